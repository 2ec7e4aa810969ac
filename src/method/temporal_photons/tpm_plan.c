/* SPDX-License-Identifier: Apache-2.0
 *
 * What temporal photons do for a scene, what they leave out, and what they refuse. */
#include <string.h>

#include "core/fmath.h"
#include "core/message.h"
#include "core/philox.h"
#include "method/temporal_photons/tpm_carry.h"
#include "pipeline/plan.h"

static NphStatus refuse_medium(NphContext *context, const NphMedium *medium) {
    const double *sigma = medium->extinction_per_m;
    if (medium->shape == NPH_SHAPE_LAYER)
        return nph_error(context, NPH_BAD_SCENE, "temporal_photons: medium %s is a layer without end, which no grid of cells fills; a box has an end",
                         medium->name);
    if (medium->emission.kind != NPH_EMISSION_NONE)
        return nph_error(context, NPH_BAD_SCENE, "temporal_photons: medium %s emits light, which this method does not follow", medium->name);
    if (medium->phase.kind != NPH_PHASE_HG && medium->phase.kind != NPH_PHASE_ISOTROPIC)
        return nph_error(context, NPH_BAD_SCENE, "temporal_photons: medium %s: the cache is made for the phase function hg (or isotropic); path has the others",
                         medium->name);
    if (sigma[0] != sigma[1] || sigma[0] != sigma[2])
        return nph_error(context, NPH_BAD_SCENE,
                         "temporal_photons: medium %s: its extinction differs between channels; photons of this method see one; path has more",
                         medium->name);
    return NPH_OK;
}

static NphStatus refuse(const NphJob *job, const NphTpmChoice *choice) {
    const NphScene *scene = job->scene;
    NphContext *context = job->context;
    int used = 0;
    NPH_TRY(nph_transport_refuse_air(context, scene, "temporal_photons"));
    if (scene->period.on[0] || scene->period.on[1])
        return nph_error(context, NPH_BAD_SCENE, "temporal_photons: sides that repeat are not part of this method; path has them");
    if (scene->surface_count > 0)
        return nph_error(context, NPH_BAD_SCENE, "temporal_photons: surface %s: surfaces are not part of this method; path has them",
                         scene->surfaces[0].name);
    if (nph_sensor_gathers(scene->sensor.kind))
        return nph_error(context, NPH_BAD_SCENE, "temporal_photons: a sensor that gathers light from many directions is not part of this method; path and light have it");
    if (job->knobs[NPH_TPM_KNOB_IMPOSTORS] > 0.5 && scene->sensor.kind != NPH_SENSOR_PERSPECTIVE)
        return nph_error(context, NPH_BAD_SCENE, "temporal_photons: impostors are seen by a perspective camera; tpm.impostors=0 has the others");
    for (int m = 0; m < scene->medium_count; m++) {
        if (!choice->transport.used[m]) continue;
        NPH_TRY(refuse_medium(context, &scene->media[m]));
        if (used++)
            return nph_error(context, NPH_BAD_SCENE, "temporal_photons: medium %s: there is one medium in this method; path has more",
                             scene->media[m].name);
    }
    return NPH_OK;
}

/* Edges of the medium's box in metres. */
static void edges_of(const NphMedium *medium, double edges[3]) {
    const double *m = medium->world_from_medium;
    int grid = medium->shape == NPH_SHAPE_GRID;
    for (int a = 0; a < 3; a++) {
        double size = grid ? medium->grid.hi[a] - medium->grid.lo[a] : medium->hi[a] - medium->lo[a];
        edges[a] = size * nph_sqrt(m[a] * m[a] + m[4 + a] * m[4 + a] + m[8 + a] * m[8 + a]);
    }
}

/* Cells as near to cubes as whole numbers allow, at most `most` of them: the smallest edge for which there are not more. */
static void choose_cells(const double edges[3], double most, int32_t cells[3]) {
    double low = 0.0, high = edges[0] + edges[1] + edges[2];
    for (int i = 0; i < 200; i++) {
        double edge = 0.5 * (low + high), count = 1.0;
        for (int a = 0; a < 3; a++) count *= nph_floor(edges[a] / edge) > 1.0 ? nph_floor(edges[a] / edge) : 1.0;
        if (count > most) low = edge;
        else high = edge;
    }
    for (int a = 0; a < 3; a++) {
        double count = nph_floor(edges[a] / high);
        cells[a] = count > 1.0 ? (int32_t)count : 1;
    }
}

