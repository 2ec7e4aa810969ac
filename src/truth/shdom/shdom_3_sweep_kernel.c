/* SPDX-License-Identifier: Apache-2.0
 *
 * shdom.sweep: the radiance of one ordinate at every point, from the point where its ray last crossed a plane of the grid [Kunasz88].
 * Cells are all alike and have one extinction each, so that plane, the place on it and the length are the same for all points: with
 * tau = sigma length, e = e^-tau and a source function S + d, S linear between both places and d the same all over the cell,
 *   L = e L_up + w_up S_up + w S + (1 - e) d,      w = 1 - (1 - e) / tau,  w_up = (1 - e) / tau - e      [Kunasz88]
 * A sun whose optical depth b is linear between both places adds p E e^-b tau (1 - e^-x) / x, x = tau + b_up - b: its light, and so what it
 * scatters, falls off exponentially, however thick the cell.
 * L_up and S_up are interpolated on the plane, which is one across the axis along which the ray is fastest: points of a plane wait for
 * the plane before it only. Where sides repeat along that axis, the first plane waits for the last one: rounds, until they agree.
 * The mean radiance of a cell is what keeps its books, from the means over its faces,
 *   mean L = mean S + d - sum over axes of f_a (L_out - L_in) / tau,      f_a: cells along axis a per step
 * so that what cells scatter, who have their own source for it, is what does not come out: no light is gained or lost between points.
 * Cells that are nearly empty, which have no books to keep, take it from their corners: thin^2 parts to tau^2.
 * [density, share, bubble, source -> radiance, mean] */
#include <assert.h>
#include <string.h>

#include "truth/shdom/shdom_kernels.h"

int64_t NPH_KERNEL(nph_shdom_sweep)(const NphShdomSweep *sweep);

enum { ROUNDS_MAX = 4096 };
#if NPH_PRECISION == 32
#define SETTLED 1e-6f
#else
#define SETTLED 1e-12
#endif

/* Of a row of points: where its rays come from, radiance and four points of the source. bubble: d. */
typedef struct Row {
    const Real *up, *S[4], *own, *density, *share, *bubble;
    Real weight[4], depth; /* depth: of density 1 */
} Row;

/* e, w and w_up; series where the differences lose their digits. */
typedef struct Parts {
    Real passes, own, far;
} Parts;

R_INLINE Parts parts_of(Real t) {
    Real e = r_exp(-t), safe = t < R(0.0625) ? R(1.0) : t;
    Real near = t * (R(1.0) / R(6.0) - t * (R(1.0) / R(24.0) - t * (R(1.0) / R(120.0) - t * (R(1.0) / R(720.0) - t * (R(1.0) / R(5040.0) -
                    t * (R(1.0) / R(40320.0) - t * (R(1.0) / R(362880.0))))))));
    Real away = t * (R(1.0) / R(3.0) - t * (R(1.0) / R(8.0) - t * (R(1.0) / R(30.0) - t * (R(1.0) / R(144.0) - t * (R(1.0) / R(840.0) -
                    t * (R(1.0) / R(5760.0) - t * (R(1.0) / R(45360.0))))))));
    int thin = t < R(0.0625);
    Real own = thin ? t * (R(0.5) - near) : R(1.0) - (R(1.0) - e) / safe, far = thin ? t * (R(0.5) - away) : (R(1.0) - e) - own;
    Parts parts = {e, own, far};
    return parts;
}

R_INLINE Real step_at(const Row *row, int64_t point, int64_t cell, Real up) {
    Parts parts = parts_of(row->density[cell] * row->depth);
    Real S = row->weight[0] * row->S[0][point] + row->weight[1] * row->S[1][point] + row->weight[2] * row->S[2][point] + row->weight[3] * row->S[3][point];
    return parts.passes * up + row->share[cell] * (parts.far * S + parts.own * row->own[point]) + (R(1.0) - parts.passes) * row->bubble[cell];
}

R_OUTLINE void step_row(const Row *given, int count, Real *restrict out) {
    const Row row = *given;
    const Real *restrict density = row.density, *restrict share = row.share, *restrict bubble = row.bubble, *restrict up = row.up;
    const Real *restrict S0 = row.S[0], *restrict S1 = row.S[1], *restrict S2 = row.S[2], *restrict S3 = row.S[3], *restrict own = row.own;
    for (int i = 0; i < count; i++) { /* vec */
        Parts parts = parts_of(density[i] * row.depth);
        Real S = row.weight[0] * S0[i] + row.weight[1] * S1[i] + row.weight[2] * S2[i] + row.weight[3] * S3[i];
        out[i] = parts.passes * up[i] + share[i] * (parts.far * S + parts.own * own[i]) + (R(1.0) - parts.passes) * bubble[i];
    }
}

