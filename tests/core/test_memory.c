/* SPDX-License-Identifier: Apache-2.0
 *
 * Memory of a context: alignment, zeroing, overflow, growth, limit, failure, threads. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "core/pool.h"
#include "harness.h"

static const size_t sizes[] = {0, 1, 7, 63, 64, 65, 4095, 4096, 100000, (size_t)3 << 20};
enum { SIZES = sizeof sizes / sizeof *sizes };

static int all_equal(const unsigned char *bytes, size_t begin, size_t end, unsigned char value) {
    for (size_t i = begin; i < end; i++)
        if (bytes[i] != value) return 0;
    return 1;
}

START_TEST(every_size_is_aligned_to_64_zeroed_and_its_own) {
    NphContext *context = nph_test_context(1);
    for (int round = 0; round < 3; round++) { /* later rounds get memory that was written to */
        unsigned char *held[SIZES];
        uint64_t total = 0;
        for (size_t i = 0; i < SIZES; i++) {
            held[i] = NULL;
            ck_assert_int_eq(NPH_NEW(context, sizes[i], "block", &held[i]), NPH_OK);
            ck_assert_ptr_nonnull(held[i]);
            ck_assert_uint_eq((uintptr_t)held[i] % 64, 0);
            ck_assert(all_equal(held[i], 0, sizes[i], 0));
            memset(held[i], 0xA5, sizes[i]);
            total += sizes[i];
            ck_assert_uint_eq(nph_context_bytes(context), total);
        }
        for (size_t i = 0; i < SIZES; i++) {
            ck_assert(all_equal(held[i], 0, sizes[i], 0xA5));
            nph_free(context, held[i]);
        }
    }
    nph_free(context, NULL);
    nph_test_context_close(context);
}
END_TEST

START_TEST(products_that_overflow_are_refused_by_name_and_leave_everything_as_it_was) {
    static const size_t cases[][2] = {
        {SIZE_MAX, 1},
        {1, SIZE_MAX},
        {SIZE_MAX, SIZE_MAX},
        {SIZE_MAX / 2 + 1, 2},
        {SIZE_MAX / 8 + 1, 8},
        {SIZE_MAX / 8 + 2, 8},
        {(size_t)1 << 32, (size_t)1 << 32},
        {((size_t)1 << 61) + 1, 8},
        {SIZE_MAX - 63, 1},
        {SIZE_MAX / 2, 1},
        {SIZE_MAX / 2 - 63, 1},
    };
    NphContext *context = nph_test_context(1);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        void *out = &out, *kept = NULL;
        ck_assert_int_eq(nph_alloc(context, cases[i][0], cases[i][1], "voxels", &out), NPH_NO_MEMORY);
        ck_assert_ptr_eq(out, &out);
        ck_assert_ptr_nonnull(strstr(nph_test_messages(), "voxels"));
        ck_assert_int_eq(nph_alloc(context, 5, 1, "kept", &kept), NPH_OK);
        memcpy(kept, "abcd", 5);
        void *before = kept;
        ck_assert_int_eq(nph_realloc(context, cases[i][0], cases[i][1], "grown", &kept), NPH_NO_MEMORY);
        ck_assert_ptr_eq(kept, before);
        ck_assert_str_eq(kept, "abcd");
        ck_assert_uint_eq(nph_context_bytes(context), 5);
        nph_free(context, kept);
    }
    ck_assert_uint_eq(nph_context_peak_bytes(context), 5);
    nph_test_context_close(context);
}
END_TEST

START_TEST(growing_and_shrinking_keep_the_contents_and_zero_what_is_new) {
    NphContext *context = nph_test_context(1);
    for (size_t a = 0; a < SIZES; a++)
        for (size_t b = 0; b < SIZES; b++) {
            unsigned char *block = NULL;
            ck_assert_int_eq(nph_realloc(context, sizes[a], 1, "block", (void **)&block), NPH_OK);
            ck_assert(all_equal(block, 0, sizes[a], 0));
            memset(block, 0x5A, sizes[a]);
            ck_assert_int_eq(nph_realloc(context, sizes[b], 1, "block", (void **)&block), NPH_OK);
            size_t kept = sizes[a] < sizes[b] ? sizes[a] : sizes[b];
            ck_assert_uint_eq((uintptr_t)block % 64, 0);
            ck_assert(all_equal(block, 0, kept, 0x5A) && all_equal(block, kept, sizes[b], 0));
            ck_assert_uint_eq(nph_context_bytes(context), sizes[b]);
            nph_free(context, block);
        }
    nph_test_context_close(context);
}
END_TEST

