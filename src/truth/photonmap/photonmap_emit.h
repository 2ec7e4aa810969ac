/* SPDX-License-Identifier: Apache-2.0
 *
 * Where photons start. A light is chosen with a probability near its share of the power that enters the box around all
 * media; the photon carries what it stands for, over that probability [Jensen98]:
 *   sun, environment, constant   direction w by the light's own density p_l; then a point, uniform on what the light sees
 *                                of the box: L / p_l A(w), A(w) = sum over its faces of area times |cos|
 *   point                        direction uniform in the cone around the box, all around inside it: I times solid angle
 * The mean over photons of carried power is so the power that enters the box. */
#ifndef NPH_TRUTH_PHOTONMAP_EMIT_H
#define NPH_TRUTH_PHOTONMAP_EMIT_H

#include "transport/camera_lookup.h"
#include "transport/lights_lookup.h"
#include "truth/photonmap/photonmap_state.h"

typedef struct RPhotonStart {
    Real p[3], d[3], flux[3];
    int32_t hero;
} RPhotonStart;

#define R_TWO_PI R(6.2831853071795865)

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

/* A direction towards the light (of a point: from it to the media), and radiance over its density. */
static inline void r_emit_direction(const RPhotonScene *scene, int number, NphWords words, Real d[3], Real value[3]) {
    const RLight *light = &scene->local.lights[number];
    Real u = r_uniform(words.w1), v = r_uniform(words.w2), scale = R(1.0);
    for (int c = 0; c < 3; c++) value[c] = light->value[c];
    if (light->kind == NPH_LIGHT_ENVIRONMENT) {
        Real density = r_environment_sample(&light->map, u, v, d, value);
        scale = density > R(0.0) ? R(1.0) / density : R(0.0);
    } else if (light->kind == NPH_LIGHT_SUN && !(light->disc.width > R(0.0))) {
        for (int a = 0; a < 3; a++) d[a] = light->direction[a];
    } else {
        const RDisc *disc = light->kind == NPH_LIGHT_SUN ? &light->disc : &scene->from[number];
        r_disc_sample(disc, u, v, d);
        scale = R_TWO_PI * disc->width;
    }
    for (int c = 0; c < 3; c++) value[c] *= scale;
}

static inline RPhotonStart r_emit(const RPhotonScene *scene, const RStream *stream) {
    const RScene *local = &scene->local;
    NphWords words = r_words(stream, 0), more = r_words(stream, 1);
    int number = r_cdf_find(scene->choose, local->light_count, nph_uniform(words.w0));
    double weight = 1.0 / (scene->choose[number + 1] - scene->choose[number]), p[3], along[3];
    Real d[3], value[3];
    r_emit_direction(scene, number, words, d, value);
    const RLight *light = &local->lights[number];
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
    RPhotonStart start;
    for (int a = 0; a < 3; a++) {
        start.p[a] = ray.p[a];
        start.d[a] = ray.d[a];
        start.flux[a] = (Real)(weight * (double)value[a]);
    }
    start.hero = ray.hero;
    return start;
}

#endif
