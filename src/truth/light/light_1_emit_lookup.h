/* SPDX-License-Identifier: Apache-2.0
 *
 * Emission of photons. A light is chosen with probability P_l, then
 *   point     direction uniform over the sphere                         weight 4 pi I / (N P_l)
 *   medium    place x drawn by a bound of j [W/m3/sr], density q(x)     weight 4 pi j / q / (N P)
 *   infinity  direction d of travel, with density q(d) (delta sun: none), then a position
 * Light from infinity crosses every plane; the power per solid angle and per area perpendicular to d is L (E for a delta).
 * Where everything has ends, positions are uniform over the box of media and meshes as seen along d: a face that faces
 * the light, with probability in proportion to its projected area A_i = |d_i| (product of its sides):
 *   weight = L / q sum A_i / (N P_l)
 * Layers and planes have no end. There photons are aimed at points x of one horizontal plane (z = level), drawn from a
 * mixture m(x) of the shadow of the box, and of uniform directions from the sensor's and the box's middle, at heights h
 * above the plane: h / (2 pi |x - foot|_h^3). With the latter, what a distant part of a plane sends to the sensor does not
 * depend on how far it is.
 *   weight = L |d_z| / (q m(x)) / (N P_l)
 * Where nothing changes along x and y the sensor's rectangle may stand for any of its copies: x is uniform over one
 * cell of their lattice, of the area A_h, and 1 / m = A_h. */
#ifndef NPH_TRUTH_LIGHT_1_EMIT_LOOKUP_H
#define NPH_TRUTH_LIGHT_1_EMIT_LOOKUP_H

#include "truth/light/light_state.h"

static const double r_two_pi = 6.28318530717958647693;

/* Where the line x + t d meets the box: 0 when it does not. */
static inline int r_aim_box(const NphLightAim *aim, const double x[3], const double d[3], double *enter) {
    double near = -1e300, far = 1e300;
    for (int a = 0; a < 3; a++) {
        if (nph_abs(d[a]) < 1e-300) {
            if (x[a] < aim->lo[a] || x[a] > aim->hi[a]) return 0;
            continue;
        }
        double t0 = (aim->lo[a] - x[a]) / d[a], t1 = (aim->hi[a] - x[a]) / d[a];
        double first = t0 < t1 ? t0 : t1, last = t0 < t1 ? t1 : t0;
        near = first > near ? first : near;
        far = last < far ? last : far;
    }
    *enter = near;
    return near <= far;
}

/* Area of the box perpendicular to d; parts: of its three faces towards the light. */
static inline double r_aim_area(const NphLightAim *aim, const double d[3], double parts[3]) {
    double side[3] = {aim->hi[0] - aim->lo[0], aim->hi[1] - aim->lo[1], aim->hi[2] - aim->lo[2]};
    for (int a = 0; a < 3; a++) parts[a] = nph_abs(d[a]) * side[(a + 1) % 3] * side[(a + 2) % 3];
    return parts[0] + parts[1] + parts[2];
}

/* A point of the box's faces towards the light; 0 when it has no area in this direction. */
static inline double r_aim_at_box(const NphLightAim *aim, const double d[3], NphWords words, double x[3]) {
    double parts[3], area = r_aim_area(aim, d, parts), at = nph_uniform(words.w0) * area;
    int face = at < parts[0] ? 0 : at < parts[0] + parts[1] ? 1 : 2;
    double u[3] = {nph_uniform(words.w1), nph_uniform(words.w2), 0.0};
    for (int k = 1; k < 3; k++) {
        int a = (face + k) % 3;
        x[a] = aim->lo[a] + u[k - 1] * (aim->hi[a] - aim->lo[a]);
    }
    x[face] = d[face] > 0.0 ? aim->lo[face] : aim->hi[face];
    return area;
}

/* Density per area of the level, at x, of uniform directions from a height above a foot. */
static inline double r_aim_foot(const double foot[3], const double x[3]) {
    double u = x[0] - foot[0], v = x[1] - foot[1], h = foot[2], squared = u * u + v * v + h * h;
    return h / (r_two_pi * squared * nph_sqrt(squared));
}

