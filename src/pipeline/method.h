/* SPDX-License-Identifier: Apache-2.0
 *
 * What a method (or a reference) is to the rest of the program: tables of knobs, stages and buffers, and the calls that
 * plan it, run it over a range of samples, and replay one sample. */
#ifndef NPH_PIPELINE_METHOD_H
#define NPH_PIPELINE_METHOD_H

#include "film/film.h"
#include "pipeline/stage.h"
#include "scene/model.h"

enum { NPH_MAX_KNOBS = 32 };

/* A checked request. */
typedef struct NphJob {
    NphContext *context;
    const NphScene *scene;
    int precision;               /* 32 or 64 */
    int plan_full;
    int crop[4];
    uint32_t seed, frame;        /* frame is 0 with lock_noise */
    int64_t sample_begin, sample_end;
    double knobs[NPH_MAX_KNOBS]; /* in the order of the method's table */
} NphJob;

typedef struct NphMethod {
    const char *name, *summary;
    const NphKnob *knobs;
    int knob_count;
    const NphStage *stages;
    int stage_count;
    int takes_wavelengths; /* it renders scenes of several wavelengths; else they are refused */
    int shares_samples; /* a sample is one image: its pixels are not independent (film.h) */
    const NphBuffer *buffers;
    int buffer_count;
    /* Says through plan.h what the run would do; the same decisions as open. */
    NphStatus (*plan)(const NphJob *job, NphPlan *plan);
    /* Channels its film needs: 1 or 3. */
    int (*channels)(const NphJob *job);
    NphStatus (*open)(const NphJob *job, void **state);
    /* Adds samples [begin, end) to every tile of the film. */
    NphStatus (*run)(void *state, NphFilm *film, int64_t begin, int64_t end, int64_t done, int64_t total);
    /* Fills counts of events, and stages. */
    void (*statistics)(const void *state, NphRenderStatistics *statistics);
    void (*close)(void *state);
    NphStatus (*replay)(const NphJob *job, int x, int y, int64_t sample, NphLineFn line, void *user);
} NphMethod;

#endif
