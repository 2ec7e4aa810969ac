/* SPDX-License-Identifier: Apache-2.0
 *
 * OpenVDB volumes: what OpenVDB's own iterators count in them, equality with the NanoVDB files made from them, choice by
 * name, and damaged files, which must be refused or read soundly. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "harness.h"
#include "io/file.h"
#include "io/half.h"
#include "io/volume.h"

static const char *data_path(const char *file) {
    char relative[256];
    snprintf(relative, sizeof relative, "reference/data/%s", file);
    return nph_test_path(relative);
}

typedef struct Probe {
    int32_t ijk[3];
    float value;
    int active;
} Probe;

static const struct {
    const char *file, *grid, *type, *grid_class;
    int32_t bbox_min[3], bbox_max[3];
    uint64_t active_voxels;
    int leaves, tiles;
    float min, max;
    double sum;
    Probe probes[3];
} expected[] = {
    {"smoke_0024.vdb", "density", "float", "fog volume", {15, 14, 1}, {58, 59, 54}, 30836, 144, 0, 1.0006263e-06f,
     0.986133635f, 8109.6239423713969,
     {{{15, 30, 30}, 3.11940107e-06f, 1}, {{30, 47, 32}, 0.68044281f, 1}, {{27, 40, 36}, 0.0f, 0}}},
    {"plume32_f20_BLOSC_float32.vdb", "density", "float", "fog volume", {4, 3, 1}, {21, 20, 17}, 2462, 24, 0,
     1.01119542e-06f, 0.949345708f, 459.98052413608025,
     {{{7, 6, 7}, 2.24097062e-06f, 1}, {{11, 5, 14}, 0.000133002017f, 1}, {{6, 20, 8}, 0.0f, 0}}},
    {"plume32_f20_BLOSC_float32.vdb", "flame", "float", "fog volume", {0, 0, 0}, {-1, -1, -1}, 0, 0, 0, 0.0f, 0.0f, 0,
     {{{0, 0, 0}, 0.0f, 0}, {{0, 0, 0}, 0.0f, 0}, {{0, 0, 0}, 0.0f, 0}}},
    {"plume32_f20_BLOSC_float32.vdb", "shadow", "float", "fog volume", {0, 0, 0}, {23, 23, 31}, 18432, 0, 36, -1.0f,
     -1.0f, -18432,
     {{{0, 0, 0}, -1.0f, 1}, {{0, 8, 24}, -1.0f, 1}, {{-1, 0, 0}, 0.0f, 0}}},
    {"plume32_f20_BLOSC_float32.vdb", "temperature", "float", "fog volume", {4, 3, 1}, {21, 20, 17}, 2445, 24, 0,
     1.11650945e-06f, 1.19387841f, 670.38382577516018,
     {{{7, 6, 7}, 3.17111858e-06f, 1}, {{11, 6, 12}, 0.473142177f, 1}, {{19, 13, 4}, 0.0f, 0}}},
    {"smoke_0048_ZIP_float16_unknownclass.vdb", "density", "half", "unknown", {2, 1, 1}, {70, 67, 94}, 115707, 432, 0,
     1.01327896e-06f, 0.986328125f, 12888.76976698637,
     {{{4, 21, 39}, 2.20537186e-06f, 1}, {{29, 19, 45}, 0.0361938477f, 1}, {{11, 22, 75}, 0.0f, 0}}},
    {"half.none.vdb", "one", "half", "fog volume", {-3, 5, 7}, {-3, 5, 7}, 1, 1, 0, 0.5f, 0.5f, 0.5,
     {{{-3, 5, 7}, 0.5f, 1}, {{-3, 5, 6}, 0.0f, 0}, {{3, 5, 7}, 0.0f, 0}}},
};

static NphVolume read_grid(NphContext *context, const char *file, const char *grid) {
    NphVolume volume = {0};
    NphStatus status = nph_vdb_read(context, data_path(file), grid, &volume);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    return volume;
}

START_TEST(every_grid_holds_what_openvdb_says_of_it) {
    NphContext *context = nph_test_context(1);
    char file[128];
    snprintf(file, sizeof file, "vdb/%s", expected[_i].file);
    NphVolume volume = read_grid(context, file, expected[_i].grid);
    NphVolumeStatistics statistics;
    nph_volume_statistics(&volume, &statistics);
    ck_assert_str_eq(volume.name, expected[_i].grid);
    ck_assert_str_eq(volume.type, expected[_i].type);
    ck_assert_str_eq(volume.grid_class, expected[_i].grid_class);
    ck_assert(volume.background == 0);
    ck_assert_uint_eq(volume.active_voxels, expected[_i].active_voxels);
    ck_assert_int_eq(volume.leaf_count, expected[_i].leaves);
    ck_assert_int_eq(volume.tile_count, expected[_i].tiles);
    ck_assert_mem_eq(volume.bbox_min, expected[_i].bbox_min, sizeof volume.bbox_min);
    ck_assert_mem_eq(volume.bbox_max, expected[_i].bbox_max, sizeof volume.bbox_max);
    ck_assert(statistics.min == expected[_i].min);
    ck_assert(statistics.max == expected[_i].max);
    ck_assert_double_le(fabs(statistics.sum - expected[_i].sum), 1e-12 * fabs(expected[_i].sum));
    for (int i = 0; i < 3; i++) {
        int active = -1;
        ck_assert(nph_volume_value(&volume, expected[_i].probes[i].ijk, &active) == expected[_i].probes[i].value);
        ck_assert_int_eq(active, expected[_i].probes[i].active);
    }
    nph_volume_free(context, &volume);
    nph_test_context_close(context);
}
END_TEST

/* half: values of the .vdb are those of the .nvdb rounded to half. */
static void compare(const NphVolume *vdb, const NphVolume *nano, int half) {
    ck_assert_int_eq(vdb->leaf_count, nano->leaf_count);
    ck_assert_int_eq(vdb->tile_count, nano->tile_count);
    ck_assert_uint_eq(vdb->active_voxels, nano->active_voxels);
    ck_assert(vdb->background == nano->background);
    ck_assert_mem_eq(vdb->world_from_index, nano->world_from_index, sizeof vdb->world_from_index);
    ck_assert_mem_eq(vdb->bbox_min, nano->bbox_min, sizeof vdb->bbox_min);
    ck_assert_mem_eq(vdb->bbox_max, nano->bbox_max, sizeof vdb->bbox_max);
    if (vdb->tile_count) ck_assert_mem_eq(vdb->tiles, nano->tiles, (size_t)vdb->tile_count * sizeof *vdb->tiles);
    for (int64_t i = 0; i < vdb->leaf_count; i++) {
        const NphLeaf *a = &vdb->leaves[i], *b = &nano->leaves[i];
        ck_assert_mem_eq(a->origin, b->origin, sizeof a->origin);
        ck_assert_mem_eq(a->active, b->active, sizeof a->active);
        for (int n = 0; n < NPH_LEAF_VOXELS; n++)
            ck_assert(a->values[n] == (half ? nph_float_from_half(nph_half_from_float(b->values[n])) : b->values[n]));
    }
}

