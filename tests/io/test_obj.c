/* SPDX-License-Identifier: Apache-2.0
 *
 * Wavefront OBJ: every form of corner, polygons, what is left out, the files of reference/data/mesh, and mistakes. */
#include "mesh_file.h"

static void read_text(NphContext *context, const char *text, NphTriangles *mesh) {
    NphStatus status = nph_obj_read(context, mesh_file("mesh.obj", text, strlen(text)), mesh);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
}

static void expect_corners(const NphTriangles *mesh, int count, const int32_t *corners) {
    ck_assert_int_eq(mesh->triangles.shape[0], count);
    ck_assert_int_eq(mesh->triangles.shape[1], 3);
    for (int i = 0; i < 3 * count; i++) ck_assert_int_eq(((const int32_t *)mesh->triangles.data)[i], corners[i]);
}

START_TEST(every_form_of_corner_names_its_vertex) {
    NphContext *context = nph_test_context(1);
    NphTriangles mesh;
    read_text(context, "v 0 0 0\r\nv 1 0 0 # right\nv 0 1e0 0\n\n  \tf 1 2 3\nf 1/1 2/7 3/1\nf 1//1 2//1 3//9\n"
                       "f 1/1/1 2/1/1 3/1/1\nf -3 -2 -1\nf 4 -1 1\nv .5 -2.25 1e-3 1.0\nv 0 0 1 0.1 0.2 0.3", &mesh);
    expect_corners(&mesh, 6, (int32_t[]){0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 3, 2, 0});
    ck_assert_int_eq(mesh.vertices.shape[0], 5);
    ck_assert_int_eq(mesh.vertices.type, NPH_F64);
    const double *v = mesh.vertices.data;
    ck_assert(v[9] == 0.5 && v[10] == -2.25 && v[11] == 1e-3);
    ck_assert_str_eq(nph_test_messages(), "");
    nph_triangles_free(context, &mesh);
    nph_test_context_close(context);
}
END_TEST

START_TEST(polygons_become_fans_and_lines_may_go_on) {
    NphContext *context = nph_test_context(1);
    NphTriangles mesh;
    read_text(context, "v 0 0 \\\n0\nv 1 0 0\nv 1 1 0\\\r\n\nv 0 1 0\nv 0 .5 0\n# no \\\nf 1 2 3 \\\n 4 5\nf 1 2 3 4\n",
              &mesh);
    expect_corners(&mesh, 5, (int32_t[]){0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 1, 2, 0, 2, 3});
    nph_triangles_free(context, &mesh);
    mesh_refused(context, nph_obj_read, mesh_file("line.obj", "v 0 0 \\\n0\nv 1 1 x\nf 1 1 1\n", 27),
                 ":3: |z of vertex 2|'x'");
    nph_test_context_close(context);
}
END_TEST

START_TEST(what_is_left_out_is_named_in_one_warning) {
    NphContext *context = nph_test_context(1);
    NphTriangles mesh;
    read_text(context,
              "mtllib a.mtl\no Thing\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 0 0 1\ns off\nf 1//1 2//2 3//1\n", &mesh);
    const char *text = nph_test_messages();
    ck_assert_msg(strstr(text, "(v and f are read): mtllib, o, vn, s\n") != NULL, "%s", text);
    ck_assert(strchr(text, '\n') == strrchr(text, '\n'));
    nph_triangles_free(context, &mesh);
    nph_test_context_close(context);
}
END_TEST

START_TEST(the_meshes_of_reference_are_read_whole) {
    NphContext *context = nph_test_context(1);
    static const struct {
        const char *file;
        int64_t vertices, triangles;
        double lo[3], hi[3];
        int32_t first[3];
    } expected[2] = {
        {"suzanne.obj", 507, 967, {-1.367188, -0.984375, -0.851562}, {1.367188, 0.984375, 0.851562}, {46, 2, 44}},
        {"teapot.obj", 1179, 2256, {-3, -2, 0}, {3.42963, 2, 3.15}, {931, 949, 935}}};
    for (int m = 0; m < 2; m++) {
        char relative[64];
        NphTriangles mesh;
        snprintf(relative, sizeof relative, "reference/data/mesh/%s", expected[m].file);
        NphStatus status = nph_obj_read(context, nph_test_path(relative), &mesh);
        ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
        nph_test_messages();
        ck_assert_int_eq(mesh.vertices.shape[0], expected[m].vertices);
        ck_assert_int_eq(mesh.triangles.shape[0], expected[m].triangles);
        const double *v = mesh.vertices.data;
        for (int k = 0; k < 3; k++) {
            double lo = v[k], hi = v[k];
            for (int64_t i = 0; i < expected[m].vertices; i++) {
                lo = v[3 * i + k] < lo ? v[3 * i + k] : lo;
                hi = v[3 * i + k] > hi ? v[3 * i + k] : hi;
            }
            ck_assert(lo == expected[m].lo[k] && hi == expected[m].hi[k]);
            ck_assert_int_eq(((const int32_t *)mesh.triangles.data)[k], expected[m].first[k]);
        }
        nph_triangles_free(context, &mesh);
    }
    nph_test_context_close(context);
}
END_TEST

