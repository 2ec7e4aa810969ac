/* SPDX-License-Identifier: Apache-2.0
 *
 * path.shadow: at each collision one sample of a light, its transmittance by ratio tracking through every medium, and
 * what scatters towards the path: weight * albedo * p(cos) * T * L / pdf, weighted against finding the light by the
 * phase function. At a flux sensor the same with the cosine's density in place of the phase function.
 * [paths, queue, distance, medium -> samples] */
#include "truth/path/path_lights.h"

void NPH_KERNEL(nph_path_shadow)(NphPathBatch *batch, int light, int at_sensor);

/* Density with which the vertex scatters into direction to. */
static Real vertex_density(const NphPathBatch *batch, int i, const Real d[3], const Real to[3], int at_sensor) {
    const RScene *scene = batch->scene;
    if (at_sensor) {
        const double *n = scene->sensor.forward;
        Real cosine = to[0] * (Real)n[0] + to[1] * (Real)n[1] + to[2] * (Real)n[2];
        return r_max(cosine, R(0.0)) * R(0.31830988618379067154);
    }
    return r_phase_at(&scene->media[batch->medium[i]].phase, r_angle_between(d, to));
}

void NPH_KERNEL(nph_path_shadow)(NphPathBatch *batch, int light_number, int at_sensor) {
    const RScene *scene = batch->scene;
    const RLight *light = &scene->lights[light_number];
    const RPaths *paths = &batch->paths[batch->now];
    int wide = scene->channels > 1, count = at_sensor ? batch->count : batch->queued;
    uint32_t vertex = batch->vertex + (at_sensor ? 0u : 1u);
    for (int k = 0; k < count; k++) {
        int i = at_sensor ? k : batch->queue[k];
        int32_t id = paths->id[i];
        Real d[3] = {paths->d[0][i], paths->d[1][i], paths->d[2][i]}, p[3];
        Real travelled = at_sensor ? R(0.0) : batch->distance[i];
        for (int a = 0; a < 3; a++) p[a] = paths->p[a][i] + travelled * d[a];
        RStream stream = r_stream(scene, NPH_RNG_LIGHT, r_pixel(batch, id), r_sample(batch, id), vertex);
        stream.draw = (uint32_t)light_number << NPH_DRAW_LIGHT_SHIFT;
        RLightSample sample;
        r_sample_light(light, p, &stream, &sample);
        Real density = vertex_density(batch, i, d, sample.d, at_sensor);
        Real balance = sample.pdf < R(0.0) ? R(1.0) : sample.pdf / (sample.pdf + density);
        Real weight[3], T[3] = {R(1.0), wide ? R(1.0) : R(0.0), wide ? R(1.0) : R(0.0)}, largest = R(0.0);
        for (int c = 0; c < 3; c++) {
            Real albedo = at_sensor ? R(1.0) : scene->media[batch->medium[i]].albedo[c];
            weight[c] = paths->weight[wide ? c : 0][i] * albedo * density * balance;
            largest = r_max(largest, weight[c] * sample.value[c]);
        }
        if (!(largest > R(0.0))) continue;
        stream = r_stream(scene, NPH_RNG_SHADOW, stream.pixel, stream.sample, vertex);
        for (int m = 0; m < scene->medium_count && T[0] + T[1] + T[2] > R(0.0); m++) {
            REvents events = r_events(&stream, light_number, scene->media[m].number);
            r_transmittance(&scene->media[m], p, sample.d, sample.distance, scene, &events, T, &batch->tally);
        }
        for (int c = 0; c < 3; c++) weight[c] *= T[wide ? c : 0];
        r_add_light(batch, id, weight, sample.value, vertex);
    }
}
