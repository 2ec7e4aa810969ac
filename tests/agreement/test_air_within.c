/* SPDX-License-Identifier: Apache-2.0
 *
 * Air within the scene: single scattering against the closed form of the sky and against its quadrature, the path tracer against
 * single at low albedo, furnaces, and the sphere against the plane. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "harness.h"
#include "optics/sky.h"
#include "render_case.h"

static const double PI = 3.14159265358979323846, EARTH_M = 6371000.0, H = 8000.0, AEROSOL_H = 1200.0;
static const double CLEAR[3] = {5.8e-6, 1.35e-5, 3.31e-5}, DUST[3] = {3e-5, 4e-5, 5e-5};
static const NphPhase RAYLEIGH = {NPH_PHASE_RAYLEIGH, {0, 0}, 0, 0, NULL}, HAZE = {NPH_PHASE_HG, {0.76, 0}, 0, 0, NULL};

static const struct {
    double height, sight[3], sun; /* elevation, degrees */
} lines[] = {{0, {0, 0, 1}, 40}, {500, {0.3, 0.2, 0.5}, 40}, {500, {-1, 0.2, 0.02}, 10}, {2500, {1, 0, 0}, 70}, {0, {0.4, 1, 0}, 4},
             {3000, {1, 1, -0.3}, 25}, {9000, {0, 0, -1}, 60}, {700, {-0.5, 0.1, -0.004}, 60}, {1e6, {0.1, 0.1, -1}, 30}};

enum { LINES = sizeof lines / sizeof lines[0] };

#define AIR_TEXT "extinction: [5.8e-6, 1.35e-5, 3.31e-5]"
#define HAZE_TEXT ", aerosol: {extinction: [3e-5, 4e-5, 5e-5], albedo: [0.9, 0.91, 0.92], scale_height: 1200, phase: {type: hg, g: 0.76}}"

static NphSky sky_of(int i, int haze) {
    NphSky sky = {.count = haze ? 2 : 1, .irradiance = {3, 2, 1}, .sun = {cos(lines[i].sun * PI / 180), 0, sin(lines[i].sun * PI / 180)}};
    sky.of[0] = (NphSkyConstituent){{CLEAR[0], CLEAR[1], CLEAR[2]}, {1, 1, 1}, H, NULL, &RAYLEIGH};
    sky.of[1] = (NphSkyConstituent){{DUST[0], DUST[1], DUST[2]}, {0.9, 0.91, 0.92}, AEROSOL_H, NULL, &HAZE};
    return sky;
}

static NphSkyLine line_of(int i) {
    NphSkyLine line = {lines[i].height, {0, 0, 0}, INFINITY};
    const double *s = lines[i].sight;
    for (int a = 0; a < 3; a++) line.direction[a] = s[a] / sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
    return line;
}

/* One pixel that looks along the line; the plane under flat air is black. */
static const char *scene_of(int i, int haze, const char *kind) {
    return render_text("nephos: 1\ncamera: {type: radiance, resolution: [1, 1], position: [0, 0, %.17g], direction: [0, 0, 1], up: [0, 1, 0], "
                       "extent: 0.001, seen: [%.17g, %.17g, %.17g]}\nair: {type: %s, where: within, %s%s}\n"
                       "lights: [{type: sun, elevation: %.17g, azimuth: 0, irradiance: [3, 2, 1]}]\n%s", lines[i].height, lines[i].sight[0],
                       lines[i].sight[1], lines[i].sight[2], kind, AIR_TEXT, haze ? HAZE_TEXT : "", lines[i].sun,
                       kind[0] == 'e' ? "surfaces: [{plane: -1e-6, albedo: 0}]\n" : "");
}

static void render_single(RenderCase *render, const char *yaml, const char *tolerance) {
    NphRenderOptions options = render_options(16, 64);
    options.method = "single";
    options.knobs = &tolerance;
    options.knob_count = 1;
    render_case(render, yaml, &options, 0);
    ck_assert_int_eq(render->statistics.unconverged, 0);
}

static const char *const channels[] = {"R", "G", "B"};

START_TEST(single_scattering_of_flat_air_is_the_analytic_sky) {
    double worst = 0;
    for (int haze = 0; haze < 2; haze++)
        for (int i = 0; i < LINES; i++) {
            RenderCase render;
            NphSky sky = sky_of(i, haze);
            NphSkyLine line = line_of(i);
            double L[3];
            nph_sky_scattered(&sky, &line, L);
            render_single(&render, scene_of(i, haze, "exponential"), "single.tolerance=1e-7");
            for (int c = 0; c < 3; c++) {
                double off = fabs(render_mean(&render, channels[c]) / L[c] - 1);
                ck_assert_msg(off < 1e-6, "line %d, haze %d, %s: %.9g is %.9g", i, haze, channels[c], render_mean(&render, channels[c]), L[c]);
                worst = fmax(worst, off);
            }
            render_free(&render);
        }
    printf("    largest relative difference %.2g\n", worst); /* pixels are floats: 6e-8 */
}
END_TEST

