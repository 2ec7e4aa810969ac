/* SPDX-License-Identifier: Apache-2.0
 *
 * truth/path as a method: its knobs, stages and buffers, the run over tiles and chunks, statistics and replay. */
#include "truth/path/path.h"

#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"
#include "truth/path/path_plan.h"

static const NphKnob knobs[NPH_PATH_KNOBS] = {
    {"path.roulette", "1", "throughput below which a path may be ended by chance", "time against variance", 0.1, 0.0, 1.0},
    {"path.shadow_roulette", "1", "transmittance below which a shadow ray may be ended by chance",
     "time against variance", 0.05, 0.0, 1.0},
    {"path.weighed", "1", "part of the absorption that weighs flights instead of collisions, where light is only met by "
     "paths that leave", "variance against time", 1.0, 0.0, 1.0},
    {"path.towards_sun", "1", "largest probability to sample a direction around the sun's instead of the path's own",
     "variance of direct peaks against variance of long paths", 0.3, 0.0, 0.9},
    {"path.least_light", "1", "light samples whose throughput times phase function is below this part of isotropic "
     "scattering are made by chance; in grids only", "time against variance", 0.5, 0.0, 10.0},
    {"path.emission_events", "1", "places along a flight across a grid that emits at which its light is looked up, in the "
     "mean", "time against variance", 16.0, 0.01, 1000.0},
    {"path.near_light", "1", "mean free paths within which flights, not collisions, take the light of a point in a medium",
     "time against variance", 1.0, 0.0, 1000.0},
    {"path.forced", "1", "1: camera rays are split into what passes and what collides where the one medium is a grey box or layer "
     "with nothing bright behind", "variance against time",
     1.0, 0.0, 1.0},
};

static const NphStage stages[NPH_PATH_STAGES] = {
    {"path.generate", "pinhole, parallel and flux sensors; box filter", "", "path.ray path.state", {NPH_PATH_BATCH, 1, 1}, 0},
    {"path.track", "delta tracking [Woodcock65]; spectral MIS [Wilkie14]; surfaces [Woop13]", "path.ray path.state",
     "path.distance path.medium path.surface path.touch path.state path.queue", {NPH_PATH_BATCH, 1, 1}, 0},
    {"path.emission", "events of a Poisson process [Kingman93]", "path.ray path.state path.distance", "path.sample",
     {NPH_PATH_BATCH, 1, 1}, 0},
    {"path.near", "equiangular sampling [Kulla12]; balance heuristic [Veach95]",
     "path.ray path.state path.distance path.medium path.surface path.touch path.queue", "path.sample",
     {NPH_PATH_BATCH, 1, 1}, 0},
    {"path.escape", "balance heuristic [Veach95]", "path.ray path.state path.queue", "path.sample", {NPH_PATH_BATCH, 1, 1}, 0},
    {"path.shadow", "ratio tracking [Novak14]; balance heuristic [Veach95]",
     "path.ray path.state path.distance path.medium path.surface path.touch path.queue", "path.sample", {NPH_PATH_BATCH, 1, 1}, 0},
    {"path.scatter", "phase function sampling; roulette [Arvo90]",
     "path.ray path.state path.distance path.medium path.surface path.touch path.queue", "path.ray path.state path.sample", {NPH_PATH_BATCH, 1, 1}, 0},
    {"path.accumulate", "moments in a dyadic tree [Chan79] [Pebay08]", "path.sample", "film.node", {NPH_TILE_PIXELS, 1, 1}, 0},
};

static const NphBuffer buffers[] = {
    {"path.ray", NPH_TYPE_REAL, "[6][path]", "m, 1", "position and direction, scene-local", NPH_NEAR, NULL},
    {"path.state", NPH_TYPE_REAL, "[7][path]", "1, 1/sr", "throughput, shares of the channels, density of the direction",
     NPH_NEAR, NULL},
    {"path.distance", NPH_TYPE_REAL, "[path]", "m", "to the next collision", NPH_NEAR, NULL},
    {"path.medium", NPH_I32, "[path]", "1", "number of the medium it happens in; -1: none", NPH_EXACT, NULL},
    {"path.surface", NPH_I32, "[path]", "1", "number of the surface that the flight ends at if nothing collides; -1: none",
     NPH_EXACT, NULL},
    {"path.touch", NPH_TYPE_REAL, "[7][path]", "m, 1", "where light leaves that surface, its normal, how far it is", NPH_NEAR,
     NULL},
    {"path.queue", NPH_I32, "[2][path]", "1", "positions of the paths that collide, then of those at surfaces; that leave",
     NPH_EXACT, NULL},
    {"path.sample", NPH_TYPE_REAL, "[field][path]", "W/m2/sr, m, 1", "what each sample carries", NPH_STAT, NULL},
    {"film.node", NPH_F64, "[moment][pixel]", "powers of W/m2/sr", "count, mean, central moments", NPH_STAT, NULL},
};

