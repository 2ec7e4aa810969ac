/* SPDX-License-Identifier: Apache-2.0
 *
 * pop.propagate [Elek14 eq. 1-8]: one iteration of all grids, one work-item a cell (of the grid and channel that its second number
 * names). A cell gathers what its six neighbours send: it reads one pair of buffers and writes another, and the host lets them take turns.
 * docs/principal_ordinates.md has the formulas. Products and sums stand in the reference's order, so that no bit differs. */
#include "nephos/portable.h"
#include "grid.h"

#define FOUR_PI 12.566370614359173f

/* A grid's channel before the iteration. */
typedef struct Before {
    __global const Grid *grid;
    __global const float *density, *light, *cosine; /* of its first cell */
} Before;

/* Light, and light times its mean cosine. */
typedef struct Sent {
    float light, bent;
} Sent;

static float larger(float a, float b) { return a > b ? a : b; }

/* Lengths ----------------------------------------------------------------------------------------------------------- */

static float radius_of(__global const Grid *g, float shell) { return g->inner * nph_expf(shell * g->log_ratio); }

/* Of a cell of plane z along an axis, in metres. Shells of a point: the edges of a square of the cell's mean area. */
static float length_of(__global const Grid *g, int axis, int z) {
    if (!g->radial) return g->edge[axis];
    if (axis == 2) return radius_of(g, (float)(z + 1)) - radius_of(g, (float)z);
    return radius_of(g, (float)z + 0.5f) * nph_sqrtf(FOUR_PI / (float)(g->n[0] * g->n[1]));
}

/* On half the way through a cell: the part of the light that absorption leaves. */
static float light_left(__global const Grid *g, float length, float density) { return nph_expf(-(0.5f * g->sigma_a * length) * density); }

/* The part of the mean cosine that scattering leaves. */
static float cosine_left(__global const Grid *g, float length, float density) {
#ifdef PLANT_PRINTED_DECAY
    float rate = -nph_logf(larger(nph_absf(g->g), 1e-30f));
#else
    float rate = 1.0f - g->g;
#endif
    return nph_expf(-(0.5f * rate * g->sigma_s * length) * density);
}

/* What a cell sends ------------------------------------------------------------------------------------------------- */

/* Parts of light of mean cosine a: into the cone to the next cell, into that to the one before, and between them. */
static void parts_of(float cone, float a, float *front, float *back, float *beside) {
    float away = 1.0f - a, fall = 1.0f - cone, rise = 1.0f + cone, square = away * away, twice = 2.0f * a, whole = 1.0f + a;
    float d = nph_sqrtf(larger(square + twice * fall, 1e-18f)), e = nph_sqrtf(larger(square + twice * rise, 1e-18f));
    float p = d * (whole + d), q = e * (whole + e), inverse = away / larger(p * q, 1e-30f);
    float below = rise * q * inverse;
    *back = fall * p * inverse;
    *front = 1.0f - below;
    *beside = below - *back;
}

/* To the next cell along the light, or (forward 0) to the one before. */
static Sent sent_along(const Before *b, int cell, int z, int forward) {
    float a = b->cosine[cell], front, back, beside, length = length_of(b->grid, 2, z);
    parts_of(b->grid->cone, a, &front, &back, &beside);
    float all = b->light[cell] * light_left(b->grid, length, b->density[cell]), bent = a * cosine_left(b->grid, length, b->density[cell]);
    Sent sent = {all * (forward ? front : back), all * (forward ? front : back) * bent};
    return sent;
}

/* To each of the two cells beside it along x or y. */
static Sent sent_across(const Before *b, int cell, int z, int axis) {
    float a = b->cosine[cell], front, back, beside, length = length_of(b->grid, axis, z);
    parts_of(b->grid->cone, a, &front, &back, &beside);
    float light = b->light[cell] * light_left(b->grid, length, b->density[cell]) * beside * b->grid->side[axis];
    Sent sent = {light, light * a * cosine_left(b->grid, length, b->density[cell])};
    return sent;
}

/* What a cell gets -------------------------------------------------------------------------------------------------- */

