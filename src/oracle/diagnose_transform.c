/* SPDX-License-Identifier: Apache-2.0
 *
 * Mistakes made of a finished picture. What moves, exchanges or scales pixels is done to the right picture B, whose pixels are
 * independent; an encoding is taken off A, so that the noise is judged where it was made. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/message.h"
#include "film/regions.h"
#include "oracle/diagnose.h"

#define PI 3.14159265358979323846

static const char *const values[3] = {"R", "G", "B"};
static const char *const variances[3] = {"Variance.R", "Variance.G", "Variance.B"};
static const char *const vovs[3] = {"Vov.R", "Vov.G", "Vov.B"};

/* A's pixel (x, y) shows what is at u = (map[0] x + map[1] y + map[2] + map[3] (width - 1), likewise v) of B. */
typedef struct Map {
    const char *name;
    int square;            /* width and height change places */
    double u[4], v[4];
} Map;

static const Map maps[] = {
    {"as it is", 0, {1, 0, 0, 0}, {0, 1, 0, 0}},
    {"mirrored: left is right", 0, {-1, 0, 0, 1}, {0, 1, 0, 0}},
    {"upside down", 0, {1, 0, 0, 0}, {0, -1, 0, 1}},
    {"turned by 180 degrees", 0, {-1, 0, 0, 1}, {0, -1, 0, 1}},
    {"rows are columns", 1, {0, 1, 0, 0}, {1, 0, 0, 0}},
    {"rows are columns, from the other corner", 1, {0, -1, 0, 1}, {-1, 0, 0, 1}},
    {"turned by 90 degrees clockwise", 1, {0, 1, 0, 0}, {-1, 0, 0, 1}},
    {"turned by 90 degrees anticlockwise", 1, {0, -1, 0, 1}, {1, 0, 0, 0}},
};
enum { MAPS = sizeof maps / sizeof maps[0], ORDERS = 5 };

typedef struct Order {
    const char *name;
    int from[3];
} Order;
static const Order orders[ORDERS] = {
    {"red and blue exchanged", {2, 1, 0}},        {"red and green exchanged", {1, 0, 2}},
    {"green and blue exchanged", {0, 2, 1}},      {"channels moved on: R shows G, G shows B", {1, 2, 0}},
    {"channels moved on: R shows B, G shows R", {2, 0, 1}},
};

/* One transform of B; encoding: of A, 1 sRGB, 2 gamma 2.2. */
typedef struct Change {
    Map map;
    int from[3], alpha, encoding;
    double factor[3];
} Change;

static Change no_change(void) { return (Change){.map = maps[0], .from = {0, 1, 2}, .factor = {1.0, 1.0, 1.0}}; }

static const float *plane(const NphImage *image, const char *name) {
    const NphChannel *channel = nph_image_channel(image, name);
    return channel ? channel->pixels : NULL;
}

/* The pixels around a place and their weights. */
typedef struct Taps {
    int64_t at[4];
    double weight[4];
} Taps;

static int clamped(double at, int length) { return at < 0.0 ? 0 : at > length - 1 ? length - 1 : (int)at; }

static Taps taps_of(const NphImage *image, const Map *map, int x, int y) {
    double u = map->u[0] * x + map->u[1] * y + map->u[2] + map->u[3] * (image->width - 1);
    double v = map->v[0] * x + map->v[1] * y + map->v[2] + map->v[3] * (image->height - 1);
    double left = floor(u), top = floor(v), right_part = u - left, lower_part = v - top;
    Taps taps;
    for (int k = 0; k < 4; k++) {
        int right = k % 2, lower = k / 2, column = clamped(left + right, image->width), row = clamped(top + lower, image->height);
        taps.at[k] = (int64_t)row * image->width + column;
        taps.weight[k] = (right ? right_part : 1.0 - right_part) * (lower ? lower_part : 1.0 - lower_part);
    }
    return taps;
}

/* What the channel is multiplied by at a pixel: the factor, and the opacity or one over it. */
static double scale_at(const Change *change, const float *alpha, int64_t at, int channel) {
    double opacity = change->alpha && alpha ? (double)alpha[at] : 1.0;
    if (change->alpha < 0) opacity = opacity > 0.0 ? 1.0 / opacity : 0.0;
    return change->factor[channel] * opacity;
}

