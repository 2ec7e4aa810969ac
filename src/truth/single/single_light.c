/* SPDX-License-Identifier: Apache-2.0
 *
 * Lights as one sample of a ray meets them. Suns without a disc and points are one beam each. A light that has a
 * size gives one direction a ray and place (medium or surface), drawn by the light's own sampling or, as often, by
 * the phase functions or Lambert's cosine, weighed by the balance heuristic [Veach95]. The cosine between ray and
 * direction is the same all along the ray, so a phase function's peak costs no variance; constant lights are drawn
 * by it alone. */
#include <string.h>

#include "transport/vertex_lookup.h"
#include "truth/single/single_quadrature.h"

/* The density of direction n among those that draw_turn draws: each medium as often as any other. */
static double turn_density(const RScene *local, const double d[3], const double *normal, const double n[3]) {
    if (normal) return r_lambert_density(r_dot(normal, n));
    double sum = 0.0;
    for (int i = 0; i < local->medium_count; i++) sum += r_phase_at(&local->media[i].phase, r_angle_between(d, n));
    return sum / (double)local->medium_count;
}

static void draw_turn(const RScene *local, const double d[3], const double *normal, double choice, NphWords words,
                      double n[3]) {
    double u = nph_uniform(words.w0), w = nph_uniform(words.w1);
    if (normal) {
        r_lambert_sample(normal, u, w, n);
        return;
    }
    int i = (int)(choice * (double)local->medium_count);
    const RPhase *phase = &local->media[i < local->medium_count ? i : local->medium_count - 1].phase;
    r_turn_by(d, r_phase_angle(phase, u, nph_uniform(words.w3)), w, n);
}

/* Radiance over density. Words: two for the direction, one for the technique and then the medium, one for the lobe. */
static void draw_direction(const RScene *local, const double d[3], const double *normal, NphWords words,
                           NphBeam *beam) {
    const RLight *light = &local->lights[beam->light];
    double u = nph_uniform(words.w0), w = nph_uniform(words.w1), choice = nph_uniform(words.w2),
           value[3] = {0.0, 0.0, 0.0};
    double density;
    if (light->kind == NPH_LIGHT_SUN) {
        r_disc_sample(&light->disc, u, w, beam->d);
        for (int c = 0; c < 3; c++) beam->value[c] = light->value[c] / light->disc.density;
        return;
    }
    if (light->kind == NPH_LIGHT_CONSTANT) {
        draw_turn(local, d, normal, choice, words, beam->d);
        density = turn_density(local, d, normal, beam->d);
        int seen = light->hemisphere == 0 || beam->d[2] * (double)light->hemisphere > 0.0;
        for (int c = 0; c < 3; c++) value[c] = seen ? light->value[c] : 0.0;
    } else {
        if (choice < 0.5)
            density = r_environment_sample(&light->map, u, w, beam->d, value);
        else {
            draw_turn(local, d, normal, 2.0 * choice - 1.0, words, beam->d);
            density = r_environment_lookup(&light->map, beam->d, value);
        }
        density = 0.5 * (density + turn_density(local, d, normal, beam->d));
    }
    for (int c = 0; c < 3; c++) beam->value[c] = density > 0.0 ? value[c] / density : 0.0;
}

void nph_single_beam(const NphSingleScene *scene, const RCameraRay *ray, const NphSingleAsk *ask, int l,
                     const double *normal, NphBeam *beam) {
    const RScene *local = &scene->local;
    const RLight *light = &local->lights[l];
    memset(beam, 0, sizeof *beam);
    beam->light = l;
    beam->point = light->kind == NPH_LIGHT_POINT;
    for (int c = 0; c < 3; c++) {
        beam->value[c] = light->kind == NPH_LIGHT_SUN ? scene->beam[l][c] : light->value[c];
        beam->d[c] = light->direction[c];
        beam->position[c] = light->position[c];
    }
    int sized = !beam->point && (light->kind != NPH_LIGHT_SUN || light->disc.width > 0.0);
    if (sized && scene->mode != NPH_SINGLE_BLINN) {
        RStream stream = r_stream(local, NPH_RNG_LIGHT, ask->pixel, ask->sample, 1);
        stream.draw = (uint32_t)l << NPH_DRAW_LIGHT_SHIFT;
        draw_direction(local, ray->d, normal, r_words(&stream, normal ? 1 : 0), beam);
    }
    for (int i = 0; i < local->medium_count && !beam->point; i++)
        beam->phase[i] = r_phase_at(&local->media[i].phase, r_angle_between(ray->d, beam->d));
}
