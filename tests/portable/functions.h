/* SPDX-License-Identifier: Apache-2.0
 *
 * The functions of nephos/portable.h that have vectors: name, arguments, results. A word is the bits of a float, or with
 * u: before its name an unsigned integer. quotient, root and product_sum are the machine's own / and sqrt, and x * y + z,
 * which must be rounded twice. scripts/vectors reads this list too. */
#ifndef NPH_TESTS_FUNCTIONS_H
#define NPH_TESTS_FUNCTIONS_H

#define NPH_FUNCTIONS(X)                                                                                            \
    X(philox, "u:key0 u:key1 u:c0 u:c1 u:c2 u:c3", "u:w0 u:w1 u:w2 u:w3")                                           \
    X(uniform, "u:word", "x")                                                                                       \
    X(quotient, "x y", "x/y")                                                                                       \
    X(root, "x", "sqrt(x)")                                                                                         \
    X(product_sum, "x y z", "x*y+z")                                                                                \
    X(exp, "x", "exp(x)")                                                                                           \
    X(expm1, "x", "expm1(x)")                                                                                       \
    X(exp2, "x", "exp2(x)")                                                                                         \
    X(log, "x", "log(x)")                                                                                           \
    X(log1p, "x", "log1p(x)")                                                                                       \
    X(sin, "x", "sin(x)")                                                                                           \
    X(cos, "x", "cos(x)")                                                                                           \
    X(tan, "x", "tan(x)")                                                                                           \
    X(sincos2pi, "x", "sine cosine")                                                                                \
    X(asin, "x", "asin(x)")                                                                                         \
    X(acos, "x", "acos(x)")                                                                                         \
    X(cbrt, "x", "cbrt(x)")                                                                                         \
    X(floor, "x", "floor(x)")                                                                                       \
    X(atan2, "y x", "atan2(y,x)")                                                                                   \
    X(pow, "x y", "pow(x,y)")                                                                                       \
    X(hg_value, "g rest fall rise", "value")                                                                        \
    X(hg_sample, "g rest u", "cosine fall rise")                                                                    \
    X(rayleigh_value, "fall rise", "value")                                                                         \
    X(rayleigh_sample, "u", "cosine fall rise")                                                                     \
    X(draine_value, "g rest alpha scale fall rise", "value")                                                        \
    X(draine_sample, "g rest alpha norm split u", "cosine fall rise")                                               \
    X(phase_of, "u:kind g0 g1 weight alpha", "u:kind rest0 rest1 alpha norm scale split")                           \
    X(phase_at, "u:kind g0 g1 rest0 rest1 weight alpha norm scale split fall rise", "value")                        \
    X(phase_angle, "u:kind g0 g1 rest0 rest1 weight alpha norm scale split u lobe", "cosine fall rise")             \
    X(turn_by, "dx dy dz cosine fall rise u_azimuth", "x y z")

enum { NPH_WORDS_IN = 12, NPH_WORDS_OUT = 7 };

#define NPH_FUNCTION_NUMBER(name, in, out) F_##name,
typedef enum NphFunction { NPH_FUNCTIONS(NPH_FUNCTION_NUMBER) F_COUNT } NphFunction;

#endif
