/* SPDX-License-Identifier: Apache-2.0
 *
 * The radiance of a black body: Planck's law, its colour for the standard observer, and a table of it for many
 * temperatures.  B(lambda, T) = 2 h c^2 / lambda^5 / (exp(h c / (lambda k T)) - 1)   [Planck01]
 * Everything in W/m2/sr/nm: RGB and XYZ are means over the spectrum, weighted by the observer (cie.h). */
#ifndef NPH_OPTICS_BLACKBODY_H
#define NPH_OPTICS_BLACKBODY_H

/* Below 100 K nothing that is visible is left (B of 780 nm is 1e-72): 0. Above: refused where scenes are read. */
#define NPH_KELVIN_LEAST 100.0
#define NPH_KELVIN_MOST 100000.0

double nph_planck(double wavelength_nm, double kelvin);

void nph_planck_xyz(double kelvin, double xyz[3]);

/* A third-order interpolation of ln XYZ in ln T, which Wien's law makes almost straight; within 1e-7 of nph_planck_xyz. */
enum { NPH_PLANCK_KNOTS = 1024 };
typedef struct NphPlanckTable {
    double log_xyz[NPH_PLANCK_KNOTS][3];
} NphPlanckTable;

void nph_planck_table(NphPlanckTable *table);

/* Linear Rec. 709. Below about 1900 K the colour lies outside Rec. 709 and its blue would be negative: it is 0. 0 below
 * NPH_KELVIN_LEAST; as at NPH_KELVIN_MOST above it. */
void nph_planck_rgb(const NphPlanckTable *table, double kelvin, double rgb[3]);

#endif
