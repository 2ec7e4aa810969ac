/* SPDX-License-Identifier: Apache-2.0
 *
 * The layers of a picture against the samples they come from. */
#include <float.h>
#include <math.h>
#include <xxhash.h>

#include "film_samples.h"

static float pixel_of(const NphImage *image, const char *name, int x, int y) {
    const NphChannel *channel = nph_image_channel(image, name);
    ck_assert_msg(channel != NULL, "no layer %s", name);
    return channel->pixels[(y - image->y0) * image->width + x - image->x0];
}

static NphImage image_of(NphContext *context, const NphFilm *film) {
    NphImage image;
    ck_assert_int_eq(nph_film_image(context, film, &image), NPH_OK);
    return image;
}

/* Radiance as plain_sample; a path's order times its luminance. */
static double path_sample(int x, int y, int64_t sample, int field) {
    if (field != NPH_SAMPLE_ORDER) return plain_sample(x, y, sample, field);
    double luminance = 0;
    for (int c = 0; c < 3; c++) luminance += nph_luminance_weights[c] * plain_sample(x, y, sample, c);
    return luminance * (double)(1 + (x + y + sample) % 5);
}

/* A float's rounding and that of the sums. */
static void check_value(const NphImage *image, const char *name, int x, int y, long double wanted) {
    float got = pixel_of(image, name, x, y);
    ck_assert_msg(fabsl(got - wanted) <= 1e-7L * fabsl(wanted), "%s at %d,%d: %.9g, not %.9Lg", name, x, y, (double)got,
                  wanted);
}

static void check_pixel(const NphImage *image, int x, int y, int64_t begin, int64_t end) {
    static const char *const letters = "RGB";
    long double n = (long double)(end - begin), luminance = 0, m[4], opacity = 0;
    for (int c = 0; c < 3; c++) {
        char name[32];
        exact_moments(x, y, c, begin, end, 64, path_sample, m);
        luminance += nph_luminance_weights[c] * m[0];
        snprintf(name, sizeof name, "%c", letters[c]);
        check_value(image, name, x, y, m[0]);
        snprintf(name, sizeof name, "Variance.%c", letters[c]);
        check_value(image, name, x, y, m[1] / (n * (n - 1)));
        snprintf(name, sizeof name, "Vov.%c", letters[c]);
        check_value(image, name, x, y, m[3] / (m[1] * m[1]) - (n - 3) / (n * (n - 1)));
        exact_moments(x, y, NPH_SAMPLE_T0 + c, begin, end, 64, path_sample, m);
        snprintf(name, sizeof name, "Transmittance.%c", letters[c]);
        check_value(image, name, x, y, m[0]);
        opacity += (1 - m[0]) / 3;
    }
    check_value(image, "A", x, y, opacity);
    check_value(image, "N", x, y, n);
    exact_moments(x, y, NPH_SAMPLE_ORDER, begin, end, 64, path_sample, m);
    check_value(image, "Order.Y", x, y, m[0] / luminance);
    long double collided[4];
    exact_moments(x, y, NPH_SAMPLE_COLLIDED, begin, end, 64, path_sample, collided);
    exact_moments(x, y, NPH_SAMPLE_DISTANCE, begin, end, 64, path_sample, m);
    check_value(image, "Z", x, y, m[0] / collided[0]);
}

START_TEST(every_layer_is_its_formula_over_the_samples) {
    NphContext *context = nph_test_context(1);
    Shape shape = {50, 40, {13, 7, 43, 22}, 3, 48, 48 + 16 * 11};
    NphFilm *film = full_film(context, &shape, 64, path_sample);
    NphImage image = image_of(context, film);
    ck_assert(image.x0 == 13 && image.y0 == 7 && image.width == 30 && image.height == 15);
    ck_assert(image.full_width == 50 && image.full_height == 40 && image.channel_count == 16);
    for (int y = 7; y < 22; y++)
        for (int x = 13; x < 43; x++) check_pixel(&image, x, y, shape.begin, shape.end);
    nph_image_free(context, &image);
    nph_film_free(context, film);
    nph_test_context_close(context);
}
END_TEST

