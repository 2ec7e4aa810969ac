/* SPDX-License-Identifier: Apache-2.0
 *
 * Adding chunks: exactness, extremes, samples that are not finite, threads, vector levels, memory. */
#include <fenv.h>
#include <math.h>

#include "core/pool.h"
#include "film_samples.h"

static double furnace_value;
static double furnace_sample(int x, int y, int64_t sample, int field) {
    (void)x, (void)y, (void)sample;
    return field <= NPH_SAMPLE_L2      ? furnace_value
           : field <= NPH_SAMPLE_T2    ? 1
           : field == NPH_SAMPLE_ORDER ? 3 * furnace_value
                                       : 0;
}

START_TEST(equal_samples_have_exactly_their_value_and_no_variance) {
    static const double values[] = {1, 0.1, 1.0 / 3, 1e-30, 1e30, 0x1.fffffffffffffp0, 0x1.fffffep-1, 3.3e-38, 0};
    NphContext *context = nph_test_context(1);
    for (int precision = 32; precision <= 64; precision += 32)
        for (size_t v = 0; v < sizeof values / sizeof *values; v++)
            for (int64_t begin = 0; begin <= 48; begin += 48) {
                Shape shape = {3, 2, {0, 0, 3, 2}, 3, begin, 16 * 27};
                furnace_value = precision == 32 ? (float)values[v] : values[v];
                NphFilm *film = full_film(context, &shape, precision, furnace_sample);
                for (int c = 0; c < 3; c++) {
                    double moments[NPH_MOMENTS][NPH_TILE_PIXELS], transmittance[NPH_TILE_PIXELS];
                    nph_tree_fold_moments(film, 0, c, moments);
                    nph_tree_fold_mean(film, 0, nph_film_value_transmittance(3) + c, transmittance);
                    ck_assert(moments[0][17] == furnace_value && transmittance[17] == 1);
                    ck_assert(moments[1][17] == 0 && moments[2][17] == 0 && moments[3][17] == 0);
                }
                NphFilmNoise noise;
                nph_film_noise(film, &noise);
                ck_assert(noise.relative_error == 0 && noise.relative_rmse == 0);
                nph_film_free(context, film);
            }
    nph_test_context_close(context);
}
END_TEST

static double scale_of_samples = 1;
static double scaled_sample(int x, int y, int64_t sample, int field) {
    double plain = plain_sample(x, y, sample, field);
    return field <= NPH_SAMPLE_L2 ? plain * scale_of_samples : plain;
}

/* Rounding: each sample adds a few times 2^-53 of the sum of |x - mean|^k, whose terms are all below it. */
static void check_moments(const NphFilm *film, int64_t begin, int64_t end, int precision) {
    for (int c = 0; c < film->channels; c++) {
        double moments[NPH_MOMENTS][NPH_TILE_PIXELS];
        nph_tree_fold_moments(film, 0, c, moments);
        for (int x = 0; x < film->width; x++) {
            long double exact[4];
            exact_moments(x, 0, c, begin, end, precision, scaled_sample, exact);
            for (int k = 0; k < 4; k++) {
                long double error = fabsl(moments[k][x] - exact[k]), bound = 1e-13L * fabsl(exact[k]);
                if (k == 2) bound = 1e-13L * sqrtl(exact[1] * exact[3]); /* signed terms: Cauchy-Schwarz bounds them */
                ck_assert_msg(error <= bound, "moment %d of pixel %d, %d bits, scale %g: %.17g, not %.17Lg", k + 1, x,
                              precision, scale_of_samples, moments[k][x], exact[k]);
            }
        }
    }
}

