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

static const NphStage stages[NPH_LIGHT_STAGES] = {
    {"light.trace", "light tracing [Dutre93]; delta and ratio tracking [Woodcock65] [Novak14]", "", "light.image", {1, 1, 1}, 0},
    {"light.see", "light that meets nothing: a ray or light samples per pixel", "light.image", "light.sample",
     {NPH_TILE_PIXELS * NPH_CHUNK, 1, 1}, 0},
    {"light.accumulate", "moments in a dyadic tree [Chan79] [Pebay08]", "light.sample", "film.node", {NPH_TILE_PIXELS, 1, 1}, 0},
};

static const NphBuffer buffers[] = {
    {"light.image", NPH_F64, "[sample][channel, order][pixel]", "W/m2/sr", "what the photons of each sample bring", NPH_STAT,
     NULL, NULL, 0},
    {"light.sample", NPH_TYPE_REAL, "[field][pixel][sample]", "W/m2/sr, 1", "what each sample carries", NPH_STAT, NULL, NULL, 0},
    {"film.node", NPH_F64, "[moment][pixel]", "powers of W/m2/sr", "count, mean, central moments, of pixels and regions",
     NPH_STAT, NULL, NULL, 0},
};

typedef struct LightWorker {
    void *samples, *film_scratch;
    NphTally tally;
    NphStageCounts counts;
} LightWorker;

typedef struct LightState {
    NphJob job;
    NphLightChoice choice;
    NphEmissionSources sources;
    NphLightKernels kernels;
    void *scene;
    double *planes;
    size_t image_doubles;
    NphLightImage images[NPH_CHUNK];
    int threads;
    LightWorker *workers;
    /* of the pass under way */
    NphFilm *film;
    int64_t chunk, images_done, images_total, images_before;
    double started;
} LightState;

size_t nph_light_sample_bytes(int precision) {
    return (size_t)(precision / 8) * NPH_SAMPLE_FIELDS * NPH_TILE_PIXELS * NPH_CHUNK;
}

static int channels(const NphJob *job) {
    NphTransportChoice choice;
    nph_transport_choose(job->scene, job->plan_full, &choice);
    return choice.film_channels;
}

static void close_light(void *opaque) {
    LightState *state = opaque;
    if (!state) return;
    NphContext *context = state->job.context;
    for (int w = 0; state->workers && w < state->threads; w++) {
        nph_free(context, state->workers[w].samples);
        nph_free(context, state->workers[w].film_scratch);
    }
    nph_free(context, state->workers);
    nph_emission_sources_free(context, &state->sources);
    nph_free(context, state->planes);
    nph_free(context, state->scene);
    nph_free(context, state);
}

static NphStatus open_buffers(LightState *state) {
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
    NPH_TRY(NPH_NEW(context, state->threads, "workers", &state->workers));
    for (int w = 0; w < state->threads; w++) {
        LightWorker *worker = &state->workers[w];
        NPH_TRY(nph_alloc(context, nph_light_sample_bytes(state->job.precision), 1, "samples of a tile", &worker->samples));
        NPH_TRY(nph_alloc(context, nph_film_scratch_bytes(film_channels), 1, "film scratch", &worker->film_scratch));
    }
    return NPH_OK;
}

