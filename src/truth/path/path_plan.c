/* SPDX-License-Identifier: Apache-2.0
 *
 * Only what the scene requires: one channel when everything is grey, no sample of a black light, no medium without extinction, no scattering where every albedo is 0. --plan full leaves nothing out. */
#include "truth/path/path_plan.h"

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

static double luminance(const double c[3]) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; }

/* The brightest sun, where a phase function has a peak that could meet it. */
static void choose_guide(const NphJob *job, NphPathChoice *choice) {
    const NphScene *scene = job->scene;
    double brightest = 0.0;
    int peaks = 0, grids = 0;
    choice->guide = -1;
    for (int m = 0; m < scene->medium_count; m++) {
        NphPhaseKind kind = scene->media[m].phase.kind;
        peaks |= choice->used[m] && (kind == NPH_PHASE_HG || kind == NPH_PHASE_TWO_LOBE);
        grids |= choice->used[m] && scene->media[m].shape == NPH_SHAPE_GRID;
    }
    for (int l = 0; l < scene->light_count; l++) {
        const NphLight *light = &scene->lights[l];
        double bright = choice->sampled[l] && light->kind == NPH_LIGHT_SUN ? luminance(light->irradiance) : 0.0;
        if (!(bright > brightest) || !peaks || !(job->knobs[NPH_PATH_KNOB_TOWARDS_SUN] > 0.0)) continue;
        brightest = bright;
        choice->guide = l;
    }
    choice->guide_part = job->knobs[NPH_PATH_KNOB_TOWARDS_SUN];
    choice->least_light = grids ? job->knobs[NPH_PATH_KNOB_LEAST_LIGHT] : 0.0;
}

void nph_path_choose(const NphJob *job, NphPathChoice *choice) {
    const NphScene *scene = job->scene;
    int used = 0, sampled = 0;
    *choice = (NphPathChoice){.channels = 1, .film_channels = 1};
    for (int m = 0; m < scene->medium_count; m++) {
        const NphMedium *medium = &scene->media[m];
        choice->used[m] = job->plan_full || !medium_is_empty(medium);
        if (!choice->used[m]) continue;
        used++;
        if (!is_grey(medium->extinction_per_m) || !is_grey(medium->albedo)) choice->channels = 3;
        if (!is_black(medium->albedo)) choice->scatters = 1;
    }
    if (job->plan_full) {
        choice->channels = 3;
        choice->scatters = 1;
    }
    choice->film_channels = choice->channels;
    for (int l = 0; l < scene->light_count; l++) {
        const NphLight *light = &scene->lights[l];
        if (!light_is_grey(light)) choice->film_channels = 3;
        choice->sampled[l] = light->kind != NPH_LIGHT_CONSTANT && (job->plan_full || !light_is_black(light));
        sampled += choice->sampled[l];
    }
    /* A flight is weighed up to where it ends: with several media that is not known when the first one is flown. */
    if (used == 1 && sampled == 0 && choice->channels == 1) choice->weighed = job->knobs[NPH_PATH_KNOB_WEIGHED];
    choose_guide(job, choice);
}

static NphStatus plan_omissions(const NphJob *job, const NphPathChoice *choice, NphPlan *plan) {
    NphContext *context = job->context;
    const NphScene *scene = job->scene;
    if (choice->film_channels == 1)
        NPH_TRY(nph_plan_add(context, plan, "left out", "channels", 0, "2 of 3: media and lights are grey"));
    else if (choice->channels == 1)
        NPH_TRY(nph_plan_add(context, plan, "left out", "transport channels", 0,
                             "2 of 3: media are grey, only the lights have a colour"));
    for (int m = 0; m < scene->medium_count; m++)
        if (!choice->used[m])
            NPH_TRY(nph_plan_add(context, plan, "left out", scene->media[m].name, 0, "medium: it has no extinction"));
    for (int m = 0; m < scene->medium_count; m++)
        if (choice->used[m] && scene->media[m].shape != NPH_SHAPE_GRID)
            NPH_TRY(nph_plan_add(context, plan, "left out", "tracking", 0,
                                 "in %s: it is homogeneous, flights and transmittances are closed forms",
                                 scene->media[m].name));
    if (choice->weighed > 0.0)
        NPH_TRY(nph_plan_add(context, plan, "left out", "collisions", 0,
                             "those that absorb: flights are weighed instead, no light is sampled at vertices"));
    if (!choice->scatters)
        NPH_TRY(nph_plan_add(context, plan, "left out", "path.shadow", 0, "at collisions: every albedo is 0"));
    for (int l = 0; l < scene->light_count; l++)
        if (!choice->sampled[l] && scene->lights[l].kind != NPH_LIGHT_CONSTANT)
            NPH_TRY(nph_plan_add(context, plan, "left out", "light sample", 0, "of %s: it is black", scene->lights[l].name));
    if (scene->light_count == 0)
        NPH_TRY(nph_plan_add(context, plan, "warning", "lights", 0, "there are none: the picture will be black"));
    return NPH_OK;
}

NphStatus nph_path_plan(const NphJob *job, NphPlan *plan) {
    NphContext *context = job->context;
    const NphScene *scene = job->scene;
    NphPathChoice choice;
    NphPathKernels kernels;
    nph_path_choose(job, &choice);
    nph_path_kernels(nph_context_isa(context), job->precision, &kernels);
    for (int s = 0; s < nph_path.stage_count; s++) {
        const NphStage *stage = &nph_path.stages[s];
        NPH_TRY(nph_plan_add(context, plan, "stage", stage->name, 0, "%s; blocks of %d", stage->source, stage->block[0]));
    }
    NPH_TRY(plan_omissions(job, &choice, plan));
    for (int m = 0; m < scene->medium_count; m++)
        if (scene->media[m].shape == NPH_SHAPE_GRID)
            NPH_TRY(nph_plan_add(context, plan, "memory", scene->media[m].name, nph_grid_bytes(&scene->media[m].grid),
                                 "bricks and majorants of the density"));
    for (int l = 0; l < scene->light_count; l++)
        if (scene->lights[l].kind == NPH_LIGHT_ENVIRONMENT) {
            uint64_t texels = (uint64_t)scene->lights[l].map.width * (uint64_t)scene->lights[l].map.height;
            NPH_TRY(nph_plan_add(context, plan, "memory", scene->lights[l].name, texels * 20, "environment and its tables"));
        }
    uint64_t threads = (uint64_t)nph_context_threads(context);
    NPH_TRY(nph_plan_add(context, plan, "buffer", "path.*", threads * kernels.batch_bytes(),
                         "%llu batches of %d paths, one a thread", (unsigned long long)threads, NPH_PATH_BATCH));
    NPH_TRY(nph_plan_add(context, plan, "buffer", "film scratch", threads * nph_film_scratch_bytes(choice.film_channels),
                         "one a thread"));
    return nph_plan_add(context, plan, "buffer", "film.node",
                        nph_film_forecast_bytes(scene->sensor.width, scene->sensor.height, job->crop,
                                                choice.film_channels, job->sample_begin, job->sample_end),
                        "moments of %d x %d pixels", job->crop[2] - job->crop[0], job->crop[3] - job->crop[1]);
}
