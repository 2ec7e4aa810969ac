/* SPDX-License-Identifier: Apache-2.0
 *
 * The pool and the messages under several threads: interruption from outside, failures, floating-point state, signals;
 * and the default number of threads. */
#define _XOPEN_SOURCE 700
#include <fenv.h>
#include <float.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

#include "core/float_state.h"
#include "core/message.h"
#include "core/pool.h"
#include "core/usable.h"
#include "harness.h"

typedef struct Job {
    NphContext *context;
    int64_t seen[4096];
    double values[4096];
} Job;

static NphStatus count_block(void *data, int64_t block, int worker) {
    Job *job = data;
    (void)worker;
    job->seen[block]++;
    return NPH_OK;
}

START_TEST(no_blocks_are_no_work) {
    NphContext *context = nph_test_context(3);
    int64_t completed = -1;
    ck_assert_int_eq(nph_pool_run(context, 0, count_block, NULL, &completed), NPH_OK);
    ck_assert_int_eq(completed, 0);
    nph_interrupt(context);
    ck_assert_int_eq(nph_pool_run(context, 5, count_block, NULL, &completed), NPH_INTERRUPTED);
    ck_assert_int_eq(completed, 0);
    nph_test_context_close(context);
}
END_TEST

static NphStatus fail_two_kinds(void *data, int64_t block, int worker) {
    (void)data, (void)worker;
    if (block == 40) {
        struct timespec moment = {0, 2000000};
        nanosleep(&moment, NULL); /* so that later blocks fail first */
        return NPH_BAD_NUMBER;
    }
    return block > 40 ? NPH_NO_MEMORY : NPH_OK;
}

START_TEST(the_failing_block_with_the_lowest_number_wins_however_late) {
    for (int threads = 1; threads <= 7; threads += 3) {
        NphContext *context = nph_test_context(threads);
        for (int repeat = 0; repeat < 10; repeat++)
            ck_assert_int_eq(nph_pool_run(context, 1000, fail_two_kinds, NULL, NULL), NPH_BAD_NUMBER);
        nph_test_context_close(context);
    }
}
END_TEST

static NphStatus slow_block(void *data, int64_t block, int worker) {
    struct timespec moment = {0, 100000};
    nanosleep(&moment, NULL);
    return count_block(data, block, worker);
}

static void *interrupt_soon(void *argument) {
    struct timespec moment = {0, 5000000};
    nanosleep(&moment, NULL);
    nph_interrupt(argument);
    return NULL;
}

START_TEST(an_interrupt_from_another_thread_leaves_exactly_the_first_blocks_done) {
    static Job job;
    job.context = nph_test_context(3);
    for (int repeat = 0; repeat < 5; repeat++) {
        pthread_t thread;
        int64_t completed = 0;
        memset(job.seen, 0, sizeof job.seen);
        nph_resume(job.context);
        ck_assert_int_eq(pthread_create(&thread, NULL, interrupt_soon, job.context), 0);
        ck_assert_int_eq(nph_pool_run(job.context, 4096, slow_block, &job, &completed), NPH_INTERRUPTED);
        ck_assert_int_eq(pthread_join(thread, NULL), 0);
        ck_assert(completed > 0 && completed < 4096);
        for (int64_t block = 0; block < 4096; block++) ck_assert_int_eq(job.seen[block], block < completed);
    }
    nph_test_context_close(job.context);
}
END_TEST

static NphStatus talk(void *data, int64_t block, int worker) {
    (void)worker;
    nph_warn(data, "block %lld of 64", (long long)block);
    return nph_context_bytes(data) == 0 ? NPH_OK : NPH_BAD_NUMBER;
}

START_TEST(messages_of_all_threads_arrive_whole) {
    NphContext *context = nph_test_context(7);
    ck_assert_int_eq(nph_pool_run(context, 64, talk, context, NULL), NPH_OK);
    char text[8192];
    int seen[64] = {0}, lines = 0;
    snprintf(text, sizeof text, "%s", nph_test_messages());
    for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n"), lines++) {
        int block = -1, end = 0;
        ck_assert_int_eq(sscanf(line, "block %d of 64%n", &block, &end), 1);
        ck_assert(end > 0 && line[end] == 0 && block >= 0 && block < 64);
        ck_assert_int_eq(seen[block]++, 0);
    }
    ck_assert_int_eq(lines, 64);
    nph_test_context_close(context);
}
END_TEST

