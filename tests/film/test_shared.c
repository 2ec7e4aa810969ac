/* SPDX-License-Identifier: Apache-2.0
 *
 * Films whose pixels share samples: the variance of the means of tiles and image is that of the samples themselves, and
 * stays to the bit through parts and merges. */
#include <math.h>

#include "core/memory.h"
#include "film/part.h"
#include "film_samples.h"
#include "io/file.h"

/* All pixels of a sample rise and fall together, and each a little by itself. */
static double image_sample(int x, int y, int64_t sample, int field) {
    double own = hash_uniform((uint64_t)x * 65536 + (uint64_t)y, (uint64_t)sample, (uint64_t)field);
    return field <= NPH_SAMPLE_L2 ? hash_uniform(99, (uint64_t)sample, (uint64_t)field) * (1 + 0.1 * x + y) + own : own;
}

static NphFilm *shared_film(NphContext *context, const Shape *shape, int64_t end, int precision) {
    NphFilm *film = empty_film(context, shape);
    ck_assert_int_eq(nph_film_share_samples(context, film), NPH_OK);
    add_images(film, end, precision, image_sample);
    return film;
}

static const Shape shapes[] = {
    {40, 30, {0, 0, 40, 30}, 3, 0, 16 * 7},
    {130, 90, {5, 2, 113, 81}, 1, 48, 96},
    {99, 35, {0, 0, 99, 35}, 3, 0, 64},
    {3, 2, {0, 0, 3, 2}, 1, 0, 32},
};
enum { SHAPES = sizeof shapes / sizeof *shapes };

/* Mean and variance of the mean of a rectangle of the crop, sample by sample. */
static void exact_region(const Shape *shape, int channel, const int rect[4], double out[2]) {
    double sum = 0, square = 0, n = (double)(shape->end - shape->begin);
    for (int64_t s = shape->begin; s < shape->end; s++) {
        double mean = 0, pixels = (double)(rect[2] - rect[0]) * (rect[3] - rect[1]);
        for (int y = rect[1]; y < rect[3]; y++)
            for (int x = rect[0]; x < rect[2]; x++)
                mean += image_sample(shape->crop[0] + x, shape->crop[1] + y, s, channel) / pixels;
        sum += mean;
        square += mean * mean;
    }
    out[0] = sum / n;
    out[1] = (square / n - out[0] * out[0]) / (n - 1);
}

static void check_level(const Shape *shape, const NphImage *image, int level, int channel) {
    int size = nph_region_sizes[level], across = nph_regions_along(image->width, size);
    int down = nph_regions_along(image->height, size);
    const float *variance = nph_image_channel(image, nph_region_variance[level][channel])->pixels;
    const float *vov = nph_image_channel(image, nph_region_vov[level][channel])->pixels;
    for (int i = 0; i < across * down; i++) {
        int rect[4];
        double exact[2];
        nph_region_span(i % across, across, size, image->width, &rect[0], &rect[2]);
        nph_region_span(i / across, down, size, image->height, &rect[1], &rect[3]);
        exact_region(shape, shape->channels == 1 ? 0 : channel, rect, exact);
        for (int y = rect[1]; y < rect[3]; y++)
            for (int x = rect[0]; x < rect[2]; x++) {
                double stated = (double)variance[y * image->width + x];
                ck_assert_msg(fabs(stated - exact[1]) < 1e-6 * exact[1], "level %d, pixel %d,%d: %g, exact %g", level, x, y,
                              stated, exact[1]);
                ck_assert(vov[y * image->width + x] > 0.0f);
            }
    }
}

START_TEST(each_regions_mean_has_the_variance_of_the_images_own_means) {
    NphContext *context = nph_test_context(1);
    for (int i = 0; i < SHAPES; i++) {
        NphFilm *film = shared_film(context, &shapes[i], shapes[i].end, 64);
        NphImage image;
        ck_assert_int_eq(nph_film_image(context, film, &image), NPH_OK);
        for (int level = 0; level < NPH_REGION_LEVELS; level++)
            for (int c = 0; c < shapes[i].channels; c++) check_level(&shapes[i], &image, level, c);
        nph_image_free(context, &image);
        nph_film_free(context, film);
    }
    nph_test_context_close(context);
}
END_TEST

START_TEST(the_noise_of_the_picture_is_that_of_its_images) {
    NphContext *context = nph_test_context(1);
    const Shape *shape = &shapes[1];
    NphFilm *film = shared_film(context, shape, shape->end, 64);
    NphFilmNoise noise;
    double exact[2];
    int whole[4] = {0, 0, shape->crop[2] - shape->crop[0], shape->crop[3] - shape->crop[1]};
    nph_film_noise(film, &noise);
    exact_region(shape, 0, whole, exact);
    ck_assert_double_eq_tol(noise.relative_error, sqrt(exact[1]) / exact[0], 1e-9);
    ck_assert_double_gt(noise.relative_error, 10 * noise.relative_rmse / sqrt(whole[2] * whole[3]));
    nph_film_free(context, film);
    nph_test_context_close(context);
}
END_TEST

static NphFilm *reread(NphContext *context, NphFilm *film) {
    NphFilm *read = NULL;
    const char *path = nph_test_temporary("shared.part");
    ck_assert_int_eq(nph_film_write_part(context, film, path), NPH_OK);
    ck_assert_msg(nph_film_read_part(context, path, &read) == NPH_OK, "%s", nph_test_messages());
    nph_film_free(context, film);
    return read;
}

