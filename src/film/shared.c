/* SPDX-License-Identifier: Apache-2.0
 *
 * Pictures whose pixels share samples (light tracing, photon maps): sample s is one whole image, so the mean of a region
 * is a random variable of its own, with one value per sample, and its variance cannot be had from the pixels'. The film
 * therefore carries three coarser films, whose pixels are the means over the regions of regions.h.
 *
 * A chunk comes tile by tile, from any thread. Each film tile leaves, for the 8 x 8 regions it meets (at most 3 x 3), the
 * sums over their pixels of each of the 16 samples; nph_film_end_chunk adds these up, tile after tile, so that no order of
 * threads changes a bit. */
#include "film/shared.h"

#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "film/regions.h"

enum { MEETS = 3, PARTIAL = MEETS * MEETS * 3 * NPH_CHUNK };

/* What adding needs; films that were read or merged have none of it. */
struct NphSharing {
    double *partial;                 /* [film tile][3 x 3][channel][sample in chunk] */
    double *sums;                    /* [8 x 8 region][channel][sample in chunk] */
    double *staging;                 /* a tile's sample buffer, all 0 but radiance */
    void *scratch;
};

typedef struct Grid {
    int across, down;
} Grid;

static Grid grid_of(const NphFilm *film, int level) {
    int size = nph_region_sizes[level];
    Grid grid = {nph_regions_along(film->crop[2] - film->crop[0], size),
                 nph_regions_along(film->crop[3] - film->crop[1], size)};
    return grid;
}

void nph_shared_lay_out(const NphFilm *film, int level, NphFilm *layout) {
    Grid grid = grid_of(film, level);
    nph_film_lay_out(layout, grid.across, grid.down, (int[4]){0, 0, grid.across, grid.down}, film->channels);
    layout->chunk_begin = film->chunk_begin;
    layout->chunk_end = film->chunk_end;
    layout->slots = film->slots;
}

NphStatus nph_shared_make(NphContext *context, NphFilm *film) {
    for (int level = 0; level < NPH_REGION_LEVELS; level++) {
        NphFilm layout;
        nph_shared_lay_out(film, level, &layout);
        NPH_TRY(nph_film_make(context, &layout, &film->regions[level]));
    }
    return NPH_OK;
}

static size_t staging_doubles(void) { return (size_t)NPH_SAMPLE_FIELDS * NPH_TILE_PIXELS * NPH_CHUNK; }

NphStatus nph_film_share_samples(NphContext *context, NphFilm *film) {
    Grid grid = grid_of(film, 0);
    NphSharing *made = NULL;
    NPH_TRY(nph_shared_make(context, film));
    NPH_TRY(NPH_NEW(context, 1, "regions", &made));
    film->sharing = made; /* freed with the film, whatever happens */
    size_t regions = (size_t)grid.across * (size_t)grid.down;
    NPH_TRY(NPH_NEW(context, (size_t)film->tile_count * PARTIAL, "regions", &made->partial));
    NPH_TRY(NPH_NEW(context, regions * 3 * NPH_CHUNK, "regions", &made->sums));
    NPH_TRY(NPH_NEW(context, staging_doubles(), "regions", &made->staging));
    return nph_alloc(context, nph_film_scratch_bytes(film->channels), 1, "regions", &made->scratch);
}

void nph_shared_free(NphContext *context, NphFilm *film) {
    for (int level = 0; level < NPH_REGION_LEVELS; level++) nph_film_free(context, film->regions[level]);
    if (!film->sharing) return;
    nph_free(context, film->sharing->partial);
    nph_free(context, film->sharing->sums);
    nph_free(context, film->sharing->staging);
    nph_free(context, film->sharing->scratch);
    nph_free(context, film->sharing);
}

