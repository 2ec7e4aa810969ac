/* SPDX-License-Identifier: Apache-2.0
 *
 * Stages and buffers as data. A method is a table of stages in the paper's order and a table of the buffers between
 * them; plans, timing, documentation, dumps and their verification read these tables. A stage is a function of the scene,
 * the arguments of its launch and the buffers that it reads. */
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
    const char *identity; /* buffer that names the items along the last axis, whose order is then nobody's business; its
                             values are such positions when `shape` is a queue's. NULL: by position */
    int queue;           /* the values are positions of items: NPH_QUEUE_..., or 0 */
} NphBuffer;

/* Positions of items: a queue, whose order is nobody's business; a list, by position. */
enum { NPH_QUEUE_AS_SET = 1, NPH_QUEUE_IN_ORDER };

typedef struct NphStage {
    const char *name;
    const char *source;  /* where the equation comes from */
    const char *reads;   /* buffers, blank separated */
    const char *writes;
    int block[3];        /* items per block */
    size_t scratch_bytes; /* block-shared memory */
} NphStage;

/* A buffer as it stands in memory: shape[0] rows that lie `stride` elements apart, each without gaps. */
typedef struct NphView {
    NphType type;
    int rank;
    int64_t shape[NPH_MAX_RANK];
    void *data;
    int64_t stride;
} NphView;

/* The first value of a view that is not finite, or of integers not from least to most; -1: none. */
int64_t nph_view_wrong(const NphView *view, int64_t least, int64_t most);

enum { NPH_MAX_ARGUMENTS = 8 };

/* The batch of what is launched once, before all others; its launches stand each for itself. */
enum { NPH_BATCH_OF_SCENE = -1 };

/* One launch of a stage: `batch` and `number` in it name it, whatever the thread. */
typedef struct NphLaunch {
    int stage;
    int64_t batch, number, items;
    int64_t arguments[NPH_MAX_ARGUMENTS]; /* in the order of the method's table */
} NphLaunch;

/* Looks at the buffers around launches (NphMethod.view), in the worker's thread. A status that is not NPH_OK ends the run. */
typedef struct NphTap {
    void *user;
    NphStatus (*before)(void *user, void *state, int worker, const NphLaunch *launch);
    NphStatus (*after)(void *user, void *state, int worker, const NphLaunch *launch);
} NphTap;

/* Whether a stage's blank-separated list of buffers has that name. */
int nph_stage_lists(const char *buffers, const char *name);

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
