/* SPDX-License-Identifier: Apache-2.0
 *
 * Messages are formatted here and handed to the context's callback under its lock. */
#include "core/message.h"

#include <stdarg.h>
#include <stdio.h>

#include "core/context.h"
#include "core/pool.h"

enum { NPH_MESSAGE_BYTES = 2048 };

static void send(NphContext *context, NphMessageLevel level, const char *format, va_list arguments) {
    if (!context->settings.message) return;
    char text[NPH_MESSAGE_BYTES];
    vsnprintf(text, sizeof text, format, arguments);
    pthread_mutex_lock(&context->lock);
    context->settings.message(context->settings.user, level, text);
    pthread_mutex_unlock(&context->lock);
}

NphStatus (nph_error)(NphContext *context, NphStatus status, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    send(context, NPH_MESSAGE_ERROR, format, arguments);
    va_end(arguments);
    return status;
}

void nph_warn(NphContext *context, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    send(context, NPH_MESSAGE_WARNING, format, arguments);
    va_end(arguments);
}

void nph_info(NphContext *context, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    send(context, NPH_MESSAGE_INFO, format, arguments);
    va_end(arguments);
}

void nph_progress(NphContext *context, const char *task, double done, double total, double seconds_left) {
    if (!context->settings.progress) return;
    double now = nph_seconds();
    if (done < total && now - context->progress_time < 0.1) return;
    context->progress_time = now;
    context->settings.progress(context->settings.user, task, done, total, seconds_left);
}
