/* SPDX-License-Identifier: Apache-2.0
 *
 * path.emission: what media add by their own light along every flight, up to where it ended (emission_lookup.h).
 * path.near: what point lights in media send to one place of every flight (near_lookup.h). Both run before the channels'
 * factors of the flight are known to the weights. [paths, distance -> samples]
 * path.around: the same light, from places around the lights to every vertex. [paths, queue -> samples] */
#include "transport/near_lookup.h"
#include "truth/path/path_state.h"

void NPH_KERNEL(nph_path_emission)(NphPathBatch *batch);
void NPH_KERNEL(nph_path_near)(NphPathBatch *batch, int light);
void NPH_KERNEL(nph_path_around)(NphPathBatch *batch, int light);

static const Real one[3] = {R(1.0), R(1.0), R(1.0)};

/* Path i as it set out. */
static void set_out(const NphPathBatch *batch, int i, RFlown *flight) {
    const RScene *scene = batch->scene;
    const RPaths *paths = &batch->paths[batch->now];
    int32_t id = paths->id[i];
    int wide = scene->channels > 1;
    flight->limit = batch->distance[i];
    flight->pdf = batch->vertex > 0 ? paths->pdf[i] : R(-1.0);
    flight->hero = r_hero_channel(paths->hero[i]);
    flight->flown = r_stream(scene, NPH_RNG_TRACK, r_pixel(batch, id), r_sample(batch, id), batch->vertex);
    for (int c = 0; c < 3; c++) {
        flight->p[c] = paths->p[c][i];
        flight->d[c] = paths->d[c][i];
        flight->weight[c] = paths->weight[wide ? c : 0][i];
        flight->share[c] = wide ? paths->share[c][i] : R(1.0);
    }
}

void NPH_KERNEL(nph_path_emission)(NphPathBatch *batch) {
    for (int i = 0; i < batch->count; i++) {
        RFlown flight;
        Real light[3];
        set_out(batch, i, &flight);
        const RScene *scene = r_path_scene(batch, i);
        RStream stream = r_stream(scene, NPH_RNG_EMISSION, flight.flown.pixel, flight.flown.sample, batch->vertex);
        r_emission(scene, &flight, &stream, &batch->tally, light);
        r_add_light(batch, scene, batch->paths[batch->now].id[i], one, light, batch->vertex);
    }
}

void NPH_KERNEL(nph_path_near)(NphPathBatch *batch, int number) {
    uint32_t vertex = batch->vertex + 1u;
    for (int i = 0; i < batch->count; i++) {
        RFlown flight;
        Real light[3];
        set_out(batch, i, &flight);
        const RScene *scene = r_path_scene(batch, i);
        uint32_t pixel = flight.flown.pixel, sample = flight.flown.sample;
        RStream streams[2] = {r_stream(scene, NPH_RNG_NEAR, pixel, sample, vertex),
                              r_stream(scene, NPH_RNG_NEAR_SHADOW, pixel, sample, vertex)};
        r_near_light(scene, &flight, number, streams, &batch->tally, light);
        r_add_light(batch, scene, batch->paths[batch->now].id[i], one, light, vertex);
    }
}

void NPH_KERNEL(nph_path_around)(NphPathBatch *batch, int number) {
    const RPaths *paths = &batch->paths[batch->now];
    uint32_t at = batch->vertex + 1u;
    int wide = batch->scene->channels > 1;
    for (int k = 0; k < batch->queued + batch->touched; k++) {
        int i = batch->queue[k];
        const RScene *scene = r_path_scene(batch, i);
        uint32_t pixel = r_pixel(batch, paths->id[i]), sample = r_sample(batch, paths->id[i]);
        RNearStreams streams = {r_stream(scene, NPH_RNG_NEAR, pixel, sample, at),
                                {r_stream(scene, NPH_RNG_AROUND_TO, pixel, sample, at),
                                 r_stream(scene, NPH_RNG_AROUND_FROM, pixel, sample, at)}};
        RVertex vertex;
        Real weight[3], light[3];
        for (int c = 0; c < 3; c++) weight[c] = paths->weight[wide ? c : 0][i];
        r_path_vertex(batch, i, &vertex);
        r_near_around(scene, &vertex, weight, number, &streams, &batch->tally, light);
        r_add_light(batch, scene, paths->id[i], one, light, at + 1u);
    }
}
