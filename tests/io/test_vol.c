/* SPDX-License-Identifier: Apache-2.0
 *
 * Mitsuba grid volumes byte by byte: what is written is what the format says, what is read is what was written, and
 * what is damaged is refused at its byte. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "harness.h"
#include "io/file.h"
#include "io/volume.h"

enum { HEADER = 48 };

static void store(unsigned char *at, uint32_t word) {
    for (int i = 0; i < 4; i++) at[i] = (unsigned char)(word >> (8 * i));
}

static void store_float(unsigned char *at, float value) {
    uint32_t word;
    memcpy(&word, &value, 4);
    store(at, word);
}

/* 2 x 3 x 4 voxels, value = index in the file, box (-1, 0, 2) to (1, 3, 6). */
static size_t sample(unsigned char *bytes, uint32_t channels) {
    static const float box[6] = {-1, 0, 2, 1, 3, 6};
    memcpy(bytes, "VOL\3", 4);
    store(bytes + 4, 1);
    for (uint32_t axis = 0; axis < 3; axis++) store(bytes + 8 + 4 * axis, 2 + axis);
    store(bytes + 20, channels);
    for (int i = 0; i < 6; i++) store_float(bytes + 24 + 4 * i, box[i]);
    for (uint32_t i = 0; i < 24 * channels; i++) store_float(bytes + HEADER + 4 * i, (float)i);
    return HEADER + 96 * channels;
}

static const char *write_bytes(const void *bytes, size_t size) {
    const char *path = nph_test_temporary("file.vol");
    FILE *file = fopen(path, "wb");
    ck_assert_ptr_nonnull(file);
    ck_assert_uint_eq(fwrite(bytes, 1, size, file), size);
    ck_assert_int_eq(fclose(file), 0);
    return path;
}

START_TEST(x_is_the_fastest_axis_and_the_box_comes_from_the_file) {
    NphContext *context = nph_test_context(1);
    unsigned char bytes[400];
    NphBoxGrid grid = {0};
    ck_assert_int_eq(nph_vol_read(context, write_bytes(bytes, sample(bytes, 1)), &grid), NPH_OK);
    static const int64_t shape[3] = {4, 3, 2};
    static const double lo[3] = {-1, 0, 2}, hi[3] = {1, 3, 6};
    ck_assert_int_eq(grid.values.type, NPH_F32);
    ck_assert_int_eq(grid.values.rank, 3);
    ck_assert_mem_eq(grid.values.shape, shape, sizeof shape);
    ck_assert_mem_eq(grid.lo, lo, sizeof lo);
    ck_assert_mem_eq(grid.hi, hi, sizeof hi);
    for (int i = 0; i < 24; i++) ck_assert(((float *)grid.values.data)[i] == (float)i);
    nph_box_grid_free(context, &grid);
    nph_test_context_close(context);
}
END_TEST

START_TEST(three_channels_become_a_last_axis) {
    NphContext *context = nph_test_context(1);
    unsigned char bytes[400];
    NphBoxGrid grid = {0};
    ck_assert_int_eq(nph_vol_read(context, write_bytes(bytes, sample(bytes, 3)), &grid), NPH_OK);
    ck_assert_int_eq(grid.values.rank, 4);
    ck_assert_int_eq(grid.values.shape[3], 3);
    ck_assert(((float *)grid.values.data)[((1 * 3 + 2) * 2 + 1) * 3 + 2] == (float)(((1 * 3 + 2) * 2 + 1) * 3 + 2));
    nph_box_grid_free(context, &grid);
    nph_test_context_close(context);
}
END_TEST

START_TEST(what_is_written_is_the_format_byte_for_byte) {
    NphContext *context = nph_test_context(1);
    unsigned char bytes[400];
    for (uint32_t channels = 1; channels <= 3; channels += 2) {
        size_t size = sample(bytes, channels), got = 0;
        NphBoxGrid grid = {0};
        char *written = NULL;
        ck_assert_int_eq(nph_vol_read(context, write_bytes(bytes, size), &grid), NPH_OK);
        const char *path = nph_test_temporary("again.vol");
        ck_assert_int_eq(nph_vol_write(context, path, &grid), NPH_OK);
        ck_assert_int_eq(nph_file_read(context, path, &written, &got), NPH_OK);
        ck_assert_uint_eq(got, size);
        ck_assert_mem_eq(written, bytes, size);
        nph_free(context, written);
        nph_box_grid_free(context, &grid);
    }
    nph_test_context_close(context);
}
END_TEST

/* More than a buffer's worth, with values whose bits a conversion could lose. */
START_TEST(values_survive_bit_for_bit) {
    NphContext *context = nph_test_context(1);
    static const int64_t shape[3] = {17, 11, 23};
    NphBoxGrid grid = {.lo = {0.1, -1e30, 5}, .hi = {0.2, 1e30, 5.5}}, back = {0};
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 3, shape, "test", &grid.values), NPH_OK);
    uint32_t *words = grid.values.data, state = 1;
    for (int i = 0; i < 17 * 11 * 23; i++) words[i] = state = state * 1664525u + 1013904223u; /* NaNs among them */
    const char *path = nph_test_temporary("bits.vol");
    ck_assert_int_eq(nph_vol_write(context, path, &grid), NPH_OK);
    ck_assert_int_eq(nph_vol_read(context, path, &back), NPH_OK);
    ck_assert_mem_eq(back.values.data, grid.values.data, 17 * 11 * 23 * 4);
    for (int axis = 0; axis < 3; axis++) {
        ck_assert(back.lo[axis] == (double)(float)grid.lo[axis]);
        ck_assert(back.hi[axis] == (double)(float)grid.hi[axis]);
    }
    nph_box_grid_free(context, &grid);
    nph_box_grid_free(context, &back);
    nph_test_context_close(context);
}
END_TEST

