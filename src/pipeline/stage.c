/* SPDX-License-Identifier: Apache-2.0
 *
 * The tables of stages, and what the stages of a run left behind, summed over its workers. */
#include "pipeline/stage.h"

#include <string.h>

#include "core/fmath.h"

int nph_stage_lists(const char *buffers, const char *name) {
    size_t length = strlen(name);
    for (const char *at = buffers; (at = strstr(at, name)) != NULL; at += length)
        if ((at == buffers || at[-1] == ' ') && (at[length] == ' ' || !at[length])) return 1;
    return 0;
}

static double value_at(const NphView *view, int64_t at) {
    switch (view->type) {
    case NPH_F32: return (double)((const float *)view->data)[at];
    case NPH_F64: return ((const double *)view->data)[at];
    case NPH_I64: return (double)((const int64_t *)view->data)[at];
    case NPH_U32: return (double)((const uint32_t *)view->data)[at];
    default: return (double)((const int32_t *)view->data)[at];
    }
}

int64_t nph_view_wrong(const NphView *view, int64_t least, int64_t most) {
    int64_t rows = view->rank > 1 ? view->shape[0] : 1, length = 1;
    int real = view->type == NPH_F32 || view->type == NPH_F64;
    for (int a = view->rank > 1; a < view->rank; a++) length *= view->shape[a];
    for (int64_t i = 0; i < rows * length; i++) {
        double value = value_at(view, i / length * view->stride + i % length);
        if (real ? !(nph_abs(value) < nph_infinity()) : value < (double)least || value > (double)most) return i;
    }
    return -1;
}

void nph_stages_begin(const NphStage *stages, int count, NphRenderStatistics *out) {
    out->stage_count = count;
    for (int s = 0; s < count; s++)
        out->stages[s] = (NphStageStatistics){stages[s].name, stages[s].source, 0, 0, 0.0};
}

void nph_stages_add(const NphStageCounts *counts, NphRenderStatistics *out) {
    for (int s = 0; s < out->stage_count; s++) {
        NphStageStatistics *stage = &out->stages[s];
        stage->launches += counts->stage[s].launches;
        stage->items += counts->stage[s].items;
        stage->seconds += counts->stage[s].seconds;
    }
}
