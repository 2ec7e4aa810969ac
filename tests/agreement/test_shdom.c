/* SPDX-License-Identifier: Apache-2.0
 *
 * truth/shdom against closed forms, the table of slab fluxes (reference/tables/slab_fluxes.csv) and the path tracer. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "harness.h"
#include "render_case.h"
#include "truth/shdom/shdom_angles.h"

#define CUBE "box: [[0, 0, 0], [1, 1, 1]]"
#define CAMERA "nephos: 1\ncamera: {resolution: [16, 16], position: [-1.5, -1.5, 0.5], look_at: [0.5, 0.5, 0.5], fov: 35}\n"

static NphRenderOptions shdom_options(int count, const char *const *knobs, int precision) {
    NphRenderOptions options = render_options(16, precision);
    options.method = "shdom";
    options.knob_count = count;
    options.knobs = knobs;
    return options;
}

START_TEST(ordinates_keep_harmonics_apart) {
    enum { BANDS = 9 };
    static double sums[BANDS * BANDS][BANDS * BANDS];
    NphPhase phase = {.kind = NPH_PHASE_HG, .g = {0.5, 0.0}};
    NphShdomCut cut = {BANDS, 0, 0, 1, 0, 0.0};
    NphShdomAngles angles;
    double y[NPH_SHDOM_TERMS_MAX], d[3], worst = 0.0;
    nph_shdom_angles(&phase, &cut, &angles);
    memset(sums, 0, sizeof sums);
    for (int o = 0; o < nph_shdom_ordinates(&angles); o++) {
        double weight = nph_shdom_ordinate(&angles, o, d);
        ck_assert_int_eq(nph_shdom_ordinate_of(&angles, d), o);
        nph_shdom_harmonics(BANDS, d, y);
        for (int i = 0; i < BANDS * BANDS; i++)
            for (int j = 0; j < BANDS * BANDS; j++) sums[i][j] += weight * y[i] * y[j];
    }
    for (int i = 0; i < BANDS * BANDS; i++)
        for (int j = 0; j < BANDS * BANDS; j++) worst = fmax(worst, fabs(sums[i][j] - (i == j)));
    printf("    largest difference from unity %.2g\n", worst);
    ck_assert_double_lt(worst, 1e-12);
}
END_TEST

/* Reflected or transmitted flux over the incident one. */
static double slab_flux(double g, double albedo, double depth, double mu0, int below, const char *const knobs[4]) {
    RenderCase render;
    NphRenderOptions options = shdom_options(4, knobs, 32);
    const char *light = mu0 > 0.0 ? render_text("{type: sun, elevation: %.17g, azimuth: 0, irradiance: %.17g}", asin(mu0) * 57.295779513082321, 1.0 / mu0)
                                  : "{type: constant, radiance: 0.31830988618379067, hemisphere: upper}";
    render_case(&render, render_text("nephos: 1\ncamera: {type: flux, resolution: [1, 1], position: [0, 0, %s], direction: [0, 0, %d], up: [0, 1, 0], extent: 1}\n"
                                     "media:\n  - {layer: [0, 1], extinction: %.17g, albedo: %.17g, phase: {type: hg, g: %.17g}}\nlights:\n  - %s\n",
                                     below ? "-0.001" : "1.001", below ? 1 : -1, depth, albedo, g, light),
                &options, 1);
    double flux = render_mean(&render, "R");
    render_free(&render);
    return flux;
}