/* A sun's depth of density at points, own and four on the plane before, as of a row. */
typedef struct BeamRow {
    const Real *own, *up[4], *density;
    Real weight[4], depth, extinction, scattered;
} BeamRow;

/* e^-b tau (1 - e^-x) / x, from the end that is larger, so that nothing overflows. */
R_INLINE Real beam_part(Real tau, Real here, Real up) {
    Real away = tau + up, x = r_abs(away - here), safe = x < R(0.0625) ? R(1.0) : x;
    Real small = R(1.0) - x * (R(1.0) / R(2.0) - x * (R(1.0) / R(6.0) - x * (R(1.0) / R(24.0) - x * (R(1.0) / R(120.0) - x * (R(1.0) / R(720.0) -
                     x * (R(1.0) / R(5040.0) - x * (R(1.0) / R(40320.0))))))));
    return tau * r_exp(-r_min(here, away)) * (x < R(0.0625) ? small : (R(1.0) - r_exp(-x)) / safe);
}

R_INLINE Real beam_at(const BeamRow *row, int64_t point, int64_t cell) {
    Real up = row->weight[0] * row->up[0][point] + row->weight[1] * row->up[1][point] + row->weight[2] * row->up[2][point] + row->weight[3] * row->up[3][point];
    return row->scattered * beam_part(row->density[cell] * row->depth, row->extinction * row->own[point], row->extinction * up);
}

R_OUTLINE void beam_row(const BeamRow *given, int count, Real *restrict out) {
    const BeamRow row = *given;
    const Real *restrict density = row.density, *restrict own = row.own;
    const Real *restrict up0 = row.up[0], *restrict up1 = row.up[1], *restrict up2 = row.up[2], *restrict up3 = row.up[3];
    for (int i = 0; i < count; i++) { /* vec */
        Real up = row.weight[0] * up0[i] + row.weight[1] * up1[i] + row.weight[2] * up2[i] + row.weight[3] * up3[i];
        out[i] += row.scattered * beam_part(density[i] * row.depth, row.extinction * own[i], row.extinction * up);
    }
}

R_OUTLINE void beam_mean_row(const Real *restrict density, const Real *restrict mean, const Real factors[3], int count, Real *restrict out) {
    const Real depth = factors[0], scattered = factors[1], thin = factors[2];
    for (int i = 0; i < count; i++) { /* vec */
        Real tau = density[i] * depth, thick = tau * tau;
        out[i] += scattered * mean[i] * (thick / (thick + thin));
    }
}

/* Of a row of cells: four rows of corners, own and upstream along c (bit 0) and a (bit 1), each at a cell's two ends along b; what leaves
 * through the downstream faces less what enters. */
typedef struct Books {
    const Real *L[4], *S[4], *density, *share, *bubble;
    Real weight[4][2], depth, thin; /* thin: tau^2 of a cell that takes half of its mean from its corners */
} Books;

R_INLINE Real mean_of(const Books *books, int64_t at, int64_t next, int64_t cell) {
    Real tau = books->density[cell] * books->depth, leaves = R(0.0), S = R(0.0), L = R(0.0);
    for (int k = 0; k < 4; k++) {
        leaves += books->weight[k][0] * books->L[k][at] + books->weight[k][1] * books->L[k][next];
        S += books->S[k][at] + books->S[k][next];
        L += books->L[k][at] + books->L[k][next];
    }
    Real part = R(1.0) / (tau * tau + books->thin), kept = R(0.125) * S * books->share[cell] + books->bubble[cell];
    return part * (tau * (tau * kept - leaves) + books->thin * R(0.125) * L);
}

