/* SPDX-License-Identifier: Apache-2.0
 *
 * What the kernels of light tracing see: the scene, a photon, and where its random words come from: counter (photon,
 * sample, number, draw), number rising with every flight of a photon and of the parts it was split into. */
#ifndef NPH_TRUTH_LIGHT_STATE_H
#define NPH_TRUTH_LIGHT_STATE_H

#include "transport/emission_source_lookup.h"
#include "transport/vertex_lookup.h"
#include "truth/light/light_tracing.h"

typedef struct RLightScene {
    RScene scene;
    NphLightChoice choice;
    NphEmissionSources sources;
    Real roulette;
} RLightScene;

/* weight: power [W] per channel over the mean probability of the channels' choices; share: as in path. */
typedef struct RPhoton {
    Real p[3], d[3];
    Real weight[3], share[3];
    Real unit;      /* what roulette measures the weight by: that when emitted, at most that of most photons */
    int hero;
    uint32_t order; /* scatterings and reflections so far */
    int source;     /* the light that it comes from, or their number: a medium's own */
} RPhoton;

/* A flight: the photon as it sets out, where it ends, and with what it goes on from there. */
typedef struct RFlight {
    int64_t name;            /* photon of the block << 32 | number of its flight + 1; or 0: the place where it begins */
    RPhoton photon;
    Real distance, touch[7]; /* touch: where light leaves the surface, its normal, how far it is */
    Real left[3];
    int32_t medium, surface; /* that it collides in; that it ends at if it does not; -1: none */
} RFlight;

/* What a flight brings to the sensor. */
typedef struct RSplat {
    int64_t flight;
    double at[2];        /* on the sensor, -1 to 1 */
    Real add[3], from[3];
    int32_t order;
} RSplat;

/* Copies of a photon that still wait at a vertex. */
typedef struct RWaiting {
    RPhoton photon;
    RVertex vertex;
    int32_t where, copies; /* where: medium of the vertex, or -1 - surface */
} RWaiting;

/* What a worker traces: a block of photons of one sample. */
struct NphLightBatch {
    const RLightScene *light;
    uint32_t sample, first; /* number of the block's first photon */
    int photons;
    Real *begin, *power, *unit; /* of a photon that sets out: [6], [3]; unit 0: it carries nothing */
    int32_t *source, *hero;
    int64_t place[2];           /* photons that have set out; flights so far of the last of these, but one */
    int waiting, flights, splats;
    RWaiting *wait;             /* copies of that photon, the next one last */
    RFlight *flight;
    RSplat *splat;
    void *columns;              /* where others look: the same, as structures of arrays */
    NphLightPlacing placing;    /* columns hold values which the lists do not have yet */
    NphTally tally;
};

enum { R_TOUCH_P = 0, R_TOUCH_N = 3, R_TOUCH_T = 6 };

static inline void r_put3(Real *rows, int room, int i, const Real value[3]) {
    for (int k = 0; k < 3; k++) rows[k * room + i] = value[k];
}

static inline void r_get3(const Real *rows, int room, int i, Real value[3]) {
    for (int k = 0; k < 3; k++) value[k] = rows[k * room + i];
}

static inline void r_vertex_of(const RScene *scene, int32_t where, const Real p[3], const Real n[3], const Real d[3], RVertex *vertex) {
    if (where >= 0) r_vertex_in_medium(&scene->media[where], p, d, vertex);
    else r_vertex_on_surface(scene->surfaces.albedo[-1 - where], p, n, d, vertex);
}

static inline RStream r_flight_stream(const NphLightBatch *batch, uint32_t stage, uint32_t photon, uint32_t number) {
    return r_stream(&batch->light->scene, stage, batch->first + photon, batch->sample, number);
}

/* What the channels would have made of the flight up to a distance, the hero being 1; hit: medium that it collides in. */
static inline void r_flight_channels(const RScene *scene, const RStream *stream, const RPhoton *photon, int hit, Real distance,
                                     Real factor[3]) {
    for (int c = 0; c < 3; c++) factor[c] = R(1.0);
    for (int m = 0; m < scene->medium_count; m++) {
        const RMedium *medium = &scene->media[m];
        if (medium->sigma[0] == medium->sigma[1] && medium->sigma[0] == medium->sigma[2]) continue;
        REvents events = r_events(stream, 0, medium->number);
        r_flight_factors(medium, photon->p, photon->d, distance, photon->hero, &events, factor);
    }
    for (int c = 0; c < 3 && hit >= 0; c++) factor[c] *= scene->media[hit].sigma[c] / scene->media[hit].sigma[photon->hero];
}

/* One-sample balance heuristic over the channels, as in path. */
static inline Real r_flight_mean(const RPhoton *photon, const Real factor[3]) {
    return (photon->share[0] * factor[0] + photon->share[1] * factor[1] + photon->share[2] * factor[2]) * R(1.0 / 3.0);
}

static inline Real r_largest(const RScene *scene, const Real weight[3]) {
    Real largest = weight[0];
    for (int c = 1; c < scene->film_channels; c++) largest = r_max(largest, weight[c]);
    return largest;
}

/* Multiplies T by the transmittance from p along d up to limit; media, not surfaces. */
static inline void r_pass(const RScene *scene, const RStream *stream, const Real p[3], const Real d[3], Real limit,
                          Real T[3], NphTally *tally) {
    int light = (int)(stream->draw >> NPH_DRAW_LIGHT_SHIFT);
    for (int m = 0; m < scene->medium_count; m++) {
        REvents events = r_events(stream, light, scene->media[m].number);
        r_transmittance(&scene->media[m], p, d, limit, scene, &events, T, tally);
        if (scene->channels == 1) T[1] = T[2] = T[0];
        if (!(T[0] + T[1] + T[2] > R(0.0))) return;
    }
}

#endif
