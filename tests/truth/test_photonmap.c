/* SPDX-License-Identifier: Apache-2.0
 *
 * The parts of photon mapping against closed forms: power that photons bring and store, the mean of the estimate,
 * optical depths; and what it promises: the same map for any number of threads, replay to the bit. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/memory.h"
#include "core/philox.h"
#include "harness.h"
#include "kernel_photonmap.h"
#include "method/job.h"

#define PI 3.14159265358979323846

/* A scene ready to make maps. */
typedef struct Maker {
    NphContext *context;
    NphScene *scene;
    NphJob job;
    NphPhotonmapChoice choice;
    void *memory;
    NphPhotonmapMaker maker;
} Maker;

static void maker_open(Maker *m, const char *yaml, int precision, int threads, int knob_count,
                       const char *const *knobs) {
    const NphMethod *method = NULL;
    NphRenderOptions options;
    m->context = nph_test_context(threads);
    NphStatus status =
        nph_scene_parse(m->context, yaml, strlen(yaml), "test.yaml", nph_test_path("reference/scenes"), &m->scene);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    nph_render_options_default(&options);
    options.method = "photonmap";
    options.precision = precision;
    options.knob_count = knob_count;
    options.knobs = knobs;
    status = nph_job_make(m->context, m->scene, &options, &method, &m->job);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    ck_assert_int_eq(nph_photonmap_choose(&m->job, &m->choice), NPH_OK);
    NphPhotonmapKernels kernels;
    nph_photonmap_kernels(NPH_ISA_BASE, precision, &kernels);
    ck_assert_int_eq(nph_alloc(m->context, kernels.scene_bytes(), 1, "scene", &m->memory), NPH_OK);
    kernels.prepare(&m->job, &m->choice, m->memory);
    ck_assert_int_eq(nph_photonmap_maker_open(&m->job, &m->choice, m->memory, &m->maker), NPH_OK);
    ck_assert_int_eq(nph_photonmap_prepare_maps(&m->maker), NPH_OK);
}

static void maker_close(Maker *m) {
    nph_photonmap_maker_close(&m->maker);
    nph_free(m->context, m->memory);
    nph_scene_free(m->context, m->scene);
    nph_test_context_close(m->context);
}

static double power_of(const Maker *m, int order) {
    return (m->job.precision == 32 ? photonmap_power_f32_base : photonmap_power_f64_base)(&m->maker.map, order);
}

/* The mean over maps of stored power is `expected`: within 4 standard errors, which must be below 2%. */
static void check_power(const char *name, const char *yaml, int order, double expected) {
    static const char *const knobs[] = {"photonmap.photons=1500", "photonmap.emitted=2000", "photonmap.direct=0"};
    enum { MAPS = 24 };
    for (int precision = 32; precision <= 64; precision += 32) {
        Maker m;
        double sum = 0.0, squares = 0.0;
        maker_open(&m, yaml, precision, 2, 3, knobs);
        for (uint32_t sample = 0; sample < MAPS; sample++) {
            ck_assert_int_eq(nph_photonmap_make(&m.maker, sample), NPH_OK);
            double power = power_of(&m, order);
            sum += power;
            squares += power * power;
        }
        double mean = sum / MAPS, error = sqrt((squares / MAPS - mean * mean) / (MAPS - 1));
        printf("    %s f%d: %.5f +- %.5f, closed form %.5f\n", name, precision, mean, error, expected);
        ck_assert_double_lt(error, 0.02 * expected);
        ck_assert_msg(fabs(mean - expected) <= 4.0 * error + 1e-5 * expected, "%s: %g +- %g is not %g", name, mean,
                      error, expected);
        maker_close(&m);
    }
}

#define SCENE(media, light)                                                                                            \
    "nephos: 1\ncamera: {resolution: [8, 8], position: [-3, 0, 0], look_at: [0, 0, 0], fov: 40}\n"                     \
    "media:\n  - {" media "}\nlights:\n  - {" light "}\n"
#define CUBE  "box: [[0, 0, 0], [1, 1, 1]], extinction: 3, albedo: 0.8, phase: {type: hg, g: 0.6}"
#define BLOCK "box: [[-1, -2, 0], [1, 3, 4]], extinction: 1e5, albedo: 0.5"

