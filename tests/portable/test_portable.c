/* SPDX-License-Identifier: Apache-2.0
 *
 * nephos/portable.h against the library's own kernels, bit for bit, at every vector level, and against reference/vectors.
 * scripts/check_portable compiles it as the other languages. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "nephos/portable.h"

#include "../../reference/vectors/vectors.h"
#include "evaluate.h"
#include "harness.h"
#include "kernel_portable.h"
#include "rows.h"

enum { BLOCK = 4096, BLOCKS = 256 }; /* 1048576 inputs */

static uint32_t blocks[3][BLOCK * NPH_WORDS_IN]; /* in, then results of the header and of the kernel */

static uint32_t random_word(uint32_t i, uint32_t draw) { return nph_philox(7u, draw, i, 0u, 0u, 0u).w0; }
static float random_between(float low, float high, uint32_t i, uint32_t draw) {
    return low + (high - low) * nph_uniformf(random_word(i, draw));
}

/* A uniform number, at times one of its ends. */
static float random_part(uint32_t i, uint32_t draw) {
    uint32_t word = random_word(i, draw);
    return (word & 255u) == 0u ? 0.0f : (word & 255u) == 1u ? 1.0f - 0x1p-24f : nph_uniformf(word);
}

/* |g| up to 0.99999, as often near 1 as not. */
static float random_g(uint32_t i, uint32_t draw) {
    float near_one = 1.0f - nph_expf(random_between(-11.5f, 0.0f, i, draw));
    float size = random_word(i, draw + 50u) & 1u ? near_one : nph_uniformf(random_word(i, draw + 51u));
    size = (random_word(i, draw + 52u) & 63u) == 0u ? 0.0f : size < 0.99999f ? size : 0.99999f;
    return random_word(i, draw + 53u) & 1u ? -size : size;
}

static NphPhasef random_phase(uint32_t i, uint32_t *in) {
    int kind = (int)(random_word(i, 0u) % 5u);
    float g0 = random_g(i, 100u), g1 = random_g(i, 200u), weight = random_part(i, 1u);
    float alpha = nph_expf(random_between(-5.0f, 6.9f, i, 2u));
    NphPhasef phase = nph_phase_of(kind, (double)g0, (double)g1, (double)weight, (double)alpha);
    const float words[] = {g0, g1, phase.rest0, phase.rest1, weight, phase.draine.alpha, phase.draine.norm,
                           phase.draine.scale, phase.draine.split};
    in[0] = (uint32_t)phase.kind;
    memcpy(in + 1, words, sizeof words);
    return phase;
}

static void random_direction(uint32_t i, float *d) {
    float z = random_between(-1.0f, 1.0f, i, 20u), radius = nph_sqrtf(1.0f - z * z);
    nph_sincos2pif(nph_uniformf(random_word(i, 21u)), &d[1], &d[0]);
    d[0] *= radius;
    d[1] *= radius;
    d[2] = z;
}

static void phase_input(int function, uint32_t i, uint32_t *in) {
    float fall = 2.0f * random_part(i, 10u), g = random_g(i, 100u), size = nph_absf(g), u = random_part(i, 11u);
    float words[NPH_WORDS_IN] = {0};
    NphPhasef phase = random_phase(i, in);
    NphDrainef draine = nph_draine((double)g, (double)nph_expf(random_between(-5.0f, 6.9f, i, 2u)));
    if (function == F_hg_value) words[0] = g, words[1] = 1.0f - size, words[2] = fall, words[3] = 2.0f - fall;
    if (function == F_hg_sample) words[0] = g, words[1] = 1.0f - size, words[2] = u;
    if (function == F_rayleigh_value) words[0] = fall, words[1] = 2.0f - fall;
    if (function == F_rayleigh_sample) words[0] = u;
    if (function == F_draine_value || function == F_draine_sample)
        words[0] = g, words[1] = 1.0f - size, words[2] = draine.alpha;
    if (function == F_draine_value) words[3] = draine.scale, words[4] = fall, words[5] = 2.0f - fall;
    if (function == F_draine_sample) words[3] = draine.norm, words[4] = draine.split, words[5] = u;
    if (function == F_turn_by) {
        random_direction(i, words);
        words[3] = 1.0f - fall, words[4] = fall, words[5] = 2.0f - fall, words[6] = u;
    }
    if (function == F_phase_of) words[1] = phase.g0, words[2] = phase.g1, words[3] = phase.weight, words[4] = u;
    if (function == F_phase_at) words[10] = fall, words[11] = 2.0f - fall;
    if (function == F_phase_angle) words[10] = u, words[11] = random_part(i, 12u);
    if (function == F_phase_at || function == F_phase_angle) memcpy(in + 10, words + 10, 2 * sizeof words[0]);
    else memcpy(in, words, sizeof words);
    if (function == F_phase_of) in[0] = (uint32_t)phase.kind;
}

