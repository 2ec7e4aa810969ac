/* SPDX-License-Identifier: Apache-2.0
 *
 * The memory of light tracing: the scene, and a worker's batch of photons, flights and splats (light_state.h); where its
 * buffers lie. */
#include <string.h>

#include "transport/prepare_lookup.h"
#include "truth/light/light_state.h"

size_t NPH_KERNEL(nph_light_scene_bytes)(void);
void NPH_KERNEL(nph_light_prepare)(const NphJob *job, const NphLightChoice *choice, const NphEmissionSources *sources,
                                   void *memory);
size_t NPH_KERNEL(nph_light_batch_bytes)(void);
void NPH_KERNEL(nph_light_layout)(void *memory, const void *scene, NphLightBatch **batch);
void NPH_KERNEL(nph_light_begin)(NphLightBatch *batch, int64_t sample, int64_t block);
int NPH_KERNEL(nph_light_unfinished)(const NphLightBatch *batch);
int64_t NPH_KERNEL(nph_light_items)(const NphLightBatch *batch, NphLightStage stage);
NphStatus NPH_KERNEL(nph_light_extend)(NphLightBatch *batch, int buffer, int64_t items);
int NPH_KERNEL(nph_light_view)(NphLightBatch *batch, int buffer, NphView *view);
NphTally *NPH_KERNEL(nph_light_tally)(NphLightBatch *batch);

size_t NPH_KERNEL(nph_light_scene_bytes)(void) { return sizeof(RLightScene); }

void NPH_KERNEL(nph_light_prepare)(const NphJob *job, const NphLightChoice *choice, const NphEmissionSources *sources,
                                   void *memory) {
    RLightScene *out = memory;
    r_prepare_scene(job->scene, &choice->transport, job->seed, job->frame, &out->scene);
    out->choice = *choice;
    out->sources = *sources;
    out->roulette = (Real)job->knobs[NPH_LIGHT_KNOB_ROULETTE];
    out->scene.shadow_roulette = (Real)job->knobs[NPH_LIGHT_KNOB_CONNECT_ROULETTE];
}

/* Arrays of a batch in the order in which they lie; called once to measure and once to place. */
static size_t place(NphLightBatch *batch, char *memory) {
    size_t at = (sizeof(NphLightBatch) + 63) / 64 * 64;
    const size_t photons = NPH_LIGHT_BLOCK, flights = NPH_LIGHT_ROOM, waiting = NPH_LIGHT_SPLITS + 1;
#define PLACE(target, count)                                            \
    do {                                                                \
        if (memory) (target) = (void *)(memory + at);                   \
        at += ((size_t)(count) * sizeof *(target) + 63) / 64 * 64;      \
    } while (0)
    PLACE(batch->begin, 6 * photons);
    PLACE(batch->power, 3 * photons);
    PLACE(batch->unit, photons);
    PLACE(batch->source, photons);
    PLACE(batch->hero, photons);
    PLACE(batch->wait, R_WAIT_REALS * waiting);
    PLACE(batch->wait_at, R_WAIT_INTS * waiting);
    PLACE(batch->flight, flights);
    PLACE(batch->ray, 6 * flights);
    PLACE(batch->weight, 3 * flights);
    PLACE(batch->share, 3 * flights);
    PLACE(batch->distance, flights);
    PLACE(batch->touch, R_TOUCH_REALS * flights);
    PLACE(batch->left, 3 * flights);
    PLACE(batch->flight_hero, flights);
    PLACE(batch->order, flights);
    PLACE(batch->medium, flights);
    PLACE(batch->surface, flights);
    PLACE(batch->splat, flights);
    PLACE(batch->at, 2 * flights);
    PLACE(batch->add, 3 * flights);
    PLACE(batch->from, 3 * flights);
    PLACE(batch->splat_order, flights);
#undef PLACE
    return at;
}

size_t NPH_KERNEL(nph_light_batch_bytes)(void) {
    NphLightBatch measure;
    return place(&measure, NULL);
}

void NPH_KERNEL(nph_light_layout)(void *memory, const void *scene, NphLightBatch **out) {
    NphLightBatch *batch = memory;
    memset(batch, 0, sizeof *batch);
    batch->light = scene;
    place(batch, memory);
    *out = batch;
}

/* A block of the sample's photons; none has set out. */
void NPH_KERNEL(nph_light_begin)(NphLightBatch *batch, int64_t sample, int64_t block) {
    int64_t first = block * NPH_LIGHT_BLOCK, rest = batch->light->choice.photons - first;
    batch->sample = (uint32_t)sample;
    batch->first = (uint32_t)first;
    batch->photons = rest < NPH_LIGHT_BLOCK ? (int)(rest > 0 ? rest : 0) : NPH_LIGHT_BLOCK;
    batch->place[0] = batch->place[1] = 0;
    batch->waiting = batch->flights = batch->splats = 0;
}

int NPH_KERNEL(nph_light_unfinished)(const NphLightBatch *batch) {
    return batch->waiting > 0 || batch->place[0] < batch->photons;
}

int64_t NPH_KERNEL(nph_light_items)(const NphLightBatch *batch, NphLightStage stage) {
    return stage == NPH_LIGHT_CONNECT ? batch->flights : stage == NPH_LIGHT_SPLAT ? batch->splats : batch->photons;
}

NphTally *NPH_KERNEL(nph_light_tally)(NphLightBatch *batch) { return &batch->tally; }

