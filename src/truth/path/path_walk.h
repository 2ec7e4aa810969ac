/* SPDX-License-Identifier: Apache-2.0
 *
 * Free flights through one medium. Media are tracked one by one, each in its own space: their collisions are
 * independent Poisson processes, whose superposition has the summed extinction; the nearest collision is the path's and
 * tells the medium, and the transmittance is the product of the media's.
 *
 *   delta tracking    tentative collisions at rate M (the cell's majorant), real with probability sigma / M
 *                     [Woodcock65] [Coleman68]
 *   ratio tracking    transmittance = product over tentative collisions of 1 - sigma / M [Novak14]
 *   box, layer        closed form: t = -ln(1 - u) / sigma, exp(-sigma s)
 *
 * Cells of the majorant grid are walked plane by plane [Amanatides87]; an empty cell knows how many empty cells
 * surround it, which are crossed at once. Lookups are clamped to the cell, whose bound holds on its faces too. */
#ifndef NPH_TRUTH_PATH_WALK_H
#define NPH_TRUTH_PATH_WALK_H

#include "truth/path/path_state.h"

#define R_HUGE R(1e30)
#define R_STILL R(1e-30) /* a direction component below this does not move */

/* The part [near, far] of a ray inside a medium, and the ray in the medium's space; directions are not normalised
 * there, so distances stay metres. */
typedef struct RSpan {
    Real o[3], d[3], inv[3];
    Real near, far;
} RSpan;

static inline void r_to_medium(const RMedium *medium, const Real p[3], const Real d[3], RSpan *span) {
    const Real *m = medium->from_local;
    for (int a = 0; a < 3; a++) {
        span->o[a] = m[4 * a] * p[0] + m[4 * a + 1] * p[1] + m[4 * a + 2] * p[2] + m[4 * a + 3];
        span->d[a] = m[4 * a] * d[0] + m[4 * a + 1] * d[1] + m[4 * a + 2] * d[2];
    }
}

/* Clips [0, limit] to the medium's box; 0 when nothing is left. */
static inline int r_clip(const RMedium *medium, const Real p[3], const Real d[3], Real limit, RSpan *span) {
    r_to_medium(medium, p, d, span);
    Real near = R(0.0), far = limit;
    int inside = 1;
    for (int a = 0; a < 3; a++) {
        int moving = r_abs(span->d[a]) > R_STILL;
        Real inv = R(1.0) / (moving ? span->d[a] : R(1.0));
        span->inv[a] = inv;
        if (!medium->bounded[a]) continue;
        Real t0 = (medium->lo[a] - span->o[a]) * inv, t1 = (medium->hi[a] - span->o[a]) * inv;
        Real first = t0 < t1 ? t0 : t1, last = t0 < t1 ? t1 : t0;
        if (moving) {
            near = first > near ? first : near;
            far = last < far ? last : far;
        } else if (span->o[a] < medium->lo[a] || span->o[a] > medium->hi[a]) {
            inside = 0;
        }
    }
    span->near = near;
    span->far = far;
    return inside && near < far;
}

/* Where a walk stands in the majorant grid. */
typedef struct RWalk {
    int32_t cell[3];
    Real t, exit;
    Real majorant;  /* of the density in this cell; 0: empty */
    int32_t step;   /* cells crossed at once: 1, or more in empty space */
    int32_t axis;   /* through whose plane the ray leaves; -1: it ends before */
} RWalk;

static inline int32_t r_cell_of(Real u, int32_t n) {
    int32_t cell = (int32_t)r_clamp(u * R(0.25), R(0.0), (Real)(n - 1));
    return cell;
}

/* Reads the cell's bound and finds where the ray leaves the cell (or the block of empty cells around it). */
static inline void r_walk_look(const RMedium *medium, const RSpan *span, RWalk *walk) {
    const int32_t *n = medium->majorant_n;
    Real bound = (Real)medium->majorant[((int64_t)walk->cell[2] * n[1] + walk->cell[1]) * n[0] + walk->cell[0]];
    int32_t step = bound < R(0.0) ? (int32_t)-bound : 1;
    Real exit = span->far;
    int32_t axis = -1;
    for (int a = 0; a < 3; a++) {
        int32_t plane = span->d[a] > R(0.0) ? walk->cell[a] + step : walk->cell[a] - step + 1;
        Real t = (R(4.0) * (Real)plane - span->o[a]) * span->inv[a];
        int crosses = (r_abs(span->d[a]) > R_STILL) & (t < exit);
        exit = crosses ? t : exit;
        axis = crosses ? a : axis;
    }
    walk->majorant = bound < R(0.0) ? R(0.0) : bound;
    walk->step = step;
    walk->exit = exit > walk->t ? exit : walk->t;
    walk->axis = axis;
}

