/* SPDX-License-Identifier: Apache-2.0
 *
 * What volumes and arrays hold, and the optical depth a beam along each axis would meet if the values were extinctions
 * in 1/m: the number to look at before rendering. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cli/info.h"
#include "core/memory.h"
#include "core/message.h"
#include "field/cloud.h"
#include "field/grid.h"
#include "io/half.h"

static void tell_depths(Info *info, const NphGrid *grid, const NphGridStatistics *statistics) {
    facts_group(&info->facts, "as_density");
    facts_integer(&info->facts, "nonzero", grid->active);
    facts_number(&info->facts, "mean", statistics->mean);
    facts_number(&info->facts, "mean_of_nonzero", statistics->mean_active);
    facts_numbers(&info->facts, "optical_depth_mean_xyz", 3, statistics->axis_depth_mean);
    facts_numbers(&info->facts, "optical_depth_max_xyz", 3, statistics->axis_depth_max);
    facts_integer(&info->facts, "bytes", (int64_t)nph_grid_bytes(grid));
    facts_end(&info->facts);
}

static NphStatus tell_grid(Info *info, NphGrid *grid) {
    NphGridStatistics statistics;
    NphStatus status = nph_grid_statistics(info->context, grid, &statistics);
    if (status == NPH_OK) tell_depths(info, grid, &statistics);
    nph_grid_free(info->context, grid);
    return status;
}

static void tell_volume(Info *info, const NphVolume *volume) {
    Facts *facts = &info->facts;
    NphVolumeStatistics statistics;
    double boxed = 1;
    nph_volume_statistics(volume, &statistics);
    for (int a = 0; a < 3; a++) {
        double edge = (double)volume->bbox_max[a] - volume->bbox_min[a] + 1;
        boxed *= edge > 0 ? edge : 0;
    }
    facts_integers(facts, "active_min", 3, volume->bbox_min);
    facts_integers(facts, "active_max", 3, volume->bbox_max);
    facts_integer(facts, "active_voxels", (int64_t)volume->active_voxels);
    facts_number(facts, "active_part", boxed > 0 ? (double)volume->active_voxels / boxed : 0);
    facts_integer(facts, "leaves", volume->leaf_count);
    facts_integer(facts, "tiles", volume->tile_count);
    facts_number(facts, "background", volume->background);
    facts_number(facts, "min", statistics.min);
    facts_number(facts, "max", statistics.max);
    facts_number(facts, "mean_of_active", statistics.mean);
    facts_number(facts, "sum", statistics.sum);
    if (statistics.not_finite) facts_integer(facts, "not_finite", (int64_t)statistics.not_finite);
    facts_numbers(facts, "world_from_index_x", 4, volume->world_from_index);
    facts_numbers(facts, "world_from_index_y", 4, volume->world_from_index + 4);
    facts_numbers(facts, "world_from_index_z", 4, volume->world_from_index + 8);
}

/* Values that are no densities (negative, level sets) have no optical depth; that is said and is no error. */
static void tell_no_depth(Info *info) {
    facts_text(&info->facts, "optical_depth", "none: not a density (negative, not finite, or nonzero outside)");
}

static NphStatus tell_volume_depth(Info *info, const NphVolume *volume) {
    NphGrid grid = {0};
    NphVolumeStatistics statistics;
    nph_volume_statistics(volume, &statistics);
    if (statistics.not_finite || statistics.min < 0 || volume->background != 0) {
        tell_no_depth(info);
        return NPH_OK;
    }
    NPH_TRY(nph_grid_from_volume(info->context, volume, NPH_CENTRING_VDB, NPH_LOOKUP_TRILINEAR, info->path, &grid));
    return tell_grid(info, &grid);
}

typedef NphStatus (*ReadFn)(NphContext *context, const char *path, const char *grid, NphVolume *volume);

static NphStatus tell_vdb_grid(Info *info, const NphGridInfo *listed, ReadFn read) {
    Facts *facts = &info->facts;
    NphVolume volume = {0};
    facts_item(facts, listed->name[0] ? listed->name : "(unnamed)");
    facts_text(facts, "type", listed->type);
    facts_text(facts, "class", listed->grid_class);
    facts_text(facts, "codec", listed->codec);
    facts_integer(facts, "file_bytes", (int64_t)listed->file_bytes);
    facts_numbers(facts, "voxel_size", 3, listed->voxel_size);
    NphStatus status = NPH_OK;
    if (!listed->readable) {
        facts_text(facts, "values", "not decoded: no scalar type that nephos reads");
    } else {
        status = read(info->context, info->path, listed->name, &volume);
        if (status == NPH_OK) tell_volume(info, &volume);
        if (status == NPH_OK) status = tell_volume_depth(info, &volume);
        nph_volume_free(info->context, &volume);
    }
    facts_end(facts);
    return status;
}