NphStatus NPH_KERNEL(nph_light_extend)(NphLightBatch *batch, int buffer, int64_t items) {
    int splits = buffer == NPH_LIGHT_WAITING || buffer == NPH_LIGHT_WAITING_AT;
    int photons = buffer >= NPH_LIGHT_RAY && buffer <= NPH_LIGHT_HERO;
    int64_t room = splits ? NPH_LIGHT_SPLITS + 1 : photons ? NPH_LIGHT_BLOCK : NPH_LIGHT_FLIGHTS;
    if (items < 0 || items > room) return NPH_BAD_INPUT;
    if (buffer == NPH_LIGHT_WAITING) batch->waiting = (int)items;
    if (buffer == NPH_LIGHT_FLIGHT) batch->flights = (int)items;
    if (buffer == NPH_LIGHT_SPLATS) batch->splats = (int)items;
    return NPH_OK;
}

static NphView rows(NphType type, void *data, int64_t count, int64_t items, int64_t room) {
    return (NphView){type, 2, {count, items}, data, room};
}

static NphView row(NphType type, void *data, int64_t items) { return (NphView){type, 1, {items}, data, items}; }

static const NphType real = NPH_PRECISION == 32 ? NPH_F32 : NPH_F64;

static int view_photons(NphLightBatch *batch, int buffer, NphView *view) {
    enum { ROOM = NPH_LIGHT_BLOCK, WAITS = NPH_LIGHT_SPLITS + 1 };
    switch (buffer) {
    case NPH_LIGHT_RAY: *view = rows(real, batch->begin, 6, batch->photons, ROOM); return 1;
    case NPH_LIGHT_POWER: *view = rows(real, batch->power, 3, batch->photons, ROOM); return 1;
    case NPH_LIGHT_UNIT: *view = row(real, batch->unit, batch->photons); return 1;
    case NPH_LIGHT_SOURCE: *view = row(NPH_I32, batch->source, batch->photons); return 1;
    case NPH_LIGHT_HERO: *view = row(NPH_I32, batch->hero, batch->photons); return 1;
    case NPH_LIGHT_PLACE: *view = row(NPH_I64, batch->place, 2); return 1;
    case NPH_LIGHT_WAITING: *view = rows(real, batch->wait, R_WAIT_REALS, batch->waiting, WAITS); return 1;
    case NPH_LIGHT_WAITING_AT: *view = rows(NPH_I32, batch->wait_at, R_WAIT_INTS, batch->waiting, WAITS); return 1;
    default: return 0;
    }
}

static int view_flights(NphLightBatch *batch, int buffer, NphView *view) {
    enum { ROOM = NPH_LIGHT_ROOM };
    const RScene *scene = &batch->light->scene;
    int count = batch->flights, surfaces = scene->surfaces.count > 0, channels = scene->channels > 1;
    int connects = scene->sensor.kind != NPH_SENSOR_FLUX;
    switch (buffer) {
    case NPH_LIGHT_FLIGHT: *view = row(NPH_I64, batch->flight, count); return 1;
    case NPH_LIGHT_FLIGHT_RAY: *view = rows(real, batch->ray, 6, count, ROOM); return 1;
    case NPH_LIGHT_FLIGHT_WEIGHT: *view = rows(real, batch->weight, 3, count, ROOM); return 1;
    case NPH_LIGHT_FLIGHT_SHARE: *view = rows(real, batch->share, 3, count, ROOM); return channels;
    case NPH_LIGHT_FLIGHT_HERO: *view = row(NPH_I32, batch->flight_hero, count); return channels;
    case NPH_LIGHT_FLIGHT_ORDER: *view = row(NPH_I32, batch->order, count); return 1;
    case NPH_LIGHT_FLIGHT_DISTANCE: *view = row(real, batch->distance, count); return 1;
    case NPH_LIGHT_FLIGHT_MEDIUM: *view = row(NPH_I32, batch->medium, count); return 1;
    case NPH_LIGHT_FLIGHT_SURFACE: *view = row(NPH_I32, batch->surface, count); return surfaces;
    case NPH_LIGHT_FLIGHT_TOUCH: *view = rows(real, batch->touch, R_TOUCH_REALS, count, ROOM); return surfaces;
    case NPH_LIGHT_FLIGHT_LEFT: *view = rows(real, batch->left, 3, count, ROOM); return connects;
    default: return 0;
    }
}

/* 0 where the scene has none. */
int NPH_KERNEL(nph_light_view)(NphLightBatch *batch, int buffer, NphView *view) {
    enum { ROOM = NPH_LIGHT_ROOM };
    switch (buffer) {
    case NPH_LIGHT_SPLATS: *view = row(NPH_I64, batch->splat, batch->splats); return 1;
    case NPH_LIGHT_SPLAT_AT: *view = rows(NPH_F64, batch->at, 2, batch->splats, ROOM); return 1;
    case NPH_LIGHT_SPLAT_ADD: *view = rows(real, batch->add, 3, batch->splats, ROOM); return 1;
    case NPH_LIGHT_SPLAT_FROM: *view = rows(real, batch->from, 3, batch->splats, ROOM); return 1;
    case NPH_LIGHT_SPLAT_ORDER: *view = row(NPH_I32, batch->splat_order, batch->splats); return 1;
    default: return buffer < NPH_LIGHT_FLIGHT ? view_photons(batch, buffer, view) : view_flights(batch, buffer, view);
    }
}