/* The cell of the octahedral map on the other side of the point, in the innermost shell. */
static int opposite(int n, int x, int y) {
    int u = 2 * x + 1 - n, v = 2 * y + 1 - n; /* times n in [-1, 1], odd */
    int to_u = (u < 0 ? 1 : -1) * (n - (int)abs(v)), to_v = (v < 0 ? 1 : -1) * (n - (int)abs(u));
    return (to_v + n - 1) / 2 * n + (to_u + n - 1) / 2;
}

/* From the neighbour along an axis, the one before (side 0) or after. Nothing comes in through the border of a box; into the innermost
 * shell comes what goes back from its other side; around the edges of the octahedral map see from_folds. */
static Sent from_neighbour(const Before *b, const int at[3], int cell, int axis, int side) {
    __global const Grid *g = b->grid;
    Sent nothing = {0.0f, 0.0f};
    int step = axis == 0 ? 1 : axis == 1 ? g->n[0] : g->n[0] * g->n[1], inside = side ? at[axis] + 1 < g->n[axis] : at[axis] > 0;
    int from = side ? cell + step : cell - step;
    if (!inside && axis == 2 && side == 0 && g->radial) return sent_along(b, opposite(g->n[0], at[0], at[1]), 0, 0);
    if (!inside) return nothing;
#ifdef PLANT_SWAPPED_DIRECTION
    if (axis == 2) return sent_along(b, from, side ? at[2] + 1 : at[2] - 1, side);
#else
    if (axis == 2) return sent_along(b, from, side ? at[2] + 1 : at[2] - 1, !side);
#endif
    return sent_across(b, from, at[2], axis);
}

static float mean_cosine(float bent, float light) {
    float mean = bent / larger(light, 1e-37f);
    return light > 0.0f ? nph_minf(larger(mean, -1.0f), 1.0f) : 0.0f;
}

/* Light that leaves the octahedral map across an edge comes back into the mirrored cell of the same edge. */
static void from_folds(const Before *b, const int at[3], int cell, const float kept[3], const float bends[3], Sent *all, float *cosine) {
    int n = b->grid->n[0];
    for (int edge = 0; edge < 4; edge++) {
        int axis = edge < 2 ? 0 : 1;
        if (at[axis] != (edge & 1 ? n - 1 : 0)) continue;
        Sent sent = sent_across(b, axis == 0 ? cell + (n - 1 - 2 * at[1]) * n : cell + n - 1 - 2 * at[0], at[2], axis);
        float sum = all->light + kept[axis] * sent.light;
        *cosine = mean_cosine(*cosine * all->light + kept[axis] * bends[axis] * sent.bent, sum);
        all->light = sum;
    }
}

/* What a cell shows the observer ------------------------------------------------------------------------------------ */

/* Middle of a cell, scene-local, and the way of its light. */
static void place_of(__global const Grid *g, const int at[3], float p[3], float d[3]) {
    float u = (float)at[0] + 0.5f, v = (float)at[1] + 0.5f, w = (float)at[2] + 0.5f;
    if (!g->radial) {
        u = g->low[0] + u * g->edge[0];
        v = g->low[1] + v * g->edge[1];
        w = g->low[2] + w * g->edge[2];
        for (int a = 0; a < 3; a++) {
            p[a] = g->middle[a] + u * g->axis[a] + v * g->axis[3 + a] + w * g->axis[6 + a];
            d[a] = g->axis[6 + a];
        }
        return;
    }
    float r = radius_of(g, w);
    u = 2.0f * u / (float)g->n[0] - 1.0f;
    v = 2.0f * v / (float)g->n[1] - 1.0f;
    float x = u, y = v, z = 1.0f - nph_absf(u) - nph_absf(v);
    if (z < 0.0f) {
        x = (1.0f - nph_absf(v)) * (u < 0.0f ? -1.0f : 1.0f);
        y = (1.0f - nph_absf(u)) * (v < 0.0f ? -1.0f : 1.0f);
    }
    float inverse = 1.0f / nph_sqrtf(x * x + y * y + z * z);
    d[0] = x * inverse;
    d[1] = y * inverse;
    d[2] = z * inverse;
    for (int a = 0; a < 3; a++) p[a] = g->middle[a] + r * d[a];
}

