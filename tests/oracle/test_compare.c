/* SPDX-License-Identifier: Apache-2.0
 *
 * The comparator's verdicts on pictures whose truth is known. */
#include <float.h>

#include "pictures.h"

START_TEST(equal_pixels_are_the_same_with_and_without_variance) {
    NphImage a = noisy(1, 64, 1.0), b = noisy(1, 64, 1.0);
    ck_assert_int_eq(judge(&a, &b), NPH_SAME);
    check_reason("every pixel is equal");
    ck_assert_int_eq(result.identical_pixels, PIXELS);
    ck_assert_double_eq(result.relative_rmse, 0.0);
    for (int c = 0; c < a.channel_count; c++) {
        if (a.channels[c].name[0] == 'V') strcpy(a.channels[c].name, "x");
    }
    ck_assert_int_eq(judge(&a, &b), NPH_SAME);
    synthetic_plane(&a, "G")[77] *= 1.0000002f;
    ck_assert_int_eq(judge(&a, &b), NPH_NOT_SAME);
    check_reason("without Variance.R, .G and .B in A only equal pixels are the same; 1 of 2496 differ");
    ck_assert_int_eq(result.level_count, 0);
    nph_image_free(context, &a);
    nph_image_free(context, &b);
}
END_TEST

START_TEST(a_picture_shifted_by_one_pixel_is_different) {
    for (int paired = 0; paired < 2; paired++) {
        for (int down = 0; down < 2; down++) {
            NphImage a = noisy(1, 64, 1.0), b = noisy(paired ? 1 : 2, 64, 1.0);
            int step = down ? WIDTH : 1;
            for (int c = 0; c < a.channel_count; c++) {
                memmove(a.channels[c].pixels + step, a.channels[c].pixels, (size_t)(PIXELS - step) * sizeof(float));
            }
            if (paired) mark_paired(&a, &b);
            ck_assert_int_eq(judge_once(a, b), NPH_NOT_SAME);
            ck_assert_int_eq(result.paired, paired);
        }
    }
}
END_TEST

START_TEST(swapped_channels_are_different) {
    NphImage a = noisy(1, 64, 1.0), b = noisy(2, 64, 1.0);
    for (int c = 0; c < a.channel_count; c++) {
        char *last = a.channels[c].name + strlen(a.channels[c].name) - 1;
        if (*last == 'R') *last = 'B';
        else if (*last == 'B') *last = 'R';
    }
    ck_assert_int_eq(judge_once(a, b), NPH_NOT_SAME);
    ck_assert_int_gt(result.levels[2].different, 10);
}
END_TEST

START_TEST(without_noise_the_margin_decides) {
    ck_assert_int_eq(judge_once(flat(100, 30, 1.002, 0), flat(100, 30, 1.0, 0)), NPH_NOT_SAME);
    check_reason("image, channel R = G = B: A is 0.2% above B, without any noise");
    ck_assert_int_eq(judge_once(flat(100, 30, 0.998, 0), flat(100, 30, 1.0, 0)), NPH_NOT_SAME);
    check_reason("0.2% below B");
    ck_assert_double_eq(result.levels[0].worst_z, 1e30);
    ck_assert_int_eq(judge_once(flat(100, 30, 1.0019, 0), flat(100, 30, 1.0, 0)), NPH_SAME);
    check_reason("significant but within it");
    /* A white furnace in single precision: an ulp per event. */
    ck_assert_int_eq(judge_once(flat(100, 30, 0.9999996, 0), flat(100, 30, 1.0, 0)), NPH_SAME);
}
END_TEST

/* Margin 0.2%, standard error 0.01%: 0.1% is ten standard errors, and as many below the margin. */
START_TEST(a_significant_difference_within_the_margin_is_the_same) {
    double error = 1e-4 * sqrt(100.0 * 30.0 / 2.0);
    ck_assert_int_eq(judge_once(flat(100, 30, 1.001, error * error), flat(100, 30, 1.0, error * error)), NPH_SAME);
    check_reason("significant but within it: image, channel R = G = B: A is 0.1% above B, 10 standard errors");
    ck_assert_int_eq(result.levels[0].same, 1);
    ck_assert_int_eq(result.levels[0].different, 0);
    ck_assert_int_eq(judge_once(flat(100, 30, 1.0019, error * error), flat(100, 30, 1.0, error * error)), NPH_NOT_SAME);
}
END_TEST

