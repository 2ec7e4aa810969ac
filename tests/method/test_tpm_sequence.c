/* SPDX-License-Identifier: Apache-2.0
 *
 * Temporal photons over time: a frame has the same bytes alone and within a sequence; its cache does not drift; generations may have
 * any number of photons, and see the scene as it was. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "method/tpm_case.h"
#include "nephos/stage.h"

#define SMALL "resolution: [19, 13], position: [-2, -2, 0.9], look_at: [0.5, 0.5, 0.5], fov: 40"
#define MOVED "resolution: [19, 13], position: {frames: [0, 8], values: [[-2, -2, 0.9], [-2, -1, 0.7]]}, look_at: [0.5, 0.5, 0.5], fov: 40"
#define GREY CUBE("4", "0.9", "0.7")
#define DENSER CUBE("{frames: [2, 7], values: [2, 6]}", "0.9", "0.7")
#define TURNING "  - {type: sun, direction: {frames: [0, 10], values: [[-1, 0, 0.2], [-0.5, 0.6, 0.2]]}, irradiance: {frames: [0, 10], values: [2, 3]}}\n"

enum { M = 4 };
static const char *const few[] = {"tpm.photons=400", "tpm.generations=4", "tpm.cells=100", "tpm.vary=0.5"};

START_TEST(a_frame_has_the_same_bytes_alone_and_within_a_sequence) {
    static const char *const scenes[] = {SCENE(SMALL, GREY, SUN WHITE), SCENE(MOVED, DENSER, TURNING WHITE)};
    static const uint32_t order[] = {2, 3, 4, 6, 12, 1, 2};
    static const int missing[] = {M, 1, 1, 2, M, M, 1};
    for (int s = 0; s < 2; s++)
        for (int precision = 32; precision <= 64; precision += 32) {
            Frames frames, other;
            NphSequence *sequence = NULL;
            frames_open(&frames, scenes[s], precision, 2, 4, few);
            frames_open(&other, scenes[s], precision, 3, 4, few);
            ck_assert_int_eq(nph_scene_is_animated(frames.scene), s);
            ck_assert_int_eq(nph_sequence_open(frames.context, frames.scene, &frames.options, &sequence), NPH_OK);
            double last = 0.0;
            for (int i = 0; i < 7; i++) {
                NphImage single, within;
                NphFilm *film = NULL;
                NphRenderStatistics of_one, of_sequence;
                ck_assert_int_eq(nph_sequence_render(sequence, order[i], &film, &of_sequence), NPH_OK);
                ck_assert_int_eq(nph_film_image(frames.context, film, &within), NPH_OK);
                alone(&other, order[i], &single, &of_one);
                same_image(&single, &within, order[i]);
                /* what was kept was not traced again: with tpm.vary a generation has half to one and a half times 100 photons, more as the sun brightens */
                ck_assert_int_eq(photons_of(&of_sequence) == photons_of(&of_one), missing[i] == M);
                ck_assert_int_le(photons_of(&of_sequence), 16 * 230 * missing[i]);
                ck_assert_int_ge(photons_of(&of_sequence), 16 * 48 * missing[i]);
                ck_assert_double_ne(mean_of(&within), last);
                last = mean_of(&within);
                nph_image_free(frames.context, &within);
                nph_image_free(other.context, &single);
                nph_film_free(frames.context, film);
            }
            nph_sequence_close(sequence);
            frames_close(&other);
            frames_close(&frames);
        }
}
END_TEST

/* The newest generation joins I and the oldest leaves, `frames` times; out: I then, and the I of the last frame made anew. */
static void exchange(Cache *c, int frames, int64_t *exchanged, int64_t *anew) {
    enum { RING = 10, VALUES = NPH_TPM_KINDS * 4 * NPH_TPM_VALUES };
    static int64_t ring[RING][VALUES];
    ck_assert_int_eq(c->choice.generations, RING);
    ck_assert_int_eq(c->cache.values, VALUES);
    memset(ring, 0, sizeof ring);
    ck_assert_int_eq(nph_tpm_cache_step(&c->cache, NPH_TPM_CLEAR), NPH_OK);
    for (int f = 0; f < frames; f++) {
        c->cache.job.frame = (uint32_t)f;
        ck_assert_int_eq(nph_tpm_cache_enter(&c->cache, RING - 1), NPH_OK);
        ck_assert_int_eq(nph_tpm_cache_step(&c->cache, NPH_TPM_TRACE), NPH_OK);
        c->cache.old = ring[f % RING];
        ck_assert_int_eq(nph_tpm_cache_step(&c->cache, NPH_TPM_UPDATE), NPH_OK);
        memcpy(ring[f % RING], c->cache.partial, sizeof ring[0]);
    }
    memcpy(exchanged, c->cache.sums, sizeof ring[0]);
    c->cache.old = NULL;
    ck_assert_int_eq(nph_tpm_cache_make(&c->cache, 0), NPH_OK);
    memcpy(anew, c->cache.sums, sizeof ring[0]);
}

