/* SPDX-License-Identifier: Apache-2.0
 *
 * See kernel_photonmap.h. */
#include "kernel_photonmap.h"

#include <string.h>

#include "truth/photonmap/photonmap_2_estimate.h"
#include "truth/photonmap/photonmap_depth.h"
#include "truth/photonmap/photonmap_emit.h"

void NPH_KERNEL(photonmap_uniform)(NphPhotonMap *map, uint32_t seed) {
    RPhoton *photons = map->photons;
    RKdNode *items = map->tree.items;
    for (int32_t i = 0; i < map->tree.count; i++) {
        NphWords words = nph_philox(seed, 3, (uint32_t)i, 0, 0, 0);
        RPhoton photon = {{R(0.0), R(0.0), R(1.0)}, {R(0.0), R(0.0), R(0.0)}, R(1.0), 0, 2};
        for (int c = 0; c < 3; c++) photon.power[c] = R(1.0) / (Real)map->tree.count;
        RKdNode item = {{r_uniform(words.w0), r_uniform(words.w1), r_uniform(words.w2)}, (uint32_t)i << 2};
        photons[i] = photon;
        items[i] = item;
    }
}

double NPH_KERNEL(photonmap_estimate)(const NphPhotonMap *map, const double p[3], int nearest, double reach,
                                      int printed) {
    static RPhotonScene scene; /* isotropic: all zeros */
    Real at[3] = {(Real)p[0], (Real)p[1], (Real)p[2]}, d[3] = {R(0.0), R(1.0), R(0.0)};
    memset(&scene, 0, sizeof scene);
    scene.local.medium_count = 1;
    scene.nearest = nearest;
    scene.reach = (Real)reach;
    scene.printed = printed;
    return 12.566370614359172 * (double)r_estimate(&scene, map, at, d, R(1.0)).radiance[0];
}

double NPH_KERNEL(photonmap_power)(const NphPhotonMap *map, int order) {
    const RPhoton *photons = map->photons;
    double sum = 0.0;
    for (int32_t i = 0; i < map->tree.count; i++)
        if (order == 0 || photons[i].order == order) sum += (double)photons[i].power[0];
    return sum;
}

static RSpan span_of(const RMedium *medium, const double ray[6]) {
    Real p[3], d[3];
    for (int a = 0; a < 3; a++) {
        p[a] = (Real)ray[a];
        d[a] = (Real)ray[3 + a];
    }
    return r_clip(medium, p, d, R_HUGE);
}

double NPH_KERNEL(photonmap_depth)(const void *scene, const double ray[6], double from, double to) {
    const RMedium *medium = &((const RPhotonScene *)scene)->local.media[0];
    RSpan span = span_of(medium, ray);
    return (double)r_depth(medium, &span, (Real)from, (Real)to);
}

double NPH_KERNEL(photonmap_depth_sum)(const void *scene, const double ray[6], const double range[2], int steps) {
    const RMedium *medium = &((const RPhotonScene *)scene)->local.media[0];
    RSpan span = span_of(medium, ray);
    double sum = 0.0, width = (range[1] - range[0]) / steps;
    for (int i = 0; i < steps; i++) {
        Real t = (Real)(range[0] + (i + 0.5) * width), u[3];
        int inside = span.inside && t >= span.near && t < span.far;
        for (int a = 0; a < 3; a++) u[a] = r_clamp(span.o[a] + t * span.d[a], medium->lo[a], medium->hi[a]);
        if (inside)
            sum += medium->shape == NPH_SHAPE_GRID ? (double)r_grid_value(&medium->grid, u[0], u[1], u[2]) : 1.0;
    }
    return sum * width;
}

double NPH_KERNEL(photonmap_sky_power)(const void *scene) {
    enum { ROWS = 512, COLUMNS = 1024 };
    const RScene *local = &((const RPhotonScene *)scene)->local;
    double sum = 0.0;
    for (int row = 0; row < ROWS; row++)
        for (int column = 0; column < COLUMNS; column++) {
            double z = 1.0 - 2.0 * (row + 0.5) / ROWS, across = nph_sqrt(1.0 - z * z), sine, cosine, areas[3];
            nph_sincos2pi((column + 0.5) / COLUMNS, &sine, &cosine);
            Real d[3] = {(Real)(across * cosine), (Real)(across * sine), (Real)z}, radiance[3];
            double along[3] = {(double)d[0], (double)d[1], (double)d[2]};
            r_environment_lookup(&local->lights[0].map, d, radiance);
            sum += (double)radiance[0] * r_box_areas(local, along, areas);
        }
    return sum * 12.566370614359172 / (ROWS * COLUMNS);
}
