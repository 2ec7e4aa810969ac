/* SPDX-License-Identifier: Apache-2.0
 *
 * f32 against f64, at home and 1e7 m from the world's origin: the same words in both precisions make nearly the same paths, so
 * pairs of equal seeds show differences far below the noise of either. Canonical scenes at the size of reference/golden.
 *
 *   NEPHOS_PRECISION_SAMPLES=N test_precision     the numbers of docs/accuracy.md; the suite takes 16 samples a pixel */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "harness.h"
#include "render_case.h"
#include "scene/model.h"

static const char *const names[] = {"cube_g000", "cube_g070", "cube_g095", "slab", "smoke", "rico", "cumulus", "les_stcu"};
enum { NAMES = sizeof names / sizeof names[0] };

/* Moves everything that has a place by 1e7 m along x, y, z: exact to 2e-9 m in f64. */
static void move(NphScene *scene) {
    for (int a = 0; a < 3; a++) {
        scene->sensor.position[a] += 1e7;
        for (int m = 0; m < scene->medium_count; m++)
            if (scene->media[m].shape != NPH_SHAPE_LAYER || a == 2) scene->media[m].world_from_medium[4 * a + 3] += 1e7;
        for (int l = 0; l < scene->light_count; l++) scene->lights[l].position[a] += 1e7;
    }
}

static void render_golden(RenderCase *render, const char *name, int precision, int far) {
    const char *text = getenv("NEPHOS_PRECISION_SAMPLES");
    NphRenderOptions options = render_options(text ? atoi(text) : 16, precision);
    memset(render, 0, sizeof *render);
    render->context = nph_test_context(0);
    const char *path = nph_test_path(render_text("reference/golden/%s.yaml", name));
    ck_assert_msg(nph_scene_load(render->context, path, &render->scene) == NPH_OK, "%s", nph_test_messages());
    if (far) move(render->scene);
    NphStatus status = nph_render(render->context, render->scene, &options, &render->film, &render->statistics);
    ck_assert_msg(status == NPH_OK, "%s: %s", name, nph_test_messages());
    ck_assert_int_eq(nph_film_image(render->context, render->film, &render->image), NPH_OK);
}

/* Difference of the pictures' means, and its standard error from the scatter of the pixels' differences; relative. */
static void compare_pair(const RenderCase *a, const RenderCase *b, double *difference, double *error, double *same) {
    const float *x = nph_image_channel(&a->image, "G")->pixels, *y = nph_image_channel(&b->image, "G")->pixels;
    int count = a->image.width * a->image.height;
    double sum = 0.0, squares = 0.0, mean = render_mean(b, "G");
    *same = 0.0;
    for (int i = 0; i < count; i++) {
        double d = (double)x[i] - (double)y[i];
        sum += d / count;
        squares += d * d / count;
        *same += fabs(d) <= 1e-5 * (double)y[i] ? 1.0 / count : 0.0;
    }
    *difference = sum / mean;
    *error = sqrt((squares - sum * sum) / count) / mean;
}

START_TEST(f32_and_f64_are_one_picture_at_home_and_far_away) {
    if (!nph_test_statistics("f32 against f64")) return;
    RenderCase exact, single, far;
    const char *name = names[_i];
    render_golden(&exact, name, 64, 0);
    render_golden(&single, name, 32, 0);
    render_golden(&far, name, 32, 1);
    const RenderCase *pairs[2] = {&single, &far};
    for (int k = 0; k < 2; k++) {
        double difference, error, same;
        compare_pair(pairs[k], &exact, &difference, &error, &same);
        printf("    | %s | %s | %+.2e | %.1e | %+.2f | %.1f%% | %.1e |\n", name, k ? "1e7 m away" : "at home", difference, error,
               error > 0.0 ? difference / error : 0.0, 100.0 * same, render_error(&exact, "G") / render_mean(&exact, "G"));
        /* sixteen comparisons at 1% in all, and the roundings of f32: 2^-24 for each of some hundred additions */
        ck_assert_double_le(fabs(difference), 3.42 * error + 5e-6);
    }
    render_free(&exact);
    render_free(&single);
    render_free(&far);
}
END_TEST

static void fill(TCase *cases) { tcase_add_loop_test(cases, f32_and_f64_are_one_picture_at_home_and_far_away, 0, NAMES); }

int main(void) { return nph_test_main("precision", fill); }
