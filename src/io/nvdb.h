/* SPDX-License-Identifier: Apache-2.0
 *
 * What the parts of the NanoVDB reader share: nvdb.c (container: segments, names, choice of a grid), nvdb_codec.c
 * (unpacking), nvdb_tree.c (grid buffer to leaves and tiles). Facts about the format: NanoVDB 32.4.2, util/IO.h,
 * NanoVDB.h and PNanoVDB.h; later 32.x versions keep the layout, but change the magic words and what is checksummed. */
#ifndef NPH_IO_NVDB_H
#define NPH_IO_NVDB_H

#include <stddef.h>
#include <stdint.h>

#include "io/volume.h"

enum { NPH_NVDB_NONE = 0, NPH_NVDB_ZIP = 1, NPH_NVDB_BLOSC = 2, NPH_NVDB_CODECS = 3 };
enum { NPH_NVDB_MAJOR = 32 };

/* "NanoVDB0" heads files and grids up to 32.5, "NanoVDB1" grids and "NanoVDB2" files after that (little endian). */
#define NPH_NVDB_MAGIC 0x304244566f6e614eu
#define NPH_NVDB_MAGIC_GRID 0x314244566f6e614eu
#define NPH_NVDB_MAGIC_FILE 0x324244566f6e614eu

/* One grid as the container describes it; all ranges lie inside the file. */
typedef struct NphNvdbEntry {
    const char *name;   /* in the file's bytes, not terminated */
    size_t name_bytes;
    char shown[64];     /* printable, cut */
    uint64_t meta_at;   /* where its description starts */
    uint64_t data_at, file_bytes, grid_bytes;
    uint32_t type, grid_class, codec;
    uint64_t active_voxels;
    int32_t bbox_min[3], bbox_max[3];
    double voxel_size[3];
} NphNvdbEntry;

/* A grid buffer to decode, in the file's bytes or unpacked. */
typedef struct NphNvdbBuffer {
    const char *path, *name;
    const unsigned char *bytes;
    uint64_t size;
    uint64_t file_offset; /* of bytes[0] in the file; 0 when unpacked */
    int unpacked;
} NphNvdbBuffer;

/* Little-endian loads; the caller has checked the range. */
static inline uint32_t nph_load_u32(const unsigned char *at) {
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}
static inline uint64_t nph_load_u64(const unsigned char *at) {
    return (uint64_t)nph_load_u32(at) | (uint64_t)nph_load_u32(at + 4) << 32;
}

/* nvdb_codec.c: "none", "zip", "blosc"; NULL beyond. */
const char *nph_nvdb_codec_name(uint32_t codec);
/* Unpacks a zip or blosc grid into *grid (entry->grid_bytes bytes, freed with nph_free). */
NphStatus nph_nvdb_unpack(NphContext *context, const char *path, const unsigned char *file, const NphNvdbEntry *entry,
                          unsigned char **grid);

/* The two CRC-32 of a grid, head in the low half of `words`: up to version 32.6.0 the head covers grid, tree and root
 * (to head_end), and the nodes' checksum differs between systems and is not checked (tail_start 0); later the head
 * covers grid and tree, the tail is the CRC of the CRCs of the rest (from tail_start) in blocks of 4 KiB. All bits set:
 * not made. Returns what does not match ("the grid's header", "the nodes"), or NULL. */
const char *nph_nvdb_checksum(const NphNvdbBuffer *buffer, uint64_t words, uint64_t head_end, uint64_t tail_start);

/* nvdb.c: names as in volume.h; "type N" and "unknown class" for numbers without one. */
void nph_nvdb_type_name(uint32_t type, char name[16]);
void nph_nvdb_class_name(uint32_t grid_class, char name[16]);

/* nvdb_tree.c: is it a scalar type that is decoded? */
int nph_nvdb_type_readable(uint32_t type);
/* Decodes a readable grid; the buffer's type must be the one the container announced. */
NphStatus nph_nvdb_decode(NphContext *context, const NphNvdbBuffer *buffer, uint32_t type, NphVolume *volume);

#endif
