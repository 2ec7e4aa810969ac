/* SPDX-License-Identifier: Apache-2.0
 *
 * What the path tracer's kernels see besides the scene (transport/local_scene.h): a batch of paths as structure of
 * arrays. A batch is one tile of 16 x 16 pixels and one chunk of 16 samples: 4096 paths, about 1 MiB in f32, for a
 * core's L2 cache while the stages pass over it. */
#ifndef NPH_TRUTH_PATH_STATE_H
#define NPH_TRUTH_PATH_STATE_H

#include "transport/vertex_lookup.h"
#include "truth/path/path.h"

/* Paths in flight. weight is the throughput of each transport channel: product of f over the mean of the channels'
 * probabilities of the same choices (one-sample balance heuristic). share is the probability with which channel c, as
 * hero, would have made the choices, over that mean: 1 for grey media. */
typedef struct RPaths {
    Real *p[3], *d[3];
    Real *weight[3], *share[3];
    Real *pdf;                 /* of the direction at the last vertex; negative when a light sample could not find it */
    int32_t *id;               /* pixel in tile * 16 + sample in chunk */
    int32_t *hero;             /* channel whose extinction drives the tracking; of which group (r_scene_group) */
} RPaths;

static inline Real r_lane(const Real *arrays, int which, int i) { return arrays[which * NPH_PATH_BATCH + i]; }

/* Where the arrays of RPaths stand, in units of NPH_PATH_BATCH from p[0]; those of shadow rays likewise from ray[0]. */
enum { R_OF_P = 0, R_OF_D = 3, R_OF_WEIGHT = 6, R_OF_SHARE = 9, R_OF_PDF = 12 };
enum { R_OF_ARRIVING = 6, R_OF_CARRIED = 9, R_OF_PASSED = 10, R_OF_REACH = 11 };

struct NphPathBatch {
    const RScene *scene;       /* the first group; r_path_scene has a path's own */
    RPaths paths[2];           /* paths[now] is read by track, escape, shadow, scatter; scatter fills the other one */
    int now, count;            /* paths in flight */
    int tile_x, tile_y, inside[4];
    uint32_t first_sample, vertex;
    Real *distance;            /* of the next collision; negative: none */
    int32_t *medium;           /* in which it happens */
    int32_t *surface;          /* where there are surfaces: the one at which the path is if it does not collide; -1 */
    Real *surface_p[3], *surface_n[3], *surface_t; /* RMet */
    Real *survived, *expected; /* where flights are weighed: weight of virtual collisions, depth by the cells' means */
    int32_t *queue, *escaped;  /* positions of the paths that collide, then of those at surfaces; that leave */
    int queued, touched, left;
    Real *ray[3], *towards[3]; /* rays from vertices to a light: [4096] each, as those below */
    Real *arriving[3];         /* radiance over density of the light sample */
    Real *carried, *passed, *reach; /* what arrives per radiance if nothing stops it; transmittance; how far the light is */
    int32_t *ray_id;
    void *flights;             /* RFlights (path_lanes.h) */
    Real *samples;             /* [NPH_SAMPLE_FIELDS][4096] */
    Real *start;               /* [4096], by id: distance from the camera to where the path began */
    /* of forced collisions, [4096] by id: the chance to collide; light of the part that did not, once it is laid aside */
    Real *collides, *passed_by[3];
    NphTally tally;
};

static inline uint32_t r_pixel(const NphPathBatch *batch, int32_t id) {
    uint32_t x = (uint32_t)(batch->tile_x + ((id >> 4) & 15)), y = (uint32_t)(batch->tile_y + (id >> 8));
    return y * (uint32_t)batch->scene->width + x;
}

static inline uint32_t r_sample(const NphPathBatch *batch, int32_t id) {
    return batch->first_sample + (uint32_t)(id & 15);
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

/* The scene of a path's three wavelengths; without wavelengths there is one. */
static inline const RScene *r_path_scene(const NphPathBatch *batch, int i) {
    return r_scene_group(batch->scene, batch->paths[batch->now].hero[i]);
}

/* Whether camera rays that miss the box of all media (RCameraRay.sees, in f64) have ended: no light can be met. One rule for
 * whole tiles, parts of tiles and the replay, since a flight in f32 might graze what the ray misses. */
static inline int r_path_blind(const RScene *scene) {
    int plain = !nph_sensor_gathers(scene->sensor.kind) && scene->sensor.kind != NPH_SENSOR_FISHEYE;
    int nothing = scene->surfaces.count == 0 && scene->emitter_count == 0 && !r_lights_are_met(scene);
    return plain && scene->channels == 1 && nothing;
}

/* The vertex of path i, in a medium or on a surface. */
static inline void r_path_vertex(const NphPathBatch *batch, int i, RVertex *vertex) {
    const RScene *scene = r_path_scene(batch, i);
    const RPaths *paths = &batch->paths[batch->now];
    Real d[3] = {paths->d[0][i], paths->d[1][i], paths->d[2][i]}, p[3], n[3];
    int in = batch->medium[i];
    if (in >= 0) {
        for (int a = 0; a < 3; a++) p[a] = paths->p[a][i] + batch->distance[i] * d[a];
        r_vertex_in_medium(&scene->media[in], p, d, vertex);
        return;
    }
    for (int a = 0; a < 3; a++) {
        p[a] = batch->surface_p[a][i];
        n[a] = batch->surface_n[a][i];
    }
    r_vertex_on_surface(scene->surfaces.albedo[batch->surface[i]], p, n, d, vertex);
}

/* Adds weight * radiance to a path's sample, as many channels of it as the film has, and to its order-weighted luminance;
 * scene: the path's own. */
static inline void r_add_light(NphPathBatch *batch, const RScene *scene, int32_t id, const Real weight[3], const Real radiance[3],
                               uint32_t order) {
    Real light[3];
    for (int c = 0; c < 3; c++) {
        light[c] = weight[c] * radiance[c];
        if (NPH_BUG(12)) light[c] = r_min(light[c], R(1.0));
    }
    r_film_rgb(scene, light);
    int colours = scene->film_channels > 1 ? 3 : 1;
    for (int c = 0; c < colours; c++) batch->samples[(NPH_SAMPLE_L0 + c) * NPH_PATH_BATCH + id] += light[c];
    batch->samples[NPH_SAMPLE_ORDER * NPH_PATH_BATCH + id] += (Real)order * r_luminance(light);
}

#endif
