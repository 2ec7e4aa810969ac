/* SPDX-License-Identifier: Apache-2.0
 *
 * One camera ray: of pinhole, parallel and fisheye cameras, and of sensors for radiance, flux and fluence; where sides
 * repeat it is moved into their first period. It is shared by path.generate and the replay. */
#ifndef NPH_TRANSPORT_CAMERA_LOOKUP_H
#define NPH_TRANSPORT_CAMERA_LOOKUP_H

#include "transport/local_scene.h"

typedef struct RCameraRay {
    Real p[3], d[3];
    Real at[3];   /* the point of the sensor: where light samples of flux and fluence start */
    Real start;   /* metres from the sensor to p */
    Real weight;  /* 1; pi for a flux sensor, 4 pi for fluence; 0 where a fisheye sees nothing */
    Real pdf;     /* of d when a light sample at the sensor could have found it (flux, fluence), else -1 */
    int32_t hero, sees;   /* sees: it may meet a medium or a surface */
} RCameraRay;

/* The part of a ray between two planes; inv = 1 / d, or 0 along an axis that the ray does not move along. */
typedef struct RSlab {
    double near, far;
    int missed;
} RSlab;

static inline RSlab r_camera_slab(double lo, double hi, double p, double d) {
    int bounded = (lo > -1e300) & (hi < 1e300), moving = nph_abs(d) > 1e-300, both = bounded & moving;
    double inv = 1.0 / d, t0 = (lo - p) * inv, t1 = (hi - p) * inv;
    double first = t0 < t1 ? t0 : t1, last = t0 < t1 ? t1 : t0;
    RSlab slab = {both ? first : 0.0, both ? last : 1e300, bounded & !moving & ((p < lo) | (p > hi))};
    return slab;
}

/* Distance along the ray to the box of all media and meshes; R_NO_SIGHT when it is missed. */
#define R_NO_SIGHT 1e300
static inline double r_camera_box(const RScene *scene, const double p[3], const double d[3]) {
    const double *lo = scene->bounds_lo, *hi = scene->bounds_hi;
    RSlab x = r_camera_slab(lo[0], hi[0], p[0], d[0]), y = r_camera_slab(lo[1], hi[1], p[1], d[1]);
    RSlab z = r_camera_slab(lo[2], hi[2], p[2], d[2]);
    double near = x.near > 0.0 ? x.near : 0.0, far = x.far < y.far ? x.far : y.far;
    near = y.near > near ? y.near : near;
    near = z.near > near ? z.near : near;
    far = z.far < far ? z.far : far;
    int met = (near < far) & !(x.missed | y.missed | z.missed);
    return met ? near : R_NO_SIGHT;
}

/* Distance along the ray to shortly above the first plane ahead: so far that the plane is still ahead in the numbers of
 * Real, and so near that t of the rest is small. */
static inline double r_camera_planes(const RSurfaces *surfaces, const double p[3], const double d[3]) {
    double nearest = R_NO_SIGHT;
    for (int i = 0; i < surfaces->plane_count; i++) {
        double rise = p[2] - surfaces->height[i], height = nph_abs(rise);
        int ahead = (rise > 0.0 && d[2] < 0.0) || (rise < 0.0 && d[2] > 0.0);
        double keep = height * 0x1p-14 + nph_abs(surfaces->height[i]) * 0x1p-18;
        double t = height > keep ? (height - keep) / nph_abs(d[2]) : 0.0;
        nearest = ahead && t < nearest ? t : nearest;
    }
    return nearest;
}

/* How far the ray is moved before it becomes Real: to what it may meet; 0 inside it, R_NO_SIGHT when there is nothing. */
static inline double r_camera_advance(const RScene *scene, const double p[3], const double d[3], int planes) {
    double box = r_camera_box(scene, p, d), plane = planes ? r_camera_planes(&scene->surfaces, p, d) : R_NO_SIGHT;
    return plane < box ? plane : box;
}

/* What the weight of a sensor's rays is: 1 over the density of their directions, times the cosine for flux. */
static inline Real r_sensor_weight(const RScene *scene) {
    return scene->sensor.kind == NPH_SENSOR_FLUX      ? R(3.14159265358979323846)
           : scene->sensor.kind == NPH_SENSOR_FLUENCE ? R(12.566370614359172954)
                                                      : R(1.0);
}

/* A ray from p along d, of any length, to scene-local space. */
static inline RCameraRay r_camera_start(const RScene *scene, const double p[3], const double along[3], uint32_t word,
                                        int planes) {
    double inverse = 1.0 / nph_sqrt(along[0] * along[0] + along[1] * along[1] + along[2] * along[2]);
    double d[3] = {along[0] * inverse, along[1] * inverse, along[2] * inverse};
    double reach = r_camera_advance(scene, p, d, planes), start = reach < R_NO_SIGHT ? reach : 0.0;
    const double *lo = scene->period_lo, *size = scene->period_size, *inverse_size = scene->period_inverse;
    double x = p[0] + start * d[0], y = p[1] + start * d[1];
    x -= size[0] * nph_floor((x - lo[0]) * inverse_size[0]);
    y -= size[1] * nph_floor((y - lo[1]) * inverse_size[1]);
    RCameraRay ray = {{(Real)x, (Real)y, (Real)(p[2] + start * d[2])},
                      {(Real)d[0], (Real)d[1], (Real)d[2]}, {(Real)p[0], (Real)p[1], (Real)p[2]}, (Real)start, R(1.0),
                      R(-1.0), (int32_t)(((uint64_t)word * (uint64_t)(uint32_t)scene->heroes) >> 32), reach < R_NO_SIGHT};
    return ray;
}

