/* SPDX-License-Identifier: Apache-2.0
 *
 * path.majorant: of every cell of 4^3 samples the largest density and the mean (bound), then for empty cells the chessboard
 * distance to the next one that is not, axis by axis (near_x, near_y, near_z). One work-item a cell. */
#include "nephos/portable.h"
#include "shared.h"

#ifdef cl_khr_fp64
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
typedef double Wide; /* the reference's means; in float they may fall into the next sixteenth */
#else
typedef float Wide;
#endif

/* Samples beyond the last ones repeat them. */
static float sample(__global const float *density, const Medium *m, int x, int y, int z) {
    x = min(x, m->samples[0] - 1);
    y = min(y, m->samples[1] - 1);
    z = min(z, m->samples[2] - 1);
#ifdef PLANT_TRANSPOSED_AXIS
    return density[(x * m->samples[1] + y) * m->samples[2] + z];
#else
    return density[(z * m->samples[1] + y) * m->samples[0] + x];
#endif
}

static int furthest(const Medium *m) { return max(m->cells[0], max(m->cells[1], m->cells[2])); }

__kernel void bound(const Medium medium, __global const float *density, __global float *cells) {
    const Wide weight[5] = {0.125f, 0.25f, 0.25f, 0.25f, 0.125f};
    int cell = (int)get_global_id(0);
    if (cell >= medium.cells[0] * medium.cells[1] * medium.cells[2]) return;
    int x0 = 4 * (cell % medium.cells[0]), y0 = 4 * (cell / medium.cells[0] % medium.cells[1]);
    int z0 = 4 * (cell / (medium.cells[0] * medium.cells[1]));
    float most = 0.0f;
    Wide mean = 0.0f;
    for (int z = 0; z < 5; z++)
        for (int y = 0; y < 5; y++) {
            Wide row = 0.0f;
            for (int x = 0; x < 5; x++) {
                float value = sample(density, &medium, x0 + x, y0 + y, z0 + z);
                most = value > most ? value : most;
                row += weight[x] * (Wide)value;
            }
            mean += weight[z] * weight[y] * row;
        }
    if (!(most > 0.0f)) {
        cells[cell] = (float)-furthest(&medium);
        return;
    }
    int level = clamp((int)((Wide)(float)mean / (Wide)most * 16.0f), 0, 15);
    cells[cell] = nph_from_bitsf(((nph_bitsf(most * (1.0f + 0x1p-20f)) + 15u) & ~15u) + (uint)level);
}

/* The cell's distance along x. */
__kernel void near_x(const Medium medium, __global const float *cells, __global int *near) {
    int cell = (int)get_global_id(0), n = medium.cells[0], x = cell % n, least = furthest(&medium);
    if (cell >= n * medium.cells[1] * medium.cells[2]) return;
    for (int i = 0; i < n; i++)
        if (cells[cell - x + i] > 0.0f) least = min(least, (int)abs(x - i));
    near[cell] = least;
}

/* In the plane: the least of max(distance along y, distance along x there). */
__kernel void near_y(const Medium medium, __global const int *row, __global int *near) {
    int cell = (int)get_global_id(0), step = medium.cells[0], n = medium.cells[1], y = cell / step % n, least = furthest(&medium);
    if (cell >= step * n * medium.cells[2]) return;
    for (int j = 0; j < n; j++) least = min(least, max((int)abs(y - j), row[cell + (j - y) * step]));
    near[cell] = least;
}

__kernel void near_z(const Medium medium, __global const int *plane, __global float *cells) {
    int cell = (int)get_global_id(0), step = medium.cells[0] * medium.cells[1], n = medium.cells[2], z = cell / step;
    int least = furthest(&medium);
    if (cell >= step * n) return;
    for (int k = 0; k < n; k++) least = min(least, max((int)abs(z - k), plane[cell + (k - z) * step]));
    if (!(cells[cell] > 0.0f)) cells[cell] = (float)-least;
}
