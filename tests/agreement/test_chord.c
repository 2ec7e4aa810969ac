/* SPDX-License-Identifier: Apache-2.0
 *
 * Mean chord: lit evenly from all sides, a convex body of volume V and surface S is crossed in paths of mean length 4V/S,
 * however it scatters [Blanco03], so that a path has 4 / S times the integral of the extinction as collisions in the mean.
 * Flux sensors just outside the faces of a box start such paths: uniform on the face, cosine distributed. */
#include <math.h>
#include <stdio.h>

#include "harness.h"
#include "io/volume.h"
#include "render_case.h"

static const double size[3] = {1.0, 0.5, 0.25};

/* Collisions of a path that enters through the face `axis`, lower or upper side. */
static double enter(const char *medium, int axis, int upper, uint32_t seed) {
    double middle[3] = {0.5 * size[0], 0.5 * size[1], 0.5 * size[2]}, direction[3] = {0, 0, 0}, up[3] = {0, 0, 0};
    int right = (axis + 1) % 3, top = (axis + 2) % 3;
    double width = size[right], height = size[top];
    middle[axis] = upper ? size[axis] + 1e-6 : -1e-6;
    direction[axis] = upper ? -1 : 1;
    up[top] = 1;
    /* the picture's shape is that of the face: 2 or 4 pixels to one; right = direction x up */
    int across = width > height ? (int)(width / height + 0.5) : 1, down = height > width ? (int)(height / width + 0.5) : 1;
    RenderCase render;
    NphRenderOptions options = render_options(256, 32);
    options.seed_given = 1;
    options.seed = seed;
    render_case(&render, render_text("nephos: 1\n"
                                     "camera: {type: flux, resolution: [%d, %d], position: [%.17g, %.17g, %.17g],"
                                     " direction: [%g, %g, %g], up: [%g, %g, %g], extent: %.17g}\n"
                                     "media:\n  - {%s}\nlights:\n  - {type: constant, radiance: 1}\n",
                                     4 * across, 4 * down, middle[0], middle[1], middle[2], direction[0], direction[1], direction[2],
                                     up[0], up[1], up[2], width < height ? width : height, medium), &options, 0);
    double collisions = (double)render.statistics.collisions / (double)render.statistics.samples;
    /* and nothing is lost */
    ck_assert_double_eq_tol(render_mean(&render, "R"), 3.14159265358979323846, 1e-5);
    render_free(&render);
    return collisions;
}

/* Mean over all faces, each as heavy as its area, with its standard error over runs of other seeds. */
static void check(const char *text, double truth, uint32_t seed) {
    enum { RUNS = 16 };
    char medium[1024];
    snprintf(medium, sizeof medium, "%s", text); /* render_text's buffers rotate */
    double faces = 2.0 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]), sum = 0.0, squares = 0.0;
    for (int run = 0; run < RUNS; run++) {
        double mean = 0.0;
        for (int face = 0; face < 6; face++) {
            double area = size[(face / 2 + 1) % 3] * size[(face / 2 + 2) % 3];
            mean += area / faces * enter(medium, face / 2, face % 2, seed + 6u * (uint32_t)run + (uint32_t)face);
        }
        sum += mean;
        squares += mean * mean;
    }
    double mean = sum / RUNS, error = sqrt((squares / RUNS - mean * mean) / (RUNS - 1));
    printf("    %.5f +- %.5f collisions, exactly %.5f, z %+.2f\n", mean, error, truth, (mean - truth) / error);
    ck_assert_double_le(error, 0.005 * truth);
    /* six comparisons at 1% in all, Student's t with 15 degrees of freedom */
    ck_assert_double_le(fabs(mean - truth), 4.0 * error);
}

START_TEST(paths_through_a_box_have_the_mean_chord_however_they_scatter) {
    static const char *const phases[] = {"isotropic", "hg, g: 0.9", "hg, g: -0.7", "rayleigh"};
    double volume = size[0] * size[1] * size[2], faces = 2.0 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]);
    for (int i = 0; i < 5 && (i == 0 || nph_test_statistics("mean chords")); i++) {
        double extinction = i == 4 ? 40.0 : 6.0;
        check(render_text("box: [[0, 0, 0], [1, 0.5, 0.25]], extinction: %g, albedo: 1, phase: {type: %s}", extinction,
                          phases[i % 4]), extinction * 4.0 * volume / faces, 1000u * (uint32_t)i);
    }
}
END_TEST

/* Where density varies, fluence is the same everywhere all the same: the integral of the extinction counts. */
START_TEST(paths_through_a_grid_have_the_collisions_of_the_mean_chord) {
    if (!nph_test_statistics("mean chords of a grid")) return;
    const char *path = nph_test_temporary("steps.npy");
    NphContext *context = nph_test_context(1);
    NphArray array;
    static const float density[8] = {0.0f, 9.0f, 1.0f, 4.0f, 0.5f, 2.0f, 30.0f, 7.0f};
    ck_assert_int_eq(nph_array_new(context, NPH_F32, 3, (int64_t[]){2, 2, 2}, "steps", &array), NPH_OK);
    double sum = 0.0;
    for (int i = 0; i < 8; i++) sum += (double)(((float *)array.data)[i] = density[i]);
    ck_assert_int_eq(nph_npy_write(context, path, &array), NPH_OK);
    nph_array_free(context, &array);
    nph_test_context_close(context);
    double volume = size[0] * size[1] * size[2], faces = 2.0 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]);
    check(render_text("density: {file: %s, box: [[0, 0, 0], [1, 0.5, 0.25]], centring: cell, lookup: nearest}, extinction: 3,"
                      " albedo: 1, phase: {type: hg, g: 0.5}", path), 3.0 * sum / 8.0 * 4.0 * volume / faces, 9000u);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, paths_through_a_box_have_the_mean_chord_however_they_scatter);
    tcase_add_test(cases, paths_through_a_grid_have_the_collisions_of_the_mean_chord);
}

int main(void) { return nph_test_main("chord", fill); }
