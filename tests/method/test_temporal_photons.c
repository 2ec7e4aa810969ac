/* SPDX-License-Identifier: Apache-2.0
 *
 * Temporally coherent photon mapping against closed forms and the path tracer: the fluence of its cells, its ledger, what it
 * promises about bytes, and extremes. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "field/sample.h"
#include "method/tpm_case.h"

START_TEST(in_a_white_furnace_every_cell_has_four_pi) {
    for (int precision = 32; precision <= 64; precision += 32) {
        Cache c;
        Means ours, truth = {.cells = 64};
        for (int i = 0; i <= 64; i++) truth.mean[i] = 4.0 * PI;
        cache_open(&c, SCENE(CAMERA, CUBE("3", "1", "0.6"), WHITE), precision, 2, PLAIN "tpm.photons=8000 tpm.generations=4");
        measure(&c, 24, &ours);
        compare("furnace", &ours, &truth, 0.003);
        cache_close(&c);
    }
}
END_TEST

START_TEST(a_sun_without_scattering_falls_by_beers_law_and_keeps_its_direction) {
    Cache c;
    Means ours, truth = {.cells = 64};
    cache_open(&c, SCENE(CAMERA, CUBE("3", "1e-9", "0.6"), SUN), 64, 2, PLAIN "tpm.photons=8000 tpm.generations=4 tpm.threshold=0");
    for (int i = 0; i <= 64; i++) {
        double from = i < 64 ? 0.25 * (i % 4) : 0.0, to = i < 64 ? from + 0.25 : 1.0;
        truth.mean[i] = 2.0 * (exp(-3.0 * from) - exp(-3.0 * to)) / (3.0 * (to - from));
    }
    measure(&c, 24, &ours);
    compare("Beer", &ours, &truth, 0.003);
    for (int i = 0; i < 64; i++) {
        ck_assert_double_eq_tol(value_of(&c, c.cache.coarse, i, NPH_TPM_I_G), 1.0, 1e-6);
        ck_assert_double_eq_tol(value_of(&c, c.cache.coarse, i, NPH_TPM_I_DEPTH), 0.0, 1e-6);
    }
    cache_close(&c);
}
END_TEST

/* A scene's media and lights, and the box of its medium cut into n^3 cells. Fluence of cells from planes of sensors in every layer: three
 * of Gauss, or many in even steps. */
typedef struct Probed {
    const char *name, *media, *lights, *knobs;
    int n, planes;
    double lo[3], edge, height; /* m: of the box, a square from above */
    double apart[4];            /* cells whose middles are nearer than apart[3] to a light are left out: fluence grows without end there */
} Probed;

static void plane_of(const Probed *probed, int k, double *at, double *weight) {
    static const double gauss[3] = {0.11270166537925831, 0.5, 0.88729833462074169}, weights[3] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
    *at = probed->planes == 3 ? gauss[k] : (k + 0.5) / probed->planes;
    *weight = probed->planes == 3 ? weights[k] : 1.0 / probed->planes;
}

static void probe_cells(const Probed *probed, const char *method, int spp, const unsigned char *left_out, Means *out) {
    static const char *const knobs[] = {"light.photons=512"};
    int n = probed->n, is_light = strcmp(method, "light") == 0;
    double layer = probed->height / n, half = 0.5 * probed->edge;
    memset(out, 0, sizeof *out);
    out->cells = n * n * n;
    for (int z = 0; z < n; z++)
        for (int k = 0; k < probed->planes; k++) {
            RenderCase seen;
            double at, weight;
            NphRenderOptions options = render_options(spp, 64);
            plane_of(probed, k, &at, &weight);
            options.seed_given = 1;
            options.seed = (uint32_t)(100 + probed->planes * z + k);
            options.method = method;
            options.knob_count = is_light;
            options.knobs = knobs;
            render_case(&seen, render_text("nephos: 1\ncamera: {type: fluence, resolution: [%d, %d], position: [%.17g, %.17g, %.17g], direction: [0, 0, -1], "
                                           "up: [0, 1, 0], extent: %.17g}\nmedia:\n  - {%s}\nlights:\n%s", n, n, probed->lo[0] + half,
                                           probed->lo[1] + half, probed->lo[2] + (z + at) * layer, probed->edge, probed->media, probed->lights),
                        &options, 2);
            const NphChannel *mean = nph_image_channel(&seen.image, "R"), *variance = nph_image_channel(&seen.image, "Variance.R");
            for (int i = 0; i < n * n; i++) {
                int cell = (z * n + n - 1 - i / n) * n + i % n;
                if (left_out[cell]) continue;
                out->mean[cell] += weight * (double)mean->pixels[i];
                out->variance[cell] += weight * weight * (double)variance->pixels[i];
            }
            render_free(&seen);
        }
    for (int i = 0; i < out->cells; i++) {
        out->mean[out->cells] += out->mean[i] / out->cells;
        out->variance[out->cells] += out->variance[i] / ((double)out->cells * out->cells);
    }
}

