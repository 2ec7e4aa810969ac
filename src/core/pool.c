/* SPDX-License-Identifier: Apache-2.0
 *
 * See pool.h. The calling thread is worker 0; the others sleep between runs. One lock guards everything. */
#define _GNU_SOURCE
#include "core/pool.h"

#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "core/context.h"
#include "core/float_state.h"
#include "core/message.h"

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
    int quit, busy;
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

/* cpu.max of the process's cgroup: "quota period" in microseconds, or "max". */
static int cgroup_threads(void) {
    FILE *file = fopen("/sys/fs/cgroup/cpu.max", "r");
    if (!file) return 0;
    long quota = 0, period = 0;
    int read = fscanf(file, "%ld %ld", &quota, &period);
    fclose(file);
    if (read != 2 || quota <= 0 || period <= 0) return 0;
    return (int)((quota + period - 1) / period);
}

static int usable_threads(void) {
    cpu_set_t set;
    int count = 1;
    if (sched_getaffinity(0, sizeof set, &set) == 0) count = CPU_COUNT(&set);
    int limit = cgroup_threads();
    if (limit > 0 && limit < count) count = limit;
    return count > 0 ? count : 1;
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

NphStatus nph_pool_open(NphContext *context) {
    NphPool *pool = calloc(1, sizeof *pool);
    if (!pool) return NPH_NO_MEMORY;
    context->pool = pool;
    pool->threads = context->settings.threads ? context->settings.threads : usable_threads();
    pool->workers = calloc((size_t)pool->threads, sizeof *pool->workers);
    if (!pool->workers) {
        free(pool);
        return NPH_NO_MEMORY;
    }
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->wake, NULL);
    pthread_cond_init(&pool->idle, NULL);
    for (int i = 1; i < pool->threads; i++) {
        Worker *worker = &pool->workers[i];
        worker->context = context;
        worker->index = i;
        if (pthread_create(&worker->thread, NULL, run_worker, worker) != 0) {
            nph_error(context, NPH_NO_MEMORY, "cannot start thread %d of %d", i + 1, pool->threads);
            nph_pool_close(context);
            return NPH_NO_MEMORY;
        }
        pool->started++;
    }
    return NPH_OK;
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
    pthread_mutex_unlock(&pool->lock);
    nph_float_state_leave(&saved);
    if (completed) *completed = count;
    if (status != NPH_OK) return status;
    return count < blocks ? NPH_INTERRUPTED : NPH_OK;
}
