/* SPDX-License-Identifier: Apache-2.0
 *
 * method/principal_ordinates as a method: its knobs and stages, the run over samples, statistics and replay. */
#include "method/principal_ordinates/pop.h"

#include <stdio.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"

static const NphKnob knobs[NPH_POP_KNOBS] = {
    {"pop.variant", "1", "0: corrected, from the transport equation; 1: paper, the formulas as printed", "nothing: to compare", 0.0, 0.0, 1.0},
    {"pop.ordinates", "1", "directions that the sky, but its suns, is cut into", "bias of directions against time", 64.0, 1.0, NPH_POP_ORDINATES_MAX},
    {"pop.cells", "1", "cells of a grid across its light", "blur against time", 20.0, 1.0, 512.0},
    {"pop.along", "1", "cells of a grid along its light; 0: as many as across", "blur against time", 0.0, 0.0, 512.0},
    {"pop.radial", "1", "shells of a point's grid, and cells of them along an edge of the octahedral map, made even", "blur against time", 8.0, 1.0, 256.0},
    {"pop.inner", "1", "radius of the innermost shell of a point in the medium, over that of the outermost", "blur near the point against cells", 0.02, 1e-4, 0.5},
    {"pop.vpls", "1", "virtual point lights of surfaces", "bias of reflected light against time", 125.0, 0.0, NPH_POP_VPLS_MAX},
    {"pop.vpl_cells", "1", "shells of their grids, and cells of them along an edge of the octahedral map, made even", "blur against time", 8.0, 1.0, 256.0},
    {"pop.rsm", "1", "texels of a reflective shadow map along an edge", "coarse surfaces against time", 32.0, 1.0, 1024.0},
    {"pop.clamp", "1", "part of a virtual point light's area that its pole is spread over", "bright spots against dark corners", 1.0, 0.0, 100.0},
    {"pop.shadows", "1", "rays along an edge of a cell that look for its shadows; 0: surfaces do not shade the medium", "hard steps against time", 2.0, 0.0, 16.0},
    {"pop.iterations", "1", "of the propagation; 0: until it is isotropic to pop.epsilon_a, at least the cells along a grid", "lost light against time", 20.0,
     0.0, NPH_POP_ITERATIONS_MAX},
    {"pop.epsilon_a", "1", "mean cosine below which light counts as isotropic, where iterations are 0", "bias against time", 0.1, 1e-6, 1.0},
    {"pop.epsilon_l", "1", "light over what was injected below which a grid stands still", "lost light against time", 1e-3, 0.0, 1.0},
    {"pop.paths", "1", "corrected: 1: isotropic light has the path in a cell that diffusion has; 0: a cell's edge", "bias of thin and of thick cells", 1.0, 0.0, 1.0},
    {"pop.regions", "1", "1: an ordinate has the mean direction and all the light of its region; 0: it is drawn in it", "noise of directions", 0.0, 0.0, 1.0},
    {"pop.prefilter", "1", "mean cosine of what an ordinate stands for: 0: 1; 1: of a cap; 2: of its region", "spots against blur", 1.0, 0.0, 2.0},
    {"pop.beta", "1", "exponent of that of a cap", "spots against blur", 1.0, 0.0, 100.0},
    {"pop.importance", "1", "1: ordinates also go where the camera's importance does", "bias of directions against time", 1.0, 0.0, 1.0},
    {"pop.frames", "1", "frames whose importance is averaged, this one the last", "flicker against late importance", 1.0, 1.0, 64.0},
    {"pop.residuum", "1", "1: light that the iterations leave goes on as isotropic light of one grid; 0: it is lost", "lost light against time", 1.0, 0.0, 1.0},
    {"pop.residuum_cells", "1", "cells of that grid along the mean edge of the medium", "blur against time", 32.0, 1.0, 512.0},
    {"pop.residuum_iterations", "1", "most iterations of it", "lost light against time", 100.0, 0.0, NPH_POP_ITERATIONS_MAX},
    {"pop.merged", "1", "resolution of what all grids show together, over that of a grid", "blur against time", 2.0, 0.25, 16.0},
    {"pop.mips", "1", "1: grids take a density of their resolution; 0: of the file's", "aliasing", 1.0, 0.0, 1.0},
    {"pop.upsampling", "1", "1: to the resolution of the density, which guides it; 0: linear", "blur against time", 1.0, 0.0, 1.0},
    {"pop.spread_density", "1", "standard deviation of that guide, over the largest density", "blur against noise", 0.1, 0.001, 10.0},
    {"pop.steps", "1", "steps of the march along the diagonal of the box", "bias against time", 300.0, 1.0, 1e6},
    {"pop.exit", "1", "a ray ends when its transmittance falls below this", "bias against time", 0.005, 0.0, 1.0},
};

