/* SPDX-License-Identifier: Apache-2.0
 *
 * Affine maps (row-major 3x4) and the few vector operations that scenes need. Only + - * / sqrt: the same bits
 * everywhere. */
#include <math.h>
#include <string.h>

#include "core/fmath.h"
#include "scene/model.h"

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
