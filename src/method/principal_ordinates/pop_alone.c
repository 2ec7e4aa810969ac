/* SPDX-License-Identifier: Apache-2.0
 *
 * The buffers of principal ordinates, and its stages alone. */
#include "core/message.h"
#include "method/principal_ordinates/pop.h"

#define R NPH_TYPE_REAL
#define GRIDS "all grids one after the other, [channel][z][y][x] each"

const NphBuffer nph_pop_buffers[NPH_POP_BUFFERS] = {
    [NPH_POP_B_MEDIUM] = {"pop.medium", R, "[z][y][x]", "as the file", "means of voxels of 2^level", NPH_NEAR, NULL, NULL, 0},
    [NPH_POP_B_IMPORTANCE] = {"pop.importance", R, "[16][32]", "1", "how much of the camera's importance leaves in a direction, per solid angle", NPH_NEAR,
                              "pop.importance is 1", NULL, 0},
    [NPH_POP_B_ORDINATE] = {"pop.ordinate", R, "[grid][12]", "1, m, W/m2, W/sr, sr, m2",
                            "suns, the rest of the sky, points, virtual points: way of the light or place of the point; irradiance or intensity; mean cosine; solid "
                            "angle; normal and area of virtual ones", NPH_NEAR, NULL, NULL, 0},
    [NPH_POP_B_RSM] = {"pop.rsm", R, "[lamp][texel][10]", "m, 1, W, m2", "reflective shadow maps of suns, the sky and points: place, normal, power, area", NPH_NEAR,
                       "a surface reflects, and pop.vpls is above 0", NULL, 0},
    [NPH_POP_B_DENSITY] = {"pop.density", R, "[cell]", "as the file", "all grids one after the other, [z][y][x] each", NPH_NEAR, NULL, NULL, 0},
    [NPH_POP_B_LIT] = {"pop.lit", R, "[cell]", "1", "part of a cell that no surface shades: all grids one after the other, [z][y][x] each", NPH_NEAR,
                       "there are surfaces, and pop.shadows is above 0", NULL, 0},
    [NPH_POP_B_LIGHT] = {"pop.light", R, "[cell]", "1", "under way, over what enters: " GRIDS, NPH_NEAR, NULL, NULL, 0},
    [NPH_POP_B_COSINE] = {"pop.cosine", R, "[cell]", "1", "its mean cosine: " GRIDS, NPH_NEAR, NULL, NULL, 0},
    [NPH_POP_B_SEEN] = {"pop.seen", R, "[cell]", "1/sr, 1/m2/sr", "what is scattered to the observer, over s_s and what enters: " GRIDS, NPH_NEAR, NULL, NULL, 0},
    [NPH_POP_B_POWER] = {"pop.power", NPH_F64, "[grid][channel][2]", "1", "sums over cells of light: injected, and under way", NPH_NEAR, NULL, NULL, 0},
    [NPH_POP_B_RESIDUUM] = {"pop.residuum", R, "[channel][z][y][x]", "W/m2", "isotropic light under way", NPH_NEAR, "pop.residuum is 1", NULL, 0},
    [NPH_POP_B_SPREAD] = {"pop.spread", R, "[channel][z][y][x]", "W/m2", "the sum of what has arrived", NPH_NEAR, "pop.residuum is 1", NULL, 0},
    [NPH_POP_B_GATHERED] = {"pop.gathered", R, "[channel][z][y][x]", "W/m2/sr", "what is scattered to the observer of the light of virtual point lights, over s_s", NPH_NEAR,
                            "a surface reflects, and pop.vpls is above 0", NULL, 0},
    [NPH_POP_B_MERGED] = {"pop.merged", R, "[z][y][x][4]", "W/m2/sr", "what is scattered to the observer, over s_s: three channels; the density over the largest", NPH_NEAR, NULL, NULL, 0},
    [NPH_POP_B_FINE] = {"pop.fine", R, "[z][y][x][4]", "W/m2/sr", "the same at the resolution of the density, its own density in the mean too; 0 where none is near", NPH_NEAR,
                        "pop.upsampling is 1, and the density a grid", NULL, 0},
    [NPH_POP_B_SAMPLE] = {"pop.sample", R, "[field][pixel][16]", "W/m2/sr, 1, m",
                          "of a tile: radiance, transmittance (3 channels each), order (0), distance and weight of the first vertex", NPH_NEAR, NULL, NULL, 0},
    [NPH_POP_B_NODE] = {"film.node", NPH_F64, "[moment][pixel]", "powers of W/m2/sr", "of 16 samples: mean, M2, M3, M4 per channel, then means", NPH_NEAR, NULL,
                        NULL, 0},
};

