/* SPDX-License-Identifier: Apache-2.0
 *
 * Altered kernels: which alteration the process makes now. Process-wide, so one run at a time: the reason why this is a program of
 * its own and no part of the library. */
#ifndef NPH_ALTERED_ALTERED_H
#define NPH_ALTERED_ALTERED_H

#include "core/bug.h"
#include "scene/model.h"

/* The bugs marked "scene" in core/bug.h: hands the kernels a wrong scene. Once, after loading. */
void altered_change_scene(NphScene *scene);

#endif
