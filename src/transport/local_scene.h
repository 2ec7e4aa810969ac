/* SPDX-License-Identifier: Apache-2.0
 *
 * A scene as kernels see it, in the number type of the build and in scene-local space: metres, origin near the media,
 * so that f32 positions keep their precision wherever in the world the scene lies. And the streams of random words.
 *
 * Random words: Philox4x32-10 with key (seed, stage << 24 | frame) and counter (pixel, sample, vertex, draw); pixel =
 * y * width + x of the whole image, vertex = number of scatterings so far, draw = light << 27 | medium << 21 | block. */
#ifndef NPH_TRANSPORT_LOCAL_SCENE_H
#define NPH_TRANSPORT_LOCAL_SCENE_H

#include "core/philox.h"
#include "core/real.h"
#include "field/lookup.h"
#include "geometry/lambert_lookup.h"
#include "geometry/surface_lookup.h"
#include "light/light_lookup.h"
#include "optics/phase_lookup.h"
#include "scene/model.h"

/* Loops over lanes run to a whole number of the widest vectors: the arrays are long enough, and lanes behind the last one
 * hold what was there. */
static inline int r_whole_vectors(int count) { return (count + 15) & ~15; }

/* Stage numbers of the random streams. */
enum { NPH_RNG_GENERATE = 1, NPH_RNG_TRACK = 2, NPH_RNG_SCATTER = 3, NPH_RNG_LIGHT = 4, NPH_RNG_SHADOW = 5,
       NPH_RNG_EMISSION = 10, NPH_RNG_NEAR = 11, NPH_RNG_NEAR_SHADOW = 12, NPH_RNG_AROUND_TO = 13,
       NPH_RNG_AROUND_FROM = 14, NPH_RNG_PILOT = 15 };

/* A flight that passes so many periods of a medium without an end is given up, and counted. */
enum { NPH_MAX_IMAGES = 1 << 20 };

/* Those of light tracing. */
enum {
    NPH_RNG_TRACE_EMIT = 16, NPH_RNG_TRACE_FLY = 17, NPH_RNG_TRACE_TURN = 18, NPH_RNG_TRACE_ROULETTE = 19,
    NPH_RNG_TRACE_CONNECT = 20, NPH_RNG_TRACE_PASS = 21, NPH_RNG_TRACE_SEE = 22, NPH_RNG_TRACE_LOOK = 23,
    NPH_RNG_TRACE_SEEN = 24
};

/* Those of photon mapping. */
enum {
    NPH_RNG_PHOTON_EMIT = 32, NPH_RNG_PHOTON_TRACK = 33, NPH_RNG_PHOTON_SCATTER = 34, NPH_RNG_PHOTON_THIN = 35,
    NPH_RNG_MARCH_STEP = 36, NPH_RNG_MARCH_LIGHT = 37, NPH_RNG_MARCH_SHADOW = 38
};

enum { NPH_DRAW_MEDIUM_SHIFT = 21, NPH_DRAW_LIGHT_SHIFT = 27, NPH_MAX_BLOCKS = 1 << NPH_DRAW_MEDIUM_SHIFT };

/* Sides that repeat, scene-local: along an axis with size > 0 a medium, cut to [lo, lo + size], stands once a period. on: any. */
typedef struct RPeriod {
    int on;
    Real lo[2], size[2], inverse[2]; /* inverse = 1 / size, 0 along axes that do not repeat */
} RPeriod;

/* Density rho (1 for box and layer); the extinction of channel c is rho * sigma[c]. */
typedef struct RMedium {
    int shape;
    uint32_t number;            /* in the scene: names the random stream */
    Real from_local[12];        /* medium space (lattice space for a grid) from scene-local space */
    Real lo[3], hi[3];          /* its box in medium space; -R_FAR, R_FAR where it has no end */
    RPeriod period;             /* off for layers, which look the same everywhere */
    Real reach_lo[3], reach_hi[3]; /* where it is denser than 0, scene-local; without end along axes that repeat */
    Real sigma[3], sigma_max, ratio[3]; /* ratio = sigma / sigma_max */
    Real collide;               /* part of the extinction that makes collisions; the rest weighs flights */
    int empty;                  /* of a grid: no density anywhere */
    Real albedo[3];             /* over collide */
    RPhase phase;
    RGrid grid;
    const float *majorant;
    int32_t majorant_n[3];
    Real scale_height;          /* of air: density exp(-h / scale_height) at heights h in [0, hi[2]]; of its space only the shift counts */
    Real radius;                /* 0: h = z; else above a sphere that touches z = 0 from below at the origin of its space */
} RMedium;

