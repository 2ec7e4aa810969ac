/* SPDX-License-Identifier: Apache-2.0
 *
 * Wavefront OBJ. The file is walked twice: first to count vertices and triangles, so that a corner may name a vertex
 * that stands further down and memory is asked for once; then to read. A line that ends in a backslash goes on in the
 * next one; '#' starts a comment. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/text.h"
#include "io/file.h"
#include "io/printable.h"
#include "io/triangles.h"

enum { TOKEN_SHOWN = 32, IGNORED_NAMES = 12, NAME_SHOWN = 16, VERTEX_NUMBERS = 7 };

typedef struct Reader {
    NphContext *context;
    const char *path;
    const char *next, *end; /* of the file */
    long long line, lines;  /* number of the statement's first line, from 1; lines behind us */
    const char *at, *stop;  /* rest of the statement without its comment */
    int64_t vertex_count, triangle_count;
    int64_t vertex, triangle; /* read so far */
    char ignored[IGNORED_NAMES][NAME_SHOWN];
    int ignored_count, ignored_more;
    NphTriangles mesh;
} Reader;

static NphStatus refuse(const Reader *reader, const char *format, ...) NPH_PRINTF(2, 3);
static NphStatus refuse(const Reader *reader, const char *format, ...) {
    char text[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return nph_error(reader->context, NPH_BAD_INPUT, "%s:%lld: %s", reader->path, reader->line, text);
}

/* Characters of the blank at `at`: 1, or those of a backslash with its line's end; 0 when it is none. */
static int blank(const char *at, const char *stop) {
    if (*at == ' ' || *at == '\t' || *at == '\r' || *at == '\n') return 1;
    if (*at != '\\') return 0;
    if (stop - at >= 2 && at[1] == '\n') return 2;
    return stop - at >= 3 && at[1] == '\r' && at[2] == '\n' ? 3 : 0;
}

static void skip_blanks(Reader *reader) {
    while (reader->at < reader->stop) {
        int count = blank(reader->at, reader->stop);
        if (!count) return;
        reader->at += count;
    }
}

/* Moves to the next statement; 0 at the end of the file. */
static int next_statement(Reader *reader) {
    while (reader->next < reader->end) {
        const char *from = reader->next, *comment = NULL, *stop;
        reader->at = from;
        reader->line = reader->lines + 1;
        for (;;) { /* the lines of one statement */
            const char *newline = memchr(from, '\n', (size_t)(reader->end - from));
            stop = newline ? newline : reader->end;
            comment = memchr(from, '#', (size_t)(stop - from));
            reader->next = newline ? newline + 1 : reader->end;
            reader->lines++;
            const char *last = stop > from && stop[-1] == '\r' ? stop - 1 : stop;
            if (comment || !newline || last == from || last[-1] != '\\') break;
            from = reader->next;
        }
        reader->stop = comment ? comment : stop;
        skip_blanks(reader);
        if (reader->at < reader->stop) return 1;
    }
    return 0;
}

static int next_token(Reader *reader, const char **begin, const char **end) {
    if (reader->at >= reader->stop) return 0;
    *begin = reader->at;
    while (reader->at < reader->stop && !blank(reader->at, reader->stop)) reader->at++;
    *end = reader->at;
    skip_blanks(reader);
    return 1;
}

static void rewind_file(Reader *reader, const char *bytes) {
    reader->next = bytes;
    reader->lines = 0;
}

static int is(const char *begin, const char *end, const char *word) {
    return (size_t)(end - begin) == strlen(word) && memcmp(begin, word, strlen(word)) == 0;
}

static void remember_ignored(Reader *reader, const char *begin, const char *end) {
    char name[NAME_SHOWN];
    nph_printable(begin, (size_t)(end - begin), name, sizeof name);
    for (int i = 0; i < reader->ignored_count; i++)
        if (strcmp(reader->ignored[i], name) == 0) return;
    if (reader->ignored_count == IGNORED_NAMES) reader->ignored_more = 1;
    else memcpy(reader->ignored[reader->ignored_count++], name, sizeof name);
}

static void warn_ignored(const Reader *reader) {
    char names[IGNORED_NAMES * (NAME_SHOWN + 2) + 8] = "";
    for (int i = 0; i < reader->ignored_count; i++) {
        strcat(names, i ? ", " : "");
        strcat(names, reader->ignored[i]);
    }
    if (reader->ignored_count)
        nph_warn(reader->context, "%s: statements left out (v and f are read): %s%s", reader->path, names,
                 reader->ignored_more ? ", ..." : "");
}

static NphStatus count_statements(Reader *reader) {
    while (next_statement(reader)) {
        const char *begin = NULL, *end = NULL;
        next_token(reader, &begin, &end);
        if (is(begin, end, "v")) {
            reader->vertex_count++;
        } else if (is(begin, end, "f")) {
            int64_t corners = 0;
            while (next_token(reader, &begin, &end)) corners++;
            if (corners >= 3) reader->triangle_count += corners - 2;
        } else {
            remember_ignored(reader, begin, end);
        }
    }
    reader->line = reader->lines;
    if (reader->vertex_count > INT32_MAX || reader->triangle_count > INT32_MAX)
        return refuse(reader, "more than 2147483647 vertices or triangles");
    if (reader->triangle_count == 0) return refuse(reader, "the file has no face (a line such as f 1 2 3)");
    return NPH_OK;
}

static NphStatus read_vertex(Reader *reader) {
    static const char *const names[3] = {"x", "y", "z"};
    double *out = (double *)reader->mesh.vertices.data + 3 * reader->vertex, extra = 0;
    const char *begin = NULL, *end = NULL;
    char shown[TOKEN_SHOWN];
    for (int i = 0; i < VERTEX_NUMBERS; i++) { /* a weight or a colour may follow the position */
        if (!next_token(reader, &begin, &end)) {
            if (i < 3) return refuse(reader, "the vertex ends before %s", names[i]);
            break;
        }
        if (!nph_parse_double_range(begin, end, i < 3 ? &out[i] : &extra))
            return refuse(reader, "%s of vertex %lld is '%s', not a finite number", i < 3 ? names[i] : "an extra value",
                          (long long)reader->vertex + 1,
                          nph_printable(begin, (size_t)(end - begin), shown, sizeof shown));
    }
    if (reader->at < reader->stop) return refuse(reader, "more than %d values follow v", VERTEX_NUMBERS);
    reader->vertex++;
    return NPH_OK;
}

/* a, a/b, a//c or a/b/c: what follows the first slash is checked to be whole numbers and left out. */
static int parse_corner(const char *begin, const char *end, int64_t *index) {
    int64_t other = 0;
    const char *slash = memchr(begin, '/', (size_t)(end - begin));
    if (!nph_parse_int_range(begin, slash ? slash : end, index)) return 0;
    if (!slash) return 1;
    const char *second = slash + 1, *again = memchr(second, '/', (size_t)(end - second));
    if (!again) return nph_parse_int_range(second, end, &other);
    return (again == second || nph_parse_int_range(second, again, &other)) &&
           nph_parse_int_range(again + 1, end, &other);
}

static NphStatus read_corner(const Reader *reader, const char *begin, const char *end, int32_t *corner) {
    char shown[TOKEN_SHOWN];
    int64_t index = 0;
    nph_printable(begin, (size_t)(end - begin), shown, sizeof shown);
    if (!parse_corner(begin, end, &index))
        return refuse(reader, "'%s' is not a corner; a, a/b, a//c or a/b/c with whole numbers is", shown);
    int64_t from_0 = index < 0 ? reader->vertex + index : index - 1;
    if (index == 0 || index < -reader->vertex || from_0 >= reader->vertex_count)
        return refuse(reader, "corner '%s' names no vertex: the file has %lld, %lld of them before this line", shown,
                      (long long)reader->vertex_count, (long long)reader->vertex);
    *corner = (int32_t)from_0;
    return NPH_OK;
}

static NphStatus read_face(Reader *reader) {
    const char *begin = NULL, *end = NULL;
    int32_t first = 0, before = 0, corner = 0;
    int64_t corners = 0;
    for (; next_token(reader, &begin, &end); corners++) {
        NPH_TRY(read_corner(reader, begin, end, &corner));
        if (corners == 0) first = corner;
        if (corners >= 2) {
            int32_t *out = (int32_t *)reader->mesh.triangles.data + 3 * reader->triangle++;
            out[0] = first;
            out[1] = before;
            out[2] = corner;
        }
        before = corner;
    }
    if (corners < 3) return refuse(reader, "a face of %lld corners; at least 3 are needed", (long long)corners);
    return NPH_OK;
}

static NphStatus read_statements(Reader *reader) {
    int64_t shape[2] = {reader->vertex_count, 3};
    NPH_TRY(nph_array_new(reader->context, NPH_F64, 2, shape, reader->path, &reader->mesh.vertices));
    shape[0] = reader->triangle_count;
    NPH_TRY(nph_array_new(reader->context, NPH_I32, 2, shape, reader->path, &reader->mesh.triangles));
    while (next_statement(reader)) {
        const char *begin = NULL, *end = NULL;
        next_token(reader, &begin, &end);
        if (is(begin, end, "v")) NPH_TRY(read_vertex(reader));
        else if (is(begin, end, "f")) NPH_TRY(read_face(reader));
    }
    return NPH_OK;
}

void nph_triangles_free(NphContext *context, NphTriangles *mesh) {
    nph_array_free(context, &mesh->vertices);
    nph_array_free(context, &mesh->triangles);
}

NphStatus nph_obj_read(NphContext *context, const char *path, NphTriangles *mesh) {
    char *bytes = NULL;
    size_t size = 0;
    NPH_TRY(nph_file_read(context, path, &bytes, &size));
    Reader reader = {.context = context, .path = path, .end = bytes + size};
    rewind_file(&reader, bytes);
    NphStatus status = count_statements(&reader);
    rewind_file(&reader, bytes);
    if (status == NPH_OK) status = read_statements(&reader);
    nph_free(context, bytes);
    if (status != NPH_OK) {
        nph_triangles_free(context, &reader.mesh);
        return status;
    }
    warn_ignored(&reader);
    *mesh = reader.mesh;
    return NPH_OK;
}
