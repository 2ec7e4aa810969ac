/* SPDX-License-Identifier: Apache-2.0
 *
 * The sky: closed forms against plain sums and against the quadrature, limits from both sides, what joined and split lines must
 * fulfil, energy, and the sphere against the plane. */
#include "optics/sky.h"

#include <float.h>
#include <math.h>
#include <stdio.h>

#include "harness.h"

static const double H = 8000.0, AEROSOL_H = 1200.0, DEGREE = 0.017453292519943295, EARTH_M = 6371000.0;
static const double RILEY[3] = {5.8e-6, 1.35e-5, 3.31e-5}; /* [Riley04 table 3] */
static const NphPhase RAYLEIGH = {NPH_PHASE_RAYLEIGH, {0, 0}, 0, 0, NULL}, HAZE = {NPH_PHASE_HG, {0.76, 0}, 0, 0, NULL};

static double relative(double value, double truth) { return fabs(value - truth) / fmax(fabs(truth), DBL_MIN); }

static void along(double elevation, double azimuth, double d[3]) {
    d[0] = cos(elevation * DEGREE) * cos(azimuth * DEGREE);
    d[1] = cos(elevation * DEGREE) * sin(azimuth * DEGREE);
    d[2] = elevation == 0 ? 0 : elevation == 180 ? 0 : sin(elevation * DEGREE);
}

static NphSky clear_sky(double sun_elevation) {
    NphSky sky = {.count = 1, .irradiance = {1, 1, 1}, .of = {{{5.8e-6, 1.35e-5, 3.31e-5}, {1, 1, 1}, 8000.0, NULL, &RAYLEIGH}}};
    along(sun_elevation, 20, sky.sun);
    return sky;
}

static NphSky hazy_sky(double sun_elevation) {
    NphSky sky = clear_sky(sun_elevation);
    sky.count = 2;
    sky.of[1] = (NphSkyConstituent){{3e-5, 4e-5, 5e-5}, {0.9, 0.91, 0.92}, AEROSOL_H, NULL, &HAZE};
    return sky;
}

static NphSkyLine looking(double height, double elevation, double azimuth, double distance) {
    NphSkyLine line = {height, {0, 0, 0}, distance};
    along(elevation, azimuth, line.direction);
    return line;
}

/* ---- the paper's line ---- */

START_TEST(the_line_of_sight_is_the_exact_integral_and_the_print_lacks_a_factor) {
    static const double of[2][7] = {{0.5, 0.8, 0, 1e5, 0.344370, 0.584828}, {0.9, 0.3, 1000, 2e4, 0.135676, 0.175900}};
    for (int k = 0; k < 2; k++) {
        const double *v = of[k];
        double exact = nph_sky_line(NPH_SKY_CORRECTED, 3.31e-5, H, v[2], v[0], v[1], v[3]);
        double printed = nph_sky_line(NPH_SKY_PAPER, 3.31e-5, H, v[2], v[0], v[1], v[3]);
        printf("    corrected %.6f, paper %.6f\n", exact, printed);
        ck_assert(fabs(exact - v[4]) < 6e-7 && fabs(printed - v[5]) < 6e-7);
        ck_assert(relative(printed * exp(-3.31e-5 * H * exp(-v[2] / H) / v[0]), exact) < 1e-13);
    }
    ck_assert(!isfinite(nph_sky_line(NPH_SKY_PAPER, 3.31e-5, H, 0, 3e-4, 0.8, 1e5)));
    ck_assert(isfinite(nph_sky_line(NPH_SKY_CORRECTED, 3.31e-5, H, 0, 3e-4, 0.8, 1e5)));
}
END_TEST

/* [Riley04 eq. 14] by Simpson's rule, columns written out anew; lines no longer than 30 optical depths. */
static double plain(double b, double eye, double rise, double sun, double length) {
    enum { STEPS = 4000 };
    double sum = 0;
    for (int i = 0; i <= STEPS; i++) {
        double t = length * i / STEPS, h = eye + rise * t, weight = i == 0 || i == STEPS ? 1 : i % 2 ? 4 : 2;
        double column = rise == 0 ? t * exp(-eye / H) : exp(-eye / H) * -expm1(-rise * t / H) * H / rise;
        sum += weight * exp(-h / H - b * (column + H * exp(-h / H) / sun));
    }
    return b * sum * length / (3 * STEPS);
}

