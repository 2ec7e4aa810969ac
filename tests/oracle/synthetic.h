/* SPDX-License-Identifier: Apache-2.0
 *
 * Synthetic renderers for calibrating the comparator: every pixel's samples are drawn one by one from a known
 * distribution (Philox, fixed seeds), and the pixel carries their mean, variance of the mean and Vov as film/ computes
 * them. Samples come from a table of 2^16 equally probable values, the last of which is 2^16 values of its own, so that
 * mean and variance are known exactly and tails reach 2^-32. */
#ifndef NPH_TESTS_SYNTHETIC_H
#define NPH_TESTS_SYNTHETIC_H

#include <math.h>
#include <stdlib.h>

#include "core/philox.h"
#include "harness.h"
#include "nephos/image.h"
#include "oracle/student.h"

enum { SYNTHETIC_TABLE = 65536 };

typedef struct Distribution {
    const char *name;
    float body[SYNTHETIC_TABLE], tail[SYNTHETIC_TABLE];
    double mean, deviation; /* of a sample */
} Distribution;

/* Quantile of a sample whose upper tail has probability q. */
typedef double Quantile(double normal, double q);

static inline double gaussian_quantile(double normal, double q) {
    (void)q;
    return 1.0 + 0.5 * normal;
}
static inline double exponential_quantile(double normal, double q) {
    (void)normal;
    return -log(q);
}
static inline double lognormal_quantile(double normal, double q) {
    (void)q;
    return exp(2.0 * normal);
}
/* A glow of 0.2 to 0.6, and fireflies: 4% of the samples follow a Pareto law with infinite fourth moment. */
static inline double firefly_quantile(double normal, double q) {
    (void)normal;
    return q > 0.04 ? 0.2 + 0.4 * (1.0 - q) : pow(q / 0.04, -1.0 / 2.2);
}

/* The normal quantile by Newton's method from a neighbour: fast for sorted probabilities. */
static inline double normal_from(double start, double q) {
    for (int i = 0; i < 4; i++) {
        double density = 0.3989422804014327 * exp(-0.5 * start * start);
        start += (nph_normal_lower(-start) - q) / density;
    }
    return start;
}

static inline void distribution_make(Distribution *made, const char *name, Quantile *quantile) {
    double normal = -4.2, sum = 0.0, square = 0.0, count = SYNTHETIC_TABLE;
    made->name = name;
    for (int k = 0; k < SYNTHETIC_TABLE; k++) {
        double q = 1.0 - (k + 0.5) / count;
        normal = normal_from(normal, q);
        made->body[k] = (float)quantile(normal, q);
    }
    for (int k = 0; k < SYNTHETIC_TABLE; k++) {
        double q = (1.0 - (k + 0.5) / count) / count;
        normal = normal_from(normal, q);
        made->tail[k] = (float)quantile(normal, q);
        sum += (double)made->tail[k] / count;
        square += (double)made->tail[k] * (double)made->tail[k] / count;
    }
    for (int k = 0; k < SYNTHETIC_TABLE - 1; k++) {
        sum += (double)made->body[k];
        square += (double)made->body[k] * (double)made->body[k];
    }
    made->mean = sum / count;
    made->deviation = sqrt(square / count - made->mean * made->mean);
}

static inline float distribution_draw(const Distribution *distribution, uint32_t word) {
    uint32_t index = word >> 16;
    return index == SYNTHETIC_TABLE - 1 ? distribution->tail[word & 0xFFFF] : distribution->body[index];
}

/* What the samples of a pixel left, relative to the distribution's mean. */
typedef struct Moments {
    double mean, variance_of_mean, vov;
} Moments;

