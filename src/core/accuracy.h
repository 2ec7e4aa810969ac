/* SPDX-License-Identifier: Apache-2.0
 *
 * How accurate the functions of a GPU interface are, and real.h's functions made as inaccurate as that. Only where NPH_ALTERED
 * is defined (src/altered): there r_exp and its like ask which interface is simulated, none at first. A result is the true
 * value moved by a part in [-1, 1] of what the interface allows; the part is a hash of the argument, so that equal arguments
 * have equal results, as on a machine. */
#ifndef NPH_CORE_ACCURACY_H
#define NPH_CORE_ACCURACY_H

#include "core/real.h"

/* Largest errors; in units in the last place of the result where nothing else is said. */
typedef struct NphAccuracy {
    const char *name, *source;
    int doubles;                /* 0: it has these functions for floats only */
    double exp, exp_by_size;    /* by_size: and so much more per |argument| */
    double log, log_absolute;   /* absolute: for arguments in [1/2, 2], where it is not 0 */
    double expm1, log1p;        /* 0: has none, a port writes exp(x) - 1 and log(1 + x) */
    double sincos, sincos_absolute; /* absolute: where it is not 0 */
    double cbrt;                /* 0: has none, a port writes exp2(log2(x) / 3) */
    double acos, atan2, sqrt;
} NphAccuracy;

/* What is simulated, NULL: nothing; process-wide. The salt chooses among machines of one accuracy. */
extern const NphAccuracy *nph_accuracy;
extern uint32_t nph_accuracy_salt;

/* The distance from |x| to the next number away from 0. */
R_INLINE double r_unit_of(double x) {
    double exponent, size = nph_abs(x), least = NPH_PRECISION == 32 ? 0x1p-126 : 0x1p-1022;
    if (!(size > least)) size = least;
    nph_mantissa(size, &exponent); /* of a number below sqrt(1/2) times a power of 2 it is that power's, one too high */
    double power = nph_power_of_2(exponent);
    return (power > size ? 0.5 * power : power) * (double)NPH_REAL_ULP;
}

/* In [-1, 1]. */
R_INLINE double r_part(Real x, uint32_t function) {
    uint64_t bits = nph_bits((double)x);
    uint32_t h = (uint32_t)bits ^ (uint32_t)(bits >> 32) * 0x9E3779B9u ^ nph_accuracy_salt * 0x85EBCA6Bu ^ function * 0xC2B2AE35u;
    h = (h ^ h >> 16) * 0x7FEB352Du; /* lowbias32 of Wellons' hash prospector */
    h = (h ^ h >> 15) * 0x846CA68Bu;
    return ((double)(h ^ h >> 16) - 2147483647.5) / 2147483647.5;
}

R_INLINE Real r_moved(double exact, double by) {
    return nph_abs(exact) < nph_infinity() ? (Real)(exact + by) : (Real)exact;
}

R_INLINE Real r_loose_exp(Real x) {
    double y = nph_exp((double)x);
    return r_max(r_moved(y, r_part(x, 1) * (nph_accuracy->exp + nph_accuracy->exp_by_size * nph_abs((double)x)) * r_unit_of(y)), R(0.0));
}

R_INLINE Real r_loose_log(Real x) {
    double y = nph_log((double)x), near = nph_accuracy->log_absolute;
    return r_moved(y, r_part(x, 2) * (near > 0.0 && x >= R(0.5) && x <= R(2.0) ? near : nph_accuracy->log * r_unit_of(y)));
}

R_INLINE Real r_loose_expm1(Real x) {
    if (!(nph_accuracy->expm1 > 0.0)) return r_loose_exp(x) - R(1.0);
    double y = nph_expm1((double)x);
    return r_moved(y, r_part(x, 3) * nph_accuracy->expm1 * r_unit_of(y));
}

R_INLINE Real r_loose_log1p(Real x) {
    if (!(nph_accuracy->log1p > 0.0)) return r_loose_log(R(1.0) + x);
    double y = nph_log1p((double)x);
    return r_moved(y, r_part(x, 4) * nph_accuracy->log1p * r_unit_of(y));
}

