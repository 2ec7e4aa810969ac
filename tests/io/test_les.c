/* SPDX-License-Identifier: Apache-2.0
 *
 * LES text in both layouts: the fields of reference/data/gpl against facts measured on them with another program, and
 * every kind of mistake, refused with its line. */
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "harness.h"
#include "io/volume.h"

typedef struct ExpectedField {
    const char *file;
    int64_t n[3]; /* nx, ny, nz */
    double spacing_m, first_m, second_m, last_m;
    int64_t cloudy; /* points with water */
    double lwc_sum, reff_sum;
    int64_t at[3]; /* of the largest water content */
    float lwc_max, reff_there, reff_max;
    double extinction_max; /* 1500 lwc / reff, 1/km */
} ExpectedField;

static const ExpectedField fields[] = {
    {"rico32x37x26.txt", {32, 37, 26}, 20, 440, 480, 1440, 3943, 1046.5975906884996, 61956.488114356995,
     {9, 26, 22}, 1.5178f, 18.506f, 18.698f, 123.02496},
    {"rico122x106x39.txt", {122, 106, 39}, 20, 440, 480, 1960, 15905, 2924.947330626659, 253189.23937129974,
     {105, 66, 28}, 1.3804f, 19.688f, 20.751f, 105.17066},
    {"les_stcu.txt", {64, 64, 16}, 55, 438, 463, 812, 24789, 8455.555599725005, 398596.5800180435,
     {3, 49, 14}, 4.2644f, 24.18f, 24.18f, 264.54094},
};

START_TEST(the_sample_fields_hold_what_was_measured_on_them) {
    const ExpectedField *expected = &fields[_i];
    NphContext *context = nph_test_context(1);
    char relative[128];
    NphLes les;
    snprintf(relative, sizeof relative, "reference/data/gpl/%s", expected->file);
    NphStatus status = nph_les_read(context, nph_test_path(relative), &les);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    ck_assert_int_eq(les.lwc_g_per_m3.type, NPH_F32);
    ck_assert_int_eq(les.lwc_g_per_m3.rank, 3);
    for (int axis = 0; axis < 3; axis++) {
        ck_assert_int_eq(les.lwc_g_per_m3.shape[2 - axis], expected->n[axis]);
        ck_assert_int_eq(les.reff_um.shape[2 - axis], expected->n[axis]);
    }
    const double *height = les.height_m.data;
    const float *lwc = les.lwc_g_per_m3.data, *reff = les.reff_um.data;
    ck_assert_double_eq(les.spacing_m[0], expected->spacing_m);
    ck_assert_double_eq(les.spacing_m[1], expected->spacing_m);
    ck_assert_double_eq(height[0], expected->first_m); /* exact: 0.44 km is 440 m, not 0.44 * 1000 */
    ck_assert_double_eq(height[1], expected->second_m);
    ck_assert_double_eq(height[expected->n[2] - 1], expected->last_m);
    int64_t count = nph_array_count(&les.lwc_g_per_m3), cloudy = 0, place = 0;
    double lwc_sum = 0, reff_sum = 0, extinction = 0;
    float reff_max = 0;
    for (int64_t i = 0; i < count; i++) {
        cloudy += lwc[i] > 0;
        lwc_sum += (double)lwc[i];
        reff_sum += (double)reff[i];
        if (lwc[i] > lwc[place]) place = i;
        if (reff[i] > reff_max) reff_max = reff[i];
        if (reff[i] > 0) extinction = fmax(extinction, 1500.0 * (double)lwc[i] / (double)reff[i]);
    }
    ck_assert_int_eq(cloudy, expected->cloudy);
    ck_assert_double_eq_tol(lwc_sum, expected->lwc_sum, 1e-9 * expected->lwc_sum);
    ck_assert_double_eq_tol(reff_sum, expected->reff_sum, 1e-9 * expected->reff_sum);
    ck_assert_int_eq(place, (expected->at[2] * expected->n[1] + expected->at[1]) * expected->n[0] + expected->at[0]);
    ck_assert(lwc[place] == expected->lwc_max);
    ck_assert(reff[place] == expected->reff_there);
    ck_assert(reff_max == expected->reff_max);
    ck_assert_double_eq_tol(extinction, expected->extinction_max, 1e-4);
    nph_les_free(context, &les);
    nph_test_context_close(context);
}
END_TEST

