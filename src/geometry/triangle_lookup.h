/* SPDX-License-Identifier: Apache-2.0
 *
 * A ray against a triangle in kernels, watertight [Woop13]. The largest component of the direction is called z, the
 * other two x and y. A corner v becomes, relative to the origin o and sheared along the ray,
 *     z = v_z - o_z,   x = (v_x - o_x) - (d_x / d_z) z,   y likewise,
 * which depends on nothing but the ray and that corner. The ray is now the z axis, and it meets the triangle when 0
 * lies in the flat triangle (a, b, c): when the edge functions
 *     u = c_x b_y - c_y b_x,   v = a_x c_y - a_y c_x,   w = b_x a_y - b_y a_x
 * have no two opposite signs; zeros belong to both sides. Then t = (u a_z + v b_z + w c_z) / ((u + v + w) d_z).
 *
 * Why nothing leaks. (1) Signs are exact. Rounding is monotonic, so p > q for the two products, when rounded p >
 * rounded q: a difference of rounded products that is not 0 has the true sign. One that is 0 is computed again
 * without error: the products of floats are exact as doubles, those of doubles are the sum of two doubles [Dekker71].
 * (2) Two triangles that share an edge compute the same two products for it and get opposite signs, or both 0. So a
 * ray sees the flat picture of the mesh, with corners moved by rounding, but exactly as connected as the mesh is:
 * where faces of a closed mesh cover 0, one of them says so. (3) A triangle that is seen edge-on (u = v = w = 0) is
 * passed over; the ray turned by an arbitrarily small angle meets a face that is not edge-on and, being closed,
 * covers 0 too. Exactness ends where products underflow: in double precision for lengths below 1e-146 m, in single
 * never (the coordinates' own range ends at 1e-45 m).
 *
 * How far corners move, u = 2^-24 or 2^-53 being the unit of rounding and m the largest |coordinate| relative to o: x
 * and y by at most 6.2 u m (differences 1, d_x / d_z 1, its product with z and its error in z 2, the last difference
 * 2), z by u m. The weights u, v, w are then computed with a relative error of a few 2^-53 in either precision, so
 * what t adds is its own rounding and at most 10 2^-53 m. An origin nearer to a surface than that may see it on the
 * wrong side of itself (t < 0): surface_lookup.h says how far from a surface rays start. */
#ifndef NPH_GEOMETRY_TRIANGLE_LOOKUP_H
#define NPH_GEOMETRY_TRIANGLE_LOOKUP_H

#include <stdint.h>

#include "core/real.h"

#if NPH_PRECISION == 32
#define R_UNIT 0x1p-24f
#else
#define R_UNIT 0x1p-53
#endif

/* A ray as the tests want it; made by r_ray. d need not be of length 1, but not be 0; t counts in lengths of d. */
typedef struct RRay {
    Real o[3], d[3], inverse[3];
    Real shear[2];  /* d_x / d_z, d_y / d_z */
    int axis[3];    /* which coordinate is x, y, z */
    int negative[3];
} RRay;

typedef struct RHit {
    Real t;
    Real weight[2]; /* of the second and the third corner; that of the first is what they lack to 1 */
    int32_t number; /* of the triangle through all meshes; -1: no hit */
    int32_t slot;   /* of the triangle in the hierarchy */
} RHit;

static inline RRay r_ray(const Real o[3], const Real d[3]) {
    RRay ray;
    Real x = r_abs(d[0]), y = r_abs(d[1]), z = r_abs(d[2]);
    int major = x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
    for (int k = 0; k < 3; k++) {
        ray.o[k] = o[k];
        ray.d[k] = d[k];
        ray.inverse[k] = R(1.0) / d[k];
        ray.negative[k] = ray.inverse[k] < R(0.0); /* -0 too: its inverse is -infinity */
        ray.axis[k] = (major + 1 + k) % 3;
    }
    ray.shear[0] = d[ray.axis[0]] / d[major];
    ray.shear[1] = d[ray.axis[1]] / d[major];
    return ray;
}

/* a b as high + low, exactly [Dekker71]; |a|, |b| < 1e300. */
static inline double r_product(double a, double b, double *low) {
    double big_a = 134217729.0 * a, big_b = 134217729.0 * b, p = a * b;
    double a1 = big_a - (big_a - a), a2 = a - a1, b1 = big_b - (big_b - b), b2 = b - b1;
    *low = ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2;
    return p;
}

/* a + b as high + low, exactly. */
static inline double r_sum(double a, double b, double *low) {
    double s = a + b, part = s - a;
    *low = (a - (s - part)) + (b - part);
    return s;
}

/* a b - c d with a relative error of a few 2^-53 and therefore the right sign. */
static inline double r_edge(Real a, Real b, Real c, Real d) {
#if NPH_PRECISION == 32
    return (double)a * (double)b - (double)c * (double)d;
#else
    double low_p, low_q, low_high, low_low, low;
    double p = r_product(a, b, &low_p), q = r_product(c, d, &low_q);
    double high = r_sum(p, -q, &low_high), rest = r_sum(low_p, -low_q, &low_low), sum = r_sum(high, rest, &low);
    return sum + ((low + low_low) + low_high);
#endif
}

/* 1 and t, weight of *hit when the ray meets the triangle at a t in [0, t_max]. */
static inline int r_triangle_hit(const RRay *ray, const Real *a, const Real *b, const Real *c, Real t_max, RHit *hit) {
    int x = ray->axis[0], y = ray->axis[1], z = ray->axis[2];
    Real az = a[z] - ray->o[z], bz = b[z] - ray->o[z], cz = c[z] - ray->o[z];
    Real ax = (a[x] - ray->o[x]) - ray->shear[0] * az, ay = (a[y] - ray->o[y]) - ray->shear[1] * az;
    Real bx = (b[x] - ray->o[x]) - ray->shear[0] * bz, by = (b[y] - ray->o[y]) - ray->shear[1] * bz;
    Real cx = (c[x] - ray->o[x]) - ray->shear[0] * cz, cy = (c[y] - ray->o[y]) - ray->shear[1] * cz;
    Real u = cx * by - cy * bx, v = ax * cy - ay * cx, w = bx * ay - by * ax;
    int unsure = u == R(0.0) || v == R(0.0) || w == R(0.0);
    if (!unsure && !(u < R(0.0) && v < R(0.0) && w < R(0.0)) && !(u > R(0.0) && v > R(0.0) && w > R(0.0))) return 0;
    double p = r_edge(cx, by, cy, bx), q = r_edge(ax, cy, ay, cx), r = r_edge(bx, ay, by, ax);
    if (unsure && (p < 0.0 || q < 0.0 || r < 0.0) && (p > 0.0 || q > 0.0 || r > 0.0)) return 0;
    double all = p + q + r;
    if (all == 0.0) return 0;
    p /= all;
    q /= all;
    r /= all;
    Real t = (Real)((p * (double)az + q * (double)bz + r * (double)cz) / (double)ray->d[z]);
    if (!(t >= R(0.0) && t <= t_max)) return 0;
    hit->t = t;
    hit->weight[0] = (Real)q;
    hit->weight[1] = (Real)r;
    return 1;
}

#endif
