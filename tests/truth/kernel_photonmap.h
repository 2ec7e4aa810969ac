/* SPDX-License-Identifier: Apache-2.0
 *
 * Inner functions of the photon map in both precisions for the tests. */
#ifndef NPH_TESTS_KERNEL_PHOTONMAP_H
#define NPH_TESTS_KERNEL_PHOTONMAP_H

#include "core/cpu.h"
#include "truth/photonmap/photonmap.h"

/* Photons uniform in the unit cube, of power 1 / count each, into the items of the map's tree. */
NPH_KERNEL_DECLARE(void, photonmap_uniform, (NphPhotonMap * map, uint32_t seed));

/* The estimate at p of an isotropic medium, times 4 pi: power scattered per volume. */
NPH_KERNEL_DECLARE(double, photonmap_estimate,
                   (const NphPhotonMap *map, const double p[3], int nearest, double reach, int printed));

/* Sum of the stored power (channel 0) of photons of scattering order `order`; 0: of all. */
NPH_KERNEL_DECLARE(double, photonmap_power, (const NphPhotonMap *map, int order));

/* Of the prepared scene's first medium: the optical depth per channel extinction over [from, to] of a ray in scene-local
 * space, and by the midpoint rule. */
NPH_KERNEL_DECLARE(double, photonmap_depth, (const void *scene, const double ray[6], double from, double to));
NPH_KERNEL_DECLARE(double, photonmap_depth_sum,
                   (const void *scene, const double ray[6], const double range[2], int steps));

/* Power [W] that the scene's first light, an environment, sends into the box around all media: channel 0, by summing over
 * directions. */
NPH_KERNEL_DECLARE(double, photonmap_sky_power, (const void *scene));

#endif