static void change_channel(const NphImage *image, const Change *change, int channel, float *const out[3]) {
    int from = change->from[channel];
    const float *value = plane(image, values[from]), *variance = plane(image, variances[from]), *vov = plane(image, vovs[from]);
    const float *alpha = plane(image, "A");
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width; x++) {
            Taps taps = taps_of(image, &change->map, x, y);
            double sum = 0.0, noise = 0.0, spread = 0.0;
            for (int k = 0; k < 4; k++) {
                double scale = scale_at(change, alpha, taps.at[k], channel) * taps.weight[k];
                double part = scale * scale * (double)variance[taps.at[k]];
                sum += scale * (double)value[taps.at[k]];
                noise += part;
                spread += (double)vov[taps.at[k]] * part * part;
            }
            int64_t i = (int64_t)y * image->width + x;
            out[0][i] = (float)sum;
            out[1][i] = (float)noise;
            out[2][i] = out[1][i] > 0.0f ? (float)(spread / (noise * noise)) : 0.0f;
        }
}

/* B with the change made; without N, since interpolated pixels have no number of samples. */
static NphStatus change_image(NphContext *context, const NphImage *image, const Change *change, NphImage *changed) {
    NphImage made;
    NPH_TRY(nph_image_new(context, image->width, image->height, &made));
    made.x0 = image->x0;
    made.y0 = image->y0;
    NphStatus status = NPH_OK;
    for (int c = 0; c < 3 && status == NPH_OK; c++) {
        float *out[3];
        status = nph_image_add_channel(context, &made, values[c], &out[0]);
        if (status == NPH_OK) status = nph_image_add_channel(context, &made, variances[c], &out[1]);
        if (status == NPH_OK) status = nph_image_add_channel(context, &made, vovs[c], &out[2]);
        if (status == NPH_OK) change_channel(image, change, c, out);
    }
    const NphAttribute *samples = nph_image_attribute(image, "samples");
    if (status == NPH_OK && samples)
        status = nph_image_set_number(context, &made, "samples", NPH_ATTRIBUTE_DOUBLE, samples->number);
    if (status == NPH_OK) *changed = made;
    else nph_image_free(context, &made);
    return status;
}

/* The linear value that was stored as x. [IEC 61966-2-1] */
static double decoded(double x, int encoding) {
    if (x <= 0.0) return x;
    if (encoding == 2) return pow(x, 2.2);
    return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
}

/* d decoded / dx, x > 0. */
static double decoded_slope(double x, int encoding) {
    if (encoding == 2) return 2.2 * pow(x, 1.2);
    return x <= 0.04045 ? 1.0 / 12.92 : 2.4 / 1.055 * pow((x + 0.055) / 1.055, 1.4);
}

/* ln of the factor from the likelihood of the decoded values to that of A's own, a tile: the mean of the pixels that are lit. */
static double decoded_density(const NphImage *a, int encoding) {
    double sum = 0.0, count = 0.0;
    for (int c = 0; c < 3; c++) {
        const float *value = plane(a, values[c]);
        for (int64_t i = 0; i < (int64_t)a->width * a->height; i++) {
            if (!(value[i] > 0.0f)) continue;
            sum += log(decoded_slope((double)value[i], encoding));
            count += 1.0;
        }
    }
    return count > 0.0 ? sum / count : 0.0;
}

static NphStatus decode_image(NphContext *context, const NphImage *a, int encoding, NphImage *decoded_a) {
    NphImage made;
    NPH_TRY(nph_image_new(context, a->width, a->height, &made));
    made.x0 = a->x0;
    made.y0 = a->y0;
    NphStatus status = NPH_OK;
    for (int c = 0; c < 3 && status == NPH_OK; c++) {
        const float *value = plane(a, values[c]);
        float *out = NULL;
        status = nph_image_add_channel(context, &made, values[c], &out);
        for (int64_t i = 0; status == NPH_OK && i < (int64_t)a->width * a->height; i++) out[i] = (float)decoded((double)value[i], encoding);
    }
    if (status == NPH_OK) *decoded_a = made;
    else nph_image_free(context, &made);
    return status;
}

