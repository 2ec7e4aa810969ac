/* SPDX-License-Identifier: Apache-2.0
 *
 * .npy files as NumPy 1.24 writes them (the headers below are its own), in every version, order and type; damaged ones;
 * and what is written, byte for byte. */
#define _POSIX_C_SOURCE 200809L
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "core/memory.h"
#include "harness.h"
#include "io/volume.h"

enum { FILE_MAX = 4096 };
static unsigned char file[FILE_MAX];

/* Magic, version, length, dictionary padded to 128 bytes in all, data. Returns the size. */
static size_t make(int major, const char *dictionary, const void *data, size_t bytes) {
    size_t start = major == 1 ? 10 : 12, length = 128 - start;
    memset(file, ' ', 128);
    memcpy(file, "\x93NUMPY", 6);
    file[6] = (unsigned char)major;
    file[7] = 0;
    file[8] = (unsigned char)length;
    file[9] = 0;
    if (major > 1) file[10] = file[11] = 0;
    memcpy(file + start, dictionary, strlen(dictionary));
    file[127] = '\n';
    memcpy(file + 128, data, bytes);
    return 128 + bytes;
}

static const char *store(size_t size) {
    const char *path = nph_test_temporary("array.npy");
    FILE *stream = fopen(path, "wb");
    ck_assert_ptr_nonnull(stream);
    ck_assert_uint_eq(fwrite(file, 1, size, stream), size);
    ck_assert_int_eq(fclose(stream), 0);
    return path;
}

static NphArray read_array(NphContext *context, size_t size) {
    NphArray array = {0};
    NphStatus status = nph_npy_read(context, store(size), &array);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    return array;
}

static void refused(size_t size, const char *words) {
    NphContext *context = nph_test_context(1);
    NphArray array = {.rank = -7};
    const char *path = store(size);
    ck_assert_int_eq(nph_npy_read(context, path, &array), NPH_BAD_INPUT);
    const char *messages = nph_test_messages();
    ck_assert_msg(strstr(messages, path) && strstr(messages, words), "no '%s' in: %s", words, messages);
    ck_assert_int_eq(array.rank, -7);
    nph_test_context_close(context);
}

static void refused_header(const char *dictionary, const char *words) { refused(make(1, dictionary, "", 0), words); }

static void is_shaped(const NphArray *array, NphType type, int rank, const int64_t *shape) {
    ck_assert_int_eq(array->type, type);
    ck_assert_int_eq(array->rank, rank);
    for (int axis = 0; axis < NPH_MAX_RANK; axis++) ck_assert_int_eq(array->shape[axis], axis < rank ? shape[axis] : 1);
}

START_TEST(every_version_and_rank_is_read) {
    NphContext *context = nph_test_context(1);
    static const float values[6] = {0, 1, 2, 3, 4, 5};
    static const char *const dictionary = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }";
    for (int major = 1; major <= 3; major++) {
        NphArray array = read_array(context, make(major, dictionary, values, sizeof values));
        is_shaped(&array, NPH_F32, 2, (int64_t[]){2, 3});
        ck_assert_mem_eq(array.data, values, sizeof values);
        nph_array_free(context, &array);
    }
    NphArray array = read_array(context, make(1, "{'descr': '<i2', 'fortran_order': False, 'shape': (), }", "\7\0", 2));
    is_shaped(&array, NPH_I16, 0, NULL);
    ck_assert_int_eq(*(int16_t *)array.data, 7);
    nph_array_free(context, &array);
    array = read_array(context, make(1, "{'descr': '<u8', 'fortran_order': False, 'shape': (0, 3), }", "", 0));
    is_shaped(&array, NPH_U64, 2, (int64_t[]){0, 3});
    nph_array_free(context, &array);
    int64_t counts[720];
    for (int i = 0; i < 300; i++) counts[i] = i;
    static const char *const long_shape = "{'descr': '<i8', 'fortran_order': False, 'shape': (1, 2, 3L, 5, 2, 5), }";
    array = read_array(context, make(1, long_shape, counts, 2400));
    is_shaped(&array, NPH_I64, 6, (int64_t[]){1, 2, 3, 5, 2, 5});
    ck_assert_mem_eq(array.data, counts, 2400);
    nph_array_free(context, &array);
    nph_test_context_close(context);
}
END_TEST

