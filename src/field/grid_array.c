/* SPDX-License-Identifier: Apache-2.0
 *
 * From a dense array to bricks. A row of bricks along x is the unit of work: its 9 x 9 rows of samples, apron and
 * padding included, are converted to float once to learn which bricks are zeros or constant, and once more to fill the
 * others. */
#include <math.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"
#include "field/grid_build.h"
#include "io/half.h"

enum { EDGE = NPH_BRICK_EDGE };

typedef struct ArrayBuild {
    const NphArray *array;
    NphGrid *grid;
    NphOutside outside;
    int64_t width;  /* of a scratch row: 8 bricks[0] + 1 */
    float *scratch; /* EDGE * EDGE rows a worker */
    int32_t shared_end;
} ArrayBuild;

double nph_array_element(const NphArray *array, int64_t i) {
    switch (array->type) {
    case NPH_U8: return ((const uint8_t *)array->data)[i];
    case NPH_I8: return ((const int8_t *)array->data)[i];
    case NPH_U16: return ((const uint16_t *)array->data)[i];
    case NPH_I16: return ((const int16_t *)array->data)[i];
    case NPH_F16: return (double)nph_float_from_half(((const uint16_t *)array->data)[i]);
    case NPH_U32: return ((const uint32_t *)array->data)[i];
    case NPH_I32: return ((const int32_t *)array->data)[i];
    case NPH_F32: return (double)((const float *)array->data)[i];
    case NPH_U64: return (double)((const uint64_t *)array->data)[i];
    case NPH_I64: return (double)((const int64_t *)array->data)[i];
    case NPH_F64: return ((const double *)array->data)[i];
    }
    return NAN;
}

/* -1 for what a grid may not hold; a -0 becomes 0. */
static float density(double value) { return nph_density_ok(value) ? (float)value + 0.0f : -1.0f; }

/* The array's row of nx elements from index i on. */
static void convert_row(const NphArray *array, int64_t i, int64_t nx, float *row) {
    if (array->type == NPH_F32) {
        const float *from = (const float *)array->data + i;
        for (int64_t x = 0; x < nx; x++)
            row[x] = from[x] >= 0 && from[x] <= (float)NPH_DENSITY_MAX ? from[x] + 0.0f : -1.0f;
        return;
    }
    for (int64_t x = 0; x < nx; x++) row[x] = density(nph_array_element(array, i + x));
}

/* Sample s of an axis of n elements to its element; -1 for padding that is zero. */
static int64_t source(int64_t s, int64_t n, NphOutside outside) {
    if (s >= 1 && s <= n) return s - 1;
    return outside == NPH_OUTSIDE_ZERO ? -1 : s < 1 ? 0 : n - 1;
}

/* All samples of a row of bricks; 0 when one of them is bad. Samples beyond the grid's last repeat the padding. */
static int load_rows(const ArrayBuild *build, int64_t block, float *rows) {
    const NphArray *array = build->array;
    int64_t nz = array->shape[0], ny = array->shape[1], nx = array->shape[2];
    int64_t z0 = block / build->grid->bricks[1] * NPH_BRICK, y0 = block % build->grid->bricks[1] * NPH_BRICK;
    float least = 0;
    for (int i = 0; i < EDGE * EDGE; i++) {
        float *row = rows + i * build->width;
        int64_t z = source(z0 + i / EDGE, nz, build->outside), y = source(y0 + i % EDGE, ny, build->outside);
        if (z < 0 || y < 0) {
            memset(row, 0, (size_t)build->width * sizeof *row);
            continue;
        }
        convert_row(array, (z * ny + y) * nx, nx, row + 1);
        row[0] = build->outside == NPH_OUTSIDE_ZERO ? 0 : row[1];
        float last = build->outside == NPH_OUTSIDE_ZERO ? 0 : row[nx];
        for (int64_t x = nx + 1; x < build->width; x++) row[x] = last;
        for (int64_t x = 1; x <= nx; x++) least = row[x] < least ? row[x] : least;
    }
    return least >= 0;
}

static int32_t brick_code(const float *rows, int64_t width) {
    for (int i = 0; i < EDGE * EDGE; i++)
        for (int x = 0; x < EDGE; x++)
            if (rows[i * width + x] != rows[0]) return NPH_BRICK_OWN;
    return nph_brick_code(rows[0]);
}

static NphStatus code_row(void *data, int64_t block, int worker) {
    ArrayBuild *build = data;
    float *rows = build->scratch + (int64_t)worker * EDGE * EDGE * build->width;
    if (!load_rows(build, block, rows)) return NPH_BAD_INPUT;
    int32_t *codes = build->grid->brick_index + block * build->grid->bricks[0];
    for (int32_t brick = 0; brick < build->grid->bricks[0]; brick++)
        codes[brick] = brick_code(rows + (int64_t)brick * NPH_BRICK, build->width);
    return NPH_OK;
}

