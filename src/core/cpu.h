/* SPDX-License-Identifier: Apache-2.0
 *
 * The vector level of this machine. A kernel NAME is built as NAME_f32_base ... NAME_f64_avx512; a NAME.c picks from
 * them with NPH_KERNEL_PICK, base first, each later line overwriting it where the level allows. */
#ifndef NPH_CORE_CPU_H
#define NPH_CORE_CPU_H

#include "nephos/context.h"

/* Highest level that processor and operating system support. */
NphIsa nph_cpu_isa(void);

/* base | avx2 | avx512 to a level; 0 when the word is none of them. */
int nph_isa_parse(const char *word, NphIsa *isa);

/* Declares a kernel's builds: NPH_KERNEL_DECLARE(void, nph_track, (NphTrack *)); */
#ifdef NPH_HAVE_X86_LEVELS
#define NPH_KERNEL_DECLARE(type, name, arguments)                                                    \
    type name##_f32_base arguments;  type name##_f64_base arguments;                                 \
    type name##_f32_avx2 arguments;  type name##_f64_avx2 arguments;                                 \
    type name##_f32_avx512 arguments; type name##_f64_avx512 arguments
#define NPH_KERNEL_PICK(target, name, isa, precision)                                                \
    do {                                                                                             \
        (target) = (precision) == 32 ? name##_f32_base : name##_f64_base;                            \
        if ((isa) >= NPH_ISA_AVX2) (target) = (precision) == 32 ? name##_f32_avx2 : name##_f64_avx2; \
        if ((isa) >= NPH_ISA_AVX512) (target) = (precision) == 32 ? name##_f32_avx512 : name##_f64_avx512; \
    } while (0)
#else
#define NPH_KERNEL_DECLARE(type, name, arguments) \
    type name##_f32_base arguments; type name##_f64_base arguments
#define NPH_KERNEL_PICK(target, name, isa, precision) \
    ((void)(isa), (target) = (precision) == 32 ? name##_f32_base : name##_f64_base)
#endif

/* Kernels that gain nothing from wider vectors have no builds for them; in altered programs, where levels are other arithmetic
 * (src/altered/meson.build), they have. */
#ifdef NPH_ALTERED_STAGES
#define NPH_STAGE_DECLARE NPH_KERNEL_DECLARE
#define NPH_STAGE_PICK NPH_KERNEL_PICK
#else
#define NPH_STAGE_DECLARE(type, name, arguments) \
    type name##_f32_base arguments; type name##_f64_base arguments
#define NPH_STAGE_PICK(target, name, isa, precision) \
    ((void)(isa), (target) = (precision) == 32 ? name##_f32_base : name##_f64_base)
#endif

#endif
