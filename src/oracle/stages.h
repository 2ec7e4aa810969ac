/* SPDX-License-Identifier: Apache-2.0
 *
 * Buffers of a method's state as arrays: taken out, put in. */
#ifndef NPH_ORACLE_STAGES_H
#define NPH_ORACLE_STAGES_H

#include "nephos/stage.h"
#include "oracle/manifest.h"
#include "pipeline/method.h"

extern const char *const nph_class_names[];

/* A copy of a buffer as it stands; rank 0 where the scene has none. */
NphStatus nph_buffer_take(NphContext *context, const NphMethod *method, void *state, int worker, int buffer, NphArray *array);

/* Copies an array into a buffer, which takes the array's length along its last axis; NPH_BAD_INPUT where it does not fit. */
NphStatus nph_buffer_place(NphContext *context, const NphMethod *method, void *state, int worker, int buffer, const NphArray *array);

/* The buffer's place in the method's table, or -1. */
int nph_buffer_find(const NphMethod *method, const char *name);
int nph_stage_find(const NphMethod *method, const char *name);

/* NPH_BAD_USAGE where the method's stages cannot be looked at. */
NphStatus nph_stages_supported(NphContext *context, const NphMethod *method);

/* Arguments and inputs of a launch of a dump; the caller frees the arrays. inputs: room for NPH_MAX_BUFFERS. (verify.c) */
NphStatus nph_launch_inputs(NphContext *context, const NphManifest *manifest, const NphManifestLaunch *launch, const NphStages *stages,
                            int64_t *arguments, NphNamedArray *inputs, int *count);

/* The first buffer that the stage reads in this scene and that is not among the inputs; NULL: there is none. */
NphStatus nph_stages_missing(NphStages *stages, const char *stage, const int64_t *arguments, int input_count, const NphNamedArray *inputs,
                             const char **missing);

#endif
