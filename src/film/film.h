/* SPDX-License-Identifier: Apache-2.0
 *
 * The film: per pixel f64 moments of what the samples carry, summed in a dyadic tree over chunks of 16 samples, so
 * that any split into tiles, sample ranges or passes folds to the same bytes.
 *
 * A NODE is the moments of an aligned dyadic range of samples: level l, index i covers samples
 * [16 i 2^l, 16 (i + 1) 2^l). Level 0 is a chunk: 16 samples added in a binary tree. A node of level l + 1 is
 * merge(left, right) of its halves (Chan, Pebay: count, mean, central moments 2 to 4). A range [a, b) is kept as its
 * maximal aligned nodes; the picture of it is their fold along the full tree with its empty branches left out (from the
 * right when a = 0). Equal samples have exactly their value as mean, and variance 0. Images are cut
 * into tiles of 16 x 16 pixels aligned to the uncropped image. */
#ifndef NPH_FILM_FILM_H
#define NPH_FILM_FILM_H

#include <stddef.h>
#include <stdint.h>

#include "nephos/conventions.h"
#include "nephos/film.h"

enum { NPH_CHUNK = NPH_SAMPLE_STEP, NPH_TILE = 16, NPH_TILE_PIXELS = 256 };

/* What one sample carries. The sample buffer of a tile and chunk is [field][pixel][sample in chunk], pixel = row-major
 * position within the 16 x 16 tile (pixels outside the crop are ignored), as float or double. */
typedef enum NphSampleField {
    NPH_SAMPLE_L0, NPH_SAMPLE_L1, NPH_SAMPLE_L2,  /* radiance per channel (W/m2/sr; irradiance for a flux sensor) */
    NPH_SAMPLE_T0, NPH_SAMPLE_T1, NPH_SAMPLE_T2,  /* estimate of the camera ray's transmittance per channel */
    NPH_SAMPLE_ORDER,                             /* sum over contributions of luminance times scattering order */
    NPH_SAMPLE_DISTANCE,                          /* distance of the first collision, m; 0 when there is none */
    NPH_SAMPLE_COLLIDED,                          /* 1 when there is one, else 0 */
    NPH_SAMPLE_FIELDS
} NphSampleField;

/* crop is {x0, y0, x1, y1}; channels 1 (everything grey: L1, L2, T1, T2 are not read and R = G = B) or 3.
 * Room for the nodes of [sample_begin, sample_end), multiples of 16, is allocated here and not later. */
NphStatus nph_film_new(NphContext *context, int width, int height, const int crop[4], int channels,
                       int64_t sample_begin, int64_t sample_end, NphFilm **film);

int64_t nph_film_tile_count(const NphFilm *film);
/* Pixels of a tile: x0, y0 of the whole tile (multiples of 16), and the part inside the crop {x0, y0, x1, y1}. */
void nph_film_tile_rect(const NphFilm *film, int64_t tile, int origin[2], int inside[4]);

/* Scratch that one worker needs for add_chunk, and bytes a film of these arguments will allocate (for plans). */
size_t nph_film_scratch_bytes(int channels);
uint64_t nph_film_forecast_bytes(int width, int height, const int crop[4], int channels, int64_t begin, int64_t end);

/* Adds the samples of chunk number `chunk` (samples [16 chunk, 16 chunk + 16)) to a tile; chunks of one tile come in
 * rising order without gaps from sample_begin / 16. Different tiles may be added to from different threads.
 * samples: float for precision 32, double for 64; |radiance| below 1e75. Samples with a field that is not finite are
 * counted and left out of no sum: the pixel shows it, and nph_film_nonfinite says how many there are, and which is the
 * first in order of y, x, sample. Allocates nothing. scratch: nph_film_scratch_bytes, aligned to 64. */
void nph_film_add_chunk(NphFilm *film, int64_t tile, int64_t chunk, int precision, const void *samples, void *scratch);

/* The same in two steps: the moments of a chunk, planes over the tile's pixels (4 per channel: mean, M2, M3, M4; a transmittance
 * per channel; order, distance, collided), into scratch, and from there into the film. */
void nph_film_chunk(const NphFilm *film, int precision, const void *samples, double *scratch);
void nph_film_add_node(NphFilm *film, int64_t tile, int64_t chunk, int precision, const void *samples, double *scratch);
int nph_film_planes(const NphFilm *film);

/* The samples of a tile, as add_chunk takes them, from the 16 images of a chunk, [16][field][pixel] with the pixels of the crop row by
 * row; those of the tile outside it become 0. */
void nph_film_gather(const NphFilm *film, int64_t tile, int precision, const void *images, void *samples);

/* Pixels share samples: sample s of all pixels is one image, independent of the other samples (light tracing, photon
 * maps). Called once on a new film; the film then keeps the variance of the means of 8 x 8 tiles, 64 x 64 tiles and the
 * image too. A chunk is added to every tile, then nph_film_end_chunk is called from one thread; after it, and before the
 * next one, all tiles have as many samples. When it fails the film can only be freed. */
NphStatus nph_film_share_samples(NphContext *context, NphFilm *film);
void nph_film_end_chunk(NphFilm *film, int64_t chunk);
/* Bytes on top of nph_film_forecast_bytes. */
uint64_t nph_film_forecast_shared_bytes(int width, int height, const int crop[4], int channels, int64_t begin,
                                        int64_t end);

/* Samples of a tile so far. */
int64_t nph_film_tile_samples(const NphFilm *film, int64_t tile);

/* A text of the film, or NULL. */
const char *nph_film_text(const NphFilm *film, const char *name);

typedef struct NphNonfinite {
    int64_t count;
    int x, y;
    int64_t sample;
} NphNonfinite;
void nph_film_nonfinite(const NphFilm *film, NphNonfinite *report);

#endif
