/* SPDX-License-Identifier: Apache-2.0
 *
 * See kernel_phase.h. */
#include "kernel_phase.h"

#include "core/philox.h"
#include "optics/phase_lookup.h"

void NPH_KERNEL(phase_draw)(const NphPhase *phase, const uint32_t *u, const uint32_t *lobe, double *const out[3],
                            int count) {
    RPhase lookup = r_phase(phase);
    for (int i = 0; i < count; i++) {
        RAngle angle = r_phase_angle(&lookup, r_uniform(u[i]), r_uniform(lobe[i]));
        Real plain_cosine, plain_fall;
        r_phase_sample(&lookup, r_uniform(u[i]), r_uniform(lobe[i]), &plain_cosine, &plain_fall);
        out[0][i] = (double)angle.fall;
        out[1][i] = (double)angle.rise;
        out[2][i] = plain_cosine == angle.cosine && plain_fall == angle.fall ? (double)angle.cosine : nph_nan();
    }
}

void NPH_KERNEL(phase_value)(const NphPhase *phase, const double *fall, const double *rise, double *value, int count) {
    RPhase lookup = r_phase(phase);
    for (int i = 0; i < count; i++) {
        if (!rise) {
            value[i] = (double)r_phase_value(&lookup, (Real)fall[i]);
            continue;
        }
        RAngle angle = {R(1.0) - (Real)fall[i], (Real)fall[i], (Real)rise[i]};
        value[i] = (double)r_phase_at(&lookup, angle);
    }
}

void NPH_KERNEL(phase_turn)(double d_[3], const double *fall, const double *rise, const double *azimuth, int count) {
    Real d[3] = {(Real)d_[0], (Real)d_[1], (Real)d_[2]};
    for (int i = 0; i < count; i++) {
        Real turned[3];
        RAngle angle = {R(0.0), (Real)fall[i], (Real)rise[i]};
        angle.cosine = fall[i] < rise[i] ? R(1.0) - angle.fall : angle.rise - R(1.0);
        r_turn_by(d, angle, (Real)azimuth[i], turned);
        for (int a = 0; a < 3; a++) d[a] = turned[a];
    }
    for (int a = 0; a < 3; a++) d_[a] = (double)d[a];
}
