/* SPDX-License-Identifier: Apache-2.0
 *
 * The context: threads, memory limit, message and progress callbacks. There is no global state: two contexts in two
 * threads work. One context is used from one thread at a time; nph_interrupt alone may be called from anywhere,
 * signal handlers included. */
#ifndef NEPHOS_CONTEXT_H
#define NEPHOS_CONTEXT_H

#include <stdint.h>

#include "nephos/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct NphContext NphContext;

typedef enum NphMessageLevel { NPH_MESSAGE_ERROR, NPH_MESSAGE_WARNING, NPH_MESSAGE_INFO } NphMessageLevel;

/* text is one UTF-8 message without a trailing newline, valid during the call only. */
typedef void (*NphMessageFn)(void *user, NphMessageLevel level, const char *text);

/* done and total are in units of the task (samples, rows); seconds_left < 0 while unknown. Called from the thread
 * that runs the task, at most about ten times a second. */
typedef void (*NphProgressFn)(void *user, const char *task, double done, double total, double seconds_left);

/* Vector levels of x86-64; elsewhere only NPH_ISA_BASE exists. All give the same bytes. */
typedef enum NphIsa { NPH_ISA_BASE = 0, NPH_ISA_AVX2 = 1, NPH_ISA_AVX512 = 2 } NphIsa;

typedef struct NphSettings {
    int threads;                  /* 0: as many as affinity and cgroup allow */
    uint64_t memory_limit_bytes;  /* 0: none */
    NphIsa isa_limit;             /* highest level used; the machine's own level bounds it further */
    NphMessageFn message;         /* NULL: messages are dropped */
    NphProgressFn progress;       /* NULL: no progress */
    void *user;                   /* handed to both callbacks */
    uint64_t fail_allocation;     /* for tests: the n-th allocation (1-based) fails; 0: none */
} NphSettings;

/* Defaults: all usable threads, no limit, highest level unless NEPHOS_ISA=base|avx2|avx512 lowers it. */
void nph_settings_default(NphSettings *settings);

/* Opens a context; *context is untouched on failure (NPH_BAD_USAGE, NPH_NO_MEMORY). Owned by the caller. */
NphStatus nph_context_open(NphContext **context, const NphSettings *settings);

/* Closes it; everything made with it must have been freed before. NULL is allowed. */
void nph_context_close(NphContext *context);

int nph_context_threads(const NphContext *context);
NphIsa nph_context_isa(const NphContext *context);
uint64_t nph_context_bytes(const NphContext *context);      /* allocated now */
uint64_t nph_context_peak_bytes(const NphContext *context); /* most allocated at once */
uint64_t nph_context_memory_limit(const NphContext *context); /* 0: none */
uint64_t nph_context_allocations(const NphContext *context); /* calls so far, for fail_allocation */
const char *nph_isa_name(NphIsa isa);
const char *nph_version(void);  /* of the library, "0.1.0" */

/* Asks the running task to stop between two blocks; async-signal-safe. nph_resume clears the request. */
void nph_interrupt(NphContext *context);
void nph_resume(NphContext *context);

#ifdef __cplusplus
}
#endif
#endif
