/* SPDX-License-Identifier: Apache-2.0
 *
 * PLY: the same mesh in ascii and both byte orders and in every number type, polygons, foreign elements, and
 * mistakes. */
#include <float.h>
#include <stdlib.h>

#include "mesh_file.h"

typedef struct Bytes {
    char data[4096];
    size_t size;
} Bytes;

static void put_text(Bytes *out, const char *text) {
    memcpy(out->data + out->size, text, strlen(text));
    out->size += strlen(text);
}

static const char *const type_names[8] = {"char", "uchar", "int16", "ushort", "int", "uint32", "float", "float64"};

#define PUT_AS(type)                   \
    do {                               \
        type number = (type)value;     \
        size = sizeof number;          \
        memcpy(raw, &number, size);    \
    } while (0)

/* A number in a PLY type, in the given byte order. */
static void put(Bytes *out, int type, int big, double value) {
    unsigned char raw[8];
    size_t size = 0;
    switch (type) {
    case 0: PUT_AS(int8_t); break;
    case 1: PUT_AS(uint8_t); break;
    case 2: PUT_AS(int16_t); break;
    case 3: PUT_AS(uint16_t); break;
    case 4: PUT_AS(int32_t); break;
    case 5: PUT_AS(uint32_t); break;
    case 6: PUT_AS(float); break;
    default: PUT_AS(double);
    }
    for (size_t i = 0; i < size; i++) out->data[out->size + i] = (char)raw[big ? size - 1 - i : i];
    out->size += size;
}

static const double positions[4][3] = {{0, 1, 2}, {100, 0, 3}, {7, 120, 0}, {1, 1, 1}};
static const int faces[2][5] = {{3, 0, 1, 2}, {4, 3, 2, 1, 0}};

/* A triangle and a quadrilateral; foreign elements and properties stand between. */
static void build(Bytes *out, int format, int position_type, int length_type, int corner_type) {
    static const char *const formats[3] = {"ascii", "binary_little_endian", "binary_big_endian"};
    char header[1024];
    int big = format == 2;
    out->size = 0;
    snprintf(
        header, sizeof header,
        "ply\nformat %s 1.0\ncomment by hand\nobj_info none\nelement camera 1\nproperty list uchar float fov\n"
        "property double far\nelement nothing 3\nelement vertex 4\nproperty %s y\nproperty uchar red\nproperty %s x\n"
        "property %s z\nelement face 2\nproperty float area\nproperty list %s %s %s\nproperty char tag\nend_header\n",
        formats[format], type_names[position_type], type_names[position_type], type_names[position_type],
        type_names[length_type], type_names[corner_type], position_type % 2 ? "vertex_index" : "vertex_indices");
    put_text(out, header);
    if (format == 0) {
        put_text(out, "2 0.5 1.5 1e3\n");
        for (int v = 0; v < 4; v++) {
            snprintf(header, sizeof header, "%g 255 %g %g%s\n", positions[v][1], positions[v][0], positions[v][2],
                     v == 2 ? "\r\n" : "");
            put_text(out, header);
        }
        put_text(out, "0.5 3 0 1 2 -1\n0.25 4 3 2 1 0 -1"); /* the last line has no end */
        return;
    }
    put(out, 1, big, 2);
    put(out, 6, big, 0.5);
    put(out, 6, big, 1.5);
    put(out, 7, big, 1e3);
    for (int v = 0; v < 4; v++) {
        put(out, position_type, big, positions[v][1]);
        put(out, 1, big, 255);
        put(out, position_type, big, positions[v][0]);
        put(out, position_type, big, positions[v][2]);
    }
    for (int f = 0; f < 2; f++) {
        put(out, 6, big, 0.5);
        put(out, length_type, big, faces[f][0]);
        for (int i = 1; i <= faces[f][0]; i++) put(out, corner_type, big, faces[f][i]);
        put(out, 0, big, -1);
    }
}

static void expect_mesh(NphContext *context, const Bytes *bytes) {
    static const int32_t corners[9] = {0, 1, 2, 3, 2, 1, 3, 1, 0};
    NphTriangles mesh;
    NphStatus status = nph_ply_read(context, mesh_file("mesh.ply", bytes->data, bytes->size), &mesh);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    ck_assert_str_eq(nph_test_messages(), "");
    ck_assert_int_eq(mesh.vertices.shape[0], 4);
    ck_assert_int_eq(mesh.triangles.shape[0], 3);
    ck_assert_int_eq(memcmp(mesh.vertices.data, positions, sizeof positions), 0);
    ck_assert_int_eq(memcmp(mesh.triangles.data, corners, sizeof corners), 0);
    nph_triangles_free(context, &mesh);
}

