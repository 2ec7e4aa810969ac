/* SPDX-License-Identifier: Apache-2.0
 *
 * See shdom_angles.h. Ordinates: on both hemispheres the points of Gauss and Legendre in the cosine, which integrate fluxes through
 * horizontal planes exactly and keep harmonics of degree < bands orthogonal from 2 bands polar angles on; azimuths even, half a step off
 * the axes. Delta-M [Wiscombe77]: f = chi_bands, chi'_l = (chi_l - f) / (1 - f). */
#include "truth/shdom/shdom_angles.h"

#include "core/fmath.h"
#include "optics/legendre.h"

#define PI 3.14159265358979323846

/* P_n and its derivative by recurrence, at x in (-1, 1). */
static double legendre(int n, double x, double *slope) {
    double before = 1.0, now = x;
    for (int k = 2; k <= n; k++) {
        double next = ((2.0 * k - 1.0) * x * now - (k - 1.0) * before) / (double)k;
        before = now;
        now = next;
    }
    *slope = (double)n * (x * now - before) / (x * x - 1.0);
    return now;
}

/* Newton's steps from Tricomi's first guess; symmetric to the bit. */
void nph_shdom_gauss(int count, double *point, double *weight) {
    for (int i = 0; i < (count + 1) / 2; i++) {
        double x = nph_cos(PI * (i + 0.75) / (count + 0.5)), slope = 1.0;
        if (2 * i + 1 == count) x = 0.0;
        for (int step = 0; step < 8; step++) {
            double value = legendre(count, x, &slope);
            if (2 * i + 1 != count) x -= value / slope;
        }
        legendre(count, x, &slope);
        double w = count == 1 ? 1.0 : 1.0 / ((1.0 - x * x) * slope * slope);
        point[count - 1 - i] = 0.5 + 0.5 * x;
        point[i] = 0.5 - 0.5 * x;
        weight[i] = weight[count - 1 - i] = w;
    }
}

double nph_shdom_ordinate(const NphShdomAngles *angles, int ordinate, double d[3]) {
    int p = ordinate / angles->azimuths, a = ordinate % angles->azimuths;
    double sine, cosine, across = nph_sqrt(1.0 - angles->cosine[p] * angles->cosine[p]);
    nph_sincos2pi((a + 0.5) / (double)angles->azimuths, &sine, &cosine);
    d[0] = across * cosine;
    d[1] = across * sine;
    d[2] = angles->cosine[p];
    return angles->weight[p] * 2.0 * PI / (double)angles->azimuths;
}

int nph_shdom_ordinate_of(const NphShdomAngles *angles, const double d[3]) {
    double turn = nph_atan2(d[1], d[0]) / (2.0 * PI), top = -1.0;
    int p = 0, a = (int)nph_floor((turn - nph_floor(turn)) * (double)angles->azimuths);
    for (; p < angles->polar - 1; p++) {
        top += angles->weight[p];
        if (2 * (p + 1) == angles->polar) top = 0.0;
        if (d[2] < top) break;
    }
    return p * angles->azimuths + (a < angles->azimuths ? a : angles->azimuths - 1);
}

/* Associated Legendre functions, normalised, by the recurrence in l that is stable [Press92 sec. 6.8]:
 *   Q_mm = sqrt((2 m + 1) / (4 pi (2 m)!)) (2 m - 1)!! sin^m,  Q_lm = a (z Q_{l-1,m} - b Q_{l-2,m}) */
