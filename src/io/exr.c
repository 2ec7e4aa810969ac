/* SPDX-License-Identifier: Apache-2.0
 *
 * What reading and writing of OpenEXR share: the library's messages. */
#include "io/exr_core.h"

#include <stdio.h>

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
