/* SPDX-License-Identifier: Apache-2.0
 *
 * See chart.h. The scale of a linear chart ends at the largest value beyond 5 degrees, that of the others at whole decades; a polar
 * chart has 0 degrees to the right, the upper half of the circle for the function and the lower for its mirror image. */
#include "cli/chart.h"

#include <string.h>

#include "cli/page.h"
#include "core/fmath.h"
#include "core/memory.h"
#include "core/message.h"
#include "io/file.h"
#include "io/volume.h"

enum { NAMES = 13 }; /* that find room */

static const uint8_t ink[3] = {40, 40, 40}, grid[3] = {220, 220, 220};
static const double LEFT = 90.0, RIGHT = 24.0, TOP = 48.0, BOTTOM = 64.0, LN10 = 2.302585092994046;

typedef struct Scale {
    double low, high; /* of the value, or of its decimal logarithm */
    double step;      /* between marks */
    int decades;      /* logarithmic */
} Scale;

static double decades_of(double value) { return nph_log(value) / LN10; }

/* The least above 0 and the largest; beyond 5 degrees where `outer`. */
static void range_of(const Chart *chart, int outer, double range[2]) {
    range[0] = nph_infinity();
    range[1] = 0.0;
    for (int c = 0; c < chart->count; c++)
        for (int i = 0; i < chart->curves[c].count; i++) {
            double value = chart->curves[c].value[i];
            if (outer && chart->curves[c].degrees[i] < 5.0) continue;
            range[1] = value > range[1] ? value : range[1];
            range[0] = value > 0.0 && value < range[0] ? value : range[0];
        }
}

/* At most ten marks: 1, 2 or 5 times a power of ten apart. */
static double even_step(double most) {
    static const double steps[] = {1.0, 2.0, 5.0, 10.0};
    double unit = nph_exp(LN10 * nph_floor(decades_of(most / 10.0)));
    int i = 0;
    while (i < 3 && steps[i] * unit * 10.0 < most) i++;
    return steps[i] * unit;
}

static Scale scale_of(const Chart *chart) {
    double range[2];
    Scale scale = {0.0, 1.0, 1.0, chart->kind != CHART_LINEAR};
    range_of(chart, !scale.decades, range);
    if (!(range[1] > 0.0)) return scale;
    if (!scale.decades) {
        scale.step = even_step(range[1]);
        scale.high = scale.step * nph_floor(range[1] / scale.step + 0.999999);
        return scale;
    }
    scale.low = nph_floor(decades_of(range[0]));
    scale.high = nph_floor(decades_of(range[1]) + 0.999999);
    if (scale.high - scale.low < 1.0) scale.high = scale.low + 1.0;
    if (scale.high - scale.low > 16.0) scale.low = scale.high - 16.0;
    scale.step = scale.high - scale.low > 10.0 ? 2.0 : 1.0;
    return scale;
}

/* In [0, 1]. */
static double part_of(const Scale *scale, double value) {
    double at = !scale->decades ? value : value > 0.0 ? decades_of(value) : scale->low, part = (at - scale->low) / (scale->high - scale->low);
    return part < 0.0 ? 0.0 : part > 1.0 ? 1.0 : part;
}

static void place(const Chart *chart, const Page *page, double degrees, double part, double at[2]) {
    double wide = page->width - LEFT - RIGHT, high = page->height - TOP - BOTTOM;
    if (chart->kind != CHART_POLAR) {
        at[0] = LEFT + wide * degrees / 180.0;
        at[1] = page->height - BOTTOM - high * part;
        return;
    }
    double sine, cosine, radius = 0.45 * (high < wide ? high : wide) * part;
    nph_sincos2pi(degrees / 360.0, &sine, &cosine);
    at[0] = LEFT + 0.5 * wide + radius * cosine;
    at[1] = TOP + 0.5 * high - radius * sine;
}

static void mark_text(const Scale *scale, double mark, char text[32]) {
    if (scale->decades) snprintf(text, 32, "1e%d", (int)nph_rint(mark));
    else snprintf(text, 32, "%.3g", mark);
}

