/* SPDX-License-Identifier: Apache-2.0
 *
 * Closed forms: transmittance through analytic densities, single scattering of a slab, and one medium written in six
 * ways. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "harness.h"
#include "io/volume.h"
#include "render_case.h"

/* Writes density f(x, y, z) on n points an axis of the box, as float, to a temporary .npy. */
static const char *write_field(double (*f)(double, double, double), const int n[3], const double lo[3], const double hi[3]) {
    static int number;
    const char *path = nph_test_temporary(render_text("field%d.npy", number++));
    NphContext *context = nph_test_context(1);
    NphArray array;
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 3, (int64_t[]){n[2], n[1], n[0]}, "field", &array), NPH_OK);
    float *value = array.data;
    for (int k = 0; k < n[2]; k++)
        for (int j = 0; j < n[1]; j++)
            for (int i = 0; i < n[0]; i++)
                *value++ = (float)f(lo[0] + (hi[0] - lo[0]) * i / (n[0] - 1), lo[1] + (hi[1] - lo[1]) * j / (n[1] - 1),
                                    lo[2] + (hi[2] - lo[2]) * k / (n[2] - 1));
    ck_assert_int_eq(nph_npy_write(context, path, &array), NPH_OK);
    nph_array_free(context, &array);
    nph_test_context_close(context);
    return path;
}

