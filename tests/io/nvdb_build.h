/* SPDX-License-Identifier: Apache-2.0
 *
 * Builds the smallest NanoVDB grid with a node of every level, for types and damages that no sample file has: one leaf
 * at the origin whose voxel n holds the value given, all active. Offsets as in PNanoVDB.h 32.4.2, written down again
 * here so that the reader is not tested against its own table. */
#ifndef NPH_TESTS_NVDB_BUILD_H
#define NPH_TESTS_NVDB_BUILD_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "harness.h"

enum {
    BUILD_FLOAT = 1, BUILD_HALF = 9, BUILD_FPN = 16,
    SEGMENT_AT = 0, META_AT = 16, NAME_AT = 192, GRID_AT = 200, /* of a file with one grid named "density" */
    CHECKSUM_AT = 8, VERSION_AT = 16, FLAGS_AT = 20, SIZE_AT = 32, MAP_AT = 296 + 88, TYPE_AT = 636,
    TREE_AT = 672, COUNTS_AT = TREE_AT + 32, VOXELS_AT = TREE_AT + 56,
    ROOT_AT = TREE_AT + 64, TABLE_SIZE_AT = ROOT_AT + 24, ROOT_TILE_AT = ROOT_AT + 64, ROOT_TILE_BYTES = 32,
    UPPER_BYTES = 270400, UPPER_TABLE = 8256, UPPER_CHILDREN = 4128, LOWER_BYTES = 33856, LOWER_TABLE = 1088,
    LOWER_VALUES = 32, LOWER_CHILDREN = 544, LEAF_MASK = 16, LEAF_TABLE = 96
};

typedef struct Built {
    unsigned char *file;
    size_t size;
    unsigned char *grid;              /* in file */
    size_t grid_size;
    size_t upper, lower, leaf;        /* offsets in the grid */
} Built;

static inline void put_u16(unsigned char *at, uint32_t value) {
    at[0] = value & 255u;
    at[1] = value >> 8 & 255u;
}
static inline void put_u32(unsigned char *at, uint32_t value) {
    put_u16(at, value);
    put_u16(at + 2, value >> 16);
}
static inline void put_u64(unsigned char *at, uint64_t value) {
    put_u32(at, (uint32_t)value);
    put_u32(at + 4, (uint32_t)(value >> 32));
}
static inline void put_f32(unsigned char *at, float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_u32(at, bits);
}
static inline void put_f64(unsigned char *at, double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_u64(at, bits);
}

/* Makes the head's checksum (grid, tree and root; grid and tree alone after 32.6.0) and the tail's where asked. */
static inline void seal(Built *built, size_t root_tiles, int later) {
    size_t end = later ? ROOT_AT : ROOT_TILE_AT + root_tiles * ROOT_TILE_BYTES;
    put_u32(built->grid + CHECKSUM_AT, (uint32_t)crc32(0, built->grid + 16, (uInt)(end - 16)));
    put_u32(built->grid + CHECKSUM_AT + 4, UINT32_MAX);
    if (!later) return;
    uLong crc = crc32(0, NULL, 0);
    size_t blocks = (built->grid_size - ROOT_AT) / 4096;
    for (size_t i = 0; i < blocks; i++) {
        size_t at = ROOT_AT + 4096 * i, bytes = i + 1 == blocks ? built->grid_size - at : 4096;
        unsigned char word[4];
        put_u32(word, (uint32_t)crc32(0, built->grid + at, (uInt)bytes));
        crc = crc32(crc, word, 4);
    }
    put_u32(built->grid + CHECKSUM_AT + 4, (uint32_t)crc);
}

/* root_tiles entries, the first with the leaf below it, the rest active tiles at (4096 n, 0, 0) of value n. */
static inline Built build(uint32_t type, size_t leaf_bytes, size_t root_tiles) {
    static const uint32_t version = 32u << 21 | 4u << 10 | 2u;
    Built built = {0};
    built.upper = ROOT_TILE_AT + root_tiles * ROOT_TILE_BYTES;
    built.lower = built.upper + UPPER_BYTES;
    built.leaf = built.lower + LOWER_BYTES;
    built.grid_size = built.leaf + leaf_bytes;
    built.size = GRID_AT + built.grid_size;
    built.file = calloc(built.size, 1);
    ck_assert_ptr_nonnull(built.file);
    unsigned char *file = built.file, *grid = built.grid = file + GRID_AT;
    memcpy(file, "NanoVDB0", 8);
    put_u32(file + 8, version);
    put_u16(file + 12, 1);
    put_u64(file + META_AT, built.grid_size);
    put_u64(file + META_AT + 8, built.grid_size);
    put_u32(file + META_AT + 32, type);
    put_u32(file + META_AT + 136, 8);
    memcpy(file + NAME_AT, "density", 8);
    memcpy(grid, "NanoVDB0", 8);
    put_u32(grid + VERSION_AT, version);
    put_u64(grid + SIZE_AT, built.grid_size);
    for (int i = 0; i < 3; i++) put_f64(grid + MAP_AT + 32 * i, 0.5);
    put_u32(grid + TYPE_AT, type);
    static const uint64_t order[3] = {2, 1, 0}; /* offsets of leaves, lower and upper nodes, then the root */
    const size_t nodes[3] = {built.upper, built.lower, built.leaf};
    for (int i = 0; i < 3; i++) {
        put_u64(grid + TREE_AT + 8 * order[i], nodes[i] - TREE_AT);
        put_u32(grid + COUNTS_AT + 4 * i, 1);
    }
    put_u64(grid + TREE_AT + 24, 64);
    put_u64(grid + VOXELS_AT, 512 + ((uint64_t)(root_tiles - 1) << 36));
    put_u32(grid + TABLE_SIZE_AT, (uint32_t)root_tiles);
    for (size_t n = 0; n < root_tiles; n++) {
        unsigned char *tile = grid + ROOT_TILE_AT + ROOT_TILE_BYTES * n;
        put_u64(tile, (uint64_t)n << 42);
        put_u64(tile + 8, n ? 0 : built.upper - ROOT_AT);
        put_u32(tile + 16, n != 0);
        if (type != BUILD_HALF) put_f32(tile + 20, (float)n);
    }
    grid[built.upper + UPPER_CHILDREN] = 1;
    put_u64(grid + built.upper + UPPER_TABLE, UPPER_BYTES);
    grid[built.lower + LOWER_CHILDREN] = 1;
    put_u64(grid + built.lower + LOWER_TABLE, LOWER_BYTES);
    memset(grid + built.leaf + LEAF_MASK, 255, 64);
    return built;
}

/* Writes bytes to a file in the temporary folder and returns its path. */
static inline const char *store(const char *name, const unsigned char *bytes, size_t size) {
    const char *path = nph_test_temporary(name);
    FILE *file = fopen(path, "wb");
    ck_assert_ptr_nonnull(file);
    ck_assert_uint_eq(fwrite(bytes, 1, size, file), size);
    ck_assert_int_eq(fclose(file), 0);
    return path;
}

/* The bytes of a file, malloc'ed. */
static inline unsigned char *load(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    ck_assert_ptr_nonnull(file);
    ck_assert_int_eq(fseek(file, 0, SEEK_END), 0);
    *size = (size_t)ftell(file);
    rewind(file);
    unsigned char *bytes = malloc(*size + 1);
    ck_assert_uint_eq(fread(bytes, 1, *size, file), *size);
    fclose(file);
    return bytes;
}

#endif
