/* SPDX-License-Identifier: Apache-2.0
 *
 * Caches of temporal photons without pictures, their fluence and what it should be, and scenes. */
#ifndef NPH_TESTS_METHOD_TPM_CASE_H
#define NPH_TESTS_METHOD_TPM_CASE_H

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "../render_case.h"
#include "core/memory.h"
#include "harness.h"
#include "method/job.h"
#include "method/temporal_photons/tpm_cache.h"

#define PI 3.14159265358979323846

enum { MOST = 512 };

/* A scene ready to make caches. */
typedef struct Cache {
    NphContext *context;
    NphScene *scene;
    NphJob job;
    NphTpmChoice choice;
    void *memory;
    NphTpmCache cache;
    unsigned char left_out[MOST]; /* cells that nobody looks at */
} Cache;

static inline void cache_open(Cache *c, const char *yaml, int precision, int threads, const char *knobs) {
    const NphMethod *method = NULL;
    NphRenderOptions options;
    NphTpmKernels kernels;
    char words[1024];
    const char *list[NPH_TPM_KNOBS];
    memset(c->left_out, 0, sizeof c->left_out);
    c->context = nph_test_context(threads);
    NphStatus status = nph_scene_parse(c->context, yaml, strlen(yaml), "test.yaml", nph_test_path("reference/scenes"), &c->scene);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    nph_render_options_default(&options);
    options.method = "temporal_photons";
    options.precision = precision;
    snprintf(words, sizeof words, "%s", knobs);
    for (char *word = strtok(words, " "); word; word = strtok(NULL, " ")) list[options.knob_count++] = word;
    options.knobs = list;
    status = nph_job_make(c->context, c->scene, &options, &method, &c->job);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    ck_assert_int_eq(nph_tpm_choose(&c->job, &c->choice, NULL), NPH_OK);
    nph_tpm_kernels(precision, nph_context_isa(c->context), &kernels);
    ck_assert_int_eq(nph_alloc(c->context, kernels.scene_bytes(0), 1, "scene", &c->memory), NPH_OK);
    kernels.prepare(&c->job, &c->choice, c->memory);
    ck_assert_int_eq(nph_tpm_cache_open(&c->job, c->memory, 0, &c->cache), NPH_OK);
}

static inline void cache_close(Cache *c) {
    nph_tpm_cache_close(&c->cache);
    nph_free(c->context, c->memory);
    nph_scene_free(c->context, c->scene);
    nph_test_context_close(c->context);
}

static inline double value_of(const Cache *c, const void *grid, int64_t cell, int field) {
    int64_t at = cell * NPH_TPM_FIELDS + field;
    return c->job.precision == 32 ? (double)((const float *)grid)[at] : ((const double *)grid)[at];
}

static inline double fluence_of(const Cache *c, int64_t cell) {
    return value_of(c, c->cache.coarse, cell, NPH_TPM_I_SUN) + value_of(c, c->cache.coarse, cell, NPH_TPM_I_SKY);
}

/* Means over caches with their errors; entry `cells` is the mean of all cells. */
typedef struct Means {
    int cells;
    double mean[MOST + 1], variance[MOST + 1]; /* of the mean */
} Means;

static inline void measure(Cache *c, int caches, Means *out) {
    double squares[MOST + 1] = {0.0};
    memset(out, 0, sizeof *out);
    out->cells = (int)nph_tpm_cells(c->choice.cells);
    ck_assert_int_le(out->cells, MOST);
    for (uint32_t s = 0; s < (uint32_t)caches; s++) {
        double all = 0.0;
        ck_assert_int_eq(nph_tpm_cache_make(&c->cache, s), NPH_OK);
        for (int i = 0; i <= out->cells; i++) {
            double value = i == out->cells ? all / out->cells : c->left_out[i] ? 0.0 : fluence_of(c, i);
            all += value;
            out->mean[i] += value;
            squares[i] += value * value;
        }
    }
    for (int i = 0; i <= out->cells; i++) {
        out->mean[i] /= caches;
        out->variance[i] = (squares[i] / caches - out->mean[i] * out->mean[i]) / (caches - 1);
    }
}

