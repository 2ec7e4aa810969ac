/* SPDX-License-Identifier: Apache-2.0
 *
 * exp, expm1 and exp2 of fmath.h: x = k log 2 + r with |r| <= log(2)/2, exp(x) = 2^k (1 + r + r^2 P(r)). log 2 is split
 * so that k times its first part is exact [Cody80 ch. 6]. Coefficients: scripts/fmath_coefficients.py. */
#ifndef NPH_CORE_FMATH_EXP_H
#define NPH_CORE_FMATH_EXP_H

#include "core/fmath.h"

/* (exp(r) - 1 - r) / r^2 */
static inline float nph_exp_restf(float r) {
    return 0.5f + r * (0.16666666f + r * (0.041666493f + r * (0.008333547f + r * (0.001393229f + r * 0.00019760847f))));
}

static inline double nph_exp_rest(double r) {
    double high = 2.7557244408134725e-06 + r * (2.7557330116682963e-07 + r * (2.510894868229037e-08 +
                  r * 2.0895323835679602e-09));
    return 0.5 + r * (0.16666666666666677 + r * (0.04166666666666665 + r * (0.008333333333321593 +
           r * (0.0013888888888904422 + r * (0.00019841269886022636 + r * (2.4801587269713337e-05 + r * high))))));
}

/* (2^r - 1) for |r| <= 1/2 */
static inline float nph_exp2_smallf(float r) {
    float rest = 0.2402265f + r * (0.055504106f + r * (0.009618079f + r * (0.0013333865f + r * (0.00015455467f +
                 r * 1.519465e-05f))));
    return r * 0.6931472f + (r * -1.9046542e-09f + r * r * rest);
}

static inline double nph_exp2_small(double r) {
    double high = 1.3215486300071557e-06 + r * (1.0178058649734173e-07 + r * (7.055072114527648e-09 +
                  r * (4.4556109515732027e-10 + r * 2.5501688572143686e-11)));
    double rest = 0.24022650695910072 + r * (0.055504108664821604 + r * (0.00961812910762805 +
                  r * (0.0013333558146411577 + r * (0.0001540353039406121 + r * (1.5252733837258569e-05 + r * high)))));
    return r * 0.6931471805599453 + (r * 2.3190468138462996e-17 + r * r * rest);
}

static inline float nph_expf(float x) {
    x = x > 89.0f ? 89.0f : x < -104.0f ? -104.0f : x; /* the limits overflow and underflow */
    float k = (x * 1.442695f + NPH_SHIFTERF) - NPH_SHIFTERF;
    float r = (x - k * 0.69314575f) - k * 1.4286068e-06f;
    return nph_scale_by_power_of_2f(1.0f + (r + r * r * nph_exp_restf(r)), k);
}

static inline double nph_exp(double x) {
    x = x > 710.0 ? 710.0 : x < -746.0 ? -746.0 : x;
    double k = (x * 1.4426950408889634 + NPH_SHIFTER) - NPH_SHIFTER;
    double r = (x - k * 0.6931471805598903) - k * 5.497923018708371e-14;
    return nph_scale_by_power_of_2(1.0 + (r + r * r * nph_exp_rest(r)), k);
}

static inline float nph_exp2f(float x) {
    x = x > 129.0f ? 129.0f : x < -151.0f ? -151.0f : x;
    float k = (x + NPH_SHIFTERF) - NPH_SHIFTERF;
    return nph_scale_by_power_of_2f(1.0f + nph_exp2_smallf(x - k), k);
}

static inline double nph_exp2(double x) {
    x = x > 1025.0 ? 1025.0 : x < -1076.0 ? -1076.0 : x;
    double k = (x + NPH_SHIFTER) - NPH_SHIFTER;
    return nph_scale_by_power_of_2(1.0 + nph_exp2_small(x - k), k);
}

/* exp(x) - 1 = (2^k - 1) + 2^k (r + q), summed with the rounding error of its first two terms; all halved, since 2^128
 * (2^1024) is not a number. tail: the part of r lost in rounding. */
static inline float nph_expm1f(float x) {
    float limited = x > 89.0f ? 89.0f : x < -30.0f ? -30.0f : x;
    float k = (limited * 1.442695f + NPH_SHIFTERF) - NPH_SHIFTERF;
    float first = limited - k * 0.69314575f, second = k * 1.4286068e-06f;
    float r = first - second, tail = (first - r) - second;
    float q = r * r * nph_exp_restf(r) + tail;
    float scale = nph_power_of_2f(k - 1.0f), base = scale - 0.5f;
    float sum = base + scale * r, lost = scale * r - (sum - base);
    return nph_absf(x) < 2.9802322e-08f ? x : 2.0f * (sum + (lost + scale * q));
}

static inline double nph_expm1(double x) {
    double limited = x > 710.0 ? 710.0 : x < -60.0 ? -60.0 : x;
    double k = (limited * 1.4426950408889634 + NPH_SHIFTER) - NPH_SHIFTER;
    double first = limited - k * 0.6931471805598903, second = k * 5.497923018708371e-14;
    double r = first - second, tail = (first - r) - second;
    double q = r * r * nph_exp_rest(r) + tail;
    double scale = nph_power_of_2(k - 1.0), base = scale - 0.5;
    double sum = base + scale * r, lost = scale * r - (sum - base);
    return nph_abs(x) < 5.551115123125783e-17 ? x : 2.0 * (sum + (lost + scale * q));
}

#endif
