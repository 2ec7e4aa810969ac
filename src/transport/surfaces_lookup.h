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

#include "transport/air_lookup.h"

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

/* The globe: how far it is along a ray; -1 where it is missed. */
static inline Real r_globe_hit(const RSurfaces *surfaces, const Real p[3], const Real d[3]) {
    Real x[3], e, b;
    for (int a = 0; a < 3; a++) x[a] = p[a] - surfaces->globe_top[a];
    r_sphere_at(surfaces->globe_radius, x, d, &e, &b);
    return r_sphere_hit(e, b);
}

/* e of a point is wrong by at most 4 u (2 R |z| + |x|^2), its height by that over 2 R; the point's own rounding adds u |x|. */
static inline RSurfacePoint r_globe_point(const RSurfaces *surfaces, const Real p[3], const Real d[3], Real t) {
    RSurfacePoint point;
    Real sum = R(0.0), x[3], length;
    for (int a = 0; a < 3; a++) {
        point.p[a] = p[a] + t * d[a];
        x[a] = point.p[a] - surfaces->globe_top[a];
        sum += r_abs(x[a]) + r_abs(point.p[a]) + r_abs(surfaces->globe_top[a]);
    }
    x[2] += surfaces->globe_radius;
    length = r_sqrt(r_dot(x, x));
    for (int a = 0; a < 3; a++) point.n[a] = x[a] / length;
    point.clear = R_UNIT * R(32.0) * sum + R_UNIT * R(32.0);
    return point;
}

/* 1 and what the ray from p along the unit direction d meets first within limit; of a mesh and a plane at the same t the
 * mesh. */
static inline int r_closest_surface(const RScene *scene, const Real p[3], const Real d[3], Real limit, RMet *met) {
    const RSurfaces *surfaces = &scene->surfaces;
    Real nearest = limit < R_SIGHT ? limit : R_SIGHT, t;
    int plane = -1, globe = 0;
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
    if (surfaces->globe_radius > R(0.0)) {
        t = r_globe_hit(surfaces, p, d);
        globe = t >= R(0.0) && t < nearest;
        nearest = globe ? t : nearest;
    }
    if (plane < 0 && hit.number < 0 && !globe) return 0;
    if (globe) {
        point = r_globe_point(surfaces, p, d, nearest);
        met->surface = surfaces->globe_surface;
        r_meet(&point, d, nearest, met);
        return 1;
    }
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
    if (surfaces->globe_radius > R(0.0)) {
        t = r_globe_hit(surfaces, p, d);
        if (t >= R(0.0) && t < reach) return 1;
    }
    if (!surfaces->bvh.nodes) return 0;
    RRay ray = r_ray(p, d);
    return r_bvh_any(&surfaces->bvh, &ray, reach);
}

#endif
