/* SPDX-License-Identifier: Apache-2.0
 *
 * Hexagonal prisms: light is kept, the projected area is a quarter of the surface, halos begin where prisms of 60 and 90 degrees
 * bend least, a flat plate lets straight through what Fresnel's formulas say, rough facets blur halos, and the numbers are the same
 * for any number of threads. */
#include "optics/crystal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "harness.h"
#include "optics/phase.h"

static const double PI = 3.14159265358979323846;

static NphCrystal column(int64_t rays) {
    return (NphCrystal){.length_um = 100, .edge_um = 50, .wavelength_um = 0.55, .index = {1.31, 0}, .rays = rays, .seed = 7};
}

static NphCrystalRays trace(NphContext *context, const NphCrystal *crystal) {
    NphCrystalRays rays;
    ck_assert_msg(nph_crystal_trace(context, crystal, "crystal", &rays) == NPH_OK, "%s", nph_test_messages());
    return rays;
}

static double sum_of(const NphCrystalRays *rays) {
    double sum = rays->straight + rays->absorbed + rays->lost;
    for (int i = 0; i < NPH_CRYSTAL_BINS; i++) sum += rays->bin[i];
    return sum;
}

START_TEST(light_is_kept_and_the_projected_area_is_a_quarter_of_the_surface) {
    static const double shapes[][4] = {{100, 50, 0, 0}, {20, 50, 0, 0}, {400, 40, 0, 1e-4}, {100, 50, 0.3, 0}, {60, 60, 0.7, 1e-3}};
    NphContext *context = nph_test_context(0);
    for (int i = 0; i < 5; i++) {
        NphCrystal crystal = column(40000);
        crystal.length_um = shapes[i][0];
        crystal.edge_um = shapes[i][1];
        crystal.tilt = shapes[i][2];
        crystal.index[1] = shapes[i][3];
        NphCrystalRays rays = trace(context, &crystal);
        double off = rays.projected_um2 - 0.25 * nph_crystal_surface_um2(&crystal);
        ck_assert_msg(fabs(sum_of(&rays) - 1) < 1e-10, "shape %d: sum - 1 = %g", i, sum_of(&rays) - 1);
        ck_assert_msg(fabs(off) < 4 * rays.projected_error_um2, "shape %d: area off by %g, standard error %g", i, off, rays.projected_error_um2);
        ck_assert_msg(rays.lost < 1e-4, "shape %d: %g lost", i, rays.lost);
        ck_assert((rays.absorbed > 1e-3) == (shapes[i][3] > 0) && (rays.straight > 0.05) == (shapes[i][2] == 0));
    }
    nph_test_context_close(context);
}
END_TEST

/* Minimum deviation of a prism: 2 asin(n sin(A / 2)) - A; 21.84 and 45.73 degrees for n = 1.31. */
START_TEST(halos_begin_where_prisms_bend_least) {
    NphContext *context = nph_test_context(0);
    for (int k = 0; k < 2; k++) {
        NphCrystal crystal = column(400000);
        crystal.index[0] = k ? 1.33 : 1.31;
        NphCrystalRays rays = trace(context, &crystal);
        for (int prism = 0; prism < 2; prism++) {
            double angle = prism ? PI / 2 : PI / 3, begins = (2 * asin(crystal.index[0] * sin(angle / 2)) - angle) * 180 / PI;
            int bin = (int)(begins * 4);
            double before = 0, after = 0;
            for (int i = 1; i <= 4; i++) {
                before += rays.bin[bin - i];
                after += rays.bin[bin + i];
            }
            printf("    n %g, %g degrees: %.3g of the light in the degree before, %.3g in the one behind\n", crystal.index[0], begins, before, after);
            ck_assert(after > (prism ? 2 : 10) * before);
            if (k == 0) ck_assert(fabs(begins - (prism ? 45.73 : 21.84)) < 0.01);
            int most = bin - 8;
            for (int i = bin - 8; i < bin + 20; i++) most = rays.bin[i] > rays.bin[most] ? i : most;
            ck_assert_msg(most >= bin && most <= bin + 2, "brightest at %g degrees", most / 4.0);
        }
    }
    nph_test_context_close(context);
}
END_TEST

/* Of a wide thin plate nearly all light passes the two caps: straight on leaves the mean over directions, weighted by their cosine,
 * of (1 - R) / (1 + R) for either polarisation, R Fresnel's. Of the caps' light; sides are 2 edge-lengths' part of the surface. */
START_TEST(a_wide_plate_transmits_as_fresnel_says) {
    enum { STEPS = 20000 };
    NphContext *context = nph_test_context(0);
    NphCrystal crystal = column(200000);
    crystal.edge_um = 100;
    crystal.length_um = 0.2;
    NphCrystalRays rays = trace(context, &crystal);
    double through = 0, n = crystal.index[0];
    for (int i = 0; i < STEPS; i++) {
        double c = (i + 0.5) / STEPS, r = sqrt(1 - (1 - c * c) / (n * n));
        double rs = pow((c - n * r) / (c + n * r), 2), rp = pow((n * c - r) / (n * c + r), 2);
        through += 2 * c / STEPS * 0.5 * ((1 - rs) / (1 + rs) + (1 - rp) / (1 + rp));
    }
    double error = 0.5 / sqrt((double)rays.hits), sides = 6 * crystal.length_um * crystal.edge_um / nph_crystal_surface_um2(&crystal);
    printf("    straight on: %.5f, by Fresnel's formulas %.5f; standard error at most %.5f, sides %.5f\n", rays.straight, through, error, sides);
    ck_assert(fabs(rays.straight - through) < 4 * error + 2 * sides);
    nph_test_context_close(context);
}
END_TEST

