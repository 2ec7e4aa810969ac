/* SPDX-License-Identifier: Apache-2.0
 *
 * The batches of truth/path against the replay, sample by sample and bit by bit, in both precisions and at every vector
 * level of this machine. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "harness.h"
#include "method/job.h"
#include "truth/path/path.h"

#define CAMERA "nephos: 1\ncamera: {type: perspective, resolution: [20, 18], position: [-2, -1.5, 1.2], look_at: [0.5, 0.5, 0.5], fov: 40}\n"

#define PERIODIC CAMERA "periodic: {x: [0.1, 0.8], y: [0, 1]}\nmedia:\n"

static const char *const scenes[] = {
    /* grey, homogeneous */
    CAMERA "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 6, albedo: 0.95, phase: {type: hg, g: 0.8}}\n"
           "lights:\n  - {type: sun, direction: [-1, 0.2, 0.3], irradiance: 3}\n  - {type: constant, radiance: 0.2}\n",
    /* chromatic, overlapping, a grid among them; disc sun and point light */
    CAMERA "media:\n"
           "  - {box: [[0, 0, 0], [1, 1, 1]], extinction: [2, 5, 0], albedo: [0.9, 1, 0.5], phase: {type: two_lobe, g: 0.8, g2: -0.3, weight: 0.7}}\n"
           "  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: [20, 30, 9], albedo: 0.99, phase: {type: rayleigh},\n"
           "     transform: [{scale: 0.4}, {rotate: {axis: [1, 2, 3], angle: 40}}, {translate: [0.5, 0.4, 0.5]}]}\n"
           "lights:\n  - {type: sun, direction: [1, 0.2, 1], irradiance: [3, 2, 1], angular_diameter: 5}\n"
           "  - {type: point, position: [0.5, 0.5, 1.5], intensity: [1, 2, 3]}\n",
    /* a grid alone, coloured sky */
    CAMERA "media:\n"
           "  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: 40, albedo: 1, phase: {type: hg, g: 0.85}}\n"
           "lights:\n  - {type: sun, direction: [1, -1, 1], irradiance: 3}\n  - {type: constant, radiance: [0.1, 0.2, 0.3], hemisphere: upper}\n",
    /* grey media whose flights are weighed: light is only met by leaving */
    CAMERA "media:\n  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: 20, albedo: 0.6, phase: {type: two_lobe, g: 0.8, g2: -0.3, weight: 0.7}}\n"
           "lights:\n  - {type: constant, radiance: [0.1, 0.2, 0.3]}\n",
    CAMERA "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 3, albedo: 0.1, phase: {type: rayleigh}}\n"
           "lights:\n  - {type: constant, radiance: 1}\n",
    /* camera rays that are split: some collide always, some oftener than they would */
    "nephos: 1\ncamera: {type: perspective, resolution: [24, 18], position: [-1, -0.7, 3], look_at: [0.5, 0.5, 0.5], fov: 8}\n"
    "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 0.3, albedo: 0.9, phase: {type: hg, g: 0.8}}\n"
    "lights:\n  - {type: sun, direction: [1, 0.2, 1], irradiance: [3, 2, 1]}\n  - {type: constant, radiance: [0.1, 0.2, 0.3], hemisphere: upper}\n",
    "nephos: 1\ncamera: {type: flux, position: [0, 0, 1.1], direction: [0, 0, -1], extent: 1, resolution: [24, 18], up: [0, 1, 0]}\n"
    "media:\n  - {layer: [0, 1], extinction: 0.2, albedo: 0.2, phase: {type: rayleigh}}\n"
    "lights:\n  - {type: sun, direction: [1, 0.2, 1], irradiance: 3}\n  - {type: constant, radiance: 0.5, hemisphere: upper}\n",
    /* a table with a peak, Draine's with and without one, alone and overlapping in colour */
    CAMERA "media:\n  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: 20, albedo: 0.99, phase: {type: tabulated, file: ../data/gpl/c1_phase.txt}}\n"
           "lights:\n  - {type: sun, direction: [1, -1, 1], irradiance: 3}\n  - {type: constant, radiance: 0.1}\n",
    CAMERA "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 6, albedo: 0.95, phase: {type: draine, g: 0.9, alpha: 20}}\n"
           "lights:\n  - {type: sun, direction: [-1, 0.2, 0.3], irradiance: 3}\n",
    CAMERA "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 6, albedo: 0.95, phase: {type: draine, g: 0.1, alpha: 0.5}}\n"
           "lights:\n  - {type: sun, direction: [-1, 0.2, 0.3], irradiance: 3}\n",
    CAMERA "media:\n"
           "  - {box: [[0, 0, 0], [1, 1, 1]], extinction: [2, 5, 0], albedo: [0.9, 1, 0.5], phase: {type: draine, g: -0.5, alpha: 2}}\n"
           "  - {box: [[0.2, 0, 0], [1.5, 0.7, 1]], extinction: [2, 5, 0], albedo: 1, phase: {type: tabulated, file: ../data/gpl/c1_phase.txt}}\n"
           "lights:\n  - {type: sun, direction: [1, 0.2, 1], irradiance: [3, 2, 1], angular_diameter: 5}\n"
           "  - {type: point, position: [0.5, 0.5, 1.5], intensity: [1, 2, 3]}\n",
    /* air within the scene, flat over a plane and around a globe, with a cloud in it and a lamp */
    CAMERA "media:\n  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: [20, 30, 9], albedo: 0.99, phase: {type: hg, g: 0.8}}\n"
           "air: {type: exponential, where: within, extinction: [0.05, 0.1, 0.3], scale_height: 5, ground: -3, aerosol: {extinction: 0.2, scale_height: 1}}\n"
           "lights:\n  - {type: sun, direction: [1, 0.2, 1], irradiance: [3, 2, 1]}\n  - {type: point, position: [0.5, 0.5, 1.5], intensity: 1}\n"
           "surfaces: [{plane: -3, albedo: [0.2, 0.3, 0.1]}]\n",
    CAMERA "air: {type: table, where: within, ground: -1, ground_albedo: [0.5, 0.4, 0.3], aerosol: {turbidity: 30, phase: {type: tabulated, file: ../data/gpl/c1_phase.txt}}}\n"
           "lights:\n  - {type: sun, direction: [1, 0.2, 1], irradiance: 3, angular_diameter: 0.53}\n  - {type: constant, radiance: 0.1}\n",
    /* wavelengths: two groups, the last one with a repeated channel; all kinds of light, a surface, a grid */
    CAMERA "wavelengths: [420, 480, 550, 600, 690]\n"
           "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: [8, 6, 4, 3, 2], albedo: [1, 0.9, 0.8, 0.9, 1], phase: {type: hg, g: 0.8}}\n"
           "  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: [5, 7, 20, 1, 0], albedo: 0.99,\n"
           "     transform: [{scale: 0.4}, {translate: [0.5, 0.4, 0.5]}]}\n"
           "lights:\n  - {type: sun, direction: [1, 0.2, 1], irradiance: [3, 2, 1, 2, 3]}\n"
           "  - {type: sun, direction: [-1, 0.5, 1], irradiance: [3, 2, 1, 2, 3], angular_diameter: 9}\n"
           "  - {type: point, position: [0.5, 0.5, 1.5], intensity: [1, 2, 3, 4, 5]}\n"
           "  - {type: constant, radiance: [0.1, 0.2, 0.3, 0.2, 0.1]}\n"
           "surfaces:\n  - {plane: -0.2, albedo: [0, 0.2, 0.4, 0.6, 0.8]}\n",
    /* wavelengths: a single group of which one is repeated, seen by a flux sensor */
    "nephos: 1\nwavelengths: [450, 610]\n"
    "camera: {type: flux, resolution: [20, 18], position: [0, 0, 2.5], direction: [0, 0, -1], up: [0, 1, 0], extent: 1}\n"
    "media:\n  - {layer: [0, 2], extinction: [1.5, 0.5], albedo: 0.9, phase: {type: rayleigh}}\n"
    "lights:\n  - {type: sun, elevation: 40, azimuth: 10, irradiance: [1, 2]}\n",
    /* a layer seen by a flux sensor */
    "nephos: 1\ncamera: {type: flux, resolution: [20, 18], position: [0, 0, 2.5], direction: [0, 0, -1], up: [0, 1, 0], extent: 1}\n"
    "media:\n  - {layer: [0, 2], extinction: 1.5, albedo: 0.9, phase: {type: isotropic}}\n"
    "lights:\n  - {type: sun, elevation: 40, azimuth: 10, irradiance: 1}\n  - {type: constant, radiance: 0.3}\n",
    /* a grid over a plane, a mesh within it */
    CAMERA "media:\n"
           "  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: 40, albedo: 0.99, phase: {type: hg, g: 0.85}}\n"
           "surfaces:\n  - {plane: -0.1, albedo: 0.7}\n"
           "  - {mesh: ../data/mesh/suzanne.obj, albedo: 0.4, transform: [{scale: 0.3}, {translate: [0.3, 0.3, 0.4]}]}\n"
           "lights:\n  - {type: sun, direction: [1, -1, 1], irradiance: 3}\n  - {type: constant, radiance: [0.1, 0.2, 0.3], hemisphere: upper}\n",
    /* coloured surfaces make grey media three channels */
    CAMERA "media:\n"
           "  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 2, albedo: 0.9, phase: {type: two_lobe, g: 0.8, g2: -0.3, weight: 0.7}}\n"
           "  - {layer: [-3, 0.2], extinction: [0.1, 0.2, 0], albedo: 0.5, phase: {type: rayleigh}}\n"
           "surfaces:\n  - {plane: -1, albedo: [0.1, 0.5, 1]}\n  - {plane: -2, albedo: 1}\n"
           "  - {mesh: ../data/mesh/teapot.obj, albedo: [1, 0.5, 0.2], transform: [{scale: 0.15}, {translate: [0.5, 0.5, 0.2]}]}\n"
           "lights:\n  - {type: sun, direction: [1, 0.2, 1], irradiance: [3, 2, 1], angular_diameter: 5}\n"
           "  - {type: point, position: [0.5, 0.5, 1.5], intensity: [1, 2, 3]}\n",
    /* weighed flights that end at surfaces */
    CAMERA "media:\n  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: 20, albedo: 0.6}\n"
           "surfaces:\n  - {plane: 0.1, albedo: 0.9}\n"
           "lights:\n  - {type: constant, radiance: [0.1, 0.2, 0.3]}\n",
    /* a plume that glows, grey */
    CAMERA "media:\n  - {density: {file: ../data/vdb/plume32_f20_BLOSC_float32.vdb}, extinction: 20, albedo: 0.6, phase: {type: hg, g: 0.5},\n"
           "     transform: [{scale: 0.4}], emission: {type: blackbody, scale: 2500}}\n"
           "lights:\n  - {type: sun, direction: [1, -1, 1], irradiance: 3}\n",
    /* channels that differ, emission of boxes and grids among them, and a plane */
    CAMERA "media:\n"
           "  - {box: [[0, 0, 0], [1, 1, 1]], extinction: [2, 5, 0], albedo: [0.9, 1, 0.5], emission: {type: volume, radiance: [1, 2, 3]}}\n"
           "  - {density: {file: ../data/vdb/plume32_f20_BLOSC_float32.vdb}, extinction: [20, 30, 9], albedo: 0.7, phase: {type: rayleigh},\n"
           "     transform: [{scale: 0.4}], emission: {type: volume, radiance: [3, 2, 1], grid: temperature}}\n"
           "surfaces:\n  - {plane: -0.1, albedo: [0.7, 0.8, 0.9]}\n",
    /* point lights in media: grey, and where channels differ, with a plane */
    CAMERA "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 4, albedo: 0.9, phase: {type: hg, g: 0.5}}\n"
           "lights:\n  - {type: point, position: [0.5, 0.5, 0.5], intensity: 1}\n",
    CAMERA "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: [2, 5, 1], albedo: [0.9, 1, 0.5]}\n"
           "  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: [20, 30, 9], albedo: 0.99, phase: {type: rayleigh},\n"
           "     transform: [{scale: 0.4}, {translate: [0.5, 0.4, 0.5]}]}\n"
           "surfaces:\n  - {plane: 0.3, albedo: 0.7}\n"
           "lights:\n  - {type: point, position: [0.5, 0.5, 0.6], intensity: [1, 2, 3]}\n  - {type: constant, radiance: 0.1}\n",
    /* emission between sides that repeat, channels that differ */
    CAMERA "periodic: {x: [0, 1.5]}\nmedia:\n"
           "  - {density: {file: ../data/vdb/plume32_f20_BLOSC_float32.vdb}, extinction: [20, 30, 9], albedo: 0.7,\n"
           "     transform: [{scale: 0.4}], emission: {type: blackbody, scale: 2000}}\n"
           "  - {box: [[0.5, 0, 0], [0.7, 1, 0.5]], extinction: [2, 5, 0], albedo: 0.5, emission: {type: volume, radiance: [1, 2, 3]}}\n",
    /* one box that emits, alone */
    CAMERA "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: [2, 5, 0], albedo: 0.5, emission: {type: blackbody, temperature: 3000}}\n",
    /* a flux sensor between a plane and a mesh, in a layer */
    "nephos: 1\ncamera: {type: flux, resolution: [20, 18], position: [0, 0, 0.5], direction: [0.1, 0, 1], up: [0, 1, 0], extent: 1}\n"
    "media:\n  - {layer: [0, 2], extinction: 1.5, albedo: 0.9, phase: {type: hg, g: 0.5}}\n"
    "surfaces:\n  - {plane: 0.2, albedo: 0.8}\n  - {mesh: ../data/mesh/suzanne.obj, transform: [{scale: 0.3}, {translate: [0, 0, 1]}]}\n"
    "lights:\n  - {type: sun, elevation: 40, azimuth: 10, irradiance: 1}\n  - {type: constant, radiance: 0.3}\n",
    /* fluence inside a medium, coloured media and a sun's disc; radiance along one direction; fisheye with dark corners */
    "nephos: 1\ncamera: {type: fluence, resolution: [20, 18], position: [0.5, 0.5, 0.5], direction: [0, 1, 0], extent: 1.5}\n"
    "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: [2, 5, 0], albedo: [0.9, 1, 0.5], phase: {type: hg, g: 0.8}}\n"
    "lights:\n  - {type: sun, elevation: 40, azimuth: 10, irradiance: 1, angular_diameter: 3}\n  - {type: constant, radiance: 0.3}\n",
    "nephos: 1\ncamera: {type: radiance, resolution: [20, 18], position: [0.5, 0.5, 0.5], direction: [0, 1, 0], extent: 1.5, seen: [1, 2, 3]}\n"
    "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 3, albedo: 0.9}\nlights:\n  - {type: sun, elevation: 40, azimuth: 10, irradiance: 1}\n",
    "nephos: 1\ncamera: {type: fisheye, resolution: [20, 18], position: [0.5, 0.5, 0.2], direction: [0, 0.1, 1], fov: 270}\n"
    "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 3, albedo: 0.9}\nlights:\n  - {type: sun, elevation: 40, azimuth: 10, irradiance: 1}\n",
    /* sides that repeat: a rotated grid cut to the period, seen aslant under a low sun; the same weighed; coloured and mixed */
    PERIODIC "  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: 8, albedo: 0.95, phase: {type: hg, g: 0.85},\n"
             "     transform: [{scale: 0.4}, {rotate: {axis: [1, 2, 3], angle: 40}}, {translate: [0.5, 0.4, 0.5]}]}\n"
             "lights:\n  - {type: sun, elevation: 9, azimuth: 33, irradiance: 3}\n",
    PERIODIC "  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: 8, albedo: 0.5, phase: {type: hg, g: 0.85},\n"
             "     transform: [{scale: 0.3}, {translate: [0.8, 0.4, 0.5]}]}\nlights:\n  - {type: constant, radiance: 1}\n",
    PERIODIC "  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: [4, 8, 16], albedo: 0.95,\n"
             "     transform: [{scale: 0.3}, {translate: [0.8, 0.4, 0.5]}]}\n"
             "  - {box: [[0.2, 0, 0], [0.5, 0.3, 1]], extinction: [5, 0, 2], albedo: [0.9, 0, 1], phase: {type: rayleigh},\n"
             "     transform: [{rotate: {axis: [0, 0, 1], angle: 20}}]}\n  - {layer: [0.3, 0.6], extinction: 0.1}\n"
             "lights:\n  - {type: sun, elevation: 9, azimuth: 33, irradiance: 3}\n",
    PERIODIC "  - {density: {file: ../data/cumulus/cumulus_300.zip.nvdb}, extinction: 8, albedo: 0.95, transform: [{scale: 0.4}, {translate: [0.5, 0.4, 0.5]}]}\n"
             "surfaces:\n  - {plane: 0.2, albedo: 0.7}\nlights:\n  - {type: sun, elevation: 20, azimuth: 33, irradiance: 3}\n",
    PERIODIC "  - {box: [[0.2, 0, 0], [0.5, 0.3, 1]], extinction: 5, albedo: 0.9, transform: [{rotate: {axis: [0, 0, 1], angle: 20}}]}\n"
             "lights:\n  - {type: sun, elevation: 9, azimuth: 33, irradiance: 3}\n",
};

