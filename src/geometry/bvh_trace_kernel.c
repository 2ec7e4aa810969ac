/* SPDX-License-Identifier: Apache-2.0
 *
 * A loop over rays around both traversals of bvh_lookup.h. */
#include "geometry/bvh_trace_kernel.h"

#include "geometry/bvh_lookup.h"

void NPH_KERNEL(nph_bvh_trace_rays)(const NphBvh *bvh, const NphBvhRays *rays, int64_t begin, int64_t end) {
    const RBvh view = r_bvh(bvh);
    for (int64_t i = begin; i < end; i++) {
        Real in[7];
        RHit hit;
        for (int k = 0; k < 7; k++) in[k] = ((const Real *)rays->ray[k])[i];
        RRay ray = r_ray(in, in + 3);
        if (r_bvh_closest(&view, &ray, in[6], &hit)) {
            ((Real *)rays->t)[i] = hit.t;
            for (int k = 0; k < 2; k++) ((Real *)rays->weight[k])[i] = hit.weight[k];
        }
        rays->number[i] = hit.number;
        rays->any[i] = (unsigned char)r_bvh_any(&view, &ray, in[6]);
    }
}
