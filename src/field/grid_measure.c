/* SPDX-License-Identifier: Apache-2.0
 *
 * Totals over the samples of a grid, padding left out: smallest, largest, sum, number of those that are not zero. Each
 * layer of bricks sums into eight lanes (the x within a brick), layers and lanes are folded in rising order: the number
 * of threads does not show.
 */
#include "field/grid_build.h"

#include <math.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"

enum { LANES = NPH_BRICK };

/* Sums in eight lanes (the x within a brick), each a double with the rounding errors kept beside it. */
typedef struct Totals {
    double sum[LANES], error[LANES];
    float min[LANES], max[LANES];
    int64_t active[LANES];
} Totals;

/* The sum's error term is exact [Knuth97 4.2.2 theorem B]. */
static inline void add_row(Totals *totals, const float *row, int begin, int end) {
    for (int x = begin; x < end; x++) {
        float value = row[x];
        double a = totals->sum[x], b = value, sum = a + b, part = sum - a;
        totals->error[x] += (a - (sum - part)) + (b - part);
        totals->sum[x] = sum;
        totals->min[x] = value < totals->min[x] ? value : totals->min[x];
        totals->max[x] = value > totals->max[x] ? value : totals->max[x];
        totals->active[x] += value > 0;
    }
}

typedef struct Measure {
    const NphGrid *grid;
    Totals *layers; /* one a layer of bricks */
} Measure;

/* First and last + 1 sample of a brick that is not padding, within the brick. */
static void interior(int32_t n, int32_t brick, int *begin, int *end) {
    int32_t last = n - 1 - brick * NPH_BRICK;
    *begin = brick == 0 ? 1 : 0;
    *end = last < NPH_BRICK ? last : NPH_BRICK;
}

static void measure_brick(Totals *totals, const NphGrid *grid, const int32_t brick[3], int32_t number) {
    int begin[3], end[3];
    for (int axis = 0; axis < 3; axis++) interior(grid->n[axis], brick[axis], &begin[axis], &end[axis]);
    if (number == 0) { /* zeros change the minimum only */
        for (int x = begin[0]; x < end[0]; x++)
            if (begin[1] < end[1] && begin[2] < end[2]) totals->min[x] = 0;
        return;
    }
    const float *values = grid->values + (int64_t)number * NPH_BRICK_STRIDE;
    for (int z = begin[2]; z < end[2]; z++)
        for (int y = begin[1]; y < end[1]; y++) {
            const float *row = values + z * NPH_BRICK_EDGE * NPH_BRICK_EDGE + y * NPH_BRICK_EDGE;
            if (begin[0] == 0 && end[0] == LANES)
                add_row(totals, row, 0, LANES);
            else
                add_row(totals, row, begin[0], end[0]);
        }
}

static NphStatus measure_layer(void *data, int64_t block, int worker) {
    (void)worker;
    Measure *measure = data;
    const NphGrid *grid = measure->grid;
    Totals totals = {0};
    for (int lane = 0; lane < LANES; lane++) totals.min[lane] = HUGE_VALF;
    int32_t at[3] = {0, 0, (int32_t)block};
    const int32_t *number = grid->brick_index + block * grid->bricks[1] * grid->bricks[0];
    for (at[1] = 0; at[1] < grid->bricks[1]; at[1]++)
        for (at[0] = 0; at[0] < grid->bricks[0]; at[0]++) measure_brick(&totals, grid, at, *number++);
    measure->layers[block] = totals;
    return NPH_OK;
}

NphStatus nph_grid_measure(NphContext *context, const char *what, NphGrid *grid) {
    Measure measure = {.grid = grid};
    NPH_TRY(NPH_NEW(context, grid->bricks[2], what, &measure.layers));
    NphStatus status = nph_pool_run(context, grid->bricks[2], measure_layer, &measure, NULL);
    double sum = 0, error = 0;
    float min = HUGE_VALF, max = 0;
    int64_t active = 0;
    for (int32_t layer = 0; layer < grid->bricks[2]; layer++) {
        const Totals *totals = &measure.layers[layer];
        for (int lane = 0; lane < LANES; lane++) {
            double a = sum, b = totals->sum[lane], part;
            sum = a + b;
            part = sum - a;
            error += (a - (sum - part)) + (b - part) + totals->error[lane];
            min = totals->min[lane] < min ? totals->min[lane] : min;
            max = totals->max[lane] > max ? totals->max[lane] : max;
            active += totals->active[lane];
        }
    }
    nph_free(context, measure.layers);
    if (status != NPH_OK) return status;
    grid->sum = sum + error;
    grid->min = min;
    grid->max = max;
    grid->active = active;
    return NPH_OK;
}
