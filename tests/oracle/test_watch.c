/* SPDX-License-Identifier: Apache-2.0
 *
 * nephos/watch.h: runs looked at and changed between their stages. */
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>

#include "harness.h"
#include "nephos/nephos.h"

static const char scene_text[] =
    "nephos: 1\ncamera: {type: perspective, resolution: [18, 9], position: [-2, -1.5, 1.2], look_at: [0.5, 0.5, 0.5], fov: 40}\n"
    "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 6, albedo: 0.95, phase: {type: hg, g: 0.8}}\n"
    "lights:\n  - {type: sun, direction: [-1, 0.2, 0.3], irradiance: 3}\n  - {type: constant, radiance: 0.2}\n";

typedef struct Watcher {
    NphContext *context;
    const char *stage, *buffer;
    float factor;
    int64_t stop; /* at the so manieth launch of the stage */
    int wrong;    /* a value that is no place in memory */
    int seen;
    NphStatus outcome;
    double mean;
    int64_t nobody; /* items without identity */
} Watcher;

static NphScene *parse(NphContext *context) {
    NphScene *scene = NULL;
    ck_assert_int_eq(nph_scene_parse(context, scene_text, strlen(scene_text), "test.yaml", ".", &scene), NPH_OK);
    return scene;
}

/* Mean of the picture's red; the status in *status. */
static double render_by(const char *method, NphContext *context, const NphWatch *watch, NphStatus *status) {
    static const char *const few[] = {"photonmap.photons=500", "photonmap.step=1"},
                             *const generations[] = {"tpm.photons=500", "tpm.generations=2", "tpm.cells=64"},
                             *const grid[] = {"shdom.cells=4", "shdom.bands=2", "shdom.iterations=4"};
    int maps = strcmp(method, "photonmap") == 0, frames = strcmp(method, "temporal_photons") == 0, ordinates = strcmp(method, "shdom") == 0;
    NphRenderOptions options;
    NphFilm *film = NULL;
    NphImage image = {0};
    NphScene *scene = parse(context);
    double sum = 0.0;
    nph_render_options_default(&options);
    options.method = method;
    options.samples = 16;
    options.knob_count = maps ? 2 : frames || ordinates ? 3 : 0;
    options.knobs = frames ? generations : ordinates ? grid : few;
    *status = watch ? nph_render_watched(context, scene, &options, watch, &film, NULL) : nph_render(context, scene, &options, &film, NULL);
    if (*status == NPH_OK) {
        ck_assert_int_eq(nph_film_image(context, film, &image), NPH_OK);
        for (int i = 0; i < 18 * 9; i++) sum += (double)nph_image_channel(&image, "R")->pixels[i] / (18 * 9);
        nph_image_free(context, &image);
    }
    nph_film_free(context, film);
    nph_scene_free(context, scene);
    return sum;
}

static double render(NphContext *context, const NphWatch *watch, NphStatus *status) { return render_by("path", context, watch, status); }

static void put_wrong(NphArray *array, int wrong) {
    if (nph_array_count(array) == 0) return;
    if (array->type == NPH_I32) ((int32_t *)array->data)[0] = wrong;
    if (array->type == NPH_I64) ((int64_t *)array->data)[0] = wrong;
}

/* Reads a buffer and puts it back, times a factor. */
static NphStatus change(void *user, NphWatched *watched) {
    Watcher *w = user;
    NphWatchedLaunch launch = nph_watched_launch(watched);
    NphArray array = {0};
    if (strcmp(launch.stage, w->stage) != 0) return NPH_OK;
    w->seen++;
    if (w->stop && w->seen == w->stop) return NPH_INTERRUPTED;
    NphStatus status = nph_watched_read(watched, w->buffer, &array);
    if (status == NPH_OK && array.type == NPH_F32)
        for (int64_t i = 0; i < nph_array_count(&array); i++) ((float *)array.data)[i] *= w->factor;
    if (status == NPH_OK && array.type == NPH_F64)
        for (int64_t i = 0; i < nph_array_count(&array); i++) ((double *)array.data)[i] *= (double)w->factor;
    if (status == NPH_OK && w->wrong) put_wrong(&array, w->wrong);
    if (status == NPH_OK) status = nph_watched_write(watched, w->buffer, &array);
    nph_array_free(w->context, &array);
    return status;
}

