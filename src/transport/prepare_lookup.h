/* SPDX-License-Identifier: Apache-2.0
 *
 * From the scene (world space, f64) to what kernels see: scene-local space, the number type of the build, and only the
 * media that the choice says are used. */
#ifndef NPH_TRANSPORT_PREPARE_LOOKUP_H
#define NPH_TRANSPORT_PREPARE_LOOKUP_H

#include <string.h>

#include "field/sample.h"
#include "transport/choice.h"
#include "transport/flight_lookup.h"

#define R_NO_END 1e300

/* The box [lo, hi] of a space and where it lies; out->shape is set. */
static inline void r_prepare_place(const double world_from[12], const double lo[3], const double hi[3],
                                   const double origin[3], RMedium *out) {
    double from_world[12];
    nph_affine_invert(world_from, from_world);
    for (int a = 0; a < 3; a++) {
        const double *row = from_world + 4 * a;
        for (int b = 0; b < 3; b++) out->from_local[4 * a + b] = (Real)row[b];
        /* the space of a box or layer is counted from its middle: its edges may be large numbers */
        int counted = out->shape != NPH_SHAPE_GRID && out->shape != NPH_SHAPE_AIR && lo[a] > -R_NO_END && hi[a] < R_NO_END;
        double middle = counted ? 0.5 * lo[a] + 0.5 * hi[a] : 0.0;
        out->from_local[4 * a + 3] =
            (Real)(row[3] + row[0] * origin[0] + row[1] * origin[1] + row[2] * origin[2] - middle);
        out->lo[a] = lo[a] > -R_NO_END ? (Real)(lo[a] - middle) : -R_FAR;
        out->hi[a] = hi[a] < R_NO_END ? (Real)(hi[a] - middle) : R_FAR;
    }
}

static inline void r_medium_values(const double extinction[3], const double albedo[3], RMedium *out) {
    double largest = 0.0;
    for (int c = 0; c < 3; c++) largest = extinction[c] > largest ? extinction[c] : largest;
    out->sigma_max = (Real)largest;
    if (NPH_BUG(10)) out->sigma_max *= (Real)albedo[0];
    for (int c = 0; c < 3; c++) {
        out->sigma[c] = (Real)extinction[c];
        if (NPH_BUG(10)) out->sigma[c] *= (Real)albedo[c];
        out->ratio[c] = largest > 0.0 ? (Real)(extinction[c] / largest) : R(0.0);
    }
    out->collide = R(1.0);
    for (int c = 0; c < 3; c++) out->albedo[c] = (Real)albedo[c];
}

static inline void r_prepare_medium(const NphMedium *medium, const double origin[3], uint32_t number, RMedium *out) {
    int grid = medium->shape == NPH_SHAPE_GRID;
    out->shape = medium->shape;
    out->number = number;
    r_prepare_place(medium->world_from_medium, grid ? medium->grid.lo : medium->lo, grid ? medium->grid.hi : medium->hi,
                    origin, out);
    r_medium_values(medium->extinction_per_m, medium->albedo, out);
    out->phase = r_phase(&medium->phase);
    out->scale_height = (Real)medium->scale_height_m;
    out->radius = (Real)medium->radius_m;
    if (medium->shape != NPH_SHAPE_GRID) return;
    nph_grid_view(&medium->grid, &out->grid);
    out->majorant = medium->grid.majorant.cells;
    out->empty = !(medium->grid.sum > 0.0);
    for (int a = 0; a < 3; a++) out->majorant_n[a] = medium->grid.majorant.n[a];
}

/* A disc sun of half angle h has the radiance E / (pi sin^2 h); its cap's solid angle is 2 pi (1 - cos h). */
static inline void r_light_values(const NphLight *light, const double value[3], RLight *out) {
    double scale = 1.0;
    if (light->kind == NPH_LIGHT_SUN && light->half_angle_rad > 0.0) {
        double sine = nph_sin(light->half_angle_rad);
        scale = NPH_BUG(17) ? 1.0 : 1.0 / (3.14159265358979323846 * sine * sine);
    }
    for (int c = 0; c < 3; c++) out->value[c] = (Real)(value[c] * scale);
}

