/* SPDX-License-Identifier: Apache-2.0
 *
 * Upper bounds of the density over cells of 4^3 of the lattice, and for empty cells how far around them all is empty.
 *
 * A lookup (lookup.h) is r = fl(a + fl(w fl(b - a))), thrice, with a, b >= 0 and 0 <= w <= 1 - e, e = 2^-24 in f32. It
 * never leaves [min(a, b), max(a, b)], so the largest sample bounds it already; the factor 1 + 2^-20 is for what callers
 * do with the result. Proof for a < b (else by symmetry): d = fl(b - a) in [2^k, 2^(k+1)) has the ulp q = 2^k 2 e.
 *   d not a power of two: d <= b - a + q / 2, and w d <= d - d e < d - q / 2, so fl(w d) <= d - q <= b - a - q / 2.
 *   d = 2^k: d <= b - a + q / 4 (spacing is q / 2 below d), and fl(w d) <= d - q / 2 <= b - a - q / 4.
 *   d below 2^-126 is exact and fl(w d) <= d: rounding is monotone.
 * So a + fl(w d) <= b before it is rounded, hence after, and fl(w d) >= 0 gives r >= a. In f64 e is 2^-53. */
#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"
#include "field/grid_build.h"

enum { EDGE = NPH_BRICK_EDGE, BRICKS_PER_BLOCK = 64 };

typedef struct MajorantBuild {
    const NphGrid *grid;
    NphMajorant *majorant;
    float *maxima; /* a brick has 2 x 2 x 2 cells, [z][y][x]: its apron makes them whole */
    float *means;  /* of the trilinear density, likewise */
} MajorantBuild;

static inline float larger(float a, float b) { return a > b ? a : b; }

/* Along each axis samples 0 .. 4 belong to the lower and 4 .. 8 to the upper cell. */
static void brick_maxima(const float *values, float maxima[8]) {
    for (int half_z = 0; half_z < 2; half_z++) {
        float plane[EDGE * EDGE];
        memcpy(plane, values + half_z * 4 * EDGE * EDGE, sizeof plane);
        for (int z = 1; z < 5; z++) {
            const float *next = values + (half_z * 4 + z) * EDGE * EDGE;
            for (int i = 0; i < EDGE * EDGE; i++) plane[i] = larger(next[i], plane[i]);
        }
        for (int half_y = 0; half_y < 2; half_y++) {
            float row[EDGE];
            memcpy(row, plane + half_y * 4 * EDGE, sizeof row);
            for (int y = 1; y < 5; y++)
                for (int x = 0; x < EDGE; x++) row[x] = larger(plane[(half_y * 4 + y) * EDGE + x], row[x]);
            for (int half_x = 0; half_x < 2; half_x++) {
                float most = 0;
                for (int x = 0; x < 5; x++) most = larger(row[half_x * 4 + x], most);
                maxima[half_z * 4 + half_y * 2 + half_x] = most;
            }
        }
    }
}

/* A trilinear density has the mean of the trapezoidal rule; so has, nearly, a nearest one. */
static void brick_means(const float *values, float means[8]) {
    static const double weight[5] = {0.125, 0.25, 0.25, 0.25, 0.125};
    for (int cell = 0; cell < 8; cell++) {
        const float *corner = values + (((cell >> 2) * 4 * EDGE + (cell >> 1 & 1) * 4) * EDGE + (cell & 1) * 4);
        double mean = 0;
        for (int z = 0; z < 5; z++)
            for (int y = 0; y < 5; y++) {
                double row = 0;
                for (int x = 0; x < 5; x++) row += weight[x] * (double)corner[(z * EDGE + y) * EDGE + x];
                mean += weight[z] * weight[y] * row;
            }
        means[cell] = (float)mean;
    }
}

static NphStatus find_maxima(void *data, int64_t block, int worker) {
    (void)worker;
    MajorantBuild *build = data;
    int64_t last = (block + 1) * BRICKS_PER_BLOCK;
    if (last > build->grid->brick_count) last = build->grid->brick_count;
    for (int64_t brick = block * BRICKS_PER_BLOCK; brick < last; brick++) {
        brick_maxima(build->grid->values + brick * NPH_BRICK_STRIDE, build->maxima + 8 * brick);
        brick_means(build->grid->values + brick * NPH_BRICK_STRIDE, build->means + 8 * brick);
    }
    return NPH_OK;
}

