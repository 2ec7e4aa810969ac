/* SPDX-License-Identifier: Apache-2.0
 *
 * The image container: planes and attributes by name, and what it refuses. */
#include <math.h>
#include <string.h>

#include "harness.h"
#include "nephos/image.h"

START_TEST(channels_are_zeroed_and_found_by_name) {
    NphContext *context = nph_test_context(1);
    NphImage image = {0};
    float *red = NULL;
    ck_assert_int_eq(nph_image_new(context, 5, 3, &image), NPH_OK);
    ck_assert_int_eq(image.full_width, 5);
    ck_assert_int_eq(image.full_height, 3);
    ck_assert_int_eq(nph_image_add_channel(context, &image, "R", &red), NPH_OK);
    ck_assert_int_eq(nph_image_add_channel(context, &image, "Variance.R", NULL), NPH_OK);
    for (int i = 0; i < 15; i++) ck_assert_float_eq(red[i], 0);
    ck_assert_ptr_eq(nph_image_channel(&image, "R")->pixels, red);
    ck_assert_ptr_eq(nph_image_channel(&image, "Variance.R"), &image.channels[1]);
    ck_assert_ptr_null(nph_image_channel(&image, "G"));
    nph_image_free(context, &image);
    ck_assert_ptr_null(image.channels);
    nph_image_free(context, &image);
    nph_test_context_close(context);
}
END_TEST

START_TEST(an_attribute_set_again_replaces_the_first_and_may_change_its_type) {
    NphContext *context = nph_test_context(1);
    NphImage image = {0};
    ck_assert_int_eq(nph_image_new(context, 1, 1, &image), NPH_OK);
    ck_assert_int_eq(nph_image_set_text(context, &image, "a", "one"), NPH_OK);
    ck_assert_int_eq(nph_image_set_number(context, &image, "b", NPH_ATTRIBUTE_FLOAT, 0.1), NPH_OK);
    ck_assert_int_eq(nph_image_set_text(context, &image, "a", "two"), NPH_OK);
    ck_assert_int_eq(image.attribute_count, 2);
    ck_assert_str_eq(nph_image_attribute(&image, "a")->text, "two");
    ck_assert_double_eq(nph_image_attribute(&image, "b")->number, (double)0.1f);
    ck_assert_int_eq(nph_image_set_number(context, &image, "a", NPH_ATTRIBUTE_DOUBLE, NAN), NPH_OK);
    ck_assert_ptr_null(nph_image_attribute(&image, "a")->text);
    ck_assert_int_eq(nph_image_set_text(context, &image, "b", ""), NPH_OK);
    ck_assert_int_eq(image.attribute_count, 2);
    ck_assert_ptr_null(nph_image_attribute(&image, "c"));
    nph_image_free(context, &image);
    nph_test_context_close(context);
}
END_TEST

START_TEST(what_a_file_could_not_hold_is_refused_and_changes_nothing) {
    NphContext *context = nph_test_context(1);
    NphImage image = {.width = 77};
    ck_assert_int_eq(nph_image_new(context, 0, 3, &image), NPH_BAD_USAGE);
    ck_assert_int_eq(nph_image_new(context, 3, -1, &image), NPH_BAD_USAGE);
    ck_assert_int_eq(image.width, 77);
    ck_assert_int_eq(nph_image_new(context, 2, 2, &image), NPH_OK);
    ck_assert_int_eq(nph_image_add_channel(context, &image, "R", NULL), NPH_OK);
    ck_assert_int_eq(nph_image_add_channel(context, &image, "R", NULL), NPH_BAD_USAGE);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "\"R\" is added twice"));
    char name[400];
    memset(name, 'x', sizeof name);
    name[256] = 0;
    ck_assert_int_eq(nph_image_add_channel(context, &image, name, NULL), NPH_BAD_USAGE);
    ck_assert_int_eq(nph_image_set_text(context, &image, name, ""), NPH_BAD_USAGE);
    ck_assert_int_eq(nph_image_set_text(context, &image, "", ""), NPH_BAD_USAGE);
    ck_assert_int_eq(nph_image_add_channel(context, &image, "", NULL), NPH_BAD_USAGE);
    ck_assert_int_eq(nph_image_set_text(context, &image, "dataWindow", ""), NPH_BAD_USAGE);
    ck_assert_int_eq(nph_image_set_number(context, &image, "type", NPH_ATTRIBUTE_INT, 1), NPH_BAD_USAGE);
    ck_assert_int_eq(nph_image_set_number(context, &image, "a", NPH_ATTRIBUTE_STRING, 1), NPH_BAD_USAGE);
    static const double not_int[] = {0.5, 2147483648.0, -2147483649.0, NAN, HUGE_VAL};
    for (int i = 0; i < 5; i++)
        ck_assert_int_eq(nph_image_set_number(context, &image, "a", NPH_ATTRIBUTE_INT, not_int[i]), NPH_BAD_USAGE);
    ck_assert_int_eq(nph_image_set_number(context, &image, "a", NPH_ATTRIBUTE_FLOAT, 1e39), NPH_BAD_USAGE);
    ck_assert_int_eq(nph_image_set_number(context, &image, "a", NPH_ATTRIBUTE_FLOAT, -HUGE_VAL), NPH_OK);
    ck_assert_int_eq(image.channel_count, 1);
    ck_assert_int_eq(image.attribute_count, 1);
    nph_image_free(context, &image);
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, channels_are_zeroed_and_found_by_name);
    tcase_add_test(cases, an_attribute_set_again_replaces_the_first_and_may_change_its_type);
    tcase_add_test(cases, what_a_file_could_not_hold_is_refused_and_changes_nothing);
}

int main(void) { return nph_test_main("image", fill); }
