/* SPDX-License-Identifier: Apache-2.0
 *
 * The buffers of photon mapping, and its stages alone. Photons and nodes lie in memory one after the other, as searches want them;
 * others see a row for each of their numbers, copied as it is looked at, and back before it is used. */
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "truth/photonmap/photonmap.h"

#define R NPH_TYPE_REAL
#define ID "photonmap.id"

const NphBuffer nph_photonmap_buffers[NPH_PHOTONMAP_BUFFERS] = {
    [NPH_PHOTONMAP_EMITTED] = {"photonmap.emitted", NPH_I64, "[1]", "1", "photons that are sent out for a map", NPH_EXACT, NULL, NULL, 0},
    [NPH_PHOTONMAP_COUNTS] = {"photonmap.count", NPH_I64, "[block]", "1",
                              "how often the photons of a block scatter where it could be stored; the last block may be short", NPH_EXACT,
                              NULL, NULL, 0},
    [NPH_PHOTONMAP_FIRST] = {"photonmap.first", NPH_I64, "[block + 1]", "1", "how often those of earlier blocks do", NPH_EXACT, NULL, NULL,
                             0},
    [NPH_PHOTONMAP_ID] = {ID, NPH_I64, "[photon]", "1", "number of the photon times 2^20, and number of its collision from 1 on; -1: none",
                          NPH_EXACT, NULL, ID, 0},
    [NPH_PHOTONMAP_PLACE] = {"photonmap.place", R, "[3][photon]", "m", "where it was scattered, scene-local", NPH_NEAR, NULL, ID, 0},
    [NPH_PHOTONMAP_DIRECTION] = {"photonmap.direction", R, "[3][photon]", "1", "along which it came", NPH_NEAR, NULL, ID, 0},
    [NPH_PHOTONMAP_POWER] = {"photonmap.power", R, "[3][photon]", "W", "that was scattered there", NPH_NEAR, NULL, ID, 0},
    [NPH_PHOTONMAP_EXTINCTION] = {"photonmap.extinction", R, "[photon]", "1/m", "of the densest channels of all media there", NPH_NEAR, NULL,
                                  ID, 0},
    [NPH_PHOTONMAP_MEDIUM] = {"photonmap.medium", NPH_I32, "[photon]", "1", "position of the medium that scattered it", NPH_EXACT, NULL, ID,
                              0},
    [NPH_PHOTONMAP_ORDER] = {"photonmap.order", NPH_I32, "[photon]", "1", "number of its collisions, this one included", NPH_EXACT, NULL, ID,
                             0},
    [NPH_PHOTONMAP_NODE] = {"photonmap.node", R, "[3][node]", "m", "place of the tree's nodes; below i are 2 i + 1 and 2 i + 2", NPH_NEAR,
                            NULL, NULL, 0},
    [NPH_PHOTONMAP_NODE_PHOTON] = {"photonmap.node_photon", NPH_I32, "[node]", "1", "position of the node's photon", NPH_EXACT, NULL, ID,
                                   NPH_QUEUE_IN_ORDER},
    [NPH_PHOTONMAP_NODE_AXIS] = {"photonmap.node_axis", NPH_I32, "[node]", "1", "axis along which those below are split", NPH_EXACT, NULL,
                                 NULL, 0},
    [NPH_PHOTONMAP_IMAGE] = {"photonmap.image", R, "[field][pixel]", "W/m2/sr, 1, m",
                             "of a sample, pixels of the crop row by row: radiance, transmittance (3 channels each), order, distance and "
                             "weight of the first vertex", NPH_NEAR, NULL, NULL, 0},
    [NPH_PHOTONMAP_SAMPLE] = {"photonmap.sample", R, "[field][pixel][16]", "W/m2/sr, 1, m", "photonmap.image of a chunk's samples, in a tile",
                              NPH_NEAR, NULL, NULL, 0},
    [NPH_PHOTONMAP_FILM_NODE] = {"film.node", NPH_F64, "[moment][pixel]", "powers of W/m2/sr",
                                 "of 16 samples: mean, M2, M3, M4 per channel, then means", NPH_NEAR, NULL, NULL, 0},
};

