/* SPDX-License-Identifier: Apache-2.0
 *
 * The air, as what attenuates light. Its extinction at height h is beta(channel) rho(h), rho = 1 at height 0, so that a
 * way has one number for all channels, its column: the integral of rho along it, metres of air as dense as at height 0.
 * Optical depth: beta times the column.
 *
 * A flat atmosphere, rho = exp(-h / H), has closed forms [Riley04 eq. 11, 12]. A spherical one, exponential or from a
 * profile, is integrated and tabulated over height and direction [Elek12 sec. 4.1.1; Bruneton08]. Refraction is not
 * modelled. Directions count by the sine of their elevation. */
#ifndef NPH_OPTICS_AIR_H
#define NPH_OPTICS_AIR_H

#include "nephos/array.h"

/* Rayleigh scattering of dry air at 288.15 K and 1013.25 hPa, CO2 at 360 ppm [1/m] [Bodhaine99 eq. 29]. 250 to 850 nm. */
double nph_rayleigh_per_m(double wavelength_nm);

/* exp(-per_m column), 0 for an infinite column whatever the extinction: there is the ground. */
double nph_air_transmittance(double per_m, double column_m);

/* ---- flat ---- */

/* Between two points at these heights, distance_m apart. */
double nph_air_column_between(double scale_height_m, double from_m, double to_m, double distance_m);

/* From a height out of the air. Infinite for sine <= 0: a flat atmosphere has no end at the horizon, and below it is
 * ground. */
double nph_air_column_above(double scale_height_m, double height_m, double sine);

/* ---- spherical ---- */

typedef struct NphAirLevel {
    double height_m, density; /* heights rise from 0, densities fall from 1 */
} NphAirLevel;

/* ln rho is linear between levels, and above the last as in the interval below it. */
typedef struct NphAirProfile {
    double radius_m; /* of the ground */
    int count;       /* at least 2 */
    NphAirLevel *levels;
} NphAirProfile;

/* Two levels, whose last ends the table: at 15 scale heights, above which lies 3e-7 of the air. */
NphStatus nph_air_profile_exponential(NphContext *context, double scale_height_m, double radius_m, NphAirProfile *profile);
/* rows as io/air_rows.h gives them. */
NphStatus nph_air_profile_from_rows(NphContext *context, const NphArray *rows, double radius_m, NphAirProfile *profile);
void nph_air_profile_free(NphContext *context, NphAirProfile *profile);

double nph_air_density(const NphAirProfile *profile, double height_m);

/* From a height >= 0 out of the air, by quadrature; infinite where the ground is in the way. Off by less than 1e-12. */
double nph_air_column_curved(const NphAirProfile *profile, double height_m, double sine);

/* ln column at heights from 0 to the last level, evenly spaced, and at sines u^2, u evenly spaced in [0, 1]. */
typedef struct NphAirTable {
    NphAirProfile profile;
    double *log_column; /* [NPH_AIR_HEIGHTS][NPH_AIR_SINES] */
} NphAirTable;

enum { NPH_AIR_HEIGHTS = 121, NPH_AIR_SINES = 65 };

/* Takes the profile over, also when it fails. */
NphStatus nph_air_table_build(NphContext *context, NphAirProfile *profile, NphAirTable *table);
void nph_air_table_free(NphContext *context, NphAirTable *table);

/* As nph_air_column_curved, for heights from 0 to the last level. */
double nph_air_table_column(const NphAirTable *table, double height_m, double sine);

#endif
