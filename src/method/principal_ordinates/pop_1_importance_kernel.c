/* SPDX-License-Identifier: Apache-2.0
 *
 * pop.importance [Elek14 sec. 5.2]. Importance travels as light does: from the camera into a grid of 16^3 cells that fills the part of
 * the picture's frustum (of parallel rays: the block) in which the medium's box lies, along the rays. A column is a part of the picture,
 * and carries the same importance however wide it is. What leaves the grid after a scattering, in a direction that its side faces, is
 * added to the map by that direction, per solid angle, with the lobe of the mean cosine of all that left there: what importance
 * says of light from there. Then each texel is mixed with its neighbours (1 2 1 along both axes).
 *
 * Planes of cells, from the eye; along the middle ray the depth, from the nearest to the farthest corner of the box. */
#include "method/principal_ordinates/pop_kept.h"

void NPH_KERNEL(nph_pop_importance)(const void *memory, const NphPopArrays *arrays, void *worker);
size_t NPH_KERNEL(nph_pop_scratch_bytes)(const NphPopChoice *choice);

enum { N = NPH_POP_IMPORTANCE_CELLS, CELLS = N * N * N, TEXELS = NPH_POP_MAP_WIDTH * NPH_POP_MAP_HEIGHT };

/* A grid's cells, three planes of what they send, masks, and guards; or importance. */
size_t NPH_KERNEL(nph_pop_scratch_bytes)(const NphPopChoice *choice) {
    int64_t most = r_pop_most_cells(choice), across = choice->flat[0] > choice->radial[0] ? choice->flat[0] : choice->radial[0];
    across = across > choice->vpl[0] ? across : choice->vpl[0];
    int32_t plane[3] = {(int32_t)across, (int32_t)across, 1};
    int64_t ring = 3 * R_POP_RING * r_pop_room(plane) + 4 * across + 2 * r_pop_room(plane);
    int64_t grid = (3 + R_POP_KEEPS) * most + R_POP_PLANES + ring + 256, own = choice->importance ? 22 * CELLS : 0;
    return sizeof(Real) * (size_t)(grid > own ? grid : own);
}

typedef struct Frustum {
    double near, far, at[3];
    const NphSensor *sensor;
    int parallel;
} Frustum;

static Frustum frustum_of(const RPopScene *scene) {
    const NphSensor *sensor = &scene->local.sensor;
    Frustum f = {.near = 1e300, .far = -1e300, .sensor = sensor};
    f.parallel = sensor->kind == NPH_SENSOR_ORTHOGRAPHIC || sensor->kind == NPH_SENSOR_RADIANCE;
    for (int a = 0; a < 3; a++) f.at[a] = sensor->position[a] - scene->local.origin[a];
    for (int k = 0; k < 8; k++) {
        double depth = 0.0;
        for (int a = 0; a < 3; a++) depth += (scene->corner[k][a] - f.at[a]) * sensor->seen[a];
        f.near = depth < f.near ? depth : f.near;
        f.far = depth > f.far ? depth : f.far;
    }
    double least = 1e-3 * (f.far - f.near);
    if (f.near < least && !f.parallel) f.near = least; /* the camera stands in the box, or before it */
    if (!(f.far > f.near)) f.far = f.near + (least > 0.0 ? least : 1e-3);
    return f;
}

/* Middle of a cell, the way there, and the cell's edges. */
static void cell_of(const Frustum *f, int x, int y, int z, Real p[3], Real d[3], Real edges[3]) {
    const NphSensor *sensor = f->sensor;
    double depth = f->near + (f->far - f->near) * ((double)z + 0.5) / N, length = 0.0, way[3];
    double s = sensor->half_size[0] * (2.0 * ((double)x + 0.5) / N - 1.0), t = sensor->half_size[1] * (2.0 * ((double)y + 0.5) / N - 1.0);
    double wide = f->parallel ? 1.0 : depth;
    for (int a = 0; a < 3; a++) {
        double off = s * sensor->right[a] + t * sensor->up[a];
        way[a] = sensor->seen[a] + (f->parallel ? 0.0 : off);
        p[a] = (Real)(f->at[a] + depth * sensor->seen[a] + wide * off);
        length += way[a] * way[a];
    }
    length = nph_sqrt(length);
    for (int a = 0; a < 3; a++) d[a] = (Real)(way[a] / length);
    edges[0] = (Real)(2.0 * sensor->half_size[0] * wide / N);
    edges[1] = (Real)(2.0 * sensor->half_size[1] * wide / N);
    edges[2] = (Real)((f->far - f->near) * length / N);
}

