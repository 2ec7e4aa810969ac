/* SPDX-License-Identifier: Apache-2.0
 *
 * The memory of a batch, and the scene in the kernels' number type. World space (f64) is turned into scene-local space
 * here: its origin is the centre of the media's box (zero along axes without end), so that f32 positions keep their
 * precision however far from the world's origin the scene lies. */
#include <string.h>

#include "field/sample.h"
#include "truth/path/path_lanes.h"

size_t NPH_KERNEL(nph_path_scene_bytes)(void);
void NPH_KERNEL(nph_path_prepare)(const NphJob *job, const NphPathChoice *choice, void *memory);
size_t NPH_KERNEL(nph_path_batch_bytes)(void);
void NPH_KERNEL(nph_path_layout)(void *memory, const void *scene, NphPathBatch **out);
void NPH_KERNEL(nph_path_begin)(NphPathBatch *batch, const int origin[2], const int inside[4], int64_t chunk);
int NPH_KERNEL(nph_path_count)(const NphPathBatch *batch);
const void *NPH_KERNEL(nph_path_samples)(const NphPathBatch *batch);
const NphPathTally *NPH_KERNEL(nph_path_tally)(const NphPathBatch *batch);

static const double huge = 1e300;

size_t NPH_KERNEL(nph_path_scene_bytes)(void) { return sizeof(RScene); }

/* Density over majorant in the mean over the cells, each as heavy as its majorant. */
static Real mean_of_majorant(const NphGrid *grid) {
    const int32_t *n = grid->majorant.n;
    int64_t cells = (int64_t)n[0] * n[1] * n[2], samples = NPH_MAJORANT_CELL * NPH_MAJORANT_CELL * NPH_MAJORANT_CELL;
    double sum = 0.0;
    for (int64_t i = 0; i < cells; i++) sum += grid->majorant.cells[i] > 0.0f ? (double)grid->majorant.cells[i] : 0.0;
    double part = sum > 0.0 ? grid->sum / (sum * (double)samples) : 0.0;
    return (Real)(part < 1.0 ? part : 1.0);
}

/* weighed: what part of the absorption weighs flights; at least a quarter of the extinction makes collisions, which tell
 * the distance of the first one. */
static void prepare_medium(const NphMedium *medium, const double origin[3], double weighed, uint32_t number, RMedium *out) {
    double medium_from_world[12];
    nph_affine_invert(medium->world_from_medium, medium_from_world);
    out->shape = medium->shape;
    out->number = number;
    for (int a = 0; a < 3; a++) {
        const double *row = medium_from_world + 4 * a;
        for (int b = 0; b < 3; b++) out->from_local[4 * a + b] = (Real)row[b];
        out->from_local[4 * a + 3] = (Real)(row[3] + row[0] * origin[0] + row[1] * origin[1] + row[2] * origin[2]);
        double lo = medium->shape == NPH_SHAPE_GRID ? medium->grid.lo[a] : medium->lo[a];
        double hi = medium->shape == NPH_SHAPE_GRID ? medium->grid.hi[a] : medium->hi[a];
        out->lo[a] = lo > -huge ? (Real)lo : -R_FAR;
        out->hi[a] = hi < huge ? (Real)hi : R_FAR;
    }
    double largest = 0.0;
    for (int c = 0; c < 3; c++) largest = medium->extinction_per_m[c] > largest ? medium->extinction_per_m[c] : largest;
    out->sigma_max = (Real)largest;
    for (int c = 0; c < 3; c++) {
        out->sigma[c] = (Real)medium->extinction_per_m[c];
        out->ratio[c] = largest > 0.0 ? (Real)(medium->extinction_per_m[c] / largest) : R(0.0);
    }
    double least = medium->albedo[0] > 0.25 ? medium->albedo[0] : 0.25, collide = 1.0 - weighed * (1.0 - least);
    out->collide = (Real)collide;
    for (int c = 0; c < 3; c++) out->albedo[c] = (Real)(medium->albedo[c] / collide);
    out->phase = r_phase(&medium->phase);
    if (medium->shape != NPH_SHAPE_GRID) return;
    nph_grid_view(&medium->grid, &out->grid);
    out->majorant = medium->grid.majorant.cells;
    out->control = mean_of_majorant(&medium->grid);
    for (int a = 0; a < 3; a++) out->majorant_n[a] = medium->grid.majorant.n[a];
}

/* A disc sun of half angle h has the radiance E / (pi sin^2 h); its cap's solid angle is 2 pi (1 - cos h). */
static void prepare_light(const NphLight *light, const double origin[3], int sampled, RLight *out) {
    out->kind = (int)light->kind;
    out->hemisphere = light->hemisphere;
    out->sampled = sampled;
    double scale = 1.0;
    if (light->kind == NPH_LIGHT_SUN && light->half_angle_rad > 0.0) {
        double sine = nph_sin(light->half_angle_rad);
        out->disc = r_disc(light->direction, light->half_angle_rad);
        scale = 1.0 / (3.14159265358979323846 * sine * sine);
    }
    const double *value = light->kind == NPH_LIGHT_SUN     ? light->irradiance
                          : light->kind == NPH_LIGHT_POINT ? light->intensity
                                                           : light->radiance;
    for (int c = 0; c < 3; c++) {
        out->value[c] = (Real)(value[c] * scale);
        out->direction[c] = (Real)light->direction[c];
        out->position[c] = (Real)(light->position[c] - origin[c]);
    }
    if (light->kind == NPH_LIGHT_ENVIRONMENT) out->map = r_environment(&light->map, light->rotation_rad);
}

