/* SPDX-License-Identifier: Apache-2.0
 *
 * FLIP of two pictures: the exposures, the mean, and the mean that noise alone would give. flip_band.c does the work. */
#include "nephos/flip.h"

#include "core/fmath.h"
#include "core/memory.h"
#include "core/message.h"
#include "core/reduce.h"
#include "core/text.h"
#include "oracle/flip_parts.h"

static const double shown_at_most = 0.85, most_stops = 100.0;

void nph_flip_options_default(NphFlipOptions *options) {
    *options = (NphFlipOptions){.kind = NPH_FLIP_HDR, .pixels_per_degree = 67.02};
}

static int is_within(double value, double least, double most) { return value >= least && value <= most; }

static NphStatus check_options(NphContext *context, const NphFlipOptions *options) {
    char text[2][NPH_DOUBLE_TEXT];
    if (!is_within(options->pixels_per_degree, 1.0, 1000.0))
        return nph_error(context, NPH_BAD_USAGE, "FLIP with %s pixels per degree; from 1 to 1000 are possible",
                         nph_format_double(options->pixels_per_degree, text[0]));
    int most = options->kind == NPH_FLIP_LDR ? 1 : NPH_FLIP_EXPOSURES;
    if (options->exposures < 0 || options->exposures > most)
        return nph_error(context, NPH_BAD_USAGE, "%s-FLIP with %d exposures; at most %d are possible",
                         options->kind == NPH_FLIP_LDR ? "LDR" : "HDR", options->exposures, most);
    if (options->exposures == 0) return NPH_OK;
    double start = options->start_stops, stop = options->stop_stops;
    if (is_within(start, -most_stops, most_stops) && is_within(stop, start, most_stops) &&
        (options->exposures > 1 || start == stop))
        return NPH_OK;
    return nph_error(context, NPH_BAD_USAGE,
                     "FLIP with %d exposures from %s to %s stops; they rise within -100 to 100, a single one is both",
                     options->exposures, nph_format_double(start, text[0]), nph_format_double(stop, text[1]));
}

static NphStatus check_shown(NphContext *context, const NphPicturePair *pair) {
    static const char *const names[3] = {"R", "G", "B"};
    for (int k = 0; k < 2; k++)
        for (int c = 0; c < 3; c++)
            for (int64_t i = 0; i < pair->pixels; i++) {
                char text[NPH_DOUBLE_TEXT];
                float value = (k == 0 ? &pair->a : &pair->b)->value[c][i];
                if (value >= 0.0f && value <= 1.0f) continue;
                return nph_error(context, NPH_BAD_INPUT,
                                 "picture %s: channel %s is %s at pixel (%d, %d); LDR-FLIP without an exposure takes 0 to 1",
                                 k == 0 ? "A" : "B", names[c], nph_format_rounded((double)value, 6, text),
                                 pair->x0 + (int)(i % pair->width), pair->y0 + (int)(i / pair->width));
            }
    return NPH_OK;
}

/* Lit pixels' luminances of a picture, their number. */
static int64_t collect_lit(const NphPicture *picture, int64_t pixels, double *lit) {
    int64_t count = 0;
    for (int64_t i = 0; i < pixels; i++) {
        double luminance = nph_pixel_luminance(picture, i);
        if (luminance > 0.0) lit[count++] = luminance;
    }
    return count;
}

static double log2_of(double x) {
    NphPair logarithm = nph_log2_pair(x);
    return logarithm.high + logarithm.low;
}

/* exposure x luminance = the light shown as 0.85, of the brightest pixel first, of the median pixel last; about a stop
 * apart. The count from the luminances alone: their ratio is often a power of two. */
static void plan_exposures(double *lit, int64_t count, NphFlipTask *task) {
    double shown = log2_of(nph_flip_aces_inverse(shown_at_most)), most = lit[0];
    for (int64_t i = 1; i < count; i++) most = lit[i] > most ? lit[i] : most;
    nph_select_rank(lit, count, count / 2);
    double median = lit[count / 2];
    if (count % 2 == 0) {
        nph_select_rank(lit, count, count / 2 - 1);
        median = 0.5 * (median + lit[count / 2 - 1]);
    }
    double brightest = log2_of(most), middle = log2_of(median), stops = -nph_floor(middle - brightest);
    task->start_stops = shown - brightest;
    task->stop_stops = shown - middle;
    task->exposures = stops > 2.0 ? (int)stops : 2;
}

NphStatus nph_flip_exposures(NphContext *context, const NphPicturePair *pair, NphFlipTask *task) {
    double *lit = NULL;
    NPH_TRY(NPH_NEW(context, pair->pixels, "luminances of FLIP", &lit));
    int64_t count = collect_lit(&pair->b, pair->pixels, lit);
    if (count == 0) count = collect_lit(&pair->a, pair->pixels, lit);
    task->exposures = 0;
    if (count > 0) plan_exposures(lit, count, task);
    nph_free(context, lit);
    return NPH_OK;
}

