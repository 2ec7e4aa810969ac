/* SPDX-License-Identifier: Apache-2.0
 *
 * FLIP against the authors' own evaluator, and what must hold of it whatever the pictures. */
#include <math.h>
#include <string.h>

#include "nephos/flip.h"
#include "oracle/flip_parts.h"
#include "pictures.h"

enum { ACROSS = 64, DOWN = 48 };

/* Pictures that any program can make again: every value is a multiple of a power of two. */
typedef double (*PixelFn)(int x, int y, int c);

static double steps(int x, int y, int c) { return ((3 * x + 2 * y + 11 * c * (x / 16)) % 128 + 1) / 128.0; }
static int pattern(int x, int y, int c) { return (x * x + 3 * y * y + 5 * c) % 16 - 8; }
static double gain(int x, int y) { return ldexp(1.0, (x / 8 + y / 12) % 6 - 1); }

static double patterned(int x, int y, int c) {
    double value = steps(x, y, c) + pattern(x, y, c) / 256.0;
    return value < 0.0 ? 0.0 : value > 1.0 ? 1.0 : value;
}
static double dimmed(int x, int y, int c) { return 0.75 * steps(x, y, c); }
static double shifted(int x, int y, int c) { return steps(x + 1, y, c); }
static double bright(int x, int y, int c) { return steps(x, y, c) * gain(x, y); }
static double bright_patterned(int x, int y, int c) { return bright(x, y, c) * (1.0 + pattern(x, y, c) / 64.0); }
static double bright_dimmed(int x, int y, int c) { return 0.75 * bright(x, y, c); }
static double bright_shifted(int x, int y, int c) { return bright(x + 1, y, c); }
static double black(int x, int y, int c) { return 0.0 * (x + y + c); }

static NphImage paint(int width, int height, PixelFn pixel) {
    static const char *const names[3] = {"R", "G", "B"};
    NphImage image;
    float *plane;
    ck_assert_int_eq(nph_image_new(context, width, height, &image), NPH_OK);
    for (int c = 0; c < 3; c++) {
        ck_assert_int_eq(nph_image_add_channel(context, &image, names[c], &plane), NPH_OK);
        for (int i = 0; i < width * height; i++) plane[i] = (float)pixel(i % width, i / width, c);
    }
    return image;
}

static NphFlip flip_images(const NphImage *a, const NphImage *b, const NphFlipOptions *options) {
    NphFlip flip;
    ck_assert_int_eq(nph_flip(context, a, b, options, &flip, NULL), NPH_OK);
    return flip;
}

static NphFlip flip_painted(PixelFn candidate, PixelFn reference, const NphFlipOptions *options) {
    NphImage a = paint(ACROSS, DOWN, candidate), b = paint(ACROSS, DOWN, reference);
    NphFlip flip = flip_images(&a, &b, options);
    nph_image_free(context, &a);
    nph_image_free(context, &b);
    return flip;
}

static NphFlipOptions of_kind(NphFlipKind kind) {
    NphFlipOptions options;
    nph_flip_options_default(&options);
    options.kind = kind;
    return options;
}

/* Means of flip-evaluator 1.7 (PyPI, the authors' code in single precision) on the same pictures, LDR with
 * inputsRGB=False, pixels per degree and exposures given. */
static const struct {
    NphFlipKind kind;
    PixelFn candidate;
    double pixels_per_degree;
    int exposures;
    double mean;
} published[] = {
    {NPH_FLIP_LDR, patterned, 67.02, 0, 0.078447}, {NPH_FLIP_LDR, patterned, 30, 0, 0.100657},
    {NPH_FLIP_LDR, dimmed, 67.02, 0, 0.386841},    {NPH_FLIP_LDR, dimmed, 30, 0, 0.373814},
    {NPH_FLIP_LDR, shifted, 67.02, 0, 0.248671},   {NPH_FLIP_LDR, shifted, 30, 0, 0.250583},
    {NPH_FLIP_HDR, bright_patterned, 67.02, 0, 0.089672}, {NPH_FLIP_HDR, bright_patterned, 67.02, 4, 0.090339},
    {NPH_FLIP_HDR, bright_dimmed, 67.02, 0, 0.289938},    {NPH_FLIP_HDR, bright_dimmed, 67.02, 4, 0.292067},
    {NPH_FLIP_HDR, bright_shifted, 67.02, 0, 0.301149},   {NPH_FLIP_HDR, bright_shifted, 67.02, 4, 0.300548},
};

