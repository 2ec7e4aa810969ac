/* SPDX-License-Identifier: Apache-2.0
 *
 * See json.h. Layout: a member of an object, and a container inside an array, begins a line of its own, indented by two
 * spaces per level; plain values of an array share a line. Of a value on one line, blanks stand for the breaks between members. */
#include "core/json.h"

#include <assert.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/text.h"

static void put(NphJson *json, const char *text) { json->write(json->user, text, strlen(text)); }

static void break_line(NphJson *json) {
    char line[1 + 2 * NPH_JSON_DEPTH] = "\n";
    memset(line + 1, ' ', 2 * (size_t)json->depth);
    json->write(json->user, line, 1 + 2 * (size_t)json->depth);
}

/* Bytes of the UTF-8 character at text, or 0 when it is none (overlong forms, surrogates and truncation included). */
static size_t character_bytes(const unsigned char *text) {
    unsigned char lead = text[0];
    size_t count = lead < 0x80 ? 1 : lead >= 0xC2 && lead < 0xE0 ? 2 : (lead & 0xF0) == 0xE0 ? 3 : 4;
    if (count == 4 && (lead < 0xF0 || lead > 0xF4)) return 0;
    for (size_t i = 1; i < count; i++) {
        if ((text[i] & 0xC0) != 0x80) return 0;
    }
    if (lead == 0xE0 && text[1] < 0xA0) return 0;
    if (lead == 0xED && text[1] > 0x9F) return 0;
    if (lead == 0xF0 && text[1] < 0x90) return 0;
    if (lead == 0xF4 && text[1] > 0x8F) return 0;
    return count;
}

static int is_plain(char c) { return c >= 0x20 && c < 0x7F && c != '"' && c != '\\'; }

static void put_string(NphJson *json, const char *text) {
    static const char marks[] = "\"\\\b\f\n\r\t", letters[] = "\"\\bfnrt";
    put(json, "\"");
    while (*text) {
        size_t plain = 0;
        while (is_plain(text[plain])) plain++;
        if (plain) json->write(json->user, text, plain);
        text += plain;
        if (!*text) break;
        size_t bytes = character_bytes((const unsigned char *)text);
        const char *mark = strchr(marks, *text);
        char escape[8];
        if (mark) {
            snprintf(escape, sizeof escape, "\\%c", letters[mark - marks]);
            put(json, escape);
        } else if ((unsigned char)*text < 0x20) {
            snprintf(escape, sizeof escape, "\\u%04x", (unsigned)(unsigned char)*text);
            put(json, escape);
        } else if (bytes == 0) {
            put(json, "\xEF\xBF\xBD");
        } else {
            json->write(json->user, text, bytes);
        }
        text += bytes ? bytes : 1;
    }
    put(json, "\"");
}

/* What stands before a value: comma, line break or blank, key. */
static void introduce(NphJson *json, const char *key, int is_container) {
    if (json->depth == 0) return;
    int inside_object = json->open[json->depth - 1].close == '}';
    assert(inside_object == (key != NULL));
    if (json->after_first) put(json, ",");
    json->open[json->depth - 1].spread = !json->line && (inside_object || is_container);
    if (json->open[json->depth - 1].spread) {
        break_line(json);
    } else if (json->after_first) {
        put(json, " ");
    }
    if (key) {
        put_string(json, key);
        put(json, ": ");
    }
    json->after_first = 1;
}

static void open_container(NphJson *json, const char *key, const char *opening, char closing) {
    assert(json->depth < NPH_JSON_DEPTH);
    introduce(json, key, 1);
    put(json, opening);
    json->open[json->depth].close = closing;
    json->open[json->depth].spread = 0;
    json->depth++;
    json->after_first = 0;
}

void nph_json_begin(NphJson *json, NphTextFn write, void *user) {
    memset(json, 0, sizeof *json);
    json->write = write;
    json->user = user;
}

void nph_json_begin_line(NphJson *json, NphTextFn write, void *user) {
    nph_json_begin(json, write, user);
    json->line = 1;
}

void nph_json_to_file(void *file, const char *text, size_t length) { (void)fwrite(text, 1, length, file); }

void nph_json_object(NphJson *json, const char *key) { open_container(json, key, "{", '}'); }
void nph_json_array(NphJson *json, const char *key) { open_container(json, key, "[", ']'); }

void nph_json_close(NphJson *json) {
    assert(json->depth > 0);
    json->depth--;
    if (json->open[json->depth].spread) break_line(json);
    json->write(json->user, &json->open[json->depth].close, 1);
    json->after_first = 1;
    if (json->depth == 0 && !json->line) put(json, "\n");
}

void nph_json_text(NphJson *json, const char *key, const char *value) {
    introduce(json, key, 0);
    if (value) put_string(json, value);
    else put(json, "null");
}

void nph_json_number(NphJson *json, const char *key, double value) {
    char text[NPH_DOUBLE_TEXT];
    introduce(json, key, 0);
    put(json, isfinite(value) ? nph_format_double(value, text) : "null");
}

void nph_json_integer(NphJson *json, const char *key, int64_t value) {
    char text[24];
    snprintf(text, sizeof text, "%" PRId64, value);
    introduce(json, key, 0);
    put(json, text);
}

void nph_json_boolean(NphJson *json, const char *key, int value) {
    introduce(json, key, 0);
    put(json, value ? "true" : "false");
}

void nph_json_copy(NphJson *json, const char *key, const char *value, size_t length) {
    introduce(json, key, 1);
    json->write(json->user, value, length);
}

void nph_json_numbers(NphJson *json, const char *key, int count, const double *values) {
    nph_json_array(json, key);
    for (int i = 0; i < count; i++) nph_json_number(json, NULL, values[i]);
    nph_json_close(json);
}
