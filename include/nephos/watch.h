/* SPDX-License-Identifier: Apache-2.0
 *
 * A run looked at, and changed, between its stages: run to stage k, read its buffers, write others in their place, go on. A
 * kernel of yours so takes the place of one stage in an otherwise unchanged run. examples/hybrid.c. */
#ifndef NEPHOS_WATCH_H
#define NEPHOS_WATCH_H

#include "nephos/stage.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A launch about to run, or just done. Valid within the call that got it, and in its thread. */
typedef struct NphWatched NphWatched;

enum { NPH_WATCHED_ARGUMENTS = 8 };

typedef struct NphWatchedLaunch {
    const char *stage;     /* "path.track" */
    int64_t batch, number; /* number: of the launch within its batch */
    int64_t items;
    int64_t arguments[NPH_WATCHED_ARGUMENTS]; /* in the order of nph_stages_argument */
} NphWatchedLaunch;

/* Called around every launch, by the context's threads at once, each with a batch of its own; the launches of a batch come in order, in
 * one thread. Either may be NULL. A status that is not NPH_OK ends the run with it: NPH_INTERRUPTED leaves a film of what was
 * done. */
typedef struct NphWatch {
    void *user;
    NphStatus (*before)(void *user, NphWatched *watched);
    NphStatus (*after)(void *user, NphWatched *watched);
} NphWatch;

/* nph_render under watch. NPH_BAD_USAGE where the method has no stages to look at. */
NphStatus nph_render_watched(NphContext *context, const NphScene *scene, const NphRenderOptions *options, const NphWatch *watch,
                             NphFilm **film, NphRenderStatistics *statistics);

NphWatchedLaunch nph_watched_launch(const NphWatched *watched);

/* A copy of a buffer as it stands (names, shapes and units: docs/architecture.md, nph_stages_buffer), to be freed by nph_array_free;
 * rank 0 where this scene has none. NPH_BAD_USAGE: no such buffer. */
NphStatus nph_watched_read(NphWatched *watched, const char *buffer, NphArray *array);

/* Puts an array in a buffer's place: its shape, but for the last axis, and its type (f32 for f64 and the other way round will
 * do), else NPH_BAD_INPUT. What later launches of the batch read is then looked through before each of them: values that are no paths,
 * media or surfaces end the run with NPH_BAD_INPUT. */
NphStatus nph_watched_write(NphWatched *watched, const char *buffer, const NphArray *array);

#ifdef __cplusplus
}
#endif
#endif
