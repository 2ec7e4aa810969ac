/* SPDX-License-Identifier: Apache-2.0
 *
 * The fixed binary tree, folded from left to right: after value i, as many finished nodes are joined as i + 1 has trailing
 * zeros, like the carries of a binary counter. */
#include "core/reduce.h"

double nph_tree_sum(const double *values, int64_t count, int64_t stride) {
    double waiting[64];
    int top = 0;
    if (count <= 0) return 0.0;
    for (int64_t i = 0; i < count; i++) {
        double node = values[i * stride];
        for (int64_t carry = i + 1; carry % 2 == 0; carry /= 2) node = waiting[--top] + node;
        waiting[top++] = node;
    }
    double sum = waiting[--top];
    while (top > 0) sum = waiting[--top] + sum;
    return sum;
}
