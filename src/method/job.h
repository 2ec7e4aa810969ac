/* SPDX-License-Identifier: Apache-2.0
 *
 * From options to a checked job. */
#ifndef NPH_METHOD_JOB_H
#define NPH_METHOD_JOB_H

#include "method/registry.h"

enum { NPH_MAX_SAMPLES = 1 << 30 }; /* of one pixel; sample numbers are 32-bit counters */

/* Checks options against scene and method; NPH_BAD_USAGE says which is wrong and what is allowed. */
NphStatus nph_job_make(NphContext *context, const NphScene *scene, const NphRenderOptions *options,
                       const NphMethod **method, NphJob *job);

/* Texts that name the job in files: digest, seed, method, knobs, precision, frame, version. */
NphStatus nph_job_describe(const NphJob *job, const NphMethod *method, NphFilm *film);

#endif
