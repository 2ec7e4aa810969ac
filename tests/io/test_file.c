/* SPDX-License-Identifier: Apache-2.0
 *
 * Reading and atomic writing of whole files. A full disk is played by a limit on file sizes (the write fails with EFBIG
 * in the same calls in which a full disk fails with ENOSPC) and, where it exists, by a write error of /dev/full's kind. */
#define _POSIX_C_SOURCE 200809L
#include "io/file.h"

#include <dirent.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/memory.h"
#include "harness.h"

static void put(const char *path, const char *text) {
    FILE *file = fopen(path, "wb");
    ck_assert_ptr_nonnull(file);
    ck_assert_int_ge(fputs(text, file), 0);
    ck_assert_int_eq(fclose(file), 0);
}

static void holds(NphContext *context, const char *path, const char *text) {
    char *bytes = NULL;
    size_t size = 0;
    ck_assert_int_eq(nph_file_read(context, path, &bytes, &size), NPH_OK);
    ck_assert_uint_eq(size, strlen(text));
    ck_assert_str_eq(bytes, text);
    nph_free(context, bytes);
}

/* Names in the temporary folder that are left by a writer. */
static int temporaries(void) {
    char folder[600];
    strcpy(folder, nph_test_temporary(""));
    DIR *stream = opendir(folder);
    ck_assert_ptr_nonnull(stream);
    int count = 0;
    for (struct dirent *entry; (entry = readdir(stream));) count += strstr(entry->d_name, ".tmp") != NULL;
    closedir(stream);
    return count;
}

static void refused(NphStatus status, NphStatus expected, const char *path, const char *word) {
    const char *messages = nph_test_messages();
    ck_assert_int_eq(status, expected);
    ck_assert_msg(strstr(messages, path) != NULL, "no path in: %s", messages);
    ck_assert_msg(strstr(messages, word) != NULL, "no '%s' in: %s", word, messages);
}

START_TEST(what_is_committed_is_read_back_and_no_temporary_is_left) {
    NphContext *context = nph_test_context(1);
    const char *path = nph_test_temporary("a.txt");
    NphWriter writer;
    ck_assert_int_eq(nph_writer_open(context, path, &writer), NPH_OK);
    ck_assert_int_eq(temporaries(), 1);
    ck_assert_int_ne(access(path, F_OK), 0);
    fputs("first", writer.stream);
    ck_assert_int_eq(nph_writer_commit(context, &writer), NPH_OK);
    nph_writer_abandon(context, &writer);
    holds(context, path, "first");
    ck_assert_int_eq(nph_writer_open(context, path, &writer), NPH_OK);
    fputs("second", writer.stream);
    holds(context, path, "first");
    ck_assert_int_eq(nph_writer_commit(context, &writer), NPH_OK);
    holds(context, path, "second");
    ck_assert_int_eq(temporaries(), 0);
    nph_test_context_close(context);
}
END_TEST

START_TEST(an_abandoned_write_leaves_the_old_file) {
    NphContext *context = nph_test_context(1);
    const char *path = nph_test_temporary("b.txt");
    put(path, "old");
    NphWriter one, two;
    ck_assert_int_eq(nph_writer_open(context, path, &one), NPH_OK);
    ck_assert_int_eq(nph_writer_open(context, path, &two), NPH_OK); /* two writers do not meet */
    ck_assert_str_ne(one.temporary, two.temporary);
    fputs("half of", one.stream);
    nph_writer_abandon(context, &one);
    nph_writer_abandon(context, &two);
    holds(context, path, "old");
    ck_assert_int_eq(temporaries(), 0);
    nph_test_context_close(context);
}
END_TEST

START_TEST(folders_pipes_devices_and_missing_files_are_refused_for_reading) {
    NphContext *context = nph_test_context(1);
    char *bytes = NULL;
    size_t size = 77;
    const char *folder = nph_test_temporary(""), *pipe_ = nph_test_temporary("pipe"),
               *none = nph_test_temporary("none");
    ck_assert_int_eq(mkfifo(pipe_, 0600), 0);
    refused(nph_file_read(context, folder, &bytes, &size), NPH_BAD_INPUT, folder, "is a folder");
    refused(nph_file_read(context, pipe_, &bytes, &size), NPH_BAD_INPUT, pipe_, "not a regular file");
    refused(nph_file_read(context, "/dev/zero", &bytes, &size), NPH_BAD_INPUT, "/dev/zero", "not a regular file");
    refused(nph_file_read(context, none, &bytes, &size), NPH_BAD_INPUT, none, "No such file");
    refused(nph_file_read(context, "", &bytes, &size), NPH_BAD_INPUT, "", "No such file");
    ck_assert_ptr_null(bytes);
    ck_assert_uint_eq(size, 77);
    put(none, "");
    holds(context, none, "");
    nph_test_context_close(context);
}
END_TEST

