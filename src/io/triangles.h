/* SPDX-License-Identifier: Apache-2.0
 *
 * Triangle meshes as their files hold them: positions and corners, nothing else. Polygons become fans around their
 * first corner, which is right for convex ones. What is read is checked: positions are finite, every corner names a
 * vertex of the file. Geometry (transforms, degenerate triangles) is the business of geometry/mesh.h. */
#ifndef NPH_IO_TRIANGLES_H
#define NPH_IO_TRIANGLES_H

#include "nephos/array.h"

typedef struct NphTriangles {
    NphArray vertices;  /* f64 [n][3], in the file's units and axes */
    NphArray triangles; /* i32 [m][3], counted from 0, in the file's order of corners */
} NphTriangles;

/* Wavefront OBJ: v, and f with corners a, a/b, a//c, a/b/c, counted from 1 or backwards from -1. Every other statement
 * is left out; one warning names them. NPH_BAD_INPUT with path:line. */
NphStatus nph_obj_read(NphContext *context, const char *path, NphTriangles *mesh);

/* PLY 1.0, ascii and binary of either byte order: x, y, z of element vertex and the list vertex_indices (or
 * vertex_index) of element face, of any number types; other elements and properties are skipped. NPH_BAD_INPUT with
 * path:line in the header and in ascii, with the byte offset in binary. */
NphStatus nph_ply_read(NphContext *context, const char *path, NphTriangles *mesh);

void nph_triangles_free(NphContext *context, NphTriangles *mesh);

#endif
