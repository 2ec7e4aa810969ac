/* SPDX-License-Identifier: Apache-2.0
 *
 * A chunk becomes a level-0 node: 16 samples of a pixel to mean and central moments, in double for either precision.
 *
 * The lanes are the 16 samples of a pixel. Sums are the binary tree that adds i + 8 to i, i + 4 to i, i + 2 to i, i + 1
 * to i: equal samples give 16 x exactly, so their mean is x and their moments are 0. Moments take two passes:
 *   mean = 1/16 sum x,   Mk = sum (x - mean)^k.
 * gcc unrolls the loops of 16 and packs the straight code that is left, so no loop carries the tag of a vector loop. */
#include "core/real.h"
#include "film/moments.h"

void NPH_KERNEL(nph_film_chunk)(const void *samples, int channels, double *node);

static inline double tree_sum(const double x[NPH_CHUNK]) {
    double sum[NPH_CHUNK / 2];
    for (int i = 0; i < 8; i++) sum[i] = x[i] + x[i + 8];
    for (int i = 0; i < 4; i++) sum[i] += sum[i + 4];
    for (int i = 0; i < 2; i++) sum[i] += sum[i + 2];
    return sum[0] + sum[1];
}

static void reduce_moments(const Real *restrict samples, double *restrict out) {
    for (int pixel = 0; pixel < NPH_TILE_PIXELS; pixel++) {
        double x[NPH_CHUNK], d2[NPH_CHUNK], d3[NPH_CHUNK], d4[NPH_CHUNK];
        for (int i = 0; i < NPH_CHUNK; i++) x[i] = (double)samples[pixel * NPH_CHUNK + i];
        double mean = tree_sum(x) * (1.0 / NPH_CHUNK);
        for (int i = 0; i < NPH_CHUNK; i++) {
            double d = x[i] - mean;
            d2[i] = d * d;
            d3[i] = d2[i] * d;
            d4[i] = d2[i] * d2[i];
        }
        out[pixel] = mean;
        out[1 * NPH_TILE_PIXELS + pixel] = tree_sum(d2);
        out[2 * NPH_TILE_PIXELS + pixel] = tree_sum(d3);
        out[3 * NPH_TILE_PIXELS + pixel] = tree_sum(d4);
    }
}

static void reduce_mean(const Real *restrict samples, double *restrict out) {
    for (int pixel = 0; pixel < NPH_TILE_PIXELS; pixel++) {
        double x[NPH_CHUNK];
        for (int i = 0; i < NPH_CHUNK; i++) x[i] = (double)samples[pixel * NPH_CHUNK + i];
        out[pixel] = tree_sum(x) * (1.0 / NPH_CHUNK);
    }
}

void NPH_KERNEL(nph_film_chunk)(const void *samples, int channels, double *node) {
    const Real *base = samples;
    const int plane = NPH_TILE_PIXELS * NPH_CHUNK;
    for (int c = 0; c < channels; c++)
        reduce_moments(base + (NPH_SAMPLE_L0 + c) * plane, node + NPH_MOMENTS * c * NPH_TILE_PIXELS);
    double *out = node + nph_film_value_transmittance(channels) * NPH_TILE_PIXELS;
    for (int c = 0; c < channels; c++, out += NPH_TILE_PIXELS) reduce_mean(base + (NPH_SAMPLE_T0 + c) * plane, out);
    for (int f = NPH_SAMPLE_ORDER; f < NPH_SAMPLE_FIELDS; f++, out += NPH_TILE_PIXELS)
        reduce_mean(base + f * plane, out);
}