#undef R

NphStatus nph_pop_begin_launch(void *opaque, int index, NphFilm *film, const NphLaunch *launch) {
    NphPopState *state = opaque;
    int64_t tile = launch->arguments[NPH_POP_ARG_TILE], chunk = launch->arguments[NPH_POP_ARG_CHUNK], iteration = launch->arguments[NPH_POP_ARG_ITERATION];
    (void)index;
    if (tile < 0 || tile >= nph_film_tile_count(film) || chunk < 0 || chunk >= NPH_MAX_SAMPLES / NPH_CHUNK || iteration < 0 ||
        iteration >= NPH_POP_ITERATIONS_MAX)
        return nph_error(state->solver.job.context, NPH_BAD_INPUT, "tile %lld, chunk %lld, iteration %lld: the picture has %lld tiles", (long long)tile,
                         (long long)chunk, (long long)iteration, (long long)nph_film_tile_count(film));
    if (launch->stage < NPH_POP_MARCH && !nph_pop_has(&state->solver, (NphPopStage)launch->stage))
        return nph_error(state->solver.job.context, NPH_BAD_INPUT, "%s: this run leaves it out", nph_pop_stages[launch->stage].name);
    state->film = film;
    state->solver.iteration = (int)iteration;
    state->solver.from = 0;
    state->solver.kept = 0;
    return NPH_OK;
}

/* Every buffer is as large as the scene makes it. */
NphStatus nph_pop_extend(void *opaque, int index, int buffer, const int64_t *shape) {
    NphPopState *state = opaque;
    NphView view;
    if (!nph_pop_view(opaque, index, buffer, &view)) return NPH_OK;
    for (int a = 0; a < view.rank; a++)
        if (shape[a] != view.shape[a])
            return nph_error(state->solver.job.context, NPH_BAD_INPUT, "%s: axis %d has %lld items, this scene makes it %lld", nph_pop_buffers[buffer].name, a,
                             (long long)shape[a], (long long)view.shape[a]);
    return NPH_OK;
}

/* Rows lie one after the other. */
static int box_of(NphView *out, NphType type, void *data, const int32_t n[3], int64_t each) {
    *out = (NphView){type, each > 1 ? 4 : 3, {n[2], n[1], n[0], each}, data, (int64_t)n[1] * n[0] * each};
    return 1;
}

static int channels_of(NphView *out, NphType type, void *data, int channels, const int32_t n[3]) {
    *out = (NphView){type, 4, {channels, n[2], n[1], n[0]}, data, nph_pop_cells(n)};
    return 1;
}

static int row_of(NphView *out, NphType type, void *data, int64_t items) {
    *out = (NphView){type, 1, {items}, data, items};
    return 1;
}

