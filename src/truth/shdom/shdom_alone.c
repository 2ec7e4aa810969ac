/* SPDX-License-Identifier: Apache-2.0
 *
 * The buffers of truth/shdom, its launches in a run and alone, and its camera rays in rows: [row][ray], a ray being pixel in its tile * 16
 * + sample in its chunk. */
#include <string.h>

#include "core/message.h"
#include "core/pool.h"
#include "truth/shdom/shdom.h"

#define REAL NPH_TYPE_REAL
enum { BATCH = NPH_SHDOM_BATCH, ROW_P = 0, ROW_D = 3, ROW_AT = 6, ROW_START = 9, ROW_WEIGHT, ROW_PDF };

const NphBuffer nph_shdom_buffers[NPH_SHDOM_BUFFERS] = {
    [NPH_SHDOM_B_DENSITY] = {"shdom.density", REAL, "[z][y][x]", "of the file", "mean over each cell; 1 in boxes and layers", NPH_NEAR, NULL, NULL, 0},
    [NPH_SHDOM_B_BEAM] = {"shdom.beam", REAL, "[channel][coefficient][point]", "W/m2", "harmonics of what suns and points scatter first: albedo times kept "
                          "times irradiance", NPH_NEAR, NULL, NULL, 0},
    [NPH_SHDOM_B_SHARE] = {"shdom.share", REAL, "[channel][cell]", "1", "what a cell gets of suns and points, over the mean of its corners", NPH_NEAR, NULL,
                           NULL, 0},
    [NPH_SHDOM_B_SUN] = {"shdom.sun", REAL, "[sun][point]", "m times density", "depth of density towards each sun", NPH_NEAR, "there are suns, scattered once by "
                         "quadrature", NULL, 0},
    [NPH_SHDOM_B_SUN_MEAN] = {"shdom.sun_mean", REAL, "[sun, channel][cell]", "1", "transmittance from each sun, mean of each cell", NPH_NEAR, "there are suns, scattered once "
                              "by quadrature", NULL, 0},
    [NPH_SHDOM_B_BORDER] = {"shdom.border", REAL, "[channel][ordinate]", "W/m2/sr", "radiance that comes in from lights at infinity", NPH_NEAR, NULL, NULL, 0},
    [NPH_SHDOM_B_SOURCE] = {"shdom.source", REAL, "[channel][coefficient, point; cell]", "W/m2/sr", "source function of light that was scattered before, "
                            "by extinction: coefficients at points, and the mean of degree 0 in cells", NPH_NEAR, NULL, NULL, 0},
    [NPH_SHDOM_B_RADIANCE] = {"shdom.radiance", REAL, "[ordinate of the group][point]", "W/m2/sr", "along each ordinate", NPH_NEAR, NULL, NULL, 0},
    [NPH_SHDOM_B_MEAN] = {"shdom.mean", REAL, "[ordinate of the group][cell]", "W/m2/sr", "radiance along each ordinate, mean of its way through a cell",
                          NPH_NEAR, NULL, NULL, 0},
    [NPH_SHDOM_B_MOMENTS] = {"shdom.moments", REAL, "[coefficient, point; cell]", "W/m2", "harmonics of the radiance of the groups so far", NPH_NEAR, NULL, NULL, 0},
    [NPH_SHDOM_B_FIRST] = {"shdom.first", REAL, "[coefficient, point; cell]", "W/m2", "harmonics of what beams were scattered to once and of the lights at infinity",
                           NPH_NEAR, NULL, NULL, 0},
    [NPH_SHDOM_B_SCATTERED] = {"shdom.scattered", REAL, "[coefficient, point; cell]", "W/m2/sr", "the source function that the last one leads to", NPH_NEAR, NULL,
                               NULL, 0},
    [NPH_SHDOM_B_HISTORY] = {"shdom.history", REAL, "[slot][2][coefficient, point; cell]", "W/m2/sr", "earlier sources, and how one more scattering changed each",
                             NPH_NEAR, NULL, NULL, 0},
    [NPH_SHDOM_B_GRAM] = {"shdom.gram", NPH_F64, "[slot][slot]", "(W/m2/sr)2", "products of those changes", NPH_NEAR, NULL, NULL, 0},
    [NPH_SHDOM_B_RESIDUAL] = {"shdom.residual", NPH_F64, "[1]", "1", "the newest change over its source, root mean squares", NPH_NEAR, NULL, NULL, 0},
    [NPH_SHDOM_B_FIELD] = {"shdom.field", REAL, "[point][part, channel, coefficient]", "W/m2/sr", "the source function, point by point; behind it, where "
                           "cameras look it up, shdom.beam", NPH_NEAR, NULL, NULL, 0},
    [NPH_SHDOM_B_BUBBLE] = {"shdom.bubble", REAL, "[channel][cell]", "W/m2/sr", "by how much the source function's mean in a cell is above that of its "
                            "corners", NPH_NEAR, NULL, NULL, 0},
    [NPH_SHDOM_B_RAY] = {"shdom.ray", NPH_F64, "[12][ray]", "m, 1, 1/sr", "position and direction, point of the sensor, scene-local; distance to the sensor, "
                         "weight, density; weight 0: there is no ray", NPH_NEAR, NULL, NULL, 0},
    [NPH_SHDOM_B_SAMPLE] = {"shdom.sample", NPH_F64, "[field][ray]", "W/m2/sr, 1, m",
                            "radiance, transmittance (3 channels each), order, distance and weight of the first vertex", NPH_NEAR, NULL, NULL, 0},
    [NPH_SHDOM_B_NODE] = {"film.node", NPH_F64, "[moment][pixel]", "powers of W/m2/sr", "of 16 samples: mean, M2, M3, M4 per channel, then means", NPH_NEAR,
                          NULL, NULL, 0},
};