static const struct {
    const char *text, *wanted;
} mistakes[] = {
    {"", "no face"},
    {"v 0 0 0\n", "no face"},
    {"v 0 0\nf 1 1 1\n", ":1: |the vertex ends before z"},
    {"v 0 nan 0\nf 1 1 1\n", ":1: |y of vertex 1 is 'nan', not a finite number"},
    {"v 0 0 -inf\nf 1 1 1\n", "z of vertex 1 is '-inf'"},
    {"v 0 0 1e999\nf 1 1 1\n", "z of vertex 1 is '1e999'"},
    {"v 0 0 0x1\nf 1 1 1\n", "'0x1'"},
    {"v 0 0 0 1 2 3 4 5\nf 1 1 1\n", "more than 7 values"},
    {"v 0 0 0\nf 1 1\n#\nf 1 1 1", ":2: |a face of 2 corners"},
    {"v 0 0 0\nf 1 1 2\n", ":2: |corner '2' names no vertex|has 1"},
    {"v 0 0 0\nf 1 1 0\n", "corner '0' names no vertex"},
    {"v 0 0 0\nf 1 -2 1\nv 0 0 0\n", ":2: |corner '-2' names no vertex: the file has 2, 1 of them before"},
    {"v 0 0 0\nf 1 1 -9223372036854775808\n", "names no vertex"},
    {"v 0 0 0\nf 1 1 9223372036854775808\n", "is not a corner"},
    {"v 0 0 0\nf 1 1 1/\n", "'1/' is not a corner"},
    {"v 0 0 0\nf 1 1 1//\n", "is not a corner"},
    {"v 0 0 0\nf 1 1 1/1/1/1\n", "is not a corner"},
    {"v 0 0 0\nf 1 1 /1\n", "is not a corner"},
    {"v 0 0 0\nf 1 1 1.5\n", "'1.5' is not a corner"},
    {"v 0 0 0\nf 1 1 \x1b[2J\n", "'?[2J' is not a corner"},
};

START_TEST(mistakes_are_refused_with_their_line) {
    NphContext *context = nph_test_context(1);
    mesh_refused(context, nph_obj_read, mesh_file("wrong.obj", mistakes[_i].text, strlen(mistakes[_i].text)),
                 mistakes[_i].wanted);
    nph_test_context_close(context);
}
END_TEST

START_TEST(no_beginning_and_no_changed_byte_is_dangerous) {
    NphContext *context = nph_test_context(1);
    static const char text[] = "# c\nv 0 0 0\nv 1 0 0\nv 0 1 0\\\n\nvn 0 0 1\nf 1//1 2//1 3//1\nf -1 -2/1 -3/1/1 1\n";
    mesh_hostile(context, nph_obj_read, "hostile.obj", text, sizeof text - 1);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_failed_allocation_leaks_nothing) {
    for (int fail = 1; fail < 8; fail++) {
        NphSettings settings;
        NphContext *context = NULL;
        NphTriangles mesh;
        nph_settings_default(&settings);
        settings.threads = 1;
        settings.fail_allocation = (uint64_t)fail;
        ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
        NphStatus status = nph_obj_read(context, nph_test_path("reference/data/mesh/teapot.obj"), &mesh);
        if (status == NPH_OK) nph_triangles_free(context, &mesh);
        else ck_assert_int_eq(status, NPH_NO_MEMORY);
        ck_assert(fail > 1 || status == NPH_NO_MEMORY);
        ck_assert_uint_eq(nph_context_bytes(context), 0);
        nph_context_close(context);
    }
}
END_TEST

static void fill(TCase *tcase) {
    tcase_add_test(tcase, every_form_of_corner_names_its_vertex);
    tcase_add_test(tcase, polygons_become_fans_and_lines_may_go_on);
    tcase_add_test(tcase, what_is_left_out_is_named_in_one_warning);
    tcase_add_test(tcase, the_meshes_of_reference_are_read_whole);
    tcase_add_loop_test(tcase, mistakes_are_refused_with_their_line, 0, sizeof mistakes / sizeof mistakes[0]);
    tcase_add_test(tcase, no_beginning_and_no_changed_byte_is_dangerous);
    tcase_add_test(tcase, a_failed_allocation_leaks_nothing);
}

int main(void) { return nph_test_main("obj", fill); }
