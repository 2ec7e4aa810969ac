/* SPDX-License-Identifier: Apache-2.0
 *
 * Few samples of every canonical scene, from another seed, against its converged picture (reference/golden). */
#include <stdio.h>
#include <string.h>

#include "harness.h"
#include "render_case.h"

typedef struct Golden {
    const char *name;
    int64_t samples;
} Golden;
static const Golden goldens[] = {{"cube_g000", 64}, {"cube_g070", 64}, {"cube_g095", 64}, {"slab", 256},
                                 {"slab16", 256},   {"smoke", 16},     {"rico", 16},      {"cumulus", 16},   {"les_stcu", 16},
                                 {"sphere", 64},    {"smoke_ground", 16}, {"smoke_seq", 16}, {"night", 16}};
enum { GOLDENS = sizeof goldens / sizeof goldens[0] };

static void load(const char *name, RenderCase *render) {
    memset(render, 0, sizeof *render);
    render->context = nph_test_context(0);
    NphStatus status =
        nph_scene_load(render->context, nph_test_path(render_text("reference/golden/%s.yaml", name)), &render->scene);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
}

/* Renders the scene and judges it against the converged picture of `name`. */
static void judge(RenderCase *render, const char *name, int64_t samples, NphComparison *comparison) {
    NphRenderOptions options = render_options(samples, 32);
    NphCompareOptions margins;
    NphImage truth;
    nph_compare_options_default(&margins);
    options.seed_given = 1;
    options.seed = 4711;
    NphStatus status = nph_render(render->context, render->scene, &options, &render->film, &render->statistics);
    if (status == NPH_OK) status = nph_film_image(render->context, render->film, &render->image);
    if (status == NPH_OK)
        status = nph_exr_read(render->context, nph_test_path(render_text("reference/golden/%s.exr", name)), &truth);
    ck_assert_msg(status == NPH_OK, "%s: %s", name, nph_test_messages());
    status = nph_compare(render->context, &render->image, &truth, &margins, comparison, NULL);
    ck_assert_msg(status == NPH_OK, "%s: %s", name, nph_test_messages());
    printf("    %s: %s (%s)\n", name, nph_verdict_name(comparison->verdict), comparison->reason);
    nph_image_free(render->context, &truth);
    render_free(render);
}

START_TEST(few_samples_do_not_differ_from_the_converged_picture) {
    RenderCase render;
    NphComparison comparison;
    load(goldens[_i].name, &render);
    judge(&render, goldens[_i].name, goldens[_i].samples, &comparison);
    ck_assert_int_ne(comparison.verdict, NPH_NOT_SAME);
    /* and it has seen enough to tell: the means are known to 5% */
    ck_assert_double_le(comparison.standard_error[1], 0.05);
}
END_TEST

START_TEST(another_scene_differs_from_it) {
    RenderCase render;
    NphComparison comparison;
    load("cube_g070", &render);
    judge(&render, "cube_g000", 64, &comparison);
    ck_assert_int_eq(comparison.verdict, NPH_NOT_SAME);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_loop_test(cases, few_samples_do_not_differ_from_the_converged_picture, 0, GOLDENS);
    tcase_add_test(cases, another_scene_differs_from_it);
}

int main(void) { return nph_test_main("golden", fill); }
