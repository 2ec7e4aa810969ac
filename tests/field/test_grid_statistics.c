/* SPDX-License-Identifier: Apache-2.0
 *
 * Optical depths: the statistics against quadrature of the lookup that is exact for piecewise linear functions, and
 * volumes that are refined without changing what they mean: their optical depth must not change. */
#include "field_fixtures.h"

static double noise(int x, int y, int z, void *user) {
    uint64_t state = (uint64_t)(z * 10007 + y * 101 + x) + *(uint64_t *)user;
    double unit = random_unit(&state);
    return unit < 0.2 ? 0 : 1 + 8 * unit;
}

static const double lo[3] = {-1, 2, 30}, hi[3] = {6, 4.5, 42};

static NphGrid build(NphContext *context, const NphArray *array, NphCentring centring, NphOutside outside,
                     NphLookup lookup) {
    NphGrid grid;
    NphStatus status = nph_grid_from_array(context, array, lo, hi, centring, outside, lookup, "array", &grid);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    return grid;
}

static double overlap(double begin, double end, double from, double to) {
    return fmax(0, fmin(end, to) - fmax(begin, from));
}

/* Midpoint rule between the half-integers: exact where the function is linear in between. Samples of nearest are read
 * in the middle of half a unit, trilinear ones there too, so only the box's share of each half counts: boxes end on
 * half-integers. */
static double line_depth(NphContext *context, const NphGrid *grid, int axis, int faster, int slower) {
    double sum = 0;
    for (int half = 0; half < 2 * (grid->n[axis] - 1); half++) {
        double at[3], begin = 0.5 * half, share = overlap(begin, begin + 0.5, grid->lo[axis], grid->hi[axis]);
        if (share == 0) continue;
        at[axis] = begin + 0.25;
        at[axis == 0 ? 1 : 0] = faster;
        at[axis == 2 ? 1 : 2] = slower;
        sum += share * field_at64(context, grid, at[0], at[1], at[2]);
    }
    return sum * grid->world_from_lattice[5 * axis];
}

START_TEST(axis_depths_are_the_integrals_of_the_lookup) {
    NphContext *context = nph_test_context(1);
    static const NphCentring centrings[] = {NPH_CENTRING_CELL, NPH_CENTRING_CELL, NPH_CENTRING_POINT, NPH_CENTRING_VDB};
    static const NphOutside outsides[] = {NPH_OUTSIDE_ZERO, NPH_OUTSIDE_CLAMP, NPH_OUTSIDE_ZERO, NPH_OUTSIDE_ZERO};
    uint64_t seed = 1;
    NphArray array = field_array(context, (int[]){11, 6, 9}, noise, &seed);
    for (int i = 0; i < 8; i++) {
        NphGrid grid = build(context, &array, centrings[i % 4], outsides[i % 4],
                             i < 4 ? NPH_LOOKUP_TRILINEAR : NPH_LOOKUP_NEAREST);
        NphGridStatistics statistics;
        ck_assert_int_eq(nph_grid_statistics(context, &grid, &statistics), NPH_OK);
        for (int axis = 0; axis < 3; axis++) {
            int faster = axis == 0 ? 1 : 0, slower = axis == 2 ? 1 : 2, lines = 0;
            double sum = 0, most = 0;
            for (int b = 1; b <= grid.n[slower] - 2; b++)
                for (int a = 1; a <= grid.n[faster] - 2; a++, lines++) {
                    double depth = line_depth(context, &grid, axis, a, b);
                    sum += depth;
                    most = depth > most ? depth : most;
                }
            ck_assert_double_eq_tol(statistics.axis_depth_mean[axis], sum / lines, 1e-11);
            ck_assert_double_eq_tol(statistics.axis_depth_max[axis], most, 1e-11);
        }
        ck_assert_double_eq_tol(statistics.mean, grid.sum / (11 * 6 * 9), 1e-12);
        ck_assert_double_eq_tol(statistics.mean_active, grid.sum / (double)grid.active, 1e-12);
        nph_grid_free(context, &grid);
    }
    nph_array_free(context, &array);
    nph_test_context_close(context);
}
END_TEST

