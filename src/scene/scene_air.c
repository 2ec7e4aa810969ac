/* SPDX-License-Identifier: Apache-2.0
 *
 * The air section, and the aerosol in it. What becomes of the lights: scene_air_lights.c. */
#include <string.h>

#include "core/fmath.h"
#include "optics/air.h"
#include "scene/scene_read.h"

static const double RGB_NM[3] = {680, 550, 440};                 /* [Riley04 table 3] */
static const double TURBIDITY_NM = 550, HAZE_G = 0.76;           /* [Bruneton08 sec. 4]: g of aerosol */

static void read_extinction(NphSceneReader *reader, const NphSceneSection *section, NphSceneAir *air) {
    const NphSceneValue *extinction = nph_section_value(section, "extinction");
    const NphScene *scene = reader->scene;
    if (extinction && extinction->given) {
        nph_scene_take_rgb(reader, extinction, air->extinction_per_m, air->extinction_spectrum);
        return;
    }
    NphSceneValue rayleigh = {.number = {nph_rayleigh_per_m(RGB_NM[0]), nph_rayleigh_per_m(RGB_NM[1]), nph_rayleigh_per_m(RGB_NM[2])}};
    for (int i = 0; i < scene->wavelength_count; i++) rayleigh.number[i] = nph_rayleigh_per_m(scene->wavelengths_nm[i]);
    nph_scene_take_rgb(reader, &rayleigh, air->extinction_per_m, air->extinction_spectrum);
}

/* Turbidity T: the aerosol's depth at 550 nm is T - 1 times the air's [Preetham99 sec. 2], and falls as wavelength^-angstrom
 * [Angstrom29]. */
static void read_turbidity(const NphSceneReader *reader, double turbidity, double power, NphSceneAir *air) {
    const NphScene *scene = reader->scene;
    NphSceneValue haze = {0};
    double per_m = (turbidity - 1.0) * nph_rayleigh_per_m(TURBIDITY_NM) * air->scale_height_m / air->aerosol.scale_height_m;
    int count = scene->wavelength_count > 0 ? scene->wavelength_count : 3;
    for (int i = 0; i < count; i++) {
        double nm = scene->wavelength_count > 0 ? scene->wavelengths_nm[i] : RGB_NM[i];
        haze.number[i] = per_m * nph_pow(nm / TURBIDITY_NM, -power);
    }
    nph_scene_take_rgb(reader, &haze, air->aerosol.extinction_per_m, air->aerosol.extinction_spectrum);
}

static NphStatus read_aerosol(NphSceneReader *reader, const NphSceneValue *value, NphSceneAir *air) {
    NphSceneSection section;
    NphSceneAerosol *aerosol = &air->aerosol;
    aerosol->phase = (NphPhase){.kind = NPH_PHASE_HG, .g = {HAZE_G, 0.0}};
    if (!nph_section_read(reader, value->node, "aerosol", &section)) return NPH_OK;
    const NphSceneValue *extinction = nph_section_value(&section, "extinction"), *albedo = nph_section_value(&section, "albedo");
    const NphSceneValue *turbidity = nph_section_value(&section, "turbidity"), *power = nph_section_value(&section, "angstrom");
    const NphSceneValue *scale = nph_section_value(&section, "scale_height"), *phase = nph_section_value(&section, "phase");
    aerosol->given = 1;
    aerosol->scale_height_m = scale ? scale->number[0] : 1.0;
    if (albedo) nph_scene_take_rgb(reader, albedo, aerosol->albedo, aerosol->albedo_spectrum);
    if (section.chosen[0] == 0 && extinction)
        nph_scene_take_rgb(reader, extinction, aerosol->extinction_per_m, aerosol->extinction_spectrum);
    if (section.chosen[0] == 1 && turbidity && power) read_turbidity(reader, turbidity->number[0], power->number[0], air);
    if (phase) aerosol->phase = (NphPhase){0};
    return nph_scene_read_phase(reader, phase, &aerosol->phase, &reader->aerosol_phase, &reader->aerosol_mie);
}

NphStatus nph_scene_read_air(NphSceneReader *reader, const yaml_node_t *node) {
    NphSceneSection section;
    NphSceneAir *air = &reader->scene->air;
    if (!nph_section_read(reader, node, "air", &section) || section.variant_unknown) return NPH_OK;
    const NphSceneValue *height = nph_section_value(&section, "height"), *file = nph_section_value(&section, "file");
    const NphSceneValue *scale = nph_section_value(&section, "scale_height"), *ground = nph_section_value(&section, "ground");
    const NphSceneValue *radius = nph_section_value(&section, "radius"), *where = nph_section_value(&section, "where");
    const NphSceneValue *aerosol = nph_section_value(&section, "aerosol");
    air->kind = strcmp(section.variant, "table") == 0 ? NPH_AIR_TABLE : NPH_AIR_EXPONENTIAL;
    reader->air_place = section.place;
    read_extinction(reader, &section, air);
    if (scale) air->scale_height_m = scale->number[0];
    if (ground) air->ground_m = ground->number[0];
    if (radius) air->radius_m = radius->number[0];
    if (where) air->within = where->word == 1;
    if ((where = nph_section_value(&section, "ground_albedo"))) nph_scene_take_rgb(reader, where, air->ground_albedo, air->ground_albedo_spectrum);
    if (aerosol) NPH_TRY(read_aerosol(reader, aerosol, air));
    if (height && height->given) {
        air->height_m = height->number[0];
        reader->height_place = height->place;
    }
    if (!file || !file->given) return NPH_OK;
    if (scale && scale->given) nph_scene_mistake(reader, scale->place, "scale_height and file exclude each other");
    reader->air_profile.place = file->place;
    return nph_scene_file_path(reader, file, "profile of the air", reader->frame, &reader->air_profile.path);
}