static NphStatus fill_row(void *data, int64_t block, int worker) {
    ArrayBuild *build = data;
    float *rows = build->scratch + (int64_t)worker * EDGE * EDGE * build->width;
    const int32_t *numbers = build->grid->brick_index + block * build->grid->bricks[0];
    int loaded = 0;
    for (int32_t brick = 0; brick < build->grid->bricks[0]; brick++) {
        if (numbers[brick] < build->shared_end) continue;
        if (!loaded) loaded = load_rows(build, block, rows);
        float *values = build->grid->values + (int64_t)numbers[brick] * NPH_BRICK_STRIDE;
        for (int i = 0; i < EDGE * EDGE; i++)
            for (int x = 0; x < EDGE; x++)
                values[i * EDGE + x] = rows[i * build->width + (int64_t)brick * NPH_BRICK + x];
    }
    return NPH_OK;
}

static NphStatus report_first_bad(NphContext *context, const NphArray *array, const char *what) {
    int64_t count = nph_array_count(array), ny = array->shape[1], nx = array->shape[2];
    for (int64_t i = 0; i < count; i++) {
        double value = nph_array_element(array, i);
        if (nph_density_ok(value)) continue;
        return nph_error(context, NPH_BAD_INPUT,
                         "%s: voxel [z, y, x] = [%lld, %lld, %lld] is %g; densities are finite, not negative and at "
                         "most %g",
                         what, (long long)(i / (nx * ny)), (long long)(i / nx % ny), (long long)(i % nx), value,
                         NPH_DENSITY_MAX);
    }
    return NPH_OK;
}

static NphStatus check_array(NphContext *context, const NphArray *array, NphCentring centring, NphOutside outside,
                             const char *what) {
    if (array->rank != 3)
        return nph_error(context, NPH_BAD_INPUT, "%s: has %d axes; a density has three, [z][y][x]", what, array->rank);
    for (int axis = 0; axis < 3; axis++) {
        int64_t size = array->shape[2 - axis];
        if (size < 1) return nph_error(context, NPH_BAD_INPUT, "%s: has no voxels along %c", what, "xyz"[axis]);
        if (size < 2 && centring != NPH_CENTRING_CELL)
            return nph_error(context, NPH_BAD_INPUT,
                             "%s: one point along %c spans nothing; at least two, or the centring `cell`", what,
                             "xyz"[axis]);
    }
    if (centring == NPH_CENTRING_VDB && outside == NPH_OUTSIDE_CLAMP)
        return nph_error(context, NPH_BAD_USAGE, "%s: the centring vdb falls to zero outside; it cannot clamp", what);
    return NPH_OK;
}

/* Sample s stands at lo + (s - first) h: cells have their first centre half a cell inside, points at lo. */
static NphStatus place(NphContext *context, const double lo[3], const double hi[3], NphCentring centring,
                       const char *what, NphGrid *grid) {
    for (int axis = 0; axis < 3; axis++) {
        double size = hi[axis] - lo[axis], samples = grid->n[axis] - 2;
        if (!isfinite(lo[axis]) || !isfinite(hi[axis]) || !isfinite(size) || !(size > 0))
            return nph_error(context, NPH_BAD_INPUT, "%s: its box from %g to %g along %c is not a finite, rising range",
                             what, lo[axis], hi[axis], "xyz"[axis]);
        double h = centring == NPH_CENTRING_CELL ? size / samples : size / (samples - 1);
        double first = centring == NPH_CENTRING_CELL ? 0.5 : 1.0;
        grid->world_from_lattice[4 * axis + axis] = h;
        grid->world_from_lattice[4 * axis + 3] = lo[axis] - first * h;
    }
    return NPH_OK;
}

static NphStatus build_bricks(NphContext *context, ArrayBuild *build, const char *what) {
    NphGrid *grid = build->grid;
    int64_t blocks = (int64_t)grid->bricks[1] * grid->bricks[2];
    build->width = (int64_t)grid->bricks[0] * NPH_BRICK + 1;
    NPH_TRY(NPH_NEW(context, nph_context_threads(context) * EDGE * EDGE * build->width, what, &build->scratch));
    NphStatus status = nph_pool_run(context, blocks, code_row, build, NULL);
    if (status == NPH_BAD_INPUT) report_first_bad(context, build->array, what);
    NPH_TRY(status);
    NPH_TRY(nph_grid_number(context, what, grid, &build->shared_end));
    return nph_pool_run(context, blocks, fill_row, build, NULL);
}

NphStatus nph_grid_from_array(NphContext *context, const NphArray *array, const double lo[3], const double hi[3],
                              NphCentring centring, NphOutside outside, NphLookup lookup, const char *what,
                              NphGrid *grid) {
    NphGrid made = {.lookup = lookup};
    ArrayBuild build = {.array = array, .grid = &made, .outside = outside};
    NPH_TRY(check_array(context, array, centring, outside, what));
    NphStatus status =
        nph_grid_layout(context, (int64_t[]){array->shape[2], array->shape[1], array->shape[0]}, centring, what, &made);
    if (status == NPH_OK) status = place(context, lo, hi, centring, what, &made);
    if (status == NPH_OK) status = build_bricks(context, &build, what);
    nph_free(context, build.scratch);
    if (status == NPH_OK) status = nph_grid_finish(context, what, &made);
    if (status != NPH_OK) {
        nph_grid_free(context, &made);
        return status;
    }
    *grid = made;
    return NPH_OK;
}
