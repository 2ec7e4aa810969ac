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
 *   air               closed form, or delta tracking around a sphere (air_lookup.h)
 *
 * Cells of the majorant grid are walked plane by plane [Amanatides87]; an empty cell knows how many empty cells
 * surround it, which are crossed at once. Lookups are clamped to the cell, whose bound holds on its faces too. */
#ifndef NPH_TRANSPORT_FLIGHT_LOOKUP_H
#define NPH_TRANSPORT_FLIGHT_LOOKUP_H

#include <assert.h>

#include "transport/air_lookup.h"
#include "transport/choice.h"

#define R_HUGE R(1e30)
#define R_FAR R(1e36)
#define R_STILL R(1e-30) /* a direction component below this does not move */

/* The part [near, far] of a ray inside a medium, and the ray in the medium's space; directions are not normalised
 * there, so distances stay metres. inv = 1 / d, and R_HUGE along an axis that the ray does not move along: a plane
 * ahead is then never reached. A ray that runs within the upper face of the box is outside. */
typedef struct RSpan {
    Real o[3], d[3], inv[3];
    Real near, far;
    int inside;
} RSpan;

typedef struct RAxis {
    Real o, d, inv, near, far;
    int inside;
} RAxis;

/* One axis of the medium's space; written without arrays and loops, which gcc would keep in memory. */
static inline RAxis r_clip_axis(const Real row[4], const Real p[3], const Real d[3], Real lo, Real hi) {
    RAxis axis;
    axis.o = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
    axis.d = row[0] * d[0] + row[1] * d[1] + row[2] * d[2];
    int moving = r_abs(axis.d) > R_STILL;
    axis.inv = moving ? R(1.0) / axis.d : R_HUGE;
    Real t0 = (lo - axis.o) * axis.inv, t1 = (hi - axis.o) * axis.inv;
    Real first = t0 < t1 ? t0 : t1, last = t0 < t1 ? t1 : t0;
    axis.near = moving ? first : R(0.0);
    axis.far = moving ? last : R_HUGE;
    axis.inside = moving | ((axis.o >= lo) & (axis.o < hi));
    return axis;
}

/* The ray in the medium's space, clipped to [from, limit] and the medium's box; inside 0 when nothing is left. */
static inline RSpan r_clip_between(const RMedium *medium, const Real p[3], const Real d[3], Real from, Real limit) {
    RAxis x = r_clip_axis(medium->from_local, p, d, medium->lo[0], medium->hi[0]);
    RAxis y = r_clip_axis(medium->from_local + 4, p, d, medium->lo[1], medium->hi[1]);
    RAxis z = r_clip_axis(medium->from_local + 8, p, d, medium->lo[2], medium->hi[2]);
    Real near = x.near > from ? x.near : from, far = x.far < limit ? x.far : limit;
    near = y.near > near ? y.near : near;
    far = y.far < far ? y.far : far;
    near = z.near > near ? z.near : near;
    far = z.far < far ? z.far : far;
    int inside = x.inside & y.inside & z.inside & (near < far);
    RSpan span = {{x.o, y.o, z.o}, {x.d, y.d, z.d}, {x.inv, y.inv, z.inv}, near, far, inside};
    return span;
}

static inline RSpan r_clip(const RMedium *medium, const Real p[3], const Real d[3], Real limit) {
    return r_clip_between(medium, p, d, R(0.0), limit);
}

/* Sides that repeat. The ray is unfolded: it crosses images of the medium, cut to the period, one after the other, and
 * distances go on. In image (i, j) the ray in the medium's first period begins at p - (i, j) size. Images are visited from
 * where the ray first may meet the medium along the axes that do not repeat, to where it last may, so that rays do not walk
 * through the clear air above and below. A ray that stays level for ever passes NPH_MAX_IMAGES of them. */
typedef struct RImage {
    int32_t at[2];
    int32_t left;         /* images that may still follow; 0: given up */
    Real near, far, end;  /* part of the ray in this image; where the last one ends */
} RImage;

/* Distance to the side through which the ray leaves the image along axis a. */
static inline Real r_image_side(const RPeriod *period, const Real p[3], const Real d[3], int a, int32_t at) {
    int still = !(r_abs(d[a]) > R_STILL) | !(period->size[a] > R(0.0));
    Real side = period->lo[a] + (Real)(at + (d[a] > R(0.0) ? 1 : 0)) * period->size[a];
    return still ? R_HUGE : (side - p[a]) / d[a];
}

