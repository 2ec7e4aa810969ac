/* SPDX-License-Identifier: Apache-2.0
 *
 * path: what host and kernels hand each other, 32-bit words in the same order on both sides. The members of Medium are those of a dump's
 * manifest (docs/oracle.md, Media). */
#ifndef EXAMPLE_SHARED_H
#define EXAMPLE_SHARED_H

#ifdef __OPENCL_VERSION__
#define WORD uint
#else
#include <stdint.h>
#define WORD uint32_t
#endif

typedef struct Medium {
    float from_local[12], lo[3], hi[3]; /* medium space from scene-local space; its box there */
    float sigma, collide;               /* 1/m; the part of it that makes collisions */
    float split;                        /* how much oftener camera rays collide; 0: they are not split */
    int is_grid, nearest, weighed, number, position;
    int samples[3], cells[3];           /* of a grid: x, y, z */
} Medium;

typedef struct Launch {
    WORD seed, frame, vertex, width, tile_x, tile_y, first_sample;
    int count;
} Launch;

#endif