void nph_shdom_harmonics(int bands, const double d[3], double *y) {
    double z = d[2], re = 1.0, im = 0.0, top = nph_sqrt(0.25 / PI); /* (x + i y)^m = sin^m e^(i m phi) */
    for (int m = 0; m < bands; m++) {
        double before = 0.0, now = top, scale = m > 0 ? nph_sqrt(2.0) : 1.0, last = 0.0;
        for (int l = m; l < bands; l++) {
            y[l * (l + 1) + m] = scale * now * re;
            if (m > 0) y[l * (l + 1) - m] = scale * now * im;
            double n = l + 1.0, a = nph_sqrt((4.0 * n * n - 1.0) / (n * n - (double)(m * m)));
            double next = a * (z * now - last * before);
            before = now;
            now = next;
            last = 1.0 / a;
        }
        double turned = re * d[0] - im * d[1];
        im = re * d[1] + im * d[0];
        re = turned;
        top *= nph_sqrt((2.0 * m + 3.0) / (2.0 * m + 2.0));
    }
}

static void add_legendre(double x, double weight, int count, double *sums) {
    double before = 1.0, now = x;
    sums[0] += weight;
    for (int l = 1; l < count; l++) {
        sums[l] += weight * now;
        double next = ((2.0 * l + 1.0) * x * now - l * before) / (l + 1.0);
        before = now;
        now = next;
    }
}

double nph_shdom_cut_phase(const NphShdomAngles *angles, double cosine, int windowed) {
    const double *of = windowed ? angles->kept : angles->plain;
    double terms[NPH_SHDOM_BANDS_MAX] = {0.0}, sum = 0.0;
    add_legendre(cosine, 1.0, angles->bands, terms);
    for (int l = 0; l < angles->bands; l++) sum += (2.0 * l + 1.0) * of[l] * terms[l];
    return sum;
}

/* 1 at degree 0. Hann's and Lanczos's reach 0 at degree `width`, the Gaussian e^-2. */
static double window_at(int kind, double x) {
    if (kind == NPH_SHDOM_NO_WINDOW || !(x > 0.0)) return 1.0;
    if (kind == NPH_SHDOM_GAUSSIAN) return nph_exp(-2.0 * x * x);
    if (x >= 1.0) return 0.0;
    return kind == NPH_SHDOM_HANNING ? 0.5 + 0.5 * nph_cos(PI * x) : nph_sin(PI * x) / (PI * x);
}

/* f, no more than keeps all moments at -1 or above: what a backward peak has in even degrees is no forward peak. */
static double cut_of(const double *chi, int bands) {
    double f = chi[bands];
    for (int l = 0; l < bands; l++) f = 0.5 * (1.0 + chi[l]) < f ? 0.5 * (1.0 + chi[l]) : f;
    return f > 0.0 ? f : 0.0;
}

void nph_shdom_angles(const NphPhase *phase, const NphShdomCut *cut, NphShdomAngles *angles) {
    double chi[NPH_SHDOM_BANDS_MAX + 1] = {0.0}, point[NPH_SHDOM_POLAR_MAX / 2] = {0.0}, weight[NPH_SHDOM_POLAR_MAX / 2] = {0.0};
    int half = (cut->polar > 0 ? cut->polar : 2 * cut->bands) / 2, last = 0;
    half = half > 0 ? half : 1;
    angles->bands = cut->bands;
    angles->polar = 2 * half;
    angles->azimuths = cut->azimuths > 0 ? cut->azimuths : 2 * cut->bands;
    nph_shdom_gauss(half, point, weight);
    for (int i = 0; i < half; i++) {
        angles->cosine[half + i] = point[i];
        angles->cosine[half - 1 - i] = -point[i];
        angles->weight[half + i] = angles->weight[half - 1 - i] = weight[i];
    }
    nph_phase_moments(phase, cut->bands + 1, chi);
    angles->cut = cut->delta_m ? cut_of(chi, cut->bands) : 0.0;
    double width = cut->width > 0.0 ? cut->width : (double)cut->bands;
    for (int l = 0; l < NPH_SHDOM_BANDS_MAX; l++) {
        angles->plain[l] = l < cut->bands ? (chi[l] - angles->cut) / (1.0 - angles->cut) : 0.0;
        angles->kept[l] = angles->plain[l] * window_at(cut->window, (double)l / width);
        if (nph_abs(angles->kept[l]) > 0.0) last = l;
    }
    angles->terms = (last + 1) * (last + 1);
}
