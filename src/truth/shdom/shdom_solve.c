/* SPDX-License-Identifier: Apache-2.0
 *
 * The solution's memory, and its stages on the pool: ordinates of a group side by side, or blocks of points, cells or coefficients. What
 * a block writes is its own, and sums run over ordinates and blocks in their order, so threads change nothing. */
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"
#include "truth/shdom/shdom.h"

int nph_shdom_groups(const NphShdomChoice *choice) {
    return (nph_shdom_ordinates(&choice->angles) + NPH_SHDOM_GROUP - 1) / NPH_SHDOM_GROUP;
}

int nph_shdom_group_size(const NphShdomChoice *choice, int group) {
    int left = nph_shdom_ordinates(&choice->angles) - group * NPH_SHDOM_GROUP;
    return left < NPH_SHDOM_GROUP ? left : NPH_SHDOM_GROUP;
}

int64_t nph_shdom_row(const NphShdomChoice *choice) { return choice->grid.point_count * choice->angles.terms + choice->grid.cell_count; }

int64_t nph_shdom_blocks(int64_t items) { return (items + NPH_SHDOM_BLOCK - 1) / NPH_SHDOM_BLOCK; }

/* Elements of the arrays of the precision's numbers. */
typedef struct Sizes {
    size_t cells, points, rows, worker, beams, dots;
} Sizes;

static Sizes sizes_of(const NphShdomChoice *choice) {
    const NphShdomGrid *grid = &choice->grid;
    int64_t plane = 0, row = 0;
    for (int a = 0; a < 3; a++) {
        plane = grid->point_count / grid->points[a] > plane ? grid->point_count / grid->points[a] : plane;
        row = grid->points[a] > row ? grid->points[a] : row;
    }
    Sizes sizes = {(size_t)grid->cell_count, (size_t)grid->point_count, (size_t)nph_shdom_row(choice), (size_t)(grid->point_count + plane + 2 * row + 8),
                   (size_t)(grid->point_count * choice->angles.terms), 0};
    sizes.dots = (size_t)nph_shdom_blocks((int64_t)sizes.rows) * (size_t)(choice->history + 2);
    return sizes;
}

uint64_t nph_shdom_solver_bytes(const NphJob *job, const NphShdomChoice *choice, int threads) {
    if (!choice->solved) return 0;
    Sizes s = sizes_of(choice);
    uint64_t real = (uint64_t)job->precision / 8, channels = (uint64_t)choice->channels, ordinates = (uint64_t)nph_shdom_ordinates(&choice->angles);
    uint64_t reals = s.cells * (4 + 2 * channels) + (uint64_t)choice->sun_count * (channels * s.cells + s.points) + channels * ordinates + s.rows * (channels + 3 + 2 * (uint64_t)choice->history) +
                     s.beams * channels * (uint64_t)(2 + choice->looks) + (s.points + s.cells) * NPH_SHDOM_GROUP + (uint64_t)threads * s.worker;
    uint64_t doubles = s.dots + NPH_SHDOM_GROUP * (uint64_t)choice->angles.terms +
                       (uint64_t)threads * channels * (uint64_t)choice->angles.terms * NPH_SHDOM_BLOCK;
    return reals * real + doubles * sizeof(double);
}

static NphStatus reals(NphShdomSolver *solver, size_t count, const char *what, void **out) {
    return nph_alloc(solver->context, count, (size_t)solver->precision / 8, what, out);
}

