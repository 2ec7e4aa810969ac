/* SPDX-License-Identifier: Apache-2.0
 *
 * Closed meshes do not leak: rays through every vertex and every edge's middle of them, in both precisions, at all
 * scales and far from the origin; and paths that go from wall to wall inside of them. */
#include "kernel_bvh.h"
#include "shapes.h"

enum { ORIGINS = 12 };

typedef struct Closed {
    const char *name;
    int level;            /* of the subdivided icosahedron; -1: a box */
    double centre[3], scale[3];
    double rough, within; /* origins lie within this part of the scale around the centre */
} Closed;

static const Closed closed[] = {
    {"sphere", 4, {0, 0, 0}, {1, 1, 1}, 0, 0.9},
    {"sphere at 1e5 m", 4, {1e5, -1e5, 1e5}, {100, 100, 100}, 0, 0.9},
    {"star", 4, {1, 2, 3}, {1, 1, 1}, 0.5, 0.2},
    {"star at 1e5 m", 4, {-1e5, 1e5, 1e5}, {1e3, 1e3, 1e3}, 0.5, 0.2},
    {"flat star", 4, {0, 0, 0}, {1, 1e-3, 1e3}, 0.5, 0.2},
    {"tiny star", 4, {0, 0, 0}, {1e-30, 1e-30, 1e-30}, 0.5, 0.2},
    {"huge star", 4, {0, 0, 0}, {1e11, 1e11, 1e11}, 0.5, 0.2},
    {"needles", 3, {0, 0, 0}, {1e-6, 1e6, 1e6}, 0.3, 0.2},
    {"icosahedron", 0, {0, 0, 0}, {1, 1, 1}, 0, 0.7},
    {"box", -1, {0, 0, 0}, {1, 1, 1}, 0, 0.9},
    {"long box", -1, {3, 3, 3}, {1e-4, 1, 1e5}, 0, 0.9},
};

static NphMesh make(NphContext *context, const Closed *shape) {
    double lo[3], hi[3];
    if (shape->level >= 0) return ball(context, shape->level, shape->centre, shape->scale, shape->rough);
    for (int k = 0; k < 3; k++) {
        lo[k] = shape->centre[k] - shape->scale[k];
        hi[k] = shape->centre[k] + shape->scale[k];
    }
    return box(context, lo, hi);
}

START_TEST(no_ray_from_inside_escapes_through_a_vertex_or_an_edge) {
    const Closed *shape = &closed[_i];
    if (_i > 0 && !nph_test_long("rays through corners and edges of more meshes")) return;
    NphContext *context = nph_test_context(0);
    NphMesh mesh = make(context, shape);
    NphBvh bvh = bvh_of(context, &mesh, NULL);
    Random random = {99, 0};
    int64_t open = -1, through_corners = 0;
    ck_assert_int_eq(nph_mesh_open_sides(context, &mesh, &open), NPH_OK);
    ck_assert_int_eq(open, 0);
    for (int precision = 32; precision <= 64; precision += 32) {
        Rays r = rays_new(precision, (mesh.vertex_count + 3 * (int64_t)mesh.triangle_count) * ORIGINS);
        for (int origin = 0; origin < ORIGINS; origin++) {
            double o[3];
            random_direction(&random, o);
            for (int k = 0; k < 3; k++) {
                double part =
                    origin ? shape->within * pow(uniform(&random), 0.5) : 0.0; /* the first one is the centre */
                o[k] = shape->centre[k] + shape->scale[k] * part * o[k] * (shape->level < 0 ? 1.0 : 0.99);
            }
            for (int64_t i = 0; i < mesh.vertex_count; i++) rays_through(&r, o, mesh.vertices_m + 3 * i, 1e30);
            for (int64_t i = 0; i < 3 * (int64_t)mesh.triangle_count; i++) {
                int32_t a = mesh.triangles[i], b = mesh.triangles[i - i % 3 + (i + 1) % 3];
                double q[3];
                if (a > b) continue; /* the neighbour has this edge */
                for (int k = 0; k < 3; k++) q[k] = 0.5 * (mesh.vertices_m[3 * a + k] + mesh.vertices_m[3 * b + k]);
                rays_through(&r, o, q, 1e30);
            }
        }
        ck_assert_int_eq(nph_bvh_trace(context, &bvh, &r.rays), NPH_OK);
        int64_t escaped = 0, denied = 0;
        for (int64_t i = 0; i < r.rays.count; i++) {
            escaped += r.rays.number[i] < 0;
            denied += !r.rays.any[i];
            if (r.rays.number[i] < 0) continue;
            double w1 = rays_real(&r, r.rays.weight[0], i), w2 = rays_real(&r, r.rays.weight[1], i);
            through_corners += w1 == 0 || w2 == 0 || w1 + w2 == 1;
        }
        ck_assert_msg(escaped == 0 && denied == 0, "%s, f%d: %lld of %lld rays met nothing, any-hit %lld", shape->name,
                      precision, (long long)escaped, (long long)r.rays.count, (long long)denied);
        free(r.memory);
    }
    ck_assert_int_gt(through_corners, 0); /* the exact case did occur */
    nph_bvh_free(context, &bvh);
    nph_mesh_free(context, &mesh);
    nph_test_context_close(context);
}
END_TEST

/* Smooth shapes: in a corner of two walls a start may lie behind the other wall (surface_lookup.h). */
START_TEST(paths_from_wall_to_wall_never_leave_a_closed_mesh) {
    NphContext *context = nph_test_context(1);
    for (int i = 0; i < 2; i++) {
        NphMesh mesh = make(context, &closed[i]);
        NphBvh bvh = bvh_of(context, &mesh, NULL);
        ck_assert_int_eq(geometry_escapes_f32_base(&bvh, closed[i].centre, 1, 50, 2000), 0);
        ck_assert_int_eq(geometry_escapes_f64_base(&bvh, closed[i].centre, 1, 50, 2000), 0);
        nph_bvh_free(context, &bvh);
        nph_mesh_free(context, &mesh);
    }
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *tcase) {
    tcase_add_loop_test(tcase, no_ray_from_inside_escapes_through_a_vertex_or_an_edge, 0,
                        sizeof closed / sizeof closed[0]);
    tcase_add_test(tcase, paths_from_wall_to_wall_never_leave_a_closed_mesh);
}

int main(void) { return nph_test_main("watertight", fill); }
