/* SPDX-License-Identifier: Apache-2.0
 *
 * Temporally coherent photon mapping against closed forms and the path tracer: the fluence of its cells, its ledger, what it
 * promises about bytes, and extremes. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "../render_case.h"
#include "core/memory.h"
#include "harness.h"
#include "method/job.h"
#include "method/temporal_photons/tpm_cache.h"

#define PI 3.14159265358979323846

/* A scene ready to make caches. */
typedef struct Cache {
    NphContext *context;
    NphScene *scene;
    NphJob job;
    NphTpmChoice choice;
    void *memory;
    NphTpmCache cache;
} Cache;

static void cache_open(Cache *c, const char *yaml, int precision, int threads, const char *knobs) {
    const NphMethod *method = NULL;
    NphRenderOptions options;
    NphTpmKernels kernels;
    char words[1024];
    const char *list[NPH_TPM_KNOBS];
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
    ck_assert_int_eq(nph_tpm_choose(&c->job, &c->choice), NPH_OK);
    nph_tpm_kernels(precision, nph_context_isa(c->context), &kernels);
    ck_assert_int_eq(nph_alloc(c->context, kernels.scene_bytes(0), 1, "scene", &c->memory), NPH_OK);
    kernels.prepare(&c->job, &c->choice, c->memory);
    ck_assert_int_eq(nph_tpm_cache_open(&c->job, &c->choice, c->memory, &c->cache), NPH_OK);
}

static void cache_close(Cache *c) {
    nph_tpm_cache_close(&c->cache);
    nph_free(c->context, c->memory);
    nph_scene_free(c->context, c->scene);
    nph_test_context_close(c->context);
}

static double value_of(const Cache *c, const void *grid, int64_t cell, int field) {
    int64_t at = cell * NPH_TPM_FIELDS + field;
    return c->job.precision == 32 ? (double)((const float *)grid)[at] : ((const double *)grid)[at];
}

static double fluence_of(const Cache *c, int64_t cell) {
    return value_of(c, c->cache.coarse, cell, NPH_TPM_I_SUN) + value_of(c, c->cache.coarse, cell, NPH_TPM_I_SKY);
}

/* Means over caches with their errors; entry `cells` is the mean of all cells. */
enum { MOST = 512 };
typedef struct Means {
    int cells;
    double mean[MOST + 1], variance[MOST + 1]; /* of the mean */
} Means;

