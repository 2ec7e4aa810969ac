/* SPDX-License-Identifier: Apache-2.0
 *
 * What injection and propagation know of the cells of a grid, made in a worker's scratch: the angle to the observer, what is left
 * of light on half the way through a cell, and how much fluence light brings. */
#ifndef NPH_METHOD_POP_KEPT_H
#define NPH_METHOD_POP_KEPT_H

#include "method/principal_ordinates/pop_state.h"

/* Rows of `cells` reals: light along x, y and z, then its mean cosine. */
enum { R_POP_KEEP_LIGHT, R_POP_KEEP_COSINE = 3, R_POP_KEEPS = 6 };
enum { R_POP_PLANES = 1024 }; /* at most, along the light */
enum { R_POP_RING = 8 }; /* numbers that a cell sends: to the front, back, x and y; the same times their cosine */

typedef struct RPopCells {
    const Real *density;
    Real *mu, *share, *fluence; /* [cell] */
    Real *depth;                /* [plane]: length of cells along the light, m */
    Real *keep;                 /* [R_POP_KEEPS][cell] */
    Real *scratch;              /* [3 planes][R_POP_RING][room of a plane], and the masks of a plane, twice */
    int64_t count, room;
} RPopCells;

static inline int64_t r_pop_most_cells(const NphPopChoice *choice) {
    int64_t flat = nph_pop_cells(choice->flat), radial = nph_pop_cells(choice->radial), vpl = nph_pop_cells(choice->vpl);
    radial = radial > vpl ? radial : vpl;
    return flat > radial ? flat : radial;
}

/* A plane in the ring, with room for the neighbours in y of its first and last row, and whole vectors. */
static inline int64_t r_pop_room(const int32_t n[3]) { return ((int64_t)n[0] * n[1] + 2 * (int64_t)n[0] + 64) & ~(int64_t)15; }

/* Density of the downscaled medium at a place of its space: linear between middles of cells, constant beyond the outermost. */
R_INLINE Real r_pop_density(const RPopScene *scene, const Real *medium, Real u, Real v, Real w) {
    const int32_t *n = scene->choice.mips;
    Real at[3] = {u * scene->per_level + scene->level_shift, v * scene->per_level + scene->level_shift, w * scene->per_level + scene->level_shift};
    int32_t low[3], up[3];
    Real part[3];
    for (int a = 0; a < 3; a++) {
        Real p = r_min(r_max(at[a], R(0.0)), (Real)(n[a] - 1));
        low[a] = (int32_t)p;
        up[a] = low[a] + 1 < n[a] ? 1 : 0;
        part[a] = p - (Real)low[a];
    }
    int32_t first = (low[2] * n[1] + low[1]) * n[0] + low[0], right = up[0], below = up[1] * n[0], behind = up[2] * n[0] * n[1];
    Real a = r_grid_mix(medium[first], medium[first + right], part[0]);
    Real b = r_grid_mix(medium[first + below], medium[first + below + right], part[0]);
    Real c = r_grid_mix(medium[first + behind], medium[first + behind + right], part[0]);
    Real d = r_grid_mix(medium[first + behind + below], medium[first + behind + below + right], part[0]);
    return r_grid_mix(r_grid_mix(a, b, part[1]), r_grid_mix(c, d, part[1]), part[2]);
}

/* In a fixed order whatever the vectors: 16 sums, folded. */
static inline double r_pop_sum(const Real *values, int64_t count) {
    Real sums[16] = {R(0.0)};
    double sum = 0.0;
    int64_t whole = count & ~(int64_t)15;
    for (int64_t i = 0; i < whole; i += 16)
        for (int k = 0; k < 16; k++) sums[k] += values[i + k];
    for (int64_t i = whole; i < count; i++) sums[i - whole] += values[i];
    for (int k = 0; k < 16; k++) sum += (double)sums[k];
    return sum;
}

/* Where the observer stands, scene-local, or, where `parallel`, the way to him. */
typedef struct RPopObserver {
    Real at[3];
    int parallel;
} RPopObserver;

static inline RPopObserver r_pop_observer(const RScene *local) {
    const NphSensor *sensor = &local->sensor;
    RPopObserver out = {.parallel = sensor->kind == NPH_SENSOR_ORTHOGRAPHIC || sensor->kind == NPH_SENSOR_RADIANCE};
    for (int a = 0; a < 3; a++) out.at[a] = (Real)(out.parallel ? -sensor->seen[a] : sensor->position[a] - local->origin[a]);
    return out;
}

/* Cosine between the way of the light in a cell and the way to the observer. */
R_INLINE Real r_pop_mu(const RPopObserver *observer, const Real p[3], const Real d[3]) {
    Real from = observer->parallel ? R(0.0) : R(1.0);
    Real x = observer->at[0] - from * p[0], y = observer->at[1] - from * p[1], z = observer->at[2] - from * p[2];
    Real mu = (x * d[0] + y * d[1] + z * d[2]) / r_sqrt(r_max(x * x + y * y + z * z, R(1e-30)));
    return r_min(r_max(mu, R(-1.0)), R(1.0));
}