static NphStatus open_light(const NphJob *job, void **out) {
    LightState *state = NULL;
    NPH_TRY(NPH_NEW(job->context, 1, "light tracer", &state));
    state->job = *job;
    state->threads = nph_context_threads(job->context);
    nph_light_kernels(job->precision, &state->kernels);
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

static void report(LightState *state, int64_t of_chunk) {
    int64_t done = state->images_done + of_chunk;
    double elapsed = nph_seconds() - state->started, made = (double)(done - state->images_before);
    double left = made > 0.0 ? elapsed * (double)(state->images_total - done) / made : -1.0;
    nph_progress(state->job.context, "tracing light", (double)done, (double)state->images_total, left);
}

/* A block of the pool: one image. */
static NphStatus run_image(void *opaque, int64_t index, int worker) {
    LightState *state = opaque;
    NphLightImage *image = &state->images[index];
    if (nph_interrupted(state->job.context)) return NPH_OK;
    image->sample = state->chunk * NPH_CHUNK + index;
    memset(image->planes, 0, state->image_doubles * sizeof *image->planes);
    NPH_LAUNCH(&state->workers[worker].counts, NPH_LIGHT_TRACE, state->choice.photons,
               state->kernels.trace(state->scene, image));
    if (worker == 0) report(state, index);
    return NPH_OK;
}

/* A block of the pool: one tile of the chunk's images. */
static NphStatus run_tile(void *opaque, int64_t tile, int index) {
    LightState *state = opaque;
    LightWorker *worker = &state->workers[index];
    int origin[2], inside[4];
    nph_film_tile_rect(state->film, tile, origin, inside);
    NPH_LAUNCH(&worker->counts, NPH_LIGHT_SEE, NPH_TILE_PIXELS * NPH_CHUNK,
               state->kernels.see(state->scene, state->images, origin, inside, worker->samples, &worker->tally));
    NPH_LAUNCH(&worker->counts, NPH_LIGHT_ACCUMULATE, NPH_TILE_PIXELS,
               nph_film_add_chunk(state->film, tile, state->chunk, state->job.precision, worker->samples,
                                  worker->film_scratch));
    return NPH_OK;
}

/* The chunk of images becomes the film's, whole: tiles that a request to stop would leave out are added here. */
static NphStatus add_chunk(LightState *state) {
    int64_t completed = 0, tiles = nph_film_tile_count(state->film);
    NphStatus status = nph_pool_run(state->job.context, tiles, run_tile, state, &completed);
    if (status != NPH_OK && status != NPH_INTERRUPTED) return status;
    for (int64_t tile = completed; status == NPH_INTERRUPTED && tile < tiles; tile++) run_tile(state, tile, 0);
    nph_film_end_chunk(state->film, state->chunk);
    return status;
}

/* A request to stop is heard between images: the chunk under way is then left out. */
static NphStatus run_light(void *opaque, NphFilm *film, int64_t begin, int64_t end, int64_t done, int64_t total) {
    LightState *state = opaque;
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
    const LightState *state = opaque;
    nph_stages_begin(stages, NPH_LIGHT_STAGES, out);
    for (int i = 0; i < NPH_CHUNK; i++) nph_tally_add(&state->images[i].tally, out);
    for (int w = 0; w < state->threads; w++) {
        nph_stages_add(&state->workers[w].counts, out);
        nph_tally_add(&state->workers[w].tally, out);
    }
}

/* Traces the sample's whole image once more and tells every arrival in the pixel. */
static void tell_pixel(const LightState *state, NphLightImage images[NPH_CHUNK], void *samples, NphLineFn line, void *user) {
    const NphJob *job = &state->job;
    const NphLightImage *own = &images[0];
    char text[256];
    int x = own->crop[0], y = own->crop[1], origin[2] = {x / NPH_TILE * NPH_TILE, y / NPH_TILE * NPH_TILE};
    NphTally tally = {0, 0, 0, 0};
    double fields[NPH_SAMPLE_FIELDS];
    snprintf(text, sizeof text, "light: pixel %d,%d of the image of %lld photons that is sample %lld, seed %u, frame %u", x, y,
             (long long)state->choice.photons, (long long)own->sample, job->seed, job->frame);
    line(user, text);
    state->kernels.trace(state->scene, &images[0]);
    for (int i = 1; i < NPH_CHUNK; i++) images[i] = images[0];
    state->kernels.see(state->scene, images, origin, own->crop, samples, &tally);
    size_t pixel = (size_t)((y - origin[1]) * NPH_TILE + x - origin[0]) * NPH_CHUNK, plane = NPH_TILE_PIXELS * NPH_CHUNK;
    for (size_t f = 0; f < NPH_SAMPLE_FIELDS; f++)
        fields[f] = job->precision == 32 ? (double)((const float *)samples)[f * plane + pixel]
                                         : ((const double *)samples)[f * plane + pixel];
    snprintf(text, sizeof text, "  seen without scattering: transmittance %.9g %.9g %.9g", fields[NPH_SAMPLE_T0],
             fields[NPH_SAMPLE_T1], fields[NPH_SAMPLE_T2]);
    line(user, text);
    snprintf(text, sizeof text, "result: %.9g %.9g %.9g", fields[NPH_SAMPLE_L0], fields[NPH_SAMPLE_L1], fields[NPH_SAMPLE_L2]);
    line(user, text);
}

static NphStatus replay(const NphJob *job, int x, int y, int64_t sample, NphLineFn line, void *user) {
    void *state = NULL, *samples = NULL;
    NphJob pixel = *job;
    memcpy(pixel.crop, (int[4]){x, y, x + 1, y + 1}, sizeof pixel.crop);
    NPH_TRY(open_light(&pixel, &state));
    NphStatus status = nph_alloc(job->context, nph_light_sample_bytes(job->precision), 1, "samples of a tile", &samples);
    if (status == NPH_OK) {
        LightState *light = state;
        light->images[0].sample = sample;
        light->images[0].line = line;
        light->images[0].user = user;
        tell_pixel(light, light->images, samples, line, user);
    }
    nph_free(job->context, samples);
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
    .buffers = buffers,
    .buffer_count = (int)(sizeof buffers / sizeof *buffers),
    .plan = nph_light_plan,
    .channels = channels,
    .open = open_light,
    .run = run_light,
    .statistics = statistics,
    .close = close_light,
    .replay = replay,
};
