/* SPDX-License-Identifier: Apache-2.0
 *
 * method/temporal_photons as a method: its knobs, stages and buffers, the run over samples, statistics and replay. */
#include "method/temporal_photons/tpm.h"

#include <stdio.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"
#include "method/temporal_photons/tpm_cache.h"

static const NphKnob knobs[NPH_TPM_KNOBS] = {
    {"tpm.variant", "1", "0: corrected, from the transport equation; 1: paper, the formulas as printed", "nothing: to compare", 0.0, 0.0, 1.0},
    {"tpm.photons", "1", "photons of all generations together", "noise against time", 819200.0, 1.0, 1e9},
    {"tpm.generations", "1", "generations that make a frame", "noise of a frame against how old its light is", 100.0, 1.0,
     NPH_TPM_GENERATIONS_MAX},
    {"tpm.primed", "1", "1: before frame 0 the scene stood still; 0: there was nothing, early frames have fewer generations",
     "noise of the first frames against time", 1.0, 0.0, 1.0},
    {"tpm.cells", "1", "most cells of the coarse grid, near to cubes", "blur against noise", 2400.0, 1.0, NPH_TPM_CELLS_MAX},
    {"tpm.cells_x", "1", "cells along x of the medium's box; 0: as tpm.cells says", "blur against noise", 0.0, 0.0, 4096.0},
    {"tpm.cells_y", "1", "cells along y", "blur against noise", 0.0, 0.0, 4096.0},
    {"tpm.cells_z", "1", "cells along z", "blur against noise", 0.0, 0.0, 4096.0},
    {"tpm.threshold", "1", "a beam ends when less than this is left of it", "bias against time", 0.01, 0.0, 1.0},
    {"tpm.similarity", "1", "scattering becomes isotropic when |g|^order falls below this; 0: never", "bias against time", 0.05, 0.0, 1.0},
    {"tpm.sky_lobe", "1", "1: the sky's light has a lobe of its own; 0: it is the same from all sides", "bias of lopsided skies", 0.0, 0.0, 1.0},
    {"tpm.upsampling", "1", "0: linear interpolation; 1: joint bilateral, Gaussians; 2: by transmittance and density", "blur against time", 2.0, 0.0, 2.0},
    {"tpm.neighbourhood", "1", "cells on either side that upsampling looks at", "blur against time", 1.0, 1.0, 2.0},
    {"tpm.spread", "1", "standard deviation of the Gaussian in space, over the neighbourhood's radius", "blur against noise", 0.4, 0.01, 10.0},
    {"tpm.spread_density", "1", "standard deviation of the Gaussian in density, over the largest", "blur against noise", 0.25, 0.001, 10.0},
    {"tpm.steps", "1", "steps of the march along the diagonal of the box", "bias against time", 300.0, 1.0, 1e6},
    {"tpm.exit", "1", "a ray ends when its transmittance falls below this", "bias against time", 0.02, 0.0, 1.0},
    {"tpm.noise", "1", "size of the noise that moves lookups, in voxels of the density (of a box, metres)", "detail that the density does not have", 0.0, 0.0, 100.0},
    {"tpm.octaves", "1", "octaves of that noise", "detail against time", 3.0, 0.0, 8.0},
    {"tpm.half", "1", "1: half the resolution is marched, in both dimensions; 0: every pixel", "blur against time", 1.0, 0.0, 1.0},
};

static const NphStage stages[NPH_TPM_STAGES] = {
    {"tpm.trace", "photon tracing and storing [Elek12 sec. 4.1]; delta tracking [Woodcock65]", "", "tpm.partial", {NPH_TPM_BLOCK, 1, 1},
     NPH_TPM_SHARED_CELLS * 5 * 4},
    {"tpm.update", "circular buffer of generations [Elek12 sec. 4.2]", "tpm.partial", "tpm.sum", {NPH_TPM_BLOCK, 1, 1}, 0},
    {"tpm.resolve", "mean cosine and depth of a cell [Elek12 sec. 4.1.2]", "tpm.sum", "tpm.coarse", {NPH_TPM_BLOCK, 1, 1}, 0},
    {"tpm.upsample", "upsampling guided by the density [Elek12 sec. 4.3]", "tpm.coarse", "tpm.fine", {NPH_TPM_BLOCK, 1, 1}, 0},
    {"tpm.march", "ray march and reconstruction [Elek12 sec. 4.4]", "tpm.fine", "tpm.picture", {16, 16, 1}, 0},
    {"tpm.enlarge", "half the resolution [Elek12 sec. 4.4]", "tpm.picture", "tpm.sample", {NPH_TILE_PIXELS, 1, 1}, 0},
    {"tpm.accumulate", "moments in a dyadic tree [Chan79] [Pebay08]", "tpm.sample", "film.node", {NPH_TILE_PIXELS, 1, 1}, 0},
};

