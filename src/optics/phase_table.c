/* SPDX-License-Identifier: Apache-2.0
 *
 * Tabulated phase functions: rows of angle and value to the two halves of NphPhaseTable. The density is linear in the
 * cosine between rows, so its integrals are exact: over an interval of width w, from a to b at distances x, x + w,
 *   part = 2 pi w (a + b) / 2,   part times mean distance = 2 pi w (a (3 x + w) + b (3 x + 2 w)) / 6. */
#include <string.h>

#include "core/fmath.h"
#include "core/memory.h"
#include "core/message.h"
#include "core/reduce.h"
#include "core/text.h"
#include "optics/phase_table_lookup.h"

enum { FEWEST_BUCKETS = 16, MOST_BUCKETS = 4096 };

typedef struct Rows {
    const double *at; /* angle, value, angle, value, ... */
    int64_t count;
    double largest;
} Rows;

static double angle_of(const Rows *rows, int64_t i) { return rows->at[2 * i]; }
static double value_of(const Rows *rows, int64_t i) { return rows->at[2 * i + 1] / rows->largest; }

/* 1 - cos of an angle in degrees. */
static double distance_of(double degrees) {
    double sine, cosine;
    nph_sincos2pi(degrees / 720.0, &sine, &cosine);
    return 2.0 * sine * sine;
}

/* The value at 90 degrees, the distance 1 from both poles, between row i and the one before. */
static double value_across(const Rows *rows, int64_t i) {
    if (i == 0) return value_of(rows, 0);
    if (i == rows->count) return value_of(rows, rows->count - 1);
    double front = 1.0 - distance_of(angle_of(rows, i - 1)), back = 1.0 - distance_of(180.0 - angle_of(rows, i));
    double share = front + back > 0.0 ? front / (front + back) : 0.0;
    return value_of(rows, i - 1) + share * (value_of(rows, i) - value_of(rows, i - 1));
}

/* The rows [first, last) of one half, outermost first, then the end at 90 degrees; x and value not yet scaled. */
static void fill_half(const Rows *rows, int64_t first, int64_t last, int back, NphPhaseHalf *half) {
    int n = 0;
    for (int64_t k = 0; k < last - first; k++) {
        int64_t i = back ? last - 1 - k : first + k;
        double x = distance_of(back ? 180.0 - angle_of(rows, i) : angle_of(rows, i));
        if (n == 0 && x > 0.0) { /* the table begins later: the value goes on to the pole */
            half->x[n] = 0.0;
            half->value[n++] = value_of(rows, i);
        }
        half->x[n] = x;
        half->value[n++] = value_of(rows, i);
    }
    double middle = value_across(rows, back ? first : last);
    if (n == 0) {
        half->x[n] = 0.0;
        half->value[n++] = middle;
    }
    half->x[n] = 1.0;
    half->value[n] = middle;
    half->count = n;
}

/* One block for a half of at most `most` intervals. */
static NphStatus allocate_half(NphContext *context, int64_t most, const char *what, NphPhaseHalf *half) {
    half->buckets = FEWEST_BUCKETS;
    while (half->buckets < most && half->buckets < MOST_BUCKETS) half->buckets *= 2;
    double *numbers = NULL;
    int32_t *guides = NULL;
    NPH_TRY(NPH_NEW(context, 3 * (most + 1), what, &numbers));
    half->x = numbers;
    half->value = numbers + (most + 1);
    half->part = numbers + 2 * (most + 1);
    NPH_TRY(NPH_NEW(context, 2 * (half->buckets + 1), what, &guides));
    half->by_x = guides;
    half->by_part = guides + half->buckets + 1;
    return NPH_OK;
}

static NphStatus check_order(NphContext *context, const NphPhaseHalf *half, const char *what) {
    for (int i = 0; i < half->count; i++)
        if (!(half->x[i] < half->x[i + 1]))
            return nph_error(context, NPH_BAD_INPUT,
                             "%s: two rows lie so close to each other, or to 90 degrees, that their cosines are equal", what);
    return NPH_OK;
}

/* Parts from the pole on, times 2 pi; returns the moment of the distance. */
static double integrate(NphPhaseHalf *half) {
    NphSum part = {0.0, 0.0}, moment = {0.0, 0.0};
    half->part[0] = 0.0;
    for (int i = 0; i < half->count; i++) {
        double x = half->x[i], w = half->x[i + 1] - x, a = half->value[i], b = half->value[i + 1];
        nph_sum_add(&part, 3.14159265358979323846 * w * (a + b));
        nph_sum_add(&moment, 1.04719755119659774615 * w * (a * (3.0 * x + w) + b * (3.0 * x + 2.0 * w)));
        double up_to = nph_sum_value(part);
        half->part[i + 1] = up_to > half->part[i] ? up_to : half->part[i];
    }
    return nph_sum_value(moment);
}

static void count_edges(const double *edges, int count, int by_x, double scale, int buckets, int32_t *guide) {
    for (int b = 0; b <= buckets; b++) guide[b] = 0;
    for (int i = 0; i < count; i++)
        guide[r_phase_bucket(by_x ? nph_sqrt(edges[i]) : edges[i] * scale, buckets) + 1]++;
    for (int b = 0; b < buckets; b++) guide[b + 1] += guide[b];
}