uint64_t nph_film_forecast_shared_bytes(int width, int height, const int crop[4], int channels, int64_t begin,
                                        int64_t end) {
    NphFilm film;
    nph_film_lay_out(&film, width, height, crop, channels);
    Grid fine = grid_of(&film, 0);
    uint64_t bytes = sizeof(NphSharing) + (uint64_t)film.tile_count * PARTIAL * sizeof(double) +
                     (uint64_t)fine.across * (uint64_t)fine.down * 3 * NPH_CHUNK * sizeof(double) +
                     staging_doubles() * sizeof(double) + nph_film_scratch_bytes(channels);
    for (int level = 0; level < NPH_REGION_LEVELS; level++) {
        Grid grid = grid_of(&film, level);
        int whole[4] = {0, 0, grid.across, grid.down};
        bytes += nph_film_forecast_bytes(grid.across, grid.down, whole, channels, begin, end);
    }
    return bytes;
}

/* The first 8 x 8 region that a film tile meets, and the pixels of it inside the crop. */
static void first_region(const NphFilm *film, int64_t tile, int origin[2], int inside[4], int first[2]) {
    Grid grid = grid_of(film, 0);
    nph_film_tile_rect(film, tile, origin, inside);
    first[0] = nph_region_of(inside[0] - film->crop[0], grid.across, nph_region_sizes[0]);
    first[1] = nph_region_of(inside[1] - film->crop[1], grid.down, nph_region_sizes[0]);
}

void nph_shared_add_tile(const NphFilm *film, int64_t tile, int precision, const void *samples) {
    double *partial = film->sharing->partial + tile * PARTIAL;
    Grid grid = grid_of(film, 0);
    int origin[2], inside[4], first[2];
    memset(partial, 0, PARTIAL * sizeof *partial);
    first_region(film, tile, origin, inside, first);
    for (int c = 0; c < film->channels; c++)
        for (int y = inside[1]; y < inside[3]; y++)
            for (int x = inside[0]; x < inside[2]; x++) {
                int row = nph_region_of(y - film->crop[1], grid.down, nph_region_sizes[0]) - first[1];
                int column = nph_region_of(x - film->crop[0], grid.across, nph_region_sizes[0]) - first[0];
                double *sum = partial + ((row * MEETS + column) * 3 + c) * NPH_CHUNK;
                size_t at = ((size_t)(NPH_SAMPLE_L0 + c) * NPH_TILE_PIXELS +
                             (size_t)((y - origin[1]) * NPH_TILE + x - origin[0])) * NPH_CHUNK;
                for (int i = 0; i < NPH_CHUNK; i++)
                    sum[i] += precision == 32 ? (double)((const float *)samples)[at + (size_t)i]
                                              : ((const double *)samples)[at + (size_t)i];
            }
}

/* Sums of the 8 x 8 regions from those of the film tiles. */
static void add_partials(const NphFilm *film) {
    Grid grid = grid_of(film, 0);
    double *sums = film->sharing->sums;
    memset(sums, 0, (size_t)grid.across * (size_t)grid.down * 3 * NPH_CHUNK * sizeof *sums);
    for (int64_t tile = 0; tile < film->tile_count; tile++) {
        const double *partial = film->sharing->partial + tile * PARTIAL;
        int origin[2], inside[4], first[2];
        first_region(film, tile, origin, inside, first);
        for (int row = 0; row < MEETS && first[1] + row < grid.down; row++)
            for (int column = 0; column < MEETS && first[0] + column < grid.across; column++) {
                const double *from = partial + (row * MEETS + column) * 3 * NPH_CHUNK;
                double *sum = sums + ((int64_t)(first[1] + row) * grid.across + first[0] + column) * 3 * NPH_CHUNK;
                for (int i = 0; i < 3 * NPH_CHUNK; i++) sum[i] += from[i];
            }
    }
}