static void against(const Probed *probed, int path_samples, int light_samples, double precise) {
    Cache c;
    Means ours, truth;
    char knobs[512];
    int n = probed->n;
    snprintf(knobs, sizeof knobs, "tpm.similarity=0 tpm.threshold=0 tpm.cells_x=%d tpm.cells_y=%d tpm.cells_z=%d %s", n, n, n, probed->knobs);
    cache_open(&c, render_text("nephos: 1\ncamera: {" CAMERA "}\nmedia:\n  - {%s}\nlights:\n%s", probed->media, probed->lights), 32, 2, knobs);
    for (int i = 0; i < n * n * n; i++) {
        double d[3] = {(i % n + 0.5) * probed->edge / n, (i / n % n + 0.5) * probed->edge / n, (i / (n * n) + 0.5) * probed->height / n}, square = 0.0;
        for (int a = 0; a < 3; a++) square += pow(probed->lo[a] + d[a] - probed->apart[a], 2.0);
        c.left_out[i] = square < probed->apart[3] * probed->apart[3];
    }
    measure(&c, 32, &ours);
    probe_cells(probed, "path", path_samples, c.left_out, &truth);
    compare(render_text("%s, path", probed->name), &ours, &truth, precise);
    probe_cells(probed, "light", light_samples, c.left_out, &truth);
    compare(render_text("%s, light", probed->name), &ours, &truth, precise);
    cache_close(&c);
}

#define RICO "density: {file: ../data/gpl/rico122x106x39.txt, centring: cell, lookup: trilinear}, transform: [{translate: [10, 10, -420]}, " \
             "{scale: [1, 1.1509433962264151, 1]}], extinction: 1, albedo: 1, phase: {type: hg, g: 0.85}"

START_TEST(without_shortcuts_the_fluence_of_cells_is_that_of_path_and_light) {
    static const char *const photons = "tpm.photons=10000 tpm.generations=5";
    const Probed probed[] = {
        {"cube, g 0", CUBE("4", "1", "0"), SUN, photons, 4, 3, {0.0, 0.0, 0.0}, 1.0, 1.0, {0.0}},
        {"cube, g 0.7", CUBE("4", "1", "0.7"), SUN, photons, 4, 3, {0.0, 0.0, 0.0}, 1.0, 1.0, {0.0}},
        {"cube, g 0.96", CUBE("20", "0.99", "0.96"), SUN WHITE, photons, 4, 3, {0.0, 0.0, 0.0}, 1.0, 1.0, {0.0}},
        {"sphere", "density: {file: ../data/sphere/sphere.npy, box: [[-1, -1, -1], [1, 1, 1]]}, extinction: 0.011764705882352941, albedo: 0.99, "
         "phase: {type: hg, g: 0.3}", "  - {type: point, position: [0.3, 0.2, 0.4], intensity: 1}\n", photons, 8, 6, {-1.0, -1.0, -1.0}, 2.0, 2.0,
         {0.3, 0.2, 0.4, 0.45}},
        {"rico, as wide as it is long", RICO, "  - {type: sun, direction: [-1, -1, 1.41421], irradiance: 3.14159}\n"
         "  - {type: constant, radiance: 0.18}\n", photons, 8, 12, {0.0, 0.0, 0.0}, 2440.0, 1560.0, {0.0}},
    };
    static const int path_samples[] = {4096, 4096, 4096, 2048, 512}, light_samples[] = {256, 256, 256, 64, 64};
    static const double precise[] = {0.005, 0.005, 0.005, 0.005, 0.01};
    if (!nph_test_statistics("temporal photons against path and light")) return;
    against(&probed[_i], path_samples[_i], light_samples[_i], precise[_i]);
}
END_TEST

