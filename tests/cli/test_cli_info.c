/* SPDX-License-Identifier: Apache-2.0
 *
 * nephos info on files whose contents are known. */
#include "cli/program.h"
#include "io/volume.h"
#include "nephos/image.h"

START_TEST(an_array_is_told_with_range_mean_and_optical_depth) {
    NphContext *context = nph_test_context(1);
    NphArray array = {0};
    const char *path = file_of("array.npy");
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 3, (int64_t[]){2, 3, 4}, "array", &array), NPH_OK);
    for (int i = 0; i < 24; i++) ((float *)array.data)[i] = 0.5f;
    ck_assert_int_eq(nph_npy_write(context, path, &array), NPH_OK);
    nph_array_free(context, &array);
    nph_test_context_close(context);
    const Ran *run = RUN("info", path, "--json");
    ck_assert_int_eq(run->status, 0);
    ck_assert_ptr_nonnull(strstr(run->out, "\"shape\": [2, 3, 4]"));
    ck_assert_ptr_nonnull(strstr(run->out, "\"mean\": 0.5"));
    /* 4 cells of 0.5 along x; zero outside: at either end half a cell falls from 0.5 to 0.25, which costs 1/16 */
    ck_assert_ptr_nonnull(strstr(run->out, "\"optical_depth_mean_xyz\": [1.875, 1.375, 0.875]"));
    run = RUN("info", path);
    ck_assert_int_eq(run->status, 0);
    ck_assert_ptr_nonnull(strstr(run->out, "(1.875, 1.375, 0.875)"));
}
END_TEST

/* 4 x 3 x 2 cells of edge 2: clamped outside, so a line of n cells of 0.5 is 0.5 * 2 n deep. */
START_TEST(a_mitsuba_volume_is_told_with_its_box) {
    NphContext *context = nph_test_context(1);
    NphBoxGrid box = {.lo = {1, 2, 3}, .hi = {9, 8, 7}};
    const char *path = file_of("grid.vol");
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 3, (int64_t[]){2, 3, 4}, "array", &box.values), NPH_OK);
    for (int i = 0; i < 24; i++) ((float *)box.values.data)[i] = 0.5f;
    ck_assert_int_eq(nph_vol_write(context, path, &box), NPH_OK);
    nph_box_grid_free(context, &box);
    nph_test_context_close(context);
    const Ran *run = RUN("info", path, "--json");
    ck_assert_int_eq(run->status, 0);
    ck_assert_ptr_nonnull(strstr(run->out, "\"box_to\": [9, 8, 7]"));
    ck_assert_ptr_nonnull(strstr(run->out, "\"optical_depth_mean_xyz\": [4, 3, 2]"));
}
END_TEST

START_TEST(an_openvdb_file_is_told_grid_by_grid) {
    const Ran *run = RUN("info", nph_test_path("reference/data/vdb/plume32_f20_BLOSC_float32.vdb"), "--json");
    ck_assert_int_eq(run->status, 0);
    static const char *const parts[] = {"\"name\": \"velocity\"", "\"type\": \"vec3s\"", "not decoded", "\"codec\": \"blosc\"",
                                        "\"active_voxels\": 2462", "\"voxel_size\": [0.125, 0.125, 0.125]"};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
        ck_assert_msg(strstr(run->out, parts[i]) != NULL, "no %s in\n%s", parts[i], run->out);
}
END_TEST

START_TEST(the_media_of_a_pbrt_file_are_listed_and_grids_told) {
    const char *path = file_of("media.pbrt");
    write_text(path, "MakeNamedMedium \"air\" \"string type\" \"homogeneous\"\n"
                     "MakeNamedMedium \"cloud\" \"string type\" \"uniformgrid\" \"integer nx\" 3 \"float density\" [1 2 3]\n");
    const Ran *run = RUN("info", path);
    ck_assert_int_eq(run->status, 0);
    static const char *const parts[] = {"air", "homogeneous", "not read", "cloud", "uniformgrid", "(1, 1, 3)"};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
        ck_assert_msg(strstr(run->out, parts[i]) != NULL, "no %s in\n%s", parts[i], run->out);
}
END_TEST

START_TEST(values_that_are_no_densities_have_no_optical_depth) {
    NphContext *context = nph_test_context(1);
    NphArray array = {0};
    const char *path = file_of("signed.npy");
    ck_assert_int_eq(nph_array_new(context, NPH_F64, 3, (int64_t[]){2, 2, 2}, "array", &array), NPH_OK);
    ((double *)array.data)[5] = -3;
    ck_assert_int_eq(nph_npy_write(context, path, &array), NPH_OK);
    nph_array_free(context, &array);
    nph_test_context_close(context);
    const Ran *run = RUN("info", path);
    ck_assert_int_eq(run->status, 0);
    ck_assert_ptr_nonnull(strstr(run->out, "not a density"));
    ck_assert_ptr_nonnull(strstr(run->out, "-3"));
}
END_TEST

START_TEST(a_picture_is_told_with_channels_and_attributes) {
    NphContext *context = nph_test_context(1);
    NphImage image;
    float *pixels = NULL;
    const char *path = file_of("picture.exr");
    ck_assert_int_eq(nph_image_new(context, 5, 4, &image), NPH_OK);
    ck_assert_int_eq(nph_image_add_channel(context, &image, "Depth.Z", &pixels), NPH_OK);
    for (int i = 0; i < 20; i++) pixels[i] = (float)i;
    ck_assert_int_eq(nph_image_set_text(context, &image, "note", "what it is"), NPH_OK);
    ck_assert_int_eq(nph_exr_write(context, path, &image), NPH_OK);
    nph_image_free(context, &image);
    nph_test_context_close(context);
    const Ran *run = RUN("info", path, "--json");
    ck_assert_int_eq(run->status, 0);
    static const char *const parts[] = {"\"size\": [5, 4]", "\"name\": \"Depth.Z\"", "\"type\": \"float\"", "\"min\": 0",
                                        "\"max\": 19", "\"mean\": 9.5", "\"note\": \"what it is\""};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
        ck_assert_msg(strstr(run->out, parts[i]) != NULL, "no %s in\n%s", parts[i], run->out);
}
END_TEST

START_TEST(what_cannot_be_read_gives_a_message_and_no_half_truth) {
    static const char *const names[] = {"empty", "garbage", "text.npy", "short.exr"};
    static const char *const texts[] = {"", "\001\002\003 nothing known", "\x93NUMPY\001", "\x76\x2f\x31\x01\x02"};
    for (int i = 0; i < 4; i++) {
        const char *path = file_of(names[i]);
        write_text(path, texts[i]);
        const Ran *run = RUN("info", path);
        ck_assert_msg(run->status == 4 && !*run->out && strstr(run->err, names[i]), "%s: status %d\n%s%s", names[i],
                      run->status, run->out, run->err);
    }
    ck_assert_int_eq(RUN("info", file_of("missing"))->status, 4);
    ck_assert_int_eq(RUN("info", file_of(""))->status, 4);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, an_array_is_told_with_range_mean_and_optical_depth);
    tcase_add_test(cases, a_mitsuba_volume_is_told_with_its_box);
    tcase_add_test(cases, an_openvdb_file_is_told_grid_by_grid);
    tcase_add_test(cases, the_media_of_a_pbrt_file_are_listed_and_grids_told);
    tcase_add_test(cases, values_that_are_no_densities_have_no_optical_depth);
    tcase_add_test(cases, a_picture_is_told_with_channels_and_attributes);
    tcase_add_test(cases, what_cannot_be_read_gives_a_message_and_no_half_truth);
}

int main(void) { return nph_test_main("cli_info", fill); }
