/* SPDX-License-Identifier: Apache-2.0
 *
 * method/temporal_photons as a method: its knobs, stages and buffers, the run over samples, statistics and replay. */
#include "method/temporal_photons/tpm.h"

#include <stdio.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"
#include "method/temporal_photons/tpm_carry.h"
#include "method/temporal_photons/tpm_impostor.h"

static const NphKnob knobs[NPH_TPM_KNOBS] = {
    {"tpm.variant", "1", "0: corrected, from the transport equation; 1: paper, the formulas as printed", "nothing: to compare", 0.0, 0.0, 1.0},
    {"tpm.photons", "1", "photons of all generations together", "noise against time", 819200.0, 1.0, 1e9},
    {"tpm.generations", "1", "generations that make a frame", "noise of a frame against how old its light is", 100.0, 1.0,
     NPH_TPM_GENERATIONS_MAX},
    {"tpm.primed", "1", "1: before frame 0 the scene stood still; 0: there was nothing, early frames have fewer generations",
     "noise of the first frames against time", 1.0, 0.0, 1.0},
    {"tpm.reference", "1", "of scenes that change: the frame at which tpm.photons are sent; as bright a light has as many", "nothing: what photons carry",
     0.0, 0.0, 16777215.0},
    {"tpm.vary", "1", "the photons of a generation are by up to this part more or fewer, by its number", "nothing: shows that it does not matter", 0.0, 0.0,
     0.95},
    {"tpm.cells", "1", "most cells of the coarse grid, near to cubes", "blur against noise", 2400.0, 1.0, NPH_TPM_CELLS_MAX},
    {"tpm.cells_x", "1", "cells along x of the medium's box; 0: as tpm.cells says", "blur against noise", 0.0, 0.0, 4096.0},
    {"tpm.cells_y", "1", "cells along y", "blur against noise", 0.0, 0.0, 4096.0},
    {"tpm.cells_z", "1", "cells along z", "blur against noise", 0.0, 0.0, 4096.0},
    {"tpm.threshold", "1", "a beam ends when less than this is left of it", "bias against time", 0.01, 0.0, 1.0},
    {"tpm.similarity", "1", "scattering becomes isotropic when |g|^order falls below this; 0: never", "bias against time", 0.05, 0.0, 1.0},
    {"tpm.sky_lobe", "1", "1: the sky's light has a lobe of its own; 0: it is the same from all sides", "bias of lopsided skies", 0.0, 0.0, 1.0},
    {"tpm.orders", "1", "light that the picture shows: 0: all; 1: scattered once; 2: twice; 3: more often", "nothing: to look at", 0.0, 0.0, 3.0},
    {"tpm.upsampling", "1", "0: linear interpolation; 1: joint bilateral, Gaussians; 2: by transmittance and density", "blur against time", 2.0, 0.0, 2.0},
    {"tpm.neighbourhood", "1", "cells on either side that upsampling looks at", "blur against time", 1.0, 1.0, 2.0},
    {"tpm.spread", "1", "standard deviation of the Gaussian in space, over the neighbourhood's radius", "blur against noise", 0.4, 0.01, 10.0},
    {"tpm.spread_density", "1", "standard deviation of the Gaussian in density, over the largest", "blur against noise", 0.25, 0.001, 10.0},
    {"tpm.steps", "1", "steps of the march along the diagonal of the box", "bias against time", 300.0, 1.0, 1e6},
    {"tpm.exit", "1", "a ray ends when its transmittance falls below this", "bias against time", 0.02, 0.0, 1.0},
    {"tpm.noise", "1", "size of the noise that moves lookups, in voxels of the density (of a box, metres)", "detail that the density does not have", 0.0, 0.0, 100.0},
    {"tpm.octaves", "1", "octaves of that noise", "detail against time", 3.0, 0.0, 8.0},
    {"tpm.half", "1", "1: half the resolution is marched, in both dimensions; 0: every pixel", "blur against time", 1.0, 0.0, 1.0},
    {"tpm.impostors", "1", "1: frames may show the cloud as an earlier one saw it; 0: each is marched", "late light and shape against time", 0.0, 0.0, 1.0},
    {"tpm.angle", "degrees", "impostors: most that the way to the cloud may turn", "bias against time", 5.0, 0.0, 180.0},
    {"tpm.distance", "1", "impostors: most that the distance may change", "bias against time", 0.2, 0.0, 1e6},
    {"tpm.light", "1", "impostors: most of the generations that may have been exchanged", "late light against time", 0.04, 0.0, 1.0},
    {"tpm.shape", "1", "impostors: most that density, extinction, albedo, mean cosine or edges may change", "late shape against time", 0.05, 0.0, 1e6},
};

