/* SPDX-License-Identifier: Apache-2.0
 *
 * Volumes that a scene names: loaded where they should lie, and, when missing or damaged, reported with their path and
 * with their place in the scene. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/text.h"
#include "harness.h"
#include "io/volume.h"
#include "scene/model.h"

#define HEAD "nephos: 1\ncamera: {resolution: [4, 3], position: [0, -4, 0], look_at: [0, 0, 0], fov: 35}\n"

static NphStatus parse(NphContext *context, const char *text, NphScene **scene) {
    *scene = NULL;
    return nph_scene_parse(context, text, strlen(text), "s", nph_test_temporary("."), scene);
}

static NphScene *must_parse(NphContext *context, const char *text) {
    NphScene *scene;
    ck_assert_msg(parse(context, text, &scene) == NPH_OK, "%s\n%s", text, nph_test_messages());
    return scene;
}

static void check3(const double *values, double x, double y, double z) {
    ck_assert_msg(values[0] == x && values[1] == y && values[2] == z, "%.17g %.17g %.17g, not %.17g %.17g %.17g",
                  values[0], values[1], values[2], x, y, z);
}

/* A volume of 4 x 3 x 2 (x, y, z) cells, value 1 + x + 10 y + 100 z, but the one at `odd`, which is `value`. */
static void write_npy(NphContext *context, const char *name, int odd, float value) {
    NphArray array = {0};
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 3, (int64_t[]){2, 3, 4}, "test", &array), NPH_OK);
    float *cells = array.data;
    for (int i = 0; i < 24; i++) cells[i] = (float)(1 + i % 4 + 10 * (i / 4 % 3) + 100 * (i / 12));
    if (odd >= 0) cells[odd] = value;
    ck_assert_int_eq(nph_npy_write(context, nph_test_temporary(name), &array), NPH_OK);
    nph_array_free(context, &array);
}

static void write_bytes(const char *name, const void *bytes, size_t size) {
    FILE *file = fopen(nph_test_temporary(name), "wb");
    ck_assert_ptr_nonnull(file);
    ck_assert_uint_eq(fwrite(bytes, 1, size, file), size);
    ck_assert_int_eq(fclose(file), 0);
}

