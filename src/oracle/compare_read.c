/* SPDX-License-Identifier: Apache-2.0
 *
 * Reading two pictures for a comparison: finds their planes, refuses what cannot be compared, and settles what kind of
 * comparison it is: with or without variance, grey or coloured, independent or with the same random numbers. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "core/message.h"
#include "oracle/compare_parts.h"

static const char *const colours[3] = {"R", "G", "B"};
static const char *const variances[3] = {"Variance.R", "Variance.G", "Variance.B"};
static const char *const vovs[3] = {"Vov.R", "Vov.G", "Vov.B"};

typedef struct Source {
    const NphImage *image;
    const char *letter;
} Source;

static const float *plane(const NphImage *image, const char *name) {
    const NphChannel *channel = nph_image_channel(image, name);
    return channel ? channel->pixels : NULL;
}

/* Every value finite, and not below least. */
static NphStatus check_plane(NphContext *context, Source source, const char *name, double least) {
    const NphImage *image = source.image;
    const float *values = plane(image, name);
    if (!values) return NPH_OK;
    int64_t count = (int64_t)image->width * image->height;
    for (int64_t i = 0; i < count; i++) {
        if (isfinite(values[i]) && values[i] >= least) continue;
        const char *what = isnan(values[i]) ? "NaN" : isinf(values[i]) ? "infinite" : "negative";
        return nph_error(context, NPH_BAD_INPUT, "picture %s: channel %s is %s at pixel (%d, %d)", source.letter, name,
                         what, image->x0 + (int)(i % image->width), image->y0 + (int)(i / image->width));
    }
    return NPH_OK;
}

/* The layers of regions' means: all of their variances or none. */
static NphStatus read_regions(NphContext *context, Source source, NphPicture *picture) {
    const char *present = NULL, *missing = NULL;
    for (int level = 0; level < NPH_REGION_LEVELS; level++)
        for (int c = 0; c < 3; c++) {
            const char *variance = nph_region_variance[level][c], *vov = nph_region_vov[level][c];
            NPH_TRY(check_plane(context, source, variance, 0.0));
            NPH_TRY(check_plane(context, source, vov, 0.0));
            picture->region_variance[level][c] = plane(source.image, variance);
            picture->region_vov[level][c] = plane(source.image, vov);
            if (picture->region_variance[level][c]) present = variance;
            else missing = variance;
        }
    if (present && missing)
        return nph_error(context, NPH_BAD_INPUT, "picture %s has channel %s but not %s: they go together", source.letter,
                         present, missing);
    picture->shared = present != NULL;
    return NPH_OK;
}

static NphStatus read_picture(NphContext *context, Source source, NphPicture *picture) {
    const NphImage *image = source.image;
    memset(picture, 0, sizeof *picture);
    for (int c = 0; c < 3; c++) {
        picture->value[c] = plane(image, colours[c]);
        if (!picture->value[c]) {
            return nph_error(context, NPH_BAD_INPUT, "picture %s has no channel %s; R, G and B are compared",
                             source.letter, colours[c]);
        }
        NPH_TRY(check_plane(context, source, colours[c], -HUGE_VAL));
        NPH_TRY(check_plane(context, source, variances[c], 0.0));
        NPH_TRY(check_plane(context, source, vovs[c], 0.0));
        picture->variance[c] = plane(image, variances[c]);
        picture->vov[c] = plane(image, vovs[c]);
    }
    NPH_TRY(read_regions(context, source, picture));
    NPH_TRY(check_plane(context, source, "N", 0.0));
    picture->samples = plane(image, "N");
    const NphAttribute *samples = nph_image_attribute(image, "samples");
    if (samples && samples->type != NPH_ATTRIBUTE_STRING && samples->number > 0.0) {
        picture->samples_everywhere = samples->number;
    }
    return NPH_OK;
}

static int has_variance(const NphPicture *picture) {
    return picture->variance[0] && picture->variance[1] && picture->variance[2];
}

/* Equal and present in both. */
static int same_attribute(const NphImage *a, const NphImage *b, const char *name) {
    const NphAttribute *left = nph_image_attribute(a, name), *right = nph_image_attribute(b, name);
    if (!left || !right || (left->type == NPH_ATTRIBUTE_STRING) != (right->type == NPH_ATTRIBUTE_STRING)) return 0;
    return left->type == NPH_ATTRIBUTE_STRING ? strcmp(left->text, right->text) == 0 : left->number == right->number;
}

