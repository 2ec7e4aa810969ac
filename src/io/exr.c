/* SPDX-License-Identifier: Apache-2.0
 *
 * What reading and writing of OpenEXR share: names the format keeps, and the library's messages. */
#include "io/exr.h"

#include <stdio.h>
#include <string.h>

#include "io/exr_core.h"

static const char *const reserved[] = {
    "channels",           "compression",       "dataWindow", "displayWindow", "lineOrder", "pixelAspectRatio",
    "screenWindowCenter", "screenWindowWidth", "name",       "type",          "tiles",     "version",
    "chunkCount"};

int nph_exr_reserved_name(const char *name) {
    for (size_t i = 0; i < sizeof reserved / sizeof *reserved; i++)
        if (strcmp(name, reserved[i]) == 0) return 1;
    return 0;
}

/* The first message is the cause; those that follow tell how the library's callers failed in turn. */
void nph_exr_note(exr_const_context_t exr, exr_result_t code, const char *text) {
    (void)code;
    void *user = NULL;
    if (!exr || exr_get_user_data(exr, &user) != EXR_ERR_SUCCESS || !user) return;
    NphExrLog *log = user;
    if (!log->text[0]) snprintf(log->text, sizeof log->text, "%s", text);
}

const char *nph_exr_reason(const NphExrLog *log, exr_result_t code) {
    return log->text[0] ? log->text : exr_get_default_error_message(code);
}
