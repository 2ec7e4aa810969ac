/* SPDX-License-Identifier: Apache-2.0
 *
 * Builds an environment map and its sampling tables from a latitude-longitude image. Row j lies between the polar angles
 * pi j / H and pi (j + 1) / H; a texel's solid angle is 2 pi / W times the difference of their cosines, taken as
 * 2 sin(pi (2j + 1) / 2H) sin(pi / 2H), which does not cancel. */
#include <float.h>

#include "core/fmath.h"
#include "core/memory.h"
#include "core/message.h"
#include "core/reduce.h"
#include "light/light.h"

static double luminance(const float *rgb) {
    return 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] + 0.0722 * (double)rgb[2];
}

static double row_solid_angle(int height, int row) {
    double middle, step, unused;
    nph_sincos2pi(0.25 * (2.0 * row + 1.0) / height, &middle, &unused);
    nph_sincos2pi(0.25 / height, &step, &unused);
    return 12.566370614359173 * middle * step;
}

/* cdf[i] = sum of weights before i over the sum of all; the last is 1. Entries of weight 0 have no width, also the
 * trailing ones: the running sum does not change there. Returns the sum; 0 leaves cdf alone. */
static double accumulate(const double *weights, int count, double *cdf) {
    double sum = 0.0;
    NphSum exact = {0};
    for (int i = 0; i < count; i++) sum += weights[i];
    if (sum == 0.0) return 0.0;
    double running = 0.0;
    for (int i = 0; i < count; i++) {
        cdf[i] = running / sum;
        running += weights[i];
        nph_sum_add(&exact, weights[i]);
    }
    cdf[count] = 1.0;
    return nph_sum_value(exact);
}

static void uniform(double *cdf, int count) {
    for (int i = 0; i <= count; i++) cdf[i] = (double)i / count;
}

/* Fills the tables. The weights are scratch, width and height numbers. */
static void build_tables(NphEnvironment *map, double *weights, double *row_weights) {
    int width = map->width, height = map->height;
    for (int row = 0; row < height; row++) {
        double *cdf = map->column_cdf + (int64_t)row * (width + 1);
        for (int column = 0; column < width; column++)
            weights[column] = luminance(map->radiance + 3 * ((int64_t)row * width + column));
        double sum = accumulate(weights, width, cdf);
        if (sum == 0.0) uniform(cdf, width);
        row_weights[row] = sum * row_solid_angle(height, row) / width;
    }
    map->total = accumulate(row_weights, height, map->row_cdf);
    if (map->total > 0.0) return;
    for (int row = 0; row < height; row++) row_weights[row] = row_solid_angle(height, row);
    accumulate(row_weights, height, map->row_cdf);
}

/* What a map is built from, and what was met there. */
typedef struct Source {
    NphContext *context;
    const NphImage *image;
    const double *scale;
    const char *what;
    int64_t negative;
} Source;

/* Scaled and checked values of one channel to the components first to last. */
static NphStatus take_channel(Source *source, const NphChannel *channel, int first, int last, float *radiance) {
    const NphImage *image = source->image;
    int64_t count = (int64_t)image->width * image->height;
    for (int64_t i = 0; i < count; i++) {
        float value = channel->pixels[i];
        int x = image->x0 + (int)(i % image->width), y = image->y0 + (int)(i / image->width);
        if (!(nph_absf(value) <= FLT_MAX))
            return nph_error(source->context, NPH_BAD_INPUT, "%s: channel %s is %s at pixel (%d, %d); radiance must be "
                             "finite", source->what, channel->name, value != value ? "not a number" : "infinite", x, y);
        source->negative += value < 0.0f;
        for (int c = first; c <= last; c++) {
            double scaled = value < 0.0f ? 0.0 : (double)value * source->scale[c];
            if (scaled > (double)FLT_MAX)
                return nph_error(source->context, NPH_BAD_INPUT, "%s: channel %s times its scale is %g at pixel (%d, %d); "
                                 "at most %g is possible", source->what, channel->name, scaled, x, y, (double)FLT_MAX);
            radiance[3 * i + c] = (float)scaled;
        }
    }
    return NPH_OK;
}

