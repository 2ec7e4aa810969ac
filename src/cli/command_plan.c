/* SPDX-License-Identifier: Apache-2.0
 *
 * nephos plan: what a run would do, without doing it. */
#include <string.h>

#include "cli/command.h"
#include "cli/render_options.h"
#include "core/json.h"
#include "core/message.h"

typedef struct PlanCommand {
    Session session;
    RunOptions run;
    int json, knobs, sequence;
} PlanCommand;

static void print_plan(const NphPlan *plan) {
    const char *kind = "";
    for (int i = 0; i < plan->line_count; i++) {
        const NphPlanLine *line = &plan->lines[i];
        if (strcmp(kind, line->kind) != 0) printf("%s%s\n", i ? "\n" : "", line->kind);
        kind = line->kind;
        printf("  %-22s", line->name);
        if (line->bytes) printf(" %9.3f MiB ", (double)line->bytes / 1048576);
        printf(" %s\n", line->text);
    }
    printf("\nall memory: %.3f MiB\n", (double)plan->bytes / 1048576);
}

static void print_json(const char *scene, const NphPlan *plan) {
    NphJson json;
    nph_json_begin(&json, nph_json_to_file, stdout);
    nph_json_object(&json, NULL);
    nph_json_text(&json, "scene", scene);
    nph_json_integer(&json, "bytes", (int64_t)plan->bytes);
    nph_json_array(&json, "lines");
    for (int i = 0; i < plan->line_count; i++) {
        nph_json_object(&json, NULL);
        nph_json_text(&json, "kind", plan->lines[i].kind);
        nph_json_text(&json, "name", plan->lines[i].name);
        nph_json_text(&json, "text", plan->lines[i].text);
        nph_json_integer(&json, "bytes", (int64_t)plan->lines[i].bytes);
        nph_json_close(&json);
    }
    nph_json_close(&json);
    nph_json_close(&json);
}

static NphStatus make_plan(PlanCommand *plan, const char *path) {
    NphContext *context = plan->session.context;
    NphRenderOptions options;
    NphScene *scene = NULL;
    NphPlan made = {0};
    NPH_TRY(run_options_resolve("plan", &plan->run, &options));
    options.sequence = plan->sequence;
    NPH_TRY(nph_scene_load_frame(context, path, options.frame, &scene));
    NphStatus status = nph_plan_make(context, scene, &options, &made);
    nph_scene_free(context, scene);
    if (status != NPH_OK) return status;
    if (plan->json) print_json(path, &made);
    else print_plan(&made);
    nph_plan_free(context, &made);
    return NPH_OK;
}

static NphStatus run(const Command *command, int argc, char **argv) {
    PlanCommand plan;
    OptionTable table = {0};
    TextList files = {0};
    NphStatus status = NPH_OK;
    memset(&plan, 0, sizeof plan);
    run_options_add(&table, &plan.run);
    option_add(&table, (Option){.name = "knobs", .kind = OPTION_FLAG, .target = &plan.knobs,
                                .meaning = "list the knobs of every method, their ranges and what they trade"});
    option_add(&table, (Option){.name = "sequence", .kind = OPTION_FLAG, .target = &plan.sequence,
                                .meaning = "of nephos batch: with what one frame keeps for the next"});
    option_add(&table, (Option){.name = "json", .kind = OPTION_FLAG, .target = &plan.json,
                                .meaning = "as JSON on standard output"});
    session_add_options(&table, &plan.session);
    if (!command_begin(command, &table, argc, argv, &files, &status)) return status;
    if (plan.knobs) knobs_print(stdout);
    if (files.count == 0)
        return plan.knobs ? NPH_OK : usage_error("plan", "which scene? usage: nephos plan %s", command->arguments);
    NPH_TRY(session_open(&plan.session, command->name));
    return session_close(&plan.session, make_plan(&plan, files.items[0]));
}

const Command command_plan = {
    .name = "plan",
    .arguments = "SCENE [options]",
    .summary = "what a run would do, leave out, and take in memory",
    .before = "Reads SCENE and says which stages a run has, what this scene makes unnecessary and why, which buffers\n"
              "there are and how large, and what about the scene deserves a second look. Takes the options of render.\n",
    .examples = "  nephos plan cloud.yaml\n"
                "  nephos plan cloud.yaml --plan full --precision f64       nothing left out\n"
                "  nephos plan --knobs\n",
    .files_min = 0,
    .files_max = 1,
    .run = run,
};
