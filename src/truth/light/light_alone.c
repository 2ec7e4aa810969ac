/* SPDX-License-Identifier: Apache-2.0
 *
 * The buffers of light tracing, and its stages alone, in the memory of a worker. */
#include <string.h>

#include "core/message.h"
#include "truth/light/light_tracing.h"

#define R NPH_TYPE_REAL
#define F "light.flight"
#define S "light.splat"

const NphBuffer nph_light_buffers[NPH_LIGHT_BUFFERS] = {
    [NPH_LIGHT_RAY] = {"light.ray", R, "[6][photon]", "m, 1", "where a photon sets out, and along which direction; scene-local", NPH_NEAR,
                       NULL, NULL, 0},
    [NPH_LIGHT_POWER] = {"light.power", R, "[3][photon]", "W", "that it stands for", NPH_NEAR, NULL, NULL, 0},
    [NPH_LIGHT_UNIT] = {"light.unit", R, "[photon]", "W", "what roulette measures weights by; 0: the photon carries nothing", NPH_NEAR,
                        NULL, NULL, 0},
    [NPH_LIGHT_SOURCE] = {"light.source", NPH_I32, "[photon]", "1", "light that it comes from; their number: light of a medium",
                          NPH_EXACT, NULL, NULL, 0},
    [NPH_LIGHT_HERO] = {"light.hero", NPH_I32, "[photon]", "1", "channel that decides collisions", NPH_EXACT, NULL, NULL, 0},
    [NPH_LIGHT_PLACE] = {"light.place", NPH_I64, "[2]", "1", "photons that have set out; flights of the last of them, less one", NPH_EXACT,
                         NULL, NULL, 0},
    [NPH_LIGHT_WAITING] = {"light.waiting", R, "[15][waiting]", "m, 1, W",
                           "of that photon's copies that still fly, the next one last: position, direction of arrival, normal, "
                           "weight, share", NPH_NEAR, NULL, NULL, 0},
    [NPH_LIGHT_WAITING_AT] = {"light.waiting_at", NPH_I32, "[4][waiting]", "1",
                              "medium of the vertex, or -1 - surface; hero; order; how many copies", NPH_EXACT, NULL, NULL, 0},
    [NPH_LIGHT_FLIGHT] = {F, NPH_I64, "[flight]", "1", "photon of the block times 2^32, and number of its flight from 1 on; 0: where it "
                          "begins", NPH_EXACT, NULL, F, 0},
    [NPH_LIGHT_FLIGHT_RAY] = {"light.flight_ray", R, "[6][flight]", "m, 1", "position and direction", NPH_NEAR, NULL, F, 0},
    [NPH_LIGHT_FLIGHT_WEIGHT] = {"light.flight_weight", R, "[3][flight]", "W", "power that sets out", NPH_NEAR, NULL, F, 0},
    [NPH_LIGHT_FLIGHT_SHARE] = {"light.flight_share", R, "[3][flight]", "1",
                                "probability of the way so far had the channel been the hero, over the channels' mean", NPH_NEAR,
                                "channels differ", F, 0},
    [NPH_LIGHT_FLIGHT_HERO] = {"light.flight_hero", NPH_I32, "[flight]", "1", "the photon's", NPH_EXACT, "channels differ", F, 0},
    [NPH_LIGHT_FLIGHT_ORDER] = {"light.flight_order", NPH_I32, "[flight]", "1", "scatterings and reflections so far", NPH_EXACT, NULL, F, 0},
    [NPH_LIGHT_FLIGHT_DISTANCE] = {"light.flight_distance", R, "[flight]", "m", "to the collision; without one how far was looked",
                                   NPH_NEAR, NULL, F, 0},
    [NPH_LIGHT_FLIGHT_MEDIUM] = {"light.flight_medium", NPH_I32, "[flight]", "1", "position of the medium it happens in; -1: none",
                                 NPH_EXACT, NULL, F, 0},
    [NPH_LIGHT_FLIGHT_SURFACE] = {"light.flight_surface", NPH_I32, "[flight]", "1",
                                  "surface that the flight ends at if nothing collides; -1: none", NPH_EXACT, "there are surfaces", F, 0},
    [NPH_LIGHT_FLIGHT_TOUCH] = {"light.flight_touch", R, "[7][flight]", "m, 1", "where light leaves that surface, its normal, how far it is",
                                NPH_NEAR, "there are surfaces", F, 0},
    [NPH_LIGHT_FLIGHT_LEFT] = {"light.flight_left", R, "[3][flight]", "W", "power behind the vertex at its end", NPH_NEAR, NULL, F, 0},
    [NPH_LIGHT_SPLATS] = {S, NPH_I64, "[splat]", "1", "flight that brings it", NPH_EXACT, NULL, S, 0},
    [NPH_LIGHT_SPLAT_AT] = {"light.splat_at", NPH_F64, "[2][splat]", "1", "where on the sensor, -1 to 1: right, up", NPH_NEAR, NULL, S, 0},
    [NPH_LIGHT_SPLAT_ADD] = {"light.splat_add", R, "[3][splat]", "W/m2/sr", "what a pixel there gains", NPH_NEAR, NULL, S, 0},
    [NPH_LIGHT_SPLAT_FROM] = {"light.splat_from", R, "[3][splat]", "m", "where it comes from", NPH_NEAR, NULL, S, 0},
    [NPH_LIGHT_SPLAT_ORDER] = {"light.splat_order", NPH_I32, "[splat]", "1", "scatterings and reflections of it", NPH_EXACT, NULL, S, 0},
    [NPH_LIGHT_IMAGE] = {"light.image", NPH_F64, "[channel, order][pixel]", "W/m2/sr", "what the photons of a sample bring; then times "
                         "order, of the luminance", NPH_NEAR, NULL, NULL, 0},
    [NPH_LIGHT_TRACED] = {"light.traced", NPH_F64, "[channel, order][pixel][16]", "W/m2/sr", "light.image of a chunk's samples, in a tile",
                          NPH_NEAR, NULL, NULL, 0},
    [NPH_LIGHT_SAMPLE] = {"light.sample", R, "[field][pixel][16]", "W/m2/sr, 1", "what each sample carries", NPH_NEAR, NULL, NULL, 0},
    [NPH_LIGHT_NODE] = {"film.node", NPH_F64, "[moment][pixel]", "powers of W/m2/sr",
                        "of 16 samples: mean, M2, M3, M4 per channel, then means", NPH_NEAR, NULL, NULL, 0},
};