static const NphBuffer buffers[] = {
    {"tpm.partial", NPH_I64, "[kind][cell][6]", "2^-scale of the unit of flux", "what a generation's photons deposit: flux of three channels, flux times cosine, flux times order, number", NPH_STAT, NULL, NULL, 0},
    {"tpm.sum", NPH_I64, "[kind][cell][6]", "2^-scale of the unit of flux", "the same of all generations of a frame", NPH_STAT, NULL, NULL, 0},
    {"tpm.coarse", NPH_TYPE_REAL, "[cell][10]", "W/m2, 1", "fluence of the sun's photons, mean cosine, fluence of the sky's, mean cosine, mean orders of both", NPH_STAT, NULL, NULL, 0},
    {"tpm.fine", NPH_TYPE_REAL, "[cell][10]", "W/m2, 1", "the same at the resolution of the density", NPH_NEAR, NULL, NULL, 0},
    {"tpm.picture", NPH_TYPE_REAL, "[pixel][field]", "W/m2/sr, m, 1", "what marched rays carry", NPH_NEAR, NULL, NULL, 0},
    {"tpm.sample", NPH_TYPE_REAL, "[tile][field][pixel][16]", "W/m2/sr, m, 1", "what each sample carries", NPH_BIAS, NULL, NULL, 0},
    {"film.node", NPH_F64, "[moment][pixel]", "powers of W/m2/sr", "count, mean, central moments", NPH_BIAS, NULL, NULL, 0},
};

enum { ROWS = 4 }; /* of the small picture in a block */

typedef struct TpmState {
    NphJob job;
    NphTpmChoice choice;
    NphTpmCache cache;
    int made; /* the cache is open */
    void *scene, *picture, *samples, *film_scratch;
    size_t tile_bytes;
    int origin[2], small[2];
    NphFilm *film;
    int64_t chunk;
    int slot;
    double started;
} TpmState;

static int channels(const NphJob *job) {
    NphTransportChoice choice;
    nph_transport_choose(job->scene, job->plan_full, &choice);
    return choice.film_channels;
}

static void close_tpm(void *opaque) {
    TpmState *state = opaque;
    if (!state) return;
    NphContext *context = state->job.context;
    if (state->made) nph_tpm_cache_close(&state->cache);
    nph_free(context, state->film_scratch);
    nph_free(context, state->samples);
    nph_free(context, state->picture);
    nph_free(context, state->scene);
    nph_free(context, state);
}

static NphStatus open_state(TpmState *state) {
    const NphJob *job = &state->job;
    NphContext *context = job->context;
    NphTpmKernels kernels;
    size_t real = job->precision == 32 ? 4 : 8;
    int64_t across = (job->crop[2] + NPH_TILE - 1) / NPH_TILE - job->crop[0] / NPH_TILE;
    int64_t down = (job->crop[3] + NPH_TILE - 1) / NPH_TILE - job->crop[1] / NPH_TILE;
    NPH_TRY(nph_tpm_choose(job, &state->choice));
    nph_tpm_kernels(job->precision, nph_context_isa(context), &kernels);
    nph_tpm_small(job, state->origin, state->small);
    NPH_TRY(nph_alloc(context, kernels.scene_bytes(job->knobs[NPH_TPM_KNOB_NOISE] > 0.0), 1, "scene for the kernels", &state->scene));
    kernels.prepare(job, &state->choice, state->scene);
    NPH_TRY(nph_alloc(context, (size_t)state->small[0] * (size_t)state->small[1] * NPH_SAMPLE_FIELDS, real, "picture that is marched",
                      &state->picture));
    state->tile_bytes = (size_t)NPH_SAMPLE_FIELDS * NPH_TILE_PIXELS * NPH_CHUNK * real;
    NPH_TRY(nph_alloc(context, (size_t)(across * down), state->tile_bytes, "samples of all pixels", &state->samples));
    NPH_TRY(nph_alloc(context, nph_film_scratch_bytes(state->choice.transport.film_channels), 1, "film scratch", &state->film_scratch));
    NPH_TRY(nph_tpm_cache_open(job, &state->choice, state->scene, &state->cache));
    state->made = 1;
    return NPH_OK;
}

