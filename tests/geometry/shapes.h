/* SPDX-License-Identifier: Apache-2.0
 *
 * Meshes for tests: a subdivided icosahedron (closed), boxes (closed), random triangles; and random numbers. */
#ifndef NPH_TESTS_SHAPES_H
#define NPH_TESTS_SHAPES_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/philox.h"
#include "geometry/bvh.h"
#include "harness.h"

typedef struct Random {
    uint32_t seed, count;
} Random;

static inline double uniform(Random *random) {
    NphWords words = nph_philox(random->seed, 77, random->count++, 0, 0, 0);
    return nph_uniform(words.w0) + nph_uniform(words.w1) * 0x1p-32;
}

static inline void random_direction(Random *random, double d[3]) {
    double z = 1.0 - 2.0 * uniform(random), phi = 6.283185307179586 * uniform(random), r = sqrt(1.0 - z * z);
    d[0] = r * cos(phi);
    d[1] = r * sin(phi);
    d[2] = z;
}

static inline NphMesh mesh_of(NphContext *context, const double *vertices, int64_t n, const int32_t *triangles,
                              int64_t m) {
    NphArray v = {.type = NPH_F64, .rank = 2, .shape = {n, 3, 1, 1, 1, 1}, .data = (void *)vertices};
    NphArray t = {.type = NPH_I32, .rank = 2, .shape = {m, 3, 1, 1, 1, 1}, .data = (void *)triangles};
    NphMesh mesh;
    NphStatus status = nph_mesh_make(context, "shape", &v, &t, &mesh);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    return mesh;
}

/* Vertices and triangles while an icosahedron is subdivided. */
typedef struct Solid {
    double *v;
    int32_t *t;
    int64_t n, m;
} Solid;

static inline int32_t solid_vertex(Solid *solid, const double p[3]) {
    double length = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    for (int k = 0; k < 3; k++) solid->v[3 * solid->n + k] = p[k] / length;
    return (int32_t)solid->n++;
}

/* The vertex in the middle of a side, made once: a side is met from both of its triangles. */
static inline int32_t solid_middle(Solid *solid, int32_t *middles, int32_t a, int32_t b) {
    int32_t low = a < b ? a : b, high = a < b ? b : a;
    int32_t *row = middles + 12 * (int64_t)low; /* six neighbours at most: pairs (vertex, middle) */
    int i = 0;
    while (row[2 * i + 1] && row[2 * i] != high) i++;
    if (!row[2 * i + 1]) {
        double p[3];
        for (int k = 0; k < 3; k++) p[k] = solid->v[3 * a + k] + solid->v[3 * b + k];
        row[2 * i] = high;
        row[2 * i + 1] = solid_vertex(solid, p);
    }
    return row[2 * i + 1];
}

