/* SPDX-License-Identifier: Apache-2.0
 *
 * Numbers as text. */
#define _POSIX_C_SOURCE 200809L
#include <fenv.h>
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/text.h"
#include "harness.h"

START_TEST(plain_decimals_are_read_and_nothing_else_is) {
    static const struct { const char *text; double value; } right[] = {
        {"0", 0}, {"-0", -0.0}, {"7", 7}, {"-3", -3}, {"+.5", 0.5}, {"2.", 2}, {"1e5", 1e5}, {"6.02E+23", 6.02e23},
        {"1e-5", 1e-5}, {"0.1", 0.1}, {"1e308", 1e308}, {"00012.50", 12.5}, {"4.9406564584124654e-324", 0x1p-1074},
        {"1e-999", 0}, {"1.7976931348623157e308", 1.7976931348623157e308},
        /* halfway between two doubles, and one digit beyond: correctly rounded */
        {"9007199254740993", 9007199254740992.0}, {"9007199254740993.0000000000000000000001", 9007199254740994.0}};
    static const char *const wrong[] = {
        "", " ", "1 ", " 1", "+", "-", ".", "e5", ".e5", "1e", "1e+", "1.2.3", "0x10", "1_000", "1,5", "nan", "inf",
        "-inf", "infinity", ".inf", "1f", "--1", "1e999", "-1e999", "1.7976931348623159e308", "1:30", "1e5.0", "\xd9\xa1"};
    for (size_t i = 0; i < sizeof right / sizeof right[0]; i++) {
        double value = 99;
        ck_assert_msg(nph_parse_double(right[i].text, &value), "%s", right[i].text);
        ck_assert_msg(memcmp(&value, &right[i].value, sizeof value) == 0, "%s gives %.17g", right[i].text, value);
    }
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        double value = 99;
        ck_assert_msg(!nph_parse_double(wrong[i], &value), "%s", wrong[i]);
        ck_assert_double_eq(value, 99);
    }
}
END_TEST

START_TEST(integers_are_read_to_the_limits_of_64_bits) {
    static const struct { const char *text; int64_t value; } right[] = {
        {"0", 0}, {"-0", 0}, {"+12", 12}, {"007", 7}, {"9223372036854775807", INT64_MAX},
        {"-9223372036854775808", INT64_MIN}};
    static const char *const wrong[] = {"", "-", "1.0", "1e3", "0x1", " 1", "1 ", "9223372036854775808",
                                        "-9223372036854775809", "99999999999999999999"};
    int64_t value;
    for (size_t i = 0; i < sizeof right / sizeof right[0]; i++) {
        ck_assert_msg(nph_parse_int(right[i].text, &value), "%s", right[i].text);
        ck_assert_int_eq(value, right[i].value);
    }
    value = 99;
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        ck_assert_msg(!nph_parse_int(wrong[i], &value), "%s", wrong[i]);
        ck_assert_int_eq(value, 99);
    }
}
END_TEST

START_TEST(a_range_ends_where_it_says_even_within_digits) {
    const char *text = "12345";
    double number;
    int64_t integer;
    ck_assert(nph_parse_double_range(text + 1, text + 3, &number));
    ck_assert_double_eq(number, 23);
    ck_assert(nph_parse_int_range(text + 1, text + 3, &integer));
    ck_assert_int_eq(integer, 23);
    ck_assert(!nph_parse_int_range(text, text, &integer));
    char huge[2000];
    memset(huge, '1', sizeof huge);
    ck_assert(nph_is_decimal(huge, huge + sizeof huge));
    ck_assert(!nph_parse_double_range(huge, huge + sizeof huge, &number));
    ck_assert(!nph_parse_double_range(huge, huge + NPH_NUMBER_MAX, &number)); /* about 1e1023 */
    ck_assert(nph_parse_double_range(huge, huge + 300, &number));
}
END_TEST