/* Functions of one number see every 4095th of all bit patterns; of several, in turn any bits and usual numbers. */
static void input_number(int function, uint32_t i, uint32_t *in) {
    memset(in, 0, NPH_WORDS_IN * sizeof *in);
    if (function >= F_hg_value) {
        phase_input(function, i, in);
        return;
    }
    for (uint32_t k = 0; k < 6; k++) {
        float usual = random_between(-4.0f, 4.0f, i, 30u + k);
        in[k] = function != F_philox && i % 2u == 0u ? nph_bitsf(usual) : random_word(i, 40u + k);
    }
    if (function != F_philox && function != F_quotient && function != F_product_sum && function != F_atan2 && function != F_pow)
        in[0] = i * 4095u;
}

static void canonical(int function, uint32_t *out, int count) {
    for (int i = 0; i < count; i++)
        for (int k = 0; k < nph_rows_results(function); k++)
            out[i * NPH_WORDS_OUT + k] = nph_rows_comparable(function, k, out[i * NPH_WORDS_OUT + k]);
}

static void header_rows(int function, const uint32_t *in, uint32_t *out, int count) {
    for (int i = 0; i < count; i++) nph_evaluate(function, &in[i * NPH_WORDS_IN], &out[i * NPH_WORDS_OUT]);
}

START_TEST(bits_are_those_of_the_kernels_at_every_level) {
    void (*rows)(int, const uint32_t *, uint32_t *, int);
    uint32_t *in = blocks[0], *header = blocks[1], *kernel = blocks[2];
    size_t bytes = BLOCK * NPH_WORDS_OUT * sizeof *header;
    int quick = getenv("NEPHOS_TEST_QUICK") != NULL;
    for (uint32_t block = 0; block < (quick ? 4u : BLOCKS); block++) {
        for (uint32_t i = 0; i < BLOCK; i++) input_number(_i, block * BLOCK + i, &in[i * NPH_WORDS_IN]);
        memset(header, 0, bytes);
        header_rows(_i, in, header, BLOCK);
        canonical(_i, header, BLOCK);
        for (int isa = 0; isa <= (int)nph_cpu_isa(); isa++) {
            NPH_KERNEL_PICK(rows, portable_rows, (NphIsa)isa, 32);
            memset(kernel, 0, bytes);
            rows(_i, in, kernel, BLOCK);
            canonical(_i, kernel, BLOCK);
            ck_assert_msg(memcmp(header, kernel, bytes) == 0, "%s: block %u at level %d differs", nph_rows_function(_i),
                          block, isa);
        }
    }
}
END_TEST

static Row all[NPH_ROWS_MOST];

START_TEST(vectors_are_met_to_the_bit) {
    int count = nph_rows_read(all), seen[F_COUNT] = {0};
    for (int i = 0; i < count; i++) {
        uint32_t out[NPH_WORDS_OUT] = {0};
        nph_evaluate(all[i].function, all[i].in, out);
        canonical(all[i].function, out, 1);
        ck_assert_msg(memcmp(out, all[i].out, sizeof out) == 0, "%s(%08x ...) = %08x ..., not %08x ...",
                      nph_rows_function(all[i].function), (unsigned)all[i].in[0], (unsigned)out[0], (unsigned)all[i].out[0]);
        seen[all[i].function]++;
    }
    for (int f = 0; f < F_COUNT; f++) ck_assert_msg(seen[f] >= 8, "%s has %d vectors", nph_rows_function(f), seen[f]);
}
END_TEST

