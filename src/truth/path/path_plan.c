/* SPDX-License-Identifier: Apache-2.0
 *
 * What the path tracer needs of a scene beyond transport/choice.h: weighed flights, and a sun to look for. */
#include "truth/path/path_plan.h"

#include "core/message.h"
#include "field/sample.h"
#include "pipeline/plan.h"

static double luminance(const double c[3]) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; }

/* Draine's and tables are taken for peaked from twice isotropic scattering on. */
static int has_peak(const NphPhase *phase) {
    if (phase->kind == NPH_PHASE_HG) return !(phase->g[0] <= 0.0 && phase->g[0] >= 0.0);
    if (phase->kind == NPH_PHASE_TWO_LOBE) return 1;
    int may = phase->kind == NPH_PHASE_DRAINE || phase->kind == NPH_PHASE_TABULATED;
    return may && nph_phase_peak(phase) > 0.15915494309189535;
}

/* The brightest sun, where a phase function has a peak that could meet it. */
static void choose_guide(const NphJob *job, NphPathChoice *choice) {
    const NphScene *scene = job->scene;
    double brightest = 0.0;
    int peaks = 0, grids = 0;
    choice->guide = -1;
    for (int m = 0; m < scene->medium_count; m++) {
        peaks |= choice->transport.used[m] && has_peak(&scene->media[m].phase);
        grids |= choice->transport.used[m] && scene->media[m].shape == NPH_SHAPE_GRID;
    }
    for (int l = 0; l < scene->light_count; l++) {
        const NphLight *light = &scene->lights[l];
        double bright = choice->transport.sampled[l] && light->kind == NPH_LIGHT_SUN ? luminance(light->irradiance) : 0.0;
        if (!(bright > brightest) || !peaks || !(job->knobs[NPH_PATH_KNOB_TOWARDS_SUN] > 0.0)) continue;
        brightest = bright;
        choice->guide = l;
    }
    choice->guide_part = job->knobs[NPH_PATH_KNOB_TOWARDS_SUN];
    choice->least_light = grids ? job->knobs[NPH_PATH_KNOB_LEAST_LIGHT] : 0.0;
}

static double density_at(const NphMedium *medium, const double p[3]) {
    double inverse[12], u[3];
    int grid = medium->shape == NPH_SHAPE_GRID;
    nph_affine_invert(medium->world_from_medium, inverse);
    for (int a = 0; a < 3; a++) {
        const double *row = inverse + 4 * a;
        u[a] = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
        if (u[a] < (grid ? medium->grid.lo : medium->lo)[a] || u[a] > (grid ? medium->grid.hi : medium->hi)[a]) return 0.0;
    }
    RGrid view;
    if (medium->shape == NPH_SHAPE_AIR) return nph_exp(-(u[2] > 0.0 ? u[2] : 0.0) / medium->scale_height_m); /* how near a light counts */
    if (!grid) return 1.0;
    nph_grid_view(&medium->grid, &view);
    return (double)r_grid_value(&view, u[0], u[1], u[2]);
}

/* The largest of the channels' extinctions at p, summed over media, and where there is none the largest anywhere. */
static double extinction_near(const NphScene *scene, const NphTransportChoice *choice, const double p[3]) {
    double here = 0.0, most = 0.0;
    for (int m = 0; m < scene->medium_count; m++) {
        const NphMedium *medium = &scene->media[m];
        double sigma = 0.0, densest = medium->shape == NPH_SHAPE_GRID ? (double)medium->grid.max : 1.0;
        for (int c = 0; c < 3; c++) sigma = medium->extinction_per_m[c] > sigma ? medium->extinction_per_m[c] : sigma;
        if (!choice->used[m]) continue;
        here += sigma * density_at(medium, p);
        most = sigma * densest > most ? sigma * densest : most;
    }
    return here > 0.0 ? here : most;
}

/* Whether p lies within `reach` of a medium that scatters: of its box in the world. */
static int is_near_media(const NphScene *scene, const NphTransportChoice *choice, const double p[3], double reach) {
    for (int m = 0; m < scene->medium_count; m++) {
        const double *albedo = scene->media[m].albedo;
        double lo[3], hi[3];
        int inside = choice->used[m] && albedo[0] + albedo[1] + albedo[2] > 0.0;
        nph_medium_bounds(&scene->media[m], lo, hi);
        for (int a = 0; a < 3; a++) inside &= p[a] >= lo[a] - reach && p[a] <= hi[a] + reach;
        if (inside) return 1;
    }
    return 0;
}