const NphStage nph_tpm_stages[NPH_TPM_STAGES] = {
    {"tpm.clear", "a frame of no generation [Elek12 sec. 4.2]", "", "tpm.sum", {NPH_TPM_BLOCK, 1, 1}, 0},
    {"tpm.trace", "photon tracing and storing [Elek12 sec. 4.1]; delta tracking [Woodcock65]", "", "tpm.partial", {NPH_TPM_BLOCK, 1, 1},
     NPH_TPM_SHARED_CELLS * 5 * 4},
    {"tpm.update", "circular buffer of generations [Elek12 sec. 4.2]", "tpm.partial tpm.old tpm.sum", "tpm.sum", {NPH_TPM_BLOCK, 1, 1}, 0},
    {"tpm.resolve", "mean cosine and depth of a cell [Elek12 sec. 4.1.2]", "tpm.sum", "tpm.coarse", {NPH_TPM_BLOCK, 1, 1}, 0},
    {"tpm.upsample", "upsampling guided by the density [Elek12 sec. 4.3]", "tpm.coarse", "tpm.fine", {NPH_TPM_BLOCK, 1, 1}, 0},
    {"tpm.march", "ray march and reconstruction [Elek12 sec. 4.4]", "tpm.fine", "tpm.picture", {16, 16, 1}, 0},
    {"tpm.enlarge", "half the resolution [Elek12 sec. 4.4]", "tpm.picture", "tpm.image", {16, 16, 1}, 0},
    {"tpm.accumulate", "moments in a dyadic tree [Chan79] [Pebay08]", "tpm.sample", "film.node", {NPH_TILE_PIXELS, 1, 1}, 0},
};

static const char *const arguments[NPH_TPM_ARGUMENTS] = {"sample", "generation", "tile"};

enum { ROWS = 4 }; /* of a picture in a block */

static int channels(const NphJob *job) {
    NphTransportChoice choice;
    nph_transport_choose(job->scene, job->plan_full, &choice);
    return choice.film_channels;
}

static void close_tpm(void *opaque) {
    NphTpmState *state = opaque;
    if (!state) return;
    NphContext *context = state->job.context;
    if (state->made) nph_tpm_cache_close(&state->cache);
    nph_free(context, state->film_scratch);
    nph_free(context, state->samples);
    nph_free(context, state->images);
    nph_free(context, state->picture);
    if (state->shown != state->scene) nph_free(context, state->shown);
    nph_free(context, state->scene);
    nph_scene_free(context, state->shown_scene);
    nph_free(context, state);
}

/* The frame whose picture is shown: this one, or an earlier one. */
static NphStatus open_shown(NphTpmState *state, const NphTpmKernels *kernels, size_t bytes, NphJob *of) {
    NphTpmChoice choice;
    *of = state->job;
    NPH_TRY(nph_tpm_choose(of, &choice, NULL));
    NPH_TRY(nph_alloc(of->context, bytes, 1, "scene for the kernels", &state->scene));
    kernels->prepare(of, &choice, state->scene);
    state->film_channels = choice.transport.film_channels;
    state->choice = choice;
    state->shown = state->scene;
    NPH_TRY(nph_tpm_impostor(of, choice.medium, &state->age, &state->shown_scene));
    if (state->age == 0) return NPH_OK;
    if (state->shown_scene) of->scene = state->shown_scene;
    if (of->frame >= (uint32_t)state->age) of->frame -= (uint32_t)state->age; /* else all have the noise of frame 0 */
    NPH_TRY(nph_tpm_choose(of, &state->choice, NULL));
    state->shown = NULL;
    NPH_TRY(nph_alloc(of->context, bytes, 1, "scene of the impostor", &state->shown));
    kernels->prepare(of, &state->choice, state->shown);
    return NPH_OK;
}

