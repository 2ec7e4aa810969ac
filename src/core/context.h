/* SPDX-License-Identifier: Apache-2.0
 *
 * What a context holds; seen by core/ only. */
#ifndef NPH_CORE_CONTEXT_H
#define NPH_CORE_CONTEXT_H

#include <pthread.h>

#include "nephos/context.h"

typedef struct NphPool NphPool;

struct NphContext {
    NphSettings settings;
    NphIsa isa;
    NphPool *pool;
    pthread_mutex_t lock;         /* guards the memory counts */
    pthread_mutex_t message_lock; /* held while the callback runs, which may ask for those counts */
    uint64_t bytes, peak_bytes, allocations;
    double progress_time;
    int interrupted; /* by nph_flag_set and nph_flag_get alone */
};

/* A flag that signal handlers and other threads set. C99 has no atomics; both compilers have these. */
static inline void nph_flag_set(int *flag, int value) { __atomic_store_n(flag, value, __ATOMIC_RELAXED); }
static inline int nph_flag_get(const int *flag) { return __atomic_load_n(flag, __ATOMIC_RELAXED); }

/* pool.c: started with the context, stopped with it. */
NphStatus nph_pool_open(NphContext *context);
void nph_pool_close(NphContext *context);

#endif