/* Methods, and where their runs are looked into: a stage, and a buffer that it has just written. */
typedef struct Looked {
    const char *method, *places[12][2];
} Looked;

static const Looked looked[] = {
    {"path", {{"path.generate", "path.ray"}, {"path.track", "path.distance"}, {"path.track", "path.colliding"}, {"path.scatter", "path.weight"},
              {"path.shadow", "path.sample"}, {"path.accumulate", "film.node"}}},
    {"light", {{"light.emit", "light.power"}, {"light.emit", "light.place"}, {"light.trace", "light.flight"},
               {"light.trace", "light.flight_ray"}, {"light.trace", "light.waiting"}, {"light.connect", "light.splat_add"},
               {"light.splat", "light.image"}, {"light.see", "light.sample"}, {"light.accumulate", "film.node"}}},
    {"single", {{"single.generate", "single.ray"}, {"single.march", "single.transmittance"}, {"single.march", "single.scattered"},
                {"single.fold", "single.sample"}, {"single.accumulate", "film.node"}}},
    {"photonmap", {{"photonmap.pilot", "photonmap.count"}, {"photonmap.fill", "photonmap.emitted"}, {"photonmap.count", "photonmap.count"},
                   {"photonmap.scan", "photonmap.first"}, {"photonmap.trace", "photonmap.id"}, {"photonmap.trace", "photonmap.place"},
                   {"photonmap.trace", "photonmap.medium"}, {"photonmap.tree", "photonmap.node"}, {"photonmap.tree", "photonmap.node_photon"},
                   {"photonmap.tree", "photonmap.power"}, {"photonmap.march", "photonmap.image"}, {"photonmap.accumulate", "film.node"}}},
    {"shdom", {{"shdom.properties", "shdom.density"}, {"shdom.direct", "shdom.sun"}, {"shdom.sweep", "shdom.radiance"}, {"shdom.moments", "shdom.moments"},
               {"shdom.first", "shdom.source"}, {"shdom.scatter", "shdom.scattered"}, {"shdom.accelerate", "shdom.history"},
               {"shdom.finish", "shdom.field"}, {"shdom.march", "shdom.sample"}, {"shdom.accumulate", "film.node"}}},
    {"temporal_photons", {{"tpm.clear", "tpm.sum"}, {"tpm.trace", "tpm.partial"}, {"tpm.update", "tpm.sum"}, {"tpm.resolve", "tpm.coarse"},
                          {"tpm.upsample", "tpm.fine"}, {"tpm.march", "tpm.picture"}, {"tpm.enlarge", "tpm.image"},
                          {"tpm.accumulate", "film.node"}}},
    {"principal_ordinates", {{"pop.medium", "pop.medium"}, {"pop.ordinates", "pop.ordinate"}, {"pop.grids", "pop.density"}, {"pop.inject", "pop.light"},
                             {"pop.propagate", "pop.cosine"}, {"pop.propagate", "pop.seen"}, {"pop.propagate", "pop.power"}, {"pop.merge", "pop.merged"},
                             {"pop.march", "pop.sample"}, {"pop.accumulate", "film.node"}}},
};
enum { LOOKED = sizeof looked / sizeof *looked };

START_TEST(a_run_whose_buffers_are_read_and_put_back_is_the_same_run) {
    NphContext *context = nph_test_context(1);
    NphStatus status;
    double plain = render_by(looked[_i].method, context, NULL, &status);
    ck_assert_int_eq(status, NPH_OK);
    for (int p = 0; p < 12 && looked[_i].places[p][0]; p++) {
        Watcher w = {.context = context, .stage = looked[_i].places[p][0], .buffer = looked[_i].places[p][1], .factor = 1.0f};
        NphWatch watch = {&w, NULL, change};
        ck_assert_msg(render_by(looked[_i].method, context, &watch, &status) == plain, "%s, %s", w.stage, w.buffer);
        ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
        ck_assert_int_gt(w.seen, 0);
    }
    nph_test_context_close(context);
}
END_TEST

