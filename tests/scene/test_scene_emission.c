/* SPDX-License-Identifier: Apache-2.0
 *
 * What media emit: from constants, from grids of their own or another file, from temperatures; wrong temperatures; and
 * what is left unmodelled. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "field/sample.h"
#include "harness.h"
#include "io/volume.h"
#include "optics/blackbody.h"
#include "scene/model.h"

#define HEAD "nephos: 1\ncamera: {resolution: [4, 3], position: [0, -4, 0], look_at: [0, 0, 0], fov: 35}\n"
#define BOX "box: [[0, 0, 0], [5, 4, 3]]"

static NphStatus parse(NphContext *context, const char *text, const char *folder, NphScene **scene) {
    *scene = NULL;
    return nph_scene_parse(context, text, strlen(text), "s", folder, scene);
}

static NphScene *must_parse(NphContext *context, const char *text, const char *folder) {
    NphScene *scene;
    ck_assert_msg(parse(context, text, folder, &scene) == NPH_OK, "%s\n%s", text, nph_test_messages());
    return scene;
}

/* 5 x 4 x 3 (x, y, z) values first + step * index; the one at `odd` is `value`. */
static void write_npy(NphContext *context, const char *name, double first, double step, int odd, double value) {
    NphArray array = {0};
    ck_assert_int_eq(nph_array_new(context, NPH_F64, 3, (int64_t[]){3, 4, 5}, "test", &array), NPH_OK);
    for (int i = 0; i < 60; i++) ((double *)array.data)[i] = i == odd ? value : first + step * i;
    ck_assert_int_eq(nph_npy_write(context, nph_test_temporary(name), &array), NPH_OK);
    nph_array_free(context, &array);
}

/* The grid's value at a place in the world, by its own map. */
static double at_world(NphContext *context, const NphGrid *grid, const double world_from_grid[12], const double p[3]) {
    double inverse[12], u[3], out = -1;
    ck_assert_int_eq(nph_affine_invert(world_from_grid, inverse), 1);
    for (int a = 0; a < 3; a++)
        u[a] = inverse[4 * a] * p[0] + inverse[4 * a + 1] * p[1] + inverse[4 * a + 2] * p[2] + inverse[4 * a + 3];
    ck_assert_int_eq(nph_grid_sample(context, grid, 64, 1, (const void *[]){&u[0], &u[1], &u[2]}, &out), NPH_OK);
    return out;
}

static void check_near(double value, double right, double relative) {
    ck_assert_msg(fabs(value - right) <= relative * fabs(right), "%.17g, not %.17g", value, right);
}

