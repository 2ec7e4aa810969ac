/* SPDX-License-Identifier: Apache-2.0
 *
 * The hierarchy: its closest hit is that of brute force to the bit, its any-hit says whether there is one, its nodes
 * hold what they should, the build gives the same bytes, and degenerate meshes are no exception. */
#include <stdio.h>

#include "core/memory.h"
#include "kernel_bvh.h"
#include "shapes.h"

#define EXPECT(condition, ...)                       \
    do {                                             \
        if (!(condition)) ck_abort_msg(__VA_ARGS__); \
    } while (0)

/* Rays of every kind: between random points, at corners and edges, along axes with zeros of both signs, in the planes
 * of triangles, of all lengths. */
static void mixed_rays(Rays *r, const NphMesh *mesh, const double centre[3], double size, uint32_t seed) {
    Random random = {seed, 1};
    r->rays.count = 0;
    while (r->rays.count < r->room) {
        const int32_t *c = mesh->triangles + 3 * (int64_t)(uniform(&random) * mesh->triangle_count);
        double o[3], q[3], w[3], t_max = uniform(&random) < 0.5 ? 1e30 : 2 * uniform(&random);
        int kind = (int)(uniform(&random) * 6), axis = (int)(uniform(&random) * 3);
        for (int k = 0; k < 3; k++) o[k] = centre[k] + 3 * size * (2 * uniform(&random) - 1);
        for (int k = 0; k < 3; k++) q[k] = centre[k] + size * (2 * uniform(&random) - 1);
        for (int k = 0; k < 3; k++) w[k] = mesh->vertices_m[3 * (int64_t)c[0] + k];
        for (int k = 0; k < 3; k++) {
            double b = mesh->vertices_m[3 * (int64_t)c[1] + k], a = mesh->vertices_m[3 * (int64_t)c[2] + k];
            if (kind == 1) q[k] = w[k];
            if (kind == 2) q[k] = 0.5 * (w[k] + b);
            if (kind == 3 && k != axis) o[k] = q[k] = w[k];
            if (kind == 4) o[k] = w[k] + 3 * (b - w[k]), q[k] = 0.25 * (a + 3 * b);
        }
        rays_through(r, o, q, t_max);
        if (kind == 3 && uniform(&random) < 0.5)
            for (int k = 0; k < 3; k++)
                if (k != axis) rays_put(r, 3 + k, r->rays.count - 1, -0.0);
    }
}

static void expect_brute(NphContext *context, const NphBvh *bvh, Rays *r, int64_t *hits) {
    Rays brute = rays_new(r->rays.precision, r->room);
    for (int k = 0; k < 7; k++) brute.rays.ray[k] = r->rays.ray[k];
    brute.rays.count = r->rays.count;
    ck_assert_int_eq(nph_bvh_trace(context, bvh, &r->rays), NPH_OK);
    (r->rays.precision == 32 ? geometry_brute_f32_base : geometry_brute_f64_base)(bvh, &brute.rays);
    for (int64_t i = 0; i < r->rays.count; i++) {
        EXPECT(r->rays.number[i] == brute.rays.number[i], "ray %lld: triangle %d, not %d", (long long)i,
               (int)r->rays.number[i], (int)brute.rays.number[i]);
        EXPECT(r->rays.any[i] == (r->rays.number[i] >= 0), "ray %lld: any-hit says %d", (long long)i, r->rays.any[i]);
        if (r->rays.number[i] < 0) continue;
        ++*hits;
        EXPECT(rays_real(r, r->rays.t, i) == rays_real(r, brute.rays.t, i), "ray %lld: t", (long long)i);
        for (int k = 0; k < 2; k++)
            EXPECT(rays_real(r, r->rays.weight[k], i) == rays_real(r, brute.rays.weight[k], i), "ray %lld: weight",
                   (long long)i);
    }
    free(brute.memory);
}

static const struct {
    double centre[3], size, spread;
} soups[] = {{{0, 0, 0}, 1, 1},       {{0, 0, 0}, 1, 1e3},      {{1e5, -1e5, 2e5}, 1, 10},
             {{1e5, 0, 0}, 1e-2, 2},  {{0, 0, 0}, 1e-25, 1e4},  {{0, 0, 0}, 1e10, 1e12},
             {{0, 0, 0}, 1e3, 1e7}};

