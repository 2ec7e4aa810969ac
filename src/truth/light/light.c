/* SPDX-License-Identifier: Apache-2.0
 *
 * truth/light as a method: its knobs, stages and buffers, the run over chunks of images, statistics and replay. A chunk
 * is 16 images: each is traced by one thread; then tiles, by any thread, take them to the film. */
#include "truth/light/light_tracing.h"

#include <stdio.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"

static const NphKnob knobs[NPH_LIGHT_KNOBS] = {
    {"light.photons", "1", "photons of one sample; 0: as many as the picture has pixels", "time against variance", 0.0, 0.0,
     4294967295.0},
    {"light.roulette", "1", "part of its first weight below which a photon may be ended by chance", "time against variance",
     0.1, 0.0, 1.0},
    {"light.connect_roulette", "1", "transmittance to the sensor below which a connection may be ended by chance",
     "time against variance", 0.05, 0.0, 1.0},
    {"light.count", "1", "1: a flux sensor counts photons that cross it; 0: every flight scores its expected crossing",
     "time against variance", 0.0, 0.0, 1.0},
    {"light.split", "1", "how far photons are split on their way through layers to a level flux sensor: 1 as the light dies "
     "out, 0 not", "variance of little transmitted light against time", 0.0, 0.0, 2.0},
};

#define PHOTONS "light.ray light.power light.unit light.source light.hero"
#define REST "light.place light.waiting light.waiting_at"
#define FLIGHTS \
    "light.flight light.flight_ray light.flight_weight light.flight_share light.flight_hero light.flight_order " \
    "light.flight_distance light.flight_medium light.flight_surface light.flight_touch light.flight_left"
#define SPLATS "light.splat light.splat_at light.splat_add light.splat_from light.splat_order"

static const NphStage stages[NPH_LIGHT_STAGES] = {
    {"light.emit", "light tracing [Dutre93]", "", PHOTONS " " REST, {NPH_LIGHT_BLOCK, 1, 1}, 0},
    {"light.trace", "delta tracking [Woodcock65]; roulette [Arvo90]", PHOTONS " " REST, FLIGHTS " " REST, {NPH_LIGHT_BLOCK, 1, 1}, 0},
    {"light.connect", "light tracing [Dutre93]; ratio tracking [Novak14]", "light.source " FLIGHTS, SPLATS, {NPH_LIGHT_FLIGHTS, 1, 1}, 0},
    {"light.splat", "a pixel is a mean over its area", SPLATS " light.image", "light.image", {NPH_LIGHT_FLIGHTS, 1, 1}, 0},
    {"light.see", "light that meets nothing: a ray or light samples per pixel", "light.traced", "light.sample",
     {NPH_TILE_PIXELS * NPH_CHUNK, 1, 1}, 0},
    {"light.accumulate", "moments in a dyadic tree [Chan79] [Pebay08]", "light.sample", "film.node", {NPH_TILE_PIXELS, 1, 1}, 0},
};

static const char *const arguments[NPH_LIGHT_ARGUMENTS] = {"sample", "block", "tile"};

size_t nph_light_sample_bytes(int precision) {
    return (size_t)(precision / 8) * NPH_SAMPLE_FIELDS * NPH_TILE_PIXELS * NPH_CHUNK;
}

size_t nph_light_traced_doubles(int film_channels) { return (size_t)(film_channels + 1) * NPH_TILE_PIXELS * NPH_CHUNK; }

static int channels(const NphJob *job) {
    NphTransportChoice choice;
    nph_transport_choose(job->scene, job->plan_full, &choice);
    return choice.film_channels;
}

static void close_light(void *opaque) {
    NphLightState *state = opaque;
    if (!state) return;
    NphContext *context = state->job.context;
    for (int w = 0; state->workers && w < state->threads; w++) {
        nph_free(context, state->workers[w].memory);
        nph_free(context, state->workers[w].columns);
        nph_free(context, state->workers[w].samples);
        nph_free(context, state->workers[w].traced);
        nph_free(context, state->workers[w].film_scratch);
    }
    nph_free(context, state->workers);
    nph_emission_sources_free(context, &state->sources);
    nph_free(context, state->planes);
    nph_free(context, state->scene);
    nph_free(context, state);
}

NphStatus nph_light_open_columns(NphLightState *state, int index) {
    NphLightWorker *worker = &state->workers[index];
    NPH_TRY(nph_alloc(state->job.context, state->kernels.column_bytes(), 1, "flights and splats as others see them",
                      &worker->columns));
    state->kernels.layout(worker->memory, worker->columns, state->scene, &worker->batch);
    return NPH_OK;
}