static const char *store_bytes(const char *text, size_t size) {
    const char *path = nph_test_temporary("field.txt");
    FILE *stream = fopen(path, "wb");
    ck_assert_ptr_nonnull(stream);
    ck_assert_uint_eq(fwrite(text, 1, size, stream), size);
    ck_assert_int_eq(fclose(stream), 0);
    return path;
}

static void is_small_field(const char *text) {
    NphContext *context = nph_test_context(1);
    NphLes les;
    NphStatus status = nph_les_read(context, store_bytes(text, strlen(text)), &les);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    const float *lwc = les.lwc_g_per_m3.data, *reff = les.reff_um.data; /* [2][1][2] */
    ck_assert(lwc[0] == 0.0f && lwc[1] == 0.25f && lwc[2] == 1e-3f && lwc[3] == 0.0f);
    ck_assert(reff[0] == 0.0f && reff[1] == 10.0f && reff[2] == 12.5f && reff[3] == 0.0f);
    ck_assert_double_eq(les.spacing_m[0], 20.0);
    ck_assert_double_eq(les.spacing_m[1], 50.0);
    ck_assert_double_eq(((double *)les.height_m.data)[0], 560.0);
    ck_assert_double_eq(((double *)les.height_m.data)[1], 600.0);
    nph_les_free(context, &les);
    nph_test_context_close(context);
}

START_TEST(both_layouts_comments_blanks_and_line_ends_are_read) {
    is_small_field("2,1,2\n0.02,0.05\n0.56,0.6\nx,y,z,lwc,reff\n1,0,0,.25,10\n0,0,1,1e-3,12.5\n");
    is_small_field("# a cloud\n\n 2, 1 ,2 # n\r\n0.020,5e-2#d\r\n.56,6.0E-1\r\ni,j,k,lwc,reff\r\n"
                   "0,0,1,0.001,12.5\r\n  # nothing\r\n1,0,0,0.25,10.0 # last\r\n");
    is_small_field("2 1 2\n0.02 0.05 0.56 0.60\n0 0 0 0 0\n0 0 1 1e-3 12.5\n1 0 0 .25 10\n1 0 1 -0 0\n");
    is_small_field("#\n2\t1  2 \n 0.02 0.05\t0.56 0.60#\n1 0 0 .25 10\n0 0 0 0 0\n1 0 1 0 0\n0 0 1 1e-3 12.5\n");
}
END_TEST

/* A comma as decimal point in the process must change nothing. */
START_TEST(numbers_do_not_follow_the_locale) {
    static const char *const names[] = {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "de_DE"};
    for (int i = 0; i < 4; i++) {
        if (!setlocale(LC_ALL, names[i])) continue;
        is_small_field("2,1,2\n0.02,0.05\n0.56,0.6\nx,y,z,lwc,reff\n1,0,0,.25,10\n0,0,1,1e-3,12.5\n");
        setlocale(LC_ALL, "C");
        return;
    }
    nph_test_skip("LES text under a locale with a decimal comma (none is installed)");
}
END_TEST

#define CSV "2,1,2\n0.02,0.05\n0.56,0.6\nx,y,z,lwc,reff\n"
#define BLANK "2 1 2\n0.02 0.05 0.56 0.6\n"