typedef struct PathWorker {
    NphPathBatch *batch;
    void *memory, *film_scratch;
    NphStageCounts counts;
} PathWorker;

typedef struct PathState {
    NphJob job;
    NphPathChoice choice;
    NphPathKernels kernels;
    void *scene;
    int threads;
    PathWorker *workers;
    /* of the pass under way */
    NphFilm *film;
    int64_t begin, end, done, total;
    double started, pass_started;
    int64_t tiles_done;
} PathState;

static int channels(const NphJob *job) {
    NphPathChoice choice;
    nph_path_choose(job, &choice);
    return choice.transport.film_channels;
}

static void close_path(void *opaque) {
    PathState *state = opaque;
    if (!state) return;
    NphContext *context = state->job.context;
    for (int w = 0; state->workers && w < state->threads; w++) {
        nph_free(context, state->workers[w].memory);
        nph_free(context, state->workers[w].film_scratch);
    }
    nph_free(context, state->workers);
    nph_free(context, state->scene);
    nph_free(context, state);
}

static NphStatus open_workers(PathState *state) {
    NphContext *context = state->job.context;
    void *scene = NULL;
    NPH_TRY(nph_alloc(context, state->kernels.scene_bytes(state->choice.transport.groups), 1, "scene for the kernels", &scene));
    state->scene = scene;
    state->kernels.prepare(&state->job, &state->choice, scene);
    NPH_TRY(NPH_NEW(context, state->threads, "workers", &state->workers));
    for (int w = 0; w < state->threads; w++) {
        PathWorker *worker = &state->workers[w];
        NPH_TRY(nph_alloc(context, state->kernels.batch_bytes(), 1, "batch of paths", &worker->memory));
        NPH_TRY(nph_alloc(context, nph_film_scratch_bytes(state->choice.transport.film_channels), 1, "film scratch",
                          &worker->film_scratch));
        state->kernels.layout(worker->memory, state->scene, &worker->batch);
    }
    return NPH_OK;
}

static NphStatus open_path(const NphJob *job, void **out) {
    PathState *state = NULL;
    NPH_TRY(NPH_NEW(job->context, 1, "path tracer", &state));
    state->job = *job;
    state->threads = nph_context_threads(job->context);
    nph_path_choose(job, &state->choice);
    nph_path_kernels(nph_context_isa(job->context), job->precision, &state->kernels);
    NphStatus status = open_workers(state);
    if (status != NPH_OK) {
        close_path(state);
        return status;
    }
    *out = state;
    return NPH_OK;
}

/* One batch from camera to film: the stages in order, until no path is left. */
static void run_batch(PathState *state, PathWorker *worker, int64_t tile, int64_t chunk) {
    const NphPathKernels *k = &state->kernels;
    const NphPathChoice *choice = &state->choice;
    NphPathBatch *batch = worker->batch;
    NphStageCounts *counts = &worker->counts;
    int origin[2], inside[4], lights = state->job.scene->light_count;
    nph_film_tile_rect(state->film, tile, origin, inside);
    k->begin(batch, origin, inside, chunk);
    NPH_LAUNCH(counts, NPH_PATH_GENERATE, k->count(batch), k->generate(batch));
    for (int l = 0; l < lights && nph_sensor_gathers(state->job.scene->sensor.kind); l++)
        if (choice->transport.sampled[l]) NPH_LAUNCH(counts, NPH_PATH_SHADOW, k->count(batch), k->shadow(batch, l, 1));
    while (k->count(batch) > 0) {
        NPH_LAUNCH(counts, NPH_PATH_TRACK, k->count(batch), k->track(batch));
        if (choice->transport.emission) NPH_LAUNCH(counts, NPH_PATH_EMISSION, k->count(batch), k->emission(batch));
        for (int l = 0; l < lights; l++)
            if (choice->near_m[l] > 0.0) NPH_LAUNCH(counts, NPH_PATH_NEAR, k->count(batch), k->near_light(batch, l));
        if (choice->transport.channels > 1) NPH_LAUNCH(counts, NPH_PATH_TRACK, 0, k->reweigh(batch));
        NPH_LAUNCH(counts, NPH_PATH_ESCAPE, k->count(batch), k->escape(batch));
        for (int l = 0; l < lights; l++)
            if (choice->near_m[l] > 0.0)
                NPH_LAUNCH(counts, NPH_PATH_NEAR, k->count(batch), k->around_light(batch, l));
        for (int l = 0; l < lights && (choice->transport.scatters || choice->transport.reflects); l++)
            if (choice->transport.sampled[l]) NPH_LAUNCH(counts, NPH_PATH_SHADOW, k->count(batch), k->shadow(batch, l, 0));
        NPH_LAUNCH(counts, NPH_PATH_SCATTER, k->count(batch), k->scatter(batch));
    }
    if (choice->forced) k->fold(batch);
    NPH_LAUNCH(counts, NPH_PATH_ACCUMULATE, NPH_TILE_PIXELS,
               nph_film_add_chunk(state->film, tile, chunk, state->job.precision, k->samples(batch), worker->film_scratch));
}

