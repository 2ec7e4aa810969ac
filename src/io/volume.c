/* SPDX-License-Identifier: Apache-2.0
 *
 * Sparse volumes: release, lookup by binary search, and statistics over the active voxels. */
#include "io/volume.h"

#include <math.h>
#include <string.h>

#include "core/memory.h"

void nph_volume_free(NphContext *context, NphVolume *volume) {
    nph_free(context, volume->leaves);
    nph_free(context, volume->tiles);
    memset(volume, 0, sizeof *volume);
}

/* Position of the first element whose origin is not below `origin`; elements start with their origin. */
static const void *find(const void *elements, int64_t count, size_t size, const int32_t origin[3]) {
    const char *base = elements;
    int64_t lo = 0, hi = count;
    while (lo < hi) {
        int64_t middle = lo + (hi - lo) / 2;
        const int32_t *at = (const int32_t *)(const void *)(base + (size_t)middle * size);
        int axis = 0;
        while (axis < 2 && at[axis] == origin[axis]) axis++;
        if (at[axis] < origin[axis]) lo = middle + 1;
        else hi = middle;
    }
    const int32_t *at = lo < count ? (const int32_t *)(const void *)(base + (size_t)lo * size) : NULL;
    return at && memcmp(at, origin, 3 * sizeof *at) == 0 ? at : NULL;
}

float nph_volume_value(const NphVolume *volume, const int32_t ijk[3], int *active) {
    static const int32_t sizes[] = {NPH_LEAF_SIZE, 128, 4096};
    for (int level = 0; level < 3; level++) {
        int32_t mask = sizes[level] - 1, origin[3] = {ijk[0] & ~mask, ijk[1] & ~mask, ijk[2] & ~mask};
        const NphLeaf *leaf = level == 0 ? find(volume->leaves, volume->leaf_count, sizeof *leaf, origin) : NULL;
        if (leaf) {
            int index = (ijk[0] & 7) << 6 | (ijk[1] & 7) << 3 | (ijk[2] & 7);
            *active = (int)(leaf->active[index >> 6] >> (index & 63) & 1);
            return leaf->values[index];
        }
        const NphTile *tile = find(volume->tiles, volume->tile_count, sizeof *tile, origin);
        if (tile && tile->size == sizes[level]) {
            *active = tile->active;
            return tile->value;
        }
    }
    *active = 0;
    return volume->background;
}

/* Neumaier's compensated sum. */
typedef struct Sum {
    double total, lost;
} Sum;

static void add(Sum *sum, double term) {
    double total = sum->total + term;
    sum->lost += fabs(sum->total) >= fabs(term) ? (sum->total - total) + term : (term - total) + sum->total;
    sum->total = total;
}

static void count_value(NphVolumeStatistics *statistics, Sum *sum, float value, double voxels) {
    if (value - value != 0.0f) {
        statistics->not_finite += (uint64_t)voxels;
        return;
    }
    if (value < statistics->min) statistics->min = value;
    if (value > statistics->max) statistics->max = value;
    add(sum, (double)value * voxels); /* exact: voxels is a power of two */
}

void nph_volume_statistics(const NphVolume *volume, NphVolumeStatistics *statistics) {
    NphVolumeStatistics made = {.min = INFINITY, .max = -INFINITY};
    Sum sum = {0, 0};
    for (int64_t i = 0; i < volume->leaf_count; i++)
        for (int n = 0; n < NPH_LEAF_VOXELS; n++)
            if (volume->leaves[i].active[n >> 6] >> (n & 63) & 1)
                count_value(&made, &sum, volume->leaves[i].values[n], 1.0);
    for (int64_t i = 0; i < volume->tile_count; i++) {
        const NphTile *tile = &volume->tiles[i];
        double voxels = (double)tile->size * (double)tile->size * (double)tile->size;
        if (tile->active) count_value(&made, &sum, tile->value, voxels);
    }
    uint64_t finite = volume->active_voxels - made.not_finite;
    if (finite == 0) made.min = made.max = 0.0f;
    made.sum = sum.total + sum.lost;
    made.mean = finite ? made.sum / (double)finite : 0.0;
    *statistics = made;
}
