/* SPDX-License-Identifier: Apache-2.0
 *
 * pop.upsample: what was merged at the resolution of the density, which guides it [Elek14 sec. 4.4] [Kopf07]. Over the eight merged
 * cells q around p, D the density over its maximum:
 *   sum J(q) w / sum w,   w = linear interpolation's share times e^(-(D(p) - D(q))^2 / 2 s^2)
 * where D(q) is that of the downscaled medium. Nothing is looked up where there is no density in a voxel nor in those around it. */
#include "method/principal_ordinates/pop_kept.h"

void NPH_KERNEL(nph_pop_upsample)(const void *memory, const NphPopArrays *arrays, int first, int end);

typedef struct Axis {
    int32_t low, up;
    Real part;
} Axis;

R_INLINE Axis axis_of(int32_t i, int32_t from, int32_t to) {
    Axis axis;
    Real at = ((Real)i + R(0.5)) * (Real)to / (Real)from - R(0.5);
    at = r_min(r_max(at, R(0.0)), (Real)(to - 1));
    axis.low = (int32_t)at;
    axis.up = axis.low + 1 < to ? 1 : 0;
    axis.part = at - (Real)axis.low;
    return axis;
}

/* The voxel's own density, and whether there is any around it. */
static int is_seen(const RGrid *grid, int32_t i, int32_t j, int32_t k) {
    for (int32_t z = k - 1; z <= k + 1; z++)
        for (int32_t y = j - 1; y <= j + 1; y++)
            for (int32_t x = i - 1; x <= i + 1; x++)
                if (grid->values[r_grid_element(grid, x, y, z)] > 0.0f) return 1;
    return 0;
}

/* Densities of merged cells over the largest, into their fourth number; then they are 0 again. */
static Real guide_of(const RPopScene *scene, const Real *medium, int32_t x, int32_t y, int32_t z) {
    const RPopBox *box = &scene->merged;
    Real u = box->lo[0] + ((Real)x + R(0.5)) * box->edge[0], v = box->lo[1] + ((Real)y + R(0.5)) * box->edge[1];
    return r_pop_density(scene, medium, u, v, box->lo[2] + ((Real)z + R(0.5)) * box->edge[2]) / scene->density_max;
}

R_INLINE void add_cell(const Real *cell, Real weight, Real sum[NPH_POP_CELL]) {
    for (int c = 0; c < NPH_POP_CELL; c++) sum[c] += weight * cell[c];
}

static void upsample_cell(const RPopScene *scene, const NphPopArrays *arrays, const Axis axes[3], Real density, Real *out) {
    const RPopBox *box = &scene->merged;
    const Real *merged = arrays->merged;
    Real sum[NPH_POP_CELL] = {R(0.0)}, all = R(0.0);
    for (int k = 0; k < 8; k++) {
        int32_t x = axes[0].low + (k & 1) * axes[0].up, y = axes[1].low + (k >> 1 & 1) * axes[1].up, z = axes[2].low + (k >> 2) * axes[2].up;
        Real share = (k & 1 ? axes[0].part : R(1.0) - axes[0].part) * (k >> 1 & 1 ? axes[1].part : R(1.0) - axes[1].part) *
                     (k >> 2 ? axes[2].part : R(1.0) - axes[2].part);
        Real unlike = (density - guide_of(scene, arrays->medium, x, y, z)) * scene->narrow;
        Real weight = (share + R(1e-6)) * r_exp(r_max(R(-0.5) * unlike * unlike, R(-80.0)));
        all += weight;
        add_cell(merged + ((z * box->n[1] + y) * box->n[0] + x) * NPH_POP_CELL, weight, sum);
    }
    for (int c = 0; c < NPH_POP_CELL; c++) out[c] = sum[c] / all;
}

void NPH_KERNEL(nph_pop_upsample)(const void *memory, const NphPopArrays *arrays, int first, int end) {
    const RPopScene *scene = memory;
    const RPopBox *fine = &scene->fine, *merged = &scene->merged;
    const RGrid *grid = &scene->medium.grid;
    Real *out = (Real *)arrays->fine + (int64_t)first * fine->n[1] * fine->n[0] * NPH_POP_CELL;
    for (int32_t z = first; z < end; z++)
        for (int32_t y = 0; y < fine->n[1]; y++)
            for (int32_t x = 0; x < fine->n[0]; x++, out += NPH_POP_CELL) {
                for (int c = 0; c < NPH_POP_CELL; c++) out[c] = R(0.0);
                if (!is_seen(grid, x + 1, y + 1, z + 1)) continue;
                Axis axes[3] = {axis_of(x, fine->n[0], merged->n[0]), axis_of(y, fine->n[1], merged->n[1]), axis_of(z, fine->n[2], merged->n[2])};
                upsample_cell(scene, arrays, axes, (Real)grid->values[r_grid_element(grid, x + 1, y + 1, z + 1)] / scene->density_max, out);
            }
}
