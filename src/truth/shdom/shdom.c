/* SPDX-License-Identifier: Apache-2.0
 *
 * truth/shdom as a method: its knobs and stages, the solution and then the tiles, statistics and replay. */
#include "truth/shdom/shdom.h"

#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"

static const NphKnob knobs[NPH_SHDOM_KNOBS] = {
    {"shdom.cells", "1", "cells along the longest edge of the medium; others near to cubes", "accuracy against time and memory", 32.0, 1.0, 4096.0},
    {"shdom.cells_x", "1", "cells along x of the medium's box; 0: as shdom.cells says", "accuracy against time and memory", 0.0, 0.0, 4096.0},
    {"shdom.cells_y", "1", "cells along y", "accuracy against time and memory", 0.0, 0.0, 4096.0},
    {"shdom.cells_z", "1", "cells along z", "accuracy against time and memory", 0.0, 0.0, 4096.0},
    {"shdom.bands", "1", "degrees of spherical harmonics, from 0 on", "ringing and blur against time", 6.0, 1.0, NPH_SHDOM_BANDS_MAX},
    {"shdom.polar", "1", "polar angles of the ordinates, even; 0: two a band", "accuracy against time", 0.0, 0.0, NPH_SHDOM_POLAR_MAX},
    {"shdom.azimuths", "1", "azimuths of the ordinates; 0: two a band", "accuracy against time", 0.0, 0.0, NPH_SHDOM_AZIMUTHS_MAX},
    {"shdom.cubic", "1", "radiance between points: 1: by polynomials of third degree; 0: linear, which spreads it sideways", "blur against ringing", 1.0, 0.0, 1.0},
    {"shdom.thin", "1", "optical depth of a step through a cell at which its mean radiance comes half from its corners, half from what passes its faces",
     "noise against light that is lost", 0.0625, 1e-3, 10.0},
    {"shdom.delta_m", "1", "1: the peak of the phase function goes on unscattered [Wiscombe77]; 0: it is cut off", "bias", 1.0, 0.0, 1.0},
    {"shdom.single", "1", "1: suns and points scattered once by quadrature with the whole phase function [Nakajima88]; 0: from the grid",
     "accuracy against time", 1.0, 0.0, 1.0},
    {"shdom.prefilter", "1", "window over the bands of the source function: 0: none; 1: Hann; 2: Lanczos; 3: Gaussian", "ringing against blur", 0.0, 0.0, 3.0},
    {"shdom.width", "1", "degree at which the window is 0 (the Gaussian e^-2); 0: as many as bands", "ringing against blur", 0.0, 0.0, 1024.0},
    {"shdom.tolerance", "1", "the solution stands when an iteration changes the source function by less, relative to it", "accuracy against time", 1e-4,
     1e-12, 1.0},
    {"shdom.iterations", "1", "most iterations; a run that ends there says so", "accuracy against time", 200.0, 1.0, 1e6},
    {"shdom.history", "1", "sources that the next one is mixed of; 1: the plain iteration", "memory against time", 6.0, 1.0, NPH_SHDOM_HISTORY_MAX},
    {"shdom.quadrature", "1", "tolerance of single scattering by quadrature, as single.tolerance", "accuracy against time", 1e-3, 1e-9, 0.1},
    {"shdom.gather", "1", "polar angles of a sensor that gathers, of each hemisphere; twice as many azimuths", "accuracy against time", 8.0, 1.0,
     NPH_SHDOM_GATHER_MAX},
};

#define ITERATED "shdom.source shdom.history shdom.gram"
#define TILE {NPH_SHDOM_BATCH, 1, 1}

