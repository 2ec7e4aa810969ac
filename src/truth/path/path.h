/* SPDX-License-Identifier: Apache-2.0
 *
 * truth/path: the unbiased volumetric path tracer. Before all batches, for every medium that is a grid:
 *   0 majorant   bounds of its density
 * (made when the grid is read, and once more where somebody looks on). Its stages over a batch:
 *   1 generate   camera rays
 *     gather     light samples of a sensor that gathers
 *   2 track      to the nearest surface; one whole free flight through every medium; the nearest collision wins
 *     emission   what media add by their own light along it
 *     near       what point lights in media send to one place of it
 *     reweigh    what the other channels would have made of it
 *   3 escape     paths that leave meet the lights at infinity
 *     around     what point lights send to the vertices through places around them
 *   4 shadow     at a vertex: a light sample per light, what surfaces hide, ratio tracking towards it
 *   5 scatter    albedo, roulette, new direction; the survivors move up
 *   6 fold       of split camera rays: what passed and what collided
 *     accumulate into the film's tree
 * path_replay_kernel.c tells the same story for one path, one event after another. */
#ifndef NPH_TRUTH_PATH_PATH_H
#define NPH_TRUTH_PATH_PATH_H

#include "transport/choice.h"

extern const NphMethod nph_path;

enum { NPH_PATH_BATCH = NPH_TILE_PIXELS * NPH_CHUNK };

typedef enum NphPathStage {
    NPH_PATH_MAJORANT, NPH_PATH_GENERATE, NPH_PATH_GATHER, NPH_PATH_TRACK, NPH_PATH_EMISSION, NPH_PATH_NEAR, NPH_PATH_REWEIGH,
    NPH_PATH_ESCAPE, NPH_PATH_AROUND, NPH_PATH_SHADOW, NPH_PATH_SCATTER, NPH_PATH_FOLD, NPH_PATH_ACCUMULATE, NPH_PATH_STAGES
} NphPathStage;

/* In the order in which inputs must be placed: what says how many paths there are before what is as long. */
typedef enum NphPathBuffer {
    NPH_PATH_DENSITY, NPH_PATH_BOUND, NPH_PATH_ID, NPH_PATH_HERO, NPH_PATH_RAY, NPH_PATH_WEIGHT, NPH_PATH_SHARE, NPH_PATH_PDF, NPH_PATH_ORIGIN,
    NPH_PATH_DISTANCE, NPH_PATH_MEDIUM, NPH_PATH_SURFACE, NPH_PATH_TOUCH, NPH_PATH_FLOWN, NPH_PATH_COLLIDING, NPH_PATH_TOUCHING, NPH_PATH_LEAVING,
    NPH_PATH_START, NPH_PATH_COLLIDED, NPH_PATH_ASIDE, NPH_PATH_SAMPLE, NPH_PATH_NODE, NPH_PATH_BUFFERS
} NphPathBuffer;

enum { NPH_PATH_TILE, NPH_PATH_CHUNK, NPH_PATH_VERTEX, NPH_PATH_LIGHT, NPH_PATH_OF_MEDIUM, NPH_PATH_ARGUMENTS };

enum { NPH_PATH_KNOB_ROULETTE, NPH_PATH_KNOB_SHADOW_ROULETTE, NPH_PATH_KNOB_WEIGHED, NPH_PATH_KNOB_TOWARDS_SUN, NPH_PATH_KNOB_LEAST_LIGHT,
       NPH_PATH_KNOB_EMISSION_EVENTS, NPH_PATH_KNOB_NEAR_LIGHT, NPH_PATH_KNOB_FORCED,
       NPH_PATH_KNOBS };

typedef struct NphPathBatch NphPathBatch;

/* What the plan decided: the one place where plan, run and replay learn it. */
typedef struct NphPathChoice {
    NphTransportChoice transport;
    double weighed;      /* part of the absorption that weighs flights instead of collisions */
    int forced;          /* camera rays are made to collide */
    int guide;           /* sun towards which directions are sampled too, or -1 */
    double guide_part;   /* with at most this probability */
    int near;            /* some near_m is above 0 */
    double near_m[NPH_MAX_LIGHTS]; /* of point lights in media: how far flights look for them; else 0 */
    double least_light;  /* light samples below this part of isotropic scattering are rouletted; 0: none */
} NphPathChoice;
void nph_path_choose(const NphJob *job, NphPathChoice *choice);

/* The kernels of one precision and vector level. Memory is the caller's: scene_bytes and batch_bytes, 64-byte aligned. */
typedef struct NphPathKernels {
    size_t (*scene_bytes)(int groups); /* of wavelengths */
    void (*prepare)(const NphJob *job, const NphPathChoice *choice, void *scene);
    size_t (*batch_bytes)(void);
    void (*layout)(void *memory, const void *scene, NphPathBatch **batch);
    void (*begin)(NphPathBatch *batch, const int origin[2], const int inside[4], int64_t chunk);
    int (*count)(const NphPathBatch *batch);
    const void *(*samples)(const NphPathBatch *batch);
    const NphTally *(*tally)(const NphPathBatch *batch);
    void (*set_vertex)(NphPathBatch *batch, int64_t vertex);
    NphStatus (*extend)(NphPathBatch *batch, int buffer, int64_t items); /* NPH_BAD_INPUT: more than a batch holds */
    int (*view)(NphPathBatch *batch, int buffer, NphView *view);
    void (*walk_bounds)(void *scene, int groups, int medium, const float *cells); /* instead of those of its grid */
    void (*facts)(const void *scene, int groups, NphFactFn fact, void *user);
    void (*generate)(NphPathBatch *batch);
    void (*track)(NphPathBatch *batch);
    void (*emission)(NphPathBatch *batch);
    void (*near_light)(NphPathBatch *batch, int light);   /* along the flights */
    void (*around_light)(NphPathBatch *batch, int light); /* from the vertices */
    void (*reweigh)(NphPathBatch *batch); /* what several channels make of their flights: weights from here on */
    void (*escape)(NphPathBatch *batch);
    void (*shadow)(NphPathBatch *batch, int light, int at_sensor);
    void (*scatter)(NphPathBatch *batch);
    void (*fold)(NphPathBatch *batch); /* of forced collisions: what passed by and what collided become one sample */
    void (*replay)(const void *scene, const int pixel[2], int64_t sample, NphLineFn line, void *user,
                   double fields[NPH_SAMPLE_FIELDS]);
} NphPathKernels;

/* path_majorant.c: what path.majorant reads and writes, of one medium at a time. */
typedef struct NphPathField {
    int32_t n[3];
    float *density;       /* [n[2]][n[1]][n[0]]: the lattice's samples, padding included */
    NphMajorant majorant; /* cells NULL: not made yet */
} NphPathField;

/* Room for the samples of a medium, a grid that the choice uses, else NPH_BAD_INPUT; what the field held before is freed. */
NphStatus nph_path_field_begin(const NphJob *job, const NphPathChoice *choice, int64_t medium, NphPathField *field);
NphStatus nph_path_field_check(const NphJob *job, const NphPathField *field); /* NPH_BAD_INPUT: no density, no bound */
NphStatus nph_path_field_bound(const NphJob *job, NphPathField *field); /* NPH_NO_MEMORY, or it cannot fail */
int nph_path_field_view(const NphPathField *field, int buffer, NphView *view);
void nph_path_field_free(NphContext *context, NphPathField *field);

/* path_kernels.c */
void nph_path_kernels(NphIsa isa, int precision, NphPathKernels *kernels);

#endif
