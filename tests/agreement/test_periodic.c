/* SPDX-License-Identifier: Apache-2.0
 *
 * Sides that repeat, against closed forms, against layers without end, and against the same field written out so many
 * times that its edges do not matter. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "harness.h"
#include "io/volume.h"
#include "render_case.h"

#define PI 3.14159265358979323846

static NphStatus try(RenderCase *r, int64_t samples, uint32_t seed, int precision, const char *yaml) {
    NphRenderOptions options = render_options(samples, precision);
    options.seed_given = 1;
    options.seed = seed;
    return render_try(r, yaml, &options, 0);
}

static void render(RenderCase *r, int64_t samples, uint32_t seed, const char *yaml) {
    NphStatus status = try(r, samples, seed, 32, yaml);
    ck_assert_msg(status == NPH_OK, "%s: %s\n%s", nph_status_name(status), nph_test_messages(), yaml);
}

/* Cells of a checkerboard, 0.3 and 1, in nx x ny columns of nz cells. */
static const char *checkerboard(const char *name, int nx, int ny, int nz) {
    NphContext *context = nph_test_context(1);
    NphArray array = {0};
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 3, (int64_t[]){nz, ny, nx}, "test", &array), NPH_OK);
    float *cells = array.data;
    for (int i = 0; i < nx * ny * nz; i++) cells[i] = (i % nx + i / nx % ny) % 2 ? 0.3f : 1.0f;
    ck_assert_int_eq(nph_npy_write(context, nph_test_temporary(name), &array), NPH_OK);
    nph_array_free(context, &array);
    nph_test_context_close(context);
    return nph_test_temporary(name);
}

static double z_of(const char *what, double a, double ea, double b, double eb) {
    double error = sqrt(ea * ea + eb * eb), z = (a - b) / error;
    printf("    %s: %.6f +- %.6f and %.6f +- %.6f, z %+.2f\n", what, a, ea, b, eb, z);
    return fabs(z);
}

/* One period that is full of a medium is a layer, as a box and as a grid, for a sun that crosses many periods. */
START_TEST(a_full_period_is_a_layer_without_end) {
    static const char *const kinds[] = {"box: [[0, 0, 0], [0.7, 0.4, 1]]", NULL, "layer: [0, 1]"};
    const char *file = nph_test_temporary("full.npy");
    if (!nph_test_statistics("a full period")) return;
    NphContext *context = nph_test_context(1);
    NphArray array = {0};
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 3, (int64_t[]){9, 7, 5}, "test", &array), NPH_OK);
    for (int i = 0; i < 9 * 7 * 5; i++) ((float *)array.data)[i] = 1.0f;
    ck_assert_int_eq(nph_npy_write(context, file, &array), NPH_OK);
    nph_array_free(context, &array);
    nph_test_context_close(context);
    double mean[3][2], error[3][2], worst = 0.0;
    for (int k = 0; k < 3; k++)
        for (int below = 0; below < 2; below++) {
            RenderCase r;
            const char *medium = kinds[k] ? kinds[k]
                : render_text("density: {file: %s, lookup: nearest, box: [[0, 0, 0], [0.7, 0.4, 1]]}", file);
            render(&r, 64, (uint32_t)(10 * k + below), render_text(
                "nephos: 1\ncamera: {type: flux, resolution: [48, 48], position: [3, 7, %s], direction: [0, 0, %d], up: [0, 1, 0], extent: 5}\n"
                "periodic: {x: [0, 0.7], y: [0, 0.4]}\nmedia:\n  - {%s, extinction: 3, albedo: 0.9, phase: {type: hg, g: 0.7}}\n"
                "lights:\n  - {type: sun, elevation: 25, azimuth: 33, irradiance: 2}\n", below ? "-0.01" : "1.01", below ? 1 : -1, medium));
            mean[k][below] = render_mean(&r, "R");
            error[k][below] = render_error(&r, "R");
            ck_assert_double_le(error[k][below], 0.015 * mean[k][below]);
            render_free(&r);
        }
    for (int k = 0; k < 2; k++)
        for (int below = 0; below < 2; below++) {
            double z = z_of(k ? "grid" : "box", mean[k][below], error[k][below], mean[2][below], error[2][below]);
            worst = z > worst ? z : worst;
        }
    ck_assert_double_le(worst, 3.03); /* four comparisons at 1% in all */
}
END_TEST