/* ---- a shift and a factor by least squares ---- */

/* B as it is and its central differences; of a difference the noise is (v(i + 1) + v(i - 1)) / 4. */
typedef struct Slope {
    double value[3], noise[3];
} Slope;

static Slope slope_at(const float *value, const float *variance, int64_t i, int width) {
    const int64_t step[2] = {1, width};
    Slope slope = {{(double)value[i]}, {(double)variance[i]}};
    for (int k = 0; k < 2; k++) {
        slope.value[k + 1] = 0.5 * ((double)value[i + step[k]] - (double)value[i - step[k]]);
        slope.noise[k + 1] = 0.25 * ((double)variance[i + step[k]] + (double)variance[i - step[k]]);
    }
    return slope;
}

/* The 3 x 3 system m p = r, by Cramer's rule; 0 when it is singular. Also the inverse's diagonal. */
static int solve(double m[3][3], const double r[3], double p[3], double diagonal[3]) {
    double minor[3][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            int a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
            minor[i][j] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
        }
    double determinant = m[0][0] * minor[0][0] + m[0][1] * minor[0][1] + m[0][2] * minor[0][2];
    if (!(fabs(determinant) > 1e-12 * fabs(m[0][0] * m[1][1] * m[2][2]))) return 0;
    for (int i = 0; i < 3; i++) {
        p[i] = (minor[0][i] * r[0] + minor[1][i] * r[1] + minor[2][i] * r[2]) / determinant;
        diagonal[i] = minor[i][i] / determinant;
    }
    return 1;
}

/* A - B = (f - 1) B - s . grad B. B's noise makes its own squares too large: that part is taken off. The error bar is that of
 * the residual's scatter. */
NphStatus nph_fit_shift(NphContext *context, const NphImage *a, const NphImage *b, NphShift *shift) {
    double m[3][3] = {{0}}, r[3] = {0}, squares = 0.0, count = 0.0, p[3], diagonal[3];
    for (int c = 0; c < 3; c++) {
        const float *of_a = plane(a, values[c]), *of_b = plane(b, values[c]), *variance = plane(b, variances[c]);
        for (int y = 1; y + 1 < b->height; y++)
            for (int x = 1; x + 1 < b->width; x++) {
                int64_t i = (int64_t)y * b->width + x;
                Slope slope = slope_at(of_b, variance, i, b->width);
                double d = (double)of_a[i] - (double)of_b[i];
                for (int j = 0; j < 3; j++) {
                    for (int k = 0; k < 3; k++) m[j][k] += slope.value[j] * slope.value[k] - (j == k ? slope.noise[j] : 0.0);
                    r[j] += slope.value[j] * d;
                }
                r[0] += slope.noise[0]; /* d holds -B, B holds it too */
                squares += d * d;
                count += 1.0;
            }
    }
    if (count < 8.0 || !solve(m, r, p, diagonal))
        return nph_error(context, NPH_BAD_INPUT, "a picture of %d x %d pixels without slopes shows no shift", b->width, b->height);
    double residual = (squares - p[0] * r[0] - p[1] * r[1] - p[2] * r[2]) / count;
    for (int k = 0; k < 2; k++) {
        shift->pixels[k] = -p[k + 1];
        shift->error[k] = sqrt(fabs((residual > 0.0 ? residual : 0.0) * diagonal[k + 1]));
    }
    return NPH_OK;
}

/* ---- names of factors ---- */

static const NphConstant known_factors[] = {
    {"pi", {PI, PI, PI}},
    {"4 pi", {4 * PI, 4 * PI, 4 * PI}},
    {"2 pi", {2 * PI, 2 * PI, 2 * PI}},
    {"1 / pi", {1 / PI, 1 / PI, 1 / PI}},
    {"1 / 4 pi", {0.25 / PI, 0.25 / PI, 0.25 / PI}},
    {"1 / 2 pi", {0.5 / PI, 0.5 / PI, 0.5 / PI}},
    {"2", {2, 2, 2}},
    {"1 / 2", {0.5, 0.5, 0.5}},
    {"4", {4, 4, 4}},
    {"1 / 4", {0.25, 0.25, 0.25}},
    {"255", {255, 255, 255}},
    {"1 / 255", {1 / 255.0, 1 / 255.0, 1 / 255.0}},
};
enum { KNOWN_FACTORS = sizeof known_factors / sizeof known_factors[0] };

