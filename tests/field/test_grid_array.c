/* SPDX-License-Identifier: Apache-2.0
 *
 * Grids from dense arrays: where samples stand in the world, what happens at the box's faces, what is shared, what is
 * refused. Positions are computed here from the definition of cells and points, not from the grid's own map. */
#include "field_fixtures.h"

static const double lo[3] = {-3.5, 100.25, 7}, hi[3] = {9.25, 101.5, 31};
static const int size[3] = {13, 9, 18};

typedef struct Frame {
    NphCentring centring;
} Frame;

static double centre(const Frame *frame, int axis, int i) {
    if (frame->centring == NPH_CENTRING_CELL) return lo[axis] + (i + 0.5) * (hi[axis] - lo[axis]) / size[axis];
    return lo[axis] + i * (hi[axis] - lo[axis]) / (size[axis] - 1);
}

static double ramp_at(double x, double y, double z) { return 2 + 0.5 * (x + 3.5) + 0.25 * (y - 100) + 0.125 * z; }

static double ramp(int x, int y, int z, void *user) {
    const Frame *frame = user;
    return ramp_at(centre(frame, 0, x), centre(frame, 1, y), centre(frame, 2, z));
}

static double hashed(int x, int y, int z, void *user) {
    uint64_t state = (uint64_t)(z * 10007 + y * 101 + x);
    (void)user;
    return floor(250 * random_unit(&state));
}

static NphGrid build(NphContext *context, const NphArray *array, NphCentring centring, NphOutside outside,
                     NphLookup lookup) {
    NphGrid grid;
    NphStatus status = nph_grid_from_array(context, array, lo, hi, centring, outside, lookup, "array", &grid);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    return grid;
}

START_TEST(a_linear_ramp_is_exact_at_world_positions_for_cells_and_points) {
    NphContext *context = nph_test_context(1);
    for (int i = 0; i < 2; i++) {
        Frame frame = {i == 0 ? NPH_CENTRING_CELL : NPH_CENTRING_POINT};
        NphArray array = field_array(context, size, ramp, &frame);
        NphGrid grid = build(context, &array, frame.centring, NPH_OUTSIDE_ZERO, NPH_LOOKUP_TRILINEAR);
        uint64_t state = 1;
        for (int sample = 0; sample < 2000; sample++) {
            double world[3], at[3];
            for (int axis = 0; axis < 3; axis++) {
                double first = centre(&frame, axis, 0), last = centre(&frame, axis, size[axis] - 1);
                world[axis] = first + random_unit(&state) * (last - first);
                at[axis] = field_lattice(&grid, axis, world[axis]);
            }
            double expected = ramp_at(world[0], world[1], world[2]);
            /* samples are rounded to f32 */
            ck_assert_double_eq_tol(field_at64(context, &grid, at[0], at[1], at[2]), expected, 12 * 0x1p-24);
        }
        nph_grid_free(context, &grid);
        nph_array_free(context, &array);
    }
    nph_test_context_close(context);
}
END_TEST

START_TEST(the_box_is_where_the_centring_says) {
    NphContext *context = nph_test_context(1);
    Frame frame = {NPH_CENTRING_CELL};
    NphArray array = field_array(context, size, ramp, &frame);
    static const NphCentring centrings[] = {NPH_CENTRING_CELL, NPH_CENTRING_POINT, NPH_CENTRING_VDB};
    for (int i = 0; i < 3; i++) {
        NphGrid grid = build(context, &array, centrings[i], NPH_OUTSIDE_ZERO, NPH_LOOKUP_TRILINEAR);
        for (int axis = 0; axis < 3; axis++) {
            /* vdb fades over one spacing more on both sides */
            double fade = i == 2 ? (hi[axis] - lo[axis]) / (size[axis] - 1) : 0;
            ck_assert_int_eq(grid.n[axis], size[axis] + 2);
            ck_assert_double_eq_tol(grid.lo[axis], field_lattice(&grid, axis, lo[axis] - fade), 1e-12);
            ck_assert_double_eq_tol(grid.hi[axis], field_lattice(&grid, axis, hi[axis] + fade), 1e-12);
        }
        ck_assert_double_eq(field_at64(context, &grid, grid.lo[0] - 1e-9, 4, 4), 0);
        ck_assert_double_eq(field_at64(context, &grid, 4, grid.hi[1] + 1e-9, 4), 0);
        ck_assert_double_eq(field_at64(context, &grid, 4, 4, NAN), 0);
        nph_grid_free(context, &grid);
    }
    nph_array_free(context, &array);
    nph_test_context_close(context);
}
END_TEST