START_TEST(the_planes_have_the_same_bytes_with_every_compiler_and_vector_level) {
    NphContext *context = nph_test_context(1);
    Shape shape = {50, 40, {13, 7, 43, 22}, 3, 48, 16 * 53};
    NphFilm *film = full_film(context, &shape, 32, path_sample);
    NphImage image = image_of(context, film);
    XXH64_hash_t digest = 0;
    for (int i = 0; i < image.channel_count; i++)
        digest = XXH3_64bits_withSeed(image.channels[i].pixels, 30 * 15 * sizeof(float), digest);
    ck_assert_msg(digest == UINT64_C(0x242f3a670848a9e5), "digest %016llx", (unsigned long long)digest);
    nph_image_free(context, &image);
    nph_film_free(context, film);
    nph_test_context_close(context);
}
END_TEST

START_TEST(texts_and_the_number_of_samples_become_attributes) {
    NphContext *context = nph_test_context(1);
    Shape shape = {20, 4, {0, 0, 20, 4}, 1, 32, 96};
    NphFilm *film = full_film(context, &shape, 32, plain_sample);
    ck_assert_int_eq(nph_film_set_text(context, film, "seed", "7"), NPH_OK);
    NphImage image = image_of(context, film);
    ck_assert_str_eq(nph_image_attribute(&image, "seed")->text, "7");
    ck_assert(nph_image_attribute(&image, "samples")->number == 64);
    ck_assert_ptr_null(nph_image_attribute(&image, "samples_least"));
    nph_image_free(context, &image);
    nph_film_free(context, film);
    nph_test_context_close(context);
}
END_TEST

START_TEST(grey_samples_give_equal_channels) {
    static const char *const groups[4][3] = {{"R", "G", "B"},
                                             {"Variance.R", "Variance.G", "Variance.B"},
                                             {"Vov.R", "Vov.G", "Vov.B"},
                                             {"Transmittance.R", "Transmittance.G", "Transmittance.B"}};
    NphContext *context = nph_test_context(1);
    Shape shape = {9, 5, {0, 0, 9, 5}, 1, 0, 48};
    NphFilm *film = full_film(context, &shape, 32, plain_sample);
    NphImage image = image_of(context, film);
    for (int g = 0; g < 4; g++)
        for (int c = 1; c < 3; c++)
            ck_assert_mem_eq(nph_image_channel(&image, groups[g][0])->pixels,
                             nph_image_channel(&image, groups[g][c])->pixels, 9 * 5 * sizeof(float));
    nph_image_free(context, &image);
    nph_film_free(context, film);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_tile_without_samples_is_zero_everywhere_and_the_counts_say_so) {
    NphContext *context = nph_test_context(1);
    Shape shape = {48, 16, {0, 0, 48, 16}, 3, 0, 64};
    NphFilm *film = empty_film(context, &shape);
    add_samples(film, 0, 64, 32, plain_sample);
    add_samples(film, 2, 48, 32, plain_sample);
    NphImage image = image_of(context, film);
    for (int i = 0; i < image.channel_count; i++)
        for (int y = 0; y < 16; y++)
            for (int x = 16; x < 32; x++) ck_assert(image.channels[i].pixels[y * 48 + x] == 0);
    ck_assert(pixel_of(&image, "N", 3, 3) == 64 && pixel_of(&image, "N", 40, 3) == 48);
    ck_assert(nph_image_attribute(&image, "samples")->number == 64 &&
              nph_image_attribute(&image, "samples_least")->number == 0);
    nph_image_free(context, &image);
    nph_film_free(context, film);
    nph_test_context_close(context);
}
END_TEST

static double clear_sample(int x, int y, int64_t sample, int field) {
    (void)x, (void)y, (void)sample;
    return field <= NPH_SAMPLE_L2 ? 0.1f : field <= NPH_SAMPLE_T2 ? 1 : 0;
}

START_TEST(a_clear_view_has_alpha_depth_order_and_variance_exactly_zero) {
    NphContext *context = nph_test_context(1);
    Shape shape = {3, 3, {0, 0, 3, 3}, 3, 16, 16 * 12};
    NphFilm *film = full_film(context, &shape, 32, clear_sample);
    NphImage image = image_of(context, film);
    static const char *const zero[] = {"A", "Z", "Order.Y", "Variance.R", "Variance.B", "Vov.G"};
    for (size_t i = 0; i < sizeof zero / sizeof *zero; i++) ck_assert(pixel_of(&image, zero[i], 1, 2) == 0);
    ck_assert(pixel_of(&image, "R", 1, 2) == 0.1f && pixel_of(&image, "Transmittance.G", 1, 2) == 1);
    nph_image_free(context, &image);
    nph_film_free(context, film);
    nph_test_context_close(context);
}
END_TEST

