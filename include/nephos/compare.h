/* SPDX-License-Identifier: Apache-2.0
 *
 * Comparison of two pictures that carry their own error bars. docs/compare.md tells the statistics. */
#ifndef NEPHOS_COMPARE_H
#define NEPHOS_COMPARE_H

#include <stdint.h>

#include "nephos/image.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum NphVerdict { NPH_SAME, NPH_NOT_SAME, NPH_INCONCLUSIVE } NphVerdict;

typedef struct NphCompareOptions {
    double margin_image;   /* relative to B's mean luminance; 0.002 */
    double margin_tile;    /* relative to a tile's, for 64^2 and 8^2 tiles; 0.01 */
    double alpha;          /* error budget: the probability of `different` for equal expectations, and of `same` for a
                              region that differs by its margin; 0.004, so that 500 equal pairs hold at most 5 false
                              alarms (1%) with probability 98% */
    int allow_noisy_tiles; /* 1: tiles need not be shown the same, only not different; 0 */
} NphCompareOptions;

void nph_compare_options_default(NphCompareOptions *options);

/* One level: the whole image, 64^2 tiles, 8^2 tiles. A level whose only tile is the image is left out. */
typedef struct NphCompareLevel {
    const char *name;
    int regions, different, same;      /* regions tested; shown different; shown same within the margin */
    double worst_z;                    /* largest |z|: of a normal variable as improbable; 1e30 without noise */
    int worst_x, worst_y, worst_size;  /* its region */
    char worst_channel[8];             /* "R", "G", "B"; "RGB" when the pictures are grey */
    double worst_difference;           /* relative to the image's mean */
    NphVerdict verdict;                /* of this level alone */
} NphCompareLevel;

typedef struct NphComparison {
    NphVerdict verdict;
    char reason[512];
    int paired;                        /* equal seeds: judged on pixel differences */
    int level_count;
    NphCompareLevel levels[3];
    double mean_a[3], mean_b[3];       /* per channel */
    double difference[3], standard_error[3]; /* of the means, relative to mean_b's luminance */
    double relative_bias, relative_rmse, percentile_99, largest; /* of luminance, relative to B's mean, with noise */
    double noise_rmse;                 /* the part of relative_rmse that noise alone would give, at most; 0: unknown */
    double pixel_histogram_p;          /* of the pixels' z against Student t; 1 when not tested */
    const char *pixel_histogram_not_tested; /* why not; NULL when it was */
    int64_t pixels, identical_pixels;
} NphComparison;

/* Judges A against B; NPH_OK whatever the verdict. Refuses (NPH_BAD_INPUT, saying which and where) different sizes,
 * missing R G B, NaN or infinite pixels, negative variances. When either lacks Variance.* the verdict is same only when
 * every pixel is equal, different otherwise; an exact reference carries Variance.* of 0 and no N.
 * z_map (may be NULL): becomes an image with Z.R, Z.G, Z.B per pixel (within +-1e30), to be freed by the caller. */
NphStatus nph_compare(NphContext *context, const NphImage *a, const NphImage *b, const NphCompareOptions *options,
                      NphComparison *comparison, NphImage *z_map);

const char *nph_verdict_name(NphVerdict verdict);

#ifdef __cplusplus
}
#endif
#endif
