/* SPDX-License-Identifier: Apache-2.0
 *
 * A scene ready for single rays of truth/single, without pixels: test_single.c. */
#ifndef NPH_TESTS_SINGLE_CASE_H
#define NPH_TESTS_SINGLE_CASE_H

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "harness.h"
#include "method/job.h"
#include "optics/cie.h"
#include "optics/wavelengths.h"
#include "truth/single/single_profile.h"
#include "truth/single/single_walk.h"

#define CAMERA "nephos: 1\ncamera: {resolution: [4, 4], position: [-2, -1.5, 1.2], look_at: [0.5, 0.5, 0.5], fov: 40}\n"
#define PI 3.14159265358979323846

typedef struct Case {
    NphContext *context;
    NphScene *scene;
    NphSingleScene *single;
    NphSingleScratch *scratch;
    void *memory;
} Case;

static const char *text(const char *format, ...) {
    static char buffers[8][2048];
    static int next;
    char *buffer = buffers[next++ % 8];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(buffer, sizeof buffers[0], format, arguments);
    va_end(arguments);
    return buffer;
}

static void begin(Case *c, const char *yaml, double tolerance, int mode) {
    const char *knobs[] = {text("single.tolerance=%g", tolerance), mode ? "single.mode=1" : "single.mode=0"};
    NphRenderOptions options;
    const NphMethod *method = NULL;
    NphJob job;
    memset(c, 0, sizeof *c);
    c->context = nph_test_context(1);
    NphStatus status = nph_scene_parse(c->context, yaml, strlen(yaml), "test.yaml", nph_test_path("reference/scenes"), &c->scene);
    ck_assert_msg(status == NPH_OK, "%s\n%s", nph_test_messages(), yaml);
    nph_render_options_default(&options);
    options.method = "single";
    options.knob_count = 2;
    options.knobs = knobs;
    ck_assert_msg(nph_job_make(c->context, c->scene, &options, &method, &job) == NPH_OK, "%s", nph_test_messages());
    ck_assert_int_eq(NPH_NEW(c->context, nph_single_groups(&job), "scene", &c->single), NPH_OK);
    ck_assert_int_eq(nph_alloc(c->context, nph_single_scratch_bytes(nph_single_fields(c->scene)), 1, "scratch", &c->memory), NPH_OK);
    nph_single_prepare(&job, c->single);
    nph_single_scratch_layout(c->memory, nph_single_fields(c->scene), &c->scratch);
}

static void end(Case *c) {
    nph_free(c->context, c->memory);
    nph_free(c->context, c->single);
    nph_scene_free(c->context, c->scene);
    nph_test_context_close(c->context);
}

/* The sample of a ray from p along d, in the world. */
static void shoot(Case *c, const double p[3], const double d[3], double fields[NPH_SAMPLE_FIELDS]) {
    NphSingleAsk ask = {0, 0, NULL, NULL};
    RCameraRay ray;
    double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    memset(&ray, 0, sizeof ray);
    for (int a = 0; a < 3; a++) {
        ray.p[a] = ray.at[a] = p[a] - c->single->local.origin[a];
        ray.d[a] = d[a] / length;
    }
    ray.weight = 1.0;
    ray.pdf = -1.0;
    nph_single_march(c->single, c->scratch, &ray, &ask, fields);
}

static double radiance(Case *c, const double p[3], const double d[3]) {
    double fields[NPH_SAMPLE_FIELDS];
    shoot(c, p, d, fields);
    return fields[NPH_SAMPLE_L0];
}

/* Rays through a scene, the same everywhere. */
static void some_ray(int i, double p[3], double d[3]) {
    double a = 0.7 * i, b = 2.3 * i + 1.0;
    for (int k = 0; k < 3; k++) p[k] = 0.5;
    d[0] = cos(a) * cos(0.5 * b);
    d[1] = sin(a) * cos(0.5 * b);
    d[2] = sin(0.5 * b);
    for (int k = 0; k < 3; k++) p[k] += -2.0 * d[k] + 0.25 * sin(b + 1.7 * k);
}

#endif
