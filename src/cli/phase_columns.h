/* SPDX-License-Identifier: Apache-2.0
 *
 * Phase functions side by side over one list of angles, and what of them is written to files. */
#ifndef NPH_CLI_PHASE_COLUMNS_H
#define NPH_CLI_PHASE_COLUMNS_H

#include "cli/chart.h"
#include "nephos/array.h"
#include "optics/phase.h"

typedef struct PhaseColumns {
    int count;
    const char *title;                            /* of all: one line, ASCII */
    char names[CHART_MOST_CURVES][48];            /* "550 nm", "2 scatterings" */
    uint8_t rgb[CHART_MOST_CURVES][3];
    NphPhase phases[CHART_MOST_CURVES];           /* owned */
    double forward[CHART_MOST_CURVES];            /* the part in front of 90 degrees, F of [Riley04 eq. 23] */
} PhaseColumns;

void phase_columns_free(NphContext *context, PhaseColumns *columns);

/* f64 [n][1 + columns]: degrees, 1/sr. rows > 1: evenly spaced; 0: where any of the tables has a row, 1801 for closed forms. */
NphStatus phase_columns_rows(NphContext *context, const PhaseColumns *columns, int64_t rows, NphArray *array);

/* NPH_BAD_USAGE, told, for an ending that is none of .txt .csv .npy .h .glsl .wgsl .svg .png. */
NphStatus phase_file_check(const char *command, const char *path);
NphStatus phase_file_write(NphContext *context, const PhaseColumns *columns, const NphArray *rows, ChartKind kind, const char *path);

#endif
