/* SPDX-License-Identifier: Apache-2.0
 *
 * Fluence and radiance on a rectangle, flux beside finite media, and the fisheye, against closed forms and against one
 * another. Where every sample is the same number the picture is compared pixel by pixel. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "harness.h"
#include "render_case.h"

#define PI 3.14159265358979323846

static void render(RenderCase *r, int64_t samples, uint32_t seed, const char *yaml) {
    NphRenderOptions options = render_options(samples, 32);
    options.seed_given = 1;
    options.seed = seed;
    render_case(r, yaml, &options, 0);
}

static float pixel(const RenderCase *r, const char *channel, int x, int y) {
    return nph_image_channel(&r->image, channel)->pixels[y * r->image.width + x];
}

/* Largest relative difference of any pixel from value. */
static double farthest(const RenderCase *r, const char *channel, double value) {
    double worst = 0.0;
    for (int i = 0; i < r->image.width * r->image.height; i++) {
        double difference = fabs((double)nph_image_channel(&r->image, channel)->pixels[i] / value - 1.0);
        worst = difference > worst ? difference : worst;
    }
    return worst;
}

/* Half way down a layer that only absorbs: E exp(-sigma (1 - z) / mu0), from whichever side the rectangle looks. */
START_TEST(fluence_of_a_sun_above_an_absorbing_slab_is_the_attenuated_beam) {
    static const char *const directions[] = {"[0, 0, 1]", "[0, 0, -1]", "[1, 2, 0]"};
    const char *up = _i < 2 ? "[0, 1, 0]" : "[0, 0, 1]";
    RenderCase r;
    render(&r, 16, 1, render_text("nephos: 1\ncamera: {type: fluence, resolution: [4, 4], position: [0, 0, 0.25], direction: %s, up: %s,"
                                  " extent: 1e-6}\nmedia:\n  - {layer: [0, 1], extinction: [2, 0.5, 0], albedo: 0}\n"
                                  "lights:\n  - {type: sun, elevation: 30, azimuth: 70, irradiance: 3}\n", directions[_i], up));
    ck_assert_double_le(farthest(&r, "R", 3.0 * exp(-2.0 * 0.75 / 0.5)), 4e-6);
    ck_assert_double_le(farthest(&r, "G", 3.0 * exp(-0.5 * 0.75 / 0.5)), 4e-6);
    ck_assert_double_le(farthest(&r, "B", 3.0), 1e-6);
    render_free(&r);
}
END_TEST

START_TEST(fluence_in_a_white_furnace_is_four_pi) {
    RenderCase r;
    render(&r, 16, 1, "nephos: 1\ncamera: {type: fluence, resolution: [16, 16], position: [0.5, 0.5, 0.5], direction: [1, 1, 1], extent: 2}\n"
           "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 5, albedo: 1, phase: {type: hg, g: 0.7}}\n"
           "lights:\n  - {type: constant, radiance: 2}\n");
    ck_assert_double_le(farthest(&r, "R", 8.0 * PI), 1e-6);
    render_free(&r);
}
END_TEST

/* A disc's radiance is E / (pi sin^2 h): found by light samples and by chance, weighted to count once. */
START_TEST(fluence_of_a_disc_is_its_radiance_times_its_solid_angle) {
    RenderCase r;
    double h = 25.0 * PI / 180.0, truth = 1.5 / (PI * sin(h) * sin(h)) * 2.0 * PI * (1.0 - cos(h));
    render(&r, 64, 1, "nephos: 1\ncamera: {type: fluence, resolution: [64, 64], position: [0, 0, 0], direction: [1, 0, 0], extent: 1}\n"
           "lights:\n  - {type: sun, elevation: 20, azimuth: 0, irradiance: 1.5, angular_diameter: 50}\n");
    double mean = render_mean(&r, "R"), error = render_error(&r, "R");
    printf("    %.6f +- %.6f, truth %.6f, z %+.2f\n", mean, error, truth, (mean - truth) / error);
    ck_assert_double_le(error, 2e-3 * truth);
    ck_assert_double_le(fabs(mean - truth), 3.3 * error);
    render_free(&r);
}
END_TEST

/* The layer for the balances below; the flux sensor at a height inside of it. */
#define BALANCE "media:\n  - {layer: [0, 1], extinction: 3, albedo: 0.8, phase: {type: hg, g: 0.6}}\n" \
                "lights:\n  - {type: sun, elevation: 50, azimuth: 20, irradiance: 2}\n  - {type: constant, radiance: 0.1, hemisphere: upper}\n"

