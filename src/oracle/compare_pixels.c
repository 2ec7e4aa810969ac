/* SPDX-License-Identifier: Apache-2.0
 *
 * Single pixels: a map of their z, one chi-square test of the histogram of all z, and the metrics of luminance. Single
 * pixels never decide: at few samples of a heavy-tailed picture their z is not distributed like Student's t. */
#include <math.h>

#include "core/memory.h"
#include "core/message.h"
#include "oracle/compare_parts.h"
#include "oracle/student.h"

enum {
    BINS = 20,
    PIXELS_LEAST = 10 * BINS, /* ten expected in a bin: chi-square holds */
    PIXELS_MOST = 1 << 17,    /* tested, evenly chosen: what more would find is below what t itself is good for */
    SAMPLES_LEAST = 16
};

/* The bins' inner edges for a number of degrees of freedom: most pictures have one for all pixels. */
typedef struct Edges {
    double dof, at[BINS - 1];
} Edges;

typedef struct Tally {
    int64_t noisy, tied, bins[BINS];
    double z2, expected_z2, noise_a, noise_b, tail;
    int unequal, few;
    Edges edges;
} Tally;

static int bin_of(double z, double dof, Edges *edges) {
    if (edges->dof == 0.0) {
        edges->dof = dof;
        for (int i = 0; i < BINS - 1; i++) edges->at[i] = nph_student_quantile((i + 1.0) / BINS, dof);
    }
    int bin = 0;
    if (dof == edges->dof) {
        while (bin < BINS - 1 && z > edges->at[bin]) bin++;
    } else {
        bin = (int)(nph_student_lower(z, dof) * BINS);
    }
    return bin < BINS ? bin : BINS - 1;
}

/* Adds pixel i of a channel. Student's t has N_A + N_B - 2 degrees of freedom, exact for Gaussian samples of equal
 * number and variance, and a mean square of dof / (dof - 2). */
static void tally_pixel(const NphPicturePair *pair, int channel, int64_t i, Tally *tally) {
    double na = nph_pixel_samples(&pair->a, i), nb = nph_pixel_samples(&pair->b, i);
    double va = pair->a.variance[channel][i], vb = pair->b.variance[channel][i], variance = va + vb;
    double d = (double)pair->a.value[channel][i] - (double)pair->b.value[channel][i];
    if (!(variance > 0.0) && d == 0.0) return;
    tally->noisy++;
    tally->tied += d == 0.0;
    tally->unequal |= !(fabs(na - nb) <= 0.1 * nb);
    tally->few |= na < SAMPLES_LEAST || nb < SAMPLES_LEAST;
    if (tally->unequal || tally->few) return;
    double dof = na + nb - 2.0, z = variance > 0.0 ? d / sqrt(variance) : NPH_Z_MOST;
    tally->bins[bin_of(z, dof, &tally->edges)]++;
    tally->z2 += z * z;
    tally->expected_z2 += dof / (dof - 2.0);
    tally->noise_a += va;
    tally->noise_b += vb;
    double vov_a = pair->a.vov[channel] ? (double)pair->a.vov[channel][i] : 2.0 / na;
    double vov_b = pair->b.vov[channel] ? (double)pair->b.vov[channel][i] : 2.0 / nb;
    tally->tail += 0.5 * (vov_a - 2.0 / na + vov_b - 2.0 / nb);
}

/* Where the test would reject equal pictures: why, else NULL. Equal samples and noise: else skewness does not cancel in
 * the difference. The last bound: the tails of the samples bend the probabilities of bins by about their excess
 * kurtosis over N, which is Vov - 2 / N; the test sees what is larger than 1 / sqrt(pixels). */
static const char *why_not(const NphPicturePair *pair, int channel, const Tally *tally) {
    double noisy = (double)tally->noisy;
    if (pair->a.shared || pair->b.shared) return "pixels share samples";
    if (pair->paired) return "the pictures share their random numbers";
    if (!pair->a.vov[channel] || !pair->b.vov[channel]) return "no Vov channels";
    if (tally->noisy < PIXELS_LEAST) return "too few pixels with noise";
    if (tally->few) return "fewer than 16 samples in a pixel";
    if (tally->unequal) return "unequal numbers of samples";
    if (tally->noise_a > 2.0 * tally->noise_b || tally->noise_b > 2.0 * tally->noise_a) return "unequal noise";
    if (tally->tied * 100 > tally->noisy) return "discrete pixel values";
    if (fabs(tally->tail) > sqrt(noisy)) return "heavy tails";
    return NULL;
}

