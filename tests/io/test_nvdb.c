/* SPDX-License-Identifier: Apache-2.0
 *
 * NanoVDB volumes against what OpenVDB says they hold: topology, values, map, names, in every codec and every type that
 * is read. Damaged files are in test_nvdb_hostile.c. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "harness.h"
#include "io/volume.h"
#include "volumes_table.h"

static const char *data_path(const char *file) {
    char relative[256];
    snprintf(relative, sizeof relative, "reference/data/%s", file);
    return nph_test_path(relative);
}

static NphVolume read_grid(NphContext *context, const char *file, const char *grid) {
    NphVolume volume = {0};
    NphStatus status = nph_nvdb_read(context, data_path(file), grid, &volume);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    return volume;
}

static int is_exact(const ExpectedVolume *expected) { return strcmp(expected->type, "float") == 0; }

static int leaf_index(const int32_t ijk[3]) { return (ijk[0] & 7) << 6 | (ijk[1] & 7) << 3 | (ijk[2] & 7); }

START_TEST(every_grid_holds_what_openvdb_says_of_it) {
    NphContext *context = nph_test_context(1);
    const ExpectedVolume *expected = &expected_volumes[_i];
    NphVolume volume = read_grid(context, expected->file, expected->grid);
    NphVolumeStatistics statistics;
    nph_volume_statistics(&volume, &statistics);
    ck_assert_str_eq(volume.name, expected->grid);
    ck_assert_str_eq(volume.type, expected->type);
    ck_assert_str_eq(volume.grid_class, expected->grid_class);
    ck_assert(volume.background == expected->background);
    ck_assert_uint_eq(volume.active_voxels, expected->active_voxels);
    ck_assert_int_eq(volume.leaf_count, expected->leaves);
    ck_assert_int_eq(volume.tile_count, expected->tiles);
    ck_assert_mem_eq(volume.bbox_min, expected->bbox_min, sizeof volume.bbox_min);
    ck_assert_mem_eq(volume.bbox_max, expected->bbox_max, sizeof volume.bbox_max);
    ck_assert_uint_eq(statistics.not_finite, 0);
    if (is_exact(expected)) {
        ck_assert(statistics.min == expected->min);
        ck_assert(statistics.max == expected->max);
        /* the expected sum was added up without compensation */
        ck_assert_double_le(fabs(statistics.sum - expected->sum), 1e-13 * fabs(expected->sum));
        if (volume.active_voxels)
            ck_assert_double_eq_tol(statistics.mean, expected->sum / (double)expected->active_voxels, 1e-12);
    }
    for (int i = 0; i < expected->probe_count; i++) {
        const Probe *probe = &expected->probes[i];
        int active = -1;
        float value = nph_volume_value(&volume, probe->ijk, &active);
        ck_assert_int_eq(active, probe->active);
        if (is_exact(expected)) ck_assert(value == probe->value);
    }
    nph_volume_free(context, &volume);
    nph_test_context_close(context);
}
END_TEST

START_TEST(all_codecs_give_the_same_volume) {
    NphContext *context = nph_test_context(1);
    static const char *const files[] = {"smoke/smoke_0024.none.nvdb", "smoke/smoke_0024.zip.nvdb",
                                        "smoke/smoke_0024.blosc.nvdb"};
    NphVolume first = read_grid(context, files[0], NULL);
    for (int i = 1; i < 3; i++) {
        NphVolume other = read_grid(context, files[i], NULL);
        ck_assert_int_eq(other.leaf_count, first.leaf_count);
        ck_assert_mem_eq(other.leaves, first.leaves, (size_t)first.leaf_count * sizeof *first.leaves);
        ck_assert_mem_eq(other.world_from_index, first.world_from_index, sizeof first.world_from_index);
        nph_volume_free(context, &other);
    }
    nph_volume_free(context, &first);
    nph_test_context_close(context);
}
END_TEST

