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

static const NphStage stages[NPH_SINGLE_STAGES] = {
    {"single.generate", "camera rays of path", "", "single.ray", {NPH_SINGLE_BATCH, 1, 1}, 0},
    {"single.march",
     "single scattering [Kajiya84] [Blinn82]; adaptive product rule",
     "single.ray",
     "single.sample",
     {1, 1, 1},
     sizeof(int32_t) * NPH_SINGLE_PANELS_MAX},
    {"single.accumulate",
     "moments in a dyadic tree [Chan79] [Pebay08]",
     "single.sample",
     "film.node",
     {NPH_TILE_PIXELS, 1, 1},
     0},
};

static const NphBuffer buffers[] = {
    {"single.ray", NPH_F64, "[9][ray]", "m, 1",
     "position and direction, scene-local; distance to the sensor, weight, density", NPH_NEAR, NULL, NULL, 0},
    {"single.sample", NPH_F64, "[field][ray]", "W/m2/sr, m, 1", "what each ray carries", NPH_NEAR, NULL, NULL, 0},
    {"film.node", NPH_F64, "[moment][pixel]", "powers of W/m2/sr", "count, mean, central moments", NPH_STAT, NULL, NULL, 0},
};

typedef struct SingleWorker {
    RCameraRay *rays;
    double *samples;
    void *memory, *film_scratch;
    NphSingleScratch *scratch;
    NphStageCounts counts;
} SingleWorker;

typedef struct SingleState {
    NphJob job;
    NphSingleScene *scene;
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
        nph_free(context, state->workers[w].rays);
        nph_free(context, state->workers[w].samples);
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
        NPH_TRY(NPH_NEW(context, NPH_SINGLE_BATCH, "camera rays", &worker->rays));
        NPH_TRY(NPH_NEW(context, NPH_SINGLE_BATCH * NPH_SAMPLE_FIELDS, "samples", &worker->samples));
        NPH_TRY(nph_alloc(context, nph_single_scratch_bytes(fields), 1, "pieces and panels of a ray", &worker->memory));
        NPH_TRY(nph_alloc(context, nph_film_scratch_bytes(state->scene->choice.transport.film_channels), 1,
                          "film scratch", &worker->film_scratch));
        nph_single_scratch_layout(worker->memory, fields, &worker->scratch);
    }
    return NPH_OK;
}

static NphStatus open_single(const NphJob *job, void **out) {
    SingleState *state = NULL;
    NPH_TRY(NPH_NEW(job->context, 1, "single scattering", &state));
    state->job = *job;
    state->threads = nph_context_threads(job->context);
    NphStatus status = open_workers(state);
    if (status != NPH_OK) {
        close_single(state);
        return status;
    }
    *out = state;
    return NPH_OK;
}

static RCameraRay camera_ray(const RScene *scene, int x, int y, uint32_t pixel, uint32_t sample) {
    RStream stream = r_stream(scene, NPH_RNG_GENERATE, pixel, sample, 0);
    RCameraRay ray;
    r_camera_ray(scene, x, y, &stream, &ray);
    return ray;
}

static int is_inside(const int inside[4], int x, int y) {
    return x >= inside[0] && x < inside[2] && y >= inside[1] && y < inside[3];
}

/* A ray: pixel in tile * 16 + sample in chunk. */
static void generate(const RScene *scene, const int origin[2], const int inside[4], int64_t chunk, RCameraRay *rays) {
    for (int id = 0; id < NPH_SINGLE_BATCH; id++) {
        int x = origin[0] + ((id >> 4) & 15), y = origin[1] + (id >> 8);
        uint32_t pixel = (uint32_t)y * (uint32_t)scene->width + (uint32_t)x;
        if (is_inside(inside, x, y))
            rays[id] = camera_ray(scene, x, y, pixel, (uint32_t)(chunk * NPH_CHUNK + (id & 15)));
    }
}

static void march(const SingleState *state, SingleWorker *worker, const int origin[2], const int inside[4],
                  int64_t chunk) {
    const RScene *local = &state->scene->local;
    for (int id = 0; id < NPH_SINGLE_BATCH; id++) {
        int x = origin[0] + ((id >> 4) & 15), y = origin[1] + (id >> 8);
        double fields[NPH_SAMPLE_FIELDS] = {0.0};
        NphSingleAsk ask = {(uint32_t)y * (uint32_t)local->width + (uint32_t)x,
                            (uint32_t)(chunk * NPH_CHUNK + (id & 15)), NULL, NULL};
        if (is_inside(inside, x, y)) nph_single_march(state->scene, worker->scratch, &worker->rays[id], &ask, fields);
        for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) worker->samples[f * NPH_SINGLE_BATCH + id] = fields[f];
    }
}

static void run_batch(SingleState *state, SingleWorker *worker, int64_t tile, int64_t chunk) {
    int origin[2], inside[4];
    nph_film_tile_rect(state->film, tile, origin, inside);
    int64_t rays = (int64_t)(inside[2] - inside[0]) * (inside[3] - inside[1]) * NPH_CHUNK;
    NPH_LAUNCH(&worker->counts, NPH_SINGLE_GENERATE, rays,
               generate(&state->scene->local, origin, inside, chunk, worker->rays));
    NPH_LAUNCH(&worker->counts, NPH_SINGLE_MARCH, rays, march(state, worker, origin, inside, chunk));
    NPH_LAUNCH(&worker->counts, NPH_SINGLE_ACCUMULATE, NPH_TILE_PIXELS,
               nph_film_add_chunk(state->film, tile, chunk, 64, worker->samples, worker->film_scratch));
}

/* A block of the pool: one tile, all chunks of the pass; a request to stop is heard after each chunk. */
static NphStatus run_tile(void *opaque, int64_t tile, int index) {
    SingleState *state = opaque;
    int64_t chunk = state->begin / NPH_CHUNK;
    for (; chunk < state->end / NPH_CHUNK && !nph_interrupted(state->job.context); chunk++)
        run_batch(state, &state->workers[index], tile, chunk);
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
        const NphSingleTally *tally = nph_single_tally(state->workers[w].scratch);
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
    RCameraRay ray = camera_ray(&scene->local, x, y, pixel, (uint32_t)sample);
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
    .buffers = buffers,
    .buffer_count = (int)(sizeof buffers / sizeof *buffers),
    .plan = nph_single_plan,
    .channels = channels,
    .open = open_single,
    .run = run_single,
    .statistics = statistics,
    .close = close_single,
    .replay = replay,
    .takes_wavelengths = 1,
};
