/* SPDX-License-Identifier: Apache-2.0
 *
 * tpm.upsample: the coarse cache at the resolution of the density, which guides it [Elek12 sec. 4.3]. At p, over the cells q of a
 * neighbourhood, with d = |p - q|, r the distance from the neighbourhood's middle to its border, D the density over its maximum:
 *   fluence     sum I(q) w / sum w,  w = f_exp(d | tau, r) max(1 - |D(p) - D(q)|, 0)
 *   f_exp       tau e^(-tau d) / (1 - e^(-tau r)), less its value at r, over what keeps its integral from 0 to r at 1:
 *               (tau / (1 - e^(-tau r))) (e^(-tau d) - e^(-tau r)) / (1 - r tau e^(-tau r) / (1 - e^(-tau r))) -> 2 (r - d) / r^2
 *   tau         s_s (D(p) + D(q)) / 2; in print the difference
 *   cosine      sum I_g(q) e^(-(1-g) delta) w / sum w, delta the depth of p less that of q: after delta events in the mean the
 *               cosine falls by that (docs/errata.md); in print g^delta, which stands in the denominator too and cancels there
 * The exponentials of all cells are taken relative to the largest: however dense the medium, one of them is 1. Where nothing
 * weighs anything, I is interpolated. `gaussian` is the joint bilateral filter that the paper compares with [Kopf07].
 *
 * A block is one coarse cell: all the fine ones in it have the same neighbourhood. The guide tells the density of every fine cell over
 * its maximum, and where there is none in a cell nor in those around it: nothing will be looked up there, and it stays 0. */
#include "method/temporal_photons/tpm_state.h"

void NPH_KERNEL(nph_tpm_guide)(const void *memory, int first, int end, void *guide);
void NPH_KERNEL(nph_tpm_guide_seen)(const void *memory, const void *guide, int first, int end, uint8_t *seen);
void NPH_KERNEL(nph_tpm_upsample)(const void *memory, const void *guide, const uint8_t *seen, const void *coarse, int64_t first, int64_t end, void *fine);

enum { NEAR = 5 * 5 * 5, CELLS = 128 };

/* A cell of the neighbourhood: its values, middle [m from the low corner], and density over the largest. */
typedef struct Neighbour {
    Real value[NPH_TPM_FIELDS], at[3], density;
} Neighbour;

enum { TOGETHER = 9 }; /* neighbours that are added at once: their weights stay near, and a sum is read and written once for all */

/* Fine cells of a block: place [m from the low corner], density, mean depth where they are; weights of some neighbours, those of the
 * cosine too; and the sums over all. */
typedef struct Block {
    Real at[3][CELLS], density[CELLS], depth[CELLS], least[CELLS], scale[CELLS];
    Real weight[TOGETHER][CELLS], bend[TOGETHER][CELLS];
    Real sum[CELLS], bent[CELLS], cosine[CELLS], total[NPH_TPM_FIELDS][CELLS];
    int64_t cell[CELLS];
    int count;
} Block;

/* What is the same for all of a run: radius r [m]; tau is half_sigma times the sum (or difference) of densities. */
typedef struct Filter {
    Real radius, half_sigma, sign, switch_at, fall, wide, wide_density;
    int gaussian;
} Filter;

static Filter filter_of(const RTpmScene *scene) {
    const RPhase *phase = &scene->medium.phase;
    int hg = phase->kind == NPH_PHASE_HG;
    Real g = hg ? r_abs(phase->g0) : R(0.0), rest = hg ? phase->rest0 : R(1.0);
    Filter f = {.radius = R_HUGE, .half_sigma = R(0.5) * scene->majorant * scene->medium.albedo[0], .sign = scene->paper ? R(-1.0) : R(1.0)};
    for (int a = 0; a < 3; a++) f.radius = r_min(f.radius, ((Real)scene->reach + R(0.5)) * scene->coarse.edge[a]);
    f.switch_at = NPH_PRECISION == 32 ? R(0.03) : R(1e-3);
    f.gaussian = scene->upsampling == NPH_TPM_GAUSSIAN;
    f.fall = f.gaussian ? R(0.0) : scene->paper ? -r_log(r_max(g, R(1e-3))) : rest;
    f.wide = R(1.0) / (scene->spread * f.radius);
    f.wide_density = R(1.0) / scene->spread_density;
    return f;
}

