/* SPDX-License-Identifier: Apache-2.0
 *
 * The comparator's parts: what it refuses, its evidence against formulas, Holm, levels, metrics, map and histogram. */
#include "oracle/compare_parts.h"
#include "pictures.h"

static Distribution exponential;

/* Seven tiles in a row with z = 4.5, 3.5, 2.9, 2.75, ...: two-sided p 7e-6, 4.7e-4, 3.7e-3, 6e-3. The level has half
 * the budget of 0.04, 0.02: Holm compares with 0.02/7 = 2.9e-3, /6 = 3.3e-3, /5 = 4e-3, /4 = 5e-3 and rejects three
 * where Bonferroni would reject two, and the whole budget four. */
START_TEST(holm_rejects_in_steps) {
    static const double z[7] = {-2.75, 4.5, 0.3, 2.9, 0.0, 3.5, -0.5};
    NphImage a = flat(56, 8, 100.0, 1.0), b = flat(56, 8, 100.0, 0.0);
    NphCompareOptions options = {.margin_image = 0.0, .margin_tile = 0.0, .alpha = 0.04};
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < 8 * 56; i++) {
            synthetic_plane(&a, synthetic_names[c][0])[i] = (float)(100.0 + z[i % 56 / 8] / 8.0);
        }
    }
    ck_assert_int_eq(judge_with(&a, &b, &options), NPH_NOT_SAME);
    ck_assert_int_eq(result.level_count, 2);
    ck_assert_int_eq(result.levels[1].different, 3);
    ck_assert_double_eq_tol(result.levels[1].worst_z, 4.5, 1e-3);
    nph_image_free(context, &a);
    nph_image_free(context, &b);
}
END_TEST

START_TEST(levels_that_repeat_the_image_are_left_out) {
    static const int sizes[][3] = {{1, 1, 1}, {11, 3, 1}, {12, 3, 2}, {95, 8, 2}, {96, 8, 3}, {300, 1, 3}};
    static const int tiles[] = {0, 0, 2, 12, 12, 38};
    for (int i = 0; i < 6; i++) {
        ck_assert_int_eq(judge_once(flat(sizes[i][0], sizes[i][1], 1.0001, 0), flat(sizes[i][0], sizes[i][1], 1, 0)),
                         NPH_SAME);
        ck_assert_int_eq(result.level_count, sizes[i][2]);
        if (tiles[i]) ck_assert_int_eq(result.levels[result.level_count - 1].regions, tiles[i]);
    }
}
END_TEST

/* Changes a picture, sees it refused with these words, and nothing else touched. */
static void check_refused(NphImage a, NphImage b, const char *words) {
    NphCompareOptions options;
    NphComparison comparison;
    NphImage map;
    nph_compare_options_default(&options);
    memset(&comparison, 0x5A, sizeof comparison);
    memset(&map, 0x5A, sizeof map);
    NphComparison before = comparison;
    NphImage map_before = map;
    ck_assert_int_eq(nph_compare(context, &a, &b, &options, &comparison, &map), NPH_BAD_INPUT);
    const char *messages = nph_test_messages();
    ck_assert_msg(strstr(messages, words) != NULL, "\"%s\" is not in: %s", words, messages);
    ck_assert_int_eq(memcmp(&comparison, &before, sizeof before), 0);
    ck_assert_int_eq(memcmp(&map, &map_before, sizeof map), 0);
    nph_image_free(context, &a);
    nph_image_free(context, &b);
}

static NphImage with_value(const char *name, float value) {
    NphImage image = noisy(1, 16, 1.0);
    synthetic_plane(&image, name)[WIDTH * 7 + 3] = value;
    return image;
}