#undef REAL

void nph_shdom_begin_batch(NphShdomState *state, NphShdomWorker *worker, int64_t tile, int64_t chunk) {
    nph_film_tile_rect(state->film, tile, worker->origin, worker->inside);
    worker->chunk = chunk;
}

static void put_ray(double *rows, int id, const RCameraRay *ray) {
    for (int a = 0; a < 3; a++) {
        rows[(ROW_P + a) * BATCH + id] = ray->p[a];
        rows[(ROW_D + a) * BATCH + id] = ray->d[a];
        rows[(ROW_AT + a) * BATCH + id] = ray->at[a];
    }
    rows[ROW_START * BATCH + id] = ray->start;
    rows[ROW_WEIGHT * BATCH + id] = ray->weight;
    rows[ROW_PDF * BATCH + id] = ray->pdf;
}

static RCameraRay get_ray(const double *rows, int id) {
    RCameraRay ray = {.start = rows[ROW_START * BATCH + id], .weight = rows[ROW_WEIGHT * BATCH + id], .pdf = rows[ROW_PDF * BATCH + id]};
    for (int a = 0; a < 3; a++) {
        ray.p[a] = rows[(ROW_P + a) * BATCH + id];
        ray.d[a] = rows[(ROW_D + a) * BATCH + id];
        ray.at[a] = rows[(ROW_AT + a) * BATCH + id];
    }
    return ray;
}

/* Pixel of the whole picture and sample that a ray belongs to; 0 when the ray is not in the picture. */
static int name_of(const NphShdomState *state, const NphShdomWorker *worker, int id, int pixel[2], NphSingleAsk *ask) {
    const int *in = worker->inside;
    pixel[0] = worker->origin[0] + ((id >> 4) & 15);
    pixel[1] = worker->origin[1] + (id >> 8);
    *ask = (NphSingleAsk){(uint32_t)pixel[1] * (uint32_t)state->scenes[1].local.width + (uint32_t)pixel[0],
                          (uint32_t)(worker->chunk * NPH_CHUNK + (id & 15)), NULL, NULL};
    return pixel[0] >= in[0] && pixel[0] < in[2] && pixel[1] >= in[1] && pixel[1] < in[3];
}

static void generate(const NphShdomState *state, NphShdomWorker *worker) {
    memset(worker->rays, 0, sizeof *worker->rays * NPH_SHDOM_RAY_ROWS * BATCH);
    for (int id = 0; id < BATCH; id++) {
        int pixel[2];
        NphSingleAsk ask;
        if (!name_of(state, worker, id, pixel, &ask)) continue;
        RCameraRay ray = nph_single_ray(&state->scenes[1].local, pixel[0], pixel[1], ask.pixel, ask.sample);
        put_ray(worker->rays, id, &ray);
    }
}

void nph_shdom_see(NphShdomState *state, int worker, const RCameraRay *ray, const NphSingleAsk *ask, double fields[NPH_SAMPLE_FIELDS]) {
    const NphShdomRoom *room = &state->workers[worker].room;
    if (nph_sensor_gathers(state->scenes[1].local.sensor.kind)) nph_shdom_march_gather(&state->camera, room, ray, ask, fields);
    else nph_shdom_march(&state->camera, room, ray, ask, fields);
}

