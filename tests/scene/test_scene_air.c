/* SPDX-License-Identifier: Apache-2.0
 *
 * Air in scenes: what it leaves of each light, against the closed form; what it does not touch; what is refused. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/text.h"
#include "harness.h"
#include "io/air_rows.h"
#include "optics/air.h"
#include "scene/model.h"

#define HEAD "nephos: 1\ncamera: {resolution: [4, 3], position: [0, -4, 0], look_at: [0, 0, 0], fov: 35}\n"
#define CLOUD "media: [{box: [[0, 0, 1000], [500, 500, 2000]], extinction: 1}]\n"
#define MAP "{type: environment, file: ../data/env/exr_variants/sunset256_float_zip.exr"
#define PROFILE "file: ../data/gpl/afglus.dat"

static const double PI = 3.14159265358979323846;

static NphScene *parse(NphContext *context, const char *text) {
    NphScene *scene = NULL;
    NphStatus status = nph_scene_parse(context, text, strlen(text), "test.yaml", nph_test_path("reference/scenes"), &scene);
    ck_assert_msg(status == NPH_OK, "%s\n%s", text, nph_test_messages());
    return scene;
}

static void near(double value, double truth, double most) {
    ck_assert_msg(fabs(value - truth) <= most * fabs(truth), "%.17g is not %.17g", value, truth);
}

/* 2000 m above sea level, in the middle of the cloud. */
static double flat(double per_m, double sine) { return exp(-per_m * 8000.0 * exp(-2000.0 / 8000.0) / sine); }