static double flux(double z, int down, uint32_t seed, double *variance) {
    RenderCase r;
    render(&r, 256, seed, render_text("nephos: 1\ncamera: {type: flux, resolution: [32, 32], position: [0, 0, %g], direction: [0, 0, %d],"
                                      " up: [0, 1, 0], extent: 1}\n" BALANCE, z, down ? 1 : -1));
    double mean = render_mean(&r, "R"), error = render_error(&r, "R");
    render_free(&r);
    *variance += error * error;
    return mean;
}

/* Between two heights the net flux downwards falls by what is absorbed: sigma_a times the integral of the fluence. */
START_TEST(net_flux_falls_by_absorption_times_fluence) {
    double variance = 0.0, lo = 0.2, hi = 0.7, sigma_a = 3.0 * 0.2;
    double above = flux(hi, 1, 11, &variance) - flux(hi, 0, 12, &variance);
    double below = flux(lo, 1, 13, &variance) - flux(lo, 0, 14, &variance);
    RenderCase r;
    render(&r, 256, 15, render_text("nephos: 1\ncamera: {type: fluence, resolution: [32, 32], position: [0, 0, %g], direction: [1, 0, 0],"
                                    " extent: %g}\n" BALANCE, 0.5 * (lo + hi), hi - lo));
    double absorbed = sigma_a * (hi - lo) * render_mean(&r, "R"), error = sigma_a * (hi - lo) * render_error(&r, "R");
    render_free(&r);
    double both = sqrt(variance + error * error);
    printf("    net flux %.5f - %.5f = %.5f, absorbed %.5f, standard error %.5f, z %+.2f\n", above, below, above - below, absorbed,
           both, (above - below - absorbed) / both);
    ck_assert_double_le(both, 0.01 * absorbed);
    ck_assert_double_le(fabs(above - below - absorbed), 3.3 * both);
}
END_TEST

#define CLOUD "media:\n  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: 20, albedo: 0.99, phase: {type: hg, g: 0.8}}\n" \
              "lights:\n  - {type: sun, elevation: 50, azimuth: 20, irradiance: 2}\n"

START_TEST(radiance_along_the_rectangles_own_direction_is_an_orthographic_camera) {
    RenderCase a, b;
    const char *frame = "resolution: [40, 30], position: [-3, -2, 2], look_at: [0, 0, 0], extent: 2";
    render(&a, 16, 1, render_text("nephos: 1\ncamera: {type: orthographic, %s}\n" CLOUD, frame));
    render(&b, 16, 1, render_text("nephos: 1\ncamera: {type: radiance, seen: [3, 2, -2], %s}\n" CLOUD, frame));
    ck_assert_double_gt(render_mean(&a, "R"), 0.01);
    for (int y = 0; y < 30; y++)
        for (int x = 0; x < 40; x++) ck_assert(pixel(&a, "R", x, y) == pixel(&b, "R", x, y) && pixel(&a, "A", x, y) == pixel(&b, "A", x, y));
    render_free(&a);
    render_free(&b);
}
END_TEST

/* A rectangle that stands upright in the layer, one row a height: looking up, exp(-sigma (1 - z) / mu) of the sky is left. */
START_TEST(radiance_inside_an_absorbing_layer_falls_with_the_way_to_its_top) {
    RenderCase r;
    render(&r, 16, 1, "nephos: 1\ncamera: {type: radiance, resolution: [3, 100], position: [0, 0, 0.5], direction: [1, 0, 0], extent: 0.03,"
           " seen: [0, 3, 4]}\nmedia:\n  - {layer: [0, 1], extinction: 2, albedo: 0}\nlights:\n  - {type: constant, radiance: 1}\n");
    for (int block = 0; block < 4; block++) { /* free flights: a sample sees the sky or not; 1200 of them a block */
        double hi = 1.0 - block * 0.25, lo = hi - 0.25, seen = 0.0;
        for (int i = 0; i < 75; i++) seen += (double)pixel(&r, "R", i % 3, 25 * block + i / 3) / 75.0;
        ck_assert_double_le(fabs(seen - 1.6 * (exp(-2.5 * (1.0 - hi)) - exp(-2.5 * (1.0 - lo)))), 0.06);
    }
    double truth = 0.8 / 2.0 * (1.0 - exp(-2.0 / 0.8)), mean = render_mean(&r, "R"), error = render_error(&r, "R");
    ck_assert_double_le(fabs(mean - truth), 3.3 * error);
    ck_assert_double_le(error, 0.02);
    render_free(&r);
}
END_TEST