static NphStatus open_arrays(NphShdomSolver *solver) {
    const NphShdomChoice *choice = solver->choice;
    Sizes s = sizes_of(choice);
    size_t channels = (size_t)choice->channels, history = (size_t)choice->history;
    NPH_TRY(reals(solver, s.cells, "density of cells", &solver->density));
    NPH_TRY(reals(solver, s.cells, "ones", &solver->ones));
    NPH_TRY(reals(solver, s.cells * channels, "share of cells", &solver->share));
    NPH_TRY(reals(solver, s.points * (size_t)choice->sun_count, "suns at points", &solver->sun));
    NPH_TRY(reals(solver, s.cells * channels * (size_t)choice->sun_count, "suns in cells", &solver->sun_mean));
    NPH_TRY(reals(solver, channels * (size_t)nph_shdom_ordinates(&choice->angles), "light at the border", &solver->border));
    NPH_TRY(reals(solver, s.beams * channels, "first scattering of beams", &solver->beam));
    NPH_TRY(reals(solver, s.rows * channels, "source function", &solver->source));
    NPH_TRY(reals(solver, s.rows, "moments", &solver->moments));
    NPH_TRY(reals(solver, s.rows, "moments of what was scattered once", &solver->first));
    NPH_TRY(reals(solver, s.rows, "scattered", &solver->scattered));
    NPH_TRY(reals(solver, s.rows * 2 * history, "earlier sources", &solver->history));
    NPH_TRY(reals(solver, s.points * NPH_SHDOM_GROUP, "radiance of a group", &solver->radiance));
    NPH_TRY(reals(solver, s.beams * channels * (size_t)(1 + choice->looks), "source function by point", &solver->field));
    NPH_TRY(reals(solver, s.cells * NPH_SHDOM_GROUP, "mean radiance of a group", &solver->mean));
    NPH_TRY(reals(solver, s.cells * channels, "bubbles", &solver->bubble));
    NPH_TRY(reals(solver, s.cells, "bubbles of a channel", &solver->bubble_now));
    NPH_TRY(reals(solver, s.cells, "no bubbles", &solver->nothing));
    NPH_TRY(NPH_NEW(solver->context, history * history, "products of changes", &solver->gram));
    NPH_TRY(NPH_NEW(solver->context, s.dots, "products by block", &solver->partial));
    NPH_TRY(NPH_NEW(solver->context, NPH_SHDOM_GROUP * choice->angles.terms, "weights of a group", &solver->factors));
    return NPH_NEW(solver->context, 1, "residual", &solver->residual);
}

static NphStatus open_workers(NphShdomSolver *solver) {
    const NphShdomChoice *choice = solver->choice;
    int threads = nph_context_threads(solver->context);
    Sizes s = sizes_of(choice);
    NPH_TRY(NPH_NEW(solver->context, threads, "sources of ordinates", &solver->projected));
    NPH_TRY(NPH_NEW(solver->context, threads, "rows", &solver->rows));
    for (int w = 0; w < threads; w++) {
        NPH_TRY(reals(solver, s.worker, "source of an ordinate", &solver->projected[w]));
        NPH_TRY(NPH_NEW(solver->context, choice->channels * choice->angles.terms * NPH_SHDOM_BLOCK, "rows of a block", &solver->rows[w]));
    }
    return NPH_OK;
}

NphStatus nph_shdom_solver_open(const NphJob *job, const NphShdomChoice *choice, const NphSingleScene *scene, NphShdomSolver *solver) {
    int threads = nph_context_threads(job->context);
    memset(solver, 0, sizeof *solver);
    solver->context = job->context;
    solver->precision = job->precision;
    solver->choice = choice;
    solver->scene = scene;
    nph_shdom_kernels(nph_context_isa(job->context), job->precision, &solver->kernels);
    NPH_TRY(NPH_NEW(job->context, threads, "counts of stages", &solver->counts));
    NPH_TRY(NPH_NEW(job->context, threads, "counts of voxels", &solver->walked));
    NPH_TRY(NPH_NEW(job->context, threads, "counts of sweeps", &solver->unsettled));
    if (!choice->solved) return NPH_OK;
    NPH_TRY(open_arrays(solver));
    NPH_TRY(open_workers(solver));
    for (int64_t i = 0; i < choice->grid.cell_count; i++) solver->kernels.store((double[1]){1.0}, 1, (char *)solver->ones + i * (job->precision / 8));
    return NPH_OK;
}

void nph_shdom_solver_close(NphShdomSolver *solver) {
    NphContext *context = solver->context;
    if (!context) return;
    void *const arrays[] = {solver->density, solver->ones, solver->share, solver->border, solver->beam, solver->source, solver->moments,
                            solver->first, solver->scattered, solver->history, solver->radiance, solver->field, solver->gram, solver->partial,
                            solver->factors, solver->sun, solver->sun_mean, solver->mean, solver->bubble, solver->bubble_now, solver->nothing, solver->residual, solver->counts, solver->walked, solver->unsettled};
    for (int w = 0; w < nph_context_threads(context); w++) {
        if (solver->projected) nph_free(context, solver->projected[w]);
        if (solver->rows) nph_free(context, solver->rows[w]);
    }
    nph_free(context, solver->projected);
    nph_free(context, solver->rows);
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++) nph_free(context, arrays[i]);
}

