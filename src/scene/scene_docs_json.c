/* SPDX-License-Identifier: Apache-2.0
 *
 * docs/scene.schema.json (JSON Schema 2020-12) from the table of keys: a definition per section; a section with
 * variants is one of as many objects. What it cannot say (order of bounds, vectors of length 0, contents of files) the
 * reader checks. */
#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "optics/wavelengths.h"
#include "scene/scene_keys.h"

static void put_size(NphJson *json, int count) {
    nph_json_text(json, "type", "array");
    nph_json_integer(json, "minItems", count);
    nph_json_integer(json, "maxItems", count);
}

static void put_number(NphJson *json, const char *key, const NphSceneKey *row, const char *type) {
    nph_json_object(json, key);
    nph_json_text(json, "type", type);
    nph_json_number(json, "minimum", row->min);
    nph_json_number(json, "maximum", row->max);
    nph_json_close(json);
}

static void put_numbers(NphJson *json, const char *key, const NphSceneKey *row, const char *type, int count) {
    nph_json_object(json, key);
    put_size(json, count);
    put_number(json, "items", row, type);
    nph_json_close(json);
}

static void put_reference(NphJson *json, const char *section) {
    char target[64];
    snprintf(target, sizeof target, "#/$defs/%s", section);
    nph_json_text(json, "$ref", target);
}

static void put_words(NphJson *json, const char *key, const char *words) {
    char word[64];
    nph_json_array(json, key);
    for (int n = 0; nph_words_get(words, n, word, sizeof word); n++) nph_json_text(json, NULL, word);
    nph_json_close(json);
}

static void put_tuple(NphJson *json, const NphSceneKey *row) {
    int whole = row->type == NPH_KEY_RESOLUTION || row->type == NPH_KEY_CROP;
    int pair = row->type == NPH_KEY_RESOLUTION || row->type == NPH_KEY_INTERVAL;
    put_size(json, pair ? 2 : row->type == NPH_KEY_VECTOR ? 3 : row->type == NPH_KEY_CROP ? 4 : 12);
    put_number(json, "items", row, whole ? "integer" : "number");
}

/* 1 to 60 numbers. */
static void put_list(NphJson *json, const NphSceneKey *row) {
    nph_json_text(json, "type", "array");
    nph_json_number(json, "minItems", 1);
    nph_json_number(json, "maxItems", NPH_MAX_WAVELENGTHS);
    put_number(json, "items", row, "number");
}

/* The members that say which values a key takes. */
static void put_value(NphJson *json, const NphSceneKey *row) {
    switch (row->type) {
    case NPH_KEY_NUMBER:
    case NPH_KEY_WHOLE:
        nph_json_text(json, "type", row->type == NPH_KEY_NUMBER ? "number" : "integer");
        nph_json_number(json, "minimum", row->min);
        nph_json_number(json, "maximum", row->max);
        break;
    case NPH_KEY_SPECTRUM: put_list(json, row); break;
    case NPH_KEY_RGB: /* with wavelengths a list is as long as theirs */
        nph_json_array(json, "anyOf");
        put_number(json, NULL, row, "number");
        nph_json_object(json, NULL);
        put_list(json, row);
        nph_json_close(json);
        nph_json_close(json);
        break;
    case NPH_KEY_FACTORS:
        nph_json_array(json, "anyOf");
        put_number(json, NULL, row, "number");
        put_numbers(json, NULL, row, "number", 3);
        nph_json_close(json);
        break;
    case NPH_KEY_VECTOR:
    case NPH_KEY_RESOLUTION:
    case NPH_KEY_CROP:
    case NPH_KEY_INTERVAL:
    case NPH_KEY_MATRIX: put_tuple(json, row); break;
    case NPH_KEY_BOX:
        put_size(json, 2);
        put_numbers(json, "items", row, "number", 3);
        break;
    case NPH_KEY_WORD: put_words(json, "enum", row->words); break;
    case NPH_KEY_TEXT:
    case NPH_KEY_FILE:
        nph_json_text(json, "type", "string");
        nph_json_number(json, "minLength", row->min);
        nph_json_number(json, "maxLength", row->max);
        break;
    case NPH_KEY_FRAMES:
        nph_json_text(json, "type", "array");
        nph_json_number(json, "minItems", 1);
        nph_json_number(json, "maxItems", NPH_MAX_KEY_FRAMES);
        put_number(json, "items", row, "integer");
        break;
    case NPH_KEY_VALUES: /* each as put_still_or_animated says */
        nph_json_text(json, "type", "array");
        nph_json_number(json, "minItems", 1);
        nph_json_number(json, "maxItems", NPH_MAX_KEY_FRAMES);
        break;
    case NPH_KEY_SECTION: put_reference(json, row->words); break;
    case NPH_KEY_LIST:
        nph_json_text(json, "type", "array");
        nph_json_number(json, "maxItems", row->max);
        nph_json_object(json, "items");
        put_reference(json, row->words);
        nph_json_close(json);
        break;
    }
}

/* A value of an animated key is held against the key's own, in place of `values` and alone. */
static void put_still_or_animated(NphJson *json, const NphSceneKey *row) {
    if (!nph_key_animates(row->type)) {
        put_value(json, row);
        return;
    }
    nph_json_array(json, "anyOf");
    nph_json_object(json, NULL);
    put_value(json, row);
    nph_json_close(json);
    nph_json_object(json, NULL);
    put_reference(json, "animated");
    nph_json_object(json, "properties");
    nph_json_object(json, "values");
    nph_json_object(json, "items");
    put_value(json, row);
    for (int i = 0; i < 5; i++) nph_json_close(json);
}

