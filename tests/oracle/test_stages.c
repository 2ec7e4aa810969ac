/* SPDX-License-Identifier: Apache-2.0
 *
 * Dumps, and stages alone: every launch of every stage of every method, given the inputs that its run had, writes the bytes that
 * its run wrote. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "harness.h"
#include "method/registry.h"
#include "nephos/scene.h"
#include "oracle/manifest.h"
#include "staged.h"

/* Launches of each stage that were run again. */
static int replayed[MAX_METHODS][NPH_MAX_STAGES];

static NphScene *parse(NphContext *context, const char *text) {
    NphScene *scene = NULL;
    NphStatus status = nph_scene_parse(context, text, strlen(text), "test.yaml", nph_test_path("reference/scenes"), &scene);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    return scene;
}

static void remove_folder(const char *folder) {
    char command[4200];
    snprintf(command, sizeof command, "rm -r '%s'", folder);
    ck_assert_int_eq(system(command), 0);
}

/* 0 when the method refuses the scene. */
static int dump(NphContext *context, const NphScene *scene, const NphRenderOptions *options, const char *folder, NphManifest *manifest) {
    NphFilm *film = NULL;
    NphDumpOptions what;
    nph_dump_options_default(&what);
    what.folder = folder;
    NphStatus status = nph_dump(context, scene, "test.yaml", options, &what, &film, NULL);
    if (status == NPH_BAD_SCENE || status == NPH_BAD_USAGE) return 0;
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    nph_film_free(context, film);
    ck_assert_int_eq(nph_manifest_read(context, folder, manifest), NPH_OK);
    return 1;
}

static int same(const NphArray *a, const NphArray *b) {
    return a->type == b->type && a->rank == b->rank && memcmp(a->shape, b->shape, sizeof a->shape) == 0 &&
           (!nph_array_count(a) || memcmp(a->data, b->data, (size_t)nph_array_count(a) * nph_type_size(a->type)) == 0);
}

/* Runs one launch of a dump again; the number of outputs that differ. */
static int differing(NphContext *context, NphStages *stages, const NphManifest *manifest, const NphManifestLaunch *launch) {
    NphNamedArray inputs[NPH_MAX_BUFFERS], outputs[NPH_MAX_BUFFERS];
    int count = 0, different = 0;
    for (int i = 0; i < launch->input_count; i++) {
        inputs[i].name = launch->inputs[i].buffer;
        ck_assert_int_eq(nph_manifest_array(context, manifest, launch->inputs[i].file, &inputs[i].array), NPH_OK);
    }
    NphStatus status = nph_stages_run(stages, launch->stage, launch->arguments, launch->input_count, inputs, &count, outputs);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    ck_assert_int_eq(count, launch->output_count);
    for (int o = 0; o < count; o++) {
        NphArray written;
        ck_assert_str_eq(outputs[o].name, launch->outputs[o].buffer);
        ck_assert_int_eq(nph_manifest_array(context, manifest, launch->outputs[o].file, &written), NPH_OK);
        different += !same(&written, &outputs[o].array);
        if (!same(&written, &outputs[o].array)) printf("    %s: %s differs\n", launch->stage, outputs[o].name);
        nph_array_free(context, &written);
        nph_array_free(context, &outputs[o].array);
    }
    for (int i = 0; i < launch->input_count; i++) nph_array_free(context, &inputs[i].array);
    return different;
}

static void replay_launches(int method, NphContext *context, const NphScene *scene, const NphManifest *manifest) {
    NphRenderOptions again;
    NphStages *stages = NULL;
    nph_manifest_options(manifest, &again);
    ck_assert_int_eq(nph_stages_open(context, scene, &again, &stages), NPH_OK);
    for (int l = manifest->launch_count - 1; l >= 0; l--) { /* backwards: what earlier launches left in memory is not there */
        const NphManifestLaunch *launch = &manifest->launches[l];
        ck_assert_msg(differing(context, stages, manifest, launch) == 0, "batch %lld launch %lld %s", (long long)launch->batch,
                      (long long)launch->number, launch->stage);
        for (int s = 0; s < nph_stages_count(stages); s++)
            replayed[method][s] += strcmp(nph_stages_stage(stages, s).name, launch->stage) == 0;
    }
    nph_stages_close(stages);
}

