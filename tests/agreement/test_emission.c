/* SPDX-License-Identifier: Apache-2.0
 *
 * Media with light of their own against closed forms: slabs, columns without extinction, cavities of one temperature
 * (Kirchhoff's law), the power of what absorbs nothing. */
#include <math.h>
#include <stdio.h>

#include "harness.h"
#include "io/volume.h"
#include "optics/blackbody.h"
#include "render_case.h"

/* Straight down through the unit cube: every ray has length 1 in it. */
static const char *const down = "nephos: 1\n"
                                "camera: {type: orthographic, resolution: [16, 16], position: [0.5, 0.5, 3], look_at: [0.5, 0.5, 0],\n"
                                "         up: [0, 1, 0], extent: 0.9}\n";
static const char *const askew = "nephos: 1\n"
                                 "camera: {resolution: [16, 16], position: [-1.5, -1, 2], look_at: [0.5, 0.5, 0.5], fov: 30}\n";

/* 6 x 5 x 7 (x, y, z) cells: first + step * z, in the unit cube, constant beyond its sides. Text is the caller's. */
static const char *volume(double first, double step, const char *name, char text[400]) {
    const char *path = nph_test_temporary(name);
    NphContext *context = nph_test_context(1);
    NphArray array = {0};
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 3, (int64_t[]){7, 5, 6}, "test", &array), NPH_OK);
    for (int i = 0; i < 210; i++) ((float *)array.data)[i] = (float)(first + step * (i / 30));
    ck_assert_int_eq(nph_npy_write(context, path, &array), NPH_OK);
    nph_array_free(context, &array);
    nph_test_context_close(context);
    snprintf(text, 400, "file: %s, box: [[0, 0, 0], [1, 1, 1]], outside: clamp", path);
    return text;
}

/* The picture's means are these, within 4.4 standard errors (one false alarm in 1e5), which are at most `most` of them. */
static void check_means(const char *text, int64_t samples, int precision, const double right[3], double most) {
    static const char *const names[] = {"R", "G", "B"};
    RenderCase render;
    char yaml[4096];
    NphRenderOptions options = render_options(samples, precision);
    snprintf(yaml, sizeof yaml, "%s", text);
    render_case(&render, yaml, &options, 0);
    for (int c = 0; c < 3; c++) {
        double mean = render_mean(&render, names[c]), error = render_error(&render, names[c]);
        printf("    %s %.7g +- %.2g, %.7g\n", names[c], mean, error, right[c]);
        double rounding = (precision == 32 ? 3e-6 : 1e-7) * right[c];
        ck_assert_msg(fabs(mean - right[c]) <= 4.4 * error + rounding, "%s", yaml);
        ck_assert_msg(error <= most * right[c], "error %g of %g", error, right[c]);
    }
    ck_assert_int_eq(render.statistics.majorant_violations, 0);
    render_free(&render);
}

static double slab(double j, double sigma, double length) { return sigma > 0 ? j * -expm1(-sigma * length) / sigma : j * length; }

START_TEST(an_absorbing_slab_that_emits_is_its_closed_form_exactly) {
    const double sigma[3] = {0.5, 3, 40};
    double right[3];
    for (int c = 0; c < 3; c++) right[c] = slab(1 + c, sigma[c], 1);
    for (int precision = 32; precision <= 64; precision += 32) {
        check_means(render_text("%s%s", down, "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: [0.5, 3, 40], albedo: 0, "
                                "emission: {type: volume, radiance: [1, 2, 3]}}\n"), 16, precision, right, 1e-7);
        check_means(render_text("%s%s", down, "media:\n  - {layer: [0.25, 1.25], extinction: [0.5, 3, 40], albedo: 0, "
                                "emission: {type: volume, radiance: [1, 2, 3]}}\n"), 16, precision, right, 1e-7);
    }
}
END_TEST

/* Two media in one place, so that no closed form is taken: collisions end flights, channels differ or not. */
START_TEST(what_emits_between_others_is_the_closed_form_in_the_mean) {
    if (!nph_test_statistics("emission among media")) return;
    static const char *const greys = "media:\n"
        "  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 1, albedo: 0, emission: {type: volume, radiance: [1, 2, 3]}}\n"
        "  - {box: [[-1, -1, 0], [2, 2, 1]], extinction: 2, albedo: 0}\n";
    static const char *const colours = "media:\n"
        "  - {box: [[0, 0, 0], [1, 1, 1]], extinction: [0, 1, 2], albedo: 0, emission: {type: volume, radiance: [1, 2, 3]}}\n"
        "  - {box: [[-1, -1, 0], [2, 2, 1]], extinction: [0.5, 0, 6], albedo: 0}\n"
        "  - {density: {%s}, extinction: [2, 0.5, 0], albedo: 0}\n";
    char one[400];
    double right[3], coloured[3];
    const double sigma[3] = {2.5, 1.5, 8};
    for (int c = 0; c < 3; c++) {
        right[c] = slab(1 + c, 3, 1);
        coloured[c] = slab(1 + c, sigma[c], 1);
    }
    check_means(render_text("%s%s", down, greys), 1024, 32, right, 2e-3);
    check_means(render_text("%s%s", down, render_text(colours, volume(1, 0, "one.npy", one))), 2048, 32, coloured, 3e-3);
}
END_TEST