START_TEST(a_volume_lies_where_its_box_and_transform_say) {
    NphContext *context = nph_test_context(1);
    double lo[3], hi[3];
    write_npy(context, "a.npy", -1, 0);
    NphScene *scene = must_parse(context, HEAD
        "media:\n"
        "- density: {file: a.npy, box: [[0, 0, 0], [8, 6, 4]]}\n"
        "  extinction: 1\n"
        "- density: {file: a.npy, box: [[0, 0, 0], [6, 4, 2]], centring: point, outside: clamp, lookup: nearest}\n"
        "  extinction: 1\n"
        "  transform: [{scale: 2}, {translate: [10, 0, 0]}]\n");
    const NphMedium *m = scene->media;
    nph_medium_bounds(&m[0], lo, hi);
    check3(lo, 0, 0, 0);
    check3(hi, 8, 6, 4);
    nph_medium_bounds(&m[1], lo, hi);
    check3(lo, 10, 0, 0);
    check3(hi, 22, 8, 4);
    nph_scene_bounds(scene, lo, hi);
    check3(lo, 0, 0, 0);
    check3(hi, 22, 8, 4);
    ck_assert(m[0].grid.lookup == NPH_LOOKUP_TRILINEAR && m[1].grid.lookup == NPH_LOOKUP_NEAREST);
    ck_assert(m[0].grid.min == 1 && m[0].grid.max == 124 && m[0].grid.active == 24);
    /* sample (1, 1, 1) of lattice space is the first cell: its middle, or the corner of the box */
    const double *cell = m[0].world_from_medium, *point = m[1].world_from_medium;
    for (int axis = 0; axis < 3; axis++) {
        ck_assert_double_eq(cell[axis * 4] + cell[axis * 4 + 1] + cell[axis * 4 + 2] + cell[axis * 4 + 3], 1);
        ck_assert_double_eq(point[axis * 4] + point[axis * 4 + 1] + point[axis * 4 + 2] + point[axis * 4 + 3],
                            axis ? 0 : 10);
    }
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

/* The same 4 x 3 x 2 cells as .vol, as pbrt text and as .npy: the box comes from the file, and so does what lies outside
 * it: Mitsuba clamps, pbrt falls to zero. */
START_TEST(grids_of_mitsuba_and_pbrt_are_the_array_in_their_own_box) {
    NphContext *context = nph_test_context(1);
    NphBoxGrid box = {.lo = {-1, 0, 1}, .hi = {7, 6, 5}};
    char text[1000] = "MakeNamedMedium \"other\" \"string type\" \"uniformgrid\" \"float density\" 3\n"
                      "MakeNamedMedium \"cloud\" \"string type\" \"uniformgrid\" \"integer nx\" 4 \"integer ny\" 3\n"
                      "\"integer nz\" 2 \"point3 p0\" [-1 0 1] \"point3 p1\" [7 6 5] \"float density\" [";
    write_npy(context, "a.npy", -1, 0);
    ck_assert_int_eq(nph_npy_read(context, nph_test_temporary("a.npy"), &box.values), NPH_OK);
    ck_assert_int_eq(nph_vol_write(context, nph_test_temporary("a.vol"), &box), NPH_OK);
    for (int i = 0; i < 24; i++)
        snprintf(text + strlen(text), sizeof text - strlen(text), " %d", (int)((float *)box.values.data)[i]);
    strcat(text, "]\n");
    write_bytes("a.pbrt", text, strlen(text));
    nph_box_grid_free(context, &box);
    NphScene *scene = must_parse(context, HEAD
        "media:\n"
        "- density: {file: a.npy, box: [[-1, 0, 1], [7, 6, 5]], outside: clamp}\n  extinction: 1\n"
        "- density: {file: a.vol}\n  extinction: 1\n"
        "- density: {file: a.npy, box: [[-1, 0, 1], [7, 6, 5]]}\n  extinction: 1\n"
        "- density: {file: a.pbrt, grid: cloud}\n  extinction: 1\n");
    for (int i = 0; i < 4; i += 2) {
        const NphMedium *a = &scene->media[i], *b = &scene->media[i + 1];
        ck_assert_mem_eq(a->world_from_medium, b->world_from_medium, sizeof a->world_from_medium);
        ck_assert_mem_eq(a->grid.n, b->grid.n, sizeof a->grid.n);
        ck_assert_int_eq(a->grid.brick_count, b->grid.brick_count);
        ck_assert_mem_eq(a->grid.values, b->grid.values, (size_t)a->grid.brick_count * NPH_BRICK_STRIDE * sizeof(float));
    }
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(an_openvdb_grid_is_the_same_medium_as_its_nanovdb_copy) {
    NphContext *context = nph_test_context(1);
    char text[3000];
    snprintf(text, sizeof text, HEAD "media:\n- density: {file: %s}\n  extinction: 1\n- density: {file: %s, grid: density, "
             "centring: vdb}\n  extinction: 1\n", nph_test_path("reference/data/smoke/smoke_0024.zip.nvdb"),
             nph_test_path("reference/data/vdb/smoke_0024.vdb"));
    NphScene *scene = must_parse(context, text);
    const NphGrid *a = &scene->media[0].grid, *b = &scene->media[1].grid;
    ck_assert_mem_eq(scene->media[0].world_from_medium, scene->media[1].world_from_medium, 12 * sizeof(double));
    ck_assert_mem_eq(a->n, b->n, sizeof a->n);
    ck_assert_mem_eq(a->lo, b->lo, sizeof a->lo);
    ck_assert_int_eq(a->brick_count, b->brick_count);
    ck_assert_mem_eq(a->values, b->values, (size_t)a->brick_count * NPH_BRICK_STRIDE * sizeof(float));
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_grid_of_colours_is_no_density) {
    NphContext *context = nph_test_context(1);
    NphBoxGrid box = {.hi = {1, 1, 1}};
    NphScene *scene;
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 4, (int64_t[]){2, 2, 2, 3}, "test", &box.values), NPH_OK);
    ck_assert_int_eq(nph_vol_write(context, nph_test_temporary("rgb.vol"), &box), NPH_OK);
    nph_box_grid_free(context, &box);
    ck_assert_int_eq(parse(context, HEAD "media:\n- density: {file: rgb.vol}\n  extinction: 1\n", &scene), NPH_BAD_INPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "has 3 channels; a density has one"));
    nph_test_context_close(context);
}
END_TEST