START_TEST(the_closed_form_is_the_plain_sum_up_down_and_level) {
    static const double rises[] = {1, 0.9, 0.3, 0.31, 0.02, 1e-4, 1e-9, 0, -1e-9, -1e-4, -0.02, -0.3, -1};
    static const double suns[] = {1, 0.9, 0.3, 0.05}, eyes[] = {0, 500, 12000};
    double worst = 0;
    for (int c = 0; c < 3; c++)
        for (size_t r = 0; r < sizeof rises / sizeof rises[0]; r++)
            for (int s = 0; s < 4; s++)
                for (int e = 0; e < 3; e++) {
                    double length = rises[r] < 0 ? fmin(eyes[e] / -rises[r], 8e4) : 8e4;
                    double value = nph_sky_line(NPH_SKY_CORRECTED, RILEY[c], H, eyes[e], rises[r], suns[s], length);
                    double truth = plain(RILEY[c], eyes[e], rises[r], suns[s], length);
                    if (length > 0) worst = fmax(worst, relative(value, truth));
                    else ck_assert(value == 0);
                }
    printf("    largest relative difference %.2g\n", worst);
    ck_assert(worst < 2e-10); /* Simpson's own: steps of 20 m, at most 1/400 of a scale height or 1/150 of a depth, ^4 / 180 */
}
END_TEST

/* ---- limits ---- */

static void steady(double from, double to, const char *what) {
    ck_assert_msg(isfinite(from) && isfinite(to) && relative(from, to) < 1e-7, "%s: %.17g and %.17g", what, from, to);
}

START_TEST(limits_are_finite_and_reached_from_both_sides) {
    static const double small[] = {1e-9, 1e-12, 1e-15, 1e-30, 1e-300, 5e-324};
    for (size_t i = 0; i < sizeof small / sizeof small[0]; i++)
        for (int c = 0; c < 3; c++)
            for (double length = 1e-3; length < 1e7; length *= 10) {
                double b = RILEY[c], level = nph_sky_line(NPH_SKY_CORRECTED, b, H, 1000, 0, 0.5, length);
                steady(nph_sky_line(NPH_SKY_CORRECTED, b, H, 1000, small[i], 0.5, length), level, "rising");
                steady(nph_sky_line(NPH_SKY_CORRECTED, b, H, 1000, -small[i], 0.5, length), level, "falling");
                double at = nph_sky_line(NPH_SKY_CORRECTED, b, H, 1000, 0.5, 0.5, length);
                steady(nph_sky_line(NPH_SKY_CORRECTED, b, H, 1000, 0.5, 0.5 + small[i], length), at, "sun above");
                steady(nph_sky_line(NPH_SKY_CORRECTED, b, H, 1000, 0.5, 0.5 - small[i], length), at, "sun below");
            }
    double endless = nph_sky_line(NPH_SKY_CORRECTED, RILEY[0], H, 0, 0, 0.5, INFINITY);
    steady(endless, exp(-RILEY[0] * H / 0.5), "level without end");
    steady(nph_sky_line(NPH_SKY_CORRECTED, RILEY[0], H, 0, 1e-12, 0.5, INFINITY), endless, "nearly level without end");
    steady(nph_sky_line(NPH_SKY_CORRECTED, RILEY[0], H, 0, 0, 0.5, 1e9), endless, "level, far");
    ck_assert(nph_sky_line(NPH_SKY_CORRECTED, RILEY[0], H, 0, 0.3, 0, 1e5) == 0);
    ck_assert(nph_sky_line(NPH_SKY_CORRECTED, RILEY[0], H, 0, 0.3, 5e-324, 1e5) == 0);
    ck_assert(nph_sky_line(NPH_SKY_CORRECTED, 0, H, 0, 0, 0.3, INFINITY) == 0);
    ck_assert(nph_sky_line(NPH_SKY_CORRECTED, 1e300, H, 0, 0.3, 0.5, 1e5) == 0);
    ck_assert(nph_sky_line(NPH_SKY_CORRECTED, RILEY[2], H, 1e12, 1, 0.5, INFINITY) == 0);
    ck_assert(isfinite(nph_sky_line(NPH_SKY_CORRECTED, RILEY[2], H, 1e12, -1, 0.5, 1e12)));
}
END_TEST

