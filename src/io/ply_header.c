/* SPDX-License-Identifier: Apache-2.0
 *
 * The text with which every PLY file begins: ply, format, then element and property lines, end_header. */
#include "io/ply_header.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "core/text.h"
#include "io/printable.h"

enum { WORD_SHOWN = 32 };

static const struct {
    const char *name, *other;
    NphType type;
} types[] = {{"char", "int8", NPH_I8},     {"uchar", "uint8", NPH_U8},     {"short", "int16", NPH_I16},
             {"ushort", "uint16", NPH_U16}, {"int", "int32", NPH_I32},      {"uint", "uint32", NPH_U32},
             {"float", "float32", NPH_F32}, {"double", "float64", NPH_F64}};
enum { TYPES = sizeof types / sizeof types[0] };

NphStatus nph_ply_refuse(const NphPlyFile *file, const char *format, ...) {
    char text[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (file->line) return nph_error(file->context, NPH_BAD_INPUT, "%s:%lld: %s", file->path, file->line, text);
    return nph_error(file->context, NPH_BAD_INPUT, "%s: byte %lld: %s", file->path,
                     (long long)(file->at - file->bytes), text);
}

static int is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

int nph_ply_word(NphPlyFile *file, const char **begin, const char **end) {
    const char *at = file->at;
    while (at < file->end && is_blank(*at)) at++;
    *begin = at;
    while (at < file->end && !is_blank(*at) && *at != '\n') at++;
    *end = at;
    file->at = at;
    return *end > *begin;
}

int nph_ply_line_ends(NphPlyFile *file) {
    while (file->at < file->end && is_blank(*file->at)) file->at++;
    if (file->at < file->end && *file->at != '\n') return 0;
    if (file->at < file->end) file->at++;
    file->line++;
    return 1;
}

static void skip_line(NphPlyFile *file) {
    const char *newline = memchr(file->at, '\n', (size_t)(file->end - file->at));
    file->at = newline ? newline + 1 : file->end;
    file->line++;
}

/* Takes a word: 1 when the line has one. It is cut to what a name may have. */
static int take(NphPlyFile *file, char word[NPH_PLY_NAME]) {
    const char *begin = NULL, *end = NULL;
    int found = nph_ply_word(file, &begin, &end);
    nph_printable(begin, (size_t)(end - begin), word, NPH_PLY_NAME);
    return found;
}

static NphStatus take_type(NphPlyFile *file, const char *what, NphType *type) {
    char word[NPH_PLY_NAME];
    take(file, word);
    for (int i = 0; i < TYPES; i++) {
        if (strcmp(word, types[i].name) != 0 && strcmp(word, types[i].other) != 0) continue;
        *type = types[i].type;
        return NPH_OK;
    }
    return nph_ply_refuse(file, "%s is '%s'; char, uchar, short, ushort, int, uint, float or double is needed", what,
                          word);
}

static NphStatus line_ends(NphPlyFile *file) {
    char word[NPH_PLY_NAME];
    if (nph_ply_line_ends(file)) return NPH_OK;
    take(file, word);
    return nph_ply_refuse(file, "'%s' follows what belongs in this line", word);
}

static NphStatus read_format(NphPlyFile *file) {
    static const char *const names[3] = {"ascii", "binary_little_endian", "binary_big_endian"};
    char word[NPH_PLY_NAME], version[NPH_PLY_NAME];
    take(file, word);
    take(file, version);
    for (int i = 0; i < 3; i++) {
        if (strcmp(word, names[i]) != 0 || strcmp(version, "1.0") != 0) continue;
        file->format = (NphPlyFormat)i;
        return line_ends(file);
    }
    return nph_ply_refuse(file, "format '%s %s'; ascii, binary_little_endian or binary_big_endian 1.0 is read", word,
                          version);
}

static NphStatus read_element(NphPlyFile *file) {
    const char *begin = NULL, *end = NULL;
    NphPlyElement element = {.first = file->property_count};
    char shown[WORD_SHOWN];
    if (file->element_count == NPH_PLY_ELEMENTS)
        return nph_ply_refuse(file, "more than %d elements", NPH_PLY_ELEMENTS);
    if (!take(file, element.name)) return nph_ply_refuse(file, "an element without a name");
    for (int i = 0; i < file->element_count; i++)
        if (strcmp(file->elements[i].name, element.name) == 0)
            return nph_ply_refuse(file, "element %s stands here twice", element.name);
    nph_ply_word(file, &begin, &end);
    if (!nph_parse_int_range(begin, end, &element.count) || element.count < 0)
        return nph_ply_refuse(file, "the number of element %s is '%s', not a whole number of at least 0", element.name,
                              nph_printable(begin, (size_t)(end - begin), shown, sizeof shown));
    file->elements[file->element_count++] = element;
    return line_ends(file);
}

static NphStatus read_property(NphPlyFile *file) {
    NphPlyProperty property = {.is_list = 0};
    char word[NPH_PLY_NAME];
    if (file->element_count == 0) return nph_ply_refuse(file, "a property before the first element");
    if (file->property_count == NPH_PLY_PROPERTIES)
        return nph_ply_refuse(file, "more than %d properties", NPH_PLY_PROPERTIES);
    const char *here = file->at;
    take(file, word);
    property.is_list = strcmp(word, "list") == 0;
    if (!property.is_list) file->at = here;
    if (property.is_list) NPH_TRY(take_type(file, "the type of a list's length", &property.count_type));
    if (property.is_list && (property.count_type == NPH_F32 || property.count_type == NPH_F64))
        return nph_ply_refuse(file, "the length of a list cannot be of type float or double");
    NPH_TRY(take_type(file, "the type of a property", &property.type));
    if (!take(file, property.name)) return nph_ply_refuse(file, "a property without a name");
    NphPlyElement *element = &file->elements[file->element_count - 1];
    for (int i = element->first; i < file->property_count; i++)
        if (strcmp(file->properties[i].name, property.name) == 0)
            return nph_ply_refuse(file, "property %s of element %s stands here twice", property.name, element->name);
    file->properties[file->property_count++] = property;
    element->properties++;
    return line_ends(file);
}

NphStatus nph_ply_header(NphPlyFile *file) {
    char word[NPH_PLY_NAME];
    int has_format = 0;
    file->line = 1;
    if (!take(file, word) || strcmp(word, "ply") != 0 || !nph_ply_line_ends(file))
        return nph_ply_refuse(file, "a PLY file begins with a line 'ply'");
    for (;;) {
        if (file->at == file->end) return nph_ply_refuse(file, "the file ends before end_header");
        if (!take(file, word) || strcmp(word, "comment") == 0 || strcmp(word, "obj_info") == 0) {
            skip_line(file);
        } else if (strcmp(word, "format") == 0) {
            if (has_format++) return nph_ply_refuse(file, "a second line 'format'");
            NPH_TRY(read_format(file));
        } else if (strcmp(word, "element") == 0) {
            NPH_TRY(read_element(file));
        } else if (strcmp(word, "property") == 0) {
            NPH_TRY(read_property(file));
        } else if (strcmp(word, "end_header") == 0) {
            if (!has_format) return nph_ply_refuse(file, "the header has no line 'format'");
            NPH_TRY(line_ends(file));
            if (file->format != NPH_PLY_ASCII) file->line = 0;
            return NPH_OK;
        } else {
            return nph_ply_refuse(file, "'%s' is no word of a PLY header", word);
        }
    }
}