START_TEST(every_format_and_number_type_gives_the_same_mesh) {
    NphContext *context = nph_test_context(1);
    Bytes bytes;
    for (int format = 0; format < 3; format++)
        for (int type = 0; type < 8; type++)
            for (int length = 0; length < 6; length++) {
                build(&bytes, format, type, length, (type + length) % 6);
                expect_mesh(context, &bytes);
            }
    nph_test_context_close(context);
}
END_TEST

START_TEST(numbers_keep_every_bit) {
    NphContext *context = nph_test_context(1);
    static const double values[3] = {0.1, -1.7976931348623157e308, 4.9406564584124654e-324};
    Bytes bytes = {.size = 0};
    NphTriangles mesh;
    put_text(&bytes,
             "ply\r\nformat binary_big_endian 1.0\r\nelement vertex 1\r\nproperty double x\r\nproperty double y\r\n"
             "property double z\r\nelement face 1\r\nproperty list uchar uint vertex_indices\r\nend_header\r\n");
    for (int k = 0; k < 3; k++) put(&bytes, 7, 1, values[k]);
    put(&bytes, 1, 1, 3);
    for (int k = 0; k < 3; k++) put(&bytes, 5, 1, 0);
    put_text(&bytes, "more");
    ck_assert_int_eq(nph_ply_read(context, mesh_file("bits.ply", bytes.data, bytes.size), &mesh), NPH_OK);
    ck_assert_ptr_nonnull(strstr(nph_test_messages(), "4 bytes behind the last element are left out"));
    ck_assert_int_eq(memcmp(mesh.vertices.data, values, sizeof values), 0);
    nph_triangles_free(context, &mesh);
    nph_test_context_close(context);
}
END_TEST

#define VERTEX "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
#define FACE "element face 1\nproperty list uchar int vertex_indices\n"
#define ASCII "ply\nformat ascii 1.0\n" VERTEX FACE "end_header\n"
static const struct {
    const char *text, *wanted;
} mistakes[] = {
    {"", ":1: |begins with a line 'ply'"},
    {"plyx\n", ":1: "},
    {"ply\nformat ascii 1.0\n" VERTEX, ":7: |ends before end_header"},
    {"ply\n" VERTEX FACE "end_header\n", "no line 'format'"},
    {"ply\nformat ascii 2.0\n", ":2: |'ascii 2.0'"},
    {"ply\nformat ascii 1.0\nformat ascii 1.0\n", ":3: |a second line"},
    {"ply\nformat binary_middle_endian 1.0\n", "binary_middle_endian"},
    {"ply\nformat ascii 1.0\nelement vertex -1\n", ":3: |'-1'"},
    {"ply\nformat ascii 1.0\nelement vertex 1e3\n", "'1e3'"},
    {"ply\nformat ascii 1.0\nproperty float x\n", "before the first element"},
    {"ply\nformat ascii 1.0\nelement v 1\nproperty half x\n", ":4: |'half'"},
    {"ply\nformat ascii 1.0\nelement v 1\nproperty list float int x\n", "cannot be of type float"},
    {"ply\nformat ascii 1.0\nelement v 1\nproperty int x\nproperty int x\n", ":5: |twice"},
    {"ply\nformat ascii 1.0\nelement v 1\nelement v 1\n", "twice"},
    {"ply\nformat ascii 1.0\nelement v 1 1\n", "'1' follows"},
    {"ply\nfoo\n", ":2: |'foo' is no word"},
    {"ply\nformat ascii 1.0\n" VERTEX "end_header\n", "no element face"},
    {"ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nproperty int y\n" FACE "end_header\n", "no property z"},
    {"ply\nformat ascii 1.0\n" VERTEX "element face 1\nproperty int vertex_indices\nend_header\n",
     "no list vertex_indices"},
    {"ply\nformat ascii 1.0\n" VERTEX "element face 1\nproperty list int float vertex_indices\nend_header\n",
     "real type"},
    {"ply\nformat ascii 1.0\nelement vertex 99999999999\nproperty int x\nproperty int y\nproperty int z\n" FACE
     "end_header\n0 0 0\n",
     "more than 2147483647"},
    {"ply\nformat ascii 1.0\nelement vertex 999999999\nproperty int x\nproperty int y\nproperty int z\n" FACE
     "end_header\n0 0 0\n",
     ":10: |999999999 records of element vertex cannot lie in the 6 bytes"},
    {"ply\nformat binary_little_endian 1.0\n" VERTEX FACE "end_header\n0123456789012345678901234567890123",
     "byte 169|3 records|34 bytes"},
    {ASCII "0 0 0\n1 0 0\n0 1 0\n3 0 1\n", ":13: |the line ends before property vertex_indices"},
    {ASCII "0 0 0\n1 0 0\n0 1 0\n3 0 1 2 2\n", ":13: |more follows record 0 of element face"},
    {ASCII "0 0 0\n1 0\n0 1 0\n3 0 1 2 2\n", ":11: |the line ends before property z"},
    {ASCII "0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n", ":11: |property z is 'nan', not a finite number"},
    {ASCII "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", ":13: |face 0 names vertex 3; the file has 0 to 2"},
    {ASCII "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", "names vertex -1"},
    {ASCII "0 0 0\n1 0 0\n0 1 0\n3 0 1 1.5\n", "'1.5', not a whole number"},
    {ASCII "0 0 0\n1 0 0\n0 1 0\n2 0 1     \n", "has 2 corners"},
    {ASCII "0 0 0\n1 0 0\n0 1 0\n-3 0 1 2\n", "has the length -3"},
    {ASCII "0 0 0\n1 0 0\n0 1 0\n4294967295 0 1 2\n", "the line ends before"},
};

