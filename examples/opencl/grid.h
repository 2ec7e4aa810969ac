/* SPDX-License-Identifier: Apache-2.0
 *
 * principal_ordinates: what host and kernels know of a grid, in 32-bit words in the same order on both sides, once for every grid and
 * channel. The host makes it of a row of pop.ordinate and of a dump's manifest (port_ordinates.c). */
#ifndef EXAMPLE_GRID_H
#define EXAMPLE_GRID_H

#include "nephos/portable.h"

typedef struct Grid {
    int n[3], radial;                  /* cells: across, across, along the light; shells around a point */
    int first_cell, first_number;      /* where it begins in pop.density; in pop.light, pop.cosine, pop.seen */
    int still;                         /* too little light is left: nothing moves any more */
    float sigma_a, sigma_s, g;         /* 1/m per unit of density; mean cosine of the phase function */
    float shown;                       /* what a visit counts: 1; at first that is half a cell */
    float wide, thick, thin;           /* see shown_by in propagate.cl */
    float cone, side[2];               /* cosine of the cone to the next cell; part of what goes beside it that each side along x, y has */
    float axis[9], low[3], edge[3];    /* of directions: axes, low corner and edges along them, scene-local [m] */
    float middle[3];                   /* what places are counted from: the middle of the medium's box, or the point */
    float inner, log_ratio, per_solid; /* of points: innermost radius; logarithm of a shell's outer over inner one; 1 / mean solid angle */
    float observer[3];                 /* his place, or, where `parallel`, the way to him */
    int parallel;
} Grid;

/* Solid angle of a cell of the octahedral map around (u, v) in [-1, 1]^2, in its middle's density. */
NPH_PORTABLE_FN float octahedron_solid(float u, float v, int n) {
    float z = 1.0f - nph_absf(u) - nph_absf(v), x = u, y = v;
    if (z < 0.0f) {
        x = 1.0f - nph_absf(v);
        y = 1.0f - nph_absf(u);
    }
    float square = x * x + y * y + z * z, edge = 2.0f / (float)n;
    return edge * edge / (square * nph_sqrtf(square));
}

#endif
