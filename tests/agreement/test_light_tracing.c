/* SPDX-License-Identifier: Apache-2.0
 *
 * Light tracing against the path tracer, which has the direction of transport and the connections the other way round,
 * and against published numbers that share nothing with either. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "harness.h"
#include "render_case.h"

typedef struct Pair {
    const char *title, *yaml;
    int photons;   /* of each of the light tracer's 128 images */
    int64_t path;  /* samples */
    double margin; /* of the image's mean, for `same` */
} Pair;

#define PINHOLE "camera: {resolution: [16, 16], position: [-1.5, -1.5, 0.9], look_at: [0.5, 0.5, 0.5], fov: 45}\n"
#define PARALLEL "camera: {type: orthographic, resolution: [16, 16], position: [-1.5, -1.5, 1.6], look_at: [0.5, 0.5, 0.5], extent: 2}\n"
#define FISHEYE "camera: {type: fisheye, resolution: [24, 24], position: [0.4, 0.5, -0.1], direction: [0, 0, 1], up: [0, 1, 0], fov: 180}\n"
#define FLUX "camera: {type: flux, resolution: [8, 8], position: [0.5, 0.4, 1.1], direction: [0, 0, -1], up: [0, 1, 0], extent: 1.5}\n"
#define FLUX_INSIDE "camera: {type: flux, resolution: [8, 8], position: [0.5, 0.5, 0.4], direction: [0.3, 0, 1], up: [0, 1, 0], extent: 0.6}\n"
#define FLUENCE "camera: {type: fluence, resolution: [8, 8], position: [0.5, 0.5, 0.6], direction: [0, 0, -1], up: [0, 1, 0], extent: 1.5}\n"
#define RADIANCE "camera: {type: radiance, resolution: [8, 8], position: [0.5, 0.5, 0.6], direction: [0, 0, -1], up: [0, 1, 0], seen: [0.6, 0, -0.8], extent: 1.5}\n"
#define GREY "{box: [[0, 0, 0], [1, 1, 1]], extinction: 4, albedo: 0.9, phase: {type: hg, g: 0.5}}"
#define COLOURED "{box: [[0, 0, 0], [1, 1, 1]], extinction: [1, 4, 9], albedo: [0.99, 0.9, 0.7], phase: {type: hg, g: 0.5}}"
#define LAYER "{layer: [0, 1], extinction: 2, albedo: 0.9, phase: {type: hg, g: 0.5}}"
#define SUN "  - {type: sun, direction: [-1, -0.2, 0.5], irradiance: 3}\n"
#define DISC "  - {type: sun, direction: [-1, -0.2, 0.5], irradiance: 3, angular_diameter: 40}\n"
#define SKY "  - {type: constant, radiance: [0.3, 0.5, 1]}\n"
#define POINT "  - {type: point, position: [0.5, 0.3, 1.5], intensity: [1, 0.8, 0.5]}\n"
#define GROUND "surfaces:\n  - {name: ground, plane: -0.2, albedo: [0.5, 0.4, 0.3]}\n"
#define PERIODIC "periodic: {x: [-0.2, 1], y: [0, 1.7]}\n"

