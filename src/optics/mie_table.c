/* SPDX-License-Identifier: Apache-2.0
 *
 * Where a table of spheres needs its rows (mie_table.h). */
#include "optics/mie_table.h"

#include <string.h>

#include "core/fmath.h"
#include "core/memory.h"
#include "core/message.h"
#include "core/reduce.h"
#include "core/text.h"

enum { NEAR_ANGLES = 128, MOST_PARTS = 16 };

static const double PI = 3.14159265358979323846, LEAST_STEP_DEGREES = 1e-6;
static const double FLOOR = 1e-4 / 12.566370614359172; /* 1/sr: errors count relative to the value, or to this where it is less */

/* Rows in the order of their angles; parts: into how many the interval to the next one is to be cut, a power of two, or 0. */
typedef struct Rows {
    int64_t count, room;
    double *degrees, *value;
    unsigned char *parts;
} Rows;

typedef struct Refinement {
    NphContext *context;
    const NphMieRequest *request;
    NphMieCloud cloud;
    Rows rows, next;
    double *distance, *inner;
    unsigned char *back;
    double error;
    const char *what;
} Refinement;

static double distance_of(double degrees, int back) {
    double sine, cosine;
    nph_sincos2pi((back ? 180.0 - degrees : degrees) / 720.0, &sine, &cosine);
    return 2.0 * sine * sine;
}

static NphStatus make_room(Refinement *work, Rows *rows, int64_t room) {
    if (rows->room >= room) return NPH_OK;
    NPH_TRY(nph_realloc(work->context, (size_t)room, sizeof(double), work->what, (void **)&rows->degrees));
    NPH_TRY(nph_realloc(work->context, (size_t)room, sizeof(double), work->what, (void **)&rows->value));
    NPH_TRY(nph_realloc(work->context, (size_t)room, 1, work->what, (void **)&rows->parts));
    rows->room = room;
    return NPH_OK;
}

static NphStatus room_for_inner(Refinement *work, int64_t count) {
    NPH_TRY(nph_realloc(work->context, (size_t)count, sizeof(double), work->what, (void **)&work->distance));
    NPH_TRY(nph_realloc(work->context, (size_t)count, sizeof(double), work->what, (void **)&work->inner));
    return nph_realloc(work->context, (size_t)count, 1, work->what, (void **)&work->back);
}

/* From a pole: 0, then steps that grow by a quarter from a fifth of the width of a peak of the largest sphere, 1 / x, up to 1
 * degree. Returns how many of them lie below 1. */
static int near_angles(double x, double degrees[NEAR_ANGLES]) {
    double step = 0.2 / (x > 1.0 ? x : 1.0) * (180.0 / PI), at = 0.0;
    int count = 0;
    for (; at < 1.0 && count < NEAR_ANGLES; step *= 1.25) {
        degrees[count++] = at;
        at += step;
    }
    return count;
}

static NphStatus first_angles(Refinement *work, double largest_x) {
    double near[NEAR_ANGLES];
    int few = near_angles(largest_x, near), count = 2 * few + 179;
    NPH_TRY(make_room(work, &work->rows, count));
    NPH_TRY(room_for_inner(work, count));
    for (int i = 0; i < count; i++) {
        double degrees = i < few ? near[i] : i < few + 179 ? (double)(i - few + 1) : 180.0 - near[count - 1 - i];
        work->rows.degrees[i] = degrees;
        work->rows.parts[i] = i + 1 < count ? 2 : 0;
        work->back[i] = degrees > 90.0;
        work->distance[i] = distance_of(degrees, work->back[i]);
    }
    work->rows.count = count;
    return NPH_OK;
}

static NphStatus begin(Refinement *work) {
    double largest_x;
    NPH_TRY(nph_mie_check(work->context, work->request, work->what, &largest_x));
    NPH_TRY(first_angles(work, largest_x));
    NphMieAngles angles = {work->rows.count, work->distance, work->back};
    return nph_mie_cloud(work->context, work->request, &angles, work->what, &work->cloud, work->rows.value);
}

