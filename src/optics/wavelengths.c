/* SPDX-License-Identifier: Apache-2.0
 *
 * Quadrature of the standard observer over a list of wavelengths (wavelengths.h). */
#include "optics/wavelengths.h"

#include "optics/cie.h"

static double observer(double nm, int k) {
    double at = nm - (double)NPH_CIE_FIRST_NM;
    int i = (int)at < NPH_CIE_COUNT - 2 ? (int)at : NPH_CIE_COUNT - 2;
    return nph_cie1931[i][k] + (at - (double)i) * (nph_cie1931[i + 1][k] - nph_cie1931[i][k]);
}

static double width(const double *nm, int count, int i) {
    if (count == 1) return 1.0;
    if (i == 0) return nm[1] - nm[0];
    if (i == count - 1) return nm[i] - nm[i - 1];
    return 0.5 * (nm[i + 1] - nm[i - 1]);
}

void nph_wavelength_weights(const double *wavelengths_nm, int count, double (*weight)[3]) {
    double white = 0.0;
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < 3; k++) weight[i][k] = width(wavelengths_nm, count, i) * observer(wavelengths_nm[i], k);
        white += weight[i][1];
    }
    for (int i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) weight[i][k] /= white;
}

void nph_wavelength_matrix(const double *wavelengths_nm, int count, int group, double rgb_from_channels[9]) {
    double weight[NPH_MAX_WAVELENGTHS][3], rgb[3];
    nph_wavelength_weights(wavelengths_nm, count, weight);
    for (int c = 0; c < 3; c++) {
        int repeated, i = nph_wavelength_of(count, group, c, &repeated);
        nph_rgb_from_xyz(weight[i], rgb);
        for (int k = 0; k < 3; k++) rgb_from_channels[3 * k + c] = repeated ? 0.0 : rgb[k];
    }
}

void nph_spectrum_thirds(const double *values, int count, double rgb[3]) {
    for (int c = 0; c < 3; c++) {
        int first = count * (2 - c) / 3, end = (count * (3 - c) + 2) / 3;
        double sum = 0.0;
        for (int i = first; i < end; i++) sum += values[i];
        rgb[c] = sum / (double)(end - first);
    }
}
