/* SPDX-License-Identifier: Apache-2.0
 *
 * A dump as its readers see it (nephos/verify.h): its launches, arrays and numbers. */
#include <string.h>

#include "core/message.h"
#include "oracle/manifest.h"

int64_t nph_dump_run_launch_count(const NphDumpRun *run) { return run->manifest.launch_count; }

static int names_of(int count, const NphManifestFile *files, const char *names[NPH_MAX_BUFFERS]) {
    int kept = count < NPH_MAX_BUFFERS ? count : NPH_MAX_BUFFERS;
    for (int i = 0; i < kept; i++) names[i] = files[i].buffer;
    return kept;
}

void nph_dump_run_launch(const NphDumpRun *run, int64_t index, NphDumpLaunch *launch) {
    const NphManifestLaunch *from = &run->manifest.launches[index];
    *launch = (NphDumpLaunch){.batch = from->batch, .number = from->number, .stage = from->stage, .argument_count = from->argument_count};
    for (int a = 0; a < from->argument_count; a++) {
        launch->argument_names[a] = from->argument_names[a];
        launch->arguments[a] = from->arguments[a];
    }
    launch->input_count = names_of(from->input_count, from->inputs, launch->inputs);
    launch->output_count = names_of(from->output_count, from->outputs, launch->outputs);
}

static const NphManifestFile *file_of(int count, const NphManifestFile *files, const char *buffer) {
    for (int i = 0; i < count; i++)
        if (strcmp(files[i].buffer, buffer) == 0) return &files[i];
    return NULL;
}

NphStatus nph_dump_run_array(NphContext *context, const NphDumpRun *run, int64_t index, const char *buffer, NphArray *array) {
    const NphManifestLaunch *launch = &run->manifest.launches[index];
    const NphManifestFile *file = file_of(launch->input_count, launch->inputs, buffer);
    if (!file) file = file_of(launch->output_count, launch->outputs, buffer);
    if (file) return nph_manifest_array(context, &run->manifest, file->file, array);
    return nph_error(context, NPH_BAD_INPUT, "%smanifest.json: %s, launch %lld of batch %lld, has no %s", run->manifest.folder,
                     launch->stage, (long long)launch->number, (long long)launch->batch, buffer);
}

int nph_dump_run_numbers(const NphDumpRun *run, const char *name, int room, double *values) {
    for (int n = 0; n < run->manifest.number_count; n++) {
        const NphManifestNumbers *numbers = &run->manifest.numbers[n];
        if (strcmp(numbers->name, name) != 0) continue;
        for (int i = 0; i < numbers->count && i < room; i++) values[i] = numbers->values[i];
        return numbers->count;
    }
    return 0;
}
