/* SPDX-License-Identifier: Apache-2.0
 *
 * One value of a scene file: kind of node, number syntax, range, order of bounds, words. Numbers are plain decimals
 * (core/text.h); what YAML 1.1 would read otherwise (hex, octal, 1:30, 1_000, .inf) is refused. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/text.h"
#include "scene/scene_read.h"

int nph_node_is_null(const yaml_node_t *node) {
    if (node->type != YAML_SCALAR_NODE || node->data.scalar.style != YAML_PLAIN_SCALAR_STYLE) return 0;
    const char *text = (const char *)node->data.scalar.value;
    return !text[0] || !strcmp(text, "~") || !strcmp(text, "null") || !strcmp(text, "Null") || !strcmp(text, "NULL");
}

/* What a value of this type looks like, for messages. */
static const char *shape_of(NphKeyType type) {
    switch (type) {
    case NPH_KEY_NUMBER: return "a number";
    case NPH_KEY_WHOLE: return "a whole number";
    case NPH_KEY_RGB: return "a number or three, [r, g, b]";
    case NPH_KEY_SPECTRUM: return "a list of 1 to 60 numbers";
    case NPH_KEY_FACTORS: return "a number or three, [x, y, z]";
    case NPH_KEY_VECTOR: return "three numbers, [x, y, z]";
    case NPH_KEY_RESOLUTION: return "two whole numbers, [width, height]";
    case NPH_KEY_CROP: return "four whole numbers, [x0, y0, x1, y1]";
    case NPH_KEY_INTERVAL: return "two numbers, [low, high]";
    case NPH_KEY_BOX: return "two corners, [[x0, y0, z0], [x1, y1, z1]]";
    case NPH_KEY_MATRIX: return "12 numbers, three rows of four";
    case NPH_KEY_WORD: return "a word";
    case NPH_KEY_TEXT: return "text";
    case NPH_KEY_FILE: return "the path of a file";
    case NPH_KEY_FRAMES: return "a list of 1 to 4096 whole numbers";
    case NPH_KEY_VALUES: return "a list of values, one for each frame";
    case NPH_KEY_SECTION: return "a mapping (key: value)";
    case NPH_KEY_LIST: return "a list of mappings (- key: value), or [] for none";
    }
    return "";
}

static int is_whole(NphKeyType type) {
    return type == NPH_KEY_WHOLE || type == NPH_KEY_RESOLUTION || type == NPH_KEY_CROP || type == NPH_KEY_FRAMES;
}

static int wrong_kind(NphSceneReader *reader, const NphSceneKey *key, const yaml_node_t *node) {
    char quote[NPH_QUOTE_BYTES];
    if (nph_node_is_null(node))
        nph_scene_mistake(reader, nph_node_place(node), "%s has no value; expected %s", key->key, shape_of(key->type));
    else if (nph_animated_meant(reader, node))
        nph_scene_mistake(reader, nph_node_place(node), "%s cannot be animated here; expected %s", key->key, shape_of(key->type));
    else
        nph_scene_mistake(reader, nph_node_place(node), "%s is %s; expected %s", key->key, nph_node_quote(node, quote),
                          shape_of(key->type));
    return 0;
}

/* A leading zero: octal in YAML 1.1, decimal elsewhere. */
static int looks_octal(const char *begin, const char *end) {
    if (begin < end && (*begin == '-' || *begin == '+')) begin++;
    if (end - begin < 2 || *begin != '0') return 0;
    for (; begin < end; begin++)
        if (*begin < '0' || *begin > '9') return 0;
    return 1;
}

static int not_a_number(NphSceneReader *reader, const NphSceneKey *key, const yaml_node_t *node) {
    char quote[NPH_QUOTE_BYTES];
    const char *begin = (const char *)node->data.scalar.value, *end = begin + node->data.scalar.length;
    const char *digits = begin < end && (*begin == '-' || *begin == '+') ? begin + 1 : begin;
    const char *bare = *digits == '.' ? digits + 1 : digits;
    const char *why = "not a number; numbers are plain decimals such as 0.5 or 1e3";
    nph_node_quote(node, quote);
    if (looks_octal(begin, end)) why = "ambiguous: YAML 1.1 takes a leading zero for octal; write it without";
    else if (is_whole(key->type) && nph_is_decimal(begin, end)) why = "not a whole number";
    else if (nph_is_decimal(begin, end)) why = "too large a number";
    else if (!strcmp(bare, "nan") || !strcmp(bare, "NaN") || !strcmp(bare, "NAN") || !strncmp(bare, "inf", 3) ||
             !strncmp(bare, "Inf", 3) || !strncmp(bare, "INF", 3)) why = "not a finite number";
    else if (!strncmp(digits, "0x", 2) || strpbrk(digits, "_:"))
        why = "not a plain decimal number such as 0.5 or 1e3 (no hex, no '_', no ':')";
    nph_scene_mistake(reader, nph_node_place(node), "%s: %s is %s", key->key, quote, why);
    return 0;
}

