/* SPDX-License-Identifier: Apache-2.0
 *
 * A film is what a run leaves: the moments of every pixel, from which pictures and part files are made. */
#ifndef NEPHOS_FILM_H
#define NEPHOS_FILM_H

#include <stdint.h>

#include "nephos/image.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct NphFilm NphFilm;

void nph_film_free(NphContext *context, NphFilm *film);

/* Text that a film carries into its files: scene digest, seed, method, knobs, release (see docs/files.md). Refused
 * (NPH_BAD_USAGE): names that OpenEXR keeps for itself ("version", "name", "type", ...), "samples", "samples_least". */
NphStatus nph_film_set_text(NphContext *context, NphFilm *film, const char *name, const char *text);

/* The picture: R G B A (A = 1 - mean transmittance over channels), Variance.R/G/B (of the mean), Vov.R/G/B (relative
 * variance of that variance), N (samples), Transmittance.R/G/B, Order.Y (radiance-weighted mean scattering order; 0
 * where there is no light), Z (mean distance of the first collision or surface; 0 where there is none). Pixels without
 * samples are 0 in every layer. Where pixels share samples (light tracing, photon maps) also Variance8, Vov8, Variance64, Vov64,
 * VarianceImage and VovImage (.R/G/B): of the mean of the 8 x 8 tile, the 64 x 64 tile and the image that hold a pixel.
 * Attributes: the film's texts, "samples", and "samples_least" when pixels differ in it. */
NphStatus nph_film_image(NphContext *context, const NphFilm *film, NphImage *image);

/* Noise of the whole picture. relative_error: standard error of the mean luminance over the picture divided by that
 * mean (0 when black). relative_rmse: root of the mean over pixels of the luminance's variance of the mean, over the
 * mean luminance. Both over the pixels that have samples. Luminance: Rec. 709 weights; channels are taken as fully
 * correlated (an upper bound). Where pixels share samples relative_error is the image's own. */
typedef struct NphFilmNoise {
    double mean_luminance, relative_error, relative_rmse;
    int64_t samples_min, samples_max;
} NphFilmNoise;
void nph_film_noise(const NphFilm *film, NphFilmNoise *noise);

/* sRGB preview, 8 bit: exposure in stops, or NAN for one that maps the 99th percentile of luminance to 0.8. rgb has
 * room for width * height * 3 of the crop; NULL only asks for these. Pixels that are not finite are magenta. */
NphStatus nph_film_preview(NphContext *context, const NphFilm *film, double exposure_stops, uint8_t *rgb, int *width,
                           int *height);
NphStatus nph_film_write_png(NphContext *context, const NphFilm *film, double exposure_stops, const char *path);

/* Part files keep the tree's nodes exactly. */
NphStatus nph_film_write_part(NphContext *context, const NphFilm *film, const char *path);
NphStatus nph_film_read_part(NphContext *context, const char *path, NphFilm **film);

/* Folds parts that differ in crop or sample range and agree in everything else (size, channels, texts). Overlaps, and
 * pixels that have gaps in their samples, are refused naming the parts and the range. names: for messages. */
NphStatus nph_film_merge(NphContext *context, int count, NphFilm *const *parts, const char *const *names, NphFilm **film);

#ifdef __cplusplus
}
#endif
#endif