/* Pinhole (perspective 1: the offset on the picture turns the ray) or parallel rays (0: it moves it). planes: whether
 * the scene has any; a constant where a loop over lanes must not look at them. */
static inline RCameraRay r_camera_plain(const RScene *scene, int x, int y, NphWords words, double perspective,
                                        int planes) {
    const NphSensor *sensor = &scene->sensor;
    const double *at = sensor->position, *o = scene->origin, *right = sensor->right, *up = sensor->up;
    const double *forward = sensor->seen;
    double s = sensor->half_size[0] * (2.0 * ((double)x + nph_uniform(words.w0)) / (double)scene->width - 1.0);
    double t = sensor->half_size[1] * (1.0 - 2.0 * ((double)y + nph_uniform(words.w1)) / (double)scene->height);
    if (NPH_BUG(27)) t = -t;
    double offset[3] = {s * right[0] + t * up[0], s * right[1] + t * up[1], s * right[2] + t * up[2]};
    double moves = 1.0 - perspective;
    double p[3] = {at[0] - o[0] + moves * offset[0], at[1] - o[1] + moves * offset[1], at[2] - o[2] + moves * offset[2]};
    double d[3] = {forward[0] + perspective * offset[0], forward[1] + perspective * offset[1],
                   forward[2] + perspective * offset[2]};
    return r_camera_start(scene, p, d, words.w2, planes);
}

/* Equidistant: the angle from the viewing direction grows with the distance from the middle of the picture. */
static inline RCameraRay r_camera_fisheye(const RScene *scene, int x, int y, NphWords words) {
    const NphSensor *sensor = &scene->sensor;
    const double *half = sensor->half_size;
    double s = half[0] * (2.0 * ((double)x + nph_uniform(words.w0)) / (double)scene->width - 1.0);
    double t = half[1] * (1.0 - 2.0 * ((double)y + nph_uniform(words.w1)) / (double)scene->height);
    double r = nph_sqrt(s * s + t * t), rim = half[0] < half[1] ? half[0] : half[1], sine, cosine, p[3], d[3];
    nph_sincos2pi(r * 0.15915494309189533577, &sine, &cosine);
    double across = r > 1e-12 ? sine / r : 1.0;
    for (int a = 0; a < 3; a++) {
        p[a] = sensor->position[a] - scene->origin[a];
        d[a] = cosine * sensor->forward[a] + across * (s * sensor->right[a] + t * sensor->up[a]);
    }
    RCameraRay ray = r_camera_start(scene, p, d, words.w2, scene->surfaces.plane_count > 0);
    ray.weight = r <= rim ? R(1.0) : R(0.0);
    return ray;
}

/* A rectangle that gathers: from its points, cosine distributed around its normal (flux) or in all directions (fluence). */
static inline RCameraRay r_camera_gather(const RScene *scene, int x, int y, NphWords words, NphWords more) {
    const NphSensor *sensor = &scene->sensor;
    double s = sensor->half_size[0] * (2.0 * ((double)x + nph_uniform(words.w0)) / (double)scene->width - 1.0);
    double t = sensor->half_size[1] * (1.0 - 2.0 * ((double)y + nph_uniform(words.w1)) / (double)scene->height);
    double v = nph_uniform(words.w3), turn_sin, turn_cos, p[3], d[3];
    int whole = sensor->kind == NPH_SENSOR_FLUENCE;
    nph_sincos2pi(nph_uniform(more.w0), &turn_sin, &turn_cos);
    double cosine = whole ? 1.0 - 2.0 * v : nph_sqrt(1.0 - v); /* v < 1, so a ray of flux never runs along the plane */
    double across = whole ? 2.0 * nph_sqrt(v * (1.0 - v)) : nph_sqrt(v);
    for (int a = 0; a < 3; a++) {
        p[a] = sensor->position[a] - scene->origin[a] + (s * sensor->right[a] + t * sensor->up[a]);
        d[a] = across * (turn_cos * sensor->right[a] + turn_sin * sensor->up[a]) + cosine * sensor->forward[a];
    }
    RCameraRay ray = r_camera_start(scene, p, d, words.w2, scene->surfaces.plane_count > 0);
    ray.weight = NPH_BUG(19) ? R(1.0) : r_sensor_weight(scene);
    ray.pdf = whole ? R(0.079577471545947667884) : (Real)(cosine * 0.31830988618379067154);
    return ray;
}

static inline void r_camera_ray(const RScene *scene, int x, int y, const RStream *stream, RCameraRay *ray) {
    NphWords words = r_words(stream, 0);
    int kind = scene->sensor.kind;
    if (nph_sensor_gathers((NphSensorKind)kind)) *ray = r_camera_gather(scene, x, y, words, r_words(stream, 1));
    else if (kind == NPH_SENSOR_FISHEYE) *ray = r_camera_fisheye(scene, x, y, words);
    else *ray = r_camera_plain(scene, x, y, words, kind == NPH_SENSOR_PERSPECTIVE ? 1.0 : 0.0, scene->surfaces.plane_count > 0);
}

#endif
