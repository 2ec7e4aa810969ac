/* SPDX-License-Identifier: Apache-2.0
 *
 * From moments to the layers of a picture (docs/files.md).
 *
 * Variance of the mean: M2 / (n (n - 1)). Its relative variance is that of the sample variance s^2,
 *   Var(s^2) / sigma^4 = (mu4 / sigma^4 - (n - 3) / (n - 1)) / n,
 * exact for independent samples of any distribution, with the sample's own mu4 = M4 / n and sigma^2 = M2 / n put in:
 *   Vov = M4 / M2^2 - (n - 3) / (n (n - 1)),
 * which tends to 2 / n for a normal distribution and 8 / n for an exponential one; 0 where the variance is 0. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "core/float_state.h"
#include "core/memory.h"
#include "core/message.h"
#include "film/tree.h"

typedef struct Planes {
    float *colour[3], *alpha, *variance[3], *vov[3], *samples, *transmittance[3], *order, *depth;
} Planes;

/* A tile's folded values that several layers need. */
typedef struct TileValues {
    double n;
    double radiance[3][NPH_MOMENTS][NPH_TILE_PIXELS], transmittance[3][NPH_TILE_PIXELS];
    double order[NPH_TILE_PIXELS], distance[NPH_TILE_PIXELS], collided[NPH_TILE_PIXELS];
} TileValues;

double nph_film_variance_of_mean(double m2, double n) { return n > 1 ? m2 / (n * (n - 1)) : 0; }

double nph_film_vov(double m2, double m4, double n) {
    if (m2 == 0 || n <= 1) return 0;
    double vov = (m4 / m2) / m2 - (n - 3) / (n * (n - 1));
    return vov < 0 ? 0 : vov;
}

/* Nearest float. What is finite stays finite, counted in *clamped; every NaN becomes the same one. */
static float narrow(double x, int64_t *clamped) {
    if (x != x) return (float)NAN;
    if (x - x != 0) return (float)x;
    if (x > FLT_MAX || x < -FLT_MAX) {
        (*clamped)++;
        return x > 0 ? FLT_MAX : -FLT_MAX;
    }
    return (float)x;
}

/* A variance that is not 0 must not become 0, which would claim an exact value. */
static float narrow_variance(double x, int64_t *clamped) {
    float narrowed = narrow(x, clamped);
    return x > 0 && narrowed == 0 ? FLT_MIN * FLT_EPSILON : narrowed;
}

static void fold_tile(const NphFilm *film, int64_t tile, TileValues *values) {
    int channels = film->channels;
    values->n = (double)nph_film_tile_samples(film, tile);
    for (int c = 0; c < 3; c++) {
        if (c < channels) {
            nph_tree_fold_moments(film, tile, c, values->radiance[c]);
            nph_tree_fold_mean(film, tile, nph_film_value_transmittance(channels) + c, values->transmittance[c]);
        } else {
            memcpy(values->radiance[c], values->radiance[0], sizeof values->radiance[c]);
            memcpy(values->transmittance[c], values->transmittance[0], sizeof values->transmittance[c]);
        }
    }
    nph_tree_fold_mean(film, tile, nph_film_value_order(channels), values->order);
    nph_tree_fold_mean(film, tile, nph_film_value_distance(channels), values->distance);
    nph_tree_fold_mean(film, tile, nph_film_value_collided(channels), values->collided);
}

static double ratio_or_zero(double a, double b) { return b == 0 ? 0 : a / b; }

/* Pixel p of the tile's values to pixel `at` of the planes. */
static void write_pixel(const TileValues *values, int p, const Planes *planes, int64_t at, int64_t *clamped) {
    double n = values->n, luminance = 0, opacity = 0;
    for (int c = 0; c < 3; c++) {
        double mean = values->radiance[c][0][p], m2 = values->radiance[c][1][p], m4 = values->radiance[c][3][p];
        planes->colour[c][at] = narrow(mean, clamped);
        planes->variance[c][at] = narrow_variance(nph_film_variance_of_mean(m2, n), clamped);
        planes->vov[c][at] = narrow(nph_film_vov(m2, m4, n), clamped);
        planes->transmittance[c][at] = narrow(values->transmittance[c][p], clamped);
        luminance += nph_luminance_weights[c] * mean;
        opacity += 1 - values->transmittance[c][p];
    }
    planes->alpha[at] = n > 0 ? narrow(opacity / 3, clamped) : 0;
    planes->samples[at] = (float)n;
    planes->order[at] = narrow(ratio_or_zero(values->order[p], luminance), clamped);
    planes->depth[at] = narrow(ratio_or_zero(values->distance[p], values->collided[p]), clamped);
}

static NphStatus add_layers(NphContext *context, NphImage *image, Planes *planes) {
    static const char *const letters[3] = {"R", "G", "B"};
    static const char *const variance[3] = {"Variance.R", "Variance.G", "Variance.B"};
    static const char *const vov[3] = {"Vov.R", "Vov.G", "Vov.B"};
    static const char *const transmittance[3] = {"Transmittance.R", "Transmittance.G", "Transmittance.B"};
    for (int c = 0; c < 3; c++) NPH_TRY(nph_image_add_channel(context, image, letters[c], &planes->colour[c]));
    NPH_TRY(nph_image_add_channel(context, image, "A", &planes->alpha));
    for (int c = 0; c < 3; c++) NPH_TRY(nph_image_add_channel(context, image, variance[c], &planes->variance[c]));
    for (int c = 0; c < 3; c++) NPH_TRY(nph_image_add_channel(context, image, vov[c], &planes->vov[c]));
    NPH_TRY(nph_image_add_channel(context, image, "N", &planes->samples));
    for (int c = 0; c < 3; c++)
        NPH_TRY(nph_image_add_channel(context, image, transmittance[c], &planes->transmittance[c]));
    NPH_TRY(nph_image_add_channel(context, image, "Order.Y", &planes->order));
    return nph_image_add_channel(context, image, "Z", &planes->depth);
}

