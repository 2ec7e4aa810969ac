/* SPDX-License-Identifier: Apache-2.0
 *
 * See made_scenes.h. Together they run every kernel: boxes, layers and grids, grey and coloured, each phase function, light and
 * emission, surfaces, wavelengths, sides that repeat, sensors. Values are made with + - * / alone. */
#include "made_scenes.h"

#include <math.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"

/* A picture of the unit cube along (2, 2, -1) / 3, 60 degrees wide within a few percent. */
static void look_at_cube(NphScene *scene, int width, int height) {
    static const double forward[3] = {2.0, 2.0, -1.0}, right[3] = {1.0, -2.0, -2.0}, up[3] = {2.0, -1.0, 2.0};
    NphSensor *sensor = &scene->sensor;
    sensor->width = sensor->crop[2] = width;
    sensor->height = sensor->crop[3] = height;
    for (int a = 0; a < 3; a++) {
        sensor->forward[a] = sensor->seen[a] = forward[a] / 3.0;
        sensor->right[a] = right[a] / 3.0;
        sensor->up[a] = up[a] / 3.0;
        sensor->position[a] = 0.5 - 1.75 * sensor->forward[a];
    }
    sensor->half_size[1] = 0.55;
    sensor->half_size[0] = 0.55 * width / height;
}

static void set3(double to[3], double a, double b, double c) {
    to[0] = a;
    to[1] = b;
    to[2] = c;
}

static NphMedium *add_medium(NphScene *scene, NphShape shape, double extinction) {
    NphMedium *medium = &scene->media[scene->medium_count++];
    medium->shape = shape;
    nph_affine_identity(medium->world_from_medium);
    set3(medium->extinction_per_m, extinction, extinction, extinction);
    set3(medium->albedo, 0.9, 0.9, 0.9);
    set3(medium->hi, 1.0, 1.0, 1.0);
    return medium;
}

static NphLight *add_sun(NphScene *scene, double half_angle_rad) {
    NphLight *light = &scene->lights[scene->light_count++];
    light->kind = NPH_LIGHT_SUN;
    set3(light->direction, -2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0);
    set3(light->irradiance, 3.0, 3.0, 3.0);
    light->half_angle_rad = half_angle_rad;
    return light;
}

static NphLight *add_constant(NphScene *scene, double radiance) {
    NphLight *light = &scene->lights[scene->light_count++];
    light->kind = NPH_LIGHT_CONSTANT;
    set3(light->radiance, radiance, radiance, radiance);
    return light;
}

static void add_plane(NphScene *scene, double height_m) {
    NphSurface *surface = &scene->surfaces[scene->surface_count++];
    surface->is_plane = 1;
    surface->height_m = height_m;
    set3(surface->albedo, 0.75, 0.5, 0.25);
}

enum { EDGE = 20 };

/* A ball in the unit cube that thins outwards, with a dent; peak: of its density. */
static NphStatus make_ball(NphContext *context, double peak, NphGrid *grid) {
    static const double lo[3] = {0.0, 0.0, 0.0}, hi[3] = {1.0, 1.0, 1.0};
    NphArray values = {0};
    NPH_TRY(nph_array_new(context, NPH_F32, 3, (int64_t[3]){EDGE, EDGE, EDGE}, "ball", &values));
    for (int i = 0; i < EDGE * EDGE * EDGE; i++) {
        double x = (i % EDGE + 0.5) / EDGE, y = (i / EDGE % EDGE + 0.5) / EDGE, z = (i / (EDGE * EDGE) + 0.5) / EDGE;
        double far = 4.0 * ((x - 0.5) * (x - 0.5) + (y - 0.5) * (y - 0.5) + (z - 0.5) * (z - 0.5));
        double dent = (x - 0.75) * (x - 0.75) + (z - 0.75) * (z - 0.75);
        ((float *)values.data)[i] = (float)(far < 1.0 ? peak * (1.0 - far) * (dent < 0.03 ? 0.0 : 1.0 + x * y) : 0.0);
    }
    NphStatus status = nph_grid_from_array(context, &values, lo, hi, NPH_CENTRING_CELL, NPH_OUTSIDE_ZERO, NPH_LOOKUP_TRILINEAR,
                                           "ball", grid);
    nph_array_free(context, &values);
    return status;
}