static const Pair pairs[] = {
    {"cube, g 0.7, sun", "nephos: 1\n" PINHOLE "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 4, albedo: 1, phase: "
     "{type: hg, g: 0.7}}\nlights:\n" SUN, 3000, 2048, 0.05},
    {"colours, three lights", "nephos: 1\n" PINHOLE "media:\n  - " COLOURED "\nlights:\n" SUN SKY POINT, 600, 512, 0.02},
    {"parallel rays", "nephos: 1\n" PARALLEL "media:\n  - " COLOURED "\nlights:\n" DISC SKY, 600, 512, 0.02},
    {"fisheye", "nephos: 1\n" FISHEYE "media:\n  - " GREY "\nlights:\n" SUN SKY, 2000, 512, 0.03},
    {"flux", "nephos: 1\n" FLUX "media:\n  - " COLOURED "\nlights:\n" DISC SKY POINT, 6000, 8192, 0.12},
    {"flux inside", "nephos: 1\n" FLUX_INSIDE "media:\n  - " GREY "\nlights:\n" SUN SKY, 5000, 2048, 0.03},
    {"fluence", "nephos: 1\n" FLUENCE "media:\n  - " COLOURED "\nlights:\n" SUN SKY, 600, 2048, 0.03},
    {"radiance inside", "nephos: 1\n" RADIANCE "media:\n  - " GREY "\nlights:\n" SUN SKY, 600, 2048, 0.03},
    {"ground, two media", "nephos: 1\n" PINHOLE "media:\n  - " GREY "\n  - {box: [[0.5, 0.5, 0], [1.5, 1.5, 0.5]], extinction: "
     "[2, 1, 0], albedo: 0.7, phase: {type: rayleigh}}\nlights:\n" SUN SKY GROUND, 3000, 1024, 0.03},
    {"flux over ground", "nephos: 1\n" FLUX "media:\n  - " GREY "\nlights:\n" SUN SKY POINT GROUND, 8000, 1024, 0.1},
    {"layer, parallel rays", "nephos: 1\n" PARALLEL "media:\n  - " LAYER "\nlights:\n" SUN SKY, 5000, 1024, 0.05},
    {"layer, pinhole", "nephos: 1\ncamera: {resolution: [16, 16], position: [-1.5, -1.5, 2.5], look_at: [0.5, 0.5, 0.5], fov: 45}\n"
     "media:\n  - " LAYER "\n  - " GREY "\nlights:\n" SUN, 4000, 1024, 0.06},
    {"layer, fluence", "nephos: 1\n" FLUENCE "media:\n  - " LAYER "\nlights:\n" SUN SKY, 1000, 1024, 0.03},
    {"sides that repeat, flux", "nephos: 1\n" FLUX PERIODIC "media:\n  - " COLOURED "\nlights:\n" SUN SKY GROUND, 4000, 1024, 0.05},
    {"sides that repeat, parallel rays", "nephos: 1\ncamera: {type: orthographic, resolution: [16, 16], position: [0.7, 0.6, 3], "
     "direction: [0.3, 0.2, -1], up: [0, 1, 0], extent: 1.5}\n" PERIODIC "media:\n  - " GREY "\nlights:\n" SUN SKY GROUND, 2000, 1024, 0.03},
    {"light of media", "nephos: 1\n" PINHOLE "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: [1, 4, 3], albedo: 0.9, "
     "emission: {type: volume, radiance: [1, 2, 0.5]}}\n" GROUND, 1000, 512, 0.03},
};
enum { PAIRS = sizeof pairs / sizeof *pairs };

/* The comparator's verdict on the image; tiles may be noisy, not different. */
static void check_same(const RenderCase *light, const RenderCase *path, double margin, const char *title) {
    NphCompareOptions options;
    NphComparison comparison;
    nph_compare_options_default(&options);
    options.margin_image = margin;
    options.margin_tile = 10.0 * margin;
    options.allow_noisy_tiles = 1;
    NphStatus status = nph_compare(light->context, &light->image, &path->image, &options, &comparison, NULL);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    printf("    %-34s %10.6g %10.6g  %+.2f%% +- %.2f%%\n", title, comparison.mean_a[0], comparison.mean_b[0],
           100.0 * comparison.difference[0], 100.0 * comparison.standard_error[0]);
    fflush(stdout);
    ck_assert_msg(comparison.verdict == NPH_SAME, "%s: %s: %s", title, nph_verdict_name(comparison.verdict),
                  comparison.reason);
}

START_TEST(light_and_path_are_the_same) {
    if (!nph_test_statistics("light against path")) return;
    const Pair *pair = &pairs[_i];
    RenderCase light, path;
    NphRenderOptions options = render_options(128, 32);
    const char *knobs[1] = {render_text("light.photons=%d", pair->photons)};
    options.method = "light";
    options.knobs = knobs;
    options.knob_count = 1;
    render_case(&light, pair->yaml, &options, 0);
    options = render_options(pair->path, 32);
    render_case(&path, pair->yaml, &options, 0);
    check_same(&light, &path, pair->margin, pair->title);
    render_free(&light);
    render_free(&path);
}
END_TEST

