/* SPDX-License-Identifier: Apache-2.0
 *
 * A 64-byte header before each allocation holds its size; the counts stand under the context's lock. */
#include "core/memory.h"

#include <stdlib.h>
#include <string.h>

#include "core/context.h"
#include "core/message.h"

enum { NPH_ALIGNMENT = 64 };

typedef struct Header {
    size_t bytes;
} Header;

static Header *header_of(void *pointer) { return (Header *)(void *)((char *)pointer - NPH_ALIGNMENT); }

static double mebibytes(uint64_t bytes) { return (double)bytes / 1048576.0; }

/* Counts the allocation before it is made; 0 when the limit or an injected failure forbids it. */
static int reserve(NphContext *context, size_t bytes) {
    int allowed = 1;
    pthread_mutex_lock(&context->lock);
    context->allocations++;
    uint64_t limit = context->settings.memory_limit_bytes;
    if (context->allocations == context->settings.fail_allocation) allowed = 0;
    if (limit && (bytes > limit || context->bytes > limit - bytes)) allowed = 0;
    if (allowed) {
        context->bytes += bytes;
        if (context->bytes > context->peak_bytes) context->peak_bytes = context->bytes;
    }
    pthread_mutex_unlock(&context->lock);
    return allowed;
}

static void release(NphContext *context, size_t bytes) {
    pthread_mutex_lock(&context->lock);
    context->bytes -= bytes;
    pthread_mutex_unlock(&context->lock);
}

static NphStatus refuse(NphContext *context, const char *what, size_t count, size_t size) {
    double wanted = (double)count * (double)size / 1048576.0;
    if (context->settings.memory_limit_bytes)
        return nph_error(context, NPH_NO_MEMORY, "out of memory: %s needs %.1f MiB (in use %.1f MiB, limit %.1f MiB)",
                         what, wanted, mebibytes(nph_context_bytes(context)),
                         mebibytes(context->settings.memory_limit_bytes));
    return nph_error(context, NPH_NO_MEMORY, "out of memory: %s needs %.1f MiB (in use %.1f MiB)", what, wanted,
                     mebibytes(nph_context_bytes(context)));
}

NphStatus nph_alloc(NphContext *context, size_t count, size_t size, const char *what, void **out) {
    if (size && count > (SIZE_MAX / 2 - NPH_ALIGNMENT) / size) return refuse(context, what, count, size);
    size_t bytes = count * size;
    if (!reserve(context, bytes)) return refuse(context, what, count, size);
    void *block = NULL;
    if (posix_memalign(&block, NPH_ALIGNMENT, bytes + NPH_ALIGNMENT) != 0) {
        release(context, bytes);
        return refuse(context, what, count, size);
    }
    memset(block, 0, bytes + NPH_ALIGNMENT);
    ((Header *)block)->bytes = bytes;
    *out = (char *)block + NPH_ALIGNMENT;
    return NPH_OK;
}

NphStatus nph_realloc(NphContext *context, size_t count, size_t size, const char *what, void **inout) {
    void *grown = NULL;
    NPH_TRY(nph_alloc(context, count, size, what, &grown));
    if (*inout) {
        size_t old = header_of(*inout)->bytes, now = header_of(grown)->bytes;
        memcpy(grown, *inout, old < now ? old : now);
        nph_free(context, *inout);
    }
    *inout = grown;
    return NPH_OK;
}

void nph_free(NphContext *context, void *pointer) {
    if (!pointer) return;
    release(context, header_of(pointer)->bytes);
    free(header_of(pointer));
}

NphStatus nph_strdup(NphContext *context, const char *text, char **out) {
    char *copy = NULL;
    NPH_TRY(NPH_NEW(context, strlen(text) + 1, "text", &copy));
    strcpy(copy, text);
    *out = copy;
    return NPH_OK;
}
