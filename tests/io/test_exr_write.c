/* SPDX-License-Identifier: Apache-2.0
 *
 * What nph_exr_write makes: read back to the bit, the same bytes each time, nothing but a whole file. */
#define _POSIX_C_SOURCE 200809L
#include <dirent.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include "core/memory.h"
#include "harness.h"
#include "io/file.h"
#include "io/half.h"
#include "nephos/image.h"

static uint32_t bits_of(float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static float float_of(uint32_t bits) {
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* Every kind of float: zeros, subnormals, infinities, NaN with payload; then a hash. */
static void fill_plane(float *pixels, size_t count, uint32_t seed) {
    static const uint32_t special[] = {0x80000000u, 0,           1u,          0x807fffffu, 0x7f800000u, 0xff800000u,
                                       0x7fc12345u, 0x7f800001u, 0x7f7fffffu, 0x00800000u, 0x3f800001u, 0xbf800000u};
    for (size_t i = 0; i < count; i++) {
        uint32_t word = (uint32_t)(i + seed) * 2654435761u;
        word ^= word >> 15;
        pixels[i] = i < sizeof special / sizeof *special ? float_of(special[i]) : (float)(word >> 8) * 0x1p-20f;
    }
}

static const char *const names[] = {
    "R",          "G",     "B", "A", "Variance.R", "Variance.G",
    "Variance.B", "Vov.R", "N", "Z", "Order.Y",    "a layer whose name is longer than thirty-one bytes.Y"};
enum { NAMES = sizeof names / sizeof *names };

static void make(NphContext *context, int width, int height, int reversed, NphImage *image) {
    ck_assert_int_eq(nph_image_new(context, width, height, image), NPH_OK);
    for (int i = 0; i < NAMES; i++) {
        int which = reversed ? NAMES - 1 - i : i;
        float *pixels = NULL;
        ck_assert_int_eq(nph_image_add_channel(context, image, names[which], &pixels), NPH_OK);
        fill_plane(pixels, (size_t)width * (size_t)height, (uint32_t)which);
    }
    ck_assert_int_eq(nph_image_set_text(context, image, "nephos:scene", "a\nscene, \xc3\xa9"), NPH_OK);
    ck_assert_int_eq(nph_image_set_text(context, image, "empty", ""), NPH_OK);
    ck_assert_int_eq(nph_image_set_number(context, image, "seed", NPH_ATTRIBUTE_INT, -2147483648.0), NPH_OK);
    ck_assert_int_eq(nph_image_set_number(context, image, "gain", NPH_ATTRIBUTE_FLOAT, 0.1), NPH_OK);
    ck_assert_int_eq(nph_image_set_number(context, image, "samples", NPH_ATTRIBUTE_DOUBLE, 0.1), NPH_OK);
    ck_assert_int_eq(nph_image_set_number(context, image, "an attribute's name of more than thirty-one bytes",
                                          NPH_ATTRIBUTE_DOUBLE, 1e300),
                     NPH_OK);
}

static void check_same(const NphImage *a, const NphImage *b) {
    ck_assert_int_eq(a->width, b->width);
    ck_assert_int_eq(a->height, b->height);
    ck_assert_int_eq(a->x0, b->x0);
    ck_assert_int_eq(a->y0, b->y0);
    ck_assert_int_eq(a->full_width, b->full_width);
    ck_assert_int_eq(a->full_height, b->full_height);
    ck_assert_int_eq(a->channel_count, b->channel_count);
    for (int i = 0; i < a->channel_count; i++) {
        const NphChannel *other = nph_image_channel(b, a->channels[i].name);
        ck_assert_ptr_nonnull(other);
        ck_assert_int_eq(a->channels[i].was_half, other->was_half);
        ck_assert_int_eq(a->channels[i].was_uint, other->was_uint);
        ck_assert_mem_eq(a->channels[i].pixels, other->pixels, sizeof(float) * (size_t)a->width * (size_t)a->height);
    }
    ck_assert_int_eq(a->attribute_count, b->attribute_count);
    for (int i = 0; i < a->attribute_count; i++) {
        const NphAttribute *other = nph_image_attribute(b, a->attributes[i].name);
        ck_assert_ptr_nonnull(other);
        ck_assert_int_eq(a->attributes[i].type, other->type);
        ck_assert_double_eq(a->attributes[i].number, other->number);
        if (a->attributes[i].text) ck_assert_str_eq(a->attributes[i].text, other->text);
    }
}

static NphStatus write_and_read(NphContext *context, const NphImage *image, NphImage *again) {
    const char *path = nph_test_temporary("again.exr");
    NphStatus status = nph_exr_write(context, path, image);
    return status == NPH_OK ? nph_exr_read(context, path, again) : status;
}

START_TEST(channels_attributes_and_windows_come_back_to_the_bit) {
    static const int sizes[][2] = {{1, 1}, {1, 37}, {37, 1}, {16, 16}, {17, 15}, {33, 49}, {500, 3}};
    NphContext *context = nph_test_context(1);
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++)
        for (int shift = 0; shift < 3; shift++) {
            NphImage image = {0}, again = {0};
            make(context, sizes[i][0], sizes[i][1], 0, &image);
            image.x0 = shift * -7;
            image.y0 = shift * 1000;
            image.full_width += shift * 50;
            image.full_height += shift;
            ck_assert_int_eq(write_and_read(context, &image, &again), NPH_OK);
            check_same(&image, &again);
            nph_image_free(context, &again);
            nph_image_free(context, &image);
        }
    ck_assert_str_eq(nph_test_messages(), "");
    nph_test_context_close(context);
}
END_TEST

static void read_whole(NphContext *context, const char *path, char **bytes, size_t *size) {
    ck_assert_int_eq(nph_file_read(context, path, bytes, size), NPH_OK);
}

START_TEST(equal_images_are_equal_bytes_whatever_order_their_channels_were_added_in) {
    NphContext *context = nph_test_context(1);
    const char *paths[3] = {nph_test_temporary("a.exr"), nph_test_temporary("b.exr"), nph_test_temporary("c.exr")};
    char *bytes[3];
    size_t sizes[3];
    for (int i = 0; i < 3; i++) {
        NphImage image = {0};
        make(context, 61, 47, i == 2, &image);
        ck_assert_int_eq(nph_exr_write(context, paths[i], &image), NPH_OK);
        nph_image_free(context, &image);
        read_whole(context, paths[i], &bytes[i], &sizes[i]);
        ck_assert_uint_eq(sizes[i], sizes[0]);
        ck_assert_mem_eq(bytes[i], bytes[0], sizes[0]);
    }
    for (int i = 0; i < 3; i++) nph_free(context, bytes[i]);
    nph_test_context_close(context);
}
END_TEST

/* Chunks of 16 lines of noise, each with a few zeros more than the last, so that deflate's result passes through the
 * chunk's own size, at which the file says no more whether it is deflated. */
START_TEST(noise_that_deflates_to_about_its_own_size_comes_back) {
    NphContext *context = nph_test_context(1);
    NphImage image = {0}, again = {0};
    enum { WIDTH = 7, CHUNK = 16 * WIDTH, CHUNKS = 800 };
    float *pixels = NULL;
    uint32_t random = 3;
    ck_assert_int_eq(nph_image_new(context, WIDTH, 16 * CHUNKS, &image), NPH_OK);
    ck_assert_int_eq(nph_image_add_channel(context, &image, "Y", &pixels), NPH_OK);
    for (int i = 0; i < CHUNK * CHUNKS; i++) {
        uint32_t bytes = 0;
        for (int k = 0; k < 4; k++) {
            random = random * 1664525u + 1013904223u;
            bytes = bytes << 8 | random >> 24;
        }
        pixels[i] = i % CHUNK < i / CHUNK % 20 ? 0 : float_of(bytes);
    }
    ck_assert_int_eq(write_and_read(context, &image, &again), NPH_OK);
    check_same(&image, &again);
    nph_image_free(context, &again);
    nph_image_free(context, &image);
    nph_test_context_close(context);
}
END_TEST

START_TEST(half_and_integer_channels_keep_their_type_and_value) {
    NphContext *context = nph_test_context(1);
    NphImage image = {0}, again = {0};
    float *half = NULL, *whole = NULL;
    ck_assert_int_eq(nph_image_new(context, 256, 256, &image), NPH_OK);
    ck_assert_int_eq(nph_image_add_channel(context, &image, "half", &half), NPH_OK);
    ck_assert_int_eq(nph_image_add_channel(context, &image, "whole", &whole), NPH_OK);
    image.channels[0].was_half = 1;
    image.channels[1].was_uint = 1;
    for (uint32_t i = 0; i < 65536; i++) {
        half[i] = nph_float_from_half((uint16_t)i);
        whole[i] = (float)(i << 8);
    }
    ck_assert_int_eq(write_and_read(context, &image, &again), NPH_OK);
    ck_assert_str_eq(nph_test_messages(), "");
    check_same(&image, &again);
    nph_image_free(context, &again);
    half[0] = 65520;
    half[1] = HUGE_VALF; /* infinite before: not counted */
    whole[2] = -1;
    whole[3] = 4294967296.0f;
    whole[4] = NAN;
    ck_assert_int_eq(write_and_read(context, &image, &again), NPH_OK);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "4 values are outside"));
    ck_assert_uint_eq(bits_of(again.channels[0].pixels[0]), 0x7f800000u);
    ck_assert_float_eq(again.channels[1].pixels[2], 0);
    ck_assert_float_eq(again.channels[1].pixels[3], 4294967296.0f); /* 2^32 - 1 as a float */
    ck_assert_float_eq(again.channels[1].pixels[4], 0);
    nph_image_free(context, &again);
    nph_image_free(context, &image);
    nph_test_context_close(context);
}
END_TEST

