/* SPDX-License-Identifier: Apache-2.0
 *
 * The library's own float functions by number, for count rows of NPH_WORDS_IN and NPH_WORDS_OUT words. */
#ifndef NPH_TESTS_KERNEL_PORTABLE_H
#define NPH_TESTS_KERNEL_PORTABLE_H

#include "core/cpu.h"

NPH_KERNEL_DECLARE(void, portable_rows, (int function, const uint32_t *in, uint32_t *out, int count));

#endif