START_TEST(every_split_into_ranges_merges_to_the_unsplit_film_through_files) {
    static const char *const names[4] = {"a", "b", "c", "d"};
    NphContext *context = nph_test_context(1);
    for (int i = 0; i < SHAPES - 1; i++) {
        NphFilm *whole = shared_film(context, &shapes[i], shapes[i].end, 32);
        for (int cuts = 0; cuts < 8; cuts++) { /* bit k: a cut after chunk k */
            NphFilm *parts[4], *merged = NULL;
            int count = 0;
            int64_t from = shapes[i].begin;
            for (int k = 0; k < 4; k++) {
                Shape shape = shapes[i];
                if (k < 3 && !(cuts >> k & 1)) continue;
                shape.begin = from;
                shape.end = from = k == 3 ? shapes[i].end : shapes[i].begin + 16 * (k + 1) < shapes[i].end ? shapes[i].begin + 16 * (k + 1) : shapes[i].end;
                if (shape.end == shape.begin) continue;
                parts[count++] = reread(context, shared_film(context, &shape, shape.end, 32));
            }
            ck_assert_msg(nph_film_merge(context, count, parts, names, &merged) == NPH_OK, "%s", nph_test_messages());
            ck_assert(films_equal(whole, merged));
            for (int k = 0; k < count; k++) nph_film_free(context, parts[k]);
            nph_film_free(context, merged);
        }
        nph_film_free(context, whole);
    }
    nph_test_context_close(context);
}
END_TEST

static void check_refused(NphContext *context, NphFilm *a, NphFilm *b, const char *words) {
    static const char *const names[2] = {"one", "two"};
    NphFilm *parts[2] = {a, b}, *merged = NULL;
    nph_test_messages();
    ck_assert_int_eq(nph_film_merge(context, 2, parts, names, &merged), NPH_BAD_INPUT);
    const char *messages = nph_test_messages();
    ck_assert_msg(strstr(messages, words) != NULL, "%s", messages);
    nph_film_free(context, a);
    nph_film_free(context, b);
}

START_TEST(parts_of_pictures_whose_pixels_share_samples_merge_by_samples_only) {
    NphContext *context = nph_test_context(1);
    Shape left = {32, 16, {0, 0, 16, 16}, 1, 0, 32}, right = {32, 16, {16, 0, 32, 16}, 1, 0, 32}, later = left;
    check_refused(context, shared_film(context, &left, 32, 32), shared_film(context, &right, 32, 32), "their crops differ");
    later.begin = 32;
    later.end = 64;
    check_refused(context, shared_film(context, &left, 32, 32), full_film(context, &later, 32, plain_sample),
                  "only in one of them pixels share samples");
    nph_test_context_close(context);
}
END_TEST

static void write_bytes(const char *path, const char *bytes, size_t size) {
    FILE *file = fopen(path, "wb");
    ck_assert_ptr_nonnull(file);
    ck_assert_uint_eq(fwrite(bytes, 1, size, file), size);
    ck_assert_int_eq(fclose(file), 0);
}

START_TEST(a_damaged_part_is_refused) {
    NphContext *context = nph_test_context(1);
    NphFilm *film = shared_film(context, &shapes[3], 32, 64), *read = NULL;
    const char *path = nph_test_temporary("damaged.part");
    char *bytes = NULL;
    size_t size;
    ck_assert_int_eq(nph_film_write_part(context, film, path), NPH_OK);
    ck_assert_int_eq(nph_file_read(context, path, &bytes, &size), NPH_OK);
    for (size_t i = 0; i < size; i++) {
        bytes[i] ^= 1;
        write_bytes(path, bytes, size);
        ck_assert_int_eq(nph_film_read_part(context, path, &read), NPH_BAD_INPUT);
        bytes[i] ^= 1;
    }
    nph_test_messages();
    nph_free(context, bytes);
    nph_film_free(context, film);
    nph_test_context_close(context);
}
END_TEST

START_TEST(the_forecast_of_the_regions_is_exact) {
    NphContext *context = nph_test_context(1);
    for (int i = 0; i < SHAPES; i++) {
        const Shape *s = &shapes[i];
        NphFilm *film = empty_film(context, s);
        uint64_t before = nph_context_bytes(context);
        ck_assert_int_eq(nph_film_share_samples(context, film), NPH_OK);
        ck_assert_uint_eq(nph_context_bytes(context) - before,
                          nph_film_forecast_shared_bytes(s->width, s->height, s->crop, s->channels, s->begin, s->end));
        nph_film_free(context, film);
    }
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, each_regions_mean_has_the_variance_of_the_images_own_means);
    tcase_add_test(cases, the_noise_of_the_picture_is_that_of_its_images);
    tcase_add_test(cases, every_split_into_ranges_merges_to_the_unsplit_film_through_files);
    tcase_add_test(cases, parts_of_pictures_whose_pixels_share_samples_merge_by_samples_only);
    tcase_add_test(cases, a_damaged_part_is_refused);
    tcase_add_test(cases, the_forecast_of_the_regions_is_exact);
}

int main(void) { return nph_test_main("shared", fill); }
