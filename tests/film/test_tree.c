/* SPDX-License-Identifier: Apache-2.0
 *
 * The dyadic tree: normal forms, room for them, and the joining of moments. */
#include <math.h>

#include "film_samples.h"

START_TEST(normal_forms_are_maximal_aligned_and_cover_the_range) {
    for (int64_t begin = 0; begin < 70; begin++)
        for (int64_t end = begin; end < 140; end++) {
            NphNode nodes[NPH_MAX_NODES];
            int count = nph_tree_nodes(begin, end, nodes);
            int64_t at = begin;
            for (int i = 0; i < count; i++) {
                int64_t size = (int64_t)1 << nodes[i].level, parent = (nodes[i].index >> 1) * 2 * size;
                ck_assert_int_eq(nodes[i].index * size, at);
                ck_assert_msg(parent < begin || parent + 2 * size > end, "[%d,%d): node %d is not maximal", (int)begin,
                              (int)end, i);
                at += size;
            }
            ck_assert_int_eq(at, end);
        }
}
END_TEST

START_TEST(room_is_the_longest_normal_form_of_any_beginning) {
    for (int64_t begin = 0; begin < 130; begin++) {
        int most = 0;
        for (int64_t end = begin; end < 300; end++) {
            NphNode nodes[NPH_MAX_NODES];
            int count = nph_tree_nodes(begin, end, nodes);
            if (count > most) most = count;
            ck_assert_msg(nph_tree_slots(begin, end) == most, "[%d,%d): %d, not %d", (int)begin, (int)end,
                          nph_tree_slots(begin, end), most);
        }
    }
    NphNode nodes[NPH_MAX_NODES];
    int64_t last = NPH_FILM_MAX_SAMPLES / NPH_CHUNK;
    ck_assert_int_le(nph_tree_slots(1, last), NPH_MAX_NODES - 1);
    ck_assert_int_eq(nph_tree_nodes(1, last, nodes), nph_tree_slots(1, last));
}
END_TEST

static long double power(long double x, int k) { return k == 1 ? x : x * power(x, k - 1); }

/* Bounded by rounding: sums of k-th powers of about 10 at 53 bits, a hundred operations. */
static void check_close(double got, long double wanted, double scale, const char *what) {
    ck_assert_msg(fabsl(got - wanted) <= 100 * 2.3e-16L * scale, "%s: %.17g, not %.17Lg", what, got, wanted);
}

START_TEST(joined_moments_are_those_of_all_samples) {
    for (int trial = 0; trial < 200; trial++) {
        long double x[64], a[4] = {0}, b[4] = {0}, all[4] = {0};
        int na = 1 + (int)(40 * hash_uniform(1, (uint64_t)trial, 0)), nb = 1 + trial % 23;
        for (int i = 0; i < na + nb; i++) x[i] = 10 * hash_uniform(2, (uint64_t)trial, (uint64_t)i) - (i < na ? 8 : 2);
        for (int i = 0; i < na + nb; i++) {
            (i < na ? a : b)[0] += x[i] / (i < na ? na : nb);
            all[0] += x[i] / (na + nb);
        }
        for (int i = 0; i < na + nb; i++)
            for (int k = 1; k <= 3; k++) {
                long double *own = i < na ? a : b;
                own[k] += power(x[i] - own[0], k + 1);
                all[k] += power(x[i] - all[0], k + 1);
            }
        NphJoin join = nph_join_of(na, nb);
        NphMoments left = {(double)a[0], (double)a[1], (double)a[2], (double)a[3]};
        NphMoments right = {(double)b[0], (double)b[1], (double)b[2], (double)b[3]},
                   both = nph_join_moments(&join, &left, &right);
        check_close(both.mean, all[0], 10, "mean");
        check_close(both.m2, all[1], 64 * 1e2, "M2");
        check_close(both.m3, all[2], 64 * 1e3, "M3");
        check_close(both.m4, all[3], 64 * 1e4, "M4");
    }
}
END_TEST

/* A fold written as the definition reads: the tree over [0, 2^level) chunks without its empty branches. */
static int fold_by_definition(const NphFilm *film, int level, int64_t index, double *out) {
    NphNode nodes[NPH_MAX_NODES];
    int64_t begin = film->chunk_begin, end = begin + film->chunks[0], first = index << level,
            size = (int64_t)1 << level;
    if (first + size <= begin || first >= end) return 0;
    int count = nph_film_tile_nodes(film, 0, nodes);
    for (int i = 0; i < count; i++)
        if (nodes[i].level == level && nodes[i].index == index) {
            memcpy(out, nph_film_node(film, 0, i), nph_film_scratch_bytes(film->channels));
            return (int)size;
        }
    double *right = malloc(nph_film_scratch_bytes(film->channels));
    int a = fold_by_definition(film, level - 1, 2 * index, out),
        b = fold_by_definition(film, level - 1, 2 * index + 1, right);
    if (a && b)
        nph_tree_merge(out, a * NPH_CHUNK, right, b * NPH_CHUNK, film->channels, out);
    else if (b)
        memcpy(out, right, nph_film_scratch_bytes(film->channels));
    free(right);
    return a + b;
}

START_TEST(the_fold_is_the_full_tree_without_its_empty_branches) {
    NphContext *context = nph_test_context(1);
    double *wanted = malloc(nph_film_scratch_bytes(1));
    for (int64_t begin = 0; begin < 9; begin++) {
        Shape shape = {2, 2, {0, 0, 2, 2}, 1, begin * 16, 26 * 16};
        NphFilm *film = empty_film(context, &shape);
        for (int64_t end = begin + 1; end <= 26; end++) {
            double moments[NPH_MOMENTS][NPH_TILE_PIXELS], mean[NPH_TILE_PIXELS];
            add_samples(film, 0, end * 16, 64, plain_sample);
            fold_by_definition(film, 5, 0, wanted);
            nph_tree_fold_moments(film, 0, 0, moments);
            nph_tree_fold_mean(film, 0, nph_film_value_distance(1), mean);
            ck_assert_mem_eq(moments, wanted, sizeof moments);
            ck_assert_mem_eq(mean, wanted + nph_film_value_distance(1) * NPH_TILE_PIXELS, sizeof mean);
        }
        nph_film_free(context, film);
    }
    free(wanted);
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, normal_forms_are_maximal_aligned_and_cover_the_range);
    tcase_add_test(cases, room_is_the_longest_normal_form_of_any_beginning);
    tcase_add_test(cases, joined_moments_are_those_of_all_samples);
    tcase_add_test(cases, the_fold_is_the_full_tree_without_its_empty_branches);
}

int main(void) { return nph_test_main("tree", fill); }
