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

/* At one x: P_l, d_{l+1}, and I1 of three orders, l - 1, l, l + 1. */
typedef struct Ladder {
    double x, p, d, i1[3];
} Ladder;

/* l = 0: I1_{-1} is not needed, I1_0 = x, I1_1 = (P_0 - P_2) / 3 = x - x^2 / 2. */
static Ladder ladder_at(double x) { return (Ladder){x, 1.0, -x, {0.0, x, x - 0.5 * x * x}}; }

/* From l to l + 1; I1_{l+2} = -(d_{l+2} + d_{l+3}) / (2l + 5). */
static inline void ladder_step(Ladder *s, double l) {
    double p1 = s->p + s->d, d2 = ((l + 1.0) * s->d - (2.0 * l + 3.0) * s->x * p1) / (l + 2.0), p2 = p1 + d2;
    double d3 = ((l + 2.0) * d2 - (2.0 * l + 5.0) * s->x * p2) / (l + 3.0);
    s->i1[0] = s->i1[1];
    s->i1[1] = s->i1[2];
    s->i1[2] = -(d2 + d3) / (2.0 * l + 5.0);
    s->p = p1;
    s->d = d2;
}

static inline double ladder_i2(const Ladder *s, int l) {
    return l > 0 ? (s->i1[0] - s->i1[2]) / (2.0 * l + 1.0) : 0.5 * s->x * s->x;
}

/* One line of a half, and of the last one its end at x = 1; P_l is odd or even: seen from behind it has the sign of (-1)^l. */
static void add_line(const NphPhaseHalf *half, int line, int back, int count, double *moment) {
    Ladder low = ladder_at(half->x[line]), high = ladder_at(half->x[line + 1]);
    double slope = (half->value[line + 1] - half->value[line]) / (half->x[line + 1] - half->x[line]);
    double end = line + 1 == half->count ? half->value[half->count] : 0.0;
    for (int l = 0; l < count; l++) {
        double part = 2.0 * PI * (end * high.i1[1] - slope * (ladder_i2(&high, l) - ladder_i2(&low, l)));
        moment[l] += back && l & 1 ? -part : part;
        ladder_step(&low, l);
        ladder_step(&high, l);
    }
}

/* base^n. */
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

void nph_phase_moments(const NphPhase *phase, int count, double *moment) {
    double first = 1.0, second = 1.0, weight = phase->kind == NPH_PHASE_TWO_LOBE ? phase->weight : 1.0;
    for (int l = 0; l < count; l++) {
        moment[l] = l == 0 ? 1.0 : 0.0;
        if (phase->kind == NPH_PHASE_HG || phase->kind == NPH_PHASE_TWO_LOBE) moment[l] = weight * first + (1.0 - weight) * second;
        if (phase->kind == NPH_PHASE_RAYLEIGH && l == 2) moment[l] = 0.1;
        if (phase->kind == NPH_PHASE_DRAINE) moment[l] = draine_moment(phase, l);
        first *= phase->g[0];
        second *= phase->g[1];
    }
    if (phase->kind != NPH_PHASE_TABULATED) return;
    for (int h = 0; h < 2; h++)
        for (int i = 0; i < phase->table->half[h].count; i++) add_line(&phase->table->half[h], i, h, count, moment);
    moment[0] = 1.0;
}

NphStatus nph_phase_all_moments(NphContext *context, const NphPhase *phase, double least, int *count, double **moment) {
    double *found = NULL;
    for (int most = 256;; most *= 2) {
        NphStatus status = nph_interrupted(context) ? NPH_INTERRUPTED : nph_realloc(context, (size_t)most, sizeof *found, "moments", (void **)&found);
        if (status != NPH_OK) {
            nph_free(context, found);
            return status;
        }
        nph_phase_moments(phase, most, found);
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
