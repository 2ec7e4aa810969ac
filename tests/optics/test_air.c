/* SPDX-License-Identifier: Apache-2.0
 *
 * The air: closed forms on both sides of what is removable in them, the table against quadrature, quadrature against a
 * plain sum, and all of it against published numbers. */
#include "optics/air.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "harness.h"
#include "io/air_rows.h"

static const double DEGREE = 0.017453292519943295, EARTH_M = 6371000.0, HEIGHT_M = 8000.0;

static double relative(double value, double truth) { return fabs(value - truth) / fabs(truth); }

/* ---- extinction ---- */

/* Cross-section of [Bucholtz95 eq. 8, table 3], times the same number of molecules: another fit to another calculation. */
static double bucholtz_per_m(double nm) {
    double um = nm * 1e-3;
    double cm2 = nm <= 500.0 ? 3.01577e-28 * pow(um, -(3.55212 + 1.35579 * um + 0.11563 / um))
                             : 4.01061e-28 * pow(um, -(3.99668 + 1.10298e-3 * um + 2.71393e-2 / um));
    return cm2 * 1e-4 * 2.546899e25;
}

START_TEST(rayleighs_extinction_is_that_of_two_published_fits_and_below_the_papers) {
    static const double riley[3][2] = {{680, 5.8e-6}, {550, 1.35e-5}, {440, 3.31e-5}}; /* [Riley04 table 3] */
    double worst = 0.0;
    for (double nm = 360.0; nm <= 830.0; nm += 5.0) worst = fmax(worst, relative(nph_rayleigh_per_m(nm), bucholtz_per_m(nm)));
    printf("    from 360 to 830 nm off by at most %.2g of Bucholtz's\n", worst);
    ck_assert(worst < 0.005);
    for (int c = 0; c < 3; c++) {
        double ours = nph_rayleigh_per_m(riley[c][0]);
        printf("    %g nm: %.4g 1/m, in print %.4g, %.0f%% more\n", riley[c][0], ours, riley[c][1], 100 * (riley[c][1] / ours - 1));
        ck_assert(riley[c][1] / ours > 1.1 && riley[c][1] / ours < 1.25);
    }
}
END_TEST

/* ---- flat ---- */

/* Simpson's rule of exp(-h / H) along the way. */
static double column_by_sum(double from, double to, double distance) {
    enum { STEPS = 2000 };
    double sum = 0.0;
    for (int i = 0; i <= STEPS; i++) {
        double weight = i == 0 || i == STEPS ? 1 : i % 2 ? 4 : 2;
        sum += weight * exp(-(from + (to - from) * i / STEPS) / HEIGHT_M);
    }
    return sum * distance / (3 * STEPS);
}

START_TEST(flat_columns_are_the_integral_of_the_density) {
    double worst = 0.0;
    for (int k = 0; k < 400; k++) {
        double from = fmod(k * 977.0, 9000.0), to = fmod(k * 3571.0, 30000.0), distance = fabs(to - from) * (1 + k % 7) + 10.0;
        double column = nph_air_column_between(HEIGHT_M, from, to, distance);
        ck_assert(column == nph_air_column_between(HEIGHT_M, to, from, distance));
        worst = fmax(worst, relative(column, column_by_sum(from, to, distance)));
    }
    printf("    largest relative difference %.2g\n", worst);
    ck_assert(worst < 1e-11); /* Simpson's own: (30000 / 8000 / 2000)^4 / 180 = 7e-14, and 2000 roundings */
}
END_TEST

/* On both sides of the switch, which is x = 0 alone, and from there to the largest numbers. (1 - e^-x) / x is taken from the
 * series 1 - x/2 + x^2/6 - x^3/24, whose next term is below 1e-18 for x <= 1e-4. */
START_TEST(level_ways_are_the_limit_of_inclined_ones) {
    static const double rises[] = {0.0, 4.9406564584124654e-324, DBL_MIN, 1e-300, 1e-30, 1e-17, 1e-16, 1e-15, 1e-9, 1e-5, 1e-4};
    for (size_t i = 0; i < sizeof rises / sizeof rises[0]; i++)
        for (int down = 0; down < 2; down++) {
            double x = rises[i], mean = 1 - x / 2 * (1 - x / 3 * (1 - x / 4));
            double column = nph_air_column_between(1.0, down ? x : 0.0, down ? 0.0 : x, 5.0);
            ck_assert_msg(relative(column, 5.0 * mean) < 4e-16, "x = %g: %.17g", x, column);
        }
    ck_assert(nph_air_column_between(HEIGHT_M, 1e300, 0.0, 7.0) == 7.0 * (HEIGHT_M / 1e300));
    ck_assert(nph_air_column_between(HEIGHT_M, 1e300, 1e300, 7.0) == 0.0);
    ck_assert(nph_air_column_between(HEIGHT_M, 100.0, 200.0, 0.0) == 0.0);
}
END_TEST

