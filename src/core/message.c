/* SPDX-License-Identifier: Apache-2.0
 *
 * Messages are formatted here and handed to the context's callback one at a time, whatever thread they come from. */
#include "core/message.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "core/context.h"
#include "core/pool.h"

enum { NPH_MESSAGE_BYTES = 2048 };

/* A text that was cut: its last UTF-8 character goes when bytes of it are missing. */
static void end_whole_character(char *text) {
    size_t end = strlen(text), begin = end;
    while (begin > 0 && ((unsigned char)text[begin - 1] & 0xC0) == 0x80) begin--;
    if (begin == 0 || !((unsigned char)text[begin - 1] & 0x80)) return;
    unsigned char first = (unsigned char)text[begin - 1];
    size_t wanted = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
    if (end - (begin - 1) < wanted) text[begin - 1] = 0;
}

static void send(NphContext *context, NphMessageLevel level, const char *format, va_list arguments) {
    if (!context->settings.message) return;
    char text[NPH_MESSAGE_BYTES];
    int length = vsnprintf(text, sizeof text, format, arguments);
    if (length >= NPH_MESSAGE_BYTES) end_whole_character(text);
    pthread_mutex_lock(&context->message_lock);
    context->settings.message(context->settings.user, level, text);
    pthread_mutex_unlock(&context->message_lock);
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
