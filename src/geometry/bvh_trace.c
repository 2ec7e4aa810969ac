/* SPDX-License-Identifier: Apache-2.0
 *
 * Hands blocks of rays to the kernel. */
#include "core/message.h"
#include "core/pool.h"
#include "geometry/bvh_trace_kernel.h"

enum { RAYS_PER_BLOCK = 1024 };

typedef struct Tracing {
    const NphBvh *bvh;
    const NphBvhRays *rays;
} Tracing;

static NphStatus trace_block(void *data, int64_t block, int worker) {
    (void)worker;
    const Tracing *tracing = data;
    const NphBvhRays *rays = tracing->rays;
    int64_t begin = block * RAYS_PER_BLOCK,
            end = begin + RAYS_PER_BLOCK < rays->count ? begin + RAYS_PER_BLOCK : rays->count;
    (rays->precision == 32 ? nph_bvh_trace_rays_f32_base : nph_bvh_trace_rays_f64_base)(tracing->bvh, rays, begin, end);
    return NPH_OK;
}

NphStatus nph_bvh_trace(NphContext *context, const NphBvh *bvh, const NphBvhRays *rays) {
    if (rays->precision != 32 && rays->precision != 64)
        return nph_error(context, NPH_BAD_USAGE, "precision %d is neither 32 nor 64", rays->precision);
    Tracing tracing = {bvh, rays};
    return nph_pool_run(context, (rays->count + RAYS_PER_BLOCK - 1) / RAYS_PER_BLOCK, trace_block, &tracing, NULL);
}