#undef R

/* Rows of photons and nodes: those of reals, then those of integers; `room` elements each. */
enum { REAL_ROWS = 13, INTEGER_ROWS = 4 };

typedef struct Column {
    int rows, row;
    NphType type;
} Column;

/* rows 0: the buffer has none. */
static Column column_of(const NphPhotonmapState *state, int buffer) {
    NphType real = state->job.precision == 32 ? NPH_F32 : NPH_F64;
    switch (buffer) {
    case NPH_PHOTONMAP_PLACE: return (Column){3, 0, real};
    case NPH_PHOTONMAP_DIRECTION: return (Column){3, 3, real};
    case NPH_PHOTONMAP_POWER: return (Column){3, 6, real};
    case NPH_PHOTONMAP_EXTINCTION: return (Column){1, 9, real};
    case NPH_PHOTONMAP_NODE: return (Column){3, 10, real};
    case NPH_PHOTONMAP_MEDIUM: return (Column){1, 0, NPH_I32};
    case NPH_PHOTONMAP_ORDER: return (Column){1, 1, NPH_I32};
    case NPH_PHOTONMAP_NODE_PHOTON: return (Column){1, 2, NPH_I32};
    case NPH_PHOTONMAP_NODE_AXIS: return (Column){1, 3, NPH_I32};
    default: return (Column){0, 0, real};
    }
}

static void *place_of(const NphPhotonmapState *state, const Column *column) {
    size_t room = (size_t)state->choice.room, reals = column->type == NPH_I32 ? REAL_ROWS : 0, real = (size_t)state->job.precision / 8;
    return (char *)state->columns + room * (reals * real + (size_t)column->row * nph_type_size(column->type));
}

static size_t columns_bytes(int precision, size_t room) {
    return room * ((size_t)REAL_ROWS * (size_t)precision / 8 + INTEGER_ROWS * sizeof(int32_t));
}

uint64_t nph_photonmap_column_bytes(int precision, int64_t room) {
    return columns_bytes(precision, (size_t)room) + (uint64_t)room * sizeof(int64_t);
}

NphStatus nph_photonmap_open_columns(NphPhotonmapState *state) {
    NphContext *context = state->job.context;
    int64_t room = state->choice.room;
    NPH_TRY(NPH_NEW(context, room, "names of photons", &state->maker.map.names));
    return nph_alloc(context, 1, columns_bytes(state->job.precision, (size_t)room), "photons as others see them", &state->columns);
}

NphStatus nph_photonmap_begin_launch(void *opaque, int index, NphFilm *film, const NphLaunch *launch) {
    NphPhotonmapState *state = opaque;
    NphPhotonmapMaker *maker = &state->maker;
    int64_t sample = launch->arguments[NPH_PHOTONMAP_ARG_SAMPLE], tile = launch->arguments[NPH_PHOTONMAP_ARG_TILE];
    (void)index;
    if (sample < 0 || sample > NPH_MAX_SAMPLES - NPH_CHUNK || tile < 0 || tile >= nph_film_tile_count(film))
        return nph_error(state->job.context, NPH_BAD_INPUT, "sample %lld, tile %lld: the picture has %lld tiles", (long long)sample,
                         (long long)tile, (long long)nph_film_tile_count(film));
    if (launch->stage <= NPH_PHOTONMAP_FILL && nph_photonmap_pilot_photons(&state->choice) == 0)
        return nph_error(state->job.context, NPH_BAD_INPUT, "%s: there is no pilot: %s", nph_photonmap_stages[launch->stage].name,
                         state->choice.traced ? "photonmap.emitted says how many photons are sent out" : "no photons are traced");
    if (!state->columns) NPH_TRY(nph_photonmap_open_columns(state));
    state->film = film;
    state->slot = 0;
    state->placing = NPH_PHOTONMAP_ALONE;
    maker->map.sample = (uint32_t)sample;
    maker->map.emitted = maker->blocks = 0;
    maker->map.tree.count = 0;
    return NPH_OK;
}

