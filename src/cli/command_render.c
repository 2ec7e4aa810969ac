/* SPDX-License-Identifier: Apache-2.0
 *
 * nephos render: scene to picture. Everything that can be refused is refused before the work begins; an interrupted run
 * writes what it has. */
#include <string.h>

#include "cli/command.h"
#include "cli/output.h"
#include "cli/render_options.h"
#include "cli/stats.h"
#include "core/message.h"
#include "core/text.h"
#include "nephos/stage.h"

typedef struct RenderCommand {
    Session session;
    RunOptions run;
    Output output;
    const char *stats;
    const char *dump;
    uint64_t dump_limit;
    TextList dump_select;
    int64_t only[4]; /* frame, x, y, sample */
    int only_given, json;
} RenderCommand;

static void add_options(OptionTable *table, RenderCommand *render) {
    output_add_options(table, &render->output);
    run_options_add(table, &render->run);
    option_add(table, (Option){.name = "only", .kind = OPTION_INTS, .target = render->only,
                               .value_name = "FRAME,X,Y,SAMPLE", .count = 4, .separator = ',',
                               .given = &render->only_given,
                               .meaning = "follow that one path and print its events; no picture"});
    option_add(table, (Option){.name = "stats", .kind = OPTION_TEXT, .target = &render->stats, .value_name = "FILE.json",
                               .meaning = "seconds, events and noise, stage by stage"});
    option_add(table, (Option){.name = "dump", .kind = OPTION_TEXT, .target = &render->dump, .value_name = "DIR",
                               .meaning = "write the outputs of every launch of every stage, and manifest.json (docs/oracle.md)"});
    option_add(table, (Option){.name = "dump-select", .kind = OPTION_LIST, .target = &render->dump_select, .value_name = "KEY=VALUE",
                               .meaning = "only stage=NAME, launch=N of each batch, batch=N, pixel=X,Y; one of each"});
    option_add(table, (Option){.name = "dump-limit", .kind = OPTION_BYTES, .target = &render->dump_limit, .value_name = "BYTES",
                               .meaning = "refuse a larger dump (default 4G)"});
    option_add(table, (Option){.name = "json", .kind = OPTION_FLAG, .target = &render->json,
                               .meaning = "the summary as JSON on standard output"});
    session_add_options(table, &render->session);
}

static void print_line(void *user, const char *text) { fprintf(user, "%s\n", text); }

static NphStatus replay(RenderCommand *render, const char *path, NphRenderOptions *options) {
    const int64_t *only = render->only;
    NphScene *scene = NULL;
    for (int i = 0; i < 4; i++)
        if (only[i] < 0 || only[i] >= (int64_t)1 << (i == 3 ? 40 : 24))
            return usage_error("render", "--only: expected FRAME,X,Y,SAMPLE, numbers from 0 on");
    options->frame = (uint32_t)only[0];
    NPH_TRY(nph_scene_load_frame(render->session.context, path, options->frame, &scene));
    NphStatus status = nph_replay(render->session.context, scene, options, (int)only[1], (int)only[2], only[3],
                                  print_line, stdout);
    nph_scene_free(render->session.context, scene);
    return status;
}

static void print_summary(const RenderCommand *render, const NphRenderStatistics *run) {
    const NphFilmNoise *noise = &run->noise;
    printf("%s\n", render->output.path);
    if (render->output.png) printf("%s\n", render->output.png_path);
    if (noise->samples_min == noise->samples_max) printf("samples  %lld per pixel", (long long)noise->samples_max);
    else printf("samples  %lld to %lld per pixel", (long long)noise->samples_min, (long long)noise->samples_max);
    printf(", %.4g million in all\n", 1e-6 * (double)run->samples);
    printf("seconds  %.2f, %.2f of processor time, %.3g million samples/s\n", run->seconds, run->cpu_seconds,
           run->seconds > 0 ? 1e-6 * (double)run->samples / run->seconds : 0);
    printf("noise    %.3g%% of the mean (standard error of the whole picture), %.3g%% RMS of a pixel\n",
           100 * noise->relative_error, 100 * noise->relative_rmse);
    if (render->run.target_error > 0)
        printf("target   %s: asked for %.3g%%\n", run->reached ? "reached" : "NOT reached", 100 * render->run.target_error);
}

static void print_json(const RenderCommand *render, const char *scene, NphStatus status, const NphRenderStatistics *run) {
    NphJson json;
    nph_json_begin(&json, nph_json_to_file, stdout);
    nph_json_object(&json, NULL);
    nph_json_text(&json, "scene", scene);
    nph_json_text(&json, "output", render->output.path);
    nph_json_text(&json, "png", render->output.png ? render->output.png_path : NULL);
    nph_json_text(&json, "status", nph_status_name(status));
    stats_run(&json, "run", run);
    nph_json_close(&json);
}

/* Writes picture and reports; `status` is what the run gave: done or interrupted. */
static NphStatus finish(RenderCommand *render, const char *scene, NphStatus status, const NphFilm *film,
                        const NphRenderStatistics *run) {
    NphContext *context = render->session.context;
    if (status == NPH_INTERRUPTED) {
        nph_resume(context); /* writing is not to be interrupted; a second signal kills */
        if (run->noise.samples_max == 0) return nph_error(context, status, "interrupted before the first samples: no picture");
        nph_warn(context, "interrupted: %s holds %lld to %lld samples per pixel", render->output.path,
                 (long long)run->noise.samples_min, (long long)run->noise.samples_max);
    }
    NPH_TRY(output_write(&render->session, &render->output, film));
    if (render->stats) NPH_TRY(stats_write(&render->session, render->stats, scene, status, run));
    if (render->json) print_json(render, scene, status, run);
    else if (!render->session.quiet) print_summary(render, run);
    return status;
}

