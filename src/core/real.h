/* SPDX-License-Identifier: Apache-2.0
 *
 * The number type of a kernel. meson compiles every NAME_kernel.c once per precision and vector level with
 * NPH_PRECISION (32 or 64) and NPH_KERNEL_SUFFIX (f32_base ... f64_avx512) defined; NPH_KERNEL(name) gives each build
 * its symbol: name_f32_avx2. */
#ifndef NPH_CORE_REAL_H
#define NPH_CORE_REAL_H

#include "core/bug.h"
#include "core/fmath.h"

#ifndef NPH_PRECISION
#define NPH_PRECISION 64
#endif

#define NPH_JOIN2_(a, b) a##_##b
#define NPH_JOIN2(a, b) NPH_JOIN2_(a, b)
#ifdef NPH_KERNEL_SUFFIX
#define NPH_KERNEL(name) NPH_JOIN2(name, NPH_KERNEL_SUFFIX)
#endif

/* Functions whose loops must become vectors stay functions: inlined, gcc forgets that their parameters are restrict.
 * What they call for each lane must be inlined, however large. */
#if defined(__GNUC__)
#define R_OUTLINE static __attribute__((noinline, unused))
#define R_INLINE static inline __attribute__((always_inline))
#else
#define R_OUTLINE static
#define R_INLINE static inline
#endif

/* Before a loop whose iterations write places of their own, where only the program's words say so: rows of one array. */
#if defined(__GNUC__) && !defined(__clang__)
#define R_INDEPENDENT _Pragma("GCC ivdep")
#else
#define R_INDEPENDENT
#endif

#if NPH_PRECISION == 32
typedef float Real;
#define R(x) x##f
#define NPH_REAL_ULP 0x1p-23f
#define r_exp nph_expf
#define r_expm1 nph_expm1f
#define r_log nph_logf
#define r_log1p nph_log1pf
#define r_sincos2pi nph_sincos2pif
#define r_cbrt nph_cbrtf
#define r_acos nph_acosf
#define r_atan2 nph_atan2f
#define r_sqrt nph_sqrtf
#define r_floor nph_floorf
#define r_abs nph_absf
#define r_uniform nph_uniformf
#else
typedef double Real;
#define R(x) x
#define NPH_REAL_ULP 0x1p-52
#define r_exp nph_exp
#define r_expm1 nph_expm1
#define r_log nph_log
#define r_log1p nph_log1p
#define r_sincos2pi nph_sincos2pi
#define r_cbrt nph_cbrt
#define r_acos nph_acos
#define r_atan2 nph_atan2
#define r_sqrt nph_sqrt
#define r_floor nph_floor
#define r_abs nph_abs
#define r_uniform nph_uniform
#endif

/* Comparisons instead of fmin and fmax: the second argument wins when the comparison is false (NaN included). */
static inline Real r_min(Real a, Real b) { return a < b ? a : b; }
static inline Real r_max(Real a, Real b) { return a > b ? a : b; }
static inline Real r_clamp(Real x, Real lo, Real hi) { return x < lo ? lo : x > hi ? hi : x; }

#ifdef NPH_ALTERED
#include "core/accuracy.h"
#endif

#endif
