/* SPDX-License-Identifier: Apache-2.0
 *
 * Profiles of the atmosphere as text, in the order of [Anderson86] and its copies: a row per level, from the top down to
 * height 0, of height [km], pressure [hPa], temperature [K] and number of air molecules [1/cm3]; further columns are
 * skipped. Separators and comments as in io/text_rows.h. */
#ifndef NPH_IO_AIR_ROWS_H
#define NPH_IO_AIR_ROWS_H

#include "nephos/array.h"

/* f64 [n][2], n >= 2: height [m], rising from 0, and molecules [1/cm3], falling, above 0. NPH_BAD_INPUT with path:line. */
NphStatus nph_air_rows_read(NphContext *context, const char *path, NphArray *rows);

#endif