#define SOLUTION "pop.light pop.cosine pop.seen pop.power"

const NphStage nph_pop_stages[NPH_POP_STAGES] = {
    {"pop.medium", "downscaled medium [Elek14 sec. 4.2]", "", "pop.medium", {64, 1, 1}, 0},
    {"pop.importance", "importance of directions [Elek14 sec. 5.2]", "pop.medium", "pop.importance", {16, 16, 16}, 0},
    {"pop.ordinates", "sampling and prefiltering [Elek14 sec. 5.1]", "pop.importance", "pop.ordinate", {1, 1, 1}, 0},
    {"pop.reflect", "reflective shadow maps [Dachsbacher05] [Elek14 sec. 6]", "pop.medium pop.ordinate", "pop.rsm", {64, 1, 1}, 0},
    {"pop.vpls", "virtual point lights [Keller97] [Elek14 sec. 6]", "pop.rsm pop.ordinate", "pop.ordinate", {1, 1, 1}, 0},
    {"pop.grids", "densities of cells [Elek14 sec. 4.1]", "pop.ordinate pop.medium", "pop.density", {64, 1, 1}, 0},
    {"pop.shadows", "shadow maps [Elek14 sec. 6]", "pop.ordinate", "pop.lit", {64, 1, 1}, 0},
    {"pop.inject", "injection in one sweep [Elek14 sec. 4.1]", "pop.ordinate pop.density pop.lit", SOLUTION, {64, 1, 1}, 0},
    {"pop.propagate", "propagation and accumulation [Elek14 eq. 1-8]", "pop.ordinate pop.density " SOLUTION, SOLUTION, {64, 1, 1}, 0},
    {"pop.join", "isotropic residuum [Elek14 sec. 5.4]", "pop.medium pop.ordinate pop.light pop.power", "pop.residuum pop.spread", {64, 1, 1}, 0},
    {"pop.spread", "isotropic propagation [Elek14 sec. 5.4]", "pop.medium pop.residuum pop.spread", "pop.residuum pop.spread", {64, 1, 1}, 0},
    {"pop.gather", "one grid of virtual points [Elek14 sec. 5.3]", "pop.ordinate pop.seen", "pop.gathered", {64, 1, 1}, 0},
    {"pop.merge", "one grid of all [Elek14 sec. 5.3]", "pop.medium pop.ordinate pop.seen pop.spread pop.gathered", "pop.merged", {64, 1, 1}, 0},
    {"pop.upsample", "joint bilateral upsampling [Elek14 sec. 4.4] [Kopf07]", "pop.merged", "pop.fine", {64, 1, 1}, 0},
    {"pop.march", "ray march [Elek14 sec. 4.4]", "pop.merged pop.fine pop.medium pop.ordinate", "pop.sample", {NPH_TILE_PIXELS, 1, 1}, 0},
    {"pop.accumulate", "moments in a dyadic tree [Chan79] [Pebay08]", "pop.sample", "film.node", {NPH_TILE_PIXELS, 1, 1}, 0},
};

static const char *const arguments[NPH_POP_ARGUMENTS] = {"iteration", "tile", "chunk"};

static int channels(const NphJob *job) {
    NphTransportChoice choice;
    nph_transport_choose(job->scene, job->plan_full, &choice);
    return choice.film_channels;
}

static void close_pop(void *opaque) {
    NphPopState *state = opaque;
    if (!state) return;
    NphContext *context = state->solver.job.context;
    for (int w = 0; state->workers && w < state->solver.threads; w++) {
        nph_free(context, state->workers[w].samples);
        nph_free(context, state->workers[w].film_scratch);
    }
    nph_free(context, state->workers);
    nph_pop_solver_close(&state->solver);
    nph_free(context, state);
}

