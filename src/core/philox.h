/* SPDX-License-Identifier: Apache-2.0
 *
 * Counter-based random numbers: Philox4x32-10 [Salmon11 table 2 and section 3.3], a keyed bijection of 128-bit counters.
 * Who draws which number is written in the counter, so threads, tiles and GPUs draw the same words in any order.
 * Plain 32- and 64-bit integer arithmetic on scalars: a loop over lanes that calls it vectorises. */
#ifndef NPH_CORE_PHILOX_H
#define NPH_CORE_PHILOX_H

#include <stdint.h>

typedef struct NphWords {
    uint32_t w0, w1, w2, w3;
} NphWords;

/* The upper half of a product, from those of 16-bit halves: no sum of them exceeds 32 bits. */
static inline uint32_t nph_philox_high(uint32_t a, uint32_t b) {
    uint32_t a0 = a & 0xffffu, a1 = a >> 16, b0 = b & 0xffffu, b1 = b >> 16;
    uint32_t middle = b1 * a0 + ((b0 * a0) >> 16), other = b0 * a1 + (middle & 0xffffu);
    return b1 * a1 + (middle >> 16) + (other >> 16);
}

/* One of the ten rounds; the keys of round n are those of the first plus n times the Weyl constants. AVX2 has no product
 * that keeps the upper halves of all lanes: gcc takes even and odd ones apart and joins them again, which costs more than
 * four short products (Zen 3, a block of words in a loop: 9.7 and 6.4 ns). */
static inline NphWords nph_philox_round(NphWords c, uint32_t key0, uint32_t key1) {
    const uint32_t factor0 = 0xD2511F53u, factor1 = 0xCD9E8D57u;
    NphWords next;
#if defined(__AVX2__) && !defined(__AVX512F__)
    next.w0 = nph_philox_high(factor1, c.w2) ^ c.w1 ^ key0;
    next.w1 = factor1 * c.w2;
    next.w2 = nph_philox_high(factor0, c.w0) ^ c.w3 ^ key1;
    next.w3 = factor0 * c.w0;
#else
    uint64_t product0 = (uint64_t)factor0 * c.w0, product1 = (uint64_t)factor1 * c.w2;
    next.w0 = (uint32_t)(product1 >> 32) ^ c.w1 ^ key0;
    next.w1 = (uint32_t)product1;
    next.w2 = (uint32_t)(product0 >> 32) ^ c.w3 ^ key1;
    next.w3 = (uint32_t)product0;
#endif
    return next;
}

/* Four random words for the counter (c0 lowest) under the key. */
static inline NphWords nph_philox(uint32_t key0, uint32_t key1, uint32_t c0, uint32_t c1, uint32_t c2, uint32_t c3) {
    const uint32_t weyl0 = 0x9E3779B9u, weyl1 = 0xBB67AE85u;
    NphWords c = {c0, c1, c2, c3};
    c = nph_philox_round(c, key0, key1);
    c = nph_philox_round(c, key0 + weyl0, key1 + weyl1);
    c = nph_philox_round(c, key0 + 2u * weyl0, key1 + 2u * weyl1);
    c = nph_philox_round(c, key0 + 3u * weyl0, key1 + 3u * weyl1);
    c = nph_philox_round(c, key0 + 4u * weyl0, key1 + 4u * weyl1);
    c = nph_philox_round(c, key0 + 5u * weyl0, key1 + 5u * weyl1);
    c = nph_philox_round(c, key0 + 6u * weyl0, key1 + 6u * weyl1);
    c = nph_philox_round(c, key0 + 7u * weyl0, key1 + 7u * weyl1);
    c = nph_philox_round(c, key0 + 8u * weyl0, key1 + 8u * weyl1);
    return nph_philox_round(c, key0 + 9u * weyl0, key1 + 9u * weyl1);
}

/* A word as a number in [0, 1): the largest is 1 - 2^-24 and 1 - 2^-32. Both conversions are exact. */
static inline float nph_uniformf(uint32_t word) { return (float)(int32_t)(word >> 8) * (1.0f / 16777216.0f); }

/* The word goes through a signed integer because SSE2 to AVX2 convert only those. */
static inline double nph_uniform(uint32_t word) {
    return ((double)(int32_t)(word ^ 0x80000000u) + 2147483648.0) * (1.0 / 4294967296.0);
}

#endif
