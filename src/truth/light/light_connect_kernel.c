/* SPDX-License-Identifier: Apache-2.0
 *
 * light.connect, light.splat: what flights, and the vertices at their ends, bring to the sensor.
 *
 *   pixel += sum over vertices of  weight * albedo * p(cos) * T * factor      (vertex connected to the sensor)
 *   flux  += sum over flights of   weight * T / A                             (where a flight crosses the sensor)
 *
 * Splats are added in the order of photons and their flights, which is that of the list. */
#include <stdio.h>

#include "truth/light/light_2_connect_lookup.h"

void NPH_KERNEL(nph_light_connect)(NphLightBatch *batch);
void NPH_KERNEL(nph_light_splat)(const NphLightBatch *batch, const NphLightImage *image);

/* A flight, and what it brings. */
typedef struct Connector {
    NphLightBatch *batch;
    const RLightScene *light;
    const RScene *scene;
    uint32_t name, number;
    RPhoton photon;
    int own;
    Real distance, add[3];
    int hit, touches;
    Real touch; /* how far the surface is */
} Connector;

static RStream stream_of(const Connector *k, uint32_t stage) { return r_flight_stream(k->batch, stage, k->name, k->number); }

static void write_splat(Connector *k, int64_t flight, const RArrival *arrival) {
    enum { ROOM = NPH_LIGHT_ROOM };
    NphLightBatch *batch = k->batch;
    int i = batch->splats++;
    batch->splat[i] = flight;
    batch->at[i] = arrival->s;
    batch->at[ROOM + i] = arrival->t;
    r_put3(batch->add, ROOM, i, k->add);
    r_put3(batch->from, ROOM, i, k->photon.p);
    batch->splat_order[i] = (int32_t)k->photon.order;
}

/* Sends weight * value towards the sensor; 0 when nothing arrives. */
static int send(Connector *k, const RArrival *arrival, uint32_t stage, Real value) {
    Real T[3] = {R(1.0), R(1.0), R(1.0)};
    const RPhoton *photon = &k->photon;
    if (!(value > R(0.0))) return 0;
    if (k->scene->surfaces.count > 0 && r_blocked(k->scene, photon->p, arrival->d, arrival->distance)) return 0;
    RStream stream = stream_of(k, stage);
    r_pass(k->scene, &stream, photon->p, arrival->d, arrival->distance, T, &k->batch->tally);
    for (int c = 0; c < 3; c++) k->add[c] = photon->weight[c] * T[c] * (value * arrival->factor);
    return k->add[0] + k->add[1] + k->add[2] > R(0.0);
}

/* Fluence adds L / |cos|, whose square has no mean when directions are the vertex's own: grazing ones are too rare. They
 * are therefore drawn from three densities with the chances a_i, and weighed by the joint one (one-sample MIS [Veach95]):
 * the vertex's own; c = |cos| = u^2, 1 / (4 pi sqrt c); and uniform points of the sensor, r^2 / (4 half_size c), which find
 * it when it is small, where it has ends. */
typedef struct RTowardsPlane {
    double d[3], c, side; /* side: of the normal that the plane lies on */
} RTowardsPlane;

static void draw_grazing(const NphSensor *sensor, NphWords words, RTowardsPlane *drawn) {
    double turn_sin, turn_cos, u = 1.0 - nph_uniform(words.w0), c = u * u, across = nph_sqrt(1.0 - c * c);
    nph_sincos2pi(nph_uniform(words.w1), &turn_sin, &turn_cos);
    for (int a = 0; a < 3; a++)
        drawn->d[a] = drawn->side * c * sensor->forward[a] + across * (turn_cos * sensor->right[a] + turn_sin * sensor->up[a]);
}

static void draw_at_sensor(const NphSensor *sensor, NphWords words, const double rel[3], RTowardsPlane *drawn) {
    double s = sensor->half_size[0] * (2.0 * nph_uniform(words.w0) - 1.0);
    double t = sensor->half_size[1] * (2.0 * nph_uniform(words.w1) - 1.0);
    for (int a = 0; a < 3; a++) drawn->d[a] = s * sensor->right[a] + t * sensor->up[a] - rel[a];
    double length = nph_sqrt(r_dot64(drawn->d, drawn->d));
    for (int a = 0; a < 3; a++) drawn->d[a] /= length > 0.0 ? length : 1.0;
}

