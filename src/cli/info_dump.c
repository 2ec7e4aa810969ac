/* SPDX-License-Identifier: Apache-2.0
 *
 * What a dump holds: its run, and of every stage's outputs how many, of what type, in what range; all of them are read. */
#include <math.h>
#include <string.h>
#include <sys/stat.h>

#include "cli/info.h"
#include "core/memory.h"
#include "core/message.h"
#include "oracle/manifest.h"

/* The outputs of one stage that share a buffer. */
typedef struct Row {
    const char *stage, *buffer;
    int64_t arrays, cells, not_finite;
    NphType type;
    double least, most;
} Row;

int info_is_dump(const char *path) {
    struct stat facts;
    size_t length = strlen(path), end = sizeof "manifest.json" - 1;
    int named = length >= end && strcmp(path + length - end, "manifest.json") == 0;
    return stat(path, &facts) == 0 && (S_ISDIR(facts.st_mode) || named);
}

static double cell(const NphArray *array, int64_t i) {
    switch (array->type) {
    case NPH_U8: return ((const uint8_t *)array->data)[i];
    case NPH_I32: return ((const int32_t *)array->data)[i];
    case NPH_U32: return ((const uint32_t *)array->data)[i];
    case NPH_I64: return (double)((const int64_t *)array->data)[i];
    case NPH_U64: return (double)((const uint64_t *)array->data)[i];
    case NPH_F32: return (double)((const float *)array->data)[i];
    case NPH_F64: return ((const double *)array->data)[i];
    default: return NAN;
    }
}

static void add(Row *row, const NphArray *array) {
    int64_t count = nph_array_count(array);
    row->type = array->type;
    row->arrays++;
    row->cells += count;
    for (int64_t i = 0; i < count; i++) {
        double value = cell(array, i);
        if (!isfinite(value)) {
            row->not_finite++;
            continue;
        }
        if (!(value >= row->least)) row->least = value;
        if (!(value <= row->most)) row->most = value;
    }
}

static Row *row_of(Row *rows, int *count, const char *stage, const char *buffer) {
    for (int r = 0; r < *count; r++)
        if (strcmp(rows[r].stage, stage) == 0 && strcmp(rows[r].buffer, buffer) == 0) return &rows[r];
    rows[*count] = (Row){.stage = stage, .buffer = buffer, .least = NAN, .most = NAN};
    return &rows[(*count)++];
}

static NphStatus read_outputs(Info *info, const NphManifest *manifest, int room, Row *rows, int *count) {
    for (int l = 0; l < manifest->launch_count; l++) {
        const NphManifestLaunch *launch = &manifest->launches[l];
        for (int o = 0; o < launch->output_count; o++) {
            NphArray array = {0};
            if (*count == room) return nph_error(info->context, NPH_BAD_INPUT, "%s: more than %d buffers of stages", info->path, room);
            Row *row = row_of(rows, count, launch->stage, launch->outputs[o].buffer);
            NPH_TRY(nph_manifest_array(info->context, manifest, launch->outputs[o].file, &array));
            add(row, &array);
            nph_array_free(info->context, &array);
        }
    }
    return NPH_OK;
}

static void tell_run(Info *info, const NphManifest *manifest) {
    const char *const texts[][2] = {{"scene", manifest->scene}, {"scene_digest", manifest->scene_digest}, {"method", manifest->method}};
    int64_t batches = 0;
    for (int i = 0; i < 3; i++)
        if (texts[i][1]) facts_text(&info->facts, texts[i][0], texts[i][1]);
    facts_text(&info->facts, "precision", manifest->precision == 64 ? "f64" : "f32");
    facts_integer(&info->facts, "seed", manifest->seed);
    facts_integer(&info->facts, "frame", manifest->frame);
    if (manifest->scene_frame != manifest->frame) facts_integer(&info->facts, "scene_frame", manifest->scene_frame);
    facts_numbers(&info->facts, "samples", 2, (double[]){(double)manifest->samples[0], (double)manifest->samples[1]});
    if (manifest->crop_given) facts_integers(&info->facts, "crop", 4, manifest->crop);
    for (int l = 0; l < manifest->launch_count; l++)
        batches += l == 0 || manifest->launches[l].batch != manifest->launches[l - 1].batch;
    facts_integer(&info->facts, "batches", batches);
    facts_integer(&info->facts, "launches", manifest->launch_count);
}

static void tell_rows(Info *info, const Row *rows, int count) {
    facts_list(&info->facts, "outputs");
    for (int r = 0; r < count; r++) {
        facts_row(&info->facts);
        facts_text(&info->facts, "stage", rows[r].stage);
        facts_text(&info->facts, "buffer", rows[r].buffer);
        facts_text(&info->facts, "type", nph_type_name(rows[r].type));
        facts_integer(&info->facts, "arrays", rows[r].arrays);
        facts_integer(&info->facts, "cells", rows[r].cells);
        if (!isnan(rows[r].least)) facts_numbers(&info->facts, "from_to", 2, (double[]){rows[r].least, rows[r].most});
        if (rows[r].not_finite) facts_integer(&info->facts, "not_finite", rows[r].not_finite);
        facts_end(&info->facts);
    }
    facts_end(&info->facts);
}

NphStatus info_dump(Info *info) {
    enum { ROOM = 1024 };
    NphManifest manifest;
    Row *rows = NULL;
    int count = 0;
    NPH_TRY(nph_manifest_read(info->context, info->path, &manifest));
    NphStatus status = NPH_NEW(info->context, ROOM, "buffers of stages", &rows);
    if (status == NPH_OK) status = read_outputs(info, &manifest, ROOM, rows, &count);
    if (status == NPH_OK) {
        tell_run(info, &manifest);
        tell_rows(info, rows, count);
    }
    nph_free(info->context, rows);
    nph_manifest_free(info->context, &manifest);
    return status;
}
