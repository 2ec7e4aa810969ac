/* SPDX-License-Identifier: Apache-2.0
 *
 * Running the nephos program from a test: arguments in, exit status and both outputs out, no shell in between. */
#ifndef NPH_TESTS_PROGRAM_H
#define NPH_TESTS_PROGRAM_H

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "harness.h"

enum { PROGRAM_OUTPUT = 1 << 17 };

typedef struct Ran {
    int status; /* exit status; 128 + number of the signal that ended it */
    char out[PROGRAM_OUTPUT], err[PROGRAM_OUTPUT];
} Ran;

static inline const char *program_path(void) {
    static char path[1024];
    const char *root = getenv("NEPHOS_PROGRAM_ROOT");
    snprintf(path, sizeof path, "%s/src/cli/nephos", root ? root : "build");
    return path;
}

static inline void program_read(const char *path, char *text) {
    FILE *file = fopen(path, "rb");
    ck_assert_ptr_nonnull(file);
    text[fread(text, 1, PROGRAM_OUTPUT - 1, file)] = 0;
    fclose(file);
}

static inline void program_redirect(const char *path, int to) {
    int file = open(path, O_CREAT | O_TRUNC | O_WRONLY, 0600);
    if (file < 0 || dup2(file, to) < 0) _exit(126);
}

/* A file of the temporary folder; unlike the harness's, the text stays for 64 further calls. */
static inline const char *file_of(const char *name) {
    static char paths[64][600];
    static int next;
    char *path = paths[next++ % 64];
    snprintf(path, sizeof paths[0], "%s", nph_test_temporary(name));
    return path;
}

/* Starts a program; arguments end with NULL, the program's path is put before them. */
static inline pid_t program_start_at(const char *path, const char *const *arguments) {
    const char *words[64] = {path};
    int count = 1;
    while (arguments[count - 1]) {
        words[count] = arguments[count - 1];
        count++;
    }
    pid_t child = fork();
    ck_assert_int_ge(child, 0);
    if (child == 0) {
        if (!freopen("/dev/null", "r", stdin)) _exit(126);
        program_redirect(file_of("out.txt"), STDOUT_FILENO);
        program_redirect(file_of("err.txt"), STDERR_FILENO);
        execv(words[0], (char *const *)words);
        _exit(127);
    }
    return child;
}

static inline const Ran *program_finish(pid_t child) {
    static Ran ran;
    int status = 0;
    ck_assert_int_eq(waitpid(child, &status, 0), child);
    ran.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    program_read(file_of("out.txt"), ran.out);
    program_read(file_of("err.txt"), ran.err);
    return &ran;
}

/* The same with nephos. */
static inline pid_t program_start(const char *const *arguments) { return program_start_at(program_path(), arguments); }

/* The result stands in a static buffer until the next run. */
static inline const Ran *program_run(const char *const *arguments) { return program_finish(program_start(arguments)); }

#define RUN(...) program_run((const char *const[]){__VA_ARGS__, NULL})

/* Runs and insists on an exit status; shows what was said otherwise. */
#define RUN_EXPECT(expected, ...)                                                                          \
    do {                                                                                                   \
        const Ran *run_ = RUN(__VA_ARGS__);                                                                \
        ck_assert_msg(run_->status == (expected), "exit status %d, expected %d\n%s%s", run_->status, (expected), \
                      run_->out, run_->err);                                                               \
    } while (0)

/* nephos-altered is there; else the case is skipped. */
static inline int has_altered(void) {
#ifdef NPH_HAVE_BUGGED
    return 1;
#else
    nph_test_skip("nephos-altered (built without it, -Dbugs=false)");
    return 0;
#endif
}

static inline void write_text(const char *path, const char *text) {
    FILE *file = fopen(path, "wb");
    ck_assert_ptr_nonnull(file);
    fputs(text, file);
    fclose(file);
}

static inline int exists(const char *path) { return access(path, F_OK) == 0; }

static inline int same_files(const char *path_a, const char *path_b) {
    FILE *a = fopen(path_a, "rb"), *b = fopen(path_b, "rb");
    ck_assert_msg(a && b, "cannot open %s or %s", path_a, path_b);
    int x = 0, y = 0;
    do {
        x = getc(a);
        y = getc(b);
    } while (x == y && x != EOF);
    fclose(a);
    fclose(b);
    return x == y;
}

#endif