START_TEST(a_volume_equals_its_nanovdb_copy_voxel_for_voxel) {
    static const struct {
        const char *vdb, *nano, *grid, *nano_grid;
        int half;
    } pairs[] = {{"vdb/smoke_0024.vdb", "smoke/smoke_0024.none.nvdb", NULL, NULL, 0},
                 {"vdb/tiles.blosc.vdb", "tiles/tiles.zip.nvdb", "tiles", "tiles", 0},
                 {"vdb/tiles.active.vdb", "tiles/tiles.zip.nvdb", "tiles", "tiles", 0},
                 {"vdb/tiles.plainzip.vdb", "tiles/tiles.zip.nvdb", "tiles", "tiles", 0},
                 {"vdb/tiles.blosc.vdb", "tiles/tiles.zip.nvdb", "tiles_half", "tiles", 1},
                 {"vdb/tiles.active.vdb", "tiles/tiles.zip.nvdb", "tiles_half", "tiles", 1},
                 {"vdb/tiles.blosc.vdb", "tiles/tiles.zip.nvdb", "empty", "empty", 0}};
    NphContext *context = nph_test_context(1);
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++) {
        NphVolume vdb = read_grid(context, pairs[i].vdb, pairs[i].grid), nano = {0};
        ck_assert_int_eq(nph_nvdb_read(context, data_path(pairs[i].nano), pairs[i].nano_grid, &nano), NPH_OK);
        compare(&vdb, &nano, pairs[i].half);
        nph_volume_free(context, &vdb);
        nph_volume_free(context, &nano);
    }
    nph_test_context_close(context);
}
END_TEST

