/* SPDX-License-Identifier: Apache-2.0 */
#include "method/temporal_photons/tpm_cache.h"

#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"

enum { CELLS = 16 }; /* coarse ones whose fine ones are made at once */

static int64_t blocks_of(int64_t photons) { return (photons + NPH_TPM_BLOCK - 1) / NPH_TPM_BLOCK; }

static NphStatus allocate(NphTpmCache *cache, const NphJob *job) {
    NphContext *context = cache->context;
    size_t threads = (size_t)nph_context_threads(context), real = job->precision == 32 ? 4 : 8;
    size_t cells = (size_t)nph_tpm_cells(cache->choice.cells), fine = (size_t)nph_tpm_cells(cache->choice.fine);
    NPH_TRY(NPH_NEW(context, threads * (size_t)cache->values, "partial caches", &cache->added));
    NPH_TRY(NPH_NEW(context, cache->values, "partial cache", &cache->partial));
    NPH_TRY(NPH_NEW(context, cache->values, "cache", &cache->sums));
    NPH_TRY(nph_alloc(context, cells * NPH_TPM_FIELDS, real, "cells", &cache->coarse));
    NPH_TRY(nph_alloc(context, fine * NPH_TPM_FIELDS, real, "cells at the resolution of the density", &cache->fine));
    NPH_TRY(NPH_NEW(context, threads, "blocks", &cache->scratch));
    NPH_TRY(NPH_NEW(context, threads, "ledgers", &cache->ledgers));
    NPH_TRY(NPH_NEW(context, threads, "tallies", &cache->tallies));
    NPH_TRY(NPH_NEW(context, threads, "stage counts", &cache->stages));
    for (size_t w = 0; w < threads; w++)
        NPH_TRY(nph_alloc(context, cache->kernels.trace_bytes((int64_t)cells, cache->choice.shared), 1, "photons of a block", &cache->scratch[w]));
    return NPH_OK;
}

NphStatus nph_tpm_cache_open(const NphJob *job, const NphTpmChoice *choice, const void *scene, NphTpmCache *cache) {
    NphTpmCache made = {.context = job->context, .choice = *choice, .scene = scene, .frame = job->frame};
    nph_tpm_kernels(job->precision, nph_context_isa(job->context), &made.kernels);
    made.values = NPH_TPM_KINDS * nph_tpm_cells(choice->cells) * NPH_TPM_VALUES;
    for (int k = 0; k < NPH_TPM_KINDS; k++) made.blocks[k] = blocks_of(choice->photons[k]);
    NphStatus status = allocate(&made, job);
    if (status != NPH_OK) {
        nph_tpm_cache_close(&made);
        return status;
    }
    *cache = made;
    return NPH_OK;
}

void nph_tpm_cache_close(NphTpmCache *cache) {
    NphContext *context = cache->context;
    for (int w = 0; cache->scratch && w < nph_context_threads(context); w++) nph_free(context, cache->scratch[w]);
    nph_free(context, cache->stages);
    nph_free(context, cache->tallies);
    nph_free(context, cache->ledgers);
    nph_free(context, cache->scratch);
    nph_free(context, cache->fine);
    nph_free(context, cache->coarse);
    nph_free(context, cache->sums);
    nph_free(context, cache->partial);
    nph_free(context, cache->added);
}

static NphStatus trace_block(void *opaque, int64_t number, int worker) {
    NphTpmCache *cache = opaque;
    int kind = number < cache->blocks[NPH_TPM_SUN] ? NPH_TPM_SUN : NPH_TPM_SKY;
    int64_t first = (number - (kind == NPH_TPM_SKY ? cache->blocks[NPH_TPM_SUN] : 0)) * NPH_TPM_BLOCK;
    int64_t left = cache->choice.photons[kind] - first;
    NphTpmBlock block = {.sample = cache->sample,
                         .generation = (uint32_t)(cache->frame + cache->choice.first + cache->generation),
                         .kind = kind,
                         .first = first,
                         .count = left < NPH_TPM_BLOCK ? (int)left : NPH_TPM_BLOCK,
                         .partial = cache->added + cache->values * worker + cache->values / NPH_TPM_KINDS * kind,
                         .scratch = cache->scratch[worker],
                         .ledger = &cache->ledgers[worker],
                         .tally = &cache->tallies[worker]};
    NPH_LAUNCH(&cache->stages[worker], NPH_TPM_TRACE, block.count, cache->kernels.trace(cache->scene, &block));
    return NPH_OK;
}

