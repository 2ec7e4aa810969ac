/* SPDX-License-Identifier: Apache-2.0
 *
 * Films filled with samples that depend on pixel, sample and field alone, for the tests of film/. */
#ifndef NPH_TESTS_FILM_SAMPLES_H
#define NPH_TESTS_FILM_SAMPLES_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "film/film.h"
#include "film/tree.h"
#include "harness.h"

typedef double (*SampleFn)(int x, int y, int64_t sample, int field);

/* Uniform in (0, 1), by the SplitMix64 finaliser. */
static inline double hash_uniform(uint64_t a, uint64_t b, uint64_t c) {
    uint64_t z = a * 0x9e3779b97f4a7c15u + b * 0xbf58476d1ce4e5b9u + c * 0x94d049bb133111ebu + 0x2545f4914f6cdd1du;
    for (int round = 0; round < 2; round++) {
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        z ^= z >> 31;
    }
    return ((double)(z >> 12) + 0.5) / 4503599627370496.0;
}

/* Skewed, positive radiance; other fields as a renderer would give. */
static inline double plain_sample(int x, int y, int64_t sample, int field) {
    double u = hash_uniform((uint64_t)x * 65536 + (uint64_t)y, (uint64_t)sample, (uint64_t)field);
    if (field == NPH_SAMPLE_COLLIDED) return u < 0.7;
    if (field == NPH_SAMPLE_DISTANCE)
        return hash_uniform((uint64_t)x * 65536 + (uint64_t)y, (uint64_t)sample, NPH_SAMPLE_COLLIDED) < 0.7 ? 100 * u
                                                                                                            : 0;
    return field <= NPH_SAMPLE_L2 ? u * u * u / (1.0000001 - u) : u;
}

/* The chunk of a tile as float or double; everything outside the crop is garbage. Static buffers are the caller's. */
static inline void fill_chunk(const NphFilm *film, int64_t tile, int64_t chunk, int precision, SampleFn value,
                              void *samples) {
    int origin[2], inside[4];
    nph_film_tile_rect(film, tile, origin, inside);
    for (int field = 0; field < NPH_SAMPLE_FIELDS; field++)
        for (int p = 0; p < NPH_TILE_PIXELS; p++)
            for (int i = 0; i < NPH_CHUNK; i++) {
                int x = origin[0] + p % NPH_TILE, y = origin[1] + p / NPH_TILE,
                    at = (field * NPH_TILE_PIXELS + p) * NPH_CHUNK + i;
                int in = x >= inside[0] && x < inside[2] && y >= inside[1] && y < inside[3];
                double v = in ? value(x, y, chunk * NPH_CHUNK + i, field) : -1e9 - at;
                if (precision == 32)
                    ((float *)samples)[at] = (float)v;
                else
                    ((double *)samples)[at] = v;
            }
}

enum { SAMPLE_BUFFER = NPH_SAMPLE_FIELDS * NPH_TILE_PIXELS * NPH_CHUNK };

/* Adds chunks up to sample `end` to every tile of a film whose pixels share samples. */
static inline void add_images(NphFilm *film, int64_t end, int precision, SampleFn value) {
    double *samples = malloc(SAMPLE_BUFFER * sizeof *samples);
    void *scratch = malloc(nph_film_scratch_bytes(film->channels));
    for (int64_t chunk = film->chunk_begin + film->chunks[0]; chunk < end / NPH_CHUNK; chunk++) {
        for (int64_t k = 0; k < film->tile_count; k++) {
            int64_t tile = chunk % 2 ? k : film->tile_count - 1 - k; /* in any order */
            fill_chunk(film, tile, chunk, precision, value, samples);
            nph_film_add_chunk(film, tile, chunk, precision, samples, scratch);
        }
        nph_film_end_chunk(film, chunk);
    }
    free(samples);
    free(scratch);
}