/* Stripes of half a period's width. The sun's rays move by a whole number of periods between top and ground, so that each of
 * them has crossed the same length of stripe. */
START_TEST(a_sun_that_crosses_many_periods_loses_the_same_light_everywhere) {
    static const int periods[] = {1, 10, 1000};
    for (int k = 0; k < 3; k++) {
        RenderCase r;
        double run = 0.5 * periods[k], slant = sqrt(run * run + 1.0), truth = 2.0 / slant * exp(-0.002 * 0.5 * slant);
        render(&r, 16, 1, render_text(
            "nephos: 1\ncamera: {type: flux, resolution: [16, 16], position: [0.1, 7, 0], direction: [0, 0, 1], up: [0, 1, 0], extent: 5}\n"
            "periodic: {x: [0, 0.5]}\nmedia:\n  - {box: [[0.1, -1e6, 0], [0.35, 1e6, 1]], extinction: 0.002, albedo: 0}\n"
            "lights:\n  - {type: sun, direction: [-%.17g, 0, 1], irradiance: 2}\n", run));
        for (int i = 0; i < 256; i++)
            ck_assert_double_eq_tol((double)nph_image_channel(&r.image, "R")->pixels[i] / truth, 1.0, 1e-4);
        render_free(&r);
    }
}
END_TEST

/* One period of two by two columns against 34 x 34 columns whose middle is looked at. Paths draw the same random words and
 * so are the same but for rounding, until one in thousands leaves the wide field through its edge. */
START_TEST(a_periodic_checkerboard_is_the_middle_of_a_wide_one_path_by_path) {
    static const char *const sensors[] = {"type: flux, position: [0.5, 0.5, 1.01], direction: [0, 0, -1]",
                                          "type: flux, position: [0.5, 0.5, -0.01], direction: [0, 0, 1]",
                                          "type: orthographic, position: [0.5, 0.5, 2], direction: [0, 0, -1]",
                                          "type: fluence, position: [0.5, 0.5, 0.4], direction: [0, 0, 1]",
                                          "type: perspective, fov: 40, position: [0.5, 0.2, 2], direction: [0.2, 0.4, -1]"};
    const char *one = checkerboard("one.npy", 2, 2, 3), *wide = checkerboard("wide.npy", 34, 34, 3);
    for (int k = 0; k < 5; k++) {
        RenderCase a, b;
        const char *rest = "extinction: 6, albedo: 0.95, phase: {type: hg, g: 0.5}}\n"
                           "lights:\n  - {type: sun, elevation: 40, azimuth: 20, irradiance: 2}\n";
        const char *extent = k < 4 ? "extent: 1, " : "";
        render(&a, 16, 1, render_text("nephos: 1\ncamera: {%s, %sup: [0, 1, 0], resolution: [48, 48]}\nperiodic: {x: [0, 1], y: [0, 1]}\n"
                                      "media:\n  - {density: {file: %s, lookup: nearest, box: [[0, 0, 0], [1, 1, 1]]}, %s", sensors[k], extent, one, rest));
        render(&b, 16, 1, render_text("nephos: 1\ncamera: {%s, %sup: [0, 1, 0], resolution: [48, 48]}\n"
                                      "media:\n  - {density: {file: %s, lookup: nearest, box: [[-8, -8, 0], [9, 9, 1]]}, %s", sensors[k], extent, wide, rest));
        const float *pa = nph_image_channel(&a.image, "R")->pixels, *pb = nph_image_channel(&b.image, "R")->pixels;
        int alike = 0;
        for (int i = 0; i < 48 * 48; i++) alike += fabsf(pa[i] - pb[i]) <= 1e-4f * pb[i];
        double mean = render_mean(&b, "R"), difference = render_mean(&a, "R") / mean - 1.0;
        printf("    %s: mean %.5f, relative difference %+.1e, %d of 2304 pixels alike\n", sensors[k], mean, difference, alike);
        ck_assert_int_ge(alike, 2100);
        ck_assert_double_le(fabs(difference), 2e-3);
        render_free(&a);
        render_free(&b);
    }
}
END_TEST