R_OUTLINE void mean_row(const Books *given, int count, Real *restrict out) {
    const Books books = *given;
    const Real *restrict density = books.density, *restrict share = books.share, *restrict bubble = books.bubble;
    const Real *restrict L0 = books.L[0], *restrict L1 = books.L[1], *restrict L2 = books.L[2], *restrict L3 = books.L[3];
    const Real *restrict S0 = books.S[0], *restrict S1 = books.S[1], *restrict S2 = books.S[2], *restrict S3 = books.S[3];
    for (int i = 0; i < count; i++) { /* vec */
        Real tau = density[i] * books.depth, part = R(1.0) / (tau * tau + books.thin);
        Real leaves = books.weight[0][0] * L0[i] + books.weight[0][1] * L0[i + 1] + books.weight[1][0] * L1[i] + books.weight[1][1] * L1[i + 1] +
                      books.weight[2][0] * L2[i] + books.weight[2][1] * L2[i + 1] + books.weight[3][0] * L3[i] + books.weight[3][1] * L3[i + 1];
        Real S = S0[i] + S0[i + 1] + S1[i] + S1[i + 1] + S2[i] + S2[i + 1] + S3[i] + S3[i + 1];
        Real L = L0[i] + L0[i + 1] + L1[i] + L1[i + 1] + L2[i] + L2[i + 1] + L3[i] + L3[i + 1], kept = R(0.125) * S * share[i] + bubble[i];
        out[i] = part * (tau * (tau * kept - leaves) + books.thin * R(0.125) * L);
    }
}

/* One ordinate under way: axes a (fastest), b (along rows), c. */
typedef struct Way {
    const NphShdomSweep *sweep;
    int axis[3], sign[3];
    int64_t points[3], cells[3], point_step[3], cell_step[3];
    Real weight[4], part[3], depth, border;
    const Real *density, *share, *bubble, *projected;
    Real *radiance, *mean, *rows[2];  /* rows: of a plane, with two places more at either end; as its radiance comes from it */
    Real cubic[2][4];                 /* along b and c: behind, own, upstream, beyond */
} Way;

/* sum over coefficients of basis times source, at every point. */
R_OUTLINE void add_terms(const Real basis[4], const Real *restrict a, int64_t apart, int count, Real *restrict out) {
    const Real *restrict b = a + apart, *restrict c = b + apart, *restrict d = c + apart;
    const Real p = basis[0], q = basis[1], r = basis[2], s = basis[3];
    for (int i = 0; i < count; i++) /* vec */
        out[i] = (((out[i] + p * a[i]) + q * b[i]) + r * c[i]) + s * d[i];
}

R_OUTLINE void add_term(Real basis, const Real *restrict a, int count, Real *restrict out) {
    for (int i = 0; i < count; i++) /* vec */
        out[i] += basis * a[i];
}

static void project(const NphShdomSweep *sweep, Real *out) {
    int64_t points = sweep->grid->point_count;
    const Real *source = sweep->source;
    for (int64_t first = 0; first < points; first += NPH_SHDOM_BLOCK) {
        int count = (int)(points - first < NPH_SHDOM_BLOCK ? points - first : NPH_SHDOM_BLOCK), t = 0;
        memset(out + first, 0, sizeof *out * (size_t)count);
        for (; t + 4 <= sweep->coefficients; t += 4) {
            const Real basis[4] = {(Real)sweep->basis[t], (Real)sweep->basis[t + 1], (Real)sweep->basis[t + 2], (Real)sweep->basis[t + 3]};
            add_terms(basis, source + t * points + first, points, count, out + first);
        }
        for (; t < sweep->coefficients; t++) add_term((Real)sweep->basis[t], source + t * points + first, count, out + first);
    }
}

/* The neighbour of a point upstream along an axis; -1: the ray comes in from outside. */
R_INLINE int64_t before(const Way *way, int k, int64_t at) {
    int64_t n = way->points[k], up = at - way->sign[k];
    if (up >= 0 && up < n) return up;
    return way->sweep->grid->periodic[way->axis[k]] ? (up < 0 ? n - 1 : 0) : -1;
}

/* The cell between both; along an axis that repeats the last cell lies before the first point. */
R_INLINE int64_t between(const Way *way, int k, int64_t at) {
    int64_t cell = way->sign[k] > 0 ? at - 1 : at;
    return cell < 0 ? way->cells[k] - 1 : cell;
}

/* Corner i of a plane's four: bit 0 upstream along b, bit 1 along c. */
static void set_row(const Way *way, const int64_t planes[2], const int64_t b[2], const int64_t c[2], Row *row) {
    row->own = way->projected + planes[0] * way->point_step[0] + b[0] * way->point_step[1] + c[0] * way->point_step[2];
    row->depth = way->depth;
    for (int i = 0; i < 4; i++) {
        row->S[i] = way->projected + planes[1] * way->point_step[0] + b[i & 1] * way->point_step[1] + c[i >> 1] * way->point_step[2];
        row->weight[i] = way->weight[i];
    }
}

