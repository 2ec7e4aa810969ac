/* SPDX-License-Identifier: Apache-2.0
 *
 * pop.join, pop.spread and pop.merge [Elek14 sec. 5.3, 5.4], on grids along the medium.
 *   join    what is left of the light of all grids, as power in a volume: sum over grids of value light / depth, times this grid's own edge
 *           (of a point over what fluence counts by); scaled to keep the power of every channel. In print it is not scaled
 *   spread  isotropic light, a sixth to every neighbour, what absorption leaves of it; all that arrives is added up
 *   merge   sum over grids of value seen, and a 4 pi-th of what was spread
 * Between the middles of a grid's cells everything is linear; beyond the outermost it is constant. */
#include "method/principal_ordinates/pop_kept.h"

void NPH_KERNEL(nph_pop_join)(const void *memory, const NphPopArrays *arrays, int first, int end);
void NPH_KERNEL(nph_pop_join_scale)(const void *memory, const NphPopArrays *arrays);
void NPH_KERNEL(nph_pop_keep)(const void *memory, const NphPopArrays *arrays, int first, int end);
void NPH_KERNEL(nph_pop_spread)(const void *memory, const NphPopArrays *arrays, int from, int first, int end);
double NPH_KERNEL(nph_pop_left)(const void *memory, const NphPopArrays *arrays, int from);
void NPH_KERNEL(nph_pop_merge)(const void *memory, const NphPopArrays *arrays, int first, int end);

enum { ROW = 4096 };

/* A row of places, and the eight cells of a grid around each of them. */
typedef struct Row {
    Real p[3][ROW], part[3][ROW], value[ROW];
    int32_t first[ROW], right[ROW], below[ROW], behind[ROW];
    int count;
} Row;

R_OUTLINE void find_places(const RPopScene *restrict scene, const RPopBox *restrict box, int32_t y, int32_t z, Row *restrict row) {
    const RPopScene *s = scene;
    const RPopBox b = *box;
    int count = row->count;
    for (int i = 0; i < count; i++) { /* vec */
        Real p[3];
        r_pop_middle(s, &b, i, y, z, p);
        row->p[0][i] = p[0];
        row->p[1][i] = p[1];
        row->p[2][i] = p[2];
    }
}

R_INLINE void find_cell(Row *row, const RPopGrid *grid, int i) {
    Real at[3];
    r_pop_find(grid, row->p[0][i], row->p[1][i], row->p[2][i], at);
    int32_t low[3] = {(int32_t)at[0], (int32_t)at[1], (int32_t)at[2]};
    row->part[0][i] = at[0] - (Real)low[0];
    row->part[1][i] = at[1] - (Real)low[1];
    row->part[2][i] = at[2] - (Real)low[2];
    row->first[i] = (low[2] * grid->n[1] + low[1]) * grid->n[0] + low[0];
    row->right[i] = low[0] + 1 < grid->n[0] ? 1 : 0;
    row->below[i] = low[1] + 1 < grid->n[1] ? grid->n[0] : 0;
    row->behind[i] = low[2] + 1 < grid->n[2] ? grid->n[0] * grid->n[1] : 0;
}

R_OUTLINE void find_flat(const RPopGrid *restrict grid, Row *restrict row) {
    RPopGrid g = *grid;
    int count = row->count;
    g.radial = 0;
    for (int i = 0; i < count; i++) find_cell(row, &g, i); /* vec */
}

R_OUTLINE void find_radial(const RPopGrid *restrict grid, Row *restrict row) {
    RPopGrid g = *grid;
    int count = row->count;
    g.radial = 1;
    for (int i = 0; i < count; i++) find_cell(row, &g, i); /* vec */
}

R_OUTLINE void read_cells(const Real *restrict values, Row *restrict row) {
    int count = row->count;
    for (int i = 0; i < count; i++) { /* vec */
        int32_t at = row->first[i], right = row->right[i], below = row->below[i], behind = row->behind[i];
        Real a = r_grid_mix(values[at], values[at + right], row->part[0][i]), b = r_grid_mix(values[at + below], values[at + below + right], row->part[0][i]);
        Real c = r_grid_mix(values[at + behind], values[at + behind + right], row->part[0][i]);
        Real d = r_grid_mix(values[at + behind + below], values[at + behind + below + right], row->part[0][i]);
        row->value[i] = r_grid_mix(r_grid_mix(a, b, row->part[1][i]), r_grid_mix(c, d, row->part[1][i]), row->part[2][i]);
    }
}

