/* SPDX-License-Identifier: Apache-2.0
 *
 * Damaged OpenEXR files: cut at many lengths, bits flipped, garbage, and allocations that fail. Nothing crashes, hangs or
 * leaks; what is refused names the file. (Run under the sanitizers as well: their build is where reading out of bounds
 * would show.) */
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "harness.h"
#include "io/file.h"
#include "nephos/image.h"

static const char *const sources[] = {"float_none", "float_piz",  "float_pxr24",     "float_zip", "half_none",
                                      "half_piz",   "half_pxr24", "half_rle",        "half_zip",  "half_zips",
                                      "half_b44",   "half_b44a",  "half_zip_tiled32"};
enum { SOURCES = sizeof sources / sizeof *sources };

typedef struct Case {
    NphContext *context;
    char path[600];
    char *bytes;
    size_t size;
} Case;

static void open_source(Case *c, int which) {
    char relative[200];
    snprintf(relative, sizeof relative, "reference/data/env/exr_variants/sunset256_%s.exr", sources[which]);
    c->context = nph_test_context(1);
    snprintf(c->path, sizeof c->path, "%s", nph_test_temporary("hostile.exr"));
    ck_assert_int_eq(nph_file_read(c->context, nph_test_path(relative), &c->bytes, &c->size), NPH_OK);
}

static void close_source(Case *c) {
    nph_free(c->context, c->bytes);
    nph_test_context_close(c->context);
}

static NphStatus read_bytes(Case *c, const char *bytes, size_t size) {
    FILE *file = fopen(c->path, "wb");
    ck_assert_ptr_nonnull(file);
    ck_assert_uint_eq(fwrite(bytes, 1, size, file), size);
    ck_assert_int_eq(fclose(file), 0);
    uint64_t before = nph_context_bytes(c->context);
    NphImage image = {0};
    NphStatus status = nph_exr_read(c->context, c->path, &image);
    const char *messages = nph_test_messages();
    if (status == NPH_OK)
        nph_image_free(c->context, &image);
    else {
        ck_assert_msg(status == NPH_BAD_INPUT, "status %d: %s", status, messages);
        ck_assert_msg(strstr(messages, c->path) != NULL, "no path in: %s", messages);
        ck_assert_ptr_null(image.channels);
    }
    ck_assert_uint_eq(nph_context_bytes(c->context), before);
    return status;
}

START_TEST(a_file_cut_anywhere_is_refused) {
    for (int which = 0; which < SOURCES; which++) {
        Case c;
        open_source(&c, which);
        for (size_t size = which ? 64 : 0; size < c.size; size += size < 64 ? 1 : size < 2000 ? 61 : c.size / 16)
            ck_assert_msg(read_bytes(&c, c.bytes, size) == NPH_BAD_INPUT, "%s cut to %zu of %zu bytes is read",
                          sources[which], size, c.size);
        ck_assert_int_eq(read_bytes(&c, c.bytes, c.size - 1), NPH_BAD_INPUT);
        ck_assert_int_eq(read_bytes(&c, c.bytes, c.size), NPH_OK);
        close_source(&c);
    }
}
END_TEST

