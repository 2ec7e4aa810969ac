/* SPDX-License-Identifier: Apache-2.0
 *
 * Sums whose bits depend on the values and their order alone. The tree has the largest power of two below the count on
 * its left, so the sums of aligned blocks of 2^k values are its nodes: they may be computed by any thread and folded. */
#ifndef NPH_CORE_REDUCE_H
#define NPH_CORE_REDUCE_H

#include <stdint.h>

#include "core/fmath.h"

/* Sum of values[0], values[stride], ... (count of them, 0 gives 0) in the fixed binary tree. Relative error at most
 * log2(count) 2^-53 for values of one sign. */
double nph_tree_sum(const double *values, int64_t count, int64_t stride);

/* A running sum with what its roundings lost [Neumaier74]: error about 2^-53 of the sum plus count 2^-106 of the sum of
 * the sizes. Start from zero. */
typedef struct NphSum {
    double sum, lost;
} NphSum;

static inline void nph_sum_add(NphSum *sum, double value) {
    double next = sum->sum + value;
    int larger = nph_abs(sum->sum) >= nph_abs(value);
    sum->lost += larger ? (sum->sum - next) + value : (value - next) + sum->sum;
    sum->sum = next;
}

/* Once a term or the sum is infinite, lost is NaN and the plain sum is the answer. */
static inline double nph_sum_value(NphSum sum) {
    double whole = sum.sum + sum.lost;
    return sum.lost == sum.lost ? whole : sum.sum;
}

#endif