NphStatus nph_photonmap_extend(void *opaque, int index, int buffer, const int64_t *shape) {
    NphPhotonmapState *state = opaque;
    NphPhotonmapMaker *maker = &state->maker;
    int photons = buffer == NPH_PHOTONMAP_ID, numbers = buffer == NPH_PHOTONMAP_FIRST;
    int64_t items = shape[0] - numbers, room = photons ? maker->map.room : nph_photonmap_blocks(nph_photonmap_most(&state->choice));
    (void)index;
    if (!photons && !numbers && buffer != NPH_PHOTONMAP_COUNTS) return NPH_OK; /* as long as these are */
    if (items < 0 || items > room)
        return nph_error(state->job.context, NPH_BAD_INPUT, "%s: there is no room for %lld items", nph_photonmap_buffers[buffer].name,
                         (long long)shape[0]);
    if (photons)
        maker->map.tree.count = (int32_t)items;
    else
        maker->blocks = items;
    return NPH_OK;
}

static NphView row(NphType type, void *data, int64_t items) { return (NphView){type, 1, {items}, data, items}; }

int nph_photonmap_view(void *opaque, int index, int buffer, NphView *out) {
    NphPhotonmapState *state = opaque;
    NphPhotonmapMaker *maker = &state->maker;
    NphPhotonMap *map = &maker->map;
    const int *crop = state->job.crop;
    const int64_t pixels = (int64_t)(crop[2] - crop[0]) * (crop[3] - crop[1]);
    NphType real = state->job.precision == 32 ? NPH_F32 : NPH_F64;
    enum { PLANE = NPH_TILE_PIXELS * NPH_CHUNK };
    (void)index;
    switch (buffer) {
    case NPH_PHOTONMAP_EMITTED: *out = row(NPH_I64, &map->emitted, 1); return 1;
    case NPH_PHOTONMAP_COUNTS: *out = row(NPH_I64, maker->counts, maker->blocks); return 1;
    case NPH_PHOTONMAP_FIRST: *out = row(NPH_I64, maker->first, maker->blocks + 1); return 1;
    case NPH_PHOTONMAP_ID: *out = row(NPH_I64, map->names, map->tree.count); return 1;
    case NPH_PHOTONMAP_IMAGE:
        *out = (NphView){real, 2, {NPH_SAMPLE_FIELDS, pixels}, (char *)state->images + state->image_bytes * (size_t)state->slot, pixels};
        return 1;
    case NPH_PHOTONMAP_SAMPLE: *out = (NphView){real, 3, {NPH_SAMPLE_FIELDS, NPH_TILE_PIXELS, NPH_CHUNK}, state->samples, PLANE}; return 1;
    case NPH_PHOTONMAP_FILM_NODE:
        *out = (NphView){NPH_F64, 2, {nph_film_planes(state->film), NPH_TILE_PIXELS}, state->film_scratch, NPH_TILE_PIXELS};
        return 1;
    default: break;
    }
    Column column = column_of(state, buffer);
    void *data = place_of(state, &column);
    if (state->placing == NPH_PHOTONMAP_NONE) maker->kernels.show(map, buffer, data);
    *out = column.rows > 1 ? (NphView){column.type, 2, {column.rows, map->tree.count}, data, map->room}
                           : row(column.type, data, map->tree.count);
    return 1;
}

/* Photons that are written beyond those there are have names and values of nothing until these are written too. */
void nph_photonmap_hold(void *opaque, int index) {
    NphPhotonmapState *state = opaque;
    NphPhotonMap *map = &state->maker.map;
    NphView view;
    memset(state->columns, 0, columns_bytes(state->job.precision, (size_t)map->room));
    for (int64_t i = map->tree.count; i < map->room; i++) map->names[i] = -1;
    for (int b = NPH_PHOTONMAP_PLACE; b <= NPH_PHOTONMAP_NODE_AXIS; b++) (void)nph_photonmap_view(state, index, b, &view);
    state->placing = NPH_PHOTONMAP_HELD;
}

