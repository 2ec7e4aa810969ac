/* SPDX-License-Identifier: Apache-2.0
 *
 * A place where light of the media begins, in scene-local space, and what it is worth. Which cell is decided in f64 in
 * both precisions, by 53 random bits. */
#ifndef NPH_TRANSPORT_EMISSION_SOURCE_LOOKUP_H
#define NPH_TRANSPORT_EMISSION_SOURCE_LOOKUP_H

#include "transport/emission_lookup.h"
#include "transport/emission_source.h"

/* The cell that u in [0, 1) falls into. */
static inline int64_t r_emission_cell(const NphEmissionSources *sources, double u) {
    int64_t lo = 0, hi = sources->count;
    while (hi - lo > 1) {
        int64_t middle = lo + (hi - lo) / 2;
        if (sources->cdf[middle] <= u) lo = middle;
        else hi = middle;
    }
    return lo;
}

/* sources->count > 0. value: that emitter's j over the density of p, W/sr; its mean over all p is the integral of j. Of
 * what lies in several emitters each is drawn by itself. */
static inline void r_emission_sample(const RScene *scene, const NphEmissionSources *sources, NphWords words, NphWords more,
                                     Real p[3], Real value[3]) {
    double pick = ((double)(words.w0 >> 5) * 67108864.0 + (double)(words.w1 >> 6)) * 0x1p-53;
    const NphEmissionCell *cell = &sources->cells[r_emission_cell(sources, pick)];
    const REmitter *emitter = &scene->emitters[cell->emitter];
    const double *map = sources->world_from_space[cell->emitter];
    double part[3] = {nph_uniform(words.w2), nph_uniform(words.w3), nph_uniform(more.w0)}, u[3];
    Real density = R(1.0), inverse = (Real)(1.0 / cell->density);
    for (int a = 0; a < 3; a++) u[a] = cell->lo[a] + part[a] * (cell->hi[a] - cell->lo[a]);
    for (int a = 0; a < 3; a++)
        p[a] = (Real)(map[4 * a] * u[0] + map[4 * a + 1] * u[1] + map[4 * a + 2] * u[2] + (map[4 * a + 3] - scene->origin[a]));
    for (int c = 0; c < 3; c++) {
        if (emitter->grids > 0 && (c == 0 || emitter->grids > 1))
            density = r_grid_value(&emitter->grid[c], (Real)u[0], (Real)u[1], (Real)u[2]);
        value[c] = emitter->value[c] * density * inverse;
    }
}

#endif