/* The straight line in the cosine between two rows, at an angle between them. */
static double line_at(double degrees, double from, double to, double a, double b) {
    int back = from + to > 180.0;
    double low = distance_of(from, back), high = distance_of(to, back), at = distance_of(degrees, back);
    return a + (at - low) / (high - low) * (b - a);
}

static double inner_angle(const Rows *rows, int64_t i, int k) {
    return rows->degrees[i] + (rows->degrees[i + 1] - rows->degrees[i]) * (double)k / (double)rows->parts[i];
}

/* Into how many parts each half of an interval goes whose middle is off by that much: the error falls as the square of the width, and
 * the parts are judged two at a time. */
static unsigned char parts_for(double miss, double tolerance, double width) {
    int most = MOST_PARTS, parts = 2;
    while (most > 1 && width < LEAST_STEP_DEGREES * most) most /= 2;
    while (parts < most && miss > 4.0 * tolerance * (double)(parts * parts)) parts *= 2;
    return (unsigned char)(miss > tolerance && most > 1 ? parts : 0);
}

/* A row and the two behind it: does the middle one lie on the line between the others? If not, both intervals are open. */
static void judge(Refinement *work, Rows *to, int64_t i) {
    double value = to->value[i + 1], width = to->degrees[i + 1] - to->degrees[i];
    double line = line_at(to->degrees[i + 1], to->degrees[i], to->degrees[i + 2], to->value[i], to->value[i + 2]);
    double miss = nph_abs(value - line) / (value > FLOOR ? value : FLOOR);
    to->parts[i] = to->parts[i + 1] = parts_for(miss, 0.5 * work->request->tolerance, width);
    if (to->parts[i] == 0 && miss > work->error) work->error = miss; /* within each half it is a quarter of that, but for corners */
}

/* A middle may lie on the line by chance: an interval as wide as w with a second divided difference d of the cosine at one of its ends
 * is off by d w^2 / 4. */
static void reopen(const Refinement *work, Rows *rows, int64_t i) {
    int back = rows->degrees[i] + rows->degrees[i + 1] > 180.0;
    double width = nph_abs(distance_of(rows->degrees[i + 1], back) - distance_of(rows->degrees[i], back));
    for (int64_t k = i > 0 ? i - 1 : 0; k <= i && k + 2 < rows->count && rows->parts[i] == 0; k++) {
        double x[3], slope[2];
        for (int j = 0; j < 3; j++) x[j] = distance_of(rows->degrees[k + j], back);
        for (int j = 0; j < 2; j++) slope[j] = (rows->value[k + j + 1] - rows->value[k + j]) / (x[j + 1] - x[j]);
        double miss = 0.25 * width * width * nph_abs((slope[1] - slope[0]) / (x[2] - x[0]));
        double least = rows->value[i] < rows->value[i + 1] ? rows->value[i] : rows->value[i + 1];
        rows->parts[i] = parts_for(miss / (least > FLOOR ? least : FLOOR), work->request->tolerance, rows->degrees[i + 1] - rows->degrees[i]);
    }
}

/* Rows and what was found between them. */
static void merge(Refinement *work) {
    const Rows *from = &work->rows;
    Rows *to = &work->next;
    int64_t used = 0, count = 0;
    for (int64_t i = 0; i < from->count; i++) {
        to->degrees[count] = from->degrees[i];
        to->value[count] = from->value[i];
        to->parts[count++] = 0;
        for (int k = 1; k < from->parts[i]; k++) {
            to->degrees[count] = inner_angle(from, i, k);
            to->value[count++] = work->inner[used++];
        }
    }
    to->count = count;
    for (int64_t i = 0, at = 0; i < from->count; i++) {
        for (int k = 0; k < from->parts[i]; k += 2) judge(work, to, at + k);
        at += from->parts[i] > 0 ? from->parts[i] : 1;
    }
    for (int64_t i = 0; i + 1 < to->count; i++) reopen(work, to, i);
    Rows swap = work->rows;
    work->rows = work->next;
    work->next = swap;
}

