/* SPDX-License-Identifier: Apache-2.0
 *
 * Vector level detection (the compiler's run-time support reads CPUID and the state the system saves). */
#include "core/cpu.h"

#include <string.h>

NphIsa nph_cpu_isa(void) {
#ifdef NPH_HAVE_X86_LEVELS
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("bmi2"))
        return NPH_ISA_AVX512;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi2")) return NPH_ISA_AVX2;
#endif
    return NPH_ISA_BASE;
}

const char *nph_isa_name(NphIsa isa) {
    return isa == NPH_ISA_AVX512 ? "avx512" : isa == NPH_ISA_AVX2 ? "avx2" : "base";
}

int nph_isa_parse(const char *word, NphIsa *isa) {
    for (int level = NPH_ISA_BASE; level <= NPH_ISA_AVX512; level++)
        if (strcmp(word, nph_isa_name((NphIsa)level)) == 0) {
            *isa = (NphIsa)level;
            return 1;
        }
    return 0;
}
