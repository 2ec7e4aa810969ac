/* SPDX-License-Identifier: Apache-2.0
 *
 * Values of a node and the formulas that join two of them; inline, for kernels and scalar code alike.
 *
 * Radiance has its count n, mean, and central moments Mk = sum (x - mean)^k, k = 2, 3, 4; everything else only a mean.
 * Joined [Chan83; Pebay08], with d = mean_b - mean_a, fa = na / n, fb = nb / n:
 *   mean = mean_a + d fb
 *   M2 = M2a + M2b + d^2 na fb
 *   M3 = M3a + M3b + d^3 na fb (fa - fb) + 3 d (fa M2b - fb M2a)
 *   M4 = M4a + M4b + d^4 na fb (fa^2 - fa fb + fb^2) + 6 d^2 (fa^2 M2b + fb^2 M2a) + 4 d (fa M3b - fb M3a)
 * With equal means d = 0: the mean stays to the bit and nothing is added, so equal samples have variance exactly 0. */
#ifndef NPH_FILM_MOMENTS_H
#define NPH_FILM_MOMENTS_H

#include <stdint.h>

#include "film/film.h"

/* A node's values, each a plane over the tile's pixels: 4 per channel (mean, M2, M3, M4), a transmittance per channel,
 * then order, distance, collided. */
enum { NPH_MOMENTS = 4, NPH_MAX_VALUES = 18 };

static inline int nph_film_values(int channels) { return (NPH_MOMENTS + 1) * channels + 3; }
static inline int nph_film_value_transmittance(int channels) { return NPH_MOMENTS * channels; }
static inline int nph_film_value_order(int channels) { return (NPH_MOMENTS + 1) * channels; }
static inline int nph_film_value_distance(int channels) { return (NPH_MOMENTS + 1) * channels + 1; }
static inline int nph_film_value_collided(int channels) { return (NPH_MOMENTS + 1) * channels + 2; }

typedef struct NphMoments {
    double mean, m2, m3, m4;
} NphMoments;

/* What the formulas take from the counts; exact for siblings (fa = fb = 1/2). */
typedef struct NphJoin {
    double fa, fb, n_fa_fb, skew, kurt, fa2, fb2;
} NphJoin;

static inline NphJoin nph_join_of(int64_t count_a, int64_t count_b) {
    double na = (double)count_a, nb = (double)count_b, n = na + nb;
    NphJoin join = {.fa = na / n, .fb = nb / n};
    join.n_fa_fb = na * join.fb;
    join.skew = join.fa - join.fb;
    join.fa2 = join.fa * join.fa;
    join.fb2 = join.fb * join.fb;
    join.kurt = join.fa2 - join.fa * join.fb + join.fb2;
    return join;
}

static inline double nph_join_mean(const NphJoin *join, double a, double b) { return a + (b - a) * join->fb; }

static inline NphMoments nph_join_moments(const NphJoin *join, const NphMoments *a, const NphMoments *b) {
    double d = b->mean - a->mean, d2 = d * d, between = d2 * join->n_fa_fb;
    NphMoments out;
    out.mean = nph_join_mean(join, a->mean, b->mean);
    out.m2 = (a->m2 + b->m2) + between;
    out.m3 = (a->m3 + b->m3) + (between * d * join->skew + 3.0 * d * (join->fa * b->m2 - join->fb * a->m2));
    out.m4 = (a->m4 + b->m4) + ((between * d2 * join->kurt + 6.0 * d2 * (join->fa2 * b->m2 + join->fb2 * a->m2)) +
                                4.0 * d * (join->fa * b->m3 - join->fb * a->m3));
    return out;
}

#endif