static NphStatus add_attributes(NphContext *context, const NphFilm *film, NphImage *image) {
    for (int i = 0; i < film->text_count; i++)
        NPH_TRY(nph_image_set_text(context, image, film->texts[i].name, film->texts[i].text));
    int64_t least, most;
    nph_film_samples_range(film, &least, &most);
    if (least != most) NPH_TRY(nph_image_set_number(context, image, "samples_least", NPH_ATTRIBUTE_INT, (double)least));
    return nph_image_set_number(context, image, "samples", NPH_ATTRIBUTE_INT, (double)most);
}

static void write_tiles(const NphFilm *film, TileValues *values, const Planes *planes, int64_t *clamped) {
    int width = film->crop[2] - film->crop[0];
    for (int64_t tile = 0; tile < film->tile_count; tile++) {
        int origin[2], inside[4];
        nph_film_tile_rect(film, tile, origin, inside);
        fold_tile(film, tile, values);
        for (int y = inside[1]; y < inside[3]; y++)
            for (int x = inside[0]; x < inside[2]; x++) {
                int64_t at = (int64_t)(y - film->crop[1]) * width + (x - film->crop[0]);
                write_pixel(values, (y - origin[1]) * NPH_TILE + x - origin[0], planes, at, clamped);
            }
    }
}

/* The variance of the mean of the region that a pixel lies in, and its Vov. */
static void write_region(const NphFilm *film, int level, const int at[2], const float value[2], float *const planes[2]) {
    const NphFilm *coarse = film->regions[level];
    int width = film->crop[2] - film->crop[0], height = film->crop[3] - film->crop[1];
    int x0, x1, y0, y1;
    nph_region_span(at[0], coarse->width, nph_region_sizes[level], width, &x0, &x1);
    nph_region_span(at[1], coarse->height, nph_region_sizes[level], height, &y0, &y1);
    for (int y = y0; y < y1; y++)
        for (int x = x0; x < x1; x++)
            for (int k = 0; k < 2; k++) planes[k][(int64_t)y * width + x] = value[k];
}

static void write_level(const NphFilm *film, int level, int channel, float *const planes[2], int64_t *clamped) {
    const NphFilm *coarse = film->regions[level];
    for (int64_t tile = 0; tile < coarse->tile_count; tile++) {
        double moments[NPH_MOMENTS][NPH_TILE_PIXELS], n = (double)nph_film_tile_samples(coarse, tile);
        int origin[2], inside[4];
        nph_film_tile_rect(coarse, tile, origin, inside);
        nph_tree_fold_moments(coarse, tile, channel < film->channels ? channel : 0, moments);
        for (int y = inside[1]; y < inside[3]; y++)
            for (int x = inside[0]; x < inside[2]; x++) {
                int p = (y - origin[1]) * NPH_TILE + x - origin[0];
                float value[2] = {narrow_variance(nph_film_variance_of_mean(moments[1][p], n), clamped),
                                  narrow(nph_film_vov(moments[1][p], moments[3][p], n), clamped)};
                write_region(film, level, (int[2]){x, y}, value, planes);
            }
    }
}

/* Where pixels share samples: the noise of the regions that verdicts rest on. */
static NphStatus add_regions(NphContext *context, const NphFilm *film, NphImage *image, int64_t *clamped) {
    for (int level = 0; level < NPH_REGION_LEVELS; level++)
        for (int c = 0; c < 3; c++) {
            float *planes[2];
            NPH_TRY(nph_image_add_channel(context, image, nph_region_variance[level][c], &planes[0]));
            NPH_TRY(nph_image_add_channel(context, image, nph_region_vov[level][c], &planes[1]));
            write_level(film, level, c, planes, clamped);
        }
    return NPH_OK;
}

static NphStatus fill_image(NphContext *context, const NphFilm *film, NphImage *image) {
    Planes planes;
    TileValues *values = NULL;
    int64_t clamped = 0;
    NPH_TRY(add_layers(context, image, &planes));
    NPH_TRY(add_attributes(context, film, image));
    NPH_TRY(NPH_NEW(context, 1, "picture", &values));
    write_tiles(film, values, &planes, &clamped);
    nph_free(context, values);
    if (nph_film_is_shared(film)) NPH_TRY(add_regions(context, film, image, &clamped));
    if (clamped)
        nph_warn(context, "picture: %lld values beyond +-%g, the largest of a float, are written as that",
                 (long long)clamped, (double)FLT_MAX);
    return NPH_OK;
}

NphStatus nph_film_image(NphContext *context, const NphFilm *film, NphImage *image) {
    NphFloatState state;
    NphImage made;
    NPH_TRY(nph_image_new(context, film->crop[2] - film->crop[0], film->crop[3] - film->crop[1], &made));
    made.x0 = film->crop[0];
    made.y0 = film->crop[1];
    made.full_width = film->width;
    made.full_height = film->height;
    nph_float_state_enter(&state);
    NphStatus status = fill_image(context, film, &made);
    nph_float_state_leave(&state);
    if (status != NPH_OK) {
        nph_image_free(context, &made);
        return status;
    }
    *image = made;
    return NPH_OK;
}
