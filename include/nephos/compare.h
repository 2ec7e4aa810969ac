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
    double margin_image;   /* relative; 0.002 */
    double margin_tile;    /* relative, for 64^2 and 8^2 tiles; 0.01 */
    double alpha;          /* overall error budget; 0.01 */
} NphCompareOptions;

void nph_compare_options_default(NphCompareOptions *options);

/* One level: the whole image, 64^2 tiles, 8^2 tiles. */
typedef struct NphCompareLevel {
    const char *name;
    int regions, different, same;      /* regions tested; shown different; shown same within the margin */
    double worst_z;                    /* largest |z| */
    int worst_x, worst_y, worst_size;  /* its region */
    char worst_channel[8];
    double worst_difference;           /* relative to the image's mean */
} NphCompareLevel;

typedef struct NphComparison {
    NphVerdict verdict;
    char reason[512];
    int paired;                        /* equal seeds: judged on pixel differences */
    int level_count;
    NphCompareLevel levels[3];
    double mean_a[3], mean_b[3];       /* per channel */
    double difference[3], standard_error[3]; /* of the means, relative to mean_b's luminance */
    double relative_bias, relative_rmse, percentile_99, largest; /* of luminance, relative to B's mean */
    double pixel_histogram_p;          /* of the pixels' z against Student t; 1 when not tested */
    int64_t pixels, identical_pixels;
} NphComparison;

/* Judges A against B. Refuses (NPH_BAD_INPUT, saying which and where) different sizes, missing R G B, NaN or infinite
 * pixels. Without Variance.* on either side the verdict is same only when every pixel is equal, different otherwise.
 * z_map (may be NULL): becomes an image with Z.R, Z.G, Z.B per pixel. */
NphStatus nph_compare(NphContext *context, const NphImage *a, const NphImage *b, const NphCompareOptions *options,
                      NphComparison *comparison, NphImage *z_map);

const char *nph_verdict_name(NphVerdict verdict);

#ifdef __cplusplus
}
#endif
#endif