/* What brings light in proportion, and only some of it: of none, once and twice as much the picture is a straight line. */
START_TEST(light_that_is_written_is_light_in_the_picture) {
    static const char *const places[][3] = {{"light", "light.connect", "light.splat_add"}, {"single", "single.march", "single.part"},
                                            {"photonmap", "photonmap.trace", "photonmap.power"}, {"shdom", "shdom.finish", "shdom.field"}};
    NphContext *context = nph_test_context(1);
    NphStatus status;
    double mean[3];
    for (int k = 0; k < 3; k++) {
        Watcher w = {.context = context, .stage = places[_i][1], .buffer = places[_i][2], .factor = (float)k};
        NphWatch watch = {&w, NULL, change};
        mean[k] = render_by(places[_i][0], context, &watch, &status);
        ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    }
    printf("    %s: %g, %g, %g\n", places[_i][0], mean[0], mean[1], mean[2]);
    ck_assert_double_gt(mean[0], 0.0);
    ck_assert_double_gt(mean[1], 1.02 * mean[0]);
    ck_assert_double_lt(fabs(mean[2] - 2.0 * mean[1] + mean[0]), 1e-6 * mean[1]);
    nph_test_context_close(context);
}
END_TEST

/* Of the photons' names, those that are none: three where the map is not full. */
static NphStatus count_nobody(void *user, NphWatched *watched) {
    Watcher *w = user;
    NphWatchedLaunch launch = nph_watched_launch(watched);
    NphArray array = {0};
    if (strcmp(launch.stage, "photonmap.trace") != 0) return NPH_OK;
    NphStatus status = nph_watched_read(watched, "photonmap.id", &array);
    int64_t before = w->nobody, count = nph_array_count(&array);
    for (int64_t i = 0; status == NPH_OK && i < count; i++) w->nobody += ((int64_t *)array.data)[i] < 0;
    if (w->seen && count < 500) ck_assert_int_eq(w->nobody - before, 3);
    nph_array_free(w->context, &array);
    return status;
}

/* More room in the map than photons scatter: what follows the numbers stays empty. */
static NphStatus number_too_many(void *user, NphWatched *watched) {
    Watcher *w = user;
    NphWatchedLaunch launch = nph_watched_launch(watched);
    NphArray array = {0};
    if (strcmp(launch.stage, "photonmap.scan") != 0) return NPH_OK;
    NphStatus status = nph_watched_read(watched, "photonmap.first", &array);
    int64_t last = nph_array_count(&array) - 1;
    if (status == NPH_OK) ((int64_t *)array.data)[last] += 3;
    if (status == NPH_OK) status = nph_watched_write(watched, "photonmap.first", &array);
    nph_array_free(w->context, &array);
    return status;
}

static NphStatus number_then_count(void *user, NphWatched *watched) {
    NphStatus status = number_too_many(user, watched);
    return status == NPH_OK ? count_nobody(user, watched) : status;
}

START_TEST(places_that_no_photon_takes_are_empty) {
    double mean[2];
    for (int k = 0; k < 2; k++) {
        NphContext *context = nph_test_context(1 + 2 * k);
        NphStatus status;
        Watcher w = {.context = context};
        NphWatch plain = {&w, NULL, count_nobody}, watch = {&w, NULL, number_then_count};
        render_by("photonmap", context, &plain, &status);
        ck_assert_int_eq(w.nobody, 0);
        w.seen = 1;
        mean[k] = render_by("photonmap", context, &watch, &status);
        ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
        ck_assert_int_gt(w.nobody, 0);
        nph_test_context_close(context);
    }
    ck_assert(mean[0] == mean[1] && mean[0] > 0.0);
}
END_TEST

