/* SPDX-License-Identifier: Apache-2.0
 *
 * Error bars and convergence. Repeats with other seeds, samples fixed beforehand: the 95% intervals of image and tiles
 * cover the truth 95% of the time; and the root mean square error falls as samples^-1/2. The truth of the first is the mean of all
 * repeats (whose own error widens nothing: 1 / repeats of a variance), of the second a picture of many samples.
 *
 *   NEPHOS_REPEATS=4000 test_confidence     the numbers of docs/accuracy.md; the suite takes 40
 *   NEPHOS_METHOD=light test_confidence     the cases of that method alone */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "harness.h"
#include "oracle/student.h"
#include "render_case.h"

typedef struct Case {
    const char *name, *method, *scene;
    int width, height;
    int64_t samples;
} Case;

#define CAMERA "camera: {type: perspective, resolution: [%s], position: [-1.5, -1.5, 0.5], look_at: [0.5, 0.5, 0.5], fov: 35}\n"
#define CUBE "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 4, albedo: 1, phase: {type: hg, g: %s}}\n"
#define SUN "lights:\n  - {type: sun, direction: [-1, 0, 0], irradiance: 3.141592653589793}\n"
#define FLUX "camera: {type: flux, resolution: [16, 16], position: [0, 0, %s], direction: [0, 0, %s], up: [0, 1, 0], extent: 1}\n"
#define SLAB "media:\n  - {layer: [0, 1], extinction: 8, albedo: 1, phase: {type: hg, g: 0.75}}\n"
#define OVERHEAD "lights:\n  - {type: sun, direction: [0, 0, 1], irradiance: 3.141592653589793}\n"

static const Case cases[] = {
    {"cube g 0", "path", "nephos: 1\n" CAMERA CUBE SUN, 32, 32, 512},
    {"cube g 0.7", "path", "nephos: 1\n" CAMERA CUBE SUN, 32, 32, 1024},
    {"slab, reflected", "path", "nephos: 1\n" FLUX SLAB OVERHEAD, 16, 16, 64},
    {"slab, transmitted", "path", "nephos: 1\n" FLUX SLAB OVERHEAD, 16, 16, 64},
    {"cube g 0.7", "light", "nephos: 1\n" CAMERA CUBE SUN, 16, 16, 256},
    {"slab, reflected", "light", "nephos: 1\n" FLUX SLAB OVERHEAD, 16, 16, 64},
};
static const char *const words[][2] = {{"32, 32", "0"}, {"32, 32", "0.7"}, {"2", "-1"}, {"-1", "1"}, {"16, 16", "0.7"}, {"2", "-1"}};
enum { CASES = sizeof cases / sizeof cases[0] };

static const char *scene_of(int i) { return render_text(cases[i].scene, words[i][0], words[i][1]); }

/* Mean, variance of the mean, and variance of that of each tile of `size` pixels. */
typedef struct Tiles {
    int count, across;
    double *mean, *variance, *spread;
} Tiles;

static Tiles tiles_of(const RenderCase *render, int size) {
    const NphImage *image = &render->image;
    const float *value = nph_image_channel(image, "G")->pixels, *v = nph_image_channel(image, "Variance.G")->pixels;
    const float *vov = nph_image_channel(image, "Vov.G")->pixels;
    Tiles tiles = {.across = (image->width + size - 1) / size};
    tiles.count = tiles.across * ((image->height + size - 1) / size);
    tiles.mean = calloc(3 * (size_t)tiles.count, sizeof(double));
    tiles.variance = tiles.mean + tiles.count;
    tiles.spread = tiles.variance + tiles.count;
    int pixels = image->width * image->height / tiles.count;
    /* where pixels share samples the tile's own variance stands in all of its pixels */
    const NphChannel *shared = nph_image_channel(image, size == 8 ? "Variance8.G" : "VarianceImage.G");
    const NphChannel *shared_vov = nph_image_channel(image, size == 8 ? "Vov8.G" : "VovImage.G");
    for (int i = 0; i < image->width * image->height; i++) {
        int t = i / image->width / size * tiles.across + i % image->width / size;
        double n = (double)nph_image_channel(image, "N")->pixels[i], least = 2.0 / (n - 1.0);
        double o = (double)vov[i] > least ? (double)vov[i] : least, pixel = (double)v[i];
        tiles.mean[t] += (double)value[i] / pixels;
        tiles.variance[t] += pixel / pixels / pixels;
        tiles.spread[t] += o * pixel * pixel / pixels / pixels / pixels / pixels;
        if (!shared) continue;
        double variance = (double)shared->pixels[i], relative = (double)shared_vov->pixels[i];
        tiles.variance[t] = variance;
        tiles.spread[t] = variance * variance * (relative > least ? relative : least);
    }
    return tiles;
}

typedef struct Counted {
    int64_t covered, normal, intervals; /* by Student's interval, as the comparator's; by 1.96 standard errors */
} Counted;

/* Intervals of tiles of `size` in all repeats about their common mean; black tiles (no variance in any repeat) have none. */
static Counted count_intervals(const Tiles *repeats, int count) {
    Counted counted = {0, 0, 0};
    for (int t = 0; t < repeats[0].count; t++) {
        double truth = 0.0, noise = 0.0;
        for (int r = 0; r < count; r++) {
            truth += repeats[r].mean[t] / count;
            noise += repeats[r].variance[t];
        }
        for (int r = 0; r < count && noise > 0.0; r++) {
            double v = repeats[r].variance[t], dof = v > 0.0 ? 2.0 * v * v / repeats[r].spread[t] : 1.0;
            double z = fabs(repeats[r].mean[t] - truth) / sqrt(v);
            counted.intervals++;
            counted.covered += z <= nph_student_quantile(0.975, dof);
            counted.normal += z <= 1.959963984540054;
        }
    }
    return counted;
}