R_OUTLINE void r_pop_row_of_mu(const RPopObserver *restrict observer, const RPopGrid *restrict grid, int32_t y, int32_t z, Real *restrict mu) {
    RPopGrid g = *grid;
    const RPopObserver o = *observer;
    g.radial = 0;
    for (int32_t x = 0; x < g.n[0]; x++) { /* vec */
        Real p[3], d[3];
        r_pop_cell(&g, x, y, z, p, d);
        mu[x] = r_pop_mu(&o, p, d);
    }
}

/* Solid angle of a cell over the mean of all. */
static inline Real r_pop_solid(const RPopGrid *grid, int32_t x, int32_t y) {
    Real u = R(2.0) * ((Real)x + R(0.5)) / (Real)grid->n[0] - R(1.0), v = R(2.0) * ((Real)y + R(0.5)) / (Real)grid->n[1] - R(1.0);
    return r_octahedron_solid(u, v, grid->n[0]) * grid->per_solid;
}

static inline void r_pop_flat_facts(const RPopScene *scene, const RPopGrid *grid, RPopCells *cells) {
    RPopObserver observer = r_pop_observer(&scene->local);
    int64_t i = 0;
    for (int32_t z = 0; z < grid->n[2]; z++) {
        cells->depth[z] = grid->edge[2];
        for (int32_t y = 0; y < grid->n[1]; y++, i += grid->n[0]) r_pop_row_of_mu(&observer, grid, y, z, cells->mu + i);
    }
    for (i = 0; i < cells->count; i++) cells->share[i] = cells->fluence[i] = R(1.0);
}

/* Shares of a virtual point light: those with its cosine, so scaled that they add up to the power of a Lambertian that has the unit along its
 * normal, pi; mean: 4 pi over the number of cells. */
static inline void r_pop_lambert(const RPopGrid *grid, RPopCells *cells) {
    int64_t plane = (int64_t)grid->n[0] * grid->n[1];
    Real sum = R(0.0);
    for (int64_t i = 0; i < plane; i++) {
        Real p[3], d[3];
        r_pop_cell(grid, (int32_t)(i % grid->n[0]), (int32_t)(i / grid->n[0]), 0, p, d);
        Real cosine = r_max(r_pop_dot(d, grid->normal), R(0.0));
        for (int32_t z = 0; z < grid->n[2]; z++) cells->share[z * plane + i] *= cosine;
        sum += cells->share[i];
    }
    Real scale = sum > R(0.0) ? R(0.25) * (Real)plane / sum : R(0.0);
    for (int64_t i = 0; i < cells->count; i++) cells->share[i] *= scale;
}

/* In print fluence is the light itself. Of a point light is the power of a cell over the mean solid angle of cells; in print all cells
 * have that, and a shell's fluence falls with the square of its radius. */
static inline void r_pop_radial_facts(const RPopScene *scene, const RPopGrid *grid, RPopCells *cells) {
    RPopObserver observer = r_pop_observer(&scene->local);
    int64_t i = 0;
    for (int32_t z = 0; z < grid->n[2]; z++) {
        Real inside = r_pop_radius(grid, (Real)z), outside = r_pop_radius(grid, (Real)(z + 1)), middle = r_pop_radius(grid, (Real)z + R(0.5));
        Real volume = (outside * outside + outside * inside + inside * inside) * R(0.33333333333333333); /* over thickness and solid angle */
        cells->depth[z] = outside - inside;
        for (int32_t y = 0; y < grid->n[1]; y++)
            for (int32_t x = 0; x < grid->n[0]; x++, i++) {
                Real p[3], d[3], solid = scene->paper ? R(1.0) : r_pop_solid(grid, x, y);
                r_pop_cell(grid, x, y, z, p, d);
                cells->mu[i] = r_pop_mu(&observer, p, d);
                cells->share[i] = solid;
                cells->fluence[i] = scene->paper ? R(1.0) / (middle * middle) : R(1.0) / (solid * volume);
            }
    }
    if (grid->lambert) r_pop_lambert(grid, cells);
}

/* The cells of a grid in the scratch of a worker; keep is filled by whoever propagates. */
static inline void r_pop_cells(const RPopScene *scene, const RPopGrid *grid, const Real *density, void *worker, RPopCells *cells) {
    int64_t most = r_pop_most_cells(&scene->choice);
    cells->count = nph_pop_cells(grid->n);
    cells->room = r_pop_room(grid->n);
    cells->density = density;
    cells->mu = worker;
    cells->share = cells->mu + most;
    cells->fluence = cells->share + most;
    cells->keep = cells->fluence + most;
    cells->depth = cells->keep + R_POP_KEEPS * most;
    cells->scratch = cells->depth + R_POP_PLANES;
    (grid->radial ? r_pop_radial_facts : r_pop_flat_facts)(scene, grid, cells);
}

#endif
