/* SPDX-License-Identifier: Apache-2.0
 *
 * OpenVDB volumes: choice of a grid by name, its values through vdb_tree.c, and what was decoded against what the file
 * says of itself. */
#include "io/vdb.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "io/printable.h"

static const char float_tree[] = "Tree_float_5_4_3";

/* "float", "half", "vec3s": the type without its usual frame, else all of it. */
static void name_type(const NphVdbGrid *grid, char type[16]) {
    static const char front[] = "Tree_", back[] = "_5_4_3";
    NphVdbText text = grid->type;
    if (text.bytes > sizeof front + sizeof back - 2 && memcmp(text.text, front, sizeof front - 1) == 0 &&
        nph_vdb_text_ends(text, back)) {
        text.text += sizeof front - 1;
        text.bytes -= sizeof front + sizeof back - 2;
    }
    if (nph_vdb_text_is(grid->type, float_tree) && grid->half) text = (NphVdbText){"half", 4};
    nph_printable(text.text, text.bytes, type, 16);
}

static void name_class(const NphVdbGrid *grid, char name[16]) {
    if (grid->grid_class.bytes) nph_printable(grid->grid_class.text, grid->grid_class.bytes, name, 16);
    else snprintf(name, 16, "unknown");
}

static int readable(const NphVdbGrid *grid) {
    return nph_vdb_text_is(grid->type, float_tree) && grid->affine && !grid->instance;
}

/* "'density' (float), 'velocity' (vec3s)" as far as it fits. */
static void list_names(const NphVdbFile *file, char *text, size_t capacity) {
    size_t used = (size_t)snprintf(text, capacity, "%s", file->count ? "" : "no grid");
    for (uint64_t i = 0; i < file->count && used < capacity; i++) {
        char type[16];
        name_type(&file->grids[i], type);
        int written = snprintf(text + used, capacity - used, "%s'%s' (%s)", i ? ", " : "", file->grids[i].shown, type);
        used += written > 0 ? (size_t)written : 0;
    }
}

static NphStatus check_readable(const NphVdbFile *file, const NphVdbGrid *grid) {
    char type[16];
    name_type(grid, type);
    if (readable(grid)) return NPH_OK;
    if (!nph_vdb_text_is(grid->type, float_tree))
        return nph_error(file->context, NPH_BAD_INPUT, "%s: grid '%s': its type %s is not read (float and half are)",
                         file->path, grid->shown, type);
    if (grid->instance)
        return nph_error(file->context, NPH_BAD_INPUT,
                         "%s: grid '%s' shares the tree of another grid; write the file without instancing", file->path,
                         grid->shown);
    return nph_error(file->context, NPH_BAD_INPUT,
                     "%s: grid '%s', byte %llu: its transform is a frustum; only affine transforms are read", file->path,
                     grid->shown, (unsigned long long)grid->transform_at);
}

static NphStatus choose(const NphVdbFile *file, const char *wanted, const NphVdbGrid **chosen) {
    char names[512], shown[64];
    const char *name = wanted ? wanted : "density";
    uint64_t found = 0;
    for (uint64_t i = 0; i < file->count; i++) {
        if (!nph_vdb_text_is(file->grids[i].name, name) && (wanted || file->count > 1)) continue;
        *chosen = &file->grids[i];
        found++;
    }
    list_names(file, names, sizeof names);
    nph_printable(name, strlen(name), shown, sizeof shown);
    if (found == 0)
        return nph_error(file->context, NPH_BAD_INPUT, "%s: has no grid '%s'%s; it holds %s", file->path, shown,
                         wanted ? "" : " (the default; choose one by name)", names);
    if (found > 1)
        return nph_error(file->context, NPH_BAD_INPUT, "%s: has %llu grids named '%s'; it holds %s", file->path,
                         (unsigned long long)found, shown, names);
    return check_readable(file, *chosen);
}

/* ---- values ---- */