START_TEST(the_horizon_is_where_up_and_down_meet) {
    NphSky skies[2] = {clear_sky(25), hazy_sky(25)};
    for (int k = 0; k < 2; k++)
        for (double eye = 1; eye < 2e4; eye *= 100) {
            double up[3], level[3], down[3];
            NphSkyLine line = looking(eye, 0, 50, INFINITY);
            nph_sky_scattered(&skies[k], &line, level);
            line.direction[2] = 1e-11;
            nph_sky_scattered(&skies[k], &line, up);
            line.direction[2] = -1e-11; /* far more than 45 depths to the ground */
            nph_sky_scattered(&skies[k], &line, down);
            for (int c = 0; c < 3; c++) steady(up[c], level[c], "up"), steady(down[c], level[c], "down");
        }
}
END_TEST

/* ---- quadrature ---- */

START_TEST(the_quadrature_is_the_closed_form) {
    double worst = 0;
    NphSky sky = clear_sky(0);
    for (int k = 0; k < 400; k++) {
        double metres[NPH_SKY_MOST][3], elevation = fmod(k * 37.7, 180) - 90, eye = k % 5 == 0 ? 0 : fmod(k * 977.0, 30000);
        NphSkyLine line = looking(eye, k % 7 ? elevation : 0, 0, k % 3 ? INFINITY : fmod(k * 3571.0, 1e5));
        along(fmod(k * 11.3, 88) + 1, 20, sky.sun);
        nph_sky_integrate(&sky, &line, metres);
        for (int c = 0; c < 3; c++) {
            double value = nph_sky_line(NPH_SKY_CORRECTED, RILEY[c], H, eye, line.direction[2], sky.sun[2], nph_sky_end(&sky, &line));
            if (value > 1e-30) worst = fmax(worst, relative(RILEY[c] * metres[0][c], value));
        }
    }
    printf("    largest relative difference %.2g\n", worst);
    ck_assert(worst < 1e-9);
}
END_TEST

/* Two scale heights, by Simpson's rule with columns written out anew. */
static double plain_haze(const NphSky *sky, int i, int c, double eye, double rise, double length) {
    enum { STEPS = 20000 };
    double sum = 0;
    for (int k = 0; k <= STEPS; k++) {
        double t = length * k / STEPS, h = eye + rise * t, weight = k == 0 || k == STEPS ? 1 : k % 2 ? 4 : 2, depth = 0;
        for (int j = 0; j < 2; j++) {
            double scale = sky->of[j].scale_height_m;
            double column = rise == 0 ? t * exp(-eye / scale) : exp(-eye / scale) * -expm1(-rise * t / scale) * scale / rise;
            depth += sky->of[j].extinction_per_m[c] * (column + scale * exp(-h / scale) / sky->sun[2]);
        }
        sum += weight * exp(-h / sky->of[i].scale_height_m - depth);
    }
    return sum * length / (3 * STEPS);
}

START_TEST(aerosol_with_a_height_of_its_own_is_the_plain_sum) {
    NphSky sky = hazy_sky(18);
    double worst = 0;
    static const double elevations[] = {-60, -5, 0, 3, 40, 90};
    for (int k = 0; k < 6; k++) {
        NphSkyLine line = looking(1500, elevations[k], 0, elevations[k] < 0 ? INFINITY : 6e4);
        double metres[NPH_SKY_MOST][3], length = nph_sky_end(&sky, &line);
        nph_sky_integrate(&sky, &line, metres);
        for (int i = 0; i < 2; i++)
            for (int c = 0; c < 3; c++)
                worst = fmax(worst, relative(metres[i][c], plain_haze(&sky, i, c, 1500, line.direction[2], length)));
    }
    printf("    largest relative difference %.2g\n", worst);
    ck_assert(worst < 1e-9);
}
END_TEST

START_TEST(two_constituents_of_one_height_are_one_of_their_sum) {
    NphSky two = hazy_sky(30), quadrature = two;
    two.of[1].scale_height_m = H;
    quadrature.of[1].scale_height_m = H * (1 + 1e-12); /* no closed form */
    for (int k = -9; k <= 9; k++) {
        NphSkyLine line = looking(700, 10 * k, 33, INFINITY);
        double a[3], b[3];
        nph_sky_scattered(&two, &line, a);
        nph_sky_scattered(&quadrature, &line, b);
        for (int c = 0; c < 3; c++) ck_assert(relative(a[c], b[c]) < 1e-9);
    }
}
END_TEST

