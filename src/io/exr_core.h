/* SPDX-License-Identifier: Apache-2.0
 *
 * OpenEXRCore for exr*.c alone. Its header uses C11's unnamed unions, hence the pragma, which makes it a system header.
 * The library prints unless it is given an error handler: nph_exr_note keeps the first message of a file instead, and
 * the reader or writer hands it to nph_error together with the path. */
#ifndef NPH_IO_EXR_CORE_H
#define NPH_IO_EXR_CORE_H

#if defined(__GNUC__)
#pragma GCC system_header
#endif
#include <openexr.h>

/* First member of what the library knows as user data. */
typedef struct NphExrLog {
    char text[256];
} NphExrLog;

void nph_exr_note(exr_const_context_t exr, exr_result_t code, const char *text);

/* The noted message, or the library's words for the code where there is none. */
const char *nph_exr_reason(const NphExrLog *log, exr_result_t code);

#endif
