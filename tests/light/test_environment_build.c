/* SPDX-License-Identifier: Apache-2.0
 *
 * Building environment maps: what is accepted, what is refused and how it is named; nothing leaks when memory fails. */
#include <math.h>
#include <string.h>

#include "harness.h"
#include "light/light.h"

static const double unit[3] = {1.0, 1.0, 1.0};

/* A 3 x 2 image with the named channels, filled with 0.5. */
static NphImage image_of(NphContext *context, const char *names) {
    NphImage image;
    ck_assert_int_eq(nph_image_new(context, 3, 2, &image), NPH_OK);
    for (; *names; names++) {
        char name[2] = {*names, 0};
        float *pixels;
        ck_assert_int_eq(nph_image_add_channel(context, &image, name, &pixels), NPH_OK);
        for (int i = 0; i < 6; i++) pixels[i] = 0.5f;
    }
    return image;
}

static void refused(const char *names, int pixel, float value, const double scale[3], const char *said) {
    NphContext *context = nph_test_context(1);
    NphImage image = image_of(context, names);
    NphEnvironment map = {.width = -7};
    if (pixel >= 0) image.channels[1].pixels[pixel] = value;
    if (pixel == -2) image.full_width = 4;
    ck_assert_int_eq(nph_environment_build(context, &image, scale, "sky.exr", &map), NPH_BAD_INPUT);
    const char *messages = nph_test_messages();
    ck_assert_msg(strstr(messages, "sky.exr") && strstr(messages, said), "said: %s", messages);
    ck_assert(map.width == -7 && !map.radiance);
    nph_image_free(context, &image);
    nph_test_context_close(context);
}

START_TEST(mistakes_are_refused_by_name_and_place) {
    refused("RGB", 4, NAN, unit, "channel G is not a number at pixel (1, 1)");
    refused("RGB", 2, INFINITY, unit, "channel G is infinite at pixel (2, 0)");
    refused("RGB", 5, -INFINITY, unit, "channel G is infinite at pixel (2, 1)");
    refused("RGB", 3, 1e30f, (double[]){1.0, 1e10, 1.0}, "channel G times its scale is 1e+40 at pixel (0, 1)");
    refused("RG", -1, 0.0f, unit, "R G only");
    refused("A", -1, 0.0f, unit, "none of R, G, B, Y");
    refused("RGB", -2, 0.0f, unit, "not the whole 4 x 2 image");
    refused("RGB", -1, 0.0f, (double[]){1.0, -1.0, 1.0}, "scale is -1");
    refused("RGB", -1, 0.0f, (double[]){1.0, 1.0, NAN}, "scale");
}
END_TEST

START_TEST(negative_values_become_zero_and_are_counted) {
    NphContext *context = nph_test_context(1);
    NphImage image = image_of(context, "RGB");
    NphEnvironment map;
    image.channels[0].pixels[1] = -1.0f;
    image.channels[2].pixels[5] = -1e-30f;
    ck_assert_int_eq(nph_environment_build(context, &image, unit, "sky.exr", &map), NPH_OK);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "sky.exr: 2 negative values are taken as 0"));
    ck_assert(map.radiance[3] == 0.0f && map.radiance[4] == 0.5f && map.radiance[17] == 0.0f);
    nph_environment_free(context, &map);
    nph_environment_free(context, &map); /* an empty one may be freed */
    nph_image_free(context, &image);
    nph_test_context_close(context);
}
END_TEST

START_TEST(grey_image_is_scaled_per_channel) {
    NphContext *context = nph_test_context(1);
    NphImage image = image_of(context, "AY");
    NphEnvironment map;
    ck_assert_int_eq(nph_environment_build(context, &image, (double[]){2.0, 4.0, 0.0}, "sky.exr", &map), NPH_OK);
    for (int i = 0; i < 6; i++)
        ck_assert(map.radiance[3 * i] == 1.0f && map.radiance[3 * i + 1] == 2.0f && map.radiance[3 * i + 2] == 0.0f);
    ck_assert(fabs(map.total / ((0.2126 + 2.0 * 0.7152) * 12.566370614359173) - 1.0) < 1e-14);
    nph_environment_free(context, &map);
    nph_image_free(context, &image);
    nph_test_context_close(context);
}
END_TEST

START_TEST(tables_rise_from_zero_to_one) {
    NphContext *context = nph_test_context(1);
    NphImage image = image_of(context, "RGB");
    NphEnvironment map;
    for (int c = 0; c < 3; c++) {
        float *pixels = image.channels[c].pixels;
        pixels[2] = 0.0f;                         /* the last of row 0 is black: no width */
        pixels[3] = pixels[4] = pixels[5] = 0.0f; /* row 1 is black */
    }
    ck_assert_int_eq(nph_environment_build(context, &image, unit, "sky.exr", &map), NPH_OK);
    ck_assert(map.row_cdf[0] == 0.0 && map.row_cdf[1] == 1.0 && map.row_cdf[2] == 1.0);
    ck_assert(map.column_cdf[0] == 0.0 && map.column_cdf[1] == 0.5);
    ck_assert(map.column_cdf[2] == 1.0 && map.column_cdf[3] == 1.0);
    ck_assert(map.column_cdf[4] == 0.0 && fabs(map.column_cdf[5] - 1.0 / 3.0) < 1e-15 && map.column_cdf[7] == 1.0);
    nph_environment_free(context, &map);
    nph_image_free(context, &image);
    nph_test_context_close(context);
}
END_TEST

START_TEST(every_allocation_may_fail) {
    for (uint64_t fail = 1; fail < 60; fail++) {
        NphSettings settings;
        nph_settings_default(&settings);
        settings.threads = 1;
        NphContext *plain = nph_test_context(1), *context = NULL;
        NphImage image = image_of(plain, "RGB");
        NphEnvironment map = {0};
        settings.fail_allocation = fail;
        ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
        NphStatus status = nph_environment_build(context, &image, unit, "sky.exr", &map);
        ck_assert_int_eq(status, fail <= 5 ? NPH_NO_MEMORY : NPH_OK);
        if (status != NPH_OK) ck_assert(!map.radiance && !map.row_cdf && !map.column_cdf);
        nph_environment_free(context, &map);
        nph_image_free(plain, &image);
        nph_test_context_close(context);
        nph_test_context_close(plain);
    }
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, mistakes_are_refused_by_name_and_place);
    tcase_add_test(cases, negative_values_become_zero_and_are_counted);
    tcase_add_test(cases, grey_image_is_scaled_per_channel);
    tcase_add_test(cases, tables_rise_from_zero_to_one);
    tcase_add_test(cases, every_allocation_may_fail);
}

int main(void) { return nph_test_main("environment_build", fill); }
