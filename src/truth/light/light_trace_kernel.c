/* SPDX-License-Identifier: Apache-2.0
 *
 * light.emit, light.trace: photons from their lights to their end, one after another.
 *
 * A flight ends at the nearest of the media's collisions (delta tracking), at a surface, or never. Weights keep the
 * albedo; roulette ends photons whose weight has become small. Towards a flux meter behind thick layers photons are split,
 * so that a deep one is not one in a million but many with a millionth of the weight. Every flight is written down, for
 * light_connect_kernel.c; where there is no room for more, what is under way waits for the next launch. */
#include <string.h>

#include "truth/light/light_1_emit_lookup.h"

void NPH_KERNEL(nph_light_emit)(NphLightBatch *batch);
void NPH_KERNEL(nph_light_trace)(NphLightBatch *batch);

enum { MOST_FLIGHTS = 1 << 22 };

typedef struct Tracer {
    const RLightScene *light;
    const RScene *scene;
    NphLightBatch *batch;
    int name;        /* of the photon in its block */
    uint32_t number; /* of its flight */
    RPhoton photon;
    double reach;    /* optical way to the meter when emitted, as splitting counts it */
    RVertex vertex;  /* that the photon is at */
    int32_t where;   /* medium of the vertex, or -1 - surface */
} Tracer;

void NPH_KERNEL(nph_light_emit)(NphLightBatch *batch) {
    enum { ROOM = NPH_LIGHT_BLOCK };
    for (int i = 0; i < batch->photons; i++) {
        RStream stream = r_flight_stream(batch, NPH_RNG_TRACE_EMIT, (uint32_t)i, 0);
        RPhoton photon;
        int emitted = r_emit(batch->light, &stream, &photon);
        Real none[3] = {R(0.0), R(0.0), R(0.0)};
        r_put3(batch->begin, ROOM, i, photon.p);
        r_put3(batch->begin + 3 * ROOM, ROOM, i, photon.d);
        r_put3(batch->power, ROOM, i, emitted ? photon.weight : none);
        batch->unit[i] = emitted ? photon.unit : R(0.0);
        batch->source[i] = photon.source;
        batch->hero[i] = photon.hero;
    }
    batch->place[0] = batch->place[1] = 0;
    batch->waiting = 0;
}

static RStream stream_of(const Tracer *t, uint32_t stage) {
    return r_flight_stream(t->batch, stage, (uint32_t)t->name, t->number);
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
                                &t->batch->tally);
        if (at < R(0.0)) continue;
        nearest = at;
        hit = m;
    }
    *distance = nearest;
    return hit;
}

static void reweigh(Tracer *t, int hit, Real distance) {
    RStream stream = stream_of(t, NPH_RNG_TRACE_FLY);
    Real factor[3];
    r_flight_channels(t->scene, &stream, &t->photon, hit, distance, factor);
    Real mean = r_flight_mean(&t->photon, factor);
    for (int c = 0; c < 3; c++) {
        t->photon.share[c] *= factor[c] / mean;
        t->photon.weight[c] *= factor[c] / mean;
    }
}

/* A flight as it sets out. */
static RFlight *write_flight(Tracer *t, int64_t number) {
    RFlight *flight = &t->batch->flight[t->batch->flights++];
    flight->name = (int64_t)t->name << 32 | number;
    flight->photon = t->photon;
    flight->distance = R(0.0);
    flight->medium = flight->surface = -1;
    for (int c = 0; c < 3; c++) flight->left[c] = R(0.0);
    if (t->scene->surfaces.count > 0) memset(flight->touch, 0, sizeof flight->touch);
    return flight;
}

static void write_touch(RFlight *flight, const RMet *met) {
    flight->surface = met->surface;
    for (int a = 0; a < 3; a++) {
        flight->touch[R_TOUCH_P + a] = met->p[a];
        flight->touch[R_TOUCH_N + a] = met->n[a];
    }
    flight->touch[R_TOUCH_T] = met->t;
}

/* One flight; 0 when the photon leaves. */
static int advance(Tracer *t) {
    const RScene *scene = t->scene;
    RPhoton *photon = &t->photon;
    RVertex *vertex = &t->vertex;
    RMet met = {.surface = -1};
    Real distance;
    int touches = scene->surfaces.count > 0 && r_closest_surface(scene, photon->p, photon->d, R_HUGE, &met);
    RFlight *flight = write_flight(t, (int64_t)t->number + 1);
    int hit = fly(t, touches ? met.limit : R_HUGE, &distance);
    flight->distance = distance;
    flight->medium = hit;
    if (touches) write_touch(flight, &met);
    if (scene->channels > 1) reweigh(t, hit, distance);
    if (hit < 0 && !touches) return 0;
    if (hit >= 0) {
        Real p[3] = {photon->p[0] + distance * photon->d[0], photon->p[1] + distance * photon->d[1],
                     photon->p[2] + distance * photon->d[2]};
        r_vertex_in_medium(&scene->media[hit], p, photon->d, vertex);
        t->batch->tally.collisions++;
    } else {
        r_vertex_on_surface(scene->surfaces.albedo[met.surface], met.p, met.n, photon->d, vertex);
    }
    t->where = hit >= 0 ? hit : -1 - met.surface;
    r_wrap_position(&scene->period, vertex->p);
    for (int a = 0; a < 3; a++) photon->p[a] = vertex->p[a];
    for (int c = 0; c < 3; c++) photon->weight[c] *= vertex->albedo[c];
    photon->order++;
    for (int c = 0; c < 3; c++) flight->left[c] = photon->weight[c];
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
        ratio = ratio < (double)NPH_LIGHT_COPIES ? ratio : (double)NPH_LIGHT_COPIES;
        if (ratio > 1.0 && (t->batch->waiting == NPH_LIGHT_SPLITS || t->number >= MOST_FLIGHTS)) return 1; /* no room: goes on as it is */
        copies = (int)(ratio + (double)chance);
        change = (Real)ratio;
    }
    for (int c = 0; c < 3 && copies > 0; c++) photon->weight[c] /= change;
    return copies;
}

