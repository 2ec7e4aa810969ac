/* SPDX-License-Identifier: Apache-2.0
 *
 * See digest.h: the build of the kernel for a vector level. */
#include "oracle/digest.h"

NPH_KERNEL_DECLARE(void, nph_digest_rows, (const void *data, size_t rows, size_t row, size_t stride, char *text));

NphDigestFn nph_digest_pick(NphIsa isa) {
    NphDigestFn picked;
    NPH_KERNEL_PICK(picked, nph_digest_rows, isa, 64);
    return picked;
}