R_INLINE Real distance_to(const Neighbour *q, Real x, Real y, Real z) {
    Real u = x - q->at[0], v = y - q->at[1], w = z - q->at[2];
    return r_sqrt(u * u + v * v + w * w);
}

/* The least tau d of all neighbours. */
R_OUTLINE void find_least(Block *restrict block, const Neighbour *restrict q, Real half_sigma, Real sign) {
    int count = block->count;
    for (int i = 0; i < count; i++) { /* vec */
        Real tau = half_sigma * (block->density[i] + sign * q->density);
        Real depth = tau * distance_to(q, block->at[0][i], block->at[1][i], block->at[2][i]);
        block->least[i] = depth < block->least[i] ? depth : block->least[i];
    }
}

R_OUTLINE void find_scale(Block *restrict block) {
    int count = block->count;
    for (int i = 0; i < count; i++) block->scale[i] = r_exp(-r_clamp(block->least[i], R(-80.0), R(80.0))); /* vec */
}

/* f_exp times e^least; below x = tau r = switch_at its series to the second order. scale: e^-least. */
R_INLINE Real truncated(Real tau, Real d, Real r, Real least, Real scale, Real switch_at) {
    Real x = tau * r, y = tau * d, left = r - d, mean = R(2.0) * left / (r * r);
    int flat = r_abs(x) < switch_at, beyond = !(left > R(0.0)) | (x < R(-60.0)); /* a difference, in print: all of it lies at r */
    Real series = mean * (R(1.0) - R(0.5) * (x + y) + (x * x + x * y + y * y) * R(0.16666666666666667));
    Real under = R(1.0) - x * R(0.66666666666666667) + R(0.25) * x * x;
    Real at = r_exp(least - y), border = r_exp(r_max(least - x, R(-80.0))), tail = border * scale;
    Real whole = R(1.0) - tail * (R(1.0) + x);
    Real value = (flat ? series : tau * (at - border)) / (flat ? under * scale : whole);
    return beyond ? R(0.0) : value;
}

/* Weights of one neighbour, slot k of TOGETHER. */
R_INLINE void weigh(Block *restrict block, const Neighbour *restrict q, const Filter *filter, int k, int gaussian) {
    const Filter f = *filter;
    const Neighbour from = *q;
    int count = block->count;
    for (int i = 0; i < count; i++) { /* vec */
        Real d = distance_to(&from, block->at[0][i], block->at[1][i], block->at[2][i]), unlike = r_abs(block->density[i] - from.density), weight;
        if (gaussian) {
            Real u = d * f.wide, v = unlike * f.wide_density;
            weight = r_exp(R(-0.5) * (u * u + v * v));
        } else {
            Real tau = f.half_sigma * (block->density[i] + f.sign * from.density), like = R(1.0) - unlike;
            weight = truncated(tau, d, f.radius, block->least[i], block->scale[i], f.switch_at) * (like > R(0.0) ? like : R(0.0));
        }
        block->weight[k][i] = weight;
        block->bend[k][i] = gaussian ? weight : weight * r_exp(-r_clamp(f.fall * (block->depth[i] - from.value[NPH_TPM_I_DEPTH]), R(-40.0), R(40.0)));
    }
}

R_OUTLINE void weigh_physical(Block *restrict block, const Neighbour *restrict q, const Filter *restrict filter, int k) {
    weigh(block, q, filter, k, 0);
}

R_OUTLINE void weigh_gaussian(Block *restrict block, const Neighbour *restrict q, const Filter *restrict filter, int k) {
    weigh(block, q, filter, k, 1);
}

