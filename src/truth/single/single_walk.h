/* SPDX-License-Identifier: Apache-2.0
 *
 * The voxels that a line crosses, in their order [Amanatides87], and the density in them; empty cells of 4^3 samples
 * are crossed as far as the grid knows them to be empty. Within one voxel a trilinear density is a polynomial of
 * third degree along a line, so two Gauss points [Golub69] integrate it exactly: optical depths have no error but
 * rounding. A nearest lookup is constant between planes half a sample off. Where sides repeat, a line crosses one
 * image of the medium after the other, cut to the period; distances go on. */
#ifndef NPH_TRUTH_SINGLE_WALK_H
#define NPH_TRUTH_SINGLE_WALK_H

#include "transport/flight_lookup.h"

/* The part [near, far] of a line in a medium, and the line in the medium's space: distances stay metres. inv = 1 / d,
 * and 1e300 along an axis that the line does not move along: a plane ahead is then never reached. */
typedef struct NphLine {
    double o[3], d[3], inv[3], near, far;
} NphLine;

/* 0 when nothing of [from, limit] lies inside. */
static inline int nph_line_clip(const RMedium *medium, const double p[3], const double d[3], double from, double limit,
                                NphLine *line) {
    line->near = from;
    line->far = limit;
    for (int a = 0; a < 3; a++) {
        const double *row = medium->from_local + 4 * a;
        line->o[a] = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
        line->d[a] = row[0] * d[0] + row[1] * d[1] + row[2] * d[2];
        line->inv[a] = 1e300;
        if (nph_abs(line->d[a]) > 1e-300) {
            line->inv[a] = 1.0 / line->d[a];
            double t0 = (medium->lo[a] - line->o[a]) * line->inv[a], t1 = (medium->hi[a] - line->o[a]) * line->inv[a];
            double first = t0 < t1 ? t0 : t1, last = t0 < t1 ? t1 : t0;
            line->near = first > line->near ? first : line->near;
            line->far = last < line->far ? last : line->far;
        } else if (!(line->o[a] >= medium->lo[a] && line->o[a] < medium->hi[a]))
            return 0;
    }
    return line->near < line->far;
}

/* Where a walk stands: in a cell of 4^3 samples that ends at `end`, in the voxel v that ends where the first of `next`
 * is reached. */
typedef struct NphVoxelWalk {
    int32_t cell[3], step, v[3];
    int within, by; /* in the voxels of a cell that is not empty; axis along which the cell is left */
    double t, end, next[3];
    double shift;        /* nearest: voxels reach half a sample to either side */
    int32_t first, last; /* voxels of a cell, from four times its number */
} NphVoxelWalk;

static inline int32_t nph_walk_floor(double u, int32_t lo, int32_t hi) {
    double low = (double)lo, high = (double)hi;
    return (int32_t)nph_floor(u < low ? low : u > high ? high : u);
}

/* The walk stands at t in a cell: where the cell ends, and its first voxel. */
static inline void nph_walk_cell(const RMedium *medium, const NphLine *line, NphVoxelWalk *walk) {
    const int32_t *n = medium->majorant_n;
    double bound = (double)medium->majorant[(walk->cell[2] * n[1] + walk->cell[1]) * n[0] + walk->cell[0]];
    walk->step = bound < 0.0 ? (int32_t)-bound : 1;
    walk->end = line->far;
    walk->by = -1;
    for (int a = 0; a < 3; a++) {
        int32_t plane = 4 * (walk->cell[a] + (line->inv[a] > 0.0 ? walk->step : 1 - walk->step));
        double t = ((double)plane - line->o[a]) * line->inv[a];
        if (t < walk->end) {
            walk->end = t;
            walk->by = a;
        }
    }
    walk->within = bound > 0.0 && walk->end > walk->t;
    for (int a = 0; a < 3 && walk->within; a++) {
        double u = line->o[a] + walk->t * line->d[a] + walk->shift;
        walk->v[a] = nph_walk_floor(u, 4 * walk->cell[a] + walk->first, 4 * walk->cell[a] + walk->last);
        double plane = (double)(walk->v[a] + (line->inv[a] > 0.0 ? 1 : 0)) - walk->shift;
        walk->next[a] = (plane - line->o[a]) * line->inv[a];
    }
}

