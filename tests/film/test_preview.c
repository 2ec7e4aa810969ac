/* SPDX-License-Identifier: Apache-2.0
 *
 * Previews: the sRGB curve, the exposure, and pictures that have none. */
#include <math.h>
#include <xxhash.h>

#include "core/memory.h"
#include "film_samples.h"
#include "io/file.h"

/* A row of pixels with given radiance in all channels, as a film. */
static const double *row;
static double row_sample(int x, int y, int64_t sample, int field) {
    (void)y, (void)sample;
    return field <= NPH_SAMPLE_L2 ? row[x] : 0;
}

static void show(const double *radiance, int count, double stops, uint8_t *rgb) {
    NphContext *context = nph_test_context(1);
    Shape shape = {count, 1, {0, 0, count, 1}, 1, 0, 16};
    int width, height;
    row = radiance;
    NphFilm *film = full_film(context, &shape, 64, row_sample);
    ck_assert_int_eq(nph_film_preview(context, film, stops, rgb, &width, &height), NPH_OK);
    ck_assert(width == count && height == 1);
    nph_film_free(context, film);
    nph_test_context_close(context);
}

static double srgb_of(double linear) {
    double clipped = linear < 0 ? 0 : linear > 1 ? 1 : linear;
    return 255 * (clipped <= 0.0031308 ? 12.92 * clipped : 1.055 * pow(clipped, 1 / 2.4) - 0.055);
}

START_TEST(levels_are_the_srgb_curve_rounded) {
    enum { N = 4000 };
    static double radiance[N];
    static uint8_t rgb[3 * N];
    for (int i = 0; i < N; i++) radiance[i] = 1.1 * pow(hash_uniform(1, (uint64_t)i, 5), 3) - 0.01;
    show(radiance, N, 0, rgb);
    for (int i = 0; i < N; i++) {
        double level = srgb_of(radiance[i]);
        ck_assert_msg(fabs(rgb[3 * i] - level) <= 0.5 + 1e-3, "%g is shown as %d, not %g", radiance[i], rgb[3 * i],
                      level);
        ck_assert(rgb[3 * i] == rgb[3 * i + 1] && rgb[3 * i] == rgb[3 * i + 2]);
    }
}
END_TEST

START_TEST(every_level_is_reached_and_every_stop_doubles) {
    double radiance[256], scaled[256];
    uint8_t rgb[3 * 256], shifted[3 * 256];
    for (int v = 0; v < 256; v++) {
        double u = v / 255.0;
        radiance[v] = u <= 0.04045 ? u / 12.92 : pow((u + 0.055) / 1.055, 2.4);
        scaled[v] = radiance[v] / pow(2, -2.5);
    }
    show(radiance, 256, 0, rgb);
    show(scaled, 256, -2.5, shifted);
    for (int v = 0; v < 256; v++) ck_assert(rgb[3 * v] == v && shifted[3 * v] == v);
}
END_TEST

START_TEST(automatic_exposure_shows_the_99th_percentile_as_0_8) {
    double radiance[300];
    uint8_t rgb[3 * 300];
    int wanted = (int)floor(srgb_of(0.8) + 0.5);
    for (int i = 0; i < 300; i++) radiance[i] = 1e-30 * (1 + (i * 7) % 300);
    show(radiance, 300, (double)NAN, rgb);
    for (int i = 0; i < 300; i++) {
        int rank = 1 + (i * 7) % 300; /* the 297th of 300 is the percentile */
        if (rank == 297) ck_assert_int_eq(rgb[3 * i], wanted);
        if (rank < 290) ck_assert_int_lt(rgb[3 * i], wanted);
        ck_assert_msg(fabs(rgb[3 * i] - srgb_of(0.8 * rank / 297)) <= 0.501, "rank %d: %d", rank, rgb[3 * i]);
    }
}
END_TEST

START_TEST(dark_pictures_are_black_and_a_single_light_is_still_seen) {
    double radiance[300] = {0};
    uint8_t rgb[3 * 300];
    show(radiance, 300, (double)NAN, rgb);
    for (int i = 0; i < 900; i++) ck_assert_int_eq(rgb[i], 0);
    radiance[17] = 1e-310;
    show(radiance, 300, (double)NAN, rgb);
    for (int i = 0; i < 300; i++) ck_assert_int_eq(rgb[3 * i], i == 17 ? (int)floor(srgb_of(0.8) + 0.5) : 0);
    show((double[]){5}, 1, (double)NAN, rgb);
    ck_assert_int_eq(rgb[0], (int)floor(srgb_of(0.8) + 0.5));
}
END_TEST

START_TEST(what_is_not_finite_is_magenta_and_does_not_move_the_exposure) {
    double radiance[4] = {(double)NAN, 1, (double)INFINITY, 0.5};
    uint8_t rgb[12];
    show(radiance, 4, (double)NAN, rgb);
    for (int i = 0; i < 4; i += 2) ck_assert(rgb[3 * i] == 255 && rgb[3 * i + 1] == 0 && rgb[3 * i + 2] == 255);
    ck_assert_int_eq(rgb[3], (int)floor(srgb_of(0.8) + 0.5));
    ck_assert_int_eq(rgb[9], (int)floor(srgb_of(0.4) + 0.5));
}
END_TEST

