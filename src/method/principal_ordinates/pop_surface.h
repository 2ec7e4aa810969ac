/* SPDX-License-Identifier: Apache-2.0
 *
 * What principal ordinates know of surfaces: what the medium leaves of a beam between two places, what a virtual point light sends, and
 * the light that a surface reflects to the camera. */
#ifndef NPH_METHOD_POP_SURFACE_H
#define NPH_METHOD_POP_SURFACE_H

#include "method/principal_ordinates/pop_kept.h"
#include "transport/flight_lookup.h"
#include "transport/surfaces_lookup.h"

/* Along a unit direction, by steps of half a cell through the downscaled medium, which is that of the grids' own beams. */
static inline void r_pop_transmittance(const RPopScene *scene, const Real *medium, const Real p[3], const Real d[3], Real limit, Real T[3]) {
    RSpan span = r_clip(&scene->medium, p, d, limit);
    Real sum = R(0.0), step = R(0.0);
    if (span.inside) {
        int32_t steps = 1 + (int32_t)((span.far - span.near) / scene->beam);
        step = (span.far - span.near) / (Real)steps;
        for (int32_t k = 0; k < steps; k++) {
            Real t = span.near + ((Real)k + R(0.5)) * step;
            sum += r_pop_density(scene, medium, span.o[0] + t * span.d[0], span.o[1] + t * span.d[1], span.o[2] + t * span.d[2]);
        }
    }
    for (int c = 0; c < 3; c++) T[c] = r_exp(-scene->sigma_t[c] * sum * step);
}

/* 1 over the square of the distance to a virtual point light that stands for the area A. On the axis of a disc its radiance brings
 * pi L A / (A + pi r^2): so A / pi is added, times pop.clamp. */
R_INLINE Real r_pop_fall(const RPopScene *scene, const Real *row, Real squared) {
    return R(1.0) / r_max(squared + scene->clamp * row[NPH_POP_AREA] * R(0.31830988618379067), R(1e-30));
}

/* Towards the light of a grid: unit direction, distance, and what arrives across that direction, without media and shadows. */
typedef struct RPopBeam {
    Real to[3], distance, arrives;
} RPopBeam;

static inline RPopBeam r_pop_beam(const RPopScene *scene, const Real *row, int number, const Real p[3]) {
    const NphPopChoice *choice = &scene->choice;
    RPopBeam beam = {{-row[NPH_POP_WAY], -row[NPH_POP_WAY + 1], -row[NPH_POP_WAY + 2]}, R_HUGE, R(1.0)};
    if (number < choice->suns + choice->sky) return beam;
    Real squared = R(0.0);
    for (int a = 0; a < 3; a++) {
        beam.to[a] = row[NPH_POP_WAY + a] - p[a];
        squared += beam.to[a] * beam.to[a];
    }
    beam.distance = r_sqrt(r_max(squared, R(1e-30)));
    for (int a = 0; a < 3; a++) beam.to[a] /= beam.distance;
    beam.arrives = R(1.0) / r_max(squared, R(1e-30));
    if (number >= nph_pop_lamps(choice)) beam.arrives = r_pop_fall(scene, row, squared) * r_max(-r_dot(row + NPH_POP_NORMAL, beam.to), R(0.0));
    return beam;
}

static inline Real r_pop_weight(const RPopScene *scene, const Real *row, int number, const RMet *met) {
    RPopBeam beam = r_pop_beam(scene, row, number, met->p);
    return beam.arrives * r_max(r_dot(met->n, beam.to), R(0.0)) * r_luminance(row + NPH_POP_VALUE);
}

/* Light of one of the grids [first, end), drawn by what it would bring, that a surface reflects to all sides alike. */
static inline void r_pop_reflect(const RPopScene *scene, const NphPopArrays *arrays, const RMet *met, const int grids[2], Real random, Real light[3]) {
    const Real *rows = arrays->ordinate;
    Real all = R(0.0), sum = R(0.0), weight = R(0.0), T[3];
    int number = -1;
    for (int n = grids[0]; n < grids[1]; n++) all += r_pop_weight(scene, rows + (int64_t)n * NPH_POP_ROW, n, met);
    for (int n = grids[0]; n < grids[1]; n++) {
        Real part = r_pop_weight(scene, rows + (int64_t)n * NPH_POP_ROW, n, met);
        if (!(part > R(0.0))) continue;
        number = n;
        weight = part;
        sum += part;
        if (sum > random * all) break;
    }
    if (number < 0) return;
    const Real *row = rows + (int64_t)number * NPH_POP_ROW;
    RPopBeam beam = r_pop_beam(scene, row, number, met->p);
    if (r_blocked(&scene->local, met->p, beam.to, beam.distance * R(0.9999))) return;
    r_pop_transmittance(scene, arrays->medium, met->p, beam.to, beam.distance, T);
    Real share = beam.arrives * r_dot(met->n, beam.to) * all / weight * R_1_PI;
    for (int c = 0; c < 3; c++) light[c] += scene->local.surfaces.albedo[met->surface][c] * row[NPH_POP_VALUE + c] * T[c] * share;
}

#endif
