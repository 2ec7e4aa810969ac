/* SPDX-License-Identifier: Apache-2.0
 *
 * What a context holds; seen by core/ only. */
#ifndef NPH_CORE_CONTEXT_H
#define NPH_CORE_CONTEXT_H

#include <pthread.h>
#include <signal.h>

#include "nephos/context.h"

typedef struct NphPool NphPool;

struct NphContext {
    NphSettings settings;
    NphIsa isa;
    NphPool *pool;
    pthread_mutex_t lock; /* guards memory counts and messages */
    uint64_t bytes, peak_bytes, allocations;
    double progress_time;
    volatile sig_atomic_t interrupted;
};

/* pool.c: started with the context, stopped with it. */
NphStatus nph_pool_open(NphContext *context);
void nph_pool_close(NphContext *context);

#endif
