/* SPDX-License-Identifier: Apache-2.0
 *
 * Lists of wavelengths: a flat spectrum has luminance 1, groups hold every wavelength once, and finer lists approach the
 * observer's integral. */
#include "optics/wavelengths.h"

#include <math.h>
#include <stdio.h>

#include "harness.h"
#include "optics/blackbody.h"
#include "optics/cie.h"

static int even_list(int count, double first, double last, double *nm) {
    for (int i = 0; i < count; i++) nm[i] = count == 1 ? first : first + (last - first) * i / (count - 1);
    return count;
}

START_TEST(a_flat_spectrum_has_luminance_one) {
    double nm[NPH_MAX_WAVELENGTHS], weight[NPH_MAX_WAVELENGTHS][3];
    static const double uneven[] = {400, 410, 555.5, 600, 830};
    for (int count = 1; count <= NPH_MAX_WAVELENGTHS; count++) {
        even_list(count, 360, 830, nm);
        for (int kind = 0; kind < (count == 5 ? 2 : 1); kind++) {
            double Y = 0;
            nph_wavelength_weights(kind ? uneven : nm, count, weight);
            for (int i = 0; i < count; i++) Y += weight[i][1];
            ck_assert_double_eq_tol(Y, 1.0, 1e-14);
        }
    }
}
END_TEST

/* Intervals by hand, of a list whose steps differ; between whole nanometres the observer is linear. */
START_TEST(each_stands_for_the_interval_between_midpoints) {
    static const double nm[] = {450, 500, 600, 620}, width[] = {50, 75, 60, 20};
    double weight[4][3], sum = 0;
    nph_wavelength_weights(nm, 4, weight);
    for (int i = 0; i < 4; i++) sum += width[i] * nph_cie1931[(int)nm[i] - 360][1];
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 3; k++)
            ck_assert_double_eq_tol(weight[i][k], width[i] * nph_cie1931[(int)nm[i] - 360][k] / sum, 1e-15);
    static const double between[] = {555.25, 830};
    double pair[2][3];
    nph_wavelength_weights(between, 2, pair);
    double at = 0.75 * nph_cie1931[195][0] + 0.25 * nph_cie1931[196][0], y = 0.75 * nph_cie1931[195][1] + 0.25 * nph_cie1931[196][1];
    ck_assert_double_eq_tol(pair[0][0], at / (y + nph_cie1931[470][1]), 1e-14);
    ck_assert_double_eq_tol(pair[1][2] , nph_cie1931[470][2] / (y + nph_cie1931[470][1]), 1e-14);
}
END_TEST

START_TEST(groups_hold_every_wavelength_once_and_span_the_list) {
    for (int count = 1; count <= NPH_MAX_WAVELENGTHS; count++) {
        int seen[NPH_MAX_WAVELENGTHS] = {0}, groups = nph_wavelength_groups(count), padded = 0;
        double nm[NPH_MAX_WAVELENGTHS], weight[NPH_MAX_WAVELENGTHS][3], rgb[3];
        even_list(count, 380, 780, nm);
        nph_wavelength_weights(nm, count, weight);
        for (int g = 0; g < groups; g++) {
            double matrix[9];
            nph_wavelength_matrix(nm, count, g, matrix);
            for (int c = 0; c < 3; c++) {
                int repeated, i = nph_wavelength_of(count, g, c, &repeated);
                ck_assert(i >= 0 && i < count);
                seen[i] += !repeated;
                padded += repeated;
                nph_rgb_from_xyz(weight[i], rgb);
                for (int k = 0; k < 3; k++) ck_assert(matrix[3 * k + c] == (repeated ? 0.0 : rgb[k]));
            }
        }
        for (int i = 0; i < count; i++) ck_assert_int_eq(seen[i], 1);
        ck_assert_int_eq(padded, 3 * groups - count);
        ck_assert_int_le(padded, 2);
    }
}
END_TEST

/* The equal-energy white of the whole table, x = y = 1/3 within 1e-4: R, G, B as the header says. The table itself sums to Z = 1.0003. */
START_TEST(equal_energy_is_slightly_red) {
    double nm[NPH_MAX_WAVELENGTHS], rgb[3] = {0, 0, 0};
    even_list(60, 360, 830, nm);
    for (int g = 0; g < 20; g++) {
        double matrix[9];
        nph_wavelength_matrix(nm, 60, g, matrix);
        for (int k = 0; k < 3; k++) rgb[k] += matrix[3 * k] + matrix[3 * k + 1] + matrix[3 * k + 2];
    }
    static const double white[3] = {1.2048, 0.9483, 0.9089}; /* Rec. 709 of X = Y = Z = 1 */
    for (int k = 0; k < 3; k++) ck_assert_double_eq_tol(rgb[k], white[k], 1e-3);
    ck_assert_double_eq_tol(0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2], 1.0, 1e-4);
}
END_TEST

static double miss_of(int count, double kelvin) {
    double nm[NPH_MAX_WAVELENGTHS], weight[NPH_MAX_WAVELENGTHS][3], xyz[3] = {0, 0, 0}, exact[3];
    even_list(count, 360, 830, nm);
    nph_wavelength_weights(nm, count, weight);
    for (int i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) xyz[k] += weight[i][k] * nph_planck(nm[i], kelvin);
    nph_planck_xyz(kelvin, exact);
    double miss = 0;
    for (int k = 0; k < 3; k++) miss = fmax(miss, fabs(xyz[k] / exact[k] - 1.0));
    return miss;
}

START_TEST(finer_lists_approach_the_integral) {
    static const double kelvins[] = {2500, 6500, 20000};
    for (int i = 0; i < 3; i++) {
        double coarse = miss_of(8, kelvins[i]), middle = miss_of(16, kelvins[i]), fine = miss_of(60, kelvins[i]);
        printf("    %g K: 8 wavelengths %.2g, 16 %.2g, 60 %.2g\n", kelvins[i], coarse, middle, fine);
        ck_assert(fine < 0.1 * coarse && fine < 2e-3);
    }
}
END_TEST

START_TEST(thirds_are_black_only_where_the_spectrum_is) {
    for (int count = 1; count <= NPH_MAX_WAVELENGTHS; count++)
        for (int lit = 0; lit < count; lit++) {
            double values[NPH_MAX_WAVELENGTHS] = {0}, rgb[3];
            values[lit] = 1e-300;
            nph_spectrum_thirds(values, count, rgb);
            ck_assert(rgb[0] > 0 || rgb[1] > 0 || rgb[2] > 0);
        }
    double rgb[3];
    nph_spectrum_thirds((double[]){1, 2, 3, 4, 5, 6}, 6, rgb);
    ck_assert(rgb[0] == 5.5 && rgb[1] == 3.5 && rgb[2] == 1.5);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, a_flat_spectrum_has_luminance_one);
    tcase_add_test(cases, each_stands_for_the_interval_between_midpoints);
    tcase_add_test(cases, groups_hold_every_wavelength_once_and_span_the_list);
    tcase_add_test(cases, equal_energy_is_slightly_red);
    tcase_add_test(cases, finer_lists_approach_the_integral);
    tcase_add_test(cases, thirds_are_black_only_where_the_spectrum_is);
}

int main(void) { return nph_test_main("wavelengths", fill); }
