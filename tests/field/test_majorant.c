/* SPDX-License-Identifier: Apache-2.0
 *
 * Bounds of the density: exact and tight against a search over all samples, distances of empty cells against a search
 * over all cells, and no lookup above its bound, in either precision, at positions and densities chosen to break it. */
#include <float.h>

#include "core/memory.h"
#include "field_fixtures.h"

enum { POSITIONS = 1 << 15 };

static NphGrid build(NphContext *context, const NphArray *array, NphOutside outside, NphLookup lookup) {
    NphGrid grid;
    NphStatus status = nph_grid_from_array(context, array, (double[]){0, 0, 0}, (double[]){1, 1, 1}, NPH_CENTRING_CELL,
                                           outside, lookup, "array", &grid);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    return grid;
}

static float cell_at(const NphMajorant *majorant, int x, int y, int z) {
    return majorant->cells[((int64_t)z * majorant->n[1] + y) * majorant->n[0] + x];
}

/* Largest of the samples 4 c .. 4 c + 4. */
static float largest(const NphGrid *grid, int cx, int cy, int cz) {
    float most = 0;
    for (int k = 4 * cz; k <= 4 * cz + 4 && k < grid->n[2]; k++)
        for (int j = 4 * cy; j <= 4 * cy + 4 && j < grid->n[1]; j++)
            for (int i = 4 * cx; i <= 4 * cx + 4 && i < grid->n[0]; i++)
                most = field_sample(grid, i, j, k) > most ? field_sample(grid, i, j, k) : most;
    return most;
}

/* The mean of a trilinear density over a cell is that of its voxels' corners. */
static double mean_of(const NphGrid *grid, int cx, int cy, int cz) {
    double sum = 0;
    for (int k = 0; k < 4; k++)
        for (int j = 0; j < 4; j++)
            for (int i = 0; i < 4; i++)
                for (int corner = 0; corner < 8; corner++)
                    sum += (double)field_sample(grid, 4 * cx + i + (corner & 1), 4 * cy + j + (corner >> 1 & 1),
                                                4 * cz + k + (corner >> 2));
    return sum / (8 * 64);
}

/* A bound is at most 2^-18 above its sample, and tells the mean of a whole cell to a 32nd of itself. */
static int bound_is_wrong(const NphGrid *grid, int x, int y, int z, float bound) {
    float most = largest(grid, x, y, z), least = most * 1.00000095367431640625f;
    int whole = 4 * x + 4 < grid->n[0] && 4 * y + 4 < grid->n[1] && 4 * z + 4 < grid->n[2];
    if (bound < least || (double)bound > (double)least * (1 + 0x1p-18)) return 1;
    return whole && fabs((double)nph_majorant_mean(bound) - mean_of(grid, x, y, z) / (double)most) > 0.03125 + 1e-6;
}

static int distance_to_full(const NphMajorant *majorant, int x, int y, int z) {
    const int32_t *n = majorant->n;
    int least = n[0] > n[1] ? n[0] : n[1];
    least = n[2] > least ? n[2] : least;
    for (int k = 0; k < n[2]; k++)
        for (int j = 0; j < n[1]; j++)
            for (int i = 0; i < n[0]; i++) {
                int dx = abs(i - x), dy = abs(j - y), dz = abs(k - z), most = dx > dy ? dx : dy;
                most = dz > most ? dz : most;
                if (cell_at(majorant, i, j, k) > 0 && most < least) least = most;
            }
    return least;
}

/* `count` single voxels of random density in an empty box. */
typedef struct Dots {
    int count;
    int at[12][3];
} Dots;

static double dots(int x, int y, int z, void *user) {
    const Dots *set = user;
    for (int i = 0; i < set->count; i++)
        if (set->at[i][0] == x && set->at[i][1] == y && set->at[i][2] == z) return 0.1 + i;
    return 0;
}

