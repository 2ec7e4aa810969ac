/* SPDX-License-Identifier: Apache-2.0
 *
 * nephos tolerance: how far an honest port may be off, stage by stage, measured. */
#include <string.h>
#include <sys/stat.h>

#include "altered/measure.h"
#include "cli/command.h"
#include "cli/render_options.h"
#include "cli/session.h"
#include "core/message.h"
#include "io/file.h"

typedef struct ToleranceCommand {
    Session session;
    RunOptions run;
    const char *output, *scene;
} ToleranceCommand;

/* A dump is a folder, or its manifest. */
static int is_dump(const char *path) {
    struct stat found;
    size_t length = strlen(path), end = sizeof "manifest.json" - 1;
    return (length >= end && strcmp(path + length - end, "manifest.json") == 0) || (stat(path, &found) == 0 && S_ISDIR(found.st_mode));
}

static NphStatus write_file(const ToleranceCommand *command, const AlteredMeasure *measure, const char *scene_name) {
    NphContext *context = command->session.context;
    NphWriter writer;
    NphJson json;
    if (!command->output) {
        nph_json_begin(&json, nph_json_to_file, stdout);
        altered_measure_write(measure, scene_name, &json);
        return NPH_OK;
    }
    NPH_TRY(nph_writer_open(context, command->output, &writer));
    nph_json_begin(&json, nph_json_to_file, writer.stream);
    altered_measure_write(measure, scene_name, &json);
    return nph_writer_commit(context, &writer);
}

static NphStatus measure_and_write(const ToleranceCommand *command, const NphScene *scene, const char *scene_name, const char *dump,
                                   const NphRenderOptions *options) {
    AlteredMeasure *measure = NULL;
    NphStatus status = altered_measure_open(command->session.context, scene, options, &measure);
    if (status == NPH_OK) status = dump ? altered_measure_dump(measure, dump) : altered_measure_run(measure, scene, options);
    if (status == NPH_OK) status = write_file(command, measure, scene_name);
    altered_measure_close(measure);
    return status;
}

static NphStatus prepare(ToleranceCommand *command, const char *path) {
    NphContext *context = command->session.context;
    NphRenderOptions options, few;
    NphScene *scene = NULL;
    NphDumpRun *dumped = NULL;
    char name[4096];
    uint32_t frame;
    const char *scene_name = command->scene ? command->scene : path;
    int dump = is_dump(path);
    if (!dump && command->scene) return usage_error("tolerance", "--scene names the scene of a dump, and %s is none", path);
    if (dump && run_options_given(&command->run))
        return usage_error("tolerance", "%s is a dump, which says what its run was; --method, -D, --seed and the like go with a scene", path);
    NPH_TRY(run_options_resolve("tolerance", &command->run, &options));
    if (command->output) NPH_TRY(check_writable(&command->session, command->output));
    if (dump) NPH_TRY(nph_dump_run(context, path, &dumped));
    NphStatus status = NPH_OK;
    frame = options.frame;
    if (dump) status = nph_dump_scene(context, path, command->scene ? NULL : name, sizeof name, &frame);
    if (dump && !command->scene) scene_name = name;
    if (status == NPH_OK) status = nph_scene_load_frame(context, scene_name, frame, &scene);
    if (status == NPH_OK && dumped) status = nph_dump_run_check(context, dumped, scene);
    if (status == NPH_OK && dumped) status = measure_and_write(command, scene, scene_name, path, nph_dump_run_options(dumped));
    else if (status == NPH_OK) {
        altered_few(scene, &options, &few);
        status = measure_and_write(command, scene, scene_name, NULL, &few);
    }
    nph_dump_run_free(context, dumped);
    nph_scene_free(context, scene);
    return status;
}

static NphStatus run(const Command *command, int argc, char **argv) {
    ToleranceCommand tolerance;
    OptionTable table = {0};
    TextList files = {0};
    NphStatus status = NPH_OK;
    memset(&tolerance, 0, sizeof tolerance);
    option_add(&table, (Option){.name = "output", .letter = 'o', .kind = OPTION_TEXT, .target = &tolerance.output, .value_name = "FILE.json",
                                .meaning = "where the tolerances go; default: standard output"});
    option_add(&table, (Option){.name = "scene", .kind = OPTION_TEXT, .target = &tolerance.scene, .value_name = "SCENE",
                                .meaning = "of a dump, where its manifest's name for it leads nowhere"});
    run_options_add(&table, &tolerance.run);
    session_add_options(&table, &tolerance.session);
    if (!command_begin(command, &table, argc, argv, &files, &status)) return status;
    tolerance.session.threads = 1; /* what is simulated is of the whole process */
    NPH_TRY(session_open(&tolerance.session, command->name));
    return session_close(&tolerance.session, prepare(&tolerance, files.items[0]));
}

const Command command_tolerance = {
    .name = "tolerance",
    .arguments = "SCENE|DUMP [-o FILE.json] [options]",
    .summary = "how far an honest port may be off, measured",
    .before = "Runs every stage once more for each way in which an honest implementation differs: in the other precision, with\n"
              "contracted sums and approximate reciprocals, with functions as accurate as GPU interfaces promise, with buffers\n"
              "kept in halves. Writes per stage, buffer and cause how far the outputs were off, and the tolerance that verify\n"
              "makes of it. Measured on launches of DUMP, or of a run of 16 samples around the middle of SCENE's picture.\n",
    .examples = "  nephos tolerance cloud.yaml -o tolerances.json\n"
                "  nephos tolerance reference -o reference/tolerances.json\n",
    .files_min = 1,
    .files_max = 1,
    .run = run,
};
