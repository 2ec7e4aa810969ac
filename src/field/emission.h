/* SPDX-License-Identifier: Apache-2.0
 *
 * Light that a medium gives off: j [W/m3/sr], the radiance it adds per metre of a ray, the same in all directions.
 *     constant   j_c = value[c] within the medium's box or layer
 *     density    j_c = value[c] times the medium's density
 *     grid       j_c = value[c] times the grid: one for all channels, or one a channel on the same lattice
 * Grids are looked up like densities, so j is what is interpolated, and end where their box does, which need not be the
 * density's. */
#ifndef NPH_FIELD_EMISSION_H
#define NPH_FIELD_EMISSION_H

#include "field/grid.h"

typedef enum NphEmissionKind {
    NPH_EMISSION_NONE, NPH_EMISSION_CONSTANT, NPH_EMISSION_DENSITY, NPH_EMISSION_GRID
} NphEmissionKind;

typedef struct NphEmission {
    NphEmissionKind kind;
    double value[3];
    int grid_count;             /* of kind grid: 1, or one a channel */
    NphGrid *grids;
    double world_from_grid[12]; /* lattice space of the grids to the world; of density the medium's own */
    NphMajorant bound;          /* of kind grid and density: of the largest channel's j, as NphGrid.majorant is */
    double depth;               /* integral of bound [W/m2/sr] along lines of the lattice, in the mean over what they
                                   bring: sum of squares over sum, of all cells' rows along the three axes */
} NphEmission;

/* With kind, value, grids and world_from_grid in place; density: of kind density. Sets bound and depth; a bound beyond
 * NPH_DENSITY_MAX is refused. */
NphStatus nph_emission_finish(NphContext *context, const NphGrid *density, const char *what, NphEmission *emission);

/* The grid of channel c; density: the medium's own. */
static inline const NphGrid *nph_emission_grid(const NphEmission *emission, const NphGrid *density, int c) {
    if (emission->kind == NPH_EMISSION_DENSITY) return density;
    return &emission->grids[emission->grid_count == 1 ? 0 : c];
}

/* Bytes that it holds besides the density. */
uint64_t nph_emission_bytes(const NphEmission *emission);

void nph_emission_free(NphContext *context, NphEmission *emission);

#endif
