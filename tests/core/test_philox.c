/* SPDX-License-Identifier: Apache-2.0
 *
 * Philox4x32-10 against the known-answer vectors published with Random123 [Salmon11], and the conversions to [0, 1). */
#include "core/philox.h"
#include "harness.h"

static void expect(NphWords got, uint32_t w0, uint32_t w1, uint32_t w2, uint32_t w3) {
    ck_assert_uint_eq(got.w0, w0);
    ck_assert_uint_eq(got.w1, w1);
    ck_assert_uint_eq(got.w2, w2);
    ck_assert_uint_eq(got.w3, w3);
}

START_TEST(published_known_answers_are_met) {
    const uint32_t ones = 0xffffffffu;
    expect(nph_philox(0, 0, 0, 0, 0, 0), 0x6627e8d5u, 0xe169c58du, 0xbc57ac4cu, 0x9b00dbd8u);
    expect(nph_philox(ones, ones, ones, ones, ones, ones), 0x408f276du, 0x41c83b0eu, 0xa20bc7c6u, 0x6d5451fdu);
    expect(nph_philox(0xa4093822u, 0x299f31d0u, 0x243f6a88u, 0x85a308d3u, 0x13198a2eu, 0x03707344u), 0xd16cfe09u,
           0x94fdccebu, 0x5001e420u, 0x24126ea1u);
}
END_TEST

START_TEST(lane_loop_draws_the_words_of_single_calls) {
    uint32_t lanes[4][37];
    for (uint32_t i = 0; i < 37; i++) {
        NphWords words = nph_philox(7, i, i * i, 1, 2, 3);
        lanes[0][i] = words.w0;
        lanes[1][i] = words.w1;
        lanes[2][i] = words.w2;
        lanes[3][i] = words.w3;
    }
    for (uint32_t i = 0; i < 37; i++) {
        volatile uint32_t alone = i; /* keeps the call out of a vector loop */
        expect(nph_philox(7, alone, alone * alone, 1, 2, 3), lanes[0][i], lanes[1][i], lanes[2][i], lanes[3][i]);
    }
}
END_TEST

START_TEST(every_bit_flip_changes_about_half_of_the_words_bits) {
    for (int bit = 0; bit < 192; bit++) {
        uint32_t in[6] = {1, 2, 3, 4, 5, 6};
        NphWords a = nph_philox(in[0], in[1], in[2], in[3], in[4], in[5]);
        in[bit / 32] ^= 1u << (bit % 32);
        NphWords b = nph_philox(in[0], in[1], in[2], in[3], in[4], in[5]);
        uint32_t difference[4] = {a.w0 ^ b.w0, a.w1 ^ b.w1, a.w2 ^ b.w2, a.w3 ^ b.w3};
        int changed = 0;
        for (int i = 0; i < 128; i++) changed += difference[i / 32] >> (i % 32) & 1u;
        /* 64 +- 5.7 at random: five standard deviations hold for all 192 with 1e-4 to spare */
        ck_assert_int_gt(changed, 35);
        ck_assert_int_lt(changed, 93);
    }
}
END_TEST

START_TEST(uniforms_are_exact_and_below_one) {
    ck_assert(nph_uniformf(0) == 0.0f && nph_uniform(0) == 0.0);
    ck_assert(nph_uniformf(0xffffffffu) == 1.0f - 0x1p-24f);
    ck_assert(nph_uniform(0xffffffffu) == 1.0 - 0x1p-32);
    ck_assert(nph_uniformf(0xffu) == 0.0f && nph_uniformf(0x100u) == 0x1p-24f);
    ck_assert(nph_uniform(1) == 0x1p-32 && nph_uniform(0x80000000u) == 0.5 && nph_uniformf(0x80000000u) == 0.5f);
    for (uint32_t i = 0; i < 100000; i++) {
        uint32_t word = nph_philox(0, 0, i, 0, 0, 0).w0;
        ck_assert(nph_uniform(word) == (double)word / 4294967296.0);
        ck_assert(nph_uniformf(word) == (float)((double)(word >> 8) / 16777216.0));
    }
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, published_known_answers_are_met);
    tcase_add_test(cases, lane_loop_draws_the_words_of_single_calls);
    tcase_add_test(cases, every_bit_flip_changes_about_half_of_the_words_bits);
    tcase_add_test(cases, uniforms_are_exact_and_below_one);
}

int main(void) { return nph_test_main("philox", fill); }
