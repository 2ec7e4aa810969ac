/* SPDX-License-Identifier: Apache-2.0
 *
 * Density grids out of pbrt's text. What is understood, everything else being stepped over:
 *     file      = { word | string | '[' | ']' | medium }         '#' to the end of the line: comment
 *     medium    = MakeNamedMedium string { parameter }           ends at the next word
 *     parameter = "type name" ( value | '[' { value } ']' )      value: number, word or string
 * of the parameters "string type", "integer nx", ny, nz (left out: 1), "point3 p0", p1 (or point; left out: 0, 1) and
 * "float density" with nx ny nz values, x fastest. Sources: pbrt-v4's file format and media.cpp (uniformgrid), the same
 * of pbrt-v3 (heterogeneous): sample (x, y, z) is the middle of cell (x, y, z) of the box p0 to p1. */
#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/text.h"
#include "io/file.h"
#include "io/printable.h"
#include "io/volume.h"

enum { SHOWN = 64 };

typedef enum TokenKind { TOKEN_END, TOKEN_WORD, TOKEN_STRING, TOKEN_OPEN, TOKEN_CLOSE } TokenKind;

typedef struct Token {
    TokenKind kind;
    const char *begin, *end; /* of a string: what stands between the quotes */
    long long line;
} Token;

typedef struct Medium {
    Token name, type;
    int64_t n[3];       /* 0: not given */
    double corner[2][3];
    int has_corner[2];
    int64_t density_count; /* -1: not given */
    Token density;         /* the first value, or the bracket that closes an empty list */
    int moved;             /* a transform stands before it */
} Medium;

typedef struct Parser {
    NphContext *context;
    const char *path, *at, *end;
    long long line;
    Token token; /* the one looked at */
    int moved, includes;
    Medium *media;
    int64_t count, capacity;
} Parser;

static NphStatus refuse(const Parser *parser, long long line, const char *format, ...) NPH_PRINTF(3, 4);
static NphStatus refuse(const Parser *parser, long long line, const char *format, ...) {
    char text[600];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return nph_error(parser->context, NPH_BAD_INPUT, "%s:%lld: %s", parser->path, line, text);
}

static const char *show(const Token *token, char shown[SHOWN]) {
    return nph_printable(token->begin, (size_t)(token->end - token->begin), shown, SHOWN);
}

static int is(const Token *token, const char *word) {
    size_t length = strlen(word);
    return (size_t)(token->end - token->begin) == length && memcmp(token->begin, word, length) == 0;
}

static int blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

/* ---- tokens ---- */

static NphStatus next_string(Parser *parser) {
    const char *at = parser->at + 1;
    while (at < parser->end && *at != '"' && *at != '\n') at += *at == '\\' && at + 1 < parser->end && at[1] != '\n' ? 2 : 1;
    if (at >= parser->end || *at != '"') return refuse(parser, parser->line, "a quoted text does not end on its line");
    parser->token = (Token){TOKEN_STRING, parser->at + 1, at, parser->line};
    parser->at = at + 1;
    return NPH_OK;
}

static NphStatus next(Parser *parser) {
    for (; parser->at < parser->end; parser->at++) {
        if (*parser->at == '#')
            while (parser->at < parser->end && *parser->at != '\n') parser->at++;
        if (parser->at == parser->end || !blank(*parser->at)) break;
        parser->line += *parser->at == '\n';
    }
    const char *begin = parser->at;
    parser->token = (Token){TOKEN_END, begin, begin, parser->line};
    if (begin == parser->end) return NPH_OK;
    if (*begin == '"') return next_string(parser);
    if (*begin == '[' || *begin == ']') {
        parser->token.kind = *begin == '[' ? TOKEN_OPEN : TOKEN_CLOSE;
        parser->at++;
    } else {
        parser->token.kind = TOKEN_WORD;
        while (parser->at < parser->end && !blank(*parser->at) && !strchr("\"[]#", *parser->at)) parser->at++;
    }
    parser->token.end = parser->at;
    return NPH_OK;
}

/* ---- parameters ---- */

typedef struct Values {
    Token first; /* the closing bracket of an empty list */
    int64_t count;
} Values;