/* Each order on its own, and the three together. The march adds one. */
START_TEST(orders_of_scattering_are_the_whole_in_parts) {
    static const char *const knobs[] = {"tpm.orders=0", "tpm.orders=1", "tpm.orders=2", "tpm.orders=3"};
    double part[4][64], deep[4][64];
    for (int k = 0; k < 4; k++) {
        Cache c;
        char all[256];
        snprintf(all, sizeof all, PLAIN "tpm.photons=8000 tpm.generations=1 %s", knobs[k]);
        cache_open(&c, SCENE(CAMERA, CUBE("4", "1", "0.7"), SUN), 64, 2, all);
        ck_assert_int_eq(nph_tpm_cache_make(&c.cache, 0), NPH_OK);
        for (int i = 0; i < 64; i++) part[k][i] = fluence_of(&c, i);
        for (int i = 0; i < 64; i++) deep[k][i] = value_of(&c, c.cache.coarse, i, NPH_TPM_I_DEPTH);
        cache_close(&c);
    }
    for (int i = 0; i < 64; i++) {
        ck_assert_double_gt(part[1][i], 0.0);
        ck_assert_double_eq_tol(part[1][i] + part[2][i] + part[3][i], part[0][i], 1e-9 * part[0][i]);
        ck_assert_double_eq_tol(deep[1][i], 0.0, 1e-9);
        ck_assert_double_eq_tol(deep[2][i], 1.0, 1e-9);
        ck_assert_double_gt(deep[3][i], 2.0 - 1e-9);
    }
}
END_TEST

static void ledger_of(const char *yaml, int precision, const char *knobs, NphTpmLedger *ledger) {
    Cache c;
    cache_open(&c, yaml, precision, 3, knobs);
    ck_assert_int_eq(nph_tpm_cache_make(&c.cache, 0), NPH_OK);
    nph_tpm_cache_ledger(&c.cache, ledger);
    cache_close(&c);
}

#define GREY    CUBE("8", "0.9", "0.8")
#define COLOURS CUBE("8", "[0.9, 1, 0.3]", "0.8")
#define PUFF    "density: {file: ../data/sphere/sphere.npy, box: [[0, 0, 0], [1, 1, 1]]}, extinction: 0.05, albedo: [1, 0.8, 0.95], phase: {type: hg, g: 0.5}"

/* Entries are rounded to half a unit each: as many as there are photons and scatterings. Beams add up what they lose event by
 * event, which f32 does to its own precision. */
START_TEST(what_photons_carry_is_escaped_or_absorbed_and_what_beams_carry_collides_or_leaves) {
    static const char *const scenes[] = {SCENE(CAMERA, GREY, SUN WHITE), SCENE(CAMERA, COLOURS, SUN WHITE), SCENE(CAMERA, PUFF, SUN)};
    for (int i = 0; i < 3; i++)
        for (int precision = 32; precision <= 64; precision += 32) {
            NphTpmLedger l;
            ledger_of(scenes[i], precision, PLAIN "tpm.similarity=0.3 tpm.photons=4000 tpm.generations=2", &l);
            double rounds = 0.5 * (double)(l.photons + 2 * l.beams), walks = (double)(l.emitted - l.escaped - l.absorbed - l.stopped);
            double beams = (double)(l.begun - l.collided - l.past - l.cut), own = precision == 32 ? 1e-6 * (double)l.begun : 0.0;
            printf("    scene %d f%d: %lld photons, %lld beams; walks are %.0f units off, beams %.0f of %lld\n", i, precision,
                   (long long)l.photons, (long long)l.beams, walks, beams, (long long)l.begun);
            ck_assert_int_gt(l.escaped, 0);
            ck_assert_int_gt(l.collided, 0);
            ck_assert(i < 2 || l.cut > 0); /* in a box the first event takes all */
            ck_assert_int_eq(l.overflow + l.nonfinite, 0);
            ck_assert_double_le(fabs(walks), rounds + own);
            ck_assert_double_le(fabs(beams), rounds + own);
        }
}
END_TEST

static void same_pictures(const NphImage *a, const NphImage *b, const char *what) {
    size_t bytes = sizeof(float) * (size_t)a->width * (size_t)a->height;
    ck_assert_int_eq(a->channel_count, b->channel_count);
    for (int c = 0; c < a->channel_count; c++)
        ck_assert_msg(memcmp(a->channels[c].pixels, b->channels[c].pixels, bytes) == 0, "%s: %s differs", what, a->channels[c].name);
}

static NphRenderOptions options_of(int precision, int count, const char *const *knobs) {
    NphRenderOptions options = render_options(16, precision);
    options.method = "temporal_photons";
    options.knob_count = count;
    options.knobs = knobs;
    return options;
}

static const char *const few[] = {"tpm.photons=600", "tpm.generations=3", "tpm.cells=200", "tpm.noise=0.5", "tpm.similarity=0.3"};
#define TILES "resolution: [37, 21], position: [-2, -2, 0.9], look_at: [0.5, 0.5, 0.5], fov: 40"