/* Cuts every open interval; *open: how many angles that took. */
static NphStatus refine(Refinement *work, int64_t *open) {
    const Rows *rows = &work->rows;
    int64_t most = work->request->most_angles > 0 ? work->request->most_angles : NPH_MIE_MOST_ANGLES, used = 0;
    *open = 0;
    for (int64_t i = 0; i < rows->count; i++) *open += rows->parts[i] > 0 ? rows->parts[i] - 1 : 0;
    if (*open == 0) return NPH_OK;
    if (rows->count + *open > most) {
        nph_warn(work->context, "%s: its tolerance between angles would need more than %lld of them, the rest is left as it is", work->what,
                 (long long)most);
        *open = 0;
        return NPH_OK;
    }
    NPH_TRY(make_room(work, &work->next, rows->count + *open));
    NPH_TRY(room_for_inner(work, *open));
    for (int64_t i = 0; i < rows->count; i++)
        for (int k = 1; k < rows->parts[i]; k++) {
            double degrees = inner_angle(rows, i, k);
            work->back[used] = degrees > 90.0;
            work->distance[used] = distance_of(degrees, work->back[used]);
            used++;
        }
    NphMieAngles angles = {used, work->distance, work->back};
    NPH_TRY(nph_mie_cloud_values(work->context, &work->cloud, &angles, work->inner));
    merge(work);
    return NPH_OK;
}

/* Integral and first moment of the lines between rows, exact. */
static void integrate(const Rows *rows, double *norm, double *mean_cosine) {
    NphSum whole = {0.0, 0.0}, moment = {0.0, 0.0};
    for (int64_t i = 0; i + 1 < rows->count; i++) {
        int back = rows->degrees[i] + rows->degrees[i + 1] > 180.0;
        double low = distance_of(rows->degrees[i], back), high = distance_of(rows->degrees[i + 1], back), a = rows->value[i],
               b = rows->value[i + 1], width = nph_abs(high - low);
        double fall = (a * (2.0 * low + high) + b * (low + 2.0 * high)) / 6.0, mean = 0.5 * (a + b);
        nph_sum_add(&whole, 2.0 * PI * width * mean);
        nph_sum_add(&moment, 2.0 * PI * width * (back ? fall - mean : mean - fall));
    }
    *norm = nph_sum_value(whole);
    *mean_cosine = nph_sum_value(moment) / *norm;
}

static NphStatus finish(Refinement *work, NphMieTable *table) {
    NphMieTable made = {.totals = work->cloud.totals, .sizes = work->cloud.points, .size_error = work->cloud.size_error,
                        .angle_error = work->error};
    NPH_TRY(nph_array_new(work->context, NPH_F64, 2, (int64_t[]){work->rows.count, 2}, work->what, &made.rows));
    for (int64_t i = 0; i < work->rows.count; i++) {
        ((double *)made.rows.data)[2 * i] = work->rows.degrees[i];
        ((double *)made.rows.data)[2 * i + 1] = work->rows.value[i];
    }
    integrate(&work->rows, &made.norm, &made.mean_cosine);
    *table = made;
    return NPH_OK;
}

NphStatus nph_mie_table(NphContext *context, const NphMieRequest *request, const char *what, NphMieTable *table) {
    Refinement work = {.context = context, .request = request, .what = what};
    int64_t open = 1;
    NphStatus status = begin(&work);
    while (status == NPH_OK && open > 0) status = refine(&work, &open);
    if (status == NPH_OK) status = finish(&work, table);
    Rows *both[2] = {&work.rows, &work.next};
    for (int i = 0; i < 2; i++) {
        nph_free(context, both[i]->degrees);
        nph_free(context, both[i]->value);
        nph_free(context, both[i]->parts);
    }
    nph_free(context, work.distance);
    nph_free(context, work.inner);
    nph_free(context, work.back);
    return status;
}

void nph_mie_table_free(NphContext *context, NphMieTable *table) { nph_array_free(context, &table->rows); }
