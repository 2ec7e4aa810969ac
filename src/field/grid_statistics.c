/* SPDX-License-Identifier: Apache-2.0
 *
 * Means and optical depths of a grid, as `nephos info` prints them. A line through samples sees the interpolant as a
 * sum of hats (trilinear) or boxes (nearest) of one lattice unit, so its exact integral over the grid's box is the sum
 * of the samples times how much of their hat lies inside. Each column of bricks is folded alone, then all in rising
 * order. */
#include <math.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"
#include "field/grid.h"

typedef struct Lines {
    double sum, max;
} Lines;

typedef struct Depth {
    const NphGrid *grid;
    int axis[3];     /* along the lines; across them: the faster and the slower one */
    double *weights; /* of the samples along the lines, lattice units; for whole bricks */
    Lines *columns;  /* one a column of bricks */
} Depth;

/* Integral from its lower end to t of the hat 1 - |t| or of the box |t| < 1/2. */
static double hat_below(double t, NphLookup lookup) {
    if (lookup == NPH_LOOKUP_NEAREST) return t < -0.5 ? 0 : t > 0.5 ? 1 : t + 0.5;
    if (t <= 0) return t < -1 ? 0 : 0.5 * (1 + t) * (1 + t);
    return t > 1 ? 1 : 1 - 0.5 * (1 - t) * (1 - t);
}

static void add_brick(const Depth *depth, const float *values, const double *weights, double lines[64]) {
    static const int strides[3] = {1, NPH_BRICK_EDGE, NPH_BRICK_EDGE * NPH_BRICK_EDGE};
    int along = strides[depth->axis[0]], faster = strides[depth->axis[1]], slower = strides[depth->axis[2]];
    for (int j = 0; j < NPH_BRICK; j++)
        for (int i = 0; i < NPH_BRICK; i++) {
            const float *line = values + j * slower + i * faster;
            double sum = 0;
            for (int k = 0; k < NPH_BRICK; k++) sum += weights[k] * (double)line[k * along];
            lines[8 * j + i] += sum;
        }
}

static NphStatus add_column(void *data, int64_t block, int worker) {
    (void)worker;
    Depth *depth = data;
    const NphGrid *grid = depth->grid;
    const int *axis = depth->axis;
    int32_t at[3];
    at[axis[1]] = (int32_t)(block % grid->bricks[axis[1]]);
    at[axis[2]] = (int32_t)(block / grid->bricks[axis[1]]);
    double lines[64] = {0};
    for (at[axis[0]] = 0; at[axis[0]] < grid->bricks[axis[0]]; at[axis[0]]++) {
        int32_t number = grid->brick_index[((int64_t)at[2] * grid->bricks[1] + at[1]) * grid->bricks[0] + at[0]];
        if (number != 0)
            add_brick(depth, grid->values + (int64_t)number * NPH_BRICK_STRIDE,
                      depth->weights + (int64_t)at[axis[0]] * NPH_BRICK, lines);
    }
    Lines column = {0, 0};
    for (int j = 0; j < NPH_BRICK; j++)
        for (int i = 0; i < NPH_BRICK; i++) {
            int32_t faster = at[axis[1]] * NPH_BRICK + i, slower = at[axis[2]] * NPH_BRICK + j;
            if (faster < 1 || faster > grid->n[axis[1]] - 2 || slower < 1 || slower > grid->n[axis[2]] - 2) continue;
            column.sum += lines[8 * j + i];
            column.max = lines[8 * j + i] > column.max ? lines[8 * j + i] : column.max;
        }
    depth->columns[block] = column;
    return NPH_OK;
}

static NphStatus axis_depth(NphContext *context, const NphGrid *grid, int along, double *mean, double *max) {
    Depth depth = {.grid = grid, .axis = {along, along == 0 ? 1 : 0, along == 2 ? 1 : 2}};
    const int *axis = depth.axis;
    int64_t columns = (int64_t)grid->bricks[axis[1]] * grid->bricks[axis[2]];
    NPH_TRY(NPH_NEW(context, (int64_t)grid->bricks[along] * NPH_BRICK, "weights of a grid", &depth.weights));
    NphStatus status = NPH_NEW(context, columns, "optical depths of a grid", &depth.columns);
    if (status == NPH_OK) {
        for (int32_t i = 0; i < grid->n[along]; i++)
            depth.weights[i] =
                hat_below(grid->hi[along] - i, grid->lookup) - hat_below(grid->lo[along] - i, grid->lookup);
        status = nph_pool_run(context, columns, add_column, &depth, NULL);
    }
    if (status == NPH_OK) {
        const double *m = grid->world_from_lattice + along;
        double unit = sqrt(m[0] * m[0] + m[4] * m[4] + m[8] * m[8]), sum = 0, most = 0;
        for (int64_t i = 0; i < columns; i++) {
            sum += depth.columns[i].sum;
            most = depth.columns[i].max > most ? depth.columns[i].max : most;
        }
        *mean = unit * sum / ((double)(grid->n[axis[1]] - 2) * (double)(grid->n[axis[2]] - 2));
        *max = unit * most;
    }
    nph_free(context, depth.weights);
    nph_free(context, depth.columns);
    return status;
}

NphStatus nph_grid_statistics(NphContext *context, const NphGrid *grid, NphGridStatistics *statistics) {
    NphGridStatistics made = {0};
    double samples = 1;
    for (int axis = 0; axis < 3; axis++) {
        samples *= grid->n[axis] - 2;
        NPH_TRY(axis_depth(context, grid, axis, &made.axis_depth_mean[axis], &made.axis_depth_max[axis]));
    }
    made.mean = grid->sum / samples;
    made.mean_active = grid->active > 0 ? grid->sum / (double)grid->active : 0;
    *statistics = made;
    return NPH_OK;
}
