/* SPDX-License-Identifier: Apache-2.0
 *
 * Photon mapping gives the same bytes for any number of threads and any split into ranges of samples, a full plan gives
 * those too, and memory is what the plan says: less fails without a leak, wherever it fails. */
#include <stdio.h>
#include <string.h>

#include "harness.h"
#include "render_case.h"

#define CAMERA                                                                                                         \
    "nephos: 1\ncamera: {resolution: [34, 19], position: [-2, -1.5, 1.2], look_at: [0.5, 0.5, 0.5], fov: 40, crop: "   \
    "[3, 2, 33, 18]}\n"

static const char *const scenes[] = {
    CAMERA "media:\n"
           "  - {box: [[0, 0, 0], [1, 1, 1]], extinction: [2, 5, 0], albedo: [0.9, 1, 0.5], phase: {type: two_lobe, g: "
           "0.8, g2: -0.3, weight: 0.7}}\n"
           "  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: [20, 30, 9], albedo: 0.99, phase: "
           "{type: rayleigh},\n"
           "     transform: [{scale: 0.4}, {rotate: {axis: [1, 2, 3], angle: 40}}, {translate: [0.5, 0.4, 0.5]}]}\n"
           "lights:\n  - {type: sun, direction: [1, 0.2, 1], irradiance: [3, 2, 1], angular_diameter: 5}\n"
           "  - {type: point, position: [0.5, 0.5, 1.5], intensity: [1, 2, 3]}\n",
    CAMERA "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 4, albedo: 0.9, phase: {type: hg, g: 0.5}}\n"
           "  - {box: [[0, 0, 0], [1, 1, 0.5]], extinction: 0}\n"
           "lights:\n  - {type: constant, radiance: 0.3}\n  - {type: sun, direction: [0, 1, 1], irradiance: 0}\n",
};

static const char *const knobs[] = {"photonmap.photons=700", "photonmap.nearest=12", "photonmap.step=1"};

static NphRenderOptions options_of(int64_t samples, int precision) {
    NphRenderOptions options = render_options(samples, precision);
    options.method = "photonmap";
    options.knob_count = 3;
    options.knobs = knobs;
    return options;
}

static void same_image(const NphImage *a, const NphImage *b, const char *what) {
    ck_assert_int_eq(a->channel_count, b->channel_count);
    size_t bytes = sizeof(float) * (size_t)a->width * (size_t)a->height;
    for (int c = 0; c < a->channel_count; c++)
        ck_assert_msg(memcmp(a->channels[c].pixels, b->channels[c].pixels, bytes) == 0, "%s: %s differs", what,
                      a->channels[c].name);
}

START_TEST(any_number_of_threads_gives_the_same_bytes) {
    static const int threads[] = {2, 3, 7};
    for (int precision = 32; precision <= 64; precision += 32) {
        RenderCase one, many;
        NphRenderOptions options = options_of(16, precision);
        render_case(&one, scenes[_i], &options, 1);
        ck_assert_double_gt(render_mean(&one, "R"), 0.0);
        for (int t = 0; t < 3; t++) {
            render_case(&many, scenes[_i], &options, threads[t]);
            same_image(&one.image, &many.image, render_text("f%d, %d threads", precision, threads[t]));
            render_free(&many);
        }
        options.plan_full = 1;
        render_case(&many, scenes[_i], &options, 2);
        same_image(&one.image, &many.image, "full plan");
        render_free(&many);
        render_free(&one);
    }
}
END_TEST

START_TEST(ranges_of_samples_merge_to_the_same_bytes) {
    RenderCase whole, part[3];
    NphFilm *films[3], *merged = NULL;
    static const char *const names[] = {"a", "b", "c"};
    static const int64_t ranges[] = {0, 16, 32, 48};
    NphRenderOptions options = options_of(48, 32);
    render_case(&whole, scenes[_i], &options, 2);
    for (int i = 0; i < 3; i++) {
        options.sample_begin = ranges[i];
        options.sample_end = ranges[i + 1];
        render_case(&part[i], scenes[_i], &options, 1 + i);
        films[i] = part[i].film;
    }
    NphImage image;
    ck_assert_int_eq(nph_film_merge(whole.context, 3, films, names, &merged), NPH_OK);
    ck_assert_int_eq(nph_film_image(whole.context, merged, &image), NPH_OK);
    same_image(&whole.image, &image, "merged");
    nph_image_free(whole.context, &image);
    nph_film_free(whole.context, merged);
    for (int i = 0; i < 3; i++) render_free(&part[i]);
    render_free(&whole);
}
END_TEST

static NphScene *parse(NphContext *context, const char *yaml) {
    NphScene *scene = NULL;
    NphStatus status =
        nph_scene_parse(context, yaml, strlen(yaml), "test.yaml", nph_test_path("reference/scenes"), &scene);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    return scene;
}

START_TEST(the_plan_names_the_memory_of_the_run) {
    NphRenderOptions options = options_of(16, 32);
    options.knobs = (const char *const[]){"photonmap.photons=200000", "photonmap.emitted=1000", "photonmap.step=1"};
    render_as_planned(scenes[1], &options);
}
END_TEST

START_TEST(a_refused_allocation_fails_the_run_without_a_leak) {
    NphRenderOptions options = options_of(16, 32);
    render_without_memory(scenes[1], &options);
}
END_TEST

/* The callback of progress asks to stop during the second chunk. */
typedef struct Stopper {
    NphContext *context;
    double at;
} Stopper;

static void stop(void *user, const char *task, double done, double total, double left) {
    Stopper *stopper = user;
    (void)task;
    (void)total;
    (void)left;
    if (done >= stopper->at) nph_interrupt(stopper->context);
}

START_TEST(an_interrupted_run_keeps_whole_chunks) {
    Stopper stopper = {NULL, 20};
    NphSettings settings;
    nph_settings_default(&settings);
    settings.threads = 2;
    settings.progress = stop;
    settings.user = &stopper;
    ck_assert_int_eq(nph_context_open(&stopper.context, &settings), NPH_OK);
    NphScene *scene = parse(stopper.context, scenes[0]);
    /* progress is throttled by time: the run is long enough for that */
    NphRenderOptions options = options_of(4096, 32);
    NphFilm *film = NULL;
    NphRenderStatistics statistics;
    ck_assert_int_eq(nph_render(stopper.context, scene, &options, &film, &statistics), NPH_INTERRUPTED);
    ck_assert_ptr_nonnull(film);
    ck_assert_int_gt(statistics.samples_per_pixel, 0);
    ck_assert_int_lt(statistics.samples_per_pixel, 4096);
    ck_assert_int_eq(statistics.samples_per_pixel % 16, 0);
    ck_assert_int_eq(statistics.noise.samples_min, statistics.noise.samples_max);
    nph_film_free(stopper.context, film);
    nph_scene_free(stopper.context, scene);
    nph_context_close(stopper.context);
}
END_TEST

static void fill(TCase *tests) {
    tcase_add_loop_test(tests, any_number_of_threads_gives_the_same_bytes, 0, 2);
    tcase_add_loop_test(tests, ranges_of_samples_merge_to_the_same_bytes, 0, 2);
    tcase_add_test(tests, the_plan_names_the_memory_of_the_run);
    tcase_add_test(tests, a_refused_allocation_fails_the_run_without_a_leak);
    tcase_add_test(tests, an_interrupted_run_keeps_whole_chunks);
}

int main(void) { return nph_test_main("photonmap_bytes", fill); }
