/* SPDX-License-Identifier: Apache-2.0
 *
 * The distribution functions against closed forms, and against values computed with 40 digits (mpmath: betainc,
 * gammainc, ncdf, loggamma), from the middle of a distribution to 1e-270 in its tail. */
#include <math.h>
#include <stdio.h>

#include "harness.h"
#include "oracle/student.h"

#define PI 3.14159265358979323846

static double worst;

/* Relative error against a value that is not 0. */
static void check_near(const char *what, double x, double parameter, double got, double expected) {
    double error = fabs(got / expected - 1.0);
    if (error > worst) worst = error;
    ck_assert_msg(error < 1e-10, "%s(%g; %g) is %.17g, not %.17g", what, x, parameter, got, expected);
}

typedef struct Value2 {
    double x, value;
} Value2;
typedef struct Value3 {
    double x, dof, value;
} Value3;
typedef struct Value4 {
    double x, dof, lower, upper;
} Value4;

static const Value2 normal_values[] = { /* z, P(Z <= z) */
    {-0.1, 0.46017216272297101633}, {-0.7, 0.24196365222307302862}, {-1.5, 0.066807201268858066004},
    {-3, 0.0013498980316300945267}, {-6, 9.865876450376981407e-10}, {-12, 1.7764821120776789977e-33},
    {-30, 4.9067139271481870595e-198},
};
static const Value3 student_values[] = { /* t, degrees of freedom, P(T <= t) */
    {-0.01, 0.7, 0.49705375629818677774}, {-0.9, 0.7, 0.2897730539408390162},
    {-1.8, 0.7, 0.19716168918900148975}, {-4.5, 0.7, 0.10764940352817112089},
    {-12, 0.7, 0.054529357491966069764}, {-35, 0.7, 0.025799971835481909883},
    {-0.01, 1, 0.49681700723509174478}, {-0.9, 1, 0.2667377083565741069},
    {-1.8, 1, 0.16141446721709524779}, {-4.5, 1, 0.069604487273063948715},
    {-12, 1, 0.026464676059589875452}, {-35, 1, 0.0090920946756484340776},
    {-0.01, 2, 0.49646455447910048569}, {-0.9, 2, 0.23155250617764787579},
    {-1.8, 2, 0.10683317450253292244}, {-4.5, 2, 0.02300095399713800954},
    {-12, 2, 0.0034364668385792300706}, {-35, 2, 0.00040766415257147927139},
    {-0.01, 2.5, 0.49638199717895412885}, {-0.9, 2.5, 0.22313197685642089915},
    {-1.8, 2.5, 0.093875473124315186133}, {-4.5, 2.5, 0.014947029504366996744},
    {-12, 2.5, 0.0014181075150391619145}, {-35, 2.5, 0.000099061078695384622889},
    {-0.01, 7, 0.49615015882181088546}, {-0.9, 7, 0.19901175948864502846},
    {-1.8, 7, 0.057442226597222250769}, {-4.5, 7, 0.0013991650389213148599},
    {-12, 7, 3.1791551890925501353e-6}, {-35, 7, 2.0163672583800428181e-9},
    {-0.01, 30, 0.49604374628658884825}, {-0.9, 30, 0.18764414338688403484},
    {-1.8, 30, 0.040962534304370142992}, {-4.5, 30, 0.000047596796960562344045},
    {-12, 30, 2.7900927075996280315e-13}, {-35, 30, 3.4738891805396189171e-26},
    {-0.01, 126, 0.49601855167120218848}, {-0.9, 126, 0.18491856876872578652},
    {-1.8, 126, 0.037126660096373024337}, {-4.5, 126, 7.6289378837055738205e-6},
    {-12, 126, 6.7743929027859094478e-23}, {-35, 126, 4.6007834248929472134e-67},
    {-0.01, 1999, 0.49601114260640534742}, {-0.9, 1999, 0.18411432778649789439},
    {-1.8, 1999, 0.036005678691225405746}, {-4.5, 1999, 3.5929767683070337693e-6},
    {-12, 1999, 2.1854684077186121734e-32}, {-35, 1999, 4.8059304126717586606e-210},
    {-0.01, 19999, 0.49601069355782852656}, {-0.9, 19999, 0.18406554371590962877},
    {-1.8, 19999, 0.035937851369241714183}, {-4.5, 19999, 3.4168207782655281848e-6},
    {-12, 19999, 2.3075488625542064317e-33}, {-35, 19999, 7.8115282211868977482e-261},
    {-0.01, 20001, 0.49601069355284156107}, {-0.9, 20001, 0.18406554317410607063},
    {-1.8, 20001, 0.035937850616050283793}, {-4.5, 20001, 3.4168188594793369182e-6},
    {-12, 20001, 2.3074887991991225072e-33}, {-35, 20001, 7.7979839727777026137e-261},
    {-0.01, 1e6, 0.49601064468277383658}, {-0.9, 1e6, 0.18406023370995243774},
    {-1.8, 1e6, 0.035930469749841684523}, {-4.5, 1e6, 3.3980552524769492853e-6},
    {-12, 1e6, 1.7858425623825449118e-33}, {-35, 1e6, 1.6374918163375649609e-268},
    {-0.01, 1e12, 0.49601064368536939362}, {-0.9, 1e12, 0.18406012534686784586},
    {-1.8, 1e12, 0.035930319113076437356}, {-4.5, 1e12, 3.3976731251121717125e-6},
    {-12, 1e12, 1.7764821214144482715e-33}, {-35, 1e12, 1.1249111291784959485e-268},
};
static const Value4 chi_square_values[] = { /* x, degrees of freedom, P(X <= x), P(X > x) */
    {0.01, 1, 0.079655674554057963757, 0.92034432544594203624},
    {0.5, 1, 0.52049987781304653768, 0.47950012218695346232},
    {1, 1, 0.68268949213708589717, 0.31731050786291410283},
    {1.3, 1, 0.7457867763960356202, 0.2542132236039643798},
    {3, 1, 0.91673548333644959815, 0.083264516663550401855},
    {0.02, 2, 0.0099501662508319466322, 0.99004983374916805337},
    {1.0, 2, 0.3934693402873665764, 0.6065306597126334236},
    {2, 2, 0.6321205588285576784, 0.3678794411714423216},
    {2.6, 2, 0.72746820696598740898, 0.27253179303401259102},
    {6, 2, 0.95021293163213605702, 0.049787068367863942979},
    {0.035, 3.5, 0.00051772736751878913309, 0.99948227263248121087},
    {1.75, 3.5, 0.28898520572700163274, 0.71101479427299836726},
    {3.5, 3.5, 0.60042790026695614175, 0.39957209973304385825},
    {4.55, 3.5, 0.72973450787283331037, 0.27026549212716668963},
    {10.5, 3.5, 0.97747961133176063258, 0.022520388668239367421},
    {0.19, 19, 1.5729819641371575507e-16, 0.9999999999999998427},
    {9.5, 19, 0.035778429267643963832, 0.96422157073235603617},
    {19, 19, 0.54316387440803761656, 0.45683612559196238344},
    {24.7, 19, 0.82934415224424627683, 0.17065584775575372317},
    {57, 19, 0.99998857380650645336, 0.000011426193493546636601},
    {2.0, 200, 3.9812808189568544112e-159, 1.0},
    {100.0, 200, 3.2000653245851252938e-10, 0.99999999967999346754},
    {200, 200, 0.51329879827914866486, 0.48670120172085133514},
    {260.0, 200, 0.99724959163269347372, 0.002750408367306526277},
    {600, 200, 1.0, 1.4110215102111521394e-41},
    {2000.0, 4000, 3.058192080168756795e-170, 1.0},
    {4000, 4000, 0.50297354844420253466, 0.49702645155579746534},
    {5200.0, 4000, 1.0, 6.0281550200821681576e-35},
};
static const Value2 log_gamma_values[] = {
    {0.01, 4.5994798780420217016}, {0.5, 0.57236494292470008707}, {1, 0.0},
    {1.5, -0.12078223763524522235}, {2, 0.0}, {3.3, 0.98709857789473440406},
    {9.99, 12.77931521435019336}, {10, 12.801827480081469611}, {123.4, 469.33609744219058579},
    {100000.0, 1051287.7089736568949},
};