START_TEST(what_cannot_be_compared_is_refused_by_name) {
    check_refused(with_value("G", NAN), noisy(2, 16, 1), "picture A: channel G is NaN at pixel (3, 7)");
    check_refused(noisy(2, 16, 1), with_value("B", -INFINITY), "picture B: channel B is infinite at pixel (3, 7)");
    check_refused(with_value("Variance.R", -1.0f), noisy(2, 16, 1), "picture A: channel Variance.R is negative");
    check_refused(with_value("Variance.R", INFINITY), noisy(2, 16, 1), "picture A: channel Variance.R is infinite");
    check_refused(with_value("Vov.B", NAN), noisy(2, 16, 1), "picture A: channel Vov.B is NaN");
    check_refused(with_value("N", -4.0f), noisy(2, 16, 1), "picture A: channel N is negative");
    check_refused(noisy(1, 16, 1), flat(WIDTH, HEIGHT + 1, 1, 0), "picture A has 104 x 24 pixels, B 104 x 25");
    NphImage image = noisy(1, 16, 1), moved = noisy(1, 16, 1);
    image.channels[0].name[0] = 'Q';
    check_refused(noisy(1, 16, 1), image, "picture B has no channel R");
    moved.x0 = 8;
    check_refused(moved, noisy(1, 16, 1), "picture A begins at pixel (8, 0), B at (0, 0)");
}
END_TEST

START_TEST(options_out_of_range_are_refused) {
    NphImage a = flat(8, 8, 1, 0), b = flat(8, 8, 1, 0);
    static const NphCompareOptions bad[] = {
        {-0.1, 0.01, 0.01, 0}, {NAN, 0.01, 0.01, 0}, {0.002, -1, 0.01, 0},  {0.002, INFINITY, 0.01, 0},
        {0.002, 0.01, 0, 0},   {0.002, 0.01, 1, 0},  {0.002, 0.01, NAN, 0},
    };
    for (int i = 0; i < 7; i++) {
        ck_assert_int_eq(nph_compare(context, &a, &b, &bad[i], &result, NULL), NPH_BAD_USAGE);
        ck_assert_ptr_nonnull(strstr(nph_test_messages(), "; it is a "));
    }
    nph_image_free(context, &a);
    nph_image_free(context, &b);
}
END_TEST

/* Standard error and degrees of freedom of a region of four pixels, by hand:
 * own: sum of variances 2 (0.04 + 0.01) + 2 (0.01 + 0.02) = 0.16; spread of A with Vov 0.5, of B with the floor
 * 2 / (N - 1) = 2 / 7: 2 (0.5 * 0.0016 + 2/7 * 0.0001) + 2 (0.5 * 0.0001 + 2/7 * 0.0004). */
START_TEST(the_evidence_of_a_region_is_the_formula) {
    static const float va[4] = {0.04f, 0.04f, 0.01f, 0.01f}, vb[4] = {0.01f, 0.01f, 0.02f, 0.02f};
    NphImage a = synthetic_image(context, 2, 2, 8), b = synthetic_image(context, 2, 2, 8);
    for (int i = 0; i < 4; i++) {
        for (int c = 0; c < 3; c++) {
            synthetic_plane(&a, synthetic_names[c][0])[i] = 3.0f + (float)i;
            synthetic_plane(&b, synthetic_names[c][0])[i] = 2.5f + (float)i;
            synthetic_plane(&a, synthetic_names[c][1])[i] = va[i];
            synthetic_plane(&b, synthetic_names[c][1])[i] = vb[i];
            synthetic_plane(&a, synthetic_names[c][2])[i] = 0.5f;
        }
    }
    NphPicturePair pair;
    NphEvidence evidence;
    ck_assert_int_eq(nph_pair_read(context, &a, &b, &pair), NPH_OK);
    nph_region_weigh(&pair, (NphRect){0, 0, 2, 2, 0}, 0, 0.1, &evidence);
    double spread = 2.0 * (0.5 * 0.0016 + 2.0 / 7 * 0.0001 + 0.5 * 0.0001 + 2.0 / 7 * 0.0004);
    double dof = 2.0 * 0.16 * 0.16 / spread, error = sqrt(0.16) / 4.0;
    ck_assert_double_eq_tol(evidence.difference, 0.5, 1e-12);
    ck_assert_double_eq_tol(evidence.standard_error, error, 1e-8);
    ck_assert_double_eq_tol(evidence.dof, dof, 1e-5);
    ck_assert_double_eq_tol(evidence.margin, 0.4, 1e-6);
    ck_assert_double_eq_tol(evidence.p_equal, 2.0 * nph_student_lower(-0.5 / error, dof), 1e-7);
    ck_assert_double_eq_tol(evidence.p_beyond, 1.0 - nph_student_lower(-0.1 / error, dof), 1e-5);
    /* 8 against 32 samples: the variance per sample of B, 32 * 0.01, is above that of A, 8 * 0.01, in two pixels. */
    for (int i = 0; i < 4; i++) {
        synthetic_plane(&b, "N")[i] = 32.0f;
        synthetic_plane(&a, "Variance.R")[i] = 0.01f;
        synthetic_plane(&b, "Variance.R")[i] = 0.01f;
    }
    nph_region_weigh(&pair, (NphRect){0, 0, 2, 2, 0}, 0, 0.1, &evidence);
    double per_sample = (7.0 * 0.08 + 31.0 * 0.32) / 38.0, pooled = per_sample * (1.0 / 8 + 1.0 / 32);
    ck_assert_double_eq_tol(evidence.standard_error, sqrt(4.0 * pooled) / 4.0, 1e-8);
    nph_image_free(context, &a);
    nph_image_free(context, &b);
}
END_TEST