typedef struct RLight {
    int kind, hemisphere;
    int sampled;               /* a light sample at every vertex finds it; met by chance it is weighted against that */
    Real direction[3];
    Real value[3];             /* irradiance (delta sun), radiance (disc, constant), intensity (point) */
    RDisc disc;                /* sun that is not a delta: width > 0 */
    Real position[3];
    Real near_squared;         /* of a point: r0^2 of near_lookup.h; 0: collisions take all of its light */
    REnvironment map;
} RLight;

/* Meshes (in one hierarchy) and planes; surface: place in albedo, in the order of the scene. */
typedef struct RSurfaces {
    int count, plane_count;
    RBvh bvh;
    const int32_t *mesh_first;
    int mesh_surface[NPH_MAX_SURFACES], plane_surface[NPH_MAX_SURFACES];
    RPlane planes[NPH_MAX_SURFACES];
    double height[NPH_MAX_SURFACES]; /* of the planes: scene-local z */
    Real albedo[NPH_MAX_SURFACES][3];
    Real globe_radius;               /* 0: none; else a sphere, below its highest point globe_top, scene-local */
    Real globe_top[3];
    int globe_surface;
} RSurfaces;

/* A medium's own light: j_c = value[c], times a grid. field: where it is; of a grid `majorant` bounds the largest channel's
 * j, and sigma_max is how many events there are per metre and unit of it; else sigma is that of its own medium. */
typedef struct REmitter {
    RMedium field;
    Real value[3];
    int grids;                 /* 1, or 3: one a channel */
    RGrid grid[3];
    int alone;                 /* box or layer: nothing but its own medium lies on the way, and no surface */
} REmitter;

typedef struct RScene {
    int medium_count, light_count, emitter_count;
    int chromatic;             /* the extinction of a medium differs between channels */
    int channels;              /* of transport: 1 when every medium is grey */
    int film_channels;         /* 1 when the lights are grey too */
    int heroes;                /* what a camera ray's hero is drawn from: channels times groups */
    int groups, spectral;      /* of wavelengths, each an RScene, one after the other; spectral: channels become R, G, B by */
    Real rgb_from_channels[9]; /* this, times the number of groups; row-major */
    int width, height;
    uint32_t seed, frame;
    /* What an integrator may set after r_prepare_scene; until then 0, and guide -1: the plain estimators. */
    int weighed;               /* flights carry weights: collide < 1 in the one medium */
    Real forced;               /* how much oftener camera rays collide in the one medium, a box or layer; 0: as it comes */
    Real roulette, shadow_roulette;
    int guide;                 /* sun towards which directions are sampled too, or -1 */
    Real guide_part, least_light, weight_unit; /* weight_unit: 1 over the weight of a camera ray */
    NphSensor sensor;          /* world space, f64 */
    double origin[3];          /* of scene-local space */
    double bounds_lo[3], bounds_hi[3]; /* of all media and meshes, scene-local, f64; infinite where a layer has no end */
    RPeriod period;
    double period_lo[2], period_size[2], period_inverse[2]; /* the same in f64, for camera rays */
    RMedium media[NPH_MAX_MEDIA];
    RLight lights[NPH_MAX_LIGHTS];
    REmitter emitters[NPH_MAX_MEDIA];
    RSurfaces surfaces;
} RScene;

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

/* Back into the first period. Flights find their way from anywhere; small numbers keep their precision. */
static inline Real r_wrap(Real u, Real lo, Real size, Real inverse) { return u - size * r_floor((u - lo) * inverse); }

static inline void r_wrap_position(const RPeriod *period, Real p[3]) {
    if (!period->on) return;
    for (int a = 0; a < 2; a++) p[a] = r_wrap(p[a], period->lo[a], period->size[a], period->inverse[a]);
}

/* A hero names a group and a channel in it. Without wavelengths there is one group. */
static inline const RScene *r_scene_group(const RScene *first, int32_t hero) { return first + hero / 3; }
static inline int r_hero_channel(int32_t hero) { return hero % 3; }

/* What a sample's light is worth to the film: R, G, B. */
static inline void r_film_rgb(const RScene *scene, Real light[3]) {
    if (!scene->spectral) return;
    const Real *m = scene->rgb_from_channels;
    Real x = light[0], y = light[1], z = light[2];
    for (int c = 0; c < 3; c++) light[c] = m[3 * c] * x + m[3 * c + 1] * y + m[3 * c + 2] * z;
}

/* Of a transmittance: where there are wavelengths the mean over the group's. */
static inline void r_film_transmittance(const RScene *scene, Real T[3]) {
    if (scene->spectral) T[0] = T[1] = T[2] = (T[0] + T[1] + T[2]) * R(0.33333333333333333);
}

static inline Real r_luminance(const Real c[3]) {
    return R(0.2126) * c[0] + R(0.7152) * c[1] + R(0.0722) * c[2];
}

#endif
