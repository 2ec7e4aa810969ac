/* SPDX-License-Identifier: Apache-2.0
 *
 * The container of a .vdb file: header, metadata, then grid after grid, each behind a descriptor (name, type, places)
 * and with compression, metadata and a transform of its own. Every count and size is checked against the bytes that are
 * there before it is followed; trees are stepped over. */
#include <math.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "io/file.h"
#include "io/nvdb.h" /* nph_load_u32, nph_load_u64 */
#include "io/printable.h"
#include "io/vdb.h"

enum { MAGIC_BYTES = 8, HEAD_BYTES = 57, NAME_SEPARATOR = 0x1e };
static const char half_suffix[] = "_HalfFloat";

static NphStatus damaged(const NphVdbFile *file, uint64_t at, const char *what) {
    return nph_error(file->context, NPH_BAD_INPUT, "%s: byte %llu: %s; the file was cut or damaged", file->path,
                     (unsigned long long)at, what);
}

static NphStatus take(NphVdbFile *file, uint64_t bytes, const char *what, const unsigned char **taken) {
    if (bytes > file->size - file->at)
        return nph_error(file->context, NPH_BAD_INPUT,
                         "%s: byte %llu: %s goes beyond the file's end at %llu; it was cut or damaged", file->path,
                         (unsigned long long)file->at, what, (unsigned long long)file->size);
    *taken = file->bytes + file->at;
    file->at += bytes;
    return NPH_OK;
}

static NphStatus take_u32(NphVdbFile *file, const char *what, uint32_t *word) {
    const unsigned char *at = NULL;
    NPH_TRY(take(file, 4, what, &at));
    *word = nph_load_u32(at);
    return NPH_OK;
}

/* A 32-bit length and as many bytes. */
static NphStatus take_text(NphVdbFile *file, const char *what, NphVdbText *text) {
    uint32_t bytes = 0;
    const unsigned char *at = NULL;
    NPH_TRY(take_u32(file, what, &bytes));
    NPH_TRY(take(file, bytes, what, &at));
    *text = (NphVdbText){(const char *)at, bytes};
    return NPH_OK;
}

int nph_vdb_text_is(NphVdbText text, const char *word) {
    return text.bytes == strlen(word) && memcmp(text.text, word, text.bytes) == 0;
}

int nph_vdb_text_ends(NphVdbText text, const char *end) {
    uint64_t bytes = strlen(end);
    return text.bytes >= bytes && memcmp(text.text + text.bytes - bytes, end, bytes) == 0;
}

/* ---- metadata: name, type, size, value ---- */

static int32_t load_i32(const char *at) { return (int32_t)nph_load_u32((const unsigned char *)at); }

/* Keeps what matters of a grid's metadata; a known name with another type or size is let be. */
static void keep(NphVdbGrid *grid, NphVdbText name, NphVdbText type, NphVdbText value, int *half) {
    if (nph_vdb_text_is(name, "class") && nph_vdb_text_is(type, "string")) grid->grid_class = value;
    if (nph_vdb_text_is(name, "is_saved_as_half_float") && nph_vdb_text_is(type, "bool") && value.bytes == 1) *half = value.text[0] != 0;
    if (nph_vdb_text_is(name, "file_voxel_count") && nph_vdb_text_is(type, "int64") && value.bytes == 8) {
        grid->active_voxels = nph_load_u64((const unsigned char *)value.text);
        grid->has_count = 1;
    }
    if (nph_vdb_text_is(name, "file_mem_bytes") && nph_vdb_text_is(type, "int64") && value.bytes == 8)
        grid->memory_bytes = nph_load_u64((const unsigned char *)value.text);
    int lo = nph_vdb_text_is(name, "file_bbox_min"), hi = nph_vdb_text_is(name, "file_bbox_max");
    if ((lo || hi) && nph_vdb_text_is(type, "vec3i") && value.bytes == 12) {
        for (int axis = 0; axis < 3; axis++)
            (lo ? grid->bbox_min : grid->bbox_max)[axis] = load_i32(value.text + 4 * axis);
        grid->has_box |= lo ? 1 : 2;
    }
}

