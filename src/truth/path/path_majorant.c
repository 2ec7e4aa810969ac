/* SPDX-License-Identifier: Apache-2.0
 *
 * path.majorant: bounds of a medium's density (field/majorant.c) from its samples as a dense array, which is what a port has.
 * [density -> bound] */
#include "core/memory.h"
#include "core/message.h"
#include "field/grid.h"
#include "truth/path/path.h"

void nph_path_field_free(NphContext *context, NphPathField *field) {
    nph_free(context, field->density);
    nph_free(context, field->majorant.cells);
    *field = (NphPathField){.density = NULL};
}

NphStatus nph_path_field_begin(const NphJob *job, const NphPathChoice *choice, int64_t medium, NphPathField *field) {
    const NphScene *scene = job->scene;
    int there = medium >= 0 && medium < scene->medium_count;
    if (!there || scene->media[medium].shape != NPH_SHAPE_GRID || !choice->transport.used[medium])
        return nph_error(job->context, NPH_BAD_INPUT, "medium %lld: %s", (long long)medium,
                         !there                                          ? "the scene has no such medium"
                         : scene->media[medium].shape != NPH_SHAPE_GRID ? "is no grid: it has no majorants"
                                                                         : "has no extinction: nothing tracks it");
    const NphGrid *grid = &scene->media[medium].grid;
    nph_path_field_free(job->context, field);
    NPH_TRY(NPH_NEW(job->context, nph_grid_dense_count(grid), "density as a dense array", &field->density));
    for (int a = 0; a < 3; a++) field->n[a] = grid->n[a];
    return NPH_OK;
}

/* A cell that is empty says how many may be skipped: a number that is taken for an integer. */
static int is_bound(float value) { return value > 0.0f ? (double)value <= 2.0 * NPH_DENSITY_MAX : value <= -1.0f && value >= -NPH_GRID_SAMPLES_MAX; }

NphStatus nph_path_field_check(const NphJob *job, const NphPathField *field) {
    const int32_t *n = field->n, *cells = field->majorant.n;
    int64_t count = (int64_t)n[0] * n[1] * n[2], bounds = field->majorant.cells ? (int64_t)cells[0] * cells[1] * cells[2] : 0;
    for (int64_t i = 0; i < count; i++)
        if (!(field->density[i] >= 0.0f && (double)field->density[i] <= NPH_DENSITY_MAX))
            return nph_error(job->context, NPH_BAD_INPUT, "input path.density: value %lld is no density", (long long)i);
    for (int64_t i = 0; i < bounds; i++)
        if (!is_bound(field->majorant.cells[i]))
            return nph_error(job->context, NPH_BAD_INPUT, "path.bound: value %lld is no bound", (long long)i);
    return NPH_OK;
}

NphStatus nph_path_field_bound(const NphJob *job, NphPathField *field) {
    nph_free(job->context, field->majorant.cells);
    field->majorant.cells = NULL;
    return nph_majorant_of_samples(job->context, field->n, field->density, "majorants", &field->majorant);
}

int nph_path_field_view(const NphPathField *field, int buffer, NphView *view) {
    int bound = buffer == NPH_PATH_BOUND;
    const int32_t *n = bound ? field->majorant.n : field->n;
    float *data = bound ? field->majorant.cells : field->density;
    *view = (NphView){NPH_F32, 3, {n[2], n[1], n[0]}, data, (int64_t)n[1] * n[0]};
    return data != NULL;
}