/* 8 against 32 samples of equal variance of the mean: pooled, that of A's is larger. */
START_TEST(pictures_of_two_methods_do_not_lend_each_other_their_variance) {
    static const char *const methods[4][2] = {{NULL, NULL}, {"path", "path"}, {"path", NULL}, {"path", "single"}};
    double pooled = (7.0 * 0.08 + 31.0 * 0.32) / 38.0 * (1.0 / 8 + 1.0 / 32);
    for (int m = 0; m < 4; m++) {
        NphImage images[2] = {synthetic_image(context, 2, 2, 8), synthetic_image(context, 2, 2, 32)};
        NphPicturePair pair;
        NphEvidence evidence;
        for (int k = 0; k < 2; k++) {
            for (int c = 0; c < 3; c++)
                for (int i = 0; i < 4; i++) {
                    synthetic_plane(&images[k], synthetic_names[c][0])[i] = 1.0f + 0.1f * (float)k;
                    synthetic_plane(&images[k], synthetic_names[c][1])[i] = 0.01f;
                    synthetic_plane(&images[k], synthetic_names[c][2])[i] = 0.5f;
                    synthetic_plane(&images[k], "N")[i] = k ? 32.0f : 8.0f;
                }
            if (methods[m][k]) ck_assert_int_eq(nph_image_set_text(context, &images[k], "method", methods[m][k]), NPH_OK);
        }
        ck_assert_int_eq(nph_pair_read(context, &images[0], &images[1], &pair), NPH_OK);
        ck_assert_int_eq(pair.one_law, m < 3);
        nph_region_weigh(&pair, (NphRect){0, 0, 2, 2, 0}, 0, 0.1, &evidence);
        ck_assert_double_eq_tol(evidence.standard_error, sqrt(4.0 * (m < 3 ? pooled : 0.02)) / 4.0, 1e-8);
        /* exchanging samples bounds p by a normal's; of two laws there is Student's alone */
        double student = 2.0 * nph_student_lower(-0.1 / evidence.standard_error, evidence.dof);
        if (m == 3) ck_assert_double_eq_tol(evidence.p_equal, student, 1e-6);
        for (int k = 0; k < 2; k++) nph_image_free(context, &images[k]);
    }
}
END_TEST

/* Sixteen pixels with the same random numbers, differences -1, 3, -1, 3, ... (in units of 0.01): mean 1, deviations all
 * 2, so the standard error is 0.02 / sqrt(15), and the fourth moment that of two points: the floor 2 / 15 of Vov. */
START_TEST(the_evidence_of_pairs_is_the_formula_at_the_price_of_two_tests) {
    NphImage a = flat(4, 4, 1.0, 4.0), b = flat(4, 4, 1.0, 4.0);
    NphPicturePair pair;
    NphEvidence evidence;
    for (int i = 0; i < 16; i++) synthetic_plane(&a, "R")[i] = i % 2 ? 1.03f : 0.99f;
    mark_paired(&a, &b);
    ck_assert_int_eq(nph_pair_read(context, &a, &b, &pair), NPH_OK);
    nph_region_weigh(&pair, (NphRect){0, 0, 4, 4, 0}, 0, 0.05, &evidence);
    double t = 0.01 / (0.02 / sqrt(15.0));
    ck_assert_double_eq_tol(evidence.ratio, t, 1e-5);
    ck_assert_double_eq_tol(evidence.dof, 15.0, 1e-5);
    ck_assert_double_eq_tol(evidence.p_equal, 2.0 * 2.0 * nph_student_lower(-t, 15.0), 1e-6);
    ck_assert_double_eq_tol(evidence.p_beyond, 2.0 * nph_student_lower(-4.0 * t, 15.0), 1e-6);
    nph_image_free(context, &a);
    nph_image_free(context, &b);
}
END_TEST

