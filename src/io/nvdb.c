/* SPDX-License-Identifier: Apache-2.0
 *
 * The container of a .nvdb file: segments, each a header of 16 bytes, a description of 176 bytes and a name per grid,
 * then the grids one after another, packed with the segment's codec. Every count and size is checked against the bytes
 * that are there before it is followed. */
#include "io/nvdb.h"

#include <stdio.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "io/file.h"
#include "io/printable.h"

/* Offsets in a segment's header and in a grid's description. */
enum { SEGMENT_BYTES = 16, SEGMENT_VERSION = 8, SEGMENT_GRIDS = 12, SEGMENT_CODEC = 14 };
enum {
    META_BYTES = 176, META_GRID_BYTES = 0, META_FILE_BYTES = 8, META_VOXELS = 24, META_TYPE = 32, META_CLASS = 36,
    META_BBOX = 88, META_VOXEL_SIZE = 112, META_NAME_BYTES = 136, META_CODEC = 168
};

typedef struct Container {
    NphContext *context;
    const char *path;
    unsigned char *bytes;
    uint64_t size, at;
    NphNvdbEntry *entries;
    uint64_t count, capacity;
} Container;

void nph_nvdb_type_name(uint32_t type, char name[16]) {
    static const char *const names[] = {
        "unknown", "float", "double", "int16", "int32", "int64", "vec3f", "vec3d", "mask", "half", "uint32", "bool",
        "rgba8", "Fp4", "Fp8", "Fp16", "FpN", "vec4f", "vec4d", "index", "onindex", "indexmask", "onindexmask",
        "pointindex", "vec3u8", "vec3u16", "uint8"};
    if (type < sizeof names / sizeof *names) snprintf(name, 16, "%s", names[type]);
    else snprintf(name, 16, "type %lu", (unsigned long)type);
}

void nph_nvdb_class_name(uint32_t grid_class, char name[16]) {
    static const char *const names[] = {"unknown", "level set", "fog volume", "staggered", "point index", "point data",
                                        "topology", "voxel volume", "index grid", "tensor grid"};
    snprintf(name, 16, "%s", grid_class < sizeof names / sizeof *names ? names[grid_class] : "unknown class");
}

static uint32_t load_u16(const unsigned char *at) { return (uint32_t)at[0] | (uint32_t)at[1] << 8; }

static double load_f64(const unsigned char *at) {
    uint64_t bits = nph_load_u64(at);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static NphStatus cut_short(const Container *file, uint64_t at, const char *what) {
    return nph_error(file->context, NPH_BAD_INPUT,
                     "%s: byte %llu: %s goes beyond the file's end at %llu; it was cut or damaged", file->path,
                     (unsigned long long)at, what, (unsigned long long)file->size);
}

/* What else it could be; helps whoever renamed or never converted a file. */
static NphStatus refuse_magic(const Container *file) {
    const unsigned char *word = file->bytes + file->at;
    if (file->at == 0 && memcmp(word, " BDV", 4) == 0)
        return nph_error(file->context, NPH_BAD_INPUT,
                         "%s: is an OpenVDB file; give it the ending .vdb, by which it is read", file->path);
    if (memcmp(word + 1, "BDVonaN", 7) == 0)
        return nph_error(file->context, NPH_BAD_INPUT,
                         "%s: byte %llu: is big-endian; only little-endian NanoVDB is read", file->path,
                         (unsigned long long)file->at);
    return nph_error(file->context, NPH_BAD_INPUT,
                     "%s: byte %llu: no NanoVDB segment starts here (\"NanoVDB0\" or \"NanoVDB2\")", file->path,
                     (unsigned long long)file->at);
}

/* A grid's description and name; moves on behind them. */
static NphStatus read_entry(Container *file, uint32_t codec, NphNvdbEntry *entry) {
    const unsigned char *meta = file->bytes + file->at;
    if (file->size - file->at < META_BYTES) return cut_short(file, file->at, "a grid's description");
    uint64_t name_bytes = nph_load_u32(meta + META_NAME_BYTES);
    if (name_bytes > file->size - file->at - META_BYTES)
        return cut_short(file, file->at + META_NAME_BYTES, "a grid's name");
    const char *name = (const char *)meta + META_BYTES;
    const char *end = memchr(name, 0, name_bytes);
    *entry = (NphNvdbEntry){.name = name, .name_bytes = end ? (size_t)(end - name) : name_bytes, .meta_at = file->at,
                            .grid_bytes = nph_load_u64(meta + META_GRID_BYTES),
                            .file_bytes = nph_load_u64(meta + META_FILE_BYTES),
                            .active_voxels = nph_load_u64(meta + META_VOXELS), .type = nph_load_u32(meta + META_TYPE),
                            .grid_class = nph_load_u32(meta + META_CLASS), .codec = codec};
    nph_printable(name, entry->name_bytes, entry->shown, sizeof entry->shown);
    for (int axis = 0; axis < 3; axis++) {
        entry->bbox_min[axis] = (int32_t)nph_load_u32(meta + META_BBOX + 4 * axis);
        entry->bbox_max[axis] = (int32_t)nph_load_u32(meta + META_BBOX + 12 + 4 * axis);
        entry->voxel_size[axis] = load_f64(meta + META_VOXEL_SIZE + 8 * axis);
    }
    if (load_u16(meta + META_CODEC) != codec)
        return nph_error(file->context, NPH_BAD_INPUT, "%s: byte %llu: grid '%s' names another codec than its segment",
                         file->path, (unsigned long long)(file->at + META_CODEC), entry->shown);
    file->at += META_BYTES + name_bytes;
    return NPH_OK;
}

/* The places of a segment's grids, behind the last description. */
static NphStatus place_grids(Container *file, NphNvdbEntry *entries, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        NphNvdbEntry *entry = &entries[i];
        entry->data_at = file->at;
        if (entry->file_bytes > file->size - file->at)
            return cut_short(file, entry->meta_at + META_FILE_BYTES, "a grid");
        if (entry->codec == NPH_NVDB_NONE && entry->file_bytes != entry->grid_bytes)
            return nph_error(file->context, NPH_BAD_INPUT,
                             "%s: byte %llu: grid '%s' is not packed, but is %llu bytes in the file, %llu unpacked",
                             file->path, (unsigned long long)entry->meta_at, entry->shown,
                             (unsigned long long)entry->file_bytes, (unsigned long long)entry->grid_bytes);
        file->at += entry->file_bytes;
    }
    return NPH_OK;
}

