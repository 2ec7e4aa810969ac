/* SPDX-License-Identifier: Apache-2.0
 *
 * How far an honest implementation may be off: every launch that is handed in is run once as it is, then once for each cause, on
 * the same inputs, and the outputs are compared as verify compares them (oracle/cells.h). */
#ifndef NPH_ALTERED_MEASURE_H
#define NPH_ALTERED_MEASURE_H

#include "core/json.h"
#include "nephos/verify.h"

/* What makes an implementation honest and yet different. */
typedef struct AlteredCause {
    char name[NPH_VERIFY_NAME];
    const char *source;     /* what it is, or whose promise */
    const char *unmeasured; /* why it could not be simulated; NULL: it was */
} AlteredCause;

/* Tolerance of every item = FACTOR max(gap, 1 ulp); flips = FACTOR max(part turned over, FLOOR); of every item but the part
 * FACTOR TAIL = TYPICAL max(what all but the part TAIL keep to, 1 ulp). Causes add up, since a port contracts, divides and calls functions
 * at once, each of which is measured alone: TYPICAL. That is measured on a sample, and the largest difference of a sample is not
 * the largest: FACTOR. */
#define ALTERED_FACTOR 16.0
#define ALTERED_TYPICAL 4.0
#define ALTERED_FLOOR 1e-6
#define ALTERED_TAIL 1e-3

typedef struct AlteredMeasure AlteredMeasure;
NphStatus altered_measure_open(NphContext *context, const NphScene *scene, const NphRenderOptions *options, AlteredMeasure **measure);
void altered_measure_close(AlteredMeasure *measure);

/* One launch, its inputs by name. */
NphStatus altered_measure_launch(AlteredMeasure *measure, const char *stage, const int64_t *arguments, int count,
                                 const NphNamedArray *inputs);

/* A dump's launches, of each stage ALTERED_LAUNCHES at most, spread over the dump. */
enum { ALTERED_LAUNCHES = 48 };
NphStatus altered_measure_dump(AlteredMeasure *measure, const char *folder);

/* The launches of a run, none of which is written; options as at open. altered_few: 16 samples of up to 2 x 2 tiles around the middle of
 * the picture or crop. */
void altered_few(const NphScene *scene, const NphRenderOptions *options, NphRenderOptions *few);
NphStatus altered_measure_run(AlteredMeasure *measure, const NphScene *scene, const NphRenderOptions *options);

/* What has been measured: of the caller, nph_tolerances_free. */
NphStatus altered_measure_tolerances(const AlteredMeasure *measure, NphTolerances *tolerances);
void altered_measure_write(const AlteredMeasure *measure, const char *scene_name, NphJson *json);

#endif
