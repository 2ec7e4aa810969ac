/* SPDX-License-Identifier: Apache-2.0
 *
 * path.escape: paths that leave all media meet the lights at infinity. A light that is also sampled at vertices is
 * weighted by the balance heuristic p_phase / (p_phase + p_light); both densities are of the direction alone, so the
 * two weights of a direction add to one whatever the transmittance. Camera rays that escape estimate the
 * transmittance. [paths, escaped -> samples] */
#include "truth/path/path_state.h"

void NPH_KERNEL(nph_path_escape)(NphPathBatch *batch);

void NPH_KERNEL(nph_path_escape)(NphPathBatch *batch) {
    const RPaths *paths = &batch->paths[batch->now];
    int wide = batch->scene->channels > 1, met = r_lights_are_met(batch->scene);
    if (!met && batch->vertex > 0) return;
    for (int k = 0; k < batch->left; k++) {
        int i = batch->escaped[k];
        int32_t id = paths->id[i];
        const RScene *scene = r_path_scene(batch, i);
        Real d[3] = {paths->d[0][i], paths->d[1][i], paths->d[2][i]}, radiance[3] = {R(0.0), R(0.0), R(0.0)};
        Real weight[3];
        for (int c = 0; c < 3; c++) weight[c] = paths->weight[wide ? c : 0][i];
        if (met) {
            r_lights_at_infinity(scene, d, paths->pdf[i], radiance);
            r_add_light(batch, scene, id, weight, radiance, batch->vertex);
        }
        if (batch->vertex == 0) {
            r_film_transmittance(scene, weight);
            for (int c = 0; c < 3; c++) batch->samples[(NPH_SAMPLE_T0 + c) * NPH_PATH_BATCH + id] = weight[c] * scene->weight_unit;
        }
    }
}
