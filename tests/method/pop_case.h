/* SPDX-License-Identifier: Apache-2.0
 *
 * Solutions of principal ordinates, stage by stage, and what lies in their arrays. */
#ifndef NPH_TESTS_METHOD_POP_CASE_H
#define NPH_TESTS_METHOD_POP_CASE_H

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "../render_case.h"
#include "harness.h"
#include "method/job.h"
#include "method/principal_ordinates/pop_kept.h"

#define PI 3.14159265358979323846

typedef struct Solution {
    NphContext *context;
    NphScene *scene;
    NphJob job;
    NphPopSolver solver;
} Solution;

/* In f64, with knobs separated by blanks. */
static inline void solution_open(Solution *s, const char *yaml, int threads, const char *knobs) {
    const NphMethod *method = NULL;
    NphRenderOptions options;
    char words[1024];
    const char *list[NPH_POP_KNOBS];
    s->context = nph_test_context(threads);
    NphStatus status = nph_scene_parse(s->context, yaml, strlen(yaml), "test.yaml", nph_test_path("reference/scenes"), &s->scene);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    nph_render_options_default(&options);
    options.method = "principal_ordinates";
    options.precision = 64;
    snprintf(words, sizeof words, "%s", knobs);
    for (char *word = strtok(words, " "); word; word = strtok(NULL, " ")) list[options.knob_count++] = word;
    options.knobs = list;
    status = nph_job_make(s->context, s->scene, &options, &method, &s->job);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    status = nph_pop_solver_open(&s->job, &s->solver);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
}

static inline void solution_close(Solution *s) {
    nph_pop_solver_close(&s->solver);
    nph_scene_free(s->context, s->scene);
    nph_test_context_close(s->context);
}

/* Stages [first, last] once each, where this scene has them; propagation with all its iterations, the residuum `spreads` times. */
static inline void solve(Solution *s, NphPopStage first, NphPopStage last, int spreads) {
    for (int stage = (int)first; stage <= (int)last; stage++) {
        if (!nph_pop_has(&s->solver, (NphPopStage)stage)) continue;
        for (int k = 0; k < (stage == NPH_POP_SPREAD ? spreads : 1); k++) ck_assert_int_eq(nph_pop_step(&s->solver, (NphPopStage)stage), NPH_OK);
    }
}

static inline const double *ordinate_of(const Solution *s, int number) { return (const double *)s->solver.arrays.ordinate + number * NPH_POP_ROW; }

static inline RPopGrid grid_of(const Solution *s, int number) { return r_pop_grid(s->solver.scene, ordinate_of(s, number), number); }

static inline double mean_of(const NphImage *image, const char *channel) {
    double sum = 0.0;
    for (int64_t i = 0; i < (int64_t)image->width * image->height; i++) sum += (double)nph_image_channel(image, channel)->pixels[i];
    return sum / (double)image->width / (double)image->height;
}

static inline void render(const char *yaml, int precision, int threads, const char *knobs, RenderCase *out) {
    NphRenderOptions options = render_options(16, precision);
    static char words[512];
    static const char *list[NPH_POP_KNOBS];
    snprintf(words, sizeof words, "%s", knobs);
    for (char *word = strtok(words, " "); word; word = strtok(NULL, " ")) list[options.knob_count++] = word;
    options.method = "principal_ordinates";
    options.knobs = list;
    render_case(out, yaml, &options, threads);
}

#define CAMERA "resolution: [16, 16], position: [-2, -2, 0.5], look_at: [0.5, 0.5, 0.5], fov: 30"
#define SCENE(camera, medium, lights) "nephos: 1\ncamera: {" camera "}\nmedia:\n  - {" medium "}\nlights:\n" lights
#define CUBE(extinction, albedo, g) "box: [[0, 0, 0], [1, 1, 1]], extinction: " extinction ", albedo: " albedo ", phase: {type: hg, g: " g "}"
#define SUN "  - {type: sun, direction: [-1, 0.3, 0.2], irradiance: 2}\n"
#define WHITE "  - {type: constant, radiance: 1}\n"
#define PLUME "density: {file: ../data/sphere/sphere.npy, box: [[0, 0, 0], [1, 1, 1]]}, extinction: 0.08, albedo: 0.95, phase: {type: hg, g: 0.7}"
#define POINT "  - {type: point, position: [0.5, 0.5, 0.5], intensity: 1}\n"

#endif
