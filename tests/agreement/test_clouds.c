/* SPDX-License-Identifier: Apache-2.0
 *
 * The step cloud of the I3RC pixel by pixel, and a RICO cumulus, between sides that repeat, against an independent Monte Carlo
 * (reference/tables/i3rc_case1_*.csv, rico_*.csv). scripts/clouds does all experiments with more samples.
 * Fluxes are parts of mu0 F0, radiances pi I / (mu0 F0); the sun's light runs towards +x. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "harness.h"
#include "io/volume.h"
#include "render_case.h"

#define PI 3.14159265358979323846

/* Calls `row` with the fields of each line behind comments and the line of names. */
static void read_table(const char *name, void (*row)(char **fields, void *user), void *user) {
    FILE *file = fopen(nph_test_path(render_text("reference/tables/%s", name)), "r");
    ck_assert_ptr_nonnull(file);
    char line[2048];
    int names = 1;
    while (fgets(line, sizeof line, file)) {
        char *fields[40] = {0}, *at = line;
        if (line[0] == '#') continue;
        line[strcspn(line, "\r\n")] = 0;
        for (int n = 0; n < 40 && at; n++) {
            fields[n] = at;
            at = strchr(at, ',');
            if (at) *at++ = 0;
        }
        if (!names) row(fields, user);
        names = 0;
    }
    fclose(file);
}

static const char *write_cells(const char *name, int nx, int ny, int nz, const float *values) {
    NphContext *context = nph_test_context(1);
    NphArray array = {0};
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 3, (int64_t[]){nz, ny, nx}, "test", &array), NPH_OK);
    memcpy(array.data, values, sizeof *values * (size_t)nx * (size_t)ny * (size_t)nz);
    ck_assert_int_eq(nph_npy_write(context, nph_test_temporary(name), &array), NPH_OK);
    nph_array_free(context, &array);
    nph_test_context_close(context);
    return nph_test_temporary(name);
}

/* Ours and the table's value of each column for one experiment and quantity. */
typedef struct Columns {
    const char *experiment, *quantity;
    double ours[32], variance[32];
    double chi_square, sum;
    int count;
} Columns;

static void compare_pixel(char **f, void *user) {
    Columns *c = user;
    if (strcmp(f[0], c->experiment) != 0 || strcmp(f[3], c->quantity) != 0) return;
    int pixel = atoi(f[4]);
    double se = atof(f[8]), z = (c->ours[pixel] - atof(f[7])) / sqrt(se * se + c->variance[pixel]);
    c->chi_square += z * z;
    c->sum += z;
    c->count++;
}

/* x runs to the right in all of them. */
static const char *camera_of(const char *quantity) {
    const char *rest = "resolution: [32, 16], extent: 250";
    if (strcmp(quantity, "A") == 0) return render_text("{type: fluence, position: [250, 0, 125], direction: [0, 1, 0], %s}", rest);
    if (strcmp(quantity, "T") == 0) return render_text("{type: flux, position: [250, 0, 0], direction: [0, 0, 1], up: [0, -1, 0], %s}", rest);
    if (strcmp(quantity, "Id") == 0) return render_text("{type: orthographic, position: [250, 0, 0], direction: [0, 0, 1], up: [0, -1, 0], %s}", rest);
    if (strcmp(quantity, "I601") == 0)
        return render_text("{type: radiance, position: [250, 0, 250], direction: [0, 0, -1], up: [0, 1, 0], %s, seen: [%.17g, 0, -0.5]}", rest, -sqrt(0.75));
    return render_text("{type: %s, position: [250, 0, 250], direction: [0, 0, -1], up: [0, 1, 0], %s}", quantity[0] == 'R' ? "flux" : "orthographic", rest);
}

static void measure(Columns *c, const char *file, double sza, double albedo, int64_t samples) {
    double mu0 = sza > 0.0 ? 0.5 : 1.0, sine = sqrt(1.0 - mu0 * mu0), scale = c->quantity[0] == 'I' ? PI : 1.0;
    RenderCase r;
    NphRenderOptions options = render_options(samples, 32);
    render_case(&r, render_text("nephos: 1\ncamera: %s\nperiodic: {x: [0, 500]}\nmedia:\n"
                                "  - {density: {file: %s, lookup: nearest, box: [[0, -1e6, 0], [500, 1e6, 250]]}, extinction: 1, albedo: %g,"
                                " phase: {type: hg, g: 0.85}}\nlights:\n  - {type: sun, direction: [%.17g, 0, %.17g], irradiance: %.17g}\n",
                                camera_of(c->quantity), file, albedo, -sine, mu0, 1.0 / mu0), &options, 0);
    const float *value = nph_image_channel(&r.image, "R")->pixels, *variance = nph_image_channel(&r.image, "Variance.R")->pixels;
    for (int i = 0; i < 32; i++) {
        double factor = scale / 16.0;
        /* what a column absorbs: sigma_a times the integral of the fluence over its height */
        if (c->quantity[0] == 'A') factor = (i < 16 ? 2.0 : 18.0) * (1.0 - albedo) / 16.0;
        c->ours[i] = c->variance[i] = 0.0;
        for (int row = 0; row < 16; row++) {
            c->ours[i] += factor * (double)value[row * 32 + i];
            c->variance[i] += factor * factor * (double)variance[row * 32 + i];
        }
    }
    render_free(&r);
}