/* Halves between neighbours i and i + 1 of the positive ones: the midpoint goes to the even, its neighbours to theirs. */
START_TEST(half_rounds_to_nearest_even_and_is_exact_both_ways) {
    for (uint32_t i = 0; i < 65536; i++) ck_assert_uint_eq(nph_half_from_float(nph_float_from_half((uint16_t)i)), i);
    for (uint32_t i = 0; i < 0x7bff; i++) {
        float low = nph_float_from_half((uint16_t)i), high = nph_float_from_half((uint16_t)(i + 1));
        float middle = (low + high) / 2; /* exact: one bit more than a half */
        ck_assert_uint_eq(nph_half_from_float(middle), i + (i & 1));
        ck_assert_uint_eq(nph_half_from_float(nextafterf(middle, 0)), i);
        ck_assert_uint_eq(nph_half_from_float(nextafterf(middle, 1e9f)), i + 1);
        ck_assert_uint_eq(nph_half_from_float(-middle), 0x8000u + i + (i & 1));
    }
    ck_assert_float_eq(nph_float_from_half(0x3c01), 1 + 0x1p-10f);
    ck_assert_float_eq(nph_float_from_half(0x0001), 0x1p-24f);
    ck_assert_float_eq(nph_float_from_half(0x7bff), 65504);
    ck_assert_uint_eq(nph_half_from_float(65519.996f), 0x7bff);
    ck_assert_uint_eq(nph_half_from_float(65520), 0x7c00);
    ck_assert_uint_eq(nph_half_from_float(float_of(0x7f800001u)), 0x7e00);
}
END_TEST