START_TEST(any_number_of_threads_and_a_full_plan_give_the_same_bytes) {
    static const char *const scenes[] = {SCENE(TILES, COLOURS, SUN WHITE), SCENE(TILES, PUFF, SUN WHITE)};
    static const int threads[] = {2, 3, 7};
    int quick = getenv("NEPHOS_TEST_QUICK") != NULL;
    for (int i = 0; i < 2; i++)
        for (int precision = 32; precision <= 64; precision += 32) {
            RenderCase one, other;
            NphRenderOptions options = options_of(precision, 5, few);
            if (quick && (i == 0) != (precision == 32)) continue; /* either precision and scene once */
            render_case(&one, scenes[i], &options, 1);
            ck_assert_double_gt(render_mean(&one, "R"), 0.01);
            for (int t = quick ? 1 : 0; t < 4; t += quick ? 2 : 1) {
                options.plan_full = t == 3;
                render_case(&other, scenes[i], &options, threads[t % 3]);
                same_pictures(&one.image, &other.image, t == 3 ? "full plan" : "threads");
                render_free(&other);
            }
            render_free(&one);
        }
}
END_TEST

START_TEST(a_crop_shows_the_pixels_of_the_whole_picture) {
    RenderCase whole, part;
    NphRenderOptions options = options_of(32, 5, few);
    render_case(&whole, SCENE(TILES, PUFF, SUN WHITE), &options, 2);
    options.crop_given = 1;
    memcpy(options.crop, (const int[4]){7, 5, 30, 18}, sizeof options.crop);
    render_case(&part, SCENE(TILES, PUFF, SUN WHITE), &options, 2);
    const float *a = nph_image_channel(&whole.image, "R")->pixels, *b = nph_image_channel(&part.image, "R")->pixels;
    int width = whole.image.width, narrow = part.image.width;
    for (int y = 5; y < 18; y++)
        for (int x = 7; x < 30; x++)
            ck_assert_msg(!(a[y * width + x] < b[narrow == width ? y * width + x : (y - 5) * narrow + x - 7] ||
                            a[y * width + x] > b[narrow == width ? y * width + x : (y - 5) * narrow + x - 7]),
                          "pixel %d,%d", x, y);
    render_free(&part);
    render_free(&whole);
}
END_TEST

/* A frame is the sum of its generations, each a function of its number: from one frame to the next the newest joins and the oldest
 * leaves, wherever the sequence is entered. */
START_TEST(the_next_frame_is_the_last_with_one_generation_exchanged) {
    enum { M = 3, VALUES = 64 * NPH_TPM_KINDS * NPH_TPM_VALUES };
    static int64_t frame[2][VALUES], single[M + 1][VALUES];
    for (int i = 0; i < 2 + M + 1; i++) {
        Cache c;
        cache_open(&c, SCENE(CAMERA, GREY, SUN WHITE), 32, 2, PLAIN "tpm.photons=900 tpm.generations=3");
        c.cache.job.frame = (uint32_t)(i < 2 ? 1000000 + i : 1000000 + i - 2 - (M - 1));
        if (i >= 2) { /* one generation, in the units of all */
            c.cache.choice.first = 0;
            c.cache.choice.generations = 1;
        }
        ck_assert_int_eq(nph_tpm_cache_make(&c.cache, 5), NPH_OK);
        memcpy(i < 2 ? frame[i] : single[i - 2], c.cache.sums, sizeof frame[0]);
        cache_close(&c);
    }
    ck_assert_int_ne(memcmp(frame[0], frame[1], sizeof frame[0]), 0);
    for (int i = 0; i < VALUES; i++) ck_assert_int_eq(frame[1][i], frame[0][i] - single[0][i] + single[M][i]);
}
END_TEST

/* Far inside a thick medium light has diffused: reduced by 1 - g it goes as far as it did, by the root it does not. */
START_TEST(similarity_keeps_the_fluence_and_the_printed_root_does_not) {
    static const char *const knobs[] = {"tpm.similarity=0", "tpm.similarity=0.05", "tpm.similarity=0.05 tpm.variant=1"};
    double deep[3], error[3];
    if (!nph_test_statistics("similarity")) return;
    for (int k = 0; k < 3; k++) {
        Cache c;
        Means means;
        char all[256];
        int at = (1 * 4 + 1) * 4 + 3; /* the far side */
        snprintf(all, sizeof all, "tpm.cells_x=4 tpm.cells_y=4 tpm.cells_z=4 tpm.photons=6000 tpm.generations=2 %s", knobs[k]);
        cache_open(&c, SCENE(CAMERA, CUBE("60", "1", "0.9"), SUN), 32, 2, all);
        measure(&c, 16, &means);
        deep[k] = means.mean[at];
        error[k] = sqrt(means.variance[at]);
        printf("    far side, %s: %.4f +- %.4f\n", knobs[k], deep[k], error[k]);
        cache_close(&c);
    }
    ck_assert_double_lt(fabs(deep[1] - deep[0]), 4.0 * hypot(error[0], error[1]) + 0.03 * deep[0]);
    ck_assert_double_gt(fabs(deep[2] - deep[0]), 0.15 * deep[0]);
}
END_TEST