static void draw_axes(const Chart *chart, const Scale *scale, Page *page) {
    char text[32];
    for (int k = 0; scale->low + k * scale->step <= scale->high + 1e-9 * scale->step; k++) {
        double mark = scale->low + k * scale->step, part = (mark - scale->low) / (scale->high - scale->low), line[2 * 181];
        mark_text(scale, mark, text);
        int points = chart->kind == CHART_POLAR ? 181 : 2;
        for (int i = 0; i < points; i++) place(chart, page, points == 2 ? 180.0 * i : 2.0 * i, part, line + 2 * (ptrdiff_t)i);
        page_lines(page, points, line, 1.0, grid);
        if (chart->kind == CHART_POLAR) page_text(page, line[2 * 45] + 4.0, line[2 * 45 + 1] - 2.0, PAGE_LEFT, text, ink);
        else page_text(page, LEFT - 8.0, line[1] + 5.0, PAGE_RIGHT, text, ink);
    }
    int turn = chart->kind == CHART_POLAR ? 360 : 181;
    for (int degrees = 0; degrees < turn; degrees += chart->kind == CHART_POLAR ? 30 : 20) {
        double line[4], beyond[2];
        place(chart, page, degrees, 0.0, line);
        place(chart, page, degrees, 1.0, line + 2);
        page_lines(page, 2, line, 1.0, grid);
        snprintf(text, sizeof text, "%d", degrees > 180 ? 360 - degrees : degrees);
        place(chart, page, degrees, 1.07, beyond);
        if (chart->kind == CHART_POLAR) page_text(page, beyond[0], beyond[1] + 5.0, PAGE_MIDDLE, text, ink);
        else page_text(page, line[0], page->height - BOTTOM + 22.0, PAGE_MIDDLE, text, ink);
    }
    page_text(page, 0.5 * page->width, page->height - 12.0, PAGE_MIDDLE, "scattering angle (degrees), value (1/sr)", ink);
    page_text(page, 0.5 * page->width, 28.0, PAGE_MIDDLE, chart->title, ink);
}

/* Points of a curve; in a polar chart those of its mirror image follow backwards. */
static NphStatus draw_curve(NphContext *context, const Chart *chart, const Scale *scale, const ChartCurve *curve, Page *page) {
    int points = chart->kind == CHART_POLAR ? 2 * curve->count : curve->count;
    double *line = NULL;
    NPH_TRY(NPH_NEW(context, 2 * (int64_t)points, "chart", &line));
    for (int i = 0; i < points; i++) {
        int k = i < curve->count ? i : 2 * curve->count - 1 - i;
        place(chart, page, i < curve->count ? curve->degrees[k] : 360.0 - curve->degrees[k], part_of(scale, curve->value[k]), line + 2 * (ptrdiff_t)i);
    }
    page_lines(page, points, line, 1.6, curve->rgb);
    nph_free(context, line);
    return NPH_OK;
}

static NphStatus draw(NphContext *context, const Chart *chart, Page *page) {
    Scale scale = scale_of(chart);
    page_begin(page);
    draw_axes(chart, &scale, page);
    for (int c = 0; c < chart->count; c++) NPH_TRY(draw_curve(context, chart, &scale, &chart->curves[c], page));
    int every = (chart->count + NAMES - 1) / NAMES;
    double y = TOP;
    for (int c = 0; c < chart->count && chart->count > 1; c += every)
        page_text(page, page->width - RIGHT - 8.0, y += 22.0, PAGE_RIGHT, chart->curves[c].name, chart->curves[c].rgb);
    page_end(page);
    return NPH_OK;
}

static NphStatus write_svg(NphContext *context, const Chart *chart, Page *page, const char *path) {
    NphWriter writer = {0};
    NPH_TRY(nph_writer_open(context, path, &writer));
    page->svg = writer.stream;
    NphStatus status = draw(context, chart, page);
    if (status == NPH_OK) return nph_writer_commit(context, &writer);
    nph_writer_abandon(context, &writer);
    return status;
}

NphStatus chart_write(NphContext *context, const Chart *chart, const char *path) {
    Page page = {.width = CHART_WIDTH, .height = CHART_HEIGHT};
    size_t length = strlen(path);
    if (length > 4 && strcmp(path + length - 4, ".svg") == 0) return write_svg(context, chart, &page, path);
    NPH_TRY(NPH_NEW(context, 3 * CHART_WIDTH * CHART_HEIGHT, "chart", &page.rgb));
    NphStatus status = draw(context, chart, &page);
    if (status == NPH_OK) status = nph_png_write(context, path, page.width, page.height, page.rgb);
    nph_free(context, page.rgb);
    return status;
}
