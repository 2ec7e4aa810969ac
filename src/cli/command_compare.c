/* SPDX-License-Identifier: Apache-2.0
 *
 * nephos compare: two pictures, judged by their error bars. */
#include <string.h>

#include "cli/command.h"
#include "cli/session.h"
#include "core/json.h"
#include "core/message.h"
#include "nephos/compare.h"

typedef struct CompareCommand {
    Session session;
    NphCompareOptions options;
    const char *z_map;
    int json;
} CompareCommand;

static void print_level(const NphCompareLevel *level) {
    printf("%-10s %8d %10d %8d %11.2f", level->name, level->regions, level->different, level->same, level->worst_z);
    if (level->worst_size)
        printf("   %s at (%d, %d), %+.3g%% of the mean", level->worst_channel, level->worst_x, level->worst_y,
               100 * level->worst_difference);
    putchar('\n');
}

static void print_text(const NphComparison *result) {
    static const char channels[] = "RGB";
    printf("verdict: %s\n%s\n\n", nph_verdict_name(result->verdict), result->reason);
    printf("channel        mean A        mean B    A - B, relative    standard error\n");
    for (int c = 0; c < 3; c++)
        printf("%c      %13.6g %13.6g %17.3g%% %16.3g%%\n", channels[c], result->mean_a[c], result->mean_b[c],
               100 * result->difference[c], 100 * result->standard_error[c]);
    if (result->level_count) printf("\nlevel       regions  different     same   worst |z|\n");
    for (int i = 0; i < result->level_count; i++) print_level(&result->levels[i]);
    printf("\nluminance, relative to the mean of B: bias %.3g%%, RMSE %.3g%%, 99th percentile %.3g%%, largest %.3g%%\n",
           100 * result->relative_bias, 100 * result->relative_rmse, 100 * result->percentile_99, 100 * result->largest);
    printf("pixels: %lld of %lld identical; histogram of their z: p = %.3g; judged %s\n",
           (long long)result->identical_pixels, (long long)result->pixels, result->pixel_histogram_p,
           result->paired ? "as pairs (equal seeds)" : "as independent");
}

static void json_level(NphJson *json, const NphCompareLevel *level) {
    nph_json_object(json, NULL);
    nph_json_text(json, "name", level->name);
    nph_json_integer(json, "regions", level->regions);
    nph_json_integer(json, "different", level->different);
    nph_json_integer(json, "same", level->same);
    nph_json_number(json, "worst_z", level->worst_z);
    nph_json_integer(json, "worst_x", level->worst_x);
    nph_json_integer(json, "worst_y", level->worst_y);
    nph_json_integer(json, "worst_size", level->worst_size);
    nph_json_text(json, "worst_channel", level->worst_channel);
    nph_json_number(json, "worst_difference", level->worst_difference);
    nph_json_close(json);
}

static void print_json(const NphComparison *result) {
    NphJson json;
    nph_json_begin(&json, nph_json_to_file, stdout);
    nph_json_object(&json, NULL);
    nph_json_text(&json, "verdict", nph_verdict_name(result->verdict));
    nph_json_text(&json, "reason", result->reason);
    nph_json_boolean(&json, "paired", result->paired);
    nph_json_numbers(&json, "mean_a", 3, result->mean_a);
    nph_json_numbers(&json, "mean_b", 3, result->mean_b);
    nph_json_numbers(&json, "difference", 3, result->difference);
    nph_json_numbers(&json, "standard_error", 3, result->standard_error);
    nph_json_array(&json, "levels");
    for (int i = 0; i < result->level_count; i++) json_level(&json, &result->levels[i]);
    nph_json_close(&json);
    nph_json_number(&json, "relative_bias", result->relative_bias);
    nph_json_number(&json, "relative_rmse", result->relative_rmse);
    nph_json_number(&json, "percentile_99", result->percentile_99);
    nph_json_number(&json, "largest", result->largest);
    nph_json_number(&json, "pixel_histogram_p", result->pixel_histogram_p);
    nph_json_integer(&json, "pixels", result->pixels);
    nph_json_integer(&json, "identical_pixels", result->identical_pixels);
    nph_json_close(&json);
}

static NphStatus judge(CompareCommand *compare, const NphImage *a, const NphImage *b) {
    NphContext *context = compare->session.context;
    NphComparison result;
    NphImage z = {0};
    memset(&result, 0, sizeof result);
    NPH_TRY(nph_compare(context, a, b, &compare->options, &result, compare->z_map ? &z : NULL));
    NphStatus status = compare->z_map ? nph_exr_write(context, compare->z_map, &z) : NPH_OK;
    nph_image_free(context, &z);
    if (status != NPH_OK) return status;
    if (compare->json) print_json(&result);
    else if (!compare->session.quiet) print_text(&result);
    return result.verdict == NPH_SAME ? NPH_OK : NPH_DIFFERENT;
}

static NphStatus compare_files(CompareCommand *compare, const char *path_a, const char *path_b) {
    NphContext *context = compare->session.context;
    NphImage a = {0}, b = {0};
    if (compare->z_map) NPH_TRY(check_writable(&compare->session, compare->z_map));
    NphStatus status = nph_exr_read(context, path_a, &a);
    if (status == NPH_OK) status = nph_exr_read(context, path_b, &b);
    if (status == NPH_OK) status = judge(compare, &a, &b);
    nph_image_free(context, &a);
    nph_image_free(context, &b);
    return status;
}

static NphStatus run(const Command *command, int argc, char **argv) {
    CompareCommand compare;
    OptionTable table = {0};
    TextList files = {0};
    NphStatus status = NPH_OK;
    memset(&compare, 0, sizeof compare);
    NphCompareOptions *options = &compare.options;
    nph_compare_options_default(options);
    option_add(&table, (Option){.name = "margin-image", .kind = OPTION_NUMBER, .target = &options->margin_image,
                                .value_name = "M", .min = 0, .max = 10,
                                .meaning = "difference of the whole picture still called same, relative; default 0.002"});
    option_add(&table, (Option){.name = "margin-tile", .kind = OPTION_NUMBER, .target = &options->margin_tile,
                                .value_name = "M", .min = 0, .max = 10,
                                .meaning = "the same for tiles of 64 x 64 and 8 x 8 pixels; default 0.01"});
    option_add(&table, (Option){.name = "alpha", .kind = OPTION_NUMBER, .target = &options->alpha, .value_name = "P",
                                .min = 1e-9, .max = 0.5, .meaning = "chance of a false verdict; default 0.004"});
    option_add(&table, (Option){.name = "z-map", .kind = OPTION_TEXT, .target = &compare.z_map, .value_name = "FILE.exr",
                                .meaning = "each pixel's difference over its standard error, as a picture"});
    option_add(&table, (Option){.name = "json", .kind = OPTION_FLAG, .target = &compare.json,
                                .meaning = "as JSON on standard output"});
    session_add_options(&table, &compare.session);
    if (!command_begin(command, &table, argc, argv, &files, &status)) return status;
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
    .examples = "  nephos compare golden.exr mine.exr\n"
                "  nephos compare a.exr b.exr --margin-image 0.001 --z-map z.exr\n",
    .files_min = 2,
    .files_max = 2,
    .run = run,
};
