/* SPDX-License-Identifier: Apache-2.0
 *
 * White furnace: albedo 1 and radiance 1 from everywhere give exactly 1 in every pixel, whatever the medium. Where the
 * estimator has no variance (grey media, constant light) every sample is 1 but for the rounding of its events. */
#include <float.h>
#include <math.h>
#include <stdio.h>

#include "harness.h"
#include "render_case.h"

static const char *const head = "nephos: 1\n"
                                "camera: {type: perspective, resolution: [24, 24], position: [%s], look_at: [%s], fov: 40}\n";
static const char *const constant = "lights:\n  - {type: constant, radiance: 1}\n";

static const char *const cube = "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 8, albedo: 1, phase: {type: hg, g: %g}}\n";
static const char *const overlap =
    "media:\n"
    "  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 5, albedo: 1, phase: {type: hg, g: 0.5}}\n"
    "  - {box: [[0.3, 0.2, 0.4], [1.5, 1.4, 1.2]], extinction: 9, albedo: 1, phase: {type: rayleigh},\n"
    "     transform: [{rotate: {axis: [1, 1, 0], angle: 30}}]}\n";
static const char *const chromatic =
    "media:\n"
    "  - {box: [[0, 0, 0], [1, 1, 1]], extinction: [2, 4, 7], albedo: 1, phase: {type: hg, g: 0.7}}\n"
    "  - {box: [[0.5, 0.5, 0.5], [1.2, 1.2, 1.2]], extinction: [6, 3, 0], albedo: 1}\n";
static const char *const cumulus =
    "media:\n"
    "  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: %s, albedo: 1, phase: {type: hg, g: 0.85}}\n";
static const char *const rico =
    "media:\n"
    "  - {density: {file: ../data/gpl/rico32x37x26.txt, centring: cell}, extinction: 1, albedo: 1, phase: {type: hg, g: 0.85}}\n";

/* No sample differs from 1 by more than the roundings: none for grey media. */
static void check_exact(const char *yaml, int precision) {
    RenderCase render;
    NphRenderOptions options = render_options(16, precision);
    render_case(&render, yaml, &options, 0);
    const NphChannel *r = nph_image_channel(&render.image, "R"), *v = nph_image_channel(&render.image, "Variance.R");
    for (int i = 0; i < 24 * 24; i++) {
        ck_assert_msg(r->pixels[i] == 1.0f, "pixel %d is %.9g", i, (double)r->pixels[i]);
        ck_assert(v->pixels[i] == 0.0f);
    }
    ck_assert_int_gt(render.statistics.collisions, 1000);
    printf("    %lld collisions, mean 1 exactly\n", (long long)render.statistics.collisions);
    render_free(&render);
}

/* Where there is variance: the comparator says `same` as 1 within 0.1%. */
static void check_verdict(const char *yaml, int64_t samples) {
    RenderCase render;
    NphComparison comparison;
    NphRenderOptions options = render_options(samples, 32);
    render_case(&render, yaml, &options, 0);
    NphVerdict verdict = render_verdict(&render, 1.0, 0.001, &comparison);
    printf("    R %.6f +- %.6f: %s (%s)\n", render_mean(&render, "R"), render_error(&render, "R"),
           nph_verdict_name(verdict), comparison.reason);
    ck_assert_msg(verdict == NPH_SAME, "%s: %s", nph_verdict_name(verdict), comparison.reason);
    render_free(&render);
}

START_TEST(grey_furnaces_have_no_variance_and_are_exactly_one) {
    static const double gs[] = {-0.9, 0.0, 0.9, 0.999};
    for (int i = 0; i < 4; i++)
        for (int precision = 32; precision <= 64; precision += 32)
            check_exact(render_text("%s%s%s", render_text(head, "-2, -1.5, 1.2", "0.5, 0.5, 0.5"), render_text(cube, gs[i]), constant),
                        precision);
}
END_TEST

START_TEST(overlapping_media_are_a_furnace) {
    check_exact(render_text("%s%s%s", render_text(head, "-2, -1.5, 1.2", "0.7, 0.6, 0.6"), overlap, constant), 32);
}
END_TEST

START_TEST(draine_and_tables_are_furnaces) {
    check_exact(render_text("%smedia:\n"
                            "  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 5, albedo: 1, phase: {type: draine, g: 0.9, alpha: 30}}\n"
                            "  - {box: [[0.3, 0.2, 0.4], [1.5, 1.4, 1.2]], extinction: 9, albedo: 1,\n"
                            "     phase: {type: tabulated, file: ../data/gpl/c1_phase.txt}}\n%s",
                            render_text(head, "-2, -1.5, 1.2", "0.7, 0.6, 0.6"), constant), 32);
}
END_TEST