/* A medium of such a ball. */
static NphStatus add_ball(NphContext *context, NphScene *scene, double extinction, NphMedium **out) {
    NphMedium *medium = add_medium(scene, NPH_SHAPE_GRID, extinction);
    NPH_TRY(make_ball(context, 1.0, &medium->grid));
    memcpy(medium->world_from_medium, medium->grid.world_from_lattice, sizeof medium->world_from_medium);
    *out = medium;
    return NPH_OK;
}

static NphStatus box(NphContext *context, NphScene *scene) {
    (void)context;
    add_medium(scene, NPH_SHAPE_BOX, 4.0)->phase = (NphPhase){NPH_PHASE_HG, {0.7, 0.0}, 0.0, 0.0, NULL};
    add_sun(scene, 0.0);
    add_constant(scene, 0.25);
    return NPH_OK;
}

/* Channels that differ, a sun with a disc, a layer beneath the box, and a plane. */
static NphStatus coloured(NphContext *context, NphScene *scene) {
    (void)context;
    NphMedium *medium = add_medium(scene, NPH_SHAPE_BOX, 4.0), *layer = add_medium(scene, NPH_SHAPE_LAYER, 0.5);
    set3(medium->extinction_per_m, 2.0, 5.0, 0.0);
    set3(medium->albedo, 0.9, 1.0, 0.5);
    medium->phase.kind = NPH_PHASE_RAYLEIGH;
    for (int a = 0; a < 2; a++) {
        layer->lo[a] = -HUGE_VAL;
        layer->hi[a] = HUGE_VAL;
    }
    layer->lo[2] = -0.5;
    layer->hi[2] = 0.25;
    layer->phase = (NphPhase){NPH_PHASE_TWO_LOBE, {0.8, -0.3}, 0.7, 0.0, NULL};
    add_sun(scene, 0.04);
    add_plane(scene, -1.0);
    return NPH_OK;
}

static NphStatus ball(NphContext *context, NphScene *scene) {
    NphMedium *medium;
    NPH_TRY(add_ball(context, scene, 12.0, &medium));
    medium->phase = (NphPhase){NPH_PHASE_DRAINE, {0.6, 0.0}, 0.0, 2.0, NULL};
    add_sun(scene, 0.0);
    add_constant(scene, 0.5)->hemisphere = 1;
    return NPH_OK;
}

/* Weighed flights: much is absorbed. A point light inside. */
static NphStatus dark(NphContext *context, NphScene *scene) {
    NphMedium *medium;
    NPH_TRY(add_ball(context, scene, 9.0, &medium));
    set3(medium->albedo, 0.5, 0.5, 0.5);
    NphLight *light = &scene->lights[scene->light_count++];
    light->kind = NPH_LIGHT_POINT;
    set3(light->position, 0.5, 0.375, 0.5);
    set3(light->intensity, 1.0, 1.0, 1.0);
    return NPH_OK;
}

/* Density and a grid that emits, channels that differ, in the light of a map. */
static NphStatus fire(NphContext *context, NphScene *scene) {
    static const double scale[3] = {1.0, 0.5, 2.0};
    NphMedium *medium;
    NphImage image;
    float *pixels = NULL;
    NPH_TRY(add_ball(context, scene, 6.0, &medium));
    set3(medium->extinction_per_m, 4.0, 6.0, 9.0);
    NphEmission *emission = &medium->emission;
    NPH_TRY(NPH_NEW(context, 1, "emission", &emission->grids));
    NPH_TRY(make_ball(context, 3.0, &emission->grids[0]));
    emission->kind = NPH_EMISSION_GRID;
    emission->grid_count = 1;
    set3(emission->value, 3.0, 2.0, 1.0);
    memcpy(emission->world_from_grid, medium->world_from_medium, sizeof emission->world_from_grid);
    NPH_TRY(nph_emission_finish(context, &medium->grid, "fire", emission));
    NphLight *light = &scene->lights[scene->light_count++];
    light->kind = NPH_LIGHT_ENVIRONMENT;
    light->rotation_rad = 0.75;
    NPH_TRY(nph_image_new(context, 16, 8, &image));
    NphStatus status = nph_image_add_channel(context, &image, "Y", &pixels);
    for (int i = 0; i < 16 * 8 && status == NPH_OK; i++) pixels[i] = (float)(i * 7 % 31) / 31.0f;
    if (status == NPH_OK) status = nph_environment_build(context, &image, scale, "map", &light->map);
    nph_image_free(context, &image);
    return status;
}

