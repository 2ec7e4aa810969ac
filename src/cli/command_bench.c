/* SPDX-License-Identifier: Apache-2.0
 *
 * nephos bench: how fast, and how much picture for the time. Each scene is rendered with all threads and with one; the
 * best of the repetitions counts, since whatever else runs on the machine can only slow it down. */
#include <math.h>
#include <string.h>

#include "cli/command.h"
#include "cli/machine.h"
#include "cli/render_options.h"
#include "cli/stats.h"
#include "core/memory.h"
#include "core/message.h"

typedef struct SceneBench {
    const char *path;
    NphRenderStatistics many, one; /* with all threads, with one */
    double relative_rmse;          /* of a lit pixel, see lit_error */
    double lit_part;
} SceneBench;

typedef struct BenchCommand {
    Session session;
    RunOptions run;
    NphRenderOptions options;
    int64_t repeat;
    int json, threads;
    Machine machine;
    int count;
    SceneBench *scenes;
} BenchCommand;

/* Root of the mean variance of luminance over lit pixels divided by their mean luminance; lit are pixels of which the
 * media cover more than 5%. Channels are taken as fully correlated. */
static NphStatus lit_error(NphContext *context, const NphFilm *film, SceneBench *bench) {
    static const double weights[3] = {0.2126, 0.7152, 0.0722};
    static const char *const names[2][3] = {{"R", "G", "B"}, {"Variance.R", "Variance.G", "Variance.B"}};
    double mean = 0, variance = 0, lit = 0;
    NphImage image = {0};
    NPH_TRY(nph_film_image(context, film, &image));
    const float *alpha = nph_image_channel(&image, "A")->pixels;
    int64_t count = (int64_t)image.width * image.height;
    for (int64_t i = 0; i < count; i++) {
        double deviation = 0;
        if (!(alpha[i] > 0.05)) continue;
        for (int c = 0; c < 3; c++) {
            mean += weights[c] * nph_image_channel(&image, names[0][c])->pixels[i];
            deviation += weights[c] * sqrt(nph_image_channel(&image, names[1][c])->pixels[i]);
        }
        variance += deviation * deviation;
        lit++;
    }
    bench->relative_rmse = mean > 0 ? sqrt(variance * lit) / mean : 0;
    bench->lit_part = lit / (double)count;
    nph_image_free(context, &image);
    return NPH_OK;
}

/* The fastest of the repetitions. */
static NphStatus time_scene(BenchCommand *bench, NphContext *context, SceneBench *scene_bench, NphRenderStatistics *best) {
    NphScene *scene = NULL;
    NPH_TRY(nph_scene_load_frame(context, scene_bench->path, bench->options.frame, &scene));
    NphStatus status = NPH_OK;
    for (int64_t i = 0; i < bench->repeat && status == NPH_OK; i++) {
        NphFilm *film = NULL;
        NphRenderStatistics run;
        memset(&run, 0, sizeof run);
        status = nph_render(context, scene, &bench->options, &film, &run);
        if (status == NPH_OK && i == 0) status = lit_error(context, film, scene_bench);
        if (status == NPH_OK && (i == 0 || run.seconds < best->seconds)) *best = run;
        nph_film_free(context, film);
    }
    nph_scene_free(context, scene);
    return status;
}

static double efficiency(const SceneBench *bench) {
    double product = bench->relative_rmse * bench->relative_rmse * bench->many.cpu_seconds;
    return product > 0 ? 1 / product : 0;
}

static double ratio(double a, double b) { return b > 0 ? a / b : 0; }

static void print_stages(const SceneBench *bench) {
    double all = 0;
    for (int i = 0; i < bench->many.stage_count; i++) all += bench->many.stages[i].seconds;
    for (int i = 0; i < bench->many.stage_count; i++) {
        const NphStageStatistics *stage = &bench->many.stages[i];
        printf("    %-20s %8.3f s %5.1f%% %8.3g ns/item\n", stage->name, stage->seconds, 100 * ratio(stage->seconds, all),
               1e9 * ratio(stage->seconds, (double)stage->items));
    }
}

static void print_text(const BenchCommand *bench) {
    printf("machine   %.3g Gflop/s f32, %.3g Gflop/s f64, %.3g GB/s, %.3g G gathers/s; %d threads, %s\n", 1e-9 * bench->machine.flops_f32,
           1e-9 * bench->machine.flops_f64, 1e-9 * bench->machine.bytes_per_second, 1e-9 * bench->machine.gathers_per_second, bench->threads,
           nph_isa_name(nph_context_isa(bench->session.context)));
    for (int i = 0; i < bench->count; i++) {
        const SceneBench *b = &bench->scenes[i];
        printf("\n%s: %lld samples per pixel\n", b->path, (long long)b->many.samples_per_pixel);
        printf("  samples     %.4g million/s, %.4g million per CPU second\n",
               1e-6 * ratio((double)b->many.samples, b->many.seconds),
               1e-6 * ratio((double)b->many.samples, b->many.cpu_seconds));
        printf("  events      %.4g million per CPU second, %.3g per sample\n",
               1e-6 * ratio((double)b->many.tentative, b->many.cpu_seconds),
               ratio((double)b->many.tentative, (double)b->many.samples));
        printf("  efficiency  %.4g = 1 / (relRMSE^2 x CPU s): relRMSE %.4g over the lit %.1f%%, CPU %.3f s\n", efficiency(b),
               b->relative_rmse, 100 * b->lit_part, b->many.cpu_seconds);
        printf("  threads     %.3f s with 1, %.3f s with %d: %.3f times as fast\n", b->one.seconds, b->many.seconds,
               bench->threads, ratio(b->one.seconds, b->many.seconds));
        print_stages(b);
        if (b->many.cpu_seconds < 0.9 * bench->threads * b->many.seconds)
            printf("    note: %.0f%% of %d processors were to be had; the machine does other work\n",
                   100 * b->many.cpu_seconds / (bench->threads * b->many.seconds), bench->threads);
    }
}

