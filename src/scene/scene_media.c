/* SPDX-License-Identifier: Apache-2.0
 *
 * The media section to NphMedium: name, shape, transform, coefficients, phase function. What a density file holds comes
 * later (scene_files.c); here its settings are kept in reader->volumes. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/memory.h"
#include "core/text.h"
#include "scene/scene_read.h"

static const double FARTHEST_M = 1e12, MOST_PER_M = 1e9;

static NphStatus read_name(NphSceneReader *reader, const NphSceneSection *section, int index) {
    const NphSceneValue *name = nph_section_value(section, "name");
    char own[24], quote[NPH_QUOTE_BYTES];
    NphMedium *media = reader->scene->media;
    snprintf(own, sizeof own, "medium%d", index);
    const char *text = name ? name->text : own;
    for (int i = 0; i < index; i++) {
        if (strcmp(media[i].name, text) != 0) continue;
        nph_scene_mistake(reader, name ? name->place : section->place, "the name %s is taken by medium number %d; "
                          "names differ", nph_text_quote(text, strlen(text), quote), i);
        break;
    }
    return nph_strdup(reader->context, text, &media[index].name);
}

/* Which file of a sequence that is sparser than frames: the last one that is not ahead of the frame, from the first on. */
static uint32_t number_of_file(NphSceneReader *reader, const NphSceneValue *value, const NphSceneValue *file) {
    NphSceneSection section;
    if (!value || !nph_section_read(reader, value->node, "numbers", &section)) return reader->frame;
    const NphSceneValue *first = nph_section_value(&section, "first"), *last = nph_section_value(&section, "last");
    const NphSceneValue *step = nph_section_value(&section, "step");
    if (!first || !last || !step) return reader->frame;
    int64_t from = (int64_t)first->number[0], to = (int64_t)last->number[0], by = (int64_t)step->number[0], at = reader->frame;
    if (to < from || (to - from) % by != 0)
        nph_scene_mistake(reader, last->place, "last is %lld; expected first, %lld, plus a whole number of steps of %lld", (long long)to,
                          (long long)from, (long long)by);
    if (!strchr(file->text, '#'))
        nph_scene_mistake(reader, value->place, "numbers is given, but no # in the name of the file stands for one");
    if (at > to) at = to;
    return (uint32_t)(at < from ? from : from + (at - from) / by * by);
}

NphStatus nph_scene_read_density(NphSceneReader *reader, const NphSceneValue *value, NphSceneFile *volume) {
    NphSceneSection density;
    if (!nph_section_read(reader, value->node, "density", &density)) return NPH_OK;
    const NphSceneValue *file = nph_section_value(&density, "file"), *grid = nph_section_value(&density, "grid");
    const NphSceneValue *lookup = nph_section_value(&density, "lookup"), *box = nph_section_value(&density, "box");
    const NphSceneValue *centring = nph_section_value(&density, "centring");
    const NphSceneValue *outside = nph_section_value(&density, "outside");
    if (!file || density.variant_unknown) return NPH_OK;
    volume->place = file->place;
    volume->kind = nph_words_index(density.info->variants, density.variant);
    volume->grid = grid ? grid->text : NULL;
    volume->lookup = lookup && lookup->word == 1 ? NPH_LOOKUP_NEAREST : NPH_LOOKUP_TRILINEAR;
    volume->centring = centring ? (NphCentring)centring->word : NPH_CENTRING_CELL;
    volume->outside = outside && outside->word == 1 ? NPH_OUTSIDE_CLAMP : NPH_OUTSIDE_ZERO;
    if (box) {
        memcpy(volume->lo, box->number, sizeof volume->lo);
        memcpy(volume->hi, box->number + 3, sizeof volume->hi);
    }
    int mistakes = reader->mistakes;
    uint32_t number = number_of_file(reader, nph_section_value(&density, "numbers"), file);
    return reader->mistakes > mistakes ? NPH_OK : nph_scene_file_path(reader, file, "volume", number, &volume->path);
}

static NphStatus read_shape(NphSceneReader *reader, const NphSceneSection *section, NphMedium *medium,
                            NphSceneFile *volume) {
    const NphSceneValue *density = nph_section_value(section, "density"), *box = nph_section_value(section, "box");
    const NphSceneValue *layer = nph_section_value(section, "layer");
    if (section->chosen[0] == 0 && density) return nph_scene_read_density(reader, density, volume);
    if (section->chosen[0] == 1 && box) {
        medium->shape = NPH_SHAPE_BOX;
        memcpy(medium->lo, box->number, sizeof medium->lo);
        memcpy(medium->hi, box->number + 3, sizeof medium->hi);
    } else if (section->chosen[0] == 2 && layer) {
        medium->shape = NPH_SHAPE_LAYER;
        for (int axis = 0; axis < 3; axis++) {
            medium->lo[axis] = axis == 2 ? layer->number[0] : -HUGE_VAL;
            medium->hi[axis] = axis == 2 ? layer->number[1] : HUGE_VAL;
        }
    }
    return NPH_OK;
}

