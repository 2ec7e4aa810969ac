/* SPDX-License-Identifier: Apache-2.0
 *
 * The reference's dump, read through nephos/verify.h, and the port's, written by hand: .npy files and a manifest.json that names them. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "port.h"

static FILE *manifest;
static const NphDumpLaunch *under_way;
static int launches_written, named, writes_outputs; /* named: buffers of the list that is open */

double number(const char *name, double otherwise) {
    double value = otherwise;
    nph_dump_run_numbers(port.run, name, 1, &value);
    return value;
}

void doubles(const char *name, int count, double *out) {
    if (nph_dump_run_numbers(port.run, name, count, out) != count) stop(NPH_BAD_INPUT, "the manifest has no %s of %d numbers", name, count);
}

void numbers(const char *name, int count, float *out) {
    double values[16];
    doubles(name, count, values);
    for (int i = 0; i < count; i++) out[i] = (float)values[i];
}

int64_t argument(const NphDumpLaunch *of, const char *name) {
    for (int a = 0; a < of->argument_count; a++)
        if (strcmp(of->argument_names[a], name) == 0) return of->arguments[a];
    stop(NPH_BAD_INPUT, "%s has no argument %s", of->stage, name);
    return 0;
}

NphArray array_of(int64_t index, const char *buffer) {
    NphArray array;
    need(nph_dump_run_array(port.context, port.run, index, buffer, &array));
    return array;
}

/* A .npy file: 128 bytes of header, and the elements. */
static void write_npy(const char *path, NphType type, int rank, const int64_t *shape, const void *data) {
    static const unsigned char version[4] = {1, 0, 118, 0}; /* 1.0, and how long the rest of the header is */
    char header[129], text[64] = "";
    size_t count = 1, size = nph_type_size(type);
    for (int a = 0; a < rank; a++) {
        count *= (size_t)shape[a];
        snprintf(text + strlen(text), sizeof text - strlen(text), "%lld,%s", (long long)shape[a], a + 1 < rank ? " " : "");
    }
    int used = snprintf(header, sizeof header, "\x93NUMPY%c%c%c%c{'descr': '<%c%d', 'fortran_order': False, 'shape': (%s), }", 1, 1, 1, 1,
                        nph_type_name(type)[0], (int)size, text);
    memcpy(header + 6, version, sizeof version);
    memset(header + used, ' ', 127 - (size_t)used);
    header[127] = '\n';
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(header, 1, 128, file) != 128 || fwrite(data, size, count, file) != count || fclose(file) != 0)
        stop(NPH_BAD_OUTPUT, "%s: cannot be written: %s", path, strerror(errno));
}

void record(const char *buffer, NphType type, int rank, const int64_t *shape, const void *data) {
    char path[4096];
    snprintf(path, sizeof path, "%s/batch%lld.%lld.%s%s.npy", port.output, (long long)under_way->batch, (long long)under_way->number,
             writes_outputs ? "" : "in.", buffer);
    write_npy(path, type, rank, shape, data);
    fprintf(manifest, "%s\"%s\": \"%s\"", named++ ? ", " : "", buffer, path + strlen(port.output) + 1);
}

void record_array(const char *buffer, const NphArray *array) { record(buffer, array->type, array->rank, array->shape, array->data); }

void record_from(const char *buffer, NphType type, int rank, const int64_t *shape, cl_mem from, size_t offset) {
    size_t bytes = nph_type_size(type);
    for (int a = 0; a < rank; a++) bytes *= (size_t)shape[a];
    void *data = malloc(bytes ? bytes : 4);
    if (!data) stop(NPH_NO_MEMORY, "no memory for %s", buffer);
    download(from, offset, bytes, data);
    record(buffer, type, rank, shape, data);
    free(data);
}

void begin_dump(const char *method) {
    char path[4096];
    snprintf(path, sizeof path, "%s/manifest.json", port.output);
    manifest = mkdir(port.output, 0777) == 0 ? fopen(path, "w") : NULL;
    if (!manifest) stop(NPH_BAD_OUTPUT, "%s: cannot be made: %s", port.output, strerror(errno));
    fprintf(manifest, "{\"nephos_dump\": 1, \"method\": \"%s\", \"launches\": [", method);
}

void begin_launch(const NphDumpLaunch *of) {
    fprintf(manifest, "%s\n  {\"batch\": %lld, \"number\": %lld, \"stage\": \"%s\", \"arguments\": {", launches_written++ ? "," : "",
            (long long)of->batch, (long long)of->number, of->stage);
    for (int a = 0; a < of->argument_count; a++)
        fprintf(manifest, "%s\"%s\": %lld", a ? ", " : "", of->argument_names[a], (long long)of->arguments[a]);
    fprintf(manifest, "},\n   \"inputs\": {");
    under_way = of;
    named = writes_outputs = 0;
}

void begin_outputs(void) {
    fprintf(manifest, "},\n   \"outputs\": {");
    named = 0;
    writes_outputs = 1;
}

void end_launch(void) { fprintf(manifest, "}}"); }

void end_dump(void) {
    fprintf(manifest, "\n]}\n");
    if (fclose(manifest) != 0) stop(NPH_BAD_OUTPUT, "%s/manifest.json: cannot be written: %s", port.output, strerror(errno));
}