R_INLINE double r_sincos_error(double y) {
    return nph_accuracy->sincos_absolute > 0.0 ? nph_accuracy->sincos_absolute : nph_accuracy->sincos * r_unit_of(y);
}

R_INLINE void r_loose_sincos2pi(Real x, Real *sine, Real *cosine) {
    double s, c;
    nph_sincos2pi((double)x, &s, &c);
    *sine = r_clamp(r_moved(s, r_part(x, 5) * r_sincos_error(s)), R(-1.0), R(1.0));
    *cosine = r_clamp(r_moved(c, r_part(x, 6) * r_sincos_error(c)), R(-1.0), R(1.0));
}

R_INLINE Real r_loose_cbrt(Real x) {
    double y = nph_cbrt((double)x), ulp = nph_accuracy->cbrt;
    if (!(ulp > 0.0)) { /* of exp2; and log2's, which changes the result by its exponent as often */
        double exponent = nph_abs(nph_log(nph_abs((double)x) + 1e-300)) * (1.4426950408889634 / 3.0);
        ulp = nph_accuracy->exp + nph_accuracy->exp_by_size * exponent + nph_accuracy->log * 0.6931471805599453 * exponent;
    }
    return r_moved(y, r_part(x, 7) * ulp * r_unit_of(y));
}

R_INLINE Real r_loose_acos(Real x) {
    double y = nph_acos((double)x);
    return r_max(r_moved(y, r_part(x, 8) * nph_accuracy->acos * r_unit_of(y)), R(0.0));
}

R_INLINE Real r_loose_atan2(Real y, Real x) {
    double angle = nph_atan2((double)y, (double)x);
    return r_moved(angle, r_part(y * R(3.0) + x, 9) * nph_accuracy->atan2 * r_unit_of(angle));
}

R_INLINE Real r_loose_sqrt(Real x) {
    double y = nph_sqrt((double)x);
    return r_max(r_moved(y, x > R(0.0) ? r_part(x, 10) * nph_accuracy->sqrt * r_unit_of(y) : 0.0), R(0.0));
}

/* Out of line: a loop that asks stays short, and makes no vectors while nothing is simulated anyway. */
#define R_LOOSE(name, exact) \
    R_OUTLINE Real r_simulated_##name(Real x) { return r_loose_##name(x); } \
    static inline Real r_asked_##name(Real x) { return nph_accuracy ? r_simulated_##name(x) : exact(x); }
R_LOOSE(exp, r_exp)
R_LOOSE(expm1, r_expm1)
R_LOOSE(log, r_log)
R_LOOSE(log1p, r_log1p)
R_LOOSE(cbrt, r_cbrt)
R_LOOSE(acos, r_acos)
R_LOOSE(sqrt, r_sqrt)
R_OUTLINE Real r_simulated_atan2(Real y, Real x) { return r_loose_atan2(y, x); }
static inline Real r_asked_atan2(Real y, Real x) { return nph_accuracy ? r_simulated_atan2(y, x) : r_atan2(y, x); }
R_OUTLINE void r_simulated_sincos2pi(Real x, Real *sine, Real *cosine) { r_loose_sincos2pi(x, sine, cosine); }
static inline void r_asked_sincos2pi(Real x, Real *sine, Real *cosine) {
    if (nph_accuracy) r_simulated_sincos2pi(x, sine, cosine);
    else r_sincos2pi(x, sine, cosine);
}
#undef R_LOOSE

#undef r_exp
#undef r_expm1
#undef r_log
#undef r_log1p
#undef r_sincos2pi
#undef r_cbrt
#undef r_acos
#undef r_atan2
#undef r_sqrt
#define r_exp r_asked_exp
#define r_expm1 r_asked_expm1
#define r_log r_asked_log
#define r_log1p r_asked_log1p
#define r_sincos2pi r_asked_sincos2pi
#define r_cbrt r_asked_cbrt
#define r_acos r_asked_acos
#define r_atan2 r_asked_atan2
#define r_sqrt r_asked_sqrt

#endif
