/* SPDX-License-Identifier: Apache-2.0
 *
 * Photons on their way into the box around all media, and about how much power every light sends there:
 *   sun, environment, constant   direction w by the light's own density p_l; then a point, uniform on what the light sees
 *                                of the box: L / p_l A(w), A(w) = sum over its faces of area times |cos|
 *   point                        direction uniform in the cone around the box, all around inside it: I times solid angle */
#ifndef NPH_TRANSPORT_ENTRY_LOOKUP_H
#define NPH_TRANSPORT_ENTRY_LOOKUP_H

#include "transport/camera_lookup.h"
#include "transport/lights_lookup.h"

#define R_TWO_PI R(6.2831853071795865)

typedef struct REntry {
    Real p[3], d[3], flux[3]; /* flux: W, were it the light's only photon */
    int32_t hero;
} REntry;

/* Area of the box seen along d, times |cos| of each face: by axis. */
static inline double r_box_areas(const RScene *scene, const double d[3], double areas[3]) {
    double size[3], sum = 0.0;
    for (int a = 0; a < 3; a++) size[a] = scene->bounds_hi[a] - scene->bounds_lo[a];
    for (int a = 0; a < 3; a++) sum += areas[a] = nph_abs(d[a]) * size[(a + 1) % 3] * size[(a + 2) % 3];
    return sum;
}

/* A point of the box's surface where rays along d enter. */
static inline void r_box_point(const RScene *scene, const double d[3], const double u[3], double p[3]) {
    double areas[3], choice = u[0] * r_box_areas(scene, d, areas);
    int axis = choice < areas[0] ? 0 : choice < areas[0] + areas[1] ? 1 : 2;
    for (int a = 0; a < 3; a++) {
        double lo = scene->bounds_lo[a], hi = scene->bounds_hi[a];
        double v = a == (axis + 1) % 3 ? u[1] : u[2];
        p[a] = a == axis ? (d[a] > 0.0 ? lo : hi) : lo + v * (hi - lo);
    }
}

static inline double r_luminance_of(const Real c[3]) {
    return 0.2126 * (double)c[0] + 0.7152 * (double)c[1] + 0.0722 * (double)c[2];
}

/* The power of a light that enters the box (a quarter of its surface is what it shows from all sides in the mean); from: set to
 * the directions in which a constant light is looked for, and a point's photons leave. */
static inline double r_entry_power(const RScene *local, const NphLight *source, int number, RDisc *from) {
    const RLight *light = &local->lights[number];
    double size[3], direction[3], areas[3], axis[3], squared = 0.0, distance = 0.0;
    for (int a = 0; a < 3; a++) {
        size[a] = local->bounds_hi[a] - local->bounds_lo[a];
        direction[a] = source->direction[a];
        axis[a] = -(double)light->position[a];
        squared += 0.25 * size[a] * size[a];
        distance += axis[a] * axis[a];
    }
    double mean = 0.5 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]);
    if (light->kind == NPH_LIGHT_SUN) {
        Real irradiance[3] = {(Real)source->irradiance[0], (Real)source->irradiance[1], (Real)source->irradiance[2]};
        return r_luminance_of(irradiance) * r_box_areas(local, direction, areas);
    }
    if (light->kind == NPH_LIGHT_ENVIRONMENT) return source->map.total * mean;
    double width = light->kind == NPH_LIGHT_CONSTANT && light->hemisphere != 0 ? 1.0 : 2.0;
    if (light->kind == NPH_LIGHT_POINT && distance > squared) {
        double sine = nph_sqrt(squared / distance);
        width = squared / distance / (1.0 + nph_sqrt(1.0 - sine * sine));
    }
    double length = nph_sqrt(distance), up[3] = {0.0, 0.0, light->hemisphere < 0 ? -1.0 : 1.0};
    for (int a = 0; a < 3; a++)
        from->axis[a] = (Real)(light->kind == NPH_LIGHT_POINT && length > 0.0 ? axis[a] / length : up[a]);
    from->width = (Real)width;
    from->density = (Real)(0.15915494309189535 / width);
    return r_luminance_of(light->value) * 6.283185307179586 * width * (light->kind == NPH_LIGHT_POINT ? 1.0 : mean);
}

/* A direction towards the light (of a point: from it to the media), and radiance over its density. */
static inline void r_entry_direction(const RLight *light, const RDisc *from, NphWords words, Real d[3], Real value[3]) {
    Real u = r_uniform(words.w1), v = r_uniform(words.w2), scale = R(1.0);
    for (int c = 0; c < 3; c++) value[c] = light->value[c];
    if (light->kind == NPH_LIGHT_ENVIRONMENT) {
        Real density = r_environment_sample(&light->map, u, v, d, value);
        scale = density > R(0.0) ? R(1.0) / density : R(0.0);
    } else if (light->kind == NPH_LIGHT_SUN && !(light->disc.width > R(0.0))) {
        for (int a = 0; a < 3; a++) d[a] = light->direction[a];
    } else {
        const RDisc *disc = light->kind == NPH_LIGHT_SUN ? &light->disc : from;
        r_disc_sample(disc, u, v, d);
        scale = R_TWO_PI * disc->width;
    }
    for (int c = 0; c < 3; c++) value[c] *= scale;
}

/* One photon of light `number`, chosen with probability `chance`; words: w1 to w3, and w0 to w2 of the next block. */
static inline REntry r_entry(const RScene *local, int number, double chance, const RDisc *from, NphWords words, NphWords more) {
    double weight = 1.0 / chance, p[3], along[3];
    Real d[3], value[3];
    const RLight *light = &local->lights[number];
    r_entry_direction(light, from, words, d, value);
    if (light->kind == NPH_LIGHT_POINT) {
        for (int a = 0; a < 3; a++) {
            p[a] = (double)light->position[a];
            along[a] = (double)d[a];
        }
    } else {
        double u[3] = {nph_uniform(words.w3), nph_uniform(more.w0), nph_uniform(more.w1)}, areas[3];
        for (int a = 0; a < 3; a++) along[a] = -(double)d[a];
        weight *= r_box_areas(local, along, areas);
        r_box_point(local, along, u, p);
    }
    RCameraRay ray = r_camera_start(local, p, along, more.w2, 0);
    REntry start;
    for (int a = 0; a < 3; a++) {
        start.p[a] = ray.p[a];
        start.d[a] = ray.d[a];
        start.flux[a] = (Real)(weight * (double)value[a]);
    }
    start.hero = ray.hero;
    return start;
}

#endif
