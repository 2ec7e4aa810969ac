/* SPDX-License-Identifier: Apache-2.0
 *
 * See diagnose.h. Whether B is excluded is the comparison's verdict; the score ranks what is left, and sees more: all tiles
 * together, where the verdict looks for one. */
#include "oracle/diagnose.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "oracle/compare_parts.h"

static const double tail = 8.0;        /* degrees of freedom of the score */
static const double roundings = 0.002; /* of a tile's luminance, or of a tenth of the picture's: what is not noise */
enum { TILE = 8 };

static const char *const values[3] = {"R", "G", "B"};
static const char *const variances[3] = {"Variance.R", "Variance.G", "Variance.B"};
static const char *const vovs[3] = {"Vov.R", "Vov.G", "Vov.B"};

static float *plane(const NphImage *image, const char *name) {
    const NphChannel *channel = nph_image_channel(image, name);
    return channel ? channel->pixels : NULL;
}

int nph_fit_clean(NphImage *image) {
    int64_t count = (int64_t)image->width * image->height;
    for (int c = 0; c < 3; c++) {
        float *value = plane(image, values[c]), *variance = plane(image, variances[c]), *vov = plane(image, vovs[c]);
        for (int64_t i = 0; i < count; i++) {
            if (!isfinite(value[i]) || !(variance[i] < FLT_MAX) || !isfinite(vov[i])) return 0;
            if (variance[i] == 0.0f) vov[i] = 0.0f;
        }
    }
    return 1;
}

/* ---- the noise of a picture without error bars ---- */

/* A tile's squares of alternating sums, and what B's noise alone would make them. */
typedef struct Detail {
    double ratio, found, expected;
} Detail;

static int compare_details(const void *left, const void *right) {
    double a = ((const Detail *)left)->ratio, b = ((const Detail *)right)->ratio;
    return (a > b) - (a < b);
}

static Detail detail_of(const NphPicturePair *pair, int x0, int y0) {
    Detail detail = {0};
    for (int y = y0; y + 1 < pair->height && y < y0 + TILE; y += 2)
        for (int x = x0; x + 1 < pair->width && x < x0 + TILE; x += 2)
            for (int c = 0; c < 3; c++) {
                double sum = 0.0, noise = 0.0;
                for (int k = 0; k < 4; k++) {
                    int64_t i = (int64_t)(y + k / 2) * pair->width + x + k % 2;
                    double d = (double)pair->a.value[c][i] - (double)pair->b.value[c][i];
                    sum += k == 1 || k == 2 ? -d : d;
                    noise += (double)pair->b.variance[c][i];
                }
                detail.found += 0.25 * sum * sum;
                detail.expected += 0.25 * noise;
            }
    detail.ratio = detail.expected > 0.0 ? detail.found / detail.expected : 0.0;
    return detail;
}

/* Variance of A over that of B. */
static NphStatus estimate_noise(NphContext *context, const NphPicturePair *pair, double *ratio) {
    int across = (pair->width + TILE - 1) / TILE, down = (pair->height + TILE - 1) / TILE, count = 0;
    Detail *details = NULL;
    NPH_TRY(NPH_NEW(context, across * down, "noise of a picture", &details));
    for (int i = 0; i < across * down; i++) {
        details[count] = detail_of(pair, i % across * TILE, i / across * TILE);
        count += details[count].expected > 0.0;
    }
    qsort(details, (size_t)count, sizeof *details, compare_details);
    double found = 0.0, expected = 0.0;
    for (int i = count / 10; i < count - count / 10; i++) {
        found += details[i].found;
        expected += details[i].expected;
    }
    nph_free(context, details);
    *ratio = expected > 0.0 && found > expected ? found / expected - 1.0 : 0.0;
    return NPH_OK;
}

static NphStatus lend_planes(NphContext *context, const NphPicturePair *pair, double ratio, NphImage *lent) {
    for (int c = 0; c < 3; c++) {
        float *value, *variance, *vov;
        NPH_TRY(nph_image_add_channel(context, lent, values[c], &value));
        NPH_TRY(nph_image_add_channel(context, lent, variances[c], &variance));
        NPH_TRY(nph_image_add_channel(context, lent, vovs[c], &vov));
        for (int64_t i = 0; i < pair->pixels; i++) {
            value[i] = pair->a.value[c][i];
            variance[i] = (float)(ratio * (double)pair->b.variance[c][i]);
            vov[i] = pair->b.vov[c] && variance[i] > 0.0f ? pair->b.vov[c][i] : 0.0f;
        }
    }
    return NPH_OK;
}