START_TEST(moments_are_those_of_the_samples_from_1e_minus_30_to_1e30) {
    static const double scales[] = {1, 1e-30, 1e30};
    NphContext *context = nph_test_context(1);
    for (int i = 0; i < 3; i++)
        for (int precision = 32; precision <= 64; precision += 32)
            for (int channels = 1; channels <= 3; channels += 2) {
                Shape shape = {4, 1, {0, 0, 4, 1}, channels, 16 * 5, 16 * 70};
                scale_of_samples = scales[i];
                NphFilm *film = full_film(context, &shape, precision, scaled_sample);
                check_moments(film, shape.begin, shape.end, precision);
                nph_film_free(context, film);
            }
    nph_test_context_close(context);
}
END_TEST

/* One sample of NAN or infinity in one field of one pixel. */
static struct {
    int x, y, field;
    int64_t sample;
    double value;
} spoiler;
static double spoiled_sample(int x, int y, int64_t sample, int field) {
    int here = x == spoiler.x && y == spoiler.y && sample == spoiler.sample && field == spoiler.field;
    return here ? spoiler.value : plain_sample(x, y, sample, field);
}

START_TEST(a_sample_that_is_not_finite_is_counted_named_and_poisons_its_pixel_alone) {
    static const double values[] = {(double)NAN, (double)INFINITY, -(double)INFINITY};
    NphContext *context = nph_test_context(1);
    Shape shape = {20, 20, {3, 2, 19, 18}, 3, 32, 96};
    NphFilm *clean = full_film(context, &shape, 32, plain_sample);
    NphNonfinite report;
    nph_film_nonfinite(clean, &report);
    ck_assert_int_eq(report.count, 0);
    for (int field = 0; field < NPH_SAMPLE_FIELDS; field++)
        for (int v = 0; v < 3; v++) {
            spoiler.x = 17, spoiler.y = 4, spoiler.field = field, spoiler.sample = 67, spoiler.value = values[v];
            NphFilm *film = full_film(context, &shape, v == 1 ? 64 : 32, spoiled_sample);
            nph_film_nonfinite(film, &report);
            ck_assert_int_eq(report.count, 1);
            ck_assert(report.x == 17 && report.y == 4 && report.sample == 67);
            double poisoned[NPH_TILE_PIXELS], same[NPH_TILE_PIXELS];
            int plane = field <= NPH_SAMPLE_L2 ? NPH_MOMENTS * field : NPH_MOMENTS * 3 + field - NPH_SAMPLE_T0;
            for (int64_t tile = 0; tile < film->tile_count; tile++) {
                nph_tree_fold_mean(film, tile, plane, poisoned);
                nph_tree_fold_mean(clean, tile, plane, same);
                for (int p = 0; p < NPH_TILE_PIXELS; p++) {
                    int here = tile == 1 && p == 4 * NPH_TILE + 1;
                    if (here)
                        ck_assert(!isfinite(poisoned[p]));
                    else if (v != 1)
                        ck_assert(poisoned[p] == same[p]);
                }
            }
            nph_film_free(context, film);
        }
    nph_film_free(context, clean);
    nph_test_context_close(context);
}
END_TEST

static double often_bad_sample(int x, int y, int64_t sample, int field) {
    int bad = (x == 5 && y == 3 && sample >= 20 && field <= 1) ||
              (x == 18 && y == 1 && sample % 16 == 9 && field == NPH_SAMPLE_ORDER);
    return bad ? (double)NAN : plain_sample(x, y, sample, field);
}

START_TEST(bad_samples_count_once_each_and_the_first_by_row_column_and_sample_is_named) {
    NphContext *context = nph_test_context(1);
    Shape shape = {20, 20, {0, 0, 20, 20}, 3, 0, 64};
    NphFilm *film = full_film(context, &shape, 32, often_bad_sample);
    NphNonfinite report;
    nph_film_nonfinite(film, &report);
    ck_assert_int_eq(report.count, 44 + 4);
    ck_assert(report.x == 18 && report.y == 1 && report.sample == 9);
    nph_film_free(context, film);
    nph_test_context_close(context);
}
END_TEST

