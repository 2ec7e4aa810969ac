/* SPDX-License-Identifier: Apache-2.0
 *
 * PLY, the records: every value of every element is read in the order of the header as a double, which holds each of
 * PLY's number types exactly; positions and corners are kept. No element is believed to have more records than the rest
 * of the file can hold. In ascii a record is a line. */
#include <string.h>

#include "core/memory.h"
#include "core/text.h"
#include "io/file.h"
#include "io/ply_header.h"
#include "io/printable.h"
#include "io/triangles.h"

enum { WORD_SHOWN = 32 };

typedef struct Reader {
    NphPlyFile file;
    int swapped;              /* the file's byte order is not the machine's */
    int64_t vertex_count;
    int position[3];          /* properties x, y, z; -1 */
    int corners;              /* property vertex_indices; -1 */
    int64_t triangle_count, triangle_room;
    NphTriangles mesh;
} Reader;

static int machine_is_little_endian(void) {
    const uint16_t one = 1;
    unsigned char first;
    memcpy(&first, &one, 1);
    return first == 1;
}

static int is_real(NphType type) { return type == NPH_F32 || type == NPH_F64; }

static double decode(NphType type, const unsigned char *bytes) {
    union {
        int16_t i16;
        uint16_t u16;
        int32_t i32;
        uint32_t u32;
        float f32;
        double f64;
    } as;
    if (type == NPH_I8) return (double)(signed char)bytes[0];
    if (type == NPH_U8) return (double)bytes[0];
    memcpy(&as, bytes, nph_type_size(type));
    switch (type) {
    case NPH_I16: return as.i16;
    case NPH_U16: return as.u16;
    case NPH_I32: return as.i32;
    case NPH_U32: return as.u32;
    case NPH_F32: return (double)as.f32;
    default: return as.f64;
    }
}

static NphStatus read_binary(Reader *reader, NphType type, const char *name, double *value) {
    NphPlyFile *file = &reader->file;
    unsigned char bytes[8] = {0};
    size_t size = nph_type_size(type);
    if ((size_t)(file->end - file->at) < size) return nph_ply_refuse(file, "the file ends inside property %s", name);
    for (size_t i = 0; i < size; i++) bytes[reader->swapped ? size - 1 - i : i] = (unsigned char)file->at[i];
    *value = decode(type, bytes);
    file->at += size;
    return NPH_OK;
}

/* A word of the current line. One that is no plain number (nan, inf) is refused for real types too. */
static NphStatus read_ascii(Reader *reader, NphType type, const char *name, double *value) {
    NphPlyFile *file = &reader->file;
    const char *begin = NULL, *end = NULL;
    char shown[WORD_SHOWN];
    int64_t whole = 0;
    if (!nph_ply_word(file, &begin, &end))
        return nph_ply_refuse(file, "the %s ends before property %s", file->at == file->end ? "file" : "line", name);
    nph_printable(begin, (size_t)(end - begin), shown, sizeof shown);
    if (is_real(type)) {
        if (nph_parse_double_range(begin, end, value)) return NPH_OK;
        return nph_ply_refuse(file, "property %s is '%s', not a finite number", name, shown);
    }
    if (!nph_parse_int_range(begin, end, &whole) || whole < INT32_MIN || whole > (int64_t)UINT32_MAX)
        return nph_ply_refuse(file, "property %s is '%s', not a whole number of at most 32 bits", name, shown);
    *value = (double)whole;
    return NPH_OK;
}

static NphStatus read_value(Reader *reader, NphType type, const char *name, double *value) {
    return reader->file.format == NPH_PLY_ASCII ? read_ascii(reader, type, name, value)
                                                : read_binary(reader, type, name, value);
}

