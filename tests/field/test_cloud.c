/* SPDX-License-Identifier: Apache-2.0
 *
 * Water content and radius to extinction: the formula, what is refused, and the clouds of reference/data/gpl, whose
 * maxima, means and optical depths were computed apart, from the numbers in the files. */
#include "field/cloud.h"
#include "field_fixtures.h"

enum { NX = 4, NY = 3, NZ = 5 };

static NphLes make_les(NphContext *context) {
    NphLes les = {.spacing_m = {20, 25}};
    int64_t shape[3] = {NZ, NY, NX};
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 3, shape, "lwc", &les.lwc_g_per_m3), NPH_OK);
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 3, shape, "reff", &les.reff_um), NPH_OK);
    ck_assert_int_eq(nph_array_new(context, NPH_F64, 1, shape, "height", &les.height_m), NPH_OK);
    float *lwc = les.lwc_g_per_m3.data, *reff = les.reff_um.data;
    for (int i = 0; i < NX * NY * NZ; i++) {
        lwc[i] = i % 3 == 0 ? 0 : 0.01f * (float)i;
        reff[i] = i % 3 == 0 ? 0 : 5 + 0.25f * (float)i;
    }
    for (int k = 0; k < NZ; k++) ((double *)les.height_m.data)[k] = 440 + 40 * k;
    return les;
}

static void drop_les(NphContext *context, NphLes *les) {
    nph_array_free(context, &les->lwc_g_per_m3);
    nph_array_free(context, &les->reff_um);
    nph_array_free(context, &les->height_m);
}

START_TEST(extinction_is_one_and_a_half_water_over_radius_on_the_outermost_points) {
    NphContext *context = nph_test_context(1);
    NphLes les = make_les(context);
    NphArray sigma;
    double lo[3], hi[3];
    ck_assert_int_eq(nph_cloud_extinction(context, &les, "cloud", &sigma, lo, hi), NPH_OK);
    const float *lwc = les.lwc_g_per_m3.data, *reff = les.reff_um.data, *out = sigma.data;
    ck_assert_int_eq(sigma.type, NPH_F32);
    ck_assert_int_eq(sigma.shape[0] * 100 + sigma.shape[1] * 10 + sigma.shape[2], 534);
    for (int i = 0; i < NX * NY * NZ; i++) {
        /* geometric optics, Q = 2, water of 1e6 g/m3: 3 Q LWC / (4 rho r), r in m */
        double expected = lwc[i] > 0 ? 3 * 2.0 * (double)lwc[i] / (4 * 1e6 * ((double)reff[i] * 1e-6)) : 0;
        ck_assert_double_eq_tol((double)out[i], expected, 0x1p-24 * expected + 1e-18);
    }
    static const double box[2][3] = {{0, 0, 440}, {60, 50, 600}};
    for (int a = 0; a < 3; a++) {
        ck_assert_double_eq(lo[a], box[0][a]);
        ck_assert_double_eq(hi[a], box[1][a]);
    }
    nph_array_free(context, &sigma);
    drop_les(context, &les);
    nph_test_context_close(context);
}
END_TEST

static void refuse(NphContext *context, const NphLes *les, const char *word) {
    NphArray sigma = {.rank = 77};
    double lo[3] = {7, 7, 7}, hi[3] = {7, 7, 7};
    ck_assert_int_eq(nph_cloud_extinction(context, les, "rico.txt", &sigma, lo, hi), NPH_BAD_INPUT);
    const char *messages = nph_test_messages();
    ck_assert_msg(strstr(messages, word) && strstr(messages, "rico.txt"), "%s", messages);
    ck_assert_int_eq(sigma.rank, 77);
    ck_assert(lo[0] == 7 && hi[2] == 7);
}

