/* SPDX-License-Identifier: Apache-2.0
 *
 * The hierarchy in kernels: closest and any hit, the point that was hit, and rays that leave it. Both traversals find
 * what testing every triangle would find, to the bit: of hits at equal t the one of the lowest number.
 *
 * That needs boxes that are never missed when a triangle in them is hit at t. The triangle test is exact for corners
 * moved by at most 6.2 u m (triangle_lookup.h; here m is the largest |coordinate| of the box relative to the origin,
 * and no corner in it has more), so t d_k lies within 6.2 u m of the box's slab, plus u m for d_z / d_k in place of
 * the shear's quotient, u m for t's own rounding, 10 u m for what its sum adds, and the slab's ends (l - e) / d_k are
 * computed with an error of 3.1 u (m + e) / |d_k|. Boxes wider by e = 32 u m on each side cover the sum. A direction
 * with d_k = 0 makes ends of infinity or, at 0 times infinity, NaN, which the comparisons below take for no limit. */
#ifndef NPH_GEOMETRY_BVH_LOOKUP_H
#define NPH_GEOMETRY_BVH_LOOKUP_H

#include "geometry/bvh.h"
#include "geometry/triangle_lookup.h"

typedef struct RBvh {
    const NphBvhNode *nodes; /* NULL: no triangles */
    const NphBvhTriangle *triangles;
    const Real *vertices;
} RBvh;

static inline RBvh r_bvh(const NphBvh *bvh) {
    RBvh out;
    out.nodes = bvh->nodes;
    out.triangles = bvh->triangles;
#if NPH_PRECISION == 32
    out.vertices = bvh->vertices_f32;
#else
    out.vertices = bvh->vertices;
#endif
    return out;
}

static inline const Real *r_bvh_corner(const RBvh *bvh, int32_t slot, int corner) {
    return bvh->vertices + 3 * (int64_t)bvh->triangles[slot].corner[corner];
}

/* 1 and where the ray enters, when it meets the widened box within [0, t_max]. */
static inline int r_box_hit(const RRay *ray, const NphBvhNode *node, Real t_max, Real *enter) {
    Real lo[3], hi[3], m = R(0.0), near = R(0.0), far = t_max;
    for (int k = 0; k < 3; k++) {
        lo[k] = (Real)node->lo[k] - ray->o[k];
        hi[k] = (Real)node->hi[k] - ray->o[k];
        m = r_max(m, r_max(-lo[k], hi[k]));
    }
    m *= R(32.0) * R_UNIT;
    for (int k = 0; k < 3; k++) {
        Real a = (ray->negative[k] ? hi[k] + m : lo[k] - m) * ray->inverse[k];
        Real b = (ray->negative[k] ? lo[k] - m : hi[k] + m) * ray->inverse[k];
        near = a > near ? a : near;
        far = b < far ? b : far;
    }
    *enter = near;
    return near <= far;
}

/* Tests a leaf's triangles; keeps the closest hit, of equal ones that with the lowest number. */
static inline void r_bvh_leaf(const RBvh *bvh, const NphBvhNode *leaf, const RRay *ray, RHit *best) {
    for (int32_t i = leaf->first; i < leaf->first + leaf->count; i++) {
        RHit hit;
        if (!r_triangle_hit(ray, r_bvh_corner(bvh, i, 0), r_bvh_corner(bvh, i, 1), r_bvh_corner(bvh, i, 2), best->t,
                            &hit))
            continue;
        hit.number = bvh->triangles[i].number;
        hit.slot = i;
        if (best->number < 0 || hit.t < best->t || hit.number < best->number) *best = hit;
    }
}

/* any: the first hit that turns up ends the search. */
static inline int r_bvh_walk(const RBvh *bvh, const RRay *ray, Real t_max, int any, RHit *best) {
    struct {
        int32_t node;
        Real enter;
    } stack[NPH_BVH_DEPTH];
    int waiting = 0;
    int32_t at = 0;
    Real enter;
    best->t = t_max;
    best->number = -1;
    best->slot = -1;
    best->weight[0] = best->weight[1] = R(0.0);
    if (!bvh->nodes || !r_box_hit(ray, bvh->nodes, t_max, &enter)) return 0;
    for (;;) {
        const NphBvhNode *node = &bvh->nodes[at];
        if (node->count > 0) {
            r_bvh_leaf(bvh, node, ray, best);
            if (any && best->number >= 0) return 1;
        } else {
            Real enter_1, enter_2;
            int hit_1 = r_box_hit(ray, node + 1, best->t, &enter_1);
            int hit_2 = r_box_hit(ray, &bvh->nodes[node->first], best->t, &enter_2);
            int32_t first = at + 1, second = node->first;
            if (hit_1 && hit_2) {
                int swap = enter_2 < enter_1;
                stack[waiting].node = swap ? first : second;
                stack[waiting++].enter = swap ? enter_1 : enter_2;
                at = swap ? second : first;
                continue;
            }
            at = hit_1 ? first : second;
            if (hit_1 || hit_2) continue;
        }
        do {
            if (waiting == 0) return best->number >= 0;
            at = stack[--waiting].node;
        } while (stack[waiting].enter > best->t);
    }
}

/* The closest hit with t in [0, t_max]; without one number is -1 and t = t_max. */
static inline int r_bvh_closest(const RBvh *bvh, const RRay *ray, Real t_max, RHit *hit) {
    return r_bvh_walk(bvh, ray, t_max, 0, hit);
}

/* 1 when there is a hit with t in [0, t_max]. */
static inline int r_bvh_any(const RBvh *bvh, const RRay *ray, Real t_max) {
    RHit hit;
    return r_bvh_walk(bvh, ray, t_max, 1, &hit);
}

#endif
