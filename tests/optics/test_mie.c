/* SPDX-License-Identifier: Apache-2.0
 *
 * Spheres against tables of other codes and of 50 digits and more, and against what must hold of any sphere: the optical
 * theorem, the integral of the phase function, its first moment, limits of small and of large spheres. */
#include "optics/mie.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "harness.h"

static const double PI = 3.14159265358979323846;

typedef struct Sphere {
    NphMieSphere at;
    double *block;
    NphMieTerms terms;
    NphMie mie;
} Sphere;

static Sphere sphere_of(double x, double n, double k) {
    Sphere s = {.at = {x, n, k}};
    s.block = malloc((size_t)nph_mie_doubles(&s.at) * sizeof(double));
    nph_mie_terms(&s.at, s.block, &s.terms);
    nph_mie_efficiencies(&s.at, &s.terms, &s.mie);
    return s;
}

/* S1, S2 in this code's sign; theta in degrees. */
static void amplitudes(const Sphere *s, double theta, double s1[2], double s2[2]) {
    int back = theta > 90;
    double half = sin((back ? 180 - theta : theta) * PI / 360);
    nph_mie_amplitudes(&s->terms, 2 * half * half, back, s1, s2);
}

/* Rows of a table, the name in its first column skipped where there is one; perfect conductors are left out. */
typedef void (*RowFn)(const double *row, double *worst);

static int each_row(const char *table, int named, int columns, int conductor, RowFn check, double *worst) {
    char path[128], line[1024];
    int rows = 0, head = 1;
    snprintf(path, sizeof path, "reference/tables/%s", table);
    FILE *file = fopen(nph_test_path(path), "r");
    ck_assert_msg(file != NULL, "%s", path);
    while (fgets(line, sizeof line, file)) {
        double row[16];
        char *at = line;
        if (line[0] == '#' || head) {
            head = line[0] == '#';
            continue;
        }
        for (int i = 0; i < named; i++) at = strchr(at, ',') + 1;
        for (int i = 0; i < columns; i++) {
            row[i] = strtod(at, &at);
            at += *at == ',';
        }
        if (conductor >= 0 && row[conductor] != 0.0) continue;
        check(row, worst);
        rows++;
    }
    fclose(file);
    return rows;
}

static void note(double value, double truth, double scale, double *worst) {
    double off = fabs(value - truth) / scale;
    if (!(off <= *worst)) *worst = off;
}

/* perfectly_conducting, x, n, k, Qext, Qsca, Qabs, g, Qback */
static void check_efficiencies(const double *row, double *worst) {
    Sphere s = sphere_of(row[1], row[2], row[3]);
    note(s.mie.extinction, row[4], row[4], &worst[0]);
    note(s.mie.scattering, row[5], row[5], &worst[0]);
    note(s.mie.asymmetry, row[7], fabs(row[7]) + 1e-3, &worst[1]); /* 1e-16 of it comes from b_1, which a small sphere lacks */
    note(s.mie.back, row[8], row[8], &worst[2]);
    if (row[3] > 0) note(s.mie.absorption, row[6], row[6] + 1e-12 * row[4], &worst[0]); /* its digits are those of Qext - Qsca */
    else ck_assert(s.mie.absorption == 0.0);
    free(s.block);
}

START_TEST(efficiencies_are_those_of_fifty_digits) {
    double worst[3] = {0, 0, 0};
    int rows = each_row("mie_efficiencies.csv", 2, 9, 0, check_efficiencies, worst);
    printf("    %d spheres: extinction, scattering, absorption off by %.2g, asymmetry %.2g, back %.2g\n", rows, worst[0], worst[1],
           worst[2]);
    ck_assert_int_ge(rows, 60);
    ck_assert(worst[0] < 1e-11 && worst[1] < 1e-12 && worst[2] < 1e-10);
}
END_TEST

