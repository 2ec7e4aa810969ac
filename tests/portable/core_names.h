/* SPDX-License-Identifier: Apache-2.0
 *
 * The library's own functions under the names that nephos/portable.h gives them; for float kernels. */
#ifndef NPH_TESTS_CORE_NAMES_H
#define NPH_TESTS_CORE_NAMES_H

#include "core/philox.h"
#include "optics/phase_lookup.h"

#define NPH_PORTABLE_FN static inline
#define NphU32 uint32_t
#define NphScatterAnglef RAngle
#define NphDrainef RDraine
#define NphPhasef RPhase
#define nph_hg_valuef r_hg_value
#define nph_hg_samplef r_hg_sample
#define nph_rayleigh_valuef r_rayleigh_value
#define nph_rayleigh_samplef r_rayleigh_sample
#define nph_draine_valuef r_draine_value
#define nph_draine_samplef r_draine_sample
#define nph_phase_of r_phase_of
#define nph_phase_atf r_phase_at
#define nph_phase_anglef r_phase_angle
#define nph_turn_byf r_turn_by

#endif
