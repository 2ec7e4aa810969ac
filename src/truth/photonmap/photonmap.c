/* SPDX-License-Identifier: Apache-2.0
 *
 * truth/photonmap as a method: its knobs and stages, the run over samples, statistics and replay. */
#include "truth/photonmap/photonmap.h"

#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"

static const NphKnob knobs[NPH_PHOTONMAP_KNOBS] = {
    {"photonmap.photons", "1", "photons that one map holds", "bias and noise against memory and time", 1e6, 1.0, 1e8},
    {"photonmap.emitted", "1", "photons sent out for one map; 0: as many as fill it, at most four times its photons",
     "noise against time", 0.0, 0.0, 1e9},
    {"photonmap.nearest", "1", "photons of one estimate", "bias against noise", 50.0, 2.0, NPH_PHOTONMAP_NEAREST_MAX},
    {"photonmap.radius", "1", "largest radius of an estimate, over the diagonal of the box around all media",
     "bias against noise", 0.05, 1e-6, 2.0},
    {"photonmap.step", "1", "step of the march, in mean free paths of the majorant", "time against noise", 0.25, 1e-3,
     10.0},
    {"photonmap.direct", "1", "1: direct light by shadow rays; 0: from photons too", "time against bias", 1.0, 0.0,
     1.0},
    {"photonmap.printed", "1", "1: estimate and march as printed; 0: without their bias", "bias", 0.0, 0.0, 1.0},
};

#define PHOTONS                                                                                                        \
    "photonmap.id photonmap.place photonmap.direction photonmap.power photonmap.extinction photonmap.medium photonmap.order"
#define NODES "photonmap.node photonmap.node_photon photonmap.node_axis"

const NphStage nph_photonmap_stages[NPH_PHOTONMAP_STAGES] = {
    {"photonmap.pilot", "photon tracing [Jensen98]; delta tracking [Woodcock65]", "", "photonmap.count", {NPH_PHOTONMAP_BLOCK, 1, 1}, 0},
    {"photonmap.fill", "expected number that fills a map", "photonmap.count", "photonmap.emitted", {1, 1, 1}, 0},
    {"photonmap.count", "photon tracing [Jensen98]; delta tracking [Woodcock65]", "photonmap.emitted", "photonmap.count",
     {NPH_PHOTONMAP_BLOCK, 1, 1}, 0},
    {"photonmap.scan", "exclusive sums", "photonmap.count", "photonmap.first", {NPH_PHOTONMAP_BLOCK, 1, 1}, 0},
    {"photonmap.trace", "photon tracing [Jensen98]; delta tracking [Woodcock65]", "photonmap.emitted photonmap.first", PHOTONS,
     {NPH_PHOTONMAP_BLOCK, 1, 1}, 0},
    {"photonmap.tree", "left-balanced kd-tree [Bentley75] [Jensen98]", "photonmap.id photonmap.place", NODES, {1, 1, 1}, 0},
    {"photonmap.march", "ray march and radiance estimate [Jensen98]",
     "photonmap.id photonmap.direction photonmap.power photonmap.extinction photonmap.medium photonmap.order " NODES, "photonmap.image",
     {NPH_TILE_PIXELS, 1, 1}, 0},
    {"photonmap.accumulate", "moments in a dyadic tree [Chan79] [Pebay08]", "photonmap.sample", "film.node", {NPH_TILE_PIXELS, 1, 1}, 0},
};

static const char *const arguments[NPH_PHOTONMAP_ARGUMENTS] = {"sample", "tile"};

static int channels(const NphJob *job) {
    NphTransportChoice choice;
    nph_transport_choose(job->scene, job->plan_full, &choice);
    return choice.film_channels;
}

static void close_photonmap(void *opaque) {
    NphPhotonmapState *state = opaque;
    if (!state) return;
    NphContext *context = state->job.context;
    if (state->made) nph_photonmap_maker_close(&state->maker);
    nph_free(context, state->columns);
    nph_free(context, state->film_scratch);
    nph_free(context, state->samples);
    nph_free(context, state->images);
    nph_free(context, state->scene);
    nph_free(context, state);
}

