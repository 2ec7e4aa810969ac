/* SPDX-License-Identifier: Apache-2.0
 *
 * What arrives of each light without scattering, in closed form: at a flux sensor, and in a camera that looks at it.
 * Between them lies an absorbing box of optical depth 0.7 a metre. */
#include <math.h>
#include <stdio.h>

#include "harness.h"
#include "render_case.h"

#define PI 3.14159265358979323846

/* A flux sensor in the middle of the box's lower face (or 0.2 m below it), facing up or down. */
static void check_flux(const char *lights, double z, int up, double truth) {
    for (int precision = 32; precision <= 64; precision += 32) {
        RenderCase render;
        NphRenderOptions options = render_options(1024, precision);
        render_case(&render, render_text("nephos: 1\n"
                                         "camera: {type: flux, resolution: [16, 16], position: [0, 0, %.17g], direction: [0, 0, %d],"
                                         " up: [0, 1, 0], extent: 1e-4}\n"
                                         "media:\n  - {box: [[-50, -50, 0], [50, 50, 1]], extinction: 0.7, albedo: 0}\n"
                                         "lights:\n  - %s\n", z, up ? 1 : -1, lights), &options, 0);
        double mean = render_mean(&render, "R"), error = render_error(&render, "R");
        printf("    f%d: %.8g +- %.1e, closed form %.8g\n", precision, mean, error, truth);
        /* |z| of 4, and the roundings of f32: a thousand of 2^-24, with what they make of a small distance */
        ck_assert_double_le(fabs(mean - truth), 4.0 * error + 1e-4 * truth);
        ck_assert_double_le(error, 0.01 * truth + 1e-30);
        render_free(&render);
    }
}

START_TEST(a_sun_gives_its_irradiance_times_cosine_and_transmittance) {
    double elevation = 50.0 * PI / 180.0, arrives = 3.0 * sin(elevation) * exp(-0.7 / sin(elevation));
    check_flux("{type: sun, elevation: 50, azimuth: 30, irradiance: 3}", 0.0, 1, arrives);
    check_flux("{type: sun, elevation: 50, azimuth: 30, irradiance: 3}", 0.0, 0, 0.0);
    check_flux("{type: sun, elevation: -50, azimuth: 30, irradiance: 3}", 1.5, 0, 3.0 * sin(elevation) * 1.0 *
               exp(-0.7 / sin(elevation)));
    check_flux("{type: sun, elevation: 50, azimuth: 30, irradiance: 3}", 1.5, 1, 3.0 * sin(elevation));
}
END_TEST

/* The cosine in the mean over a disc of radiance E / (pi sin^2 h) makes E cos again, however large it is. */
START_TEST(a_suns_disc_gives_the_irradiance_of_the_sun) {
    static const double diameters[] = {0.53, 5.0, 40.0};
    double cosine = sin(50.0 * PI / 180.0);
    for (int i = 0; i < 3; i++)
        check_flux(render_text("{type: sun, elevation: 50, azimuth: 30, irradiance: 3, angular_diameter: %g}", diameters[i]), 1.5,
                   1, 3.0 * cosine);
}
END_TEST

START_TEST(a_suns_disc_has_its_irradiance_over_pi_sin_squared) {
    for (int i = 0; i < 2; i++) {
        double diameter = i ? 20.0 : 0.53, s = sin(0.5 * diameter * PI / 180.0);
        RenderCase render;
        NphRenderOptions options = render_options(16, 32);
        render_case(&render, render_text("nephos: 1\n"
                                         "camera: {type: orthographic, resolution: [4, 4], position: [0, 0, 0], direction: [1, 0, 1],"
                                         " extent: 1e-4}\n"
                                         "media:\n  - {box: [[-1, -1, -2], [1, 1, -1]], extinction: 1, albedo: 0.5}\n"
                                         "lights:\n  - {type: sun, direction: [1, 0, 1], irradiance: 3, angular_diameter: %g}\n",
                                         diameter), &options, 1);
        ck_assert_double_eq_tol(render_mean(&render, "R") * PI * s * s / 3.0, 1.0, 1e-5);
        render_free(&render);
    }
}
END_TEST

/* I cos / r^2 exp(-sigma r): behind the light the box goes on, which must not count. */
START_TEST(a_point_light_falls_off_with_the_square_of_its_distance) {
    static const double at[][3] = {{0, 0, 0.9}, {0.3, 0.4, 0.5}, {3, 4, 0.25}};
    for (int i = 0; i < 3; i++) {
        double squared = at[i][0] * at[i][0] + at[i][1] * at[i][1] + at[i][2] * at[i][2], r = sqrt(squared);
        check_flux(render_text("{type: point, position: [%g, %g, %g], intensity: 5}", at[i][0], at[i][1], at[i][2]), 0.0, 1,
                   5.0 * at[i][2] / (r * squared) * exp(-0.7 * r));
    }
}
END_TEST

START_TEST(half_of_the_sky_gives_pi_to_a_sensor_that_faces_it_and_nothing_to_one_that_does_not) {
    static const char *const halves[] = {"lower", "upper"};
    for (int half = 0; half < 2; half++)
        for (int up = 0; up < 2; up++)
            check_flux(render_text("{type: constant, radiance: 2, hemisphere: %s}", halves[half]), up ? 1.5 : -0.5, up,
                       half == up ? 2.0 * PI : 0.0);
}
END_TEST

/* Looking along +y with z up: +x is to the right. */
START_TEST(what_is_above_is_drawn_above_and_what_is_right_to_the_right) {
    static const char *const cameras[] = {"perspective, position: [0, 0, 0], fov: 90", "orthographic, position: [0, 0, 0], extent: 2"};
    for (int i = 0; i < 2; i++) {
        RenderCase render;
        NphRenderOptions options = render_options(16, 32);
        render_case(&render, render_text("nephos: 1\n"
                                         "camera: {type: %s, resolution: [8, 8], direction: [0, 1, 0]}\n"
                                         "media:\n  - {box: [[0, 1, -1], [1, 2, 0]], extinction: 1e6, albedo: 0}\n"
                                         "lights:\n  - {type: constant, radiance: 1, hemisphere: upper}\n", cameras[i]), &options, 1);
        const float *r = nph_image_channel(&render.image, "R")->pixels, *a = nph_image_channel(&render.image, "A")->pixels;
        for (int y = 0; y < 8; y++)
            for (int x = 0; x < 8; x++) {
                int hidden = x >= 4 && y >= 4; /* the box, lower right */
                ck_assert_float_eq(a[8 * y + x], hidden ? 1.0f : 0.0f);
                if (i == 0 && !hidden) ck_assert_float_eq(r[8 * y + x], y < 4 ? 1.0f : 0.0f);
            }
        render_free(&render);
    }
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, a_sun_gives_its_irradiance_times_cosine_and_transmittance);
    tcase_add_test(cases, a_suns_disc_gives_the_irradiance_of_the_sun);
    tcase_add_test(cases, a_suns_disc_has_its_irradiance_over_pi_sin_squared);
    tcase_add_test(cases, a_point_light_falls_off_with_the_square_of_its_distance);
    tcase_add_test(cases, what_is_above_is_drawn_above_and_what_is_right_to_the_right);
    tcase_add_test(cases, half_of_the_sky_gives_pi_to_a_sensor_that_faces_it_and_nothing_to_one_that_does_not);
}

int main(void) { return nph_test_main("lights", fill); }
