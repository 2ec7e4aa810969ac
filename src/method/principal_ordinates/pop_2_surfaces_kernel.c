/* SPDX-License-Identifier: Apache-2.0
 *
 * Surfaces that light the medium and shade it [Elek14 sec. 6].
 *
 * pop.reflect  a reflective shadow map [Dachsbacher05] of every sun, ordinate and point: what its light meets first, and the power that goes
 *              from there, irradiance times the area of a texel times albedo, behind what the medium leaves. Around a point the map is
 *              octahedral. Of light from afar it lies across the light, around the medium: texels at u, v in [-1, 1] look at places
 *              r s(u), s = 1.1 u / (1 - 0.9 |u|), r the radius of the medium's box: half of them within r, the last at 11 r.
 * pop.vpls     virtual point lights drawn from all maps together, at equal steps of the sum of their weights: the luminance of that power
 *              times r^2 / (r^2 + d^2), d how far the medium's middle is. Expectations do not depend on weights. A light stands for the
 *              area A of its texel over how often it is expected; with â it is prefiltered as a cap of that area's solid angle, seen from the
 *              medium's middle.
 * pop.shadows  how much of every cell of a grid the unscattered light reaches: shadow maps of n x n rays for a column of cells along the
 *              light. What has been scattered passes through surfaces. */
#include "method/principal_ordinates/pop_surface.h"

void NPH_KERNEL(nph_pop_reflect)(const void *memory, const NphPopArrays *arrays, int light);
void NPH_KERNEL(nph_pop_vpls)(const NphJob *job, const void *memory, const NphPopArrays *arrays);
void NPH_KERNEL(nph_pop_shadow)(const void *memory, const NphPopArrays *arrays, int grid);

/* So far before a place `off` from the medium's middle that light on its way there has met nothing: beyond all meshes, and on the lit side
 * of planes. */
static double before(const RPopScene *scene, const double way[3], double off) {
    const RSurfaces *surfaces = &scene->local.surfaces;
    double far = scene->around + off, slope = nph_abs(way[2]) > 1e-3 ? nph_abs(way[2]) : 1e-3;
    for (int i = 0; i < surfaces->plane_count; i++) {
        double height = (nph_abs(scene->middle[2] - surfaces->height[i]) + 2.0 * off) / slope;
        far = height > far ? height : far;
    }
    return far;
}

/* A ray of the map of a texel. */
typedef struct Look {
    Real p[3], d[3];
    double size; /* area across the light [m2], or solid angle [sr] */
} Look;

static double warp(double u) { return 1.1 * u / (1.0 - 0.9 * nph_abs(u)); }

/* Of the texel around u. */
static double warp_width(double u, double edge) { return warp(u + 0.5 * edge) - warp(u - 0.5 * edge); }

static void look_along(const RPopScene *scene, const Real *row, const double uv[2], Look *look) {
    double axis[3][3] = {{0.0}}, way[3], edge = 2.0 / (double)scene->choice.rsm, s[2];
    for (int a = 0; a < 3; a++) way[a] = (double)row[NPH_POP_WAY + a];
    r_pop_axes(scene, way, axis);
    for (int b = 0; b < 2; b++) s[b] = scene->radius * warp(uv[b]);
    double off = scene->radius + nph_sqrt(s[0] * s[0] + s[1] * s[1]), back = before(scene, way, off);
    for (int a = 0; a < 3; a++) {
        look->p[a] = (Real)(scene->middle[a] + s[0] * axis[0][a] + s[1] * axis[1][a] - back * axis[2][a]);
        look->d[a] = (Real)axis[2][a];
    }
    look->size = scene->radius * scene->radius * warp_width(uv[0], edge) * warp_width(uv[1], edge);
}

static void look_around(const RPopScene *scene, const Real *row, const double uv[2], Look *look) {
    Real u = (Real)uv[0], v = (Real)uv[1];
    for (int a = 0; a < 3; a++) look->p[a] = row[NPH_POP_WAY + a];
    r_octahedron_way(u, v, look->d);
    look->size = (double)r_octahedron_solid(u, v, scene->choice.rsm);
}

