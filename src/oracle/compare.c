/* SPDX-License-Identifier: Apache-2.0
 *
 * The verdict on two pictures, from the evidence of three levels. Different: some region differs significantly and is
 * not shown to differ by less than the margin. Same: every region is shown to. Inconclusive: the rest, noise. */
#include "nephos/compare.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/message.h"
#include "core/text.h"
#include "oracle/compare_parts.h"

/* Everything the verdict is drawn from. */
typedef struct Case {
    const NphCompareOptions *options;
    NphPicturePair pair;
    NphHistogram histogram;
    int level_count;
    NphLevelTask tasks[3];
    NphLevelFindings findings[3];
} Case;

void nph_compare_options_default(NphCompareOptions *options) {
    *options = (NphCompareOptions){.margin_image = 0.002, .margin_tile = 0.01, .alpha = 0.004};
}

const char *nph_verdict_name(NphVerdict verdict) {
    return verdict == NPH_SAME ? "same" : verdict == NPH_NOT_SAME ? "different" : "inconclusive";
}

static NphStatus check_options(NphContext *context, const NphCompareOptions *options) {
    char text[NPH_DOUBLE_TEXT];
    if (!(options->margin_image >= 0.0) || !(options->margin_image < 1e6)) {
        return nph_error(context, NPH_BAD_USAGE, "the image's margin is %s; it is a fraction from 0 (0.002 is 0.2%%)",
                         nph_format_double(options->margin_image, text));
    }
    if (!(options->margin_tile >= 0.0) || !(options->margin_tile < 1e6)) {
        return nph_error(context, NPH_BAD_USAGE, "the tiles' margin is %s; it is a fraction from 0 (0.01 is 1%%)",
                         nph_format_double(options->margin_tile, text));
    }
    if (!(options->alpha > 0.0) || !(options->alpha <= 0.5)) {
        return nph_error(context, NPH_BAD_USAGE, "the error budget is %s; it is a probability above 0, at most 0.5",
                         nph_format_double(options->alpha, text));
    }
    return NPH_OK;
}

/* The levels that say something of their own, and each one's share of the budget. */
static void plan_levels(Case *judged) {
    static const char *const names[3] = {"image", "64^2 tiles", "8^2 tiles"};
    static const int sizes[3] = {0, 64, 8};
    const NphCompareOptions *options = judged->options;
    int longest = judged->pair.width > judged->pair.height ? judged->pair.width : judged->pair.height;
    for (int i = 0; i < 3; i++) {
        if (2 * longest < 3 * sizes[i]) continue; /* a single tile: the image again */
        judged->tasks[judged->level_count++] = (NphLevelTask){names[i], sizes[i],
            sizes[i] == 0 ? options->margin_image : options->margin_tile, 0.0, options->alpha};
    }
    for (int i = 0; i < judged->level_count; i++) judged->tasks[i].alpha = options->alpha / judged->level_count;
}

/* Reasons are put together from pieces; what does not fit is cut off. */
static void add(NphComparison *comparison, const char *text) {
    size_t used = strlen(comparison->reason);
    snprintf(comparison->reason + used, sizeof comparison->reason - used, "%s", text);
}

static void add_number(NphComparison *comparison, double value, int digits) {
    char text[NPH_DOUBLE_TEXT];
    add(comparison, nph_format_rounded(value, digits, text));
}

static void add_percent(NphComparison *comparison, double fraction) {
    add_number(comparison, 100.0 * fraction, 3);
    add(comparison, "%");
}

static void add_place(const Case *judged, int level, const NphFinding *found, NphComparison *comparison) {
    static const char *const names[3] = {"R", "G", "B"};
    char text[96];
    const NphRect *rect = &found->rect;
    if (judged->tasks[level].size == 0) {
        add(comparison, "image");
    } else {
        snprintf(text, sizeof text, "tile of %d x %d pixels at (%d, %d)", rect->x1 - rect->x0, rect->y1 - rect->y0,
                 judged->pair.x0 + rect->x0, judged->pair.y0 + rect->y0);
        add(comparison, text);
    }
    snprintf(text, sizeof text, ", channel %s: ", judged->pair.channels == 1 ? "R = G = B" : names[found->channel]);
    add(comparison, text);
}