static void build(NphContext *context, double scale, double radius, NphAirTable *table) {
    NphAirProfile profile;
    ck_assert_int_eq(nph_air_profile_exponential(context, scale, radius, &profile), NPH_OK);
    ck_assert_int_eq(nph_air_table_build(context, &profile, table), NPH_OK);
}

START_TEST(single_scattering_around_a_sphere_is_the_skys_quadrature) {
    NphContext *context = nph_test_context(1);
    NphAirTable tables[2];
    double worst = 0;
    build(context, H, EARTH_M, &tables[0]);
    build(context, AEROSOL_H, EARTH_M, &tables[1]);
    for (int haze = 0; haze < 2; haze++)
        for (int i = 0; i < LINES; i++) {
            RenderCase render;
            NphSky sky = sky_of(i, haze);
            NphSkyLine line = line_of(i);
            double L[3];
            sky.radius_m = EARTH_M;
            for (int k = 0; k < 2; k++) sky.of[k].table = &tables[k];
            nph_sky_scattered(&sky, &line, L);
            render_single(&render, scene_of(i, haze, "table"), "single.tolerance=1e-6");
            for (int c = 0; c < 3; c++) {
                double off = fabs(render_mean(&render, channels[c]) / L[c] - 1);
                ck_assert_msg(off < 1e-4, "line %d, haze %d, %s: %.9g is %.9g", i, haze, channels[c], render_mean(&render, channels[c]), L[c]);
                worst = fmax(worst, off);
            }
            render_free(&render);
        }
    printf("    largest relative difference %.2g\n", worst); /* the tables' 1e-5, times depths of up to 10 */
    for (int k = 0; k < 2; k++) nph_air_table_free(context, &tables[k]);
    nph_test_context_close(context);
}
END_TEST

START_TEST(a_large_sphere_is_the_plane) {
    double before = INFINITY;
    for (double radius = EARTH_M; radius < 1e11; radius *= 100) {
        double worst = 0;
        for (int i = 0; i < 2; i++) {
            RenderCase flat, round;
            render_single(&flat, scene_of(i, 1, "exponential"), "single.tolerance=1e-6");
            render_single(&round, scene_of(i, 1, render_text("table, radius: %.17g", radius)), "single.tolerance=1e-6");
            for (int c = 0; c < 3; c++)
                worst = fmax(worst, fabs(render_mean(&round, channels[c]) / render_mean(&flat, channels[c]) - 1));
            render_free(&flat);
            render_free(&round);
        }
        printf("    radius %.3g m: off by at most %.2g\n", radius, worst);
        fflush(stdout);
        ck_assert(worst < 0.02 * before + 1.5e-7); /* two pixels that are floats */
        before = worst;
    }
    ck_assert(before < 2e-5);
}
END_TEST

/* ---- the path tracer ---- */

#define VIEW "nephos: 1\ncamera: {type: perspective, resolution: [24, 24], position: [0, -4000, 800], look_at: [0, 0, 1500], fov: 50}\n"
#define DIM "aerosol: {extinction: [4e-5, 8e-5, 2e-4], albedo: [2e-4, 1e-4, 1e-4], scale_height: 3000, phase: {type: rayleigh}}}\n"
#define CLOUD "media:\n  - {box: [[-800, -500, 1200], [900, 600, 2000]], extinction: 1e-3, albedo: 1e-4, phase: {type: hg, g: 0.5}}\n"

static const char *const pairs[] = {
    VIEW "air: {type: exponential, where: within, extinction: 0, " DIM "lights: [{type: sun, elevation: 35, azimuth: -60, irradiance: 3e4}]\n"
    "surfaces: [{plane: 0, albedo: 1e-4}]\n",
    VIEW CLOUD "air: {type: exponential, where: within, extinction: 0, " DIM
    "lights: [{type: sun, elevation: 35, azimuth: 130, irradiance: 3e4, angular_diameter: 5}, {type: point, position: [100, 200, 1100], intensity: 3e8}]\n",
    VIEW CLOUD "air: {type: table, where: within, extinction: 0, ground_albedo: 2e-4, " DIM
    "lights: [{type: sun, elevation: 5, azimuth: 130, irradiance: 3e4}]\n",
    VIEW "air: {type: table, where: within, radius: 1e6, extinction: 0, " DIM "lights: [{type: sun, elevation: -2, azimuth: 90, irradiance: 3e4}]\n",
};

