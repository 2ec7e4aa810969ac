/* SPDX-License-Identifier: Apache-2.0
 *
 * Phase functions outside kernels: the same formulas in double precision. */
#include "optics/phase.h"

#include "optics/phase_lookup.h"

double nph_phase_value(const NphPhase *phase, double cos_theta) {
    RPhase lookup = r_phase(phase);
    return r_phase_at(&lookup, r_angle(cos_theta));
}

double nph_phase_mean_cosine(const NphPhase *phase) {
    switch (phase->kind) {
        case NPH_PHASE_HG: return phase->g[0];
        case NPH_PHASE_TWO_LOBE: return phase->weight * phase->g[0] + (1.0 - phase->weight) * phase->g[1];
        case NPH_PHASE_ISOTROPIC:
        case NPH_PHASE_RAYLEIGH: break;
    }
    return 0.0;
}