START_TEST(boxes_and_layers_emit_constants) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = must_parse(context, HEAD
        "media:\n"
        "- {" BOX ", extinction: 0, emission: {type: volume, radiance: [1, 2, 3]}}\n"
        "- {layer: [0, 1], extinction: [2, 3, 4], albedo: [0, 0.5, 1], emission: {type: blackbody, temperature: 3000}}\n"
        "- {" BOX ", extinction: 1}\n", NULL);
    const NphEmission *first = &scene->media[0].emission, *second = &scene->media[1].emission;
    ck_assert_int_eq(first->kind, NPH_EMISSION_CONSTANT);
    ck_assert(first->value[0] == 1 && first->value[1] == 2 && first->value[2] == 3);
    /* the first channel absorbs 2, the second 1.5, the third nothing */
    check_near(second->value[0], 2 * 733.24, 1e-4);
    check_near(second->value[1], 1.5 * 349.56, 1e-4);
    ck_assert(second->value[2] == 0.0);
    ck_assert_int_eq(scene->media[2].emission.kind, NPH_EMISSION_NONE);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_density_emits_in_proportion_and_a_volume_of_its_own_where_it_lies) {
    NphContext *context = nph_test_context(2);
    write_npy(context, "rho.npy", 1, 0.5, -1, 0);
    write_npy(context, "fire.npy", 0, 2, -1, 0);
    NphScene *scene = must_parse(context, HEAD
        "media:\n"
        "- {density: {file: rho.npy, " BOX "}, extinction: 2, albedo: 0.25, emission: {type: volume, radiance: 7}}\n"
        "- {density: {file: rho.npy, " BOX "}, extinction: 2, albedo: 0.25, emission: {type: blackbody, temperature: 3000},\n"
        "   transform: [{translate: [1, 2, 3]}]}\n"
        "- {density: {file: rho.npy, " BOX "}, extinction: 2, transform: [{scale: 2}, {translate: [1, 2, 3]}],\n"
        "   emission: {type: volume, radiance: [1, 0, 2],\n"
        "              volume: {file: fire.npy, box: [[10, 10, 10], [15, 14, 13]], lookup: nearest}}}\n",
        nph_test_temporary("."));
    const NphMedium *m = scene->media;
    ck_assert_int_eq(m[0].emission.kind, NPH_EMISSION_DENSITY);
    ck_assert(m[0].emission.value[1] == 7);
    ck_assert_int_eq(m[1].emission.kind, NPH_EMISSION_DENSITY);
    check_near(m[1].emission.value[0], 1.5 * 733.24, 1e-4);
    ck_assert(nph_emission_grid(&m[1].emission, &m[1].grid, 2) == &m[1].grid);
    ck_assert(memcmp(m[1].emission.world_from_grid, m[1].world_from_medium, sizeof m[1].world_from_medium) == 0);
    const NphEmission *fire = &m[2].emission;
    ck_assert_int_eq(fire->kind, NPH_EMISSION_GRID);
    ck_assert_int_eq(fire->grid_count, 1);
    /* cell (3, 2, 1) of the fire is number 33 and stands at 2 (13.5, 12.5, 11.5) + (1, 2, 3) */
    ck_assert(at_world(context, &fire->grids[0], fire->world_from_grid, (double[3]){28, 27, 26}) == 66);
    double lo[3], hi[3];
    nph_scene_bounds(scene, lo, hi);
    ck_assert(lo[0] == 0 && lo[2] == 0 && hi[0] == 31 && hi[1] == 30 && hi[2] == 29);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

/* j = absorption B(T) at the samples of the temperature's grid, whatever the density's is. */
START_TEST(a_black_body_emits_absorption_times_planck_at_its_samples) {
    NphContext *context = nph_test_context(2);
    NphPlanckTable *table = malloc(sizeof *table);
    ck_assert_ptr_nonnull(table);
    nph_planck_table(table);
    write_npy(context, "rho.npy", 1, 0.5, -1, 0);
    write_npy(context, "hot.npy", -20, 10, -1, 0);
    NphScene *scene = must_parse(context, HEAD
        "media:\n"
        "- {density: {file: rho.npy, " BOX "}, extinction: [2, 3, 4], albedo: [0.25, 0.5, 0], transform: [{rotate: {axis: [1, 2, 3], angle: 40}}],\n"
        "   emission: {type: blackbody, scale: 5, offset: 1500, volume: {file: hot.npy, " BOX "}}}\n"
        "- {density: {file: rho.npy, " BOX "}, extinction: 1, albedo: 0,\n"
        "   emission: {type: blackbody, scale: 5, offset: 1500, volume: {file: hot.npy, box: [[0, 0, 0], [10, 8, 6]]}}}\n",
        nph_test_temporary("."));
    const double absorption[3] = {1.5, 1.5, 4};
    const NphEmission *same = &scene->media[0].emission, *wide = &scene->media[1].emission;
    ck_assert_int_eq(same->grid_count, 3);
    for (int i = 0; i < 60; i++) {
        double rgb[3], u = 1 + i % 5, v = 1 + i / 5 % 4, w = 1 + i / 20, j = -1;
        nph_planck_rgb(table, 5 * (-20 + 10 * i) + 1500, rgb);
        for (int c = 0; c < 3; c++) {
            ck_assert_int_eq(nph_grid_sample(context, &same->grids[c], 64, 1, (const void *[]){&u, &v, &w}, &j), NPH_OK);
            check_near(j, (1 + 0.5 * i) * absorption[c] * rgb[c], 1e-6);
        }
    }
    /* cell (1, 1, 0) of the wide grid is number 6, at (3, 3, 1): between densities 12, 13, 17 and 18, of layers 0 and 1 */
    double rgb[3], density = 0;
    nph_planck_rgb(table, 5 * 40 + 1500, rgb);
    for (int corner = 0; corner < 8; corner++)
        density += (1 + 0.5 * (2 + (corner & 1) + 5 * (2 + (corner >> 1 & 1)) + 20 * (corner >> 2))) / 8;
    check_near(at_world(context, &wide->grids[0], wide->world_from_grid, (double[3]){3, 3, 1}), density * rgb[0], 1e-6);
    /* and beyond the density there is none */
    ck_assert(at_world(context, &wide->grids[0], wide->world_from_grid, (double[3]){9, 7, 5}) == 0);
    nph_scene_free(context, scene);
    free(table);
    nph_test_context_close(context);
}
END_TEST

/* The bound is at least every sample's largest channel in the cell, and no more than a rounding above the largest. */
START_TEST(the_bound_holds_all_channels) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = must_parse(context, HEAD
        "media:\n"
        "- density: {file: ../data/vdb/plume32_f20_BLOSC_float32.vdb}\n"
        "  extinction: 20\n"
        "  albedo: 0.3\n"
        "  emission: {type: blackbody, scale: 2000}\n", nph_test_path("reference/scenes"));
    const NphEmission *e = &scene->media[0].emission;
    ck_assert_int_eq(e->grid_count, 3);
    int64_t lit = 0;
    for (int32_t z = 0; z < e->bound.n[2]; z++)
        for (int32_t y = 0; y < e->bound.n[1]; y++)
            for (int32_t x = 0; x < e->bound.n[0]; x++) {
                int64_t cell = ((int64_t)z * e->bound.n[1] + y) * e->bound.n[0] + x;
                float most = 0;
                for (int c = 0; c < 3; c++)
                    most = e->grids[c].majorant.cells[cell] > most ? e->grids[c].majorant.cells[cell] : most;
                if (most > 1e-29f) {
                    ck_assert(e->bound.cells[cell] >= most && e->bound.cells[cell] < most * 1.00001f);
                    lit++;
                } else
                    ck_assert(e->bound.cells[cell] <= 1e-29f);
            }
    ck_assert_int_gt(lit, 20);
    ck_assert(e->depth > 0);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(tiles_glow_and_empty_flames_are_dark) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = must_parse(context, HEAD
        "media:\n"
        "- density: {file: ../data/smoke/fluid_data_0048.allgrids.blosc.nvdb, grid: density}\n"
        "  extinction: 20\n"
        "  albedo: 0\n"
        "  emission: {type: blackbody, grid: shadow, scale: -2000}\n"
        "- density: {file: ../data/smoke/fluid_data_0048.allgrids.blosc.nvdb}\n"
        "  extinction: 20\n"
        "  emission: {type: volume, radiance: 5}\n", nph_test_path("reference/scenes"));
    const NphEmission *tiles = &scene->media[0].emission, *flame = &scene->media[1].emission;
    /* the whole box is one temperature: emission is the density's, up to its scale */
    check_near(tiles->grids[0].sum / (20 * 16.0147956), scene->media[0].grid.sum, 1e-5);
    ck_assert(flame->grids[0].max == 0 && flame->depth == 0);
    ck_assert_str_eq(scene->media[0].unmodelled, "temperature");
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(hot_grids_that_nothing_emits_are_noted) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = must_parse(context, HEAD
        "media:\n"
        "- {density: {file: ../data/vdb/plume32_f20_BLOSC_float32.vdb}, extinction: 20}\n"
        "- {density: {file: ../data/smoke/smoke_0024.zip.nvdb}, extinction: 20}\n", nph_test_path("reference/scenes"));
    ck_assert_str_eq(scene->media[0].unmodelled, "temperature");
    ck_assert_ptr_null(scene->media[1].unmodelled);
    nph_scene_free(context, scene);
    scene = must_parse(context, HEAD
        "media:\n"
        "- {density: {file: ../data/vdb/plume32_f20_BLOSC_float32.vdb}, extinction: 20}\n"
        "- {density: {file: ../data/vdb/plume32_f20_BLOSC_float32.vdb}, extinction: 1, emission: {type: blackbody}}\n",
        nph_test_path("reference/scenes"));
    ck_assert_ptr_null(scene->media[0].unmodelled);
    ck_assert_ptr_null(scene->media[1].unmodelled);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(wrong_temperatures_are_refused_at_their_voxel) {
    static const struct { double value; const char *what; } wrong[] = {
        {NAN, "is nan, which"}, {-301, "make -1 K"}, {INFINITY, "make inf K"}, {1e6, "allowed: 0 to 100000 K"}};
    NphContext *context = nph_test_context(1);
    write_npy(context, "rho.npy", 1, 0.5, -1, 0);
    for (int i = 0; i < 4; i++) {
        NphScene *scene;
        write_npy(context, "hot.npy", 1000, 10, 33, wrong[i].value);
        ck_assert_int_eq(parse(context, HEAD
            "media:\n"
            "- density: {file: rho.npy, " BOX "}\n"
            "  extinction: 1\n"
            "  emission:\n"
            "    type: blackbody\n"
            "    offset: 300\n"
            "    volume: {file: hot.npy, " BOX "}\n", nph_test_temporary("."), &scene), NPH_BAD_INPUT);
        const char *messages = nph_test_messages();
        ck_assert_msg(strstr(messages, "hot.npy: voxel [z, y, x] = [1, 2, 3]") && strstr(messages, wrong[i].what) &&
                      strstr(messages, "s:9:20"), "%s", messages);
    }
    nph_test_context_close(context);
}
END_TEST

START_TEST(emission_is_part_of_the_digest) {
    static const char *const emissions[] = {
        "", ", emission: {type: volume, radiance: 0}", ", emission: {type: volume, radiance: 1}",
        ", emission: {type: blackbody, temperature: 3000}", ", emission: {type: blackbody, temperature: 3001}"};
    NphContext *context = nph_test_context(1);
    uint8_t digests[5][16];
    for (int i = 0; i < 5; i++) {
        char text[400];
        snprintf(text, sizeof text, HEAD "media:\n- {" BOX ", extinction: 1, albedo: 0%s}\n", emissions[i]);
        NphScene *scene = must_parse(context, text, NULL);
        memcpy(digests[i], scene->digest, 16);
        for (int k = 0; k < i; k++) ck_assert(memcmp(digests[i], digests[k], 16) != 0);
        nph_scene_free(context, scene);
    }
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, boxes_and_layers_emit_constants);
    tcase_add_test(cases, a_density_emits_in_proportion_and_a_volume_of_its_own_where_it_lies);
    tcase_add_test(cases, a_black_body_emits_absorption_times_planck_at_its_samples);
    tcase_add_test(cases, the_bound_holds_all_channels);
    tcase_add_test(cases, tiles_glow_and_empty_flames_are_dark);
    tcase_add_test(cases, hot_grids_that_nothing_emits_are_noted);
    tcase_add_test(cases, wrong_temperatures_are_refused_at_their_voxel);
    tcase_add_test(cases, emission_is_part_of_the_digest);
}

int main(void) { return nph_test_main("scene_emission", fill); }
