/* SPDX-License-Identifier: Apache-2.0
 *
 * truth/single as a method: its knobs, stages and buffers, the run over tiles and chunks, statistics and replay. */
#include "truth/single/single.h"

#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"

static const NphKnob knobs[NPH_SINGLE_KNOBS] = {
    {"single.tolerance", "1",
     "largest estimated error of what a light sends by one scattering along a ray, relative to it",
     "accuracy against time", 1e-3, 1e-9, 0.1},
    {"single.panels", "1", "panels along the media on a ray to begin with, at least: what is narrower may be missed",
     "safety against time", 8.0, 1.0, 256.0},
    {"single.mode", "1",
     "0: all lights, by quadrature [Kajiya84]; 1: suns alone, as parallel light, in a layer by the closed "
     "form [Blinn82]",
     "completeness against time", 0.0, 0.0, 1.0},
};

#define RAYS {NPH_SINGLE_BATCH, 1, 1}
#define MET "single.surface single.touch"

static const NphStage stages[NPH_SINGLE_STAGES] = {
    {"single.generate", "camera rays of path", "", "single.ray single.sample", RAYS, 0},
    {"single.meet", "surfaces [Woop13]", "single.ray", MET " single.part", RAYS, 0},
    {"single.gather", "balance heuristic [Veach95]", "single.ray single.part", "single.part", RAYS, 0},
    {"single.march", "single scattering [Kajiya84] [Blinn82]; adaptive product rule", "single.ray " MET " single.part",
     "single.transmittance single.scattered single.part", {1, 1, 1}, sizeof(int32_t) * NPH_SINGLE_PANELS_MAX},
    {"single.arrive", "single scattering [Kajiya84]; Lambert's cosine", "single.ray " MET " single.transmittance single.part", "single.part",
     RAYS, 0},
    {"single.leave", "balance heuristic [Veach95]", "single.ray " MET " single.transmittance single.part", "single.part", RAYS, 0},
    {"single.fold", "linearity", "single.part single.sample", "single.sample", RAYS, 0},
    {"single.accumulate", "moments in a dyadic tree [Chan79] [Pebay08]", "single.sample", "film.node", {NPH_TILE_PIXELS, 1, 1}, 0},
};

static const char *const arguments[NPH_SINGLE_ARGUMENTS] = {"tile", "chunk", "group"};

typedef struct SingleWorker {
    NphSingleBatch batch;
    void *memory, *film_scratch;
    NphStageCounts counts;
} SingleWorker;

typedef struct SingleState {
    NphJob job;
    NphSingleScene *scene;
    NphSingleLaunchFn launch;
    int threads;
    SingleWorker *workers;
    /* of the pass under way */
    NphFilm *film;
    int64_t begin, end, done, total, tiles_done;
    double started;
} SingleState;

static int channels(const NphJob *job) {
    NphSingleChoice choice;
    nph_single_choose(job, &choice);
    return choice.transport.film_channels;
}

static void close_single(void *opaque) {
    SingleState *state = opaque;
    if (!state) return;
    NphContext *context = state->job.context;
    for (int w = 0; state->workers && w < state->threads; w++) {
        nph_free(context, state->workers[w].batch.rows);
        nph_free(context, state->workers[w].batch.samples);
        nph_free(context, state->workers[w].batch.surface);
        nph_free(context, state->workers[w].memory);
        nph_free(context, state->workers[w].film_scratch);
    }
    nph_free(context, state->workers);
    nph_free(context, state->scene);
    nph_free(context, state);
}

static NphStatus open_workers(SingleState *state) {
    NphContext *context = state->job.context;
    NPH_TRY(NPH_NEW(context, nph_single_groups(&state->job), "scene of the marcher", &state->scene));
    nph_single_prepare(&state->job, state->scene);
    NPH_TRY(NPH_NEW(context, state->threads, "workers", &state->workers));
    int fields = nph_single_fields(state->job.scene);
    for (int w = 0; w < state->threads; w++) {
        SingleWorker *worker = &state->workers[w];
        NPH_TRY(NPH_NEW(context, nph_single_batch_doubles(state->job.scene), "rays", &worker->batch.rows));
        NPH_TRY(NPH_NEW(context, NPH_SINGLE_BATCH * NPH_SAMPLE_FIELDS, "samples", &worker->batch.samples));
        NPH_TRY(NPH_NEW(context, NPH_SINGLE_BATCH, "surfaces of rays", &worker->batch.surface));
        NPH_TRY(nph_alloc(context, nph_single_scratch_bytes(fields), 1, "pieces and panels of a ray", &worker->memory));
        NPH_TRY(nph_alloc(context, nph_film_scratch_bytes(state->scene->choice.transport.film_channels), 1,
                          "film scratch", &worker->film_scratch));
        nph_single_scratch_layout(worker->memory, fields, &worker->batch.scratch);
        worker->batch.scenes = state->scene;
    }
    return NPH_OK;
}