START_TEST(a_flat_atmosphere_ends_above_and_has_no_light_at_or_below_the_horizon) {
    for (double sine = 1.0; sine > 1e-3; sine *= 0.7) {
        double far = nph_air_column_between(HEIGHT_M, 500.0, 500.0 + 45 * HEIGHT_M, 45 * HEIGHT_M / sine);
        ck_assert(relative(nph_air_column_above(HEIGHT_M, 500.0, sine), far) < 1e-14);
    }
    static const double dark[] = {0.0, -0.0, -1e-300, -0.5, -1.0};
    for (int i = 0; i < 5; i++) {
        ck_assert(isinf(nph_air_column_above(HEIGHT_M, 500.0, dark[i])));
        ck_assert(nph_air_transmittance(1e-5, nph_air_column_above(HEIGHT_M, 500.0, dark[i])) == 0.0);
        ck_assert(nph_air_transmittance(0.0, nph_air_column_above(HEIGHT_M, 500.0, dark[i])) == 0.0);
    }
    ck_assert(nph_air_transmittance(1e-5, nph_air_column_above(HEIGHT_M, 0.0, 1e-300)) == 0.0);
    ck_assert(nph_air_transmittance(0.0, nph_air_column_above(HEIGHT_M, 0.0, 1e-3)) == 1.0);
}
END_TEST

/* [Riley04 eq. 14] without its phase function, by Simpson's rule over our columns: the two values of its integral that hold
 * for the exact solution, and not for eq. 15 as printed. */
static double light_of_sight(double rise, double sun, double eye_m, double length) {
    enum { STEPS = 20000 };
    double sum = 0.0, beta = 3.31e-5;
    for (int i = 0; i <= STEPS; i++) {
        double way = length * i / STEPS, height = eye_m + rise * way, weight = i == 0 || i == STEPS ? 1 : i % 2 ? 4 : 2;
        double column = nph_air_column_between(HEIGHT_M, eye_m, height, way) + nph_air_column_above(HEIGHT_M, height, sun);
        sum += weight * beta * exp(-height / HEIGHT_M) * nph_air_transmittance(beta, column);
    }
    return sum * length / (3 * STEPS);
}

START_TEST(the_sky_along_a_line_of_sight_has_the_value_of_exact_integration) {
    double first = light_of_sight(0.5, 0.8, 0.0, 1e5), second = light_of_sight(0.9, 0.3, 1000.0, 2e4);
    printf("    %.7f %.7f\n", first, second);
    ck_assert(fabs(first - 0.344370) < 6e-7 && fabs(second - 0.135676) < 6e-7);
}
END_TEST

/* ---- spherical ---- */

static NphAirProfile exponential(NphContext *context, double scale_height, double radius) {
    NphAirProfile profile;
    ck_assert_int_eq(nph_air_profile_exponential(context, scale_height, radius, &profile), NPH_OK);
    return profile;
}

static NphAirProfile us_standard(NphContext *context) {
    NphAirProfile profile;
    NphArray rows;
    ck_assert_msg(nph_air_rows_read(context, nph_test_path("reference/data/gpl/afglus.dat"), &rows) == NPH_OK, "%s",
                  nph_test_messages());
    ck_assert_int_eq(nph_air_profile_from_rows(context, &rows, EARTH_M, &profile), NPH_OK);
    nph_array_free(context, &rows);
    return profile;
}

/* Midpoints of equal steps along the way, in the plainest form; rising ways end where a 1e-13th of the air is left. */
static double plain_sum(const NphAirProfile *profile, double height, double sine, double end, int steps) {
    double sum = 0.0, r = profile->radius_m + height;
    for (int i = 0; i < steps; i++) {
        double s = end * (i + 0.5) / steps, at = sqrt(r * r + s * s + 2 * r * s * sine) - profile->radius_m;
        sum += nph_air_density(profile, at);
    }
    return sum * end / steps;
}

START_TEST(quadrature_is_the_plain_sum_over_the_way) {
    NphContext *context = nph_test_context(1);
    NphAirProfile profile = exponential(context, HEIGHT_M, EARTH_M);
    static const double heights[] = {0.0, 1234.0, 9000.0}, sines[] = {1.0, 0.5, 0.1, 0.01, 0.0, -0.02};
    double worst = 0.0;
    for (int h = 0; h < 3; h++)
        for (int k = 0; k < 6; k++) {
            double r = EARTH_M + heights[h], straight = r * sines[k], top = heights[h] + 30 * HEIGHT_M;
            double end = sqrt(straight * straight + (EARTH_M + top) * (EARTH_M + top) - r * r) - straight;
            double column = nph_air_column_curved(&profile, heights[h], sines[k]);
            int grounded = sines[k] < 0 && r * sqrt(1 - sines[k] * sines[k]) < EARTH_M;
            ck_assert(grounded == isinf(column));
            if (!grounded) worst = fmax(worst, relative(column, plain_sum(&profile, heights[h], sines[k], end, 100000)));
        }
    printf("    largest relative difference %.2g\n", worst);
    ck_assert(worst < 1e-8); /* the sum's own: (step / H)^2 / 24 = 3e-9 for the longest ways */
    nph_air_profile_free(context, &profile);
    nph_test_context_close(context);
}
END_TEST

