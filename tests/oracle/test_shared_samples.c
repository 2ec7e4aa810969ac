/* SPDX-License-Identifier: Apache-2.0
 *
 * The comparator on pictures whose pixels share samples: what it says of correlated pixels with the variances of the
 * regions' means, how wrong it would be without them, and what it asks of such pictures. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "film/regions.h"
#include "nephos/compare.h"
#include "synthetic.h"

enum { WIDTH = 104, HEIGHT = 24, PIXELS = WIDTH * HEIGHT, SAMPLES = 64, PAIRS = 500, BLOB = 12 };
enum { BLOBS_X = WIDTH / BLOB + 1, BLOBS_Y = HEIGHT / BLOB };

static Distribution distributions[3];
static double scene[PIXELS];
static NphContext *context;

/* One sample of all pixels: a factor of the whole image, one of blobs that lie across the tiles, and each pixel's own. */
static void draw_image(const Distribution *distribution, uint32_t seed, int sample, float out[PIXELS]) {
    float blobs[BLOBS_X * BLOBS_Y];
    NphWords words = nph_philox(seed, 1, (uint32_t)sample, 0, 0, 0);
    float whole = distribution_draw(distribution, words.w0);
    for (int b = 0; b < BLOBS_X * BLOBS_Y; b++)
        blobs[b] = distribution_draw(distribution, nph_philox(seed, 2, (uint32_t)sample, (uint32_t)b, 0, 0).w0);
    for (int p = 0; p < PIXELS; p += 4) {
        words = nph_philox(seed, 3, (uint32_t)sample, (uint32_t)p, 0, 0);
        uint32_t own[4] = {words.w0, words.w1, words.w2, words.w3};
        for (int k = 0; k < 4; k++) {
            int x = (p + k) % WIDTH, y = (p + k) / WIDTH, blob = (y / BLOB) * BLOBS_X + x / BLOB;
            float noise = 0.1f * whole + 0.3f * blobs[blob] + 0.6f * distribution_draw(distribution, own[k]);
            out[p + k] = (float)(scene[p + k] * (double)noise / distribution->mean);
        }
    }
}

static float images[SAMPLES][PIXELS];

static void put_moments(NphImage *picture, const char *variance, const char *vov, const int rect[4], int samples) {
    float means[SAMPLES];
    float *v = nph_image_channel(picture, variance)->pixels, *o = nph_image_channel(picture, vov)->pixels;
    for (int s = 0; s < samples; s++) {
        double sum = 0.0;
        for (int y = rect[1]; y < rect[3]; y++)
            for (int x = rect[0]; x < rect[2]; x++) sum += (double)images[s][y * WIDTH + x];
        means[s] = (float)(sum / ((double)(rect[2] - rect[0]) * (double)(rect[3] - rect[1])));
    }
    Moments moments = moments_of(means, samples, 1.0);
    for (int y = rect[1]; y < rect[3]; y++)
        for (int x = rect[0]; x < rect[2]; x++) {
            v[y * WIDTH + x] = (float)moments.variance_of_mean;
            o[y * WIDTH + x] = (float)moments.vov;
        }
}

static void put_level(NphImage *picture, int level, int samples) {
    float *unused;
    int size = nph_region_sizes[level], across = nph_regions_along(WIDTH, size), down = nph_regions_along(HEIGHT, size);
    ck_assert_int_eq(nph_image_add_channel(context, picture, nph_region_variance[level][0], &unused), NPH_OK);
    ck_assert_int_eq(nph_image_add_channel(context, picture, nph_region_vov[level][0], &unused), NPH_OK);
    for (int i = 0; i < across * down; i++) {
        int rect[4];
        nph_region_span(i % across, across, size, WIDTH, &rect[0], &rect[2]);
        nph_region_span(i / across, down, size, HEIGHT, &rect[1], &rect[3]);
        put_moments(picture, nph_region_variance[level][0], nph_region_vov[level][0], rect, samples);
    }
}

