/* SPDX-License-Identifier: Apache-2.0
 *
 * XXH3 (128 bits, canonical) of bytes as 32 hexadecimal digits; in one piece or in several. */
#ifndef NPH_ORACLE_DIGEST_H
#define NPH_ORACLE_DIGEST_H

#ifndef XXH_STATIC_LINKING_ONLY
#define XXH_STATIC_LINKING_ONLY /* the state lies in its owner's memory */
#endif
#include <xxhash.h>

#include "core/cpu.h"

enum { NPH_DIGEST_TEXT = 33 };

typedef struct NphDigest {
    XXH3_state_t state;
} NphDigest;

static inline void nph_digest_begin(NphDigest *digest) {
    XXH3_INITSTATE(&digest->state);
    XXH3_128bits_reset(&digest->state);
}

static inline void nph_digest_add(NphDigest *digest, const void *bytes, size_t count) {
    XXH3_128bits_update(&digest->state, bytes, count);
}

static inline void nph_digest_end(const NphDigest *digest, char text[NPH_DIGEST_TEXT]) {
    XXH128_canonical_t canonical;
    XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(&digest->state));
    for (int i = 0; i < 32; i++) text[i] = "0123456789abcdef"[canonical.digest[i / 2] >> (i % 2 ? 0 : 4) & 15];
    text[32] = 0;
}

static inline void nph_digest_text(const void *bytes, size_t count, char text[NPH_DIGEST_TEXT]) {
    NphDigest digest;
    nph_digest_begin(&digest);
    nph_digest_add(&digest, bytes, count);
    nph_digest_end(&digest, text);
}

/* Of `rows` rows of `row` bytes that lie `stride` bytes apart, as if they lay without gaps. */
typedef void (*NphDigestFn)(const void *data, size_t rows, size_t row, size_t stride, char *text);
NphDigestFn nph_digest_pick(NphIsa isa);

#endif