/* A sphere of a millionth of the curvature is flat. */
START_TEST(a_large_sphere_is_flat_and_its_lowest_point_is_found) {
    NphContext *context = nph_test_context(1);
    NphAirProfile profile = exponential(context, HEIGHT_M, 1e12);
    for (double sine = 1.0; sine > 0.01; sine *= 0.6)
        ck_assert(relative(nph_air_column_curved(&profile, 700.0, sine), nph_air_column_above(HEIGHT_M, 700.0, sine)) < 1e-4);
    nph_air_profile_free(context, &profile);
    profile = exponential(context, HEIGHT_M, EARTH_M);
    /* on both sides of the horizon as seen from 5 km, and of level */
    double dip = -sqrt(1 - pow(EARTH_M / (EARTH_M + 5000.0), 2.0));
    ck_assert(isinf(nph_air_column_curved(&profile, 5000.0, dip - 1e-9)));
    double grazing = nph_air_column_curved(&profile, 5000.0, dip + 1e-9), ground = nph_air_column_curved(&profile, 0.0, 0.0);
    ck_assert(grazing > ground && grazing < 2 * ground);
    double level = nph_air_column_curved(&profile, 5000.0, 0.0);
    ck_assert(relative(nph_air_column_curved(&profile, 5000.0, -1e-12), level) < 1e-9);
    ck_assert(relative(nph_air_column_curved(&profile, 5000.0, 1e-12), level) < 1e-9);
    ck_assert(isinf(nph_air_column_curved(&profile, 0.0, -1e-9)));
    nph_air_profile_free(context, &profile);
    nph_test_context_close(context);
}
END_TEST

/* [Bodhaine99 eq. 30] counts 2.152e25 molecules a cm2 at sea level. Relative air masses: [Kasten89], whose air refracts: a
 * hundredth more at 5 degrees, a fifteenth at the horizon. */
START_TEST(the_standard_atmosphere_weighs_what_is_published) {
    NphContext *context = nph_test_context(1);
    NphAirProfile profile = us_standard(context);
    double zenith = nph_air_column_curved(&profile, 0.0, 1.0), molecules = zenith * 2.545818e21;
    printf("    %.5g molecules/cm2 above sea level, %.6g m of air\n", molecules, zenith);
    ck_assert(relative(molecules, 2.152e25) < 1e-3);
    for (double degrees = 0.0; degrees <= 90.0; degrees += degrees < 10.0 ? 5.0 : 20.0) {
        double mass = nph_air_column_curved(&profile, 0.0, sin(degrees * DEGREE)) / zenith;
        double published = 1 / (sin(degrees * DEGREE) + 0.50572 * pow(degrees + 6.07995, -1.6364));
        printf("    %2g degrees: %.4f air masses, [Kasten89] %.4f\n", degrees, mass, published);
        ck_assert_msg(relative(mass, published) < (degrees > 9.0 ? 0.004 : degrees > 4.0 ? 0.012 : 0.1), "%g: %g", mass, published);
    }
    nph_air_profile_free(context, &profile);
    nph_test_context_close(context);
}
END_TEST

static double table_error(const NphAirTable *table, double most_m) {
    double worst = 0.0;
    for (int i = 0; i <= 77; i++)
        for (int k = -20; k <= 200; k++) {
            double height = most_m * i / 77, sine = k / 200.0 * fabs(k / 200.0);
            double truth = nph_air_column_curved(&table->profile, height, sine), column = nph_air_table_column(table, height, sine);
            ck_assert(isinf(truth) == isinf(column));
            if (!isinf(truth)) worst = fmax(worst, relative(column, truth));
        }
    return worst;
}

START_TEST(the_table_holds_what_quadrature_gives) {
    NphContext *context = nph_test_context(1);
    NphAirTable table;
    NphAirProfile profile = exponential(context, HEIGHT_M, EARTH_M);
    ck_assert_int_eq(nph_air_table_build(context, &profile, &table), NPH_OK);
    ck_assert(!profile.levels);
    double smooth = table_error(&table, 120000.0);
    nph_air_table_free(context, &table);
    profile = us_standard(context);
    ck_assert_int_eq(nph_air_table_build(context, &profile, &table), NPH_OK);
    double low = table_error(&table, 24000.0), all = table_error(&table, 120000.0);
    nph_air_table_free(context, &table);
    printf("    relative error: exponential %.2g; standard atmosphere %.2g below 24 km, %.2g below 120 km\n", smooth, low, all);
    ck_assert(smooth < 2e-5 && low < 1e-3 && all < 1e-3); /* measured when the nodes were chosen, and twice that */
    nph_test_context_close(context);
}
END_TEST