START_TEST(what_is_written_is_what_the_run_goes_on_with) {
    NphContext *context = nph_test_context(1);
    NphStatus status;
    double plain = render(context, NULL, &status);
    Watcher w = {.context = context, .stage = "path.generate", .buffer = "path.weight", .factor = 2.0f};
    NphWatch watch = {&w, NULL, change};
    double twice = render(context, &watch, &status);
    ck_assert_int_eq(status, NPH_OK);
    ck_assert_msg(fabs(twice - 2.0 * plain) < 0.02 * plain, "%g, %g", twice, plain); /* roulette looks at weights: not quite twice */
    w = (Watcher){.context = context, .stage = "path.accumulate", .buffer = "path.sample", .factor = 0.0f};
    watch = (NphWatch){&w, change, NULL};
    ck_assert(render(context, &watch, &status) == 0.0);
    nph_test_context_close(context);
}
END_TEST

START_TEST(what_cannot_be_is_refused_before_it_is_used) {
    NphContext *context = nph_test_context(1);
    NphStatus status;
    Watcher w = {.context = context, .stage = "path.track", .buffer = "path.colliding", .wrong = 1 << 30};
    NphWatch watch = {&w, NULL, change};
    render(context, &watch, &status);
    ck_assert_int_eq(status, NPH_BAD_INPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "path.colliding"));
    w = (Watcher){.context = context, .stage = "path.track", .buffer = "path.medium", .wrong = 77};
    render(context, &watch, &status);
    ck_assert_int_eq(status, NPH_BAD_INPUT);
    w = (Watcher){.context = context, .stage = "path.track", .buffer = "path.nothing"};
    render(context, &watch, &status);
    ck_assert_int_eq(status, NPH_BAD_USAGE);
    w = (Watcher){.context = context, .stage = "path.scatter", .buffer = "path.ray", .factor = 1.0f, .stop = 2};
    render(context, &watch, &status);
    ck_assert_int_eq(status, NPH_INTERRUPTED);
    ck_assert_int_eq(w.seen, 2);
    nph_test_context_close(context);
}
END_TEST

START_TEST(what_no_other_method_could_have_is_refused_too) {
    static const struct {
        const char *method, *stage, *buffer;
        float factor;
        int wrong;
    } tries[] = {
        {"light", "light.trace", "light.flight_medium", 1.0f, 77},
        {"light", "light.trace", "light.flight_ray", INFINITY, 0},
        {"light", "light.emit", "light.hero", 1.0f, 5},
        {"single", "single.generate", "single.ray", INFINITY, 0},
        {"shdom", "shdom.sweep", "shdom.radiance", INFINITY, 0},
        {"photonmap", "photonmap.fill", "photonmap.emitted", 1.0f, 1 << 30},
        {"photonmap", "photonmap.scan", "photonmap.first", 1.0f, 1},
        {"photonmap", "photonmap.trace", "photonmap.medium", 1.0f, 77},
        {"photonmap", "photonmap.trace", "photonmap.place", INFINITY, 0},
        {"photonmap", "photonmap.tree", "photonmap.node_photon", 1.0f, 500},
        {"photonmap", "photonmap.tree", "photonmap.node_axis", 1.0f, 3},
    };
    NphContext *context = nph_test_context(1);
    for (size_t t = 0; t < sizeof tries / sizeof *tries; t++) {
        NphStatus status;
        Watcher w = {
            .context = context, .stage = tries[t].stage, .buffer = tries[t].buffer, .factor = tries[t].factor, .wrong = tries[t].wrong};
        NphWatch watch = {&w, NULL, change};
        render_by(tries[t].method, context, &watch, &status);
        ck_assert_msg(status == NPH_BAD_INPUT, "%s took %s", tries[t].stage, tries[t].buffer);
        const char *said = nph_test_messages();
        ck_assert_msg(strstr(said, tries[t].buffer) != NULL, "%s", said);
    }
    nph_test_context_close(context);
}
END_TEST

static const char cloud_text[] =
    "nephos: 1\ncamera: {type: perspective, resolution: [18, 9], position: [-2, -1.5, 1.2], look_at: [0.5, 0.5, 0.5], fov: 40}\n"
    "media:\n  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: 20, albedo: 0.9}\n"
    "lights:\n  - {type: constant, radiance: 0.2}\n";

