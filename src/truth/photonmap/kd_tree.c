/* SPDX-License-Identifier: Apache-2.0
 *
 * The build of the kd-tree on the pool: the upper levels node by node, one level after another, then a subtree a block. */
#include "truth/photonmap/kd_tree.h"

#include "core/message.h"
#include "core/pool.h"

enum { LEVELS_TOGETHER = 7 }; /* above the subtrees */

#define BUILDS(name, arguments)                                                                                        \
    void name##_f32_base arguments;                                                                                    \
    void name##_f64_base arguments
BUILDS(nph_kd_fill, (NphKdTree *, const void *));
BUILDS(nph_kd_split, (NphKdTree *, int32_t));
BUILDS(nph_kd_subtree, (NphKdTree *, int32_t));

typedef struct Level {
    NphKdTree *tree;
    void (*run)(NphKdTree *tree, int32_t node);
    int32_t first;
    double *seconds;
} Level;

size_t nph_kd_node_bytes(int precision) { return precision == 32 ? 4 * sizeof(float) : 4 * sizeof(double); }

void nph_kd_fill(NphKdTree *tree, const void *points) {
    if (tree->precision == 32)
        nph_kd_fill_f32_base(tree, points);
    else
        nph_kd_fill_f64_base(tree, points);
}

/* Rows above the last one are full; the last one fills the left half first. */
int32_t nph_kd_left(int32_t n) {
    int32_t half = 1; /* what one half of the last row holds */
    if (n == 1) return 0;
    while (half <= n / 4) half *= 2;
    int32_t last = n - (2 * half - 1);
    return half - 1 + (last < half ? last : half);
}

static NphStatus run_node(void *data, int64_t block, int worker) {
    Level *level = data;
    double start = nph_seconds();
    level->run(level->tree, level->first + (int32_t)block);
    if (level->seconds) level->seconds[worker] += nph_seconds() - start;
    return NPH_OK;
}

NphStatus nph_kd_build(NphContext *context, NphKdTree *tree, double *seconds) {
    int f32 = tree->precision == 32;
    Level level = {tree, f32 ? nph_kd_split_f32_base : nph_kd_split_f64_base, 0, seconds};
    for (int depth = 0; depth <= LEVELS_TOGETHER && level.first < tree->count; depth++) {
        int32_t width = (int32_t)1 << depth, rest = tree->count - level.first;
        if (depth == LEVELS_TOGETHER) level.run = f32 ? nph_kd_subtree_f32_base : nph_kd_subtree_f64_base;
        NPH_TRY(nph_pool_run(context, width < rest ? width : rest, run_node, &level, NULL));
        level.first += width;
    }
    return NPH_OK;
}
