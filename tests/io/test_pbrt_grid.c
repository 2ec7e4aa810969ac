/* SPDX-License-Identifier: Apache-2.0
 *
 * Density grids in pbrt's text: both versions' spellings, choice by name, and mistakes named with their line. */
#define _POSIX_C_SOURCE 200809L
#include <locale.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "harness.h"
#include "io/volume.h"

static const char *write_text(const char *text, size_t size) {
    const char *path = nph_test_temporary("file.pbrt");
    FILE *file = fopen(path, "wb");
    ck_assert_ptr_nonnull(file);
    ck_assert_uint_eq(fwrite(text, 1, size, file), size);
    ck_assert_int_eq(fclose(file), 0);
    return path;
}

static NphStatus read_text(NphContext *context, const char *text, const char *name, NphBoxGrid *grid) {
    return nph_pbrt_read(context, write_text(text, strlen(text)), name, grid);
}

static const char v4[] =
    "# a scene\n"
    "LookAt 3 4 .5  .5 .5 0  0 0 1 # outside the world\n"
    "Camera \"perspective\" \"float fov\" 45\n"
    "Film \"rgb\" \"string filename\" \"a # b.exr\" \"integer xresolution\" [ 400 ]\n"
    "WorldBegin\n"
    "MakeNamedMedium \"air\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [ .1 .2 .3 ]\n"
    "MakeNamedMedium \"cloud\" \"string type\" \"uniformgrid\"\n"
    "   \"integer nx\" 2 \"integer ny\" [3] # comment ] \" here\n"
    "   \"float density\" [\n"
    "      0 0.5 1e0 1.5\t2 2.5\r\n"
    "      # half way\n"
    "      3 3.5 4 4.5 5 5.5 ]\n"
    "   \"spectrum sigma_s\" \"metal\\\"X\" \"bool unused\" true\n"
    "   \"integer nz\" [ 2 ] \"point3 p1\" [ 1 2 3 ] \"point3 p0\" [ -1 -2 -3e0 ]\n"
    "AttributeBegin\n"
    "  MediumInterface \"cloud\" \"\"\n"
    "  Shape \"sphere\" \"float radius\" 1\n"
    "AttributeEnd\n";

START_TEST(a_pbrt_4_medium_is_read_with_its_box_and_x_fastest) {
    NphContext *context = nph_test_context(1);
    static const int64_t shape[3] = {2, 3, 2};
    static const double lo[3] = {-1, -2, -3}, hi[3] = {1, 2, 3};
    for (int i = 0; i < 2; i++) {
        NphBoxGrid grid = {0};
        ck_assert_int_eq(read_text(context, v4, i ? "cloud" : NULL, &grid), NPH_OK);
        ck_assert_int_eq(grid.values.type, NPH_F32);
        ck_assert_int_eq(grid.values.rank, 3);
        ck_assert_mem_eq(grid.values.shape, shape, sizeof shape);
        ck_assert_mem_eq(grid.lo, lo, sizeof lo);
        ck_assert_mem_eq(grid.hi, hi, sizeof hi);
        for (int n = 0; n < 12; n++) ck_assert(((float *)grid.values.data)[n] == 0.5f * (float)n);
        nph_box_grid_free(context, &grid);
    }
    ck_assert_str_eq(nph_test_messages(), "");
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_pbrt_3_medium_is_read_and_its_box_defaults_to_the_unit_cube) {
    NphContext *context = nph_test_context(1);
    NphBoxGrid grid = {0};
    ck_assert_int_eq(read_text(context, "MakeNamedMedium \"m\" \"string type\" \"heterogeneous\" \"integer nx\" [1]\n"
                                        "\"integer ny\" 1 \"integer nz\" 3 \"point p1\" [1 1 2] \"float density\" [1 2 3]",
                               NULL, &grid), NPH_OK);
    ck_assert_int_eq(grid.values.shape[0], 3);
    ck_assert(grid.lo[2] == 0 && grid.hi[2] == 2 && grid.hi[0] == 1);
    ck_assert(((float *)grid.values.data)[2] == 3);
    nph_box_grid_free(context, &grid);
    ck_assert_int_eq(read_text(context, "MakeNamedMedium \"m\" \"string type\" [\"uniformgrid\"] \"float density\" 7", NULL, &grid), NPH_OK);
    ck_assert_int_eq(nph_array_count(&grid.values), 1);
    ck_assert(((float *)grid.values.data)[0] == 7);
    nph_box_grid_free(context, &grid);
    nph_test_context_close(context);
}
END_TEST

