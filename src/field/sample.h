/* SPDX-License-Identifier: Apache-2.0
 *
 * Densities at many positions: the lookup of the kernels (lookup.h) as a call, for tests, `nephos info` and stages that
 * have positions in an array. Every vector level gives the same bits. */
#ifndef NPH_FIELD_SAMPLE_H
#define NPH_FIELD_SAMPLE_H

#include "field/grid.h"
#include "field/lookup.h"

/* The grid as kernels see it; points into the grid. */
void nph_grid_view(const NphGrid *grid, RGrid *view);

/* positions[axis]: count coordinates in lattice space, float for precision 32, double for 64; so is out. The density
 * is 0 outside the grid's box (and at NaN). */
NphStatus nph_grid_sample(NphContext *context, const NphGrid *grid, int precision, int64_t count,
                          const void *const positions[3], void *out);

#endif