/* Mean of one region of a level: all the 8 x 8 regions in it. */
static void region_mean(const NphFilm *film, int level, const int at[2], double mean[3 * NPH_CHUNK]) {
    Grid grid = grid_of(film, level), fine = grid_of(film, 0);
    int width = film->crop[2] - film->crop[0], height = film->crop[3] - film->crop[1], size = nph_region_sizes[level];
    int x0, x1, y0, y1;
    nph_region_span(at[0], grid.across, size, width, &x0, &x1);
    nph_region_span(at[1], grid.down, size, height, &y0, &y1);
    memset(mean, 0, 3 * NPH_CHUNK * sizeof *mean);
    int last_x = nph_region_of(x1 - 1, fine.across, nph_region_sizes[0]);
    int last_y = nph_region_of(y1 - 1, fine.down, nph_region_sizes[0]);
    for (int y = nph_region_of(y0, fine.down, nph_region_sizes[0]); y <= last_y; y++)
        for (int x = nph_region_of(x0, fine.across, nph_region_sizes[0]); x <= last_x; x++) {
            const double *sum = film->sharing->sums + ((int64_t)y * fine.across + x) * 3 * NPH_CHUNK;
            for (int i = 0; i < 3 * NPH_CHUNK; i++) mean[i] += sum[i];
        }
    double share = 1.0 / ((double)(x1 - x0) * (double)(y1 - y0));
    for (int i = 0; i < 3 * NPH_CHUNK; i++) mean[i] *= share;
}

static void add_level(const NphFilm *film, int level, int64_t chunk) {
    NphFilm *coarse = film->regions[level];
    double *staging = film->sharing->staging;
    for (int64_t tile = 0; tile < coarse->tile_count; tile++) {
        int origin[2], inside[4];
        nph_film_tile_rect(coarse, tile, origin, inside);
        for (int y = inside[1]; y < inside[3]; y++)
            for (int x = inside[0]; x < inside[2]; x++) {
                double mean[3 * NPH_CHUNK];
                int pixel = (y - origin[1]) * NPH_TILE + x - origin[0];
                region_mean(film, level, (int[2]){x, y}, mean);
                for (int c = 0; c < film->channels; c++)
                    memcpy(staging + ((NPH_SAMPLE_L0 + c) * NPH_TILE_PIXELS + pixel) * NPH_CHUNK, mean + c * NPH_CHUNK,
                           NPH_CHUNK * sizeof *mean);
            }
        nph_film_add_chunk(coarse, tile, chunk, 64, staging, film->sharing->scratch);
        coarse->nonfinite[tile] = (NphNonfinite){0}; /* the pixels report theirs */
    }
}

void nph_film_end_chunk(NphFilm *film, int64_t chunk) {
    add_partials(film);
    for (int level = 0; level < NPH_REGION_LEVELS; level++) add_level(film, level, chunk);
}

/* One row of a field: pixels lie NPH_CHUNK samples apart. */
static void gather_row(const char *from, char *to, int count, size_t real) {
    for (int x = 0; x < count; x++) memcpy(to + (size_t)x * NPH_CHUNK * real, from + (size_t)x * real, real);
}

void nph_film_gather(const NphFilm *film, int64_t tile, int precision, const void *images, void *samples) {
    const int *crop = film->crop;
    int64_t width = crop[2] - crop[0], pixels = width * (crop[3] - crop[1]);
    size_t real = (size_t)precision / 8;
    int origin[2], inside[4];
    nph_film_tile_rect(film, tile, origin, inside);
    memset(samples, 0, (size_t)NPH_SAMPLE_FIELDS * NPH_TILE_PIXELS * NPH_CHUNK * real);
    for (int s = 0; s < NPH_CHUNK; s++)
        for (int f = 0; f < NPH_SAMPLE_FIELDS; f++)
            for (int y = inside[1]; y < inside[3]; y++) {
                int64_t at = (s * NPH_SAMPLE_FIELDS + f) * pixels + (y - crop[1]) * width + inside[0] - crop[0];
                int64_t pixel = (y - origin[1]) * NPH_TILE + inside[0] - origin[0], into = (f * NPH_TILE_PIXELS + pixel) * NPH_CHUNK + s;
                gather_row((const char *)images + (size_t)at * real, (char *)samples + (size_t)into * real, inside[2] - inside[0], real);
            }
}