static NphStatus tell_vdb_grids(Info *info, NphGridInfo *grids, int count, ReadFn read) {
    NphStatus status = NPH_OK;
    facts_list(&info->facts, "grids");
    for (int i = 0; i < count && status == NPH_OK; i++) status = tell_vdb_grid(info, &grids[i], read);
    facts_end(&info->facts);
    nph_free(info->context, grids);
    return status;
}

NphStatus info_nvdb(Info *info) {
    NphGridInfo *grids = NULL;
    int count = 0;
    NPH_TRY(nph_nvdb_list(info->context, info->path, &grids, &count));
    return tell_vdb_grids(info, grids, count, nph_nvdb_read);
}

NphStatus info_vdb(Info *info) {
    NphGridInfo *grids = NULL;
    int count = 0;
    NPH_TRY(nph_vdb_list(info->context, info->path, &grids, &count));
    return tell_vdb_grids(info, grids, count, nph_vdb_read);
}

static void tell_shape(Info *info, const char *key, const NphArray *array) {
    double shape[NPH_MAX_RANK];
    for (int i = 0; i < array->rank; i++) shape[i] = (double)array->shape[i];
    facts_numbers(&info->facts, key, array->rank, shape);
}

static double element(const NphArray *array, int64_t i) {
    switch (array->type) {
    case NPH_U8: return ((const uint8_t *)array->data)[i];
    case NPH_I8: return ((const int8_t *)array->data)[i];
    case NPH_U16: return ((const uint16_t *)array->data)[i];
    case NPH_I16: return ((const int16_t *)array->data)[i];
    case NPH_U32: return ((const uint32_t *)array->data)[i];
    case NPH_I32: return ((const int32_t *)array->data)[i];
    case NPH_F32: return ((const float *)array->data)[i];
    case NPH_U64: return (double)((const uint64_t *)array->data)[i];
    case NPH_I64: return (double)((const int64_t *)array->data)[i];
    case NPH_F64: return ((const double *)array->data)[i];
    case NPH_F16: break;
    }
    return nph_float_from_half(((const uint16_t *)array->data)[i]);
}

/* Range of the finite elements; returns 1 when all could be densities: finite and not negative. */
static int tell_range(Info *info, const char *what, const NphArray *array) {
    int64_t count = nph_array_count(array), finite = 0, nonzero = 0;
    double min = 0, max = 0, sum = 0;
    char key[64];
    for (int64_t i = 0; i < count; i++) {
        double value = element(array, i);
        if (!isfinite(value)) continue;
        min = !finite || value < min ? value : min;
        max = !finite || value > max ? value : max;
        sum += value;
        finite++;
        nonzero += value != 0;
    }
    const double values[] = {min, max, finite ? sum / (double)finite : 0,
                             count ? (double)nonzero / (double)count : 0, (double)(count - finite)};
    static const char *const names[] = {"min", "max", "mean", "nonzero_part", "not_finite"};
    for (int i = 0; i < 5; i++) {
        snprintf(key, sizeof key, "%s%s", what, names[i]);
        if (i < 4 || count > finite) facts_number(&info->facts, key, values[i]);
    }
    return finite == count && min >= 0;
}

NphStatus info_npy(Info *info) {
    NphArray array = {0};
    NphGrid grid = {0};
    NPH_TRY(nph_npy_read(info->context, info->path, &array));
    facts_text(&info->facts, "type", nph_type_name(array.type));
    tell_shape(info, "shape", &array);
    int density = tell_range(info, "", &array);
    NphStatus status = NPH_OK;
    if (!density) {
        tell_no_depth(info);
    } else if (array.rank == 3 && nph_array_count(&array) > 0) {
        facts_text(&info->facts, "seen_as", "cells of edge 1, axes z y x, values = extinction");
        double hi[3] = {(double)array.shape[2], (double)array.shape[1], (double)array.shape[0]};
        status = nph_grid_from_array(info->context, &array, (double[3]){0, 0, 0}, hi, NPH_CENTRING_CELL, NPH_OUTSIDE_ZERO,
                                     NPH_LOOKUP_TRILINEAR, info->path, &grid);
        if (status == NPH_OK) status = tell_grid(info, &grid);
    }
    nph_array_free(info->context, &array);
    return status;
}