/* grid NULL: the file's own, stepped over. */
static NphStatus read_metadata(NphVdbFile *file, NphVdbGrid *grid) {
    uint32_t count = 0;
    uint64_t at = file->at;
    int half = -1;
    NPH_TRY(take_u32(file, "the number of metadata", &count));
    for (uint32_t i = 0; i < count; i++) {
        NphVdbText name, type, value;
        NPH_TRY(take_text(file, "the name of metadata", &name));
        NPH_TRY(take_text(file, "the type of metadata", &type));
        NPH_TRY(take_text(file, "the value of metadata", &value));
        if (grid) keep(grid, name, type, value, &half);
    }
    if (half >= 0 && half != grid->half)
        return damaged(file, at, "metadata and type disagree on whether values are saved as half");
    return NPH_OK;
}

/* ---- transform ---- */

static double load_f64(const unsigned char *at) {
    uint64_t bits = nph_load_u64(at);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* The maps that are affine: their sizes, and where in them stand a translation, the scales of the axes, or a matrix of
 * 4 x 4 doubles by which rows are multiplied (-1: not there). What is derived from these in the file is not read. */
static const struct {
    const char *name;
    uint64_t bytes;
    int translation_at, scale_at, matrix_at;
} maps[] = {{"AffineMap", 128, -1, -1, 0},         {"UnitaryMap", 128, -1, -1, 0},
            {"ScaleMap", 120, -1, 0, -1},          {"UniformScaleMap", 120, -1, 0, -1},
            {"ScaleTranslateMap", 144, 0, 24, -1}, {"UniformScaleTranslateMap", 144, 0, 24, -1},
            {"TranslationMap", 24, 0, -1, -1}};

static void load_map(const unsigned char *map, size_t kind, NphVdbGrid *grid) {
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 4; column++) {
            double value = row == column;
            if (maps[kind].matrix_at >= 0) value = load_f64(map + 32 * column + 8 * row);
            else if (column == 3) value = maps[kind].translation_at >= 0 ? load_f64(map + 8 * row) : 0;
            else if (row == column && maps[kind].scale_at >= 0) value = load_f64(map + maps[kind].scale_at + 8 * row);
            grid->world_from_index[4 * row + column] = value;
        }
    for (int axis = 0; axis < 3; axis++) {
        const double *m = grid->world_from_index + axis;
        grid->voxel_size[axis] = sqrt(m[0] * m[0] + m[4] * m[4] + m[8] * m[8]);
    }
}

static NphStatus read_transform(NphVdbFile *file, NphVdbGrid *grid) {
    NphVdbText type;
    grid->transform_at = file->at;
    NPH_TRY(take_text(file, "a transform", &type));
    for (size_t i = 0; i < sizeof maps / sizeof *maps; i++) {
        const unsigned char *map = NULL;
        if (!nph_vdb_text_is(type, maps[i].name)) continue;
        NPH_TRY(take(file, maps[i].bytes, "a transform", &map));
        load_map(map, i, grid);
        grid->affine = 1;
        grid->topology_at = file->at;
        return NPH_OK;
    }
    char shown[64];
    nph_printable(type.text, type.bytes, shown, sizeof shown);
    if (nph_vdb_text_is(type, "NonlinearFrustumMap")) return NPH_OK; /* listed, but not read */
    return nph_error(file->context, NPH_BAD_INPUT, "%s: grid '%s', byte %llu: the transform '%s' is unknown", file->path,
                     grid->shown, (unsigned long long)grid->transform_at, shown);
}

/* ---- grids ---- */

