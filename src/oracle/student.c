/* SPDX-License-Identifier: Apache-2.0
 *
 * See student.h. Gamma and beta functions by series and continued fractions (DLMF 8.7.1, 8.9.2, 8.17.22; modified Lentz
 * evaluation), ln Gamma by Stirling's series [DLMF 5.11.1]; Student t with many degrees of freedom by Hill's
 * transformation to a normal variable [Hill70]; quantiles by bisection and chords, which need no derivative. */
#include "oracle/student.h"

#include "core/fmath.h"

#define HALF_LOG_2PI 0.91893853320467274178
#define SQRT_2PI 2.50662827463100050242

enum { MOST_TERMS = 1000000 };
static const double tiny = 1e-300, precision = 1e-16;
/* Above this many degrees of freedom Hill's transformation is exact to 1e-11 for |t| < 35. */
static const double hill_dof = 20000.0;

/* ln Gamma(x) minus its leading part (x - 1/2) ln x - x + ln(2 pi) / 2, for x >= 10: the term left out is 3e-17. */
static double stirling_rest(double x) {
    static const double c[] = {1.0 / 12, -1.0 / 360, 1.0 / 1260, -1.0 / 1680, 1.0 / 1188, -691.0 / 360360, 1.0 / 156};
    double u = 1.0 / (x * x), sum = 0.0;
    for (int i = 6; i >= 0; i--) sum = sum * u + c[i];
    return sum / x;
}

double nph_log_gamma(double x) {
    double product = 1.0;
    while (x < 10.0) product *= x++;
    return (x - 0.5) * nph_log(x) - x + HALF_LOG_2PI + stirling_rest(x) - nph_log(product);
}

/* x^a e^-x / Gamma(a). For large a the logarithms are taken of x / a, since a ln x and ln Gamma(a) nearly cancel. */
static double gamma_front(double a, double x) {
    if (a < 10.0) return nph_exp(a * nph_log(x) - x - nph_log_gamma(a));
    double d = (x - a) / a;
    double excess = nph_abs(d) < 0.5 ? nph_log1p(d) - d : nph_log(x / a) - d;
    return nph_exp(a * excess - stirling_rest(a)) * nph_sqrt(a) / SQRT_2PI;
}

/* P(a, x) = front / a * sum x^n / ((a + 1) ... (a + n)); converges fast for x < a + 1. */
static double gamma_series(double a, double x) {
    double term = 1.0 / a, sum = term;
    for (int n = 1; n < MOST_TERMS && term > sum * precision; n++) {
        term *= x / (a + n);
        sum += term;
    }
    return gamma_front(a, x) * sum;
}

/* Q(a, x) = front / (x + 1 - a - 1 (1 - a) / (x + 3 - a - 2 (2 - a) / (x + 5 - a - ...))), for x > a + 1. */
static double gamma_fraction(double a, double x) {
    double b = x + 1.0 - a, c = 1.0 / tiny, d = 1.0 / b, h = d;
    for (int n = 1; n < MOST_TERMS; n++) {
        double factor = n * (a - n);
        b += 2.0;
        d = factor * d + b;
        if (nph_abs(d) < tiny) d = tiny;
        c = b + factor / c;
        if (nph_abs(c) < tiny) c = tiny;
        d = 1.0 / d;
        h *= d * c;
        if (nph_abs(d * c - 1.0) < precision) break;
    }
    return gamma_front(a, x) * h;
}

double nph_gamma_lower(double a, double x) {
    if (!(x > 0.0)) return 0.0;
    if (x > 1e300) return 1.0;
    return x < a + 1.0 ? gamma_series(a, x) : 1.0 - gamma_fraction(a, x);
}

double nph_gamma_upper(double a, double x) {
    if (!(x > 0.0)) return 1.0;
    if (x > 1e300) return 0.0;
    return x < a + 1.0 ? 1.0 - gamma_series(a, x) : gamma_fraction(a, x);
}

/* I_x(a, b) by [DLMF 8.17.22], where x < (a + 1) / (a + b + 2). */
static double beta_fraction(double a, double b, double x, double y) {
    double log_x = y < 0.5 ? nph_log1p(-y) : nph_log(x), log_y = x < 0.5 ? nph_log1p(-x) : nph_log(y);
    double front = nph_exp(a * log_x + b * log_y + nph_log_gamma(a + b) - nph_log_gamma(a) - nph_log_gamma(b)) / a;
    double c = 1.0, d = 1.0 - (a + b) * x / (a + 1.0);
    if (nph_abs(d) < tiny) d = tiny;
    d = 1.0 / d;
    double h = d;
    for (int n = 1; n < MOST_TERMS; n++) {
        double even = n * (b - n) * x / ((a + 2 * n - 1.0) * (a + 2 * n));
        double odd = -(a + n) * (a + b + n) * x / ((a + 2 * n) * (a + 2 * n + 1.0));
        double factors[2] = {even, odd}, change = 1.0;
        for (int i = 0; i < 2; i++) {
            d = 1.0 + factors[i] * d;
            if (nph_abs(d) < tiny) d = tiny;
            c = 1.0 + factors[i] / c;
            if (nph_abs(c) < tiny) c = tiny;
            d = 1.0 / d;
            change = d * c;
            h *= change;
        }
        if (nph_abs(change - 1.0) < precision) break;
    }
    return front * h;
}

