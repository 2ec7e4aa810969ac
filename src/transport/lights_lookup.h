/* SPDX-License-Identifier: Apache-2.0
 *
 * Lights as a path meets them: by chance at infinity, and by a light sample at a vertex. */
#ifndef NPH_TRANSPORT_LIGHTS_LOOKUP_H
#define NPH_TRANSPORT_LIGHTS_LOOKUP_H

#include "transport/flight_lookup.h"

/* The angle between unit vectors: 1 - cos = |a - b|^2 / 2 and 1 + cos = |a + b|^2 / 2, without cancellation. */
R_INLINE RAngle r_angle_between(const Real a[3], const Real b[3]) {
    Real x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    Real u = a[0] + b[0], v = a[1] + b[1], w = a[2] + b[2];
    RAngle angle = {a[0] * b[0] + a[1] * b[1] + a[2] * b[2], R(0.5) * (x * x + y * y + z * z),
                    R(0.5) * (u * u + v * v + w * w)};
    return angle;
}

/* Directions are drawn from the mixture (1 - m) p(d, n) + m p(s, n): the phase function around the path's direction d and
 * around the direction s of the sun, by one-sample MIS [Veach95]. Then a light sample of the next vertex, p(n, s), meets a
 * weight that is small where p(n, s) is large, and no vertex adds more than about p(d, n) / m. The fraction
 *   m = part p(d, s) / (p(d, s) + 0.4 / 4 pi)
 * is small where the sun is not in the path's view, and `part` falls with W^-4 once the throughput W is above that of a
 * camera ray: weights of many scatterings, products of up to 1 / (1 - m), stop growing. */
static inline Real r_part_of(Real part, Real weight, Real unit) {
    Real w = r_max(weight * unit, R(1.0)), squared = w * w;
    return part / (squared * squared);
}

static inline Real r_guide_part(Real part, Real towards) { return part * towards / (towards + R(0.031830988618379067)); }

/* Density of direction n at a vertex that is reached along d: of the phase function, or of the mixture. */
static inline Real r_scatter_density(const RScene *scene, const RPhase *phase, const Real d[3], const Real n[3],
                                     Real weight) {
    Real density = r_phase_at(phase, r_angle_between(d, n));
    if (scene->guide < 0) return density;
    const Real *sun = scene->lights[scene->guide].direction;
    Real part = r_part_of(scene->guide_part, weight, scene->weight_unit);
    Real m = r_guide_part(part, r_phase_at(phase, r_angle_between(d, sun)));
    return (R(1.0) - m) * density + m * r_phase_at(phase, r_angle_between(sun, n));
}

/* A direction from the mixture: weight = p(d, n) / pdf; peak = 4 pi p(n, s) or 1, whichever is larger, tells roulette
 * how much brighter than isotropic the next light sample may be. */
typedef struct RTurned {
    Real d[3], pdf, weight, peak;
} RTurned;

R_INLINE RTurned r_turn_guided(const RPhase *phase, const Real d[3], const Real sun[3], Real part, NphWords words) {
    Real m = r_guide_part(part, r_phase_at(phase, r_angle_between(d, sun))), lobe = r_uniform(words.w2);
    int guided = lobe < m;
    Real rest = guided ? lobe / m : (lobe - m) / (R(1.0) - m); /* uniform again */
    Real around[3] = {guided ? sun[0] : d[0], guided ? sun[1] : d[1], guided ? sun[2] : d[2]};
    Real beside[3] = {guided ? d[0] : sun[0], guided ? d[1] : sun[1], guided ? d[2] : sun[2]}, n[3];
    RAngle angle = r_phase_angle(phase, r_uniform(words.w0), rest);
    r_turn_by(around, angle, r_uniform(NPH_BUG(21) ? words.w0 : words.w1), n);
    Real drawn = r_phase_at(phase, angle), other = r_phase_at(phase, r_angle_between(beside, n));
    Real own = guided ? other : drawn, towards = guided ? drawn : other;
    Real pdf = (R(1.0) - m) * own + m * towards, bright = towards * R(12.566370614359173);
    RTurned turned = {{n[0], n[1], n[2]}, pdf, NPH_BUG(30) ? R(1.0) : own / pdf, bright > R(1.0) ? bright : R(1.0)};
    return turned;
}

/* Without a sun to look for. */
R_INLINE RTurned r_turn_plain(const RPhase *phase, const Real d[3], NphWords words) {
    Real n[3];
    RAngle angle = r_phase_angle(phase, r_uniform(words.w0), r_uniform(words.w2));
    r_turn_by(d, angle, r_uniform(NPH_BUG(21) ? words.w0 : words.w1), n);
    RTurned turned = {{n[0], n[1], n[2]}, r_phase_at(phase, angle), R(1.0), R(1.0)};
    return turned;
}

