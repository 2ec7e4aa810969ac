/* SPDX-License-Identifier: Apache-2.0
 *
 * Between bvh_trace.c and the builds of its kernel: scalar, so one per precision. */
#ifndef NPH_GEOMETRY_BVH_TRACE_KERNEL_H
#define NPH_GEOMETRY_BVH_TRACE_KERNEL_H

#include "geometry/bvh.h"

/* Rays [begin, end). */
void nph_bvh_trace_rays_f32_base(const NphBvh *bvh, const NphBvhRays *rays, int64_t begin, int64_t end);
void nph_bvh_trace_rays_f64_base(const NphBvh *bvh, const NphBvhRays *rays, int64_t begin, int64_t end);

#endif