void nph_tpm_cache_ledger(const NphTpmCache *cache, NphTpmLedger *sum) {
    memset(sum, 0, sizeof *sum);
    for (int w = 0; w < nph_context_threads(cache->context); w++) {
        const NphTpmLedger *l = &cache->ledgers[w];
        sum->emitted += l->emitted;
        sum->escaped += l->escaped;
        sum->absorbed += l->absorbed;
        sum->stopped += l->stopped;
        sum->begun += l->begun;
        sum->collided += l->collided;
        sum->past += l->past;
        sum->cut += l->cut;
        sum->photons += l->photons;
        sum->beams += l->beams;
        sum->deposits += l->deposits;
        sum->overflow += l->overflow;
        sum->nonfinite += l->nonfinite;
    }
}

/* A value that 64 bits do not hold, or that is no number, was left out: nothing of it stays in the cache, and the run fails. */
static NphStatus check_ledger(const NphTpmCache *cache) {
    NphTpmLedger sum;
    nph_tpm_cache_ledger(cache, &sum);
    if (sum.nonfinite)
        return nph_error(cache->context, NPH_BAD_NUMBER, "temporal_photons: %lld deposits are not finite", (long long)sum.nonfinite);
    if (sum.overflow)
        return nph_error(cache->context, NPH_BAD_NUMBER,
                         "temporal_photons: %lld deposits do not fit 64-bit fixed point of %d bits below the unit", (long long)sum.overflow,
                         cache->choice.scale);
    return NPH_OK;
}

/* The workers' parts of H are whole numbers: their order is nobody's business. */
static NphStatus trace(NphTpmCache *cache) {
    int threads = nph_context_threads(cache->context);
    memset(cache->added, 0, (size_t)cache->values * sizeof *cache->added * (size_t)threads);
    memset(cache->partial, 0, (size_t)cache->values * sizeof *cache->partial);
    if (cache->choice.traced)
        NPH_TRY(nph_pool_run(cache->context, cache->blocks[0] + cache->blocks[1], trace_block, cache, NULL));
    for (int w = 0; w < threads; w++)
        for (int64_t i = 0; i < cache->values; i++) cache->partial[i] += cache->added[cache->values * w + i];
    return check_ledger(cache);
}

/* I + H_new. Of a frame by itself nothing grows old: it is the sum of its generations. */
static void update(NphTpmCache *cache) {
    for (int64_t i = 0; i < cache->values; i++) cache->sums[i] += cache->partial[i];
}

static void resolve(NphTpmCache *cache) {
    int64_t photons[NPH_TPM_KINDS];
    for (int k = 0; k < NPH_TPM_KINDS; k++) photons[k] = cache->choice.photons[k] * cache->choice.generations;
    cache->kernels.resolve(cache->scene, cache->sums, photons, cache->coarse);
}

static NphStatus upsample_cells(void *opaque, int64_t number, int worker) {
    NphTpmCache *cache = opaque;
    int64_t cells = nph_tpm_cells(cache->choice.cells), first = number * CELLS, end = first + CELLS < cells ? first + CELLS : cells;
    NPH_LAUNCH(&cache->stages[worker], NPH_TPM_UPSAMPLE, end - first,
               cache->kernels.upsample(cache->scene, cache->coarse, first, end, cache->fine));
    return NPH_OK;
}

NphStatus nph_tpm_cache_step(NphTpmCache *cache, NphTpmStage stage) {
    NphStageCounts *counts = &cache->stages[0];
    int64_t cells = nph_tpm_cells(cache->choice.cells);
    if (cache->choice.medium < 0) return NPH_OK; /* nothing is looked up */
    switch (stage) {
    case NPH_TPM_CLEAR:
        NPH_LAUNCH(counts, stage, cache->values, memset(cache->sums, 0, (size_t)cache->values * sizeof *cache->sums));
        return NPH_OK;
    case NPH_TPM_TRACE: return trace(cache);
    case NPH_TPM_UPDATE: NPH_LAUNCH(counts, stage, cache->values, update(cache)); return NPH_OK;
    case NPH_TPM_RESOLVE: NPH_LAUNCH(counts, stage, cells, resolve(cache)); return NPH_OK;
    default: return nph_pool_run(cache->context, (cells + CELLS - 1) / CELLS, upsample_cells, cache, NULL);
    }
}

NphStatus nph_tpm_cache_make(NphTpmCache *cache, uint32_t sample) {
    cache->sample = sample;
    NPH_TRY(nph_tpm_cache_step(cache, NPH_TPM_CLEAR));
    for (cache->generation = 0; cache->generation < cache->choice.generations && cache->choice.traced; cache->generation++) {
        NPH_TRY(nph_tpm_cache_step(cache, NPH_TPM_TRACE));
        NPH_TRY(nph_tpm_cache_step(cache, NPH_TPM_UPDATE));
    }
    NPH_TRY(nph_tpm_cache_step(cache, NPH_TPM_RESOLVE));
    return nph_tpm_cache_step(cache, NPH_TPM_UPSAMPLE);
}
