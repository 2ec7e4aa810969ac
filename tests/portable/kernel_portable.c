/* SPDX-License-Identifier: Apache-2.0
 *
 * See kernel_portable.h. In double precision there is nothing to compare. */
#include "kernel_portable.h"

#include "core/real.h"

#if NPH_PRECISION == 32
#include "core_names.h"
#include "evaluate.h"

void NPH_KERNEL(portable_rows)(int function, const uint32_t *in, uint32_t *out, int count) {
    for (int i = 0; i < count; i++) nph_evaluate(function, &in[i * NPH_WORDS_IN], &out[i * NPH_WORDS_OUT]);
}
#else
void NPH_KERNEL(portable_rows)(int function, const uint32_t *in, uint32_t *out, int count) {
    (void)function, (void)in, (void)out, (void)count;
}
#endif
