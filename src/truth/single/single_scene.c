/* SPDX-License-Identifier: Apache-2.0
 *
 * What the marcher needs of a scene: chosen once for plan, run and replay, and turned into scene-local space. */
#include "core/message.h"
#include "pipeline/plan.h"
#include "transport/prepare_lookup.h"
#include "truth/single/single.h"

static int only_layer(const NphScene *scene, const NphTransportChoice *choice) {
    int used = 0, layers = 0;
    for (int m = 0; m < scene->medium_count; m++) {
        used += choice->used[m];
        layers += choice->used[m] && scene->media[m].shape == NPH_SHAPE_LAYER;
    }
    return used == 1 && layers == 1;
}

static int is_black(const double value[3]) { return value[0] == 0.0 && value[1] == 0.0 && value[2] == 0.0; }

void nph_single_choose(const NphJob *job, NphSingleChoice *choice) {
    const NphScene *scene = job->scene;
    int blinn = (int)job->knobs[NPH_SINGLE_KNOB_MODE] == NPH_SINGLE_BLINN;
    nph_transport_choose(scene, job->plan_full, &choice->transport);
    int media = 0;
    for (int m = 0; m < scene->medium_count; m++) media += choice->transport.used[m];
    choice->layer = only_layer(scene, &choice->transport) && scene->surface_count == 0;
    for (int l = 0; l < scene->light_count; l++) {
        const NphLight *light = &scene->lights[l];
        int lit = light->kind == NPH_LIGHT_CONSTANT ? job->plan_full || !is_black(light->radiance)
                                                    : choice->transport.sampled[l];
        if (blinn && light->kind != NPH_LIGHT_SUN) lit = 0;
        choice->scattered[l] = lit && media > 0 && choice->transport.scatters;
        choice->reflected[l] = lit && choice->transport.reflects;
    }
}

int nph_single_fields(const NphScene *scene) {
    int fields = scene->medium_count;
    for (int m = 0; m < scene->medium_count; m++) fields += scene->media[m].emission.kind != NPH_EMISSION_NONE ? 3 : 0;
    return fields;
}

/* A grid that all channels share is one glow, one of its own for each channel three. They have no extinction: that of
 * their medium is counted there. */
static void prepare_glows(NphSingleScene *scene) {
    RScene *local = &scene->local;
    scene->fields = local->medium_count;
    for (int e = 0; e < local->emitter_count; e++) {
        const REmitter *emitter = &local->emitters[e];
        int parts = emitter->field.shape == NPH_SHAPE_GRID && emitter->grids > 1 ? 3 : 1;
        for (int i = 0; i < parts; i++) {
            int at = scene->fields++ - local->medium_count;
            RMedium *glow = &scene->glow[at];
            *glow = emitter->field;
            if (glow->shape == NPH_SHAPE_GRID) glow->grid = emitter->grid[i];
            for (int c = 0; c < 3; c++) {
                glow->sigma[c] = 0.0;
                scene->glow_value[at][c] = parts == 1 || c == i ? emitter->value[c] : 0.0;
            }
        }
    }
}

static void prepare_group(const NphJob *job, const NphSingleChoice *choice, int group, NphSingleScene *scene) {
    scene->choice = *choice;
    r_prepare_scene(job->scene, &choice->transport, job->seed, job->frame, &scene->local);
    if (nph_scene_is_spectral(job->scene)) r_take_group(job->scene, group, &scene->local);
    prepare_glows(scene);
    scene->tolerance = job->knobs[NPH_SINGLE_KNOB_TOLERANCE];
    scene->panels = (int)job->knobs[NPH_SINGLE_KNOB_PANELS];
    scene->mode = (int)job->knobs[NPH_SINGLE_KNOB_MODE];
    for (int l = 0; l < job->scene->light_count; l++) {
        double sine = nph_sin(job->scene->lights[l].half_angle_rad);
        double spread = scene->local.lights[l].disc.width > 0.0 ? 3.14159265358979323846 * sine * sine : 1.0;
        for (int c = 0; c < 3; c++) scene->beam[l][c] = scene->local.lights[l].value[c] * spread;
    }
}