START_TEST(closest_hit_is_that_of_brute_force_to_the_bit) {
    NphContext *context = nph_test_context(1);
    for (int precision = 32; precision <= 64; precision += 32) {
        int64_t hits = 0;
        NphMesh mesh = soup(context, 5 + (uint32_t)_i, 300, soups[_i].centre, soups[_i].size, soups[_i].spread);
        NphBvh bvh = bvh_of(context, &mesh, NULL);
        Rays r = rays_new(precision, 4000);
        mixed_rays(&r, &mesh, soups[_i].centre, soups[_i].size, 9);
        expect_brute(context, &bvh, &r, &hits);
        ck_assert_int_gt(hits, 200);
        free(r.memory);
        nph_bvh_free(context, &bvh);
        nph_mesh_free(context, &mesh);
    }
    nph_test_context_close(context);
}
END_TEST

/* A lattice of squares at whole coordinates, every triangle three times: ties everywhere. */
START_TEST(of_hits_at_equal_t_the_lowest_number_wins) {
    NphContext *context = nph_test_context(1);
    double v[25 * 3];
    int32_t t[96 * 3];
    for (int i = 0; i < 25; i++) {
        v[3 * i] = i % 5 - 2;
        v[3 * i + 1] = i / 5 - 2;
        v[3 * i + 2] = 1;
    }
    for (int i = 0; i < 96; i++) {
        int cell = i % 16, a = cell / 4 * 5 + cell % 4, other = i / 16 % 2;
        t[3 * i] = a;
        t[3 * i + 1] = other ? a + 6 : a + 1;
        t[3 * i + 2] = other ? a + 5 : a + 6;
    }
    NphMesh mesh = mesh_of(context, v, 25, t, 96);
    NphBvh bvh = bvh_of(context, &mesh, NULL);
    for (int precision = 32; precision <= 64; precision += 32) {
        int64_t hits = 0;
        Rays r = rays_new(precision, 81);
        for (int i = 0; i < 81; i++)
            rays_through(&r, (double[]){0, 0, 0}, (double[]){0.5 * (i % 9) - 2, 0.5 * (i / 9) - 2, 1}, 1e30);
        expect_brute(context, &bvh, &r, &hits);
        ck_assert_int_eq(hits, 81);
        for (int i = 0; i < 81; i++) ck_assert_int_lt(r.rays.number[i], 32); /* never a copy */
        ck_assert_int_eq(r.rays.number[40], 5); /* six triangles meet in the middle: 5, 6, 9, 10, 21, ... */
        free(r.memory);
    }
    nph_bvh_free(context, &bvh);
    nph_mesh_free(context, &mesh);
    nph_test_context_close(context);
}
END_TEST

/* Every triangle in one leaf, every box around what is below it, in both precisions; returns the depth. */
static int check_node(const NphBvh *bvh, int32_t number, int32_t *next_triangle, int32_t *next_node) {
    const NphBvhNode *node = &bvh->nodes[number];
    EXPECT(number == (*next_node)++, "node %d is not in depth-first order", (int)number);
    if (node->count > 0) {
        EXPECT(node->first == *next_triangle, "leaf %d", (int)number);
        *next_triangle += node->count;
        for (int32_t i = node->first; i < node->first + node->count; i++)
            for (int j = 0; j < 9; j++) {
                int64_t at = 3 * (int64_t)bvh->triangles[i].corner[j / 3] + j % 3;
                double x = bvh->vertices[at], lo = node->lo[j % 3], hi = node->hi[j % 3];
                EXPECT(lo <= x && x <= hi, "f64 vertex outside leaf %d", (int)number);
                EXPECT(lo <= bvh->vertices_f32[at] && bvh->vertices_f32[at] <= hi, "f32 vertex outside leaf %d",
                       (int)number);
            }
        return 1;
    }
    const NphBvhNode *children[2] = {node + 1, &bvh->nodes[node->first]};
    for (int c = 0; c < 2; c++)
        for (int k = 0; k < 3; k++)
            EXPECT(node->lo[k] <= children[c]->lo[k] && node->hi[k] >= children[c]->hi[k], "child outside %d",
                   (int)number);
    int left = check_node(bvh, number + 1, next_triangle, next_node);
    int right = check_node(bvh, node->first, next_triangle, next_node);
    return 1 + (left > right ? left : right);
}

