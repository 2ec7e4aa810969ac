/* SPDX-License-Identifier: Apache-2.0
 *
 * path.shadow: at each vertex one sample of a light, whether a surface hides it, its transmittance by ratio tracking
 * through every medium, and what scatters towards the path: weight * albedo * p(cos) * T * L / pdf, weighted against
 * finding the light by the phase function. On surfaces and at a flux sensor the same with max(0, cos) / pi in place of the
 * phase function, at a sensor for fluence with 1 / 4 pi. [paths, queue, distance, medium, surface -> samples] */
#include "transport/near_lookup.h"
#include "truth/path/path_lanes.h"
#include "truth/path/path_state.h"

void NPH_KERNEL(nph_path_shadow)(NphPathBatch *batch, int light, int at_sensor);

/* The vertex of path i: its next one, or the point of the flux sensor where it began. */
static void vertex_of(const NphPathBatch *batch, int i, int at_sensor, RVertex *vertex) {
    const RPaths *paths = &batch->paths[batch->now];
    if (!at_sensor) {
        r_path_vertex(batch, i, vertex);
        return;
    }
    Real p[3] = {batch->ray[0][i], batch->ray[1][i], batch->ray[2][i]};
    Real d[3] = {paths->d[0][i], paths->d[1][i], paths->d[2][i]};
    r_vertex_at_sensor(&batch->scene->sensor, p, d, vertex);
}

/* The balance heuristic against the density with which the vertex itself would find the light. */
static Real balance_of(const NphPathBatch *batch, int i, const RVertex *vertex, const RLightSample *sample, Real value) {
    if (sample->pdf < R(0.0) || NPH_BUG(2)) return R(1.0);
    const RPaths *paths = &batch->paths[batch->now];
    Real weight = R(0.0);
    for (int c = 0; c < batch->scene->channels; c++) weight = r_max(weight, paths->weight[c][i]);
    return sample->pdf / (sample->pdf + r_vertex_density(batch->scene, vertex, sample->d, value, weight));
}

/* Grey transport, 1: a light sample for each vertex from number `first` of the queue on, and what it would add unhindered.
 * passed: 1, or 0 where that is nothing. */
static void sample_grey(NphPathBatch *batch, int light_number, int first, int count, int at_sensor, uint32_t number) {
    const RScene *scene = batch->scene;
    const RLight *light = &scene->lights[light_number];
    const RPaths *paths = &batch->paths[batch->now];
    for (int k = first; k < count; k++) {
        int i = at_sensor ? k : batch->queue[k];
        int32_t id = paths->id[i];
        RVertex vertex;
        vertex_of(batch, i, at_sensor, &vertex);
        RStream stream = r_stream(scene, NPH_RNG_LIGHT, r_pixel(batch, id), r_sample(batch, id), number);
        stream.draw = (uint32_t)light_number << NPH_DRAW_LIGHT_SHIFT;
        RLightSample sample;
        r_sample_light(light, vertex.p, &stream, &sample);
        r_far_part(light, &vertex, &sample);
        Real value = r_vertex_value(&vertex, sample.d);
        Real balance = balance_of(batch, i, &vertex, &sample, value);
        Real weight = paths->weight[0][i] * vertex.albedo[0] * value * balance;
        Real largest = R(0.0);
        for (int c = 0; c < 3; c++) {
            batch->arriving[c][k] = sample.value[c];
            largest = r_max(largest, weight * sample.value[c]);
        }
        for (int a = 0; a < 3; a++) {
            batch->ray[a][k] = vertex.p[a];
            batch->towards[a][k] = sample.d[a];
        }
        batch->reach[k] = sample.distance;
        int doubtful = vertex.phase && light->kind != NPH_LIGHT_ENVIRONMENT;
        Real chance = doubtful ? r_light_chance(scene->least_light, weight) : R(1.0);
        batch->carried[k] = weight / chance;
        batch->ray_id[k] = id;
        batch->passed[k] = (Real)((largest > R(0.0)) & (sample.chance < chance));
    }
}