/* All stages over one batch, as the method runs them. */
static void run_batch(const NphPathKernels *k, const NphJob *job, const NphPathChoice *choice, NphPathBatch *batch) {
    const NphScene *scene = job->scene;
    int origin[2] = {0, 0}, inside[4] = {0, 0, 16, 16};
    k->begin(batch, origin, inside, 3);
    k->generate(batch);
    for (int l = 0; l < scene->light_count && nph_sensor_gathers(scene->sensor.kind); l++)
        if (choice->transport.sampled[l]) k->shadow(batch, l, 1);
    while (k->count(batch) > 0) {
        k->track(batch);
        if (choice->transport.emission) k->emission(batch);
        for (int l = 0; l < scene->light_count; l++)
            if (choice->near_m[l] > 0.0) k->near_light(batch, l);
        if (choice->transport.channels > 1) k->reweigh(batch);
        k->escape(batch);
        for (int l = 0; l < scene->light_count; l++)
            if (choice->near_m[l] > 0.0) k->around_light(batch, l);
        for (int l = 0; l < scene->light_count; l++)
            if (choice->transport.sampled[l]) k->shadow(batch, l, 0);
        k->scatter(batch);
    }
    NphView split;
    if (k->view(batch, NPH_PATH_COLLIDED, &split)) k->fold(batch);
}

