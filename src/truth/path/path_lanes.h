/* SPDX-License-Identifier: Apache-2.0
 *
 * Many rays through one grid at once, for grey transport: the arithmetic of flight_lookup.h as loops over lanes, which become
 * vectors. Every lane stands in its own cell; a pass moves all of them by one step of the walk, then those that met a
 * tentative collision look the density up and draw their next event. A lane whose flight is over is replaced by the
 * next ray. Lanes do not see each other, so neither their order nor the width of vectors changes a bit. */
#ifndef NPH_TRUTH_PATH_LANES_H
#define NPH_TRUTH_PATH_LANES_H

#include "truth/path/path_state.h"

enum { R_LANES = 128, R_FEW = 4 }; /* so few rays are followed one by one */

/* Rays to follow: T and limit are read, and written when the flight ends. ray: six arrays of NPH_PATH_BATCH, p and d. */
typedef struct RRays {
    const Real *ray;
    Real *limit, *T, *expected;
    const int32_t *id;
    int count;
} RRays;

typedef struct RLanes {
    int32_t ray[R_LANES], state[R_LANES], c0[R_LANES], c1[R_LANES], c2[R_LANES];
    uint32_t pixel[R_LANES], sample[R_LANES], events[R_LANES], spare0[R_LANES], spare1[R_LANES];
    Real o[3][R_LANES], d[3][R_LANES], inv[3][R_LANES], far[R_LANES];
    Real t[R_LANES], depth[R_LANES], majorant[R_LANES], decision[R_LANES], T[R_LANES], expected[R_LANES];
    int count;
} RLanes;

/* What the lanes in list (the first `count` numbers) are doing between gathering and scattering. */
typedef struct RDue {
    int32_t list[R_LANES], fresh[R_LANES];
    uint32_t pixel[R_LANES], sample[R_LANES], block[R_LANES], w0[R_LANES], w1[R_LANES], w2[R_LANES], w3[R_LANES];
    Real u[R_LANES], v[R_LANES], w[R_LANES], rho[R_LANES], decision[R_LANES], T[R_LANES], depth[R_LANES];
    int32_t violates[R_LANES], hits[R_LANES];
    int count;
} RDue;

typedef struct RFlights {
    const RScene *scene;
    const RMedium *medium;
    RStream stream;       /* draw says light and medium; pixel and sample are the lanes' */
    const NphPathBatch *batch;
    RRays rays;
    int next;             /* the first ray that is not in a lane yet */
    RLanes ready, work;
    RDue due;
    int32_t over[R_LANES]; /* lanes whose flight has ended in this pass */
    int ended;
    RImage image[NPH_PATH_BATCH]; /* of each ray, where sides repeat */
} RFlights;

/* r_clip of ray i of six arrays one after another. */
static inline RSpan r_clip_ray(const RMedium *medium, const Real *rays, int i, Real limit) {
    Real p[3] = {r_lane(rays, R_OF_P, i), r_lane(rays, R_OF_P + 1, i), r_lane(rays, R_OF_P + 2, i)};
    Real d[3] = {r_lane(rays, R_OF_D, i), r_lane(rays, R_OF_D + 1, i), r_lane(rays, R_OF_D + 2, i)};
    return r_clip(medium, p, d, limit);
}

static inline void r_flights_words(RDue *due, const RStream *stream, int count) {
    uint32_t key0 = stream->key[0], key1 = stream->key[1], vertex = stream->vertex, draw = stream->draw;
    for (int k = 0; k < count; k++) { /* vec */
        NphWords words = nph_philox(key0, key1, due->pixel[k], due->sample[k], vertex, draw | due->block[k]);
        due->w0[k] = words.w0;
        due->w1[k] = words.w1;
        due->w2[k] = words.w2;
        due->w3[k] = words.w3;
    }
}