static NphStatus open_single(const NphJob *job, void **out) {
    SingleState *state = NULL;
    NPH_TRY(NPH_NEW(job->context, 1, "single scattering", &state));
    state->job = *job;
    state->threads = nph_context_threads(job->context);
    state->launch = nph_single_kernel(nph_context_isa(job->context));
    NphStatus status = open_workers(state);
    if (status != NPH_OK) {
        close_single(state);
        return status;
    }
    *out = state;
    return NPH_OK;
}

/* A batch is a tile and a chunk. */
static void begin_batch(const SingleState *state, SingleWorker *worker, int64_t tile, int64_t chunk) {
    nph_film_tile_rect(state->film, tile, worker->batch.origin, worker->batch.inside);
    worker->batch.chunk = chunk;
    worker->batch.group = 0;
}

static void launch_stage(const SingleState *state, SingleWorker *worker, const NphLaunch *launch) {
    worker->batch.group = (int)launch->arguments[NPH_SINGLE_GROUP];
    if (launch->stage == NPH_SINGLE_ACCUMULATE) nph_film_chunk(state->film, 64, worker->batch.samples, worker->film_scratch);
    else state->launch(&worker->batch, (NphSingleStage)launch->stage);
}

/* The next launch of a batch. */
static NphStatus step(SingleState *state, SingleWorker *worker, NphLaunch *launch, NphSingleStage stage) {
    const NphTap *tap = state->job.tap;
    const int *in = worker->batch.inside;
    int index = (int)(worker - state->workers);
    launch->stage = (int)stage;
    launch->items = stage == NPH_SINGLE_ACCUMULATE ? NPH_TILE_PIXELS : (int64_t)(in[2] - in[0]) * (in[3] - in[1]) * NPH_CHUNK;
    if (tap) NPH_TRY(tap->before(tap->user, state, index, launch));
    NPH_LAUNCH(&worker->counts, stage, launch->items, launch_stage(state, worker, launch));
    if (tap) NPH_TRY(tap->after(tap->user, state, index, launch));
    launch->number++;
    return NPH_OK;
}

static NphStatus run_batch(SingleState *state, SingleWorker *worker, int64_t tile, int64_t chunk) {
    const RScene *local = &state->scene->local;
    NphLaunch launch = {.batch = chunk * nph_film_tile_count(state->film) + tile, .arguments = {tile, chunk}};
    begin_batch(state, worker, tile, chunk);
    NPH_TRY(step(state, worker, &launch, NPH_SINGLE_GENERATE));
    for (int g = 0; g < local->groups; g++) {
        launch.arguments[NPH_SINGLE_GROUP] = g;
        NPH_TRY(step(state, worker, &launch, NPH_SINGLE_MEET));
        if (nph_sensor_gathers(local->sensor.kind)) NPH_TRY(step(state, worker, &launch, NPH_SINGLE_GATHER));
        NPH_TRY(step(state, worker, &launch, NPH_SINGLE_MARCH));
        if (local->surfaces.count > 0) NPH_TRY(step(state, worker, &launch, NPH_SINGLE_ARRIVE));
        NPH_TRY(step(state, worker, &launch, NPH_SINGLE_LEAVE));
        NPH_TRY(step(state, worker, &launch, NPH_SINGLE_FOLD));
    }
    NPH_TRY(step(state, worker, &launch, NPH_SINGLE_ACCUMULATE));
    nph_film_add_node(state->film, tile, chunk, 64, worker->batch.samples, worker->film_scratch);
    return NPH_OK;
}

static NphStatus begin_launch(void *opaque, int index, NphFilm *film, const NphLaunch *launch) {
    SingleState *state = opaque;
    int64_t tile = launch->arguments[NPH_SINGLE_TILE], chunk = launch->arguments[NPH_SINGLE_CHUNK];
    int64_t group = launch->arguments[NPH_SINGLE_GROUP];
    int groups = state->scene->local.groups;
    if (tile < 0 || tile >= nph_film_tile_count(film) || chunk < 0 || chunk >= NPH_MAX_SAMPLES / NPH_CHUNK || group < 0 || group >= groups)
        return nph_error(state->job.context, NPH_BAD_INPUT, "tile %lld, chunk %lld, group %lld: the picture has %lld tiles, the scene %d "
                         "groups of wavelengths", (long long)tile, (long long)chunk, (long long)group,
                         (long long)nph_film_tile_count(film), groups);
    state->film = film;
    begin_batch(state, &state->workers[index], tile, chunk);
    return NPH_OK;
}

/* All buffers are of one size: another one is told by whoever compares it with the view's. */
static NphStatus extend(void *opaque, int index, int buffer, const int64_t *shape) {
    (void)opaque;
    (void)index;
    (void)buffer;
    (void)shape;
    return NPH_OK;
}

static int view(void *opaque, int index, int buffer, NphView *out) {
    SingleState *state = opaque;
    SingleWorker *worker = &state->workers[index];
    if (buffer != NPH_SINGLE_NODE) return nph_single_view(&worker->batch, buffer, out);
    *out = (NphView){NPH_F64, 2, {nph_film_planes(state->film), NPH_TILE_PIXELS}, worker->film_scratch, NPH_TILE_PIXELS};
    return 1;
}