static inline Solid solid_icosahedron(int level) {
    static const int32_t faces[20][3] = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                         {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                         {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                         {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    int64_t most = 20 * ((int64_t)1 << 2 * level);
    Solid solid = {malloc((size_t)(most / 2 + 2) * 3 * sizeof(double)), malloc((size_t)most * 3 * sizeof(int32_t)), 0,
                   20};
    const double f = 1.618033988749895;
    const double corners[12][3] = {{-1, f, 0}, {1, f, 0}, {-1, -f, 0}, {1, -f, 0}, {0, -1, f}, {0, 1, f},
                                   {0, -1, -f}, {0, 1, -f}, {f, 0, -1}, {f, 0, 1}, {-f, 0, -1}, {-f, 0, 1}};
    for (int i = 0; i < 12; i++) solid_vertex(&solid, corners[i]);
    memcpy(solid.t, faces, sizeof faces);
    for (; level > 0; level--) {
        int32_t *middles = calloc((size_t)solid.n * 12, sizeof *middles);
        int32_t *finer = malloc((size_t)solid.m * 12 * sizeof *finer);
        for (int64_t i = 0; i < solid.m; i++) {
            const int32_t *c = solid.t + 3 * i;
            int32_t m[3];
            for (int k = 0; k < 3; k++) m[k] = solid_middle(&solid, middles, c[k], c[(k + 1) % 3]);
            const int32_t four[12] = {c[0], m[0], m[2], m[0], c[1], m[1], m[2], m[1], c[2], m[0], m[1], m[2]};
            memcpy(finer + 12 * i, four, sizeof four);
        }
        solid.m *= 4;
        memcpy(solid.t, finer, (size_t)solid.m * 3 * sizeof *finer);
        free(middles);
        free(finer);
    }
    return solid;
}

/* A sphere-like closed mesh: vertex = centre + scale * (unit vertex * (1 - rough * random)). */
static inline NphMesh ball(NphContext *context, int level, const double centre[3], const double scale[3],
                           double rough) {
    Solid solid = solid_icosahedron(level);
    Random random = {4711, 0};
    for (int64_t i = 0; i < solid.n; i++) {
        double r = 1.0 - rough * uniform(&random);
        for (int k = 0; k < 3; k++) solid.v[3 * i + k] = centre[k] + scale[k] * r * solid.v[3 * i + k];
    }
    NphMesh mesh = mesh_of(context, solid.v, solid.n, solid.t, solid.m);
    free(solid.v);
    free(solid.t);
    return mesh;
}

static inline NphMesh box(NphContext *context, const double lo[3], const double hi[3]) {
    static const int32_t faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                         {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    double v[24];
    for (int i = 0; i < 24; i++) v[i] = (i / 3) >> (i % 3) & 1 ? hi[i % 3] : lo[i % 3];
    return mesh_of(context, v, 8, &faces[0][0], 12);
}

/* Triangles thrown into a cube about centre, of sizes from size down to size / spread. */
static inline NphMesh soup(NphContext *context, uint32_t seed, int count, const double centre[3], double size,
                           double spread) {
    Random random = {seed, 0};
    double *v = malloc((size_t)count * 9 * sizeof *v);
    int32_t *t = malloc((size_t)count * 3 * sizeof *t);
    for (int i = 0; i < count; i++) {
        double middle[3], extent = size * pow(spread, -uniform(&random));
        for (int k = 0; k < 3; k++) middle[k] = centre[k] + size * (2.0 * uniform(&random) - 1.0);
        for (int j = 0; j < 9; j++) v[9 * i + j] = middle[j % 3] + extent * (2.0 * uniform(&random) - 1.0);
        for (int k = 0; k < 3; k++) t[3 * i + k] = 3 * i + k;
    }
    NphMesh mesh = mesh_of(context, v, 3 * (int64_t)count, t, count);
    free(v);
    free(t);
    return mesh;
}

static inline NphBvh bvh_of(NphContext *context, const NphMesh *mesh, const double origin[3]) {
    static const double zero[3] = {0, 0, 0};
    NphBvh bvh;
    NphStatus status = nph_bvh_build(context, mesh, 1, origin ? origin : zero, &bvh);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    return bvh;
}

/* Rays and results for nph_bvh_trace in either precision. */
typedef struct Rays {
    NphBvhRays rays;
    char *memory;
    int64_t room;
} Rays;

static inline Rays rays_new(int precision, int64_t room) {
    Rays r = {.rays = {.precision = precision}, .room = room};
    size_t size = (size_t)precision / 8;
    r.memory = calloc((size_t)room, 10 * size + 5);
    for (int k = 0; k < 7; k++) r.rays.ray[k] = r.memory + (size_t)k * (size_t)room * size;
    r.rays.t = r.memory + 7 * (size_t)room * size;
    r.rays.weight[0] = r.memory + 8 * (size_t)room * size;
    r.rays.weight[1] = r.memory + 9 * (size_t)room * size;
    r.rays.number = (int32_t *)(r.memory + 10 * (size_t)room * size);
    r.rays.any = (unsigned char *)(r.rays.number + room);
    return r;
}

static inline void rays_put(Rays *r, int k, int64_t i, double x) {
    if (r->rays.precision == 32) ((float *)r->rays.ray[k])[i] = (float)x;
    else ((double *)r->rays.ray[k])[i] = x;
}

/* Adds the ray from o through the point q, both first rounded to the precision; d is their difference in it. */
static inline void rays_through(Rays *r, const double o[3], const double q[3], double t_max) {
    int64_t i = r->rays.count++;
    ck_assert_int_lt(i, r->room);
    for (int k = 0; k < 3; k++) {
        rays_put(r, k, i, o[k]);
        rays_put(r, 3 + k, i, r->rays.precision == 32 ? (double)((float)q[k] - (float)o[k]) : q[k] - o[k]);
    }
    rays_put(r, 6, i, t_max);
}

static inline double rays_real(const Rays *r, const void *values, int64_t i) {
    return r->rays.precision == 32 ? (double)((const float *)values)[i] : ((const double *)values)[i];
}

#endif