START_TEST(mistakes_are_refused_with_their_place) {
    NphContext *context = nph_test_context(1);
    mesh_refused(context, nph_ply_read, mesh_file("wrong.ply", mistakes[_i].text, strlen(mistakes[_i].text)),
                 mistakes[_i].wanted);
    nph_test_context_close(context);
}
END_TEST

START_TEST(infinite_positions_of_binary_files_are_refused) {
    NphContext *context = nph_test_context(1);
    Bytes bytes;
    build(&bytes, 1, 7, 1, 4);
    unsigned char infinity[8] = {0, 0, 0, 0, 0, 0, 0xf0, 0x7f};
    size_t records = (size_t)(strstr(bytes.data, "end_header\n") + 11 - bytes.data);
    memcpy(bytes.data + records + 17 + 25 + 9, infinity, 8); /* camera, vertex 0, then y and red */
    mesh_refused(context, nph_ply_read, mesh_file("infinite.ply", bytes.data, bytes.size),
                 "x of vertex 1 is not finite|byte ");
    nph_test_context_close(context);
}
END_TEST

START_TEST(no_beginning_and_no_changed_byte_is_dangerous) {
    NphContext *context = nph_test_context(1);
    Bytes bytes;
    build(&bytes, _i, 6, 1, 4);
    mesh_hostile(context, nph_ply_read, "hostile.ply", bytes.data, bytes.size);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_failed_allocation_leaks_nothing) {
    Bytes bytes;
    build(&bytes, 2, 6, 1, 4);
    for (int fail = 1; fail < 10; fail++) {
        NphSettings settings;
        NphContext *context = NULL;
        NphTriangles mesh;
        nph_settings_default(&settings);
        settings.threads = 1;
        settings.fail_allocation = (uint64_t)fail;
        ck_assert_int_eq(nph_context_open(&context, &settings), NPH_OK);
        NphStatus status = nph_ply_read(context, mesh_file("memory.ply", bytes.data, bytes.size), &mesh);
        if (status == NPH_OK) nph_triangles_free(context, &mesh);
        else ck_assert_int_eq(status, NPH_NO_MEMORY);
        ck_assert(fail > 1 || status == NPH_NO_MEMORY);
        ck_assert_uint_eq(nph_context_bytes(context), 0);
        nph_context_close(context);
    }
}
END_TEST

static void fill(TCase *tcase) {
    tcase_add_test(tcase, every_format_and_number_type_gives_the_same_mesh);
    tcase_add_test(tcase, numbers_keep_every_bit);
    tcase_add_loop_test(tcase, mistakes_are_refused_with_their_place, 0, sizeof mistakes / sizeof mistakes[0]);
    tcase_add_test(tcase, infinite_positions_of_binary_files_are_refused);
    tcase_add_loop_test(tcase, no_beginning_and_no_changed_byte_is_dangerous, 0, 3);
    tcase_add_test(tcase, a_failed_allocation_leaks_nothing);
}

int main(void) { return nph_test_main("ply", fill); }
