/* SPDX-License-Identifier: Apache-2.0
 *
 * Stages of nephos on an OpenCL device, fed from a dump, written down as a dump of their own for `nephos verify`:
 *
 *     nephos render reference/scenes/smoke.yaml -o smoke.exr --spp 16 --crop 192,144,208,160 --dump dump
 *     build/examples/example_opencl dump mine
 *     nephos verify dump mine
 *
 * Of path its path.majorant and path.track (port_path.c), of principal_ordinates its pop.propagate (port_ordinates.c). --plant MISTAKE
 * makes one of four mistakes of each, for verify to find. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "port.h"

static const Method *const methods[] = {&path_port, &ordinates_port};
enum { METHODS = sizeof methods / sizeof *methods, PLANTS = 4 };

Port port = {.plant = ""};

void stop(int status, const char *format, ...) {
    va_list words;
    va_start(words, format);
    vfprintf(stderr, format, words);
    va_end(words);
    fputc('\n', stderr);
    exit(status);
}

void need(NphStatus status) {
    if (status != NPH_OK) exit((int)status);
}

static void on_message(void *user, NphMessageLevel level, const char *text) {
    (void)user;
    fprintf(stderr, "%s%s\n", level == NPH_MESSAGE_ERROR ? "error: " : "", text);
}

static void usage(const char *program) {
    fprintf(stderr, "usage: %s DUMP OUT [--plant MISTAKE]\n", program);
    for (int m = 0; m < METHODS; m++) {
        fprintf(stderr, "mistakes of %s:", methods[m]->name);
        for (int p = 0; p < PLANTS; p++) fprintf(stderr, " %s", methods[m]->plants[p][0]);
        fputc('\n', stderr);
    }
    exit(NPH_BAD_USAGE);
}

static const Method *method_of(const char *name) {
    for (int m = 0; m < METHODS; m++)
        if (strcmp(methods[m]->name, name) == 0) return methods[m];
    stop(NPH_BAD_INPUT, "%s is not ported; path and principal_ordinates are, in part", name);
    return NULL;
}

/* What the compiler is told of the mistake. */
static const char *option_of(const Method *method) {
    if (!*port.plant) return "";
    for (int p = 0; p < PLANTS; p++)
        if (strcmp(method->plants[p][0], port.plant) == 0) return method->plants[p][1];
    stop(NPH_BAD_USAGE, "%s has no mistake %s", method->name, port.plant);
    return NULL;
}

int main(int argc, char **argv) {
    NphSettings settings;
    int planted = argc == 5 && strcmp(argv[3], "--plant") == 0;
    if (argc != 3 && !planted) usage(argv[0]);
    port.output = argv[2];
    port.plant = planted ? argv[4] : "";
    nph_settings_default(&settings);
    settings.message = on_message;
    need(nph_context_open(&port.context, &settings));
    need(nph_dump_run(port.context, argv[1], &port.run));
    const Method *method = method_of(nph_dump_run_options(port.run)->method);
    const char *option = option_of(method);
    method->read_scene();
    open_device(method->source, option);
    begin_dump(method->name);
    for (int64_t l = 0; l < nph_dump_run_launch_count(port.run); l++) {
        NphDumpLaunch of;
        nph_dump_run_launch(port.run, l, &of);
        method->run_launch(l, &of);
    }
    end_dump();
    method->release();
    close_device();
    nph_dump_run_free(port.context, port.run);
    nph_context_close(port.context);
    return 0;
}
