/* SPDX-License-Identifier: Apache-2.0
 *
 * LDR-FLIP [Andersson20] of bands of rows, the largest of all exposures for HDR-FLIP [Andersson21 section 3]. A band
 * holds the opponent channels of its rows and of those that the filters reach; a row is filtered down the columns, then
 * along itself. Bands write disjoint rows of the map. */
#include "core/fmath.h"
#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"
#include "oracle/flip_parts.h"

enum { ROWS = 32, LANES = 8 };

/* X/Xn, Y/Yn, Z/Zn of linear R, G, B and back: exact from the primaries and the white of sRGB [IEC 61966-2-1]. */
static const double xyz_from_rgb[3][3] = {
    {1013504.0 / 2335869, 878810.0 / 2335869, 443555.0 / 2335869},
    {87098.0 / 409605, 175762.0 / 245763, 12673.0 / 175545},
    {15836.0 / 892167, 878810.0 / 8029503, 7008169.0 / 8029503},
};
static const double rgb_from_xyz[3][3] = {
    {121953.0 / 39590, -329.0 / 214, -10749.0 / 19795},
    {-8095803.0 / 8788100, 1648619.0 / 878810, 397713.0 / 8788100},
    {9381.0 / 177422, -2585.0 / 12673, 10749.0 / 9338},
};
/* [Andersson20 section 4.1.3, 4.2 and 4.3] */
static const double colour_power = 0.7, break_colour = 0.4, break_error = 0.95, half_root = 0.7071067811865476;

/* A row of a picture after its filters. */
typedef struct Row {
    double *lab[3], *edge, *point;
} Row;

/* One worker's memory. */
typedef struct Scratch {
    double *opponent[2][3]; /* ROWS + 2 reach rows of `stride` */
    double *down[NPH_FLIP_CSFS], *across[4], *padded;
    Row row[2];
    double *memory;
} Scratch;

typedef struct Bands {
    const NphFlipTask *task;
    NphFlipFilters filters;
    int reach;          /* rows and columns that a filter reaches */
    int64_t stride;
    double most_colour; /* green against blue */
    Scratch *scratch;
} Bands;

static double clamp(double x) { return x < 0.0 ? 0.0 : x > 1.0 ? 1.0 : x; }

static void transform(const double matrix[3][3], const double from[3], double to[3]) {
    for (int i = 0; i < 3; i++) to[i] = matrix[i][0] * from[0] + matrix[i][1] * from[1] + matrix[i][2] * from[2];
}

double nph_flip_aces(double x) { return (0.9036 * x * x + 0.018 * x) / (0.8748 * x * x + 0.354 * x + 0.14); }

double nph_flip_aces_inverse(double y) {
    double a = 0.9036 - 0.8748 * y, b = 0.018 - 0.354 * y, c = -0.14 * y;
    return (nph_sqrt(b * b - 4.0 * a * c) - b) / (2.0 * a);
}

static double lab_curve(double t) {
    return t > 216.0 / 24389 ? nph_cbrt(t) : t * (841.0 / 108) + 4.0 / 29;
}

void nph_flip_lab(const double rgb[3], double lab[3]) {
    double xyz[3], f[3];
    transform(xyz_from_rgb, rgb, xyz);
    for (int i = 0; i < 3; i++) f[i] = lab_curve(xyz[i]);
    lab[0] = 116.0 * f[1] - 16.0;
    lab[1] = 0.01 * lab[0] * 500.0 * (f[0] - f[1]);
    lab[2] = 0.01 * lab[0] * 200.0 * (f[1] - f[2]);
}

double nph_flip_hyab(const double a[3], const double b[3]) {
    double da = a[1] - b[1], db = a[2] - b[2];
    return nph_abs(a[0] - b[0]) + nph_sqrt(da * da + db * db);
}

static void fill_opponent(const NphFlipTask *task, const NphFlipPicture *picture, int64_t pixel, double factor,
                          double opponent[3]) {
    double rgb[3], xyz[3];
    for (int c = 0; c < 3; c++) {
        double x = picture->value[c][pixel];
        x = x > 0.0 ? x * factor : 0.0;
        rgb[c] = clamp(task->tone_mapped ? nph_flip_aces(x) : x);
    }
    transform(xyz_from_rgb, rgb, xyz);
    opponent[0] = 116.0 * xyz[1] - 16.0;
    opponent[1] = 500.0 * (xyz[0] - xyz[1]);
    opponent[2] = 200.0 * (xyz[1] - xyz[2]);
}

/* The opponent channels of a picture from row y - reach on; outside, the picture's border goes on. */
static void fill_band(const Bands *bands, const NphFlipPicture *picture, int y, double factor, double *const planes[3]) {
    const NphFlipTask *task = bands->task;
    for (int row = 0; row < ROWS + 2 * bands->reach; row++) {
        int from = y - bands->reach + row;
        from = from < 0 ? 0 : from >= task->height ? task->height - 1 : from;
        for (int x = 0; x < task->width; x++) {
            double opponent[3];
            fill_opponent(task, picture, (int64_t)from * task->width + x, factor, opponent);
            for (int c = 0; c < 3; c++) planes[c][row * bands->stride + x] = opponent[c];
        }
    }
}

