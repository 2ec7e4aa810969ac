/* SPDX-License-Identifier: Apache-2.0
 *
 * The stages of single over a batch of rays: what single_march.c does to one ray, for all of them, with its state in
 * arrays between. */
#include <string.h>

#include "truth/single/single.h"

enum { BATCH = NPH_SINGLE_BATCH };

/* Rows of a batch. */
enum {
    ROW_P = 0, ROW_D = 3, ROW_AT = 6, ROW_START = 9, ROW_WEIGHT, ROW_PDF, RAY_ROWS,
    ROW_TOUCH = RAY_ROWS, TOUCH_ROWS = 8, /* point, normal, distance, limit of media */
    ROW_T = ROW_TOUCH + TOUCH_ROWS,
    ROW_PART = ROW_T + 3,
    ROW_SCATTERED = ROW_PART + NPH_SAMPLE_FIELDS /* three a light */
};

const NphBuffer nph_single_buffers[NPH_SINGLE_BUFFERS] = {
    [NPH_SINGLE_RAY] = {"single.ray", NPH_F64, "[12][ray]", "m, 1, 1/sr",
                        "position and direction, point of the sensor, scene-local; distance to the sensor, weight, density; weight 0: "
                        "there is no ray", NPH_NEAR, NULL, NULL, 0},
    [NPH_SINGLE_SURFACE] = {"single.surface", NPH_I32, "[ray]", "1", "surface that the ray ends at; -1: none", NPH_EXACT,
                            "there are surfaces", NULL, 0},
    [NPH_SINGLE_TOUCH] = {"single.touch", NPH_F64, "[8][ray]", "m, 1",
                          "where light leaves that surface, its normal, how far it is; how far media are looked at", NPH_NEAR,
                          "there are surfaces", NULL, 0},
    [NPH_SINGLE_TRANSMITTANCE] = {"single.transmittance", NPH_F64, "[3][ray]", "1", "of all media, to the end of the ray", NPH_NEAR, NULL,
                                  NULL, 0},
    [NPH_SINGLE_SCATTERED] = {"single.scattered", NPH_F64, "[light, channel][ray]", "W/m2/sr",
                              "of what the group brings: light of each lamp, scattered once in media", NPH_NEAR, "there are lights", NULL, 0},
    [NPH_SINGLE_PART] = {"single.part", NPH_F64, "[field][ray]", "W/m2/sr, 1, m", "what the group of wavelengths brings so far", NPH_NEAR,
                         NULL, NULL, 0},
    [NPH_SINGLE_SAMPLE] = {"single.sample", NPH_F64, "[field][ray]", "W/m2/sr, 1, m",
                           "radiance, transmittance (3 channels each), order, distance and weight of the first vertex", NPH_NEAR, NULL, NULL,
                           0},
    [NPH_SINGLE_NODE] = {"film.node", NPH_F64, "[moment][pixel]", "powers of W/m2/sr",
                         "of 16 samples: mean, M2, M3, M4 per channel, then means", NPH_NEAR, NULL, NULL, 0},
};

size_t nph_single_batch_doubles(const NphScene *scene) { return (size_t)(ROW_SCATTERED + 3 * scene->light_count) * BATCH; }

RCameraRay nph_single_ray(const RScene *scene, int x, int y, uint32_t pixel, uint32_t sample) {
    RStream stream = r_stream(scene, NPH_RNG_GENERATE, pixel, sample, 0);
    RCameraRay ray;
    r_camera_ray(scene, x, y, &stream, &ray);
    return ray;
}

static void put3(double *rows, int row, int id, const double value[3]) {
    for (int a = 0; a < 3; a++) rows[(row + a) * BATCH + id] = value[a];
}

static void get3(const double *rows, int row, int id, double value[3]) {
    for (int a = 0; a < 3; a++) value[a] = rows[(row + a) * BATCH + id];
}

