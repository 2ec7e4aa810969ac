/* SPDX-License-Identifier: Apache-2.0
 *
 * shdom.sweep: the radiance of one ordinate at every point, from the point where its ray last crossed a plane of the grid [Kunasz88].
 * Cells are all alike and have one extinction each, so that plane, the place on it and the length are the same for all points: with
 * tau = sigma length, e = e^-tau and a source function S + d, S linear between both places and d the same all over the cell,
 *   L      = e L_up + w_up S_up + w S + (1 - e) d,      w = 1 - (1 - e) / tau,  w_up = (1 - e) / tau - e      [Olson87 eq. 19]
 *   mean L = (1 - e) / tau L_up + m_up S_up + m S + w d,      m = 1/2 - w / tau,  m_up = 1/2 - w_up / tau
 * L_up and S_up are interpolated between four points, for L along the ray through a point, for the mean of a cell along the one through
 * its middle. The plane is one across the axis along which the ray is fastest: points of a
 * plane wait for the plane before it only. Where sides repeat along that axis, the first plane waits for the last one: rounds, until
 * they agree. Means of cells say what they scatter, where linear interpolation between corners would gain or lose light.
 * [density, share, bubble, source -> radiance, mean] */
#include <string.h>

#include "truth/shdom/shdom_kernels.h"

int64_t NPH_KERNEL(nph_shdom_sweep)(const NphShdomSweep *sweep);

enum { ROUNDS_MAX = 4096 };
#if NPH_PRECISION == 32
#define SETTLED 1e-6f
#else
#define SETTLED 1e-12
#endif

/* Four points on the plane before, and four on its own, for every point of a row. bubble: d; weights of the ray through the point; of the
 * one through the middle of its cell, where it enters and leaves. */
typedef struct Row {
    const Real *up, *L[4], *S[4], *own[4], *density, *share, *bubble; /* up: L where the ray through the point comes from */
    Real weight[4], enters[4], leaves[4], depth; /* depth: of density 1 */
} Row;

/* Parts of the source here (w, m) and there (w_up, m_up); series where the differences lose their digits: m = tau q, w = tau (1/2 - m). */
typedef struct Parts {
    Real passes, mean_passes, own, far, mean_own, mean_far;
} Parts;

R_INLINE Parts parts_of(Real t) {
    Real e = r_exp(-t), safe = t < R(0.0625) ? R(1.0) : t, inverse = R(1.0) / safe;
    Real near = t * (R(1.0) / R(6.0) - t * (R(1.0) / R(24.0) - t * (R(1.0) / R(120.0) - t * (R(1.0) / R(720.0) - t * (R(1.0) / R(5040.0) -
                    t * (R(1.0) / R(40320.0) - t * (R(1.0) / R(362880.0))))))));
    Real away = t * (R(1.0) / R(3.0) - t * (R(1.0) / R(8.0) - t * (R(1.0) / R(30.0) - t * (R(1.0) / R(144.0) - t * (R(1.0) / R(840.0) -
                    t * (R(1.0) / R(5760.0) - t * (R(1.0) / R(45360.0))))))));
    int thin = t < R(0.0625);
    Real own = thin ? t * (R(0.5) - near) : R(1.0) - (R(1.0) - e) * inverse;
    Real far = thin ? t * (R(0.5) - away) : (R(1.0) - e) - own;
    Parts parts = {e, R(1.0) - own, own, far, thin ? near : R(0.5) - own * inverse, thin ? away : R(0.5) - far * inverse};
    return parts;
}

R_INLINE Real four(const Real weight[4], const Real *const from[4], int64_t at) {
    return weight[0] * from[0][at] + weight[1] * from[1][at] + weight[2] * from[2][at] + weight[3] * from[3][at];
}

R_INLINE Real step_at(const Row *row, int64_t point, int64_t cell, Real up, Real *mean) {
    Parts parts = parts_of(row->density[cell] * row->depth);
    Real share = row->share[cell], bubble = row->bubble[cell], S = four(row->weight, row->S, point);
    Real enters = four(row->enters, row->L, point), away = four(row->enters, row->S, point), near = four(row->leaves, row->own, point);
    *mean = parts.mean_passes * enters + share * (parts.mean_far * away + parts.mean_own * near) + parts.own * bubble;
    return parts.passes * up + share * (parts.far * S + parts.own * row->own[0][point]) + (R(1.0) - parts.passes) * bubble;
}