static void render_light(RenderCase *render, const char *yaml, int64_t samples, const char *const *knobs, int knob_count) {
    NphRenderOptions options = render_options(samples, 32);
    options.method = "light";
    options.knobs = knobs;
    options.knob_count = knob_count;
    render_case(render, yaml, &options, 0);
}

static const char *slab_scene(double g, double albedo, double depth, double mu0, int below) {
    double elevation = asin(mu0) * 180.0 / 3.14159265358979323846;
    return render_text("nephos: 1\n"
                       "camera: {type: flux, resolution: [1, 1], position: [0, 0, %s], direction: [0, 0, %d], up: [0, 1, 0], "
                       "extent: 1}\n"
                       "media:\n  - {layer: [0, 1], extinction: %.17g, albedo: %.17g, phase: {type: hg, g: %.17g}}\n"
                       "lights:\n  - {type: sun, elevation: %.17g, azimuth: 0, irradiance: %.17g}\n",
                       below ? "-0.001" : "1.001", below ? 1 : -1, depth, albedo, g, elevation, 1.0 / mu0);
}

/* R and T of a row of reference/tables/slab_fluxes.csv. */
static void find_slab(double g, double albedo, double depth, double mu0, double fluxes[2]) {
    FILE *file = fopen(nph_test_path("reference/tables/slab_fluxes.csv"), "r");
    ck_assert_ptr_nonnull(file);
    char line[2048], light[32];
    int found = 0;
    while (fgets(line, sizeof line, file)) {
        double v[8];
        if (sscanf(line, "%lf,%lf,%lf,%31[^,],%lf,%lf,%lf,%lf,%lf", &v[0], &v[1], &v[2], light, &v[3], &v[4], &v[5], &v[6],
                   &v[7]) != 9 || strcmp(light, "beam") != 0)
            continue;
        if (v[0] != g || v[1] != albedo || v[2] != depth || v[3] != mu0) continue;
        fluxes[0] = v[4];
        fluxes[1] = v[7];
        found = 1;
    }
    fclose(file);
    ck_assert_msg(found, "no slab g %g albedo %g depth %g mu0 %g in the table", g, albedo, depth, mu0);
}

typedef struct Slab {
    double g, albedo, depth, mu0;
    int below;
    const char *knob;
    int64_t samples;
    double error; /* the standard error that these samples give, at most */
} Slab;

static const Slab slabs[] = {
    {0, 1, 1, 0.5, 0, "light.count=0", 64, 0.005},      {0, 1, 1, 0.5, 1, "light.count=0", 64, 0.005},
    {0, 1, 1, 0.5, 1, "light.count=1", 64, 0.005},      {0, 0.999, 2, 0.5, 0, "light.count=1", 64, 0.005},
    {0, 1, 8, 1, 0, "light.split=0", 64, 0.005},        {0, 1, 8, 1, 1, "light.split=0", 64, 0.015},
    {0, 0.99, 64, 1, 1, "light.split=1", 64, 0.05},     {0, 0.8, 32, 0.5, 1, "light.split=1", 128, 0.15},
    {0.75, 0.9, 32, 0.5, 1, "light.split=1", 128, 0.05}, {0.85, 0.8, 32, 0.5, 1, "light.split=1", 128, 0.05},
    {0.9, 0.8, 64, 0.5, 1, "light.split=1", 128, 0.05},
};
enum { SLABS = sizeof slabs / sizeof *slabs };