/* Cosine between the way of the light and the way to the observer. */
static float cosine_to_observer(__global const Grid *g, const int at[3]) {
    float p[3], d[3], from = g->parallel ? 0.0f : 1.0f;
    place_of(g, at, p, d);
    float x = g->observer[0] - from * p[0], y = g->observer[1] - from * p[1], z = g->observer[2] - from * p[2];
    float mu = (x * d[0] + y * d[1] + z * d[2]) / nph_sqrtf(larger(x * x + y * y + z * z, 1e-30f));
    return nph_minf(larger(mu, -1.0f), 1.0f);
}

/* Light over the area across it; a point's is power over that of the cell's shell. */
static float fluence_of(__global const Grid *g, const int at[3]) {
    if (!g->radial) return 1.0f;
    float inside = radius_of(g, (float)at[2]), outside = radius_of(g, (float)(at[2] + 1));
    float volume = (outside * outside + outside * inside + inside * inside) * 0.33333333333333333f; /* over thickness and solid angle */
    float u = 2.0f * ((float)at[0] + 0.5f) / (float)g->n[0] - 1.0f, v = 2.0f * ((float)at[1] + 0.5f) / (float)g->n[1] - 1.0f;
    return 1.0f / (octahedron_solid(u, v, g->n[0]) * g->per_solid * volume);
}

/* Scattered once more, before it is sent. A visit counts as an edge of the cell; light without a direction as the path that diffusion
 * has there (thin), light to the sides of cells that are no cubes by their width (wide). */
static float shown_by(const Before *b, const int at[3], int cell) {
    __global const Grid *g = b->grid;
    float a = b->cosine[cell], mu = cosine_to_observer(g, at), front, back, beside, size = nph_absf(a), lobe = a * g->g;
    parts_of(g->cone, a, &front, &back, &beside);
    float way = g->shown * (1.0f + beside * g->wide) * (size + (1.0f - size) * (g->thick + g->thin * length_of(g, 2, at[2]) * b->density[cell]));
    return fluence_of(g, at) * way * b->light[cell] * nph_hg_valuef(lobe, larger(1.0f - nph_absf(lobe), 1e-6f), nph_anglef(mu));
}

/* The kernels ------------------------------------------------------------------------------------------------------- */

__kernel void propagate(__global const Grid *grids, __global const float *density, __global const float *light, __global const float *cosine,
                        __global float *light_after, __global float *cosine_after, __global float *seen) {
    __global const Grid *g = grids + get_global_id(1);
    int cell = (int)get_global_id(0), number = g->first_number + cell;
    if (cell >= g->n[0] * g->n[1] * g->n[2]) return;
    if (g->still) {
        light_after[number] = light[number];
        cosine_after[number] = cosine[number];
        return;
    }
    Before b = {g, density + g->first_cell, light + g->first_number, cosine + g->first_number};
    int at[3] = {cell % g->n[0], cell / g->n[0] % g->n[1], cell / (g->n[0] * g->n[1])};
    float kept[3], bends[3];
    Sent all = {0.0f, 0.0f};
    seen[number] += shown_by(&b, at, cell);
    for (int axis = 0; axis < 3; axis++) {
        float length = length_of(g, axis, at[2]);
        Sent low = from_neighbour(&b, at, cell, axis, 0), high = from_neighbour(&b, at, cell, axis, 1);
#ifdef PLANT_HALF_AN_EDGE
        kept[axis] = 1.0f;
#else
        kept[axis] = light_left(g, length, b.density[cell]);
#endif
        bends[axis] = cosine_left(g, length, b.density[cell]);
        all.light += kept[axis] * (low.light + high.light);
        all.bent += kept[axis] * bends[axis] * (low.bent + high.bent);
    }
    float mean = mean_cosine(all.bent, all.light);
    if (g->radial) from_folds(&b, at, cell, kept, bends, &all, &mean);
    light_after[number] = all.light;
    cosine_after[number] = mean;
}

/* Sixteen sums of what is under way in a grid's channel, of every sixteenth cell each: the host adds them up in double. */
__kernel void add_up(__global const Grid *grids, __global const float *light, __global float *sums) {
    __global const Grid *g = grids + get_global_id(1);
    int lane = (int)get_global_id(0), count = g->n[0] * g->n[1] * g->n[2];
    float sum = 0.0f;
    if (lane >= 16) return;
    for (int i = lane; i < count; i += 16) sum += light[g->first_number + i];
    sums[16 * get_global_id(1) + lane] = sum;
}