START_TEST(bad_targets_are_refused_before_anything_is_written) {
    NphContext *context = nph_test_context(1);
    NphWriter writer;
    const char *folder = nph_test_temporary(""), *pipe_ = nph_test_temporary("pipe2");
    const char *lost = nph_test_temporary("nowhere/x.exr");
    ck_assert_int_eq(mkfifo(pipe_, 0600), 0);
    refused(nph_writer_open(context, folder, &writer), NPH_BAD_OUTPUT, folder, "is a folder");
    refused(nph_writer_open(context, pipe_, &writer), NPH_BAD_OUTPUT, pipe_, "not a regular file");
    refused(nph_writer_open(context, "/dev/null", &writer), NPH_BAD_OUTPUT, "/dev/null", "not a regular file");
    refused(nph_writer_open(context, lost, &writer), NPH_BAD_OUTPUT, lost, "No such file");
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_symbolic_link_stays_and_its_file_is_replaced) {
    NphContext *context = nph_test_context(1);
    const char *path = nph_test_temporary("real.txt"), *link_ = nph_test_temporary("link.txt");
    put(path, "old");
    ck_assert_int_eq(symlink("real.txt", link_), 0);
    NphWriter writer;
    ck_assert_int_eq(nph_writer_open(context, link_, &writer), NPH_OK);
    fputs("new", writer.stream);
    ck_assert_int_eq(nph_writer_commit(context, &writer), NPH_OK);
    holds(context, path, "new");
    struct stat facts;
    ck_assert_int_eq(lstat(link_, &facts), 0);
    ck_assert(S_ISLNK(facts.st_mode));
    nph_test_context_close(context);
}
END_TEST

static void limit_file_size(rlim_t bytes) {
    signal(SIGXFSZ, SIG_IGN);
    struct rlimit limit;
    ck_assert_int_eq(getrlimit(RLIMIT_FSIZE, &limit), 0);
    limit.rlim_cur = bytes;
    ck_assert_int_eq(setrlimit(RLIMIT_FSIZE, &limit), 0);
}

START_TEST(a_full_disk_is_reported_with_its_reason_and_the_old_file_stays) {
    NphContext *context = nph_test_context(1);
    const char *path = nph_test_temporary("c.txt");
    put(path, "old");
    limit_file_size(10000);
    static const size_t sizes[] = {10001, 12000, 1 << 20}; /* fails in the last flush, and long before it */
    for (int i = 0; i < 3; i++) {
        NphWriter writer;
        ck_assert_int_eq(nph_writer_open(context, path, &writer), NPH_OK);
        for (size_t byte = 0; byte < sizes[i]; byte++) putc('x', writer.stream);
        refused(nph_writer_commit(context, &writer), NPH_BAD_OUTPUT, path, "File too large");
        nph_writer_abandon(context, &writer);
    }
    holds(context, path, "old");
    ck_assert_int_eq(temporaries(), 0);
    nph_test_context_close(context);
}
END_TEST

START_TEST(every_failing_allocation_is_reported_and_nothing_leaks) {
    const char *path = nph_test_temporary("d.txt");
    put(path, "old");
    int failures = 0;
    for (uint64_t nth = 1; nth < 10; nth++) {
        NphSettings settings;
        nph_settings_default(&settings);
        settings.threads = 1;
        settings.fail_allocation = nth;
        NphContext *context = NULL;
        ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
        NphWriter writer;
        NphStatus status = nph_writer_open(context, path, &writer);
        if (status == NPH_OK) nph_writer_abandon(context, &writer);
        failures += status == NPH_NO_MEMORY;
        char *bytes = NULL;
        size_t size;
        status = nph_file_read(context, path, &bytes, &size);
        if (status == NPH_OK) nph_free(context, bytes);
        failures += status == NPH_NO_MEMORY;
        nph_test_context_close(context);
    }
    ck_assert_int_eq(failures, 3);
    ck_assert_int_eq(temporaries(), 0);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, what_is_committed_is_read_back_and_no_temporary_is_left);
    tcase_add_test(cases, an_abandoned_write_leaves_the_old_file);
    tcase_add_test(cases, folders_pipes_devices_and_missing_files_are_refused_for_reading);
    tcase_add_test(cases, bad_targets_are_refused_before_anything_is_written);
    tcase_add_test(cases, a_symbolic_link_stays_and_its_file_is_replaced);
    tcase_add_test(cases, a_full_disk_is_reported_with_its_reason_and_the_old_file_stays);
    tcase_add_test(cases, every_failing_allocation_is_reported_and_nothing_leaks);
}

int main(void) { return nph_test_main("file", fill); }
