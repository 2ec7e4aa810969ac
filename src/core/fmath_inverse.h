/* SPDX-License-Identifier: Apache-2.0
 *
 * asin, acos and atan2 of fmath.h. asin is a polynomial for |x| <= 1/2, beyond pi/2 - 2 asin(sqrt((1 - |x|) / 2));
 * atan2 is a polynomial of min / max, taken to its octant. Constants are sums of two numbers, the second what the first
 * lost. Coefficients: scripts/fmath_coefficients.py. */
#ifndef NPH_CORE_FMATH_INVERSE_H
#define NPH_CORE_FMATH_INVERSE_H

#include "core/fmath.h"

/* (asin(s) - s) / s of z = s^2 <= 1/4 */
static inline float nph_asin_restf(float z) {
    return z * (0.16666752f + z * (0.074953124f + z * (0.045468602f + z * (0.024187975f + z * 0.04215234f))));
}

static inline double nph_asin_rest(double z) {
    double p = 0.010779238244953223 + z * (0.00371027904307413 + z * (0.02169802864381197 +
               z * (-0.020985845187122463 + z * 0.03262048859451739)));
    p = 0.02237221489931078 + z * (0.017351613685285674 + z * (0.01398079958786537 +
        z * (0.011399089482696342 + z * p)));
    return z * (0.1666666666666676 + z * (0.07499999999970872 + z * (0.044642857174549494 +
           z * (0.03038194271078314 + z * p))));
}

static inline float nph_asinf(float x) {
    float size = nph_absf(x), z = size > 0.5f ? 0.5f * (1.0f - size) : size * size;
    float s = size > 0.5f ? nph_sqrtf(z) : size, rest = s * nph_asin_restf(z);
    float sum = 1.5707964f - 2.0f * s, lost = (1.5707964f - sum) - 2.0f * s; /* exact together */
    float far = sum + (lost - (2.0f * rest - -4.371139e-08f));
    return size <= 1.0f ? nph_copysignf(size > 0.5f ? far : s + rest, x) : nph_nanf();
}

static inline double nph_asin(double x) {
    double size = nph_abs(x), z = size > 0.5 ? 0.5 * (1.0 - size) : size * size;
    double s = size > 0.5 ? nph_sqrt(z) : size, rest = s * nph_asin_rest(z);
    double sum = 1.5707963267948966 - 2.0 * s, lost = (1.5707963267948966 - sum) - 2.0 * s;
    double far = sum + (lost - (2.0 * rest - 6.123233995736766e-17));
    return size <= 1.0 ? nph_copysign(size > 0.5 ? far : s + rest, x) : nph_nan();
}

static inline float nph_acosf(float x) {
    float size = nph_absf(x), z = size > 0.5f ? 0.5f * (1.0f - size) : size * size;
    float s = size > 0.5f ? nph_sqrtf(z) : x, rest = s * nph_asin_restf(z);
    float middle = 1.5707964f - (s + (rest - -4.371139e-08f));
    float front = 2.0f * (s + rest), back = 3.1415927f - (front - -8.742278e-08f);
    float y = size > 0.5f ? (x > 0.0f ? front : back) : middle;
    return size <= 1.0f ? y : nph_nanf();
}

static inline double nph_acos(double x) {
    double size = nph_abs(x), z = size > 0.5 ? 0.5 * (1.0 - size) : size * size;
    double s = size > 0.5 ? nph_sqrt(z) : x, rest = s * nph_asin_rest(z);
    double middle = 1.5707963267948966 - (s + (rest - 6.123233995736766e-17));
    double front = 2.0 * (s + rest), back = 3.141592653589793 - (front - 1.2246467991473532e-16);
    double y = size > 0.5 ? (x > 0.0 ? front : back) : middle;
    return size <= 1.0 ? y : nph_nan();
}

/* atan(q) - q for 0 <= q <= 1 */
static inline float nph_atan_restf(float q) {
    float z = q * q;
    float p = -0.08401503f + z * (0.05792625f + z * (-0.031148635f + z * (0.0109f + z * -0.0017905897f)));
    p = -0.333333f + z * (0.19998534f + z * (-0.142641f + z * (0.1095148f + z * p)));
    return q * z * p;
}

static inline double nph_atan_rest(double q) {
    double z = q * q;
    double p = -0.0028836465470505183 + z * (0.0008308832019204058 + z * (-0.00015206790246003084 +
               z * 1.3215951056322585e-05));
    p = -0.02990045055224263 + z * (0.021980813299038292 + z * (-0.01389687425530052 +
        z * (0.007193967266506929 + z * p)));
    p = -0.05253504123525458 + z * (0.04722276027922332 + z * (-0.04219063986814928 +
        z * (0.036639673051917565 + z * p)));
    p = -0.0909090699509622 + z * (0.07692279755501762 + z * (-0.06666403429022863 +
        z * (0.05880524348849983 + z * p)));
    p = -0.33333333333333065 + z * (0.1999999999995107 + z * (-0.14285714282556 + z * (0.11111111006529636 + z * p)));
    return q * z * p;
}

/* Angle of (x, y) in [-pi, pi], for zeros and infinities as in C99 annex F. With q = min / max <= 1 and b in {q, -q}:
 * multiple of pi/2 + atan(b). */
static inline float nph_atan2f(float y, float x) {
    float ax = nph_absf(x), ay = nph_absf(y), low = ay < ax ? ay : ax, high = ay < ax ? ax : ay;
    float q = low / (high > 0.0f ? high : 1.0f);
    q = low == high && high > 0.0f ? 1.0f : q; /* two infinities */
    float rest = nph_atan_restf(q), turned = (float)(int32_t)(nph_bitsf(x) >> 31), steep = ay > ax ? 1.0f : 0.0f;
    float sign = steep == turned ? 1.0f : -1.0f, quarters = steep == 1.0f ? 1.0f : 2.0f * turned;
    float angle = quarters * 1.5707964f + (sign * q + (sign * rest + quarters * -4.371139e-08f));
    return x != x || y != y ? nph_nanf() : nph_copysignf(angle, y);
}

static inline double nph_atan2(double y, double x) {
    double ax = nph_abs(x), ay = nph_abs(y), low = ay < ax ? ay : ax, high = ay < ax ? ax : ay;
    double q = low / (high > 0.0 ? high : 1.0);
    q = low == high && high > 0.0 ? 1.0 : q;
    double rest = nph_atan_rest(q), turned = nph_copysign(1.0, x) < 0.0 ? 1.0 : 0.0, steep = ay > ax ? 1.0 : 0.0;
    double sign = steep == turned ? 1.0 : -1.0, quarters = steep == 1.0 ? 1.0 : 2.0 * turned;
    double angle = quarters * 1.5707963267948966 + (sign * q + (sign * rest + quarters * 6.123233995736766e-17));
    return x != x || y != y ? nph_nan() : nph_copysign(angle, y);
}

#endif
