/* SPDX-License-Identifier: Apache-2.0
 *
 * How large particles are: number densities over the radius, at any scale.
 *   single          one radius
 *   lognormal       exp(-ln^2(r / radius) / (2 ln^2 spread)) / r: radius is the median, spread > 1 the geometric standard deviation
 *   gamma           r^(1/v - 3) exp(-r / (v radius)): radius is the effective one, v = spread < 1/2 the effective variance
 *                   [Hansen74 eq. 2.56]
 *   modified_gamma  r^alpha exp(-alpha / gamma (r / radius)^gamma): radius is where it is largest [Deirmendjian69] */
#ifndef NPH_OPTICS_SIZES_H
#define NPH_OPTICS_SIZES_H

typedef enum NphSizesKind { NPH_SIZES_SINGLE, NPH_SIZES_LOGNORMAL, NPH_SIZES_GAMMA, NPH_SIZES_MODIFIED_GAMMA } NphSizesKind;

#define NPH_SIZES_WORDS "single|lognormal|gamma|modified_gamma"
#define NPH_SIZES_LEAST_UM 1e-6
#define NPH_SIZES_MOST_UM 1e6
#define NPH_SIZES_MOST_LOGNORMAL 5.0
#define NPH_SIZES_LEAST_GAMMA 1e-4 /* of spread */
#define NPH_SIZES_MOST_GAMMA 0.49

typedef struct NphSizes {
    NphSizesKind kind;
    double radius_um, spread;
    double alpha, gamma; /* of modified_gamma */
} NphSizes;

/* NULL, or what is out of its range, as a message tells it. */
const char *nph_sizes_mistake(const NphSizes *sizes);

/* ln of the number density over ln r, up to a constant, at ln r; not of single. */
double nph_sizes_log_density(const NphSizes *sizes, double log_um);

/* Radii outside of which r^2 times the number density over ln r (below) and r^6 times it (above) are less than `least` of their
 * largest: cross sections of spheres rise as the square of the radius, those of small ones as its sixth power. */
void nph_sizes_range(const NphSizes *sizes, double least, double range_um[2]);

#endif
