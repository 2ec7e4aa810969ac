/* SPDX-License-Identifier: Apache-2.0
 *
 * truth/path as a method: its knobs, stages and buffers, the run over tiles and chunks, statistics and replay. */
#include "truth/path/path.h"

#include <string.h>

#include "core/fmath.h"
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

#define PATHS {NPH_PATH_BATCH, 1, 1}
#define RAYS "path.id path.hero path.ray path.weight path.pdf"
#define VERTICES "path.distance path.medium path.surface path.touch path.colliding path.touching"

static const NphStage stages[NPH_PATH_STAGES] = {
    {"path.majorant", "largest samples; chessboard distances [Rosenfeld66]", "path.density", "path.bound", {512, 1, 1}, 0},
    {"path.generate", "pinhole, parallel and flux sensors; box filter", "",
     "path.id path.hero path.ray path.weight path.share path.pdf path.origin path.start path.sample", PATHS, 0},
    {"path.gather", "ratio tracking [Novak14]; balance heuristic [Veach95]", RAYS " path.origin path.sample", "path.sample", PATHS, 0},
    {"path.track", "delta tracking [Woodcock65]; surfaces [Woop13]", "path.id path.hero path.ray path.weight path.collided",
     "path.distance path.medium path.surface path.touch path.flown path.weight path.colliding path.touching path.leaving "
     "path.collided", PATHS, 0},
    {"path.emission", "events of a Poisson process [Kingman93]", RAYS " path.share path.distance path.sample", "path.sample", PATHS, 0},
    {"path.near", "equiangular sampling [Kulla12]; balance heuristic [Veach95]", RAYS " path.share path.distance path.sample",
     "path.sample", PATHS, 0},
    {"path.reweigh", "spectral MIS [Wilkie14] [Miller19]", RAYS " path.share path.distance path.medium",
     "path.weight path.share", PATHS, 0},
    {"path.escape", "balance heuristic [Veach95]", RAYS " path.flown path.leaving path.aside path.sample", "path.sample path.aside", PATHS, 0},
    {"path.around", "balance heuristic [Veach95]", RAYS " " VERTICES " path.sample", "path.sample", PATHS, 0},
    {"path.shadow", "ratio tracking [Novak14]; balance heuristic [Veach95]", RAYS " " VERTICES " path.sample",
     "path.sample", PATHS, 0},
    {"path.scatter", "phase function sampling; roulette [Arvo90]", RAYS " path.share path.start path.collided " VERTICES " path.sample",
     "path.id path.hero path.ray path.weight path.share path.pdf path.sample", PATHS, 0},
    {"path.fold", "linearity", "path.collided path.aside path.sample", "path.sample", PATHS, 0},
    {"path.accumulate", "moments in a dyadic tree [Chan79] [Pebay08]", "path.sample", "film.node", {NPH_TILE_PIXELS, 1, 1}, 0},
};

static const char *const arguments[NPH_PATH_ARGUMENTS] = {"tile", "chunk", "vertex", "light", "medium"};

