/* SPDX-License-Identifier: Apache-2.0
 *
 * For tests of mesh readers: a file of given bytes, and a reader's complaint about it. */
#ifndef NPH_TESTS_MESH_FILE_H
#define NPH_TESTS_MESH_FILE_H

#include <stdio.h>
#include <string.h>

#include "harness.h"
#include "io/triangles.h"

typedef NphStatus (*MeshReader)(NphContext *, const char *, NphTriangles *);

static inline const char *mesh_file(const char *name, const void *bytes, size_t size) {
    const char *path = nph_test_temporary(name);
    remove(path); /* a file cut to nothing and written again would be synced by some file systems */
    FILE *file = fopen(path, "wb");
    ck_assert_ptr_nonnull(file);
    ck_assert_uint_eq(fwrite(bytes, 1, size, file), size);
    fclose(file);
    return path;
}

/* The bytes must be refused with a message that holds every part of wanted, parts separated by '|'. */
static inline void mesh_refused(NphContext *context, MeshReader read, const char *path, const char *wanted) {
    NphTriangles mesh = {.vertices = {.rank = 77}};
    NphStatus status = read(context, path, &mesh);
    const char *text = nph_test_messages();
    ck_assert_msg(status == NPH_BAD_INPUT, "status %d, wanted: %s, said: %s", (int)status, wanted, text);
    ck_assert_int_eq(mesh.vertices.rank, 77);
    while (*wanted) {
        char part[128];
        size_t length = strcspn(wanted, "|");
        snprintf(part, sizeof part, "%.*s", (int)length, wanted);
        ck_assert_msg(strstr(text, part) != NULL, "'%s' is not in: %s", part, text);
        wanted += length + (wanted[length] == '|');
    }
}

/* Every beginning of the bytes, and every byte changed: a status, never a crash; corners stay in range. */
static inline void mesh_hostile(NphContext *context, MeshReader read, const char *name, const char *bytes,
                                size_t size) {
    char changed[4096];
    ck_assert_uint_le(size, sizeof changed);
    for (size_t i = 0; i < 5 * size; i++) {
        static const char marks[5] = {0, '\xff', '9', '-', '\n'};
        size_t length = i < size ? i : size;
        memcpy(changed, bytes, size);
        if (i >= size) changed[i % size] = marks[i / size];
        NphTriangles mesh;
        NphStatus status = read(context, mesh_file(name, changed, length), &mesh);
        nph_test_messages();
        if (status != NPH_OK) continue;
        const int32_t *corner = mesh.triangles.data;
        for (int64_t k = 0; k < nph_array_count(&mesh.triangles); k++)
            ck_assert(corner[k] >= 0 && corner[k] < mesh.vertices.shape[0]);
        nph_triangles_free(context, &mesh);
    }
}

#endif
