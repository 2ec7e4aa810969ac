/* SPDX-License-Identifier: Apache-2.0
 *
 * Estimators that differ and have the same mean: chromatic media against grey ones channel by channel (spectral multiple
 * importance sampling is at work in the former only), and every knob of the path tracer at its ends. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "harness.h"
#include "render_case.h"

/* Extinctions and albedos of two overlapping media, a channel each. */
typedef struct Coefficients {
    double extinction[2][3], albedo[2][3];
} Coefficients;

static const char *const scenes[] = {
    "nephos: 1\n"
    "camera: {type: perspective, resolution: [24, 24], position: [-3, -2, 1], look_at: [0, 0, 0.2], fov: 40}\n"
    "media:\n"
    "  - {box: [[-1, -1, -0.8], [1, 1, 0.8]], extinction: %s, albedo: %s, phase: {type: hg, g: 0.5}}\n"
    "  - {box: [[-0.5, -0.5, -0.5], [1.5, 1.5, 0.5]], extinction: %s, albedo: %s}\n"
    "lights:\n"
    "  - {type: sun, direction: [-1, -0.5, 1], irradiance: 3, angular_diameter: 20}\n"
    "  - {type: constant, radiance: 0.3}\n",
    "nephos: 1\n"
    "camera: {type: perspective, resolution: [24, 24], position: [-3, -2, 1], look_at: [0, 0, 0.4], fov: 40}\n"
    "media:\n"
    "  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: %s, albedo: %s, phase: {type: hg, g: 0.5}}\n"
    "  - {box: [[-1, -1, -1], [1, 1, 0.4]], extinction: %s, albedo: %s}\n"
    "lights:\n"
    "  - {type: sun, direction: [-1, -0.5, 1], irradiance: 3}\n"
    "  - {type: constant, radiance: 0.3}\n",
};

/* A channel without extinction in one medium, one that is thick for the others, and one of little albedo. */
static const Coefficients coefficients = {{{3, 8, 0}, {0.5, 0.1, 2}}, {{0.9, 1, 0.5}, {0.8, 0.8, 0.3}}};

static const char *list(const double value[3]) { return render_text("[%g, %g, %g]", value[0], value[1], value[2]); }

START_TEST(each_channel_of_chromatic_media_has_the_mean_of_grey_media) {
    static const char *const channels[] = {"R", "G", "B"};
    const Coefficients *c = &coefficients;
    RenderCase wide;
    if (_i > 0 && !nph_test_statistics("chromatic media")) return;
    NphRenderOptions options = render_options(512, 32);
    render_case(&wide, render_text(scenes[_i], list(c->extinction[0]), list(c->albedo[0]), list(c->extinction[1]),
                                   list(c->albedo[1])), &options, 0);
    for (int i = 0; i < 3; i++) {
        RenderCase grey;
        options.seed_given = 1;
        options.seed = 100u + (uint32_t)i;
        render_case(&grey, render_text(scenes[_i], render_text("%g", c->extinction[0][i]), render_text("%g", c->albedo[0][i]),
                                       render_text("%g", c->extinction[1][i]), render_text("%g", c->albedo[1][i])), &options, 0);
        double a = render_mean(&wide, channels[i]), b = render_mean(&grey, "R");
        double ea = render_error(&wide, channels[i]), eb = render_error(&grey, "R"), error = sqrt(ea * ea + eb * eb);
        printf("    %s: %.5f +- %.5f, grey %.5f +- %.5f, z %+.2f\n", channels[i], a, ea, b, eb, (a - b) / error);
        ck_assert_double_le(error, 0.01 * b);
        /* six comparisons at 1% in all */
        ck_assert_double_le(fabs(a - b), 3.14 * error);
        render_free(&grey);
    }
    render_free(&wide);
}
END_TEST

/* Absorbing media: one lit by leaving alone, so that flights are weighed; one with a sun, so that shadow rays are. */
static const char *const grey_scenes[] = {
    "nephos: 1\n"
    "camera: {type: perspective, resolution: [24, 24], position: [-3, -2, 1], look_at: [0, 0, 0.4], fov: 40}\n"
    "media:\n  - {%s, extinction: 20, albedo: 0.7, phase: {type: hg, g: 0.5}}\n"
    "lights:\n  - {type: constant, radiance: 1, hemisphere: upper}\n",
    "nephos: 1\n"
    "camera: {type: perspective, resolution: [24, 24], position: [-3, -2, 1], look_at: [0, 0, 0.4], fov: 40}\n"
    "media:\n  - {%s, extinction: 20, albedo: 0.9, phase: {type: hg, g: 0.5}}\n"
    "lights:\n  - {type: sun, direction: [-1, -0.5, 1], irradiance: 3}\n",
};
static const char *const shapes[] = {"density: {file: ../data/cumulus/cumulus_300.zip.nvdb}", "box: [[-1, -1, -0.5], [1, 1, 0.7]]"};