static void print_json(const BenchCommand *bench) {
    NphJson json;
    nph_json_begin(&json, nph_json_to_file, stdout);
    nph_json_object(&json, NULL);
    stats_environment(&json, &bench->session);
    nph_json_number(&json, "flops_f32_per_s", bench->machine.flops_f32);
    nph_json_number(&json, "flops_f64_per_s", bench->machine.flops_f64);
    nph_json_number(&json, "memory_bytes_per_s", bench->machine.bytes_per_second);
    nph_json_number(&json, "gathers_per_s", bench->machine.gathers_per_second);
    nph_json_array(&json, "scenes");
    for (int i = 0; i < bench->count; i++) {
        const SceneBench *b = &bench->scenes[i];
        nph_json_object(&json, NULL);
        nph_json_text(&json, "scene", b->path);
        nph_json_number(&json, "samples_per_s", ratio((double)b->many.samples, b->many.seconds));
        nph_json_number(&json, "samples_per_cpu_s", ratio((double)b->many.samples, b->many.cpu_seconds));
        nph_json_number(&json, "events_per_cpu_s", ratio((double)b->many.tentative, b->many.cpu_seconds));
        nph_json_number(&json, "lit_relative_rmse", b->relative_rmse);
        nph_json_number(&json, "lit_part", b->lit_part);
        nph_json_number(&json, "efficiency", efficiency(b));
        nph_json_number(&json, "seconds_one_thread", b->one.seconds);
        nph_json_number(&json, "speedup", ratio(b->one.seconds, b->many.seconds));
        stats_run(&json, "run", &b->many);
        nph_json_close(&json);
    }
    nph_json_close(&json);
    nph_json_close(&json);
}

/* All scenes in the session's context; `many` says which of the two results. */
static NphStatus time_scenes(BenchCommand *bench, NphContext *context, int many) {
    for (int i = 0; i < bench->count; i++) {
        SceneBench *scene = &bench->scenes[i];
        NPH_TRY(time_scene(bench, context, scene, many ? &scene->many : &scene->one));
    }
    return NPH_OK;
}

/* With one thread, in a context of its own, before the other is opened: signals reach one context. */
static NphStatus time_alone(BenchCommand *bench) {
    Session single = bench->session;
    single.threads = 1;
    NPH_TRY(session_open(&single, "bench"));
    return session_close(&single, time_scenes(bench, single.context, 0));
}

static NphStatus run(const Command *command, int argc, char **argv) {
    static SceneBench scenes[MAX_LIST];
    BenchCommand bench;
    OptionTable table = {0};
    TextList files = {0};
    NphStatus status = NPH_OK;
    memset(&bench, 0, sizeof bench);
    bench.repeat = 3;
    run_options_add(&table, &bench.run);
    option_add(&table, (Option){.name = "repeat", .kind = OPTION_INT, .target = &bench.repeat, .value_name = "N", .min = 1,
                                .max = 1000, .meaning = "the fastest of N runs counts; default 3"});
    option_add(&table, (Option){.name = "json", .kind = OPTION_FLAG, .target = &bench.json,
                                .meaning = "as JSON on standard output"});
    session_add_options(&table, &bench.session);
    if (!command_begin(command, &table, argc, argv, &files, &status)) return status;
    NPH_TRY(run_options_resolve("bench", &bench.run, &bench.options));
    bench.scenes = scenes;
    bench.count = files.count;
    for (int i = 0; i < files.count; i++) scenes[i].path = files.items[i];

    NPH_TRY(time_alone(&bench));
    NPH_TRY(session_open(&bench.session, command->name));
    bench.threads = nph_context_threads(bench.session.context);
    status = machine_measure(bench.session.context, &bench.machine);
    if (status == NPH_OK) status = time_scenes(&bench, bench.session.context, 1);
    if (status == NPH_OK && bench.json) print_json(&bench);
    if (status == NPH_OK && !bench.json) print_text(&bench);
    return session_close(&bench.session, status);
}

const Command command_bench = {
    .name = "bench",
    .arguments = "SCENE... [options]",
    .summary = "speed, efficiency, and time by stage",
    .before = "Renders each scene with all threads and with one, and tells samples and events per second, the efficiency\n"
              "1 / (relRMSE^2 x CPU seconds), the seconds of every stage, and what the machine itself can do. Takes the\n"
              "options of render. On a machine that does other work the numbers mean little.\n",
    .examples = "  nephos bench reference/scenes/cube.yaml --spp 64\n"
                "  nephos bench reference/scenes/*.yaml --spp 64 --json > bench.json\n",
    .files_min = 1,
    .files_max = MAX_LIST,
    .run = run,
};