static inline void r_image_reach(const RPeriod *period, const Real p[3], const Real d[3], RImage *image) {
    Real x = r_image_side(period, p, d, 0, image->at[0]), y = r_image_side(period, p, d, 1, image->at[1]);
    Real far = x < y ? x : y;
    far = far < image->end ? far : image->end;
    image->far = far > image->near ? far : image->near;
}

/* The first image of a ray, up to limit; without periods the whole ray. end = near when it never meets the medium. */
static inline RImage r_first_image(const RMedium *medium, const Real p[3], const Real d[3], Real limit) {
    RImage image = {{0, 0}, NPH_MAX_IMAGES, R(0.0), limit, limit};
    const RPeriod *period = &medium->period;
    if (!period->on) return image;
    for (int a = 0; a < 3; a++) {
        int moving = r_abs(d[a]) > R_STILL, within = (p[a] >= medium->reach_lo[a]) & (p[a] <= medium->reach_hi[a]);
        Real inv = moving ? R(1.0) / d[a] : R(1.0);
        Real t0 = (medium->reach_lo[a] - p[a]) * inv, t1 = (medium->reach_hi[a] - p[a]) * inv;
        Real first = t0 < t1 ? t0 : t1, last = t0 < t1 ? t1 : t0;
        if (moving && first > image.near) image.near = first;
        if (moving && last < image.end) image.end = last;
        if (!moving && !within) image.end = R(0.0);
    }
    image.end = image.end > image.near ? image.end : image.near;
    for (int a = 0; a < 2; a++) {
        Real count = (p[a] + image.near * d[a] - period->lo[a]) * period->inverse[a];
        image.at[a] = (int32_t)r_clamp(r_floor(count), R(-1e9), R(1e9));
    }
    r_image_reach(period, p, d, &image);
    return image;
}

/* Goes on to the next image; 0 behind the last one, and when so many were passed that the ray may never leave. */
static inline int r_next_image(const RMedium *medium, const Real p[3], const Real d[3], RImage *image) {
    const RPeriod *period = &medium->period;
    if (!period->on || !(image->far < image->end) || --image->left == 0) return 0;
    Real x = r_image_side(period, p, d, 0, image->at[0]), y = r_image_side(period, p, d, 1, image->at[1]);
    int a = x < y ? 0 : 1;
    image->at[a] += d[a] > R(0.0) ? 1 : -1;
    image->near = image->far;
    r_image_reach(period, p, d, image);
    return 1;
}

static inline RSpan r_image_span(const RMedium *medium, const Real p[3], const Real d[3], const RImage *image) {
    const RPeriod *period = &medium->period;
    if (!period->on) return r_clip(medium, p, d, image->far);
    Real q[3] = {p[0] - (Real)image->at[0] * period->size[0], p[1] - (Real)image->at[1] * period->size[1], p[2]};
    return r_clip_between(medium, q, d, image->near, image->far);
}

/* Where a walk stands in the majorant grid: its cell, how far along the ray, and the optical depth of the majorant still
 * to go to the next tentative collision. */
typedef struct RWalk {
    int32_t c0, c1, c2;
    int state;
    Real t, depth, majorant; /* majorant: of the density in the cell where a tentative collision happens */
    Real expected;           /* depth so far by the cells' mean densities: weighed flights alone ask for it */
} RWalk;
enum { R_WALKING, R_COLLIDES, R_LEFT };

static inline int32_t r_cell_of(Real u, int32_t n) { return (int32_t)r_clamp(u * R(0.25), R(0.0), (Real)(n - 1)); }

static inline RWalk r_walk_enter(const int32_t n[3], const RSpan *span, Real depth) {
    RWalk walk = {r_cell_of(span->o[0] + span->near * span->d[0], n[0]), r_cell_of(span->o[1] + span->near * span->d[1], n[1]),
                  r_cell_of(span->o[2] + span->near * span->d[2], n[2]), R_WALKING, span->near, depth, R(0.0), R(0.0)};
    return walk;
}

