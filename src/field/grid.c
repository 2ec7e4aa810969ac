/* SPDX-License-Identifier: Apache-2.0
 *
 * A grid's first and last step (grid_build.h): the limits and the box of its lattice, and what is checked and derived
 * once its values stand. */
#include "field/grid.h"

#include <math.h>

#include "core/memory.h"
#include "core/message.h"
#include "field/grid_build.h"

void nph_grid_free(NphContext *context, NphGrid *grid) {
    nph_free(context, grid->brick_index);
    nph_free(context, grid->values);
    nph_free(context, grid->majorant.cells);
    memset(grid, 0, sizeof *grid);
}

static int64_t product3(const int32_t n[3]) { return (int64_t)n[0] * n[1] * n[2]; }

uint64_t nph_grid_bytes(const NphGrid *grid) {
    uint64_t bytes = (uint64_t)product3(grid->bricks) * sizeof *grid->brick_index;
    bytes += (uint64_t)grid->brick_count * NPH_BRICK_STRIDE * sizeof *grid->values;
    return bytes + (uint64_t)product3(grid->majorant.n) * sizeof *grid->majorant.cells;
}

NphStatus nph_grid_layout(NphContext *context, const int64_t samples[3], NphCentring centring, const char *what,
                          NphGrid *grid) {
    double cells = 1;
    for (int axis = 0; axis < 3; axis++) {
        int64_t n = samples[axis] + 2;
        if (n > NPH_GRID_SAMPLES_MAX)
            return nph_error(context, NPH_BAD_INPUT, "%s: %lld voxels along %c are too many; at most %d", what,
                             (long long)samples[axis], "xyz"[axis], NPH_GRID_SAMPLES_MAX - 2);
        double inset = centring == NPH_CENTRING_CELL ? 0.5 : centring == NPH_CENTRING_POINT ? 1.0 : 0.0;
        grid->n[axis] = (int32_t)n;
        grid->bricks[axis] = (int32_t)((n + NPH_BRICK - 1) / NPH_BRICK);
        grid->lo[axis] = inset;
        grid->hi[axis] = (double)(n - 1) - inset;
        int64_t row = (n - 1 + NPH_MAJORANT_CELL - 1) / NPH_MAJORANT_CELL;
        cells *= (double)row;
    }
    if (cells > NPH_GRID_CELLS_MAX)
        return nph_error(context, NPH_BAD_INPUT,
                         "%s: a box of %lld x %lld x %lld voxels is too large: its bounds would take %.0f cells of 4^3 "
                         "voxels; at most %d",
                         what, (long long)samples[0], (long long)samples[1], (long long)samples[2], cells,
                         NPH_GRID_CELLS_MAX);
    return NPH_NEW(context, product3(grid->bricks), what, &grid->brick_index);
}

static double determinant(const double m[12]) {
    return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
           m[2] * (m[4] * m[9] - m[5] * m[8]);
}

NphStatus nph_grid_finish(NphContext *context, const char *what, NphGrid *grid) {
    const double *m = grid->world_from_lattice;
    for (int i = 0; i < 12; i++)
        if (!isfinite(m[i]))
            return nph_error(context, NPH_BAD_INPUT, "%s: its transform is not finite (row %d, column %d)", what, i / 4,
                             i % 4);
    double volume = determinant(m);
    if (volume == 0 || !isfinite(volume))
        return nph_error(context, NPH_BAD_INPUT, "%s: its transform is singular: a voxel has the volume %g", what,
                         volume);
    NPH_TRY(nph_grid_measure(context, what, grid));
    return nph_majorant_build(context, grid, what, &grid->majorant);
}
