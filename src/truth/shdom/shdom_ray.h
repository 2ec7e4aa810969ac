/* SPDX-License-Identifier: Apache-2.0
 *
 * A ray of a camera, or one of many of a sensor that gathers, on its way through the solution. */
#ifndef NPH_TRUTH_SHDOM_RAY_H
#define NPH_TRUTH_SHDOM_RAY_H

#include "truth/shdom/shdom.h"
#include "truth/single/single_quadrature.h"

typedef struct NphShdomRay {
    const NphShdomCamera *camera;
    const NphShdomRoom *room;
    double p[3], d[3], start;     /* start: metres from the sensor to p */
    double u[3], w[3];            /* p and a metre along d in the grid's space */
    double grid[3];               /* light that the grid sends: radiance by channel of the solution */
    double once[3];               /* scattered once, by quadrature: of the film's channels */
    double passes[3], true_passes[3]; /* transmittance with what delta-M leaves of the extinction, and with all of it */
    double distance;              /* sums of first collisions, of all channels */
} NphShdomRay;

/* room->look holds the harmonics of the ray from then on. */
void nph_shdom_ray_begin(const NphShdomCamera *camera, const NphShdomRoom *room, const double p[3], const double d[3], NphShdomRay *ray);
/* cut: single scattering by the phase function as it was solved, as fluxes need it; 0: by the whole one. */
void nph_shdom_ray_follow(NphShdomRay *ray, const RCameraRay *camera_ray, const NphSingleAsk *ask, int cut);
double nph_shdom_ray_channel(const NphShdomRay *ray, const double value[3], int c);
void nph_shdom_ray_spread(const NphShdomRay *ray, double light[3]);
void nph_shdom_ray_add(const NphShdomCamera *camera, const double light[3], int order, double fields[NPH_SAMPLE_FIELDS]);

#endif
