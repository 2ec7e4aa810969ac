/* SPDX-License-Identifier: Apache-2.0
 *
 * What a run of truth/shdom would do, and the memory that it takes. */
#include "core/message.h"
#include "pipeline/plan.h"
#include "truth/shdom/shdom.h"

static NphStatus plan_solution(const NphJob *job, const NphShdomChoice *choice, NphPlan *plan) {
    NphContext *context = job->context;
    const NphShdomGrid *grid = &choice->grid;
    const NphShdomAngles *angles = &choice->angles;
    if (!choice->solved)
        return nph_plan_add(context, plan, "left out", "shdom.sweep", 0, "nothing scatters, or there is no light: nothing is solved for");
    if (angles->terms < angles->bands * angles->bands)
        NPH_TRY(nph_plan_add(context, plan, "left out", "shdom.moments", 0, "%d of %d coefficients: the phase function scatters nothing into them",
                             angles->bands * angles->bands - angles->terms, angles->bands * angles->bands));
    if (angles->cut > 0.0)
        NPH_TRY(nph_plan_add(context, plan, "left out", job->scene->media[choice->medium].name, 0,
                             "%.3g of what is scattered: the peak of the phase function goes on unscattered (shdom.delta_m)", angles->cut));
    if (choice->looks)
        NPH_TRY(nph_plan_add(context, plan, "left out", "quadrature", 0, "single scattering comes from the grid"));
    return nph_plan_add(context, plan, "buffer", "shdom.source", nph_shdom_solver_bytes(job, choice, nph_context_threads(context)),
                        "%d x %d x %d cells, %lld points of %d coefficients in %d channels, %d ordinates, the last %d sources", (int)grid->cells[0],
                        (int)grid->cells[1], (int)grid->cells[2], (long long)grid->point_count, angles->terms, choice->channels,
                        nph_shdom_ordinates(angles), choice->history);
}

NphStatus nph_shdom_plan(const NphJob *job, NphPlan *plan) {
    NphContext *context = job->context;
    const NphSensor *sensor = &job->scene->sensor;
    NphShdomChoice choice;
    NPH_TRY(nph_shdom_choose(job, &choice));
    for (int s = 0; s < NPH_SHDOM_STAGES; s++) {
        const NphStage *stage = &nph_shdom_stages[s];
        NPH_TRY(nph_plan_add(context, plan, "stage", stage->name, 0, "%s; blocks of %d", stage->source, stage->block[0]));
    }
    NPH_TRY(nph_transport_plan(context, job->scene, &choice.transport, plan));
    NPH_TRY(plan_solution(job, &choice, plan));
    uint64_t threads = (uint64_t)nph_context_threads(context), batch = (NPH_SHDOM_RAY_ROWS + NPH_SAMPLE_FIELDS) * NPH_SHDOM_BATCH * sizeof(double);
    uint64_t scratch = nph_single_scratch_bytes(1) + nph_film_scratch_bytes(choice.transport.film_channels) + nph_shdom_look_doubles(&choice) * sizeof(double);
    NPH_TRY(nph_plan_add(context, plan, "memory", "scene", 2 * sizeof(NphSingleScene), "in scene-local space, f64, twice"));
    NPH_TRY(nph_plan_add(context, plan, "memory", "batches", threads * batch, "%d rays each, one a thread", NPH_SHDOM_BATCH));
    NPH_TRY(nph_plan_add(context, plan, "memory", "scratch", threads * scratch, "pieces of the ray, panels, harmonics, film scratch"));
    return nph_plan_add(context, plan, "memory", "film",
                        nph_film_forecast_bytes(sensor->width, sensor->height, job->crop, choice.transport.film_channels, job->sample_begin,
                                                job->sample_end),
                        "moments of every pixel");
}
