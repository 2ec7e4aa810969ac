/* SPDX-License-Identifier: Apache-2.0
 *
 * Pictures of wavelengths: against closed forms at each wavelength, against the scene rendered wavelength by wavelength,
 * and against the grey scene where all wavelengths are alike; each combined to R, G, B by the observer. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "harness.h"
#include "optics/cie.h"
#include "optics/wavelengths.h"
#include "render_case.h"

static const char *const names[] = {"R", "G", "B"};

/* R, G, B of a spectrum. */
static void rgb_of(const double *nm, int count, const double *spectrum, double rgb[3]) {
    double weight[NPH_MAX_WAVELENGTHS][3], xyz[3] = {0, 0, 0};
    nph_wavelength_weights(nm, count, weight);
    for (int i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) xyz[k] += weight[i][k] * spectrum[i];
    nph_rgb_from_xyz(xyz, rgb);
}

/* Each channel of a render against a truth with a standard error of its own: |z| below 3.3, 1% over ten such. */
static void expect_rgb(const RenderCase *render, const double truth[3], const double error[3], double most_error) {
    for (int c = 0; c < 3; c++) {
        double mean = render_mean(render, names[c]), own = render_error(render, names[c]);
        double both = sqrt(own * own + (error ? error[c] * error[c] : 0.0)), z = (mean - truth[c]) / both;
        printf("    %s %.6f +- %.6f, expected %.6f: z %+.2f\n", names[c], mean, own, truth[c], z);
        ck_assert_msg(own < most_error * fabs(truth[c]), "standard error %g of %g", own, truth[c]);
        ck_assert_msg(fabs(z) < 3.3, "%s: z %g", names[c], z);
    }
}

static void render(RenderCase *out, const char *yaml, int64_t samples, uint32_t seed) {
    NphRenderOptions options = render_options(samples, 32);
    options.seed_given = 1;
    options.seed = seed;
    render_case(out, yaml, &options, 0);
}

/* Light scattered once, downwards sun over a layer of depth tau seen from above at right angles:
 *   L = albedo p E / (1 + 1 / mu0) (1 - exp(-tau (1 + 1 / mu0))); twice scattered light is 1e-4 of it. */
START_TEST(a_blue_sky_is_its_closed_form_at_each_wavelength) {
    enum { COUNT = 7 };
    double nm[COUNT] = {400, 440, 490, 540, 580, 630, 700}, spectrum[COUNT], rgb[3], tau[COUNT];
    char list[2][256] = {"", ""};
    for (int i = 0; i < COUNT; i++) {
        tau[i] = 0.3 * pow(550 / nm[i], 4);
        snprintf(list[0] + strlen(list[0]), sizeof list[0] - strlen(list[0]), "%s%g", i ? ", " : "", nm[i]);
        snprintf(list[1] + strlen(list[1]), sizeof list[1] - strlen(list[1]), "%s%.17g", i ? ", " : "", tau[i]);
        /* 30 degrees above the horizon: mu0 = 1/2, scattering angle 120 degrees */
        spectrum[i] = 1e-4 * (3.0 / (16.0 * 3.14159265358979324)) * 1.25 * 1e4 / 3.0 * (1.0 - exp(-3.0 * tau[i]));
    }
    RenderCase sky;
    render(&sky, render_text("nephos: 1\nwavelengths: [%s]\n"
        "camera: {type: orthographic, resolution: [32, 32], position: [0, 0, 3], direction: [0, 0, -1], up: [0, 1, 0], extent: 1}\n"
        "media:\n  - {layer: [0, 1], extinction: [%s], albedo: 1e-4, phase: {type: rayleigh}}\n"
        "lights:\n  - {type: sun, elevation: 30, azimuth: 0, irradiance: 1e4}\n", list[0], list[1]), 1024, 5);
    rgb_of(nm, COUNT, spectrum, rgb);
    ck_assert(rgb[2] > 1.5 * rgb[0]); /* it is blue */
    expect_rgb(&sky, rgb, NULL, 0.004);
    render_free(&sky);
}
END_TEST

static const char *const two = "nephos: 1\n%s"
    "camera: {type: perspective, resolution: [24, 24], position: [-2, -1.5, 1.2], look_at: [0.5, 0.5, 0.5], fov: 30}\n"
    "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: %s, albedo: %s, phase: {type: hg, g: 0.5}}\n"
    "lights:\n  - {type: sun, direction: [-1, 0.2, 0.3], irradiance: %s}\n  - {type: constant, radiance: %s}\n"
    "surfaces:\n  - {plane: -0.1, albedo: %s}\n";

START_TEST(two_wavelengths_are_two_grey_pictures_joined_by_the_observer) {
    if (!nph_test_statistics("two wavelengths")) return;
    static const double nm[2] = {480, 610};
    static const char *const values[2][5] = {{"6", "0.95", "2", "0.3", "0.2"}, {"2", "0.8", "3", "0.1", "0.7"}};
    double weight[2][3], truth[3] = {0, 0, 0}, variance[3] = {0, 0, 0};
    nph_wavelength_weights(nm, 2, weight);
    for (int i = 0; i < 2; i++) {
        RenderCase grey;
        const char *const *v = values[i];
        render(&grey, render_text(two, "", v[0], v[1], v[2], v[3], v[4]), 512, 11u + (uint32_t)i);
        double rgb[3], mean = render_mean(&grey, "R"), error = render_error(&grey, "R");
        nph_rgb_from_xyz(weight[i], rgb);
        for (int c = 0; c < 3; c++) {
            truth[c] += rgb[c] * mean;
            variance[c] += rgb[c] * error * rgb[c] * error;
        }
        render_free(&grey);
    }
    double error[3] = {sqrt(variance[0]), sqrt(variance[1]), sqrt(variance[2])};
    RenderCase both;
    render(&both, render_text(two, "wavelengths: [480, 610]\n", "[6, 2]", "[0.95, 0.8]", "[2, 3]", "[0.3, 0.1]", "[0.2, 0.7]"),
           2048, 13);
    expect_rgb(&both, truth, error, 0.01);
    render_free(&both);
}
END_TEST