const NphStage nph_shdom_stages[NPH_SHDOM_STAGES] = {
    {"shdom.properties", "mean over a cell", "", "shdom.density", {NPH_SHDOM_BLOCK, 1, 1}, 0},
    {"shdom.direct", "Beer's law; harmonics of a beam [Evans98]", "shdom.density", "shdom.beam shdom.share shdom.sun shdom.sun_mean shdom.border", {NPH_SHDOM_BLOCK, 1, 1}, 0},
    {"shdom.sweep", "short characteristics [Kunasz88]", "shdom.density shdom.beam shdom.share shdom.sun shdom.sun_mean shdom.border shdom.source", "shdom.radiance shdom.mean", {1, 1, 1}, 0},
    {"shdom.moments", "discrete ordinates to harmonics [Evans98]", "shdom.radiance shdom.mean shdom.moments", "shdom.moments", {NPH_SHDOM_BLOCK, 1, 1}, 0},
    {"shdom.first", "source function [Evans98]", "shdom.moments shdom.source", "shdom.first shdom.source", {NPH_SHDOM_BLOCK, 1, 1}, 0},
    {"shdom.scatter", "source function [Evans98]; delta-M [Wiscombe77]", "shdom.first shdom.moments", "shdom.scattered", {NPH_SHDOM_BLOCK, 1, 1}, 0},
    {"shdom.accelerate", "mixing of iterates [Anderson65]", "shdom.scattered " ITERATED, ITERATED " shdom.residual", {NPH_SHDOM_BLOCK, 1, 1}, 0},
    {"shdom.finish", "transposition", "shdom.source shdom.beam", "shdom.field shdom.bubble", {NPH_SHDOM_BLOCK, 1, 1}, 0},
    {"shdom.generate", "camera rays of path", "", "shdom.ray", TILE, 0},
    {"shdom.march", "source function along a ray [Evans98]; TMS [Nakajima88]", "shdom.share shdom.field shdom.bubble shdom.ray", "shdom.sample", TILE, 0},
    {"shdom.accumulate", "moments in a dyadic tree [Chan79] [Pebay08]", "shdom.sample", "film.node", {NPH_TILE_PIXELS, 1, 1}, 0},
};

static const char *const arguments[NPH_SHDOM_ARGUMENTS] = {"channel", "iteration", "group", "tile", "chunk"};

static int channels(const NphJob *job) {
    NphTransportChoice choice;
    nph_transport_choose(job->scene, job->plan_full, &choice);
    return choice.film_channels;
}

static void close_shdom(void *opaque) {
    NphShdomState *state = opaque;
    if (!state) return;
    NphContext *context = state->job.context;
    for (int w = 0; state->workers && w < state->threads; w++) {
        nph_free(context, state->workers[w].rays);
        nph_free(context, state->workers[w].samples);
        nph_free(context, state->workers[w].memory);
        nph_free(context, state->workers[w].room.look);
        nph_free(context, state->workers[w].film_scratch);
    }
    nph_shdom_solver_close(&state->solver);
    nph_free(context, state->workers);
    nph_free(context, state->scenes);
    nph_free(context, state);
}

/* Twice the scene as single sees it: with its own extinction, and with what delta-M leaves of it. */
static NphStatus open_scenes(NphShdomState *state) {
    NphJob as_single = state->job;
    memset(as_single.knobs, 0, sizeof as_single.knobs);
    as_single.knobs[NPH_SINGLE_KNOB_TOLERANCE] = state->job.knobs[NPH_SHDOM_KNOB_QUADRATURE];
    as_single.knobs[NPH_SINGLE_KNOB_PANELS] = nph_single.knobs[NPH_SINGLE_KNOB_PANELS].value;
    as_single.knobs[NPH_SINGLE_KNOB_MODE] = NPH_SINGLE_KAJIYA;
    NPH_TRY(NPH_NEW(state->job.context, 2, "scenes of the marcher", &state->scenes));
    for (int i = 0; i < 2; i++) nph_single_prepare(&as_single, &state->scenes[i]);
    nph_shdom_scale_scene(&state->choice, &state->scenes[1]);
    return NPH_OK;
}

static NphStatus open_workers(NphShdomState *state) {
    NphContext *context = state->job.context;
    NPH_TRY(NPH_NEW(context, state->threads, "workers", &state->workers));
    for (int w = 0; w < state->threads; w++) {
        NphShdomWorker *worker = &state->workers[w];
        NPH_TRY(NPH_NEW(context, NPH_SHDOM_RAY_ROWS * NPH_SHDOM_BATCH, "rays", &worker->rays));
        NPH_TRY(NPH_NEW(context, NPH_SAMPLE_FIELDS * NPH_SHDOM_BATCH, "samples", &worker->samples));
        NPH_TRY(nph_alloc(context, nph_single_scratch_bytes(1), 1, "pieces and panels of a ray", &worker->memory));
        NPH_TRY(NPH_NEW(context, nph_shdom_look_doubles(&state->choice), "harmonics of a ray", &worker->room.look));
        NPH_TRY(nph_alloc(context, nph_film_scratch_bytes(state->choice.transport.film_channels), 1, "film scratch", &worker->film_scratch));
        nph_single_scratch_layout(worker->memory, 1, &worker->room.scratch);
    }
    return NPH_OK;
}

