/* SPDX-License-Identifier: Apache-2.0
 *
 * One path in scalar code, from the camera to its end, told event by event. It draws the same random words as the
 * batches and gives the same bits; it is the version to read first, and the tests hold the batches to it.
 *
 *   L = sum over vertices of  weight * albedo * p(cos) * T * L_light / pdf_light * w_light   (light samples)
 *     + weight * L_infinity * w_phase                                                        (where the path leaves) */
#include <stdarg.h>
#include <stdio.h>

#include "transport/camera_lookup.h"
#include "transport/near_lookup.h"
#include "truth/path/path_state.h"

void NPH_KERNEL(nph_path_replay)(const void *memory, const int pixel[2], int64_t sample, NphLineFn line, void *user,
                                 double fields[NPH_SAMPLE_FIELDS]);

typedef struct Replay {
    const RScene *scene;
    uint32_t pixel, sample, vertex;
    NphLineFn line;
    void *user;
    Real p[3], d[3], weight[3], share[3], pdf, camera_weight;
    int hero;
    Real collides, passed_by[3]; /* where camera rays are split; else 1 and 0 */
    Real field[NPH_SAMPLE_FIELDS];
    NphTally tally;
} Replay;

static void tell(const Replay *r, const char *format, ...) {
    if (!r->line) return;
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    r->line(r->user, text);
}

static RStream stream_of(const Replay *r, uint32_t stage) {
    return r_stream(r->scene, stage, r->pixel, r->sample, r->vertex);
}

/* Position in world space, for the reader. */
static double world(const Replay *r, const Real p[3], int a) { return (double)p[a] + r->scene->origin[a]; }

static void add(Replay *r, const Real weight[3], const Real radiance[3]) {
    Real light[3];
    for (int c = 0; c < 3; c++) light[c] = weight[c] * radiance[c];
    r_film_rgb(r->scene, light);
    int colours = r->scene->film_channels > 1 ? 3 : 1;
    for (int c = 0; c < colours; c++) r->field[NPH_SAMPLE_L0 + c] += light[c];
    r->field[NPH_SAMPLE_ORDER] += (Real)r->vertex * r_luminance(light);
}

/* The nearest of the media's collisions before limit; its medium's position in the list, or -1. */
static int fly(Replay *r, Real limit, Real *distance) {
    RStream stream = stream_of(r, NPH_RNG_TRACK);
    Real nearest = limit;
    int hit = -1;
    for (int m = 0; m < r->scene->medium_count; m++) {
        REvents events = r_events(&stream, 0, r->scene->media[m].number);
        Real t = r_free_flight(&r->scene->media[m], r->p, r->d, nearest, r->hero, &events, &r->tally);
        if (r->scene->weighed) r->weight[0] *= r_flight_weight(&r->scene->media[m], events.survived, events.expected);
        if (t < R(0.0)) continue;
        nearest = t;
        hit = m;
    }
    if (r->scene->weighed) r->weight[1] = r->weight[2] = r->weight[0];
    *distance = nearest;
    return hit;
}

static void leave(Replay *r) {
    Real radiance[3] = {R(0.0), R(0.0), R(0.0)};
    r_lights_at_infinity(r->scene, r->d, r->pdf, radiance);
    add(r, r->weight, radiance);
    tell(r, "  leaves along %.6g %.6g %.6g: radiance (weighted) %.9g %.9g %.9g", (double)r->d[0], (double)r->d[1],
         (double)r->d[2], (double)radiance[0], (double)radiance[1], (double)radiance[2]);
    if (r->vertex > 0) return;
    Real T[3] = {r->weight[0], r->weight[1], r->weight[2]};
    r_film_transmittance(r->scene, T);
    for (int c = 0; c < 3; c++) r->field[NPH_SAMPLE_T0 + c] = T[c] * r->scene->weight_unit;
}

/* The first flight, split: what passes escapes, and is laid aside. */
static int fly_forced(Replay *r, Real *distance) {
    const RMedium *medium = &r->scene->media[0];
    RStream stream = stream_of(r, NPH_RNG_TRACK);
    stream.draw = medium->number << NPH_DRAW_MEDIUM_SHIFT;
    RSpan span = r_clip(medium, r->p, r->d, R_HUGE);
    RForced forced = r_forced_flight(medium, &span, r->scene->forced, r_words(&stream, 0));
    tell(r, "  passes with %.9g, collides with %.9g", (double)forced.through, (double)forced.collides);
    r->tally.tentative++;
    r->collides = forced.collides;
    for (int c = 0; c < 3; c++) r->weight[c] = forced.through * r->camera_weight;
    leave(r);
    for (int c = 0; c < 3; c++) {
        r->weight[c] = r->camera_weight * medium->collide;
        r->passed_by[c] = r->field[NPH_SAMPLE_L0 + c];
        r->field[NPH_SAMPLE_L0 + c] = R(0.0);
    }
    *distance = forced.t;
    return forced.collides > R(0.0);
}

