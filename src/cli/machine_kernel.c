/* SPDX-License-Identifier: Apache-2.0
 *
 * What the machine itself can do, for `nephos bench` to stand beside: multiplications and additions that depend on
 * nothing but registers, a triad over arrays far larger than the caches, and numbers from places that lanes choose. */
#include "core/real.h"

#include "cli/machine.h"

/* One chain of 16 steps x <- x m + a, 32 operations; m and a keep x near 1. */
#define STEP(x) (x) = (x) * m + a;
#define STEPS4(x) STEP(x) STEP(x) STEP(x) STEP(x)
#define STEPS16(x) STEPS4(x) STEPS4(x) STEPS4(x) STEPS4(x)

/* 8 independent chains a lane hide the latency: MACHINE_LANE_FLOPS operations. */
void NPH_KERNEL(nph_machine_flops)(void *restrict lanes) {
    Real *restrict value = lanes;
    const Real m = R(0.999), a = R(0.001);
    for (int k = 0; k < MACHINE_LANES; k++) { /* vec */
        Real x = value[k], s = x + R(0.1), t = x + R(0.2), u = x + R(0.3), v = x + R(0.4), w = x + R(0.5);
        Real y = x + R(0.6), z = x + R(0.7);
        STEPS16(x) STEPS16(s) STEPS16(t) STEPS16(u) STEPS16(v) STEPS16(w) STEPS16(y) STEPS16(z)
        value[k] = (x + s + t + u + v + w + y + z) * R(0.125);
    }
}

void NPH_KERNEL(nph_machine_triad)(void *restrict to, const void *restrict from, const void *restrict more, int64_t count) {
    Real *restrict sum = to;
    const Real *restrict b = from, *restrict c = more;
    for (int64_t i = 0; i < count; i++) sum[i] = b[i] + R(0.5) * c[i]; /* vec */
}

enum { FAR = MACHINE_TABLE / 2 / MACHINE_LOOKS };

void NPH_KERNEL(nph_machine_gather)(void *restrict lanes, const void *restrict table, const int32_t *restrict index) {
    Real *restrict value = lanes;
    const Real *restrict from = table;
    for (int k = 0; k < MACHINE_LANES; k++) { /* vec */
        int32_t at = index[k];
        Real sum = (from[at] + from[at + FAR]) + (from[at + 2 * FAR] + from[at + 3 * FAR]);
        sum += (from[at + 4 * FAR] + from[at + 5 * FAR]) + (from[at + 6 * FAR] + from[at + 7 * FAR]);
        value[k] = sum;
    }
}