START_TEST(bounds_are_the_largest_sample_times_the_factor_and_empty_cells_know_how_far) {
    NphContext *context = nph_test_context(2);
    static const int sizes[][3] = {{1, 1, 1}, {2, 3, 4}, {7, 15, 31}, {33, 30, 29}, {62, 5, 17}, {14, 47, 6}};
    uint64_t state = 3;
    for (int trial = 0; trial < 24; trial++) {
        const int *size = sizes[trial % 6];
        Dots set = {.count = trial % 5 * 3};
        for (int i = 0; i < set.count; i++)
            for (int a = 0; a < 3; a++) set.at[i][a] = random_below(&state, size[a]);
        NphArray array = field_array(context, size, dots, &set);
        NphGrid grid = build(context, &array, trial % 2 ? NPH_OUTSIDE_CLAMP : NPH_OUTSIDE_ZERO, NPH_LOOKUP_TRILINEAR);
        const NphMajorant *majorant = &grid.majorant;
        int wrong = 0;
        for (int a = 0; a < 3; a++) ck_assert_int_eq(majorant->n[a], (size[a] + 1 + 3) / 4);
        for (int z = 0; z < majorant->n[2]; z++)
            for (int y = 0; y < majorant->n[1]; y++)
                for (int x = 0; x < majorant->n[0]; x++) {
                    float bound = cell_at(majorant, x, y, z);
                    if (largest(&grid, x, y, z) > 0) wrong += bound_is_wrong(&grid, x, y, z, bound);
                    else wrong += bound != -(float)distance_to_full(majorant, x, y, z);
                }
        ck_assert_int_eq(wrong, 0);
        nph_grid_free(context, &grid);
        nph_array_free(context, &array);
    }
    nph_test_context_close(context);
}
END_TEST

/* Densities that strain rounding. kind 0: contrasts from the smallest denormal to 1e38; 1: neighbours of one value with
 * full mantissas; 2: denormals and the smallest normal numbers; 3: dense noise. */
typedef struct Extreme {
    int kind;
    uint64_t state;
} Extreme;

static double extreme(int x, int y, int z, void *user) {
    static const double contrasts[] = {0, 0x1p-149, 1e-40, FLT_MIN, 1e-20, 1, 1 + 0x1p-23, 1e20, 9.99999e37, 1e38};
    Extreme *set = user;
    (void)x, (void)y, (void)z;
    double unit = random_unit(&set->state);
    switch (set->kind) {
    case 0: return contrasts[random_below(&set->state, 10)];
    case 1: return 1.9999 + 0x1p-23 * random_below(&set->state, 64);
    case 2: return unit < 0.5 ? 0x1p-149 * random_below(&set->state, 20) : FLT_MIN * (1 + 2 * (unit - 0.75));
    default: return unit;
    }
}

/* A coordinate in [0.5, n - 1.5], often on or one rounding beside a sample or a cell's face. */
static float coordinate(uint64_t *state, int n) {
    float u = (float)(0.5 + random_unit(state) * (n - 2));
    int whole = 1 + random_below(state, n - 2);
    switch (random_below(state, 6)) {
    case 0: u = (float)whole; break;
    case 1: u = nextafterf((float)whole, 0); break;
    case 2: u = nextafterf((float)whole, 1e9f); break;
    case 3: u = (float)whole + 0.5f; break;
    default: break;
    }
    return u < 0.5f ? 0.5f : u > (float)n - 1.5f ? (float)n - 1.5f : u;
}

/* Cells that hold a coordinate: one, or two on a face. */
static int cells_of(double u, int n_cells, int cells[2]) {
    int count = 0, c = (int)floor(u / 4);
    if (c < n_cells) cells[count++] = c;
    if (u == 4.0 * c && c > 0) cells[count++] = c - 1;
    return count;
}

/* Largest and smallest of the corners of the lattice cell that holds a position. */
static void corners(const NphGrid *grid, const double at[3], double *least, double *most) {
    *least = HUGE_VAL;
    *most = 0;
    for (int corner = 0; corner < 8; corner++) {
        double value = (double)field_sample(grid, (int)at[0] + (corner & 1), (int)at[1] + (corner >> 1 & 1),
                                            (int)at[2] + (corner >> 2));
        *least = value < *least ? value : *least;
        *most = value > *most ? value : *most;
    }
}

/* Bounds that a lookup breaks: those of its corners, and those of all cells that its position belongs to. */
static int violations(const NphGrid *grid, const double at[3], double value) {
    int cells[3][2], count[3];
    double least, most;
    corners(grid, at, &least, &most);
    int bad = (value < least) + (value > most);
    for (int a = 0; a < 3; a++) count[a] = cells_of(at[a], grid->majorant.n[a], cells[a]);
    for (int k = 0; k < count[2]; k++)
        for (int j = 0; j < count[1]; j++)
            for (int i = 0; i < count[0]; i++) {
                double bound = (double)cell_at(&grid->majorant, cells[0][i], cells[1][j], cells[2][k]);
                bad += bound > 0 ? value > bound : value != 0;
            }
    return bad;
}