START_TEST(cloud_fields_are_cells_around_their_points_or_end_at_them_as_the_scene_says) {
    NphContext *context = nph_test_context(1);
    double lo[3], hi[3];
    static const char les[] = "# points\n2,3,2\n0.5,0.25\n1.0,1.5\nx,y,z,lwc,reff\n0,0,0,0.2,10\n1,2,1,0.4,10\n";
    write_bytes("les.txt", les, sizeof les - 1);
    NphScene *scene = must_parse(context, HEAD
        "media:\n- {density: {file: les.txt, centring: cell}, extinction: 1}\n"
        "- {density: {file: les.txt, centring: point}, extinction: 1}\n");
    nph_medium_bounds(&scene->media[0], lo, hi);
    check3(lo, -250, -125, 750);
    check3(hi, 750, 625, 1750);
    nph_medium_bounds(&scene->media[1], lo, hi);
    check3(lo, 0, 0, 1000);
    check3(hi, 500, 500, 1500);
    ck_assert_float_eq_tol(scene->media[0].grid.max, 0.06f, 1e-8f); /* 1.5 * 0.4 / 10 */
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

typedef struct Expected {
    const char *name;
    double lo[3], hi[3], max, sum;
    int64_t active;
} Expected;

START_TEST(the_reference_scenes_load_and_their_volumes_lie_where_they_should) {
    static const Expected expected[] = {
        {"cube_g000", {0, 0, 0}, {1, 1, 1}, 0, 0, 0}, {"cube_g070", {0, 0, 0}, {1, 1, 1}, 0, 0, 0},
        {"cube_g095", {0, 0, 0}, {1, 1, 1}, 0, 0, 0},
        {"slab", {HUGE_VAL, HUGE_VAL, 0}, {-HUGE_VAL, -HUGE_VAL, 1}, 0, 0, 0},
        {"rico", {0, 0, 420}, {2440, 2120, 1980}, 0.105171, 260.859, 15905},
        {"smoke", {0, 0, 0}, {1, 1, 1}, 13.942362, 1550625.236, 315075},
        {"smoke_ground", {0, 0, 0}, {1.587729, 1, 1}, 13.942362, 1550625.236, 315075},
        {"smoke_seq", {11.5 / 24, 10.5 / 24, 0.5 / 24}, {60.5 / 24, 62.5 / 24, 60.5 / 24}, 0.9847858548, 8980.08800148667, 40752},
        {"les_stcu", {-27.5, -27.5, 425.53333}, {3492.5, 3492.5, 824.46667}, 0.264541, 1113.88, 24789},
        {"night", {-613.982524, -562.387354, 601.012075}, {510.792184, 407.601843, 1158.239911}, 1, 1453017.8, 1526233},
        {"cumulus", {-1.534956, -1.405968, -0.322470}, {1.276980, 1.019005, 1.070600}, 1, 1453017.8, 1526233}};
    NphContext *context = nph_test_context(0);
    for (size_t i = 0; i < sizeof expected / sizeof expected[0]; i++) {
        const Expected *e = &expected[i];
        char path[64];
        double lo[3], hi[3];
        NphScene *scene = NULL;
        snprintf(path, sizeof path, "reference/scenes/%s.yaml", e->name);
        ck_assert_msg(nph_scene_load(context, nph_test_path(path), &scene) == NPH_OK, "%s", nph_test_messages());
        nph_scene_bounds(scene, lo, hi);
        for (int axis = 0; axis < 3; axis++) {
            ck_assert_msg(lo[axis] == e->lo[axis] || fabs(lo[axis] - e->lo[axis]) < 1e-5, "%s %.17g", e->name,
                          lo[axis]);
            ck_assert_msg(hi[axis] == e->hi[axis] || fabs(hi[axis] - e->hi[axis]) < 1e-5, "%s %.17g", e->name,
                          hi[axis]);
        }
        const NphGrid *grid = &scene->media[0].grid;
        ck_assert_msg(fabs((double)grid->max - e->max) <= 1e-5 * e->max, "%s max %.9g", e->name, (double)grid->max);
        ck_assert_msg(fabs(grid->sum - e->sum) <= 1e-5 * e->sum, "%s sum %.9g", e->name, grid->sum);
        ck_assert_msg(grid->active == e->active, "%s active %lld", e->name, (long long)grid->active);
        nph_scene_free(context, scene);
    }
    nph_test_context_close(context);
}
END_TEST

START_TEST(missing_and_damaged_files_are_named_with_their_place_in_the_scene) {
    NphContext *context = nph_test_context(1);
    NphScene *scene;
    write_npy(context, "a.npy", -1, 0);
    write_npy(context, "nan.npy", 13, (float)NAN);
    write_npy(context, "negative.npy", 0, -1);
    write_bytes("cut.npy", "\x93NUMPY\1\0", 8);
    write_bytes("noise.nvdb", "certainly not a volume", 22);
    write_bytes("empty.txt", "", 0);
    const char *text = HEAD
        "media:\n"
        "- {density: {file: nan.npy, box: [[0, 0, 0], [1, 1, 1]]}, extinction: 1}\n"
        "- {density: {file: a.npy, box: [[0, 0, 0], [1, 1, 1]]}, extinction: 1}\n"
        "- {density: {file: cut.npy, box: [[0, 0, 0], [1, 1, 1]]}, extinction: 1}\n"
        "- {density: {file: noise.nvdb}, extinction: 1}\n"
        "- {density: {file: empty.txt, centring: cell}, extinction: 1}\n"
        "- {density: {file: negative.npy, box: [[0, 0, 0], [1, 1, 1]]}, extinction: 1}\n";
    ck_assert_int_eq(parse(context, text, &scene), NPH_BAD_INPUT);
    const char *messages = nph_test_messages();
    static const char *const parts[] = {"s:4:20: this volume cannot be used",
                                        "s:6:20: ",
                                        "s:7:20: ",
                                        "s:8:20: ",
                                        "s:9:20: ",
                                        "nan.npy",
                                        "cut.npy",
                                        "noise.nvdb",
                                        "empty.txt",
                                        "negative.npy"};
    for (size_t i = 0; i < sizeof parts / sizeof parts[0]; i++)
        ck_assert_msg(strstr(messages, parts[i]) != NULL, "%s not in\n%s", parts[i], messages);
    ck_assert_ptr_null(strstr(messages, "s:5:"));
    ck_assert_int_eq(parse(context, HEAD "media:\n- {density: {file: no/such.nvdb}, extinction: 1}\n"
                                         "lights:\n- {type: environment, file: none.exr}\n", &scene), NPH_BAD_INPUT);
    messages = nph_test_messages();
    ck_assert_ptr_nonnull(strstr(messages, "s:4:20: volume 'no/such.nvdb' cannot be read: No such file"));
    ck_assert_ptr_nonnull(strstr(messages, "s:6:29: environment map 'none.exr' cannot be read: No such file"));
    ck_assert_int_eq(parse(context, HEAD "media:\n- {density: {file: ., centring: cell}, extinction: 1}\n", &scene),
                     NPH_BAD_SCENE);
    ck_assert_int_eq(parse(context, HEAD "media:\n- {density: {file: no.nvdb}, extinction: -1}\n", &scene),
                     NPH_BAD_SCENE);
    messages = nph_test_messages();
    ck_assert_ptr_nonnull(strstr(messages, "no.nvdb")); /* told as well, although the scene itself is wrong */
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_folder_in_place_of_a_volume_and_an_unknown_grid_are_refused) {
    NphContext *context = nph_test_context(1);
    NphScene *scene;
    char text[2000];
    snprintf(text, sizeof text, HEAD "media:\n- {density: {file: %s, grid: temperature}, extinction: 1}\n",
             nph_test_path("reference/data/cumulus/cumulus_300.zip.nvdb"));
    ck_assert_int_eq(parse(context, text, &scene), NPH_BAD_INPUT);
    const char *messages = nph_test_messages();
    ck_assert_msg(strstr(messages, "temperature") && strstr(messages, "density") && strstr(messages, "s:4:20: "), "%s",
                  messages);
    snprintf(text, sizeof text, "mkdir '%s'", nph_test_temporary("folder.nvdb"));
    ck_assert_int_eq(system(text), 0);
    ck_assert_int_eq(parse(context, HEAD "media:\n- {density: {file: folder.nvdb}, extinction: 1}\n", &scene),
                     NPH_BAD_INPUT);
    ck_assert_ptr_nonnull(
        strstr(nph_test_messages(), "s:4:20: volume 'folder.nvdb' cannot be read: it is not a regular file"));
    ck_assert_int_eq(remove(nph_test_temporary("folder.nvdb")), 0);
    nph_test_context_close(context);
}
END_TEST

START_TEST(extinction_times_the_largest_density_is_bounded) {
    NphContext *context = nph_test_context(1);
    NphScene *scene;
    write_npy(context, "dense.npy", 5, 1e30f);
    ck_assert_int_eq(parse(context, HEAD "media:\n- density: {file: dense.npy, box: [[0, 0, 0], [1, 1, 1]]}\n"
                                         "  extinction: [0, 0, 1e-20]\n", &scene), NPH_BAD_SCENE);
    const char *messages = nph_test_messages();
    ck_assert_msg(strncmp(messages, "s:5:15: extinction times the volume's largest density", 53) == 0, "%s", messages);
    scene = must_parse(context, HEAD "media:\n- density: {file: dense.npy, box: [[0, 0, 0], [1, 1, 1]]}\n"
                                     "  extinction: [0, 0, 0.99e-21]\n");
    nph_scene_free(context, scene);
    ck_assert_int_eq(parse(context, HEAD "media:\n- density: {file: dense.npy, box: [[9e11, 0, 0], [1e12, 1, 1]]}\n"
                                         "  extinction: 0\n  transform: [{scale: 2}]\n", &scene), NPH_BAD_SCENE);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "beyond 1e12 m along x"));
    nph_test_context_close(context);
}
END_TEST

