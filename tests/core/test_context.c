/* SPDX-License-Identifier: Apache-2.0
 *
 * Context, memory, arrays and the pool. */
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"
#include "harness.h"
#include "nephos/array.h"

START_TEST(memory_over_the_limit_is_refused_by_name_and_nothing_leaks) {
    NphSettings settings;
    nph_settings_default(&settings);
    settings.threads = 1;
    settings.memory_limit_bytes = 1000;
    NphContext *context = NULL;
    ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
    char *first = NULL, *second = NULL;
    ck_assert_int_eq(NPH_NEW(context, 600, "first", &first), NPH_OK);
    ck_assert_int_eq(NPH_NEW(context, 600, "second", &second), NPH_NO_MEMORY);
    ck_assert_ptr_null(second);
    ck_assert_uint_eq(nph_context_bytes(context), 600);
    nph_free(context, first);
    ck_assert_int_eq(NPH_NEW(context, 600, "second", &second), NPH_OK);
    nph_free(context, second);
    ck_assert_uint_eq(nph_context_bytes(context), 0);
    ck_assert_uint_eq(nph_context_peak_bytes(context), 600);
    nph_context_close(context);
}
END_TEST

START_TEST(the_chosen_allocation_fails) {
    NphSettings settings;
    nph_settings_default(&settings);
    settings.threads = 1;
    settings.fail_allocation = 2;
    NphContext *context = NULL;
    ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
    char *a = NULL, *b = NULL, *c = NULL;
    ck_assert_int_eq(NPH_NEW(context, 1, "a", &a), NPH_OK);
    ck_assert_int_eq(NPH_NEW(context, 1, "b", &b), NPH_NO_MEMORY);
    ck_assert_int_eq(NPH_NEW(context, 1, "c", &c), NPH_OK);
    nph_free(context, a);
    nph_free(context, c);
    nph_context_close(context);
}
END_TEST

START_TEST(overflowing_and_negative_shapes_are_refused) {
    NphContext *context = nph_test_context(1);
    NphArray array = {0};
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 2, (int64_t[]){-1, 4}, "field", &array), NPH_BAD_INPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "field"));
    int64_t huge[3] = {(int64_t)1 << 40, (int64_t)1 << 40, 2};
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 3, huge, "field", &array), NPH_BAD_INPUT);
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 7, huge, "field", &array), NPH_BAD_INPUT);
    ck_assert_ptr_null(array.data);
    ck_assert_int_eq(nph_array_new(context, NPH_F64, 2, (int64_t[]){3, 4}, "field", &array), NPH_OK);
    ck_assert_int_eq(nph_array_count(&array), 12);
    ck_assert_uint_eq((uintptr_t)array.data % 64, 0);
    nph_array_free(context, &array);
    nph_test_context_close(context);
}
END_TEST

typedef struct Count {
    int64_t seen[1000];
    NphContext *context;
} Count;

static NphStatus count_block(void *data, int64_t block, int worker) {
    Count *count = data;
    ck_assert_int_ge(worker, 0);
    ck_assert_int_lt(worker, nph_context_threads(count->context));
    count->seen[block]++;
    return NPH_OK;
}

START_TEST(every_block_runs_once_for_any_thread_count) {
    static const int threads[] = {1, 2, 3, 7};
    for (int i = 0; i < 4; i++) {
        static Count count;
        memset(&count, 0, sizeof count);
        count.context = nph_test_context(threads[i]);
        for (int repeat = 0; repeat < 50; repeat++) {
            int64_t completed = 0;
            ck_assert_int_eq(nph_pool_run(count.context, 1000, count_block, &count, &completed), NPH_OK);
            ck_assert_int_eq(completed, 1000);
        }
        for (int block = 0; block < 1000; block++) ck_assert_int_eq(count.seen[block], 50);
        nph_test_context_close(count.context);
    }
}
END_TEST

static NphStatus fail_at_500(void *data, int64_t block, int worker) {
    (void)data;
    (void)worker;
    return block == 500 ? NPH_BAD_NUMBER : NPH_OK;
}

static NphStatus interrupt_at_10(void *data, int64_t block, int worker) {
    (void)worker;
    if (block == 10) nph_interrupt(data);
    return NPH_OK;
}

START_TEST(failure_and_interruption_stop_between_blocks) {
    NphContext *context = nph_test_context(3);
    int64_t completed = 0;
    ck_assert_int_eq(nph_pool_run(context, 1000, fail_at_500, NULL, &completed), NPH_BAD_NUMBER);
    ck_assert_int_ge(completed, 501);
    ck_assert_int_eq(nph_pool_run(context, 1000, interrupt_at_10, context, &completed), NPH_INTERRUPTED);
    ck_assert_int_ge(completed, 11);
    ck_assert_int_lt(completed, 1000);
    nph_resume(context);
    ck_assert_int_eq(nph_pool_run(context, 3, interrupt_at_10, context, NULL), NPH_OK);
    nph_test_context_close(context);
}
END_TEST

START_TEST(two_contexts_live_side_by_side) {
    NphContext *a = nph_test_context(2), *b = nph_test_context(2);
    nph_interrupt(a);
    ck_assert_int_eq(nph_interrupted(a), 1);
    ck_assert_int_eq(nph_interrupted(b), 0);
    ck_assert_int_eq(nph_pool_run(b, 3, interrupt_at_10, b, NULL), NPH_OK);
    nph_test_context_close(a);
    nph_test_context_close(b);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, memory_over_the_limit_is_refused_by_name_and_nothing_leaks);
    tcase_add_test(cases, the_chosen_allocation_fails);
    tcase_add_test(cases, overflowing_and_negative_shapes_are_refused);
    tcase_add_test(cases, every_block_runs_once_for_any_thread_count);
    tcase_add_test(cases, failure_and_interruption_stop_between_blocks);
    tcase_add_test(cases, two_contexts_live_side_by_side);
}

int main(void) { return nph_test_main("context", fill); }
