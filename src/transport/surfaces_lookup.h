/* SPDX-License-Identifier: Apache-2.0
 *
 * Surfaces on the way of a ray: what it meets first, and whether anything stands between two points. Opaque, Lambertian
 * on both sides.
 *
 * Nothing that goes on starts in a surface: light leaves it from a point `clear` above it (geometry/surface_lookup.h),
 * on the side from which the ray came. A flight through media ends there too, at
 *     limit = t - clear / cos,
 * so that no collision can come to lie behind the surface by rounding: media are left out within `clear` of surfaces,
 * a few units of rounding of the triangle's size, in both directions alike.
 *
 * Rays meet nothing beyond R_SIGHT: a level ray does so above a plane, for what that is worth. */
#ifndef NPH_TRANSPORT_SURFACES_LOOKUP_H
#define NPH_TRANSPORT_SURFACES_LOOKUP_H

#include "transport/local_scene.h"

#define R_SIGHT R(1e15) /* m; its square is a float */

typedef struct RMet {
    Real t;          /* of the surface, along a unit direction */
    Real limit;      /* of flights through media; at least 0 */
    Real p[3], n[3]; /* where light goes on, and the normal on that side: d . n <= 0 */
    int surface;     /* its place in scene->surfaces */
} RMet;

/* The surface that a triangle belongs to. */
static inline int r_surface_of(const RSurfaces *surfaces, int32_t triangle) {
    int mesh = 0;
    while (triangle >= surfaces->mesh_first[mesh + 1]) mesh++;
    return surfaces->mesh_surface[mesh];
}

static inline void r_meet(const RSurfacePoint *point, const Real d[3], Real t, RMet *met) {
    Real along = r_dot(point->n, d), side = along > R(0.0) ? R(-1.0) : R(1.0);
    Real limit = t - point->clear / r_abs(along);
    for (int a = 0; a < 3; a++) {
        met->n[a] = side * point->n[a];
        met->p[a] = point->p[a] + point->clear * met->n[a];
    }
    met->t = t;
    met->limit = limit > R(0.0) ? limit : R(0.0);
}

/* 1 and what the ray from p along the unit direction d meets first within limit; of a mesh and a plane at the same t the
 * mesh. */
static inline int r_closest_surface(const RScene *scene, const Real p[3], const Real d[3], Real limit, RMet *met) {
    const RSurfaces *surfaces = &scene->surfaces;
    Real nearest = limit < R_SIGHT ? limit : R_SIGHT, t;
    int plane = -1;
    RHit hit = {R(0.0), {R(0.0), R(0.0)}, -1, -1};
    RSurfacePoint point;
    met->surface = -1;
    if (surfaces->bvh.nodes) {
        RRay ray = r_ray(p, d);
        if (r_bvh_closest(&surfaces->bvh, &ray, nearest, &hit)) nearest = hit.t;
    }
    for (int i = 0; i < surfaces->plane_count; i++) {
        if (!r_plane_hit(&surfaces->planes[i], p, d, nearest, &t) || (t == nearest && hit.number >= 0)) continue;
        nearest = t;
        plane = i;
    }
    if (plane < 0 && hit.number < 0) return 0;
    if (plane >= 0) point = r_plane_point(&surfaces->planes[plane], p, d, nearest);
    else point = r_bvh_point(&surfaces->bvh, &hit);
    met->surface = plane >= 0 ? surfaces->plane_surface[plane] : r_surface_of(surfaces, hit.number);
    r_meet(&point, d, nearest, met);
    return 1;
}

/* 1 when a surface lies on the way from p along d within limit. */
static inline int r_blocked(const RScene *scene, const Real p[3], const Real d[3], Real limit) {
    const RSurfaces *surfaces = &scene->surfaces;
    Real reach = limit < R_SIGHT ? limit : R_SIGHT, t;
    for (int i = 0; i < surfaces->plane_count; i++)
        if (r_plane_hit(&surfaces->planes[i], p, d, reach, &t)) return 1;
    if (!surfaces->bvh.nodes) return 0;
    RRay ray = r_ray(p, d);
    return r_bvh_any(&surfaces->bvh, &ray, reach);
}

#endif
