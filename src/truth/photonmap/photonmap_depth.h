/* SPDX-License-Identifier: Apache-2.0
 *
 * Optical depths along a ray without chance. Cells of the majorant grid are walked as in flights; within one voxel a
 * trilinear density is a polynomial of third degree along the ray, so two Gauss points integrate it exactly; a nearest
 * lookup is constant between planes half a sample off. */
#ifndef NPH_TRUTH_PHOTONMAP_DEPTH_H
#define NPH_TRUTH_PHOTONMAP_DEPTH_H

#include "transport/flight_lookup.h"

/* The density at t of the span, looked up in a cell. */
static inline Real r_depth_density(const RMedium *medium, const RSpan *span, const int32_t cell[3], Real t) {
    Real u[3];
    for (int a = 0; a < 3; a++) u[a] = r_within(span->o[a] + t * span->d[a], cell[a], medium->lo[a], medium->hi[a]);
    return r_grid_value(&medium->grid, u[0], u[1], u[2]);
}

/* The integral of the density over [from, to] within one cell, voxel by voxel. */
static inline Real r_cell_depth(const RMedium *medium, const RSpan *span, const int32_t cell[3], Real from, Real to) {
    Real shift = (Real)medium->grid.shift, next[3], depth = R(0.0);
    int32_t voxel[3], way[3];
    for (int a = 0; a < 3; a++) {
        Real u = span->o[a] + from * span->d[a] + shift, first = R(4.0) * (Real)cell[a];
        way[a] = span->inv[a] > R(0.0) ? 1 : -1;
        voxel[a] = (int32_t)r_floor(r_clamp(u, first, first + R(4.0)));
        next[a] = ((Real)(voxel[a] + (way[a] > 0)) - shift - span->o[a]) * span->inv[a];
    }
    for (Real t = from; t < to;) {
        int axis = next[0] < next[1] ? 0 : 1;
        axis = next[2] < next[axis] ? 2 : axis;
        Real end = next[axis] < to ? next[axis] : to, half = R(0.5) * (end - t), middle = t + half;
        Real off = half * R(0.57735026918962576);
        if (half > R(0.0))
            depth += half * (r_depth_density(medium, span, cell, middle - off) +
                             r_depth_density(medium, span, cell, middle + off));
        if (!(next[axis] < to)) break;
        t = end > t ? end : t;
        voxel[axis] += way[axis];
        next[axis] = ((Real)(voxel[axis] + (way[axis] > 0)) - shift - span->o[axis]) * span->inv[axis];
    }
    return depth;
}

/* The integral of the density over [from, to] of a ray whose part in the medium is `span`; a box has density 1. */
static inline Real r_depth(const RMedium *medium, const RSpan *whole, Real from, Real to) {
    RSpan span = *whole;
    span.near = from > span.near ? from : span.near;
    span.far = to < span.far ? to : span.far;
    if (!span.inside || !(span.near < span.far)) return R(0.0);
    if (medium->shape != NPH_SHAPE_GRID) return span.far - span.near;
    RWalk walk = r_walk_enter(medium->majorant_n, &span, R(1.0));
    Real depth = R(0.0);
    while (walk.state == R_WALKING) { /* sigma 0: nothing stops the walk but the end */
        int32_t cell[3] = {walk.c0, walk.c1, walk.c2};
        float bound = medium->majorant[r_walk_cell(medium->majorant_n, cell[0], cell[1], cell[2])];
        Real start = walk.t;
        walk = r_walk_step(medium->majorant_n, &span, walk, bound, R(0.0));
        if (bound > 0.0f && walk.t > start) depth += r_cell_depth(medium, &span, cell, start, walk.t);
    }
    return depth;
}

/* Extinction of the densest channel of each medium at a place, summed. */
static inline Real r_extinction_at(const RScene *scene, const Real p[3]) {
    Real sum = R(0.0);
    for (int m = 0; m < scene->medium_count; m++) {
        const RMedium *medium = &scene->media[m];
        Real u[3];
        int inside = 1;
        for (int a = 0; a < 3; a++) {
            const Real *row = medium->from_local + 4 * a;
            u[a] = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
            inside &= u[a] >= medium->lo[a] && u[a] <= medium->hi[a];
        }
        if (!inside) continue;
        Real density = medium->shape == NPH_SHAPE_GRID ? r_grid_value(&medium->grid, u[0], u[1], u[2]) : R(1.0);
        sum += density * medium->sigma_max;
    }
    return sum;
}

#endif
