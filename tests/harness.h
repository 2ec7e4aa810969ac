/* SPDX-License-Identifier: Apache-2.0
 *
 * What every test program shares: one Check suite a program, run by nph_test_main. */
#ifndef NPH_TESTS_HARNESS_H
#define NPH_TESTS_HARNESS_H

#include <check.h>

#include "nephos/context.h"

/* With NEPHOS_TEST_ONLY=TITLE only the case of that title runs. */
int nph_test_wanted(const char *title);
#undef tcase_add_test
#undef tcase_add_loop_test
#define tcase_add_loop_test(tcase, title, from, to)                                                  \
    do {                                                                                             \
        if (nph_test_wanted(#title)) tcase_add_loop_test_raise_signal(tcase, title, 0, from, to);     \
    } while (0)
#define tcase_add_test(tcase, title) tcase_add_loop_test(tcase, title, 0, 1)

/* Runs the suite; with NEPHOS_TEST_LOGS=DIR writes DIR/NAME.xml (Check's log with seconds per case). Returns the exit status. */
int nph_test_main(const char *name, void (*fill)(TCase *));

/* A context that records messages. threads 0: all. */
NphContext *nph_test_context(int threads);
void nph_test_context_close(NphContext *context); /* fails the case when memory is still allocated */
/* All messages since the last call, one per line; static buffer. */
const char *nph_test_messages(void);

/* Path below the source root (reference/data/...); static buffers, eight in rotation. */
const char *nph_test_path(const char *relative);

/* A path in a fresh temporary folder of this process, removed at exit. */
const char *nph_test_temporary(const char *name);
/* The path of a temporary file that holds the text. */
const char *nph_test_write(const char *name, const char *text);

/* 1 when long statistics are wanted; else names what is skipped and returns 0, and the case returns. NEPHOS_TEST_QUICK is set under
 * sanitizers, which look for other things; NEPHOS_TEST_NO_STATISTICS, which says why, where another run has them. */
int nph_test_statistics(const char *what);
/* The same of what is slow under sanitizers alone. */
int nph_test_long(const char *what);

/* Names a case that did not run and why; the runner counts it as skipped, not passed. */
void nph_test_skip(const char *why);

#endif