/* A level set, whose inactive values are the background outside and its negative inside: left out of one file, there in
 * the other. */
START_TEST(inactive_values_that_a_file_leaves_out_are_restored) {
    NphContext *context = nph_test_context(1);
    NphVolume without = read_grid(context, "vdb/tiles.active.vdb", "sphere");
    NphVolume with = read_grid(context, "vdb/tiles.plainzip.vdb", "sphere");
    int active;
    ck_assert(with.background == 2);
    ck_assert(nph_volume_value(&with, (int32_t[]){33, 34, 35}, &active) == -2);
    compare(&without, &with, 0);
    nph_volume_free(context, &without);
    nph_volume_free(context, &with);
    nph_test_context_close(context);
}
END_TEST

START_TEST(scales_and_translations_are_maps_too) {
    static const double map[12] = {0.5, 0, 0, 10, 0, 0.25, 0, -20, 0, 0, 2, 30.5};
    NphContext *context = nph_test_context(1);
    NphVolume volume = read_grid(context, "vdb/half.none.vdb", NULL);
    ck_assert_mem_eq(volume.world_from_index, map, sizeof map);
    nph_volume_free(context, &volume);
    nph_test_context_close(context);
}
END_TEST

static void refused(NphContext *context, const char *file, const char *grid, const char *word) {
    NphVolume volume = {.leaf_count = -7};
    ck_assert_int_eq(nph_vdb_read(context, data_path(file), grid, &volume), NPH_BAD_INPUT);
    ck_assert_int_eq(volume.leaf_count, -7);
    const char *messages = nph_test_messages();
    ck_assert_msg(strstr(messages, file) && strstr(messages, word), "no '%s' in: %s", word, messages);
}

START_TEST(a_grid_is_chosen_by_name_and_refused_with_the_list_of_names) {
    NphContext *context = nph_test_context(1);
    const char *plume = "vdb/plume32_f20_BLOSC_float32.vdb", *tiles = "vdb/tiles.blosc.vdb";
    NphVolume volume = read_grid(context, plume, NULL);
    ck_assert_str_eq(volume.name, "density");
    nph_volume_free(context, &volume);
    refused(context, plume, "smoke", "has no grid 'smoke'; it holds 'velocity' (vec3s), 'density' (float), "
                                     "'shadow' (float), 'temperature' (float), 'flame' (float)");
    refused(context, plume, "velocity", "type vec3s is not read");
    refused(context, plume, "Density", "has no grid 'Density'");
    refused(context, plume, "", "has no grid ''");
    refused(context, tiles, NULL, "has no grid 'density' (the default; choose one by name); it holds 'tiles' (float)");
    refused(context, tiles, "twin", "has 2 grids named 'twin'");
    refused(context, tiles, "double", "type double is not read");
    refused(context, tiles, "mask", "type mask is not read");
    refused(context, tiles, "frustum", "its transform is a frustum");
    refused(context, tiles, "instance", "shares the tree of another grid");
    refused(context, "smoke/smoke_0024.none.nvdb", NULL, "no OpenVDB file starts here");
    refused(context, "vdb/none", NULL, "cannot read");
    nph_test_context_close(context);
}
END_TEST