int nph_single_groups(const NphJob *job) {
    NphSingleChoice choice;
    nph_single_choose(job, &choice);
    return choice.transport.groups;
}

void nph_single_prepare(const NphJob *job, NphSingleScene *scenes) {
    NphSingleChoice choice;
    nph_single_choose(job, &choice);
    for (int g = 0; g < choice.transport.groups; g++) prepare_group(job, &choice, g, &scenes[g]);
}

/* What the method leaves out by its nature, where the scene has it. */
static NphStatus plan_missing(const NphJob *job, const NphSingleChoice *choice, NphPlan *plan) {
    NphContext *context = job->context;
    const NphScene *scene = job->scene;
    int blinn = (int)job->knobs[NPH_SINGLE_KNOB_MODE] == NPH_SINGLE_BLINN;
    for (int m = 0; m < scene->medium_count; m++) {
        const double *albedo = scene->media[m].albedo;
        double most = albedo[0] > albedo[1] ? albedo[0] : albedo[1];
        most = albedo[2] > most ? albedo[2] : most;
        if (choice->transport.used[m] && most > 0.3)
            NPH_TRY(nph_plan_add(context, plan, "warning", scene->media[m].name, 0,
                                 "albedo %g: light scattered twice or more is missing, and counts above 0.3", most));
    }
    for (int m = 0; m < scene->medium_count; m++)
        if (scene->media[m].emission.kind != NPH_EMISSION_NONE &&
            choice->transport.scatters + choice->transport.reflects > 0)
            NPH_TRY(nph_plan_add(context, plan, "left out", scene->media[m].name, 0,
                                 "as a light: what it emits is seen, not scattered"));
    for (int l = 0; l < scene->light_count; l++) {
        if (choice->scattered[l]) continue;
        if (blinn && scene->lights[l].kind != NPH_LIGHT_SUN)
            NPH_TRY(nph_plan_add(context, plan, "left out", scene->lights[l].name, 0,
                                 "as light on media: Blinn's mode knows suns alone"));
    }
    if (blinn && choice->layer)
        NPH_TRY(nph_plan_add(context, plan, "left out", "quadrature", 0, "the medium is one layer: closed form"));
    return NPH_OK;
}

NphStatus nph_single_plan(const NphJob *job, NphPlan *plan) {
    NphContext *context = job->context;
    NphSingleChoice choice;
    nph_single_choose(job, &choice);
    for (int s = 0; s < nph_single.stage_count; s++) {
        const NphStage *stage = &nph_single.stages[s];
        NPH_TRY(
            nph_plan_add(context, plan, "stage", stage->name, 0, "%s; blocks of %d", stage->source, stage->block[0]));
    }
    NPH_TRY(nph_transport_plan(context, job->scene, &choice.transport, plan));
    NPH_TRY(plan_missing(job, &choice, plan));
    uint64_t threads = (uint64_t)nph_context_threads(context);
    uint64_t batch = nph_single_batch_doubles(job->scene) * sizeof(double) +
                     NPH_SINGLE_BATCH * (NPH_SAMPLE_FIELDS * sizeof(double) + sizeof(int32_t));
    uint64_t scratch = nph_single_scratch_bytes(nph_single_fields(job->scene)) +
                       nph_film_scratch_bytes(choice.transport.film_channels);
    NPH_TRY(nph_plan_add(context, plan, "memory", "scene", (uint64_t)choice.transport.groups * sizeof(NphSingleScene),
                         "in scene-local space, f64"));
    NPH_TRY(nph_plan_add(context, plan, "memory", "batches", threads * batch, "%d rays each, one a thread",
                         NPH_SINGLE_BATCH));
    NPH_TRY(
        nph_plan_add(context, plan, "memory", "scratch", threads * scratch, "pieces of the ray, panels, film scratch"));
    return nph_plan_add(context, plan, "memory", "film",
                        nph_film_forecast_bytes(job->scene->sensor.width, job->scene->sensor.height, job->crop,
                                                choice.transport.film_channels, job->sample_begin, job->sample_end),
                        "moments of every pixel");
}