/* Values of the table; errors of the grid of 48 cells: below 0.2% of the incident flux. mu0 0: uniform light. */
START_TEST(slab_fluxes_are_those_of_the_table) {
    static const double rows[][6] = {{0, 1, 1, 0, 0.446594, 0.553406},         {0, 1, 8, 0.5, 0.876648, 0.123352}, {0.85, 1, 8, 1, 0.358432, 0.641568},
                                     {0.85, 0.9, 8, 0.5, 0.206664, 0.093798}, {0, 1, 1, 0.5, 0.4983755, 0.5016245}};
    static const char *const knobs[4] = {"shdom.cells=48", "shdom.bands=8", "shdom.tolerance=1e-5", "shdom.gather=8"};
    for (size_t r = 0; r < sizeof rows / sizeof *rows; r++) {
        const double *row = rows[r];
        double R = slab_flux(row[0], row[1], row[2], row[3], 0, knobs), T = slab_flux(row[0], row[1], row[2], row[3], 1, knobs);
        printf("    g %g albedo %g depth %g mu0 %g: R %.6f (%+.1e) T %.6f (%+.1e)\n", row[0], row[1], row[2], row[3], R, R - row[4], T, T - row[5]);
        ck_assert_double_eq_tol(R, row[4], 2e-3);
        ck_assert_double_eq_tol(T, row[5], 2e-3);
        if (row[1] >= 1.0) ck_assert_double_eq_tol(R + T, 1.0, 2e-3);
    }
}
END_TEST

/* Rays through the middle of a cube see the sky through its extinction, as exactly as f32 pictures tell. */
START_TEST(without_scattering_light_falls_off_by_beers_law) {
    RenderCase render;
    NphRenderOptions options = shdom_options(0, NULL, 32);
    render_case(&render, "nephos: 1\ncamera: {type: orthographic, resolution: [4, 4], position: [0.5, 0.5, 3], direction: [0, 0, -1], up: [0, 1, 0], extent: 0.5}\n"
                         "media:\n  - {" CUBE ", extinction: 2, albedo: 0, phase: {type: hg, g: 0.9}}\nlights:\n  - {type: constant, radiance: 3}\n", &options, 2);
    ck_assert_double_eq_tol(render_mean(&render, "R"), 3.0 * exp(-2.0), 1e-6);
    ck_assert_double_eq_tol(render_error(&render, "R"), 0.0, 1e-9);
    render_free(&render);
}
END_TEST

START_TEST(a_white_cube_in_a_white_sky_is_not_seen) {
    static const char *const knobs[] = {"shdom.cells=12", "shdom.tolerance=1e-6"};
    for (int k = 0; k < 2; k++) {
        RenderCase render;
        NphRenderOptions options = shdom_options(2, knobs, 32);
        render_case(&render, render_text(CAMERA "media:\n  - {" CUBE ", extinction: %s, albedo: 1, phase: {type: hg, g: 0.8}}\n"
                                         "lights:\n  - {type: constant, radiance: 1}\n", k ? "30" : "4"), &options, 2);
        printf("    mean %.7f\n", render_mean(&render, "R"));
        ck_assert_double_eq_tol(render_mean(&render, "R"), 1.0, 1e-4);
        render_free(&render);
    }
}
END_TEST

static const char *cube_text(double g) {
    return render_text(CAMERA "media:\n  - {" CUBE ", extinction: 4, albedo: 1, phase: {type: hg, g: %g}}\n"
                       "lights:\n  - {type: sun, direction: [-1, 0, 0], irradiance: 3.14159265}\n", g);
}

/* A discretisation error: from 8 cells to 32 it falls to less than half and below 2%; the path tracer's own error is below 0.25%. */
START_TEST(finer_grids_lead_to_the_path_tracers_cube) {
    static const double g[] = {0.0, 0.7};
    RenderCase truth, render;
    NphRenderOptions path = render_options(12288, 32);
    render_case(&truth, cube_text(g[_i]), &path, 0);
    double mean = render_mean(&truth, "R"), error = render_error(&truth, "R") / mean, bias[3];
    for (int k = 0; k < 3; k++) {
        const char *knobs[] = {render_text("shdom.cells=%d", 8 << k)};
        NphRenderOptions options = shdom_options(1, knobs, 32);
        render_case(&render, cube_text(g[_i]), &options, 0);
        bias[k] = render_mean(&render, "R") / mean - 1.0;
        render_free(&render);
    }
    printf("    g %g: %+.4f, %+.4f, %+.4f of the truth, whose standard error is %.4f\n", g[_i], bias[0], bias[1], bias[2], error);
    ck_assert_double_lt(error, 0.0025);
    ck_assert_double_lt(fabs(bias[2]), 0.5 * fabs(bias[0]) + 2.0 * error);
    ck_assert_double_lt(fabs(bias[2]), 0.02);
    render_free(&truth);
}
END_TEST