/* The same where no lane has to choose: one medium, whose phase function is known, and a sun in one direction. */
typedef struct RSunlight {
    RPhase phase;
    Real albedo, value[3], to[3], least;
    RTile tile;
} RSunlight;

/* by_chance: a constant of the loop; else no light sample is left out, and none draws a number. */
R_INLINE void light_lane(const RSunlight *sun, const Real *from, const int32_t *id, int i, Real distance, Real *rays,
                         int k, int by_chance) {
    Real d[3] = {r_lane(from, R_OF_D, i), r_lane(from, R_OF_D + 1, i), r_lane(from, R_OF_D + 2, i)};
    Real weight = r_lane(from, R_OF_WEIGHT, i) * sun->albedo * r_phase_at(&sun->phase, r_angle_between(d, sun->to));
    Real chance = by_chance ? r_light_chance(sun->least, weight) : R(1.0);
    Real drawn = by_chance ? r_uniform(r_tile_words(&sun->tile, id[i], 0).w2) : R(0.0);
    Real largest = r_max(weight * sun->value[0], R(0.0));
    largest = r_max(largest, weight * sun->value[1]);
    largest = r_max(largest, weight * sun->value[2]);
    rays[R_OF_P * NPH_PATH_BATCH + k] = r_lane(from, R_OF_P, i) + distance * d[0];
    rays[(R_OF_P + 1) * NPH_PATH_BATCH + k] = r_lane(from, R_OF_P + 1, i) + distance * d[1];
    rays[(R_OF_P + 2) * NPH_PATH_BATCH + k] = r_lane(from, R_OF_P + 2, i) + distance * d[2];
    rays[R_OF_D * NPH_PATH_BATCH + k] = sun->to[0];
    rays[(R_OF_D + 1) * NPH_PATH_BATCH + k] = sun->to[1];
    rays[(R_OF_D + 2) * NPH_PATH_BATCH + k] = sun->to[2];
    rays[R_OF_ARRIVING * NPH_PATH_BATCH + k] = sun->value[0];
    rays[(R_OF_ARRIVING + 1) * NPH_PATH_BATCH + k] = sun->value[1];
    rays[(R_OF_ARRIVING + 2) * NPH_PATH_BATCH + k] = sun->value[2];
    rays[R_OF_CARRIED * NPH_PATH_BATCH + k] = weight / chance;
    rays[R_OF_PASSED * NPH_PATH_BATCH + k] = (Real)((largest > R(0.0)) & (drawn < chance));
    rays[R_OF_REACH * NPH_PATH_BATCH + k] = R_HUGE;
}

#define SUNLIGHT(name, phase_kind)                                                                                \
    R_OUTLINE void name(const RSunlight *restrict constant, const Real *restrict from, const int32_t *restrict id,  \
                        const int32_t *restrict queue, const Real *restrict distance, Real *restrict rays) {      \
        RSunlight sun = *constant;                                                                                \
        sun.phase.kind = (phase_kind);                                                                            \
        int count = r_whole_vectors(sun.tile.count), sure = sun.least > R(0.0) ? 0 : count;                                       \
        for (int k = 0; k < sure; k++) light_lane(&sun, from, id, queue[k], distance[queue[k]], rays, k, 0);      \
        for (int k = sure; k < count; k++) light_lane(&sun, from, id, queue[k], distance[queue[k]], rays, k, 1);  \
    }
SUNLIGHT(sunlight_isotropic, NPH_PHASE_ISOTROPIC) /* vec */
SUNLIGHT(sunlight_hg, NPH_PHASE_HG) /* vec */
SUNLIGHT(sunlight_two_lobe, NPH_PHASE_TWO_LOBE) /* vec */
SUNLIGHT(sunlight_rayleigh, NPH_PHASE_RAYLEIGH) /* vec */
SUNLIGHT(sunlight_draine, NPH_PHASE_DRAINE) /* vec */
SUNLIGHT(sunlight_tabulated, NPH_PHASE_TABULATED)

