/* SPDX-License-Identifier: Apache-2.0
 *
 * Moments against quadrature and closed forms, functions given back by their moments, and what several scatterings make of a phase
 * function: Henyey and Greenstein's stays one, of g to the power; light is kept; many make it isotropic. */
#include "optics/legendre.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "core/memory.h"
#include "harness.h"
#include "io/phase_rows.h"

static const double PI = 3.14159265358979323846;

static double legendre(int l, double c) {
    double p = 1, before = 0;
    for (int n = 1; n <= l; n++) {
        double next = ((2 * n - 1) * c * p - (n - 1) * before) / n;
        before = p;
        p = next;
    }
    return p;
}

/* 2 pi int p P_l dcos by Simpson's rule in the angle. */
static double by_sum(const NphPhase *phase, int l) {
    enum { STEPS = 20000 };
    double sum = 0;
    for (int i = 0; i <= STEPS; i++) {
        double theta = PI * i / STEPS, weight = i == 0 || i == STEPS ? 1 : i % 2 ? 4 : 2;
        sum += weight * nph_phase_value(phase, cos(theta)) * legendre(l, cos(theta)) * sin(theta);
    }
    return 2 * PI * sum * PI / (3.0 * STEPS);
}

static NphPhase table_from_file(NphContext *context, const char *path) {
    NphArray rows;
    NphPhase phase;
    ck_assert_int_eq(nph_phase_rows_read(context, nph_test_path(path), &rows), NPH_OK);
    ck_assert_int_eq(nph_phase_tabulate(context, &rows, path, &phase), NPH_OK);
    nph_array_free(context, &rows);
    return phase;
}

START_TEST(moments_are_integrals) {
    NphContext *context = nph_test_context(1);
    NphPhase phases[6] = {{.kind = NPH_PHASE_ISOTROPIC},
                          {.kind = NPH_PHASE_HG, .g = {0.8, 0}},
                          {.kind = NPH_PHASE_TWO_LOBE, .g = {0.85, -0.4}, .weight = 0.8},
                          {.kind = NPH_PHASE_RAYLEIGH},
                          {.kind = NPH_PHASE_DRAINE, .g = {0.6, 0}, .alpha = 3},
                          table_from_file(context, "reference/data/gpl/c1_phase.txt")};
    for (int i = 0; i < 6; i++) {
        double moment[60], worst = 0;
        nph_phase_moments(&phases[i], 60, moment);
        ck_assert(fabs(moment[0] - 1) < 1e-12 && fabs(moment[1] - nph_phase_mean_cosine(&phases[i])) < 1e-12);
        for (int l = 0; l < 60; l += l < 6 ? 1 : 9) worst = fmax(worst, fabs(moment[l] - by_sum(&phases[i], l)));
        ck_assert_msg(worst < (i < 5 ? 1e-8 : 2e-6), "phase %d: %g", i, worst); /* the sum misses the table's corners */
    }
    nph_phase_free(context, &phases[5]);
    nph_test_context_close(context);
}
END_TEST

/* Draine's function of alpha 0 is Henyey and Greenstein's, whose moments are g^l; that of alpha 1 and g 0 is Rayleigh's. */
START_TEST(moments_are_those_of_closed_forms) {
    double moment[12], g = 1.0;
    NphPhase phase = {.kind = NPH_PHASE_DRAINE, .g = {0.9, 0.0}, .alpha = 0.0};
    nph_phase_moments(&phase, 12, moment);
    for (int l = 0; l < 12; l++, g *= 0.9) ck_assert(fabs(moment[l] - g) < 1e-14);
    phase = (NphPhase){.kind = NPH_PHASE_DRAINE, .g = {0.0, 0.0}, .alpha = 1.0};
    nph_phase_moments(&phase, 4, moment);
    ck_assert(fabs(moment[1]) < 1e-15 && fabs(moment[2] - 0.1) < 1e-15 && fabs(moment[3]) < 1e-15);
    phase = (NphPhase){.kind = NPH_PHASE_TWO_LOBE, .g = {0.8, -0.3}, .weight = 0.7};
    nph_phase_moments(&phase, 4, moment);
    ck_assert(fabs(moment[3] - (0.7 * 0.512 - 0.3 * 0.027)) < 1e-15);
}
END_TEST

START_TEST(moments_give_the_function_back) {
    NphContext *context = nph_test_context(0);
    NphPhase cloud = table_from_file(context, "reference/data/gpl/c1_phase.txt"), hg = {.kind = NPH_PHASE_HG, .g = {-0.9, 0}};
    const NphPhase *phases[2] = {&cloud, &hg};
    for (int i = 0; i < 2; i++) {
        int count;
        double *moment, worst = 0;
        ck_assert_int_eq(nph_phase_all_moments(context, phases[i], 1e-8, &count, &moment), NPH_OK);
        for (double degrees = 0; degrees <= 180; degrees += 0.373) {
            int back = degrees > 90;
            double half = sin((back ? 180 - degrees : degrees) * PI / 360), truth = nph_phase_value(phases[i], cos(degrees * PI / 180));
            worst = fmax(worst, fabs(nph_legendre_value(count, moment, 2 * half * half, back) / truth - 1));
        }
        printf("    %d moments: off by at most %.2g\n", count, worst);
        ck_assert(worst < 2e-3 && count < (i ? 300 : NPH_MOST_MOMENTS));
        nph_free(context, moment);
    }
    nph_phase_free(context, &cloud);
    nph_test_context_close(context);
}
END_TEST

