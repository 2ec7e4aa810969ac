/* SPDX-License-Identifier: Apache-2.0
 *
 * Places where light of media begins: their worth has the mean that the integral of the emission has, and no place is
 * worth more than the integral of the bound. (In the number type of f64.) */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "harness.h"
#include "transport/emission_source_lookup.h"
#include "transport/prepare_lookup.h"

#define HEAD "nephos: 1\ncamera: {resolution: [4, 3], position: [0, -4, 0], look_at: [0, 0, 0], fov: 35}\n"

static RScene local;

static NphScene *open_scene(NphContext *context, const char *media, NphTransportChoice *choice) {
    char text[2000];
    NphScene *scene = NULL;
    snprintf(text, sizeof text, HEAD "media:\n%s", media);
    NphStatus status = nph_scene_parse(context, text, strlen(text), "s", nph_test_path("reference/scenes"), &scene);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    nph_transport_choose(scene, 0, choice);
    r_prepare_scene(scene, choice, 1, 0, &local);
    return scene;
}

/* Two boxes and a grid without extinction: the integral of a trilinear function that falls to zero around its samples is
 * their sum times a voxel, here 0.4^3 times the file's 0.125^3. */
START_TEST(the_mean_worth_is_the_integral_of_the_emission) {
    NphContext *context = nph_test_context(1);
    NphTransportChoice choice;
    NphEmissionSources sources;
    NphScene *scene = open_scene(context,
        "- {box: [[0, 0, 0], [1, 2, 3]], extinction: 0, emission: {type: volume, radiance: [0.02, 0.01, 0]}, transform: [{rotate: {axis: [1, 1, 0], angle: 30}}]}\n"
        "- {box: [[0, 0, 0], [1, 1, 1]], extinction: 0, emission: {type: volume, radiance: 0}}\n"
        "- {density: {file: ../data/vdb/plume32_f20_BLOSC_float32.vdb}, extinction: 1, transform: [{scale: 0.4}, {translate: [1e7, 0, 0]}],\n"
        "   emission: {type: volume, radiance: [1, 2, 4], grid: temperature}}\n", &choice);
    ck_assert_int_eq(nph_emission_sources(context, scene, &choice, &sources), NPH_OK);
    const NphGrid *grid = &scene->media[2].emission.grids[0];
    const double *m = scene->media[2].emission.world_from_grid;
    double voxel = m[0] * m[5] * m[10], sum[3] = {0, 0, 0}, squares[3] = {0, 0, 0};
    enum { COUNT = 1 << 20 };
    for (uint32_t i = 0; i < COUNT; i++) {
        Real p[3], value[3];
        NphWords words = nph_philox(1, 2, i, 0, 0, 0), more = nph_philox(1, 2, i, 0, 0, 1);
        r_emission_sample(&local, &sources, words, more, p, value);
        for (int c = 0; c < 3; c++) {
            ck_assert(value[c] >= 0.0 && value[c] <= sources.total * 1.000001);
            sum[c] += value[c];
            squares[c] += value[c] * value[c];
        }
        if (i >= 1000 || p[0] < 0.0) continue; /* the grid's: its emission is found there by position */
        Real j[3];
        r_emission_at(&local, p, j);
        ck_assert(j[2] > 0.0 || value[2] == 0.0);
    }
    for (int c = 0; c < 3; c++) {
        double right = grid->sum * voxel * (1 << c) + 6.0 * (0.02 - 0.01 * c);
        double mean = sum[c] / COUNT, error = sqrt((squares[c] / COUNT - mean * mean) / COUNT);
        printf("    %.6g +- %.2g, %.6g\n", mean, error, right);
        ck_assert(fabs(mean - right) < 4.4 * error && error < 3e-3 * right);
    }
    nph_emission_sources_free(context, &sources);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_layer_without_end_is_refused_and_darkness_has_no_place) {
    NphContext *context = nph_test_context(1);
    NphTransportChoice choice;
    NphEmissionSources sources;
    NphScene *scene = open_scene(context, "- {layer: [0, 1], extinction: 1, emission: {type: volume, radiance: 1}}\n", &choice);
    ck_assert_int_eq(nph_emission_sources(context, scene, &choice, &sources), NPH_BAD_INPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "medium0: light cannot be followed"));
    nph_scene_free(context, scene);
    scene = open_scene(context, "- {layer: [0, 1], extinction: 1}\n", &choice);
    ck_assert_int_eq(nph_emission_sources(context, scene, &choice, &sources), NPH_OK);
    ck_assert_int_eq(sources.count, 0);
    nph_emission_sources_free(context, &sources);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, the_mean_worth_is_the_integral_of_the_emission);
    tcase_add_test(cases, a_layer_without_end_is_refused_and_darkness_has_no_place);
}

int main(void) { return nph_test_main("emission_source", fill); }
