/* SPDX-License-Identifier: Apache-2.0
 *
 * light/light_lookup.h in both precisions for test_environment.c; directions and results are doubles in either. */
#ifndef NPH_TESTS_KERNEL_LIGHT_H
#define NPH_TESTS_KERNEL_LIGHT_H

#include "core/cpu.h"
#include "light/light.h"

typedef struct LightQuery {
    double d[3], radiance[3], density;
    uint32_t u, w; /* the words a direction is drawn with */
    int held;      /* disc: whether the drawn direction lies in it */
} LightQuery;

NPH_KERNEL_DECLARE(void, light_sample, (const NphEnvironment *map, double rotation_rad, LightQuery *queries, int count));
NPH_KERNEL_DECLARE(void, light_lookup, (const NphEnvironment *map, double rotation_rad, LightQuery *queries, int count));
NPH_KERNEL_DECLARE(void, light_disc, (const double axis[3], double half_angle_rad, LightQuery *queries, int count));

#endif
