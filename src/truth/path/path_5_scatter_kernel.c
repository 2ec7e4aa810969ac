/* SPDX-License-Identifier: Apache-2.0
 *
 * path.scatter: a collision takes its albedo, may end the path by roulette (below `roulette` it survives with
 * probability weight / (2 roulette), keeping the mean), and turns into a direction of the phase function. Survivors are
 * written one after the other into the other set of paths. At albedo 1 no weight falls and no path is ended: it leaves
 * through the surface, after sigma 4V/S collisions in the mean.
 * [paths, queue, distance, medium -> the other paths; samples at the first collision] */
#include "truth/path/path_walk.h"

void NPH_KERNEL(nph_path_scatter)(NphPathBatch *batch);

void NPH_KERNEL(nph_path_scatter)(NphPathBatch *batch) {
    const RScene *scene = batch->scene;
    const RPaths *from = &batch->paths[batch->now];
    RPaths *to = &batch->paths[1 - batch->now];
    uint32_t vertex = batch->vertex + 1u;
    int count = 0;
    for (int k = 0; k < batch->queued; k++) {
        int i = batch->queue[k];
        int32_t id = from->id[i];
        const RMedium *medium = &scene->media[batch->medium[i]];
        if (vertex == 1) {
            batch->samples[NPH_SAMPLE_DISTANCE * NPH_PATH_BATCH + id] = batch->start[id] + batch->distance[i];
            batch->samples[NPH_SAMPLE_COLLIDED * NPH_PATH_BATCH + id] = R(1.0);
        }
        RStream stream = r_stream(scene, NPH_RNG_SCATTER, r_pixel(batch, id), r_sample(batch, id), vertex);
        NphWords words = r_words(&stream, 0);
        Real weight[3], largest = R(0.0);
        for (int c = 0; c < scene->channels; c++) {
            weight[c] = from->weight[c][i] * medium->albedo[c];
            largest = r_max(largest, weight[c]);
        }
        Real survival = largest < scene->roulette ? largest / (R(2.0) * scene->roulette) : R(1.0);
        if (!(r_uniform(words.w3) < survival)) continue;
        Real d[3] = {from->d[0][i], from->d[1][i], from->d[2][i]}, turned[3];
        RAngle angle = r_phase_angle(&medium->phase, r_uniform(words.w0), r_uniform(words.w2));
        r_turn_by(d, angle, r_uniform(words.w1), turned);
        for (int a = 0; a < 3; a++) {
            to->p[a][count] = from->p[a][i] + batch->distance[i] * d[a];
            to->d[a][count] = turned[a];
        }
        for (int c = 0; c < scene->channels; c++) {
            to->weight[c][count] = weight[c] / survival;
            to->share[c][count] = from->share[c][i];
        }
        to->pdf[count] = r_phase_at(&medium->phase, angle);
        to->id[count] = id;
        to->hero[count] = from->hero[i];
        count++;
    }
    batch->now = 1 - batch->now;
    batch->count = count;
    batch->vertex = vertex;
}
