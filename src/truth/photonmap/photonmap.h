/* SPDX-License-Identifier: Apache-2.0
 *
 * truth/photonmap: volumetric photon mapping [Jensen98]. One sample of the film is one picture from one photon map:
 *   1 pilot      once: what photons of other random words scatter is counted
 *   2 fill       how many photons so fill a map
 *   3 count      photons from the lights through all media: what those of each block scatter
 *   4 scan       numbers for it, in order of blocks
 *   5 trace      the same photons once more: what they scatter is stored
 *   6 tree       the stored photons become a left-balanced kd-tree (kd_tree.h)
 *   7 march      camera rays: direct light by shadow rays, multiply scattered light by the density of photons
 *   8 accumulate into the film's tree, 16 samples of a tile together
 * Pixels of one sample share a map, so samples are independent and pixels are not. A launch is of the whole map or picture; its
 * blocks go to the pool. */
#ifndef NPH_TRUTH_PHOTONMAP_PHOTONMAP_H
#define NPH_TRUTH_PHOTONMAP_PHOTONMAP_H

#include "transport/choice.h"
#include "truth/photonmap/kd_tree.h"

extern const NphMethod nph_photonmap;

/* Photons of one block; and what the pilot traces to learn how many emitted photons fill a map. */
enum { NPH_PHOTONMAP_BLOCK = 256, NPH_PHOTONMAP_PILOT_PHOTONS = 16384, NPH_PHOTONMAP_PILOT_SAMPLE = -1 };
enum { NPH_PHOTONMAP_NEAREST_MAX = 1024, NPH_PHOTONMAP_EMITTED_PER_STORED = 4 };

typedef enum NphPhotonmapStage {
    NPH_PHOTONMAP_PILOT,
    NPH_PHOTONMAP_FILL,
    NPH_PHOTONMAP_COUNT,
    NPH_PHOTONMAP_SCAN,
    NPH_PHOTONMAP_TRACE,
    NPH_PHOTONMAP_TREE,
    NPH_PHOTONMAP_MARCH,
    NPH_PHOTONMAP_ACCUMULATE,
    NPH_PHOTONMAP_STAGES
} NphPhotonmapStage;

/* Of blocks of photons; of the photons of a map, by position in it, and of its tree; of pictures. */
typedef enum NphPhotonmapBuffer {
    NPH_PHOTONMAP_EMITTED, NPH_PHOTONMAP_COUNTS, NPH_PHOTONMAP_FIRST,
    NPH_PHOTONMAP_ID, NPH_PHOTONMAP_PLACE, NPH_PHOTONMAP_DIRECTION, NPH_PHOTONMAP_POWER, NPH_PHOTONMAP_EXTINCTION,
    NPH_PHOTONMAP_MEDIUM, NPH_PHOTONMAP_ORDER,
    NPH_PHOTONMAP_NODE, NPH_PHOTONMAP_NODE_PHOTON, NPH_PHOTONMAP_NODE_AXIS,
    NPH_PHOTONMAP_IMAGE, NPH_PHOTONMAP_SAMPLE, NPH_PHOTONMAP_FILM_NODE, NPH_PHOTONMAP_BUFFERS
} NphPhotonmapBuffer;
typedef enum NphPhotonmapArgument { NPH_PHOTONMAP_ARG_SAMPLE, NPH_PHOTONMAP_ARG_TILE, NPH_PHOTONMAP_ARGUMENTS } NphPhotonmapArgument;

/* A photon's name: its number times this, and the number of its collision. Exact as a double. */
enum { NPH_PHOTONMAP_NAMES = 1 << 20 };

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
    int64_t *names;    /* of the photons; NULL: nobody looks. -1: nothing is stored there */
    NphKdTree tree;
} NphPhotonMap;

/* Pixels [inside) of a sample's image: [field][pixel of the crop]. */
typedef struct NphPhotonmapTile {
    int inside[4], crop[4];
    void *image;
} NphPhotonmapTile;

/* The kernels of one precision. Memory is the caller's. */
typedef struct NphPhotonmapKernels {
    size_t (*scene_bytes)(void);
    size_t (*photon_bytes)(void);
    void (*prepare)(const NphJob *job, const NphPhotonmapChoice *choice, void *scene);
    /* What photons [first, end) scatter; then the same photons once more, to store what is kept of it, whose numbers in the
     * map are [first, end) of `numbers`: what is beyond them is left out. */
    int64_t (*count)(const void *scene, uint32_t sample, const int64_t range[2], NphTally *tally);
    void (*store)(const void *scene, const NphPhotonMap *map, const int64_t range[2], const int64_t numbers[2]);
    int64_t (*thin)(const void *scene, uint32_t sample, int64_t scattered);
    void (*march)(const void *scene, const NphPhotonMap *map, const NphPhotonmapTile *tile, NphTally *tally);
    void (*replay)(const void *scene, const NphPhotonMap *map, const int pixel[2], NphLineFn line, void *user,
                   double fields[NPH_SAMPLE_FIELDS]);
    /* photonmap_alone_kernel.c: no photons; fields of photons and nodes to rows that lie map->room apart, and back. */
    void (*clear)(NphPhotonMap *map);
    void (*show)(const NphPhotonMap *map, int buffer, void *column);
    void (*take)(NphPhotonMap *map, int buffer, const void *column);
    void (*facts)(const void *scene, int64_t room, NphFactFn fact, void *user);
} NphPhotonmapKernels;
void nph_photonmap_kernels(NphIsa isa, int precision, NphPhotonmapKernels *kernels);