static void digest_of(NphContext *context, const char *text, uint8_t digest[16]) {
    NphScene *scene = must_parse(context, text);
    memcpy(digest, scene->digest, 16);
    nph_scene_free(context, scene);
}

START_TEST(the_digest_sees_the_contents_of_volumes_and_not_their_names) {
    NphContext *context = nph_test_context(1);
    uint8_t first[16], second[16], third[16], fourth[16];
    write_npy(context, "a.npy", -1, 0);
    write_npy(context, "b.npy", -1, 0);
    write_npy(context, "c.npy", 17, 113.00001f);
    digest_of(context, HEAD "media:\n- {density: {file: a.npy, box: [[0, 0, 0], [1, 1, 1]]}, extinction: 1}\n", first);
    digest_of(context,
              HEAD "media:\n- {extinction: 1, density: {box: [[0, 0, 0], [1, 1, 1]], outside: zero, centring: cell,\n"
                   "   lookup: trilinear, file: ./b.npy}}\n",
              second);
    digest_of(context, HEAD "media:\n- {density: {file: c.npy, box: [[0, 0, 0], [1, 1, 1]]}, extinction: 1}\n", third);
    digest_of(context,
              HEAD "media:\n- {density: {file: a.npy, box: [[0, 0, 0], [1, 1, 1]], lookup: nearest}, extinction: 1}\n",
              fourth);
    ck_assert_mem_eq(first, second, 16);
    ck_assert_mem_ne(first, third, 16);
    ck_assert_mem_ne(first, fourth, 16);
    nph_test_context_close(context);
}
END_TEST

