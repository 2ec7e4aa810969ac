/* SPDX-License-Identifier: Apache-2.0
 *
 * Phase functions as sums of Legendre polynomials: p = sum (2l + 1) / (4 pi) moment_l P_l(cos), moment_l the mean of P_l; moment_0 is 1,
 * moment_1 the mean cosine. Scattering twice multiplies moments: after n times they are moment_l^n [Riley04 eq. 20], and those of a
 * mixture are the mixture's. The forward part of it is F_n [Riley04 eq. 23]. */
#ifndef NPH_OPTICS_LEGENDRE_H
#define NPH_OPTICS_LEGENDRE_H

#include "optics/phase.h"

enum { NPH_MOST_MOMENTS = 1 << 17, NPH_MOST_CONVOLUTIONS = 1024 };

/* moment[0 .. count - 1]. Closed forms; of a table the integrals of its straight lines, exact but for rounding. */
void nph_phase_moments(const NphPhase *phase, int count, double *moment);

/* How many moments give the function back: from there on, over as many again, they lie below `least`; at most NPH_MOST_MOMENTS.
 * *moment: owned, freed with nph_free. */
NphStatus nph_phase_all_moments(NphContext *context, const NphPhase *phase, double least, int *count, double **moment);

/* The function [1/sr] at 1 - |cos| from the forward or, where back, the backward pole. */
double nph_legendre_value(int count, const double *moment, double distance, int back);

/* What is left after 1, 2, ... count scatterings. */
typedef struct NphConvolutions {
    int count;
    NphPhase *after;     /* [i]: after i + 1, tabulated; owned */
    double *forward;     /* [i]: F of it */
    double negative;     /* 1/sr: the most that was lifted to 0; what the end of the sum leaves */
} NphConvolutions;

/* Tables have rows every 0.1 degrees, closer towards the poles. count at most NPH_MOST_CONVOLUTIONS. */
NphStatus nph_phase_convolve(NphContext *context, int moments, const double *moment, int count, const char *what,
                             NphConvolutions *convolutions);
void nph_convolutions_free(NphContext *context, NphConvolutions *convolutions);

#endif