static void set_out(const Replay *r, Real distance, RFlown *flight) {
    flight->limit = distance;
    flight->pdf = r->vertex > 0 ? r->pdf : R(-1.0);
    flight->hero = r->hero;
    flight->flown = stream_of(r, NPH_RNG_TRACK);
    for (int c = 0; c < 3; c++) {
        flight->p[c] = r->p[c];
        flight->d[c] = r->d[c];
        flight->weight[c] = r->weight[c];
        flight->share[c] = r->share[c];
    }
}

/* What media add by their own light along the flight. */
static void emit(Replay *r, const RFlown *flight) {
    Real light[3], one[3] = {R(1.0), R(1.0), R(1.0)};
    RStream stream = stream_of(r, NPH_RNG_EMISSION);
    r_emission(r->scene, flight, &stream, &r->tally, light);
    add(r, one, light);
    tell(r, "    emission up to %.9g m: %.9g %.9g %.9g", (double)flight->limit, (double)light[0], (double)light[1],
         (double)light[2]);
}

/* What point lights in media send to one place of the flight: scattered once more than at its start. */
static void near_lights(Replay *r, const RFlown *flight) {
    Real one[3] = {R(1.0), R(1.0), R(1.0)};
    r->vertex++;
    RStream streams[2] = {stream_of(r, NPH_RNG_NEAR), stream_of(r, NPH_RNG_NEAR_SHADOW)};
    for (int l = 0; l < r->scene->light_count; l++) {
        Real light[3];
        if (!(r->scene->lights[l].near_squared > R(0.0))) continue;
        r_near_light(r->scene, flight, l, streams, &r->tally, light);
        add(r, one, light);
        tell(r, "    light %d near the flight: adds %.9g %.9g %.9g", l, (double)light[0], (double)light[1], (double)light[2]);
    }
    r->vertex--;
}

/* One-sample balance heuristic over the channels: what each would have made of this flight. */
static void reweigh(Replay *r, int hit, Real distance) {
    RStream stream = stream_of(r, NPH_RNG_TRACK);
    Real factor[3] = {R(1.0), R(1.0), R(1.0)}, mean = R(0.0);
    for (int m = 0; m < r->scene->medium_count; m++) {
        const RMedium *medium = &r->scene->media[m];
        if (medium->sigma[0] == medium->sigma[1] && medium->sigma[0] == medium->sigma[2]) continue;
        REvents events = r_events(&stream, 0, medium->number);
        r_flight_factors(medium, r->p, r->d, distance, r->hero, &events, factor);
    }
    for (int c = 0; c < 3; c++) {
        if (hit >= 0) factor[c] *= r->scene->media[hit].sigma[c] / r->scene->media[hit].sigma[r->hero];
        mean += r->share[c] * factor[c];
    }
    mean *= R(1.0) / R(3.0);
    for (int c = 0; c < 3; c++) {
        r->share[c] *= factor[c] / mean;
        r->weight[c] *= factor[c] / mean;
    }
    tell(r, "    channels: hero %d, weight %.9g %.9g %.9g, shares %.6g %.6g %.6g", r->hero, (double)r->weight[0],
         (double)r->weight[1], (double)r->weight[2], (double)r->share[0], (double)r->share[1], (double)r->share[2]);
}

/* The largest channel's. */
static Real throughput(const Replay *r) {
    Real largest = R(0.0);
    for (int c = 0; c < r->scene->channels; c++) largest = r_max(largest, r->weight[c]);
    return largest;
}

/* What point lights in media send to the vertex through places around them, scattered there once more. */
static void lights_around(Replay *r, const RVertex *vertex) {
    Real one[3] = {R(1.0), R(1.0), R(1.0)};
    RNearStreams streams = {stream_of(r, NPH_RNG_NEAR), {stream_of(r, NPH_RNG_AROUND_TO), stream_of(r, NPH_RNG_AROUND_FROM)}};
    for (int l = 0; l < r->scene->light_count; l++) {
        Real light[3];
        if (!(r->scene->lights[l].near_squared > R(0.0))) continue;
        r_near_around(r->scene, vertex, r->weight, l, &streams, &r->tally, light);
        r->vertex++;
        add(r, one, light);
        r->vertex--;
        tell(r, "    around light %d: adds %.9g %.9g %.9g", l, (double)light[0], (double)light[1], (double)light[2]);
    }
}

