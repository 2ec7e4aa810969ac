/* SPDX-License-Identifier: Apache-2.0
 *
 * The memory of a batch, and what the path tracer adds to the scene in the kernels' number type. */
#include <string.h>

#include "transport/camera_lookup.h"
#include "transport/facts_lookup.h"
#include "transport/lights_lookup.h"
#include "transport/prepare_lookup.h"
#include "truth/path/path_lanes.h"

size_t NPH_KERNEL(nph_path_scene_bytes)(int groups);
void NPH_KERNEL(nph_path_prepare)(const NphJob *job, const NphPathChoice *choice, void *memory);
size_t NPH_KERNEL(nph_path_batch_bytes)(void);
void NPH_KERNEL(nph_path_layout)(void *memory, const void *scene, NphPathBatch **out);
void NPH_KERNEL(nph_path_begin)(NphPathBatch *batch, const int origin[2], const int inside[4], int64_t chunk);
int NPH_KERNEL(nph_path_count)(const NphPathBatch *batch);
void NPH_KERNEL(nph_path_set_vertex)(NphPathBatch *batch, int64_t vertex);
NphStatus NPH_KERNEL(nph_path_extend)(NphPathBatch *batch, int buffer, int64_t items);
int NPH_KERNEL(nph_path_view)(NphPathBatch *batch, int buffer, NphView *view);
void NPH_KERNEL(nph_path_walk_bounds)(void *scene, int groups, int medium, const float *cells);
void NPH_KERNEL(nph_path_facts)(const void *scene, int groups, NphFactFn fact, void *user);
const void *NPH_KERNEL(nph_path_samples)(const NphPathBatch *batch);
const NphTally *NPH_KERNEL(nph_path_tally)(const NphPathBatch *batch);

size_t NPH_KERNEL(nph_path_scene_bytes)(int groups) { return (size_t)groups * sizeof(RScene); }

static void prepare_group(const NphJob *job, const NphPathChoice *choice, RScene *out) {
    const NphScene *scene = job->scene;
    out->weighed = choice->weighed > 0.0;
    out->roulette = (Real)job->knobs[NPH_PATH_KNOB_ROULETTE];
    out->shadow_roulette = (Real)job->knobs[NPH_PATH_KNOB_SHADOW_ROULETTE];
    out->guide = choice->guide;
    out->weight_unit = scene->sensor.kind == NPH_SENSOR_FLUX      ? R(0.31830988618379067154)
                       : scene->sensor.kind == NPH_SENSOR_FLUENCE ? R(0.079577471545947667884)
                                                                  : R(1.0);
    out->guide_part = (Real)choice->guide_part;
    out->least_light = (Real)(choice->least_light * 0.079577471545947668);
    for (int l = 0; l < out->light_count; l++)
        out->lights[l].near_squared = (Real)(choice->near_m[l] * choice->near_m[l]);
    for (int e = 0; e < out->emitter_count; e++)
        if (out->emitters[e].field.shape == NPH_SHAPE_GRID)
            out->emitters[e].field.sigma_max *= (Real)job->knobs[NPH_PATH_KNOB_EMISSION_EVENTS];
    for (int m = 0; m < out->medium_count && !out->spectral; m++)
        r_weigh_flights(&scene->media[out->media[m].number], choice->weighed, &out->media[m]);
}

enum { PILOTS = 16 }; /* across and down */

/* What collides of the camera rays through the middles of a PILOTS x PILOTS raster over the picture; 0 if a light shines
 * behind one of them. */
static int measure_collisions(const RScene *scene, double part[PILOTS * PILOTS]) {
    Real behind[3] = {R(0.0), R(0.0), R(0.0)};
    for (int k = 0; k < PILOTS * PILOTS; k++) {
        int x = scene->width * (2 * (k % PILOTS) + 1) / (2 * PILOTS), y = scene->height * (2 * (k / PILOTS) + 1) / (2 * PILOTS);
        RStream stream = r_stream(scene, NPH_RNG_PILOT, (uint32_t)k, 0, 0);
        RCameraRay ray;
        r_camera_ray(scene, x, y, &stream, &ray);
        RSpan span = r_clip(&scene->media[0], ray.p, ray.d, R_HUGE);
        part[k] = -nph_expm1(-(double)r_forced_depth(&scene->media[0], &span));
        r_lights_at_infinity(scene, ray.d, ray.pdf, behind);
    }
    return !(behind[0] + behind[1] + behind[2] > R(0.0));
}

/* With k times as many collisions, P = min(1, k q) of the rays of collided part q, the second moment of a sample goes as the sum
 * of q^2 / P and its cost as that of 1 + c P, c what a path costs after its first collision over what it costs before. The k
 * of the least product; 4 for c (measured: 2 to 10). 0, not to split, where that promises less than a quarter, and where
 * light comes from behind: what passes and what scatters then make up for each other (in a furnace exactly). */
