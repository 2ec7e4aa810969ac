/* SPDX-License-Identifier: Apache-2.0
 *
 * The phase function of spheres as rows of a table. Angles begin a degree apart, and towards the poles as close as the largest
 * sphere's peaks ask for; an interval is halved, and its middle kept, until the value there lies within half the tolerance of the straight
 * line in the cosine that a table has between its rows. What is left between rows is about an eighth of it. */
#ifndef NPH_OPTICS_MIE_TABLE_H
#define NPH_OPTICS_MIE_TABLE_H

#include "nephos/array.h"
#include "optics/mie_cloud.h"

enum { NPH_MIE_MOST_ANGLES = 1 << 18 };

typedef struct NphMieTable {
    NphArray rows;          /* f64 [n][2]: degrees, 1/sr; owned */
    NphMieTotals totals;
    int64_t sizes;
    double size_error, angle_error; /* of halvings: at most the tolerance and half of it, unless a warning said so */
    double norm, mean_cosine;       /* of the rows: 1 and the asymmetry but for the tolerance; the table itself is normalised */
} NphMieTable;

/* Interruptible; the rows are the same for any number of threads. */
NphStatus nph_mie_table(NphContext *context, const NphMieRequest *request, const char *what, NphMieTable *table);
void nph_mie_table_free(NphContext *context, NphMieTable *table);

#endif
