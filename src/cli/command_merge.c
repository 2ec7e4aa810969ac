/* SPDX-License-Identifier: Apache-2.0
 *
 * nephos merge: part files to one picture, to the byte that of one run. */
#include <string.h>

#include "cli/command.h"
#include "cli/output.h"
#include "core/message.h"

typedef struct MergeCommand {
    Session session;
    Output output;
} MergeCommand;

static NphStatus write_merged(MergeCommand *merge, int count, NphFilm *const *parts, const char *const *names) {
    NphContext *context = merge->session.context;
    NphFilm *film = NULL;
    NphFilmNoise noise;
    NPH_TRY(nph_film_merge(context, count, parts, names, &film));
    NphStatus status = output_write(&merge->session, &merge->output, film);
    nph_film_noise(film, &noise);
    nph_film_free(context, film);
    if (status == NPH_OK && !merge->session.quiet)
        printf("%s\n%d parts, %lld samples per pixel, noise %.3g%% of the mean\n", merge->output.path, count,
               (long long)noise.samples_max, 100 * noise.relative_error);
    return status;
}

static NphStatus merge_parts(MergeCommand *merge, const TextList *files) {
    NphContext *context = merge->session.context;
    NphFilm *parts[MAX_LIST] = {NULL};
    int count = 0;
    NphStatus status = output_check("merge", &merge->session, &merge->output);
    while (status == NPH_OK && count < files->count) {
        status = nph_film_read_part(context, files->items[count], &parts[count]);
        count += status == NPH_OK;
    }
    if (status == NPH_OK) status = write_merged(merge, count, parts, files->items);
    while (count > 0) nph_film_free(context, parts[--count]);
    return status;
}

static NphStatus run(const Command *command, int argc, char **argv) {
    MergeCommand merge;
    OptionTable table = {0};
    TextList files = {0};
    NphStatus status = NPH_OK;
    memset(&merge, 0, sizeof merge);
    output_add_options(&table, &merge.output);
    session_add_options(&table, &merge.session);
    if (!command_begin(command, &table, argc, argv, &files, &status)) return status;
    NPH_TRY(session_open(&merge.session, command->name));
    return session_close(&merge.session, merge_parts(&merge, &files));
}

const Command command_merge = {
    .name = "merge",
    .arguments = "PART... -o OUT.exr [options]",
    .summary = "tiles or sample ranges back into one picture",
    .before = "Joins part files (render --part) that differ in --crop or --samples and in nothing else. The picture is\n"
              "that of one run, to the byte. Overlaps and gaps are refused.\n",
    .examples = "  nephos merge 1.part 2.part -o cloud.exr --png\n"
                "  nephos merge 1.part 2.part -o both.part --part           to be merged further\n",
    .files_min = 1,
    .files_max = MAX_LIST,
    .run = run,
};