static int check_tree(const NphBvh *bvh) {
    int32_t triangles = 0, nodes = 0;
    if (bvh->triangle_count == 0) {
        ck_assert_int_eq(bvh->node_count, 0);
        return 0;
    }
    int depth = check_node(bvh, 0, &triangles, &nodes);
    unsigned char *seen = calloc((size_t)bvh->triangle_count, 1);
    for (int32_t i = 0; i < bvh->triangle_count; i++)
        EXPECT(!seen[bvh->triangles[i].number]++, "a triangle is there twice");
    free(seen);
    ck_assert_int_eq(triangles, bvh->triangle_count);
    ck_assert_int_eq(nodes, bvh->node_count);
    ck_assert_int_le(depth, NPH_BVH_DEPTH);
    return depth;
}

START_TEST(build_gives_the_same_bytes_for_any_number_of_threads) {
    static const double origin[3] = {0.1, 0.2, 0.3};
    NphContext *one = nph_test_context(1), *four = nph_test_context(4);
    NphMesh mesh = soup(one, 3, 20000, (double[]){10, 20, 30}, 5, 100);
    NphBvh a = bvh_of(one, &mesh, origin), b = bvh_of(four, &mesh, origin);
    check_tree(&a);
    ck_assert_int_eq(a.node_count, b.node_count);
    ck_assert_int_eq(memcmp(a.nodes, b.nodes, (size_t)a.node_count * sizeof *a.nodes), 0);
    ck_assert_int_eq(memcmp(a.triangles, b.triangles, (size_t)a.triangle_count * sizeof *a.triangles), 0);
    ck_assert_int_eq(memcmp(a.vertices_f32, b.vertices_f32, (size_t)a.vertex_count * 12), 0);
    nph_bvh_free(one, &a);
    nph_bvh_free(four, &b);
    nph_mesh_free(one, &mesh);
    nph_test_context_close(four);
    nph_test_context_close(one);
}
END_TEST

START_TEST(origin_is_subtracted_and_meshes_are_numbered_one_after_another) {
    NphContext *context = nph_test_context(1);
    static const double origin[3] = {1e7, 0, 0};
    NphMesh meshes[3] = {box(context, (double[]){1e7 - 1, -1, -1}, (double[]){1e7 + 1, 1, 1}), {0},
                         box(context, (double[]){1e7 - 2, -2, -2}, (double[]){1e7 + 2, 2, 2})};
    NphBvh bvh;
    Rays r = rays_new(32, 2);
    ck_assert_int_eq(nph_bvh_build(context, meshes, 3, origin, &bvh), NPH_OK);
    check_tree(&bvh);
    ck_assert_int_eq(bvh.mesh_first[1], 12);
    ck_assert_int_eq(bvh.mesh_first[2], 12);
    ck_assert_int_eq(bvh.mesh_first[3], 24);
    rays_through(&r, (double[]){0, 0.25, 0.125}, (double[]){1, 0.25, 0.125}, 1e30);
    rays_through(&r, (double[]){1.5, 0.25, 0.125}, (double[]){3, 0.25, 0.125}, 1e30);
    ck_assert_int_eq(nph_bvh_trace(context, &bvh, &r.rays), NPH_OK);
    ck_assert(r.rays.number[0] < 12 && rays_real(&r, r.rays.t, 0) == 1);
    ck_assert(r.rays.number[1] >= 12 && fabs(rays_real(&r, r.rays.t, 1) - 1.0 / 3.0) < 1e-7);
    free(r.memory);
    nph_bvh_free(context, &bvh);
    for (int m = 0; m < 3; m += 2) nph_mesh_free(context, &meshes[m]);
    nph_test_context_close(context);
}
END_TEST

