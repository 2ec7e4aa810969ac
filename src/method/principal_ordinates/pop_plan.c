/* SPDX-License-Identifier: Apache-2.0
 *
 * What principal ordinates do for a scene, what they leave out, and what they refuse. */
#include <string.h>

#include "core/message.h"
#include "method/principal_ordinates/pop.h"
#include "pipeline/plan.h"

static NphStatus refuse(const NphJob *job, const NphTransportChoice *transport) {
    const NphScene *scene = job->scene;
    int used = 0;
    NPH_TRY(nph_transport_refuse_air(job->context, scene, "principal_ordinates"));
    if (scene->period.on[0] || scene->period.on[1])
        return nph_error(job->context, NPH_BAD_SCENE, "principal_ordinates: sides that repeat are not part of this method; path has them");
    if (nph_sensor_gathers(scene->sensor.kind))
        return nph_error(job->context, NPH_BAD_SCENE, "principal_ordinates: what its grids show belongs to one observer; a sensor that gathers from many "
                         "directions needs path");
    for (int m = 0; m < scene->medium_count; m++) {
        const NphMedium *medium = &scene->media[m];
        if (!transport->used[m]) continue;
        if (used++)
            return nph_error(job->context, NPH_BAD_SCENE, "principal_ordinates: medium %s is the second; the method knows one", medium->name);
        if (medium->shape == NPH_SHAPE_LAYER)
            return nph_error(job->context, NPH_BAD_SCENE, "principal_ordinates: medium %s is a layer without end; a box has one", medium->name);
        if (medium->emission.kind != NPH_EMISSION_NONE)
            return nph_error(job->context, NPH_BAD_SCENE, "principal_ordinates: medium %s emits light, which this method does not follow", medium->name);
    }
    if (scene->surface_count > 0 && used == 0)
        return nph_error(job->context, NPH_BAD_SCENE, "principal_ordinates: surface %s: surfaces are lit where there is a medium; path has them alone",
                         scene->surfaces[0].name);
    return NPH_OK;
}

/* Edges of the medium's box [m]. */
static void edges_of(const NphMedium *medium, double edges[3]) {
    const double *m = medium->world_from_medium;
    int grid = medium->shape == NPH_SHAPE_GRID;
    for (int a = 0; a < 3; a++) {
        double size = grid ? medium->grid.hi[a] - medium->grid.lo[a] : medium->hi[a] - medium->lo[a];
        edges[a] = size * nph_sqrt(m[a] * m[a] + m[4 + a] * m[4 + a] + m[8 + a] * m[8 + a]);
    }
}

/* Cells along the medium, near to cubes: the edge of those that `most` along its mean edge would have. */
static void choose_box(const double edges[3], double most, int32_t cells[3]) {
    double mean = nph_exp(nph_log(edges[0] * edges[1] * edges[2]) / 3.0), longest = 0.0;
    for (int a = 0; a < 3; a++) longest = edges[a] > longest ? edges[a] : longest;
    double edge = mean / most > longest / 1024.0 ? mean / most : longest / 1024.0;
    for (int a = 0; a < 3; a++) {
        double count = nph_floor(edges[a] / edge + 0.5);
        cells[a] = count > 1.0 ? (int32_t)count : 1;
    }
}

/* The largest voxels that are not larger than the grids' cells. */
static void choose_level(const NphJob *job, const double edges[3], NphPopChoice *choice) {
    const NphMedium *medium = &job->scene->media[choice->medium];
    double diagonal = nph_sqrt(edges[0] * edges[0] + edges[1] * edges[1] + edges[2] * edges[2]);
    double cell = diagonal / 1.7320508075688772 / job->knobs[NPH_POP_KNOB_CELLS];
    choice->level = 0;
    for (int a = 0; a < 3; a++) choice->mips[a] = 1;
    choice->mean_density = 1.0;
    if (medium->shape != NPH_SHAPE_GRID) return;
    double voxel = 0.0, voxels = 1.0;
    for (int a = 0; a < 3; a++) {
        double size = edges[a] / (medium->grid.hi[a] - medium->grid.lo[a]);
        voxel = size > voxel ? size : voxel;
        voxels *= (double)(medium->grid.n[a] - 2);
    }
    while (job->knobs[NPH_POP_KNOB_MIPS] > 0.5 && choice->level < 12 && voxel * (double)(2 << choice->level) <= cell) choice->level++;
    for (int a = 0; a < 3; a++) choice->mips[a] = (medium->grid.n[a] - 2 + (1 << choice->level) - 1) >> choice->level;
    choice->mean_density = medium->grid.sum / voxels;
}