/* Steps over the value or values of a parameter. */
static NphStatus skip_values(Parser *parser, const Token *parameter, Values *values) {
    char shown[SHOWN];
    int list = parser->token.kind == TOKEN_OPEN;
    if (list) NPH_TRY(next(parser));
    values->first = parser->token;
    for (values->count = 0; parser->token.kind == TOKEN_WORD || parser->token.kind == TOKEN_STRING;) {
        values->count++;
        NPH_TRY(next(parser));
        if (!list) return NPH_OK;
    }
    if (!list) return refuse(parser, parameter->line, "the parameter \"%s\" has no value", show(parameter, shown));
    if (parser->token.kind != TOKEN_CLOSE)
        return refuse(parser, parser->token.line, "%s within the list of \"%s\", which began in line %lld",
                      parser->token.kind == TOKEN_OPEN ? "a second [" : "the file ends", show(parameter, shown),
                      parameter->line);
    return next(parser);
}

/* Goes back to where values were found; returns what was looked at. */
static Parser values_of(const Parser *parser, const Token *first) {
    Parser back = *parser;
    back.token = *first;
    back.at = first->end + (first->kind == TOKEN_STRING);
    back.line = first->line;
    return back;
}

static NphStatus take_number(Parser *parser, const char *what, double *number) {
    char shown[SHOWN];
    if (parser->token.kind != TOKEN_WORD ||
        !nph_parse_double_range(parser->token.begin, parser->token.end, number))
        return refuse(parser, parser->token.line, "%s is '%s', not a finite number", what, show(&parser->token, shown));
    return next(parser);
}

static NphStatus need_count(const Parser *parser, const Token *parameter, const Values *values, int64_t count) {
    char shown[SHOWN];
    if (values->count == count) return NPH_OK;
    return refuse(parser, parameter->line, "\"%s\" has %lld values; %lld is right", show(parameter, shown),
                  (long long)values->count, (long long)count);
}

static NphStatus read_size(const Parser *parser, const Token *parameter, const Values *values, int64_t *size) {
    char shown[SHOWN], value[SHOWN];
    NPH_TRY(need_count(parser, parameter, values, 1));
    int64_t number = 0;
    if (values->first.kind == TOKEN_WORD && nph_parse_int_range(values->first.begin, values->first.end, &number) &&
        number >= 1 && number <= INT32_MAX) {
        *size = number;
        return NPH_OK;
    }
    return refuse(parser, values->first.line, "\"%s\" is '%s', not a whole number from 1 to 2147483647",
                  show(parameter, shown), show(&values->first, value));
}

static NphStatus read_corner(const Parser *parser, const Token *parameter, const Values *values, double corner[3]) {
    NPH_TRY(need_count(parser, parameter, values, 3));
    Parser back = values_of(parser, &values->first);
    double made[3];
    for (int axis = 0; axis < 3; axis++) NPH_TRY(take_number(&back, "a corner of the box", &made[axis]));
    memcpy(corner, made, sizeof made);
    return NPH_OK;
}

/* "type name" with any blanks between and around. */
static int split(const Token *parameter, Token *type, Token *name) {
    Token *parts[2] = {type, name};
    const char *at = parameter->begin;
    for (int i = 0; i < 2; i++) {
        while (at < parameter->end && blank(*at)) at++;
        parts[i]->begin = at;
        while (at < parameter->end && !blank(*at)) at++;
        parts[i]->end = at;
        parts[i]->line = parameter->line;
    }
    while (at < parameter->end && blank(*at)) at++;
    return at == parameter->end && name->begin < name->end;
}

static NphStatus read_parameter(Parser *parser, Medium *medium) {
    static const char *const sizes[3] = {"nx", "ny", "nz"}, *const corners[2] = {"p0", "p1"};
    Token parameter = parser->token, type, name;
    Values values;
    char shown[SHOWN];
    int twice = 0;
    if (!split(&parameter, &type, &name))
        return refuse(parser, parameter.line, "\"%s\" stands where a parameter, \"type name\", belongs",
                      show(&parameter, shown));
    NPH_TRY(next(parser));
    NPH_TRY(skip_values(parser, &parameter, &values));
    for (int axis = 0; axis < 3; axis++) {
        if (!is(&type, "integer") || !is(&name, sizes[axis])) continue;
        twice = medium->n[axis] != 0;
        NPH_TRY(read_size(parser, &parameter, &values, &medium->n[axis]));
    }
    for (int i = 0; i < 2; i++) {
        if (!(is(&type, "point3") || is(&type, "point")) || !is(&name, corners[i])) continue;
        twice = medium->has_corner[i]++;
        NPH_TRY(read_corner(parser, &parameter, &values, medium->corner[i]));
    }
    if (is(&type, "string") && is(&name, "type")) {
        twice = medium->type.begin != NULL;
        NPH_TRY(need_count(parser, &parameter, &values, 1));
        medium->type = values.first;
    }
    if (is(&type, "float") && is(&name, "density")) {
        twice = medium->density_count >= 0;
        medium->density = values.first;
        medium->density_count = values.count;
    }
    return twice ? refuse(parser, parameter.line, "\"%s\" is given a second time", show(&parameter, shown)) : NPH_OK;
}