/* Copies of the photon that are still to go on from the vertex. */
static void put_aside(Tracer *t, int copies) {
    RWaiting *waiting = &t->batch->wait[t->batch->waiting++];
    waiting->photon = t->photon;
    waiting->vertex = t->vertex;
    waiting->where = t->where;
    waiting->copies = copies;
}

/* The last of what waits. */
static void take_up(Tracer *t) {
    RWaiting *waiting = &t->batch->wait[t->batch->waiting - 1];
    t->photon = waiting->photon;
    t->vertex = waiting->vertex;
    t->where = waiting->where;
    if (--waiting->copies == 0) t->batch->waiting--;
}

/* At a vertex, but for the new direction; 0 when the photon ends there. */
static int visit(Tracer *t) {
    RStream stream = stream_of(t, NPH_RNG_TRACE_ROULETTE);
    int copies = multiply(t, r_uniform(r_words(&stream, 0).w0));
    if (copies > 1) put_aside(t, copies - 1);
    return copies > 0;
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
static int turn(Tracer *t) {
    const NphLightAim *aim = &t->light->choice.aim;
    t->number++;
    RStream stream = stream_of(t, NPH_RNG_TRACE_TURN);
    NphWords words = r_words(&stream, 0);
    RTurned turned = !t->vertex.phase && aim->target[3] > 0.0 ? turn_to_target(t, &t->vertex, words)
                                                              : r_vertex_turn(t->scene, &t->vertex, words, R(0.0));
    for (int a = 0; a < 3; a++) t->photon.d[a] = turned.d[a];
    for (int c = 0; c < 3; c++) t->photon.weight[c] *= turned.weight;
    return turned.weight > R(0.0);
}

/* There may be a flight more, and the place that a photon begins at. */
static int has_room(const Tracer *t) { return t->batch->flights + 2 <= NPH_LIGHT_FLIGHTS; }

/* What is the same for all copies of a photon. */
static void name_photon(Tracer *t, int name) {
    enum { ROOM = NPH_LIGHT_BLOCK };
    const NphLightBatch *batch = t->batch;
    Real p[3];
    t->name = name;
    r_get3(batch->begin, ROOM, name, p);
    if (t->light->choice.split) t->reach = way_to_meter(t, p);
}

/* The first flight. */
static int set_out(Tracer *t) {
    enum { ROOM = NPH_LIGHT_BLOCK };
    const NphLightBatch *batch = t->batch;
    RPhoton *photon = &t->photon;
    t->number = 0;
    r_get3(batch->begin, ROOM, t->name, photon->p);
    r_get3(batch->begin + 3 * ROOM, ROOM, t->name, photon->d);
    r_get3(batch->power, ROOM, t->name, photon->weight);
    for (int c = 0; c < 3; c++) photon->share[c] = R(1.0);
    photon->unit = batch->unit[t->name];
    photon->hero = batch->hero[t->name];
    photon->source = batch->source[t->name];
    photon->order = 0;
    if (photon->source == t->scene->light_count && t->scene->sensor.kind != NPH_SENSOR_FLUX) write_flight(t, 0);
    return advance(t) && visit(t);
}

/* The photon, while it lives and there is room. */
static void go_on(Tracer *t, int alive) {
    while (alive && has_room(t)) alive = turn(t) && advance(t) && visit(t);
    if (alive) put_aside(t, 1);
}

void NPH_KERNEL(nph_light_trace)(NphLightBatch *batch) {
    Tracer t = {.light = batch->light, .scene = &batch->light->scene, .batch = batch, .number = (uint32_t)batch->place[1]};
    int next = (int)batch->place[0];
    batch->flights = 0;
    if (batch->waiting > 0) name_photon(&t, next - 1);
    while (has_room(&t) && (batch->waiting > 0 || next < batch->photons)) {
        if (batch->waiting > 0) {
            take_up(&t);
            go_on(&t, 1);
            continue;
        }
        name_photon(&t, next++);
        if (batch->unit[t.name] > R(0.0)) go_on(&t, set_out(&t));
    }
    batch->place[0] = next;
    batch->place[1] = (int64_t)t.number;
}
