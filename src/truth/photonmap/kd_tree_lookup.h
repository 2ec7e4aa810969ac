/* SPDX-License-Identifier: Apache-2.0
 *
 * The kd-tree in kernels: its nodes, and the nearest points to a place.
 *
 * What is found is what looking at every point would find, to the bit: computed squared distances are sums of squares
 * that are not negative, so they are not below the rounded square of one coordinate's difference, and rounding is
 * monotonic, so points behind a plane are not nearer than the plane is. Of equally far points those of lower node come
 * first; a subtree is passed over only when its plane is farther than the farthest point kept. */
#ifndef NPH_TRUTH_PHOTONMAP_KD_TREE_LOOKUP_H
#define NPH_TRUTH_PHOTONMAP_KD_TREE_LOOKUP_H

#include "core/real.h"
#include "truth/photonmap/kd_tree.h"

typedef struct RKdNode {
    Real p[3];
    uint32_t tag; /* number of the point << 2 | axis of the split */
} RKdNode;

static inline uint32_t r_kd_number(const RKdNode *node) { return node->tag >> 2; }

typedef struct RKdFound {
    Real squared; /* distance, m2 */
    int32_t node;
} RKdFound;

static inline int r_kd_farther(const RKdFound *a, const RKdFound *b) {
    return a->squared > b->squared || (a->squared == b->squared && a->node > b->node);
}

/* Lets the element at the top of a heap (the farthest on top) sink to its place. */
static inline void r_kd_sink(RKdFound *found, int count) {
    RKdFound moved = found[0];
    int at = 0;
    for (int child = 1; child < count; child = 2 * at + 1) {
        if (child + 1 < count && r_kd_farther(&found[child + 1], &found[child])) child++;
        if (!r_kd_farther(&found[child], &moved)) break;
        found[at] = found[child];
        at = child;
    }
    found[at] = moved;
}

/* Puts a new last element into a heap of count elements, itself included. */
static inline void r_kd_rise(RKdFound *found, int count) {
    RKdFound moved = found[count - 1];
    int at = count - 1;
    while (at > 0 && r_kd_farther(&moved, &found[(at - 1) / 2])) {
        found[at] = found[(at - 1) / 2];
        at = (at - 1) / 2;
    }
    found[at] = moved;
}

/* The at most k >= 1 points nearest to p whose squared distance is below `within`. Returns their number; found is a heap:
 * the farthest is found[0]. */
static inline int r_kd_nearest(const RKdNode *nodes, int32_t count, const Real p[3], Real within, int k,
                               RKdFound *found) {
    struct {
        int32_t node;
        Real squared;
    } waiting[32];
    int depth = 0, kept = 0;
    int32_t node = 0;
    for (;;) {
        while (node < count) {
            const RKdNode *at = &nodes[node];
            Real x = p[0] - at->p[0], y = p[1] - at->p[1], z = p[2] - at->p[2];
            RKdFound here = {x * x + y * y + z * z, node};
            if (kept < k && here.squared < within) {
                found[kept++] = here;
                r_kd_rise(found, kept);
            } else if (kept > 0 && kept == k && r_kd_farther(&found[0], &here)) {
                found[0] = here;
                r_kd_sink(found, kept);
            }
            uint32_t axis = at->tag & 3u;
            Real off = axis == 0 ? x : axis == 1 ? y : z;
            int32_t left = 2 * node + 1, upper = off > R(0.0);
            waiting[depth].node = left + 1 - upper;
            waiting[depth++].squared = off * off;
            node = left + upper;
        }
        do {
            if (depth == 0) return kept;
            depth--;
        } while (kept < k || kept == 0 ? !(waiting[depth].squared < within)
                                       : waiting[depth].squared > found[0].squared);
        node = waiting[depth].node;
    }
}

#endif