static double grey_bad_sample(int x, int y, int64_t sample, int field) {
    int unread = field == NPH_SAMPLE_L1 || field == NPH_SAMPLE_L2 || field == NPH_SAMPLE_T1 || field == NPH_SAMPLE_T2;
    return unread ? (double)NAN : plain_sample(x, y, sample, field);
}

static double grey_spoiled_sample(int x, int y, int64_t sample, int field) {
    int here = x == 3 && y == 1 && sample == 17 && field == NPH_SAMPLE_T0;
    return here ? (double)INFINITY : grey_bad_sample(x, y, sample, field);
}

START_TEST(one_channel_leaves_the_fields_of_the_others_unread) {
    NphContext *context = nph_test_context(1);
    Shape shape = {5, 5, {0, 0, 5, 5}, 1, 0, 32};
    NphFilm *film = full_film(context, &shape, 32, grey_bad_sample),
            *clean = full_film(context, &shape, 32, plain_sample);
    ck_assert(films_equal(film, clean));
    nph_film_free(context, film);
    nph_film_free(context, clean);
    film = full_film(context, &shape, 32, grey_spoiled_sample);
    NphNonfinite report;
    nph_film_nonfinite(film, &report);
    ck_assert(report.count == 1 && report.x == 3 && report.y == 1 && report.sample == 17);
    nph_film_free(context, film);
    nph_test_context_close(context);
}
END_TEST

typedef struct Job {
    NphFilm *film;
    int64_t end;
    int rounding;
} Job;

static NphStatus add_tile(void *data, int64_t block, int worker) {
    Job *job = data;
    (void)worker;
    add_samples(job->film, block, job->end, 32, plain_sample);
    return NPH_OK;
}

START_TEST(threads_and_passes_do_not_change_a_bit) {
    Shape shape = {50, 35, {1, 0, 50, 34}, 3, 16, 16 * 14};
    NphContext *one = nph_test_context(1);
    NphFilm *whole = full_film(one, &shape, 32, plain_sample);
    for (int threads = 2; threads <= 7; threads += 5) {
        NphContext *context = nph_test_context(threads);
        Job job = {empty_film(context, &shape), 0, 0};
        static const int64_t passes[] = {16 * 2, 16 * 3, 16 * 9, 16 * 14};
        for (int i = 0; i < 4; i++) {
            job.end = passes[i];
            ck_assert_int_eq(nph_pool_run(context, job.film->tile_count, add_tile, &job, NULL), NPH_OK);
        }
        ck_assert(films_equal(whole, job.film));
        nph_film_free(context, job.film);
        nph_test_context_close(context);
    }
    nph_film_free(one, whole);
    nph_test_context_close(one);
}
END_TEST

START_TEST(vector_levels_do_not_change_a_bit) {
    Shape shape = {16, 9, {0, 0, 16, 9}, 3, 0, 16 * 6};
    NphContext *best = nph_test_context(1);
    for (int precision = 32; precision <= 64; precision += 32) {
        NphFilm *film = full_film(best, &shape, precision, plain_sample);
        for (int isa = NPH_ISA_BASE; isa < (int)nph_context_isa(best); isa++) {
            NphSettings settings;
            NphContext *context = NULL;
            nph_settings_default(&settings);
            settings.threads = 1;
            settings.isa_limit = (NphIsa)isa;
            ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
            NphFilm *other = full_film(context, &shape, precision, plain_sample);
            ck_assert_msg(films_equal(film, other), "%s differs", nph_isa_name((NphIsa)isa));
            nph_film_free(context, other);
            nph_test_context_close(context);
        }
        nph_film_free(best, film);
    }
    nph_test_context_close(best);
}
END_TEST

