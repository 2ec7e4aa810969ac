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

/* A flight, and what it brings. photon: at the place from which it is connected. */
typedef struct Connector {
    NphLightBatch *batch;
    const RLightScene *light;
    const RScene *scene;
    const RFlight *flight;
    RPhoton photon;
    Real add[3];
} Connector;

static RStream stream_of(const Connector *k, uint32_t stage) {
    uint32_t flights = (uint32_t)(k->flight->name & 0xffffffff);
    return r_flight_stream(k->batch, stage, (uint32_t)(k->flight->name >> 32), flights > 0 ? flights - 1u : 0u);
}

static void write_splat(Connector *k, const RArrival *arrival) {
    RSplat *splat = &k->batch->splat[k->batch->splats++];
    splat->flight = k->flight->name;
    splat->at[0] = arrival->s;
    splat->at[1] = arrival->t;
    for (int c = 0; c < 3; c++) {
        splat->add[c] = k->add[c];
        splat->from[c] = k->photon.p[c];
    }
    splat->order = (int32_t)k->photon.order;
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

/* The vertex at the end of the flight, from which the photon goes on with what is left of its weight. */
static int connect_end(Connector *k, RArrival *arrival) {
    const RScene *scene = k->scene;
    const RFlight *flight = k->flight;
    RPhoton *photon = &k->photon;
    RVertex vertex;
    Real p[3];
    int hit = flight->medium;
    if (hit < 0 && flight->surface < 0) return 0;
    for (int a = 0; a < 3; a++) p[a] = hit >= 0 ? photon->p[a] + flight->distance * photon->d[a] : flight->touch[R_TOUCH_P + a];
    r_vertex_of(scene, hit >= 0 ? hit : -1 - flight->surface, p, flight->touch + R_TOUCH_N, photon->d, &vertex);
    r_wrap_position(&scene->period, vertex.p);
    for (int a = 0; a < 3; a++) photon->p[a] = vertex.p[a];
    for (int c = 0; c < 3; c++) photon->weight[c] = flight->left[c];
    photon->order++;
    return connect(k, &vertex, arrival);
}

/* A crossing of the flux meter, counted when the flight reaches it. */
static int count_crossing(Connector *k, const RArrival *arrival) {
    if (!(arrival->distance < (k->flight->medium >= 0 ? k->flight->distance : R_HUGE))) return 0;
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
    int begins = photon->order == 0 && photon->source != k->scene->light_count;
    if (begins || !r_arrive_by_flight(k->scene, photon->p, photon->d, arrival)) return 0;
    if (k->flight->surface >= 0 && !(arrival->distance < k->flight->touch[R_TOUCH_T])) return 0;
    return k->light->choice.expected ? send(k, arrival, NPH_RNG_TRACE_PASS, R(1.0)) : count_crossing(k, arrival);
}

void NPH_KERNEL(nph_light_connect)(NphLightBatch *batch) {
    Connector k = {.batch = batch, .light = batch->light, .scene = &batch->light->scene};
    int counts = k.scene->sensor.kind == NPH_SENSOR_FLUX;
    batch->splats = 0;
    for (int i = 0; i < batch->flights; i++) {
        RArrival arrival;
        k.flight = &batch->flight[i];
        k.photon = k.flight->photon;
        int begins = (k.flight->name & 0xffffffff) == 0;
        int arrives = counts ? cross(&k, &arrival) : begins ? connect_source(&k, &arrival) : connect_end(&k, &arrival);
        if (arrives) write_splat(&k, &arrival);
    }
}

/* A splat on its way into an image. */
typedef struct Arriving {
    const NphLightBatch *batch;
    const NphLightImage *image;
    const RSplat *splat;
} Arriving;

/* Replay: what arrives. */
static void tell(const Arriving *arriving) {
    const NphLightBatch *batch = arriving->batch;
    const RSplat *splat = arriving->splat;
    const double *o = batch->light->scene.origin;
    char text[256];
    snprintf(text, sizeof text, "  photon %u after %d scatterings at %.9g %.9g %.9g: adds %.9g %.9g %.9g",
             batch->first + (uint32_t)(splat->flight >> 32), splat->order, (double)splat->from[0] + o[0],
             (double)splat->from[1] + o[1], (double)splat->from[2] + o[2], (double)splat->add[0], (double)splat->add[1],
             (double)splat->add[2]);
    arriving->image->line(arriving->image->user, text);
}

/* Adds what arrives to a pixel. */
static void arrived(void *user, int x, int y) {
    const Arriving *arriving = user;
    const RSplat *splat = arriving->splat;
    const NphLightImage *image = arriving->image;
    const int *crop = image->crop;
    if (x < crop[0] || y < crop[1] || x >= crop[2] || y >= crop[3]) return;
    int64_t width = crop[2] - crop[0], pixels = width * (crop[3] - crop[1]), at = (y - crop[1]) * width + x - crop[0];
    int channels = arriving->batch->light->scene.film_channels;
    for (int c = 0; c < channels; c++) image->planes[c * pixels + at] += (double)splat->add[c];
    image->planes[channels * pixels + at] += (double)splat->order * (double)r_luminance(splat->add);
    if (image->line) tell(arriving);
}

void NPH_KERNEL(nph_light_splat)(const NphLightBatch *batch, const NphLightImage *image) {
    Arriving arriving = {.batch = batch, .image = image};
    for (int i = 0; i < batch->splats; i++) {
        arriving.splat = &batch->splat[i];
        RArrival arrival = {.s = batch->splat[i].at[0], .t = batch->splat[i].at[1]};
        r_arrive(&batch->light->scene, &batch->light->choice.aim, &arrival, arrived, &arriving);
    }
}