static NphStatus open_scene(const NphJob *job, const NphPhotonmapChoice *choice, void **scene) {
    NphPhotonmapKernels kernels;
    nph_photonmap_kernels(NPH_ISA_BASE, job->precision, &kernels);
    NPH_TRY(nph_alloc(job->context, kernels.scene_bytes(), 1, "scene for the kernels", scene));
    kernels.prepare(job, choice, *scene);
    return NPH_OK;
}

static NphStatus open_state(NphPhotonmapState *state) {
    const NphJob *job = &state->job;
    NphContext *context = job->context;
    size_t field = (size_t)NPH_SAMPLE_FIELDS * (size_t)(job->precision / 8);
    void *scratch = NULL;
    NPH_TRY(nph_photonmap_choose(job, &state->choice));
    NPH_TRY(open_scene(job, &state->choice, &state->scene));
    state->image_bytes = field * (size_t)(job->crop[2] - job->crop[0]) * (size_t)(job->crop[3] - job->crop[1]);
    NPH_TRY(nph_alloc(context, NPH_CHUNK, state->image_bytes, "images of a chunk", &state->images));
    NPH_TRY(nph_alloc(context, (size_t)NPH_TILE_PIXELS * NPH_CHUNK, field, "samples of a tile", &state->samples));
    NPH_TRY(nph_alloc(context, nph_film_scratch_bytes(state->choice.transport.film_channels), 1, "film scratch", &scratch));
    state->film_scratch = scratch;
    NPH_TRY(nph_photonmap_maker_open(job, &state->choice, state->scene, &state->maker));
    state->made = 1;
    return job->tap ? nph_photonmap_open_columns(state) : NPH_OK;
}

static NphStatus open_photonmap(const NphJob *job, void **out) {
    NphPhotonmapState *state = NULL;
    NPH_TRY(NPH_NEW(job->context, 1, "photon mapping", &state));
    state->job = *job;
    NphStatus status = open_state(state);
    if (status != NPH_OK) {
        close_photonmap(state);
        return status;
    }
    *out = state;
    return NPH_OK;
}

static NphStatus march_tile(void *opaque, int64_t number, int worker) {
    NphPhotonmapState *state = opaque;
    NphPhotonmapMaker *maker = &state->maker;
    NphPhotonmapTile tile = {.image = (char *)state->images + state->image_bytes * (size_t)state->slot};
    int origin[2];
    memcpy(tile.crop, state->job.crop, sizeof tile.crop);
    nph_film_tile_rect(state->film, number, origin, tile.inside);
    int64_t pixels = (int64_t)(tile.inside[2] - tile.inside[0]) * (tile.inside[3] - tile.inside[1]);
    NPH_LAUNCH(&maker->stages[worker], NPH_PHOTONMAP_MARCH, pixels,
               maker->kernels.march(state->scene, &maker->map, &tile, &maker->tallies[worker]));
    return NPH_OK;
}

NphStatus nph_photonmap_launch(NphPhotonmapState *state, const NphLaunch *launch) {
    switch ((NphPhotonmapStage)launch->stage) {
    case NPH_PHOTONMAP_MARCH:
        return nph_pool_run(state->job.context, nph_film_tile_count(state->film), march_tile, state, NULL);
    case NPH_PHOTONMAP_ACCUMULATE:
        NPH_LAUNCH(&state->maker.stages[0], launch->stage, launch->items,
                   nph_film_chunk(state->film, state->job.precision, state->samples, state->film_scratch));
        return NPH_OK;
    default: return nph_photonmap_step(&state->maker, (NphPhotonmapStage)launch->stage);
    }
}

