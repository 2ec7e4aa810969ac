/* SPDX-License-Identifier: Apache-2.0
 *
 * Profiles of the atmosphere: rows turned upside down, and mistakes named with their line. */
#include "io/air_rows.h"

#include "io/rows_case.h"

START_TEST(the_standard_atmosphere_is_read_from_the_ground_up) {
    NphContext *context = nph_test_context(1);
    NphArray rows;
    ck_assert_msg(nph_air_rows_read(context, nph_test_path("reference/data/gpl/afglus.dat"), &rows) == NPH_OK, "%s",
                  nph_test_messages());
    const double *row = rows.data;
    ck_assert(rows.rank == 2 && rows.shape[0] == 50 && rows.shape[1] == 2);
    ck_assert(row[0] == 0.0 && row[1] == 2.545818e19 && row[2] == 1000.0 && row[3] == 2.310936e19);
    ck_assert(row[98] == 120000.0 && row[99] == 5.110260e11);
    nph_array_free(context, &rows);
    nph_test_context_close(context);
}
END_TEST

static const RowsMistake mistakes[] = {
    {"", "", "0 rows of height in km, pressure, temperature and molecules"},
    {"0 1 2 3\n", "", "1 rows"},
    {"1 9 9 2\n0 9 9\n", ":2:", "ends before the air"},
    {"1 9 9 2\n0.5 9 9 3\n", "", "the lowest level lies at 0.5 km; a profile ends at height 0"},
    {"1 9 9 2\n-1 9 9 3\n", ":2:", "the height is -1"},
    {"# z\n0 9 9 3\n1 9 9 2\n", ":3:", "does not lie below"},
    {"1 9 9 2\n0 9 9 2\n", ":2:", "not denser"},
    {"1 9 9 0\n0 9 9 2\n", ":1:", "the air is 0"},
    {"1 9 nan 1\n0 9 9 2\n", ":1:", "the temperature is 'nan'"},
};

START_TEST(mistakes_are_refused_with_their_line) { rows_expect_refused(mistakes, sizeof mistakes / sizeof *mistakes, nph_air_rows_read); }
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, the_standard_atmosphere_is_read_from_the_ground_up);
    tcase_add_test(cases, mistakes_are_refused_with_their_line);
}

int main(void) { return nph_test_main("air_rows", fill); }