START_TEST(the_list_describes_every_grid) {
    NphContext *context = nph_test_context(1);
    NphGridInfo *grids = NULL;
    int count = 0;
    ck_assert_int_eq(nph_vdb_list(context, data_path("vdb/plume32_f20_BLOSC_float32.vdb"), &grids, &count), NPH_OK);
    ck_assert_int_eq(count, 5);
    ck_assert_str_eq(grids[0].name, "velocity");
    ck_assert_str_eq(grids[0].type, "vec3s");
    ck_assert_str_eq(grids[0].grid_class, "staggered");
    ck_assert_int_eq(grids[0].readable, 0);
    ck_assert_str_eq(grids[1].name, "density");
    ck_assert_str_eq(grids[1].codec, "blosc");
    ck_assert_int_eq(grids[1].readable, 1);
    ck_assert_uint_eq(grids[1].active_voxels, 2462);
    ck_assert_int_eq(grids[1].bbox_max[2], 17);
    for (int i = 0; i < 5; i++) ck_assert(grids[i].voxel_size[i % 3] == 0.125);
    nph_free(context, grids);
    ck_assert_int_eq(nph_vdb_list(context, data_path("vdb/tiles.blosc.vdb"), &grids, &count), NPH_OK);
    ck_assert_int_eq(count, 9);
    ck_assert_double_eq(grids[0].voxel_size[1], 1.125); /* edge (-0.5, 1, 0.125) */
    ck_assert_str_eq(grids[1].type, "half");
    ck_assert_int_eq(grids[7].readable, 0);
    nph_free(context, grids);
    nph_test_context_close(context);
}
END_TEST

/* ---- damage ---- */

typedef struct Sample {
    char *bytes;
    size_t size;
} Sample;

static Sample load(NphContext *context, const char *file) {
    Sample sample = {NULL, 0};
    ck_assert_int_eq(nph_file_read(context, data_path(file), &sample.bytes, &sample.size), NPH_OK);
    return sample;
}

/* Reads the first `size` bytes as a file; both functions must refuse it or find it sound. */
static NphStatus try_bytes(NphContext *context, const char *bytes, size_t size, const char *grid) {
    const char *path = nph_test_temporary("damaged.vdb");
    NphVolume volume = {0};
    NphGridInfo *grids = NULL;
    int count = 0;
    FILE *file = fopen(path, "wb");
    ck_assert_ptr_nonnull(file);
    ck_assert_uint_eq(fwrite(bytes, 1, size, file), size);
    ck_assert_int_eq(fclose(file), 0);
    NphStatus listed = nph_vdb_list(context, path, &grids, &count);
    NphStatus status = nph_vdb_read(context, path, grid, &volume);
    ck_assert(status == NPH_OK || status == NPH_BAD_INPUT);
    ck_assert(listed == NPH_OK || (listed == NPH_BAD_INPUT && status == NPH_BAD_INPUT));
    ck_assert(status == NPH_OK || strstr(nph_test_messages(), "damaged.vdb") != NULL);
    nph_free(context, grids);
    nph_volume_free(context, &volume);
    nph_test_messages();
    return status;
}

static const char *const damaged_files[][2] = {{"vdb/tiles.blosc.vdb", "tiles"}, {"vdb/tiles.active.vdb", "tiles_half"},
                                               {"vdb/tiles.plainzip.vdb", "tiles"}, {"vdb/half.none.vdb", "one"},
                                               {"vdb/smoke_0024.vdb", "density"}};

START_TEST(cut_files_are_refused) {
    NphContext *context = nph_test_context(1);
    Sample sample = load(context, damaged_files[_i][0]);
    for (size_t cut = 0; cut < sample.size; cut += cut < 1200 ? 7 : sample.size / 50)
        ck_assert_int_eq(try_bytes(context, sample.bytes, cut, damaged_files[_i][1]), NPH_BAD_INPUT);
    ck_assert_int_eq(try_bytes(context, sample.bytes, sample.size, damaged_files[_i][1]), NPH_OK);
    nph_free(context, sample.bytes);
    nph_test_context_close(context);
}
END_TEST

