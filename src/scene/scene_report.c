/* SPDX-License-Identifier: Apache-2.0
 *
 * Messages of a scene file: FILE:LINE:COLUMN: what is wrong, what is allowed. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "scene/scene_read.h"

enum { NPH_MISTAKE_BYTES = 1200 };

NphScenePlace nph_node_place(const yaml_node_t *node) {
    NphScenePlace place = {.line = (int)node->start_mark.line + 1, .column = (int)node->start_mark.column + 1};
    return place;
}

static void report(NphSceneReader *reader, NphStatus status, NphScenePlace place, const char *text) {
    int before = reader->mistakes + reader->bad_inputs - 1;
    char when[32] = "";
    if (place.animated) snprintf(when, sizeof when, " (at frame %u)", (unsigned)reader->frame);
    if (before < NPH_SHOWN_MISTAKES)
        nph_error(reader->context, status, "%s:%d:%d: %s%s", reader->name, place.line, place.column, text, when);
    else if (before == NPH_SHOWN_MISTAKES)
        nph_error(reader->context, status, "%s: more than %d mistakes; the others are not shown", reader->name,
                  (int)NPH_SHOWN_MISTAKES);
}

void nph_scene_mistake(NphSceneReader *reader, NphScenePlace place, const char *format, ...) {
    char text[NPH_MISTAKE_BYTES];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    reader->mistakes++;
    report(reader, NPH_BAD_SCENE, place, text);
}

void nph_scene_bad_input(NphSceneReader *reader, NphScenePlace place, const char *format, ...) {
    char text[NPH_MISTAKE_BYTES];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    reader->bad_inputs++;
    report(reader, NPH_BAD_INPUT, place, text);
}

/* Cuts between characters of UTF-8, and shows what could upset a terminal as '?'. */
const char *nph_text_quote(const char *text, size_t length, char *buffer) {
    size_t room = NPH_QUOTE_BYTES - 6, used = length < room ? length : room;
    if (used < length)
        while (used > 0 && ((unsigned char)text[used] & 0xC0) == 0x80) used--;
    buffer[0] = '\'';
    for (size_t i = 0; i < used; i++) {
        unsigned char byte = (unsigned char)text[i];
        buffer[i + 1] = byte < 0x20 || byte == 0x7F ? '?' : (char)byte;
    }
    strcpy(buffer + used + 1, used < length ? "...'" : "'");
    return buffer;
}

const char *nph_node_quote(const yaml_node_t *node, char *buffer) {
    switch (node->type) {
    case YAML_SCALAR_NODE:
        if (nph_node_is_null(node)) return strcpy(buffer, "nothing");
        return nph_text_quote((const char *)node->data.scalar.value, node->data.scalar.length, buffer);
    case YAML_SEQUENCE_NODE: return strcpy(buffer, "a list");
    case YAML_MAPPING_NODE: return strcpy(buffer, "a mapping");
    default: return strcpy(buffer, "nothing");
    }
}
