/* SPDX-License-Identifier: Apache-2.0
 *
 * Points on surfaces: rays that leave one do not meet it again, points lie where the bound says, normals; the plane;
 * chords of convex bodies; Lambert's directions. */
#include "kernel_bvh.h"
#include "shapes.h"

#define PI 3.14159265358979324

static const struct {
    double centre[3], size, spread;
} soups[] = {{{0, 0, 0}, 1, 1},
             {{1e5, -1e5, 2e5}, 1, 1e3},
             {{3, 2, 1}, 1e3, 1e6},
             {{0, 0, 0}, 1e-20, 10},
             {{1e9, 1e9, 1e9}, 1e6, 10}};

START_TEST(rays_that_leave_a_triangle_do_not_meet_it_again) {
    NphContext *context = nph_test_context(1);
    NphMesh mesh = soup(context, 21, 500, soups[_i].centre, soups[_i].size, soups[_i].spread);
    NphBvh bvh = bvh_of(context, &mesh, NULL);
    static const double grazing[3] = {0, 0.1, 1e-3};
    for (int g = 0; g < 3; g++) {
        ck_assert_int_eq(geometry_self_hits_f32_base(&bvh, 1, 100000, grazing[g], 1), 0);
        ck_assert_int_eq(geometry_self_hits_f64_base(&bvh, 1, 100000, grazing[g], 1), 0);
    }
    /* without the clearance many do: the test can fail */
    ck_assert_int_gt(geometry_self_hits_f32_base(&bvh, 1, 10000, 0, 0), 1000);
    ck_assert_int_gt(geometry_self_hits_f64_base(&bvh, 1, 10000, 0, 0), 1000);
    nph_bvh_free(context, &bvh);
    nph_mesh_free(context, &mesh);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_hit_point_lies_within_a_fraction_of_its_clearance_of_the_plane) {
    NphContext *context = nph_test_context(1);
    NphMesh mesh = soup(context, 22, 500, (double[]){100, -1000, 1e4}, 10, 1e3);
    NphBvh bvh = bvh_of(context, &mesh, NULL);
    Random random = {1, 0};
    for (int i = 0; i < 20000; i++) {
        int32_t slot = i % bvh.triangle_count;
        double u = sqrt(uniform(&random)), v = uniform(&random), out[7], e[3], f[3];
        geometry_point_f32_base(&bvh, slot, (double[]){u * v, u - u * v}, out);
        const float *c[3];
        for (int j = 0; j < 3; j++) c[j] = bvh.vertices_f32 + 3 * (int64_t)bvh.triangles[slot].corner[j];
        double n[3], length = 0, height = 0, turn = 0;
        for (int k = 0; k < 3; k++) {
            e[k] = (double)c[1][k] - c[0][k];
            f[k] = (double)c[2][k] - c[0][k];
        }
        for (int k = 0; k < 3; k++) n[k] = e[(k + 1) % 3] * f[(k + 2) % 3] - e[(k + 2) % 3] * f[(k + 1) % 3];
        for (int k = 0; k < 3; k++) length += n[k] * n[k];
        for (int k = 0; k < 3; k++) {
            height += n[k] / sqrt(length) * (out[k] - c[0][k]);
            turn += n[k] / sqrt(length) * out[3 + k];
        }
        ck_assert(fabs(height) < 0.4 * out[6] && fabs(turn - 1) < 1e-6);
        ck_assert(out[6] < 1e4 * 4.1 * 0x1p-24 * 1.1 +
                               10 * 2 * 64 * 0x1p-24 * 2); /* and the clearance is no more than it says */
    }
    nph_bvh_free(context, &bvh);
    nph_mesh_free(context, &mesh);
    nph_test_context_close(context);
}
END_TEST

START_TEST(corners_on_a_line_get_a_unit_normal_across_it) {
    NphContext *context = nph_test_context(1);
    static const double lines[4][3] = {{1, 0, 0}, {0, -1e-20, 0}, {1e10, 1e10, 0}, {1, 2, 3}};
    for (int i = 0; i < 4; i++) {
        double v[9] = {0}, out[7], dot = 0, length = 0;
        for (int k = 0; k < 3; k++) {
            v[3 + k] = lines[i][k];
            v[6 + k] = 2 * lines[i][k];
        }
        NphMesh mesh = mesh_of(context, v, 3, (int32_t[]){0, 1, 2}, 1);
        NphBvh bvh = bvh_of(context, &mesh, NULL);
        geometry_point_f64_base(&bvh, 0, (double[]){0.25, 0.25}, out);
        for (int k = 0; k < 3; k++) {
            dot += out[3 + k] * lines[i][k];
            length += out[3 + k] * out[3 + k];
        }
        ck_assert(fabs(length - 1) < 1e-14 && fabs(dot) < 1e-15 * fabs(lines[i][0] + lines[i][1] + lines[i][2]));
        nph_bvh_free(context, &bvh);
        nph_mesh_free(context, &mesh);
    }
    nph_test_context_close(context);
}
END_TEST