static NphStatus take_radiance(Source *source, float *radiance) {
    static const char *const names[3] = {"R", "G", "B"};
    const NphChannel *rgb[3], *grey = nph_image_channel(source->image, "Y");
    int found = 0;
    for (int c = 0; c < 3; c++) {
        rgb[c] = nph_image_channel(source->image, names[c]);
        found += rgb[c] != NULL;
    }
    if (found != 3 && (found > 0 || !grey))
        return nph_error(source->context, NPH_BAD_INPUT, "%s: has %s%s%s%s; an environment map needs the channels R, G "
                         "and B, or Y", source->what, rgb[0] ? "R " : "", rgb[1] ? "G " : "", rgb[2] ? "B " : "",
                         found ? "only" : "none of R, G, B, Y");
    for (int c = 0; c < (found ? 3 : 1); c++)
        NPH_TRY(take_channel(source, found ? rgb[c] : grey, c, found ? c : 2, radiance));
    if (source->negative)
        nph_warn(source->context, "%s: %lld negative values are taken as 0", source->what, (long long)source->negative);
    return NPH_OK;
}

static NphStatus new_map(NphContext *context, int width, int height, NphEnvironment *map) {
    map->width = width;
    map->height = height;
    NPH_TRY(NPH_NEW(context, 3 * (int64_t)width * height, "radiance of an environment map", &map->radiance));
    NPH_TRY(NPH_NEW(context, (int64_t)height + 1, "rows of an environment map", &map->row_cdf));
    return NPH_NEW(context, height * ((int64_t)width + 1), "columns of an environment map", &map->column_cdf);
}

static NphStatus finish(NphContext *context, NphEnvironment *map) {
    double *weights = NULL, *row_weights = NULL;
    NphStatus status = NPH_NEW(context, map->width, "weights of an environment map", &weights);
    if (status == NPH_OK) status = NPH_NEW(context, map->height, "weights of an environment map", &row_weights);
    if (status == NPH_OK) build_tables(map, weights, row_weights);
    nph_free(context, weights);
    nph_free(context, row_weights);
    return status;
}

static NphStatus build(Source *source, NphEnvironment *map) {
    NPH_TRY(new_map(source->context, source->image->width, source->image->height, map));
    NPH_TRY(take_radiance(source, map->radiance));
    return finish(source->context, map);
}

NphStatus nph_environment_build(NphContext *context, const NphImage *image, const double scale[3], const char *what,
                                NphEnvironment *map) {
    for (int c = 0; c < 3; c++)
        if (!(scale[c] >= 0.0 && scale[c] <= DBL_MAX))
            return nph_error(context, NPH_BAD_INPUT, "%s: its scale is %g; 0 or more is allowed", what, scale[c]);
    if (image->x0 != 0 || image->y0 != 0 || image->width != image->full_width || image->height != image->full_height)
        return nph_error(context, NPH_BAD_INPUT, "%s: its %d x %d pixels from (%d, %d) are not the whole %d x %d image; "
                         "an environment map must be complete", what, image->width, image->height, image->x0, image->y0,
                         image->full_width, image->full_height);
    Source source = {context, image, scale, what, 0};
    NphEnvironment made = {0};
    NphStatus status = build(&source, &made);
    if (status == NPH_OK) *map = made;
    else nph_environment_free(context, &made);
    return status;
}

NphStatus nph_environment_of_texels(NphContext *context, int width, int height, const double *texels, NphEnvironment *map) {
    NphEnvironment made = {0};
    NphStatus status = new_map(context, width, height, &made);
    for (int64_t i = 0; i < 3 * (int64_t)width * height && status == NPH_OK; i++) made.radiance[i] = (float)texels[i];
    if (status == NPH_OK) status = finish(context, &made);
    if (status == NPH_OK) *map = made;
    else nph_environment_free(context, &made);
    return status;
}

NphStatus nph_environment_uniform(NphContext *context, int height, const double radiance[3], NphEnvironment *map) {
    NphEnvironment made = {0};
    NphStatus status = new_map(context, 1, height, &made);
    for (int i = 0; i < 3 * height && status == NPH_OK; i++) made.radiance[i] = (float)radiance[i % 3];
    if (status == NPH_OK) status = finish(context, &made);
    if (status == NPH_OK) *map = made;
    else nph_environment_free(context, &made);
    return status;
}

NphStatus nph_environment_scale_rows(NphContext *context, const double *factors, NphEnvironment *map) {
    int64_t row_values = 3 * (int64_t)map->width;
    for (int64_t i = 0; i < row_values * map->height; i++)
        map->radiance[i] = (float)((double)map->radiance[i] * factors[3 * (i / row_values) + i % 3]);
    return finish(context, map);
}

void nph_environment_free(NphContext *context, NphEnvironment *map) {
    nph_free(context, map->radiance);
    nph_free(context, map->row_cdf);
    nph_free(context, map->column_cdf);
    *map = (NphEnvironment){0};
}
