/* SPDX-License-Identifier: Apache-2.0
 *
 * Coefficients and efficiencies of a sphere. With A = D_n(mx) / m + n / x (for b_n: m D_n(mx) + n / x), the logarithmic
 * derivative D, and Riccati-Bessel functions psi, chi [Bohren83 eq. 4.88]
 *   N = A psi_n - psi_{n-1},   C = A chi_n - chi_{n-1},   a_n = N / (N - i C).
 * What is absorbed needs no difference, by the Wronskian of psi and chi: Re a_n - |a_n|^2 = -Im A / |N - i C|^2. */
#include <stddef.h>
#include <stdint.h>

#include "core/reduce.h"
#include "optics/mie.h"

/* From |z| on psi_n(z) falls and chi_n(z) rises as exp(-+ 2/3 (2^(1/3) c)^(3/2)) at order |z| + c |z|^(1/3): at c = 7.6 psi / chi
 * is below 1e-17. The constant is for small z, where orders count one by one. */
static int orders_beyond(double z) { return (int)(z + 7.6 * nph_cbrt(z)) + 9; }

int nph_mie_orders(double x) { return orders_beyond(x); }

static int first_order(const NphMieSphere *sphere) {
    int from = orders_beyond(sphere->x * nph_sqrt(sphere->n * sphere->n + sphere->k * sphere->k)), most = nph_mie_orders(sphere->x);
    return (from > most ? from : most) + 16;
}

int64_t nph_mie_doubles(const NphMieSphere *sphere) {
    int64_t orders = nph_mie_orders(sphere->x);
    return 5 * orders + 3 * (orders + 1);
}

/* D_n(z) = n / z - 1 / (D_{n+1} + (n + 1) / z) ... down to order 1; kept up to `orders`. */
static void log_derivatives(const NphMieSphere *sphere, int orders, double *re, double *im) {
    double z_re = sphere->x * sphere->n, z_im = sphere->x * sphere->k, size = z_re * z_re + z_im * z_im;
    double inverse_re = z_re / size, inverse_im = -z_im / size, d_re = 0.0, d_im = 0.0;
    for (int n = first_order(sphere); n > 1; n--) {
        double q_re = (double)n * inverse_re, q_im = (double)n * inverse_im;
        double below_re = d_re + q_re, below_im = d_im + q_im, scale = 1.0 / (below_re * below_re + below_im * below_im);
        d_re = q_re - below_re * scale;
        d_im = q_im + below_im * scale;
        if (n - 1 > orders) continue;
        re[n - 1] = d_re;
        im[n - 1] = d_im;
    }
}

/* psi_{n-1} / psi_n, downwards; above order x psi has no zeros. */
static void psi_ratios(double x, int orders, double *ratio) {
    double above = (double)(2 * (orders + 16) + 1) / x;
    for (int n = orders + 15; n >= 1 && (double)n > x; n--) {
        above = (double)(2 * n + 1) / x - 1.0 / above;
        if (n <= orders) ratio[n] = above;
    }
}

typedef struct Radial {
    double psi, psi_before, chi, chi_before;
} Radial;

/* One of a_n, b_n for A; returns what is absorbed. */
static double coefficient(const Radial *radial, double a_re, double a_im, double *re, double *im) {
    double n_re = a_re * radial->psi - radial->psi_before, n_im = a_im * radial->psi;
    double c_re = a_re * radial->chi - radial->chi_before, c_im = a_im * radial->chi;
    double below_re = n_re + c_im, below_im = n_im - c_re, scale = 1.0 / (below_re * below_re + below_im * below_im);
    *re = (n_re * below_re + n_im * below_im) * scale;
    *im = (n_im * below_re - n_re * below_im) * scale;
    return -a_im * scale;
}

