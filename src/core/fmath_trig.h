/* SPDX-License-Identifier: Apache-2.0
 *
 * sin, cos, tan (radians) and sincos2pi (turns) of fmath.h. Radians are reduced by pi/2 in parts whose products with the
 * quadrant are exact [Cody80 ch. 8]; that holds for |x| <= 8192 (float) and 2^20 (double). Beyond, the result is NaN:
 * nothing is returned that is not right. sincos2pi has no such limit. Coefficients: scripts/fmath_coefficients.py. */
#ifndef NPH_CORE_FMATH_TRIG_H
#define NPH_CORE_FMATH_TRIG_H

#include "core/fmath.h"

#define NPH_TRIG_LIMITF 8192.0f
#define NPH_TRIG_LIMIT 1048576.0

/* An angle as quadrant * pi/2 + (r + tail); only the last two bits of quadrant are meant. */
typedef struct NphAnglef {
    float r, tail;
    uint32_t quadrant;
} NphAnglef;

typedef struct NphAngle {
    double r, tail;
    uint64_t quadrant;
} NphAngle;

static inline NphAnglef nph_reduce_anglef(float x) {
    float shifted = x * 0.63661975f + NPH_SHIFTERF, k = shifted - NPH_SHIFTERF;
    float a = (x - k * 1.5703125f) - k * 0.0004837513f; /* exact */
    float second = k * 7.5495336e-08f, b = a - second, t = a - b;
    float lost = (a - (b + t)) + (t - second); /* b + lost = a - second */
    float third = k * 2.563283e-12f, c = b - third;
    t = b - c;
    lost += ((b - (c + t)) + (t - third)) - k * 6.123234e-17f;
    NphAnglef angle;
    angle.r = c + lost;
    angle.tail = (c - angle.r) + lost;
    angle.quadrant = nph_bitsf(shifted);
    return angle;
}

static inline NphAngle nph_reduce_angle(double x) {
    double shifted = x * 0.6366197723675814 + NPH_SHIFTER, k = shifted - NPH_SHIFTER;
    double a = x - k * 1.5707963267341256; /* exact */
    double second = k * 6.077100506303966e-11, b = a - second, t = a - b;
    double lost = (a - (b + t)) + (t - second);
    double third = k * 2.0222662487111665e-21, c = b - third;
    t = b - c;
    lost += ((b - (c + t)) + (t - third)) - k * 8.4784276603689e-32;
    NphAngle angle;
    angle.r = c + lost;
    angle.tail = (c - angle.r) + lost;
    angle.quadrant = nph_bits(shifted);
    return angle;
}

/* sin(q pi/2 + r) and cos(q pi/2 + r) from s = sin(r), c = cos(r): swapped in odd quadrants, signs from bit 1. */
static inline void nph_turn_quadrantf(uint32_t q, float s, float c, float *sine, float *cosine) {
    uint32_t swap = 0u - (q & 1u), a = nph_bitsf(s), b = nph_bitsf(c);
    *sine = nph_from_bitsf(((b & swap) | (a & ~swap)) ^ ((q & 2u) << 30));
    *cosine = nph_from_bitsf(((a & swap) | (b & ~swap)) ^ (((q + 1u) & 2u) << 30));
}

static inline void nph_turn_quadrant(uint64_t q, double s, double c, double *sine, double *cosine) {
    uint64_t swap = 0u - (q & 1u), a = nph_bits(s), b = nph_bits(c);
    *sine = nph_from_bits(((b & swap) | (a & ~swap)) ^ ((q & 2u) << 62));
    *cosine = nph_from_bits(((a & swap) | (b & ~swap)) ^ (((q + 1u) & 2u) << 62));
}

static inline void nph_sincosf(float x, float *sine, float *cosine) {
    NphAnglef angle = nph_reduce_anglef(x);
    float r = angle.r, z = r * r, half = 0.5f * z, w = 1.0f - half;
    float ps = -0.16666655f + z * (0.008332189f + z * -0.00019518283f);
    float pc = 0.041666646f + z * (-0.0013887313f + z * 2.443303e-05f);
    float s = r + (r * z * ps + angle.tail * w);
    float c = w + (((1.0f - w) - half) + (z * z * pc - r * angle.tail));
    nph_turn_quadrantf(angle.quadrant, s, c, &s, &c);
    float size = nph_absf(x);
    s = size < 0.00024414062f ? x : s; /* keeps -0 */
    *sine = size <= NPH_TRIG_LIMITF ? s : nph_nanf();
    *cosine = size <= NPH_TRIG_LIMITF ? c : nph_nanf();
}

static inline void nph_sincos(double x, double *sine, double *cosine) {
    NphAngle angle = nph_reduce_angle(x);
    double r = angle.r, z = r * r, half = 0.5 * z, w = 1.0 - half;
    double ps = 2.755731357808285e-06 + z * (-2.5050741600375537e-08 + z * 1.5895899360955595e-10);
    ps = -0.1666666666666663 + z * (0.008333333333321912 + z * (-0.00019841269829448714 + z * ps));
    double pc = -2.755731422106406e-07 + z * (2.087570606341385e-09 + z * -1.135878981549119e-11);
    pc = 0.041666666666666595 + z * (-0.001388888888887335 + z * (2.4801587289012332e-05 + z * pc));
    double s = r + (r * z * ps + angle.tail * w);
    double c = w + (((1.0 - w) - half) + (z * z * pc - r * angle.tail));
    nph_turn_quadrant(angle.quadrant, s, c, &s, &c);
    double size = nph_abs(x);
    s = size < 1.0536712127723509e-08 ? x : s;
    *sine = size <= NPH_TRIG_LIMIT ? s : nph_nan();
    *cosine = size <= NPH_TRIG_LIMIT ? c : nph_nan();
}

