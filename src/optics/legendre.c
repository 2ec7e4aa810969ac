/* SPDX-License-Identifier: Apache-2.0
 *
 * Moments of phase functions. Over a straight line in x = 1 - |cos| they are, by parts, with
 *   I1_l(x) = int_0^x P_l = (P_{l-1} - P_{l+1}) / (2l + 1),   I2_l(x) = int_0^x I1_l = (I1_{l-1} - I1_{l+1}) / (2l + 1):
 *   int_0^1 p P_l dx = p(1) I1_l(1) - sum over lines of slope times the change of I2_l.
 * P_l runs by its differences d_l = P_l - P_{l-1}, which keep their digits at the pole:
 *   d_{l+1} = (l d_l - (2l + 1) x P_l) / (l + 1),   P_{l-1} - P_{l+1} = -(d_l + d_{l+1}). */
#include "optics/legendre.h"

#include "core/memory.h"
#include "core/message.h"
#include "core/reduce.h"

static const double PI = 3.14159265358979323846;

/* At one x of a list: P_l, d_{l+1}, and I1 of three orders, l - 1, l, l + 1. */
typedef struct Ladder {
    int count;
    const double *x;
    double *p, *d, *i1[3];
} Ladder;

static NphStatus ladder_new(NphContext *context, const double *x, int count, const char *what, Ladder *ladder) {
    double *block = NULL;
    NPH_TRY(NPH_NEW(context, 5 * (int64_t)count, what, &block));
    *ladder = (Ladder){count, x, block, block + count, {block + 2 * (int64_t)count, block + 3 * (int64_t)count, block + 4 * (int64_t)count}};
    return NPH_OK;
}

/* l = 0: I1_{-1} is not needed, I1_0 = x, I1_1 = (P_0 - P_2) / 3 = x - x^2 / 2. */
static void ladder_begin(Ladder *s) {
    for (int k = 0; k < s->count; k++) {
        double x = s->x[k];
        s->p[k] = 1.0;
        s->d[k] = -x;
        s->i1[0][k] = 0.0;
        s->i1[1][k] = x;
        s->i1[2][k] = x - 0.5 * x * x;
    }
}

/* From l to l + 1; fills I1_{l+2} = -(d_{l+2} + d_{l+3}) / (2l + 5). */
static void ladder_step(Ladder *s, int l) {
    double *swap = s->i1[0], *restrict out, *restrict p = s->p, *restrict d = s->d;
    const double *restrict x = s->x;
    double a = l + 1, b = l + 2, c = l + 3, scale = 1.0 / (2.0 * l + 5.0);
    s->i1[0] = s->i1[1];
    s->i1[1] = s->i1[2];
    s->i1[2] = out = swap;
    for (int k = 0; k < s->count; k++) {
        double p1 = p[k] + d[k], d2 = (a * d[k] - (2.0 * a + 1.0) * x[k] * p1) / b, p2 = p1 + d2;
        double d3 = (b * d2 - (2.0 * b + 1.0) * x[k] * p2) / c;
        out[k] = -(d2 + d3) * scale;
        p[k] = p1;
        d[k] = d2;
    }
}

/* int_0^1 p P_l dx */
static double half_moment(const Ladder *s, const NphPhaseHalf *half, int l) {
    NphSum sum = {0.0, 0.0};
    double before = 0.0;
    nph_sum_add(&sum, half->value[half->count] * s->i1[1][half->count]);
    for (int k = 0; k <= half->count; k++) {
        double now = l > 0 ? (s->i1[0][k] - s->i1[2][k]) / (2.0 * l + 1.0) : 0.5 * s->x[k] * s->x[k];
        double slope = k > 0 ? (half->value[k] - half->value[k - 1]) / (half->x[k] - half->x[k - 1]) : 0.0;
        nph_sum_add(&sum, -slope * (now - before));
        before = now;
    }
    return nph_sum_value(sum);
}