/* x, n, k, theta, S1, S2, i1, i2, p; the table's m = n - ik. A zero index marks a perfect conductor. */
static void check_angle(const double *row, double *worst) {
    double s1[2], s2[2];
    if (row[1] == 0.0) return;
    Sphere s = sphere_of(row[0], row[1], row[2]);
    amplitudes(&s, row[3], s1, s2);
    double size = sqrt(0.5 * (row[8] + row[9]));
    note(s1[0], row[4], size, worst);
    note(s1[1], -row[5], size, worst);
    note(s2[0], row[6], size, worst);
    note(s2[1], -row[7], size, worst);
    free(s.block);
}

START_TEST(amplitudes_are_those_of_fifty_digits) {
    double worst = 0;
    int rows = each_row("mie_angles.csv", 2, 11, -1, check_angle, &worst);
    printf("    %d angles: amplitudes off by %.2g of their size\n", rows, worst);
    ck_assert_int_ge(rows, 500);
    ck_assert(worst < 1e-8);
}
END_TEST

/* case, perfectly conducting, x, n, k, Qext, Qsca, g Qsca, theta, S1, S2: seven digits. */
static void check_published(const double *row, double *worst) {
    double s1[2], s2[2];
    Sphere s = sphere_of(row[2], row[3], -row[4] > 0 ? -row[4] : row[4]);
    double size = hypot(row[9], row[10]) + hypot(row[11], row[12]);
    amplitudes(&s, row[8], s1, s2);
    note(s.mie.extinction, row[5], row[5], worst);
    note(s.mie.scattering, row[6], row[6], worst);
    note(s1[0], row[9], size, worst);
    note(s1[1], -row[10], size, worst);
    note(s2[0], row[11], size, worst);
    note(s2[1], -row[12], size, worst);
    note(s.mie.asymmetry * s.mie.scattering, row[7], fabs(row[7]), worst);
    free(s.block);
}

START_TEST(wiscombes_printed_cases_come_out) {
    double worst = 0;
    int rows = each_row("mie_miev0_published.csv", 0, 13, 1, check_published, &worst);
    printf("    %d rows: off by %.2g\n", rows, worst);
    ck_assert_int_ge(rows, 50);
    ck_assert(worst < 2e-6);
}
END_TEST

static double bohrens_forward; /* S11 at 0 */

/* theta, S11 / S11(0), polarisation, S33 / S11, S34 / S11 */
static void check_bohren(const double *row, double *worst) {
    double s1[2], s2[2];
    Sphere s = sphere_of(2 * PI * 0.525 / 0.6328, 1.55, 0);
    amplitudes(&s, row[0], s1, s2);
    double i1 = s1[0] * s1[0] + s1[1] * s1[1], i2 = s2[0] * s2[0] + s2[1] * s2[1], s11 = 0.5 * (i1 + i2);
    note(s11 / bohrens_forward, row[1], row[1], worst);
    note(-0.5 * (i2 - i1) / s11, row[2], 1, worst);
    note((s2[0] * s1[0] + s2[1] * s1[1]) / s11, row[3], 1, worst);
    note((s2[1] * s1[0] - s2[0] * s1[1]) / s11, row[4], 1, worst);
    free(s.block);
}

START_TEST(bohren_and_huffmans_sample_comes_out) {
    double worst = 0, s1[2], s2[2];
    Sphere s = sphere_of(2 * PI * 0.525 / 0.6328, 1.55, 0);
    amplitudes(&s, 0, s1, s2);
    bohrens_forward = s1[0] * s1[0] + s1[1] * s1[1];
    int rows = each_row("mie_bh_sample.csv", 0, 5, -1, check_bohren, &worst);
    printf("    %d angles off by %.2g; Qext %.7g (3.10543), Qback %.7g (2.92534)\n", rows, worst, s.mie.extinction, s.mie.back);
    ck_assert(worst < 5e-6 && fabs(s.mie.extinction - 3.10543) < 5e-6 && fabs(s.mie.back - 2.92534) < 5e-6);
    free(s.block);
}
END_TEST

