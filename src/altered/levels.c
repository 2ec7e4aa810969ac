/* SPDX-License-Identifier: Apache-2.0
 *
 * See altered.h: the context is told another level than the processor's. */
#include "altered/altered.h"
#include "core/context.h"

#ifdef NPH_ALTERED_LEVELS
static int has_fma(void) {
    __builtin_cpu_init();
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
}
#else
static int has_fma(void) { return 0; }
#endif

int altered_choose_level(NphContext *context, NphIsa level) {
    if (level != NPH_ISA_BASE && !has_fma()) return 0;
    context->isa = level;
    return 1;
}
