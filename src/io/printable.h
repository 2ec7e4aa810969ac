/* SPDX-License-Identifier: Apache-2.0
 *
 * Names and words out of a file for a message: what is not printable ASCII becomes '?', what is long is cut, so that a
 * hostile file cannot write escape sequences or pages of text to a terminal. */
#ifndef NPH_IO_PRINTABLE_H
#define NPH_IO_PRINTABLE_H

#include <stddef.h>

/* Copies at most capacity - 1 bytes of text, NUL-terminated; a cut shows as "...". Returns out. */
static inline const char *nph_printable(const char *text, size_t bytes, char *out, size_t capacity) {
    size_t count = bytes < capacity ? bytes : capacity - 1;
    for (size_t i = 0; i < count; i++) out[i] = text[i] >= 0x20 && text[i] < 0x7f ? text[i] : '?';
    for (size_t i = 1; bytes > count && i <= 3 && i <= count; i++) out[count - i] = '.';
    out[count] = 0;
    return out;
}

#endif