/* How far a flat atmosphere is off, as published in docs/air.md: transmittance of the channels at a height of 1 km. */
START_TEST(the_flat_form_holds_at_high_sun_and_not_at_low_sun) {
    NphContext *context = nph_test_context(1);
    NphAirTable round_one, standard;
    NphAirProfile profile = exponential(context, HEIGHT_M, EARTH_M);
    ck_assert_int_eq(nph_air_table_build(context, &profile, &round_one), NPH_OK);
    profile = us_standard(context);
    ck_assert_int_eq(nph_air_table_build(context, &profile, &standard), NPH_OK);
    static const double degrees[] = {90, 60, 30, 20, 10, 5, 3, 2, 1, 0.5, 0};
    for (int i = 0; i < 11; i++) {
        double sine = sin(degrees[i] * DEGREE), flat = nph_air_column_above(HEIGHT_M, 1000.0, sine), T[3][3];
        double columns[3] = {flat, nph_air_table_column(&round_one, 1000.0, sine), nph_air_table_column(&standard, 1000.0, sine)};
        for (int k = 0; k < 3; k++)
            for (int c = 0; c < 3; c++)
                T[k][c] = nph_air_transmittance(nph_rayleigh_per_m((double[]){680, 550, 440}[c]), columns[k]);
        printf("    %4.1f degrees: flat %.4f %.4f %.4f, round %.4f %.4f %.4f, standard %.4f %.4f %.4f\n", degrees[i], T[0][0],
               T[0][1], T[0][2], T[1][0], T[1][1], T[1][2], T[2][0], T[2][1], T[2][2]);
        /* columns: H / (R sin^2) is the first term of the difference */
        double bound = HEIGHT_M / (EARTH_M * sine * sine);
        if (degrees[i] >= 10) ck_assert(flat >= columns[1] && flat / columns[1] - 1 < bound);
        if (degrees[i] <= 1) ck_assert(flat > 1.5 * columns[1]);
    }
    nph_air_table_free(context, &round_one);
    nph_air_table_free(context, &standard);
    nph_test_context_close(context);
}
END_TEST

/* One height stands for a cloud's: what the transmittance is half a kilometre above and below. */
START_TEST(one_height_stands_for_a_cloud_of_a_kilometre) {
    static const double degrees[] = {60, 30, 10, 5};
    double blue = nph_rayleigh_per_m(440), red = nph_rayleigh_per_m(680);
    for (int i = 0; i < 4; i++) {
        double off[2][2];
        for (int c = 0; c < 2; c++)
            for (int end = 0; end < 2; end++) {
                double sine = sin(degrees[i] * DEGREE), beta = c ? blue : red;
                double middle = nph_air_transmittance(beta, nph_air_column_above(HEIGHT_M, 1500.0, sine));
                double there = nph_air_transmittance(beta, nph_air_column_above(HEIGHT_M, end ? 2000.0 : 1000.0, sine));
                off[c][end] = 100 * (there / middle - 1);
            }
        printf("    %2g degrees: red %+.2f%% %+.2f%%, blue %+.2f%% %+.2f%%\n", degrees[i], off[0][0], off[0][1], off[1][0], off[1][1]);
        ck_assert(off[0][0] < 0 && off[0][1] > 0 && off[1][0] < off[0][0] && off[1][1] > off[0][1]);
    }
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, rayleighs_extinction_is_that_of_two_published_fits_and_below_the_papers);
    tcase_add_test(cases, flat_columns_are_the_integral_of_the_density);
    tcase_add_test(cases, level_ways_are_the_limit_of_inclined_ones);
    tcase_add_test(cases, a_flat_atmosphere_ends_above_and_has_no_light_at_or_below_the_horizon);
    tcase_add_test(cases, the_sky_along_a_line_of_sight_has_the_value_of_exact_integration);
    tcase_add_test(cases, quadrature_is_the_plain_sum_over_the_way);
    tcase_add_test(cases, a_large_sphere_is_flat_and_its_lowest_point_is_found);
    tcase_add_test(cases, the_standard_atmosphere_weighs_what_is_published);
    tcase_add_test(cases, the_table_holds_what_quadrature_gives);
    tcase_add_test(cases, the_flat_form_holds_at_high_sun_and_not_at_low_sun);
    tcase_add_test(cases, one_height_stands_for_a_cloud_of_a_kilometre);
}

int main(void) { return nph_test_main("air", fill); }