static inline int32_t r_walk_cell(const int32_t n[3], int32_t c0, int32_t c1, int32_t c2) {
    return (c2 * n[1] + c1) * n[0] + c0;
}

/* Distance to the plane behind which `step` cells along this axis are crossed. */
static inline Real r_plane(int32_t cell, int32_t step, Real o, Real inv) {
    int32_t plane = cell + (inv > R(0.0) ? step : 1 - step);
    return (R(4.0) * (Real)plane - o) * inv;
}

/* The cell along one axis once the ray stands at u behind the block of `step` cells. */
static inline int32_t r_cross(int32_t cell, int32_t step, int crosses, Real u, Real inv) {
    int forward = inv > R(0.0);
    int32_t last = cell + (forward ? step - 1 : 1 - step), lo = forward ? cell : last, hi = forward ? last : cell;
    int32_t within = (int32_t)r_clamp(u * R(0.25), (Real)lo, (Real)hi), next = last + (forward ? 1 : -1);
    return crosses ? next : within;
}

/* One step: to the tentative collision if it lies in this cell, else to the next cell (or behind the block of empty
 * cells around this one), or out of the medium. bound: what the majorant grid says of the cell. Cells move along the
 * ray only, so a walk ends. */
static inline RWalk r_walk_step(const int32_t n[3], const RSpan *span, RWalk walk, float entry, Real sigma) {
    Real bound = (Real)entry;
    if (NPH_BUG(13) && bound > R(0.0)) bound *= R(0.8);
    int32_t step = bound < R(0.0) ? (int32_t)-bound : 1;
    Real rate = (bound < R(0.0) ? R(0.0) : bound) * sigma;
    Real t0 = r_plane(walk.c0, step, span->o[0], span->inv[0]), t1 = r_plane(walk.c1, step, span->o[1], span->inv[1]);
    Real t2 = r_plane(walk.c2, step, span->o[2], span->inv[2]), exit = t0 < t1 ? t0 : t1;
    exit = t2 < exit ? t2 : exit;
    int by2 = t2 <= exit, by1 = (t1 <= exit) & !by2, by0 = !by1 & !by2, ends = exit >= span->far;
    exit = ends ? span->far : exit;
    exit = exit > walk.t ? exit : walk.t;
    Real through = rate * (exit - walk.t), along = walk.t + walk.depth / rate;
    int hits = walk.depth < through;
    along = along < exit ? along : exit;
    int32_t c0 = r_cross(walk.c0, step, by0, span->o[0] + exit * span->d[0], span->inv[0]);
    int32_t c1 = r_cross(walk.c1, step, by1, span->o[1] + exit * span->d[1], span->inv[1]);
    int32_t c2 = r_cross(walk.c2, step, by2, span->o[2] + exit * span->d[2], span->inv[2]);
    int out = ends | ((uint32_t)c0 >= (uint32_t)n[0]) | ((uint32_t)c1 >= (uint32_t)n[1]) | ((uint32_t)c2 >= (uint32_t)n[2]);
    int stays = hits | out;
    walk.c0 = stays ? walk.c0 : c0;
    walk.c1 = stays ? walk.c1 : c1;
    walk.c2 = stays ? walk.c2 : c2;
    walk.t = hits ? along : exit;
    walk.expected += (Real)nph_majorant_mean(entry) * (hits ? walk.depth : through);
    walk.depth = hits ? walk.depth : walk.depth - through;
    walk.state = hits ? R_COLLIDES : out ? R_LEFT : R_WALKING;
    walk.majorant = bound;
    return walk;
}

/* Mean density over bound in the cell of a tentative collision. */
static inline Real r_walk_control(Real majorant) { return (Real)nph_majorant_mean((float)majorant); }

/* A position along one axis, clamped to the walk's cell and the medium's box. */
static inline Real r_within(Real u, int32_t cell, Real lo, Real hi) {
    Real first = R(4.0) * (Real)cell, last = first + R(4.0);
    first = first > lo ? first : lo;
    last = last < hi ? last : hi;
    return r_clamp(u, first, last);
}

/* Tentative collisions of one flight through one medium: two random words each, distance and decision. */
typedef struct REvents {
    RStream stream;
    NphWords words;
    uint32_t count;
    Real survived, expected; /* of a flight: product of r_null_weight, depth that the cells' means make of the majorant's */
    uint32_t violations;   /* of an emission's bound */
} REvents;

