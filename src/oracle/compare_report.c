/* SPDX-License-Identifier: Apache-2.0
 *
 * See compare_report.h. Numbers go through core/text: the same in every locale. */
#include "oracle/compare_report.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "core/text.h"

enum { LINE = 1024 };

/* "+0.21%": three significant digits. */
typedef struct Percent {
    char text[NPH_DOUBLE_TEXT + 4];
} Percent;

static Percent percent(double fraction, int with_sign) {
    Percent made;
    char number[NPH_DOUBLE_TEXT];
    snprintf(made.text, sizeof made.text, "%s%s%%", with_sign && fraction > 0.0 ? "+" : "",
             nph_format_rounded(100.0 * fraction, 3, number));
    return made;
}

static void put_channels(const NphComparison *comparison, NphLineFn line, void *user) {
    char text[LINE], number[2][3][NPH_DOUBLE_TEXT];
    Percent difference[3], error[3];
    for (int c = 0; c < 3; c++) {
        nph_format_rounded(comparison->mean_a[c], 6, number[0][c]);
        nph_format_rounded(comparison->mean_b[c], 6, number[1][c]);
        difference[c] = percent(comparison->difference[c], 1);
        error[c] = percent(comparison->standard_error[c], 0);
    }
    snprintf(text, sizeof text, "%-15s%14s%14s%14s", "", "R", "G", "B");
    line(user, text);
    for (int k = 0; k < 2; k++) {
        snprintf(text, sizeof text, "%-15s%14s%14s%14s", k ? "mean of B" : "mean of A", number[k][0], number[k][1],
                 number[k][2]);
        line(user, text);
    }
    snprintf(text, sizeof text, "%-15s%14s%14s%14s  of B's mean luminance", "A - B", difference[0].text,
             difference[1].text, difference[2].text);
    line(user, text);
    if (comparison->level_count == 0) return;
    snprintf(text, sizeof text, "%-15s%14s%14s%14s", "standard error", error[0].text, error[1].text, error[2].text);
    line(user, text);
}

/* "G at (16, 0), 104 wide: +0.21% of the image's luminance" */
static const char *worst_words(const NphCompareLevel *level, char text[NPH_LEVEL_WORDS]) {
    snprintf(text, NPH_LEVEL_WORDS, "%s at (%d, %d), %d wide: %s of the image's luminance", level->worst_channel,
             level->worst_x, level->worst_y, level->worst_size, percent(level->worst_difference, 1).text);
    return text;
}

const char *nph_level_words(const NphCompareLevel *level, char text[NPH_LEVEL_WORDS]) {
    char worst[NPH_LEVEL_WORDS], z[NPH_DOUBLE_TEXT];
    snprintf(text, NPH_LEVEL_WORDS, "%d of %d regions different, %d shown same, largest |z| %s: %.160s", level->different,
             level->regions, level->same, nph_format_rounded(level->worst_z, 3, z), worst_words(level, worst));
    return text;
}

static void put_levels(const NphComparison *comparison, NphLineFn line, void *user) {
    char text[LINE], z[NPH_DOUBLE_TEXT], worst[NPH_LEVEL_WORDS];
    if (comparison->level_count == 0) return;
    snprintf(text, sizeof text, "%-15s%9s%11s%12s%13s  worst region", "level", "regions", "different", "shown same",
             "largest |z|");
    line(user, text);
    for (int i = 0; i < comparison->level_count; i++) {
        const NphCompareLevel *level = &comparison->levels[i];
        snprintf(text, sizeof text, "%-15s%9d%11d%12d%13s  %s", level->name, level->regions, level->different,
                 level->same, nph_format_rounded(level->worst_z, 3, z), worst_words(level, worst));
        line(user, text);
    }
}

static const char *kind_name(NphFlipKind kind) { return kind == NPH_FLIP_LDR ? "LDR" : "HDR"; }

/* "3 exposures from -1.9 to +0.64 stops, " */
static const char *exposure_words(const NphFlip *flip, char *text, size_t size) {
    char number[2][NPH_DOUBLE_TEXT];
    const char *start = nph_format_rounded(flip->start_stops, 3, number[0]);
    text[0] = 0;
    if (flip->exposures == 1) snprintf(text, size, "one exposure of %s stops, ", start);
    if (flip->exposures > 1)
        snprintf(text, size, "%d exposures from %s to %s stops, ", flip->exposures, start,
                 nph_format_rounded(flip->stop_stops, 3, number[1]));
    return text;
}

static void put_flip(const NphFlip *flip, NphLineFn line, void *user) {
    char text[LINE], number[4][NPH_DOUBLE_TEXT], noise[128], exposures[128];
    snprintf(noise, sizeof noise, "%s%s", flip->noise_unknown ? "unknown: " : "",
             flip->noise_unknown ? flip->noise_unknown : nph_format_rounded(flip->noise_mean, 3, number[0]));
    snprintf(text, sizeof text,
             "%s-FLIP       mean %s (noise alone: %s), largest %s at (%d, %d); %s%s pixels per degree", kind_name(flip->kind),
             nph_format_rounded(flip->mean, 3, number[1]), noise, nph_format_rounded(flip->largest, 3, number[2]),
             flip->largest_x, flip->largest_y, exposure_words(flip, exposures, sizeof exposures),
             nph_format_rounded(flip->pixels_per_degree, 6, number[3]));
    line(user, text);
}