/* The ordinates of x are those of y, so but for roundings the pictures are mirror images. */
START_TEST(exchanged_axes_exchange_the_picture) {
    static const char *const directions[] = {"[-1, 0.25, 0.5]", "[0.25, -1, 0.5]"}, *const knobs[] = {"shdom.cells=10", "shdom.tolerance=1e-6"};
    double mean[2];
    for (int k = 0; k < 2; k++) {
        RenderCase render;
        NphRenderOptions options = shdom_options(2, knobs, 64);
        render_case(&render, render_text("nephos: 1\ncamera: {type: orthographic, resolution: [8, 8], position: [0.5, 0.5, 3], direction: [0, 0, -1], up: [0, 1, 0], extent: 1}\n"
                                         "media:\n  - {" CUBE ", extinction: 5, albedo: 0.95, phase: {type: hg, g: 0.6}}\n"
                                         "lights:\n  - {type: sun, direction: %s, irradiance: 3}\n", directions[k]), &options, 2);
        mean[k] = render_mean(&render, "R");
        render_free(&render);
    }
    printf("    %.7f %.7f\n", mean[0], mean[1]);
    ck_assert_double_eq_tol(mean[0] / mean[1], 1.0, 2e-3); /* the camera's random places differ */
}
END_TEST

/* A box that repeats is a layer; across its columns rays go as they do along them. */
START_TEST(a_box_that_repeats_is_a_layer) {
    static const char *const knobs[] = {"shdom.cells=16", "shdom.gather=6", "shdom.tolerance=1e-5", "shdom.quadrature=0.01"};
    double layer = slab_flux(0.5, 1.0, 4.0, 0.5, 0, knobs);
    RenderCase render;
    NphRenderOptions options = shdom_options(4, knobs, 32);
    render_case(&render, "nephos: 1\nperiodic: {x: [0, 1], y: [0, 1]}\n"
                         "camera: {type: flux, resolution: [1, 1], position: [0.5, 0.5, 1.001], direction: [0, 0, -1], up: [0, 1, 0], extent: 1}\n"
                         "media:\n  - {box: [[-1, -1, 0], [2, 2, 1]], extinction: 4, albedo: 1, phase: {type: hg, g: 0.5}}\n"
                         "lights:\n  - {type: sun, elevation: 30, azimuth: 0, irradiance: 2}\n", &options, 0);
    printf("    layer %.5f, box %.5f\n", layer, render_mean(&render, "R"));
    ck_assert_double_eq_tol(render_mean(&render, "R"), layer, 0.02);
    render_free(&render);
}
END_TEST

static const char *const lit[] = {
    "{type: sun, direction: [0, 0, 1], irradiance: 1}",                 /* along an axis of the grid */
    "{type: point, position: [0.5, 0.5, 0.5], intensity: 1}",           /* at a corner of cells */
    "{type: point, position: [0.3, 0.4, 0.2], intensity: 1}",
    "{type: constant, radiance: 0}",                                    /* nothing at all */
};

