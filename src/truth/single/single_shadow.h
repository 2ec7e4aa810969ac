/* SPDX-License-Identifier: Apache-2.0
 *
 * Where on a ray the box of a medium stands between the ray and parallel light: air lies along all of a ray, and the shadow of a
 * cloud in it is short beside that. A point t of the ray is in the shadow when for some s >= 0 the point p + t d + s l is in the
 * box: half-planes of (t, s), a convex polygon, whose corners have the smallest and the largest t. */
#ifndef NPH_TRUTH_SINGLE_SINGLE_SHADOW_H
#define NPH_TRUTH_SINGLE_SINGLE_SHADOW_H

#include "transport/local_scene.h"

/* The half-plane t a + s b <= c. */
typedef struct NphHalfPlane {
    double a, b, c;
} NphHalfPlane;

enum { NPH_SHADOW_SIDES = 7 };

static inline void nph_shadow_sides(const RMedium *medium, const double p[3], const double d[3], const double light[3],
                                    NphHalfPlane side[NPH_SHADOW_SIDES]) {
    for (int a = 0; a < 3; a++) {
        const double *row = medium->from_local + 4 * a;
        double o = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
        double along = row[0] * d[0] + row[1] * d[1] + row[2] * d[2];
        double towards = row[0] * light[0] + row[1] * light[1] + row[2] * light[2];
        side[2 * a] = (NphHalfPlane){along, towards, medium->hi[a] - o};
        side[2 * a + 1] = (NphHalfPlane){-along, -towards, o - medium->lo[a]};
    }
    side[6] = (NphHalfPlane){0.0, -1.0, 0.0};
}

static inline int nph_shadow_holds(const NphHalfPlane *side, double t, double s) {
    double value = side->a * t + side->b * s, size = nph_abs(side->a * t) + nph_abs(side->b * s) + nph_abs(side->c);
    return value <= side->c + 1e-9 * size;
}

/* 0: no shadow falls on the ray. Where light and ray are parallel there is no polygon, and none is told. */
static inline int nph_shadow_on_ray(const RMedium *medium, const double p[3], const double d[3], const double light[3], double range[2]) {
    NphHalfPlane side[NPH_SHADOW_SIDES];
    nph_shadow_sides(medium, p, d, light, side);
    range[0] = 1e300;
    range[1] = -1e300;
    for (int i = 0; i < NPH_SHADOW_SIDES; i++)
        for (int j = 0; j < i; j++) {
            double det = side[i].a * side[j].b - side[j].a * side[i].b, inside = 1.0;
            if (!(nph_abs(det) > 1e-12 * (nph_abs(side[i].a * side[j].b) + nph_abs(side[j].a * side[i].b)))) continue;
            double t = (side[i].c * side[j].b - side[j].c * side[i].b) / det, s = (side[i].a * side[j].c - side[j].a * side[i].c) / det;
            for (int k = 0; k < NPH_SHADOW_SIDES; k++)
                if (k != i && k != j && !nph_shadow_holds(&side[k], t, s)) inside = 0.0;
            if (!(inside > 0.0)) continue;
            range[0] = t < range[0] ? t : range[0];
            range[1] = t > range[1] ? t : range[1];
        }
    return range[0] < range[1];
}

#endif
