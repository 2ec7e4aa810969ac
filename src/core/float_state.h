/* SPDX-License-Identifier: Apache-2.0
 *
 * The floating-point state that all results assume: round to nearest, neither flush-to-zero nor denormals-are-zero.
 * Workers and API entries that compute enter it, and leave the caller's as it was. */
#ifndef NPH_CORE_FLOAT_STATE_H
#define NPH_CORE_FLOAT_STATE_H

#include <fenv.h>

typedef struct NphFloatState {
    fenv_t environment;
    unsigned control; /* MXCSR; unused elsewhere */
} NphFloatState;

void nph_float_state_enter(NphFloatState *saved);
void nph_float_state_leave(const NphFloatState *saved);

#endif