static NphStatus open_state(NphShdomState *state) {
    NPH_TRY(nph_shdom_choose(&state->job, &state->choice));
    NPH_TRY(open_scenes(state));
    NPH_TRY(open_workers(state));
    NPH_TRY(nph_shdom_solver_open(&state->job, &state->choice, &state->scenes[0], &state->solver));
    double *rules = state->gather_rules;
    int polar = (int)state->job.knobs[NPH_SHDOM_KNOB_GATHER];
    nph_shdom_gauss(polar, rules, rules + NPH_SHDOM_GATHER_MAX);
    state->camera = (NphShdomCamera){&state->choice, &state->scenes[1], state->solver.field, state->solver.share, state->solver.bubble, state->solver.kernels,
                                     polar, rules, rules + NPH_SHDOM_GATHER_MAX};
    return NPH_OK;
}

static NphStatus open_shdom(const NphJob *job, void **out) {
    NphShdomState *state = NULL;
    NPH_TRY(NPH_NEW(job->context, 1, "spherical harmonics discrete ordinates", &state));
    state->job = *job;
    state->threads = nph_context_threads(job->context);
    NphStatus status = open_state(state);
    if (status != NPH_OK) {
        close_shdom(state);
        return status;
    }
    *out = state;
    return NPH_OK;
}

static int64_t items_of(const NphShdomState *state, int worker, NphShdomStage stage) {
    const NphShdomChoice *choice = &state->choice;
    const int *in = state->workers[worker].inside;
    switch (stage) {
    case NPH_SHDOM_PROPERTIES: return choice->grid.cell_count;
    case NPH_SHDOM_SWEEP: return nph_shdom_group_size(choice, state->solver.group);
    case NPH_SHDOM_FIRST:
    case NPH_SHDOM_SCATTER:
    case NPH_SHDOM_ACCELERATE: return nph_shdom_row(choice);
    case NPH_SHDOM_DIRECT:
    case NPH_SHDOM_MOMENTS:
    case NPH_SHDOM_FINISH: return choice->grid.point_count;
    case NPH_SHDOM_ACCUMULATE: return NPH_TILE_PIXELS;
    default: return (int64_t)(in[2] - in[0]) * (in[3] - in[1]) * NPH_CHUNK;
    }
}

static NphStatus step(NphShdomState *state, int worker, NphLaunch *launch, NphShdomStage stage) {
    const NphTap *tap = state->job.tap;
    launch->stage = (int)stage;
    launch->items = items_of(state, worker, stage);
    if (tap) NPH_TRY(tap->before(tap->user, state, worker, launch));
    NPH_TRY(nph_shdom_launch(state, worker, launch));
    if (tap) NPH_TRY(tap->after(tap->user, state, worker, launch));
    launch->number++;
    return NPH_OK;
}

/* Radiance of all ordinates, group by group, and its moments. */
static NphStatus run_ordinates(NphShdomState *state, NphLaunch *launch) {
    NphShdomSolver *solver = &state->solver;
    launch->arguments[NPH_SHDOM_ARG_ITERATION] = solver->iteration;
    for (solver->group = 0; solver->group < nph_shdom_groups(&state->choice); solver->group++) {
        launch->arguments[NPH_SHDOM_ARG_GROUP] = solver->group;
        NPH_TRY(step(state, 0, launch, NPH_SHDOM_SWEEP));
        NPH_TRY(step(state, 0, launch, NPH_SHDOM_MOMENTS));
    }
    launch->arguments[NPH_SHDOM_ARG_GROUP] = solver->group = 0;
    return NPH_OK;
}

/* One channel, until it stands. */
static NphStatus run_channel(NphShdomState *state, NphLaunch *launch, int channel) {
    NphShdomSolver *solver = &state->solver;
    double tolerance = state->job.knobs[NPH_SHDOM_KNOB_TOLERANCE];
    int most = (int)state->job.knobs[NPH_SHDOM_KNOB_ITERATIONS], scatters = state->choice.albedo[channel] > 0.0;
    solver->channel = channel;
    solver->iteration = 0;
    launch->arguments[NPH_SHDOM_ARG_CHANNEL] = channel;
    NPH_TRY(run_ordinates(state, launch));
    NPH_TRY(step(state, 0, launch, NPH_SHDOM_FIRST));
    solver->reached[channel] = 0.0;
    while (scatters && solver->iteration < most) {
        solver->iteration++;
        NPH_TRY(run_ordinates(state, launch));
        NPH_TRY(step(state, 0, launch, NPH_SHDOM_SCATTER));
        NPH_TRY(step(state, 0, launch, NPH_SHDOM_ACCELERATE));
        solver->reached[channel] = solver->residual[0];
        nph_progress(state->job.context, "solving", solver->iteration, most + 1, -1.0);
        if (nph_interrupted(state->job.context)) return NPH_INTERRUPTED;
        if (!(solver->residual[0] > tolerance)) break;
    }
    solver->iterations[channel] = solver->iteration;
    return NPH_OK;
}

