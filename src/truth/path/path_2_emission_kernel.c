/* SPDX-License-Identifier: Apache-2.0
 *
 * path.emission: what media add by their own light along every flight, up to where it ended (emission_lookup.h). Runs
 * before the channels' factors of the flight are known to the weights. [paths, distance -> samples] */
#include "transport/emission_lookup.h"
#include "truth/path/path_state.h"

void NPH_KERNEL(nph_path_emission)(NphPathBatch *batch);

void NPH_KERNEL(nph_path_emission)(NphPathBatch *batch) {
    const RScene *scene = batch->scene;
    const RPaths *paths = &batch->paths[batch->now];
    const Real one[3] = {R(1.0), R(1.0), R(1.0)};
    int wide = scene->channels > 1;
    for (int i = 0; i < batch->count; i++) {
        int32_t id = paths->id[i];
        uint32_t pixel = r_pixel(batch, id), sample = r_sample(batch, id);
        RFlown flight = {.limit = batch->distance[i], .hero = paths->hero[i],
                         .flown = r_stream(scene, NPH_RNG_TRACK, pixel, sample, batch->vertex)};
        for (int c = 0; c < 3; c++) {
            flight.p[c] = paths->p[c][i];
            flight.d[c] = paths->d[c][i];
            flight.weight[c] = paths->weight[wide ? c : 0][i];
            flight.share[c] = wide ? paths->share[c][i] : R(1.0);
        }
        RStream stream = r_stream(scene, NPH_RNG_EMISSION, pixel, sample, batch->vertex);
        Real light[3];
        r_emission(scene, &flight, &stream, &batch->tally, light);
        r_add_light(batch, scene, id, one, light, batch->vertex);
    }
}