/* sigma_t = sigma_s + sigma_a, albedo = sigma_s / sigma_t (1 where nothing is, as the default albedo). */
static void read_coefficients(NphSceneReader *reader, const NphSceneSection *section, NphMedium *medium,
                              NphSceneFile *volume) {
    const NphSceneValue *extinction = nph_section_value(section, "extinction"),
                        *albedo = nph_section_value(section, "albedo");
    const NphSceneValue *scattering = nph_section_value(section, "scattering");
    const NphSceneValue *absorption = nph_section_value(section, "absorption");
    if (section->chosen[1] == 0 && extinction && albedo) {
        volume->extinction_place = extinction->place;
        nph_scene_take_rgb(reader, extinction, medium->extinction_per_m, medium->extinction_spectrum);
        nph_scene_take_rgb(reader, albedo, medium->albedo, medium->albedo_spectrum);
    } else if (section->chosen[1] == 1 && scattering && absorption) {
        volume->extinction_place = scattering->given ? scattering->place : absorption->place;
        NphSceneValue sum = *scattering, share = *scattering;
        int channels = reader->scene->wavelength_count > 0 ? reader->scene->wavelength_count : 3;
        for (int i = 0; i < channels; i++) {
            sum.number[i] = scattering->number[i] + absorption->number[i];
            share.number[i] = sum.number[i] > 0 ? scattering->number[i] / sum.number[i] : 1;
            if (sum.number[i] <= MOST_PER_M) continue;
            nph_scene_mistake(reader, volume->extinction_place, "scattering + absorption exceed 1e9 1/m");
            break;
        }
        nph_scene_take_rgb(reader, &sum, medium->extinction_per_m, medium->extinction_spectrum);
        nph_scene_take_rgb(reader, &share, medium->albedo, medium->albedo_spectrum);
    }
}

NphStatus nph_scene_read_phase(NphSceneReader *reader, const NphSceneValue *value, NphPhase *phase, NphSceneFile *table, NphSceneMie *mie) {
    NphSceneSection section;
    if (!value || !nph_section_read(reader, value->node, "phase", &section)) return NPH_OK;
    const NphSceneValue *type = nph_section_value(&section, "type"), *g = nph_section_value(&section, "g");
    const NphSceneValue *g2 = nph_section_value(&section, "g2"), *weight = nph_section_value(&section, "weight");
    const NphSceneValue *alpha = nph_section_value(&section, "alpha"), *file = nph_section_value(&section, "file");
    if (type && type->word == NPH_PHASE_KINDS) nph_scene_read_mie(reader, &section, mie); /* becomes a table */
    else if (type) phase->kind = (NphPhaseKind)type->word;
    if (g) phase->g[0] = g->number[0];
    if (g2) phase->g[1] = g2->number[0];
    if (weight) phase->weight = weight->number[0];
    if (alpha) phase->alpha = alpha->number[0];
    if (!file) return NPH_OK;
    table->place = file->place;
    return nph_scene_file_path(reader, file, "table of the phase function", reader->frame, &table->path);
}

/* A transformed medium must stay where doubles are fine. A grid's own box is known once it is loaded. */
void nph_scene_check_reach(NphSceneReader *reader, NphScenePlace place, const NphMedium *medium) {
    double lo[3], hi[3];
    nph_medium_bounds(medium, lo, hi);
    for (int axis = 0; axis < 3; axis++) {
        if (medium->shape == NPH_SHAPE_LAYER && axis < 2) continue;
        if (lo[axis] >= -FARTHEST_M && hi[axis] <= FARTHEST_M && lo[axis] < hi[axis]) continue;
        nph_scene_mistake(reader, place, "after its transform this medium is flat or lies beyond 1e12 m along %c",
                          "xyz"[axis]);
        return;
    }
}

static NphStatus read_medium(NphSceneReader *reader, const yaml_node_t *node, int index) {
    NphSceneSection section;
    NphMedium *medium = &reader->scene->media[index];
    NphSceneFile *volume = &reader->volumes[index];
    nph_affine_identity(medium->world_from_medium);
    int whole = nph_section_read(reader, node, "medium", &section);
    NPH_TRY(read_name(reader, &section, index));
    if (!whole) return NPH_OK;
    NPH_TRY(read_shape(reader, &section, medium, volume));
    read_coefficients(reader, &section, medium, volume);
    NPH_TRY(nph_scene_read_phase(reader, nph_section_value(&section, "phase"), &medium->phase, &reader->phases[index], &reader->mies[index]));
    const NphSceneValue *emission = nph_section_value(&section, "emission");
    if (emission) NPH_TRY(nph_scene_read_emission(reader, emission, index));
    const NphSceneValue *transform = nph_section_value(&section, "transform");
    if (!transform) return NPH_OK;
    int layer = medium->shape == NPH_SHAPE_LAYER;
    int right = nph_scene_read_transform(reader, transform->node, layer, medium->world_from_medium);
    if (right && medium->shape != NPH_SHAPE_GRID) nph_scene_check_reach(reader, transform->place, medium);
    return NPH_OK;
}

NphStatus nph_scene_read_media(NphSceneReader *reader, const yaml_node_t *list) {
    yaml_node_item_t *items = list->data.sequence.items.start;
    int count = (int)(list->data.sequence.items.top - items);
    for (int i = 0; i < count && i < NPH_MAX_MEDIA; i++) {
        reader->scene->medium_count = i + 1;
        NPH_TRY(read_medium(reader, yaml_document_get_node(&reader->document, items[i]), i));
    }
    return NPH_OK;
}
