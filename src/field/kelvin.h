/* SPDX-License-Identifier: Apache-2.0
 *
 * Values of a file to temperatures in kelvin, scale * value + offset, before they become a grid. What is not between 0
 * and `most` is refused (NPH_BAD_INPUT) with its voxel. */
#ifndef NPH_FIELD_KELVIN_H
#define NPH_FIELD_KELVIN_H

#include "field/grid.h"

typedef struct NphKelvin {
    double scale, offset, most;
} NphKelvin;

/* Active voxels and tiles; inactive ones, and the background, become 0: there is nothing there that glows. */
NphStatus nph_kelvin_volume(NphContext *context, const NphKelvin *kelvin, const char *what, NphVolume *volume);

/* All elements of an array of rank 3 into a new one of f32. */
NphStatus nph_kelvin_array(NphContext *context, const NphKelvin *kelvin, const NphArray *array, const char *what,
                           NphArray *out);

#endif
