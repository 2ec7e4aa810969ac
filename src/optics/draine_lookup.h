/* SPDX-License-Identifier: Apache-2.0
 *
 * Draine's phase function in kernels [Draine03]:
 *   p = hg(g) (1 + alpha cos^2) / N,   N = 1 + alpha (1 + 2 g^2) / 3
 * alpha 0 is Henyey and Greenstein's, g = 0 with alpha = 1 Rayleigh's.
 *
 * Sampling. Let x be the part of hg(g) between a pole and the angle, seen from a pole where it has the asymmetry -e
 * (e = -|g| from the peak's side, |g| from the other). With m = 1 - e, p = 1 + e, s = m + 2 e x, d = 1 - |cos| is
 *   d(x) = 2 (p / s)^2 x (m + e x)
 * and the part of p itself is (x + alpha G(x)) / N with G(x) the integral of (1 - d)^2. In t = x / s, where d is
 * linear in 1 / s^2, that integral is elementary; ordered by powers of t the singularity at e = 0 cancels:
 *   G = x (1 - 2 p^2 t + 4/3 p^4 t^2 - 2/3 e p^4 t^3)
 * (check: e = 0 gives the integral of (1 - 2 x)^2; x = 1 gives (1 + 2 e^2) / 3). x + alpha G = y has a closed root,
 * of a quartic [Jendersie23], which cancels for small g. Newton's iteration keeps all digits: up to cos = 0 the left
 * side is increasing and concave, so that from x = y / (1 + alpha) it rises to the root, and each pole is taken
 * for its half. */
#ifndef NPH_OPTICS_DRAINE_LOOKUP_H
#define NPH_OPTICS_DRAINE_LOOKUP_H

#include "optics/hg_lookup.h"

enum { R_DRAINE_STEPS = 40 }; /* alpha = 1000, g = 0 needs 17 */

typedef struct RDraine {
    Real alpha, norm, scale; /* N and 1 / N */
    Real split;              /* part of the distribution in the half away from the peak */
} RDraine;

/* x + alpha G(x). */
static inline double r_draine_part(double alpha, double e, double x) {
    double p = 1.0 + e, b = p * p, t = x / (1.0 - e + 2.0 * e * x);
    return x * (1.0 + alpha * (1.0 - b * t * (2.0 - b * t * (4.0 / 3.0 - 2.0 / 3.0 * e * t))));
}

static inline RDraine r_draine(double g, double alpha) {
    double size = nph_abs(g), q = nph_sqrt(1.0 + size * size), norm = 1.0 + alpha * (1.0 + 2.0 * size * size) / 3.0;
    double middle = (1.0 - size) / (q * (1.0 + size + q)); /* hg's part with cos < 0 */
    RDraine out;
    out.alpha = (Real)alpha;
    out.norm = (Real)norm;
    out.scale = (Real)(1.0 / norm);
    out.split = (Real)(r_draine_part(alpha, size, middle) / norm);
    return out;
}

/* cos^2 from (rise - fall) / 2, which is right in the middle too. */
R_INLINE Real r_draine_value(const RDraine *draine, Real g, Real rest, RAngle angle) {
    Real cosine = R(0.5) * (angle.rise - angle.fall);
    return r_hg_value(g, rest, angle) * (R(1.0) + draine->alpha * cosine * cosine) * draine->scale;
}

/* The distance 1 - |cos| from a pole within which lies the part `part` of the distribution; m = 1 - e, p = 1 + e. */
static inline Real r_draine_near(const RDraine *draine, Real e, Real m, Real p, Real part) {
    Real b = p * p, y = draine->norm * part, x = y / (R(1.0) + draine->alpha), d = R(0.0);
    for (int step = 0; step < R_DRAINE_STEPS; step++) {
        Real inverse = R(1.0) / (m + R(2.0) * e * x), t = x * inverse, bt = b * t;
        Real curve = bt * (R(2.0) - bt * (R(1.3333333333333333) - R(0.66666666666666667) * e * t));
        d = R(2.0) * b * inverse * t * (m + e * x);
        Real miss = y - x * (R(1.0) + draine->alpha * (R(1.0) - curve));
        Real slope = R(1.0) + draine->alpha * (R(1.0) - d) * (R(1.0) - d), move = miss / slope;
        if (!(r_abs(move) > R(4.0) * NPH_REAL_ULP * x)) break;
        x = r_clamp(x + move, R(0.0), R(1.0));
    }
    return r_min(d, R(1.0));
}

static inline RAngle r_draine_sample(const RDraine *draine, Real g, Real rest, Real u) {
    int backward = g < R(0.0);
    Real far = backward ? R(1.0) - u : u, near = backward ? u : R(1.0) - u, size = R(1.0) - rest;
    int at_peak = !(far < draine->split), front = at_peak != backward;
    Real m = at_peak ? R(2.0) - rest : rest, p = at_peak ? rest : R(2.0) - rest;
    Real distance = r_draine_near(draine, at_peak ? -size : size, m, p, at_peak ? near : far);
    return r_angle_near(front, distance);
}

#endif
