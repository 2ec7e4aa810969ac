/* SPDX-License-Identifier: Apache-2.0
 *
 * See pool.h. The calling thread is worker 0; the others sleep between runs. One lock guards everything. */
#include "core/pool.h"

#include <assert.h>
#include <signal.h>
#include <stdlib.h>
#include <time.h>

#include "core/context.h"
#include "core/float_state.h"
#include "core/message.h"
#include "core/usable.h"

typedef struct Worker {
    NphContext *context;
    int index;
    pthread_t thread;
} Worker;

struct NphPool {
    int threads, started;
    Worker *workers;
    pthread_mutex_t lock;
    pthread_cond_t wake, idle;
    int quit, busy, running;
    uint64_t generation;
    NphBlockFn function;
    void *data;
    int64_t blocks, next, completed, failed_block;
    NphStatus failed;
};

double nph_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Runs blocks until none is left; the pool's lock is held at entry and exit. */
static void work(NphContext *context, int worker) {
    NphPool *pool = context->pool;
    while (pool->next < pool->blocks && pool->failed == NPH_OK && !nph_interrupted(context)) {
        int64_t block = pool->next++;
        pthread_mutex_unlock(&pool->lock);
        NphStatus status = pool->function(pool->data, block, worker);
        pthread_mutex_lock(&pool->lock);
        pool->completed++;
        if (status != NPH_OK && (pool->failed == NPH_OK || block < pool->failed_block)) {
            pool->failed = status;
            pool->failed_block = block;
        }
    }
}

static void *run_worker(void *argument) {
    Worker *worker = argument;
    NphPool *pool = worker->context->pool;
    NphFloatState saved;
    nph_float_state_enter(&saved);
    uint64_t seen = 0;
    pthread_mutex_lock(&pool->lock);
    for (;;) {
        while (!pool->quit && pool->generation == seen) pthread_cond_wait(&pool->wake, &pool->lock);
        if (pool->quit) break;
        seen = pool->generation;
        work(worker->context, worker->index);
        if (--pool->busy == 0) pthread_cond_signal(&pool->idle);
    }
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

/* Signals sent to the process are for the program's own threads: workers inherit a mask that leaves them only those
 * that their own instructions raise, and the profiler's. */
static void start_workers(NphContext *context) {
    static const int own[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGABRT, SIGSYS, SIGPROF};
    NphPool *pool = context->pool;
    sigset_t blocked, before;
    sigfillset(&blocked);
    for (size_t i = 0; i < sizeof own / sizeof *own; i++) sigdelset(&blocked, own[i]);
    pthread_sigmask(SIG_SETMASK, &blocked, &before);
    while (pool->started < pool->threads - 1) {
        Worker *worker = &pool->workers[pool->started + 1];
        worker->context = context;
        worker->index = pool->started + 1;
        if (pthread_create(&worker->thread, NULL, run_worker, worker) != 0) break;
        pool->started++;
    }
    pthread_sigmask(SIG_SETMASK, &before, NULL);
}

NphStatus nph_pool_open(NphContext *context) {
    NphPool *pool = calloc(1, sizeof *pool);
    if (!pool) return NPH_NO_MEMORY;
    context->pool = pool;
    pool->threads = context->settings.threads ? context->settings.threads : nph_usable_threads("");
    pool->workers = calloc((size_t)pool->threads, sizeof *pool->workers);
    if (!pool->workers) {
        free(pool);
        return NPH_NO_MEMORY;
    }
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->wake, NULL);
    pthread_cond_init(&pool->idle, NULL);
    start_workers(context);
    if (pool->started == pool->threads - 1) return NPH_OK;
    nph_error(context, NPH_NO_MEMORY, "cannot start thread %d of %d", pool->started + 2, pool->threads);
    nph_pool_close(context);
    return NPH_NO_MEMORY;
}

void nph_pool_close(NphContext *context) {
    NphPool *pool = context->pool;
    pthread_mutex_lock(&pool->lock);
    pool->quit = 1;
    pthread_cond_broadcast(&pool->wake);
    pthread_mutex_unlock(&pool->lock);
    for (int i = 1; i <= pool->started; i++) pthread_join(pool->workers[i].thread, NULL);
    pthread_cond_destroy(&pool->wake);
    pthread_cond_destroy(&pool->idle);
    pthread_mutex_destroy(&pool->lock);
    free(pool->workers);
    free(pool);
    context->pool = NULL;
}

int nph_context_threads(const NphContext *context) { return context->pool->threads; }

NphStatus nph_pool_run(NphContext *context, int64_t blocks, NphBlockFn function, void *data, int64_t *completed) {
    NphPool *pool = context->pool;
    NphFloatState saved;
    nph_float_state_enter(&saved);
    pthread_mutex_lock(&pool->lock);
    assert(!pool->running && "a block must not run blocks");
    pool->running = 1;
    pool->function = function;
    pool->data = data;
    pool->blocks = blocks;
    pool->next = pool->completed = 0;
    pool->failed = NPH_OK;
    pool->busy = pool->started;
    pool->generation++;
    pthread_cond_broadcast(&pool->wake);
    work(context, 0);
    while (pool->busy > 0) pthread_cond_wait(&pool->idle, &pool->lock);
    NphStatus status = pool->failed;
    int64_t count = pool->completed;
    pool->running = 0;
    pthread_mutex_unlock(&pool->lock);
    nph_float_state_leave(&saved);
    if (completed) *completed = count;
    if (status != NPH_OK) return status;
    return count < blocks ? NPH_INTERRUPTED : NPH_OK;
}
