/* SPDX-License-Identifier: Apache-2.0
 *
 * truth/photonmap as a method: its knobs, stages and buffers, the run over samples, statistics and replay. */
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

static const NphStage stages[NPH_PHOTONMAP_STAGES] = {
    {"photonmap.trace",
     "photon tracing [Jensen98]; delta tracking [Woodcock65]",
     "",
     "photonmap.count photonmap.photon",
     {NPH_PHOTONMAP_BLOCK, 1, 1},
     0},
    {"photonmap.tree",
     "left-balanced kd-tree [Bentley75] [Jensen98]",
     "photonmap.photon",
     "photonmap.node",
     {1, 1, 1},
     0},
    {"photonmap.march",
     "ray march and radiance estimate [Jensen98]",
     "photonmap.photon photonmap.node",
     "photonmap.sample",
     {NPH_TILE_PIXELS, 1, 1},
     0},
    {"photonmap.accumulate",
     "moments in a dyadic tree [Chan79] [Pebay08]",
     "photonmap.sample",
     "film.node",
     {NPH_TILE_PIXELS, 1, 1},
     0},
};

static const NphBuffer buffers[] = {
    {"photonmap.count", NPH_I64, "[block + 1]", "1", "what photons of earlier blocks scatter", NPH_EXACT, NULL, NULL, 0},
    {"photonmap.photon", NPH_TYPE_REAL, "[photon]", "1, W, 1",
     "direction, scattered power per channel, extinction there, medium, order", NPH_NEAR, NULL, NULL, 0},
    {"photonmap.node", NPH_TYPE_REAL, "[photon]", "m, 1", "position; number of the photon << 2 | axis", NPH_NEAR, NULL, NULL, 0},
    {"photonmap.sample", NPH_TYPE_REAL, "[tile][field][pixel][16]", "W/m2/sr, m, 1", "what each sample carries",
     NPH_BIAS, NULL, NULL, 0},
    {"film.node", NPH_F64, "[moment][pixel]", "powers of W/m2/sr", "count, mean, central moments", NPH_BIAS, NULL, NULL, 0},
};

typedef struct PhotonmapState {
    NphJob job;
    NphPhotonmapChoice choice;
    NphPhotonmapMaker maker;
    int made; /* the maker is open */
    void *scene;
    void *samples; /* [tile][field][pixel][sample in chunk] */
    size_t tile_bytes;
    void *film_scratch;
    NphFilm *film;
    int64_t chunk;
    int slot;
    double started;
} PhotonmapState;

static int channels(const NphJob *job) {
    NphTransportChoice choice;
    nph_transport_choose(job->scene, job->plan_full, &choice);
    return choice.film_channels;
}

static void close_photonmap(void *opaque) {
    PhotonmapState *state = opaque;
    if (!state) return;
    NphContext *context = state->job.context;
    if (state->made) nph_photonmap_maker_close(&state->maker);
    nph_free(context, state->film_scratch);
    nph_free(context, state->samples);
    nph_free(context, state->scene);
    nph_free(context, state);
}

static NphStatus open_scene(const NphJob *job, const NphPhotonmapChoice *choice, void **scene) {
    NphPhotonmapKernels kernels;
    nph_photonmap_kernels(job->precision, &kernels);
    NPH_TRY(nph_alloc(job->context, kernels.scene_bytes(), 1, "scene for the kernels", scene));
    kernels.prepare(job, choice, *scene);
    return NPH_OK;
}

static NphStatus open_state(PhotonmapState *state) {
    const NphJob *job = &state->job;
    NphContext *context = job->context;
    int64_t across = (job->crop[2] + NPH_TILE - 1) / NPH_TILE - job->crop[0] / NPH_TILE;
    int64_t down = (job->crop[3] + NPH_TILE - 1) / NPH_TILE - job->crop[1] / NPH_TILE;
    NPH_TRY(nph_photonmap_choose(job, &state->choice));
    NPH_TRY(open_scene(job, &state->choice, &state->scene));
    state->tile_bytes = (size_t)NPH_SAMPLE_FIELDS * NPH_TILE_PIXELS * NPH_CHUNK * (job->precision == 32 ? 4 : 8);
    NPH_TRY(nph_alloc(context, (size_t)(across * down), state->tile_bytes, "samples of all pixels", &state->samples));
    NPH_TRY(nph_alloc(context, nph_film_scratch_bytes(state->choice.transport.film_channels), 1, "film scratch",
                      &state->film_scratch));
    NPH_TRY(nph_photonmap_maker_open(job, &state->choice, state->scene, &state->maker));
    state->made = 1;
    return NPH_OK;
}