/* Bytes 1, 2, 3, ... as little- and as big-endian elements of every type. */
START_TEST(every_type_is_read_in_both_byte_orders) {
    static const char codes[][3] = {"u1", "i1", "u2", "i2", "f2", "u4", "i4", "f4", "u8", "i8", "f8"};
    NphContext *context = nph_test_context(1);
    for (int type = NPH_U8; type <= NPH_F64; type++)
        for (int big = 0; big < 2; big++) {
            size_t size = nph_type_size((NphType)type);
            unsigned char data[24], expected[24];
            char dictionary[100];
            for (size_t i = 0; i < 3 * size; i++) {
                expected[i] = (unsigned char)(i + 1);
                data[big ? i / size * size + size - 1 - i % size : i] = (unsigned char)(i + 1);
            }
            snprintf(dictionary, sizeof dictionary, "{'descr': '%c%s', 'fortran_order': False, 'shape': (3,), }",
                     size == 1 ? '|' : big ? '>' : '<', codes[type]);
            NphArray array = read_array(context, make(1, dictionary, data, 3 * size));
            is_shaped(&array, (NphType)type, 1, (int64_t[]){3});
            ck_assert_mem_eq(array.data, expected, 3 * size);
            nph_array_free(context, &array);
        }
    nph_test_context_close(context);
}
END_TEST

START_TEST(fortran_order_becomes_c_order) {
    NphContext *context = nph_test_context(1);
    double data[24], swapped[24];
    for (int x = 0; x < 2; x++)
        for (int y = 0; y < 3; y++)
            for (int z = 0; z < 4; z++) data[x + 2 * (y + 3 * z)] = 100 * x + 10 * y + z;
    for (int i = 0; i < 24; i++)
        for (int b = 0; b < 8; b++) ((unsigned char *)swapped)[8 * i + b] = ((unsigned char *)data)[8 * i + 7 - b];
    for (int big = 0; big < 2; big++) {
        const char *dictionary = big ? "{'descr': '>f8', 'fortran_order': True, 'shape': (2, 3, 4), }"
                                     : "{'descr': '<f8', 'fortran_order': True, 'shape': (2, 3, 4), }";
        NphArray array = read_array(context, make(2, dictionary, big ? swapped : data, sizeof data));
        is_shaped(&array, NPH_F64, 3, (int64_t[]){2, 3, 4});
        const double *values = array.data;
        for (int i = 0; i < 24; i++) ck_assert_double_eq(values[i], 100 * (i / 12) + 10 * (i / 4 % 3) + i % 4);
        nph_array_free(context, &array);
    }
    nph_test_context_close(context);
}
END_TEST

START_TEST(other_types_are_refused_by_name) {
    refused_header("{'descr': '<c16', 'fortran_order': False, 'shape': (1,), }",
                   "byte 21: elements of type '<c16' (complex numbers)");
    refused_header("{'descr': '|O', 'fortran_order': False, 'shape': (1,), }", "'|O' (Python objects)");
    refused_header("{'descr': '<U2', 'fortran_order': False, 'shape': (1,), }", "'<U2' (text)");
    refused_header("{'descr': '|S2', 'fortran_order': False, 'shape': (1,), }", "'|S2' (text)");
    refused_header("{'descr': '<M8[D]', 'fortran_order': False, 'shape': (1,), }", "'<M8[D]' (times)");
    refused_header("{'descr': '|b1', 'fortran_order': False, 'shape': (1,), }", "'|b1' (booleans)");
    refused_header("{'descr': '<f16', 'fortran_order': False, 'shape': (1,), }", "'<f16'");
    refused_header("{'descr': '|f4', 'fortran_order': False, 'shape': (1,), }", "'|f4'");
    refused_header("{'descr': [('a', '<f4'), ('b', '<i4')], 'fortran_order': False, 'shape': (2,), }",
                   "structured records");
}
END_TEST