START_TEST(whole_numbers_do_not_drift_and_the_floats_of_the_print_do) {
    enum { VALUES = NPH_TPM_KINDS * 4 * NPH_TPM_VALUES };
    int frames = getenv("NEPHOS_TEST_QUICK") ? 2000 : 100000;
    for (int paper = 0; paper < 2; paper++) {
        Cache c;
        int64_t exchanged[VALUES], anew[VALUES];
        double drift = 0.0;
        cache_open(&c, SCENE(CAMERA, GREY, SUN WHITE), 32, 1, paper ? "tpm.photons=40 tpm.generations=10 tpm.cells_x=2 tpm.cells_y=2 tpm.cells_z=1 tpm.variant=1"
                                                                  : "tpm.photons=40 tpm.generations=10 tpm.cells_x=2 tpm.cells_y=2 tpm.cells_z=1");
        exchange(&c, frames, exchanged, anew);
        ck_assert_int_ne(anew[0], 0);
        for (int i = 0; i < VALUES; i++)
            drift = fmax(drift, fabs((double)exchanged[i] - (double)anew[i]) / fmax(fabs((double)anew[i]), 1.0));
        printf("    %s: after %d frames I is %.3g of a cell off\n", paper ? "floats" : "whole numbers", frames, drift);
        if (paper) ck_assert_double_gt(drift, 1e-7);
        else ck_assert_int_eq(memcmp(exchanged, anew, sizeof anew), 0);
        cache_close(&c);
    }
}
END_TEST

/* A generation whose flux is no number fails its frame and is not in the cache; when it has left nothing tells of it. */
START_TEST(what_is_no_number_is_reported_and_leaves_nothing_in_the_cache) {
    enum { RING = 3, VALUES = NPH_TPM_KINDS * 4 * NPH_TPM_VALUES };
    int64_t ring[RING][VALUES], sums[VALUES];
    Cache c;
    memset(ring, 0, sizeof ring);
    cache_open(&c, SCENE(CAMERA, GREY, SUN WHITE), 32, 2, "tpm.photons=600 tpm.generations=3 tpm.cells_x=2 tpm.cells_y=2 tpm.cells_z=1");
    ck_assert_int_eq(nph_tpm_cache_step(&c.cache, NPH_TPM_CLEAR), NPH_OK);
    for (int f = 0; f < 9; f++) {
        c.cache.job.frame = (uint32_t)f;
        ck_assert_int_eq(nph_tpm_cache_enter(&c.cache, RING - 1), NPH_OK);
        if (f == 4) c.cache.now.relative[NPH_TPM_SUN] = (double)NAN;
        NphStatus status = nph_tpm_cache_step(&c.cache, NPH_TPM_TRACE);
        ck_assert_int_eq(status, f == 4 ? NPH_BAD_NUMBER : NPH_OK);
        if (f == 4) {
            ck_assert_ptr_nonnull(strstr(nph_test_messages(), "deposits are not finite"));
            memset(c.cache.ledgers, 0, sizeof *c.cache.ledgers * 2);
        }
        c.cache.old = ring[f % RING];
        ck_assert_int_eq(nph_tpm_cache_step(&c.cache, NPH_TPM_UPDATE), NPH_OK);
        memcpy(ring[f % RING], c.cache.partial, sizeof ring[0]);
        memcpy(sums, c.cache.sums, sizeof sums);
        c.cache.old = NULL;
        ck_assert_int_eq(nph_tpm_cache_make(&c.cache, 0), NPH_OK);
        if (f >= RING - 1) ck_assert_int_eq(memcmp(sums, c.cache.sums, sizeof sums) == 0, f < 4 || f > 4 + RING - 1);
        memcpy(c.cache.sums, sums, sizeof sums);
    }
    cache_close(&c);
}
END_TEST

