/* SPDX-License-Identifier: Apache-2.0
 *
 * optics/phase_lookup.h in both precisions for test_phase.c; arguments and results are doubles in either. */
#ifndef NPH_TESTS_KERNEL_PHASE_H
#define NPH_TESTS_KERNEL_PHASE_H

#include "core/cpu.h"
#include "optics/phase.h"

/* Angles drawn with the words of u and lobe: out[0] receives fall, out[1] rise, out[2] cos. */
NPH_KERNEL_DECLARE(void, phase_draw, (const NphPhase *phase, const uint32_t *u, const uint32_t *lobe,
                                      double *const out[3], int count));
/* Values at angles; with rise NULL from fall alone. */
NPH_KERNEL_DECLARE(void, phase_value, (const NphPhase *phase, const double *fall, const double *rise, double *value,
                                       int count));
/* d is turned count times by the angles (fall, rise) and azimuths; the last direction is left in d. */
NPH_KERNEL_DECLARE(void, phase_turn, (double d[3], const double *fall, const double *rise, const double *azimuth,
                                      int count));

#endif