START_TEST(damaged_headers_are_refused_with_the_byte) {
    refused_header("['descr', '<f4']", "byte 10: the header is not a dictionary");
    refused_header("{'descr': '<f4', 'fortran_order': False}", "lacks descr, fortran_order or shape");
    refused_header("{'descr': '<f4', 'fortran_order': False, 'shape': (1,), 'more': 1}", "unknown or repeated key");
    refused_header("{'shape': (1,), 'descr': '<f4', 'fortran_order': False, 'shape': (1,)}", "unknown or repeated key");
    refused_header("{'descr': '<f4', 'fortran_order': 0, 'shape': (1,), }",
                   "byte 44: 'fortran_order' is not True or False");
    refused_header("{'descr': '<f4', 'fortran_order': False, 'shape': 1, }", "byte 60: 'shape' is not a list");
    refused_header("{'descr': '<f4', 'fortran_order': False, 'shape': (-1,), }", "not a number of at least 0");
    refused_header("{'descr': '<f4', 'fortran_order': False, 'shape': (1 2), }", "'shape' is not closed");
    refused_header("{'descr': '<f4', 'fortran_order': False, 'shape': (1,1,1,1,1,1,1), }", "more than 6 dimensions");
    refused_header("{'descr': '<f4', 'fortran_order': False, 'shape': (99999999999999999999,), }", "not a number");
    refused_header("{'descr': '<f4', 'fortran_order': False, 'shape': (1,), } x", "something follows");
    refused_header("{'descr: ", "dictionary is damaged");
    size_t size = make(1, "{'descr': '|u1', 'fortran_order': False, 'shape': (4,), }", "abcd", 4);
    file[6] = 4;
    refused(size, "byte 6: version 4.0 of .npy is not read");
    file[6] = 1;
    file[9] = 255;
    refused(size, "byte 8: the file ends within its header");
    file[1] = 'M';
    refused(size, "is not a .npy file");
    refused(0, "is not a .npy file");
}
END_TEST

/* 2^63 elements, products that overflow, one byte too few or too many: nothing is allocated for what is not there. */
START_TEST(shape_and_size_must_agree) {
    static const char *const form = "{'descr': '%s', 'fortran_order': False, 'shape': (%s), }";
    static const struct {
        const char *descr, *shape;
        size_t bytes;
    } cases[] = {{"<f4", "2, 3", 23},          {"<f4", "2, 3", 25},
                 {"<f8", "9223372036854775807,", 8}, {"|u1", "4294967296, 4294967296", 0},
                 {"|u1", "4294967296, 4294967297", 1}, {"<f4", "3037000500, 3037000500", 100},
                 {"<f8", "1, 2305843009213693952,", 0}, {"|u1", "0, 5", 1},
                 {"|u1", "9223372036854775807, 0", 1},  {"<f4", "", 3}};
    static const unsigned char zeros[128];
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char dictionary[120];
        snprintf(dictionary, sizeof dictionary, form, cases[i].descr, cases[i].shape);
        refused(make(1, dictionary, zeros, cases[i].bytes), "follow the header, but its shape and type need");
    }
}
END_TEST