static inline void r_walk_enter(const RMedium *medium, const RSpan *span, RWalk *walk) {
    walk->t = span->near;
    for (int a = 0; a < 3; a++) walk->cell[a] = r_cell_of(span->o[a] + span->near * span->d[a], medium->majorant_n[a]);
    r_walk_look(medium, span, walk);
}

/* Moves to the next cell; 0 when the ray leaves the medium. Cells move along the ray only, so the walk ends. */
static inline int r_walk_step(const RMedium *medium, const RSpan *span, RWalk *walk) {
    if (walk->axis < 0) return 0;
    walk->t = walk->exit;
    for (int a = 0; a < 3; a++) {
        int32_t old = walk->cell[a];
        int forward = span->d[a] > R(0.0);
        if (a == walk->axis) {
            walk->cell[a] = forward ? old + walk->step : old - walk->step;
            if (walk->cell[a] < 0 || walk->cell[a] >= medium->majorant_n[a]) return 0;
        } else if (walk->step > 1) {
            int32_t now = r_cell_of(span->o[a] + walk->t * span->d[a], medium->majorant_n[a]);
            int32_t last = forward ? old + walk->step - 1 : old - walk->step + 1;
            int32_t lo = forward ? old : last, hi = forward ? last : old;
            walk->cell[a] = now < lo ? lo : now > hi ? hi : now;
        }
    }
    for (int a = 0; a < 3; a++) /* the block of empty cells may reach beyond the grid on the other axes */
        if (walk->cell[a] < 0 || walk->cell[a] >= medium->majorant_n[a]) return 0;
    r_walk_look(medium, span, walk);
    return 1;
}

/* Density at distance t, the position clamped to the walk's cell and the medium's box. */
static inline Real r_walk_density(const RMedium *medium, const RSpan *span, const RWalk *walk, Real t) {
    Real u[3];
    for (int a = 0; a < 3; a++) {
        Real lo = R(4.0) * (Real)walk->cell[a], hi = lo + R(4.0);
        lo = lo > medium->lo[a] ? lo : medium->lo[a];
        hi = hi < medium->hi[a] ? hi : medium->hi[a];
        u[a] = r_clamp(span->o[a] + t * span->d[a], lo, hi);
    }
    return r_grid_value(&medium->grid, u[0], u[1], u[2]);
}

/* Tentative collisions of one flight through one medium: two random words each, distance and decision. */
typedef struct REvents {
    RStream stream;
    NphWords words;
    uint32_t count;
} REvents;

static inline REvents r_events(const RStream *stream, int light, uint32_t medium) {
    REvents events = {*stream, {0, 0, 0, 0}, 0};
    events.stream.draw = (uint32_t)light << NPH_DRAW_LIGHT_SHIFT | medium << NPH_DRAW_MEDIUM_SHIFT;
    return events;
}

static inline void r_next_event(REvents *events, Real *depth, Real *decision) {
    int second = events->count & 1u;
    if (!second) events->words = r_words(&events->stream, (events->count >> 1) & (NPH_MAX_BLOCKS - 1u));
    *depth = -r_log1p(-r_uniform(second ? events->words.w2 : events->words.w0));
    *decision = r_uniform(second ? events->words.w3 : events->words.w1);
    events->count++;
}

static inline int r_exhausted(const REvents *events) { return events->count >= 2u * NPH_MAX_BLOCKS; }

/* Goes on to the next tentative collision, at walk->t, whose decision is drawn; 0 when the medium ends before. *depth is
 * the optical depth of the majorant still to go. */
static inline int r_walk_to_collision(const RMedium *medium, const RSpan *span, RWalk *walk, Real depth) {
    for (;;) {
        Real rate = walk->majorant * medium->sigma_max;
        Real t = walk->t + depth / (rate > R(0.0) ? rate : R(1.0));
        if (rate > R(0.0) && t < walk->exit) {
            walk->t = t;
            return 1;
        }
        depth -= rate * (walk->exit - walk->t);
        depth = depth > R(0.0) ? depth : R(0.0);
        if (!r_walk_step(medium, span, walk)) return 0;
    }
}

