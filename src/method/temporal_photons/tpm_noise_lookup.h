/* SPDX-License-Identifier: Apache-2.0
 *
 * Detail: octaves of vector noise that move the places at which density and cache are looked up [Elek12 sec. 4.4]. */
#ifndef NPH_METHOD_TPM_NOISE_LOOKUP_H
#define NPH_METHOD_TPM_NOISE_LOOKUP_H

#include "method/temporal_photons/tpm_state.h"

/* Periodic, linear between its points. */
static inline void add_noise(const RTpmScene *scene, Real size, Real amount, const Real p[3], Real out[3]) {
    int32_t low[3];
    Real part[3];
    for (int a = 0; a < 3; a++) {
        Real u = p[a] * size, whole = r_floor(u);
        part[a] = u - whole;
        low[a] = (int32_t)(whole - R(32.0) * r_floor(whole * R(0.03125)));
    }
    for (int k = 0; k < 8; k++) {
        Real share = amount;
        int32_t at[3];
        for (int a = 0; a < 3; a++) {
            int up = k >> a & 1;
            share *= up ? part[a] : R(1.0) - part[a];
            at[a] = (low[a] + up) & (R_TPM_NOISE - 1);
        }
        const float *vector = scene->field + 3 * ((at[2] * R_TPM_NOISE + at[1]) * R_TPM_NOISE + at[0]);
        for (int a = 0; a < 3; a++) out[a] += share * (Real)vector[a];
    }
}

/* The place that is looked up for p: p itself, or moved by noise and kept in the box. */
static inline void detail(const RTpmScene *scene, const Real p[3], Real out[3]) {
    Real moved[3] = {R(0.0), R(0.0), R(0.0)}, size = R(0.25), amount = scene->noise;
    for (int o = 0; o < scene->octaves && scene->noise > R(0.0); o++, size *= R(2.0), amount *= R(0.5))
        add_noise(scene, size, amount, p, moved);
    for (int a = 0; a < 3; a++) out[a] = r_clamp(p[a] + moved[a], scene->medium.lo[a], scene->medium.hi[a]);
}

#endif