/* A light sample of a vertex: in a medium, on a surface, or of the flux sensor. */
static void sample_light(Replay *r, int number, const RVertex *vertex) {
    const RLight *light = &r->scene->lights[number];
    RStream stream = stream_of(r, NPH_RNG_LIGHT);
    stream.draw = (uint32_t)number << NPH_DRAW_LIGHT_SHIFT;
    RLightSample s;
    r_sample_light(light, vertex->p, &stream, &s);
    r_far_part(light, vertex, &s);
    Real value = r_vertex_value(vertex, s.d), balance = R(1.0);
    if (s.pdf >= R(0.0)) balance = s.pdf / (s.pdf + r_vertex_density(r->scene, vertex, s.d, value, throughput(r)));
    Real weight[3], T[3] = {R(1.0), R(1.0), R(1.0)}, largest = R(0.0), most = R(0.0);
    for (int c = 0; c < 3; c++) {
        weight[c] = r->weight[c] * vertex->albedo[c] * value * balance;
        largest = r_max(largest, weight[c] * s.value[c]);
        most = c < r->scene->channels ? r_max(most, weight[c]) : most;
    }
    if (!(largest > R(0.0))) return;
    int doubtful = vertex->phase && light->kind != NPH_LIGHT_ENVIRONMENT;
    Real chance = doubtful ? r_light_chance(r->scene->least_light, most) : R(1.0);
    if (!(s.chance < chance)) return;
    for (int c = 0; c < 3; c++) weight[c] /= chance;
    if (r->scene->surfaces.count > 0 && r_blocked(r->scene, vertex->p, s.d, s.distance)) {
        tell(r, "    light %d: behind a surface", number);
        return;
    }
    stream = stream_of(r, NPH_RNG_SHADOW);
    for (int m = 0; m < r->scene->medium_count; m++) {
        REvents events = r_events(&stream, number, r->scene->media[m].number);
        r_transmittance(&r->scene->media[m], vertex->p, s.d, s.distance, r->scene, &events, T, &r->tally);
        if (r->scene->channels == 1) T[1] = T[2] = T[0];
        if (!(T[0] + T[1] + T[2] > R(0.0))) break;
    }
    for (int c = 0; c < 3; c++) weight[c] *= T[c];
    add(r, weight, s.value);
    tell(r, "    light %d: transmittance %.9g, density %.6g, weight %.6g; adds %.9g %.9g %.9g", number, (double)T[0],
         (double)value, (double)balance, (double)(weight[0] * s.value[0]), (double)(weight[1] * s.value[1]),
         (double)(weight[2] * s.value[2]));
}

static void sample_lights(Replay *r, const RVertex *vertex) {
    for (int l = 0; l < r->scene->light_count; l++)
        if (r->scene->lights[l].sampled) sample_light(r, l, vertex);
}

/* Albedo, roulette, new direction; 0 when the path ends. */
static int scatter(Replay *r, const RVertex *vertex) {
    RStream stream = stream_of(r, NPH_RNG_SCATTER);
    NphWords words = r_words(&stream, 0);
    Real largest = R(0.0);
    RTurned turned = r_vertex_turn(r->scene, vertex, words, throughput(r));
    for (int c = 0; c < 3; c++) {
        r->weight[c] = r->weight[c] * vertex->albedo[c] * turned.weight;
        largest = c < r->scene->channels ? r_max(largest, r->weight[c]) : largest;
    }
    Real survival = r_survival(r->scene->roulette, largest, turned.peak);
    if (!(largest > R(0.0) && r_uniform(words.w3) < survival)) {
        tell(r, "  ends: %s", largest > R(0.0) ? "roulette" : "absorbed");
        return 0;
    }
    for (int c = 0; c < 3; c++) r->weight[c] /= survival;
    RAngle angle = r_angle_between(r->d, turned.d);
    for (int a = 0; a < 3; a++) r->d[a] = turned.d[a];
    r->pdf = turned.pdf;
    tell(r, "    scatters by cos %.9g into %.6g %.6g %.6g, weight %.9g", (double)angle.cosine, (double)r->d[0],
         (double)r->d[1], (double)r->d[2], (double)r->weight[0]);
    return 1;
}

/* What a camera ray tells of its first vertex; collide: what the medium leaves of its weight, 1 on surfaces. */
static void note_first(Replay *r, Real travelled, Real collide) {
    Real weight = r->scene->weighed ? r->weight[0] / r->camera_weight / collide : R(1.0);
    if (r->scene->forced > R(0.0)) weight = r->collides;
    r->field[NPH_SAMPLE_DISTANCE] = weight * travelled;
    r->field[NPH_SAMPLE_COLLIDED] = weight;
}

