/* SPDX-License-Identifier: Apache-2.0
 *
 * What the kernels see, in the number type of the build. Grids are made of their ordinate: those of directions fill the box that the
 * medium's has along their axes; those of points are shells around the point, cut by an octahedral map [Praun03]. Cells of all of
 * them lie [z][y][x], z along the light. */
#ifndef NPH_METHOD_POP_STATE_H
#define NPH_METHOD_POP_STATE_H

#include "method/principal_ordinates/pop.h"
#include "transport/camera_lookup.h"
#include "transport/lights_lookup.h"

#define R_POP_HALF R(0.70710678118654752)   /* cosine of a quarter of pi [Elek14 eq. 3] */
#define R_POP_FOUR_PI R(12.566370614359173)

typedef struct RPopBox {
    int32_t n[3];
    Real lo[3], edge[3], per[3]; /* along the medium's sides, in its space: low corner, cells */
    Real metres[3];              /* edges of a cell */
} RPopBox;

typedef struct RPopScene {
    RScene local;
    RMedium medium;
    NphPopChoice choice;
    int paper, paths, upsampling, regions, prefilter;
    Real g, sigma_t[3], sigma_s[3], sigma_a[3]; /* per unit of density, 1/m */
    Real epsilon_a, epsilon_l, beta, inner, clamp, exit, step, narrow; /* narrow: 1 / the Gaussian's width in density over the largest */
    Real beam;                   /* longest step of shadow rays through the medium, m */
    Real density_max;
    Real per_level, level_shift; /* lattice to cells of the mips */
    double corner[8][3], side[3][3], middle[3], metres[3]; /* of the medium's box: scene-local; metres per unit of its space */
    double radius, around;       /* of it; within how far of its middle all meshes lie, m */
    Real local_from[12];         /* scene-local from medium space */
    RPopBox joined, gathered, merged, fine;
} RPopScene;

/* A grid. */
typedef struct RPopGrid {
    int radial;
    int32_t n[3];
    Real axis[3][3];           /* of directions: across, across, along; unit vectors, scene-local */
    Real middle[3];            /* what places are counted from: the box's middle, or the point */
    Real low[3], edge[3];      /* of directions: low corner along the axes, edges, m */
    Real inner, log_ratio;     /* of points: radius of the innermost shell's inside, logarithm of outer over inner of a shell */
    Real core, per_solid;      /* how much of that radius lies in the medium's box; 1 / the mean solid angle of cells */
    int lambert;               /* what leaves falls with the cosine to this normal: a virtual point light */
    Real normal[3];
    Real cone, side[2];        /* cosine of the cone to the next cell; part of the light between the cones for each side along x, y */
} RPopGrid;