START_TEST(a_grid_that_emits_is_the_box_of_the_same_values) {
    if (!nph_test_statistics("emission of grids")) return;
    const double sigma[3] = {0.5, 3, 12};
    double grey[3], right[3];
    for (int c = 0; c < 3; c++) {
        right[c] = slab(1 + c, sigma[c], 1);
        grey[c] = slab(1 + c, 3, 1);
    }
    char text[400];
    const char *one = volume(1, 0, "one.npy", text);
    for (int precision = 32; precision <= 64; precision += 32) {
        check_means(render_text("%smedia:\n  - {density: {%s}, extinction: 3, albedo: 0, emission: {type: volume, "
                                "radiance: [1, 2, 3]}}\n", down, one), 1024, precision, grey, 4e-3);
        check_means(render_text("%smedia:\n  - {density: {%s}, extinction: [0.5, 3, 12], albedo: 0, emission: {type: volume, "
                                "radiance: [1, 2, 3], volume: {%s}}}\n", down, one, one), 1024, precision, right, 9e-3);
    }
}
END_TEST

/* Without extinction the picture is the integral of j: here of a ramp, 2 + 3 z at cell z, trilinear and clamped at the
 * ends, whose mean is that of its cells, along z; a flame apart from the density too. */
START_TEST(without_extinction_a_picture_is_the_integral_of_the_emission) {
    if (!nph_test_statistics("emission without extinction")) return;
    const double right[3] = {11, 0, 22};
    char text[400];
    const char *ramp = volume(2, 3, "ramp.npy", text);
    check_means(render_text("%smedia:\n  - {density: {%s}, extinction: 0, emission: {type: volume, radiance: [1, 0, 2]}}\n",
                            down, ramp), 256, 32, right, 5e-3);
    check_means(render_text("%smedia:\n  - {box: [[5, 5, 5], [6, 6, 6]], extinction: 1, albedo: 0, emission: {type: volume, "
                            "radiance: [1, 0, 2], volume: {%s}}}\n", down, ramp), 256, 64, right, 5e-3);
}
END_TEST

/* Cut to a period of 1 / 2 and repeated, a cube of constant emission is a layer of it: 1 / cos long along any ray. */
START_TEST(what_repeats_emits_again_and_again) {
    if (!nph_test_statistics("emission between sides that repeat")) return;
    char text[400];
    const char *one = volume(1, 0, "one.npy", text);
    static const char *const slant = "nephos: 1\nperiodic: {x: [0.25, 0.75], y: [0, 1]}\n"
        "camera: {type: orthographic, resolution: [16, 16], position: [3, 0, 5], direction: [-3, 0, -4], up: [0, 1, 0], extent: 1}\n";
    double right[3];
    for (int c = 0; c < 3; c++) right[c] = slab(1 + c, 1 + c, 1.25);
    check_means(render_text("%smedia:\n  - {density: {%s}, extinction: [1, 2, 3], albedo: 0, emission: {type: volume, "
                            "radiance: [1, 2, 3]}}\n", slant, one), 1024, 32, right, 5e-3);
    for (int c = 0; c < 3; c++) right[c] = 1.25 * (1 + c);
    check_means(render_text("%smedia:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 0, emission: {type: volume, radiance: [1, 2, 3]}}\n",
                            slant), 16, 64, right, 1e-6);
}
END_TEST

/* Kirchhoff: a medium of the temperature of the cavity around it cannot be seen, however it absorbs and scatters. */
START_TEST(in_a_cavity_of_its_own_temperature_nothing_is_seen) {
    if (!nph_test_statistics("Kirchhoff's law")) return;
    static const char *const media[] = {
        "box: [[0, 0, 0], [1, 1, 1]], extinction: 3, albedo: 0.6, phase: {type: hg, g: 0.5}, emission: {type: blackbody, temperature: 4000}",
        "box: [[0, 0, 0], [1, 1, 1]], extinction: [1, 3, 9], albedo: [0.9, 0.5, 0], emission: {type: blackbody, temperature: 4000}",
        "density: {%s}, extinction: 1, albedo: 0.6, emission: {type: blackbody, temperature: 4000}",
        "density: {%s}, extinction: 1, albedo: 0, emission: {type: blackbody, scale: 0, offset: 4000, volume: {%s}}",
        "density: {%s}, extinction: [0.5, 1, 2], albedo: [0.2, 0.9, 0.5], phase: {type: rayleigh}, emission: {type: blackbody, scale: 0, offset: 4000, volume: {%s}}"};
    static NphPlanckTable table;
    double B[3];
    nph_planck_table(&table);
    nph_planck_rgb(&table, 4000, B);
    char text[400];
    const char *ramp = volume(0.5, 0.75, "rho.npy", text);
    for (int i = 0; i < 5; i++) {
        const char *medium = render_text(media[i], ramp, ramp);
        check_means(render_text("%smedia:\n  - {%s}\nlights:\n  - {type: constant, radiance: [%.17g, %.17g, %.17g]}\n", askew,
                                medium, B[0], B[1], B[2]), 1024, i == 0 ? 64 : 32, B, 5e-3);
    }
}
END_TEST