/* out[x] = sum over k of taps[k] in[k step + x], x below `stride`, a multiple of LANES. */
static void filter(const double *restrict in, int64_t step, const double *restrict taps, int count, int64_t stride,
                   double *restrict out) {
    for (int64_t x = 0; x < stride; x += LANES) {
        double sum[LANES] = {0};
        for (int k = 0; k < count; k++)
            for (int lane = 0; lane < LANES; lane++) sum[lane] += taps[k] * in[k * step + x + lane];
        for (int lane = 0; lane < LANES; lane++) out[x + lane] = sum[lane];
    }
}

static void filter_down(const Bands *bands, const double *plane, int row, const double *taps, int radius, double *out) {
    const double *in = plane + (bands->reach + row - radius) * bands->stride;
    filter(in, bands->stride, taps, 2 * radius + 1, bands->stride, out);
}

static void pad(const Bands *bands, const double *row, int radius, double *padded) {
    int width = bands->task->width;
    for (int x = 0; x < radius; x++) padded[x] = row[0];
    for (int x = 0; x < width; x++) padded[radius + x] = row[x];
    for (int64_t x = radius + width; x < bands->stride + 2 * radius; x++) padded[x] = row[width - 1];
}

static void filter_across(const Bands *bands, const double *padded, const double *taps, int radius, double *out) {
    filter(padded, 1, taps, 2 * radius + 1, bands->stride, out);
}

/* [Andersson20 section 4.1.1 and 4.1.2]: what the eye cannot resolve is filtered out; the rest in a uniform space. */
static void fill_colour(const Bands *bands, double *const planes[3], int row, Scratch *scratch, double *const lab[3]) {
    static const int channel[NPH_FLIP_CSFS] = {0, 1, 2, 2};
    const NphFlipFilters *filters = &bands->filters;
    double *const *across = scratch->across;
    for (int i = 0; i < NPH_FLIP_CSFS; i++) {
        filter_down(bands, planes[channel[i]], row, filters->csf[i], filters->csf_radius, scratch->down[0]);
        pad(bands, scratch->down[0], filters->csf_radius, scratch->padded);
        filter_across(bands, scratch->padded, filters->csf[i], filters->csf_radius, across[i]);
    }
    for (int x = 0; x < bands->task->width; x++) {
        double cz = filters->cz_1 * across[NPH_FLIP_CZ_1][x] + filters->cz_2 * across[NPH_FLIP_CZ_2][x];
        double y = (across[NPH_FLIP_Y][x] + 16.0) / 116.0, rgb[3], adjusted[3];
        transform(rgb_from_xyz, (const double[3]){y + across[NPH_FLIP_CX][x] / 500.0, y, y - cz / 200.0}, rgb);
        for (int c = 0; c < 3; c++) rgb[c] = clamp(rgb[c]);
        nph_flip_lab(rgb, adjusted);
        for (int c = 0; c < 3; c++) lab[c][x] = adjusted[c];
    }
}

/* [Andersson20 section 4.2]: sizes of the first and second derivatives of luminance, in Y/Yn, not in Y. */
static void fill_features(const Bands *bands, const double *luminance, int row, Scratch *scratch, Row *made) {
    const NphFlipFilters *filters = &bands->filters;
    const double *taps[3] = {filters->feature_gauss, filters->edge, filters->point};
    int radius = filters->feature_radius;
    double *const *across = scratch->across;
    for (int i = 0; i < 3; i++) filter_down(bands, luminance, row, taps[i], radius, scratch->down[i]);
    pad(bands, scratch->down[0], radius, scratch->padded);
    filter_across(bands, scratch->padded, filters->edge, radius, across[0]);
    filter_across(bands, scratch->padded, filters->point, radius, across[1]);
    for (int i = 1; i < 3; i++) {
        pad(bands, scratch->down[i], radius, scratch->padded);
        filter_across(bands, scratch->padded, filters->feature_gauss, radius, across[i + 1]);
    }
    for (int x = 0; x < bands->task->width; x++) {
        made->edge[x] = nph_sqrt(across[0][x] * across[0][x] + across[2][x] * across[2][x]) / 116.0;
        made->point[x] = nph_sqrt(across[1][x] * across[1][x] + across[3][x] * across[3][x]) / 116.0;
    }
}

/* [Andersson20 section 4.1.3]: differences above 0.4 of the largest take the last 0.05. */
static double redistribute(double colour, double most) {
    double at = break_colour * most;
    return colour < at ? break_error / at * colour : break_error + (colour - at) / (most - at) * (1.0 - break_error);
}

