/* SPDX-License-Identifier: Apache-2.0
 *
 * A lattice as a dense array [z][y][x] of its samples, padding included, and the majorants of such an array: by way of bricks, so
 * that they are made in one place (majorant.c). */
#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"
#include "field/grid_build.h"

enum { EDGE = NPH_BRICK_EDGE };

typedef struct Dense {
    NphGrid grid;
    const float *samples;
} Dense;

int64_t nph_grid_dense_count(const NphGrid *grid) { return (int64_t)grid->n[0] * grid->n[1] * grid->n[2]; }

void nph_grid_dense(const NphGrid *grid, float *samples) {
    for (int32_t z = 0; z < grid->n[2]; z++)
        for (int32_t y = 0; y < grid->n[1]; y++) {
            const int32_t *numbers = grid->brick_index + ((int64_t)(z >> 3) * grid->bricks[1] + (y >> 3)) * grid->bricks[0];
            int32_t row = (z & 7) * EDGE * EDGE + (y & 7) * EDGE;
            for (int32_t x = 0; x < grid->n[0]; x++)
                *samples++ = grid->values[(int64_t)numbers[x >> 3] * NPH_BRICK_STRIDE + row + (x & 7)];
        }
}

static int64_t within(int64_t i, int32_t n) { return i < n ? i : n - 1; }

/* A row of bricks along x, each of its own, numbers from 1 on. Samples beyond the lattice repeat its last ones, as builders have it. */
static NphStatus fill_row(void *data, int64_t row, int worker) {
    (void)worker;
    Dense *dense = data;
    NphGrid *grid = &dense->grid;
    int64_t z0 = row / grid->bricks[1] * NPH_BRICK, y0 = row % grid->bricks[1] * NPH_BRICK;
    for (int32_t brick = 0; brick < grid->bricks[0]; brick++) {
        int64_t number = row * grid->bricks[0] + brick + 1;
        float *value = grid->values + number * NPH_BRICK_STRIDE;
        grid->brick_index[number - 1] = (int32_t)number;
        for (int i = 0; i < EDGE * EDGE; i++) {
            int64_t z = within(z0 + i / EDGE, grid->n[2]), y = within(y0 + i % EDGE, grid->n[1]);
            const float *from = dense->samples + (z * grid->n[1] + y) * grid->n[0];
            for (int x = 0; x < EDGE; x++) *value++ = from[within((int64_t)brick * NPH_BRICK + x, grid->n[0])];
        }
    }
    return NPH_OK;
}

static NphStatus fill_bricks(NphContext *context, Dense *dense, const char *what) {
    NphGrid *grid = &dense->grid;
    int64_t rows = (int64_t)grid->bricks[1] * grid->bricks[2];
    grid->brick_count = rows * grid->bricks[0] + 1;
    if (grid->brick_count > NPH_GRID_BRICKS_MAX)
        return nph_error(context, NPH_BAD_INPUT, "%s: %lld bricks of 8^3 samples are too many; at most %d", what,
                         (long long)grid->brick_count, NPH_GRID_BRICKS_MAX);
    NPH_TRY(NPH_NEW(context, rows * grid->bricks[0], what, &grid->brick_index));
    NPH_TRY(NPH_NEW(context, grid->brick_count * NPH_BRICK_STRIDE, what, &grid->values));
    return nph_pool_run(context, rows, fill_row, dense, NULL);
}

NphStatus nph_majorant_of_samples(NphContext *context, const int32_t n[3], const float *samples, const char *what,
                                  NphMajorant *majorant) {
    Dense dense = {.samples = samples};
    for (int a = 0; a < 3; a++) {
        dense.grid.n[a] = n[a];
        dense.grid.bricks[a] = (n[a] + NPH_BRICK - 1) / NPH_BRICK;
    }
    NphStatus status = fill_bricks(context, &dense, what);
    if (status == NPH_OK) status = nph_majorant_build(context, &dense.grid, what, majorant);
    nph_grid_free(context, &dense.grid);
    return status;
}
