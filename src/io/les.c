/* SPDX-License-Identifier: Apache-2.0
 *
 * Cloud fields of large-eddy simulations as text: liquid water content in g/m3 and effective radius in um on a lattice.
 * Two layouts, told apart by the commas of the line with the sizes:
 *     comma separated    nx,ny,nz / dx,dy [km] / altitudes [km] / i,j,k,lwc,reff / a row per non-empty point
 *     SHDOM              nx ny nz / dx dy altitudes [km] / a row per point, all of them
 * Indices count from 0. '#' starts a comment anywhere, empty lines are skipped. Lengths become metres. */
#include <assert.h>
#include <float.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/text.h"
#include "io/file.h"
#include "io/printable.h"
#include "io/volume.h"

/* A lattice of more cells than this per byte of its file is not believed: it would only allocate. */
enum { CELLS_PER_BYTE = 256, TOKEN_SHOWN = 32, ROW_TOKENS = 5 };
static const float unset = -1.0f; /* water content of a point that no row named yet */

typedef struct Reader {
    NphContext *context;
    const char *path;
    const char *next, *end; /* of the file */
    long long line;         /* number of the current line, from 1 */
    const char *at, *stop;  /* rest of the current line without its comment */
    int commas;             /* comma separated? */
    int64_t n[3];           /* nx, ny, nz */
    NphLes les;
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

static int blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/* Moves to the next line that says something; 0 at the end of the file. */
static int next_line(Reader *reader) {
    while (reader->next < reader->end) {
        size_t left = (size_t)(reader->end - reader->next);
        const char *newline = memchr(reader->next, '\n', left), *stop = newline ? newline : reader->end;
        const char *comment = memchr(reader->next, '#', (size_t)(stop - reader->next));
        reader->at = reader->next;
        reader->stop = comment ? comment : stop;
        reader->next = newline ? newline + 1 : reader->end;
        reader->line++;
        while (reader->at < reader->stop && blank(*reader->at)) reader->at++;
        while (reader->stop > reader->at && blank(reader->stop[-1])) reader->stop--;
        if (reader->at < reader->stop) return 1;
    }
    return 0;
}

/* The next value of the line, without blanks around it; 0 when there is none. An empty value between commas is given
 * as such, so that it is refused as a number. */
static int next_token(Reader *reader, const char **begin, const char **end) {
    if (reader->at >= reader->stop) return 0;
    const char *at = reader->at;
    if (reader->commas) {
        const char *comma = memchr(at, ',', (size_t)(reader->stop - at));
        *end = comma ? comma : reader->stop;
        reader->at = comma ? comma + 1 : reader->stop;
    } else {
        while (at < reader->stop && !blank(*at)) at++;
        *end = at;
        at = reader->at;
        reader->at = *end;
        while (reader->at < reader->stop && blank(*reader->at)) reader->at++;
    }
    while (at < *end && blank(*at)) at++;
    while (*end > at && blank((*end)[-1])) (*end)--;
    *begin = at;
    return 1;
}

static NphStatus take(Reader *reader, const char *what, const char **begin, const char **end) {
    return next_token(reader, begin, end) ? NPH_OK : refuse(reader, "the line ends before %s", what);
}

static NphStatus take_int(Reader *reader, const char *what, int64_t *value) {
    const char *begin = NULL, *end = NULL;
    char shown[TOKEN_SHOWN];
    NPH_TRY(take(reader, what, &begin, &end));
    if (nph_parse_int_range(begin, end, value)) return NPH_OK;
    return refuse(reader, "%s is '%s', not a whole number", what,
                  nph_printable(begin, (size_t)(end - begin), shown, sizeof shown));
}

/* Kilometres to metres by the decimal exponent: 0.56 becomes 560 exactly, where 0.56 * 1000 is not. */
static int parse_km(const char *begin, const char *end, double *metres) {
    char text[NPH_NUMBER_MAX + 1];
    size_t length = (size_t)(end - begin);
    const char *e = begin;
    int64_t exponent = 0;
    if (length > 64 || !nph_is_decimal(begin, end)) return 0;
    while (e < end && *e != 'e' && *e != 'E') e++;
    if (e < end && !nph_parse_int_range(e + 1, end, &exponent)) return 0;
    if (exponent < -1000 || exponent > 1000) return 0;
    snprintf(text, sizeof text, "%.*se%d", (int)(e - begin), begin, (int)exponent + 3);
    return nph_parse_double(text, metres);
}

static NphStatus take_number(Reader *reader, const char *what, int kilometres, double *value) {
    const char *begin = NULL, *end = NULL;
    char shown[TOKEN_SHOWN];
    NPH_TRY(take(reader, what, &begin, &end));
    if (kilometres ? parse_km(begin, end, value) : nph_parse_double_range(begin, end, value)) return NPH_OK;
    return refuse(reader, "%s is '%s', not a finite number", what,
                  nph_printable(begin, (size_t)(end - begin), shown, sizeof shown));
}

static NphStatus line_ends(Reader *reader, const char *behind) {
    if (reader->at >= reader->stop) return NPH_OK;
    char shown[TOKEN_SHOWN];
    return refuse(reader, "'%s' follows %s",
                  nph_printable(reader->at, (size_t)(reader->stop - reader->at), shown, sizeof shown), behind);
}

static NphStatus need_line(Reader *reader, const char *what) {
    return next_line(reader) ? NPH_OK : refuse(reader, "the file ends before %s", what);
}

static NphStatus read_sizes(Reader *reader, size_t bytes) {
    static const char *const names[3] = {"nx", "ny", "nz"};
    NPH_TRY(need_line(reader, "the line nx,ny,nz"));
    assert(reader->at != NULL);
    reader->commas = memchr(reader->at, ',', (size_t)(reader->stop - reader->at)) != NULL;
    uint64_t cells = 1, most = (uint64_t)bytes * CELLS_PER_BYTE;
    for (int axis = 0; axis < 3; axis++) {
        NPH_TRY(take_int(reader, names[axis], &reader->n[axis]));
        if (reader->n[axis] < 1)
            return refuse(reader, "%s is %lld; at least 1 is needed", names[axis], (long long)reader->n[axis]);
        if ((uint64_t)reader->n[axis] > most / cells)
            return refuse(reader, "a lattice of this size cannot come from a file of %zu bytes", bytes);
        cells *= (uint64_t)reader->n[axis];
    }
    NPH_TRY(line_ends(reader, "nz"));
    int64_t shape[3] = {reader->n[2], reader->n[1], reader->n[0]};
    NPH_TRY(nph_array_new(reader->context, NPH_F32, 3, shape, reader->path, &reader->les.lwc_g_per_m3));
    NPH_TRY(nph_array_new(reader->context, NPH_F32, 3, shape, reader->path, &reader->les.reff_um));
    float *lwc = reader->les.lwc_g_per_m3.data;
    for (uint64_t i = 0; i < cells; i++) lwc[i] = unset;
    return nph_array_new(reader->context, NPH_F64, 1, &reader->n[2], reader->path, &reader->les.height_m);
}

static NphStatus read_lengths(Reader *reader) {
    NPH_TRY(need_line(reader, "the line dx,dy"));
    for (int axis = 0; axis < 2; axis++) {
        double *spacing = &reader->les.spacing_m[axis];
        NPH_TRY(take_number(reader, axis ? "dy" : "dx", 1, spacing));
        if (!(*spacing > 0.0)) return refuse(reader, "%s must be greater than 0", axis ? "dy" : "dx");
    }
    if (reader->commas) {
        NPH_TRY(line_ends(reader, "dy"));
        NPH_TRY(need_line(reader, "the line of altitudes"));
    }
    double *height = reader->les.height_m.data;
    for (int64_t k = 0; k < reader->n[2]; k++) {
        char what[64];
        snprintf(what, sizeof what, "altitude %lld of %lld", (long long)k + 1, (long long)reader->n[2]);
        NPH_TRY(take_number(reader, what, 1, &height[k]));
        if (k > 0 && !(height[k] > height[k - 1])) return refuse(reader, "%s does not lie above the one before", what);
    }
    return line_ends(reader, "the last altitude");
}

static NphStatus read_columns(Reader *reader) {
    static const char *const columns[2][ROW_TOKENS] = {{"i", "j", "k", "lwc", "reff"}, {"x", "y", "z", "lwc", "reff"}};
    NPH_TRY(need_line(reader, "the line i,j,k,lwc,reff"));
    int fits[2] = {1, 1};
    for (int c = 0; c < ROW_TOKENS; c++) {
        const char *begin = NULL, *end = NULL;
        NPH_TRY(take(reader, columns[0][c], &begin, &end));
        for (int form = 0; form < 2; form++)
            fits[form] &= strlen(columns[form][c]) == (size_t)(end - begin) &&
                          memcmp(columns[form][c], begin, (size_t)(end - begin)) == 0;
    }
    if (!fits[0] && !fits[1]) return refuse(reader, "the columns must be i,j,k,lwc,reff or x,y,z,lwc,reff");
    return line_ends(reader, "the column reff");
}

static NphStatus check_range(const Reader *reader, const char *what, double value) {
    char text[NPH_DOUBLE_TEXT];
    if (value >= 0 && value <= FLT_MAX) return NPH_OK;
    return refuse(reader, "%s is %s; it must be at least 0 and at most 3.4e38", what, nph_format_double(value, text));
}

static NphStatus read_row(Reader *reader) {
    static const char *const names[3] = {"i", "j", "k"};
    int64_t index[3];
    double lwc = 0, reff = 0;
    for (int axis = 0; axis < 3; axis++) {
        NPH_TRY(take_int(reader, names[axis], &index[axis]));
        if (index[axis] < 0 || index[axis] >= reader->n[axis])
            return refuse(reader, "%s is %lld, not in 0 to %lld", names[axis], (long long)index[axis],
                          (long long)reader->n[axis] - 1);
    }
    NPH_TRY(take_number(reader, "lwc", 0, &lwc));
    NPH_TRY(take_number(reader, "reff", 0, &reff));
    NPH_TRY(line_ends(reader, "reff"));
    NPH_TRY(check_range(reader, "lwc", lwc));
    NPH_TRY(check_range(reader, "reff", reff));
    int64_t place = (index[2] * reader->n[1] + index[1]) * reader->n[0] + index[0];
    float *cell = (float *)reader->les.lwc_g_per_m3.data + place;
    if (*cell != unset)
        return refuse(reader, "point (%lld, %lld, %lld) occurs a second time", (long long)index[0], (long long)index[1],
                      (long long)index[2]);
    *cell = lwc > 0 ? (float)lwc : 0.0f; /* -0 becomes 0 */
    ((float *)reader->les.reff_um.data)[place] = reff > 0 ? (float)reff : 0.0f;
    return NPH_OK;
}

static NphStatus read_rows(Reader *reader) {
    int64_t rows = 0, cells = reader->n[0] * reader->n[1] * reader->n[2];
    for (; next_line(reader); rows++) NPH_TRY(read_row(reader));
    if (rows == 0) return refuse(reader, "the file ends without a row of values");
    if (!reader->commas && rows != cells)
        return refuse(reader, "the file ends after %lld rows; this layout has one for each of its %lld points",
                      (long long)rows, (long long)cells);
    float *lwc = reader->les.lwc_g_per_m3.data;
    for (int64_t i = 0; i < cells; i++)
        if (lwc[i] == unset) lwc[i] = 0.0f;
    return NPH_OK;
}

static NphStatus read_text(Reader *reader, size_t bytes) {
    if (bytes == 0) return nph_error(reader->context, NPH_BAD_INPUT, "%s: is empty", reader->path);
    const char *nul = memchr(reader->next, 0, bytes);
    if (nul)
        return nph_error(reader->context, NPH_BAD_INPUT, "%s: byte %lld: holds a NUL byte, so it is not text",
                         reader->path, (long long)(nul - reader->next));
    NPH_TRY(read_sizes(reader, bytes));
    NPH_TRY(read_lengths(reader));
    if (reader->commas) NPH_TRY(read_columns(reader));
    NPH_TRY(read_rows(reader));
    if (reader->end[-1] != '\n')
        return refuse(reader, "the last line does not end; the file was cut, or a line feed is missing");
    return NPH_OK;
}

NphStatus nph_les_read(NphContext *context, const char *path, NphLes *les) {
    char *bytes = NULL;
    size_t size = 0;
    NPH_TRY(nph_file_read(context, path, &bytes, &size));
    Reader reader = {.context = context, .path = path, .next = bytes, .end = bytes + size};
    NphStatus status = read_text(&reader, size);
    nph_free(context, bytes);
    if (status != NPH_OK) nph_les_free(context, &reader.les);
    else *les = reader.les;
    return status;
}

void nph_les_free(NphContext *context, NphLes *les) {
    nph_array_free(context, &les->lwc_g_per_m3);
    nph_array_free(context, &les->reff_um);
    nph_array_free(context, &les->height_m);
    memset(les, 0, sizeof *les);
}
