/* SPDX-License-Identifier: Apache-2.0
 *
 * pop.join, pop.spread and pop.merge [Elek14 sec. 5.3, 5.4], on grids along the medium.
 *   join    what is left of the light of all grids, as power in a volume: sum over grids of value light / depth, times this grid's own edge
 *           (of a point over what fluence counts by); scaled to keep the power of every channel. In print it is not scaled
 *   spread  isotropic light, a sixth to every neighbour, what absorption leaves of it; all that was joined (not in print, where the grids
 *           have accumulated it) and all that arrives is added up, times the path of a visit (pop_4_propagate_kernel.c)
 *   gather  sum over the grids of virtual point lights of value seen. There are many, of few cells: their grid has fewer cells than that of all
 *   merge   the same over all other grids, what was gathered, and a 4 pi-th of what was spread
 * Between the middles of a grid's cells everything is linear; beyond the outermost it is constant. */
#include "method/principal_ordinates/pop_kept.h"

void NPH_KERNEL(nph_pop_join)(const void *memory, const NphPopArrays *arrays, int first, int end);
void NPH_KERNEL(nph_pop_join_scale)(const void *memory, const NphPopArrays *arrays);
void NPH_KERNEL(nph_pop_keep)(const void *memory, const NphPopArrays *arrays, int first, int end);
void NPH_KERNEL(nph_pop_spread)(const void *memory, const NphPopArrays *arrays, int from, int first, int end);
double NPH_KERNEL(nph_pop_left)(const void *memory, const NphPopArrays *arrays, int from);
void NPH_KERNEL(nph_pop_gather)(const void *memory, const NphPopArrays *arrays, int first, int end);
void NPH_KERNEL(nph_pop_merge)(const void *memory, const NphPopArrays *arrays, int first, int end);

enum { MOST = 4096 };

/* Rows of places of a box along the medium, in scene-local space, and the eight cells of a grid around each of them. */
typedef struct Places {
    Real p[3][MOST], part[3][MOST], value[MOST];
    int32_t first[MOST], right[MOST], below[MOST], behind[MOST];
    int32_t width;
    int rows, count;
} Places;

static void find_places(const RPopScene *scene, const RPopBox *box, const int32_t first[2], Places *at) {
    at->count = 0;
    for (int row = 0; row < at->rows; row++)
        for (int32_t x = 0; x < at->width; x++, at->count++) {
            Real p[3];
            r_pop_middle(scene, box, x, first[0] + row, first[1], p);
            for (int a = 0; a < 3; a++) at->p[a][at->count] = p[a];
        }
}

R_INLINE void find_cell(Places *at, const RPopGrid *grid, const Real place[3], int i) {
    int32_t low[3] = {(int32_t)place[0], (int32_t)place[1], (int32_t)place[2]};
    at->part[0][i] = place[0] - (Real)low[0];
    at->part[1][i] = place[1] - (Real)low[1];
    at->part[2][i] = place[2] - (Real)low[2];
    at->first[i] = (low[2] * grid->n[1] + low[1]) * grid->n[0] + low[0];
    at->right[i] = low[0] + 1 < grid->n[0] ? 1 : 0;
    at->below[i] = low[1] + 1 < grid->n[1] ? grid->n[0] : 0;
    at->behind[i] = low[2] + 1 < grid->n[2] ? grid->n[0] * grid->n[1] : 0;
}

/* A grid's axes over its edges: places in cells, from the middle of the first. */
R_OUTLINE void find_flat(const RPopGrid *restrict grid, Places *restrict at) {
    const RPopGrid g = *grid;
    Real m[3][4];
    for (int b = 0; b < 3; b++) {
        for (int a = 0; a < 3; a++) m[b][a] = g.axis[b][a] / g.edge[b];
        m[b][3] = -(m[b][0] * g.middle[0] + m[b][1] * g.middle[1] + m[b][2] * g.middle[2]) - g.low[b] / g.edge[b] - R(0.5);
    }
    int count = at->count;
    for (int i = 0; i < count; i++) { /* vec */
        Real x = at->p[0][i], y = at->p[1][i], z = at->p[2][i], place[3];
        place[0] = r_min(r_max(m[0][0] * x + m[0][1] * y + m[0][2] * z + m[0][3], R(0.0)), (Real)(g.n[0] - 1));
        place[1] = r_min(r_max(m[1][0] * x + m[1][1] * y + m[1][2] * z + m[1][3], R(0.0)), (Real)(g.n[1] - 1));
        place[2] = r_min(r_max(m[2][0] * x + m[2][1] * y + m[2][2] * z + m[2][3], R(0.0)), (Real)(g.n[2] - 1));
        find_cell(at, &g, place, i);
    }
}

R_OUTLINE void find_radial(const RPopGrid *restrict grid, Places *restrict at) {
    const RPopGrid g = *grid;
    int count = at->count;
    for (int i = 0; i < count; i++) { /* vec */
        Real place[3];
        r_pop_find_radial(&g, at->p[0][i], at->p[1][i], at->p[2][i], place);
        find_cell(at, &g, place, i);
    }
}