NphStatus nph_lend_noise(NphContext *context, const NphImage *a, const NphImage *b, double a_samples, NphImage *lent) {
    NphPicturePair pair;
    double ratio = 0.0;
    NPH_TRY(nph_pair_read(context, a, b, &pair));
    if (a_samples > 0.0) ratio = nph_pixel_samples(&pair.b, 0) / a_samples;
    else NPH_TRY(estimate_noise(context, &pair, &ratio));
    NphImage made;
    NPH_TRY(nph_image_new(context, a->width, a->height, &made));
    made.x0 = a->x0;
    made.y0 = a->y0;
    NphStatus status = lend_planes(context, &pair, ratio, &made);
    if (status == NPH_OK) *lent = made;
    else nph_image_free(context, &made);
    return status;
}

/* ---- the score ---- */

/* Variance of the mean over the tile of one side, in parts of that of the difference. */
static double share_of_b(const NphPicturePair *pair, const NphRect *rect, int channel, double standard_error) {
    double sum = 0.0, count = (double)(rect->x1 - rect->x0) * (rect->y1 - rect->y0);
    for (int y = rect->y0; y < rect->y1; y++)
        for (int x = rect->x0; x < rect->x1; x++) sum += (double)pair->b.variance[channel][(int64_t)y * pair->width + x];
    double variance = standard_error * standard_error * count * count;
    return variance > sum ? sum / variance : 1.0;
}

/* The floor under a standard error does not depend on B: it is taken from A. */
static double floor_of(const NphPicturePair *pair, const NphRect *rect) {
    double sum = 0.0, least = 0.1 * fabs(pair->luminance_a);
    for (int y = rect->y0; y < rect->y1; y++)
        for (int x = rect->x0; x < rect->x1; x++) sum += nph_pixel_luminance(&pair->a, (int64_t)y * pair->width + x);
    double luminance = fabs(sum) / ((double)(rect->x1 - rect->x0) * (rect->y1 - rect->y0));
    return roundings * (luminance > least ? luminance : least) + DBL_MIN;
}

/* Student's t, but for constants; square: of the difference over its standard error. */
static double log_likelihood(double square) { return -0.5 * (tail + 1.0) * log1p(square / tail); }

/* A region's channel: its part of the score; *error: the standard error with its floor. */
static double score_region(const NphPicturePair *pair, NphRect rect, int channel, double *error) {
    NphEvidence evidence;
    nph_region_weigh(pair, rect, channel, 0.0, &evidence);
    *error = hypot(evidence.standard_error, floor_of(pair, &rect));
    double z = evidence.difference / *error;
    return log_likelihood(z * z) - log(*error);
}

/* Variance of the score of a region by a part r of its variance, near its expectation. */
static double spread_by(double part) { return part * (1.0 - part) + 0.5 * part * part; }

static NphRect score_rect(const NphPicturePair *pair, int across, int index) {
    NphRect rect = {.size = TILE};
    int down = nph_regions_along(pair->height, TILE);
    nph_region_span(index % across, across, TILE, pair->width, &rect.x0, &rect.x1);
    nph_region_span(index / across, down, TILE, pair->height, &rect.y0, &rect.y1);
    return rect;
}

/* A tile's channels tell of one light: the mean of them counts. */
static void score(const NphPicturePair *pair, NphFit *fit) {
    double variance = 0.0, channels = pair->channels, error;
    int across = nph_regions_along(pair->width, TILE), down = nph_regions_along(pair->height, TILE);
    for (int i = 0; i < across * down; i++) {
        NphRect rect = score_rect(pair, across, i);
        for (int c = 0; c < pair->channels; c++) {
            fit->score += score_region(pair, rect, c, &error) / channels;
            variance += spread_by(share_of_b(pair, &rect, c, error)) / channels;
        }
    }
    fit->tiles = (double)across * down;
    fit->score_noise = sqrt(variance);
}

/* Of three pairs: A with both pictures, and these with each other, whose noise is mostly the same. */
static void sum_lead(const NphPicturePair pairs[3], NphLead *lead) {
    double sum = 0.0, variance = 0.0, reach = 0.0, error[2], channels = pairs[0].channels > pairs[1].channels ? pairs[0].channels : pairs[1].channels;
    int across = nph_regions_along(pairs[0].width, TILE), down = nph_regions_along(pairs[0].height, TILE);
    for (int i = 0; i < across * down; i++) {
        NphRect rect = score_rect(&pairs[0], across, i);
        for (int c = 0; c < (int)channels; c++) {
            NphEvidence between;
            sum += score_region(&pairs[0], rect, c, &error[0]) - score_region(&pairs[1], rect, c, &error[1]);
            nph_region_weigh(&pairs[2], rect, c, 0.0, &between);
            double least = error[0] < error[1] ? error[0] : error[1], part = between.standard_error / least;
            variance += spread_by(part < 1.0 ? part * part : 1.0);
            double own = error[0] * error[0] * (1.0 - share_of_b(&pairs[0], &rect, c, error[0]));
            if (own > 0.0) reach -= log_likelihood(between.difference * between.difference / own);
        }
    }
    *lead = (NphLead){sum / channels, sqrt(variance / channels), reach / channels};
}