/* The map of a sun, ordinate or point. */
void NPH_KERNEL(nph_pop_reflect)(const void *memory, const NphPopArrays *arrays, int light) {
    const RPopScene *scene = memory;
    const NphPopChoice *choice = &scene->choice;
    const Real *row = (const Real *)arrays->ordinate + (int64_t)light * NPH_POP_ROW;
    int n = choice->rsm, point = light >= choice->suns + choice->sky;
    Real *out = (Real *)arrays->rsm + (int64_t)light * n * n * NPH_POP_TEXEL;
    for (int y = 0; y < n; y++)
        for (int x = 0; x < n; x++, out += NPH_POP_TEXEL) {
            double uv[2] = {(2.0 * (double)x + 1.0) / (double)n - 1.0, (2.0 * (double)y + 1.0) / (double)n - 1.0};
            Look look;
            RMet met;
            Real T[3];
            for (int k = 0; k < NPH_POP_TEXEL; k++) out[k] = R(0.0);
            (point ? look_around : look_along)(scene, row, uv, &look);
            if (!r_closest_surface(&scene->local, look.p, look.d, R_HUGE, &met)) continue;
            r_pop_transmittance(scene, arrays->medium, look.p, look.d, met.limit, T);
            double squared = point ? (double)met.t * (double)met.t : 1.0;
            Real slope = r_max(-r_dot(met.n, look.d), R(1e-6));
            for (int a = 0; a < 3; a++) {
                out[NPH_POP_TEXEL_PLACE + a] = met.p[a];
                out[NPH_POP_TEXEL_NORMAL + a] = met.n[a];
                out[NPH_POP_TEXEL_POWER + a] = row[NPH_POP_VALUE + a] * T[a] * scene->local.surfaces.albedo[met.surface][a] * (Real)look.size;
            }
            out[NPH_POP_TEXEL_AREA] = (Real)(look.size * squared) / slope;
        }
}

static double weight_of(const RPopScene *scene, const Real *texel) {
    double squared = 0.0, radius = scene->radius * scene->radius;
    for (int a = 0; a < 3; a++) {
        double off = (double)texel[NPH_POP_TEXEL_PLACE + a] - scene->middle[a];
        squared += off * off;
    }
    return (double)r_luminance(texel + NPH_POP_TEXEL_POWER) * radius / (radius + squared);
}

/* part: the weight of the texel over that of all. most: the largest part of a texel, for the print's mean cosine. */
static void put_vpl(const RPopScene *scene, const Real *texel, double part, double most, Real *row) {
    double often = part * (double)scene->choice.vpls, area = (double)texel[NPH_POP_TEXEL_AREA] / often, squared = 0.0, cosine = 1.0;
    for (int a = 0; a < 3; a++) {
        double off = (double)texel[NPH_POP_TEXEL_PLACE + a] - scene->middle[a];
        squared += off * off;
        row[NPH_POP_WAY + a] = texel[NPH_POP_TEXEL_PLACE + a];
        row[NPH_POP_NORMAL + a] = texel[NPH_POP_TEXEL_NORMAL + a];
        row[NPH_POP_VALUE + a] = (Real)((double)texel[NPH_POP_TEXEL_POWER + a] / often * 0.31830988618379067);
    }
    double edge = area * 0.31830988618379067, solid = 6.283185307179586 * (1.0 - nph_sqrt(squared / (squared + edge)));
    if (scene->prefilter != NPH_POP_PREFILTER_NONE) cosine = 1.0 - solid * 0.079577471545947668;
    if (scene->prefilter == NPH_POP_PREFILTER_CAP) {
        if (scene->paper) cosine = 1.0 - part / most / (double)scene->choice.vpls;
        if (scene->beta != R(1.0)) cosine = cosine > 0.0 ? nph_exp((double)scene->beta * nph_log(cosine)) : 0.0;
    }
    row[NPH_POP_COSINE] = (Real)cosine;
    row[NPH_POP_SOLID_ANGLE] = (Real)solid;
    row[NPH_POP_AREA] = (Real)area;
}