/* Both planes may be missing. */
static int same_plane(const float *a, const float *b, int64_t count) {
    return a == b || (a && b && memcmp(a, b, (size_t)count * sizeof *a) == 0);
}

static int is_grey(const NphPicture *picture, int64_t count) {
    for (int c = 1; c < 3; c++) {
        if (!same_plane(picture->value[0], picture->value[c], count)) return 0;
        if (!same_plane(picture->variance[0], picture->variance[c], count)) return 0;
        if (!same_plane(picture->vov[0], picture->vov[c], count)) return 0;
    }
    return 1;
}

/* A variance that says nothing: of a single sample, or outside the range of float. One too small for it is 0 with a
 * relative spread that is not. */
static int is_unusable(const NphPicture *picture, int64_t i) {
    double samples = nph_pixel_samples(picture, i);
    for (int c = 0; c < 3; c++) {
        if (picture->variance[c][i] >= FLT_MAX) return 1;
        for (int level = 0; level < NPH_REGION_LEVELS && picture->shared; level++)
            if (picture->region_variance[level][c][i] >= FLT_MAX) return 1;
        if (picture->variance[c][i] > 0.0f) continue;
        if ((samples > 0.0 || picture->samples) && samples < 2.0) return 1;
        if (picture->vov[c] && picture->vov[c][i] > 0.0f) return 1;
    }
    return 0;
}

static int is_few_images(const NphPicture *picture, int64_t i) {
    return picture->shared && nph_pixel_samples(picture, i) < NPH_IMAGES_LEAST;
}

static void scan_pixels(NphPicturePair *pair) {
    double sum_a = 0.0, sum_b = 0.0;
    pair->unusable = -1;
    for (int64_t i = 0; i < pair->pixels; i++) {
        int equal = 1;
        for (int c = 0; c < 3; c++) equal &= pair->a.value[c][i] == pair->b.value[c][i];
        pair->identical += equal;
        pair->few_images |= is_few_images(&pair->a, i) || is_few_images(&pair->b, i);
        sum_a += nph_pixel_luminance(&pair->a, i);
        sum_b += nph_pixel_luminance(&pair->b, i);
        if (pair->has_variance && pair->unusable < 0 && (is_unusable(&pair->a, i) || is_unusable(&pair->b, i))) {
            pair->unusable = i;
        }
    }
    pair->luminance_a = sum_a / (double)pair->pixels;
    pair->luminance_b = sum_b / (double)pair->pixels;
}

double nph_pair_scale(const NphPicturePair *pair) {
    if (pair->luminance_b != 0.0) return fabs(pair->luminance_b);
    return pair->luminance_a != 0.0 ? fabs(pair->luminance_a) : 1.0;
}

NphStatus nph_pair_read(NphContext *context, const NphImage *a, const NphImage *b, NphPicturePair *pair) {
    NphPicturePair made = {.x0 = a->x0, .y0 = a->y0, .width = a->width, .height = a->height};
    if (a->width != b->width || a->height != b->height) {
        return nph_error(context, NPH_BAD_INPUT, "picture A has %d x %d pixels, B %d x %d; only equal sizes compare",
                         a->width, a->height, b->width, b->height);
    }
    if (a->x0 != b->x0 || a->y0 != b->y0) {
        return nph_error(context, NPH_BAD_INPUT,
                         "picture A begins at pixel (%d, %d), B at (%d, %d); only the same window compares", a->x0,
                         a->y0, b->x0, b->y0);
    }
    made.pixels = (int64_t)a->width * a->height;
    if (a->width < 1 || a->height < 1) return nph_error(context, NPH_BAD_INPUT, "both pictures are empty");
    NPH_TRY(read_picture(context, (Source){a, "A"}, &made.a));
    NPH_TRY(read_picture(context, (Source){b, "B"}, &made.b));
    made.has_variance = has_variance(&made.a) && has_variance(&made.b);
    made.channels = is_grey(&made.a, made.pixels) && is_grey(&made.b, made.pixels) ? 1 : 3;
    scan_pixels(&made);
    int same_scene = same_attribute(a, b, "scene") || same_attribute(a, b, "digest");
    int both_say = nph_image_attribute(a, "method") && nph_image_attribute(b, "method");
    made.one_law = !both_say || same_attribute(a, b, "method");
    int same_words = same_scene && made.one_law && same_attribute(a, b, "seed") && !made.a.shared && !made.b.shared;
    made.paired = same_words || made.identical == made.pixels;
    *pair = made;
    return NPH_OK;
}