/* "A is 0.21% above B, 6.9 standard errors (p = 5e-12)" */
static void add_difference(const Case *judged, int level, const NphFinding *found, NphComparison *comparison) {
    const NphEvidence *evidence = &found->evidence;
    double margin = judged->tasks[level].margin;
    add_place(judged, level, found, comparison);
    add(comparison, "A is ");
    if (margin > 0.0 && evidence->margin > 0.0) {
        add_percent(comparison, fabs(evidence->difference) / evidence->margin * margin);
    } else {
        add_number(comparison, fabs(evidence->difference), 3);
    }
    add(comparison, evidence->difference < 0.0 ? " below B, " : " above B, ");
    if (evidence->standard_error > 0.0) {
        add_number(comparison, fabs(evidence->ratio), 3);
        add(comparison, " standard errors (p = ");
        add_number(comparison, evidence->p_equal, 2);
        add(comparison, ")");
    } else {
        add(comparison, "without any noise");
    }
}

static int draw_different(const Case *judged, NphComparison *comparison) {
    for (int i = 0; i < judged->level_count; i++) {
        if (judged->findings[i].different.channel < 0) continue;
        add_difference(judged, i, &judged->findings[i].different, comparison);
        return 1;
    }
    return 0;
}

/* A level that noise keeps from being shown the same. */
static int is_undecided(const Case *judged, int level) {
    if (judged->options->allow_noisy_tiles && judged->tasks[level].size > 0) return 0;
    return judged->findings[level].undecided.channel >= 0;
}

static NphVerdict verdict_of_level(const Case *judged, int level) {
    if (judged->findings[level].different.channel >= 0) return NPH_NOT_SAME;
    return is_undecided(judged, level) ? NPH_INCONCLUSIVE : NPH_SAME;
}

static int draw_inconclusive(const Case *judged, NphComparison *comparison) {
    int undecided = -1;
    for (int i = 0; i < judged->level_count; i++) {
        if (!is_undecided(judged, i)) continue;
        if (undecided < 0 || judged->findings[i].more_samples > judged->findings[undecided].more_samples) undecided = i;
    }
    if (undecided < 0) return 0;
    const NphLevelFindings *findings = &judged->findings[undecided];
    const NphEvidence *evidence = &findings->undecided.evidence;
    double scale = evidence->margin > 0.0 ? judged->tasks[undecided].margin / evidence->margin : 0.0;
    char text[128];
    add(comparison, "no difference is shown, but ");
    snprintf(text, sizeof text, "%d of %d regions of level \"%s\" are too noisy for a margin of ",
             findings->level.regions - findings->level.same, findings->level.regions, findings->level.name);
    add(comparison, text);
    add_percent(comparison, judged->tasks[undecided].margin);
    add(comparison, "; noisiest: ");
    add_place(judged, undecided, &findings->undecided, comparison);
    if (scale == 0.0) {
        add(comparison, "B is black or the margin 0, so that no noise is small enough");
        return 1;
    }
    add_percent(comparison, evidence->difference * scale);
    add(comparison, " with a standard error of ");
    add_percent(comparison, evidence->standard_error * scale);
    add(comparison, "; about ");
    add_number(comparison, ceil(10.0 * findings->more_samples) / 10.0, findings->more_samples < 10.0 ? 2 : 3);
    add(comparison, " times the samples in both pictures would decide");
    return 1;
}

static void draw_same(const Case *judged, NphComparison *comparison) {
    int noisy = 0;
    add(comparison, "every region shown is within its margin");
    for (int i = 0; i < judged->level_count; i++) {
        const NphFinding *forgiven = &judged->findings[i].forgiven;
        noisy += judged->findings[i].level.regions - judged->findings[i].level.same;
        if (forgiven->channel < 0) continue;
        add(comparison, "; significant but within it: ");
        add_difference(judged, i, forgiven, comparison);
    }
    if (noisy == 0) return;
    char text[96];
    snprintf(text, sizeof text, "; %d tiles are too noisy to be shown, as allowed", noisy);
    add(comparison, text);
}