/* The picture of a furnace is as bright as its sky, with every kind of upsampling, marched to the end in small steps. */
START_TEST(a_furnace_is_white_whatever_the_upsampling) {
    static const char *const upsampling[] = {"tpm.upsampling=0", "tpm.upsampling=1", "tpm.upsampling=2"};
    if (!nph_test_statistics("furnace of pictures")) return;
    for (int u = 0; u < 3; u++) {
        const char *knobs[] = {upsampling[u], "tpm.photons=20000", "tpm.generations=2", "tpm.cells=200", "tpm.exit=0", "tpm.threshold=0.001"};
        RenderCase render;
        NphRenderOptions options = options_of(32, 6, knobs);
        render_case(&render, SCENE(TILES, "density: {file: ../data/sphere/sphere.npy, box: [[0, 0, 0], [1, 1, 1]]}, extinction: 0.03, phase: {type: hg, g: 0.5}", WHITE),
                    &options, 2);
        double mean = render_mean(&render, "R"), error = render_error(&render, "R");
        printf("    %s: %.5f +- %.5f\n", upsampling[u], mean, error);
        fflush(stdout);
        ck_assert_double_lt(error, 0.003);
        ck_assert_double_lt(fabs(mean - 1.0), 4.0 * error + 1e-4);
        render_free(&render);
    }
}
END_TEST

#define AT(medium, lights) SCENE("resolution: [8, 8], position: [-2, -2, 0.5], look_at: [0.5, 0.5, 0.5], fov: 30", medium, lights)
#define NOTHING "nephos: 1\ncamera: {resolution: [8, 8], position: [-2, -2, 0.5], look_at: [0.5, 0.5, 0.5], fov: 30}\nlights:\n"
#define UP "  - {type: sun, direction: [0, 0, 1], irradiance: 2}\n"
#define LEVEL "  - {type: sun, direction: [1, 0, 0], irradiance: 2}\n"
#define BELOW "  - {type: sun, direction: [0.3, 0, -1], irradiance: 2}\n"

START_TEST(extremes_stay_finite_and_say_so) {
    static const char *const scenes[] = {
        AT(CUBE("4", "1", "0"), SUN), AT(CUBE("400", "1", "0.9999"), SUN), AT(CUBE("4", "1", "-0.9"), SUN), AT(CUBE("0", "1", "0"), SUN),
        AT(CUBE("1e6", "0.5", "0.3"), SUN WHITE), AT(PUFF, UP), AT(PUFF, LEVEL), AT(PUFF, BELOW), AT(CUBE("4", "0", "0.5"), SUN WHITE),
        AT(CUBE("4", "1", "0.5"), "  - {type: point, position: [0.5, 0.5, 0.5], intensity: 1}\n"),
        (NOTHING SUN),
    };
    static const char *const sets[][5] = {{"tpm.photons=1", "tpm.generations=1", "tpm.cells=1", "tpm.steps=10", "tpm.noise=0"},
                                          {"tpm.photons=300", "tpm.generations=2", "tpm.cells=64", "tpm.variant=1", "tpm.steps=50"},
                                          {"tpm.photons=300", "tpm.generations=2", "tpm.cells=5000", "tpm.noise=2", "tpm.sky_lobe=1"}};
    int quick = getenv("NEPHOS_TEST_QUICK") != NULL;
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++)
        for (int k = 0; k < 3; k++)
            for (int precision = 32; precision <= 64; precision += 32) {
                RenderCase render;
                if (quick && (k != 1 || precision == 64)) continue;
                NphRenderOptions options = options_of(precision, 5, sets[k]);
                options.frame = k == 2 ? 1000000 : 0;
                NphStatus status = render_try(&render, scenes[i], &options, 2);
                ck_assert_msg(status == NPH_OK, "scene %zu, set %d: %s", i, k, nph_test_messages());
                ck_assert_int_eq(render.statistics.nonfinite, 0);
                ck_assert_double_ge(render_mean(&render, "R"), 0.0);
                render_free(&render);
            }
}
END_TEST

