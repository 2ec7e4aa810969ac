/* SPDX-License-Identifier: Apache-2.0
 *
 * Draine's phase function: normalisation and mean cosine by quadrature, its limits, and sampling against the closed form
 * of its distribution written another way. */
#include <string.h>

#include "phase_checks.h"

static const double asymmetries[] = {0.0,  1e-9,  -1e-9, 1e-4,  -1e-4, 0.01,  0.3,    -0.5,   0.85,
                                     -0.9, 0.99, -0.99, 0.999, -0.999, 0.9999, 0.99999, -0.99999};
static const double alphas[] = {0.0, 1e-6, 0.3, 1.0, 5.0, 40.0, 1000.0};
enum {
    ASYMMETRIES = sizeof asymmetries / sizeof asymmetries[0],
    ALPHAS = sizeof alphas / sizeof alphas[0]
};

static NphPhase draine(double g, double alpha) { return (NphPhase){.kind = NPH_PHASE_DRAINE, .g = {g, 0}, .alpha = alpha}; }

START_TEST(value_is_normalised_and_has_its_mean_cosine) {
    for (int i = 0; i < ASYMMETRIES * ALPHAS; i++)
        for (int single = 0; single < 2; single++) {
            double g = asymmetries[i / ALPHAS], got[2], bound = single ? 2e-6 : 1e-10;
            NphPhase phase = draine(g, alphas[i % ALPHAS]);
            Scale scale = scale_of(&phase);
            integrate(single, &phase, scale, (double[]){0.0, scale.top}, 400, got);
            double mean = scale.backward ? got[1] - 1.0 : 1.0 - got[1];
            ck_assert_msg(fabs(got[0] - 1.0) < bound, "g %g, alpha %g: norm - 1 = %g", g, phase.alpha, got[0] - 1.0);
            ck_assert_msg(fabs(mean - nph_phase_mean_cosine(&phase)) < bound, "g %g, alpha %g: mean cosine %.12g, not %.12g",
                          g, phase.alpha, mean, nph_phase_mean_cosine(&phase));
        }
}
END_TEST

START_TEST(alpha_zero_is_henyey_greenstein_and_g_zero_alpha_one_is_rayleigh) {
    for (int k = 0; k <= 200; k++) {
        double fall = k < 100 ? 2.0 * pow(10.0, -0.1 * k) : 2.0 - 2.0 * pow(10.0, -0.1 * (k - 100)), rise = 2.0 - fall, a, b;
        for (int i = 0; i < ASYMMETRIES; i++) {
            NphPhase one = draine(asymmetries[i], 0.0), other = hg(asymmetries[i]);
            values(0, &one, &fall, &rise, &a, 1);
            values(0, &other, &fall, &rise, &b, 1);
            EXPECT(fabs(a - b) <= 4e-16 * b, "g %g: %g, not %g", asymmetries[i], a, b);
        }
        NphPhase one = draine(0.0, 1.0), other = {.kind = NPH_PHASE_RAYLEIGH};
        values(0, &one, &fall, &rise, &a, 1);
        values(0, &other, &fall, &rise, &b, 1);
        EXPECT(fabs(a - b) <= 1e-15 * b, "fall %g: %g, not %g", fall, a, b);
    }
}
END_TEST

/* The part of the distribution between the pole of the peak and fall (or the other pole and rise), in long double and
 * by another route: the integral of (1 + alpha c^2) / D^(3/2) in r = sqrt D,
 *   (1 - g^2) / (2 g N) [ (1 + alpha A^2 / 4 g^2) (1/r0 - 1/r) + alpha / 4 g^2 (-2 A (r - r0) + (r^3 - r0^3) / 3) ],
 * A = 1 + g^2. It cancels for small g. */
static long double part(long double g, long double alpha, long double near, int peak) {
    long double norm = 1 + alpha * (1 + 2 * g * g) / 3, a = 1 + g * g, r0 = peak ? 1 - g : 1 + g;
    long double square = r0 * r0 + (peak ? 2 * g * near : -2 * g * near), r = sqrtl(square), k = alpha / (4 * g * g);
    long double sign = peak ? 1 : -1, move = sign * 2 * g * near / (r + r0); /* r - r0 */
    long double cubes = move * (r * r + r * r0 + r0 * r0);
    long double sum = (1 + k * a * a) * move / (r * r0) + k * (-2 * a * move + cubes / 3);
    return sign * (1 - g * g) / (2 * g * norm) * sum;
}

