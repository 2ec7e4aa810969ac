/* SPDX-License-Identifier: Apache-2.0
 *
 * Angles and Henyey and Greenstein's function in kernels. An angle is carried as cos, fall = 1 - cos and rise = 1 +
 * cos, so that neither peak loses digits; the asymmetry as |g| and rest = 1 - |g|, because a float 0.99999 has three
 * digits left in 1 - g. Henyey-Greenstein [Henyey41] of g >= 0 (g < 0: fall and rise exchanged):
 *   p = rest (1 + g) / (4 pi D^(3/2)),  D = 1 + g^2 - 2 g cos = rest^2 + 2 g fall. */
#ifndef NPH_OPTICS_HG_LOOKUP_H
#define NPH_OPTICS_HG_LOOKUP_H

#include "core/real.h"

typedef struct RAngle {
    Real cosine, fall, rise; /* cos, 1 - cos, 1 + cos of the scattering angle */
} RAngle;

/* The angle of a cosine: good where the cosine itself is. */
R_INLINE RAngle r_angle(Real cosine) {
    RAngle angle = {cosine, R(1.0) - cosine, R(1.0) + cosine};
    return angle;
}

/* The angle at a distance 1 - |cos| from the front or the back pole. */
R_INLINE RAngle r_angle_near(int front, Real near) {
    Real far = R(2.0) - near;
    RAngle angle = {front ? R(1.0) - near : near - R(1.0), front ? near : far, front ? far : near};
    return angle;
}

R_INLINE Real r_hg_value(Real g, Real rest, RAngle angle) {
    Real near = g < R(0.0) ? angle.rise : angle.fall;
    Real d = rest * rest + R(2.0) * (R(1.0) - rest) * near;
    return rest * (R(2.0) - rest) * R(0.079577471545947668) / (d * r_sqrt(d));
}

/* The angle below whose cosine lies the part u of the distribution, without a singularity at g = 0: for g >= 0
 *   1 - cos = 2 (rest / s)^2 (1 - u) (1 + g u),  1 + cos = 2 ((1 + g) / s)^2 u (rest + g u),  s = rest + 2 g u. */
R_INLINE RAngle r_hg_sample(Real g, Real rest, Real u) {
    int backward = g < R(0.0);
    Real v = backward ? R(1.0) - u : u, w = backward ? u : R(1.0) - u, size = R(1.0) - rest;
    Real inverse = R(1.0) / (rest + R(2.0) * size * v), a = rest * inverse, b = (R(2.0) - rest) * inverse;
    Real near = R(2.0) * a * a * w * (R(1.0) + size * v), far = R(2.0) * b * b * v * (rest + size * v);
    int front = near < far;
    near = front ? near : R(2.0) - far; /* the smaller decides: it has the smaller error */
    far = front ? R(2.0) - near : far;
    Real cosine = front ? R(1.0) - near : far - R(1.0);
    RAngle angle;
    angle.cosine = backward ? -cosine : cosine;
    angle.fall = backward ? far : near;
    angle.rise = backward ? near : far;
    return angle;
}

#endif
