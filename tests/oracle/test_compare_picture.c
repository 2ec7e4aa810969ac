/* SPDX-License-Identifier: Apache-2.0
 *
 * The picture of a comparison: its layout, its colours at known places, and that its words can be read. */
#include <string.h>

#include "core/memory.h"
#include "oracle/compare_picture.h"
#include "pictures.h"

enum { SIDE = 256, GAP = 8, TOP = 2 * GAP + NPH_GLYPH_HEIGHT };

static NphComparePicture picture_of(const NphImage *a, const NphImage *b) {
    NphFlipOptions options;
    NphFlip flip;
    NphImage map;
    NphComparePicture picture;
    nph_flip_options_default(&options);
    ck_assert_int_eq(nph_flip(context, a, b, &options, &flip, &map), NPH_OK);
    ck_assert_int_eq(nph_compare_picture(context, a, b, &flip, &map, &picture), NPH_OK);
    nph_image_free(context, &map);
    return picture;
}

static const uint8_t *at(const NphComparePicture *picture, int panel, int x, int y) {
    return picture->rgb + 3 * ((TOP + y) * picture->width + GAP + panel * (SIDE + GAP) + x);
}

static void set(NphImage *image, int x, int y, float value) {
    for (int c = 0; c < 3; c++)
        synthetic_plane(image, synthetic_names[c][0])[y * image->width + x] = value;
}

START_TEST(panels_show_the_pictures_and_the_sign_of_their_difference) {
    NphImage a = flat(SIDE, SIDE, 0.5, 0), b = flat(SIDE, SIDE, 0.5, 0);
    for (int y = 0; y < 64; y++)
        for (int x = 0; x < SIDE; x++) set(&a, x, y, x < 128 ? 1.0f : 0.25f);
    NphComparePicture picture = picture_of(&a, &b);
    ck_assert_int_eq(picture.width, 4 * SIDE + 5 * GAP);
    ck_assert_int_eq(picture.height, TOP + SIDE + 3 * GAP + 2 * NPH_GLYPH_HEIGHT);
    /* 0.8 in sRGB is 0.9063 */
    for (int c = 0; c < 3; c++) ck_assert_int_eq(at(&picture, 0, 10, 200)[c], 231);
    for (int c = 0; c < 3; c++) ck_assert_int_eq(at(&picture, 1, 10, 10)[c], 255);
    ck_assert_int_lt(at(&picture, 1, 200, 10)[0], 200);
    const uint8_t *brighter = at(&picture, 2, 10, 10), *darker = at(&picture, 2, 200, 10), *equal = at(&picture, 2, 10, 200);
    ck_assert_int_gt(brighter[0], brighter[2] + 20);
    ck_assert_int_gt(darker[2], darker[0] + 20);
    ck_assert_int_eq(equal[0], 247);
    ck_assert_int_eq(equal[2], 247);
    ck_assert_int_eq(at(&picture, 3, 10, 200)[2], 4); /* magma of 0 */
    ck_assert_int_gt(at(&picture, 3, 200, 10)[0], 50);
    nph_free(context, picture.rgb);
    nph_image_free(context, &a);
    nph_image_free(context, &b);
}
END_TEST

START_TEST(any_size_fits_and_small_ones_are_enlarged) {
    static const int sizes[][2] = {{1, 1}, {3, 2}, {1, 700}, {700, 1}, {257, 5}, {104, 24}};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        NphImage a = flat(sizes[i][0], sizes[i][1], 0.0, 0), b = flat(sizes[i][0], sizes[i][1], 1.0, 0);
        NphComparePicture picture = picture_of(&a, &b);
        ck_assert_int_ge(picture.width, 4 * SIDE);
        ck_assert_int_lt(picture.height, 2500);
        nph_free(context, picture.rgb);
        picture = picture_of(&b, &a); /* a black reference */
        nph_free(context, picture.rgb);
        nph_image_free(context, &a);
        nph_image_free(context, &b);
    }
}
END_TEST

START_TEST(every_letter_of_the_legends_has_its_own_shape) {
    for (int i = 0; i < nph_glyph_count; i++)
        for (int k = 0; k < i; k++) {
            ck_assert_int_ne(nph_glyphs[i].letter, nph_glyphs[k].letter);
            ck_assert_mem_ne(nph_glyphs[i].rows, nph_glyphs[k].rows, NPH_GLYPH_HEIGHT);
        }
    int found = 0;
    for (int i = 0; i < nph_glyph_count; i++) {
        found += nph_glyphs[i].letter != ' ' && strchr("ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789+-.,%/()", nph_glyphs[i].letter) != NULL;
    }
    ck_assert_int_eq(found, 26 + 10 + 8);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_checked_fixture(cases, open_context, close_context);
    tcase_add_test(cases, panels_show_the_pictures_and_the_sign_of_their_difference);
    tcase_add_test(cases, any_size_fits_and_small_ones_are_enlarged);
    tcase_add_test(cases, every_letter_of_the_legends_has_its_own_shape);
}

int main(void) { return nph_test_main("compare_picture", fill); }
