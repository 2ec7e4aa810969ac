/* SPDX-License-Identifier: Apache-2.0
 *
 * Two dumps, stage by stage: where a port first differs from the reference. docs/oracle.md. */
#ifndef NEPHOS_VERIFY_H
#define NEPHOS_VERIFY_H

#include "nephos/stage.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { NPH_VERIFY_NAME = 64 };

/* How far an honest implementation of one stage may be off in one buffer, for one cause: "f64", "contraction", "opencl", ...;
 * "f16:BUFFER", halves in place of floats in that buffer, counts only where it is allowed. Differences of numbers are in units in the
 * last place of the reference's value or of the largest in its row, whichever are fewer; of an item (a path, a pixel) the largest
 * counts. */
typedef struct NphTolerance {
    char stage[NPH_VERIFY_NAME], buffer[NPH_VERIFY_NAME], cause[NPH_VERIFY_NAME];
    double ulp;            /* of every item, but for the part `flips`, whose decision may have fallen the other way */
    double flips;
    double typical, tail;  /* of every item, but for the part `tail` */
    double gap;            /* the largest difference that was measured, of which ulp is a multiple */
} NphTolerance;

/* What `nephos tolerance` writes: docs/oracle.md. */
typedef struct NphTolerances {
    char method[NPH_VERIFY_NAME], scene_digest[40];
    int precision; /* of the reference: 32 or 64 */
    int count;
    NphTolerance *rows;
} NphTolerances;

NphStatus nph_tolerances_read(NphContext *context, const char *path, NphTolerances *tolerances);
void nph_tolerances_free(NphContext *context, NphTolerances *tolerances);

typedef struct NphVerifyOptions {
    const NphScene *scene;  /* of the reference; NULL: no stage is run again, whole_run is implied */
    int complete;           /* launches of the reference that the candidate has not are a failure */
    int whole_run;          /* outputs are compared with those of the reference's run, whatever the candidate's inputs were */
    /* Measured: of a stage's buffer the loosest of all causes that count. NULL: ulp and flips are those of every buffer. */
    const NphTolerances *tolerances;
    const char *interface;  /* of all interfaces only this one counts; NULL: each */
    int allow_count;        /* causes that count besides: "f16:path.weight"; those that the candidate's manifest declares need none */
    const char *const *allow;
    double ulp;             /* as in NphTolerance */
    double flips;
} NphVerifyOptions;

void nph_verify_options_default(NphVerifyOptions *options);

/* ulp: of the reference's value or the largest one in its row, whichever are fewer, of a float where the reference ran in f32; infinite
 * where one of the two is not a number. index: of the reference's cell. */
typedef struct NphVerifyCell {
    int64_t batch, number;  /* of the launch */
    int rank;
    int64_t index[NPH_MAX_RANK];
    double reference, candidate, ulp, absolute, relative;
} NphVerifyCell;

/* ulp 0; up to 1, 4, 16, 64, 1024, 2^20; more. */
enum { NPH_VERIFY_BINS = 8 };

/* One buffer of one stage, over all its launches. */
typedef struct NphVerifyRow {
    char stage[NPH_VERIFY_NAME], buffer[NPH_VERIFY_NAME];
    int64_t launches, cells, beyond; /* beyond the tolerance; of integers: different */
    int64_t items, turned;  /* items compared, and those with a cell beyond: decisions that fell the other way, or mistakes */
    int64_t untypical;      /* items beyond what is typical */
    NphTolerance tolerance; /* that was applied, and from which cause; no cause: ulp and flips were given */
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

/* Folders of dumps. An item whose integers differ in a launch is turned over: its numbers are not compared. A buffer passes while
 * no more than flips of its items are turned over, in all launches together, and in none of them more than that and one; and no more
 * than tail of them, and one, are untypical. Where tolerances were measured, integers may have one more turned over. A launch of the candidate whose manifest lists inputs is judged on those: the reference's stage is run again
 * on them. Without them its outputs are compared with those of the reference's launch: it was given the same inputs. NPH_OK whatever the
 * outcome. */
NphStatus nph_verify(NphContext *context, const char *reference, const char *candidate, const NphVerifyOptions *options,
                     NphVerification *result);
void nph_verification_free(NphContext *context, NphVerification *result);

/* What a dump says of its run. The options and all names point into it. */
typedef struct NphDumpRun NphDumpRun;
NphStatus nph_dump_run(NphContext *context, const char *folder, NphDumpRun **run);
const NphRenderOptions *nph_dump_run_options(const NphDumpRun *run);
/* NPH_BAD_INPUT where the scene is not the one that was dumped. */
NphStatus nph_dump_run_check(NphContext *context, const NphDumpRun *run, const NphScene *scene);
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

/* The reference's scene as its manifest names it, and the frame that it stood at, for nph_scene_load_frame. NPH_BAD_INPUT where it names
 * none, or one that is too long; with name NULL only the frame is told. */
NphStatus nph_dump_scene(NphContext *context, const char *folder, char *name, size_t bytes, uint32_t *frame);

#ifdef __cplusplus
}
#endif
#endif