/* What TOGETHER neighbours add to one sum. */
R_OUTLINE void add_weighed(Real *restrict sum, Real (*restrict w)[CELLS], const Real *restrict value, int count) {
    for (int i = 0; i < count; i++) /* vec */
        sum[i] += w[0][i] * value[0] + w[1][i] * value[1] + w[2][i] * value[2] + w[3][i] * value[3] + w[4][i] * value[4] + w[5][i] * value[5] +
                  w[6][i] * value[6] + w[7][i] * value[7] + w[8][i] * value[8];
}

static void add_neighbours(Block *block, const Neighbour *q, const Filter *filter, int neighbours) {
    Real one[TOGETHER], value[TOGETHER];
    for (int k = 0; k < TOGETHER; k++) {
        one[k] = R(1.0);
        if (k < neighbours) (filter->gaussian ? weigh_gaussian : weigh_physical)(block, &q[k], filter, k);
        for (int i = 0; i < block->count && k >= neighbours; i++) block->weight[k][i] = block->bend[k][i] = R(0.0);
    }
    add_weighed(block->sum, block->weight, one, block->count);
    add_weighed(block->bent, block->bend, one, block->count);
    for (int v = 0; v < NPH_TPM_FIELDS; v++) {
        for (int k = 0; k < TOGETHER; k++) value[k] = k < neighbours ? q[k].value[v] : R(0.0);
        add_weighed(block->total[v], block->weight, value, block->count);
        if (v == NPH_TPM_I_G) add_weighed(block->cosine, block->bend, value, block->count);
    }
}

static Real density_at(const RTpmScene *scene, const Real p[3]) {
    return r_tpm_density(&scene->medium, p[0], p[1], p[2]) / scene->density_max;
}

static Real middle_of(const RTpmGrid *grid, int a, int32_t i) { return grid->lo[a] + ((Real)i + R(0.5)) / grid->per_unit[a]; }

static int look_around(const RTpmScene *scene, const Real *coarse, const int32_t middle[3], Neighbour around[NEAR]) {
    const RTpmGrid *grid = &scene->coarse;
    int32_t low[3], high[3], at[3];
    int count = 0;
    for (int a = 0; a < 3; a++) {
        low[a] = middle[a] > scene->reach ? middle[a] - scene->reach : 0;
        high[a] = middle[a] + scene->reach < grid->n[a] ? middle[a] + scene->reach : grid->n[a] - 1;
    }
    for (at[2] = low[2]; at[2] <= high[2]; at[2]++)
        for (at[1] = low[1]; at[1] <= high[1]; at[1]++)
            for (at[0] = low[0]; at[0] <= high[0]; at[0]++) {
                Neighbour *q = &around[count++];
                const Real *cell = coarse + r_tpm_cell(grid->n, at[0], at[1], at[2]) * NPH_TPM_FIELDS;
                Real p[3] = {middle_of(grid, 0, at[0]), middle_of(grid, 1, at[1]), middle_of(grid, 2, at[2])};
                for (int v = 0; v < NPH_TPM_FIELDS; v++) q->value[v] = cell[v];
                for (int a = 0; a < 3; a++) q->at[a] = ((Real)at[a] + R(0.5)) * grid->edge[a];
                q->density = density_at(scene, p);
            }
    return count;
}

/* Fields [first, end) at p. */
static void interpolate(const RTpmScene *scene, const Real *coarse, const Real p[3], int first, int end, Real *out) {
    RTpmEight eight;
    r_tpm_eight(&scene->coarse, p, &eight);
    for (int v = first; v < end; v++) {
        out[v - first] = R(0.0);
        for (int k = 0; k < 8; k++) out[v - first] += eight.share[k] * coarse[eight.at[k] * NPH_TPM_FIELDS + v];
    }
}