#define COUNT(array) (int)(sizeof(array) / sizeof *(array))

START_TEST(values_with_forty_digits_are_matched_to_1e_10) {
    worst = 0.0;
    for (int i = 0; i < COUNT(normal_values); i++) {
        Value2 v = normal_values[i];
        check_near("normal", v.x, 0, nph_normal_lower(v.x), v.value);
        check_near("normal", -v.x, 0, nph_normal_lower(-v.x), 1.0 - v.value);
    }
    for (int i = 0; i < COUNT(student_values); i++) {
        Value3 v = student_values[i];
        check_near("student", v.x, v.dof, nph_student_lower(v.x, v.dof), v.value);
        check_near("student", -v.x, v.dof, nph_student_lower(-v.x, v.dof), 1.0 - v.value);
    }
    for (int i = 0; i < COUNT(chi_square_values); i++) {
        Value4 v = chi_square_values[i];
        check_near("chi-square", v.x, v.dof, nph_chi_square_lower(v.x, v.dof), v.lower);
        check_near("chi-square, upper", v.x, v.dof, nph_chi_square_upper(v.x, v.dof), v.upper);
    }
    for (int i = 0; i < COUNT(log_gamma_values); i++) {
        Value2 v = log_gamma_values[i];
        double error = fabs(nph_log_gamma(v.x) - v.value);
        ck_assert_msg(error < 1e-13 * (10.0 + fabs(v.value)), "ln Gamma(%g) is off by %g", v.x, error);
    }
    printf("worst relative error: %.2g\n", worst);
}
END_TEST