static NphStatus open_state(NphTpmState *state) {
    const NphJob *job = &state->job;
    NphContext *context = job->context;
    NphTpmKernels kernels;
    size_t field = (size_t)NPH_SAMPLE_FIELDS * (size_t)(job->precision / 8);
    void *scratch = NULL;
    NphJob of;
    nph_tpm_kernels(job->precision, nph_context_isa(context), &kernels);
    nph_tpm_small(job, state->origin, state->small);
    NPH_TRY(open_shown(state, &kernels, kernels.scene_bytes(job->knobs[NPH_TPM_KNOB_NOISE] > 0.0), &of));
    NPH_TRY(nph_alloc(context, (size_t)state->small[0] * (size_t)state->small[1], field, "picture that is marched", &state->picture));
    state->image_bytes = field * (size_t)(job->crop[2] - job->crop[0]) * (size_t)(job->crop[3] - job->crop[1]);
    NPH_TRY(nph_alloc(context, NPH_CHUNK, state->image_bytes, "images of a chunk", &state->images));
    NPH_TRY(nph_alloc(context, (size_t)NPH_TILE_PIXELS * NPH_CHUNK, field, "samples of a tile", &state->samples));
    NPH_TRY(nph_alloc(context, nph_film_scratch_bytes(state->film_channels), 1, "film scratch", &scratch));
    state->film_scratch = scratch;
    NPH_TRY(nph_tpm_cache_open(&of, state->shown, state->age, &state->cache));
    state->made = 1;
    if (!job->carry || state->choice.medium < 0) return NPH_OK;
    NPH_TRY(nph_tpm_carry_open(job, &state->cache, field * (size_t)state->small[0] * (size_t)state->small[1], job->carry));
    state->carry = *job->carry;
    return NPH_OK;
}

