/* SPDX-License-Identifier: Apache-2.0
 *
 * Skies and aerosol in scenes: the map is the sky of optics/sky.h in the right places, turbidity is what it is called, and what
 * is refused. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "harness.h"
#include "optics/air.h"
#include "scene/model.h"

#define HEAD "nephos: 1\ncamera: {resolution: [4, 3], position: [0, -4, 0], look_at: [0, 0, 0], fov: 35}\n"

static const double PI = 3.14159265358979323846;
static const NphPhase RAYLEIGH = {.kind = NPH_PHASE_RAYLEIGH}, HAZE = {.kind = NPH_PHASE_HG, .g = {0.76, 0.0}};

static NphScene *parse(NphContext *context, const char *text) {
    NphScene *scene = NULL;
    NphStatus status = nph_scene_parse(context, text, strlen(text), "test.yaml", nph_test_path("reference/scenes"), &scene);
    ck_assert_msg(status == NPH_OK, "%s\n%s", text, nph_test_messages());
    return scene;
}

static const float *texel(const NphEnvironment *map, int row, int column) { return map->radiance + 3 * ((int64_t)row * map->width + column); }

/* light.h: the middle of an unrotated map is +x, its right half lies towards -y. */
static void direction_of(const NphEnvironment *map, int row, int column, double d[3]) {
    double phi = 2 * PI * (0.5 - (column + 0.5) / map->width);
    d[2] = 0.5 * (cos(PI * row / map->height) + cos(PI * (row + 1) / map->height));
    d[0] = sqrt(1 - d[2] * d[2]) * cos(phi);
    d[1] = sqrt(1 - d[2] * d[2]) * sin(phi);
}

START_TEST(the_map_holds_the_sky_of_its_directions) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = parse(context, HEAD "air: {type: exponential, ground: -100, height: 900, aerosol: {extinction: [1e-5, 2e-5, 3e-5]}}\n"
                            "lights: [{type: sky, elevation: 35, azimuth: 130, irradiance: [3, 2, 1], rows: 90}]\n");
    const NphEnvironment *map = &scene->lights[0].map;
    const NphSceneAir *air = &scene->air;
    NphSky sky = {.count = 2, .irradiance = {3, 2, 1}, .sun = {cos(35 * PI / 180) * cos(130 * PI / 180), cos(35 * PI / 180) * sin(130 * PI / 180), sin(35 * PI / 180)}};
    sky.of[0] = (NphSkyConstituent){{air->extinction_per_m[0], air->extinction_per_m[1], air->extinction_per_m[2]}, {1, 1, 1}, 8000, NULL, &RAYLEIGH};
    sky.of[1] = (NphSkyConstituent){{1e-5, 2e-5, 3e-5}, {0.9, 0.9, 0.9}, 1200, NULL, &HAZE};
    double worst = 0;
    ck_assert(scene->lights[0].kind == NPH_LIGHT_ENVIRONMENT && map->width == 180 && map->height == 90);
    for (int row = 0; row < 90; row++)
        for (int column = 0; column < 180; column += 7) {
            NphSkyLine line = {1000, {0, 0, 0}, INFINITY};
            double L[3], cosine = 0;
            direction_of(map, row, column, line.direction);
            nph_sky_scattered(&sky, &line, L);
            for (int a = 0; a < 3; a++) cosine += line.direction[a] * sky.sun[a];
            int steep = row > 40 && row < 50; /* at the horizon a texel is no point */
            for (int c = 0; c < 3 && !steep; c++) worst = fmax(worst, fabs((double)texel(map, row, column)[c] - L[c]) / L[c] * (cosine > 0.98 ? 0.1 : 1));
        }
    printf("    texels off by at most %.2g of the sky in their middle\n", worst);
    ck_assert(worst < 0.01);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