START_TEST(path_at_low_albedo_is_single) {
    if (!nph_test_statistics("air at low albedo")) return;
    RenderCase path, single;
    NphComparison comparison;
    NphCompareOptions margins;
    NphRenderOptions options = render_options(512, 32);
    options.knobs = (const char *[]){"path.roulette=0", "path.least_light=0"};
    options.knob_count = 2;
    render_case(&path, pairs[_i], &options, 0);
    options = render_options(16, 64);
    options.method = "single";
    options.seed_given = 1;
    options.seed = 77;
    render_case(&single, pairs[_i], &options, 0);
    ck_assert_int_eq(single.statistics.unconverged, 0);
    for (int c = 0; c < 3; c++) {
        double one = render_mean(&path, channels[c]), other = render_mean(&single, channels[c]);
        double error = hypot(render_error(&path, channels[c]), render_error(&single, channels[c]));
        printf("    %d, %s: path %.6g, single %.6g, %+.2f%% +- %.2f%%\n", _i, channels[c], one, other, 100 * (other / one - 1), 100 * error / one);
        ck_assert_double_gt(other, 0.0);
        ck_assert_double_le(error, 0.015 * one);
        ck_assert_double_le(fabs(one - other), 4.0 * error);
    }
    nph_compare_options_default(&margins);
    ck_assert_int_eq(nph_compare(path.context, &path.image, &single.image, &margins, &comparison, NULL), NPH_OK);
    ck_assert_msg(comparison.verdict != NPH_NOT_SAME, "%s", comparison.reason);
    render_free(&single);
    render_free(&path);
}
END_TEST

static const char *const furnaces[] = {
    "air: {type: exponential, where: within, extinction: 1e-4}\n",
    "air: {type: exponential, where: within, aerosol: {turbidity: 4, albedo: 1}}\n",
    "air: {type: exponential, where: within, aerosol: {turbidity: 4, albedo: 1}}\nsurfaces: [{plane: 0, albedo: 1}]\n",
    "air: {type: table, where: within, extinction: 1e-4, ground_albedo: 1}\n",
    "air: {type: table, where: within, radius: 1e6, ground_albedo: 1, aerosol: {turbidity: 4, albedo: 1}}\n",
};

/* Of one extinction in all channels every sample is 1; else channels are weighed against each other, and have a variance. */
START_TEST(white_light_around_air_that_absorbs_nothing_stays_white) {
    if (!nph_test_statistics("furnaces of air")) return;
    int grey = _i == 0 || _i == 3;
    for (int precision = 32; precision <= 64; precision += 32) {
        RenderCase render;
        NphRenderOptions options = render_options(grey ? 16 : precision == 32 ? 4096 : 256, precision);
        render_case(&render, render_text("%s%slights: [{type: constant, radiance: 1}]\n",
                                         "nephos: 1\ncamera: {type: fisheye, resolution: [16, 16], position: [30, 20, 900], direction: [1, 0, 0.2], up: [0, 0, 1], fov: 300}\n"
                                         "media:\n  - {box: [[-800, -500, 1200], [900, 600, 2000]], extinction: 1e-3, albedo: 1, phase: {type: hg, g: 0.5}}\n",
                                         furnaces[_i]), &options, 0);
        const NphChannel *alpha = nph_image_channel(&render.image, "A");
        for (int c = 0; c < 3; c++) {
            const NphChannel *of = nph_image_channel(&render.image, channels[c]);
            char name[16];
            snprintf(name, sizeof name, "Variance.%s", channels[c]);
            const NphChannel *variance = nph_image_channel(&render.image, name);
            double sum = 0, square = 0;
            int seen = 0;
            for (int y = 0; y < 16; y++)
                for (int x = 0; x < 16; x++) {
                    if ((x - 7.5) * (x - 7.5) + (y - 7.5) * (y - 7.5) > 50) continue; /* whole pixels within the circle */
                    int i = 16 * y + x;
                    if (grey) ck_assert_msg(fabsf(of->pixels[i] - 1.0f) < 1e-6f, "%d: pixel %d is %.9g", _i, i, (double)of->pixels[i]);
                    sum += (double)of->pixels[i];
                    square += (double)variance->pixels[i];
                    seen++;
                }
            printf("    %d f%d %s: %.6f +- %.6f\n", _i, precision, channels[c], sum / seen, sqrt(square) / seen);
            ck_assert(fabs(sum / seen - 1) < 4 * sqrt(square) / seen + 1e-6 && sqrt(square) / seen < 0.03);
        }
        ck_assert(alpha != NULL && render.statistics.majorant_violations == 0);
        ck_assert_int_gt(render.statistics.collisions, 1000);
        render_free(&render);
    }
}
END_TEST

