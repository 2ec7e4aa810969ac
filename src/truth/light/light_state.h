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
    int own;        /* light of a medium: its way before the first scattering is not seen by the sensor itself */
} RPhoton;

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