static inline void r_prepare_light(const NphLight *light, const double origin[3], int sampled, RLight *out) {
    out->kind = (int)light->kind;
    out->hemisphere = light->hemisphere;
    out->sampled = sampled;
    if (light->kind == NPH_LIGHT_SUN && light->half_angle_rad > 0.0)
        out->disc = r_disc(light->direction, light->half_angle_rad);
    const double *value = light->kind == NPH_LIGHT_SUN     ? light->irradiance
                          : light->kind == NPH_LIGHT_POINT ? light->intensity
                                                           : light->radiance;
    r_light_values(light, value, out);
    for (int c = 0; c < 3; c++) {
        out->direction[c] = (Real)light->direction[c];
        out->position[c] = (Real)(light->position[c] - origin[c]);
    }
    if (light->kind == NPH_LIGHT_ENVIRONMENT) out->map = r_environment(&light->map, light->rotation_rad);
}

/* weighed: what part of the absorption weighs flights; at least a quarter of the extinction makes collisions, which tell
 * the distance of the first one. */
static inline void r_weigh_flights(const NphMedium *medium, double weighed, RMedium *out) {
    double least = medium->albedo[0] > 0.25 ? medium->albedo[0] : 0.25, collide = 1.0 - weighed * (1.0 - least);
    out->collide = (Real)collide;
    for (int c = 0; c < 3; c++) out->albedo[c] = NPH_BUG(6) ? R(1.0) : (Real)(medium->albedo[c] / collide);
}

static inline void r_prepare_surfaces(const NphScene *scene, const double origin[3], RSurfaces *out) {
    int meshes = 0;
    out->count = scene->surface_count;
    out->bvh = r_bvh(&scene->bvh);
    out->mesh_first = scene->bvh.mesh_first;
    for (int s = 0; s < scene->surface_count; s++) {
        const NphSurface *surface = &scene->surfaces[s];
        for (int c = 0; c < 3; c++) out->albedo[s][c] = (Real)surface->albedo[c];
        if (surface->radius_m > 0.0) {
            out->globe_surface = s;
            out->globe_radius = (Real)surface->radius_m;
            for (int a = 0; a < 3; a++) out->globe_top[a] = (Real)((a == 2 ? surface->height_m : 0.0) - origin[a]);
        } else if (surface->is_plane) {
            double point[3] = {origin[0], origin[1], surface->height_m}, up[3] = {0.0, 0.0, 1.0};
            out->height[out->plane_count] = surface->height_m - origin[2];
            out->planes[out->plane_count] = r_plane_through(point, up, origin);
            out->plane_surface[out->plane_count++] = s;
        } else {
            out->mesh_surface[meshes++] = s;
        }
    }
}

static inline void r_prepare_period(const NphPeriod *period, RScene *out) {
    for (int a = 0; a < 2; a++) {
        if (!period->on[a]) continue;
        out->period.on = 1;
        out->period_lo[a] = period->lo[a] - out->origin[a];
        out->period_size[a] = period->hi[a] - period->lo[a];
        out->period_inverse[a] = 1.0 / out->period_size[a];
        out->period.lo[a] = (Real)out->period_lo[a];
        out->period.size[a] = (Real)out->period_size[a];
        out->period.inverse[a] = (Real)out->period_inverse[a];
    }
}

/* The part of a grid that holds cells with something in them, in lattice space; a cell bounds lookups within itself. */
static inline void r_occupied(const NphGrid *grid, double lo[3], double hi[3]) {
    const int32_t *n = grid->majorant.n;
    int32_t first[3] = {n[0], n[1], n[2]}, last[3] = {-1, -1, -1};
    for (int64_t i = 0; i < (int64_t)n[0] * n[1] * n[2]; i++) {
        int32_t at[3] = {(int32_t)(i % n[0]), (int32_t)(i / n[0] % n[1]), (int32_t)(i / n[0] / n[1])};
        for (int a = 0; a < 3 && grid->majorant.cells[i] > 0.0f; a++) {
            first[a] = at[a] < first[a] ? at[a] : first[a];
            last[a] = at[a] > last[a] ? at[a] : last[a];
        }
    }
    for (int a = 0; a < 3; a++) {
        double from = (double)(first[a] * NPH_MAJORANT_CELL), to = (double)((last[a] + 1) * NPH_MAJORANT_CELL);
        lo[a] = from > grid->lo[a] ? from : grid->lo[a];
        hi[a] = to < grid->hi[a] ? to : grid->hi[a];
    }
}