START_TEST(adding_chunks_allocates_nothing_and_the_forecast_is_exact) {
    NphContext *context = nph_test_context(1);
    static const int crops[2][4] = {{0, 0, 1, 1}, {3, 15, 40, 33}};
    for (int i = 0; i < 2; i++) {
        Shape shape = {64, 48, {crops[i][0], crops[i][1], crops[i][2], crops[i][3]}, i ? 3 : 1, 48, 16 * 40};
        uint64_t before = nph_context_bytes(context);
        NphFilm *film = empty_film(context, &shape);
        uint64_t bytes = nph_context_bytes(context), calls = nph_context_allocations(context);
        uint64_t forecast = nph_film_forecast_bytes(64, 48, shape.crop, shape.channels, shape.begin, shape.end);
        ck_assert_uint_eq(bytes - before, forecast);
        for (int64_t tile = 0; tile < film->tile_count; tile++) add_samples(film, tile, shape.end, 64, plain_sample);
        ck_assert_uint_eq(nph_context_allocations(context), calls);
        for (int64_t tile = 0; tile < film->tile_count; tile++)
            ck_assert_int_eq(nph_film_tile_samples(film, tile), 16 * 37);
        nph_film_free(context, film);
    }
    nph_test_context_close(context);
}
END_TEST

START_TEST(tiles_cover_the_crop_once_aligned_to_the_whole_picture) {
    NphContext *context = nph_test_context(1);
    Shape shape = {100, 70, {17, 3, 81, 64}, 1, 0, 16};
    NphFilm *film = empty_film(context, &shape);
    static int seen[70][100];
    ck_assert_int_eq(nph_film_tile_count(film), 5 * 4);
    for (int64_t tile = 0; tile < 20; tile++) {
        int origin[2], inside[4];
        nph_film_tile_rect(film, tile, origin, inside);
        ck_assert(origin[0] % 16 == 0 && origin[1] % 16 == 0);
        ck_assert(inside[0] >= origin[0] && inside[2] <= origin[0] + 16 && inside[1] >= origin[1] &&
                  inside[3] <= origin[1] + 16);
        for (int y = inside[1]; y < inside[3]; y++)
            for (int x = inside[0]; x < inside[2]; x++) seen[y][x]++;
    }
    for (int y = 0; y < 70; y++)
        for (int x = 0; x < 100; x++) ck_assert_int_eq(seen[y][x], x >= 17 && x < 81 && y >= 3 && y < 64);
    nph_film_free(context, film);
    nph_test_context_close(context);
}
END_TEST

START_TEST(impossible_films_are_refused_with_the_reason) {
    static const struct {
        Shape shape;
        const char *word;
    } cases[] = {
        {{0, 4, {0, 0, 0, 4}, 1, 0, 16}, "size"},
        {{4, -4, {0, 0, 4, 4}, 1, 0, 16}, "size"},
        {{1 << 25, 1, {0, 0, 1, 1}, 1, 0, 16}, "size"},
        {{4, 4, {0, 0, 5, 4}, 1, 0, 16}, "crop"},
        {{4, 4, {2, 0, 2, 4}, 1, 0, 16}, "crop"},
        {{4, 4, {-1, 0, 2, 4}, 1, 0, 16}, "crop"},
        {{4, 4, {0, 3, 2, 2}, 1, 0, 16}, "crop"},
        {{4, 4, {0, 0, 4, 4}, 2, 0, 16}, "channels"},
        {{4, 4, {0, 0, 4, 4}, 1, 8, 16}, "multiples"},
        {{4, 4, {0, 0, 4, 4}, 1, 0, 17}, "multiples"},
        {{4, 4, {0, 0, 4, 4}, 1, 16, 16}, "rising"},
        {{4, 4, {0, 0, 4, 4}, 1, -16, 16}, "rising"},
        {{4, 4, {0, 0, 4, 4}, 1, 0, (int64_t)1 << 40}, "2147483632"},
    };
    NphContext *context = nph_test_context(1);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const Shape *s = &cases[i].shape;
        NphFilm *film = NULL;
        ck_assert_int_eq(nph_film_new(context, s->width, s->height, s->crop, s->channels, s->begin, s->end, &film),
                         NPH_BAD_USAGE);
        ck_assert_ptr_null(film);
        const char *said = nph_test_messages();
        ck_assert_msg(strstr(said, cases[i].word) != NULL, "case %d said: %s", (int)i, said);
    }
    nph_test_context_close(context);
}
END_TEST

