/* SPDX-License-Identifier: Apache-2.0
 *
 * truth/photonmap: volumetric photon mapping [Jensen98]. One sample of the film is one picture from one photon map:
 *   1 trace     photons from the lights through all media; what they scatter is counted, then stored
 *   2 tree      the stored photons become a left-balanced kd-tree (kd_tree.h)
 *   3 march     camera rays: direct light by shadow rays, multiply scattered light by the density of photons
 *   4 accumulate into the film's tree
 * Pixels of one sample share a map, so samples are independent and pixels are not. */
#ifndef NPH_TRUTH_PHOTONMAP_PHOTONMAP_H
#define NPH_TRUTH_PHOTONMAP_PHOTONMAP_H

#include "transport/choice.h"
#include "truth/photonmap/kd_tree.h"

extern const NphMethod nph_photonmap;

/* Photons of one block; and what the pilot traces to learn how many emitted photons fill a map. */
enum { NPH_PHOTONMAP_BLOCK = 256, NPH_PHOTONMAP_PILOT = 16384, NPH_PHOTONMAP_PILOT_SAMPLE = -1 };
enum { NPH_PHOTONMAP_NEAREST_MAX = 1024, NPH_PHOTONMAP_EMITTED_PER_STORED = 4 };

typedef enum NphPhotonmapStage {
    NPH_PHOTONMAP_TRACE,
    NPH_PHOTONMAP_TREE,
    NPH_PHOTONMAP_MARCH,
    NPH_PHOTONMAP_ACCUMULATE,
    NPH_PHOTONMAP_STAGES
} NphPhotonmapStage;

enum {
    NPH_PHOTONMAP_KNOB_PHOTONS,
    NPH_PHOTONMAP_KNOB_EMITTED,
    NPH_PHOTONMAP_KNOB_NEAREST,
    NPH_PHOTONMAP_KNOB_RADIUS,
    NPH_PHOTONMAP_KNOB_STEP,
    NPH_PHOTONMAP_KNOB_DIRECT,
    NPH_PHOTONMAP_KNOB_PRINTED,
    NPH_PHOTONMAP_KNOBS
};

/* What plan, run and replay agree on. */
typedef struct NphPhotonmapChoice {
    NphTransportChoice transport;
    int traced;      /* photons can add something */
    int64_t room;    /* photons a map holds */
    int64_t emitted; /* photons of a map; 0: the pilot decides */
    int64_t most;    /* that it may decide on */
} NphPhotonmapChoice;

/* NPH_BAD_SCENE when the scene holds what the method cannot do. */
NphStatus nph_photonmap_choose(const NphJob *job, NphPhotonmapChoice *choice);
NphStatus nph_photonmap_plan(const NphJob *job, NphPlan *plan);

/* One photon map. Arrays of `room` elements; those of the tree are its own. */
typedef struct NphPhotonMap {
    int64_t room, emitted;
    int64_t scattered; /* what the photons scatter and could be stored: thinned evenly to `room` when it is more */
    int64_t thin;      /* where the thinning begins, in [0, scattered) */
    double power;      /* of one stored photon per unit of its weight: 1 / emitted, over the part that is kept */
    uint32_t sample;   /* of the film, names the random streams */
    void *photons;     /* RPhoton */
    NphKdTree tree;
} NphPhotonMap;

/* One tile of a sample: pixels [inside) of the tile at origin; samples is the film's [field][pixel][16], of which number
 * `slot` is written. */
typedef struct NphPhotonmapTile {
    int origin[2], inside[4];
    int slot;
    void *samples;
} NphPhotonmapTile;

/* The kernels of one precision. Memory is the caller's. */
typedef struct NphPhotonmapKernels {
    size_t (*scene_bytes)(void);
    size_t (*photon_bytes)(void);
    void (*prepare)(const NphJob *job, const NphPhotonmapChoice *choice, void *scene);
    /* What photons [first, end) scatter; then the same photons once more, to store what is kept of it, the first being
     * number `ordinal` of the map. */
    int64_t (*count)(const void *scene, uint32_t sample, const int64_t range[2], NphTally *tally);
    void (*store)(const void *scene, const NphPhotonMap *map, const int64_t range[2], int64_t ordinal);
    int64_t (*thin)(const void *scene, uint32_t sample, int64_t scattered);
    void (*march)(const void *scene, const NphPhotonMap *map, const NphPhotonmapTile *tile, NphTally *tally);
    void (*replay)(const void *scene, const NphPhotonMap *map, const int pixel[2], NphLineFn line, void *user,
                   double fields[NPH_SAMPLE_FIELDS]);
} NphPhotonmapKernels;
void nph_photonmap_kernels(int precision, NphPhotonmapKernels *kernels);

/* photonmap_map.c: a map's memory, its making for one sample on the pool, and the pilot. */
typedef struct NphPhotonmapMaker {
    NphContext *context;
    NphPhotonmapKernels kernels;
    const void *scene;
    int64_t *counts; /* [blocks + 1] */
    int64_t blocks;
    NphPhotonMap map;
    NphTally *tallies;      /* per worker */
    NphStageCounts *stages; /* per worker */
    double *seconds;        /* per worker, of the tree */
} NphPhotonmapMaker;
NphStatus nph_photonmap_maker_open(const NphJob *job, const NphPhotonmapChoice *choice, const void *scene,
                                   NphPhotonmapMaker *maker);
void nph_photonmap_maker_close(NphPhotonmapMaker *maker);
NphStatus nph_photonmap_make(NphPhotonmapMaker *maker, uint32_t sample);
/* Bytes that a maker and its map take; emitted as it may become. */
uint64_t nph_photonmap_map_bytes(int precision, const NphPhotonmapChoice *choice, uint64_t threads);

#endif
