/* SPDX-License-Identifier: Apache-2.0
 *
 * From a scene to a film: options, plan, run, statistics, replay. */
#ifndef NEPHOS_RENDER_H
#define NEPHOS_RENDER_H

#include "nephos/film.h"
#include "nephos/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct NphRenderOptions {
    const char *method;        /* "path", "light", "single" */
    int64_t samples;           /* per pixel, rounded up to 16; 0: the scene's default */
    int64_t sample_begin, sample_end; /* a range of samples instead, multiples of 16; both 0: not given */
    double target_error;       /* relative standard error of the picture's mean; 0: none. Samples double until met, up to
                                  `samples` when given, else 2^20 */
    double time_budget_s;      /* 0: none */
    int seed_given;
    uint32_t seed;
    int precision;             /* 32 (default) or 64 */
    int crop_given;
    int crop[4];               /* x0, y0, x1, y1 */
    uint32_t frame;            /* of the random numbers, to 16777215; that of the scene: nph_scene_load_frame */
    int lock_noise;            /* leaves the frame out of the random numbers */
    int plan_full;             /* leave nothing out */
    int sequence;              /* of a plan: frame after frame, nph_sequence_render; methods then keep what the next one needs */
    int knob_count;
    const char *const *knobs;  /* "path.roulette=0.1" */
} NphRenderOptions;

void nph_render_options_default(NphRenderOptions *options);

typedef struct NphStageStatistics {
    const char *name;      /* "path.track" */
    const char *source;    /* where it comes from in the literature */
    int64_t launches, items; /* items: lanes processed */
    double seconds;        /* summed over threads */
} NphStageStatistics;

enum { NPH_MAX_STAGES = 32 };

typedef struct NphRenderStatistics {
    int64_t samples;          /* camera samples in all */
    int64_t samples_per_pixel;
    double seconds, cpu_seconds;
    int64_t collisions, tentative; /* real ones; real and virtual, shadow rays included */
    int64_t nonfinite, majorant_violations, exhausted; /* each must be 0, else the run fails */
    int64_t integrals, integrand_points; /* quadrature: how many, and points at which light was looked for */
    int64_t unconverged;      /* of these integrals: how many did not reach their tolerance (a warning says so) */
    double worst_residual;    /* largest estimate of their error, relative */
    NphFilmNoise noise;
    int reached;              /* target_error: 1 reached, 0 not */
    int stage_count;
    NphStageStatistics stages[NPH_MAX_STAGES];
} NphRenderStatistics;

/* Renders. *film holds what was done even with NPH_INTERRUPTED (then every tile has its own true number of samples) and
 * NPH_BAD_NUMBER (for inspection); else it is untouched on failure. statistics may be NULL. */
NphStatus nph_render(NphContext *context, const NphScene *scene, const NphRenderOptions *options, NphFilm **film,
                     NphRenderStatistics *statistics);

/* Frames one after another: each the same bytes as nph_render of the scene at that frame, in less time where a method has memory
 * over time. Frames may be taken in any order; from one to the next but few the method goes on. options is copied, its texts are
 * not; its frame does not count. `scene`, of any frame, and those texts must outlive the sequence. What a method sums in floats, as
 * `tpm.variant` 1 does, depends on where the sequence began. */
typedef struct NphSequence NphSequence;
NphStatus nph_sequence_open(NphContext *context, const NphScene *scene, const NphRenderOptions *options, NphSequence **sequence);
/* As nph_render. After a failure the next frame begins anew. */
NphStatus nph_sequence_render(NphSequence *sequence, uint32_t frame, NphFilm **film, NphRenderStatistics *statistics);
void nph_sequence_close(NphSequence *sequence);

/* What a run would do. Text lines owned by the plan. */
typedef struct NphPlanLine {
    char kind[12];   /* "stage", "buffer", "left out", "modelled", "warning", "memory" */
    char *name;
    char *text;      /* why, or the shape */
    uint64_t bytes;  /* of a buffer or in all */
} NphPlanLine;

typedef struct NphPlan {
    uint64_t bytes;      /* all memory the run takes, the scene's included */
    int line_count;
    NphPlanLine *lines;
} NphPlan;

NphStatus nph_plan_make(NphContext *context, const NphScene *scene, const NphRenderOptions *options, NphPlan *plan);
void nph_plan_free(NphContext *context, NphPlan *plan);

/* Follows one path event by event in scalar code and writes a line for each to `line`. */
typedef void (*NphLineFn)(void *user, const char *text);
NphStatus nph_replay(NphContext *context, const NphScene *scene, const NphRenderOptions *options, int x, int y,
                     int64_t sample, NphLineFn line, void *user);

/* Knobs of every method: for help, checks and sweeps. */
typedef struct NphKnob {
    const char *name, *unit, *meaning, *trades;
    double value, min, max; /* value: the default */
} NphKnob;
int nph_knob_count(void);
const NphKnob *nph_knob(int index);

#ifdef __cplusplus
}
#endif
#endif