/* Both within their errors: every cell, and all together, whose error must be below `precise`. */
static inline void compare(const char *name, const Means *ours, const Means *truth, double precise) {
    double most = 0.0, sum = 0.0;
    int n = ours->cells;
    for (int i = 0; i < n; i++) {
        double square = ours->variance[i] + truth->variance[i] + 1e-12 * truth->mean[i] * truth->mean[i];
        double z = square > 0.0 ? (ours->mean[i] - truth->mean[i]) / sqrt(square) : 0.0;
        most = fmax(most, fabs(z));
        sum += z * z;
    }
    double error = sqrt(ours->variance[n] + truth->variance[n]), off = ours->mean[n] - truth->mean[n];
    printf("    %s: mean %.5f +- %.5f, truth %.5f +- %.5f (%+.2f%%); of %d cells largest |z| %.2f, RMS %.2f\n", name, ours->mean[n],
           sqrt(ours->variance[n]), truth->mean[n], sqrt(truth->variance[n]), 100.0 * off / truth->mean[n], n, most, sqrt(sum / n));
    ck_assert_msg(error < precise * truth->mean[n], "%s: error %g", name, error / truth->mean[n]);
    ck_assert_msg(fabs(off) < 3.5 * error + 2e-6 * truth->mean[n], "%s: %g is not %g +- %g", name, ours->mean[n], truth->mean[n], error);
    ck_assert_msg(most < 5.0, "%s: a cell is %g errors off", name, most);
}

#define SCENE(camera, medium, lights) \
    "nephos: 1\ncamera: {" camera "}\nmedia:\n  - {" medium "}\nlights:\n" lights
#define CAMERA "resolution: [16, 16], position: [-2, -2, 0.5], look_at: [0.5, 0.5, 0.5], fov: 30"
#define CUBE(extinction, albedo, g) \
    "box: [[0, 0, 0], [1, 1, 1]], extinction: " extinction ", albedo: " albedo ", phase: {type: hg, g: " g "}"
#define SUN "  - {type: sun, direction: [-1, 0, 0], irradiance: 2}\n"
#define WHITE "  - {type: constant, radiance: 1}\n"
#define PLAIN "tpm.similarity=0 tpm.cells_x=4 tpm.cells_y=4 tpm.cells_z=4 "

/* A scene whose frames are rendered. */
typedef struct Frames {
    NphContext *context;
    NphScene *scene;
    NphRenderOptions options;
} Frames;

static inline void frames_open(Frames *frames, const char *yaml, int precision, int threads, int count, const char *const *knobs) {
    frames->context = nph_test_context(threads);
    NphStatus status = nph_scene_parse(frames->context, yaml, strlen(yaml), "test.yaml", nph_test_path("reference/scenes"), &frames->scene);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    frames->options = render_options(16, precision);
    frames->options.method = "temporal_photons";
    frames->options.knob_count = count;
    frames->options.knobs = knobs;
}

static inline void frames_close(Frames *frames) {
    nph_scene_free(frames->context, frames->scene);
    nph_test_context_close(frames->context);
}

static inline void alone(const Frames *frames, uint32_t frame, NphImage *image, NphRenderStatistics *statistics) {
    NphRenderOptions options = frames->options;
    NphScene *other = NULL;
    NphFilm *film = NULL;
    options.frame = frame;
    if (nph_scene_is_animated(frames->scene)) ck_assert_int_eq(nph_scene_at_frame(frames->context, frames->scene, frame, &other), NPH_OK);
    NphStatus status = nph_render(frames->context, other ? other : frames->scene, &options, &film, statistics);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    ck_assert_int_eq(nph_film_image(frames->context, film, image), NPH_OK);
    nph_film_free(frames->context, film);
    nph_scene_free(frames->context, other);
}

static inline void same_image(const NphImage *a, const NphImage *b, uint32_t frame) {
    ck_assert_int_eq(a->channel_count, b->channel_count);
    for (int c = 0; c < a->channel_count; c++)
        ck_assert_msg(memcmp(a->channels[c].pixels, b->channels[c].pixels, sizeof(float) * (size_t)a->width * (size_t)a->height) == 0,
                      "frame %u: %s differs", (unsigned)frame, a->channels[c].name);
}

static inline int64_t photons_of(const NphRenderStatistics *statistics) { return statistics->stages[NPH_TPM_TRACE].items; }

static inline double mean_of(const NphImage *image) {
    double sum = 0.0;
    for (int64_t i = 0; i < (int64_t)image->width * image->height; i++) sum += (double)image->channels[0].pixels[i];
    return sum / (double)image->width / (double)image->height;
}

#endif