static int64_t differing(const NphPathKernels *k, const NphJob *job, const NphPathChoice *choice) {
    NphContext *context = job->context;
    void *scene = NULL, *memory = NULL;
    ck_assert_int_eq(nph_alloc(context, k->scene_bytes(choice->transport.groups), 1, "scene", &scene), NPH_OK);
    ck_assert_int_eq(nph_alloc(context, k->batch_bytes(), 1, "batch", &memory), NPH_OK);
    k->prepare(job, choice, scene);
    NphPathBatch *batch = NULL;
    k->layout(memory, scene, &batch);
    run_batch(k, job, choice, batch);
    int64_t different = 0, lit = 0;
    for (int id = 0; id < NPH_PATH_BATCH; id++) {
        int pixel[2] = {(id >> 4) & 15, id >> 8};
        double fields[NPH_SAMPLE_FIELDS];
        k->replay(scene, pixel, 3 * NPH_CHUNK + (id & 15), NULL, NULL, fields);
        for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) {
            size_t at = (size_t)f * NPH_PATH_BATCH + (size_t)id;
            double value = job->precision == 32 ? (double)((const float *)k->samples(batch))[at]
                                                : ((const double *)k->samples(batch))[at];
            different += memcmp(&value, &fields[f], sizeof value) != 0;
            lit += f == 0 && value > 0.0;
        }
    }
    ck_assert_int_gt(lit, NPH_PATH_BATCH / 50);
    ck_assert_int_gt(k->tally(batch)->collisions, 500);
    ck_assert_int_eq(k->tally(batch)->violations, 0);
    nph_free(context, scene);
    nph_free(context, memory);
    return different;
}