/* Half of the flips fall into the head, where names, places, metadata and transform are. */
START_TEST(flipped_bits_are_refused_or_read_soundly) {
    NphContext *context = nph_test_context(1);
    Sample sample = load(context, damaged_files[_i][0]);
    uint64_t state = 88172645463325252u + (uint64_t)_i;
    int refusals = 0;
    for (int i = 0; i < 120; i++) {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        size_t at = (size_t)(state >> 8) % (i % 2 ? sample.size : 1500);
        char flip = (char)(1 << (state & 7));
        sample.bytes[at] ^= flip;
        refusals += try_bytes(context, sample.bytes, sample.size, damaged_files[_i][1]) == NPH_BAD_INPUT;
        sample.bytes[at] ^= flip;
    }
    ck_assert_int_gt(refusals, 5);
    ck_assert_uint_lt(nph_context_peak_bytes(context), 4u << 20);
    nph_free(context, sample.bytes);
    nph_test_context_close(context);
}
END_TEST

/* A block that says it is not packed and longer than its buffer would be copied there by a reader that trusts it. */
START_TEST(block_sizes_that_would_overflow_a_buffer_are_refused) {
    static const int64_t lies[] = {-5000, -70000, INT64_MIN, INT64_MAX, -1, 1, 0x100000010};
    NphContext *context = nph_test_context(1);
    Sample sample = load(context, "vdb/smoke_0024.vdb");
    int blocks = 0;
    for (size_t at = 100; at + 24 < sample.size && blocks < 200; at++) {
        static const char head[] = {2, 1, 0x33, 4}; /* of a blosc block of floats, behind its size */
        if (memcmp(sample.bytes + at + 8, head, sizeof head) != 0) continue;
        char size[8];
        memcpy(size, sample.bytes + at, 8);
        memcpy(sample.bytes + at, &lies[blocks++ % 7], 8);
        ck_assert_int_eq(try_bytes(context, sample.bytes, sample.size, NULL), NPH_BAD_INPUT);
        memcpy(sample.bytes + at, size, 8);
    }
    ck_assert_int_gt(blocks, 50);
    nph_free(context, sample.bytes);
    nph_test_context_close(context);
}
END_TEST

START_TEST(too_little_memory_is_refused_and_nothing_leaks) {
    NphContext *counted = nph_test_context(1);
    NphVolume volume = read_grid(counted, "vdb/tiles.blosc.vdb", "tiles");
    uint64_t calls = nph_context_allocations(counted);
    nph_volume_free(counted, &volume);
    nph_test_context_close(counted);
    ck_assert_uint_gt(calls, 3);
    for (uint64_t fail = 1; fail <= calls; fail++) {
        NphSettings settings;
        NphContext *context = NULL;
        nph_settings_default(&settings);
        settings.threads = 1;
        settings.fail_allocation = fail;
        if (nph_context_open(&context, &settings) != NPH_OK) continue;
        NphStatus status = nph_vdb_read(context, data_path("vdb/tiles.blosc.vdb"), "tiles", &volume);
        ck_assert(status == NPH_NO_MEMORY || status == NPH_OK);
        if (status == NPH_OK) nph_volume_free(context, &volume);
        nph_test_context_close(context);
    }
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_loop_test(cases, every_grid_holds_what_openvdb_says_of_it, 0, (int)(sizeof expected / sizeof *expected));
    tcase_add_test(cases, a_volume_equals_its_nanovdb_copy_voxel_for_voxel);
    tcase_add_test(cases, inactive_values_that_a_file_leaves_out_are_restored);
    tcase_add_test(cases, scales_and_translations_are_maps_too);
    tcase_add_test(cases, a_grid_is_chosen_by_name_and_refused_with_the_list_of_names);
    tcase_add_test(cases, the_list_describes_every_grid);
    tcase_add_loop_test(cases, cut_files_are_refused, 0, (int)(sizeof damaged_files / sizeof *damaged_files));
    tcase_add_loop_test(cases, flipped_bits_are_refused_or_read_soundly, 0, (int)(sizeof damaged_files / sizeof *damaged_files));
    tcase_add_test(cases, block_sizes_that_would_overflow_a_buffer_are_refused);
    tcase_add_test(cases, too_little_memory_is_refused_and_nothing_leaks);
}

int main(void) { return nph_test_main("vdb", fill); }