START_TEST(rough_facets_blur_the_halo) {
    NphContext *context = nph_test_context(0);
    double contrast[3];
    for (int k = 0; k < 3; k++) {
        NphCrystal crystal = column(200000);
        crystal.tilt = 0.3 * k;
        NphCrystalRays rays = trace(context, &crystal);
        double peak = 0, foot = 0;
        for (int i = 0; i < 8; i++) {
            peak += rays.bin[88 + i];
            foot += rays.bin[76 + i];
        }
        contrast[k] = peak / foot;
    }
    printf("    light from 22 to 24 degrees over that from 19 to 21: %.3g, %.3g, %.3g\n", contrast[0], contrast[1], contrast[2]);
    ck_assert(contrast[0] > 10 && contrast[1] < 1.5 && contrast[2] < 1.2);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_table_is_normalised_and_the_same_for_any_threads) {
    NphCrystal crystal = column(60000);
    NphCrystalTable first;
    NphContext *context = nph_test_context(1);
    ck_assert_int_eq(nph_crystal_table(context, &crystal, "crystal", &first), NPH_OK);
    for (int threads = 2; threads <= 5; threads += 3) {
        NphContext *other = nph_test_context(threads);
        NphCrystalTable table;
        ck_assert_int_eq(nph_crystal_table(other, &crystal, "crystal", &table), NPH_OK);
        ck_assert(memcmp(&table.rays, &first.rays, sizeof table.rays) == 0);
        ck_assert_int_eq(table.rows.shape[0], first.rows.shape[0]);
        ck_assert(memcmp(table.rows.data, first.rows.data, (size_t)first.rows.shape[0] * 16) == 0);
        nph_crystal_table_free(other, &table);
        nph_test_context_close(other);
    }
    crystal.seed = 8;
    NphCrystalRays rays = trace(context, &crystal);
    ck_assert(memcmp(&rays, &first.rays, sizeof rays) != 0);
    ck_assert(fabs(rays.mean_cosine - first.rays.mean_cosine) < 4 * hypot(rays.mean_cosine_error, first.rays.mean_cosine_error));
    NphPhase phase;
    ck_assert_int_eq(nph_phase_tabulate(context, &first.rows, "crystal", &phase), NPH_OK);
    ck_assert(fabs(nph_phase_mean_cosine(&phase) - first.asymmetry) < 1e-9);
    /* half of the light diffracted, mean cosine 1 but for some 1e-3; of the rest the rays' */
    ck_assert(fabs(first.asymmetry - 0.5 * (1 + first.rays.mean_cosine)) < 2e-3);
    nph_phase_free(context, &phase);
    nph_crystal_table_free(context, &first);
    nph_test_context_close(context);
}
END_TEST

START_TEST(what_is_out_of_range_is_named) {
    NphContext *context = nph_test_context(1);
    static const struct { double length, edge, tilt, n, k; int64_t rays; const char *words; } wrong[] = {
        {100, 0, 0, 1.31, 0, 10, "edge"}, {1e6, 1, 0, 1.31, 0, 10, "length"}, {100, 50, 1, 1.31, 0, 10, "tilt"},
        {100, 50, 0, 1, 0, 10, "above 1"}, {100, 50, 0, 1.31, 1, 10, "k of at most"}, {100, 50, 0, 1.31, 0, 0, "rays"}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        NphCrystal crystal = {wrong[i].length, wrong[i].edge, wrong[i].tilt, 0.55, {wrong[i].n, wrong[i].k}, wrong[i].rays, 1};
        NphCrystalRays rays;
        ck_assert_int_eq(nph_crystal_trace(context, &crystal, "crystal", &rays), NPH_BAD_INPUT);
        const char *said = nph_test_messages();
        ck_assert_msg(strstr(said, wrong[i].words) != NULL, "%zu: %s", i, said);
    }
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *tcase) {
    tcase_set_timeout(tcase, 300);
    tcase_add_test(tcase, light_is_kept_and_the_projected_area_is_a_quarter_of_the_surface);
    tcase_add_test(tcase, halos_begin_where_prisms_bend_least);
    tcase_add_test(tcase, a_wide_plate_transmits_as_fresnel_says);
    tcase_add_test(tcase, rough_facets_blur_the_halo);
    tcase_add_test(tcase, a_table_is_normalised_and_the_same_for_any_threads);
    tcase_add_test(tcase, what_is_out_of_range_is_named);
}

int main(void) { return nph_test_main("crystal", fill); }