/* The sun's depths at the points of a row of the source. */
static void set_beam(const Way *way, int beam, const Row *row, BeamRow *out) {
    const NphShdomBeam *of = &way->sweep->beams[beam];
    const Real *depth = of->depth;
    out->own = depth + (row->own - way->projected);
    out->density = row->density;
    out->depth = way->depth;
    out->extinction = (Real)way->sweep->extinction;
    out->scattered = (Real)of->scattered;
    for (int i = 0; i < 4; i++) {
        out->up[i] = depth + (row->S[i] - way->projected);
        out->weight[i] = row->weight[i];
    }
}

/* A point by itself: at the rim, or at the seam of sides that repeat. */
static Real step_point(const Way *way, const int64_t at[3]) {
    int64_t up[3], cell = 0;
    for (int k = 0; k < 3; k++) {
        up[k] = before(way, k, at[k]);
        if (up[k] < 0) return way->border;
        cell += between(way, k, at[k]) * way->cell_step[k];
    }
    Row row = {.density = way->density, .share = way->share, .bubble = way->bubble};
    set_row(way, (int64_t[2]){at[0], up[0]}, (int64_t[2]){at[1], up[1]}, (int64_t[2]){at[2], up[2]}, &row);
    Real L = step_at(&row, 0, cell, way->rows[1][at[1]]);
    for (int n = 0; n < way->sweep->beam_count; n++) {
        BeamRow beam;
        set_beam(way, n, &row, &beam);
        L += beam_at(&beam, 0, cell);
    }
    return L;
}

/* All points of a row but the one at its upstream end. */
static void step_inner(const Way *way, const int64_t planes[2], const int64_t lines[2], int64_t cell) {
    int64_t first = way->sign[1] > 0, steps = way->point_step[1];
    Real *out = way->radiance + planes[0] * way->point_step[0] + lines[0] * way->point_step[2] + first * steps;
    Row row = {.up = way->rows[1] + first, .density = way->density + cell, .share = way->share + cell, .bubble = way->bubble + cell};
    set_row(way, planes, (int64_t[2]){first, first - way->sign[1]}, lines, &row);
    int count = (int)way->points[1] - 1;
    if (steps == 1) step_row(&row, count, out);
    else
        for (int i = 0; i < count; i++) out[i * steps] = step_at(&row, i * steps, i * way->cell_step[1], row.up[i]);
    for (int n = 0; n < way->sweep->beam_count; n++) {
        BeamRow beam;
        set_beam(way, n, &row, &beam);
        if (steps == 1) beam_row(&beam, count, out);
        else
            for (int i = 0; i < count; i++) out[i * steps] += beam_at(&beam, i * steps, i * way->cell_step[1]);
    }
}

R_OUTLINE void mix_rows(const Real weight[4], const Real *const from[4], int count, Real *restrict out) {
    const Real *restrict a = from[0], *restrict b = from[1], *restrict c = from[2], *restrict d = from[3];
    const Real p = weight[0], q = weight[1], r = weight[2], s = weight[3];
    for (int i = 0; i < count; i++) /* vec */
        out[i] = (p * a[i] + q * b[i]) + (r * c[i] + s * d[i]);
}

/* Places along axis c: behind a point, its own, upstream, beyond; where a side is open, what would lie outside goes on in a line. */
static void four_places(const Way *way, const Real cubic[4], int64_t at, int64_t place[4], Real weight[4]) {
    int64_t n = way->points[2];
    for (int i = 0; i < 4; i++) {
        place[i] = at + (1 - i) * way->sign[2];
        weight[i] = cubic[i];
        if (way->sweep->grid->periodic[way->axis[2]]) place[i] = (place[i] % n + n) % n;
    }
    for (int i = 0; i < 4; i += 3) {
        int inner = i == 0 ? 1 : 2, outer = i == 0 ? 2 : 1;
        if (place[i] >= 0 && place[i] < n) continue;
        weight[inner] += R(2.0) * weight[i];
        weight[outer] -= weight[i];
        weight[i] = R(0.0);
        place[i] = place[inner];
    }
}