/* Planes [first, end) of fine cells. */
void NPH_KERNEL(nph_tpm_guide)(const void *memory, int first, int end, void *guide) {
    const RTpmScene *scene = memory;
    const RTpmGrid *grid = &scene->fine;
    for (int z = first; z < end; z++)
        for (int y = 0; y < grid->n[1]; y++)
            for (int x = 0; x < grid->n[0]; x++) {
                Real p[3] = {middle_of(grid, 0, x), middle_of(grid, 1, y), middle_of(grid, 2, z)};
                ((Real *)guide)[r_tpm_cell(grid->n, x, y, z)] = density_at(scene, p);
            }
}

/* Whether anything is looked up in a fine cell, which is not larger than a voxel then: the density reaches no further than to the next
 * sample. Lookups that noise moves may be anywhere. */
static int is_seen(const RTpmScene *scene, const Real *guide, const int32_t at[3]) {
    const int32_t *n = scene->fine.n;
    int32_t low[3], high[3], p[3];
    if (scene->medium.shape != NPH_SHAPE_GRID || scene->upsampling == NPH_TPM_LINEAR || scene->noise > R(0.0)) return 1;
    for (int a = 0; a < 3; a++) {
        low[a] = at[a] > 0 ? at[a] - 1 : 0;
        high[a] = at[a] + 1 < n[a] ? at[a] + 1 : n[a] - 1;
    }
    for (p[2] = low[2]; p[2] <= high[2]; p[2]++)
        for (p[1] = low[1]; p[1] <= high[1]; p[1]++)
            for (p[0] = low[0]; p[0] <= high[0]; p[0]++)
                if (guide[r_tpm_cell(n, p[0], p[1], p[2])] > R(0.0)) return 1;
    return 0;
}

void NPH_KERNEL(nph_tpm_guide_seen)(const void *memory, const void *guide, int first, int end, uint8_t *seen) {
    const RTpmScene *scene = memory;
    const int32_t *n = scene->fine.n;
    int32_t at[3];
    for (at[2] = first; at[2] < end; at[2]++)
        for (at[1] = 0; at[1] < n[1]; at[1]++)
            for (at[0] = 0; at[0] < n[0]; at[0]++) seen[r_tpm_cell(n, at[0], at[1], at[2])] = (uint8_t)is_seen(scene, guide, at);
}

/* What nothing weighs is interpolated. */
static void finish(const RTpmScene *scene, const Block *block, const Real *coarse, Real *fine) {
    int divide = scene->paper || scene->upsampling == NPH_TPM_GAUSSIAN;
    const int32_t *n = scene->fine.n;
    for (int i = 0; i < block->count; i++) {
        int64_t cell = block->cell[i];
        Real *out = fine + cell * NPH_TPM_FIELDS;
        if (!(block->sum[i] > R(0.0))) {
            Real p[3] = {middle_of(&scene->fine, 0, (int32_t)(cell % n[0])), middle_of(&scene->fine, 1, (int32_t)(cell / n[0] % n[1])),
                         middle_of(&scene->fine, 2, (int32_t)(cell / n[0] / n[1]))};
            interpolate(scene, coarse, p, 0, NPH_TPM_FIELDS, out);
            continue;
        }
        for (int v = 0; v < NPH_TPM_FIELDS; v++) out[v] = block->total[v][i] / block->sum[i];
        out[NPH_TPM_I_G] = r_clamp(block->cosine[i] / (divide ? block->bent[i] : block->sum[i]), R(-1.0), R(1.0));
    }
}

/* Vectors are whole: lanes beyond the last cell do what it does. */
static void fill_vectors(Block *block) {
    for (int i = block->count; i & 15; i++) {
        for (int a = 0; a < 3; a++) block->at[a][i] = block->at[a][block->count - 1];
        block->density[i] = block->density[block->count - 1];
        block->depth[i] = block->depth[block->count - 1];
    }
}