START_TEST(a_bright_tile_is_found_and_named) {
    NphImage a = noisy(1, 64, 0.4), b = noisy(2, 64, 0.4);
    for (int y = 8; y < 16; y++) {
        for (int x = 72; x < 80; x++) synthetic_plane(&a, "G")[y * WIDTH + x] *= 1.05f;
    }
    a.x0 = b.x0 = 1000;
    a.y0 = b.y0 = -20;
    ck_assert_int_eq(judge_once(a, b), NPH_NOT_SAME);
    ck_assert_int_eq(result.level_count, 3);
    ck_assert_int_eq(result.levels[0].different, 0);
    ck_assert_int_eq(result.levels[2].different, 1);
    ck_assert_int_eq(result.levels[2].regions, 39);
    ck_assert_int_eq(result.levels[2].worst_x, 1072);
    ck_assert_int_eq(result.levels[2].worst_y, -12);
    ck_assert_int_eq(result.levels[2].worst_size, 8);
    ck_assert_str_eq(result.levels[2].worst_channel, "G");
    check_reason("tile of 8 x 8 pixels at (1072, -12), channel G: A is ");
}
END_TEST

START_TEST(noise_is_inconclusive_and_the_samples_asked_for_decide) {
    double noise = 1.0;
    ck_assert_int_eq(judge_once(noisy(1, 64, noise), noisy(2, 64, noise)), NPH_INCONCLUSIVE);
    check_reason("no difference is shown, but ");
    const char *about = strstr(result.reason, "about ");
    ck_assert_ptr_nonnull(about);
    double times = strtod(about + 6, NULL);
    ck_assert_double_gt(times, 10.0);
    /* The same random numbers with that many times fewer variance: what more samples would give at best. */
    ck_assert_int_eq(judge_once(noisy(1, 64, noise / sqrt(1.02 * times)), noisy(2, 64, noise / sqrt(1.02 * times))),
                     NPH_SAME);
    ck_assert_int_eq(judge_once(noisy(1, 64, noise / sqrt(0.8 * times)), noisy(2, 64, noise / sqrt(0.8 * times))),
                     NPH_INCONCLUSIVE);
}
END_TEST

START_TEST(noisy_tiles_can_be_allowed) {
    NphCompareOptions options;
    nph_compare_options_default(&options);
    options.margin_tile = 0.003;
    NphImage a = noisy(1, 64, 0.1), b = noisy(2, 64, 0.1);
    ck_assert_int_eq(judge_with(&a, &b, &options), NPH_INCONCLUSIVE);
    check_reason("8^2 tiles");
    options.allow_noisy_tiles = 1;
    ck_assert_int_eq(judge_with(&a, &b, &options), NPH_SAME);
    check_reason("tiles are too noisy to be shown, as allowed");
    for (int i = 0; i < PIXELS; i++) synthetic_plane(&a, "R")[i] *= i % WIDTH < 8 ? 1.1f : 1.0f;
    ck_assert_int_eq(judge_with(&a, &b, &options), NPH_NOT_SAME);
    nph_image_free(context, &a);
    nph_image_free(context, &b);
}
END_TEST

/* A dark tile's margin is that of a tenth of the picture's luminance: 1% of 0.1 against 1% of 0.0001. */
START_TEST(dark_tiles_do_not_demand_the_impossible) {
    NphImage a = flat(160, 8, 1.0, 0), b = flat(160, 8, 1.0, 0);
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < 8 * 160; i++) {
            if (i % 160 >= 8) continue;
            synthetic_plane(&a, synthetic_names[c][0])[i] = 0.00015f;
            synthetic_plane(&b, synthetic_names[c][0])[i] = 0.0001f;
        }
    }
    ck_assert_int_eq(judge(&a, &b), NPH_SAME);
    for (int i = 0; i < 8 * 160; i++) synthetic_plane(&a, "R")[i] += i % 160 < 8 ? 0.0011f : 0.0f;
    ck_assert_int_eq(judge(&a, &b), NPH_NOT_SAME);
    nph_image_free(context, &a);
    nph_image_free(context, &b);
}
END_TEST

/* Noise of 1% in the image, shared by both: the difference is found where independent pictures could not show it. */
START_TEST(equal_seeds_are_judged_by_their_pixel_differences) {
    NphImage a = noisy(1, 64, 4.0), b = noisy(1, 64, 4.0);
    brighten(&a, 1.004);
    ck_assert_int_eq(judge(&a, &b), NPH_INCONCLUSIVE);
    double independent = result.standard_error[0];
    mark_paired(&a, &b);
    ck_assert_int_eq(judge(&a, &b), NPH_NOT_SAME);
    ck_assert_int_eq(result.paired, 1);
    ck_assert_double_lt(result.standard_error[0], 0.02 * independent);
    ck_assert_ptr_nonnull(result.pixel_histogram_not_tested);
    nph_image_free(context, &a);
    nph_image_free(context, &b);
    /* Rounding of another build: no bias, tiny scatter: the same, although the noise is large. */
    a = noisy(1, 64, 4.0);
    b = noisy(1, 64, 4.0);
    for (int i = 0; i < PIXELS; i++) {
        if (i % 3 < 2) synthetic_plane(&a, "G")[i] *= i % 3 ? 1.000001f : 0.999999f;
    }
    mark_paired(&a, &b);
    ck_assert_int_eq(judge_once(a, b), NPH_SAME);
}
END_TEST