static int shines(const NphLight *light) {
    const double *value = light->kind == NPH_LIGHT_SUN ? light->irradiance : light->kind == NPH_LIGHT_POINT ? light->intensity : light->radiance;
    if (light->kind == NPH_LIGHT_ENVIRONMENT) return light->map.total > 0.0;
    return value[0] + value[1] + value[2] > 0.0;
}

static void choose_lights(const NphJob *job, NphPopChoice *choice) {
    int skies = 0;
    for (int l = 0; l < job->scene->light_count; l++) {
        const NphLight *light = &job->scene->lights[l];
        if (!shines(light)) continue;
        choice->suns += light->kind == NPH_LIGHT_SUN;
        choice->points += light->kind == NPH_LIGHT_POINT;
        skies += light->kind == NPH_LIGHT_ENVIRONMENT || light->kind == NPH_LIGHT_CONSTANT;
    }
    int ordinates = (int)job->knobs[NPH_POP_KNOB_ORDINATES];
    choice->sky = skies == 0 ? 0 : ordinates > skies ? ordinates : skies;
}

/* Surfaces shade the grids, and send light of their own where they reflect any. */
static void choose_surfaces(const NphJob *job, NphPopChoice *choice) {
    if (job->scene->surface_count == 0 || nph_pop_lamps(choice) == 0) return;
    choice->rsm = (int)job->knobs[NPH_POP_KNOB_RSM];
    choice->shadows = (int)job->knobs[NPH_POP_KNOB_SHADOWS];
    choice->vpls = choice->transport.reflects ? (int)job->knobs[NPH_POP_KNOB_VPLS] : 0;
}

/* Whether its channels differ. */
static int is_coloured(const NphMedium *medium) {
    const double *extinction = medium->extinction_per_m, *albedo = medium->albedo;
    return extinction[0] != extinction[1] || extinction[0] != extinction[2] || albedo[0] != albedo[1] || albedo[0] != albedo[2];
}

NphStatus nph_pop_choose(const NphJob *job, NphPopChoice *choice) {
    const NphScene *scene = job->scene;
    const double *knobs = job->knobs;
    NphPopChoice made = {.medium = -1, .channels = 1};
    double edges[3];
    nph_transport_choose(scene, job->plan_full, &made.transport);
    NPH_TRY(refuse(job, &made.transport));
    for (int m = 0; m < scene->medium_count; m++) made.medium = made.transport.used[m] ? m : made.medium;
    for (int a = 0; a < 3; a++) made.flat[a] = made.radial[a] = made.vpl[a] = made.joined[a] = made.gathered[a] = made.merged[a] = made.fine[a] = made.mips[a] = 1;
    if (made.medium < 0) {
        *choice = made;
        return NPH_OK;
    }
    const NphMedium *medium = &scene->media[made.medium];
    edges_of(medium, edges);
    int across = (int)knobs[NPH_POP_KNOB_CELLS], along = (int)knobs[NPH_POP_KNOB_ALONG], radial = (int)knobs[NPH_POP_KNOB_RADIAL];
    int vpl = (int)knobs[NPH_POP_KNOB_VPL_CELLS];
    made.flat[0] = made.flat[1] = across;
    made.flat[2] = along > 0 ? along : across;
    made.radial[0] = made.radial[1] = 2 * ((radial + 1) / 2); /* even: every cell has one on the other side */
    made.radial[2] = radial;
    made.vpl[0] = made.vpl[1] = 2 * ((vpl + 1) / 2);
    made.vpl[2] = vpl;
    choose_box(edges, knobs[NPH_POP_KNOB_RESIDUUM_CELLS], made.joined);
    choose_box(edges, knobs[NPH_POP_KNOB_MERGED] * (double)across, made.merged);
    choose_box(edges, 2.0 * knobs[NPH_POP_KNOB_MERGED] * (double)vpl, made.gathered); /* shells are thinner near the point than in the mean */
    for (int a = 0; a < 3; a++) made.gathered[a] = made.gathered[a] < made.merged[a] ? made.gathered[a] : made.merged[a];
    choose_level(job, edges, &made);
    int guided = medium->shape == NPH_SHAPE_GRID && knobs[NPH_POP_KNOB_UPSAMPLING] > 0.5;
    for (int a = 0; a < 3; a++) made.fine[a] = guided ? medium->grid.n[a] - 2 : 1;
    int dense = medium->shape != NPH_SHAPE_GRID || medium->grid.max > 0.0f;
    if ((dense && made.transport.scatters) || scene->surface_count > 0) choose_lights(job, &made);
    choose_surfaces(job, &made);
    made.lit = nph_pop_grids(&made) > 0;
    made.channels = job->plan_full || made.transport.groups > 1 || is_coloured(medium) ? made.transport.channels : 1;
    made.importance = made.lit && made.sky > 0 && knobs[NPH_POP_KNOB_IMPORTANCE] > 0.5;
    made.residuum = made.lit && knobs[NPH_POP_KNOB_RESIDUUM] > 0.5;
    made.iterations = (int)knobs[NPH_POP_KNOB_ITERATIONS];
    int64_t cells = nph_pop_first(&made, nph_pop_grids(&made), made.channels);
    if (cells > (int64_t)1 << 31)
        return nph_error(job->context, NPH_BAD_USAGE, "principal_ordinates: %d grids of %d x %d x %d cells have %lld numbers; at most 2^31: fewer ordinates, or "
                         "fewer cells", nph_pop_grids(&made), (int)made.flat[0], (int)made.flat[1], (int)made.flat[2], (long long)cells);
    *choice = made;
    return NPH_OK;
}