static NphStatus choose_grids(const NphJob *job, NphTpmChoice *choice) {
    const NphMedium *medium = &job->scene->media[choice->medium];
    double edges[3];
    edges_of(medium, edges);
    choose_cells(edges, job->knobs[NPH_TPM_KNOB_CELLS], choice->cells);
    for (int a = 0; a < 3; a++) {
        double given = job->knobs[NPH_TPM_KNOB_CELLS_X + a];
        if (given > 0.0) choice->cells[a] = (int32_t)given;
        int guided = medium->shape == NPH_SHAPE_GRID && job->knobs[NPH_TPM_KNOB_UPSAMPLING] > 0.5;
        choice->fine[a] = guided ? medium->grid.n[a] - 2 : choice->cells[a];
    }
    if ((double)choice->cells[0] * choice->cells[1] * choice->cells[2] > (double)NPH_TPM_CELLS_MAX)
        return nph_error(job->context, NPH_BAD_USAGE, "temporal_photons: %d x %d x %d cells; at most %d", (int)choice->cells[0],
                         (int)choice->cells[1], (int)choice->cells[2], (int)NPH_TPM_CELLS_MAX);
    choice->shared = nph_tpm_cells(choice->cells) <= NPH_TPM_SHARED_CELLS;
    return NPH_OK;
}

static double brightness(const double c[3]) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; }

/* The brightest sun; then photons in proportion to the power that enters a box as large, seen from all sides in the mean. */
static void choose_lights(const NphJob *job, NphTpmChoice *choice) {
    const NphScene *scene = job->scene;
    double edges[3], lo[3], hi[3], sun = 0.0, sky = 0.0, power[NPH_MAX_LIGHTS], diagonal = 0.0;
    edges_of(&scene->media[choice->medium], edges);
    nph_medium_bounds(&scene->media[choice->medium], lo, hi);
    double mean = 0.5 * (edges[0] * edges[1] + edges[1] * edges[2] + edges[2] * edges[0]);
    for (int a = 0; a < 3; a++) diagonal += edges[a] * edges[a];
    for (int l = 0; l < scene->light_count; l++) {
        const NphLight *light = &scene->lights[l];
        double squared = 0.0, seen = 4.0;
        for (int a = 0; a < 3; a++) squared += (light->position[a] - 0.5 * (lo[a] + hi[a])) * (light->position[a] - 0.5 * (lo[a] + hi[a]));
        if (squared > 0.25 * diagonal) seen = diagonal / (4.0 * squared);
        power[l] = light->kind == NPH_LIGHT_SUN           ? brightness(light->irradiance) * mean
                   : light->kind == NPH_LIGHT_CONSTANT    ? brightness(light->radiance) * mean * (light->hemisphere ? 6.2831853 : 12.566371)
                   : light->kind == NPH_LIGHT_ENVIRONMENT ? light->map.total * mean
                                                          : brightness(light->intensity) * 3.1415927 * seen;
        /* one that has gone out still tells where its older photons came from */
        int first = choice->dominant < 0 && nph_scene_is_animated(scene);
        if (light->kind == NPH_LIGHT_SUN && (power[l] > sun || first)) {
            sun = power[l];
            choice->dominant = l;
        }
    }
    for (int l = 0; l < scene->light_count; l++) sky += l == choice->dominant ? 0.0 : power[l];
    choice->power[NPH_TPM_SUN] = sun;
    choice->power[NPH_TPM_SKY] = sky;
    int64_t all = (int64_t)nph_floor(job->knobs[NPH_TPM_KNOB_PHOTONS] / (double)choice->generations + 0.5);
    int64_t of_sun = sun > 0.0 ? (int64_t)nph_floor((double)all * (sun / (sun + sky)) + 0.5) : 0;
    all = all > 1 ? all : 1;
    if (sun > 0.0 && of_sun < 1) of_sun = 1;
    if (sky > 0.0 && of_sun >= all) of_sun = all > 1 ? all - 1 : 1;
    choice->photons[NPH_TPM_SUN] = of_sun;
    choice->photons[NPH_TPM_SKY] = sky > 0.0 ? (all > of_sun ? all - of_sun : 1) : 0;
    choice->traced = sun + sky > 0.0;
}

