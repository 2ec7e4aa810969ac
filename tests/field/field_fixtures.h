/* SPDX-License-Identifier: Apache-2.0
 *
 * What the tests of field/ share: random numbers, arrays from formulas, single lookups, and an oracle of the lookup that
 * sums hat functions over all samples in double precision. */
#ifndef NPH_TESTS_FIELD_FIXTURES_H
#define NPH_TESTS_FIELD_FIXTURES_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "field/grid.h"
#include "field/sample.h"
#include "harness.h"
#include "nephos/array.h"

/* splitmix64 */
static inline uint64_t random_bits(uint64_t *state) {
    uint64_t z = (*state += 0x9e3779b97f4a7c15u);
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}
static inline double random_unit(uint64_t *state) { return (double)(random_bits(state) >> 11) * 0x1p-53; }
static inline int random_below(uint64_t *state, int n) { return (int)(random_bits(state) % (uint64_t)n); }

typedef double (*FieldFn)(int x, int y, int z, void *user);

/* f64 array [z][y][x] of a function of the voxel's indices. */
static inline NphArray field_array(NphContext *context, const int size[3], FieldFn function, void *user) {
    NphArray array = {0};
    ck_assert_int_eq(nph_array_new(context, NPH_F64, 3, (int64_t[]){size[2], size[1], size[0]}, "field", &array),
                     NPH_OK);
    double *value = array.data;
    for (int z = 0; z < size[2]; z++)
        for (int y = 0; y < size[1]; y++)
            for (int x = 0; x < size[0]; x++) *value++ = function(x, y, z, user);
    return array;
}

/* The stored sample, padding included, straight from the bricks. */
static inline float field_sample(const NphGrid *grid, int i, int j, int k) {
    int64_t entry = ((int64_t)(k / 8) * grid->bricks[1] + j / 8) * grid->bricks[0] + i / 8;
    int64_t within = (k % 8) * 81 + (j % 8) * 9 + i % 8;
    return grid->values[(int64_t)grid->brick_index[entry] * NPH_BRICK_STRIDE + within];
}

static inline double field_at64(NphContext *context, const NphGrid *grid, double u, double v, double w) {
    double out = -1;
    ck_assert_int_eq(nph_grid_sample(context, grid, 64, 1, (const void *[]){&u, &v, &w}, &out), NPH_OK);
    return out;
}

static inline float field_at32(NphContext *context, const NphGrid *grid, float u, float v, float w) {
    float out = -1;
    ck_assert_int_eq(nph_grid_sample(context, grid, 32, 1, (const void *[]){&u, &v, &w}, &out), NPH_OK);
    return out;
}

/* Trilinear interpolation as it is defined: the sum over samples of value times the product of three hats. */
static inline double field_oracle(const NphGrid *grid, double u, double v, double w) {
    double at[3] = {u, v, w}, sum = 0;
    int first[3], last[3];
    for (int a = 0; a < 3; a++) {
        first[a] = (int)floor(at[a]) - 1 < 0 ? 0 : (int)floor(at[a]) - 1;
        last[a] = first[a] + 3 > grid->n[a] - 1 ? grid->n[a] - 1 : first[a] + 3;
    }
    for (int k = first[2]; k <= last[2]; k++)
        for (int j = first[1]; j <= last[1]; j++)
            for (int i = first[0]; i <= last[0]; i++)
                sum += fmax(0, 1 - fabs(u - i)) * fmax(0, 1 - fabs(v - j)) * fmax(0, 1 - fabs(w - k)) *
                       (double)field_sample(grid, i, j, k);
    return sum;
}

/* Lattice position of a world position for a map without rotation. */
static inline double field_lattice(const NphGrid *grid, int axis, double world) {
    return (world - grid->world_from_lattice[4 * axis + 3]) / grid->world_from_lattice[5 * axis];
}

/* The content of two grids is the same to the bit. */
static inline int field_same(const NphGrid *a, const NphGrid *b) {
    size_t bricks = (size_t)a->bricks[0] * (size_t)a->bricks[1] * (size_t)a->bricks[2];
    size_t cells = (size_t)a->majorant.n[0] * (size_t)a->majorant.n[1] * (size_t)a->majorant.n[2];
    return memcmp(a->n, b->n, sizeof a->n) == 0 && a->brick_count == b->brick_count && a->sum == b->sum &&
           a->min == b->min && a->max == b->max && a->active == b->active &&
           memcmp(a->brick_index, b->brick_index, bricks * sizeof *a->brick_index) == 0 &&
           memcmp(a->values, b->values, (size_t)a->brick_count * NPH_BRICK_STRIDE * sizeof *a->values) == 0 &&
           memcmp(a->majorant.cells, b->majorant.cells, cells * sizeof *a->majorant.cells) == 0;
}

/* Calls build(context, data, &grid) with every allocation failing once: no leak, *grid untouched, NPH_NO_MEMORY. */
typedef NphStatus (*FieldBuildFn)(NphContext *context, void *data, NphGrid *grid);
static inline void field_fail_every_allocation(FieldBuildFn build, void *data) {
    for (uint64_t nth = 1;; nth++) {
        ck_assert_uint_lt(nth, 100);
        NphSettings settings;
        nph_settings_default(&settings);
        settings.threads = 1;
        settings.fail_allocation = nth;
        NphContext *context = NULL;
        ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
        NphGrid grid, untouched;
        memset(&grid, 0x5a, sizeof grid);
        untouched = grid;
        NphStatus status = build(context, data, &grid);
        if (status == NPH_OK) {
            ck_assert_uint_gt(nth, 3);
            nph_grid_free(context, &grid);
            nph_test_context_close(context);
            return;
        }
        ck_assert_int_eq(status, NPH_NO_MEMORY);
        ck_assert_int_eq(memcmp(&grid, &untouched, sizeof grid), 0);
        nph_test_context_close(context);
    }
}

#endif
