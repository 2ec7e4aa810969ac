/* SPDX-License-Identifier: Apache-2.0
 *
 * The tables of stages, and what the stages of a run left behind, summed over its workers. */
#include "pipeline/stage.h"

#include <string.h>

int nph_stage_lists(const char *buffers, const char *name) {
    size_t length = strlen(name);
    for (const char *at = buffers; (at = strstr(at, name)) != NULL; at += length)
        if ((at == buffers || at[-1] == ' ') && (at[length] == ' ' || !at[length])) return 1;
    return 0;
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
