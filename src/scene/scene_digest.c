/* SPDX-License-Identifier: Apache-2.0
 *
 * The digest of a scene: XXH3 (128 bits) over its values one by one in little-endian order, never over the memory of
 * structs; -0 counts as 0. Only what the kind of a thing uses enters. */
#include <string.h>
#include <xxhash.h>

#include "core/memory.h"
#include "scene/scene_read.h"

enum { NPH_DIGEST_BYTES = 4096 };

typedef struct Digest {
    XXH3_state_t *state;
    size_t used;
    unsigned char bytes[NPH_DIGEST_BYTES];
} Digest;

static void flush(Digest *digest) {
    XXH3_128bits_update(digest->state, digest->bytes, digest->used);
    digest->used = 0;
}

static void put(Digest *digest, uint64_t value, int bytes) {
    if (digest->used + 8 > NPH_DIGEST_BYTES) flush(digest);
    for (int i = 0; i < bytes; i++) digest->bytes[digest->used++] = (unsigned char)(value >> (8 * i));
}

static void put_int(Digest *digest, int64_t value) { put(digest, (uint64_t)value, 8); }

static void put_doubles(Digest *digest, const double *values, int64_t count) {
    for (int64_t i = 0; i < count; i++) {
        uint64_t bits = 0;
        if (values[i] != 0) memcpy(&bits, &values[i], sizeof bits);
        put(digest, bits, 8);
    }
}

static void put_floats(Digest *digest, const float *values, int64_t count) {
    for (int64_t i = 0; i < count; i++) {
        uint32_t bits = 0;
        if (values[i] != 0) memcpy(&bits, &values[i], sizeof bits);
        put(digest, bits, 4);
    }
}

static void put_sensor(Digest *digest, const NphSensor *sensor) {
    put_int(digest, sensor->kind);
    put_int(digest, sensor->width);
    put_int(digest, sensor->height);
    for (int i = 0; i < 4; i++) put_int(digest, sensor->crop[i]);
    put_doubles(digest, sensor->position, 3);
    put_doubles(digest, sensor->right, 3);
    put_doubles(digest, sensor->up, 3);
    put_doubles(digest, sensor->forward, 3);
    put_doubles(digest, sensor->half_size, 2);
    if (sensor->kind == NPH_SENSOR_RADIANCE) put_doubles(digest, sensor->seen, 3);
}

static void put_period(Digest *digest, const NphPeriod *period) {
    for (int a = 0; a < 2; a++) {
        if (!period->on[a]) continue;
        put_int(digest, a);
        put_doubles(digest, &period->lo[a], 1);
        put_doubles(digest, &period->hi[a], 1);
    }
}

/* Brick after brick as the index orders them, so that how equal bricks are shared makes no difference. */
static void put_grid(Digest *digest, const NphGrid *grid) {
    int64_t bricks = (int64_t)grid->bricks[0] * grid->bricks[1] * grid->bricks[2];
    for (int i = 0; i < 3; i++) put_int(digest, grid->n[i]);
    put_int(digest, grid->lookup);
    put_doubles(digest, grid->lo, 3);
    put_doubles(digest, grid->hi, 3);
    for (int64_t i = 0; i < bricks; i++) {
        int32_t brick = grid->brick_index[i];
        put_int(digest, brick != 0);
        if (brick) put_floats(digest, grid->values + (int64_t)brick * NPH_BRICK_STRIDE,
                              NPH_BRICK_EDGE * NPH_BRICK_EDGE * NPH_BRICK_EDGE);
    }
}

/* A scene without emission has the digest of one that knows none. */
static void put_emission(Digest *digest, const NphEmission *emission) {
    if (emission->kind == NPH_EMISSION_NONE) return;
    put_int(digest, emission->kind);
    put_doubles(digest, emission->value, 3);
    for (int g = 0; g < emission->grid_count; g++) put_grid(digest, &emission->grids[g]);
    if (emission->kind == NPH_EMISSION_GRID) put_doubles(digest, emission->world_from_grid, 12);
}

static void put_phase(Digest *digest, const NphPhase *phase) {
    put_int(digest, phase->kind);
    put_doubles(digest, phase->g, 2);
    put_doubles(digest, &phase->weight, 1);
    if (phase->kind == NPH_PHASE_DRAINE) put_doubles(digest, &phase->alpha, 1);
    if (phase->kind != NPH_PHASE_TABULATED) return;
    for (int h = 0; h < 2; h++) {
        const NphPhaseHalf *half = &phase->table->half[h];
        put_int(digest, half->count);
        put_doubles(digest, half->x, half->count + 1);
        put_doubles(digest, half->value, half->count + 1);
    }
}