/* ---- joined and split ---- */

START_TEST(transmittances_of_joined_lines_multiply_and_split_lines_add_up) {
    NphSky skies[2] = {clear_sky(12), hazy_sky(70)};
    for (int k = 0; k < 600; k++) {
        const NphSky *sky = &skies[k % 2];
        NphSkyLine line = looking(fmod(k * 97.0, 9000) + 1, fmod(k * 37.7, 180) - 90, k, 10 + fmod(k * k * 31.0, 50000)), whole = line, next = line;
        if (k % 9 == 0) line = whole = next = looking(300, 0, k, line.distance_m);
        double first[3], second[3], both[3], all[3];
        NphSkySplit split;
        whole.distance_m = INFINITY;
        nph_sky_scattered(sky, &whole, all);
        nph_sky_split(sky, &line, &split);
        for (int c = 0; c < 3; c++) ck_assert(relative(split.front[c] + split.through[c] * split.behind[c], all[c]) < 2e-9);
        if (!(line.distance_m < nph_sky_end(sky, &whole))) {
            for (int c = 0; c < 3; c++) ck_assert(split.behind[c] == 0 && split.front[c] == all[c]);
            continue;
        }
        next.height_m = nph_sky_height(sky, &line, line.distance_m);
        next.distance_m = fmin(line.distance_m, nph_sky_end(sky, &next));
        whole.distance_m = line.distance_m + next.distance_m;
        nph_sky_transmittance(sky, &line, first);
        nph_sky_transmittance(sky, &next, second);
        nph_sky_transmittance(sky, &whole, both);
        for (int c = 0; c < 3; c++) ck_assert(relative(first[c] * second[c], both[c]) < 1e-12 || both[c] < 1e-290);
    }
}
END_TEST

/* ---- energy ---- */

/* Flux through a level plane at a height of what comes from above (+1) or below (-1). */
static void flux(const NphSky *sky, double height, double side, double sum[3]) {
    enum { RISES = 64, TURNS = 64 };
    for (int c = 0; c < 3; c++) sum[c] = 0;
    for (int j = 0; j < RISES; j++)
        for (int i = 0; i < TURNS; i++) {
            double u = (j + 0.5) / RISES, rise = u * u, L[3]; /* d rise = 2 u du: denser at the horizon */
            NphSkyLine line = {height, {sqrt(1 - rise * rise) * cos(6.2831853071795865 * i / TURNS),
                                        sqrt(1 - rise * rise) * sin(6.2831853071795865 * i / TURNS), side * rise}, INFINITY};
            nph_sky_scattered(sky, &line, L);
            for (int c = 0; c < 3; c++) sum[c] += L[c] * rise * 2 * u / RISES * 6.2831853071795865 / TURNS;
        }
}

START_TEST(no_more_light_leaves_the_air_than_it_scattered) {
    for (double elevation = 5; elevation <= 90; elevation += 17)
        for (int haze = 0; haze < 2; haze++) {
            NphSky sky = haze ? hazy_sky(elevation) : clear_sky(elevation);
            double down[3], up[3], arrives[3];
            flux(&sky, 0, 1, down);
            flux(&sky, 45 * H, -1, up);
            nph_sky_sunlight(&sky, 0, arrives);
            for (int c = 0; c < 3; c++) ck_assert(down[c] + up[c] < (1 - arrives[c]) * sky.sun[2]);
        }
}
END_TEST

/* With a millionth of the air nothing of what is scattered is scattered again: the fluxes are all of it. */
START_TEST(thin_air_returns_all_that_it_scatters) {
    NphSky sky = clear_sky(50);
    double down[3], up[3], arrives[3];
    for (int c = 0; c < 3; c++) sky.of[0].extinction_per_m[c] *= 1e-6;
    flux(&sky, 0, 1, down);
    flux(&sky, 45 * H, -1, up);
    nph_sky_sunlight(&sky, 0, arrives);
    for (int c = 0; c < 3; c++) {
        printf("    scattered %.6g, returned %.6g\n", (1 - arrives[c]) * sky.sun[2], down[c] + up[c]);
        ck_assert(relative(down[c] + up[c], (1 - arrives[c]) * sky.sun[2]) < 1e-3); /* 64 rises; horizon, where it is not thin */
    }
}
END_TEST