/* The sensor lies in full light beneath a box that stands aside; the sun shines through the box from there. */
START_TEST(flux_beside_a_box_is_that_of_the_sensors_own_place) {
    RenderCase r;
    double mu = sin(40.0 * PI / 180.0), crossed = 1.0 / cos(40.0 * PI / 180.0);
    render(&r, 16, 1, "nephos: 1\ncamera: {type: flux, resolution: [4, 4], position: [0, 0, 0], direction: [0, 0, 1], up: [0, 1, 0], extent: 1e-3}\n"
           "media:\n  - {box: [[2, -1, 1], [3, 1, 9]], extinction: 0.7, albedo: 0}\n"
           "lights:\n  - {type: sun, elevation: 40, azimuth: 0, irradiance: 3}\n");
    ck_assert_double_le(farthest(&r, "R", 3.0 * mu * exp(-0.7 * crossed)), 1e-5);
    render_free(&r);
}
END_TEST

/* Looking straight up with the top of the picture towards +y, +x lies on the left. */
START_TEST(a_fisheye_pixel_sees_its_angle) {
    enum { SIZE = 90 };
    static const double suns[][2] = {{60, 0}, {60, 90}, {20, 200}, {5, 300}, {90, 0}};
    for (size_t k = 0; k < sizeof suns / sizeof *suns; k++) {
        RenderCase r;
        double elevation = suns[k][0], azimuth = suns[k][1] * PI / 180.0, away = (90.0 - elevation) / 90.0;
        render(&r, 64, 1, render_text("nephos: 1\ncamera: {type: fisheye, resolution: [90, 90], position: [0, 0, 0], direction: [0, 0, 1],"
                                      " up: [0, 1, 0], fov: 180}\nlights:\n  - {type: sun, elevation: %g, azimuth: %g, irradiance: 1,"
                                      " angular_diameter: 8}\n", elevation, suns[k][1]));
        double sum = 0.0, at[2] = {0.0, 0.0};
        for (int y = 0; y < SIZE; y++)
            for (int x = 0; x < SIZE; x++) {
                double value = (double)pixel(&r, "R", x, y);
                sum += value;
                at[0] += value * ((x + 0.5) / SIZE * 2.0 - 1.0);
                at[1] += value * (1.0 - (y + 0.5) / SIZE * 2.0);
            }
        printf("    elevation %g azimuth %g: at %.3f %.3f\n", elevation, suns[k][1], at[0] / sum, at[1] / sum);
        /* a hundredth is less than half a pixel; the picture stretches a disc near the rim across, not along */
        ck_assert_double_le(fabs(at[0] / sum + away * cos(azimuth)), 0.011);
        ck_assert_double_le(fabs(at[1] / sum - away * sin(azimuth)), 0.011);
        render_free(&r);
    }
}
END_TEST

START_TEST(a_whole_fisheye_sees_half_of_the_world_bright_and_nothing_outside_of_its_circle) {
    enum { W = 60, H = 40 };
    RenderCase r;
    render(&r, 64, 1, "nephos: 1\ncamera: {type: fisheye, resolution: [60, 40], position: [0, 0, 0], direction: [0, 0, 1], up: [0, 1, 0], fov: 360}\n"
           "lights:\n  - {type: constant, radiance: 0.5, hemisphere: upper}\n");
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++) {
            double s = (x + 0.5 - W / 2.0) / (H / 2.0), t = (y + 0.5 - H / 2.0) / (H / 2.0), radius = sqrt(s * s + t * t);
            double light = (double)pixel(&r, "R", x, y), opaque = (double)pixel(&r, "A", x, y);
            if (radius < 0.46) ck_assert(light == 0.5 && opaque == 0.0);
            if (radius > 0.54 && radius < 0.96) ck_assert(light == 0.0 && opaque == 0.0);
            if (radius > 1.04) ck_assert(light == 0.0 && opaque == 1.0);
        }
    render_free(&r);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_loop_test(cases, fluence_of_a_sun_above_an_absorbing_slab_is_the_attenuated_beam, 0, 3);
    tcase_add_test(cases, fluence_in_a_white_furnace_is_four_pi);
    tcase_add_test(cases, fluence_of_a_disc_is_its_radiance_times_its_solid_angle);
    tcase_add_test(cases, net_flux_falls_by_absorption_times_fluence);
    tcase_add_test(cases, radiance_along_the_rectangles_own_direction_is_an_orthographic_camera);
    tcase_add_test(cases, radiance_inside_an_absorbing_layer_falls_with_the_way_to_its_top);
    tcase_add_test(cases, flux_beside_a_box_is_that_of_the_sensors_own_place);
    tcase_add_test(cases, a_fisheye_pixel_sees_its_angle);
    tcase_add_test(cases, a_whole_fisheye_sees_half_of_the_world_bright_and_nothing_outside_of_its_circle);
}

int main(void) { return nph_test_main("sensors", fill); }
