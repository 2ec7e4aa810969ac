/* SPDX-License-Identifier: Apache-2.0
 *
 * See machine.h. The best of many short rounds: other processes only slow down, and rarely all. */
#include "cli/machine.h"

#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"

enum { ROUNDS = 60, CALLS = 250, TRIADS = 10, TRIAD_BLOCK = 1 << 16, TRIAD_BLOCKS = 256 };

typedef struct Work {
    void (*flops)(void *restrict);
    void (*triad)(void *restrict, const void *restrict, const void *restrict, int64_t);
    void (*gather)(void *restrict, const void *restrict, const int32_t *restrict);
    char *lanes;                   /* MACHINE_LANES doubles for each worker */
    float *a, *b, *c;
    int32_t index[MACHINE_LANES];
} Work;

static NphStatus compute(void *data, int64_t block, int worker) {
    Work *work = data;
    (void)block;
    for (int i = 0; i < CALLS; i++) work->flops(work->lanes + (size_t)worker * MACHINE_LANES * sizeof(double));
    return NPH_OK;
}

static NphStatus stream(void *data, int64_t block, int worker) {
    Work *work = data;
    int64_t at = block * TRIAD_BLOCK;
    (void)worker;
    work->triad(work->a + at, work->b + at, work->c + at, TRIAD_BLOCK);
    return NPH_OK;
}

static NphStatus look_up(void *data, int64_t block, int worker) {
    Work *work = data;
    (void)block;
    for (int i = 0; i < CALLS; i++)
        work->gather(work->lanes + (size_t)worker * MACHINE_LANES * sizeof(double), work->a, work->index);
    return NPH_OK;
}

/* Most `amount` a second over the rounds. */
static NphStatus best(NphContext *context, int64_t blocks, NphBlockFn function, Work *work, double amount, double *rate) {
    int rounds = function == stream ? TRIADS : ROUNDS;
    *rate = 0;
    for (int i = 0; i < rounds; i++) {
        double began = nph_seconds();
        NPH_TRY(nph_pool_run(context, blocks, function, work, NULL));
        double seconds = nph_seconds() - began;
        if (seconds > 0 && amount / seconds > *rate) *rate = amount / seconds;
    }
    return NPH_OK;
}

static NphStatus measure(NphContext *context, Work *work, Machine *machine) {
    NphIsa isa = nph_context_isa(context);
    int64_t threads = nph_context_threads(context);
    double amount = (double)threads * CALLS * MACHINE_LANES * MACHINE_LANE_FLOPS;
    NPH_KERNEL_PICK(work->flops, nph_machine_flops, isa, 32);
    NPH_TRY(best(context, threads, compute, work, amount, &machine->flops_f32));
    NPH_KERNEL_PICK(work->flops, nph_machine_flops, isa, 64);
    NPH_TRY(best(context, threads, compute, work, amount, &machine->flops_f64));
    NPH_KERNEL_PICK(work->triad, nph_machine_triad, isa, 32);
    NPH_TRY(best(context, TRIAD_BLOCKS, stream, work, 3.0 * sizeof(float) * TRIAD_BLOCK * TRIAD_BLOCKS, &machine->bytes_per_second));
    NPH_KERNEL_PICK(work->gather, nph_machine_gather, isa, 32);
    for (int i = 0; i < MACHINE_LANES; i++) work->index[i] = (int32_t)((uint32_t)i * 2654435761u >> 17); /* below half the table */
    return best(context, threads, look_up, work, (double)threads * CALLS * MACHINE_LANES * MACHINE_LOOKS, &machine->gathers_per_second);
}

NphStatus machine_measure(NphContext *context, Machine *machine) {
    Work work = {0};
    size_t count = (size_t)TRIAD_BLOCK * TRIAD_BLOCKS;
    NphStatus status = nph_alloc(context, (size_t)nph_context_threads(context) * MACHINE_LANES, sizeof(double), "lanes",
                                 (void **)&work.lanes);
    if (status == NPH_OK) status = NPH_NEW(context, count, "triad", &work.a);
    if (status == NPH_OK) status = NPH_NEW(context, count, "triad", &work.b);
    if (status == NPH_OK) status = NPH_NEW(context, count, "triad", &work.c);
    if (status == NPH_OK) status = measure(context, &work, machine);
    nph_free(context, work.lanes);
    nph_free(context, work.a);
    nph_free(context, work.b);
    nph_free(context, work.c);
    return status;
}