static Real choose_oftener(const RScene *scene) {
    double part[PILOTS * PILOTS], first = 0.0, least = nph_infinity(), best = 1.0, k = 1.0;
    if (!measure_collisions(scene, part)) return R(0.0);
    for (int step = 0; step <= 100; step++, k *= 1.4142135623730951) {
        double square = 0.0, cost = 0.0;
        for (int p = 0; p < PILOTS * PILOTS; p++) {
            double chance = part[p] * k < 1.0 ? part[p] * k : 1.0;
            square += chance > 0.0 ? part[p] * part[p] / chance : 0.0;
            cost += 1.0 + 4.0 * chance;
        }
        first = step == 0 ? square * cost : first;
        if (!(square * cost < least * 0.999)) continue;
        least = square * cost;
        best = k;
    }
    return least * 1.25 < first ? (Real)best : R(0.0);
}

void NPH_KERNEL(nph_path_prepare)(const NphJob *job, const NphPathChoice *choice, void *memory) {
    RScene *groups = memory;
    r_prepare_groups(job->scene, &choice->transport, job->seed, job->frame, groups);
    for (int g = 0; g < choice->transport.groups; g++) prepare_group(job, choice, &groups[g]);
    if (choice->forced) groups[0].forced = choose_oftener(&groups[0]);
}

void NPH_KERNEL(nph_path_walk_bounds)(void *memory, int groups, int medium, const float *cells) {
    RScene *scene = memory;
    for (int g = 0; g < groups; g++)
        for (int m = 0; m < scene[g].medium_count; m++)
            if (scene[g].media[m].number == (uint32_t)medium) scene[g].media[m].majorant = cells;
}

void NPH_KERNEL(nph_path_facts)(const void *memory, int groups, NphFactFn fact, void *user) {
    const RScene *scene = memory;
    r_fact(fact, user, "weighed", (Real)scene->weighed);
    r_fact(fact, user, "split", scene->forced);
    r_fact(fact, user, "guide", (Real)scene->guide);
    r_fact(fact, user, "guide_part", scene->guide_part);
    r_fact(fact, user, "least_light", scene->least_light);
    r_fact(fact, user, "weight_unit", scene->weight_unit);
    r_scene_facts(scene, groups, fact, user);
}

/* Arrays of a batch in the order in which they lie; called once to measure and once to place. */
static size_t place(NphPathBatch *batch, char *memory) {
    size_t at = (sizeof(NphPathBatch) + 63) / 64 * 64;
    size_t reals = (size_t)NPH_PATH_BATCH * sizeof(Real), ints = (size_t)NPH_PATH_BATCH * sizeof(int32_t);
#define PLACE(target, bytes)                                       \
    do {                                                           \
        if (memory) (target) = (void *)(memory + at);              \
        at += (bytes);                                             \
    } while (0)
    for (int set = 0; set < 2; set++) {
        RPaths *paths = &batch->paths[set];
        /* one after another: loops over lanes reach them from p[0] (R_OF_P ... R_ARRAYS) */
        for (int a = 0; a < 3; a++) PLACE(paths->p[a], reals);
        for (int a = 0; a < 3; a++) PLACE(paths->d[a], reals);
        for (int c = 0; c < 3; c++) PLACE(paths->weight[c], reals);
        for (int c = 0; c < 3; c++) PLACE(paths->share[c], reals);
        PLACE(paths->pdf, reals);
        PLACE(paths->id, ints);
        PLACE(paths->hero, ints);
    }
    PLACE(batch->distance, reals);
    PLACE(batch->survived, reals);
    PLACE(batch->expected, reals);
    PLACE(batch->medium, ints);
    PLACE(batch->surface, ints);
    for (int a = 0; a < 3; a++) PLACE(batch->surface_p[a], reals);
    for (int a = 0; a < 3; a++) PLACE(batch->surface_n[a], reals);
    PLACE(batch->surface_t, reals);
    PLACE(batch->queue, ints);
    PLACE(batch->escaped, ints);
    for (int a = 0; a < 3; a++) PLACE(batch->ray[a], reals);
    for (int a = 0; a < 3; a++) PLACE(batch->towards[a], reals);
    for (int a = 0; a < 3; a++) PLACE(batch->arriving[a], reals);
    PLACE(batch->carried, reals);
    PLACE(batch->passed, reals);
    PLACE(batch->reach, reals);
    PLACE(batch->ray_id, ints);
    PLACE(batch->flights, (sizeof(RFlights) + 63) / 64 * 64);
    PLACE(batch->samples, reals * NPH_SAMPLE_FIELDS);
    PLACE(batch->start, reals);
    PLACE(batch->collides, reals);
    for (int c = 0; c < 3; c++) PLACE(batch->passed_by[c], reals);
#undef PLACE
    return at;
}

size_t NPH_KERNEL(nph_path_batch_bytes)(void) {
    NphPathBatch measure;
    return place(&measure, NULL);
}

void NPH_KERNEL(nph_path_layout)(void *memory, const void *scene, NphPathBatch **out) {
    NphPathBatch *batch = memory;
    memset(batch, 0, sizeof *batch);
    batch->scene = scene;
    place(batch, memory);
    *out = batch;
}