static int64_t items_of(const NphPhotonmapState *state, NphPhotonmapStage stage) {
    const NphPhotonmapMaker *maker = &state->maker;
    const int *crop = state->job.crop;
    switch (stage) {
    case NPH_PHOTONMAP_PILOT: return nph_photonmap_pilot_photons(&state->choice);
    case NPH_PHOTONMAP_FILL: return 1;
    case NPH_PHOTONMAP_COUNT:
    case NPH_PHOTONMAP_TRACE: return maker->map.emitted;
    case NPH_PHOTONMAP_SCAN: return maker->blocks;
    case NPH_PHOTONMAP_TREE: return maker->map.tree.count;
    case NPH_PHOTONMAP_MARCH: return (int64_t)(crop[2] - crop[0]) * (crop[3] - crop[1]);
    default: return NPH_TILE_PIXELS;
    }
}

/* The next launch of a batch: all of them in the calling thread, their blocks on the pool. */
static NphStatus step(NphPhotonmapState *state, NphLaunch *launch, NphPhotonmapStage stage) {
    const NphTap *tap = state->job.tap;
    launch->stage = (int)stage;
    launch->items = items_of(state, stage);
    if (launch->number == 0) state->placing = NPH_PHOTONMAP_NONE;
    if (tap) NPH_TRY(tap->before(tap->user, state, 0, launch));
    NPH_TRY(nph_photonmap_launch(state, launch));
    if (tap) NPH_TRY(tap->after(tap->user, state, 0, launch));
    launch->number++;
    return NPH_OK;
}

/* Batches of a chunk: its images, then its tiles. */
static int64_t batch_of(const NphPhotonmapState *state, int64_t number) {
    return state->chunk * (NPH_CHUNK + nph_film_tile_count(state->film)) + number;
}

/* What is written into its batch is looked through for the next one, whose maps are made of it. */
static NphStatus run_pilot(NphPhotonmapState *state) {
    NphLaunch launch = {.batch = NPH_BATCH_OF_SCENE};
    if (nph_photonmap_pilot_photons(&state->choice) == 0) return NPH_OK;
    NPH_TRY(step(state, &launch, NPH_PHOTONMAP_PILOT));
    NPH_TRY(step(state, &launch, NPH_PHOTONMAP_FILL));
    launch.stage = NPH_PHOTONMAP_COUNT;
    return state->job.tap ? nph_photonmap_check(state, 0, &launch) : NPH_OK;
}

/* A map and its picture. */
static NphStatus run_image(NphPhotonmapState *state) {
    int64_t sample = state->chunk * NPH_CHUNK + state->slot;
    NphLaunch launch = {.batch = batch_of(state, state->slot), .arguments = {sample}};
    state->maker.map.sample = (uint32_t)sample;
    for (int stage = NPH_PHOTONMAP_COUNT; stage <= NPH_PHOTONMAP_MARCH; stage++)
        NPH_TRY(step(state, &launch, (NphPhotonmapStage)stage));
    return NPH_OK;
}

static NphStatus add_tile(NphPhotonmapState *state, int64_t tile) {
    NphLaunch launch = {.batch = batch_of(state, NPH_CHUNK + tile), .arguments = {state->chunk * NPH_CHUNK, tile}};
    nph_film_gather(state->film, tile, state->job.precision, state->images, state->samples);
    NPH_TRY(step(state, &launch, NPH_PHOTONMAP_ACCUMULATE));
    nph_film_add_node(state->film, tile, state->chunk, state->job.precision, state->samples, state->film_scratch);
    return NPH_OK;
}

/* Sixteen maps and pictures; all tiles get them, or none when a request to stop comes in between. */
static NphStatus run_chunk(NphPhotonmapState *state, int64_t done, int64_t total) {
    int64_t tiles = nph_film_tile_count(state->film);
    for (state->slot = 0; state->slot < NPH_CHUNK; state->slot++) {
        NPH_TRY(run_image(state));
        double ready = (double)(done + state->slot + 1), elapsed = nph_seconds() - state->started;
        nph_progress(state->job.context, "rendering", ready, (double)total, elapsed * ((double)total - ready) / ready);
    }
    for (int64_t tile = 0; tile < tiles; tile++) NPH_TRY(add_tile(state, tile));
    nph_film_end_chunk(state->film, state->chunk);
    return NPH_OK;
}

