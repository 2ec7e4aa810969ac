/* SPDX-License-Identifier: Apache-2.0
 *
 * light.trace: photons from their lights to their end, one after another.
 *
 *   pixel += sum over vertices of  weight * albedo * p(cos) * T * factor      (vertex connected to the sensor)
 *   flux  += sum over flights of   weight * T / A                             (where a flight crosses the sensor)
 *
 * A flight ends at the nearest of the media's collisions (delta tracking), at a surface, or never. Weights keep the
 * albedo; roulette ends photons whose weight has become small. Towards a flux meter behind thick layers photons are split,
 * so that a deep one is not one in a million but many with a millionth of the weight. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "truth/light/light_1_emit_lookup.h"
#include "truth/light/light_2_connect_lookup.h"
#include "transport/prepare_lookup.h"

size_t NPH_KERNEL(nph_light_scene_bytes)(void);
void NPH_KERNEL(nph_light_prepare)(const NphJob *job, const NphLightChoice *choice, const NphEmissionSources *sources,
                                   void *memory);
void NPH_KERNEL(nph_light_trace)(const void *memory, NphLightImage *image);

enum { SPLITS = 256, MOST_COPIES = 16, MOST_FLIGHTS = 1 << 22 };

/* Copies of a photon that still wait at a vertex. */
typedef struct Waiting {
    RPhoton photon;
    RVertex vertex;
    int copies;
} Waiting;

typedef struct Tracer {
    const RLightScene *light;
    const RScene *scene;
    NphLightImage *image;
    uint32_t name, number; /* of the photon; of its flight */
    RPhoton photon;
    double reach;          /* optical way to the meter when emitted, as splitting counts it */
    Real adds[3];          /* what arrives at the sensor */
    Waiting waiting[SPLITS];
    int count;
} Tracer;

size_t NPH_KERNEL(nph_light_scene_bytes)(void) { return sizeof(RLightScene); }

void NPH_KERNEL(nph_light_prepare)(const NphJob *job, const NphLightChoice *choice, const NphEmissionSources *sources,
                                   void *memory) {
    RLightScene *out = memory;
    r_prepare_scene(job->scene, &choice->transport, job->seed, job->frame, &out->scene);
    out->choice = *choice;
    out->sources = *sources;
    out->roulette = (Real)job->knobs[NPH_LIGHT_KNOB_ROULETTE];
    out->scene.shadow_roulette = (Real)job->knobs[NPH_LIGHT_KNOB_CONNECT_ROULETTE];
}