START_TEST(what_is_written_is_what_numpy_writes) {
    NphContext *context = nph_test_context(1);
    const char *path = nph_test_temporary("written.npy");
    static const struct {
        NphType type;
        int rank;
        int64_t shape[NPH_MAX_RANK];
        const char *dictionary;
    } cases[] = {{NPH_F32, 2, {2, 3}, "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }"},
                 {NPH_I16, 0, {0}, "{'descr': '<i2', 'fortran_order': False, 'shape': (), }"},
                 {NPH_F16, 1, {2}, "{'descr': '<f2', 'fortran_order': False, 'shape': (2,), }"},
                 {NPH_U8, 1, {3}, "{'descr': '|u1', 'fortran_order': False, 'shape': (3,), }"},
                 {NPH_U64, 2, {0, 3}, "{'descr': '<u8', 'fortran_order': False, 'shape': (0, 3), }"},
                 {NPH_I64, 6, {1, 2, 3, 4, 5, 1},
                  "{'descr': '<i8', 'fortran_order': False, 'shape': (1, 2, 3, 4, 5, 1), }"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        NphArray array = {0}, back = {0};
        ck_assert_int_eq(nph_array_new(context, cases[i].type, cases[i].rank, cases[i].shape, "test", &array), NPH_OK);
        size_t bytes = (size_t)nph_array_count(&array) * nph_type_size(array.type);
        for (size_t b = 0; b < bytes; b++) ((unsigned char *)array.data)[b] = (unsigned char)(b * 7);
        ck_assert_int_eq(nph_npy_write(context, path, &array), NPH_OK);
        size_t expected = make(1, cases[i].dictionary, array.data, bytes);
        static unsigned char written[FILE_MAX];
        FILE *stream = fopen(path, "rb");
        ck_assert_ptr_nonnull(stream);
        ck_assert_uint_eq(fread(written, 1, FILE_MAX, stream), expected);
        fclose(stream);
        ck_assert_mem_eq(written, file, expected);
        ck_assert_int_eq(nph_npy_read(context, path, &back), NPH_OK);
        is_shaped(&back, cases[i].type, cases[i].rank, cases[i].shape);
        ck_assert_mem_eq(back.data, array.data, bytes);
        nph_array_free(context, &array);
        nph_array_free(context, &back);
    }
    nph_test_context_close(context);
}
END_TEST

START_TEST(an_unwritable_target_is_refused) {
    NphContext *context = nph_test_context(1);
    NphArray array = {0};
    ck_assert_int_eq(nph_array_new(context, NPH_U8, 1, (int64_t[]){3}, "test", &array), NPH_OK);
    ck_assert_int_eq(nph_npy_write(context, nph_test_temporary("nowhere/x.npy"), &array), NPH_BAD_OUTPUT);
    ck_assert_int_eq(nph_npy_write(context, nph_test_temporary(""), &array), NPH_BAD_OUTPUT);
    nph_array_free(context, &array);
    ck_assert_int_eq(nph_npy_read(context, nph_test_temporary(""), &array), NPH_BAD_INPUT);
    ck_assert_int_eq(nph_npy_read(context, nph_test_temporary("none.npy"), &array), NPH_BAD_INPUT);
    nph_test_context_close(context);
}
END_TEST

/* Flips in the elements are other elements; flips in the header are refused or blanks of the padding or such. */
START_TEST(cuts_are_refused_and_flips_do_no_harm) {
    NphContext *context = nph_test_context(1);
    static const float values[60] = {1};
    static const char *const dictionary = "{'descr': '<f4', 'fortran_order': True, 'shape': (3, 4, 5), }";
    size_t size = make(1, dictionary, values, sizeof values);
    NphArray array = {0};
    for (size_t cut = 0; cut < size; cut++) ck_assert_int_eq(nph_npy_read(context, store(cut), &array), NPH_BAD_INPUT);
    int read = 0;
    for (size_t bit = 0; bit < 8 * 130; bit++) {
        file[bit >> 3] ^= (unsigned char)(1 << (bit & 7));
        NphStatus status = nph_npy_read(context, store(size), &array);
        ck_assert(status == NPH_OK || status == NPH_BAD_INPUT);
        if (status == NPH_OK) {
            ck_assert_uint_eq((size_t)nph_array_count(&array) * nph_type_size(array.type), sizeof values);
            nph_array_free(context, &array);
            read++;
        }
        file[bit >> 3] ^= (unsigned char)(1 << (bit & 7));
    }
    ck_assert_int_gt(read, 0);
    ck_assert_int_lt(read, 200);
    ck_assert_uint_lt(nph_context_peak_bytes(context), 4096);
    nph_test_context_close(context);
}
END_TEST

START_TEST(arrays_one_after_the_other_are_read_from_where_they_begin) {
    NphContext *context = nph_test_context(1);
    static const int64_t shapes[3][2] = {{3, 5}, {0, 4}, {2, 2}};
    int64_t begins[4] = {0};
    const char *path = nph_test_temporary("arrays.npys");
    int descriptor = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    ck_assert_int_ge(descriptor, 0);
    NphAppender appender;
    ck_assert_int_eq(nph_appender_open(context, descriptor, path, &appender), NPH_OK);
    for (int k = 0; k < 3; k++) {
        NphArray array = {0};
        ck_assert_int_eq(nph_array_new(context, k == 1 ? NPH_I32 : NPH_F32, 2, shapes[k], "test", &array), NPH_OK);
        for (int64_t i = 0; i < nph_array_count(&array); i++) ((float *)array.data)[i] = (float)(10 * k + i);
        begins[k + 1] = begins[k];
        ck_assert_int_eq(nph_npy_append(context, &appender, &array, 0, &begins[k + 1]), NPH_OK);
        ck_assert_int_eq(begins[k + 1] % 64, 0);
        nph_array_free(context, &array);
    }
    ck_assert_int_eq(nph_appender_flush(context, &appender), NPH_OK);
    nph_appender_close(context, &appender);
    ck_assert_int_eq(lseek(descriptor, 0, SEEK_END), begins[3]);
    ck_assert_int_eq(close(descriptor), 0);
    for (int k = 2; k >= 0; k--) {
        char place[4096];
        NphArray array = {0};
        snprintf(place, sizeof place, "%s@%lld", path, (long long)begins[k]);
        ck_assert_msg(nph_npy_read(context, place, &array) == NPH_OK, "%s", nph_test_messages());
        ck_assert(array.rank == 2 && array.shape[0] == shapes[k][0] && array.shape[1] == shapes[k][1]);
        for (int64_t i = 0; i < nph_array_count(&array); i++) ck_assert(((float *)array.data)[i] == (float)(10 * k + i));
        nph_array_free(context, &array);
    }
    static const struct { int64_t offset; const char *words; } wrong[] = {
        {1, "is not a .npy file"}, {1 << 20, "none at 1048576"}, {256 - 4, "is not a .npy file"}};
    for (int k = 0; k < 3; k++) {
        char place[4096];
        NphArray array;
        snprintf(place, sizeof place, "%s@%lld", path, (long long)wrong[k].offset);
        ck_assert_int_eq(nph_npy_read(context, place, &array), NPH_BAD_INPUT);
        ck_assert_msg(strstr(nph_test_messages(), wrong[k].words), "%s", nph_test_messages());
    }
    /* cut in the middle of the last one: what is missing is said, and nothing is allocated for what a header claims */
    ck_assert_int_eq(truncate(path, (off_t)begins[2] + 130), 0);
    char place[4096];
    NphArray array;
    snprintf(place, sizeof place, "%s@%lld", path, (long long)begins[2]);
    ck_assert_int_eq(nph_npy_read(context, place, &array), NPH_BAD_INPUT);
    ck_assert_msg(strstr(nph_test_messages(), "2 bytes follow the header"), "%s", nph_test_messages());
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, arrays_one_after_the_other_are_read_from_where_they_begin);
    tcase_add_test(cases, every_version_and_rank_is_read);
    tcase_add_test(cases, every_type_is_read_in_both_byte_orders);
    tcase_add_test(cases, fortran_order_becomes_c_order);
    tcase_add_test(cases, other_types_are_refused_by_name);
    tcase_add_test(cases, damaged_headers_are_refused_with_the_byte);
    tcase_add_test(cases, shape_and_size_must_agree);
    tcase_add_test(cases, what_is_written_is_what_numpy_writes);
    tcase_add_test(cases, an_unwritable_target_is_refused);
    tcase_add_test(cases, cuts_are_refused_and_flips_do_no_harm);
}

int main(void) { return nph_test_main("npy", fill); }