START_TEST(batches_and_replay_agree_to_the_bit) {
    NphContext *context = nph_test_context(1);
    const char *text = scenes[_i];
    NphScene *scene = NULL;
    NphStatus status = nph_scene_parse(context, text, strlen(text), "test.yaml", nph_test_path("reference/scenes"), &scene);
    ck_assert_msg(status == NPH_OK, "%s", nph_test_messages());
    for (int full = 0; full < 2; full++)
        for (int precision = 32; precision <= 64; precision += 32)
            for (int isa = NPH_ISA_BASE; isa <= (int)nph_context_isa(context); isa++) {
                NphRenderOptions options;
                NphJob job;
                const NphMethod *method = NULL;
                NphPathChoice choice;
                NphPathKernels kernels;
                nph_render_options_default(&options);
                options.precision = precision;
                options.plan_full = full;
                ck_assert_int_eq(nph_job_make(context, scene, &options, &method, &job), NPH_OK);
                nph_path_choose(&job, &choice);
                nph_path_kernels((NphIsa)isa, precision, &kernels);
                int64_t different = differing(&kernels, &job, &choice);
                ck_assert_msg(different == 0, "scene %d f%d %s full %d: %lld values differ", _i, precision,
                              nph_isa_name((NphIsa)isa), full, (long long)different);
            }
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

static void count_line(void *user, const char *text) {
    int *lines = user;
    ck_assert_uint_gt(strlen(text), 3);
    ++*lines;
}

START_TEST(the_replay_tells_every_event) {
    NphContext *context = nph_test_context(1);
    NphScene *scene = NULL;
    ck_assert_int_eq(nph_scene_parse(context, scenes[0], strlen(scenes[0]), "test.yaml", ".", &scene), NPH_OK);
    NphRenderOptions options;
    nph_render_options_default(&options);
    int lines = 0;
    ck_assert_int_eq(nph_replay(context, scene, &options, 10, 9, 5, count_line, &lines), NPH_OK);
    ck_assert_int_ge(lines, 3);
    ck_assert_int_eq(nph_replay(context, scene, &options, 20, 9, 5, count_line, &lines), NPH_BAD_USAGE);
    nph_scene_free(context, scene);
    nph_test_context_close(context);
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_loop_test(cases, batches_and_replay_agree_to_the_bit, 0, (int)(sizeof scenes / sizeof *scenes));
    tcase_add_test(cases, the_replay_tells_every_event);
}

int main(void) { return nph_test_main("path_replay", fill); }