static void ask_back(void *user, NphMessageLevel level, const char *text) {
    (void)level;
    NphContext *context = *(NphContext **)user;
    if (context)
        snprintf((char *)user + sizeof context, 32, "%s %llu", text, (unsigned long long)nph_context_bytes(context));
}

START_TEST(a_message_callback_may_ask_for_the_memory_in_use) {
    struct {
        NphContext *context;
        char text[32];
    } user = {NULL, ""};
    NphSettings settings;
    nph_settings_default(&settings);
    settings.threads = 1;
    settings.message = ask_back;
    settings.user = &user;
    ck_assert_int_eq(nph_context_open(&user.context, &settings), NPH_OK);
    nph_info(user.context, "bytes");
    ck_assert_str_eq(user.text, "bytes 0");
    nph_test_context_close(user.context);
}
END_TEST

START_TEST(a_message_too_long_is_cut_between_characters) {
    static const char *const letters[] = {"x", "\xc3\xa4", "\xe2\x82\xac", "\xf0\x9f\x98\x80"};
    for (int shift = 0; shift < 4; shift++)
        for (size_t i = 0; i < 4; i++) {
            NphContext *context = nph_test_context(1);
            char text[6000] = "";
            size_t length = strlen(letters[i]);
            memset(text, '-', (size_t)shift);
            for (size_t at = (size_t)shift; at + length < 4000; at += length) memcpy(text + at, letters[i], length);
            nph_warn(context, "%s", text);
            const char *said = nph_test_messages();
            size_t kept = strlen(said) - 1; /* without the newline */
            ck_assert_mem_eq(said, text, kept);
            ck_assert_msg((kept - (size_t)shift) % length == 0 && kept > 2047 - 4, "%zu bytes, letters of %zu", kept,
                          length);
            nph_test_context_close(context);
        }
}
END_TEST

/* 1/3 and a subnormal: different when rounding upward or flushing to zero. */
static volatile double one = 1, three = 3, smallest = DBL_MIN;
static NphStatus divide(void *data, int64_t block, int worker) {
    Job *job = data;
    (void)worker;
    job->values[block] = one / three + (smallest / 4 == 0 ? 1 : 0);
    return NPH_OK;
}

START_TEST(blocks_round_to_nearest_with_subnormals_and_the_callers_state_comes_back) {
    static Job job;
    job.context = nph_test_context(3);
    fesetround(FE_UPWARD);
#if defined(__SSE2__)
    _mm_setcsr(_mm_getcsr() | 0x8040u);
    unsigned before = _mm_getcsr() & 0xFFC0u;
#endif
    NphStatus status = nph_pool_run(job.context, 4096, divide, &job, NULL);
    int kept = fegetround() == FE_UPWARD;
#if defined(__SSE2__)
    kept = kept && (_mm_getcsr() & 0xFFC0u) == before;
    _mm_setcsr(_mm_getcsr() & ~0x8040u);
#endif
    fesetround(FE_TONEAREST);
    ck_assert(status == NPH_OK && kept);
    for (int i = 0; i < 4096; i++) ck_assert(job.values[i] == 0x1.5555555555555p-2);
    nph_test_context_close(job.context);
}
END_TEST

static int blocked[8];
static NphStatus look_at_mask(void *data, int64_t block, int worker) {
    sigset_t mask;
    struct timespec moment = {0, 1000000};
    (void)data, (void)block;
    nanosleep(&moment, NULL);
    pthread_sigmask(SIG_SETMASK, NULL, &mask);
    blocked[worker] = 1 + (sigismember(&mask, SIGINT) && sigismember(&mask, SIGTERM) && !sigismember(&mask, SIGSEGV));
    return NPH_OK;
}

START_TEST(signals_to_the_process_never_reach_a_worker) {
    NphContext *context = nph_test_context(4);
    ck_assert_int_eq(nph_pool_run(context, 64, look_at_mask, NULL, NULL), NPH_OK);
    ck_assert_int_eq(blocked[0], 1); /* the caller's own mask is as it was */
    int workers = 0;
    for (int i = 1; i < 4; i++) {
        ck_assert_int_ne(blocked[i], 1);
        workers += blocked[i] == 2;
    }
    ck_assert_int_gt(workers, 0);
    nph_test_context_close(context);
}
END_TEST