static NphStatus read_segment(Container *file) {
    if (file->size - file->at < SEGMENT_BYTES) return cut_short(file, file->at, "a segment's header");
    const unsigned char *header = file->bytes + file->at;
    uint64_t magic = nph_load_u64(header), start = file->at;
    if (magic != NPH_NVDB_MAGIC && magic != NPH_NVDB_MAGIC_FILE) return refuse_magic(file);
    uint32_t major = nph_load_u32(header + SEGMENT_VERSION) >> 21, count = load_u16(header + SEGMENT_GRIDS);
    uint32_t codec = load_u16(header + SEGMENT_CODEC);
    if (major != NPH_NVDB_MAJOR)
        return nph_error(file->context, NPH_BAD_INPUT,
                         "%s: byte %llu: NanoVDB version %lu; %d is read: convert the volume with a current one",
                         file->path, (unsigned long long)(start + SEGMENT_VERSION), (unsigned long)major,
                         NPH_NVDB_MAJOR);
    if (!nph_nvdb_codec_name(codec))
        return nph_error(file->context, NPH_BAD_INPUT,
                         "%s: byte %llu: codec %lu is unknown (none, zip and blosc are read)", file->path,
                         (unsigned long long)(start + SEGMENT_CODEC), (unsigned long)codec);
    if (count == 0)
        return nph_error(file->context, NPH_BAD_INPUT, "%s: byte %llu: the segment holds no grids", file->path,
                         (unsigned long long)(start + SEGMENT_GRIDS));
    file->at += SEGMENT_BYTES;
    if (count > (file->size - file->at) / META_BYTES)
        return cut_short(file, start + SEGMENT_GRIDS, "the list of grids");
    if (file->count + count > file->capacity) {
        uint64_t capacity = 2 * file->count + count;
        NPH_TRY(nph_realloc(file->context, capacity, sizeof *file->entries, "volume grids", (void **)&file->entries));
        file->capacity = capacity;
    }
    NphNvdbEntry *entries = file->entries + file->count;
    for (uint32_t i = 0; i < count; i++) NPH_TRY(read_entry(file, codec, &entries[i]));
    file->count += count;
    return place_grids(file, entries, count);
}

/* Reads the file and describes its grids. On failure nothing is left allocated. */
static NphStatus open_container(NphContext *context, const char *path, Container *file) {
    char *bytes = NULL;
    size_t size = 0;
    NPH_TRY(nph_file_read(context, path, &bytes, &size));
    *file = (Container){.context = context, .path = path, .bytes = (unsigned char *)bytes, .size = size};
    NphStatus status = NPH_OK;
    if (size == 0) status = nph_error(context, NPH_BAD_INPUT, "%s: is empty", path);
    while (status == NPH_OK && file->at < file->size) status = read_segment(file);
    if (status != NPH_OK) {
        nph_free(context, file->entries);
        nph_free(context, bytes);
    }
    return status;
}

static void close_container(Container *file) {
    nph_free(file->context, file->entries);
    nph_free(file->context, file->bytes);
    file->entries = NULL;
    file->bytes = NULL;
}