R_OUTLINE void read_cells(const Real *restrict values, Places *restrict at) {
    int count = at->count;
    for (int i = 0; i < count; i++) { /* vec */
        int32_t k = at->first[i], right = at->right[i], below = at->below[i], behind = at->behind[i];
        Real a = r_grid_mix(values[k], values[k + right], at->part[0][i]), b = r_grid_mix(values[k + below], values[k + below + right], at->part[0][i]);
        Real c = r_grid_mix(values[k + behind], values[k + behind + right], at->part[0][i]);
        Real d = r_grid_mix(values[k + behind + below], values[k + behind + below + right], at->part[0][i]);
        at->value[i] = r_grid_mix(r_grid_mix(a, b, at->part[1][i]), r_grid_mix(c, d, at->part[1][i]), at->part[2][i]);
    }
}

/* out: every `apart`-th number of it. */
static void add_places(const Places *at, Real factor, int apart, Real *out) {
    for (int i = 0; i < at->count; i++) out[i * apart] += factor * at->value[i];
}

static void find_grid(const RPopGrid *grid, Places *at) { (grid->radial ? find_radial : find_flat)(grid, at); }

static int is_dark(const Real *row) { return !(row[NPH_POP_VALUE] + row[NPH_POP_VALUE + 1] + row[NPH_POP_VALUE + 2] > R(0.0)); }

/* From power over the mean solid angle of cells to power in a volume of a shell. */
static void thin_places(const RPopGrid *grid, Places *at) {
    for (int i = 0; i < at->count; i++) {
        int32_t shell = at->first[i] / (grid->n[0] * grid->n[1]);
        Real inside = r_pop_radius(grid, (Real)shell + at->part[2][i]), outside = inside * r_exp(grid->log_ratio);
        at->value[i] /= (outside * outside * outside - inside * inside * inside) * R(0.33333333333333333);
    }
}

/* What is added up: [cell] of all grids; numbers of the sum that are `apart`, channels that are `between`; joins: power in a volume. */
typedef struct Sum {
    const Real *values;
    Real *out;
    int apart, joins;
    int64_t between;
} Sum;

static void add_grid(const RPopScene *scene, const Real *ordinate, int number, const Sum *sum, Places *at) {
    const NphPopChoice *choice = &scene->choice;
    RPopGrid grid = r_pop_grid(scene, ordinate, number);
    int64_t cells = nph_pop_cells(grid.n), first = nph_pop_first(choice, number, choice->channels);
    find_grid(&grid, at);
    for (int c = 0; c < choice->transport.film_channels; c++) {
        if (choice->channels > 1 || c == 0) {
            read_cells(sum->values + first + (choice->channels > 1 ? c : 0) * cells, at);
            if (sum->joins && grid.radial) thin_places(&grid, at);
        }
        Real factor = ordinate[NPH_POP_VALUE + c];
        if (sum->joins && !grid.radial) factor /= grid.edge[2];
        add_places(at, factor, sum->apart, sum->out + c * sum->between);
    }
}

static void add_grids(const RPopScene *scene, const NphPopArrays *arrays, const int grids[2], const Sum *sum, Places *at) {
    for (int n = grids[0]; n < grids[1]; n++) {
        const Real *ordinate = (const Real *)arrays->ordinate + (int64_t)n * NPH_POP_ROW;
        if (!is_dark(ordinate)) add_grid(scene, ordinate, n, sum, at);
    }
}

/* The next rows of a plane, from row y on: as many as there is room for. */
static void begin_rows(const RPopScene *scene, const RPopBox *box, int32_t y, int32_t z, Places *at) {
    int32_t most = MOST / box->n[0], left = box->n[1] - y;
    at->width = box->n[0];
    at->rows = (int)(left < most ? left : most);
    find_places(scene, box, (int32_t[]){y, z}, at);
}

/* The sum over grids in planes of a box, [channel][z][y][x]; whole: of all planes. */
static void sum_planes(const RPopScene *scene, const NphPopArrays *arrays, const RPopBox *box, const int grids[2], const Sum *whole, const int planes[2]) {
    Places at;
    for (int32_t z = planes[0]; z < planes[1]; z++)
        for (int32_t y = 0; y < box->n[1]; y += at.rows) {
            Sum sum = *whole;
            sum.out += ((int64_t)z * box->n[1] + y) * box->n[0];
            begin_rows(scene, box, y, z, &at);
            for (int c = 0; c < scene->choice.transport.film_channels; c++)
                for (int i = 0; i < at.count; i++) sum.out[c * sum.between + i] = R(0.0);
            add_grids(scene, arrays, grids, &sum, &at);
        }
}

