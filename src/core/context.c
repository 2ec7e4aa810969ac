/* SPDX-License-Identifier: Apache-2.0
 *
 * Opening and closing of a context. */
#include "core/context.h"

#include <stdlib.h>
#include <string.h>

#include "core/cpu.h"
#include "core/message.h"

void nph_settings_default(NphSettings *settings) {
    memset(settings, 0, sizeof *settings);
    settings->isa_limit = NPH_ISA_AVX512;
    const char *word = getenv("NEPHOS_ISA");
    if (word) nph_isa_parse(word, &settings->isa_limit); /* the program refuses other words */
}

static void discard(NphContext *context) {
    pthread_mutex_destroy(&context->lock);
    pthread_mutex_destroy(&context->message_lock);
    free(context);
}

NphStatus nph_context_open(NphContext **context, const NphSettings *settings) {
    if (settings->threads < 0 || settings->threads > 1024) return NPH_BAD_USAGE;
    if (settings->isa_limit > NPH_ISA_AVX512) return NPH_BAD_USAGE;
    NphContext *made = calloc(1, sizeof *made);
    if (!made) return NPH_NO_MEMORY;
    made->settings = *settings;
    made->isa = nph_cpu_isa();
    if (made->isa > settings->isa_limit) made->isa = settings->isa_limit;
    pthread_mutex_init(&made->lock, NULL); /* cannot fail with default attributes */
    pthread_mutex_init(&made->message_lock, NULL);
    NphStatus status = nph_pool_open(made);
    if (status != NPH_OK) {
        discard(made);
        return status;
    }
    *context = made;
    return NPH_OK;
}

void nph_context_close(NphContext *context) {
    if (!context) return;
    nph_pool_close(context);
    discard(context);
}

const char *nph_version(void) { return NPH_VERSION; }
NphIsa nph_context_isa(const NphContext *context) { return context->isa; }
uint64_t nph_context_memory_limit(const NphContext *context) { return context->settings.memory_limit_bytes; }

static uint64_t locked(const NphContext *context, const uint64_t *count) {
    pthread_mutex_t *lock = (pthread_mutex_t *)&context->lock;
    pthread_mutex_lock(lock);
    uint64_t value = *count;
    pthread_mutex_unlock(lock);
    return value;
}

uint64_t nph_context_bytes(const NphContext *context) { return locked(context, &context->bytes); }
uint64_t nph_context_peak_bytes(const NphContext *context) { return locked(context, &context->peak_bytes); }
uint64_t nph_context_allocations(const NphContext *context) { return locked(context, &context->allocations); }

void nph_interrupt(NphContext *context) { nph_flag_set(&context->interrupted, 1); }
void nph_resume(NphContext *context) { nph_flag_set(&context->interrupted, 0); }
int nph_interrupted(const NphContext *context) { return nph_flag_get(&context->interrupted); }
