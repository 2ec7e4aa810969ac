/* SPDX-License-Identifier: Apache-2.0
 *
 * One node of the kd-tree, or the whole subtree below it: the items of its range are partitioned around the item of the
 * wanted rank, which becomes the node. */
#include "truth/photonmap/kd_tree_lookup.h"

void NPH_KERNEL(nph_kd_fill)(NphKdTree *tree, const void *points);
void NPH_KERNEL(nph_kd_split)(NphKdTree *tree, int32_t node);
void NPH_KERNEL(nph_kd_subtree)(NphKdTree *tree, int32_t node);

typedef struct Range {
    int32_t first, count;
} Range;

void NPH_KERNEL(nph_kd_fill)(NphKdTree *tree, const void *points) {
    const Real *p = points;
    RKdNode *items = tree->items;
    for (int32_t i = 0; i < tree->count; i++) {
        for (int a = 0; a < 3; a++) items[i].p[a] = p[3 * (int64_t)i + a];
        items[i].tag = (uint32_t)i << 2;
    }
}

static int before(const RKdNode *a, const RKdNode *b, int axis) {
    return a->p[axis] < b->p[axis] || (a->p[axis] == b->p[axis] && a->tag < b->tag);
}

static void exchange(RKdNode *a, RKdNode *b) {
    RKdNode c = *a;
    *a = *b;
    *b = c;
}

static int longest_axis(const RKdNode *items, int32_t count) {
    Real lo[3], hi[3];
    for (int a = 0; a < 3; a++) lo[a] = hi[a] = items[0].p[a];
    for (int32_t i = 1; i < count; i++)
        for (int a = 0; a < 3; a++) {
            lo[a] = items[i].p[a] < lo[a] ? items[i].p[a] : lo[a];
            hi[a] = items[i].p[a] > hi[a] ? items[i].p[a] : hi[a];
        }
    int axis = 0;
    for (int a = 1; a < 3; a++) axis = hi[a] - lo[a] > hi[axis] - lo[axis] ? a : axis;
    return axis;
}

/* The median of three items at places that a mixture of bits of the range gives: no order of points is slow. */
static RKdNode pivot_of(const RKdNode *items, int32_t lo, int32_t hi, int axis) {
    uint32_t range = (uint32_t)(hi - lo + 1), mixed = (uint32_t)lo * 0x9E3779B1u ^ (uint32_t)hi * 0x85EBCA77u;
    const RKdNode *three[3];
    for (int i = 0; i < 3; i++) {
        mixed = (mixed ^ mixed >> 15) * 0x2C1B3C6Du + 0x297A2D39u;
        three[i] = &items[lo + (int32_t)((uint64_t)mixed * range >> 32)];
    }
    int ab = before(three[0], three[1], axis), bc = before(three[1], three[2], axis),
        ac = before(three[0], three[2], axis);
    return ab ? (bc ? *three[1] : ac ? *three[2] : *three[0]) : (ac ? *three[0] : bc ? *three[2] : *three[1]);
}

/* Quickselect [Hoare61]: afterwards items[rank] has `rank` items before it, all of them at its left. */
static void select_rank(RKdNode *items, int32_t count, int32_t rank, int axis) {
    int32_t lo = 0, hi = count - 1;
    while (lo < hi) {
        RKdNode pivot = pivot_of(items, lo, hi, axis);
        int32_t i = lo, j = hi;
        while (i <= j) {
            while (before(&items[i], &pivot, axis)) i++;
            while (before(&pivot, &items[j], axis)) j--;
            if (i > j) break;
            exchange(&items[i++], &items[j--]);
        }
        if (rank <= j)
            hi = j;
        else if (rank >= i)
            lo = i;
        else
            return;
    }
}

/* Items of a node: down from the root, along the bits of node + 1 below the highest. */
static Range range_of(int32_t count, int32_t node) {
    Range range = {0, count};
    uint32_t path = (uint32_t)node + 1u, bit = 1u;
    while (bit <= path / 2u) bit *= 2u;
    for (bit /= 2u; bit > 0u; bit /= 2u) {
        int32_t left = nph_kd_left(range.count);
        range.first += path & bit ? left + 1 : 0;
        range.count = path & bit ? range.count - left - 1 : left;
    }
    return range;
}

static int32_t split(NphKdTree *tree, int32_t node, Range range) {
    RKdNode *items = (RKdNode *)tree->items + range.first;
    int32_t left = nph_kd_left(range.count);
    int axis = longest_axis(items, range.count);
    select_rank(items, range.count, left, axis);
    RKdNode *out = (RKdNode *)tree->nodes + node;
    *out = items[left];
    out->tag |= (uint32_t)axis;
    return left;
}

void NPH_KERNEL(nph_kd_split)(NphKdTree *tree, int32_t node) { split(tree, node, range_of(tree->count, node)); }

void NPH_KERNEL(nph_kd_subtree)(NphKdTree *tree, int32_t node) {
    struct {
        int32_t node;
        Range range;
    } waiting[33];
    int depth = 0;
    waiting[depth].node = node;
    waiting[depth++].range = range_of(tree->count, node);
    while (depth > 0) {
        int32_t at = waiting[--depth].node;
        Range range = waiting[depth].range;
        int32_t left = split(tree, at, range), right = range.count - left - 1;
        if (right > 0) {
            waiting[depth].node = 2 * at + 2;
            waiting[depth++].range = (Range){range.first + left + 1, right};
        }
        if (left > 0) {
            waiting[depth].node = 2 * at + 1;
            waiting[depth++].range = (Range){range.first, left};
        }
    }
}
