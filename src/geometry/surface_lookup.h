/* SPDX-License-Identifier: Apache-2.0
 *
 * Points on surfaces in kernels: where a hit lies, its normal, and rays that start there; and the infinite plane.
 *
 * A ray that starts on a surface must not meet that surface again, and should lose nothing else. So a point knows how
 * far from it, along the normal n, rays must start: clear. For a triangle with corners a, b, c, longest |coordinate|
 * of a side L, and the point p = a + (weight_1 (b - a) + weight_2 (c - a)), u being the unit of rounding:
 *   p      lies within u (S + 9 L) of the plane, S = sum |n_k p_k|: the sum in brackets is a point of the plane for
 *          any weights, its rounding errors are below 5 u L in each coordinate, 9 u L along n, and the last sum adds
 *          u |p_k|.
 *   start  o = p + clear n adds rounding u (S + clear).
 *   test   seen from o, every corner has coordinates of at most L (1 + small) since p lies in the triangle; the
 *          triangle test is exact for corners moved by at most 6.2 u L in two coordinates and u L in the third, less
 *          than 9 u L along n, and its t is wrong by at most 10 u sqrt(3) L besides its rounding, which keeps its sign.
 *   d      a direction whose computed n . d is not negative may descend by 4 u of its way, 7 u L before it is past the
 *          triangle.
 * The moved triangle lies below a height of 9 u L, the ray above it when clear > u (2 S + 9 L + 9 L + 18 L + 7 L):
 * its t is negative. clear = u (4 S + 64 L) leaves a margin for n's own error. It costs what the numbers cost: at 1e5
 * m from the scene's origin floats are 0.008 m apart, and clear is 0.02 m. Another surface nearer than that (in the
 * corner of two faces) can be passed over; nothing else is. */
#ifndef NPH_GEOMETRY_SURFACE_LOOKUP_H
#define NPH_GEOMETRY_SURFACE_LOOKUP_H

#include "geometry/bvh_lookup.h"

typedef struct RSurfacePoint {
    Real p[3];  /* scene-local */
    Real n[3];  /* unit, to the side from which the corners turn counter-clockwise */
    Real clear; /* how far along n (or -n) rays start */
} RSurfacePoint;

static inline Real r_dot(const Real a[3], const Real b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* The length of a vector, and the vector made unit, without over- or underflow in between. 0 stays 0. */
static inline double r_unit(double v[3]) {
    double size = 0.0;
    for (int k = 0; k < 3; k++) size = nph_abs(v[k]) > size ? nph_abs(v[k]) : size;
    if (!(size > 0.0)) return 0.0;
    for (int k = 0; k < 3; k++) v[k] /= size;
    double length = nph_sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int k = 0; k < 3; k++) v[k] /= length;
    return length * size;
}

/* The unit normal of two sides, in double also for floats: slivers lose digits in it. Corners on a line have no normal;
 * they get one that is perpendicular to the line. */
static inline void r_normal(const double e[3], const double f[3], Real n[3]) {
    double a[3] = {e[0], e[1], e[2]}, b[3] = {f[0], f[1], f[2]}, c[3];
    r_unit(a);
    r_unit(b);
    for (int k = 0; k < 3; k++) c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
    if (r_unit(c) == 0.0) {
        int least = nph_abs(a[0]) < nph_abs(a[1]) ? 0 : 1;
        least = nph_abs(a[2]) < nph_abs(a[least]) ? 2 : least;
        for (int k = 0; k < 3; k++) c[k] = (k == least ? 1.0 : 0.0) - a[least] * a[k];
        r_unit(c);
    }
    for (int k = 0; k < 3; k++) n[k] = (Real)c[k];
}

