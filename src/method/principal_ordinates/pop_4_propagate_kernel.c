/* SPDX-License-Identifier: Apache-2.0
 *
 * pop.propagate [Elek14 eq. 1-8]. A cell sends its light to its six neighbours, each what its distribution has in the neighbour's
 * solid angle, and what arrives is what the absorption leaves:
 *   light'  = sum of sent e^(-s_a t),   cosine' = sum of sent e^(-s_a t) cosine decay / sum of sent e^(-s_a t)
 *   decay     e^(-(1 - g) s_s t): events are Poisson (docs/errata.md); in print g^(s_s t)
 *   seen   += fluence light f_hg(mu, cosine g), before it is sent: what it scatters to the observer; in print f_hg(mu, cosine), the light itself
 * with the mean coefficients of both cells over t, the distance of their middles. Exponentials of means are products: each cell has a
 * factor for half of its way along each axis. What leaves a cell is computed once, not once a neighbour. A grid's planes are done in
 * place, with three planes of what they send in a ring.
 *
 * pop.paths: light that is isotropic in every cell walks at random. With a step d its square distance grows by d per length, in a medium by
 * 2 / s_tr, s_tr = s_a + (1 - g) s_s: the walk of cells diffuses as the medium does when a visit counts as s_tr d / 2 of d. A visit of light
 * of mean cosine a is taken as |a| + (1 - |a|) s_tr d / 2 (docs/errata.md); in print always 1.
 * Sides of cells that are no cubes: light along x crosses a width of the cell and not its depth, which fluence counts by.
 * Around a point the four edges of the octahedral map fold: the neighbour is mirrored along the same edge; what goes back from the
 * innermost shell comes out on the other side of it. */
#include "method/principal_ordinates/pop_kept.h"

void NPH_KERNEL(nph_pop_propagate)(const void *memory, const NphPopArrays *arrays, int number, const int iterations[3], void *worker);
double NPH_KERNEL(nph_pop_leaves)(const void *memory, const NphPopArrays *arrays, int number, int channel, void *worker);

enum { FRONT, BACK, ACROSS, UP, FRONT_COSINE, BACK_COSINE, ACROSS_COSINE, UP_COSINE };

/* Of a channel of a grid. What a visit counts: shown (1; at first that is half a cell, in print nothing) times
 * plain + wide beside (light to the sides crosses widths of cells that are no cubes) times |a| + (1 - |a|) (thick + thin density). */
typedef struct Flow {
    Real cone, side[2], see;               /* see: g, or in print 1 */
    Real shown, plain, wide, thick, thin;
    int count, row;                        /* cells of a plane, and of a row */
    int64_t stride, room, apart;           /* between rows of keep; of the ring; of facts */
    int64_t before, own, after;            /* planes of the ring: where cell 0 is */
} Flow;

/* Parts of the light of mean cosine a that go to the front, to the back, and between: r_pop_below at both cones with one division. */
R_INLINE void parts_of(Real cone, Real a, Real *front, Real *back, Real *beside) {
    Real away = R(1.0) - a, near = R(1.0) - cone, far = R(1.0) + cone, square = away * away, twice = R(2.0) * a, whole = R(1.0) + a;
    Real d = r_sqrt(r_max(square + twice * near, R(1e-18))), e = r_sqrt(r_max(square + twice * far, R(1e-18)));
    Real p = d * (whole + d), q = e * (whole + e), inverse = away / r_max(p * q, R(1e-30));
    Real below = far * q * inverse;
    *back = near * p * inverse;
    *front = R(1.0) - below;
    *beside = below - *back;
}

/* Of a plane. */
typedef struct From {
    const Real *light, *cosine, *keep, *density;
} From;

/* What a plane sends, into the ring, and what it shows. Rows of `facts`: mu, and twice `apart` further fluence (pop_kept.h). */
R_OUTLINE void send(const Flow *restrict flow, const From *restrict from, const Real *restrict facts, Real *restrict ring, Real *restrict seen) {
    const Flow f = *flow;
    Real *to = ring + f.own;
    const Real *light = from->light, *cosine = from->cosine, *keep = from->keep, *density = from->density, *mu = facts, *fluence = facts + 2 * f.apart;
    R_INDEPENDENT
    for (int i = 0; i < f.count; i++) { /* vec */
        Real a = cosine[i], front, back, beside, size = r_abs(a);
        parts_of(f.cone, a, &front, &back, &beside);
        Real way = f.shown * (f.plain + beside * f.wide) * (size + (R(1.0) - size) * (f.thick + f.thin * density[i]));
        seen[i] += fluence[i] * way * light[i] * r_pop_lobe(a * f.see, mu[i]);
        Real x = light[i] * keep[i] * beside * f.side[0], y = light[i] * keep[f.stride + i] * beside * f.side[1];
        Real z = light[i] * keep[2 * f.stride + i], bent = a * keep[5 * f.stride + i];
        to[FRONT * f.room + i] = z * front;
        to[BACK * f.room + i] = z * back;
        to[ACROSS * f.room + i] = x;
        to[UP * f.room + i] = y;
        to[FRONT_COSINE * f.room + i] = z * front * bent;
        to[BACK_COSINE * f.room + i] = z * back * bent;
        to[ACROSS_COSINE * f.room + i] = x * a * keep[3 * f.stride + i];
        to[UP_COSINE * f.room + i] = y * a * keep[4 * f.stride + i];
    }
}

