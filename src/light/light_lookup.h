/* SPDX-License-Identifier: Apache-2.0
 *
 * Environment maps and discs in kernels: radiance and density of a direction, and directions drawn by that density.
 * Directions are unit vectors towards the light. Within a texel directions are uniform in solid angle and the density is
 * luminance / total, so a map of one value has 1 / 4 pi everywhere. Drawn directions keep off the edges of their texel
 * (disc) by what rounding can move them: looking one up finds what it was drawn with, to the bit. The radiance is
 * the same all over a texel and a disc, so nothing becomes biased by that. */
#ifndef NPH_LIGHT_LIGHT_LOOKUP_H
#define NPH_LIGHT_LIGHT_LOOKUP_H

#include "core/real.h"
#include "light/light.h"
#include "optics/phase_lookup.h"

#if NPH_PRECISION == 32
#define R_TEXEL_MARGIN 0x1p-20f /* of the map's width or height */
#define R_DISC_MARGIN 0x1p-22f  /* of the disc's radius over its size */
#else
#define R_TEXEL_MARGIN 0x1p-49
#define R_DISC_MARGIN 0x1p-51
#endif

typedef struct REnvironment {
    const float *radiance;
    const double *row_cdf, *column_cdf;
    int width, height;
    Real turns;       /* rotation / 2 pi, in [0, 1) */
    Real unit, share; /* density = luminance * unit * share; two factors, since 1 / total may leave the float range */
} REnvironment;

static inline REnvironment r_environment(const NphEnvironment *map, double rotation_rad) {
    REnvironment out;
    double turns = rotation_rad * 0.15915494309189535, exponent = 0.0;
    if (map->total > 0.0) nph_mantissa(map->total, &exponent);
    turns -= nph_floor(turns);
    out.radiance = map->radiance;
    out.row_cdf = map->row_cdf;
    out.column_cdf = map->column_cdf;
    out.width = map->width;
    out.height = map->height;
    out.turns = (Real)(turns < 1.0 ? turns : 0.0);
    double unit = nph_power_of_2(exponent > 126.0 ? -126.0 : exponent < -126.0 ? 126.0 : -exponent);
    out.unit = (Real)unit;
    out.share = map->total > 0.0 ? (Real)(1.0 / (map->total * unit)) : R(0.0);
    return out;
}

/* Copies a texel's radiance and returns its density [1/sr], 0 for a black one. Luminance as Rec. 709 weighs. */
static inline Real r_environment_texel(const REnvironment *map, int row, int column, Real radiance[3]) {
    const float *texel = map->radiance + 3 * ((int64_t)row * map->width + column);
    for (int c = 0; c < 3; c++) radiance[c] = (Real)texel[c];
    Real luminance = R(0.2126) * radiance[0] + R(0.7152) * radiance[1] + R(0.0722) * radiance[2];
    return luminance * map->unit * map->share;
}

/* Radiance from a direction, and the density with which r_environment_sample draws it. */
static inline Real r_environment_lookup(const REnvironment *map, const Real d[3], Real radiance[3]) {
    Real polar = r_atan2(r_sqrt(d[0] * d[0] + d[1] * d[1]), d[2]) * R(0.31830988618379067);
    Real u = R(0.5) - r_atan2(d[1], d[0]) * R(0.15915494309189535) + map->turns;
    Real row = polar * (Real)map->height, column = (u - r_floor(u)) * (Real)map->width;
    Real last_row = (Real)(map->height - 1), last_column = (Real)(map->width - 1);
    row = row > R(0.0) ? row : R(0.0); /* NaN becomes 0 */
    column = column > R(0.0) ? column : R(0.0);
    return r_environment_texel(map, (int)(row < last_row ? row : last_row),
                               (int)(column < last_column ? column : last_column), radiance);
}

/* The entry i with cdf[i] <= u < cdf[i + 1]: never one of probability 0. cdf[0] = 0, cdf[count] = 1, 0 <= u < 1. */
static inline int r_cdf_find(const double *cdf, int count, double u) {
    int low = 0, high = count;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (cdf[middle] <= u) low = middle;
        else high = middle;
    }
    return low;
}

/* Where u lies in its entry, kept off the ends. */
static inline Real r_cdf_rest(const double *cdf, int entry, double u, Real margin) {
    Real rest = (Real)((u - cdf[entry]) / (cdf[entry + 1] - cdf[entry]));
    margin = margin < R(0.5) ? margin : R(0.5);
    return r_clamp(rest, margin, R(1.0) - margin);
}

/* Draws a direction from two uniform numbers in [0, 1); returns its density, 0 only for an all-black map. The distance
 * from the nearer pole, 1 - |z| = 2 sin^2(polar / 2), is interpolated between the edges of the row: solid angle. */
static inline Real r_environment_sample(const REnvironment *map, Real u, Real w, Real d[3], Real radiance[3]) {
    int height = map->height, width = map->width, row = r_cdf_find(map->row_cdf, height, (double)u);
    const double *columns = map->column_cdf + (int64_t)row * (width + 1);
    int column = r_cdf_find(columns, width, (double)w), upper = 2 * row + 1 <= height;
    Real down = r_cdf_rest(map->row_cdf, row, (double)u, R_TEXEL_MARGIN * (Real)height);
    Real right = r_cdf_rest(columns, column, (double)w, R_TEXEL_MARGIN * (Real)width);
    Real edge0, edge1, unused, along, across, scale = R(0.25) / (Real)height;
    r_sincos2pi((Real)(upper ? row : height - row) * scale, &edge0, &unused);
    r_sincos2pi((Real)(upper ? row + 1 : height - row - 1) * scale, &edge1, &unused);
    edge0 *= R(2.0) * edge0;
    edge1 *= R(2.0) * edge1;
    Real near = edge0 + down * (edge1 - edge0), sine = r_sqrt(near * (R(2.0) - near));
    r_sincos2pi(R(0.5) - ((Real)column + right) / (Real)width + map->turns, &across, &along);
    d[0] = sine * along;
    d[1] = sine * across;
    d[2] = upper ? R(1.0) - near : near - R(1.0);
    return r_environment_texel(map, row, column, radiance);
}

/* A disc of directions around axis: those with 1 - cos < width. */
typedef struct RDisc {
    Real axis[3], width;
    Real density; /* 1 / solid angle = 1 / (2 pi width) [1/sr] */
} RDisc;

static inline RDisc r_disc(const double axis[3], double half_angle_rad) {
    double s = nph_sin(0.5 * half_angle_rad), width = 2.0 * s * s;
    RDisc disc;
    for (int a = 0; a < 3; a++) disc.axis[a] = (Real)axis[a];
    disc.width = (Real)width;
    disc.density = (Real)(0.15915494309189535 / width);
    return disc;
}

/* 1 - cos = |a - b|^2 / 2, which keeps its digits at small angles. */
static inline int r_disc_holds(const RDisc *disc, const Real d[3]) {
    Real x = d[0] - disc->axis[0], y = d[1] - disc->axis[1], z = d[2] - disc->axis[2];
    return R(0.5) * (x * x + y * y + z * z) < disc->width;
}

static inline void r_disc_sample(const RDisc *disc, Real u, Real w, Real d[3]) {
    Real fall = u * disc->width, most = disc->width - R_DISC_MARGIN * (r_sqrt(disc->width) + disc->width);
    fall = fall < most ? fall : most;
    r_turn_by(disc->axis, r_angle_of_fall(fall > R(0.0) ? fall : R(0.0)), w, d);
}

#endif
