/* SPDX-License-Identifier: Apache-2.0
 *
 * Light that a point sends into the medium close around it. A light sample at a collision at distance r is worth I / r^2,
 * whose square has no mean. So it is shared:
 *     1 / r^2  =  1 / (r0^2 + r^2)  +  g        g = r0^2 / (r^2 (r0^2 + r^2))
 * Collisions take the first term, which is bounded. What g scatters at y towards x, the start of the flight, at distance R,
 *     integral of  v(x -> y) T(x, y) sigma_s(y) p(y) T(y, light) I g / R^2  dy,        v: phase function, or cosine / pi,
 * is found in two ways:
 *   along    once a flight, at a place that need not be a collision (the flight still is under way there with the
 *            probability T, as in emission_lookup.h), drawn by the angle at which the light sees it [Kulla12]: density
 *            P D / ((b - a) r^2 R^2), P that of the direction, D the distance of the light from the ray, a and b the
 *            angles of the ends. Rays that come close to the light, small D, are worth much and rare: 1 / D alone would
 *            have no variance.
 *   around   once a vertex, at a place around the light with density  r0 / (2 pi^2 r^2 (r0^2 + r^2)). It is worth much
 *            where it comes close to the vertex.
 * Each is weighted by its density over the sum of both (the first one's with b - a = pi, so that the weights do not depend
 * on where flights end) [Veach95]: no value then has a pole whose square has no mean. Camera rays know the first way only:
 * the pixel in which the light itself would be seen keeps 1 / D, whose square diverges as the logarithm of D. */
#ifndef NPH_TRANSPORT_NEAR_LOOKUP_H
#define NPH_TRANSPORT_NEAR_LOOKUP_H

#include "transport/emission_lookup.h"
#include "transport/vertex_lookup.h"

/* What a collision leaves to the flights: the value of its light sample is multiplied by r^2 / (r0^2 + r^2). */
static inline void r_far_part(const RLight *light, const RVertex *vertex, RLightSample *sample) {
    if (!(light->near_squared > R(0.0)) || !vertex->phase) return;
    Real squared = sample->distance * sample->distance, part = squared / (light->near_squared + squared);
    for (int c = 0; c < 3; c++) sample->value[c] *= part;
}

/* The part of a flight within media that scatter; far <= near when there is none. */
static inline void r_scattering_span(const RScene *scene, const RFlown *flight, Real *near, Real *far) {
    *near = flight->limit;
    *far = R(0.0);
    for (int m = 0; m < scene->medium_count; m++) {
        const RMedium *medium = &scene->media[m];
        RSpan span = r_clip(medium, flight->p, flight->d, flight->limit);
        int scatters = span.inside & (medium->albedo[0] + medium->albedo[1] + medium->albedo[2] > R(0.0));
        *near = scatters && span.near < *near ? span.near : *near;
        *far = scatters && span.far > *far ? span.far : *far;
    }
}

/* A place along the flight, one over its density, and D. */
typedef struct RNearPlace {
    Real t, inverse, D;
} RNearPlace;

/* Weight of the first way; pdf: P, negative when there is no other. */
static inline Real r_near_along(const RLight *light, Real pdf, Real D, Real R_squared, Real r_squared) {
    Real a = pdf * D * R(6.2831853071795864769) * (light->near_squared + r_squared);
    Real b = r_sqrt(light->near_squared) * R_squared;
    return pdf >= R(0.0) && a + b > R(0.0) ? a / (a + b) : R(1.0);
}

/* The foot may lie far off; places keep to [near, far]. D is held above what rounding makes of it: any D gives a density. */
static inline RNearPlace r_near_place(const RLight *light, const RFlown *flight, Real near, Real far, Real random) {
    Real foot = R(0.0), squared = R(0.0), sine, cosine;
    for (int a = 0; a < 3; a++) foot += (light->position[a] - flight->p[a]) * flight->d[a];
    for (int a = 0; a < 3; a++) {
        Real off = flight->p[a] + foot * flight->d[a] - light->position[a];
        squared += off * off;
    }
    Real least = R(1e-7) * (r_sqrt(light->near_squared) + r_abs(foot));
    Real D = r_max(r_sqrt(squared), least);
    Real first = r_atan2(near - foot, D), last = r_atan2(far - foot, D), angle = first + random * (last - first);
    r_sincos2pi(angle * R(0.15915494309189533577), &sine, &cosine);
    Real u = r_clamp(D * sine / r_max(cosine, R(1e-12)), near - foot, far - foot);
    RNearPlace place = {foot + u, (last - first) * (D * D + u * u) / D, D};
    return place;
}

/* sigma_s p towards the light at p, summed over media: what is scattered per metre of ray. */
static inline void r_scattered_at(const RScene *scene, const Real p[3], const Real d[3], const Real to[3], Real scattered[3]) {
    RAngle angle = r_angle_between(d, to);
    scattered[0] = scattered[1] = scattered[2] = R(0.0);
    for (int m = 0; m < scene->medium_count; m++) {
        const RMedium *medium = &scene->media[m];
        Real density = r_density_at(medium, p);
        if (!(density > R(0.0))) continue;
        Real value = density * r_phase_at(&medium->phase, angle);
        for (int c = 0; c < 3; c++) scattered[c] += medium->sigma[c] * medium->albedo[c] * value;
    }
}

