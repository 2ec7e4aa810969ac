/* SPDX-License-Identifier: Apache-2.0
 *
 * Accounted, 64-byte aligned memory of a context: a settable limit, a count of calls, and an injectable failure.
 * Thread-safe. Every allocation is named so that a refusal says what was too large. */
#ifndef NPH_CORE_MEMORY_H
#define NPH_CORE_MEMORY_H

#include <stddef.h>

#include "nephos/context.h"

/* Allocates count * size bytes, zeroed (overflow is checked); a zero product gives a valid pointer. Reports and
 * returns NPH_NO_MEMORY on failure, *out untouched. */
NphStatus nph_alloc(NphContext *context, size_t count, size_t size, const char *what, void **out);

/* Grows an allocation to count * size bytes, keeping its contents; the new part is zeroed. *inout NULL is allowed. */
NphStatus nph_realloc(NphContext *context, size_t count, size_t size, const char *what, void **inout);

/* Frees what nph_alloc gave; NULL is allowed. */
void nph_free(NphContext *context, void *pointer);

/* Copies a string. */
NphStatus nph_strdup(NphContext *context, const char *text, char **out);

/* NPH_NEW(context, n, "what", &pointer): typed, n elements. */
#define NPH_NEW(context, count, what, pointer_address) \
    nph_alloc((context), (size_t)(count), sizeof **(pointer_address), (what), (void **)(pointer_address))

#endif