/* A point of the level from the mixture, and 1 / its density; 0 when the light does not cross the level. */
static inline double r_aim_at_level(const NphLightAim *aim, const double d[3], NphWords words, double x[3]) {
    double parts[3], area = aim->box ? r_aim_area(aim, d, parts) : 0.0, steep = nph_abs(d[2]), enter;
    double shadow = area > 0.0 ? 0.4 : 0.0, rest = 1.0 - shadow, pick = nph_uniform(words.w3), cosine, turn_sin, turn_cos;
    double share[2] = {aim->box ? 0.5 * rest : rest, aim->box ? 0.5 * rest : 0.0};
    if (!(steep > 1e-6)) return 0.0;
    if (pick < shadow) {
        r_aim_at_box(aim, d, words, x);
        double t = (aim->level - x[2]) / d[2];
        for (int a = 0; a < 2; a++) x[a] += t * d[a];
    } else {
        const double *foot = aim->centre[pick < shadow + share[0] ? 0 : 1];
        cosine = 1.0 - nph_uniform(words.w0); /* above 0 */
        nph_sincos2pi(nph_uniform(words.w1), &turn_sin, &turn_cos);
        double away = foot[2] * nph_sqrt(1.0 - cosine * cosine) / cosine;
        x[0] = foot[0] + away * turn_cos;
        x[1] = foot[1] + away * turn_sin;
    }
    x[2] = aim->level;
    double density = share[0] * r_aim_foot(aim->centre[0], x) + share[1] * r_aim_foot(aim->centre[1], x);
    if (shadow > 0.0 && r_aim_box(aim, x, d, &enter)) density += shadow * steep / area;
    return 1.0 / density;
}

/* Moves x back along d to where nothing has been met yet. */
static inline void r_aim_back(const NphLightAim *aim, const double d[3], double x[3]) {
    double start = 0.0, enter, size = aim->centre[0][2];
    if (aim->box && r_aim_box(aim, x, d, &enter) && enter < start) start = enter;
    if (aim->unbounded) {
        double t0 = (aim->slab[0] - x[2]) / d[2], t1 = (aim->slab[1] - x[2]) / d[2];
        double first = t0 < t1 ? t0 : t1;
        if (nph_abs(d[2]) > 1e-6 && first < start) start = first;
    }
    start -= 1e-3 * size / (nph_abs(d[2]) > 1e-6 && aim->unbounded ? nph_abs(d[2]) : 1.0); /* surfaces may lie in the box's faces, and planes at the slab's ends */
    for (int a = 0; a < 3; a++) x[a] += start * d[a];
}

/* A position for light travelling along d: returns the area it stands for, perpendicular to d. */
static inline double r_aim_position(const NphLightAim *aim, const double d[3], NphWords words, double x[3]) {
    double area;
    if (aim->wrapped) {
        double u = nph_uniform(words.w0) - 0.5, v = nph_uniform(words.w1) - 0.5;
        for (int a = 0; a < 2; a++) x[a] = aim->centre[0][a] + aim->steps[a][0] * u + aim->steps[a][1] * v;
        x[2] = aim->level;
        area = nph_abs(d[2]) > 1e-6 ? aim->area * nph_abs(d[2]) : 0.0;
    } else if (aim->unbounded && nph_abs(d[2]) > 1e-6) {
        area = r_aim_at_level(aim, d, words, x) * nph_abs(d[2]);
    } else {
        area = aim->box ? r_aim_at_box(aim, d, words, x) : 0.0;
    }
    if (area > 0.0) r_aim_back(aim, d, x);
    return area;
}

/* Uniform over the sphere, or the half of it above (+1) or below (-1). Returns the solid angle. */
static inline double r_uniform_direction(NphWords words, int hemisphere, Real d[3]) {
    double z = hemisphere ? (double)hemisphere * (1.0 - nph_uniform(words.w2)) : 1.0 - 2.0 * nph_uniform(words.w2);
    double across = nph_sqrt(1.0 - z * z), turn_sin, turn_cos;
    nph_sincos2pi(nph_uniform(words.w3), &turn_sin, &turn_cos);
    d[0] = (Real)(across * turn_cos);
    d[1] = (Real)(across * turn_sin);
    d[2] = (Real)z;
    return hemisphere ? r_two_pi : 2.0 * r_two_pi;
}

