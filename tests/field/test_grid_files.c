/* SPDX-License-Identifier: Apache-2.0
 *
 * Grids of the volumes in reference/data: every sample against a search in the volume, and the recorded totals. */
#include "field_fixtures.h"

static NphVolume read_volume(NphContext *context, const char *name) {
    NphVolume volume;
    NphStatus status = nph_nvdb_read(context, nph_test_path(name), NULL, &volume);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    return volume;
}

/* Samples that differ from what the volume holds there, and the sum of all of them. */
static int64_t differences(const NphGrid *grid, const NphVolume *volume, double *sum) {
    int64_t wrong = 0;
    *sum = 0;
    for (int k = 0; k < grid->n[2]; k++)
        for (int j = 0; j < grid->n[1]; j++)
            for (int i = 0; i < grid->n[0]; i++) {
                int32_t at[3] = {volume->bbox_min[0] + i - 1, volume->bbox_min[1] + j - 1, volume->bbox_min[2] + k - 1};
                int active;
                float value = nph_volume_value(volume, at, &active);
                wrong += field_sample(grid, i, j, k) != (active ? value : 0);
                *sum += active ? (double)value : 0;
            }
    return wrong;
}

/* Recorded with OpenVDB and numpy, apart from this project; a depth of 0 was not recorded. */
static void check(const char *name, double sum, double depth_z) {
    NphContext *context = nph_test_context(2);
    NphVolume volume = read_volume(context, name);
    NphGrid grid;
    NphGridStatistics statistics;
    double found;
    ck_assert_int_eq(nph_grid_from_volume(context, &volume, NPH_CENTRING_VDB, NPH_LOOKUP_TRILINEAR, name, &grid),
                     NPH_OK);
    ck_assert_str_eq(nph_test_messages(), ""); /* nothing inactive holds anything */
    for (int a = 0; a < 3; a++) ck_assert_int_eq(grid.n[a], volume.bbox_max[a] - volume.bbox_min[a] + 3);
    ck_assert_int_eq(differences(&grid, &volume, &found), 0);
    ck_assert_double_eq_tol(grid.sum / found, 1, 1e-12);
    ck_assert_double_eq_tol(grid.sum / sum, 1, 1e-12);
    ck_assert_int_eq(nph_grid_statistics(context, &grid, &statistics), NPH_OK);
    if (depth_z > 0) ck_assert_double_eq_tol(statistics.axis_depth_max[2], depth_z, 0.0005);
    nph_grid_free(context, &grid);
    nph_volume_free(context, &volume);
    nph_test_context_close(context);
}

START_TEST(cumulus_has_its_recorded_sum_and_depth) {
    check("reference/data/cumulus/cumulus_300.zip.nvdb", 1453017.8136697018, 1.327);
}
END_TEST

START_TEST(smoke_has_its_recorded_sum) { check("reference/data/smoke/smoke_0024.none.nvdb", 8109.623942371397, 0); }
END_TEST

START_TEST(a_grid_with_a_background_is_refused_and_an_empty_one_is_zero) {
    NphContext *context = nph_test_context(1);
    NphVolume volume;
    NphGrid grid;
    const char *tiles = nph_test_path("reference/data/tiles/tiles.zip.nvdb");
    ck_assert_int_eq(nph_nvdb_read(context, tiles, "tiles", &volume), NPH_OK);
    ck_assert_int_eq(nph_grid_from_volume(context, &volume, NPH_CENTRING_VDB, NPH_LOOKUP_TRILINEAR, tiles, &grid),
                     NPH_BAD_INPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "background is 0.125"));
    volume.background = 0; /* then it is too large: it has active tiles of 4096^3 */
    ck_assert_int_eq(nph_grid_from_volume(context, &volume, NPH_CENTRING_VDB, NPH_LOOKUP_TRILINEAR, tiles, &grid),
                     NPH_BAD_INPUT);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "too large"));
    nph_volume_free(context, &volume);
    const char *smoke = nph_test_path("reference/data/smoke/fluid_data_0048.allgrids.blosc.nvdb");
    ck_assert_int_eq(nph_nvdb_read(context, smoke, "flame", &volume), NPH_OK);
    ck_assert_int_eq(nph_grid_from_volume(context, &volume, NPH_CENTRING_VDB, NPH_LOOKUP_TRILINEAR, smoke, &grid),
                     NPH_OK);
    ck_assert_int_eq(grid.active, 0);
    ck_assert_int_eq(grid.brick_count, 1);
    nph_grid_free(context, &grid);
    nph_volume_free(context, &volume);
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, cumulus_has_its_recorded_sum_and_depth);
    tcase_add_test(cases, smoke_has_its_recorded_sum);
    tcase_add_test(cases, a_grid_with_a_background_is_refused_and_an_empty_one_is_zero);
}

int main(void) { return nph_test_main("grid_files", fill); }
