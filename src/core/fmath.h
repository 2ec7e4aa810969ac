/* SPDX-License-Identifier: Apache-2.0
 *
 * Deterministic mathematics: exp, expm1, exp2, log, log1p, sin, cos, tan, sincos2pi, asin, acos, atan2, cbrt, pow,
 * floor, sqrt in float and double, at most 2 ulp from the true value (measured: 1.64, sincos2pi). Only + - * /,
 * correctly rounded square roots and integer operations on the bits, selections instead of branches, no tables: the same
 * bits on every machine that rounds to nearest and does not contract, and a loop over lanes vectorises from SSE2 on. The
 * float versions use float alone. Domain errors give NaN, poles infinity; underflow is gradual. NaN in gives NaN out. */
#ifndef NPH_CORE_FMATH_H
#define NPH_CORE_FMATH_H

#include <math.h>
#include <stdint.h>
#include <string.h>

static inline uint32_t nph_bitsf(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static inline float nph_from_bitsf(uint32_t bits) {
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static inline uint64_t nph_bits(double x) {
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static inline double nph_from_bits(uint64_t bits) {
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static inline float nph_infinityf(void) { return nph_from_bitsf(0x7f800000u); }
static inline double nph_infinity(void) { return nph_from_bits(0x7ff0000000000000u); }
static inline float nph_nanf(void) { return nph_from_bitsf(0x7fc00000u); }
static inline double nph_nan(void) { return nph_from_bits(0x7ff8000000000000u); }

static inline float nph_absf(float x) { return nph_from_bitsf(nph_bitsf(x) & 0x7fffffffu); }
static inline double nph_abs(double x) { return nph_from_bits(nph_bits(x) & 0x7fffffffffffffffu); }

/* |magnitude| with the sign bit of sign. */
static inline float nph_copysignf(float magnitude, float sign) {
    return nph_from_bitsf((nph_bitsf(magnitude) & 0x7fffffffu) | (nph_bitsf(sign) & 0x80000000u));
}

static inline double nph_copysign(double magnitude, double sign) {
    return nph_from_bits((nph_bits(magnitude) & 0x7fffffffffffffffu) | (nph_bits(sign) & 0x8000000000000000u));
}

/* Correctly rounded by IEEE 754. */
static inline float nph_sqrtf(float x) { return sqrtf(x); }
static inline double nph_sqrt(double x) { return sqrt(x); }

/* Adding 1.5 * 2^23 (2^52) leaves the nearest integer in the low bits of the sum: right for |x| <= 2^22 (2^51). */
#define NPH_SHIFTERF 12582912.0f
#define NPH_SHIFTER 6755399441055744.0

/* Nearest integer, ties to even, of any number: |x| + 2^23 has no bits for a fraction, larger |x| have none either. */
static inline float nph_rintf(float x) {
    float size = nph_absf(x), whole = (size + 8388608.0f) - 8388608.0f;
    return nph_copysignf(size < 8388608.0f ? whole : size, x);
}

static inline double nph_rint(double x) {
    double size = nph_abs(x), whole = (size + 4503599627370496.0) - 4503599627370496.0;
    return nph_copysign(size < 4503599627370496.0 ? whole : size, x);
}

/* Largest integer not above x; exact for every x, infinities and -0 keep themselves. */
static inline float nph_floorf(float x) {
    float near = nph_rintf(x);
    return near > x ? near - 1.0f : near;
}

static inline double nph_floor(double x) {
    double near = nph_rint(x);
    return near > x ? near - 1.0 : near;
}

/* 2^k for an integral k in [-126, 127] ([-1022, 1023]). */
static inline float nph_power_of_2f(float k) { return nph_from_bitsf((nph_bitsf(k + NPH_SHIFTERF) + 127u) << 23); }
static inline double nph_power_of_2(double k) { return nph_from_bits((nph_bits(k + NPH_SHIFTER) + 1023u) << 52); }

/* y 2^k for y in [1/2, 2], integral |k| <= 250 (2000): rounded once, in the last product, if that is subnormal. */
static inline float nph_scale_by_power_of_2f(float y, float k) {
    float half = (k * 0.5f + NPH_SHIFTERF) - NPH_SHIFTERF;
    return y * nph_power_of_2f(half) * nph_power_of_2f(k - half);
}

static inline double nph_scale_by_power_of_2(double y, double k) {
    double half = (k * 0.5 + NPH_SHIFTER) - NPH_SHIFTER;
    return y * nph_power_of_2(half) * nph_power_of_2(k - half);
}

/* A positive normal number as 2^exponent * mantissa, mantissa in [sqrt 1/2, sqrt 2). */
static inline float nph_mantissaf(float x, float *exponent) {
    uint32_t bits = nph_bitsf(x) + (0x3f800000u - 0x3f3504f3u);
    *exponent = (float)((int32_t)(bits >> 23) - 127);
    return nph_from_bitsf((bits & 0x007fffffu) + 0x3f3504f3u);
}

static inline double nph_mantissa(double x, double *exponent) {
    uint64_t bits = nph_bits(x) + (0x3ff0000000000000u - 0x3fe6a09e667f3bcdu);
    /* the biased exponent below the exponent of 2^52 makes 2^52 + itself: SSE2 and AVX2 convert no 64-bit integers */
    *exponent = nph_from_bits((bits >> 52) | 0x4330000000000000u) - (4503599627370496.0 + 1023.0);
    return nph_from_bits((bits & 0x000fffffffffffffu) + 0x3fe6a09e667f3bcdu);
}

#include "core/fmath_exp.h"
#include "core/fmath_log.h"
#include "core/fmath_trig.h"
#include "core/fmath_inverse.h"
#include "core/fmath_power.h"

#endif
