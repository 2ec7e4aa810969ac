/* SPDX-License-Identifier: Apache-2.0
 *
 * The public tap: a caller's functions around every launch. */
#include "nephos/watch.h"

#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "method/job.h"
#include "oracle/stages.h"

typedef struct Watcher {
    NphContext *context;
    const NphMethod *method;
    const NphWatch *watch;
    char *written, *held; /* by worker: something was written in the batch under way; since the last launch */
} Watcher;

struct NphWatched {
    Watcher *watcher;
    void *state;
    int worker;
    const NphLaunch *launch;
};

static NphStatus before(void *user, void *state, int worker, const NphLaunch *launch) {
    Watcher *w = user;
    NphWatched watched = {w, state, worker, launch};
    if (launch->number == 0) w->written[worker] = w->held[worker] = 0;
    if (w->watch->before) NPH_TRY(w->watch->before(w->watch->user, &watched));
    w->held[worker] = 0;
    return w->written[worker] ? w->method->check(state, worker, launch) : NPH_OK;
}

static NphStatus after(void *user, void *state, int worker, const NphLaunch *launch) {
    Watcher *w = user;
    NphWatched watched = {w, state, worker, launch};
    return w->watch->after ? w->watch->after(w->watch->user, &watched) : NPH_OK;
}

NphStatus nph_render_watched(NphContext *context, const NphScene *scene, const NphRenderOptions *options, const NphWatch *watch,
                             NphFilm **film, NphRenderStatistics *statistics) {
    Watcher watcher = {.context = context, .watch = watch};
    NphJob job;
    NPH_TRY(nph_job_make(context, scene, options, &watcher.method, &job));
    NPH_TRY(nph_stages_supported(context, watcher.method));
    NPH_TRY(NPH_NEW(context, 2 * nph_context_threads(context), "marks of workers", &watcher.written));
    watcher.held = watcher.written + nph_context_threads(context);
    NphTap tap = {&watcher, before, after};
    NphStatus status = nph_render_tapped(context, scene, options, &tap, film, statistics);
    nph_free(context, watcher.written);
    return status;
}

NphWatchedLaunch nph_watched_launch(const NphWatched *watched) {
    const NphLaunch *launch = watched->launch;
    NphWatchedLaunch told = {watched->watcher->method->stages[launch->stage].name, launch->batch, launch->number, launch->items, {0}};
    for (int a = 0; a < watched->watcher->method->argument_count; a++) told.arguments[a] = launch->arguments[a];
    return told;
}

static NphStatus find(const NphWatched *watched, const char *name, int *buffer) {
    const Watcher *w = watched->watcher;
    *buffer = nph_buffer_find(w->method, name);
    return *buffer >= 0 ? NPH_OK : nph_error(w->context, NPH_BAD_USAGE, "method %s has no buffer %s", w->method->name, name);
}

NphStatus nph_watched_read(NphWatched *watched, const char *name, NphArray *array) {
    int buffer;
    NPH_TRY(find(watched, name, &buffer));
    return nph_buffer_take(watched->watcher->context, watched->watcher->method, watched->state, watched->worker, buffer, array);
}

NphStatus nph_watched_write(NphWatched *watched, const char *name, const NphArray *array) {
    int buffer;
    Watcher *w = watched->watcher;
    int worker = watched->worker;
    NPH_TRY(find(watched, name, &buffer));
    if (!w->held[worker] && w->method->hold) w->method->hold(watched->state, worker);
    w->written[worker] = w->held[worker] = 1;
    return nph_buffer_place(w->context, w->method, watched->state, worker, buffer, array);
}
