/* SPDX-License-Identifier: Apache-2.0
 *
 * Air within the scene: molecules and aerosol as the last media, each of density exp(-h / H) from the ground up to where
 * e^-40 = 4e-18 of it is left. Lights stay as they are outside; the sky is what these media scatter. Around a sphere the ground
 * is a surface too. */
#include <math.h>
#include <string.h>

#include "core/memory.h"
#include "scene/scene_read.h"

static const double TOP_SCALE_HEIGHTS = 40.0;

/* The next medium; NULL after a mistake. */
static NphMedium *new_medium(NphSceneReader *reader, const char *name, NphStatus *status) {
    NphScene *scene = reader->scene;
    if (scene->medium_count == NPH_MAX_MEDIA) {
        nph_scene_mistake(reader, reader->air_place, "there is no room for the air among %d media", (int)NPH_MAX_MEDIA);
        return NULL;
    }
    for (int m = 0; m < scene->medium_count; m++) {
        if (strcmp(scene->media[m].name, name) != 0) continue;
        nph_scene_mistake(reader, reader->air_place, "the name %s is taken by medium number %d; with where: within the air has it", name, m);
        return NULL;
    }
    NphMedium *medium = &scene->media[scene->medium_count];
    *status = nph_strdup(reader->context, name, &medium->name);
    if (*status != NPH_OK) return NULL;
    scene->medium_count++;
    return medium;
}

static void place(const NphSceneAir *air, double scale_height_m, NphMedium *medium) {
    medium->shape = NPH_SHAPE_AIR;
    medium->scale_height_m = scale_height_m;
    medium->radius_m = air->kind == NPH_AIR_TABLE ? air->radius_m : 0.0;
    for (int a = 0; a < 2; a++) {
        medium->lo[a] = -HUGE_VAL;
        medium->hi[a] = HUGE_VAL;
    }
    medium->hi[2] = TOP_SCALE_HEIGHTS * scale_height_m;
    nph_affine_identity(medium->world_from_medium);
    medium->world_from_medium[11] = air->ground_m;
}

static void molecules(const NphSceneAir *air, NphMedium *medium) {
    place(air, air->scale_height_m, medium);
    memcpy(medium->extinction_per_m, air->extinction_per_m, sizeof medium->extinction_per_m);
    memcpy(medium->extinction_spectrum, air->extinction_spectrum, sizeof medium->extinction_spectrum);
    for (int c = 0; c < 3; c++) medium->albedo[c] = 1.0;
    for (int i = 0; i < NPH_MAX_WAVELENGTHS; i++) medium->albedo_spectrum[i] = 1.0;
    medium->phase.kind = NPH_PHASE_RAYLEIGH;
}

static void haze(NphSceneAerosol *aerosol, const NphSceneAir *air, NphMedium *medium) {
    place(air, aerosol->scale_height_m, medium);
    memcpy(medium->extinction_per_m, aerosol->extinction_per_m, sizeof medium->extinction_per_m);
    memcpy(medium->extinction_spectrum, aerosol->extinction_spectrum, sizeof medium->extinction_spectrum);
    memcpy(medium->albedo, aerosol->albedo, sizeof medium->albedo);
    memcpy(medium->albedo_spectrum, aerosol->albedo_spectrum, sizeof medium->albedo_spectrum);
    medium->phase = aerosol->phase;
    aerosol->phase = (NphPhase){0}; /* the medium owns a table now */
}

static void refuse(NphSceneReader *reader) {
    const NphScene *scene = reader->scene;
    if (reader->air_profile.path)
        nph_scene_mistake(reader, reader->air_profile.place, "a profile from a file is not modelled within the scene; scale_height is");
    if (scene->air.kind == NPH_AIR_TABLE && (scene->period.on[0] || scene->period.on[1]))
        nph_scene_mistake(reader, reader->air_place, "air around a sphere is nowhere the same: sides do not repeat in it");
    if (scene->air.kind == NPH_AIR_TABLE && scene->surface_count == NPH_MAX_SURFACES)
        nph_scene_mistake(reader, reader->air_place, "there is no room for the globe among %d surfaces", (int)NPH_MAX_SURFACES);
    if (reader->height_place.line > 0)
        nph_scene_mistake(reader, reader->height_place, "height is that of lights before the scene; with where: within there is none");
    for (int l = 0; l < scene->light_count; l++) {
        if (reader->sky_rows[l])
            nph_scene_mistake(reader, reader->light_places[l], "a sky is what the air scatters, which with where: within the scene does itself");
        if (reader->bare[l])
            nph_scene_mistake(reader, reader->light_places[l], "air: ignored does not go with where: within; all light passes the air there");
    }
}

/* The ground of a sphere is a surface: else one would see through it. */
static NphStatus add_globe(NphSceneReader *reader) {
    NphScene *scene = reader->scene;
    NphSurface *globe = &scene->surfaces[scene->surface_count];
    NPH_TRY(nph_strdup(reader->context, "globe", &globe->name));
    scene->surface_count++;
    globe->is_plane = 1;
    globe->height_m = scene->air.ground_m;
    globe->radius_m = scene->air.radius_m;
    memcpy(globe->albedo, scene->air.ground_albedo, sizeof globe->albedo);
    memcpy(globe->albedo_spectrum, scene->air.ground_albedo_spectrum, sizeof globe->albedo_spectrum);
    return NPH_OK;
}

NphStatus nph_scene_air_within(NphSceneReader *reader) {
    NphSceneAir *air = &reader->scene->air;
    NphStatus status = NPH_OK;
    refuse(reader);
    if (reader->mistakes) return NPH_OK;
    NphMedium *medium = new_medium(reader, "air", &status);
    if (!medium) return status;
    molecules(air, medium);
    if (air->kind == NPH_AIR_TABLE) NPH_TRY(add_globe(reader));
    if (!air->aerosol.given) return NPH_OK;
    medium = new_medium(reader, "aerosol", &status);
    if (medium) haze(&air->aerosol, air, medium);
    return status;
}
