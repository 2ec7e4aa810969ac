/* SPDX-License-Identifier: Apache-2.0
 *
 * Phase functions in kernels: value, sampling, and turning a direction. */
#ifndef NPH_OPTICS_PHASE_LOOKUP_H
#define NPH_OPTICS_PHASE_LOOKUP_H

#include "optics/draine_lookup.h"
#include "optics/phase.h"
#include "optics/phase_table_lookup.h"

typedef struct RPhase {
    int kind;          /* NphPhaseKind */
    Real g0, g1;
    Real rest0, rest1; /* 1 - |g|, rounded once */
    Real weight;
    RDraine draine;
    const NphPhaseHalf *half; /* of a table: two, from 0 degrees and from 180 */
} RPhase;

/* Of any kind but a table. HG of g = 0 is isotropic: the same values and directions, to the bit. */
static inline RPhase r_phase_of(int kind, double g0, double g1, double weight, double alpha) {
    RPhase out;
    int isotropic = kind == (int)NPH_PHASE_HG && nph_abs(g0) == 0.0;
    out.kind = isotropic ? (int)NPH_PHASE_ISOTROPIC : kind;
    out.g0 = (Real)g0;
    out.g1 = (Real)g1;
    out.rest0 = (Real)(1.0 - nph_abs(g0));
    out.rest1 = (Real)(1.0 - nph_abs(g1));
    out.weight = (Real)weight;
    out.draine = r_draine(g0, kind == (int)NPH_PHASE_DRAINE ? alpha : 0.0);
    out.half = NULL;
    return out;
}

static inline RPhase r_phase(const NphPhase *phase) {
    RPhase out = r_phase_of((int)phase->kind, phase->g[0], phase->g[1], phase->weight, phase->alpha);
    out.half = phase->kind == NPH_PHASE_TABULATED ? phase->table->half : NULL;
    return out;
}

/* 1 + cos^2 = 2 - fall rise */
R_INLINE Real r_rayleigh_value(RAngle angle) {
    return R(0.059683103659460751) * (R(2.0) - angle.fall * angle.rise);
}

/* cos^3 + 3 cos = 8 u - 4 by Cardano's formula; then for the distance n = 1 - |cos| to the nearer pole one Newton step
 * on n^3 - 3 n^2 + 6 n = 8 min(u, 1 - u), which gives n its relative accuracy back. */
R_INLINE RAngle r_rayleigh_sample(Real u) {
    int forward = u > R(0.5);
    Real tail = forward ? R(1.0) - u : u, q = R(2.0) - R(4.0) * tail;
    Real t = r_cbrt(q + r_sqrt(q * q + R(1.0))), near = R(1.0) - (t - R(1.0) / t);
    Real miss = near * (R(6.0) - near * (R(3.0) - near)) - R(8.0) * tail;
    near -= miss / (R(6.0) - near * (R(6.0) - R(3.0) * near));
    near = r_clamp(near, R(0.0), R(1.0));
    RAngle angle;
    angle.cosine = forward ? R(1.0) - near : near - R(1.0);
    angle.fall = forward ? near : R(2.0) - near;
    angle.rise = forward ? R(2.0) - near : near;
    return angle;
}

/* Value [1/sr], which is also the density of r_phase_angle; of the angle only fall and rise are read. */
R_INLINE Real r_phase_at(const RPhase *phase, RAngle angle) {
    if (NPH_BUG(3)) angle = (RAngle){-angle.cosine, angle.rise, angle.fall};
    if (phase->kind == NPH_PHASE_HG) return r_hg_value(phase->g0, phase->rest0, angle);
    if (phase->kind == NPH_PHASE_TWO_LOBE)
        return phase->weight * r_hg_value(phase->g0, phase->rest0, angle) +
               (R(1.0) - phase->weight) * r_hg_value(phase->g1, phase->rest1, angle);
    if (phase->kind == NPH_PHASE_RAYLEIGH) return r_rayleigh_value(angle);
    if (phase->kind == NPH_PHASE_DRAINE) return r_draine_value(&phase->draine, phase->g0, phase->rest0, angle);
    if (phase->kind == NPH_PHASE_TABULATED) return r_phase_table_value(phase->half, angle);
    return NPH_BUG(4) ? R(1.0) : R(0.079577471545947668);
}

/* Draws an angle: u in [0, 1) is the part of the distribution below it, lobe in [0, 1) chooses between two lobes. */
R_INLINE RAngle r_phase_angle(const RPhase *phase, Real u, Real lobe) {
    int second = phase->kind == NPH_PHASE_TWO_LOBE && !(lobe < phase->weight);
    if (phase->kind == NPH_PHASE_RAYLEIGH) return r_rayleigh_sample(u);
    if (phase->kind == NPH_PHASE_ISOTROPIC) return r_hg_sample(R(0.0), R(1.0), u);
    if (phase->kind == NPH_PHASE_DRAINE) return r_draine_sample(&phase->draine, phase->g0, phase->rest0, u);
    if (phase->kind == NPH_PHASE_TABULATED) return r_phase_table_sample(phase->half, u);
    return r_hg_sample(second ? phase->g1 : phase->g0, second ? phase->rest1 : phase->rest0, u);
}

/* Out: the unit vector d turned by an angle, at the azimuth u_azimuth turns around it. The frame around d is that of
 * [Duff17], which has no pole; one Newton step towards length 1 keeps errors from adding up along a path. */
R_INLINE void r_turn_by(const Real d[3], RAngle angle, Real u_azimuth, Real out[3]) {
    Real sine = r_sqrt(angle.fall * angle.rise), along, across;
    r_sincos2pi(u_azimuth, &across, &along);
    along *= sine;
    across *= sine;
    Real sign = d[2] < R(0.0) ? R(-1.0) : R(1.0), a = R(-1.0) / (sign + d[2]), b = d[0] * d[1] * a;
    Real x = along * (R(1.0) + sign * d[0] * d[0] * a) + across * b + angle.cosine * d[0];
    Real y = along * sign * b + across * (sign + d[1] * d[1] * a) + angle.cosine * d[1];
    Real z = angle.cosine * d[2] - (along * sign * d[0] + across * d[1]);
    Real scale = R(1.5) - R(0.5) * (x * x + y * y + z * z);
    out[0] = x * scale;
    out[1] = y * scale;
    out[2] = z * scale;
}

/* The same with the angle as one number, fall = 1 - cos: right for isotropic and forward peaks. A backward peak as
 * narrow as g < -0.99 loses digits in 2 - fall in single precision; r_phase_at and r_turn_by do not. */
R_INLINE RAngle r_angle_of_fall(Real fall) {
    RAngle angle = {R(1.0) - fall, fall, R(2.0) - fall};
    return angle;
}

static inline Real r_phase_value(const RPhase *phase, Real fall) { return r_phase_at(phase, r_angle_of_fall(fall)); }

static inline void r_phase_sample(const RPhase *phase, Real u, Real lobe, Real *cosine, Real *fall) {
    RAngle angle = r_phase_angle(phase, u, lobe);
    *cosine = angle.cosine;
    *fall = angle.fall;
}

static inline void r_turn(const Real d[3], Real cosine, Real fall, Real u_azimuth, Real out[3]) {
    RAngle angle = {cosine, fall, R(2.0) - fall};
    r_turn_by(d, angle, u_azimuth, out);
}

#endif