START_TEST(student_is_cauchy_for_one_degree_and_algebraic_for_two) {
    for (double t = -50.0; t <= 50.0; t += 0.37) {
        double cauchy = t < 0 ? atan2(1.0, -t) / PI : 1.0 - atan2(1.0, t) / PI;
        double root = sqrt(2.0 + t * t);
        double two = t < 0 ? 1.0 / (root * (root - t)) : 1.0 - 1.0 / (root * (root + t));
        check_near("student", t, 1, nph_student_lower(t, 1.0), cauchy);
        check_near("student", t, 2, nph_student_lower(t, 2.0), two);
    }
}
END_TEST

START_TEST(student_is_continuous_where_its_formulas_meet) {
    for (double t = -30.0; t < 0.0; t += 0.5) {
        check_near("student", t, 20000, nph_student_lower(t, 20000.00000001), nph_student_lower(t, 20000));
        check_near("student", t, 1e18, nph_student_lower(t, 0.9e18), nph_student_lower(t, 1.1e18));
    }
    for (double dof = 1.0; dof < 300.0; dof *= 1.7) {
        double t = -sqrt(3.0 * dof / (dof + 2.0));
        check_near("student", t, dof, nph_student_lower(t * (1 + 1e-14), dof), nph_student_lower(t * (1 - 1e-14), dof));
    }
}
END_TEST

START_TEST(chi_square_with_even_degrees_is_a_poisson_sum) {
    for (int half = 1; half <= 40; half += 3) {
        for (double x = 0.1; x < 300.0; x *= 1.9) {
            double term = exp(-0.5 * x), sum = 0.0;
            for (int k = 0; k < half; k++) {
                sum += term;
                term *= 0.5 * x / (k + 1);
            }
            check_near("chi-square, upper", x, 2 * half, nph_chi_square_upper(x, 2.0 * half), sum);
        }
    }
}
END_TEST