/* out: every `apart`-th number of it. */
static void add_row(const Row *row, Real factor, int apart, Real *out) {
    for (int i = 0; i < row->count; i++) out[i * apart] += factor * row->value[i];
}

static void find_grid(const RPopGrid *grid, Row *row) { (grid->radial ? find_radial : find_flat)(grid, row); }

static int is_dark(const Real *row) { return !(row[NPH_POP_VALUE] + row[NPH_POP_VALUE + 1] + row[NPH_POP_VALUE + 2] > R(0.0)); }

/* From power over the mean solid angle of cells to power in a volume of a shell. */
static void thin_row(const RPopGrid *grid, Row *row) {
    for (int i = 0; i < row->count; i++) {
        Real inside = r_pop_radius(grid, (Real)(row->first[i] / (grid->n[0] * grid->n[1])) + row->part[2][i]), outside = inside * r_exp(grid->log_ratio);
        row->value[i] /= (outside * outside * outside - inside * inside * inside) * R(0.33333333333333333);
    }
}

/* Radiance or power of all grids at the places of a row: `values` is arrays->seen or arrays->light. */
static void add_grids(const RPopScene *scene, const NphPopArrays *arrays, const Real *values, int channels, int apart, int64_t between, int joins,
                      Row *row, Real *out) {
    const NphPopChoice *choice = &scene->choice;
    for (int n = 0; n < nph_pop_grids(choice); n++) {
        const Real *ordinate = (const Real *)arrays->ordinate + (int64_t)n * NPH_POP_ROW;
        if (is_dark(ordinate)) continue;
        RPopGrid grid = r_pop_grid(scene, ordinate, n);
        int64_t cells = nph_pop_cells(grid.n), first = nph_pop_first(choice, n, choice->channels);
        find_grid(&grid, row);
        for (int c = 0; c < channels; c++) {
            Real factor = ordinate[NPH_POP_VALUE + c];
            if (choice->channels > 1 || c == 0) {
                read_cells(values + first + (choice->channels > 1 ? c : 0) * cells, row);
                if (joins && grid.radial) thin_row(&grid, row);
            }
            if (joins && !grid.radial) factor /= grid.edge[2];
            add_row(row, factor, apart, out + c * between);
        }
    }
}

void NPH_KERNEL(nph_pop_join)(const void *memory, const NphPopArrays *arrays, int first, int end) {
    const RPopScene *scene = memory;
    const RPopBox *box = &scene->joined;
    int64_t cells = nph_pop_cells(box->n);
    Row row;
    row.count = box->n[0];
    for (int32_t z = first; z < end; z++)
        for (int32_t y = 0; y < box->n[1]; y++) {
            Real *out = (Real *)arrays->residuum[0] + ((int64_t)z * box->n[1] + y) * box->n[0];
            for (int c = 0; c < scene->choice.transport.film_channels; c++)
                for (int i = 0; i < row.count; i++) out[c * cells + i] = ((Real *)arrays->spread)[out - (Real *)arrays->residuum[0] + c * cells + i] = R(0.0);
            find_places(scene, box, y, z, &row);
            add_grids(scene, arrays, arrays->light, scene->choice.transport.film_channels, 1, cells, 1, &row, out);
        }
}

/* The volume of a cell of the joined grid. */
static double volume_of(const RPopBox *box) { return (double)box->metres[0] * (double)box->metres[1] * (double)box->metres[2]; }

