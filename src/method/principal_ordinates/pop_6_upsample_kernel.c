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

/* Whether there is density in the voxel or in those around it. A cell of the majorant tells how many cells around it are empty. */
static int is_seen(const RPopScene *scene, int32_t i, int32_t j, int32_t k) {
    const RGrid *grid = &scene->medium.grid;
    const int32_t *n = scene->medium.majorant_n;
    if (grid->values[r_grid_element(grid, i, j, k)] > 0.0f) return 1;
    float around = -scene->medium.majorant[((k >> 2) * n[1] + (j >> 2)) * n[0] + (i >> 2)];
    if (around > 1.5f) return 0;
    for (int32_t z = k - 1; z <= k + 1; z++)
        for (int32_t y = j - 1; y <= j + 1; y++)
            for (int32_t x = i - 1; x <= i + 1; x++)
                if (grid->values[r_grid_element(grid, x, y, z)] > 0.0f) return 1;
    return 0;
}

/* Weights of the eight cells. */
R_OUTLINE void weigh(const Real *restrict share, const Real *restrict guide, Real density, Real narrow, Real *restrict weight) {
    for (int k = 0; k < 8; k++) { /* vec */
        Real unlike = (density - guide[k]) * narrow;
        weight[k] = (share[k] + R(1e-6)) * r_exp(r_max(R(-0.5) * unlike * unlike, R(-80.0)));
    }
}

static void upsample_cell(const RPopScene *scene, const Real *merged, const Axis axes[3], Real density, Real *out) {
    const RPopBox *box = &scene->merged;
    const Real *cell[8];
    Real share[8], guide[8], weight[8], all = R(0.0), sum[NPH_POP_CELL] = {R(0.0)};
    for (int k = 0; k < 8; k++) {
        int32_t x = axes[0].low + (k & 1) * axes[0].up, y = axes[1].low + (k >> 1 & 1) * axes[1].up, z = axes[2].low + (k >> 2) * axes[2].up;
        cell[k] = merged + ((z * box->n[1] + y) * box->n[0] + x) * NPH_POP_CELL;
        guide[k] = cell[k][3];
        share[k] = (k & 1 ? axes[0].part : R(1.0) - axes[0].part) * (k >> 1 & 1 ? axes[1].part : R(1.0) - axes[1].part) *
                   (k >> 2 ? axes[2].part : R(1.0) - axes[2].part);
    }
    weigh(share, guide, density, scene->narrow, weight);
    for (int k = 0; k < 8; k++) {
        all += weight[k];
        for (int c = 0; c < NPH_POP_CELL; c++) sum[c] += weight[k] * cell[k][c];
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
                if (!is_seen(scene, x + 1, y + 1, z + 1)) continue;
                Axis axes[3] = {axis_of(x, fine->n[0], merged->n[0]), axis_of(y, fine->n[1], merged->n[1]), axis_of(z, fine->n[2], merged->n[2])};
                upsample_cell(scene, arrays->merged, axes, (Real)grid->values[r_grid_element(grid, x + 1, y + 1, z + 1)] / scene->density_max, out);
            }
}
