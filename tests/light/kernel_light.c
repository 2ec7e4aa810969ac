/* SPDX-License-Identifier: Apache-2.0
 *
 * See kernel_light.h. */
#include "kernel_light.h"

#include "core/philox.h"
#include "light/light_lookup.h"

static void keep(LightQuery *query, const Real d[3], const Real radiance[3], Real density) {
    for (int a = 0; a < 3; a++) {
        query->d[a] = (double)d[a];
        query->radiance[a] = (double)radiance[a];
    }
    query->density = (double)density;
}

void NPH_KERNEL(light_sample)(const NphEnvironment *map, double rotation_rad, LightQuery *queries, int count) {
    REnvironment environment = r_environment(map, rotation_rad);
    for (int i = 0; i < count; i++) {
        Real d[3], radiance[3];
        Real density = r_environment_sample(&environment, r_uniform(queries[i].u), r_uniform(queries[i].w), d, radiance);
        keep(&queries[i], d, radiance, density);
    }
}

void NPH_KERNEL(light_lookup)(const NphEnvironment *map, double rotation_rad, LightQuery *queries, int count) {
    REnvironment environment = r_environment(map, rotation_rad);
    for (int i = 0; i < count; i++) {
        Real d[3] = {(Real)queries[i].d[0], (Real)queries[i].d[1], (Real)queries[i].d[2]}, radiance[3];
        Real density = r_environment_lookup(&environment, d, radiance);
        keep(&queries[i], d, radiance, density);
    }
}

void NPH_KERNEL(light_disc)(const double axis[3], double half_angle_rad, LightQuery *queries, int count) {
    RDisc disc = r_disc(axis, half_angle_rad);
    for (int i = 0; i < count; i++) {
        Real d[3], none[3] = {R(0.0), R(0.0), R(0.0)};
        r_disc_sample(&disc, r_uniform(queries[i].u), r_uniform(queries[i].w), d);
        keep(&queries[i], d, none, disc.density);
        queries[i].held = r_disc_holds(&disc, d);
    }
}