/* Nothing absorbs, so all that is emitted leaves: 4 pi j d per area of a layer, half of it upwards, however thick. */
START_TEST(a_layer_that_only_scatters_gives_off_what_it_emits) {
    if (!nph_test_statistics("power of a layer")) return;
    const double right[3] = {2 * 3.14159265358979323846 * 0.5, 2 * 3.14159265358979323846, 0};
    check_means("nephos: 1\ncamera: {type: flux, resolution: [16, 16], position: [0, 0, 1.5], direction: [0, 0, -1], up: [0, 1, 0], extent: 1}\n"
                "media:\n  - {layer: [0, 1], extinction: 4, albedo: 1, phase: {type: hg, g: 0.4}, emission: {type: volume, radiance: [0.5, 1, 0]}}\n",
                512, 32, right, 6e-3);
}
END_TEST

/* Two estimators that share nothing but the places where the emission is looked up. */
START_TEST(light_followed_from_where_it_is_emitted_makes_the_same_picture) {
    if (!nph_test_statistics("emission of path and light")) return;
    const char *yaml = render_text(
        "%smedia:\n  - {density: {file: ../data/vdb/plume32_f20_BLOSC_float32.vdb}, extinction: [5, 10, 15], albedo: [0.8, 0.5, 0.3],\n"
        "     transform: [{scale: 0.4}], emission: {type: blackbody, scale: 2500}}\n"
        "  - {box: [[0, 0, 0], [1, 1, 0.3]], extinction: 2, albedo: 0.9, emission: {type: volume, radiance: [10, 5, 1]}}\n", askew);
    RenderCase a, b;
    NphRenderOptions options = render_options(1536, 32);
    render_case(&a, yaml, &options, 0);
    options.method = "light";
    options.seed_given = 1;
    options.seed = 5;
    render_case(&b, yaml, &options, 0);
    for (int c = 0; c < 3; c++) {
        const char *name = (const char *[]){"R", "G", "B"}[c];
        double both = hypot(render_error(&a, name), render_error(&b, name)), off = render_mean(&a, name) - render_mean(&b, name);
        printf("    %s %.5g, light %.5g: z %+.2f\n", name, render_mean(&a, name), render_mean(&b, name), off / both);
        ck_assert(fabs(off) < 4.4 * both && both < 0.015 * render_mean(&a, name));
    }
    render_free(&a);
    render_free(&b);
}
END_TEST

/* However many events. */
START_TEST(the_number_of_events_changes_no_mean) {
    if (!nph_test_statistics("emission events")) return;
    static const char *const few[] = {"path.emission_events=0.2"}, *const many[] = {"path.emission_events=20"};
    const char *yaml = render_text("%smedia:\n  - {density: {file: ../data/vdb/plume32_f20_BLOSC_float32.vdb}, extinction: [10, 20, 40], "
                                   "albedo: [0.8, 0.5, 0.3], transform: [{scale: 0.4}], emission: {type: blackbody, scale: 2500}}\n", askew);
    RenderCase a, b;
    NphRenderOptions options = render_options(1024, 32);
    options.knobs = few;
    options.knob_count = 1;
    render_case(&a, yaml, &options, 0);
    options.samples = 256;
    options.knobs = many;
    options.seed = 7;
    options.seed_given = 1;
    render_case(&b, yaml, &options, 0);
    for (int c = 0; c < 3; c++) {
        const char *name = (const char *[]){"R", "G", "B"}[c];
        double ea = render_error(&a, name), eb = render_error(&b, name), off = render_mean(&a, name) - render_mean(&b, name);
        printf("    %s %.5g +- %.2g, %.5g +- %.2g\n", name, render_mean(&a, name), ea, render_mean(&b, name), eb);
        ck_assert(fabs(off) < 4.4 * sqrt(ea * ea + eb * eb) && eb < 0.03 * render_mean(&b, name));
        ck_assert(render_mean(&a, name) > 0);
    }
    render_free(&a);
    render_free(&b);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, an_absorbing_slab_that_emits_is_its_closed_form_exactly);
    tcase_add_test(cases, what_emits_between_others_is_the_closed_form_in_the_mean);
    tcase_add_test(cases, a_grid_that_emits_is_the_box_of_the_same_values);
    tcase_add_test(cases, without_extinction_a_picture_is_the_integral_of_the_emission);
    tcase_add_test(cases, what_repeats_emits_again_and_again);
    tcase_add_test(cases, in_a_cavity_of_its_own_temperature_nothing_is_seen);
    tcase_add_test(cases, a_layer_that_only_scatters_gives_off_what_it_emits);
    tcase_add_test(cases, light_followed_from_where_it_is_emitted_makes_the_same_picture);
    tcase_add_test(cases, the_number_of_events_changes_no_mean);
}

int main(void) { return nph_test_main("emission", fill); }