/* Part of HG in front of 90 degrees. */
static double hg_forward(double g) { return fabs(g) < 1e-9 ? 0.5 : (1 - g * g) / (2 * g) * (1 / (1 - g) - 1 / sqrt(1 + g * g)); }

START_TEST(henyey_and_greenstein_of_n_scatterings_has_g_to_the_n) {
    enum { TIMES = 26 };
    static const double gs[] = {0.3, 0.88, -0.7, 0.97};
    NphContext *context = nph_test_context(0);
    for (int k = 0; k < 4; k++) {
        NphPhase hg = {.kind = NPH_PHASE_HG, .g = {gs[k], 0}};
        NphConvolutions made;
        int count;
        double *moment, worst = 0, worst_forward = 0, worst_mean = 0;
        ck_assert_int_eq(nph_phase_all_moments(context, &hg, 1e-12, &count, &moment), NPH_OK);
        ck_assert_int_eq(nph_phase_convolve(context, count, moment, TIMES, "hg", &made), NPH_OK);
        for (int n = 1; n <= TIMES; n++) {
            NphPhase truth = {.kind = NPH_PHASE_HG, .g = {pow(gs[k], n), 0}};
            for (double degrees = 0; degrees <= 180; degrees += 0.637)
                worst = fmax(worst, fabs(nph_phase_value(&made.after[n - 1], cos(degrees * PI / 180)) / nph_phase_value(&truth, cos(degrees * PI / 180)) - 1));
            worst_forward = fmax(worst_forward, fabs(made.forward[n - 1] - hg_forward(truth.g[0])));
            worst_mean = fmax(worst_mean, fabs(nph_phase_mean_cosine(&made.after[n - 1]) - truth.g[0]));
        }
        printf("    g %g: %d moments, values off by %.2g, F by %.2g, mean cosines by %.2g\n", gs[k], count, worst, worst_forward, worst_mean);
        ck_assert(worst < 1e-3 && worst_forward < 1e-5 && worst_mean < 1e-5 && made.negative < 1e-9);
        nph_convolutions_free(context, &made);
        nph_free(context, moment);
    }
    nph_test_context_close(context);
}
END_TEST

/* Parts of a table add to 1; the mean cosine of n scatterings is g^n; F falls to 1/2 and values to 1 / (4 pi). */
START_TEST(scattering_often_keeps_the_light_and_forgets_the_direction) {
    enum { TIMES = 200 };
    NphContext *context = nph_test_context(0);
    NphPhase cloud = table_from_file(context, "reference/data/gpl/c1_phase.txt");
    NphConvolutions made;
    int count;
    double *moment, worst = 0;
    ck_assert_int_eq(nph_phase_all_moments(context, &cloud, 1e-7, &count, &moment), NPH_OK);
    ck_assert_int_eq(nph_phase_convolve(context, count, moment, TIMES, "cloud", &made), NPH_OK);
    for (int i = 0; i < TIMES; i++) {
        const NphPhaseHalf *half = made.after[i].table->half;
        double norm = 0;
        for (int h = 0; h < 2; h++)
            for (int k = 0; k < half[h].count; k++)
                norm += PI * (half[h].x[k + 1] - half[h].x[k]) * (half[h].value[k] + half[h].value[k + 1]);
        ck_assert_msg(fabs(norm - 1) < 1e-10, "after %d: norm - 1 = %g", i + 1, norm - 1);
        worst = fmax(worst, fabs(nph_phase_mean_cosine(&made.after[i]) - pow(moment[1], i + 1)));
        ck_assert(made.forward[i] >= 0.5 && (i == 0 || made.forward[i] < made.forward[i - 1]));
    }
    printf("    mean cosines off by %.2g, %.2g of a value lifted to 0\n", worst, made.negative);
    ck_assert(worst < 2e-4); /* straight lines between rows */
    ck_assert(fabs(nph_phase_value(&made.after[TIMES - 1], 1) * 4 * PI - 1) < 1e-6);
    ck_assert(fabs(nph_phase_value(&made.after[TIMES - 1], -1) * 4 * PI - 1) < 1e-6);
    ck_assert_int_eq(nph_phase_convolve(context, count, moment, 0, "cloud", &made), NPH_BAD_USAGE);
    nph_convolutions_free(context, &made);
    nph_free(context, moment);
    nph_phase_free(context, &cloud);
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *tcase) {
    tcase_set_timeout(tcase, 120);
    tcase_add_test(tcase, moments_are_integrals);
    tcase_add_test(tcase, moments_are_those_of_closed_forms);
    tcase_add_test(tcase, moments_give_the_function_back);
    tcase_add_test(tcase, henyey_and_greenstein_of_n_scatterings_has_g_to_the_n);
    tcase_add_test(tcase, scattering_often_keeps_the_light_and_forgets_the_direction);
}

int main(void) { return nph_test_main("legendre", fill); }