/* From power in a volume to light, its power kept. */
void NPH_KERNEL(nph_pop_join_scale)(const void *memory, const NphPopArrays *arrays) {
    const RPopScene *scene = memory;
    const NphPopChoice *choice = &scene->choice;
    int64_t cells = nph_pop_cells(scene->joined.n);
    double edge = nph_exp(nph_log(volume_of(&scene->joined)) / 3.0);
    for (int c = 0; c < choice->transport.film_channels; c++) {
        Real *out = (Real *)arrays->residuum[0] + c * cells;
        double before = 0.0, after = r_pop_sum(out, cells) * volume_of(&scene->joined), scale = 1.0;
        for (int n = 0; n < nph_pop_grids(choice); n++) {
            const Real *ordinate = (const Real *)arrays->ordinate + (int64_t)n * NPH_POP_ROW;
            RPopGrid grid = r_pop_grid(scene, ordinate, n);
            double area = grid.radial ? 12.566370614359172 / (double)(grid.n[0] * grid.n[1]) : (double)grid.edge[0] * (double)grid.edge[1];
            before += (double)ordinate[NPH_POP_VALUE + c] * area * arrays->power[((int64_t)n * choice->channels + (choice->channels > 1 ? c : 0)) * NPH_POP_POWERS + NPH_POP_LEFT];
        }
        if (!scene->paper && after > 0.0) scale = before / after;
        for (int64_t i = 0; i < cells; i++) out[i] = (Real)((double)out[i] * scale * edge);
    }
}

/* What is left on half the way through a cell: [axis][channel][cell]. */
void NPH_KERNEL(nph_pop_keep)(const void *memory, const NphPopArrays *arrays, int first, int end) {
    const RPopScene *scene = memory;
    const RPopBox *box = &scene->joined;
    int64_t cells = nph_pop_cells(box->n), at = (int64_t)first * box->n[1] * box->n[0];
    int channels = scene->choice.transport.film_channels;
    const Real edge = (Real)nph_exp(nph_log(volume_of(box)) / 3.0);
    for (int32_t z = first; z < end; z++)
        for (int32_t y = 0; y < box->n[1]; y++)
            for (int32_t x = 0; x < box->n[0]; x++, at++) {
                Real u = box->lo[0] + ((Real)x + R(0.5)) * box->edge[0], v = box->lo[1] + ((Real)y + R(0.5)) * box->edge[1];
                Real density = r_pop_density(scene, arrays->medium, u, v, box->lo[2] + ((Real)z + R(0.5)) * box->edge[2]);
                for (int c = 0; c < channels; c++) {
                    Real path = scene->paths ? R(0.5) * (scene->sigma_a[c] + scene->sigma_s[c] * (R(1.0) - scene->g)) * density * edge : R(1.0);
                    for (int a = 0; a < 3; a++)
                        ((Real *)arrays->keep)[(a * channels + c) * cells + at] = r_exp(R(-0.5) * path * scene->sigma_a[c] * density * box->metres[a]);
                    ((Real *)arrays->keep)[(3 * channels + c) * cells + at] = path;
                }
            }
}

/* A row of an iteration: whether there are rows and planes below and above; 0 or how far they are. */
typedef struct Spread {
    int64_t south, north, back, front;
    Real down, up, before, after;
    int count;
} Spread;

R_INLINE Real arrives_at(const Spread *s, const Real *from, const Real *keep, int64_t axis, int i, int west, int east) {
    const Real *ky = keep + axis, *kz = keep + 2 * axis;
    Real lateral = (Real)west * from[i - west] * keep[i - west] + (Real)east * from[i + east] * keep[i + east];
    Real beside = s->down * from[i - s->south] * ky[i - s->south] + s->up * from[i + s->north] * ky[i + s->north];
    Real along = s->before * from[i - s->back] * kz[i - s->back] + s->after * from[i + s->front] * kz[i + s->front];
    return R(0.16666666666666667) * (lateral * keep[i] + beside * ky[i] + along * kz[i]);
}

R_OUTLINE void spread_row(const Spread *restrict spread, const Real *restrict from, const Real *restrict keep, int64_t axis, Real *restrict to, Real *restrict sum) {
    const Spread s = *spread;
    const int last = s.count - 1;
    to[0] = arrives_at(&s, from, keep, axis, 0, 0, last > 0);
    if (last > 0) to[last] = arrives_at(&s, from, keep, axis, last, 1, 0);
    for (int i = 1; i < last; i++) to[i] = arrives_at(&s, from, keep, axis, i, 1, 1); /* vec */
    for (int i = 0; i < s.count; i++) sum[i] += keep[3 * axis + i] * to[i];          /* vec */
}

