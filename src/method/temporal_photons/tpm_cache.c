/* SPDX-License-Identifier: Apache-2.0 */
#include "method/temporal_photons/tpm_cache.h"

#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"

enum { CELLS = 16 }; /* coarse ones whose fine ones are made at once */

static int64_t blocks_of(int64_t photons) { return (photons + NPH_TPM_BLOCK - 1) / NPH_TPM_BLOCK; }

static NphStatus allocate(NphTpmCache *cache, const NphJob *job, int later) {
    NphContext *context = cache->context;
    size_t threads = (size_t)nph_context_threads(context), real = job->precision == 32 ? 4 : 8;
    size_t cells = (size_t)nph_tpm_cells(cache->choice.cells), fine = (size_t)nph_tpm_cells(cache->choice.fine);
    NPH_TRY(NPH_NEW(context, threads * (size_t)cache->values, "partial caches", &cache->added));
    NPH_TRY(NPH_NEW(context, cache->values, "partial cache", &cache->partial));
    NPH_TRY(NPH_NEW(context, cache->values, "cache", &cache->sums));
    NPH_TRY(nph_alloc(context, cells * NPH_TPM_FIELDS, real, "cells", &cache->coarse));
    NPH_TRY(nph_alloc(context, fine * NPH_TPM_FIELDS, real, "cells at the resolution of the density", &cache->fine));
    NPH_TRY(nph_alloc(context, fine, real, "densities of cells", &cache->guide));
    NPH_TRY(NPH_NEW(context, fine, "cells that are seen", &cache->seen));
    NPH_TRY(NPH_NEW(context, threads, "blocks", &cache->scratch));
    NPH_TRY(NPH_NEW(context, threads, "ledgers", &cache->ledgers));
    NPH_TRY(NPH_NEW(context, threads, "tallies", &cache->tallies));
    NPH_TRY(NPH_NEW(context, threads, "stage counts", &cache->stages));
    NPH_TRY(NPH_NEW(context, cache->choice.generations + later, "generations", &cache->shares));
    for (size_t w = 0; w < threads; w++)
        NPH_TRY(nph_alloc(context, cache->kernels.trace_bytes((int64_t)cells, cache->choice.shared), 1, "photons of a block", &cache->scratch[w]));
    return NPH_OK;
}

/* The frame's scene, and those of generations, count in the units of the reference frame's. */
static NphStatus take_units(NphTpmCache *cache, void *scene) {
    NphScene *from = NULL;
    NphJob of = cache->job;
    size_t bytes = cache->kernels.scene_bytes(0);
    if (!cache->choice.animated) return NPH_OK;
    NPH_TRY(nph_alloc(cache->context, bytes, 1, "scene of the reference frame", &cache->units));
    NPH_TRY(nph_alloc(cache->context, bytes, 1, "scene of a generation", &cache->other));
    NPH_TRY(nph_tpm_reference(&cache->job, &from));
    if (from) of.scene = from;
    of.knobs[NPH_TPM_KNOB_NOISE] = 0.0; /* nothing is marched in it */
    cache->kernels.prepare(&of, &cache->reference, cache->units);
    cache->kernels.adopt(scene, cache->units);
    nph_scene_free(cache->context, from);
    return NPH_OK;
}

static NphStatus guide_plane(void *opaque, int64_t plane, int worker) {
    const NphTpmCache *cache = opaque;
    (void)worker;
    cache->kernels.guide(cache->scene, (int)plane, (int)plane + 1, cache->guide);
    return NPH_OK;
}

static NphStatus see_plane(void *opaque, int64_t plane, int worker) {
    const NphTpmCache *cache = opaque;
    (void)worker;
    cache->kernels.guide_seen(cache->scene, cache->guide, (int)plane, (int)plane + 1, cache->seen);
    return NPH_OK;
}

static NphStatus guide(NphTpmCache *cache) {
    NPH_TRY(nph_pool_run(cache->context, cache->choice.fine[2], guide_plane, cache, NULL));
    return nph_pool_run(cache->context, cache->choice.fine[2], see_plane, cache, NULL);
}

NphStatus nph_tpm_cache_open(const NphJob *job, void *scene, int later, NphTpmCache *cache) {
    NphTpmCache made = {.context = job->context, .job = *job, .scene = scene, .other_frame = -1};
    nph_tpm_kernels(job->precision, nph_context_isa(job->context), &made.kernels);
    NPH_TRY(nph_tpm_choose(job, &made.choice, &made.reference));
    made.values = NPH_TPM_KINDS * nph_tpm_cells(made.choice.cells) * NPH_TPM_VALUES;
    NphStatus status = allocate(&made, job, later);
    if (status == NPH_OK) status = take_units(&made, scene);
    if (status == NPH_OK && made.choice.medium >= 0) status = guide(&made);
    if (status != NPH_OK) {
        nph_tpm_cache_close(&made);
        return status;
    }
    *cache = made;
    return NPH_OK;
}

void nph_tpm_cache_close(NphTpmCache *cache) {
    NphContext *context = cache->context;
    nph_scene_free(context, cache->other_scene);
    nph_free(context, cache->other);
    nph_free(context, cache->units);
    nph_free(context, cache->shares);
    for (int w = 0; cache->scratch && w < nph_context_threads(context); w++) nph_free(context, cache->scratch[w]);
    nph_free(context, cache->stages);
    nph_free(context, cache->tallies);
    nph_free(context, cache->ledgers);
    nph_free(context, cache->scratch);
    nph_free(context, cache->seen);
    nph_free(context, cache->guide);
    nph_free(context, cache->fine);
    nph_free(context, cache->coarse);
    nph_free(context, cache->sums);
    nph_free(context, cache->old_room);
    nph_free(context, cache->partial);
    nph_free(context, cache->added);
}

