/* SPDX-License-Identifier: Apache-2.0
 *
 * Only what the scene requires: one channel when everything is grey, no sample of a black light, no medium without
 * extinction, no scattering where every albedo is 0. --plan full leaves nothing out. */
#include "transport/choice.h"

#include "core/message.h"
#include "pipeline/plan.h"

static int is_grey(const double value[3]) { return value[0] == value[1] && value[0] == value[2]; }

static int is_black(const double value[3]) { return value[0] == 0.0 && value[1] == 0.0 && value[2] == 0.0; }

static int light_is_grey(const NphLight *light) {
    switch (light->kind) {
    case NPH_LIGHT_SUN: return is_grey(light->irradiance);
    case NPH_LIGHT_CONSTANT: return is_grey(light->radiance);
    case NPH_LIGHT_POINT: return is_grey(light->intensity);
    case NPH_LIGHT_ENVIRONMENT: break;
    }
    const NphEnvironment *map = &light->map;
    int64_t texels = (int64_t)map->width * map->height;
    for (int64_t i = 0; i < texels; i++) {
        const float *t = map->radiance + 3 * i;
        if (t[0] != t[1] || t[0] != t[2]) return 0;
    }
    return 1;
}

static int light_is_black(const NphLight *light) {
    switch (light->kind) {
    case NPH_LIGHT_SUN: return is_black(light->irradiance);
    case NPH_LIGHT_CONSTANT: return is_black(light->radiance);
    case NPH_LIGHT_POINT: return is_black(light->intensity);
    case NPH_LIGHT_ENVIRONMENT: break;
    }
    return !(light->map.total > 0.0);
}

static int medium_is_empty(const NphMedium *medium) {
    return is_black(medium->extinction_per_m) || (medium->shape == NPH_SHAPE_GRID && !(medium->grid.max > 0.0f));
}

static int emission_is_black(const NphEmission *emission) {
    int grid = emission->kind == NPH_EMISSION_GRID || emission->kind == NPH_EMISSION_DENSITY;
    return emission->kind == NPH_EMISSION_NONE || is_black(emission->value) || (grid && !(emission->depth > 0.0));
}

static int emission_is_grey(const NphEmission *emission) { return is_grey(emission->value) && emission->grid_count <= 1; }

static void choose_emission(const NphScene *scene, int plan_full, NphTransportChoice *choice) {
    for (int m = 0; m < scene->medium_count; m++) {
        const NphEmission *emission = &scene->media[m].emission;
        choice->emits[m] = emission->kind != NPH_EMISSION_NONE && (plan_full || !emission_is_black(emission));
        if (!choice->emits[m]) continue;
        choice->emission = 1;
        if (!emission_is_grey(emission)) choice->film_channels = 3;
    }
}

void nph_transport_choose(const NphScene *scene, int plan_full, NphTransportChoice *choice) {
    *choice = (NphTransportChoice){.channels = 1, .film_channels = 1, .groups = 1};
    for (int m = 0; m < scene->medium_count; m++) {
        const NphMedium *medium = &scene->media[m];
        choice->used[m] = plan_full || !medium_is_empty(medium);
        if (!choice->used[m]) continue;
        if (!is_grey(medium->extinction_per_m) || !is_grey(medium->albedo)) choice->channels = 3;
        if (medium->shape == NPH_SHAPE_AIR) choice->channels = 3; /* kernels for grey light know no air */
        if (!is_black(medium->albedo)) choice->scatters = 1;
    }
    for (int s = 0; s < scene->surface_count; s++) {
        if (!is_grey(scene->surfaces[s].albedo)) choice->channels = 3;
        if (plan_full || !is_black(scene->surfaces[s].albedo)) choice->reflects = 1;
    }
    if (plan_full) {
        choice->channels = 3;
        choice->scatters = 1;
    }
    if (nph_scene_is_spectral(scene)) {
        choice->channels = 3;
        choice->groups = nph_wavelength_groups(scene->wavelength_count);
    }
    choice->film_channels = choice->channels;
    choose_emission(scene, plan_full, choice);
    for (int l = 0; l < scene->light_count; l++) {
        const NphLight *light = &scene->lights[l];
        if (!light_is_grey(light)) choice->film_channels = 3;
        choice->sampled[l] = light->kind != NPH_LIGHT_CONSTANT && (plan_full || !light_is_black(light));
    }
}

