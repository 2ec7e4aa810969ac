/* SPDX-License-Identifier: Apache-2.0
 *
 * light.see: what arrives without having met anything. A camera sees the lights at infinity along one ray per pixel and
 * sample, L T, and that ray's transmittance; flux and fluence take one light sample of each light from a point of the
 * pixel, L T cos / pdf and L T / pdf. The order of this light is 0. The rest of a sample is the image its photons made. */
#include <string.h>

#include "geometry/lambert_lookup.h"
#include "transport/camera_lookup.h"
#include "truth/light/light_1_emit_lookup.h"

void NPH_KERNEL(nph_light_see)(const void *memory, const double *traced, const int origin[2], const int inside[4],
                               int64_t sample, void *samples, NphTally *tally);

typedef struct Seer {
    const RScene *scene;
    RStream stream;
    NphTally *tally;
    Real L[3], T[3];
} Seer;

/* T up to limit; 0 behind a surface. */
static void pass(Seer *seer, const Real p[3], const Real d[3], Real limit, Real T[3]) {
    const RScene *scene = seer->scene;
    for (int c = 0; c < 3; c++) T[c] = R(1.0);
    if (scene->surfaces.count > 0 && r_blocked(scene, p, d, limit)) {
        for (int c = 0; c < 3; c++) T[c] = R(0.0);
        return;
    }
    r_pass(scene, &seer->stream, p, d, limit, T, seer->tally);
}

static void look(Seer *seer, const RCameraRay *ray) {
    Real radiance[3] = {R(0.0), R(0.0), R(0.0)};
    if (!(ray->weight > R(0.0))) return; /* a fisheye's corners */
    pass(seer, ray->p, ray->d, R_HUGE, seer->T);
    r_lights_at_infinity(seer->scene, ray->d, R(-1.0), radiance);
    for (int c = 0; c < 3; c++) seer->L[c] = radiance[c] * seer->T[c];
}

/* A constant light on a rectangle: directions by the cosine, so that every one that is lit brings pi L. */
static void sky_by_cosine(const RLight *light, const double normal[3], NphWords words, RLightSample *s) {
    Real n[3] = {(Real)normal[0], (Real)normal[1], (Real)normal[2]};
    r_lambert_sample(n, r_uniform(words.w2), r_uniform(words.w3), s->d);
    Real cosine = s->d[0] * n[0] + s->d[1] * n[1] + s->d[2] * n[2];
    int seen = light->hemisphere == 0 || s->d[2] * (Real)light->hemisphere > R(0.0);
    for (int c = 0; c < 3; c++) s->value[c] = seen ? light->value[c] * R(3.14159265358979323846) / cosine : R(0.0);
}

/* One light as a point of a sensor that gathers has it. */
static void gather(Seer *seer, int number, const RCameraRay *ray) {
    const RScene *scene = seer->scene;
    const RLight *light = &scene->lights[number];
    RLightSample s;
    Real T[3];
    const double *n = scene->sensor.forward;
    RStream stream = seer->stream;
    stream.key[1] = NPH_RNG_TRACE_LOOK << 24 | (scene->frame & 0xffffffu);
    stream.draw = seer->stream.draw = (uint32_t)number << NPH_DRAW_LIGHT_SHIFT;
    if (light->kind == NPH_LIGHT_CONSTANT && scene->sensor.kind == NPH_SENSOR_FLUX) {
        s.distance = R_HUGE;
        sky_by_cosine(light, n, r_words(&stream, 0), &s);
    } else if (light->kind == NPH_LIGHT_CONSTANT) {
        s.distance = R_HUGE;
        r_towards_infinity(light, r_words(&stream, 0), s.d, s.value);
    } else {
        r_sample_light(light, ray->at, &stream, &s);
    }
    Real cosine = s.d[0] * (Real)n[0] + s.d[1] * (Real)n[1] + s.d[2] * (Real)n[2];
    Real weight = scene->sensor.kind == NPH_SENSOR_FLUX ? r_max(cosine, R(0.0)) : R(1.0);
    if (!(weight * (s.value[0] + s.value[1] + s.value[2]) > R(0.0))) return;
    pass(seer, ray->at, s.d, s.distance, T);
    for (int c = 0; c < 3; c++) seer->L[c] += weight * s.value[c] * T[c];
}

static void see_pixel(Seer *seer, int x, int y, uint32_t sample) {
    const RScene *scene = seer->scene;
    RCameraRay ray;
    uint32_t pixel = (uint32_t)y * (uint32_t)scene->width + (uint32_t)x;
    seer->stream = r_stream(scene, NPH_RNG_TRACE_SEE, pixel, sample, 0);
    memset(seer->L, 0, sizeof seer->L);
    memset(seer->T, 0, sizeof seer->T);
    r_camera_ray(scene, x, y, &seer->stream, &ray);
    seer->stream = r_stream(scene, NPH_RNG_TRACE_SEEN, pixel, sample, 0);
    if (!nph_sensor_gathers((NphSensorKind)scene->sensor.kind)) {
        look(seer, &ray);
        return;
    }
    for (int l = 0; l < scene->light_count; l++) gather(seer, l, &ray);
}

void NPH_KERNEL(nph_light_see)(const void *memory, const double *traced, const int origin[2], const int inside[4],
                               int64_t sample, void *samples, NphTally *tally) {
    enum { PLANE = NPH_TILE_PIXELS * NPH_CHUNK };
    const RLightScene *light = memory;
    const RScene *scene = &light->scene;
    Real *out = samples;
    int channels = scene->film_channels;
    Seer seer = {.scene = scene, .tally = tally};
    memset(out, 0, sizeof *out * NPH_SAMPLE_FIELDS * PLANE);
    for (int y = inside[1]; y < inside[3]; y++)
        for (int x = inside[0]; x < inside[2]; x++)
            for (int i = 0; i < NPH_CHUNK; i++) {
                int at = ((y - origin[1]) * NPH_TILE + x - origin[0]) * NPH_CHUNK + i;
                see_pixel(&seer, x, y, (uint32_t)(sample + i));
                for (int c = 0; c < 3; c++) {
                    Real arrived = c < channels ? (Real)traced[c * PLANE + at] : R(0.0);
                    out[(NPH_SAMPLE_L0 + c) * PLANE + at] = seer.L[c] + arrived;
                    out[(NPH_SAMPLE_T0 + c) * PLANE + at] = seer.T[c];
                }
                out[NPH_SAMPLE_ORDER * PLANE + at] = (Real)traced[channels * PLANE + at];
            }
}
