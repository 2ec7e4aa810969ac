/* SPDX-License-Identifier: Apache-2.0
 *
 * Affine maps (row-major 3x4) and the few vector operations that scenes need. Only + - * / sqrt: the same bits
 * everywhere. */
#include <math.h>
#include <string.h>

#include "core/fmath.h"
#include "scene/scene_read.h"

void nph_affine_identity(double out[12]) {
    for (int i = 0; i < 12; i++) out[i] = i % 5 == 0;
}

void nph_affine_multiply(const double a[12], const double b[12], double out[12]) {
    double product[12];
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 4; column++)
            product[row * 4 + column] = a[row * 4] * b[column] + a[row * 4 + 1] * b[4 + column] +
                                        a[row * 4 + 2] * b[8 + column] + (column == 3 ? a[row * 4 + 3] : 0);
    memcpy(out, product, sizeof product);
}

/* Cofactors over the determinant. Singular: |det| at most 1e-12 of the product of the columns' lengths (1 for
 * perpendicular columns), or anything not finite. */
int nph_affine_invert(const double a[12], double out[12]) {
    double inverse[12], lengths = 1, cofactor[3][3];
    for (int i = 0; i < 3; i++) {
        int r1 = (i + 1) % 3, r2 = (i + 2) % 3;
        for (int j = 0; j < 3; j++) {
            int c1 = (j + 1) % 3, c2 = (j + 2) % 3;
            cofactor[i][j] = a[r1 * 4 + c1] * a[r2 * 4 + c2] - a[r1 * 4 + c2] * a[r2 * 4 + c1];
        }
        lengths *= nph_sqrt(a[i] * a[i] + a[4 + i] * a[4 + i] + a[8 + i] * a[8 + i]);
    }
    double determinant = a[0] * cofactor[0][0] + a[1] * cofactor[0][1] + a[2] * cofactor[0][2];
    if (!(determinant * determinant > 1e-24 * lengths * lengths) || !(lengths < HUGE_VAL)) return 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) inverse[i * 4 + j] = cofactor[j][i] / determinant;
    for (int i = 0; i < 3; i++)
        inverse[i * 4 + 3] = -(inverse[i * 4] * a[3] + inverse[i * 4 + 1] * a[7] + inverse[i * 4 + 2] * a[11]);
    for (int i = 0; i < 12; i++)
        if (!(inverse[i] < HUGE_VAL && inverse[i] > -HUGE_VAL)) return 0;
    memcpy(out, inverse, sizeof inverse);
    return 1;
}

/* Divided by the largest component first: neither end of the range of doubles is reached by the squares. */
int nph_vector_normalise(const double vector[3], double unit[3]) {
    double largest = 0, scaled[3];
    for (int i = 0; i < 3; i++) largest = nph_abs(vector[i]) > largest ? nph_abs(vector[i]) : largest;
    if (!(largest > 0)) return 0;
    for (int i = 0; i < 3; i++) scaled[i] = vector[i] / largest;
    double length = nph_sqrt(scaled[0] * scaled[0] + scaled[1] * scaled[1] + scaled[2] * scaled[2]);
    for (int i = 0; i < 3; i++) unit[i] = scaled[i] / length;
    return 1;
}

void nph_vector_cross(const double a[3], const double b[3], double out[3]) {
    double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
    out[0] = x;
    out[1] = y;
    out[2] = z;
}

static void grow(double lo[3], double hi[3], int axis, double value) {
    if (value < lo[axis]) lo[axis] = value;
    if (value > hi[axis]) hi[axis] = value;
}

static void grow_by_box(const double map[12], const double low[3], const double high[3], double lo[3], double hi[3]) {
    for (int corner = 0; corner < 8; corner++) {
        double x = corner & 1 ? high[0] : low[0], y = corner & 2 ? high[1] : low[1], z = corner & 4 ? high[2] : low[2];
        for (int axis = 0; axis < 3; axis++)
            grow(lo, hi, axis, map[axis * 4] * x + map[axis * 4 + 1] * y + map[axis * 4 + 2] * z + map[axis * 4 + 3]);
    }
}

void nph_medium_bounds(const NphMedium *medium, double lo[3], double hi[3]) {
    const double *map = medium->world_from_medium;
    const double *low = medium->shape == NPH_SHAPE_GRID ? medium->grid.lo : medium->lo;
    const double *high = medium->shape == NPH_SHAPE_GRID ? medium->grid.hi : medium->hi;
    for (int axis = 0; axis < 3; axis++) {
        lo[axis] = medium->shape == NPH_SHAPE_LAYER ? -HUGE_VAL : HUGE_VAL;
        hi[axis] = -lo[axis];
    }
    if (medium->shape == NPH_SHAPE_LAYER) {
        lo[2] = HUGE_VAL;
        hi[2] = -HUGE_VAL;
        grow(lo, hi, 2, map[10] * low[2] + map[11]);
        grow(lo, hi, 2, map[10] * high[2] + map[11]);
        return;
    }
    grow_by_box(map, low, high, lo, hi);
}

int nph_emission_bounds(const NphMedium *medium, double lo[3], double hi[3]) {
    const NphEmission *emission = &medium->emission;
    if (emission->kind != NPH_EMISSION_GRID) return 0;
    for (int axis = 0; axis < 3; axis++) {
        lo[axis] = HUGE_VAL;
        hi[axis] = -HUGE_VAL;
    }
    grow_by_box(emission->world_from_grid, emission->grids[0].lo, emission->grids[0].hi, lo, hi);
    return 1;
}

void nph_scene_bounds(const NphScene *scene, double lo[3], double hi[3]) {
    for (int axis = 0; axis < 3; axis++) {
        lo[axis] = HUGE_VAL;
        hi[axis] = -HUGE_VAL;
    }
    for (int m = 0; m < scene->medium_count; m++) {
        double low[3], high[3];
        nph_medium_bounds(&scene->media[m], low, high);
        for (int axis = scene->media[m].shape == NPH_SHAPE_LAYER ? 2 : 0; axis < 3; axis++) {
            grow(lo, hi, axis, low[axis]);
            grow(lo, hi, axis, high[axis]);
        }
        int emits = nph_emission_bounds(&scene->media[m], low, high);
        for (int axis = 0; axis < 3 && emits; axis++) {
            grow(lo, hi, axis, low[axis]);
            grow(lo, hi, axis, high[axis]);
        }
    }
    for (int s = 0; s < scene->surface_count; s++) {
        const NphSurface *surface = &scene->surfaces[s];
        if (surface->is_plane) grow(lo, hi, 2, surface->height_m);
        for (int64_t i = 0; i < 3 * (int64_t)surface->mesh.vertex_count; i++)
            grow(lo, hi, (int)(i % 3), surface->mesh.vertices_m[i]);
    }
}

void nph_scene_origin(const NphScene *scene, double origin[3]) {
    double lo[3], hi[3];
    nph_scene_bounds(scene, lo, hi);
    for (int axis = 0; axis < 3; axis++)
        origin[axis] = lo[axis] <= hi[axis] ? 0.5 * lo[axis] + 0.5 * hi[axis] : scene->sensor.position[axis];
    for (int axis = 0; axis < 2; axis++)
        if (scene->period.on[axis]) origin[axis] = 0.5 * scene->period.lo[axis] + 0.5 * scene->period.hi[axis];
}
