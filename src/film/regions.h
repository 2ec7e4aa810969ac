/* SPDX-License-Identifier: Apache-2.0
 *
 * The regions that verdicts rest on: the whole picture, 64 x 64 and 8 x 8 tiles, counted from the upper left pixel of the
 * crop. A remainder of less than half a tile belongs to the last tile, so that no tile is a sliver. A 64 x 64 tile is whole
 * 8 x 8 tiles: 64 k begins one, since k (64) <= length - 32 leaves the 8 x 8 tile at 64 k more than half of itself. */
#ifndef NPH_FILM_REGIONS_H
#define NPH_FILM_REGIONS_H

enum { NPH_REGION_LEVELS = 3 };

/* Side in pixels; 0: the whole picture. */
static const int nph_region_sizes[NPH_REGION_LEVELS] = {8, 64, 0};

/* Layers of a picture whose pixels share samples (docs/files.md): variance of a region's mean, and its Vov. */
static const char *const nph_region_variance[NPH_REGION_LEVELS][3] = {
    {"Variance8.R", "Variance8.G", "Variance8.B"},
    {"Variance64.R", "Variance64.G", "Variance64.B"},
    {"VarianceImage.R", "VarianceImage.G", "VarianceImage.B"}};
static const char *const nph_region_vov[NPH_REGION_LEVELS][3] = {
    {"Vov8.R", "Vov8.G", "Vov8.B"}, {"Vov64.R", "Vov64.G", "Vov64.B"}, {"VovImage.R", "VovImage.G", "VovImage.B"}};

/* Tiles along one side. */
static inline int nph_regions_along(int length, int size) {
    if (size == 0 || length < size) return 1;
    return (length + size / 2) / size;
}

/* Pixels [begin, end) of a tile along one side. */
static inline void nph_region_span(int tile, int tiles, int size, int length, int *begin, int *end) {
    *begin = tile * size;
    *end = tile == tiles - 1 ? length : (tile + 1) * size;
}

/* The tile that holds a pixel. */
static inline int nph_region_of(int at, int tiles, int size) {
    if (size == 0) return 0;
    int tile = at / size;
    return tile < tiles ? tile : tiles - 1;
}

#endif