/* Of all cells: importance under way and its mean cosine, before and after an iteration; factors for half a cell along each axis. */
typedef struct Flow {
    Real *light[2], *cosine[2], *keep, *bend; /* [cell]; [axis][cell] */
} Flow;

static int inside(int x, int y, int z) { return x >= 0 && y >= 0 && z >= 0 && x < N && y < N && z < N; }

static const int sides[6][3] = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}};

/* Part of the light of a cell for side k. */
static Real part_of(Real a, int k) {
    Real below = r_pop_below(R_POP_HALF, a), back = r_pop_below(-R_POP_HALF, a);
    return k == 0 ? R(1.0) - below : k == 1 ? back : R(0.25) * (below - back);
}

/* Gathers from six neighbours; what a cell at the border sends out is added to `lost` [side][cell], times its mean cosine to `bent`. */
static void iterate(Flow *f, int from, Real *lost, Real *bent) {
    for (int z = 0; z < N; z++)
        for (int y = 0; y < N; y++)
            for (int x = 0; x < N; x++) {
                int to = (z * N + y) * N + x;
                Real sum = R(0.0), turned = R(0.0);
                for (int k = 0; k < 6; k++) {
                    int axis = k < 2 ? 2 : k < 4 ? 0 : 1, i = x - sides[k][0], j = y - sides[k][1], l = z - sides[k][2];
                    if (!inside(x + sides[k][0], y + sides[k][1], z + sides[k][2])) {
                        Real leaves = f->light[from][to] * part_of(f->cosine[from][to], k) * f->keep[axis * CELLS + to];
                        lost[k * CELLS + to] += leaves;
                        bent[k * CELLS + to] += leaves * f->cosine[from][to];
                    }
                    if (!inside(i, j, l)) continue;
                    int at = (l * N + j) * N + i;
                    Real arrives = f->light[from][at] * part_of(f->cosine[from][at], k) * f->keep[axis * CELLS + at] * f->keep[axis * CELLS + to];
                    sum += arrives;
                    turned += arrives * f->cosine[from][at] * f->bend[axis * CELLS + at] * f->bend[axis * CELLS + to];
                }
                f->light[1 - from][to] = sum;
                f->cosine[1 - from][to] = sum > R(0.0) ? r_min(r_max(turned / r_max(sum, R(1e-37)), R(-1.0)), R(1.0)) : R(0.0);
            }
}

static void texel_way(int i, Real d[3]) {
    int row = i / NPH_POP_MAP_WIDTH, column = i % NPH_POP_MAP_WIDTH;
    double sine, cosine, middle, top;
    nph_sincos2pi(0.5 * ((double)row + 0.5) / NPH_POP_MAP_HEIGHT, &middle, &top);
    nph_sincos2pi(0.5 - ((double)column + 0.5) / NPH_POP_MAP_WIDTH, &sine, &cosine);
    d[0] = (Real)(middle * cosine);
    d[1] = (Real)(middle * sine);
    d[2] = (Real)top;
}

R_OUTLINE void add_lobe(const Real *restrict ways, const Real *restrict d, const Real *restrict n, Real a, Real amount, Real *restrict map) {
    for (int i = 0; i < TEXELS; i++) { /* vec */
        Real mu = ways[i] * d[0] + ways[TEXELS + i] * d[1] + ways[2 * TEXELS + i] * d[2];
        Real face = ways[i] * n[0] + ways[TEXELS + i] * n[1] + ways[2 * TEXELS + i] * n[2];
        map[i] += (face > R(0.0) ? amount : R(0.0)) * r_pop_lobe(a, r_min(r_max(mu, R(-1.0)), R(1.0)));
    }
}

static void add_lost(const RPopScene *scene, const Frustum *frustum, const Real *lost, const Real *bent, Real *map) {
    Real ways[3 * TEXELS];
    const NphSensor *sensor = &scene->local.sensor;
    for (int i = 0; i < TEXELS; i++) {
        Real d[3];
        texel_way(i, d);
        for (int a = 0; a < 3; a++) ways[a * TEXELS + i] = d[a];
        map[i] = R(0.0);
    }
    for (int k = 0; k < 6; k++)
        for (int i = 0; i < CELLS; i++) {
            Real p[3], d[3], n[3], edges[3], amount = lost[k * CELLS + i];
            if (!(amount > R(0.0))) continue;
            cell_of(frustum, i % N, i / N % N, i / N / N, p, d, edges);
            for (int a = 0; a < 3; a++)
                n[a] = (Real)((double)sides[k][0] * sensor->right[a] + (double)sides[k][1] * sensor->up[a] + (double)sides[k][2] * sensor->forward[a]);
            add_lobe(ways, d, n, bent[k * CELLS + i] / amount, amount, map);
        }
}

