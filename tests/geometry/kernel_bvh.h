/* SPDX-License-Identifier: Apache-2.0
 *
 * The inline functions of geometry/ in both precisions for the tests; arguments and results are doubles in either. */
#ifndef NPH_TESTS_KERNEL_BVH_H
#define NPH_TESTS_KERNEL_BVH_H

#include "core/cpu.h"
#include "geometry/bvh.h"

/* What nph_bvh_trace says, by testing every triangle. */
NPH_KERNEL_DECLARE(void, geometry_brute, (const NphBvh *bvh, const NphBvhRays *rays));

/* Rays leave random points of random triangles, cosine distributed or (grazing > 0) with a cosine below grazing, on
 * both sides: how many meet the triangle they left. share scales the clearance. */
NPH_KERNEL_DECLARE(int64_t, geometry_self_hits,
                   (const NphBvh *bvh, uint32_t seed, int64_t count, double grazing, double share));

/* From inside a closed mesh: paths of count reflections at the walls, each by the rule for rays that leave a surface;
 * how many rays met nothing. */
NPH_KERNEL_DECLARE(int64_t, geometry_escapes,
                   (const NphBvh *bvh, const double start[3], uint32_t seed, int64_t paths, int64_t count));

/* Chords of a convex body from uniform points of its surface, inwards with density cos / pi. cdf: of the areas by
 * number of triangle, rising to 1. out: their number that met a wall, sum and sum of squares of their lengths. */
NPH_KERNEL_DECLARE(void, geometry_chords,
                   (const NphBvh *bvh, const double *cdf, uint32_t seed, int64_t count, double out[3]));

/* Directions about a normal, and their densities. */
NPH_KERNEL_DECLARE(void, geometry_lambert,
                   (const double n[3], uint32_t seed, int64_t count, double *direction, double *density));

/* A ray and a plane: t or -1; then rays that leave the point: how many of count meet the plane again. */
NPH_KERNEL_DECLARE(double, geometry_plane, (const double plane[6], const double ray[6], double t_max));
NPH_KERNEL_DECLARE(int64_t, geometry_plane_self_hits,
                   (const double plane[6], const double ray[6], uint32_t seed, int64_t count));

/* p[3], n[3], clear of a hit. */
NPH_KERNEL_DECLARE(void, geometry_point, (const NphBvh *bvh, int32_t slot, const double weight[2], double out[7]));

#endif