/* What arrives in a plane; mask: 0 where a row begins, then 0 where one ends. */
R_OUTLINE void arrive(const Flow *restrict flow, const Real *restrict ring, const Real *restrict keep, const Real *restrict mask, Real *restrict light,
                      Real *restrict cosine) {
    const Flow f = *flow;
    const Real *before = ring + f.before, *own = ring + f.own, *after = ring + f.after, *across = own + ACROSS * f.room, *up = own + UP * f.room;
    const Real *across_cosine = own + ACROSS_COSINE * f.room, *up_cosine = own + UP_COSINE * f.room;
    for (int i = 0; i < f.count; i++) { /* vec */
        Real begin = mask[i], end = mask[f.room + i];
        Real x = keep[i] * (begin * across[i - 1] + end * across[i + 1]);
        Real y = keep[f.stride + i] * (up[i - f.row] + up[i + f.row]);
        Real z = keep[2 * f.stride + i] * (before[FRONT * f.room + i] + after[BACK * f.room + i]);
        Real sum = x + y + z;
        Real bent = keep[i] * keep[3 * f.stride + i] * (begin * across_cosine[i - 1] + end * across_cosine[i + 1]);
        bent += keep[f.stride + i] * keep[4 * f.stride + i] * (up_cosine[i - f.row] + up_cosine[i + f.row]);
        bent += keep[2 * f.stride + i] * keep[5 * f.stride + i] * (before[FRONT_COSINE * f.room + i] + after[BACK_COSINE * f.room + i]);
        light[i] = sum;
        cosine[i] = sum > R(0.0) ? r_min(r_max(bent / r_max(sum, R(1e-37)), R(-1.0)), R(1.0)) : R(0.0);
    }
}

R_OUTLINE void fill_keep(const Real *restrict density, Real *restrict keep, Real light, Real cosine, int64_t stride, int64_t count) {
    for (int64_t i = 0; i < count; i++) { /* vec */
        keep[i] = r_exp(-light * density[i]);
        keep[3 * stride + i] = r_exp(-cosine * density[i]);
    }
}

/* Factors for half the way through a cell. In print g^(s t), which for g = 0 is 0 wherever anything scatters. */
static void prepare_keep(const RPopScene *scene, const RPopGrid *grid, int channel, RPopCells *cells) {
    int64_t plane = (int64_t)grid->n[0] * grid->n[1];
    Real rate = scene->paper ? -r_log(r_max(r_abs(scene->g), R(1e-30))) : R(1.0) - scene->g;
    for (int32_t z = 0; z < grid->n[2]; z++) {
        Real lengths[3] = {grid->edge[0], grid->edge[1], grid->edge[2]};
        if (grid->radial) {
            lengths[2] = cells->depth[z];
            lengths[0] = lengths[1] = r_pop_radius(grid, (Real)z + R(0.5)) * r_sqrt(R_POP_FOUR_PI / (Real)plane);
        }
        for (int a = 0; a < 3; a++)
            fill_keep(cells->density + z * plane, cells->keep + a * cells->count + z * plane, R(0.5) * scene->sigma_a[channel] * lengths[a],
                      R(0.5) * rate * scene->sigma_s[channel] * lengths[a], cells->count, plane);
    }
}

/* Light that leaves the octahedral map across an edge comes back into the mirrored cell of the same edge. */
static void fold_edges(const Flow *f, const RPopGrid *grid, const Real *ring, const Real *keep, Real *light, Real *cosine) {
    const Real *own = ring + f->own;
    int32_t n = grid->n[0];
    for (int edge = 0; edge < 4; edge++)
        for (int32_t k = 0; k < n; k++) {
            int32_t fixed = edge & 1 ? n - 1 : 0, i = edge < 2 ? k * n + fixed : fixed * n + k;
            int32_t from = edge < 2 ? (n - 1 - k) * n + fixed : fixed * n + n - 1 - k;
            int axis = edge < 2 ? 0 : 1;
            Real light_from = keep[axis * f->stride + i] * own[(ACROSS + axis) * f->room + from];
            Real bent = keep[axis * f->stride + i] * keep[(3 + axis) * f->stride + i] * own[(ACROSS_COSINE + axis) * f->room + from];
            Real sum = light[i] + light_from;
            cosine[i] = sum > R(0.0) ? r_min(r_max((cosine[i] * light[i] + bent) / r_max(sum, R(1e-37)), R(-1.0)), R(1.0)) : R(0.0);
            light[i] = sum;
        }
}