static void put_ray(double *rows, int id, const RCameraRay *ray) {
    put3(rows, ROW_P, id, ray->p);
    put3(rows, ROW_D, id, ray->d);
    put3(rows, ROW_AT, id, ray->at);
    rows[ROW_START * BATCH + id] = ray->start;
    rows[ROW_WEIGHT * BATCH + id] = ray->weight;
    rows[ROW_PDF * BATCH + id] = ray->pdf;
}

static void get_state(const NphSingleBatch *batch, int id, NphSingleState *state) {
    const double *rows = batch->rows;
    get3(rows, ROW_P, id, state->ray.p);
    get3(rows, ROW_D, id, state->ray.d);
    get3(rows, ROW_AT, id, state->ray.at);
    state->ray.start = rows[ROW_START * BATCH + id];
    state->ray.weight = rows[ROW_WEIGHT * BATCH + id];
    state->ray.pdf = rows[ROW_PDF * BATCH + id];
    state->met = (RMet){.limit = R_HUGE, .surface = -1};
    if (batch->scenes->local.surfaces.count > 0) {
        get3(rows, ROW_TOUCH, id, state->met.p);
        get3(rows, ROW_TOUCH + 3, id, state->met.n);
        state->met.t = rows[(ROW_TOUCH + 6) * BATCH + id];
        state->met.limit = rows[(ROW_TOUCH + 7) * BATCH + id];
        state->met.surface = batch->surface[id];
    }
    get3(rows, ROW_T, id, state->T);
    for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) state->part[f] = rows[(ROW_PART + f) * BATCH + id];
}

static void put_met(NphSingleBatch *batch, int id, const RMet *met) {
    double *rows = batch->rows;
    put3(rows, ROW_TOUCH, id, met->p);
    put3(rows, ROW_TOUCH + 3, id, met->n);
    rows[(ROW_TOUCH + 6) * BATCH + id] = met->t;
    rows[(ROW_TOUCH + 7) * BATCH + id] = met->limit;
    batch->surface[id] = met->surface;
}

static void put_part(NphSingleBatch *batch, int id, const NphSingleState *state) {
    for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) batch->rows[(ROW_PART + f) * BATCH + id] = state->part[f];
}

static void generate(NphSingleBatch *batch) {
    const RScene *scene = &batch->scenes->local;
    const int *in = batch->inside;
    memset(batch->rows, 0, RAY_ROWS * BATCH * sizeof *batch->rows);
    memset(batch->samples, 0, NPH_SAMPLE_FIELDS * BATCH * sizeof *batch->samples);
    for (int id = 0; id < BATCH; id++) {
        int x = batch->origin[0] + ((id >> 4) & 15), y = batch->origin[1] + (id >> 8);
        uint32_t pixel = (uint32_t)y * (uint32_t)scene->width + (uint32_t)x;
        if (x < in[0] || x >= in[2] || y < in[1] || y >= in[3]) continue;
        RCameraRay ray = nph_single_ray(scene, x, y, pixel, (uint32_t)(batch->chunk * NPH_CHUNK + (id & 15)));
        put_ray(batch->rows, id, &ray);
    }
}

