/* SPDX-License-Identifier: Apache-2.0
 *
 * The quadrature of single scattering against the path tracer at an albedo of 1e-4, where what is scattered twice is a
 * ten thousandth of what is scattered once. They share the scene and the camera rays and nothing else. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "harness.h"
#include "render_case.h"

#define VIEW "nephos: 1\ncamera: {type: perspective, resolution: [32, 32], position: [-1.5, -1.5, 0.8], look_at: [0.5, 0.5, 0.5], fov: 35}\n"
#define CLOUD "  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: 12, albedo: 1e-4, phase: {type: hg, g: 0.5},\n" \
              "     transform: [{scale: 0.4}, {rotate: {axis: [1, 2, 3], angle: 40}}, {translate: [0.5, 0.4, 0.5]}]}\n"

typedef struct Pair {
    const char *what, *yaml;
    int64_t samples, rays; /* of path, of single */
} Pair;

static const Pair pairs[] = {
    {"cube and sun", VIEW
     "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 4, albedo: 1e-4, phase: {type: hg, g: 0.7}}\n"
     "lights:\n  - {type: sun, direction: [-1, 0.2, 0.3], irradiance: 3}\n", 256, 32},
    {"cloud and sun", VIEW "media:\n" CLOUD "lights:\n  - {type: sun, direction: [-1, 0.5, 0.6], irradiance: 3}\n", 512, 32},
    {"chromatic media that overlap, a sun with a disc", VIEW
     "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: [3, 2, 1], albedo: [1e-4, 5e-5, 1e-4], phase: {type: rayleigh}}\n" CLOUD
     "lights:\n  - {type: sun, direction: [1, -0.8, 1], irradiance: [3, 2, 1], angular_diameter: 20}\n", 512, 32},
    {"a point light beside the media", VIEW "media:\n" CLOUD
     "lights:\n  - {type: point, position: [0.2, -0.6, 1.2], intensity: [1, 2, 3]}\n", 512, 32},
    /* the sky of the upper half is not seen by a camera that looks down */
    {"light from half the sky", "nephos: 1\ncamera: {type: perspective, resolution: [32, 32], position: [0.5, 0.3, 4], look_at: [0.5, 0.5, 0.5], fov: 25, up: [0, 1, 0]}\n"
     "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 3, albedo: 1e-4, phase: {type: hg, g: -0.6}}\n"
     "lights:\n  - {type: constant, radiance: 1, hemisphere: upper}\n", 512, 32},
    {"a flux sensor under a box, off its side", "nephos: 1\ncamera: {type: flux, resolution: [32, 32], position: [0.5, 0.5, -0.7], direction: [0, 0, 1], up: [0, 1, 0], extent: 2}\n"
     "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 3, albedo: 1e-4}\n"
     "lights:\n  - {type: sun, direction: [0.6, 0.2, 1], irradiance: 2}\n  - {type: point, position: [0, 0, 2], intensity: 3}\n", 512, 32},
    {"fluence within a glowing cloud whose sides repeat", "nephos: 1\ncamera: {type: fluence, resolution: [8, 8], position: [0.5, 0.5, 0.5], direction: [0, 0, 1], up: [0, 1, 0], extent: 1}\n"
     "periodic: {x: [0, 1], y: [0, 1]}\nmedia:\n" CLOUD
     "  - {box: [[0.2, 0.2, 0], [0.7, 0.9, 0.8]], extinction: [1, 2, 3], albedo: 1e-4, emission: {type: volume, radiance: [0.01, 0.02, 0.01]}}\n"
     "lights:\n  - {type: sun, direction: [0.6, 0.2, 1], irradiance: 2}\n  - {type: constant, radiance: [0.1, 0.2, 0.3]}\n", 512, 64},
    {"a mesh over a plane, shadows through the medium", VIEW
     "media:\n  - {box: [[-0.5, -0.5, 0], [1.5, 1.5, 1]], extinction: 1.2, albedo: 1e-4, phase: {type: hg, g: 0.3}}\n"
     "surfaces:\n  - {plane: -0.2, albedo: 2e-4}\n"
     "  - {mesh: ../data/mesh/suzanne.obj, albedo: [1e-4, 2e-4, 3e-4], transform: [{scale: 0.3}, {translate: [0.5, 0.5, 0.6]}]}\n"
     "lights:\n  - {type: sun, direction: [-0.6, 0.5, 1], irradiance: 3}\n  - {type: point, position: [0.5, -0.3, 1.3], intensity: 1}\n", 512, 32},
};

START_TEST(path_at_low_albedo_is_the_quadrature) {
    const Pair *pair = &pairs[_i];
    if (!nph_test_statistics(pair->what)) return;
    static const char *const channels[] = {"R", "G", "B"};
    RenderCase path, single;
    NphComparison comparison;
    NphCompareOptions margins;
    NphRenderOptions options = render_options(pair->samples, 32);
    /* roulette and the chance of a light sample look at throughputs, which are small here */
    options.knobs = (const char *[]){"path.roulette=0", "path.least_light=0"};
    options.knob_count = 2;
    render_case(&path, pair->yaml, &options, 0);
    options = render_options(pair->rays, 64);
    options.method = "single";
    options.seed_given = 1;
    options.seed = 77;
    render_case(&single, pair->yaml, &options, 0);
    ck_assert_int_eq(single.statistics.unconverged, 0);
    for (int c = 0; c < 3; c++) {
        double one = render_mean(&path, channels[c]), other = render_mean(&single, channels[c]);
        double error = hypot(render_error(&path, channels[c]), render_error(&single, channels[c]));
        printf("    %s, %s: path %.6g, single %.6g, %+.2f%% +- %.2f%%\n", pair->what, channels[c], one, other,
               100.0 * (other / one - 1.0), 100.0 * error / one);
        fflush(stdout);
        ck_assert_double_gt(other, 0.0);
        ck_assert_double_le(error, 0.015 * one);
        ck_assert_double_le(fabs(one - other), 4.0 * error);
    }
    nph_compare_options_default(&margins);
    ck_assert_int_eq(nph_compare(path.context, &path.image, &single.image, &margins, &comparison, NULL), NPH_OK);
    ck_assert_msg(comparison.verdict != NPH_NOT_SAME, "%s", comparison.reason);
    render_free(&single);
    render_free(&path);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_loop_test(cases, path_at_low_albedo_is_the_quadrature, 0, (int)(sizeof pairs / sizeof *pairs));
}

int main(void) { return nph_test_main("single_agreement", fill); }