static NphStatus table_moments(NphContext *context, const NphPhaseTable *table, int count, double *moment) {
    Ladder ladder[2] = {{0}, {0}};
    NphStatus status = NPH_OK;
    for (int h = 0; h < 2 && status == NPH_OK; h++) {
        status = ladder_new(context, table->half[h].x, table->half[h].count + 1, "moments", &ladder[h]);
        if (status == NPH_OK) ladder_begin(&ladder[h]);
    }
    for (int l = 0; l < count && status == NPH_OK; l++) {
        double front = half_moment(&ladder[0], &table->half[0], l), back = half_moment(&ladder[1], &table->half[1], l);
        moment[l] = 2.0 * PI * (l & 1 ? front - back : front + back);
        for (int h = 0; h < 2; h++) ladder_step(&ladder[h], l);
        if (l % 256 == 0 && nph_interrupted(context)) status = NPH_INTERRUPTED;
    }
    for (int h = 0; h < 2; h++) nph_free(context, ladder[h].p);
    return status;
}

static double whole_power(double base, int n) {
    double result = 1.0;
    for (; n > 0; n >>= 1, base *= base)
        if (n & 1) result *= base;
    return result;
}

/* The mean of cos P_l, of a function whose moments are powers of g. */
static double times_cosine(double g, int l) {
    double above = (l + 1.0) * whole_power(g, l + 1), below = l > 0 ? l * whole_power(g, l - 1) : 0.0;
    return (above + below) / (2.0 * l + 1.0);
}

/* hg times 1 + alpha cos^2. */
static double draine_moment(const NphPhase *phase, int l) {
    double g = phase->g[0], below = l > 0 ? l * times_cosine(g, l - 1) : 0.0;
    double square = ((l + 1.0) * times_cosine(g, l + 1) + below) / (2.0 * l + 1.0);
    return (whole_power(g, l) + phase->alpha * square) / (1.0 + phase->alpha * (1.0 + 2.0 * g * g) / 3.0);
}

NphStatus nph_phase_moments(NphContext *context, const NphPhase *phase, int count, double *moment) {
    if (phase->kind == NPH_PHASE_TABULATED) return table_moments(context, phase->table, count, moment);
    for (int l = 0; l < count; l++) {
        double first = whole_power(phase->g[0], l), second = whole_power(phase->g[1], l);
        moment[l] = l == 0 ? 1.0 : 0.0;
        if (phase->kind == NPH_PHASE_HG) moment[l] = first;
        if (phase->kind == NPH_PHASE_TWO_LOBE) moment[l] = phase->weight * first + (1.0 - phase->weight) * second;
        if (phase->kind == NPH_PHASE_RAYLEIGH && l == 2) moment[l] = 0.1;
        if (phase->kind == NPH_PHASE_DRAINE) moment[l] = draine_moment(phase, l);
    }
    return NPH_OK;
}

NphStatus nph_phase_all_moments(NphContext *context, const NphPhase *phase, double least, int *count, double **moment) {
    double *found = NULL;
    for (int most = 256;; most *= 2) {
        NphStatus status = nph_realloc(context, (size_t)most, sizeof *found, "moments", (void **)&found);
        if (status == NPH_OK) status = nph_phase_moments(context, phase, most, found);
        if (status != NPH_OK) {
            nph_free(context, found);
            return status;
        }
        int last = most - 1;
        while (last > 0 && nph_abs(found[last]) < least) last--;
        if (2 * last > most && most < NPH_MOST_MOMENTS) continue;
        *count = last + 1;
        *moment = found;
        return NPH_OK;
    }
}

double nph_legendre_value(int count, const double *moment, double distance, int back) {
    NphSum sum = {0.0, 0.0};
    double p = 1.0, d = -distance;
    for (int l = 0; l < count; l++) {
        double term = (2.0 * l + 1.0) * moment[l] * p;
        nph_sum_add(&sum, back && l & 1 ? -term : term);
        p += d;
        d = ((l + 1.0) * d - (2.0 * l + 3.0) * distance * p) / (l + 2.0);
    }
    return nph_sum_value(sum) / (4.0 * PI);
}
