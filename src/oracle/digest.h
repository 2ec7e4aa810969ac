/* SPDX-License-Identifier: Apache-2.0
 *
 * XXH3 (128 bits, canonical) of bytes as 32 hexadecimal digits. */
#ifndef NPH_ORACLE_DIGEST_H
#define NPH_ORACLE_DIGEST_H

#include <xxhash.h>

enum { NPH_DIGEST_TEXT = 33 };

static inline void nph_digest_text(const void *bytes, size_t count, char text[NPH_DIGEST_TEXT]) {
    XXH128_canonical_t canonical;
    XXH128_canonicalFromHash(&canonical, XXH3_128bits(bytes, count));
    for (int i = 0; i < 32; i++) text[i] = "0123456789abcdef"[canonical.digest[i / 2] >> (i % 2 ? 0 : 4) & 15];
    text[32] = 0;
}

#endif
