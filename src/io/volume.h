/* SPDX-License-Identifier: Apache-2.0
 *
 * A sparse scalar volume as its file holds it: 8^3 leaves and constant tiles on an integer lattice, never densified.
 * Made by the readers of .nvdb (and .vdb), turned into bricks by field/. */
#ifndef NPH_IO_VOLUME_H
#define NPH_IO_VOLUME_H

#include <stdint.h>

#include "io/file.h"
#include "nephos/array.h"

enum { NPH_LEAF_SIZE = 8, NPH_LEAF_VOXELS = 512 };

typedef struct NphLeaf {
    int32_t origin[3];            /* multiple of 8 */
    uint64_t active[8];           /* bit (x << 6 | y << 3 | z) as in OpenVDB: word x, bit y * 8 + z */
    float values[NPH_LEAF_VOXELS]; /* index x * 64 + y * 8 + z; inactive voxels hold what the file holds */
} NphLeaf;

typedef struct NphTile {
    int32_t origin[3];
    int32_t size;    /* edge in voxels: 8, 128 or 4096 */
    float value;
    int32_t active;  /* inactive tiles that differ from the background are kept too */
} NphTile;

typedef struct NphVolume {
    char name[64];
    char type[16];                       /* as the file says: "float", "half", "Fp8", "FpN", ... */
    char grid_class[16];                 /* "fog volume", "level set", "unknown", ... */
    float background;
    int32_t bbox_min[3], bbox_max[3];    /* active lattice points, inclusive; min > max when empty */
    uint64_t active_voxels;              /* tiles counted in full */
    double world_from_index[12];         /* row-major 3x4: position of lattice point (i, j, k) */
    int64_t leaf_count, tile_count;
    NphLeaf *leaves;                     /* sorted by origin x, y, z */
    NphTile *tiles;                      /* sorted likewise */
} NphVolume;

void nph_volume_free(NphContext *context, NphVolume *volume);

/* Value and activity at a lattice point, by search; for tests and tools. */
float nph_volume_value(const NphVolume *volume, const int32_t ijk[3], int *active);

/* Over the active voxels, tiles counted in full; an empty volume gives zeros. The sum is compensated and taken in the
 * order leaves, tiles, so it is the same everywhere. */
typedef struct NphVolumeStatistics {
    float min, max;      /* of the finite values */
    double mean, sum;    /* of the finite values */
    uint64_t not_finite; /* NaN and infinite values; left out above */
} NphVolumeStatistics;
void nph_volume_statistics(const NphVolume *volume, NphVolumeStatistics *statistics);

/* NanoVDB. Codecs none, zip, blosc; float, half (Fp16), Fp4, Fp8, FpN grids. grid_name NULL: the only grid, else
 * "density"; a name that is not there is refused with the list of those that are. */
NphStatus nph_nvdb_read(NphContext *context, const char *path, const char *grid_name, NphVolume *volume);

/* OpenVDB (.vdb), versions 222 to 224 of its file format, every compression; float trees of the usual shape, saved as
 * half or not. Grid names, background and tiles as nph_nvdb_read has them. Does not use the library. */
NphStatus nph_vdb_read(NphContext *context, const char *path, const char *grid_name, NphVolume *volume);

/* What a .nvdb (or .vdb) file holds, grid by grid, without decoding voxels; *grids is freed with nph_free. */
typedef struct NphGridInfo {
    char name[64], type[16], grid_class[16], codec[8];
    int readable; /* a scalar type this library decodes */
    int32_t bbox_min[3], bbox_max[3];
    uint64_t active_voxels, file_bytes, grid_bytes;
    double voxel_size[3];
} NphGridInfo;
NphStatus nph_nvdb_list(NphContext *context, const char *path, NphGridInfo **grids, int *count);
/* From what the file says of its grids; grid_bytes: in memory, 0 where it is not said. */
NphStatus nph_vdb_list(NphContext *context, const char *path, NphGridInfo **grids, int *count);

/* .npy (format 1.0 to 3.0, little or big endian, C or Fortran order, which is made C order). PATH@OFFSET: the array that
 * begins at that byte of a file, whatever follows it. */
NphStatus nph_npy_read(NphContext *context, const char *path, NphArray *array);
NphStatus nph_npy_write(NphContext *context, const char *path, const NphArray *array);
/* The same at the end of a file, whose size, a multiple of 64, grows to the next one.
 * stride: bytes from one row of the first axis to the next, 0 where there are no gaps. */
NphStatus nph_npy_append(NphContext *context, NphAppender *file, const NphArray *array, int64_t stride, int64_t *size);

/* LES text (water content and effective radius on lattice points), both layouts of the field: comma separated with a
 * column line, and SHDOM's blank separated one. Knows no physics. */
typedef struct NphLes {
    NphArray lwc_g_per_m3;  /* f32 [nz][ny][nx] */
    NphArray reff_um;       /* f32 [nz][ny][nx]; 0 where absent */
    double spacing_m[2];    /* dx, dy */
    NphArray height_m;      /* f64 [nz]: altitudes of the levels, strictly rising */
} NphLes;
NphStatus nph_les_read(NphContext *context, const char *path, NphLes *les);
void nph_les_free(NphContext *context, NphLes *les);

/* A dense grid and the box it fills: value [z][y][x] is that of the cell's middle, cell (0, 0, 0) touches lo. */
typedef struct NphBoxGrid {
    NphArray values; /* f32 [nz][ny][nx], or [nz][ny][nx][3] of a .vol with three channels */
    double lo[3], hi[3];
} NphBoxGrid;
void nph_box_grid_free(NphContext *context, NphBoxGrid *grid);

/* Mitsuba's grid volume (.vol): version 3, type 1 (float32), one or three channels. The box is the file's own, which
 * Mitsuba itself uses only with use_grid_bbox. Its lookups clamp at the border. Writing: f32 values, a box that stays
 * finite and rising in float32, to whose numbers it is rounded. */
NphStatus nph_vol_read(NphContext *context, const char *path, NphBoxGrid *grid);
NphStatus nph_vol_write(NphContext *context, const char *path, const NphBoxGrid *grid);

/* pbrt text: the density of a MakeNamedMedium of type uniformgrid (pbrt-v4) or heterogeneous (pbrt-v3). name NULL: the
 * only such medium, else "density"; a name that is not there is refused with the list of those that are. The box is
 * p0 to p1 in the medium's own space; transforms in the file are not applied, which a warning says. Lookups of pbrt
 * fall to zero outside. */
NphStatus nph_pbrt_read(NphContext *context, const char *path, const char *name, NphBoxGrid *grid);

typedef struct NphPbrtInfo {
    char name[64], type[32];
    int readable; /* a grid of densities that nph_pbrt_read takes */
} NphPbrtInfo;
/* All named media, in the file's order; *media is freed with nph_free. */
NphStatus nph_pbrt_list(NphContext *context, const char *path, NphPbrtInfo **media, int *count);

/* 8-bit sRGB PNG: rgb is height * width * 3 bytes from the top row. Atomic like every writer. */
NphStatus nph_png_write(NphContext *context, const char *path, int width, int height, const uint8_t *rgb);

#endif