/* 2^62 units hold what all photons deposit when each leaves 2^18 times its flux in one cell. */
static int scale_of(const NphTpmChoice *choice) {
    int64_t photons = (choice->photons[0] + choice->photons[1]) * choice->generations;
    int bits = 0;
    while (photons >> bits > 0) bits++;
    return 62 - 18 - bits;
}

/* Of the job's scene by itself. */
static NphStatus choose_still(const NphJob *job, NphTpmChoice *choice) {
    const NphScene *scene = job->scene;
    NphTpmChoice made = {.medium = -1, .dominant = -1, .cells = {1, 1, 1}, .fine = {1, 1, 1}, .shared = 1};
    nph_transport_choose(scene, job->plan_full, &made.transport);
    NPH_TRY(refuse(job, &made));
    for (int m = 0; m < scene->medium_count; m++) made.medium = made.transport.used[m] ? m : made.medium;
    int64_t wanted = (int64_t)job->knobs[NPH_TPM_KNOB_GENERATIONS];
    int primed = job->knobs[NPH_TPM_KNOB_PRIMED] > 0.5;
    int64_t frame = nph_scene_is_animated(scene) ? (int64_t)scene->frame : (int64_t)job->frame;
    made.generations = (int)(primed || frame + 1 > wanted ? wanted : frame + 1);
    made.first = 1 - made.generations;
    if (made.medium < 0) {
        *choice = made;
        return NPH_OK;
    }
    NPH_TRY(choose_grids(job, &made));
    const NphMedium *medium = &scene->media[made.medium];
    int dense = medium->shape != NPH_SHAPE_GRID || medium->grid.max > 0.0f;
    if (dense && made.transport.scatters) choose_lights(job, &made);
    int grey = medium->albedo[0] == medium->albedo[1] && medium->albedo[0] == medium->albedo[2];
    int hg = medium->phase.kind == NPH_PHASE_HG && (medium->phase.g[0] > 0.0 || medium->phase.g[0] < 0.0);
    made.similarity = grey && hg && job->knobs[NPH_TPM_KNOB_SIMILARITY] > 0.0;
    made.scale = scale_of(&made);
    *choice = made;
    return NPH_OK;
}

NphStatus nph_tpm_reference(const NphJob *job, NphScene **scene) {
    uint32_t frame = (uint32_t)job->knobs[NPH_TPM_KNOB_REFERENCE];
    *scene = NULL;
    if (!nph_scene_is_animated(job->scene) || job->scene->frame == frame) return NPH_OK;
    return nph_scene_at_frame(job->context, job->scene, frame, scene);
}

NphStatus nph_tpm_choose_like(const NphJob *job, const NphTpmChoice *reference, NphTpmChoice *choice) {
    NPH_TRY(choose_still(job, choice));
    memcpy(choice->cells, reference->cells, sizeof choice->cells);
    choice->shared = reference->shared;
    choice->scale = reference->scale;
    choice->animated = 1;
    for (int k = 0; k < NPH_TPM_KINDS; k++) choice->photons[k] = reference->photons[k];
    return NPH_OK;
}

/* What has no photons in the reference frame is weighed as all that shines there. */
static NphStatus choose_animated(const NphJob *job, NphTpmChoice *choice, NphTpmChoice *reference) {
    NphScene *scene = NULL;
    NPH_TRY(nph_tpm_reference(job, &scene));
    NphJob of = *job;
    if (scene) of.scene = scene;
    NphStatus status = choose_still(&of, reference);
    if (status == NPH_OK && !reference->traced)
        status = nph_error(job->context, NPH_BAD_USAGE,
                           "temporal_photons: at frame %.0f nothing shines or nothing scatters, so photons cannot be weighed; tpm.reference "
                           "takes the number of a frame at which something does", job->knobs[NPH_TPM_KNOB_REFERENCE]);
    for (int k = 0; k < NPH_TPM_KINDS && status == NPH_OK; k++) {
        int other = k == NPH_TPM_SUN ? NPH_TPM_SKY : NPH_TPM_SUN;
        if (reference->power[k] > 0.0) continue;
        reference->power[k] = reference->power[other];
        reference->photons[k] = reference->photons[other];
    }
    if (status == NPH_OK) status = nph_tpm_choose_like(job, reference, choice);
    nph_scene_free(job->context, scene);
    return status;
}