START_TEST(without_a_medium_the_sky_is_seen) {
    RenderCase render;
    NphRenderOptions options = options_of(32, 0, NULL);
    render_case(&render, NOTHING WHITE, &options, 2);
    ck_assert_double_eq_tol(render_mean(&render, "R"), 1.0, 1e-7);
    render_free(&render);
}
END_TEST

START_TEST(what_the_method_cannot_do_is_refused_by_name) {
    static const struct {
        const char *scene, *says;
    } cases[] = {
        {AT("box: [[0, 0, 0], [1, 1, 1]], extinction: [1, 2, 3]", SUN), "extinction differs"},
        {AT("box: [[0, 0, 0], [1, 1, 1]], extinction: 1, phase: {type: rayleigh}", SUN), "phase function hg"},
        {AT("box: [[0, 0, 0], [1, 1, 1]], extinction: 1}\n  - {box: [[0, 0, 0], [1, 1, 2]], extinction: 2", SUN), "one medium"},
        {AT("layer: [0, 1], extinction: 1", SUN), "layer"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        RenderCase render;
        NphRenderOptions options = options_of(32, 0, NULL);
        ck_assert_int_eq(render_try(&render, cases[i].scene, &options, 1), NPH_BAD_SCENE);
        const char *messages = nph_test_messages();
        ck_assert_msg(strstr(messages, cases[i].says) != NULL, "%s", messages);
        render_free(&render);
    }
}
END_TEST

START_TEST(the_plan_names_the_memory_of_the_run) {
    const char *knobs[] = {"tpm.photons=300", "tpm.generations=1", "tpm.steps=10"};
    NphRenderOptions options = options_of(32, 3, knobs);
    render_as_planned(SCENE(TILES, PUFF, SUN WHITE), &options);
}
END_TEST

START_TEST(memory_that_is_refused_anywhere_leaves_nothing_behind) {
    const char *knobs[] = {"tpm.photons=30", "tpm.generations=1", "tpm.steps=10", "tpm.cells=8"};
    NphRenderOptions options = options_of(32, 4, knobs);
    render_without_memory(AT(PUFF, SUN), &options);
}
END_TEST

/* Scattering after which a photon goes ten thousand times as far, and still scatters often: more than one photon is given room for. */
START_TEST(a_deposit_that_does_not_fit_fails_the_run) {
    const char *knobs[] = {"tpm.photons=1", "tpm.generations=1", "tpm.cells=1", "tpm.similarity=1"};
    RenderCase render;
    NphRenderOptions options = options_of(64, 4, knobs);
    ck_assert_int_eq(render_try(&render, AT(CUBE("1e6", "1", "0.9999"), SUN), &options, 1), NPH_BAD_NUMBER);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "do not fit"));
    render_free(&render);
}
END_TEST

/* Where hardly anything is scattered twice the lobe is the beam: the picture is that of single scattering, seen from anywhere. */
START_TEST(a_thin_cloud_is_as_bright_as_single_scattering_from_every_side) {
    static const char *const eyes[] = {"-3, 0.5, 0.5", "0.5, -3, 0.5", "4, 0.5, 0.5"};
    const char *knobs[] = {"tpm.photons=40000", "tpm.generations=2", "tpm.cells=64", "tpm.half=0", "tpm.upsampling=0"};
    if (!nph_test_statistics("thin cloud")) return;
    for (int e = 0; e < 3; e++) {
        RenderCase ours, truth;
        const char *scene = render_text("nephos: 1\ncamera: {resolution: [16, 16], position: [%s], look_at: [0.5, 0.5, 0.5], fov: 30}\n"
                                        "media:\n  - {" CUBE("0.01", "1", "0.6") "}\nlights:\n" SUN, eyes[e]);
        NphRenderOptions options = options_of(32, 5, knobs), single = render_options(64, 32);
        single.method = "single";
        options.samples = 64;
        render_case(&ours, scene, &options, 2);
        render_case(&truth, scene, &single, 2);
        double a = render_mean(&ours, "R"), b = render_mean(&truth, "R"),
               error = hypot(render_error(&ours, "R"), render_error(&truth, "R"));
        printf("    from %s: %.6g +- %.2g, single %.6g\n", eyes[e], a, error, b);
        /* 1%: orders above the first, of optical depth 0.01 */
        ck_assert_double_lt(fabs(a - b), 4.0 * error + 0.01 * b);
        ck_assert_double_lt(error, 0.01 * b);
        render_free(&truth);
        render_free(&ours);
    }
}
END_TEST

