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

/* What a worker traces: a block of photons of one sample. Rows of an array lie a room apart. */
struct NphLightBatch {
    const RLightScene *light;
    uint32_t sample, first; /* number of the block's first photon */
    int photons;
    Real *begin, *power, *unit; /* of a photon that sets out: [6], [3]; unit 0: it carries nothing */
    int32_t *source, *hero;     /* light that it comes from, or their number: a medium's own */
    int64_t place[2];           /* photons that have set out; flights so far of the last of these, but one */
    int waiting;                /* copies of that photon still to fly, the next one last */
    Real *wait;                 /* position, direction of arrival, normal, weight, share: [15] */
    int32_t *wait_at;           /* R_WAIT_... */
    int flights, splats;
    int64_t *flight;            /* photon of the block << 32 | number of its flight + 1; or 0: the place where it begins */
    Real *ray, *weight, *share, *distance, *touch, *left; /* [6], [3], [3], 1, [7], [3] */
    int32_t *flight_hero, *order, *medium, *surface;
    int64_t *splat;
    double *at;                 /* [2]: on the sensor, -1 to 1 */
    Real *add, *from;           /* [3], [3] */
    int32_t *splat_order;
    NphTally tally;
};

enum { R_WAIT_P = 0, R_WAIT_D = 3, R_WAIT_N = 6, R_WAIT_WEIGHT = 9, R_WAIT_SHARE = 12, R_WAIT_REALS = 15 };
enum { R_WAIT_WHERE, R_WAIT_HERO, R_WAIT_ORDER, R_WAIT_COPIES, R_WAIT_INTS }; /* where: medium, or -1 - surface */
enum { R_TOUCH_P = 0, R_TOUCH_N = 3, R_TOUCH_T = 6, R_TOUCH_REALS = 7 };

static inline void r_put3(Real *rows, int room, int i, const Real value[3]) {
    for (int k = 0; k < 3; k++) rows[k * room + i] = value[k];
}

static inline void r_get3(const Real *rows, int room, int i, Real value[3]) {
    for (int k = 0; k < 3; k++) value[k] = rows[k * room + i];
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