static void march(NphShdomState *state, int index) {
    NphShdomWorker *worker = &state->workers[index];
    memset(worker->samples, 0, sizeof *worker->samples * NPH_SAMPLE_FIELDS * BATCH);
    for (int id = 0; id < BATCH; id++) {
        int pixel[2];
        NphSingleAsk ask;
        double fields[NPH_SAMPLE_FIELDS];
        if (!name_of(state, worker, id, pixel, &ask)) continue;
        RCameraRay ray = get_ray(worker->rays, id);
        if (!(ray.weight > 0.0)) continue;
        nph_shdom_see(state, index, &ray, &ask, fields);
        for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) worker->samples[f * BATCH + id] = fields[f];
    }
}

NphStatus nph_shdom_launch(NphShdomState *state, int worker, const NphLaunch *launch) {
    NphStageCounts *counts = &state->solver.counts[worker];
    NphShdomWorker *own = &state->workers[worker];
    switch ((NphShdomStage)launch->stage) {
    case NPH_SHDOM_GENERATE: NPH_LAUNCH(counts, launch->stage, launch->items, generate(state, own)); return NPH_OK;
    case NPH_SHDOM_MARCH: NPH_LAUNCH(counts, launch->stage, launch->items, march(state, worker)); return NPH_OK;
    case NPH_SHDOM_ACCUMULATE:
        NPH_LAUNCH(counts, launch->stage, launch->items, nph_film_chunk(state->film, 64, own->samples, own->film_scratch));
        return NPH_OK;
    default: return nph_shdom_step(&state->solver, (NphShdomStage)launch->stage);
    }
}

NphStatus nph_shdom_begin_launch(void *opaque, int index, NphFilm *film, const NphLaunch *launch) {
    NphShdomState *state = opaque;
    const int64_t *of = launch->arguments;
    int64_t tile = of[NPH_SHDOM_ARG_TILE], chunk = of[NPH_SHDOM_ARG_CHUNK], iteration = of[NPH_SHDOM_ARG_ITERATION];
    int groups = state->choice.solved ? nph_shdom_groups(&state->choice) : 1;
    if (tile < 0 || tile >= nph_film_tile_count(film) || chunk < 0 || chunk >= NPH_MAX_SAMPLES / NPH_CHUNK || of[NPH_SHDOM_ARG_CHANNEL] < 0 ||
        of[NPH_SHDOM_ARG_CHANNEL] >= state->choice.channels || of[NPH_SHDOM_ARG_GROUP] < 0 || of[NPH_SHDOM_ARG_GROUP] >= groups || iteration < 0 ||
        iteration > 1000000)
        return nph_error(state->job.context, NPH_BAD_INPUT, "channel %lld, iteration %lld, group %lld, tile %lld, chunk %lld: there are %d channels, %d "
                         "groups of ordinates and %lld tiles", (long long)of[NPH_SHDOM_ARG_CHANNEL], (long long)iteration,
                         (long long)of[NPH_SHDOM_ARG_GROUP], (long long)tile, (long long)chunk, state->choice.channels, groups,
                         (long long)nph_film_tile_count(film));
    if (launch->stage <= NPH_SHDOM_FINISH && !state->choice.solved)
        return nph_error(state->job.context, NPH_BAD_INPUT, "%s: nothing is solved in this scene: nothing scatters, or there is no light",
                         nph_shdom_stages[launch->stage].name);
    if (launch->stage == NPH_SHDOM_ACCELERATE && iteration < 1)
        return nph_error(state->job.context, NPH_BAD_INPUT, "shdom.accelerate: its first iteration is 1");
    state->film = film;
    state->solver.channel = (int)of[NPH_SHDOM_ARG_CHANNEL];
    state->solver.iteration = (int)iteration;
    state->solver.group = (int)of[NPH_SHDOM_ARG_GROUP];
    nph_shdom_begin_batch(state, &state->workers[index], tile, chunk);
    return NPH_OK;
}

/* All buffers are of one size: another one is told by whoever compares it with the view's. */
NphStatus nph_shdom_extend(void *opaque, int index, int buffer, const int64_t *shape) {
    (void)opaque;
    (void)index;
    (void)buffer;
    (void)shape;
    return NPH_OK;
}

