/* SPDX-License-Identifier: Apache-2.0
 *
 * shdom.moments, shdom.scatter, shdom.accelerate, shdom.finish, element by element and in a fixed order:
 *   moments   I_lm = sum over ordinates, one after another, of w Y_lm L
 *   scatter   S_lm = albedo (chi_l - f) / (1 - f) w_l (first + I)_lm
 *   accelerate   how a source has changed, products of such changes in double (eight sums side by side, folded in pairs), and the mix
 * and the look up of the finished source function. */
#include <string.h>

#include "truth/shdom/shdom_kernels.h"

void NPH_KERNEL(nph_shdom_gather)(const NphShdomGather *gather);
void NPH_KERNEL(nph_shdom_scatter)(double factor, const void *a, const void *b, const int64_t range[2], void *out);
void NPH_KERNEL(nph_shdom_difference)(const NphShdomMix *mix);
void NPH_KERNEL(nph_shdom_combine)(const NphShdomMix *mix);
void NPH_KERNEL(nph_shdom_store)(const double *values, int64_t count, void *to);
double NPH_KERNEL(nph_shdom_load)(const void *from, int64_t at);
void NPH_KERNEL(nph_shdom_bubble)(const NphShdomGrid *grid, const void *corners, const void *means, const int64_t range[2], void *out);
void NPH_KERNEL(nph_shdom_look)(const NphShdomLook *look, const void *field, double *out);

enum { LANES = 8 };

R_OUTLINE void add_ordinates(const Real factor[4], const Real *restrict a, int64_t apart, int count, Real *restrict out) {
    const Real *restrict b = a + apart, *restrict c = b + apart, *restrict d = c + apart;
    const Real p = factor[0], q = factor[1], r = factor[2], s = factor[3];
    for (int i = 0; i < count; i++) /* vec */
        out[i] = (((out[i] + p * a[i]) + q * b[i]) + r * c[i]) + s * d[i];
}

R_OUTLINE void add_ordinate(Real factor, const Real *restrict a, int count, Real *restrict out) {
    for (int i = 0; i < count; i++) /* vec */
        out[i] += factor * a[i];
}

void NPH_KERNEL(nph_shdom_gather)(const NphShdomGather *gather) {
    int64_t points = gather->points;
    int count = (int)(gather->end - gather->first), terms = gather->coefficients;
    const Real *radiance = (const Real *)gather->radiance + gather->first;
    for (int t = 0; t < terms; t++) {
        Real *out = (Real *)gather->moments + t * points + gather->first;
        int o = 0;
        if (!gather->add) memset(out, 0, sizeof *out * (size_t)count);
        for (; o + 4 <= gather->ordinates; o += 4) {
            const double *f = gather->factors + (int64_t)o * gather->stride + t;
            const Real factor[4] = {(Real)f[0], (Real)f[gather->stride], (Real)f[2 * gather->stride], (Real)f[3 * gather->stride]};
            add_ordinates(factor, radiance + o * points, points, count, out);
        }
        for (; o < gather->ordinates; o++) add_ordinate((Real)gather->factors[o * gather->stride + t], radiance + o * points, count, out);
    }
}

R_OUTLINE void scatter_row(Real factor, const Real *restrict a, const Real *restrict b, int count, Real *restrict out) {
    for (int i = 0; i < count; i++) /* vec */
        out[i] = factor * (a[i] + b[i]);
}

void NPH_KERNEL(nph_shdom_scatter)(double factor, const void *a, const void *b, const int64_t range[2], void *out) {
    int64_t first = range[0];
    scatter_row((Real)factor, (const Real *)a + first, (const Real *)b + first, (int)(range[1] - first), (Real *)out + first);
}

/* Eight sums, each of every eighth product. */
R_OUTLINE double dot(const Real *restrict a, const Real *restrict b, int count) {
    double sum[LANES] = {0.0};
    int i = 0;
    for (; i + LANES <= count; i += LANES)
        for (int k = 0; k < LANES; k++) sum[k] += (double)a[i + k] * (double)b[i + k];
    for (int k = 0; i + k < count; k++) sum[k] += (double)a[i + k] * (double)b[i + k];
    return ((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7]));
}