/* Tiles of eight pixels, too few for a scatter of their own: equal pixels are equal, whatever the noise. */
START_TEST(identical_tiles_of_a_pair_are_exactly_equal) {
    NphImage a = flat(40, 1, 1.0, 4.0), b = flat(40, 1, 1.0, 4.0);
    synthetic_plane(&a, "G")[17] = 1.00001f;
    mark_paired(&a, &b);
    ck_assert_int_eq(judge(&a, &b), NPH_INCONCLUSIVE);
    ck_assert_int_eq(result.levels[1].regions, 5);
    ck_assert_int_eq(result.levels[1].same, 4);
    nph_image_free(context, &a);
    nph_image_free(context, &b);
}
END_TEST

START_TEST(metrics_are_of_luminance_and_relative_to_b) {
    NphImage a = flat(100, 2, 2.0, 0.01), b = flat(100, 2, 2.0, 0.03);
    synthetic_plane(&a, "R")[10] = 3.0f;  /* + 0.2126 */
    synthetic_plane(&a, "G")[120] = 1.0f; /* - 0.7152 */
    synthetic_plane(&a, "B")[50] = 2.5f;  /* + 0.0361 */
    judge(&a, &b);
    double r = 0.2126, g = -0.7152, blue = 0.0361;
    ck_assert_double_eq_tol(result.relative_bias, (r + g + blue) / 200.0 / 2.0, 1e-12);
    ck_assert_double_eq_tol(result.relative_rmse, sqrt((r * r + g * g + blue * blue) / 200.0) / 2.0, 1e-12);
    ck_assert_double_eq_tol(result.noise_rmse, sqrt(0.04) / 2.0, 1e-8);
    ck_assert_double_eq_tol(result.largest, 0.7152 / 2.0, 1e-12);
    ck_assert_double_eq_tol(result.percentile_99, 0.0361 / 2.0, 1e-12); /* the third largest of 200 */
    ck_assert_double_eq_tol(result.mean_a[0], 2.005, 1e-12);
    ck_assert_double_eq_tol(result.difference[1], -0.005 / 2.0, 1e-12);
    ck_assert_double_eq_tol(result.standard_error[1], sqrt(0.04 / 200.0) / 2.0, 1e-8);
    nph_image_free(context, &a);
    nph_image_free(context, &b);
}
END_TEST

START_TEST(the_map_holds_each_pixels_z) {
    NphImage a = flat(5, 4, 2.0, 0.01), b = flat(5, 4, 2.0, 0.03), map;
    NphCompareOptions options;
    nph_compare_options_default(&options);
    synthetic_plane(&a, "R")[7] = 3.0f;
    synthetic_plane(&a, "G")[3] = 1.0f;
    synthetic_plane(&a, "Variance.G")[3] = synthetic_plane(&b, "Variance.G")[3] = 0.0f;
    a.x0 = b.x0 = 2;
    a.full_width = 50;
    ck_assert_int_eq(nph_compare(context, &a, &b, &options, &result, &map), NPH_OK);
    ck_assert_double_eq_tol(synthetic_plane(&map, "Z.R")[7], 5.0, 1e-5);
    ck_assert_double_eq_tol(synthetic_plane(&map, "Z.G")[3], -1e30, 1e24);
    ck_assert_double_eq(synthetic_plane(&map, "Z.B")[7], 0.0);
    ck_assert_int_eq(map.x0, 2);
    ck_assert_int_eq(map.full_width, 50);
    nph_image_free(context, &a);
    nph_image_free(context, &b);
    nph_image_free(context, &map);
}
END_TEST

START_TEST(the_histogram_sees_wrong_error_bars_where_it_is_valid) {
    NphImage a = noisy(1, 64, 0.01), b = noisy(2, 64, 0.01);
    ck_assert_int_eq(judge(&a, &b), NPH_SAME);
    ck_assert_ptr_null(result.pixel_histogram_not_tested);
    ck_assert_double_gt(result.pixel_histogram_p, 0.001);
    for (int k = 0; k < 2; k++) { /* error bars a fifth too short */
        float *plane = synthetic_plane(k ? &a : &b, "Variance.G");
        for (int i = 0; i < PIXELS; i++) plane[i] *= 0.64f;
    }
    ck_assert_int_eq(judge(&a, &b), NPH_SAME);
    ck_assert_double_lt(result.pixel_histogram_p, 1e-6);
    check_reason("times as wide as their error bars");
    nph_image_free(context, &a);
    nph_image_free(context, &b);
}
END_TEST