/* A pyramid of triangles within a layer. */
static NphStatus solid(NphContext *context, NphScene *scene) {
    static const double corners[5][3] = {{0.1, 0.2, 0.1}, {0.9, 0.1, 0.2}, {0.8, 0.9, 0.1}, {0.2, 0.7, 0.2}, {0.5, 0.4, 0.9}};
    static const int32_t faces[6][3] = {{0, 2, 1}, {0, 3, 2}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
    NphArray vertices = {NPH_F64, 2, {5, 3, 1, 1, 1, 1}, NULL}, triangles = {NPH_I32, 2, {6, 3, 1, 1, 1, 1}, NULL};
    double copy[5][3], origin[3];
    int32_t rows[6][3];
    memcpy(copy, corners, sizeof copy);
    memcpy(rows, faces, sizeof rows);
    vertices.data = copy;
    triangles.data = rows;
    NphSurface *surface = &scene->surfaces[scene->surface_count++];
    set3(surface->albedo, 0.5, 0.6, 0.7);
    NPH_TRY(nph_mesh_make(context, "pyramid", &vertices, &triangles, &surface->mesh));
    add_medium(scene, NPH_SHAPE_BOX, 1.0);
    add_plane(scene, 0.0);
    add_sun(scene, 0.0);
    add_constant(scene, 0.25);
    nph_scene_origin(scene, origin);
    return nph_bvh_build(context, &surface->mesh, 1, origin, &scene->bvh);
}

/* Four wavelengths, a table for phase function, sides that repeat, fluence instead of a camera. */
static NphStatus spectral(NphContext *context, NphScene *scene) {
    double degrees[5][2] = {{0.0, 9.0}, {10.0, 2.0}, {60.0, 0.5}, {120.0, 0.25}, {180.0, 0.5}};
    NphArray rows = {NPH_F64, 2, {5, 2, 1, 1, 1, 1}, NULL};
    NphMedium *medium;
    rows.data = degrees;
    scene->sensor.kind = NPH_SENSOR_FLUENCE;
    scene->period = (NphPeriod){{1, 1}, {0.125, 0.0}, {1.0, 0.875}};
    scene->wavelength_count = 4;
    NPH_TRY(add_ball(context, scene, 4.0, &medium));
    NphLight *light = add_sun(scene, 0.0);
    for (int i = 0; i < 4; i++) {
        scene->wavelengths_nm[i] = 450.0 + 60.0 * i;
        medium->extinction_spectrum[i] = 6.0 - i;
        medium->albedo_spectrum[i] = 0.8 + 0.05 * i;
        light->spectrum[i] = 1.0 + i;
    }
    nph_spectrum_thirds(medium->extinction_spectrum, 4, medium->extinction_per_m);
    nph_spectrum_thirds(medium->albedo_spectrum, 4, medium->albedo);
    nph_spectrum_thirds(light->spectrum, 4, light->irradiance);
    return nph_phase_tabulate(context, &rows, "table", &medium->phase);
}

const MadeScene made_scenes[] = {
    {"box", box, "path light single photonmap temporal_photons principal_ordinates shdom"},
    {"coloured", coloured, "path light single"},
    {"ball", ball, "path light single photonmap shdom"},
    {"dark", dark, "path light single photonmap temporal_photons principal_ordinates shdom"},
    {"fire", fire, "path light single"},
    {"solid", solid, "path light single"},
    {"spectral", spectral, "path"},
};
const int made_scene_count = (int)(sizeof made_scenes / sizeof *made_scenes);

NphStatus made_scene(NphContext *context, const MadeScene *what, int width, int height, NphScene **scene) {
    NphScene *made = NULL;
    NPH_TRY(NPH_NEW(context, 1, "scene", &made));
    NphStatus status = nph_strdup(context, what->name, &made->name);
    look_at_cube(made, width, height);
    made->default_spp = 16;
    made->default_seed = 1;
    if (status == NPH_OK) status = what->fill(context, made);
    if (status != NPH_OK) nph_scene_free(context, made);
    else *scene = made;
    return status;
}