static NphStatus open_photonmap(const NphJob *job, void **out) {
    PhotonmapState *state = NULL;
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

static void *tile_samples(const PhotonmapState *state, int64_t tile) {
    return (char *)state->samples + state->tile_bytes * (size_t)tile;
}

static NphStatus march_tile(void *opaque, int64_t number, int worker) {
    PhotonmapState *state = opaque;
    NphPhotonmapMaker *maker = &state->maker;
    NphPhotonmapTile tile = {.slot = state->slot, .samples = tile_samples(state, number)};
    nph_film_tile_rect(state->film, number, tile.origin, tile.inside);
    int64_t pixels = (int64_t)(tile.inside[2] - tile.inside[0]) * (tile.inside[3] - tile.inside[1]);
    NPH_LAUNCH(&maker->stages[worker], NPH_PHOTONMAP_MARCH, pixels,
               maker->kernels.march(state->scene, &maker->map, &tile, &maker->tallies[worker]));
    return NPH_OK;
}

/* Sixteen maps and pictures; all tiles get them, or none when a request to stop comes in between. */
static NphStatus run_chunk(PhotonmapState *state, int64_t done, int64_t total) {
    NphContext *context = state->job.context;
    int64_t tiles = nph_film_tile_count(state->film);
    for (state->slot = 0; state->slot < NPH_CHUNK; state->slot++) {
        NPH_TRY(nph_photonmap_make(&state->maker, (uint32_t)(state->chunk * NPH_CHUNK + state->slot)));
        NPH_TRY(nph_pool_run(context, tiles, march_tile, state, NULL));
        double ready = (double)(done + state->slot + 1), elapsed = nph_seconds() - state->started;
        nph_progress(context, "rendering", ready, (double)total, elapsed * ((double)total - ready) / ready);
    }
    NphStageCounts *counts = &state->maker.stages[0];
    for (int64_t tile = 0; tile < tiles; tile++)
        NPH_LAUNCH(counts, NPH_PHOTONMAP_ACCUMULATE, NPH_TILE_PIXELS,
                   nph_film_add_chunk(state->film, tile, state->chunk, state->job.precision, tile_samples(state, tile),
                                      state->film_scratch));
    nph_film_end_chunk(state->film, state->chunk);
    return NPH_OK;
}

static NphStatus run_photonmap(void *opaque, NphFilm *film, int64_t begin, int64_t end, int64_t done, int64_t total) {
    PhotonmapState *state = opaque;
    state->film = film;
    if (done == 0) state->started = nph_seconds();
    for (int64_t at = begin; at < end; at += NPH_CHUNK) {
        state->chunk = at / NPH_CHUNK;
        NPH_TRY(run_chunk(state, done + at - begin, total));
    }
    return NPH_OK;
}

static void statistics(const void *opaque, NphRenderStatistics *out) {
    const PhotonmapState *state = opaque;
    nph_stages_begin(stages, NPH_PHOTONMAP_STAGES, out);
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
    if (status == NPH_OK) status = nph_photonmap_make(&maker, (uint32_t)sample);
    double fields[NPH_SAMPLE_FIELDS];
    if (status == NPH_OK) maker.kernels.replay(scene, &maker.map, (int[2]){x, y}, line, user, fields);
    nph_photonmap_maker_close(&maker);
    nph_free(job->context, scene);
    return status;
}

const NphMethod nph_photonmap = {
    .name = "photonmap",
    .summary = "volumetric photon mapping: direct light by shadow rays, the rest from the density of photons (biased)",
    .knobs = knobs,
    .knob_count = NPH_PHOTONMAP_KNOBS,
    .stages = stages,
    .stage_count = NPH_PHOTONMAP_STAGES,
    .shares_samples = 1,
    .buffers = buffers,
    .buffer_count = (int)(sizeof buffers / sizeof *buffers),
    .plan = nph_photonmap_plan,
    .channels = channels,
    .open = open_photonmap,
    .run = run_photonmap,
    .statistics = statistics,
    .close = close_photonmap,
    .replay = replay,
};