static void put_medium(Digest *digest, const NphMedium *medium) {
    put_int(digest, medium->shape);
    if (medium->shape == NPH_SHAPE_GRID) put_grid(digest, &medium->grid);
    else {
        put_doubles(digest, medium->lo, 3);
        put_doubles(digest, medium->hi, 3);
    }
    if (medium->shape == NPH_SHAPE_AIR) {
        put_doubles(digest, &medium->scale_height_m, 1);
        put_doubles(digest, &medium->radius_m, 1);
    }
    put_doubles(digest, medium->world_from_medium, 12);
    put_doubles(digest, medium->extinction_per_m, 3);
    put_doubles(digest, medium->albedo, 3);
    put_emission(digest, &medium->emission);
    put_phase(digest, &medium->phase);
}

static void put_light(Digest *digest, const NphLight *light) {
    put_int(digest, light->kind);
    switch (light->kind) {
    case NPH_LIGHT_SUN:
        put_doubles(digest, light->direction, 3);
        put_doubles(digest, light->irradiance, 3);
        put_doubles(digest, &light->half_angle_rad, 1);
        break;
    case NPH_LIGHT_CONSTANT:
        put_doubles(digest, light->radiance, 3);
        put_int(digest, light->hemisphere);
        break;
    case NPH_LIGHT_ENVIRONMENT:
        put_int(digest, light->map.width);
        put_int(digest, light->map.height);
        put_floats(digest, light->map.radiance, (int64_t)light->map.width * light->map.height * 3);
        put_doubles(digest, &light->rotation_rad, 1);
        break;
    case NPH_LIGHT_POINT:
        put_doubles(digest, light->position, 3);
        put_doubles(digest, light->intensity, 3);
        break;
    }
}

/* Triangles as points, so that how they share vertices makes no difference. */
static void put_surface(Digest *digest, const NphSurface *surface) {
    const NphMesh *mesh = &surface->mesh;
    put_int(digest, surface->is_plane);
    put_doubles(digest, surface->albedo, 3);
    if (surface->radius_m > 0.0) put_doubles(digest, &surface->radius_m, 1);
    if (surface->is_plane) put_doubles(digest, &surface->height_m, 1);
    else put_int(digest, mesh->triangle_count);
    for (int64_t i = 0; i < 3 * (int64_t)mesh->triangle_count; i++)
        put_doubles(digest, mesh->vertices_m + 3 * (int64_t)mesh->triangles[i], 3);
}

/* A scene without wavelengths has the digest of one that knows none. */
static void put_wavelengths(Digest *digest, const NphScene *scene) {
    int count = scene->wavelength_count;
    if (count == 0) return;
    put_int(digest, count);
    put_doubles(digest, scene->wavelengths_nm, count);
    for (int m = 0; m < scene->medium_count; m++) {
        put_doubles(digest, scene->media[m].extinction_spectrum, count);
        put_doubles(digest, scene->media[m].albedo_spectrum, count);
    }
    for (int l = 0; l < scene->light_count; l++) put_doubles(digest, scene->lights[l].spectrum, count);
    for (int s = 0; s < scene->surface_count; s++) put_doubles(digest, scene->surfaces[s].albedo_spectrum, count);
}

NphStatus nph_scene_digest(NphContext *context, NphScene *scene) {
    Digest digest = {0};
    digest.state = XXH3_createState();
    if (!digest.state) return nph_error(context, NPH_NO_MEMORY, "out of memory: state of the scene's digest");
    XXH3_128bits_reset(digest.state);
    put_wavelengths(&digest, scene);
    put_sensor(&digest, &scene->sensor);
    put_period(&digest, &scene->period);
    put_int(&digest, scene->medium_count);
    for (int i = 0; i < scene->medium_count; i++) put_medium(&digest, &scene->media[i]);
    put_int(&digest, scene->light_count);
    for (int i = 0; i < scene->light_count; i++) put_light(&digest, &scene->lights[i]);
    if (scene->surface_count > 0) { /* scenes without keep the digest that they have always had */
        put_int(&digest, -1);
        put_int(&digest, scene->surface_count);
    }
    for (int i = 0; i < scene->surface_count; i++) put_surface(&digest, &scene->surfaces[i]);
    flush(&digest);
    XXH128_canonical_t canonical;
    XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(digest.state));
    memcpy(scene->digest, canonical.digest, sizeof scene->digest);
    XXH3_freeState(digest.state);
    return NPH_OK;
}