NphStatus nph_tpm_choose(const NphJob *job, NphTpmChoice *choice, NphTpmChoice *reference) {
    NphTpmChoice made, of;
    if (nph_scene_is_animated(job->scene)) NPH_TRY(choose_animated(job, &made, &of));
    else {
        NPH_TRY(choose_still(job, &made));
        of = made;
    }
    if (reference) *reference = of;
    *choice = made;
    return NPH_OK;
}

void nph_tpm_generation(const NphTpmChoice *reference, const NphTpmChoice *of, double vary, int64_t number, NphTpmGeneration *out) {
    NphWords words = nph_philox(0, (uint32_t)NPH_RNG_TPM_VARY << 24, (uint32_t)number, 0, 0, 0);
    double factor = 1.0 + vary * (2.0 * nph_uniform(words.w0) - 1.0);
    for (int k = 0; k < NPH_TPM_KINDS; k++) {
        double n = (double)reference->photons[k], bright = of->traced && n > 0.0 ? of->power[k] / reference->power[k] : 0.0;
        int64_t photons = (int64_t)nph_floor(n * bright * factor + 0.5);
        out->photons[k] = bright > 0.0 ? (photons > 1 ? photons : 1) : 0;
        out->relative[k] = bright > 0.0 ? 1.0 / bright : 0.0;
        out->share[k] = bright > 0.0 ? (double)out->photons[k] / bright : n;
    }
}

void nph_tpm_small(const NphJob *job, int origin[2], int size[2]) {
    const int whole[2] = {job->scene->sensor.width, job->scene->sensor.height};
    int all = job->knobs[NPH_TPM_KNOB_IMPOSTORS] > 0.5;
    for (int a = 0; a < 2; a++) {
        int first = all ? 0 : job->crop[a], end = all ? whole[a] : job->crop[2 + a];
        if (job->knobs[NPH_TPM_KNOB_HALF] > 0.5) {
            int most = (whole[a] + 1) / 2;
            first = first / 2 > 0 ? first / 2 - 1 : 0;
            end = (end + 1) / 2 < most ? (end + 1) / 2 + 1 : most;
        }
        origin[a] = first;
        size[a] = end - first;
    }
}