START_TEST(statistics_do_not_depend_on_threads) {
    NphContext *one = nph_test_context(1), *three = nph_test_context(3);
    uint64_t seed = 4;
    NphArray array = field_array(one, (int[]){50, 41, 33}, noise, &seed);
    NphGrid grid = build(one, &array, NPH_CENTRING_CELL, NPH_OUTSIDE_ZERO, NPH_LOOKUP_TRILINEAR);
    NphGridStatistics a, b;
    memset(&a, 0, sizeof a);
    memset(&b, 1, sizeof b);
    ck_assert_int_eq(nph_grid_statistics(one, &grid, &a), NPH_OK);
    ck_assert_int_eq(nph_grid_statistics(three, &grid, &b), NPH_OK);
    ck_assert_int_eq(memcmp(&a, &b, sizeof a), 0);
    nph_grid_free(one, &grid);
    nph_array_free(one, &array);
    nph_test_context_close(one);
    nph_test_context_close(three);
}
END_TEST

/* The array at refine times the resolution. smooth: values of the interpolant at the finer points; else copies. */
typedef struct Fine {
    NphContext *context;
    const NphGrid *coarse;
    int refine;
    double first; /* lattice position of the first finer sample; smooth only */
} Fine;

static double smooth(int x, int y, int z, void *user) {
    const Fine *fine = user;
    double u = fine->first + (double)x / fine->refine, v = fine->first + (double)y / fine->refine;
    return field_oracle(fine->coarse, u, v, fine->first + (double)z / fine->refine);
}

static double copies(int x, int y, int z, void *user) {
    const Fine *fine = user;
    return (double)field_sample(fine->coarse, 1 + x / fine->refine, 1 + y / fine->refine, 1 + z / fine->refine);
}

enum { STEPS = 400, RAYS = 60 };

/* Largest difference of optical depth between two grids over rays from face to face, the same points in both. */
static double ray_difference(NphContext *context, const NphGrid *a, const NphGrid *b) {
    static double at[2][3][STEPS], out[2][STEPS];
    const NphGrid *grids[2] = {a, b};
    uint64_t state = 17;
    double worst = 0;
    for (int ray = 0; ray < RAYS; ray++) {
        double from[3], to[3], length = 0, depth[2];
        for (int axis = 0; axis < 3; axis++) {
            from[axis] = axis == ray % 3 ? lo[axis] : lo[axis] + random_unit(&state) * (hi[axis] - lo[axis]);
            to[axis] = axis == ray % 3 ? hi[axis] : lo[axis] + random_unit(&state) * (hi[axis] - lo[axis]);
            length += (to[axis] - from[axis]) * (to[axis] - from[axis]);
        }
        for (int g = 0; g < 2; g++) {
            for (int i = 0; i < STEPS; i++)
                for (int axis = 0; axis < 3; axis++)
                    at[g][axis][i] =
                        field_lattice(grids[g], axis, from[axis] + (to[axis] - from[axis]) * (i + 0.5) / STEPS);
            ck_assert_int_eq(
                nph_grid_sample(context, grids[g], 64, STEPS, (const void *[]){at[g][0], at[g][1], at[g][2]}, out[g]),
                NPH_OK);
            depth[g] = 0;
            for (int i = 0; i < STEPS; i++) depth[g] += out[g][i];
            depth[g] *= sqrt(length) / STEPS;
        }
        ck_assert_double_gt(depth[0], 1);
        worst = fmax(worst, fabs(depth[0] - depth[1]));
    }
    return worst;
}

/* A trilinear function cut into r^3 parts is the same trilinear function in each part: only the rounding of the finer
 * samples to f32 is left, 2^-24 of at most 9 along at most 14.2 m, 7.6e-6, and the same for the largest depth. */
