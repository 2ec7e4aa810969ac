/* SPDX-License-Identifier: Apache-2.0
 *
 * A density field as sparse bricks of 8^3 samples, each stored with one more layer on the upper sides (9^3), so that a
 * trilinear lookup reads one brick. Positions are in LATTICE space: sample i stands at u = i, and the builder has put
 * one layer of padding below and above, so that sample 0 and sample n-1 are padding (zero, or the edge's value when
 * `outside` is clamp). The part of lattice space that is medium is the box [lo, hi]:
 *     cell centring   [0.5, n - 1.5]   values belong to cells, the field fills whole cells
 *     point centring  [1, n - 2]       values belong to points, the field ends at the outermost points
 *     vdb             [0, n - 1]       point centring that falls to zero within one voxel outside the active box
 * Storage is float in both precisions of the kernels. */
#ifndef NPH_FIELD_GRID_H
#define NPH_FIELD_GRID_H

#include <stdint.h>

#include "core/fmath.h"
#include "io/volume.h"

enum { NPH_BRICK = 8, NPH_BRICK_EDGE = 9, NPH_BRICK_STRIDE = 736 }; /* 9^3 = 729, padded to a multiple of 16 */
enum { NPH_MAJORANT_CELL = 4 };                                     /* edge of a majorant cell in samples */

/* Limits, refused beyond them with NPH_BAD_INPUT: samples along an axis with padding (an f32 position in the lattice is
 * then good to 2^-8), majorant cells of the whole box (1 GiB; about 2500^3 voxels), bricks stored (16 GiB: offsets
 * then fit 32 bits), density. */
enum { NPH_GRID_SAMPLES_MAX = 65536, NPH_GRID_CELLS_MAX = 1 << 28, NPH_GRID_BRICKS_MAX = 5835553 };
#define NPH_DENSITY_MAX 1e38

typedef enum NphCentring { NPH_CENTRING_CELL, NPH_CENTRING_POINT, NPH_CENTRING_VDB } NphCentring;
typedef enum NphOutside { NPH_OUTSIDE_ZERO, NPH_OUTSIDE_CLAMP } NphOutside;
typedef enum NphLookup { NPH_LOOKUP_NEAREST, NPH_LOOKUP_TRILINEAR } NphLookup;

/* Upper bounds of the density over cells of NPH_MAJORANT_CELL^3 of lattice space: cell c covers u in
 * [4 c, 4 (c + 1)] per axis, both ends included, so the bound holds for either lookup on the cell's faces too. It is
 * the largest of the samples 4 c .. 4 c + 4 times 1 + 2^-20; a lookup never exceeds the samples it is made of. Its last four
 * bits, by which it is larger still, tell the mean density of the cell in 32nds of the bound (nph_majorant_mean). An
 * empty cell (bound 0) holds minus the number k of cells that may be skipped: all cells within Chebyshev distance
 * k - 1 of it are empty (cells beyond the grid count as empty); k >= 1. */
typedef struct NphMajorant {
    int32_t n[3]; /* cells per axis */
    float *cells; /* [z][y][x] */
} NphMajorant;

/* A bound above `most` that carries mean / most, from 0 to 1: the nearest of 1/32, 3/32 ... 31/32. */
static inline float nph_majorant_bound(float most, double part) {
    int32_t level = (int32_t)(part * 16.0);
    return nph_from_bitsf(((nph_bitsf(most) + 15u) & ~15u) + (uint32_t)(level < 0 ? 0 : level > 15 ? 15 : level));
}

static inline float nph_majorant_mean(float bound) {
    return (float)(int32_t)(nph_bitsf(bound) & 15u) * 0.0625f + 0.03125f;
}

typedef struct NphGrid {
    int32_t n[3];                  /* samples per axis, padding included; >= 3 */
    int32_t bricks[3];             /* ceil(n / 8) */
    int32_t *brick_index;          /* [bz][by][bx]: number of the brick; 0 is the brick of zeros */
    int64_t brick_count;           /* at least 1; equal constant bricks are shared */
    float *values;                 /* brick_count * NPH_BRICK_STRIDE; within a brick z * 81 + y * 9 + x */
    double lo[3], hi[3];           /* the medium's box in lattice space */
    double world_from_lattice[12]; /* row-major 3x4, before any transform of the scene */
    NphLookup lookup;
    float min, max; /* of the stored samples without padding */
    double sum;     /* over samples without padding, compensated */
    int64_t active; /* samples different from zero */
    NphMajorant majorant;
} NphGrid;

/* All builders validate: NaN, infinite or negative samples and those above NPH_DENSITY_MAX are refused with
 * NPH_BAD_INPUT, naming the voxel's index as in the file, as are maps to the world that are not finite or flat. `what`
 * names the source in messages. *grid is untouched on failure. */

/* From leaves and tiles; never densified. The lattice spans the box of the active voxels; sample s is the file's lattice
 * point bbox_min + s - 1 and stands where the file's transform puts that point, whatever the centring (a cell is centred
 * on its point). Inactive voxels are 0 (a warning counts those that hold something else); a background other than 0 is
 * refused. A volume without active voxels becomes one sample of 0 at the lattice point (0, 0, 0). */
NphStatus nph_grid_from_volume(NphContext *context, const NphVolume *volume, NphCentring centring, NphLookup lookup,
                               const char *what, NphGrid *grid);

/* From a dense f32/f64/f16/integer array [z][y][x]; the box [lo, hi] in world units is what the cells fill (cell) or
 * what the outermost points span (point and vdb; an axis of one sample is refused). vdb with clamp is refused
 * (NPH_BAD_USAGE). */
NphStatus nph_grid_from_array(NphContext *context, const NphArray *array, const double lo[3], const double hi[3],
                              NphCentring centring, NphOutside outside, NphLookup lookup, const char *what,
                              NphGrid *grid);

/* The same lattice, sample = function(user, its place in the lattice, from's sample), which is not called where a whole
 * brick of `from` is zero: those stay zero. */
typedef double (*NphSampleFn)(const void *user, const double at[3], double value);
NphStatus nph_grid_derive(NphContext *context, const NphGrid *from, NphSampleFn function, const void *user,
                          const char *what, NphGrid *grid);

void nph_grid_free(NphContext *context, NphGrid *grid);

/* grid_dense.c: all samples of the lattice, padding included, [z][y][x]; room for as many as it has. And the majorants of such
 * samples, which must be densities, where those beyond the last ones repeat them: those of the grid, to the bit. */
int64_t nph_grid_dense_count(const NphGrid *grid);
void nph_grid_dense(const NphGrid *grid, float *samples);
NphStatus nph_majorant_of_samples(NphContext *context, const int32_t n[3], const float *samples, const char *what,
                                  NphMajorant *majorant);

/* Bytes the grid holds. */
uint64_t nph_grid_bytes(const NphGrid *grid);

/* For `nephos info`. mean: sum over all samples without padding divided by their number; mean_active: divided by the
 * number of those different from zero (0 when there are none). Optical depth for extinction = density: the exact
 * integral of the interpolant, from one end of the box to the other, along the lines of the lattice that go through
 * the samples; largest and unweighted mean over the lines through samples that are not padding. World units. */
typedef struct NphGridStatistics {
    double mean, mean_active;
    double axis_depth_mean[3], axis_depth_max[3];
} NphGridStatistics;
NphStatus nph_grid_statistics(NphContext *context, const NphGrid *grid, NphGridStatistics *statistics);

#endif
