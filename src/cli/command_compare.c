/* SPDX-License-Identifier: Apache-2.0
 *
 * nephos compare: two pictures, judged by their error bars, and FLIP of them. */
#include <string.h>

#include "cli/command.h"
#include "cli/session.h"
#include "core/json.h"
#include "core/memory.h"
#include "core/message.h"
#include "core/text.h"
#include "io/file.h"
#include "io/volume.h"
#include "oracle/compare_picture.h"
#include "oracle/compare_report.h"

typedef struct CompareCommand {
    Session session;
    NphCompareOptions options;
    NphFlipOptions flip_options;
    const char *kind, *exposure, *z_map, *flip_map, *picture, *junit;
    double pixels_per_degree;
    int json, flip, ppd_given;
    char suite[600];
} CompareCommand;

/* What one comparison makes. */
typedef struct Result {
    NphComparison comparison;
    NphFlip flip;
    NphImage z, map;
} Result;

static void print_line(void *user, const char *line) { fprintf(user, "%s\n", line); }

static void print(const CompareCommand *compare, NphReport report) {
    NphJson json;
    if (compare->json) {
        nph_json_begin(&json, nph_json_to_file, stdout);
        nph_comparison_json(report, &json, NULL);
    } else if (!compare->session.quiet) {
        nph_comparison_text(report, print_line, stdout);
    }
}

static NphStatus write_junit(const CompareCommand *compare, NphReport report) {
    NphWriter writer;
    NPH_TRY(nph_writer_open(compare->session.context, compare->junit, &writer));
    nph_comparison_junit(report, compare->suite, nph_json_to_file, writer.stream);
    return nph_writer_commit(compare->session.context, &writer);
}

static NphStatus write_picture(const CompareCommand *compare, const NphImage *a, const NphImage *b, const Result *result) {
    NphContext *context = compare->session.context;
    NphComparePicture picture = {0};
    NPH_TRY(nph_compare_picture(context, a, b, &result->flip, &result->map, &picture));
    NphStatus status = nph_png_write(context, compare->picture, picture.width, picture.height, picture.rgb);
    nph_free(context, picture.rgb);
    return status;
}

static NphStatus make(const CompareCommand *compare, const NphImage *a, const NphImage *b, Result *result) {
    NphContext *context = compare->session.context;
    NPH_TRY(nph_compare(context, a, b, &compare->options, &result->comparison, compare->z_map ? &result->z : NULL));
    if (compare->flip) NPH_TRY(nph_flip(context, a, b, &compare->flip_options, &result->flip, &result->map));
    if (compare->z_map) NPH_TRY(nph_exr_write(context, compare->z_map, &result->z));
    if (compare->flip_map) NPH_TRY(nph_exr_write(context, compare->flip_map, &result->map));
    return compare->picture ? write_picture(compare, a, b, result) : NPH_OK;
}

static NphStatus judge(const CompareCommand *compare, const NphImage *a, const NphImage *b) {
    NphContext *context = compare->session.context;
    Result result;
    memset(&result, 0, sizeof result);
    NphReport report = {&result.comparison, compare->flip ? &result.flip : NULL};
    NphStatus status = make(compare, a, b, &result);
    nph_image_free(context, &result.z);
    nph_image_free(context, &result.map);
    if (status == NPH_OK && compare->junit) status = write_junit(compare, report);
    if (status != NPH_OK) return status;
    print(compare, report);
    return result.comparison.verdict == NPH_SAME ? NPH_OK : NPH_DIFFERENT;
}

static NphStatus compare_files(CompareCommand *compare, const char *path_a, const char *path_b) {
    NphContext *context = compare->session.context;
    NphImage a = {0}, b = {0};
    const char *const targets[] = {compare->z_map, compare->flip_map, compare->picture, compare->junit};
    for (size_t i = 0; i < sizeof targets / sizeof targets[0]; i++)
        if (targets[i]) NPH_TRY(check_writable(&compare->session, targets[i]));
    snprintf(compare->suite, sizeof compare->suite, "%s against %s", path_a, path_b);
    NphStatus status = nph_exr_read(context, path_a, &a);
    if (status == NPH_OK) status = nph_exr_read(context, path_b, &b);
    if (status == NPH_OK) status = judge(compare, &a, &b);
    nph_image_free(context, &a);
    nph_image_free(context, &b);
    return status;
}

/* "STOPS", or "START:STOP:COUNT" of HDR. */
static NphStatus parse_exposure(const char *command, const char *text, NphFlipOptions *options) {
    const char *colon = strchr(text, ':'), *second = colon ? strchr(colon + 1, ':') : NULL;
    double start = 0, stop = 0;
    int64_t count = 1;
    int parsed = colon ? second && nph_parse_double_range(text, colon, &start) &&
                             nph_parse_double_range(colon + 1, second, &stop) && nph_parse_int(second + 1, &count)
                       : nph_parse_double(text, &start);
    if (!colon) stop = start;
    if (!parsed || (colon && options->kind == NPH_FLIP_LDR))
        return usage_error(command, "--exposure %s: expected %s", text,
                           options->kind == NPH_FLIP_LDR ? "STOPS, one number with --flip ldr" : "START:STOP:COUNT or STOPS");
    if (start < -100 || stop > 100 || start > stop || count < 1 || count > NPH_FLIP_EXPOSURES || (count == 1 && start < stop))
        return usage_error(command, "--exposure %s: expected START <= STOP within -100 to 100, and 2 to %d of them", text,
                           NPH_FLIP_EXPOSURES);
    options->start_stops = start;
    options->stop_stops = stop;
    options->exposures = (int)count;
    return NPH_OK;
}