/* Where a hit lies. */
static inline RSurfacePoint r_bvh_point(const RBvh *bvh, const RHit *hit) {
    const Real *a = r_bvh_corner(bvh, hit->slot, 0), *b = r_bvh_corner(bvh, hit->slot, 1);
    const Real *c = r_bvh_corner(bvh, hit->slot, 2);
    RSurfacePoint point;
    double e[3], f[3];
    Real size = R(0.0), sum = R(0.0);
    for (int k = 0; k < 3; k++) {
        Real x = b[k] - a[k], y = c[k] - a[k], z = c[k] - b[k];
        e[k] = (double)b[k] - (double)a[k];
        f[k] = (double)c[k] - (double)a[k];
        point.p[k] = a[k] + (hit->weight[0] * x + hit->weight[1] * y);
        size = r_max(size, r_max(r_max(r_abs(x), r_abs(y)), r_abs(z)));
    }
    r_normal(e, f, point.n);
    for (int k = 0; k < 3; k++) sum += r_abs(point.n[k] * point.p[k]);
    point.clear = R_UNIT * (R(4.0) * sum + R(64.0) * size);
    return point;
}

/* Where a ray with direction d starts that leaves the point: on d's side of the surface. */
static inline void r_leave(const RSurfacePoint *point, const Real d[3], Real o[3]) {
    Real way = r_dot(point->n, d) < R(0.0) ? -point->clear : point->clear;
    for (int k = 0; k < 3; k++) o[k] = point->p[k] + way * point->n[k];
}

/* The same for a segment that ends at q: as a ray with t in [0, 1]. Where q lies on a surface too, hand in its start of
 * a ray back to p (r_leave), so that the segment ends before that surface. */
static inline void r_leave_towards(const RSurfacePoint *point, const Real q[3], Real o[3], Real d[3]) {
    Real straight[3];
    for (int k = 0; k < 3; k++) straight[k] = q[k] - point->p[k];
    r_leave(point, straight, o);
    for (int k = 0; k < 3; k++) d[k] = q[k] - o[k];
}

/* The plane n . x = level, without end; n is unit. */
typedef struct RPlane {
    Real n[3], level;
} RPlane;

/* From a point of the plane and its normal (any length) in world space, and the origin of scene-local space. */
static inline RPlane r_plane_through(const double point[3], const double normal[3], const double origin[3]) {
    RPlane plane;
    double n[3] = {normal[0], normal[1], normal[2]}, level = 0.0;
    r_unit(n);
    for (int k = 0; k < 3; k++) {
        plane.n[k] = (Real)n[k];
        level += (double)plane.n[k] * (point[k] - origin[k]);
    }
    plane.level = (Real)level;
    return plane;
}

/* t of the ray o + t d when it meets the plane at a t in [0, t_max]: it comes from one side and goes to the other. A
 * ray that starts in the plane does not meet it. */
static inline int r_plane_hit(const RPlane *plane, const Real o[3], const Real d[3], Real t_max, Real *t) {
    Real height = r_dot(plane->n, o) - plane->level, rise = r_dot(plane->n, d);
    if (!(height > R(0.0) && rise < R(0.0)) && !(height < R(0.0) && rise > R(0.0))) return 0;
    Real at = -height / rise;
    if (!(at >= R(0.0) && at <= t_max)) return 0;
    *t = at;
    return 1;
}

/* The point of a hit, moved into the plane. Heights are computed with an error of at most 4 u (S + |level|), S = sum
 * |n_k p_k|: the point lies that near the plane but for its own rounding u S, a ray's start adds u S, and its height
 * is computed with that error again: 10 u (S + |level|) in all. clear is 16 u (S + |level|), so the height of a start
 * never has the wrong sign, and r_plane_hit looks at signs alone. In a coordinate plane through 0 both are 0, and all
 * is exact. */
static inline RSurfacePoint r_plane_point(const RPlane *plane, const Real o[3], const Real d[3], Real t) {
    RSurfacePoint point;
    Real sum = r_abs(plane->level);
    for (int k = 0; k < 3; k++) {
        point.p[k] = o[k] + t * d[k];
        point.n[k] = plane->n[k];
    }
    Real height = r_dot(plane->n, point.p) - plane->level;
    for (int k = 0; k < 3; k++) {
        point.p[k] -= height * plane->n[k];
        sum += r_abs(plane->n[k] * point.p[k]);
    }
    point.clear = R(16.0) * R_UNIT * sum;
    return point;
}

#endif