/* The cell of the map on the other side of the point. */
static int32_t opposite(int32_t n, int32_t x, int32_t y) {
    int32_t u = 2 * x + 1 - n, v = 2 * y + 1 - n; /* times n in [-1, 1], odd */
    int32_t size_u = u < 0 ? -u : u, size_v = v < 0 ? -v : v;
    int32_t to_u = (u < 0 ? 1 : -1) * (n - size_v), to_v = (v < 0 ? 1 : -1) * (n - size_u);
    return (to_v + n - 1) / 2 * n + (to_u + n - 1) / 2;
}

/* What the innermost shell sends back, from the other side, as the plane before it. */
static void through_point(const Flow *f, const RPopGrid *grid, Real *ring) {
    int32_t n = grid->n[0];
    const Real *own = ring + f->own;
    Real *before = ring + f->before;
    for (int32_t y = 0; y < n; y++)
        for (int32_t x = 0; x < n; x++) {
            int32_t to = opposite(n, x, y), from = y * n + x;
            before[FRONT * f->room + to] = own[BACK * f->room + from];
            before[FRONT_COSINE * f->room + to] = own[BACK_COSINE * f->room + from];
        }
}

static void clear_plane(const Flow *f, Real *ring, int64_t at) {
    for (int k = 0; k < R_POP_RING; k++)
        for (int i = 0; i < f->count; i++) ring[at + k * f->room + i] = R(0.0);
}

typedef struct Channel {
    Flow flow;
    const RPopGrid *grid;
    const RPopCells *cells;
    const Real *mask;
    Real *ring, *light, *cosine, *seen, thin;
} Channel;

static void send_plane(Channel *c, int32_t z, Real *ring) {
    int64_t at = (int64_t)z * c->flow.count;
    From from = {c->light + at, c->cosine + at, c->cells->keep + at, c->cells->density + at};
    c->flow.thin = c->thin * c->cells->depth[z];
    send(&c->flow, &from, c->cells->mu + at, ring, c->seen + at);
}

/* All planes once, in place: what is under way is shown, and sent. */
static void iterate(Channel *c) {
    Flow *f = &c->flow;
    int64_t plane = f->count, size = R_POP_RING * f->room, first = f->row;
    int32_t planes = c->grid->n[2];
    f->before = first;
    f->own = first + size;
    f->after = first + 2 * size;
    clear_plane(f, c->ring, f->before);
    send_plane(c, 0, c->ring);
    if (c->grid->radial) through_point(f, c->grid, c->ring);
    for (int32_t z = 0; z < planes; z++) {
        int64_t at = z * plane, kept = f->own;
        f->own = f->after;
        if (z + 1 < planes) send_plane(c, z + 1, c->ring);
        else clear_plane(f, c->ring, f->after);
        f->own = kept;
        arrive(f, c->ring, c->cells->keep + at, c->mask, c->light + at, c->cosine + at);
        if (c->grid->radial) fold_edges(f, c->grid, c->ring, c->cells->keep + at, c->light + at, c->cosine + at);
        kept = f->before;
        f->before = f->own;
        f->own = f->after;
        f->after = kept;
    }
}

static Channel channel_of(const RPopScene *scene, const RPopGrid *grid, RPopCells *cells) {
    Channel c = {.grid = grid, .cells = cells};
    int cubes = !scene->paths || grid->radial;
    Real *mask;
    c.flow = (Flow){.cone = grid->cone, .side = {grid->side[0], grid->side[1]}, .see = scene->paper ? R(1.0) : scene->g, .plain = R(1.0),
                    .thick = scene->paths ? R(0.0) : R(1.0), .count = grid->n[0] * grid->n[1], .row = grid->n[0], .stride = cells->count,
                    .room = cells->room, .apart = cells->share - cells->mu};
    for (int a = 0; a < 2 && !cubes; a++) c.flow.wide += R(2.0) * grid->side[a] * (grid->edge[a] / grid->edge[2] - R(1.0));
    c.ring = cells->scratch;
    mask = c.ring + 3 * R_POP_RING * cells->room + 2 * grid->n[0];
    for (int64_t i = 0; i < 3 * R_POP_RING * cells->room + 2 * grid->n[0]; i++) c.ring[i] = R(0.0);
    for (int i = 0; i < c.flow.count; i++) {
        mask[i] = i % grid->n[0] > 0 ? R(1.0) : R(0.0);
        mask[cells->room + i] = i % grid->n[0] + 1 < grid->n[0] ? R(1.0) : R(0.0);
    }
    c.mask = mask;
    return c;
}

