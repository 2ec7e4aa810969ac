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
 * In e^(-(1-g) delta) the depth of the block's own cell stands between the two: a factor of p, and one of q that its I_g is multiplied by.
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

/* A cell of the neighbourhood: its values, middle [m from the low corner], density over the largest; and what e^(-(1-g) delta) is between
 * the block's own cell and this one, which the mean cosine is multiplied by already. */
typedef struct Neighbour {
    Real value[NPH_TPM_FIELDS], at[3], density, bend;
} Neighbour;

enum { TOGETHER = 9 }; /* neighbours that are added at once: their weights stay near, and a sum is read and written once for all */

/* Fine cells of a block: place [m from the low corner; in the medium's space], density, the rest of e^(-(1-g) delta); distances from all
 * neighbours, weights of some; and the sums over all. */
typedef struct Block {
    Real at[3][CELLS], place[3][CELLS], density[CELLS], bend[CELLS], least[CELLS], scale[CELLS];
    Real distance[NEAR][CELLS], weight[TOGETHER][CELLS];
    Real sum[CELLS], bent[CELLS], total[NPH_TPM_FIELDS][CELLS];
    int64_t cell[CELLS];
    int count;
} Block;

/* What is the same for all of a run: radius r [m]; tau is half_sigma times the sum (or difference) of densities. */
typedef struct Filter {
    Real radius, per_radius2, half_sigma, sign, switch_at, fall, wide, wide_density;
    int gaussian, divide; /* divide: the mean cosine by its own weights */
} Filter;

static Filter filter_of(const RTpmScene *scene) {
    const RPhase *phase = &scene->medium.phase;
    int hg = phase->kind == NPH_PHASE_HG;
    Real g = hg ? r_abs(phase->g0) : R(0.0), rest = hg ? phase->rest0 : R(1.0);
    Filter f = {.radius = R_HUGE, .half_sigma = R(0.5) * scene->majorant * scene->medium.albedo[0], .sign = scene->paper ? R(-1.0) : R(1.0)};
    for (int a = 0; a < 3; a++) f.radius = r_min(f.radius, ((Real)scene->reach + R(0.5)) * scene->coarse.edge[a]);
    f.per_radius2 = R(2.0) / (f.radius * f.radius);
    f.switch_at = NPH_PRECISION == 32 ? R(0.03) : R(1e-3);
    f.gaussian = scene->upsampling == NPH_TPM_GAUSSIAN;
    f.divide = scene->paper || f.gaussian;
    f.fall = f.gaussian ? R(0.0) : scene->paper ? -r_log(r_max(g, R(1e-3))) : rest;
    f.wide = R(1.0) / (scene->spread * f.radius);
    f.wide_density = R(1.0) / scene->spread_density;
    return f;
}

/* Distances of a neighbour, and the least tau d of all. */
R_OUTLINE void find_least(Block *restrict block, Real *restrict distance, const Neighbour *restrict q, Real half_sigma, Real sign) {
    int count = block->count;
    for (int i = 0; i < count; i++) { /* vec */
        Real u = block->at[0][i] - q->at[0], v = block->at[1][i] - q->at[1], w = block->at[2][i] - q->at[2];
        Real d = r_sqrt(u * u + v * v + w * w), tau = half_sigma * (block->density[i] + sign * q->density), depth = tau * d;
        distance[i] = d;
        block->least[i] = depth < block->least[i] ? depth : block->least[i];
    }
}

/* From the mean depth where the cells are: linear between the middles of the coarse ones. own: the depth of the block's. */
R_OUTLINE void find_bend(Block *restrict block, const RTpmGrid *restrict grid, const Real *restrict depth, Real fall, Real own) {
    const RTpmGrid g = *grid;
    int count = block->count, line = g.n[0] * NPH_TPM_FIELDS, plane = g.n[1] * line;
    for (int i = 0; i < count; i++) { /* vec */
        RTpmAxis x = r_tpm_axis(block->place[0][i], g.lo[0], g.per_unit[0], g.n[0]), y = r_tpm_axis(block->place[1][i], g.lo[1], g.per_unit[1], g.n[1]);
        RTpmAxis z = r_tpm_axis(block->place[2][i], g.lo[2], g.per_unit[2], g.n[2]);
        int32_t at = z.low * plane + y.low * line + x.low * NPH_TPM_FIELDS, right = x.more * NPH_TPM_FIELDS, below = y.more * line, behind = z.more * plane;
        Real near00 = r_grid_mix(depth[at], depth[at + right], x.part), near10 = r_grid_mix(depth[at + below], depth[at + below + right], x.part);
        Real far00 = r_grid_mix(depth[at + behind], depth[at + behind + right], x.part);
        Real far10 = r_grid_mix(depth[at + behind + below], depth[at + behind + below + right], x.part);
        Real here = r_grid_mix(r_grid_mix(near00, near10, y.part), r_grid_mix(far00, far10, y.part), z.part);
        block->bend[i] = r_exp(-r_clamp(fall * (here - own), R(-40.0), R(40.0)));
    }
}

