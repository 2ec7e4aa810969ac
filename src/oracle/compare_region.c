/* SPDX-License-Identifier: Apache-2.0
 *
 * What the pixels of a region say about the difference of two pictures: a standard error with its degrees of freedom,
 * the p of equality and the p of a difference beyond the margin. Pixels are independent of each other, or the picture
 * says itself what the noise of its regions' means is. */
#include <math.h>

#include "oracle/compare_parts.h"
#include "oracle/student.h"

/* Fewer pixel differences than this say nothing about their own spread. */
enum { PAIRS_LEAST = 16 };
/* The margin of a dark tile: as if it had this part of the picture's luminance. */
static const double dark_tile = 0.1;
/* Storing a number as float shifts it by at most this part. */
static const double float_rounding = 1.0 / 16777216.0;

/* A sum of fixed numbers with random signs exceeds x of its standard deviations at most this much more often than a
 * normal variable: 1 / (4 P(Z > sqrt 2)) [Bentkus15 theorem 1.1]. */
static const double signs_bound = 3.178;

double nph_pixel_samples(const NphPicture *picture, int64_t pixel) {
    return picture->samples ? (double)picture->samples[pixel] : picture->samples_everywhere;
}

/* Variance of a mean and the number of samples it comes from; spread: variance of that variance. */
typedef struct Noise {
    double variance, spread, samples;
} Noise;

/* The spread relative to the variance is what the picture says (planes may lack), and no less than that of Gaussian
 * samples, 2 / (N - 1), since few samples cannot show their own tail. */
static Noise noise_of(const float *variance, const float *vovs, int64_t pixel, double samples) {
    double vov = vovs ? (double)vovs[pixel] : 0.0, own = (double)variance[pixel];
    double gaussian = samples >= 2.0 ? 2.0 / (samples - 1.0) : 0.0;
    Noise noise = {own, (vov > gaussian ? vov : gaussian) * own * own, samples};
    return noise;
}

/* With s^2 the variance per sample, N s^2's estimate in each picture and f = N - 1:
 * own    = sA^2 / NA + sB^2 / NB
 * pooled = (fA sA^2 + fB sB^2) / (fA + fB) (1 / NA + 1 / NB) */
static NphPixelNoise join_noise(Noise a, Noise b, int one_law) {
    double variance = a.variance + b.variance, spread = a.spread + b.spread;
    NphPixelNoise noise = {variance, spread, variance, spread};
    if (one_law && a.samples >= 2.0 && b.samples >= 2.0 && a.samples != b.samples) {
        double per_mean = (1.0 / a.samples + 1.0 / b.samples) / (a.samples + b.samples - 2.0);
        double weight_a = per_mean * (a.samples - 1.0) * a.samples, weight_b = per_mean * (b.samples - 1.0) * b.samples;
        noise.pooled = weight_a * a.variance + weight_b * b.variance;
        noise.pooled_spread = weight_a * weight_a * a.spread + weight_b * weight_b * b.spread;
    }
    return noise;
}

static Noise pixel_noise(const NphPicture *picture, int channel, int64_t pixel) {
    double samples = nph_pixel_samples(picture, pixel);
    return noise_of(picture->variance[channel], picture->vov[channel], pixel, samples);
}

NphPixelNoise nph_pixel_noise(const NphPicturePair *pair, int channel, int64_t pixel) {
    return join_noise(pixel_noise(&pair->a, channel, pixel), pixel_noise(&pair->b, channel, pixel), pair->one_law);
}

typedef struct Sums {
    double count, a, b, luminance_b, identical;
    NphPixelNoise noise;
    double own_square, pooled_square; /* sums of squares of all samples' differences, over N^2 */
    double noise_a, noise_b;
    int unknown;                      /* some number of samples is, or the samples are of two laws */
} Sums;

/* Adds what both pictures say of one difference d: of a pixel, or of the whole region. To the sum of squares about 0
 * instead of about the mean: (1 - 1/N) of the variance, and d^2 / N. */
