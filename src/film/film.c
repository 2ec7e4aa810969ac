/* SPDX-License-Identifier: Apache-2.0
 *
 * Making a film, its texts, and adding chunks to it. All memory is taken in nph_film_new; adding a chunk works like
 * adding 1 to a binary counter, whose digits are the nodes of the tile. */
#include "film/film.h"

#include <assert.h>
#include <string.h>

#include "core/cpu.h"
#include "core/memory.h"
#include "core/message.h"
#include "film/shared.h"
#include "io/exr.h"
#include "nephos/context.h"

NPH_KERNEL_DECLARE(void, nph_film_chunk, (const void *samples, int channels, double *node));

static NphStatus check_arguments(NphContext *context, int width, int height, const int crop[4], int channels) {
    if (width < 1 || height < 1 || width > NPH_FILM_MAX_SIZE || height > NPH_FILM_MAX_SIZE)
        return nph_error(context, NPH_BAD_USAGE, "film: size %d x %d is not in 1 to %d", width, height,
                         NPH_FILM_MAX_SIZE);
    if (crop[0] < 0 || crop[1] < 0 || crop[2] > width || crop[3] > height || crop[0] >= crop[2] || crop[1] >= crop[3])
        return nph_error(context, NPH_BAD_USAGE, "film: crop %d,%d,%d,%d is empty or not inside %d x %d pixels",
                         crop[0], crop[1], crop[2], crop[3], width, height);
    if (channels != 1 && channels != 3)
        return nph_error(context, NPH_BAD_USAGE, "film: %d channels; 1 or 3 are possible", channels);
    return NPH_OK;
}

static NphStatus check_range(NphContext *context, int64_t begin, int64_t end) {
    if (begin < 0 || end <= begin || end > NPH_FILM_MAX_SAMPLES || begin % NPH_CHUNK != 0 || end % NPH_CHUNK != 0)
        return nph_error(context, NPH_BAD_USAGE,
                         "film: samples %lld:%lld are not a rising range of multiples of %d from 0 to %lld",
                         (long long)begin, (long long)end, (int)NPH_CHUNK, (long long)NPH_FILM_MAX_SAMPLES);
    return NPH_OK;
}

/* Everything that follows from the arguments. */
void nph_film_lay_out(NphFilm *film, int width, int height, const int crop[4], int channels) {
    *film = (NphFilm){0};
    film->width = width;
    film->height = height;
    memcpy(film->crop, crop, sizeof film->crop);
    film->channels = channels;
    film->values = nph_film_values(channels);
    film->tile_x0 = crop[0] / NPH_TILE;
    film->tile_y0 = crop[1] / NPH_TILE;
    film->tiles_x = (crop[2] + NPH_TILE - 1) / NPH_TILE - film->tile_x0;
    film->tiles_y = (crop[3] + NPH_TILE - 1) / NPH_TILE - film->tile_y0;
    film->tile_count = (int64_t)film->tiles_x * film->tiles_y;
}

/* At most 2^40 tiles, 64 slots, 2^16 bytes a node: no overflow. */
static uint64_t doubles_of(const NphFilm *film) {
    return (uint64_t)film->tile_count * (uint64_t)film->slots * (uint64_t)film->values * NPH_TILE_PIXELS;
}

uint64_t nph_film_forecast_bytes(int width, int height, const int crop[4], int channels, int64_t begin, int64_t end) {
    NphFilm film;
    nph_film_lay_out(&film, width, height, crop, channels);
    film.slots = nph_tree_slots(begin / NPH_CHUNK, end / NPH_CHUNK);
    return sizeof film + doubles_of(&film) * sizeof *film.nodes +
           (uint64_t)film.tile_count * (sizeof *film.chunks + sizeof *film.nonfinite);
}

size_t nph_film_scratch_bytes(int channels) {
    return (size_t)nph_film_values(channels) * NPH_TILE_PIXELS * sizeof(double);
}

NphStatus nph_film_make(NphContext *context, const NphFilm *layout, NphFilm **film) {
    NphFilm *made = NULL;
    NPH_TRY(NPH_NEW(context, 1, "film", &made));
    *made = *layout;
    NPH_KERNEL_PICK(made->chunk_f32, nph_film_chunk, nph_context_isa(context), 32);
    NPH_KERNEL_PICK(made->chunk_f64, nph_film_chunk, nph_context_isa(context), 64);
    NphStatus status = NPH_NEW(context, made->tile_count, "film tiles", &made->chunks);
    if (status == NPH_OK) status = NPH_NEW(context, made->tile_count, "film tiles", &made->nonfinite);
    if (status == NPH_OK) status = NPH_NEW(context, doubles_of(made), "film", &made->nodes);
    if (status != NPH_OK) {
        nph_film_free(context, made);
        return status;
    }
    *film = made;
    return NPH_OK;
}

