/* SPDX-License-Identifier: Apache-2.0
 *
 * Phase functions: probability density of the scattering direction over the sphere [1/sr], as a function of
 * cos_theta = dot of the propagation directions before and after (+1 is forward). */
#ifndef NPH_OPTICS_PHASE_H
#define NPH_OPTICS_PHASE_H

#include "nephos/status.h"

typedef enum NphPhaseKind { NPH_PHASE_ISOTROPIC, NPH_PHASE_HG, NPH_PHASE_TWO_LOBE, NPH_PHASE_RAYLEIGH } NphPhaseKind;

/* isotropic: 1/4pi. hg: Henyey-Greenstein of mean cosine g[0]. two_lobe: weight * hg(g[0]) + (1-weight) * hg(g[1]).
 * rayleigh: 3/(16 pi) (1 + cos^2). |g| <= 0.99999 */
typedef struct NphPhase {
    NphPhaseKind kind;
    double g[2];
    double weight;
} NphPhase;

/* Value [1/sr] at cos_theta in [-1, 1], and the mean of cos_theta over the sphere. */
double nph_phase_value(const NphPhase *phase, double cos_theta);
double nph_phase_mean_cosine(const NphPhase *phase);

#endif