static void filter_block(const RTpmScene *scene, const Filter *filter, Block *block, const Neighbour *around, int neighbours, const Real *coarse,
                         Real *fine) {
    int cells = block->count;
    if (cells == 0) return;
    fill_vectors(block);
    block->count = r_whole_vectors(cells);
    for (int i = 0; i < block->count; i++) {
        block->least[i] = R_HUGE;
        block->sum[i] = block->bent[i] = block->cosine[i] = R(0.0);
        for (int v = 0; v < NPH_TPM_FIELDS; v++) block->total[v][i] = R(0.0);
    }
    for (int k = 0; k < neighbours && !filter->gaussian; k++) find_least(block, &around[k], filter->half_sigma, filter->sign);
    find_scale(block);
    for (int k = 0; k < neighbours; k += TOGETHER) add_neighbours(block, around + k, filter, neighbours - k);
    block->count = cells;
    finish(scene, block, coarse, fine);
    block->count = 0;
}

/* The first fine cell of a coarse one along an axis: whose middle is not below its low side. */
static int32_t first_fine(const RTpmScene *scene, int a, int32_t coarse) {
    int64_t fine = scene->fine.n[a], cells = scene->coarse.n[a], twice = 2 * fine * coarse - cells;
    return twice <= 0 ? 0 : (int32_t)((twice + 2 * cells - 1) / (2 * cells));
}

static void upsample_block(const RTpmScene *scene, const Filter *filter, const Real *guide, const uint8_t *seen, const Real *coarse,
                           const int32_t middle[3], Real *fine) {
    const RTpmGrid *grid = &scene->fine;
    Neighbour around[NEAR];
    Block block;
    int neighbours = look_around(scene, coarse, middle, around);
    int32_t low[3], high[3], at[3];
    block.count = 0;
    for (int a = 0; a < 3; a++) {
        low[a] = first_fine(scene, a, middle[a]);
        high[a] = middle[a] + 1 < scene->coarse.n[a] ? first_fine(scene, a, middle[a] + 1) : grid->n[a];
    }
    for (at[2] = low[2]; at[2] < high[2]; at[2]++)
        for (at[1] = low[1]; at[1] < high[1]; at[1]++)
            for (at[0] = low[0]; at[0] < high[0]; at[0]++) {
                Real p[3] = {middle_of(grid, 0, at[0]), middle_of(grid, 1, at[1]), middle_of(grid, 2, at[2])};
                int64_t cell = r_tpm_cell(grid->n, at[0], at[1], at[2]);
                Real *out = fine + cell * NPH_TPM_FIELDS;
                if (!seen[cell]) {
                    for (int v = 0; v < NPH_TPM_FIELDS; v++) out[v] = R(0.0);
                    continue;
                }
                if (scene->upsampling == NPH_TPM_LINEAR) {
                    interpolate(scene, coarse, p, 0, NPH_TPM_FIELDS, out);
                    continue;
                }
                int i = block.count++;
                for (int a = 0; a < 3; a++) block.at[a][i] = ((Real)at[a] + R(0.5)) * grid->edge[a];
                interpolate(scene, coarse, p, NPH_TPM_I_DEPTH, NPH_TPM_I_DEPTH + 1, &block.depth[i]);
                block.density[i] = guide[cell];
                block.cell[i] = cell;
                if (block.count == CELLS) filter_block(scene, filter, &block, around, neighbours, coarse, fine);
            }
    filter_block(scene, filter, &block, around, neighbours, coarse, fine);
}

void NPH_KERNEL(nph_tpm_upsample)(const void *memory, const void *guide, const uint8_t *seen, const void *coarse, int64_t first, int64_t end,
                                  void *fine) {
    const RTpmScene *scene = memory;
    const int32_t *n = scene->coarse.n;
    Filter filter = filter_of(scene);
    for (int64_t i = first; i < end; i++) {
        int32_t middle[3] = {(int32_t)(i % n[0]), (int32_t)(i / n[0] % n[1]), (int32_t)(i / n[0] / n[1])};
        upsample_block(scene, &filter, guide, seen, coarse, middle, fine);
    }
}