static double colour_sample(int x, int y, int64_t sample, int field) {
    (void)sample;
    return field <= NPH_SAMPLE_L2 ? (field == 0 ? 0.01 * x : field == 1 ? 0.02 * y : 0.5) : 0;
}

START_TEST(colours_and_pixels_stand_where_they_belong_in_a_crop) {
    NphContext *context = nph_test_context(1);
    Shape shape = {60, 50, {10, 14, 45, 33}, 3, 0, 16};
    NphFilm *film = full_film(context, &shape, 64, colour_sample);
    static uint8_t rgb[3 * 35 * 19];
    int width = 0, height = 0;
    ck_assert_int_eq(nph_film_preview(context, film, 0, NULL, &width, &height), NPH_OK);
    ck_assert(width == 35 && height == 19);
    ck_assert_int_eq(nph_film_preview(context, film, 0, rgb, &width, &height), NPH_OK);
    for (int y = 14; y < 33; y++)
        for (int x = 10; x < 45; x++) {
            const uint8_t *pixel = rgb + 3 * ((y - 14) * 35 + x - 10);
            ck_assert(fabs(pixel[0] - srgb_of(0.01 * x)) < 0.51 && fabs(pixel[1] - srgb_of(0.02 * y)) < 0.51 &&
                      fabs(pixel[2] - srgb_of(0.5)) < 0.51);
        }
    nph_film_free(context, film);
    nph_test_context_close(context);
}
END_TEST

START_TEST(the_levels_are_the_same_with_every_compiler) {
    NphContext *context = nph_test_context(1);
    Shape shape = {64, 64, {0, 0, 64, 64}, 3, 0, 32};
    static uint8_t rgb[3 * 64 * 64];
    static const double stops[3] = {(double)NAN, -1.3, 0.7};
    NphFilm *film = full_film(context, &shape, 32, plain_sample);
    XXH64_hash_t digest = 0;
    for (int i = 0; i < 3; i++) {
        int width, height;
        ck_assert_int_eq(nph_film_preview(context, film, stops[i], rgb, &width, &height), NPH_OK);
        digest = XXH3_64bits_withSeed(rgb, sizeof rgb, digest);
    }
    ck_assert_msg(digest == UINT64_C(0x88e49b95bc3533a9), "digest %016llx", (unsigned long long)digest);
    nph_film_free(context, film);
    nph_test_context_close(context);
}
END_TEST

START_TEST(the_png_is_written_with_the_same_bytes_each_time) {
    NphContext *context = nph_test_context(1);
    Shape shape = {20, 18, {1, 2, 20, 18}, 3, 0, 32};
    NphFilm *film = full_film(context, &shape, 32, plain_sample);
    char *bytes[2];
    size_t size[2];
    for (int i = 0; i < 2; i++) {
        const char *path = nph_test_temporary(i ? "b.png" : "a.png");
        ck_assert_int_eq(nph_film_write_png(context, film, (double)NAN, path), NPH_OK);
        ck_assert_int_eq(nph_file_read(context, path, &bytes[i], &size[i]), NPH_OK);
    }
    ck_assert_uint_eq(size[0], size[1]);
    ck_assert_mem_eq(bytes[0], bytes[1], size[0]);
    ck_assert_mem_eq(bytes[0], "\x89PNG\r\n\x1a\n", 8);
    ck_assert_mem_eq(bytes[0] + 16, "\0\0\0\x13\0\0\0\x10", 8);
    nph_free(context, bytes[0]);
    nph_free(context, bytes[1]);
    ck_assert_int_eq(nph_film_write_png(context, film, 101, nph_test_temporary("c.png")), NPH_BAD_USAGE);
    ck_assert_int_eq(nph_film_write_png(context, film, -(double)INFINITY, nph_test_temporary("c.png")), NPH_BAD_USAGE);
    nph_film_free(context, film);
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, levels_are_the_srgb_curve_rounded);
    tcase_add_test(cases, every_level_is_reached_and_every_stop_doubles);
    tcase_add_test(cases, automatic_exposure_shows_the_99th_percentile_as_0_8);
    tcase_add_test(cases, dark_pictures_are_black_and_a_single_light_is_still_seen);
    tcase_add_test(cases, what_is_not_finite_is_magenta_and_does_not_move_the_exposure);
    tcase_add_test(cases, colours_and_pixels_stand_where_they_belong_in_a_crop);
    tcase_add_test(cases, the_levels_are_the_same_with_every_compiler);
    tcase_add_test(cases, the_png_is_written_with_the_same_bytes_each_time);
}

int main(void) { return nph_test_main("preview", fill); }