static double three_in_x(int x, int y, int z, void *user) {
    (void)y, (void)z, (void)user;
    return x == 0 ? 4 : x == 12 ? 8 : 1;
}

START_TEST(faces_halve_with_zero_outside_and_hold_with_clamp) {
    NphContext *context = nph_test_context(1);
    NphArray array = field_array(context, size, three_in_x, NULL);
    NphGrid zero = build(context, &array, NPH_CENTRING_CELL, NPH_OUTSIDE_ZERO, NPH_LOOKUP_TRILINEAR);
    NphGrid clamp = build(context, &array, NPH_CENTRING_CELL, NPH_OUTSIDE_CLAMP, NPH_LOOKUP_TRILINEAR);
    NphGrid point = build(context, &array, NPH_CENTRING_POINT, NPH_OUTSIDE_ZERO, NPH_LOOKUP_TRILINEAR);
    NphGrid vdb = build(context, &array, NPH_CENTRING_VDB, NPH_OUTSIDE_ZERO, NPH_LOOKUP_TRILINEAR);
    NphGrid nearest = build(context, &array, NPH_CENTRING_CELL, NPH_OUTSIDE_ZERO, NPH_LOOKUP_NEAREST);
    ck_assert_double_eq(field_at64(context, &zero, 0.5, 4, 4), 2);
    ck_assert_double_eq(field_at64(context, &zero, 0.75, 4, 4), 3);
    ck_assert_double_eq(field_at64(context, &zero, 13.5, 4, 4), 4);
    ck_assert_double_eq(field_at64(context, &clamp, 0.5, 4, 4), 4);
    ck_assert_double_eq(field_at64(context, &clamp, 1, 0.5, 0.5), 4);
    ck_assert_double_eq(field_at64(context, &clamp, 13.5, 9.5, 18.5), 8);
    ck_assert_double_eq(field_at64(context, &clamp, 1.5, 4, 4), 2.5);
    ck_assert_double_eq(field_at64(context, &point, 1, 1, 1), 4);
    ck_assert_double_eq(field_at64(context, &point, 13, 9, 18), 8);
    ck_assert_double_eq(field_at64(context, &vdb, 0.25, 4, 4), 1);
    ck_assert_double_eq(field_at64(context, &vdb, 0, 4, 4), 0);
    ck_assert_double_eq(field_at64(context, &vdb, 14, 4, 4), 0);
    ck_assert_double_eq(field_at64(context, &nearest, 0.5, 0.5, 0.5), 4);
    ck_assert_double_eq(field_at64(context, &nearest, 1.499, 4, 4), 4);
    ck_assert_double_eq(field_at64(context, &nearest, 1.5, 4, 4), 1);
    ck_assert_double_eq(field_at64(context, &nearest, 13.499, 4, 4), 8);
    NphGrid *grids[] = {&zero, &clamp, &point, &vdb, &nearest};
    for (int i = 0; i < 5; i++) nph_grid_free(context, grids[i]);
    nph_array_free(context, &array);
    nph_test_context_close(context);
}
END_TEST

START_TEST(the_sum_is_the_integral_of_the_interpolant_for_vdb_centring) {
    NphContext *context = nph_test_context(1);
    NphArray array = field_array(context, size, hashed, NULL);
    NphGrid grid = build(context, &array, NPH_CENTRING_VDB, NPH_OUTSIDE_ZERO, NPH_LOOKUP_TRILINEAR);
    double integral = 0, sum = 0;
    /* the middle of a lattice cell has the mean of its corners, which is the cell's integral */
    for (int k = 0; k < grid.n[2] - 1; k++)
        for (int j = 0; j < grid.n[1] - 1; j++)
            for (int i = 0; i < grid.n[0] - 1; i++) integral += field_at64(context, &grid, i + 0.5, j + 0.5, k + 0.5);
    const double *values = array.data;
    int64_t count = nph_array_count(&array), active = 0;
    for (int64_t i = 0; i < count; i++) {
        sum += values[i];
        active += values[i] != 0;
    }
    ck_assert_double_eq_tol(integral, grid.sum, 1e-9);
    ck_assert_double_eq(sum, grid.sum); /* integers: exact */
    ck_assert_int_eq(active, grid.active);
    nph_grid_free(context, &grid);
    nph_array_free(context, &array);
    nph_test_context_close(context);
}
END_TEST

#define STORE(type, ctype)                                                                                             \
    case type:                                                                                                         \
        for (int64_t i = 0; i < count; i++) ((ctype *)made.data)[i] = (ctype)values[i];                                \
        break

