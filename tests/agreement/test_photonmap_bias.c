/* SPDX-License-Identifier: Apache-2.0
 *
 * Photon mapping against closed forms and the path tracer: what is unbiased has the right mean (direct light, transmittance,
 * a scene without multiple scattering), and the bias of the estimate shrinks with more photons and with its radius. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "harness.h"
#include "render_case.h"

#define PI 3.14159265358979323846
#define CUBE_CAMERA                                                                                                    \
    "nephos: 1\ncamera: {resolution: [12, 12], position: [-1.5, -1.5, 0.5], look_at: [0.5, 0.5, 0.5], fov: 35}\n"
#define SUN "lights:\n  - {type: sun, direction: [-1, 0, 0], irradiance: 3.141592653589793}\n"

static const char *const cube =
    CUBE_CAMERA "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 4, albedo: 1, phase: {type: hg, g: 0}}\n" SUN;

static NphRenderOptions photon_options(int64_t samples, int precision, int knob_count, const char *const *knobs) {
    NphRenderOptions options = render_options(samples, precision);
    options.method = "photonmap";
    options.knob_count = knob_count;
    options.knobs = knobs;
    return options;
}

/* The mean of R is `expected` within 4 standard errors and `bias`; the standard error is below 0.5%. */
static void check_mean(const char *yaml, const NphRenderOptions *options, double expected, double bias) {
    RenderCase render;
    render_case(&render, yaml, options, 0);
    double mean = render_mean(&render, "R"), error = render_error(&render, "R");
    printf("    %.8g +- %.2g, expected %.8g, z %+.2f\n", mean, error, expected, (mean - expected) / error);
    ck_assert_double_lt(error, 0.005 * expected);
    ck_assert_double_le(fabs(mean - expected), 4.0 * error + bias * expected);
    render_free(&render);
}

/* L = E w p (1 - e^(-tau (1 + 1/mu))) / (1 + 1/mu), seen from above; albedo 1e-4 leaves higher orders 2e-4 of it. */
START_TEST(direct_light_is_single_scattering_in_closed_form) {
    static const char *const text = "nephos: 1\ncamera: {type: orthographic, resolution: [8, 8], position: [0, 0, 3], "
                                    "look_at: [0, 0, 0], up: [0, 1, 0], extent: 0.5}\n"
                                    "media:\n%slights:\n  - {type: sun, elevation: 30, azimuth: 20, irradiance: 2}\n";
    static const char *const media[] = {
        "  - {box: [[-20, -20, 0], [20, 20, 1]], extinction: 3, albedo: 1e-4, phase: {type: hg, g: 0.5}}\n",
        "  - {box: [[-20, -20, 0], [20, 20, 1]], extinction: 1, albedo: 1e-4, phase: {type: hg, g: 0.5}}\n"
        "  - {box: [[-21, -20, 0], [20, 22, 1]], extinction: 2, albedo: 1e-4, phase: {type: hg, g: 0.5}}\n",
    };
    static const char *const knobs[] = {"photonmap.photons=1000"};
    double mu = 0.5, path = 1.0 + 1.0 / mu, g = 0.5;
    double phase = (1 - g * g) / (4 * PI * pow(1 + g * g + 2 * g * mu, 1.5)); /* cos = -mu */
    double expected = 2.0 * 1e-4 * phase * (1 - exp(-3.0 * path)) / path;
    for (int precision = 32; precision <= 64; precision += 32) {
        NphRenderOptions options = photon_options(256, precision, 1, knobs);
        check_mean(render_text(text, media[_i]), &options, expected, 4e-4);
    }
}
END_TEST