START_TEST(texts_are_kept_replaced_and_refused_when_no_picture_could_carry_them) {
    NphContext *context = nph_test_context(1);
    Shape shape = {1, 1, {0, 0, 1, 1}, 1, 0, 16};
    NphFilm *film = empty_film(context, &shape);
    ck_assert_int_eq(nph_film_set_text(context, film, "seed", "1"), NPH_OK);
    ck_assert_int_eq(nph_film_set_text(context, film, "method", "path"), NPH_OK);
    ck_assert_int_eq(nph_film_set_text(context, film, "seed", "2"), NPH_OK);
    ck_assert_str_eq(nph_film_text(film, "seed"), "2");
    ck_assert_str_eq(nph_film_text(film, "method"), "path");
    ck_assert_ptr_null(nph_film_text(film, "knobs"));
    ck_assert_int_eq(nph_film_set_text(context, film, "", "x"), NPH_BAD_USAGE);
    ck_assert_int_eq(nph_film_set_text(context, film, "dataWindow", "x"), NPH_BAD_USAGE);
    ck_assert_int_eq(nph_film_set_text(context, film, "samples", "x"), NPH_BAD_USAGE);
    nph_film_free(context, film);
    nph_test_context_close(context);
}
END_TEST

START_TEST(every_failing_allocation_is_reported_and_leaks_nothing) {
    NphSettings settings;
    nph_settings_default(&settings);
    settings.threads = 1;
    for (settings.fail_allocation = 1;; settings.fail_allocation++) {
        NphContext *context = NULL;
        NphFilm *film = NULL;
        ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
        NphStatus status = nph_film_new(context, 40, 40, (int[]){0, 0, 40, 40}, 3, 0, 64, &film);
        if (status == NPH_OK) status = nph_film_set_text(context, film, "seed", "1");
        if (status == NPH_OK) status = nph_film_set_text(context, film, "method", "path");
        int done = nph_context_allocations(context) < settings.fail_allocation;
        ck_assert_int_eq(status, done ? NPH_OK : NPH_NO_MEMORY);
        nph_film_free(context, film);
        nph_test_context_close(context);
        if (done) break;
    }
    ck_assert_uint_ge(settings.fail_allocation, 10);
}
END_TEST

START_TEST(noise_is_the_standard_error_of_the_picture_and_of_its_pixels) {
    NphContext *context = nph_test_context(1);
    Shape shape = {21, 18, {0, 0, 21, 18}, 3, 0, 64};
    NphFilm *film = full_film(context, &shape, 64, plain_sample);
    long double mean = 0, variance = 0;
    for (int y = 0; y < 18; y++)
        for (int x = 0; x < 21; x++) {
            long double error = 0;
            for (int c = 0; c < 3; c++) {
                static const long double weight[3] = {0.2126L, 0.7152L, 0.0722L};
                long double exact[4];
                exact_moments(x, y, c, 0, 64, 64, plain_sample, exact);
                mean += weight[c] * exact[0] / (21 * 18);
                error += weight[c] * sqrtl(exact[1] / (64 * 63));
            }
            variance += error * error;
        }
    NphFilmNoise noise;
    nph_film_noise(film, &noise);
    ck_assert_double_eq_tol(noise.mean_luminance, (double)mean, 1e-12 * (double)mean);
    ck_assert_double_eq_tol(noise.relative_error, (double)(sqrtl(variance) / (21 * 18) / mean), 1e-12);
    ck_assert_double_eq_tol(noise.relative_rmse, (double)(sqrtl(variance / (21 * 18)) / mean), 1e-12);
    ck_assert(noise.samples_min == 64 && noise.samples_max == 64);
    nph_film_free(context, film);
    nph_test_context_close(context);
}
END_TEST

