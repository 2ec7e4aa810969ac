/* SPDX-License-Identifier: Apache-2.0
 *
 * Where a picture goes: -o, --png, --part, checked before the work and written after it. */
#ifndef NPH_CLI_OUTPUT_H
#define NPH_CLI_OUTPUT_H

#include "cli/options.h"
#include "cli/session.h"
#include "nephos/film.h"

typedef struct Output {
    const char *path;       /* -o */
    const char *png;        /* NULL: none; "": beside the picture */
    double exposure_stops;
    int part, exposure_given;
    char png_path[4096];
} Output;

void output_add_options(OptionTable *table, Output *output);
NphStatus output_check(const char *command, Session *session, Output *output);
NphStatus output_write(Session *session, const Output *output, const NphFilm *film);

#endif