/* Albedo 1: what comes out is what goes in, whatever the cells; the picture of a bound amount of light is bound. */
START_TEST(extremes_stay_finite_and_bound) {
    static const double extinction[] = {1e-6, 4.0, 6e4}, g[] = {0.0, 0.99999, -0.99};
    static const char *const knobs[] = {"shdom.cells=6", "shdom.bands=4", "shdom.iterations=60"};
    for (int i = 0; i < 3 * 3 * 4; i++) {
        RenderCase render;
        NphRenderOptions options = shdom_options(3, knobs, 32);
        render_case(&render, render_text("nephos: 1\ncamera: {resolution: [4, 4], position: [-1.5, -1.4, 0.6], look_at: [0.5, 0.5, 0.5], fov: 25}\n"
                                         "media:\n  - {" CUBE ", extinction: %g, albedo: %g, phase: {type: hg, g: %g}}\nlights:\n  - %s\n",
                                         extinction[i % 3], i & 1 ? 1.0 : 0.5, g[i / 3 % 3], lit[i / 9]), &options, 2);
        double mean = render_mean(&render, "R");
        ck_assert_msg(mean > -0.05 && mean < 10.0, "extinction %g, g %g, %s: %g", extinction[i % 3], g[i / 3 % 3], lit[i / 9], mean);
        if (i / 9 == 3) ck_assert(mean <= 0.0 && mean >= 0.0);
        render_free(&render);
    }
}
END_TEST

/* Nothing of a single bright texel is lost between ordinates: in a thin isotropic cube it is as bright as by single scattering. */
START_TEST(a_single_texel_lights_as_much_as_it_sends) {
    static const char *const knobs[] = {"shdom.cells=8", "shdom.bands=8"};
    const char *map = nph_test_temporary("texel.exr");
    NphContext *context = nph_test_context(1);
    NphImage image;
    float *pixels = NULL;
    ck_assert_int_eq(nph_image_new(context, 64, 32, &image), NPH_OK);
    ck_assert_int_eq(nph_image_add_channel(context, &image, "Y", &pixels), NPH_OK);
    memset(pixels, 0, sizeof *pixels * 64 * 32);
    pixels[9 * 64 + 50] = 1e6f;
    ck_assert_int_eq(nph_exr_write(context, map, &image), NPH_OK);
    nph_image_free(context, &image);
    nph_test_context_close(context);
    double mean[2];
    for (int k = 0; k < 2; k++) {
        RenderCase render;
        NphRenderOptions options = shdom_options(2, knobs, 32);
        if (k) options = render_options(1024, 32);
        render_case(&render, render_text(CAMERA "media:\n  - {" CUBE ", extinction: 0.05, albedo: 1, phase: {type: isotropic}}\n"
                                         "lights:\n  - {type: environment, file: %s}\n", map), &options, 0);
        mean[k] = render_mean(&render, "R");
        render_free(&render);
    }
    printf("    %.6g, path %.6g\n", mean[0], mean[1]);
    ck_assert_double_eq_tol(mean[0] / mean[1], 1.0, 0.02);
}
END_TEST

START_TEST(threads_change_no_bit) {
    static const char *const knobs[] = {"shdom.cells=7", "shdom.bands=5"};
    for (int precision = 32; precision <= 64; precision += 32) {
        RenderCase render[2];
        for (int k = 0; k < 2; k++) {
            NphRenderOptions options = shdom_options(2, knobs, precision);
            render_case(&render[k], CAMERA "media:\n  - {" CUBE ", extinction: [3, 4, 6], albedo: 0.9, phase: {type: hg, g: 0.7}}\n"
                                    "lights:\n  - {type: sun, direction: [-1, 0.2, 0.5], irradiance: [3, 2, 1]}\n  - {type: constant, radiance: 0.2}\n"
                                    "  - {type: point, position: [0.5, 0.5, 1.5], intensity: 1}\n", &options, 1 + 2 * k);
        }
        for (int c = 0; c < render[0].image.channel_count; c++)
            ck_assert_int_eq(memcmp(render[0].image.channels[c].pixels, render[1].image.channels[c].pixels, 16 * 16 * sizeof(float)), 0);
        render_free(&render[0]);
        render_free(&render[1]);
    }
}
END_TEST