#undef R

NphStatus nph_light_begin_launch(void *opaque, int index, NphFilm *film, const NphLaunch *launch) {
    NphLightState *state = opaque;
    int64_t sample = launch->arguments[NPH_LIGHT_ARG_SAMPLE], block = launch->arguments[NPH_LIGHT_ARG_BLOCK];
    int64_t tile = launch->arguments[NPH_LIGHT_ARG_TILE], blocks = nph_light_blocks(state);
    if (sample < 0 || sample > NPH_MAX_SAMPLES - NPH_CHUNK || block < 0 || block >= (blocks > 0 ? blocks : 1) || tile < 0 ||
        tile >= nph_film_tile_count(film))
        return nph_error(state->job.context, NPH_BAD_INPUT, "sample %lld, block %lld, tile %lld: a sample has %lld blocks of photons, "
                         "the picture %lld tiles", (long long)sample, (long long)block, (long long)tile, (long long)blocks,
                         (long long)nph_film_tile_count(film));
    if (!state->workers[index].columns) NPH_TRY(nph_light_open_columns(state, index));
    state->film = film;
    state->kernels.begin(state->workers[index].batch, sample, block);
    state->kernels.start(state->workers[index].batch, NPH_LIGHT_ALONE);
    state->workers[index].image = &state->images[0];
    return NPH_OK;
}

NphStatus nph_light_extend(void *opaque, int index, int buffer, const int64_t *shape) {
    NphLightState *state = opaque;
    const NphBuffer *what = &nph_light_buffers[buffer];
    int64_t items = what->shape[strcspn(what->shape, "]") + 1] ? shape[1] : shape[0];
    if (buffer >= NPH_LIGHT_IMAGE || buffer == NPH_LIGHT_PLACE) return NPH_OK; /* of one size */
    NphStatus status = state->kernels.extend(state->workers[index].batch, buffer, items);
    return status == NPH_OK ? status
                            : nph_error(state->job.context, status, "%s: there is no room for %lld items", what->name, (long long)items);
}

int nph_light_view(void *opaque, int index, int buffer, NphView *out) {
    NphLightState *state = opaque;
    NphLightWorker *worker = &state->workers[index];
    const int *crop = state->job.crop;
    int64_t values = state->choice.transport.film_channels + 1, pixels = (int64_t)(crop[2] - crop[0]) * (crop[3] - crop[1]);
    NphType real = state->job.precision == 32 ? NPH_F32 : NPH_F64;
    enum { PLANE = NPH_TILE_PIXELS * NPH_CHUNK };
    switch (buffer) {
    case NPH_LIGHT_IMAGE: *out = (NphView){NPH_F64, 2, {values, pixels}, worker->image->planes, pixels}; return 1;
    case NPH_LIGHT_TRACED: *out = (NphView){NPH_F64, 3, {values, NPH_TILE_PIXELS, NPH_CHUNK}, worker->traced, PLANE}; return 1;
    case NPH_LIGHT_SAMPLE:
        *out = (NphView){real, 3, {NPH_SAMPLE_FIELDS, NPH_TILE_PIXELS, NPH_CHUNK}, worker->samples, PLANE};
        return 1;
    case NPH_LIGHT_NODE:
        *out = (NphView){NPH_F64, 2, {nph_film_planes(state->film), NPH_TILE_PIXELS}, worker->film_scratch, NPH_TILE_PIXELS};
        return 1;
    default: return state->kernels.view(worker->batch, buffer, out);
    }
}

