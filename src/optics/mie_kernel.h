/* SPDX-License-Identifier: Apache-2.0
 *
 * Between mie_table.c and the builds of its kernel. */
#ifndef NPH_OPTICS_MIE_KERNEL_H
#define NPH_OPTICS_MIE_KERNEL_H

#include <stdint.h>

#include "core/cpu.h"

enum { NPH_MIE_LANES = 64, NPH_MIE_UNROLL = 8 };

/* One order: c (a + b) and c (a - b), c = (2n + 1) / (n (n + 1)); n; (n + 1) / n. Past the last order all but n are 0. */
typedef struct NphMieOrder {
    double plus_re, plus_im, minus_re, minus_im, n, ratio;
} NphMieOrder;

typedef struct NphMieTile {
    const NphMieOrder *orders;
    int count;              /* of orders: a multiple of NPH_MIE_UNROLL */
    double weight;
    const double *distance; /* 1 - |cos|, of NPH_MIE_LANES angles */
    double *sum;            /* grows by weight (|S1|^2 + |S2|^2) / 2 */
} NphMieTile;

NPH_KERNEL_DECLARE(void, nph_mie_tile, (const NphMieTile *));

#endif
