/* SPDX-License-Identifier: Apache-2.0
 *
 * shdom.accelerate: with x_j a source and f_j what one more scattering changes it by, the next one is
 *   sum over the last sources of a_j (x_j + f_j),   sum a_j = 1,   |sum a_j f_j| as small as can be     [Anderson65]
 * which for a linear problem is about what GMRES does [Walker11]. a_j = g_j, a_now = 1 - sum g_j with
 *   sum over k of (f_j - f)(f_k - f) g_k = -(f_j - f) f
 * by elimination, the newest first; those that tell nothing new (a pivot below 1e-9 of what it was) are left out. With one
 * source alone it is the plain iteration. [scattered, source, history, gram -> source, history, gram, residual] */
#include <string.h>

#include "core/fmath.h"
#include "core/pool.h"
#include "core/reduce.h"
#include "truth/shdom/shdom.h"

enum { MOST = NPH_SHDOM_HISTORY_MAX };

typedef struct Step {
    NphShdomSolver *solver;
    NphShdomMix mix;
    int combine;
} Step;

static NphStatus run_block(void *opaque, int64_t block, int worker) {
    const Step *step = opaque;
    NphShdomSolver *solver = step->solver;
    NphShdomMix mix = step->mix;
    mix.first = block * NPH_SHDOM_BLOCK;
    mix.end = mix.first + NPH_SHDOM_BLOCK < mix.size ? mix.first + NPH_SHDOM_BLOCK : mix.size;
    mix.dots = solver->partial + block * (mix.count + 1);
    NPH_LAUNCH(&solver->counts[worker], NPH_SHDOM_ACCELERATE, mix.end - mix.first,
               step->combine ? solver->kernels.combine(&mix) : solver->kernels.difference(&mix));
    return NPH_OK;
}

/* Solves for the other sources' weights; order: slots, the newest first, which is `order[0]`. */
static void solve_weights(const double *gram, int history, const int *order, int count, double *weights) {
    double A[MOST][MOST + 1] = {{0.0}}, kept[MOST] = {0.0};
    int used[MOST] = {0}, now = order[0];
    double square = gram[now * history + now];
    for (int i = 1; i < count; i++) {
        for (int j = 1; j < count; j++)
            A[i][j] = gram[order[i] * history + order[j]] - gram[order[i] * history + now] - gram[order[j] * history + now] + square;
        A[i][0] = square - gram[order[i] * history + now];
        kept[i] = A[i][i];
    }
    for (int i = 1; i < count; i++) { /* symmetric elimination */
        used[i] = A[i][i] > 1e-9 * kept[i] && A[i][i] > 0.0;
        for (int k = i + 1; k < count && used[i]; k++) {
            double factor = A[k][i] / A[i][i];
            for (int j = 0; j < count; j++)
                if (j == 0 || j > i) A[k][j] -= factor * A[i][j];
        }
    }
    for (int k = 0; k < count; k++) weights[order[k]] = k == 0 ? 1.0 : 0.0;
    for (int i = count - 1; i > 0; i--) {
        double sum = A[i][0];
        if (!used[i]) continue;
        for (int j = i + 1; j < count; j++) sum -= A[i][j] * weights[order[j]];
        weights[order[i]] = sum / A[i][i];
    }
    for (int i = 1; i < count; i++) weights[now] -= weights[order[i]];
}

NphStatus nph_shdom_accelerate(NphShdomSolver *solver) {
    const NphShdomChoice *choice = solver->choice;
    int64_t size = nph_shdom_row(choice), blocks = nph_shdom_blocks(size);
    int history = choice->history, done = solver->iteration - 1, slot = done % history, count = done < history ? done + 1 : history;
    int order[MOST] = {0};
    double weights[MOST] = {0.0};
    char *source = (char *)solver->source + (size_t)(solver->channel * size) * ((size_t)solver->precision / 8);
    Step step = {.solver = solver, .mix = {.size = size, .slot = slot, .count = count, .weights = weights, .scattered = solver->scattered,
                                           .source = source, .history = solver->history}};
    NPH_TRY(nph_pool_run(solver->context, blocks, run_block, &step, NULL));
    for (int k = 0; k < count; k++) {
        double dot = nph_tree_sum(solver->partial + k, blocks, count + 1);
        solver->gram[slot * history + k] = solver->gram[k * history + slot] = dot;
        order[k] = (slot + history - k) % history;
    }
    double square = nph_tree_sum(solver->partial + count, blocks, count + 1), change = solver->gram[slot * history + slot];
    solver->residual[0] = square > 0.0 ? nph_sqrt(change / square) : 0.0;
    solve_weights(solver->gram, history, order, count, weights);
    step.combine = 1;
    return nph_pool_run(solver->context, blocks, run_block, &step, NULL);
}
