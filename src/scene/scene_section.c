/* SPDX-License-Identifier: Apache-2.0
 *
 * All keys of one mapping after the table: first the key that decides the variant, then every pair (unknown, doubled
 * and misplaced keys are reported with what may have been meant), then what is missing, then which keys exclude each
 * other. */
#include <stdio.h>
#include <string.h>

#include "scene/scene_read.h"

/* The row of a key that counts for this variant; *any: one row of that name, whatever the variant. */
static int find_row(const NphSceneSection *section, const char *name, int *any) {
    *any = -1;
    for (int i = 0; i < section->count; i++) {
        if (strcmp(section->keys[i].key, name) != 0) continue;
        if (*any < 0) *any = i;
        if (nph_words_apply(section->keys[i].applies, section->variant[0] ? section->variant : NULL)) return i;
    }
    return -1;
}

static const char *variant_name(const NphSceneSection *section, const char *variant, char *buffer, size_t size) {
    int file = strcmp(section->info->variant_key, "file") == 0;
    snprintf(buffer, size, file ? ".%s files" : "type %s", variant);
    return buffer;
}

static void report_misplaced(NphSceneReader *reader, const NphSceneSection *section, const yaml_node_t *node, int row) {
    char mine[40], words[128] = "", word[32];
    for (int n = 0; nph_words_get(section->keys[row].applies, n, word, sizeof word); n++)
        snprintf(words + strlen(words), sizeof words - strlen(words), "%s%s", n ? " or " : "", word);
    nph_scene_mistake(reader, nph_node_place(node), "%s does not go with %s, only with %s", section->keys[row].key,
                      variant_name(section, section->variant, mine, sizeof mine), words);
}

/* The closest key of the section; else a section that has exactly this key. */
static void suggest(const NphSceneSection *section, const char *text, char *hint, size_t size) {
    int best = 1000;
    hint[0] = 0;
    for (int i = 0; i < section->count; i++) {
        int distance = nph_edit_distance(text, section->keys[i].key);
        if (!nph_edit_close(text, section->keys[i].key) || distance >= best) continue;
        best = distance;
        snprintf(hint, size, "; did you mean '%s'?", section->keys[i].key);
    }
    for (int i = 0; i < nph_scene_key_count && best == 1000; i++) {
        if (strcmp(nph_scene_keys[i].key, text) != 0) continue;
        snprintf(hint, size, "; it belongs to %s", nph_scene_section_info(nph_scene_keys[i].section)->place);
        best = 0;
    }
}

static void report_unknown(NphSceneReader *reader, const NphSceneSection *section, const yaml_node_t *node) {
    char quote[NPH_QUOTE_BYTES], hint[96], list[400] = "";
    const char *text = (const char *)node->data.scalar.value;
    if (strcmp(text, "<<") == 0) {
        nph_scene_mistake(reader, nph_node_place(node), "merge keys ('<<') are not supported; write the keys out");
        return;
    }
    suggest(section, text, hint, sizeof hint);
    for (int i = 0; i < section->count; i++) {
        if (i > 0 && strcmp(section->keys[i].key, section->keys[i - 1].key) == 0) continue;
        if (!nph_words_apply(section->keys[i].applies, section->variant[0] ? section->variant : NULL)) continue;
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s", list[0] ? ", " : "", section->keys[i].key);
    }
    nph_scene_mistake(reader, nph_node_place(node), "unknown key %s in %s%s; allowed: %s", nph_node_quote(node, quote),
                      section->info->place, hint, list);
}

