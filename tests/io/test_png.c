/* SPDX-License-Identifier: Apache-2.0
 *
 * PNG previews: read back with libpng's simple reader, chunk by chunk, and on a full disk. */
#define _POSIX_C_SOURCE 200809L
#include <png.h>
#include <signal.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "core/memory.h"
#include "harness.h"
#include "io/file.h"
#include "io/volume.h"

enum { MAX_PIXELS = 1 << 16 };

static uint8_t pixels[MAX_PIXELS * 3], again[MAX_PIXELS * 3];

/* A gradient in red and green, noise in blue: both runs and literals for the compressor. */
static void make(int width, int height) {
    uint32_t random = 1;
    for (int i = 0; i < width * height; i++) {
        random = random * 1664525u + 1013904223u;
        pixels[3 * i] = (uint8_t)(i % width * 255 / width);
        pixels[3 * i + 1] = (uint8_t)(i / width * 255 / height);
        pixels[3 * i + 2] = (uint8_t)(random >> 24);
    }
}

START_TEST(pixels_come_back_for_every_size) {
    static const int sizes[][2] = {{1, 1}, {1, 300}, {300, 1}, {17, 31}, {256, 128}};
    NphContext *context = nph_test_context(1);
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        const char *path = nph_test_temporary("a.png");
        make(sizes[i][0], sizes[i][1]);
        ck_assert_int_eq(nph_png_write(context, path, sizes[i][0], sizes[i][1], pixels), NPH_OK);
        png_image image = {.version = PNG_IMAGE_VERSION};
        ck_assert(png_image_begin_read_from_file(&image, path));
        ck_assert_uint_eq(image.width, sizes[i][0]);
        ck_assert_uint_eq(image.height, sizes[i][1]);
        ck_assert_uint_eq(image.format, PNG_FORMAT_RGB);
        ck_assert_uint_eq(image.flags & PNG_IMAGE_FLAG_COLORSPACE_NOT_sRGB, 0);
        ck_assert(png_image_finish_read(&image, NULL, again, 0, NULL));
        ck_assert_mem_eq(again, pixels, (size_t)sizes[i][0] * (size_t)sizes[i][1] * 3);
    }
    ck_assert_str_eq(nph_test_messages(), "");
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_picture_holds_header_srgb_and_pixels_only_and_is_the_same_each_time) {
    NphContext *context = nph_test_context(1);
    char *bytes[2];
    size_t sizes[2];
    make(256, 128);
    for (int i = 0; i < 2; i++) {
        const char *path = nph_test_temporary(i ? "one.png" : "two.png");
        ck_assert_int_eq(nph_png_write(context, path, 256, 128, pixels), NPH_OK);
        ck_assert_int_eq(nph_file_read(context, path, &bytes[i], &sizes[i]), NPH_OK);
    }
    ck_assert_uint_eq(sizes[0], sizes[1]);
    ck_assert_mem_eq(bytes[0], bytes[1], sizes[0]);
    char names[200] = "";
    for (size_t at = 8; at + 8 <= sizes[0] && strlen(names) < 150;) {
        const unsigned char *b = (const unsigned char *)bytes[0] + at;
        char name[6] = {' ', (char)b[4], (char)b[5], (char)b[6], (char)b[7], 0};
        if (strcmp(name, " IDAT") != 0 || !strstr(names, " IDAT")) strcat(names, name);
        at += 12 + ((size_t)b[0] << 24 | (size_t)b[1] << 16 | (size_t)b[2] << 8 | (size_t)b[3]);
    }
    ck_assert_str_eq(names, " IHDR sRGB IDAT IEND");
    nph_free(context, bytes[0]);
    nph_free(context, bytes[1]);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_full_disk_and_bad_targets_are_reported) {
    NphContext *context = nph_test_context(1);
    char path[600];
    strcpy(path, nph_test_temporary("full.png"));
    make(256, 256);
    ck_assert_int_eq(nph_png_write(context, "/nowhere/x.png", 2, 2, pixels), NPH_BAD_OUTPUT);
    ck_assert_int_eq(nph_png_write(context, path, 0, 2, pixels), NPH_BAD_USAGE);
    ck_assert_int_eq(nph_png_write(context, path, 2, -2, pixels), NPH_BAD_USAGE);
    nph_test_messages();
    signal(SIGXFSZ, SIG_IGN);
    for (rlim_t limit = 0; limit < 50000; limit += 7000) {
        struct rlimit files = {limit, RLIM_INFINITY};
        ck_assert_int_eq(setrlimit(RLIMIT_FSIZE, &files), 0);
        ck_assert_int_eq(nph_png_write(context, path, 256, 256, pixels), NPH_BAD_OUTPUT);
        const char *messages = nph_test_messages();
        ck_assert_msg(strstr(messages, path) && strstr(messages, "File too large"), "%s", messages);
        ck_assert_int_ne(access(path, F_OK), 0);
    }
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, pixels_come_back_for_every_size);
    tcase_add_test(cases, a_picture_holds_header_srgb_and_pixels_only_and_is_the_same_each_time);
    tcase_add_test(cases, a_full_disk_and_bad_targets_are_reported);
}

int main(void) { return nph_test_main("png", fill); }