R_OUTLINE void change_row(const Real *restrict scattered, const Real *restrict source, int count, Real *restrict kept, Real *restrict change) {
    for (int i = 0; i < count; i++) { /* vec */
        kept[i] = source[i];
        change[i] = scattered[i] - source[i];
    }
}

void NPH_KERNEL(nph_shdom_difference)(const NphShdomMix *mix) {
    int count = (int)(mix->end - mix->first);
    const Real *source = (const Real *)mix->source + mix->first;
    Real *history = (Real *)mix->history + mix->first, *own = history + 2 * mix->slot * mix->size;
    change_row((const Real *)mix->scattered + mix->first, source, count, own, own + mix->size);
    for (int k = 0; k < mix->count; k++) mix->dots[k] = dot(own + mix->size, history + (2 * k + 1) * mix->size, count);
    mix->dots[mix->count] = dot(source, source, count);
}

R_OUTLINE void mix_row(Real weight, const Real *restrict kept, const Real *restrict change, int count, Real *restrict out) {
    for (int i = 0; i < count; i++) /* vec */
        out[i] += weight * (kept[i] + change[i]);
}

void NPH_KERNEL(nph_shdom_combine)(const NphShdomMix *mix) {
    int count = (int)(mix->end - mix->first);
    Real *source = (Real *)mix->source + mix->first;
    memset(source, 0, sizeof *source * (size_t)count);
    for (int k = 0; k < mix->count; k++) {
        const Real *kept = (const Real *)mix->history + 2 * k * mix->size + mix->first;
        mix_row((Real)mix->weights[k], kept, kept + mix->size, count, source);
    }
}

void NPH_KERNEL(nph_shdom_store)(const double *values, int64_t count, void *to) {
    Real *out = to;
    for (int64_t i = 0; i < count; i++) out[i] = (Real)values[i];
}

double NPH_KERNEL(nph_shdom_load)(const void *from, int64_t at) { return (double)((const Real *)from)[at]; }

/* Corners: coefficients of degree 0, whose harmonic is 1 / sqrt(4 pi). */
void NPH_KERNEL(nph_shdom_bubble)(const NphShdomGrid *grid, const void *corners, const void *means, const int64_t range[2], void *out) {
    const Real *values = corners, *mean = means;
    Real *bubble = out;
    for (int64_t cell = range[0]; cell < range[1]; cell++) {
        int64_t low[3] = {cell % grid->cells[0], cell / grid->cells[0] % grid->cells[1], cell / grid->cells[0] / grid->cells[1]}, high[3];
        Real sum = R(0.0);
        for (int a = 0; a < 3; a++) high[a] = (low[a] + 1) % grid->points[a];
        for (int i = 0; i < 8; i++) {
            int64_t x = i & 1 ? high[0] : low[0], y = i & 2 ? high[1] : low[1], z = i & 4 ? high[2] : low[2];
            sum += values[(z * grid->points[1] + y) * grid->points[0] + x];
        }
        bubble[cell] = R(0.28209479177387814) * (mean[cell] - R(0.125) * sum);
    }
}

R_OUTLINE void add_corner(double weight, const Real *restrict row, int count, double *restrict sums) {
    for (int i = 0; i < count; i++) sums[i] += weight * (double)row[i];
}

void NPH_KERNEL(nph_shdom_look)(const NphShdomLook *look, const void *field, double *out) {
    int terms = look->terms, all = look->rows * terms;
    double *sums = look->room;
    memset(sums, 0, sizeof *sums * (size_t)all);
    for (int i = 0; i < 8; i++)
        if (look->weights[i] > 0.0) add_corner(look->weights[i], (const Real *)field + look->points[i] * all, all, sums);
    for (int r = 0; r < look->rows; r++) {
        const double *row = sums + r * terms;
        double sum[LANES] = {0.0};
        int t = 0;
        for (; t + LANES <= terms; t += LANES)
            for (int k = 0; k < LANES; k++) sum[k] += look->basis[t + k] * row[t + k];
        for (int k = 0; t + k < terms; k++) sum[k] += look->basis[t + k] * row[t + k];
        out[r] = ((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7]));
    }
}