/* The same numbers, all integers below 250, in another type. */
static NphArray convert(NphContext *context, const NphArray *from, NphType type) {
    NphArray made = {0};
    ck_assert_int_eq(nph_array_new(context, type, 3, from->shape, "copy", &made), NPH_OK);
    const double *values = from->data;
    int64_t count = nph_array_count(from);
    switch (type) {
        STORE(NPH_U8, uint8_t);
        STORE(NPH_U16, uint16_t);
        STORE(NPH_I16, int16_t);
        STORE(NPH_U32, uint32_t);
        STORE(NPH_I32, int32_t);
        STORE(NPH_U64, uint64_t);
        STORE(NPH_I64, int64_t);
        STORE(NPH_F32, float);
        STORE(NPH_F64, double);
    case NPH_I8:
        for (int64_t i = 0; i < count; i++) ((int8_t *)made.data)[i] = (int8_t)(values[i] / 2);
        break;
    case NPH_F16: /* of a whole number m 2^e, 1 <= m < 2 */
        for (int64_t i = 0; i < count; i++) {
            int exponent = 0;
            double m = frexp(values[i], &exponent);
            ((uint16_t *)made.data)[i] =
                (uint16_t)(values[i] > 0 ? (unsigned)(exponent + 14) << 10 | ((unsigned)(m * 2048) & 1023u) : 0u);
        }
        break;
    }
    return made;
}

START_TEST(every_type_arrives_sample_by_sample) {
    NphContext *context = nph_test_context(2);
    NphArray array = field_array(context, size, hashed, NULL);
    for (int type = NPH_U8; type <= NPH_F64; type++) {
        NphArray copy = convert(context, &array, (NphType)type);
        NphGrid grid = build(context, &copy, NPH_CENTRING_CELL, NPH_OUTSIDE_ZERO, NPH_LOOKUP_NEAREST);
        for (int k = 0; k < grid.n[2]; k++)
            for (int j = 0; j < grid.n[1]; j++)
                for (int i = 0; i < grid.n[0]; i++) {
                    int x = i - 1, y = j - 1, z = k - 1;
                    int padding = x < 0 || y < 0 || z < 0 || x >= size[0] || y >= size[1] || z >= size[2];
                    double expected = padding ? 0 : hashed(x, y, z, NULL);
                    if (type == NPH_I8) expected = floor(expected / 2);
                    ck_assert_double_eq((double)field_sample(&grid, i, j, k), expected);
                    if (!padding)
                        ck_assert_double_eq(field_at64(context, &grid, i - 0.49, j + 0.49, k - 0.5), expected);
                }
        nph_grid_free(context, &grid);
        nph_array_free(context, &copy);
    }
    nph_array_free(context, &array);
    nph_test_context_close(context);
}
END_TEST

START_TEST(lookups_agree_with_the_sum_of_hats) {
    NphContext *context = nph_test_context(1);
    NphArray array = field_array(context, size, hashed, NULL);
    for (int outside = NPH_OUTSIDE_ZERO; outside <= NPH_OUTSIDE_CLAMP; outside++) {
        NphGrid grid = build(context, &array, NPH_CENTRING_CELL, (NphOutside)outside, NPH_LOOKUP_TRILINEAR);
        uint64_t state = 7;
        for (int sample = 0; sample < 3000; sample++) {
            double at[3];
            for (int axis = 0; axis < 3; axis++) at[axis] = 0.5 + random_unit(&state) * size[axis];
            ck_assert_double_eq_tol(field_at64(context, &grid, at[0], at[1], at[2]),
                                    field_oracle(&grid, at[0], at[1], at[2]), 250 * 0x1p-49);
        }
        nph_grid_free(context, &grid);
    }
    nph_array_free(context, &array);
    nph_test_context_close(context);
}
END_TEST

static double blob(int x, int y, int z, void *user) {
    (void)user;
    return x >= 40 && x < 43 && y >= 40 && y < 43 && z >= 40 && z < 43 ? 1 : 0;
}

static double constant(int x, int y, int z, void *user) {
    (void)x, (void)y, (void)z;
    return *(double *)user;
}

