/* SPDX-License-Identifier: Apache-2.0
 *
 * Tabulated phase functions in kernels. Each half of the sphere is a list of intervals in the distance x = 1 - |cos| to
 * its pole; the density is linear in x over an interval, and the part of the distribution a quadratic, inverted in
 * closed form. The table is searched and interpolated in double, so that single precision meets the same function. */
#ifndef NPH_OPTICS_PHASE_TABLE_LOOKUP_H
#define NPH_OPTICS_PHASE_TABLE_LOOKUP_H

#include "optics/hg_lookup.h"
#include "optics/phase.h"

/* Buckets only narrow the search: they rise with their argument, rounding included. */
static inline int r_phase_bucket(double part, int buckets) {
    int bucket = (int)(part * (double)buckets);
    return bucket < buckets - 1 ? bucket : buckets - 1;
}

/* The last interval i whose edge[i] <= key (below: edge[i] < key), or 0. guide[b]: edges in buckets before b. */
static inline int r_phase_interval(const double *edge, int count, const int32_t *guide, int bucket, double key,
                                   int below) {
    int low = guide[bucket] > 0 ? guide[bucket] - 1 : 0, high = guide[bucket + 1];
    high = high < count ? high : count;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (below ? edge[middle] < key : edge[middle] <= key) low = middle;
        else high = middle;
    }
    return low;
}

/* Angles are mostly tabulated in even steps of the angle: buckets of sqrt(x). */
static inline Real r_phase_table_value(const NphPhaseHalf *halves, RAngle angle) {
    int front = angle.fall < angle.rise;
    const NphPhaseHalf *half = &halves[!front];
    double x = (double)(front ? angle.fall : angle.rise);
    x = x > 0.0 ? (x < 1.0 ? x : 1.0) : 0.0; /* NaN becomes 0 */
    int i = r_phase_interval(half->x, half->count, half->by_x, r_phase_bucket(nph_sqrt(x), half->buckets), x, 0);
    double along = (x - half->x[i]) / (half->x[i + 1] - half->x[i]);
    return (Real)(half->value[i] + along * (half->value[i + 1] - half->value[i]));
}

/* An interval from density a to b: the part r of it lies within s = r / (a + sqrt(a^2 (1 - r) + b^2 r)), a + b = 1. */
static inline double r_phase_within(double a, double b, double r) {
    double unit = 1.0 / (a + b);
    a *= unit;
    b *= unit;
    double root = nph_sqrt(a * a * (1.0 - r) + b * b * r), s = r > 0.0 ? r / (a + root) : 0.0;
    return s < 1.0 ? s : 1.0;
}

/* u below the back half's part: counted from the back pole; else from the front one. */
static inline RAngle r_phase_table_sample(const NphPhaseHalf *halves, Real u) {
    double back = halves[1].part[halves[1].count];
    int front = !((double)u < back);
    const NphPhaseHalf *half = &halves[!front];
    double key = front ? 1.0 - (double)u : (double)u;
    int bucket = r_phase_bucket(key * half->part_scale, half->buckets);
    int i = r_phase_interval(half->part, half->count, half->by_part, bucket, key, front);
    double r = (key - half->part[i]) / (half->part[i + 1] - half->part[i]);
    r = r > 0.0 ? (r < 1.0 ? r : 1.0) : 0.0;
    double s = r_phase_within(half->value[i], half->value[i + 1], r);
    return r_angle_near(front, (Real)(half->x[i] + s * (half->x[i + 1] - half->x[i])));
}

#endif