/* One flight, to a collision or, when media let it through, to the nearest surface; 0 when the path leaves. */
static int advance(Replay *r, Real start, RVertex *vertex) {
    const RScene *scene = r->scene;
    RMet met = {.surface = -1};
    int touches = scene->surfaces.count > 0 && r_closest_surface(scene, r->p, r->d, R_HUGE, &met);
    int forced = scene->forced > R(0.0) && r->vertex == 0, hit;
    Real distance;
    if (forced && !fly_forced(r, &distance)) return 0;
    hit = forced ? 0 : fly(r, touches ? met.limit : R_HUGE, &distance);
    RFlown flight;
    set_out(r, distance, &flight);
    if (scene->emitter_count > 0) emit(r, &flight);
    near_lights(r, &flight);
    if (scene->channels > 1) reweigh(r, hit, distance);
    if (hit < 0 && !touches) {
        leave(r);
        return 0;
    }
    if (r->vertex == 0) note_first(r, start + (hit >= 0 ? distance : met.t), hit >= 0 ? scene->media[hit].collide : R(1.0));
    r->vertex++;
    if (hit >= 0) {
        Real p[3] = {r->p[0] + distance * r->d[0], r->p[1] + distance * r->d[1], r->p[2] + distance * r->d[2]};
        r_vertex_in_medium(&scene->media[hit], p, r->d, vertex);
    } else {
        r_vertex_on_surface(scene->surfaces.albedo[met.surface], met.p, met.n, r->d, vertex);
    }
    for (int a = 0; a < 3; a++) r->p[a] = vertex->p[a];
    tell(r, "  %s %u %s %u after %.9g m at %.9g %.9g %.9g", hit >= 0 ? "collision" : "reflection", r->vertex,
         hit >= 0 ? "in medium" : "on surface", hit >= 0 ? scene->media[hit].number : (uint32_t)met.surface,
         (double)(hit >= 0 ? distance : met.t), world(r, r->p, 0), world(r, r->p, 1), world(r, r->p, 2));
    return 1;
}

static void follow(Replay *r, Real start) {
    RVertex vertex;
    while (advance(r, start, &vertex)) {
        lights_around(r, &vertex);
        sample_lights(r, &vertex);
        if (!scatter(r, &vertex)) return;
        r_wrap_position(&r->scene->period, r->p);
    }
}

void NPH_KERNEL(nph_path_replay)(const void *memory, const int pixel[2], int64_t sample, NphLineFn line, void *user,
                                 double fields[NPH_SAMPLE_FIELDS]) {
    const RScene *scene = memory;
    uint32_t number = (uint32_t)pixel[1] * (uint32_t)scene->width + (uint32_t)pixel[0];
    Replay r = {.scene = scene, .pixel = number, .sample = (uint32_t)sample, .line = line, .user = user, .collides = R(1.0)};
    RStream stream = stream_of(&r, NPH_RNG_GENERATE);
    RCameraRay ray;
    r_camera_ray(scene, pixel[0], pixel[1], &stream, &ray);
    for (int a = 0; a < 3; a++) {
        r.p[a] = ray.p[a];
        r.d[a] = ray.d[a];
        r.weight[a] = ray.weight;
        r.share[a] = R(1.0);
    }
    r.pdf = ray.pdf;
    r.camera_weight = ray.weight;
    r.scene = scene = r_scene_group(scene, ray.hero);
    r.hero = r_hero_channel(ray.hero);
    tell(&r, "path: pixel %d,%d sample %lld, seed %u, frame %u", pixel[0], pixel[1], (long long)sample, scene->seed,
         scene->frame);
    tell(&r, "  camera ray at %.9g %.9g %.9g (%.9g m from the sensor) along %.9g %.9g %.9g", world(&r, r.p, 0),
         world(&r, r.p, 1), world(&r, r.p, 2), (double)ray.start, (double)r.d[0], (double)r.d[1], (double)r.d[2]);
    if (nph_sensor_gathers(scene->sensor.kind)) {
        RVertex vertex;
        r_vertex_at_sensor(&scene->sensor, ray.at, ray.d, &vertex);
        sample_lights(&r, &vertex);
    }
    if (r_path_blind(scene) && !ray.sees) {
        for (int c = 0; c < 3; c++) r.field[NPH_SAMPLE_T0 + c] = R(1.0);
        tell(&r, "  meets nothing");
    } else if (ray.weight > R(0.0)) follow(&r, ray.start);
    else tell(&r, "  outside of the fisheye's circle");
    for (int c = 0; c < 3; c++) r.field[NPH_SAMPLE_L0 + c] = r.passed_by[c] + r.collides * r.field[NPH_SAMPLE_L0 + c];
    r.field[NPH_SAMPLE_ORDER] *= r.collides;
    int grey = r.scene->film_channels == 1; /* the film then has one channel */
    tell(&r, "result: %.9g %.9g %.9g after %u scatterings, %lld tentative collisions", (double)r.field[0],
         (double)r.field[grey ? 0 : 1], (double)r.field[grey ? 0 : 2], r.vertex, (long long)r.tally.tentative);
    for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) fields[f] = (double)r.field[f];
}