R_OUTLINE void step_row(const Row *given, int count, Real *restrict mean, Real *restrict out) {
    const Row row = *given;
    const Real *restrict up = row.up, *restrict density = row.density, *restrict share = row.share, *restrict bubble = row.bubble;
    const Real *restrict L0 = row.L[0], *restrict L1 = row.L[1], *restrict L2 = row.L[2], *restrict L3 = row.L[3];
    const Real *restrict S0 = row.S[0], *restrict S1 = row.S[1], *restrict S2 = row.S[2], *restrict S3 = row.S[3];
    const Real *restrict own0 = row.own[0], *restrict own1 = row.own[1], *restrict own2 = row.own[2], *restrict own3 = row.own[3];
    for (int i = 0; i < count; i++) { /* vec */
        Parts parts = parts_of(density[i] * row.depth);
        Real S = row.weight[0] * S0[i] + row.weight[1] * S1[i] + row.weight[2] * S2[i] + row.weight[3] * S3[i];
        Real enters = row.enters[0] * L0[i] + row.enters[1] * L1[i] + row.enters[2] * L2[i] + row.enters[3] * L3[i];
        Real away = row.enters[0] * S0[i] + row.enters[1] * S1[i] + row.enters[2] * S2[i] + row.enters[3] * S3[i];
        Real near = row.leaves[0] * own0[i] + row.leaves[1] * own1[i] + row.leaves[2] * own2[i] + row.leaves[3] * own3[i];
        mean[i] = parts.mean_passes * enters + share[i] * (parts.mean_far * away + parts.mean_own * near) + parts.own * bubble[i];
        out[i] = parts.passes * up[i] + share[i] * (parts.far * S + parts.own * own0[i]) + (R(1.0) - parts.passes) * bubble[i];
    }
}

/* One ordinate under way: axes a (fastest), b (along rows), c. */
typedef struct Way {
    const NphShdomSweep *sweep;
    int axis[3], sign[3];
    int64_t points[3], cells[3], point_step[3], cell_step[3];
    Real weight[4], enters[4], leaves[4], depth, border;
    const Real *density, *share, *bubble, *projected;
    Real *radiance, *mean, *rows[2];  /* rows: of a plane, with two places more at either end */
    Real cubic[2][4];                 /* weights along b and c: behind, own, upstream, beyond */
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
    for (int i = 0; i < 4; i++) {
        int64_t within = b[i & 1] * way->point_step[1] + c[i >> 1] * way->point_step[2];
        row->L[i] = way->radiance + planes[1] * way->point_step[0] + within;
        row->S[i] = way->projected + planes[1] * way->point_step[0] + within;
        row->own[i] = way->projected + planes[0] * way->point_step[0] + within;
        row->weight[i] = way->weight[i];
        row->enters[i] = way->enters[i];
        row->leaves[i] = way->leaves[i];
    }
    row->depth = way->depth;
}

/* A point by itself: at the rim, or in a row that is not one in memory. */
static Real step_point(const Way *way, const int64_t at[3], Real above) {
    int64_t up[3], cell = 0;
    for (int k = 0; k < 3; k++) {
        up[k] = before(way, k, at[k]);
        if (up[k] < 0) return way->border;
        cell += between(way, k, at[k]) * way->cell_step[k];
    }
    Row row = {.density = way->density, .share = way->share, .bubble = way->bubble};
    set_row(way, (int64_t[2]){at[0], up[0]}, (int64_t[2]){at[1], up[1]}, (int64_t[2]){at[2], up[2]}, &row);
    return step_at(&row, 0, cell, above, way->mean + cell);
}

