/* SPDX-License-Identifier: Apache-2.0
 *
 * What the path tracer does for a scene, and why it leaves the rest out. */
#ifndef NPH_TRUTH_PATH_PLAN_H
#define NPH_TRUTH_PATH_PLAN_H

#include "truth/path/path.h"

NphStatus nph_path_plan(const NphJob *job, NphPlan *plan);

#endif