static inline RTurned r_turn_any(const RScene *scene, const RPhase *phase, const Real d[3], NphWords words, Real weight) {
    if (scene->guide < 0) return r_turn_plain(phase, d, words);
    Real part = r_part_of(scene->guide_part, weight, scene->weight_unit);
    return r_turn_guided(phase, d, scene->lights[scene->guide].direction, part, words);
}

/* The chance to survive of a path of this throughput: keeps weight * peak from falling far below `roulette`. */
static inline Real r_survival(Real roulette, Real weight, Real peak) {
    Real value = weight * peak;
    return value < roulette ? value / (R(2.0) * roulette) : R(1.0);
}

/* The chance that a light sample is made whose throughput times phase function is `weight`. */
static inline Real r_light_chance(Real least, Real weight) { return weight < least ? weight / least : R(1.0); }

/* The balance heuristic's weight of density a against b; a negative a stands for certainty. */
static inline Real r_balance(Real a, Real b) { return a < R(0.0) ? R(1.0) : a / (a + b); }

/* Whether a direction can meet a light at infinity at all: all but points and suns without a disc. */
static inline int r_light_is_met(const RLight *light) {
    int met = light->kind == NPH_LIGHT_CONSTANT || light->kind == NPH_LIGHT_ENVIRONMENT;
    return met || (light->kind == NPH_LIGHT_SUN && light->disc.width > R(0.0));
}

static inline int r_lights_are_met(const RScene *scene) {
    int met = 0;
    for (int l = 0; l < scene->light_count; l++) met |= r_light_is_met(&scene->lights[l]);
    return met;
}

/* Adds the radiance from direction d of all lights at infinity, each with its weight. */
static inline void r_lights_at_infinity(const RScene *scene, const Real d[3], Real pdf, Real radiance[3]) {
    for (int l = 0; l < scene->light_count; l++) {
        const RLight *light = &scene->lights[l];
        Real value[3] = {R(0.0), R(0.0), R(0.0)}, weight = R(1.0);
        if (light->kind == NPH_LIGHT_CONSTANT) {
            Real up = NPH_BUG(26) ? -d[2] : d[2];
            Real seen = light->hemisphere == 0 || up * (Real)light->hemisphere > R(0.0) ? R(1.0) : R(0.0);
            for (int c = 0; c < 3; c++) value[c] = light->value[c] * seen;
        } else if (light->kind == NPH_LIGHT_ENVIRONMENT) {
            Real density = r_environment_lookup(&light->map, d, value);
            weight = light->sampled && !NPH_BUG(7) ? r_balance(pdf, density) : R(1.0);
        } else if (light->kind == NPH_LIGHT_SUN && light->disc.width > R(0.0)) {
            Real seen = r_disc_holds(&light->disc, d) ? R(1.0) : R(0.0);
            for (int c = 0; c < 3; c++) value[c] = light->value[c] * seen;
            weight = light->sampled ? r_balance(pdf, light->disc.density) : R(1.0);
        }
        for (int c = 0; c < 3; c++) radiance[c] += weight * value[c];
    }
}

/* A light sample: direction, how far the light is, and radiance over density (intensity / r^2 for a point, irradiance
 * for a delta sun). pdf is negative for lights that no other technique can find. */
typedef struct RLightSample {
    Real d[3], distance, value[3], pdf;
    Real chance; /* a random number for r_light_chance */
} RLightSample;

static inline void r_sample_light(const RLight *light, const Real p[3], const RStream *stream, RLightSample *sample) {
    NphWords words = r_words(stream, 0);
    sample->distance = R_HUGE;
    sample->chance = r_uniform(words.w2);
    sample->pdf = R(-1.0);
    for (int c = 0; c < 3; c++) sample->value[c] = light->value[c];
    if (light->kind == NPH_LIGHT_POINT) {
        Real d[3] = {light->position[0] - p[0], light->position[1] - p[1], light->position[2] - p[2]};
        Real squared = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        squared = r_max(squared, R(1e-30));
        sample->distance = r_sqrt(squared);
        for (int a = 0; a < 3; a++) sample->d[a] = d[a] / sample->distance;
        if (NPH_BUG(18)) squared = R(1.0);
        if (NPH_BUG(20)) sample->distance = R_HUGE;
        for (int c = 0; c < 3; c++) sample->value[c] = light->value[c] / squared;
    } else if (light->kind == NPH_LIGHT_ENVIRONMENT) {
        sample->pdf = r_environment_sample(&light->map, r_uniform(words.w0), r_uniform(words.w1), sample->d, sample->value);
        for (int c = 0; c < 3; c++) sample->value[c] = sample->pdf > R(0.0) ? sample->value[c] / sample->pdf : R(0.0);
    } else if (light->disc.width > R(0.0)) {
        r_disc_sample(&light->disc, r_uniform(words.w0), r_uniform(words.w1), sample->d);
        sample->pdf = light->disc.density;
        for (int c = 0; c < 3; c++) sample->value[c] = light->value[c] / light->disc.density;
    } else {
        for (int a = 0; a < 3; a++) sample->d[a] = light->direction[a];
    }
}

#endif