static NphStatus open_workers(NphPopState *state) {
    NphPopSolver *solver = &state->solver;
    NphContext *context = solver->job.context;
    NPH_TRY(NPH_NEW(context, solver->threads, "workers", &state->workers));
    for (int w = 0; w < solver->threads; w++) {
        void *scratch = NULL;
        NPH_TRY(nph_alloc(context, (size_t)NPH_TILE_PIXELS * NPH_CHUNK * NPH_SAMPLE_FIELDS, (size_t)solver->job.precision / 8, "samples of a tile",
                          &state->workers[w].samples));
        NPH_TRY(nph_alloc(context, nph_film_scratch_bytes(solver->choice.transport.film_channels), 1, "film scratch", &scratch));
        state->workers[w].film_scratch = scratch;
    }
    return NPH_OK;
}

static NphStatus open_pop(const NphJob *job, void **out) {
    NphPopState *state = NULL;
    NPH_TRY(NPH_NEW(job->context, 1, "principal ordinates", &state));
    state->solver.job.context = job->context;
    NphStatus status = nph_pop_solver_open(job, &state->solver);
    if (status == NPH_OK) status = open_workers(state);
    if (status != NPH_OK) {
        close_pop(state);
        return status;
    }
    *out = state;
    return NPH_OK;
}

static NphStatus march_tile(NphPopState *state, int index, const NphLaunch *launch) {
    NphPopSolver *solver = &state->solver;
    NphPopWorker *worker = &state->workers[index];
    int64_t steps = 0;
    int origin[2], inside[4];
    nph_film_tile_rect(state->film, launch->arguments[NPH_POP_ARG_TILE], origin, inside);
    NPH_LAUNCH(&solver->stages[index], NPH_POP_MARCH, launch->items,
               solver->kernels.march(solver->scene, &solver->arrays, inside, launch->arguments[NPH_POP_ARG_CHUNK], worker->samples, &steps));
    worker->steps += steps;
    return NPH_OK;
}

NphStatus nph_pop_launch(NphPopState *state, int index, const NphLaunch *launch) {
    NphPopSolver *solver = &state->solver;
    NphPopWorker *worker = &state->workers[index];
    if (launch->stage == NPH_POP_MARCH) return march_tile(state, index, launch);
    if (launch->stage == NPH_POP_ACCUMULATE) {
        NPH_LAUNCH(&solver->stages[index], NPH_POP_ACCUMULATE, launch->items,
                   nph_film_chunk(state->film, solver->job.precision, worker->samples, worker->film_scratch));
        return NPH_OK;
    }
    if (launch->stage == NPH_POP_PROPAGATE && solver->iteration >= 0) solver->iteration = (int)launch->arguments[NPH_POP_ARG_ITERATION];
    return nph_pop_step(solver, (NphPopStage)launch->stage);
}

static int64_t items_of(const NphPopState *state, NphPopStage stage) {
    const NphPopChoice *choice = &state->solver.choice;
    switch (stage) {
    case NPH_POP_MEDIUM: return nph_pop_cells(choice->mips);
    case NPH_POP_IMPORTANCE: return NPH_POP_MAP_WIDTH * NPH_POP_MAP_HEIGHT;
    case NPH_POP_ORDINATES: return nph_pop_grids(choice);
    case NPH_POP_REFLECT: return (int64_t)nph_pop_lamps(choice) * choice->rsm * choice->rsm;
    case NPH_POP_VPLS: return choice->vpls;
    case NPH_POP_GRIDS:
    case NPH_POP_SHADOWS:
    case NPH_POP_INJECT:
    case NPH_POP_PROPAGATE: return nph_pop_first(choice, nph_pop_grids(choice), 1);
    case NPH_POP_JOIN:
    case NPH_POP_SPREAD: return nph_pop_cells(choice->joined);
    case NPH_POP_GATHER: return nph_pop_cells(choice->gathered);
    case NPH_POP_MERGE: return nph_pop_cells(choice->merged);
    case NPH_POP_UPSAMPLE: return nph_pop_cells(choice->fine);
    case NPH_POP_MARCH: return (int64_t)NPH_TILE_PIXELS * NPH_CHUNK;
    default: return NPH_TILE_PIXELS;
    }
}

