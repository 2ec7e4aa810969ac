/* SPDX-License-Identifier: Apache-2.0
 *
 * The memory of light tracing: the scene, and a worker's batch of photons, flights and splats (light_state.h); where its
 * buffers lie. */
#include <stddef.h>
#include <string.h>

#include "transport/prepare_lookup.h"
#include "truth/light/light_state.h"

size_t NPH_KERNEL(nph_light_scene_bytes)(void);
void NPH_KERNEL(nph_light_prepare)(const NphJob *job, const NphLightChoice *choice, const NphEmissionSources *sources,
                                   void *memory);
size_t NPH_KERNEL(nph_light_batch_bytes)(void);
void NPH_KERNEL(nph_light_layout)(void *memory, void *columns, const void *scene, NphLightBatch **batch);
size_t NPH_KERNEL(nph_light_column_bytes)(void);
void NPH_KERNEL(nph_light_start)(NphLightBatch *batch, NphLightPlacing placing);
void NPH_KERNEL(nph_light_take)(NphLightBatch *batch, const char *reads);
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
    const size_t photons = NPH_LIGHT_BLOCK;
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
    PLACE(batch->wait, NPH_LIGHT_SPLITS + 1);
    PLACE(batch->flight, NPH_LIGHT_FLIGHTS);
    PLACE(batch->splat, NPH_LIGHT_FLIGHTS);
#undef PLACE
    return at;
}

size_t NPH_KERNEL(nph_light_batch_bytes)(void) {
    NphLightBatch measure;
    return place(&measure, NULL);
}