/* "density (float), velocity (vec3f)" as far as it fits. */
static void list_names(const Container *file, char *text, size_t capacity) {
    size_t used = 0;
    text[0] = 0;
    for (uint64_t i = 0; i < file->count && used < capacity; i++) {
        char type[16];
        nph_nvdb_type_name(file->entries[i].type, type);
        const char *name = file->entries[i].shown;
        int written = snprintf(text + used, capacity - used, "%s'%s' (%s)", i ? ", " : "", name, type);
        used += written > 0 ? (size_t)written : 0;
    }
}

static NphStatus choose(const Container *file, const char *wanted, const NphNvdbEntry **chosen) {
    char names[512], shown[64];
    uint64_t found = 0;
    const char *name = wanted ? wanted : "density";
    size_t bytes = strlen(name);
    for (uint64_t i = 0; i < file->count; i++) {
        const NphNvdbEntry *entry = &file->entries[i];
        int match = entry->name_bytes == bytes && memcmp(entry->name, name, bytes) == 0;
        if (!match && (wanted || file->count > 1)) continue;
        *chosen = entry;
        found++;
    }
    list_names(file, names, sizeof names);
    nph_printable(name, bytes, shown, sizeof shown);
    if (found == 0)
        return nph_error(file->context, NPH_BAD_INPUT, "%s: has no grid '%s'%s; it holds %s", file->path, shown,
                         wanted ? "" : " (the default; choose one by name)", names);
    if (found > 1)
        return nph_error(file->context, NPH_BAD_INPUT, "%s: has %llu grids named '%s'; it holds %s", file->path,
                         (unsigned long long)found, shown, names);
    if (nph_nvdb_type_readable((*chosen)->type)) return NPH_OK;
    char type[16];
    nph_nvdb_type_name((*chosen)->type, type);
    return nph_error(file->context, NPH_BAD_INPUT,
                     "%s: grid '%s', byte %llu: its type %s is not read (float, half, Fp4, Fp8, Fp16 and FpN are)",
                     file->path, (*chosen)->shown, (unsigned long long)((*chosen)->meta_at + META_TYPE), type);
}

static NphStatus read_chosen(Container *file, const char *grid_name, NphVolume *volume) {
    const NphNvdbEntry *found = NULL;
    NPH_TRY(choose(file, grid_name, &found));
    NphNvdbEntry entry = *found;
    NphNvdbBuffer buffer = {.path = file->path, .name = entry.shown, .bytes = file->bytes + entry.data_at,
                            .size = entry.grid_bytes, .file_offset = entry.data_at};
    if (entry.codec == NPH_NVDB_NONE) return nph_nvdb_decode(file->context, &buffer, entry.type, volume);
    unsigned char *unpacked = NULL;
    NPH_TRY(nph_nvdb_unpack(file->context, file->path, file->bytes, &entry, &unpacked));
    close_container(file); /* the packed bytes are not needed beside the leaves */
    buffer.bytes = unpacked;
    buffer.file_offset = 0;
    buffer.unpacked = 1;
    NphStatus status = nph_nvdb_decode(file->context, &buffer, entry.type, volume);
    nph_free(file->context, unpacked);
    return status;
}

NphStatus nph_nvdb_read(NphContext *context, const char *path, const char *grid_name, NphVolume *volume) {
    Container file;
    NPH_TRY(open_container(context, path, &file));
    NphStatus status = read_chosen(&file, grid_name, volume);
    close_container(&file);
    return status;
}

static void describe(const NphNvdbEntry *entry, NphGridInfo *info) {
    memcpy(info->name, entry->shown, sizeof info->name);
    nph_nvdb_type_name(entry->type, info->type);
    nph_nvdb_class_name(entry->grid_class, info->grid_class);
    snprintf(info->codec, sizeof info->codec, "%s", nph_nvdb_codec_name(entry->codec));
    info->readable = nph_nvdb_type_readable(entry->type);
    int empty = entry->active_voxels == 0;
    for (int axis = 0; axis < 3; axis++) {
        info->bbox_min[axis] = empty ? 0 : entry->bbox_min[axis];
        info->bbox_max[axis] = empty ? -1 : entry->bbox_max[axis];
        info->voxel_size[axis] = entry->voxel_size[axis];
    }
    info->active_voxels = entry->active_voxels;
    info->file_bytes = entry->file_bytes;
    info->grid_bytes = entry->grid_bytes;
}

NphStatus nph_nvdb_list(NphContext *context, const char *path, NphGridInfo **grids, int *count) {
    Container file;
    NPH_TRY(open_container(context, path, &file));
    NphGridInfo *made = NULL;
    NphStatus status = NPH_NEW(context, file.count, "grid list", &made);
    if (status == NPH_OK) {
        for (uint64_t i = 0; i < file.count; i++) describe(&file.entries[i], &made[i]);
        *grids = made;
        *count = (int)file.count;
    }
    close_container(&file);
    return status;
}