void NPH_KERNEL(nph_path_prepare)(const NphJob *job, const NphPathChoice *choice, void *memory) {
    const NphScene *scene = job->scene;
    RScene *out = memory;
    memset(out, 0, sizeof *out);
    double lo[3], hi[3];
    nph_scene_bounds(scene, lo, hi);
    for (int a = 0; a < 3; a++) {
        int bounded = lo[a] <= hi[a] && lo[a] > -huge && hi[a] < huge;
        out->origin[a] = bounded ? 0.5 * lo[a] + 0.5 * hi[a] : scene->sensor.position[a];
        out->bounds_lo[a] = bounded ? lo[a] - out->origin[a] : -2.0 * huge;
        out->bounds_hi[a] = bounded ? hi[a] - out->origin[a] : 2.0 * huge;
    }
    out->channels = choice->channels;
    out->film_channels = choice->film_channels;
    out->weighed = choice->weighed > 0.0;
    out->width = scene->sensor.width;
    out->height = scene->sensor.height;
    out->seed = job->seed;
    out->frame = job->frame;
    out->roulette = (Real)job->knobs[NPH_PATH_KNOB_ROULETTE];
    out->shadow_roulette = (Real)job->knobs[NPH_PATH_KNOB_SHADOW_ROULETTE];
    out->guide = choice->guide;
    out->weight_unit = scene->sensor.kind == NPH_SENSOR_FLUX ? R(0.31830988618379067154) : R(1.0);
    out->guide_part = (Real)choice->guide_part;
    out->least_light = (Real)(choice->least_light * 0.079577471545947668);
    out->sensor = scene->sensor;
    for (int m = 0; m < scene->medium_count; m++)
        if (choice->used[m])
            prepare_medium(&scene->media[m], out->origin, choice->weighed, (uint32_t)m, &out->media[out->medium_count++]);
    for (int l = 0; l < scene->light_count; l++)
        prepare_light(&scene->lights[l], out->origin, choice->sampled[l], &out->lights[l]);
    out->light_count = scene->light_count;
}

/* Arrays of a batch in the order in which they lie; called once to measure and once to place. */
static size_t place(NphPathBatch *batch, char *memory) {
    size_t at = (sizeof(NphPathBatch) + 63) / 64 * 64;
    size_t reals = (size_t)NPH_PATH_BATCH * sizeof(Real), ints = (size_t)NPH_PATH_BATCH * sizeof(int32_t);
#define PLACE(target, bytes)                                       \
    do {                                                           \
        if (memory) (target) = (void *)(memory + at);              \
        at += (bytes);                                             \
    } while (0)
    for (int set = 0; set < 2; set++) {
        RPaths *paths = &batch->paths[set];
        /* one after another: loops over lanes reach them from p[0] (R_OF_P ... R_ARRAYS) */
        for (int a = 0; a < 3; a++) PLACE(paths->p[a], reals);
        for (int a = 0; a < 3; a++) PLACE(paths->d[a], reals);
        for (int c = 0; c < 3; c++) PLACE(paths->weight[c], reals);
        for (int c = 0; c < 3; c++) PLACE(paths->share[c], reals);
        PLACE(paths->pdf, reals);
        PLACE(paths->id, ints);
        PLACE(paths->hero, ints);
    }
    PLACE(batch->distance, reals);
    PLACE(batch->survived, reals);
    PLACE(batch->walked, reals);
    PLACE(batch->medium, ints);
    PLACE(batch->queue, ints);
    PLACE(batch->escaped, ints);
    for (int a = 0; a < 3; a++) PLACE(batch->ray[a], reals);
    for (int a = 0; a < 3; a++) PLACE(batch->towards[a], reals);
    for (int a = 0; a < 3; a++) PLACE(batch->arriving[a], reals);
    PLACE(batch->carried, reals);
    PLACE(batch->passed, reals);
    PLACE(batch->reach, reals);
    PLACE(batch->ray_id, ints);
    PLACE(batch->flights, (sizeof(RFlights) + 63) / 64 * 64);
    PLACE(batch->samples, reals * NPH_SAMPLE_FIELDS);
    PLACE(batch->start, reals);
#undef PLACE
    return at;
}

size_t NPH_KERNEL(nph_path_batch_bytes)(void) {
    NphPathBatch measure;
    return place(&measure, NULL);
}

void NPH_KERNEL(nph_path_layout)(void *memory, const void *scene, NphPathBatch **out) {
    NphPathBatch *batch = memory;
    memset(batch, 0, sizeof *batch);
    batch->scene = scene;
    place(batch, memory);
    *out = batch;
}

void NPH_KERNEL(nph_path_begin)(NphPathBatch *batch, const int origin[2], const int inside[4], int64_t chunk) {
    batch->tile_x = origin[0];
    batch->tile_y = origin[1];
    memcpy(batch->inside, inside, sizeof batch->inside);
    batch->first_sample = (uint32_t)(chunk * NPH_CHUNK);
    batch->now = batch->count = 0;
    memset(batch->samples, 0, sizeof(Real) * NPH_SAMPLE_FIELDS * NPH_PATH_BATCH);
}

int NPH_KERNEL(nph_path_count)(const NphPathBatch *batch) { return batch->count; }
const void *NPH_KERNEL(nph_path_samples)(const NphPathBatch *batch) { return batch->samples; }
const NphPathTally *NPH_KERNEL(nph_path_tally)(const NphPathBatch *batch) { return &batch->tally; }