static inline REvents r_events(const RStream *stream, int light, uint32_t medium) {
    REvents events = {*stream, {0, 0, 0, 0}, 0, R(1.0), R(0.0), 0};
    events.stream.draw = (uint32_t)light << NPH_DRAW_LIGHT_SHIFT | medium << NPH_DRAW_MEDIUM_SHIFT;
    return events;
}

/* -ln(1 - u); 1 - u is exact. */
static inline Real r_event_depth(uint32_t word) { return -r_log(R(1.0) - r_uniform(word)); }

static inline void r_next_event(REvents *events, Real *depth, Real *decision) {
    int second = events->count & 1u;
    if (!second) events->words = r_words(&events->stream, (events->count >> 1) & (NPH_MAX_BLOCKS - 1u));
    *depth = r_event_depth(second ? events->words.w2 : events->words.w0);
    *decision = r_uniform(second ? events->words.w3 : events->words.w1);
    if (NPH_BUG(15)) *decision = r_uniform(second ? events->words.w2 : events->words.w0);
    events->count++;
}

static inline int r_exhausted(const REvents *events) { return events->count >= 2u * NPH_MAX_BLOCKS; }

/* Walks on to the next tentative collision; 0 when the medium ends before. */
static inline int r_walk_on(const RMedium *medium, const RSpan *span, RWalk *walk) {
    do {
        int32_t cell = r_walk_cell(medium->majorant_n, walk->c0, walk->c1, walk->c2);
        *walk = r_walk_step(medium->majorant_n, span, *walk, medium->majorant[cell], medium->sigma_max);
    } while (walk->state == R_WALKING);
    return walk->state == R_COLLIDES;
}

static inline Real r_walk_density(const RMedium *medium, const RSpan *span, const RWalk *walk) {
    return r_grid_value(&medium->grid, r_within(span->o[0] + walk->t * span->d[0], walk->c0, medium->lo[0], medium->hi[0]),
                        r_within(span->o[1] + walk->t * span->d[1], walk->c1, medium->lo[1], medium->hi[1]),
                        r_within(span->o[2] + walk->t * span->d[2], walk->c2, medium->lo[2], medium->hi[2]));
}

/* The density at a scene-local point; 0 outside. */
static inline Real r_density_at(const RMedium *medium, const Real p[3]) {
    Real u[3];
    int inside = 1;
    if (medium->shape == NPH_SHAPE_AIR && medium->radius > R(0.0)) {
        static const Real up[3] = {R(0.0), R(0.0), R(1.0)};
        RArc arc = r_air_arc(medium, p, up, R(1.0));
        return arc.inside && arc.near <= R(0.0) && arc.e >= R(0.0) ? r_air_density(medium, r_air_height(medium, arc.e)) : R(0.0);
    }
    for (int a = 0; a < 3; a++) {
        const Real *row = medium->from_local + 4 * a;
        u[a] = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
        inside &= (u[a] >= medium->lo[a]) & (u[a] <= medium->hi[a]);
    }
    if (!inside) return R(0.0);
    if (medium->shape == NPH_SHAPE_AIR) return r_air_density(medium, u[2]);
    return medium->shape == NPH_SHAPE_GRID ? r_grid_value(&medium->grid, u[0], u[1], u[2]) : R(1.0);
}

/* Weighed flights. Collisions happen with `collide` = k of the extinction only; the rest weighs the flight with
 * exp(-(1 - k) tau), estimated as exp(-(1 - k) E) prod w_i over the flight's virtual collisions: the majorant's cells expect
 * control M of the extinction, c M in short, E in all [Novak14: the residual is tracked]. Virtual collisions are a Poisson
 * process of rate M (1 - k rho), rho = sigma / M, so that with
 *   w = 1 - (1 - k) (rho - c) / (1 - k rho)
 * the mean of the product is exp(-(1 - k) (tau - E)). w >= 0 for rho <= 1. One medium, channels alike. */
static inline Real r_null_weight(Real collide, Real control, Real rho) {
    if (NPH_BUG(24)) return R(1.0);
    return R(1.0) - (R(1.0) - collide) * (rho - control) / (R(1.0) - collide * rho);
}