static NphStatus add_triangle(Reader *reader, int32_t first, int32_t before, int32_t corner) {
    NphArray *triangles = &reader->mesh.triangles;
    if (reader->triangle_count == INT32_MAX) return nph_ply_refuse(&reader->file, "more than 2147483647 triangles");
    if (reader->triangle_count == reader->triangle_room) {
        reader->triangle_room = 2 * reader->triangle_room + 64;
        NPH_TRY(nph_realloc(reader->file.context, (size_t)reader->triangle_room, 3 * sizeof(int32_t), reader->file.path,
                            &triangles->data));
    }
    int32_t *out = (int32_t *)triangles->data + 3 * reader->triangle_count++;
    out[0] = first;
    out[1] = before;
    out[2] = corner;
    return NPH_OK;
}

static NphStatus read_corners(Reader *reader, const NphPlyProperty *property, int64_t length, int64_t face) {
    int32_t first = 0, before = 0;
    if (length < 3)
        return nph_ply_refuse(&reader->file, "face %lld has %lld corners; at least 3 are needed", (long long)face,
                              (long long)length);
    for (int64_t i = 0; i < length; i++) {
        double index = 0;
        NPH_TRY(read_value(reader, property->type, property->name, &index));
        if (!(index >= 0 && index < (double)reader->vertex_count))
            return nph_ply_refuse(&reader->file, "face %lld names vertex %.0f; the file has 0 to %lld", (long long)face,
                                  index, (long long)reader->vertex_count - 1);
        int32_t corner = (int32_t)index;
        if (i == 0) first = corner;
        if (i >= 2) NPH_TRY(add_triangle(reader, first, before, corner));
        before = corner;
    }
    return NPH_OK;
}

static NphStatus read_list(Reader *reader, int number, int64_t record) {
    const NphPlyProperty *property = &reader->file.properties[number];
    double length = 0, value = 0;
    NPH_TRY(read_value(reader, property->count_type, property->name, &length));
    if (length < 0) return nph_ply_refuse(&reader->file, "list %s has the length %.0f", property->name, length);
    if (number == reader->corners) return read_corners(reader, property, (int64_t)length, record);
    for (int64_t i = 0; i < (int64_t)length; i++)
        NPH_TRY(read_value(reader, property->type, property->name, &value));
    return NPH_OK;
}

static NphStatus read_record(Reader *reader, const NphPlyElement *element, int64_t record) {
    for (int p = element->first; p < element->first + element->properties; p++) {
        const NphPlyProperty *property = &reader->file.properties[p];
        double value = 0;
        if (property->is_list) {
            NPH_TRY(read_list(reader, p, record));
            continue;
        }
        NPH_TRY(read_value(reader, property->type, property->name, &value));
        for (int axis = 0; axis < 3; axis++) {
            if (p != reader->position[axis]) continue;
            if (!(value - value == 0))
                return nph_ply_refuse(&reader->file, "%s of vertex %lld is not finite", property->name,
                                      (long long)record);
            ((double *)reader->mesh.vertices.data)[3 * record + axis] = value;
        }
    }
    return NPH_OK;
}

/* Bytes that a record takes at least: in ascii a character and a blank for each value. */
static int64_t least_bytes(const Reader *reader, const NphPlyElement *element) {
    int64_t bytes = 0;
    for (int p = element->first; p < element->first + element->properties; p++) {
        const NphPlyProperty *property = &reader->file.properties[p];
        NphType type = property->is_list ? property->count_type : property->type;
        bytes += reader->file.format == NPH_PLY_ASCII ? 2 : (int64_t)nph_type_size(type);
    }
    return bytes;
}

static NphStatus read_element(Reader *reader, const NphPlyElement *element) {
    NphPlyFile *file = &reader->file;
    int64_t least = least_bytes(reader, element), left = (int64_t)(file->end - file->at);
    if (least == 0) return NPH_OK; /* records without properties take no room */
    if (element->count > (left + 1) / least) /* the last line may lack its end */
        return nph_ply_refuse(file, "%lld records of element %s cannot lie in the %lld bytes that follow",
                              (long long)element->count, element->name, (long long)left);
    if (strcmp(element->name, "vertex") == 0) {
        int64_t shape[2] = {element->count, 3};
        NPH_TRY(nph_array_new(file->context, NPH_F64, 2, shape, file->path, &reader->mesh.vertices));
    }
    for (int64_t record = 0; record < element->count; record++) {
        if (file->format != NPH_PLY_ASCII) {
            NPH_TRY(read_record(reader, element, record));
            continue;
        }
        while (file->at < file->end && nph_ply_line_ends(file)) {} /* empty lines */
        NPH_TRY(read_record(reader, element, record));
        if (!nph_ply_line_ends(file))
            return nph_ply_refuse(file, "more follows record %lld of element %s", (long long)record, element->name);
    }
    return NPH_OK;
}