static void *row_of(const NphShdomSolver *solver, void *array, int64_t row, int64_t length) {
    return (char *)array + (size_t)(row * length) * ((size_t)solver->precision / 8);
}

/* What each sun scatters into an ordinate. */
static void set_beams(const NphShdomSolver *solver, const double d[3], NphShdomSweep *sweep) {
    const NphShdomChoice *choice = solver->choice;
    const NphShdomGrid *grid = &choice->grid;
    int c = solver->channel;
    sweep->beam_count = choice->sun_count;
    for (int n = 0; n < choice->sun_count; n++) {
        const double *to = solver->scene->local.lights[choice->suns[n]].direction;
        double cosine = -(d[0] * to[0] + d[1] * to[1] + d[2] * to[2]), value = solver->scene->beam[choice->suns[n]][c];
        sweep->beams[n].scattered = value * choice->albedo[c] * nph_shdom_cut_phase(&choice->angles, cosine, 1) * 0.079577471545947667884;
        sweep->beams[n].depth = row_of(solver, solver->sun, n, grid->point_count);
        sweep->beams[n].mean = row_of(solver, solver->sun_mean, n * choice->channels + c, grid->cell_count);
    }
}

static NphStatus run_sweep(void *opaque, int64_t number, int worker) {
    NphShdomSolver *solver = opaque;
    const NphShdomChoice *choice = solver->choice;
    const NphShdomGrid *grid = &choice->grid;
    int first = solver->iteration == 0, c = solver->channel, ordinate = solver->group * NPH_SHDOM_GROUP + (int)number;
    double d[3], basis[NPH_SHDOM_TERMS_MAX];
    nph_shdom_ordinate(&choice->angles, ordinate, d);
    nph_shdom_harmonics(choice->angles.bands, d, basis);
    NphShdomSweep sweep = {.grid = grid, .basis = basis, .coefficients = choice->angles.terms, .extinction = choice->extinction[c],
                           .density = solver->density, .projected = solver->projected[worker], .cubic = choice->cubic, .thin = choice->thin};
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) sweep.along[a] += grid->from_local[4 * a + b] * d[b];
    int64_t row = nph_shdom_row(choice);
    sweep.share = first ? row_of(solver, solver->share, c, grid->cell_count) : solver->ones;
    sweep.bubble = first ? solver->nothing : solver->bubble_now;
    sweep.source = first ? row_of(solver, solver->beam, c * (int64_t)choice->angles.terms, grid->point_count) : row_of(solver, solver->source, c, row);
    sweep.border = first ? solver->kernels.load(solver->border, (int64_t)c * nph_shdom_ordinates(&choice->angles) + ordinate) : 0.0;
    if (first) set_beams(solver, d, &sweep);
    sweep.radiance = row_of(solver, solver->radiance, number, grid->point_count);
    sweep.mean = row_of(solver, solver->mean, number, grid->cell_count);
    NPH_LAUNCH(&solver->counts[worker], NPH_SHDOM_SWEEP, grid->point_count, solver->unsettled[worker] += solver->kernels.sweep(&sweep));
    return NPH_OK;
}

/* What the ordinates of the group count in the moments. */
static void set_factors(NphShdomSolver *solver) {
    const NphShdomAngles *angles = &solver->choice->angles;
    double d[3], y[NPH_SHDOM_TERMS_MAX];
    for (int i = 0; i < nph_shdom_group_size(solver->choice, solver->group); i++) {
        double weight = nph_shdom_ordinate(angles, solver->group * NPH_SHDOM_GROUP + i, d);
        nph_shdom_harmonics(angles->bands, d, y);
        for (int t = 0; t < angles->terms; t++) solver->factors[i * angles->terms + t] = weight * y[t];
    }
}