/* A direction towards a light at infinity and the light over its density. */
static inline void r_towards_infinity(const RLight *light, NphWords words, Real towards[3], Real value[3]) {
    for (int c = 0; c < 3; c++) value[c] = light->value[c];
    if (light->kind == NPH_LIGHT_CONSTANT) {
        Real angle = (Real)r_uniform_direction(words, light->hemisphere, towards);
        for (int c = 0; c < 3; c++) value[c] *= angle;
    } else if (light->kind == NPH_LIGHT_ENVIRONMENT) {
        Real pdf = r_environment_sample(&light->map, r_uniform(words.w2), r_uniform(words.w3), towards, value);
        for (int c = 0; c < 3; c++) value[c] = pdf > R(0.0) ? value[c] / pdf : R(0.0);
    } else if (light->disc.width > R(0.0)) {
        r_disc_sample(&light->disc, r_uniform(words.w2), r_uniform(words.w3), towards);
        for (int c = 0; c < 3; c++) value[c] /= light->disc.density;
    } else {
        for (int a = 0; a < 3; a++) towards[a] = light->direction[a];
    }
}

/* Where the photon begins, and the power it stands for but for the chance of its light; 0 when there is none. */
static inline double r_emit_from(const RLightScene *light_scene, const RStream *stream, int number, RPhoton *photon,
                                 Real value[3]) {
    const RScene *scene = &light_scene->scene;
    const RLight *light = &scene->lights[number];
    NphWords words = r_words(stream, 0), more = r_words(stream, 1);
    double x[3] = {0.0, 0.0, 0.0}, d[3];
    Real towards[3];
    if (number == scene->light_count) {
        r_emission_sample(scene, &light_scene->sources, more, r_words(stream, 2), photon->p, value);
        const double *lo = scene->period_lo, *size = scene->period_size;
        for (int a = 0; a < 2; a++) {
            double at = (double)photon->p[a] - lo[a];
            if (size[a] > 0.0 && (at < 0.0 || at >= size[a])) return 0.0; /* cut off */
        }
        return r_uniform_direction(words, 0, photon->d);
    }
    if (light->kind == NPH_LIGHT_POINT) {
        for (int a = 0; a < 3; a++) {
            photon->p[a] = light->position[a];
            value[a] = light->value[a];
        }
        return r_uniform_direction(words, 0, photon->d);
    }
    r_towards_infinity(light, words, towards, value);
    for (int a = 0; a < 3; a++) d[a] = -(double)towards[a];
    double area = r_aim_position(&light_scene->choice.aim, d, more, x);
    if (!(area > 0.0)) return 0.0;
    for (int a = 0; a < 3; a++) {
        photon->d[a] = -towards[a];
        photon->p[a] = (Real)x[a];
    }
    return area;
}

/* Emits a photon; 0 when it carries nothing. */
static inline int r_emit(const RLightScene *light_scene, const RStream *stream, RPhoton *photon) {
    const RScene *scene = &light_scene->scene;
    const NphLightChoice *choice = &light_scene->choice;
    NphWords words = r_words(stream, 0);
    int number = r_cdf_find(choice->reach, scene->light_count + 1, nph_uniform(words.w0));
    double chance = choice->reach[number + 1] - choice->reach[number];
    Real value[3];
    photon->hero = (int)(((uint64_t)words.w1 * (uint64_t)(uint32_t)scene->channels) >> 32);
    photon->order = 0;
    for (int k = 0; k < 3; k++) photon->p[k] = photon->d[k] = R(0.0);
    photon->source = number;
    double share = r_emit_from(light_scene, stream, number, photon, value) / (chance * (double)choice->photons);
    if (!(share > 0.0)) return 0;
    r_wrap_position(&scene->period, photon->p);
    for (int c = 0; c < 3; c++) {
        photon->weight[c] = value[c] * (Real)share;
        photon->share[c] = R(1.0);
    }
    Real largest = r_largest(scene, photon->weight), mean = (Real)choice->unit;
    photon->unit = largest < mean ? largest : mean; /* a photon from far out stands for much and becomes one of many */
    return photon->unit > R(0.0);
}

#endif