START_TEST(means_are_those_of_the_authors_evaluator) {
    for (size_t i = 0; i < sizeof published / sizeof published[0]; i++) {
        NphFlipOptions options = of_kind(published[i].kind);
        options.pixels_per_degree = published[i].pixels_per_degree;
        options.exposures = published[i].exposures;
        if (options.exposures) {
            options.start_stops = -2.0;
            options.stop_stops = 3.0;
        }
        NphFlip flip = flip_painted(published[i].candidate, options.kind == NPH_FLIP_LDR ? steps : bright, &options);
        printf("    %zu: %.6f, the authors' %.6f\n", i, flip.mean, published[i].mean);
        ck_assert_double_eq_tol(flip.mean, published[i].mean, 2e-5); /* single precision, and matrices of fewer digits */
    }
}
END_TEST

START_TEST(equal_pictures_are_0_and_so_are_black_ones) {
    for (int kind = 0; kind < 2; kind++) {
        NphFlipOptions options = of_kind(kind ? NPH_FLIP_LDR : NPH_FLIP_HDR);
        PixelFn painted[2] = {steps, black};
        for (int i = 0; i < 2; i++) {
            NphFlip flip = flip_painted(painted[i], painted[i], &options);
            ck_assert_double_eq(flip.mean, 0.0);
            ck_assert_double_eq(flip.largest, 0.0);
            ck_assert_str_eq(flip.noise_unknown, "every pixel is equal");
        }
    }
}
END_TEST

START_TEST(the_order_of_the_pictures_does_not_matter_with_equal_exposures) {
    NphFlipOptions options = of_kind(NPH_FLIP_LDR);
    ck_assert_double_eq(flip_painted(patterned, steps, &options).mean, flip_painted(steps, patterned, &options).mean);
    options = of_kind(NPH_FLIP_HDR);
    options.exposures = 3;
    options.stop_stops = 2.0;
    ck_assert_double_eq(flip_painted(dimmed, steps, &options).mean, flip_painted(steps, dimmed, &options).mean);
}
END_TEST

static double contrast;
static double faded(int x, int y, int c) { return 0.5 + contrast * (steps(x, y, c) - 0.5); }

START_TEST(more_contrast_lost_is_a_larger_difference) {
    NphFlipOptions options = of_kind(NPH_FLIP_LDR);
    double before = 0.0;
    for (int i = 9; i >= 0; i--) {
        contrast = i / 10.0;
        double mean = flip_painted(faded, steps, &options).mean;
        ck_assert_double_gt(mean, before);
        before = mean;
    }
}
END_TEST

static double fine(int x, int y, int c) { return ((x + y) % 2 + 0 * c) * 0.5; }
static double fine_shifted(int x, int y, int c) { return fine(x + 1, y, c); }

START_TEST(a_shift_of_details_too_fine_to_see_is_no_difference) {
    NphFlipOptions options = of_kind(NPH_FLIP_LDR);
    options.pixels_per_degree = 20.0;
    double near = flip_painted(fine_shifted, fine, &options).mean;
    options.pixels_per_degree = 200.0;
    double far = flip_painted(fine_shifted, fine, &options).mean;
    ck_assert_double_gt(near, 0.05);
    ck_assert_double_lt(far, 0.01);
}
END_TEST

static double green(int x, int y, int c) { return c == 1 ? 1.0 : black(x, y, c); }
static double blue(int x, int y, int c) { return c == 2 ? 1.0 : black(x, y, c); }
static double white(int x, int y, int c) { return 1.0 + black(x, y, c); }

START_TEST(flat_colours_differ_by_their_distance_alone) {
    NphFlipOptions options = of_kind(NPH_FLIP_LDR);
    ck_assert_double_eq_tol(flip_painted(green, blue, &options).mean, 1.0, 1e-12);
    /* L* from 0 to 100 and no hue: 100^0.7 = 25.12 of the 41.28 between green and blue [Andersson20 section 4.1.3] */
    double most = 41.2760, at = 0.4 * most, expected = 0.95 + 0.05 * (pow(100.0, 0.7) - at) / (most - at);
    ck_assert_double_eq_tol(flip_painted(white, black, &options).mean, expected, 1e-4);
}
END_TEST