START_TEST(the_histogram_is_not_tested_on_heavy_tails_or_unequal_pictures) {
    static Moments moments[PIXELS];
    static double scene[PIXELS];
    NphImage a = noisy(1, 64, 1.0), b = noisy(2, 64, 1.0);
    synthetic_scene(WIDTH, HEIGHT, 1, scene);
    draw_pixels(&exponential, 1, PIXELS, 64, moments);
    synthetic_fill(&a, 1, scene, moments, 1.0, 1.0);
    draw_pixels(&exponential, 2, PIXELS, 64, moments);
    synthetic_fill(&b, 1, scene, moments, 1.0, 1.0);
    judge(&a, &b);
    ck_assert_str_eq(result.pixel_histogram_not_tested, "heavy tails");
    for (int i = 0; i < PIXELS; i++) synthetic_plane(&a, "N")[i] = 128.0f;
    judge(&a, &b);
    ck_assert_str_eq(result.pixel_histogram_not_tested, "unequal numbers of samples");
    nph_image_free(context, &a);
    nph_image_free(context, &b);
    judge_once(noisy(1, 64, 1.0), noisy(2, 64, 0.0));
    ck_assert_str_eq(result.pixel_histogram_not_tested, "unequal noise");
}
END_TEST

START_TEST(memory_that_fails_leaks_nothing) {
    uint64_t failures = 0;
    for (uint64_t n = 1; n < 100; n++) {
        NphImage a = noisy(1, 16, 1.0), b = noisy(2, 16, 1.0), map = {0};
        uint64_t used = nph_context_allocations(context);
        nph_image_free(context, &a);
        nph_image_free(context, &b);
        close_context();
        NphSettings settings;
        nph_settings_default(&settings);
        settings.threads = 1;
        settings.fail_allocation = used + n;
        ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
        a = noisy(1, 16, 1.0);
        b = noisy(2, 16, 1.0);
        NphCompareOptions options;
        nph_compare_options_default(&options);
        NphStatus status = nph_compare(context, &a, &b, &options, &result, &map);
        if (status == NPH_OK) nph_image_free(context, &map);
        nph_image_free(context, &a);
        nph_image_free(context, &b);
        nph_test_context_close(context);
        open_context();
        if (status == NPH_OK) break;
        ck_assert_int_eq(status, NPH_NO_MEMORY);
        failures++;
    }
    ck_assert_uint_gt(failures, 8);
}
END_TEST

static void fill(TCase *cases) {
    distribution_make(&gaussian, "gaussian", gaussian_quantile);
    distribution_make(&exponential, "exponential", exponential_quantile);
    tcase_add_checked_fixture(cases, open_context, close_context);
    tcase_add_test(cases, holm_rejects_in_steps);
    tcase_add_test(cases, levels_that_repeat_the_image_are_left_out);
    tcase_add_test(cases, what_cannot_be_compared_is_refused_by_name);
    tcase_add_test(cases, options_out_of_range_are_refused);
    tcase_add_test(cases, the_evidence_of_a_region_is_the_formula);
    tcase_add_test(cases, pictures_of_two_methods_do_not_lend_each_other_their_variance);
    tcase_add_test(cases, the_evidence_of_pairs_is_the_formula_at_the_price_of_two_tests);
    tcase_add_test(cases, identical_tiles_of_a_pair_are_exactly_equal);
    tcase_add_test(cases, metrics_are_of_luminance_and_relative_to_b);
    tcase_add_test(cases, the_map_holds_each_pixels_z);
    tcase_add_test(cases, the_histogram_sees_wrong_error_bars_where_it_is_valid);
    tcase_add_test(cases, the_histogram_is_not_tested_on_heavy_tails_or_unequal_pictures);
    tcase_add_test(cases, memory_that_fails_leaks_nothing);
}

int main(void) { return nph_test_main("compare_parts", fill); }
