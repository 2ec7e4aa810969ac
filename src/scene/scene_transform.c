/* SPDX-License-Identifier: Apache-2.0
 *
 * The steps of a transform, applied in the order they are written: world = last ... second first. Rotation about the
 * unit axis a by angle t: R = cos t I + sin t [a]x + (1 - cos t) a a^T (Rodrigues). */
#include <stdio.h>
#include <string.h>

#include "core/fmath.h"
#include "scene/scene_read.h"

static int refuse_in_layer(NphSceneReader *reader, NphScenePlace place, const char *what) {
    nph_scene_mistake(reader, place,
                      "%s would tilt or stretch a layer; a layer takes translate, a positive uniform scale, "
                      "and rotate about z",
                      what);
    return 0;
}

static int read_scale(NphSceneReader *reader, const NphSceneValue *value, int layer, double map[12]) {
    const double *factor = value->number;
    for (int i = 0; i < 3; i++) {
        if (factor[i] == 0) {
            nph_scene_mistake(reader, value->place, "scale has a factor 0, which flattens the medium");
            return 0;
        }
        map[i * 5] = factor[i];
    }
    int level = factor[0] == factor[1] && factor[1] == factor[2] && factor[0] > 0;
    return !layer || level ? 1 : refuse_in_layer(reader, value->place, "this scale");
}

static int read_rotation(NphSceneReader *reader, const NphSceneValue *value, int layer, double map[12]) {
    NphSceneSection rotation;
    double a[3], sine, cosine;
    if (!nph_section_read(reader, value->node, "rotate", &rotation)) return 0;
    const NphSceneValue *axis = nph_section_value(&rotation, "axis"), *angle = nph_section_value(&rotation, "angle");
    if (!axis || !angle) return 0;
    if (!nph_vector_normalise(axis->number, a)) {
        nph_scene_mistake(reader, axis->place, "axis has length 0");
        return 0;
    }
    if (layer && (a[0] != 0 || a[1] != 0)) return refuse_in_layer(reader, axis->place, "a rotation about this axis");
    nph_sincos2pi(angle->number[0] / 360, &sine, &cosine);
    double cross[9] = {0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            map[i * 4 + j] = (i == j ? cosine : 0) + sine * cross[i * 3 + j] + (1 - cosine) * a[i] * a[j];
    return 1;
}

static int read_step(NphSceneReader *reader, const yaml_node_t *node, int layer, double map[12]) {
    NphSceneSection step;
    const NphSceneValue *value;
    nph_affine_identity(map);
    if (!nph_section_read(reader, node, "transform", &step) || step.chosen[0] < 0) return 0;
    if ((value = nph_section_value(&step, "scale"))) return read_scale(reader, value, layer, map);
    if ((value = nph_section_value(&step, "rotate"))) return read_rotation(reader, value, layer, map);
    if ((value = nph_section_value(&step, "translate"))) {
        for (int i = 0; i < 3; i++) map[i * 4 + 3] = value->number[i];
        return 1;
    }
    if (!(value = nph_section_value(&step, "matrix"))) return 0;
    if (layer) return refuse_in_layer(reader, value->place, "a matrix");
    memcpy(map, value->number, 12 * sizeof map[0]);
    return 1;
}

int nph_scene_read_transform(NphSceneReader *reader, const yaml_node_t *list, int layer, double world_from_medium[12]) {
    double total[12], step[12], inverse[12];
    int right = 1;
    nph_affine_identity(total);
    yaml_node_item_t *item = list->data.sequence.items.start;
    for (; item < list->data.sequence.items.top; item++) {
        const yaml_node_t *node = yaml_document_get_node(&reader->document, *item);
        if (!read_step(reader, node, layer, step)) {
            right = 0;
        } else if (!nph_affine_invert(step, inverse)) {
            nph_scene_mistake(reader, nph_node_place(node), "this step is singular: it flattens space");
            right = 0;
        } else {
            nph_affine_multiply(step, total, total);
        }
    }
    if (right && !nph_affine_invert(total, inverse)) {
        nph_scene_mistake(reader, nph_node_place(list), "the transform as a whole is singular or out of range");
        right = 0;
    }
    if (right) memcpy(world_from_medium, total, sizeof total);
    return right;
}