/* A block of the pool: one tile, all chunks of the pass; a request to stop is heard after each chunk. */
static NphStatus run_tile(void *opaque, int64_t tile, int index) {
    PathState *state = opaque;
    PathWorker *worker = &state->workers[index];
    int64_t chunk = state->begin / NPH_CHUNK;
    for (; chunk < state->end / NPH_CHUNK && !nph_interrupted(state->job.context); chunk++)
        run_batch(state, worker, tile, chunk);
    if (index == 0) { /* the calling thread reports; the others' tiles are estimated from its own */
        state->tiles_done += nph_context_threads(state->job.context);
        int64_t tiles = nph_film_tile_count(state->film);
        double part = (double)state->tiles_done / (double)tiles;
        part = part < 1.0 ? part : 1.0;
        double done = (double)state->done + part * (double)(state->end - state->begin);
        double elapsed = nph_seconds() - state->started;
        double left = done > 0.0 ? elapsed * ((double)state->total - done) / done : -1.0;
        nph_progress(state->job.context, "rendering", done, (double)state->total, left);
    }
    return NPH_OK;
}

static NphStatus run_path(void *opaque, NphFilm *film, int64_t begin, int64_t end, int64_t done, int64_t total) {
    PathState *state = opaque;
    state->film = film;
    state->begin = begin;
    state->end = end;
    state->done = done;
    state->total = total;
    state->tiles_done = 0;
    if (done == 0) state->started = nph_seconds();
    return nph_pool_run(state->job.context, nph_film_tile_count(film), run_tile, state, NULL);
}

static void statistics(const void *opaque, NphRenderStatistics *out) {
    const PathState *state = opaque;
    nph_stages_begin(stages, NPH_PATH_STAGES, out);
    for (int w = 0; w < state->threads; w++) {
        nph_stages_add(&state->workers[w].counts, out);
        nph_tally_add(state->kernels.tally(state->workers[w].batch), out);
    }
}

static NphStatus replay(const NphJob *job, int x, int y, int64_t sample, NphLineFn line, void *user) {
    NphPathChoice choice;
    NphPathKernels kernels;
    void *scene = NULL;
    nph_path_choose(job, &choice);
    nph_path_kernels(NPH_ISA_BASE, job->precision, &kernels);
    NPH_TRY(nph_alloc(job->context, kernels.scene_bytes(choice.transport.groups), 1, "scene for the kernels", &scene));
    kernels.prepare(job, &choice, scene);
    double fields[NPH_SAMPLE_FIELDS];
    kernels.replay(scene, (int[2]){x, y}, sample, line, user, fields);
    nph_free(job->context, scene);
    return NPH_OK;
}

const NphMethod nph_path = {
    .name = "path",
    .takes_wavelengths = 1,
    .summary = "unbiased path tracer: delta tracking, ratio-tracked light samples, no depth limit",
    .knobs = knobs,
    .knob_count = NPH_PATH_KNOBS,
    .stages = stages,
    .stage_count = NPH_PATH_STAGES,
    .buffers = buffers,
    .buffer_count = (int)(sizeof buffers / sizeof *buffers),
    .plan = nph_path_plan,
    .channels = channels,
    .open = open_path,
    .run = run_path,
    .statistics = statistics,
    .close = close_path,
    .replay = replay,
};
