/* SPDX-License-Identifier: Apache-2.0
 *
 * pop.grids and pop.inject [Elek14 sec. 4.1]. A cell's density is that of the downscaled medium in its middle, times the part of the
 * cell that the medium's box covers. Then one sweep along the light, for every unit of irradiance that enters a grid:
 *   corrected  light   a T (1 - e^(-s_t d)): what first scatters in the cell, T the transmittance to its near side
 *              cosine  c g, c that of the unscattered light: it has been scattered once
 *              seen    the unscattered beam, T (1 - e^(-s_t d)) / (s_t d) f_hg(mu, c g)
 *   in print   light T to the middle, cosine c, nothing seen: all cells are sent on, so the beam counts once for every cell crossed
 * T in print is read as that of the extinction. Of a point a unit of intensity enters, and a cell has its share of the sphere. Where there are
 * surfaces light and seen are those of the lit part of a cell. */
#include "method/principal_ordinates/pop_kept.h"

void NPH_KERNEL(nph_pop_grid)(const void *memory, const NphPopArrays *arrays, int number);
void NPH_KERNEL(nph_pop_inject)(const void *memory, const NphPopArrays *arrays, int number, void *worker);

/* How much of [at - half, at + half] lies in [lo, hi]. */
R_INLINE Real covered(Real at, Real half, Real lo, Real hi) {
    Real below = r_max(at - half, lo), above = r_min(at + half, hi);
    return r_max(above - below, R(0.0)) / (R(2.0) * half);
}

/* Half of what a cell takes of each axis of the medium. */
static void reach_of(const RPopScene *scene, Real step[3][3], Real half[3]) {
    const Real *m = scene->medium.from_local;
    for (int a = 0; a < 3; a++) {
        half[a] = R(0.0);
        for (int b = 0; b < 3; b++) half[a] += R(0.5) * r_abs(m[4 * a] * step[b][0] + m[4 * a + 1] * step[b][1] + m[4 * a + 2] * step[b][2]);
        half[a] = r_max(half[a], R(1e-30));
    }
}

/* A cell of row `row`: y, z. */
R_INLINE Real density_of(const RPopScene *scene, const RPopGrid *grid, const Real *half, const Real *medium, int32_t x, const int32_t *row) {
    const Real *m = scene->medium.from_local, *lo = scene->medium.lo, *hi = scene->medium.hi;
    Real p[3], d[3];
    r_pop_cell(grid, x, row[0], row[1], p, d);
    Real u = m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3], v = m[4] * p[0] + m[5] * p[1] + m[6] * p[2] + m[7];
    Real w = m[8] * p[0] + m[9] * p[1] + m[10] * p[2] + m[11];
    Real part = covered(u, half[0], lo[0], hi[0]) * covered(v, half[1], lo[1], hi[1]) * covered(w, half[2], lo[2], hi[2]);
    return part * r_pop_density(scene, medium, u, v, w);
}

R_OUTLINE void flat_row(const RPopScene *restrict scene, const RPopGrid *restrict grid, const Real *restrict half, const Real *restrict medium,
                        const int32_t *restrict row, Real *restrict out) {
    RPopGrid g = *grid;
    g.radial = 0;
    for (int32_t x = 0; x < g.n[0]; x++) out[x] = density_of(scene, &g, half, medium, x, row); /* vec */
}

R_OUTLINE void radial_row(const RPopScene *restrict scene, const RPopGrid *restrict grid, const Real *restrict half, const Real *restrict medium,
                          const int32_t *restrict row, Real *restrict out) {
    RPopGrid g = *grid;
    g.radial = 1;
    for (int32_t x = 0; x < g.n[0]; x++) out[x] = density_of(scene, &g, half, medium, x, row);
}

void NPH_KERNEL(nph_pop_grid)(const void *memory, const NphPopArrays *arrays, int number) {
    const RPopScene *scene = memory;
    const Real *row = (const Real *)arrays->ordinate + (int64_t)number * NPH_POP_ROW;
    RPopGrid grid = r_pop_grid(scene, row, number);
    Real *out = (Real *)arrays->density + nph_pop_first(&scene->choice, number, 1), half[3], step[3][3];
    for (int32_t z = 0; z < grid.n[2]; z++) {
        Real inside = grid.radial ? r_pop_radius(&grid, (Real)z) : R(0.0);
        Real thick = grid.radial ? r_pop_radius(&grid, (Real)(z + 1)) - inside : R(0.0); /* shells: a cube of that edge */
        for (int b = 0; b < 3; b++)
            for (int a = 0; a < 3; a++) step[b][a] = grid.radial ? (a == b ? thick : R(0.0)) : grid.axis[b][a] * grid.edge[b];
        reach_of(scene, step, half);
        for (int32_t y = 0; y < grid.n[1]; y++, out += grid.n[0]) 
            (grid.radial ? radial_row : flat_row)(scene, &grid, half, arrays->medium, (int32_t[]){y, z}, out);
    }
}

