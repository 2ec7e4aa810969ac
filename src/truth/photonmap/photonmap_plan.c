/* SPDX-License-Identifier: Apache-2.0
 *
 * What photon mapping does for a scene, what it leaves out, and what it refuses. */
#include "core/message.h"
#include "pipeline/plan.h"
#include "truth/photonmap/photonmap.h"

NphStatus nph_photonmap_choose(const NphJob *job, NphPhotonmapChoice *choice) {
    const NphScene *scene = job->scene;
    NphPhotonmapChoice made = {.traced = 0};
    nph_transport_choose(scene, job->plan_full, &made.transport);
    int used = 0, multiple = 0;
    NPH_TRY(nph_transport_refuse_air(job->context, scene, "photonmap"));
    if (scene->period.on[0] || scene->period.on[1])
        return nph_error(job->context, NPH_BAD_SCENE,
                         "photonmap: sides that repeat are not part of this method; path has them");
    if (scene->surface_count > 0)
        return nph_error(job->context, NPH_BAD_SCENE,
                         "photonmap: surface %s: surfaces are not part of this method; path has them",
                         scene->surfaces[0].name);
    for (int m = 0; m < scene->medium_count; m++) {
        if (scene->media[m].shape == NPH_SHAPE_LAYER)
            return nph_error(job->context, NPH_BAD_SCENE,
                             "photonmap: medium %s is a layer without end, which photons cannot fill; a box has an end",
                             scene->media[m].name);
        if (scene->media[m].emission.kind != NPH_EMISSION_NONE)
            return nph_error(job->context, NPH_BAD_SCENE,
                             "photonmap: medium %s emits light, which this method does not follow",
                             scene->media[m].name);
        used += made.transport.used[m];
        for (int c = 0; c < 3; c++) multiple |= made.transport.used[m] && scene->media[m].albedo[c] > 0.0;
    }
    made.traced = used > 0 && scene->light_count > 0 && (multiple || job->plan_full);
    made.room = made.traced ? (int64_t)job->knobs[NPH_PHOTONMAP_KNOB_PHOTONS] : 1;
    made.emitted = made.traced ? (int64_t)job->knobs[NPH_PHOTONMAP_KNOB_EMITTED] : 1;
    made.most = made.room * NPH_PHOTONMAP_EMITTED_PER_STORED;
    *choice = made;
    return NPH_OK;
}

static NphStatus plan_buffers(const NphJob *job, const NphPhotonmapChoice *choice, NphPlan *plan) {
    NphContext *context = job->context;
    const NphScene *scene = job->scene;
    uint64_t threads = (uint64_t)nph_context_threads(context), real = job->precision == 32 ? 4 : 8;
    NPH_TRY(nph_plan_add(context, plan, "buffer", "photonmap.photon",
                         nph_photonmap_map_bytes(job->precision, choice, threads),
                         "room for %lld photons, their tree, and counts of blocks", (long long)choice->room));
    if (job->tap)
        NPH_TRY(nph_plan_add(context, plan, "buffer", "photonmap.id", nph_photonmap_column_bytes(job->precision, choice->room),
                             "photons as others see them"));
    uint64_t pixels = (uint64_t)(job->crop[2] - job->crop[0]) * (uint64_t)(job->crop[3] - job->crop[1]);
    NPH_TRY(nph_plan_add(context, plan, "buffer", "photonmap.image", NPH_CHUNK * NPH_SAMPLE_FIELDS * pixels * real,
                         "%d samples of every pixel", NPH_CHUNK));
    NPH_TRY(nph_plan_add(context, plan, "buffer", "photonmap.sample", NPH_CHUNK * NPH_SAMPLE_FIELDS * NPH_TILE_PIXELS * real,
                         "those of a tile"));
    NPH_TRY(nph_plan_add(context, plan, "buffer", "film scratch",
                         nph_film_scratch_bytes(choice->transport.film_channels), "one"));
    uint64_t regions =
        nph_film_forecast_shared_bytes(scene->sensor.width, scene->sensor.height, job->crop,
                                       choice->transport.film_channels, job->sample_begin, job->sample_end);
    return nph_plan_add(
        context, plan, "buffer", "film.node",
        regions + nph_film_forecast_bytes(scene->sensor.width, scene->sensor.height, job->crop,
                                          choice->transport.film_channels, job->sample_begin, job->sample_end),
        "moments of tiles and %d x %d pixels", job->crop[2] - job->crop[0], job->crop[3] - job->crop[1]);
}

NphStatus nph_photonmap_plan(const NphJob *job, NphPlan *plan) {
    NphContext *context = job->context;
    NphPhotonmapChoice choice;
    NPH_TRY(nph_photonmap_choose(job, &choice));
    for (int s = 0; s < nph_photonmap.stage_count; s++) {
        const NphStage *stage = &nph_photonmap.stages[s];
        NPH_TRY(
            nph_plan_add(context, plan, "stage", stage->name, 0, "%s; blocks of %d", stage->source, stage->block[0]));
    }
    if (!choice.traced)
        NPH_TRY(nph_plan_add(context, plan, "left out", "photons", 0, "nothing scatters, or there is no light"));
    else if (choice.emitted)
        NPH_TRY(nph_plan_add(context, plan, "left out", "pilot", 0, "photonmap.emitted says how many photons are sent out"));
    if (job->knobs[NPH_PHOTONMAP_KNOB_DIRECT] < 0.5)
        NPH_TRY(nph_plan_add(context, plan, "left out", "shadow rays", 0, "direct light is taken from photons too"));
    NPH_TRY(nph_transport_plan(context, job->scene, &choice.transport, plan));
    return plan_buffers(job, &choice, plan);
}