static NphStatus run_photonmap(void *opaque, NphFilm *film, int64_t begin, int64_t end, int64_t done, int64_t total) {
    NphPhotonmapState *state = opaque;
    state->film = film;
    if (done == 0) {
        state->started = nph_seconds();
        NPH_TRY(run_pilot(state));
    }
    for (int64_t at = begin; at < end; at += NPH_CHUNK) {
        state->chunk = at / NPH_CHUNK;
        NPH_TRY(run_chunk(state, done + at - begin, total));
    }
    return NPH_OK;
}

static void statistics(const void *opaque, NphRenderStatistics *out) {
    const NphPhotonmapState *state = opaque;
    nph_stages_begin(nph_photonmap_stages, NPH_PHOTONMAP_STAGES, out);
    for (int w = 0; w < nph_context_threads(state->job.context); w++) {
        nph_stages_add(&state->maker.stages[w], out);
        nph_tally_add(&state->maker.tallies[w], out);
    }
}

static NphStatus replay(const NphJob *job, int x, int y, int64_t sample, NphLineFn line, void *user) {
    NphPhotonmapChoice choice;
    NphPhotonmapMaker maker = {.context = job->context};
    void *scene = NULL;
    NPH_TRY(nph_photonmap_choose(job, &choice));
    NphStatus status = open_scene(job, &choice, &scene);
    if (status == NPH_OK) status = nph_photonmap_maker_open(job, &choice, scene, &maker);
    if (status == NPH_OK) status = nph_photonmap_prepare_maps(&maker);
    if (status == NPH_OK) status = nph_photonmap_make(&maker, (uint32_t)sample);
    double fields[NPH_SAMPLE_FIELDS];
    if (status == NPH_OK) maker.kernels.replay(scene, &maker.map, (int[2]){x, y}, line, user, fields);
    nph_photonmap_maker_close(&maker);
    nph_free(job->context, scene);
    return status;
}

static NphStatus facts(const NphJob *job, NphFactFn fact, void *user) {
    NphPhotonmapChoice choice;
    NphPhotonmapKernels kernels;
    void *scene = NULL;
    nph_photonmap_kernels(NPH_ISA_BASE, job->precision, &kernels);
    NPH_TRY(nph_photonmap_choose(job, &choice));
    NPH_TRY(open_scene(job, &choice, &scene));
    kernels.facts(scene, choice.room, fact, user);
    nph_free(job->context, scene);
    return NPH_OK;
}

const NphMethod nph_photonmap = {
    .name = "photonmap",
    .summary = "volumetric photon mapping: direct light by shadow rays, the rest from the density of photons (biased)",
    .knobs = knobs,
    .knob_count = NPH_PHOTONMAP_KNOBS,
    .stages = nph_photonmap_stages,
    .stage_count = NPH_PHOTONMAP_STAGES,
    .shares_samples = 1,
    .buffers = nph_photonmap_buffers,
    .buffer_count = NPH_PHOTONMAP_BUFFERS,
    .plan = nph_photonmap_plan,
    .channels = channels,
    .open = open_photonmap,
    .run = run_photonmap,
    .statistics = statistics,
    .close = close_photonmap,
    .replay = replay,
    .arguments = arguments,
    .argument_count = NPH_PHOTONMAP_ARGUMENTS,
    .begin_launch = nph_photonmap_begin_launch,
    .extend = nph_photonmap_extend,
    .view = nph_photonmap_view,
    .hold = nph_photonmap_hold,
    .check = nph_photonmap_check,
    .launch = nph_photonmap_launch_alone,
    .facts = facts,
};