static void add_noise(Noise a, Noise b, int one_law, double d, Sums *sums) {
    NphPixelNoise joint = join_noise(a, b, one_law), *noise = &joint;
    double least = a.samples < b.samples ? a.samples : b.samples;
    sums->noise_a += a.variance;
    sums->noise_b += b.variance;
    sums->noise.own += noise->own;
    sums->noise.own_spread += noise->own_spread;
    sums->noise.pooled += noise->pooled;
    sums->noise.pooled_spread += noise->pooled_spread;
    if (least < 2.0 || !one_law) {
        sums->unknown = 1;
        return;
    }
    sums->own_square += noise->own * (1.0 - 1.0 / least) + d * d / least;
    sums->pooled_square += noise->pooled * (1.0 - 1.0 / least) + d * d / least;
}

/* The noise of a region's sum, as the picture states it for the region's mean. */
static Noise region_noise(const NphPicture *picture, NphRect rect, int64_t first, int channel, double count) {
    int level = nph_level_of(rect.size);
    double samples = nph_pixel_samples(picture, first), square = count * count;
    Noise noise = noise_of(picture->region_variance[level][channel], picture->region_vov[level][channel], first, samples);
    noise.variance *= square;
    noise.spread *= square * square;
    return noise;
}

/* A picture whose pixels share samples brings the noise of the region. Against one whose pixels do not, the samples are
 * different things: nothing is pooled, and exchanging them is no symmetry. */
static void add_region_noise(const NphPicturePair *pair, NphRect rect, int channel, Sums *sums) {
    int64_t first = (int64_t)rect.y0 * pair->width + rect.x0;
    Noise none = {0}, a = none, b = none;
    if (pair->a.shared) a = region_noise(&pair->a, rect, first, channel, sums->count);
    if (pair->b.shared) b = region_noise(&pair->b, rect, first, channel, sums->count);
    if (!pair->a.shared || !pair->b.shared) sums->unknown = 1;
    add_noise(a, b, pair->one_law, sums->a - sums->b, sums);
}

static Sums add_up(const NphPicturePair *pair, NphRect rect, int channel) {
    Sums sums = {0};
    const float *a = pair->a.value[channel], *b = pair->b.value[channel];
    Noise none = {0};
    for (int y = rect.y0; y < rect.y1; y++) {
        for (int x = rect.x0; x < rect.x1; x++) {
            int64_t i = (int64_t)y * pair->width + x;
            Noise noise_a = pair->a.shared ? none : pixel_noise(&pair->a, channel, i);
            Noise noise_b = pair->b.shared ? none : pixel_noise(&pair->b, channel, i);
            sums.a += (double)a[i];
            sums.b += (double)b[i];
            sums.luminance_b += nph_pixel_luminance(&pair->b, i);
            sums.identical += a[i] == b[i];
            if (!pair->a.shared || !pair->b.shared) add_noise(noise_a, noise_b, pair->one_law, (double)a[i] - (double)b[i], &sums);
        }
    }
    sums.count = (double)(rect.x1 - rect.x0) * (double)(rect.y1 - rect.y0);
    if (pair->a.shared || pair->b.shared) add_region_noise(pair, rect, channel, &sums);
    return sums;
}

/* Fills in ratio, p_equal and p_beyond from the difference, its standard error, dof and margin. */
static void test(NphEvidence *evidence) {
    double difference = fabs(evidence->difference);
    if (evidence->standard_error > 0.0) {
        double ratio = difference / evidence->standard_error;
        if (ratio > NPH_Z_MOST) ratio = NPH_Z_MOST;
        evidence->ratio = evidence->difference < 0.0 ? -ratio : ratio;
        evidence->p_equal = 2.0 * nph_student_lower(-ratio, evidence->dof);
        evidence->p_beyond =
            nph_student_lower((difference - evidence->margin) / evidence->standard_error, evidence->dof);
    } else {
        evidence->ratio = difference == 0.0 ? 0.0 : evidence->difference < 0.0 ? -NPH_Z_MOST : NPH_Z_MOST;
        evidence->p_equal = difference == 0.0 ? 1.0 : 0.0;
        evidence->p_beyond = difference == 0.0 || difference < evidence->margin ? 0.0 : 1.0;
    }
}

