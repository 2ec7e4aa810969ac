/* SPDX-License-Identifier: Apache-2.0
 *
 * Two pictures that differ by noise alone, of the size that A and B state. How the noise of the three channels hangs
 * together is taken from the differences of neighbouring pixels of (A - B) / standard error, in which a smooth real
 * difference cancels. */
#include "core/fmath.h"
#include "core/philox.h"
#include "oracle/flip_parts.h"

static const uint32_t noise_key[2] = {0x464c4950, 0}; /* "FLIP" */
static const double most_z = 5.0; /* of the correlation: fireflies and real differences do not decide it */

const char *nph_flip_noise_unknown(const NphPicturePair *pair) {
    if (pair->identical == pair->pixels) return "every pixel is equal";
    if (!pair->has_variance) return "no variances";
    if (pair->a.shared || pair->b.shared) return "pixels share samples";
    if (pair->paired) return "the pictures share their random numbers";
    return pair->unusable >= 0 ? "the variance of a pixel says nothing" : NULL;
}

static double z_of(const NphPicturePair *pair, int channel, int64_t i) {
    double variance = (double)pair->a.variance[channel][i] + (double)pair->b.variance[channel][i];
    if (!(variance > 0.0)) return 0.0;
    double z = ((double)pair->a.value[channel][i] - (double)pair->b.value[channel][i]) / nph_sqrt(variance);
    return z > most_z ? most_z : z < -most_z ? -most_z : z;
}

static void sum_products(const NphPicturePair *pair, double sums[3][3]) {
    for (int64_t i = 0; i + 1 < pair->pixels; i++) {
        double step[3];
        for (int c = 0; c < 3; c++) step[c] = z_of(pair, c, i + 1) - z_of(pair, c, i);
        for (int c = 0; c < 3; c++)
            for (int d = 0; d <= c; d++) sums[c][d] += step[c] * step[d];
    }
}

/* The Cholesky factor of the correlations of R, G and B: mixes independent normal variables into correlated ones. */
static void fill_mixer(const NphPicturePair *pair, double mixer[3][3]) {
    double sums[3][3] = {{0}};
    sum_products(pair, sums);
    for (int c = 0; c < 3; c++) {
        double rest = 1.0;
        for (int d = 0; d < c; d++) {
            double sizes = nph_sqrt(sums[c][c] * sums[d][d]), left = sizes > 0.0 ? sums[c][d] / sizes : 0.0;
            for (int k = 0; k < d; k++) left -= mixer[c][k] * mixer[d][k];
            mixer[c][d] = mixer[d][d] > 1e-6 ? left / mixer[d][d] : 0.0;
            rest -= mixer[c][d] * mixer[c][d];
        }
        mixer[c][c] = rest > 0.0 ? nph_sqrt(rest) : 0.0;
    }
}

/* Independent normal variables of a pixel [Box58]. */
static void draw_normals(int64_t pixel, double normal[3]) {
    NphWords words = nph_philox(noise_key[0], noise_key[1], (uint32_t)pixel, (uint32_t)(pixel >> 32), 0, 0);
    double sine, cosine, other;
    double size = nph_sqrt(-2.0 * nph_log(1.0 - nph_uniform(words.w0)));
    nph_sincos2pi(nph_uniform(words.w1), &sine, &cosine);
    normal[0] = size * cosine;
    normal[1] = size * sine;
    nph_sincos2pi(nph_uniform(words.w3), &other, &cosine);
    normal[2] = nph_sqrt(-2.0 * nph_log(1.0 - nph_uniform(words.w2))) * cosine;
}

/* The weighted mean of two normal variables does not depend on their difference, so with equal expectations the pair
 * made here is distributed like A and B themselves, whatever the picture below the noise is. */
void nph_flip_noise(const NphPicturePair *pair, float *const value[6]) {
    double mixer[3][3] = {{0}};
    fill_mixer(pair, mixer);
    for (int64_t i = 0; i < pair->pixels; i++) {
        double normal[3];
        draw_normals(i, normal);
        for (int c = 0; c < 3; c++) {
            double a = pair->a.value[c][i], b = pair->b.value[c][i];
            double va = pair->a.variance[c][i], vb = pair->b.variance[c][i];
            double share = va + vb > 0.0 ? va / (va + vb) : 0.5, mean = (1.0 - share) * a + share * b;
            double mixed = mixer[c][0] * normal[0] + mixer[c][1] * normal[1] + mixer[c][2] * normal[2];
            double difference = mixed * nph_sqrt(va + vb);
            value[c][i] = (float)(mean + share * difference);
            value[3 + c][i] = (float)(mean - (1.0 - share) * difference);
        }
    }
}