START_TEST(empty_and_equal_constant_bricks_are_stored_once) {
    NphContext *context = nph_test_context(2);
    NphArray array = field_array(context, (int[]){70, 70, 70}, blob, NULL);
    NphGrid grid = build(context, &array, NPH_CENTRING_CELL, NPH_OUTSIDE_ZERO, NPH_LOOKUP_TRILINEAR);
    ck_assert_int_eq(grid.brick_count, 2); /* samples 41 to 43 lie inside brick 5 (40 to 48) */
    ck_assert_int_eq(grid.active, 27);
    ck_assert_uint_eq(nph_grid_bytes(&grid), 9 * 9 * 9 * 4 + 2 * 736 * 4 + 18 * 18 * 18 * 4);
    nph_grid_free(context, &grid);
    nph_array_free(context, &array);
    double three = 3;
    array = field_array(context, (int[]){70, 70, 70}, constant, &three);
    grid = build(context, &array, NPH_CENTRING_CELL, NPH_OUTSIDE_CLAMP, NPH_LOOKUP_TRILINEAR);
    ck_assert_int_eq(grid.brick_count, 2);
    ck_assert_double_eq(field_at64(context, &grid, 70.5, 33.3, 0.5), 3);
    ck_assert_double_eq(grid.sum, 3.0 * 70 * 70 * 70);
    nph_grid_free(context, &grid);
    grid = build(context, &array, NPH_CENTRING_CELL, NPH_OUTSIDE_ZERO, NPH_LOOKUP_TRILINEAR);
    ck_assert_int_eq(grid.brick_count, 2 + 9 * 9 * 9 - 7 * 7 * 7); /* all but the inner 7^3 touch the padding */
    nph_grid_free(context, &grid);
    nph_array_free(context, &array);
    nph_test_context_close(context);
}
END_TEST

START_TEST(one_cell_is_a_grid) {
    NphContext *context = nph_test_context(1);
    double five = 5;
    NphArray array = field_array(context, (int[]){1, 1, 1}, constant, &five);
    NphGrid grid = build(context, &array, NPH_CENTRING_CELL, NPH_OUTSIDE_CLAMP, NPH_LOOKUP_TRILINEAR);
    ck_assert_int_eq(grid.n[0], 3);
    ck_assert_double_eq(field_at64(context, &grid, 0.5, 0.5, 1.5), 5);
    ck_assert_double_eq(field_at64(context, &grid, 0.4999, 0.5, 1.5), 0);
    nph_grid_free(context, &grid);
    nph_array_free(context, &array);
    nph_test_context_close(context);
}
END_TEST

static void refuse(NphContext *context, const NphArray *array, NphCentring centring, NphStatus expected,
                   const char *word) {
    NphGrid grid, untouched;
    memset(&grid, 0x5a, sizeof grid);
    untouched = grid;
    NphStatus status = nph_grid_from_array(context, array, lo, hi, centring, NPH_OUTSIDE_CLAMP, NPH_LOOKUP_TRILINEAR,
                                           "cloud.npy", &grid);
    const char *messages = nph_test_messages();
    ck_assert_int_eq(status, expected);
    ck_assert_msg(strstr(messages, word) && strstr(messages, "cloud.npy"), "%s", messages);
    ck_assert_int_eq(memcmp(&grid, &untouched, sizeof grid), 0);
}

START_TEST(bad_voxels_are_named_and_the_largest_density_is_taken) {
    NphContext *context = nph_test_context(3);
    static const double bad[] = {NAN, HUGE_VAL, -HUGE_VAL, -1, -1e-300, -1e300, 1.1e38, 1e39, 1e300};
    for (int i = 0; i < 9; i++) {
        NphArray array = field_array(context, size, hashed, NULL);
        ((double *)array.data)[(10 * 9 + 8) * 13 + 12] = bad[i];
        ((double *)array.data)[(17 * 9 + 0) * 13 + 1] = NAN;
        refuse(context, &array, NPH_CENTRING_CELL, NPH_BAD_INPUT, "[z, y, x] = [10, 8, 12]");
        nph_array_free(context, &array);
    }
    NphArray array = field_array(context, size, hashed, NULL);
    double *values = array.data;
    values[0] = 1e38;
    values[1] = -0.0;
    values[2] = 1e-300;
    NphGrid grid = build(context, &array, NPH_CENTRING_CELL, NPH_OUTSIDE_CLAMP, NPH_LOOKUP_TRILINEAR);
    ck_assert_float_eq(field_sample(&grid, 1, 1, 1), 1e38f);
    ck_assert_int_eq(signbit(field_sample(&grid, 2, 1, 1)), 0);
    ck_assert_float_eq(field_sample(&grid, 3, 1, 1), 0);
    ck_assert_float_eq(grid.max, 1e38f);
    ck_assert(isfinite(grid.sum));
    nph_grid_free(context, &grid);
    nph_array_free(context, &array);
    nph_test_context_close(context);
}
END_TEST

