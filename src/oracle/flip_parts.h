/* SPDX-License-Identifier: Apache-2.0
 *
 * The parts of FLIP: the exposures that an HDR picture is looked at with, the noise that is looked at beside the
 * candidate, the filters, and the stages of LDR-FLIP over bands of rows. flip.c puts them together. */
#ifndef NPH_ORACLE_FLIP_PARTS_H
#define NPH_ORACLE_FLIP_PARTS_H

#include "nephos/flip.h"
#include "oracle/compare_parts.h"

/* Planes of linear R, G, B. */
typedef struct NphFlipPicture {
    const float *value[3];
} NphFlipPicture;

typedef struct NphFlipTask {
    int width, height, tone_mapped, exposures;
    double pixels_per_degree, start_stops, stop_stops;
    NphFlipPicture picture[2]; /* the order does not matter */
    double *map;               /* width x height */
} NphFlipTask;

/* One-dimensional filters of 2 radius + 1 taps. */
enum { NPH_FLIP_Y, NPH_FLIP_CX, NPH_FLIP_CZ_1, NPH_FLIP_CZ_2, NPH_FLIP_CSFS };

typedef struct NphFlipFilters {
    int csf_radius, feature_radius;
    double *taps;                              /* what the others point into */
    const double *csf[NPH_FLIP_CSFS];          /* each of sum 1 */
    double cz_1, cz_2;                 /* shares of the two Gaussians of Cz, of sum 1 */
    const double *feature_gauss, *edge, *point; /* of sum 1; positive taps of sum 1, negative ones of -1 */
} NphFlipFilters;

NphStatus nph_flip_filters(NphContext *context, double pixels_per_degree, NphFlipFilters *filters);
void nph_flip_filters_free(NphContext *context, NphFlipFilters *filters);

/* Hunt-adjusted CIELAB of linear R, G, B in [0, 1]. */
void nph_flip_lab(const double rgb[3], double lab[3]);
double nph_flip_hyab(const double a[3], const double b[3]);

/* ACES curve [Narkowicz15] with its exposure of 0.6 taken out, for x >= 0; and the x that it maps to y. */
double nph_flip_aces(double x);
double nph_flip_aces_inverse(double y);

/* Fills the task's map: the largest LDR-FLIP of all exposures. */
NphStatus nph_flip_run(NphContext *context, const NphFlipTask *task);

/* First and last exposure for these luminances [Andersson21 eq. 1-3], from the lit pixels of B (of A where B is black;
 * 0 exposures where both are). */
NphStatus nph_flip_exposures(NphContext *context, const NphPicturePair *pair, NphFlipTask *task);

/* Why the noise of the pair is unknown, NULL when it is known. */
const char *nph_flip_noise_unknown(const NphPicturePair *pair);
/* Two pictures of the same mean as A and B, weighted by their precision, whose differences are normal variables of
 * the variance of A - B, correlated between the channels as A - B is. Planes R, G, B of the first, then of the second. */
void nph_flip_noise(const NphPicturePair *pair, float *const value[6]);

#endif
