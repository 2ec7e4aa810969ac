/* SPDX-License-Identifier: Apache-2.0
 *
 * See kelvin.h. */
#include "field/kelvin.h"

#include "core/message.h"
#include "field/grid_build.h"

static double to_kelvin(const NphKelvin *kelvin, double value) { return kelvin->scale * value + kelvin->offset; }

static int is_temperature(const NphKelvin *kelvin, double value) { return value >= 0.0 && value <= kelvin->most; }

static NphStatus refuse(NphContext *context, const NphKelvin *kelvin, const char *what, const char *order,
                        const int64_t at[3], double value) {
    return nph_error(context, NPH_BAD_INPUT,
                     "%s: voxel %s = [%lld, %lld, %lld] is %g, which scale and offset make %g K; allowed: 0 to %g K", what,
                     order, (long long)at[0], (long long)at[1], (long long)at[2], value, to_kelvin(kelvin, value),
                     kelvin->most);
}

static NphStatus convert_leaf(NphContext *context, const NphKelvin *kelvin, const char *what, NphLeaf *leaf) {
    for (int i = 0; i < NPH_LEAF_VOXELS; i++) {
        double value = (double)leaf->values[i], hot = to_kelvin(kelvin, value);
        int active = leaf->active[i >> 6] >> (i & 63) & 1u;
        int64_t at[3] = {(int64_t)leaf->origin[0] + (i >> 6), (int64_t)leaf->origin[1] + (i >> 3 & 7),
                         (int64_t)leaf->origin[2] + (i & 7)};
        if (active && !is_temperature(kelvin, hot)) return refuse(context, kelvin, what, "[x, y, z]", at, value);
        leaf->values[i] = active ? (float)hot : 0.0f;
    }
    return NPH_OK;
}

NphStatus nph_kelvin_volume(NphContext *context, const NphKelvin *kelvin, const char *what, NphVolume *volume) {
    for (int64_t i = 0; i < volume->leaf_count; i++) NPH_TRY(convert_leaf(context, kelvin, what, &volume->leaves[i]));
    for (int64_t i = 0; i < volume->tile_count; i++) {
        NphTile *tile = &volume->tiles[i];
        double value = (double)tile->value, hot = to_kelvin(kelvin, value);
        int64_t at[3] = {tile->origin[0], tile->origin[1], tile->origin[2]};
        if (tile->active && !is_temperature(kelvin, hot)) return refuse(context, kelvin, what, "[x, y, z]", at, value);
        tile->value = tile->active ? (float)hot : 0.0f;
    }
    volume->background = 0.0f;
    return NPH_OK;
}

NphStatus nph_kelvin_array(NphContext *context, const NphKelvin *kelvin, const NphArray *array, const char *what,
                           NphArray *out) {
    NphArray made;
    if (array->rank != 3)
        return nph_error(context, NPH_BAD_INPUT, "%s: has %d axes; temperatures have three, [z][y][x]", what, array->rank);
    NPH_TRY(nph_array_new(context, NPH_F32, 3, array->shape, what, &made));
    int64_t count = nph_array_count(array), nx = array->shape[2], ny = array->shape[1];
    for (int64_t i = 0; i < count; i++) {
        double value = nph_array_element(array, i), hot = to_kelvin(kelvin, value);
        if (!is_temperature(kelvin, hot)) {
            nph_array_free(context, &made);
            return refuse(context, kelvin, what, "[z, y, x]", (int64_t[3]){i / (nx * ny), i / nx % ny, i % nx}, value);
        }
        ((float *)made.data)[i] = (float)hot;
    }
    *out = made;
    return NPH_OK;
}
