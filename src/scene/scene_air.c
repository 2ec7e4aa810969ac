/* SPDX-License-Identifier: Apache-2.0
 *
 * The air section, and what the air leaves of the lights at infinity. A light from direction w has its radiance times
 * exp(-beta column(height, w_z)) (optics/air.h), the same all over the scene: a sun becomes weaker; the texels of a map
 * take the mean over their row, where the sine of the elevation is uniform in solid angle; a constant light becomes a map
 * of one column. */
#include <string.h>

#include "core/fmath.h"
#include "core/memory.h"
#include "core/text.h"
#include "io/air_rows.h"
#include "optics/air.h"
#include "scene/scene_read.h"

static const double RED_NM = 680, GREEN_NM = 550, BLUE_NM = 440; /* [Riley04 table 3] */
static const double WIDEST_SUN_RAD = 0.0175;                     /* half of it: a disc is attenuated as its middle is */

enum { CONSTANT_ROWS = 1024, ROW_STEPS = 64 };

/* ---- the section ---- */

static void read_extinction(NphSceneReader *reader, const NphSceneSection *section, NphSceneAir *air) {
    const NphSceneValue *extinction = nph_section_value(section, "extinction");
    const NphScene *scene = reader->scene;
    if (extinction && extinction->given) {
        nph_scene_take_rgb(reader, extinction, air->extinction_per_m, air->extinction_spectrum);
        return;
    }
    NphSceneValue rayleigh = {.number = {nph_rayleigh_per_m(RED_NM), nph_rayleigh_per_m(GREEN_NM), nph_rayleigh_per_m(BLUE_NM)}};
    for (int i = 0; i < scene->wavelength_count; i++) rayleigh.number[i] = nph_rayleigh_per_m(scene->wavelengths_nm[i]);
    nph_scene_take_rgb(reader, &rayleigh, air->extinction_per_m, air->extinction_spectrum);
}

NphStatus nph_scene_read_air(NphSceneReader *reader, const yaml_node_t *node) {
    NphSceneSection section;
    NphSceneAir *air = &reader->scene->air;
    if (!nph_section_read(reader, node, "air", &section) || section.variant_unknown) return NPH_OK;
    const NphSceneValue *height = nph_section_value(&section, "height"), *file = nph_section_value(&section, "file");
    const NphSceneValue *scale = nph_section_value(&section, "scale_height"), *ground = nph_section_value(&section, "ground");
    const NphSceneValue *radius = nph_section_value(&section, "radius");
    air->kind = strcmp(section.variant, "table") == 0 ? NPH_AIR_TABLE : NPH_AIR_EXPONENTIAL;
    reader->air_place = section.place;
    read_extinction(reader, &section, air);
    if (scale) air->scale_height_m = scale->number[0];
    if (ground) air->ground_m = ground->number[0];
    if (radius) air->radius_m = radius->number[0];
    if (height && height->given) {
        air->height_m = height->number[0];
        reader->height_place = height->place;
    }
    if (!file || !file->given) return NPH_OK;
    if (scale && scale->given) nph_scene_mistake(reader, scale->place, "scale_height and file exclude each other");
    reader->air_profile.place = file->place;
    return nph_scene_file_path(reader, file, "profile of the air", reader->frame, &reader->air_profile.path);
}

/* ---- attenuation ---- */

/* What is known of the air at the height that stands for the scene. */
typedef struct Attenuation {
    const NphSceneAir *air;
    NphAirTable table;
    double height_m; /* above sea level */
    double top_m;    /* end of the table, or infinite */
} Attenuation;

static double column(const Attenuation *attenuation, double sine) {
    if (attenuation->air->kind == NPH_AIR_TABLE) return nph_air_table_column(&attenuation->table, attenuation->height_m, sine);
    return nph_air_column_above(attenuation->air->scale_height_m, attenuation->height_m, sine);
}

/* Mean transmittances of the rows of a map [height][3]; a constant light's hemisphere leaves out others. */
static void fill_rows(const Attenuation *attenuation, int height, int hemisphere, double *factors) {
    for (int row = 0; row < height; row++) {
        double top, bottom, unused, sum[3] = {0.0, 0.0, 0.0};
        nph_sincos2pi(0.5 * row / height, &unused, &top);
        nph_sincos2pi(0.5 * (row + 1.0) / height, &unused, &bottom);
        for (int i = 0; i < ROW_STEPS; i++) {
            double sine = top + (bottom - top) * (i + 0.5) / ROW_STEPS;
            if (hemisphere * sine < 0.0) continue;
            double metres = column(attenuation, sine);
            for (int c = 0; c < 3; c++) sum[c] += nph_air_transmittance(attenuation->air->extinction_per_m[c], metres);
        }
        for (int c = 0; c < 3; c++) factors[3 * row + c] = sum[c] / ROW_STEPS;
    }
}

static NphStatus attenuate_map(NphSceneReader *reader, const Attenuation *attenuation, int hemisphere, NphEnvironment *map) {
    double *factors = NULL;
    NPH_TRY(NPH_NEW(reader->context, 3 * (int64_t)map->height, "transmittance of the air", &factors));
    fill_rows(attenuation, map->height, hemisphere, factors);
    NphStatus status = nph_environment_scale_rows(reader->context, factors, map);
    nph_free(reader->context, factors);
    return status;
}

