/* SPDX-License-Identifier: Apache-2.0
 *
 * nephos stage: one stage of a method alone, on the inputs of a dump or on others. */
#include <errno.h>
#include <string.h>
#include <sys/stat.h>

#include "cli/command.h"
#include "cli/render_options.h"
#include "cli/session.h"
#include "core/message.h"
#include "core/text.h"
#include "nephos/stage.h"
#include "nephos/verify.h"

typedef struct StageCommand {
    Session session;
    RunOptions run;
    const char *scene, *from, *output;
    int64_t launch[2]; /* batch, number */
    int launch_given;
    TextList in, set;
} StageCommand;

/* --set NAME=VALUE over what the dump's launch had. */
static NphStatus set_arguments(const StageCommand *command, const NphStages *stages, int64_t *arguments) {
    for (int i = 0; i < command->set.count; i++) {
        const char *text = command->set.items[i], *value = strchr(text, '=');
        int found = 0;
        for (int a = 0; a < nph_stages_argument_count(stages) && value; a++) {
            const char *name = nph_stages_argument(stages, a);
            if (strlen(name) != (size_t)(value - text) || strncmp(name, text, strlen(name)) != 0) continue;
            found = nph_parse_int(value + 1, &arguments[a]);
        }
        if (!found) return usage_error("stage", "--set %s: expected NAME=NUMBER, NAME tile, chunk, vertex, light, medium or what the method has", text);
    }
    return NPH_OK;
}

/* --in BUFFER=FILE in place of, or beside, the dump's. */
static NphStatus read_inputs(const StageCommand *command, NphStages *stages, NphNamedArray *inputs, int *count) {
    for (int i = 0; i < command->in.count; i++) {
        const char *text = command->in.items[i], *file = strchr(text, '=');
        const char *name = NULL;
        for (int b = 0; b < nph_stages_buffer_count(stages) && file; b++) {
            const char *known = nph_stages_buffer(stages, b).name;
            if (strlen(known) == (size_t)(file - text) && strncmp(known, text, strlen(known)) == 0) name = known;
        }
        if (!name) return usage_error("stage", "--in %s: expected BUFFER=FILE.npy, BUFFER as in path.ray", text);
        int at = 0;
        while (at < *count && strcmp(inputs[at].name, name) != 0) at++;
        if (at < *count) nph_array_free(command->session.context, &inputs[at].array);
        NPH_TRY(nph_array_read_npy(command->session.context, file + 1, &inputs[at].array));
        inputs[at].name = name;
        *count += at == *count;
    }
    return NPH_OK;
}

static NphStatus write_outputs(const StageCommand *command, int count, const NphNamedArray *outputs) {
    NphContext *context = command->session.context;
    if (mkdir(command->output, 0777) != 0 && errno != EEXIST)
        return nph_error(context, NPH_BAD_OUTPUT, "%s: cannot be made: %s", command->output, strerror(errno));
    for (int o = 0; o < count; o++) {
        char path[4096];
        snprintf(path, sizeof path, "%s/%s.npy", command->output, outputs[o].name);
        NPH_TRY(nph_array_write_npy(context, path, &outputs[o].array));
        if (command->session.quiet) continue;
        printf("%s  %s [", path, nph_type_name(outputs[o].array.type));
        for (int a = 0; a < outputs[o].array.rank; a++) printf("%s%lld", a ? ", " : "", (long long)outputs[o].array.shape[a]);
        printf("]\n");
    }
    return NPH_OK;
}

static NphStatus run_stage(StageCommand *command, const char *stage, NphStages *stages) {
    NphContext *context = command->session.context;
    NphNamedArray inputs[NPH_MAX_BUFFERS], outputs[NPH_MAX_BUFFERS];
    int64_t arguments[16] = {0};
    int inputs_count = 0, count = 0;
    memset(inputs, 0, sizeof inputs);
    NphStatus status = NPH_OK;
    if (command->from)
        status = nph_dump_inputs(context, command->from, command->launch[0], command->launch[1], stages, stage, arguments, inputs, &inputs_count);
    if (status == NPH_OK) status = set_arguments(command, stages, arguments);
    if (status == NPH_OK) status = read_inputs(command, stages, inputs, &inputs_count);
    if (status == NPH_OK) status = nph_stages_run(stages, stage, arguments, inputs_count, inputs, &count, outputs);
    if (status == NPH_OK) status = write_outputs(command, count, outputs);
    for (int i = 0; i < inputs_count; i++) nph_array_free(context, &inputs[i].array);
    for (int o = 0; o < count; o++) nph_array_free(context, &outputs[o].array);
    return status;
}