START_TEST(trilinear_refinement_of_points_keeps_the_optical_depth) {
    NphContext *context = nph_test_context(1);
    uint64_t seed = 2;
    NphArray array = field_array(context, (int[]){8, 6, 9}, noise, &seed);
    NphGrid coarse = build(context, &array, NPH_CENTRING_POINT, NPH_OUTSIDE_ZERO, NPH_LOOKUP_TRILINEAR);
    NphGridStatistics before, after;
    ck_assert_int_eq(nph_grid_statistics(context, &coarse, &before), NPH_OK);
    for (int r = 2; r <= 5; r++) {
        Fine fine = {context, &coarse, r, 1};
        NphArray more = field_array(context, (int[]){7 * r + 1, 5 * r + 1, 8 * r + 1}, smooth, &fine);
        NphGrid grid = build(context, &more, NPH_CENTRING_POINT, NPH_OUTSIDE_ZERO, NPH_LOOKUP_TRILINEAR);
        ck_assert_double_le(ray_difference(context, &coarse, &grid), 7.7e-6);
        /* the depth is linear between lines: its largest value stays on one that both have */
        ck_assert_int_eq(nph_grid_statistics(context, &grid, &after), NPH_OK);
        for (int axis = 0; axis < 3; axis++)
            ck_assert_double_eq_tol(after.axis_depth_max[axis], before.axis_depth_max[axis], 7.7e-6);
        nph_grid_free(context, &grid);
        nph_array_free(context, &more);
    }
    nph_grid_free(context, &coarse);
    nph_array_free(context, &array);
    nph_test_context_close(context);
}
END_TEST

START_TEST(copied_cells_keep_the_optical_depth_of_the_nearest_lookup) {
    NphContext *context = nph_test_context(1);
    uint64_t seed = 3;
    NphArray array = field_array(context, (int[]){8, 6, 9}, noise, &seed);
    NphGrid coarse = build(context, &array, NPH_CENTRING_CELL, NPH_OUTSIDE_ZERO, NPH_LOOKUP_NEAREST);
    NphGridStatistics before, after;
    ck_assert_int_eq(nph_grid_statistics(context, &coarse, &before), NPH_OK);
    for (int r = 2; r <= 4; r++) {
        Fine fine = {context, &coarse, r, 0};
        NphArray more = field_array(context, (int[]){8 * r, 6 * r, 9 * r}, copies, &fine);
        NphGrid grid = build(context, &more, NPH_CENTRING_CELL, NPH_OUTSIDE_ZERO, NPH_LOOKUP_NEAREST);
        ck_assert_double_le(ray_difference(context, &coarse, &grid), 1e-11);
        ck_assert_int_eq(nph_grid_statistics(context, &grid, &after), NPH_OK);
        for (int axis = 0; axis < 3; axis++) {
            ck_assert_double_eq_tol(after.axis_depth_mean[axis], before.axis_depth_mean[axis], 1e-11);
            ck_assert_double_eq_tol(after.axis_depth_max[axis], before.axis_depth_max[axis], 1e-11);
        }
        nph_grid_free(context, &grid);
        nph_array_free(context, &more);
    }
    nph_grid_free(context, &coarse);
    nph_array_free(context, &array);
    nph_test_context_close(context);
}
END_TEST

/* With zero outside, a trilinear line between cells loses h / 8 of its first and its last value (3/8 of the half cell's
 * 1/2 are left), so copies at r times the resolution gain h / 8 (1 - 1 / r) of both: at most h / 4 of the largest. */