typedef struct Range {
    int64_t least, most;
} Range;

/* What values of a buffer of integers may be; of what waits by row. */
static Range range_of(const NphLightState *state, int photons, int buffer, int row) {
    const NphScene *scene = state->job.scene;
    const int64_t last = (int64_t)photons * 4294967296 - 1, most = INT32_MAX;
    int64_t media = 0;
    for (int m = 0; m < scene->medium_count; m++) media += state->choice.transport.used[m];
    const Range waits[] = {{-scene->surface_count, media - 1}, {0, 2}, {0, most}, {1, NPH_LIGHT_COPIES}};
    switch (buffer) {
    case NPH_LIGHT_SOURCE: return (Range){0, scene->light_count};
    case NPH_LIGHT_HERO:
    case NPH_LIGHT_FLIGHT_HERO: return (Range){0, 2};
    case NPH_LIGHT_WAITING_AT: return waits[row];
    case NPH_LIGHT_PLACE: return (Range){0, UINT32_MAX - 1};
    case NPH_LIGHT_FLIGHT:
    case NPH_LIGHT_SPLATS: return (Range){0, last};
    case NPH_LIGHT_FLIGHT_MEDIUM: return (Range){-1, media - 1};
    case NPH_LIGHT_FLIGHT_SURFACE: return (Range){-1, scene->surface_count - 1};
    default: return (Range){0, most};
    }
}

static NphStatus check_input(NphLightState *state, int index, int buffer) {
    NphView seen, row;
    NphView photons;
    if (!nph_light_view(state, index, buffer, &seen)) return NPH_OK;
    nph_light_view(state, index, NPH_LIGHT_UNIT, &photons);
    row = seen;
    int rows = buffer == NPH_LIGHT_WAITING_AT ? (int)seen.shape[0] : 1;
    for (int r = 0; r < rows; r++) {
        if (rows > 1) row = (NphView){seen.type, 1, {seen.shape[1]}, (int32_t *)seen.data + r * seen.stride, seen.stride};
        Range range = range_of(state, (int)photons.shape[0], buffer, r);
        int64_t wrong = nph_view_wrong(&row, range.least, range.most);
        if (wrong >= 0)
            return nph_error(state->job.context, NPH_BAD_INPUT, "input %s: value %lld is not %s", nph_light_buffers[buffer].name,
                             (long long)(wrong + r * seen.shape[1]),
                             seen.type == NPH_I32 || seen.type == NPH_I64 ? "one of this scene and these photons" : "finite");
    }
    return NPH_OK;
}

/* Copies wait of a photon that has set out. */
static NphStatus check_place(NphLightState *state, int index) {
    NphView place, waiting, photons;
    nph_light_view(state, index, NPH_LIGHT_PLACE, &place);
    nph_light_view(state, index, NPH_LIGHT_WAITING, &waiting);
    nph_light_view(state, index, NPH_LIGHT_UNIT, &photons);
    int64_t out = ((const int64_t *)place.data)[0];
    if (out <= photons.shape[0] && (out > 0 || waiting.shape[1] == 0)) return NPH_OK;
    return nph_error(state->job.context, NPH_BAD_INPUT, "input light.place: %lld photons have set out, of %lld, and %lld copies of the last "
                     "of them wait", (long long)out, (long long)photons.shape[0], (long long)waiting.shape[1]);
}

void nph_light_hold(void *opaque, int index) {
    NphLightState *state = opaque;
    NphView view;
    for (int b = 0; b < NPH_LIGHT_BUFFERS; b++) (void)nph_light_view(state, index, b, &view); /* fills its columns */
    state->kernels.start(state->workers[index].batch, NPH_LIGHT_HELD);
}

NphStatus nph_light_check(void *opaque, int index, const NphLaunch *launch) {
    NphLightState *state = opaque;
    const char *reads = nph_light.stages[launch->stage].reads;
    for (int b = 0; b < NPH_LIGHT_BUFFERS; b++)
        if (nph_stage_lists(reads, nph_light_buffers[b].name)) NPH_TRY(check_input(state, index, b));
    if (launch->stage == NPH_LIGHT_TRACE) NPH_TRY(check_place(state, index));
    state->kernels.take(state->workers[index].batch, reads);
    return NPH_OK;
}

NphStatus nph_light_launch_alone(void *opaque, int index, const NphLaunch *launch) {
    nph_light_launch(opaque, index, launch);
    return NPH_OK;
}
