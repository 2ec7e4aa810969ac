/* SPDX-License-Identifier: Apache-2.0
 *
 * Spheres of many sizes, at one wavelength or the mean over several: sums over a grid of ln r that is halved until it no longer
 * matters, and intensities at any angles for it. */
#ifndef NPH_OPTICS_MIE_CLOUD_H
#define NPH_OPTICS_MIE_CLOUD_H

#include "nephos/context.h"
#include "optics/mie.h"
#include "optics/sizes.h"

enum { NPH_MIE_WAVELENGTHS = 60, NPH_MIE_MOST_SIZES = 1 << 16 };

typedef struct NphMieRequest {
    NphSizes sizes;
    int wavelength_count;                      /* 1 to NPH_MIE_WAVELENGTHS */
    double wavelength_um[NPH_MIE_WAVELENGTHS]; /* in vacuum */
    double index[NPH_MIE_WAVELENGTHS][2];      /* n, k of the spheres; the surroundings have 1 */
    double tolerance; /* relative: of the sum over sizes, as size_error below, and of the value between angles */
    int most_angles;  /* 0: NPH_MIE_MOST_ANGLES */
} NphMieRequest;

/* Sums over sizes and wavelengths; cross sections [um^2] are means over particles, each wavelength counting once. */
typedef struct NphMieTotals {
    double extinction_um2, scattering_um2, absorption_um2, geometric_um2, asymmetry;
    double effective_radius_um, effective_variance;
} NphMieTotals;

typedef struct NphMieCloud {
    const NphMieRequest *request;
    double first, step; /* of ln r */
    int64_t points;
    double size_error;  /* what the last halving changed, relative: root mean square over angles, or ten times of extinction and 1 - g */
    double weight_sum;
    NphMieTotals totals;
} NphMieCloud;

/* Angles as distances 1 - |cos| from the nearer pole; back[i] != 0: the backward one. */
typedef struct NphMieAngles {
    int64_t count;
    const double *distance;
    const unsigned char *back;
} NphMieAngles;

/* NPH_BAD_INPUT names what is out of range; else the largest size parameter. */
NphStatus nph_mie_check(NphContext *context, const NphMieRequest *request, const char *what, double *largest_x);

/* Chooses the grid by the phase function at these angles, which it gives too [1/sr]. A grid of NPH_MIE_MOST_SIZES that
 * still changes warns. The request outlives the cloud. */
NphStatus nph_mie_cloud(NphContext *context, const NphMieRequest *request, const NphMieAngles *probe, const char *what,
                        NphMieCloud *cloud, double *value);

/* The phase function [1/sr] at any angles. */
NphStatus nph_mie_cloud_values(NphContext *context, const NphMieCloud *cloud, const NphMieAngles *angles, double *value);

#endif
