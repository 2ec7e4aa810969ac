/* SPDX-License-Identifier: Apache-2.0
 *
 * Texts of rows that are wrong, and the line and words with which each must be refused. */
#ifndef NPH_TESTS_IO_ROWS_CASE_H
#define NPH_TESTS_IO_ROWS_CASE_H

#include <stdio.h>
#include <string.h>

#include "harness.h"
#include "nephos/array.h"

typedef struct RowsMistake {
    const char *text, *place, *words;
} RowsMistake;

static inline const char *rows_store(const char *text, size_t size) {
    const char *path = nph_test_temporary("rows.txt");
    FILE *file = fopen(path, "wb");
    ck_assert(file != NULL && fwrite(text, 1, size, file) == size && fclose(file) == 0);
    return path;
}

static inline void rows_expect_refused(const RowsMistake *mistakes, size_t count, NphStatus (*read)(NphContext *, const char *, NphArray *)) {
    for (size_t i = 0; i < count; i++) {
        NphContext *context = nph_test_context(1);
        NphArray rows = {.rank = 5};
        const char *path = rows_store(mistakes[i].text, strlen(mistakes[i].text));
        ck_assert_int_eq(read(context, path, &rows), NPH_BAD_INPUT);
        const char *messages = nph_test_messages();
        ck_assert_msg(strstr(messages, mistakes[i].words) && strstr(messages, mistakes[i].place) && strstr(messages, path),
                      "'%s' lacks '%s' or '%s'", messages, mistakes[i].words, mistakes[i].place);
        ck_assert(rows.rank == 5);
        nph_test_context_close(context);
    }
}

#endif
