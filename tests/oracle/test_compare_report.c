/* SPDX-License-Identifier: Apache-2.0
 *
 * The two forms of a comparison's report, to the byte. */
#include <string.h>

#include "harness.h"
#include "oracle/compare_report.h"

static char written[8192];

static void collect_line(void *user, const char *line) {
    ck_assert_ptr_eq(user, written);
    ck_assert_ptr_null(strchr(line, '\n'));
    ck_assert_uint_lt(strlen(written) + strlen(line) + 1, sizeof written);
    strcat(strcat(written, line), "\n");
}

static void collect_text(void *user, const char *text, size_t length) {
    ck_assert_uint_lt(strlen(user) + length, sizeof written);
    strncat(user, text, length);
}

static NphComparison example(void) {
    NphComparison made = {
        .verdict = NPH_NOT_SAME,
        .reason = "image, channel G: A is 0.21% above B, 6.9 standard errors (p = 5e-12)",
        .level_count = 1,
        .levels = {{"image", 1, 1, 0, 6.9, 16, 0, 104, "G", 0.0021}},
        .mean_a = {1.0 / 3.0, 0.5, 2e-9},
        .mean_b = {0.25, 0.499, 0},
        .difference = {0.0001, 0.0021, -0.02},
        .standard_error = {0.0003, 0.000304, 0.0},
        .relative_bias = 0.0015,
        .relative_rmse = 0.031,
        .noise_rmse = 0.03,
        .percentile_99 = 0.08,
        .largest = 0.5,
        .pixel_histogram_p = 0.25,
        .pixels = 2496,
        .identical_pixels = 3,
    };
    return made;
}

START_TEST(text_tells_the_verdict_first_and_lines_up) {
    NphComparison comparison = example();
    written[0] = 0;
    nph_comparison_text(&comparison, collect_line, written);
    ck_assert_str_eq(written,
        "different: image, channel G: A is 0.21% above B, 6.9 standard errors (p = 5e-12)\n"
        "2496 pixels, 3 of them equal\n"
        "                            R             G             B\n"
        "mean of A            0.333333           0.5         2e-09\n"
        "mean of B                0.25         0.499             0\n"
        "A - B                  +0.01%        +0.21%           -2%  of B's mean luminance\n"
        "standard error          0.03%       0.0304%            0%\n"
        "level            regions  different  shown same  largest |z|  worst region\n"
        "image                  1          1           0          6.9  G at (16, 0), 104 wide: +0.21% of the image's"
        " luminance\n"
        "luminance      bias +0.15%, RMSE 3.1% (noise alone: at most 3%), 99th percentile 8%, largest 50%\n"
        "pixels' z      histogram against Student t: p = 0.25\n");
}
END_TEST

START_TEST(text_leaves_out_what_is_unknown) {
    NphComparison comparison = example();
    comparison.level_count = 0;
    comparison.paired = 1;
    comparison.pixel_histogram_not_tested = "no variances";
    written[0] = 0;
    nph_comparison_text(&comparison, collect_line, written);
    ck_assert_ptr_null(strstr(written, "level"));
    ck_assert_ptr_null(strstr(written, "standard error  "));
    ck_assert_ptr_null(strstr(written, "noise alone"));
    ck_assert_ptr_nonnull(strstr(written, "same scene and seed"));
    ck_assert_ptr_nonnull(strstr(written, "histogram not tested: no variances"));
}
END_TEST

START_TEST(the_longest_reason_is_not_cut) {
    NphComparison comparison = example();
    memset(comparison.reason, 'x', sizeof comparison.reason - 1);
    written[0] = 0;
    nph_comparison_text(&comparison, collect_line, written);
    ck_assert_ptr_nonnull(strstr(written, comparison.reason));
}
END_TEST

START_TEST(json_holds_every_field) {
    NphComparison comparison = example();
    NphJson json;
    written[0] = 0;
    nph_json_begin(&json, collect_text, written);
    nph_comparison_json(&comparison, &json, NULL);
    ck_assert_str_eq(written,
        "{\n  \"verdict\": \"different\",\n"
        "  \"reason\": \"image, channel G: A is 0.21% above B, 6.9 standard errors (p = 5e-12)\",\n"
        "  \"paired\": false,\n  \"pixels\": 2496,\n  \"identical_pixels\": 3,\n"
        "  \"mean_a\": [0.3333333333333333, 0.5, 2e-09],\n  \"mean_b\": [0.25, 0.499, 0],\n"
        "  \"difference\": [0.0001, 0.0021, -0.02],\n  \"standard_error\": [0.0003, 0.000304, 0],\n"
        "  \"levels\": [\n    {\n      \"name\": \"image\",\n      \"regions\": 1,\n      \"different\": 1,\n"
        "      \"same\": 0,\n      \"worst_z\": 6.9,\n      \"worst_x\": 16,\n      \"worst_y\": 0,\n"
        "      \"worst_size\": 104,\n      \"worst_channel\": \"G\",\n      \"worst_difference\": 0.0021\n    }\n  ],\n"
        "  \"relative_bias\": 0.0015,\n  \"relative_rmse\": 0.031,\n  \"noise_rmse\": 0.03,\n"
        "  \"percentile_99\": 0.08,\n  \"largest\": 0.5,\n  \"pixel_histogram_p\": 0.25\n}\n");
    comparison.pixel_histogram_not_tested = "heavy tails";
    written[0] = 0;
    nph_json_begin(&json, collect_text, written);
    nph_comparison_json(&comparison, &json, NULL);
    ck_assert_ptr_nonnull(strstr(written, "\"pixel_histogram_p\": null,\n"
                                          "  \"pixel_histogram_not_tested\": \"heavy tails\""));
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, text_tells_the_verdict_first_and_lines_up);
    tcase_add_test(cases, text_leaves_out_what_is_unknown);
    tcase_add_test(cases, the_longest_reason_is_not_cut);
    tcase_add_test(cases, json_holds_every_field);
}

int main(void) { return nph_test_main("compare_report", fill); }
