/* SPDX-License-Identifier: Apache-2.0
 *
 * One camera ray, shared by path.generate and the replay. */
#ifndef NPH_TRUTH_PATH_CAMERA_H
#define NPH_TRUTH_PATH_CAMERA_H

#include "truth/path/path_state.h"

typedef struct RCameraRay {
    Real p[3], d[3];
    Real start;   /* metres from the sensor to p */
    Real weight;  /* 1; pi for a flux sensor */
    Real pdf;     /* of d when a light sample at the sensor could have found it (flux), else -1 */
    int32_t hero;
} RCameraRay;

/* Distance along the ray to the box of all media, at most; 0 inside it or when it is missed. */
static inline double r_camera_advance(const RScene *scene, const double p[3], const double d[3]) {
    double near = 0.0, far = 1e300;
    for (int a = 0; a < 3; a++) {
        double lo = scene->bounds_lo[a], hi = scene->bounds_hi[a];
        if (!(lo > -1e300) || !(hi < 1e300)) continue;
        if (!(nph_abs(d[a]) > 1e-300)) {
            if (p[a] < lo || p[a] > hi) return 0.0;
            continue;
        }
        double t0 = (lo - p[a]) / d[a], t1 = (hi - p[a]) / d[a];
        double first = t0 < t1 ? t0 : t1, last = t0 < t1 ? t1 : t0;
        near = first > near ? first : near;
        far = last < far ? last : far;
    }
    return near < far ? near : 0.0;
}

static inline void r_camera_ray(const RScene *scene, int x, int y, const RStream *stream, RCameraRay *ray) {
    const NphSensor *sensor = &scene->sensor;
    NphWords words = r_words(stream, 0), more = r_words(stream, 1);
    double s = 2.0 * ((double)x + nph_uniform(words.w0)) / (double)scene->width - 1.0;
    double t = 1.0 - 2.0 * ((double)y + nph_uniform(words.w1)) / (double)scene->height;
    double p[3], d[3], length = 0.0, cosine = 1.0;
    s *= sensor->half_size[0];
    t *= sensor->half_size[1];
    int perspective = sensor->kind == NPH_SENSOR_PERSPECTIVE, flux = sensor->kind == NPH_SENSOR_FLUX;
    double v = nph_uniform(words.w3), turn_sin, turn_cos;
    nph_sincos2pi(nph_uniform(more.w0), &turn_sin, &turn_cos);
    double across = nph_sqrt(v);
    cosine = nph_sqrt(1.0 - v); /* v < 1, so the ray never runs along the plane */
    for (int a = 0; a < 3; a++) {
        double offset = s * sensor->right[a] + t * sensor->up[a];
        p[a] = sensor->position[a] + (perspective ? 0.0 : offset) - scene->origin[a];
        d[a] = sensor->forward[a] + (perspective ? offset : 0.0);
        if (flux) d[a] = across * (turn_cos * sensor->right[a] + turn_sin * sensor->up[a]) + cosine * sensor->forward[a];
        length += d[a] * d[a];
    }
    length = nph_sqrt(length);
    for (int a = 0; a < 3; a++) d[a] /= length;
    double start = r_camera_advance(scene, p, d);
    for (int a = 0; a < 3; a++) {
        ray->p[a] = (Real)(p[a] + start * d[a]);
        ray->d[a] = (Real)d[a];
    }
    ray->start = (Real)start;
    ray->weight = flux ? R(3.14159265358979323846) : R(1.0);
    ray->pdf = flux ? (Real)(cosine * 0.31830988618379067154) : R(-1.0);
    int32_t hero = (int32_t)(((uint64_t)words.w2 * (uint64_t)(uint32_t)scene->channels) >> 32);
    ray->hero = hero;
}

#endif