static void tell_solution(const NphShdomState *state) {
    const NphShdomSolver *solver = &state->solver;
    double tolerance = state->job.knobs[NPH_SHDOM_KNOB_TOLERANCE];
    for (int c = 0; c < state->choice.channels; c++) {
        nph_info(state->job.context, "shdom: channel %d: %d iterations, the last one changed the source function by %.3g", c, solver->iterations[c],
                 solver->reached[c]);
        if (solver->reached[c] > tolerance)
            nph_warn(state->job.context, "shdom: channel %d did not settle: after %d iterations (shdom.iterations) the source function still "
                     "changes by %.3g, more than %.3g (shdom.tolerance)", c, solver->iterations[c], solver->reached[c], tolerance);
    }
}

static NphStatus run_solution(NphShdomState *state) {
    NphLaunch launch = {.batch = NPH_BATCH_OF_SCENE};
    if (!state->choice.solved) return NPH_OK;
    NPH_TRY(step(state, 0, &launch, NPH_SHDOM_PROPERTIES));
    NPH_TRY(step(state, 0, &launch, NPH_SHDOM_DIRECT));
    for (int c = 0; c < state->choice.channels; c++) NPH_TRY(run_channel(state, &launch, c));
    memset(launch.arguments, 0, sizeof launch.arguments);
    NPH_TRY(step(state, 0, &launch, NPH_SHDOM_FINISH));
    tell_solution(state);
    return NPH_OK;
}

static NphStatus run_batch(NphShdomState *state, int worker, int64_t tile, int64_t chunk) {
    NphLaunch launch = {.batch = chunk * nph_film_tile_count(state->film) + tile};
    launch.arguments[NPH_SHDOM_ARG_TILE] = tile;
    launch.arguments[NPH_SHDOM_ARG_CHUNK] = chunk;
    nph_shdom_begin_batch(state, &state->workers[worker], tile, chunk);
    for (int stage = NPH_SHDOM_GENERATE; stage <= NPH_SHDOM_ACCUMULATE; stage++) NPH_TRY(step(state, worker, &launch, (NphShdomStage)stage));
    nph_film_add_node(state->film, tile, chunk, 64, state->workers[worker].samples, state->workers[worker].film_scratch);
    return NPH_OK;
}

/* A block of the pool: one tile, all chunks of the pass. */
static NphStatus run_tile(void *opaque, int64_t tile, int worker) {
    NphShdomState *state = opaque;
    for (int64_t chunk = state->begin / NPH_CHUNK; chunk < state->end / NPH_CHUNK && !nph_interrupted(state->job.context); chunk++)
        NPH_TRY(run_batch(state, worker, tile, chunk));
    if (worker == 0) { /* the calling thread reports; the others' tiles are estimated from its own */
        state->tiles_done += state->threads;
        double part = (double)state->tiles_done / (double)nph_film_tile_count(state->film), elapsed = nph_seconds() - state->started;
        double done = (double)state->done + (part < 1.0 ? part : 1.0) * (double)(state->end - state->begin);
        nph_progress(state->job.context, "marching", done, (double)state->total, done > 0.0 ? elapsed * ((double)state->total - done) / done : -1.0);
    }
    return NPH_OK;
}

static NphStatus run_shdom(void *opaque, NphFilm *film, int64_t begin, int64_t end, int64_t done, int64_t total) {
    NphShdomState *state = opaque;
    state->film = film;
    if (done == 0) NPH_TRY(run_solution(state));
    if (done == 0) state->started = nph_seconds();
    state->begin = begin;
    state->end = end;
    state->done = done;
    state->total = total;
    state->tiles_done = 0;
    return nph_pool_run(state->job.context, nph_film_tile_count(film), run_tile, state, NULL);
}

/* A channel that did not settle counts with the integrals that did not. */
static void statistics(const void *opaque, NphRenderStatistics *out) {
    const NphShdomState *state = opaque;
    const NphShdomSolver *solver = &state->solver;
    nph_stages_begin(nph_shdom_stages, NPH_SHDOM_STAGES, out);
    for (int w = 0; w < state->threads; w++) {
        const NphSingleTally *tally = nph_single_tally(state->workers[w].room.scratch);
        nph_stages_add(&solver->counts[w], out);
        out->exhausted += tally->walked.exhausted + solver->walked[w].exhausted;
        out->integrals += tally->integrals;
        out->integrand_points += tally->points;
        out->unconverged += tally->unconverged + solver->unsettled[w];
        out->worst_residual = tally->worst > out->worst_residual ? tally->worst : out->worst_residual;
    }
    for (int c = 0; c < state->choice.channels && state->choice.solved; c++) {
        out->integrals++;
        if (!(solver->reached[c] > state->job.knobs[NPH_SHDOM_KNOB_TOLERANCE])) continue;
        out->unconverged++;
        out->worst_residual = solver->reached[c] > out->worst_residual ? solver->reached[c] : out->worst_residual;
    }
}

