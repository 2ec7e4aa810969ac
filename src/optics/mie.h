/* SPDX-License-Identifier: Apache-2.0
 *
 * Scattering by a homogeneous sphere [Bohren83 ch. 4]. Size parameter x = 2 pi radius / wavelength, both in the surrounding
 * medium; refractive index n + i k relative to it, k >= 0 absorbs (time factor exp(-i w t); tables made with the other sign have
 * conjugate amplitudes). Stable for x from 1e-6 to 1e5 and |n + i k| x up to 1e6: logarithmic derivatives run downwards, psi runs
 * upwards below order x and by ratios above it, and the efficiencies are sums of positive terms, so that neither small spheres nor
 * weak absorption lose digits. */
#ifndef NPH_OPTICS_MIE_H
#define NPH_OPTICS_MIE_H

#include <stdint.h>

typedef struct NphMieSphere {
    double x, n, k;
} NphMieSphere;

#define NPH_MIE_LEAST_X 1e-6
#define NPH_MIE_MOST_X 1e5
#define NPH_MIE_MOST_MX 1e6

/* Per geometrical cross section. back: 4 |S(180)|^2 / x^2, 4 pi times the part per steradian. */
typedef struct NphMie {
    double extinction, scattering, absorption, back, asymmetry;
} NphMie;

/* a_n, b_n of order i + 1 at i, and room to make them: from one block of nph_mie_doubles(sphere) doubles. */
typedef struct NphMieTerms {
    int count;
    double *a_re, *a_im, *b_re, *b_im;
    double *absorbed; /* Re a - |a|^2 + Re b - |b|^2, without their cancellation */
    double *scratch;
} NphMieTerms;

/* Orders that are summed: beyond them |a_n|, |b_n| are below 1e-16. */
int nph_mie_orders(double x);
int64_t nph_mie_doubles(const NphMieSphere *sphere);
void nph_mie_terms(const NphMieSphere *sphere, double *block, NphMieTerms *terms);

void nph_mie_efficiencies(const NphMieSphere *sphere, const NphMieTerms *terms, NphMie *mie);

/* S1 (perpendicular) and S2 (parallel), real and imaginary part, at the distance 1 - cos, in [0, 1], from the forward pole, or
 * where `back` from the backward one. */
void nph_mie_amplitudes(const NphMieTerms *terms, double distance, int back, double s1[2], double s2[2]);

#endif