/* Light that was injected travels half a cell where it was scattered, in the mean. In print it is never accumulated. */
static Real shown_of(const RPopScene *scene, int iteration) { return iteration > 0 ? R(1.0) : scene->paper ? R(0.0) : R(0.5); }

/* Iterations [begin, end). A channel whose light has fallen below epsilon_L of what was injected stands still. In print the last iteration
 * also accumulates what it has sent; else that is left to the residuum. */
void NPH_KERNEL(nph_pop_propagate)(const void *memory, const NphPopArrays *arrays, int number, const int iterations[3], void *worker) {
    const RPopScene *scene = memory;
    const NphPopChoice *choice = &scene->choice;
    RPopGrid grid = r_pop_grid(scene, (const Real *)arrays->ordinate + (int64_t)number * NPH_POP_ROW, number);
    RPopCells cells;
    int64_t count = nph_pop_cells(grid.n), first = nph_pop_first(choice, number, choice->channels);
    r_pop_cells(scene, &grid, (const Real *)arrays->density + nph_pop_first(choice, number, 1), worker, &cells);
    Channel c = channel_of(scene, &grid, &cells);
    for (int channel = 0; channel < choice->channels; channel++) {
        double *power = arrays->power + ((int64_t)number * choice->channels + channel) * NPH_POP_POWERS;
        c.light = (Real *)arrays->light + first + channel * count;
        c.cosine = (Real *)arrays->cosine + first + channel * count;
        c.seen = (Real *)arrays->seen + first + channel * count;
        c.thin = scene->paths ? R(0.5) * (scene->sigma_a[channel] + scene->sigma_s[channel] * (R(1.0) - scene->g)) : R(0.0);
        prepare_keep(scene, &grid, channel, &cells);
        for (int m = iterations[0]; m < iterations[1] && power[NPH_POP_LEFT] > (double)scene->epsilon_l * power[NPH_POP_INJECTED]; m++) {
            c.flow.shown = shown_of(scene, m);
            iterate(&c);
            power[NPH_POP_LEFT] = r_pop_sum(c.light, count);
        }
        c.flow.shown = R(1.0);
        c.flow.own = c.flow.row;
        for (int32_t z = 0; z < grid.n[2] && scene->paper && iterations[1] == iterations[2]; z++) send_plane(&c, z, c.ring); /* shown, not sent */
    }
}

/* What the light of a channel loses through the border of the grid in the next iteration. */
double NPH_KERNEL(nph_pop_leaves)(const void *memory, const NphPopArrays *arrays, int number, int channel, void *worker) {
    const RPopScene *scene = memory;
    const NphPopChoice *choice = &scene->choice;
    RPopGrid grid = r_pop_grid(scene, (const Real *)arrays->ordinate + (int64_t)number * NPH_POP_ROW, number);
    RPopCells cells;
    int64_t count = nph_pop_cells(grid.n), first = nph_pop_first(choice, number, choice->channels) + channel * count, i = 0;
    double sum = 0.0;
    r_pop_cells(scene, &grid, (const Real *)arrays->density + nph_pop_first(choice, number, 1), worker, &cells);
    prepare_keep(scene, &grid, channel, &cells);
    for (int32_t z = 0; z < grid.n[2]; z++)
        for (int32_t y = 0; y < grid.n[1]; y++)
            for (int32_t x = 0; x < grid.n[0]; x++, i++) {
                Real front, back, beside, light = ((const Real *)arrays->light)[first + i];
                parts_of(grid.cone, ((const Real *)arrays->cosine)[first + i], &front, &back, &beside);
                int sides = (x == 0) + (x + 1 == grid.n[0]), ends = (y == 0) + (y + 1 == grid.n[1]);
                Real lost = grid.radial ? R(0.0) : beside * (grid.side[0] * (Real)sides * cells.keep[i] + grid.side[1] * (Real)ends * cells.keep[count + i]);
                if (z == 0 && !grid.radial) lost += back * cells.keep[2 * count + i];
                if (z + 1 == grid.n[2]) lost += front * cells.keep[2 * count + i];
                sum += (double)(light * lost);
            }
    return sum;
}
