/* SPDX-License-Identifier: Apache-2.0
 *
 * Extinction of air, and columns of a flat exponential atmosphere in closed form. */
#include "optics/air.h"

#include "core/fmath.h"

/* Molecules of air at 288.15 K and 1013.25 hPa [1/m3], and the fit's cross-section [1e-28 cm2] of one [Bodhaine99]. */
static const double MOLECULES = 2.546899e25, CROSS_SECTION_M2 = 1e-32;

double nph_rayleigh_per_m(double wavelength_nm) {
    double um = wavelength_nm * 1e-3, squared = um * um;
    double over = 1.0455996 - 341.29061 / squared - 0.90230850 * squared;
    double under = 1.0 + 0.0027059889 / squared - 85.968563 * squared;
    return MOLECULES * CROSS_SECTION_M2 * over / under;
}

double nph_air_transmittance(double per_m, double column_m) {
    return column_m < nph_infinity() ? nph_exp(-per_m * column_m) : 0.0;
}

/* The integral of exp(-h / H) over a way whose height changes by H x, from its lower end:
 *   distance exp(-low / H) (1 - e^-x) / x
 * Counted from the lower end x >= 0 and nothing overflows; expm1 keeps all digits of the quotient for any x but 0, where
 * it is 0 / 0 and 1 in the limit: a level way. */
double nph_air_column_between(double scale_height_m, double from_m, double to_m, double distance_m) {
    double low = from_m < to_m ? from_m : to_m, high = from_m < to_m ? to_m : from_m;
    double x = (high - low) / scale_height_m;
    double mean = x > 0.0 ? -nph_expm1(-x) / x : 1.0;
    return distance_m * nph_exp(-low / scale_height_m) * mean;
}

double nph_air_column_above(double scale_height_m, double height_m, double sine) {
    return sine > 0.0 ? scale_height_m * nph_exp(-height_m / scale_height_m) / sine : nph_infinity();
}
