/* SPDX-License-Identifier: Apache-2.0
 *
 * A bounding volume hierarchy over the triangles of all meshes of a scene, built by the surface area heuristic over
 * bins [Wald07]. Everything lies in scene-local space (metres; world minus origin), which kernels work in: vertices
 * once as doubles and once rounded to floats, boxes as floats rounded outwards, so that they hold the triangles of
 * both. Triangles are numbered through the meshes in their order. The build runs on one thread: the same bytes
 * always. */
#ifndef NPH_GEOMETRY_BVH_H
#define NPH_GEOMETRY_BVH_H

#include "geometry/mesh.h"

enum {
    NPH_BVH_DEPTH = 64 /* nodes on a way from the root to a leaf, at most: room of a traversal's stack */
};

/* Nodes lie in depth-first order. */
typedef struct NphBvhNode {
    float lo[3], hi[3];
    int32_t first; /* leaf: its first triangle; else the second child (the first one is the next node) */
    int32_t count; /* leaf: its triangles; else 0 */
} NphBvhNode;

typedef struct NphBvhTriangle {
    int32_t corner[3]; /* rows of vertices */
    int32_t number;    /* through all meshes */
} NphBvhTriangle;

typedef struct NphBvh {
    double origin[3]; /* of scene-local space, in world space */
    int32_t vertex_count, triangle_count, node_count, mesh_count;
    double *vertices;          /* [vertex_count][3] */
    float *vertices_f32;       /* [vertex_count][3], the same rounded to nearest */
    NphBvhNode *nodes;         /* none when there are no triangles */
    NphBvhTriangle *triangles; /* [triangle_count], grouped by leaves */
    int32_t *mesh_first;       /* [mesh_count + 1]: number of each mesh's first triangle, then triangle_count */
} NphBvh;

/* Lengths that traversal is exact about: coordinates in scene-local space reach at most 1e12 m, farther ones are
 * refused (NPH_BAD_INPUT names mesh and vertex). Copies what it needs of the meshes. *bvh is untouched on failure. */
NphStatus nph_bvh_build(NphContext *context, const NphMesh *meshes, int mesh_count, const double origin[3],
                        NphBvh *bvh);

void nph_bvh_free(NphContext *context, NphBvh *bvh);

/* Many rays at once, for tests and tools. ray[0..2] origins and ray[3..5] directions in scene-local space, ray[6] the
 * largest t, each of count numbers: float for precision 32, double for 64; so are t and weights. */
typedef struct NphBvhRays {
    int precision;
    int64_t count;
    const void *ray[7];
    void *t,
        *weight[2];  /* of the closest hit, and its second and third corner's weights; untouched where there is none */
    int32_t *number; /* of the triangle hit; -1 */
    unsigned char *any; /* what the any-hit traversal says */
} NphBvhRays;
NphStatus nph_bvh_trace(NphContext *context, const NphBvh *bvh, const NphBvhRays *rays);

#endif
