/* SPDX-License-Identifier: Apache-2.0
 *
 * Noise of a whole picture, from the pixels' moments; allocates nothing.
 *
 * Pixels are independent, their channels are not: with s_c the standard error of a channel's mean, that of a pixel's
 * luminance is at most s = sum w_c s_c. Over the P pixels that have samples:
 *   relative_error = sqrt(sum s^2) / P / mean,   relative_rmse = sqrt(sum s^2 / P) / mean.
 * Where pixels share samples they are not independent: relative_error is then that of the image's own mean. */
#include <assert.h>
#include <math.h>

#include "core/float_state.h"
#include "film/tree.h"

const double nph_luminance_weights[3] = {NPH_LUMINANCE_RED, NPH_LUMINANCE_GREEN, NPH_LUMINANCE_BLUE};

void nph_film_samples_range(const NphFilm *film, int64_t *least, int64_t *most) {
    *least = *most = nph_film_tile_samples(film, 0);
    for (int64_t tile = 1; tile < film->tile_count; tile++) {
        int64_t samples = nph_film_tile_samples(film, tile);
        if (samples < *least) *least = samples;
        if (samples > *most) *most = samples;
    }
}

typedef struct Sums {
    double luminance, variance, pixels;
} Sums;

static void add_tile(const NphFilm *film, int64_t tile, Sums *sums) {
    double moments[NPH_MOMENTS][NPH_TILE_PIXELS], mean[NPH_TILE_PIXELS] = {0}, error[NPH_TILE_PIXELS] = {0};
    double n = (double)nph_film_tile_samples(film, tile);
    for (int c = 0; c < film->channels; c++) {
        double weight = film->channels == 1 ? 1 : nph_luminance_weights[c];
        nph_tree_fold_moments(film, tile, c, moments);
        for (int p = 0; p < NPH_TILE_PIXELS; p++) {
            mean[p] += weight * moments[0][p];
            error[p] += weight * sqrt(nph_film_variance_of_mean(moments[1][p], n));
        }
    }
    int origin[2], inside[4];
    nph_film_tile_rect(film, tile, origin, inside);
    Sums own = {0};
    for (int y = inside[1]; y < inside[3]; y++)
        for (int x = inside[0]; x < inside[2]; x++) {
            int p = (y - origin[1]) * NPH_TILE + x - origin[0];
            own.luminance += mean[p];
            own.variance += error[p] * error[p];
            own.pixels += 1;
        }
    sums->luminance += own.luminance;
    sums->variance += own.variance;
    sums->pixels += own.pixels;
}

/* Standard error of the mean of the picture, its samples being whole images. */
static double image_error(const NphFilm *film) {
    const NphFilm *image = film->regions[NPH_REGION_LEVELS - 1];
    double moments[NPH_MOMENTS][NPH_TILE_PIXELS] = {{0}}, error = 0.0, n = (double)nph_film_tile_samples(image, 0);
    assert(film->channels <= 3);
    for (int c = 0; c < film->channels; c++) {
        nph_tree_fold_moments(image, 0, c, moments);
        error += (film->channels == 1 ? 1 : nph_luminance_weights[c]) * sqrt(nph_film_variance_of_mean(moments[1][0], n));
    }
    return error;
}

void nph_film_noise(const NphFilm *film, NphFilmNoise *noise) {
    NphFloatState state;
    NphFilmNoise made = {0};
    Sums sums = {0};
    nph_float_state_enter(&state);
    for (int64_t tile = 0; tile < film->tile_count; tile++)
        if (nph_film_tile_samples(film, tile) > 0) add_tile(film, tile, &sums);
    if (sums.pixels > 0) made.mean_luminance = sums.luminance / sums.pixels;
    if (made.mean_luminance != 0) {
        double error = nph_film_is_shared(film) ? image_error(film) : sqrt(sums.variance) / sums.pixels;
        made.relative_error = error / made.mean_luminance;
        made.relative_rmse = sqrt(sums.variance / sums.pixels) / made.mean_luminance;
    }
    nph_float_state_leave(&state);
    nph_film_samples_range(film, &made.samples_min, &made.samples_max);
    *noise = made;
}