static NphStatus step(NphPopState *state, int worker, NphLaunch *launch, NphPopStage stage) {
    const NphTap *tap = state->solver.job.tap;
    launch->stage = (int)stage;
    launch->items = items_of(state, stage);
    if (tap) NPH_TRY(tap->before(tap->user, state, worker, launch));
    NPH_TRY(nph_pop_launch(state, worker, launch));
    if (tap) NPH_TRY(tap->after(tap->user, state, worker, launch));
    launch->number++;
    return NPH_OK;
}

/* Iterations one by one where somebody looks on, all of a grid together where not: the same bytes. */
static NphStatus propagate(NphPopState *state, NphLaunch *launch) {
    NphPopSolver *solver = &state->solver;
    int all = solver->choice.iterations > 0 ? solver->choice.iterations : solver->kernels.iterations(solver->scene, solver->arrays.ordinate);
    solver->iteration = solver->job.tap ? 0 : -1;
    for (int m = 0; m < (solver->job.tap ? all : 1); m++) {
        launch->arguments[NPH_POP_ARG_ITERATION] = m;
        NPH_TRY(step(state, 0, launch, NPH_POP_PROPAGATE));
    }
    return NPH_OK;
}

static NphStatus spread(NphPopState *state, NphLaunch *launch) {
    NphPopSolver *solver = &state->solver;
    double joined = solver->kernels.left(solver->scene, &solver->arrays, 0);
    int most = (int)solver->job.knobs[NPH_POP_KNOB_RESIDUUM_ITERATIONS];
    for (int m = 0; m < most && nph_pop_spreads(solver, joined); m++) {
        launch->arguments[NPH_POP_ARG_ITERATION] = m;
        NPH_TRY(step(state, 0, launch, NPH_POP_SPREAD));
    }
    return NPH_OK;
}

/* Once for all samples. */
static NphStatus solve(NphPopState *state) {
    NphLaunch launch = {.batch = NPH_BATCH_OF_SCENE};
    for (int stage = NPH_POP_MEDIUM; stage <= NPH_POP_UPSAMPLE; stage++) {
        NphPopSolver *solver = &state->solver;
        if (!nph_pop_has(solver, (NphPopStage)stage)) continue;
        launch.arguments[NPH_POP_ARG_ITERATION] = 0;
        if (stage == NPH_POP_PROPAGATE) NPH_TRY(propagate(state, &launch));
        else if (stage == NPH_POP_SPREAD) NPH_TRY(spread(state, &launch));
        else NPH_TRY(step(state, 0, &launch, (NphPopStage)stage));
        if (nph_interrupted(solver->job.context)) return NPH_INTERRUPTED;
    }
    return NPH_OK;
}

static NphStatus run_chunk(NphPopState *state, int index, int64_t tile, int64_t chunk) {
    NphPopWorker *worker = &state->workers[index];
    NphLaunch launch = {.batch = chunk * nph_film_tile_count(state->film) + tile, .arguments = {0, tile, chunk}};
    NPH_TRY(step(state, index, &launch, NPH_POP_MARCH));
    NPH_TRY(step(state, index, &launch, NPH_POP_ACCUMULATE));
    nph_film_add_node(state->film, tile, chunk, state->solver.job.precision, worker->samples, worker->film_scratch);
    return NPH_OK;
}

/* A block of the pool: one tile, all chunks of the pass. */
static NphStatus run_tile(void *opaque, int64_t tile, int index) {
    NphPopState *state = opaque;
    NphContext *context = state->solver.job.context;
    for (int64_t chunk = state->begin / NPH_CHUNK; chunk < state->end / NPH_CHUNK && !nph_interrupted(context); chunk++)
        NPH_TRY(run_chunk(state, index, tile, chunk));
    if (index == 0) { /* the calling thread reports; the others' tiles are estimated from its own */
        state->tiles_done += state->solver.threads;
        double part = (double)state->tiles_done / (double)nph_film_tile_count(state->film);
        part = part < 1.0 ? part : 1.0;
        double done = (double)state->done + part * (double)(state->end - state->begin), elapsed = nph_seconds() - state->started;
        nph_progress(context, "marching", done, (double)state->total, done > 0.0 ? elapsed * ((double)state->total - done) / done : -1.0);
    }
    return NPH_OK;
}