int64_t nph_tpm_cache_number(const NphTpmCache *cache, int generation) {
    int64_t frame = cache->choice.animated ? (int64_t)cache->job.scene->frame : (int64_t)cache->job.frame;
    return frame + cache->choice.first + generation;
}

static NphStatus load_other(NphTpmCache *cache, int64_t frame) {
    NphJob of = cache->job;
    nph_scene_free(cache->context, cache->other_scene);
    cache->other_scene = NULL;
    cache->other_frame = -1;
    NPH_TRY(nph_scene_at_frame(cache->context, cache->job.scene, (uint32_t)frame, &cache->other_scene));
    of.scene = cache->other_scene;
    of.knobs[NPH_TPM_KNOB_NOISE] = 0.0;
    NPH_TRY(nph_tpm_choose_like(&of, &cache->reference, &cache->other_choice));
    if (cache->other_choice.traced) {
        cache->kernels.prepare(&of, &cache->other_choice, cache->other);
        cache->kernels.adopt(cache->other, cache->units);
    }
    cache->other_frame = frame;
    return NPH_OK;
}

NphStatus nph_tpm_cache_enter(NphTpmCache *cache, int generation) {
    int64_t number = nph_tpm_cache_number(cache, generation), frame = number > 0 ? number : 0;
    int own = !cache->choice.animated || frame == (int64_t)cache->job.scene->frame;
    if (!own && frame != cache->other_frame) NPH_TRY(load_other(cache, frame));
    cache->generation = generation;
    cache->traced = own ? cache->scene : cache->other;
    nph_tpm_generation(&cache->reference, own ? &cache->choice : &cache->other_choice, cache->job.knobs[NPH_TPM_KNOB_VARY], number, &cache->now);
    memcpy(cache->shares[generation], cache->now.share, sizeof cache->now.share);
    return NPH_OK;
}

static NphStatus trace_block(void *opaque, int64_t number, int worker) {
    NphTpmCache *cache = opaque;
    int64_t of_sun = blocks_of(cache->now.photons[NPH_TPM_SUN]);
    int kind = number < of_sun ? NPH_TPM_SUN : NPH_TPM_SKY;
    int64_t first = (number - (kind == NPH_TPM_SKY ? of_sun : 0)) * NPH_TPM_BLOCK;
    int64_t left = cache->now.photons[kind] - first;
    NphTpmBlock block = {.sample = cache->sample,
                         .generation = (uint32_t)((int64_t)cache->job.frame + cache->choice.first + cache->generation),
                         .kind = kind,
                         .first = first,
                         .count = left < NPH_TPM_BLOCK ? (int)left : NPH_TPM_BLOCK,
                         .relative = cache->now.relative[kind],
                         .partial = cache->added + cache->values * worker + cache->values / NPH_TPM_KINDS * kind,
                         .scratch = cache->scratch[worker],
                         .ledger = &cache->ledgers[worker],
                         .tally = &cache->tallies[worker]};
    NPH_LAUNCH(&cache->stages[worker], NPH_TPM_TRACE, block.count, cache->kernels.trace(cache->traced, &block));
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
    NPH_TRY(nph_pool_run(cache->context, blocks_of(cache->now.photons[0]) + blocks_of(cache->now.photons[1]), trace_block, cache, NULL));
    for (int w = 0; w < threads; w++)
        for (int64_t i = 0; i < cache->values; i++) cache->partial[i] += cache->added[cache->values * w + i];
    return check_ledger(cache);
}

/* I - H_old + H_new. Of a frame by itself nothing grows old: it is the sum of its generations. Whole numbers, so nothing is left of
 * what goes; in print they are floats, whose roundings stay. */
static void update(NphTpmCache *cache) {
    int paper = cache->job.knobs[NPH_TPM_KNOB_VARIANT] > 0.5;
    for (int64_t i = 0; i < cache->values; i++) {
        int64_t old = cache->old ? cache->old[i] : 0;
        if (!paper) cache->sums[i] += cache->partial[i] - old;
        else {
            float left = (float)cache->sums[i] - (float)old, sum = left + (float)cache->partial[i];
            cache->sums[i] = (int64_t)sum;
        }
    }
}

static void resolve(NphTpmCache *cache) {
    double photons[NPH_TPM_KINDS] = {0.0};
    for (int g = 0; g < cache->choice.generations; g++)
        for (int k = 0; k < NPH_TPM_KINDS; k++) photons[k] += cache->shares[g][k];
    cache->kernels.resolve(cache->scene, cache->sums, photons, cache->coarse);
}

static NphStatus upsample_cells(void *opaque, int64_t number, int worker) {
    NphTpmCache *cache = opaque;
    int64_t cells = nph_tpm_cells(cache->choice.cells), first = number * CELLS, end = first + CELLS < cells ? first + CELLS : cells;
    NPH_LAUNCH(&cache->stages[worker], NPH_TPM_UPSAMPLE, end - first,
               cache->kernels.upsample(cache->scene, cache->guide, cache->seen, cache->coarse, first, end, cache->fine));
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
    for (int g = 0; g < cache->choice.generations && nph_tpm_has_photons(&cache->choice); g++) {
        NPH_TRY(nph_tpm_cache_enter(cache, g));
        NPH_TRY(nph_tpm_cache_step(cache, NPH_TPM_TRACE));
        NPH_TRY(nph_tpm_cache_step(cache, NPH_TPM_UPDATE));
    }
    NPH_TRY(nph_tpm_cache_step(cache, NPH_TPM_RESOLVE));
    return nph_tpm_cache_step(cache, NPH_TPM_UPSAMPLE);
}
