/* SPDX-License-Identifier: Apache-2.0
 *
 * Stages and buffers as data. A method is a table of stages in the paper's order and a table of the buffers between
 * them; plans, timing, documentation (later dumps and comparison) read these tables. */
#ifndef NPH_PIPELINE_STAGE_H
#define NPH_PIPELINE_STAGE_H

#include "nephos/array.h"
#include "nephos/render.h"

/* How a buffer is compared with somebody else's. */
typedef enum NphClass {
    NPH_EXACT, /* indices, counts, random words */
    NPH_NEAR,  /* rounding */
    NPH_STAT,  /* Monte Carlo, with its variance */
    NPH_BIAS   /* a method against the truth */
} NphClass;

/* NPH_TYPE_REAL stands for f32 or f64, whichever the run's precision is. */
enum { NPH_TYPE_REAL = -1 };

typedef struct NphBuffer {
    const char *name;    /* "path.position" */
    int type;            /* NphType or NPH_TYPE_REAL */
    const char *shape;   /* "[3][path]" */
    const char *unit;
    const char *meaning;
    NphClass comparison;
    const char *needed;  /* the condition in words; NULL: always there */
} NphBuffer;

typedef struct NphStage {
    const char *name;
    const char *source;  /* where the equation comes from */
    const char *reads;   /* buffers, blank separated */
    const char *writes;
    int block[3];        /* items per block */
    size_t scratch_bytes; /* block-shared memory */
} NphStage;

/* What a stage left behind: seconds and items summed over workers. */
typedef struct NphStageCount {
    int64_t launches, items;
    double seconds;
} NphStageCount;

/* One worker's record of the stages it ran; merged after the run. */
typedef struct NphStageCounts {
    NphStageCount stage[NPH_MAX_STAGES];
} NphStageCounts;

/* Names the stages in a run's statistics, all counts 0; then adds what each worker counted. */
void nph_stages_begin(const NphStage *stages, int count, NphRenderStatistics *out);
void nph_stages_add(const NphStageCounts *counts, NphRenderStatistics *out);

/* Runs `call` as stage `index` on `items` items: the one place where a stage is timed and counted. */
#define NPH_LAUNCH(counts, index, item_count, call)                          \
    do {                                                                     \
        double nph_launch_start_ = nph_seconds();                            \
        (call);                                                              \
        NphStageCount *nph_launch_count_ = &(counts)->stage[index];          \
        nph_launch_count_->seconds += nph_seconds() - nph_launch_start_;     \
        nph_launch_count_->launches += 1;                                    \
        nph_launch_count_->items += (item_count);                            \
    } while (0)

#endif
