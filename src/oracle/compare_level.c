/* SPDX-License-Identifier: Apache-2.0
 *
 * One level of a comparison: the picture cut into tiles, every tile and channel a hypothesis. Holm's procedure keeps
 * the probability of even one false difference below the level's share of the error budget, however the hypotheses
 * depend on each other [Holm79]. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "oracle/compare_parts.h"
#include "oracle/student.h"

/* A difference that is shown is forgiven for its smallness only with this much more certainty. */
static const double forgiveness = 0.1;

static const char *const channel_names[3] = {"R", "G", "B"};

static NphRect tile_rect(const NphPicturePair *pair, int size, int across, int down, int index) {
    NphRect rect = {.size = size};
    nph_region_span(index % across, across, size, pair->width, &rect.x0, &rect.x1);
    nph_region_span(index / across, down, size, pair->height, &rect.y0, &rect.y1);
    return rect;
}

static int compare_numbers(const void *left, const void *right) {
    double a = *(const double *)left, b = *(const double *)right;
    return (a > b) - (a < b);
}

/* The largest p that Holm's procedure rejects, -1 when none: from the smallest p up, the k-th of m (from 0) must not
 * exceed alpha / (m - k). Sorts p. */
static double holm_threshold(double *p, size_t count, double alpha) {
    double threshold = -1.0;
    qsort(p, count, sizeof *p, compare_numbers);
    for (size_t k = 0; k < count && p[k] <= alpha / (double)(count - k); k++) threshold = p[k];
    return threshold;
}

/* The more certain of two differences. */
static int is_stronger(const NphEvidence *a, const NphEvidence *b) {
    if (a->p_equal != b->p_equal) return a->p_equal < b->p_equal;
    return fabs(a->ratio) > fabs(b->ratio);
}

static void keep_stronger(NphFinding *kept, const NphFinding *found) {
    if (kept->channel < 0 || is_stronger(&found->evidence, &kept->evidence)) *kept = *found;
}

/* Noise falls with the root of the samples: were the difference noise alone, |difference| + q standard errors would
 * meet the margin with this many times the samples. */
static double samples_wanted(const NphEvidence *evidence, double alpha_same) {
    double quantile = -nph_student_quantile(alpha_same, evidence->dof);
    double now = fabs(evidence->difference) + quantile * evidence->standard_error;
    return evidence->margin > 0.0 ? now / evidence->margin * (now / evidence->margin) : HUGE_VAL;
}

/* Which of two regions will need more samples; a cheap stand-in for samples_wanted. */
static double noise_in_margins(const NphEvidence *evidence) {
    if (!(evidence->margin > 0.0)) return HUGE_VAL;
    return (fabs(evidence->difference) + 3.0 * evidence->standard_error) / evidence->margin;
}

/* |z| of a normal variable as improbable as p; the ratio itself where p is too small to invert. */
static double equivalent_z(const NphEvidence *evidence) {
    if (evidence->p_equal < 1e-200 || isinf(evidence->dof)) return fabs(evidence->ratio);
    return evidence->p_equal < 1.0 ? -nph_normal_quantile(0.5 * evidence->p_equal) : 0.0;
}

static void name_worst(const NphPicturePair *pair, const NphFinding *worst, NphCompareLevel *level) {
    double scale = nph_pair_scale(pair);
    level->worst_z = equivalent_z(&worst->evidence);
    level->worst_x = pair->x0 + worst->rect.x0;
    level->worst_y = pair->y0 + worst->rect.y0;
    level->worst_size = worst->rect.x1 - worst->rect.x0;
    assert(worst->channel >= 0);
    strcpy(level->worst_channel, pair->channels == 1 ? "RGB" : channel_names[worst->channel]);
    level->worst_difference = worst->evidence.difference / scale;
}

/* Weighs every region and channel, in this order. */
static void weigh_all(const NphPicturePair *pair, const NphLevelTask *task, NphEvidence *evidence) {
    int across = nph_regions_along(pair->width, task->size), down = nph_regions_along(pair->height, task->size);
    for (int i = 0; i < across * down; i++) {
        NphRect rect = tile_rect(pair, task->size, across, down, i);
        for (int c = 0; c < pair->channels; c++) {
            nph_region_weigh(pair, rect, c, task->margin, &evidence[i * pair->channels + c]);
        }
    }
}

/* One region, once the threshold is known. */
static void judge_region(const NphLevelTask *task, double threshold, NphFinding *found, int *different, int *same,
                         NphLevelFindings *findings) {
    const NphEvidence *evidence = &found->evidence;
    int shown_same = evidence->p_beyond < task->alpha_same;
    if (evidence->p_equal <= threshold) {
        int forgiven = evidence->p_beyond < task->alpha_same * forgiveness;
        if (!forgiven) *different = 1;
        keep_stronger(forgiven ? &findings->forgiven : &findings->different, found);
    }
    if (shown_same) return;
    *same = 0;
    NphFinding *undecided = &findings->undecided;
    if (undecided->channel < 0 || noise_in_margins(evidence) > noise_in_margins(&undecided->evidence)) {
        *undecided = *found;
    }
}

static void judge_all(const NphPicturePair *pair, const NphLevelTask *task, const NphEvidence *evidence, double threshold,
                      NphLevelFindings *findings) {
    int across = nph_regions_along(pair->width, task->size), down = nph_regions_along(pair->height, task->size);
    NphFinding worst = {.channel = -1};
    for (int i = 0; i < across * down; i++) {
        int different = 0, same = 1;
        NphFinding found = {.rect = tile_rect(pair, task->size, across, down, i)};
        for (int c = 0; c < pair->channels; c++) {
            found.channel = c;
            found.evidence = evidence[i * pair->channels + c];
            judge_region(task, threshold, &found, &different, &same, findings);
            keep_stronger(&worst, &found);
        }
        findings->level.different += different;
        findings->level.same += same;
    }
    name_worst(pair, &worst, &findings->level);
    if (findings->undecided.channel < 0) return;
    findings->more_samples = samples_wanted(&findings->undecided.evidence, task->alpha_same);
}

NphStatus nph_level_judge(NphContext *context, const NphPicturePair *pair, const NphLevelTask *task,
                          NphLevelFindings *findings) {
    int across = nph_regions_along(pair->width, task->size), down = nph_regions_along(pair->height, task->size);
    size_t count = (size_t)across * (size_t)down * (size_t)pair->channels;
    NphEvidence *evidence = NULL;
    double *p = NULL;
    NPH_TRY(NPH_NEW(context, count, "evidence of a comparison", &evidence));
    NphStatus status = NPH_NEW(context, count, "probabilities of a comparison", &p);
    if (status == NPH_OK) {
        weigh_all(pair, task, evidence);
        for (size_t i = 0; i < count; i++) p[i] = evidence[i].p_equal;
        double threshold = holm_threshold(p, count, task->alpha);
        memset(findings, 0, sizeof *findings);
        findings->different.channel = findings->forgiven.channel = findings->undecided.channel = -1;
        findings->level.name = task->name;
        findings->level.regions = across * down;
        for (int c = 0; c < 3; c++) findings->first[c] = evidence[c < pair->channels ? c : 0];
        judge_all(pair, task, evidence, threshold, findings);
    }
    nph_free(context, p);
    nph_free(context, evidence);
    return status;
}
