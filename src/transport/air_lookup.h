/* SPDX-License-Identifier: Apache-2.0
 *
 * Flights through air: a medium without end whose density falls exponentially with height, flat. All of it is closed: the
 * column of a way (optics/air.h), and the way to a column,
 *     column(s) = s rho (1 - e^-x) / x,  x = s d_z / H  (rho at the lower end, |x|)
 *     s = (c / rho) log1p(a) / a,        a = -c d_z / (rho H)  (rho where the ray comes in); a <= -1: it never gets there
 * so that nothing is tracked. Where H d_z is 0 both are the level way's. */
#ifndef NPH_TRANSPORT_AIR_LOOKUP_H
#define NPH_TRANSPORT_AIR_LOOKUP_H

#include "transport/local_scene.h"

/* Density at a height. */
static inline Real r_air_density(const RMedium *medium, Real height) {
    return r_exp(-(height > R(0.0) ? height : R(0.0)) / medium->scale_height);
}

/* From height `height` on, s metres along a way whose z is `rise`; nothing overflows, however long it is. */
static inline Real r_air_column(const RMedium *medium, Real height, Real rise, Real s) {
    Real x = r_abs(rise) * s / medium->scale_height, low = rise < R(0.0) ? height + rise * s : height;
    Real mean = x > R(0.0) ? -r_expm1(-x) / x : R(1.0);
    return s * mean * r_air_density(medium, low);
}

/* The way to a column; R_HUGE where the air has less. */
static inline Real r_air_reach(const RMedium *medium, Real height, Real rise, Real column) {
    Real rho = r_air_density(medium, height), level = column / rho, a = -rise * level / medium->scale_height;
    if (!(a > R(-1.0))) return R(1e30);
    return r_abs(a) > R(0.0) ? level * (r_log1p(a) / a) : level;
}

#endif