START_TEST(in_a_white_furnace_all_media_scatter_four_pi_per_volume) {
    check_power("furnace",
                SCENE("box: [[0, 0, 0], [1, 2, 0.5]], extinction: 3, albedo: 1, phase: {type: hg, g: 0.6}",
                      "type: constant, radiance: 2"),
                0, 2.0 * 4.0 * PI * 3.0);
    check_power("two media",
                "nephos: 1\ncamera: {resolution: [8, 8], position: [-3, 0, 0], look_at: [0, 0, 0], fov: 40}\n"
                "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: [2, 1, 0], albedo: 1}\n"
                "  - {box: [[0.5, 0.5, 0.5], [1.5, 1, 2]], extinction: [1, 4, 2], albedo: 1, transform: [{rotate: "
                "{axis: [1, 1, 0], angle: 20}}]}\n"
                "lights:\n  - {type: constant, radiance: 1}\n",
                0, 4.0 * PI * (2.0 + 1.0 * 0.5 * 1.5));
}
END_TEST

START_TEST(the_first_collisions_scatter_what_the_lights_send) {
    double passed = 0.8 * (1.0 - exp(-3.0));
    check_power("sun", SCENE(CUBE, "type: sun, direction: [0, 0, 1], irradiance: 2"), 1, 2.0 * passed);
    /* thick: everything that meets the block collides; A(w) from its faces 5 x 4, 2 x 4, 2 x 5 */
    double d[3] = {1.0, 2.0, 2.0};
    check_power("oblique sun", SCENE(BLOCK, "type: sun, direction: [1, 2, 2], irradiance: 1"), 1,
                0.5 * (20.0 * d[0] + 8.0 * d[1] + 10.0 * d[2]) / 3.0);
    /* every face that sees the disc sees all of it */
    check_power("disc", SCENE(BLOCK, "type: sun, direction: [1, 2, 2], irradiance: 1, angular_diameter: 10"), 1,
                0.5 * (20.0 * d[0] + 8.0 * d[1] + 10.0 * d[2]) / 3.0);
    check_power("constant", SCENE(BLOCK, "type: constant, radiance: 1.5"), 1,
                0.5 * 1.5 * PI * 2.0 * (20.0 + 8.0 + 10.0));
    /* a face sees the upper half of the sky by a quarter of its area times pi at its sides, all of it on top */
    check_power("upper half", SCENE(BLOCK, "type: constant, radiance: 1, hemisphere: upper"), 1,
                0.5 * PI * (10.0 + 0.5 * 2.0 * (20.0 + 8.0)));
    check_power("point inside", SCENE(BLOCK, "type: point, position: [0.5, 1, 1], intensity: 3"), 1,
                0.5 * 3.0 * 4.0 * PI);
    /* from the axis of the upper face, 2 m above it: solid angle of a 2 x 5 rectangle */
    check_power("point outside", SCENE(BLOCK, "type: point, position: [0, 0.5, 6], intensity: 1"), 1,
                0.5 * 4.0 * asin(1.0 * 2.5 / sqrt((1.0 + 4.0) * (6.25 + 4.0))));
}
END_TEST

START_TEST(the_sky_of_a_map_sends_its_integral) {
    const char *yaml = SCENE(BLOCK, "type: environment, file: ../data/env/exr_variants/sunset256_float_zip.exr, rotation: 70");
    Maker m;
    maker_open(&m, yaml, 64, 1, 0, NULL);
    double power = photonmap_sky_power_f64_base(m.memory);
    maker_close(&m);
    check_power("environment", yaml, 1, 0.5 * power);
}
END_TEST

START_TEST(thinning_keeps_the_power_and_fills_the_room) {
    static const char *const knobs[] = {"photonmap.photons=300", "photonmap.emitted=2000", "photonmap.direct=0"};
    Maker m;
    maker_open(&m,
               SCENE("box: [[0, 0, 0], [1, 1, 1]], extinction: 5, albedo: 1",
                     "type: sun, direction: [0, 0, 1], irradiance: 1"),
               64, 1, 3, knobs);
    for (uint32_t sample = 0; sample < 8; sample++) {
        ck_assert_int_eq(nph_photonmap_make(&m.maker, sample), NPH_OK);
        ck_assert_int_eq(m.maker.map.tree.count, 300);
        ck_assert_int_gt(m.maker.map.scattered, 3000);
        /* all photons are alike: the sum is the power of all, kept or not */
        double all = (double)m.maker.map.scattered / 2000.0;
        ck_assert_double_le(fabs(power_of(&m, 0) - all), 1e-6 * all);
    }
    maker_close(&m);
}
END_TEST