static double extreme;
static double extreme_sample(int x, int y, int64_t sample, int field) {
    return field <= NPH_SAMPLE_L2 ? extreme * (1 + (double)(sample % 2)) : plain_sample(x, y, sample, field);
}

START_TEST(variances_beyond_a_float_saturate_with_a_warning_and_never_become_zero) {
    NphContext *context = nph_test_context(1);
    Shape shape = {1, 1, {0, 0, 1, 1}, 3, 0, 32};
    extreme = 1e30;
    NphFilm *film = full_film(context, &shape, 32, extreme_sample);
    NphImage image = image_of(context, film);
    ck_assert(fabs((double)pixel_of(&image, "R", 0, 0) - 1.5e30) < 1e24 &&
              pixel_of(&image, "Variance.R", 0, 0) == FLT_MAX);
    ck_assert(isfinite(pixel_of(&image, "Vov.R", 0, 0)));
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "largest of a float"));
    nph_image_free(context, &image);
    nph_film_free(context, film);
    extreme = 1e-30;
    film = full_film(context, &shape, 32, extreme_sample);
    image = image_of(context, film);
    ck_assert(fabs((double)pixel_of(&image, "R", 0, 0) - 1.5e-30) < 1e-36);
    ck_assert(pixel_of(&image, "Variance.R", 0, 0) == 0x1p-149f);
    ck_assert_str_eq(nph_test_messages(), "");
    nph_image_free(context, &image);
    nph_film_free(context, film);
    nph_test_context_close(context);
}
END_TEST

static double nan_sample(int x, int y, int64_t sample, int field) {
    return x == 1 && sample == 5 && field < 3 ? -(double)NAN : plain_sample(x, y, sample, field);
}

START_TEST(every_nan_in_a_picture_is_the_same_bits) {
    NphContext *context = nph_test_context(1);
    Shape shape = {3, 1, {0, 0, 3, 1}, 3, 0, 64};
    NphFilm *film = full_film(context, &shape, 32, nan_sample);
    NphImage image = image_of(context, film);
    static const char *const spoiled[] = {"R", "Variance.G", "Vov.B", "Order.Y"};
    for (size_t i = 0; i < sizeof spoiled / sizeof *spoiled; i++) {
        float value = pixel_of(&image, spoiled[i], 1, 0);
        uint32_t bits;
        memcpy(&bits, &value, sizeof bits);
        ck_assert_msg(bits == 0x7fc00000u, "%s: %08x", spoiled[i], bits);
        ck_assert(isfinite(pixel_of(&image, spoiled[i], 0, 0)) && isfinite(pixel_of(&image, spoiled[i], 2, 0)));
    }
    nph_image_free(context, &image);
    nph_film_free(context, film);
    nph_test_context_close(context);
}
END_TEST

static double normal_sample(int x, int y, int64_t sample, int field) {
    uint64_t pixel = (uint64_t)x * 65536 + (uint64_t)y;
    double u = hash_uniform(pixel, (uint64_t)sample, 100 + (uint64_t)field),
           v = hash_uniform(pixel, (uint64_t)sample, 200 + (uint64_t)field);
    return field == 0 ? 5 + sqrt(-2 * log(u)) * cos(6.283185307179586 * v) : 0;
}
static double exponential_sample(int x, int y, int64_t sample, int field) {
    return field == 0 ? -log(hash_uniform((uint64_t)x * 65536 + (uint64_t)y, (uint64_t)sample, 300)) : 0;
}

typedef struct Spread {
    double mean, error; /* of a layer over its pixels: mean, and its standard error */
    double variance;
} Spread;

static Spread spread_of(const NphImage *image, const char *name) {
    const float *pixels = nph_image_channel(image, name)->pixels;
    int count = image->width * image->height;
    Spread spread = {0, 0, 0};
    for (int i = 0; i < count; i++) spread.mean += pixels[i] / (double)count;
    for (int i = 0; i < count; i++)
        spread.variance += (pixels[i] - spread.mean) * (pixels[i] - spread.mean) / (count - 1.0);
    spread.error = sqrt(spread.variance / count);
    return spread;
}