static int view_solution(NphShdomState *state, int buffer, NphView *out) {
    NphShdomSolver *s = &state->solver;
    const NphShdomChoice *choice = &state->choice;
    NphType real = state->job.precision == 32 ? NPH_F32 : NPH_F64;
    const NphShdomGrid *grid = &choice->grid;
    const int64_t points = grid->point_count, terms = choice->angles.terms, channels = choice->channels, history = choice->history;
    const int64_t row = nph_shdom_row(choice), field = channels * terms * (1 + choice->looks);
    switch ((NphShdomBuffer)buffer) {
    case NPH_SHDOM_B_DENSITY:
        *out = (NphView){real, 3, {grid->cells[2], grid->cells[1], grid->cells[0]}, s->density, (int64_t)grid->cells[0] * grid->cells[1]};
        break;
    case NPH_SHDOM_B_BEAM: *out = (NphView){real, 3, {channels, terms, points}, s->beam, terms * points}; break;
    case NPH_SHDOM_B_SHARE: *out = (NphView){real, 2, {channels, grid->cell_count}, s->share, grid->cell_count}; break;
    case NPH_SHDOM_B_SUN:
        *out = (NphView){real, 2, {choice->sun_count, points}, s->sun, points};
        return choice->solved && choice->sun_count > 0;
    case NPH_SHDOM_B_SUN_MEAN:
        *out = (NphView){real, 2, {choice->sun_count * channels, grid->cell_count}, s->sun_mean, grid->cell_count};
        return choice->solved && choice->sun_count > 0;
    case NPH_SHDOM_B_BORDER:
        *out = (NphView){real, 2, {channels, nph_shdom_ordinates(&choice->angles)}, s->border, nph_shdom_ordinates(&choice->angles)};
        break;
    case NPH_SHDOM_B_SOURCE: *out = (NphView){real, 2, {channels, row}, s->source, row}; break;
    case NPH_SHDOM_B_RADIANCE: *out = (NphView){real, 2, {nph_shdom_group_size(choice, s->group), points}, s->radiance, points}; break;
    case NPH_SHDOM_B_MEAN: *out = (NphView){real, 2, {nph_shdom_group_size(choice, s->group), grid->cell_count}, s->mean, grid->cell_count}; break;
    case NPH_SHDOM_B_BUBBLE: *out = (NphView){real, 2, {channels, grid->cell_count}, s->bubble, grid->cell_count}; break;
    case NPH_SHDOM_B_MOMENTS: *out = (NphView){real, 1, {row}, s->moments, row}; break;
    case NPH_SHDOM_B_FIRST: *out = (NphView){real, 1, {row}, s->first, row}; break;
    case NPH_SHDOM_B_SCATTERED: *out = (NphView){real, 1, {row}, s->scattered, row}; break;
    case NPH_SHDOM_B_HISTORY: *out = (NphView){real, 3, {history, 2, row}, s->history, 2 * row}; break;
    case NPH_SHDOM_B_GRAM: *out = (NphView){NPH_F64, 2, {history, history}, s->gram, history}; break;
    case NPH_SHDOM_B_RESIDUAL: *out = (NphView){NPH_F64, 1, {1}, s->residual, 1}; break;
    default: *out = (NphView){real, 2, {points, field}, s->field, field}; break;
    }
    return choice->solved;
}

int nph_shdom_view(void *opaque, int index, int buffer, NphView *out) {
    NphShdomState *state = opaque;
    NphShdomWorker *worker = &state->workers[index];
    switch ((NphShdomBuffer)buffer) {
    case NPH_SHDOM_B_RAY: *out = (NphView){NPH_F64, 2, {NPH_SHDOM_RAY_ROWS, BATCH}, worker->rays, BATCH}; return 1;
    case NPH_SHDOM_B_SAMPLE: *out = (NphView){NPH_F64, 2, {NPH_SAMPLE_FIELDS, BATCH}, worker->samples, BATCH}; return 1;
    case NPH_SHDOM_B_NODE:
        *out = (NphView){NPH_F64, 2, {nph_film_planes(state->film), NPH_TILE_PIXELS}, worker->film_scratch, NPH_TILE_PIXELS};
        return 1;
    default: return view_solution(state, buffer, out);
    }
}

/* No number is a place in memory; what is not finite no run could have. */
NphStatus nph_shdom_check(void *opaque, int index, const NphLaunch *launch) {
    NphShdomState *state = opaque;
    const char *reads = nph_shdom_stages[launch->stage].reads;
    for (int b = 0; b < NPH_SHDOM_BUFFERS; b++) {
        NphView seen;
        if (!nph_stage_lists(reads, nph_shdom_buffers[b].name) || !nph_shdom_view(state, index, b, &seen)) continue;
        int64_t wrong = nph_view_wrong(&seen, 0, 0);
        if (wrong >= 0)
            return nph_error(state->job.context, NPH_BAD_INPUT, "input %s: value %lld is not finite", nph_shdom_buffers[b].name, (long long)wrong);
    }
    return NPH_OK;
}

NphStatus nph_shdom_launch_alone(void *opaque, int index, const NphLaunch *launch) { return nph_shdom_launch(opaque, index, launch); }