/* Where flights have to look for a medium that repeats: the corners of its box (of a grid: of its occupied cells) in
 * scene-local space, a millionth wider, so that rounding does not cut into it. */
static inline void r_prepare_reach(const NphMedium *medium, const RScene *scene, RMedium *out) {
    if (!scene->period.on || medium->shape == NPH_SHAPE_LAYER || medium->shape == NPH_SHAPE_AIR) return;
    double lo[3] = {medium->lo[0], medium->lo[1], medium->lo[2]}, hi[3] = {medium->hi[0], medium->hi[1], medium->hi[2]};
    if (medium->shape == NPH_SHAPE_GRID) r_occupied(&medium->grid, lo, hi);
    out->period = scene->period;
    for (int a = 0; a < 3; a++) {
        const double *row = medium->world_from_medium + 4 * a;
        double low = row[3] - scene->origin[a], high = low;
        for (int b = 0; b < 3; b++) {
            double u = row[b] * lo[b], v = row[b] * hi[b];
            low += u < v ? u : v;
            high += u < v ? v : u;
        }
        double margin = 1e-6 * (high - low + nph_abs(low) + nph_abs(high));
        int repeats = a < 2 && scene->period.inverse[a] > R(0.0);
        out->reach_lo[a] = repeats ? -R_FAR : (Real)(low - margin);
        out->reach_hi[a] = repeats ? R_FAR : (Real)(high + margin);
    }
}

/* What a medium emits, one event per crossing in the mean (over what lines bring); the integrator may want more. */
static inline void r_prepare_emitter(const NphMedium *medium, const RScene *scene, uint32_t number, REmitter *out) {
    const NphEmission *emission = &medium->emission;
    int others = scene->surfaces.count;
    for (int m = 0; m < scene->medium_count; m++) {
        const RMedium *other = &scene->media[m];
        int empty = !(other->sigma_max > R(0.0)) || (other->shape == NPH_SHAPE_GRID && other->empty);
        others += other->number != number && !empty;
    }
    for (int c = 0; c < 3; c++) out->value[c] = (Real)emission->value[c];
    out->alone = others == 0;
    out->field.number = number;
    if (emission->kind == NPH_EMISSION_CONSTANT) {
        r_prepare_medium(medium, scene->origin, number, &out->field);
        r_prepare_reach(medium, scene, &out->field);
        return;
    }
    const NphGrid *grid = nph_emission_grid(emission, &medium->grid, 0);
    out->field.shape = NPH_SHAPE_GRID;
    r_prepare_place(emission->world_from_grid, grid->lo, grid->hi, scene->origin, &out->field);
    out->grids = emission->grid_count > 1 ? 3 : 1;
    for (int c = 0; c < 3; c++) nph_grid_view(nph_emission_grid(emission, &medium->grid, c), &out->grid[c]);
    out->field.grid = out->grid[0];
    out->field.majorant = emission->bound.cells;
    out->field.sigma_max = emission->depth > 0.0 ? (Real)(1.0 / emission->depth) : R(0.0);
    for (int a = 0; a < 3; a++) out->field.majorant_n[a] = emission->bound.n[a];
    NphMedium place = {.shape = NPH_SHAPE_GRID, .grid = *grid};
    place.grid.majorant = emission->bound;
    memcpy(place.world_from_medium, emission->world_from_grid, sizeof place.world_from_medium);
    r_prepare_reach(&place, scene, &out->field);
}

/* The box that camera rays are moved to. A layer fills x and y without end, air everything; planes are looked at by
 * themselves. */
static inline void r_prepare_bounds(const NphScene *scene, RScene *out) {
    double lo[3], hi[3], room = 0.0;
    int layers = 0, air = 0;
    for (int m = 0; m < scene->medium_count; m++) {
        layers |= scene->media[m].shape == NPH_SHAPE_LAYER;
        air |= scene->media[m].shape == NPH_SHAPE_AIR;
    }
    nph_scene_bounds(scene, lo, hi);
    /* faces may lie in the sides of that box: rays stop before it, by more than f32 loses there */
    for (int a = 0; a < 3 && scene->bvh.nodes; a++)
        room = hi[a] - lo[a] > room * 0x1p16 ? (hi[a] - lo[a]) * 0x1p-16 : room;
    for (int a = 0; a < 3; a++) {
        int repeats = a < 2 && scene->period.on[a];
        int bounded = !repeats && !air && lo[a] <= hi[a] && lo[a] > -R_NO_END && hi[a] < R_NO_END && (a == 2 || !layers);
        out->bounds_lo[a] = bounded ? lo[a] - out->origin[a] - room : -2.0 * R_NO_END;
        out->bounds_hi[a] = bounded ? hi[a] - out->origin[a] + room : 2.0 * R_NO_END;
    }
}

