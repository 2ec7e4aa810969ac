/* SPDX-License-Identifier: Apache-2.0
 *
 * The kd-tree's lookup in both precisions for the tests, and the same by looking at every point. */
#ifndef NPH_TESTS_KERNEL_KD_TREE_H
#define NPH_TESTS_KERNEL_KD_TREE_H

#include "core/cpu.h"
#include "truth/photonmap/kd_tree.h"

/* The nearest points to p, nearest first: their numbers and squared distances; returns how many. */
NPH_KERNEL_DECLARE(int, kd_nearest,
                   (const NphKdTree *tree, const double p[3], double within, int k, int32_t *number, double *squared));
NPH_KERNEL_DECLARE(int, kd_brute,
                   (const NphKdTree *tree, const double p[3], double within, int k, int32_t *number, double *squared));

/* Node i's point, number and axis. */
NPH_KERNEL_DECLARE(void, kd_node, (const NphKdTree *tree, int32_t node, double p[3], int32_t *number, int *axis));

#endif