static inline NphVoxelWalk nph_walk_enter(const RMedium *medium, const NphLine *line) {
    NphVoxelWalk walk;
    walk.shift = (double)medium->grid.shift;
    walk.first = 0;
    walk.last = walk.shift > 0.0 ? 4 : 3;
    walk.t = line->near;
    for (int a = 0; a < 3; a++)
        walk.cell[a] = nph_walk_floor((line->o[a] + line->near * line->d[a]) * 0.25, 0, medium->majorant_n[a] - 1);
    nph_walk_cell(medium, line, &walk);
    return walk;
}

/* Behind the block of `step` cells; 0 when the line leaves the medium there. */
static inline int nph_walk_cross(const RMedium *medium, const NphLine *line, NphVoxelWalk *walk) {
    if (walk->by < 0) return 0;
    walk->t = walk->end > walk->t ? walk->end : walk->t;
    for (int a = 0; a < 3; a++) {
        int32_t way = line->inv[a] > 0.0 ? 1 : -1, last = walk->cell[a] + way * (walk->step - 1);
        int32_t lo = way > 0 ? walk->cell[a] : last, hi = way > 0 ? last : walk->cell[a];
        walk->cell[a] = a == walk->by ? last + way : nph_walk_floor((line->o[a] + walk->t * line->d[a]) * 0.25, lo, hi);
        if (walk->cell[a] < 0 || walk->cell[a] >= medium->majorant_n[a]) return 0;
    }
    nph_walk_cell(medium, line, walk);
    return 1;
}

/* The next voxel that the line crosses, from t to e; 0 at the end. */
static inline int nph_walk_voxel(const RMedium *medium, const NphLine *line, NphVoxelWalk *walk, int32_t v[3],
                                 double *t, double *e) {
    for (;;) {
        while (walk->within) {
            int a = walk->next[0] < walk->next[1] ? 0 : 1;
            a = walk->next[2] < walk->next[a] ? 2 : a;
            *t = walk->t;
            *e = walk->next[a] < walk->end ? walk->next[a] : walk->end;
            for (int b = 0; b < 3; b++) v[b] = walk->v[b];
            if (walk->next[a] < walk->end) {
                int32_t way = line->inv[a] > 0.0 ? 1 : -1;
                walk->v[a] += way;
                walk->next[a] = ((double)(walk->v[a] + (way > 0 ? 1 : 0)) - walk->shift - line->o[a]) * line->inv[a];
                int32_t within = walk->v[a] - 4 * walk->cell[a];
                walk->within = within >= walk->first && within <= walk->last;
            } else
                walk->within = 0;
            if (!(*e > *t)) continue;
            walk->t = *e;
            return 1;
        }
        if (!nph_walk_cross(medium, line, walk)) return 0;
    }
}

/* The eight samples around a voxel, x fastest; of a nearest lookup one, eight times. 0 when all are 0. */
static inline int nph_voxel_corners(const RMedium *medium, const int32_t v[3], double corner[8]) {
    const float *at = medium->grid.values + r_grid_element(&medium->grid, v[0], v[1], v[2]);
    static const int offset[8] = {0, 1, 9, 10, 81, 82, 90, 91};
    int nearest = medium->grid.shift > 0.0f, some = 0;
    for (int i = 0; i < 8; i++) {
        corner[i] = (double)at[nearest ? 0 : offset[i]];
        some |= corner[i] > 0.0;
    }
    return some;
}

/* The density at t of the line, in the voxel v with these corners. */
static inline double nph_voxel_density(const NphLine *line, const int32_t v[3], const double corner[8], double t) {
    double f = line->o[0] + t * line->d[0] - (double)v[0], g = line->o[1] + t * line->d[1] - (double)v[1];
    double h = line->o[2] + t * line->d[2] - (double)v[2];
    double c00 = corner[0] + f * (corner[1] - corner[0]), c10 = corner[2] + f * (corner[3] - corner[2]);
    double c01 = corner[4] + f * (corner[5] - corner[4]), c11 = corner[6] + f * (corner[7] - corner[6]);
    double c0 = c00 + g * (c10 - c00), c1 = c01 + g * (c11 - c01);
    return c0 + h * (c1 - c0);
}

/* The part [from, to] of a line in one image of a medium, and where the line began if that image were the first one. */
typedef struct NphLineImage {
    double q[3], from, to, end;
    int32_t at[2], left; /* left: images that may follow */
} NphLineImage;

static inline double nph_image_side(const RPeriod *period, const double p[3], const double d[3], int a, int32_t at) {
    if (!(nph_abs(d[a]) > 1e-300) || !(period->size[a] > 0.0)) return 1e300;
    return (period->lo[a] + (double)(at + (d[a] > 0.0 ? 1 : 0)) * period->size[a] - p[a]) / d[a];
}