/* Little albedo: what photons bring is 3% of the picture, and its bias a tenth of that. Every kind of light and sensor. */
START_TEST(dim_media_agree_with_path) {
    static const char *const sensors[] = {
        "{resolution: [12, 12], position: [-1.6, -1.5, 0.5], look_at: [0.5, 0.5, 0.5], fov: 40}",
        "{type: flux, resolution: [8, 8], position: [0.5, 0.5, 0.5], direction: [0, 0.3, 1], up: [0, 1, 0], extent: 0.6}",
        "{type: fluence, resolution: [8, 8], position: [0.5, 0.5, 0.5], direction: [0, 0.3, 1], up: [0, 1, 0], extent: 0.6}",
        "{type: fisheye, resolution: [12, 12], position: [0.5, 0.4, 1.2], direction: [0, 0, -1], up: [0, 1, 0], fov: 150}",
    };
    static const char *const scene =
        "nephos: 1\ncamera: %s\nmedia:\n"
        "  - {box: [[0, 0, 0], [1, 1, 1]], extinction: [2, 4, 1], albedo: 0.06, phase: {type: hg, g: 0.5}}\n"
        "  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: [20, 30, 9], albedo: 0.05, phase: {type: rayleigh},\n"
        "     transform: [{scale: 0.4}, {rotate: {axis: [1, 2, 3], angle: 40}}, {translate: [0.5, 0.4, 0.5]}]}\n"
        "lights:\n  - {type: sun, direction: [-1, 0.2, 1], irradiance: [9, 6, 3], angular_diameter: 20}\n"
        "  - {type: sun, direction: [1, -0.2, 0.4], irradiance: [3, 6, 3]}\n"
        "  - {type: constant, radiance: 0.1, hemisphere: lower}\n"
        "  - {type: environment, file: ../data/env/exr_variants/sunset256_float_zip.exr, rotation: 70, scale: 0.2}\n"
        "  - {type: point, position: [-0.5, 0.5, 1.5], intensity: [3, 2, 3]}\n";
    static const char *const channels[] = {"R", "G", "B"};
    static const char *const knobs[] = {"photonmap.photons=3000", "photonmap.nearest=20"};
    RenderCase photons, path;
    NphRenderOptions options = photon_options(128, 32, 2, knobs), plain = render_options(2048, 32);
    if (_i > 0 && !nph_test_statistics("dim media by photons")) return;
    options.seed_given = 1;
    options.seed = 33;
    render_case(&photons, render_text(scene, sensors[_i]), &options, 0);
    render_case(&path, render_text(scene, sensors[_i]), &plain, 0);
    for (int c = 0; c < 3; c++) {
        double a = render_mean(&photons, channels[c]), b = render_mean(&path, channels[c]);
        double ea = render_error(&photons, channels[c]), eb = render_error(&path, channels[c]), error = sqrt(ea * ea + eb * eb);
        printf("    sensor %d %s: %.5f +- %.5f, path %.5f +- %.5f, z %+.2f\n", _i, channels[c], a, ea, b, eb, (a - b) / error);
        ck_assert_double_lt(error, 0.03 * b);
        ck_assert_double_le(fabs(a - b), 4.0 * error + 0.005 * b);
    }
    double covered = render_mean(&photons, "A") - render_mean(&path, "A");
    printf("    sensor %d: A differs by %+.5f\n", _i, covered);
    ck_assert_double_le(fabs(covered), 0.01);
    render_free(&photons);
    render_free(&path);
}
END_TEST

/* Only the transmittance and the lights behind. */
START_TEST(without_scattering_only_transmittance_is_left) {
    static const char *const scenes[] = {
        CUBE_CAMERA "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: [1, 2, 3], albedo: 0}\n"
                    "lights:\n  - {type: constant, radiance: 1}\n",
        CUBE_CAMERA "lights:\n  - {type: constant, radiance: 1}\n",
        CUBE_CAMERA "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 0, albedo: 1}\nlights:\n  - {type: "
                    "constant, radiance: 1}\n",
        CUBE_CAMERA "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 2, albedo: 1}\n",
    };
    RenderCase photons, path;
    NphRenderOptions options = photon_options(16, 32, 0, NULL), plain = render_options(1024, 32);
    render_case(&photons, scenes[_i], &options, 0);
    render_case(&path, scenes[_i], &plain, 0);
    double error = render_error(&path, "B") + 1e-6, difference = render_mean(&photons, "B") - render_mean(&path, "B");
    printf("    %.5f, path %.5f +- %.5f\n", render_mean(&photons, "B"), render_mean(&path, "B"), error);
    ck_assert_double_le(fabs(difference), 4.0 * error + 4.0 * render_error(&photons, "B"));
    ck_assert_int_eq(photons.statistics.nonfinite, 0);
    render_free(&photons);
    render_free(&path);
}
END_TEST

START_TEST(few_photons_are_no_exception) {
    static const char *const knobs[][2] = {{"photonmap.photons=1", "photonmap.nearest=2"},
                                           {"photonmap.photons=2", "photonmap.nearest=1024"},
                                           {"photonmap.photons=3", "photonmap.emitted=1"},
                                           {"photonmap.photons=7", "photonmap.radius=2"}};
    for (int precision = 32; precision <= 64; precision += 32) {
        RenderCase render;
        NphRenderOptions options = photon_options(16, precision, 2, knobs[_i]);
        render_case(&render, cube, &options, 0);
        ck_assert_double_gt(render_mean(&render, "R"), 0.02);
        ck_assert_double_lt(render_mean(&render, "R"), 1.0);
        ck_assert_int_eq(render.statistics.nonfinite, 0);
        render_free(&render);
    }
}
END_TEST