static int draw_towards_plane(const Connector *k, const RVertex *vertex, RArrival *arrival, Real *value) {
    const NphSensor *sensor = &k->scene->sensor;
    RStream stream = stream_of(k, NPH_RNG_TRACE_CONNECT);
    NphWords words = r_words(&stream, 0), more = r_words(&stream, 1);
    double rel[3], pick = nph_uniform(more.w0), part = k->light->choice.aim.wrapped ? 0.5 : 1.0 / 3.0;
    RTowardsPlane drawn;
    r_from_sensor(k->scene, vertex->p, rel);
    drawn.side = r_dot64(rel, sensor->forward) > 0.0 ? -1.0 : 1.0;
    if (pick < part) {
        RTurned turned = r_vertex_turn(k->scene, vertex, words, R(0.0));
        for (int a = 0; a < 3; a++) drawn.d[a] = (double)turned.d[a];
    } else if (pick < 2.0 * part) {
        draw_grazing(sensor, words, &drawn);
    } else {
        draw_at_sensor(sensor, words, rel, &drawn);
    }
    double c = r_dot64(drawn.d, sensor->forward) * drawn.side;
    if (!(c > 0.0) || !r_arrive_at_plane(k->scene, vertex->p, drawn.d, arrival)) return 0;
    double own = (double)r_vertex_value(vertex, arrival->d), density = part * (own + 0.079577471545947668 / nph_sqrt(c));
    int inside = nph_abs(arrival->s) <= 1.0 && nph_abs(arrival->t) <= 1.0;
    double r = (double)arrival->distance, area = 4.0 * sensor->half_size[0] * sensor->half_size[1];
    if (!k->light->choice.aim.wrapped && inside) density += part * r * r / (area * c);
    *value = (Real)(own / density);
    return 1;
}

/* Next event: a vertex to the sensor. */
static int connect(Connector *k, const RVertex *vertex, RArrival *arrival) {
    const RScene *scene = k->scene;
    Real value = R(0.0);
    int kind = scene->sensor.kind, met = 0;
    if (kind == NPH_SENSOR_FLUENCE) {
        met = draw_towards_plane(k, vertex, arrival, &value);
    } else {
        int at_point = kind == NPH_SENSOR_PERSPECTIVE || kind == NPH_SENSOR_FISHEYE;
        met = at_point ? r_arrive_at_point(scene, vertex->p, arrival)
                       : r_arrive_along(scene, &k->light->choice.aim, vertex->p, arrival);
        if (met) value = r_vertex_value(vertex, arrival->d);
    }
    return met && send(k, arrival, NPH_RNG_TRACE_PASS, value);
}

/* Light of a medium is seen from where it begins; of its power in all directions each has 1 / 4 pi. */
static int connect_source(Connector *k, RArrival *arrival) {
    const NphPhase isotropic = {.kind = NPH_PHASE_ISOTROPIC};
    RPhase phase = r_phase(&isotropic);
    RVertex vertex = {.phase = &phase};
    for (int a = 0; a < 3; a++) {
        vertex.p[a] = k->photon.p[a];
        vertex.d[a] = k->photon.d[a];
    }
    return connect(k, &vertex, arrival);
}

/* The vertex at the end of flight i, from which the photon goes on with what is left of its weight. */
static int connect_end(Connector *k, int i, RArrival *arrival) {
    enum { ROOM = NPH_LIGHT_ROOM };
    const RScene *scene = k->scene;
    RPhoton *photon = &k->photon;
    RVertex vertex;
    if (k->hit < 0 && !k->touches) return 0;
    if (k->hit >= 0) {
        Real p[3] = {photon->p[0] + k->distance * photon->d[0], photon->p[1] + k->distance * photon->d[1],
                     photon->p[2] + k->distance * photon->d[2]};
        r_vertex_in_medium(&scene->media[k->hit], p, photon->d, &vertex);
    } else {
        Real p[3], n[3];
        r_get3(k->batch->touch + R_TOUCH_P * ROOM, ROOM, i, p);
        r_get3(k->batch->touch + R_TOUCH_N * ROOM, ROOM, i, n);
        r_vertex_on_surface(scene->surfaces.albedo[k->batch->surface[i]], p, n, photon->d, &vertex);
    }
    r_wrap_position(&scene->period, vertex.p);
    for (int a = 0; a < 3; a++) photon->p[a] = vertex.p[a];
    r_get3(k->batch->left, ROOM, i, photon->weight);
    photon->order++;
    return connect(k, &vertex, arrival);
}

/* A crossing of the flux meter, counted when the flight reaches it. */
static int count_crossing(Connector *k, const RArrival *arrival) {
    if (!(arrival->distance < (k->hit >= 0 ? k->distance : R_HUGE))) return 0;
    for (int c = 0; c < 3; c++) k->add[c] = k->photon.weight[c] * arrival->factor;
    if (k->scene->channels > 1) {
        RStream stream = stream_of(k, NPH_RNG_TRACE_FLY);
        Real factor[3];
        r_flight_channels(k->scene, &stream, &k->photon, -1, arrival->distance, factor);
        Real mean = r_flight_mean(&k->photon, factor);
        for (int c = 0; c < 3; c++) k->add[c] *= factor[c] / mean;
    }
    return 1;
}