/* A folder standing for /; files below it by path. */
static char fake_root[600];
static void put(const char *path, const char *text) {
    char full[1200];
    snprintf(full, sizeof full, "%s%s", fake_root, path);
    for (char *slash = strchr(full + strlen(fake_root) + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = 0;
        mkdir(full, 0777);
        *slash = '/';
    }
    FILE *file = fopen(full, "w");
    ck_assert_ptr_nonnull(file);
    fputs(text, file);
    fclose(file);
}

static void remove_tree(void) {
    char command[700];
    snprintf(command, sizeof command, "rm -rf '%s'", fake_root);
    ck_assert_int_eq(system(command), 0);
}

START_TEST(the_least_quota_of_the_control_groups_bounds_the_threads) {
    snprintf(fake_root, sizeof fake_root, "%s", nph_test_temporary("root"));
    ck_assert_int_eq(mkdir(fake_root, 0777), 0);
    ck_assert_int_eq(nph_cgroup_threads(fake_root), 0);
    put("/proc/self/cgroup", "0::/user.slice/job\n");
    ck_assert_int_eq(nph_cgroup_threads(fake_root), 0);
    put("/sys/fs/cgroup/user.slice/job/cpu.max", "max 100000\n");
    ck_assert_int_eq(nph_cgroup_threads(fake_root), 0);
    put("/sys/fs/cgroup/user.slice/cpu.max", "350000 100000\n");
    ck_assert_int_eq(nph_cgroup_threads(fake_root), 4);
    put("/sys/fs/cgroup/user.slice/job/cpu.max", "150000 100000\n");
    ck_assert_int_eq(nph_cgroup_threads(fake_root), 2);
    put("/sys/fs/cgroup/cpu.max", "1000 100000\n");
    ck_assert_int_eq(nph_cgroup_threads(fake_root), 1);
    ck_assert_int_eq(nph_usable_threads(fake_root), 1);
    put("/sys/fs/cgroup/cpu.max", "no number\n");
    ck_assert_int_eq(nph_cgroup_threads(fake_root), 2);
    put("/proc/self/cgroup", "0::/\n");
    put("/sys/fs/cgroup/cpu.max", "300000 100000\n");
    ck_assert_int_eq(nph_cgroup_threads(fake_root), 3);
    remove_tree();
}
END_TEST

START_TEST(version_1_groups_and_containers_without_their_hosts_path_count_too) {
    snprintf(fake_root, sizeof fake_root, "%s", nph_test_temporary("root1"));
    ck_assert_int_eq(mkdir(fake_root, 0777), 0);
    put("/proc/self/cgroup", "7:cpuset:/docker/abc\n4:cpuacct,cpu:/docker/abc\n0::/\n");
    put("/sys/fs/cgroup/cpu/cpu.cfs_quota_us", "-1\n");
    put("/sys/fs/cgroup/cpu/cpu.cfs_period_us", "100000\n");
    ck_assert_int_eq(nph_cgroup_threads(fake_root), 0);
    put("/sys/fs/cgroup/cpu/cpu.cfs_quota_us", "500001\n");
    ck_assert_int_eq(nph_cgroup_threads(fake_root), 6);
    put("/proc/self/cgroup", "garbage\n\n:::\n4:cpuset:/\n");
    ck_assert_int_eq(nph_cgroup_threads(fake_root), 0);
    ck_assert_int_ge(nph_usable_threads(fake_root), 1);
    remove_tree();
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, no_blocks_are_no_work);
    tcase_add_test(cases, the_failing_block_with_the_lowest_number_wins_however_late);
    tcase_add_test(cases, an_interrupt_from_another_thread_leaves_exactly_the_first_blocks_done);
    tcase_add_test(cases, messages_of_all_threads_arrive_whole);
    tcase_add_test(cases, a_message_callback_may_ask_for_the_memory_in_use);
    tcase_add_test(cases, a_message_too_long_is_cut_between_characters);
    tcase_add_test(cases, blocks_round_to_nearest_with_subnormals_and_the_callers_state_comes_back);
    tcase_add_test(cases, signals_to_the_process_never_reach_a_worker);
    tcase_add_test(cases, the_least_quota_of_the_control_groups_bounds_the_threads);
    tcase_add_test(cases, version_1_groups_and_containers_without_their_hosts_path_count_too);
}

int main(void) { return nph_test_main("pool", fill); }
