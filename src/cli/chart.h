/* SPDX-License-Identifier: Apache-2.0
 *
 * A chart of phase functions over the scattering angle: linear, logarithmic, or polar with a logarithmic radius. Drawn as lines and
 * words on a page of SVG or of PNG pixels. */
#ifndef NPH_CLI_CHART_H
#define NPH_CLI_CHART_H

#include <stdint.h>

#include "nephos/context.h"

typedef enum ChartKind { CHART_LINEAR, CHART_LOG, CHART_POLAR } ChartKind;

enum { CHART_MOST_CURVES = 64, CHART_WIDTH = 960, CHART_HEIGHT = 640 };

typedef struct ChartCurve {
    const char *name;
    uint8_t rgb[3];
    int count;
    const double *degrees, *value; /* rising; 1/sr, at least 0 */
} ChartCurve;

typedef struct Chart {
    ChartKind kind;
    const char *title;
    int count;
    const ChartCurve *curves;
} Chart;

/* By the ending of the path: .svg or .png. */
NphStatus chart_write(NphContext *context, const Chart *chart, const char *path);

#endif