/* Where the middles of boxes allow no split, and where they call for the deepest one. */
START_TEST(degenerate_meshes_make_sound_trees) {
    NphContext *context = nph_test_context(1);
    enum { COPIES = 5000, OCTAVES = 180 };
    static double v[9 * COPIES];
    static int32_t t[3 * COPIES];
    for (int kind = 0; kind < 5; kind++) {
        int count = kind == 0 ? 0 : kind == 1 ? 1 : kind == 4 ? 3 * OCTAVES : COPIES;
        for (int i = 0; i < 3 * count; i++) {
            double scale = kind == 3 ? 1 + (double)(i / 3) / COPIES : 1; /* 2: copies, 3: the same middle, 4: octaves */
            v[3 * i] = (i % 3 == 1 ? 1 : -1) * scale;
            v[3 * i + 1] = (i % 3 == 2 ? 1 : -1) * scale;
            v[3 * i + 2] = (i % 3 == 0 ? -1 : 1) * scale;
            if (kind == 4)
                for (int k = 0; k < 3; k++)
                    v[3 * i + k] = ldexp((k == i / 3 / OCTAVES) + 0.01 * v[3 * i + k], i / 3 % OCTAVES - 142);
            t[i] = i;
        }
        NphMesh mesh = mesh_of(context, v, 3 * count, t, count);
        NphBvh bvh = bvh_of(context, &mesh, NULL);
        int depth = check_tree(&bvh);
        ck_assert(kind < 2 ? depth == kind : depth > 5);
        for (int precision = 32; precision <= 64; precision += 32) {
            int64_t hits = 0;
            Rays r = rays_new(precision, 20);
            for (int i = 0; i < 20; i++)
                rays_through(&r, (double[]){0, 0, -5}, (double[]){-0.25 + 0.001 * i, -0.25, 0}, 1e30);
            expect_brute(context, &bvh, &r, &hits);
            ck_assert_int_eq(hits, kind == 0 || kind == 4 ? 0 : 20);
            free(r.memory);
        }
        nph_bvh_free(context, &bvh);
        nph_mesh_free(context, &mesh);
    }
    nph_test_context_close(context);
}
END_TEST

START_TEST(far_vertices_and_wrong_precisions_are_refused) {
    NphContext *context = nph_test_context(1);
    NphMesh mesh = box(context, (double[]){0, 0, 0}, (double[]){1, 1, 2e12});
    NphBvh bvh = {.node_count = 77};
    ck_assert_int_eq(nph_bvh_build(context, &mesh, 1, (double[]){0, 0, 0}, &bvh), NPH_BAD_INPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "mesh 0: z of vertex 4 lies 2e+12 m"));
    ck_assert_int_eq(nph_bvh_build(context, &mesh, 1, (double[]){0, 0, NAN}, &bvh), NPH_BAD_INPUT);
    nph_test_messages();
    ck_assert_int_eq(bvh.node_count, 77);
    ck_assert_int_eq(nph_bvh_build(context, &mesh, 1, (double[]){0, 0, 1e12}, &bvh), NPH_OK);
    NphBvhRays rays = {.precision = 16};
    ck_assert_int_eq(nph_bvh_trace(context, &bvh, &rays), NPH_BAD_USAGE);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "precision 16"));
    nph_bvh_free(context, &bvh);
    nph_mesh_free(context, &mesh);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_failed_allocation_leaks_nothing) {
    NphContext *builder = nph_test_context(1);
    NphMesh mesh = box(builder, (double[]){0, 0, 0}, (double[]){1, 1, 1});
    int failed = 0;
    for (int fail = 1; fail < 12; fail++) {
        NphSettings settings;
        NphContext *context = NULL;
        NphBvh bvh;
        nph_settings_default(&settings);
        settings.threads = 1;
        settings.fail_allocation = (uint64_t)fail;
        ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
        NphStatus status = nph_bvh_build(context, &mesh, 1, (double[]){0, 0, 0}, &bvh);
        if (status == NPH_OK) nph_bvh_free(context, &bvh);
        failed += status == NPH_NO_MEMORY;
        ck_assert_uint_eq(nph_context_bytes(context), 0);
        nph_context_close(context);
    }
    ck_assert_int_eq(failed, 8);
    nph_mesh_free(builder, &mesh);
    nph_test_context_close(builder);
}
END_TEST

static void fill(TCase *tcase) {
    tcase_add_loop_test(tcase, closest_hit_is_that_of_brute_force_to_the_bit, 0, sizeof soups / sizeof soups[0]);
    tcase_add_test(tcase, of_hits_at_equal_t_the_lowest_number_wins);
    tcase_add_test(tcase, build_gives_the_same_bytes_for_any_number_of_threads);
    tcase_add_test(tcase, origin_is_subtracted_and_meshes_are_numbered_one_after_another);
    tcase_add_test(tcase, degenerate_meshes_make_sound_trees);
    tcase_add_test(tcase, far_vertices_and_wrong_precisions_are_refused);
    tcase_add_test(tcase, a_failed_allocation_leaks_nothing);
}

int main(void) { return nph_test_main("bvh", fill); }