static void write_text(const char *name, const char *text) { write_bytes(name, text, strlen(text)); }

/* One mesh in two formats, its vertices in two orders: two triangles over the unit square. */
static const char square_obj[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
static const char square_ply[] =
    "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n"
    "property list uchar int vertex_indices\nend_header\n0 1 0\n1 1 0\n0 0 0\n1 0 0\n0 0 0\n3 2 3 1\n3 4 1 0\n";

START_TEST(meshes_lie_where_their_transforms_say) {
    NphContext *context = nph_test_context(1);
    double lo[3], hi[3];
    write_text("a.obj", square_obj);
    write_text("a.ply", square_ply);
    NphScene *scene = must_parse(context, HEAD
        "surfaces:\n"
        "- {mesh: a.obj, albedo: .25, transform: [{scale: [2, 4, 1]}, {translate: [10, 20, 30]}]}\n"
        "- {plane: 28}\n"
        "- {mesh: a.ply, name: door}\n");
    const NphSurface *s = scene->surfaces;
    ck_assert(!s[0].is_plane && s[1].is_plane && !s[2].is_plane && s[0].albedo[1] == .25);
    ck_assert_str_eq(s[2].name, "door");
    ck_assert(s[0].mesh.triangle_count == 2 && s[0].mesh.area_m2 == 8 && s[2].mesh.area_m2 == 1);
    nph_scene_bounds(scene, lo, hi);
    check3(lo, 0, 0, 0);
    check3(hi, 12, 24, 30);
    const NphBvh *bvh = &scene->bvh; /* planes are not in it */
    check3(bvh->origin, 6, 12, 15);
    ck_assert(bvh->mesh_count == 2 && bvh->mesh_first[1] == 2 && bvh->mesh_first[2] == 4 && bvh->vertex_count == 9);
    check3(bvh->vertices, 4, 8, 15);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}

#define PHASE(file) HEAD "media:\n- {box: [[0, 0, 0], [1, 1, 1]], extinction: 1, phase: {type: tabulated, file: " file "}}\n"

START_TEST(a_tabulated_phase_function_is_what_its_file_holds) {
    NphContext *context = nph_test_context(1);
    uint8_t digest[4][16];
    write_text("a.txt", "# angle value\n0 3\n90 1\n180 1\n");
    write_text("b.txt", "0,30\n90,10\n180,10\n"); /* the same at another scale */
    write_text("c.txt", "0 3\n90 1\n180 1.001\n");
    write_text("d.txt", "0 3\n30 1\n180 1\n");
    NphScene *scene = must_parse(context, PHASE("a.txt"));
    const NphPhase *phase = &scene->media[0].phase;
    ck_assert_int_eq(phase->kind, NPH_PHASE_TABULATED);
    /* 1 + 2 c from cos 1 to 0, then 1: integral 2 pi (2 + 1), of c times that 2 pi (1/2 + 2/3 - 1/2) */
    ck_assert_double_eq_tol(nph_phase_value(phase, 1.0), 3.0 / (6.0 * 3.14159265358979324), 1e-15);
    ck_assert_double_eq_tol(nph_phase_value(phase, 0.5), 2.0 / (6.0 * 3.14159265358979324), 1e-15);
    ck_assert_double_eq_tol(nph_phase_mean_cosine(phase), (7.0 / 6.0 - 0.5) / 3.0, 1e-15);
    nph_scene_free(context, scene);
    digest_of(context, PHASE("a.txt"), digest[0]);
    digest_of(context, PHASE("b.txt"), digest[1]);
    digest_of(context, PHASE("c.txt"), digest[2]);
    digest_of(context, PHASE("d.txt"), digest[3]);
    ck_assert_mem_eq(digest[0], digest[1], 16);
    ck_assert_mem_ne(digest[0], digest[2], 16);
    ck_assert_mem_ne(digest[0], digest[3], 16);
    nph_test_context_close(context);
}
END_TEST

START_TEST(phase_tables_that_cannot_be_used_are_named_with_their_place_in_the_scene) {
    NphContext *context = nph_test_context(1);
    NphScene *scene;
    write_text("bad.txt", "0 3\n90 one\n180 1\n");
    write_text("dark.txt", "0 0\n180 0\n");
    ck_assert_int_eq(parse(context, PHASE("bad.txt"), &scene), NPH_BAD_INPUT);
    const char *messages = nph_test_messages();
    ck_assert(strstr(messages, "bad.txt:2: the value is 'one'") && strstr(messages, "s:4:79: this table of a phase function"));
    ck_assert_int_eq(parse(context, PHASE("dark.txt"), &scene), NPH_BAD_INPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "all values are 0"));
    ck_assert_int_eq(parse(context, PHASE("none.txt"), &scene), NPH_BAD_INPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "s:4:79: table of the phase function 'none.txt' cannot be read: No such file"));
    nph_test_context_close(context);
}
END_TEST

