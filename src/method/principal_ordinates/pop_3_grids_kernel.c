/* SPDX-License-Identifier: Apache-2.0
 *
 * pop.grids and pop.inject [Elek14 sec. 4.1]. A cell's density is that of the downscaled medium in its middle, times the part of the
 * cell that the medium's box covers. Then one sweep along the light, for every unit of irradiance that enters a grid:
 *   corrected  light   a T (1 - e^(-s_t d)): what first scatters in the cell, T the transmittance to its near side
 *              cosine  c g, c that of the unscattered light: it has been scattered once
 *              seen    the unscattered beam, T (1 - e^(-s_t d)) / (s_t d) f_hg(mu, c g); and the cell's own light, which travels half a cell
 *                      in it in the mean: 1/2 light f_hg(mu, cosine g)
 *   in print   light T to the middle, cosine c, nothing seen: all cells are sent on, so the beam counts once for every cell crossed
 * T in print is read as that of the extinction. Of a point a unit of intensity enters, and a cell has its share of the sphere. */
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

R_OUTLINE void row_of_density(const RPopScene *restrict scene, const RPopGrid *restrict grid, const Real *restrict half, const Real *restrict medium,
                              const int32_t *restrict row, Real *restrict out) {
    const int32_t y = row[0], z = row[1];
    const Real h0 = half[0], h1 = half[1], h2 = half[2];
    const Real *m = scene->medium.from_local, *lo = scene->medium.lo, *hi = scene->medium.hi;
    const RPopGrid g = *grid;
    for (int32_t x = 0; x < g.n[0]; x++) { /* vec */
        Real p[3], d[3];
        r_pop_cell(&g, x, y, z, p, d);
        Real u = m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3], v = m[4] * p[0] + m[5] * p[1] + m[6] * p[2] + m[7];
        Real w = m[8] * p[0] + m[9] * p[1] + m[10] * p[2] + m[11];
        Real part = covered(u, h0, lo[0], hi[0]) * covered(v, h1, lo[1], hi[1]) * covered(w, h2, lo[2], hi[2]);
        out[x] = part * r_pop_density(scene, medium, u, v, w);
    }
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
        for (int32_t y = 0; y < grid.n[1]; y++, out += grid.n[0]) row_of_density(scene, &grid, half, arrays->medium, (int32_t[]){y, z}, out);
    }
}

/* What the sweep does with a plane. */
typedef struct Sweep {
    Real sigma_t, albedo, cosine, g, own;
    int paper, count;
} Sweep;

R_OUTLINE void sweep_plane(const Sweep *restrict sweep, const RPopCells *restrict cells, int64_t first, Real *restrict T, Real *restrict light,
                           Real *restrict seen) {
    const Sweep s = *sweep;
    const Real *density = cells->density + first, *mu = cells->mu + first, *share = cells->share + first, *fluence = cells->fluence + first;
    const Real depth = cells->depth[first / s.count], once = s.cosine * s.g, twice = s.cosine * s.g * s.g;
    for (int i = 0; i < s.count; i++) { /* vec */
        Real tau = s.sigma_t * density[i] * depth, part = -r_expm1(-tau);
        Real mean = tau > R(1e-3) ? part / r_max(tau, R(1e-30)) : R(1.0) - R(0.5) * tau;
        Real enters = T[i] * share[i], scattered = enters * s.albedo * part;
        Real middle = enters * r_exp(R(-0.5) * tau);
        light[i] = s.paper ? middle : scattered;
        seen[i] = s.paper ? R(0.0) : fluence[i] * (enters * mean * r_pop_lobe(once, mu[i]) + s.own * scattered * r_pop_lobe(twice, mu[i]));
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
        Sweep sweep = {scene->sigma_t[c], scene->sigma_t[c] > R(0.0) ? scene->sigma_s[c] / scene->sigma_t[c] : R(0.0), row[NPH_POP_COSINE], scene->g, R(0.5),
                       scene->paper, (int)plane};
        for (int64_t i = 0; i < plane; i++) T[i] = r_exp(-sweep.sigma_t * cells.density[i] * grid.core);
        for (int32_t z = 0; z < grid.n[2]; z++) sweep_plane(&sweep, &cells, z * plane, T, light + z * plane, seen + z * plane);
        for (int64_t i = 0; i < plane && !scene->paper; i++) /* what scatters before the innermost shell */
            light[i] += sweep.albedo * cells.share[i] * -r_expm1(-sweep.sigma_t * cells.density[i] * grid.core);
        Real begins = scene->paper ? row[NPH_POP_COSINE] : row[NPH_POP_COSINE] * scene->g;
        for (int64_t i = 0; i < count; i++) cosine[i] = begins;
        power[NPH_POP_INJECTED] = power[NPH_POP_LEFT] = r_pop_sum(light, count);
    }
}