void NPH_KERNEL(nph_light_layout)(void *memory, void *columns, const void *scene, NphLightBatch **out) {
    NphLightBatch *batch = memory;
    memset(batch, 0, sizeof *batch);
    batch->light = scene;
    batch->columns = columns;
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
    batch->waiting = batch->flights = batch->splats = batch->placing = 0;
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

/* Fields of the lists' items, as rows of buffers. */
typedef struct Column {
    int buffer, row, rows;
    NphType type;
    size_t offset;
} Column;

#define REAL_TYPE (NPH_PRECISION == 32 ? NPH_F32 : NPH_F64)
#define WAIT(row, rows, type, field, place) {place, row, rows, type, offsetof(RWaiting, field)}
#define FLIGHT(place, row, rows, type, field) {NPH_LIGHT_##place, row, rows, type, offsetof(RFlight, field)}
#define SPLAT(place, rows, type, field) {NPH_LIGHT_##place, 0, rows, type, offsetof(RSplat, field)}

static const Column columns[] = {
    WAIT(0, 3, REAL_TYPE, vertex.p, NPH_LIGHT_WAITING),
    WAIT(3, 3, REAL_TYPE, vertex.d, NPH_LIGHT_WAITING),
    WAIT(6, 3, REAL_TYPE, vertex.n, NPH_LIGHT_WAITING),
    WAIT(9, 3, REAL_TYPE, photon.weight, NPH_LIGHT_WAITING),
    WAIT(12, 3, REAL_TYPE, photon.share, NPH_LIGHT_WAITING),
    WAIT(0, 1, NPH_I32, where, NPH_LIGHT_WAITING_AT),
    WAIT(1, 1, NPH_I32, photon.hero, NPH_LIGHT_WAITING_AT),
    WAIT(2, 1, NPH_I32, photon.order, NPH_LIGHT_WAITING_AT),
    WAIT(3, 1, NPH_I32, copies, NPH_LIGHT_WAITING_AT),
    FLIGHT(FLIGHT, 0, 1, NPH_I64, name),
    FLIGHT(FLIGHT_RAY, 0, 3, REAL_TYPE, photon.p),
    FLIGHT(FLIGHT_RAY, 3, 3, REAL_TYPE, photon.d),
    FLIGHT(FLIGHT_WEIGHT, 0, 3, REAL_TYPE, photon.weight),
    FLIGHT(FLIGHT_SHARE, 0, 3, REAL_TYPE, photon.share),
    FLIGHT(FLIGHT_HERO, 0, 1, NPH_I32, photon.hero),
    FLIGHT(FLIGHT_ORDER, 0, 1, NPH_I32, photon.order),
    FLIGHT(FLIGHT_DISTANCE, 0, 1, REAL_TYPE, distance),
    FLIGHT(FLIGHT_MEDIUM, 0, 1, NPH_I32, medium),
    FLIGHT(FLIGHT_SURFACE, 0, 1, NPH_I32, surface),
    FLIGHT(FLIGHT_TOUCH, 0, 7, REAL_TYPE, touch),
    FLIGHT(FLIGHT_LEFT, 0, 3, REAL_TYPE, left),
    SPLAT(SPLATS, 1, NPH_I64, flight),
    SPLAT(SPLAT_AT, 2, NPH_F64, at),
    SPLAT(SPLAT_ADD, 3, REAL_TYPE, add),
    SPLAT(SPLAT_FROM, 3, REAL_TYPE, from),
    SPLAT(SPLAT_ORDER, 1, NPH_I32, order),
};
enum { COLUMNS = sizeof columns / sizeof *columns };

/* Rooms that rows of a buffer have, the items of its list, and where they lie. */
typedef struct List {
    int64_t room, count;
    char *items;
    size_t size;
} List;

static List list_of(const NphLightBatch *batch, int buffer) {
    if (buffer < NPH_LIGHT_FLIGHT) return (List){NPH_LIGHT_SPLITS + 1, batch->waiting, (char *)batch->wait, sizeof *batch->wait};
    if (buffer < NPH_LIGHT_SPLATS) return (List){NPH_LIGHT_FLIGHTS, batch->flights, (char *)batch->flight, sizeof *batch->flight};
    return (List){NPH_LIGHT_FLIGHTS, batch->splats, (char *)batch->splat, sizeof *batch->splat};
}

/* Where the columns of a buffer begin, and how many rows there are of them; the bytes of all where it has none. */
static size_t find_columns(int buffer, int64_t *rows, NphType *type) {
    NphLightBatch none = {.waiting = 0};
    size_t at = 0;
    *rows = 0;
    for (int c = 0; c < COLUMNS; c++) {
        if (columns[c].buffer == buffer) {
            *rows += columns[c].rows;
            *type = columns[c].type;
        } else if (*rows == 0) {
            at += (size_t)columns[c].rows * (size_t)list_of(&none, columns[c].buffer).room * nph_type_size(columns[c].type);
            at = (at + 63) / 64 * 64;
        }
    }
    return at;
}

size_t NPH_KERNEL(nph_light_column_bytes)(void) {
    int64_t rows;
    NphType type;
    return find_columns(-1, &rows, &type);
}

/* Copies the items' fields to a buffer's columns, or (back) from there. */
static void copy_columns(NphLightBatch *batch, int buffer, char *data, int back) {
    List list = list_of(batch, buffer);
    for (int c = 0; c < COLUMNS; c++) {
        const Column *column = &columns[c];
        size_t size = nph_type_size(column->type);
        if (column->buffer != buffer) continue;
        for (int64_t i = 0; i < list.count; i++)
            for (int r = 0; r < column->rows; r++) {
                char *field = list.items + (size_t)i * list.size + column->offset + (size_t)r * size;
                char *cell = data + ((size_t)(column->row + r) * (size_t)list.room + (size_t)i) * size;
                memcpy(back ? field : cell, back ? cell : field, size);
            }
    }
}

void NPH_KERNEL(nph_light_start)(NphLightBatch *batch, NphLightPlacing placing) { batch->placing = placing; }

/* What follows from the columns of what waits. */
static void complete_waiting(NphLightBatch *batch) {
    for (int i = 0; i < batch->waiting; i++) {
        RWaiting *waiting = &batch->wait[i];
        RVertex vertex = waiting->vertex;
        int photon = (int)batch->place[0] - 1;
        r_vertex_of(&batch->light->scene, waiting->where, vertex.p, vertex.n, vertex.d, &waiting->vertex);
        for (int a = 0; a < 3; a++) {
            waiting->photon.p[a] = vertex.p[a];
            waiting->photon.d[a] = vertex.d[a];
        }
        waiting->photon.unit = batch->unit[photon];
        waiting->photon.source = batch->source[photon];
    }
}

/* reads: buffers of the stage, whose values have been checked. */
void NPH_KERNEL(nph_light_take)(NphLightBatch *batch, const char *reads) {
    NphView view;
    int all = batch->placing == NPH_LIGHT_HELD;
    for (int b = NPH_LIGHT_WAITING; b <= NPH_LIGHT_SPLAT_ORDER; b++)
        if ((all || nph_stage_lists(reads, nph_light_buffers[b].name)) && NPH_KERNEL(nph_light_view)(batch, b, &view))
            copy_columns(batch, b, view.data, 1);
    if (all || nph_stage_lists(reads, nph_light_buffers[NPH_LIGHT_WAITING].name)) complete_waiting(batch);
    for (int i = 0; i < batch->flights; i++) {
        RFlight *flight = &batch->flight[i];
        flight->photon.source = batch->source[flight->name >> 32];
        if (batch->light->scene.surfaces.count == 0) flight->surface = -1;
    }
    batch->placing = NPH_LIGHT_NONE;
}

static NphView row(NphType type, void *data, int64_t items) { return (NphView){type, 1, {items}, data, items}; }

static int view_photons(NphLightBatch *batch, int buffer, NphView *view) {
    enum { ROOM = NPH_LIGHT_BLOCK };
    int64_t count = batch->photons;
    switch (buffer) {
    case NPH_LIGHT_RAY: *view = (NphView){REAL_TYPE, 2, {6, count}, batch->begin, ROOM}; return 1;
    case NPH_LIGHT_POWER: *view = (NphView){REAL_TYPE, 2, {3, count}, batch->power, ROOM}; return 1;
    case NPH_LIGHT_UNIT: *view = row(REAL_TYPE, batch->unit, count); return 1;
    case NPH_LIGHT_SOURCE: *view = row(NPH_I32, batch->source, count); return 1;
    case NPH_LIGHT_HERO: *view = row(NPH_I32, batch->hero, count); return 1;
    default: *view = row(NPH_I64, batch->place, 2); return 1;
    }
}

static int is_there(const NphLightBatch *batch, int buffer) {
    const RScene *scene = &batch->light->scene;
    switch (buffer) {
    case NPH_LIGHT_FLIGHT_SHARE:
    case NPH_LIGHT_FLIGHT_HERO: return scene->channels > 1;
    case NPH_LIGHT_FLIGHT_SURFACE:
    case NPH_LIGHT_FLIGHT_TOUCH: return scene->surfaces.count > 0;
    default: return 1;
    }
}

/* 0 where the scene has none. */
int NPH_KERNEL(nph_light_view)(NphLightBatch *batch, int buffer, NphView *view) {
    NphType type = REAL_TYPE;
    int64_t rows;
    if (buffer <= NPH_LIGHT_PLACE) return view_photons(batch, buffer, view);
    List list = list_of(batch, buffer);
    char *data = (char *)batch->columns + find_columns(buffer, &rows, &type);
    if (!is_there(batch, buffer)) return 0;
    if (!batch->placing) copy_columns(batch, buffer, data, 0);
    *view = rows > 1 ? (NphView){type, 2, {rows, list.count}, data, list.room} : row(type, data, list.count);
    return 1;
}