#define SUNSET "reference/data/env/exr_variants/sunset256_half_"

static const char *environment_scene(const char *file, const char *settings) {
    static char text[2000];
    snprintf(text, sizeof text, HEAD "lights:\n- {type: environment, file: %s%s}\n", nph_test_path(file), settings);
    return text;
}

START_TEST(an_environment_map_is_scaled_and_turned_as_the_scene_says) {
    NphContext *context = nph_test_context(1);
    NphScene *plain = must_parse(context, environment_scene(SUNSET "zip.exr", ""));
    NphScene *turned = must_parse(context, environment_scene(SUNSET "zip.exr", ", scale: [2, 1, 0.5], rotation: -90"));
    const NphEnvironment *map = &plain->lights[0].map, *scaled = &turned->lights[0].map;
    ck_assert(map->width == 256 && map->height == 128 && map->total > 0);
    for (int i = 0; i < 256 * 128; i++) {
        ck_assert(scaled->radiance[3 * i] == 2 * map->radiance[3 * i]);
        ck_assert(scaled->radiance[3 * i + 1] == map->radiance[3 * i + 1]);
        ck_assert(scaled->radiance[3 * i + 2] == map->radiance[3 * i + 2] / 2);
    }
    ck_assert(plain->lights[0].rotation_rad == 0);
    ck_assert_double_eq_tol(turned->lights[0].rotation_rad, -1.5707963267948966, 3e-16);
    nph_scene_free(context, plain);
    nph_scene_free(context, turned);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_map_with_colours_does_not_go_with_wavelengths) {
    NphContext *context = nph_test_context(1);
    NphScene *scene;
    char text[2100];
    snprintf(text, sizeof text, "%swavelengths: [500, 600]\n", environment_scene(SUNSET "zip.exr", ""));
    ck_assert_int_eq(parse(context, text, &scene), NPH_BAD_SCENE);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "s:4:29: this environment map has colours"));
    snprintf(text, sizeof text, "%swavelengths: [500, 600]\n", environment_scene(SUNSET "zip.exr", ", scale: [1, 2]"));
    ck_assert_int_eq(parse(context, text, &scene), NPH_BAD_SCENE);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "with wavelengths the scale of a map is one number"));
    nph_test_context_close(context);
}
END_TEST