void nph_comparison_text(NphReport report, NphLineFn line, void *user) {
    const NphComparison *comparison = report.comparison;
    char text[LINE], p[NPH_DOUBLE_TEXT];
    snprintf(text, sizeof text, "%s: %s", nph_verdict_name(comparison->verdict), comparison->reason);
    line(user, text);
    snprintf(text, sizeof text, "%" PRId64 " pixels, %" PRId64 " of them equal%s", comparison->pixels,
             comparison->identical_pixels,
             comparison->paired ? "; same scene and seed: judged by the scatter of pixel differences" : "");
    line(user, text);
    put_channels(comparison, line, user);
    put_levels(comparison, line, user);
    Percent noise = percent(comparison->noise_rmse, 0);
    snprintf(text, sizeof text, "luminance      bias %s, RMSE %s%s%s%s, 99th percentile %s, largest %s",
             percent(comparison->relative_bias, 1).text, percent(comparison->relative_rmse, 0).text,
             comparison->level_count ? " (noise alone: at most " : "", comparison->level_count ? noise.text : "",
             comparison->level_count ? ")" : "", percent(comparison->percentile_99, 0).text,
             percent(comparison->largest, 0).text);
    line(user, text);
    if (comparison->pixel_histogram_not_tested) {
        snprintf(text, sizeof text, "pixels' z      histogram not tested: %s", comparison->pixel_histogram_not_tested);
    } else {
        snprintf(text, sizeof text, "pixels' z      histogram against Student t: p = %s",
                 nph_format_rounded(comparison->pixel_histogram_p, 2, p));
    }
    line(user, text);
    if (report.flip) put_flip(report.flip, line, user);
}

static void put_level_json(const NphCompareLevel *level, NphJson *json) {
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
    nph_json_text(json, "verdict", nph_verdict_name(level->verdict));
    nph_json_close(json);
}

static void put_flip_json(const NphFlip *flip, NphJson *json) {
    nph_json_object(json, "flip");
    nph_json_text(json, "kind", kind_name(flip->kind));
    nph_json_number(json, "mean", flip->mean);
    if (flip->noise_unknown) {
        nph_json_text(json, "noise_mean", NULL);
        nph_json_text(json, "noise_unknown", flip->noise_unknown);
    } else {
        nph_json_number(json, "noise_mean", flip->noise_mean);
    }
    nph_json_number(json, "largest", flip->largest);
    nph_json_integer(json, "largest_x", flip->largest_x);
    nph_json_integer(json, "largest_y", flip->largest_y);
    nph_json_integer(json, "exposures", flip->exposures);
    nph_json_number(json, "start_stops", flip->start_stops);
    nph_json_number(json, "stop_stops", flip->stop_stops);
    nph_json_number(json, "pixels_per_degree", flip->pixels_per_degree);
    nph_json_close(json);
}

void nph_comparison_json(NphReport report, NphJson *json, const char *key) {
    const NphComparison *comparison = report.comparison;
    nph_json_object(json, key);
    nph_json_text(json, "verdict", nph_verdict_name(comparison->verdict));
    nph_json_text(json, "reason", comparison->reason);
    nph_json_boolean(json, "paired", comparison->paired);
    nph_json_integer(json, "pixels", comparison->pixels);
    nph_json_integer(json, "identical_pixels", comparison->identical_pixels);
    nph_json_numbers(json, "mean_a", 3, comparison->mean_a);
    nph_json_numbers(json, "mean_b", 3, comparison->mean_b);
    nph_json_numbers(json, "difference", 3, comparison->difference);
    nph_json_numbers(json, "standard_error", 3, comparison->standard_error);
    nph_json_array(json, "levels");
    for (int i = 0; i < comparison->level_count; i++) put_level_json(&comparison->levels[i], json);
    nph_json_close(json);
    nph_json_number(json, "relative_bias", comparison->relative_bias);
    nph_json_number(json, "relative_rmse", comparison->relative_rmse);
    nph_json_number(json, "noise_rmse", comparison->noise_rmse);
    nph_json_number(json, "percentile_99", comparison->percentile_99);
    nph_json_number(json, "largest", comparison->largest);
    if (comparison->pixel_histogram_not_tested) {
        nph_json_text(json, "pixel_histogram_p", NULL);
        nph_json_text(json, "pixel_histogram_not_tested", comparison->pixel_histogram_not_tested);
    } else {
        nph_json_number(json, "pixel_histogram_p", comparison->pixel_histogram_p);
    }
    if (report.flip) put_flip_json(report.flip, json);
    nph_json_close(json);
}
