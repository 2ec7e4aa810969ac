/* SPDX-License-Identifier: Apache-2.0
 *
 * What the air leaves of the lights at infinity, and what it scatters. A light from direction w has its radiance times
 * exp(-sum beta column(height, w_z)) (optics/air.h), the same all over the scene: a sun becomes weaker; the texels of a map
 * take the mean over their row, where the sine of the elevation is uniform in solid angle; a constant light becomes a map
 * of one column. A sky becomes the map of what arrives at that height of light scattered once (optics/sky.h). */
#include <string.h>

#include "core/fmath.h"
#include "core/memory.h"
#include "core/text.h"
#include "io/air_rows.h"
#include "scene/scene_read.h"

static const double WIDEST_SUN_RAD = 0.0175; /* half of it: a disc is attenuated as its middle is */
static const double WHITE[3] = {1.0, 1.0, 1.0};
static const NphPhase RAYLEIGH = {.kind = NPH_PHASE_RAYLEIGH};

enum { CONSTANT_ROWS = 1024, ROW_STEPS = 64 };

/* What is known of the air at the height that stands for the scene. */
typedef struct Attenuation {
    const NphSceneAir *air;
    NphAirTable tables[NPH_SKY_MOST];
    NphSky sky;      /* without a sun */
    double height_m; /* above sea level */
    double top_m;    /* end of the table, or infinite */
} Attenuation;

/* Which columns a light has; 0 when it does not come through. */
static int columns(const Attenuation *attenuation, double sine, double metres[NPH_SKY_MOST]) {
    nph_sky_columns_above(&attenuation->sky, attenuation->height_m, sine, metres);
    return metres[0] < nph_infinity();
}

static double transmittance(const Attenuation *attenuation, const double metres[NPH_SKY_MOST], double air_per_m, double aerosol_per_m) {
    double T = nph_air_transmittance(air_per_m, metres[0]);
    return attenuation->sky.count > 1 ? T * nph_air_transmittance(aerosol_per_m, metres[1]) : T;
}