START_TEST(noise_counts_only_pixels_that_have_samples_and_a_black_picture_has_none) {
    NphContext *context = nph_test_context(1);
    Shape shape = {40, 16, {0, 0, 40, 16}, 1, 0, 64}, left = {40, 16, {0, 0, 16, 16}, 1, 0, 64};
    NphFilm *film = empty_film(context, &shape), *alone = full_film(context, &left, 32, plain_sample);
    NphFilmNoise noise, wanted;
    nph_film_noise(film, &noise);
    ck_assert(noise.mean_luminance == 0 && noise.relative_error == 0 && noise.relative_rmse == 0);
    add_samples(film, 0, 64, 32, plain_sample);
    nph_film_noise(film, &noise);
    nph_film_noise(alone, &wanted);
    ck_assert(noise.mean_luminance == wanted.mean_luminance && noise.relative_error == wanted.relative_error);
    ck_assert(noise.samples_min == 0 && noise.samples_max == 64 && wanted.samples_min == 64);
    nph_film_free(context, film);
    nph_film_free(context, alone);
    furnace_value = 0;
    film = full_film(context, &shape, 32, furnace_sample);
    nph_film_noise(film, &noise);
    ck_assert(noise.mean_luminance == 0 && noise.relative_error == 0 && noise.relative_rmse == 0);
    nph_film_free(context, film);
    nph_test_context_close(context);
}
END_TEST

START_TEST(the_callers_rounding_mode_neither_counts_nor_is_lost) {
    NphContext *context = nph_test_context(1);
    Shape shape = {16, 16, {0, 0, 16, 16}, 3, 0, 16 * 7};
    NphFilm *film = full_film(context, &shape, 32, plain_sample);
    NphFilmNoise noise, upward;
    nph_film_noise(film, &noise);
    fesetround(FE_UPWARD);
    nph_film_noise(film, &upward);
    int kept = fegetround() == FE_UPWARD;
    fesetround(FE_TONEAREST);
    ck_assert(kept);
    ck_assert(upward.mean_luminance == noise.mean_luminance && upward.relative_error == noise.relative_error);
    nph_film_free(context, film);
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, equal_samples_have_exactly_their_value_and_no_variance);
    tcase_add_test(cases, moments_are_those_of_the_samples_from_1e_minus_30_to_1e30);
    tcase_add_test(cases, a_sample_that_is_not_finite_is_counted_named_and_poisons_its_pixel_alone);
    tcase_add_test(cases, bad_samples_count_once_each_and_the_first_by_row_column_and_sample_is_named);
    tcase_add_test(cases, one_channel_leaves_the_fields_of_the_others_unread);
    tcase_add_test(cases, threads_and_passes_do_not_change_a_bit);
    tcase_add_test(cases, vector_levels_do_not_change_a_bit);
    tcase_add_test(cases, adding_chunks_allocates_nothing_and_the_forecast_is_exact);
    tcase_add_test(cases, tiles_cover_the_crop_once_aligned_to_the_whole_picture);
    tcase_add_test(cases, impossible_films_are_refused_with_the_reason);
    tcase_add_test(cases, texts_are_kept_replaced_and_refused_when_no_picture_could_carry_them);
    tcase_add_test(cases, every_failing_allocation_is_reported_and_leaks_nothing);
    tcase_add_test(cases, noise_is_the_standard_error_of_the_picture_and_of_its_pixels);
    tcase_add_test(cases, noise_counts_only_pixels_that_have_samples_and_a_black_picture_has_none);
    tcase_add_test(cases, the_callers_rounding_mode_neither_counts_nor_is_lost);
}

int main(void) { return nph_test_main("film", fill); }