START_TEST(points_and_levels_that_mean_nothing_are_named) {
    NphContext *context = nph_test_context(1);
    NphLes les = make_les(context);
    float *lwc = les.lwc_g_per_m3.data, *reff = les.reff_um.data;
    double *height = les.height_m.data;
    int at = (3 * NY + 1) * NX + 2; /* (2, 1, 3) */
    static const float bad[][2] = {{1, 0},   {-1, 5}, {NAN, 5},       {HUGE_VALF, 5},
                                   {1, NAN}, {1, -3}, {1, HUGE_VALF}, {1e38f, 1e-3f}};
    for (int i = 0; i < 8; i++) {
        lwc[at] = bad[i][0];
        reff[at] = bad[i][1];
        refuse(context, &les, "point (2, 1, 3)");
    }
    lwc[at] = 0; /* the radius of no water does not matter */
    reff[at] = NAN;
    NphArray sigma;
    double lo[3], hi[3];
    ck_assert_int_eq(nph_cloud_extinction(context, &les, "cloud", &sigma, lo, hi), NPH_OK);
    ck_assert_float_eq(((float *)sigma.data)[at], 0);
    nph_array_free(context, &sigma);
    height[2] += 1.9; /* within 5% of 40 m */
    ck_assert_int_eq(nph_cloud_extinction(context, &les, "cloud", &sigma, lo, hi), NPH_OK);
    nph_array_free(context, &sigma);
    height[2] += 0.2;
    refuse(context, &les, "level 2 is at");
    height[2] = NAN;
    refuse(context, &les, "level 2");
    height[2] = 520;
    height[0] = 700;
    refuse(context, &les, "do not rise");
    height[0] = 440;
    les.spacing_m[1] = 0;
    refuse(context, &les, "spacing along y");
    drop_les(context, &les);
    nph_test_context_close(context);
}
END_TEST

/* Per km, as recorded beside the files; NAN where nothing is recorded. The VDB centring integrates whole hats: a
 * column's depth is the sum of its points times the spacing, as it was recorded. */
static void check_cloud(const char *name, double max, double mean_in_cloud, double depth_mean, double depth_max) {
    NphContext *context = nph_test_context(2);
    NphLes les;
    NphArray sigma;
    double lo[3], hi[3];
    const char *path = nph_test_path(name);
    ck_assert_msg(nph_les_read(context, path, &les) == NPH_OK, "%s", nph_test_messages());
    ck_assert_int_eq(nph_cloud_extinction(context, &les, path, &sigma, lo, hi), NPH_OK);
    NphGrid grid;
    NphGridStatistics statistics;
    ck_assert_int_eq(nph_grid_from_array(context, &sigma, lo, hi, NPH_CENTRING_VDB, NPH_OUTSIDE_ZERO,
                                         NPH_LOOKUP_TRILINEAR, path, &grid),
                     NPH_OK);
    ck_assert_int_eq(nph_grid_statistics(context, &grid, &statistics), NPH_OK);
    /* half a unit of the last recorded digit */
    if (!isnan(max)) ck_assert_double_eq_tol(1000 * (double)grid.max, max, max > 200 ? 0.05 : 0.005);
    if (!isnan(mean_in_cloud)) ck_assert_double_eq_tol(1000 * statistics.mean_active, mean_in_cloud, 0.005);
    ck_assert_double_eq_tol(statistics.axis_depth_mean[2], depth_mean, 0.0005);
    ck_assert_double_eq_tol(statistics.axis_depth_max[2], depth_max, depth_max > 26 ? 0.0005 : 0.005);
    nph_grid_free(context, &grid);
    nph_array_free(context, &sigma);
    nph_les_free(context, &les);
    nph_test_context_close(context);
}

START_TEST(rico_has_its_recorded_extinction_and_depth) {
    check_cloud("reference/data/gpl/rico122x106x39.txt", 105.17, 16.40, 0.807, 22.03);
}
END_TEST

START_TEST(a_single_rico_cloud_has_its_recorded_extinction_and_depth) {
    check_cloud("reference/data/gpl/rico32x37x26.txt", 123.02, NAN, 3.180, 25.85);
}
END_TEST

START_TEST(stratocumulus_has_its_recorded_extinction_and_depth) {
    /* 6.799 and 26.262 were recorded for levels 25 m apart; the file rounds them to 438 .. 812 m: 15 of 374 / 15 m */
    check_cloud("reference/data/gpl/les_stcu.txt", 264.5, NAN, 6.799 * 374 / 375, 26.262 * 374 / 375);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, extinction_is_one_and_a_half_water_over_radius_on_the_outermost_points);
    tcase_add_test(cases, points_and_levels_that_mean_nothing_are_named);
    tcase_add_test(cases, rico_has_its_recorded_extinction_and_depth);
    tcase_add_test(cases, a_single_rico_cloud_has_its_recorded_extinction_and_depth);
    tcase_add_test(cases, stratocumulus_has_its_recorded_extinction_and_depth);
}

int main(void) { return nph_test_main("cloud", fill); }