/* Around a sphere azimuths are interpolated; at high sun the two kinds of air agree. */
START_TEST(a_sky_around_a_sphere_is_the_flat_one_at_high_sun) {
    NphContext *context = nph_test_context(1);
    static const char *const kinds[] = {"exponential", "table", "table, radius: 1e9"};
    double total[3], zenith[3];
    for (int k = 0; k < 3; k++) {
        char text[512];
        snprintf(text, sizeof text, HEAD "air: {type: %s, height: 0, aerosol: {turbidity: 2}}\n"
                 "lights: [{type: sky, elevation: 60, azimuth: -70, irradiance: 1, rows: 24}]\n", kinds[k]);
        NphScene *scene = parse(context, text);
        const NphEnvironment *map = &scene->lights[0].map;
        total[k] = map->total;
        zenith[k] = (double)texel(map, 0, 0)[1];
        int brightest = 0;
        for (int i = 0; i < map->width * map->height; i++)
            brightest = map->radiance[3 * i + 1] > map->radiance[3 * brightest + 1] ? i : brightest;
        double d[3];
        direction_of(map, brightest / map->width, brightest % map->width, d);
        ck_assert(fabs(atan2(d[1], d[0]) * 180 / PI + 70) < 7.6 && fabs(asin(d[2]) * 180 / PI - 60) < 7.6);
        nph_scene_free(context, scene);
    }
    printf("    total %.5g %.5g %.5g, zenith %.5g %.5g %.5g\n", total[0], total[1], total[2], zenith[0], zenith[1], zenith[2]);
    ck_assert(fabs(total[1] / total[0] - 1) < 0.05 && fabs(zenith[1] / zenith[0] - 1) < 0.01);
    ck_assert(fabs(total[2] / total[0] - 1) < 1e-3 && fabs(zenith[2] / zenith[0] - 1) < 1e-3);
    nph_test_context_close(context);
}
END_TEST

START_TEST(turbidity_is_the_depth_of_air_and_haze_over_that_of_air) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = parse(context, HEAD "air: {type: exponential, height: 0, aerosol: {turbidity: 3.5, scale_height: 2000, angstrom: 1}}\n"
                            "lights: [{type: sun, elevation: 90, azimuth: 0, irradiance: 1}]\n");
    double air = nph_rayleigh_per_m(550) * 8000;
    ck_assert(fabs(scene->lights[0].irradiance[1] - exp(-3.5 * air)) < 1e-14);
    for (int c = 0; c < 3; c++) {
        double nm = c == 0 ? 680 : c == 1 ? 550 : 440, depth = nph_rayleigh_per_m(nm) * 8000 + 2.5 * air * 550 / nm;
        ck_assert(fabs(scene->lights[0].irradiance[c] - exp(-depth)) < 1e-14);
    }
    nph_scene_free(context, scene);
    scene = parse(context, HEAD "wavelengths: [400, 550, 700]\nair: {type: exponential, height: 0, aerosol: {turbidity: 3.5, scale_height: 2000, angstrom: 1}}\n"
                  "lights: [{type: sun, elevation: 90, azimuth: 0, irradiance: 1}]\n");
    for (int i = 0; i < 3; i++) {
        double nm = 400 + 150 * i, depth = nph_rayleigh_per_m(nm) * 8000 + 2.5 * air * 550 / nm;
        ck_assert(fabs(scene->lights[0].spectrum[i] - exp(-depth)) < 1e-14);
    }
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(aerosol_of_no_extinction_changes_nothing) {
    NphContext *context = nph_test_context(1);
    static const char *const kinds[] = {"exponential", "table"};
    for (int k = 0; k < 2; k++) {
        char text[512];
        uint8_t digest[16];
        for (int haze = 0; haze < 2; haze++) {
            snprintf(text, sizeof text, HEAD "air: {type: %s, height: 30%s}\nlights:\n- {type: sun, elevation: 8, azimuth: 0, irradiance: 1}\n"
                     "- {type: constant, radiance: 1}\n", kinds[k], haze ? ", aerosol: {turbidity: 1}" : "");
            NphScene *scene = parse(context, text);
            if (haze) ck_assert(memcmp(digest, scene->digest, sizeof digest) == 0);
            memcpy(digest, scene->digest, sizeof digest);
            nph_scene_free(context, scene);
        }
    }
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_flat_sky_of_a_sun_below_the_horizon_is_black_and_says_so) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = parse(context, HEAD "air: {type: exponential, height: 0}\nlights: [{type: sky, elevation: -1, azimuth: 0, irradiance: 1, rows: 4}]\n");
    ck_assert(strstr(nph_test_messages(), "the sky light0 is not above the horizon") && scene->lights[0].map.total == 0.0);
    nph_scene_free(context, scene);
    scene = parse(context, HEAD "air: {type: table, height: 0}\nlights: [{type: sky, elevation: -1, azimuth: 0, irradiance: 1, rows: 8}]\n");
    ck_assert(scene->lights[0].map.total > 0.0);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

