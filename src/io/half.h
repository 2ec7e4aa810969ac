/* SPDX-License-Identifier: Apache-2.0
 *
 * IEEE 754 binary16 ("half") to and from float in integer arithmetic: the same bits on every machine, NaN payloads
 * kept, no table and no vector instruction. Float to half rounds to nearest, ties to even. */
#ifndef NPH_IO_HALF_H
#define NPH_IO_HALF_H

#include <stdint.h>
#include <string.h>

/* Exact: every half is a float. Subnormals are m 2^-24, m < 1024. */
static inline float nph_float_from_half(uint16_t half) {
    uint32_t sign = (uint32_t)(half & 0x8000u) << 16, exponent = half >> 10 & 31u, mantissa = half & 1023u, bits;
    if (exponent == 31) bits = sign | 0x7f800000u | mantissa << 13;
    else if (exponent > 0) bits = sign | (exponent + 112) << 23 | mantissa << 13;
    else if (mantissa == 0) bits = sign;
    else {
        uint32_t shift = 0;
        while (!(mantissa & 1024u)) {
            mantissa <<= 1;
            shift++;
        }
        bits = sign | (113 - shift) << 23 | (mantissa & 1023u) << 13;
    }
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* From 65520 on the result is infinity; NaN stays NaN. */
static inline uint16_t nph_half_from_float(float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    uint32_t sign = bits >> 16 & 0x8000u, size = bits & 0x7fffffffu;
    if (size > 0x7f800000u) { /* the upper payload bits; one is set where they are all zero */
        uint32_t payload = size >> 13 & 1023u;
        return (uint16_t)(sign | 0x7c00u | (payload ? payload : 512u));
    }
    if (size >= 0x477ff000u) return (uint16_t)(sign | 0x7c00u);
    if (size >= 0x38800000u) { /* normal: from 2^-14 */
        uint32_t rounded = size + 0xfffu + (size >> 13 & 1u);
        return (uint16_t)(sign | (rounded - 0x38000000u) >> 13);
    }
    if (size < 0x33000000u) return (uint16_t)sign; /* below 2^-25 */
    uint32_t shift = 126 - (size >> 23), mantissa = (size & 0x7fffffu) | 0x800000u;
    uint32_t kept = mantissa >> shift, rest = mantissa & ((1u << shift) - 1), half = 1u << (shift - 1);
    kept += rest > half || (rest == half && (kept & 1u));
    return (uint16_t)(sign | kept);
}

#endif