/* How far off, in standard errors: the largest of the channels'. */
static double distance_to(const NphTransform *t, const NphConstant *constant) {
    double most = 0.0;
    for (int c = 0; c < 3; c++) {
        double error = t->factor_error[c] + 1e-6 * fabs(t->factor[c]), z = fabs(t->factor[c] - constant->value[c]) / error;
        if (z > most) most = z;
    }
    return most;
}

/* The nearest known constant within three standard errors, where these are below 5%. */
static void name_factor(const NphFitOptions *options, NphTransform *t) {
    double least = 3.0;
    if (t->factors == 0 || !(t->factor_error[0] < 0.05 * fabs(t->factor[0]))) return;
    for (int i = 0; i < KNOWN_FACTORS + options->constant_count; i++) {
        const NphConstant *constant = i < KNOWN_FACTORS ? &known_factors[i] : &options->constants[i - KNOWN_FACTORS];
        double z = distance_to(t, constant);
        if (z >= least) continue;
        least = z;
        snprintf(t->known, sizeof t->known, "%s", constant->name);
    }
}

/* ---- trying ---- */

typedef struct Trial {
    NphContext *context;
    const NphImage *a, *right;
    const NphFitOptions *options;
    double offset;         /* of scores */
    int count;
    NphTransform *found;
} Trial;

/* Fits A to the changed B. */
static NphStatus fit_change(const Trial *trial, const NphImage *a, const Change *change, NphFit *fit) {
    NphImage changed;
    NPH_TRY(change_image(trial->context, trial->right, change, &changed));
    NphStatus status = nph_fit(trial->context, a, &changed, trial->options, fit);
    nph_image_free(trial->context, &changed);
    return status;
}

static NphStatus measure_shift(const Trial *trial, const NphImage *a, const Change *change, NphTransform *t) {
    NphImage changed;
    NphShift rest;
    NPH_TRY(change_image(trial->context, trial->right, change, &changed));
    NphStatus status = nph_fit_shift(trial->context, a, &changed, &rest);
    nph_image_free(trial->context, &changed);
    if (status != NPH_OK) return status;
    t->shifted = 1;
    t->shift = rest;
    t->shift.pixels[0] -= change->map.u[2];
    t->shift.pixels[1] -= change->map.v[2];
    return NPH_OK;
}

static NphStatus keep(Trial *trial, const NphImage *a, const char *name, const Change *change, NphTransform *t) {
    snprintf(t->name, sizeof t->name, "%s", name);
    name_factor(trial->options, t);
    if (change->map.u[2] != 0.0 || change->map.v[2] != 0.0) NPH_TRY(measure_shift(trial, a, change, t));
    int fitted = t->factors + 2 * t->shifted;
    t->fit.score += trial->offset - log((double)NPH_MAX_TRANSFORMS) - 0.5 * fitted * log(t->fit.tiles + 1.0);
    trial->found[trial->count++] = *t;
    return NPH_OK;
}

/* One factor (3 channels: one each) that makes the means equal; 0 where there is none. */
static int take_factors(const NphFit *before, int factors, Change *change, NphTransform *t) {
    t->factors = factors;
    for (int c = 0; c < 3; c++) {
        int of = factors == 1 ? 3 : c;
        if (!(before->ratio[of] > 0.0) || !isfinite(before->ratio[of])) return 0;
        change->factor[c] = t->factor[c] = before->ratio[of];
        t->factor_error[c] = before->ratio_error[of];
    }
    return 1;
}

static int has_colours(const NphFit *fit) {
    return fabs(fit->ratio[0] - fit->ratio[1]) + fabs(fit->ratio[2] - fit->ratio[1]) > 1e-5 * fabs(fit->ratio[1]);
}

/* As it is, then with up to so many fitted factors; the first that A does not exclude is kept. An encoding or an opacity with a
 * free factor would fit too much. */