/* Methods whose defaults are too much here, and the scene in which they have every stage; of others number 3. */
static const struct {
    const char *method;
    int scene, count;
    const char *knobs[6];
} few[] = {{"single", 3, 1, {"single.tolerance=0.05"}},
           {"photonmap", 6, 2, {"photonmap.photons=600", "photonmap.step=1"}},
           {"shdom", 7, 3, {"shdom.cells=4", "shdom.bands=2", "shdom.iterations=3"}},
           {"temporal_photons", 7, 4, {"tpm.photons=600", "tpm.generations=2", "tpm.cells=100", "tpm.steps=40"}},
           {"principal_ordinates", 8, 6, {"pop.ordinates=5", "pop.cells=6", "pop.iterations=3", "pop.residuum_iterations=2", "pop.vpls=4", "pop.rsm=5"}}};

enum { FEW = sizeof few / sizeof *few };

static int few_of(int method) {
    int f = 0;
    while (f < FEW && strcmp(few[f].method, nph_method(method)->name) != 0) f++;
    return f;
}

static int full_scene(int method) { return few_of(method) < FEW ? few[few_of(method)].scene : 3; }

static NphRenderOptions options_of(int method, int precision) {
    NphRenderOptions options;
    int f = few_of(method);
    nph_render_options_default(&options);
    options.method = nph_method(method)->name;
    options.samples = 16;
    options.precision = precision;
    options.knob_count = f < FEW ? few[f].count : 0;
    options.knobs = f < FEW ? few[f].knobs : NULL;
    return options;
}

static void replay(int method, const char *text, const NphRenderOptions *options) {
    NphContext *context = nph_test_context(2);
    NphScene *scene = parse(context, text);
    NphManifest manifest;
    const char *folder = nph_test_temporary("dump");
    if (dump(context, scene, options, folder, &manifest)) {
        replay_launches(method, context, scene, &manifest);
        nph_manifest_free(context, &manifest);
        remove_folder(folder);
    }
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}

START_TEST(a_stage_given_its_own_inputs_writes_its_own_outputs) {
    const NphMethod *method = nph_method(_i);
    int all = nph_test_statistics("stages alone in all scenes and f64");
    for (int s = 0; s < SCENES; s++)
        for (int precision = 32; precision <= 64; precision += 32) {
            NphRenderOptions options = options_of(_i, precision);
            int full = s == full_scene(_i);
            if (full ? all || precision == 32 : all ? s < 6 : precision == 32 && s == 2) replay(_i, scenes[s], &options); /* these have every stage */
        }
    for (int s = 0; s < method->stage_count; s++) {
        printf("    %s: %d launches\n", method->stages[s].name, replayed[_i][s]);
        ck_assert_msg(replayed[_i][s] > 0, "%s was never launched", method->stages[s].name);
    }
}
END_TEST

static int method_named(const char *name) {
    int method = 0;
    while (strcmp(nph_method(method)->name, name) != 0) method++;
    return method;
}

/* Photons that are split deep in a layer fill more than a launch's flights: some wait for the next one. */
START_TEST(photons_wait_for_room_and_go_on) {
    static const char *const knobs[] = {"light.photons=3000", "light.split=1"};
    int method = method_named("light"), parts = 0;
    NphContext *context = nph_test_context(2);
    NphScene *scene = parse(context,
                            "nephos: 1\ncamera: {type: flux, position: [0, 0, -0.1], direction: [0, 0, 1], extent: 1, resolution: [4, 2], up: [0, 1, 0]}\n"
                            "media:\n  - {layer: [0, 1], extinction: [9, 12, 15], albedo: 0.9, phase: {type: hg, g: 0.5}}\n"
                            "lights:\n  - {type: sun, direction: [1, 0.2, 1], irradiance: 3}\n");
    NphRenderOptions options = options_of(method, 32);
    NphManifest manifest;
    const char *folder = nph_test_temporary("dump");
    options.knobs = knobs;
    options.knob_count = 2;
    ck_assert(dump(context, scene, &options, folder, &manifest));
    for (int l = 1; l < manifest.launch_count; l++) {
        const NphManifestLaunch *launch = &manifest.launches[l];
        NphArray waiting;
        if (strcmp(launch->stage, "light.trace") != 0) continue;
        for (int i = 0; i < launch->input_count; i++) {
            if (strcmp(launch->inputs[i].buffer, "light.waiting") != 0) continue;
            ck_assert_int_eq(nph_manifest_array(context, &manifest, launch->inputs[i].file, &waiting), NPH_OK);
            parts += waiting.shape[1] > 1;
            nph_array_free(context, &waiting);
        }
    }
    ck_assert_int_gt(parts, 0);
    replay_launches(method, context, scene, &manifest);
    nph_manifest_free(context, &manifest);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
    remove_folder(folder);
}
END_TEST

