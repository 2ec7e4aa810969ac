/* SPDX-License-Identifier: Apache-2.0
 *
 * What the path tracer's kernels see, in the number type of the build: the scene in scene-local space (metres, origin
 * near the media), and a batch of paths as structure of arrays. A batch is one tile of 16 x 16 pixels and one chunk of
 * 16 samples: 4096 paths, about 1 MiB in f32, for a core's L2 cache while the stages pass over it.
 *
 * Random words: Philox4x32-10 with key (seed, stage << 24 | frame) and counter (pixel, sample, vertex, draw); pixel =
 * y * width + x of the whole image, vertex = number of scatterings so far, draw = light << 27 | medium << 21 | block. */
#ifndef NPH_TRUTH_PATH_STATE_H
#define NPH_TRUTH_PATH_STATE_H

#include "core/philox.h"
#include "core/real.h"
#include "field/lookup.h"
#include "light/light_lookup.h"
#include "optics/phase_lookup.h"
#include "truth/path/path.h"

/* Functions whose loops must become vectors stay functions: inlined, gcc forgets that their parameters are restrict.
 * What they call for each lane must be inlined, however large. */
#if defined(__GNUC__)
#define R_OUTLINE static __attribute__((noinline, unused))
#define R_INLINE static inline __attribute__((always_inline))
#else
#define R_OUTLINE static
#define R_INLINE static inline
#endif

/* Stage numbers of the random streams. */
enum { NPH_RNG_GENERATE = 1, NPH_RNG_TRACK = 2, NPH_RNG_SCATTER = 3, NPH_RNG_LIGHT = 4, NPH_RNG_SHADOW = 5 };

enum { NPH_DRAW_MEDIUM_SHIFT = 21, NPH_DRAW_LIGHT_SHIFT = 27, NPH_MAX_BLOCKS = 1 << NPH_DRAW_MEDIUM_SHIFT };

/* Density rho (1 for box and layer); the extinction of channel c is rho * sigma[c]. */
typedef struct RMedium {
    int shape;
    uint32_t number;            /* in the scene: names the random stream */
    Real from_local[12];        /* medium space (lattice space for a grid) from scene-local space */
    Real lo[3], hi[3];          /* its box in medium space; -R_FAR, R_FAR where it has no end */
    Real sigma[3], sigma_max, ratio[3]; /* ratio = sigma / sigma_max */
    Real collide;               /* part of the extinction that makes collisions; the rest weighs flights */
    Real control;               /* mean of density over majorant: what weighing expects of a virtual collision */
    Real albedo[3];             /* over collide */
    RPhase phase;
    RGrid grid;
    const float *majorant;
    int32_t majorant_n[3];
} RMedium;

typedef struct RLight {
    int kind, hemisphere;
    int sampled;               /* a light sample at every vertex finds it; met by chance it is weighted against that */
    Real direction[3];
    Real value[3];             /* irradiance (delta sun), radiance (disc, constant), intensity (point) */
    RDisc disc;                /* sun that is not a delta: width > 0 */
    Real position[3];
    REnvironment map;
} RLight;

typedef struct RScene {
    int medium_count, light_count;
    int channels;              /* of transport: 1 when every medium is grey */
    int film_channels;         /* 1 when the lights are grey too */
    int weighed;               /* flights carry weights: collide < 1 in the one medium */
    int width, height;
    uint32_t seed, frame;
    Real roulette, shadow_roulette;
    int guide;                 /* sun towards which directions are sampled too, or -1 */
    Real guide_part, least_light, weight_unit; /* weight_unit: 1 over the weight of a camera ray */
    NphSensor sensor;          /* world space, f64 */
    double origin[3];          /* of scene-local space */
    double bounds_lo[3], bounds_hi[3]; /* of all media, scene-local, f64; infinite where a layer has no end */
    RMedium media[NPH_MAX_MEDIA];
    RLight lights[NPH_MAX_LIGHTS];
} RScene;

/* Paths in flight. weight is the throughput of each transport channel: product of f over the mean of the channels'
 * probabilities of the same choices (one-sample balance heuristic). share is the probability with which channel c, as
 * hero, would have made the choices, over that mean: 1 for grey media. */
