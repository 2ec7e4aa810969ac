/* SPDX-License-Identifier: Apache-2.0
 *
 * What a film holds, and the dyadic tree over its chunks. Seen by film/ only.
 *
 * The NORMAL FORM of a range of chunks is its list of maximal aligned nodes, left to right: levels rise, then fall. A
 * tile keeps exactly the normal form of the chunks it has, so the list follows from their number. */
#ifndef NPH_FILM_TREE_H
#define NPH_FILM_TREE_H

#include <stdint.h>

#include "film/film.h"
#include "film/moments.h"
#include "film/regions.h"

/* Samples end at 2^31 - 16, so chunk numbers have 27 bits, and a normal form has at most 27 rising and 27 falling. */
enum {
    NPH_MAX_NODES = 64,
    NPH_FILM_MAX_SIZE = 1 << 24,
    NPH_FILM_MAX_TEXTS = 1024,
    NPH_FILM_MAX_NAME = 255,
    NPH_FILM_MAX_TEXT = 1 << 24
};
#define NPH_FILM_MAX_SAMPLES INT64_C(2147483632)

typedef struct NphNode {
    int level;
    int64_t index; /* chunks [index << level, (index + 1) << level) */
} NphNode;

typedef struct NphFilmText {
    char *name, *text;
} NphFilmText;

typedef struct NphSharing NphSharing;

typedef void (*NphChunkFn)(const void *samples, int channels, double *node);

struct NphFilm {
    int width, height, crop[4], channels, values;
    int tile_x0, tile_y0, tiles_x, tiles_y; /* in tiles of the uncropped image */
    int64_t tile_count, chunk_begin, chunk_end;
    int slots;               /* nodes that a tile has room for */
    int64_t *chunks;         /* per tile: chunks so far */
    NphNonfinite *nonfinite; /* per tile */
    double *nodes;           /* [tile][slot][value][pixel] */
    int text_count;
    NphFilmText *texts;
    NphChunkFn chunk_f32, chunk_f64;
    NphFilm *regions[NPH_REGION_LEVELS]; /* means of regions, where pixels share samples; else NULL (shared.c) */
    NphSharing *sharing;                 /* while such a film is being filled */
};

/* The normal form of chunks [begin, end); returns its length. */
int nph_tree_nodes(int64_t begin, int64_t end, NphNode nodes[NPH_MAX_NODES]);
/* The longest normal form of [begin, m) for m up to end. */
int nph_tree_slots(int64_t begin, int64_t end);
static inline int64_t nph_node_samples(NphNode node) { return (int64_t)NPH_CHUNK << node.level; }

/* Node `slot` of a tile: its planes [value][pixel]. */
static inline double *nph_film_node(const NphFilm *film, int64_t tile, int slot) {
    return film->nodes + ((tile * film->slots + slot) * film->values) * NPH_TILE_PIXELS;
}
static inline int nph_film_tile_nodes(const NphFilm *film, int64_t tile, NphNode nodes[NPH_MAX_NODES]) {
    return nph_tree_nodes(film->chunk_begin, film->chunk_begin + film->chunks[tile], nodes);
}

/* out = merge(left, right) of whole nodes; out may be left or right. */
void nph_tree_merge(const double *left, int64_t left_samples, const double *right, int64_t right_samples, int channels,
                    double *out);

/* All samples of a tile: a channel's four moments (mean, M2, M3, M4), or the mean of one value. 0 without samples. */
void nph_tree_fold_moments(const NphFilm *film, int64_t tile, int channel, double out[NPH_MOMENTS][NPH_TILE_PIXELS]);
void nph_tree_fold_mean(const NphFilm *film, int64_t tile, int value, double out[NPH_TILE_PIXELS]);

/* film.c: fills in what follows from the arguments (valid ones), everything else 0; then memory for layout->slots nodes
 * a tile. */
void nph_film_lay_out(NphFilm *film, int width, int height, const int crop[4], int channels);
NphStatus nph_film_make(NphContext *context, const NphFilm *layout, NphFilm **film);

/* Pixels share samples. */
static inline int nph_film_is_shared(const NphFilm *film) { return film->regions[0] != NULL; }

/* film.c: a tile's report with another one joined to it. */
void nph_nonfinite_join(NphNonfinite *report, const NphNonfinite *other);

/* noise.c: Rec. 709. */
extern const double nph_luminance_weights[3];

/* picture.c: variance of the mean of n samples, and its relative variance. */
double nph_film_variance_of_mean(double m2, double n);
double nph_film_vov(double m2, double m4, double n);

/* noise.c: fewest and most samples of a tile. */
void nph_film_samples_range(const NphFilm *film, int64_t *least, int64_t *most);

#endif
