/* SPDX-License-Identifier: Apache-2.0
 *
 * Surfaces between media: white furnaces, closed forms of a ground under sun, sky, point light and slab, energy in a closed
 * box, and closed meshes that let nothing through. Where no choice is left to chance the sample is the closed form, and
 * the test asks for exactly that. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "harness.h"
#include "render_case.h"

#define PI 3.14159265358979323846
#define LOOK(from, to) "camera: {type: perspective, resolution: [24, 24], position: " from ", look_at: " to ", fov: 40}\n"
/* Straight down onto [-2, 2]^2, pixels of 0.5 m. */
#define DOWN(height) "camera: {type: orthographic, resolution: [8, 8], position: [0, 0, " height \
    "], direction: [0, 0, -1], up: [0, 1, 0], extent: 4}\n"
#define WHITE "lights:\n  - {type: constant, radiance: 1}\n"

static const char *write_square(void) {
    return nph_test_write("square.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n");
}

/* [-1, 1]^3. */
static const char *write_cube(void) {
    return nph_test_write("cube.obj", "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n"
                                 "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
}

/* The unit sphere as rings of `n` and `n / 2` steps: slivers at its poles. */
static const char *write_sphere(int n) {
    const char *path = nph_test_temporary("sphere.obj");
    FILE *file = fopen(path, "w");
    ck_assert_ptr_nonnull(file);
    int rings = n / 2;
    for (int i = 1; i < rings; i++)
        for (int j = 0; j < n; j++)
            fprintf(file, "v %.17g %.17g %.17g\n", sin(PI * i / rings) * cos(2 * PI * j / n),
                    sin(PI * i / rings) * sin(2 * PI * j / n), cos(PI * i / rings));
    fprintf(file, "v 0 0 1\nv 0 0 -1\n");
    int top = (rings - 1) * n + 1, bottom = top + 1;
    for (int j = 0; j < n; j++) {
        int k = (j + 1) % n, last = (rings - 2) * n;
        fprintf(file, "f %d %d %d\nf %d %d %d\n", top, j + 1, k + 1, bottom, last + k + 1, last + j + 1);
        for (int i = 0; i + 2 < rings; i++)
            fprintf(file, "f %d %d %d %d\n", i * n + j + 1, (i + 1) * n + j + 1, (i + 1) * n + k + 1, i * n + k + 1);
    }
    ck_assert_int_eq(fclose(file), 0);
    return path;
}

static void start(RenderCase *render, const char *text, int64_t samples, int precision) {
    NphRenderOptions options = render_options(samples, precision);
    render_case(render, render_text("nephos: 1\n%s", text), &options, 0);
}

/* Every pixel is `value` to within the roundings of a few operations, and has no variance. */
static void check_flat(const char *text, double value) {
    for (int precision = 32; precision <= 64; precision += 32) {
        RenderCase render;
        start(&render, text, 16, precision);
        const NphChannel *r = nph_image_channel(&render.image, "R"), *v = nph_image_channel(&render.image, "Variance.R");
        for (int i = 0; i < render.image.width * render.image.height; i++) {
            ck_assert_msg(fabs((double)r->pixels[i] - value) <= 1e-6 * value, "f%d pixel %d is %.9g, not %.9g", precision, i,
                          (double)r->pixels[i], value);
            ck_assert_double_le((double)v->pixels[i], 1e-12 * value * value);
        }
        render_free(&render);
    }
}

static void check_mean(const char *what, const char *text, int64_t samples, double value, double most_error) {
    for (int precision = 32; precision <= 64; precision += 32) {
        RenderCase render;
        start(&render, text, samples, precision);
        double mean = render_mean(&render, "R"), error = render_error(&render, "R");
        printf("    %s, f%d: %.6f +- %.6f, closed form %.6f, z %+.2f\n", what, precision, mean, error, value,
               (mean - value) / error);
        ck_assert_double_le(error, most_error * value);
        ck_assert_double_le(fabs(mean - value), 3.9 * error); /* 1e-4, two-sided */
        render_free(&render);
    }
}

/* --- furnaces --- */

static const char *const crowd =
    "surfaces:\n"
    "  - {plane: -0.2, albedo: 1}\n"
    "  - {mesh: ../data/mesh/suzanne.obj, albedo: 1, transform: [{scale: 0.4}, {translate: [0.5, 0.5, 0.5]}]}\n"
    "  - {mesh: ../data/mesh/teapot.obj, albedo: 1, transform: [{scale: 0.2}, {translate: [0, -0.6, -0.2]}]}\n";
static const char *const fog = "media:\n  - {box: [[0, 0, -0.5], [1, 1, 1]], extinction: 3, albedo: 1, phase: {type: hg, g: 0.5}}\n";
static const char *const cloud = "media:\n  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: 20, albedo: 1}\n";

static void check_exact(const char *text, int64_t least_collisions) {
    for (int precision = 32; precision <= 64; precision += 32) {
        RenderCase render;
        start(&render, text, 16, precision);
        const NphChannel *r = nph_image_channel(&render.image, "R"), *v = nph_image_channel(&render.image, "Variance.R");
        for (int i = 0; i < render.image.width * render.image.height; i++) {
            ck_assert_msg(r->pixels[i] == 1.0f, "f%d pixel %d is %.9g", precision, i, (double)r->pixels[i]);
            ck_assert(v->pixels[i] == 0.0f);
        }
        double order = render_mean(&render, "Order.Y");
        printf("    f%d: 1 exactly, %.2f reflections and scatterings a path\n", precision, order);
        ck_assert_double_ge(order, 0.5);
        ck_assert_int_ge(render.statistics.collisions, least_collisions);
        render_free(&render);
    }
}

START_TEST(white_surfaces_in_white_light_are_exactly_one) {
    check_exact(render_text("%s%s%s", LOOK("[-1.5, -2, 1.2]", "[0.4, 0, 0.3]"), crowd, WHITE), 0);
    check_exact(render_text("%s%s%s%s", LOOK("[-1.5, -2, 1.2]", "[0.4, 0.2, 0.4]"), fog, crowd, WHITE), 5000);
    check_exact(render_text("%s%s%s%s", LOOK("[0.6, 0.1, 0.9]", "[0.4, 0.6, 0.5]"), fog, crowd, WHITE), 5000);
    check_exact(render_text("%s%s%s%s", LOOK("[-1.5, -2, 1.2]", "[0.2, 0, 0.2]"), cloud, crowd, WHITE), 5000);
}
END_TEST

static void check_verdict(const char *text, int64_t samples, double margin) {
    RenderCase render;
    NphComparison comparison;
    start(&render, text, samples, 32);
    NphVerdict verdict = render_verdict(&render, 1.0, margin, &comparison);
    printf("    R %.6f +- %.6f: %s (%s)\n", render_mean(&render, "R"), render_error(&render, "R"),
           nph_verdict_name(verdict), comparison.reason);
    ck_assert_msg(verdict == NPH_SAME, "%s: %s", nph_verdict_name(verdict), comparison.reason);
    render_free(&render);
}

START_TEST(white_surfaces_in_coloured_media_are_a_furnace) {
    if (!nph_test_statistics("chromatic furnace with surfaces")) return;
    check_verdict(render_text("%smedia:\n  - {box: [[0, 0, -0.5], [1, 1, 1]], extinction: [1, 2, 3], albedo: 1}\n%s%s",
                              LOOK("[-1.5, -2, 1.2]", "[0.4, 0.2, 0.4]"), crowd, WHITE), 1536, 0.001);
}
END_TEST

/* A map is found by light samples and by chance: the two must add up to 1 on surfaces too. */
START_TEST(white_surfaces_under_a_white_map_are_a_furnace) {
    if (!nph_test_statistics("furnace of a white map with surfaces")) return;
    const char *path = nph_test_temporary("white.exr");
    NphContext *context = nph_test_context(1);
    NphImage white;
    ck_assert_int_eq(nph_image_new(context, 8, 4, &white), NPH_OK);
    for (int c = 0; c < 3; c++) {
        float *pixels = NULL;
        ck_assert_int_eq(nph_image_add_channel(context, &white, (const char *[]){"R", "G", "B"}[c], &pixels), NPH_OK);
        for (int i = 0; i < 32; i++) pixels[i] = 1.0f;
    }
    ck_assert_int_eq(nph_exr_write(context, path, &white), NPH_OK);
    nph_image_free(context, &white);
    nph_test_context_close(context);
    check_verdict(render_text("%s%s%slights:\n  - {type: environment, file: %s, rotation: 30}\n",
                              LOOK("[-1.5, -2, 1.2]", "[0.4, 0.2, 0.4]"), fog, crowd, path), 1536, 0.002);
}
END_TEST

/* --- a ground --- */

START_TEST(a_plane_under_a_uniform_sky_has_its_albedo_times_the_radiance_of_the_sky) {
    check_flat(DOWN("3") "surfaces:\n  - {plane: 0.5, albedo: 0.3}\nlights:\n  - {type: constant, radiance: 2, hemisphere: upper}\n", 0.6);
    check_flat("camera: {type: orthographic, resolution: [8, 8], position: [0, 0, -3], direction: [1, 0, 0.2], extent: 4}\n"
               "surfaces:\n  - {plane: 0.5, albedo: 0.3}\nlights:\n  - {type: constant, radiance: 2, hemisphere: lower}\n", 0.6);
}
END_TEST

START_TEST(a_plane_under_a_sun_reflects_albedo_e_cos_over_pi) {
    check_flat(DOWN("3") "surfaces:\n  - {plane: 0, albedo: 0.7}\nlights:\n  - {type: sun, elevation: 30, azimuth: 70, irradiance: 2}\n",
               0.7 * 2.0 * 0.5 / PI);
    /* level light: nothing, from above and from below */
    check_flat(DOWN("3") "surfaces:\n  - {plane: 0, albedo: 1}\nlights:\n  - {type: sun, direction: [1, 1, 0], irradiance: 2}\n", 0.0);
    check_flat(DOWN("3") "surfaces:\n  - {plane: 0, albedo: 1}\nlights:\n  - {type: sun, direction: [0, 1e-9, -1], irradiance: 2}\n", 0.0);
    check_mean("disc", DOWN("3") "surfaces:\n  - {plane: 0, albedo: 0.7}\n"
               "lights:\n  - {type: sun, elevation: 30, azimuth: 70, irradiance: 2, angular_diameter: 40}\n", 256,
               0.7 * 2.0 * 0.5 / PI, 0.003);
}
END_TEST

START_TEST(a_wall_that_the_sun_grazes_is_black) {
    const char *square = write_square();
    check_flat(render_text("camera: {type: orthographic, resolution: [8, 8], position: [3, 0, 0], direction: [-1, 0, 0], extent: 1}\n"
                           "surfaces:\n  - {mesh: %s, albedo: 1, transform: [{rotate: {axis: [0, 1, 0], angle: 90}}]}\n"
                           "lights:\n  - {type: sun, direction: [0, 0, 1], irradiance: 2}\n", square), 0.0);
    check_flat(render_text("camera: {type: orthographic, resolution: [8, 8], position: [3, 0, 0], direction: [-1, 0, 0], extent: 1}\n"
                           "surfaces:\n  - {mesh: %s, albedo: 1, transform: [{rotate: {axis: [0, 1, 0], angle: 90}}]}\n"
                           "lights:\n  - {type: sun, direction: [0.6, 0, 0.8], irradiance: 2}\n", square), 2.0 * 0.6 / PI);
}
END_TEST

/* E = I h / r^3 under a point light at height h; the mean over [-2, 2]^2 by Gauss-Legendre would be overkill: the flux
 * through a square seen from its axis is 4 I asin(a^2 / (a^2 + h^2)). */
START_TEST(a_point_light_over_a_plane_gives_the_flux_of_its_solid_angle) {
    check_mean("point", DOWN("0.5") "surfaces:\n  - {plane: 0, albedo: 1}\nlights:\n  - {type: point, position: [0, 0, 1], intensity: 5}\n",
               1024, 5.0 * 4.0 * asin(4.0 / 5.0) / 16.0 / PI, 0.002);
}
END_TEST

START_TEST(what_stands_before_the_sun_is_dark_and_what_does_not_is_not) {
    const char *square = write_square();
    const char *text = render_text(DOWN("0.5") "surfaces:\n  - {plane: 0, albedo: 0.5}\n"
                                   "  - {mesh: %s, albedo: 0, transform: [{translate: [0, 0, 1]}]}\n"
                                   "lights:\n  - {type: sun, direction: [0, 0, 1], irradiance: 1}\n", square);
    for (int precision = 32; precision <= 64; precision += 32) {
        RenderCase render;
        start(&render, text, 16, precision);
        const NphChannel *r = nph_image_channel(&render.image, "R"), *a = nph_image_channel(&render.image, "A");
        const NphChannel *z = nph_image_channel(&render.image, "Z");
        for (int i = 0; i < 64; i++) {
            int x = i % 8, y = i / 8, dark = x >= 2 && x < 6 && y >= 2 && y < 6;
            ck_assert_msg(dark ? r->pixels[i] == 0.0f : fabs((double)r->pixels[i] - 0.5 / PI) < 1e-6, "pixel %d,%d is %g", x, y,
                          (double)r->pixels[i]);
            ck_assert(a->pixels[i] == 1.0f && z->pixels[i] == 0.5f);
        }
        render_free(&render);
    }
}
END_TEST

/* E3, by its integral: int_0^1 mu exp(-x / mu) dmu. */
static double e3(double x) {
    double sum = 0.0;
    int steps = 20000;
    for (int i = 0; i < steps; i++) {
        double mu = (i + 0.5) / steps;
        sum += mu * exp(-x / mu);
    }
    return sum / steps;
}

#define FLUX(height, towards) "camera: {type: flux, resolution: [16, 16], position: [0, 0, " height "], direction: [0, 0, " towards \
    "], up: [0, 1, 0], extent: 4}\n"
#define SUN60 "lights:\n  - {type: sun, elevation: 60, azimuth: 20, irradiance: 1}\n"

/* What goes up above an absorbing slab over a Lambertian ground: a mu exp(-tau / mu) 2 E3(tau). */
START_TEST(light_that_a_ground_sends_through_an_absorbing_slab_is_the_closed_form) {
    double mu = sin(PI / 3), value = 0.8 * mu * exp(-0.7 / mu) * 2.0 * e3(0.7);
    check_mean("layer", FLUX("2", "-1") "media:\n  - {layer: [0, 1], extinction: 0.7, albedo: 0}\n"
               "surfaces:\n  - {plane: 0, albedo: 0.8}\n" SUN60, 256, value, 0.006);
    check_mean("surface within the layer", FLUX("2", "-1") "media:\n  - {layer: [-1, 1], extinction: 0.7, albedo: 0}\n"
               "surfaces:\n  - {plane: 0, albedo: 0.8}\n" SUN60, 256, value, 0.006);
}
END_TEST

static double flux(const char *text, double *error) {
    RenderCase render;
    start(&render, text, 1024, 32);
    double mean = render_mean(&render, "R");
    *error = render_error(&render, "R");
    render_free(&render);
    return mean;
}

/* R = R0 + T a T' / (1 - a R'), the sum over all reflections between the ground and the slab: R0, T for the sun, R', T'
 * for even light from below. Each measured without the ground. And the light that reaches the ground is T / (1 - a R'). */
START_TEST(a_slab_over_a_ground_sends_back_the_sum_of_all_reflections) {
    if (!nph_test_statistics("slab over a ground")) return;
    static const char slab[] = "media:\n  - {layer: [0, 1], extinction: 4, albedo: 0.95, phase: {type: hg, g: 0.6}}\n";
    static const char below[] = "lights:\n  - {type: constant, radiance: 0.31830988618379067, hemisphere: lower}\n";
    static const char ground[] = "surfaces:\n  - {plane: -0.5, albedo: 0.8}\n";
    double e[6], a = 0.8;
    double r0 = flux(render_text("%s%s%s", FLUX("2", "-1"), slab, SUN60), &e[0]);
    double t = flux(render_text("%s%s%s", FLUX("-0.2", "1"), slab, SUN60), &e[1]);
    double r1 = flux(render_text("%s%s%s", FLUX("-0.2", "1"), slab, below), &e[2]);
    double t1 = flux(render_text("%s%s%s", FLUX("2", "-1"), slab, below), &e[3]);
    double up = flux(render_text("%s%s%s%s", FLUX("2", "-1"), slab, ground, SUN60), &e[4]);
    double down = flux(render_text("%s%s%s%s", FLUX("-0.2", "1"), slab, ground, SUN60), &e[5]);
    double gain = 1.0 / (1.0 - a * r1), sum = r0 + t * a * t1 * gain, arrives = t * gain;
    double es = sqrt(e[0] * e[0] + pow(a * t1 * gain * e[1], 2) + pow(t * a * gain * e[3], 2) +
                     pow(t * a * t1 * gain * gain * a * e[2], 2) + e[4] * e[4]);
    double ea = sqrt(pow(gain * e[1], 2) + pow(arrives * gain * a * e[2], 2) + e[5] * e[5]);
    printf("    R0 %.5f T %.5f R' %.5f T' %.5f: up %.5f, sum %.5f, z %+.2f; down %.5f, sum %.5f, z %+.2f\n", r0, t, r1, t1,
           up, sum, (up - sum) / es, down, arrives, (down - arrives) / ea);
    ck_assert_double_le(es, 0.004 * sum);
    ck_assert_double_le(ea, 0.004 * arrives);
    ck_assert_double_le(fabs(up - sum), 3.3 * es);
    ck_assert_double_le(fabs(down - arrives), 3.3 * ea);
}
END_TEST

START_TEST(nothing_is_lost_between_a_white_ground_and_a_slab_that_does_not_absorb) {
    check_mean("all comes back", FLUX("2", "-1") "media:\n  - {layer: [0, 1], extinction: 2, albedo: 1, phase: {type: hg, g: 0.6}}\n"
               "surfaces:\n  - {plane: 0, albedo: 1}\n" SUN60, 256, sin(PI / 3), 0.01);
}
END_TEST

/* --- colours --- */

START_TEST(each_channel_of_coloured_surfaces_is_a_grey_surface_of_its_albedo) {
    static const char *const channels[] = {"R", "G", "B"};
    static const double albedo[] = {0.9, 0.5, 0.0};
    static const char frame[] = LOOK("[-1.5, -2, 1.2]", "[0.4, 0.2, 0.4]")
        "media:\n  - {box: [[0, 0, -0.5], [1, 1, 1]], extinction: 2, albedo: 0.9}\n"
        "surfaces:\n  - {plane: -0.2, albedo: %s}\n"
        "  - {mesh: ../data/mesh/suzanne.obj, albedo: 0.4, transform: [{scale: 0.4}, {translate: [0.5, 0.5, 0.5]}]}\n"
        "lights:\n  - {type: sun, direction: [-1, -1, 1], irradiance: 3}\n  - {type: constant, radiance: 0.5, hemisphere: upper}\n";
    RenderCase wide;
    start(&wide, render_text(frame, "[0.9, 0.5, 0]"), 256, 32);
    for (int i = 0; i < 3; i++) {
        RenderCase grey;
        NphRenderOptions options = render_options(256, 32);
        options.seed_given = 1;
        options.seed = 50u + (uint32_t)i;
        render_case(&grey, render_text("nephos: 1\n%s", render_text(frame, render_text("%g", albedo[i]))), &options, 0);
        double a = render_mean(&wide, channels[i]), b = render_mean(&grey, "R");
        double ea = render_error(&wide, channels[i]), eb = render_error(&grey, "R"), error = sqrt(ea * ea + eb * eb);
        printf("    %s: %.5f, grey %.5f, z %+.2f\n", channels[i], a, b, (a - b) / error);
        ck_assert_double_le(error, 0.01 * b);
        ck_assert_double_le(fabs(a - b), 3.0 * error);
        render_free(&grey);
    }
    render_free(&wide);
}
END_TEST

/* Two meshes with a plane between them in the list, and triangles of both in one hierarchy. */
START_TEST(every_surface_has_its_own_albedo) {
    const char *square = write_square();
    for (int precision = 32; precision <= 64; precision += 32) {
        RenderCase render;
        start(&render, render_text(DOWN("3") "surfaces:\n"
                                   "  - {mesh: %s, albedo: 0.2, transform: [{scale: [0.5, 2, 1]}, {translate: [-1.5, 0, 0]}]}\n"
                                   "  - {plane: -1, albedo: 0.6}\n"
                                   "  - {mesh: %s, albedo: 0.8, transform: [{scale: [0.5, 2, 1]}, {translate: [0.5, 0, 0]}]}\n"
                                   "lights:\n  - {type: sun, direction: [0, 0, 1], irradiance: 3.14159265}\n", square, square),
              16, precision);
        const NphChannel *r = nph_image_channel(&render.image, "R");
        for (int i = 0; i < 64; i++) {
            int strip = i % 8 / 2;
            double direct = strip == 0 ? 0.2 : strip == 2 ? 0.8 : 0.6;
            /* the plane has some light more that the squares send back down */
            ck_assert_double_ge((double)r->pixels[i], direct * (1.0 - 1e-6));
            ck_assert_double_le((double)r->pixels[i], direct + (strip & 1 ? 0.6 * 0.6 * 0.8 : 1e-6));
        }
        render_free(&render);
    }
}
END_TEST

/* --- closed meshes --- */

/* A point light in the middle of a closed cube: what it sends, 4 pi I, is what the walls absorb, (1 - a) E A. A sensor just
 * before one of the six faces sees their mean irradiance. Clouds in the corners that do not absorb change nothing. */
START_TEST(the_walls_of_a_closed_box_absorb_what_its_light_sends) {
    if (!nph_test_statistics("a closed box")) return;
    const char *cube = write_cube();
    char media[4096] = "media:\n";
    for (int corner = 0; corner < 8; corner++) {
        double lo[3], hi[3];
        for (int k = 0; k < 3; k++) {
            lo[k] = corner >> k & 1 ? 0.3 : -1.2; /* they reach through the walls */
            hi[k] = lo[k] + 0.9;
        }
        snprintf(media + strlen(media), sizeof media - strlen(media),
                 "  - {box: [[%g, %g, %g], [%g, %g, %g]], extinction: 5, albedo: 1, phase: {type: hg, g: 0.5}}\n", lo[0], lo[1],
                 lo[2], hi[0], hi[1], hi[2]);
    }
    const char *room = render_text("camera: {type: flux, resolution: [8, 8], position: [0.99999, 0, 0], direction: [-1, 0, 0], extent: 2}\n"
                                   "surfaces:\n  - {mesh: %s, albedo: 0.7}\n"
                                   "lights:\n  - {type: point, position: [0, 0, 0], intensity: 1}\n  - {type: constant, radiance: 100}\n", cube);
    double value = 4.0 * PI / (0.3 * 24.0);
    check_mean("empty", room, 256, value, 0.005);
    check_mean("with clouds", render_text("%s%s", room, media), 256, value, 0.005);
}
END_TEST

static void check_black(const char *what, const char *text, int64_t samples) {
    for (int precision = 32; precision <= 64; precision += 32) {
        RenderCase render;
        start(&render, text, samples, precision);
        const NphChannel *r = nph_image_channel(&render.image, "R");
        int lit = 0;
        for (int i = 0; i < render.image.width * render.image.height; i++) lit += r->pixels[i] != 0.0f;
        printf("    %s, f%d: %d of %d pixels lit, %lld collisions\n", what, precision, lit,
               render.image.width * render.image.height, (long long)render.statistics.collisions);
        ck_assert_int_eq(lit, 0);
        render_free(&render);
    }
}

/* A closed mesh turned out of all axes, fog on both sides of it. */
START_TEST(no_light_enters_or_leaves_a_closed_mesh) {
    static const char turned[] = "transform: [{scale: [1, 0.8, 0.6]}, {rotate: {axis: [1, 2, 3], angle: 50}}, {translate: [3, 4, 5]}]";
    const char *meshes[] = {write_cube(), write_sphere(24)};
    const char *fogs = "media:\n  - {box: [[1, 2, 3], [5, 6, 7]], extinction: 1.5, albedo: 1, phase: {type: hg, g: 0.3}}\n";
    for (int m = 0; m < 2 && (m == 0 || nph_test_long("light in and out of a closed sphere")); m++) {
        const char *surfaces = render_text("surfaces:\n  - {mesh: %s, albedo: 0.9, %s}\n", meshes[m], turned);
        check_black("in", render_text("%s%s%slights:\n  - {type: sun, direction: [1, 1, 1], irradiance: 10}\n"
                                      "  - {type: sun, direction: [-1, -1, 0], irradiance: 10, angular_diameter: 90}\n"
                                      "  - {type: constant, radiance: 10}\n  - {type: point, position: [3, 4, 7], intensity: 9}\n",
                                      LOOK("[3, 4, 5]", "[3, 4.1, 5.3]"), fogs, surfaces), 16);
        check_black("out", render_text("%s%s%slights:\n  - {type: point, position: [3, 4, 5], intensity: 9}\n",
                                       LOOK("[0, 0, 0]", "[3, 4, 5]"), fogs, surfaces), 32);
    }
}
END_TEST

/* Camera rays are moved to the box around the scene, where the faces of this mesh lie. */
START_TEST(a_mesh_that_fills_the_box_around_the_scene_hides_what_is_in_it) {
    const char *cube = write_cube();
    check_black("cube alone", render_text("%ssurfaces:\n  - {mesh: %s, albedo: 0.9}\n"
                                          "lights:\n  - {type: point, position: [0.3, 0.2, 0.1], intensity: 9}\n",
                                          LOOK("[-5, -3, 2]", "[0, 0, 0]"), cube), 32);
    check_black("cube in the plane of a face", render_text("%ssurfaces:\n  - {mesh: %s, albedo: 0.9}\n  - {plane: -1}\n"
                                          "lights:\n  - {type: point, position: [0.3, 0.2, 0.1], intensity: 9}\n",
                                          LOOK("[-5, -3, 1]", "[0, 0, 0]"), cube), 32);
}
END_TEST

/* --- far away --- */

#define FAR_SCENE(x, y, camera) "camera: {type: orthographic, resolution: [16, 16], position: [" camera "], direction: [0, 3, -4], extent: 3}\n" \
    "media:\n  - {box: [[" x ", " y ", 0.5], [1000000" "1, 20000001, 1.5]], extinction: 3, albedo: 0.9}\n" \
    "surfaces:\n  - {plane: 0, albedo: 0.5}\n" \
    "lights:\n  - {type: sun, direction: [1, -2, 3], irradiance: 3}\n  - {type: constant, radiance: 0.2, hemisphere: upper}\n"

/* The same rays from 10 m and from 1e7 m away, at 1e7 m from the world's origin: the ground with a shadow on it. */
START_TEST(a_camera_ten_million_metres_away_sees_the_same_ground) {
    static const char near[] = FAR_SCENE("9999999", "19999999", "10000000, 19999994, 8");
    static const char away[] = FAR_SCENE("9999999", "19999999", "10000000, 13999994, 8000008");
    RenderCase a, b;
    start(&a, near, 64, 32);
    start(&b, away, 64, 32);
    double one = render_mean(&a, "R"), other = render_mean(&b, "R"), error = render_error(&a, "R");
    printf("    %.6f +- %.6f and %.6f\n", one, error, other);
    ck_assert_double_gt(error, 0.001 * one);
    ck_assert_double_le(fabs(one - other), 0.5 * error); /* nearly all of their paths are the same */
    ck_assert_double_eq(render_mean(&a, "A"), render_mean(&b, "A"));
    ck_assert_double_eq_tol(render_mean(&b, "Z") - render_mean(&a, "Z"), 1e7, 8.0);
    render_free(&a);
    render_free(&b);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, white_surfaces_in_white_light_are_exactly_one);
    tcase_add_test(cases, white_surfaces_in_coloured_media_are_a_furnace);
    tcase_add_test(cases, white_surfaces_under_a_white_map_are_a_furnace);
    tcase_add_test(cases, a_plane_under_a_uniform_sky_has_its_albedo_times_the_radiance_of_the_sky);
    tcase_add_test(cases, a_plane_under_a_sun_reflects_albedo_e_cos_over_pi);
    tcase_add_test(cases, a_wall_that_the_sun_grazes_is_black);
    tcase_add_test(cases, a_point_light_over_a_plane_gives_the_flux_of_its_solid_angle);
    tcase_add_test(cases, what_stands_before_the_sun_is_dark_and_what_does_not_is_not);
    tcase_add_test(cases, light_that_a_ground_sends_through_an_absorbing_slab_is_the_closed_form);
    tcase_add_test(cases, a_slab_over_a_ground_sends_back_the_sum_of_all_reflections);
    tcase_add_test(cases, nothing_is_lost_between_a_white_ground_and_a_slab_that_does_not_absorb);
    tcase_add_test(cases, each_channel_of_coloured_surfaces_is_a_grey_surface_of_its_albedo);
    tcase_add_test(cases, every_surface_has_its_own_albedo);
    tcase_add_test(cases, the_walls_of_a_closed_box_absorb_what_its_light_sends);
    tcase_add_test(cases, no_light_enters_or_leaves_a_closed_mesh);
    tcase_add_test(cases, a_mesh_that_fills_the_box_around_the_scene_hides_what_is_in_it);
    tcase_add_test(cases, a_camera_ten_million_metres_away_sees_the_same_ground);
}

int main(void) { return nph_test_main("surfaces", fill); }
