/* SPDX-License-Identifier: Apache-2.0
 *
 * See altered.h. */
#include "altered/altered.h"

int nph_bug_number;

/* The lattice of a grid changed before it is placed in the world. */
static void change_lattice(NphScene *scene, const double change[12]) {
    for (int m = 0; m < scene->medium_count; m++)
        if (scene->media[m].shape == NPH_SHAPE_GRID)
            nph_affine_multiply(scene->media[m].world_from_medium, change, scene->media[m].world_from_medium);
}

void altered_change_scene(NphScene *scene) {
    static const double half[12] = {1, 0, 0, 0.5, 0, 1, 0, 0.5, 0, 0, 1, 0.5};
    static const double swapped[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 0};
    static const double twice[12] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0};
    if (NPH_BUG(8)) change_lattice(scene, half);
    if (NPH_BUG(9)) change_lattice(scene, swapped);
    if (NPH_BUG(11)) change_lattice(scene, twice);
}