/* ---- colours, the disc ---- */

START_TEST(overhead_is_bluer_than_the_horizon_and_a_low_sun_is_red) {
    NphSky sky = clear_sky(60);
    NphSkyLine zenith = looking(0, 90, 0, INFINITY), horizon = looking(0, 0, 100, INFINITY);
    double top[3], rim[3], high[3], low[3];
    nph_sky_scattered(&sky, &zenith, top);
    nph_sky_scattered(&sky, &horizon, rim);
    nph_sky_sunlight(&sky, 0, high);
    along(3, 20, sky.sun);
    nph_sky_sunlight(&sky, 0, low);
    printf("    blue over red: zenith %.3f, horizon %.3f; sun at 60 degrees %.3f, at 3 %.3f\n", top[2] / top[0], rim[2] / rim[0],
           high[2] / high[0], low[2] / low[0]);
    ck_assert(top[2] / top[0] > 3 && rim[2] / rim[0] < 1.1 && rim[1] > top[1]);
    ck_assert(high[2] / high[0] > 0.7 && low[2] / low[0] < 0.05);
}
END_TEST

START_TEST(the_disc_holds_the_suns_light) {
    NphSky sky = clear_sky(40);
    NphSkyLine line = {0, {sky.sun[0], sky.sun[1], sky.sun[2]}, INFINITY}, beside = looking(0, 40.26, 20, INFINITY), within = looking(0, 40.24, 20, INFINITY);
    double L[3], arrives[3], half = 0.25 * DEGREE;
    nph_sky_sunlight(&sky, 0, arrives);
    nph_sky_disc(&sky, &line, half, L);
    for (int c = 0; c < 3; c++) ck_assert(relative(L[c] * 3.14159265358979323846 * sin(half) * sin(half), arrives[c]) < 1e-12);
    nph_sky_disc(&sky, &beside, half, L);
    ck_assert(L[0] == 0 && L[1] == 0 && L[2] == 0);
    nph_sky_disc(&sky, &within, half, L);
    ck_assert(L[0] > 0);
}
END_TEST

/* ---- around a sphere ---- */

static void build(NphContext *context, double scale, double radius, NphAirTable *table) {
    NphAirProfile profile;
    ck_assert_int_eq(nph_air_profile_exponential(context, scale, radius, &profile), NPH_OK);
    ck_assert_int_eq(nph_air_table_build(context, &profile, table), NPH_OK);
}

START_TEST(a_sphere_becomes_the_plane_as_it_grows) {
    NphContext *context = nph_test_context(1);
    static const double elevations[] = {-50, -12, 4, 15, 60, 90};
    double before = INFINITY;
    for (double radius = EARTH_M; radius < 1e9; radius *= 10) {
        NphAirTable tables[2];
        NphSky flat = hazy_sky(20), round = flat;
        double worst = 0;
        build(context, H, radius, &tables[0]);
        build(context, AEROSOL_H, radius, &tables[1]);
        round.radius_m = radius;
        for (int i = 0; i < 2; i++) round.of[i].table = &tables[i];
        for (int k = 0; k < 6; k++) {
            NphSkyLine line = looking(1000, elevations[k], 70, INFINITY);
            double a[3], b[3];
            nph_sky_scattered(&flat, &line, a);
            nph_sky_scattered(&round, &line, b);
            for (int c = 0; c < 3; c++) worst = fmax(worst, relative(b[c], a[c]));
        }
        printf("    radius %.3g m: off by at most %.2g\n", radius, worst);
        ck_assert(worst < 0.2 * before);
        before = worst;
        for (int i = 0; i < 2; i++) nph_air_table_free(context, &tables[i]);
    }
    ck_assert(before < 2e-3);
    nph_test_context_close(context);
}
END_TEST