static const struct {
    const char *text, *said;
    NphStatus status;
} wrong[] = {
    {"lights: [{type: sky, elevation: 9, azimuth: 0, irradiance: 1}]\n", "test.yaml:3:10: a sky is what air scatters, and the scene has no air", NPH_BAD_SCENE},
    {"air: {type: exponential, height: 0}\nwavelengths: [500, 600]\nlights: [{type: sky, elevation: 9, azimuth: 0, irradiance: 1}]\n",
     "test.yaml:5:10: a sky is a map of R, G, B", NPH_BAD_SCENE},
    {"air: {type: exponential, aerosol: {}}\n", "extinction", NPH_BAD_SCENE},
    {"air: {type: exponential, aerosol: {turbidity: 2, extinction: 1e-5}}\n", "test.yaml:3:", NPH_BAD_SCENE},
    {"air: {type: exponential, aerosol: {turbidity: 0.5}}\n", "test.yaml:3:", NPH_BAD_SCENE},
    {"air: {type: exponential, height: 0, aerosol: {turbidity: 2, phase: {type: tabulated, file: nothing.txt}}}\n", "nothing.txt", NPH_BAD_INPUT},
    {"air: {type: exponential, where: within, height: 3}\n", "test.yaml:3:49: height is that of lights before the scene", NPH_BAD_SCENE},
    {"air: {type: exponential, where: within}\nlights: [{type: sky, elevation: 9, azimuth: 0, irradiance: 1}]\n",
     "test.yaml:4:10: a sky is what the air scatters, which with where: within", NPH_BAD_SCENE},
    {"air: {type: exponential, where: within}\nlights: [{type: constant, radiance: 1, air: ignored}]\n",
     "test.yaml:4:10: air: ignored does not go with where: within", NPH_BAD_SCENE},
    {"air: {type: exponential, where: within}\nmedia: [{name: air, layer: [0, 1], extinction: 1}]\n",
     "test.yaml:3:6: the name air is taken by medium number 0", NPH_BAD_SCENE},
    {"air: {type: table, where: within, file: ../data/gpl/afglus.dat}\n", "test.yaml:3:41: a profile from a file is not modelled within", NPH_BAD_SCENE},
    {"air: {type: table, where: within}\nperiodic: {x: [0, 1]}\nmedia: [{box: [[0, 0, 0], [1, 1, 1]], extinction: 1}]\n",
     "test.yaml:3:6: air around a sphere is nowhere the same", NPH_BAD_SCENE},
};

START_TEST(mistakes_are_told_with_their_place) {
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        NphContext *context = nph_test_context(1);
        NphScene *scene = NULL;
        char text[1024];
        snprintf(text, sizeof text, HEAD "%s", wrong[i].text);
        NphStatus status = nph_scene_parse(context, text, strlen(text), "test.yaml", nph_test_path("reference/scenes"), &scene);
        const char *messages = nph_test_messages();
        ck_assert_msg(status == wrong[i].status && strstr(messages, wrong[i].said), "%s: %d, %s", wrong[i].text, status, messages);
        nph_test_context_close(context);
    }
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, the_map_holds_the_sky_of_its_directions);
    tcase_add_test(cases, a_sky_around_a_sphere_is_the_flat_one_at_high_sun);
    tcase_add_test(cases, turbidity_is_the_depth_of_air_and_haze_over_that_of_air);
    tcase_add_test(cases, aerosol_of_no_extinction_changes_nothing);
    tcase_add_test(cases, a_flat_sky_of_a_sun_below_the_horizon_is_black_and_says_so);
    tcase_add_test(cases, mistakes_are_told_with_their_place);
}

int main(void) { return nph_test_main("scene_sky", fill); }