START_TEST(generations_of_any_size_have_the_same_mean) {
    Cache c;
    Means ours, truth = {.cells = 64};
    int64_t least = INT64_MAX, most = 0;
    for (int i = 0; i <= 64; i++) truth.mean[i] = 4.0 * PI;
    cache_open(&c, SCENE(CAMERA, CUBE("3", "1", "0.6"), WHITE), 32, 2, PLAIN "tpm.photons=8000 tpm.generations=4 tpm.vary=0.9");
    for (int g = 0; g < 4; g++) {
        ck_assert_int_eq(nph_tpm_cache_enter(&c.cache, g), NPH_OK);
        least = c.cache.now.photons[NPH_TPM_SKY] < least ? c.cache.now.photons[NPH_TPM_SKY] : least;
        most = c.cache.now.photons[NPH_TPM_SKY] > most ? c.cache.now.photons[NPH_TPM_SKY] : most;
    }
    ck_assert_int_gt(most, least + 500);
    measure(&c, 24, &ours);
    compare("furnace", &ours, &truth, 0.003);
    cache_close(&c);
}
END_TEST

/* Once all generations have seen it, a light twice as bright is a light twice as bright, of twice as many photons. */
START_TEST(brighter_lights_have_more_photons_that_carry_the_same) {
    static const char *const knobs[] = {"tpm.photons=40000", "tpm.generations=4", "tpm.cells=27"};
    static const char *const scenes[] = {SCENE(SMALL, GREY, "  - {type: sun, direction: [-1, 0.1, 0.2], irradiance: {frames: [3, 4], values: [1.5, 3]}}\n"),
                                         SCENE(SMALL, GREY, "  - {type: sun, direction: [-1, 0.1, 0.2], irradiance: 3}\n")};
    double mean[2];
    int64_t photons[2];
    for (int s = 0; s < 2; s++) {
        Frames frames;
        NphImage image;
        NphRenderStatistics statistics;
        frames_open(&frames, scenes[s], 32, 2, 3, knobs);
        alone(&frames, 8, &image, &statistics);
        mean[s] = mean_of(&image);
        photons[s] = photons_of(&statistics);
        nph_image_free(frames.context, &image);
        frames_close(&frames);
    }
    printf("    means %.5f and %.5f, photons %lld and %lld\n", mean[0], mean[1], (long long)photons[0], (long long)photons[1]);
    ck_assert_int_eq(photons[0], 2 * photons[1]);
    ck_assert_double_le(fabs(mean[0] / mean[1] - 1.0), 0.004);
}
END_TEST

/* As bright as where it was always so. */
static void expect_settled(const char *what, const char *changed, const char *still, double most) {
    static const char *const knobs[] = {"tpm.photons=100000", "tpm.generations=4", "tpm.cells_x=3", "tpm.cells_y=3", "tpm.cells_z=3"};
    double mean[2];
    for (int s = 0; s < 2; s++) {
        Frames frames;
        NphImage image;
        frames_open(&frames, s ? still : changed, 32, 2, 5, knobs);
        alone(&frames, 8, &image, NULL);
        mean[s] = mean_of(&image);
        nph_image_free(frames.context, &image);
        frames_close(&frames);
    }
    printf("    %s: %.6f, always so %.6f\n", what, mean[0], mean[1]);
    ck_assert_double_le(fabs(mean[0] / mean[1] - 1.0), most);
}

/* Deposits of another medium and other cells than the reference frame's come in its units. Of the first the photons are the same, of the second
 * there are more. */
START_TEST(what_has_changed_since_the_reference_frame_is_as_bright_as_if_it_had_always_been_so) {
    if (!nph_test_statistics("changes that have settled")) return;
    expect_settled("denser", SCENE(SMALL, CUBE("{frames: [3, 4], values: [2, 8]}", "0.9", "0.7"), SUN WHITE), SCENE(SMALL, CUBE("8", "0.9", "0.7"), SUN WHITE), 1e-5);
    expect_settled("larger", SCENE(SMALL, "box: {frames: [3, 4], values: [[[0, 0, 0], [1, 1, 1]], [[0, 0, 0], [1, 1, 1.5]]]}, extinction: 4, albedo: 0.9", SUN),
                   SCENE(SMALL, "box: [[0, 0, 0], [1, 1, 1.5]], extinction: 4, albedo: 0.9", SUN), 0.003);
}
END_TEST

/* At frame 6 three of four generations are of the sun that has gone out, whose side they still tell. All frames
 * have the same random numbers, of camera rays too. */