/* What the sweep does with a plane; facts: rows of mu, share and fluence are `apart`. */
typedef struct Sweep {
    Real sigma_t, albedo, cosine, g, depth;
    int paper, count;
    int64_t apart;
} Sweep;

/* What surfaces leave of it. */
R_OUTLINE void shade_plane(const Real *restrict lit, int count, Real *restrict light, Real *restrict seen) {
    for (int i = 0; i < count; i++) { /* vec */
        light[i] *= lit[i];
        seen[i] *= lit[i];
    }
}

R_OUTLINE void sweep_plane(const Sweep *restrict sweep, const Real *restrict density, const Real *restrict facts, Real *restrict T, Real *restrict light,
                           Real *restrict seen) {
    const Sweep s = *sweep;
    const Real *mu = facts, *share = facts + s.apart, *fluence = facts + 2 * s.apart;
    const Real depth = s.depth, once = s.cosine * s.g, keeps = s.paper ? R(0.0) : R(1.0);
    for (int i = 0; i < s.count; i++) { /* vec */
        Real tau = s.sigma_t * density[i] * depth, part = -r_expm1(-tau);
        Real mean = tau > R(1e-3) ? part / r_max(tau, R(1e-30)) : R(1.0) - R(0.5) * tau;
        Real enters = T[i] * share[i], scattered = enters * s.albedo * part;
        Real middle = enters * r_exp(R(-0.5) * tau);
        light[i] = keeps * scattered + (R(1.0) - keeps) * middle;
        seen[i] = keeps * fluence[i] * enters * mean * r_pop_lobe(once, mu[i]);
        T[i] *= R(1.0) - part;
    }
}

void NPH_KERNEL(nph_pop_inject)(const void *memory, const NphPopArrays *arrays, int number, void *worker) {
    const RPopScene *scene = memory;
    const NphPopChoice *choice = &scene->choice;
    const Real *row = (const Real *)arrays->ordinate + (int64_t)number * NPH_POP_ROW;
    RPopGrid grid = r_pop_grid(scene, row, number);
    RPopCells cells;
    int64_t count = nph_pop_cells(grid.n), first = nph_pop_first(choice, number, choice->channels), plane = (int64_t)grid.n[0] * grid.n[1];
    r_pop_cells(scene, &grid, (const Real *)arrays->density + nph_pop_first(choice, number, 1), worker, &cells);
    for (int c = 0; c < choice->channels; c++) {
        Real *light = (Real *)arrays->light + first + c * count, *cosine = (Real *)arrays->cosine + first + c * count;
        Real *seen = (Real *)arrays->seen + first + c * count, *T = cells.scratch;
        double *power = arrays->power + ((int64_t)number * choice->channels + c) * NPH_POP_POWERS;
        Sweep sweep = {.sigma_t = scene->sigma_t[c], .cosine = row[NPH_POP_COSINE], .g = scene->g, .paper = scene->paper, .count = (int)plane,
                       .apart = cells.share - cells.mu};
        sweep.albedo = scene->sigma_t[c] > R(0.0) ? scene->sigma_s[c] / scene->sigma_t[c] : R(0.0);
        for (int64_t i = 0; i < plane; i++) T[i] = r_exp(-sweep.sigma_t * cells.density[i] * grid.core);
        for (int32_t z = 0; z < grid.n[2]; z++) {
            sweep.depth = cells.depth[z];
            sweep_plane(&sweep, cells.density + z * plane, cells.mu + z * plane, T, light + z * plane, seen + z * plane);
        }
        for (int64_t i = 0; i < plane && !scene->paper; i++) /* what scatters before the innermost shell */
            light[i] += sweep.albedo * cells.share[i] * -r_expm1(-sweep.sigma_t * cells.density[i] * grid.core);
        if (choice->shadows > 0) shade_plane((const Real *)arrays->lit + nph_pop_first(choice, number, 1), (int)count, light, seen);
        Real begins = scene->paper ? row[NPH_POP_COSINE] : row[NPH_POP_COSINE] * scene->g;
        for (int64_t i = 0; i < count; i++) cosine[i] = begins;
        power[NPH_POP_INJECTED] = power[NPH_POP_LEFT] = r_pop_sum(light, count);
    }
}