static NphStatus run_pop(void *opaque, NphFilm *film, int64_t begin, int64_t end, int64_t done, int64_t total) {
    NphPopState *state = opaque;
    state->film = film;
    state->begin = begin;
    state->end = end;
    state->done = done;
    state->total = total;
    state->tiles_done = 0;
    if (done == 0) {
        NPH_TRY(solve(state));
        state->started = nph_seconds();
    }
    return nph_pool_run(state->solver.job.context, nph_film_tile_count(film), run_tile, state, NULL);
}

static void statistics(const void *opaque, NphRenderStatistics *out) {
    const NphPopState *state = opaque;
    nph_stages_begin(nph_pop_stages, NPH_POP_STAGES, out);
    for (int w = 0; w < state->solver.threads; w++) {
        nph_stages_add(&state->solver.stages[w], out);
        out->tentative += state->workers[w].steps;
    }
}

static void tell_grids(const NphPopSolver *s, NphLineFn line, void *user) {
    char text[256];
    double injected = 0.0, left = 0.0;
    int rows = nph_pop_grids(&s->choice) * s->choice.channels;
    for (int i = 0; i < rows; i++) {
        injected += s->arrays.power[i * NPH_POP_POWERS + NPH_POP_INJECTED];
        left += s->arrays.power[i * NPH_POP_POWERS + NPH_POP_LEFT];
    }
    snprintf(text, sizeof text, "  grids: %d of suns, %d of the sky, %d of points, %d of surfaces; iterations: %d; left of what was injected: %.4g", s->choice.suns,
             s->choice.sky, s->choice.points, s->choice.vpls, s->iterations, injected > 0.0 ? left / injected : 0.0);
    line(user, text);
}

static NphStatus replay(const NphJob *job, int x, int y, int64_t sample, NphLineFn line, void *user) {
    void *opaque = NULL;
    char text[128];
    NPH_TRY(open_pop(job, &opaque));
    NphPopState *state = opaque;
    NphStatus status = solve(state);
    snprintf(text, sizeof text, "principal_ordinates: pixel %d,%d sample %lld, frame %u", x, y, (long long)sample, (unsigned)job->frame);
    line(user, text);
    if (status == NPH_OK) {
        tell_grids(&state->solver, line, user);
        state->solver.kernels.replay(state->solver.scene, &state->solver.arrays, (int[]){x, y}, (uint32_t)sample, line, user);
    }
    close_pop(state);
    return status;
}

static NphStatus facts(const NphJob *job, NphFactFn fact, void *user) {
    NphPopSolver solver;
    NPH_TRY(nph_pop_solver_open(job, &solver));
    solver.kernels.facts(solver.scene, fact, user);
    nph_pop_solver_close(&solver);
    return NPH_OK;
}

static NphStatus launch_alone(void *opaque, int worker, const NphLaunch *launch) { return nph_pop_launch(opaque, worker, launch); }

const NphMethod nph_principal_ordinates = {
    .name = "principal_ordinates",
    .summary = "principal-ordinates propagation: light in grids along its main directions, one lobe a cell (biased)",
    .knobs = knobs,
    .knob_count = NPH_POP_KNOBS,
    .stages = nph_pop_stages,
    .stage_count = NPH_POP_STAGES,
    .buffers = nph_pop_buffers,
    .buffer_count = NPH_POP_BUFFERS,
    .plan = nph_pop_plan,
    .channels = channels,
    .open = open_pop,
    .run = run_pop,
    .statistics = statistics,
    .close = close_pop,
    .replay = replay,
    .arguments = arguments,
    .argument_count = NPH_POP_ARGUMENTS,
    .begin_launch = nph_pop_begin_launch,
    .extend = nph_pop_extend,
    .view = nph_pop_view,
    .check = nph_pop_check,
    .launch = launch_alone,
    .facts = facts,
};