static void sample_sun(NphPathBatch *batch, int number, uint32_t vertex) {
    const RLight *light = &batch->scene->lights[number];
    RStream stream = r_stream(batch->scene, NPH_RNG_LIGHT, 0, 0, vertex);
    stream.draw = (uint32_t)number << NPH_DRAW_LIGHT_SHIFT;
    const RMedium *medium = &batch->scene->media[0];
    const RPaths *paths = &batch->paths[batch->now];
    RSunlight sun = {medium->phase, medium->albedo[0], {light->value[0], light->value[1], light->value[2]},
                     {light->direction[0], light->direction[1], light->direction[2]}, batch->scene->least_light,
                     r_tile(batch, &stream, batch->queued, 0)};
    void (*const samples[])(const RSunlight *, const Real *, const int32_t *, const int32_t *, const Real *, Real *) = {
        [NPH_PHASE_ISOTROPIC] = sunlight_isotropic, [NPH_PHASE_HG] = sunlight_hg,
        [NPH_PHASE_TWO_LOBE] = sunlight_two_lobe, [NPH_PHASE_RAYLEIGH] = sunlight_rayleigh,
        [NPH_PHASE_DRAINE] = sunlight_draine, [NPH_PHASE_TABULATED] = sunlight_tabulated};
    samples[medium->phase.kind](&sun, paths->p[0], paths->id, batch->queue, batch->distance, batch->ray[0]);
    for (int k = 0; k < batch->queued; k++) batch->ray_id[k] = paths->id[batch->queue[k]];
}

R_OUTLINE void pass_homogeneous(const RMedium *restrict medium, const Real *restrict rays, const Real *restrict reach,
                                Real *restrict passed, int rays_in_flight) {
    int count = r_whole_vectors(rays_in_flight);
    for (int k = 0; k < count; k++) { /* vec */
        RSpan span = r_clip_ray(medium, rays, k, reach[k]);
        Real T = r_exp(-medium->sigma[0] * (span.far - span.near));
        passed[k] *= span.inside ? T : R(1.0);
    }
}

/* 2: what surfaces hide. */
static void hide_grey(NphPathBatch *batch, int count) {
    for (int k = 0; k < count; k++) {
        Real p[3] = {batch->ray[0][k], batch->ray[1][k], batch->ray[2][k]};
        Real d[3] = {batch->towards[0][k], batch->towards[1][k], batch->towards[2][k]};
        if (batch->passed[k] > R(0.0) && r_blocked(batch->scene, p, d, batch->reach[k])) batch->passed[k] = R(0.0);
    }
}

/* 3: their transmittances. */
static void pass_grey(NphPathBatch *batch, int m, const RStream *base, int light_number, int count) {
    const RScene *scene = batch->scene;
    const RMedium *medium = &scene->media[m];
    if (count > R_FEW && medium->shape == NPH_SHAPE_GRID) {
        RFlights *flights = batch->flights;
        flights->scene = scene;
        flights->medium = medium;
        flights->stream = *base;
        flights->stream.draw = (uint32_t)light_number << NPH_DRAW_LIGHT_SHIFT | medium->number << NPH_DRAW_MEDIUM_SHIFT;
        flights->batch = batch;
        flights->rays = (RRays){batch->ray[0], batch->reach, batch->passed, NULL, batch->ray_id, count};
        r_flights_run(flights, &batch->tally, 1, NULL, m);
        return;
    }
    if (count > R_FEW && !medium->period.on) {
        pass_homogeneous(medium, batch->ray[0], batch->reach, batch->passed, count);
        return;
    }
    for (int k = 0; k < count; k++) {
        Real p[3] = {batch->ray[0][k], batch->ray[1][k], batch->ray[2][k]}, T[3] = {batch->passed[k], R(0.0), R(0.0)};
        Real d[3] = {batch->towards[0][k], batch->towards[1][k], batch->towards[2][k]};
        if (!(T[0] > R(0.0))) continue;
        RStream stream = *base;
        stream.pixel = r_pixel(batch, batch->ray_id[k]);
        stream.sample = r_sample(batch, batch->ray_id[k]);
        REvents events = r_events(&stream, light_number, medium->number);
        r_transmittance(medium, p, d, batch->reach[k], scene, &events, T, &batch->tally);
        batch->passed[k] = T[0];
    }
}