/* Depth and decision of the next event for the lanes in due->list. */
static inline void r_flights_draw(RLanes *lanes, RDue *due, const RStream *stream) {
    int fresh = 0, count = due->count;
    for (int k = 0; k < count; k++) {
        int i = due->list[k];
        due->fresh[fresh] = i;
        due->pixel[fresh] = lanes->pixel[i];
        due->sample[fresh] = lanes->sample[i];
        due->block[fresh] = (lanes->events[i] >> 1) & (NPH_MAX_BLOCKS - 1u);
        fresh += !(lanes->events[i] & 1u);
    }
    r_flights_words(due, stream, fresh);
    /* the words of an even event and the one after it */
    for (int k = 0, from = 0; k < count; k++) {
        int i = due->list[k], even = !(lanes->events[i] & 1u);
        uint32_t first = even ? due->w0[from] : lanes->spare0[i], second = even ? due->w1[from] : lanes->spare1[i];
        lanes->spare0[i] = even ? due->w2[from] : 0;
        lanes->spare1[i] = even ? due->w3[from] : 0;
        due->pixel[k] = first;
        due->sample[k] = second;
        from += even;
        lanes->events[i]++;
    }
    for (int k = 0; k < count; k++) { /* vec */
        due->depth[k] = r_event_depth(due->pixel[k]);
        due->decision[k] = r_uniform(NPH_BUG(15) ? due->pixel[k] : due->sample[k]);
    }
    for (int k = 0; k < count; k++) {
        int i = due->list[k];
        lanes->depth[i] = due->depth[k];
        lanes->decision[i] = due->decision[k];
        lanes->state[i] = R_WALKING;
    }
}

static inline void r_lane_copy(RLanes *to, int i, const RLanes *from, int j) {
    to->ray[i] = from->ray[j];
    to->state[i] = from->state[j];
    to->c0[i] = from->c0[j];
    to->c1[i] = from->c1[j];
    to->c2[i] = from->c2[j];
    to->pixel[i] = from->pixel[j];
    to->sample[i] = from->sample[j];
    to->events[i] = from->events[j];
    to->spare0[i] = from->spare0[j];
    to->spare1[i] = from->spare1[j];
    for (int a = 0; a < 3; a++) {
        to->o[a][i] = from->o[a][j];
        to->d[a][i] = from->d[a][j];
        to->inv[a][i] = from->inv[a][j];
    }
    to->far[i] = from->far[j];
    to->t[i] = from->t[j];
    to->depth[i] = from->depth[j];
    to->majorant[i] = from->majorant[j];
    to->decision[i] = from->decision[j];
    to->T[i] = from->T[j];
    to->expected[i] = from->expected[j];
}

/* Clips the rays from `ray` on, enters their first cells; state R_LEFT where nothing is inside. */
R_OUTLINE void r_flights_enter(RLanes *restrict lanes, const RMedium *restrict medium, const Real *restrict ray,
                               const Real *restrict limit, int count) {
    const int32_t n[3] = {medium->majorant_n[0], medium->majorant_n[1], medium->majorant_n[2]};
    for (int i = 0; i < count; i++) { /* vec */
        RSpan span = r_clip_ray(medium, ray, i, limit[i]);
        for (int a = 0; a < 3; a++) {
            lanes->o[a][i] = span.o[a];
            lanes->d[a][i] = span.d[a];
            lanes->inv[a][i] = span.inv[a];
        }
        lanes->far[i] = span.far;
        lanes->t[i] = span.near;
        lanes->state[i] = span.inside ? R_WALKING : R_LEFT;
        lanes->c0[i] = r_cell_of(span.o[0] + span.near * span.d[0], n[0]);
        lanes->c1[i] = r_cell_of(span.o[1] + span.near * span.d[1], n[1]);
        lanes->c2[i] = r_cell_of(span.o[2] + span.near * span.d[2], n[2]);
    }
}