/* 4 pi times the estimate is the density of power, 1: uniform photons, a place whose sphere lies in the cube. */
START_TEST(the_estimate_of_a_uniform_density_is_exact_in_the_mean) {
    static const struct {
        int nearest;
        double reach;
    } cases[] = {{2, 0.4}, {2, 0.05}, {5, 0.1}, {5, 0.14}, {40, 0.2}, {40, 0.3}};
    enum { MAPS = 3000, PHOTONS = 1000 };
    for (int precision = 32; precision <= 64; precision += 32) {
        double sums[6][2] = {{0}}, squares[6][2] = {{0}};
        NphContext *context = nph_test_context(1);
        NphPhotonMap map = {.room = PHOTONS, .tree = {.precision = precision, .count = PHOTONS}};
        ck_assert_int_eq(nph_alloc(context, PHOTONS, 64, "photons", &map.photons), NPH_OK);
        ck_assert_int_eq(nph_alloc(context, PHOTONS, 64, "nodes", &map.tree.nodes), NPH_OK);
        ck_assert_int_eq(nph_alloc(context, PHOTONS, 64, "items", &map.tree.items), NPH_OK);
        const double p[3] = {0.5, 0.45, 0.52};
        for (uint32_t seed = 0; seed < MAPS; seed++) {
            (precision == 32 ? photonmap_uniform_f32_base : photonmap_uniform_f64_base)(&map, seed);
            ck_assert_int_eq(nph_kd_build(context, &map.tree, NULL), NPH_OK);
            for (int c = 0; c < 6; c++)
                for (int printed = 0; printed < 2; printed++) {
                    double value = (precision == 32 ? photonmap_estimate_f32_base : photonmap_estimate_f64_base)(
                        &map, p, cases[c].nearest, cases[c].reach, printed);
                    sums[c][printed] += value;
                    squares[c][printed] += value * value;
                }
        }
        for (int c = 0; c < 6; c++) {
            double mean = sums[c][0] / MAPS, error = sqrt((squares[c][0] / MAPS - mean * mean) / MAPS);
            double printed = sums[c][1] / MAPS;
            printf("    f%d nearest %d within %g: %.4f +- %.4f, as printed %.4f\n", precision, cases[c].nearest,
                   cases[c].reach, mean, error, printed);
            ck_assert_double_le(fabs(mean - 1.0), 4.0 * error);
            /* where the k-th is nearly always found its share is 1 / (k - 1) */
            if (c == 4 || c == 5) ck_assert_double_gt(printed, mean);
            if (c == 5) ck_assert_double_le(fabs(printed - 40.0 / 39.0), 4.0 * error + 1e-3);
        }
        nph_free(context, map.photons);
        nph_free(context, map.tree.nodes);
        nph_free(context, map.tree.items);
        nph_test_context_close(context);
    }
}
END_TEST

static const char *scene_of(const char *medium) {
    static char text[1024];
    int length = snprintf(text, sizeof text, SCENE("%s", "type: constant, radiance: 1"), medium);
    ck_assert_int_lt(length, (int)sizeof text);
    return text;
}

START_TEST(optical_depths_are_the_integral_of_the_density) {
    static const char *const media[] = {
        "density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: 30, transform: [{scale: 0.4}, {rotate: "
        "{axis: [1, 2, 3], angle: 40}}]",
        "density: {file: ../data/gpl/rico32x37x26.txt, centring: cell, lookup: nearest}, extinction: 1",
        "box: [[-0.5, -0.5, -0.5], [0.5, 0.25, 0.5]], extinction: 2, transform: [{rotate: {axis: [1, 0, 0], angle: "
        "30}}]",
    };
    Maker m;
    maker_open(&m, scene_of(media[_i]), 64, 1, 0, NULL);
    double lo[3], hi[3], worst = 0.0, largest = 0.0;
    nph_scene_bounds(m.scene, lo, hi);
    for (uint32_t i = 0; i < 60; i++) {
        NphWords a = nph_philox(5, 5, i, 0, 0, 0), b = nph_philox(5, 6, i, 0, 0, 0);
        double u[6] = {nph_uniform(a.w0), nph_uniform(a.w1), nph_uniform(a.w2),
                       nph_uniform(b.w0), nph_uniform(b.w1), nph_uniform(b.w2)};
        double ray[6], length = 0.0, range[2];
        for (int k = 0; k < 3; k++) {
            double size = hi[k] - lo[k];
            ray[k] = (u[k] - 0.5) * 1.6 * size;
            ray[3 + k] = i % 4 == 0 && k != (int)(i / 4 % 3) ? 0.0 : (u[3 + k] - 0.5) * size;
        }
        for (int k = 3; k < 6; k++) length += ray[k] * ray[k];
        for (int k = 3; k < 6; k++) ray[k] /= sqrt(length);
        range[0] = 0.1 * (hi[0] - lo[0]) * u[3];
        range[1] = range[0] + 1.5 * (hi[0] - lo[0]) * u[4];
        double depth = photonmap_depth_f64_base(m.memory, ray, range[0], range[1]),
               middle = 0.3 * range[0] + 0.7 * range[1];
        double parts = photonmap_depth_f64_base(m.memory, ray, range[0], middle) +
                       photonmap_depth_f64_base(m.memory, ray, middle, range[1]);
        double sum = photonmap_depth_sum_f64_base(m.memory, ray, range, 20000);
        ck_assert_double_le(fabs(depth - parts), 1e-11 * (1.0 + depth));
        worst = fabs(depth - sum) > worst ? fabs(depth - sum) : worst;
        largest = depth > largest ? depth : largest;
    }
    printf("    %d: largest difference %.3g of depths up to %.4g\n", _i, worst, largest);
    ck_assert_double_gt(largest, 0.0);
    ck_assert_double_le(worst, (_i == 0 ? 1e-6 : 3e-4) * largest); /* midpoint rule: steps of the density cost more */
    maker_close(&m);
}
END_TEST