/* In single precision g itself is rounded only where it is not a multiple of 2^-24 from 1: rest is. */
START_TEST(sampling_inverts_the_distribution) {
    static const double g[] = {0.1, 0.3, -0.5, 0.85, -0.9, 0.99, 0.999, -0.999, 0.99999};
    double worst[2] = {0.0, 0.0};
    for (int i = 0; i < 9 * ALPHAS; i++)
        for (int single = 0; single < 2; single++)
            for (uint32_t k = 0; k <= 2048; k++) {
                uint32_t word = k == 2048 ? 0xffffff00u : k << 21, lobe = 0;
                NphPhase phase = draine(g[i / ALPHAS], alphas[i % ALPHAS]);
                double u = word / 4294967296.0, fall, rise, cosine, size = fabs(phase.g[0]);
                double *const out[3] = {&fall, &rise, &cosine};
                if (single) phase_draw_f32_base(&phase, &word, &lobe, out, 1);
                else phase_draw_f64_base(&phase, &word, &lobe, out, 1);
                int front = fall < rise, peak = front == (phase.g[0] > 0);
                double tail = front ? 1.0 - u : u, epsilon = single ? 0x1p-24 : 0x1p-53;
                double back = (double)part((long double)size, (long double)phase.alpha,
                                           (long double)(front ? fall : rise), peak);
                double error = tail > 0 ? fabs(back / tail - 1.0) / epsilon : fabs(back);
                worst[single] = error > worst[single] ? error : worst[single];
                EXPECT(error < 64, "g %g, alpha %g: u %.9g, tail %.17g, not %.17g", phase.g[0], phase.alpha, u, back, tail);
            }
    printf("worst relative error of a tail: %.1f epsilon in f64, %.1f in f32\n", worst[0], worst[1]);
}
END_TEST

/* Where the closed form above cancels: against the polynomial of g = 0, x = 1 - near,
 *   (4 near - ... ) -> ((1 - x) + alpha (1 - x^3) / 3) / (2 + 2 alpha / 3), off by less than 4 |g|. */
START_TEST(sampling_has_no_singularity_at_g_zero) {
    static const double g[] = {0.0, 1e-9, -1e-9, 1e-7};
    for (int i = 0; i < 4 * ALPHAS; i++)
        for (uint32_t k = 0; k <= 2048; k++) {
            uint32_t word = k == 2048 ? 0xffffff00u : k << 21, lobe = 0;
            NphPhase phase = draine(g[i / ALPHAS], alphas[i % ALPHAS]);
            double u = word / 4294967296.0, fall, rise, cosine, alpha = phase.alpha;
            phase_draw_f64_base(&phase, &word, &lobe, (double *[]){&fall, &rise, &cosine}, 1);
            int front = fall < rise;
            double near = front ? fall : rise, tail = front ? 1.0 - u : u;
            double back = (near + alpha * near * (3.0 - near * (3.0 - near)) / 3.0) / (2.0 + 2.0 * alpha / 3.0);
            EXPECT(fabs(back - tail) <= (1e-14 + 4.0 * fabs(phase.g[0])) * tail, "alpha %g: u %.9g, tail %.17g, not %.17g",
                   alpha, u, back, tail);
        }
}
END_TEST

START_TEST(sampling_follows_the_value) {
    static const double g[] = {-0.99, -0.3, 0.0, 1e-8, 0.5, 0.9, 0.999};
    static const double alpha[] = {1.0, 40.0};
    for (int i = 0; i < 14; i++)
        for (int single = 0; single < 2; single++) {
            char name[64];
            NphPhase phase = draine(g[i / 2], alpha[i % 2]);
            snprintf(name, sizeof name, "g %g, alpha %g", phase.g[0], phase.alpha);
            chi_square(single, &phase, scale_of(&phase), 400u + (uint32_t)i, name);
        }
}
END_TEST

START_TEST(every_vector_level_gives_the_same_bits) {
    enum { COUNT = 1000 };
    static double results[2][4][COUNT];
    uint32_t u[COUNT], lobe[COUNT];
    for (uint32_t i = 0; i < COUNT; i++) {
        u[i] = nph_philox(19, 0, i, 0, 0, 0).w0;
        lobe[i] = 0;
    }
    if (nph_cpu_isa() < NPH_ISA_AVX512) nph_test_skip("a vector level this processor lacks");
    for (int i = 0; i < 2 * ASYMMETRIES; i++)
        for (int isa = NPH_ISA_BASE; isa <= (int)nph_cpu_isa(); isa++) {
            NphPhase phase = draine(asymmetries[i / 2], alphas[i % ALPHAS]);
            int bits = i % 2 ? 32 : 64;
            double (*r)[COUNT] = results[isa != NPH_ISA_BASE];
            void (*draws)(const NphPhase *, const uint32_t *, const uint32_t *, double *const *, int);
            void (*value)(const NphPhase *, const double *, const double *, double *, int);
            NPH_KERNEL_PICK(draws, phase_draw, isa, bits);
            NPH_KERNEL_PICK(value, phase_value, isa, bits);
            draws(&phase, u, lobe, (double *[]){r[0], r[1], r[2]}, COUNT);
            value(&phase, r[0], r[1], r[3], COUNT);
            if (isa != NPH_ISA_BASE) ck_assert_int_eq(memcmp(results[0], results[1], sizeof results[0]), 0);
        }
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, value_is_normalised_and_has_its_mean_cosine);
    tcase_add_test(cases, alpha_zero_is_henyey_greenstein_and_g_zero_alpha_one_is_rayleigh);
    tcase_add_test(cases, sampling_inverts_the_distribution);
    tcase_add_test(cases, sampling_has_no_singularity_at_g_zero);
    tcase_add_test(cases, sampling_follows_the_value);
    tcase_add_test(cases, every_vector_level_gives_the_same_bits);
}

int main(void) { return nph_test_main("draine", fill); }