static NphStatus open_tpm(const NphJob *job, void **out) {
    NphTpmState *state = NULL;
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

static NphStatus march_rows(void *opaque, int64_t number, int worker) {
    NphTpmState *state = opaque;
    NphTpmCache *cache = &state->cache;
    int first = (int)number * ROWS, end = first + ROWS < state->small[1] ? first + ROWS : state->small[1];
    int64_t steps;
    NPH_LAUNCH(&cache->stages[worker], NPH_TPM_MARCH, (int64_t)(end - first) * state->small[0],
               cache->kernels.march(state->shown, cache->fine, cache->sample, first, end, state->picture, &steps));
    cache->tallies[worker].tentative += steps;
    return NPH_OK;
}

static NphStatus enlarge_rows(void *opaque, int64_t number, int worker) {
    NphTpmState *state = opaque;
    const int *crop = state->job.crop;
    int rows = crop[3] - crop[1], first = (int)number * ROWS, end = first + ROWS < rows ? first + ROWS : rows;
    NPH_LAUNCH(&state->cache.stages[worker], NPH_TPM_ENLARGE, (int64_t)(end - first) * (crop[2] - crop[0]),
               state->cache.kernels.enlarge(state->shown, state->scene, state->picture, crop, first, end,
                                            (char *)state->images + state->image_bytes * (size_t)state->slot));
    return NPH_OK;
}

NphStatus nph_tpm_launch(NphTpmState *state, const NphLaunch *launch) {
    NphContext *context = state->job.context;
    const int *crop = state->job.crop;
    switch ((NphTpmStage)launch->stage) {
    case NPH_TPM_MARCH: return nph_pool_run(context, (state->small[1] + ROWS - 1) / ROWS, march_rows, state, NULL);
    case NPH_TPM_ENLARGE: return nph_pool_run(context, (crop[3] - crop[1] + ROWS - 1) / ROWS, enlarge_rows, state, NULL);
    case NPH_TPM_ACCUMULATE:
        NPH_LAUNCH(&state->cache.stages[0], launch->stage, launch->items,
                   nph_film_chunk(state->film, state->job.precision, state->samples, state->film_scratch));
        return NPH_OK;
    default: return nph_tpm_cache_step(&state->cache, (NphTpmStage)launch->stage);
    }
}

static int64_t items_of(const NphTpmState *state, NphTpmStage stage) {
    const NphTpmChoice *choice = &state->choice;
    const int *crop = state->job.crop;
    switch (stage) {
    case NPH_TPM_CLEAR:
    case NPH_TPM_UPDATE: return state->cache.values;
    case NPH_TPM_TRACE: return state->cache.now.photons[NPH_TPM_SUN] + state->cache.now.photons[NPH_TPM_SKY];
    case NPH_TPM_RESOLVE: return nph_tpm_cells(choice->cells);
    case NPH_TPM_UPSAMPLE: return nph_tpm_cells(choice->fine);
    case NPH_TPM_MARCH: return (int64_t)state->small[0] * state->small[1];
    case NPH_TPM_ENLARGE: return (int64_t)(crop[2] - crop[0]) * (crop[3] - crop[1]);
    default: return NPH_TILE_PIXELS;
    }
}

/* The next launch of a batch: all of them in the calling thread, their blocks on the pool. */
static NphStatus step(NphTpmState *state, NphLaunch *launch, NphTpmStage stage) {
    const NphTap *tap = state->job.tap;
    launch->stage = (int)stage;
    launch->items = items_of(state, stage);
    if (tap) NPH_TRY(tap->before(tap->user, state, 0, launch));
    NPH_TRY(nph_tpm_launch(state, launch));
    if (tap) NPH_TRY(tap->after(tap->user, state, 0, launch));
    launch->number++;
    return NPH_OK;
}

/* Batches of a chunk: its frames, then its tiles. */
static int64_t batch_of(const NphTpmState *state, int64_t number) {
    return state->chunk * (NPH_CHUNK + nph_film_tile_count(state->film)) + number;
}

/* A generation joins I, and in a sequence another one leaves it. */
static NphStatus run_generation(NphTpmState *state, NphLaunch *launch, int generation) {
    NphTpmCache *cache = &state->cache;
    launch->arguments[NPH_TPM_ARG_GENERATION] = generation;
    NPH_TRY(nph_tpm_cache_enter(cache, generation));
    NPH_TRY(step(state, launch, NPH_TPM_TRACE));
    cache->old = state->carry ? nph_tpm_carry_old(state->carry, cache) : NULL;
    NPH_TRY(step(state, launch, NPH_TPM_UPDATE));
    if (state->carry) nph_tpm_carry_keep(state->carry, cache);
    return NPH_OK;
}

static NphStatus run_generations(NphTpmState *state, NphLaunch *launch, int first, int end) {
    for (int g = first; g < end && nph_tpm_has_photons(&state->choice); g++) NPH_TRY(run_generation(state, launch, g));
    return NPH_OK;
}

/* The picture of a frame from its generations, of which those from `first` on are missing. */
static NphStatus run_picture(NphTpmState *state, NphLaunch *launch, int first) {
    if (first == 0) NPH_TRY(step(state, launch, NPH_TPM_CLEAR));
    NPH_TRY(run_generations(state, launch, first, state->choice.generations));
    launch->arguments[NPH_TPM_ARG_GENERATION] = 0;
    for (int stage = NPH_TPM_RESOLVE; stage <= NPH_TPM_MARCH; stage++) NPH_TRY(step(state, launch, (NphTpmStage)stage));
    return NPH_OK;
}

/* A frame from photons of the sample's own; in a sequence what the next one needs too. */
static NphStatus run_frame(NphTpmState *state) {
    NphTpmCache *cache = &state->cache;
    NphTpmCarry *carry = state->carry;
    int64_t sample = state->chunk * NPH_CHUNK + state->slot;
    NphLaunch launch = {.batch = batch_of(state, state->slot), .arguments = {sample}};
    int first = carry ? nph_tpm_carry_take(carry, sample, cache) : 0, own = state->choice.generations;
    size_t bytes = (size_t)state->small[0] * (size_t)state->small[1] * NPH_SAMPLE_FIELDS * (size_t)(state->job.precision / 8);
    void *kept = carry ? nph_tpm_carry_picture(carry) : NULL;
    cache->sample = (uint32_t)sample;
    if (first < own) NPH_TRY(run_picture(state, &launch, first));
    if (first < own && kept) memcpy(kept, state->picture, bytes);
    if (first >= own && kept) memcpy(state->picture, kept, bytes);
    if (carry) NPH_TRY(run_generations(state, &launch, first < own ? own : first, own + state->age));
    if (carry) nph_tpm_carry_give(carry, cache);
    launch.arguments[NPH_TPM_ARG_GENERATION] = 0;
    return step(state, &launch, NPH_TPM_ENLARGE);
}

static NphStatus add_tile(NphTpmState *state, int64_t tile) {
    NphLaunch launch = {.batch = batch_of(state, NPH_CHUNK + tile), .arguments = {state->chunk * NPH_CHUNK, 0, tile}};
    nph_film_gather(state->film, tile, state->job.precision, state->images, state->samples);
    NPH_TRY(step(state, &launch, NPH_TPM_ACCUMULATE));
    nph_film_add_node(state->film, tile, state->chunk, state->job.precision, state->samples, state->film_scratch);
    return NPH_OK;
}

/* Sixteen frames; all tiles get them, or none when a request to stop comes in between. */
static NphStatus run_chunk(NphTpmState *state, int64_t done, int64_t total) {
    int64_t tiles = nph_film_tile_count(state->film);
    for (state->slot = 0; state->slot < NPH_CHUNK; state->slot++) {
        NPH_TRY(run_frame(state));
        double ready = (double)(done + state->slot + 1), elapsed = nph_seconds() - state->started;
        nph_progress(state->job.context, "rendering", ready, (double)total, elapsed * ((double)total - ready) / ready);
    }
    for (int64_t tile = 0; tile < tiles; tile++) NPH_TRY(add_tile(state, tile));
    nph_film_end_chunk(state->film, state->chunk);
    return NPH_OK;
}

static NphStatus run_tpm(void *opaque, NphFilm *film, int64_t begin, int64_t end, int64_t done, int64_t total) {
    NphTpmState *state = opaque;
    state->film = film;
    if (done == 0) state->started = nph_seconds();
    if (done == 0 && state->carry) nph_tpm_carry_begin(state->carry, &state->cache, state->age);
    for (int64_t at = begin; at < end; at += NPH_CHUNK) {
        state->chunk = at / NPH_CHUNK;
        NPH_TRY(run_chunk(state, done + at - begin, total));
    }
    if (state->carry && done + end - begin == total) nph_tpm_carry_end(state->carry, &state->cache, state->age);
    return NPH_OK;
}

static void statistics(const void *opaque, NphRenderStatistics *out) {
    const NphTpmState *state = opaque;
    nph_stages_begin(nph_tpm_stages, NPH_TPM_STAGES, out);
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

static NphStatus replay_frame(NphTpmState *state, const int pixel[2], uint32_t sample, NphLineFn line, void *user) {
    NphTpmLedger sum;
    char text[256];
    NPH_TRY(nph_tpm_cache_make(&state->cache, sample));
    nph_tpm_cache_ledger(&state->cache, &sum);
    snprintf(text, sizeof text, "temporal_photons: pixel %d,%d sample %u, frame %u, generations %d, cells %d x %d x %d", pixel[0], pixel[1],
             (unsigned)sample, (unsigned)state->job.frame, state->choice.generations, (int)state->choice.cells[0],
             (int)state->choice.cells[1], (int)state->choice.cells[2]);
    line(user, text);
    tell_ledger(&sum, state->choice.scale, line, user);
    state->cache.kernels.replay(state->shown, state->cache.fine, sample, pixel, line, user);
    return NPH_OK;
}

static NphStatus replay(const NphJob *job, int x, int y, int64_t sample, NphLineFn line, void *user) {
    void *opaque = NULL;
    NPH_TRY(open_tpm(job, &opaque));
    NphStatus status = replay_frame(opaque, (int[2]){x, y}, (uint32_t)sample, line, user);
    close_tpm(opaque);
    return status;
}

static NphStatus facts(const NphJob *job, NphFactFn fact, void *user) {
    void *opaque = NULL;
    NPH_TRY(open_tpm(job, &opaque));
    const NphTpmState *state = opaque;
    state->cache.kernels.facts(state->shown, &state->choice, fact, user);
    close_tpm(opaque);
    return NPH_OK;
}

const NphMethod nph_temporal_photons = {
    .name = "temporal_photons",
    .summary = "temporally coherent photon mapping: photons in a coarse grid, a fraction refreshed each frame (biased)",
    .knobs = knobs,
    .knob_count = NPH_TPM_KNOBS,
    .stages = nph_tpm_stages,
    .stage_count = NPH_TPM_STAGES,
    .shares_samples = 1,
    .buffers = nph_tpm_buffers,
    .buffer_count = NPH_TPM_BUFFERS,
    .plan = nph_tpm_plan,
    .channels = channels,
    .open = open_tpm,
    .run = run_tpm,
    .statistics = statistics,
    .close = close_tpm,
    .drop = nph_tpm_carry_drop,
    .replay = replay,
    .arguments = arguments,
    .argument_count = NPH_TPM_ARGUMENTS,
    .begin_launch = nph_tpm_begin_launch,
    .extend = nph_tpm_extend,
    .view = nph_tpm_view,
    .check = nph_tpm_check,
    .launch = nph_tpm_launch_alone,
    .facts = facts,
};