NphStatus nph_fit_lead(NphContext *context, const NphImage *a, const NphImage *const pictures[2], const NphFitOptions *options,
                       NphLead *lead) {
    NphPicturePair pairs[3];
    NphImage lent = {0};
    NPH_TRY(nph_pair_read(context, a, pictures[0], &pairs[0]));
    int lend = !pairs[0].has_variance || pairs[0].unusable >= 0;
    if (lend) NPH_TRY(nph_lend_noise(context, a, pictures[0], options->a_samples, &lent));
    const NphImage *seen = lend ? &lent : a;
    NphStatus status = nph_pair_read(context, seen, pictures[0], &pairs[0]);
    if (status == NPH_OK) status = nph_pair_read(context, seen, pictures[1], &pairs[1]);
    if (status == NPH_OK) status = nph_pair_read(context, pictures[0], pictures[1], &pairs[2]);
    if (status == NPH_OK) sum_lead(pairs, lead);
    nph_image_free(context, &lent);
    return status;
}

/* ---- ratios of means ---- */

/* Mean and standard error of a channel; 3: of luminance, whose channels are taken as fully correlated. */
static void mean_of(const NphPicture *picture, int64_t pixels, double mean[4], double error[4]) {
    static const double weight[3] = {NPH_LUMINANCE_R, NPH_LUMINANCE_G, NPH_LUMINANCE_B};
    mean[3] = error[3] = 0.0;
    for (int c = 0; c < 3; c++) {
        double sum = 0.0, variance = 0.0;
        for (int64_t i = 0; i < pixels; i++) {
            sum += (double)picture->value[c][i];
            variance += (double)picture->variance[c][i];
        }
        mean[c] = sum / (double)pixels;
        error[c] = picture->shared ? sqrt((double)picture->region_variance[nph_level_of(0)][c][0]) : sqrt(variance) / (double)pixels;
        mean[3] += weight[c] * mean[c];
        error[3] += weight[c] * error[c];
    }
}

static void fill_ratios(const NphPicturePair *pair, NphFit *fit) {
    double a[4], b[4], error_a[4], error_b[4];
    mean_of(&pair->a, pair->pixels, a, error_a);
    mean_of(&pair->b, pair->pixels, b, error_b);
    for (int c = 0; c < 4; c++) {
        fit->ratio[c] = b[c] != 0.0 ? a[c] / b[c] : (double)NAN;
        fit->ratio_error[c] = b[c] != 0.0 ? hypot(error_a[c], fit->ratio[c] * error_b[c]) / fabs(b[c]) : (double)NAN;
    }
}

static NphStatus fit_noisy(NphContext *context, const NphImage *a, const NphImage *b, const NphFitOptions *options, NphFit *fit) {
    NphCompareOptions compare;
    NphComparison comparison;
    NphPicturePair pair;
    nph_compare_options_default(&compare);
    compare.alpha = options->alpha;
    compare.allow_noisy_tiles = 1;
    NPH_TRY(nph_compare(context, a, b, &compare, &comparison, NULL));
    NPH_TRY(nph_pair_read(context, a, b, &pair));
    fit->excluded = comparison.verdict == NPH_NOT_SAME;
    memcpy(fit->reason, comparison.reason, sizeof fit->reason);
    fill_ratios(&pair, fit);
    score(&pair, fit);
    return NPH_OK;
}

NphStatus nph_fit(NphContext *context, const NphImage *a, const NphImage *b, const NphFitOptions *options, NphFit *fit) {
    NphPicturePair pair;
    NphFit made = {0};
    NphImage lent = {0};
    NPH_TRY(nph_pair_read(context, a, b, &pair));
    made.lent = !pair.has_variance || pair.unusable >= 0;
    if (made.lent) NPH_TRY(nph_lend_noise(context, a, b, options->a_samples, &lent));
    NphStatus status = fit_noisy(context, made.lent ? &lent : a, b, options, &made);
    nph_image_free(context, &lent);
    if (status == NPH_OK) *fit = made;
    return status;
}