/* A dark box straight ahead is as far from the left as from the right, and from the top as from the bottom. */
START_TEST(half_the_resolution_shifts_nothing) {
    const char *knobs[] = {"tpm.half=1"};
    RenderCase render;
    NphRenderOptions options = options_of(32, 1, knobs);
    double sides[4] = {0.0};
    if (!nph_test_statistics("half the resolution")) return;
    options.samples = 256;
    render_case(&render, SCENE("resolution: [16, 16], position: [0.5, -3, 0.5], look_at: [0.5, 0.5, 0.5], fov: 40", CUBE("50", "0", "0"), WHITE),
                &options, 2);
    const float *pixels = nph_image_channel(&render.image, "R")->pixels;
    for (int i = 0; i < 256; i++) {
        sides[i % 16 < 8] += (double)pixels[i];
        sides[2 + (i / 16 < 8)] += (double)pixels[i];
    }
    printf("    left and right %.4f %.4f, below and above %.4f %.4f\n", sides[1], sides[0], sides[2], sides[3]);
    /* half a pixel would move 8 of them from side to side by as much as the box covers */
    ck_assert_double_lt(fabs(sides[0] - sides[1]), 0.4);
    ck_assert_double_lt(fabs(sides[2] - sides[3]), 0.4);
    render_free(&render);
}
END_TEST

static double density_at(const Cache *c, const double p[3]) {
    const NphGrid *grid = &c->scene->media[0].grid;
    const void *const at[3] = {&p[0], &p[1], &p[2]};
    double density;
    ck_assert_int_eq(nph_grid_sample(c->context, grid, 64, 1, at, &density), NPH_OK);
    return density / (double)grid->max;
}

/* The formulas at the head of tpm_4_upsample_kernel.c, as they stand there. */
static void upsampled(const Cache *c, const int at[3], int paper, double out[2]) {
    const NphMedium *medium = &c->scene->media[0];
    double sum = 0.0, fluence = 0.0, cosine = 0.0, bent = 0.0, size[3], p[3], q[3], own, radius = 1e30, g = medium->phase.g[0];
    int middle[3], cell[3];
    for (int a = 0; a < 3; a++) {
        size[a] = (medium->grid.hi[a] - medium->grid.lo[a]) / c->choice.cells[a];
        p[a] = medium->grid.lo[a] + (at[a] + 0.5) * (medium->grid.hi[a] - medium->grid.lo[a]) / c->choice.fine[a];
        middle[a] = (int)((p[a] - medium->grid.lo[a]) / size[a]);
        radius = fmin(radius, 1.5 / c->choice.cells[a]); /* the box is the unit cube */
    }
    own = density_at(c, p);
    /* the depth at p: between the middles of eight cells */
    double depth = 0.0;
    for (int k = 0; k < 8; k++) {
        double share = 1.0;
        for (int a = 0; a < 3; a++) {
            double u = fmin(fmax((p[a] - medium->grid.lo[a]) / size[a] - 0.5, 0.0), c->choice.cells[a] - 1.0), low = floor(u);
            cell[a] = (int)fmin(low + (k >> a & 1), c->choice.cells[a] - 1.0);
            share *= k >> a & 1 ? u - low : 1.0 - (u - low);
        }
        depth += share * value_of(c, c->cache.coarse, ((int64_t)cell[2] * c->choice.cells[1] + cell[1]) * c->choice.cells[0] + cell[0], NPH_TPM_I_DEPTH);
    }
    for (int k = 0; k < 27; k++) {
        double squared = 0.0;
        int outside = 0;
        for (int a = 0, rest = k; a < 3; a++, rest /= 3) {
            cell[a] = middle[a] + rest % 3 - 1;
            outside |= cell[a] < 0 || cell[a] >= c->choice.cells[a];
            q[a] = medium->grid.lo[a] + (cell[a] + 0.5) * size[a];
            double off = (p[a] - q[a]) / (medium->grid.hi[a] - medium->grid.lo[a]);
            squared += off * off;
        }
        if (outside) continue;
        int64_t number = ((int64_t)cell[2] * c->choice.cells[1] + cell[1]) * c->choice.cells[0] + cell[0];
        double other = density_at(c, q), d = sqrt(squared), sigma = medium->extinction_per_m[0] * (double)medium->grid.max * medium->albedo[0];
        double tau = 0.5 * sigma * (paper ? own - other : own + other), x = tau * radius, weight = 0.0;
        if (d < radius)
            weight = fabs(x) < 1e-3 ? 2.0 * (radius - d) / (radius * radius)
                                    : tau * (exp(-tau * d) - exp(-x)) / (1.0 - exp(-x)) / (1.0 - x * exp(-x) / (1.0 - exp(-x)));
        weight *= fmax(1.0 - fabs(own - other), 0.0);
        double delta = depth - value_of(c, c->cache.coarse, number, NPH_TPM_I_DEPTH);
        double fall = paper ? pow(g, delta) : exp(-(1.0 - g) * delta);
        sum += weight;
        bent += weight * fall;
        fluence += weight * value_of(c, c->cache.coarse, number, NPH_TPM_I_SUN);
        cosine += weight * fall * value_of(c, c->cache.coarse, number, NPH_TPM_I_G);
    }
    out[0] = fluence / sum;
    out[1] = fmin(fmax(cosine / (paper ? bent : sum), -1.0), 1.0);
}

