/* SPDX-License-Identifier: Apache-2.0
 *
 * Messages and progress of a context. The library itself never prints. */
#ifndef NPH_CORE_MESSAGE_H
#define NPH_CORE_MESSAGE_H

#include "nephos/context.h"

#if defined(__GNUC__)
#define NPH_PRINTF(form, first) __attribute__((format(printf, form, first)))
#else
#define NPH_PRINTF(form, first)
#endif

/* Reports an error and returns its status: `return nph_error(context, NPH_BAD_INPUT, "%s: ...", path);` */
NphStatus nph_error(NphContext *context, NphStatus status, const char *format, ...) NPH_PRINTF(3, 4);
#ifdef __clang_analyzer__ /* the analyzer does not see that what is handed in comes back */
#define nph_error(context, status, ...) ((void)(nph_error)((context), (status), __VA_ARGS__), (status))
#endif
void nph_warn(NphContext *context, const char *format, ...) NPH_PRINTF(2, 3);
void nph_info(NphContext *context, const char *format, ...) NPH_PRINTF(2, 3);

/* Reports progress, throttled to about ten calls a second; done == total always passes. */
void nph_progress(NphContext *context, const char *task, double done, double total, double seconds_left);

/* True once nph_interrupt was called. */
int nph_interrupted(const NphContext *context);

/* Forwards a failing status. */
#define NPH_TRY(expression)                              \
    do {                                                 \
        NphStatus nph_try_status_ = (expression);        \
        if (nph_try_status_ != NPH_OK) return nph_try_status_; \
    } while (0)

#endif