START_TEST(every_double_survives_being_written_and_read) {
    uint64_t state = 1;
    for (int i = 0; i < 50000; i++) {
        char text[NPH_DOUBLE_TEXT];
        double value, again = 99;
        state = state * 6364136223846793005u + 1442695040888963407u;
        uint64_t bits = state ^ state >> 29;
        memcpy(&value, &bits, sizeof value);
        nph_format_double(value, text);
        if (!isfinite(value)) continue;
        ck_assert_msg(nph_parse_double(text, &again), "%s", text);
        ck_assert_msg(memcmp(&value, &again, sizeof value) == 0, "%s", text);
    }
    char text[NPH_DOUBLE_TEXT];
    ck_assert_str_eq(nph_format_double(0.1, text), "0.1");
    ck_assert_str_eq(nph_format_double(-2, text), "-2");
    ck_assert_str_eq(nph_format_double(0.1 + 0.2, text), "0.30000000000000004");
    ck_assert_str_eq(nph_format_double(-1.7976931348623157e308, text), "-1.7976931348623157e+308");
    ck_assert_str_eq(nph_format_double(nan(""), text), "nan");
    ck_assert_str_eq(nph_format_double(-HUGE_VAL, text), "-inf");
}
END_TEST

START_TEST(rounding_mode_of_the_caller_changes_nothing_and_stays) {
    double near, up;
    ck_assert(nph_parse_double("0.1", &near));
    fesetround(FE_UPWARD);
    ck_assert(nph_parse_double("0.1", &up));
    ck_assert_int_eq(fegetround(), FE_UPWARD);
    fesetround(FE_TONEAREST);
    ck_assert(near == 0.1 && up == near);
}
END_TEST

START_TEST(rounded_numbers_have_the_digits_asked_for) {
    char text[NPH_DOUBLE_TEXT];
    ck_assert_str_eq(nph_format_rounded(0.00299999, 3, text), "0.003");
    ck_assert_str_eq(nph_format_rounded(-1234567.0, 2, text), "-1.2e+06");
    ck_assert_str_eq(nph_format_rounded(1.0 / 3.0, 17, text), "0.33333333333333331");
    ck_assert_str_eq(nph_format_rounded(HUGE_VAL, 3, text), "inf");
}
END_TEST

/* Makes a German locale in the test's folder where the system can; its decimal point is a comma. */
START_TEST(a_locale_with_a_decimal_comma_changes_nothing) {
    char command[1400];
    setenv("LOCPATH", nph_test_temporary("."), 1);
    snprintf(command, sizeof command, "localedef -i de_DE -f UTF-8 '%s' >/dev/null 2>&1", nph_test_temporary("de_DE.UTF-8"));
    if (system(command) != 0 || !setlocale(LC_ALL, "de_DE.UTF-8")) {
        nph_test_skip("core/text: no locale with a decimal comma on this system");
        return;
    }
    char text[NPH_DOUBLE_TEXT];
    double value = 0;
    snprintf(text, sizeof text, "%.1f", 1.5);
    ck_assert_str_eq(text, "1,5");
    ck_assert_str_eq(nph_format_double(1.5, text), "1.5");
    ck_assert(nph_parse_double("1.5", &value));
    ck_assert_double_eq(value, 1.5);
    ck_assert(!nph_parse_double("1,5", &value));
    ck_assert_str_eq(localeconv()->decimal_point, ",");
    ck_assert_str_eq(nph_format_rounded(3.14159, 3, text), "3.14");
    snprintf(command, sizeof command, "rm -r '%s'", nph_test_temporary("de_DE.UTF-8"));
    ck_assert_int_eq(system(command), 0);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, plain_decimals_are_read_and_nothing_else_is);
    tcase_add_test(cases, integers_are_read_to_the_limits_of_64_bits);
    tcase_add_test(cases, a_range_ends_where_it_says_even_within_digits);
    tcase_add_test(cases, every_double_survives_being_written_and_read);
    tcase_add_test(cases, rounding_mode_of_the_caller_changes_nothing_and_stays);
    tcase_add_test(cases, rounded_numbers_have_the_digits_asked_for);
    tcase_add_test(cases, a_locale_with_a_decimal_comma_changes_nothing);
}

int main(void) { return nph_test_main("text", fill); }
