/* SPDX-License-Identifier: Apache-2.0
 *
 * The JSON writer: its layout to the byte, escapes, text that is not UTF-8, numbers. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "core/json.h"
#include "core/text.h"
#include "harness.h"

static char written[4096];

static void collect(void *user, const char *text, size_t length) {
    (void)user;
    ck_assert_uint_lt(strlen(written) + length, sizeof written);
    strncat(written, text, length);
}

static NphJson begin(void) {
    NphJson json;
    written[0] = 0;
    nph_json_begin(&json, collect, NULL);
    return json;
}

START_TEST(the_layout_is_fixed) {
    NphJson json = begin();
    nph_json_object(&json, NULL);
    nph_json_text(&json, "name", "cumulus");
    nph_json_integer(&json, "pixels", INT64_MIN);
    nph_json_boolean(&json, "paired", 1);
    nph_json_boolean(&json, "grey", 0);
    nph_json_text(&json, "seed", NULL);
    nph_json_numbers(&json, "mean", 3, (double[]){0.1, 1, -2.5e-7});
    nph_json_object(&json, "empty");
    nph_json_close(&json);
    nph_json_array(&json, "levels");
    for (int i = 0; i < 2; i++) {
        nph_json_object(&json, NULL);
        nph_json_integer(&json, "i", i);
        nph_json_close(&json);
    }
    nph_json_close(&json);
    nph_json_array(&json, "none");
    nph_json_close(&json);
    nph_json_close(&json);
    ck_assert_str_eq(written, "{\n  \"name\": \"cumulus\",\n  \"pixels\": -9223372036854775808,\n  \"paired\": true,\n"
                              "  \"grey\": false,\n  \"seed\": null,\n  \"mean\": [0.1, 1, -2.5e-07],\n  \"empty\": {},\n"
                              "  \"levels\": [\n    {\n      \"i\": 0\n    },\n    {\n      \"i\": 1\n    }\n  ],\n"
                              "  \"none\": []\n}\n");
}
END_TEST

START_TEST(a_line_is_copied_into_a_document) {
    NphJson json;
    char line[128];
    written[0] = 0;
    nph_json_begin_line(&json, collect, NULL);
    nph_json_object(&json, NULL);
    nph_json_object(&json, "arguments");
    nph_json_integer(&json, "tile", 5);
    nph_json_integer(&json, "chunk", 0);
    nph_json_close(&json);
    nph_json_array(&json, "outputs");
    for (int i = 0; i < 2; i++) {
        nph_json_object(&json, NULL);
        nph_json_close(&json);
    }
    nph_json_close(&json);
    nph_json_close(&json);
    ck_assert_str_eq(written, "{\"arguments\": {\"tile\": 5, \"chunk\": 0}, \"outputs\": [{}, {}]}");
    strcpy(line, written);
    json = begin();
    nph_json_array(&json, NULL);
    for (int i = 0; i < 2; i++) nph_json_copy(&json, NULL, line, strlen(line));
    nph_json_close(&json);
    ck_assert_str_eq(written, "[\n  {\"arguments\": {\"tile\": 5, \"chunk\": 0}, \"outputs\": [{}, {}]},\n  {\"arguments\": {\"tile\": 5, \"chunk\": 0}, \"outputs\": [{}, {}]}\n]\n");
}
END_TEST

START_TEST(text_is_escaped_and_always_utf8) {
    NphJson json = begin();
    nph_json_array(&json, NULL);
    nph_json_text(&json, NULL, "a\"b\\c\n\t\r\b\f\x01\x1f/");
    nph_json_text(&json, NULL, "g\xC3\xBCltig \xE2\x98\x81 \xF0\x9F\x8C\xA5");
    nph_json_close(&json);
    ck_assert_str_eq(written, "[\"a\\\"b\\\\c\\n\\t\\r\\b\\f\\u0001\\u001f/\", "
                              "\"g\xC3\xBCltig \xE2\x98\x81 \xF0\x9F\x8C\xA5\"]\n");
    static const char *const broken[] = {"\xFF", "\xC0\x80", "\xE2\x98", "\xED\xA0\x80", "\xF5\x80\x80\x80", "\x80", "\xC3"};
    for (int i = 0; i < 7; i++) {
        json = begin();
        nph_json_array(&json, NULL);
        nph_json_text(&json, NULL, broken[i]);
        nph_json_close(&json);
        ck_assert_int_eq(strncmp(written, "[\"\xEF\xBF\xBD", 5), 0);
        for (const char *c = written; *c; c++) {
            ck_assert_msg(strchr("[]\"\n\xEF\xBF\xBD", *c) != NULL, "byte %02x of broken text %d passed", (unsigned char)*c, i);
        }
    }
}
END_TEST

START_TEST(numbers_read_back_and_what_is_not_finite_is_null) {
    static const double values[] = {1.0 / 3.0, 5e-324, 1.7976931348623157e308, -0.0, 123456789012345678.0};
    for (int i = 0; i < 5; i++) {
        NphJson json = begin();
        double back = 0.0;
        nph_json_number(&json, NULL, values[i]);
        ck_assert_int_eq(nph_parse_double(written, &back), 1);
        ck_assert_int_eq(memcmp(&back, &values[i], sizeof back), 0);
    }
    NphJson json = begin();
    nph_json_numbers(&json, NULL, 3, (double[]){NAN, INFINITY, -INFINITY});
    ck_assert_str_eq(written, "[null, null, null]\n");
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, the_layout_is_fixed);
    tcase_add_test(cases, a_line_is_copied_into_a_document);
    tcase_add_test(cases, text_is_escaped_and_always_utf8);
    tcase_add_test(cases, numbers_read_back_and_what_is_not_finite_is_null);
}

int main(void) { return nph_test_main("json", fill); }
