/* SPDX-License-Identifier: Apache-2.0
 *
 * Grids from sparse volumes. The oracle is the formula that a voxel's value was drawn from, so bricks that are not
 * aligned with leaves, aprons, tiles and sharing are checked sample by sample. */
#include "field_fixtures.h"

/* A volume over [0, leaves)^3 leaves, moved by `origin`: each leaf is absent, a leaf, a constant leaf or a tile of 8^3,
 * chosen by its hash. Within leaves some voxels are inactive and some active ones are 0. */
typedef struct Sparse {
    int32_t origin[3]; /* multiple of 8 */
    int leaves;
    int tiles_only;
} Sparse;

enum { ABSENT, LEAF, CONSTANT_LEAF, TILE, INACTIVE_TILE, KINDS };

static uint64_t hash3(const Sparse *sparse, int a, int b, int c) {
    uint64_t state = (uint64_t)(sparse->leaves * 1000003 + a * 10007 + b * 101 + c);
    random_bits(&state);
    return random_bits(&state);
}

static int kind(const Sparse *sparse, int lx, int ly, int lz) {
    static const int kinds[8] = {ABSENT, LEAF, CONSTANT_LEAF, CONSTANT_LEAF, TILE, TILE, INACTIVE_TILE, LEAF};
    return kinds[hash3(sparse, lx, ly, lz) % 8];
}

/* Value and activity of a voxel, counted from the origin. */
static float voxel(const Sparse *sparse, int x, int y, int z, int *active) {
    *active = 0;
    if (x < 0 || y < 0 || z < 0 || x >= 8 * sparse->leaves || y >= 8 * sparse->leaves || z >= 8 * sparse->leaves)
        return 0;
    switch (kind(sparse, x / 8, y / 8, z / 8)) {
    case LEAF: {
        uint64_t h = hash3(sparse, x + 1000, y, z);
        *active = h % 4 != 0;
        return *active && h % 8 != 1 ? 1 + (float)(h % 97) : 0;
    }
    case CONSTANT_LEAF:
    case TILE: *active = 1; return 2;
    default: return 0;
    }
}