/* The mean chord of a convex body, chords entering uniformly over the surface with density cos / pi, is 4 V / S. */
START_TEST(mean_chord_of_convex_bodies_is_4_V_by_S) {
    NphContext *context = nph_test_context(1);
    enum { CHORDS = 200000 };
    NphMesh bodies[3] = {ball(context, 2, (double[]){0, 0, 0}, (double[]){1, 1, 1}, 0),
                         ball(context, 1, (double[]){30, -20, 10}, (double[]){1, 2, 4}, 0),
                         box(context, (double[]){0, 0, 0}, (double[]){1, 2, 5})};
    for (int b = 0; b < 3; b++) {
        NphBvh bvh = bvh_of(context, &bodies[b], NULL);
        double *cdf = malloc((size_t)bodies[b].triangle_count * sizeof *cdf), sum = 0, out[3];
        double expected = 4 * nph_mesh_volume(&bodies[b]) / bodies[b].area_m2;
        for (int32_t t = 0; t < bodies[b].triangle_count; t++)
            cdf[t] = (sum += bodies[b].areas_m2[t]) / bodies[b].area_m2;
        cdf[bodies[b].triangle_count - 1] = 1;
        for (int single = 0; single < 2; single++) {
            (single ? geometry_chords_f32_base : geometry_chords_f64_base)(&bvh, cdf, 5 + (uint32_t)single, CHORDS,
                                                                           out);
            ck_assert(out[0] == CHORDS);
            double mean = out[1] / CHORDS, error = sqrt((out[2] / CHORDS - mean * mean) / (CHORDS - 1));
            ck_assert_msg(fabs(mean - expected) < 3.5 * error && error < 0.003 * expected,
                          "body %d: mean %.6f, 4V/S %.6f, standard error %.6f", b, mean, expected, error);
        }
        free(cdf);
        nph_bvh_free(context, &bvh);
        nph_mesh_free(context, &bodies[b]);
    }
    nph_test_context_close(context);
}
END_TEST

START_TEST(the_plane_is_met_where_it_lies_and_left_for_good) {
    static const double planes[4][6] = {
        {0, 0, 0, 0, 0, 1}, {5, 6, -1000, 0, 0, 2}, {1, 2, 3, 1, 1, 1}, {1e5, 0, 0, 0.3, -0.4, 0.1}};
    Random random = {17, 0};
    for (int p = 0; p < 4; p++)
        for (int i = 0; i < 200; i++) {
            double ray[6], height = 0, rise = 0, length = 0, size = 0;
            random_direction(&random, ray + 3);
            for (int k = 0; k < 3; k++) {
                ray[k] =
                    (float)(planes[p][k] + 1e4 * (2 * uniform(&random) - 1)); /* floats: equal in both precisions */
                ray[3 + k] = (float)ray[3 + k];
                height += planes[p][3 + k] * (ray[k] - planes[p][k]);
                rise += planes[p][3 + k] * ray[3 + k];
                length += planes[p][3 + k] * planes[p][3 + k];
                size += fabs(ray[k]) + fabs(planes[p][k]);
            }
            double t = -height / rise, bound = 20 * size / fabs(rise / sqrt(length));
            double got = geometry_plane_f64_base(planes[p], ray, 1e30),
                   single = geometry_plane_f32_base(planes[p], ray, 1e30);
            ck_assert((got < 0) == (t < 0) && (single < 0) == (t < 0));
            if (t < 0) continue;
            ck_assert(fabs(got - t) < 0x1p-53 * bound && fabs(single - t) < 0x1p-24 * bound * (1 + t / size));
            ck_assert(geometry_plane_f64_base(planes[p], ray, 0.99 * t) == -1);
            ck_assert_int_eq(geometry_plane_self_hits_f32_base(planes[p], ray, 2, 500), 0);
            ck_assert_int_eq(geometry_plane_self_hits_f64_base(planes[p], ray, 2, 500), 0);
        }
    static const double level[6] = {0, 0, 0, 0, 0, 1};
    ck_assert(geometry_plane_f32_base(level, (double[]){0, 0, 5, 1, 0, 0}, 1e30) == -1); /* parallel */
    ck_assert(geometry_plane_f32_base(level, (double[]){0, 0, 0, 0, 0, -1}, 1e30) == -1);  /* starts in it */
    ck_assert(geometry_plane_f32_base(level, (double[]){0, 0, 5, 0, 0, -2}, 2.5) == 2.5);
}
END_TEST