static NphStatus check(void *opaque, int index, const NphLaunch *launch) {
    SingleState *state = opaque;
    return nph_single_check(state->job.context, &state->workers[index].batch, &stages[launch->stage]);
}

static NphStatus launch_alone(void *opaque, int index, const NphLaunch *launch) {
    SingleState *state = opaque;
    launch_stage(state, &state->workers[index], launch);
    return NPH_OK;
}

/* A block of the pool: one tile, all chunks of the pass; a request to stop is heard after each chunk. */
static NphStatus run_tile(void *opaque, int64_t tile, int index) {
    SingleState *state = opaque;
    int64_t chunk = state->begin / NPH_CHUNK;
    for (; chunk < state->end / NPH_CHUNK && !nph_interrupted(state->job.context); chunk++)
        NPH_TRY(run_batch(state, &state->workers[index], tile, chunk));
    if (index == 0) { /* the calling thread reports; the others' tiles are estimated from its own */
        state->tiles_done += state->threads;
        double part = (double)state->tiles_done / (double)nph_film_tile_count(state->film);
        part = part < 1.0 ? part : 1.0;
        double done = (double)state->done + part * (double)(state->end - state->begin),
               elapsed = nph_seconds() - state->started;
        double left = done > 0.0 ? elapsed * ((double)state->total - done) / done : -1.0;
        nph_progress(state->job.context, "marching", done, (double)state->total, left);
    }
    return NPH_OK;
}

static NphStatus run_single(void *opaque, NphFilm *film, int64_t begin, int64_t end, int64_t done, int64_t total) {
    SingleState *state = opaque;
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
    const SingleState *state = opaque;
    nph_stages_begin(stages, NPH_SINGLE_STAGES, out);
    for (int w = 0; w < state->threads; w++) {
        const NphSingleTally *tally = nph_single_tally(state->workers[w].batch.scratch);
        nph_stages_add(&state->workers[w].counts, out);
        out->exhausted += tally->walked.exhausted;
        out->integrals += tally->integrals;
        out->integrand_points += tally->points;
        out->unconverged += tally->unconverged;
        out->worst_residual = tally->worst > out->worst_residual ? tally->worst : out->worst_residual;
    }
}

static NphStatus replay_with(const NphJob *job, NphSingleScene *scene, void *memory, int x, int y, int64_t sample,
                             NphLineFn line, void *user) {
    NphSingleScratch *scratch = NULL;
    nph_single_prepare(job, scene);
    nph_single_scratch_layout(memory, nph_single_fields(job->scene), &scratch);
    uint32_t pixel = (uint32_t)y * (uint32_t)scene->local.width + (uint32_t)x;
    NphSingleAsk ask = {pixel, (uint32_t)sample, line, user};
    RCameraRay ray = nph_single_ray(&scene->local, x, y, pixel, (uint32_t)sample);
    double fields[NPH_SAMPLE_FIELDS], at[3];
    for (int a = 0; a < 3; a++) at[a] = ray.p[a] + scene->local.origin[a];
    nph_single_tell(&ask, "single: pixel %d,%d sample %lld, seed %u, frame %u", x, y, (long long)sample, job->seed,
                    job->frame);
    nph_single_tell(&ask, "  camera ray at %.9g %.9g %.9g (%.9g m from the sensor) along %.9g %.9g %.9g", at[0], at[1],
                    at[2], ray.start, ray.d[0], ray.d[1], ray.d[2]);
    nph_single_march(scene, scratch, &ray, &ask, fields);
    nph_single_tell(&ask, "result: %.17g %.17g %.17g", fields[0], fields[1], fields[2]);
    return NPH_OK;
}

static NphStatus replay(const NphJob *job, int x, int y, int64_t sample, NphLineFn line, void *user) {
    NphSingleScene *scene = NULL;
    void *memory = NULL;
    NphStatus status = NPH_NEW(job->context, nph_single_groups(job), "scene of the marcher", &scene);
    if (status == NPH_OK)
        status = nph_alloc(job->context, nph_single_scratch_bytes(nph_single_fields(job->scene)), 1,
                           "pieces and panels of a ray", &memory);
    if (status == NPH_OK) status = replay_with(job, scene, memory, x, y, sample, line, user);
    nph_free(job->context, memory);
    nph_free(job->context, scene);
    return status;
}

const NphMethod nph_single = {
    .name = "single",
    .summary = "light scattered at most once, by deterministic quadrature to a stated tolerance",
    .knobs = knobs,
    .knob_count = NPH_SINGLE_KNOBS,
    .stages = stages,
    .stage_count = NPH_SINGLE_STAGES,
    .buffers = nph_single_buffers,
    .buffer_count = NPH_SINGLE_BUFFERS,
    .plan = nph_single_plan,
    .channels = channels,
    .open = open_single,
    .run = run_single,
    .statistics = statistics,
    .close = close_single,
    .replay = replay,
    .takes_wavelengths = 1,
    .arguments = arguments,
    .argument_count = NPH_SINGLE_ARGUMENTS,
    .begin_launch = begin_launch,
    .extend = extend,
    .view = view,
    .check = check,
    .launch = launch_alone,
};