/* The same launches, files and digests, whatever the threads. */
START_TEST(a_dump_does_not_depend_on_threads) {
    char *manifests[2] = {NULL, NULL};
    size_t sizes[2] = {0, 0};
    for (int k = 0; k < 2; k++) {
        NphContext *context = nph_test_context(1 + 2 * k);
        NphScene *scene = parse(context, scenes[full_scene(_i)]);
        NphRenderOptions options = options_of(_i, 32);
        NphManifest manifest;
        char path[4200];
        options.samples = _i == 0 ? 32 : 16;
        const char *folder = nph_test_temporary("threads");
        ck_assert(dump(context, scene, &options, folder, &manifest));
        snprintf(path, sizeof path, "%s/manifest.json", folder);
        FILE *file = fopen(path, "rb");
        manifests[k] = malloc(1 << 24);
        sizes[k] = fread(manifests[k], 1, 1 << 24, file);
        fclose(file);
        nph_manifest_free(context, &manifest);
        nph_scene_free(context, scene);
        nph_test_context_close(context);
        remove_folder(folder);
    }
    ck_assert_uint_gt(sizes[0], 10000);
    ck_assert_uint_eq(sizes[0], sizes[1]);
    ck_assert_int_eq(memcmp(manifests[0], manifests[1], sizes[0]), 0);
    free(manifests[0]);
    free(manifests[1]);
}
END_TEST

/* The picture is the same with and without a dump, and selections write a part of the files. */
START_TEST(a_selection_writes_its_launches_and_their_inputs) {
    NphContext *context = nph_test_context(2);
    NphScene *scene = parse(context, scenes[0]);
    NphRenderOptions options;
    NphDumpOptions what;
    NphManifest manifest;
    NphFilm *film = NULL;
    nph_render_options_default(&options);
    options.samples = 16;
    nph_dump_options_default(&what);
    what.folder = nph_test_temporary("selection");
    what.stage = "path.shadow";
    what.launch = 4;
    what.pixel_given = 1;
    what.pixel[0] = 17;
    what.pixel[1] = 3;
    ck_assert_int_eq(nph_dump(context, scene, "test.yaml", &options, &what, &film, NULL), NPH_BAD_USAGE);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "no launch of this run is among those to be written"));
    ck_assert_int_eq(nph_manifest_read(context, what.folder, &manifest), NPH_OK);
    ck_assert_int_eq(manifest.launch_count, 0); /* 0 generate, 1 track, 2 escape, 3 shadow, 4 scatter */
    nph_manifest_free(context, &manifest);
    remove_folder(what.folder);
    nph_film_free(context, film);
    what.launch = 3;
    ck_assert_int_eq(nph_dump(context, scene, "test.yaml", &options, &what, &film, NULL), NPH_OK);
    ck_assert_int_eq(nph_manifest_read(context, what.folder, &manifest), NPH_OK);
    ck_assert_int_eq(manifest.launch_count, 1);
    ck_assert_int_eq(manifest.launches[0].batch, 1);
    ck_assert_int_gt(manifest.launches[0].input_count, 7);
    NphStages *stages = NULL;
    ck_assert_int_eq(nph_stages_open(context, scene, &options, &stages), NPH_OK);
    ck_assert_int_eq(differing(context, stages, &manifest, &manifest.launches[0]), 0);
    nph_stages_close(stages);
    nph_manifest_free(context, &manifest);
    remove_folder(what.folder);
    nph_film_free(context, film);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(dumps_beyond_their_limit_are_refused_before_the_run) {
    NphContext *context = nph_test_context(2);
    NphScene *scene = parse(context, scenes[0]);
    NphRenderOptions options;
    NphDumpOptions what;
    NphFilm *film = NULL;
    nph_render_options_default(&options);
    options.samples = 16;
    nph_dump_options_default(&what);
    what.folder = nph_test_temporary("limit");
    what.limit_bytes = 1 << 20;
    ck_assert_int_eq(nph_dump(context, scene, "test.yaml", &options, &what, &film, NULL), NPH_NO_MEMORY);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "its limit is 1.0 MiB"));
    ck_assert_int_ne(access(what.folder, F_OK), 0);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