static inline void nph_image_reach(const RMedium *medium, const double p[3], const double d[3], NphLineImage *image) {
    const RPeriod *period = &medium->period;
    image->to = image->end;
    for (int a = 0; a < 2; a++) {
        double side = nph_image_side(period, p, d, a, image->at[a]);
        image->to = side < image->to ? side : image->to;
        image->q[a] = p[a] - (double)image->at[a] * period->size[a];
    }
}

/* The first image that [from, limit] meets; 0 when it never meets the medium. */
static inline int nph_image_first(const RMedium *medium, const double p[3], const double d[3], double from,
                                  double limit, NphLineImage *image) {
    *image = (NphLineImage){{p[0], p[1], p[2]}, from, limit, limit, {0, 0}, NPH_MAX_IMAGES};
    const RPeriod *period = &medium->period;
    if (!period->on) return from < limit;
    for (int a = 0; a < 3; a++) {
        if (!(nph_abs(d[a]) > 1e-300)) {
            if (p[a] < medium->reach_lo[a] || p[a] > medium->reach_hi[a]) return 0;
            continue;
        }
        double t0 = (medium->reach_lo[a] - p[a]) / d[a], t1 = (medium->reach_hi[a] - p[a]) / d[a];
        double first = t0 < t1 ? t0 : t1, last = t0 < t1 ? t1 : t0;
        image->from = first > image->from ? first : image->from;
        image->end = last < image->end ? last : image->end;
    }
    if (!(image->from < image->end)) return 0;
    for (int a = 0; a < 2; a++) {
        double count = nph_floor((p[a] + image->from * d[a] - period->lo[a]) * period->inverse[a]);
        image->at[a] = nph_abs(count) < 1e9 ? (int32_t)count : 0;
    }
    nph_image_reach(medium, p, d, image);
    return 1;
}

/* The next one; 0 at the end of the line, and when too many were passed: image->left is then 0. */
static inline int nph_image_next(const RMedium *medium, const double p[3], const double d[3], NphLineImage *image) {
    const RPeriod *period = &medium->period;
    if (!period->on || !(image->to < image->end) || --image->left == 0) return 0;
    double x = nph_image_side(period, p, d, 0, image->at[0]), y = nph_image_side(period, p, d, 1, image->at[1]);
    int a = y < x ? 1 : 0;
    image->at[a] += d[a] > 0.0 ? 1 : -1;
    image->from = image->to > image->from ? image->to : image->from;
    nph_image_reach(medium, p, d, image);
    return 1;
}

/* What lines cost. */
typedef struct NphWalked {
    int64_t voxels, exhausted; /* exhausted: lines that passed NPH_MAX_IMAGES periods without an end */
} NphWalked;

static inline double nph_line_depth(const RMedium *medium, const NphLine *line, double enough, NphWalked *walked) {
    if (medium->shape != NPH_SHAPE_GRID) return line->far - line->near;
    NphVoxelWalk walk = nph_walk_enter(medium, line);
    double depth = 0.0, t, e, corner[8];
    int32_t v[3];
    while (depth < enough && nph_walk_voxel(medium, line, &walk, v, &t, &e)) {
        walked->voxels++;
        if (!nph_voxel_corners(medium, v, corner)) continue;
        double middle = 0.5 * (t + e), half = 0.5 * (e - t), off = half * 0.57735026918962576451;
        depth += half *
                 (nph_voxel_density(line, v, corner, middle - off) + nph_voxel_density(line, v, corner, middle + off));
    }
    return depth;
}

/* The integral of the density over [0, limit] of a ray; 1 m of a box or layer is 1. Beyond `enough` nobody looks. */
static inline double nph_single_depth(const RMedium *medium, const double p[3], const double d[3], double limit,
                                      double enough, NphWalked *walked) {
    NphLine line;
    NphLineImage image;
    double depth = 0.0;
    if (medium->shape == NPH_SHAPE_AIR) return r_air_passed(medium, p, d, limit);
    if (!nph_image_first(medium, p, d, 0.0, limit, &image)) return 0.0;
    do {
        if (nph_line_clip(medium, image.q, d, image.from, image.to, &line))
            depth += nph_line_depth(medium, &line, enough - depth, walked);
    } while (depth < enough && nph_image_next(medium, p, d, &image));
    walked->exhausted += image.left == 0;
    return depth;
}

#endif
