/* SPDX-License-Identifier: Apache-2.0
 *
 * Two dumps, stage by stage: where a port first differs from the reference. docs/oracle.md. */
#ifndef NEPHOS_VERIFY_H
#define NEPHOS_VERIFY_H

#include "nephos/stage.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct NphVerifyOptions {
    const NphScene *scene;  /* of the reference; NULL: no stage is run again, whole_run is implied */
    int whole_run;          /* outputs are compared with those of the reference's run, whatever the candidate's inputs were */
    double ulp;             /* units in the last place that rounding may make; of the value, or of its row's largest one */
    double flips;           /* part of a buffer of integers that may differ: decisions that rounding turned over */
} NphVerifyOptions;

void nph_verify_options_default(NphVerifyOptions *options);

/* ulp: in units of the reference's value, of a float where the reference ran in f32; infinite where one of the two is not a number. index: of the reference's cell. */
typedef struct NphVerifyCell {
    int64_t batch, number;  /* of the launch */
    int rank;
    int64_t index[NPH_MAX_RANK];
    double reference, candidate, ulp, absolute, relative;
} NphVerifyCell;

/* ulp 0; up to 1, 4, 16, 64, 1024, 2^20; more. */
enum { NPH_VERIFY_BINS = 8, NPH_VERIFY_NAME = 64 };

/* One buffer of one stage, over all its launches. */
typedef struct NphVerifyRow {
    char stage[NPH_VERIFY_NAME], buffer[NPH_VERIFY_NAME];
    int64_t launches, cells, beyond; /* beyond the tolerance; of integers: different */
    int64_t histogram[NPH_VERIFY_BINS];
    NphVerifyCell worst;    /* the largest ulp; the first one of equal ones */
    int failed;
    char problem[256];      /* missing, misshaped; else empty */
} NphVerifyRow;

typedef struct NphVerification {
    int failed;
    int64_t launches;       /* compared */
    int64_t left_out;       /* launches of the reference that the candidate has not */
    int64_t run_again;      /* of those compared: judged on the candidate's inputs */
    int first;              /* row of the first launch that failed; -1 */
    int64_t first_batch, first_number;
    int row_count;
    NphVerifyRow *rows;     /* in the order in which the launches come */
} NphVerification;

/* Folders of dumps. A launch of the candidate whose manifest lists inputs is judged on those: the reference's stage is run again
 * on them. Without them its outputs are compared with those of the reference's launch: it was given the same inputs. NPH_OK whatever the
 * outcome. */
NphStatus nph_verify(NphContext *context, const char *reference, const char *candidate, const NphVerifyOptions *options,
                     NphVerification *result);
void nph_verification_free(NphContext *context, NphVerification *result);

/* What a dump says of its run. The options and all names point into it. */
typedef struct NphDumpRun NphDumpRun;
NphStatus nph_dump_run(NphContext *context, const char *folder, NphDumpRun **run);
const NphRenderOptions *nph_dump_run_options(const NphDumpRun *run);
void nph_dump_run_free(NphContext *context, NphDumpRun *run);

/* Its launches, from 0, in the order of batches (-1: what is launched once, before all others) and of numbers in them. */
enum { NPH_DUMP_ARGUMENTS = 8 };
typedef struct NphDumpLaunch {
    int64_t batch, number;
    const char *stage;
    int argument_count, input_count, output_count;
    const char *argument_names[NPH_DUMP_ARGUMENTS];
    int64_t arguments[NPH_DUMP_ARGUMENTS];
    const char *inputs[NPH_MAX_BUFFERS], *outputs[NPH_MAX_BUFFERS]; /* names of buffers */
} NphDumpLaunch;
int64_t nph_dump_run_launch_count(const NphDumpRun *run);
void nph_dump_run_launch(const NphDumpRun *run, int64_t index, NphDumpLaunch *launch);

/* A buffer that the launch reads, or if it does not, writes; the caller frees it. NPH_BAD_INPUT where it does neither. */
NphStatus nph_dump_run_array(NphContext *context, const NphDumpRun *run, int64_t index, const char *buffer, NphArray *array);

/* Numbers of the manifest by where they stand: "resolution", "transport.channels", "media.0.sigma". Returns how many there are, of
 * which at most `room` are written; 0 where there are none. */
int nph_dump_run_numbers(const NphDumpRun *run, const char *name, int room, double *values);

/* Arguments (in the order of stages) and inputs of one of its launches, which must be of that stage; the caller frees the arrays.
 * inputs: room for NPH_MAX_BUFFERS. */
NphStatus nph_dump_inputs(NphContext *context, const char *folder, int64_t batch, int64_t number, const NphStages *stages,
                          const char *stage, int64_t *arguments, NphNamedArray *inputs, int *count);

/* The reference's scene as its manifest names it, for nph_scene_load. NPH_BAD_INPUT where it names none, or one that is too long. */
NphStatus nph_dump_scene_name(NphContext *context, const char *folder, char *name, size_t bytes);

#ifdef __cplusplus
}
#endif
#endif