/* 1 2 1 along both axes; around the poles a row's neighbour is itself. */
static void smooth(const Real *map, Real *out) {
    for (int row = 0; row < NPH_POP_MAP_HEIGHT; row++)
        for (int column = 0; column < NPH_POP_MAP_WIDTH; column++) {
            Real sum = R(0.0);
            for (int j = -1; j <= 1; j++)
                for (int i = -1; i <= 1; i++) {
                    int y = row + j < 0 ? 0 : row + j >= NPH_POP_MAP_HEIGHT ? NPH_POP_MAP_HEIGHT - 1 : row + j;
                    int x = (column + i + NPH_POP_MAP_WIDTH) % NPH_POP_MAP_WIDTH;
                    sum += (i == 0 ? R(0.5) : R(0.25)) * (j == 0 ? R(0.5) : R(0.25)) * map[y * NPH_POP_MAP_WIDTH + x];
                }
            out[row * NPH_POP_MAP_WIDTH + column] = sum;
        }
}

/* What first scatters in a cell; half cells' factors. The extinction is that of the channels' mean. */
static void begin(const RPopScene *scene, const Frustum *frustum, const Real *medium, Flow *f) {
    const Real *m = scene->medium.from_local, third = R(0.33333333333333333);
    Real sigma_t = third * (scene->sigma_t[0] + scene->sigma_t[1] + scene->sigma_t[2]);
    Real sigma_s = third * (scene->sigma_s[0] + scene->sigma_s[1] + scene->sigma_s[2]), rate = R(1.0) - scene->g;
    if (scene->paper) rate = -r_log(r_max(r_abs(scene->g), R(1e-30)));
    for (int i = 0; i < N * N; i++) {
        Real T = R(1.0);
        for (int z = 0; z < N; z++) {
            Real p[3], d[3], edges[3], u[3], density = R(0.0);
            int at = z * N * N + i, within = 1;
            cell_of(frustum, i % N, i / N, z, p, d, edges);
            for (int a = 0; a < 3; a++) {
                u[a] = m[4 * a] * p[0] + m[4 * a + 1] * p[1] + m[4 * a + 2] * p[2] + m[4 * a + 3];
                within &= u[a] >= scene->medium.lo[a] && u[a] <= scene->medium.hi[a];
            }
            if (within) density = r_pop_density(scene, medium, u[0], u[1], u[2]);
            Real part = -r_expm1(-sigma_t * density * edges[2]);
            f->light[0][at] = T * part * (sigma_t > R(0.0) ? sigma_s / sigma_t : R(0.0));
            f->cosine[0][at] = scene->g;
            T *= R(1.0) - part;
            for (int a = 0; a < 3; a++) {
                f->keep[a * CELLS + at] = r_exp(R(-0.5) * (sigma_t - sigma_s) * density * edges[a]);
                f->bend[a * CELLS + at] = r_exp(R(-0.5) * rate * sigma_s * density * edges[a]);
            }
        }
    }
}

void NPH_KERNEL(nph_pop_importance)(const void *memory, const NphPopArrays *arrays, void *worker) {
    const RPopScene *scene = memory;
    Frustum frustum = frustum_of(scene);
    Real *lost = worker, *bent = lost + 6 * CELLS, map[TEXELS];
    Flow f;
    Real *at = bent + 6 * CELLS;
    for (int k = 0; k < 2; k++, at += 2 * CELLS) {
        f.light[k] = at;
        f.cosine[k] = at + CELLS;
    }
    f.keep = at;
    f.bend = at + 3 * CELLS;
    for (int i = 0; i < 12 * CELLS; i++) lost[i] = R(0.0);
    begin(scene, &frustum, arrays->medium, &f);
    for (int m = 0; m < 2 * N; m++) iterate(&f, m & 1, lost, bent);
    add_lost(scene, &frustum, lost, bent, map);
    smooth(map, arrays->importance);
}
