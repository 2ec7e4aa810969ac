/* SPDX-License-Identifier: Apache-2.0
 *
 * Checks and measures of triangle meshes. Area of a triangle: half the length of the cross product of two sides. */
#include "geometry/mesh.h"

#include <math.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"

static void sides(const NphMesh *mesh, int64_t triangle, double e[3], double f[3]) {
    const int32_t *corner = mesh->triangles + 3 * triangle;
    const double *a = mesh->vertices_m + 3 * (int64_t)corner[0];
    for (int k = 0; k < 3; k++) {
        e[k] = mesh->vertices_m[3 * (int64_t)corner[1] + k] - a[k];
        f[k] = mesh->vertices_m[3 * (int64_t)corner[2] + k] - a[k];
    }
}

static void cross(const double a[3], const double b[3], double out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static NphStatus check_shape(NphContext *context, const char *name, const NphArray *vertices,
                             const NphArray *triangles) {
    if ((vertices->type != NPH_F64 && vertices->type != NPH_F32) || vertices->rank != 2 || vertices->shape[1] != 3)
        return nph_error(context, NPH_BAD_USAGE, "%s: vertices must be an f64 or f32 array of shape [n][3]", name);
    if (triangles->type != NPH_I32 || triangles->rank != 2 || triangles->shape[1] != 3)
        return nph_error(context, NPH_BAD_USAGE, "%s: triangles must be an i32 array of shape [m][3]", name);
    if (vertices->shape[0] > INT32_MAX || triangles->shape[0] > INT32_MAX)
        return nph_error(context, NPH_BAD_INPUT, "%s: more than 2147483647 vertices or triangles", name);
    return NPH_OK;
}

static NphStatus copy_vertices(NphContext *context, const char *name, const NphArray *vertices, NphMesh *mesh) {
    mesh->vertex_count = (int32_t)vertices->shape[0];
    int64_t count = 3 * (int64_t)mesh->vertex_count;
    NPH_TRY(NPH_NEW(context, count, name, &mesh->vertices_m));
    for (int64_t i = 0; i < count; i++) {
        double x = vertices->type == NPH_F64 ? ((const double *)vertices->data)[i] : ((const float *)vertices->data)[i];
        if (!(x - x == 0))
            return nph_error(context, NPH_BAD_INPUT, "%s: %c of vertex %lld is not finite", name, "xyz"[i % 3],
                             (long long)(i / 3));
        mesh->vertices_m[i] = x;
    }
    return NPH_OK;
}

static int same_point(const NphMesh *mesh, int32_t a, int32_t b) {
    const double *p = mesh->vertices_m + 3 * (int64_t)a, *q = mesh->vertices_m + 3 * (int64_t)b;
    return p[0] == q[0] && p[1] == q[1] && p[2] == q[2];
}

static NphStatus copy_triangles(NphContext *context, const char *name, const NphArray *triangles, NphMesh *mesh) {
    int64_t given = triangles->shape[0];
    const int32_t *from = triangles->data;
    NPH_TRY(NPH_NEW(context, 3 * given, name, &mesh->triangles));
    NPH_TRY(NPH_NEW(context, given, name, &mesh->areas_m2));
    for (int64_t t = 0; t < given; t++) {
        const int32_t *corner = from + 3 * t;
        for (int i = 0; i < 3; i++)
            if (corner[i] < 0 || corner[i] >= mesh->vertex_count)
                return nph_error(context, NPH_BAD_INPUT, "%s: triangle %lld names vertex %d; the mesh has %d, from 0",
                                 name, (long long)t, (int)corner[i], (int)mesh->vertex_count);
        if (same_point(mesh, corner[0], corner[1]) || same_point(mesh, corner[1], corner[2]) ||
            same_point(mesh, corner[2], corner[0])) {
            mesh->dropped++;
            continue;
        }
        double e[3], f[3], n[3];
        int32_t kept = mesh->triangle_count++;
        memcpy(mesh->triangles + 3 * (int64_t)kept, corner, 3 * sizeof *corner);
        sides(mesh, kept, e, f);
        cross(e, f, n);
        mesh->areas_m2[kept] = 0.5 * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        mesh->area_m2 += mesh->areas_m2[kept];
    }
    return NPH_OK;
}

NphStatus nph_mesh_make(NphContext *context, const char *name, const NphArray *vertices, const NphArray *triangles,
                        NphMesh *mesh) {
    NphMesh made = {0};
    NPH_TRY(check_shape(context, name, vertices, triangles));
    NphStatus status = copy_vertices(context, name, vertices, &made);
    if (status == NPH_OK) status = copy_triangles(context, name, triangles, &made);
    if (status != NPH_OK) {
        nph_mesh_free(context, &made);
        return status;
    }
    *mesh = made;
    return NPH_OK;
}

void nph_mesh_free(NphContext *context, NphMesh *mesh) {
    nph_free(context, mesh->vertices_m);
    nph_free(context, mesh->triangles);
    nph_free(context, mesh->areas_m2);
    memset(mesh, 0, sizeof *mesh);
}

double nph_mesh_volume(const NphMesh *mesh) {
    double sum = 0;
    if (mesh->triangle_count == 0) return 0;
    const double *base = mesh->vertices_m + 3 * (int64_t)mesh->triangles[0];
    for (int64_t t = 0; t < mesh->triangle_count; t++) {
        double e[3], f[3], n[3];
        const double *a = mesh->vertices_m + 3 * (int64_t)mesh->triangles[3 * t];
        sides(mesh, t, e, f);
        cross(e, f, n);
        sum += (a[0] - base[0]) * n[0] + (a[1] - base[1]) * n[1] + (a[2] - base[2]) * n[2];
    }
    return sum / 6.0;
}

/* A side as the pair of its vertices, the lower first; +1 in that direction, -1 against it. */
typedef struct Side {
    int32_t low, high;
    int32_t forward, backward; /* how often each direction occurs */
} Side;

/* The slot of a side in an open-addressing table of a power of two of slots; high = 0 marks a free one. */
static Side *find_side(Side *table, uint64_t slots, int32_t low, int32_t high) {
    uint64_t hash = ((uint64_t)(uint32_t)low << 32 | (uint32_t)high) * 0x9E3779B97F4A7C15u;
    for (uint64_t i = hash ^ hash >> 29;; i++) {
        Side *side = &table[i & (slots - 1)];
        if (side->high == 0 || (side->low == low && side->high == high)) return side;
    }
}

NphStatus nph_mesh_open_sides(NphContext *context, const NphMesh *mesh, int64_t *count) {
    uint64_t slots = 16;
    Side *table = NULL;
    int64_t open = 0;
    while (slots < 6 * (uint64_t)mesh->triangle_count) slots *= 2;
    NPH_TRY(NPH_NEW(context, slots, "the sides of a mesh", &table));
    for (int64_t t = 0; t < mesh->triangle_count; t++)
        for (int i = 0; i < 3; i++) {
            int32_t a = mesh->triangles[3 * t + i], b = mesh->triangles[3 * t + (i + 1) % 3];
            Side *side = find_side(table, slots, a < b ? a : b, a < b ? b : a);
            side->low = a < b ? a : b;
            side->high = a < b ? b : a;
            *(a < b ? &side->forward : &side->backward) += 1;
        }
    for (uint64_t i = 0; i < slots; i++)
        if (table[i].high && (table[i].forward != 1 || table[i].backward != 1))
            open += table[i].forward + table[i].backward;
    nph_free(context, table);
    *count = open;
    return NPH_OK;
}