START_TEST(no_knob_changes_the_mean) {
    enum { KNOBS = 8 };
    static const char *const settings[][KNOBS] = {
        {"path.roulette=0", "path.shadow_roulette=0", "path.weighed=0", "path.towards_sun=0", "path.least_light=0",
         "path.emission_events=0.01", "path.near_light=0", "path.forced=0"},
        {"path.roulette=1", "path.shadow_roulette=1", "path.weighed=1", "path.towards_sun=0.9", "path.least_light=10",
         "path.emission_events=1000", "path.near_light=1000", "path.forced=1"},
        {"path.roulette=0.1", "path.shadow_roulette=0.05", "path.weighed=0.5", "path.towards_sun=0.3", "path.least_light=0.5",
         "path.emission_events=2", "path.near_light=1", "path.forced=1"},
    };
    int known = 0; /* other methods have theirs */
    for (int k = 0; k < nph_knob_count(); k++) known += strncmp(nph_knob(k)->name, "path.", 5) == 0;
    ck_assert_int_eq(known, KNOBS);
    const char *yaml = render_text(grey_scenes[_i / 2], shapes[_i % 2]);
    double mean[3], error[3];
    for (int i = 0; i < 3; i++) {
        RenderCase render;
        NphRenderOptions options = render_options(256, 32);
        options.seed_given = 1;
        options.seed = (uint32_t)(10 * _i + i);
        options.knob_count = KNOBS;
        options.knobs = settings[i];
        render_case(&render, yaml, &options, 0);
        mean[i] = render_mean(&render, "R");
        error[i] = render_error(&render, "R");
        render_free(&render);
    }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        double both = sqrt(error[i] * error[i] + error[j] * error[j]);
        printf("    %.6f +- %.6f, z against the next %+.2f\n", mean[i], error[i], (mean[i] - mean[j]) / both);
        ck_assert_double_le(both, 0.04 * mean[j]);
        /* twelve comparisons at 1% in all */
        ck_assert_double_le(fabs(mean[i] - mean[j]), 3.34 * both);
    }
}
END_TEST

/* Light that a layer of depth tau sends up at mu when a beam of irradiance E comes at mu0, scattered once:
 * albedo p E mu0 / (mu + mu0) (1 - exp(-tau (1 / mu + 1 / mu0))). Scatterings after the first add a part of the order of tau. */
START_TEST(a_layer_of_a_millionth_keeps_its_digits) {
    static const double depths[] = {1e-6, 1e-9};
    double tau = depths[_i], mu = 0.6, mu0 = 0.8;
    const char *yaml = render_text(
        "nephos: 1\ncamera: {type: orthographic, position: [0.8, 0, 1.6], direction: [-0.8, 0, -0.6], up: [0, 1, 0], resolution: [16, 16], extent: 0.1}\n"
        "media:\n  - {layer: [0, 1], extinction: %.17g, albedo: 0.9, phase: {type: isotropic}}\n"
        "lights:\n  - {type: sun, direction: [0.6, 0, 0.8], irradiance: 3}\n", tau);
    RenderCase render;
    NphRenderOptions options = render_options(64, 32);
    render_case(&render, yaml, &options, 0);
    double once = 0.9 / (4.0 * 3.14159265358979323846) * 3.0 * mu0 / (mu + mu0) * tau * (1.0 / mu + 1.0 / mu0);
    double mean = render_mean(&render, "R");
    printf("    %.9g, closed form %.9g\n", mean, once);
    ck_assert_double_le(fabs(mean - once), 2e-5 * once);
    render_free(&render);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_loop_test(cases, a_layer_of_a_millionth_keeps_its_digits, 0, 2);
    tcase_add_loop_test(cases, each_channel_of_chromatic_media_has_the_mean_of_grey_media, 0, 2);
    tcase_add_loop_test(cases, no_knob_changes_the_mean, 0, 4);
}

int main(void) { return nph_test_main("estimators", fill); }