R_INLINE Real r_pop_dot(const Real a[3], const Real b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* 2 pi F_hg(mu, a), the part of the light of mean cosine a at cosines below mu [Elek14 eq. 1], without its singularity at a = 0:
 * with D^2 = (1 - a)^2 + 2 a (1 - mu) and (1 + a)^2 - D^2 = 2 a (1 + mu),
 *   ((1 - a^2) / 2 a) (1 / D - 1 / (1 + a)) = (1 - a) (1 + mu) / (D (1 + a + D)). */
R_INLINE Real r_pop_below(Real mu, Real a) {
    Real away = R(1.0) - a, d = r_sqrt(r_max(away * away + R(2.0) * a * (R(1.0) - mu), R(1e-30)));
    return away * (R(1.0) + mu) / (d * (R(1.0) + a + d));
}

R_INLINE Real r_pop_lobe(Real a, Real cosine) {
    RAngle angle = {cosine, R(1.0) - cosine, R(1.0) + cosine};
    return r_hg_value(a, r_max(R(1.0) - r_abs(a), R(1e-6)), angle);
}

/* Octahedral map: a direction's place in [-1, 1]^2, and back. */
R_INLINE void r_octahedron(Real x, Real y, Real z, Real *u, Real *v) {
    Real inverse = R(1.0) / (r_abs(x) + r_abs(y) + r_abs(z));
    Real a = x * inverse, b = y * inverse;
    Real over_a = (R(1.0) - r_abs(b)) * (a < R(0.0) ? R(-1.0) : R(1.0)), over_b = (R(1.0) - r_abs(a)) * (b < R(0.0) ? R(-1.0) : R(1.0));
    *u = z < R(0.0) ? over_a : a;
    *v = z < R(0.0) ? over_b : b;
}

R_INLINE void r_octahedron_way(Real u, Real v, Real d[3]) {
    Real z = R(1.0) - r_abs(u) - r_abs(v), x = u, y = v;
    if (z < R(0.0)) {
        x = (R(1.0) - r_abs(v)) * (u < R(0.0) ? R(-1.0) : R(1.0));
        y = (R(1.0) - r_abs(u)) * (v < R(0.0) ? R(-1.0) : R(1.0));
    }
    Real inverse = R(1.0) / r_sqrt(x * x + y * y + z * z);
    d[0] = x * inverse;
    d[1] = y * inverse;
    d[2] = z * inverse;
}

/* Solid angle of a cell of the map in the middle's density: area (2 / n)^2 over |p|^3, p on the octahedron. Cells differ by 5. */
R_INLINE Real r_octahedron_solid(Real u, Real v, int32_t n) {
    Real z = R(1.0) - r_abs(u) - r_abs(v), x = u, y = v;
    if (z < R(0.0)) {
        x = R(1.0) - r_abs(v);
        y = R(1.0) - r_abs(u);
    }
    Real square = x * x + y * y + z * z, edge = R(2.0) / (Real)n;
    return edge * edge / (square * r_sqrt(square));
}

/* Radius of the inside of a shell. */
R_INLINE Real r_pop_radius(const RPopGrid *grid, Real shell) { return grid->inner * r_exp(shell * grid->log_ratio); }

/* Middle of a cell, scene-local, and the way of the light there. */
R_INLINE void r_pop_cell(const RPopGrid *grid, int32_t x, int32_t y, int32_t z, Real p[3], Real d[3]) {
    Real at[3] = {(Real)x + R(0.5), (Real)y + R(0.5), (Real)z + R(0.5)};
    if (grid->radial) {
        Real r = r_pop_radius(grid, at[2]);
        r_octahedron_way(R(2.0) * at[0] / (Real)grid->n[0] - R(1.0), R(2.0) * at[1] / (Real)grid->n[1] - R(1.0), d);
        for (int a = 0; a < 3; a++) p[a] = grid->middle[a] + r * d[a];
        return;
    }
    for (int a = 0; a < 3; a++) at[a] = grid->low[a] + at[a] * grid->edge[a];
    for (int a = 0; a < 3; a++) {
        p[a] = grid->middle[a] + at[0] * grid->axis[0][a] + at[1] * grid->axis[1][a] + at[2] * grid->axis[2][a];
        d[a] = grid->axis[2][a];
    }
}

/* Shells around a point, from the nearest place of the medium's box, or from a part of the farthest's distance, to the farthest. */
static inline void r_pop_radial_grid(const RPopScene *scene, const Real *row, RPopGrid *grid) {
    double place[3] = {(double)row[NPH_POP_WAY], (double)row[NPH_POP_WAY + 1], (double)row[NPH_POP_WAY + 2]};
    double near = 0.0, far = 0.0, solid = 0.0;
    for (int k = 0; k < 8; k++) {
        double square = 0.0;
        for (int a = 0; a < 3; a++) square += (scene->corner[k][a] - place[a]) * (scene->corner[k][a] - place[a]);
        far = square > far ? square : far;
    }
    for (int a = 0; a < 3; a++) { /* along the sides of the box */
        double at = 0.0, half = 0.0;
        for (int b = 0; b < 3; b++) at += (place[b] - scene->middle[b]) * scene->side[a][b];
        for (int b = 0; b < 3; b++) half += 0.5 * (scene->corner[1 << a][b] - scene->corner[0][b]) * scene->side[a][b];
        double off = nph_abs(at) > half ? nph_abs(at) - half : 0.0;
        near += off * off;
        grid->middle[a] = (Real)place[a];
    }
    far = nph_sqrt(far) * 1.0001;
    near = nph_sqrt(near) * 0.9999;
    double inner = near > (double)scene->inner * far ? near : (double)scene->inner * far;
    double disc = nph_sqrt((double)scene->clamp * (double)row[NPH_POP_AREA] * 0.31830988618379067); /* of the area's size: clamped */
    disc = disc < 0.5 * far ? disc : 0.5 * far;
    inner = disc > inner ? disc : inner;
    grid->inner = (Real)inner;
    grid->core = (Real)(near < inner ? inner - near : 0.0);
    grid->log_ratio = (Real)(nph_log(far / inner) / (double)grid->n[2]);
    for (int32_t y = 0; y < grid->n[1]; y++)
        for (int32_t x = 0; x < grid->n[0]; x++) {
            Real u = R(2.0) * ((Real)x + R(0.5)) / (Real)grid->n[0] - R(1.0), v = R(2.0) * ((Real)y + R(0.5)) / (Real)grid->n[1] - R(1.0);
            solid += (double)r_octahedron_solid(u, v, grid->n[0]);
        }
    grid->per_solid = (Real)((double)grid->n[0] * (double)grid->n[1] / solid);
}

/* Along the way of the light; across, one axis lies near to that side of the medium which is most across. */
static inline void r_pop_axes(const RPopScene *scene, const double way[3], double axis[3][3]) {
    double best = 2.0, length = 0.0;
    int across = 0;
    for (int s = 0; s < 3; s++) {
        double along = nph_abs(scene->side[s][0] * way[0] + scene->side[s][1] * way[1] + scene->side[s][2] * way[2]);
        if (along < best - 1e-6) {
            best = along;
            across = s;
        }
    }
    double along = scene->side[across][0] * way[0] + scene->side[across][1] * way[1] + scene->side[across][2] * way[2];
    for (int a = 0; a < 3; a++) {
        axis[2][a] = way[a];
        axis[0][a] = scene->side[across][a] - along * way[a];
        length += axis[0][a] * axis[0][a];
    }
    for (int a = 0; a < 3; a++) axis[0][a] /= nph_sqrt(length);
    nph_vector_cross(axis[2], axis[0], axis[1]);
}

/* The box that the medium's has along those axes. */
static inline void r_pop_flat_grid(const RPopScene *scene, const Real *row, RPopGrid *grid) {
    double axis[3][3], edge[3], way[3] = {(double)row[NPH_POP_WAY], (double)row[NPH_POP_WAY + 1], (double)row[NPH_POP_WAY + 2]};
    r_pop_axes(scene, way, axis);
    for (int b = 0; b < 3; b++) {
        double lo = 1e300, hi = -1e300;
        for (int k = 0; k < 8; k++) {
            double at = 0.0;
            for (int a = 0; a < 3; a++) at += (scene->corner[k][a] - scene->middle[a]) * axis[b][a];
            lo = at < lo ? at : lo;
            hi = at > hi ? at : hi;
        }
        edge[b] = (hi - lo) / (double)grid->n[b];
        grid->middle[b] = (Real)scene->middle[b];
        grid->low[b] = (Real)lo;
        grid->edge[b] = (Real)edge[b];
        for (int a = 0; a < 3; a++) grid->axis[b][a] = (Real)axis[b][a];
    }
    if (scene->paper) return;
    /* of cells that are no cubes: the cone that the next one fills, and what those beside it share */
    double turn = nph_acos(edge[0] / nph_sqrt(edge[0] * edge[0] + edge[1] * edge[1])) * 0.31830988618379067; /* half the angle of an x face, over pi */
    grid->cone = (Real)(edge[2] / nph_sqrt(edge[2] * edge[2] + edge[0] * edge[1]));
    grid->side[0] = (Real)turn;
    grid->side[1] = (Real)(0.5 - turn);
}

/* From the ordinate's row. Pure arithmetic: whoever has the row has the grid. */
static inline RPopGrid r_pop_grid(const RPopScene *scene, const Real *row, int number) {
    const NphPopChoice *choice = &scene->choice;
    RPopGrid grid = {.radial = number >= choice->suns + choice->sky, .cone = R_POP_HALF, .side = {R(0.25), R(0.25)}};
    const int32_t *n = nph_pop_shape(choice, number);
    grid.lambert = number >= nph_pop_lamps(choice);
    for (int a = 0; a < 3; a++) {
        grid.n[a] = n[a];
        grid.normal[a] = row[NPH_POP_NORMAL + a];
    }
    (grid.radial ? r_pop_radial_grid : r_pop_flat_grid)(scene, row, &grid);
    return grid;
}

/* Of a cell of a box along the medium. */
R_INLINE void r_pop_middle(const RPopScene *scene, const RPopBox *box, int32_t x, int32_t y, int32_t z, Real p[3]) {
    const Real *m = scene->local_from;
    Real u = box->lo[0] + ((Real)x + R(0.5)) * box->edge[0], v = box->lo[1] + ((Real)y + R(0.5)) * box->edge[1];
    Real w = box->lo[2] + ((Real)z + R(0.5)) * box->edge[2];
    for (int a = 0; a < 3; a++) p[a] = m[4 * a] * u + m[4 * a + 1] * v + m[4 * a + 2] * w + m[4 * a + 3];
}

/* A place in a radial grid, in cells from the middle of the first one: not below 0, not above the last. */
R_INLINE void r_pop_find_radial(const RPopGrid *grid, Real x, Real y, Real z, Real at[3]) {
    Real p[3] = {x - grid->middle[0], y - grid->middle[1], z - grid->middle[2]};
    Real r = r_sqrt(r_max(p[0] * p[0] + p[1] * p[1] + p[2] * p[2], R(1e-30))), u, v;
    r_octahedron(p[0], p[1], p[2] + R(1e-18), &u, &v);
    at[0] = R(0.5) * (u + R(1.0)) * (Real)grid->n[0];
    at[1] = R(0.5) * (v + R(1.0)) * (Real)grid->n[1];
    at[2] = r_log(r_max(r / grid->inner, R(1e-30))) / grid->log_ratio;
    for (int b = 0; b < 3; b++) at[b] = r_min(r_max(at[b] - R(0.5), R(0.0)), (Real)(grid->n[b] - 1));
}

#endif
