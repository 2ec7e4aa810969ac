/* SPDX-License-Identifier: Apache-2.0
 *
 * The 512 values of a NanoVDB leaf, float, half or quantised, and the facts its activity mask gives. The layout's
 * offsets come from the caller, which has checked that the leaf lies inside its buffer. */
#ifndef NPH_IO_NVDB_LEAF_H
#define NPH_IO_NVDB_LEAF_H

#include "io/nvdb.h"

/* A quantised leaf: value = minimum + code * quantum, codes of 1 << log_bits bits, low bits first. */
typedef struct NphQuantised {
    float minimum, quantum;
    uint32_t log_bits; /* 0 to 4 */
} NphQuantised;

float nph_load_f32(const unsigned char *at);
float nph_load_f16(const unsigned char *at);

void nph_leaf_floats(const unsigned char *table, float values[NPH_LEAF_VOXELS]);
void nph_leaf_halves(const unsigned char *table, float values[NPH_LEAF_VOXELS]);
void nph_leaf_codes(const unsigned char *table, const NphQuantised *code, float values[NPH_LEAF_VOXELS]);

/* Sums and counts the active values; returns the index of the first that is not in [lo, hi], or -1. */
int nph_leaf_examine(const NphLeaf *leaf, float lo, float hi, double *sum, int *count);

/* Counts the active voxels of leaves and tiles and finds their box. */
void nph_volume_measure(NphVolume *volume);

#endif