/* A layer of cells; empty ones as far from everything as the grid is wide. */
static NphStatus fill_layer(void *data, int64_t z, int worker) {
    (void)worker;
    MajorantBuild *build = data;
    const NphGrid *grid = build->grid;
    const int32_t *n = build->majorant->n;
    float *cell = build->majorant->cells + z * n[1] * n[0];
    float far_away = (float)(n[0] > n[1] ? (n[0] > n[2] ? n[0] : n[2]) : (n[1] > n[2] ? n[1] : n[2]));
    for (int32_t y = 0; y < n[1]; y++) {
        const int32_t *numbers = grid->brick_index + ((z >> 1) * grid->bricks[1] + (y >> 1)) * grid->bricks[0];
        for (int32_t x = 0; x < n[0]; x++) {
            int64_t at = 8 * (int64_t)numbers[x >> 1] + (z & 1) * 4 + (y & 1) * 2 + (x & 1);
            float most = build->maxima[at];
            double part = most > 0 ? (double)build->means[at] / (double)most : 0;
            *cell++ = most > 0 ? nph_majorant_bound(most * (1.0f + 0x1p-20f), part) : -far_away;
        }
    }
    return NPH_OK;
}

/* near[x] becomes the smaller of itself and the distances in a row of cells (0 where a cell is not empty). */
static void nearer(const float *cells, int32_t n, float *near) {
    for (int32_t x = 0; x < n; x++) {
        float distance = cells[x] > 0 ? 0 : -cells[x];
        near[x] = distance < near[x] ? distance : near[x];
    }
}

/* One sweep of the chessboard distance transform [Rosenfeld66] over 13 of a cell's 26
 * neighbours, those that come before it when counting in direction step = +1 or -1; both sweeps together are exact.
 * near: room for n[0] + 2. */
static void sweep(NphMajorant *majorant, int step, float *near) {
    const int32_t *n = majorant->n;
    int64_t slice = (int64_t)n[1] * n[0];
    float far_away = (float)NPH_GRID_SAMPLES_MAX;
    for (int32_t i = 0; i < n[2]; i++)
        for (int32_t j = 0; j < n[1]; j++) {
            int32_t z = step > 0 ? i : n[2] - 1 - i, y = step > 0 ? j : n[1] - 1 - j;
            float *row = majorant->cells + z * slice + (int64_t)y * n[0];
            for (int32_t x = 0; x < n[0] + 2; x++) near[x] = far_away;
            for (int dy = -1; dy <= 1 && i > 0; dy++)
                if (y + dy >= 0 && y + dy < n[1]) nearer(row - step * slice + dy * n[0], n[0], near + 1);
            if (j > 0) nearer(row - step * n[0], n[0], near + 1);
            float before = far_away;
            for (int32_t k = 0; k < n[0]; k++) {
                int32_t x = step > 0 ? k : n[0] - 1 - k;
                float closest = near[x] < near[x + 1] ? near[x] : near[x + 1];
                closest = near[x + 2] < closest ? near[x + 2] : closest;
                closest = (before < closest ? before : closest) + 1;
                if (row[x] <= 0 && closest < -row[x]) row[x] = -closest;
                before = row[x] > 0 ? 0 : -row[x];
            }
        }
}

static NphStatus build_cells(NphContext *context, MajorantBuild *build, const char *what) {
    NphMajorant *majorant = build->majorant;
    int64_t blocks = (build->grid->brick_count + BRICKS_PER_BLOCK - 1) / BRICKS_PER_BLOCK;
    NPH_TRY(nph_pool_run(context, blocks, find_maxima, build, NULL));
    NPH_TRY(nph_pool_run(context, majorant->n[2], fill_layer, build, NULL));
    float *near = NULL;
    NPH_TRY(NPH_NEW(context, majorant->n[0] + 2, what, &near));
    sweep(majorant, 1, near);
    sweep(majorant, -1, near);
    nph_free(context, near);
    return NPH_OK;
}

NphStatus nph_majorant_build(NphContext *context, const NphGrid *grid, const char *what, NphMajorant *majorant) {
    NphMajorant made = {{0, 0, 0}, NULL};
    int64_t cells = 1;
    for (int axis = 0; axis < 3; axis++) {
        made.n[axis] = (grid->n[axis] - 1 + NPH_MAJORANT_CELL - 1) / NPH_MAJORANT_CELL;
        cells *= made.n[axis];
    }
    MajorantBuild build = {.grid = grid, .majorant = &made};
    NPH_TRY(NPH_NEW(context, cells, what, &made.cells));
    NphStatus status = NPH_NEW(context, grid->brick_count * 8, what, &build.maxima);
    if (status == NPH_OK) status = NPH_NEW(context, grid->brick_count * 8, what, &build.means);
    if (status == NPH_OK) status = build_cells(context, &build, what);
    nph_free(context, build.means);
    nph_free(context, build.maxima);
    if (status != NPH_OK) {
        nph_free(context, made.cells);
        return status;
    }
    *majorant = made;
    return NPH_OK;
}
