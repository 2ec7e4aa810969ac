/* SPDX-License-Identifier: Apache-2.0
 *
 * Tables of phase functions as text: what is read, and every kind of mistake refused with its line. */
#include "io/phase_rows.h"

#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "io/rows_case.h"

START_TEST(rows_are_read_with_comments_commas_and_blank_lines) {
    static const char *const texts[] = {
        "# angle value\n0 2\n\n 45.5\t1e-3 # here\n180 , 0\n", "0,2\r\n45.5,1e-3\r\n180,0\r\n", "0 2\n45.5 .001\n180 0",
        "\t0.0 , 2.0\n4.55e1,1e-3\n#\n#\n180. 0."};
    static const double want[6] = {0, 2, 45.5, 0.001, 180, 0};
    NphContext *context = nph_test_context(1);
    for (int i = 0; i < 4; i++) {
        NphArray rows;
        ck_assert_msg(nph_phase_rows_read(context, rows_store(texts[i], strlen(texts[i])), &rows) == NPH_OK, "%s", nph_test_messages());
        ck_assert(rows.type == NPH_F64 && rows.rank == 2 && rows.shape[0] == 3 && rows.shape[1] == 2);
        ck_assert_mem_eq(rows.data, want, sizeof want);
        nph_array_free(context, &rows);
    }
    nph_test_context_close(context);
}
END_TEST

START_TEST(the_c1_table_holds_what_was_measured_on_it) {
    NphContext *context = nph_test_context(1);
    NphArray rows;
    ck_assert_int_eq(nph_phase_rows_read(context, nph_test_path("reference/data/gpl/c1_phase.txt"), &rows), NPH_OK);
    const double *row = rows.data;
    ck_assert_int_eq(rows.shape[0], 1801);
    ck_assert(row[0] == 0 && row[1] == 1712.880 && row[3600] == 180);
    double least = 1e9, at = 0;
    for (int i = 0; i < 1801; i++)
        if (row[2 * i + 1] < least) least = row[2 * i + 1], at = row[2 * i];
    ck_assert(at == 105.2);
    ck_assert_double_eq_tol(least, 0.02689, 5e-6);
    nph_array_free(context, &rows);
    nph_test_context_close(context);
}
END_TEST

static const RowsMistake mistakes[] = {
    {"", "", "0 rows"},
    {"# nothing\n\n", "", "0 rows"},
    {"0 1\n", "", "1 rows"},
    {"0 1\n5\n180 1\n", ":2:", "ends before the value"},
    {"0 1\n5,\n180 1\n", ":2:", "ends before the value"},
    {"0 1\n5,,1\n180 1\n", ":2:", "the value is '', not a finite number"},
    {"angle value\n0 1\n180 1\n", ":1:", "the angle is 'angle'"},
    {"0 1\n90 nan\n180 1\n", ":2:", "the value is 'nan'"},
    {"0 1\n90 1e999\n180 1\n", ":2:", "not a finite number"},
    {"0 0x1\n180 1\n", ":1:", "'0x1'"},
    {"0 1 2\n180 1 2\n", ":1:", "'2' follows the value"},
    {"0 1,5\n180 1\n", ":1:", "follows the value"},
    {"0 1\n\n# x\n90 -1e-9\n180 1\n", ":4:", "values are at least 0"},
    {"-0.5 1\n180 1\n", ":1:", "angles are 0 to 180"},
    {"0 1\n180.1 1\n", ":2:", "angles are 0 to 180"},
    {"0 1\n90 1\n90 1\n180 1\n", ":3:", "does not lie above"},
    {"0 1\n90 1\n80 1\n", ":3:", "does not lie above"},
    {"180 1\n0 1\n", ":2:", "does not lie above"},
    {"0 1\n90 \033[2J1\n", ":2:", "'?[2J1'"},
    {"0 1\n90 1111111111111111111111111111111111111111111x\n", ":2:", "..."},
};

START_TEST(mistakes_are_refused_with_their_line) { rows_expect_refused(mistakes, sizeof mistakes / sizeof *mistakes, nph_phase_rows_read); }
END_TEST

START_TEST(binary_bytes_are_refused_and_never_read_beyond) {
    NphContext *context = nph_test_context(1);
    NphArray rows;
    ck_assert_int_eq(nph_phase_rows_read(context, rows_store("0 1\n\0 180 1\n", 12), &rows), NPH_BAD_INPUT);
    ck_assert(strstr(nph_test_messages(), "byte 4: holds a NUL byte") != NULL);
    ck_assert_int_eq(nph_phase_rows_read(context, nph_test_temporary("missing"), &rows), NPH_BAD_INPUT);
    ck_assert(strstr(nph_test_messages(), "missing") != NULL);
    srand(7);
    for (int round = 0; round < 500; round++) {
        static const char letters[] = "0123456789.,e+- \t\n#\n 18\xff";
        char text[200];
        int size = rand() % 200;
        for (int i = 0; i < size; i++) text[i] = letters[rand() % (int)(sizeof letters - 1)];
        NphStatus status = nph_phase_rows_read(context, rows_store(text, (size_t)size), &rows);
        nph_test_messages();
        ck_assert(status == NPH_OK || status == NPH_BAD_INPUT);
        if (status == NPH_OK) nph_array_free(context, &rows);
    }
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, rows_are_read_with_comments_commas_and_blank_lines);
    tcase_add_test(cases, the_c1_table_holds_what_was_measured_on_it);
    tcase_add_test(cases, mistakes_are_refused_with_their_line);
    tcase_add_test(cases, binary_bytes_are_refused_and_never_read_beyond);
}

int main(void) { return nph_test_main("phase_rows", fill); }