static NphVolume make_volume(const Sparse *sparse) {
    NphVolume volume = {.background = 0, .world_from_index = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    int n = sparse->leaves;
    volume.leaves = calloc((size_t)(n * n * n), sizeof *volume.leaves);
    volume.tiles = calloc((size_t)(n * n * n), sizeof *volume.tiles);
    for (int lx = 0; lx < n; lx++)
        for (int ly = 0; ly < n; ly++)
            for (int lz = 0; lz < n; lz++) {
                int32_t origin[3] = {sparse->origin[0] + 8 * lx, sparse->origin[1] + 8 * ly,
                                     sparse->origin[2] + 8 * lz};
                int what = kind(sparse, lx, ly, lz);
                if (what == ABSENT) continue;
                if (what == TILE || what == INACTIVE_TILE) {
                    NphTile *tile = &volume.tiles[volume.tile_count++];
                    memcpy(tile->origin, origin, sizeof origin);
                    tile->size = 8;
                    tile->active = what == TILE;
                    tile->value = what == TILE ? 2 : 0;
                    continue;
                }
                NphLeaf *leaf = &volume.leaves[volume.leaf_count++];
                memcpy(leaf->origin, origin, sizeof origin);
                for (int i = 0; i < 512; i++) {
                    int active = 0;
                    leaf->values[i] =
                        voxel(sparse, 8 * lx + (i >> 6), 8 * ly + (i >> 3 & 7), 8 * lz + (i & 7), &active);
                    leaf->active[i >> 6] |= (uint64_t)active << (i & 63);
                }
            }
    return volume;
}

static void drop_volume(NphVolume *volume) {
    free(volume->leaves);
    free(volume->tiles);
}

static NphGrid build(NphContext *context, const NphVolume *volume, NphCentring centring) {
    NphGrid grid;
    NphStatus status = nph_grid_from_volume(context, volume, centring, NPH_LOOKUP_TRILINEAR, "volume", &grid);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    return grid;
}

/* Every sample of the grid against the formula; base: the voxel of sample 0, counted from the origin. */
static void compare(const NphGrid *grid, const Sparse *sparse, const int base[3]) {
    double sum = 0;
    int64_t nonzero = 0;
    for (int k = 0; k < grid->n[2]; k++)
        for (int j = 0; j < grid->n[1]; j++)
            for (int i = 0; i < grid->n[0]; i++) {
                int active;
                float expected = voxel(sparse, base[0] + i, base[1] + j, base[2] + k, &active);
                if (field_sample(grid, i, j, k) != expected)
                    ck_abort_msg("sample (%d, %d, %d) is %g, not %g", i, j, k, (double)field_sample(grid, i, j, k),
                                 (double)expected);
                sum += (double)expected;
                nonzero += expected != 0;
            }
    ck_assert_double_eq(grid->sum, sum); /* integers: exact */
    ck_assert_int_eq(grid->active, nonzero);
}

/* All eight corners of every lattice cell come from one brick: its apron holds the neighbours' samples. */
static void check_aprons(const NphGrid *grid) {
    int64_t wrong = 0;
    for (int bz = 0; bz < grid->bricks[2]; bz++)
        for (int by = 0; by < grid->bricks[1]; by++)
            for (int bx = 0; bx < grid->bricks[0]; bx++) {
                int64_t number = grid->brick_index[((int64_t)bz * grid->bricks[1] + by) * grid->bricks[0] + bx];
                for (int i = 0; i < 729; i++) {
                    int x = bx * 8 + i % 9, y = by * 8 + i / 9 % 9, z = bz * 8 + i / 81;
                    if (x >= grid->n[0] || y >= grid->n[1] || z >= grid->n[2]) continue;
                    wrong += grid->values[number * NPH_BRICK_STRIDE + i] != field_sample(grid, x, y, z);
                }
            }
    ck_assert_int_eq(wrong, 0);
}

START_TEST(every_voxel_arrives_whatever_the_alignment) {
    NphContext *context = nph_test_context(2);
    for (int leaves = 1; leaves <= 6; leaves++) {
        Sparse sparse = {.origin = {-24, 8 * leaves, -8 * leaves}, .leaves = leaves};
        NphVolume volume = make_volume(&sparse);
        int lo[3] = {1 << 20, 1 << 20, 1 << 20}, hi[3] = {-1, -1, -1}, any = 0;
        for (int i = 0; i < 512 * leaves * leaves * leaves; i++) {
            int edge = 8 * leaves, at[3] = {i / edge / edge, i / edge % edge, i % edge}, active;
            voxel(&sparse, at[0], at[1], at[2], &active);
            for (int a = 0; a < 3 && active; a++) {
                any = 1;
                lo[a] = at[a] < lo[a] ? at[a] : lo[a];
                hi[a] = at[a] > hi[a] ? at[a] : hi[a];
            }
        }
        if (any) {
            NphGrid grid = build(context, &volume, NPH_CENTRING_VDB);
            for (int a = 0; a < 3; a++) {
                ck_assert_int_eq(grid.n[a], hi[a] - lo[a] + 3);
                ck_assert_double_eq(grid.lo[a], 0);
                ck_assert_double_eq(grid.hi[a], grid.n[a] - 1);
                /* sample 0 stands one voxel below the first active one */
                ck_assert_double_eq(grid.world_from_lattice[4 * a + 3], sparse.origin[a] + lo[a] - 1);
            }
            compare(&grid, &sparse, (int[]){lo[0] - 1, lo[1] - 1, lo[2] - 1});
            check_aprons(&grid);
            nph_grid_free(context, &grid);
        }
        drop_volume(&volume);
    }
    nph_test_context_close(context);
}
END_TEST

/* One leaf whose only active voxels are the corners `a` and `b` of a box: all 8 phases of bricks against leaves. */
START_TEST(all_phases_of_leaves_against_bricks_hold) {
    NphContext *context = nph_test_context(1);
    for (int phase = 0; phase < 8; phase++) {
        NphLeaf leaves[4] = {
            {.origin = {-8, 0, 0}}, {.origin = {0, 0, 0}}, {.origin = {0, 0, 8}}, {.origin = {8, 8, 8}}};
        NphVolume volume = {
            .leaf_count = 4, .leaves = leaves, .world_from_index = {2, 0, 0, 1, 0, 3, 0, 1, 0, 0, 4, 1}};
        leaves[0].active[phase] = 1; /* (phase - 8, 0, 0) opens the box */
        leaves[0].values[64 * phase] = 1;
        for (int l = 1; l < 4; l++)
            for (int i = 0; i < 512; i++) {
                leaves[l].values[i] = (float)(1 + l * 512 + i);
                leaves[l].active[i >> 6] |= (uint64_t)1 << (i & 63);
            }
        NphGrid grid = build(context, &volume, NPH_CENTRING_VDB);
        int wrong = 0;
        ck_assert_int_eq(grid.n[0], 16 - (phase - 8) + 2);
        for (int l = 1; l < 4; l++)
            for (int i = 0; i < 512; i++) {
                int x = leaves[l].origin[0] + (i >> 6) - (phase - 8) + 1, y = leaves[l].origin[1] + (i >> 3 & 7) + 1;
                int z = leaves[l].origin[2] + (i & 7) + 1;
                wrong += field_sample(&grid, x, y, z) != leaves[l].values[i];
            }
        ck_assert_int_eq(wrong, 0);
        check_aprons(&grid);
        ck_assert_double_eq(grid.world_from_lattice[3], 1 + 2 * (phase - 8 - 1));
        ck_assert_double_eq(grid.world_from_lattice[7], 1 + 3 * -1);
        nph_grid_free(context, &grid);
    }
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_linear_ramp_is_exact_at_world_positions_under_any_affine_map) {
    NphContext *context = nph_test_context(1);
    NphLeaf leaf = {.origin = {-16, 40, 8}};
    /* world = M (i, j, k) + t, sheared and rotated; density = 30 + i + 2 j - 3 k at lattice points */
    NphVolume volume = {
        .leaf_count = 1, .leaves = &leaf, .world_from_index = {0.5, 0.1, 0, 7, -0.2, 0.25, 0.3, -1000, 0, 0.1, 2, 5}};
    for (int i = 0; i < 512; i++) {
        leaf.values[i] = (float)(30 + (i >> 6) + 2 * (i >> 3 & 7) - 3 * (i & 7));
        leaf.active[i >> 6] |= (uint64_t)1 << (i & 63);
    }
    static const NphCentring centrings[] = {NPH_CENTRING_CELL, NPH_CENTRING_POINT, NPH_CENTRING_VDB};
    for (int c = 0; c < 3; c++) {
        NphGrid grid = build(context, &volume, centrings[c]);
        uint64_t state = 5;
        for (int sample = 0; sample < 300; sample++) {
            double local[3], lattice[3], world[3], expected[3];
            for (int a = 0; a < 3; a++) {
                local[a] = 7 * random_unit(&state);
                lattice[a] = local[a] + 1;
            }
            const double *m = volume.world_from_index, *w = grid.world_from_lattice;
            for (int a = 0; a < 3; a++) {
                expected[a] = m[4 * a] * (local[0] - 16) + m[4 * a + 1] * (local[1] + 40) +
                              m[4 * a + 2] * (local[2] + 8) + m[4 * a + 3];
                world[a] = w[4 * a] * lattice[0] + w[4 * a + 1] * lattice[1] + w[4 * a + 2] * lattice[2] + w[4 * a + 3];
                ck_assert_double_eq_tol(world[a], expected[a], 1e-11);
            }
            ck_assert_double_eq_tol(field_at64(context, &grid, lattice[0], lattice[1], lattice[2]),
                                    30 + local[0] + 2 * local[1] - 3 * local[2], 1e-12);
        }
        double inset = c == 0 ? 0.5 : c == 1 ? 1 : 0;
        for (int a = 0; a < 3; a++) {
            ck_assert_double_eq(grid.lo[a], inset);
            ck_assert_double_eq(grid.hi[a], 9 - inset);
        }
        nph_grid_free(context, &grid);
    }
    nph_test_context_close(context);
}
END_TEST

START_TEST(the_inside_of_a_large_tile_is_one_brick) {
    NphContext *context = nph_test_context(1);
    NphTile tiles[8];
    for (int i = 0; i < 8; i++)
        tiles[i] = (NphTile){.origin = {-128 + 128 * (i >> 2), -128 + 128 * (i >> 1 & 1), 128 * (i & 1)},
                             .size = 128,
                             .value = 0.5f,
                             .active = 1};
    NphVolume volume = {.tile_count = 8, .tiles = tiles, .world_from_index = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    NphGrid grid = build(context, &volume, NPH_CENTRING_VDB);
    /* 258 samples: bricks 1 to 31 of 33 lie inside along each axis, the joints between the tiles too */
    ck_assert_int_eq(grid.n[0], 258);
    ck_assert_int_eq(grid.brick_count, 2 + 33 * 33 * 33 - 31 * 31 * 31);
    ck_assert_double_eq(grid.sum, 0.5 * 256 * 256 * 256);
    ck_assert_int_eq(grid.active, 256 * 256 * 256);
    check_aprons(&grid);
    ck_assert_float_eq(field_sample(&grid, 129, 128, 129), 0.5f);
    ck_assert_float_eq(field_sample(&grid, 256, 256, 256), 0.5f);
    ck_assert_float_eq(field_sample(&grid, 257, 256, 256), 0);
    nph_grid_free(context, &grid);
    tiles[7].value = 0.25f; /* bricks over the joints to it now differ */
    grid = build(context, &volume, NPH_CENTRING_VDB);
    ck_assert_float_eq(field_sample(&grid, 128, 200, 200), 0.5f);
    ck_assert_float_eq(field_sample(&grid, 129, 200, 200), 0.25f);
    ck_assert_double_eq(grid.sum, 7.5 / 8 * 0.5 * 256 * 256 * 256);
    check_aprons(&grid);
    nph_grid_free(context, &grid);
    nph_test_context_close(context);
}
END_TEST

static void refuse(NphContext *context, const NphVolume *volume, const char *word) {
    NphGrid grid, untouched;
    memset(&grid, 0x5a, sizeof grid);
    untouched = grid;
    NphStatus status = nph_grid_from_volume(context, volume, NPH_CENTRING_VDB, NPH_LOOKUP_TRILINEAR, "a.nvdb", &grid);
    const char *messages = nph_test_messages();
    ck_assert_int_eq(status, NPH_BAD_INPUT);
    ck_assert_msg(strstr(messages, word) && strstr(messages, "a.nvdb"), "%s", messages);
    ck_assert_int_eq(memcmp(&grid, &untouched, sizeof grid), 0);
}

START_TEST(huge_boxes_are_refused_before_they_take_memory) {
    NphContext *context = nph_test_context(1);
    NphTile tiles[2] = {{.origin = {0, 0, 0}, .size = 4096, .value = 1, .active = 1},
                        {.origin = {2147483640, 0, 0}, .size = 8, .value = 1, .active = 1}};
    NphVolume volume = {.tile_count = 1, .tiles = tiles, .world_from_index = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    refuse(context, &volume, "4096 x 4096 x 4096 voxels is too large");
    volume.tile_count = 2;
    refuse(context, &volume, "2147483648 voxels along x");
    tiles[0].origin[0] = -2147483647 - 1;
    refuse(context, &volume, "4294967296 voxels along x");
    ck_assert_uint_eq(nph_context_peak_bytes(context), 0);
    nph_test_context_close(context);
}
END_TEST

START_TEST(bad_voxels_tiles_and_backgrounds_are_named) {
    NphContext *context = nph_test_context(2);
    static NphLeaf leaves[2];
    memset(leaves, 0, sizeof leaves);
    leaves[1].origin[0] = 8;
    leaves[0].active[0] = 1;
    NphTile tile = {.origin = {-128, 0, 0}, .size = 128, .value = NAN, .active = 1};
    NphVolume volume = {
        .leaf_count = 2, .leaves = leaves, .tiles = &tile, .world_from_index = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    static const float bad[] = {NAN, HUGE_VALF, -HUGE_VALF, -1, -1e-45f, 1.1e38f, 3e38f};
    for (int i = 0; i < 7; i++) {
        leaves[1].values[64 * 5 + 8 * 3 + 7] = bad[i];
        leaves[1].active[5] = (uint64_t)1 << (8 * 3 + 7);
        refuse(context, &volume, "voxel (13, 3, 7)");
    }
    leaves[1].values[64 * 5 + 8 * 3 + 7] = 1e38f;
    volume.tile_count = 1;
    refuse(context, &volume, "tile of 128^3 voxels from (-128, 0, 0)");
    tile.active = 0;
    leaves[0].values[9] = -3; /* inactive */
    NphGrid grid = build(context, &volume, NPH_CENTRING_VDB);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "2 inactive voxels or tiles"));
    ck_assert_int_eq(grid.n[0], 13 + 3);
    ck_assert_int_eq(grid.active, 1);
    ck_assert_double_eq(grid.sum, (double)1e38f);
    nph_grid_free(context, &grid);
    volume.background = 0.3f;
    refuse(context, &volume, "background is 0.3");
    volume.background = NAN;
    refuse(context, &volume, "background is");
    volume.background = 0;
    volume.world_from_index[5] = 0;
    refuse(context, &volume, "singular");
    volume.world_from_index[5] = HUGE_VAL;
    refuse(context, &volume, "not finite");
    volume.world_from_index[5] = 1;
    leaves[1].origin[0] = 0;
    refuse(context, &volume, "leaf 1 at (0, 0, 0)");
    leaves[1].origin[0] = 9;
    refuse(context, &volume, "leaf 1 at (9, 0, 0)");
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_volume_without_active_voxels_is_one_zero) {
    NphContext *context = nph_test_context(1);
    NphTile tile = {.origin = {0, 0, 0}, .size = 4096, .value = 0, .active = 0};
    NphVolume volume = {.tile_count = 1, .tiles = &tile, .world_from_index = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    NphGrid grid = build(context, &volume, NPH_CENTRING_VDB);
    ck_assert_int_eq(grid.n[0], 3);
    ck_assert_int_eq(grid.brick_count, 1);
    ck_assert_double_eq(grid.sum, 0);
    ck_assert_float_eq(grid.min, 0);
    ck_assert_float_eq(grid.max, 0);
    ck_assert_float_eq(grid.majorant.cells[0], -1);
    ck_assert_double_eq(field_at64(context, &grid, 1, 1, 1), 0);
    nph_grid_free(context, &grid);
    nph_test_context_close(context);
}
END_TEST

static NphStatus build_once(NphContext *context, void *data, NphGrid *grid) {
    return nph_grid_from_volume(context, data, NPH_CENTRING_VDB, NPH_LOOKUP_TRILINEAR, "volume", grid);
}

START_TEST(failing_allocations_leak_nothing_and_threads_do_not_show) {
    Sparse sparse = {.leaves = 6};
    NphVolume volume = make_volume(&sparse);
    field_fail_every_allocation(build_once, &volume);
    NphContext *one = nph_test_context(1), *three = nph_test_context(3);
    NphGrid a = build(one, &volume, NPH_CENTRING_VDB), b = build(three, &volume, NPH_CENTRING_VDB);
    ck_assert(field_same(&a, &b));
    nph_grid_free(one, &a);
    nph_grid_free(three, &b);
    nph_test_context_close(one);
    nph_test_context_close(three);
    drop_volume(&volume);
}
END_TEST

static double hashed(int x, int y, int z, void *user) {
    int active;
    return (double)voxel(user, x, y, z, &active);
}

START_TEST(a_volume_and_the_same_voxels_in_an_array_give_the_same_grid) {
    NphContext *context = nph_test_context(1);
    Sparse sparse = {.leaves = 6};
    NphVolume volume = make_volume(&sparse);
    NphArray array = field_array(context, (int[]){48, 48, 48}, hashed, &sparse);
    NphGrid a = build(context, &volume, NPH_CENTRING_VDB), b;
    ck_assert_int_eq(a.n[0] + 1000 * a.n[1] + 1000000 * a.n[2], 50050050);
    ck_assert_int_eq(nph_grid_from_array(context, &array, (double[]){0, 0, 0}, (double[]){47, 47, 47}, NPH_CENTRING_VDB,
                                         NPH_OUTSIDE_ZERO, NPH_LOOKUP_TRILINEAR, "array", &b),
                     NPH_OK);
    ck_assert(field_same(&a, &b));
    ck_assert_int_eq(memcmp(a.world_from_lattice, b.world_from_lattice, sizeof a.world_from_lattice), 0);
    nph_grid_free(context, &a);
    nph_grid_free(context, &b);
    nph_array_free(context, &array);
    drop_volume(&volume);
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, every_voxel_arrives_whatever_the_alignment);
    tcase_add_test(cases, all_phases_of_leaves_against_bricks_hold);
    tcase_add_test(cases, a_linear_ramp_is_exact_at_world_positions_under_any_affine_map);
    tcase_add_test(cases, the_inside_of_a_large_tile_is_one_brick);
    tcase_add_test(cases, huge_boxes_are_refused_before_they_take_memory);
    tcase_add_test(cases, bad_voxels_tiles_and_backgrounds_are_named);
    tcase_add_test(cases, a_volume_without_active_voxels_is_one_zero);
    tcase_add_test(cases, failing_allocations_leak_nothing_and_threads_do_not_show);
    tcase_add_test(cases, a_volume_and_the_same_voxels_in_an_array_give_the_same_grid);
}

int main(void) { return nph_test_main("grid_volume", fill); }