static int ends_in_png(const char *path) {
    size_t length = strlen(path);
    return length > 4 && strcmp(path + length - 4, ".png") == 0;
}

static NphStatus check_flip(const char *command, CompareCommand *compare) {
    NphFlipOptions *options = &compare->flip_options;
    nph_flip_options_default(options);
    if (compare->kind && strcmp(compare->kind, "hdr") != 0 && strcmp(compare->kind, "ldr") != 0)
        return usage_error(command, "--flip %s: expected hdr or ldr", compare->kind);
    if (compare->picture && !ends_in_png(compare->picture))
        return usage_error(command, "--map %s: expected a name that ends in .png", compare->picture);
    if (compare->kind && strcmp(compare->kind, "ldr") == 0) options->kind = NPH_FLIP_LDR;
    if (compare->ppd_given) options->pixels_per_degree = compare->pixels_per_degree;
    compare->flip = compare->kind || compare->exposure || compare->ppd_given || compare->flip_map || compare->picture;
    return compare->exposure ? parse_exposure(command, compare->exposure, options) : NPH_OK;
}

static void add_judging(OptionTable *table, NphCompareOptions *options) {
    option_add(table, (Option){.name = "margin-image", .kind = OPTION_NUMBER, .target = &options->margin_image,
                               .value_name = "M", .min = 0, .max = 10,
                               .meaning = "difference of the whole picture still called same, relative; default 0.002"});
    option_add(table, (Option){.name = "margin-tile", .kind = OPTION_NUMBER, .target = &options->margin_tile,
                               .value_name = "M", .min = 0, .max = 10,
                               .meaning = "the same for tiles of 64 x 64 and 8 x 8 pixels; default 0.01"});
    option_add(table, (Option){.name = "alpha", .kind = OPTION_NUMBER, .target = &options->alpha, .value_name = "P",
                               .min = 1e-9, .max = 0.5, .meaning = "chance of a false verdict; default 0.004"});
}

static void add_flip(OptionTable *table, CompareCommand *compare) {
    option_add(table, (Option){.name = "flip", .kind = OPTION_TEXT, .target = &compare->kind, .value_name = "KIND",
                               .meaning = "how different they look, from 0 to 1: hdr (radiance, the default of the "
                                          "options below) or ldr (linear values from 0 to 1); no part of the verdict"});
    option_add(table, (Option){.name = "exposure", .kind = OPTION_TEXT, .target = &compare->exposure,
                               .value_name = "START:STOP:COUNT",
                               .meaning = "of hdr, in stops; default: from B's luminances; of ldr one number, STOPS"});
    option_add(table, (Option){.name = "ppd", .kind = OPTION_NUMBER, .target = &compare->pixels_per_degree,
                               .value_name = "N", .min = 1, .max = 1000, .given = &compare->ppd_given,
                               .meaning = "pixels per degree of visual angle; default 67.02"});
    option_add(table, (Option){.name = "flip-map", .kind = OPTION_TEXT, .target = &compare->flip_map,
                               .value_name = "FILE.exr", .meaning = "FLIP of each pixel, as a picture"});
    option_add(table, (Option){.name = "map", .kind = OPTION_TEXT, .target = &compare->picture, .value_name = "FILE.png",
                               .meaning = "B, A, their relative difference and FLIP side by side, to look at"});
}

static NphStatus run(const Command *command, int argc, char **argv) {
    CompareCommand compare;
    OptionTable table = {0};
    TextList files = {0};
    NphStatus status = NPH_OK;
    memset(&compare, 0, sizeof compare);
    nph_compare_options_default(&compare.options);
    add_judging(&table, &compare.options);
    option_add(&table, (Option){.name = "z-map", .kind = OPTION_TEXT, .target = &compare.z_map, .value_name = "FILE.exr",
                                .meaning = "each pixel's difference over its standard error, as a picture"});
    add_flip(&table, &compare);
    option_add(&table, (Option){.name = "junit", .kind = OPTION_TEXT, .target = &compare.junit, .value_name = "FILE.xml",
                                .meaning = "the verdict and its levels as JUnit XML too"});
    option_add(&table, (Option){.name = "json", .kind = OPTION_FLAG, .target = &compare.json,
                                .meaning = "as JSON on standard output"});
    session_add_options(&table, &compare.session);
    if (!command_begin(command, &table, argc, argv, &files, &status)) return status;
    NPH_TRY(check_flip(command->name, &compare));
    NPH_TRY(session_open(&compare.session, command->name));
    return session_close(&compare.session, compare_files(&compare, files.items[0], files.items[1]));
}

const Command command_compare = {
    .name = "compare",
    .arguments = "A.exr B.exr [options]",
    .summary = "two pictures, judged by their error bars",
    .before = "Judges A against B over the whole picture, tiles of 64 x 64 and of 8 x 8 pixels: `same` when every\n"
              "difference is shown to be within the margins, `different` when one is shown not to be, `inconclusive` when\n"
              "more samples are needed to tell. Exit status 0 means same, 1 anything else.\n",
    .examples = "  nephos compare mine.exr golden.exr\n"
                "  nephos compare mine.exr golden.exr --margin-image 0.001 --map look.png --junit verdict.xml\n",
    .files_min = 2,
    .files_max = 2,
    .run = run,
};
