/* SPDX-License-Identifier: Apache-2.0
 *
 * Slabs whose phase function is Henyey and Greenstein's in disguise, as a table of its values and as Draine's with alpha
 * 0, against discrete ordinates (reference/tables/slab_fluxes.csv). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "harness.h"
#include "render_case.h"

/* g, ssa, tau, mu0 as the table writes them. */
static const char *const chosen[] = {"0.85,1,2,beam,0.5,", "0.85,0.99,2,beam,1,", "0.5,0.8,2,beam,0.5,"};
enum { CHOSEN = 3 };

/* R and T of the row that begins so. */
static void find_row(const char *beginning, double flux[2]) {
    FILE *file = fopen(nph_test_path("reference/tables/slab_fluxes.csv"), "r");
    ck_assert_ptr_nonnull(file);
    char line[2048];
    int found = 0;
    while (!found && fgets(line, sizeof line, file)) {
        double diffuse, direct;
        if (strncmp(line, beginning, strlen(beginning)) != 0) continue;
        found = sscanf(line + strlen(beginning), "%lf,%lf,%lf,%lf", &flux[0], &diffuse, &direct, &flux[1]) == 4;
    }
    fclose(file);
    ck_assert_msg(found, "no row %s", beginning);
}

/* Linear in the cosine between rows: steps of h deg change the mean cosine by less than (h pi / 180)^2 / (1 - g). */
static const char *write_table(double g) {
    const char *path = nph_test_temporary("hg.txt");
    FILE *file = fopen(path, "w");
    ck_assert_ptr_nonnull(file);
    fprintf(file, "# Henyey-Greenstein, g = %g\n", g);
    for (int i = 0; i <= 18000; i++) {
        double sine = sin(i * 0.005 * 3.14159265358979324 / 180.0), rest = 1.0 - g;
        fprintf(file, "%.2f %.17g\n", i * 0.01, pow(rest * rest + 4.0 * g * sine * sine, -1.5));
    }
    ck_assert_int_eq(fclose(file), 0);
    return path;
}

/* The number of samples comes from a pilot run with another seed (see test_slab.c). */
static void measure(const char *yaml, uint32_t seed, double wanted, double *mean, double *error) {
    int64_t samples = 64;
    for (uint32_t run = 0; run < 2; run++) {
        RenderCase render;
        NphRenderOptions options = render_options(samples, 32);
        options.seed_given = 1;
        options.seed = seed + run;
        render_case(&render, yaml, &options, 0);
        *mean = render_mean(&render, "R");
        *error = render_error(&render, "R");
        render_free(&render);
        samples = (int64_t)ceil((double)samples * *error * *error / (wanted * wanted) / 16.0) * 16;
    }
}

START_TEST(henyey_greenstein_in_disguise_matches_discrete_ordinates) {
    if (!nph_test_statistics("slab fluxes of tables")) return;
    double worst = 0.0;
    for (int i = 0; i < CHOSEN; i++) {
        double g, ssa, tau, mu0, flux[2];
        ck_assert_int_eq(sscanf(chosen[i], "%lf,%lf,%lf,beam,%lf", &g, &ssa, &tau, &mu0), 4);
        find_row(chosen[i], flux);
        const char *phases[] = {render_text("type: tabulated, file: %s", write_table(g)), render_text("type: draine, g: %g, alpha: 0", g)};
        for (int k = 0; k < 4; k++) {
            int below = k & 1;
            double mean = 0.0, error = 0.0;
            const char *yaml = render_text("nephos: 1\n"
                "camera: {type: flux, resolution: [32, 32], position: [0, 0, %s], direction: [0, 0, %d], up: [0, 1, 0], extent: 1}\n"
                "media:\n  - {layer: [0, 1], extinction: %.17g, albedo: %.17g, phase: {%s}}\n"
                "lights:\n  - {type: sun, elevation: %.17g, azimuth: 0, irradiance: %.17g}\n", below ? "-0.001" : "1.001",
                below ? 1 : -1, tau, ssa, phases[k / 2], asin(mu0) * 180.0 / 3.14159265358979324, 1.0 / mu0);
            measure(yaml, (uint32_t)(100 + 8 * i + 2 * k), 0.004 * flux[below], &mean, &error);
            double z = (mean - flux[below]) / error;
            printf("    %s %s %s %.6f  %.6f +- %.6f  z %+.2f\n", chosen[i], k < 2 ? "table" : "draine", below ? "below" : "above",
                   flux[below], mean, error, z);
            ck_assert_double_lt(error, 0.006 * flux[below]);
            worst = fabs(z) > worst ? fabs(z) : worst;
        }
    }
    /* 12 two-sided comparisons at 1% in all: 0.01 / 12 / 2 = 4.2e-4 beyond 3.34 standard deviations */
    ck_assert_double_le(worst, 3.34);
}
END_TEST

static void fill(TCase *cases) { tcase_add_test(cases, henyey_greenstein_in_disguise_matches_discrete_ordinates); }

int main(void) { return nph_test_main("phase_slab", fill); }
