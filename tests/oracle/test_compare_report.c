/* SPDX-License-Identifier: Apache-2.0
 *
 * The three forms of a comparison's report, to the byte. */
#include <stdio.h>
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
        .levels = {{"image", 1, 1, 0, 6.9, 16, 0, 104, "G", 0.0021, NPH_NOT_SAME}},
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
    nph_comparison_text((NphReport){&comparison, NULL}, collect_line, written);
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
    nph_comparison_text((NphReport){&comparison, NULL}, collect_line, written);
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
    nph_comparison_text((NphReport){&comparison, NULL}, collect_line, written);
    ck_assert_ptr_nonnull(strstr(written, comparison.reason));
}
END_TEST

START_TEST(json_holds_every_field) {
    NphComparison comparison = example();
    NphJson json;
    written[0] = 0;
    nph_json_begin(&json, collect_text, written);
    nph_comparison_json((NphReport){&comparison, NULL}, &json, NULL);
    ck_assert_str_eq(written,
        "{\n  \"verdict\": \"different\",\n"
        "  \"reason\": \"image, channel G: A is 0.21% above B, 6.9 standard errors (p = 5e-12)\",\n"
        "  \"paired\": false,\n  \"pixels\": 2496,\n  \"identical_pixels\": 3,\n"
        "  \"mean_a\": [0.3333333333333333, 0.5, 2e-09],\n  \"mean_b\": [0.25, 0.499, 0],\n"
        "  \"difference\": [0.0001, 0.0021, -0.02],\n  \"standard_error\": [0.0003, 0.000304, 0],\n"
        "  \"levels\": [\n    {\n      \"name\": \"image\",\n      \"regions\": 1,\n      \"different\": 1,\n"
        "      \"same\": 0,\n      \"worst_z\": 6.9,\n      \"worst_x\": 16,\n      \"worst_y\": 0,\n"
        "      \"worst_size\": 104,\n      \"worst_channel\": \"G\",\n      \"worst_difference\": 0.0021,\n"
        "      \"verdict\": \"different\"\n    }\n  ],\n"
        "  \"relative_bias\": 0.0015,\n  \"relative_rmse\": 0.031,\n  \"noise_rmse\": 0.03,\n"
        "  \"percentile_99\": 0.08,\n  \"largest\": 0.5,\n  \"pixel_histogram_p\": 0.25\n}\n");
    comparison.pixel_histogram_not_tested = "heavy tails";
    written[0] = 0;
    nph_json_begin(&json, collect_text, written);
    nph_comparison_json((NphReport){&comparison, NULL}, &json, NULL);
    ck_assert_ptr_nonnull(strstr(written, "\"pixel_histogram_p\": null,\n"
                                          "  \"pixel_histogram_not_tested\": \"heavy tails\""));
}
END_TEST

static NphFlip example_flip(void) {
    return (NphFlip){.kind = NPH_FLIP_HDR, .pixels_per_degree = 67.02, .start_stops = -1.5, .stop_stops = 2.25, .exposures = 4,
                     .mean = 0.0625, .largest = 0.5, .largest_x = 3, .largest_y = 7, .noise_mean = 0.03125};
}

START_TEST(flip_is_one_line_more_and_an_object_of_its_own) {
    NphComparison comparison = example();
    NphFlip flip = example_flip();
    NphJson json;
    written[0] = 0;
    nph_comparison_text((NphReport){&comparison, &flip}, collect_line, written);
    ck_assert_ptr_nonnull(strstr(written, "\nHDR-FLIP       mean 0.0625 (noise alone: 0.0312), largest 0.5 at (3, 7); "
                                          "4 exposures from -1.5 to 2.25 stops, 67.02 pixels per degree\n"));
    written[0] = 0;
    nph_json_begin(&json, collect_text, written);
    nph_comparison_json((NphReport){&comparison, &flip}, &json, NULL);
    ck_assert_ptr_nonnull(strstr(written,
        "  \"flip\": {\n    \"kind\": \"HDR\",\n    \"mean\": 0.0625,\n    \"noise_mean\": 0.03125,\n    \"largest\": 0.5,\n"
        "    \"largest_x\": 3,\n    \"largest_y\": 7,\n    \"exposures\": 4,\n    \"start_stops\": -1.5,\n"
        "    \"stop_stops\": 2.25,\n    \"pixels_per_degree\": 67.02\n  }\n}\n"));
    flip.noise_unknown = "no variances";
    flip.kind = NPH_FLIP_LDR;
    flip.exposures = 0;
    written[0] = 0;
    nph_comparison_text((NphReport){&comparison, &flip}, collect_line, written);
    ck_assert_ptr_nonnull(strstr(written, "LDR-FLIP       mean 0.0625 (noise alone: unknown: no variances), largest 0.5 at "
                                          "(3, 7); 67.02 pixels per degree\n"));
}
END_TEST