void NPH_KERNEL(nph_pop_join)(const void *memory, const NphPopArrays *arrays, int first, int end) {
    const RPopScene *scene = memory;
    const RPopBox *box = &scene->joined;
    Sum sum = {.values = arrays->light, .out = arrays->residuum[0], .apart = 1, .joins = 1, .between = nph_pop_cells(box->n)};
    sum_planes(scene, arrays, box, (int[]){0, nph_pop_grids(&scene->choice)}, &sum, (int[]){first, end});
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
        const Real *path = (const Real *)arrays->keep + (3 * choice->transport.film_channels + c) * cells;
        Real *shown = (Real *)arrays->spread + c * cells;
        for (int64_t i = 0; i < cells; i++) {
            out[i] = (Real)((double)out[i] * scale * edge);
            shown[i] = scene->paper ? R(0.0) : path[i] * out[i];
        }
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

/* [channel][z][y][x] of a box along the medium, at places of the merged one, times a factor. */
static void add_box(const RPopScene *scene, const RPopBox *box, const Real *values, Real factor, const int32_t first[2], Places *at, Real *out) {
    const RPopBox *from = &scene->merged;
    RPopGrid grid = {.radial = 0, .n = {box->n[0], box->n[1], box->n[2]}, .axis = {{R(1.0)}, {R(0.0), R(1.0)}, {R(0.0), R(0.0), R(1.0)}}};
    for (int a = 0; a < 3; a++) {
        grid.low[a] = box->lo[a];
        grid.edge[a] = box->edge[a];
    }
    for (int i = 0; i < at->count; i++) { /* in the medium's space */
        int32_t x = i % at->width, y = first[0] + i / at->width;
        at->p[0][i] = from->lo[0] + ((Real)x + R(0.5)) * from->edge[0];
        at->p[1][i] = from->lo[1] + ((Real)y + R(0.5)) * from->edge[1];
        at->p[2][i] = from->lo[2] + ((Real)first[1] + R(0.5)) * from->edge[2];
    }
    find_grid(&grid, at);
    for (int c = 0; c < scene->choice.transport.film_channels; c++) {
        read_cells(values + c * nph_pop_cells(box->n), at);
        add_places(at, factor, NPH_POP_CELL, out + c);
    }
}

/* The fourth number guides the upsampling: the density over the largest. */
static void add_guides(const RPopScene *scene, const NphPopArrays *arrays, const int32_t first[2], const Places *at, Real *out) {
    const RPopBox *box = &scene->merged;
    for (int i = 0; i < at->count; i++) {
        int32_t x = i % at->width, y = first[0] + i / at->width;
        Real u = box->lo[0] + ((Real)x + R(0.5)) * box->edge[0], v = box->lo[1] + ((Real)y + R(0.5)) * box->edge[1];
        Real density = r_pop_density(scene, arrays->medium, u, v, box->lo[2] + ((Real)first[1] + R(0.5)) * box->edge[2]);
        out[i * NPH_POP_CELL + 3] = scene->density_max > R(0.0) ? density / scene->density_max : R(0.0);
    }
}

void NPH_KERNEL(nph_pop_gather)(const void *memory, const NphPopArrays *arrays, int first, int end) {
    const RPopScene *scene = memory;
    const RPopBox *box = &scene->gathered;
    Sum sum = {.values = arrays->seen, .out = arrays->gathered, .apart = 1, .between = nph_pop_cells(box->n)};
    sum_planes(scene, arrays, box, (int[]){nph_pop_lamps(&scene->choice), nph_pop_grids(&scene->choice)}, &sum, (int[]){first, end});
}

void NPH_KERNEL(nph_pop_merge)(const void *memory, const NphPopArrays *arrays, int first, int end) {
    const RPopScene *scene = memory;
    const RPopBox *box = &scene->merged;
    int channels = scene->choice.transport.film_channels;
    Places at;
    for (int32_t z = first; z < end; z++)
        for (int32_t y = 0; y < box->n[1]; y += at.rows) {
            Real *out = (Real *)arrays->merged + ((int64_t)z * box->n[1] + y) * box->n[0] * NPH_POP_CELL;
            Sum sum = {.values = arrays->seen, .out = out, .apart = NPH_POP_CELL, .between = 1};
            begin_rows(scene, box, y, z, &at);
            for (int i = 0; i < at.count * NPH_POP_CELL; i++) out[i] = R(0.0);
            add_grids(scene, arrays, (int[]){0, nph_pop_lamps(&scene->choice)}, &sum, &at);
            if (scene->choice.vpls > 0) add_box(scene, &scene->gathered, arrays->gathered, R(1.0), (int32_t[]){y, z}, &at, out);
            if (scene->choice.residuum) add_box(scene, &scene->joined, arrays->spread, R(0.079577471545947668), (int32_t[]){y, z}, &at, out);
            for (int i = 0; i < at.count && channels == 1; i++) out[i * NPH_POP_CELL + 1] = out[i * NPH_POP_CELL + 2] = out[i * NPH_POP_CELL];
            add_guides(scene, arrays, (int32_t[]){y, z}, &at, out);
        }
}
