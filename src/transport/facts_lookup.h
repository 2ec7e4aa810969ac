/* SPDX-License-Identifier: Apache-2.0
 *
 * The scene as kernels see it, told as numbers under names (NphMethod.facts; docs/oracle.md lists them): what a port is fed with
 * beside the buffers of its stages. */
#ifndef NPH_TRANSPORT_FACTS_LOOKUP_H
#define NPH_TRANSPORT_FACTS_LOOKUP_H

#include "pipeline/method.h"
#include "transport/local_scene.h"

enum { R_FACT_MOST = NPH_MAX_WAVELENGTHS + 3 };

static inline void r_fact(NphFactFn fact, void *user, const char *name, Real value) { fact(user, -1, name, 1, (double[]){(double)value}); }

static inline void r_medium_fact(NphFactFn fact, void *user, const RMedium *medium, const char *name, int count, const Real *values) {
    double wide[R_FACT_MOST] = {0.0};
    for (int i = 0; i < count; i++) wide[i] = (double)values[i];
    fact(user, (int)medium->number, name, count, wide);
}

/* Three channels of every group of wavelengths. */
static inline void r_group_facts(const RScene *groups, int count, int m, NphFactFn fact, void *user) {
    Real sigma[R_FACT_MOST], albedo[R_FACT_MOST], most[R_FACT_MOST];
    for (int g = 0; g < count; g++) {
        const RMedium *medium = &groups[g].media[m];
        most[g] = medium->sigma_max;
        for (int c = 0; c < 3; c++) {
            sigma[3 * g + c] = medium->sigma[c];
            albedo[3 * g + c] = medium->albedo[c];
        }
    }
    const RMedium *medium = &groups[0].media[m];
    r_medium_fact(fact, user, medium, "sigma", 3 * count, sigma);
    r_medium_fact(fact, user, medium, "sigma_max", count, most);
    r_medium_fact(fact, user, medium, "collide", 1, &medium->collide);
    r_medium_fact(fact, user, medium, "albedo_over_collide", 3 * count, albedo);
}

static inline void r_medium_facts(const RScene *groups, int count, int m, NphFactFn fact, void *user) {
    const RMedium *medium = &groups[0].media[m];
    Real position = (Real)m, samples[3], cells[3], nearest = (Real)(medium->grid.weight < 0.5f);
    r_medium_fact(fact, user, medium, "position", 1, &position);
    r_medium_fact(fact, user, medium, "medium_from_local", 12, medium->from_local);
    r_medium_fact(fact, user, medium, "lo", 3, medium->lo);
    r_medium_fact(fact, user, medium, "hi", 3, medium->hi);
    r_group_facts(groups, count, m, fact, user);
    if (medium->shape == NPH_SHAPE_AIR) {
        r_medium_fact(fact, user, medium, "scale_height", 1, &medium->scale_height);
        r_medium_fact(fact, user, medium, "radius", 1, &medium->radius);
    }
    if (medium->shape != NPH_SHAPE_GRID) return;
    for (int a = 0; a < 3; a++) {
        samples[a] = (Real)medium->grid.n[a];
        cells[a] = (Real)medium->majorant_n[a];
    }
    r_medium_fact(fact, user, medium, "samples", 3, samples);
    r_medium_fact(fact, user, medium, "cells", 3, cells);
    r_medium_fact(fact, user, medium, "nearest", 1, &nearest);
}

static inline void r_scene_facts(const RScene *groups, int count, NphFactFn fact, void *user) {
    const RPeriod *period = &groups[0].period;
    fact(user, -1, "origin", 3, groups[0].origin);
    r_fact(fact, user, "channels", (Real)groups[0].channels);
    r_fact(fact, user, "film_channels", (Real)groups[0].film_channels);
    r_fact(fact, user, "groups", (Real)count);
    r_fact(fact, user, "surfaces", (Real)groups[0].surfaces.count);
    if (period->on) {
        fact(user, -1, "period_lo", 2, (double[]){(double)period->lo[0], (double)period->lo[1]});
        fact(user, -1, "period_size", 2, (double[]){(double)period->size[0], (double)period->size[1]});
    }
    for (int m = 0; m < groups[0].medium_count; m++) r_medium_facts(groups, count, m, fact, user);
}

#endif
