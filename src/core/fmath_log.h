/* SPDX-License-Identifier: Apache-2.0
 *
 * log and log1p of fmath.h: x = 2^k (1 + f), log(x) = k log 2 + log(1 + f). In float log(1 + f) is a polynomial of f; in
 * double it is f - f^2/2 + s (f^2/2 + R), s = f / (2 + f), R = 2 (atanh(s) - s) / s, whose rounding errors are all small
 * against f [Ng93]. Coefficients: scripts/fmath_coefficients.py. */
#ifndef NPH_CORE_FMATH_LOG_H
#define NPH_CORE_FMATH_LOG_H

#include "core/fmath.h"

/* k log 2 + log(1 + f) + extra for f in [sqrt(1/2) - 1, sqrt(2) - 1] and a small extra */
static inline float nph_log_of_partsf(float k, float f, float extra) {
    float z = f * f;
    float p = 0.14220244f + f * (-0.12408135f + f * (0.118859425f + f * (-0.11660855f + f * 0.06734632f)));
    p = 0.33333313f + f * (-0.25000012f + f * (0.20002073f + f * (-0.16667858f + f * p)));
    float rest = f * z * p + (extra + k * 1.4286068e-06f);
    return k * 0.69314575f + (f - (0.5f * z - rest));
}

static inline double nph_log_of_parts(double k, double f, double extra) {
    double s = f / (2.0 + f), z = s * s, half = 0.5 * f * f;
    double p = 0.11111099308895597 + z * (0.09091781042096764 + z * (0.0765705351165287 + z * 0.07397688774589833));
    p = 0.3333333333333367 + z * (0.19999999999708457 + z * (0.14285714370965394 + z * p));
    double rest = s * (half + 2.0 * z * p) + (extra + k * 5.497923018708371e-14);
    return k * 0.6931471805598903 + (f - (half - rest));
}

/* log(0) = -inf, log of a negative number NaN */
static inline float nph_logf(float x) {
    float k, subnormal = x < 1.1754944e-38f ? 25.0f : 0.0f;
    float m = nph_mantissaf(x < 1.1754944e-38f ? x * 33554432.0f : x, &k);
    float y = nph_log_of_partsf(k - subnormal, m - 1.0f, 0.0f);
    y = x <= 3.4028235e+38f ? y : x;
    return x > 0.0f ? y : x == 0.0f ? -nph_infinityf() : nph_nanf();
}

static inline double nph_log(double x) {
    double k, subnormal = x < 2.2250738585072014e-308 ? 54.0 : 0.0;
    double m = nph_mantissa(x < 2.2250738585072014e-308 ? x * 18014398509481984.0 : x, &k);
    double y = nph_log_of_parts(k - subnormal, m - 1.0, 0.0);
    y = x <= 1.7976931348623157e+308 ? y : x;
    return x > 0.0 ? y : x == 0.0 ? -nph_infinity() : nph_nan();
}

/* log(1 + x) with u = 1 + x rounded and lost = (1 + x) - u: log(u) + lost / u; where k = 0 simply f = x. */
static inline float nph_log1pf(float x) {
    float u = 1.0f + x, shift = u - 1.0f, lost = (1.0f - (u - shift)) + (x - shift), k;
    float m = nph_mantissaf(u, &k);
    float y = nph_log_of_partsf(k, k == 0.0f ? x : m - 1.0f, k == 0.0f ? 0.0f : lost / u);
    y = nph_absf(x) < 2.9802322e-08f ? x : y;
    y = x <= 3.4028235e+38f ? y : x;
    return x > -1.0f ? y : x == -1.0f ? -nph_infinityf() : nph_nanf();
}

static inline double nph_log1p(double x) {
    double u = 1.0 + x, shift = u - 1.0, lost = (1.0 - (u - shift)) + (x - shift), k;
    double m = nph_mantissa(u, &k);
    double y = nph_log_of_parts(k, k == 0.0 ? x : m - 1.0, k == 0.0 ? 0.0 : lost / u);
    y = nph_abs(x) < 5.551115123125783e-17 ? x : y;
    y = x <= 1.7976931348623157e+308 ? y : x;
    return x > -1.0 ? y : x == -1.0 ? -nph_infinity() : nph_nan();
}

#endif