START_TEST(light_of_a_sun_that_has_gone_out_keeps_its_side) {
    static const char *const knobs[] = {"tpm.photons=40000", "tpm.generations=4", "tpm.cells=27"};
    static const char dusk[] = SCENE(SMALL, GREY, "  - {type: sun, direction: [1, 1, 0.2], irradiance: {frames: [5, 6], values: [2, 0]}}\n");
    double mean[2];
    for (uint32_t f = 0; f < 2; f++) {
        Frames frames;
        NphImage image;
        frames_open(&frames, dusk, 32, 2, 3, knobs);
        frames.options.lock_noise = 1;
        alone(&frames, 5 + f, &image, NULL);
        mean[f] = mean_of(&image);
        nph_image_free(frames.context, &image);
        frames_close(&frames);
    }
    printf("    lit %.5f, a quarter gone %.5f\n", mean[0], mean[1]);
    ck_assert_double_le(fabs(mean[1] / mean[0] - 0.75), 0.002);
}
END_TEST

START_TEST(a_sequence_that_begins_with_nothing_has_the_bytes_of_its_frames) {
    static const char *const knobs[] = {"tpm.photons=400", "tpm.generations=4", "tpm.cells=100", "tpm.primed=0", "tpm.impostors=1", "tpm.light=0.25"};
    Frames frames;
    NphSequence *sequence = NULL;
    frames_open(&frames, SCENE(MOVED, DENSER, TURNING WHITE), 32, 2, 6, knobs);
    ck_assert_int_eq(nph_sequence_open(frames.context, frames.scene, &frames.options, &sequence), NPH_OK);
    for (uint32_t frame = 0; frame < 7; frame++) {
        NphImage single, within;
        NphFilm *film = NULL;
        ck_assert_int_eq(nph_sequence_render(sequence, frame, &film, NULL), NPH_OK);
        ck_assert_int_eq(nph_film_image(frames.context, film, &within), NPH_OK);
        alone(&frames, frame, &single, NULL);
        same_image(&single, &within, frame);
        nph_image_free(frames.context, &within);
        nph_image_free(frames.context, &single);
        nph_film_free(frames.context, film);
    }
    nph_sequence_close(sequence);
    frames_close(&frames);
}
END_TEST

/* tpm.update by itself, with and without a generation that leaves. */
START_TEST(the_exchange_of_a_generation_runs_alone) {
    enum { VALUES = NPH_TPM_KINDS * 4 * NPH_TPM_VALUES };
    static const char *const knobs[] = {"tpm.photons=60", "tpm.generations=3", "tpm.cells_x=2", "tpm.cells_y=2", "tpm.cells_z=1"};
    static const char *const names[] = {"tpm.partial", "tpm.sum", "tpm.old"};
    const int64_t shape[5] = {NPH_TPM_KINDS, 1, 2, 2, NPH_TPM_VALUES}, arguments[NPH_TPM_ARGUMENTS] = {0, 1, 0};
    NphNamedArray inputs[3], outputs[NPH_MAX_BUFFERS];
    NphStages *stages = NULL;
    Frames frames;
    frames_open(&frames, SCENE(SMALL, GREY, SUN WHITE), 32, 1, 5, knobs);
    ck_assert_int_eq(nph_stages_open(frames.context, frames.scene, &frames.options, &stages), NPH_OK);
    for (int i = 0; i < 3; i++) {
        inputs[i].name = names[i];
        ck_assert_int_eq(nph_array_new(frames.context, NPH_I64, 5, shape, names[i], &inputs[i].array), NPH_OK);
        for (int64_t v = 0; v < VALUES; v++) ((int64_t *)inputs[i].array.data)[v] = (v + 1) * (i == 0 ? 1000000007 : i == 1 ? 99991 : 31);
    }
    for (int given = 3; given >= 2; given--) {
        int count = 0;
        ck_assert_int_eq(nph_stages_run(stages, "tpm.update", arguments, given, inputs, &count, outputs), NPH_OK);
        ck_assert_int_eq(count, 1);
        for (int64_t v = 0; v < VALUES; v++)
            ck_assert_int_eq(((int64_t *)outputs[0].array.data)[v], (v + 1) * (1000000007 + 99991 - (given == 3 ? 31 : 0)));
        nph_array_free(frames.context, &outputs[0].array);
    }
    for (int i = 0; i < 3; i++) nph_array_free(frames.context, &inputs[i].array);
    nph_stages_close(stages);
    frames_close(&frames);
}
END_TEST

/* Between keys that are alike nothing happens. */
START_TEST(a_scene_whose_keys_are_all_alike_is_the_scene_that_stands_still) {
    static const char *const scenes[] = {SCENE(SMALL, GREY, "  - {type: sun, direction: [-1, 0.1, 0.2], irradiance: {frames: [0, 9], values: [3, 3]}}\n" WHITE),
                                         SCENE(SMALL, GREY, "  - {type: sun, direction: [-1, 0.1, 0.2], irradiance: 3}\n" WHITE)};
    NphImage image[2];
    Frames frames[2];
    for (int s = 0; s < 2; s++) {
        frames_open(&frames[s], scenes[s], 32, 2, 4, few);
        alone(&frames[s], 6, &image[s], NULL);
    }
    same_image(&image[0], &image[1], 6);
    for (int s = 0; s < 2; s++) {
        nph_image_free(frames[s].context, &image[s]);
        frames_close(&frames[s]);
    }
}
END_TEST