typedef struct RPaths {
    Real *p[3], *d[3];
    Real *weight[3], *share[3];
    Real *pdf;                 /* of the direction at the last vertex; negative when a light sample could not find it */
    int32_t *id;               /* pixel in tile * 16 + sample in chunk */
    int32_t *hero;             /* channel whose extinction drives the tracking */
} RPaths;

static inline Real r_lane(const Real *arrays, int which, int i) { return arrays[which * NPH_PATH_BATCH + i]; }

/* Where the arrays of RPaths stand, in units of NPH_PATH_BATCH from p[0]; those of shadow rays likewise from ray[0]. */
enum { R_OF_P = 0, R_OF_D = 3, R_OF_WEIGHT = 6, R_OF_SHARE = 9, R_OF_PDF = 12 };
enum { R_OF_ARRIVING = 6, R_OF_CARRIED = 9, R_OF_PASSED = 10, R_OF_REACH = 11 };

struct NphPathBatch {
    const RScene *scene;
    RPaths paths[2];           /* paths[now] is read by track, escape, shadow, scatter; scatter fills the other one */
    int now, count;            /* paths in flight */
    int tile_x, tile_y, inside[4];
    uint32_t first_sample, vertex;
    Real *distance;            /* of the next collision; negative: none */
    int32_t *medium;           /* in which it happens */
    Real *survived, *walked;   /* where flights are weighed: weight of virtual collisions, majorant's depth of the flight */
    int32_t *queue, *escaped;  /* positions of the paths that collide, that leave */
    int queued, left;
    Real *ray[3], *towards[3]; /* rays from vertices to a light: [4096] each, as those below */
    Real *arriving[3];         /* radiance over density of the light sample */
    Real *carried, *passed, *reach; /* what arrives per radiance if nothing stops it; transmittance; how far the light is */
    int32_t *ray_id;
    void *flights;             /* RFlights (path_lanes.h) */
    Real *samples;             /* [NPH_SAMPLE_FIELDS][4096] */
    Real *start;               /* [4096], by id: distance from the camera to where the path began */
    NphPathTally tally;
};

static inline uint32_t r_pixel(const NphPathBatch *batch, int32_t id) {
    uint32_t x = (uint32_t)(batch->tile_x + ((id >> 4) & 15)), y = (uint32_t)(batch->tile_y + (id >> 8));
    return y * (uint32_t)batch->scene->width + x;
}

static inline uint32_t r_sample(const NphPathBatch *batch, int32_t id) {
    return batch->first_sample + (uint32_t)(id & 15);
}

/* Where a random stream stands: all of key and counter but the block. */
typedef struct RStream {
    uint32_t key[2], pixel, sample, vertex, draw;
} RStream;

static inline RStream r_stream(const RScene *scene, uint32_t stage, uint32_t pixel, uint32_t sample, uint32_t vertex) {
    RStream stream = {{scene->seed, stage << 24 | (scene->frame & 0xffffffu)}, pixel, sample, vertex, 0};
    return stream;
}

static inline NphWords r_words(const RStream *stream, uint32_t block) {
    return nph_philox(stream->key[0], stream->key[1], stream->pixel, stream->sample, stream->vertex,
                      stream->draw | block);
}

/* What a loop over lanes holds in registers to draw random words; medium: a number that the loop writes. */
typedef struct RTile {
    int32_t x, y, width;
    uint32_t first_sample;
    int32_t count, medium;
    RStream stream; /* but pixel and sample */
} RTile;

static inline RTile r_tile(const NphPathBatch *batch, const RStream *stream, int count, int medium) {
    RTile tile = {batch->tile_x, batch->tile_y, batch->scene->width, batch->first_sample, count, medium, *stream};
    return tile;
}

static inline NphWords r_tile_words(const RTile *tile, int32_t id, uint32_t block) {
    uint32_t pixel = (uint32_t)(tile->y + (id >> 8)) * (uint32_t)tile->width + (uint32_t)(tile->x + ((id >> 4) & 15));
    return nph_philox(tile->stream.key[0], tile->stream.key[1], pixel, tile->first_sample + (uint32_t)(id & 15),
                      tile->stream.vertex, tile->stream.draw | block);
}

static inline Real r_luminance(const Real c[3]) {
    return R(0.2126) * c[0] + R(0.7152) * c[1] + R(0.0722) * c[2];
}

#endif
