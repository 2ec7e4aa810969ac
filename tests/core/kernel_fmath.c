/* SPDX-License-Identifier: Apache-2.0
 *
 * Lane loops over the functions of core/fmath.h, in every precision and vector level. */
#include "kernel_fmath.h"

#include "core/real.h"

#if NPH_PRECISION == 32
#define NAMED(name) nph_##name##f
#else
#define NAMED(name) nph_##name
#endif

#define LANES(code, statement)                            \
    case code:                                            \
        for (int i = 0; i < count; i++) statement;        \
        break

void NPH_KERNEL(fmath_lanes)(int function, const void *x_, const void *y_, void *out_, int count) {
    const Real *restrict x = x_, *restrict y = y_;
    Real *restrict out = out_;
    Real other;
    switch ((Function)function) {
        LANES(F_EXP, out[i] = NAMED(exp)(x[i]));
        LANES(F_EXPM1, out[i] = NAMED(expm1)(x[i]));
        LANES(F_EXP2, out[i] = NAMED(exp2)(x[i]));
        LANES(F_LOG, out[i] = NAMED(log)(x[i]));
        LANES(F_LOG1P, out[i] = NAMED(log1p)(x[i]));
        LANES(F_SIN, out[i] = NAMED(sin)(x[i]));
        LANES(F_COS, out[i] = NAMED(cos)(x[i]));
        LANES(F_TAN, out[i] = NAMED(tan)(x[i]));
        LANES(F_SIN2PI, NAMED(sincos2pi)(x[i], &out[i], &other));
        LANES(F_COS2PI, NAMED(sincos2pi)(x[i], &other, &out[i]));
        LANES(F_ASIN, out[i] = NAMED(asin)(x[i]));
        LANES(F_ACOS, out[i] = NAMED(acos)(x[i]));
        LANES(F_CBRT, out[i] = NAMED(cbrt)(x[i]));
        LANES(F_FLOOR, out[i] = NAMED(floor)(x[i]));
        LANES(F_POW, out[i] = NAMED(pow)(x[i], y[i]));
        LANES(F_ATAN2, out[i] = NAMED(atan2)(y[i], x[i]));
        case F_COUNT: break;
    }
}