static const double some[][3] = {{1e-6, 1.33, 0}, {1e-3, 1.5, 1}, {0.1, 1.33, 1e-9}, {1, 1.33, 1e-5}, {3, 1.33, 1e-8}, {10, 1.5, 0.1}, {100, 1.31, 2e-9},
                                 {1234.5, 1.335, 2e-9}, {500, 0.75, 0}, {200, 10, 10}, {11424, 1.3355, 2e-9}, {1e5, 1.33, 1e-4}};
enum { SOME = (int)(sizeof some / sizeof some[0]) };

/* Qext = 4 / x^2 Re S(0) [Bohren83 eq. 4.76]: a sum of the coefficients themselves, not of their squares. S1 = S2 at 0, S1 = -S2 at
 * 180, where |S|^2 is Qback x^2 / 4. The amplitude of a small sphere is i x^3 to x^6 of Re S: there digits are lost, in this sum alone. */
START_TEST(the_optical_theorem_holds) {
    for (int i = 0; i < SOME; i++) {
        double s1[2], s2[2], b1[2], b2[2], x = some[i][0];
        Sphere s = sphere_of(x, some[i][1], some[i][2]);
        amplitudes(&s, 0, s1, s2);
        amplitudes(&s, 180, b1, b2);
        double ext = 4 * s1[0] / (x * x), size = 4 * hypot(s1[0], s1[1]) / (x * x), back = 4 * (b1[0] * b1[0] + b1[1] * b1[1]) / (x * x);
        ck_assert_msg(fabs(ext - s.mie.extinction) < 1e-12 * s.mie.extinction + 2e-15 * size, "x %g: %.15g, not %.15g", x, s.mie.extinction, ext);
        ck_assert(fabs(s.mie.extinction - s.mie.absorption - s.mie.scattering) <= 1e-15 * s.mie.extinction);
        ck_assert_msg(fabs(back / s.mie.back - 1) < 1e-9, "x %g: %.15g, not %.15g", x, s.mie.back, back);
        ck_assert(hypot(s1[0] - s2[0], s1[1] - s2[1]) < 1e-12 * hypot(s1[0], s1[1]));
        ck_assert(hypot(b1[0] + b2[0], b1[1] + b2[1]) < 1e-12 * hypot(b1[0], b1[1]));
        free(s.block);
    }
}
END_TEST

/* |S1|^2 + |S2|^2 is a polynomial in the cosine of degree 2 orders: Gauss's rule with enough points is exact. */
static void gauss(int count, double *at, double *weight) {
    for (int i = 0; i < count; i++) {
        double z = cos(PI * (i + 0.75) / (count + 0.5)), slope = 1;
        for (int step = 0; step < 8; step++) {
            double p = 1, before = 0;
            for (int n = 1; n <= count; n++) {
                double next = ((2 * n - 1) * z * p - (n - 1) * before) / n;
                before = p;
                p = next;
            }
            slope = count * (z * p - before) / (z * z - 1);
            z -= p / slope;
        }
        at[i] = z;
        weight[i] = 2 / ((1 - z * z) * slope * slope);
    }
}

START_TEST(scattering_and_asymmetry_are_integrals_of_the_phase_function) {
    for (int i = 0; i < SOME; i++) {
        double x = some[i][0], integral = 0, moment = 0;
        if (x > 1300) continue;
        Sphere s = sphere_of(x, some[i][1], some[i][2]);
        int count = nph_mie_orders(x) + 2;
        double *at = malloc((size_t)count * sizeof *at), *weight = malloc((size_t)count * sizeof *weight);
        gauss(count, at, weight);
        for (int k = 0; k < count; k++) {
            double s1[2], s2[2];
            nph_mie_amplitudes(&s.terms, 1 - fabs(at[k]), at[k] < 0, s1, s2);
            double p = (s1[0] * s1[0] + s1[1] * s1[1] + s2[0] * s2[0] + s2[1] * s2[1]) / (x * x) * weight[k];
            integral += p;
            moment += at[k] * p;
        }
        ck_assert_msg(fabs(integral / s.mie.scattering - 1) < 1e-11, "x %g: %.15g, not %.15g", x, integral, s.mie.scattering);
        ck_assert_msg(fabs(moment / integral - s.mie.asymmetry) < 1e-11, "x %g: g %.15g, not %.15g", x, moment / integral, s.mie.asymmetry);
        free(at);
        free(weight);
        free(s.block);
    }
}
END_TEST

