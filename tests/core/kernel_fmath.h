/* SPDX-License-Identifier: Apache-2.0
 *
 * The functions of core/fmath.h by number, for test_fmath.c: out[i] = function(x[i], y[i]); y is read by pow and atan2. */
#ifndef NPH_TESTS_KERNEL_FMATH_H
#define NPH_TESTS_KERNEL_FMATH_H

#include "core/cpu.h"

typedef enum Function {
    F_EXP, F_EXPM1, F_EXP2, F_LOG, F_LOG1P, F_SIN, F_COS, F_TAN, F_SIN2PI, F_COS2PI, F_ASIN, F_ACOS, F_CBRT, F_FLOOR,
    F_POW, F_ATAN2, F_COUNT
} Function;

/* x, y and out are float or double as the build says. */
NPH_KERNEL_DECLARE(void, fmath_lanes, (int function, const void *x, const void *y, void *out, int count));

#endif