static inline Moments moments_of(const float *samples, int count, double scale) {
    double sum = 0.0, second = 0.0, fourth = 0.0;
    for (int i = 0; i < count; i++) sum += (double)samples[i];
    double mean = sum / count;
    for (int i = 0; i < count; i++) {
        double d = (double)samples[i] - mean, d2 = d * d;
        second += d2;
        fourth += d2 * d2;
    }
    Moments moments = {mean / scale, second / ((double)count * (count - 1.0)) / (scale * scale),
                       second > 0.0 ? fourth / (second * second) - (count - 3.0) / (count * (count - 1.0)) : 0.0};
    return moments;
}

/* Moments of `pixels` pixels with `count` samples each (a multiple of 4, at most 4096). */
static inline void draw_pixels(const Distribution *distribution, uint32_t seed, int pixels, int count,
                               Moments *moments) {
    float samples[4096];
    for (int p = 0; p < pixels; p++) {
        for (int i = 0; i < count; i += 4) {
            NphWords words = nph_philox(seed, 0x5EED, (uint32_t)p, (uint32_t)i, 0, 0);
            samples[i] = distribution_draw(distribution, words.w0);
            samples[i + 1] = distribution_draw(distribution, words.w1);
            samples[i + 2] = distribution_draw(distribution, words.w2);
            samples[i + 3] = distribution_draw(distribution, words.w3);
        }
        moments[p] = moments_of(samples, count, distribution->mean);
    }
}

/* The expected picture: a bright cloud with an edge and texture over a darkening sky. */
static inline void synthetic_scene(int width, int height, int channel, double *scene) {
    for (int y = 0; y < height; y++) {
        for (int x = 0; x < width; x++) {
            double sky = 0.5 - 0.004 * y + 0.05 * channel, dx = x - 50.3, dy = (y - 12.1) * 2.0;
            double inside = 1.0 - (dx * dx + dy * dy) / 900.0;
            double cloud = 1.0 + 0.3 * sin(0.7 * x) * sin(0.9 * y) + inside - 0.1 * channel;
            scene[y * width + x] = inside > 0.0 ? cloud : sky;
        }
    }
}

static const char *const synthetic_names[3][3] = {
    {"R", "Variance.R", "Vov.R"}, {"G", "Variance.G", "Vov.G"}, {"B", "Variance.B", "Vov.B"}};

/* An image with R G B, Variance.*, Vov.* and, for samples > 0, N. */
static inline NphImage synthetic_image(NphContext *context, int width, int height, int samples) {
    NphImage image;
    float *plane;
    ck_assert_int_eq(nph_image_new(context, width, height, &image), NPH_OK);
    for (int c = 0; c < 3; c++) {
        for (int k = 0; k < 3; k++) {
            ck_assert_int_eq(nph_image_add_channel(context, &image, synthetic_names[c][k], &plane), NPH_OK);
        }
    }
    if (samples > 0) {
        ck_assert_int_eq(nph_image_add_channel(context, &image, "N", &plane), NPH_OK);
        for (int i = 0; i < width * height; i++) plane[i] = (float)samples;
    }
    return image;
}

static inline float *synthetic_plane(NphImage *image, const char *name) {
    return nph_image_channel(image, name)->pixels;
}

/* Fills a channel with a scene of expectations times `brightness`, its noise that of the moments times `noise` (0: the
 * exact picture). */
static inline void synthetic_fill(NphImage *image, int channel, const double *scene, const Moments *moments,
                                  double noise, double brightness) {
    float *value = synthetic_plane(image, synthetic_names[channel][0]);
    float *variance = synthetic_plane(image, synthetic_names[channel][1]);
    float *vov = synthetic_plane(image, synthetic_names[channel][2]);
    for (int i = 0; i < image->width * image->height; i++) {
        double expected = scene[i] * brightness, deviation = expected * noise;
        value[i] = (float)(expected + deviation * (moments[i].mean - 1.0));
        variance[i] = (float)(deviation * deviation * moments[i].variance_of_mean);
        vov[i] = noise > 0.0 ? (float)moments[i].vov : 0.0f;
    }
}

#endif
