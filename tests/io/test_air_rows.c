/* SPDX-License-Identifier: Apache-2.0
 *
 * Profiles of the atmosphere: rows turned upside down, and mistakes named with their line. */
#include "io/air_rows.h"

#include <stdio.h>
#include <string.h>

#include "harness.h"

static const char *store(const char *text) {
    const char *path = nph_test_temporary("air.dat");
    FILE *file = fopen(path, "wb");
    ck_assert_ptr_nonnull(file);
    ck_assert_uint_eq(fwrite(text, 1, strlen(text), file), strlen(text));
    ck_assert_int_eq(fclose(file), 0);
    return path;
}

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

static const struct {
    const char *text, *place, *words;
} mistakes[] = {
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

START_TEST(mistakes_are_refused_with_their_line) {
    for (size_t i = 0; i < sizeof mistakes / sizeof mistakes[0]; i++) {
        NphContext *context = nph_test_context(1);
        NphArray rows = {.rank = 5};
        const char *path = store(mistakes[i].text);
        ck_assert_int_eq(nph_air_rows_read(context, path, &rows), NPH_BAD_INPUT);
        const char *messages = nph_test_messages();
        ck_assert_msg(strstr(messages, mistakes[i].words) && strstr(messages, mistakes[i].place) && strstr(messages, path),
                      "'%s' lacks '%s' or '%s'", messages, mistakes[i].words, mistakes[i].place);
        ck_assert(rows.rank == 5);
        nph_test_context_close(context);
    }
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, the_standard_atmosphere_is_read_from_the_ground_up);
    tcase_add_test(cases, mistakes_are_refused_with_their_line);
}

int main(void) { return nph_test_main("air_rows", fill); }
