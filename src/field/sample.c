/* SPDX-License-Identifier: Apache-2.0
 *
 * Hands blocks of positions to the kernel's build for this machine. */
#include "field/sample.h"

#include "core/message.h"
#include "core/pool.h"
#include "field/grid_sample_kernel.h"

enum { POSITIONS_PER_BLOCK = 4096 };

void nph_grid_view(const NphGrid *grid, RGrid *view) {
    uint32_t bias = grid->brick_count * NPH_BRICK_STRIDE > INT32_MAX ? (uint32_t)1 << 31 : 0;
    *view = (RGrid){.brick_index = grid->brick_index,
                    .values = grid->values + bias,
                    .bias = bias,
                    .shift = grid->lookup == NPH_LOOKUP_NEAREST ? 0.5f : 0.0f,
                    .weight = grid->lookup == NPH_LOOKUP_NEAREST ? 0.0f : 1.0f};
    for (int axis = 0; axis < 3; axis++) {
        view->n[axis] = grid->n[axis];
        view->bricks[axis] = grid->bricks[axis];
    }
}

typedef struct Sampling {
    GridSample whole;
    const void *const *positions;
    void *out;
    int64_t size; /* of a coordinate */
    void (*kernel)(const GridSample *, const void *, const void *, const void *, void *);
} Sampling;

static NphStatus sample_block(void *data, int64_t block, int worker) {
    (void)worker;
    const Sampling *sampling = data;
    GridSample part = sampling->whole;
    int64_t begin = block * POSITIONS_PER_BLOCK, left = part.count - begin, skip = begin * sampling->size;
    const char *u = sampling->positions[0], *v = sampling->positions[1], *w = sampling->positions[2];
    part.count = left < POSITIONS_PER_BLOCK ? left : POSITIONS_PER_BLOCK;
    sampling->kernel(&part, u + skip, v + skip, w + skip, (char *)sampling->out + skip);
    return NPH_OK;
}

NphStatus nph_grid_sample(NphContext *context, const NphGrid *grid, int precision, int64_t count,
                          const void *const positions[3], void *out) {
    if (precision != 32 && precision != 64)
        return nph_error(context, NPH_BAD_USAGE, "precision %d is neither 32 nor 64", precision);
    Sampling sampling = {.whole = {.count = count}, .positions = positions, .out = out, .size = precision / 8};
    nph_grid_view(grid, &sampling.whole.grid);
    for (int axis = 0; axis < 3; axis++) {
        sampling.whole.lo[axis] = grid->lo[axis];
        sampling.whole.hi[axis] = grid->hi[axis];
    }
    NPH_KERNEL_PICK(sampling.kernel, nph_grid_sample, nph_context_isa(context), precision);
    int64_t blocks = (count + POSITIONS_PER_BLOCK - 1) / POSITIONS_PER_BLOCK;
    return nph_pool_run(context, blocks, sample_block, &sampling, NULL);
}
