/* SPDX-License-Identifier: Apache-2.0
 *
 * nephos batch: frames A to B of a scene, one after another; a method with memory over time goes on from each to the next. */
#include <string.h>

#include "cli/command.h"
#include "cli/output.h"
#include "cli/render_options.h"
#include "core/message.h"
#include "core/text.h"

enum { FRAME_MAX = 16777215, PATH_BYTES = 4096 };

typedef struct BatchCommand {
    Session session;
    RunOptions run;
    Output output;
    const char *frames;
    int64_t first, last, step;
} BatchCommand;

static void add_options(OptionTable *table, BatchCommand *batch) {
    batch->step = 1;
    option_add(table, (Option){.name = "frames", .kind = OPTION_TEXT, .target = &batch->frames, .value_name = "A-B",
                               .meaning = "the first and the last frame; or a single one"});
    option_add(table, (Option){.name = "step", .kind = OPTION_INT, .target = &batch->step, .value_name = "S", .min = 1, .max = FRAME_MAX,
                               .meaning = "every S-th of them"});
    output_add_options(table, &batch->output);
    run_options_add(table, &batch->run);
    session_add_options(table, &batch->session);
}

static NphStatus parse_frames(BatchCommand *batch) {
    const char *text = batch->frames, *dash = text ? strchr(text, '-') : NULL;
    if (!text) return usage_error("batch", "which frames? --frames A-B");
    int right = dash ? nph_parse_int_range(text, dash, &batch->first) && nph_parse_int(dash + 1, &batch->last) : nph_parse_int(text, &batch->first);
    if (!dash) batch->last = batch->first;
    if (!right || batch->first < 0 || batch->last < batch->first || batch->last > FRAME_MAX)
        return usage_error("batch", "--frames %s: expected A-B, whole numbers with 0 <= A <= B <= %d", text, (int)FRAME_MAX);
    return NPH_OK;
}

/* The run of # of a name, NULL when there is not exactly one. */
static const char *hashes_of(const char *path, int *count) {
    const char *first = strchr(path, '#');
    if (!first) return NULL;
    *count = (int)strspn(first, "#");
    return strchr(first + *count, '#') ? NULL : first;
}

/* A name with the frame's number in place of its # and, of what was cut short, ".partial" before its ending. */
static int name_frame(const char *pattern, int64_t frame, int partial, char path[PATH_BYTES]) {
    int count = 0;
    const char *hashes = hashes_of(pattern, &count), *rest = hashes + count, *slash = strrchr(rest, '/');
    const char *dot = strrchr(slash ? slash : rest, '.');
    int stem = (int)(dot ? dot - rest : (long)strlen(rest));
    int length = snprintf(path, PATH_BYTES, "%.*s%0*lld%.*s%s%s", (int)(hashes - pattern), pattern, count, (long long)frame, stem, rest,
                          partial ? ".partial" : "", rest + stem);
    return length < PATH_BYTES;
}

static NphStatus check_names(const BatchCommand *batch) {
    int count = 0;
    const char *const names[] = {batch->output.path, batch->output.png};
    if (!batch->output.path) return usage_error("batch", "where to? -o OUT.####.exr");
    for (int i = 0; i < 2; i++)
        if (names[i] && *names[i] && !hashes_of(names[i], &count))
            return usage_error("batch", "%s: expected one run of #, in whose place the frame's number stands: OUT.####.exr", names[i]);
    if (batch->run.frame) return usage_error("batch", "--frame: a batch takes --frames A-B");
    return NPH_OK;
}

/* Names of a frame in place of the patterns. */
static NphStatus name_output(BatchCommand *batch, int64_t frame, int partial, char path[PATH_BYTES], char png[PATH_BYTES], Output *output) {
    *output = batch->output;
    if (!name_frame(batch->output.path, frame, partial, path) ||
        (batch->output.png && *batch->output.png && !name_frame(batch->output.png, frame, partial, png)))
        return usage_error("batch", "frame %lld: the path is too long", (long long)frame);
    output->path = path;
    if (batch->output.png && *batch->output.png) output->png = png;
    return output_check("batch", &batch->session, output);
}