START_TEST(shapes_and_boxes_that_mean_nothing_are_refused) {
    NphContext *context = nph_test_context(1);
    NphArray array = {0};
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 2, (int64_t[]){4, 4}, "flat", &array), NPH_OK);
    refuse(context, &array, NPH_CENTRING_CELL, NPH_BAD_INPUT, "2 axes");
    nph_array_free(context, &array);
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 3, (int64_t[]){4, 0, 4}, "empty", &array), NPH_OK);
    refuse(context, &array, NPH_CENTRING_CELL, NPH_BAD_INPUT, "no voxels along y");
    nph_array_free(context, &array);
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 3, (int64_t[]){4, 4, 1}, "thin", &array), NPH_OK);
    refuse(context, &array, NPH_CENTRING_POINT, NPH_BAD_INPUT, "one point along x");
    nph_array_free(context, &array);
    ck_assert_int_eq(nph_array_new(context, NPH_U8, 3, (int64_t[]){1, 1, 65535}, "long", &array), NPH_OK);
    refuse(context, &array, NPH_CENTRING_CELL, NPH_BAD_INPUT, "at most 65534");
    nph_array_free(context, &array);
    ck_assert_int_eq(nph_array_new(context, NPH_U8, 3, (int64_t[]){4, 4, 4}, "cube", &array), NPH_OK);
    refuse(context, &array, NPH_CENTRING_VDB, NPH_BAD_USAGE, "cannot clamp");
    static const double edges[][2] = {{1, 1}, {2, 1}, {0, HUGE_VAL}, {NAN, 1}, {-1.7e308, 1.7e308}};
    for (int i = 0; i < 5; i++) {
        NphGrid grid;
        double low[3] = {0, edges[i][0], 0}, high[3] = {1, edges[i][1], 1};
        ck_assert_int_eq(nph_grid_from_array(context, &array, low, high, NPH_CENTRING_CELL, NPH_OUTSIDE_ZERO,
                                             NPH_LOOKUP_NEAREST, "box", &grid),
                         NPH_BAD_INPUT);
        ck_assert_ptr_nonnull(strstr(nph_test_messages(), "along y"));
    }
    nph_array_free(context, &array);
    nph_test_context_close(context);
}
END_TEST

static NphStatus build_once(NphContext *context, void *data, NphGrid *grid) {
    return nph_grid_from_array(context, data, lo, hi, NPH_CENTRING_CELL, NPH_OUTSIDE_CLAMP, NPH_LOOKUP_TRILINEAR,
                               "array", grid);
}

START_TEST(failing_allocations_leak_nothing) {
    NphContext *context = nph_test_context(1);
    double three = 3;
    NphArray array = field_array(context, (int[]){20, 20, 20}, constant, &three);
    ((double *)array.data)[77] = 4;
    field_fail_every_allocation(build_once, &array);
    nph_array_free(context, &array);
    nph_test_context_close(context);
}
END_TEST

START_TEST(the_number_of_threads_does_not_show) {
    NphContext *one = nph_test_context(1);
    NphArray array = field_array(one, (int[]){50, 60, 70}, hashed, NULL);
    NphGrid expected = build(one, &array, NPH_CENTRING_CELL, NPH_OUTSIDE_ZERO, NPH_LOOKUP_TRILINEAR);
    static const int threads[] = {2, 3, 7};
    for (int i = 0; i < 3; i++) {
        NphContext *context = nph_test_context(threads[i]);
        NphGrid grid = build(context, &array, NPH_CENTRING_CELL, NPH_OUTSIDE_ZERO, NPH_LOOKUP_TRILINEAR);
        ck_assert(field_same(&grid, &expected));
        nph_grid_free(context, &grid);
        nph_test_context_close(context);
    }
    nph_grid_free(one, &expected);
    nph_array_free(one, &array);
    nph_test_context_close(one);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, a_linear_ramp_is_exact_at_world_positions_for_cells_and_points);
    tcase_add_test(cases, the_box_is_where_the_centring_says);
    tcase_add_test(cases, faces_halve_with_zero_outside_and_hold_with_clamp);
    tcase_add_test(cases, the_sum_is_the_integral_of_the_interpolant_for_vdb_centring);
    tcase_add_test(cases, every_type_arrives_sample_by_sample);
    tcase_add_test(cases, lookups_agree_with_the_sum_of_hats);
    tcase_add_test(cases, empty_and_equal_constant_bricks_are_stored_once);
    tcase_add_test(cases, one_cell_is_a_grid);
    tcase_add_test(cases, bad_voxels_are_named_and_the_largest_density_is_taken);
    tcase_add_test(cases, shapes_and_boxes_that_mean_nothing_are_refused);
    tcase_add_test(cases, failing_allocations_leak_nothing);
    tcase_add_test(cases, the_number_of_threads_does_not_show);
}

int main(void) { return nph_test_main("grid_array", fill); }