/* One stage for one ray. */
static void step(NphSingleBatch *batch, NphSingleStage stage, int id, NphSingleState *state) {
    const NphSingleScene *scene = &batch->scenes[batch->group];
    int x = batch->origin[0] + ((id >> 4) & 15), y = batch->origin[1] + (id >> 8);
    NphSingleAsk ask = {(uint32_t)y * (uint32_t)scene->local.width + (uint32_t)x,
                        (uint32_t)(batch->chunk * NPH_CHUNK + (id & 15)), NULL, NULL};
    double fields[NPH_SAMPLE_FIELDS];
    switch (stage) {
    case NPH_SINGLE_MEET:
        nph_single_meet(scene, state);
        put_met(batch, id, &state->met);
        break;
    case NPH_SINGLE_GATHER: nph_single_gather(scene, batch->scratch, state, &ask); break;
    case NPH_SINGLE_MARCH:
        nph_single_follow(scene, batch->scratch, state, &ask);
        put3(batch->rows, ROW_T, id, state->T);
        for (int l = 0; l < scene->local.light_count; l++) put3(batch->rows, ROW_SCATTERED + 3 * l, id, state->scattered[l]);
        break;
    case NPH_SINGLE_ARRIVE: nph_single_arrive(scene, batch->scratch, state, &ask); break;
    case NPH_SINGLE_LEAVE: nph_single_leave(scene, batch->scratch, state, &ask); break;
    case NPH_SINGLE_FOLD:
        for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) fields[f] = batch->samples[f * BATCH + id];
        nph_single_fold(scene, batch->group, state, fields);
        for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) batch->samples[f * BATCH + id] = fields[f];
        return;
    default: return;
    }
    put_part(batch, id, state);
}

void nph_single_launch(NphSingleBatch *batch, NphSingleStage stage) {
    NphSingleState state;
    memset(&state, 0, sizeof state);
    if (stage == NPH_SINGLE_GENERATE) {
        generate(batch);
        return;
    }
    for (int id = 0; id < BATCH; id++) {
        get_state(batch, id, &state);
        step(batch, stage, id, &state);
    }
}

int nph_single_view(const NphSingleBatch *batch, int buffer, NphView *view) {
    const NphSingleScene *scene = batch->scenes;
    int surfaces = scene->local.surfaces.count > 0, lights = scene->local.light_count;
    switch (buffer) {
    case NPH_SINGLE_RAY: *view = (NphView){NPH_F64, 2, {RAY_ROWS, BATCH}, batch->rows, BATCH}; return 1;
    case NPH_SINGLE_SURFACE: *view = (NphView){NPH_I32, 1, {BATCH}, batch->surface, BATCH}; return surfaces;
    case NPH_SINGLE_TOUCH: *view = (NphView){NPH_F64, 2, {TOUCH_ROWS, BATCH}, batch->rows + ROW_TOUCH * BATCH, BATCH}; return surfaces;
    case NPH_SINGLE_TRANSMITTANCE: *view = (NphView){NPH_F64, 2, {3, BATCH}, batch->rows + ROW_T * BATCH, BATCH}; return 1;
    case NPH_SINGLE_SCATTERED:
        *view = (NphView){NPH_F64, 2, {3 * lights, BATCH}, batch->rows + ROW_SCATTERED * BATCH, BATCH};
        return lights > 0;
    case NPH_SINGLE_PART: *view = (NphView){NPH_F64, 2, {NPH_SAMPLE_FIELDS, BATCH}, batch->rows + ROW_PART * BATCH, BATCH}; return 1;
    case NPH_SINGLE_SAMPLE: *view = (NphView){NPH_F64, 2, {NPH_SAMPLE_FIELDS, BATCH}, batch->samples, BATCH}; return 1;
    default: return 0;
    }
}

NphStatus nph_single_check(NphContext *context, const NphSingleBatch *batch, const NphStage *stage) {
    static const int checked[] = {NPH_SINGLE_RAY, NPH_SINGLE_SURFACE, NPH_SINGLE_TOUCH};
    for (size_t c = 0; c < sizeof checked / sizeof *checked; c++) {
        const NphBuffer *buffer = &nph_single_buffers[checked[c]];
        NphView seen;
        if (!nph_stage_lists(stage->reads, buffer->name) || !nph_single_view(batch, checked[c], &seen)) continue;
        int64_t wrong = nph_view_wrong(&seen, -1, batch->scenes->local.surfaces.count - 1);
        if (wrong >= 0)
            return nph_error(context, NPH_BAD_INPUT, "input %s: value %lld is not %s", buffer->name, (long long)wrong,
                             seen.type == NPH_I32 ? "one of this scene" : "finite");
    }
    return NPH_OK;
}
