/* SPDX-License-Identifier: Apache-2.0
 *
 * What a scene holds once it is read and checked. */
#include <stdio.h>

#include "cli/info.h"
#include "core/message.h"
#include "scene/model.h"

static void tell_sensor(Facts *facts, const NphSensor *sensor) {
    static const char *const kinds[] = {"perspective", "orthographic", "flux", "fisheye", "fluence", "radiance"};
    facts_group(facts, "sensor");
    facts_text(facts, "kind", kinds[sensor->kind]);
    facts_integers(facts, "size", 2, (int32_t[]){sensor->width, sensor->height});
    facts_integers(facts, "crop", 4, (int32_t[]){sensor->crop[0], sensor->crop[1], sensor->crop[2], sensor->crop[3]});
    facts_numbers(facts, "position_m", 3, sensor->position);
    facts_numbers(facts, "forward", 3, sensor->forward);
    facts_numbers(facts, "half_size", 2, sensor->half_size);
    if (sensor->kind == NPH_SENSOR_RADIANCE) facts_numbers(facts, "seen", 3, sensor->seen);
    facts_end(facts);
}

/* Lights are told as they are behind it. */
static void tell_air(Facts *facts, const NphSceneAir *air) {
    if (air->kind == NPH_AIR_NONE) return;
    facts_group(facts, "air");
    facts_text(facts, "type", air->kind == NPH_AIR_TABLE ? "table" : "exponential");
    facts_numbers(facts, "extinction_per_m", 3, air->extinction_per_m);
    facts_number(facts, "height_m", air->height_m);
    if (air->aerosol.given) {
        facts_numbers(facts, "aerosol_extinction_per_m", 3, air->aerosol.extinction_per_m);
        facts_number(facts, "aerosol_scale_height_m", air->aerosol.scale_height_m);
    }
    facts_end(facts);
}

static void tell_medium(Facts *facts, const NphMedium *medium) {
    static const char *const shapes[] = {"grid", "box", "layer", "air"};
    static const char *const phases[] = {"isotropic", "Henyey-Greenstein", "two-lobe Henyey-Greenstein", "Rayleigh",
                                         "Draine", "tabulated"};
    facts_item(facts, medium->name ? medium->name : "medium");
    facts_text(facts, "shape", shapes[medium->shape]);
    facts_numbers(facts, "extinction_per_m", 3, medium->extinction_per_m);
    facts_numbers(facts, "albedo", 3, medium->albedo);
    facts_text(facts, "phase", phases[medium->phase.kind]);
    if (medium->phase.kind == NPH_PHASE_HG) facts_number(facts, "g", medium->phase.g[0]);
    if (medium->phase.kind == NPH_PHASE_TWO_LOBE)
        facts_numbers(facts, "g1_g2_weight", 3, (double[]){medium->phase.g[0], medium->phase.g[1], medium->phase.weight});
    if (medium->phase.kind == NPH_PHASE_DRAINE)
        facts_numbers(facts, "g_alpha", 2, (double[]){medium->phase.g[0], medium->phase.alpha});
    if (medium->phase.kind >= NPH_PHASE_DRAINE) facts_number(facts, "mean_cosine", nph_phase_mean_cosine(&medium->phase));
    if (medium->phase.kind == NPH_PHASE_TABULATED) facts_number(facts, "peak_per_sr", nph_phase_peak(&medium->phase));
    if (medium->shape == NPH_SHAPE_GRID) {
        facts_integers(facts, "samples_xyz", 3, medium->grid.n);
        facts_number(facts, "density_min", medium->grid.min);
        facts_number(facts, "density_max", medium->grid.max);
        facts_integer(facts, "nonzero", medium->grid.active);
    }
    facts_end(facts);
}

static void tell_light(Facts *facts, const NphLight *light) {
    static const char *const kinds[] = {"sun", "constant", "environment", "point"};
    facts_item(facts, light->name ? light->name : "light");
    facts_text(facts, "kind", kinds[light->kind]);
    if (light->kind == NPH_LIGHT_SUN) {
        facts_numbers(facts, "direction", 3, light->direction);
        facts_numbers(facts, "irradiance", 3, light->irradiance);
    }
    if (light->kind == NPH_LIGHT_CONSTANT) facts_numbers(facts, "radiance", 3, light->radiance);
    if (light->kind == NPH_LIGHT_POINT) facts_numbers(facts, "intensity", 3, light->intensity);
    if (light->kind == NPH_LIGHT_ENVIRONMENT) facts_integers(facts, "map", 2, (int32_t[]){light->map.width, light->map.height});
    facts_end(facts);
}

static void tell_surface(Facts *facts, const NphSurface *surface) {
    facts_item(facts, surface->name ? surface->name : "surface");
    facts_text(facts, "shape", surface->is_plane ? "plane" : "mesh");
    facts_numbers(facts, "albedo", 3, surface->albedo);
    if (surface->is_plane) facts_number(facts, "height_m", surface->height_m);
    else {
        facts_integer(facts, "triangles", surface->mesh.triangle_count);
        facts_integer(facts, "dropped", surface->mesh.dropped);
        facts_number(facts, "area_m2", surface->mesh.area_m2);
    }
    facts_end(facts);
}

NphStatus info_scene(Info *info) {
    Facts *facts = &info->facts;
    NphScene *scene = NULL;
    double lo[3], hi[3];
    char digest[33];
    NPH_TRY(nph_scene_load_frame(info->context, info->path, info->frame, &scene));
    nph_scene_bounds(scene, lo, hi);
    for (int i = 0; i < 16; i++) snprintf(digest + 2 * i, 3, "%02x", scene->digest[i]);
    if (nph_scene_is_animated(scene)) facts_integer(facts, "animated_at_frame", scene->frame);
    facts_text(facts, "digest", digest);
    facts_numbers(facts, "bounds_min_m", 3, lo);
    facts_numbers(facts, "bounds_max_m", 3, hi);
    facts_integer(facts, "samples_per_pixel", scene->default_spp);
    facts_integer(facts, "seed", scene->default_seed);
    const NphPeriod *period = &scene->period;
    if (period->on[0]) facts_numbers(facts, "periodic_x_m", 2, (double[]){period->lo[0], period->hi[0]});
    if (period->on[1]) facts_numbers(facts, "periodic_y_m", 2, (double[]){period->lo[1], period->hi[1]});
    if (scene->wavelength_count > 0) facts_numbers(facts, "wavelengths_nm", scene->wavelength_count, scene->wavelengths_nm);
    tell_sensor(facts, &scene->sensor);
    tell_air(facts, &scene->air);
    facts_list(facts, "media");
    for (int i = 0; i < scene->medium_count; i++) tell_medium(facts, &scene->media[i]);
    facts_end(facts);
    facts_list(facts, "lights");
    for (int i = 0; i < scene->light_count; i++) tell_light(facts, &scene->lights[i]);
    facts_end(facts);
    facts_list(facts, "surfaces");
    for (int i = 0; i < scene->surface_count; i++) tell_surface(facts, &scene->surfaces[i]);
    facts_end(facts);
    nph_scene_free(info->context, scene);
    return NPH_OK;
}