double nph_beta_lower(double a, double b, double x, double y) {
    if (!(x > 0.0)) return 0.0;
    if (!(y > 0.0)) return 1.0;
    if (x < (a + 1.0) / (a + b + 2.0)) return beta_fraction(a, b, x, y);
    return 1.0 - beta_fraction(b, a, y, x);
}

/* P(X > |z|) = Q(1/2, z^2 / 2) / 2, where the series would lose the digits of a small Q. */
double nph_normal_lower(double z) {
    double tail = 0.5 * nph_gamma_upper(0.5, 0.5 * z * z);
    return z < 0.0 ? tail : 1.0 - tail;
}

/* With a = dof - 1/2, b = 48 a^2, z = sqrt(a ln(1 + t^2 / dof)):
 * t is as probable as z + (z^3 + 3 z) / b - (4 z^7 + 33 z^5 + 240 z^3 + 855 z) / (10 b (b + 0.8 z^4 + 100)). */
static double hill_normal(double t, double dof) {
    double a = dof - 0.5, b = 48.0 * a * a, q = t * t / dof;
    if (!(q < 1e300)) return t;
    double z2 = a * nph_log1p(q), z = nph_sqrt(z2);
    double third = (((4.0 * z2 + 33.0) * z2 + 240.0) * z2 + 855.0) / (10.0 * b * (b + 0.8 * z2 * z2 + 100.0));
    double u = z * (1.0 + (z2 + 3.0) / b - third);
    return t < 0.0 ? -u : u;
}

double nph_student_lower(double t, double dof) {
    if (dof > 1e18) return nph_normal_lower(t);
    if (dof > hill_dof) return nph_normal_lower(hill_normal(t, dof));
    double t2 = t * t, tail;
    if (!(t2 < 1e300)) {
        tail = 0.0;
    } else if (t2 < 3.0 * dof / (dof + 2.0)) {
        tail = 0.5 - 0.5 * nph_beta_lower(0.5, 0.5 * dof, t2 / (dof + t2), dof / (dof + t2));
    } else {
        tail = 0.5 * nph_beta_lower(0.5 * dof, 0.5, dof / (dof + t2), t2 / (dof + t2));
    }
    return t < 0.0 ? tail : 1.0 - tail;
}

double nph_chi_square_lower(double x, double dof) { return nph_gamma_lower(0.5 * dof, 0.5 * x); }
double nph_chi_square_upper(double x, double dof) { return nph_gamma_upper(0.5 * dof, 0.5 * x); }

/* A falling function of x >= 0 with a parameter. */
typedef double Falling(double x, double dof);

/* The x >= 0 where falling(x) = p: doubled until bracketed, halved until a chord is a good guess, then chords until
 * they no longer move (Illinois: an end that stays has its weight halved). */
static double invert(Falling *falling, double dof, double p) {
    double low = 0.0, high = 1.0;
    while (falling(high, dof) > p && high < 1e300) {
        low = high;
        high *= 2.0;
    }
    while (high - low > 1e-3 * high && high > 1e-300) {
        double middle = 0.5 * (low + high);
        if (falling(middle, dof) > p) low = middle;
        else high = middle;
    }
    double above = falling(low, dof) - p, below = falling(high, dof) - p, last = high;
    for (int i = 0; i < 100 && below < 0.0; i++) {
        double x = high - (high - low) * below / (below - above), value = falling(x, dof) - p;
        if (nph_abs(x - last) <= 1e-15 * x) return x;
        last = x;
        if (value > 0.0) {
            low = x;
            above = value;
            below *= 0.5;
        } else {
            high = x;
            below = value;
            above *= 0.5;
        }
    }
    return high;
}

static double student_upper(double t, double dof) { return nph_student_lower(-t, dof); }
static double normal_upper(double z, double unused) {
    (void)unused;
    return nph_normal_lower(-z);
}
static double chi_square_not_lower(double x, double dof) { return -nph_chi_square_lower(x, dof); }

double nph_normal_quantile(double p) {
    return p < 0.5 ? -invert(normal_upper, 0.0, p) : invert(normal_upper, 0.0, 1.0 - p);
}

double nph_student_quantile(double p, double dof) {
    return p < 0.5 ? -invert(student_upper, dof, p) : invert(student_upper, dof, 1.0 - p);
}

double nph_chi_square_quantile(double p, double dof) {
    return p < 0.5 ? invert(chi_square_not_lower, dof, -p) : invert(nph_chi_square_upper, dof, 1.0 - p);
}
