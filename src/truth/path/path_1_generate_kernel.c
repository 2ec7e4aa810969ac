/* SPDX-License-Identifier: Apache-2.0
 *
 * path.generate: camera rays. World space (f64) ends here: the ray is moved into scene-local space and forward to the
 * box of all media, so that Real holds what follows. A pixel is a box filter: uniform positions. A flux sensor's rays
 * start on its rectangle and are cosine distributed: E = pi times the mean radiance.
 * [-> paths.p, d, weight, share, pdf, id, hero; start] */
#include "truth/path/path_camera.h"

void NPH_KERNEL(nph_path_generate)(NphPathBatch *batch);

void NPH_KERNEL(nph_path_generate)(NphPathBatch *batch) {
    const RScene *scene = batch->scene;
    RPaths *paths = &batch->paths[batch->now];
    int count = 0;
    for (int32_t id = 0; id < NPH_PATH_BATCH; id++) {
        int x = batch->tile_x + ((id >> 4) & 15), y = batch->tile_y + (id >> 8);
        if (x < batch->inside[0] || y < batch->inside[1] || x >= batch->inside[2] || y >= batch->inside[3]) continue;
        RStream stream = r_stream(scene, NPH_RNG_GENERATE, r_pixel(batch, id), r_sample(batch, id), 0);
        RCameraRay ray;
        r_camera_ray(scene, x, y, &stream, &ray);
        for (int a = 0; a < 3; a++) {
            paths->p[a][count] = ray.p[a];
            paths->d[a][count] = ray.d[a];
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
    batch->vertex = 0;
}