static NphStatus read_descriptor(NphVdbFile *file, NphVdbGrid *grid) {
    NphVdbText parent;
    const unsigned char *places = NULL;
    NPH_TRY(take_text(file, "a grid's name", &grid->name));
    NPH_TRY(take_text(file, "a grid's type", &grid->type));
    NPH_TRY(take_text(file, "a grid's parent", &parent));
    const char *number = memchr(grid->name.text, NAME_SEPARATOR, grid->name.bytes); /* tells equal names apart */
    if (number) grid->name.bytes = (uint64_t)(number - grid->name.text);
    nph_printable(grid->name.text, grid->name.bytes, grid->shown, sizeof grid->shown);
    grid->half = nph_vdb_text_ends(grid->type, half_suffix);
    if (grid->half) grid->type.bytes -= sizeof half_suffix - 1;
    grid->instance = parent.bytes > 0;
    uint64_t at = file->at;
    NPH_TRY(take(file, 24, "a grid's places", &places));
    grid->grid_at = nph_load_u64(places);
    grid->block_at = nph_load_u64(places + 8);
    grid->end_at = nph_load_u64(places + 16);
    /* an instance has no blocks of its own: its second place is 0 */
    if (grid->grid_at < file->at || grid->grid_at > grid->end_at || grid->end_at > file->size ||
        (!grid->instance && (grid->block_at < grid->grid_at || grid->block_at > grid->end_at)))
        return damaged(file, at, "a grid does not lie within the file, behind its descriptor");
    return NPH_OK;
}

static NphStatus read_grid(NphVdbFile *file, NphVdbGrid *grid) {
    NPH_TRY(read_descriptor(file, grid));
    file->at = grid->grid_at;
    NPH_TRY(take_u32(file, "a grid's compression", &grid->compression));
    if (grid->compression & ~(uint32_t)(NPH_VDB_ZIP | NPH_VDB_ACTIVE | NPH_VDB_BLOSC))
        return damaged(file, grid->grid_at, "the grid's compression is unknown");
    NPH_TRY(read_metadata(file, grid));
    NPH_TRY(read_transform(file, grid));
    if (file->at > grid->end_at) return damaged(file, file->at, "a grid's head goes beyond its end");
    file->at = grid->end_at;
    return NPH_OK;
}

static NphStatus read_head(NphVdbFile *file) {
    const unsigned char *head = NULL;
    if (file->size == 0) return nph_error(file->context, NPH_BAD_INPUT, "%s: is empty", file->path);
    if (file->size < MAGIC_BYTES || memcmp(file->bytes, " BDV\0\0\0\0", MAGIC_BYTES) != 0)
        return nph_error(file->context, NPH_BAD_INPUT, "%s: byte 0: no OpenVDB file starts here", file->path);
    NPH_TRY(take(file, HEAD_BYTES, "the header", &head));
    file->file_version = nph_load_u32(head + 8);
    if (file->file_version < NPH_VDB_OLDEST || file->file_version > NPH_VDB_NEWEST)
        return nph_error(file->context, NPH_BAD_INPUT,
                         "%s: byte 8: version %lu of the file format; %d to %d are read: write the volume anew with "
                         "another release of the program it comes from",
                         file->path, (unsigned long)file->file_version, NPH_VDB_OLDEST, NPH_VDB_NEWEST);
    if (head[20] != 1)
        return nph_error(file->context, NPH_BAD_INPUT,
                         "%s: byte 20: the file was written as a stream, without the places of its grids; write it as a "
                         "file",
                         file->path);
    return read_metadata(file, NULL);
}

static NphStatus read_grids(NphVdbFile *file) {
    enum { DESCRIPTOR_BYTES = 36 };
    uint32_t count = 0;
    NPH_TRY(read_head(file));
    uint64_t at = file->at;
    NPH_TRY(take_u32(file, "the number of grids", &count));
    if (count > (file->size - file->at) / DESCRIPTOR_BYTES) return damaged(file, at, "there are not that many grids");
    NPH_TRY(NPH_NEW(file->context, count, "volume grids", &file->grids));
    for (; file->count < count; file->count++) NPH_TRY(read_grid(file, &file->grids[file->count]));
    return NPH_OK;
}

void nph_vdb_file_close(NphVdbFile *file) {
    nph_free(file->context, file->grids);
    nph_free(file->context, file->bytes);
}

NphStatus nph_vdb_file_open(NphContext *context, const char *path, NphVdbFile *file) {
    char *bytes = NULL;
    size_t size = 0;
    NPH_TRY(nph_file_read(context, path, &bytes, &size));
    *file = (NphVdbFile){.context = context, .path = path, .bytes = (unsigned char *)bytes, .size = size};
    NphStatus status = read_grids(file);
    if (status != NPH_OK) nph_vdb_file_close(file);
    return status;
}