/* Scenes for whole maps and pictures: chromatic overlapping media, a grid among them, every kind of light but a map. */
static const char *const scenes[] = {
    "nephos: 1\ncamera: {resolution: [20, 18], position: [-2, -1.5, 1.2], look_at: [0.5, 0.5, 0.5], fov: 40}\n"
    "media:\n"
    "  - {box: [[0, 0, 0], [1, 1, 1]], extinction: [2, 5, 0], albedo: [0.9, 1, 0.5], phase: {type: two_lobe, g: 0.8, "
    "g2: -0.3, weight: 0.7}}\n"
    "  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: [20, 30, 9], albedo: 0.99, phase: {type: "
    "rayleigh},\n"
    "     transform: [{scale: 0.4}, {rotate: {axis: [1, 2, 3], angle: 40}}, {translate: [0.5, 0.4, 0.5]}]}\n"
    "lights:\n  - {type: sun, direction: [1, 0.2, 1], irradiance: [3, 2, 1], angular_diameter: 5}\n"
    "  - {type: constant, radiance: 0.1}\n"
    "  - {type: point, position: [0.5, 0.5, 1.5], intensity: [1, 2, 3]}\n",
    "nephos: 1\ncamera: {type: flux, resolution: [20, 18], position: [0.5, 0.5, 1.5], direction: [0, 0, -1], up: [0, "
    "1, 0], extent: 1}\n"
    "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 4, albedo: 0.9, phase: {type: hg, g: 0.5}}\n"
    "lights:\n  - {type: sun, elevation: 40, azimuth: 10, irradiance: 1}\n  - {type: constant, radiance: 0.3}\n",
};

static const char *const small_map[] = {"photonmap.photons=2000", "photonmap.nearest=20"};

START_TEST(any_number_of_threads_makes_the_same_map) {
    static const int threads[] = {2, 3, 7};
    for (int precision = 32; precision <= 64; precision += 32) {
        Maker one, many;
        maker_open(&one, scenes[_i], precision, 1, 2, small_map);
        size_t photon = one.maker.kernels.photon_bytes();
        ck_assert_int_eq(nph_photonmap_make(&one.maker, 7), NPH_OK);
        ck_assert_int_gt(one.maker.map.tree.count, 1000);
        for (int t = 0; t < 3; t++) {
            maker_open(&many, scenes[_i], precision, threads[t], 2, small_map);
            ck_assert_int_eq(nph_photonmap_make(&many.maker, 3), NPH_OK); /* what was there before leaves no trace */
            ck_assert_int_eq(nph_photonmap_make(&many.maker, 7), NPH_OK);
            const NphPhotonMap *a = &one.maker.map, *b = &many.maker.map;
            ck_assert_int_eq(a->emitted, b->emitted);
            ck_assert_int_eq(a->scattered, b->scattered);
            ck_assert_int_eq(a->tree.count, b->tree.count);
            ck_assert(memcmp(a->photons, b->photons, photon * (size_t)a->tree.count) == 0);
            /* f64 nodes end in four bytes that mean nothing */
            size_t node = nph_kd_node_bytes(precision), means = precision == 32 ? 16 : 28;
            for (int32_t i = 0; i < a->tree.count; i++)
                ck_assert(memcmp((char *)a->tree.nodes + node * (size_t)i, (char *)b->tree.nodes + node * (size_t)i,
                                 means) == 0);
            maker_close(&many);
        }
        maker_close(&one);
    }
}
END_TEST

