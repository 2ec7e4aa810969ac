/* SPDX-License-Identifier: Apache-2.0
 *
 * nephos info: what a file holds. */
#include <string.h>

#include "cli/command.h"
#include "cli/info.h"
#include "cli/session.h"
#include "core/message.h"
#include "io/describe.h"

typedef NphStatus (*InfoFn)(Info *info);

static NphStatus tell(Info *info, int as_json, int frame_given) {
    static const InfoFn functions[NPH_FILE_KINDS] = {
        [NPH_FILE_EXR] = info_exr, [NPH_FILE_NVDB] = info_nvdb, [NPH_FILE_VDB] = info_vdb, [NPH_FILE_NPY] = info_npy,
        [NPH_FILE_VOL] = info_vol, [NPH_FILE_PBRT] = info_pbrt, [NPH_FILE_LES] = info_les, [NPH_FILE_PHASE] = info_phase, [NPH_FILE_PART] = info_part, [NPH_FILE_SCENE] = info_scene,
    };
    NphFileKind kind = NPH_FILE_UNKNOWN;
    int is_dump = info_is_dump(info->path);
    if (!is_dump) NPH_TRY(nph_file_kind(info->context, info->path, &kind));
    if (!is_dump && !functions[kind])
        return nph_error(info->context, NPH_BAD_INPUT,
                         "%s: this is %s; info reads OpenEXR, .nvdb, .vdb, .npy, .vol, .pbrt, LES text, phase"
                         " tables, part files, scenes and dumps",
                         info->path, nph_file_kind_name(kind));
    if (frame_given && (is_dump || kind != NPH_FILE_SCENE))
        return usage_error("info", "--frame: only scenes have frames, and %s is %s", info->path, is_dump ? "a dump" : nph_file_kind_name(kind));
    if (facts_begin(&info->facts, as_json) != NPH_OK) return nph_error(info->context, NPH_NO_MEMORY, "no memory");
    facts_text(&info->facts, "file", info->path);
    facts_text(&info->facts, "kind", is_dump ? "a dump" : nph_file_kind_name(kind));
    return facts_finish(&info->facts, is_dump ? info_dump(info) : functions[kind](info));
}

static NphStatus run(const Command *command, int argc, char **argv) {
    Session session;
    OptionTable table = {0};
    TextList files = {0};
    NphStatus status = NPH_OK;
    int as_json = 0, frame_given = 0;
    int64_t frame = 0;
    memset(&session, 0, sizeof session);
    option_add(&table, (Option){.name = "json", .kind = OPTION_FLAG, .target = &as_json,
                                .meaning = "as JSON on standard output"});
    option_add(&table, (Option){.name = "frame", .letter = 'f', .kind = OPTION_INT, .target = &frame, .value_name = "F", .min = 0,
                                .max = 16777215.0, .given = &frame_given, .meaning = "of an animated scene; default 0"});
    session_add_options(&table, &session);
    if (!command_begin(command, &table, argc, argv, &files, &status)) return status;
    NPH_TRY(session_open(&session, command->name));
    Info info = {.context = session.context, .path = files.items[0], .frame = (uint32_t)frame};
    return session_close(&session, tell(&info, as_json, frame_given));
}

const Command command_info = {
    .name = "info",
    .arguments = "FILE [options]",
    .summary = "what a volume, picture, part file, scene or dump holds",
    .before = "Tells format, size, range, mean, active part, transform and the optical depth along the axes of a volume\n"
              "(.nvdb, .vdb, .npy, .vol, .pbrt, LES text); channels, attributes and noise of a picture (OpenEXR) or part file;\n"
              "mean cosine, peak and back part of a table of a phase function; sensor, media and lights of a scene; run, stages, buffers and\n"
              "their ranges of a dump. The kind is told from the contents, not from the name.\n",
    .examples = "  nephos info cloud.nvdb\n"
                "  nephos info picture.exr --json\n"
                "  nephos info cloud.yaml --frame 12                        the scene as of that frame\n",
    .files_min = 1,
    .files_max = 1,
    .run = run,
};