static NphStatus prepare(StageCommand *command, const char *stage) {
    NphContext *context = command->session.context;
    NphRenderOptions options;
    NphScene *scene = NULL;
    NphStages *stages = NULL;
    NphDumpRun *dumped = NULL;
    char name[4096];
    uint32_t frame;
    const char *path = command->scene;
    if (!command->output) return usage_error("stage", "-o DIR: where the outputs go");
    if (!path && !command->from) return usage_error("stage", "--scene SCENE or --from DUMP: what the stage belongs to");
    if (command->from && !command->launch_given) return usage_error("stage", "--launch BATCH:NUMBER: which launch of the dump");
    if (!command->from && command->launch_given) return usage_error("stage", "--launch: of which dump? --from DUMP");
    if (command->from && run_options_given(&command->run))
        return usage_error("stage", "--from: the dump says what its run was; --method, -D, --seed and the like go with --scene alone");
    NPH_TRY(run_options_resolve("stage", &command->run, &options));
    frame = options.frame;
    if (command->from) NPH_TRY(nph_dump_scene(context, command->from, path ? NULL : name, sizeof name, &frame));
    NPH_TRY(nph_scene_load_frame(context, path ? path : name, frame, &scene));
    NphStatus status = command->from ? nph_dump_run(context, command->from, &dumped) : NPH_OK;
    if (status == NPH_OK && dumped) status = nph_dump_run_check(context, dumped, scene);
    if (status == NPH_OK) status = nph_stages_open(context, scene, dumped ? nph_dump_run_options(dumped) : &options, &stages);
    if (status == NPH_OK) status = run_stage(command, stage, stages);
    nph_stages_close(stages);
    nph_dump_run_free(context, dumped);
    nph_scene_free(context, scene);
    return status;
}

static NphStatus run(const Command *command, int argc, char **argv) {
    StageCommand stage;
    OptionTable table = {0};
    TextList files = {0};
    NphStatus status = NPH_OK;
    memset(&stage, 0, sizeof stage);
    option_add(&table, (Option){.name = "from", .kind = OPTION_TEXT, .target = &stage.from, .value_name = "DUMP",
                                .meaning = "take the run's options, arguments and inputs from a launch of this dump"});
    option_add(&table, (Option){.name = "launch", .kind = OPTION_INTS, .target = stage.launch, .value_name = "BATCH:NUMBER", .count = 2,
                                .separator = ':', .given = &stage.launch_given, .meaning = "which launch of the dump"});
    option_add(&table, (Option){.name = "scene", .kind = OPTION_TEXT, .target = &stage.scene, .value_name = "SCENE",
                                .meaning = "without --from, or where the dump's name for it leads nowhere"});
    option_add(&table, (Option){.name = "in", .kind = OPTION_LIST, .target = &stage.in, .value_name = "BUFFER=FILE.npy",
                                .meaning = "an input; replaces the dump's; may be given several times"});
    option_add(&table, (Option){.name = "set", .kind = OPTION_LIST, .target = &stage.set, .value_name = "NAME=NUMBER",
                                .meaning = "an argument of the launch: tile, chunk, vertex, light, medium; may be given several times"});
    option_add(&table, (Option){.name = "output", .letter = 'o', .kind = OPTION_TEXT, .target = &stage.output, .value_name = "DIR",
                                .meaning = "where the outputs go, as BUFFER.npy"});
    run_options_add(&table, &stage.run);
    session_add_options(&table, &stage.session);
    if (!command_begin(command, &table, argc, argv, &files, &status)) return status;
    NPH_TRY(session_open(&stage.session, command->name));
    return session_close(&stage.session, prepare(&stage, files.items[0]));
}

const Command command_stage = {
    .name = "stage",
    .arguments = "NAME --from DUMP --launch BATCH:NUMBER -o DIR [options]",
    .summary = "one stage alone, on given inputs",
    .before = "Runs the stage NAME (path.track) once, on the inputs of a launch of a dump or on .npy files, and writes its\n"
              "outputs. Given the inputs that a run had it writes the bytes that the run wrote.\n",
    .examples = "  nephos stage path.track --from reference --launch 0:1 -o tracked\n"
                "  nephos stage path.track --from reference --launch 0:1 --in path.ray=mine.npy -o tracked\n"
                "  nephos stage path.generate --scene cloud.yaml --set tile=3 -o rays\n",
    .files_min = 1,
    .files_max = 1,
    .run = run,
};