START_TEST(a_reference_frame_in_the_dark_is_refused_and_another_one_taken) {
    static const char *const knobs[] = {"tpm.photons=400", "tpm.generations=4", "tpm.cells=27", "tpm.reference=5"};
    static const char dusk[] = SCENE(SMALL, GREY, "  - {type: sun, direction: [-1, 0.1, 0.2], irradiance: {frames: [2, 6], values: [0, 3]}}\n");
    for (int given = 0; given < 2; given++) {
        Frames frames;
        NphFilm *film = NULL;
        NphScene *other = NULL;
        frames_open(&frames, dusk, 32, 2, 3 + given, knobs);
        frames.options.frame = 4;
        ck_assert_int_eq(nph_scene_at_frame(frames.context, frames.scene, 4, &other), NPH_OK);
        ck_assert_int_eq(nph_render(frames.context, other, &frames.options, &film, NULL), given ? NPH_OK : NPH_BAD_USAGE);
        if (!given) ck_assert_ptr_nonnull(strstr(nph_test_messages(), "tpm.reference takes the number of a frame"));
        nph_film_free(frames.context, film);
        nph_scene_free(frames.context, other);
        frames_close(&frames);
    }
}
END_TEST

START_TEST(a_plan_of_a_sequence_names_what_it_keeps_and_a_limit_refuses_it) {
    Frames frames;
    NphPlan plan;
    NphFilm *film = NULL;
    NphSequence *sequence = NULL;
    uint64_t kept = 0, single = 0;
    for (int together = 0; together < 2; together++) {
        frames_open(&frames, SCENE(SMALL, GREY, SUN WHITE), 32, 2, 4, few);
        frames.options.sequence = together;
        ck_assert_int_eq(nph_plan_make(frames.context, frames.scene, &frames.options, &plan), NPH_OK);
        for (int l = 0; l < plan.line_count; l++)
            if (strcmp(plan.lines[l].name, "tpm.old") == 0) kept = plan.lines[l].bytes;
        ck_assert_int_eq(kept > 0, together);
        if (!together) single = plan.bytes;
        else ck_assert_uint_ge(plan.bytes, single + kept);
        nph_plan_free(frames.context, &plan);
        frames_close(&frames);
    }
    NphSettings settings;
    NphContext *context = NULL;
    nph_settings_default(&settings);
    settings.threads = 2;
    settings.memory_limit_bytes = single + kept / 2;
    ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
    frames_open(&frames, SCENE(SMALL, GREY, SUN WHITE), 32, 2, 4, few);
    ck_assert_int_eq(nph_sequence_open(context, frames.scene, &frames.options, &sequence), NPH_OK);
    ck_assert_int_eq(nph_sequence_render(sequence, 0, &film, NULL), NPH_NO_MEMORY);
    nph_sequence_close(sequence);
    frames_close(&frames);
    nph_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, a_frame_has_the_same_bytes_alone_and_within_a_sequence);
    tcase_add_test(cases, whole_numbers_do_not_drift_and_the_floats_of_the_print_do);
    tcase_add_test(cases, what_is_no_number_is_reported_and_leaves_nothing_in_the_cache);
    tcase_add_test(cases, generations_of_any_size_have_the_same_mean);
    tcase_add_test(cases, brighter_lights_have_more_photons_that_carry_the_same);
    tcase_add_test(cases, what_has_changed_since_the_reference_frame_is_as_bright_as_if_it_had_always_been_so);
    tcase_add_test(cases, light_of_a_sun_that_has_gone_out_keeps_its_side);
    tcase_add_test(cases, a_sequence_that_begins_with_nothing_has_the_bytes_of_its_frames);
    tcase_add_test(cases, the_exchange_of_a_generation_runs_alone);
    tcase_add_test(cases, a_scene_whose_keys_are_all_alike_is_the_scene_that_stands_still);
    tcase_add_test(cases, a_reference_frame_in_the_dark_is_refused_and_another_one_taken);
    tcase_add_test(cases, a_plan_of_a_sequence_names_what_it_keeps_and_a_limit_refuses_it);
}

int main(void) { return nph_test_main("tpm_sequence", fill); }