START_TEST(the_limit_can_be_filled_to_the_byte_and_not_beyond) {
    NphSettings settings;
    NphContext *context = NULL;
    nph_settings_default(&settings);
    settings.threads = 1;
    settings.memory_limit_bytes = 1 << 20;
    ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
    char *half = NULL, *rest = NULL, *more = NULL, *none = NULL;
    ck_assert_int_eq(NPH_NEW(context, (1 << 20) + 1, "all and one", &more), NPH_NO_MEMORY);
    ck_assert_int_eq(NPH_NEW(context, 1 << 19, "half", &half), NPH_OK);
    ck_assert_int_eq(NPH_NEW(context, (1 << 19) + 1, "more", &more), NPH_NO_MEMORY);
    ck_assert_int_eq(NPH_NEW(context, 1 << 19, "rest", &rest), NPH_OK);
    ck_assert_int_eq(NPH_NEW(context, 1, "more", &more), NPH_NO_MEMORY);
    ck_assert_int_eq(NPH_NEW(context, 0, "none", &none), NPH_OK);
    ck_assert_uint_eq(nph_context_peak_bytes(context), 1 << 20);
    nph_free(context, half);
    ck_assert_int_eq(nph_realloc(context, (1 << 19) + 1, 1, "rest", (void **)&rest),
                     NPH_NO_MEMORY); /* both stand meanwhile */
    ck_assert_int_eq(nph_realloc(context, 1 << 19, 1, "rest", (void **)&rest), NPH_OK);
    nph_free(context, rest);
    nph_free(context, none);
    nph_test_context_close(context);
}
END_TEST

typedef struct Churn {
    NphContext *context;
    int refused[64];
} Churn;

static NphStatus churn(void *data, int64_t block, int worker) {
    Churn *job = data;
    unsigned char *held[8] = {0};
    (void)worker;
    for (int i = 0; i < 400; i++) {
        size_t size = 1 + (size_t)((block * 7919 + i * 104729) % 5000);
        unsigned char **slot = &held[i % 8];
        if (*slot && (*slot)[0] != (unsigned char)block) return NPH_BAD_NUMBER;
        nph_free(job->context, *slot);
        *slot = NULL;
        if (NPH_NEW(job->context, size, "churn", slot) == NPH_OK)
            memset(*slot, (int)block, size);
        else
            job->refused[block]++;
    }
    for (int i = 0; i < 8; i++) nph_free(job->context, held[i]);
    return NPH_OK;
}

START_TEST(threads_share_one_limit_without_exceeding_it_or_losing_count) {
    NphSettings settings;
    static Churn job;
    nph_settings_default(&settings);
    settings.threads = 7;
    settings.memory_limit_bytes = 15000; /* less than one block wants: some calls fail whatever the timing */
    ck_assert_int_eq(nph_context_open(&job.context, &settings), NPH_OK);
    ck_assert_int_eq(nph_pool_run(job.context, 64, churn, &job, NULL), NPH_OK);
    ck_assert_uint_eq(nph_context_bytes(job.context), 0);
    ck_assert_uint_le(nph_context_peak_bytes(job.context), 15000);
    int refused = 0;
    for (int i = 0; i < 64; i++) refused += job.refused[i];
    ck_assert_int_gt(refused, 0);
    ck_assert_uint_eq(nph_context_allocations(job.context), 64 * 400);
    nph_test_context_close(job.context);
}
END_TEST

START_TEST(each_chosen_call_fails_and_only_that_one) {
    for (uint64_t chosen = 1; chosen <= 6; chosen++) {
        NphSettings settings;
        NphContext *context = NULL;
        void *held = NULL;
        char *copy = NULL;
        nph_settings_default(&settings);
        settings.threads = 1;
        settings.fail_allocation = chosen;
        ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
        ck_assert_int_eq(nph_alloc(context, 10, 1, "a", &held), chosen == 1 ? NPH_NO_MEMORY : NPH_OK);
        for (uint64_t call = 2; call <= 4; call++)
            ck_assert_int_eq(nph_realloc(context, 10 * call, 1, "a", &held), chosen == call ? NPH_NO_MEMORY : NPH_OK);
        ck_assert_int_eq(nph_strdup(context, "text", &copy), chosen == 5 ? NPH_NO_MEMORY : NPH_OK);
        if (copy)
            ck_assert_str_eq(copy, "text");
        else
            ck_assert_uint_eq(chosen, 5);
        nph_free(context, copy);
        nph_free(context, held);
        nph_test_context_close(context);
    }
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, every_size_is_aligned_to_64_zeroed_and_its_own);
    tcase_add_test(cases, products_that_overflow_are_refused_by_name_and_leave_everything_as_it_was);
    tcase_add_test(cases, growing_and_shrinking_keep_the_contents_and_zero_what_is_new);
    tcase_add_test(cases, the_limit_can_be_filled_to_the_byte_and_not_beyond);
    tcase_add_test(cases, threads_share_one_limit_without_exceeding_it_or_losing_count);
    tcase_add_test(cases, each_chosen_call_fails_and_only_that_one);
}

int main(void) { return nph_test_main("memory", fill); }