START_TEST(each_pixel_of_the_step_cloud_matches_an_independent_monte_carlo) {
    static const struct { const char *name; double sza, albedo; const char *quantities[6]; } experiments[] = {
        {"1", 0, 1, {"R", "T", "Iu"}}, {"2", 60, 1, {"R", "T", "I601", "Id"}}, {"3", 0, 0.99, {"R", "A"}}, {"4", 60, 0.99, {"T", "A", "Iu"}}};
    if (!nph_test_statistics("step cloud")) return;
    float cells[32];
    for (int i = 0; i < 32; i++) cells[i] = (float)((i < 16 ? 2.0 : 18.0) / 250.0);
    const char *file = write_cells("step.npy", 32, 1, 1, cells);
    int unlike = 0;
    for (int e = 0; e < 4; e++)
        for (int q = 0; experiments[e].quantities[q]; q++) {
            Columns c = {.experiment = experiments[e].name, .quantity = experiments[e].quantities[q]};
            int flux = c.quantity[0] != 'I';
            measure(&c, file, experiments[e].sza, experiments[e].albedo, 128);
            read_table(flux ? "i3rc_case1_step_flux_pixels.csv" : "i3rc_case1_step_radiance_pixels.csv", compare_pixel, &c);
            /* chi-square's 99.9% limit by Wilson and Hilferty's formula; the sum of z has the variance `count` */
            double part = 2.0 / (9.0 * c.count), limit = c.count * pow(1.0 - part + 3.09 * sqrt(part), 3.0);
            printf("    experiment %s %-4s: chi-square %5.1f of %d (limit %.1f), mean z %+.2f\n", c.experiment, c.quantity, c.chi_square,
                   c.count, limit, c.sum / c.count);
            ck_assert_int_ge(c.count, 15);
            unlike += c.chi_square > limit || fabs(c.sum) > 3.3 * sqrt(c.count);
        }
    ck_assert_int_eq(unlike, 0);
}
END_TEST

static void add_voxel(char **f, void *user) {
    float *cells = user;
    cells[(atoi(f[2]) * 37 + atoi(f[1])) * 32 + atoi(f[0])] = (float)atof(f[3]);
}

typedef struct Domain {
    const char *boundary, *sza, *albedo, *quantity;
    double value, error;
} Domain;

static void find_domain(char **f, void *user) {
    Domain *d = user;
    if (strcmp(f[0], "voxel") != 0 || strcmp(f[1], d->boundary) != 0 || strcmp(f[2], d->sza) != 0 || strcmp(f[3], d->albedo) != 0) return;
    if (strcmp(f[4], d->quantity) != 0) return;
    d->value = atof(f[5]);
    d->error = atof(f[6]);
}

START_TEST(a_cumulus_open_and_periodic_matches_an_independent_monte_carlo) {
    static const struct { Domain domain; const char *camera; } cases[] = {
        {{"periodic", "60", "0.99", "R", 0, 0}, "type: flux, position: [320, 370, 1040], direction: [0, 0, -1]"},
        {{"periodic", "60", "1", "Iu_mean", 0, 0}, "type: orthographic, position: [320, 370, 1040], direction: [0, 0, -1]"},
        {{"periodic", "60", "0.99", "Tdir", 0, 0}, "type: flux, position: [320, 370, 0], direction: [0, 0, 1]"},
        {{"open", "60", "0.99", "R", 0, 0}, "type: flux, position: [320, 370, 1040], direction: [0, 0, -1]"},
        {{"open", "0", "1", "R", 0, 0}, "type: flux, position: [320, 370, 1040], direction: [0, 0, -1]"}};
    if (!nph_test_statistics("cumulus")) return;
    static float cells[32 * 37 * 26];
    read_table("rico_sigma.csv", add_voxel, cells);
    const char *file = write_cells("rico.npy", 32, 37, 26, cells);
    for (int k = 0; k < 5; k++) {
        Domain d = cases[k].domain;
        read_table("rico_domain.csv", find_domain, &d);
        ck_assert_double_gt(d.value, 0.0);
        int direct = strcmp(d.quantity, "Tdir") == 0, up = direct ? -1 : 1;
        double mu0 = d.sza[0] == '6' ? 0.5 : 1.0, scale = d.quantity[0] == 'I' ? PI : 1.0;
        RenderCase r;
        NphRenderOptions options = render_options(direct ? 16 : 128, 32);
        render_case(&r, render_text("nephos: 1\ncamera: {%s, up: [0, %d, 0], resolution: [32, 37], extent: 640}\n%s"
                                    "media:\n  - {density: {file: %s, lookup: nearest, box: [[0, 0, 0], [640, 740, 1040]]}, extinction: 1, albedo: %s,"
                                    " phase: {type: hg, g: 0.85}}\nlights:\n  - {type: sun, direction: [%.17g, 0, %.17g], irradiance: %.17g}\n",
                                    cases[k].camera, up, strcmp(d.boundary, "open") == 0 ? "" : "periodic: {x: [0, 640], y: [0, 740]}\n", file,
                                    direct ? "0" : d.albedo, -sqrt(1.0 - mu0 * mu0), mu0, 1.0 / mu0), &options, 0);
        double ours = scale * render_mean(&r, "R"), error = scale * render_error(&r, "R"), both = sqrt(error * error + d.error * d.error);
        printf("    %s, sun at %s, albedo %s, %s: table %.5f +- %.5f, ours %.5f +- %.5f, z %+.2f\n", d.boundary, d.sza, d.albedo, d.quantity,
               d.value, d.error, ours, error, (ours - d.value) / both);
        ck_assert_double_le(both, 0.04 * d.value);
        ck_assert_double_le(fabs(ours - d.value), 3.09 * both); /* five comparisons at 1% in all */
        render_free(&r);
    }
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, each_pixel_of_the_step_cloud_matches_an_independent_monte_carlo);
    tcase_add_test(cases, a_cumulus_open_and_periodic_matches_an_independent_monte_carlo);
}

int main(void) { return nph_test_main("clouds", fill); }