static inline float nph_sinf(float x) {
    float s, c;
    nph_sincosf(x, &s, &c);
    return s;
}

static inline double nph_sin(double x) {
    double s, c;
    nph_sincos(x, &s, &c);
    return s;
}

static inline float nph_cosf(float x) {
    float s, c;
    nph_sincosf(x, &s, &c);
    return c;
}

static inline double nph_cos(double x) {
    double s, c;
    nph_sincos(x, &s, &c);
    return c;
}

/* sin and cos of 2 pi x for every finite x: x less its nearest quarter turn is exact. A zero has either sign. */
static inline void nph_sincos2pif(float x, float *sine, float *cosine) {
    float turn = x - nph_rintf(x); /* NaN for an infinite x */
    float shifted = 4.0f * turn + NPH_SHIFTERF, r = turn - 0.25f * (shifted - NPH_SHIFTERF);
    float z = r * r, h = 19.739208f * z, w = 1.0f - h;
    float ps = -41.34167f + z * (81.5935f + z * -75.43349f);
    float pc = 64.93936f + z * (-85.44719f + z * 59.35197f);
    float s = r * 6.2831855f + (r * -1.7484555e-07f + r * z * ps);
    float c = w + (((1.0f - w) - h) + z * z * pc);
    nph_turn_quadrantf(nph_bitsf(shifted), s, c, sine, cosine);
}

static inline void nph_sincos2pi(double x, double *sine, double *cosine) {
    double turn = x - nph_rint(x);
    double shifted = 4.0 * turn + NPH_SHIFTER, r = turn - 0.25 * (shifted - NPH_SHIFTER);
    double z = r * r, h = 19.739208802178716 * z, w = 1.0 - h;
    double ps = 42.05868535964659 + z * (-15.093820842752022 + z * 3.7811839089774884);
    ps = -41.34170224039967 + z * (81.60524927596417 + z * (-76.70585970762063 + z * ps));
    double pc = -26.42625201436475 + z * (7.903139906288401 + z * -1.6976843882494392);
    pc = 64.93939402266818 + z * (-85.45681720659944 + z * (60.24464134161235 + z * pc));
    double s = r * 6.283185307179586 + (r * 2.4492935982947064e-16 + r * z * ps);
    double c = w + (((1.0 - w) - h) + z * z * pc);
    nph_turn_quadrant(nph_bits(shifted), s, c, sine, cosine);
}

/* tan(r) = t + low; in odd quadrants -1/(t + low): a = -1/t improved by one Newton step whose products are exact, since
 * t and a are cut to half their bits there [Ng93 k_tan]. */
static inline float nph_tanf(float x) {
    NphAnglef angle = nph_reduce_anglef(x);
    float r = angle.r, z = r * r;
    float p = 0.021286385f + z * (0.010826729f + z * (9.948752e-05f + z * 0.004371889f));
    p = 0.3333335f + z * (0.13332675f + z * (0.0540589f + z * p));
    p = r * z * p + angle.tail * (1.0f + z);
    float t = r + p, cut = nph_from_bitsf(nph_bitsf(t) & 0xfffff000u), low = p - (cut - r);
    float a = -1.0f / t, a_cut = nph_from_bitsf(nph_bitsf(a) & 0xfffff000u);
    float inverse = a_cut + a * ((1.0f + a_cut * cut) + a_cut * low);
    float size = nph_absf(x), y = (angle.quadrant & 1u) != 0u ? inverse : t;
    y = size < 0.00024414062f ? x : y;
    return size <= NPH_TRIG_LIMITF ? y : nph_nanf();
}

static inline double nph_tan(double x) {
    NphAngle angle = nph_reduce_angle(x);
    double r = angle.r, z = r * r;
    double p = -2.638697167013412e-05 + z * (8.945478848549277e-05 + z * (-4.4878838816293165e-05 +
               z * 2.0864038778330904e-05));
    p = 0.0014547580886083958 + z * (0.0005950643049281473 + z * (0.00022238066895530437 +
        z * (0.00013652487817695353 + z * p)));
    p = 0.05396825392664503 + z * (0.021869489609161765 + z * (0.008863219164873468 +
        z * (0.003592289061507375 + z * p)));
    p = 0.33333333333332776 + z * (0.1333333333341473 + z * p);
    p = r * z * p + angle.tail * (1.0 + z);
    double t = r + p, cut = nph_from_bits(nph_bits(t) & 0xffffffff00000000u), low = p - (cut - r);
    double a = -1.0 / t, a_cut = nph_from_bits(nph_bits(a) & 0xffffffff00000000u);
    double inverse = a_cut + a * ((1.0 + a_cut * cut) + a_cut * low);
    uint64_t odd = 0u - (angle.quadrant & 1u);
    double size = nph_abs(x), y = nph_from_bits((nph_bits(inverse) & odd) | (nph_bits(t) & ~odd));
    y = size < 1.0536712127723509e-08 ? x : y;
    return size <= NPH_TRIG_LIMIT ? y : nph_nan();
}

#endif