/* Puts ray `ray` into lane i where it enters the next image of the medium that holds a part of it; 0 when there is none. */
static inline int r_flights_reenter(RFlights *f, RLanes *lanes, int i, int32_t ray, int first, NphTally *tally) {
    const RMedium *medium = f->medium;
    const Real *rays = f->rays.ray;
    RImage *image = &f->image[ray];
    Real p[3] = {r_lane(rays, R_OF_P, ray), r_lane(rays, R_OF_P + 1, ray), r_lane(rays, R_OF_P + 2, ray)};
    Real d[3] = {r_lane(rays, R_OF_D, ray), r_lane(rays, R_OF_D + 1, ray), r_lane(rays, R_OF_D + 2, ray)};
    if (first) *image = r_first_image(medium, p, d, f->rays.limit[ray]);
    while (first || r_next_image(medium, p, d, image)) {
        first = 0;
        RSpan span = r_image_span(medium, p, d, image);
        if (!span.inside) continue;
        RWalk walk = r_walk_enter(medium->majorant_n, &span, R(0.0));
        for (int a = 0; a < 3; a++) {
            lanes->o[a][i] = span.o[a];
            lanes->d[a][i] = span.d[a];
            lanes->inv[a][i] = span.inv[a];
        }
        lanes->far[i] = span.far;
        lanes->t[i] = span.near;
        lanes->c0[i] = walk.c0;
        lanes->c1[i] = walk.c1;
        lanes->c2[i] = walk.c2;
        lanes->state[i] = R_WALKING;
        return 1;
    }
    tally->exhausted += image->left == 0;
    lanes->state[i] = R_LEFT;
    return 0;
}

/* Fills `ready` with the next rays that meet the medium, their first event drawn. */
static inline void r_flights_load(RFlights *f, NphTally *tally, int shadow) {
    RLanes *lanes = &f->ready;
    const RRays *rays = &f->rays;
    lanes->count = 0;
    while (lanes->count == 0 && f->next < rays->count) {
        int first = f->next, count = rays->count - first < R_LANES ? rays->count - first : R_LANES, kept = 0;
        int repeats = f->medium->period.on;
        if (!repeats) r_flights_enter(lanes, f->medium, rays->ray + first, rays->limit + first, count);
        for (int i = 0; i < count; i++) {
            Real T = shadow ? rays->T[first + i] : R(1.0);
            if (repeats && T > R(0.0)) r_flights_reenter(f, lanes, i, first + i, 1, tally);
            if (lanes->state[i] != R_WALKING || !(T > R(0.0))) continue;
            if (kept != i) r_lane_copy(lanes, kept, lanes, i);
            lanes->ray[kept] = first + i;
            lanes->pixel[kept] = r_pixel(f->batch, rays->id[first + i]);
            lanes->sample[kept] = r_sample(f->batch, rays->id[first + i]);
            lanes->events[kept] = 0;
            lanes->T[kept] = T;
            lanes->expected[kept] = R(0.0);
            f->due.list[kept] = kept;
            kept++;
        }
        f->next = first + count;
        f->due.count = lanes->count = kept;
        tally->tentative += shadow ? kept : 0;
        r_flights_draw(lanes, &f->due, &f->stream);
    }
}

/* One step of the walk for one lane; weighed: a constant of the loop. */
R_INLINE void r_lane_step(RLanes *lanes, int i, const int32_t n[3], const float *bounds, Real sigma, int weighed) {
    RSpan span = {{lanes->o[0][i], lanes->o[1][i], lanes->o[2][i]},
                  {lanes->d[0][i], lanes->d[1][i], lanes->d[2][i]},
                  {lanes->inv[0][i], lanes->inv[1][i], lanes->inv[2][i]}, R(0.0), lanes->far[i], 1};
    RWalk walk = {lanes->c0[i], lanes->c1[i], lanes->c2[i], R_WALKING, lanes->t[i], lanes->depth[i], R(0.0), R(0.0)};
    if (weighed) walk.expected = lanes->expected[i];
    walk = r_walk_step(n, &span, walk, bounds[r_walk_cell(n, walk.c0, walk.c1, walk.c2)], sigma);
    lanes->c0[i] = walk.c0;
    lanes->c1[i] = walk.c1;
    lanes->c2[i] = walk.c2;
    lanes->state[i] = walk.state;
    lanes->t[i] = walk.t;
    lanes->depth[i] = walk.depth;
    lanes->majorant[i] = walk.majorant;
    if (weighed) lanes->expected[i] = walk.expected;
}

