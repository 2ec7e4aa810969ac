/* SPDX-License-Identifier: Apache-2.0
 *
 * Distribution functions that verdicts need: normal, Student t, chi-square, and the gamma and beta functions below.
 * All in double, relative error below 1e-10 in both tails down to 1e-250 (tests/oracle/test_student.c), the same bits
 * everywhere; plain functions of their arguments. Upper tails: the lower one with -t, or nph_chi_square_upper. */
#ifndef NPH_ORACLE_STUDENT_H
#define NPH_ORACLE_STUDENT_H

/* ln Gamma(x), x > 0. */
double nph_log_gamma(double x);

/* Regularised incomplete gamma functions P(a, x) and Q = 1 - P; a > 0, x >= 0. [DLMF 8.2.4] */
double nph_gamma_lower(double a, double x);
double nph_gamma_upper(double a, double x);

/* Regularised incomplete beta function I_x(a, b); a, b > 0; y = 1 - x is given apart because it may be tiny.
 * [DLMF 8.17.2] */
double nph_beta_lower(double a, double b, double x, double y);

/* P(X <= z) and its inverse, p in (0, 1). */
double nph_normal_lower(double z);
double nph_normal_quantile(double p);

/* Student t with dof > 0 degrees of freedom, not necessarily an integer; infinity gives the normal distribution. */
double nph_student_lower(double t, double dof);
double nph_student_quantile(double p, double dof);

/* Chi-square with dof > 0 degrees of freedom. */
double nph_chi_square_lower(double x, double dof);
double nph_chi_square_upper(double x, double dof);
double nph_chi_square_quantile(double p, double dof);

#endif