static NphStatus plan_surfaces(const NphJob *job, const NphPopChoice *choice, NphPlan *plan) {
    NphContext *context = job->context;
    if (choice->shadows == 0) NPH_TRY(nph_plan_add(context, plan, "left out", "shadows", 0, "pop.shadows is 0: surfaces do not shade the medium"));
    if (choice->vpls == 0)
        NPH_TRY(nph_plan_add(context, plan, "left out", "virtual point lights", 0, "%s", choice->transport.reflects ? "pop.vpls is 0" : "no surface reflects"));
    return nph_plan_add(context, plan, "warning", "surfaces", 0, "get no light that the medium scatters, and send on once what lamps bring them; light that has "
                        "been scattered passes through them");
}

static NphStatus plan_left_out(const NphJob *job, const NphPopChoice *choice, NphPlan *plan) {
    NphContext *context = job->context;
    const double *knobs = job->knobs;
    if (!choice->lit) return nph_plan_add(context, plan, "left out", "grids", 0, "nothing scatters, or there is no light");
    const NphMedium *medium = &job->scene->media[choice->medium];
    if (choice->channels == 1 && choice->transport.film_channels == 3)
        NPH_TRY(nph_plan_add(context, plan, "left out", "channels", 0, "the medium is grey: one is propagated for three, and coloured by its ordinate"));
    if (choice->sky == 0) NPH_TRY(nph_plan_add(context, plan, "left out", "sampling of the sky", 0, "there is none beside suns"));
    if (!choice->importance)
        NPH_TRY(nph_plan_add(context, plan, "left out", "importance", 0, "%s", choice->sky == 0 ? "there is no sky to sample" : "pop.importance is 0"));
    if (choice->importance && knobs[NPH_POP_KNOB_FRAMES] > 1.5 && !nph_scene_is_animated(job->scene))
        NPH_TRY(nph_plan_add(context, plan, "left out", "mean over frames", 0, "the scene is the same at every frame"));
    if (!choice->residuum) NPH_TRY(nph_plan_add(context, plan, "left out", "residuum", 0, "pop.residuum is 0: light that is left after the iterations is lost"));
    if (choice->points == 0) NPH_TRY(nph_plan_add(context, plan, "left out", "radial grids", 0, "there are no points"));
    if (job->scene->surface_count == 0) NPH_TRY(nph_plan_add(context, plan, "left out", "shadows, virtual point lights", 0, "there are no surfaces"));
    else NPH_TRY(plan_surfaces(job, choice, plan));
    if (medium->shape != NPH_SHAPE_GRID) NPH_TRY(nph_plan_add(context, plan, "left out", "upsampling", 0, "the density is the same everywhere: nothing guides it"));
    else if (knobs[NPH_POP_KNOB_UPSAMPLING] < 0.5) NPH_TRY(nph_plan_add(context, plan, "left out", "upsampling", 0, "pop.upsampling is 0"));
    if (medium->phase.kind != NPH_PHASE_HG && medium->phase.kind != NPH_PHASE_ISOTROPIC)
        NPH_TRY(nph_plan_add(context, plan, "warning", medium->name, 0, "its phase function is replaced by that of Henyey and Greenstein with its mean cosine, %.4g",
                             nph_phase_mean_cosine(&medium->phase)));
    return nph_plan_add(context, plan, "warning", "Order.Y", 0, "stays 0: the method does not count scatterings");
}