/* One step for every lane. */
static inline void r_flights_step(RLanes *restrict lanes, const RMedium *restrict medium, const float *restrict bounds,
                                  int weighed) {
    const int32_t n[3] = {medium->majorant_n[0], medium->majorant_n[1], medium->majorant_n[2]};
    Real sigma = medium->sigma_max;
    int count = lanes->count, plain = weighed ? 0 : count;
    for (int i = 0; i < plain; i++) r_lane_step(lanes, i, n, bounds, sigma, 0); /* vec */
    for (int i = plain; i < count; i++) r_lane_step(lanes, i, n, bounds, sigma, 1); /* vec */
}

/* Density over majorant where the lanes of due->list stand. */
R_OUTLINE void r_flights_look(const RLanes *restrict lanes, RDue *restrict due, const RMedium *restrict medium,
                                  const int32_t *restrict brick_index, const float *restrict values) {
    RGrid grid = medium->grid;
    grid.brick_index = brick_index;
    grid.values = values;
    Real lo0 = medium->lo[0], lo1 = medium->lo[1], lo2 = medium->lo[2];
    Real hi0 = medium->hi[0], hi1 = medium->hi[1], hi2 = medium->hi[2];
    int count = due->count;
    for (int k = 0; k < count; k++) { /* vec */
        int i = due->list[k];
        Real t = lanes->t[i];
        due->u[k] = r_within(lanes->o[0][i] + t * lanes->d[0][i], lanes->c0[i], lo0, hi0);
        due->v[k] = r_within(lanes->o[1][i] + t * lanes->d[1][i], lanes->c1[i], lo1, hi1);
        due->w[k] = r_within(lanes->o[2][i] + t * lanes->d[2][i], lanes->c2[i], lo2, hi2);
        due->depth[k] = lanes->majorant[i];
        due->decision[k] = lanes->decision[i];
        due->T[k] = lanes->T[i];
    }
    for (int k = 0; k < count; k++) { /* vec */
        Real density = r_grid_value(&grid, due->u[k], due->v[k], due->w[k]);
        due->violates[k] = density > due->depth[k];
        due->rho[k] = density / due->depth[k];
    }
}

/* Ratio tracking at the tentative collisions. */
static inline void r_flights_attenuate(RDue *due, Real roulette) {
    int count = due->count;
    for (int k = 0; k < count; k++) { /* vec */
        Real T = due->T[k] * (NPH_BUG(1) ? R(1.0) : r_max(R(1.0) - due->rho[k], R(0.0)));
        Real grow = due->decision[k] < R(0.25) ? (NPH_BUG(23) ? R(1.0) : R(4.0)) : R(0.0);
        due->T[k] = T < roulette ? T * grow : T;
        due->hits[k] = !(due->T[k] > R(0.0));
    }
}

/* Delta tracking: T of the lanes that meet a virtual collision, and whose flight is over. */
static inline void r_flights_decide(RDue *due, const RMedium *medium) {
    Real collide = medium->collide;
    int count = due->count;
    for (int k = 0; k < count; k++) { /* vec */
        due->hits[k] = due->decision[k] < due->rho[k] * collide;
        due->T[k] = due->hits[k] ? due->T[k] : due->T[k] * r_null_weight(collide, r_walk_control(due->depth[k]), due->rho[k]);
    }
}

/* What the step left: lanes at a tentative collision, lanes behind the medium. Without branches, which would be guessed
 * wrong once or twice a flight. */
static inline void r_flights_sort(RFlights *f) {
    const RLanes *lanes = &f->work;
    int due = 0, ended = 0;
    for (int i = 0; i < lanes->count; i++) {
        f->due.list[due] = i;
        f->over[ended] = i;
        due += lanes->state[i] == R_COLLIDES;
        ended += lanes->state[i] == R_LEFT;
    }
    f->due.count = due;
    f->ended = ended;
}