static inline Real r_flight_weight(const RMedium *medium, Real survived, Real expected) {
    return survived * r_exp(-(R(1.0) - medium->collide) * expected);
}

/* Of a closed form: the whole weight. */
static inline Real r_segment_weight(const RMedium *medium, Real length) {
    return r_exp(-(R(1.0) - medium->collide) * medium->sigma[0] * length);
}

/* A flight through the one medium, a box or layer, that is split: light from behind counts with `through`, and collisions
 * happen `oftener` times as often as they would, at most always, each with the weight `collides`; 0: none. They keep their
 * digits however thin the medium is. */
typedef struct RForced {
    Real through, collides, t;
} RForced;

static inline Real r_forced_depth(const RMedium *medium, const RSpan *span) {
    return span->inside ? medium->sigma[0] * (span->far - span->near) : R(0.0);
}

static inline RForced r_forced_flight(const RMedium *medium, const RSpan *span, Real oftener, NphWords words) {
    Real depth = r_forced_depth(medium, span), part = -r_expm1(-depth), chance = part * oftener;
    Real t = span->near - r_log1p(-(r_uniform(words.w0) * part)) / medium->sigma[0];
    Real weight = chance < R(1.0) ? R(1.0) / oftener : part;
    if (NPH_BUG(31)) weight = R(1.0);
    RForced forced = {r_exp(-depth), r_uniform(words.w1) < chance ? weight : R(0.0), t < span->far ? t : span->far};
    return forced;
}

/* The closed form in one span. 1: it ends there, at t. depth: what is left to go of the flight's optical depth. */
static inline int r_fly_segment(const RMedium *medium, const RSpan *span, int hero, REvents *events, Real *depth, Real *t) {
    Real rate = medium->sigma[hero] * medium->collide, at = span->near + *depth / rate;
    int hits = at < span->far;
    events->survived *= r_segment_weight(medium, (hits ? at : span->far) - span->near);
    *depth -= rate * (span->far - span->near);
    *t = at;
    return hits;
}

/* Delta tracking through one span. 1: the flight is over, at t, or -1 where it used up its random numbers. */
static inline int r_fly_grid(const RMedium *medium, const RSpan *span, int hero, REvents *events, NphTally *tally, Real *depth,
                             Real *decision, Real *t) {
    RWalk walk = r_walk_enter(medium->majorant_n, span, *depth);
    walk.expected = events->expected;
    while (r_walk_on(medium, span, &walk)) {
        Real density = r_walk_density(medium, span, &walk);
        tally->tentative++;
        tally->violations += density > walk.majorant;
        Real rho = density / walk.majorant;
        *t = walk.t;
        events->expected = walk.expected;
        if (*decision < rho * medium->ratio[hero] * medium->collide) return 1;
        events->survived *= r_null_weight(medium->collide, r_walk_control(walk.majorant), rho);
        *t = R(-1.0);
        if (r_exhausted(events)) {
            tally->exhausted++;
            return 1;
        }
        r_next_event(events, &walk.depth, decision);
    }
    events->expected = walk.expected;
    *depth = walk.depth;
    return 0;
}

/* Of air: the column of the part of a ray before limit. */
static inline Real r_air_passed(const RMedium *medium, const Real p[3], const Real d[3], Real limit) {
    if (medium->radius > R(0.0)) {
        RArc arc = r_air_arc(medium, p, d, limit);
        return arc.inside ? r_air_curved(medium, &arc, arc.near, arc.far) : R(0.0);
    }
    RSpan span = r_clip(medium, p, d, limit);
    return span.inside ? r_air_column(medium, span.o[2] + span.near * span.d[2], span.d[2], span.far - span.near) : R(0.0);
}

/* Delta tracking around a sphere, from piece to piece and from one tentative collision to the next; the bound is a thousandth
 * higher, for rounding. Bend: how far above its plane a way may come within a piece. */
