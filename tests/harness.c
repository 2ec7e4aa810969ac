/* SPDX-License-Identifier: Apache-2.0
 *
 * See harness.h. */
#define _POSIX_C_SOURCE 200809L
#include "harness.h"

#ifdef NPH_ALTERED
#include "bugs/bugs.h"
#endif

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char messages[1 << 16];
static char temporary[256];
static pid_t temporary_owner;

static void record(void *user, NphMessageLevel level, const char *text) {
    (void)user;
    (void)level;
    size_t used = strlen(messages);
    snprintf(messages + used, sizeof messages - used, "%s\n", text);
}

NphContext *nph_test_context(int threads) {
    NphSettings settings;
    nph_settings_default(&settings);
    settings.threads = threads;
    settings.message = record;
    NphContext *context = NULL;
    ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
    messages[0] = 0;
    return context;
}

void nph_test_context_close(NphContext *context) {
    uint64_t left = nph_context_bytes(context);
    nph_context_close(context);
    ck_assert_msg(left == 0, "%llu bytes still allocated", (unsigned long long)left);
}

const char *nph_test_messages(void) {
    static char copy[sizeof messages];
    memcpy(copy, messages, sizeof messages);
    messages[0] = 0;
    return copy;
}

const char *nph_test_path(const char *relative) {
    static char buffers[8][1024];
    static int next;
    char *buffer = buffers[next++ % 8];
    const char *root = getenv("NEPHOS_SOURCE_ROOT");
    snprintf(buffer, sizeof buffers[0], "%s/%s", root ? root : ".", relative);
    return buffer;
}

static void remove_temporary(void) {
    if (!temporary[0] || temporary_owner != getpid()) return;
    DIR *folder = opendir(temporary);
    if (!folder) return;
    for (struct dirent *entry; (entry = readdir(folder));) {
        char path[600];
        if (entry->d_name[0] == '.') continue;
        snprintf(path, sizeof path, "%s/%s", temporary, entry->d_name);
        remove(path);
    }
    closedir(folder);
    rmdir(temporary);
}

static void make_temporary(void) {
    const char *base = getenv("TMPDIR");
    snprintf(temporary, sizeof temporary, "%s/nephos-test-XXXXXX", base ? base : "/tmp");
    if (!mkdtemp(temporary)) {
        perror("mkdtemp");
        exit(2);
    }
    temporary_owner = getpid();
    atexit(remove_temporary);
}

const char *nph_test_temporary(const char *name) {
    static char buffers[8][600];
    static int next;
    char *buffer = buffers[next++ % 8];
    snprintf(buffer, sizeof buffers[0], "%s/%s", temporary, name);
    return buffer;
}

const char *nph_test_write(const char *name, const char *text) {
    const char *path = nph_test_temporary(name);
    FILE *file = fopen(path, "w");
    ck_assert_ptr_nonnull(file);
    fputs(text, file);
    ck_assert_int_eq(fclose(file), 0);
    return path;
}

void nph_test_skip(const char *why) {
    const char *logs = getenv("NEPHOS_TEST_LOGS");
    printf("SKIPPED: %s\n", why);
    if (!logs) return;
    char path[1024];
    snprintf(path, sizeof path, "%s/skipped.txt", logs);
    FILE *file = fopen(path, "a");
    if (!file) return;
    fprintf(file, "%s\n", why);
    fclose(file);
}

static int skip_if(const char *variable, const char *what, const char *reason) {
    if (!getenv(variable)) return 0;
    char why[256];
    snprintf(why, sizeof why, "%s (%s)", what, reason);
    nph_test_skip(why);
    return 1;
}

int nph_test_statistics(const char *what) {
    const char *elsewhere = getenv("NEPHOS_TEST_NO_STATISTICS");
    return !skip_if("NEPHOS_TEST_QUICK", what, "long statistics, not under sanitizers") &&
           !skip_if("NEPHOS_TEST_NO_STATISTICS", what, elsewhere);
}

int nph_test_long(const char *what) { return !skip_if("NEPHOS_TEST_QUICK", what, "long, not under sanitizers"); }

int nph_test_wanted(const char *title) {
    const char *only = getenv("NEPHOS_TEST_ONLY");
    return !only || strcmp(only, title) == 0;
}

int nph_test_main(const char *name, void (*fill)(TCase *)) {
#ifdef NPH_ALTERED
    bugs_choose();
#endif
    make_temporary();
    Suite *suite = suite_create(name);
    TCase *cases = tcase_create(name);
    tcase_set_timeout(cases, 900);
    fill(cases);
    suite_add_tcase(suite, cases);
    SRunner *runner = srunner_create(suite);
    const char *logs = getenv("NEPHOS_TEST_LOGS");
    char path[1024];
    if (logs) {
        snprintf(path, sizeof path, "%s/%s.xml", logs, name);
        srunner_set_xml(runner, path);
    }
    srunner_run_all(runner, CK_NORMAL);
    int failed = srunner_ntests_failed(runner);
    srunner_free(runner);
    return failed ? 1 : 0;
}