static NphStatus open_tpm(const NphJob *job, void **out) {
    TpmState *state = NULL;
    NPH_TRY(NPH_NEW(job->context, 1, "temporal photons", &state));
    state->job = *job;
    NphStatus status = open_state(state);
    if (status != NPH_OK) {
        close_tpm(state);
        return status;
    }
    *out = state;
    return NPH_OK;
}

static void *tile_samples(const TpmState *state, int64_t tile) { return (char *)state->samples + state->tile_bytes * (size_t)tile; }

static NphStatus march_rows(void *opaque, int64_t number, int worker) {
    TpmState *state = opaque;
    NphTpmCache *cache = &state->cache;
    int first = (int)number * ROWS, end = first + ROWS < state->small[1] ? first + ROWS : state->small[1];
    int64_t steps;
    NPH_LAUNCH(&cache->stages[worker], NPH_TPM_MARCH, (int64_t)(end - first) * state->small[0],
               cache->kernels.march(state->scene, cache->fine, cache->sample, first, end, state->picture, &steps));
    cache->tallies[worker].tentative += steps;
    return NPH_OK;
}

static NphStatus enlarge_tile(void *opaque, int64_t number, int worker) {
    TpmState *state = opaque;
    NphTpmTile tile = {.slot = state->slot, .samples = tile_samples(state, number)};
    nph_film_tile_rect(state->film, number, tile.origin, tile.inside);
    int64_t pixels = (int64_t)(tile.inside[2] - tile.inside[0]) * (tile.inside[3] - tile.inside[1]);
    NPH_LAUNCH(&state->cache.stages[worker], NPH_TPM_ENLARGE, pixels, state->cache.kernels.enlarge(state->scene, state->picture, &tile));
    return NPH_OK;
}

/* A frame from photons of the sample's own. */
static NphStatus run_frame(TpmState *state, uint32_t sample) {
    NphContext *context = state->job.context;
    NPH_TRY(nph_tpm_cache_make(&state->cache, sample));
    NPH_TRY(nph_pool_run(context, (state->small[1] + ROWS - 1) / ROWS, march_rows, state, NULL));
    return nph_pool_run(context, nph_film_tile_count(state->film), enlarge_tile, state, NULL);
}

/* A value that 64 bits do not hold, or that is no number, was left out: nothing of it stays in the cache, and the run fails. */
static NphStatus check_ledger(TpmState *state) {
    NphTpmLedger sum;
    nph_tpm_cache_ledger(&state->cache, &sum);
    if (sum.nonfinite)
        return nph_error(state->job.context, NPH_BAD_NUMBER, "temporal_photons: %lld deposits are not finite", (long long)sum.nonfinite);
    if (sum.overflow)
        return nph_error(state->job.context, NPH_BAD_NUMBER, "temporal_photons: %lld deposits do not fit 64-bit fixed point of %d bits below the unit",
                         (long long)sum.overflow, state->choice.scale);
    return NPH_OK;
}

/* Sixteen frames; all tiles get them, or none when a request to stop comes in between. */
static NphStatus run_chunk(TpmState *state, int64_t done, int64_t total) {
    NphContext *context = state->job.context;
    int64_t tiles = nph_film_tile_count(state->film);
    for (state->slot = 0; state->slot < NPH_CHUNK; state->slot++) {
        NPH_TRY(run_frame(state, (uint32_t)(state->chunk * NPH_CHUNK + state->slot)));
        double ready = (double)(done + state->slot + 1), elapsed = nph_seconds() - state->started;
        nph_progress(context, "rendering", ready, (double)total, elapsed * ((double)total - ready) / ready);
    }
    NPH_TRY(check_ledger(state));
    for (int64_t tile = 0; tile < tiles; tile++)
        NPH_LAUNCH(&state->cache.stages[0], NPH_TPM_ACCUMULATE, NPH_TILE_PIXELS,
                   nph_film_add_chunk(state->film, tile, state->chunk, state->job.precision, tile_samples(state, tile), state->film_scratch));
    nph_film_end_chunk(state->film, state->chunk);
    return NPH_OK;
}