NphStatus nph_film_new(NphContext *context, int width, int height, const int crop[4], int channels,
                       int64_t sample_begin, int64_t sample_end, NphFilm **film) {
    NphFilm layout;
    NPH_TRY(check_arguments(context, width, height, crop, channels));
    NPH_TRY(check_range(context, sample_begin, sample_end));
    nph_film_lay_out(&layout, width, height, crop, channels);
    layout.chunk_begin = sample_begin / NPH_CHUNK;
    layout.chunk_end = sample_end / NPH_CHUNK;
    layout.slots = nph_tree_slots(layout.chunk_begin, layout.chunk_end);
    return nph_film_make(context, &layout, film);
}

void nph_film_free(NphContext *context, NphFilm *film) {
    if (!film) return;
    for (int i = 0; i < film->text_count; i++) {
        nph_free(context, film->texts[i].name);
        nph_free(context, film->texts[i].text);
    }
    nph_shared_free(context, film);
    nph_free(context, film->texts);
    nph_free(context, film->chunks);
    nph_free(context, film->nonfinite);
    nph_free(context, film->nodes);
    nph_free(context, film);
}

const char *nph_film_text(const NphFilm *film, const char *name) {
    for (int i = 0; i < film->text_count; i++)
        if (strcmp(film->texts[i].name, name) == 0) return film->texts[i].text;
    return NULL;
}

/* A text becomes an attribute of the picture; what could not is refused before anything is rendered. */
static NphStatus check_text(NphContext *context, const char *name, const char *text) {
    int taken = nph_exr_reserved_name(name) || strcmp(name, "samples") == 0 || strcmp(name, "samples_least") == 0;
    if (taken) return nph_error(context, NPH_BAD_USAGE, "film: the name \"%s\" is taken and cannot name a text", name);
    if (!name[0] || strlen(name) > NPH_FILM_MAX_NAME || strlen(text) > NPH_FILM_MAX_TEXT)
        return nph_error(context, NPH_BAD_USAGE, "film: a text's name must have 1 to %d bytes, the text at most %d",
                         NPH_FILM_MAX_NAME, NPH_FILM_MAX_TEXT);
    return NPH_OK;
}

NphStatus nph_film_set_text(NphContext *context, NphFilm *film, const char *name, const char *text) {
    char *copy = NULL;
    NPH_TRY(check_text(context, name, text));
    NPH_TRY(nph_strdup(context, text, &copy));
    for (int i = 0; i < film->text_count; i++) {
        if (strcmp(film->texts[i].name, name) != 0) continue;
        nph_free(context, film->texts[i].text);
        film->texts[i].text = copy;
        return NPH_OK;
    }
    NphFilmText added = {NULL, copy};
    NphStatus status = film->text_count < NPH_FILM_MAX_TEXTS
                           ? nph_strdup(context, name, &added.name)
                           : nph_error(context, NPH_BAD_USAGE, "film: more than %d texts", NPH_FILM_MAX_TEXTS);
    if (status == NPH_OK)
        status = nph_realloc(context, (size_t)film->text_count + 1, sizeof *film->texts, "film texts",
                             (void **)&film->texts);
    if (status != NPH_OK) {
        nph_free(context, added.name);
        nph_free(context, copy);
        return status;
    }
    film->texts[film->text_count++] = added;
    return NPH_OK;
}

int64_t nph_film_tile_count(const NphFilm *film) { return film->tile_count; }
int64_t nph_film_tile_samples(const NphFilm *film, int64_t tile) { return film->chunks[tile] * NPH_CHUNK; }

static int larger(int a, int b) { return a > b ? a : b; }
static int smaller(int a, int b) { return a < b ? a : b; }

void nph_film_tile_rect(const NphFilm *film, int64_t tile, int origin[2], int inside[4]) {
    origin[0] = (film->tile_x0 + (int)(tile % film->tiles_x)) * NPH_TILE;
    origin[1] = (film->tile_y0 + (int)(tile / film->tiles_x)) * NPH_TILE;
    inside[0] = larger(origin[0], film->crop[0]);
    inside[1] = larger(origin[1], film->crop[1]);
    inside[2] = smaller(origin[0] + NPH_TILE, film->crop[2]);
    inside[3] = smaller(origin[1] + NPH_TILE, film->crop[3]);
}

