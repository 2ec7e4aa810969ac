/* SPDX-License-Identifier: Apache-2.0
 *
 * Meshes: areas and volumes with known values, degenerate triangles, sides without partners, and refusals. */
#include "io/triangles.h"
#include "shapes.h"

#define PI 3.14159265358979324

START_TEST(areas_and_volume_of_a_box_are_exact) {
    NphContext *context = nph_test_context(1);
    NphMesh mesh = box(context, (double[]){1, 2, 3}, (double[]){2, 4, 8});
    ck_assert(mesh.area_m2 == 2 * (1 * 2 + 2 * 5 + 5 * 1) && nph_mesh_volume(&mesh) == 10);
    ck_assert(mesh.areas_m2[0] == 1 && mesh.dropped == 0);
    for (int i = 0; i < 12; i++) {
        int32_t swap = mesh.triangles[3 * i];
        mesh.triangles[3 * i] = mesh.triangles[3 * i + 1];
        mesh.triangles[3 * i + 1] = swap;
    }
    ck_assert(nph_mesh_volume(&mesh) == -10);
    nph_mesh_free(context, &mesh);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_subdivided_icosahedron_is_closed_and_nears_the_sphere_by_4_per_level) {
    NphContext *context = nph_test_context(1);
    double before = 0;
    for (int level = 0; level < 5; level++) {
        int64_t open = -1;
        NphMesh mesh = ball(context, level, (double[]){5, 6, 7}, (double[]){2, 2, 2}, 0);
        double miss = 4.0 / 3.0 * PI * 8 - nph_mesh_volume(&mesh);
        ck_assert_int_eq(nph_mesh_open_sides(context, &mesh, &open), NPH_OK);
        ck_assert_int_eq(open, 0);
        ck_assert_int_eq(mesh.triangle_count, 20 << 2 * level);
        ck_assert_int_eq(mesh.vertex_count, (10 << 2 * level) + 2);
        ck_assert(miss > 0 && (level < 2 || fabs(before / miss - 4) < 0.3));
        before = miss;
        nph_mesh_free(context, &mesh);
    }
    nph_test_context_close(context);
}
END_TEST

/* 47 and 104 were counted by another program. */
START_TEST(the_open_sides_of_the_reference_meshes_are_found) {
    static const char *const files[2] = {"reference/data/mesh/suzanne.obj", "reference/data/mesh/teapot.obj"};
    static const int64_t expected[2] = {47, 104};
    NphContext *context = nph_test_context(1);
    for (int i = 0; i < 2; i++) {
        NphTriangles file;
        NphMesh mesh;
        int64_t open = -1;
        ck_assert_int_eq(nph_obj_read(context, nph_test_path(files[i]), &file), NPH_OK);
        ck_assert_int_eq(nph_mesh_make(context, files[i], &file.vertices, &file.triangles, &mesh), NPH_OK);
        ck_assert_int_eq(mesh.dropped, 0);
        ck_assert_int_eq(nph_mesh_open_sides(context, &mesh, &open), NPH_OK);
        ck_assert_int_eq(open, expected[i]);
        nph_triangles_free(context, &file);
        nph_mesh_free(context, &mesh);
    }
    nph_test_messages();
    nph_test_context_close(context);
}
END_TEST

START_TEST(triangles_with_two_corners_in_a_point_are_dropped_and_slivers_kept) {
    NphContext *context = nph_test_context(1);
    const double v[15] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 2, 0, 0, 0.0, -0.0, 0};
    const int32_t t[15] = {0, 0, 1, 0, 1, 2, 0, 1, 3, 4, 2, 0, 1, 2, 3};
    NphMesh mesh = mesh_of(context, v, 5, t, 5);
    ck_assert_int_eq(mesh.dropped, 2);
    ck_assert_int_eq(mesh.triangle_count, 3);
    ck_assert(mesh.areas_m2[0] == 0.5 && mesh.areas_m2[1] == 0 && mesh.areas_m2[2] == 0.5 && mesh.area_m2 == 1);
    ck_assert_int_eq(mesh.triangles[3], 0);
    ck_assert_int_eq(mesh.triangles[5], 3);
    nph_mesh_free(context, &mesh);
    nph_test_context_close(context);
}
END_TEST

static void refuse(NphContext *context, const NphArray *v, const NphArray *t, NphStatus wanted, const char *words) {
    NphMesh mesh = {.dropped = 77};
    ck_assert_int_eq(nph_mesh_make(context, "thing", v, t, &mesh), wanted);
    ck_assert_int_eq(mesh.dropped, 77);
    const char *text = nph_test_messages();
    ck_assert_msg(strstr(text, words) != NULL, "%s", text);
}

START_TEST(bad_vertices_and_corners_are_refused_by_name) {
    NphContext *context = nph_test_context(1);
    double v[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    float w[9] = {0, 0, 0, 1, 0, 0, 0, INFINITY, 0};
    int32_t c[6] = {0, 1, 2, 0, 1, 2};
    NphArray vertices = {.type = NPH_F64, .rank = 2, .shape = {3, 3, 1, 1, 1, 1}, .data = v};
    NphArray floats = {.type = NPH_F32, .rank = 2, .shape = {3, 3, 1, 1, 1, 1}, .data = w};
    NphArray triangles = {.type = NPH_I32, .rank = 2, .shape = {2, 3, 1, 1, 1, 1}, .data = c};
    refuse(context, &floats, &triangles, NPH_BAD_INPUT, "thing: y of vertex 2 is not finite");
    v[3] = NAN;
    refuse(context, &vertices, &triangles, NPH_BAD_INPUT, "thing: x of vertex 1 is not finite");
    v[3] = 1;
    c[5] = 3;
    refuse(context, &vertices, &triangles, NPH_BAD_INPUT, "triangle 1 names vertex 3; the mesh has 3");
    c[5] = -1;
    refuse(context, &vertices, &triangles, NPH_BAD_INPUT, "triangle 1 names vertex -1");
    refuse(context, &triangles, &triangles, NPH_BAD_USAGE, "vertices must be");
    refuse(context, &vertices, &vertices, NPH_BAD_USAGE, "triangles must be");
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *tcase) {
    tcase_add_test(tcase, areas_and_volume_of_a_box_are_exact);
    tcase_add_test(tcase, a_subdivided_icosahedron_is_closed_and_nears_the_sphere_by_4_per_level);
    tcase_add_test(tcase, the_open_sides_of_the_reference_meshes_are_found);
    tcase_add_test(tcase, triangles_with_two_corners_in_a_point_are_dropped_and_slivers_kept);
    tcase_add_test(tcase, bad_vertices_and_corners_are_refused_by_name);
}

int main(void) { return nph_test_main("mesh", fill); }
