/* SPDX-License-Identifier: Apache-2.0
 *
 * What the tests of phase functions share: values and draws of either precision, integrals over angles spread out around
 * a peak, and the chi-square of draws against the integrated value. */
#ifndef NPH_TESTS_PHASE_CHECKS_H
#define NPH_TESTS_PHASE_CHECKS_H

#include <math.h>
#include <stdio.h>

#include "core/philox.h"
#include "harness.h"
#include "kernel_phase.h"

#define PI 3.14159265358979324
/* ck_assert_msg writes to a pipe even where it holds, which inner loops would pay for. */
#define EXPECT(condition, ...)                       \
    do {                                             \
        if (!(condition)) ck_abort_msg(__VA_ARGS__); \
    } while (0)

static inline NphPhase hg(double g) { return (NphPhase){.kind = NPH_PHASE_HG, .g = {g, 0.0}, .weight = 0.0}; }

static inline void values(int single, const NphPhase *phase, const double *fall, const double *rise, double *out, int count) {
    if (single) phase_value_f32_base(phase, fall, rise, out, count);
    else phase_value_f64_base(phase, fall, rise, out, count);
}

/* Angles with fall = a (e^t - 1), t in [0, top]: a peak of width a at fall = 0 is spread out. backward: at rise = 0. */
typedef struct Scale {
    double a, top;
    int backward;
} Scale;

static inline Scale scale_of(const NphPhase *phase) {
    double g = phase->g[0];
    double rest = 1.0 - fabs(g), a = 0.5 * rest * rest + 1e-12;
    return (Scale){a, log(2.0 / a + 1.0), g < 0.0};
}

/* Integral of p(cos) (1, near) 2 pi dcos between t0 and t1: Gauss-Legendre, 4 points on each of count panels. */
static inline void integrate(int single, const NphPhase *phase, Scale scale, const double t[2], int panels, double out[2]) {
    static const double node[2] = {0.33998104358485626, 0.86113631159405258};
    static const double weight[2] = {0.65214515486254614, 0.34785484513745386};
    out[0] = out[1] = 0.0;
    for (int i = 0; i < panels; i++)
        for (int k = 0; k < 4; k++) {
            double x = (k & 1 ? -1.0 : 1.0) * node[k / 2];
            double at = t[0] + (t[1] - t[0]) * (i + 0.5 + 0.5 * x) / panels;
            double near = scale.a * expm1(at), far = 2.0 - near, p;
            far = far < 0.0 ? 0.0 : far;
            values(single, phase, scale.backward ? &far : &near, scale.backward ? &near : &far, &p, 1);
            double part = 2.0 * PI * p * scale.a * exp(at) * weight[k / 2] * 0.5 * (t[1] - t[0]) / panels;
            out[0] += part;
            out[1] += part * near;
        }
}

/* Draws count angles; near[i] is the distance to the peak. */
static inline void draw(int single, const NphPhase *phase, uint32_t seed, int count, double *const out[3]) {
    enum { BATCH = 1024 };
    uint32_t u[BATCH], lobe[BATCH];
    for (int first = 0; first < count; first += BATCH) {
        int n = count - first < BATCH ? count - first : BATCH;
        for (int i = 0; i < n; i++) {
            NphWords words = nph_philox(seed, 1, (uint32_t)(first + i), 0, 0, 0);
            u[i] = words.w0;
            lobe[i] = words.w1;
        }
        double *const at[3] = {out[0] + first, out[1] + first, out[2] + first};
        if (single) phase_draw_f32_base(phase, u, lobe, at, n);
        else phase_draw_f64_base(phase, u, lobe, at, n);
    }
}

static inline void chi_square(int single, const NphPhase *phase, Scale scale, uint32_t seed, const char *what) {
    enum { SAMPLES = 200000, BINS = 60 };
    static double fall[SAMPLES], rise[SAMPLES], cosine[SAMPLES];
    double count[BINS + 1] = {0}, sum = 0.0, waiting = 0.0, expected_waiting = 0.0, total = 0.0;
    int degrees = -1;
    draw(single, phase, seed, SAMPLES, (double *[]){fall, rise, cosine});
    for (int i = 0; i < SAMPLES; i++) {
        double nearer = fall[i] < rise[i] ? fall[i] : rise[i], epsilon = single ? 0x1p-24 : 0x1p-53;
        EXPECT(nearer >= 0.0 && fall[i] <= 2.0 && rise[i] <= 2.0, "fall %g, rise %g", fall[i], rise[i]);
        EXPECT(fabs(fall[i] + rise[i] - 2.0) <= 2 * epsilon, "fall + rise - 2 = %g", fall[i] + rise[i] - 2.0);
        EXPECT(fabs(fabs(cosine[i]) + nearer - 1.0) <= epsilon && (cosine[i] >= 0) == (fall[i] <= rise[i]),
               "cos %g", cosine[i]);
        int bin = (int)(log1p((scale.backward ? rise[i] : fall[i]) / scale.a) / scale.top * BINS);
        count[bin < BINS ? bin : BINS - 1]++;
    }
    for (int bin = 0; bin < BINS; bin++) {
        double part[2];
        integrate(0, phase, scale, (double[]){scale.top * bin / BINS, scale.top * (bin + 1) / BINS}, 64, part);
        waiting += count[bin];
        expected_waiting += SAMPLES * part[0];
        total += part[0];
        if (expected_waiting < 20.0 && bin + 1 < BINS) continue;
        sum += (waiting - expected_waiting) * (waiting - expected_waiting) / expected_waiting;
        waiting = expected_waiting = 0.0;
        degrees++;
    }
    ck_assert(fabs(total - 1.0) < 1e-6);
    ck_assert_int_ge(degrees, 10);
    /* mean degrees, variance 2 degrees: 4.5 standard deviations; the seed is fixed, so it passes always or never */
    printf("%s %s: chi-square %.1f of %d\n", what, single ? "f32" : "f64", sum, degrees);
    ck_assert_msg(sum < degrees + 4.5 * sqrt(2.0 * degrees), "%s: chi-square %g of %d", what, sum, degrees);
}

#endif
