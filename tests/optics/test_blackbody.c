/* SPDX-License-Identifier: Apache-2.0
 *
 * Black bodies against laws that follow from Planck's, and their colours against published ones. */
#include <math.h>
#include <stdio.h>

#include "harness.h"
#include "optics/blackbody.h"
#include "optics/cie.h"

static const double sigma = 5.670374419e-8; /* Stefan and Boltzmann's constant, W/m2/K4 [SI19] */

/* Midpoints in ln lambda, from 0.02 to 2000 times Wien's wavelength: what lies outside is below 1e-9 of the whole. */
START_TEST(the_whole_spectrum_is_stefan_and_boltzmanns) {
    for (double kelvin = 300.0; kelvin < 1e5; kelvin *= 3.0) {
        double sum = 0.0, peak = 2.897771955e6 / kelvin, step = log(1e5) / 20000;
        for (int i = 0; i < 20000; i++) {
            double lambda = 0.02 * peak * exp((i + 0.5) * step);
            sum += nph_planck(lambda, kelvin) * lambda * step;
        }
        double law = sigma * pow(kelvin, 4.0) / acos(-1.0);
        printf("    %g K: %.10g of sigma T^4 / pi\n", kelvin, sum / law);
        ck_assert(fabs(sum / law - 1.0) < 1e-8);
    }
}
END_TEST

START_TEST(the_brightest_wavelength_is_wiens) {
    for (double kelvin = 1000.0; kelvin < 1e5; kelvin *= 2.0) {
        double peak = 2.897771955e6 / kelvin;
        ck_assert(nph_planck(peak, kelvin) > nph_planck(peak * 1.001, kelvin));
        ck_assert(nph_planck(peak, kelvin) > nph_planck(peak * 0.999, kelvin));
    }
}
END_TEST

START_TEST(long_waves_are_rayleigh_and_jeans_and_cold_bodies_dark) {
    /* 2 c k T / lambda^4, off by x / 2 with x = hc / (lambda k T) = 1.4e-6 */
    double lambda = 1e12, law = 2.0 * 299792458.0 * 1.380649e-23 * 1e4 / pow(lambda * 1e-9, 4.0) * 1e-9;
    ck_assert(fabs(nph_planck(lambda, 1e4) / law - 1.0) < 2e-6);
    ck_assert(nph_planck(500.0, 0.0) == 0.0 && nph_planck(500.0, 10.0) == 0.0);
    ck_assert(isfinite(nph_planck(1.0, 1e-300)) && isfinite(nph_planck(1.0, 1e200)));
}
END_TEST

static void chromaticity(double kelvin, double xy[2]) {
    double xyz[3];
    nph_planck_xyz(kelvin, xyz);
    for (int k = 0; k < 2; k++) xy[k] = xyz[k] / (xyz[0] + xyz[1] + xyz[2]);
}

/* Illuminant A is a black body of 2848 K with c2 = 1.435e-2 m K; its chromaticity is 0.44758, 0.40745 [CIE04]. */
START_TEST(illuminant_a_has_its_colour) {
    double xy[2];
    chromaticity(2848.0 * 1.438776877 / 1.435, xy);
    printf("    x %.6f y %.6f\n", xy[0], xy[1]);
    ck_assert(fabs(xy[0] - 0.44758) < 1.5e-5 && fabs(xy[1] - 0.40745) < 1.5e-5);
}
END_TEST

/* [Kim02]: cubic approximations of the locus, printed to stay within 1e-3 of it. */
START_TEST(the_locus_is_the_published_one_from_2000_to_10000_kelvin) {
    double worst = 0.0;
    for (double kelvin = 2000.0; kelvin <= 10000.0; kelvin += 250.0) {
        double i = 1000.0 / kelvin, xy[2], x, y;
        x = kelvin <= 4000.0 ? -0.2661239 * i * i * i - 0.2343589 * i * i + 0.8776956 * i + 0.179910
                             : -3.0258469 * i * i * i + 2.1070379 * i * i + 0.2226347 * i + 0.240390;
        y = kelvin <= 2222.0   ? -1.1063814 * x * x * x - 1.34811020 * x * x + 2.18555832 * x - 0.20219683
            : kelvin <= 4000.0 ? -0.9549476 * x * x * x - 1.37418593 * x * x + 2.09137015 * x - 0.16748867
                               : 3.0817580 * x * x * x - 5.87338670 * x * x + 3.75112997 * x - 0.37001483;
        chromaticity(kelvin, xy);
        double off = fmax(fabs(xy[0] - x), fabs(xy[1] - y));
        worst = off > worst ? off : worst;
    }
    printf("    largest distance in x or y: %.2g\n", worst);
    ck_assert(worst < 1e-3);
}
END_TEST

START_TEST(a_flat_spectrum_of_one_has_y_one_and_white_is_white) {
    double white = 0.0, sum = 0.0, d65[3] = {0.3127 / 0.3290, 1.0, (1.0 - 0.3127 - 0.3290) / 0.3290}, rgb[3];
    for (int i = 0; i < NPH_CIE_COUNT; i++) {
        white += nph_cie1931[i][1];
        sum += nph_cie1931[i][0];
    }
    /* the equal-energy stimulus has x = y = z = 1/3 within the table's rounding [CIE04] */
    ck_assert(fabs(sum / white - 1.0) < 1e-3);
    nph_rgb_from_xyz(d65, rgb);
    for (int c = 0; c < 3; c++) ck_assert(fabs(rgb[c] - 1.0) < 1e-14);
}
END_TEST

START_TEST(the_table_keeps_seven_digits_and_colours_stay_positive) {
    static NphPlanckTable table;
    double worst = 0.0;
    nph_planck_table(&table);
    for (double kelvin = NPH_KELVIN_LEAST; kelvin <= NPH_KELVIN_MOST; kelvin *= 1.0037) {
        double xyz[3], exact[3], rgb[3];
        nph_planck_xyz(kelvin, xyz);
        nph_rgb_from_xyz(xyz, exact);
        nph_planck_rgb(&table, kelvin, rgb);
        for (int c = 0; c < 3; c++) {
            ck_assert(rgb[c] >= 0.0);
            double off = fabs(rgb[c] - fmax(exact[c], 0.0)) / xyz[1];
            worst = off > worst ? off : worst;
        }
    }
    printf("    largest error over Y: %.2g\n", worst);
    ck_assert(worst < 1e-7);
    double cold[3], hot[3], most[3];
    nph_planck_rgb(&table, 99.0, cold);
    ck_assert(cold[0] == 0.0 && cold[1] == 0.0 && cold[2] == 0.0);
    nph_planck_rgb(&table, NAN, cold);
    ck_assert(cold[0] == 0.0);
    nph_planck_rgb(&table, 1e300, hot);
    nph_planck_rgb(&table, NPH_KELVIN_MOST, most);
    ck_assert(hot[2] == most[2] && most[2] > 0.0);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, the_whole_spectrum_is_stefan_and_boltzmanns);
    tcase_add_test(cases, the_brightest_wavelength_is_wiens);
    tcase_add_test(cases, long_waves_are_rayleigh_and_jeans_and_cold_bodies_dark);
    tcase_add_test(cases, illuminant_a_has_its_colour);
    tcase_add_test(cases, the_locus_is_the_published_one_from_2000_to_10000_kelvin);
    tcase_add_test(cases, a_flat_spectrum_of_one_has_y_one_and_white_is_white);
    tcase_add_test(cases, the_table_keeps_seven_digits_and_colours_stay_positive);
}

int main(void) { return nph_test_main("blackbody", fill); }
