/* SPDX-License-Identifier: Apache-2.0
 *
 * Fixed-tree and compensated sums. */
#include <math.h>

#include "core/philox.h"
#include "core/reduce.h"
#include "harness.h"

enum { N = 10007 };
static double values[N];

static void draw(double least_exponent) {
    for (uint32_t i = 0; i < N; i++) {
        NphWords w = nph_philox(5, 0, i, 0, 0, 0);
        double mantissa = 0.5 + nph_uniform(w.w0) + 0x1p-32 * nph_uniform(w.w1);
        values[i] = ldexp(mantissa, (int)(least_exponent * nph_uniform(w.w2)));
    }
}

/* The definition: left subtree of the largest power of two below the count. */
static double tree_by_definition(const double *v, int64_t count) {
    if (count == 1) return v[0];
    int64_t left = 1;
    while (2 * left < count) left *= 2;
    return tree_by_definition(v, left) + tree_by_definition(v + left, count - left);
}

START_TEST(tree_is_the_defined_one_for_every_count) {
    draw(-40);
    ck_assert(nph_tree_sum(values, 0, 1) == 0.0);
    for (int64_t count = 1; count < 600; count++)
        ck_assert(nph_tree_sum(values, count, 1) == tree_by_definition(values, count));
    ck_assert(nph_tree_sum(values, N, 1) == tree_by_definition(values, N));
}
END_TEST

START_TEST(sums_of_aligned_blocks_fold_to_the_same_bits) {
    draw(-40);
    double whole = nph_tree_sum(values, N, 1), strided[N];
    int differing = 0;
    for (int64_t block = 1; block <= 16384; block *= 2) {
        int64_t blocks = 0;
        for (int64_t first = 0; first < N; first += block, blocks++)
            strided[blocks] = nph_tree_sum(values + first, first + block < N ? block : N - first, 1);
        ck_assert(nph_tree_sum(strided, blocks, 1) == whole);
    }
    for (int64_t block = 3; block < 100; block += 2) { /* not aligned: here the bits do differ */
        int64_t blocks = 0;
        for (int64_t first = 0; first < N; first += block, blocks++)
            strided[blocks] = nph_tree_sum(values + first, first + block < N ? block : N - first, 1);
        differing += nph_tree_sum(strided, blocks, 1) != whole;
    }
    ck_assert_int_gt(differing, 0);
}
END_TEST

START_TEST(stride_picks_one_channel) {
    double rgb[9] = {1, 10, 100, 2, 20, 200, 4, 40, 400};
    ck_assert(nph_tree_sum(rgb, 3, 3) == 7.0 && nph_tree_sum(rgb + 2, 3, 3) == 700.0);
}
END_TEST

START_TEST(compensated_sum_keeps_what_a_plain_one_loses) {
    NphSum sum = {0};
    static const double hard[] = {1.0, 1e100, 1.0, -1e100};
    for (int i = 0; i < 4; i++) nph_sum_add(&sum, hard[i]);
    ck_assert(nph_sum_value(sum) == 2.0);

    draw(-60);
    NphSum forwards = {0}, backwards = {0};
    for (int i = 0; i < N; i++) nph_sum_add(&forwards, values[i]);
    for (int i = N; i-- > 0;) nph_sum_add(&backwards, values[i]);
    double a = nph_sum_value(forwards), b = nph_sum_value(backwards);
    ck_assert(fabs(a - b) <= 0x1p-52 * a);
    ck_assert(fabs(nph_tree_sum(values, N, 1) - a) <= 14 * 0x1p-53 * a); /* depth of the tree: 14 */

    NphSum infinite = {0};
    nph_sum_add(&infinite, 1.0);
    nph_sum_add(&infinite, INFINITY);
    nph_sum_add(&infinite, 1.0);
    ck_assert(isinf(nph_sum_value(infinite)));
    nph_sum_add(&infinite, -INFINITY);
    ck_assert(isnan(nph_sum_value(infinite)));
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, tree_is_the_defined_one_for_every_count);
    tcase_add_test(cases, sums_of_aligned_blocks_fold_to_the_same_bits);
    tcase_add_test(cases, stride_picks_one_channel);
    tcase_add_test(cases, compensated_sum_keeps_what_a_plain_one_loses);
}

int main(void) { return nph_test_main("reduce", fill); }