/* What is written once is counted once: more samples do not multiply it, and it alone can be too much. */
START_TEST(the_density_of_a_grid_counts_once_in_the_forecast) {
    NphContext *context = nph_test_context(2);
    NphScene *scene = parse(context, scenes[4]);
    NphRenderOptions options;
    NphDumpOptions what;
    NphFilm *film = NULL;
    double mebibytes[2];
    nph_render_options_default(&options);
    nph_dump_options_default(&what);
    what.folder = nph_test_temporary("once");
    what.stage = "path.generate"; /* of a batch as good as nothing */
    what.limit_bytes = 1 << 20;
    ck_assert_int_eq(nph_dump(context, scene, "test.yaml", &options, &what, &film, NULL), NPH_NO_MEMORY);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "the density of medium0 takes 17.2 MiB as a dense array, the dump's limit is 1.0 MiB"));
    what.limit_bytes = (1 << 20) * 35 / 2;
    for (int k = 0; k < 2; k++) {
        options.samples = k ? 64 : 16;
        ck_assert_int_eq(nph_dump(context, scene, "test.yaml", &options, &what, &film, NULL), NPH_NO_MEMORY);
        const char *said = strstr(nph_test_messages(), "the dump will take about ");
        ck_assert_ptr_nonnull(said);
        mebibytes[k] = strtod(said + strlen("the dump will take about "), NULL);
    }
    const NphGrid *grid = &scene->media[0].grid;
    double dense = (double)grid->n[0] * grid->n[1] * grid->n[2] * 4.0 / 1048576.0;
    printf("    16 samples: %.1f MiB, 64: %.1f MiB; density %.1f MiB\n", mebibytes[0], mebibytes[1], dense);
    ck_assert_double_gt(mebibytes[0], dense);
    ck_assert_double_lt(mebibytes[0], 1.3 * dense);
    ck_assert_double_gt(mebibytes[1], mebibytes[0]);
    ck_assert_double_lt(mebibytes[1], 1.9 * dense);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