static int view_solution(const NphPopSolver *s, int buffer, NphView *out) {
    const NphPopChoice *choice = &s->choice;
    const NphPopArrays *a = &s->arrays;
    const int grids = nph_pop_grids(choice);
    const NphType real = s->job.precision == 32 ? NPH_F32 : NPH_F64;
    const int64_t cells = nph_pop_first(choice, grids, 1), numbers = nph_pop_first(choice, grids, choice->channels);
    if (!choice->lit) return 0;
    switch (buffer) {
    case NPH_POP_B_MEDIUM: return box_of(out, real, a->medium, choice->mips, 1);
    case NPH_POP_B_IMPORTANCE:
        *out = (NphView){real, 2, {NPH_POP_MAP_HEIGHT, NPH_POP_MAP_WIDTH}, a->importance, NPH_POP_MAP_WIDTH};
        return choice->importance;
    case NPH_POP_B_ORDINATE: *out = (NphView){real, 2, {grids, NPH_POP_ROW}, a->ordinate, NPH_POP_ROW}; return 1;
    case NPH_POP_B_RSM:
        *out = (NphView){real, 3, {nph_pop_lamps(choice), (int64_t)choice->rsm * choice->rsm, NPH_POP_TEXEL}, a->rsm, (int64_t)choice->rsm * choice->rsm * NPH_POP_TEXEL};
        return choice->vpls > 0;
    case NPH_POP_B_DENSITY: return row_of(out, real, a->density, cells);
    case NPH_POP_B_LIT: return row_of(out, real, a->lit, cells) && choice->shadows > 0;
    case NPH_POP_B_LIGHT: return row_of(out, real, a->light, numbers);
    case NPH_POP_B_COSINE: return row_of(out, real, a->cosine, numbers);
    case NPH_POP_B_SEEN: return row_of(out, real, a->seen, numbers);
    case NPH_POP_B_POWER:
        *out = (NphView){NPH_F64, 3, {grids, choice->channels, NPH_POP_POWERS}, a->power, (int64_t)choice->channels * NPH_POP_POWERS};
        return 1;
    case NPH_POP_B_RESIDUUM: return channels_of(out, real, a->residuum[s->from], choice->transport.film_channels, choice->joined) && choice->residuum;
    case NPH_POP_B_SPREAD: return channels_of(out, real, a->spread, choice->transport.film_channels, choice->joined) && choice->residuum;
    case NPH_POP_B_GATHERED: return channels_of(out, real, a->gathered, choice->transport.film_channels, choice->gathered) && choice->vpls > 0;
    case NPH_POP_B_MERGED: return box_of(out, real, a->merged, choice->merged, NPH_POP_CELL);
    default: return box_of(out, real, a->fine, choice->fine, NPH_POP_CELL) && nph_pop_has(s, NPH_POP_UPSAMPLE);
    }
}

int nph_pop_view(void *opaque, int index, int buffer, NphView *out) {
    NphPopState *state = opaque;
    enum { PLANE = NPH_TILE_PIXELS * NPH_CHUNK };
    if (buffer < NPH_POP_B_SAMPLE) return view_solution(&state->solver, buffer, out);
    if (buffer == NPH_POP_B_SAMPLE)
        *out = (NphView){state->solver.job.precision == 32 ? NPH_F32 : NPH_F64, 3, {NPH_SAMPLE_FIELDS, NPH_TILE_PIXELS, NPH_CHUNK}, state->workers[index].samples,
                         PLANE};
    else *out = (NphView){NPH_F64, 2, {nph_film_planes(state->film), NPH_TILE_PIXELS}, state->workers[index].film_scratch, NPH_TILE_PIXELS};
    return 1;
}

/* Numbers are taken as they are: none is a place in memory. Of an ordinate the direction must be one. */
NphStatus nph_pop_check(void *opaque, int index, const NphLaunch *launch) {
    NphPopState *state = opaque;
    const char *reads = nph_pop_stages[launch->stage].reads;
    for (int b = 0; b < NPH_POP_BUFFERS; b++) {
        NphView seen;
        if (!nph_stage_lists(reads, nph_pop_buffers[b].name) || !nph_pop_view(state, index, b, &seen)) continue;
        int64_t wrong = nph_view_wrong(&seen, 0, 0);
        if (wrong >= 0)
            return nph_error(state->solver.job.context, NPH_BAD_INPUT, "input %s: value %lld is not finite", nph_pop_buffers[b].name, (long long)wrong);
    }
    return NPH_OK;
}