static void refused(NphContext *context, const void *bytes, size_t size, const char *word) {
    NphBoxGrid grid = {.lo = {7, 7, 7}};
    ck_assert_int_eq(nph_vol_read(context, write_bytes(bytes, size), &grid), NPH_BAD_INPUT);
    ck_assert(grid.lo[0] == 7);
    const char *messages = nph_test_messages();
    ck_assert_msg(strstr(messages, "file.vol") && strstr(messages, word), "no '%s' in: %s", word, messages);
}

START_TEST(every_length_but_the_right_one_is_refused) {
    NphContext *context = nph_test_context(1);
    unsigned char bytes[400] = {0};
    size_t size = sample(bytes, 1);
    refused(context, bytes, 0, "is empty");
    for (size_t cut = 1; cut < size; cut++) refused(context, bytes, cut, cut < 3 ? "VOL" : cut < HEADER ? "cut" : "fill");
    refused(context, bytes, size + 1, "fill");
    refused(context, bytes, size + 4, "fill");
    nph_test_context_close(context);
}
END_TEST

START_TEST(headers_that_lie_are_refused_at_their_byte) {
    static const struct {
        int at;
        uint32_t word;
        const char *message;
    } lies[] = {
        {0, 0x044c4f56, "byte 3: version 4"},       {4, 2, "type 2 (float16)"},       {4, 99, "type 99 (unknown)"},
        {8, 0, "size along x is 0"},                {12, 0xffffffff, "along y is -1"}, {16, 0x7fffffff, "does not fill"},
        {20, 0, "0 channels"},                      {20, 2, "2 channels"},             {20, 6, "6 channels"},
        {24, 0x7fc00000, "box from nan"},           {24, 0x40000000, "box from 2 to 1"}, {40, 0x7f800000, "to inf"},
        {8, 0x40000000, "does not fill"},
    };
    NphContext *context = nph_test_context(1);
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++) {
        unsigned char bytes[400];
        size_t size = sample(bytes, 1);
        store(bytes + lies[i].at, lies[i].word);
        refused(context, bytes, size, lies[i].message);
    }
    /* sizes whose product wraps around to what is there: 2^31 - 1, 2^31 - 1 and a rest */
    unsigned char bytes[400];
    size_t size = sample(bytes, 1);
    for (int axis = 0; axis < 3; axis++) store(bytes + 8 + 4 * axis, 0x7fffffff);
    refused(context, bytes, size, "does not fill");
    ck_assert_uint_lt(nph_context_peak_bytes(context), 1u << 16);
    nph_test_context_close(context);
}
END_TEST

START_TEST(every_flipped_bit_of_the_header_is_refused_or_read_soundly) {
    NphContext *context = nph_test_context(1);
    unsigned char bytes[400];
    size_t size = sample(bytes, 1);
    int taken = 0;
    for (int bit = 0; bit < 8 * HEADER; bit++) {
        NphBoxGrid grid = {0};
        bytes[bit / 8] ^= (unsigned char)(1 << bit % 8);
        NphStatus status = nph_vol_read(context, write_bytes(bytes, size), &grid);
        bytes[bit / 8] ^= (unsigned char)(1 << bit % 8);
        ck_assert(status == NPH_OK || status == NPH_BAD_INPUT);
        ck_assert(status != NPH_OK || bit >= 8 * 24); /* only the box can change unseen */
        taken += status == NPH_OK;
        nph_box_grid_free(context, &grid);
    }
    ck_assert_int_gt(taken, 0);
    nph_test_messages();
    nph_test_context_close(context);
}
END_TEST

START_TEST(the_writer_refuses_what_the_format_cannot_hold) {
    NphContext *context = nph_test_context(1);
    static const int64_t shape[4] = {2, 2, 2, 2};
    static const double his[] = {0, NAN, 1e39, -1, 1e-50};
    const char *path = nph_test_temporary("no.vol");
    NphBoxGrid grid = {.hi = {1, 1, 1}};
    ck_assert_int_eq(nph_array_new(context, NPH_F64, 3, shape, "test", &grid.values), NPH_OK);
    ck_assert_int_eq(nph_vol_write(context, path, &grid), NPH_BAD_USAGE);
    nph_array_free(context, &grid.values);
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 4, shape, "test", &grid.values), NPH_OK);
    ck_assert_int_eq(nph_vol_write(context, path, &grid), NPH_BAD_USAGE);
    nph_array_free(context, &grid.values);
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 3, shape, "test", &grid.values), NPH_OK);
    for (int i = 0; i < 5; i++) {
        grid.hi[1] = his[i];
        ck_assert_int_eq(nph_vol_write(context, path, &grid), NPH_BAD_USAGE);
    }
    grid.hi[1] = 1;
    ck_assert_int_eq(nph_vol_write(context, "/nowhere/at/all.vol", &grid), NPH_BAD_OUTPUT);
    FILE *file = fopen(path, "rb");
    ck_assert_ptr_null(file);
    nph_box_grid_free(context, &grid);
    nph_test_messages();
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, x_is_the_fastest_axis_and_the_box_comes_from_the_file);
    tcase_add_test(cases, three_channels_become_a_last_axis);
    tcase_add_test(cases, what_is_written_is_the_format_byte_for_byte);
    tcase_add_test(cases, values_survive_bit_for_bit);
    tcase_add_test(cases, every_length_but_the_right_one_is_refused);
    tcase_add_test(cases, headers_that_lie_are_refused_at_their_byte);
    tcase_add_test(cases, every_flipped_bit_of_the_header_is_refused_or_read_soundly);
    tcase_add_test(cases, the_writer_refuses_what_the_format_cannot_hold);
}

int main(void) { return nph_test_main("vol", fill); }