static NphStatus replay_ray(NphShdomState *state, const int pixel[2], int64_t sample, NphLineFn line, void *user) {
    const RScene *local = &state->scenes[1].local;
    uint32_t number = (uint32_t)pixel[1] * (uint32_t)local->width + (uint32_t)pixel[0];
    NphSingleAsk ask = {number, (uint32_t)sample, line, user};
    double fields[NPH_SAMPLE_FIELDS];
    const NphShdomGrid *grid = &state->choice.grid;
    NPH_TRY(run_solution(state));
    RCameraRay ray = nph_single_ray(local, pixel[0], pixel[1], number, (uint32_t)sample);
    nph_single_tell(&ask, "shdom: pixel %d,%d sample %lld, seed %u, frame %u", pixel[0], pixel[1], (long long)sample, state->job.seed, state->job.frame);
    if (state->choice.solved)
        nph_single_tell(&ask, "  solved on %d x %d x %d cells with %d ordinates: %d iterations, the last one changed it by %.3g", (int)grid->cells[0],
                        (int)grid->cells[1], (int)grid->cells[2], nph_shdom_ordinates(&state->choice.angles), state->solver.iterations[0],
                        state->solver.reached[0]);
    nph_shdom_see(state, 0, &ray, &ask, fields);
    nph_single_tell(&ask, "result: %.17g %.17g %.17g", fields[0], fields[1], fields[2]);
    return NPH_OK;
}

static NphStatus replay(const NphJob *job, int x, int y, int64_t sample, NphLineFn line, void *user) {
    void *opaque = NULL;
    NPH_TRY(open_shdom(job, &opaque));
    NphStatus status = replay_ray(opaque, (int[2]){x, y}, sample, line, user);
    close_shdom(opaque);
    return status;
}

/* What a port needs beside buffers and knobs. */
static NphStatus facts(const NphJob *job, NphFactFn fact, void *user) {
    NphShdomChoice choice;
    NPH_TRY(nph_shdom_choose(job, &choice));
    const NphShdomGrid *grid = &choice.grid;
    if (choice.medium < 0) return NPH_OK;
    fact(user, -1, "shdom_cells", 3, (double[]){grid->cells[0], grid->cells[1], grid->cells[2]});
    fact(user, -1, "shdom_periodic", 3, (double[]){grid->periodic[0], grid->periodic[1], grid->periodic[2]});
    fact(user, -1, "grid_from_local", 12, grid->from_local);
    fact(user, -1, "terms", 1, (double[]){choice.angles.terms});
    fact(user, -1, "polar_cosine", choice.angles.polar, choice.angles.cosine);
    fact(user, -1, "polar_weight", choice.angles.polar, choice.angles.weight);
    fact(user, -1, "azimuths", 1, (double[]){choice.angles.azimuths});
    fact(user, -1, "cut", 1, &choice.angles.cut);
    fact(user, -1, "kept", choice.angles.bands, choice.angles.kept);
    fact(user, -1, "scaled_extinction", 3, choice.extinction);
    fact(user, -1, "scaled_albedo", 3, choice.albedo);
    return NPH_OK;
}

const NphMethod nph_shdom = {
    .name = "shdom",
    .summary = "spherical harmonics and discrete ordinates on a grid, deterministic, with single scattering by quadrature",
    .knobs = knobs,
    .knob_count = NPH_SHDOM_KNOBS,
    .stages = nph_shdom_stages,
    .stage_count = NPH_SHDOM_STAGES,
    .buffers = nph_shdom_buffers,
    .buffer_count = NPH_SHDOM_BUFFERS,
    .plan = nph_shdom_plan,
    .channels = channels,
    .open = open_shdom,
    .run = run_shdom,
    .statistics = statistics,
    .close = close_shdom,
    .replay = replay,
    .arguments = arguments,
    .argument_count = NPH_SHDOM_ARGUMENTS,
    .begin_launch = nph_shdom_begin_launch,
    .extend = nph_shdom_extend,
    .view = nph_shdom_view,
    .check = nph_shdom_check,
    .launch = nph_shdom_launch_alone,
    .facts = facts,
};
