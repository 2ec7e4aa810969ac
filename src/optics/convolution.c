/* SPDX-License-Identifier: Apache-2.0
 *
 * Phase functions of several scatterings [Riley04 eq. 20, 23] from powers of moments (legendre.h). A block is a few angles, at which
 * one recurrence of P_l serves all numbers of scatterings. */
#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"
#include "core/reduce.h"
#include "optics/legendre.h"

enum { ANGLES_PER_BLOCK = 16, NEAR_MOST = 512 };

static const double PI = 3.14159265358979323846, LEAST = 1e-18;

typedef struct Convolving {
    int count, angles;
    int *lengths;         /* moments that count after i + 1 scatterings: fewer and fewer */
    double **power;       /* [count]: (2l + 1) / (4 pi) moment_l^(i+1) */
    double *distance;
    unsigned char *back;
    double *value;        /* [count][angles] */
} Convolving;

static NphStatus convolve_block(void *data, int64_t block, int worker) {
    (void)worker;
    Convolving *work = data;
    int end = (int)(block + 1) * ANGLES_PER_BLOCK < work->angles ? (int)(block + 1) * ANGLES_PER_BLOCK : work->angles;
    for (int a = (int)block * ANGLES_PER_BLOCK; a < end; a++) {
        double x = work->distance[a], p = 1.0, d = -x;
        for (int l = 0, count = work->count; count > 0; l++) {
            double signed_p = work->back[a] && l & 1 ? -p : p;
            while (count > 0 && l >= work->lengths[count - 1]) count--;
            for (int i = 0; i < count; i++) work->value[(int64_t)i * work->angles + a] += work->power[i][l] * signed_p;
            p += d;
            d = ((l + 1.0) * d - (2.0 * l + 3.0) * x * p) / (l + 2.0);
        }
    }
    return NPH_OK;
}

/* From a pole in steps that grow by a thirtieth from a fiftieth of the finest wave, 1 / moments, to 0.1 degrees. */
static int near_angles(int moments, double degrees[NEAR_MOST]) {
    double at = 0.0;
    int count = 0;
    for (double step = 0.02 / moments * (180.0 / PI); step < 0.1 && count < NEAR_MOST; step *= 1.0 + 1.0 / 30.0) {
        degrees[count++] = at;
        at += step;
    }
    if (count == 0) degrees[count++] = 0.0;
    return count;
}

/* Rows of angle and value; the values follow. */
static NphStatus make_angles(NphContext *context, Convolving *work, int moments, NphArray *rows) {
    double near[NEAR_MOST];
    int few = near_angles(moments, near), first = (int)(10.0 * near[few - 1]) + 1, every = 1801 - 2 * first;
    work->angles = 2 * few + every;
    NPH_TRY(nph_array_new(context, NPH_F64, 2, (int64_t[]){work->angles, 2}, "convolutions", rows));
    NPH_TRY(NPH_NEW(context, work->angles, "convolutions", &work->distance));
    NPH_TRY(NPH_NEW(context, work->angles, "convolutions", &work->back));
    for (int i = 0; i < work->angles; i++) {
        double degrees = i < few ? near[i] : i < few + every ? 0.1 * (i - few + first) : 180.0 - near[work->angles - 1 - i], sine, cosine;
        work->back[i] = degrees > 90.0;
        nph_sincos2pi((work->back[i] ? 180.0 - degrees : degrees) / 720.0, &sine, &cosine);
        work->distance[i] = 2.0 * sine * sine;
        ((double *)rows->data)[2 * i] = degrees;
    }
    return NPH_OK;
}

static NphStatus make_powers(NphContext *context, Convolving *work, int moments, const double *moment) {
    NPH_TRY(NPH_NEW(context, work->count, "convolutions", &work->lengths));
    NPH_TRY(NPH_NEW(context, work->count, "convolutions", &work->power));
    int length = moments;
    for (int i = 0; i < work->count; i++) {
        NPH_TRY(NPH_NEW(context, length, "convolutions", &work->power[i]));
        for (int l = 0; l < length; l++)
            work->power[i][l] = i > 0 ? work->power[i - 1][l] * moment[l] : (2.0 * l + 1.0) / (4.0 * PI) * moment[l];
        while (length > 1 && nph_abs(work->power[i][length - 1]) < LEAST) length--;
        work->lengths[i] = length;
    }
    return NPH_NEW(context, (int64_t)work->count * work->angles, "convolutions", &work->value);
}

static NphStatus tabulate(NphContext *context, const Convolving *work, NphArray *rows, const char *what, NphConvolutions *made) {
    double *at = rows->data;
    for (int i = 0; i < work->count; i++) {
        for (int a = 0; a < work->angles; a++) {
            double value = work->value[(int64_t)i * work->angles + a];
            made->negative = -value > made->negative ? -value : made->negative;
            at[2 * a + 1] = value > 0.0 ? value : 0.0;
        }
        NPH_TRY(nph_phase_tabulate(context, rows, what, &made->after[i]));
        made->count = i + 1;
        const NphPhaseHalf *front = &made->after[i].table->half[0];
        made->forward[i] = front->part[front->count];
    }
    return NPH_OK;
}

static void release(NphContext *context, Convolving *work, NphArray *rows) {
    for (int i = 0; i < work->count && work->power; i++) nph_free(context, work->power[i]);
    nph_free(context, work->power);
    nph_free(context, work->lengths);
    nph_free(context, work->value);
    nph_free(context, work->back);
    nph_free(context, work->distance);
    nph_array_free(context, rows);
}

NphStatus nph_phase_convolve(NphContext *context, int moments, const double *moment, int count, const char *what,
                             NphConvolutions *convolutions) {
    if (count < 1 || count > NPH_MOST_CONVOLUTIONS || moments < 1)
        return nph_error(context, NPH_BAD_USAGE, "%s: %d scatterings of %d moments; 1 to %d of at least 1 are possible", what, count, moments,
                         (int)NPH_MOST_CONVOLUTIONS);
    Convolving work = {.count = count};
    NphConvolutions made = {0};
    NphArray rows = {0};
    NphStatus status = make_angles(context, &work, moments, &rows);
    if (status == NPH_OK) status = make_powers(context, &work, moments, moment);
    if (status == NPH_OK) status = NPH_NEW(context, count, what, &made.after);
    if (status == NPH_OK) status = NPH_NEW(context, count, what, &made.forward);
    int64_t blocks = (work.angles + ANGLES_PER_BLOCK - 1) / ANGLES_PER_BLOCK;
    if (status == NPH_OK) status = nph_pool_run(context, blocks, convolve_block, &work, NULL);
    if (status == NPH_OK) status = tabulate(context, &work, &rows, what, &made);
    release(context, &work, &rows);
    if (status == NPH_OK) *convolutions = made;
    else nph_convolutions_free(context, &made);
    return status;
}

void nph_convolutions_free(NphContext *context, NphConvolutions *convolutions) {
    for (int i = 0; i < convolutions->count; i++) nph_phase_free(context, &convolutions->after[i]);
    nph_free(context, convolutions->after);
    nph_free(context, convolutions->forward);
    *convolutions = (NphConvolutions){0};
}
