/* SPDX-License-Identifier: Apache-2.0
 *
 * Pictures with known truth, and the comparator called on them: what the comparator's tests share. */
#ifndef NPH_TESTS_PICTURES_H
#define NPH_TESTS_PICTURES_H

#include <stdio.h>
#include <string.h>

#include "nephos/compare.h"
#include "synthetic.h"

enum { WIDTH = 104, HEIGHT = 24, PIXELS = WIDTH * HEIGHT };

static Distribution gaussian;
static NphContext *context;
static NphComparison result;

/* A picture of the scene with `samples` Gaussian samples a pixel, noise scaled so. */
static inline NphImage noisy(uint32_t seed, int samples, double noise) {
    static Moments moments[PIXELS];
    static double scene[PIXELS];
    NphImage image = synthetic_image(context, WIDTH, HEIGHT, samples);
    for (int c = 0; c < 3; c++) {
        synthetic_scene(WIDTH, HEIGHT, c, scene);
        draw_pixels(&gaussian, seed * 4 + (uint32_t)c, PIXELS, samples, moments);
        synthetic_fill(&image, c, scene, moments, noise, 1.0);
    }
    return image;
}

/* A picture of one value and one variance in every channel; without N and Vov: z is normal. */
static inline NphImage flat(int width, int height, double value, double variance) {
    NphImage image;
    float *plane;
    ck_assert_int_eq(nph_image_new(context, width, height, &image), NPH_OK);
    for (int c = 0; c < 3; c++) {
        for (int k = 0; k < 2; k++) {
            ck_assert_int_eq(nph_image_add_channel(context, &image, synthetic_names[c][k], &plane), NPH_OK);
            for (int i = 0; i < width * height; i++) plane[i] = (float)(k == 0 ? value : variance);
        }
    }
    return image;
}

/* Same scene and seed. */
static inline void mark_paired(NphImage *a, NphImage *b) {
    NphImage *images[2] = {a, b};
    for (int k = 0; k < 2; k++) {
        ck_assert_int_eq(nph_image_set_text(context, images[k], "scene", "0123abcd"), NPH_OK);
        ck_assert_int_eq(nph_image_set_text(context, images[k], "seed", "7"), NPH_OK);
    }
}

static inline NphVerdict judge_with(const NphImage *a, const NphImage *b, const NphCompareOptions *options) {
    memset(&result, 0, sizeof result);
    ck_assert_int_eq(nph_compare(context, a, b, options, &result, NULL), NPH_OK);
    return result.verdict;
}

static inline NphVerdict judge(const NphImage *a, const NphImage *b) {
    NphCompareOptions options;
    nph_compare_options_default(&options);
    return judge_with(a, b, &options);
}

/* Judges and frees. */
static inline NphVerdict judge_once(NphImage a, NphImage b) {
    NphVerdict verdict = judge(&a, &b);
    nph_image_free(context, &a);
    nph_image_free(context, &b);
    return verdict;
}

static inline void check_reason(const char *words) {
    ck_assert_msg(strstr(result.reason, words) != NULL, "\"%s\" is not in: %s", words, result.reason);
}

static inline void brighten(NphImage *image, double factor) {
    for (int c = 0; c < 3; c++) {
        float *plane = synthetic_plane(image, synthetic_names[c][0]);
        for (int i = 0; i < image->width * image->height; i++) plane[i] = (float)(plane[i] * factor);
    }
}

static inline void open_context(void) { context = nph_test_context(1); }
static inline void close_context(void) { nph_test_context_close(context); }

#endif
