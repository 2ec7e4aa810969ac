/* SPDX-License-Identifier: Apache-2.0
 *
 * From options to a checked job. */
#ifndef NPH_METHOD_JOB_H
#define NPH_METHOD_JOB_H

#include "method/registry.h"

/* Checks options against scene and method; NPH_BAD_USAGE says which is wrong and what is allowed. */
NphStatus nph_job_make(NphContext *context, const NphScene *scene, const NphRenderOptions *options,
                       const NphMethod **method, NphJob *job);

/* nph_render with somebody who looks at the buffers, or NULL. */
NphStatus nph_render_tapped(NphContext *context, const NphScene *scene, const NphRenderOptions *options, const NphTap *tap,
                            NphFilm **film, NphRenderStatistics *statistics);

/* The same, with what the method keeps over frames (NphJob.carry), or NULL. */
NphStatus nph_render_carried(NphContext *context, const NphScene *scene, const NphRenderOptions *options, const NphTap *tap, void **carry,
                             NphFilm **film, NphRenderStatistics *statistics);

/* Texts that name the job in files: digest, seed, method, knobs, precision, frame, version. */
NphStatus nph_job_describe(const NphJob *job, const NphMethod *method, NphFilm *film);

#endif
