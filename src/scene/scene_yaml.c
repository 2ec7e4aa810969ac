/* SPDX-License-Identifier: Apache-2.0
 *
 * From bytes to a YAML document whose nodes know their line and column. Before libyaml builds it, the bytes are checked
 * (size, UTF-8, NUL) and its events are walked once: that bounds the depth of nesting, whose cost inside libyaml grows
 * with its square, and finds what a document no longer shows: tags, the number of documents and of anchors. */
#include <stdio.h>
#include <string.h>

#include "scene/scene_read.h"

enum { NPH_SCENE_DEPTH = 16, NPH_SCENE_ANCHORS = 256 };

/* Line and column (in characters) of a byte. */
static NphScenePlace place_of_byte(const char *text, size_t offset) {
    NphScenePlace place = {.line = 1, .column = 1};
    for (size_t i = 0; i < offset; i++) {
        unsigned char byte = (unsigned char)text[i];
        int crlf = byte == '\r' && i + 1 < offset && text[i + 1] == '\n';
        if (byte == '\n' || (byte == '\r' && !crlf)) {
            place.line++;
            place.column = 1;
        } else if (!crlf && (byte & 0xC0) != 0x80) {
            place.column++;
        }
    }
    return place;
}

static NphScenePlace place_of_mark(yaml_mark_t mark) {
    NphScenePlace place = {.line = (int)mark.line + 1, .column = (int)mark.column + 1};
    return place;
}

/* Bytes of the UTF-8 character at text; 0 when it is none (overlong, surrogate, beyond U+10FFFF, cut). */
static size_t utf8_length(const unsigned char *text, size_t left) {
    if (text[0] < 0x80) return 1;
    size_t length = text[0] >= 0xF0 ? 4 : text[0] >= 0xE0 ? 3 : 2;
    if (text[0] < 0xC2 || text[0] > 0xF4 || length > left) return 0;
    for (size_t i = 1; i < length; i++)
        if ((text[i] & 0xC0) != 0x80) return 0;
    if (text[0] == 0xE0 && text[1] < 0xA0) return 0;
    if (text[0] == 0xED && text[1] > 0x9F) return 0;
    if (text[0] == 0xF0 && text[1] < 0x90) return 0;
    if (text[0] == 0xF4 && text[1] > 0x8F) return 0;
    return length;
}

static int check_bytes(NphSceneReader *reader) {
    NphScenePlace start = {.line = 1, .column = 1};
    const char *text = reader->text;
    const unsigned char *bytes = (const unsigned char *)text;
    size_t size = reader->size;
    if (size > NPH_SCENE_BYTES) {
        nph_scene_mistake(reader, start, NPH_SCENE_TOO_LARGE, (int)NPH_SCENE_BYTES, (unsigned long long)size);
        return 0;
    }
    if (size >= 2 && ((bytes[0] == 0xFF && bytes[1] == 0xFE) || (bytes[0] == 0xFE && bytes[1] == 0xFF))) {
        nph_scene_mistake(reader, start, "the file is UTF-16 or UTF-32; scenes are UTF-8");
        return 0;
    }
    for (size_t i = 0; i < size;) {
        size_t length = utf8_length(bytes + i, size - i);
        if (length == 0 || bytes[i] == 0) {
            nph_scene_mistake(reader, place_of_byte(text, i), "byte 0x%02X at offset %llu is not %s", bytes[i],
                              (unsigned long long)i, length == 0 ? "UTF-8" : "allowed: a NUL does not belong in text");
            return 0;
        }
        i += length;
    }
    return 1;
}

/* 1 when the blanks that begin a line (from 0) hold a tab. */
static int tab_indents(const NphSceneReader *reader, size_t line) {
    const char *at = reader->text, *end = reader->text + reader->size;
    for (; line > 0 && at < end; at++) line -= *at == '\n';
    while (at < end && *at == ' ') at++;
    return at < end && *at == '\t';
}

static NphStatus report_parser(NphSceneReader *reader, const yaml_parser_t *parser) {
    if (parser->error == YAML_MEMORY_ERROR)
        return nph_error(reader->context, NPH_NO_MEMORY, "out of memory: the YAML parser has none left");
    const char *problem = parser->problem ? parser->problem : "cannot be read";
    if (parser->error == YAML_READER_ERROR) {
        nph_scene_mistake(reader, place_of_byte(reader->text, parser->problem_offset), "not YAML: %s (U+%04X)", problem,
                          (unsigned)parser->problem_value);
        return NPH_OK;
    }
    char where[160] = "";
    if (parser->context)
        snprintf(where, sizeof where, " (%s that begins in line %d)", parser->context,
                 (int)parser->context_mark.line + 1);
    int tab = strstr(problem, "cannot start any token") && tab_indents(reader, parser->problem_mark.line);
    nph_scene_mistake(reader, place_of_mark(parser->problem_mark), "not YAML: %s%s%s", problem, where,
                      tab ? "; lines are indented with blanks, not tabs" : "");
    return NPH_OK;
}