static int read_number(NphSceneReader *reader, const NphSceneKey *key, const yaml_node_t *node, double *number) {
    char least[NPH_DOUBLE_TEXT], most[NPH_DOUBLE_TEXT], quote[NPH_QUOTE_BYTES];
    if (node->type != YAML_SCALAR_NODE || nph_node_is_null(node)) return wrong_kind(reader, key, node);
    const char *begin = (const char *)node->data.scalar.value, *end = begin + node->data.scalar.length;
    if (node->data.scalar.style != YAML_PLAIN_SCALAR_STYLE) {
        nph_scene_mistake(reader, nph_node_place(node), "%s: %s is quoted text; write numbers without quotes", key->key,
                          nph_node_quote(node, quote));
        return 0;
    }
    double parsed;
    int64_t whole;
    if (looks_octal(begin, end) || !nph_parse_double_range(begin, end, &parsed)) return not_a_number(reader, key, node);
    if (is_whole(key->type) && !nph_parse_int_range(begin, end, &whole) && strpbrk(begin, ".eE"))
        return not_a_number(reader, key, node);
    if (!(parsed >= key->min && parsed <= key->max)) {
        nph_scene_mistake(reader, nph_node_place(node), "%s is %s; allowed: %s to %s%s%s", key->key,
                          nph_node_quote(node, quote), nph_limit_text(key->min, least), nph_limit_text(key->max, most),
                          key->unit[0] ? " " : "", key->unit);
        return 0;
    }
    *number = parsed;
    return 1;
}

/* A list of exactly count numbers. */
static int read_numbers(NphSceneReader *reader, const NphSceneKey *key, const yaml_node_t *node, int count,
                        double *numbers) {
    if (node->type != YAML_SEQUENCE_NODE) return wrong_kind(reader, key, node);
    yaml_node_item_t *items = node->data.sequence.items.start;
    int given = (int)(node->data.sequence.items.top - items), right = 1;
    if (given != count) {
        nph_scene_mistake(reader, nph_node_place(node), "%s has %d entries; expected %s", key->key, given,
                          shape_of(key->type));
        return 0;
    }
    for (int i = 0; i < count; i++)
        right &= read_number(reader, key, yaml_document_get_node(&reader->document, items[i]), &numbers[i]);
    return right;
}

static int check_rising(NphSceneReader *reader, const NphSceneKey *key, NphScenePlace place, const double *low,
                        const double *high, int count) {
    static const char *const axes[] = {"x", "y", "z"};
    char a[NPH_DOUBLE_TEXT], b[NPH_DOUBLE_TEXT];
    int right = 1;
    for (int i = 0; i < count; i++) {
        if (low[i] < high[i]) continue;
        nph_scene_mistake(reader, place,
                          "%s is %s%s%s: from %s to %s; the first number is the lower one", key->key,
                          low[i] == high[i] ? "flat" : "inverted", count > 1 ? " along " : "", count > 1 ? axes[i] : "",
                          nph_format_double(low[i], a), nph_format_double(high[i], b));
        right = 0;
    }
    return right;
}

static int read_box(NphSceneReader *reader, const NphSceneKey *key, const yaml_node_t *node, double *corners) {
    if (node->type != YAML_SEQUENCE_NODE) return wrong_kind(reader, key, node);
    yaml_node_item_t *items = node->data.sequence.items.start;
    if (node->data.sequence.items.top - items != 2) {
        nph_scene_mistake(reader, nph_node_place(node), "%s has %d entries; expected %s", key->key,
                          (int)(node->data.sequence.items.top - items), shape_of(key->type));
        return 0;
    }
    int right = read_numbers(reader, key, yaml_document_get_node(&reader->document, items[0]), 3, corners);
    return right & read_numbers(reader, key, yaml_document_get_node(&reader->document, items[1]), 3, corners + 3);
}

/* Entries of a list of 1 to most; 0 where it is none. */
static int list_length(NphSceneReader *reader, const NphSceneKey *key, const yaml_node_t *node, int most) {
    if (node->type != YAML_SEQUENCE_NODE) return wrong_kind(reader, key, node);
    int given = (int)(node->data.sequence.items.top - node->data.sequence.items.start);
    if (given >= 1 && given <= most) return given;
    nph_scene_mistake(reader, nph_node_place(node), "%s has %d entries; expected a list of 1 to %d %s", key->key, given, most,
                      key->type == NPH_KEY_FRAMES ? "whole numbers" : key->type == NPH_KEY_VALUES ? "values" : "numbers");
    return 0;
}