static NphFlipPicture planes_of(const NphPicture *picture) {
    return (NphFlipPicture){{picture->value[0], picture->value[1], picture->value[2]}};
}

static NphStatus plan(NphContext *context, const NphPicturePair *pair, const NphFlipOptions *options, NphFlipTask *task) {
    *task = (NphFlipTask){.width = pair->width, .height = pair->height,
                          .tone_mapped = options->kind == NPH_FLIP_HDR, .exposures = options->exposures,
                          .pixels_per_degree = options->pixels_per_degree, .start_stops = options->start_stops,
                          .stop_stops = options->stop_stops};
    task->picture[0] = planes_of(&pair->b);
    task->picture[1] = planes_of(&pair->a);
    if (options->exposures > 0) return NPH_OK;
    if (options->kind == NPH_FLIP_HDR) return nph_flip_exposures(context, pair, task);
    task->start_stops = task->stop_stops = 0.0;
    return check_shown(context, pair);
}

/* Fills task->map and returns its mean; dark pictures have no exposures and are equal. */
static NphStatus run(NphContext *context, const NphFlipTask *task, double *mean) {
    int64_t pixels = (int64_t)task->width * task->height;
    if (task->exposures > 0) NPH_TRY(nph_flip_run(context, task));
    *mean = nph_tree_sum(task->map, pixels, 1) / (double)pixels;
    return NPH_OK;
}

static NphStatus run_noise(NphContext *context, const NphPicturePair *pair, NphFlipTask task, double *mean) {
    float *noise = NULL, *value[6];
    NPH_TRY(NPH_NEW(context, 6 * pair->pixels, "noise of FLIP", &noise));
    for (int i = 0; i < 6; i++) {
        value[i] = noise + i * pair->pixels;
        task.picture[i / 3].value[i % 3] = value[i];
    }
    nph_flip_noise(pair, value);
    NphStatus status = run(context, &task, mean);
    nph_free(context, noise);
    return status;
}

static void find_largest(const NphPicturePair *pair, const double *map, NphFlip *flip) {
    int64_t at = 0;
    for (int64_t i = 1; i < pair->pixels; i++)
        if (map[i] > map[at]) at = i;
    flip->largest = map[at];
    flip->largest_x = pair->x0 + (int)(at % pair->width);
    flip->largest_y = pair->y0 + (int)(at / pair->width);
}

static NphStatus fill_image(NphContext *context, const NphImage *a, const double *map, NphImage *image) {
    NphImage made;
    float *plane;
    NPH_TRY(nph_image_new(context, a->width, a->height, &made));
    NphStatus status = nph_image_add_channel(context, &made, "FLIP", &plane);
    if (status != NPH_OK) {
        nph_image_free(context, &made);
        return status;
    }
    for (int64_t i = 0; i < (int64_t)a->width * a->height; i++) plane[i] = (float)map[i];
    made.x0 = a->x0;
    made.y0 = a->y0;
    made.full_width = a->full_width;
    made.full_height = a->full_height;
    *image = made;
    return NPH_OK;
}

/* The noise first: its map is overwritten by the pictures'. */
static NphStatus evaluate(NphContext *context, const NphPicturePair *pair, NphFlipTask *task, NphFlip *flip) {
    flip->pixels_per_degree = task->pixels_per_degree;
    flip->start_stops = task->start_stops;
    flip->stop_stops = task->stop_stops;
    flip->exposures = task->exposures;
    if (flip->kind == NPH_FLIP_LDR) task->exposures = 1;
    flip->noise_unknown = nph_flip_noise_unknown(pair);
    if (!flip->noise_unknown) NPH_TRY(run_noise(context, pair, *task, &flip->noise_mean));
    NPH_TRY(run(context, task, &flip->mean));
    find_largest(pair, task->map, flip);
    return NPH_OK;
}

NphStatus nph_flip(NphContext *context, const NphImage *a, const NphImage *b, const NphFlipOptions *options,
                   NphFlip *flip, NphImage *map) {
    NphPicturePair pair;
    NphFlipTask task;
    NphFlip made = {.kind = options->kind};
    NPH_TRY(check_options(context, options));
    NPH_TRY(nph_pair_read(context, a, b, &pair));
    NPH_TRY(plan(context, &pair, options, &task));
    NPH_TRY(NPH_NEW(context, pair.pixels, "map of FLIP", &task.map));
    NphStatus status = evaluate(context, &pair, &task, &made);
    if (status == NPH_OK && map) status = fill_image(context, a, task.map, map);
    nph_free(context, task.map);
    if (status == NPH_OK) *flip = made;
    return status;
}
