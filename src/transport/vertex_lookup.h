/* SPDX-License-Identifier: Apache-2.0
 *
 * Where a path turns: in a medium, on a surface, or (its light samples only) at a sensor that gathers. What it does with light
 * from a direction n, per steradian, and how it draws directions:
 *   medium            albedo p(d . n)             from p, or from the mixture towards the sun
 *   surface, flux     albedo max(0, cos) / pi     with density cos / pi about the normal
 *   fluence           1 / 4 pi                    evenly */
#ifndef NPH_TRANSPORT_VERTEX_LOOKUP_H
#define NPH_TRANSPORT_VERTEX_LOOKUP_H

#include "transport/lights_lookup.h"
#include "transport/surfaces_lookup.h"

typedef struct RVertex {
    Real p[3], d[3];     /* d: along which it was reached */
    Real n[3];           /* the normal, where there is one */
    Real even;           /* 1 / 4 pi at a sensor for fluence, else 0 */
    const RPhase *phase; /* NULL: a surface or a sensor */
    Real albedo[3];
} RVertex;

static inline void r_vertex_in_medium(const RMedium *medium, const Real p[3], const Real d[3], RVertex *vertex) {
    vertex->phase = &medium->phase;
    vertex->even = R(0.0);
    for (int a = 0; a < 3; a++) {
        vertex->p[a] = p[a];
        vertex->d[a] = d[a];
        vertex->n[a] = R(0.0);
        vertex->albedo[a] = medium->albedo[a];
    }
}

static inline void r_vertex_on_surface(const Real albedo[3], const Real p[3], const Real n[3], const Real d[3],
                                       RVertex *vertex) {
    vertex->phase = NULL;
    vertex->even = R(0.0);
    for (int a = 0; a < 3; a++) {
        vertex->p[a] = p[a];
        vertex->d[a] = d[a];
        vertex->n[a] = n[a];
        vertex->albedo[a] = albedo[a];
    }
}

static inline void r_vertex_at_sensor(const NphSensor *sensor, const Real p[3], const Real d[3], RVertex *vertex) {
    Real white[3] = {R(1.0), R(1.0), R(1.0)};
    Real n[3] = {(Real)sensor->forward[0], (Real)sensor->forward[1], (Real)sensor->forward[2]};
    r_vertex_on_surface(white, p, n, d, vertex);
    if (sensor->kind == NPH_SENSOR_FLUENCE) vertex->even = R(0.079577471545947667884);
}

/* What the vertex passes on of light from direction to, but for the albedo. */
static inline Real r_vertex_value(const RVertex *vertex, const Real to[3]) {
    if (vertex->phase) return r_phase_at(vertex->phase, r_angle_between(vertex->d, to));
    if (NPH_BUG(28)) return R(0.31830988618379067);
    return vertex->even > R(0.0) ? vertex->even : r_lambert_density(r_dot(vertex->n, to));
}

/* The density with which a path of this weight draws that direction; value: r_vertex_value. */
static inline Real r_vertex_density(const RScene *scene, const RVertex *vertex, const Real to[3], Real value,
                                    Real weight) {
    return vertex->phase ? r_scatter_density(scene, vertex->phase, vertex->d, to, weight) : value;
}

/* A new direction. */
static inline RTurned r_vertex_turn(const RScene *scene, const RVertex *vertex, NphWords words, Real weight) {
    if (vertex->phase) return r_turn_any(scene, vertex->phase, vertex->d, words, weight);
    RTurned turned = {{R(0.0), R(0.0), R(0.0)}, R(0.0), R(1.0), R(1.0)};
    r_lambert_sample(vertex->n, r_uniform(words.w0), r_uniform(words.w1), turned.d);
    turned.pdf = r_lambert_density(r_dot(vertex->n, turned.d));
    return turned;
}

#endif
