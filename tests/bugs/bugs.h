/* SPDX-License-Identifier: Apache-2.0
 *
 * In test programs that are built against kernels with known bugs (core/bug.h): the bug to make is the number in
 * NEPHOS_BUG, none when there is no such variable. */
#ifndef NPH_TESTS_BUGS_H
#define NPH_TESTS_BUGS_H

#include "nephos/scene.h"

void bugs_choose(void);

/* Bugs that live in a scene: changes what has been read. */
void bugs_change_scene(NphScene *scene);

#endif
