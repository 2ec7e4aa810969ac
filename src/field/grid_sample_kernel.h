/* SPDX-License-Identifier: Apache-2.0
 *
 * Between sample.c and the builds of its kernel. */
#ifndef NPH_FIELD_GRID_SAMPLE_KERNEL_H
#define NPH_FIELD_GRID_SAMPLE_KERNEL_H

#include "core/cpu.h"
#include "field/lookup.h"

typedef struct GridSample {
    RGrid grid;
    double lo[3], hi[3]; /* the medium's box */
    int64_t count;
} GridSample;

/* u, v, w and the densities, in the kernel's precision. */
NPH_KERNEL_DECLARE(void, nph_grid_sample, (const GridSample *, const void *, const void *, const void *, void *));

#endif