/* Blocks of points, then of cells: these have their mean of degree 0 alone. */
static NphStatus run_moments(void *opaque, int64_t block, int worker) {
    NphShdomSolver *solver = opaque;
    const NphShdomChoice *choice = solver->choice;
    int64_t of_points = nph_shdom_blocks(choice->grid.point_count), means = block >= of_points;
    int64_t items = means ? choice->grid.cell_count : choice->grid.point_count, first = (block - means * of_points) * NPH_SHDOM_BLOCK;
    NphShdomGather gather = {.factors = solver->factors, .ordinates = nph_shdom_group_size(choice, solver->group), .coefficients = choice->angles.terms,
                             .stride = choice->angles.terms, .add = solver->group > 0, .points = items, .first = first,
                             .end = first + NPH_SHDOM_BLOCK < items ? first + NPH_SHDOM_BLOCK : items, .radiance = solver->radiance,
                             .moments = solver->moments};
    if (means) {
        gather.coefficients = 1;
        gather.radiance = solver->mean;
        gather.moments = row_of(solver, solver->moments, choice->angles.terms, choice->grid.point_count);
    }
    NPH_LAUNCH(&solver->counts[worker], NPH_SHDOM_MOMENTS, gather.end - gather.first, solver->kernels.gather(&gather));
    return NPH_OK;
}

/* A coefficient each, then the means: what has been scattered once makes a source, then all that has been scattered the next one. */
static NphStatus run_scatter(void *opaque, int64_t term, int worker) {
    NphShdomSolver *solver = opaque;
    const NphShdomChoice *choice = solver->choice;
    int64_t points = choice->grid.point_count, begin = term * points, end = term < choice->angles.terms ? begin + points : nph_shdom_row(choice);
    int degree = 0, begins = solver->iteration == 0;
    while (term < choice->angles.terms && (int64_t)(degree + 1) * (degree + 1) <= term) degree++;
    double factor = choice->albedo[solver->channel] * choice->angles.kept[degree];
    void *source = row_of(solver, solver->source, solver->channel, nph_shdom_row(choice));
    if (begins)
        memcpy(row_of(solver, solver->first, term, points), row_of(solver, solver->moments, term, points),
               (size_t)(end - begin) * (size_t)(solver->precision / 8));
    for (int64_t at = begin; at < end; at += NPH_SHDOM_BLOCK) {
        int64_t part[2] = {at, at + NPH_SHDOM_BLOCK < end ? at + NPH_SHDOM_BLOCK : end};
        if (begins) /* half of twice as much, to the bit */
            NPH_LAUNCH(&solver->counts[worker], NPH_SHDOM_FIRST, part[1] - part[0],
                       solver->kernels.scatter(0.5 * factor, solver->first, solver->first, part, source));
        else
            NPH_LAUNCH(&solver->counts[worker], NPH_SHDOM_SCATTER, part[1] - part[0],
                       solver->kernels.scatter(factor, solver->first, solver->moments, part, solver->scattered));
    }
    return NPH_OK;
}

static NphStatus run_properties(void *opaque, int64_t block, int worker) {
    NphShdomSolver *solver = opaque;
    NPH_LAUNCH(&solver->counts[worker], NPH_SHDOM_PROPERTIES, NPH_SHDOM_BLOCK, nph_shdom_properties(solver, block, worker));
    return NPH_OK;
}

static NphStatus run_points(void *opaque, int64_t block, int worker) {
    NphShdomSolver *solver = opaque;
    NPH_LAUNCH(&solver->counts[worker], NPH_SHDOM_DIRECT, NPH_SHDOM_BLOCK, nph_shdom_direct_points(solver, block, worker));
    return NPH_OK;
}

static NphStatus run_cells(void *opaque, int64_t block, int worker) {
    NphShdomSolver *solver = opaque;
    NPH_LAUNCH(&solver->counts[worker], NPH_SHDOM_DIRECT, NPH_SHDOM_BLOCK, nph_shdom_direct_cells(solver, block, worker));
    return NPH_OK;
}

static NphStatus step_direct(NphShdomSolver *solver) {
    const NphShdomChoice *choice = solver->choice;
    int count = choice->channels * nph_shdom_ordinates(&choice->angles);
    double *border = NULL;
    NPH_TRY(nph_pool_run(solver->context, nph_shdom_blocks(choice->grid.point_count), run_points, solver, NULL));
    NPH_TRY(nph_pool_run(solver->context, nph_shdom_blocks(choice->grid.cell_count), run_cells, solver, NULL));
    NPH_TRY(NPH_NEW(solver->context, count, "light by ordinate", &border));
    nph_shdom_border(solver, border);
    solver->kernels.store(border, count, solver->border);
    nph_free(solver->context, border);
    return NPH_OK;
}