/* R = G = B, planes of one for all. */
static void copy_channels(NphImage *picture, int stated) {
    for (int c = 1; c < 3; c++) {
        for (int k = 0; k < 3; k++)
            memcpy(synthetic_plane(picture, synthetic_names[c][k]), synthetic_plane(picture, synthetic_names[0][k]),
                   PIXELS * sizeof(float));
        for (int level = 0; level < NPH_REGION_LEVELS && stated; level++)
            for (int k = 0; k < 2; k++) {
                const char *const(*names)[3] = k ? nph_region_vov : nph_region_variance;
                float *plane;
                ck_assert_int_eq(nph_image_add_channel(context, picture, names[level][c], &plane), NPH_OK);
                memcpy(plane, nph_image_channel(picture, names[level][0])->pixels, PIXELS * sizeof(float));
            }
    }
}

/* A picture of so many images; stated: with the variances of the regions' means. */
static NphImage picture_of(const Distribution *distribution, uint32_t seed, int samples, int stated, double brightness) {
    NphImage picture = synthetic_image(context, WIDTH, HEIGHT, samples);
    float *value = synthetic_plane(&picture, "R"), *variance = synthetic_plane(&picture, "Variance.R");
    float *vov = synthetic_plane(&picture, "Vov.R");
    for (int s = 0; s < samples; s++) draw_image(distribution, seed, s, images[s]);
    for (int p = 0; p < PIXELS; p++) {
        float own[SAMPLES];
        for (int s = 0; s < samples; s++) own[s] = images[s][p];
        Moments moments = moments_of(own, samples, 1.0);
        value[p] = (float)(moments.mean * brightness);
        variance[p] = (float)moments.variance_of_mean;
        vov[p] = (float)moments.vov;
    }
    for (int level = 0; level < NPH_REGION_LEVELS && stated; level++) put_level(&picture, level, samples);
    copy_channels(&picture, stated);
    return picture;
}

static NphComparison result;

static NphVerdict judge(const NphImage *a, const NphImage *b) {
    NphCompareOptions options;
    nph_compare_options_default(&options);
    memset(&result, 0, sizeof result);
    ck_assert_msg(nph_compare(context, a, b, &options, &result, NULL) == NPH_OK, "%s", nph_test_messages());
    return result.verdict;
}

static NphVerdict judge_once(NphImage a, NphImage b) {
    NphVerdict verdict = judge(&a, &b);
    nph_image_free(context, &a);
    nph_image_free(context, &b);
    return verdict;
}

/* Pairs of equal expectation, samples of B as given; how many are called different. */
static int alarms(const Distribution *distribution, int samples_b, int stated, int pairs) {
    int different = 0;
    for (int pair = 0; pair < pairs; pair++) {
        NphImage a = picture_of(distribution, (uint32_t)(2 * pair), SAMPLES, stated, 1.0);
        NphImage b = picture_of(distribution, (uint32_t)(2 * pair + 1), samples_b, stated, 1.0);
        different += judge_once(a, b) == NPH_NOT_SAME;
    }
    printf("%s, %d images against %d, variances of regions %s: different %d of %d\n", distribution->name, SAMPLES,
           samples_b, stated ? "stated" : "left out", different, pairs);
    fflush(stdout);
    return different;
}

START_TEST(correlated_pixels_raise_at_most_one_percent_false_alarms_and_most_without_the_regions) {
    if (!nph_test_statistics("comparator, shared samples")) return;
    context = nph_test_context(1);
    for (int d = 0; d < 3; d++) {
        ck_assert_int_le(alarms(&distributions[d], SAMPLES, 1, d == 0 ? PAIRS : PAIRS / 5), d == 0 ? PAIRS / 100 : 1);
        ck_assert_int_le(alarms(&distributions[d], SAMPLES / 2, 1, PAIRS / 5), 1);
    }
    ck_assert_int_ge(alarms(&distributions[0], SAMPLES, 0, PAIRS / 5), PAIRS / 10);
    nph_test_context_close(context);
}
END_TEST

/* An unshared picture of the same expectation: independent pixels. */
static NphImage independent(uint32_t seed, double noise, double brightness) {
    static Moments moments[PIXELS];
    NphImage image = synthetic_image(context, WIDTH, HEIGHT, SAMPLES);
    draw_pixels(&distributions[0], seed, PIXELS, SAMPLES, moments);
    for (int c = 0; c < 3; c++) synthetic_fill(&image, c, scene, moments, noise, brightness);
    return image;
}

