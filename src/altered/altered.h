/* SPDX-License-Identifier: Apache-2.0
 *
 * Altered kernels: which alteration the process makes now. Process-wide, so one run at a time: the reason why this is a program of
 * its own and no part of the library. */
#ifndef NPH_ALTERED_ALTERED_H
#define NPH_ALTERED_ALTERED_H

#include "core/accuracy.h"
#include "core/bug.h"
#include "scene/model.h"

/* The bugs marked "scene" in core/bug.h: hands the kernels a wrong scene. Once, after loading. */
void altered_change_scene(NphScene *scene);

/* Interfaces whose functions' accuracy can be simulated: set nph_accuracy to one of them. */
int altered_interface_count(void);
const NphAccuracy *altered_interface(int index);

/* Of kernels there are three builds, under the names of the vector levels: base is exact but for what is asked for above; avx2
 * contracts a * b + c to one rounding, avx512 divides by approximate reciprocals. The level of what opens next; 0 where
 * this processor or build has none. */
int altered_choose_level(NphContext *context, NphIsa level);

#endif