/* Delta tracking of channel hero. Returns the distance of the first real collision before limit, or -1. */
static inline Real r_free_flight(const RMedium *medium, const Real p[3], const Real d[3], Real limit, int hero,
                                 REvents *events, NphPathTally *tally) {
    RSpan span;
    Real depth, decision;
    if (!(medium->sigma[hero] > R(0.0)) || !r_clip(medium, p, d, limit, &span)) return R(-1.0);
    r_next_event(events, &depth, &decision);
    if (medium->shape != NPH_SHAPE_GRID) {
        Real t = span.near + depth / medium->sigma[hero];
        tally->tentative++;
        return t < span.far ? t : R(-1.0);
    }
    RWalk walk;
    r_walk_enter(medium, &span, &walk);
    while (r_walk_to_collision(medium, &span, &walk, depth)) {
        Real density = r_walk_density(medium, &span, &walk, walk.t);
        tally->tentative++;
        tally->violations += density > walk.majorant;
        if (decision * walk.majorant < density * medium->ratio[hero]) return walk.t;
        if (r_exhausted(events)) {
            tally->exhausted++;
            break;
        }
        r_next_event(events, &depth, &decision);
    }
    return R(-1.0);
}

/* The same flight once more, up to limit, for media whose extinction differs between channels: what each channel would
 * have made of its virtual collisions, relative to the hero: factor[c] *= prod (1 - rho_c) / (1 - rho_hero); in closed
 * form exp(-(sigma_c - sigma_hero) s). */
static inline void r_flight_factors(const RMedium *medium, const Real p[3], const Real d[3], Real limit, int hero,
                                    REvents *events, Real factor[3]) {
    RSpan span;
    Real depth, decision;
    if (!r_clip(medium, p, d, limit, &span)) return;
    if (medium->shape != NPH_SHAPE_GRID) {
        for (int c = 0; c < 3; c++)
            factor[c] *= r_exp(-(medium->sigma[c] - medium->sigma[hero]) * (span.far - span.near));
        return;
    }
    r_next_event(events, &depth, &decision);
    RWalk walk;
    r_walk_enter(medium, &span, &walk);
    while (r_walk_to_collision(medium, &span, &walk, depth) && !r_exhausted(events)) {
        Real density = r_walk_density(medium, &span, &walk, walk.t);
        if (decision * walk.majorant < density * medium->ratio[hero]) return;
        Real rho = density / walk.majorant, null = R(1.0) - rho * medium->ratio[hero];
        for (int c = 0; c < 3; c++) factor[c] *= r_max(R(1.0) - rho * medium->ratio[c], R(0.0)) / null;
        r_next_event(events, &depth, &decision);
    }
}

/* Ratio tracking: multiplies T by an unbiased estimate of the transmittance up to limit. Below `roulette` (largest
 * channel) the walk survives with probability 1/4 and T grows by 4. channels is 1 or 3. */
static inline void r_transmittance(const RMedium *medium, const Real p[3], const Real d[3], Real limit,
                                   const RScene *scene, REvents *events, Real T[3], NphPathTally *tally) {
    RSpan span;
    Real depth, decision;
    if (!r_clip(medium, p, d, limit, &span)) return;
    tally->tentative++;
    if (medium->shape != NPH_SHAPE_GRID) {
        for (int c = 0; c < scene->channels; c++) T[c] *= r_exp(-medium->sigma[c] * (span.far - span.near));
        return;
    }
    r_next_event(events, &depth, &decision);
    RWalk walk;
    r_walk_enter(medium, &span, &walk);
    while (r_walk_to_collision(medium, &span, &walk, depth)) {
        Real density = r_walk_density(medium, &span, &walk, walk.t);
        Real rho = density / walk.majorant, largest = R(0.0);
        tally->tentative++;
        tally->violations += density > walk.majorant;
        for (int c = 0; c < scene->channels; c++) {
            T[c] *= r_max(R(1.0) - rho * medium->ratio[c], R(0.0));
            largest = T[c] > largest ? T[c] : largest;
        }
        if (largest < scene->shadow_roulette) {
            Real grow = decision < R(0.25) ? R(4.0) : R(0.0);
            for (int c = 0; c < scene->channels; c++) T[c] *= grow;
            largest *= grow;
        }
        if (!(largest > R(0.0))) return;
        if (r_exhausted(events)) {
            tally->exhausted++;
            return;
        }
        r_next_event(events, &depth, &decision);
    }
}

#endif