START_TEST(exposures_show_the_brightest_and_the_median_lit_pixel_at_85_percent) {
    double shown = nph_flip_aces_inverse(0.85);
    ck_assert_double_eq_tol(nph_flip_aces(shown), 0.85, 1e-14);
    NphImage a = paint(5, 2, white), b = paint(5, 2, black);
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < 5; i++) b.channels[c].pixels[i] = ldexpf(1.0f, 2 * i); /* 1, 4, 16, 64, 256; five are black */
    NphFlipOptions options = of_kind(NPH_FLIP_HDR);
    NphFlip flip = flip_images(&a, &b, &options);
    ck_assert_int_eq(flip.exposures, 4);
    ck_assert_double_eq_tol(flip.start_stops, log2(shown) - 8.0, 1e-12);
    ck_assert_double_eq_tol(flip.stop_stops, log2(shown) - 4.0, 1e-12);
    for (int c = 0; c < 3; c++) b.channels[c].pixels[4] = 0.0f; /* an even number: the mean of 4 and 16 */
    flip = flip_images(&a, &b, &options);
    ck_assert_double_eq_tol(flip.stop_stops, log2(shown / 10.0), 1e-12);
    ck_assert_int_eq(flip.exposures, 3);
    nph_image_free(context, &a);
    nph_image_free(context, &b);
}
END_TEST

static NphImage map_with_threads(int threads, NphFlip *flip) {
    NphContext *own = nph_test_context(threads), *kept = context;
    NphFlipOptions options = of_kind(NPH_FLIP_HDR);
    NphImage map, copy = paint(131, 97, black);
    context = own;
    NphImage a = paint(131, 97, bright_patterned), b = paint(131, 97, bright);
    ck_assert_int_eq(nph_flip(own, &a, &b, &options, flip, &map), NPH_OK);
    memcpy(copy.channels[0].pixels, nph_image_channel(&map, "FLIP")->pixels, 131 * 97 * sizeof(float));
    nph_image_free(own, &map);
    nph_image_free(own, &a);
    nph_image_free(own, &b);
    nph_test_context_close(own);
    context = kept;
    return copy;
}

START_TEST(threads_do_not_change_a_bit_and_the_map_holds_mean_and_largest) {
    NphFlip flip[2];
    NphImage one = map_with_threads(1, &flip[0]), three = map_with_threads(3, &flip[1]);
    const float *map = one.channels[0].pixels;
    ck_assert_mem_eq(map, three.channels[0].pixels, 131 * 97 * sizeof *map);
    ck_assert_double_eq(flip[0].mean, flip[1].mean);
    double sum = 0.0;
    for (int i = 0; i < 131 * 97; i++) sum += (double)map[i];
    ck_assert_double_eq_tol(sum / (131 * 97), flip[0].mean, 1e-7);
    ck_assert_float_eq(map[flip[0].largest_y * 131 + flip[0].largest_x], (float)flip[0].largest);
    nph_image_free(context, &one);
    nph_image_free(context, &three);
}
END_TEST

/* Of 64 Gaussian samples a pixel: FLIP of two such pictures is what the noise alone was said to give; the mean over 2496
 * pixels scatters by about 1% of itself (seeds 1 to 12). */
START_TEST(noise_alone_is_foretold_and_a_real_difference_exceeds_it) {
    NphFlipOptions options = of_kind(NPH_FLIP_HDR);
    for (uint32_t seed = 1; seed <= 3; seed++) {
        NphImage a = noisy(2 * seed, 64, 1.0), b = noisy(2 * seed + 1, 64, 1.0);
        NphFlip flip = flip_images(&a, &b, &options);
        ck_assert_ptr_null(flip.noise_unknown);
        printf("    mean %.4f, noise alone %.4f\n", flip.mean, flip.noise_mean);
        ck_assert_double_eq_tol(flip.mean, flip.noise_mean, 0.05 * flip.mean);
        brighten(&a, 1.3);
        flip = flip_images(&a, &b, &options);
        ck_assert_double_gt(flip.mean, 1.2 * flip.noise_mean);
        nph_image_free(context, &a);
        nph_image_free(context, &b);
    }
}
END_TEST