START_TEST(wavelengths_that_are_alike_are_the_grey_scene_in_the_white_of_equal_energy) {
    if (!nph_test_statistics("wavelengths that are alike")) return;
    static const double nm[5] = {410, 470, 530, 600, 680}, flat[5] = {1, 1, 1, 1, 1};
    double rgb[3], truth[3], error[3];
    RenderCase grey, many;
    rgb_of(nm, 5, flat, rgb);
    render(&grey, render_text(two, "", "4", "0.9", "2", "0.3", "0.4"), 1024, 21);
    for (int c = 0; c < 3; c++) {
        truth[c] = render_mean(&grey, "R") * rgb[c];
        error[c] = render_error(&grey, "R") * fabs(rgb[c]);
    }
    render(&many, render_text(two, "wavelengths: [410, 470, 530, 600, 680]\n", "4", "0.9", "2", "0.3", "0.4"), 2048, 22);
    expect_rgb(&many, truth, error, 0.01);
    render_free(&grey);
    render_free(&many);
}
END_TEST

/* The same bits as the scene without wavelengths. */
START_TEST(one_wavelength_is_the_grey_picture) {
    RenderCase grey, one;
    render(&grey, render_text(two, "", "4", "0.9", "2", "0.3", "0.4"), 16, 31);
    render(&one, render_text(two, "wavelengths: [555]\n", "[4]", "0.9", "[2]", "0.3", "[0.4]"), 16, 31);
    for (int c = 0; c < 3; c++) {
        const NphChannel *a = nph_image_channel(&grey.image, names[c]), *b = nph_image_channel(&one.image, names[c]);
        ck_assert_mem_eq(a->pixels, b->pixels, 24 * 24 * sizeof(float));
    }
    render_free(&grey);
    render_free(&one);
}
END_TEST

/* An empty scene, seven wavelengths in three groups: the picture's alpha knows no group. */
START_TEST(where_nothing_is_the_transmittance_is_one) {
    RenderCase empty;
    render(&empty, "nephos: 1\nwavelengths: [400, 440, 490, 540, 580, 630, 700]\n"
                   "camera: {resolution: [16, 16], position: [0, -3, 0], look_at: [0, 0, 0], fov: 30}\n"
                   "lights: [{type: constant, radiance: [1, 2, 3, 4, 3, 2, 1]}]\n", 4096, 41);
    const NphChannel *A = nph_image_channel(&empty.image, "A");
    for (int i = 0; i < 256; i++) ck_assert(A->pixels[i] == 0.0f);
    static const double nm[7] = {400, 440, 490, 540, 580, 630, 700}, L[7] = {1, 2, 3, 4, 3, 2, 1};
    double rgb[3];
    rgb_of(nm, 7, L, rgb);
    expect_rgb(&empty, rgb, NULL, 0.005);
    render_free(&empty);
}
END_TEST

/* A method that knows R, G, B alone would paint a wrong picture. */
START_TEST(methods_without_wavelengths_refuse_them) {
    static const char *const methods[] = {"light", "photonmap"}, *const knobs[] = {"photonmap.photons=1000"};
    for (int m = 0; m < 2; m++)
        for (int count = 1; count <= 2; count++) {
            RenderCase tried;
            NphRenderOptions options = render_options(16, 32);
            options.method = methods[m];
            options.knobs = knobs;
            options.knob_count = m;
            const char *list = count == 1 ? "wavelengths: [500]\n" : "wavelengths: [500, 600]\n";
            NphStatus status = render_try(&tried, render_text("nephos: 1\n%s"
                "camera: {resolution: [8, 8], position: [0, -3, 0.5], look_at: [0, 0, 0.5], fov: 30}\n"
                "media: [{box: [[0, 0, 0], [1, 1, 1]], extinction: 1, albedo: 0.5}]\n"
                "lights: [{type: sun, elevation: 50, azimuth: 0, irradiance: 1}]\n", list), &options, 1);
            const char *messages = nph_test_messages();
            ck_assert_msg(status == (count == 1 ? NPH_OK : NPH_BAD_USAGE), "%s, %d: %s", methods[m], count, messages);
            ck_assert(count == 1 || strstr(messages, "does not render wavelengths") != NULL);
            render_free(&tried);
        }
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, a_blue_sky_is_its_closed_form_at_each_wavelength);
    tcase_add_test(cases, two_wavelengths_are_two_grey_pictures_joined_by_the_observer);
    tcase_add_test(cases, wavelengths_that_are_alike_are_the_grey_scene_in_the_white_of_equal_energy);
    tcase_add_test(cases, one_wavelength_is_the_grey_picture);
    tcase_add_test(cases, methods_without_wavelengths_refuse_them);
    tcase_add_test(cases, where_nothing_is_the_transmittance_is_one);
}

int main(void) { return nph_test_main("spectrum", fill); }
