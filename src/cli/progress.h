/* SPDX-License-Identifier: Apache-2.0
 *
 * Progress on stderr: a bar with the time left on a terminal, a line every ten seconds in a log. Messages pass through
 * here too, so that they do not end up inside the bar. */
#ifndef NPH_CLI_PROGRESS_H
#define NPH_CLI_PROGRESS_H

#include <pthread.h>

#include "nephos/context.h"

typedef struct Progress {
    pthread_mutex_t lock;
    int terminal, quiet;
    int width;         /* characters of the bar on the screen; 0: none */
    double line_time;  /* when the last line of a log was written */
} Progress;

void progress_open(Progress *progress, int quiet);
void progress_close(Progress *progress);
void progress_show(Progress *progress, const char *task, double done, double total, double seconds_left);
void progress_message(Progress *progress, NphMessageLevel level, const char *text);

/* "1:05", "2:10:00", "3 days". */
void format_duration(double seconds, char text[32]);

#endif