/* The file holds two periods of the pattern: which of them the interval cuts out, and where it begins, is nothing that light
 * could see. */
START_TEST(it_does_not_matter_where_the_period_begins) {
    static const char *const periods[] = {"x: [0, 1], y: [0, 1]", "x: [0.5, 1.5], y: [0.25, 1.25]", "x: [0.2, 2.2], y: [1, 2]"};
    if (!nph_test_statistics("where a period begins")) return;
    const char *file = checkerboard("begin.npy", 6, 4, 3);
    double mean[3], error[3], worst = 0.0;
    for (int k = 0; k < 3; k++) {
        RenderCase r;
        render(&r, 64, (uint32_t)k, render_text(
            "nephos: 1\ncamera: {type: orthographic, position: [5.5, -3.5, 4], direction: [0.3, 0.1, -1], up: [0, 1, 0], resolution: [48, 48], extent: 3}\n"
            "periodic: {%s}\nmedia:\n  - {density: {file: %s, lookup: nearest, box: [[0, 0, 0], [3, 2, 1]]}, extinction: 6, albedo: 0.95}\n"
            "lights:\n  - {type: sun, elevation: 40, azimuth: 20, irradiance: 2}\n", periods[k], file));
        mean[k] = render_mean(&r, "R");
        error[k] = render_error(&r, "R");
        render_free(&r);
        double z = k ? z_of(periods[k], mean[k], error[k], mean[0], error[0]) : 0.0;
        worst = z > worst ? z : worst;
    }
    ck_assert_double_le(worst, 2.81);
}
END_TEST

/* White walls all around: light goes in and comes out, whatever path it takes through the periods. */
START_TEST(a_periodic_white_furnace_is_white) {
    const char *file = checkerboard("white.npy", 4, 4, 3);
    RenderCase r;
    render(&r, 16, 1, render_text("nephos: 1\ncamera: {type: fluence, position: [0.5, 0.5, 0.4], direction: [0, 0, 1], up: [0, 1, 0], resolution: [16, 16], extent: 1}\n"
           "periodic: {x: [0, 1], y: [0, 1]}\nmedia:\n  - {density: {file: %s, box: [[0, 0, 0], [1, 1, 1]]}, extinction: 6, phase: {type: hg, g: 0.9}}\n"
           "lights:\n  - {type: constant, radiance: 1}\n", file));
    for (int i = 0; i < 256; i++) ck_assert_double_eq_tol((double)nph_image_channel(&r.image, "R")->pixels[i], 4.0 * PI, 1e-5);
    render_free(&r);
}
END_TEST

/* A level ray above the media leaves; one that runs level between boxes for ever ends the run. */
START_TEST(a_level_ray_that_never_leaves_is_reported) {
    static const char *const scene = "nephos: 1\ncamera: {type: orthographic, position: [0, 0, %s], direction: [0, 1, 0], resolution: [2, 2], extent: 1e-3}\n"
        "periodic: {x: [-1, 1], y: [-1, 1]}\nmedia:\n  - {box: [[0.5, -1, 0], [0.9, 1, 1]], extinction: 1}\nlights:\n  - {type: constant, radiance: 1}\n";
    RenderCase r;
    ck_assert_int_eq(try(&r, 16, 1, 32, render_text(scene, "1.5")), NPH_OK);
    ck_assert(nph_image_channel(&r.image, "R")->pixels[0] == 1.0f);
    render_free(&r);
    ck_assert_int_eq(try(&r, 16, 1, 32, render_text(scene, "0.5")), NPH_BAD_NUMBER);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "never leave"));
    render_free(&r);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, a_full_period_is_a_layer_without_end);
    tcase_add_test(cases, a_sun_that_crosses_many_periods_loses_the_same_light_everywhere);
    tcase_add_test(cases, a_periodic_checkerboard_is_the_middle_of_a_wide_one_path_by_path);
    tcase_add_test(cases, it_does_not_matter_where_the_period_begins);
    tcase_add_test(cases, a_periodic_white_furnace_is_white);
    tcase_add_test(cases, a_level_ray_that_never_leaves_is_reported);
}

int main(void) { return nph_test_main("periodic", fill); }
