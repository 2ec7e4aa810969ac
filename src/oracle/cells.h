/* SPDX-License-Identifier: Apache-2.0
 *
 * What a stage wrote, held against what somebody else's wrote, buffer by buffer. An item (a path, by its identity) whose decision
 * fell the other way differs in everything of that launch: it counts as turned over where integers say so, and its
 * numbers are not compared. Reads two sides of a launch, calls back for each buffer. */
#ifndef NPH_ORACLE_CELLS_H
#define NPH_ORACLE_CELLS_H

#include "pipeline/method.h"
#include "nephos/stage.h"

/* The buffers of one launch, of one side: outputs, then inputs. */
typedef struct NphSide {
    int count, outputs;
    NphNamedArray buffers[2 * NPH_MAX_BUFFERS];
} NphSide;

void nph_side_free(NphContext *context, NphSide *side);

/* By octave: 0; up to 1, 2, 4, ... 2^61; more. */
enum { NPH_OCTAVES = 64 };
int nph_octave(double ulp);

/* One buffer of a launch. Differences of numbers are in units in the last place of the reference's value or of the largest value in its
 * row, whichever are fewer; those of integers are whole. Values from 1e30 on stand for nowhere and are no row's largest. */
typedef struct NphBufferGap {
    const NphBuffer *buffer;
    char problem[192];     /* missing, misshaped: nothing is compared; else empty */
    double limit;
    int64_t cells, beyond; /* compared; more than `limit` apart, for integers different */
    int64_t items, turned; /* likewise, of items: places along the last axis, or identities in a queue */
    int64_t octaves[NPH_OCTAVES]; /* of cells */
    const double *gap;     /* of numbers: the largest of each item; negative: not compared */
    int64_t gap_count;
    int rank;              /* the largest: where, what */
    int64_t index[NPH_MAX_RANK];
    double reference, candidate, ulp, absolute;
} NphBufferGap;

typedef struct NphCellWatch {
    void *user;
    double (*limit)(void *user, const NphBuffer *buffer); /* of numbers */
    NphStatus (*take)(void *user, const NphBufferGap *gap);
} NphCellWatch;

/* precision: the reference's: where it is 32, doubles of it (moments) are no better than floats. */
NphStatus nph_compare_sides(NphContext *context, const NphMethod *method, int precision, const NphSide *ours, const NphSide *theirs,
                            const NphCellWatch *watch);

#endif
