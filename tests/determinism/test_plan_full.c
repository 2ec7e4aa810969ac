/* SPDX-License-Identifier: Apache-2.0
 *
 * What the plan leaves out cannot change the picture: with --plan full every channel of every pixel has the same bits.
 * Weighed flights and split camera rays (knobs path.weighed, path.forced) are other estimators of the same picture: held equal
 * within standard errors. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "harness.h"
#include "render_case.h"

#define CAMERA "nephos: 1\ncamera: {type: perspective, resolution: [24, 20], position: [-2, -1.5, 1.2], look_at: [0.5, 0.5, 0.5], fov: 40}\n"
#define BOX "box: [[0, 0, 0], [1, 1, 1]]"

static const char *const scenes[] = {
    /* one channel: everything grey */
    CAMERA "media:\n  - {" BOX ", extinction: 6, albedo: 0.95, phase: {type: hg, g: 0.8}}\n"
           "lights:\n  - {type: sun, direction: [-1, 0.2, 0.3], irradiance: 3}\n  - {type: constant, radiance: 0.2}\n",
    /* one transport channel: grey media under a coloured light */
    CAMERA "media:\n  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: 30, albedo: 1, phase: {type: hg, g: 0.8}}\n"
           "lights:\n  - {type: sun, direction: [-1, 0.2, 0.3], irradiance: [3, 2, 1]}\n",
    /* an empty medium and a black light */
    CAMERA "media:\n  - {" BOX ", extinction: 0}\n  - {" BOX ", extinction: 2, albedo: 0.5}\n"
           "lights:\n  - {type: constant, radiance: 1}\n  - {type: point, position: [2, 2, 2], intensity: 0}\n",
    /* no scattering */
    CAMERA "media:\n  - {" BOX ", extinction: 2, albedo: 0}\n"
           "lights:\n  - {type: constant, radiance: 1}\n  - {type: sun, direction: [-1, 0.2, 0.3], irradiance: 3}\n",
    /* black emission beside grey, and a box that emits alone but for an empty medium */
    CAMERA "media:\n  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: 0, emission: {type: volume, radiance: 1, grid: density}}\n"
           "  - {" BOX ", extinction: 2, albedo: 0.5, emission: {type: volume, radiance: 1}}\n"
           "  - {layer: [0, 1], extinction: 0, emission: {type: volume, radiance: 0}}\n",
    /* grey surfaces */
    CAMERA "media:\n  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: 30, albedo: 0.9, phase: {type: hg, g: 0.8}}\n"
           "surfaces:\n  - {plane: -0.3}\n  - {mesh: ../data/mesh/teapot.obj, albedo: 0, transform: [{scale: 0.2}, {translate: [0.3, 0, -0.3]}]}\n"
           "lights:\n  - {type: sun, direction: [-1, 0.2, 0.3], irradiance: 3, angular_diameter: 2}\n  - {type: constant, radiance: 0.2}\n",
    /* black surfaces */
    CAMERA "media:\n  - {" BOX ", extinction: 2, albedo: 0}\nsurfaces:\n  - {plane: 0.2, albedo: 0}\n"
           "lights:\n  - {type: constant, radiance: 1}\n  - {type: sun, direction: [-1, 0.2, 0.3], irradiance: 3}\n",
};

START_TEST(a_full_plan_gives_the_same_bits) {
    for (int precision = 32; precision <= 64; precision += 32) {
        RenderCase lean, full;
        NphRenderOptions options = render_options(32, precision);
        options.knob_count = 2;
        options.knobs = (const char *const[]){"path.weighed=0", "path.forced=0"};
        render_case(&lean, scenes[_i], &options, 0);
        options.plan_full = 1;
        render_case(&full, scenes[_i], &options, 0);
        ck_assert_int_eq(lean.image.channel_count, full.image.channel_count);
        size_t bytes = sizeof(float) * (size_t)lean.image.width * (size_t)lean.image.height;
        for (int c = 0; c < lean.image.channel_count; c++) {
            ck_assert_str_eq(lean.image.channels[c].name, full.image.channels[c].name);
            ck_assert_msg(memcmp(lean.image.channels[c].pixels, full.image.channels[c].pixels, bytes) == 0,
                          "scene %d f%d: %s differs", _i, precision, lean.image.channels[c].name);
        }
        render_free(&lean);
        render_free(&full);
    }
}
END_TEST

