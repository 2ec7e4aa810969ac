/* SPDX-License-Identifier: Apache-2.0
 *
 * Intensities of a sphere at many angles, in double for either precision: with p = pi_n + tau_n, q = pi_n - tau_n
 *   S1 + S2 = sum plus_n p,  S1 - S2 = sum minus_n q,  (|S1|^2 + |S2|^2) / 2 = (|S1 + S2|^2 + |S1 - S2|^2) / 4,
 * and pi_n, tau_n by the recurrence of mie.c. A few orders at a time: what an angle has reached stays in registers for them. */
#include "optics/mie_kernel.h"

#include "core/real.h"

typedef struct Lanes {
    double pi[NPH_MIE_LANES], rise[NPH_MIE_LANES];
    double plus_re[NPH_MIE_LANES], plus_im[NPH_MIE_LANES], minus_re[NPH_MIE_LANES], minus_im[NPH_MIE_LANES];
} Lanes;

R_OUTLINE void add_orders(const NphMieOrder *restrict order, const double *restrict distance, Lanes *restrict s) {
    R_INDEPENDENT
    for (int i = 0; i < NPH_MIE_LANES; i++) { /* vec */
        double x = distance[i], pi = s->pi[i], rise = s->rise[i];
        double plus_re = s->plus_re[i], plus_im = s->plus_im[i], minus_re = s->minus_re[i], minus_im = s->minus_im[i];
        for (int k = 0; k < NPH_MIE_UNROLL; k++) {
            double away = x * pi, t = rise - away, tau = order[k].n * t - (pi - rise), p = pi + tau, q = pi - tau;
            plus_re += order[k].plus_re * p;
            plus_im += order[k].plus_im * p;
            minus_re += order[k].minus_re * q;
            minus_im += order[k].minus_im * q;
            rise = order[k].ratio * t - away;
            pi += rise;
        }
        s->pi[i] = pi;
        s->rise[i] = rise;
        s->plus_re[i] = plus_re;
        s->plus_im[i] = plus_im;
        s->minus_re[i] = minus_re;
        s->minus_im[i] = minus_im;
    }
}

void NPH_KERNEL(nph_mie_tile)(const NphMieTile *tile) {
    Lanes s;
    memset(&s, 0, sizeof s);
    for (int i = 0; i < NPH_MIE_LANES; i++) s.pi[i] = s.rise[i] = 1.0;
    for (int n = 0; n < tile->count; n += NPH_MIE_UNROLL) add_orders(tile->orders + n, tile->distance, &s);
    double quarter = 0.25 * tile->weight;
    for (int i = 0; i < NPH_MIE_LANES; i++)
        tile->sum[i] += quarter * (s.plus_re[i] * s.plus_re[i] + s.plus_im[i] * s.plus_im[i] +
                                   (s.minus_re[i] * s.minus_re[i] + s.minus_im[i] * s.minus_im[i]));
}