/* What the stage makes of the dense samples is what the run walks. Sampled lattices that are no multiple of a brick or a cell. */
START_TEST(dumped_majorants_are_those_that_the_run_walks) {
    NphContext *context = nph_test_context(2);
    NphScene *scene = parse(context, scenes[3]);
    NphRenderOptions options;
    NphDumpOptions what;
    NphManifest manifest;
    NphFilm *film = NULL;
    NphArray bound, density;
    nph_render_options_default(&options);
    options.samples = 16;
    nph_dump_options_default(&what);
    what.folder = nph_test_temporary("majorants");
    what.batch = 1;
    what.stage = "path.generate";
    ck_assert_int_eq(nph_dump(context, scene, "test.yaml", &options, &what, &film, NULL), NPH_OK);
    ck_assert_int_eq(nph_manifest_read(context, what.folder, &manifest), NPH_OK);
    ck_assert_int_eq(manifest.launch_count, 2); /* whatever is selected, what media hold is there */
    const NphManifestLaunch *launch = &manifest.launches[0];
    ck_assert_str_eq(launch->stage, "path.majorant");
    ck_assert_int_eq(launch->batch, -1);
    ck_assert_int_eq(launch->arguments[4], 1);
    ck_assert_int_eq(nph_manifest_array(context, &manifest, launch->outputs[0].file, &bound), NPH_OK);
    ck_assert_int_eq(nph_manifest_array(context, &manifest, launch->inputs[0].file, &density), NPH_OK);
    const NphGrid *grid = &scene->media[1].grid;
    for (int a = 0; a < 3; a++) {
        ck_assert_int_eq(bound.shape[a], grid->majorant.n[2 - a]);
        ck_assert_int_eq(density.shape[a], grid->n[2 - a]);
    }
    ck_assert_int_eq(memcmp(bound.data, grid->majorant.cells, (size_t)nph_array_count(&bound) * sizeof(float)), 0);
    nph_array_free(context, &bound);
    nph_array_free(context, &density);
    nph_manifest_free(context, &manifest);
    remove_folder(what.folder);
    nph_film_free(context, film);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

static void expect_numbers(const NphDumpRun *run, const char *name, int count, const double *values) {
    double found[64];
    ck_assert_msg(nph_dump_run_numbers(run, name, 64, found) == count, "%s has %d numbers", name, nph_dump_run_numbers(run, name, 64, found));
    for (int i = 0; i < count; i++) ck_assert_msg(fabs(found[i] - values[i]) <= 1e-6 * fabs(values[i]), "%s[%d] = %g", name, i, found[i]);
}

/* What a port is told besides buffers, and what its arrays are, by the public functions alone. */
START_TEST(a_dump_tells_its_launches_arrays_and_what_kernels_know) {
    NphContext *context = nph_test_context(2);
    NphScene *scene = parse(context, scenes[3]);
    NphRenderOptions options;
    NphDumpOptions what;
    NphDumpRun *run = NULL;
    NphDumpLaunch launch;
    NphFilm *film = NULL;
    NphArray array;
    double more[2] = {0, 7};
    nph_render_options_default(&options);
    options.samples = 16;
    nph_dump_options_default(&what);
    what.folder = nph_test_temporary("told");
    what.batch = 1;
    ck_assert_int_eq(nph_dump(context, scene, "test.yaml", &options, &what, &film, NULL), NPH_OK);
    ck_assert_int_eq(nph_dump_run(context, what.folder, &run), NPH_OK);
    const NphGrid *grid = &scene->media[1].grid;
    expect_numbers(run, "resolution", 2, (double[]){18, 9});
    expect_numbers(run, "transport.channels", 1, (double[]){3});
    expect_numbers(run, "transport.surfaces", 1, (double[]){2});
    expect_numbers(run, "media.0.sigma", 3, (double[]){2, 5, 0});
    expect_numbers(run, "media.0.sigma_max", 1, (double[]){5});
    expect_numbers(run, "media.0.hi", 3, (double[]){0.5, 0.5, 0.5});
    expect_numbers(run, "media.0.phase.g2", 1, (double[]){-0.3});
    expect_numbers(run, "media.1.medium", 1, (double[]){1});
    expect_numbers(run, "media.1.albedo", 3, (double[]){0.9, 0.9, 0.9});
    expect_numbers(run, "media.1.world_from_grid", 12, scene->media[1].world_from_medium);
    expect_numbers(run, "media.1.samples", 3, (double[]){grid->n[0], grid->n[1], grid->n[2]});
    expect_numbers(run, "media.1.cells", 3, (double[]){grid->majorant.n[0], grid->majorant.n[1], grid->majorant.n[2]});
    ck_assert_int_eq(nph_dump_run_numbers(run, "media.0.samples", 1, more), 0);
    ck_assert_int_eq(nph_dump_run_numbers(run, "media.1.samples", 1, more), 3);
    ck_assert_double_eq(more[1], 7.0);
    ck_assert_int_gt(nph_dump_run_launch_count(run), 10);
    nph_dump_run_launch(run, 2, &launch); /* majorants, generate, track */
    ck_assert_str_eq(launch.stage, "path.track");
    ck_assert_int_eq(launch.batch, 1);
    ck_assert_str_eq(launch.argument_names[4], "medium");
    ck_assert_int_eq(launch.arguments[0], 1);
    ck_assert_str_eq(launch.inputs[2], "path.ray");
    ck_assert_int_eq(nph_dump_run_array(context, run, 2, "path.distance", &array), NPH_OK);
    ck_assert_int_eq(array.rank, 1);
    nph_array_free(context, &array);
    ck_assert_int_eq(nph_dump_run_array(context, run, 2, "path.pdf", &array), NPH_BAD_INPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "path.track, launch 1 of batch 1, has no path.pdf"));
    nph_dump_run_free(context, run);
    remove_folder(what.folder);
    nph_film_free(context, film);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_medium_without_majorants_is_refused) {
    int64_t arguments[5] = {0, 0, 0, 0, 0};
    NphContext *context = nph_test_context(1);
    NphScene *scene = parse(context, scenes[3]);
    NphRenderOptions options;
    NphStages *stages = NULL;
    NphNamedArray outputs[NPH_MAX_BUFFERS], input = {.name = "path.density"};
    int count = 0;
    nph_render_options_default(&options);
    ck_assert_int_eq(nph_stages_open(context, scene, &options, &stages), NPH_OK);
    ck_assert_int_eq(nph_stages_run(stages, "path.majorant", arguments, 0, NULL, &count, outputs), NPH_BAD_INPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "medium 0: is no grid"));
    arguments[4] = 2;
    ck_assert_int_eq(nph_stages_run(stages, "path.majorant", arguments, 0, NULL, &count, outputs), NPH_BAD_INPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "medium 2: the scene has no such medium"));
    arguments[4] = 1;
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 3, (int64_t[]){3, 3, 3}, "density", &input.array), NPH_OK);
    ck_assert_int_eq(nph_stages_run(stages, "path.majorant", arguments, 1, &input, &count, outputs), NPH_BAD_INPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "input path.density: axis 0 has 3 elements, expected "));
    nph_array_free(context, &input.array);
    const int32_t *n = scene->media[1].grid.n;
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 3, (int64_t[]){n[2], n[1], n[0]}, "density", &input.array), NPH_OK);
    ((float *)input.array.data)[n[0] + 2] = -1.0f;
    ck_assert_int_eq(nph_stages_run(stages, "path.majorant", arguments, 1, &input, &count, outputs), NPH_BAD_INPUT);
    char said[96];
    snprintf(said, sizeof said, "input path.density: value %d is no density", n[0] + 2);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), said));
    nph_array_free(context, &input.array);
    nph_stages_close(stages);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

