/* SPDX-License-Identifier: Apache-2.0
 *
 * Lights as the scene describes them. Directions point from the scene towards the light. Each value has three channels
 * (RGB), or one a wavelength of the scene. */
#ifndef NPH_LIGHT_LIGHT_H
#define NPH_LIGHT_LIGHT_H

#include "nephos/image.h"
#include "optics/sky.h"
#include "optics/wavelengths.h"

typedef enum NphLightKind { NPH_LIGHT_SUN, NPH_LIGHT_CONSTANT, NPH_LIGHT_ENVIRONMENT, NPH_LIGHT_POINT } NphLightKind;

/* A latitude-longitude map, constant over each texel. World z is up: row 0 touches +z. With azimuth phi measured from
 * +x towards +y and rotation r (counterclockwise seen from above), column coordinate in [0, 1):
 * u = frac(1/2 - (phi - r) / 2 pi): the middle of an unrotated image looks along +x, its right half along -y. */
typedef struct NphEnvironment {
    int width, height;
    float *radiance;      /* [row][column][3], W/m2/sr */
    /* Sampling by luminance times solid angle: row cumulative sums (height + 1 values from 0 to 1), per row column
     * cumulative sums (width + 1). A row of no light has a uniform column distribution and row probability 0. */
    double *row_cdf;
    double *column_cdf;
    double total;         /* integral of luminance over the sphere */
} NphEnvironment;

typedef struct NphLight {
    NphLightKind kind;
    char *name;
    double direction[3];     /* sun: unit vector towards it */
    double irradiance[3];    /* sun: on a plane facing it, W/m2 */
    double half_angle_rad;   /* sun: 0 for a delta; else a disc of uniform radiance irradiance / (pi sin^2 half_angle) */
    double radiance[3];      /* constant: W/m2/sr */
    int hemisphere;          /* constant: 0 whole sphere, +1 only directions with z > 0, -1 only z < 0 */
    NphEnvironment map;      /* environment: radiance scaled as the scene says */
    double rotation_rad;     /* environment */
    double position[3];      /* point, m */
    double intensity[3];     /* point, W/sr, the same in all directions */
    double spectrum[NPH_MAX_WAVELENGTHS]; /* where the scene has wavelengths: irradiance, radiance or intensity of each,
                                             per nm; the three above are then its thirds (optics/wavelengths.h) */
} NphLight;

/* Builds the map from an RGB (or single channel Y) image scaled by scale. Negative values are clamped to 0 and counted
 * in a warning; NaN and infinity are refused naming the pixel. An all-black map is valid (total = 0). */
NphStatus nph_environment_build(NphContext *context, const NphImage *image, const double scale[3], const char *what,
                                NphEnvironment *map);
/* From radiances >= 0 [height][width][3]. */
NphStatus nph_environment_of_texels(NphContext *context, int width, int height, const double *texels, NphEnvironment *map);

/* sky_map.c: what the air scatters towards a height, without the sun itself; twice as many columns as rows. */
NphStatus nph_environment_sky(NphContext *context, const NphSky *sky, double height_m, int height, NphEnvironment *map);

/* The same radiance everywhere: a map of one column. Then each row times its factors [height][3], 0 to 1, and the tables
 * anew. */
NphStatus nph_environment_uniform(NphContext *context, int height, const double radiance[3], NphEnvironment *map);
NphStatus nph_environment_scale_rows(NphContext *context, const double *factors, NphEnvironment *map);
void nph_environment_free(NphContext *context, NphEnvironment *map);

#endif