/* The mean over the picture relative to the path tracer's; `error` its standard error. */
static double bias_of(const char *yaml, double truth, const char *first, const char *second, const char *third,
                      double *error) {
    const char *const knobs[] = {first, second, third};
    RenderCase render;
    NphRenderOptions options = photon_options(16, 32, 3, knobs);
    render_case(&render, yaml, &options, 0);
    double bias = render_mean(&render, "R") / truth - 1.0;
    *error = render_error(&render, "R") / truth;
    printf("    %s %s %s: bias %+.4f +- %.4f\n", first, second, third, bias, *error);
    render_free(&render);
    return bias;
}

static double truth_of(const char *yaml) {
    RenderCase path;
    NphRenderOptions options = render_options(2048, 32);
    render_case(&path, yaml, &options, 0);
    double mean = render_mean(&path, "R");
    ck_assert_double_lt(render_error(&path, "R"), 0.003 * mean);
    render_free(&path);
    return mean;
}

/* At fixed k the radius goes as N^(-1/3), and so does the dark rim: eight times the photons, half the bias. */
START_TEST(bias_shrinks_with_photons) {
    static const char *const photons[] = {"photonmap.photons=500", "photonmap.photons=4000", "photonmap.photons=32000"};
    double truth = truth_of(cube), bias[3], error[3];
    for (int i = 0; i < 3; i++)
        bias[i] = bias_of(cube, truth, photons[i], "photonmap.nearest=20", "photonmap.radius=1", &error[i]);
    for (int i = 0; i < 3; i++) ck_assert_double_lt(bias[i], -4.0 * error[i]);
    for (int i = 1; i < 3; i++) {
        ck_assert_double_lt(bias[i] / bias[i - 1], 0.7);
        ck_assert_double_gt(bias[i] / bias[i - 1], 0.3);
    }
}
END_TEST

START_TEST(bias_shrinks_with_the_radius) {
    static const char *const radii[] = {"photonmap.radius=0.12", "photonmap.radius=0.06", "photonmap.radius=0.03"};
    double truth = truth_of(cube), bias[3], error[3];
    for (int i = 0; i < 3; i++)
        bias[i] = bias_of(cube, truth, "photonmap.photons=3000", "photonmap.nearest=1024", radii[i], &error[i]);
    for (int i = 0; i < 3; i++) ck_assert_double_lt(bias[i], -3.0 * error[i]);
    for (int i = 1; i < 3; i++) {
        ck_assert_double_lt(bias[i] / bias[i - 1], 0.7);
        ck_assert_double_gt(bias[i] / bias[i - 1], 0.3);
    }
}
END_TEST

/* Photons are alike everywhere but at the rim, which is far, and all within the radius are taken, so how they cluster does
 * not matter: nothing is biased. The printed attenuation, exp(-sigma dx) at each point, is that of the step before. */
START_TEST(an_even_light_is_not_biased_and_as_printed_is_too_bright) {
    static const char *const furnace =
        "nephos: 1\ncamera: {resolution: [4, 4], position: [0, 0, 0], look_at: [1, 0.3, 0.2], fov: 60}\n"
        "media:\n  - {box: [[-1, -1, -1], [1, 1, 1]], extinction: 3.5, albedo: 1, phase: {type: hg, g: 0.4}}\n"
        "lights:\n  - {type: constant, radiance: 1}\n";
    static const char *const knobs[] = {"photonmap.photons=3000", "photonmap.nearest=1024", "photonmap.radius=0.04",
                                        "photonmap.printed=1"};
    RenderCase render;
    NphRenderOptions options = photon_options(768, 32, 3, knobs);
    if (!nph_test_statistics("furnace of photons")) return;
    render_case(&render, furnace, &options, 0);
    double mean = render_mean(&render, "R"), error = render_error(&render, "R");
    render_free(&render);
    options.knob_count = 4;
    render_case(&render, furnace, &options, 0);
    double printed = render_mean(&render, "R");
    printf("    %.4f +- %.4f; as printed %.4f\n", mean, error, printed);
    ck_assert_double_lt(error, 0.015);
    ck_assert_double_le(fabs(mean - 1.0), 4.0 * error);
    ck_assert_double_gt(printed / mean, 1.05); /* the same photons; steps of a quarter: e^(1/8) = 1.13 */
    ck_assert_double_lt(printed / mean, 1.2);
    render_free(&render);
}
END_TEST

static void fill(TCase *tests) {
    tcase_add_loop_test(tests, direct_light_is_single_scattering_in_closed_form, 0, 2);
    tcase_add_loop_test(tests, dim_media_agree_with_path, 0, 4);
    tcase_add_loop_test(tests, without_scattering_only_transmittance_is_left, 0, 4);
    tcase_add_loop_test(tests, few_photons_are_no_exception, 0, 4);
    tcase_add_test(tests, bias_shrinks_with_photons);
    tcase_add_test(tests, bias_shrinks_with_the_radius);
    tcase_add_test(tests, an_even_light_is_not_biased_and_as_printed_is_too_bright);
}

int main(void) { return nph_test_main("photonmap_bias", fill); }