/* Tentative collisions of all lanes that have one; those that go on draw their next event. */
static inline void r_flights_collide(RFlights *f, NphTally *tally, int shadow) {
    RLanes *lanes = &f->work;
    RDue *due = &f->due;
    int count = due->count;
    if (count == 0) return;
    r_flights_look(lanes, due, f->medium, f->medium->grid.brick_index, f->medium->grid.values);
    if (shadow) r_flights_attenuate(due, f->scene->shadow_roulette);
    else r_flights_decide(due, f->medium);
    int left = 0;
    for (int k = 0; k < count; k++) {
        int i = due->list[k];
        int over = due->hits[k];
        int exhausted = !over & (lanes->events[i] >= 2u * NPH_MAX_BLOCKS);
        tally->violations += due->violates[k];
        tally->exhausted += exhausted;
        lanes->T[i] = due->T[k];
        lanes->state[i] = exhausted ? R_LEFT : R_COLLIDES; /* what is over stays at its collision */
        if (exhausted) f->image[lanes->ray[i]].end = R(0.0);
        f->over[f->ended] = i;
        f->ended += over | exhausted;
        due->list[left] = i;
        left += !(over | exhausted);
    }
    tally->tentative += count;
    due->count = left;
    r_flights_draw(lanes, due, &f->stream);
}

/* Hands finished flights to their rays and puts new rays into their lanes; without new ones the lanes move together. */
static inline void r_flights_renew(RFlights *f, NphTally *tally, int shadow, int32_t *medium_of, int32_t medium) {
    RLanes *lanes = &f->work;
    int repeats = f->medium->period.on, weighed = f->scene->weighed;
    for (int k = 0; k < f->ended; k++) {
        int i = f->over[k], collides = lanes->state[i] == R_COLLIDES;
        int32_t ray = lanes->ray[i];
        if (repeats && !collides && r_flights_reenter(f, lanes, i, ray, 0, tally)) continue;
        if (shadow || weighed) f->rays.T[ray] = lanes->T[i];
        if (!shadow && weighed) f->rays.expected[ray] = lanes->expected[i];
        if (!shadow) {
            f->rays.limit[ray] = collides ? lanes->t[i] : f->rays.limit[ray];
            medium_of[ray] = collides ? medium : medium_of[ray];
        }
        if (f->ready.count == 0) r_flights_load(f, tally, shadow);
        if (f->ready.count > 0) r_lane_copy(lanes, i, &f->ready, --f->ready.count);
    }
    if (f->ready.count > 0 || f->ended == 0) return;
    for (int i = lanes->count - 1; i >= 0; i--) {
        if (lanes->state[i] == R_WALKING) continue;
        lanes->count--;
        if (i < lanes->count) r_lane_copy(lanes, i, lanes, lanes->count);
    }
}

/* Follows all rays. Delta tracking (shadow 0): a collision nearer than a ray's limit becomes its limit, and the medium's
 * number its medium_of. Ratio tracking (shadow 1): T is multiplied by an estimate of the transmittance up to limit. */
static inline void r_flights_run(RFlights *f, NphTally *tally, int shadow, int32_t *medium_of, int32_t medium) {
    f->next = 0;
    f->work.count = 0;
    r_flights_load(f, tally, shadow);
    while (f->work.count < R_LANES && f->ready.count > 0) {
        r_lane_copy(&f->work, f->work.count++, &f->ready, --f->ready.count);
        if (f->ready.count == 0) r_flights_load(f, tally, shadow);
    }
    while (f->work.count > 0) {
        r_flights_step(&f->work, f->medium, f->medium->majorant, !shadow && f->scene->weighed);
        r_flights_sort(f);
        r_flights_collide(f, tally, shadow);
        r_flights_renew(f, tally, shadow, medium_of, medium);
    }
}

#endif