/* dof = 2 V^2 / Var(V), the number for which V is distributed like chi-square; without a known spread V is exact. */
static double dof_of(double variance, double spread) {
    return spread > 0.0 ? 2.0 * variance * variance / spread : HUGE_VAL;
}

/* The standard error from the two pictures' variances. Where both have the same numbers of samples and the same law,
 * exchanging a sample of A for one of B changes only the sign of their difference: no tail, however heavy, makes t with
 * few degrees of freedom necessary beyond the bound of random signs. With unequal numbers of samples the larger of own
 * and pooled: see docs/compare.md, "Few samples against many". */
static void test_noise(const Sums *sums, NphEvidence *evidence) {
    const NphPixelNoise *noise = &sums->noise;
    int pooled = noise->pooled > noise->own;
    double variance = pooled ? noise->pooled : noise->own, spread = pooled ? noise->pooled_spread : noise->own_spread;
    evidence->standard_error = sqrt(variance) / sums->count;
    evidence->dof = dof_of(variance, spread);
    test(evidence);
    if (sums->unknown || sums->noise_a == 0.0 || sums->noise_b == 0.0) return;
    double square = pooled ? sums->pooled_square : sums->own_square;
    double p = signs_bound * 2.0 * nph_normal_lower(-fabs(sums->a - sums->b) / sqrt(square));
    if (p < evidence->p_equal) evidence->p_equal = p;
}

/* The standard error from the scatter of the region's pixel differences about their mean: what is left of the noise
 * when both pictures drew the same random numbers. */
static void test_pairs(const NphPicturePair *pair, NphRect rect, int channel, double count, NphEvidence *evidence) {
    const float *a = pair->a.value[channel], *b = pair->b.value[channel];
    double second = 0.0, fourth = 0.0;
    for (int y = rect.y0; y < rect.y1; y++) {
        for (int x = rect.x0; x < rect.x1; x++) {
            int64_t i = (int64_t)y * pair->width + x;
            double d = (double)a[i] - (double)b[i] - evidence->difference;
            second += d * d;
            fourth += d * d * d * d;
        }
    }
    double vov = second > 0.0 ? fourth / (second * second) - 1.0 / count : 0.0, gaussian = 2.0 / (count - 1.0);
    evidence->standard_error = sqrt(second / (count * (count - 1.0)));
    evidence->dof = 2.0 / (vov > gaussian ? vov : gaussian);
    test(evidence);
}

void nph_region_weigh(const NphPicturePair *pair, NphRect rect, int channel, double margin, NphEvidence *evidence) {
    Sums sums = add_up(pair, rect, channel);
    double luminance = fabs(sums.luminance_b) / sums.count, floor = dark_tile * fabs(pair->luminance_b);
    *evidence = (NphEvidence){.difference = (sums.a - sums.b) / sums.count};
    evidence->margin = margin * (luminance > floor ? luminance : floor) -
                       float_rounding * (fabs(sums.a) + fabs(sums.b)) / sums.count;
    if (pair->paired && sums.identical == sums.count) {
        evidence->dof = HUGE_VAL;
        test(evidence);
        return;
    }
    test_noise(&sums, evidence);
    if (!pair->paired || sums.count < PAIRS_LEAST) return;
    /* Both tests hold; the better one counts, at the price of two. */
    NphEvidence pairs = *evidence;
    test_pairs(pair, rect, channel, sums.count, &pairs);
    double p_equal = pairs.p_equal < evidence->p_equal ? pairs.p_equal : evidence->p_equal;
    double p_beyond = pairs.p_beyond < evidence->p_beyond ? pairs.p_beyond : evidence->p_beyond;
    if (pairs.standard_error < evidence->standard_error) *evidence = pairs;
    evidence->p_equal = p_equal < 0.5 ? 2.0 * p_equal : 1.0;
    evidence->p_beyond = p_beyond < 0.5 ? 2.0 * p_beyond : 1.0;
}