static inline Real r_air_flight_curved(const RMedium *medium, const RArc *arc, int hero, REvents *events, NphTally *tally) {
    const Real margin = R(1.0009765625);
    Real sigma = medium->sigma[hero] * margin, piece = r_sqrt(medium->scale_height * medium->radius), t = arc->near, depth, decision;
    r_next_event(events, &depth, &decision);
    while (t < arc->far) {
        Real height = r_air_height(medium, r_air_e(arc, t)), rise = (arc->b + t) / (medium->radius + height);
        Real most = arc->far - t < piece ? arc->far - t : piece, s = r_air_reach(medium, height, rise, depth / sigma);
        if (!(s < most)) {
            depth -= sigma * r_air_column(medium, height, rise, most);
            depth = depth > R(0.0) ? depth : R(0.0);
            t = most < piece ? arc->far : t + most;
            continue;
        }
        t += s;
        Real above = r_air_height(medium, r_air_e(arc, t)) - (height + rise * s), real = r_air_density(medium, above) / margin;
        tally->tentative++;
        tally->violations += real > R(1.0);
        if (decision < real) return t;
        if (r_exhausted(events)) {
            tally->exhausted++;
            return R(-1.0);
        }
        r_next_event(events, &depth, &decision);
    }
    return R(-1.0);
}

/* A flight of channel hero through air. */
static inline Real r_air_flight(const RMedium *medium, const Real p[3], const Real d[3], Real limit, int hero, REvents *events,
                                NphTally *tally) {
    Real depth, decision;
    if (medium->radius > R(0.0)) {
        RArc arc = r_air_arc(medium, p, d, limit);
        return arc.inside ? r_air_flight_curved(medium, &arc, hero, events, tally) : R(-1.0);
    }
    RSpan span = r_clip(medium, p, d, limit);
    if (!span.inside) return R(-1.0);
    r_next_event(events, &depth, &decision);
    tally->tentative++;
    Real t = span.near + r_air_reach(medium, span.o[2] + span.near * span.d[2], span.d[2], depth / medium->sigma[hero]);
    return t < span.far ? t : R(-1.0);
}

/* Delta tracking of channel hero. Returns the distance of the first real collision before limit, or -1. */
static inline Real r_free_flight(const RMedium *medium, const Real p[3], const Real d[3], Real limit, int hero,
                                 REvents *events, NphTally *tally) {
    Real depth = R(0.0), decision = R(0.0), t = R(-1.0);
    int grid = medium->shape == NPH_SHAPE_GRID;
    if (!(medium->sigma[hero] > R(0.0))) return R(-1.0);
    if (medium->shape == NPH_SHAPE_AIR) return r_air_flight(medium, p, d, limit, hero, events, tally);
    RImage image = r_first_image(medium, p, d, limit);
    do {
        RSpan span = r_image_span(medium, p, d, &image);
        if (!span.inside) continue;
        if (events->count == 0) {
            r_next_event(events, &depth, &decision);
            tally->tentative += !grid;
        }
        int over = grid ? r_fly_grid(medium, &span, hero, events, tally, &depth, &decision, &t)
                        : r_fly_segment(medium, &span, hero, events, &depth, &t);
        if (over) return t;
    } while (r_next_image(medium, p, d, &image));
    tally->exhausted += image.left == 0;
    return R(-1.0);
}

/* What the channels make of a flight's virtual collisions in one span. 1: the flight is over. */
static inline int r_factors_grid(const RMedium *medium, const RSpan *span, int hero, REvents *events, Real *depth,
                                 Real *decision, Real factor[3]) {
    RWalk walk = r_walk_enter(medium->majorant_n, span, *depth);
    while (r_walk_on(medium, span, &walk)) {
        if (r_exhausted(events)) return 1;
        Real density = r_walk_density(medium, span, &walk);
        Real rho = density / walk.majorant, null = R(1.0) - rho * medium->ratio[hero];
        if (*decision < rho * medium->ratio[hero]) return 1;
        for (int c = 0; c < 3; c++) factor[c] *= r_max(R(1.0) - rho * medium->ratio[c], R(0.0)) / null;
        r_next_event(events, &walk.depth, decision);
    }
    *depth = walk.depth;
    return 0;
}

/* The same flight once more, up to limit, for media whose extinction differs between channels: what each channel would
 * have made of its virtual collisions, relative to the hero: factor[c] *= prod (1 - rho_c) / (1 - rho_hero); in closed
 * form exp(-(sigma_c - sigma_hero) s). */