static NphStatus plan_buffers(const NphJob *job, const NphPopChoice *choice, NphPlan *plan) {
    NphContext *context = job->context;
    const NphScene *scene = job->scene;
    uint64_t threads = (uint64_t)nph_context_threads(context), real = job->precision == 32 ? 4 : 8;
    NphPopKernels kernels;
    nph_pop_kernels(job->precision, NPH_ISA_BASE, &kernels);
    for (int b = 0; b < NPH_POP_B_SAMPLE; b++)
        NPH_TRY(nph_plan_add(context, plan, "buffer", nph_pop_buffers[b].name, nph_pop_buffer_bytes(choice, job->precision, (NphPopBuffer)b), "%s",
                             nph_pop_buffers[b].shape));
    NPH_TRY(nph_plan_add(context, plan, "buffer", "sums of the sky", sizeof(double) * (uint64_t)nph_pop_sky_texels(scene), "texels of the largest map"));
    NPH_TRY(nph_plan_add(context, plan, "buffer", "block scratch", threads * kernels.scratch_bytes(choice), "cells of a grid, and planes of what they send"));
    NPH_TRY(nph_plan_add(context, plan, "buffer", "pop.sample", threads * NPH_CHUNK * NPH_SAMPLE_FIELDS * NPH_TILE_PIXELS * real, "of a tile, a worker"));
    NPH_TRY(nph_plan_add(context, plan, "buffer", "film scratch", threads * nph_film_scratch_bytes(choice->transport.film_channels), "one a worker"));
    return nph_plan_add(context, plan, "buffer", "film.node",
                        nph_film_forecast_bytes(scene->sensor.width, scene->sensor.height, job->crop, choice->transport.film_channels, job->sample_begin,
                                                job->sample_end), "moments of %d x %d pixels", job->crop[2] - job->crop[0], job->crop[3] - job->crop[1]);
}

NphStatus nph_pop_plan(const NphJob *job, NphPlan *plan) {
    NphContext *context = job->context;
    NphPopChoice choice;
    NPH_TRY(nph_pop_choose(job, &choice));
    for (int s = 0; s < NPH_POP_STAGES; s++)
        NPH_TRY(nph_plan_add(context, plan, "stage", nph_pop_stages[s].name, 0, "%s; blocks of %d", nph_pop_stages[s].source, nph_pop_stages[s].block[0]));
    if (choice.lit)
        NPH_TRY(nph_plan_add(context, plan, "memory", "grids", 0, "%d of suns and %d of the sky, %d x %d x %d cells each; %d of points, %d x %d x %d; %d of "
                             "virtual point lights, %d x %d x %d", choice.suns, choice.sky, (int)choice.flat[0], (int)choice.flat[1], (int)choice.flat[2],
                             choice.points, (int)choice.radial[0], (int)choice.radial[1], (int)choice.radial[2], choice.vpls, (int)choice.vpl[0],
                             (int)choice.vpl[1], (int)choice.vpl[2]));
    if (choice.medium >= 0) NPH_TRY(plan_left_out(job, &choice, plan));
    NPH_TRY(nph_transport_plan(context, job->scene, &choice.transport, plan));
    return plan_buffers(job, &choice, plan);
}