START_TEST(against_independent_pixels_equal_pictures_raise_no_alarm_and_brighter_ones_do) {
    if (!nph_test_statistics("comparator, shared samples against independent")) return;
    context = nph_test_context(1);
    int equal = 0, brighter = 0, pairs = PAIRS / 5;
    for (int pair = 0; pair < pairs; pair++) {
        uint32_t seed = (uint32_t)(2 * pair);
        NphImage shared = picture_of(&distributions[0], seed, SAMPLES, 1, 1.0);
        equal += judge_once(independent(seed + 1, 0.5, 1.0), shared) == NPH_NOT_SAME;
        /* the image's standard error is 1%: 6% is a sure difference */
        brighter += judge_once(independent(seed + 1, 0.5, 1.06), picture_of(&distributions[0], seed, SAMPLES, 1, 1.0)) ==
                    NPH_NOT_SAME;
    }
    printf("independent against shared: equal %d different, brighter %d different of %d\n", equal, brighter, pairs);
    ck_assert_int_le(equal, 1);
    ck_assert_int_ge(brighter, 99 * pairs / 100);
    nph_test_context_close(context);
}
END_TEST

START_TEST(fewer_than_32_images_decide_nothing_but_equality) {
    context = nph_test_context(1);
    NphImage few = picture_of(&distributions[0], 1, 16, 1, 1.0), other = picture_of(&distributions[0], 2, 64, 1, 2.0);
    ck_assert_int_eq(judge(&few, &other), NPH_INCONCLUSIVE);
    ck_assert_ptr_nonnull(strstr(result.reason, "at least 32 samples"));
    ck_assert_int_eq(judge(&other, &few), NPH_INCONCLUSIVE);
    ck_assert_int_eq(judge(&few, &few), NPH_SAME);
    nph_image_free(context, &few);
    nph_image_free(context, &other);
    nph_test_context_close(context);
}
END_TEST

START_TEST(equal_seeds_are_no_pairs_of_pixels_where_samples_are_shared) {
    context = nph_test_context(1);
    NphImage a = picture_of(&distributions[0], 1, 64, 1, 1.0), b = picture_of(&distributions[0], 2, 64, 1, 1.0);
    NphImage *both[2] = {&a, &b};
    for (int k = 0; k < 2; k++) {
        ck_assert_int_eq(nph_image_set_text(context, both[k], "digest", "0123"), NPH_OK);
        ck_assert_int_eq(nph_image_set_text(context, both[k], "seed", "7"), NPH_OK);
    }
    judge(&a, &b);
    ck_assert_int_eq(result.paired, 0);
    ck_assert_str_eq(result.pixel_histogram_not_tested, "pixels share samples");
    nph_image_free(context, &a);
    nph_image_free(context, &b);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_picture_that_states_some_levels_only_is_refused) {
    context = nph_test_context(1);
    NphImage a = picture_of(&distributions[0], 1, 64, 0, 1.0);
    float *plane;
    NphComparison comparison;
    NphCompareOptions options;
    nph_compare_options_default(&options);
    ck_assert_int_eq(nph_image_add_channel(context, &a, "Variance64.G", &plane), NPH_OK);
    ck_assert_int_eq(nph_compare(context, &a, &a, &options, &comparison, NULL), NPH_BAD_INPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "Variance64.G but not VarianceImage.B"));
    nph_image_free(context, &a);
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    synthetic_scene(WIDTH, HEIGHT, 0, scene);
    distribution_make(&distributions[0], "gaussian", gaussian_quantile);
    distribution_make(&distributions[1], "exponential", exponential_quantile);
    distribution_make(&distributions[2], "lognormal", lognormal_quantile);
    tcase_add_test(cases, correlated_pixels_raise_at_most_one_percent_false_alarms_and_most_without_the_regions);
    tcase_add_test(cases, against_independent_pixels_equal_pictures_raise_no_alarm_and_brighter_ones_do);
    tcase_add_test(cases, fewer_than_32_images_decide_nothing_but_equality);
    tcase_add_test(cases, equal_seeds_are_no_pairs_of_pixels_where_samples_are_shared);
    tcase_add_test(cases, a_picture_that_states_some_levels_only_is_refused);
}

int main(void) { return nph_test_main("shared_samples", fill); }