/* Largest |a - b| over a leaf and the range of a. */
static float largest_difference(const NphLeaf *a, const NphLeaf *b, float *range) {
    float difference = 0, lo = a->values[0], hi = a->values[0];
    for (int i = 0; i < NPH_LEAF_VOXELS; i++) {
        lo = fminf(lo, a->values[i]);
        hi = fmaxf(hi, a->values[i]);
        difference = fmaxf(difference, fabsf(a->values[i] - b->values[i]));
    }
    *range = hi - lo;
    return difference;
}

static void compare_quantised(const NphVolume *original, const NphVolume *quantised, double step, double tolerance) {
    ck_assert_int_eq(quantised->leaf_count, original->leaf_count);
    int differ = 0;
    for (int64_t i = 0; i < original->leaf_count; i++) {
        const NphLeaf *a = &original->leaves[i], *b = &quantised->leaves[i];
        ck_assert_mem_eq(a->origin, b->origin, sizeof a->origin);
        ck_assert_mem_eq(a->active, b->active, sizeof a->active);
        float range, difference = largest_difference(a, b, &range);
        double allowed = tolerance > 0 ? tolerance : 0.5 * step * (double)range;
        allowed += 4e-7 * ((double)range + fabs((double)a->values[0])); /* rounding of range, quantum and value */
        ck_assert_msg((double)difference <= allowed, "leaf %d: off by %g, allowed %g", (int)i, (double)difference,
                      allowed);
        differ += difference > 0;
    }
    ck_assert_int_gt(differ, 0);
}

/* Fp4, Fp8, Fp16 round to the nearest of 2^bits values across the leaf's range. FpN takes as many bits as a tolerance
 * asks for, by NanoVDB's default 0.01 for fog volumes; for other classes 0, so that it takes 16 bits or is exact. */
START_TEST(quantised_values_lie_within_half_a_step_of_their_leaf) {
    NphContext *context = nph_test_context(1);
    static const char *const smoke[] = {"smoke/smoke_0048.fp4.nvdb", "smoke/smoke_0048.fp8.nvdb",
                                        "smoke/smoke_0048.fp16.nvdb", "smoke/smoke_0048.fpN.nvdb"};
    static const char *const tiles[] = {"tiles_fp4", "tiles_fp8", "tiles_fp16", "tiles_fpn"};
    static const double steps[] = {1 / 15.0, 1 / 255.0, 1 / 65535.0, 1 / 65535.0};
    NphVolume plume = read_grid(context, "smoke/fluid_data_0048.allgrids.blosc.nvdb", "density");
    NphVolume shapes = read_grid(context, "tiles/tiles.zip.nvdb", "tiles");
    for (int i = 0; i < 4; i++) {
        NphVolume quantised = read_grid(context, smoke[i], NULL);
        compare_quantised(&plume, &quantised, steps[i], i == 3 ? 0.01 : 0);
        nph_volume_free(context, &quantised);
        quantised = read_grid(context, "tiles/tiles.zip.nvdb", tiles[i]);
        compare_quantised(&shapes, &quantised, steps[i], 0);
        ck_assert_int_eq(quantised.tile_count, shapes.tile_count);
        ck_assert_mem_eq(quantised.tiles, shapes.tiles, (size_t)shapes.tile_count * sizeof *shapes.tiles);
        nph_volume_free(context, &quantised);
    }
    nph_volume_free(context, &plume);
    nph_volume_free(context, &shapes);
    nph_test_context_close(context);
}
END_TEST

static int below(const int32_t a[3], const int32_t b[3]) {
    for (int axis = 0; axis < 3; axis++)
        if (a[axis] != b[axis]) return a[axis] < b[axis];
    return 0;
}

