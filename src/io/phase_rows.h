/* SPDX-License-Identifier: Apache-2.0
 *
 * Tables of a phase function as text: a row per angle, angle in degrees and value, separated by blanks or a comma. '#'
 * starts a comment anywhere, empty lines are skipped. */
#ifndef NPH_IO_PHASE_ROWS_H
#define NPH_IO_PHASE_ROWS_H

#include "nephos/array.h"

/* f64 [n][2], n >= 2: angles rise, from 0 to 180 at most; values are finite and at least 0. NPH_BAD_INPUT with
 * path:line. */
NphStatus nph_phase_rows_read(NphContext *context, const char *path, NphArray *rows);

#endif