static const NphPlyElement *find_element(const NphPlyFile *file, const char *name) {
    for (int i = 0; i < file->element_count; i++)
        if (strcmp(file->elements[i].name, name) == 0) return &file->elements[i];
    return NULL;
}

static int find_property(const NphPlyFile *file, const NphPlyElement *element, const char *name, int is_list) {
    for (int p = element->first; p < element->first + element->properties; p++)
        if (strcmp(file->properties[p].name, name) == 0 && file->properties[p].is_list == is_list) return p;
    return -1;
}

static NphStatus find_columns(Reader *reader) {
    static const char *const names[3] = {"x", "y", "z"};
    const NphPlyFile *file = &reader->file;
    const NphPlyElement *vertex = find_element(file, "vertex"), *face = find_element(file, "face");
    if (!vertex || !face) return nph_ply_refuse(file, "the file has no element %s", vertex ? "face" : "vertex");
    for (int axis = 0; axis < 3; axis++) {
        reader->position[axis] = find_property(file, vertex, names[axis], 0);
        if (reader->position[axis] < 0) return nph_ply_refuse(file, "element vertex has no property %s", names[axis]);
    }
    reader->corners = find_property(file, face, "vertex_indices", 1);
    if (reader->corners < 0) reader->corners = find_property(file, face, "vertex_index", 1);
    if (reader->corners < 0) return nph_ply_refuse(file, "element face has no list vertex_indices or vertex_index");
    if (is_real(file->properties[reader->corners].type))
        return nph_ply_refuse(file, "the list %s is of a real type; corners are whole numbers",
                              file->properties[reader->corners].name);
    if (vertex->count > INT32_MAX) return nph_ply_refuse(file, "more than 2147483647 vertices");
    reader->vertex_count = vertex->count;
    return NPH_OK;
}

static NphStatus read_file(Reader *reader) {
    NphPlyFile *file = &reader->file;
    NPH_TRY(nph_ply_header(file));
    NPH_TRY(find_columns(reader));
    reader->swapped = (file->format == NPH_PLY_BIG) == machine_is_little_endian();
    for (int i = 0; i < file->element_count; i++) NPH_TRY(read_element(reader, &file->elements[i]));
    if (reader->triangle_count == 0) return nph_ply_refuse(file, "the file has no face");
    if (file->format == NPH_PLY_ASCII)
        while (file->at < file->end && nph_ply_line_ends(file)) {}
    if (file->at < file->end)
        nph_warn(file->context, "%s: %lld bytes behind the last element are left out", file->path,
                 (long long)(file->end - file->at));
    return nph_realloc(file->context, (size_t)reader->triangle_count, 3 * sizeof(int32_t), file->path,
                       &reader->mesh.triangles.data);
}

NphStatus nph_ply_read(NphContext *context, const char *path, NphTriangles *mesh) {
    char *bytes = NULL;
    size_t size = 0;
    NPH_TRY(nph_file_read(context, path, &bytes, &size));
    Reader reader = {.file = {.context = context, .path = path, .bytes = bytes, .at = bytes, .end = bytes + size}};
    int64_t none[2] = {0, 3};
    NphStatus status = nph_array_new(context, NPH_I32, 2, none, path, &reader.mesh.triangles);
    if (status == NPH_OK) status = read_file(&reader);
    nph_free(context, bytes);
    if (status != NPH_OK) {
        nph_triangles_free(context, &reader.mesh);
        return status;
    }
    reader.mesh.triangles.shape[0] = reader.triangle_count;
    *mesh = reader.mesh;
    return NPH_OK;
}