START_TEST(around_a_sphere_lines_join_and_split_too) {
    NphContext *context = nph_test_context(1);
    NphAirTable tables[2];
    NphSky sky = hazy_sky(9);
    double worst = 0, joined = 0;
    build(context, H, EARTH_M, &tables[0]);
    build(context, AEROSOL_H, EARTH_M, &tables[1]);
    sky.radius_m = EARTH_M;
    for (int i = 0; i < 2; i++) sky.of[i].table = &tables[i];
    for (int k = 0; k < 200; k++) {
        NphSkyLine line = looking(fmod(k * 97.0, 9000) + 1, fmod(k * 37.7, 140) - 50, k * 7, 10 + fmod(k * k * 31.0, 90000)), whole = line;
        double all[3], T[3], more[3], both[3];
        NphSkySplit split;
        whole.distance_m = INFINITY;
        nph_sky_scattered(&sky, &whole, all);
        nph_sky_split(&sky, &line, &split);
        for (int c = 0; c < 3; c++) worst = fmax(worst, relative(split.front[c] + split.through[c] * split.behind[c], all[c]));
        if (!(2 * line.distance_m < nph_sky_end(&sky, &whole))) continue;
        nph_sky_transmittance(&sky, &line, T);
        double height = nph_sky_height(&sky, &line, line.distance_m), radius = EARTH_M + height;
        NphSkyLine next = {height, {0, 0, ((EARTH_M + line.height_m) * line.direction[2] + line.distance_m) / radius}, line.distance_m};
        next.direction[0] = sqrt(1 - next.direction[2] * next.direction[2]);
        whole.distance_m = 2 * line.distance_m;
        nph_sky_transmittance(&sky, &next, more);
        nph_sky_transmittance(&sky, &whole, both);
        for (int c = 0; c < 3; c++) joined = fmax(joined, relative(T[c] * more[c], both[c]));
    }
    printf("    split %.2g, joined %.2g\n", worst, joined);
    ck_assert(worst < 1e-5 && joined < 1e-9); /* the tables' own 1e-5 */
    for (int i = 0; i < 2; i++) nph_air_table_free(context, &tables[i]);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_sphere_has_light_at_and_below_the_horizon) {
    NphContext *context = nph_test_context(1);
    NphAirTable table;
    NphSky sky = clear_sky(-1);
    double L[3];
    build(context, H, EARTH_M, &table);
    sky.radius_m = EARTH_M;
    sky.of[0].table = &table;
    NphSkyLine zenith = looking(0, 90, 0, INFINITY), down = looking(2e6, -80, 0, INFINITY), past = looking(2e6, -10, 0, INFINITY);
    nph_sky_scattered(&sky, &zenith, L);
    for (int c = 0; c < 3; c++) ck_assert(L[c] > 0 && isfinite(L[c])); /* twilight */
    along(50, 0, sky.sun);
    nph_sky_scattered(&sky, &down, L);
    ck_assert(L[2] > L[0] && L[0] > 1e-4); /* the blue haze over a black earth */
    nph_sky_scattered(&sky, &past, L);
    ck_assert(L[0] == 0 && L[1] == 0 && L[2] == 0); /* passes above the air */
    nph_air_table_free(context, &table);
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *tcase) {
    tcase_add_test(tcase, the_line_of_sight_is_the_exact_integral_and_the_print_lacks_a_factor);
    tcase_add_test(tcase, the_closed_form_is_the_plain_sum_up_down_and_level);
    tcase_add_test(tcase, limits_are_finite_and_reached_from_both_sides);
    tcase_add_test(tcase, the_horizon_is_where_up_and_down_meet);
    tcase_add_test(tcase, the_quadrature_is_the_closed_form);
    tcase_add_test(tcase, aerosol_with_a_height_of_its_own_is_the_plain_sum);
    tcase_add_test(tcase, two_constituents_of_one_height_are_one_of_their_sum);
    tcase_add_test(tcase, transmittances_of_joined_lines_multiply_and_split_lines_add_up);
    tcase_add_test(tcase, no_more_light_leaves_the_air_than_it_scattered);
    tcase_add_test(tcase, thin_air_returns_all_that_it_scatters);
    tcase_add_test(tcase, overhead_is_bluer_than_the_horizon_and_a_low_sun_is_red);
    tcase_add_test(tcase, the_disc_holds_the_suns_light);
    tcase_add_test(tcase, a_sphere_becomes_the_plane_as_it_grows);
    tcase_add_test(tcase, around_a_sphere_lines_join_and_split_too);
    tcase_add_test(tcase, a_sphere_has_light_at_and_below_the_horizon);
}

int main(void) { return nph_test_main("sky", fill); }