/* One KEY=VALUE of --dump-select. */
static int select_dump(const char *text, NphDumpOptions *dump) {
    const char *value = strchr(text, '='), *comma = value ? strchr(value, ',') : NULL;
    int64_t x, y, *number = strncmp(text, "launch=", 7) == 0 ? &dump->launch : strncmp(text, "batch=", 6) == 0 ? &dump->batch : NULL;
    if (number) return nph_parse_int(value + 1, number) && *number >= 0;
    if (strncmp(text, "stage=", 6) == 0) dump->stage = value + 1;
    else if (strncmp(text, "pixel=", 6) != 0 || !comma || !nph_parse_int_range(value + 1, comma, &x) || !nph_parse_int(comma + 1, &y) ||
             x < 0 || y < 0 || x > INT32_MAX || y > INT32_MAX)
        return 0;
    else {
        dump->pixel_given = 1;
        dump->pixel[0] = (int)x;
        dump->pixel[1] = (int)y;
    }
    return 1;
}

static NphStatus dump_options(const RenderCommand *render, NphDumpOptions *dump) {
    nph_dump_options_default(dump);
    dump->folder = render->dump;
    if (render->dump_limit) dump->limit_bytes = render->dump_limit;
    for (int i = 0; i < render->dump_select.count; i++)
        for (int j = 0; j < i; j++)
            if (strcspn(render->dump_select.items[i], "=") == strcspn(render->dump_select.items[j], "=") &&
                strncmp(render->dump_select.items[i], render->dump_select.items[j], strcspn(render->dump_select.items[i], "=")) == 0)
                return usage_error("render", "--dump-select: %s and %s: one of a kind", render->dump_select.items[j], render->dump_select.items[i]);
    for (int i = 0; i < render->dump_select.count; i++)
        if (!select_dump(render->dump_select.items[i], dump))
            return usage_error("render", "--dump-select %s: expected stage=NAME, launch=N, batch=N or pixel=X,Y", render->dump_select.items[i]);
    if (render->dump && render->only_given) return usage_error("render", "--dump and --only exclude each other: one path makes no launches");
    if (!render->dump && (render->dump_select.count || render->dump_limit))
        return usage_error("render", "--dump-select and --dump-limit: without --dump nothing is written");
    return NPH_OK;
}

static NphStatus render_scene(RenderCommand *render, const char *path, const NphRenderOptions *options, const NphDumpOptions *dump) {
    NphContext *context = render->session.context;
    NphScene *scene = NULL;
    NphFilm *film = NULL;
    NphRenderStatistics run;
    memset(&run, 0, sizeof run);
    NPH_TRY(nph_scene_load_frame(context, path, options->frame, &scene));
    NphStatus status = dump->folder ? nph_dump(context, scene, path, options, dump, &film, &run)
                                    : nph_render(context, scene, options, &film, &run);
    nph_scene_free(context, scene);
    if (film && (status == NPH_OK || status == NPH_INTERRUPTED)) status = finish(render, path, status, film, &run);
    else if (status == NPH_INTERRUPTED) nph_error(context, status, "interrupted before the first samples: no picture");
    nph_film_free(context, film);
    return status;
}

static NphStatus prepare(RenderCommand *render, const char *path) {
    NphRenderOptions options;
    NphDumpOptions dump;
    NPH_TRY(run_options_resolve("render", &render->run, &options));
    NPH_TRY(dump_options(render, &dump));
    if (render->only_given) return replay(render, path, &options);
    NPH_TRY(output_check("render", &render->session, &render->output));
    if (render->stats) NPH_TRY(check_writable(&render->session, render->stats));
    return render_scene(render, path, &options, &dump);
}

static NphStatus run(const Command *command, int argc, char **argv) {
    RenderCommand render;
    OptionTable table = {0};
    TextList files = {0};
    NphStatus status = NPH_OK;
    memset(&render, 0, sizeof render);
    add_options(&table, &render);
    if (!command_begin(command, &table, argc, argv, &files, &status)) return status;
    NPH_TRY(session_open(&render.session, command->name));
    return session_close(&render.session, prepare(&render, files.items[0]));
}

const Command command_render = {
    .name = "render",
    .arguments = "SCENE -o OUT.exr [options]",
    .summary = "a scene to a picture with error bars",
    .before = "Renders SCENE (YAML; docs/scene.md) to an OpenEXR file: R G B A, and the variance of every pixel beside\n"
              "them. The same scene, seed and samples give the same bytes, whatever the machine. Ctrl-C writes what is\n"
              "done and exits with 75; a second Ctrl-C kills.\n",
    .examples = "  nephos render cloud.yaml -o cloud.exr --png              the scene's own number of samples\n"
                "  nephos render cloud.yaml -o cloud.exr --spp 1024\n"
                "  nephos render cloud.yaml -o cloud.exr --target-error 0.002 --time-budget 600\n"
                "  nephos render cloud.yaml -o half.part --part --samples 512:1024\n"
                "  nephos render cloud.yaml -o left.part --part --crop 0,0,256,512\n"
                "  nephos render cloud.yaml --only 0,120,80,7               sample 7 of pixel (120, 80), event by event\n",
    .files_min = 1,
    .files_max = 1,
    .run = run,
};