/* A flight through the flux meter. What has not met anything yet is seen by the sensor itself (light.see). */
static int cross(Connector *k, RArrival *arrival) {
    const RPhoton *photon = &k->photon;
    if (!(photon->order > 0 || k->own) || !r_arrive_by_flight(k->scene, photon->p, photon->d, arrival)) return 0;
    if (k->touches && !(arrival->distance < k->touch)) return 0;
    return k->light->choice.expected ? send(k, arrival, NPH_RNG_TRACE_PASS, R(1.0)) : count_crossing(k, arrival);
}

/* Flight i of the list. */
static void load(Connector *k, int i) {
    enum { ROOM = NPH_LIGHT_ROOM };
    const NphLightBatch *batch = k->batch;
    RPhoton *photon = &k->photon;
    uint32_t flights = (uint32_t)(batch->flight[i] & 0xffffffff);
    k->name = (uint32_t)(batch->flight[i] >> 32);
    k->number = flights > 0 ? flights - 1u : 0u;
    r_get3(batch->ray, ROOM, i, photon->p);
    r_get3(batch->ray + 3 * ROOM, ROOM, i, photon->d);
    r_get3(batch->weight, ROOM, i, photon->weight);
    if (k->scene->channels > 1) {
        r_get3(batch->share, ROOM, i, photon->share);
        photon->hero = batch->flight_hero[i];
    }
    photon->order = (uint32_t)batch->order[i];
    k->own = batch->source[k->name] == k->scene->light_count;
    k->distance = batch->distance[i];
    k->hit = batch->medium[i];
    k->touches = k->scene->surfaces.count > 0 && batch->surface[i] >= 0;
    if (k->touches) k->touch = batch->touch[R_TOUCH_T * ROOM + i];
}

void NPH_KERNEL(nph_light_connect)(NphLightBatch *batch) {
    Connector k = {.batch = batch, .light = batch->light, .scene = &batch->light->scene};
    int counts = k.scene->sensor.kind == NPH_SENSOR_FLUX;
    batch->splats = 0;
    for (int i = 0; i < batch->flights; i++) {
        RArrival arrival;
        load(&k, i);
        int source = (batch->flight[i] & 0xffffffff) == 0;
        int arrives = counts ? cross(&k, &arrival) : source ? connect_source(&k, &arrival) : connect_end(&k, i, &arrival);
        if (arrives) write_splat(&k, batch->flight[i], &arrival);
    }
}

/* A splat on its way into an image. */
typedef struct Splat {
    const NphLightBatch *batch;
    const NphLightImage *image;
    int number;
    Real add[3];
} Splat;

/* Replay: what arrives. */
static void tell(const Splat *splat) {
    enum { ROOM = NPH_LIGHT_ROOM };
    const NphLightBatch *batch = splat->batch;
    const double *o = batch->light->scene.origin;
    char text[256];
    Real p[3];
    r_get3(batch->from, ROOM, splat->number, p);
    snprintf(text, sizeof text, "  photon %u after %d scatterings at %.9g %.9g %.9g: adds %.9g %.9g %.9g",
             batch->first + (uint32_t)(batch->splat[splat->number] >> 32), batch->splat_order[splat->number], (double)p[0] + o[0],
             (double)p[1] + o[1], (double)p[2] + o[2], (double)splat->add[0], (double)splat->add[1], (double)splat->add[2]);
    splat->image->line(splat->image->user, text);
}

/* Adds what arrives to a pixel. */
static void arrived(void *user, int x, int y) {
    const Splat *splat = user;
    const NphLightImage *image = splat->image;
    const int *crop = image->crop;
    if (x < crop[0] || y < crop[1] || x >= crop[2] || y >= crop[3]) return;
    int64_t width = crop[2] - crop[0], pixels = width * (crop[3] - crop[1]), at = (y - crop[1]) * width + x - crop[0];
    int channels = splat->batch->light->scene.film_channels;
    for (int c = 0; c < channels; c++) image->planes[c * pixels + at] += (double)splat->add[c];
    image->planes[channels * pixels + at] += (double)splat->batch->splat_order[splat->number] * (double)r_luminance(splat->add);
    if (image->line) tell(splat);
}

void NPH_KERNEL(nph_light_splat)(const NphLightBatch *batch, const NphLightImage *image) {
    enum { ROOM = NPH_LIGHT_ROOM };
    Splat splat = {.batch = batch, .image = image};
    for (int i = 0; i < batch->splats; i++) {
        RArrival arrival = {.s = batch->at[i], .t = batch->at[ROOM + i]};
        splat.number = i;
        r_get3(batch->add, ROOM, i, splat.add);
        r_arrive(&batch->light->scene, &batch->light->choice.aim, &arrival, arrived, &splat);
    }
}
