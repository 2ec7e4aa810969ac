/* SPDX-License-Identifier: Apache-2.0
 *
 * The global names of what nph_single_launch calls, as those of kernels: where altered programs build it by level
 * (src/altered/meson.build), each build calls its own. */
#ifndef NPH_TRUTH_SINGLE_SINGLE_NAMES_H
#define NPH_TRUTH_SINGLE_SINGLE_NAMES_H

#include "core/real.h"

#define nph_gauss_point NPH_KERNEL(nph_gauss_point)
#define nph_gauss_weight NPH_KERNEL(nph_gauss_weight)
#define nph_profile_at NPH_KERNEL(nph_profile_at)
#define nph_profile_build NPH_KERNEL(nph_profile_build)
#define nph_profile_move NPH_KERNEL(nph_profile_move)
#define nph_profile_seek NPH_KERNEL(nph_profile_seek)
#define nph_profile_thin NPH_KERNEL(nph_profile_thin)
#define nph_single_arrive NPH_KERNEL(nph_single_arrive)
#define nph_single_batch_doubles NPH_KERNEL(nph_single_batch_doubles)
#define nph_single_beam NPH_KERNEL(nph_single_beam)
#define nph_single_buffers NPH_KERNEL(nph_single_buffers)
#define nph_single_check NPH_KERNEL(nph_single_check)
#define nph_single_fold NPH_KERNEL(nph_single_fold)
#define nph_single_follow NPH_KERNEL(nph_single_follow)
#define nph_single_gather NPH_KERNEL(nph_single_gather)
#define nph_single_integrate NPH_KERNEL(nph_single_integrate)
#define nph_single_launch NPH_KERNEL(nph_single_launch)
#define nph_single_leave NPH_KERNEL(nph_single_leave)
#define nph_single_march NPH_KERNEL(nph_single_march)
#define nph_single_meet NPH_KERNEL(nph_single_meet)
#define nph_single_opaque NPH_KERNEL(nph_single_opaque)
#define nph_single_ray NPH_KERNEL(nph_single_ray)
#define nph_single_scratch_bytes NPH_KERNEL(nph_single_scratch_bytes)
#define nph_single_scratch_layout NPH_KERNEL(nph_single_scratch_layout)
#define nph_single_tally NPH_KERNEL(nph_single_tally)
#define nph_single_tell NPH_KERNEL(nph_single_tell)
#define nph_single_transmittance NPH_KERNEL(nph_single_transmittance)
#define nph_single_view NPH_KERNEL(nph_single_view)

#endif