void nph_pixels_histogram(const NphPicturePair *pair, NphHistogram *histogram) {
    int channel = pair->channels == 1 ? 0 : 1; /* one channel: the noise of the three is correlated */
    int64_t count = pair->pixels < PIXELS_MOST ? pair->pixels : PIXELS_MOST;
    Tally tally = {0};
    for (int64_t k = 0; k < count; k++) {
        tally_pixel(pair, channel, k * (pair->pixels / count) + k * (pair->pixels % count) / count, &tally);
    }
    *histogram = (NphHistogram){.not_tested = why_not(pair, channel, &tally), .p = 1.0, .dispersion = 1.0};
    if (histogram->not_tested) return;
    double expected = (double)tally.noisy / BINS, chi_square = 0.0;
    for (int bin = 0; bin < BINS; bin++) {
        double d = (double)tally.bins[bin] - expected;
        chi_square += d * d / expected;
    }
    histogram->p = nph_chi_square_upper(chi_square, BINS - 1);
    histogram->dispersion = tally.z2 / tally.expected_z2;
}

void nph_select_rank(double *values, int64_t count, int64_t rank) {
    int64_t low = 0, high = count - 1;
    while (low < high) {
        double pivot = values[low + (high - low) / 2];
        int64_t i = low, j = high;
        while (i <= j) {
            while (values[i] < pivot) i++;
            while (values[j] > pivot) j--;
            if (i > j) break;
            double swap = values[i];
            values[i++] = values[j];
            values[j--] = swap;
        }
        if (rank <= j) high = j;
        else if (rank >= i) low = i;
        else return;
    }
}

/* Variance of a pixel's luminance difference with fully correlated channels: an upper bound. */
static double luminance_variance(const NphPicturePair *pair, int64_t i) {
    static const double weight[3] = {NPH_LUMINANCE_R, NPH_LUMINANCE_G, NPH_LUMINANCE_B};
    double deviation_a = 0.0, deviation_b = 0.0;
    for (int c = 0; c < 3; c++) {
        deviation_a += weight[c] * sqrt((double)pair->a.variance[c][i]);
        deviation_b += weight[c] * sqrt((double)pair->b.variance[c][i]);
    }
    return deviation_a * deviation_a + deviation_b * deviation_b;
}

NphStatus nph_pixels_metrics(NphContext *context, const NphPicturePair *pair, NphComparison *comparison) {
    double *sizes = NULL;
    NPH_TRY(NPH_NEW(context, pair->pixels, "differences of a comparison", &sizes));
    double square = 0.0, noise = 0.0, largest = 0.0, count = (double)pair->pixels;
    for (int64_t i = 0; i < pair->pixels; i++) {
        double d = nph_pixel_luminance(&pair->a, i) - nph_pixel_luminance(&pair->b, i);
        square += d * d;
        if (fabs(d) > largest) largest = fabs(d);
        if (pair->has_variance) noise += luminance_variance(pair, i);
        sizes[i] = fabs(d);
    }
    int64_t rank = pair->pixels - 1 - pair->pixels / 100;
    nph_select_rank(sizes, pair->pixels, rank);
    double scale = nph_pair_scale(pair);
    comparison->relative_bias = (pair->luminance_a - pair->luminance_b) / scale;
    comparison->relative_rmse = sqrt(square / count) / scale;
    comparison->noise_rmse = sqrt(noise / count) / scale;
    comparison->percentile_99 = sizes[rank] / scale;
    comparison->largest = largest / scale;
    nph_free(context, sizes);
    return NPH_OK;
}

static float map_value(const NphPicturePair *pair, int channel, int64_t i) {
    double d = (double)pair->a.value[channel][i] - (double)pair->b.value[channel][i];
    double variance = 0.0;
    if (pair->has_variance) variance = (double)pair->a.variance[channel][i] + (double)pair->b.variance[channel][i];
    if (d == 0.0) return 0.0f;
    double z = variance > 0.0 ? d / sqrt(variance) : d > 0.0 ? NPH_Z_MOST : -NPH_Z_MOST;
    return (float)(z > NPH_Z_MOST ? NPH_Z_MOST : z < -NPH_Z_MOST ? -NPH_Z_MOST : z);
}

NphStatus nph_pixels_map(NphContext *context, const NphPicturePair *pair, NphImage *z_map) {
    static const char *const names[3] = {"Z.R", "Z.G", "Z.B"};
    NphImage map;
    NPH_TRY(nph_image_new(context, pair->width, pair->height, &map));
    map.x0 = pair->x0;
    map.y0 = pair->y0;
    for (int c = 0; c < 3; c++) {
        float *pixels = NULL;
        NphStatus status = nph_image_add_channel(context, &map, names[c], &pixels);
        if (status != NPH_OK) {
            nph_image_free(context, &map);
            return status;
        }
        for (int64_t i = 0; i < pair->pixels; i++) pixels[i] = map_value(pair, c, i);
    }
    *z_map = map;
    return NPH_OK;
}