typedef struct Walk {
    int depth, anchors, documents, stop;
} Walk;

static void note_properties(NphSceneReader *reader, Walk *walk, yaml_mark_t mark, const yaml_char_t *anchor,
                            const yaml_char_t *tag) {
    char quote[NPH_QUOTE_BYTES];
    if (tag)
        nph_scene_mistake(reader, place_of_mark(mark), "tag %s: tags are not used in scenes, write the value alone",
                          nph_text_quote((const char *)tag, strlen((const char *)tag), quote));
    if (anchor && ++walk->anchors > NPH_SCENE_ANCHORS) {
        nph_scene_mistake(reader, place_of_mark(mark), "more than %d anchors", (int)NPH_SCENE_ANCHORS);
        walk->stop = 1;
    }
}

static void note_deeper(NphSceneReader *reader, Walk *walk, yaml_mark_t mark) {
    if (++walk->depth <= NPH_SCENE_DEPTH) return;
    nph_scene_mistake(reader, place_of_mark(mark), "lists and mappings are nested more than %d deep",
                      (int)NPH_SCENE_DEPTH);
    walk->stop = 1;
}

static void note_event(NphSceneReader *reader, Walk *walk, const yaml_event_t *event) {
    switch (event->type) {
    case YAML_DOCUMENT_START_EVENT:
        if (++walk->documents < 2) break;
        nph_scene_mistake(reader, place_of_mark(event->start_mark),
                          "a second document begins here; a scene file holds one");
        walk->stop = 1;
        break;
    case YAML_SCALAR_EVENT:
        note_properties(reader, walk, event->start_mark, event->data.scalar.anchor, event->data.scalar.tag);
        break;
    case YAML_SEQUENCE_START_EVENT:
        note_properties(reader, walk, event->start_mark, event->data.sequence_start.anchor,
                        event->data.sequence_start.tag);
        note_deeper(reader, walk, event->start_mark);
        break;
    case YAML_MAPPING_START_EVENT:
        note_properties(reader, walk, event->start_mark, event->data.mapping_start.anchor,
                        event->data.mapping_start.tag);
        note_deeper(reader, walk, event->start_mark);
        break;
    case YAML_SEQUENCE_END_EVENT:
    case YAML_MAPPING_END_EVENT: walk->depth--; break;
    case YAML_STREAM_END_EVENT: walk->stop = 1; break;
    default: break;
    }
}

static NphStatus walk_events(NphSceneReader *reader, yaml_parser_t *parser, int *whole) {
    Walk walk = {0};
    *whole = 0;
    while (!walk.stop) {
        yaml_event_t event;
        if (!yaml_parser_parse(parser, &event)) return report_parser(reader, parser);
        *whole = event.type == YAML_STREAM_END_EVENT;
        note_event(reader, &walk, &event);
        yaml_event_delete(&event);
    }
    return NPH_OK;
}

static NphStatus open_parser(NphSceneReader *reader, yaml_parser_t *parser) {
    if (!yaml_parser_initialize(parser))
        return nph_error(reader->context, NPH_NO_MEMORY, "out of memory: the YAML parser has none left");
    yaml_parser_set_encoding(parser, YAML_UTF8_ENCODING);
    yaml_parser_set_input_string(parser, (const unsigned char *)reader->text, reader->size);
    return NPH_OK;
}

NphStatus nph_scene_document(NphSceneReader *reader, const char *text, size_t size) {
    yaml_parser_t parser;
    NphScenePlace start = {.line = 1, .column = 1};
    int whole = 0;
    int mark = size >= 3 && memcmp(text, "\xEF\xBB\xBF", 3) == 0; /* UTF-8's byte order mark */
    reader->text = mark ? text + 3 : text;
    reader->size = mark ? size - 3 : size;
    if (!check_bytes(reader)) return NPH_OK;
    NPH_TRY(open_parser(reader, &parser));
    NphStatus status = walk_events(reader, &parser, &whole);
    yaml_parser_delete(&parser);
    if (status != NPH_OK || !whole) return status;
    NPH_TRY(open_parser(reader, &parser));
    if (!yaml_parser_load(&parser, &reader->document)) {
        status = report_parser(reader, &parser);
    } else if (!yaml_document_get_root_node(&reader->document)) {
        yaml_document_delete(&reader->document);
        nph_scene_mistake(reader, start, "the file is empty; a scene begins with 'nephos: 1' and has a camera");
    } else {
        reader->has_document = 1;
    }
    yaml_parser_delete(&parser);
    return status;
}
