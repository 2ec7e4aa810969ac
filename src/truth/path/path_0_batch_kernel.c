/* SPDX-License-Identifier: Apache-2.0
 *
 * The memory of a batch, and what the path tracer adds to the scene in the kernels' number type. */
#include <string.h>

#include "transport/camera_lookup.h"
#include "transport/lights_lookup.h"
#include "transport/prepare_lookup.h"
#include "truth/path/path_lanes.h"

size_t NPH_KERNEL(nph_path_scene_bytes)(int groups);
void NPH_KERNEL(nph_path_prepare)(const NphJob *job, const NphPathChoice *choice, void *memory);
size_t NPH_KERNEL(nph_path_batch_bytes)(void);
void NPH_KERNEL(nph_path_layout)(void *memory, const void *scene, NphPathBatch **out);
void NPH_KERNEL(nph_path_begin)(NphPathBatch *batch, const int origin[2], const int inside[4], int64_t chunk);
int NPH_KERNEL(nph_path_count)(const NphPathBatch *batch);
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
    batch->now = batch->count = batch->laid_aside = 0;
    memset(batch->samples, 0, sizeof(Real) * NPH_SAMPLE_FIELDS * NPH_PATH_BATCH);
}

int NPH_KERNEL(nph_path_count)(const NphPathBatch *batch) { return batch->count; }
const void *NPH_KERNEL(nph_path_samples)(const NphPathBatch *batch) { return batch->samples; }
const NphTally *NPH_KERNEL(nph_path_tally)(const NphPathBatch *batch) { return &batch->tally; }
