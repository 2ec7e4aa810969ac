/* SPDX-License-Identifier: Apache-2.0
 *
 * Phase functions: probability density of the scattering direction over the sphere [1/sr], as a function of
 * cos_theta = dot of the propagation directions before and after (+1 is forward). */
#ifndef NPH_OPTICS_PHASE_H
#define NPH_OPTICS_PHASE_H

#include "nephos/array.h"
#include "nephos/status.h"

typedef enum NphPhaseKind {
    NPH_PHASE_ISOTROPIC, NPH_PHASE_HG, NPH_PHASE_TWO_LOBE, NPH_PHASE_RAYLEIGH, NPH_PHASE_DRAINE, NPH_PHASE_TABULATED,
    NPH_PHASE_KINDS
} NphPhaseKind;

/* The half of a tabulated function around one pole. In x = 1 - |cos|, the distance to the pole, the density is
 * piecewise linear. Arrays have count + 1 entries, guides buckets + 1. */
typedef struct NphPhaseHalf {
    int count;                /* intervals, at least 1 */
    int buckets;              /* of the guides */
    double *x;                /* rising from 0 to 1 */
    double *value;            /* 1/sr */
    double *part;             /* of the whole distribution nearer to the pole; both halves' last ones add to 1 */
    double part_scale;        /* 1 / the last part; 0 where that is 0 */
    int32_t *by_x, *by_part;  /* guides of the search (phase_table_lookup.h) */
} NphPhaseHalf;

typedef struct NphPhaseTable {
    NphPhaseHalf half[2]; /* from 0 degrees, from 180 degrees */
    double mean_cosine;
} NphPhaseTable;

/* isotropic: 1/4pi. hg: Henyey-Greenstein of mean cosine g[0]. two_lobe: weight * hg(g[0]) + (1-weight) * hg(g[1]).
 * rayleigh: 3/(16 pi) (1 + cos^2). draine: hg(g[0]) * (1 + alpha cos^2), normalised. tabulated: table.
 * |g| <= 0.99999, 0 <= alpha <= NPH_PHASE_MOST_ALPHA */
typedef struct NphPhase {
    NphPhaseKind kind;
    double g[2];
    double weight;
    double alpha;
    NphPhaseTable *table; /* tabulated: owned */
} NphPhase;

#define NPH_PHASE_MOST_ALPHA 1000.0
#define NPH_PHASE_MOST_VALUE 1e10 /* 1/sr: the peak of a table, some 6e-6 rad wide; single precision tells 1e-7 */

/* Value [1/sr] at cos_theta in [-1, 1], and the mean of cos_theta over the sphere. */
double nph_phase_value(const NphPhase *phase, double cos_theta);
double nph_phase_mean_cosine(const NphPhase *phase);

/* The largest value [1/sr] over all angles. */
double nph_phase_peak(const NphPhase *phase);

/* phase_table.c: makes a tabulated function of rows (f64, [n][2]: angle in degrees, rising within 0 to 180; value >=
 * 0 at any scale), n >= 2, normalised to 1 over the sphere. Between rows it is linear in the cosine. Where the rows
 * do not reach 0 or 180 degrees the outermost value goes on, with a warning. NPH_BAD_INPUT when all values are 0,
 * rows lie closer than doubles tell, or the peak is above NPH_PHASE_MOST_VALUE. */
NphStatus nph_phase_tabulate(NphContext *context, const NphArray *rows, const char *what, NphPhase *phase);
void nph_phase_free(NphContext *context, NphPhase *phase);

#endif
