/* SPDX-License-Identifier: Apache-2.0
 *
 * The thread pool: runs a function once for every block of a range. Blocks are claimed under a lock in rising order, so
 * which thread runs a block is unknown but what a block computes must not depend on it. Workers run with
 * round-to-nearest and without flush-to-zero, and the caller's floating-point state is restored. */
#ifndef NPH_CORE_POOL_H
#define NPH_CORE_POOL_H

#include <stdint.h>

#include "nephos/context.h"

/* block in [0, blocks); worker in [0, nph_context_threads): index for per-worker scratch, never for results.
 * A status other than NPH_OK stops the claiming of further blocks; the failing block with the lowest number wins. */
typedef NphStatus (*NphBlockFn)(void *data, int64_t block, int worker);

/* Runs all blocks and waits. NPH_INTERRUPTED when nph_interrupt came in between: blocks already claimed are finished,
 * and *completed (may be NULL) says how many, which are the blocks 0 .. completed-1. */
NphStatus nph_pool_run(NphContext *context, int64_t blocks, NphBlockFn function, void *data, int64_t *completed);

/* Monotonic seconds, for statistics only. */
double nph_seconds(void);

#endif
