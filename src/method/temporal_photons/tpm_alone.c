/* SPDX-License-Identifier: Apache-2.0
 *
 * The buffers of temporal photons, and its stages alone. */
#include "core/memory.h"
#include "core/message.h"
#include "method/temporal_photons/tpm_cache.h"

#define R NPH_TYPE_REAL
#define CELL "sun: fluence of three channels, mean cosine; sky: the same; mean orders of both"
#define PIXEL "radiance, transmittance (3 channels each), order, distance and weight of the first vertex"

const NphBuffer nph_tpm_buffers[NPH_TPM_BUFFERS] = {
    [NPH_TPM_B_PARTIAL] = {"tpm.partial", NPH_I64, "[kind][z][y][x][6]", "1 / fixed_point_scale of unit_W",
                           "of a generation's photons, of the sun's and of the others: flux of three channels, flux times cosine, flux times "
                           "order, and, in print, unweighted and their number", NPH_STAT, NULL, NULL, 0},
    [NPH_TPM_B_OLD] = {"tpm.old", NPH_I64, "[kind][z][y][x][6]", "1 / fixed_point_scale of unit_W", "the same of the generation that leaves",
                       NPH_EXACT, "in a sequence of frames", NULL, 0},
    [NPH_TPM_B_SUM] = {"tpm.sum", NPH_I64, "[kind][z][y][x][6]", "1 / fixed_point_scale of unit_W", "the same of the generations so far", NPH_EXACT,
                       NULL, NULL, 0},
    [NPH_TPM_B_COARSE] = {"tpm.coarse", R, "[cell][10]", "W/m2, 1", CELL, NPH_NEAR, NULL, NULL, 0},
    [NPH_TPM_B_FINE] = {"tpm.fine", R, "[cell][10]", "W/m2, 1", CELL ", at the resolution of the density; 0 where none is near", NPH_NEAR, NULL,
                        NULL, 0},
    [NPH_TPM_B_PICTURE] = {"tpm.picture", R, "[pixel][field]", "W/m2/sr, 1, m", "of marched rays: " PIXEL, NPH_NEAR, NULL, NULL, 0},
    [NPH_TPM_B_IMAGE] = {"tpm.image", R, "[field][pixel]", "W/m2/sr, 1, m", "of a sample, pixels of the crop row by row: " PIXEL, NPH_NEAR, NULL,
                         NULL, 0},
    [NPH_TPM_B_SAMPLE] = {"tpm.sample", R, "[field][pixel][16]", "W/m2/sr, 1, m", "tpm.image of a chunk's samples, in a tile", NPH_NEAR, NULL,
                          NULL, 0},
    [NPH_TPM_B_NODE] = {"film.node", NPH_F64, "[moment][pixel]", "powers of W/m2/sr",
                        "of 16 samples: mean, M2, M3, M4 per channel, then means", NPH_NEAR, NULL, NULL, 0},
};

#undef R

/* What a stage by itself needs to know of its generation, or of all: how many photons they are. */
static NphStatus enter_generation(NphTpmCache *cache, NphTpmStage stage, int generation) {
    if (cache->choice.medium < 0) return NPH_OK;
    if (stage == NPH_TPM_TRACE || stage == NPH_TPM_UPDATE) return nph_tpm_cache_enter(cache, generation);
    for (int g = 0; g < cache->choice.generations && stage == NPH_TPM_RESOLVE; g++) NPH_TRY(nph_tpm_cache_enter(cache, g));
    return NPH_OK;
}

NphStatus nph_tpm_begin_launch(void *opaque, int index, NphFilm *film, const NphLaunch *launch) {
    NphTpmState *state = opaque;
    int64_t sample = launch->arguments[NPH_TPM_ARG_SAMPLE], tile = launch->arguments[NPH_TPM_ARG_TILE];
    int64_t generation = launch->arguments[NPH_TPM_ARG_GENERATION];
    (void)index;
    if (sample < 0 || sample > NPH_MAX_SAMPLES - NPH_CHUNK || tile < 0 || tile >= nph_film_tile_count(film) || generation < 0 ||
        generation >= state->choice.generations + state->age)
        return nph_error(state->job.context, NPH_BAD_INPUT, "sample %lld, generation %lld, tile %lld: there are %d generations and %lld tiles",
                         (long long)sample, (long long)generation, (long long)tile, state->choice.generations,
                         (long long)nph_film_tile_count(film));
    state->film = film;
    state->slot = 0;
    state->cache.sample = (uint32_t)sample;
    state->cache.old = NULL;
    return enter_generation(&state->cache, (NphTpmStage)launch->stage, (int)generation);
}