/* High sun, from the ground: the curve of the earth changes the column by H / (R sin^2), 0.1%. */
START_TEST(path_sees_the_same_high_sun_around_a_sphere_and_on_a_plane) {
    if (!nph_test_statistics("flat and spherical air")) return;
    RenderCase flat, round;
    NphRenderOptions options = render_options(16384, 32);
    static const char *const text = "nephos: 1\ncamera: {type: flux, resolution: [4, 4], position: [0, 0, 0.5], direction: [0, 0, 1], up: [0, 1, 0], extent: 0.1}\n"
                                    "air: {type: %s, where: within, aerosol: {turbidity: 2}}\nlights: [{type: sun, elevation: 75, azimuth: 0, irradiance: 1}]\n%s";
    render_case(&flat, render_text(text, "exponential", "surfaces: [{plane: 0, albedo: 0}]\n"), &options, 0);
    options.seed_given = 1;
    options.seed = 5;
    render_case(&round, render_text(text, "table", ""), &options, 0);
    for (int c = 0; c < 3; c++) {
        double one = render_mean(&flat, channels[c]), other = render_mean(&round, channels[c]);
        double error = hypot(render_error(&flat, channels[c]), render_error(&round, channels[c]));
        printf("    %s: flat %.6f, sphere %.6f, %+.3f%% +- %.3f%%\n", channels[c], one, other, 100 * (other / one - 1), 100 * error / one);
        ck_assert(fabs(other / one - 1) < 0.005 + 4 * error / one && error < 0.003 * one);
    }
    render_free(&flat);
    render_free(&round);
}
END_TEST

START_TEST(running_out_of_memory_is_told_and_leaves_nothing_behind) {
    NphRenderOptions options = render_options(16, 32);
    render_without_memory("nephos: 1\ncamera: {type: flux, resolution: [2, 2], position: [0, 0, 0.5], direction: [0, 0, 1], up: [0, 1, 0], extent: 0.1}\n"
                          "air: {type: table, where: within, aerosol: {turbidity: 2, phase: {type: tabulated, file: ../data/gpl/c1_phase.txt}}}\n"
                          "lights: [{type: sun, elevation: 35, azimuth: 0, irradiance: 1}]\n", &options);
    render_without_memory("nephos: 1\ncamera: {type: flux, resolution: [2, 2], position: [0, 0, 0.5], direction: [0, 0, 1], up: [0, 1, 0], extent: 0.1}\n"
                          "air: {type: table, aerosol: {turbidity: 2}}\nlights: [{type: sky, elevation: 35, azimuth: 0, irradiance: 1, rows: 2}]\n", &options);
}
END_TEST

START_TEST(methods_without_air_say_so) {
    static const char *const methods[] = {"light", "photonmap", "shdom", "temporal_photons", "principal_ordinates"};
    for (int i = 0; i < 5; i++) {
        RenderCase render;
        NphRenderOptions options = render_options(16, 32);
        options.method = methods[i];
        NphStatus status = render_try(&render, VIEW CLOUD "air: {type: exponential, where: within}\nlights: [{type: sun, elevation: 35, azimuth: 0, irradiance: 1}]\n", &options, 1);
        const char *said = nph_test_messages();
        ck_assert_msg(status == NPH_BAD_SCENE && strstr(said, "air within the scene is not part of this method"), "%s: %d, %s", methods[i], status, said);
        render_free(&render);
    }
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, single_scattering_of_flat_air_is_the_analytic_sky);
    tcase_add_test(cases, single_scattering_around_a_sphere_is_the_skys_quadrature);
    tcase_add_test(cases, a_large_sphere_is_the_plane);
    tcase_add_loop_test(cases, path_at_low_albedo_is_single, 0, (int)(sizeof pairs / sizeof *pairs));
    tcase_add_loop_test(cases, white_light_around_air_that_absorbs_nothing_stays_white, 0, (int)(sizeof furnaces / sizeof *furnaces));
    tcase_add_test(cases, path_sees_the_same_high_sun_around_a_sphere_and_on_a_plane);
    tcase_add_test(cases, running_out_of_memory_is_told_and_leaves_nothing_behind);
    tcase_add_test(cases, methods_without_air_say_so);
}

int main(void) { return nph_test_main("air_within", fill); }