/* Pairs that share a seed by name only: their differences are all noise, and no alarm may come from it. */
START_TEST(pairs_that_share_nothing_raise_no_alarm) {
    int different = 0;
    for (int i = 0; i < 100; i++) {
        NphImage a = noisy((uint32_t)(2 * i + 10), 16, 1.0), b = noisy((uint32_t)(2 * i + 11), 16, 1.0);
        mark_paired(&a, &b);
        different += judge_once(a, b) == NPH_NOT_SAME;
    }
    ck_assert_int_le(different, 1);
}
END_TEST

START_TEST(variances_that_say_nothing_are_inconclusive) {
    NphImage a = noisy(1, 64, 1.0), b = noisy(2, 64, 1.0);
    synthetic_plane(&a, "N")[WIDTH * 3 + 5] = 1.0f;
    synthetic_plane(&a, "Variance.G")[WIDTH * 3 + 5] = 0.0f;
    ck_assert_int_eq(judge(&a, &b), NPH_INCONCLUSIVE);
    check_reason("the variance of pixel (5, 3) says nothing");
    synthetic_plane(&a, "N")[WIDTH * 3 + 5] = 64.0f; /* now underflown: Vov is not 0 */
    ck_assert_int_eq(judge(&a, &b), NPH_INCONCLUSIVE);
    check_reason("the variance of pixel (5, 3) says nothing");
    synthetic_plane(&a, "Vov.G")[WIDTH * 3 + 5] = 0.0f;
    ck_assert_int_eq(judge(&a, &b), NPH_INCONCLUSIVE);
    check_reason("too noisy");
    synthetic_plane(&a, "Variance.G")[WIDTH * 3 + 5] = FLT_MAX;
    ck_assert_int_eq(judge(&a, &b), NPH_INCONCLUSIVE);
    check_reason("the variance of pixel (5, 3) says nothing");
    nph_image_free(context, &a);
    nph_image_free(context, &b);
}
END_TEST

START_TEST(black_pictures_compare) {
    ck_assert_int_eq(judge_once(flat(20, 20, 0, 0), flat(20, 20, 0, 0)), NPH_SAME);
    ck_assert_int_eq(judge_once(flat(20, 20, 1e-30, 0), flat(20, 20, 0, 0)), NPH_NOT_SAME);
    ck_assert_double_eq(result.relative_bias, 1.0);
    ck_assert_int_eq(judge_once(flat(20, 20, 0, 0), flat(20, 20, 1e30, 0)), NPH_NOT_SAME);
    ck_assert_double_eq(result.relative_bias, -1.0);
    NphImage a = flat(20, 20, 0.01, 1), b = flat(20, 20, 0, 0);
    ck_assert_int_eq(judge_once(a, b), NPH_INCONCLUSIVE);
    check_reason("B is black or the margin 0");
}
END_TEST

static void fill(TCase *cases) {
    distribution_make(&gaussian, "gaussian", gaussian_quantile);
    tcase_add_checked_fixture(cases, open_context, close_context);
    tcase_add_test(cases, equal_pixels_are_the_same_with_and_without_variance);
    tcase_add_test(cases, a_picture_shifted_by_one_pixel_is_different);
    tcase_add_test(cases, swapped_channels_are_different);
    tcase_add_test(cases, without_noise_the_margin_decides);
    tcase_add_test(cases, a_significant_difference_within_the_margin_is_the_same);
    tcase_add_test(cases, a_bright_tile_is_found_and_named);
    tcase_add_test(cases, noise_is_inconclusive_and_the_samples_asked_for_decide);
    tcase_add_test(cases, noisy_tiles_can_be_allowed);
    tcase_add_test(cases, dark_tiles_do_not_demand_the_impossible);
    tcase_add_test(cases, equal_seeds_are_judged_by_their_pixel_differences);
    tcase_add_test(cases, pairs_that_share_nothing_raise_no_alarm);
    tcase_add_test(cases, variances_that_say_nothing_are_inconclusive);
    tcase_add_test(cases, black_pictures_compare);
}

int main(void) { return nph_test_main("compare", fill); }