/* The plan says what it left out, and announces less memory than the full one. */
START_TEST(the_plan_names_what_it_leaves_out) {
    static const char *const expected[] = {"channels", "transport channels", "medium0", "path.shadow",
                                           "emission", "channels", "path.shadow"};
    NphContext *context = nph_test_context(1);
    NphScene *scene = NULL;
    NphStatus status = nph_scene_parse(context, scenes[_i], strlen(scenes[_i]), "test.yaml", nph_test_path("reference/scenes"), &scene);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    NphRenderOptions options = render_options(32, 32);
    NphPlan lean, full;
    ck_assert_int_eq(nph_plan_make(context, scene, &options, &lean), NPH_OK);
    options.plan_full = 1;
    ck_assert_int_eq(nph_plan_make(context, scene, &options, &full), NPH_OK);
    int named = 0;
    for (int i = 0; i < lean.line_count; i++)
        named += strcmp(lean.lines[i].kind, "left out") == 0 && strcmp(lean.lines[i].name, expected[_i]) == 0;
    ck_assert_int_eq(named, 1);
    for (int i = 0; i < full.line_count; i++)
        ck_assert(strcmp(full.lines[i].kind, "left out") != 0 || strcmp(full.lines[i].name, expected[_i]) != 0);
    ck_assert_uint_le(lean.bytes, full.bytes);
    nph_plan_free(context, &lean);
    nph_plan_free(context, &full);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(the_plan_warns_of_hot_grids_that_nothing_emits) {
    static const char *const media[] = {"", ", emission: {type: blackbody, scale: 2000}"};
    for (int emits = 0; emits < 2; emits++) {
        NphContext *context = nph_test_context(1);
        NphScene *scene = NULL;
        NphPlan plan;
        const char *text = render_text(CAMERA "media:\n  - {name: plume, density: {file: ../data/vdb/plume32_f20_BLOSC_float32.vdb}, extinction: 10, albedo: 0.5%s}\n",
                                       media[emits]);
        NphStatus status = nph_scene_parse(context, text, strlen(text), "test.yaml", nph_test_path("reference/scenes"), &scene);
        ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
        NphRenderOptions options = render_options(32, 32);
        ck_assert_int_eq(nph_plan_make(context, scene, &options, &plan), NPH_OK);
        int warned = 0, dark = 0;
        for (int i = 0; i < plan.line_count; i++) {
            warned += strcmp(plan.lines[i].kind, "warning") == 0 && strstr(plan.lines[i].text, "'temperature', which is not modelled");
            dark += strcmp(plan.lines[i].kind, "warning") == 0 && strstr(plan.lines[i].text, "will be black");
        }
        ck_assert_int_eq(warned, !emits);
        ck_assert_int_eq(dark, !emits);
        nph_plan_free(context, &plan);
        nph_scene_free(context, scene);
        nph_test_context_close(context);
    }
}
END_TEST

START_TEST(weighed_flights_agree_with_the_full_plan) {
    static const char *const scene =
        CAMERA "media:\n  - {%s, extinction: %g, albedo: 0.6, phase: {type: hg, g: 0.5}}\nsurfaces: [%s]\nlights:\n  - {type: constant, radiance: 1}\n";
    static const char *const shapes[] = {BOX, "density: {file: ../data/cumulus/cumulus_300.zip.nvdb}", BOX};
    static const char *const surfaces[] = {"", "", "{plane: 0.3, albedo: 0.7}"};
    for (int i = 0; i < 3; i++) {
        double extinction = i == 1 ? 10.0 : 3.0;
        RenderCase lean, full;
        NphRenderOptions options = render_options(512, 32);
        render_case(&lean, render_text(scene, shapes[i], extinction, surfaces[i]), &options, 0);
        options.plan_full = 1;
        options.seed_given = 1;
        options.seed = 2;
        render_case(&full, render_text(scene, shapes[i], extinction, surfaces[i]), &options, 0);
        double a = render_mean(&lean, "R"), b = render_mean(&full, "R");
        double error = hypot(render_error(&lean, "R"), render_error(&full, "R"));
        printf("    %.6f +- %.6f, full %.6f +- %.6f\n", a, render_error(&lean, "R"), b, render_error(&full, "R"));
        ck_assert_double_le(error, 0.003 * b);
        ck_assert_double_le(fabs(a - b), 3.5 * error);
        render_free(&lean);
        render_free(&full);
    }
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_loop_test(cases, a_full_plan_gives_the_same_bits, 0, (int)(sizeof scenes / sizeof *scenes));
    tcase_add_loop_test(cases, the_plan_names_what_it_leaves_out, 0, (int)(sizeof scenes / sizeof *scenes));
    tcase_add_test(cases, the_plan_warns_of_hot_grids_that_nothing_emits);
    tcase_add_test(cases, weighed_flights_agree_with_the_full_plan);
}

int main(void) { return nph_test_main("plan_full", fill); }