R_OUTLINE void find_scale(Block *restrict block) {
    int count = block->count;
    for (int i = 0; i < count; i++) block->scale[i] = r_exp(-r_clamp(block->least[i], R(-80.0), R(80.0))); /* vec */
}

/* f_exp times e^least; below x = tau r = switch_at its series to the second order. scale: e^-least. */
R_INLINE Real truncated(const Filter *f, Real tau, Real d, Real least, Real scale) {
    Real x = tau * f->radius, y = tau * d, left = f->radius - d, mean = left * f->per_radius2;
    int flat = r_abs(x) < f->switch_at, beyond = !(left > R(0.0)) | (x < R(-60.0)); /* a difference, in print: all of it lies at r */
    Real series = mean * (R(1.0) - R(0.5) * (x + y) + (x * x + x * y + y * y) * R(0.16666666666666667));
    Real under = R(1.0) - x * R(0.66666666666666667) + R(0.25) * x * x;
    Real at = r_exp(least - y), border = r_exp(r_max(least - x, R(-80.0))), tail = border * scale;
    Real whole = R(1.0) - tail * (R(1.0) + x);
    Real value = (flat ? series : tau * (at - border)) / (flat ? under * scale : whole);
    return beyond ? R(0.0) : value;
}

/* Weights of one neighbour. */
R_INLINE void weigh(Real *restrict weights, const Block *restrict block, const Real *restrict distance, const Filter *filter, Real density, int gaussian) {
    const Filter f = *filter;
    int count = block->count;
    for (int i = 0; i < count; i++) { /* vec */
        Real unlike = r_abs(block->density[i] - density), weight;
        if (gaussian) {
            Real u = distance[i] * f.wide, v = unlike * f.wide_density;
            weight = r_exp(R(-0.5) * (u * u + v * v));
        } else {
            Real tau = f.half_sigma * (block->density[i] + f.sign * density), like = R(1.0) - unlike;
            weight = truncated(&f, tau, distance[i], block->least[i], block->scale[i]) * (like > R(0.0) ? like : R(0.0));
        }
        weights[i] = weight;
    }
}

R_OUTLINE void weigh_physical(Real *restrict weights, const Block *restrict block, const Real *restrict distance, const Filter *restrict filter,
                              Real density) {
    weigh(weights, block, distance, filter, density, 0);
}

R_OUTLINE void weigh_gaussian(Real *restrict weights, const Block *restrict block, const Real *restrict distance, const Filter *restrict filter,
                              Real density) {
    weigh(weights, block, distance, filter, density, 1);
}

/* What TOGETHER neighbours add to one sum. */
R_OUTLINE void add_weighed(Real *restrict sum, Real (*restrict w)[CELLS], const Real *restrict value, int count) {
    for (int i = 0; i < count; i++) /* vec */
        sum[i] += w[0][i] * value[0] + w[1][i] * value[1] + w[2][i] * value[2] + w[3][i] * value[3] + w[4][i] * value[4] + w[5][i] * value[5] +
                  w[6][i] * value[6] + w[7][i] * value[7] + w[8][i] * value[8];
}

/* Neighbours [first, first + TOGETHER), of which there may be fewer. A field that none of them has adds nothing: so is the lobe of a sky
 * that is the same from all sides. */
static void add_neighbours(Block *block, const Neighbour *around, const Filter *filter, int first, int neighbours) {
    Real value[NPH_TPM_FIELDS + 2][TOGETHER] = {{R(0.0)}};
    int left = neighbours - first < TOGETHER ? neighbours - first : TOGETHER, any[NPH_TPM_FIELDS + 2] = {0};
    for (int k = 0; k < left; k++) {
        const Neighbour *q = &around[first + k];
        (filter->gaussian ? weigh_gaussian : weigh_physical)(block->weight[k], block, block->distance[first + k], filter, q->density);
        for (int v = 0; v < NPH_TPM_FIELDS; v++) value[v][k] = q->value[v];
        value[NPH_TPM_FIELDS][k] = R(1.0);
        value[NPH_TPM_FIELDS + 1][k] = filter->divide ? q->bend : R(0.0);
        for (int v = 0; v < NPH_TPM_FIELDS + 2; v++) any[v] |= value[v][k] < R(0.0) || value[v][k] > R(0.0);
    }
    for (int k = left; k < TOGETHER; k++)
        for (int i = 0; i < block->count; i++) block->weight[k][i] = R(0.0);
    for (int v = 0; v < NPH_TPM_FIELDS; v++)
        if (any[v]) add_weighed(block->total[v], block->weight, value[v], block->count);
    add_weighed(block->sum, block->weight, value[NPH_TPM_FIELDS], block->count);
    if (filter->divide) add_weighed(block->bent, block->weight, value[NPH_TPM_FIELDS + 1], block->count);
}

