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
enum { NPH_MAX_SAMPLES = 1 << 30 }; /* of one pixel; sample numbers are 32-bit counters */

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
    const NphTap *tap;           /* NULL: nobody looks */
    int sequence;                /* frames come one after another: */
    void **carry;                /* what the method keeps for the next one, at first NULL; NULL: nothing is kept */
} NphJob;

/* Takes numbers that a port needs beside the buffers; medium: of the scene, or -1. */
typedef void (*NphFactFn)(void *user, int medium, const char *name, int count, const double *values);

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
    /* Frees what was kept in *NphJob.carry. NULL: the method has no memory over time. */
    void (*drop)(NphContext *context, void *carry);
    NphStatus (*replay)(const NphJob *job, int x, int y, int64_t sample, NphLineFn line, void *user);
    /* Stages alone, in a worker's memory. NULL, and no arguments: the method cannot be looked into. To run one: begin_launch,
     * then for every buffer that it reads, in the order of the table, extend and view, and the input is copied; then check, launch,
     * and view what it writes. Batches of a chunk of samples: its tiles; with shares_samples each sample, then the tiles. */
    const char *const *arguments; /* what tells the launches of a stage apart: "tile", "light" */
    int argument_count;
    NphStatus (*begin_launch)(void *state, int worker, NphFilm *film, const NphLaunch *launch);
    /* Makes an input as large as shape says; NPH_BAD_INPUT where it cannot be. */
    NphStatus (*extend)(void *state, int worker, int buffer, const int64_t *shape);
    /* Where the buffer lies and how large it is now; 0 where this scene has none. */
    int (*view)(void *state, int worker, int buffer, NphView *view);
    /* In a run: from now to the next check buffers are changed through their views. NULL: nothing needs to be done. */
    void (*hold)(void *state, int worker);
    /* What has been placed becomes the run's. NPH_BAD_INPUT: what the launch reads has values that no run could have, and that would
     * be taken for places in memory. */
    NphStatus (*check)(void *state, int worker, const NphLaunch *launch);
    NphStatus (*launch)(void *state, int worker, const NphLaunch *launch); /* NPH_NO_MEMORY, or it cannot fail */
    /* Tells what kernels know of the scene, in the run's precision: first of the whole, then medium by medium. */
    NphStatus (*facts)(const NphJob *job, NphFactFn fact, void *user);
} NphMethod;

#endif