/* What was decoded against what the file says of it. */
static NphStatus check_against_file(const NphVdbFile *file, const NphVdbGrid *grid, const NphVolume *volume) {
    if (grid->has_count && grid->active_voxels != volume->active_voxels)
        return nph_error(file->context, NPH_BAD_INPUT,
                         "%s: grid '%s': %llu active voxels are announced, but the masks hold %llu; the file was damaged",
                         file->path, grid->shown, (unsigned long long)grid->active_voxels,
                         (unsigned long long)volume->active_voxels);
    for (int axis = 0; axis < 3 && grid->has_box == 3 && volume->active_voxels; axis++)
        if (grid->bbox_min[axis] != volume->bbox_min[axis] || grid->bbox_max[axis] != volume->bbox_max[axis])
            return nph_error(file->context, NPH_BAD_INPUT,
                             "%s: grid '%s': the active box is announced as %d to %d along %c, but the masks span %d to "
                             "%d; the file was damaged",
                             file->path, grid->shown, grid->bbox_min[axis], grid->bbox_max[axis], "xyz"[axis],
                             volume->bbox_min[axis], volume->bbox_max[axis]);
    return NPH_OK;
}

static NphStatus read_tree(const NphVdbFile *file, const NphVdbGrid *grid, NphVolume *volume) {
    NphVdbSource source = {.bytes = file->bytes, .size = grid->end_at, .topology_at = grid->topology_at,
                           .block_at = grid->block_at, .compression = grid->compression, .half = grid->half};
    NphVolume made;
    for (int i = 0; i < 12; i++)
        if (!isfinite(grid->world_from_index[i]))
            return nph_error(file->context, NPH_BAD_INPUT, "%s: grid '%s', byte %llu: its transform is not finite",
                             file->path, grid->shown, (unsigned long long)grid->transform_at);
    NPH_TRY(nph_vdb_decode(file->context, file->path, grid->shown, &source, &made));
    memcpy(made.world_from_index, grid->world_from_index, sizeof made.world_from_index);
    memcpy(made.name, grid->shown, sizeof made.name);
    name_type(grid, made.type);
    name_class(grid, made.grid_class);
    NphStatus status = check_against_file(file, grid, &made);
    if (status != NPH_OK) nph_volume_free(file->context, &made);
    else *volume = made;
    return status;
}

NphStatus nph_vdb_read(NphContext *context, const char *path, const char *grid_name, NphVolume *volume) {
    NphVdbFile file;
    const NphVdbGrid *grid = NULL;
    NPH_TRY(nph_vdb_file_open(context, path, &file));
    NphStatus status = choose(&file, grid_name, &grid);
    if (status == NPH_OK) status = read_tree(&file, grid, volume);
    nph_vdb_file_close(&file);
    return status;
}

static void describe(const NphVdbGrid *grid, NphGridInfo *info) {
    memcpy(info->name, grid->shown, sizeof info->name);
    name_type(grid, info->type);
    name_class(grid, info->grid_class);
    snprintf(info->codec, sizeof info->codec, "%s",
             grid->compression & NPH_VDB_BLOSC ? "blosc" : grid->compression & NPH_VDB_ZIP ? "zip" : "none");
    info->readable = readable(grid);
    int empty = grid->active_voxels == 0 || grid->has_box != 3;
    for (int axis = 0; axis < 3; axis++) {
        info->bbox_min[axis] = empty ? 0 : grid->bbox_min[axis];
        info->bbox_max[axis] = empty ? -1 : grid->bbox_max[axis];
        info->voxel_size[axis] = grid->voxel_size[axis];
    }
    info->active_voxels = grid->active_voxels;
    info->file_bytes = grid->end_at - grid->grid_at;
    info->grid_bytes = grid->memory_bytes;
}

NphStatus nph_vdb_list(NphContext *context, const char *path, NphGridInfo **grids, int *count) {
    NphVdbFile file;
    NPH_TRY(nph_vdb_file_open(context, path, &file));
    NphGridInfo *made = NULL;
    NphStatus status = NPH_NEW(context, file.count, "grid list", &made);
    if (status == NPH_OK) {
        for (uint64_t i = 0; i < file.count; i++) describe(&file.grids[i], &made[i]);
        *grids = made;
        *count = (int)file.count;
    }
    nph_vdb_file_close(&file);
    return status;
}