/* Point lights whose light is shared between collisions and flights (transport/near_lookup.h). */
static void choose_near(const NphJob *job, NphPathChoice *choice) {
    const NphScene *scene = job->scene;
    for (int l = 0; l < scene->light_count; l++) {
        const NphLight *light = &scene->lights[l];
        if (light->kind != NPH_LIGHT_POINT || !choice->transport.sampled[l]) continue;
        if (scene->period.on[0] || scene->period.on[1]) continue; /* it has images without end */
        double sigma = extinction_near(scene, &choice->transport, light->position);
        double reach = sigma > 0.0 ? job->knobs[NPH_PATH_KNOB_NEAR_LIGHT] / sigma : 0.0;
        choice->near_m[l] = is_near_media(scene, &choice->transport, light->position, reach) ? reach : 0.0;
        choice->near |= choice->near_m[l] > 0.0;
    }
}

/* Where light passes the one medium in a closed form, camera rays need not find out by chance whether they do. */
static void choose_forced(const NphJob *job, int used, NphPathChoice *choice) {
    const NphScene *scene = job->scene;
    int repeats = scene->period.on[0] || scene->period.on[1];
    if (used != 1 || choice->transport.channels > 1 || choice->transport.emission || choice->near || job->plan_full) return;
    if (scene->surface_count > 0) return;
    for (int m = 0; m < scene->medium_count; m++) {
        int shape = scene->media[m].shape;
        if (choice->transport.used[m] && shape != NPH_SHAPE_GRID && !(repeats && shape != NPH_SHAPE_LAYER))
            choice->forced = job->knobs[NPH_PATH_KNOB_FORCED] > 0.0;
    }
}

void nph_path_choose(const NphJob *job, NphPathChoice *choice) {
    const NphScene *scene = job->scene;
    int used = 0, sampled = 0;
    *choice = (NphPathChoice){.weighed = 0.0};
    nph_transport_choose(scene, job->plan_full, &choice->transport);
    for (int m = 0; m < scene->medium_count; m++) used += choice->transport.used[m];
    for (int l = 0; l < scene->light_count; l++) sampled += choice->transport.sampled[l];
    /* A flight is weighed up to where it ends: with several media that is not known when the first one is flown. Emission
     * asks how far it got with all of the extinction. */
    if (used == 1 && sampled == 0 && choice->transport.channels == 1 && !choice->transport.emission)
        choice->weighed = job->knobs[NPH_PATH_KNOB_WEIGHED];
    choose_guide(job, choice);
    choose_near(job, choice);
    choose_forced(job, used, choice);
}

static NphStatus plan_omissions(const NphJob *job, const NphPathChoice *choice, NphPlan *plan) {
    NphContext *context = job->context;
    if (choice->weighed > 0.0)
        NPH_TRY(nph_plan_add(context, plan, "left out", "collisions", 0,
                             "those that absorb: flights are weighed instead, no light is sampled at vertices"));
    if (choice->forced)
        NPH_TRY(nph_plan_add(context, plan, "left out", "chance", 0, "whether light from behind passes the medium: the part that does is known"));
    int grids = 0;
    for (int m = 0; m < job->scene->medium_count; m++) grids += choice->transport.used[m] && job->scene->media[m].shape == NPH_SHAPE_GRID;
    if (grids == 0) NPH_TRY(nph_plan_add(context, plan, "left out", "path.majorant", 0, "no medium is a grid"));
    if (!choice->transport.emission)
        NPH_TRY(nph_plan_add(context, plan, "left out", "path.emission", 0, "no medium emits"));
    if (!choice->near)
        NPH_TRY(nph_plan_add(context, plan, "left out", "path.near", 0, "no point light shines in a medium"));
    if (!choice->transport.scatters && !choice->transport.reflects)
        NPH_TRY(nph_plan_add(context, plan, "left out", "path.shadow", 0, "at vertices: every albedo is 0"));
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
    NPH_TRY(nph_transport_plan(context, scene, &choice.transport, plan));
    if (choice.transport.groups > 1)
        NPH_TRY(nph_plan_add(context, plan, "buffer", "groups of wavelengths", kernels.scene_bytes(choice.transport.groups),
                             "%d scenes for the kernels, of three wavelengths each", choice.transport.groups));
    uint64_t threads = (uint64_t)nph_context_threads(context);
    NPH_TRY(nph_plan_add(context, plan, "buffer", "path.*", threads * kernels.batch_bytes(),
                         "%llu batches of %d paths, one a thread", (unsigned long long)threads, NPH_PATH_BATCH));
    NPH_TRY(nph_plan_add(context, plan, "buffer", "film scratch", threads * nph_film_scratch_bytes(choice.transport.film_channels),
                         "one a thread"));
    return nph_plan_add(context, plan, "buffer", "film.node",
                        nph_film_forecast_bytes(scene->sensor.width, scene->sensor.height, job->crop,
                                                choice.transport.film_channels, job->sample_begin, job->sample_end),
                        "moments of %d x %d pixels", job->crop[2] - job->crop[0], job->crop[3] - job->crop[1]);
}