/* All points of a row but the one at its upstream end. */
static void step_inner(const Way *way, const int64_t planes[2], const int64_t lines[2], int64_t cell) {
    int64_t first = way->sign[1] > 0, steps = way->point_step[1];
    Real *out = way->radiance + planes[0] * way->point_step[0] + lines[0] * way->point_step[2] + first * steps, *mean = way->mean + cell;
    Row row = {.density = way->density + cell, .share = way->share + cell, .bubble = way->bubble + cell};
    set_row(way, planes, (int64_t[2]){first, first - way->sign[1]}, lines, &row);
    row.up = way->rows[1] + first;
    int count = (int)way->points[1] - 1;
    if (steps == 1) {
        step_row(&row, count, mean, out);
        return;
    }
    for (int i = 0; i < count; i++) out[i * steps] = step_at(&row, i * steps, i * way->cell_step[1], row.up[i], mean + i * way->cell_step[1]);
}

R_OUTLINE void mix_rows(const Real weight[4], const Real *const from[4], int count, Real *restrict out) {
    const Real *restrict a = from[0], *restrict b = from[1], *restrict c = from[2], *restrict d = from[3];
    const Real p = weight[0], q = weight[1], r = weight[2], s = weight[3];
    for (int i = 0; i < count; i++) /* vec */
        out[i] = (p * a[i] + q * b[i]) + (r * c[i] + s * d[i]);
}

/* Places along axis k: behind a point, its own, upstream, beyond; where a side is open, what would lie outside goes on in a line. */
static void four_places(const Way *way, int k, int64_t at, int64_t place[4], Real weight[4]) {
    int64_t n = way->points[k];
    for (int i = 0; i < 4; i++) {
        place[i] = at + (1 - i) * way->sign[k];
        weight[i] = way->cubic[k - 1][i];
        if (way->sweep->grid->periodic[way->axis[k]]) place[i] = (place[i] % n + n) % n;
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

/* Radiance of the plane before where the rays through a row come from: across it first, then along it. */
static void fill_up(const Way *way, int64_t plane, int64_t c) {
    int64_t place[4], n = way->points[1], steps = way->point_step[1];
    Real weight[4], *across = way->rows[0];
    const Real *from[4];
    four_places(way, 2, c, place, weight);
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
        way->radiance[row + last * way->point_step[1]] = step_point(way, place, way->rows[1][last]);
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
        for (int64_t j = 0; j < count; j++) {
            Real now = way->radiance[here + j % way->points[1] * way->point_step[1] + j / way->points[1] * way->point_step[2]];
            change = r_max(change, r_abs(now - kept[j]));
            most = r_max(most, r_abs(now));
        }
    }
    return change > SETTLED * most ? R(1.0) : R(0.0);
}

/* Weights of four places at 1, 0, -1, -2 for what lies at -part: Lagrange's polynomial of third degree, or a line. */
static void set_cubic(double part, int cubic, Real weight[4]) {
    double f = part, of[4] = {0.0, 1.0 - f, f, 0.0};
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
        way->enters[i] = (Real)(0.25 * (i & 1 ? 1.0 + part[1] : 1.0 - part[1]) * (i & 2 ? 1.0 + part[2] : 1.0 - part[2]));
        way->leaves[i] = (Real)(0.25 * (i & 1 ? 1.0 - part[1] : 1.0 + part[1]) * (i & 2 ? 1.0 - part[2] : 1.0 + part[2]));
    }
    for (int k = 0; k < 2; k++) set_cubic(part[1 + k], sweep->cubic, way->cubic[k]);
    way->depth = (Real)(sweep->extinction * length);
    way->border = (Real)sweep->border;
}

int64_t NPH_KERNEL(nph_shdom_sweep)(const NphShdomSweep *sweep) {
    Way way = {.sweep = sweep, .density = sweep->density, .share = sweep->share, .bubble = sweep->bubble, .projected = sweep->projected,
               .radiance = sweep->radiance, .mean = sweep->mean};
    Real *projected = sweep->projected, *kept = projected + sweep->grid->point_count; /* a plane and two rows behind it */
    lay_out(sweep, &way);
    way.rows[0] = kept + way.points[1] * way.points[2] + 2;
    way.rows[1] = way.rows[0] + way.points[1] + 2;
    project(sweep, projected);
    if (!sweep->grid->periodic[way.axis[0]]) {
        (void)step_round(&way, NULL);
        return 0;
    }
    memset(way.radiance, 0, sizeof *way.radiance * (size_t)sweep->grid->point_count);
    for (int round = 0; round < ROUNDS_MAX; round++)
        if (!(step_round(&way, kept) > R(0.0))) return 0;
    return 1;
}