typedef struct Told {
    int lines;
    char last[512];
} Told;

static void hear(void *user, const char *text) {
    Told *told = user;
    told->lines++;
    snprintf(told->last, sizeof told->last, "%s", text);
}

START_TEST(tiles_and_replay_agree_to_the_bit) {
    for (int precision = 32; precision <= 64; precision += 32) {
        Maker m;
        maker_open(&m, scenes[_i], precision, 2, 2, small_map);
        ck_assert_int_eq(nph_photonmap_make(&m.maker, 5), NPH_OK);
        NphPhotonmapTile tile = {{0, 0, 16, 16}, {0, 0, 16, 16}, NULL};
        size_t count = (size_t)NPH_SAMPLE_FIELDS * NPH_TILE_PIXELS;
        ck_assert_int_eq(nph_alloc(m.context, count, 8, "image", &tile.image), NPH_OK);
        NphTally tally = {0, 0, 0, 0};
        m.maker.kernels.march(m.memory, &m.maker.map, &tile, &tally);
        int lit = 0;
        for (int pixel = 0; pixel < NPH_TILE_PIXELS; pixel += 3) {
            double fields[NPH_SAMPLE_FIELDS];
            m.maker.kernels.replay(m.memory, &m.maker.map, (int[2]){pixel % 16, pixel / 16}, NULL, NULL, fields);
            for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) {
                size_t at = (size_t)f * NPH_TILE_PIXELS + (size_t)pixel;
                double value = precision == 32 ? (double)((float *)tile.image)[at] : ((double *)tile.image)[at];
                ck_assert_msg(memcmp(&value, &fields[f], sizeof value) == 0, "field %d of pixel %d differs", f, pixel);
                lit += f == 0 && value > 0.0;
            }
        }
        ck_assert_int_gt(lit, 40);
        ck_assert_int_eq(tally.violations, 0);
        Told told = {0, ""};
        ck_assert_int_eq(nph_photonmap.replay(&m.job, 7, 9, 5, hear, &told), NPH_OK);
        ck_assert_int_ge(told.lines, 4);
        char expected[64];
        double red = precision == 32 ? (double)((float *)tile.image)[9 * 16 + 7] : ((double *)tile.image)[9 * 16 + 7];
        snprintf(expected, sizeof expected, "result: %.9g ", red);
        ck_assert_msg(strncmp(told.last, expected, strlen(expected)) == 0, "%s is not %s", told.last, expected);
        nph_free(m.context, tile.image);
        maker_close(&m);
    }
}
END_TEST

/* What it does not do is refused, by name. */
START_TEST(layers_are_refused) {
    NphContext *context = nph_test_context(1);
    const char *yaml =
        "nephos: 1\ncamera: {resolution: [8, 8], position: [0, 0, 9], look_at: [0, 0.1, 0], fov: 40}\n"
        "media:\n  - {name: haze, layer: [0, 1], extinction: 1}\nlights:\n  - {type: constant, radiance: 1}\n";
    NphScene *scene = NULL;
    ck_assert_int_eq(nph_scene_parse(context, yaml, strlen(yaml), "test.yaml", ".", &scene), NPH_OK);
    NphRenderOptions options;
    nph_render_options_default(&options);
    options.method = "photonmap";
    NphPlan plan;
    NphFilm *film = NULL;
    nph_test_messages();
    ck_assert_int_eq(nph_plan_make(context, scene, &options, &plan), NPH_BAD_SCENE);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "haze"));
    ck_assert_int_eq(nph_render(context, scene, &options, &film, NULL), NPH_BAD_SCENE);
    ck_assert_int_eq(nph_replay(context, scene, &options, 0, 0, 0, hear, NULL), NPH_BAD_SCENE);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *tests) {
    tcase_add_test(tests, in_a_white_furnace_all_media_scatter_four_pi_per_volume);
    tcase_add_test(tests, the_first_collisions_scatter_what_the_lights_send);
    tcase_add_test(tests, the_sky_of_a_map_sends_its_integral);
    tcase_add_test(tests, thinning_keeps_the_power_and_fills_the_room);
    tcase_add_test(tests, the_estimate_of_a_uniform_density_is_exact_in_the_mean);
    tcase_add_loop_test(tests, optical_depths_are_the_integral_of_the_density, 0, 3);
    tcase_add_loop_test(tests, any_number_of_threads_makes_the_same_map, 0, 2);
    tcase_add_loop_test(tests, tiles_and_replay_agree_to_the_bit, 0, 2);
    tcase_add_test(tests, layers_are_refused);
}

int main(void) { return nph_test_main("photonmap", fill); }