/* tests/kat_vectors of Random123, lines "philox4x32 10": counter, key, words. */
START_TEST(first_philox_vectors_are_the_published_ones) {
    static const uint32_t published[3][10] = {
        {0, 0, 0, 0, 0, 0, 0x6627e8d5u, 0xe169c58du, 0xbc57ac4cu, 0x9b00dbd8u},
        {0xffffffffu, 0xffffffffu, 0xffffffffu, 0xffffffffu, 0xffffffffu, 0xffffffffu, 0x408f276du, 0x41c83b0eu,
         0xa20bc7c6u, 0x6d5451fdu},
        {0x243f6a88u, 0x85a308d3u, 0x13198a2eu, 0x03707344u, 0xa4093822u, 0x299f31d0u, 0xd16cfe09u, 0x94fdccebu,
         0x5001e420u, 0x24126ea1u}};
    nph_rows_read(all);
    for (int i = 0; i < 3; i++) {
        ck_assert_int_eq(all[i].function, F_philox);
        ck_assert_mem_eq(all[i].in, &published[i][4], 2 * sizeof(uint32_t));
        ck_assert_mem_eq(&all[i].in[2], published[i], 4 * sizeof(uint32_t));
        ck_assert_mem_eq(all[i].out, &published[i][6], 4 * sizeof(uint32_t));
    }
}
END_TEST

static const struct {
    const uint32_t *in, *out;
    size_t words_in, words_out, count;
} constants[F_COUNT] = {
#define CONSTANTS(name, arguments, results)                                                                       \
    {nph_##name##_in, nph_##name##_out, sizeof nph_##name##_in / sizeof(uint32_t),                                 \
     sizeof nph_##name##_out / sizeof(uint32_t), nph_##name##_count},
    NPH_FUNCTIONS(CONSTANTS)
};

START_TEST(constants_for_c_are_the_vectors) {
    int count = nph_rows_read(all);
    size_t next[F_COUNT] = {0};
    for (int i = 0; i < count; i++) {
        int f = all[i].function;
        size_t in = constants[f].words_in / constants[f].count, out = constants[f].words_out / constants[f].count;
        ck_assert_uint_lt(next[f], constants[f].count);
        ck_assert_mem_eq(&constants[f].in[next[f] * in], all[i].in, in * sizeof(uint32_t));
        ck_assert_mem_eq(&constants[f].out[next[f] * out], all[i].out, out * sizeof(uint32_t));
        ck_assert_int_eq((int)out, nph_rows_results(f));
        next[f]++;
    }
    for (int f = 0; f < F_COUNT; f++) ck_assert_uint_eq(next[f], constants[f].count);
}
END_TEST

/* The next word 0x........u of a file; 0 at its end. */
static int next_word(FILE *file, uint32_t *word) {
    for (int c = fgetc(file); c != EOF; c = fgetc(file)) {
        unsigned value;
        if (c == '0' && fscanf(file, "x%8xu", &value) == 1) {
            *word = value;
            return 1;
        }
    }
    return 0;
}

START_TEST(constants_for_shaders_are_those_for_c) {
    static const char *const names[] = {"reference/vectors/vectors.glsl", "reference/vectors/vectors.wgsl"};
    FILE *file = fopen(nph_test_path(names[_i]), "r");
    uint32_t word;
    ck_assert_ptr_nonnull(file);
    for (int f = 0; f < F_COUNT; f++) {
        for (size_t k = 0; k < constants[f].words_in; k++)
            ck_assert(next_word(file, &word) && word == constants[f].in[k]);
        for (size_t k = 0; k < constants[f].words_out; k++)
            ck_assert(next_word(file, &word) && word == constants[f].out[k]);
    }
    ck_assert(!next_word(file, &word));
    fclose(file);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_loop_test(cases, bits_are_those_of_the_kernels_at_every_level, 0, F_COUNT);
    tcase_add_test(cases, vectors_are_met_to_the_bit);
    tcase_add_test(cases, first_philox_vectors_are_the_published_ones);
    tcase_add_test(cases, constants_for_c_are_the_vectors);
    tcase_add_loop_test(cases, constants_for_shaders_are_those_for_c, 0, 2);
}

int main(void) { return nph_test_main("portable", fill); }