START_TEST(inputs_that_do_not_fit_are_named) {
    static const int64_t arguments[5] = {0, 0, 0, 0, 0}, beyond[5] = {99, 0, 0, 0, 0};
    NphContext *context = nph_test_context(1);
    NphScene *scene = parse(context, scenes[0]);
    NphRenderOptions options;
    NphStages *stages = NULL;
    NphNamedArray made[NPH_MAX_BUFFERS], outputs[NPH_MAX_BUFFERS], inputs[4];
    int count = 0, none = 0, found = 0;
    nph_render_options_default(&options);
    ck_assert_int_eq(nph_stages_open(context, scene, &options, &stages), NPH_OK);
    ck_assert_int_eq(nph_stages_run(stages, "path.generate", beyond, 0, NULL, &none, outputs), NPH_BAD_INPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "tile 99"));
    ck_assert_int_eq(nph_stages_run(stages, "path.generate", arguments, 0, NULL, &count, made), NPH_OK);
    for (int m = 0; m < count && found < 4; m++)
        if (strcmp(made[m].name, "path.id") == 0 || strcmp(made[m].name, "path.hero") == 0 || strcmp(made[m].name, "path.ray") == 0 ||
            strcmp(made[m].name, "path.weight") == 0)
            inputs[found++] = made[m];
    ck_assert_int_eq(found, 4);
    ck_assert_int_eq(nph_stages_run(stages, "path.track", arguments, 3, inputs, &none, outputs), NPH_BAD_INPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "path.track reads path.weight, which is not among the inputs"));
    inputs[2].array.shape[0] = 3;
    ck_assert_int_eq(nph_stages_run(stages, "path.track", arguments, 4, inputs, &none, outputs), NPH_BAD_INPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "input path.ray: axis 0 has 3 elements, expected 6 ([6][path])"));
    inputs[2].array.shape[0] = 6;
    ((int32_t *)inputs[0].array.data)[7] = 4096;
    ck_assert_int_eq(nph_stages_run(stages, "path.track", arguments, 4, inputs, &none, outputs), NPH_BAD_INPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "input path.id: value 7 is not one of this scene and these paths"));
    ((int32_t *)inputs[0].array.data)[7] = 7;
    ((float *)inputs[2].array.data)[9] = (float)NAN;
    ck_assert_int_eq(nph_stages_run(stages, "path.track", arguments, 4, inputs, &none, outputs), NPH_BAD_INPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "input path.ray: value 9 is not finite"));
    ((float *)inputs[2].array.data)[9] = 0.5f;
    inputs[0].name = "path.sample";
    ck_assert_int_eq(nph_stages_run(stages, "path.track", arguments, 4, inputs, &none, outputs), NPH_BAD_INPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "path.track reads path.id path.hero"));
    ck_assert_int_eq(nph_stages_run(stages, "path.trak", arguments, 4, inputs, &none, outputs), NPH_BAD_USAGE);
    for (int m = 0; m < count; m++) nph_array_free(context, &made[m].array);
    nph_stages_close(stages);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