/* Adds chunks up to sample `end` to one tile. */
static inline void add_samples(NphFilm *film, int64_t tile, int64_t end, int precision, SampleFn value) {
    double *samples = malloc(SAMPLE_BUFFER * sizeof *samples);
    void *scratch = malloc(nph_film_scratch_bytes(film->channels));
    for (int64_t chunk = film->chunk_begin + film->chunks[tile]; chunk < end / NPH_CHUNK; chunk++) {
        fill_chunk(film, tile, chunk, precision, value, samples);
        nph_film_add_chunk(film, tile, chunk, precision, samples, scratch);
    }
    free(samples);
    free(scratch);
}

typedef struct Shape {
    int width, height, crop[4], channels;
    int64_t begin, end;
} Shape;

static inline NphFilm *empty_film(NphContext *context, const Shape *shape) {
    NphFilm *film = NULL;
    ck_assert_int_eq(nph_film_new(context, shape->width, shape->height, shape->crop, shape->channels, shape->begin,
                                  shape->end, &film),
                     NPH_OK);
    return film;
}

static inline NphFilm *full_film(NphContext *context, const Shape *shape, int precision, SampleFn value) {
    NphFilm *film = empty_film(context, shape);
    for (int64_t tile = 0; tile < film->tile_count; tile++) add_samples(film, tile, shape->end, precision, value);
    return film;
}

/* The same bits; one NaN is as good as another. */
static inline int same_double(double a, double b) { return a != a ? b != b : memcmp(&a, &b, sizeof a) == 0; }

static inline int tiles_equal(const NphFilm *a, const NphFilm *b, int64_t tile) {
    NphNode nodes[NPH_MAX_NODES];
    const NphNonfinite *p = &a->nonfinite[tile], *q = &b->nonfinite[tile];
    if (a->chunks[tile] != b->chunks[tile] || p->count != q->count || p->x != q->x || p->y != q->y ||
        p->sample != q->sample)
        return 0;
    int origin[2], inside[4], planes = nph_film_tile_nodes(a, tile, nodes) * a->values;
    nph_film_tile_rect(a, tile, origin, inside);
    for (int plane = 0; plane < planes; plane++)
        for (int y = inside[1]; y < inside[3]; y++)
            for (int x = inside[0]; x < inside[2]; x++) {
                int at = plane * NPH_TILE_PIXELS + (y - origin[1]) * NPH_TILE + x - origin[0];
                if (!same_double(nph_film_node(a, tile, 0)[at], nph_film_node(b, tile, 0)[at])) return 0;
            }
    return 1;
}

/* The same shape and bit for bit the same nodes and reports, inside the crop. */
static inline int films_equal(const NphFilm *a, const NphFilm *b) {
    if (a->width != b->width || a->height != b->height || memcmp(a->crop, b->crop, sizeof a->crop) ||
        a->channels != b->channels || a->chunk_begin != b->chunk_begin || a->chunk_end != b->chunk_end ||
        a->tile_count != b->tile_count)
        return 0;
    for (int64_t tile = 0; tile < a->tile_count; tile++)
        if (!tiles_equal(a, b, tile)) return 0;
    for (int level = 0; level < NPH_REGION_LEVELS; level++) {
        if (!a->regions[level] != !b->regions[level]) return 0;
        if (a->regions[level] && !films_equal(a->regions[level], b->regions[level])) return 0;
    }
    return 1;
}

/* The moments of a pixel's samples in long double. */
static inline void exact_moments(int x, int y, int field, int64_t begin, int64_t end, int precision, SampleFn value,
                                 long double out[4]) {
    long double n = (long double)(end - begin), sum = 0;
    for (int64_t s = begin; s < end; s++) sum += precision == 32 ? (float)value(x, y, s, field) : value(x, y, s, field);
    memset(out, 0, 4 * sizeof *out);
    out[0] = sum / n;
    for (int64_t s = begin; s < end; s++) {
        long double d = (precision == 32 ? (float)value(x, y, s, field) : value(x, y, s, field)) - out[0];
        out[1] += d * d;
        out[2] += d * d * d;
        out[3] += d * d * d * d;
    }
}

#endif