/* A block of points: coefficients one after another; then, where cameras look for it, what beams are scattered first. */
static NphStatus run_finish(void *opaque, int64_t block, int worker) {
    NphShdomSolver *solver = opaque;
    const NphShdomChoice *choice = solver->choice;
    int64_t points = choice->grid.point_count, first = block * NPH_SHDOM_BLOCK, end = first + NPH_SHDOM_BLOCK < points ? first + NPH_SHDOM_BLOCK : points;
    int64_t terms = choice->angles.terms, rows = choice->channels * terms, all = rows * (1 + choice->looks);
    size_t real = (size_t)solver->precision / 8;
    double started = nph_seconds();
    for (int64_t r = 0; r < all; r++) {
        int64_t c = r % rows / terms, t = r % terms;
        const char *from = r < rows ? row_of(solver, solver->source, c, nph_shdom_row(choice)) : row_of(solver, solver->beam, c * terms, points);
        from += (size_t)(t * points) * real;
        for (int64_t p = first; p < end; p++) memcpy((char *)solver->field + real * (size_t)(p * all + r), from + real * (size_t)p, real);
    }
    NphStageCount *count = &solver->counts[worker].stage[NPH_SHDOM_FINISH];
    count->seconds += nph_seconds() - started;
    count->launches++;
    count->items += end - first;
    return NPH_OK;
}

/* Bubbles of a channel's source, a block of cells. */
static NphStatus run_bubbles(void *opaque, int64_t block, int worker) {
    NphShdomSolver *solver = opaque;
    const NphShdomChoice *choice = solver->choice;
    int64_t cells = choice->grid.cell_count, first = block * NPH_SHDOM_BLOCK;
    int64_t range[2] = {first, first + NPH_SHDOM_BLOCK < cells ? first + NPH_SHDOM_BLOCK : cells};
    const void *source = row_of(solver, solver->source, solver->channel, nph_shdom_row(choice));
    const void *means = (const char *)source + (size_t)(choice->grid.point_count * choice->angles.terms) * ((size_t)solver->precision / 8);
    (void)worker;
    solver->kernels.bubble(&choice->grid, source, means, range, solver->bubble_now);
    return NPH_OK;
}

static NphStatus step_finish(NphShdomSolver *solver) {
    int64_t cells = solver->choice->grid.cell_count;
    for (solver->channel = 0; solver->channel < solver->choice->channels; solver->channel++) {
        NPH_TRY(nph_pool_run(solver->context, nph_shdom_blocks(cells), run_bubbles, solver, NULL));
        memcpy(row_of(solver, solver->bubble, solver->channel, cells), solver->bubble_now, (size_t)cells * (size_t)(solver->precision / 8));
    }
    solver->channel = 0;
    return nph_pool_run(solver->context, nph_shdom_blocks(solver->choice->grid.point_count), run_finish, solver, NULL);
}

NphStatus nph_shdom_step(NphShdomSolver *solver, NphShdomStage stage) {
    const NphShdomChoice *choice = solver->choice;
    NphContext *context = solver->context;
    switch (stage) {
    case NPH_SHDOM_PROPERTIES: return nph_pool_run(context, nph_shdom_blocks(choice->grid.cell_count), run_properties, solver, NULL);
    case NPH_SHDOM_DIRECT: return step_direct(solver);
    case NPH_SHDOM_SWEEP:
        if (solver->iteration > 0) NPH_TRY(nph_pool_run(context, nph_shdom_blocks(choice->grid.cell_count), run_bubbles, solver, NULL));
        return nph_pool_run(context, nph_shdom_group_size(choice, solver->group), run_sweep, solver, NULL);
    case NPH_SHDOM_MOMENTS:
        set_factors(solver);
        return nph_pool_run(context, nph_shdom_blocks(choice->grid.point_count) + nph_shdom_blocks(choice->grid.cell_count), run_moments, solver, NULL);
    case NPH_SHDOM_FIRST:
    case NPH_SHDOM_SCATTER: return nph_pool_run(context, choice->angles.terms + 1, run_scatter, solver, NULL);
    case NPH_SHDOM_ACCELERATE: return nph_shdom_accelerate(solver);
    default: return step_finish(solver);
    }
}