/* Places the least integer into an input of a launch; what the stage says to it. */
static NphStatus spoilt(NphContext *context, NphStages *stages, const NphManifest *manifest, const NphManifestLaunch *launch, int which) {
    NphNamedArray inputs[NPH_MAX_BUFFERS], outputs[NPH_MAX_BUFFERS];
    int count = 0;
    NphStatus status = NPH_BAD_INPUT;
    for (int i = 0; i < launch->input_count; i++) {
        inputs[i].name = launch->inputs[i].buffer;
        ck_assert_int_eq(nph_manifest_array(context, manifest, launch->inputs[i].file, &inputs[i].array), NPH_OK);
    }
    NphArray *array = &inputs[which].array;
    int64_t last = nph_array_count(array) - 1;
    int integer = array->type == NPH_I32 || array->type == NPH_I64;
    if (array->type == NPH_I32 && last >= 0) ((int32_t *)array->data)[last] = INT32_MIN;
    if (array->type == NPH_I64 && last >= 0) ((int64_t *)array->data)[last] = INT64_MIN;
    if (integer && last >= 0)
        status = nph_stages_run(stages, launch->stage, launch->arguments, launch->input_count, inputs, &count, outputs);
    for (int o = 0; o < count && status == NPH_OK; o++) nph_array_free(context, &outputs[o].array);
    for (int i = 0; i < launch->input_count; i++) nph_array_free(context, &inputs[i].array);
    return status;
}

START_TEST(integers_that_no_run_could_have_are_refused) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = parse(context, scenes[full_scene(_i)]);
    NphRenderOptions options = options_of(_i, 32), again;
    NphManifest manifest;
    NphStages *stages = NULL;
    int tried[NPH_MAX_STAGES] = {0};
    const char *folder = nph_test_temporary("spoilt");
    ck_assert(dump(context, scene, &options, folder, &manifest));
    nph_manifest_options(&manifest, &again);
    ck_assert_int_eq(nph_stages_open(context, scene, &again, &stages), NPH_OK);
    for (int l = 0; l < manifest.launch_count; l++) {
        const NphManifestLaunch *launch = &manifest.launches[l];
        int stage = 0;
        while (strcmp(nph_method(_i)->stages[stage].name, launch->stage) != 0) stage++;
        if (tried[stage]++ >= 2) continue;
        for (int i = 0; i < launch->input_count; i++)
            ck_assert_msg(spoilt(context, stages, &manifest, launch, i) == NPH_BAD_INPUT, "%s took %s", launch->stage,
                          launch->inputs[i].buffer);
    }
    nph_stages_close(stages);
    nph_manifest_free(context, &manifest);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
    remove_folder(folder);
}
END_TEST

START_TEST(pixels_are_selected_only_where_launches_have_them) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = parse(context, scenes[0]);
    for (int m = 0; m < nph_method_count(); m++) {
        const NphMethod *method = nph_method(m);
        NphRenderOptions options = options_of(m, 32);
        NphDumpOptions what;
        NphFilm *film = NULL;
        nph_dump_options_default(&what);
        what.folder = nph_test_temporary("pixel");
        what.pixel_given = 1;
        NphStatus status = nph_dump(context, scene, "test.yaml", &options, &what, &film, NULL);
        ck_assert_int_eq(status, method->shares_samples ? NPH_BAD_USAGE : NPH_OK);
        if (status == NPH_OK) remove_folder(what.folder);
        else ck_assert_ptr_nonnull(strstr(nph_test_messages(), "are not of single pixels"));
        nph_film_free(context, film);
    }
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_loop_test(cases, a_stage_given_its_own_inputs_writes_its_own_outputs, 0, nph_method_count());
    tcase_add_test(cases, photons_wait_for_room_and_go_on);
    tcase_add_loop_test(cases, a_dump_does_not_depend_on_threads, 0, nph_method_count());
    tcase_add_loop_test(cases, integers_that_no_run_could_have_are_refused, 0, nph_method_count());
    tcase_add_test(cases, pixels_are_selected_only_where_launches_have_them);
    tcase_add_test(cases, a_selection_writes_its_launches_and_their_inputs);
    tcase_add_test(cases, dumps_beyond_their_limit_are_refused_before_the_run);
    tcase_add_test(cases, the_density_of_a_grid_counts_once_in_the_forecast);
    tcase_add_test(cases, dumped_majorants_are_those_that_the_run_walks);
    tcase_add_test(cases, a_dump_tells_its_launches_arrays_and_what_kernels_know);
    tcase_add_test(cases, a_medium_without_majorants_is_refused);
    tcase_add_test(cases, inputs_that_do_not_fit_are_named);
}

int main(void) { return nph_test_main("stages", fill); }
