/* SPDX-License-Identifier: Apache-2.0
 *
 * Lambert's surface in kernels: radiance albedo / pi times irradiance, the same in all directions of the side that is
 * lit. Directions drawn with density cos / pi about the normal: sin^2 = u, uniform azimuth; value cos / density =
 * albedo. */
#ifndef NPH_GEOMETRY_LAMBERT_LOOKUP_H
#define NPH_GEOMETRY_LAMBERT_LOOKUP_H

#include "optics/phase_lookup.h"

#define R_1_PI R(0.31830988618379067)

/* A unit direction about the unit normal n; u, u_azimuth in [0, 1). u < 1 keeps the cosine above 0: at least 2^-12 in
 * single precision (u in steps of 2^-24), 2^-16 in double (2^-32), far above rounding. */
static inline void r_lambert_sample(const Real n[3], Real u, Real u_azimuth, Real out[3]) {
    RAngle angle;
    angle.cosine = r_sqrt(R(1.0) - u);
    angle.rise = R(1.0) + angle.cosine;
    angle.fall = u / angle.rise;
    r_turn_by(n, angle, u_azimuth, out);
}

/* Density [1/sr] of a direction, given n . d; 0 below the surface. */
static inline Real r_lambert_density(Real cosine) { return cosine > R(0.0) ? cosine * R_1_PI : R(0.0); }

#endif