static inline void r_note_colours(RScene *out) {
    out->chromatic = 0;
    for (int m = 0; m < out->medium_count; m++) {
        const Real *sigma = out->media[m].sigma;
        out->chromatic |= (sigma[0] != sigma[1]) | (sigma[0] != sigma[2]);
    }
}

static inline void r_prepare_scene(const NphScene *scene, const NphTransportChoice *choice, uint32_t seed, uint32_t frame,
                                   RScene *out) {
    memset(out, 0, sizeof *out);
    nph_scene_origin(scene, out->origin);
    r_prepare_bounds(scene, out);
    r_prepare_period(&scene->period, out);
    r_prepare_surfaces(scene, out->origin, &out->surfaces);
    out->channels = choice->channels;
    out->film_channels = choice->film_channels;
    out->heroes = choice->channels * choice->groups;
    out->groups = 1;
    out->width = scene->sensor.width;
    out->height = scene->sensor.height;
    out->seed = seed;
    out->frame = frame;
    out->guide = -1;
    out->weight_unit = R(1.0);
    out->sensor = scene->sensor;
    for (int m = 0; m < scene->medium_count; m++)
        if (choice->used[m]) {
            r_prepare_medium(&scene->media[m], out->origin, (uint32_t)m, &out->media[out->medium_count]);
            r_prepare_reach(&scene->media[m], out, &out->media[out->medium_count++]);
        }
    r_note_colours(out);
    for (int m = 0; m < scene->medium_count; m++)
        if (choice->emits[m]) r_prepare_emitter(&scene->media[m], out, (uint32_t)m, &out->emitters[out->emitter_count++]);
    for (int l = 0; l < scene->light_count; l++)
        r_prepare_light(&scene->lights[l], out->origin, choice->sampled[l], &out->lights[l]);
    out->light_count = scene->light_count;
}

/* Three wavelengths of a spectral scene in place of the channels that r_prepare_scene took. Only what differs between
 * groups: extinction, albedo, lights, and the way to R, G, B. */
static inline void r_take_group(const NphScene *scene, int group, RScene *out) {
    double a[3], b[3], matrix[9];
    for (int m = 0; m < out->medium_count; m++) {
        const NphMedium *medium = &scene->media[out->media[m].number];
        nph_scene_channels(scene, group, medium->extinction_per_m, medium->extinction_spectrum, a);
        nph_scene_channels(scene, group, medium->albedo, medium->albedo_spectrum, b);
        r_medium_values(a, b, &out->media[m]);
    }
    for (int l = 0; l < out->light_count; l++) {
        if (scene->lights[l].kind == NPH_LIGHT_ENVIRONMENT) continue; /* grey */
        nph_scene_channels(scene, group, NULL, scene->lights[l].spectrum, a);
        r_light_values(&scene->lights[l], a, &out->lights[l]);
    }
    for (int s = 0; s < out->surfaces.count; s++) {
        nph_scene_channels(scene, group, NULL, scene->surfaces[s].albedo_spectrum, a);
        for (int c = 0; c < 3; c++) out->surfaces.albedo[s][c] = (Real)a[c];
    }
    r_note_colours(out);
    out->spectral = 1;
    out->groups = nph_wavelength_groups(scene->wavelength_count);
    nph_wavelength_matrix(scene->wavelengths_nm, scene->wavelength_count, group, matrix);
    for (int i = 0; i < 9; i++) out->rgb_from_channels[i] = (Real)(matrix[i] * (double)out->groups);
}

/* All groups (choice->groups of them), one after another. */
static inline void r_prepare_groups(const NphScene *scene, const NphTransportChoice *choice, uint32_t seed, uint32_t frame,
                                    RScene *out) {
    for (int g = 0; g < choice->groups; g++) {
        r_prepare_scene(scene, choice, seed, frame, &out[g]);
        if (nph_scene_is_spectral(scene)) r_take_group(scene, g, &out[g]);
    }
}

#endif