START_TEST(beta_has_its_polynomials_and_its_symmetry) {
    for (double x = 0.001; x < 1.0; x += 0.0415) {
        double y = 1.0 - x;
        check_near("beta 1 1", x, 0, nph_beta_lower(1, 1, x, y), x);
        check_near("beta 3 1", x, 0, nph_beta_lower(3, 1, x, y), x * x * x);
        check_near("beta 2 3", x, 0, nph_beta_lower(2, 3, x, y), x * x * (6.0 - 8.0 * x + 3.0 * x * x));
        check_near("beta 0.5 0.5", x, 0, nph_beta_lower(0.5, 0.5, x, y), 2.0 / PI * asin(sqrt(x)));
        ck_assert_double_eq_tol(nph_beta_lower(4.2, 7.7, x, y) + nph_beta_lower(7.7, 4.2, y, x), 1.0, 1e-14);
    }
}
END_TEST

START_TEST(quantiles_invert_their_distributions) {
    static const double dofs[] = {0.7, 1, 3, 20, 500, 1e5, 1e9};
    static const double ps[] = {1e-12, 1e-6, 0.005, 0.3, 0.5, 0.7, 0.995, 0.999999};
    for (int i = 0; i < COUNT(ps); i++) {
        check_near("normal quantile", ps[i], 0, nph_normal_lower(nph_normal_quantile(ps[i])), ps[i]);
        for (int k = 0; k < COUNT(dofs); k++) {
            check_near("student quantile", ps[i], dofs[k],
                       nph_student_lower(nph_student_quantile(ps[i], dofs[k]), dofs[k]), ps[i]);
            if (dofs[k] < 1e6) {
                check_near("chi-square quantile", ps[i], dofs[k],
                           nph_chi_square_lower(nph_chi_square_quantile(ps[i], dofs[k]), dofs[k]), ps[i]);
            }
        }
    }
    /* Textbook values: two-sided 5% points of t with 10 and infinitely many degrees, upper 5% of chi-square with 19. */
    ck_assert_double_eq_tol(nph_student_quantile(0.975, 10), 2.228138851964939, 1e-10);
    ck_assert_double_eq_tol(nph_student_quantile(0.975, INFINITY), 1.959963984540054, 1e-10);
    ck_assert_double_eq_tol(nph_chi_square_quantile(0.95, 19), 30.14352720564616, 1e-9);
}
END_TEST

START_TEST(the_ends_of_the_range_are_exact) {
    ck_assert_double_eq(nph_student_lower(-INFINITY, 3), 0.0);
    ck_assert_double_eq(nph_student_lower(INFINITY, 3), 1.0);
    ck_assert_double_eq(nph_student_lower(-INFINITY, 1e6), 0.0);
    ck_assert_double_eq(nph_student_lower(0.0, 5), 0.5);
    ck_assert_double_eq(nph_student_lower(-1e200, 1e4), 0.0);
    ck_assert_double_eq(nph_normal_lower(-INFINITY), 0.0);
    ck_assert_double_eq(nph_normal_lower(INFINITY), 1.0);
    ck_assert_double_eq(nph_chi_square_lower(0.0, 4), 0.0);
    ck_assert_double_eq(nph_chi_square_upper(0.0, 4), 1.0);
    ck_assert_double_eq(nph_chi_square_upper(INFINITY, 4), 0.0);
    ck_assert_double_eq(nph_beta_lower(2, 3, 0.0, 1.0), 0.0);
    ck_assert_double_eq(nph_beta_lower(2, 3, 1.0, 0.0), 1.0);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, values_with_forty_digits_are_matched_to_1e_10);
    tcase_add_test(cases, student_is_cauchy_for_one_degree_and_algebraic_for_two);
    tcase_add_test(cases, student_is_continuous_where_its_formulas_meet);
    tcase_add_test(cases, chi_square_with_even_degrees_is_a_poisson_sum);
    tcase_add_test(cases, beta_has_its_polynomials_and_its_symmetry);
    tcase_add_test(cases, quantiles_invert_their_distributions);
    tcase_add_test(cases, the_ends_of_the_range_are_exact);
}

int main(void) { return nph_test_main("student", fill); }
