/* SPDX-License-Identifier: Apache-2.0
 *
 * shdom.march for sensors that gather, flux and fluence: from a point of the sensor a ray along each of a set of directions, Gauss and
 * Legendre's in the cosine on each hemisphere around the sensor's axis times even azimuths, turned by a random angle a sample:
 *   flux = sum of w cos L + suns E cos e^-tau' + points I cos / r^2 e^-tau',   fluence the same without cosines, from both sides
 * Fluxes are those of the solution, with the cut phase function and extinction in every term, so that energy is conserved: what delta-M
 * takes for not scattered arrives with the beams. Maps arrive by one light sample and one ray, weighed by the balance heuristic
 * [Veach95], as small lights slip through any fixed set. */
#include <string.h>

#include "core/fmath.h"
#include "transport/vertex_lookup.h"
#include "truth/shdom/shdom_ray.h"

/* A sensor's point under way. */
typedef struct Sensor {
    const NphShdomCamera *camera;
    const NphShdomRoom *room;
    const RCameraRay *ray;
    const NphSingleAsk *ask;
    int flux;
    double *fields;
} Sensor;

static double cosine_of(const Sensor *sensor, const double d[3]) {
    const double *n = sensor->camera->scene->local.sensor.forward;
    return sensor->flux ? n[0] * d[0] + n[1] * d[1] + n[2] * d[2] : 1.0;
}

/* Suns and points, not scattered; and the light sample of a map. */
static void add_beams(Sensor *sensor) {
    const RScene *local = &sensor->camera->scene->local;
    for (int l = 0; l < local->light_count; l++) {
        RStream stream = r_stream(local, NPH_RNG_LIGHT, sensor->ask->pixel, sensor->ask->sample, 0);
        RLightSample sample;
        double T[3], light[3];
        if (!local->lights[l].sampled) continue;
        stream.draw = (uint32_t)l << NPH_DRAW_LIGHT_SHIFT;
        r_sample_light(&local->lights[l], sensor->ray->at, &stream, &sample);
        if (local->lights[l].kind == NPH_LIGHT_SUN)
            for (int c = 0; c < 3; c++) sample.value[c] = sensor->camera->scene->beam[l][c];
        double cosine = cosine_of(sensor, sample.d), map = local->lights[l].kind == NPH_LIGHT_ENVIRONMENT;
        if (!(cosine > 0.0)) continue;
        double density = cosine * (sensor->flux ? 0.31830988618379067154 : 0.079577471545947667884);
        double balance = map > 0.0 ? r_balance(sample.pdf, density) : 1.0;
        nph_single_transmittance(local, sensor->ray->at, sample.d, sample.distance, &sensor->room->scratch->tally.walked, T);
        for (int c = 0; c < 3; c++) light[c] = cosine * balance * T[local->channels > 1 ? c : 0] * sample.value[c];
        nph_shdom_ray_add(sensor->camera, light, 0, sensor->fields);
    }
}

/* Maps that the random ray of the sensor meets. */
static void add_maps(Sensor *sensor, double mean_T[3]) {
    const RScene *local = &sensor->camera->scene->local;
    const double *d = sensor->ray->d;
    double T[3], light[3] = {0.0, 0.0, 0.0};
    nph_single_transmittance(local, sensor->ray->p, d, R_HUGE, &sensor->room->scratch->tally.walked, T);
    for (int l = 0; l < local->light_count; l++) {
        double value[3];
        if (local->lights[l].kind != NPH_LIGHT_ENVIRONMENT) continue;
        double density = r_environment_lookup(&local->lights[l].map, d, value);
        double weight = sensor->ray->weight * (local->lights[l].sampled ? r_balance(sensor->ray->pdf, density) : 1.0);
        for (int c = 0; c < 3; c++) light[c] += weight * value[c] * T[local->channels > 1 ? c : 0];
    }
    nph_shdom_ray_add(sensor->camera, light, 0, sensor->fields);
    for (int c = 0; c < 3; c++) {
        double kept = sensor->camera->choice->kept[c], passes = T[local->channels > 1 ? c : 0];
        mean_T[c] = passes > 0.0 ? nph_exp(nph_log(passes) / kept) : 0.0;
    }
}

/* One direction of the set: weight in steradians, cosine included. */
static void add_direction(Sensor *sensor, const double d[3], double weight, double *near) {
    const NphShdomCamera *camera = sensor->camera;
    const RScene *local = &camera->scene->local;
    RCameraRay started = r_camera_start(local, sensor->ray->at, d, 0, 0);
    NphShdomRay ray;
    double light[3], sky[3] = {0.0, 0.0, 0.0};
    nph_shdom_ray_begin(camera, sensor->room, started.p, started.d, &ray);
    nph_shdom_ray_follow(&ray, &started, sensor->ask, 1);
    nph_shdom_ray_spread(&ray, light);
    for (int l = 0; l < local->light_count; l++) {
        const RLight *of = &local->lights[l];
        int seen = of->kind == NPH_LIGHT_CONSTANT && (of->hemisphere == 0 || ray.d[2] * (double)of->hemisphere > 0.0);
        for (int c = 0; c < 3; c++) sky[c] += seen ? of->value[c] * nph_shdom_ray_channel(&ray, ray.passes, c) : 0.0;
    }
    for (int c = 0; c < 3; c++) {
        light[c] *= weight;
        ray.once[c] *= weight;
        sky[c] *= weight;
    }
    nph_shdom_ray_add(camera, light, 2, sensor->fields);
    nph_shdom_ray_add(camera, ray.once, 1, sensor->fields);
    nph_shdom_ray_add(camera, sky, 0, sensor->fields);
    *near += weight * ray.distance / (double)local->channels;
}

void nph_shdom_march_gather(const NphShdomCamera *camera, const NphShdomRoom *room, const RCameraRay *ray, const NphSingleAsk *ask,
                            double fields[NPH_SAMPLE_FIELDS]) {
    const RScene *local = &camera->scene->local;
    const NphSensor *s = &local->sensor;
    Sensor sensor = {camera, room, ray, ask, s->kind == NPH_SENSOR_FLUX, fields};
    RStream stream = r_stream(local, NPH_RNG_LIGHT, ask->pixel, ask->sample, 1);
    double turn = nph_uniform(r_words(&stream, 0).w0), T[3], collided = 0.0, near = 0.0, whole = sensor.flux ? 3.14159265358979323846 : 12.566370614359172954;
    int polar = camera->gather, azimuths = 2 * polar;
    for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) fields[f] = 0.0;
    add_beams(&sensor);
    add_maps(&sensor, T);
    for (int i = 0; i < polar * azimuths * (sensor.flux ? 1 : 2); i++) {
        int p = i / azimuths % polar, down = i >= polar * azimuths;
        double cosine = camera->gather_cosines[p], across = nph_sqrt(1.0 - cosine * cosine), sine, side, d[3];
        nph_sincos2pi((i % azimuths + turn) / azimuths, &sine, &side);
        for (int a = 0; a < 3; a++) d[a] = across * (side * s->right[a] + sine * s->up[a]) + (down ? -cosine : cosine) * s->forward[a];
        add_direction(&sensor, d, camera->gather_weights[p] * 6.2831853071795864769 / azimuths * (sensor.flux ? cosine : 1.0), &near);
    }
    for (int c = 0; c < 3; c++) fields[NPH_SAMPLE_T0 + c] = T[c];
    for (int c = 0; c < local->channels; c++) collided += (1.0 - T[c]) / (double)local->channels;
    fields[NPH_SAMPLE_COLLIDED] = collided;
    fields[NPH_SAMPLE_DISTANCE] = near / whole;
}
