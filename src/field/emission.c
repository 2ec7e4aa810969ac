/* SPDX-License-Identifier: Apache-2.0
 *
 * Bounds of the emission, over the cells of its grids' majorants, and how much of them a line meets. */
#include "field/emission.h"

#include <string.h>

#include "core/fmath.h"
#include "core/memory.h"
#include "core/message.h"

/* Channel c's bound in a cell; at most 0, minus the cells that may be skipped, where it is empty. */
static double cell_bound(const NphEmission *emission, const NphGrid *density, int c, int64_t cell) {
    double most = (double)nph_emission_grid(emission, density, c)->majorant.cells[cell];
    return most > 0.0 ? most * emission->value[c] : most;
}

static NphStatus build_bound(NphContext *context, const NphGrid *density, const char *what, NphEmission *emission) {
    const NphMajorant *shape = &nph_emission_grid(emission, density, 0)->majorant;
    int64_t cells = (int64_t)shape->n[0] * shape->n[1] * shape->n[2];
    memcpy(emission->bound.n, shape->n, sizeof shape->n);
    NPH_TRY(NPH_NEW(context, cells, what, &emission->bound.cells));
    for (int64_t i = 0; i < cells; i++) {
        double most = 0.0, nearest = -(double)NPH_GRID_SAMPLES_MAX;
        for (int c = 0; c < 3; c++) {
            double bound = cell_bound(emission, density, c, i);
            if (bound > most) most = bound;
            if (bound <= 0.0 && bound > nearest) nearest = bound;
        }
        if (most > NPH_DENSITY_MAX)
            return nph_error(context, NPH_BAD_INPUT, "%s: emits %g W/m3/sr; at most %g", what, most, NPH_DENSITY_MAX);
        /* a channel of value 0 is black where its grid is not: such a cell is alone */
        if (nearest > -1.0) nearest = -1.0;
        emission->bound.cells[i] = (float)(most > 1e-30 ? most * (1.0 + 0x1p-20) : most > 0.0 ? 1e-30 : nearest);
    }
    return NPH_OK;
}

/* Rows along one axis, each with the sum of its bounds. */
static void add_rows(const NphMajorant *bound, int axis, double metres, double *squares, double *sum) {
    int a = (axis + 1) % 3, b = (axis + 2) % 3;
    int64_t stride[3] = {1, bound->n[0], (int64_t)bound->n[0] * bound->n[1]};
    for (int32_t i = 0; i < bound->n[a]; i++)
        for (int32_t j = 0; j < bound->n[b]; j++) {
            double depth = 0.0;
            const float *cell = bound->cells + i * stride[a] + j * stride[b];
            for (int32_t k = 0; k < bound->n[axis]; k++, cell += stride[axis])
                depth += *cell > 0.0f ? (double)*cell * metres : 0.0;
            *squares += depth * depth;
            *sum += depth;
        }
}

NphStatus nph_emission_finish(NphContext *context, const NphGrid *density, const char *what, NphEmission *emission) {
    if (emission->kind != NPH_EMISSION_DENSITY && emission->kind != NPH_EMISSION_GRID) return NPH_OK;
    double squares = 0.0, sum = 0.0;
    NPH_TRY(build_bound(context, density, what, emission));
    for (int axis = 0; axis < 3; axis++) {
        const double *m = emission->world_from_grid + axis;
        double edge = nph_sqrt(m[0] * m[0] + m[4] * m[4] + m[8] * m[8]);
        add_rows(&emission->bound, axis, NPH_MAJORANT_CELL * edge, &squares, &sum);
    }
    emission->depth = sum > 0.0 ? squares / sum : 0.0;
    return NPH_OK;
}

uint64_t nph_emission_bytes(const NphEmission *emission) {
    const int32_t *n = emission->bound.n;
    uint64_t bytes = (uint64_t)n[0] * (uint64_t)n[1] * (uint64_t)n[2] * sizeof *emission->bound.cells;
    for (int i = 0; i < emission->grid_count; i++) bytes += nph_grid_bytes(&emission->grids[i]);
    return bytes;
}

void nph_emission_free(NphContext *context, NphEmission *emission) {
    for (int i = 0; i < emission->grid_count; i++) nph_grid_free(context, &emission->grids[i]);
    nph_free(context, emission->grids);
    nph_free(context, emission->bound.cells);
    memset(emission, 0, sizeof *emission);
}