/* photonmap_map.c: a map's memory, and its making on the pool. choice and scene are the caller's, and must outlive it. */
typedef struct NphPhotonmapMaker {
    NphContext *context;
    NphPhotonmapKernels kernels;
    const NphPhotonmapChoice *choice;
    const void *scene;
    int64_t *counts; /* [blocks], then of the same blocks: */
    int64_t *first;  /* [blocks + 1] */
    int64_t blocks, traced; /* photons that are traced now */
    NphPhotonMap map;
    NphTally *tallies;      /* per worker */
    NphStageCounts *stages; /* per worker */
    double *seconds;        /* per worker, of the tree */
} NphPhotonmapMaker;
NphStatus nph_photonmap_maker_open(const NphJob *job, const NphPhotonmapChoice *choice, const void *scene,
                                   NphPhotonmapMaker *maker);
void nph_photonmap_maker_close(NphPhotonmapMaker *maker);
int64_t nph_photonmap_blocks(int64_t photons);
int64_t nph_photonmap_pilot_photons(const NphPhotonmapChoice *choice); /* 0: how many are emitted is known without */
int64_t nph_photonmap_most(const NphPhotonmapChoice *choice);          /* photons that are emitted at most */
/* One stage, NPH_PHOTONMAP_PILOT to NPH_PHOTONMAP_TREE, of map.sample; the pilot's sample is its own. */
NphStatus nph_photonmap_step(NphPhotonmapMaker *maker, NphPhotonmapStage stage);
/* All that come before the first map; then those of a map. */
NphStatus nph_photonmap_prepare_maps(NphPhotonmapMaker *maker);
NphStatus nph_photonmap_make(NphPhotonmapMaker *maker, uint32_t sample);
/* Bytes that a maker and its map take; emitted as it may become. */
uint64_t nph_photonmap_map_bytes(int precision, const NphPhotonmapChoice *choice, uint64_t threads);

/* Values of photons and nodes that stand in columns and not yet in the map: none; a stage's inputs, of which there are no
 * others; what a watcher of a run has written. */
typedef enum NphPhotonmapPlacing { NPH_PHOTONMAP_NONE, NPH_PHOTONMAP_ALONE, NPH_PHOTONMAP_HELD } NphPhotonmapPlacing;

/* photonmap.c: a run. */
typedef struct NphPhotonmapState {
    NphJob job;
    NphPhotonmapChoice choice;
    NphPhotonmapMaker maker;
    int made; /* the maker is open */
    void *scene;
    void *images;  /* [sample of the chunk][field][pixel of the crop] */
    void *samples; /* a tile of them: [field][pixel][sample] */
    size_t image_bytes;
    void *columns; /* of photons and nodes; NULL: nobody looks */
    NphPhotonmapPlacing placing;
    double *film_scratch;
    NphFilm *film;
    int64_t chunk;
    int slot; /* of the image that is made */
    double started;
} NphPhotonmapState;
extern const NphStage nph_photonmap_stages[NPH_PHOTONMAP_STAGES];
NphStatus nph_photonmap_launch(NphPhotonmapState *state, const NphLaunch *launch);

/* photonmap_alone.c: what others see of it (columns are for a tap, and for stages alone), and NphMethod's calls of these names. */
NphStatus nph_photonmap_open_columns(NphPhotonmapState *state);
uint64_t nph_photonmap_column_bytes(int precision, int64_t room);
extern const NphBuffer nph_photonmap_buffers[NPH_PHOTONMAP_BUFFERS];
NphStatus nph_photonmap_begin_launch(void *state, int worker, NphFilm *film, const NphLaunch *launch);
NphStatus nph_photonmap_extend(void *state, int worker, int buffer, const int64_t *shape);
int nph_photonmap_view(void *state, int worker, int buffer, NphView *view);
void nph_photonmap_hold(void *state, int worker);
NphStatus nph_photonmap_check(void *state, int worker, const NphLaunch *launch);
NphStatus nph_photonmap_launch_alone(void *state, int worker, const NphLaunch *launch);

#endif