static inline void r_flight_factors(const RMedium *medium, const Real p[3], const Real d[3], Real limit, int hero,
                                    REvents *events, Real factor[3]) {
    Real depth = R(0.0), decision = R(0.0);
    if (medium->shape == NPH_SHAPE_AIR) {
        Real column = r_air_passed(medium, p, d, limit);
        for (int c = 0; c < 3; c++) factor[c] *= r_exp(-(medium->sigma[c] - medium->sigma[hero]) * column);
        return;
    }
    RImage image = r_first_image(medium, p, d, limit);
    do {
        RSpan span = r_image_span(medium, p, d, &image);
        if (!span.inside) continue;
        for (int c = 0; c < 3 && medium->shape != NPH_SHAPE_GRID; c++)
            factor[c] *= r_exp(-(medium->sigma[c] - medium->sigma[hero]) * (span.far - span.near));
        if (medium->shape != NPH_SHAPE_GRID) continue;
        if (events->count == 0) r_next_event(events, &depth, &decision);
        if (r_factors_grid(medium, &span, hero, events, &depth, &decision, factor)) return;
    } while (r_next_image(medium, p, d, &image));
}

/* Ratio tracking through one span. 1: the walk is over. */
static inline int r_transmit_grid(const RMedium *medium, const RSpan *span, const RScene *scene, REvents *events, Real *depth,
                                  Real *decision, Real T[3], NphTally *tally) {
    RWalk walk = r_walk_enter(medium->majorant_n, span, *depth);
    while (r_walk_on(medium, span, &walk)) {
        Real density = r_walk_density(medium, span, &walk);
        Real rho = density / walk.majorant, largest = R(0.0);
        tally->tentative++;
        tally->violations += density > walk.majorant;
        for (int c = 0; c < scene->channels; c++) {
            T[c] *= NPH_BUG(1) ? R(1.0) : r_max(R(1.0) - rho * medium->ratio[NPH_BUG(25) ? 0 : c], R(0.0));
            largest = T[c] > largest ? T[c] : largest;
        }
        if (largest < scene->shadow_roulette) {
            Real grow = *decision < R(0.25) ? (NPH_BUG(23) ? R(1.0) : R(4.0)) : R(0.0);
            for (int c = 0; c < scene->channels; c++) T[c] *= grow;
            largest *= grow;
        }
        if (!(largest > R(0.0))) return 1;
        if (r_exhausted(events)) {
            tally->exhausted++;
            return 1;
        }
        r_next_event(events, &walk.depth, decision);
    }
    *depth = walk.depth;
    return 0;
}

/* Ratio tracking: multiplies T by an unbiased estimate of the transmittance up to limit. Below `roulette` (largest
 * channel) the walk survives with probability 1/4 and T grows by 4. channels is 1 or 3. */
static inline void r_transmittance(const RMedium *medium, const Real p[3], const Real d[3], Real limit,
                                   const RScene *scene, REvents *events, Real T[3], NphTally *tally) {
    Real depth = R(0.0), decision = R(0.0);
    int met = 0;
    assert(scene->channels <= 3);
    if (medium->shape == NPH_SHAPE_AIR) {
        Real column = r_air_passed(medium, p, d, limit);
        for (int c = 0; c < scene->channels; c++) T[c] *= r_exp(-medium->sigma[c] * column);
        tally->tentative += column > R(0.0);
        return;
    }
    RImage image = r_first_image(medium, p, d, limit);
    do {
        RSpan span = r_image_span(medium, p, d, &image);
        if (!span.inside) continue;
        tally->tentative += !met;
        met = 1;
        int dark = medium->shape != NPH_SHAPE_GRID;
        for (int c = 0; c < scene->channels && medium->shape != NPH_SHAPE_GRID; c++) {
            T[c] *= r_exp(-medium->sigma[NPH_BUG(25) ? 0 : c] * (span.far - span.near));
            dark &= !(T[c] > R(0.0));
        }
        if (dark) return; /* a level ray between sides that repeat would go on for ever */
        if (medium->shape != NPH_SHAPE_GRID) continue;
        if (events->count == 0) r_next_event(events, &depth, &decision);
        if (r_transmit_grid(medium, &span, scene, events, &depth, &decision, T, tally)) return;
    } while (r_next_image(medium, p, d, &image));
    tally->exhausted += image.left == 0;
}

#endif