void NPH_KERNEL(nph_path_begin)(NphPathBatch *batch, const int origin[2], const int inside[4], int64_t chunk) {
    batch->tile_x = origin[0];
    batch->tile_y = origin[1];
    memcpy(batch->inside, inside, sizeof batch->inside);
    batch->first_sample = (uint32_t)(chunk * NPH_CHUNK);
    batch->now = batch->count = batch->queued = batch->touched = batch->left = 0;
    batch->vertex = 0;
    memset(batch->start, 0, sizeof(Real) * NPH_PATH_BATCH);
    for (int a = 0; a < 4 && batch->scene->forced > R(0.0); a++)
        memset(a < 3 ? batch->passed_by[a] : batch->collides, 0, sizeof(Real) * NPH_PATH_BATCH);
    memset(batch->samples, 0, sizeof(Real) * NPH_SAMPLE_FIELDS * NPH_PATH_BATCH);
}

int NPH_KERNEL(nph_path_count)(const NphPathBatch *batch) { return batch->count; }
const void *NPH_KERNEL(nph_path_samples)(const NphPathBatch *batch) { return batch->samples; }
const NphTally *NPH_KERNEL(nph_path_tally)(const NphPathBatch *batch) { return &batch->tally; }
void NPH_KERNEL(nph_path_set_vertex)(NphPathBatch *batch, int64_t vertex) { batch->vertex = (uint32_t)vertex; }

NphStatus NPH_KERNEL(nph_path_extend)(NphPathBatch *batch, int buffer, int64_t items) {
    int before = buffer == NPH_PATH_TOUCHING ? batch->queued : 0;
    if (items < 0 || items > NPH_PATH_BATCH - before) return NPH_BAD_INPUT;
    if (buffer == NPH_PATH_ID) batch->count = (int)items;
    if (buffer == NPH_PATH_COLLIDING) batch->queued = (int)items;
    if (buffer == NPH_PATH_TOUCHING) batch->touched = (int)items;
    if (buffer == NPH_PATH_LEAVING) batch->left = (int)items;
    return NPH_OK;
}

static NphView rows(void *data, int count, int64_t items) {
    return (NphView){NPH_PRECISION == 32 ? NPH_F32 : NPH_F64, 2, {count, items}, data, NPH_PATH_BATCH};
}

static NphView reals(void *data, int64_t items) {
    return (NphView){NPH_PRECISION == 32 ? NPH_F32 : NPH_F64, 1, {items}, data, 1};
}

static NphView integers(void *data, int64_t items) { return (NphView){NPH_I32, 1, {items}, data, 1}; }

/* Those that only some scenes have. */
static int view_conditional(NphPathBatch *batch, int buffer, NphView *view) {
    const RScene *scene = batch->scene;
    int surfaces = scene->surfaces.count > 0, split = scene->forced > R(0.0);
    switch (buffer) {
    case NPH_PATH_ORIGIN: *view = rows(batch->ray[0], 3, batch->count); return nph_sensor_gathers(scene->sensor.kind);
    case NPH_PATH_SURFACE: *view = integers(batch->surface, batch->count); return surfaces;
    case NPH_PATH_TOUCH: *view = rows(batch->surface_p[0], 7, batch->count); return surfaces;
    case NPH_PATH_TOUCHING: *view = integers(batch->queue + batch->queued, batch->touched); return surfaces;
    case NPH_PATH_FLOWN: *view = rows(batch->survived, 2, batch->count); return scene->weighed || (split && batch->vertex == 0);
    case NPH_PATH_COLLIDED: *view = reals(batch->collides, NPH_PATH_BATCH); return split;
    case NPH_PATH_ASIDE: *view = rows(batch->passed_by[0], 3, NPH_PATH_BATCH); return split;
    default: return 0;
    }
}

int NPH_KERNEL(nph_path_view)(NphPathBatch *batch, int buffer, NphView *view) {
    RPaths *paths = &batch->paths[batch->now];
    int channels = batch->scene->channels;
    switch (buffer) {
    case NPH_PATH_ID: *view = integers(paths->id, batch->count); return 1;
    case NPH_PATH_HERO: *view = integers(paths->hero, batch->count); return 1;
    case NPH_PATH_RAY: *view = rows(paths->p[0], 6, batch->count); return 1;
    case NPH_PATH_WEIGHT: *view = rows(paths->weight[0], channels, batch->count); return 1;
    case NPH_PATH_SHARE: *view = rows(paths->share[0], channels, batch->count); return 1;
    case NPH_PATH_PDF: *view = reals(paths->pdf, batch->count); return 1;
    case NPH_PATH_DISTANCE: *view = reals(batch->distance, batch->count); return 1;
    case NPH_PATH_MEDIUM: *view = integers(batch->medium, batch->count); return 1;
    case NPH_PATH_COLLIDING: *view = integers(batch->queue, batch->queued); return 1;
    case NPH_PATH_LEAVING: *view = integers(batch->escaped, batch->left); return 1;
    case NPH_PATH_START: *view = reals(batch->start, NPH_PATH_BATCH); return 1;
    case NPH_PATH_SAMPLE: *view = rows(batch->samples, NPH_SAMPLE_FIELDS, NPH_PATH_BATCH); return 1;
    default: return view_conditional(batch, buffer, view);
    }
}
