/* SPDX-License-Identifier: Apache-2.0
 *
 * See kernel_kd_tree.h. */
#include "kernel_kd_tree.h"

#include "truth/photonmap/kd_tree_lookup.h"

enum { MOST = 4096 };

/* Insertion sort of what was found, by distance and node. */
static int report(const NphKdTree *tree, RKdFound *found, int count, int32_t *number, double *squared) {
    const RKdNode *nodes = tree->nodes;
    for (int i = 1; i < count; i++) {
        RKdFound moved = found[i];
        int at = i;
        for (; at > 0 && r_kd_farther(&found[at - 1], &moved); at--) found[at] = found[at - 1];
        found[at] = moved;
    }
    for (int i = 0; i < count; i++) {
        number[i] = (int32_t)r_kd_number(&nodes[found[i].node]);
        squared[i] = (double)found[i].squared;
    }
    return count;
}

int NPH_KERNEL(kd_nearest)(const NphKdTree *tree, const double p[3], double within, int k, int32_t *number,
                           double *squared) {
    RKdFound found[MOST];
    Real at[3] = {(Real)p[0], (Real)p[1], (Real)p[2]};
    int count = r_kd_nearest(tree->nodes, tree->count, at, (Real)within, k, found);
    for (int i = 1; i < count; i++)
        if (r_kd_farther(&found[i], &found[0])) return -1; /* the farthest is on top */
    return report(tree, found, count, number, squared);
}

int NPH_KERNEL(kd_brute)(const NphKdTree *tree, const double p[3], double within, int k, int32_t *number,
                         double *squared) {
    RKdFound found[MOST];
    const RKdNode *nodes = tree->nodes;
    int count = 0;
    for (int32_t i = 0; i < tree->count; i++) {
        Real x = (Real)p[0] - nodes[i].p[0], y = (Real)p[1] - nodes[i].p[1], z = (Real)p[2] - nodes[i].p[2];
        RKdFound here = {x * x + y * y + z * z, i};
        if (!(here.squared < (Real)within)) continue;
        int at = count < k ? count++ : k;
        for (; at > 0 && r_kd_farther(&found[at - 1], &here); at--)
            if (at < k) found[at] = found[at - 1];
        if (at < k) found[at] = here;
    }
    return report(tree, found, count, number, squared);
}

void NPH_KERNEL(kd_node)(const NphKdTree *tree, int32_t node, double p[3], int32_t *number, int *axis) {
    const RKdNode *at = (const RKdNode *)tree->nodes + node;
    for (int a = 0; a < 3; a++) p[a] = (double)at->p[a];
    *number = (int32_t)r_kd_number(at);
    *axis = (int)(at->tag & 3u);
}