static void measure(Cache *c, int caches, Means *out) {
    double squares[MOST + 1] = {0.0};
    memset(out, 0, sizeof *out);
    out->cells = (int)nph_tpm_cells(c->choice.cells);
    ck_assert_int_le(out->cells, MOST);
    for (uint32_t s = 0; s < (uint32_t)caches; s++) {
        double all = 0.0;
        ck_assert_int_eq(nph_tpm_cache_make(&c->cache, s), NPH_OK);
        for (int i = 0; i <= out->cells; i++) {
            double value = i < out->cells ? fluence_of(c, i) : all / out->cells;
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
static void compare(const char *name, const Means *ours, const Means *truth, double precise) {
    double most = 0.0, sum = 0.0;
    int n = ours->cells;
    for (int i = 0; i < n; i++) {
        double z = (ours->mean[i] - truth->mean[i]) / sqrt(ours->variance[i] + truth->variance[i] + 1e-12 * truth->mean[i] * truth->mean[i]);
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

START_TEST(in_a_white_furnace_every_cell_has_four_pi) {
    for (int precision = 32; precision <= 64; precision += 32) {
        Cache c;
        Means ours, truth = {.cells = 64};
        for (int i = 0; i <= 64; i++) truth.mean[i] = 4.0 * PI;
        cache_open(&c, SCENE(CAMERA, CUBE("3", "1", "0.6"), WHITE), precision, 2, PLAIN "tpm.photons=8000 tpm.generations=4");
        measure(&c, 24, &ours);
        compare("furnace", &ours, &truth, 0.003);
        cache_close(&c);
    }
}
END_TEST

START_TEST(a_sun_without_scattering_falls_by_beers_law_and_keeps_its_direction) {
    Cache c;
    Means ours, truth = {.cells = 64};
    cache_open(&c, SCENE(CAMERA, CUBE("3", "1e-9", "0.6"), SUN), 64, 2, PLAIN "tpm.photons=8000 tpm.generations=4 tpm.threshold=0");
    for (int i = 0; i <= 64; i++) {
        double from = i < 64 ? 0.25 * (i % 4) : 0.0, to = i < 64 ? from + 0.25 : 1.0;
        truth.mean[i] = 2.0 * (exp(-3.0 * from) - exp(-3.0 * to)) / (3.0 * (to - from));
    }
    measure(&c, 24, &ours);
    compare("Beer", &ours, &truth, 0.003);
    for (int i = 0; i < 64; i++) {
        ck_assert_double_eq_tol(value_of(&c, c.cache.coarse, i, NPH_TPM_I_G), 1.0, 1e-6);
        ck_assert_double_eq_tol(value_of(&c, c.cache.coarse, i, NPH_TPM_I_DEPTH), 0.0, 1e-6);
    }
    cache_close(&c);
}
END_TEST

/* What the path tracer finds on the same cells of the unit cube: fluence on three Gauss planes of every layer. */
static void trace_cells(const char *scene, int spp, Means *out) {
    static const double at[3] = {0.11270166537925831, 0.5, 0.88729833462074169}, weight[3] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
    memset(out, 0, sizeof *out);
    out->cells = 64;
    for (int z = 0; z < 4; z++)
        for (int k = 0; k < 3; k++) {
            RenderCase path;
            NphRenderOptions options = render_options(spp, 64);
            options.seed_given = 1;
            options.seed = (uint32_t)(100 + 3 * z + k);
            render_case(&path, render_text(scene, 0.25 * (z + at[k])), &options, 2);
            const NphChannel *mean = nph_image_channel(&path.image, "R"), *variance = nph_image_channel(&path.image, "Variance.R");
            for (int i = 0; i < 16; i++) {
                int cell = (z * 4 + 3 - i / 4) * 4 + i % 4;
                out->mean[cell] += weight[k] * (double)mean->pixels[i];
                out->variance[cell] += weight[k] * weight[k] * (double)variance->pixels[i];
            }
            render_free(&path);
        }
    for (int i = 0; i < 64; i++) {
        out->mean[64] += out->mean[i] / 64.0;
        out->variance[64] += out->variance[i] / 4096.0;
    }
}

#define PROBE "type: fluence, resolution: [4, 4], position: [0.5, 0.5, %.17g], direction: [0, 0, -1], up: [0, 1, 0], extent: 1"

static void against_path(const char *name, const char *scene, const char *probe, int spp) {
    Cache c;
    Means ours, truth;
    cache_open(&c, scene, 32, 2, PLAIN "tpm.photons=10000 tpm.generations=5 tpm.threshold=0");
    measure(&c, 24, &ours);
    trace_cells(probe, spp, &truth);
    compare(name, &ours, &truth, 0.005);
    cache_close(&c);
}

#define AGAINST(name, spp, medium, lights) against_path(name, SCENE(CAMERA, medium, lights), SCENE(PROBE, medium, lights), spp)

START_TEST(without_shortcuts_the_fluence_of_cells_is_that_of_the_path_tracer) {
    if (!nph_test_statistics("temporal photons against path")) return;
    AGAINST("cube, g 0", 4096, CUBE("4", "1", "0"), SUN);
    AGAINST("cube, g 0.7", 4096, CUBE("4", "1", "0.7"), SUN);
    AGAINST("cube, g 0.96", 4096, CUBE("20", "0.99", "0.96"), SUN WHITE);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, in_a_white_furnace_every_cell_has_four_pi);
    tcase_add_test(cases, a_sun_without_scattering_falls_by_beers_law_and_keeps_its_direction);
    tcase_add_test(cases, without_shortcuts_the_fluence_of_cells_is_that_of_the_path_tracer);
}

int main(void) { return nph_test_main("temporal_photons", fill); }