/* What light number `number` adds through one place of the flight; streams: of the place, and of the way to the light. */
static inline void r_near_light(const RScene *scene, const RFlown *flight, int number, const RStream streams[2],
                                NphTally *tally, Real light[3]) {
    const RLight *from = &scene->lights[number];
    RStream stream = streams[0];
    Real near, far, T[3] = {R(1.0), R(1.0), R(1.0)}, p[3], to[3], weight[3], scattered[3], squared = R(0.0);
    light[0] = light[1] = light[2] = R(0.0);
    r_scattering_span(scene, flight, &near, &far);
    if (!(near < far)) return;
    stream.draw = (uint32_t)number << NPH_DRAW_LIGHT_SHIFT;
    RNearPlace place = r_near_place(from, flight, near, far, r_uniform(r_words(&stream, 0).w0));
    for (int a = 0; a < 3; a++) {
        p[a] = flight->p[a] + place.t * flight->d[a];
        to[a] = from->position[a] - p[a];
        squared += to[a] * to[a];
    }
    squared = r_max(squared, R(1e-30));
    Real distance = r_sqrt(squared), part = from->near_squared / (squared * (from->near_squared + squared));
    for (int a = 0; a < 3; a++) to[a] /= distance;
    r_scattered_at(scene, p, flight->d, to, scattered);
    if (!(scattered[0] + scattered[1] + scattered[2] > R(0.0))) return;
    if (scene->surfaces.count > 0 && r_blocked(scene, p, to, distance)) return;
    for (int m = 0; m < scene->medium_count && T[0] + T[1] + T[2] > R(0.0); m++) {
        REvents events = r_events(&streams[1], number, scene->media[m].number);
        r_transmittance(&scene->media[m], p, to, distance, scene, &events, T, tally);
        if (scene->channels == 1) T[1] = T[2] = T[0];
    }
    r_weights_at(scene, flight, place.t, weight);
    part *= r_near_along(from, flight->pdf, place.D, place.t * place.t, squared);
    for (int c = 0; c < 3; c++) light[c] = weight[c] * scattered[c] * T[c] * (from->value[c] * part * place.inverse);
}

/* A place around the light: its direction from there, and r. */
static inline Real r_near_draw(const RLight *light, NphWords words, Real direction[3]) {
    Real sine, cosine, z = R(1.0) - R(2.0) * r_uniform(words.w1), across = r_sqrt(r_max(R(1.0) - z * z, R(0.0)));
    r_sincos2pi(r_uniform(words.w2), &sine, &cosine);
    direction[0] = across * cosine;
    direction[1] = across * sine;
    direction[2] = z;
    r_sincos2pi(R(0.25) * r_uniform(words.w0), &sine, &cosine);
    return r_sqrt(light->near_squared) * (sine / r_max(cosine, R(1e-8)));
}

/* Random words: of the place, and of the two legs. */
typedef struct RNearStreams {
    RStream pick, ways[2];
} RNearStreams;

/* What light number `number` adds to a vertex of this weight through one place around it. */
static inline void r_near_around(const RScene *scene, const RVertex *vertex, const Real weight[3], int number,
                                 const RNearStreams *streams, NphTally *tally, Real light[3]) {
    const RLight *from = &scene->lights[number];
    RStream stream = streams->pick;
    Real away[3], back[3], y[3], to[3], off[3], scattered[3], T[3] = {R(1.0), R(1.0), R(1.0)}, squared = R(0.0);
    light[0] = light[1] = light[2] = R(0.0);
    stream.draw = (uint32_t)number << NPH_DRAW_LIGHT_SHIFT;
    Real r = r_near_draw(from, r_words(&stream, 1), away), largest = R(0.0);
    for (int a = 0; a < 3; a++) {
        y[a] = from->position[a] + r * away[a];
        back[a] = -away[a];
        off[a] = from->position[a] - vertex->p[a];
        to[a] = y[a] - vertex->p[a];
        squared += to[a] * to[a];
    }
    Real length = r_sqrt(r_max(squared, R(1e-30)));
    for (int a = 0; a < 3; a++) to[a] /= length;
    for (int c = 0; c < 3; c++) largest = c < scene->channels ? r_max(largest, weight[c]) : largest;
    Real value = r_vertex_value(vertex, to), pdf = r_vertex_density(scene, vertex, to, value, largest);
    r_scattered_at(scene, y, to, back, scattered);
    if (!(value > R(0.0)) || !(scattered[0] + scattered[1] + scattered[2] > R(0.0))) return;
    if (scene->surfaces.count > 0 && (r_blocked(scene, vertex->p, to, length) || r_blocked(scene, y, back, r))) return;
    for (int m = 0; m < 2 * scene->medium_count && T[0] + T[1] + T[2] > R(0.0); m++) {
        const RMedium *medium = &scene->media[m / 2];
        REvents events = r_events(&streams->ways[m & 1], number, medium->number);
        r_transmittance(medium, m & 1 ? y : vertex->p, m & 1 ? back : to, m & 1 ? r : length, scene, &events, T, tally);
        if (scene->channels == 1) T[1] = T[2] = T[0];
    }
    Real cross[3] = {to[1] * off[2] - to[2] * off[1], to[2] * off[0] - to[0] * off[2], to[0] * off[1] - to[1] * off[0]};
    Real D = r_sqrt(cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]);
    Real part = R(1.0) - r_near_along(from, pdf, D, squared, r * r);
    Real worth = R(19.739208802178717) * r_sqrt(from->near_squared) / r_max(squared, R(1e-30)) * part * value;
    for (int c = 0; c < 3; c++) light[c] = weight[c] * vertex->albedo[c] * T[c] * scattered[c] * (from->value[c] * worth);
}

#endif