START_TEST(what_is_not_modelled_is_refused_by_name) {
    static const char *const refused[][2] = {
        {"media:\n  - {" CUBE ", extinction: 1}\nsurfaces:\n  - {plane: -1, name: floor}\n", "surface floor"},
        {"media:\n  - {" CUBE ", extinction: 1, name: a}\n  - {" CUBE ", extinction: 1, name: b}\n", "medium b: there is one medium"},
        {"media:\n  - {" CUBE ", extinction: 1, name: glow, emission: {type: volume, radiance: 1}}\n", "medium glow emits light"},
    };
    for (int k = 0; k < 3; k++) {
        RenderCase render;
        NphRenderOptions options = shdom_options(0, NULL, 32);
        ck_assert_int_eq(render_try(&render, render_text(CAMERA "%s", refused[k][0]), &options, 1), NPH_BAD_SCENE);
        const char *said = nph_test_messages();
        ck_assert_msg(strstr(said, refused[k][1]) != NULL, "%s", said);
        render_free(&render);
    }
}
END_TEST

START_TEST(a_solution_that_does_not_settle_is_told) {
    static const char *const knobs[] = {"shdom.cells=8", "shdom.bands=3", "shdom.iterations=2"};
    RenderCase render;
    NphRenderOptions options = shdom_options(3, knobs, 32);
    render_case(&render, cube_text(0.5), &options, 1);
    const char *said = nph_test_messages();
    ck_assert_msg(strstr(said, "did not settle: after 2 iterations") != NULL, "%s", said);
    ck_assert_int_eq(render.statistics.unconverged, 1);
    ck_assert_double_gt(render.statistics.worst_residual, 1e-4);
    render_free(&render);
}
END_TEST

/* Five bands of a narrow peak ring: somewhere less than nothing is seen. A window takes that away, and the peak. */
START_TEST(prefiltering_takes_the_ringing_away) {
    double least[2];
    for (int k = 0; k < 2; k++) {
        const char *knobs[] = {"shdom.cells=10", "shdom.bands=5", "shdom.delta_m=0", "shdom.single=0", k ? "shdom.prefilter=1" : "shdom.prefilter=0"};
        RenderCase render;
        NphRenderOptions options = shdom_options(5, knobs, 32);
        render_case(&render, cube_text(0.9), &options, 2);
        const float *pixels = nph_image_channel(&render.image, "R")->pixels;
        least[k] = 0.0;
        for (int i = 0; i < 16 * 16; i++) least[k] = pixels[i] < least[k] ? pixels[i] : least[k];
        render_free(&render);
    }
    printf("    least %g, with a window %g\n", least[0], least[1]);
    ck_assert_double_lt(least[0], -0.1);
    ck_assert_double_gt(least[1], 0.2 * least[0]);
}
END_TEST

START_TEST(memory_is_planned_and_can_run_out_anywhere) {
    static const char *const knobs[] = {"shdom.cells=6", "shdom.bands=3"};
    NphRenderOptions options = shdom_options(2, knobs, 32);
    render_as_planned(cube_text(0.5), &options);
    render_without_memory(cube_text(0.5), &options);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, ordinates_keep_harmonics_apart);
    tcase_add_test(cases, slab_fluxes_are_those_of_the_table);
    tcase_add_test(cases, without_scattering_light_falls_off_by_beers_law);
    tcase_add_test(cases, a_white_cube_in_a_white_sky_is_not_seen);
    tcase_add_loop_test(cases, finer_grids_lead_to_the_path_tracers_cube, 0, 2);
    tcase_add_test(cases, exchanged_axes_exchange_the_picture);
    tcase_add_test(cases, a_box_that_repeats_is_a_layer);
    tcase_add_test(cases, extremes_stay_finite_and_bound);
    tcase_add_test(cases, a_single_texel_lights_as_much_as_it_sends);
    tcase_add_test(cases, threads_change_no_bit);
    tcase_add_test(cases, what_is_not_modelled_is_refused_by_name);
    tcase_add_test(cases, a_solution_that_does_not_settle_is_told);
    tcase_add_test(cases, prefiltering_takes_the_ringing_away);
    tcase_add_test(cases, memory_is_planned_and_can_run_out_anywhere);
}

int main(void) { return nph_test_main("shdom", fill); }
