/* SPDX-License-Identifier: Apache-2.0
 *
 * The lookup as kernels see it: the same bits at every vector level, f32 beside f64, offsets beyond 2^31. */
#define _GNU_SOURCE
#include <sys/mman.h>

#include "core/cpu.h"
#include "field_fixtures.h"

enum { POSITIONS = 5003 }; /* more than a block, not a multiple of any vector */

static double noise(int x, int y, int z, void *user) {
    (void)x, (void)y, (void)z;
    double unit = random_unit(user);
    return unit < 0.3 ? 0 : exp(30 * unit - 20);
}

static NphGrid noisy_grid(NphContext *context, NphLookup lookup) {
    uint64_t state = 11;
    NphArray array = field_array(context, (int[]){37, 22, 19}, noise, &state);
    NphGrid grid;
    ck_assert_int_eq(nph_grid_from_array(context, &array, (double[]){0, 0, 0}, (double[]){1, 2, 3}, NPH_CENTRING_CELL,
                                         NPH_OUTSIDE_CLAMP, lookup, "noise", &grid),
                     NPH_OK);
    nph_array_free(context, &array);
    return grid;
}

/* Inside, on samples and faces, and outside the box. */
static void draw_positions(const NphGrid *grid, float at[3][POSITIONS], double at64[3][POSITIONS]) {
    uint64_t state = 23;
    for (int i = 0; i < POSITIONS; i++)
        for (int a = 0; a < 3; a++) {
            float u = (float)(random_unit(&state) * (grid->n[a] + 1) - 1);
            if (random_below(&state, 5) == 0) u = floorf(u);
            if (random_below(&state, 5) == 0) u = floorf(u) + 0.5f;
            if (i < 3000) u = (float)(grid->lo[a] + random_unit(&state) * (grid->hi[a] - grid->lo[a]));
            at[a][i] = u;
            at64[a][i] = (double)u;
        }
}

START_TEST(vector_levels_and_threads_give_the_same_bits) {
    static float at[3][POSITIONS], out[POSITIONS], expected[POSITIONS];
    static double at64[3][POSITIONS], out64[POSITIONS], expected64[POSITIONS];
    for (int lookup = NPH_LOOKUP_NEAREST; lookup <= NPH_LOOKUP_TRILINEAR; lookup++)
        for (int level = NPH_ISA_BASE; level <= NPH_ISA_AVX512; level++) {
            if ((NphIsa)level > nph_cpu_isa()) {
                nph_test_skip("grid lookup at a vector level this machine does not have");
                continue;
            }
            NphSettings settings;
            nph_settings_default(&settings);
            settings.isa_limit = (NphIsa)level;
            settings.threads = 1 + level;
            NphContext *context = NULL;
            ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
            NphGrid grid = noisy_grid(context, (NphLookup)lookup);
            draw_positions(&grid, at, at64);
            ck_assert_int_eq(nph_grid_sample(context, &grid, 32, POSITIONS, (const void *[]){at[0], at[1], at[2]}, out),
                             NPH_OK);
            ck_assert_int_eq(
                nph_grid_sample(context, &grid, 64, POSITIONS, (const void *[]){at64[0], at64[1], at64[2]}, out64),
                NPH_OK);
            if (level == NPH_ISA_BASE) {
                memcpy(expected, out, sizeof out);
                memcpy(expected64, out64, sizeof out64);
            }
            ck_assert_int_eq(memcmp(out, expected, sizeof out), 0);
            ck_assert_int_eq(memcmp(out64, expected64, sizeof out64), 0);
            nph_grid_free(context, &grid);
            nph_test_context_close(context);
        }
}
END_TEST

/* Each of the three levels of a + w (b - a) rounds the difference, the product and the sum, none above the largest
 * corner M, and passes on earlier errors with weights that add up to 1: 9 roundings of at most 2^-24 M. */
START_TEST(f32_is_within_nine_roundings_of_f64_which_is_the_sum_of_hats) {
    static float at[3][POSITIONS], out[POSITIONS];
    static double at64[3][POSITIONS], out64[POSITIONS];
    NphContext *context = nph_test_context(1);
    NphGrid grid = noisy_grid(context, NPH_LOOKUP_TRILINEAR);
    draw_positions(&grid, at, at64);
    ck_assert_int_eq(nph_grid_sample(context, &grid, 32, POSITIONS, (const void *[]){at[0], at[1], at[2]}, out),
                     NPH_OK);
    ck_assert_int_eq(nph_grid_sample(context, &grid, 64, POSITIONS, (const void *[]){at64[0], at64[1], at64[2]}, out64),
                     NPH_OK);
    int inside = 0;
    for (int i = 0; i < POSITIONS; i++) {
        double most = 0;
        int in = 1;
        for (int a = 0; a < 3; a++) in &= at64[a][i] >= grid.lo[a] && at64[a][i] <= grid.hi[a];
        inside += in;
        if (!in) {
            ck_assert(out[i] == 0 && out64[i] == 0);
            continue;
        }
        for (int corner = 0; corner < 8; corner++)
            most = fmax(most, (double)field_sample(&grid, (int)at[0][i] + (corner & 1),
                                                   (int)at[1][i] + (corner >> 1 & 1), (int)at[2][i] + (corner >> 2)));
        if (fabs((double)out[i] - out64[i]) > 9.001 * 0x1p-24 * most)
            ck_abort_msg("f32 %g, f64 %g", (double)out[i], out64[i]);
        double oracle = field_oracle(&grid, at64[0][i], at64[1][i], at64[2][i]);
        if (fabs(oracle - out64[i]) > 30 * 0x1p-53 * most) ck_abort_msg("f64 %g, oracle %g", out64[i], oracle);
    }
    ck_assert_int_gt(inside, 3000);
    nph_grid_free(context, &grid);
    nph_test_context_close(context);
}
END_TEST

