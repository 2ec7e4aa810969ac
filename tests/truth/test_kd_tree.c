/* SPDX-License-Identifier: Apache-2.0
 *
 * The photon map's kd-tree: nearest points are those of brute force to the bit, the tree is left-balanced and split as it
 * says, any number of threads builds the same bytes, and few, equal and aligned points are no exception. */
#include <math.h>
#include <string.h>

#include "core/memory.h"
#include "core/philox.h"
#include "harness.h"
#include "kernel_kd_tree.h"

#define EXPECT(condition, ...)                                                                                         \
    do {                                                                                                               \
        if (!(condition)) ck_abort_msg(__VA_ARGS__);                                                                   \
    } while (0)

/* Kinds of points. */
enum { UNIFORM, LATTICE, EQUAL, PLANE, LINE, SORTED, CLUSTERED, KINDS };

typedef struct Cloud {
    NphContext *context;
    NphKdTree tree;
    double *points; /* as the tree's number type holds them */
} Cloud;

static double random_number(uint32_t seed, int32_t i, int a) {
    NphWords words = nph_philox(seed, 7, (uint32_t)i, 0, 0, 0);
    return nph_uniform(a == 0 ? words.w0 : a == 1 ? words.w1 : words.w2);
}

static double coordinate(int kind, uint32_t seed, int32_t i, int32_t count, int a) {
    double u = random_number(seed, i, a);
    switch (kind) {
    case LATTICE: return floor(4.0 * u); /* many duplicates */
    case EQUAL: return 0.25;
    case PLANE: return a == 1 ? -3.0 : u;
    case LINE: return a == 2 ? u : a == 0 ? 0.0 : 1e6;
    case SORTED: return (double)(a == 0 ? i : count - i); /* in order already */
    case CLUSTERED: return u * u * u * (i % 3 == 0 ? 1e-3 : 1.0) + (i % 5 == 0 ? 10.0 : 0.0);
    default: return u - 0.5;
    }
}

static void cloud_make(Cloud *cloud, int threads, int precision, int kind, int32_t count) {
    cloud->context = nph_test_context(threads);
    cloud->tree = (NphKdTree){.precision = precision, .count = count};
    size_t bytes = nph_kd_node_bytes(precision), real = precision == 32 ? sizeof(float) : sizeof(double);
    void *input = NULL;
    ck_assert_int_eq(nph_alloc(cloud->context, (size_t)count, bytes, "nodes", &cloud->tree.nodes), NPH_OK);
    ck_assert_int_eq(nph_alloc(cloud->context, (size_t)count, bytes, "items", &cloud->tree.items), NPH_OK);
    ck_assert_int_eq(nph_alloc(cloud->context, (size_t)count * 3, real, "input", &input), NPH_OK);
    ck_assert_int_eq(NPH_NEW(cloud->context, (size_t)count * 3, "points", &cloud->points), NPH_OK);
    for (int32_t i = 0; i < count; i++)
        for (int a = 0; a < 3; a++) {
            double value = coordinate(kind, 11, i, count, a);
            size_t at = 3 * (size_t)i + (size_t)a;
            if (precision == 32)
                ((float *)input)[at] = (float)value;
            else
                ((double *)input)[at] = value;
            cloud->points[at] = precision == 32 ? (double)(float)value : value;
        }
    nph_kd_fill(&cloud->tree, input);
    nph_free(cloud->context, input);
    ck_assert_int_eq(nph_kd_build(cloud->context, &cloud->tree, NULL), NPH_OK);
}

static void cloud_free(Cloud *cloud) {
    nph_free(cloud->context, cloud->tree.nodes);
    nph_free(cloud->context, cloud->tree.items);
    nph_free(cloud->context, cloud->points);
    nph_test_context_close(cloud->context);
}

static void node_of(const NphKdTree *tree, int32_t node, double p[3], int32_t *number, int *axis) {
    if (tree->precision == 32)
        kd_node_f32_base(tree, node, p, number, axis);
    else
        kd_node_f64_base(tree, node, p, number, axis);
}

/* Points below `node`; each must lie on its side of `splits` along `axis`, ties by number. */
static int32_t check_side(const NphKdTree *tree, int32_t node, int32_t splits, int upper) {
    if (node >= tree->count) return 0;
    double p[3], s[3];
    int32_t number, split_number;
    int axis, ignored;
    node_of(tree, splits, s, &split_number, &axis);
    node_of(tree, node, p, &number, &ignored);
    int below = p[axis] < s[axis] || (p[axis] == s[axis] && number < split_number);
    EXPECT(below != upper, "node %d of point %d is on the wrong side of node %d", node, number, splits);
    return 1 + check_side(tree, 2 * node + 1, splits, upper) + check_side(tree, 2 * node + 2, splits, upper);
}

