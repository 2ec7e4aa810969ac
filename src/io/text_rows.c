/* SPDX-License-Identifier: Apache-2.0
 *
 * Rows of numbers, line by line; memory is bounded by the number of lines. */
#include "io/text_rows.h"

#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/text.h"
#include "io/file.h"
#include "io/printable.h"

enum { SHOWN = NPH_DOUBLE_TEXT, MOST_ROWS = 1 << 24 };

typedef struct Line {
    NphContext *context;
    const char *path;
    const NphTextRows *form;
    long long number;      /* from 1 */
    const char *at, *stop; /* without comment and outer blanks */
} Line;

static int blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

static void trim(const char **at, const char **stop) {
    while (*at < *stop && blank(**at)) ++*at;
    while (*stop > *at && blank((*stop)[-1])) --*stop;
}

/* One number, from *at to the next blank or comma. */
static NphStatus take(const Line *line, const char *what, const char **at, double *value) {
    char shown[SHOWN];
    const char *begin = *at, *end = begin;
    while (end < line->stop && !blank(*end) && *end != ',') end++;
    if (begin == line->stop)
        return nph_error(line->context, NPH_BAD_INPUT, "%s:%lld: the line ends before the %s; a row is %s", line->path,
                         line->number, what, line->form->row);
    if (!nph_parse_double_range(begin, end, value))
        return nph_error(line->context, NPH_BAD_INPUT, "%s:%lld: the %s is '%s', not a finite number", line->path,
                         line->number, what, nph_printable(begin, (size_t)(end - begin), shown, sizeof shown));
    *at = end;
    return NPH_OK;
}

/* Blanks, at most one comma, blanks. */
static const char *skip_separator(const char *at, const char *stop) {
    while (at < stop && blank(*at)) at++;
    if (at < stop && *at == ',') at++;
    while (at < stop && blank(*at)) at++;
    return at;
}

static NphStatus read_row(const Line *line, double *row) {
    char shown[SHOWN];
    const NphTextRows *form = line->form;
    const char *at = line->at;
    for (int c = 0; c < form->column_count; c++) {
        if (c > 0) at = skip_separator(at, line->stop);
        NPH_TRY(take(line, form->columns[c], &at, &row[c]));
    }
    while (at < line->stop && blank(*at)) at++;
    if (at < line->stop && !form->more)
        return nph_error(line->context, NPH_BAD_INPUT, "%s:%lld: '%s' follows the %s; a row is %s", line->path, line->number,
                         nph_printable(at, (size_t)(line->stop - at), shown, sizeof shown),
                         form->columns[form->column_count - 1], form->row);
    return NPH_OK;
}

static NphStatus read_rows(Line *line, const char *text, size_t size, NphArray *rows) {
    double *row = rows->data;
    int64_t count = 0, columns = line->form->column_count;
    for (const char *next = text, *end = text + size; next < end;) {
        const char *newline = memchr(next, '\n', (size_t)(end - next)), *stop = newline ? newline : end;
        const char *comment = memchr(next, '#', (size_t)(stop - next));
        line->number++;
        line->at = next;
        line->stop = comment ? comment : stop;
        next = newline ? newline + 1 : end;
        trim(&line->at, &line->stop);
        if (line->at == line->stop) continue;
        NPH_TRY(read_row(line, &row[columns * count]));
        NPH_TRY(line->form->check(line->context, line->path, line->number, &row[columns * count],
                                  count > 0 ? &row[columns * (count - 1)] : NULL));
        if (count++ == MOST_ROWS)
            return nph_error(line->context, NPH_BAD_INPUT, "%s:%lld: more than %d rows", line->path, line->number,
                             (int)MOST_ROWS);
    }
    if (count < 2)
        return nph_error(line->context, NPH_BAD_INPUT, "%s: has %d rows of %s; at least 2 are needed", line->path, (int)count,
                         line->form->row);
    rows->shape[0] = count;
    return NPH_OK;
}

NphStatus nph_text_rows_read(NphContext *context, const char *path, const NphTextRows *form, NphArray *rows) {
    char *text = NULL;
    size_t size = 0;
    NphArray made = {0};
    Line line = {.context = context, .path = path, .form = form};
    NPH_TRY(nph_file_read(context, path, &text, &size));
    int64_t lines = 1;
    for (size_t i = 0; i < size; i++) lines += text[i] == '\n';
    const char *nul = size ? memchr(text, 0, size) : NULL;
    NphStatus status = nul ? nph_error(context, NPH_BAD_INPUT, "%s: byte %lld: holds a NUL byte, so it is not text", path,
                                       (long long)(nul - text))
                           : nph_array_new(context, NPH_F64, 2, (int64_t[]){lines, form->column_count}, path, &made);
    if (status == NPH_OK) status = read_rows(&line, text, size, &made);
    nph_free(context, text);
    if (status == NPH_OK) *rows = made;
    else nph_array_free(context, &made);
    return status;
}