static void attenuate_sun(NphSceneReader *reader, const Attenuation *attenuation, NphLight *light) {
    const NphSceneAir *air = attenuation->air;
    double metres = column(attenuation, light->direction[2]);
    int count = reader->scene->wavelength_count;
    if (!(metres < nph_infinity()))
        nph_warn(reader->context, "%s: the sun %s is not above the horizon of the air, which lets nothing of it through",
                 reader->name, light->name);
    for (int c = 0; c < 3; c++) light->irradiance[c] *= nph_air_transmittance(air->extinction_per_m[c], metres);
    for (int i = 0; i < count; i++) light->spectrum[i] *= nph_air_transmittance(air->extinction_spectrum[i], metres);
    if (count > 0) nph_spectrum_thirds(light->spectrum, count, light->irradiance);
}

static NphStatus attenuate_light(NphSceneReader *reader, const Attenuation *attenuation, int index) {
    NphLight *light = &reader->scene->lights[index];
    if (light->kind == NPH_LIGHT_SUN) {
        if (light->half_angle_rad > WIDEST_SUN_RAD)
            nph_scene_mistake(reader, reader->light_places[index], "a sun wider than 2 degrees does not go with air, which "
                              "attenuates a whole disc as its middle; give the light air: ignored");
        else attenuate_sun(reader, attenuation, light);
        return NPH_OK;
    }
    if (reader->scene->wavelength_count > 0) {
        nph_scene_mistake(reader, reader->light_places[index], "with wavelengths the air attenuates suns alone, since maps have "
                          "no spectrum; give the light air: ignored");
        return NPH_OK;
    }
    if (light->kind == NPH_LIGHT_CONSTANT) {
        NPH_TRY(nph_environment_uniform(reader->context, CONSTANT_ROWS, light->radiance, &light->map));
        light->kind = NPH_LIGHT_ENVIRONMENT;
    }
    return attenuate_map(reader, attenuation, light->hemisphere, &light->map);
}

static NphStatus build_table(NphSceneReader *reader, Attenuation *attenuation) {
    NphContext *context = reader->context;
    const NphSceneAir *air = attenuation->air;
    NphAirProfile profile = {0};
    NphArray rows = {0};
    NphStatus status = NPH_OK;
    if (reader->air_profile.path) {
        status = nph_air_rows_read(context, reader->air_profile.path, &rows);
        if (status == NPH_OK) status = nph_air_profile_from_rows(context, &rows, air->radius_m, &profile);
        nph_array_free(context, &rows);
    } else {
        status = nph_air_profile_exponential(context, air->scale_height_m, air->radius_m, &profile);
    }
    if (status == NPH_OK) attenuation->top_m = profile.levels[profile.count - 1].height_m;
    if (status == NPH_OK) status = nph_air_table_build(context, &profile, &attenuation->table);
    return reader->air_profile.path ? nph_scene_note(reader, &reader->air_profile, "profile of the air", status) : status;
}

/* 0 after a mistake. */
static int check_height(NphSceneReader *reader, const Attenuation *attenuation) {
    const NphSceneAir *air = attenuation->air;
    int before = reader->mistakes, written = reader->height_place.line > 0;
    NphScenePlace place = written ? reader->height_place : reader->air_place;
    const char *middle = written ? "" : ", the middle of the scene,";
    char z[NPH_DOUBLE_TEXT], ground[NPH_DOUBLE_TEXT], end[NPH_DOUBLE_TEXT];
    nph_format_double(air->height_m, z);
    nph_format_double(air->ground_m, ground);
    nph_format_double(air->ground_m + attenuation->top_m, end);
    if (attenuation->height_m < 0.0)
        nph_scene_mistake(reader, place, "height%s is %s m, below the ground of the air at %s m", middle, z, ground);
    if (attenuation->height_m > attenuation->top_m)
        nph_scene_mistake(reader, place, "height%s is %s m, above the end of the air's table at %s m", middle, z, end);
    return reader->mistakes == before;
}

NphStatus nph_scene_attenuate_lights(NphSceneReader *reader) {
    NphScene *scene = reader->scene;
    NphSceneAir *air = &scene->air;
    Attenuation attenuation = {.air = air, .top_m = nph_infinity()};
    NphStatus status = NPH_OK;
    if (air->kind == NPH_AIR_NONE) return NPH_OK;
    if (reader->height_place.line == 0) {
        double origin[3];
        nph_scene_origin(scene, origin);
        air->height_m = origin[2];
    }
    attenuation.height_m = air->height_m - air->ground_m;
    if (air->kind == NPH_AIR_TABLE) status = build_table(reader, &attenuation);
    int usable = status == NPH_OK && reader->bad_inputs == 0 && check_height(reader, &attenuation);
    for (int l = 0; l < scene->light_count && usable && status == NPH_OK; l++)
        if (scene->lights[l].kind != NPH_LIGHT_POINT && !reader->bare[l]) status = attenuate_light(reader, &attenuation, l);
    nph_air_table_free(reader->context, &attenuation.table);
    return status;
}