static NphStatus try_change(Trial *trial, const NphImage *a, const char *name, const Change *change, int most_factors) {
    NphTransform t;
    NphFit before;
    memset(&t, 0, sizeof t);
    NPH_TRY(fit_change(trial, a, change, &before));
    t.fit = before;
    if (!before.excluded) return keep(trial, a, name, change, &t);
    for (int factors = 1; factors <= (has_colours(&before) ? most_factors : most_factors > 0); factors += 2) {
        Change scaled = *change;
        if (!take_factors(&before, factors, &scaled, &t)) continue;
        NPH_TRY(fit_change(trial, a, &scaled, &t.fit));
        if (!t.fit.excluded) return keep(trial, a, name, &scaled, &t);
    }
    return NPH_OK;
}

static NphStatus try_maps(Trial *trial) {
    for (int i = 0; i < MAPS; i++) {
        Change change = no_change();
        change.map = maps[i];
        if (maps[i].square && trial->right->width != trial->right->height) continue;
        NPH_TRY(try_change(trial, trial->a, i ? maps[i].name : "a factor", &change, i ? 1 : 3));
    }
    return NPH_OK;
}

static NphStatus try_shifts(Trial *trial) {
    for (int i = 0; i < 25; i++) {
        Change change = no_change();
        int column = i % 5 - 2, row = i / 5 - 2;
        change.map.u[2] = 0.5 * column;
        change.map.v[2] = 0.5 * row;
        if (i == 12) continue;
        NPH_TRY(try_change(trial, trial->a, "shifted", &change, 0));
    }
    return NPH_OK;
}

static int is_grey(const NphImage *image) {
    size_t bytes = (size_t)image->width * (size_t)image->height * sizeof(float);
    return memcmp(plane(image, "R"), plane(image, "G"), bytes) == 0 && memcmp(plane(image, "R"), plane(image, "B"), bytes) == 0;
}

static NphStatus try_colours(Trial *trial) {
    if (is_grey(trial->right)) return NPH_OK;
    for (int i = 0; i < ORDERS; i++) {
        Change change = no_change();
        memcpy(change.from, orders[i].from, sizeof change.from);
        NPH_TRY(try_change(trial, trial->a, orders[i].name, &change, 1));
    }
    return NPH_OK;
}

static NphStatus try_opacity(Trial *trial) {
    static const char *const names[2] = {"divided by the opacity (not premultiplied)", "multiplied by the opacity once more"};
    if (!nph_image_channel(trial->right, "A")) return NPH_OK;
    for (int i = 0; i < 2; i++) {
        Change change = no_change();
        change.alpha = i ? 1 : -1;
        NPH_TRY(try_change(trial, trial->a, names[i], &change, 0));
    }
    return NPH_OK;
}

static NphStatus try_encodings(Trial *trial) {
    static const char *const names[2] = {"encoded as sRGB", "encoded with gamma 2.2"};
    for (int i = 0; i < 2; i++) {
        Change change = no_change();
        NphImage linear;
        NPH_TRY(decode_image(trial->context, trial->a, i + 1, &linear));
        double tiles = (double)nph_regions_along(linear.width, 8) * nph_regions_along(linear.height, 8);
        trial->offset = tiles * decoded_density(trial->a, i + 1);
        NphStatus status = try_change(trial, &linear, names[i], &change, 0);
        trial->offset = 0.0;
        nph_image_free(trial->context, &linear);
        if (status != NPH_OK) return status;
    }
    return NPH_OK;
}

static int better_first(const void *left, const void *right) {
    double a = ((const NphTransform *)left)->fit.score, b = ((const NphTransform *)right)->fit.score;
    return (a < b) - (a > b);
}

NphStatus nph_fit_transforms(NphContext *context, const NphImage *a, const NphImage *right, const NphFitOptions *options,
                             int *count, NphTransform *transforms) {
    Trial trial = {.context = context, .a = a, .right = right, .options = options, .found = transforms};
    NPH_TRY(try_maps(&trial));
    NPH_TRY(try_colours(&trial));
    NPH_TRY(try_opacity(&trial));
    NPH_TRY(try_encodings(&trial));
    NPH_TRY(try_shifts(&trial));
    qsort(transforms, (size_t)trial.count, sizeof *transforms, better_first);
    *count = trial.count;
    return NPH_OK;
}