static NphStatus open_workers(NphLightState *state) {
    NphContext *context = state->job.context;
    int film_channels = state->choice.transport.film_channels;
    NPH_TRY(NPH_NEW(context, state->threads, "workers", &state->workers));
    for (int w = 0; w < state->threads; w++) {
        NphLightWorker *worker = &state->workers[w];
        void *scratch = NULL;
        NPH_TRY(nph_alloc(context, state->kernels.batch_bytes(), 1, "batch of photons", &worker->memory));
        NPH_TRY(nph_alloc(context, nph_light_sample_bytes(state->job.precision), 1, "samples of a tile", &worker->samples));
        NPH_TRY(NPH_NEW(context, nph_light_traced_doubles(film_channels), "a tile of images", &worker->traced));
        NPH_TRY(nph_alloc(context, nph_film_scratch_bytes(film_channels), 1, "film scratch", &scratch));
        worker->film_scratch = scratch;
        state->kernels.layout(worker->memory, NULL, state->scene, &worker->batch);
        if (state->job.tap) NPH_TRY(nph_light_open_columns(state, w));
    }
    return NPH_OK;
}

static NphStatus open_buffers(NphLightState *state) {
    NphContext *context = state->job.context;
    const int *crop = state->job.crop;
    int film_channels = state->choice.transport.film_channels;
    state->image_doubles = (size_t)(crop[2] - crop[0]) * (size_t)(crop[3] - crop[1]) * (size_t)(film_channels + 1);
    NPH_TRY(nph_alloc(context, state->kernels.scene_bytes(), 1, "scene for the kernels", &state->scene));
    state->kernels.prepare(&state->job, &state->choice, &state->sources, state->scene);
    NPH_TRY(NPH_NEW(context, state->image_doubles * NPH_CHUNK, "images of photons", &state->planes));
    for (int i = 0; i < NPH_CHUNK; i++) {
        memcpy(state->images[i].crop, crop, sizeof state->images[i].crop);
        state->images[i].planes = state->planes + (size_t)i * state->image_doubles;
    }
    return open_workers(state);
}

static NphStatus open_light(const NphJob *job, void **out) {
    NphLightState *state = NULL;
    NPH_TRY(NPH_NEW(job->context, 1, "light tracer", &state));
    state->job = *job;
    state->threads = nph_context_threads(job->context);
    nph_light_kernels(nph_context_isa(job->context), job->precision, &state->kernels);
    NphStatus status = nph_light_sources(job, &state->sources);
    if (status == NPH_OK) status = nph_light_choose(job, &state->sources, &state->choice);
    if (status == NPH_OK) status = open_buffers(state);
    if (status != NPH_OK) {
        close_light(state);
        return status;
    }
    *out = state;
    return NPH_OK;
}

static void report(NphLightState *state, int64_t of_chunk) {
    int64_t done = state->images_done + of_chunk;
    double elapsed = nph_seconds() - state->started, made = (double)(done - state->images_before);
    double left = made > 0.0 ? elapsed * (double)(state->images_total - done) / made : -1.0;
    nph_progress(state->job.context, "tracing light", (double)done, (double)state->images_total, left);
}

int64_t nph_light_blocks(const NphLightState *state) { return (state->choice.photons + NPH_LIGHT_BLOCK - 1) / NPH_LIGHT_BLOCK; }

/* What the worker's traced and samples hold is of this tile. */
static void see(NphLightState *state, NphLightWorker *worker, const NphLaunch *launch) {
    int origin[2], inside[4];
    nph_film_tile_rect(state->film, launch->arguments[NPH_LIGHT_ARG_TILE], origin, inside);
    state->kernels.see(state->scene, worker->traced, origin, inside, launch->arguments[NPH_LIGHT_ARG_SAMPLE], worker->samples,
                       state->kernels.tally(worker->batch));
}

void nph_light_launch(NphLightState *state, int index, const NphLaunch *launch) {
    const NphLightKernels *k = &state->kernels;
    NphLightWorker *worker = &state->workers[index];
    switch ((NphLightStage)launch->stage) {
    case NPH_LIGHT_EMIT: k->emit(worker->batch); break;
    case NPH_LIGHT_TRACE: k->trace(worker->batch); break;
    case NPH_LIGHT_CONNECT: k->connect(worker->batch); break;
    case NPH_LIGHT_SPLAT: k->splat(worker->batch, worker->image); break;
    case NPH_LIGHT_SEE: see(state, worker, launch); break;
    case NPH_LIGHT_ACCUMULATE: nph_film_chunk(state->film, state->job.precision, worker->samples, worker->film_scratch); break;
    default: break;
    }
}

