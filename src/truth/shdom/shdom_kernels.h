/* SPDX-License-Identifier: Apache-2.0
 *
 * What the kernels of truth/shdom take, and their table. Arrays are of the precision's numbers where they are void. */
#ifndef NPH_TRUTH_SHDOM_KERNELS_H
#define NPH_TRUTH_SHDOM_KERNELS_H

#include <stdint.h>

#include "core/real.h"
#include "nephos/context.h"
#include "truth/shdom/shdom_angles.h"

/* Ordinates whose radiance is known at once; points, cells or coefficients of a block. */
enum { NPH_SHDOM_GROUP = 32, NPH_SHDOM_BLOCK = 1024 };

/* Cells in rows, x fastest; points at their corners. Where sides repeat the last point of a row is the first. */
typedef struct NphShdomGrid {
    int32_t cells[3], points[3];
    int periodic[3];
    double from_local[12], to_local[12]; /* affine, row-major 3 x 4: one cell is 1 in the grid's space */
    int64_t cell_count, point_count;
} NphShdomGrid;

/* A sun, whose light falls off exponentially between points: what the ordinate gets of it where it is not attenuated, by what it scatters. */
typedef struct NphShdomBeam {
    double scattered;
    const void *depth, *mean; /* [point]: of density [m]; [cell]: e^-tau */
} NphShdomBeam;

enum { NPH_SHDOM_SUNS_MAX = 32 };

/* One ordinate through the grid, of one channel. */
typedef struct NphShdomSweep {
    const NphShdomGrid *grid;
    const double *basis; /* [coefficients] of the ordinate */
    int coefficients;
    double along[3];     /* in the grid's space, of one metre on the ordinate */
    double extinction;   /* per unit of density [1/m] */
    int cubic;           /* radiance is interpolated by polynomials of third degree, else linearly */
    double thin;         /* optical depth of a step at which a cell's mean is half that of its corners */
    double border;       /* radiance that comes in at open sides */
    const void *density, *share, *bubble; /* [cell]; share: how much the source counts; bubble: what comes on top of it */
    const void *source;  /* [coefficient][point] */
    void *projected;     /* of the worker: [point], the largest plane, two rows and eight numbers more */
    void *radiance, *mean; /* [point]; [cell] */
    int beam_count;
    NphShdomBeam beams[NPH_SHDOM_SUNS_MAX];
} NphShdomSweep;

/* Coefficients of a group's radiance, points [first, end): moments [coefficient][points]. */
typedef struct NphShdomGather {
    const double *factors; /* [ordinate of the group][stride]: weight times basis */
    int ordinates, coefficients, stride, add; /* add: to what there is */
    int64_t points, first, end;
    const void *radiance;  /* [ordinate of the group][points] */
    void *moments;
} NphShdomGather;

/* What accelerate combines: elements [first, end) of rows of `size`; history [slot][2][size]: a source, and how it changed. */
typedef struct NphShdomMix {
    int64_t size, first, end;
    int slot, count;              /* that is written now; slots in use */
    double *dots;                 /* [count + 1]: changes times the newest one; then the source's square */
    const double *weights;        /* [count] */
    const void *scattered;
    void *source, *history;
} NphShdomMix;

/* The kernels of one precision and level. */
typedef struct NphShdomKernels {
    int64_t (*sweep)(const NphShdomSweep *sweep); /* 1: rounds through sides that repeat did not settle, else 0 */
    void (*gather)(const NphShdomGather *gather);
    /* out = factor * (a + b), elements [first, end) */
    void (*scatter)(double factor, const void *a, const void *b, const int64_t range[2], void *out);
    void (*difference)(const NphShdomMix *mix); /* the newest change and source, into their slot; dots */
    void (*combine)(const NphShdomMix *mix);    /* the next source */
    void (*store)(const double *values, int64_t count, void *to); /* as the precision's numbers */
    double (*load)(const void *from, int64_t at);
    /* bubble of cells [first, end): harmonic * (mean of the cell - mean of its corners) */
    void (*bubble)(const NphShdomGrid *grid, const void *corners, const void *means, const int64_t range[2], void *out);
    /* field[point] has rows of `stride`: sum over corners of weight times coefficients times basis, for `rows` rows of each */
    void (*look)(const NphShdomLook *look, const void *field, double *out);
} NphShdomKernels;
void nph_shdom_kernels(NphIsa isa, int precision, NphShdomKernels *kernels);

#endif
