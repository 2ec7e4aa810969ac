/* SPDX-License-Identifier: Apache-2.0
 *
 * A left-balanced kd-tree over points [Bentley75], stored as a heap without pointers: the children of node i are 2 i + 1 and
 * 2 i + 2. Each node splits its points along the axis of their longest extent (the first of equal ones) at the point
 * whose rank makes the tree left-balanced. Ranks order points by coordinate and then by number: no two are alike, so
 * the tree is a function of the points, whatever thread builds which part. */
#ifndef NPH_TRUTH_PHOTONMAP_KD_TREE_H
#define NPH_TRUTH_PHOTONMAP_KD_TREE_H

#include <stddef.h>
#include <stdint.h>

#include "nephos/context.h"

enum { NPH_KD_MOST = (1 << 30) - 1 }; /* points: number and axis share 32 bits */

/* Memory is the caller's: nodes and items of room for count elements of nph_kd_node_bytes, aligned to 16. */
typedef struct NphKdTree {
    int precision; /* 32 or 64: coordinates are float or double */
    int32_t count; /* 0 to NPH_KD_MOST */
    void *nodes;   /* the tree, once built */
    void *items;   /* scratch of the build */
} NphKdTree;

size_t nph_kd_node_bytes(int precision);

/* points: float or double [count][3], finite. Point i keeps the number i. */
void nph_kd_fill(NphKdTree *tree, const void *points);

/* Builds the tree of what the items hold (nph_kd_fill, or RKdNode of kd_tree_lookup.h with axis 0 written by a kernel);
 * the items are in no order afterwards. seconds: per worker, added to; may be NULL. NPH_INTERRUPTED leaves no tree. */
NphStatus nph_kd_build(NphContext *context, NphKdTree *tree, double *seconds);

/* How many of n points of a left-balanced tree are left of its root; n >= 1. */
int32_t nph_kd_left(int32_t n);

#endif