START_TEST(the_digest_sees_the_pixels_of_a_map_and_not_their_compression) {
    NphContext *context = nph_test_context(1);
    uint8_t zip[16], piz[16], turned[16], bright[16];
    digest_of(context, environment_scene(SUNSET "zip.exr", ""), zip);
    digest_of(context, environment_scene(SUNSET "piz.exr", ", rotation: 0, scale: 1"), piz);
    digest_of(context, environment_scene(SUNSET "zip.exr", ", rotation: 1"), turned);
    digest_of(context, environment_scene(SUNSET "zip.exr", ", scale: 1.001"), bright);
    ck_assert_mem_eq(zip, piz, 16);
    ck_assert_mem_ne(zip, turned, 16);
    ck_assert_mem_ne(zip, bright, 16);
    nph_test_context_close(context);
}
END_TEST

START_TEST(maps_that_cannot_be_used_are_named_with_their_place_in_the_scene) {
    NphContext *context = nph_test_context(1);
    NphScene *scene;
    ck_assert_int_eq(parse(context, environment_scene(SUNSET "dwaa.exr", ""), &scene), NPH_BAD_INPUT);
    const char *messages = nph_test_messages();
    ck_assert_msg(strstr(messages, "DWAA") && strstr(messages, "s:4:29: this environment map cannot be used"), "%s",
                  messages);
    ck_assert_int_eq(parse(context, environment_scene(SUNSET "zip.exr", ", scale: 1e35"), &scene), NPH_OK);
    nph_scene_free(context, scene);
    ck_assert_int_eq(parse(context, environment_scene("reference/data/env/exr_variants/sunset256.hdr", ""), &scene),
                     NPH_BAD_INPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "s:4:29: "));
    nph_test_context_close(context);
}
END_TEST

END_TEST

START_TEST(the_digest_sees_the_triangles_of_a_mesh_and_not_its_format) {
    NphContext *context = nph_test_context(1);
    write_text("a.obj", square_obj);
    write_text("a.ply", square_ply);
    write_text("b.obj", "v 0 0 0\nv 1 0 0\nv 1 1 1e-9\nv 0 1 0\nf 1 2 3 4\n");
    NphScene *obj = must_parse(context, HEAD "surfaces: [{mesh: a.obj}]\n");
    NphScene *ply = must_parse(context, HEAD "surfaces: [{mesh: a.ply}]\n");
    NphScene *other = must_parse(context, HEAD "surfaces: [{mesh: b.obj}]\n");
    ck_assert(memcmp(obj->digest, ply->digest, 16) == 0);
    ck_assert(memcmp(obj->digest, other->digest, 16) != 0);
    nph_scene_free(context, obj);
    nph_scene_free(context, ply);
    nph_scene_free(context, other);
    nph_test_context_close(context);
}
END_TEST

START_TEST(meshes_that_cannot_be_used_are_named_with_their_place_in_the_scene) {
    NphContext *context = nph_test_context(1);
    NphScene *scene;
    write_text("a.obj", square_obj);
    write_text("none.obj", "v 0 0 0\nv 1 0 0\nv 1 0 0\nf 1 2 3\n"); /* its only triangle has two equal corners */
    write_text("bad.obj", "v 0 0 0\nf 1 2 3\n");
    ck_assert_int_eq(parse(context, HEAD "surfaces:\n- {mesh: bad.obj}\n- {mesh: a.obj}\n- {mesh: none.obj}\n", &scene),
                     NPH_BAD_INPUT);
    const char *messages = nph_test_messages();
    ck_assert_msg(strstr(messages, "s:4:10: this mesh cannot be used") != NULL, "%s", messages);
    ck_assert_ptr_nonnull(strstr(messages, "bad.obj:2"));
    ck_assert_ptr_nonnull(strstr(messages, "s:6:10: this mesh has no triangles"));
    ck_assert_ptr_null(strstr(messages, "s:5:"));
    ck_assert_int_eq(parse(context, HEAD "surfaces: [{plane: 0}, {mesh: a.obj}]\nperiodic: {x: [0, 1]}\n", &scene), NPH_BAD_SCENE);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "s:4:11: periodic does not go with a mesh (surface surface1)"));
    ck_assert_int_eq(parse(context, HEAD "surfaces:\n- {mesh: a.obj, transform: [{translate: [0, 1e12, 0]}]}\n", &scene),
                     NPH_BAD_SCENE);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "s:4:10: after its transform this mesh reaches beyond 1e12 m along y"));
    nph_test_context_close(context);
}
END_TEST