/* The next launch of a batch. */
static NphStatus step(NphLightState *state, int index, NphLaunch *launch, NphLightStage stage) {
    const NphTap *tap = state->job.tap;
    NphLightWorker *worker = &state->workers[index];
    launch->stage = (int)stage;
    launch->items = stage == NPH_LIGHT_SEE          ? NPH_TILE_PIXELS * NPH_CHUNK
                    : stage == NPH_LIGHT_ACCUMULATE ? NPH_TILE_PIXELS
                                                    : state->kernels.items(worker->batch, stage);
    if (tap) NPH_TRY(tap->before(tap->user, state, index, launch));
    NPH_LAUNCH(&worker->counts, stage, launch->items, nph_light_launch(state, index, launch));
    if (tap) NPH_TRY(tap->after(tap->user, state, index, launch));
    launch->number++;
    return NPH_OK;
}

/* All photons of a sample, into its image. */
static NphStatus trace_image(NphLightState *state, int index, NphLightImage *image, int64_t batch) {
    const NphLightKernels *k = &state->kernels;
    NphLightBatch *own = state->workers[index].batch;
    NphLaunch launch = {.batch = batch, .arguments = {image->sample}};
    memset(image->planes, 0, state->image_doubles * sizeof *image->planes);
    state->workers[index].image = image;
    for (int64_t block = 0; block < nph_light_blocks(state); block++) {
        launch.arguments[NPH_LIGHT_ARG_BLOCK] = block;
        k->begin(own, image->sample, block);
        NPH_TRY(step(state, index, &launch, NPH_LIGHT_EMIT));
        while (k->unfinished(own)) {
            NPH_TRY(step(state, index, &launch, NPH_LIGHT_TRACE));
            NPH_TRY(step(state, index, &launch, NPH_LIGHT_CONNECT));
            NPH_TRY(step(state, index, &launch, NPH_LIGHT_SPLAT));
        }
    }
    return NPH_OK;
}

/* Batches of a chunk: its images, then its tiles. */
static int64_t batch_of(const NphLightState *state, int64_t number) {
    return state->chunk * (NPH_CHUNK + nph_film_tile_count(state->film)) + number;
}

/* A block of the pool: one image. */
static NphStatus run_image(void *opaque, int64_t index, int worker) {
    NphLightState *state = opaque;
    NphLightImage *image = &state->images[index];
    if (nph_interrupted(state->job.context)) return NPH_OK;
    image->sample = state->chunk * NPH_CHUNK + index;
    NPH_TRY(trace_image(state, worker, image, batch_of(state, index)));
    if (worker == 0) report(state, index);
    return NPH_OK;
}

/* What the images hold in a tile, by pixel and sample. */
static void take_tile(const NphLightState *state, const NphLightImage images[NPH_CHUNK], const int origin[2], const int inside[4],
                      double *traced) {
    enum { PLANE = NPH_TILE_PIXELS * NPH_CHUNK };
    const int *crop = images->crop;
    int channels = state->choice.transport.film_channels;
    int64_t width = crop[2] - crop[0], pixels = width * (crop[3] - crop[1]);
    memset(traced, 0, nph_light_traced_doubles(channels) * sizeof *traced);
    for (int c = 0; c <= channels; c++)
        for (int y = inside[1]; y < inside[3]; y++)
            for (int x = inside[0]; x < inside[2]; x++) {
                int64_t from = c * pixels + (y - crop[1]) * width + x - crop[0];
                double *to = traced + c * PLANE + ((y - origin[1]) * NPH_TILE + x - origin[0]) * NPH_CHUNK;
                for (int i = 0; i < NPH_CHUNK; i++) to[i] = images[i].planes[from];
            }
}

/* A block of the pool: one tile of the chunk's images. */
static NphStatus run_tile(void *opaque, int64_t tile, int index) {
    NphLightState *state = opaque;
    NphLightWorker *worker = &state->workers[index];
    NphLaunch launch = {.batch = batch_of(state, NPH_CHUNK + tile), .arguments = {state->chunk * NPH_CHUNK, 0, tile}};
    int origin[2], inside[4];
    nph_film_tile_rect(state->film, tile, origin, inside);
    take_tile(state, state->images, origin, inside, worker->traced);
    NPH_TRY(step(state, index, &launch, NPH_LIGHT_SEE));
    NPH_TRY(step(state, index, &launch, NPH_LIGHT_ACCUMULATE));
    nph_film_add_node(state->film, tile, state->chunk, state->job.precision, worker->samples, worker->film_scratch);
    return NPH_OK;
}

/* The chunk of images becomes the film's, whole: tiles that a request to stop would leave out are added here. */
static NphStatus add_chunk(NphLightState *state) {
    int64_t completed = 0, tiles = nph_film_tile_count(state->film);
    NphStatus status = nph_pool_run(state->job.context, tiles, run_tile, state, &completed);
    if (status != NPH_OK && status != NPH_INTERRUPTED) return status;
    for (int64_t tile = completed; status == NPH_INTERRUPTED && tile < tiles; tile++) NPH_TRY(run_tile(state, tile, 0));
    nph_film_end_chunk(state->film, state->chunk);
    return status;
}