/* Tells the steps between levels and makes them even, which a grid needs: files round altitudes. */
static void tell_levels(Info *info, NphArray *height_m) {
    double *z = height_m->data, steps[2] = {HUGE_VAL, 0};
    int64_t last = height_m->shape[0] - 1;
    for (int64_t k = 0; k < last; k++) {
        double step = z[k + 1] - z[k];
        steps[0] = step < steps[0] ? step : steps[0];
        steps[1] = step > steps[1] ? step : steps[1];
    }
    if (last < 1) return;
    facts_numbers(&info->facts, "step_z_from_to_m", 2, steps);
    double first = z[0], mean = (z[last] - z[0]) / (double)last;
    for (int64_t k = 0; k < last; k++) z[k] = first + (double)k * mean;
}

static NphStatus tell_cloud(Info *info, const NphLes *les) {
    double lo[3], hi[3];
    NphArray extinction = {0};
    NphGrid grid = {0};
    NPH_TRY(nph_cloud_extinction(info->context, les, info->path, &extinction, lo, hi));
    facts_numbers(&info->facts, "points_from_m", 3, lo);
    facts_numbers(&info->facts, "points_to_m", 3, hi);
    tell_range(info, "extinction_per_m_", &extinction);
    facts_text(&info->facts, "seen_as", "points (centring: point) on even levels, trilinear");
    NphStatus status = nph_grid_from_array(info->context, &extinction, lo, hi, NPH_CENTRING_POINT, NPH_OUTSIDE_ZERO,
                                           NPH_LOOKUP_TRILINEAR, info->path, &grid);
    nph_array_free(info->context, &extinction);
    return status == NPH_OK ? tell_grid(info, &grid) : status;
}

NphStatus info_les(Info *info) {
    NphLes les;
    memset(&les, 0, sizeof les);
    NPH_TRY(nph_les_read(info->context, info->path, &les));
    tell_shape(info, "points_zyx", &les.lwc_g_per_m3);
    facts_numbers(&info->facts, "spacing_xy_m", 2, les.spacing_m);
    tell_range(info, "water_g_per_m3_", &les.lwc_g_per_m3);
    tell_range(info, "radius_um_", &les.reff_um);
    tell_levels(info, &les.height_m);
    NphStatus status = tell_cloud(info, &les);
    nph_les_free(info->context, &les);
    return status;
}

/* Box, range, and the depths of cells that fill the box. */
static NphStatus tell_box_grid(Info *info, const NphBoxGrid *box, NphOutside outside) {
    NphGrid grid = {0};
    const char *seen = outside == NPH_OUTSIDE_ZERO ? "cells, values = extinction, zero outside"
                                                   : "cells, values = extinction, clamped at the border";
    tell_shape(info, box->values.rank == 4 ? "shape_zyxc" : "shape_zyx", &box->values);
    facts_numbers(&info->facts, "box_from", 3, box->lo);
    facts_numbers(&info->facts, "box_to", 3, box->hi);
    if (!tell_range(info, "", &box->values) || box->values.rank != 3) {
        tell_no_depth(info);
        return NPH_OK;
    }
    facts_text(&info->facts, "seen_as", seen);
    NPH_TRY(nph_grid_from_array(info->context, &box->values, box->lo, box->hi, NPH_CENTRING_CELL, outside,
                                NPH_LOOKUP_TRILINEAR, info->path, &grid));
    return tell_grid(info, &grid);
}

NphStatus info_vol(Info *info) {
    NphBoxGrid box = {0};
    NPH_TRY(nph_vol_read(info->context, info->path, &box));
    NphStatus status = tell_box_grid(info, &box, NPH_OUTSIDE_CLAMP);
    nph_box_grid_free(info->context, &box);
    return status;
}

static NphStatus tell_pbrt_medium(Info *info, const NphPbrtInfo *listed) {
    NphBoxGrid box = {0};
    facts_item(&info->facts, listed->name[0] ? listed->name : "(unnamed)");
    facts_text(&info->facts, "type", listed->type);
    NphStatus status = NPH_OK;
    if (!listed->readable) {
        facts_text(&info->facts, "values", "not read: no grid of densities (uniformgrid, heterogeneous)");
    } else {
        status = nph_pbrt_read(info->context, info->path, listed->name, &box);
        if (status == NPH_OK) status = tell_box_grid(info, &box, NPH_OUTSIDE_ZERO);
        nph_box_grid_free(info->context, &box);
    }
    facts_end(&info->facts);
    return status;
}

NphStatus info_pbrt(Info *info) {
    NphPbrtInfo *media = NULL;
    int count = 0;
    NphStatus status = NPH_OK;
    NPH_TRY(nph_pbrt_list(info->context, info->path, &media, &count));
    facts_list(&info->facts, "media");
    for (int i = 0; i < count && status == NPH_OK; i++) status = tell_pbrt_medium(info, &media[i]);
    facts_end(&info->facts);
    nph_free(info->context, media);
    return status;
}