/* Mean transmittances of the rows of a map [height][3]; a constant light's hemisphere leaves out others. */
static void fill_rows(const Attenuation *attenuation, int height, int hemisphere, double *factors) {
    const NphSceneAir *air = attenuation->air;
    for (int row = 0; row < height; row++) {
        double top, bottom, unused, sum[3] = {0.0, 0.0, 0.0};
        nph_sincos2pi(0.5 * row / height, &unused, &top);
        nph_sincos2pi(0.5 * (row + 1.0) / height, &unused, &bottom);
        for (int i = 0; i < ROW_STEPS; i++) {
            double sine = top + (bottom - top) * (i + 0.5) / ROW_STEPS;
            if (hemisphere * sine < 0.0) continue;
            double metres[NPH_SKY_MOST];
            columns(attenuation, sine, metres);
            for (int c = 0; c < 3; c++) sum[c] += transmittance(attenuation, metres, air->extinction_per_m[c], air->aerosol.extinction_per_m[c]);
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
    double metres[NPH_SKY_MOST];
    int count = reader->scene->wavelength_count;
    if (!columns(attenuation, light->direction[2], metres))
        nph_warn(reader->context, "%s: the sun %s is not above the horizon of the air, which lets nothing of it through",
                 reader->name, light->name);
    for (int c = 0; c < 3; c++) light->irradiance[c] *= transmittance(attenuation, metres, air->extinction_per_m[c], air->aerosol.extinction_per_m[c]);
    for (int i = 0; i < count; i++)
        light->spectrum[i] *= transmittance(attenuation, metres, air->extinction_spectrum[i], air->aerosol.extinction_spectrum[i]);
    if (count > 0) nph_spectrum_thirds(light->spectrum, count, light->irradiance);
}

static NphStatus draw_sky(NphSceneReader *reader, const Attenuation *attenuation, int index) {
    NphLight *light = &reader->scene->lights[index];
    NphSky sky = attenuation->sky;
    memcpy(sky.sun, light->direction, sizeof sky.sun);
    memcpy(sky.irradiance, light->irradiance, sizeof sky.irradiance);
    if (!(sky.radius_m > 0.0) && !(sky.sun[2] > 0.0))
        nph_warn(reader->context, "%s: the sun of the sky %s is not above the horizon: flat air is dark then, %s", reader->name,
                 light->name, "type: table has twilight");
    memset(light->direction, 0, sizeof light->direction);
    memset(light->irradiance, 0, sizeof light->irradiance);
    return nph_environment_sky(reader->context, &sky, attenuation->height_m, reader->sky_rows[index], &light->map);
}

static NphStatus attenuate_light(NphSceneReader *reader, const Attenuation *attenuation, int index) {
    NphLight *light = &reader->scene->lights[index];
    if (reader->sky_rows[index]) return draw_sky(reader, attenuation, index);
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

static void constituent(NphSky *sky, const double extinction_per_m[3], const double albedo[3], double scale_height_m, const NphPhase *phase) {
    NphSkyConstituent *of = &sky->of[sky->count++];
    memcpy(of->extinction_per_m, extinction_per_m, sizeof of->extinction_per_m);
    memcpy(of->albedo, albedo, sizeof of->albedo);
    of->scale_height_m = scale_height_m;
    of->phase = phase;
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
    if (status == NPH_OK) status = nph_air_table_build(context, &profile, &attenuation->tables[0]);
    return reader->air_profile.path ? nph_scene_note(reader, &reader->air_profile, "profile of the air", status) : status;
}

/* Of the aerosol; both profiles begin at the same sphere. */
static NphStatus build_haze(NphSceneReader *reader, Attenuation *attenuation) {
    const NphSceneAir *air = attenuation->air;
    NphAirProfile profile = {0};
    NPH_TRY(nph_air_profile_exponential(reader->context, air->aerosol.scale_height_m, air->radius_m, &profile));
    return nph_air_table_build(reader->context, &profile, &attenuation->tables[1]);
}

static NphStatus build(NphSceneReader *reader, Attenuation *attenuation) {
    const NphSceneAir *air = attenuation->air;
    NphSky *sky = &attenuation->sky;
    constituent(sky, air->extinction_per_m, WHITE, reader->air_profile.path ? 0.0 : air->scale_height_m, &RAYLEIGH);
    if (air->aerosol.given)
        constituent(sky, air->aerosol.extinction_per_m, air->aerosol.albedo, air->aerosol.scale_height_m, &air->aerosol.phase);
    if (air->kind != NPH_AIR_TABLE) return NPH_OK;
    sky->radius_m = air->radius_m;
    for (int i = 0; i < sky->count; i++) sky->of[i].table = &attenuation->tables[i];
    NPH_TRY(build_table(reader, attenuation));
    return sky->count > 1 ? build_haze(reader, attenuation) : NPH_OK;
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
    for (int l = 0; l < scene->light_count; l++) {
        air->skies += reader->sky_rows[l] > 0;
        if (reader->sky_rows[l] && air->kind == NPH_AIR_NONE)
            nph_scene_mistake(reader, reader->light_places[l], "a sky is what air scatters, and the scene has no air");
    }
    if (air->kind == NPH_AIR_NONE) return NPH_OK;
    if (air->within) return nph_scene_air_within(reader);
    if (reader->height_place.line == 0) {
        double origin[3];
        nph_scene_origin(scene, origin);
        air->height_m = origin[2];
    }
    attenuation.height_m = air->height_m - air->ground_m;
    status = build(reader, &attenuation);
    int usable = status == NPH_OK && reader->bad_inputs == 0 && check_height(reader, &attenuation);
    for (int l = 0; l < scene->light_count && usable && status == NPH_OK; l++)
        if (scene->lights[l].kind != NPH_LIGHT_POINT && !reader->bare[l]) status = attenuate_light(reader, &attenuation, l);
    for (int i = 0; i < NPH_SKY_MOST; i++) nph_air_table_free(reader->context, &attenuation.tables[i]);
    return status;
}
