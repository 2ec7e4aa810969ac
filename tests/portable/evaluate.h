/* SPDX-License-Identifier: Apache-2.0
 *
 * out = function(in) for the functions of functions.h, words in and out, by the names of nephos/portable.h: compiled as
 * C99, C++ and OpenCL C, and by core_names.h against the library's own headers. */
#ifndef NPH_TESTS_EVALUATE_H
#define NPH_TESTS_EVALUATE_H

#include "functions.h"

#define X_(i) nph_from_bitsf(in[i])
#define PUT_(i, x) out[i] = nph_bitsf(x)
#define UNARY_(name) \
    case F_##name: PUT_(0, nph_##name##f(X_(0))); break

NPH_PORTABLE_FN void nph_put_words(NphWords words, NphU32 *out) {
    out[0] = words.w0;
    out[1] = words.w1;
    out[2] = words.w2;
    out[3] = words.w3;
}

NPH_PORTABLE_FN void nph_put_angle(NphScatterAnglef angle, NphU32 *out) {
    PUT_(0, angle.cosine);
    PUT_(1, angle.fall);
    PUT_(2, angle.rise);
}

NPH_PORTABLE_FN NphScatterAnglef nph_get_angle(float cosine, float fall, float rise) {
    NphScatterAnglef angle = {cosine, fall, rise};
    return angle;
}

NPH_PORTABLE_FN NphPhasef nph_get_phase(const NphU32 *in) {
    NphPhasef phase;
    phase.kind = (int)in[0];
    phase.g0 = X_(1);
    phase.g1 = X_(2);
    phase.rest0 = X_(3);
    phase.rest1 = X_(4);
    phase.weight = X_(5);
    phase.draine.alpha = X_(6);
    phase.draine.norm = X_(7);
    phase.draine.scale = X_(8);
    phase.draine.split = X_(9);
    return phase;
}

NPH_PORTABLE_FN void nph_evaluate_numbers(int function, const NphU32 *in, NphU32 *out) {
    float sine, cosine, x, y;
    switch (function) {
    case F_philox: nph_put_words(nph_philox(in[0], in[1], in[2], in[3], in[4], in[5]), out); break;
    case F_uniform: PUT_(0, nph_uniformf(in[0])); break;
    case F_quotient: PUT_(0, X_(0) / X_(1)); break;
    case F_root: PUT_(0, nph_sqrtf(X_(0))); break;
    case F_product_sum: x = X_(0), y = X_(1), PUT_(0, x * y + X_(2)); break;
    case F_sincos2pi:
        nph_sincos2pif(X_(0), &sine, &cosine);
        PUT_(0, sine);
        PUT_(1, cosine);
        break;
    case F_atan2: PUT_(0, nph_atan2f(X_(0), X_(1))); break;
    case F_pow: PUT_(0, nph_powf(X_(0), X_(1))); break;
    UNARY_(exp);
    UNARY_(expm1);
    UNARY_(exp2);
    UNARY_(log);
    UNARY_(log1p);
    UNARY_(sin);
    UNARY_(cos);
    UNARY_(tan);
    UNARY_(asin);
    UNARY_(acos);
    UNARY_(cbrt);
    UNARY_(floor);
    default: break;
    }
}

NPH_PORTABLE_FN void nph_evaluate_turn(const NphU32 *in, NphU32 *out) {
    float d[3], turned[3];
    for (int i = 0; i < 3; i++) d[i] = X_(i);
    nph_turn_byf(d, nph_get_angle(X_(3), X_(4), X_(5)), X_(6), turned);
    for (int i = 0; i < 3; i++) PUT_(i, turned[i]);
}

/* Doubles are the host's: phase_of is not for OpenCL. */
NPH_PORTABLE_FN void nph_evaluate_prepared(const NphU32 *in, NphU32 *out) {
#ifndef NPH_PORTABLE_OPENCL
    NphPhasef phase = nph_phase_of((int)in[0], (double)X_(1), (double)X_(2), (double)X_(3), (double)X_(4));
    out[0] = (NphU32)phase.kind;
    PUT_(1, phase.rest0);
    PUT_(2, phase.rest1);
    PUT_(3, phase.draine.alpha);
    PUT_(4, phase.draine.norm);
    PUT_(5, phase.draine.scale);
    PUT_(6, phase.draine.split);
#else
    for (int i = 0; i < NPH_WORDS_OUT; i++) out[i] = in[0] - in[0];
#endif
}

NPH_PORTABLE_FN void nph_evaluate_phases(int function, const NphU32 *in, NphU32 *out) {
    NphPhasef phase;
    NphDrainef draine = {0.0f, 1.0f, 1.0f, 0.5f};
    switch (function) {
    case F_hg_value: PUT_(0, nph_hg_valuef(X_(0), X_(1), nph_get_angle(0.0f, X_(2), X_(3)))); break;
    case F_hg_sample: nph_put_angle(nph_hg_samplef(X_(0), X_(1), X_(2)), out); break;
    case F_rayleigh_value: PUT_(0, nph_rayleigh_valuef(nph_get_angle(0.0f, X_(0), X_(1)))); break;
    case F_rayleigh_sample: nph_put_angle(nph_rayleigh_samplef(X_(0)), out); break;
    case F_draine_value:
        draine.alpha = X_(2), draine.scale = X_(3);
        PUT_(0, nph_draine_valuef(&draine, X_(0), X_(1), nph_get_angle(0.0f, X_(4), X_(5))));
        break;
    case F_draine_sample:
        draine.alpha = X_(2), draine.norm = X_(3), draine.split = X_(4);
        nph_put_angle(nph_draine_samplef(&draine, X_(0), X_(1), X_(5)), out);
        break;
    case F_phase_of: nph_evaluate_prepared(in, out); break;
    case F_phase_at:
        phase = nph_get_phase(in);
        PUT_(0, nph_phase_atf(&phase, nph_get_angle(0.0f, X_(10), X_(11))));
        break;
    case F_phase_angle:
        phase = nph_get_phase(in);
        nph_put_angle(nph_phase_anglef(&phase, X_(10), X_(11)), out);
        break;
    case F_turn_by: nph_evaluate_turn(in, out); break;
    default: break;
    }
}

NPH_PORTABLE_FN void nph_evaluate(int function, const NphU32 *in, NphU32 *out) {
    nph_evaluate_numbers(function, in, out);
    nph_evaluate_phases(function, in, out);
}

#endif