static NphStatus render_cloud(NphContext *context, const NphWatch *watch, NphRenderStatistics *statistics) {
    NphRenderOptions options;
    NphFilm *film = NULL;
    NphScene *scene = NULL;
    NphStatus status = nph_scene_parse(context, cloud_text, strlen(cloud_text), "cloud.yaml", nph_test_path("reference/scenes"), &scene);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    nph_render_options_default(&options);
    options.samples = 16;
    status = nph_render_watched(context, scene, &options, watch, &film, statistics);
    nph_film_free(context, film);
    nph_scene_free(context, scene);
    return status;
}

/* Twice the bounds: as many tentative collisions more. Half: what every density is compared with. */
START_TEST(bounds_that_are_written_are_the_ones_that_flights_walk) {
    NphContext *context = nph_test_context(2);
    NphRenderStatistics plain, looser, tighter;
    Watcher w = {.context = context, .stage = "path.majorant", .buffer = "path.bound", .factor = 1.0f};
    NphWatch watch = {&w, NULL, change};
    ck_assert_int_eq(render_cloud(context, &watch, &plain), NPH_OK);
    ck_assert_int_eq(w.seen, 1);
    w.factor = 0.5f; /* of empty cells, too: nearer ones are skipped to, 0.5 is no number of cells */
    ck_assert_int_eq(render_cloud(context, &watch, &tighter), NPH_BAD_INPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "is no bound"));
    w.buffer = "path.density"; /* of which bounds are made that are too low for the density that is looked up */
    watch = (NphWatch){&w, change, NULL};
    ck_assert_int_eq(render_cloud(context, &watch, &tighter), NPH_BAD_NUMBER);
    ck_assert_int_gt(tighter.majorant_violations, 0);
    w.factor = 2.0f;
    ck_assert_int_eq(render_cloud(context, &watch, &looser), NPH_OK);
    ck_assert_int_gt(looser.tentative, plain.tentative + plain.tentative / 2);
    nph_test_context_close(context);
}
END_TEST

static void *run(void *user) {
    Watcher *w = user;
    NphWatch watch = {w, change, NULL};
    NphSettings settings;
    nph_settings_default(&settings);
    settings.threads = 1;
    w->outcome = nph_context_open(&w->context, &settings);
    if (w->outcome != NPH_OK) return NULL;
    w->mean = render(w->context, &watch, &w->outcome);
    nph_context_close(w->context);
    return NULL;
}

START_TEST(two_contexts_in_two_threads_know_nothing_of_each_other) {
    Watcher both[2] = {{.stage = "path.accumulate", .buffer = "path.sample", .factor = 1.0f},
                       {.stage = "path.accumulate", .buffer = "path.sample", .factor = 4.0f}};
    pthread_t threads[2];
    for (int t = 0; t < 2; t++) ck_assert_int_eq(pthread_create(&threads[t], NULL, run, &both[t]), 0);
    for (int t = 0; t < 2; t++) ck_assert_int_eq(pthread_join(threads[t], NULL), 0);
    for (int t = 0; t < 2; t++) {
        Watcher alone = {.stage = both[t].stage, .buffer = both[t].buffer, .factor = both[t].factor};
        run(&alone);
        ck_assert_int_eq(both[t].outcome, NPH_OK);
        ck_assert(alone.mean == both[t].mean && alone.mean > 0.0);
    }
    ck_assert(both[1].mean == 4.0 * both[0].mean);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_loop_test(cases, a_run_whose_buffers_are_read_and_put_back_is_the_same_run, 0, LOOKED);
    tcase_add_loop_test(cases, light_that_is_written_is_light_in_the_picture, 0, 4);
    tcase_add_test(cases, places_that_no_photon_takes_are_empty);
    tcase_add_test(cases, what_no_other_method_could_have_is_refused_too);
    tcase_add_test(cases, what_is_written_is_what_the_run_goes_on_with);
    tcase_add_test(cases, what_cannot_be_is_refused_before_it_is_used);
    tcase_add_test(cases, bounds_that_are_written_are_the_ones_that_flights_walk);
    tcase_add_test(cases, two_contexts_in_two_threads_know_nothing_of_each_other);
}

int main(void) { return nph_test_main("watch", fill); }
