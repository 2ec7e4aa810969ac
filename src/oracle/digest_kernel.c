/* SPDX-License-Identifier: Apache-2.0
 *
 * The digest of an array's elements for each vector level: the library's own is compiled for the oldest processor. XXH3 gives
 * the same bytes whatever it is compiled for. Elements are bytes here, the same for either precision. */
#define XXH_INLINE_ALL
#include "core/real.h"
#include "oracle/digest.h"

void NPH_KERNEL(nph_digest_rows)(const void *data, size_t rows, size_t row, size_t stride, char *text);

void NPH_KERNEL(nph_digest_rows)(const void *data, size_t rows, size_t row, size_t stride, char *text) {
    NphDigest digest;
    nph_digest_begin(&digest);
    for (size_t r = 0; r < rows; r++) nph_digest_add(&digest, (const char *)data + r * stride, row);
    nph_digest_end(&digest, text);
}
