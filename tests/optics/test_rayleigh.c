/* SPDX-License-Identifier: Apache-2.0
 *
 * Air's scattering in [Riley04 tables 2 and 3]: the two are one set of numbers under two sets of wavelengths, of which those of table 3
 * follow the fourth power. And Rayleigh's phase function as the limit of spheres. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "harness.h"
#include "optics/air.h"
#include "optics/legendre.h"
#include "optics/mie.h"

static const double PI = 3.14159265358979323846;

START_TEST(cross_sections_in_print_are_the_coefficients_in_print) {
    static const double section_m2[] = {2.28e-31, 5.33e-31, 1.30e-30}, per_m[] = {5.8e-6, 1.35e-5, 3.31e-5};
    static const double nm[2][3] = {{650, 515, 440}, {680, 550, 440}}; /* of table 2, of table 3 */
    double worst[2] = {0, 0};
    for (int i = 0; i < 3; i++) ck_assert(fabs(section_m2[i] * 2.55e25 / per_m[i] - 1) < 0.01);
    for (int table = 0; table < 2; table++)
        for (int i = 0; i < 2; i++) worst[table] = fmax(worst[table], fabs(per_m[i] / per_m[2] / pow(nm[table][2] / nm[table][i], 4) - 1));
    printf("    off the fourth power by %.2g at table 2's wavelengths, %.2g at table 3's\n", worst[0], worst[1]);
    ck_assert(worst[0] > 0.15 && worst[1] < 0.01);
    for (int i = 0; i < 3; i++) {
        double ours = nph_rayleigh_per_m(nm[1][i]);
        printf("    %g nm: %.4g m2, %.4g 1/m; in print %.3g, %.3g\n", nm[1][i], ours / 2.546899e25, ours, section_m2[i], per_m[i]);
        ck_assert(per_m[i] / ours > 1.1 && per_m[i] / ours < 1.25);
    }
}
END_TEST

START_TEST(rayleighs_phase_function_is_the_limit_of_spheres) {
    NphPhase rayleigh = {.kind = NPH_PHASE_RAYLEIGH};
    NphMieSphere sphere = {1e-4, 1.33, 0};
    double *block = malloc((size_t)nph_mie_doubles(&sphere) * sizeof *block), moment[4];
    NphMieTerms terms;
    NphMie mie;
    nph_mie_terms(&sphere, block, &terms);
    nph_mie_efficiencies(&sphere, &terms, &mie);
    for (double degrees = 0; degrees <= 180; degrees += 1) {
        int back = degrees > 90;
        double half = sin((back ? 180 - degrees : degrees) * PI / 360), s1[2], s2[2];
        nph_mie_amplitudes(&terms, 2 * half * half, back, s1, s2);
        double p = (s1[0] * s1[0] + s1[1] * s1[1] + s2[0] * s2[0] + s2[1] * s2[1]) / (2 * PI * sphere.x * sphere.x * mie.scattering);
        ck_assert(fabs(p / nph_phase_value(&rayleigh, cos(degrees * PI / 180)) - 1) < 1e-7);
    }
    nph_phase_moments(&rayleigh, 4, moment);
    ck_assert(moment[0] == 1 && moment[1] == 0 && moment[2] == 0.1 && moment[3] == 0);
    free(block);
}
END_TEST

static void fill(TCase *tcase) {
    tcase_add_test(tcase, cross_sections_in_print_are_the_coefficients_in_print);
    tcase_add_test(tcase, rayleighs_phase_function_is_the_limit_of_spheres);
}

int main(void) { return nph_test_main("rayleigh", fill); }
