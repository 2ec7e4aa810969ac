/* SPDX-License-Identifier: Apache-2.0
 *
 * Text to rows of numbers: columns separated by blanks or a comma, '#' starts a comment anywhere, empty lines are
 * skipped. What a table means is checked row by row by the format that reads it. */
#ifndef NPH_IO_TEXT_ROWS_H
#define NPH_IO_TEXT_ROWS_H

#include "nephos/array.h"

enum { NPH_TEXT_COLUMNS = 4 };

typedef struct NphTextRows {
    const char *row;                              /* as messages tell it: "an angle in degrees and a value" */
    const char *columns[NPH_TEXT_COLUMNS];        /* "angle", "value" */
    int column_count;
    int more;                                     /* 1: columns may follow, which are not read */
    /* A row that holds finite numbers, and the one before (NULL: the first). Reports and returns what is wrong. */
    NphStatus (*check)(NphContext *context, const char *path, long long line, const double *row, const double *before);
} NphTextRows;

/* f64 [n][column_count], n >= 2. NPH_BAD_INPUT with path:line; *rows is untouched on failure. */
NphStatus nph_text_rows_read(NphContext *context, const char *path, const NphTextRows *form, NphArray *rows);

#endif