START_TEST(every_node_splits_its_points_and_every_point_has_a_node) {
    for (int precision = 32; precision <= 64; precision += 32)
        for (int32_t count = 1; count < 700; count = count < 20 ? count + 1 : count * 2 + 1) {
            Cloud cloud;
            cloud_make(&cloud, 2, precision, _i, count);
            char seen[1500] = {0};
            for (int32_t node = 0; node < count; node++) {
                double p[3];
                int32_t number;
                int axis;
                node_of(&cloud.tree, node, p, &number, &axis);
                EXPECT(number >= 0 && number < count && !seen[number], "point %d has two nodes", number);
                seen[number] = 1;
                EXPECT(memcmp(p, cloud.points + 3 * number, sizeof p) == 0, "point %d has moved", number);
                check_side(&cloud.tree, 2 * node + 1, node, 0);
                check_side(&cloud.tree, 2 * node + 2, node, 1);
            }
            cloud_free(&cloud);
        }
}
END_TEST

START_TEST(left_subtrees_hold_what_a_heap_holds) {
    for (int32_t n = 1; n < 5000; n++) {
        int32_t left = 0; /* nodes of the heap in the left subtree, row by row */
        for (int64_t first = 1, width = 1; first < n; first = 2 * first + 1, width *= 2)
            left += (int32_t)(first + width <= n ? width : n - first);
        ck_assert_int_eq(nph_kd_left(n), left);
    }
    ck_assert_int_eq(nph_kd_left(NPH_KD_MOST), NPH_KD_MOST / 2);
}
END_TEST

static void compare(const Cloud *cloud, const double p[3], double within, int k) {
    int32_t number[2][64];
    double squared[2][64];
    int f32 = cloud->tree.precision == 32;
    int found = (f32 ? kd_nearest_f32_base : kd_nearest_f64_base)(&cloud->tree, p, within, k, number[0], squared[0]);
    int all = (f32 ? kd_brute_f32_base : kd_brute_f64_base)(&cloud->tree, p, within, k, number[1], squared[1]);
    EXPECT(found == all, "%d points found, there are %d", found, all);
    EXPECT(memcmp(number[0], number[1], sizeof(int32_t) * (size_t)found) == 0 &&
               memcmp(squared[0], squared[1], sizeof(double) * (size_t)found) == 0,
           "not the nearest of %d points, k %d, within %g", cloud->tree.count, k, within);
}

START_TEST(the_nearest_points_are_those_of_brute_force) {
    static const int32_t counts[] = {0, 1, 2, 3, 64, 1000};
    static const int ks[] = {1, 2, 7, 50};
    for (int precision = 32; precision <= 64; precision += 32)
        for (int c = 0; c < 6; c++) {
            Cloud cloud;
            cloud_make(&cloud, 1, precision, _i, counts[c]);
            for (int32_t q = 0; q < 60; q++) {
                double p[3], within = q % 4 == 0 ? 1e30 : q % 4 == 1 ? 0.3 : q % 4 == 2 ? 4.0 : 0.0;
                for (int a = 0; a < 3; a++) p[a] = coordinate(_i, 12, q, 60, a) + (q % 7 == 0 ? 0.5 : 0.0);
                if (q % 3 == 0 && counts[c] > 0) memcpy(p, cloud.points + 3 * (q % counts[c]), sizeof p);
                compare(&cloud, p, within, ks[q % 4]);
            }
            cloud_free(&cloud);
        }
}
END_TEST

START_TEST(any_number_of_threads_builds_the_same_tree) {
    enum { COUNT = 20000 };
    static const int threads[] = {2, 3, 7};
    for (int precision = 32; precision <= 64; precision += 32) {
        Cloud one, many;
        cloud_make(&one, 1, precision, _i, COUNT);
        for (int t = 0; t < 3; t++) {
            cloud_make(&many, threads[t], precision, _i, COUNT);
            for (int32_t node = 0; node < COUNT; node++) {
                double p[2][3];
                int32_t number[2];
                int axis[2];
                node_of(&one.tree, node, p[0], &number[0], &axis[0]);
                node_of(&many.tree, node, p[1], &number[1], &axis[1]);
                EXPECT(memcmp(p[0], p[1], sizeof p[0]) == 0 && number[0] == number[1] && axis[0] == axis[1],
                       "node %d differs with %d threads", node, threads[t]);
            }
            cloud_free(&many);
        }
        cloud_free(&one);
    }
}
END_TEST

static void fill(TCase *tests) {
    tcase_add_test(tests, left_subtrees_hold_what_a_heap_holds);
    tcase_add_loop_test(tests, every_node_splits_its_points_and_every_point_has_a_node, 0, KINDS);
    tcase_add_loop_test(tests, the_nearest_points_are_those_of_brute_force, 0, KINDS);
    tcase_add_loop_test(tests, any_number_of_threads_builds_the_same_tree, 0, KINDS);
}

int main(void) { return nph_test_main("kd_tree", fill); }