void NPH_KERNEL(nph_pop_spread)(const void *memory, const NphPopArrays *arrays, int from, int first, int end) {
    const RPopScene *scene = memory;
    const RPopBox *box = &scene->joined;
    int channels = scene->choice.transport.film_channels;
    int64_t cells = nph_pop_cells(box->n);
    for (int c = 0; c < channels; c++)
        for (int32_t z = first; z < end; z++)
            for (int32_t y = 0; y < box->n[1]; y++) {
                int64_t line = box->n[0], plane = line * box->n[1], at = z * plane + y * line;
                int low = y > 0, high = y + 1 < box->n[1], near = z > 0, far = z + 1 < box->n[2];
                Spread s = {low * line, high * line, near * plane, far * plane, (Real)low, (Real)high, (Real)near, (Real)far, box->n[0]};
                spread_row(&s, (const Real *)arrays->residuum[from] + c * cells + at, (const Real *)arrays->keep + c * cells + at, channels * cells,
                           (Real *)arrays->residuum[1 - from] + c * cells + at, (Real *)arrays->spread + c * cells + at);
            }
}

double NPH_KERNEL(nph_pop_left)(const void *memory, const NphPopArrays *arrays, int from) {
    const RPopScene *scene = memory;
    return r_pop_sum(arrays->residuum[from], scene->choice.transport.film_channels * nph_pop_cells(scene->joined.n));
}

/* What was spread, at the places of a row: isotropic. */
static void add_spread(const RPopScene *scene, const NphPopArrays *arrays, int32_t y, int32_t z, Row *row, Real *out) {
    const RPopBox *from = &scene->merged, *box = &scene->joined;
    RPopGrid grid = {.radial = 0, .n = {box->n[0], box->n[1], box->n[2]}, .axis = {{R(1.0)}, {R(0.0), R(1.0)}, {R(0.0), R(0.0), R(1.0)}}};
    for (int a = 0; a < 3; a++) {
        grid.low[a] = box->lo[a];
        grid.edge[a] = box->edge[a];
    }
    for (int i = 0; i < row->count; i++) { /* in the medium's space */
        row->p[0][i] = from->lo[0] + ((Real)i + R(0.5)) * from->edge[0];
        row->p[1][i] = from->lo[1] + ((Real)y + R(0.5)) * from->edge[1];
        row->p[2][i] = from->lo[2] + ((Real)z + R(0.5)) * from->edge[2];
    }
    find_grid(&grid, row);
    for (int c = 0; c < scene->choice.transport.film_channels; c++) {
        read_cells((const Real *)arrays->spread + c * nph_pop_cells(box->n), row);
        add_row(row, R(0.079577471545947668), NPH_POP_CELL, out + c);
    }
}

void NPH_KERNEL(nph_pop_merge)(const void *memory, const NphPopArrays *arrays, int first, int end) {
    const RPopScene *scene = memory;
    const RPopBox *box = &scene->merged;
    int channels = scene->choice.transport.film_channels;
    Row row;
    row.count = box->n[0];
    for (int32_t z = first; z < end; z++)
        for (int32_t y = 0; y < box->n[1]; y++) {
            Real *out = (Real *)arrays->merged + ((int64_t)z * box->n[1] + y) * box->n[0] * NPH_POP_CELL;
            for (int i = 0; i < row.count * NPH_POP_CELL; i++) out[i] = R(0.0);
            find_places(scene, box, y, z, &row);
            add_grids(scene, arrays, arrays->seen, channels, NPH_POP_CELL, 1, 0, &row, out);
            if (scene->choice.residuum) add_spread(scene, arrays, y, z, &row, out);
            for (int i = 0; i < row.count && channels == 1; i++) out[i * NPH_POP_CELL + 1] = out[i * NPH_POP_CELL + 2] = out[i * NPH_POP_CELL];
        }
}