void nph_mie_terms(const NphMieSphere *sphere, double *block, NphMieTerms *terms) {
    int orders = nph_mie_orders(sphere->x);
    double x = sphere->x, m_re = sphere->n, m_im = sphere->k, size = m_re * m_re + m_im * m_im;
    *terms = (NphMieTerms){orders, block, block + orders, block + 2 * (ptrdiff_t)orders, block + 3 * (ptrdiff_t)orders,
                           block + 4 * (ptrdiff_t)orders, block + 5 * (ptrdiff_t)orders};
    double *d_re = terms->scratch, *d_im = d_re + orders + 1, *ratio = d_im + orders + 1;
    log_derivatives(sphere, orders, d_re, d_im);
    psi_ratios(x, orders, ratio);
    Radial radial = {nph_sin(x), nph_cos(x), nph_cos(x), -nph_sin(x)};
    for (int n = 1; n <= orders; n++) {
        double order = (double)n, step = (double)(2 * n - 1) / x, psi = radial.psi, chi = radial.chi;
        radial.psi = order > x ? psi / ratio[n] : step * psi - radial.psi_before;
        radial.chi = step * chi - radial.chi_before;
        radial.psi_before = psi;
        radial.chi_before = chi;
        double re = d_re[n], im = d_im[n];
        double a = coefficient(&radial, (re * m_re + im * m_im) / size + order / x, (im * m_re - re * m_im) / size,
                               &terms->a_re[n - 1], &terms->a_im[n - 1]);
        double b = coefficient(&radial, re * m_re - im * m_im + order / x, re * m_im + im * m_re, &terms->b_re[n - 1],
                               &terms->b_im[n - 1]);
        terms->absorbed[n - 1] = m_im > 0.0 ? a + b : 0.0;
    }
}

/* g [Bohren83 sec. 4.5], Q_back as the sum's square. */
void nph_mie_efficiencies(const NphMieSphere *sphere, const NphMieTerms *terms, NphMie *mie) {
    NphSum scattered = {0.0, 0.0}, absorbed = {0.0, 0.0}, moment = {0.0, 0.0}, back_re = {0.0, 0.0}, back_im = {0.0, 0.0};
    const double *a_re = terms->a_re, *a_im = terms->a_im, *b_re = terms->b_re, *b_im = terms->b_im;
    for (int i = 0; i < terms->count; i++) {
        double n = (double)(i + 1), weight = 2.0 * n + 1.0, sign = i & 1 ? 1.0 : -1.0;
        nph_sum_add(&scattered, weight * (a_re[i] * a_re[i] + a_im[i] * a_im[i] + b_re[i] * b_re[i] + b_im[i] * b_im[i]));
        nph_sum_add(&absorbed, weight * terms->absorbed[i]);
        nph_sum_add(&moment, weight / (n * (n + 1.0)) * (a_re[i] * b_re[i] + a_im[i] * b_im[i]));
        nph_sum_add(&back_re, sign * weight * (a_re[i] - b_re[i]));
        nph_sum_add(&back_im, sign * weight * (a_im[i] - b_im[i]));
        if (i + 1 == terms->count) break;
        double next = a_re[i] * a_re[i + 1] + a_im[i] * a_im[i + 1] + b_re[i] * b_re[i + 1] + b_im[i] * b_im[i + 1];
        nph_sum_add(&moment, n * (n + 2.0) / (n + 1.0) * next);
    }
    double scale = 2.0 / (sphere->x * sphere->x), re = nph_sum_value(back_re), im = nph_sum_value(back_im);
    mie->scattering = scale * nph_sum_value(scattered);
    mie->absorption = scale * nph_sum_value(absorbed);
    mie->extinction = mie->scattering + mie->absorption;
    mie->back = 0.5 * scale * (re * re + im * im);
    mie->asymmetry = 2.0 * nph_sum_value(moment) / nph_sum_value(scattered);
}

/* pi_n and tau_n by differences of pi, which keep their digits at the pole:
 *   d_n = pi_n - pi_{n-1},  t = d_n - distance pi_n,  tau_n = n t - pi_{n-1},  d_{n+1} = (n + 1)/n t - distance pi_n.
 * Seen from the backward pole a_n, b_n become s a_n, -s b_n, s = (-1)^(n+1), and S2 changes its sign. */
void nph_mie_amplitudes(const NphMieTerms *terms, double distance, int back, double s1[2], double s2[2]) {
    double sum[2][2] = {{0.0, 0.0}, {0.0, 0.0}}, pi = 1.0, d = 1.0;
    for (int i = 0; i < terms->count; i++) {
        double n = (double)(i + 1), away = distance * pi, t = d - away, tau = n * t - (pi - d);
        double scale = (2.0 * n + 1.0) / (n * (n + 1.0)), a = back && i & 1 ? -scale : scale, b = back ? -a : a;
        sum[0][0] += a * terms->a_re[i] * pi + b * terms->b_re[i] * tau;
        sum[0][1] += a * terms->a_im[i] * pi + b * terms->b_im[i] * tau;
        sum[1][0] += a * terms->a_re[i] * tau + b * terms->b_re[i] * pi;
        sum[1][1] += a * terms->a_im[i] * tau + b * terms->b_im[i] * pi;
        d = (n + 1.0) / n * t - away;
        pi += d;
    }
    for (int k = 0; k < 2; k++) {
        s1[k] = sum[0][k];
        s2[k] = back ? -sum[1][k] : sum[1][k];
    }
}