START_TEST(leaves_and_tiles_are_sorted_and_lookup_finds_each) {
    NphContext *context = nph_test_context(1);
    NphVolume volume = read_grid(context, "cumulus/cumulus_300.zip.nvdb", NULL);
    int active;
    for (int64_t i = 0; i < volume.leaf_count; i++) {
        const NphLeaf *leaf = &volume.leaves[i];
        if (i) ck_assert(below(volume.leaves[i - 1].origin, leaf->origin));
        int n = (int)(i * 37 % NPH_LEAF_VOXELS);
        int32_t ijk[3] = {leaf->origin[0] + (n >> 6), leaf->origin[1] + (n >> 3 & 7), leaf->origin[2] + (n & 7)};
        ck_assert_int_eq(leaf_index(ijk), n);
        ck_assert(nph_volume_value(&volume, ijk, &active) == leaf->values[n]);
        ck_assert_int_eq(active, (int)(leaf->active[n >> 6] >> (n & 63) & 1));
    }
    for (int64_t i = 0; i < volume.tile_count; i++) {
        const NphTile *tile = &volume.tiles[i];
        if (i) ck_assert(below(volume.tiles[i - 1].origin, tile->origin));
        int32_t last[3];
        for (int axis = 0; axis < 3; axis++) last[axis] = tile->origin[axis] + tile->size - 1;
        ck_assert(nph_volume_value(&volume, last, &active) == tile->value);
        ck_assert_int_eq(active, tile->active);
    }
    nph_volume_free(context, &volume);
    nph_test_context_close(context);
}
END_TEST

/* Positions that OpenVDB computes for the same lattice points: rows and columns are not swapped. */
START_TEST(the_map_takes_lattice_points_where_openvdb_takes_them) {
    static const double expected[][6] = {{0, 0, 0, 10, -20, 30.5},      {1, 0, 0, 10.5, -19.75, 30.5},
                                         {0, 1, 0, 9.5, -19, 30.625},   {0, 0, 1, 10, -19.9375, 32.5},
                                         {-3, 5, -7, 6, -16.1875, 17.125}};
    NphContext *context = nph_test_context(1);
    NphVolume volume = read_grid(context, "tiles/tiles.zip.nvdb", "tiles_fp4");
    const double *m = volume.world_from_index;
    for (int i = 0; i < 5; i++)
        for (int row = 0; row < 3; row++) {
            const double *p = expected[i];
            double at = m[row * 4] * p[0] + m[row * 4 + 1] * p[1] + m[row * 4 + 2] * p[2] + m[row * 4 + 3];
            ck_assert_double_eq(at, p[3 + row]);
        }
    nph_volume_free(context, &volume);
    nph_test_context_close(context);
}
END_TEST

static void refused(NphContext *context, const char *file, const char *grid, const char *word) {
    NphVolume volume = {.leaf_count = -7};
    ck_assert_int_eq(nph_nvdb_read(context, data_path(file), grid, &volume), NPH_BAD_INPUT);
    ck_assert_int_eq(volume.leaf_count, -7);
    const char *messages = nph_test_messages();
    ck_assert_msg(strstr(messages, file) && strstr(messages, word), "no '%s' in: %s", word, messages);
}

START_TEST(a_grid_is_chosen_by_name_and_refused_with_the_list_of_names) {
    NphContext *context = nph_test_context(1);
    const char *all = "smoke/fluid_data_0048.allgrids.blosc.nvdb", *tiles = "tiles/tiles.zip.nvdb";
    NphVolume volume = read_grid(context, all, NULL);
    ck_assert_str_eq(volume.name, "density");
    nph_volume_free(context, &volume);
    refused(context, all, "smoke", "has no grid 'smoke'; it holds 'density' (float), 'flame' (float), "
                                   "'shadow' (float), 'temperature' (float), 'velocity' (vec3f)");
    refused(context, all, "velocity", "type vec3f is not read");
    refused(context, all, "Density", "has no grid 'Density'");
    refused(context, all, "", "has no grid ''");
    refused(context, tiles, "double", "type double is not read");
    refused(context, tiles, "mask", "type mask is not read");
    refused(context, tiles, NULL, "has no grid 'density' (the default; choose one by name); it holds 'tiles' (float)");
    nph_test_context_close(context);
}
END_TEST