/* Transmittance along one line by the alpha channel of a tiny orthographic picture: 16 x 16 pixels, 1024 samples. */
static void check_line(const char *density, const double from[3], const double to[3], double truth) {
    double d[3] = {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
    const char *up = fabs(d[2]) > fabs(d[0]) + fabs(d[1]) ? "1, 0, 0" : "0, 0, 1";
    const char *yaml = render_text("nephos: 1\n"
                                   "camera: {type: orthographic, resolution: [16, 16], position: [%.17g, %.17g, %.17g],"
                                   " direction: [%.17g, %.17g, %.17g], up: [%s], extent: 1e-7}\n"
                                   "media:\n  - {density: %s, extinction: 1, albedo: 0}\n"
                                   "lights:\n  - {type: constant, radiance: 1}\n",
                                   from[0], from[1], from[2], d[0], d[1], d[2], up, density);
    for (int precision = 32; precision <= 64; precision += 32) {
        RenderCase render;
        NphRenderOptions options = render_options(1024, precision);
        render_case(&render, yaml, &options, 0);
        double mean = render_mean(&render, "R"), error = sqrt(truth * (1.0 - truth) / (256.0 * 1024.0));
        printf("    f%d: %.6f, closed form %.6f, z %+.2f\n", precision, mean, truth, (mean - truth) / error);
        ck_assert_double_le(fabs(mean - truth), 4.0 * error);
        ck_assert_double_eq_tol(render_mean(&render, "A"), 1.0 - mean, 1e-6);
        render_free(&render);
    }
}

static double corners(double x, double y, double z) {
    static const double v[8] = {0.1, 2.0, 0.7, 0.0, 1.3, 0.4, 5.0, 0.9};
    return v[(x > 0.5) + 2 * (y > 0.5) + 4 * (z > 0.5)];
}
static double exponential(double x, double y, double z) {
    (void)x;
    (void)y;
    return 0.7 * exp(-z / 1.3);
}
static double gaussian(double x, double y, double z) { return 3.0 * exp(-0.5 * (x * x + y * y + z * z)); }
static double sinusoid(double x, double y, double z) {
    (void)y;
    (void)z;
    return 0.9 * (1.0 + 0.8 * sin(2.0 * 3.14159265358979323846 * x));
}

/* Rows of reference/tables/transmittance_heterogeneous.csv; the grids are fine enough for their own error (h^2 f'' / 12)
 * to be a tenth of the statistical one. */
START_TEST(transmittance_through_analytic_densities_is_beer_lamberts) {
    const char *path = write_field(corners, (int[]){2, 2, 2}, (double[]){0, 0, 0}, (double[]){1, 1, 1});
    check_line(render_text("{file: %s, box: [[0, 0, 0], [1, 1, 1]], centring: point}", path), (double[]){0.1, 0.2, 0},
               (double[]){0.9, 0.6, 1}, 0.2466515779207);
    path = write_field(exponential, (int[]){2, 2, 513}, (double[]){-9, -9, 0.5}, (double[]){9, 9, 3.5});
    check_line(render_text("{file: %s, box: [[-9, -9, 0.5], [9, 9, 3.5]], centring: point}", path), (double[]){0, 0, 0.25},
               (double[]){0, 0, 4}, 0.5724562227645);
    path = write_field(gaussian, (int[]){129, 129, 129}, (double[]){-5, -5, -5}, (double[]){5, 5, 5});
    check_line(render_text("{file: %s, box: [[-5, -5, -5], [5, 5, 5]], centring: point}", path), (double[]){-5, 0.9, 0},
               (double[]){5, 0.9, 0}, 0.006633744038993);
    path = write_field(sinusoid, (int[]){513, 2, 2}, (double[]){0, 0, 0}, (double[]){2.37, 1, 1});
    check_line(render_text("{file: %s, box: [[0, 0, 0], [2.37, 1, 1]], centring: point}", path), (double[]){-1, 0.5, 0.5},
               (double[]){5, 0.5, 0.5}, 0.09768230235043);
}
END_TEST

typedef struct SingleRow {
    char phase[32], level[16];
    double ssa, tau, mu0, mu, phi, value;
} SingleRow;

static int read_single(SingleRow *rows, int most) {
    FILE *file = fopen(nph_test_path("reference/tables/single_scatter_slab.csv"), "r");
    ck_assert_ptr_nonnull(file);
    char line[1024];
    int count = 0;
    while (count < most && fgets(line, sizeof line, file)) {
        SingleRow *r = &rows[count];
        if (sscanf(line, "%31[^,],%lf,%lf,%lf,%lf,%lf,%15[^,],%lf", r->phase, &r->ssa, &r->tau, &r->mu0, &r->mu, &r->phi,
                   r->level, &r->value) == 8)
            count++;
    }
    fclose(file);
    return count;
}

/* The path tracer has no depth limit: an albedo of 1e-4 leaves single scattering, to a relative 1e-4 of it. */
START_TEST(single_scattering_of_a_slab_is_the_closed_form) {
    if (!nph_test_statistics("single scattering of a slab")) return;
    static SingleRow rows[512];
    int count = read_single(rows, 512);
    ck_assert_int_gt(count, 300);
    double worst = 0.0;
    int checked = 0;
    for (int i = 0; i < count; i += 11) {
        const SingleRow *r = &rows[i];
        if (r->value < 1e-4) continue; /* light that deep needs more samples than a test has */
        double s = sqrt(1.0 - r->mu * r->mu), phi = r->phi * 3.14159265358979323846 / 180.0;
        const char *phase = strncmp(r->phase, "HG", 2) == 0      ? render_text("{type: hg, g: %s}", r->phase + 2)
                            : strcmp(r->phase, "rayleigh") == 0 ? "{type: rayleigh}"
                                                                : "{type: isotropic}";
        const char *yaml = render_text(
            "nephos: 1\n"
            "camera: {type: orthographic, resolution: [32, 32], position: [0, 0, %g], direction: [%.17g, %.17g, %.17g],"
            " up: [0.3, 1, 0.1], extent: 0.001}\n"
            "media:\n  - {layer: [0, 1], extinction: %.17g, albedo: 1e-4, phase: %s}\n"
            "lights:\n  - {type: sun, direction: [%.17g, 0, %.17g], irradiance: 1}\n",
            r->mu > 0 ? 1.001 : -0.001, -s * cos(phi), -s * sin(phi), -r->mu, r->tau, phase, -sqrt(1.0 - r->mu0 * r->mu0),
            r->mu0);
        double mean = 0.0, error = HUGE_VAL;
        for (int64_t samples = 64; samples <= 4096 && !(error <= 0.01 * r->value); samples *= 4) {
            RenderCase render;
            NphRenderOptions options = render_options(samples, 32);
            render_case(&render, yaml, &options, 0);
            mean = render_mean(&render, "R") / 1e-4;
            error = render_error(&render, "R") / 1e-4;
            render_free(&render);
        }
        double z = (r->ssa * mean - r->value) / (r->ssa * sqrt(error * error + 1e-8 * mean * mean));
        worst = fabs(z) > worst ? fabs(z) : worst;
        if (fabs(z) > 3.0) printf("    %s tau %g mu0 %g mu %g phi %g: %.8f against %.8f, z %+.2f\n", r->phase, r->tau, r->mu0, r->mu, r->phi, r->ssa * mean, r->value, z);
        ck_assert_double_le(error, 0.01 * r->value);
        checked++;
    }
    /* About 30 comparisons at 1% in all: |z| < 3.8. */
    printf("    %d rows, largest |z| %.2f\n", checked, worst);
    ck_assert_int_ge(checked, 20);
    ck_assert_double_le(worst, 3.8);
}
END_TEST

static double one(double x, double y, double z) {
    (void)x;
    (void)y;
    (void)z;
    return 1.0;
}

START_TEST(one_medium_written_six_ways_is_one_picture) {
    if (!nph_test_statistics("one medium in six ways")) return;
    static const char *const scene =
        "nephos: 1\n"
        "camera: {type: perspective, resolution: [64, 64], position: [-1.5, -1.5, 0.5], look_at: [0.5, 0.5, 0.5], fov: 35}\n"
        "media:\n  - {%s, extinction: 4, albedo: 0.9, phase: {type: hg, g: 0.5}}\n"
        "lights:\n  - {type: sun, direction: [-1, 0.2, 0.3], irradiance: 3}\n  - {type: constant, radiance: 0.2}\n";
    const char *fine = write_field(one, (int[]){17, 13, 11}, (double[]){0, 0, 0}, (double[]){1, 1, 1});
    const char *voxel = nph_test_temporary("voxel.npy");
    NphContext *context = nph_test_context(1);
    NphArray array;
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 3, (int64_t[]){1, 1, 1}, "voxel", &array), NPH_OK);
    *(float *)array.data = 1.0f;
    ck_assert_int_eq(nph_npy_write(context, voxel, &array), NPH_OK);
    nph_array_free(context, &array);
    nph_test_context_close(context);
    const char *ways[] = {
        "box: [[0, 0, 0], [1, 1, 1]]",
        render_text("density: {file: %s, box: [[0, 0, 0], [1, 1, 1]], centring: point}", fine),
        render_text("density: {file: %s, box: [[0, 0, 0], [1, 1, 1]], centring: cell, lookup: nearest}", fine),
        render_text("density: {file: %s, box: [[0, 0, 0], [1, 1, 1]], centring: cell, outside: clamp}", voxel),
        render_text("density: {file: %s, box: [[0, 0, 0], [1, 1, 1]], centring: cell, lookup: nearest}", voxel),
        "density: {file: ../data/cube/cube.zip.nvdb, centring: cell, lookup: nearest}",
    };
    RenderCase first;
    NphRenderOptions options = render_options(1024, 32);
    render_case(&first, render_text(scene, ways[0]), &options, 0);
    for (int way = 1; way < 6; way++) {
        RenderCase other;
        NphComparison comparison;
        NphCompareOptions margins;
        options.seed_given = 1;
        options.seed = 100u + (uint32_t)way;
        render_case(&other, render_text(scene, ways[way]), &options, 0);
        nph_compare_options_default(&margins);
        margins.margin_image = 0.01;
        margins.margin_tile = 0.1;
        ck_assert_int_eq(nph_compare(first.context, &first.image, &other.image, &margins, &comparison, NULL), NPH_OK);
        printf("    %s: %s (%s)\n", ways[way], nph_verdict_name(comparison.verdict), comparison.reason);
        ck_assert_int_eq(comparison.verdict, NPH_SAME);
        render_free(&other);
    }
    render_free(&first);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, transmittance_through_analytic_densities_is_beer_lamberts);
    tcase_add_test(cases, single_scattering_of_a_slab_is_the_closed_form);
    tcase_add_test(cases, one_medium_written_six_ways_is_one_picture);
}

int main(void) { return nph_test_main("closed_forms", fill); }
