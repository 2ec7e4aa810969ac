/* SPDX-License-Identifier: Apache-2.0
 *
 * cbrt and pow of fmath.h. cbrt: a polynomial start, then Halley's iteration, the last with a start short enough for its
 * square to be exact. pow: 2^(y log2 x), log2 x and the product as unevaluated sums of two numbers [Dekker71], because
 * an error of y log2 x is multiplied by up to 128 (1024). Coefficients: scripts/fmath_coefficients.py. */
#ifndef NPH_CORE_FMATH_POWER_H
#define NPH_CORE_FMATH_POWER_H

#include "core/fmath_exp.h"

/* high + low, |low| at most half an ulp of high */
typedef struct NphPairf {
    float high, low;
} NphPairf;

typedef struct NphPair {
    double high, low;
} NphPair;

/* a + b exactly */
static inline NphPairf nph_exact_sumf(float a, float b) {
    float sum = a + b, from_b = sum - a;
    NphPairf pair = {sum, (a - (sum - from_b)) + (b - from_b)};
    return pair;
}

static inline NphPair nph_exact_sum(double a, double b) {
    double sum = a + b, from_b = sum - a;
    return (NphPair){sum, (a - (sum - from_b)) + (b - from_b)};
}

/* a * b exactly unless it over- or underflows: both are cut into halves whose products are exact. */
static inline NphPairf nph_exact_productf(float a, float b) {
    float ta = 4097.0f * a, ah = ta - (ta - a), al = a - ah, tb = 4097.0f * b, bh = tb - (tb - b), bl = b - bh;
    float product = a * b;
    NphPairf pair = {product, ((ah * bh - product) + ah * bl + al * bh) + al * bl};
    return pair;
}

static inline NphPair nph_exact_product(double a, double b) {
    double ta = 134217729.0 * a, ah = ta - (ta - a), al = a - ah, tb = 134217729.0 * b, bh = tb - (tb - b), bl = b - bh;
    double product = a * b;
    return (NphPair){product, ((ah * bh - product) + ah * bl + al * bh) + al * bl};
}

static inline float nph_cbrtf(float x) {
    float size = nph_absf(x), subnormal = size < 1.1754944e-38f ? 8.0f : 0.0f;
    uint32_t bits = nph_bitsf(subnormal > 0.0f ? size * 16777216.0f : size);
    float exponent = (float)((int32_t)(bits >> 23) - 127), m = nph_from_bitsf((bits & 0x007fffffu) | 0x3f800000u);
    float third = (exponent * 0.33333334f + NPH_SHIFTERF) - NPH_SHIFTERF, left = exponent - 3.0f * third;
    float start = 0.62153155f + m * (0.4394218f + m * -0.06031519f);
    start *= left < 0.0f ? 0.7937005f : left > 0.0f ? 1.2599211f : 1.0f;
    m *= left < 0.0f ? 0.5f : left > 0.0f ? 2.0f : 1.0f;
    float t = nph_from_bitsf(nph_bitsf(start) & 0xfffff000u), quotient = m / (t * t);
    float root = (t + t * ((quotient - t) / (t + t + quotient))) * nph_power_of_2f(third - subnormal);
    return size > 0.0f && size <= 3.4028235e+38f ? nph_copysignf(root, x) : x;
}

static inline double nph_cbrt(double x) {
    double size = nph_abs(x), subnormal = size < 2.2250738585072014e-308 ? 18.0 : 0.0;
    uint64_t bits = nph_bits(subnormal > 0.0 ? size * 18014398509481984.0 : size);
    double exponent = nph_from_bits((bits >> 52) | 0x4330000000000000u) - (4503599627370496.0 + 1023.0);
    double m = nph_from_bits((bits & 0x000fffffffffffffu) | 0x3ff0000000000000u);
    double third = (exponent * 0.3333333333333333 + NPH_SHIFTER) - NPH_SHIFTER, left = exponent - 3.0 * third;
    double start = 0.6215315205614274 + m * (0.43942184373714405 + m * -0.060315206116787944);
    start *= left < 0.0 ? 0.7937005259840998 : left > 0.0 ? 1.2599210498948732 : 1.0;
    m *= left < 0.0 ? 0.5 : left > 0.0 ? 2.0 : 1.0;
    double cube = start * start * start;
    start += start * ((m - cube) / (cube + cube + m));
    double t = nph_from_bits(nph_bits(start) & 0xfffffffff8000000u), quotient = m / (t * t);
    double root = (t + t * ((quotient - t) / (t + t + quotient))) * nph_power_of_2(third - subnormal);
    return size > 0.0 && size <= 1.7976931348623157e+308 ? nph_copysign(root, x) : x;
}

/* log2(x) of a positive, finite x. With x = 2^k (1 + f), s = f / (2 + f), z = s^2:
 * log2 x = k + 2 / log 2 (s + s (z/3 + z^2 W(z))), all but W as pairs. */
static inline NphPairf nph_log2_pairf(float x) {
    float k, subnormal = x < 1.1754944e-38f ? 25.0f : 0.0f;
    float f = nph_mantissaf(x < 1.1754944e-38f ? x * 33554432.0f : x, &k) - 1.0f;
    NphPairf d = nph_exact_sumf(2.0f, f);
    float s = f / d.high;
    NphPairf p = nph_exact_productf(s, d.high);
    float s_low = (((f - p.high) - p.low) - s * d.low) / d.high;
    NphPairf z = nph_exact_productf(s, s);
    z.low += 2.0f * s * s_low;
    NphPairf q = nph_exact_productf(z.high, 0.33333334f);
    float w = 0.20000076f + z.high * (0.14273556f + z.high * 0.117093086f);
    q.low += z.high * -9.934108e-09f + z.low * 0.33333334f + z.high * z.high * w;
    NphPairf u = nph_exact_productf(s, q.high);
    u.low += s * q.low + s_low * q.high;
    NphPairf v = nph_exact_sumf(s, u.high);
    v.low += s_low + u.low;
    NphPairf t = nph_exact_productf(v.high, 2.88539f);
    t.low += v.high * 3.851926e-08f + v.low * 2.88539f;
    NphPairf sum = nph_exact_sumf(k - subnormal, t.high);
    return nph_exact_sumf(sum.high, sum.low + t.low);
}

