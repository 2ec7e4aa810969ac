/* SPDX-License-Identifier: Apache-2.0
 *
 * The dyadic tree over chunks: normal forms, merging of nodes, and the fold of a tile's normal form.
 *
 * The fold is the full binary tree over all chunks with its empty branches left out. A normal form is a run of right
 * children of rising size, which fold from the left, and a run of left children of falling size, which fold from the
 * right; last, both sums are merged. */
#include "film/tree.h"

#include <assert.h>
#include <string.h>

int nph_tree_nodes(int64_t begin, int64_t end, NphNode nodes[NPH_MAX_NODES]) {
    int count = 0;
    for (int64_t at = begin; at < end;) {
        int level = 0;
        while ((at & (((int64_t)2 << level) - 1)) == 0 && ((int64_t)2 << level) <= end - at) level++;
        nodes[count++] = (NphNode){level, at >> level};
        at += (int64_t)1 << level;
    }
    return count;
}

static int bits_set(int64_t x) {
    int count = 0;
    for (; x; x &= x - 1) count++;
    return count;
}

/* The normal form of [begin, m) splits at p, its point with most trailing zeros, into bits_set(p - begin) rising nodes
 * and bits_set(m - p) falling ones, and m - p < 2^(level of p) (any m when p = 0). Of the numbers up to x, the largest
 * 2^k - 1 has the most bits. */
int nph_tree_slots(int64_t begin, int64_t end) {
    int most = 0;
    for (int level = 0; level < 62; level++) {
        int64_t size = (int64_t)1 << level, p = (begin + size - 1) / size * size;
        if (p > end) break;
        int64_t beyond = end - p;
        if (p != 0 && beyond > size - 1) beyond = size - 1;
        int falling = 0;
        while (((int64_t)2 << falling) - 1 <= beyond) falling++;
        int count = bits_set(p - begin) + falling;
        if (count > most) most = count;
    }
    return most;
}

static void merge_moment_planes(const NphJoin *join, const double *a, const double *b, double *out) {
    enum { N = NPH_TILE_PIXELS };
    for (int i = 0; i < N; i++) {
        NphMoments left = {a[i], a[N + i], a[2 * N + i], a[3 * N + i]};
        NphMoments right = {b[i], b[N + i], b[2 * N + i], b[3 * N + i]};
        NphMoments both = nph_join_moments(join, &left, &right);
        out[i] = both.mean;
        out[N + i] = both.m2;
        out[2 * N + i] = both.m3;
        out[3 * N + i] = both.m4;
    }
}

static void merge_mean_planes(const NphJoin *join, const double *a, const double *b, double *out) {
    for (int i = 0; i < NPH_TILE_PIXELS; i++) out[i] = nph_join_mean(join, a[i], b[i]);
}

void nph_tree_merge(const double *left, int64_t left_samples, const double *right, int64_t right_samples, int channels,
                    double *out) {
    NphJoin join = nph_join_of(left_samples, right_samples);
    for (int c = 0; c < channels; c++) {
        int at = NPH_MOMENTS * c * NPH_TILE_PIXELS;
        merge_moment_planes(&join, left + at, right + at, out + at);
    }
    for (int value = NPH_MOMENTS * channels; value < nph_film_values(channels); value++) {
        int at = value * NPH_TILE_PIXELS;
        merge_mean_planes(&join, left + at, right + at, out + at);
    }
}

typedef void (*MergePlanes)(const NphJoin *join, const double *a, const double *b, double *out);

/* A plane set and the samples in it. */
typedef struct Sum {
    double *planes;
    int64_t samples;
} Sum;

/* Where rising nodes end and falling ones begin: the largest node is a right child (odd) and rises, or a left child. */
static int find_split(const NphNode *nodes, int length) {
    int largest = 0;
    for (int i = 1; i < length; i++)
        if (nodes[i].level > nodes[largest].level) largest = i;
    return largest + (int)(nodes[largest].index & 1);
}

/* Folds `count` planes beginning at `value` into out; spare has the same room. */
static void fold(const NphFilm *film, int64_t tile, int value, int count, MergePlanes merge, double *out,
                 double *spare) {
    NphNode nodes[NPH_MAX_NODES];
    size_t bytes = (size_t)count * NPH_TILE_PIXELS * sizeof(double), at = (size_t)value * NPH_TILE_PIXELS;
    int length = nph_film_tile_nodes(film, tile, nodes), split;
    Sum rising = {out, 0}, falling = {spare, 0};
    memset(out, 0, bytes);
    if (length == 0) return;
    split = find_split(nodes, length);
    assert(split >= 0 && split <= length);
    for (int i = 0; i < split; i++) {
        const double *node = nph_film_node(film, tile, i) + at;
        NphJoin join = nph_join_of(rising.samples, nph_node_samples(nodes[i]));
        if (i == 0)
            memcpy(rising.planes, node, bytes);
        else
            merge(&join, rising.planes, node, rising.planes);
        rising.samples += nph_node_samples(nodes[i]);
    }
    if (split == 0) falling.planes = out;
    for (int i = length - 1; i >= split; i--) {
        const double *node = nph_film_node(film, tile, i) + at;
        NphJoin join = nph_join_of(nph_node_samples(nodes[i]), falling.samples);
        if (i == length - 1)
            memcpy(falling.planes, node, bytes);
        else
            merge(&join, node, falling.planes, falling.planes);
        falling.samples += nph_node_samples(nodes[i]);
    }
    if (split == 0 || split == length) return;
    NphJoin join = nph_join_of(rising.samples, falling.samples);
    merge(&join, out, spare, out);
}

void nph_tree_fold_moments(const NphFilm *film, int64_t tile, int channel, double out[NPH_MOMENTS][NPH_TILE_PIXELS]) {
    double spare[NPH_MOMENTS][NPH_TILE_PIXELS];
    fold(film, tile, NPH_MOMENTS * channel, NPH_MOMENTS, merge_moment_planes, out[0], spare[0]);
}

void nph_tree_fold_mean(const NphFilm *film, int64_t tile, int value, double out[NPH_TILE_PIXELS]) {
    double spare[NPH_TILE_PIXELS];
    fold(film, tile, value, 1, merge_mean_planes, out, spare);
}