void NPH_KERNEL(nph_pop_vpls)(const NphJob *job, const void *memory, const NphPopArrays *arrays) {
    const RPopScene *scene = memory;
    const NphPopChoice *choice = &scene->choice;
    const Real *texels = arrays->rsm;
    Real *rows = (Real *)arrays->ordinate + (int64_t)nph_pop_lamps(choice) * NPH_POP_ROW;
    int64_t count = (int64_t)nph_pop_lamps(choice) * choice->rsm * choice->rsm;
    double all = 0.0, most = 0.0, sum = 0.0;
    int put = 0;
    for (int k = 0; k < choice->vpls; k++) {
        Real *row = rows + (int64_t)k * NPH_POP_ROW;
        for (int i = 0; i < NPH_POP_ROW; i++) row[i] = R(0.0);
        for (int a = 0; a < 3; a++) row[NPH_POP_WAY + a] = (Real)scene->middle[a]; /* dark ones: anywhere */
        row[NPH_POP_NORMAL + 2] = row[NPH_POP_COSINE] = R(1.0);
    }
    for (int64_t i = 0; i < count; i++) {
        double weight = weight_of(scene, texels + i * NPH_POP_TEXEL);
        all += weight;
        most = weight > most ? weight : most;
    }
    NphWords words = nph_philox(job->seed, (uint32_t)NPH_RNG_POP_VPL << 24 | (job->frame & 0xffffffu), 0, 0, 0, 0);
    double begin = nph_uniform(words.w0), step = all / (double)choice->vpls;
    for (int64_t i = 0; i < count && all > 0.0; i++) {
        double weight = weight_of(scene, texels + i * NPH_POP_TEXEL);
        sum += weight;
        for (; put < choice->vpls && ((double)put + begin) * step < sum && weight > 0.0; put++)
            put_vpl(scene, texels + i * NPH_POP_TEXEL, weight / all, most / all, rows + (int64_t)put * NPH_POP_ROW);
    }
}

/* The part of [from, to] before t. */
R_INLINE Real lit_part(Real t, Real from, Real to) { return r_min(r_max((t - from) / (to - from), R(0.0)), R(1.0)); }

/* A ray of the shadow map, `share` of its column of cells. */
static void shade_column(const RPopScene *scene, const RPopGrid *grid, const Look *look, double starts, Real share, Real *column) {
    RMet met;
    int64_t plane = (int64_t)grid->n[0] * grid->n[1];
    Real t = r_closest_surface(&scene->local, look->p, look->d, R_HUGE, &met) ? met.t + (Real)starts : R_HUGE;
    for (int32_t z = 0; z < grid->n[2]; z++) {
        Real from = grid->radial ? r_pop_radius(grid, (Real)z) : grid->low[2] + (Real)z * grid->edge[2];
        Real to = grid->radial ? r_pop_radius(grid, (Real)(z + 1)) : grid->low[2] + (Real)(z + 1) * grid->edge[2];
        column[z * plane] += share * lit_part(t, from, to);
    }
}

/* x, y: in cells. Returns where along the axis of the grid the ray starts. */
static double look_down(const RPopScene *scene, const RPopGrid *grid, double x, double y, Look *look) {
    double way[3], s[2] = {(double)grid->low[0] + x * (double)grid->edge[0], (double)grid->low[1] + y * (double)grid->edge[1]};
    for (int a = 0; a < 3; a++) way[a] = (double)grid->axis[2][a];
    double back = before(scene, way, 2.0 * scene->radius);
    for (int a = 0; a < 3; a++) {
        look->p[a] = (Real)((double)grid->middle[a] + s[0] * (double)grid->axis[0][a] + s[1] * (double)grid->axis[1][a] - back * way[a]);
        look->d[a] = grid->axis[2][a];
    }
    return -back;
}

void NPH_KERNEL(nph_pop_shadow)(const void *memory, const NphPopArrays *arrays, int number) {
    const RPopScene *scene = memory;
    const NphPopChoice *choice = &scene->choice;
    const Real *row = (const Real *)arrays->ordinate + (int64_t)number * NPH_POP_ROW;
    RPopGrid grid = r_pop_grid(scene, row, number);
    int n = choice->shadows;
    Real *out = (Real *)arrays->lit + nph_pop_first(choice, number, 1), share = R(1.0) / (Real)(n * n);
    for (int64_t i = 0; i < nph_pop_cells(grid.n); i++) out[i] = R(0.0);
    for (int32_t y = 0; y < grid.n[1]; y++)
        for (int32_t x = 0; x < grid.n[0]; x++)
            for (int k = 0; k < n * n; k++) {
                int i = k % n, j = k / n;
                double u = (double)x + ((double)i + 0.5) / (double)n, v = (double)y + ((double)j + 0.5) / (double)n, starts = 0.0;
                Look look;
                if (grid.radial) look_around(scene, row, (double[]){2.0 * u / (double)grid.n[0] - 1.0, 2.0 * v / (double)grid.n[1] - 1.0}, &look);
                else starts = look_down(scene, &grid, u, v, &look);
                shade_column(scene, &grid, &look, starts, share, out + (int64_t)y * grid.n[0] + x);
            }
}