static void put_property(NphJson *json, const NphSceneSectionInfo *info, const NphSceneKey *row, const char *variant) {
    char text[400], pattern[32];
    nph_json_object(json, row->key);
    snprintf(text, sizeof text, "%s%s%s%s", row->meaning, row->unit[0] ? " [" : "", row->unit, row->unit[0] ? "]" : "");
    nph_json_text(json, "description", text);
    int decides = variant && strcmp(info->variant_key, row->key) == 0;
    if (decides && row->type == NPH_KEY_WORD) {
        nph_json_text(json, "const", variant);
    } else {
        put_still_or_animated(json, row);
        if (decides) {
            snprintf(pattern, sizeof pattern, "\\.%s$", variant);
            nph_json_text(json, "pattern", pattern);
        }
    }
    nph_json_close(json);
}

typedef struct Key {
    char name[32];
    int alternative, optional;
} Key;

static int split_rule(const char *alternatives, Key keys[8]) {
    int count = 0, alternative = 0;
    for (const char *at = alternatives; *at && count < 8;) {
        size_t length = strcspn(at, " |?");
        Key *key = &keys[count++];
        snprintf(key->name, sizeof key->name, "%.*s", (int)length, at);
        key->alternative = alternative;
        key->optional = at[length] == '?';
        at += length + (size_t)key->optional;
        alternative += *at == '|';
        if (*at) at++;
    }
    return count;
}

/* {"anyOf": [{"required": [a]}, ...]} over the keys of an alternative, or over all others. */
static void put_any_required(NphJson *json, const Key *keys, int count, int alternative, int others) {
    nph_json_array(json, "anyOf");
    for (int i = 0; i < count; i++) {
        if ((keys[i].alternative == alternative) == others) continue;
        nph_json_object(json, NULL);
        put_words(json, "required", keys[i].name);
        nph_json_close(json);
    }
    nph_json_close(json);
}

static void put_alternative(NphJson *json, const Key *keys, int count, int alternative) {
    int needed = 0;
    for (int i = 0; i < count; i++) needed += keys[i].alternative == alternative && !keys[i].optional;
    nph_json_object(json, NULL);
    if (needed) {
        nph_json_array(json, "required");
        for (int i = 0; i < count; i++)
            if (keys[i].alternative == alternative && !keys[i].optional) nph_json_text(json, NULL, keys[i].name);
        nph_json_close(json);
    } else {
        put_any_required(json, keys, count, alternative, 0);
    }
    nph_json_object(json, "not");
    put_any_required(json, keys, count, alternative, 1);
    nph_json_close(json);
    nph_json_close(json);
}

static void put_rules(NphJson *json, const char *section, const char *variant) {
    Key keys[8];
    int opened = 0;
    for (int i = 0; i < nph_scene_rule_count; i++) {
        const NphSceneRule *rule = &nph_scene_rules[i];
        if (strcmp(rule->section, section) != 0 || (rule->applies && !nph_words_apply(rule->applies, variant)))
            continue;
        if (!opened++) nph_json_array(json, "allOf");
        int count = split_rule(rule->alternatives, keys);
        assert(count > 0);
        nph_json_object(json, NULL);
        nph_json_array(json, "oneOf");
        for (int a = 0; a <= keys[count - 1].alternative; a++) put_alternative(json, keys, count, a);
        nph_json_close(json);
        nph_json_close(json);
    }
    if (opened) nph_json_close(json);
}

/* A variant whose `type` may be left out is the default. */
static int is_required(const NphSceneSectionInfo *info, const NphSceneKey *row, const char *variant) {
    if (variant && strcmp(info->variant_key, row->key) == 0)
        return row->fallback == nph_key_required || strcmp(row->fallback, variant) != 0;
    return row->fallback == nph_key_required;
}

static void put_object(NphJson *json, const NphSceneSectionInfo *info, const char *variant) {
    int count;
    const NphSceneKey *rows = nph_scene_section_keys(info->name, &count);
    nph_json_text(json, "type", "object");
    nph_json_boolean(json, "additionalProperties", 0);
    nph_json_object(json, "properties");
    for (int i = 0; i < count; i++)
        if (nph_words_apply(rows[i].applies, variant)) put_property(json, info, &rows[i], variant);
    nph_json_close(json);
    nph_json_array(json, "required");
    for (int i = 0; i < count; i++)
        if (nph_words_apply(rows[i].applies, variant) && is_required(info, &rows[i], variant))
            nph_json_text(json, NULL, rows[i].key);
    nph_json_close(json);
    put_rules(json, info->name, variant);
}

static void put_section(NphJson *json, const NphSceneSectionInfo *info) {
    char variant[64];
    nph_json_object(json, info->name);
    nph_json_text(json, "description", info->meaning);
    if (info->variants) {
        nph_json_array(json, "oneOf");
        for (int n = 0; nph_words_get(info->variants, n, variant, sizeof variant); n++) {
            nph_json_object(json, NULL);
            put_object(json, info, variant);
            nph_json_close(json);
        }
        nph_json_close(json);
    } else {
        put_object(json, info, NULL);
    }
    nph_json_close(json);
}

void nph_scene_keys_json(NphTextFn write, void *user) {
    NphJson json;
    nph_json_begin(&json, write, user);
    nph_json_object(&json, NULL);
    nph_json_text(&json, "$schema", "https://json-schema.org/draft/2020-12/schema");
    nph_json_text(&json, "title", "nephos scene");
    nph_json_text(&json, "$ref", "#/$defs/scene");
    nph_json_object(&json, "$defs");
    for (int i = 0; i < nph_scene_section_count; i++) put_section(&json, &nph_scene_sections[i]);
    nph_json_close(&json);
    nph_json_close(&json);
}