/* ---- media ---- */

static NphStatus read_medium(Parser *parser) {
    Medium medium = {.corner = {{0, 0, 0}, {1, 1, 1}}, .density_count = -1, .moved = parser->moved};
    NPH_TRY(next(parser));
    if (parser->token.kind != TOKEN_STRING)
        return refuse(parser, parser->token.line, "MakeNamedMedium is not followed by a quoted name");
    medium.name = parser->token;
    NPH_TRY(next(parser));
    while (parser->token.kind == TOKEN_STRING) NPH_TRY(read_parameter(parser, &medium));
    if (parser->count == parser->capacity) {
        int64_t capacity = parser->capacity ? 2 * parser->capacity : 8;
        NPH_TRY(nph_realloc(parser->context, (size_t)capacity, sizeof *parser->media, "pbrt media",
                            (void **)&parser->media));
        parser->capacity = capacity;
    }
    parser->media[parser->count++] = medium;
    return NPH_OK;
}

static int is_transform(const Token *word) {
    static const char *const words[] = {"Translate", "Rotate", "Scale", "LookAt", "Transform", "ConcatTransform",
                                        "CoordSysTransform"};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (is(word, words[i])) return 1;
    return 0;
}

static NphStatus read_media(Parser *parser, size_t size) {
    if (size == 0) return nph_error(parser->context, NPH_BAD_INPUT, "%s: is empty", parser->path);
    const char *nul = memchr(parser->at, 0, size);
    if (nul)
        return nph_error(parser->context, NPH_BAD_INPUT, "%s: byte %lld: holds a NUL byte, so it is not text",
                         parser->path, (long long)(nul - parser->at));
    NPH_TRY(next(parser));
    while (parser->token.kind != TOKEN_END) {
        const Token *token = &parser->token;
        if (token->kind == TOKEN_WORD && is(token, "MakeNamedMedium")) {
            NPH_TRY(read_medium(parser));
            continue;
        }
        if (token->kind == TOKEN_WORD) {
            parser->moved |= is_transform(token);
            if (is(token, "WorldBegin") || is(token, "Identity")) parser->moved = 0;
            parser->includes |= is(token, "Include") || is(token, "Import");
        }
        NPH_TRY(next(parser));
    }
    return NPH_OK;
}

static NphStatus open_parser(NphContext *context, const char *path, char **bytes, Parser *parser) {
    size_t size = 0;
    NPH_TRY(nph_file_read(context, path, bytes, &size));
    *parser = (Parser){.context = context, .path = path, .at = *bytes, .end = *bytes + size, .line = 1};
    NphStatus status = read_media(parser, size);
    if (status != NPH_OK) {
        nph_free(context, parser->media);
        nph_free(context, *bytes);
    }
    return status;
}

static int is_grid(const Medium *medium) {
    return medium->type.begin && (is(&medium->type, "uniformgrid") || is(&medium->type, "heterogeneous"));
}

/* "'cloud' (uniformgrid), 'air' (homogeneous)" as far as it fits. */
static void list_names(const Parser *parser, char *text, size_t capacity) {
    char name[SHOWN], type[SHOWN];
    size_t used = (size_t)snprintf(text, capacity, "%s", parser->count ? "" : "no medium");
    for (int64_t i = 0; i < parser->count && used < capacity; i++) {
        const Medium *medium = &parser->media[i];
        int written = snprintf(text + used, capacity - used, "%s'%s' (%s)", i ? ", " : "", show(&medium->name, name),
                               medium->type.begin ? show(&medium->type, type) : "no type");
        used += written > 0 ? (size_t)written : 0;
    }
}

static NphStatus choose(const Parser *parser, const char *wanted, const Medium **chosen) {
    char names[400], shown[SHOWN];
    const char *name = wanted ? wanted : "density";
    int64_t grids = 0, found = 0;
    for (int64_t i = 0; i < parser->count; i++) grids += is_grid(&parser->media[i]);
    for (int64_t i = 0; i < parser->count; i++) {
        const Medium *medium = &parser->media[i];
        int match = is(&medium->name, name) || (!wanted && grids == 1 && is_grid(medium));
        if (!match || (!wanted && !is_grid(medium))) continue;
        *chosen = medium;
        found++;
    }
    list_names(parser, names, sizeof names);
    nph_printable(name, strlen(name), shown, sizeof shown);
    if (found == 0)
        return nph_error(parser->context, NPH_BAD_INPUT, "%s: has no medium '%s'%s; it holds %s%s", parser->path, shown,
                         wanted ? "" : " of type uniformgrid or heterogeneous (the default; choose one by name)", names,
                         parser->includes ? " (the files it includes are not read)" : "");
    if (found > 1)
        return nph_error(parser->context, NPH_BAD_INPUT, "%s: has %lld media named '%s'; it holds %s", parser->path,
                         (long long)found, shown, names);
    if (is_grid(*chosen)) return NPH_OK;
    return refuse(parser, (*chosen)->name.line, "the medium '%s' is of the type '%s'; uniformgrid and heterogeneous are read",
                  shown, (*chosen)->type.begin ? show(&(*chosen)->type, names) : "");
}