START_TEST(samples_come_back_exactly_and_nearest_takes_the_closest) {
    NphContext *context = nph_test_context(1);
    NphGrid smooth = noisy_grid(context, NPH_LOOKUP_TRILINEAR), nearest = noisy_grid(context, NPH_LOOKUP_NEAREST);
    uint64_t state = 5;
    for (int trial = 0; trial < 3000; trial++) {
        int s[3];
        float u[3];
        for (int a = 0; a < 3; a++) {
            s[a] = 1 + random_below(&state, smooth.n[a] - 2);
            u[a] = (float)s[a] + (float)(random_unit(&state) * 0.998 - 0.499);
        }
        float expected = field_sample(&smooth, s[0], s[1], s[2]);
        ck_assert_float_eq(field_at32(context, &smooth, (float)s[0], (float)s[1], (float)s[2]), expected);
        ck_assert_double_eq(field_at64(context, &smooth, s[0], s[1], s[2]), (double)expected);
        ck_assert_float_eq(field_at32(context, &nearest, u[0], u[1], u[2]), expected);
        ck_assert_double_eq(field_at64(context, &nearest, (double)u[0], (double)u[1], (double)u[2]), (double)expected);
    }
    nph_grid_free(context, &smooth);
    nph_grid_free(context, &nearest);
    nph_test_context_close(context);
}
END_TEST

/* A grid of 5.8 million bricks in 16 GiB of address space, of which three bricks are touched. */
START_TEST(bricks_beyond_two_to_the_31_elements_are_found) {
    size_t bytes = (size_t)NPH_GRID_BRICKS_MAX * NPH_BRICK_STRIDE * sizeof(float);
    float *values = mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (values == MAP_FAILED) {
        nph_test_skip("lookup beyond 2^31 elements: 16 GiB of address space are not to be had");
        return;
    }
    NphContext *context = nph_test_context(1);
    int32_t index[3] = {2917777, 2917778, NPH_GRID_BRICKS_MAX - 1}; /* below, above 2^31 elements; the last */
    NphGrid grid = {.n = {24, 8, 8},
                    .bricks = {3, 1, 1},
                    .brick_index = index,
                    .brick_count = NPH_GRID_BRICKS_MAX,
                    .values = values,
                    .hi = {23, 7, 7},
                    .lookup = NPH_LOOKUP_TRILINEAR};
    for (int b = 0; b < 3; b++)
        for (int i = 0; i < 729; i++)
            values[(int64_t)index[b] * NPH_BRICK_STRIDE + i] =
                (float)(b * 8 + i % 9 + 100 * (i / 9 % 9) + 10000 * (i / 81));
    uint64_t state = 9;
    for (int trial = 0; trial < 1000; trial++) {
        double u = 23 * random_unit(&state), v = 7 * random_unit(&state), w = 7 * random_unit(&state);
        ck_assert_double_eq_tol(field_at64(context, &grid, u, v, w), u + 100 * v + 10000 * w, 1e-10);
        ck_assert_float_eq_tol(field_at32(context, &grid, (float)u, (float)v, (float)w),
                               (float)(u + 100 * v + 10000 * w), 0.04f);
    }
    nph_test_context_close(context);
    munmap(values, bytes);
}
END_TEST

START_TEST(another_precision_is_refused) {
    NphContext *context = nph_test_context(1);
    NphGrid grid = noisy_grid(context, NPH_LOOKUP_TRILINEAR);
    double at = 1, out = 7;
    ck_assert_int_eq(nph_grid_sample(context, &grid, 16, 1, (const void *[]){&at, &at, &at}, &out), NPH_BAD_USAGE);
    ck_assert_double_eq(out, 7);
    nph_grid_free(context, &grid);
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, vector_levels_and_threads_give_the_same_bits);
    tcase_add_test(cases, f32_is_within_nine_roundings_of_f64_which_is_the_sum_of_hats);
    tcase_add_test(cases, samples_come_back_exactly_and_nearest_takes_the_closest);
    tcase_add_test(cases, bricks_beyond_two_to_the_31_elements_are_found);
    tcase_add_test(cases, another_precision_is_refused);
}

int main(void) { return nph_test_main("sample", fill); }
