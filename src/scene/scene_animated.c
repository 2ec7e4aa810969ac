/* SPDX-License-Identifier: Apache-2.0
 *
 * A value that changes with the frame: {frames: [...], values: [...]} in place of it. Every one of the values is read as it would
 * be alone, so that mistakes are found whatever the frame; between two of them each number goes in a straight line, before the
 * first and after the last it stays. */
#include <string.h>

#include "core/text.h"
#include "scene/scene_read.h"

static int length_of(const yaml_node_t *list) { return (int)(list->data.sequence.items.top - list->data.sequence.items.start); }

static const yaml_node_t *entry_of(NphSceneReader *reader, const yaml_node_t *list, int i) {
    return yaml_document_get_node(&reader->document, list->data.sequence.items.start[i]);
}

int nph_animated_meant(NphSceneReader *reader, const yaml_node_t *node) {
    if (node->type != YAML_MAPPING_NODE) return 0;
    for (yaml_node_pair_t *pair = node->data.mapping.pairs.start; pair < node->data.mapping.pairs.top; pair++) {
        const yaml_node_t *key = yaml_document_get_node(&reader->document, pair->key);
        const char *text = key->type == YAML_SCALAR_NODE ? (const char *)key->data.scalar.value : "";
        if (nph_edit_close(text, "frames") || nph_edit_close(text, "values")) return 1;
    }
    return 0;
}

/* Whole numbers that have been checked. */
static double frame_of(NphSceneReader *reader, const yaml_node_t *frames, int i) {
    const yaml_node_t *entry = entry_of(reader, frames, i);
    const char *begin = (const char *)entry->data.scalar.value;
    double frame = 0;
    nph_parse_double_range(begin, begin + entry->data.scalar.length, &frame);
    return frame;
}

/* The value that counts, and how much of the way to the one after it has been gone. */
static int find_segment(NphSceneReader *reader, const yaml_node_t *frames, double *way) {
    int count = length_of(frames), at = 0;
    double now = reader->frame;
    *way = 0;
    while (at + 1 < count && frame_of(reader, frames, at + 1) <= now) at++;
    double from = frame_of(reader, frames, at);
    if (at + 1 < count && now > from) *way = (now - from) / (frame_of(reader, frames, at + 1) - from);
    return at;
}

/* from + way (to - from): exact where both are the same, and never beyond either. */
static void go(double *from, const double *to, double way) {
    for (int i = 0; i < NPH_MAX_WAVELENGTHS; i++) from[i] += (to[i] - from[i]) * way;
}

/* Value number `at`, moved towards the next; the others for their mistakes alone. */
static void read_values(NphSceneReader *reader, const NphSceneKey *key, const yaml_node_t *list, int at, double way,
                        NphSceneValue *value) {
    for (int i = 0; i < length_of(list); i++) {
        NphSceneValue one;
        memset(&one, 0, sizeof one);
        nph_value_read_still(reader, key, entry_of(reader, list, i), &one);
        if (i == at) memcpy(value->number, one.number, sizeof value->number);
        if (i == at + 1 && way > 0) go(value->number, one.number, way);
    }
}

int nph_animated_read(NphSceneReader *reader, const NphSceneKey *key, const yaml_node_t *node, NphSceneValue *value) {
    NphSceneSection section;
    int at = 0, mistakes = reader->mistakes;
    double way = 0;
    value->given = 1;
    value->node = node;
    value->place = nph_node_place(node);
    reader->scene->animated = value->place.animated = 1;
    if (!nph_section_read(reader, node, "animated", &section)) return 0;
    const NphSceneValue *frames = nph_section_value(&section, "frames"), *values = nph_section_value(&section, "values");
    if (frames) at = find_segment(reader, frames->node, &way);
    if (frames && values && length_of(values->node) != length_of(frames->node))
        nph_scene_mistake(reader, values->place, "values has %d entries, frames has %d; expected as many", length_of(values->node),
                          length_of(frames->node));
    if (values) read_values(reader, key, values->node, at, way, value);
    value->valid = reader->mistakes == mistakes && nph_value_check(reader, key, value);
    return value->valid;
}