/* Rayleigh's limit [Bohren83 eq. 5.8, 5.11]: with L = (m^2 - 1) / (m^2 + 2), Qsca = 8/3 x^4 |L|^2, Qabs = 4 x Im L, both but
 * for x^2 relative; p = 3 / (16 pi) (1 + cos^2). */
START_TEST(small_spheres_scatter_as_rayleigh_says) {
    static const double index[][2] = {{1.33, 0}, {1.33, 1e-9}, {1.5, 1}, {0.75, 0}, {1.31, 0.1}};
    for (double x = 1e-6; x < 0.02; x *= 2)
        for (int i = 0; i < 5; i++) {
            double n = index[i][0], k = index[i][1], re = n * n - k * k, im = 2 * n * k;
            double below = (re + 2) * (re + 2) + im * im, l_re = ((re - 1) * (re + 2) + im * im) / below, l_im = 3 * im / below;
            Sphere s = sphere_of(x, n, k);
            double sca = 8.0 / 3 * x * x * x * x * (l_re * l_re + l_im * l_im), near = 4 * x * x + 1e-14, s1[2], s2[2];
            ck_assert_msg(fabs(s.mie.scattering / sca - 1) < near, "x %g m %g %g: %g", x, n, k, s.mie.scattering / sca - 1);
            if (k > 0) ck_assert_msg(fabs(s.mie.absorption / (4 * x * l_im) - 1) < near, "x %g m %g %g: %g", x, n, k, s.mie.absorption / (4 * x * l_im) - 1);
            ck_assert(fabs(s.mie.asymmetry) < x * x);
            for (double theta = 0; theta <= 180; theta += 15) {
                double c = cos(theta * PI / 180);
                amplitudes(&s, theta, s1, s2);
                double p = (s1[0] * s1[0] + s1[1] * s1[1] + s2[0] * s2[0] + s2[1] * s2[1]) / (2 * PI * x * x * s.mie.scattering);
                ck_assert(fabs(p / (3 / (16 * PI) * (1 + c * c)) - 1) < 10 * near);
            }
            free(s.block);
        }
}
END_TEST

/* Towards 2 as x^(-2/3): [Nussenzveig80] gives 2 + 1.9923861 x^(-2/3) for large spheres, here of strong absorption. */
START_TEST(large_spheres_take_away_twice_their_cross_section) {
    for (double x = 1e3; x <= 1e5; x *= 10) {
        Sphere s = sphere_of(x, 1.33, 0.3);
        double edge = 2 + 1.9923861 * pow(x, -2.0 / 3);
        ck_assert_msg(fabs(s.mie.extinction - edge) < 10 / x, "x %g: %g, not %g", x, s.mie.extinction, edge);
        free(s.block);
    }
}
END_TEST

static void fill(TCase *tcase) {
    tcase_add_test(tcase, efficiencies_are_those_of_fifty_digits);
    tcase_add_test(tcase, amplitudes_are_those_of_fifty_digits);
    tcase_add_test(tcase, wiscombes_printed_cases_come_out);
    tcase_add_test(tcase, bohren_and_huffmans_sample_comes_out);
    tcase_add_test(tcase, the_optical_theorem_holds);
    tcase_add_test(tcase, scattering_and_asymmetry_are_integrals_of_the_phase_function);
    tcase_add_test(tcase, small_spheres_scatter_as_rayleigh_says);
    tcase_add_test(tcase, large_spheres_take_away_twice_their_cross_section);
}

int main(void) { return nph_test_main("mie", fill); }
