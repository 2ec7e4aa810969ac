/* SPDX-License-Identifier: Apache-2.0
 *
 * An 8-bit sRGB preview [IEC 61966-2-1]. Level v is shown from the radiance whose transfer is (v - 0.5) / 255 on: the
 * 255 thresholds are computed once, so pixels only compare. Light below 0 is black, above 1 white, and what is not
 * finite is magenta. */
#include <math.h>
#include <stdlib.h>

#include "core/float_state.h"
#include "core/memory.h"
#include "core/message.h"
#include "film/tree.h"
#include "io/volume.h"

static const double percentile_target = 0.8, most_stops = 100;

/* w^2.4 for 0 < w <= 1: w^2 times the fifth root of w^2, by Newton's rule from above, which falls until it is exact. */
static double power_2_4(double w) {
    double square = w * w, root = 1;
    for (int i = 0; i < 64; i++) {
        double fourth = root * root * root * root;
        root -= (fourth * root - square) / (5 * fourth);
    }
    return square * root;
}

/* 2^x, exact for whole x: the digits of its fraction choose among the roots 2^(1/2), 2^(1/4), ... */
static double power_of_two(double x) {
    double whole = floor(x), rest = x - whole, result = ldexp(1.0, (int)whole), root = 2;
    while (rest > 0) {
        root = sqrt(root);
        rest *= 2;
        if (rest < 1) continue;
        result *= root;
        rest -= 1;
    }
    return result;
}

static double linear_of_srgb(double shown) {
    return shown <= 0.04045 ? shown / 12.92 : power_2_4((shown + 0.055) / 1.055);
}

static void fill_thresholds(double thresholds[255]) {
    for (int v = 0; v < 255; v++) thresholds[v] = linear_of_srgb((v + 0.5) / 255.0);
}

/* How many thresholds are at most x. */
static uint8_t quantise(const double thresholds[255], double x) {
    int low = 0, high = 255;
    while (low < high) {
        int middle = (low + high) / 2;
        if (thresholds[middle] <= x)
            low = middle + 1;
        else
            high = middle;
    }
    return (uint8_t)low;
}

/* Mean radiance of the crop, [pixel][3]. */
static void fill_linear(const NphFilm *film, double *linear) {
    double moments[NPH_MOMENTS][NPH_TILE_PIXELS];
    int width = film->crop[2] - film->crop[0];
    for (int64_t tile = 0; tile < film->tile_count; tile++) {
        int origin[2], inside[4];
        nph_film_tile_rect(film, tile, origin, inside);
        for (int c = 0; c < 3; c++) {
            if (c < film->channels) nph_tree_fold_moments(film, tile, c, moments);
            for (int y = inside[1]; y < inside[3]; y++)
                for (int x = inside[0]; x < inside[2]; x++) {
                    int64_t at = (int64_t)(y - film->crop[1]) * width + (x - film->crop[0]);
                    linear[3 * at + c] = moments[0][(y - origin[1]) * NPH_TILE + x - origin[0]];
                }
        }
    }
}

static int is_finite(const double *rgb) {
    double poison = (rgb[0] - rgb[0]) + (rgb[1] - rgb[1]) + (rgb[2] - rgb[2]);
    return poison == 0;
}

static int rising(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The luminance shown as 0.8: the 99th percentile (nearest rank), or the largest when that is not positive. */
static double reference_luminance(const double *linear, int64_t pixels, double *sorted) {
    int64_t count = 0;
    for (int64_t i = 0; i < pixels; i++) {
        const double *rgb = linear + 3 * i, *w = nph_luminance_weights;
        if (is_finite(rgb)) sorted[count++] = w[0] * rgb[0] + w[1] * rgb[1] + w[2] * rgb[2];
    }
    if (count == 0) return 0;
    qsort(sorted, (size_t)count, sizeof *sorted, rising);
    double reference = sorted[count - 1 - count / 100];
    return reference > 0 ? reference : sorted[count - 1];
}

static void write_pixels(const double *linear, int64_t pixels, double divisor, double factor, uint8_t *rgb) {
    double thresholds[255];
    fill_thresholds(thresholds);
    for (int64_t i = 0; i < pixels; i++, linear += 3, rgb += 3) {
        if (!is_finite(linear)) {
            rgb[0] = rgb[2] = 255;
            rgb[1] = 0;
            continue;
        }
        for (int c = 0; c < 3; c++) rgb[c] = quantise(thresholds, linear[c] / divisor * factor);
    }
}

static NphStatus preview(NphContext *context, const NphFilm *film, double exposure_stops, uint8_t *rgb) {
    int64_t pixels = (int64_t)(film->crop[2] - film->crop[0]) * (film->crop[3] - film->crop[1]);
    double *linear = NULL, divisor = 1, factor = 1;
    NPH_TRY(NPH_NEW(context, 3 * pixels, "preview", &linear));
    fill_linear(film, linear);
    if (exposure_stops == exposure_stops) {
        factor = power_of_two(exposure_stops);
    } else {
        double *sorted = NULL;
        NphStatus status = NPH_NEW(context, pixels, "preview", &sorted);
        if (status != NPH_OK) {
            nph_free(context, linear);
            return status;
        }
        double reference = reference_luminance(linear, pixels, sorted);
        nph_free(context, sorted);
        if (reference > 0) {
            divisor = reference;
            factor = percentile_target;
        }
    }
    write_pixels(linear, pixels, divisor, factor, rgb);
    nph_free(context, linear);
    return NPH_OK;
}

NphStatus nph_film_preview(NphContext *context, const NphFilm *film, double exposure_stops, uint8_t *rgb, int *width,
                           int *height) {
    if (exposure_stops < -most_stops || exposure_stops > most_stops)
        return nph_error(context, NPH_BAD_USAGE, "preview: an exposure of %g stops is not in -100 to 100",
                         exposure_stops);
    if (rgb) {
        NphFloatState state;
        nph_float_state_enter(&state);
        NphStatus status = preview(context, film, exposure_stops, rgb);
        nph_float_state_leave(&state);
        NPH_TRY(status);
    }
    *width = film->crop[2] - film->crop[0];
    *height = film->crop[3] - film->crop[1];
    return NPH_OK;
}

NphStatus nph_film_write_png(NphContext *context, const NphFilm *film, double exposure_stops, const char *path) {
    int width = film->crop[2] - film->crop[0], height = film->crop[3] - film->crop[1];
    uint8_t *rgb = NULL;
    NPH_TRY(nph_alloc(context, (size_t)width * (size_t)height, 3, "preview", (void **)&rgb));
    NphStatus status = nph_film_preview(context, film, exposure_stops, rgb, &width, &height);
    if (status == NPH_OK) status = nph_png_write(context, path, width, height, rgb);
    nph_free(context, rgb);
    return status;
}