/* Deep transmissions down to 7e-11 among them; z of all within a Bonferroni bound at 1%. */
START_TEST(fluxes_of_slabs_match_discrete_ordinates_also_through_thick_ones) {
    if (!nph_test_statistics("light: slabs")) return;
    for (int k = 0; k < SLABS; k++) {
        const Slab *slab = &slabs[k];
        RenderCase render;
        double fluxes[2];
        const char *knobs[2] = {slab->knob, "light.photons=1000"};
        find_slab(slab->g, slab->albedo, slab->depth, slab->mu0, fluxes);
        render_light(&render, slab_scene(slab->g, slab->albedo, slab->depth, slab->mu0, slab->below), slab->samples, knobs, 2);
        double mean = render_mean(&render, "R"), error = render_error(&render, "R"), truth = fluxes[slab->below];
        printf("    g %-5g albedo %-6g depth %-3g mu0 %-4g %s %-14s table %.6e  ours %.6e +- %.2f%%  z %+.2f\n", slab->g,
               slab->albedo, slab->depth, slab->mu0, slab->below ? "T" : "R", slab->knob, truth, mean, 100.0 * error / truth,
               (mean - truth) / error);
        fflush(stdout);
        ck_assert_double_gt(error, 0.0);
        ck_assert_double_le(error, slab->error * truth);
        ck_assert_double_le(fabs(mean - truth) / error, 3.3); /* 0.01 / 11 two-sided */
        render_free(&render);
    }
}
END_TEST

/* Splitting leaves the mean, and makes what is deep less noisy. */
START_TEST(splitting_changes_no_mean_and_lowers_the_noise_of_what_is_deep) {
    if (!nph_test_statistics("light: splitting")) return;
    const char *scene = slab_scene(0.5, 0.9, 14, 1, 1);
    const char *off[2] = {"light.split=0", "light.photons=2000"}, *on[2] = {"light.split=1", "light.photons=2000"};
    RenderCase plain, split;
    render_light(&plain, scene, 256, off, 2);
    render_light(&split, scene, 256, on, 2);
    double a = render_mean(&plain, "R"), b = render_mean(&split, "R"), ea = render_error(&plain, "R"), eb = render_error(&split, "R");
    printf("    plain %.6g +- %.2g, split %.6g +- %.2g\n", a, ea, b, eb);
    ck_assert_double_le(fabs(a - b), 3.3 * sqrt(ea * ea + eb * eb));
    ck_assert_double_lt(eb, 0.6 * ea);
    render_free(&plain);
    render_free(&split);
}
END_TEST

/* The power of a point source of 1 W in a medium without end: the fluence at r by exact transport. The sensor is a square
 * of a tenth; its mean differs from the value in its middle by less than 0.1%. */
START_TEST(fluence_around_a_point_light_inside_a_medium_is_that_of_exact_transport) {
    if (!nph_test_statistics("light: point light inside a medium")) return;
    static const struct {
        double albedo, r, fluence;
    } rows[] = {{0.5, 1, 0.058695137513}, {0.8, 1, 0.10741258975}, {0.9, 0.5, 0.48283269187}};
    const char *knobs[1] = {"light.photons=3000"};
    for (int k = 0; k < 3; k++) {
        RenderCase render;
        double size = 15;
        const char *yaml = render_text(
            "nephos: 1\ncamera: {type: fluence, resolution: [1, 1], position: [%.17g, 0, 0], direction: [1, 0, 0], up: [0, 0, 1], "
            "extent: 0.1}\nmedia:\n  - {box: [[-%g, -%g, -%g], [%g, %g, %g]], extinction: 1, albedo: %.17g}\n"
            "lights:\n  - {type: point, position: [0, 0, 0], intensity: 0.079577471545947668}\n",
            rows[k].r, size, size, size, size, size, size, rows[k].albedo);
        render_light(&render, yaml, 256, knobs, 1);
        double mean = render_mean(&render, "R"), error = render_error(&render, "R");
        printf("    albedo %g at %g: exact %.6g, ours %.6g +- %.2g, z %+.2f\n", rows[k].albedo, rows[k].r, rows[k].fluence, mean,
               error, (mean - rows[k].fluence) / error);
        fflush(stdout);
        ck_assert_double_le(error, 0.03 * rows[k].fluence);
        ck_assert_double_le(fabs(mean - rows[k].fluence), 3.0 * error + 0.001 * rows[k].fluence);
        render_free(&render);
    }
}
END_TEST