static int finite_sample(const NphFilm *film, int precision, const void *samples, int pixel, int sample) {
    for (int field = 0; field < NPH_SAMPLE_FIELDS; field++) {
        int unread =
            field == NPH_SAMPLE_L1 || field == NPH_SAMPLE_L2 || field == NPH_SAMPLE_T1 || field == NPH_SAMPLE_T2;
        if (film->channels == 1 && unread) continue;
        size_t at = ((size_t)field * NPH_TILE_PIXELS + (size_t)pixel) * NPH_CHUNK + (size_t)sample;
        double x = precision == 32 ? (double)((const float *)samples)[at] : ((const double *)samples)[at];
        if (x - x != 0) return 0;
    }
    return 1;
}

/* Counts a tile's bad samples; the reported one is the first in order of y, x, sample. */
static void count_bad_samples(NphFilm *film, int64_t tile, int64_t chunk, int precision, const void *samples) {
    NphNonfinite *report = &film->nonfinite[tile];
    int origin[2], inside[4];
    nph_film_tile_rect(film, tile, origin, inside);
    for (int y = inside[1]; y < inside[3]; y++)
        for (int x = inside[0]; x < inside[2]; x++)
            for (int i = 0; i < NPH_CHUNK; i++) {
                int pixel = (y - origin[1]) * NPH_TILE + x - origin[0];
                if (finite_sample(film, precision, samples, pixel, i)) continue;
                nph_nonfinite_join(report, &(NphNonfinite){1, x, y, chunk * NPH_CHUNK + i});
            }
}

/* A sum with a term that is not finite is not finite. */
static int all_means_finite(const double *node, int channels) {
    double poison = 0;
    for (int value = 0; value < nph_film_values(channels); value++) {
        if (value < NPH_MOMENTS * channels && value % NPH_MOMENTS != 0) continue;
        const double *plane = node + value * NPH_TILE_PIXELS;
        for (int pixel = 0; pixel < NPH_TILE_PIXELS; pixel++) poison += plane[pixel] - plane[pixel];
    }
    return poison == 0;
}

int nph_film_planes(const NphFilm *film) { return nph_film_values(film->channels); }

void nph_film_chunk(const NphFilm *film, int precision, const void *samples, double *scratch) {
    (precision == 32 ? film->chunk_f32 : film->chunk_f64)(samples, film->channels, scratch);
}

void nph_film_add_chunk(NphFilm *film, int64_t tile, int64_t chunk, int precision, const void *samples, void *scratch) {
    nph_film_chunk(film, precision, samples, scratch);
    nph_film_add_node(film, tile, chunk, precision, samples, scratch);
}

void nph_film_add_node(NphFilm *film, int64_t tile, int64_t chunk, int precision, const void *samples, double *scratch) {
    double *carry = scratch;
    assert(chunk == film->chunk_begin + film->chunks[tile] && chunk < film->chunk_end);
    if (film->sharing) nph_shared_add_tile(film, tile, precision, samples);
    if (!all_means_finite(carry, film->channels)) count_bad_samples(film, tile, chunk, precision, samples);
    NphNode nodes[NPH_MAX_NODES], node = {0, chunk};
    int count = nph_film_tile_nodes(film, tile, nodes);
    while (count > 0 && nodes[count - 1].level == node.level && (node.index & 1)) {
        int64_t half = nph_node_samples(node);
        nph_tree_merge(nph_film_node(film, tile, count - 1), half, carry, half, film->channels, carry);
        node = (NphNode){node.level + 1, node.index >> 1};
        count--;
    }
    memcpy(nph_film_node(film, tile, count), carry, nph_film_scratch_bytes(film->channels));
    film->chunks[tile]++;
}

void nph_nonfinite_join(NphNonfinite *report, const NphNonfinite *other) {
    if (!other->count) return;
    int64_t total = report->count + other->count;
    int before = other->y != report->y   ? other->y < report->y
                 : other->x != report->x ? other->x < report->x
                                         : other->sample < report->sample;
    if (!report->count || before) *report = *other;
    report->count = total;
}

void nph_film_nonfinite(const NphFilm *film, NphNonfinite *report) {
    *report = (NphNonfinite){0};
    for (int64_t tile = 0; tile < film->tile_count; tile++) nph_nonfinite_join(report, &film->nonfinite[tile]);
}