START_TEST(junit_says_the_verdicts_in_the_words_of_the_text) {
    NphComparison comparison = example();
    NphFlip flip = example_flip();
    comparison.level_count = 2;
    comparison.levels[1] = (NphCompareLevel){"8^2 tiles", 39, 0, 39, 1.5, 0, 8, 8, "G", -0.01, NPH_SAME};
    written[0] = 0;
    nph_comparison_junit((NphReport){&comparison, &flip}, "a.exr against b.exr", collect_text, written);
    const char *expected =
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n"
        "  <testsuite name=\"a.exr against b.exr\" tests=\"3\" failures=\"2\" errors=\"0\">\n"
        "    <properties>\n      <property name=\"relative_bias\" value=\"0.0015\"/>\n"
        "      <property name=\"relative_rmse\" value=\"0.031\"/>\n      <property name=\"flip_mean\" value=\"0.0625\"/>\n"
        "      <property name=\"flip_noise_mean\" value=\"0.03125\"/>\n    </properties>\n"
        "    <testcase classname=\"a.exr against b.exr\" name=\"verdict\">\n      <failure type=\"different\" "
        "message=\"image, channel G: A is 0.21% above B, 6.9 standard errors (p = 5e-12)\"/>\n    </testcase>\n"
        "    <testcase classname=\"a.exr against b.exr\" name=\"image\">\n      <failure type=\"different\" "
        "message=\"1 of 1 regions different, 0 shown same, largest |z| 6.9: G at (16, 0), 104 wide: +0.21% of the image's "
        "luminance\"/>\n    </testcase>\n"
        "    <testcase classname=\"a.exr against b.exr\" name=\"8^2 tiles\"/>\n    <system-out>\n"
        "different: image, channel G: A is 0.21% above B, 6.9 standard errors (p = 5e-12)\n2496 pixels, 3 of them equal\n";
    ck_assert_msg(strncmp(written, expected, strlen(expected)) == 0, "%s", written);
    ck_assert_ptr_nonnull(strstr(written, "pixels per degree\n    </system-out>\n  </testsuite>\n</testsuites>\n"));
}
END_TEST

START_TEST(junit_holds_any_bytes_of_a_file_name) {
    static const struct {
        const char *bytes, *escaped;
    } names[] = {
        {"<a & \"b\">", "&lt;a &amp; &quot;b&quot;&gt;"},
        {"line\n\tbreak\r", "line&#10;&#9;break&#13;"},
        {"wolke \xc3\xa4 \xf0\x9f\x8c\xa7", "wolke \xc3\xa4 \xf0\x9f\x8c\xa7"},
        {"bell \x07 half \xc3", "bell \xef\xbf\xbd half \xef\xbf\xbd"},
        {"long \xc0\xaf half \xed\xa0\x80 none \xef\xbf\xbf", "long \xef\xbf\xbd\xef\xbf\xbd half "
         "\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd none \xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd"},
    };
    NphComparison comparison = example();
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        char expected[200];
        snprintf(expected, sizeof expected, "<testsuite name=\"%s\" tests=", names[i].escaped);
        written[0] = 0;
        nph_comparison_junit((NphReport){&comparison, NULL}, names[i].bytes, collect_text, written);
        ck_assert_msg(strstr(written, expected) != NULL, "%s is not in:\n%s", expected, written);
    }
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, text_tells_the_verdict_first_and_lines_up);
    tcase_add_test(cases, text_leaves_out_what_is_unknown);
    tcase_add_test(cases, the_longest_reason_is_not_cut);
    tcase_add_test(cases, json_holds_every_field);
    tcase_add_test(cases, flip_is_one_line_more_and_an_object_of_its_own);
    tcase_add_test(cases, junit_says_the_verdicts_in_the_words_of_the_text);
    tcase_add_test(cases, junit_holds_any_bytes_of_a_file_name);
}

int main(void) { return nph_test_main("compare_report", fill); }
