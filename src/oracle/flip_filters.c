/* SPDX-License-Identifier: Apache-2.0
 *
 * FLIP's filters [Andersson20 sections 4.1 and 4.2]: contrast sensitivity functions of the three opponent channels as
 * sums of Gaussians, and first and second derivatives of a Gaussian. All of them are products of one-dimensional filters,
 * but the sum of two Gaussians of Cz, whose terms are. */
#include <math.h>

#include "core/fmath.h"
#include "core/memory.h"
#include "core/message.h"
#include "oracle/flip_parts.h"

static const double pi = 3.141592653589793;

/* The CSF's Gaussians a sqrt(pi / b) exp(-pi^2 x^2 / b), x in degrees [Andersson20 table 1]. */
static const struct {
    double a, b;
} gaussians[NPH_FLIP_CSFS] = {{1, 0.0047}, {1, 0.0053}, {34.1, 0.04}, {13.5, 0.025}};
static const double widest = 0.04, feature_width_degrees = 0.082;

/* What a filter's taps are of: a Gaussian's value, or its first or second derivative. */
typedef enum Derivative { VALUE, FIRST, SECOND } Derivative;

static double tap_at(Derivative derivative, double x, double sigma) {
    double u = x / sigma, value = nph_exp(-0.5 * u * u);
    return derivative == VALUE ? value : derivative == FIRST ? -x * value : (u * u - 1.0) * value;
}

/* Positive taps made to sum to 1, negative ones to -1. Returns the sum of the positive ones before. */
static double fill_taps(Derivative derivative, double sigma, int radius, double *taps) {
    double positive = 0.0, negative = 0.0;
    for (int i = -radius; i <= radius; i++) {
        double tap = tap_at(derivative, i, sigma);
        taps[i + radius] = tap;
        if (tap > 0.0) positive += tap;
        else negative -= tap;
    }
    for (int i = 0; i <= 2 * radius; i++) {
        double sum = taps[i] > 0.0 ? positive : negative;
        if (sum > 0.0) taps[i] /= sum;
    }
    return positive;
}

static int radius_of(double sigma) { return (int)ceil(3.0 * sigma); }

NphStatus nph_flip_filters(NphContext *context, double pixels_per_degree, NphFlipFilters *filters) {
    double feature_sigma = 0.5 * feature_width_degrees * pixels_per_degree, volume[NPH_FLIP_CSFS];
    NphFlipFilters made = {.csf_radius = radius_of(nph_sqrt(widest / (2.0 * pi * pi)) * pixels_per_degree),
                           .feature_radius = radius_of(feature_sigma)};
    size_t csf_taps = 2 * (size_t)made.csf_radius + 1, feature_taps = 2 * (size_t)made.feature_radius + 1;
    NPH_TRY(NPH_NEW(context, NPH_FLIP_CSFS * csf_taps + 3 * feature_taps, "filters of FLIP", &made.taps));
    double *at = made.taps;
    for (int i = 0; i < NPH_FLIP_CSFS; i++, at += csf_taps) {
        double b = gaussians[i].b;
        double sum = fill_taps(VALUE, nph_sqrt(b / (2.0 * pi * pi)) * pixels_per_degree, made.csf_radius, at);
        volume[i] = gaussians[i].a * nph_sqrt(pi / b) * sum * sum; /* of the two-dimensional term */
        made.csf[i] = at;
    }
    double both = volume[NPH_FLIP_CZ_1] + volume[NPH_FLIP_CZ_2];
    made.cz_1 = volume[NPH_FLIP_CZ_1] / both;
    made.cz_2 = volume[NPH_FLIP_CZ_2] / both;
    fill_taps(VALUE, feature_sigma, made.feature_radius, at);
    fill_taps(FIRST, feature_sigma, made.feature_radius, at + feature_taps);
    fill_taps(SECOND, feature_sigma, made.feature_radius, at + 2 * feature_taps);
    made.feature_gauss = at;
    made.edge = at + feature_taps;
    made.point = at + 2 * feature_taps;
    *filters = made;
    return NPH_OK;
}

void nph_flip_filters_free(NphContext *context, NphFlipFilters *filters) { nph_free(context, filters->taps); }
