/* SPDX-License-Identifier: Apache-2.0
 *
 * What a scene knows about itself once it is made: its bounds, its origin, the channels of a value,
 * its other frames. */
#include "scene/model.h"

#include <math.h>

#include "core/memory.h"
#include "core/message.h"

static void free_scene_parts(NphContext *context, NphScene *scene) {
    for (int i = 0; i < scene->medium_count; i++) {
        nph_free(context, scene->media[i].name);
        nph_free(context, scene->media[i].unmodelled);
        nph_grid_free(context, &scene->media[i].grid);
        nph_emission_free(context, &scene->media[i].emission);
        nph_phase_free(context, &scene->media[i].phase);
    }
    for (int i = 0; i < scene->light_count; i++) {
        nph_free(context, scene->lights[i].name);
        nph_environment_free(context, &scene->lights[i].map);
    }
    for (int i = 0; i < scene->surface_count; i++) {
        nph_free(context, scene->surfaces[i].name);
        nph_mesh_free(context, &scene->surfaces[i].mesh);
    }
    nph_phase_free(context, &scene->air.aerosol.phase);
    nph_bvh_free(context, &scene->bvh);
    nph_free(context, scene->name);
    nph_free(context, scene->source.text);
    nph_free(context, scene->source.name);
    nph_free(context, scene->source.folder);
}

void nph_scene_free(NphContext *context, NphScene *scene) {
    if (!scene) return;
    free_scene_parts(context, scene);
    nph_free(context, scene);
}

NphStatus nph_scene_at_frame(NphContext *context, const NphScene *scene, uint32_t frame, NphScene **other) {
    if (scene->source.read) return scene->source.read(context, &scene->source, frame, other);
    return nph_error(context, NPH_BAD_USAGE, "frame %u of %s: the scene was made without a text to read again", (unsigned)frame,
                     scene->name ? scene->name : "a scene");
}

int nph_scene_is_animated(const NphScene *scene) { return scene->animated; }

static void grow(double lo[3], double hi[3], int axis, double value) {
    if (value < lo[axis]) lo[axis] = value;
    if (value > hi[axis]) hi[axis] = value;
}

static void grow_by_box(const double map[12], const double low[3], const double high[3], double lo[3], double hi[3]) {
    for (int corner = 0; corner < 8; corner++) {
        double x = corner & 1 ? high[0] : low[0], y = corner & 2 ? high[1] : low[1], z = corner & 4 ? high[2] : low[2];
        for (int axis = 0; axis < 3; axis++)
            grow(lo, hi, axis, map[axis * 4] * x + map[axis * 4 + 1] * y + map[axis * 4 + 2] * z + map[axis * 4 + 3]);
    }
}

void nph_medium_bounds(const NphMedium *medium, double lo[3], double hi[3]) {
    const double *map = medium->world_from_medium;
    const double *low = medium->shape == NPH_SHAPE_GRID ? medium->grid.lo : medium->lo;
    const double *high = medium->shape == NPH_SHAPE_GRID ? medium->grid.hi : medium->hi;
    for (int axis = 0; axis < 3; axis++) {
        lo[axis] = medium->shape == NPH_SHAPE_LAYER || medium->shape == NPH_SHAPE_AIR ? -HUGE_VAL : HUGE_VAL;
        hi[axis] = -lo[axis];
    }
    if (medium->shape == NPH_SHAPE_LAYER || medium->shape == NPH_SHAPE_AIR) {
        lo[2] = HUGE_VAL;
        hi[2] = -HUGE_VAL;
        grow(lo, hi, 2, map[10] * low[2] + map[11]);
        grow(lo, hi, 2, map[10] * high[2] + map[11]);
        return;
    }
    grow_by_box(map, low, high, lo, hi);
}

int nph_emission_bounds(const NphMedium *medium, double lo[3], double hi[3]) {
    const NphEmission *emission = &medium->emission;
    if (emission->kind != NPH_EMISSION_GRID) return 0;
    for (int axis = 0; axis < 3; axis++) {
        lo[axis] = HUGE_VAL;
        hi[axis] = -HUGE_VAL;
    }
    grow_by_box(emission->world_from_grid, emission->grids[0].lo, emission->grids[0].hi, lo, hi);
    return 1;
}

void nph_scene_bounds(const NphScene *scene, double lo[3], double hi[3]) {
    for (int axis = 0; axis < 3; axis++) {
        lo[axis] = HUGE_VAL;
        hi[axis] = -HUGE_VAL;
    }
    for (int m = 0; m < scene->medium_count; m++) {
        double low[3], high[3];
        if (scene->media[m].shape == NPH_SHAPE_AIR) continue;
        nph_medium_bounds(&scene->media[m], low, high);
        for (int axis = scene->media[m].shape == NPH_SHAPE_LAYER ? 2 : 0; axis < 3; axis++) {
            grow(lo, hi, axis, low[axis]);
            grow(lo, hi, axis, high[axis]);
        }
        int emits = nph_emission_bounds(&scene->media[m], low, high);
        for (int axis = 0; axis < 3 && emits; axis++) {
            grow(lo, hi, axis, low[axis]);
            grow(lo, hi, axis, high[axis]);
        }
    }
    for (int s = 0; s < scene->surface_count; s++) {
        const NphSurface *surface = &scene->surfaces[s];
        if (surface->is_plane) grow(lo, hi, 2, surface->height_m);
        for (int64_t i = 0; i < 3 * (int64_t)surface->mesh.vertex_count; i++)
            grow(lo, hi, (int)(i % 3), surface->mesh.vertices_m[i]);
    }
}

void nph_scene_origin(const NphScene *scene, double origin[3]) {
    double lo[3], hi[3];
    nph_scene_bounds(scene, lo, hi);
    for (int axis = 0; axis < 3; axis++)
        origin[axis] = lo[axis] <= hi[axis] ? 0.5 * lo[axis] + 0.5 * hi[axis] : scene->sensor.position[axis];
    for (int axis = 0; axis < 2; axis++)
        if (scene->period.on[axis]) origin[axis] = 0.5 * scene->period.lo[axis] + 0.5 * scene->period.hi[axis];
}

void nph_scene_channels(const NphScene *scene, int group, const double rgb[3], const double *spectrum, double out[3]) {
    for (int c = 0; c < 3; c++) {
        int repeated;
        out[c] = nph_scene_is_spectral(scene) ? spectrum[nph_wavelength_of(scene->wavelength_count, group, c, &repeated)]
                                              : rgb[c];
    }
}
