/* SPDX-License-Identifier: Apache-2.0
 *
 * path.generate: camera rays. World space (f64) ends here: the ray is moved into scene-local space and forward to the
 * box of all media, so that Real holds what follows. A pixel is a box filter: uniform positions. A flux sensor's rays
 * start on its rectangle and are cosine distributed: E = pi times the mean radiance.
 * [-> paths.p, d, weight, share, pdf, id, hero; start] */
#include <string.h>

#include "transport/camera_lookup.h"
#include "truth/path/path_state.h"

void NPH_KERNEL(nph_path_generate)(NphPathBatch *batch);

static int plain(NphSensorKind kind) { return !nph_sensor_gathers(kind) && kind != NPH_SENSOR_FISHEYE; }

/* All 4096 rays of a tile, one grey channel. */
R_OUTLINE void generate_lanes(const RScene *restrict constant, const RTile *restrict from, Real *restrict to,
                              Real *restrict start, int32_t *restrict sees) {
    const RScene *scene = constant;
    RTile tile = *from;
    double perspective = scene->sensor.kind == NPH_SENSOR_PERSPECTIVE ? 1.0 : 0.0;
    for (int i = 0; i < NPH_PATH_BATCH; i++) { /* vec */
        NphWords words = r_tile_words(&tile, i, 0);
        RCameraRay ray = r_camera_plain(scene, tile.x + ((i >> 4) & 15), tile.y + (i >> 8), words, perspective, 0);
        to[R_OF_P * NPH_PATH_BATCH + i] = ray.p[0];
        to[(R_OF_P + 1) * NPH_PATH_BATCH + i] = ray.p[1];
        to[(R_OF_P + 2) * NPH_PATH_BATCH + i] = ray.p[2];
        to[R_OF_D * NPH_PATH_BATCH + i] = ray.d[0];
        to[(R_OF_D + 1) * NPH_PATH_BATCH + i] = ray.d[1];
        to[(R_OF_D + 2) * NPH_PATH_BATCH + i] = ray.d[2];
        to[R_OF_WEIGHT * NPH_PATH_BATCH + i] = R(1.0);
        to[R_OF_SHARE * NPH_PATH_BATCH + i] = R(1.0);
        to[R_OF_PDF * NPH_PATH_BATCH + i] = R(-1.0);
        start[i] = ray.start;
        sees[i] = ray.sees;
    }
}

/* Where no light can be met, paths that meet nothing at all have ended: they see through. The others move together. */
static void part_blind(NphPathBatch *batch, RPaths *paths, const int32_t *sees) {
    int count = 0;
    for (int32_t id = 0; id < NPH_PATH_BATCH; id++) {
        for (int c = 0; c < 3 && !sees[id]; c++) batch->samples[(NPH_SAMPLE_T0 + c) * NPH_PATH_BATCH + id] = R(1.0);
        for (int a = 0; a < 3; a++) {
            paths->p[a][count] = paths->p[a][id];
            paths->d[a][count] = paths->d[a][id];
        }
        paths->id[count] = id;
        count += sees[id];
    }
    batch->count = count;
}

void NPH_KERNEL(nph_path_generate)(NphPathBatch *batch) {
    const RScene *scene = batch->scene;
    RPaths *paths = &batch->paths[batch->now];
    int count = 0, whole = batch->inside[0] <= batch->tile_x && batch->inside[1] <= batch->tile_y &&
                           batch->inside[2] >= batch->tile_x + NPH_TILE && batch->inside[3] >= batch->tile_y + NPH_TILE;
    int blind = r_path_blind(scene);
    batch->vertex = 0;
    if (whole && scene->channels == 1 && plain(scene->sensor.kind) &&
        scene->surfaces.plane_count == 0) {
        RStream stream = r_stream(scene, NPH_RNG_GENERATE, 0, 0, 0);
        RTile tile = r_tile(batch, &stream, NPH_PATH_BATCH, 0);
        generate_lanes(scene, &tile, paths->p[0], batch->start, batch->surface);
        for (int32_t id = 0; id < NPH_PATH_BATCH; id++) paths->id[id] = id;
        memset(paths->hero, 0, sizeof(int32_t) * NPH_PATH_BATCH);
        batch->count = NPH_PATH_BATCH;
        if (blind) part_blind(batch, paths, batch->surface);
        return;
    }
    for (int32_t id = 0; id < NPH_PATH_BATCH; id++) {
        int x = batch->tile_x + ((id >> 4) & 15), y = batch->tile_y + (id >> 8);
        if (x < batch->inside[0] || y < batch->inside[1] || x >= batch->inside[2] || y >= batch->inside[3]) continue;
        RStream stream = r_stream(scene, NPH_RNG_GENERATE, r_pixel(batch, id), r_sample(batch, id), 0);
        RCameraRay ray;
        r_camera_ray(scene, x, y, &stream, &ray);
        if (!(ray.weight > R(0.0))) continue;
        int ended = blind && !ray.sees;
        for (int c = 0; c < 3 && ended; c++) batch->samples[(NPH_SAMPLE_T0 + c) * NPH_PATH_BATCH + id] = R(1.0);
        if (ended) continue;
        for (int a = 0; a < 3; a++) {
            paths->p[a][count] = ray.p[a];
            paths->d[a][count] = ray.d[a];
            batch->ray[a][count] = ray.at[a];
        }
        for (int c = 0; c < scene->channels; c++) {
            paths->weight[c][count] = ray.weight;
            paths->share[c][count] = R(1.0);
        }
        paths->pdf[count] = ray.pdf;
        paths->hero[count] = ray.hero;
        paths->id[count] = id;
        batch->start[id] = ray.start;
        count++;
    }
    batch->count = count;
}
