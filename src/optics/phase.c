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
        case NPH_PHASE_DRAINE: { /* [Draine03] */
            double g = phase->g[0], alpha = phase->alpha;
            return g * (1.0 + alpha * (3.0 + 2.0 * g * g) / 5.0) / (1.0 + alpha * (1.0 + 2.0 * g * g) / 3.0);
        }
        case NPH_PHASE_TABULATED: return phase->table->mean_cosine;
        case NPH_PHASE_ISOTROPIC:
        case NPH_PHASE_RAYLEIGH:
        case NPH_PHASE_KINDS: break;
    }
    return 0.0;
}

/* All but tables have their peak at a pole: a sum of lobes is convex in the cosine, and cos^2 is largest at both. */
double nph_phase_peak(const NphPhase *phase) {
    double front = nph_phase_value(phase, 1.0), back = nph_phase_value(phase, -1.0), most = front > back ? front : back;
    for (int h = 0; h < 2 && phase->kind == NPH_PHASE_TABULATED; h++) {
        const NphPhaseHalf *half = &phase->table->half[h];
        for (int i = 0; i <= half->count; i++) most = half->value[i] > most ? half->value[i] : most;
    }
    return most;
}
