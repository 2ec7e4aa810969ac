/* SPDX-License-Identifier: Apache-2.0
 *
 * Stages alone, and dumps. A method is a list of stages with buffers between them. A stage is a function of the scene, the
 * arguments of its launch (which tile, which vertex, which light) and the buffers that it reads: given the same it writes the
 * same bytes, in a run or alone. docs/oracle.md. */
#ifndef NEPHOS_STAGE_H
#define NEPHOS_STAGE_H

#include "nephos/array.h"
#include "nephos/render.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct NphStageInfo {
    const char *name;          /* "path.track" */
    const char *source;        /* in the literature */
    const char *reads, *writes; /* buffers, blank separated; those that the scene does not need are not there */
} NphStageInfo;

typedef struct NphBufferInfo {
    const char *name;          /* "path.ray" */
    const char *shape;         /* "[6][path]": the last axis is the fastest */
    const char *unit, *meaning;
    const char *comparison;    /* "exact", "near" (rounding), "stat" (Monte Carlo), "bias" */
    const char *needed;        /* when it is there, in words; NULL: always */
    const char *identity;      /* buffer that names the items along the last axis, whose order is free; NULL: by position */
    int queue;                 /* its values are positions of such items, 1: in any order, 2: in this order */
} NphBufferInfo;

typedef struct NphNamedArray {
    const char *name;          /* of the buffer; not owned */
    NphArray array;
} NphNamedArray;

enum { NPH_MAX_BUFFERS = 64 };

/* A method opened on a scene, to run stages of. NPH_BAD_USAGE where the method's stages cannot be run alone. The scene must
 * outlive it. */
typedef struct NphStages NphStages;
NphStatus nph_stages_open(NphContext *context, const NphScene *scene, const NphRenderOptions *options, NphStages **stages);
void nph_stages_close(NphStages *stages);

int nph_stages_count(const NphStages *stages);
NphStageInfo nph_stages_stage(const NphStages *stages, int index);
int nph_stages_buffer_count(const NphStages *stages);
NphBufferInfo nph_stages_buffer(const NphStages *stages, int index);
int nph_stages_argument_count(const NphStages *stages);
const char *nph_stages_argument(const NphStages *stages, int index); /* "tile" */

/* Runs one stage on one worker. arguments: as many as there are, in their order. Inputs are what the stage reads, in any order;
 * f32 and f64 are converted to the run's precision; integers must be of the buffer's type. NPH_BAD_INPUT names an input that is missing,
 * not read by the stage, or of a shape that does not fit. outputs: room for NPH_MAX_BUFFERS; *output_count of them are made
 * and owned by the caller (nph_array_free). */
NphStatus nph_stages_run(NphStages *stages, const char *stage, const int64_t *arguments, int input_count,
                         const NphNamedArray *inputs, int *output_count, NphNamedArray *outputs);

/* What of a run is written down. */
typedef struct NphDumpOptions {
    const char *folder;        /* made if it is not there; must be empty */
    const char *stage;         /* one stage only; NULL: all */
    int64_t launch, batch;     /* one launch of each batch, one batch only; -1: all */
    int pixel_given, pixel[2]; /* the batches of that pixel only */
    uint64_t limit_bytes;      /* refused with NPH_NO_MEMORY, before the run where the forecast says so, as soon as more would be written */
} NphDumpOptions;

void nph_dump_options_default(NphDumpOptions *options);

/* nph_render that writes the outputs of every launch, those of a batch one after the other as .npy arrays into one file, and, at the
 * end, manifest.json, which says where each begins. scene_name: for the manifest. */
NphStatus nph_dump(NphContext *context, const NphScene *scene, const char *scene_name, const NphRenderOptions *options,
                   const NphDumpOptions *dump, NphFilm **film, NphRenderStatistics *statistics);

#ifdef __cplusplus
}
#endif
#endif