START_TEST(numbers_do_not_depend_on_the_locale) {
    static const char *const locales[] = {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8"};
    int set = 0;
    for (int i = 0; i < 3 && !set; i++) set = setlocale(LC_ALL, locales[i]) != NULL;
    if (!set) nph_test_skip("pbrt numbers in another locale: none with a decimal comma is installed");
    NphContext *context = nph_test_context(1);
    NphBoxGrid grid = {0};
    ck_assert_int_eq(read_text(context, v4, NULL, &grid), NPH_OK);
    ck_assert(((float *)grid.values.data)[1] == 0.5f);
    nph_box_grid_free(context, &grid);
    nph_test_context_close(context);
    setlocale(LC_ALL, "C");
}
END_TEST

START_TEST(the_list_names_every_medium) {
    NphContext *context = nph_test_context(1);
    NphPbrtInfo *media = NULL;
    int count = 0;
    ck_assert_int_eq(nph_pbrt_list(context, write_text(v4, strlen(v4)), &media, &count), NPH_OK);
    ck_assert_int_eq(count, 2);
    ck_assert_str_eq(media[0].name, "air");
    ck_assert_str_eq(media[0].type, "homogeneous");
    ck_assert_int_eq(media[0].readable, 0);
    ck_assert_str_eq(media[1].name, "cloud");
    ck_assert_int_eq(media[1].readable, 1);
    nph_free(context, media);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_transform_before_a_medium_is_warned_of) {
    NphContext *context = nph_test_context(1);
    NphBoxGrid grid = {0};
    static const char medium[] = "MakeNamedMedium \"m\" \"string type\" \"uniformgrid\" \"float density\" [1]\n";
    static const char *const before[] = {"", "Scale 2 2 2\nWorldBegin\n", "WorldBegin\nScale 2 2 2\n", "Rotate 1 0 0 1 "};
    for (int i = 0; i < 4; i++) {
        char text[400];
        snprintf(text, sizeof text, "%s%s", before[i], medium);
        ck_assert_int_eq(read_text(context, text, "m", &grid), NPH_OK);
        ck_assert_int_eq(strstr(nph_test_messages(), "not applied") != NULL, i >= 2);
        nph_box_grid_free(context, &grid);
    }
    nph_test_context_close(context);
}
END_TEST

#define M "MakeNamedMedium \"m\" \"string type\" \"uniformgrid\" "
static const struct {
    const char *text, *name, *message;
} mistakes[] = {
    {"", NULL, "is empty"},
    {"# nothing\n", NULL, "it holds no medium"},
    {M "\"float density\" [1]", "fog", "has no medium 'fog'; it holds 'm' (uniformgrid)"},
    {"Include \"a.pbrt\"\n" M "\"float density\" [1]", "fog", "includes are not read"},
    {M "\"float density\" [1] " M "\"float density\" [2]", "m", "has 2 media named 'm'"},
    {M "\"float density\" [1] MakeNamedMedium \"b\" \"string type\" \"uniformgrid\" \"float density\" 1", NULL,
     "has no medium 'density' of type uniformgrid or heterogeneous (the default; choose one by name)"},
    {"MakeNamedMedium \"m\" \"string type\" \"rgbgrid\"", "m", ":1: the medium 'm' is of the type 'rgbgrid'"},
    {"\n" M "\"float\n", NULL, ":2: a quoted text does not end"},
    {"\nMakeNamedMedium m", NULL, ":2: MakeNamedMedium is not followed"},
    {"MakeNamedMedium", NULL, "is not followed"},
    {M "\"density\" [1]", NULL, "stands where a parameter"},
    {M "\"float density extra\" [1]", NULL, "stands where a parameter"},
    {M "\"float density\"", NULL, "has no value"},
    {M "\n\"float density\" [ 1\n2\n", NULL, ":4: the file ends within the list of \"float density\", which began in line 2"},
    {M "\"float density\" [ 1 [ 2 ] ]", NULL, "a second ["},
    {M "\"float density\" ]", NULL, "has no value"},
    {M "\"float density\" [ 1 2 ]", NULL, "'m' has 2 density values; nx ny nz = 1 x 1 x 1"},
    {M "\"float density\" []", NULL, "'m' has 0 density values"},
    {M "\"integer nx\" 3 \"float density\" [1 2]", NULL, "nx ny nz = 3 x 1 x 1"},
    {M "\"integer nx\" 2147483647 \"integer ny\" 2147483647 \"integer nz\" 2147483647 \"float density\" [1 2]", NULL,
     "has 2 density values"},
    {M "\"integer nx\" 2147483648 \"float density\" [1 2]", NULL, "whole number from 1"},
    {M "\"integer nx\" 0", NULL, "whole number from 1"},
    {M "\"integer nx\" 1.0", NULL, "whole number from 1"},
    {M "\"integer nx\" \"1\"", NULL, "whole number from 1"},
    {M "\"integer nx\" [1 1]", NULL, "\"integer nx\" has 2 values; 1 is right"},
    {M "\"integer nx\" 1 \"integer nx\" 1", NULL, "given a second time"},
    {M "\"point3 p0\" [0 0]", NULL, "\"point3 p0\" has 2 values; 3 is right"},
    {M "\"point3 p0\" [0 0 x]", NULL, "corner of the box is 'x'"},
    {M "\"point3 p0\" [0 1 0] \"float density\" 1", NULL, "from 1 to 1 along y is no rising range"},
    {M "\"point3 p0\" [0 0 0] \"point p0\" [0 0 0]", NULL, "given a second time"},
    {M "\"float density\" [1] \"float density\" [1]", NULL, "given a second time"},
    {M "\"string type\" \"uniformgrid\"", NULL, "given a second time"},
    {M "\"integer nx\" 2 \"float density\" [1\n\n0,5]", NULL, ":3: a density is '0,5', not a finite number"},
    {M "\"integer nx\" 2 \"float density\" [1 nan]", NULL, "'nan'"},
    {M "\"integer nx\" 2 \"float density\" [1 \"2\"]", NULL, "'2', not a finite number"},
    {M "\"integer nx\" 2 \"float density\" [1 \n 1e39]", NULL, ":2: density value 2 lies beyond"},
    {M, NULL, "has no \"float density\""},
};

START_TEST(mistakes_are_named_with_their_line) {
    NphContext *context = nph_test_context(1);
    NphBoxGrid grid = {.lo = {7, 7, 7}};
    ck_assert_int_eq(read_text(context, mistakes[_i].text, mistakes[_i].name, &grid), NPH_BAD_INPUT);
    ck_assert(grid.lo[0] == 7);
    const char *messages = nph_test_messages();
    const char *wanted = strcmp(mistakes[_i].message, "includes are not read") == 0 ? "(the files it includes are not read)"
                                                                                    : mistakes[_i].message;
    ck_assert_msg(strstr(messages, "file.pbrt") && strstr(messages, wanted), "no '%s' in: %s", wanted, messages);
    nph_test_context_close(context);
}
END_TEST

START_TEST(cut_and_altered_texts_are_refused_or_read_without_a_leak) {
    NphContext *context = nph_test_context(1);
    size_t size = strlen(v4);
    char *text = malloc(size);
    uint32_t state = 7;
    int ok = 0, bad = 0;
    for (size_t i = 0; i < size + 2000; i++) {
        NphBoxGrid grid = {0};
        memcpy(text, v4, size);
        state = state * 1664525u + 1013904223u;
        if (i >= size) text[(state >> 8) % size] ^= (char)(1 << (state >> 29));
        NphStatus status = nph_pbrt_read(context, write_text(text, i < size ? i : size), NULL, &grid);
        ck_assert(status == NPH_OK || status == NPH_BAD_INPUT);
        *(status == NPH_OK ? &ok : &bad) += 1;
        nph_box_grid_free(context, &grid);
        nph_test_messages();
    }
    ck_assert_int_gt(ok, 100);
    ck_assert_int_gt(bad, 100);
    ck_assert_uint_lt(nph_context_peak_bytes(context), 1u << 18);
    free(text);
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, a_pbrt_4_medium_is_read_with_its_box_and_x_fastest);
    tcase_add_test(cases, a_pbrt_3_medium_is_read_and_its_box_defaults_to_the_unit_cube);
    tcase_add_test(cases, numbers_do_not_depend_on_the_locale);
    tcase_add_test(cases, the_list_names_every_medium);
    tcase_add_test(cases, a_transform_before_a_medium_is_warned_of);
    tcase_add_loop_test(cases, mistakes_are_named_with_their_line, 0, (int)(sizeof mistakes / sizeof *mistakes));
    tcase_add_test(cases, cut_and_altered_texts_are_refused_or_read_without_a_leak);
}

int main(void) { return nph_test_main("pbrt_grid", fill); }
