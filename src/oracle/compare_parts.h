/* SPDX-License-Identifier: Apache-2.0
 *
 * The parts of a comparison, in the order they run: read both pictures, weigh the evidence of a region, judge a level
 * of tiles, look at single pixels. docs/compare.md derives the formulas; compare.c draws the verdict. */
#ifndef NPH_ORACLE_COMPARE_PARTS_H
#define NPH_ORACLE_COMPARE_PARTS_H

#include <stddef.h>
#include <stdint.h>

#include "film/regions.h"
#include "nephos/compare.h"

/* z of a difference without noise; also what a map holds instead of an infinity. */
#define NPH_Z_MOST 1e30
/* Rec. 709 luminance, as in film/. */
#define NPH_LUMINANCE_R 0.2126
#define NPH_LUMINANCE_G 0.7152
#define NPH_LUMINANCE_B 0.0722

/* Planes of one picture; those that a file may lack are NULL. */
typedef struct NphPicture {
    const float *value[3], *variance[3], *vov[3], *samples;
    const float *region_variance[NPH_REGION_LEVELS][3]; /* of regions' means, where pixels share samples; else NULL */
    const float *region_vov[NPH_REGION_LEVELS][3];
    int shared;                                         /* they do */
    double samples_everywhere; /* from the attribute "samples" where there is no plane N; 0: unknown */
} NphPicture;

typedef struct NphPicturePair {
    NphPicture a, b;
    int x0, y0, width, height;
    int channels;          /* 1: grey, the three channels are one hypothesis; else 3 */
    int has_variance;      /* in both pictures */
    int64_t unusable;      /* first pixel whose variance says nothing (one sample, out of range); -1: none */
    int few_images;        /* pixels of A or B share samples, and there are too few of them for an error bar */
    int one_law;           /* the samples may be of one law: not where both name a method, and another one */
    int paired;            /* same scene, method and seed: the noise is correlated */
    int64_t pixels, identical;
    double luminance_a, luminance_b; /* means over the picture */
} NphPicturePair;

/* Validates and gathers; a and b must outlive the pair. */
NphStatus nph_pair_read(NphContext *context, const NphImage *a, const NphImage *b, NphPicturePair *pair);

/* What differences are reported relative to: B's luminance; A's where B is black, 1 where both are. */
double nph_pair_scale(const NphPicturePair *pair);

static inline double nph_pixel_luminance(const NphPicture *picture, int64_t i) {
    return NPH_LUMINANCE_R * (double)picture->value[0][i] + NPH_LUMINANCE_G * (double)picture->value[1][i] +
           NPH_LUMINANCE_B * (double)picture->value[2][i];
}

/* Puts the value of rank `rank` (from 0) at its place, smaller ones before it (Hoare's selection). */
void nph_select_rank(double *values, int64_t count, int64_t rank);

/* Fewer whole images than this say nothing about their own spread. */
enum { NPH_IMAGES_LEAST = 32 };

/* Noise of one pixel's difference A - B: its variance, and the variance of that estimate. `own` trusts each picture's
 * variance for itself; `pooled` takes the variance per sample to be the same in both. */
typedef struct NphPixelNoise {
    double own, own_spread, pooled, pooled_spread;
} NphPixelNoise;
NphPixelNoise nph_pixel_noise(const NphPicturePair *pair, int channel, int64_t pixel);
/* Samples of a pixel, 0 when unknown. */
double nph_pixel_samples(const NphPicture *picture, int64_t pixel);

/* Number of the level of regions of that size (regions.h). */
static inline int nph_level_of(int size) { return size == nph_region_sizes[0] ? 0 : size == nph_region_sizes[1] ? 1 : 2; }

typedef struct NphRect {
    int x0, y0, x1, y1; /* in pixels of the data window, x1 and y1 outside */
    int size;           /* of the level's tiles; 0: the whole picture */
} NphRect;

/* What a region says about one channel. */
typedef struct NphEvidence {
    double difference, standard_error, dof; /* of mean A - mean B */
    double ratio;                           /* difference / standard_error, at most NPH_Z_MOST */
    double p_equal;                         /* two-sided p of "the expectations are equal" */
    double p_beyond;                        /* p of "they differ by the margin or more" (TOST) */
    double margin;                          /* absolute, less what storing floats may have shifted */
} NphEvidence;

/* margin: relative to the larger of the region's luminance in B and a tenth of the picture's. */
void nph_region_weigh(const NphPicturePair *pair, NphRect rect, int channel, double margin, NphEvidence *evidence);

/* A region worth naming. channel < 0: none. */
typedef struct NphFinding {
    NphRect rect;
    int channel;
    NphEvidence evidence;
} NphFinding;

typedef struct NphLevelTask {
    const char *name;
    int size;              /* of tiles; 0: the whole picture */
    double margin;         /* relative */
    double alpha;          /* this level's share of the budget */
    double alpha_same;     /* level of the equivalence tests */
} NphLevelTask;

typedef struct NphLevelFindings {
    NphCompareLevel level;
    NphFinding different;   /* the most certain difference that is not within the margin */
    NphFinding forgiven;    /* the most certain difference that is within it */
    NphFinding undecided;   /* the region that needs most samples to be shown the same */
    double more_samples;    /* how many times as many it needs */
    NphEvidence first[3];   /* of the first region, by channel */
} NphLevelFindings;

/* Holm's test over all regions x channels of a level, and the equivalence test of each. */
NphStatus nph_level_judge(NphContext *context, const NphPicturePair *pair, const NphLevelTask *task,
                          NphLevelFindings *findings);

/* One test of the histogram of the pixels' z. */
typedef struct NphHistogram {
    const char *not_tested; /* why not; NULL when it was */
    double p;               /* 1 when not tested */
    double dispersion;      /* mean z^2 over its expectation: 1 when the error bars are right */
} NphHistogram;
void nph_pixels_histogram(const NphPicturePair *pair, NphHistogram *histogram);

/* relative_bias, relative_rmse, noise_rmse, percentile_99, largest. */
NphStatus nph_pixels_metrics(NphContext *context, const NphPicturePair *pair, NphComparison *comparison);
NphStatus nph_pixels_map(NphContext *context, const NphPicturePair *pair, NphImage *z_map);

#endif