static void shadow_grey(NphPathBatch *batch, int light_number, int at_sensor) {
    const RScene *scene = batch->scene;
    int count = at_sensor ? batch->count : batch->queued + batch->touched;
    uint32_t vertex = batch->vertex + (at_sensor ? 0u : 1u);
    RStream stream = r_stream(scene, NPH_RNG_SHADOW, 0, 0, vertex);
    const RLight *light = &scene->lights[light_number];
    int sun = light->kind == NPH_LIGHT_SUN && !(light->disc.width > R(0.0)) && scene->medium_count == 1 && !at_sensor;
    if (sun) sample_sun(batch, light_number, vertex);
    sample_grey(batch, light_number, sun ? batch->queued : 0, count, at_sensor, vertex);
    if (scene->surfaces.count > 0) hide_grey(batch, count);
    for (int m = 0; m < scene->medium_count; m++) pass_grey(batch, m, &stream, light_number, count);
    for (int k = 0; k < count; k++) {
        Real arrives = batch->carried[k] * batch->passed[k];
        Real weight[3] = {arrives, arrives, arrives};
        Real value[3] = {batch->arriving[0][k], batch->arriving[1][k], batch->arriving[2][k]};
        if (batch->passed[k] > R(0.0)) r_add_light(batch, scene, batch->ray_id[k], weight, value, vertex);
    }
}

static void shadow_wide(NphPathBatch *batch, int light_number, int at_sensor) {
    const RPaths *paths = &batch->paths[batch->now];
    int count = at_sensor ? batch->count : batch->queued + batch->touched;
    uint32_t number = batch->vertex + (at_sensor ? 0u : 1u);
    for (int k = 0; k < count; k++) {
        int i = at_sensor ? k : batch->queue[k];
        int32_t id = paths->id[i];
        const RScene *scene = r_path_scene(batch, i);
        const RLight *light = &scene->lights[light_number];
        RVertex vertex;
        vertex_of(batch, i, at_sensor, &vertex);
        RStream stream = r_stream(scene, NPH_RNG_LIGHT, r_pixel(batch, id), r_sample(batch, id), number);
        stream.draw = (uint32_t)light_number << NPH_DRAW_LIGHT_SHIFT;
        RLightSample sample;
        r_sample_light(light, vertex.p, &stream, &sample);
        r_far_part(light, &vertex, &sample);
        Real value = r_vertex_value(&vertex, sample.d);
        Real balance = balance_of(batch, i, &vertex, &sample, value);
        Real weight[3], T[3] = {R(1.0), R(1.0), R(1.0)}, largest = R(0.0), most = R(0.0);
        for (int c = 0; c < 3; c++) {
            weight[c] = paths->weight[c][i] * vertex.albedo[c] * value * balance;
            largest = r_max(largest, weight[c] * sample.value[c]);
            most = r_max(most, weight[c]);
        }
        if (!(largest > R(0.0))) continue;
        int doubtful = vertex.phase && light->kind != NPH_LIGHT_ENVIRONMENT;
        Real chance = doubtful ? r_light_chance(scene->least_light, most) : R(1.0);
        if (!(sample.chance < chance)) continue;
        if (scene->surfaces.count > 0 && r_blocked(scene, vertex.p, sample.d, sample.distance)) continue;
        for (int c = 0; c < 3; c++) weight[c] /= chance;
        stream = r_stream(scene, NPH_RNG_SHADOW, stream.pixel, stream.sample, number);
        for (int m = 0; m < scene->medium_count && T[0] + T[1] + T[2] > R(0.0); m++) {
            REvents events = r_events(&stream, light_number, scene->media[m].number);
            r_transmittance(&scene->media[m], vertex.p, sample.d, sample.distance, scene, &events, T, &batch->tally);
        }
        for (int c = 0; c < 3; c++) weight[c] *= T[c];
        r_add_light(batch, scene, id, weight, sample.value, number);
    }
}

void NPH_KERNEL(nph_path_shadow)(NphPathBatch *batch, int light_number, int at_sensor) {
    if (batch->scene->channels > 1) shadow_wide(batch, light_number, at_sensor);
    else shadow_grey(batch, light_number, at_sensor);
}
