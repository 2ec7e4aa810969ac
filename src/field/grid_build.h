/* SPDX-License-Identifier: Apache-2.0
 *
 * The steps that every builder of grids shares: lay out, mark bricks with a code, number and allocate them, fill the own
 * ones, finish. Codes stand in grid->brick_index until nph_grid_number turns them into brick numbers. */
#ifndef NPH_FIELD_GRID_BUILD_H
#define NPH_FIELD_GRID_BUILD_H

#include <string.h>

#include "field/grid.h"

/* Code of a brick: 0 for zeros, the bits of a float > 0 where all 9^3 samples are that float, or this. */
enum { NPH_BRICK_OWN = -1 };
enum { NPH_BRICK_SAMPLES = NPH_BRICK_EDGE * NPH_BRICK_EDGE * NPH_BRICK_EDGE };

static inline int32_t nph_brick_code(float value) {
    int32_t code;
    memcpy(&code, &value, sizeof code);
    return code;
}

/* A density that a grid may hold; false for NaN. */
static inline int nph_density_ok(double value) { return value >= 0 && value <= NPH_DENSITY_MAX; }

/* Element i as it is in the file; of the wide integers the rounded value. */
double nph_array_element(const NphArray *array, int64_t i);

/* Checks samples[] (per axis, without padding, >= 1) against the limits; sets n, bricks, the box of the centring and a
 * brick_index of zeros. */
NphStatus nph_grid_layout(NphContext *context, const int64_t samples[3], NphCentring centring, const char *what,
                          NphGrid *grid);

/* Replaces codes by numbers: 1 .. *shared_end - 1 for the constant bricks, which are filled, and from *shared_end on
 * for the own ones, in the order of the table, left at zero for the builder to fill. Allocates values. */
NphStatus nph_grid_number(NphContext *context, const char *what, NphGrid *grid, int32_t *shared_end);

/* With values and world_from_lattice in place: checks the map, sets min, max, sum, active and the majorant. */
NphStatus nph_grid_finish(NphContext *context, const char *what, NphGrid *grid);

NphStatus nph_grid_measure(NphContext *context, const char *what, NphGrid *grid);
NphStatus nph_majorant_build(NphContext *context, const NphGrid *grid, const char *what, NphMajorant *majorant);

#endif
