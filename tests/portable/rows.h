/* SPDX-License-Identifier: Apache-2.0
 *
 * The rows of reference/vectors. */
#ifndef NPH_TESTS_ROWS_H
#define NPH_TESTS_ROWS_H

#include <stdint.h>

#include "functions.h"

typedef struct Row {
    int function; /* NphFunction */
    uint32_t in[NPH_WORDS_IN], out[NPH_WORDS_OUT];
} Row;

enum { NPH_ROWS_MOST = 4096 };

/* All rows of the three files, a function's one after another; the number of them. */
int nph_rows_read(Row rows[NPH_ROWS_MOST]);

const char *nph_rows_function(int function);
int nph_rows_results(int function); /* how many words it gives */

/* got as it should be compared: every NaN of a result that is a float becomes the one of the files. */
uint32_t nph_rows_comparable(int function, int result, uint32_t got);

#endif
