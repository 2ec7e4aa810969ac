/* SPDX-License-Identifier: Apache-2.0
 *
 * Phase functions of spheres in scenes: what is loaded is the table of the same request, the digest knows it, and what cannot be
 * computed is named. */
#include <math.h>
#include <string.h>

#include "harness.h"
#include "optics/index.h"
#include "optics/mie_table.h"
#include "scene/model.h"

#define HEAD "nephos: 1\ncamera: {resolution: [4, 3], position: [0, -4, 0], look_at: [0, 0, 0], fov: 35}\n"
#define MEDIUM(phase) "media: [{box: [[0, 0, 0], [1, 1, 1]], extinction: 1, phase: {type: mie, " phase "}}]\n"

static NphScene *parse(NphContext *context, const char *text) {
    NphScene *scene = NULL;
    ck_assert_msg(nph_scene_parse(context, text, strlen(text), "test.yaml", ".", &scene) == NPH_OK, "%s\n%s", text, nph_test_messages());
    return scene;
}

static void check(NphContext *context, const char *text, const NphMieRequest *request) {
    NphScene *scene = parse(context, text);
    NphMieTable table = {0};
    NphPhase phase;
    ck_assert_int_eq(nph_mie_table(context, request, "spheres", &table), NPH_OK);
    ck_assert_int_eq(nph_phase_tabulate(context, &table.rows, "spheres", &phase), NPH_OK);
    ck_assert_int_eq(scene->media[0].phase.kind, NPH_PHASE_TABULATED);
    for (double c = -1; c <= 1; c += 0.01) ck_assert(nph_phase_value(&phase, c) == nph_phase_value(&scene->media[0].phase, c));
    ck_assert(fabs(nph_phase_mean_cosine(&phase) - table.totals.asymmetry) < 2e-3);
    nph_phase_free(context, &phase);
    nph_mie_table_free(context, &table);
    nph_scene_free(context, scene);
}

START_TEST(spheres_have_the_table_of_their_request) {
    NphContext *context = nph_test_context(0);
    NphMieRequest water = {.sizes = {NPH_SIZES_GAMMA, 4, 0.1, 0, 0}, .wavelength_count = 1, .wavelength_um = {1e-3 * 550}, .tolerance = 0.05};
    ck_assert(nph_index_at(NPH_WATER, 1e-3 * 550, water.index[0]));
    check(context, HEAD MEDIUM("particle: water, sizes: gamma, radius: 4, spread: 0.1, wavelengths: [550], tolerance: 0.05"), &water);
    NphMieRequest other = {.sizes = {NPH_SIZES_SINGLE, 0.3, 0, 0, 0}, .wavelength_count = 2, .wavelength_um = {1e-3 * 450, 1e-3 * 650}, .index = {{1.5, 0.1}, {1.5, 0.1}},
                           .tolerance = 0.01};
    check(context, HEAD "wavelengths: [450, 650]\n" MEDIUM("particle: other, n: 1.5, k: 0.1, sizes: single, radius: 0.3"), &other);
    NphMieRequest haze = {.sizes = {NPH_SIZES_MODIFIED_GAMMA, 0.07, 0, 2, 0.5}, .wavelength_count = 1, .wavelength_um = {1e-3 * 700}, .index = {{1.33, 0}}, .tolerance = 0.01};
    check(context, HEAD MEDIUM("particle: other, n: 1.33, k: 0, sizes: modified_gamma, radius: 0.07, alpha: 2, gamma: 0.5, wavelengths: [700]"), &haze);
    nph_test_context_close(context);
}
END_TEST

START_TEST(other_spheres_are_another_scene) {
    NphContext *context = nph_test_context(0);
    NphScene *a = parse(context, HEAD MEDIUM("particle: soot, sizes: single, radius: 0.1, wavelengths: [550]"));
    NphScene *b = parse(context, HEAD MEDIUM("particle: soot, sizes: single, radius: 0.1, wavelengths: [550], tolerance: 1e-2"));
    NphScene *c = parse(context, HEAD MEDIUM("particle: soot, sizes: single, radius: 0.11, wavelengths: [550]"));
    ck_assert(memcmp(a->digest, b->digest, 16) == 0 && memcmp(a->digest, c->digest, 16) != 0);
    nph_scene_free(context, a);
    nph_scene_free(context, b);
    nph_scene_free(context, c);
    nph_test_context_close(context);
}
END_TEST

/* An aerosol takes them as a medium does. */
START_TEST(an_aerosol_may_be_spheres) {
    NphContext *context = nph_test_context(0);
    NphScene *scene = parse(context, HEAD "air: {type: exponential, aerosol: {turbidity: 3, scale_height: 1000, phase: {type: mie, particle: water, sizes: single, radius: 0.3, "
                                          "wavelengths: [550]}}}\nlights: [{type: constant, radiance: 1}]\n");
    const NphPhase *phase = &scene->air.aerosol.phase;
    ck_assert_int_eq(phase->kind, NPH_PHASE_TABULATED);
    ck_assert(nph_phase_mean_cosine(phase) > 0.5);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(spheres_too_large_are_named_with_their_place) {
    static const char text[] = HEAD MEDIUM("particle: water, sizes: single, radius: 1e5, wavelengths: [550]");
    NphContext *context = nph_test_context(0);
    NphScene *scene = NULL;
    ck_assert_int_eq(nph_scene_parse(context, text, strlen(text), "s", ".", &scene), NPH_BAD_INPUT);
    const char *said = nph_test_messages();
    ck_assert_msg(strstr(said, "medium0: size parameters") && strstr(said, "s:3:61: the phase function of medium0 cannot be computed"), "%s", said);
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *tcase) {
    tcase_set_timeout(tcase, 60);
    tcase_add_test(tcase, an_aerosol_may_be_spheres);
    tcase_add_test(tcase, spheres_have_the_table_of_their_request);
    tcase_add_test(tcase, other_spheres_are_another_scene);
    tcase_add_test(tcase, spheres_too_large_are_named_with_their_place);
}

int main(void) { return nph_test_main("scene_mie", fill); }