/* Radiance of the plane before where rays through a row come from: across it first, then along it. */
static void fill_up(const Way *way, int64_t plane, int64_t c) {
    int64_t place[4], n = way->points[1], steps = way->point_step[1];
    Real weight[4], *across = way->rows[0];
    const Real *from[4];
    four_places(way, way->cubic[1], c, place, weight);
    for (int i = 0; i < 4; i++) from[i] = way->radiance + plane * way->point_step[0] + place[i] * way->point_step[2];
    if (steps == 1) mix_rows(weight, from, (int)n, across);
    else
        for (int64_t b = 0; b < n; b++)
            across[b] = (weight[0] * from[0][b * steps] + weight[1] * from[1][b * steps]) + (weight[2] * from[2][b * steps] + weight[3] * from[3][b * steps]);
    int periodic = way->sweep->grid->periodic[way->axis[1]];
    for (int64_t i = 1; i <= 2; i++) {
        across[-i] = periodic ? across[((-i) % n + n) % n] : across[0] + (Real)i * (across[0] - across[1]);
        across[n - 1 + i] = periodic ? across[(i - 1) % n] : across[n - 1] + (Real)i * (across[n - 1] - across[n - 2]);
    }
    for (int i = 0; i < 4; i++) from[i] = across + (1 - i) * way->sign[1];
    mix_rows(way->cubic[0], from, (int)n, way->rows[1]);
}

/* at: of the plane along the fastest axis. */
static void step_plane(const Way *way, int64_t at) {
    int64_t up = before(way, 0, at), slab = between(way, 0, at), last = way->sign[1] > 0 ? 0 : way->points[1] - 1;
    for (int64_t c = 0; c < way->points[2]; c++) {
        int64_t above = before(way, 2, c), place[3] = {at, last, c}, row = at * way->point_step[0] + c * way->point_step[2];
        if (up >= 0 && above >= 0) fill_up(way, up, c);
        way->radiance[row + last * way->point_step[1]] = step_point(way, place);
        if (up >= 0 && above >= 0) {
            step_inner(way, (int64_t[2]){at, up}, (int64_t[2]){c, above}, slab * way->cell_step[0] + between(way, 2, c) * way->cell_step[2]);
            continue;
        }
        for (int64_t b = 0; b < way->points[1]; b++) way->radiance[row + b * way->point_step[1]] = way->border;
    }
}

/* A round through all planes; how much the first one changed, over the largest value in it. */
static Real step_round(const Way *way, Real *kept) {
    int64_t n = way->points[0];
    Real change = R(0.0), most = R(0.0);
    for (int64_t i = 0; i < n; i++) {
        int64_t at = way->sign[0] > 0 ? i : n - 1 - i, here = at * way->point_step[0], count = 0;
        for (int64_t j = 0; i == 0 && kept && j < way->points[1] * way->points[2]; j++)
            kept[count++] = way->radiance[here + j % way->points[1] * way->point_step[1] + j / way->points[1] * way->point_step[2]];
        step_plane(way, at);
        for (int64_t j = 0; kept && j < count; j++) {
            Real now = way->radiance[here + j % way->points[1] * way->point_step[1] + j / way->points[1] * way->point_step[2]];
            change = r_max(change, r_abs(now - kept[j]));
            most = r_max(most, r_abs(now));
        }
    }
    return change > SETTLED * most ? R(1.0) : R(0.0);
}

/* What suns are scattered in all cells, once they are known without. */
static void beam_means(const Way *way) {
    int64_t cells = way->sweep->grid->cell_count;
    for (int n = 0; n < way->sweep->beam_count; n++) {
        const Real factors[3] = {way->depth, (Real)way->sweep->beams[n].scattered, (Real)(way->sweep->thin * way->sweep->thin)};
        for (int64_t first = 0; first < cells; first += NPH_SHDOM_BLOCK)
            beam_mean_row(way->density + first, (const Real *)way->sweep->beams[n].mean + first, factors,
                          (int)(cells - first < NPH_SHDOM_BLOCK ? cells - first : NPH_SHDOM_BLOCK), way->mean + first);
    }
}

/* Means of the cells between a plane and the one before it. */
static void mean_plane(const Way *way, int64_t at) {
    int64_t up = before(way, 0, at), steps = way->point_step[1], n = way->points[1];
    for (int64_t c = 0; c < way->points[2] && up >= 0; c++) {
        int64_t above = before(way, 2, c), cell = between(way, 0, at) * way->cell_step[0] + between(way, 2, c) * way->cell_step[2];
        if (above < 0) continue;
        Books books = {.density = way->density + cell, .share = way->share + cell, .bubble = way->bubble + cell, .depth = way->depth,
                       .thin = (Real)(way->sweep->thin * way->sweep->thin)};
        for (int k = 0; k < 4; k++) {
            int64_t row = (k & 2 ? up : at) * way->point_step[0] + (k & 1 ? above : c) * way->point_step[2];
            Real across = (k & 2 ? -way->part[0] : way->part[0]) + (k & 1 ? -way->part[2] : way->part[2]);
            books.L[k] = way->radiance + row;
            books.S[k] = way->projected + row;
            for (int e = 0; e < 2; e++) books.weight[k][e] = R(0.25) * (across + (e == (way->sign[1] > 0) ? way->part[1] : -way->part[1]));
        }
        if (steps == 1) mean_row(&books, (int)n - 1, way->mean + cell);
        else
            for (int64_t b = 0; b < n - 1; b++) way->mean[cell + b * way->cell_step[1]] = mean_of(&books, b * steps, (b + 1) * steps, b * way->cell_step[1]);
        if (way->cells[1] == n) way->mean[cell + (n - 1) * way->cell_step[1]] = mean_of(&books, (n - 1) * steps, 0, (n - 1) * way->cell_step[1]);
    }
}