/* Every buffer is as large as the scene makes it. */
NphStatus nph_tpm_extend(void *opaque, int index, int buffer, const int64_t *shape) {
    NphTpmState *state = opaque;
    NphTpmCache *cache = &state->cache;
    NphView view;
    if (buffer == NPH_TPM_B_OLD) {
        if (!cache->old_room) NPH_TRY(NPH_NEW(state->job.context, cache->values, "generation that leaves", &cache->old_room));
        cache->old = cache->old_room;
    }
    (void)nph_tpm_view(opaque, index, buffer, &view);
    for (int a = 0; a < view.rank; a++)
        if (shape[a] != view.shape[a])
            return nph_error(state->job.context, NPH_BAD_INPUT, "%s: axis %d has %lld items, this scene makes it %lld", nph_tpm_buffers[buffer].name,
                             a, (long long)shape[a], (long long)view.shape[a]);
    return NPH_OK;
}

static NphView cells_of(NphType type, void *data, int64_t cells) {
    return (NphView){type, 2, {cells, NPH_TPM_FIELDS}, data, NPH_TPM_FIELDS};
}

int nph_tpm_view(void *opaque, int index, int buffer, NphView *out) {
    NphTpmState *state = opaque;
    NphTpmCache *cache = &state->cache;
    const NphTpmChoice *choice = &state->choice;
    const int *crop = state->job.crop;
    const int64_t pixels = (int64_t)(crop[2] - crop[0]) * (crop[3] - crop[1]), cells = nph_tpm_cells(choice->cells);
    NphType real = state->job.precision == 32 ? NPH_F32 : NPH_F64;
    enum { PLANE = NPH_TILE_PIXELS * NPH_CHUNK };
    (void)index;
    switch ((NphTpmBuffer)buffer) {
    case NPH_TPM_B_PARTIAL:
    case NPH_TPM_B_OLD:
    case NPH_TPM_B_SUM:
        *out = (NphView){NPH_I64, 5, {NPH_TPM_KINDS, choice->cells[2], choice->cells[1], choice->cells[0], NPH_TPM_VALUES},
                         buffer == NPH_TPM_B_SUM ? cache->sums : buffer == NPH_TPM_B_OLD ? cache->old : cache->partial, cells * NPH_TPM_VALUES};
        return buffer != NPH_TPM_B_OLD || cache->old != NULL;
    case NPH_TPM_B_COARSE: *out = cells_of(real, cache->coarse, cells); return 1;
    case NPH_TPM_B_FINE: *out = cells_of(real, cache->fine, nph_tpm_cells(choice->fine)); return 1;
    case NPH_TPM_B_PICTURE:
        *out = (NphView){real, 2, {(int64_t)state->small[0] * state->small[1], NPH_SAMPLE_FIELDS}, state->picture, NPH_SAMPLE_FIELDS};
        return 1;
    case NPH_TPM_B_IMAGE:
        *out = (NphView){real, 2, {NPH_SAMPLE_FIELDS, pixels}, (char *)state->images + state->image_bytes * (size_t)state->slot, pixels};
        return 1;
    case NPH_TPM_B_SAMPLE: *out = (NphView){real, 3, {NPH_SAMPLE_FIELDS, NPH_TILE_PIXELS, NPH_CHUNK}, state->samples, PLANE}; return 1;
    default:
        *out = (NphView){NPH_F64, 2, {nph_film_planes(state->film), NPH_TILE_PIXELS}, state->film_scratch, NPH_TILE_PIXELS};
        return 1;
    }
}

/* Numbers are taken as they are: none is a place in memory. Sums of a frame's generations stay below 2^63. */
NphStatus nph_tpm_check(void *opaque, int index, const NphLaunch *launch) {
    NphTpmState *state = opaque;
    const char *reads = nph_tpm_stages[launch->stage].reads;
    const int64_t most = (int64_t)1 << 62;
    for (int b = 0; b < NPH_TPM_BUFFERS; b++) {
        NphView seen;
        if (!nph_stage_lists(reads, nph_tpm_buffers[b].name)) continue;
        if (!nph_tpm_view(state, index, b, &seen)) continue;
        int64_t wrong = nph_view_wrong(&seen, 1 - most, most - 1);
        if (wrong >= 0)
            return nph_error(state->job.context, NPH_BAD_INPUT, "input %s: value %lld is not %s", nph_tpm_buffers[b].name, (long long)wrong,
                             seen.type == NPH_I64 ? "below 2^62" : "finite");
    }
    return NPH_OK;
}

NphStatus nph_tpm_launch_alone(void *opaque, int index, const NphLaunch *launch) {
    (void)index;
    return nph_tpm_launch(opaque, launch);
}
