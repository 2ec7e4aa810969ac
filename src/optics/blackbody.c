/* SPDX-License-Identifier: Apache-2.0
 *
 * Planck's law and its colour. Constants: the exact h, c, k of the SI [SI19]. */
#include "optics/blackbody.h"

#include "core/fmath.h"
#include "optics/cie.h"

static const double twice_hcc = 1.1910429723971884e-16; /* W m2 */
static const double hc_over_k = 1.4387768775039337e-2;  /* m K */

/* expm1 keeps the small exponents of hot bodies. Where exp would overflow B is below 1e-280. */
double nph_planck(double wavelength_nm, double kelvin) {
    double lambda = wavelength_nm * 1e-9, x = hc_over_k / (lambda * kelvin);
    if (!(kelvin > 0.0) || x > 700.0) return 0.0;
    double squared = lambda * lambda;
    return twice_hcc / (squared * squared * lambda) / nph_expm1(x) * 1e-9;
}

void nph_planck_xyz(double kelvin, double xyz[3]) {
    double sum[3] = {0.0, 0.0, 0.0}, white = 0.0;
    for (int i = 0; i < NPH_CIE_COUNT; i++) {
        double radiance = nph_planck(NPH_CIE_FIRST_NM + i, kelvin);
        for (int k = 0; k < 3; k++) sum[k] += radiance * nph_cie1931[i][k];
        white += nph_cie1931[i][1];
    }
    for (int k = 0; k < 3; k++) xyz[k] = sum[k] / white;
}

static double log_step(void) { return nph_log(NPH_KELVIN_MOST / NPH_KELVIN_LEAST) / (NPH_PLANCK_KNOTS - 1); }

void nph_planck_table(NphPlanckTable *table) {
    for (int i = 0; i < NPH_PLANCK_KNOTS; i++) {
        double xyz[3];
        nph_planck_xyz(NPH_KELVIN_LEAST * nph_exp(i * log_step()), xyz);
        for (int k = 0; k < 3; k++) table->log_xyz[i][k] = nph_log(xyz[k]);
    }
}

/* Lagrange's polynomial through four knots around the place. */
void nph_planck_rgb(const NphPlanckTable *table, double kelvin, double rgb[3]) {
    double xyz[3];
    rgb[0] = rgb[1] = rgb[2] = 0.0;
    if (!(kelvin >= NPH_KELVIN_LEAST)) return;
    double place = nph_log((kelvin < NPH_KELVIN_MOST ? kelvin : NPH_KELVIN_MOST) / NPH_KELVIN_LEAST) / log_step();
    int first = (int)place - 1;
    first = first < 0 ? 0 : first > NPH_PLANCK_KNOTS - 4 ? NPH_PLANCK_KNOTS - 4 : first;
    double t = place - first;
    double w[4] = {(t - 1) * (t - 2) * (t - 3) / -6, t * (t - 2) * (t - 3) / 2, t * (t - 1) * (t - 3) / -2,
                   t * (t - 1) * (t - 2) / 6};
    for (int k = 0; k < 3; k++) {
        double sum = 0.0;
        for (int i = 0; i < 4; i++) sum += w[i] * table->log_xyz[first + i][k];
        xyz[k] = nph_exp(sum);
    }
    nph_rgb_from_xyz(xyz, rgb);
    for (int c = 0; c < 3; c++) rgb[c] = rgb[c] > 0.0 ? rgb[c] : 0.0;
}