/* E[M4 / M2^2] = 3 (n - 1) / (n (n + 1)) for normal samples, so Vov's expectation is exact for any n. */
START_TEST(vov_of_normal_samples_has_its_exact_expectation_at_16_and_at_1024_samples) {
    NphContext *context = nph_test_context(1);
    static const int sizes[2][2] = {{16, 128}, {1024, 24}};
    for (int i = 0; i < 2; i++) {
        int side = sizes[i][1];
        double n = sizes[i][0], wanted = 3 * (n - 1) / (n * (n + 1)) - (n - 3) / (n * (n - 1));
        Shape shape = {side, side, {0, 0, side, side}, 1, 0, sizes[i][0]};
        NphFilm *film = full_film(context, &shape, 64, normal_sample);
        NphImage image = image_of(context, film);
        Spread vov = spread_of(&image, "Vov.R"), variance = spread_of(&image, "Variance.R"),
               mean = spread_of(&image, "R");
        ck_assert_msg(fabs(vov.mean - wanted) < 4 * vov.error, "n %g: %g +- %g, not %g", n, vov.mean, vov.error,
                      wanted);
        ck_assert(fabs(variance.mean - 1 / n) < 4 * variance.error && fabs(mean.mean - 5) < 4 * mean.error);
        /* What Vov estimates: 2 / (n - 1); the variance of a sample variance of 576 pixels or more is known to 25%. */
        ck_assert_double_eq_tol(variance.variance * n * n, 2 / (n - 1), 0.25 * 2 / (n - 1));
        ck_assert_double_eq_tol(mean.variance * n, 1, 0.25);
        nph_image_free(context, &image);
        nph_film_free(context, film);
    }
    nph_test_context_close(context);
}
END_TEST

/* Kurtosis 9: (9 - (n - 3) / (n - 1)) / n; at 2048 samples the sample kurtosis is still a few per cent low. */
START_TEST(vov_of_exponential_samples_is_8_over_n) {
    NphContext *context = nph_test_context(1);
    Shape shape = {24, 24, {0, 0, 24, 24}, 1, 0, 2048};
    double n = 2048, wanted = (9 - (n - 3) / (n - 1)) / n;
    NphFilm *film = full_film(context, &shape, 64, exponential_sample);
    NphImage image = image_of(context, film);
    Spread vov = spread_of(&image, "Vov.R"), variance = spread_of(&image, "Variance.R");
    ck_assert_msg(fabs(vov.mean - wanted) < 4 * vov.error + 0.05 * wanted, "%g +- %g, not %g", vov.mean, vov.error,
                  wanted);
    ck_assert_double_eq_tol(variance.variance * n * n, wanted, 0.25 * wanted);
    nph_image_free(context, &image);
    nph_film_free(context, film);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_failed_allocation_leaves_no_image_and_no_leak) {
    NphSettings settings;
    nph_settings_default(&settings);
    settings.threads = 1;
    NphContext *maker = nph_test_context(1);
    Shape shape = {5, 5, {0, 0, 5, 5}, 1, 0, 16};
    NphFilm *film = full_film(maker, &shape, 32, plain_sample);
    ck_assert_int_eq(nph_film_set_text(maker, film, "seed", "1"), NPH_OK);
    for (settings.fail_allocation = 1;; settings.fail_allocation++) {
        NphContext *context = NULL;
        NphImage image = {.width = -7};
        ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
        NphStatus status = nph_film_image(context, film, &image);
        int done = nph_context_allocations(context) < settings.fail_allocation;
        ck_assert_int_eq(status, done ? NPH_OK : NPH_NO_MEMORY);
        if (done)
            nph_image_free(context, &image);
        else
            ck_assert_int_eq(image.width, -7);
        nph_test_context_close(context);
        if (done) break;
    }
    ck_assert_uint_ge(settings.fail_allocation, 30);
    nph_film_free(maker, film);
    nph_test_context_close(maker);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, every_layer_is_its_formula_over_the_samples);
    tcase_add_test(cases, the_planes_have_the_same_bytes_with_every_compiler_and_vector_level);
    tcase_add_test(cases, texts_and_the_number_of_samples_become_attributes);
    tcase_add_test(cases, grey_samples_give_equal_channels);
    tcase_add_test(cases, a_tile_without_samples_is_zero_everywhere_and_the_counts_say_so);
    tcase_add_test(cases, a_clear_view_has_alpha_depth_order_and_variance_exactly_zero);
    tcase_add_test(cases, variances_beyond_a_float_saturate_with_a_warning_and_never_become_zero);
    tcase_add_test(cases, every_nan_in_a_picture_is_the_same_bits);
    tcase_add_test(cases, vov_of_normal_samples_has_its_exact_expectation_at_16_and_at_1024_samples);
    tcase_add_test(cases, vov_of_exponential_samples_is_8_over_n);
    tcase_add_test(cases, a_failed_allocation_leaves_no_image_and_no_leak);
}

int main(void) { return nph_test_main("picture", fill); }
