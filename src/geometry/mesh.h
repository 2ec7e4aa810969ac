/* SPDX-License-Identifier: Apache-2.0
 *
 * A triangle mesh in world space (metres, f64), checked and immutable. A corner order that turns counter-clockwise as
 * seen from outside has its normal outwards. Who gives the vertices has applied the object's transform.
 *
 * Triangles two corners of which lie at the same point are dropped and counted: their other two sides coincide, so a
 * closed surface stays closed. One whose three corners are distinct points of a line is kept, although its area is 0:
 * with it gone, its neighbours would meet at a T, where rounding opens cracks. */
#ifndef NPH_GEOMETRY_MESH_H
#define NPH_GEOMETRY_MESH_H

#include <stdint.h>

#include "nephos/array.h"

typedef struct NphMesh {
    int32_t vertex_count, triangle_count;
    double *vertices_m;  /* [vertex_count][3], owned */
    int32_t *triangles;  /* [triangle_count][3], owned; in the given order */
    double *areas_m2;    /* [triangle_count], owned */
    double area_m2;      /* their sum in that order */
    int32_t dropped;     /* degenerate triangles left out */
} NphMesh;

/* vertices: f64 or f32 [n][3]; triangles: i32 [m][3]. NPH_BAD_INPUT names the mesh and the vertex that is not finite or
 * the triangle that names no vertex. 0 triangles are allowed. *mesh is untouched on failure. */
NphStatus nph_mesh_make(NphContext *context, const char *name, const NphArray *vertices, const NphArray *triangles,
                        NphMesh *mesh);

void nph_mesh_free(NphContext *context, NphMesh *mesh);

/* Volume enclosed by a closed mesh (divergence theorem, about its first vertex); negative when turned inside out. */
double nph_mesh_volume(const NphMesh *mesh);

/* Sides that do not have exactly one partner of opposite direction: 0 for a closed, consistently oriented mesh. */
NphStatus nph_mesh_open_sides(NphContext *context, const NphMesh *mesh, int64_t *count);

#endif