static void read_pair(NphSceneReader *reader, NphSceneSection *section, const yaml_node_t *key,
                      const yaml_node_t *node) {
    char quote[NPH_QUOTE_BYTES];
    int any;
    if (key->type != YAML_SCALAR_NODE || strlen((const char *)key->data.scalar.value) != key->data.scalar.length) {
        nph_scene_mistake(reader, nph_node_place(key), "a key of %s is %s; keys are words", section->info->place,
                          nph_node_quote(key, quote));
        return;
    }
    int row = find_row(section, (const char *)key->data.scalar.value, &any);
    if (row >= 0 && section->values[row].given) {
        nph_scene_mistake(reader, nph_node_place(key), "%s is given twice; first in line %d", section->keys[row].key,
                          section->values[row].place.line);
    } else if (row >= 0) {
        nph_value_read(reader, &section->keys[row], node, &section->values[row]);
    } else if (any >= 0) {
        report_misplaced(reader, section, key, any);
    } else {
        report_unknown(reader, section, key);
    }
}

/* Sets the variant from `type` or the ending of `file`; leaves it unknown when that is missing or wrong, which the
 * reading of that key will report. */
static void find_variant(NphSceneReader *reader, NphSceneSection *section) {
    int any, file = strcmp(section->info->variant_key, "file") == 0;
    const char *text = NULL;
    const NphSceneKey *key = &section->keys[find_row(section, section->info->variant_key, &any)];
    if (key->fallback && key->fallback != nph_key_required) text = key->fallback;
    yaml_node_pair_t *pair = section->node->data.mapping.pairs.start;
    for (; pair < section->node->data.mapping.pairs.top; pair++) {
        yaml_node_t *name = yaml_document_get_node(&reader->document, pair->key);
        yaml_node_t *node = yaml_document_get_node(&reader->document, pair->value);
        if (name->type != YAML_SCALAR_NODE || strcmp((const char *)name->data.scalar.value, key->key) != 0) continue;
        text = node->type == YAML_SCALAR_NODE ? (const char *)node->data.scalar.value : NULL;
        break;
    }
    section->variant_unknown = 1;
    if (text && file) text = strrchr(text, '.') ? strrchr(text, '.') + 1 : "";
    if (!text || nph_words_index(section->info->variants, text) < 0) return;
    snprintf(section->variant, sizeof section->variant, "%s", text);
    section->variant_unknown = 0;
}

/* A file whose ending says nothing; a wrong `type` has been reported with its own value. */
static void check_variant(NphSceneReader *reader, const NphSceneSection *section) {
    char quote[NPH_QUOTE_BYTES], ending[16], list[80] = "";
    if (!section->variant_unknown || strcmp(section->info->variant_key, "file") != 0) return;
    const NphSceneValue *file = nph_section_value(section, "file");
    if (!file) return;
    for (int n = 0; nph_words_get(section->info->variants, n, ending, sizeof ending); n++)
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s.%s", n ? ", " : "", ending);
    nph_scene_mistake(reader, file->place, "file: %s ends in none of %s", nph_node_quote(file->node, quote), list);
}