static Real density_at(const RTpmScene *scene, const Real p[3]) {
    return r_tpm_density(&scene->medium, p[0], p[1], p[2]) / scene->density_max;
}

static Real middle_of(const RTpmGrid *grid, int a, int32_t i) { return grid->lo[a] + ((Real)i + R(0.5)) / grid->per_unit[a]; }

static int look_around(const RTpmScene *scene, Real fall, const Real *coarse, const int32_t middle[3], Neighbour around[NEAR]) {
    const RTpmGrid *grid = &scene->coarse;
    const Real own = coarse[r_tpm_cell(grid->n, middle[0], middle[1], middle[2]) * NPH_TPM_FIELDS + NPH_TPM_I_DEPTH];
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
                q->bend = r_exp(-r_clamp(fall * (own - cell[NPH_TPM_I_DEPTH]), R(-40.0), R(40.0)));
                q->value[NPH_TPM_I_G] *= q->bend;
            }
    return count;
}

static void interpolate(const RTpmScene *scene, const Real *coarse, const Real p[3], Real *out) {
    RTpmEight eight;
    r_tpm_eight(&scene->coarse, p, &eight);
    for (int v = 0; v < NPH_TPM_FIELDS; v++) {
        out[v] = R(0.0);
        for (int k = 0; k < 8; k++) out[v] += eight.share[k] * coarse[eight.at[k] * NPH_TPM_FIELDS + v];
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

R_OUTLINE void divide(Real *restrict value, const Real *restrict by, int count) {
    for (int i = 0; i < count; i++) value[i] /= by[i]; /* vec */
}

R_OUTLINE void bend_cosine(Real *restrict cosine, const Real *restrict bend, int count) {
    for (int i = 0; i < count; i++) cosine[i] = r_clamp(cosine[i] * bend[i], R(-1.0), R(1.0)); /* vec */
}

/* What nothing weighs is interpolated. */
static void finish(const RTpmScene *scene, const Filter *filter, Block *block, int cells, const Real *coarse, Real *fine) {
    for (int v = 0; v < NPH_TPM_FIELDS; v++) divide(block->total[v], filter->divide && v == NPH_TPM_I_G ? block->bent : block->sum, block->count);
    bend_cosine(block->total[NPH_TPM_I_G], block->bend, block->count);
    for (int i = 0; i < cells; i++) {
        Real *out = fine + block->cell[i] * NPH_TPM_FIELDS;
        Real p[3] = {block->place[0][i], block->place[1][i], block->place[2][i]};
        for (int v = 0; v < NPH_TPM_FIELDS; v++) out[v] = block->total[v][i];
        if (!(block->sum[i] > R(0.0))) interpolate(scene, coarse, p, out);
    }
}

/* Vectors are whole: lanes beyond the last cell do what it does. */
static void fill_vectors(Block *block) {
    for (int i = block->count; i & 15; i++) {
        for (int a = 0; a < 3; a++) {
            block->at[a][i] = block->at[a][block->count - 1];
            block->place[a][i] = block->place[a][block->count - 1];
        }
        block->density[i] = block->density[block->count - 1];
    }
}

static void filter_block(const RTpmScene *scene, const Filter *filter, Block *block, const int32_t middle[3], const Real *coarse, Real *fine) {
    Neighbour around[NEAR];
    int cells = block->count;
    if (cells == 0) return;
    int neighbours = look_around(scene, filter->fall, coarse, middle, around);
    fill_vectors(block);
    block->count = r_whole_vectors(cells);
    for (int i = 0; i < block->count; i++) {
        block->least[i] = R_HUGE;
        block->bend[i] = R(1.0);
        block->sum[i] = block->bent[i] = R(0.0);
        for (int v = 0; v < NPH_TPM_FIELDS; v++) block->total[v][i] = R(0.0);
    }
    for (int k = 0; k < neighbours; k++) find_least(block, block->distance[k], &around[k], filter->half_sigma, filter->sign);
    find_scale(block);
    if (!filter->divide)
        find_bend(block, &scene->coarse, coarse + NPH_TPM_I_DEPTH, filter->fall,
                  coarse[r_tpm_cell(scene->coarse.n, middle[0], middle[1], middle[2]) * NPH_TPM_FIELDS + NPH_TPM_I_DEPTH]);
    for (int k = 0; k < neighbours; k += TOGETHER) add_neighbours(block, around, filter, k, neighbours);
    finish(scene, filter, block, cells, coarse, fine);
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
    Block block;
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
                    interpolate(scene, coarse, p, out);
                    continue;
                }
                int i = block.count++;
                for (int a = 0; a < 3; a++) {
                    block.at[a][i] = ((Real)at[a] + R(0.5)) * grid->edge[a];
                    block.place[a][i] = p[a];
                }
                block.density[i] = guide[cell];
                block.cell[i] = cell;
                if (block.count == CELLS) filter_block(scene, filter, &block, middle, coarse, fine);
            }
    filter_block(scene, filter, &block, middle, coarse, fine);
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