START_TEST(upsampled_cells_are_what_the_formulas_say) {
    for (int paper = 0; paper < 2; paper++) {
        Cache c;
        int compared = 0;
        cache_open(&c, SCENE(CAMERA, "density: {file: ../data/sphere/sphere.npy, box: [[0, 0, 0], [1, 1, 1]]}, extinction: 0.05, albedo: 0.9, phase: {type: hg, g: 0.5}", SUN),
                   64, 2, paper ? "tpm.photons=20000 tpm.generations=1 tpm.cells=216 tpm.variant=1" : "tpm.photons=20000 tpm.generations=1 tpm.cells=216");
        ck_assert_int_eq(nph_tpm_cache_make(&c.cache, 0), NPH_OK);
        for (int i = 0; i < 400; i++) {
            int at[3] = {(i * 7 + 3) % 48, (i * 11 + 5) % 48, (i * 13 + 1) % 48};
            double p[3], want[2], got[2];
            int64_t cell = ((int64_t)at[2] * c.choice.fine[1] + at[1]) * c.choice.fine[0] + at[0];
            ck_assert_int_eq(c.choice.fine[0], 48);
            for (int a = 0; a < 3; a++) p[a] = c.scene->media[0].grid.lo[a] + at[a] + 0.5;
            if (!(density_at(&c, p) > 0.0)) continue;
            upsampled(&c, at, paper, want);
            got[0] = value_of(&c, c.cache.fine, cell, NPH_TPM_I_SUN);
            got[1] = value_of(&c, c.cache.fine, cell, NPH_TPM_I_G);
            for (int k = 0; k < 2; k++) /* in print tau can be next to 0, where the limit above is good to tau r */
                ck_assert_msg(fabs(got[k] - want[k]) < 1e-3 * (paper ? 1.0 : 1e-3) * fmax(fabs(want[k]), 1e-3), "%d %d %d, %s, %d: %.12g is not %.12g",
                              at[0], at[1], at[2], paper ? "paper" : "corrected", k, got[k], want[k]);
            compared++;
        }
        printf("    %s: %d cells\n", paper ? "paper" : "corrected", compared);
        ck_assert_int_gt(compared, 100);
        cache_close(&c);
    }
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, in_a_white_furnace_every_cell_has_four_pi);
    tcase_add_test(cases, a_sun_without_scattering_falls_by_beers_law_and_keeps_its_direction);
    tcase_add_loop_test(cases, without_shortcuts_the_fluence_of_cells_is_that_of_path_and_light, 0, 5);
    tcase_add_test(cases, orders_of_scattering_are_the_whole_in_parts);
    tcase_add_test(cases, what_photons_carry_is_escaped_or_absorbed_and_what_beams_carry_collides_or_leaves);
    tcase_add_test(cases, any_number_of_threads_and_a_full_plan_give_the_same_bytes);
    tcase_add_test(cases, a_crop_shows_the_pixels_of_the_whole_picture);
    tcase_add_test(cases, the_next_frame_is_the_last_with_one_generation_exchanged);
    tcase_add_test(cases, similarity_keeps_the_fluence_and_the_printed_root_does_not);
    tcase_add_test(cases, a_furnace_is_white_whatever_the_upsampling);
    tcase_add_test(cases, extremes_stay_finite_and_say_so);
    tcase_add_test(cases, without_a_medium_the_sky_is_seen);
    tcase_add_test(cases, what_the_method_cannot_do_is_refused_by_name);
    tcase_add_test(cases, the_plan_names_the_memory_of_the_run);
    tcase_add_test(cases, a_deposit_that_does_not_fit_fails_the_run);
    tcase_add_test(cases, a_thin_cloud_is_as_bright_as_single_scattering_from_every_side);
    tcase_add_test(cases, half_the_resolution_shifts_nothing);
    tcase_add_test(cases, upsampled_cells_are_what_the_formulas_say);
    tcase_add_test(cases, memory_that_is_refused_anywhere_leaves_nothing_behind);
}

int main(void) { return nph_test_main("temporal_photons", fill); }
