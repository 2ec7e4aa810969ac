/* SPDX-License-Identifier: Apache-2.0
 *
 * A grid from a grid: the same lattice, every sample a function of the other's sample and of where it stands. Bricks of
 * zeros stay zeros. The function is called twice for a sample: to learn which bricks are constant, and to fill the
 * others. */
#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"
#include "field/grid_build.h"

enum { EDGE = NPH_BRICK_EDGE };

typedef struct Derivation {
    const NphGrid *from;
    NphGrid *grid;
    NphSampleFn function;
    const void *user;
    int32_t shared_end;
} Derivation;

/* All samples of a brick; 0 when one of them is no density. */
static int derive_brick(const Derivation *derive, int64_t entry, float *values) {
    const NphGrid *from = derive->from;
    const float *source = from->values + (int64_t)from->brick_index[entry] * NPH_BRICK_STRIDE;
    int64_t bx = entry % from->bricks[0], by = entry / from->bricks[0] % from->bricks[1];
    int64_t bz = entry / from->bricks[0] / from->bricks[1];
    int good = 1;
    for (int i = 0; i < NPH_BRICK_SAMPLES; i++) {
        int64_t x = i % EDGE, y = i / EDGE % EDGE, z = i / (EDGE * EDGE);
        double at[3] = {(double)(bx * NPH_BRICK + x), (double)(by * NPH_BRICK + y),
                        (double)(bz * NPH_BRICK + z)};
        double value = derive->function(derive->user, at, (double)source[i]);
        good &= nph_density_ok(value);
        values[i] = (float)value;
    }
    return good;
}

static NphStatus code_row(void *data, int64_t row, int worker) {
    (void)worker;
    Derivation *derive = data;
    float values[NPH_BRICK_SAMPLES];
    int32_t across = derive->from->bricks[0];
    for (int64_t entry = row * across; entry < (row + 1) * across; entry++) {
        if (derive->from->brick_index[entry] == 0) continue;
        if (!derive_brick(derive, entry, values)) return NPH_BAD_INPUT;
        int same = 1;
        for (int i = 1; i < NPH_BRICK_SAMPLES; i++) same &= values[i] == values[0];
        derive->grid->brick_index[entry] = same ? nph_brick_code(values[0] + 0.0f) : NPH_BRICK_OWN;
    }
    return NPH_OK;
}

static NphStatus fill_row(void *data, int64_t row, int worker) {
    (void)worker;
    Derivation *derive = data;
    int32_t across = derive->from->bricks[0];
    for (int64_t entry = row * across; entry < (row + 1) * across; entry++) {
        int32_t number = derive->grid->brick_index[entry];
        if (number >= derive->shared_end) derive_brick(derive, entry, derive->grid->values + (int64_t)number * NPH_BRICK_STRIDE);
    }
    return NPH_OK;
}

static NphStatus build(NphContext *context, Derivation *derive, const char *what) {
    NphGrid *grid = derive->grid;
    int64_t rows = (int64_t)grid->bricks[1] * grid->bricks[2];
    NPH_TRY(NPH_NEW(context, rows * grid->bricks[0], what, &grid->brick_index));
    NphStatus status = nph_pool_run(context, rows, code_row, derive, NULL);
    if (status == NPH_BAD_INPUT)
        return nph_error(context, status, "%s: a value that follows from it is not finite, negative or above %g", what,
                         NPH_DENSITY_MAX);
    if (status != NPH_OK) return status;
    NPH_TRY(nph_grid_number(context, what, grid, &derive->shared_end));
    NPH_TRY(nph_pool_run(context, rows, fill_row, derive, NULL));
    return nph_grid_finish(context, what, grid);
}

NphStatus nph_grid_derive(NphContext *context, const NphGrid *from, NphSampleFn function, const void *user,
                          const char *what, NphGrid *grid) {
    NphGrid made = *from;
    made.brick_index = NULL;
    made.values = NULL;
    made.majorant.cells = NULL;
    Derivation derive = {.from = from, .grid = &made, .function = function, .user = user};
    NphStatus status = build(context, &derive, what);
    if (status != NPH_OK) {
        nph_grid_free(context, &made);
        return status;
    }
    *grid = made;
    return NPH_OK;
}