static const struct {
    const char *text, *message; /* behind the path */
} mistakes[] = {
    {"", ": is empty"},
    {"# nothing\n", ":1: the file ends before the line nx,ny,nz"},
    {"2,1\n", ":1: the line ends before nz"},
    {"2,1,2,9\n", ":1: '9' follows nz"},
    {"2,one,2\n", ":1: ny is 'one', not a whole number"},
    {"2,,2\n", ":1: ny is '', not a whole number"},
    {"2,1.0,2\n", ":1: ny is '1.0', not a whole number"},
    {"0,1,2\n", ":1: nx is 0; at least 1 is needed"},
    {"2,-1,2\n", ":1: ny is -1; at least 1 is needed"},
    {"99999999999999999999,1,2\n", ":1: nx is '99999999999999999999', not a whole number"},
    {"100000,100000,2\n0.1,0.1\n", ":1: a lattice of this size cannot come from a file of 24 bytes"},
    {"9223372036854775807,9223372036854775807,9\n", ":1: a lattice of this size cannot come"},
    {"2,1,2\n", ":1: the file ends before the line dx,dy"},
    {"2,1,2\n0.02,0\n", ":2: dy must be greater than 0"},
    {"2,1,2\n-0.02,0.05\n", ":2: dx must be greater than 0"},
    {"2,1,2\nnan,0.05\n", ":2: dx is 'nan', not a finite number"},
    {"2,1,2\n1e999,0.05\n", ":2: dx is '1e999', not a finite number"},
    {"2,1,2\n0.02,0.05,7\n", ":2: '7' follows dy"},
    {"2,1,2\n0.02,0.05\n0.56\n", ":3: the line ends before altitude 2 of 2"},
    {"2,1,2\n0.02,0.05\n0.56,0.6,0.7\n", ":3: '0.7' follows the last altitude"},
    {"2,1,2\n0.02,0.05\n0.56,0.56\n", ":3: altitude 2 of 2 does not lie above the one before"},
    {"2,1,2\n0.02,0.05\n0.56,0.6\n", ":3: the file ends before the line i,j,k,lwc,reff"},
    {"2,1,2\n0.02,0.05\n0.56,0.6\n1,0,0,.25,10\n", ":4: the columns must be i,j,k,lwc,reff or x,y,z,lwc,reff"},
    {"2,1,2\n0.02,0.05\n0.56,0.6\nx,y,z,reff,lwc\n", ":4: the columns must be"},
    {"2,1,2\n0.02,0.05\n0.56,0.6\nx,j,k,lwc,reff\n", ":4: the columns must be"},
    {"2,1,2\n0.02,0.05\n0.56,0.6\nx,y,z,lwc,reff,veff\n", ":4: 'veff' follows the column reff"},
    {CSV, ":4: the file ends without a row"},
    {CSV "1,0,0,.25\n", ":5: the line ends before reff"},
    {CSV "1,0,0,.25,10,3\n", ":5: '3' follows reff"},
    {CSV "1 0 0 .25 10\n", ":5: i is '1 0 0 .25 10', not a whole number"},
    {CSV "# c\n\n2,0,0,.25,10\n", ":7: i is 2, not in 0 to 1"},
    {CSV "1,0,-1,.25,10\n", ":5: k is -1, not in 0 to 1"},
    {CSV "1,0,0,.25,10\n1,0,0,.25,10\n", ":6: point (1, 0, 0) occurs a second time"},
    {CSV "1,0,0,0,0\n1,0,0,.25,10\n", ":6: point (1, 0, 0) occurs a second time"},
    {CSV "1,0,0,-.25,10\n", ":5: lwc is -0.25; it must be at least 0"},
    {CSV "1,0,0,.25,-10\n", ":5: reff is -10; it must be at least 0"},
    {CSV "1,0,0,NaN,10\n", ":5: lwc is 'NaN', not a finite number"},
    {CSV "1,0,0,.25,inf\n", ":5: reff is 'inf', not a finite number"},
    {CSV "1,0,0,1e39,10\n", ":5: lwc is 1e+39; it must be at least 0 and at most"},
    {CSV "1,0,0,0x1p3,10\n", ":5: lwc is '0x1p3', not a finite number"},
    {CSV "1,0,0,\x1b[2J,10\n", ":5: lwc is '?[2J', not a finite number"},
    {CSV "1,0,0,.25,10", ":5: the last line does not end"},
    {BLANK "0 0 0 0 0\n0 0 1 0 0\n1 0 0 0 0\n",
     ":5: the file ends after 3 rows; this layout has one for each of its 4 points"},
    {BLANK "0 0 0 0 0\n0 0 1 0 0\n1 0 0 0 0\n1 0 1 0 0\n1 0 1 0 0\n", ":7: point (1, 0, 1) occurs a second time"},
    {"2 1 2\n0.02 0.05\n0.56 0.6\n", ":2: the line ends before altitude 1 of 2"},
};
enum { MISTAKES = sizeof mistakes / sizeof *mistakes };

START_TEST(every_mistake_is_refused_with_its_line) {
    NphContext *context = nph_test_context(1);
    NphLes les = {.spacing_m = {-7, -7}};
    const char *path = store_bytes(mistakes[_i].text, strlen(mistakes[_i].text));
    ck_assert_int_eq(nph_les_read(context, path, &les), NPH_BAD_INPUT);
    ck_assert_double_eq(les.spacing_m[0], -7);
    char expected[1024];
    snprintf(expected, sizeof expected, "%s%s", path, mistakes[_i].message);
    const char *messages = nph_test_messages();
    ck_assert_msg(strncmp(messages, expected, strlen(expected)) == 0, "expected %s, got %s", expected, messages);
    nph_test_context_close(context);
}
END_TEST