START_TEST(copied_cells_change_trilinear_depth_by_the_half_cells_at_the_faces) {
    NphContext *context = nph_test_context(1);
    uint64_t seed = 3;
    int size[3] = {8, 6, 9};
    NphArray array = field_array(context, size, noise, &seed);
    NphGrid coarse = build(context, &array, NPH_CENTRING_CELL, NPH_OUTSIDE_ZERO, NPH_LOOKUP_TRILINEAR);
    NphGridStatistics before, after;
    ck_assert_int_eq(nph_grid_statistics(context, &coarse, &before), NPH_OK);
    for (int r = 2; r <= 4; r++) {
        Fine fine = {context, &coarse, r, 0};
        NphArray more = field_array(context, (int[]){8 * r, 6 * r, 9 * r}, copies, &fine);
        NphGrid grid = build(context, &more, NPH_CENTRING_CELL, NPH_OUTSIDE_ZERO, NPH_LOOKUP_TRILINEAR);
        ck_assert_int_eq(nph_grid_statistics(context, &grid, &after), NPH_OK);
        for (int axis = 0; axis < 3; axis++) {
            int faster = axis == 0 ? 1 : 0, slower = axis == 2 ? 1 : 2, at[3];
            double faces = 0, h = (hi[axis] - lo[axis]) / size[axis];
            for (at[slower] = 1; at[slower] <= size[slower]; at[slower]++)
                for (at[faster] = 1; at[faster] <= size[faster]; at[faster]++) {
                    at[axis] = 1;
                    faces += (double)field_sample(&coarse, at[0], at[1], at[2]);
                    at[axis] = size[axis];
                    faces += (double)field_sample(&coarse, at[0], at[1], at[2]);
                }
            faces /= size[slower] * size[faster];
            double gain = after.axis_depth_mean[axis] - before.axis_depth_mean[axis];
            ck_assert_double_eq_tol(gain, h / 8 * (1 - 1.0 / r) * faces, 1e-11);
            ck_assert_double_le(fabs(gain), h / 4 * (double)coarse.max);
        }
        nph_grid_free(context, &grid);
        nph_array_free(context, &more);
    }
    nph_grid_free(context, &coarse);
    nph_array_free(context, &array);
    nph_test_context_close(context);
}
END_TEST

START_TEST(refinement_keeps_the_integral_over_all_space_for_vdb_centring) {
    NphContext *context = nph_test_context(1);
    uint64_t seed = 5;
    NphArray array = field_array(context, (int[]){8, 6, 9}, noise, &seed);
    NphGrid coarse = build(context, &array, NPH_CENTRING_VDB, NPH_OUTSIDE_ZERO, NPH_LOOKUP_TRILINEAR);
    for (int r = 2; r <= 4; r++) {
        Fine fine = {context, &coarse, r, 1.0 / r}; /* the fade within one voxel becomes samples of its own */
        NphArray more = field_array(context, (int[]){9 * r - 1, 7 * r - 1, 10 * r - 1}, smooth, &fine);
        NphGrid grid = build(context, &more, NPH_CENTRING_VDB, NPH_OUTSIDE_ZERO, NPH_LOOKUP_TRILINEAR);
        ck_assert_double_eq_tol(grid.sum / (r * r * r), coarse.sum, 0x1p-24 * coarse.sum);
        nph_grid_free(context, &grid);
        nph_array_free(context, &more);
    }
    nph_grid_free(context, &coarse);
    nph_array_free(context, &array);
    nph_test_context_close(context);
}
END_TEST

static double large(int x, int y, int z, void *user) {
    (void)user;
    return (x + y + z) % 2 ? 1e38 : 1e-38;
}

START_TEST(sums_of_the_largest_densities_are_finite) {
    NphContext *context = nph_test_context(1);
    NphArray array = field_array(context, (int[]){20, 20, 20}, large, NULL);
    NphGrid grid = build(context, &array, NPH_CENTRING_CELL, NPH_OUTSIDE_CLAMP, NPH_LOOKUP_NEAREST);
    NphGridStatistics statistics;
    ck_assert_int_eq(nph_grid_statistics(context, &grid, &statistics), NPH_OK);
    ck_assert_double_eq_tol(grid.sum / 4e41, 1, 1e-7);
    ck_assert_double_eq_tol(statistics.axis_depth_mean[0] / (0.5 * 7 * 1e38), 1, 1e-7);
    nph_grid_free(context, &grid);
    nph_array_free(context, &array);
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, axis_depths_are_the_integrals_of_the_lookup);
    tcase_add_test(cases, statistics_do_not_depend_on_threads);
    tcase_add_test(cases, trilinear_refinement_of_points_keeps_the_optical_depth);
    tcase_add_test(cases, copied_cells_keep_the_optical_depth_of_the_nearest_lookup);
    tcase_add_test(cases, copied_cells_change_trilinear_depth_by_the_half_cells_at_the_faces);
    tcase_add_test(cases, refinement_keeps_the_integral_over_all_space_for_vdb_centring);
    tcase_add_test(cases, sums_of_the_largest_densities_are_finite);
}

int main(void) { return nph_test_main("grid_statistics", fill); }