START_TEST(a_furnace_seen_from_inside_is_one) {
    check_exact(render_text("%s%s%s", render_text(head, "0.5, 0.5, 0.5", "1, 0.6, 0.6"), render_text(cube, 0.5), constant), 32);
}
END_TEST

START_TEST(cumulus_and_rico_are_furnaces) {
    check_exact(render_text("%s%s%s", render_text(head, "-3, -2, 1", "0, 0, 0.4"), render_text(cumulus, "40"), constant), 32);
    check_exact(render_text("%s%s%s", render_text(head, "320, -1500, 900", "320, 370, 900"), rico, constant), 32);
}
END_TEST

static const char *write_white_map(void) {
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
    return path;
}

/* Both ways of finding the map's light, with the new densities; and beside a sun, which guides directions. */
START_TEST(a_white_map_around_a_tabulated_cloud_is_a_furnace) {
    if (!nph_test_statistics("furnace of a white map around a tabulated cloud")) return;
    const char *path = write_white_map();
    static const char *const phases[] = {"type: tabulated, file: ../data/gpl/c1_phase.txt", "type: draine, g: 0.8, alpha: 10"};
    for (int i = 0; i < 2; i++)
        check_verdict(render_text("%smedia:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 8, albedo: 1, phase: {%s}}\n"
                                  "lights:\n  - {type: environment, file: %s}\n"
                                  "  - {type: sun, direction: [1, 0.8, -0.3], irradiance: 1e-9}\n",
                                  render_text(head, "-2, -1.5, 1.2", "0.5, 0.5, 0.5"), phases[i], path), 4096);
}
END_TEST

START_TEST(chromatic_media_are_a_furnace) {
    if (!nph_test_statistics("chromatic furnace")) return;
    check_verdict(render_text("%s%s%s", render_text(head, "-2, -1.5, 1.2", "0.5, 0.5, 0.5"), chromatic, constant), 8192);
}
END_TEST

START_TEST(a_chromatic_cumulus_is_a_furnace) {
    if (!nph_test_statistics("chromatic cumulus furnace")) return;
    check_verdict(render_text("%s%s%s", render_text(head, "-3, -2, 1", "0, 0, 0.4"), render_text(cumulus, "[5, 5.5, 6]"), constant),
                  6144);
}
END_TEST

/* The same light as a map: every vertex samples it, and both ways of finding it must add up to one. */
START_TEST(a_white_map_found_by_light_samples_and_by_chance_is_a_furnace) {
    if (!nph_test_statistics("furnace of a white map")) return;
    const char *path = write_white_map();
    static const double gs[] = {-0.9, 0.0, 0.9};
    for (int i = 0; i < 3; i++)
        check_verdict(render_text("%s%slights:\n  - {type: environment, file: %s, rotation: 30}\n",
                                  render_text(head, "-2, -1.5, 1.2", "0.5, 0.5, 0.5"), render_text(cube, gs[i]), path), 8192);
}
END_TEST

/* A sun too faint to see draws directions towards itself: the map's weights must be against that mixture. */
START_TEST(a_white_map_beside_a_faint_sun_is_a_furnace) {
    if (!nph_test_statistics("furnace of a white map beside a sun")) return;
    const char *path = write_white_map();
    check_verdict(render_text("%s%slights:\n  - {type: environment, file: %s}\n"
                              "  - {type: sun, direction: [1, 0.8, -0.3], irradiance: 1e-9}\n",
                              render_text(head, "-2, -1.5, 1.2", "0.5, 0.5, 0.5"), render_text(cube, 0.5), path), 8192);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, grey_furnaces_have_no_variance_and_are_exactly_one);
    tcase_add_test(cases, overlapping_media_are_a_furnace);
    tcase_add_test(cases, draine_and_tables_are_furnaces);
    tcase_add_test(cases, a_furnace_seen_from_inside_is_one);
    tcase_add_test(cases, cumulus_and_rico_are_furnaces);
    tcase_add_test(cases, a_white_map_found_by_light_samples_and_by_chance_is_a_furnace);
    tcase_add_test(cases, a_white_map_beside_a_faint_sun_is_a_furnace);
    tcase_add_test(cases, a_white_map_around_a_tabulated_cloud_is_a_furnace);
    tcase_add_test(cases, chromatic_media_are_a_furnace);
    tcase_add_test(cases, a_chromatic_cumulus_is_a_furnace);
}

int main(void) { return nph_test_main("furnace", fill); }