static uint32_t next_random(uint32_t *state) {
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

/* A third of the flips fall into header and chunk table. NPH_TEST_FLIPS multiplies their number. */
START_TEST(flipped_bits_are_refused_or_decode_to_something) {
    uint32_t random = 20260101u;
    const char *more = getenv("NPH_TEST_FLIPS");
    int files = 26 * (more ? atoi(more) : 1), refused = 0, read = 0;
    for (int which = 0; which < SOURCES; which++) {
        Case c;
        open_source(&c, which);
        char *damaged = NULL;
        ck_assert_int_eq(NPH_NEW(c.context, c.size, "damaged file", &damaged), NPH_OK);
        for (int i = 0; i < files; i++) {
            memcpy(damaged, c.bytes, c.size);
            int flips = 1 + (int)(next_random(&random) % 4);
            for (int flip = 0; flip < flips; flip++) {
                size_t room = i % 3 == 0 ? 1400 : c.size;
                damaged[next_random(&random) % room] ^= (char)(1 << next_random(&random) % 8);
            }
            if (read_bytes(&c, damaged, c.size) == NPH_OK)
                read++;
            else
                refused++;
        }
        nph_free(c.context, damaged);
        close_source(&c);
    }
    ck_assert_int_gt(refused, SOURCES * files / 10);
    ck_assert_int_gt(read, SOURCES * files / 10);
}
END_TEST

START_TEST(garbage_with_or_without_the_magic_is_refused) {
    uint32_t random = 7;
    Case c;
    open_source(&c, 0);
    for (int i = 0; i < 60; i++) {
        char bytes[3000];
        for (size_t k = 0; k < sizeof bytes; k++) bytes[k] = (char)(next_random(&random) & 255);
        if (i % 2) memcpy(bytes, c.bytes, i % 4 == 1 ? 8 : 300);
        ck_assert_int_eq(read_bytes(&c, bytes, sizeof bytes - (size_t)i * 40), NPH_BAD_INPUT);
    }
    close_source(&c);
}
END_TEST

START_TEST(a_chunk_that_is_empty_or_belongs_elsewhere_is_refused) {
    static const int kinds[] = {0, 8, 12}; /* float_none, half_zip, tiled: the table's last offset leads to a chunk */
    for (int k = 0; k < 3; k++) {
        Case c;
        open_source(&c, kinds[k]);
        /* A chunk's head ends with its size, which is found as the distance to the end of the file. */
        int fields = kinds[k] == 12 ? 5 : 2, found = 0;
        for (size_t at = 1000; at + 4 <= c.size && !found; at++) {
            unsigned char *b = (unsigned char *)c.bytes + at;
            size_t size = b[0] | (size_t)b[1] << 8 | (size_t)b[2] << 16 | (size_t)b[3] << 24;
            if (size == 0 || at + 4 + size != c.size) continue;
            found = 1;
            memset(b, 0, 4);
            ck_assert_int_eq(read_bytes(&c, c.bytes, c.size), NPH_BAD_INPUT);
            b[0] = 5; /* five bytes of a compressed chunk, or an uncompressed one that is too short */
            ck_assert_int_eq(read_bytes(&c, c.bytes, c.size), NPH_BAD_INPUT);
            memset(b, 0xff, 4);
            ck_assert_int_eq(read_bytes(&c, c.bytes, c.size), NPH_BAD_INPUT);
            b[0] = (unsigned char)(size & 255), b[1] = (unsigned char)(size >> 8 & 255);
            b[2] = (unsigned char)(size >> 16 & 255), b[3] = 0;
            ck_assert_int_eq(read_bytes(&c, c.bytes, c.size), NPH_OK);
            b[4 - 4 * fields] ^= 1; /* its line or tile */
            ck_assert_int_eq(read_bytes(&c, c.bytes, c.size), NPH_BAD_INPUT);
        }
        ck_assert(found);
        close_source(&c);
    }
}
END_TEST

START_TEST(every_failing_allocation_is_reported_and_nothing_leaks) {
    int failures = 0;
    for (uint64_t nth = 1;; nth++) {
        NphSettings settings;
        nph_settings_default(&settings);
        settings.threads = 1;
        settings.fail_allocation = nth;
        NphContext *context = NULL;
        ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
        NphImage image = {0};
        NphStatus status =
            nph_exr_read(context, nph_test_path("reference/data/env/exr_variants/sunset256_half_zip.exr"), &image);
        if (status == NPH_OK) status = nph_exr_write(context, nph_test_temporary("copy.exr"), &image);
        nph_image_free(context, &image);
        nph_test_context_close(context);
        if (status == NPH_OK) break;
        ck_assert_int_eq(status, NPH_NO_MEMORY);
        failures++;
    }
    ck_assert_int_gt(failures, 15);
}
END_TEST

START_TEST(the_memory_limit_holds_for_the_planes) {
    NphSettings settings;
    nph_settings_default(&settings);
    settings.threads = 1;
    settings.memory_limit_bytes = 400000; /* file and two of three planes of 131072 bytes */
    NphContext *context = NULL;
    ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
    NphImage image = {0};
    ck_assert_int_eq(
        nph_exr_read(context, nph_test_path("reference/data/env/exr_variants/sunset256_half_zip.exr"), &image),
        NPH_NO_MEMORY);
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, a_file_cut_anywhere_is_refused);
    tcase_add_test(cases, flipped_bits_are_refused_or_decode_to_something);
    tcase_add_test(cases, garbage_with_or_without_the_magic_is_refused);
    tcase_add_test(cases, a_chunk_that_is_empty_or_belongs_elsewhere_is_refused);
    tcase_add_test(cases, every_failing_allocation_is_reported_and_nothing_leaks);
    tcase_add_test(cases, the_memory_limit_holds_for_the_planes);
}

int main(void) { return nph_test_main("exr_hostile", fill); }
