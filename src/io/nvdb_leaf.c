/* SPDX-License-Identifier: Apache-2.0
 *
 * Values and activity of one 8^3 leaf. Quantised values are computed in float as code * quantum + minimum, two
 * roundings in that order, as NanoVDB's own accessor does. */
#include "io/nvdb_leaf.h"

#include <string.h>

static float float_of_bits(uint32_t bits) {
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

float nph_load_f32(const unsigned char *at) { return float_of_bits(nph_load_u32(at)); }

/* IEEE 754 binary16 to binary32, exact: subnormals are renormalised, infinity and NaN keep their kind. */
float nph_load_f16(const unsigned char *at) {
    uint32_t half = (uint32_t)at[0] | (uint32_t)at[1] << 8;
    uint32_t sign = (half & 0x8000u) << 16, exponent = half >> 10 & 31u, mantissa = half & 1023u;
    if (exponent == 31u) return float_of_bits(sign | 0x7f800000u | mantissa << 13);
    if (exponent > 0u) return float_of_bits(sign | (exponent + 112u) << 23 | mantissa << 13);
    float magnitude = (float)mantissa * (1.0f / 16777216.0f); /* subnormal: mantissa * 2^-24 */
    return sign ? -magnitude : magnitude;
}

void nph_leaf_floats(const unsigned char *table, float values[NPH_LEAF_VOXELS]) {
    for (int i = 0; i < NPH_LEAF_VOXELS; i++) values[i] = nph_load_f32(table + 4 * i);
}

void nph_leaf_halves(const unsigned char *table, float values[NPH_LEAF_VOXELS]) {
    for (int i = 0; i < NPH_LEAF_VOXELS; i++) values[i] = nph_load_f16(table + 2 * i);
}

void nph_leaf_codes(const unsigned char *table, const NphQuantised *code, float values[NPH_LEAF_VOXELS]) {
    uint32_t bits = 1u << code->log_bits, mask = (1u << bits) - 1u;
    for (uint32_t i = 0; i < NPH_LEAF_VOXELS; i++) {
        uint32_t first = i * bits; /* no code crosses a byte except those of 16 bits, which fill two */
        uint32_t raw = table[first >> 3];
        if (bits == 16u) raw |= (uint32_t)table[(first >> 3) + 1] << 8;
        values[i] = (float)(raw >> (first & 7u) & mask) * code->quantum + code->minimum;
    }
}

int nph_leaf_examine(const NphLeaf *leaf, float lo, float hi, double *sum, int *count) {
    double total = 0;
    int active = 0, outside = -1;
    for (int i = NPH_LEAF_VOXELS - 1; i >= 0; i--) {
        if (!(leaf->active[i >> 6] >> (i & 63) & 1)) continue;
        if (leaf->values[i] < lo || leaf->values[i] > hi) outside = i;
        total += (double)leaf->values[i];
        active++;
    }
    *sum = total;
    *count = active;
    return outside;
}

static uint64_t count_bits(uint64_t word) {
    word -= word >> 1 & 0x5555555555555555u;
    word = (word & 0x3333333333333333u) + (word >> 2 & 0x3333333333333333u);
    word = (word + (word >> 4)) & 0x0f0f0f0f0f0f0f0fu;
    return word * 0x0101010101010101u >> 56;
}

static uint64_t leaf_active(const NphLeaf *leaf) {
    uint64_t count = 0;
    for (int x = 0; x < 8; x++) count += count_bits(leaf->active[x]);
    return count;
}

/* present: bit i set when something is active at offset i along the axis. */
static void extend_axis(int32_t origin, uint32_t present, int32_t *lo, int32_t *hi) {
    for (int32_t i = 0; i < 8; i++) {
        if (!(present >> i & 1u)) continue;
        if (origin + i < *lo) *lo = origin + i;
        if (origin + i > *hi) *hi = origin + i;
    }
}

/* Widens [lo, hi] by the leaf's active voxels. */
static void leaf_extend(const NphLeaf *leaf, int32_t lo[3], int32_t hi[3]) {
    uint64_t any = 0;
    uint32_t present[3] = {0, 0, 0};
    for (uint32_t x = 0; x < 8; x++) {
        any |= leaf->active[x];
        if (leaf->active[x]) present[0] |= 1u << x;
    }
    for (uint32_t y = 0; y < 8; y++) {
        uint32_t row = (uint32_t)(any >> (8 * y)) & 255u;
        if (row) present[1] |= 1u << y;
        present[2] |= row;
    }
    for (int axis = 0; axis < 3; axis++) extend_axis(leaf->origin[axis], present[axis], &lo[axis], &hi[axis]);
}

void nph_volume_measure(NphVolume *volume) {
    int32_t lo[3] = {INT32_MAX, INT32_MAX, INT32_MAX}, hi[3] = {INT32_MIN, INT32_MIN, INT32_MIN};
    for (int64_t i = 0; i < volume->leaf_count; i++) {
        volume->active_voxels += leaf_active(&volume->leaves[i]);
        leaf_extend(&volume->leaves[i], lo, hi);
    }
    for (int64_t i = 0; i < volume->tile_count; i++) {
        const NphTile *tile = &volume->tiles[i];
        if (!tile->active) continue;
        volume->active_voxels += (uint64_t)tile->size * (uint64_t)tile->size * (uint64_t)tile->size;
        for (int axis = 0; axis < 3; axis++) {
            int32_t last = tile->origin[axis] + (tile->size - 1);
            if (tile->origin[axis] < lo[axis]) lo[axis] = tile->origin[axis];
            if (last > hi[axis]) hi[axis] = last;
        }
    }
    for (int axis = 0; axis < 3; axis++) {
        volume->bbox_min[axis] = volume->active_voxels ? lo[axis] : 0;
        volume->bbox_max[axis] = volume->active_voxels ? hi[axis] : -1;
    }
}
