/* SPDX-License-Identifier: Apache-2.0
 *
 * What the parts of the OpenVDB reader share: vdb_container.c (names, places, metadata, transform), vdb.c (choice of a
 * grid, what the file says of it) and vdb_tree.c (tree to leaves and tiles). Facts about the format: headers of OpenVDB
 * 10.0.1, io/Compression.h, tree/ and math/Maps.h. The library itself is not linked: where it is found, a test holds
 * both readers against each other. */
#ifndef NPH_IO_VDB_H
#define NPH_IO_VDB_H

#include <stddef.h>
#include <stdint.h>

#include "io/volume.h"

/* Versions of the file format whose layout is known. */
enum { NPH_VDB_OLDEST = 222, NPH_VDB_NEWEST = 224 };
/* Compression of a grid: zip and blosc exclude each other in practice, blosc wins. */
enum { NPH_VDB_ZIP = 1, NPH_VDB_ACTIVE = 2, NPH_VDB_BLOSC = 4 };

/* In the file's bytes, not terminated. */
typedef struct NphVdbText {
    const char *text;
    uint64_t bytes;
} NphVdbText;

/* One grid as the container describes it; its places lie inside the file. */
typedef struct NphVdbGrid {
    NphVdbText name, type, grid_class;
    char shown[64];
    uint64_t grid_at, block_at, end_at, transform_at, topology_at;
    uint32_t compression;
    int half, instance; /* values saved as half; the tree is that of another grid */
    int affine;         /* its transform is; topology_at is set then */
    double voxel_size[3], world_from_index[12]; /* where affine */
    int has_count, has_box; /* of the metadata that follow; has_box 3: both corners */
    uint64_t active_voxels, memory_bytes;
    int32_t bbox_min[3], bbox_max[3];
} NphVdbGrid;

typedef struct NphVdbFile {
    NphContext *context;
    const char *path;
    unsigned char *bytes;
    uint64_t size, at;
    uint32_t file_version;
    NphVdbGrid *grids;
    uint64_t count;
} NphVdbFile;

/* vdb_container.c: reads the file and describes its grids; nothing is left allocated on failure. */
NphStatus nph_vdb_file_open(NphContext *context, const char *path, NphVdbFile *file);
void nph_vdb_file_close(NphVdbFile *file);
int nph_vdb_text_is(NphVdbText text, const char *word);
int nph_vdb_text_ends(NphVdbText text, const char *end);

/* A grid's bytes and what decoding them needs to know. */
typedef struct NphVdbSource {
    const unsigned char *bytes; /* of the file */
    uint64_t size;              /* up to the grid's end */
    uint64_t topology_at, block_at;
    uint32_t compression;
    int half; /* values are saved as half */
} NphVdbSource;

/* vdb_tree.c: leaves, tiles, background and what nph_volume_measure tells; NPH_BAD_INPUT names the byte. */
NphStatus nph_vdb_decode(NphContext *context, const char *path, const char *name, const NphVdbSource *source,
                         NphVolume *volume);

#endif