static NphStatus plan_omissions(NphContext *context, const NphScene *scene, const NphTransportChoice *choice, NphPlan *plan) {
    if (choice->film_channels == 1)
        NPH_TRY(nph_plan_add(context, plan, "left out", "channels", 0, "2 of 3: media, surfaces and lights are grey"));
    else if (choice->channels == 1)
        NPH_TRY(nph_plan_add(context, plan, "left out", "transport channels", 0,
                             "2 of 3: media and surfaces are grey, only the lights have a colour"));
    for (int m = 0; m < scene->medium_count; m++)
        if (!choice->used[m])
            NPH_TRY(nph_plan_add(context, plan, "left out", scene->media[m].name, 0, "medium: it has no extinction"));
    for (int m = 0; m < scene->medium_count; m++)
        if (choice->used[m] && scene->media[m].shape == NPH_SHAPE_AIR)
            NPH_TRY(nph_plan_add(context, plan, "left out", "tracking", 0,
                                 "in %s: its density is exponential, flights and transmittances are closed forms",
                                 scene->media[m].name));
        else if (choice->used[m] && scene->media[m].shape != NPH_SHAPE_GRID)
            NPH_TRY(nph_plan_add(context, plan, "left out", "tracking", 0,
                                 "in %s: it is homogeneous, flights and transmittances are closed forms",
                                 scene->media[m].name));
    for (int l = 0; l < scene->light_count; l++)
        if (!choice->sampled[l] && scene->lights[l].kind != NPH_LIGHT_CONSTANT)
            NPH_TRY(nph_plan_add(context, plan, "left out", "light sample", 0, "of %s: it is black", scene->lights[l].name));
    if (scene->surface_count == 0)
        NPH_TRY(nph_plan_add(context, plan, "left out", "surfaces", 0, "there are none: no ray is tested against them"));
    for (int m = 0; m < scene->medium_count; m++)
        if (scene->media[m].emission.kind != NPH_EMISSION_NONE && !choice->emits[m])
            NPH_TRY(nph_plan_add(context, plan, "left out", "emission", 0, "of %s: it is black", scene->media[m].name));
    if (scene->light_count == 0 && !choice->emission)
        NPH_TRY(nph_plan_add(context, plan, "warning", "lights", 0, "there are none: the picture will be black"));
    for (int m = 0; m < scene->medium_count; m++)
        if (scene->media[m].unmodelled)
            NPH_TRY(nph_plan_add(context, plan, "warning", scene->media[m].name, 0,
                                 "its file holds a grid '%s', which is not modelled; emission: would make it glow",
                                 scene->media[m].unmodelled));
    return NPH_OK;
}

/* What of the air is in the picture. */
static NphStatus plan_air(NphContext *context, const NphScene *scene, NphPlan *plan) {
    const NphSceneAir *air = &scene->air;
    const char *haze = air->aerosol.given ? " and aerosol" : "", *form = air->kind == NPH_AIR_TABLE ? "around a sphere" : "flat";
    if (air->kind == NPH_AIR_NONE) return NPH_OK;
    if (air->within)
        return nph_plan_add(context, plan, "modelled", "air", 0, "molecules%s, %s, among the media: light is scattered by them as often as by "
                            "others", haze, form);
    NPH_TRY(nph_plan_add(context, plan, "modelled", "air", 0, "molecules%s, %s: lights as at %g m, behind it; none within the scene", haze,
                         form, air->height_m));
    for (int l = 0; l < air->skies; l++)
        NPH_TRY(nph_plan_add(context, plan, "modelled", "sky", 0, "a map of what the air scatters once towards %g m; no light from the ground",
                             air->height_m));
    return NPH_OK;
}

NphStatus nph_transport_refuse_air(NphContext *context, const NphScene *scene, const char *method) {
    for (int m = 0; m < scene->medium_count; m++)
        if (scene->media[m].shape == NPH_SHAPE_AIR)
            return nph_error(context, NPH_BAD_SCENE, "%s: air within the scene is not part of this method; path and single have it", method);
    return NPH_OK;
}

NphStatus nph_transport_plan(NphContext *context, const NphScene *scene, const NphTransportChoice *choice, NphPlan *plan) {
    NPH_TRY(plan_omissions(context, scene, choice, plan));
    NPH_TRY(plan_air(context, scene, plan));
    for (int m = 0; m < scene->medium_count; m++)
        if (scene->media[m].shape == NPH_SHAPE_GRID)
            NPH_TRY(nph_plan_add(context, plan, "memory", scene->media[m].name, nph_grid_bytes(&scene->media[m].grid),
                                 "bricks and majorants of the density"));
    for (int m = 0; m < scene->medium_count; m++)
        if (scene->media[m].emission.kind == NPH_EMISSION_GRID || scene->media[m].emission.kind == NPH_EMISSION_DENSITY)
            NPH_TRY(nph_plan_add(context, plan, "memory", scene->media[m].name, nph_emission_bytes(&scene->media[m].emission),
                                 "bricks and bounds of the emission"));
    for (int l = 0; l < scene->light_count; l++)
        if (scene->lights[l].kind == NPH_LIGHT_ENVIRONMENT) {
            uint64_t texels = (uint64_t)scene->lights[l].map.width * (uint64_t)scene->lights[l].map.height;
            NPH_TRY(nph_plan_add(context, plan, "memory", scene->lights[l].name, texels * 20, "environment and its tables"));
        }
    const NphBvh *bvh = &scene->bvh;
    uint64_t vertices = (uint64_t)bvh->vertex_count, triangles = (uint64_t)bvh->triangle_count;
    uint64_t nodes = (uint64_t)bvh->node_count * sizeof *bvh->nodes;
    if (triangles > 0) /* the meshes themselves and the hierarchy's copies of them */
        NPH_TRY(nph_plan_add(context, plan, "memory", "surfaces", vertices * 60 + triangles * 36 + nodes,
                             "%llu triangles and the hierarchy over them", (unsigned long long)triangles));
    return NPH_OK;
}

void nph_tally_add(const NphTally *tally, NphRenderStatistics *out) {
    out->collisions += tally->collisions;
    out->tentative += tally->tentative;
    out->majorant_violations += tally->violations;
    out->exhausted += tally->exhausted;
}
