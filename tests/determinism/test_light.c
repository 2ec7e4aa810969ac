/* SPDX-License-Identifier: Apache-2.0
 *
 * What light tracing promises besides its mean: the same bytes for any threads and ranges, a crop that is a piece of the
 * whole, replays that add up to the sample, and refusals that name what cannot be done. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "harness.h"
#include "render_case.h"

static const char scene[] =
    "nephos: 1\ncamera: {resolution: [40, 24], position: [-1.5, -1.5, 0.9], look_at: [0.5, 0.5, 0.5], fov: 45}\n"
    "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: [1, 4, 9], albedo: [0.99, 0.9, 0.7], phase: {type: hg, g: 0.5}}\n"
    "surfaces:\n  - {name: ground, plane: -0.2, albedo: 0.5}\n"
    "lights:\n  - {type: sun, direction: [-1, -0.2, 0.5], irradiance: 3}\n  - {type: constant, radiance: [0.3, 0.5, 1]}\n";

static NphRenderOptions options_of(int64_t samples, int precision) {
    NphRenderOptions options = render_options(samples, precision);
    options.method = "light";
    return options;
}

static void check_equal(const NphImage *a, const NphImage *b) {
    ck_assert_int_eq(a->channel_count, b->channel_count);
    for (int c = 0; c < a->channel_count; c++)
        ck_assert_mem_eq(a->channels[c].pixels, b->channels[c].pixels, (size_t)a->width * (size_t)a->height * sizeof(float));
}

START_TEST(any_number_of_threads_gives_the_same_bits) {
    static const int threads[] = {2, 3, 7};
    for (int precision = 32; precision <= 64; precision += 32) {
        RenderCase one, other;
        NphRenderOptions options = options_of(32, precision);
        render_case(&one, scene, &options, 1);
        for (int k = 0; k < 3; k++) {
            render_case(&other, scene, &options, threads[k]);
            check_equal(&one.image, &other.image);
            render_free(&other);
        }
        render_free(&one);
    }
}
END_TEST

START_TEST(ranges_of_samples_merge_to_the_bits_of_the_whole) {
    static const char *const names[2] = {"first", "second"};
    RenderCase whole, parts[2];
    NphFilm *merged = NULL;
    NphImage image;
    NphRenderOptions options = options_of(48, 32);
    render_case(&whole, scene, &options, 2);
    for (int k = 0; k < 2; k++) {
        options.samples = 0;
        options.sample_begin = k ? 16 : 0;
        options.sample_end = k ? 48 : 16;
        render_case(&parts[k], scene, &options, 2);
    }
    NphFilm *films[2] = {parts[1].film, parts[0].film};
    ck_assert_msg(nph_film_merge(whole.context, 2, films, names, &merged) == NPH_OK, "%s", nph_test_messages());
    ck_assert_int_eq(nph_film_image(whole.context, merged, &image), NPH_OK);
    check_equal(&whole.image, &image);
    nph_image_free(whole.context, &image);
    nph_film_free(whole.context, merged);
    for (int k = 0; k < 2; k++) render_free(&parts[k]);
    render_free(&whole);
}
END_TEST

START_TEST(a_crop_is_a_piece_of_the_whole) {
    RenderCase whole, crop;
    NphRenderOptions options = options_of(16, 32);
    render_case(&whole, scene, &options, 2);
    options.crop_given = 1;
    memcpy(options.crop, (int[4]){7, 3, 31, 20}, sizeof options.crop);
    render_case(&crop, scene, &options, 2);
    static const char *const names[] = {"R", "G", "B", "Variance.G", "Order.Y", "Transmittance.R"};
    for (int c = 0; c < 6; c++) {
        const float *a = nph_image_channel(&whole.image, names[c])->pixels, *b = nph_image_channel(&crop.image, names[c])->pixels;
        for (int y = 3; y < 20; y++) ck_assert_mem_eq(a + y * 40 + 7, b + (y - 3) * 24, 24 * sizeof(float));
    }
    render_free(&whole);
    render_free(&crop);
}
END_TEST

typedef struct Told {
    double adds, result;
    int arrivals;
} Told;

static void hear(void *user, const char *line) {
    Told *told = user;
    double value;
    const char *adds = strstr(line, ": adds ");
    if (adds) {
        sscanf(adds, ": adds %lf", &value);
        told->adds += value;
        told->arrivals++;
    }
    if (strncmp(line, "result: ", 8) == 0) sscanf(line, "result: %lf", &told->result);
}

START_TEST(a_replay_tells_every_arrival_of_a_pixel_and_their_sum) {
    RenderCase render;
    NphRenderOptions options = options_of(16, 64);
    render_case(&render, scene, &options, 2);
    double sum = 0.0;
    int arrivals = 0;
    for (int64_t sample = 0; sample < 16; sample++) {
        Told told = {0.0, -1.0, 0};
        ck_assert_int_eq(nph_replay(render.context, render.scene, &options, 20, 14, sample, hear, &told), NPH_OK);
        ck_assert_double_ge(told.result, told.adds * (1.0 - 1e-6));
        sum += told.result;
        arrivals += told.arrivals;
    }
    double mean = (double)nph_image_channel(&render.image, "R")->pixels[14 * 40 + 20];
    ck_assert_int_gt(arrivals, 0);
    ck_assert_double_le(fabs(sum / 16.0 - mean), 1e-6 * mean);
    render_free(&render);
}
END_TEST

static void check_refused(const char *yaml, const char *words) {
    RenderCase render;
    NphRenderOptions options = options_of(16, 32);
    ck_assert_int_ne(render_try(&render, yaml, &options, 1), NPH_OK);
    const char *messages = nph_test_messages();
    ck_assert_msg(strstr(messages, words) != NULL, "%s", messages);
    render_free(&render);
}

START_TEST(what_cannot_be_done_is_refused_by_name) {
    const char *rest = "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 1, albedo: 0.9}\nlights:\n  - {type: constant, radiance: 1}\n";
    check_refused(render_text("nephos: 1\ncamera: {resolution: [4, 4], position: [0, 0, 9], look_at: [0, 0, 0], up: [0, 1, 0], fov: 45}\n"
                              "periodic: {x: [0, 1], y: [0, 1]}\n%s", rest), "seen at infinitely many places");
    check_refused(render_text("nephos: 1\ncamera: {type: flux, resolution: [4, 4], position: [0, 0, 2], direction: [0, 0, -1], up: [0, 1, 0], extent: 1}\n"
                              "periodic: {x: [0, 1]}\n%s", rest), "along one axis only");
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, any_number_of_threads_gives_the_same_bits);
    tcase_add_test(cases, ranges_of_samples_merge_to_the_bits_of_the_whole);
    tcase_add_test(cases, a_crop_is_a_piece_of_the_whole);
    tcase_add_test(cases, a_replay_tells_every_arrival_of_a_pixel_and_their_sum);
    tcase_add_test(cases, what_cannot_be_done_is_refused_by_name);
}

int main(void) { return nph_test_main("light", fill); }
