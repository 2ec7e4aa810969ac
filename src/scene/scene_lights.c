/* SPDX-License-Identifier: Apache-2.0
 *
 * The lights section to NphLight. An environment's image comes later (scene_files.c). */
#include <stdio.h>
#include <string.h>

#include "core/fmath.h"
#include "core/memory.h"
#include "scene/scene_read.h"

static const double PI = 3.14159265358979323846;
static const double MOST_RADIANCE = 1e35, SMALLEST_SUN_DEGREES = 0.001;

enum { SKY = NPH_LIGHT_POINT + 1 }; /* of the words: the kinds in their order, and this */

static void copy3(double to[3], const NphSceneValue *value) {
    if (value) memcpy(to, value->number, 3 * sizeof to[0]);
}

static void read_sun_direction(NphSceneReader *reader, const NphSceneSection *section, NphLight *light) {
    const NphSceneValue *direction = nph_section_value(section, "direction");
    const NphSceneValue *elevation = nph_section_value(section, "elevation"),
                        *azimuth = nph_section_value(section, "azimuth");
    if (section->chosen[0] == 0 && direction) {
        if (!nph_vector_normalise(direction->number, light->direction))
            nph_scene_mistake(reader, direction->place, "direction has length 0; it points towards the sun");
    } else if (section->chosen[0] == 1 && elevation && azimuth) {
        double rise, flat, sine, cosine;
        nph_sincos2pi(elevation->number[0] / 360, &rise, &flat);
        nph_sincos2pi(azimuth->number[0] / 360, &sine, &cosine);
        light->direction[0] = flat * cosine;
        light->direction[1] = flat * sine;
        light->direction[2] = rise;
    }
}

/* A disc's radiance is E / (pi sin^2 half_angle): it must fit as well. */
static void read_sun(NphSceneReader *reader, const NphSceneSection *section, NphLight *light) {
    const NphSceneValue *irradiance = nph_section_value(section, "irradiance");
    const NphSceneValue *diameter = nph_section_value(section, "angular_diameter");
    read_sun_direction(reader, section, light);
    if (irradiance) nph_scene_take_rgb(reader, irradiance, light->irradiance, light->spectrum);
    if (!diameter || diameter->number[0] == 0) return;
    if (diameter->number[0] < SMALLEST_SUN_DEGREES) {
        nph_scene_mistake(reader, diameter->place, "angular_diameter is below 0.001 degrees; use 0 for parallel light");
        return;
    }
    double sine, cosine;
    light->half_angle_rad = diameter->number[0] * (PI / 360);
    nph_sincos2pi(diameter->number[0] / 720, &sine, &cosine);
    int channels = reader->scene->wavelength_count > 0 ? reader->scene->wavelength_count : 3;
    for (int i = 0; i < channels && irradiance; i++) {
        if (irradiance->number[i] <= MOST_RADIANCE * PI * sine * sine) continue;
        nph_scene_mistake(reader, irradiance->place,
                          "irradiance gives a disc this small a radiance beyond 1e35 W/m2/sr");
        return;
    }
}

static NphStatus read_environment(NphSceneReader *reader, const NphSceneSection *section, NphLight *light,
                                  NphSceneFile *map) {
    const NphSceneValue *rotation = nph_section_value(section, "rotation"), *file = nph_section_value(section, "file");
    const NphSceneValue *scale = nph_section_value(section, "scale");
    copy3(map->scale, scale);
    for (int i = 1; i < reader->scene->wavelength_count && scale; i++) {
        if (scale->number[i] == scale->number[0]) continue;
        nph_scene_mistake(reader, scale->place, "with wavelengths the scale of a map is one number: maps have no spectrum");
        break;
    }
    if (reader->scene->wavelength_count > 0) map->scale[1] = map->scale[2] = map->scale[0];
    if (rotation) light->rotation_rad = rotation->number[0] * (PI / 180);
    if (!file) return NPH_OK;
    map->place = file->place;
    return nph_scene_file_path(reader, file, "environment map", reader->frame, &map->path);
}

/* What the air makes of this sun; a map from then on (scene_air_lights.c). */
static void read_sky(NphSceneReader *reader, const NphSceneSection *section, int index) {
    NphLight *light = &reader->scene->lights[index];
    const NphSceneValue *irradiance = nph_section_value(section, "irradiance"), *rows = nph_section_value(section, "rows");
    light->kind = NPH_LIGHT_ENVIRONMENT;
    read_sun_direction(reader, section, light);
    copy3(light->irradiance, irradiance);
    reader->sky_rows[index] = rows ? (int)rows->number[0] : 2;
    if (reader->scene->wavelength_count > 0)
        nph_scene_mistake(reader, section->place, "a sky is a map of R, G, B, which does not go with wavelengths");
}

static NphStatus read_light(NphSceneReader *reader, const yaml_node_t *node, int index) {
    NphSceneSection section;
    NphLight *light = &reader->scene->lights[index];
    char name[24];
    snprintf(name, sizeof name, "light%d", index);
    NPH_TRY(nph_strdup(reader->context, name, &light->name));
    if (!nph_section_read(reader, node, "light", &section) || section.variant_unknown) return NPH_OK;
    const NphSceneValue *type = nph_section_value(&section, "type"), *hemisphere, *value;
    if (!type) return NPH_OK;
    reader->light_places[index] = section.place;
    reader->bare[index] = (value = nph_section_value(&section, "air")) && value->word == 1;
    if (type->word == SKY) {
        read_sky(reader, &section, index);
        return NPH_OK;
    }
    light->kind = (NphLightKind)type->word;
    switch (light->kind) {
    case NPH_LIGHT_SUN: read_sun(reader, &section, light); break;
    case NPH_LIGHT_CONSTANT:
        if ((value = nph_section_value(&section, "radiance")))
            nph_scene_take_rgb(reader, value, light->radiance, light->spectrum);
        hemisphere = nph_section_value(&section, "hemisphere");
        if (hemisphere) light->hemisphere = hemisphere->word == 0 ? 0 : hemisphere->word == 1 ? 1 : -1;
        break;
    case NPH_LIGHT_ENVIRONMENT: return read_environment(reader, &section, light, &reader->maps[index]);
    case NPH_LIGHT_POINT:
        copy3(light->position, nph_section_value(&section, "position"));
        if ((value = nph_section_value(&section, "intensity")))
            nph_scene_take_rgb(reader, value, light->intensity, light->spectrum);
        break;
    }
    return NPH_OK;
}

NphStatus nph_scene_read_lights(NphSceneReader *reader, const yaml_node_t *list) {
    yaml_node_item_t *items = list->data.sequence.items.start;
    int count = (int)(list->data.sequence.items.top - items);
    for (int i = 0; i < count && i < NPH_MAX_LIGHTS; i++) {
        reader->scene->light_count = i + 1;
        NPH_TRY(read_light(reader, yaml_document_get_node(&reader->document, items[i]), i));
    }
    return NPH_OK;
}