static const NphBuffer buffers[NPH_PATH_BUFFERS] = {
    [NPH_PATH_DENSITY] = {"path.density", NPH_F32, "[z][y][x]", "file's", "samples of a medium's lattice, padding included", NPH_NEAR,
                          "a medium is a grid", NULL, 0},
    [NPH_PATH_BOUND] = {"path.bound", NPH_F32, "[z][y][x]", "file's", "of cells of 4^3 samples: bound of the density, its last 4 bits "
                        "the mean; where empty, minus how many cells may be skipped", NPH_NEAR, "a medium is a grid", NULL, 0},
    [NPH_PATH_ID] = {"path.id", NPH_I32, "[path]", "1", "which sample: pixel in its tile times 16 and sample in its chunk", NPH_EXACT,
                     NULL, "path.id", 0},
    [NPH_PATH_HERO] = {"path.hero", NPH_I32, "[path]", "1", "channel that decides collisions; three times the group and channel in it",
                       NPH_EXACT, NULL, "path.id", 0},
    [NPH_PATH_RAY] = {"path.ray", NPH_TYPE_REAL, "[6][path]", "m, 1", "position and direction, scene-local", NPH_NEAR, NULL, "path.id", 0},
    [NPH_PATH_WEIGHT] = {"path.weight", NPH_TYPE_REAL, "[channel][path]", "1", "throughput", NPH_NEAR, NULL, "path.id", 0},
    [NPH_PATH_SHARE] = {"path.share", NPH_TYPE_REAL, "[channel][path]", "1",
                        "probability of the path had the channel been the hero, over the channels' mean", NPH_NEAR, NULL, "path.id", 0},
    [NPH_PATH_PDF] = {"path.pdf", NPH_TYPE_REAL, "[path]", "1/sr", "density of the direction; negative: no light sample could find it",
                      NPH_NEAR, NULL, "path.id", 0},
    [NPH_PATH_ORIGIN] = {"path.origin", NPH_TYPE_REAL, "[3][path]", "m", "point of the sensor", NPH_NEAR, "the sensor gathers",
                         "path.id", 0},
    [NPH_PATH_DISTANCE] = {"path.distance", NPH_TYPE_REAL, "[path]", "m", "to the collision; without one how far was looked", NPH_NEAR,
                           NULL, "path.id", 0},
    [NPH_PATH_MEDIUM] = {"path.medium", NPH_I32, "[path]", "1", "position of the medium it happens in; -1: none", NPH_EXACT, NULL,
                         "path.id", 0},
    [NPH_PATH_SURFACE] = {"path.surface", NPH_I32, "[path]", "1", "surface that the flight ends at if nothing collides; -1: none",
                          NPH_EXACT, "there are surfaces", "path.id", 0},
    [NPH_PATH_TOUCH] = {"path.touch", NPH_TYPE_REAL, "[7][path]", "m, 1", "where light leaves that surface, its normal, how far it is",
                        NPH_NEAR, "there are surfaces", "path.id", 0},
    [NPH_PATH_FLOWN] = {"path.flown", NPH_TYPE_REAL, "[2][path]", "1",
                        "weight of virtual collisions and depth by the cells' means; of split rays what passes and what collides",
                        NPH_NEAR, "flights are weighed or split", "path.id", 0},
    [NPH_PATH_COLLIDING] = {"path.colliding", NPH_I32, "[queue]", "1", "positions of the paths that collide", NPH_EXACT, NULL,
                            "path.id", 1},
    [NPH_PATH_TOUCHING] = {"path.touching", NPH_I32, "[queue]", "1", "positions of the paths at surfaces", NPH_EXACT,
                           "there are surfaces", "path.id", 1},
    [NPH_PATH_LEAVING] = {"path.leaving", NPH_I32, "[queue]", "1", "positions of the paths that leave", NPH_EXACT, NULL, "path.id", 1},
    [NPH_PATH_START] = {"path.start", NPH_TYPE_REAL, "[id]", "m", "from the sensor to where the path began", NPH_NEAR, NULL, NULL, 0},
    [NPH_PATH_COLLIDED] = {"path.collided", NPH_TYPE_REAL, "[id]", "1", "weight of all but what passed", NPH_NEAR, "camera rays are split",
                           NULL, 0},
    [NPH_PATH_ASIDE] = {"path.aside", NPH_TYPE_REAL, "[3][id]", "W/m2/sr", "light of what passed", NPH_NEAR, "camera rays are split", NULL,
                        0},
    [NPH_PATH_SAMPLE] = {"path.sample", NPH_TYPE_REAL, "[field][id]", "W/m2/sr, 1, m",
                         "radiance, transmittance (3 channels each), order, distance and weight of the first vertex", NPH_NEAR, NULL, NULL, 0},
    [NPH_PATH_NODE] = {"film.node", NPH_F64, "[moment][pixel]", "powers of W/m2/sr",
                       "of 16 samples: mean, M2, M3, M4 per channel, then means", NPH_NEAR, NULL, NULL, 0},
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
    NphPathField field; /* of path.majorant, on worker 0 */
    float *bounds[NPH_MAX_MEDIA]; /* what it made, where somebody looks on: these are walked */
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
    nph_path_field_free(context, &state->field);
    for (int m = 0; m < NPH_MAX_MEDIA; m++) nph_free(context, state->bounds[m]);
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

/* A batch is a tile and a chunk: where it lies, and no paths yet. */
static void begin_batch(const PathState *state, PathWorker *worker, int64_t tile, int64_t chunk) {
    int origin[2], inside[4];
    nph_film_tile_rect(state->film, tile, origin, inside);
    state->kernels.begin(worker->batch, origin, inside, chunk);
}

static void launch_stage(PathState *state, PathWorker *worker, const NphLaunch *launch) {
    const NphPathKernels *k = &state->kernels;
    NphPathBatch *batch = worker->batch;
    int light = (int)launch->arguments[NPH_PATH_LIGHT];
    switch ((NphPathStage)launch->stage) {
    case NPH_PATH_GENERATE: k->generate(batch); break;
    case NPH_PATH_TRACK: k->track(batch); break;
    case NPH_PATH_EMISSION: k->emission(batch); break;
    case NPH_PATH_NEAR: k->near_light(batch, light); break;
    case NPH_PATH_REWEIGH: k->reweigh(batch); break;
    case NPH_PATH_ESCAPE: k->escape(batch); break;
    case NPH_PATH_AROUND: k->around_light(batch, light); break;
    case NPH_PATH_GATHER: k->shadow(batch, light, 1); break;
    case NPH_PATH_SHADOW: k->shadow(batch, light, 0); break;
    case NPH_PATH_SCATTER: k->scatter(batch); break;
    case NPH_PATH_FOLD: k->fold(batch); break;
    case NPH_PATH_ACCUMULATE:
        nph_film_chunk(state->film, state->job.precision, k->samples(batch), worker->film_scratch);
        break;
    default: break;
    }
}

/* The next launch of a batch. */
static NphStatus step(PathState *state, PathWorker *worker, NphLaunch *launch, NphPathStage stage, int light) {
    const NphTap *tap = state->job.tap;
    int index = (int)(worker - state->workers);
    launch->stage = (int)stage;
    launch->items = stage == NPH_PATH_ACCUMULATE ? NPH_TILE_PIXELS : stage == NPH_PATH_GENERATE ? NPH_PATH_BATCH : state->kernels.count(worker->batch);
    launch->arguments[NPH_PATH_LIGHT] = light;
    if (tap) NPH_TRY(tap->before(tap->user, state, index, launch));
    NPH_LAUNCH(&worker->counts, stage, launch->items, launch_stage(state, worker, launch));
    if (tap) NPH_TRY(tap->after(tap->user, state, index, launch));
    launch->number++;
    return NPH_OK;
}

/* The stages of a vertex: from a flight to the next direction. */
static NphStatus run_vertex(PathState *state, PathWorker *worker, NphLaunch *launch) {
    const NphPathChoice *choice = &state->choice;
    int lights = state->job.scene->light_count, turns = choice->transport.scatters || choice->transport.reflects;
    NPH_TRY(step(state, worker, launch, NPH_PATH_TRACK, 0));
    if (choice->transport.emission) NPH_TRY(step(state, worker, launch, NPH_PATH_EMISSION, 0));
    for (int l = 0; l < lights; l++)
        if (choice->near_m[l] > 0.0) NPH_TRY(step(state, worker, launch, NPH_PATH_NEAR, l));
    if (choice->transport.channels > 1) NPH_TRY(step(state, worker, launch, NPH_PATH_REWEIGH, 0));
    NPH_TRY(step(state, worker, launch, NPH_PATH_ESCAPE, 0));
    for (int l = 0; l < lights; l++)
        if (choice->near_m[l] > 0.0) NPH_TRY(step(state, worker, launch, NPH_PATH_AROUND, l));
    for (int l = 0; l < lights && turns; l++)
        if (choice->transport.sampled[l]) NPH_TRY(step(state, worker, launch, NPH_PATH_SHADOW, l));
    return step(state, worker, launch, NPH_PATH_SCATTER, 0);
}

/* One batch from camera to film: the stages in order, until no path is left. */
static NphStatus run_batch(PathState *state, PathWorker *worker, int64_t tile, int64_t chunk) {
    const NphPathKernels *k = &state->kernels;
    const NphPathChoice *choice = &state->choice;
    NphView split;
    NphLaunch launch = {.batch = chunk * nph_film_tile_count(state->film) + tile, .arguments = {tile, chunk}};
    begin_batch(state, worker, tile, chunk);
    NPH_TRY(step(state, worker, &launch, NPH_PATH_GENERATE, 0));
    for (int l = 0; l < state->job.scene->light_count && nph_sensor_gathers(state->job.scene->sensor.kind); l++)
        if (choice->transport.sampled[l]) NPH_TRY(step(state, worker, &launch, NPH_PATH_GATHER, l));
    for (; k->count(worker->batch) > 0; launch.arguments[NPH_PATH_VERTEX]++) NPH_TRY(run_vertex(state, worker, &launch));
    if (k->view(worker->batch, NPH_PATH_COLLIDED, &split)) NPH_TRY(step(state, worker, &launch, NPH_PATH_FOLD, 0));
    NPH_TRY(step(state, worker, &launch, NPH_PATH_ACCUMULATE, 0));
    nph_film_add_node(state->film, tile, chunk, state->job.precision, k->samples(worker->batch), worker->film_scratch);
    return NPH_OK;
}

static NphStatus run_majorant(PathState *state, NphLaunch *launch, int m) {
    const NphTap *tap = state->job.tap;
    const NphMedium *medium = &state->job.scene->media[m];
    const int32_t *cells = medium->grid.majorant.n;
    NphStatus status = NPH_OK;
    launch->arguments[NPH_PATH_OF_MEDIUM] = m;
    launch->items = (int64_t)cells[0] * cells[1] * cells[2];
    NPH_TRY(nph_path_field_begin(&state->job, &state->choice, m, &state->field));
    nph_grid_dense(&medium->grid, state->field.density);
    NPH_TRY(tap->before(tap->user, state, 0, launch));
    NPH_LAUNCH(&state->workers[0].counts, NPH_PATH_MAJORANT, launch->items, status = nph_path_field_bound(&state->job, &state->field));
    if (status == NPH_OK) status = tap->after(tap->user, state, 0, launch);
    if (status == NPH_OK) status = nph_path_field_check(&state->job, &state->field);
    if (status != NPH_OK) return status;
    state->bounds[m] = state->field.majorant.cells;
    state->field.majorant.cells = NULL;
    state->kernels.walk_bounds(state->scene, state->choice.transport.groups, m, state->bounds[m]);
    launch->number++;
    return NPH_OK;
}

/* Majorants were made when the grids were read. Where somebody looks on they are made once more, of the samples that are shown, and what
 * is left when all have looked is what flights walk. */
static NphStatus run_majorants(PathState *state) {
    NphLaunch launch = {.stage = NPH_PATH_MAJORANT, .batch = NPH_BATCH_OF_SCENE};
    for (int m = 0; m < state->job.scene->medium_count && state->job.tap; m++)
        if (state->choice.transport.used[m] && state->job.scene->media[m].shape == NPH_SHAPE_GRID)
            NPH_TRY(run_majorant(state, &launch, m));
    nph_path_field_free(state->job.context, &state->field);
    return NPH_OK;
}

static NphStatus begin_launch(void *opaque, int index, NphFilm *film, const NphLaunch *launch) {
    PathState *state = opaque;
    if (launch->stage == NPH_PATH_MAJORANT)
        return nph_path_field_begin(&state->job, &state->choice, launch->arguments[NPH_PATH_OF_MEDIUM], &state->field);
    int64_t tile = launch->arguments[NPH_PATH_TILE], chunk = launch->arguments[NPH_PATH_CHUNK];
    int64_t light = launch->arguments[NPH_PATH_LIGHT], vertex = launch->arguments[NPH_PATH_VERTEX];
    state->film = film;
    if (tile < 0 || tile >= nph_film_tile_count(film) || chunk < 0 || chunk >= NPH_MAX_SAMPLES / NPH_CHUNK || light < 0 ||
        light >= (state->job.scene->light_count > 0 ? state->job.scene->light_count : 1) || vertex < 0 || vertex > UINT32_MAX)
        return nph_error(state->job.context, NPH_BAD_INPUT, "tile %lld, chunk %lld, vertex %lld, light %lld: the picture has %lld "
                         "tiles, the scene %d lights", (long long)tile, (long long)chunk, (long long)vertex, (long long)light,
                         (long long)nph_film_tile_count(film), state->job.scene->light_count);
    begin_batch(state, &state->workers[index], tile, chunk);
    state->kernels.set_vertex(state->workers[index].batch, vertex);
    return NPH_OK;
}

static NphStatus extend(void *opaque, int index, int buffer, const int64_t *shape) {
    PathState *state = opaque;
    if (buffer == NPH_PATH_DENSITY || buffer == NPH_PATH_BOUND) return NPH_OK; /* as large as the medium has them */
    int rank = 1 + (buffers[buffer].shape[1 + strcspn(buffers[buffer].shape + 1, "[")] == '[');
    NphStatus status = state->kernels.extend(state->workers[index].batch, buffer, shape[rank - 1]);
    return status == NPH_OK ? status
                            : nph_error(state->job.context, status, "%s: %lld items, a batch has room for %d", buffers[buffer].name,
                                        (long long)shape[rank - 1], NPH_PATH_BATCH);
}

static int view(void *opaque, int index, int buffer, NphView *out) {
    PathState *state = opaque;
    PathWorker *worker = &state->workers[index];
    if (buffer == NPH_PATH_DENSITY || buffer == NPH_PATH_BOUND) return nph_path_field_view(&state->field, buffer, out);
    if (buffer != NPH_PATH_NODE) return state->kernels.view(worker->batch, buffer, out);
    *out = (NphView){NPH_F64, 2, {nph_film_planes(state->film), NPH_TILE_PIXELS}, worker->film_scratch, NPH_TILE_PIXELS};
    return 1;
}

/* What indexes something, and where paths are: others' inputs may hold anything. */
static NphStatus check(void *opaque, int index, const NphLaunch *launch) {
    PathState *state = opaque;
    PathWorker *worker = &state->workers[index];
    const NphStage *stage = &stages[launch->stage];
    if (launch->stage == NPH_PATH_MAJORANT) return nph_path_field_check(&state->job, &state->field);
    static const int checked[] = {NPH_PATH_ID, NPH_PATH_HERO, NPH_PATH_RAY, NPH_PATH_ORIGIN, NPH_PATH_DISTANCE, NPH_PATH_MEDIUM,
                                  NPH_PATH_SURFACE, NPH_PATH_TOUCH, NPH_PATH_COLLIDING, NPH_PATH_TOUCHING, NPH_PATH_LEAVING};
    int media = 0, paths = state->kernels.count(worker->batch);
    for (int m = 0; m < state->job.scene->medium_count; m++) media += state->choice.transport.used[m];
    for (size_t c = 0; c < sizeof checked / sizeof *checked; c++) {
        const NphBuffer *buffer = &buffers[checked[c]];
        NphView seen;
        int64_t most = checked[c] == NPH_PATH_ID        ? NPH_PATH_BATCH - 1
                       : checked[c] == NPH_PATH_HERO    ? 3 * state->choice.transport.groups - 1
                       : checked[c] == NPH_PATH_MEDIUM  ? media - 1
                       : checked[c] == NPH_PATH_SURFACE ? state->job.scene->surface_count - 1
                                                        : paths - 1;
        int64_t least = checked[c] == NPH_PATH_MEDIUM || checked[c] == NPH_PATH_SURFACE ? -1 : 0;
        if (!nph_stage_lists(stage->reads, buffer->name) || !state->kernels.view(worker->batch, checked[c], &seen)) continue;
        int64_t wrong = nph_view_wrong(&seen, least, most);
        if (wrong >= 0)
            return nph_error(state->job.context, NPH_BAD_INPUT, "input %s: value %lld is not %s", buffer->name, (long long)wrong,
                             seen.type == NPH_I32 ? "one of this scene and these paths" : "finite");
    }
    return NPH_OK;
}

static NphStatus launch_alone(void *opaque, int index, const NphLaunch *launch) {
    PathState *state = opaque;
    if (launch->stage == NPH_PATH_MAJORANT) return nph_path_field_bound(&state->job, &state->field);
    launch_stage(state, &state->workers[index], launch);
    return NPH_OK;
}

/* A block of the pool: one tile, all chunks of the pass; a request to stop is heard after each chunk. */
static NphStatus run_tile(void *opaque, int64_t tile, int index) {
    PathState *state = opaque;
    PathWorker *worker = &state->workers[index];
    int64_t chunk = state->begin / NPH_CHUNK;
    for (; chunk < state->end / NPH_CHUNK && !nph_interrupted(state->job.context); chunk++)
        NPH_TRY(run_batch(state, worker, tile, chunk));
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
    if (done == 0) {
        state->started = nph_seconds();
        NPH_TRY(run_majorants(state));
    }
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

/* Without a run: the scene as the kernels of base see it, of the caller. */
static NphStatus prepare_alone(const NphJob *job, NphPathChoice *choice, NphPathKernels *kernels, void **scene) {
    nph_path_choose(job, choice);
    nph_path_kernels(NPH_ISA_BASE, job->precision, kernels);
    NPH_TRY(nph_alloc(job->context, kernels->scene_bytes(choice->transport.groups), 1, "scene for the kernels", scene));
    kernels->prepare(job, choice, *scene);
    return NPH_OK;
}

static NphStatus replay(const NphJob *job, int x, int y, int64_t sample, NphLineFn line, void *user) {
    NphPathChoice choice;
    NphPathKernels kernels;
    void *scene = NULL;
    double fields[NPH_SAMPLE_FIELDS];
    NPH_TRY(prepare_alone(job, &choice, &kernels, &scene));
    kernels.replay(scene, (int[2]){x, y}, sample, line, user, fields);
    nph_free(job->context, scene);
    return NPH_OK;
}

static NphStatus facts(const NphJob *job, NphFactFn fact, void *user) {
    NphPathChoice choice;
    NphPathKernels kernels;
    void *scene = NULL;
    NPH_TRY(prepare_alone(job, &choice, &kernels, &scene));
    kernels.facts(scene, choice.transport.groups, fact, user);
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
    .buffer_count = NPH_PATH_BUFFERS,
    .plan = nph_path_plan,
    .channels = channels,
    .open = open_path,
    .run = run_path,
    .statistics = statistics,
    .close = close_path,
    .replay = replay,
    .arguments = arguments,
    .argument_count = NPH_PATH_ARGUMENTS,
    .begin_launch = begin_launch,
    .extend = extend,
    .view = view,
    .check = check,
    .launch = launch_alone,
    .facts = facts,
};