static inline NphPair nph_log2_pair(double x) {
    double k, subnormal = x < 2.2250738585072014e-308 ? 54.0 : 0.0;
    double f = nph_mantissa(x < 2.2250738585072014e-308 ? x * 18014398509481984.0 : x, &k) - 1.0;
    NphPair d = nph_exact_sum(2.0, f);
    double s = f / d.high;
    NphPair p = nph_exact_product(s, d.high);
    double s_low = (((f - p.high) - p.low) - s * d.low) / d.high;
    NphPair z = nph_exact_product(s, s);
    z.low += 2.0 * s * s_low;
    NphPair q = nph_exact_product(z.high, 0.3333333333333333);
    double w = 0.09090892163399049 + z.high * (0.07693379352598775 + z.high * (0.06628399032226814 +
               z.high * 0.06598197132878057));
    w = 0.2000000000000113 + z.high * (0.14285714285048146 + z.high * (0.11111111260238324 + z.high * w));
    q.low += z.high * 1.850371707708594e-17 + z.low * 0.3333333333333333 + z.high * z.high * w;
    NphPair u = nph_exact_product(s, q.high);
    u.low += s * q.low + s_low * q.high;
    NphPair v = nph_exact_sum(s, u.high);
    v.low += s_low + u.low;
    NphPair t = nph_exact_product(v.high, 2.8853900817779268);
    t.low += v.high * 4.0710547481862066e-17 + v.low * 2.8853900817779268;
    NphPair sum = nph_exact_sum(k - subnormal, t.high);
    return nph_exact_sum(sum.high, sum.low + t.low);
}

/* x^y with the special cases of C99 annex F: 1 for y = 0 or x = 1 whatever the other is; NaN for a negative finite x and
 * a y that is no integer. |y| is limited where every x but 1 has long over- or underflowed. */
static inline float nph_powf(float x, float y) {
    float size = nph_absf(x), limited = y > 1099511627776.0f ? 1099511627776.0f : y;
    limited = limited < -1099511627776.0f ? -1099511627776.0f : limited; /* 2^40 */
    NphPairf logarithm = nph_log2_pairf(size), t = nph_exact_productf(limited, logarithm.high);
    t.low += limited * logarithm.low;
    float high = t.high > 200.0f ? 200.0f : t.high < -200.0f ? -200.0f : t.high;
    float low = high == t.high ? t.low : 0.0f, n = (high + NPH_SHIFTERF) - NPH_SHIFTERF;
    float power = nph_scale_by_power_of_2f(1.0f + nph_exp2_smallf((high - n) + low), n);
    power = size > 0.0f ? power : y > 0.0f ? 0.0f : nph_infinityf();
    power = size <= 3.4028235e+38f ? power : y > 0.0f ? nph_infinityf() : 0.0f;
    float fraction = y - nph_floorf(y), odd = y - 2.0f * nph_floorf(0.5f * y); /* odd: 1 where y is odd */
    odd = fraction == 0.0f ? odd : 0.0f; /* rounding makes -0.99999994 + 2 odd */
    power = odd == 1.0f ? nph_copysignf(power, x) : power;
    fraction = x < 0.0f ? (size <= 3.4028235e+38f ? fraction : 0.0f) : 0.0f;
    power = fraction > 0.0f ? nph_nanf() : power;
    power = x == x ? (y == y ? power : nph_nanf()) : nph_nanf();
    return y == 0.0f ? 1.0f : x == 1.0f ? 1.0f : power;
}

static inline double nph_pow(double x, double y) {
    double size = nph_abs(x), limited = y > 0x1p70 ? 0x1p70 : y < -0x1p70 ? -0x1p70 : y;
    NphPair logarithm = nph_log2_pair(size), t = nph_exact_product(limited, logarithm.high);
    t.low += limited * logarithm.low;
    double high = t.high > 1200.0 ? 1200.0 : t.high < -1200.0 ? -1200.0 : t.high;
    double low = high == t.high ? t.low : 0.0, n = (high + NPH_SHIFTER) - NPH_SHIFTER;
    double power = nph_scale_by_power_of_2(1.0 + nph_exp2_small((high - n) + low), n);
    power = size > 0.0 ? power : y > 0.0 ? 0.0 : nph_infinity();
    power = size <= 1.7976931348623157e+308 ? power : y > 0.0 ? nph_infinity() : 0.0;
    double fraction = y - nph_floor(y), odd = y - 2.0 * nph_floor(0.5 * y);
    odd = fraction == 0.0 ? odd : 0.0;
    power = odd == 1.0 ? nph_copysign(power, x) : power;
    fraction = x < 0.0 ? (size <= 1.7976931348623157e+308 ? fraction : 0.0) : 0.0;
    power = fraction > 0.0 ? nph_nan() : power;
    power = x == x ? (y == y ? power : nph_nan()) : nph_nan();
    return y == 0.0 ? 1.0 : x == 1.0 ? 1.0 : power;
}

#endif