/* What integers may be. */
static int64_t most_of(const NphPhotonmapState *state, int buffer) {
    int64_t media = 0;
    for (int m = 0; m < state->job.scene->medium_count; m++) media += state->choice.transport.used[m];
    switch (buffer) {
    case NPH_PHOTONMAP_EMITTED: return nph_photonmap_most(&state->choice);
    case NPH_PHOTONMAP_COUNTS:
    case NPH_PHOTONMAP_FIRST: return (int64_t)1 << 36; /* times the largest room below 2^63 */
    case NPH_PHOTONMAP_ID: return ((int64_t)1 << 53) - 1;
    case NPH_PHOTONMAP_MEDIUM: return media - 1;
    case NPH_PHOTONMAP_NODE_PHOTON: return state->maker.map.tree.count - 1;
    case NPH_PHOTONMAP_NODE_AXIS: return 2;
    default: return INT32_MAX;
    }
}

static NphStatus check_input(NphPhotonmapState *state, int index, int buffer) {
    NphView seen;
    nph_photonmap_view(state, index, buffer, &seen);
    int64_t wrong = nph_view_wrong(&seen, buffer == NPH_PHOTONMAP_ID ? -1 : 0, most_of(state, buffer));
    if (wrong < 0) return NPH_OK;
    return nph_error(state->job.context, NPH_BAD_INPUT, "input %s: value %lld is not %s", nph_photonmap_buffers[buffer].name,
                     (long long)wrong, seen.type == NPH_I32 || seen.type == NPH_I64 ? "one of this scene and its photons" : "finite");
}

/* Blocks of the photons that are sent out, numbered one after the other. */
static NphStatus check_blocks(const NphPhotonmapState *state, const NphLaunch *launch) {
    const NphPhotonmapMaker *maker = &state->maker;
    int pilot = launch->stage == NPH_PHOTONMAP_FILL;
    int64_t photons = pilot ? nph_photonmap_pilot_photons(&state->choice) : maker->map.emitted;
    if (maker->blocks != nph_photonmap_blocks(photons))
        return nph_error(state->job.context, NPH_BAD_INPUT, "input %s: it has %lld blocks, %lld photons have %lld",
                         pilot ? "photonmap.count" : "photonmap.first", (long long)maker->blocks, (long long)photons,
                         (long long)nph_photonmap_blocks(photons));
    for (int64_t b = 0; b <= maker->blocks && !pilot; b++)
        if (b == 0 ? maker->first[0] != 0 : maker->first[b] < maker->first[b - 1])
            return nph_error(state->job.context, NPH_BAD_INPUT, "input photonmap.first: value %lld is below the one before it, or not 0 "
                             "at first", (long long)b);
    return NPH_OK;
}

NphStatus nph_photonmap_check(void *opaque, int index, const NphLaunch *launch) {
    NphPhotonmapState *state = opaque;
    NphPhotonmapMaker *maker = &state->maker;
    const char *reads = nph_photonmap_stages[launch->stage].reads;
    for (int b = 0; b < NPH_PHOTONMAP_IMAGE; b++)
        if (nph_stage_lists(reads, nph_photonmap_buffers[b].name)) NPH_TRY(check_input(state, index, b));
    if (launch->stage == NPH_PHOTONMAP_FILL || launch->stage == NPH_PHOTONMAP_TRACE) NPH_TRY(check_blocks(state, launch));
    for (int b = NPH_PHOTONMAP_PLACE; b <= NPH_PHOTONMAP_NODE_AXIS && state->placing != NPH_PHOTONMAP_NONE; b++) {
        Column column = column_of(state, b);
        if (state->placing == NPH_PHOTONMAP_HELD || nph_stage_lists(reads, nph_photonmap_buffers[b].name))
            maker->kernels.take(&maker->map, b, place_of(state, &column));
    }
    state->placing = NPH_PHOTONMAP_NONE;
    return NPH_OK;
}

NphStatus nph_photonmap_launch_alone(void *opaque, int index, const NphLaunch *launch) {
    (void)index;
    return nph_photonmap_launch(opaque, launch);
}