static NphStatus run_tpm(void *opaque, NphFilm *film, int64_t begin, int64_t end, int64_t done, int64_t total) {
    TpmState *state = opaque;
    state->film = film;
    if (done == 0) state->started = nph_seconds();
    for (int64_t at = begin; at < end; at += NPH_CHUNK) {
        state->chunk = at / NPH_CHUNK;
        NPH_TRY(run_chunk(state, done + at - begin, total));
    }
    return NPH_OK;
}

static void statistics(const void *opaque, NphRenderStatistics *out) {
    const TpmState *state = opaque;
    nph_stages_begin(stages, NPH_TPM_STAGES, out);
    for (int w = 0; w < nph_context_threads(state->job.context); w++) {
        nph_stages_add(&state->cache.stages[w], out);
        nph_tally_add(&state->cache.tallies[w], out);
    }
}

static void tell(NphLineFn line, void *user, const char *what, double a, double b, double c) {
    char text[256];
    snprintf(text, sizeof text, "  %-48s %.9g %.9g %.9g", what, a, b, c);
    line(user, text);
}

static void tell_ledger(const NphTpmLedger *l, int scale, NphLineFn line, void *user) {
    double unit = 1.0;
    for (int i = 0; i < scale; i++) unit *= 0.5;
    tell(line, user, "photons, beams, deposits:", (double)l->photons, (double)l->beams, (double)l->deposits);
    tell(line, user, "walks: emitted; escaped, absorbed [units of flux]:", (double)l->emitted * unit, (double)l->escaped * unit,
         (double)l->absorbed * unit);
    tell(line, user, "beams: collided, past the border, cut:", (double)l->collided * unit, (double)l->past * unit, (double)l->cut * unit);
}

static NphStatus replay_frame(TpmState *state, const int pixel[2], uint32_t sample, NphLineFn line, void *user) {
    NphTpmLedger sum;
    char text[256];
    NPH_TRY(nph_tpm_cache_make(&state->cache, sample));
    nph_tpm_cache_ledger(&state->cache, &sum);
    snprintf(text, sizeof text, "temporal_photons: pixel %d,%d sample %u, frame %u, generations %d, cells %d x %d x %d", pixel[0], pixel[1],
             (unsigned)sample, (unsigned)state->job.frame, state->choice.generations, (int)state->choice.cells[0],
             (int)state->choice.cells[1], (int)state->choice.cells[2]);
    line(user, text);
    tell_ledger(&sum, state->choice.scale, line, user);
    state->cache.kernels.replay(state->scene, state->cache.fine, sample, pixel, line, user);
    return NPH_OK;
}

static NphStatus replay(const NphJob *job, int x, int y, int64_t sample, NphLineFn line, void *user) {
    void *opaque = NULL;
    NPH_TRY(open_tpm(job, &opaque));
    NphStatus status = replay_frame(opaque, (int[2]){x, y}, (uint32_t)sample, line, user);
    close_tpm(opaque);
    return status;
}

const NphMethod nph_temporal_photons = {
    .name = "temporal_photons",
    .summary = "temporally coherent photon mapping: photons in a coarse grid, a fraction refreshed each frame (biased)",
    .knobs = knobs,
    .knob_count = NPH_TPM_KNOBS,
    .stages = stages,
    .stage_count = NPH_TPM_STAGES,
    .shares_samples = 1,
    .buffers = buffers,
    .buffer_count = (int)(sizeof buffers / sizeof *buffers),
    .plan = nph_tpm_plan,
    .channels = channels,
    .open = open_tpm,
    .run = run_tpm,
    .statistics = statistics,
    .close = close_tpm,
    .replay = replay,
};
