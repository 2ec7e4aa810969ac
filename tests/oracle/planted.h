/* SPDX-License-Identifier: Apache-2.0
 *
 * Mistakes that ports make, planted in a copy of a dump of planted_scene. */
#ifndef NPH_TESTS_PLANTED_H
#define NPH_TESTS_PLANTED_H

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "harness.h"
#include "io/volume.h"
#include "oracle/manifest.h"

static const char planted_scene[] =
    "nephos: 1\ncamera: {type: perspective, resolution: [18, 9], position: [-2, -1.5, 1.2], look_at: [0.5, 0.5, 0.5], fov: 40}\n"
    "media:\n  - {box: [[0, 0, 0], [1, 1, 1]], extinction: 6, albedo: 0.95, phase: {type: hg, g: 0.8}}\n"
    "lights:\n  - {type: sun, direction: [-1, 0.2, 0.3], irradiance: 3}\n  - {type: constant, radiance: 0.2}\n";

/* File of an output of the n-th launch of a stage; static buffer. */
static const char *launch_file(const NphManifest *manifest, const char *stage, int n, const char *buffer, const NphManifestLaunch **out) {
    static char path[4200];
    for (int l = 0; l < manifest->launch_count; l++) {
        const NphManifestLaunch *launch = &manifest->launches[l];
        if (strcmp(launch->stage, stage) != 0 || n-- > 0) continue;
        for (int o = 0; o < launch->output_count; o++)
            if (strcmp(launch->outputs[o].buffer, buffer) == 0) snprintf(path, sizeof path, "%s%s", manifest->folder, launch->outputs[o].file);
        if (out) *out = launch;
        return path;
    }
    ck_abort_msg("no such launch");
    return NULL;
}

/* In the place of an array that is no smaller: "FILE@OFFSET". */
static void store_array(NphContext *context, const char *place, const NphArray *array) {
    char path[4200];
    int64_t size = 0;
    const char *at = strrchr(place, '@');
    snprintf(path, sizeof path, "%.*s", (int)(at - place), place);
    int file = open(path, O_WRONLY);
    ck_assert_int_ge(file, 0);
    ck_assert_int_eq(lseek(file, atoll(at + 1), SEEK_SET), atoll(at + 1));
    NphAppender appender;
    ck_assert_int_eq(nph_appender_open(context, file, path, &appender), NPH_OK);
    ck_assert_int_eq(nph_npy_append(context, &appender, array, 0, &size), NPH_OK);
    ck_assert_int_eq(nph_appender_flush(context, &appender), NPH_OK);
    nph_appender_close(context, &appender);
    ck_assert_int_eq(close(file), 0);
}

static void change_array(NphContext *context, const char *path, void (*mistake)(NphArray *)) {
    NphArray array;
    ck_assert_int_eq(nph_array_read_npy(context, path, &array), NPH_OK);
    mistake(&array);
    store_array(context, path, &array);
    nph_array_free(context, &array);
}

static void swap_x_and_y(NphArray *array) {
    float *x = array->data, *y = x + array->shape[1];
    for (int64_t i = 0; i < array->shape[1]; i++) {
        float kept = x[i];
        x[i] = y[i];
        y[i] = kept;
    }
}

static void drop_a_factor(NphArray *array) {
    float *light = array->data;
    for (int64_t i = 0; i < array->shape[1]; i++) light[i] *= 12.566371f;
}

static void one_block_late(NphArray *array) {
    float *distance = array->data;
    memmove(distance + 64, distance, sizeof(float) * (size_t)(array->shape[0] - 64));
}

static float to_half(float x) {
    float big = x * 8193.0f; /* 11 bits are left [Dekker's splitting] */
    return big - (big - x);
}

static void store_halves(NphArray *array) {
    float *value = array->data;
    for (int64_t i = 0; i < nph_array_count(array); i++) value[i] = to_half(value[i]);
}

static void one_cell(NphArray *array) { ((float *)array->data)[2 * array->shape[1] + 17] *= 1.001f; }

/* row, item: of the first cell that is wrong, as expected; item -1: not told. */
typedef struct Planted {
    const char *stage;
    int launch;
    const char *buffer;
    void (*mistake)(NphArray *);
    int row, item;
} Planted;

static const Planted planted[] = {
    {"path.generate", 1, "path.ray", swap_x_and_y, 0, -1},
    {"path.shadow", 0, "path.sample", drop_a_factor, 0, -1},
    {"path.track", 2, "path.distance", one_block_late, 0, -1},
    {"path.scatter", 1, "path.weight", store_halves, 0, -1},
    {"path.scatter", 3, "path.ray", one_cell, 2, 17},
};
enum { PLANTED = sizeof planted / sizeof planted[0] };

static void plant(NphContext *context, const NphManifest *manifest, const Planted *which, const NphManifestLaunch **launch) {
    change_array(context, launch_file(manifest, which->stage, which->launch, which->buffer, launch), which->mistake);
}

#endif