/* The numbers of a list of any length that fits. */
static int read_list(NphSceneReader *reader, const NphSceneKey *key, const yaml_node_t *node, NphSceneValue *value) {
    int given = list_length(reader, key, node, NPH_MAX_WAVELENGTHS);
    if (!given) return 0;
    value->count = given;
    return read_numbers(reader, key, node, given, value->number);
}

/* Wavelengths are kept; of frames there may be more than a value has room for. */
static int read_rising(NphSceneReader *reader, const NphSceneKey *key, const yaml_node_t *node, NphSceneValue *value) {
    int kept = key->type == NPH_KEY_SPECTRUM, right = 1, above = 1;
    int given = list_length(reader, key, node, kept ? NPH_MAX_WAVELENGTHS : NPH_MAX_KEY_FRAMES);
    double before = 0, number = 0;
    for (int i = 0; i < given; i++) {
        yaml_node_t *entry = yaml_document_get_node(&reader->document, node->data.sequence.items.start[i]);
        char quote[NPH_QUOTE_BYTES];
        right &= read_number(reader, key, entry, &number);
        if (right && above && i > 0 && !(before < number)) {
            nph_scene_mistake(reader, nph_node_place(entry), "%s: %s does not lie above the one before", key->key,
                              nph_node_quote(entry, quote));
            above = 0;
        }
        if (kept) value->number[i] = number;
        before = number;
    }
    value->count = given;
    return given && right && above;
}

/* One number for all channels, or one for each: three, or as many as there are wavelengths. */
static int read_channels(NphSceneReader *reader, const NphSceneKey *key, const yaml_node_t *node, NphSceneValue *value) {
    int wavelengths = reader->scene->wavelength_count;
    if (node->type == YAML_SEQUENCE_NODE && reader->unsure) return read_list(reader, key, node, value);
    if (node->type == YAML_SEQUENCE_NODE && wavelengths == 0) return read_numbers(reader, key, node, 3, value->number);
    if (node->type == YAML_SEQUENCE_NODE) {
        int given = (int)(node->data.sequence.items.top - node->data.sequence.items.start);
        if (given == wavelengths) return read_numbers(reader, key, node, given, value->number);
        nph_scene_mistake(reader, nph_node_place(node), "%s has %d entries; expected a number, or one for each of the %d "
                          "wavelengths", key->key, given, wavelengths);
        return 0;
    }
    if (!read_number(reader, key, node, &value->number[0])) return 0;
    for (int i = 1; i < NPH_MAX_WAVELENGTHS; i++) value->number[i] = value->number[0];
    return 1;
}

static int read_one_or_three(NphSceneReader *reader, const NphSceneKey *key, const yaml_node_t *node, double *numbers) {
    if (node->type == YAML_SEQUENCE_NODE) return read_numbers(reader, key, node, 3, numbers);
    if (!read_number(reader, key, node, &numbers[0])) return 0;
    numbers[1] = numbers[2] = numbers[0];
    return 1;
}

static int unknown_word(NphSceneReader *reader, const NphSceneKey *key, const yaml_node_t *node) {
    char quote[NPH_QUOTE_BYTES], word[NPH_QUOTE_BYTES], list[256] = "", close[NPH_QUOTE_BYTES + 20] = "";
    const char *text = (const char *)node->data.scalar.value;
    int best = 1000;
    for (int n = 0; nph_words_get(key->words, n, word, sizeof word); n++) {
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s", n ? ", " : "", word);
        int distance = nph_edit_distance(text, word);
        if (!nph_edit_close(text, word) || distance >= best) continue;
        best = distance;
        snprintf(close, sizeof close, "; did you mean '%s'?", word);
    }
    nph_scene_mistake(reader, nph_node_place(node), "%s: %s is not known; allowed: %s%s", key->key,
                      nph_node_quote(node, quote), list, close);
    return 0;
}

static int read_text(NphSceneReader *reader, const NphSceneKey *key, const yaml_node_t *node, NphSceneValue *value) {
    char quote[NPH_QUOTE_BYTES];
    if (node->type != YAML_SCALAR_NODE || nph_node_is_null(node)) return wrong_kind(reader, key, node);
    const char *text = (const char *)node->data.scalar.value;
    size_t length = node->data.scalar.length;
    value->text = text;
    if (key->type == NPH_KEY_WORD) {
        value->word = nph_words_index(key->words, text);
        return value->word >= 0 && strlen(text) == length ? 1 : unknown_word(reader, key, node);
    }
    for (size_t i = 0; i < length; i++) {
        if ((unsigned char)text[i] >= 0x20 && text[i] != 0x7F) continue;
        nph_scene_mistake(reader, nph_node_place(node), "%s: %s holds a control character (byte %d of %d)", key->key,
                          nph_node_quote(node, quote), (int)i + 1, (int)length);
        return 0;
    }
    if (length < (size_t)key->min || length > (size_t)key->max) {
        nph_scene_mistake(reader, nph_node_place(node), "%s has %d bytes; allowed: %d to %d", key->key, (int)length,
                          (int)key->min, (int)key->max);
        return 0;
    }
    return 1;
}