START_TEST(binary_files_folders_and_missing_files_are_refused) {
    NphContext *context = nph_test_context(1);
    NphLes les;
    ck_assert_int_eq(nph_les_read(context, store_bytes(CSV "1,0,0\0,1,1\n", sizeof CSV + 10), &les), NPH_BAD_INPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "byte 45: holds a NUL byte"));
    ck_assert_int_eq(nph_les_read(context, nph_test_temporary(""), &les), NPH_BAD_INPUT);
    ck_assert_int_eq(nph_les_read(context, nph_test_temporary("none.txt"), &les), NPH_BAD_INPUT);
    nph_test_context_close(context);
}
END_TEST

static uint64_t random_state = 88172645463325252u;
static uint64_t next_random(void) {
    random_state ^= random_state << 13;
    random_state ^= random_state >> 7;
    return random_state ^= random_state << 17;
}

/* A row may be changed into another sound row; nothing else may come through, and never more memory than the limit. */
START_TEST(flips_and_cuts_of_a_field_do_no_harm) {
    static char text[100000];
    NphContext *context = nph_test_context(1);
    FILE *stream = fopen(nph_test_path("reference/data/gpl/rico32x37x26.txt"), "rb");
    ck_assert_ptr_nonnull(stream);
    size_t size = fread(text, 1, sizeof text, stream);
    fclose(stream);
    int read = 0;
    for (int n = 0; n < 500; n++) {
        size_t bit = next_random() % (8 * (n % 2 ? size : 500));
        text[bit >> 3] = (char)(text[bit >> 3] ^ 1 << (bit & 7));
        NphLes les;
        NphStatus status = nph_les_read(context, store_bytes(text, size), &les);
        ck_assert(status == NPH_OK || status == NPH_BAD_INPUT);
        if (status == NPH_OK) nph_les_free(context, &les);
        read += status == NPH_OK;
        ck_assert_uint_eq(nph_context_bytes(context), 0);
        text[bit >> 3] = (char)(text[bit >> 3] ^ 1 << (bit & 7));
    }
    ck_assert_int_gt(read, 0);
    ck_assert_int_lt(read, 450);
    for (int n = 0; n < 100; n++) {
        size_t cut = next_random() % size;
        NphLes les;
        if (cut && text[cut - 1] == '\n') continue; /* whole rows are missing: no text file can tell */
        ck_assert_int_eq(nph_les_read(context, store_bytes(text, cut), &les), NPH_BAD_INPUT);
    }
    ck_assert_uint_lt(nph_context_peak_bytes(context), (uint64_t)256 << 20);
    nph_test_context_close(context);
}
END_TEST

START_TEST(every_failing_allocation_is_reported_and_nothing_leaks) {
    NphStatus status = NPH_NO_MEMORY;
    uint64_t nth = 0;
    while (status == NPH_NO_MEMORY && nth < 20) {
        NphSettings settings;
        nph_settings_default(&settings);
        settings.threads = 1;
        settings.fail_allocation = ++nth;
        NphContext *context = NULL;
        ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
        NphLes les;
        status = nph_les_read(context, store_bytes(CSV "1,0,0,1,1\n", sizeof CSV + 9), &les);
        if (status == NPH_OK) nph_les_free(context, &les);
        nph_test_context_close(context);
    }
    ck_assert_int_eq(status, NPH_OK);
    ck_assert_uint_ge(nth, 5);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_loop_test(cases, the_sample_fields_hold_what_was_measured_on_them, 0, 3);
    tcase_add_test(cases, both_layouts_comments_blanks_and_line_ends_are_read);
    tcase_add_test(cases, numbers_do_not_follow_the_locale);
    tcase_add_loop_test(cases, every_mistake_is_refused_with_its_line, 0, MISTAKES);
    tcase_add_test(cases, binary_files_folders_and_missing_files_are_refused);
    tcase_add_test(cases, flips_and_cuts_of_a_field_do_no_harm);
    tcase_add_test(cases, every_failing_allocation_is_reported_and_nothing_leaks);
}

int main(void) { return nph_test_main("les", fill); }
