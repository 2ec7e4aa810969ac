/* SPDX-License-Identifier: Apache-2.0
 *
 * The sky by single scattering [Riley04 sec. 4.1]: how much of a parallel sun the air scatters into a line of sight, of any
 * length (aerial perspective) and direction, seen from any height; what the air lets through of it; the sun's disc.
 *
 * The air has one or two constituents, molecules and aerosol, whose densities fall by height: flat, exp(-h / H), or around
 * a sphere, by the tables of air.h. Line of sight: distance t from the eye along a unit direction, z up. With the column
 * C_i(t) from the eye and X_i(h) towards the sun, ground black and no light but the sun's,
 *     L_c = E_c sum_i s_ic p_i(theta) integral rho_i(t) exp(-sum_j b_jc (C_j(t) + X_j(h(t)))) dt       b extinction, s scattering
 * [Riley04 eq. 14]. Flat and of one scale height it has a closed form (sky.c), which is taken; else it is integrated
 * (sky_quadrature.c). Refraction and light scattered twice are not in it. A flat atmosphere is lit while the sun is above the
 * horizon. */
#ifndef NPH_OPTICS_SKY_H
#define NPH_OPTICS_SKY_H

#include "optics/air.h"
#include "optics/phase.h"

enum { NPH_SKY_MOST = 2 };

typedef struct NphSkyConstituent {
    double extinction_per_m[3], albedo[3]; /* at height 0 */
    double scale_height_m;                 /* 0: the density is that of the table's profile */
    const NphAirTable *table;              /* around a sphere: borrowed; the same radius for all */
    const NphPhase *phase;                 /* borrowed */
} NphSkyConstituent;

typedef struct NphSky {
    int count;            /* 1 or 2 */
    double radius_m;      /* 0: flat */
    NphSkyConstituent of[NPH_SKY_MOST];
    double sun[3];        /* unit vector towards it */
    double irradiance[3]; /* outside the air, on a plane facing the sun */
} NphSky;

/* Where one looks: from a height >= 0 along a unit direction, as far as distance_m, which may be infinite. The line ends at
 * the ground. */
typedef struct NphSkyLine {
    double height_m, direction[3], distance_m;
} NphSkyLine;

/* exp of minus the optical depths along the line: 0 where a line without end meets the ground. */
void nph_sky_transmittance(const NphSky *sky, const NphSkyLine *line, double transmittance[3]);

/* What arrives of the sun at a height, on a plane facing it [W/m2]. */
void nph_sky_sunlight(const NphSky *sky, double height_m, double irradiance[3]);

/* Light scattered along the line towards the eye [W/m2/sr]. */
void nph_sky_scattered(const NphSky *sky, const NphSkyLine *line, double radiance[3]);

/* The same before the phase functions: s times the integral, a row a constituent. Of a flat atmosphere it depends on nothing
 * of the direction but its z. */
void nph_sky_sources(const NphSky *sky, const NphSkyLine *line, double source[NPH_SKY_MOST][3]);
void nph_sky_combine(const NphSky *sky, const double direction[3], double source[NPH_SKY_MOST][3], double radiance[3]);

/* A line split at distance_m: what the air before it adds, what it lets through, and what arrives there from the air behind
 * it: front + through behind is the whole line's [Riley04 sec. 5: the middle of a volume]. Beyond the ground all is ground. */
typedef struct NphSkySplit {
    double front[3], through[3], behind[3];
} NphSkySplit;
void nph_sky_split(const NphSky *sky, const NphSkyLine *line, NphSkySplit *split);

/* The sun's disc [W/m2/sr]: irradiance / (pi sin^2 half_angle) behind the air, within half_angle_rad of the sun; else 0. */
void nph_sky_disc(const NphSky *sky, const NphSkyLine *line, double half_angle_rad, double radiance[3]);

/* [Riley04 eq. 14] without P and I, for albedo 1 and one flat constituent: b times the integral. Rises are the z of the unit
 * vectors along the line and towards the sun. corrected: for any rise; 0 for sun_rise <= 0. paper: eq. 15 to the letter,
 * which lacks exp(-b_eye / (gamma rise)), and overflows as rise falls to 0. */
typedef enum NphSkyVariant { NPH_SKY_CORRECTED, NPH_SKY_PAPER } NphSkyVariant;
double nph_sky_line(NphSkyVariant variant, double per_m, double scale_height_m, double height_m, double rise,
                    double sun_rise, double distance_m);

/* sky_quadrature.c: the integral in metres of every constituent and channel, for any atmosphere; columns along the line.
 * Relative error below 1e-9 flat; what the tables have, 1e-5 of the depths, around a sphere. */
void nph_sky_integrate(const NphSky *sky, const NphSkyLine *line, double metres[NPH_SKY_MOST][3]);
void nph_sky_columns(const NphSky *sky, const NphSkyLine *line, double columns_m[NPH_SKY_MOST]);
/* Columns from a height towards the sun, at cosine sun_rise to the local vertical; infinite behind the ground. */
void nph_sky_columns_above(const NphSky *sky, double height_m, double sun_rise, double columns_m[NPH_SKY_MOST]);
/* Where the line ends: at distance_m, or at the ground. */
double nph_sky_end(const NphSky *sky, const NphSkyLine *line);
/* Height above the ground at a distance along the line. */
double nph_sky_height(const NphSky *sky, const NphSkyLine *line, double distance_m);

#endif