START_TEST(the_list_describes_every_grid_without_decoding) {
    static const struct {
        const char *name, *type, *grid_class;
        int readable;
        uint64_t active, file_bytes;
    } expected[] = {{"density", "float", "fog volume", 1, 115707, 537711},
                    {"flame", "float", "fog volume", 1, 0, 342},
                    {"shadow", "float", "fog volume", 1, 497664, 1726},
                    {"temperature", "float", "fog volume", 1, 115427, 535634},
                    {"velocity", "vec3f", "staggered", 0, 115675, 1457534}};
    NphContext *context = nph_test_context(1);
    NphGridInfo *grids = NULL;
    int count = 0;
    const char *path = data_path("smoke/fluid_data_0048.allgrids.blosc.nvdb");
    ck_assert_int_eq(nph_nvdb_list(context, path, &grids, &count), NPH_OK);
    ck_assert_int_eq(count, 5);
    for (int i = 0; i < 5; i++) {
        ck_assert_str_eq(grids[i].name, expected[i].name);
        ck_assert_str_eq(grids[i].type, expected[i].type);
        ck_assert_str_eq(grids[i].grid_class, expected[i].grid_class);
        ck_assert_str_eq(grids[i].codec, "blosc");
        ck_assert_int_eq(grids[i].readable, expected[i].readable);
        ck_assert_uint_eq(grids[i].active_voxels, expected[i].active);
        ck_assert_uint_eq(grids[i].file_bytes, expected[i].file_bytes);
        for (int axis = 0; axis < 3; axis++) ck_assert_double_eq_tol(grids[i].voxel_size[axis], 1 / 24.0, 1e-8);
    }
    ck_assert_int_eq(grids[0].bbox_min[0], 2);
    ck_assert_int_eq(grids[0].bbox_max[2], 94);
    ck_assert_int_gt(grids[1].bbox_min[0], grids[1].bbox_max[0]); /* empty */
    ck_assert_uint_eq(grids[2].grid_bytes, 305088);
    nph_free(context, grids);
    nph_test_context_close(context);
}
END_TEST

/* 1e16 + 1 - 1e16, in that order, is 0 without compensation; not-a-number and infinity are counted and left out. */
START_TEST(the_sum_is_compensated_and_what_is_not_finite_is_counted) {
    NphLeaf *leaf = calloc(1, sizeof *leaf);
    NphTile tiles[2] = {{.size = 8, .value = 0.5f, .active = 1},
                        {.origin = {8, 0, 0}, .size = 128, .value = 7, .active = 0}};
    static const float values[] = {1e16f, 1.0f, -1e16f, NAN, INFINITY, -3.0f};
    for (int i = 0; i < 6; i++) {
        leaf->values[i] = values[i];
        leaf->active[0] |= (uint64_t)1 << i;
    }
    leaf->values[100] = 1e30f; /* inactive */
    NphVolume volume = {.leaf_count = 1, .leaves = leaf, .tile_count = 2, .tiles = tiles, .active_voxels = 6 + 512};
    NphVolumeStatistics statistics;
    nph_volume_statistics(&volume, &statistics);
    ck_assert_uint_eq(statistics.not_finite, 2);
    ck_assert(statistics.min == -1e16f);
    ck_assert(statistics.max == 1e16f);
    ck_assert_double_eq(statistics.sum, 256.0 - 2.0);
    ck_assert_double_eq(statistics.mean, 254.0 / 516.0);
    free(leaf);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_loop_test(cases, every_grid_holds_what_openvdb_says_of_it, 0, EXPECTED_VOLUMES);
    tcase_add_test(cases, all_codecs_give_the_same_volume);
    tcase_add_test(cases, quantised_values_lie_within_half_a_step_of_their_leaf);
    tcase_add_test(cases, leaves_and_tiles_are_sorted_and_lookup_finds_each);
    tcase_add_test(cases, the_map_takes_lattice_points_where_openvdb_takes_them);
    tcase_add_test(cases, a_grid_is_chosen_by_name_and_refused_with_the_list_of_names);
    tcase_add_test(cases, the_list_describes_every_grid_without_decoding);
    tcase_add_test(cases, the_sum_is_compensated_and_what_is_not_finite_is_counted);
}

int main(void) { return nph_test_main("nvdb", fill); }