static int temporaries(void) {
    char folder[600];
    strcpy(folder, nph_test_temporary(""));
    DIR *stream = opendir(folder);
    int count = 0;
    for (struct dirent *entry; (entry = readdir(stream));) count += strstr(entry->d_name, ".tmp") != NULL;
    closedir(stream);
    return count;
}

START_TEST(a_full_disk_at_any_point_is_reported_and_leaves_the_old_file) {
    NphContext *context = nph_test_context(1);
    NphImage image = {0};
    char path[600];
    strcpy(path, nph_test_temporary("full.exr"));
    char *old = NULL, *now = NULL;
    size_t old_size = 0, now_size = 0;
    make(context, 61, 47, 0, &image);
    ck_assert_int_eq(nph_exr_write(context, path, &image), NPH_OK);
    read_whole(context, path, &old, &old_size);
    signal(SIGXFSZ, SIG_IGN);
    for (size_t limit = 0; limit < old_size; limit += 1 + old_size / 40) {
        struct rlimit files = {limit, RLIM_INFINITY};
        ck_assert_int_eq(setrlimit(RLIMIT_FSIZE, &files), 0);
        ck_assert_int_eq(nph_exr_write(context, path, &image), NPH_BAD_OUTPUT);
        const char *messages = nph_test_messages();
        ck_assert_msg(strstr(messages, path) && strstr(messages, "File too large"), "%s", messages);
        ck_assert_msg(strchr(messages, '\n') == strrchr(messages, '\n'), "more than one message: %s", messages);
        ck_assert_int_eq(temporaries(), 0);
    }
    read_whole(context, path, &now, &now_size);
    ck_assert_uint_eq(now_size, old_size);
    ck_assert_mem_eq(now, old, old_size);
    nph_free(context, old);
    nph_free(context, now);
    nph_image_free(context, &image);
    nph_test_context_close(context);
}
END_TEST

START_TEST(what_cannot_be_written_is_refused) {
    NphContext *context = nph_test_context(1);
    NphImage image = {0};
    ck_assert_int_eq(nph_image_new(context, 4, 4, &image), NPH_OK);
    ck_assert_int_eq(nph_exr_write(context, nph_test_temporary("none.exr"), &image), NPH_BAD_USAGE);
    ck_assert_int_eq(nph_image_add_channel(context, &image, "R", NULL), NPH_OK);
    ck_assert_int_eq(nph_exr_write(context, "/nowhere/none.exr", &image), NPH_BAD_OUTPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "/nowhere/none.exr"));
    image.x0 = 1 << 30;
    ck_assert_int_eq(nph_exr_write(context, nph_test_temporary("none.exr"), &image), NPH_BAD_USAGE);
    image.x0 = 0;
    image.full_width = 0;
    ck_assert_int_eq(nph_exr_write(context, nph_test_temporary("none.exr"), &image), NPH_BAD_USAGE);
    ck_assert_int_eq(temporaries(), 0);
    nph_image_free(context, &image);
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, channels_attributes_and_windows_come_back_to_the_bit);
    tcase_add_test(cases, equal_images_are_equal_bytes_whatever_order_their_channels_were_added_in);
    tcase_add_test(cases, noise_that_deflates_to_about_its_own_size_comes_back);
    tcase_add_test(cases, half_and_integer_channels_keep_their_type_and_value);
    tcase_add_test(cases, half_rounds_to_nearest_even_and_is_exact_both_ways);
    tcase_add_test(cases, a_full_disk_at_any_point_is_reported_and_leaves_the_old_file);
    tcase_add_test(cases, what_cannot_be_written_is_refused);
}

int main(void) { return nph_test_main("exr_write", fill); }
