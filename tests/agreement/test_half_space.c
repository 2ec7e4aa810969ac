/* SPDX-License-Identifier: Apache-2.0
 *
 * Isotropic scattering in a half space, whose reflection is known to twelve digits [Chandrasekhar60]: the radiance that
 * leaves under a beam, and the plane albedo 1 - H sqrt(1 - omega), which is also the radiance seen under a uniform upper
 * hemisphere. Depth 40 stands for the half space (albedos up to 0.9: what lies deeper returns less than 1e-9). */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "harness.h"
#include "render_case.h"

enum { CHOSEN = 12 };

/* Mean and standard error of the radiance with cosine mu under a light. */
static double z_of(double omega, double mu, const char *light, double truth, uint32_t seed) {
    RenderCase render;
    NphRenderOptions options = render_options(64, 32);
    options.seed_given = 1;
    options.seed = seed;
    render_case(&render, render_text("nephos: 1\n"
                                     "camera: {type: orthographic, resolution: [32, 32], position: [0, 0, 1.001],"
                                     " direction: [%.17g, 0, %.17g], up: [0, 1, 0], extent: 0.001}\n"
                                     "media:\n  - {layer: [0, 1], extinction: 40, albedo: %.17g, phase: {type: isotropic}}\n"
                                     "lights:\n  - %s\n", -sqrt(1.0 - mu * mu), -mu, omega, light), &options, 0);
    double mean = render_mean(&render, "R"), error = render_error(&render, "R");
    printf("    albedo %g, mu %g: %.6f +- %.6f, exactly %.6f, z %+.2f\n", omega, mu, mean, error, truth,
           (mean - truth) / error);
    ck_assert_double_le(error, 0.03 * mean);
    render_free(&render);
    return fabs(mean - truth) / error;
}

/* Rows that `use` takes, every `stride`-th: 0 leaves a row out. */
static void check_rows(const char *table, int stride, double (*use)(const char *row, uint32_t seed)) {
    FILE *file = fopen(nph_test_path(table), "r");
    ck_assert_ptr_nonnull(file);
    char line[2048];
    int used = 0, number = 0;
    double worst = 0.0;
    while (used < CHOSEN && fgets(line, sizeof line, file)) {
        if (line[0] == '#' || number++ % stride != 0) continue;
        double z = use(line, (uint32_t)number);
        used += z >= 0.0;
        worst = z > worst ? z : worst;
    }
    fclose(file);
    ck_assert_int_eq(used, CHOSEN);
    /* twelve comparisons at 1% in all */
    ck_assert_double_le(worst, 3.34);
}

static double use_radiance(const char *row, uint32_t seed) {
    char quantity[64];
    double omega, mu0, mu, value;
    if (sscanf(row, "%63[^,],%lf,%lf,%lf,%lf", quantity, &omega, &mu0, &mu, &value) != 5) return -1.0;
    if (strncmp(quantity, "I_", 2) != 0 || omega > 0.9 || mu0 * mu == 0.0) return -1.0;
    return z_of(omega, mu, render_text("{type: sun, direction: [%.17g, 0, %.17g], irradiance: 1}", -sqrt(1.0 - mu0 * mu0), mu0),
                value, seed);
}

static double use_albedo(const char *row, uint32_t seed) {
    double omega, mu, h, value;
    if (sscanf(row, "%lf,%lf,%lf,%lf", &omega, &mu, &h, &value) != 4 || omega > 0.9 || mu == 0.0) return -1.0;
    return z_of(omega, mu, "{type: constant, radiance: 1, hemisphere: upper}", value, seed);
}

START_TEST(a_half_space_under_a_beam_is_chandrasekhars) {
    check_rows("reference/tables/semi_infinite_isotropic.csv", 7, use_radiance);
}
END_TEST

START_TEST(the_plane_albedo_of_a_half_space_is_chandrasekhars) {
    check_rows("reference/tables/chandrasekhar_H.csv", 5, use_albedo);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, a_half_space_under_a_beam_is_chandrasekhars);
    tcase_add_test(cases, the_plane_albedo_of_a_half_space_is_chandrasekhars);
}

int main(void) { return nph_test_main("half_space", fill); }