/* Too many entries are a mistake at the first one too many; those before it are still read. */
static int check_list(NphSceneReader *reader, const NphSceneKey *key, const yaml_node_t *node) {
    if (node->type != YAML_SEQUENCE_NODE) return wrong_kind(reader, key, node);
    yaml_node_item_t *items = node->data.sequence.items.start;
    int given = (int)(node->data.sequence.items.top - items), most = (int)key->max;
    if (given > most)
        nph_scene_mistake(reader, nph_node_place(yaml_document_get_node(&reader->document, items[most])),
                          "%s has %d entries; allowed: at most %d", key->key, given, most);
    return 1;
}

int nph_value_check(NphSceneReader *reader, const NphSceneKey *key, const NphSceneValue *value) {
    const double *number = value->number;
    if (key->type == NPH_KEY_INTERVAL) return check_rising(reader, key, value->place, number, number + 1, 1);
    return key->type != NPH_KEY_BOX || check_rising(reader, key, value->place, number, number + 3, 3);
}

int nph_value_read_still(NphSceneReader *reader, const NphSceneKey *key, const yaml_node_t *node, NphSceneValue *value) {
    double *number = value->number;
    int right = 0;
    value->given = 1;
    value->place = nph_node_place(node);
    value->node = node;
    switch (key->type) {
    case NPH_KEY_NUMBER:
    case NPH_KEY_WHOLE: right = read_number(reader, key, node, number); break;
    case NPH_KEY_RGB: right = read_channels(reader, key, node, value); break;
    case NPH_KEY_SPECTRUM:
    case NPH_KEY_FRAMES: right = read_rising(reader, key, node, value); break;
    case NPH_KEY_VALUES: right = list_length(reader, key, node, NPH_MAX_KEY_FRAMES) > 0; break;
    case NPH_KEY_FACTORS: right = read_one_or_three(reader, key, node, number); break;
    case NPH_KEY_VECTOR: right = read_numbers(reader, key, node, 3, number); break;
    case NPH_KEY_RESOLUTION: right = read_numbers(reader, key, node, 2, number); break;
    case NPH_KEY_CROP: right = read_numbers(reader, key, node, 4, number); break;
    case NPH_KEY_INTERVAL: right = read_numbers(reader, key, node, 2, number); break;
    case NPH_KEY_BOX: right = read_box(reader, key, node, number); break;
    case NPH_KEY_MATRIX: right = read_numbers(reader, key, node, 12, number); break;
    case NPH_KEY_WORD:
    case NPH_KEY_TEXT:
    case NPH_KEY_FILE: right = read_text(reader, key, node, value); break;
    case NPH_KEY_SECTION: right = node->type == YAML_MAPPING_NODE || wrong_kind(reader, key, node); break;
    case NPH_KEY_LIST: right = check_list(reader, key, node); break;
    }
    value->valid = right && nph_value_check(reader, key, value);
    return value->valid;
}

int nph_value_read(NphSceneReader *reader, const NphSceneKey *key, const yaml_node_t *node, NphSceneValue *value) {
    if (nph_key_animates(key->type) && nph_animated_meant(reader, node)) return nph_animated_read(reader, key, node, value);
    int right = nph_value_read_still(reader, key, node, value);
    value->place.animated = right && key->type == NPH_KEY_FILE && strchr(value->text, '#');
    reader->scene->animated |= value->place.animated;
    return right;
}

/* Defaults stand in the table as they would in a file: a number, "[x, y, z]" or a word. */
void nph_value_default(const NphSceneKey *key, NphSceneValue *value) {
    const char *text = key->fallback;
    if (!text || text == nph_key_required) return;
    value->valid = 1;
    if (key->type == NPH_KEY_WORD) {
        value->text = text;
        value->word = nph_words_index(key->words, text);
        return;
    }
    int count = 0;
    while (*text) {
        size_t skip = strspn(text, "[], "), length = strcspn(text + skip, "[], ");
        if (length && count < 12) nph_parse_double_range(text + skip, text + skip + length, &value->number[count++]);
        text += skip + length;
    }
    for (int i = 1; i < NPH_MAX_WAVELENGTHS && count == 1; i++) value->number[i] = value->number[0];
}