/* The number of values is known to be nx ny nz, so the array is no larger than twice the file. */
static NphStatus read_density(const Parser *parser, const Medium *medium, NphArray *array) {
    Parser back = values_of(parser, &medium->density);
    for (int64_t i = 0; i < medium->density_count; i++) {
        double number = 0;
        long long line = back.token.line;
        NPH_TRY(take_number(&back, "a density", &number));
        if (fabs(number) > FLT_MAX)
            return refuse(parser, line, "density value %lld lies beyond float32's range", (long long)i + 1);
        ((float *)array->data)[i] = (float)number;
    }
    return NPH_OK;
}

static NphStatus read_grid(const Parser *parser, const Medium *medium, NphBoxGrid *grid) {
    char shown[SHOWN], text[2][NPH_DOUBLE_TEXT];
    int64_t n[3], left = medium->density_count;
    show(&medium->name, shown);
    if (left < 0)
        return refuse(parser, medium->name.line, "the medium '%s' has no \"float density\"", shown);
    for (int axis = 0; axis < 3; axis++) {
        double lo = medium->corner[0][axis], hi = medium->corner[1][axis];
        n[axis] = medium->n[axis] ? medium->n[axis] : 1;
        left = left % n[axis] == 0 && left > 0 ? left / n[axis] : 0;
        if (!(lo < hi) || !isfinite(hi - lo))
            return refuse(parser, medium->name.line, "the box of '%s' from %s to %s along %c is no rising range", shown,
                          nph_format_double(lo, text[0]), nph_format_double(hi, text[1]), "xyz"[axis]);
        grid->lo[axis] = lo;
        grid->hi[axis] = hi;
    }
    if (left != 1)
        return refuse(parser, medium->density.line, "'%s' has %lld density values; nx ny nz = %lld x %lld x %lld", shown,
                      (long long)medium->density_count, (long long)n[0], (long long)n[1], (long long)n[2]);
    int64_t shape[3] = {n[2], n[1], n[0]};
    NPH_TRY(nph_array_new(parser->context, NPH_F32, 3, shape, parser->path, &grid->values));
    return read_density(parser, medium, &grid->values);
}

NphStatus nph_pbrt_read(NphContext *context, const char *path, const char *name, NphBoxGrid *grid) {
    char *bytes = NULL, shown[SHOWN];
    Parser parser;
    const Medium *medium = NULL;
    NphBoxGrid made = {0};
    NPH_TRY(open_parser(context, path, &bytes, &parser));
    NphStatus status = choose(&parser, name, &medium);
    if (status == NPH_OK) status = read_grid(&parser, medium, &made);
    if (status == NPH_OK && medium->moved)
        nph_warn(context, "%s:%lld: a transform stands before the medium '%s'; it is not applied to its box", path,
                 medium->name.line, show(&medium->name, shown));
    if (status != NPH_OK) nph_box_grid_free(context, &made);
    else *grid = made;
    nph_free(context, parser.media);
    nph_free(context, bytes);
    return status;
}

NphStatus nph_pbrt_list(NphContext *context, const char *path, NphPbrtInfo **media, int *count) {
    char *bytes = NULL;
    Parser parser;
    NphPbrtInfo *made = NULL;
    NPH_TRY(open_parser(context, path, &bytes, &parser));
    NphStatus status = NPH_NEW(context, parser.count, "list of media", &made);
    for (int64_t i = 0; status == NPH_OK && i < parser.count; i++) {
        const Medium *medium = &parser.media[i];
        show(&medium->name, made[i].name);
        if (medium->type.begin)
            nph_printable(medium->type.begin, (size_t)(medium->type.end - medium->type.begin), made[i].type,
                          sizeof made[i].type);
        made[i].readable = is_grid(medium);
    }
    if (status == NPH_OK) {
        *media = made;
        *count = (int)parser.count;
    }
    nph_free(context, parser.media);
    nph_free(context, bytes);
    return status;
}