START_TEST(no_lookup_exceeds_its_bound_or_leaves_the_range_of_its_corners) {
    NphContext *context = nph_test_context(2);
    static float at32[3][POSITIONS], out32[POSITIONS];
    static double at64[3][POSITIONS], out64[POSITIONS];
    for (int trial = 0; trial < 16; trial++) {
        Extreme set = {.kind = trial % 4, .state = (uint64_t)trial};
        int size[3] = {9 + trial, 14, 22};
        NphArray array = field_array(context, size, extreme, &set);
        NphGrid grid = build(context, &array, trial & 4 ? NPH_OUTSIDE_CLAMP : NPH_OUTSIDE_ZERO,
                             trial & 8 ? NPH_LOOKUP_NEAREST : NPH_LOOKUP_TRILINEAR);
        uint64_t state = (uint64_t)(trial + 100);
        for (int i = 0; i < POSITIONS; i++)
            for (int a = 0; a < 3; a++) {
                at32[a][i] = coordinate(&state, grid.n[a]);
                at64[a][i] = (double)at32[a][i];
                if (random_below(&state, 4) == 0) /* beyond the precision of f32 */
                    at64[a][i] = fmax(0.5, nextafter(at64[a][i], random_below(&state, 2) ? 0 : 0.5));
            }
        ck_assert_int_eq(
            nph_grid_sample(context, &grid, 32, POSITIONS, (const void *[]){at32[0], at32[1], at32[2]}, out32), NPH_OK);
        ck_assert_int_eq(
            nph_grid_sample(context, &grid, 64, POSITIONS, (const void *[]){at64[0], at64[1], at64[2]}, out64), NPH_OK);
        int bad = 0;
        for (int i = 0; i < POSITIONS; i++) {
            double at[3] = {(double)at32[0][i], (double)at32[1][i], (double)at32[2][i]};
            bad += violations(&grid, at, (double)out32[i]);
            bad += violations(&grid, (double[]){at64[0][i], at64[1][i], at64[2][i]}, out64[i]);
        }
        ck_assert_msg(bad == 0, "%d bounds broken, kind %d", bad, set.kind);
        nph_grid_free(context, &grid);
        nph_array_free(context, &array);
    }
    nph_test_context_close(context);
}
END_TEST

/* Of the samples alone, padding included, whatever lies beyond the lattice; sizes around those of cells and bricks. */
START_TEST(dense_samples_have_the_majorants_of_their_grid_to_the_bit) {
    static const int sizes[][3] = {{1, 1, 1}, {3, 6, 7}, {13, 14, 15}, {22, 9, 5}, {30, 31, 17}};
    NphContext *context = nph_test_context(2);
    for (int s = 0; s < 5; s++)
        for (int outside = 0; outside < 2; outside++) {
            Dots set = {.count = 12};
            uint64_t state = 7u + (uint64_t)s;
            for (int i = 0; i < 12; i++)
                for (int a = 0; a < 3; a++) set.at[i][a] = i == 0 ? sizes[s][a] - 1 : random_below(&state, sizes[s][a]);
            NphArray array = field_array(context, sizes[s], dots, &set);
            NphGrid grid = build(context, &array, outside ? NPH_OUTSIDE_CLAMP : NPH_OUTSIDE_ZERO, NPH_LOOKUP_TRILINEAR);
            NphMajorant made;
            float *samples = calloc((size_t)nph_grid_dense_count(&grid), sizeof *samples);
            nph_grid_dense(&grid, samples);
            for (int k = 0; k < grid.n[2]; k++)
                for (int j = 0; j < grid.n[1]; j++)
                    for (int i = 0; i < grid.n[0]; i++)
                        ck_assert(samples[((int64_t)k * grid.n[1] + j) * grid.n[0] + i] == field_sample(&grid, i, j, k));
            ck_assert_int_eq(nph_majorant_of_samples(context, grid.n, samples, "samples", &made), NPH_OK);
            size_t cells = (size_t)grid.majorant.n[0] * (size_t)grid.majorant.n[1] * (size_t)grid.majorant.n[2];
            ck_assert_mem_eq(made.n, grid.majorant.n, sizeof made.n);
            ck_assert_mem_eq(made.cells, grid.majorant.cells, cells * sizeof *made.cells);
            nph_free(context, made.cells);
            free(samples);
            nph_grid_free(context, &grid);
            nph_array_free(context, &array);
        }
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, dense_samples_have_the_majorants_of_their_grid_to_the_bit);
    tcase_add_test(cases, bounds_are_the_largest_sample_times_the_factor_and_empty_cells_know_how_far);
    tcase_add_test(cases, no_lookup_exceeds_its_bound_or_leaves_the_range_of_its_corners);
}

int main(void) { return nph_test_main("majorant", fill); }