static NphStatus plan_buffers(const NphJob *job, const NphTpmChoice *choice, NphPlan *plan) {
    NphContext *context = job->context;
    const NphScene *scene = job->scene;
    uint64_t threads = (uint64_t)nph_context_threads(context), real = job->precision == 32 ? 4 : 8;
    uint64_t cells = (uint64_t)nph_tpm_cells(choice->cells), fine = (uint64_t)nph_tpm_cells(choice->fine);
    int origin[2], small[2];
    NphTpmKernels kernels;
    nph_tpm_kernels(job->precision, NPH_ISA_BASE, &kernels);
    nph_tpm_small(job, origin, small);
    NPH_TRY(nph_plan_add(context, plan, "buffer", "tpm.partial", (threads + 2) * NPH_TPM_KINDS * cells * NPH_TPM_VALUES * 8,
                         "H, of every worker too, and I: %d x %d x %d cells, 64-bit fixed point", (int)choice->cells[0],
                         (int)choice->cells[1], (int)choice->cells[2]));
    if (choice->animated)
        NPH_TRY(nph_plan_add(context, plan, "buffer", "scenes of other frames", 2 * kernels.scene_bytes(0) + 2 * nph_grid_bytes(&scene->media[choice->medium < 0 ? 0 : choice->medium].grid),
                             "the reference frame's and a generation's, with a density as large as this frame's"));
    if (job->sequence)
        NPH_TRY(nph_plan_add(context, plan, "buffer", "tpm.old", nph_tpm_carry_bytes(job, choice), "H of the last %d generations of %lld samples, and their I",
                             (int)job->knobs[NPH_TPM_KNOB_GENERATIONS], (long long)(job->sample_end - job->sample_begin)));
    NPH_TRY(nph_plan_add(context, plan, "buffer", "block scratch", threads * kernels.trace_bytes((int64_t)cells, choice->shared),
                         choice->shared ? "lanes, and a block's own grid" : "lanes; the grid is too large for a block's own"));
    NPH_TRY(nph_plan_add(context, plan, "buffer", "tpm.coarse", cells * NPH_TPM_FIELDS * real, "I resolved"));
    NPH_TRY(nph_plan_add(context, plan, "buffer", "tpm.fine", fine * NPH_TPM_FIELDS * real, "J: %d x %d x %d cells",
                         (int)choice->fine[0], (int)choice->fine[1], (int)choice->fine[2]));
    NPH_TRY(nph_plan_add(context, plan, "buffer", "guide", fine * (real + 1), "densities that guide the upsampling"));
    NPH_TRY(nph_plan_add(context, plan, "buffer", "tpm.picture", (uint64_t)small[0] * (uint64_t)small[1] * NPH_SAMPLE_FIELDS * real,
                         "%d x %d pixels that are marched", small[0], small[1]));
    uint64_t pixels = (uint64_t)(job->crop[2] - job->crop[0]) * (uint64_t)(job->crop[3] - job->crop[1]);
    NPH_TRY(nph_plan_add(context, plan, "buffer", "tpm.image", (pixels + NPH_TILE_PIXELS) * NPH_SAMPLE_FIELDS * NPH_CHUNK * real,
                         "%d samples of every pixel, and of a tile", NPH_CHUNK));
    NPH_TRY(nph_plan_add(context, plan, "buffer", "film scratch", nph_film_scratch_bytes(choice->transport.film_channels), "one"));
    uint64_t regions = nph_film_forecast_shared_bytes(scene->sensor.width, scene->sensor.height, job->crop,
                                                      choice->transport.film_channels, job->sample_begin, job->sample_end);
    return nph_plan_add(context, plan, "buffer", "film.node",
                        regions + nph_film_forecast_bytes(scene->sensor.width, scene->sensor.height, job->crop,
                                                          choice->transport.film_channels, job->sample_begin, job->sample_end),
                        "moments of tiles and %d x %d pixels", job->crop[2] - job->crop[0], job->crop[3] - job->crop[1]);
}

static NphStatus plan_left_out(const NphJob *job, const NphTpmChoice *choice, NphPlan *plan) {
    NphContext *context = job->context;
    const double *knobs = job->knobs;
    if (!choice->traced)
        NPH_TRY(nph_plan_add(context, plan, "left out", "photons", 0, "nothing scatters, or there is no light"));
    if (!choice->similarity)
        NPH_TRY(nph_plan_add(context, plan, "left out", "similarity", 0, "%s",
                             knobs[NPH_TPM_KNOB_SIMILARITY] > 0.0 ? "g is 0, or the albedo differs between channels, whose reduced extinctions would too"
                                                                  : "its threshold is 0"));
    if (!(knobs[NPH_TPM_KNOB_NOISE] > 0.0) || knobs[NPH_TPM_KNOB_OCTAVES] < 1.0)
        NPH_TRY(nph_plan_add(context, plan, "left out", "noise", 0, "its size is 0"));
    if (choice->dominant < 0) NPH_TRY(nph_plan_add(context, plan, "left out", "lobe of the sun", 0, "there is no sun"));
    return NPH_OK;
}

NphStatus nph_tpm_plan(const NphJob *job, NphPlan *plan) {
    NphContext *context = job->context;
    NphTpmChoice choice;
    NPH_TRY(nph_tpm_choose(job, &choice, NULL));
    for (int s = 0; s < nph_temporal_photons.stage_count; s++) {
        const NphStage *stage = &nph_tpm_stages[s];
        NPH_TRY(nph_plan_add(context, plan, "stage", stage->name, 0, "%s; blocks of %d", stage->source, stage->block[0]));
    }
    NPH_TRY(plan_left_out(job, &choice, plan));
    NPH_TRY(nph_transport_plan(context, job->scene, &choice.transport, plan));
    return plan_buffers(job, &choice, plan);
}
