/* SPDX-License-Identifier: Apache-2.0
 *
 * See rows.h. */
#include "rows.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "harness.h"

static const struct {
    const char *name, *arguments, *results;
} functions[F_COUNT] = {
#define NPH_FUNCTION_TEXT(name, in, out) {#name, in, out},
    NPH_FUNCTIONS(NPH_FUNCTION_TEXT)
};

static int words_of(const char *kinds) {
    int count = 1;
    for (; *kinds; kinds++) count += *kinds == ' ';
    return count;
}

const char *nph_rows_function(int function) { return functions[function].name; }
int nph_rows_results(int function) { return words_of(functions[function].results); }

uint32_t nph_rows_comparable(int function, int result, uint32_t got) {
    const char *kind = functions[function].results;
    for (int i = 0; i < result; i++) kind = strchr(kind, ' ') + 1;
    return strncmp(kind, "u:", 2) != 0 && (got & 0x7fffffffu) > 0x7f800000u ? 0x7fc00000u : got;
}

static int function_named(const char *name, size_t length) {
    for (int f = 0; f < F_COUNT; f++)
        if (strlen(functions[f].name) == length && strncmp(functions[f].name, name, length) == 0) return f;
    ck_abort_msg("no function is called %.*s", (int)length, name);
    return -1;
}

/* Hexadecimal words up to the comma; what stands behind it. */
static const char *read_words(const char *text, uint32_t *words, int count) {
    for (int i = 0; i < count; i++) {
        char *end;
        words[i] = (uint32_t)strtoul(text, &end, 16);
        ck_assert_msg(end == text + 8 && *end == (i + 1 < count ? ' ' : ','), "not %d words: %s", count, text);
        text = end + 1;
    }
    return text;
}

static int read_file(const char *name, Row *rows, int count) {
    char line[512];
    FILE *file = fopen(nph_test_path(name), "r");
    ck_assert_msg(file != NULL, "no %s", name);
    ck_assert_ptr_nonnull(fgets(line, sizeof line, file));
    while (fgets(line, sizeof line, file)) {
        ck_assert_int_lt(count, NPH_ROWS_MOST);
        Row *row = &rows[count++];
        const char *comma = strchr(line, ',');
        memset(row, 0, sizeof *row);
        row->function = function_named(line, (size_t)(comma - line));
        const char *results = read_words(comma + 1, row->in, words_of(functions[row->function].arguments));
        read_words(results, row->out, nph_rows_results(row->function));
    }
    fclose(file);
    return count;
}

int nph_rows_read(Row rows[NPH_ROWS_MOST]) {
    int count = read_file("reference/vectors/philox.csv", rows, 0);
    count = read_file("reference/vectors/fmath.csv", rows, count);
    return read_file("reference/vectors/phase.csv", rows, count);
}
