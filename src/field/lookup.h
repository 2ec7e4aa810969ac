/* SPDX-License-Identifier: Apache-2.0
 *
 * The lookup of a grid inside kernels: `static inline`, in the kernel's precision, without a branch, so that a loop over
 * lanes becomes vectors (gcc needs the loop's pointers to be `restrict` parameters, and a result that is used in some
 * lanes only to be multiplied by 0 or 1, not selected). The same operations in the same order everywhere:
 *     i = floor(u), f = u - i (exact)                       likewise j, g from v and k, h from w
 *     a + f (b - a) along x for the four edges, then with g along y, then with h along z
 * nearest: i = floor(u + 1/2), f = 0, which gives the sample itself. Results never leave the range of the eight corners
 * (majorant.c has the proof), and at samples are the samples. */
#ifndef NPH_FIELD_LOOKUP_H
#define NPH_FIELD_LOOKUP_H

#include <stdint.h>

#include "core/real.h"

/* A grid as kernels see it; made by nph_grid_view (field/sample.h). Offsets take 32 bits: where values has 2^31
 * elements or more (up to 2^32, 16 GiB; builders refuse more), `values` points at element 2^31 and bias is 2^31, so that
 * the offset less the bias is a signed 32-bit number. Measured against 64-bit offsets: 1.2 to 1.7 times as fast in f32,
 * and no branch. */
typedef struct RGrid {
    const int32_t *brick_index;
    const float *values;
    int32_t n[3], bricks[3];
    uint32_t bias;
    float shift;  /* trilinear 0, nearest 0.5: added before the floor */
    float weight; /* trilinear 1, nearest 0: times the fractions */
} RGrid;

/* Element of sample (i, j, k), counted from grid->values. */
static inline int32_t r_grid_element(const RGrid *grid, int32_t i, int32_t j, int32_t k) {
    int32_t brick = grid->brick_index[((k >> 3) * grid->bricks[1] + (j >> 3)) * grid->bricks[0] + (i >> 3)];
    int32_t within = (k & 7) * 81 + (j & 7) * 9 + (i & 7);
    return (int32_t)((uint32_t)brick * 736u + (uint32_t)within - grid->bias); /* NPH_BRICK_STRIDE */
}

static inline Real r_grid_mix(Real a, Real b, Real w) { return a + w * (b - a); }

/* The density at a position of the lattice, which the caller has clamped: u in [0, n[0] - 1], v, w likewise. */
static inline Real r_grid_value(const RGrid *grid, Real u, Real v, Real w) {
    Real shift = (Real)grid->shift, weight = (Real)grid->weight;
    int32_t i = (int32_t)(u + shift), j = (int32_t)(v + shift), k = (int32_t)(w + shift);
    Real f = (u - (Real)i) * weight, g = (v - (Real)j) * weight, h = (w - (Real)k) * weight;
    if (NPH_BUG(29)) {
        Real kept = f;
        f = g;
        g = kept;
    }
    int32_t at = r_grid_element(grid, i, j, k);
    const float *values = grid->values;
    Real c00 = r_grid_mix((Real)values[at], (Real)values[at + 1], f);
    Real c10 = r_grid_mix((Real)values[at + 9], (Real)values[at + 10], f);
    Real c01 = r_grid_mix((Real)values[at + 81], (Real)values[at + 82], f);
    Real c11 = r_grid_mix((Real)values[at + 90], (Real)values[at + 91], f);
    return r_grid_mix(r_grid_mix(c00, c10, g), r_grid_mix(c01, c11, g), h);
}

#endif