/* The case without usable variances. */
static int draw_without_noise(const Case *judged, NphComparison *comparison) {
    const NphPicturePair *pair = &judged->pair;
    char text[160];
    if (pair->identical == pair->pixels) {
        add(comparison, "every pixel is equal");
        comparison->verdict = NPH_SAME;
    } else if (!pair->has_variance) {
        int a = pair->a.variance[0] != NULL, b = pair->b.variance[0] != NULL;
        add(comparison, "without Variance.R, .G and .B in ");
        add(comparison, a == b ? "both pictures" : a ? "B" : "A");
        snprintf(text, sizeof text, " only equal pixels are the same; %lld of %lld differ",
                 (long long)(pair->pixels - pair->identical), (long long)pair->pixels);
        add(comparison, text);
        comparison->verdict = NPH_NOT_SAME;
    } else if (pair->few_images) {
        snprintf(text, sizeof text, "pixels share samples: the error bar of a tile takes at least %d samples of the picture",
                 NPH_IMAGES_LEAST);
        add(comparison, text);
        comparison->verdict = NPH_INCONCLUSIVE;
    } else {
        snprintf(text, sizeof text, "the variance of pixel (%d, %d) ", pair->x0 + (int)(pair->unusable % pair->width),
                 pair->y0 + (int)(pair->unusable / pair->width));
        add(comparison, text);
        add(comparison, "says nothing: a single sample, or out of a float's range");
        comparison->verdict = NPH_INCONCLUSIVE;
    }
    return 1;
}

static void fill_means(const NphPicturePair *pair, NphComparison *comparison) {
    for (int c = 0; c < 3; c++) {
        double a = 0.0, b = 0.0;
        for (int64_t i = 0; i < pair->pixels; i++) {
            a += (double)pair->a.value[c][i];
            b += (double)pair->b.value[c][i];
        }
        double scale = nph_pair_scale(pair);
        comparison->mean_a[c] = a / (double)pair->pixels;
        comparison->mean_b[c] = b / (double)pair->pixels;
        comparison->difference[c] = (a - b) / (double)pair->pixels / scale;
    }
}

/* The error bars themselves; what they are worth, not whether the pictures differ. */
static void add_histogram(const Case *judged, NphComparison *comparison) {
    const NphHistogram *histogram = &judged->histogram;
    if (histogram->p >= judged->options->alpha) return;
    add(comparison, "; single pixels scatter ");
    add_number(comparison, sqrt(histogram->dispersion), 3);
    add(comparison, " times as wide as their error bars, which are not what they should be (p = ");
    add_number(comparison, histogram->p, 2);
    add(comparison, ")");
}

static NphStatus judge_levels(NphContext *context, Case *judged, NphComparison *comparison) {
    nph_pixels_histogram(&judged->pair, &judged->histogram);
    comparison->pixel_histogram_p = judged->histogram.p;
    comparison->pixel_histogram_not_tested = judged->histogram.not_tested;
    plan_levels(judged);
    for (int i = 0; i < judged->level_count; i++) {
        NPH_TRY(nph_level_judge(context, &judged->pair, &judged->tasks[i], &judged->findings[i]));
        comparison->levels[i] = judged->findings[i].level;
        comparison->levels[i].verdict = verdict_of_level(judged, i);
    }
    comparison->level_count = judged->level_count;
    double scale = nph_pair_scale(&judged->pair);
    for (int c = 0; c < 3; c++) {
        comparison->standard_error[c] = judged->findings[0].first[c].standard_error / scale;
    }
    if (draw_different(judged, comparison)) {
        comparison->verdict = NPH_NOT_SAME;
    } else if (draw_inconclusive(judged, comparison)) {
        comparison->verdict = NPH_INCONCLUSIVE;
    } else {
        draw_same(judged, comparison);
        comparison->verdict = NPH_SAME;
    }
    add_histogram(judged, comparison);
    return NPH_OK;
}

NphStatus nph_compare(NphContext *context, const NphImage *a, const NphImage *b, const NphCompareOptions *options,
                      NphComparison *comparison, NphImage *z_map) {
    Case judged = {.options = options};
    NphComparison made = {.pixel_histogram_p = 1.0, .pixel_histogram_not_tested = "no variances"};
    NPH_TRY(check_options(context, options));
    NPH_TRY(nph_pair_read(context, a, b, &judged.pair));
    made.paired = judged.pair.paired;
    made.pixels = judged.pair.pixels;
    made.identical_pixels = judged.pair.identical;
    fill_means(&judged.pair, &made);
    NPH_TRY(nph_pixels_metrics(context, &judged.pair, &made));
    if (judged.pair.identical < judged.pair.pixels && judged.pair.has_variance && judged.pair.unusable < 0 &&
        !judged.pair.few_images) {
        NPH_TRY(judge_levels(context, &judged, &made));
    } else {
        draw_without_noise(&judged, &made);
    }
    if (z_map) {
        NPH_TRY(nph_pixels_map(context, &judged.pair, z_map));
        z_map->full_width = a->full_width;
        z_map->full_height = a->full_height;
    }
    *comparison = made;
    return NPH_OK;
}