/* A request to stop is heard between images: the chunk under way is then left out. */
static NphStatus run_light(void *opaque, NphFilm *film, int64_t begin, int64_t end, int64_t done, int64_t total) {
    NphLightState *state = opaque;
    NphContext *context = state->job.context;
    state->film = film;
    if (done == 0) state->started = nph_seconds();
    state->images_before = 0;
    state->images_total = total;
    state->images_done = done;
    for (state->chunk = begin / NPH_CHUNK; state->chunk < end / NPH_CHUNK; state->chunk++) {
        NPH_TRY(nph_pool_run(context, NPH_CHUNK, run_image, state, NULL));
        if (nph_interrupted(context)) return NPH_INTERRUPTED;
        NphStatus status = add_chunk(state);
        state->images_done += NPH_CHUNK;
        NPH_TRY(status);
    }
    return NPH_OK;
}

static void statistics(const void *opaque, NphRenderStatistics *out) {
    const NphLightState *state = opaque;
    nph_stages_begin(stages, NPH_LIGHT_STAGES, out);
    for (int w = 0; w < state->threads; w++) {
        nph_stages_add(&state->workers[w].counts, out);
        nph_tally_add(state->kernels.tally(state->workers[w].batch), out);
    }
}

/* Traces the sample's whole image once more and tells every arrival in the pixel. */
static NphStatus tell_pixel(NphLightState *state, NphLineFn line, void *user) {
    const NphJob *job = &state->job;
    NphLightWorker *worker = &state->workers[0];
    NphLightImage *own = &state->images[0];
    char text[256];
    int x = own->crop[0], y = own->crop[1], origin[2] = {x / NPH_TILE * NPH_TILE, y / NPH_TILE * NPH_TILE};
    double fields[NPH_SAMPLE_FIELDS];
    snprintf(text, sizeof text, "light: pixel %d,%d of the image of %lld photons that is sample %lld, seed %u, frame %u", x, y,
             (long long)state->choice.photons, (long long)own->sample, job->seed, job->frame);
    line(user, text);
    NPH_TRY(trace_image(state, 0, own, 0));
    take_tile(state, state->images, origin, own->crop, worker->traced);
    state->kernels.see(state->scene, worker->traced, origin, own->crop, own->sample, worker->samples,
                       state->kernels.tally(worker->batch));
    size_t pixel = (size_t)((y - origin[1]) * NPH_TILE + x - origin[0]) * NPH_CHUNK, plane = NPH_TILE_PIXELS * NPH_CHUNK;
    for (size_t f = 0; f < NPH_SAMPLE_FIELDS; f++)
        fields[f] = job->precision == 32 ? (double)((const float *)worker->samples)[f * plane + pixel]
                                         : ((const double *)worker->samples)[f * plane + pixel];
    snprintf(text, sizeof text, "  seen without scattering: transmittance %.9g %.9g %.9g", fields[NPH_SAMPLE_T0],
             fields[NPH_SAMPLE_T1], fields[NPH_SAMPLE_T2]);
    line(user, text);
    snprintf(text, sizeof text, "result: %.9g %.9g %.9g", fields[NPH_SAMPLE_L0], fields[NPH_SAMPLE_L1], fields[NPH_SAMPLE_L2]);
    line(user, text);
    return NPH_OK;
}

static NphStatus replay(const NphJob *job, int x, int y, int64_t sample, NphLineFn line, void *user) {
    void *opaque = NULL;
    NphJob pixel = *job;
    memcpy(pixel.crop, (int[4]){x, y, x + 1, y + 1}, sizeof pixel.crop);
    NPH_TRY(open_light(&pixel, &opaque));
    NphLightState *state = opaque;
    state->images[0].sample = sample;
    state->images[0].line = line;
    state->images[0].user = user;
    NphStatus status = tell_pixel(state, line, user);
    close_light(state);
    return status;
}

const NphMethod nph_light = {
    .name = "light",
    .summary = "light tracing: photons from the lights, every vertex connected to the sensor, no depth limit",
    .knobs = knobs,
    .knob_count = NPH_LIGHT_KNOBS,
    .stages = stages,
    .stage_count = NPH_LIGHT_STAGES,
    .shares_samples = 1,
    .buffers = nph_light_buffers,
    .buffer_count = NPH_LIGHT_BUFFERS,
    .plan = nph_light_plan,
    .channels = channels,
    .open = open_light,
    .run = run_light,
    .statistics = statistics,
    .close = close_light,
    .replay = replay,
    .arguments = arguments,
    .argument_count = NPH_LIGHT_ARGUMENTS,
    .begin_launch = nph_light_begin_launch,
    .extend = nph_light_extend,
    .view = nph_light_view,
    .hold = nph_light_hold,
    .check = nph_light_check,
    .launch = nph_light_launch_alone,
};