static int method_wanted(const char *method) {
    const char *only = getenv("NEPHOS_METHOD");
    return !only || strcmp(only, method) == 0;
}

static int repeats_wanted(void) {
    const char *text = getenv("NEPHOS_REPEATS");
    int repeats = text ? atoi(text) : 40;
    return repeats > 1 ? repeats : 2;
}

START_TEST(intervals_of_image_and_tiles_cover_the_mean_as_often_as_they_say) {
    if (!method_wanted(cases[_i].method) || !nph_test_statistics("coverage of intervals")) return;
    static const int sizes[] = {64, 8};
    int repeats = repeats_wanted();
    const Case *c = &cases[_i];
    Tiles *tiles[2] = {calloc((size_t)repeats, sizeof(Tiles)), calloc((size_t)repeats, sizeof(Tiles))};
    for (int r = 0; r < repeats; r++) {
        RenderCase render;
        NphRenderOptions options = render_options(c->samples, 32);
        options.method = c->method;
        options.seed_given = 1;
        options.seed = 1000u + (uint32_t)r;
        render_case(&render, scene_of(_i), &options, 0);
        for (int level = 0; level < 2; level++) tiles[level][r] = tiles_of(&render, sizes[level]);
        render_free(&render);
    }
    for (int level = 0; level < 2; level++) {
        Counted counted = count_intervals(tiles[level], repeats);
        double part = (double)counted.covered / (double)counted.intervals, plain = (double)counted.normal / (double)counted.intervals;
        /* tiles of one picture are independent, so all intervals are */
        double error = sqrt(0.95 * 0.05 / (double)counted.intervals);
        printf("    | %s | %s | %lld | %s | %d | %.2f%% +- %.2f%% | %.2f%% |\n", c->name, c->method, (long long)c->samples,
               level ? "8 x 8 tiles" : "image", repeats, 100.0 * part, 100.0 * error, 100.0 * plain);
        ck_assert_double_le(fabs(part - 0.95), 0.01 + 3.5 * error);
        for (int r = 0; r < repeats; r++) free(tiles[level][r].mean);
        free(tiles[level]);
    }
}
END_TEST

/* Least squares of log RMSE against log samples, every level with as many samples in all; the truth's own variance is taken
 * off. The last level has 1024 or 256 pixels (times repeats / 100): its RMSE is known to 3 or 5%, the slope to 0.006 or 0.01. */
START_TEST(the_error_falls_with_the_square_root_of_samples) {
    if (!method_wanted(cases[_i].method) || !nph_test_statistics("convergence")) return;
    enum { LEVELS = 4 };
    static const int64_t samples[LEVELS] = {16, 64, 256, 1024};
    const Case *c = &cases[_i];
    int repeats = repeats_wanted(), pixels = c->width * c->height, times = repeats / 100 > 0 ? repeats / 100 : 1;
    RenderCase truth;
    NphRenderOptions options = render_options((c->width == 32 ? 32768 : 16384) * (int64_t)(times > 4 ? 4 : times), 32);
    options.seed_given = 1;
    options.seed = 7;
    options.method = "path"; /* for light too: the truth shares nothing with it */
    render_case(&truth, scene_of(_i), &options, 0);
    const float *right = nph_image_channel(&truth.image, "G")->pixels, *doubt = nph_image_channel(&truth.image, "Variance.G")->pixels;
    double sx = 0, sy = 0, sxx = 0, sxy = 0, rmse[LEVELS];
    for (int level = 0; level < LEVELS; level++) {
        int pictures = (int)(1024 / samples[level]) * times;
        double squares = 0.0;
        for (int k = 0; k < pictures; k++) {
            RenderCase render;
            options.samples = samples[level];
            options.method = c->method;
            options.seed = 100000u * (uint32_t)(level + 1) + (uint32_t)k;
            render_case(&render, scene_of(_i), &options, 0);
            const float *value = nph_image_channel(&render.image, "G")->pixels;
            for (int i = 0; i < pixels; i++) {
                double d = (double)value[i] - (double)right[i];
                squares += d * d - (double)doubt[i];
            }
            render_free(&render);
        }
        rmse[level] = sqrt(squares / pictures / pixels);
        double x = log((double)samples[level]), y = log(rmse[level]);
        sx += x;
        sy += y;
        sxx += x * x;
        sxy += x * y;
    }
    double slope = (LEVELS * sxy - sx * sy) / (LEVELS * sxx - sx * sx);
    printf("    | %s | %s | %.4g | %.4g | %.4g | %.4g | %.4f |\n", c->name, c->method, rmse[0], rmse[1], rmse[2], rmse[3], slope);
    ck_assert_double_le(fabs(slope + 0.5), 0.02);
    render_free(&truth);
}
END_TEST

static void fill(TCase *tests) {
    tcase_set_timeout(tests, 36000);
    tcase_add_loop_test(tests, intervals_of_image_and_tiles_cover_the_mean_as_often_as_they_say, 0, CASES);
    tcase_add_loop_test(tests, the_error_falls_with_the_square_root_of_samples, 0, CASES);
}

int main(void) { return nph_test_main("confidence", fill); }