START_TEST(suns_are_attenuated_at_the_middle_of_the_scene_or_at_the_height_given) {
    NphContext *context = nph_test_context(1);
    static const double nm[] = {680, 550, 440};
    NphScene *scene = parse(context, HEAD CLOUD "air: {type: exponential, ground: -500}\n"
                            "lights:\n- {type: sun, elevation: 30, azimuth: 0, irradiance: [3, 2, 1]}\n"
                            "- {type: sun, direction: [0, 0, 1], irradiance: 5, angular_diameter: 1.9}\n");
    for (int c = 0; c < 3; c++) {
        near(scene->air.extinction_per_m[c], nph_rayleigh_per_m(nm[c]), 0);
        near(scene->lights[0].irradiance[c], (3 - c) * flat(nph_rayleigh_per_m(nm[c]), 0.5), 1e-14);
        near(scene->lights[1].irradiance[c], 5 * flat(nph_rayleigh_per_m(nm[c]), 1.0), 1e-14);
    }
    ck_assert(scene->air.height_m == 1500.0);
    nph_scene_free(context, scene);
    scene = parse(context, HEAD CLOUD "air: {type: exponential, extinction: [1e-5, 0, 2e-5], scale_height: 4000, height: 4000}\n"
                  "lights: [{type: sun, elevation: 30, azimuth: 0, irradiance: 1}]\n");
    for (int c = 0; c < 3; c++)
        near(scene->lights[0].irradiance[c], exp(-(c == 0 ? 1e-5 : c == 1 ? 0 : 2e-5) * 4000.0 * exp(-1.0) / 0.5), 1e-14);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(wavelengths_have_each_their_own_extinction) {
    NphContext *context = nph_test_context(1);
    static const double nm[] = {400, 500, 600, 700};
    NphScene *scene = parse(context, HEAD CLOUD "wavelengths: [400, 500, 600, 700]\nair: {type: exponential, ground: -500}\n"
                            "lights: [{type: sun, elevation: 30, azimuth: 0, irradiance: [1, 2, 3, 4]},\n"
                            "         {type: constant, radiance: 1, air: ignored}]\n");
    double thirds[3];
    for (int i = 0; i < 4; i++) near(scene->lights[0].spectrum[i], (i + 1) * flat(nph_rayleigh_per_m(nm[i]), 0.5), 1e-14);
    nph_spectrum_thirds(scene->lights[0].spectrum, 4, thirds);
    for (int c = 0; c < 3; c++) ck_assert(scene->lights[0].irradiance[c] == thirds[c]);
    ck_assert(scene->lights[1].kind == NPH_LIGHT_CONSTANT);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_scene_behind_air_is_the_scene_with_weaker_lights) {
    NphContext *context = nph_test_context(1);
    NphScene *behind = parse(context, HEAD CLOUD "air: {type: exponential}\n"
                             "lights:\n- {type: sun, elevation: 20, azimuth: 40, irradiance: [5, 4.3, 3.4]}\n"
                             "- {type: point, position: [0, 0, 50], intensity: 7}\n- {type: constant, radiance: 2, air: ignored}\n");
    char weaker[1024], number[3][NPH_DOUBLE_TEXT];
    for (int c = 0; c < 3; c++) nph_format_double(behind->lights[0].irradiance[c], number[c]);
    snprintf(weaker, sizeof weaker, HEAD CLOUD "lights:\n- {type: sun, elevation: 20, azimuth: 40, irradiance: [%s, %s, %s]}\n"
             "- {type: point, position: [0, 0, 50], intensity: 7}\n- {type: constant, radiance: 2}\n", number[0], number[1], number[2]);
    NphScene *without = parse(context, weaker);
    ck_assert(memcmp(behind->digest, without->digest, sizeof behind->digest) == 0);
    ck_assert(behind->lights[0].irradiance[2] < 3.0);
    nph_scene_free(context, behind);
    nph_scene_free(context, without);
    nph_test_context_close(context);
}
END_TEST

/* The mean over a row is that of the integral over its solid angle, here by 20000 midpoints. */
START_TEST(rows_of_a_map_take_their_mean_transmittance) {
    NphContext *context = nph_test_context(1);
    NphScene *bare = parse(context, HEAD CLOUD "lights: [" MAP "}]\n");
    NphScene *behind = parse(context, HEAD CLOUD "air: {type: exponential, ground: -500}\nlights: [" MAP ", rotation: 77}]\n");
    const NphEnvironment *from = &bare->lights[0].map, *to = &behind->lights[0].map;
    double worst = 0.0;
    for (int row = 0; row < from->height; row++) {
        double top = cos(PI * row / from->height), bottom = cos(PI * (row + 1) / from->height);
        for (int c = 0; c < 3; c++) {
            double T = 0.0;
            for (int i = 0; i < 20000; i++) {
                double sine = top + (bottom - top) * (i + 0.5) / 20000;
                T += sine > 0 ? flat(behind->air.extinction_per_m[c], sine) / 20000 : 0.0;
            }
            for (int column = 0; column < from->width; column += 37) {
                int64_t texel = 3 * ((int64_t)row * from->width + column) + c;
                double off = fabs((double)to->radiance[texel] - (double)from->radiance[texel] * T);
                worst = fmax(worst, off / (double)from->radiance[texel]);
                if (top <= 1e-9) ck_assert(to->radiance[texel] == 0.0f);
            }
        }
    }
    printf("    largest difference %.2g of what was there\n", worst);
    ck_assert(worst < 1e-5); /* 64 midpoints of the row above the horizon, where blue falls from 0.02 to 0 */
    ck_assert(to->total < from->total && to->row_cdf[from->height / 2] == 1.0);
    nph_scene_free(context, bare);
    nph_scene_free(context, behind);
    nph_test_context_close(context);
}
END_TEST

/* Luminance over the sphere of a constant light above air without extinction, and with the same extinction everywhere:
 * 2 pi times the integral of exp(-tau / sine), E_2(tau). E_2(0.5) = 0.3266439 [Abramowitz64 table 5.1]. */
START_TEST(a_constant_light_becomes_a_map_with_the_integral_of_its_transmittance) {
    NphContext *context = nph_test_context(1);
    static const struct {
        const char *extinction, *hemisphere;
        double total;
    } cases[] = {{"0", "all", 1.0}, {"0", "upper", 1.0}, {"0", "lower", 0.0}, {"0.0005", "upper", 0.3266439}, {"0.0005", "lower", 0}};
    for (int i = 0; i < 5; i++) {
        char text[512];
        snprintf(text, sizeof text, HEAD CLOUD "air: {type: exponential, scale_height: 1000, height: 0, extinction: %s}\n"
                 "lights: [{type: constant, radiance: [1.5, 1.5, 1.5], hemisphere: %s}]\n", cases[i].extinction, cases[i].hemisphere);
        NphScene *scene = parse(context, text);
        ck_assert(scene->lights[0].kind == NPH_LIGHT_ENVIRONMENT && scene->lights[0].map.width == 1);
        printf("    %.8g\n", scene->lights[0].map.total / (3 * PI));
        ck_assert(fabs(scene->lights[0].map.total / (3 * PI) - cases[i].total) < 1e-6);
        nph_scene_free(context, scene);
    }
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_table_is_that_of_its_profile) {
    NphContext *context = nph_test_context(1);
    static const char *const ways[] = {"", ", " PROFILE};
    for (int k = 0; k < 2; k++) {
        NphAirProfile profile;
        NphArray rows;
        char text[512];
        snprintf(text, sizeof text, HEAD CLOUD "air: {type: table, ground: -500, height: 2500%s}\nlights:\n"
                 "- {type: sun, elevation: 4, azimuth: 0, irradiance: 1}\n- {type: sun, elevation: -1.5, azimuth: 0, irradiance: 1}\n"
                 "- {type: sun, elevation: -1.9, azimuth: 0, irradiance: 1}\n", ways[k]);
        NphScene *scene = parse(context, text);
        ck_assert(strstr(nph_test_messages(), "the sun light2 is not above the horizon") != NULL);
        if (k == 1) ck_assert_int_eq(nph_air_rows_read(context, nph_test_path("reference/data/gpl/afglus.dat"), &rows), NPH_OK);
        ck_assert_int_eq(k == 1 ? nph_air_profile_from_rows(context, &rows, 6371000, &profile)
                                : nph_air_profile_exponential(context, 8000, 6371000, &profile), NPH_OK);
        for (int l = 0; l < 2; l++) {
            double metres = nph_air_column_curved(&profile, 3000, sin(PI / 180 * (l == 0 ? 4 : -1.5)));
            for (int c = 0; c < 3; c++) {
                double depth = scene->air.extinction_per_m[c] * metres;
                near(scene->lights[l].irradiance[c], exp(-depth), 1e-3 * depth + 1e-6);
                ck_assert(scene->lights[l].irradiance[c] > 0.0 && scene->lights[2].irradiance[c] == 0.0);
            }
        }
        nph_air_profile_free(context, &profile);
        if (k == 1) nph_array_free(context, &rows);
        nph_scene_free(context, scene);
    }
    nph_test_context_close(context);
}
END_TEST

/* Text after the head and the cloud, which are 3 lines. */
static const struct {
    const char *text, *said;
    NphStatus status;
} wrong[] = {
    {"air: {}\n", "test.yaml:4:6: the air lacks type (one of exponential, table)", NPH_BAD_SCENE},
    {"air: {type: flat}\n", "test.yaml:4:13: ", NPH_BAD_SCENE},
    {"air: {type: exponential, radius: 7e6}\n", "radius does not go with type exponential, only with table", NPH_BAD_SCENE},
    {"air: {type: table, scale_height: 7000, " PROFILE "}\n", "test.yaml:4:34: scale_height and file exclude each other", NPH_BAD_SCENE},
    {"air: {type: exponential, height: -1}\n", "test.yaml:4:34: height is -1 m, below the ground of the air at 0 m", NPH_BAD_SCENE},
    {"air: {type: exponential, ground: 1600}\n", "test.yaml:4:6: height, the middle of the scene, is 1500 m, below the ground",
     NPH_BAD_SCENE},
    {"air: {type: table, height: 120001}\n", "test.yaml:4:28: height is 120001 m, above the end of the air's table at 120000 m",
     NPH_BAD_SCENE},
    {"air: {type: exponential, extinction: -1}\n", "test.yaml:4:38: ", NPH_BAD_SCENE},
    {"air: {type: table, file: nothing.dat}\n", "test.yaml:4:26: profile of the air 'nothing.dat' cannot be read", NPH_BAD_INPUT},
    {"air: {type: table, file: ../data/gpl/c1_phase.txt}\n", "test.yaml:4:26: this profile of the air cannot be used", NPH_BAD_INPUT},
    {"air: {type: exponential}\nlights: [{type: sun, elevation: 9, azimuth: 0, irradiance: 1, angular_diameter: 2.1}]\n",
     "test.yaml:5:10: a sun wider than 2 degrees", NPH_BAD_SCENE},
    {"air: {type: exponential}\nwavelengths: [500, 600]\nlights: [{type: constant, radiance: 1}]\n",
     "test.yaml:6:10: with wavelengths the air attenuates suns alone", NPH_BAD_SCENE},
    {"lights: [{type: point, position: [0, 0, 0], intensity: 1, air: ignored}]\n",
     "air does not go with type point, only with sun or constant or environment", NPH_BAD_SCENE},
};

START_TEST(mistakes_are_told_with_their_place) {
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        NphContext *context = nph_test_context(1);
        NphScene *scene = NULL;
        char text[1024];
        snprintf(text, sizeof text, HEAD CLOUD "%s", wrong[i].text);
        NphStatus status = nph_scene_parse(context, text, strlen(text), "test.yaml", nph_test_path("reference/scenes"), &scene);
        const char *messages = nph_test_messages();
        ck_assert_msg(status == wrong[i].status && strstr(messages, wrong[i].said), "%s: %d, %s", wrong[i].text, status, messages);
        nph_test_context_close(context);
    }
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, suns_are_attenuated_at_the_middle_of_the_scene_or_at_the_height_given);
    tcase_add_test(cases, wavelengths_have_each_their_own_extinction);
    tcase_add_test(cases, a_scene_behind_air_is_the_scene_with_weaker_lights);
    tcase_add_test(cases, rows_of_a_map_take_their_mean_transmittance);
    tcase_add_test(cases, a_constant_light_becomes_a_map_with_the_integral_of_its_transmittance);
    tcase_add_test(cases, a_table_is_that_of_its_profile);
    tcase_add_test(cases, mistakes_are_told_with_their_place);
}

int main(void) { return nph_test_main("scene_air", fill); }