static void tell(const BatchCommand *batch, int64_t frame, const char *path, const NphRenderStatistics *run) {
    if (batch->session.quiet) return;
    printf("frame %lld  %s  samples %lld  seconds %.2f  noise %.3g%%\n", (long long)frame, path, (long long)run->noise.samples_max, run->seconds,
           100 * run->noise.relative_error);
    fflush(stdout);
}

/* What was interrupted is written under another name, if there is anything of it. */
static NphStatus render_frame(BatchCommand *batch, NphSequence *sequence, int64_t frame) {
    NphContext *context = batch->session.context;
    char path[PATH_BYTES], png[PATH_BYTES];
    Output output;
    NphFilm *film = NULL;
    NphRenderStatistics run;
    memset(&run, 0, sizeof run);
    NPH_TRY(name_output(batch, frame, 0, path, png, &output));
    NphStatus status = nph_sequence_render(sequence, (uint32_t)frame, &film, &run), written = NPH_OK;
    if (status == NPH_INTERRUPTED) {
        nph_resume(context);
        if (film && run.noise.samples_max > 0) written = name_output(batch, frame, 1, path, png, &output);
        else path[0] = 0;
        nph_warn(context, "interrupted in frame %lld: %s", (long long)frame, path[0] ? path : "no picture of it");
    }
    if (written == NPH_OK && film && path[0] && (status == NPH_OK || status == NPH_INTERRUPTED)) written = output_write(&batch->session, &output, film);
    if (written == NPH_OK && status == NPH_OK) tell(batch, frame, path, &run);
    if (status != NPH_OK && status != NPH_INTERRUPTED) nph_error(context, status, "frame %lld: no picture", (long long)frame);
    nph_film_free(context, film);
    return written != NPH_OK ? written : status;
}

static NphStatus render_frames(BatchCommand *batch, const NphScene *scene, const NphRenderOptions *options) {
    NphSequence *sequence = NULL;
    NphStatus status = nph_sequence_open(batch->session.context, scene, options, &sequence);
    for (int64_t frame = batch->first; frame <= batch->last && status == NPH_OK; frame += batch->step) status = render_frame(batch, sequence, frame);
    nph_sequence_close(sequence);
    return status;
}

static NphStatus prepare(BatchCommand *batch, const char *path) {
    NphContext *context = batch->session.context;
    NphRenderOptions options;
    NphScene *scene = NULL;
    Output first;
    char exr[PATH_BYTES], png[PATH_BYTES];
    NPH_TRY(run_options_resolve("batch", &batch->run, &options));
    NPH_TRY(parse_frames(batch));
    NPH_TRY(check_names(batch));
    NPH_TRY(name_output(batch, batch->first, 0, exr, png, &first));
    NPH_TRY(nph_scene_load_frame(context, path, (uint32_t)batch->first, &scene));
    NphStatus status = render_frames(batch, scene, &options);
    nph_scene_free(context, scene);
    return status;
}

static NphStatus run(const Command *command, int argc, char **argv) {
    BatchCommand batch;
    OptionTable table = {0};
    TextList files = {0};
    NphStatus status = NPH_OK;
    memset(&batch, 0, sizeof batch);
    add_options(&table, &batch);
    if (!command_begin(command, &table, argc, argv, &files, &status)) return status;
    NPH_TRY(session_open(&batch.session, command->name));
    return session_close(&batch.session, prepare(&batch, files.items[0]));
}

const Command command_batch = {
    .name = "batch",
    .arguments = "SCENE --frames A-B -o OUT.####.exr [options]",
    .summary = "frames of a scene, one after another",
    .before = "Renders SCENE at each frame to a picture of its own; # in the name are the digits of its number. Each has the\n"
              "bytes that `nephos render --frame` gives it, however the frames are divided between runs; a method with memory\n"
              "over time (temporal_photons) keeps what the next frame needs, and traces what is new.\n",
    .examples = "  nephos batch sunset.yaml --frames 0-99 -o sunset.####.exr --png\n"
                "  nephos batch sunset.yaml --frames 100-199 --step 2 -o sunset.####.exr -m temporal_photons\n",
    .files_min = 1,
    .files_max = 1,
    .run = run,
};