/* [Andersson20 section 4.3] */
static double error_of(const Bands *bands, const Row *left, const Row *right, int x) {
    double a[3], b[3];
    for (int c = 0; c < 3; c++) {
        a[c] = left->lab[c][x];
        b[c] = right->lab[c][x];
    }
    double colour = redistribute(nph_pow(nph_flip_hyab(a, b), colour_power), bands->most_colour);
    double edge = nph_abs(left->edge[x] - right->edge[x]);
    double point = nph_abs(left->point[x] - right->point[x]);
    double feature = nph_sqrt(clamp(half_root * (edge > point ? edge : point)));
    return clamp(nph_pow(colour, 1.0 - feature));
}

static void finish_row(const Bands *bands, Scratch *scratch, int y, int row, int first) {
    const NphFlipTask *task = bands->task;
    for (int k = 0; k < 2; k++) {
        fill_colour(bands, scratch->opponent[k], row, scratch, scratch->row[k].lab);
        fill_features(bands, scratch->opponent[k][0], row, scratch, &scratch->row[k]);
    }
    double *map = task->map + (int64_t)(y + row) * task->width;
    for (int x = 0; x < task->width; x++) {
        double error = error_of(bands, &scratch->row[0], &scratch->row[1], x);
        if (first || error > map[x]) map[x] = error;
    }
}

static double exposure_of(const NphFlipTask *task, int i) {
    double step = task->exposures > 1 ? (task->stop_stops - task->start_stops) / (task->exposures - 1) : 0.0;
    return nph_exp2(task->start_stops + i * step);
}

static NphStatus run_band(void *data, int64_t band, int worker) {
    const Bands *bands = data;
    const NphFlipTask *task = bands->task;
    Scratch *scratch = &bands->scratch[worker];
    int y = (int)band * ROWS, rows = task->height - y < ROWS ? task->height - y : ROWS;
    for (int i = 0; i < task->exposures; i++) {
        for (int k = 0; k < 2; k++)
            fill_band(bands, &task->picture[k], y, exposure_of(task, i), scratch->opponent[k]);
        for (int row = 0; row < rows; row++) finish_row(bands, scratch, y, row, i == 0);
    }
    return NPH_OK;
}

static NphStatus scratch_new(NphContext *context, const Bands *bands, Scratch *scratch) {
    int64_t stride = bands->stride, plane = (ROWS + 2 * (int64_t)bands->reach) * stride;
    int64_t rows = NPH_FLIP_CSFS + 4 + 2 * 5;
    NPH_TRY(NPH_NEW(context, 2 * 3 * plane + (rows + 1) * stride + 2 * bands->reach, "rows of FLIP",
                    &scratch->memory));
    double *at = scratch->memory;
    for (int k = 0; k < 2; k++)
        for (int c = 0; c < 3; c++, at += plane) scratch->opponent[k][c] = at;
    for (int i = 0; i < NPH_FLIP_CSFS; i++, at += stride) scratch->down[i] = at;
    for (int i = 0; i < 4; i++, at += stride) scratch->across[i] = at;
    for (int k = 0; k < 2; k++) {
        Row *row = &scratch->row[k];
        for (int c = 0; c < 3; c++, at += stride) row->lab[c] = at;
        row->edge = at;
        row->point = at + stride;
        at += 2 * stride;
    }
    scratch->padded = at;
    return NPH_OK;
}

static NphStatus run_bands(NphContext *context, Bands *bands) {
    int workers = nph_context_threads(context);
    NPH_TRY(NPH_NEW(context, workers, "workers of FLIP", &bands->scratch));
    NphStatus status = NPH_OK;
    for (int i = 0; i < workers && status == NPH_OK; i++) status = scratch_new(context, bands, &bands->scratch[i]);
    if (status == NPH_OK)
        status = nph_pool_run(context, (bands->task->height + ROWS - 1) / ROWS, run_band, bands, NULL);
    for (int i = 0; i < workers; i++) nph_free(context, bands->scratch[i].memory);
    nph_free(context, bands->scratch);
    return status;
}

NphStatus nph_flip_run(NphContext *context, const NphFlipTask *task) {
    Bands bands = {.task = task, .stride = (task->width + LANES - 1) / LANES * LANES};
    double green[3], blue[3];
    nph_flip_lab((const double[3]){0, 1, 0}, green);
    nph_flip_lab((const double[3]){0, 0, 1}, blue);
    bands.most_colour = nph_pow(nph_flip_hyab(green, blue), colour_power);
    NPH_TRY(nph_flip_filters(context, task->pixels_per_degree, &bands.filters));
    int csf = bands.filters.csf_radius, feature = bands.filters.feature_radius;
    bands.reach = csf > feature ? csf : feature;
    NphStatus status = run_bands(context, &bands);
    nph_flip_filters_free(context, &bands.filters);
    return status;
}
