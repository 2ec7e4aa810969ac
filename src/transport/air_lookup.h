/* SPDX-License-Identifier: Apache-2.0
 *
 * Flights through air: a medium without end whose density falls exponentially with height.
 *
 * Flat, all of it is closed: the column of a way (optics/air.h), and the way to a column,
 *     column(s) = s rho (1 - e^-x) / x,  x = s |d_z| / H  (rho at the lower end)
 *     s = (c / rho) log1p(a) / a,        a = -c d_z / (rho H)  (rho where the ray comes in); a <= -1: it never gets there
 * so that nothing is tracked.
 *
 * Around a sphere of radius R that touches z = 0 from below, e = r^2 - R^2 is a polynomial along a ray, e(s) = e + s (2 b + s)
 * with b = r times the sine of the elevation, and the height is e / (r + R), without cancellation. Height is convex along a ray:
 * the plane that touches the sphere below the ray's point bounds it from below, and the density of the flat air on that plane
 * bounds the density from above. So the flat way gives tentative collisions, which are real with probability
 * exp(-(height above the sphere - height above the plane) / H): delta tracking [Woodcock65] with a bound of its own for every piece.
 * Columns are integrated by Gauss and Legendre's rule, 8 points for four scale heights: 1e-13 [Golub69]. */
#ifndef NPH_TRANSPORT_AIR_LOOKUP_H
#define NPH_TRANSPORT_AIR_LOOKUP_H

#include "transport/local_scene.h"

/* Density at a height. */
static inline Real r_air_density(const RMedium *medium, Real height) { return r_exp(-height / medium->scale_height); }

/* Flat: from height `height` on, s metres along a way whose z is `rise`; nothing overflows, however long it is. */
static inline Real r_air_column(const RMedium *medium, Real height, Real rise, Real s) {
    Real x = r_abs(rise) * s / medium->scale_height, low = rise < R(0.0) ? height + rise * s : height;
    Real mean = x > R(0.0) ? -r_expm1(-x) / x : R(1.0);
    return s * mean * r_air_density(medium, low);
}

/* Flat: the way to a column; 1e30 where the air has less. */
static inline Real r_air_reach(const RMedium *medium, Real height, Real rise, Real column) {
    Real rho = r_air_density(medium, height), level = column / rho, a = -rise * level / medium->scale_height;
    if (!(a > R(-1.0))) return R(1e30);
    return r_abs(a) > R(0.0) ? level * (r_log1p(a) / a) : level;
}

/* ---- around a sphere ---- */

/* A ray: e and b where it begins, and the part of it between the ground and the end of the air. */
typedef struct RArc {
    Real e, b, near, far;
    int inside;
} RArc;

/* e and b at a point x of a space whose z = 0 the sphere touches at the origin. */
static inline void r_sphere_at(Real radius, const Real x[3], const Real d[3], Real *e, Real *b) {
    *e = x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + R(2.0) * radius * x[2];
    *b = x[0] * d[0] + x[1] * d[1] + x[2] * d[2] + radius * d[2];
}

/* Where a ray comes down to the sphere; -1: never. */
static inline Real r_sphere_hit(Real e, Real b) {
    Real square = b * b - e;
    if (!(b < R(0.0)) || !(square > R(0.0))) return R(-1.0);
    return e > R(0.0) ? e / (r_sqrt(square) - b) : R(0.0);
}

static inline Real r_air_e(const RArc *arc, Real s) {
    Real e = arc->e + s * (R(2.0) * arc->b + s);
    return e > R(0.0) ? e : R(0.0);
}

static inline Real r_air_height(const RMedium *medium, Real e) {
    return e / (r_sqrt(medium->radius * medium->radius + e) + medium->radius);
}

static inline RArc r_air_arc(const RMedium *medium, const Real p[3], const Real d[3], Real limit) {
    RArc arc = {R(0.0), R(0.0), R(0.0), R(0.0), 0};
    Real top = medium->hi[2] * (R(2.0) * medium->radius + medium->hi[2]), x[3];
    for (int a = 0; a < 3; a++) x[a] = p[a] + medium->from_local[4 * a + 3];
    r_sphere_at(medium->radius, x, d, &arc.e, &arc.b);
    Real above = arc.e - top, square = arc.b * arc.b - above;
    if (!(square > R(0.0)) || (above > R(0.0) && !(arc.b < R(0.0)))) return arc;
    Real root = r_sqrt(square), ground = r_sphere_hit(arc.e, arc.b);
    arc.near = above > R(0.0) ? above / (root - arc.b) : R(0.0);
    arc.far = arc.b > R(0.0) ? -above / (root + arc.b) : root - arc.b;
    arc.far = ground >= R(0.0) && ground < arc.far ? ground : arc.far;
    arc.far = arc.far < limit ? arc.far : limit;
    arc.inside = arc.near < arc.far;
    return arc;
}

/* Column of a way that leads up (b >= 0) from e on. */
static inline Real r_air_upwards(const RMedium *medium, Real e, Real b, Real length) {
    static const Real place[8] = {R(0.019855071751231912), R(0.10166676129318664), R(0.23723379504183550), R(0.40828267875217511),
                                  R(0.59171732124782489), R(0.76276620495816450), R(0.89833323870681336), R(0.98014492824876809)};
    static const Real weight[8] = {R(0.050614268145188129), R(0.11119051722668724), R(0.15685332293894363), R(0.18134189168918100),
                                   R(0.18134189168918100), R(0.15685332293894363), R(0.11119051722668724), R(0.050614268145188129)};
    Real sum = R(0.0), climb = R(4.0) * medium->scale_height;
    while (length > R(0.0)) {
        Real height = r_air_height(medium, e), more = climb * (R(2.0) * (medium->radius + height) + climb), piece = R(0.0);
        Real step = more / (b + r_sqrt(b * b + more));
        step = step < length ? step : length;
        for (int k = 0; k < 8; k++) {
            Real s = step * place[k];
            piece += weight[k] * r_air_density(medium, r_air_height(medium, e + s * (R(2.0) * b + s)));
        }
        sum += piece * step;
        e += step * (R(2.0) * b + step);
        b += step;
        length -= step;
    }
    return sum;
}

/* Column between two distances: down to the lowest point, taken from its lower end, and up again. */
static inline Real r_air_curved(const RMedium *medium, const RArc *arc, Real from, Real to) {
    Real lowest = r_max(from, -arc->b < to ? -arc->b : to), sum = R(0.0), e = r_air_e(arc, lowest);
    if (lowest > from) sum += r_air_upwards(medium, e, r_max(-(arc->b + lowest), R(0.0)), lowest - from);
    if (to > lowest) sum += r_air_upwards(medium, e, r_max(arc->b + lowest, R(0.0)), to - lowest);
    return sum;
}

#endif
