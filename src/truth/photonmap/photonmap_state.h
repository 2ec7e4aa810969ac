/* SPDX-License-Identifier: Apache-2.0
 *
 * What the photon map's kernels see, in the number type of the build. Scene-local space throughout. */
#ifndef NPH_TRUTH_PHOTONMAP_STATE_H
#define NPH_TRUTH_PHOTONMAP_STATE_H

#include "transport/local_scene.h"
#include "truth/photonmap/kd_tree_lookup.h"
#include "truth/photonmap/photonmap.h"

/* What a photon scatters at one collision: the power [W] per channel after the albedo, the direction it came along. */
typedef struct RPhoton {
    Real d[3], power[3];
    Real extinction; /* of the densest channels of all media there, 1/m */
    int32_t medium;  /* position in the list of media */
    int32_t order;   /* number of its collisions, this one included */
} RPhoton;

typedef struct RPhotonScene {
    RScene local;
    double choose[NPH_MAX_LIGHTS + 1]; /* cumulated probability that a photon comes from a light */
    RDisc from[NPH_MAX_LIGHTS];        /* directions towards a constant light; of a point, directions to the media */
    int nearest;
    Real reach; /* largest radius of an estimate, m */
    Real step;  /* mean number of steps of the march per optical depth 1 of the majorants is 1 / step */
    int direct; /* by shadow rays; else by photons */
    int printed;
} RPhotonScene;

static inline RStream r_photon_stream(const RPhotonScene *scene, uint32_t stage, uint32_t photon, uint32_t sample,
                                      uint32_t vertex) {
    return r_stream(&scene->local, stage, photon, sample, vertex);
}

#endif
