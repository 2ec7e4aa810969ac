/* SPDX-License-Identifier: Apache-2.0
 *
 * See float_state.h. On AArch64 fesetround leaves FPCR's flush-to-zero bit (24) alone, so it is cleared by hand. */
#include "core/float_state.h"

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

void nph_float_state_enter(NphFloatState *saved) {
    fegetenv(&saved->environment);
    fesetround(FE_TONEAREST);
    saved->control = 0;
#if defined(__SSE2__)
    saved->control = _mm_getcsr();
    _mm_setcsr((saved->control & ~0xE040u) | 0x1F80u); /* nearest, no FTZ, no DAZ, no traps */
#elif defined(__aarch64__)
    unsigned long control;
    __asm__ volatile("mrs %0, fpcr" : "=r"(control));
    __asm__ volatile("msr fpcr, %0" : : "r"(control & ~(1ul << 24)));
#endif
}

void nph_float_state_leave(const NphFloatState *saved) {
#if defined(__SSE2__)
    _mm_setcsr(saved->control);
#endif
    fesetenv(&saved->environment);
}