START_TEST(files_are_looked_up_beside_the_scene) {
    NphContext *context = nph_test_context(1);
    write_npy(context, "a.npy", -1, 0);
    static const char text[] = HEAD "media:\n- {density: {file: a.npy, box: [[0, 0, 0], [1, 1, 1]]}, extinction: 1}\n";
    write_bytes("scene.yaml", text, sizeof text - 1);
    NphScene *scene = NULL;
    ck_assert_msg(nph_scene_load(context, nph_test_temporary("scene.yaml"), &scene) == NPH_OK, "%s",
                  nph_test_messages());
    ck_assert_str_eq(scene->name, "scene.yaml");
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(any_allocation_that_fails_while_files_load_is_reported_and_nothing_leaks) {
    NphContext *outer = nph_test_context(1);
    write_npy(outer, "a.npy", -1, 0);
    static const char les[] = "#\n2,3,2\n0.5,0.25\n1.0,1.5\nx,y,z,lwc,reff\n0,0,0,0.2,10\n1,2,1,0.4,10\n";
    write_bytes("les.txt", les, sizeof les - 1);
    write_text("a.obj", square_obj);
    write_text("a.ply", square_ply);
    write_text("a.txt", "0 3\n90 1\n180 1\n");
    write_text("air.dat", "9 0 0 1\n0 0 0 3\n");
    char text[3000];
    snprintf(text, sizeof text, HEAD "media:\n- {density: {file: a.npy, box: [[0, 0, 0], [1, 1, 1]]}, extinction: 1, phase: {type: tabulated, file: a.txt}}\n"
             "- {density: {file: les.txt, centring: cell}, extinction: 1}\n- {density: {file: %s}, extinction: 1}\n"
             "surfaces: [{mesh: a.obj}, {plane: 0}, {mesh: a.ply}]\n"
             "lights:\n- {type: environment, file: %s}\n- {type: constant, radiance: 1}\nair: {type: table, file: air.dat}\n",
             nph_test_path("reference/data/smoke/smoke_0024.zip.nvdb"), nph_test_path(SUNSET "zip.exr"));
    for (uint64_t n = 1;; n++) {
        NphSettings settings;
        nph_settings_default(&settings);
        settings.threads = 1;
        settings.fail_allocation = n;
        NphContext *context = NULL;
        NphScene *scene = NULL;
        ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
        NphStatus status = nph_scene_parse(context, text, strlen(text), "s", nph_test_temporary("."), &scene);
        int reached = nph_context_allocations(context) >= n;
        ck_assert_int_eq(status, reached ? NPH_NO_MEMORY : NPH_OK);
        nph_scene_free(context, scene);
        ck_assert_msg(nph_context_bytes(context) == 0, "allocation %llu", (unsigned long long)n);
        nph_context_close(context);
        if (!reached) break;
        ck_assert_uint_lt(n, 2000);
    }
    nph_test_context_close(outer);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, a_volume_lies_where_its_box_and_transform_say);
    tcase_add_test(cases, grids_of_mitsuba_and_pbrt_are_the_array_in_their_own_box);
    tcase_add_test(cases, an_openvdb_grid_is_the_same_medium_as_its_nanovdb_copy);
    tcase_add_test(cases, a_grid_of_colours_is_no_density);
    tcase_add_test(cases, cloud_fields_are_cells_around_their_points_or_end_at_them_as_the_scene_says);
    tcase_add_test(cases, the_reference_scenes_load_and_their_volumes_lie_where_they_should);
    tcase_add_test(cases, missing_and_damaged_files_are_named_with_their_place_in_the_scene);
    tcase_add_test(cases, a_folder_in_place_of_a_volume_and_an_unknown_grid_are_refused);
    tcase_add_test(cases, extinction_times_the_largest_density_is_bounded);
    tcase_add_test(cases, the_digest_sees_the_contents_of_volumes_and_not_their_names);
    tcase_add_test(cases, a_tabulated_phase_function_is_what_its_file_holds);
    tcase_add_test(cases, phase_tables_that_cannot_be_used_are_named_with_their_place_in_the_scene);
    tcase_add_test(cases, an_environment_map_is_scaled_and_turned_as_the_scene_says);
    tcase_add_test(cases, the_digest_sees_the_pixels_of_a_map_and_not_their_compression);
    tcase_add_test(cases, maps_that_cannot_be_used_are_named_with_their_place_in_the_scene);
    tcase_add_test(cases, a_map_with_colours_does_not_go_with_wavelengths);
    tcase_add_test(cases, meshes_lie_where_their_transforms_say);
    tcase_add_test(cases, the_digest_sees_the_triangles_of_a_mesh_and_not_its_format);
    tcase_add_test(cases, meshes_that_cannot_be_used_are_named_with_their_place_in_the_scene);
    tcase_add_test(cases, files_are_looked_up_beside_the_scene);
    tcase_add_test(cases, any_allocation_that_fails_while_files_load_is_reported_and_nothing_leaks);
}

int main(void) { return nph_test_main("scene_files", fill); }