/* Weights of four places at 1, 0, -1, -2 for what lies at -f: Lagrange's polynomial of third degree, or a line. */
static void set_cubic(double f, int cubic, Real weight[4]) {
    double of[4] = {0.0, 1.0 - f, f, 0.0};
    if (cubic) {
        of[0] = -f * (f - 1.0) * (f - 2.0) / 6.0;
        of[1] = 0.5 * (f + 1.0) * (f - 1.0) * (f - 2.0);
        of[2] = -0.5 * (f + 1.0) * f * (f - 2.0);
        of[3] = (f + 1.0) * f * (f - 1.0) / 6.0;
    }
    for (int i = 0; i < 4; i++) weight[i] = (Real)of[i];
}

/* Axis a is the one along which the ray is fastest; rows lie along x wherever they can. */
static void lay_out(const NphShdomSweep *sweep, Way *way) {
    const NphShdomGrid *grid = sweep->grid;
    int64_t point_step[3] = {1, grid->points[0], (int64_t)grid->points[0] * grid->points[1]};
    int64_t cell_step[3] = {1, grid->cells[0], (int64_t)grid->cells[0] * grid->cells[1]};
    int fastest = 0;
    for (int a = 1; a < 3; a++) fastest = nph_abs(sweep->along[a]) > nph_abs(sweep->along[fastest]) ? a : fastest;
    double length = 1.0 / nph_abs(sweep->along[fastest]), part[3];
    way->axis[0] = fastest;
    way->axis[1] = fastest == 0 ? 1 : 0;
    way->axis[2] = fastest == 2 ? 1 : 2;
    for (int k = 0; k < 3; k++) {
        int a = way->axis[k];
        way->sign[k] = sweep->along[a] < 0.0 ? -1 : 1;
        way->points[k] = grid->points[a];
        way->cells[k] = grid->cells[a];
        way->point_step[k] = point_step[a];
        way->cell_step[k] = cell_step[a];
        part[k] = nph_abs(sweep->along[a]) * length;
    }
    for (int i = 0; i < 4; i++) {
        double b = i & 1 ? part[1] : 1.0 - part[1], c = i & 2 ? part[2] : 1.0 - part[2];
        way->weight[i] = (Real)(b * c);
    }
    for (int k = 0; k < 3; k++) way->part[k] = (Real)part[k];
    for (int k = 0; k < 2; k++) set_cubic(part[1 + k], sweep->cubic, way->cubic[k]);
    way->depth = (Real)(sweep->extinction * length);
    way->border = (Real)sweep->border;
}

int64_t NPH_KERNEL(nph_shdom_sweep)(const NphShdomSweep *sweep) {
    Way way = {.sweep = sweep, .density = sweep->density, .share = sweep->share, .bubble = sweep->bubble, .projected = sweep->projected,
               .radiance = sweep->radiance, .mean = sweep->mean};
    Real *projected = sweep->projected, *kept = projected + sweep->grid->point_count; /* a plane and two rows behind it */
    lay_out(sweep, &way);
    assert(projected && way.radiance);
    way.rows[0] = kept + way.points[1] * way.points[2] + 2;
    way.rows[1] = way.rows[0] + way.points[1] + 2;
    project(sweep, projected);
    int64_t settled = !sweep->grid->periodic[way.axis[0]];
    if (settled) (void)step_round(&way, NULL);
    else memset(way.radiance, 0, sizeof *way.radiance * (size_t)sweep->grid->point_count);
    for (int round = 0; round < ROUNDS_MAX && !settled; round++) settled = !(step_round(&way, kept) > R(0.0));
    for (int64_t at = 0; at < way.points[0]; at++) mean_plane(&way, at);
    beam_means(&way);
    return !settled;
}