/* 16 bins of the cosine by 16 of the azimuth against the integral of the density: chi-square of 255 degrees, mean 255,
 * standard deviation 22.6; bounds at 4 of them. */
START_TEST(directions_about_a_normal_have_the_density_cos_by_pi) {
    static const double normals[5][3] = {{0, 0, 1}, {0, 0, -1}, {0.6, 0, 0.8}, {-0.48, 0.64, -0.6}, {1, 0, 0}};
    enum { DRAWS = 200000, BINS = 16 };
    double *d = malloc(DRAWS * 3 * sizeof *d), *density = malloc(DRAWS * sizeof *density);
    for (int i = 0; i < 10; i++) {
        const double *n = normals[i / 2];
        double tolerance = i % 2 ? 1e-6 : 1e-14, chi = 0;
        int least = fabs(n[0]) < 0.5 ? 0 : 1, counts[BINS][BINS] = {{0}};
        double x[3] = {0, 0, 0}, y[3], length = sqrt(1 - n[least] * n[least]);
        for (int k = 0; k < 3; k++) x[k] = ((k == least) - n[least] * n[k]) / length;
        for (int k = 0; k < 3; k++) y[k] = n[(k + 1) % 3] * x[(k + 2) % 3] - n[(k + 2) % 3] * x[(k + 1) % 3];
        (i % 2 ? geometry_lambert_f32_base : geometry_lambert_f64_base)(n, 3 + (uint32_t)i, DRAWS, d, density);
        for (int64_t j = 0; j < DRAWS; j++) {
            double c = 0, a = 0, b = 0, square = 0;
            for (int k = 0; k < 3; k++) {
                c += n[k] * d[3 * j + k];
                a += x[k] * d[3 * j + k];
                b += y[k] * d[3 * j + k];
                square += d[3 * j + k] * d[3 * j + k];
            }
            if (!(c > 0 && fabs(square - 1) < tolerance && fabs(density[j] * PI - c) < tolerance))
                ck_abort_msg("draw %d", (int)j);
            int bin = (int)(c * BINS), turn = (int)((atan2(b, a) / (2 * PI) + 0.5) * BINS);
            counts[bin < BINS ? bin : BINS - 1][turn < BINS ? turn : BINS - 1]++;
        }
        for (int bin = 0; bin < BINS * BINS; bin++) {
            int row = bin / BINS; /* integral of cos / pi 2 pi d cos, a BINS-th of the azimuth */
            double expected = DRAWS * (2.0 * row + 1) / (BINS * BINS) / BINS, miss = counts[row][bin % BINS] - expected;
            chi += miss * miss / expected;
        }
        ck_assert_msg(chi > 255 - 4 * 22.6 && chi < 255 + 4 * 22.6, "normal %d, f%d: chi-square %.1f", i / 2,
                      i % 2 ? 32 : 64, chi);
    }
    free(d);
    free(density);
}
END_TEST

static void fill(TCase *tcase) {
    tcase_add_loop_test(tcase, rays_that_leave_a_triangle_do_not_meet_it_again, 0, sizeof soups / sizeof soups[0]);
    tcase_add_test(tcase, a_hit_point_lies_within_a_fraction_of_its_clearance_of_the_plane);
    tcase_add_test(tcase, corners_on_a_line_get_a_unit_normal_across_it);
    tcase_add_test(tcase, mean_chord_of_convex_bodies_is_4_V_by_S);
    tcase_add_test(tcase, the_plane_is_met_where_it_lies_and_left_for_good);
    tcase_add_test(tcase, directions_about_a_normal_have_the_density_cos_by_pi);
}

int main(void) { return nph_test_main("surface", fill); }