/* Outgoing flux through the six sides of a cube, each seen by a sensor that looks at it from a little outside. */
static double outgoing(double albedo, double *variance) {
    static const char *const sides[6] = {
        "position: [0.5, 0.5, 1.00001], direction: [0, 0, -1], up: [0, 1, 0]", "position: [0.5, 0.5, -0.00001], direction: [0, 0, 1], up: [0, 1, 0]",
        "position: [0.5, 1.00001, 0.5], direction: [0, -1, 0], up: [0, 0, 1]", "position: [0.5, -0.00001, 0.5], direction: [0, 1, 0], up: [0, 0, 1]",
        "position: [1.00001, 0.5, 0.5], direction: [-1, 0, 0], up: [0, 0, 1]", "position: [-0.00001, 0.5, 0.5], direction: [1, 0, 0], up: [0, 0, 1]"};
    const char *knobs[1] = {"light.photons=2000"};
    double sum = 0.0;
    *variance = 0.0;
    for (int k = 0; k < 6; k++) {
        RenderCase render;
        render_light(&render, render_text("nephos: 1\ncamera: {type: flux, resolution: [1, 1], %s, extent: 1.00002}\n"
                                          "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 4, albedo: %.17g, phase: {type: hg, g: 0.6}}\n"
                                          "lights:\n  - {type: sun, direction: [0, 0, 1], irradiance: 2}\n", sides[k], albedo),
                     128, knobs, 1);
        double error = render_error(&render, "R");
        sum += render_mean(&render, "R");
        *variance += error * error;
        render_free(&render);
    }
    return sum;
}

START_TEST(what_enters_a_cube_without_absorption_leaves_it_and_less_with_it) {
    if (!nph_test_statistics("light: energy")) return;
    double variance, out = outgoing(1.0, &variance);
    printf("    incident 2 W, outgoing %.5f +- %.5f W\n", out, sqrt(variance));
    ck_assert_double_le(sqrt(variance), 0.01);
    ck_assert_double_le(fabs(out - 2.0), 3.3 * sqrt(variance));
    out = outgoing(0.9, &variance);
    printf("    albedo 0.9: outgoing %.5f W\n", out);
    ck_assert_double_lt(out + 3.0 * sqrt(variance), 1.9);
    ck_assert_double_gt(out, 0.5);
}
END_TEST

/* Albedo 1 in light from everywhere: radiance 1, whatever the medium. */
START_TEST(a_furnace_is_white) {
    if (!nph_test_statistics("light: furnace")) return;
    RenderCase render;
    NphComparison comparison;
    render_light(&render, "nephos: 1\n" PINHOLE "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: [1, 4, 9], albedo: 1, phase: {type: "
                          "hg, g: 0.8}}\nlights:\n  - {type: constant, radiance: 1}\n", 512, NULL, 0);
    NphVerdict verdict = render_verdict(&render, 1.0, 0.005, &comparison);
    printf("    %s: %s\n", nph_verdict_name(verdict), comparison.reason);
    ck_assert_int_ne(verdict, NPH_NOT_SAME);
    ck_assert_double_le(fabs(render_mean(&render, "R") - 1.0), 3.5 * render_error(&render, "R"));
    ck_assert_double_le(render_error(&render, "R"), 0.003);
    render_free(&render);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_loop_test(cases, light_and_path_are_the_same, 0, PAIRS);
    tcase_add_test(cases, fluxes_of_slabs_match_discrete_ordinates_also_through_thick_ones);
    tcase_add_test(cases, splitting_changes_no_mean_and_lowers_the_noise_of_what_is_deep);
    tcase_add_test(cases, fluence_around_a_point_light_inside_a_medium_is_that_of_exact_transport);
    tcase_add_test(cases, what_enters_a_cube_without_absorption_leaves_it_and_less_with_it);
    tcase_add_test(cases, a_furnace_is_white);
}

int main(void) { return nph_test_main("light_tracing", fill); }