/* Both halves to probabilities; the front's last part is what the back's leaves of 1. */
static NphStatus normalise(NphContext *context, const char *what, NphPhaseTable *table) {
    double moment[2], most = 0.0;
    for (int h = 0; h < 2; h++) moment[h] = integrate(&table->half[h]);
    double part[2] = {table->half[0].part[table->half[0].count], table->half[1].part[table->half[1].count]};
    double total = part[0] + part[1];
    for (int h = 0; h < 2; h++) {
        NphPhaseHalf *half = &table->half[h];
        for (int i = 0; i <= half->count; i++) {
            half->value[i] /= total;
            half->part[i] /= total;
            most = half->value[i] > most ? half->value[i] : most;
        }
    }
    NphPhaseHalf *front = &table->half[0], *back = &table->half[1];
    double rest = 1.0 - back->part[back->count], before = front->part[front->count];
    for (int i = front->count; i >= 0 && (front->part[i] == before || front->part[i] > rest); i--) front->part[i] = rest;
    for (int h = 0; h < 2; h++) {
        NphPhaseHalf *half = &table->half[h];
        double last = half->part[half->count];
        half->part_scale = last > 0.0 ? 1.0 / last : 0.0;
        count_edges(half->x, half->count, 1, 1.0, half->buckets, half->by_x);
        count_edges(half->part, half->count, 0, half->part_scale, half->buckets, half->by_part);
    }
    table->mean_cosine = (part[0] - moment[0] - (part[1] - moment[1])) / total;
    if (most <= NPH_PHASE_MOST_VALUE) return NPH_OK;
    char shown[NPH_DOUBLE_TEXT];
    return nph_error(context, NPH_BAD_INPUT,
                     "%s: has a peak of %s per steradian, at most 1e10 are resolved; light scattered by less than 1e-5 "
                     "radians is as good as not scattered: leave it out here and in the extinction",
                     what, nph_format_rounded(most, 3, shown));
}

static NphStatus build(NphContext *context, const Rows *rows, const char *what, NphPhaseTable *table) {
    int64_t front = 0, back = rows->count;
    while (front < rows->count && angle_of(rows, front) < 90.0) front++;
    while (back > 0 && angle_of(rows, back - 1) > 90.0) back--;
    NPH_TRY(allocate_half(context, front + 2, what, &table->half[0]));
    NPH_TRY(allocate_half(context, rows->count - back + 2, what, &table->half[1]));
    double exact = front < back ? value_of(rows, front) : 0.0;
    fill_half(rows, 0, front, 0, &table->half[0]);
    fill_half(rows, back, rows->count, 1, &table->half[1]);
    for (int h = 0; h < 2 && front < back; h++) table->half[h].value[table->half[h].count] = exact; /* a row at 90 */
    for (int h = 0; h < 2; h++) NPH_TRY(check_order(context, &table->half[h], what));
    return normalise(context, what, table);
}

static void warn_ends(NphContext *context, const Rows *rows, const char *what) {
    char angle[NPH_DOUBLE_TEXT];
    double first = angle_of(rows, 0), last = angle_of(rows, rows->count - 1);
    if (first > 0.0)
        nph_warn(context, "%s: begins at %s degrees; the first value is taken down to 0", what,
                 nph_format_double(first, angle));
    if (last < 180.0)
        nph_warn(context, "%s: ends at %s degrees; the last value is taken up to 180", what,
                 nph_format_double(last, angle));
}

NphStatus nph_phase_tabulate(NphContext *context, const NphArray *array, const char *what, NphPhase *phase) {
    Rows rows = {array->data, array->shape[0], 0.0};
    NphPhase made = {.kind = NPH_PHASE_TABULATED};
    for (int64_t i = 0; i < rows.count; i++) {
        double value = rows.at[2 * i + 1], angle = rows.at[2 * i];
        if (!(angle >= 0.0 && angle <= 180.0 && value >= 0.0) || (i > 0 && !(angle > angle_of(&rows, i - 1))))
            return nph_error(context, NPH_BAD_INPUT, "%s: row %lld is no angle above the one before and at most 180 "
                             "degrees with a value of at least 0", what, (long long)i + 1);
        rows.largest = value > rows.largest ? value : rows.largest;
    }
    if (rows.count < 2) return nph_error(context, NPH_BAD_INPUT, "%s: has fewer than two rows", what);
    if (!(rows.largest > 0.0)) return nph_error(context, NPH_BAD_INPUT, "%s: all values are 0", what);
    NPH_TRY(NPH_NEW(context, 1, what, &made.table));
    NphStatus status = build(context, &rows, what, made.table);
    if (status != NPH_OK) {
        nph_phase_free(context, &made);
        return status;
    }
    warn_ends(context, &rows, what);
    *phase = made;
    return NPH_OK;
}

void nph_phase_free(NphContext *context, NphPhase *phase) {
    if (phase->table)
        for (int h = 0; h < 2; h++) {
            nph_free(context, phase->table->half[h].x);
            nph_free(context, phase->table->half[h].by_x);
        }
    nph_free(context, phase->table);
    phase->table = NULL;
}
