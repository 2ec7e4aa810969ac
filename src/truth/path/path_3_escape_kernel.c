/* SPDX-License-Identifier: Apache-2.0
 *
 * path.escape: paths that leave all media meet the lights at infinity. A light that is also sampled at vertices is
 * weighted by the balance heuristic p_phase / (p_phase + p_light); both densities are of the direction alone, so the
 * two weights of a direction add to one whatever the transmittance. Camera rays that escape estimate the
 * transmittance. Of camera rays that were made to collide a part escapes all the same: what it finds is laid aside, and
 * joined at the end to what the collision brought. [paths, escaped -> samples] */
#include <string.h>

#include "transport/camera_lookup.h"
#include "truth/path/path_state.h"

void NPH_KERNEL(nph_path_escape)(NphPathBatch *batch);
void NPH_KERNEL(nph_path_fold)(NphPathBatch *batch);

static int colours(const RScene *scene) { return scene->film_channels > 1 ? 3 : 1; }

/* All that samples hold so far came without a collision. */
static void lay_aside(NphPathBatch *batch) {
    size_t bytes = sizeof(Real) * NPH_PATH_BATCH;
    for (int c = 0; c < colours(batch->scene); c++) {
        Real *light = batch->samples + (NPH_SAMPLE_L0 + c) * NPH_PATH_BATCH;
        memcpy(batch->passed_by[c], light, bytes);
        memset(light, 0, bytes);
    }
}

/* Of ids that no ray was made for, in parts of tiles, samples and light laid aside are 0. */
void NPH_KERNEL(nph_path_fold)(NphPathBatch *batch) {
    Real *order = batch->samples + NPH_SAMPLE_ORDER * NPH_PATH_BATCH;
    for (int c = 0; c < colours(batch->scene); c++) {
        Real *light = batch->samples + (NPH_SAMPLE_L0 + c) * NPH_PATH_BATCH;
        for (int id = 0; id < NPH_PATH_BATCH; id++)
            light[id] = batch->passed_by[c][id] + batch->collides[id] * light[id];
    }
    for (int id = 0; id < NPH_PATH_BATCH; id++) order[id] *= batch->collides[id];
}

void NPH_KERNEL(nph_path_escape)(NphPathBatch *batch) {
    const RPaths *paths = &batch->paths[batch->now];
    int wide = batch->scene->channels > 1, met = r_lights_are_met(batch->scene);
    if (!met && batch->vertex > 0) return;
    int forced = batch->scene->forced > R(0.0) && batch->vertex == 0, left = forced ? batch->count : batch->left;
    for (int k = 0; k < left; k++) {
        int i = forced ? k : batch->escaped[k];
        int32_t id = paths->id[i];
        const RScene *scene = r_path_scene(batch, i);
        Real d[3] = {paths->d[0][i], paths->d[1][i], paths->d[2][i]}, radiance[3] = {R(0.0), R(0.0), R(0.0)};
        Real weight[3];
        for (int c = 0; c < 3; c++) weight[c] = paths->weight[wide ? c : 0][i];
        if (forced) weight[0] = weight[1] = weight[2] = batch->survived[i] * r_sensor_weight(scene);
        if (met) {
            r_lights_at_infinity(scene, d, paths->pdf[i], radiance);
            r_add_light(batch, scene, id, weight, radiance, batch->vertex);
        }
        if (batch->vertex == 0) {
            r_film_transmittance(scene, weight);
            for (int c = 0; c < 3; c++) batch->samples[(NPH_SAMPLE_T0 + c) * NPH_PATH_BATCH + id] = weight[c] * scene->weight_unit;
        }
    }
    if (forced) lay_aside(batch);
}