static void check_missing(NphSceneReader *reader, NphSceneSection *section) {
    for (int i = 0; i < section->count; i++) {
        const NphSceneKey *key = &section->keys[i];
        NphSceneValue *value = &section->values[i];
        int unsure = section->variant_unknown && key->applies;
        if (value->given || unsure || !nph_words_apply(key->applies, section->variant[0] ? section->variant : NULL))
            continue;
        value->place = section->place;
        nph_value_default(key, value);
        if (key->fallback != nph_key_required) continue;
        char word[32], list[128] = "";
        for (int n = 0; key->type == NPH_KEY_WORD && nph_words_get(key->words, n, word, sizeof word); n++)
            snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s", n ? ", " : " (one of ", word);
        nph_scene_mistake(reader, section->place, "%s lacks %s%s%s", section->info->place, key->key, list,
                          list[0] ? ")" : "");
    }
}

/* Walks "a b? | c" word by word: copies the next key, says which alternative it belongs to and whether it may be left
 * out; returns what follows, NULL at the end. */
static const char *next_alternative(const char *at, char *key, int *alternative, int *optional) {
    while (*at == ' ' || *at == '|') *alternative += *at++ == '|';
    if (!*at) return NULL;
    size_t length = strcspn(at, " |?");
    memcpy(key, at, length);
    key[length] = 0;
    at += length;
    *optional = *at == '?';
    return at + *optional;
}

static void describe_rule(const char *alternatives, char *text, size_t size) {
    char key[32];
    int alternative = 0, optional, last = -1;
    text[0] = 0;
    for (const char *at = alternatives; (at = next_alternative(at, key, &alternative, &optional));) {
        const char *link = last < 0 ? "" : last == alternative ? " with " : ", or ";
        snprintf(text + strlen(text), size - strlen(text), "%s%s", link, key);
        last = alternative;
    }
}

static const NphSceneValue *value_written(const NphSceneSection *section, const char *key) {
    int any, row = find_row(section, key, &any);
    return row >= 0 && section->values[row].given ? &section->values[row] : NULL;
}

static int check_rule(NphSceneReader *reader, NphSceneSection *section, const NphSceneRule *rule) {
    char key[32], first[32] = "", text[160];
    int alternative = 0, optional, chosen = -1;
    describe_rule(rule->alternatives, text, sizeof text);
    for (const char *at = rule->alternatives; (at = next_alternative(at, key, &alternative, &optional));) {
        const NphSceneValue *value = value_written(section, key);
        if (!value) continue;
        if (chosen >= 0 && chosen != alternative) {
            nph_scene_mistake(reader, value->place, "%s and %s exclude each other; give %s", first, key, text);
            return -1;
        }
        if (chosen < 0) strcpy(first, key);
        chosen = alternative;
    }
    if (chosen < 0) {
        nph_scene_mistake(reader, section->place, "%s lacks %s", section->info->place, text);
        return -1;
    }
    alternative = 0;
    for (const char *at = rule->alternatives; (at = next_alternative(at, key, &alternative, &optional));) {
        if (alternative != chosen || optional || value_written(section, key)) continue;
        nph_scene_mistake(reader, section->place, "%s is given without %s; give %s", first, key, text);
        return -1;
    }
    return chosen;
}

int nph_section_read(NphSceneReader *reader, const yaml_node_t *node, const char *name, NphSceneSection *section) {
    char quote[NPH_QUOTE_BYTES];
    int rules = 0;
    memset(section, 0, sizeof *section);
    section->info = nph_scene_section_info(name);
    section->keys = nph_scene_section_keys(name, &section->count);
    section->node = node;
    section->place = nph_node_place(node);
    for (int i = 0; i < 4; i++) section->chosen[i] = -1;
    if (node->type != YAML_MAPPING_NODE) {
        nph_scene_mistake(reader, section->place, "%s: %s where a mapping (key: value) is expected",
                          section->info->place, nph_node_quote(node, quote));
        return 0;
    }
    if (section->info->variant_key) find_variant(reader, section);
    yaml_node_pair_t *pair = node->data.mapping.pairs.start;
    for (; pair < node->data.mapping.pairs.top; pair++)
        read_pair(reader, section, yaml_document_get_node(&reader->document, pair->key),
                  yaml_document_get_node(&reader->document, pair->value));
    if (section->info->variant_key) check_variant(reader, section);
    check_missing(reader, section);
    for (int i = 0; i < nph_scene_rule_count; i++) {
        const NphSceneRule *rule = &nph_scene_rules[i];
        if (strcmp(rule->section, name) != 0) continue;
        int applies = !rule->applies || (!section->variant_unknown && nph_words_apply(rule->applies, section->variant));
        section->chosen[rules++] = applies ? check_rule(reader, section, rule) : -1;
    }
    return 1;
}

const NphSceneValue *nph_section_value(const NphSceneSection *section, const char *key) {
    int any, row = find_row(section, key, &any);
    return row >= 0 && section->values[row].valid ? &section->values[row] : NULL;
}