START_TEST(noise_that_cannot_be_told_is_unknown_and_says_why) {
    NphFlipOptions options = of_kind(NPH_FLIP_HDR);
    ck_assert_str_eq(flip_painted(bright_dimmed, bright, &options).noise_unknown, "no variances");
    NphImage a = noisy(1, 64, 1.0), b = noisy(2, 64, 1.0);
    mark_paired(&a, &b);
    NphFlip flip = flip_images(&a, &b, &options);
    ck_assert_str_eq(flip.noise_unknown, "the pictures share their random numbers");
    ck_assert_double_eq(flip.noise_mean, 0.0);
    nph_image_free(context, &a);
    nph_image_free(context, &b);
}
END_TEST

static void refuse(const NphImage *a, const NphImage *b, const NphFlipOptions *options, NphStatus status, const char *said) {
    NphFlip flip;
    ck_assert_int_eq(nph_flip(context, a, b, options, &flip, NULL), status);
    const char *messages = nph_test_messages();
    ck_assert_msg(strstr(messages, said) != NULL, "\"%s\" is not in: %s", said, messages);
}

START_TEST(what_cannot_be_compared_is_refused) {
    NphFlipOptions hdr = of_kind(NPH_FLIP_HDR), ldr = of_kind(NPH_FLIP_LDR);
    NphImage a = paint(ACROSS, DOWN, bright), b = paint(ACROSS, DOWN, steps), small = paint(ACROSS, 8, steps);
    refuse(&a, &small, &hdr, NPH_BAD_INPUT, "only equal sizes");
    refuse(&a, &b, &ldr, NPH_BAD_INPUT, "picture A: channel R is ");
    ldr.exposures = 1;
    ck_assert_double_gt(flip_images(&a, &b, &ldr).mean, 0.0);
    ldr.exposures = 2;
    refuse(&a, &b, &ldr, NPH_BAD_USAGE, "at most 1");
    hdr.exposures = 3;
    hdr.start_stops = 1.0;
    refuse(&a, &b, &hdr, NPH_BAD_USAGE, "they rise");
    hdr = of_kind(NPH_FLIP_HDR);
    hdr.pixels_per_degree = NAN;
    refuse(&a, &b, &hdr, NPH_BAD_USAGE, "pixels per degree");
    b.channels[1].pixels[70] = NAN;
    hdr = of_kind(NPH_FLIP_HDR);
    refuse(&a, &b, &hdr, NPH_BAD_INPUT, "picture B: channel G is NaN at pixel (6, 1)");
    nph_image_free(context, &a);
    nph_image_free(context, &b);
    nph_image_free(context, &small);
}
END_TEST

static void fill(TCase *cases) {
    distribution_make(&gaussian, "gaussian", gaussian_quantile);
    tcase_add_checked_fixture(cases, open_context, close_context);
    tcase_add_test(cases, means_are_those_of_the_authors_evaluator);
    tcase_add_test(cases, equal_pictures_are_0_and_so_are_black_ones);
    tcase_add_test(cases, the_order_of_the_pictures_does_not_matter_with_equal_exposures);
    tcase_add_test(cases, more_contrast_lost_is_a_larger_difference);
    tcase_add_test(cases, a_shift_of_details_too_fine_to_see_is_no_difference);
    tcase_add_test(cases, flat_colours_differ_by_their_distance_alone);
    tcase_add_test(cases, exposures_show_the_brightest_and_the_median_lit_pixel_at_85_percent);
    tcase_add_test(cases, threads_do_not_change_a_bit_and_the_map_holds_mean_and_largest);
    tcase_add_test(cases, noise_alone_is_foretold_and_a_real_difference_exceeds_it);
    tcase_add_test(cases, noise_that_cannot_be_told_is_unknown_and_says_why);
    tcase_add_test(cases, what_cannot_be_compared_is_refused);
}

int main(void) { return nph_test_main("flip", fill); }