static void tell(const Tracer *t, const char *format, ...) {
    char text[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    t->image->line(t->image->user, text);
}

static RStream stream_of(const Tracer *t, uint32_t stage) {
    return r_stream(t->scene, stage, t->name, (uint32_t)t->image->sample, t->number);
}

/* Adds what arrives to a pixel. */
static void arrived(void *user, int x, int y) {
    Tracer *t = user;
    const NphLightImage *image = t->image;
    const int *crop = image->crop;
    if (x < crop[0] || y < crop[1] || x >= crop[2] || y >= crop[3]) return;
    int64_t width = crop[2] - crop[0], pixels = width * (crop[3] - crop[1]), at = (y - crop[1]) * width + x - crop[0];
    int channels = t->scene->film_channels;
    for (int c = 0; c < channels; c++) image->planes[c * pixels + at] += (double)t->adds[c];
    image->planes[channels * pixels + at] += (double)t->photon.order * (double)r_luminance(t->adds);
    if (!image->line) return;
    const Real *p = t->photon.p;
    const double *o = t->scene->origin;
    tell(t, "  photon %u after %u scatterings at %.9g %.9g %.9g: adds %.9g %.9g %.9g", t->name, t->photon.order,
         (double)p[0] + o[0], (double)p[1] + o[1], (double)p[2] + o[2], (double)t->adds[0], (double)t->adds[1],
         (double)t->adds[2]);
}

/* Sends weight * value towards the sensor. */
static void send(Tracer *t, const RArrival *arrival, uint32_t stage, Real value) {
    Real T[3] = {R(1.0), R(1.0), R(1.0)};
    const RPhoton *photon = &t->photon;
    if (!(value > R(0.0))) return;
    if (t->scene->surfaces.count > 0 && r_blocked(t->scene, photon->p, arrival->d, arrival->distance)) return;
    RStream stream = stream_of(t, stage);
    r_pass(t->scene, &stream, photon->p, arrival->d, arrival->distance, T, &t->image->tally);
    for (int c = 0; c < 3; c++) t->adds[c] = photon->weight[c] * T[c] * (value * arrival->factor);
    if (!(t->adds[0] + t->adds[1] + t->adds[2] > R(0.0))) return;
    r_arrive(t->scene, &t->light->choice.aim, arrival, arrived, t);
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

static int draw_towards_plane(Tracer *t, const RVertex *vertex, RArrival *arrival, Real *value) {
    const NphSensor *sensor = &t->scene->sensor;
    RStream stream = stream_of(t, NPH_RNG_TRACE_CONNECT);
    NphWords words = r_words(&stream, 0), more = r_words(&stream, 1);
    double rel[3], pick = nph_uniform(more.w0), part = t->light->choice.aim.wrapped ? 0.5 : 1.0 / 3.0;
    RTowardsPlane drawn;
    r_from_sensor(t->scene, vertex->p, rel);
    drawn.side = r_dot64(rel, sensor->forward) > 0.0 ? -1.0 : 1.0;
    if (pick < part) {
        RTurned turned = r_vertex_turn(t->scene, vertex, words, R(0.0));
        for (int a = 0; a < 3; a++) drawn.d[a] = (double)turned.d[a];
    } else if (pick < 2.0 * part) {
        draw_grazing(sensor, words, &drawn);
    } else {
        draw_at_sensor(sensor, words, rel, &drawn);
    }
    double c = r_dot64(drawn.d, sensor->forward) * drawn.side;
    if (!(c > 0.0) || !r_arrive_at_plane(t->scene, vertex->p, drawn.d, arrival)) return 0;
    double own = (double)r_vertex_value(vertex, arrival->d), density = part * (own + 0.079577471545947668 / nph_sqrt(c));
    int inside = nph_abs(arrival->s) <= 1.0 && nph_abs(arrival->t) <= 1.0;
    double r = (double)arrival->distance, area = 4.0 * sensor->half_size[0] * sensor->half_size[1];
    if (!t->light->choice.aim.wrapped && inside) density += part * r * r / (area * c);
    *value = (Real)(own / density);
    return 1;
}

/* Next event: the vertex to the sensor, unless that only counts what crosses it. */
static void connect(Tracer *t, const RVertex *vertex) {
    const RScene *scene = t->scene;
    RArrival arrival;
    Real value = R(0.0);
    int kind = scene->sensor.kind, met = 0;
    if (kind == NPH_SENSOR_FLUX) return;
    if (kind == NPH_SENSOR_FLUENCE) {
        met = draw_towards_plane(t, vertex, &arrival, &value);
    } else {
        int at_point = kind == NPH_SENSOR_PERSPECTIVE || kind == NPH_SENSOR_FISHEYE;
        met = at_point ? r_arrive_at_point(scene, vertex->p, &arrival)
                       : r_arrive_along(scene, &t->light->choice.aim, vertex->p, &arrival);
        if (met) value = r_vertex_value(vertex, arrival.d);
    }
    if (met) send(t, &arrival, NPH_RNG_TRACE_PASS, value);
}

/* The nearest of the media's collisions; its medium's position in the list, or -1. */
static int fly(Tracer *t, Real limit, Real *distance) {
    const RScene *scene = t->scene;
    RStream stream = stream_of(t, NPH_RNG_TRACE_FLY);
    Real nearest = limit;
    int hit = -1;
    for (int m = 0; m < scene->medium_count; m++) {
        REvents events = r_events(&stream, 0, scene->media[m].number);
        Real at = r_free_flight(&scene->media[m], t->photon.p, t->photon.d, nearest, t->photon.hero, &events,
                                &t->image->tally);
        if (at < R(0.0)) continue;
        nearest = at;
        hit = m;
    }
    *distance = nearest;
    return hit;
}

/* What the channels would have made of the flight up to a distance, the hero being 1. */
static void factors_of(Tracer *t, int hit, Real distance, Real factor[3]) {
    const RScene *scene = t->scene;
    RStream stream = stream_of(t, NPH_RNG_TRACE_FLY);
    for (int c = 0; c < 3; c++) factor[c] = R(1.0);
    for (int m = 0; m < scene->medium_count; m++) {
        const RMedium *medium = &scene->media[m];
        if (medium->sigma[0] == medium->sigma[1] && medium->sigma[0] == medium->sigma[2]) continue;
        REvents events = r_events(&stream, 0, medium->number);
        r_flight_factors(medium, t->photon.p, t->photon.d, distance, t->photon.hero, &events, factor);
    }
    for (int c = 0; c < 3 && hit >= 0; c++)
        factor[c] *= scene->media[hit].sigma[c] / scene->media[hit].sigma[t->photon.hero];
}

/* One-sample balance heuristic over the channels, as in path. */
static Real mean_of(const RPhoton *photon, const Real factor[3]) {
    return (photon->share[0] * factor[0] + photon->share[1] * factor[1] + photon->share[2] * factor[2]) * R(1.0 / 3.0);
}

static void reweigh(Tracer *t, int hit, Real distance) {
    Real factor[3];
    factors_of(t, hit, distance, factor);
    Real mean = mean_of(&t->photon, factor);
    for (int c = 0; c < 3; c++) {
        t->photon.share[c] *= factor[c] / mean;
        t->photon.weight[c] *= factor[c] / mean;
    }
}

/* A crossing of the flux meter, counted when the flight reaches it (hit: where it ends). */
static void count_crossing(Tracer *t, const RArrival *arrival, Real end) {
    if (!(arrival->distance < end)) return;
    for (int c = 0; c < 3; c++) t->adds[c] = t->photon.weight[c] * arrival->factor;
    if (t->scene->channels > 1) {
        Real factor[3];
        factors_of(t, -1, arrival->distance, factor);
        Real mean = mean_of(&t->photon, factor);
        for (int c = 0; c < 3; c++) t->adds[c] *= factor[c] / mean;
    }
    r_arrive(t->scene, &t->light->choice.aim, arrival, arrived, t);
}

/* One flight; 0 when the photon leaves. What has not met anything yet is seen by the sensor itself (light.see). */
static int advance(Tracer *t, RVertex *vertex) {
    const RScene *scene = t->scene;
    RPhoton *photon = &t->photon;
    RMet met = {.surface = -1};
    RArrival arrival;
    Real distance;
    int touches = scene->surfaces.count > 0 && r_closest_surface(scene, photon->p, photon->d, R_HUGE, &met);
    int crosses = scene->sensor.kind == NPH_SENSOR_FLUX && (photon->order > 0 || photon->own) && r_arrive_by_flight(scene, photon->p, photon->d, &arrival);
    if (crosses && touches && !(arrival.distance < met.t)) crosses = 0;
    if (crosses && t->light->choice.expected) send(t, &arrival, NPH_RNG_TRACE_PASS, R(1.0));
    int hit = fly(t, touches ? met.limit : R_HUGE, &distance);
    if (crosses && !t->light->choice.expected) count_crossing(t, &arrival, hit >= 0 ? distance : R_HUGE);
    if (scene->channels > 1) reweigh(t, hit, distance);
    if (hit < 0 && !touches) return 0;
    if (hit >= 0) {
        Real p[3] = {photon->p[0] + distance * photon->d[0], photon->p[1] + distance * photon->d[1],
                     photon->p[2] + distance * photon->d[2]};
        r_vertex_in_medium(&scene->media[hit], p, photon->d, vertex);
        t->image->tally.collisions++;
    } else {
        r_vertex_on_surface(scene->surfaces.albedo[met.surface], met.p, met.n, photon->d, vertex);
    }
    r_wrap_position(&scene->period, vertex->p);
    for (int a = 0; a < 3; a++) photon->p[a] = vertex->p[a];
    for (int c = 0; c < 3; c++) photon->weight[c] *= vertex->albedo[c];
    photon->order++;
    return 1;
}

/* Optical way through layers from here to the meter, as splitting counts it. */
static double way_to_meter(const Tracer *t, const Real p[3]) {
    const RScene *scene = t->scene;
    double z = (double)p[2], meter = scene->sensor.position[2] - scene->origin[2], way = 0.0;
    double low = z < meter ? z : meter, high = z < meter ? meter : z;
    for (int m = 0; m < scene->medium_count; m++) {
        const RMedium *medium = &scene->media[m]; /* a layer's space is the world's but for a shift and a scale */
        double row = (double)medium->from_local[10], shift = (double)medium->from_local[11];
        double a = ((double)medium->lo[2] - shift) / row, b = ((double)medium->hi[2] - shift) / row;
        double from = (a < b ? a : b) > low ? (a < b ? a : b) : low, to = (a < b ? b : a) < high ? (a < b ? b : a) : high;
        if (to > from) way += t->light->choice.importance[medium->number] * (to - from);
    }
    return way;
}

/* How many photons go on from here: roulette, or splitting to a weight that falls with the way to the meter. The mean
 * of copies times weight stays. */
static int multiply(Tracer *t, Real chance) {
    RPhoton *photon = &t->photon;
    Real largest = r_largest(t->scene, photon->weight), change;
    int copies;
    if (!(largest > R(0.0))) return 0;
    if (!t->light->choice.split) {
        change = r_survival(t->light->roulette, largest / photon->unit, R(1.0));
        copies = chance < change;
    } else {
        double target = (double)photon->unit * nph_exp(way_to_meter(t, photon->p) - t->reach);
        double ratio = (double)largest / target;
        if (ratio > 0.5 && ratio < 2.0) return 1;
        ratio = ratio < (double)MOST_COPIES ? ratio : (double)MOST_COPIES;
        if (ratio > 1.0 && (t->count == SPLITS || t->number >= MOST_FLIGHTS)) return 1; /* no room: goes on as it is */
        copies = (int)(ratio + (double)chance);
        change = (Real)ratio;
    }
    for (int c = 0; c < 3 && copies > 0; c++) photon->weight[c] /= change;
    return copies;
}

/* Everything that happens at a vertex but the new direction; 0 when the photon ends there. */
static int visit(Tracer *t, RVertex *vertex) {
    connect(t, vertex);
    RStream stream = stream_of(t, NPH_RNG_TRACE_ROULETTE);
    int copies = multiply(t, r_uniform(r_words(&stream, 0).w0));
    if (copies > 1) {
        Waiting *waiting = &t->waiting[t->count++];
        waiting->photon = t->photon;
        waiting->vertex = *vertex;
        waiting->copies = copies - 1;
    }
    return copies > 0;
}

static int resume(Tracer *t, RVertex *vertex) {
    if (t->count == 0) return 0;
    Waiting *waiting = &t->waiting[t->count - 1];
    t->photon = waiting->photon;
    *vertex = waiting->vertex;
    if (--waiting->copies == 0) t->count--;
    return 1;
}

/* Photons far out on a plane stand for much light (light_1_emit_lookup.h), and one of them in rho^3 is reflected to the
 * box or a flux sensor: without help the variance has no end. Half of the reflections go into the cone around the sphere
 * of these, uniformly over its solid angle, and both are weighed by the joint density. */
static RTurned turn_to_target(const Tracer *t, const RVertex *vertex, NphWords words) {
    const NphLightAim *aim = &t->light->choice.aim;
    RTurned turned = r_vertex_turn(t->scene, vertex, words, R(0.0));
    double to[3], radius2 = aim->target[3] * aim->target[3], distance2 = 0.0;
    for (int a = 0; a < 3; a++) {
        to[a] = aim->target[a] - (double)vertex->p[a];
        distance2 += to[a] * to[a];
    }
    if (!(radius2 < 0.999 * distance2)) return turned;
    double sine2 = radius2 / distance2, width = sine2 / (1.0 + nph_sqrt(1.0 - sine2)), distance = nph_sqrt(distance2);
    Real axis[3] = {(Real)(to[0] / distance), (Real)(to[1] / distance), (Real)(to[2] / distance)};
    if (words.w3 & 0x80000000u)
        r_turn_by(axis, r_angle_of_fall(r_uniform(words.w0) * (Real)width), r_uniform(words.w1), turned.d);
    Real own = r_lambert_density(r_dot(vertex->n, turned.d));
    int inside = r_angle_between(axis, turned.d).fall < (Real)width;
    Real joint = R(0.5) * own + (inside ? R(0.5) * (Real)(1.0 / (r_two_pi * width)) : R(0.0));
    turned.weight = own > R(0.0) ? own / joint : R(0.0);
    return turned;
}

/* A new direction; 0 when the photon ends. */
static int turn(Tracer *t, const RVertex *vertex) {
    const NphLightAim *aim = &t->light->choice.aim;
    t->number++;
    RStream stream = stream_of(t, NPH_RNG_TRACE_TURN);
    NphWords words = r_words(&stream, 0);
    RTurned turned = !vertex->phase && aim->target[3] > 0.0 ? turn_to_target(t, vertex, words)
                                                            : r_vertex_turn(t->scene, vertex, words, R(0.0));
    for (int a = 0; a < 3; a++) t->photon.d[a] = turned.d[a];
    for (int c = 0; c < 3; c++) t->photon.weight[c] *= turned.weight;
    return turned.weight > R(0.0);
}

/* Light of a medium is seen from where it begins; of its power in all directions each has 1 / 4 pi. */
static void connect_source(Tracer *t) {
    const NphPhase isotropic = {.kind = NPH_PHASE_ISOTROPIC};
    RPhase phase = r_phase(&isotropic);
    RVertex vertex = {.phase = &phase};
    for (int a = 0; a < 3; a++) {
        vertex.p[a] = t->photon.p[a];
        vertex.d[a] = t->photon.d[a];
    }
    connect(t, &vertex);
}

static void trace_photon(Tracer *t) {
    RVertex vertex;
    RStream stream;
    t->number = 0;
    stream = stream_of(t, NPH_RNG_TRACE_EMIT);
    if (!r_emit(t->light, &stream, &t->photon)) return;
    if (t->light->choice.split) t->reach = way_to_meter(t, t->photon.p);
    if (t->photon.own) connect_source(t);
    int alive = advance(t, &vertex) && visit(t, &vertex);
    while (alive || resume(t, &vertex)) {
        alive = turn(t, &vertex) && advance(t, &vertex) && visit(t, &vertex);
    }
}

void NPH_KERNEL(nph_light_trace)(const void *memory, NphLightImage *image) {
    Tracer tracer;
    tracer.light = memory;
    tracer.scene = &tracer.light->scene;
    tracer.image = image;
    tracer.count = 0;
    tracer.reach = 0.0;
    for (int64_t i = 0; i < tracer.light->choice.photons; i++) {
        tracer.name = (uint32_t)i;
        trace_photon(&tracer);
    }
}
