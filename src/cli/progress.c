/* SPDX-License-Identifier: Apache-2.0
 *
 * See progress.h. */
#include "cli/progress.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "core/pool.h"

enum { LINE_SECONDS = 10, BAR = 30 };

void progress_open(Progress *progress, int quiet) {
    memset(progress, 0, sizeof *progress);
    pthread_mutex_init(&progress->lock, NULL);
    progress->terminal = isatty(STDERR_FILENO);
    progress->quiet = quiet;
    progress->line_time = nph_seconds();
}

static void clear_bar(Progress *progress) {
    if (progress->width) fprintf(stderr, "\r%*s\r", progress->width, "");
    progress->width = 0;
}

void progress_close(Progress *progress) {
    clear_bar(progress);
    pthread_mutex_destroy(&progress->lock);
}

void format_duration(double seconds, char text[32]) {
    double whole = seconds < 0 ? 0 : seconds < 1e12 ? seconds + 0.5 : 1e12;
    long long s = (long long)whole;
    if (s < 3600) snprintf(text, 32, "%lld:%02lld", s / 60, s % 60);
    else if (s < 2 * 86400) snprintf(text, 32, "%lld:%02lld:%02lld", s / 3600, s / 60 % 60, s % 60);
    else snprintf(text, 32, "%lld days", s / 86400);
}

static void draw_bar(Progress *progress, const char *task, double part, const char *left) {
    char bar[BAR + 1];
    int filled = (int)(part * BAR);
    for (int i = 0; i < BAR; i++) bar[i] = i < filled ? '#' : '.';
    bar[BAR] = 0;
    char line[200];
    int width = snprintf(line, sizeof line, "%.40s [%s] %3.0f%% %s", task, bar, 100 * part, left);
    fprintf(stderr, "\r%-*s", progress->width, line);
    progress->width = width;
}

void progress_show(Progress *progress, const char *task, double done, double total, double seconds_left) {
    if (progress->quiet) return;
    char duration[32], left[64] = "";
    double part = total > 0 ? done / total : 0;
    part = part < 0 ? 0 : part > 1 ? 1 : part;
    if (seconds_left >= 0) {
        format_duration(seconds_left, duration);
        snprintf(left, sizeof left, "%s left", duration);
    }
    pthread_mutex_lock(&progress->lock);
    if (progress->terminal) {
        if (done >= total) clear_bar(progress);
        else draw_bar(progress, task, part, left);
    } else if (nph_seconds() - progress->line_time >= LINE_SECONDS) {
        progress->line_time = nph_seconds();
        fprintf(stderr, "nephos: %s %.0f%%%s%s\n", task, 100 * part, *left ? ", " : "", left);
    }
    fflush(stderr);
    pthread_mutex_unlock(&progress->lock);
}

void progress_message(Progress *progress, NphMessageLevel level, const char *text) {
    static const char *const words[] = {"error: ", "warning: ", ""};
    if (progress->quiet && level == NPH_MESSAGE_INFO) return;
    pthread_mutex_lock(&progress->lock);
    clear_bar(progress);
    fprintf(stderr, "nephos: %s%s\n", words[level], text);
    fflush(stderr);
    pthread_mutex_unlock(&progress->lock);
}
