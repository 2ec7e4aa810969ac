/* SPDX-License-Identifier: Apache-2.0
 *
 * A point light inside a medium: against exact transport in an infinite medium, and against what a variance is: it falls
 * as one over the number of samples, and shared between techniques in whatever way the mean stays. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "harness.h"
#include "render_case.h"

#define CUBE "nephos: 1\ncamera: {resolution: [24, 24], position: [-1.6, -1.3, 1.5], look_at: [0.5, 0.5, 0.5], fov: 25}\n" \
             "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: %s, albedo: %s, phase: {type: hg, g: 0.4}}\n"                \
             "lights:\n  - {type: point, position: [0.45, 0.5, 0.6], intensity: 1}\n"

/* Rows of the table: albedo, distance in mean free paths, fluence of a source of 1 W. The medium is a layer of 120 mean
 * free paths, what is missing beyond them is below 1e-20. */
START_TEST(fluence_around_a_point_in_an_infinite_medium_is_exact_transports) {
    if (!nph_test_statistics("point source")) return;
    static const struct { double albedo, r, fluence; } rows[] = {
        {0.3, 0.5, 0.2453390822}, {0.5, 1, 0.058695137513}, {0.8, 0.1, 8.6640272028}, {0.8, 1, 0.10741258975}};
    for (int i = 0; i < 4; i++) {
        RenderCase r;
        NphRenderOptions options = render_options(4096, i == 3 ? 64 : 32);
        options.seed_given = 1;
        options.seed = (uint32_t)(i + 1);
        render_case(&r, render_text("nephos: 1\ncamera: {type: fluence, resolution: [8, 8], position: [%.17g, 0, 0], direction: [0, 0, 1],"
                                    " up: [0, 1, 0], extent: 1e-4}\nmedia:\n  - {layer: [-60, 60], extinction: 1, albedo: %.17g}\n"
                                    "lights:\n  - {type: point, position: [0, 0, 0], intensity: 0.079577471545947668}\n",
                                    rows[i].r, rows[i].albedo), &options, 0);
        double mean = render_mean(&r, "R"), error = render_error(&r, "R");
        printf("    albedo %g at %g: %.6g +- %.2g, %.6g: z %+.2f\n", rows[i].albedo, rows[i].r, mean, error, rows[i].fluence,
               (mean - rows[i].fluence) / error);
        ck_assert(fabs(mean - rows[i].fluence) < 4.0 * error);
        ck_assert(error < 0.01 * rows[i].fluence);
        render_free(&r);
    }
}
END_TEST

/* The mean of the pixels' variances times the samples, which is that of one sample. Over the upper third of the picture,
 * where no camera ray meets the light: its own pixel has a pole whose square diverges, if only as a logarithm. */
static double variance_of_one(int64_t samples, uint32_t seed, const char *knob, double *mean, double *error) {
    RenderCase r;
    NphRenderOptions options = render_options(samples, 32);
    options.seed_given = 1;
    options.seed = seed;
    options.knob_count = 1;
    options.knobs = &knob;
    render_case(&r, render_text(CUBE, "4", "1"), &options, 0);
    const NphChannel *values = nph_image_channel(&r.image, "Variance.R");
    double variance = 0.0;
    for (int i = 0; i < 24 * 8; i++) variance += (double)values->pixels[i] * (double)samples / (24 * 8);
    *mean = render_mean(&r, "R");
    *error = render_error(&r, "R");
    render_free(&r);
    return variance;
}

START_TEST(the_variance_of_a_sample_does_not_grow_with_their_number) {
    if (!nph_test_statistics("variance of a point light")) return;
    double mean, error, few = variance_of_one(256, 3, "path.near_light=1", &mean, &error);
    double many = variance_of_one(2048, 4, "path.near_light=1", &mean, &error);
    double before = variance_of_one(2048, 4, "path.near_light=0", &mean, &error);
    printf("    variance of one sample: %.3g in 256, %.3g in 2048; %.3g when collisions take all\n", few, many, before);
    ck_assert(many < 1.5 * few && few < 1.5 * many);
    ck_assert(before > 3.0 * many);
}
END_TEST

START_TEST(however_it_is_shared_the_mean_stays) {
    if (!nph_test_statistics("sharing of a point light")) return;
    static const char *const knobs[] = {"path.near_light=0.2", "path.near_light=1", "path.near_light=4"};
    double mean[3], error[3];
    for (int i = 0; i < 3; i++) {
        variance_of_one(1536, (uint32_t)(10 + i), knobs[i], &mean[i], &error[i]);
        printf("    %s: %.6g +- %.2g\n", knobs[i], mean[i], error[i]);
    }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        ck_assert(fabs(mean[i] - mean[j]) < 4.0 * hypot(error[i], error[j]));
        ck_assert(error[i] < 0.01 * mean[i]);
    }
}
END_TEST

/* Each channel of a chromatic medium is a grey scene; a surface beside the light is lit, and hides, as it did. */
START_TEST(channels_and_surfaces_share_alike) {
    if (!nph_test_statistics("point light, channels and surfaces")) return;
    static const char *const grey[] = {"1", "4", "8"}, *const albedo[] = {"1", "0.9", "0.5"};
    static const char *const floor = "surfaces:\n  - {plane: 0.5, albedo: 0.6}\n";
    RenderCase wide;
    NphRenderOptions options = render_options(2048, 32);
    render_case(&wide, render_text("%s%s", render_text(CUBE, "[1, 4, 8]", "[1, 0.9, 0.5]"), floor), &options, 0);
    for (int c = 0; c < 3; c++) {
        const char *name = (const char *[]){"R", "G", "B"}[c];
        double mean = render_mean(&wide, name), error = render_error(&wide, name);
        RenderCase one;
        NphRenderOptions other = render_options(2048, 32);
        const char *knob = "path.near_light=0.3";
        other.seed_given = 1;
        other.seed = (uint32_t)(20 + c);
        other.knob_count = 1;
        other.knobs = &knob;
        render_case(&one, render_text("%s%s", render_text(CUBE, grey[c], albedo[c]), floor), &other, 0);
        double both = hypot(error, render_error(&one, "R")), off = mean - render_mean(&one, "R");
        printf("    %s %.5g, alone %.5g: z %+.2f\n", name, mean, render_mean(&one, "R"), off / both);
        ck_assert(fabs(off) < 4.0 * both && both < 0.03 * mean);
        render_free(&one);
    }
    render_free(&wide);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, fluence_around_a_point_in_an_infinite_medium_is_exact_transports);
    tcase_add_test(cases, the_variance_of_a_sample_does_not_grow_with_their_number);
    tcase_add_test(cases, however_it_is_shared_the_mean_stays);
    tcase_add_test(cases, channels_and_surfaces_share_alike);
}

int main(void) { return nph_test_main("point_light", fill); }
