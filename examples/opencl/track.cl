/* SPDX-License-Identifier: Apache-2.0
 *
 * path.track through one grey medium, one work-item a path. A grid: delta tracking [Woodcock65] cell by cell of its majorants
 * [Amanatides87]; a box: the closed form. docs/path.md, stage 2, has the formulas, and the names are its. */
#include "nephos/portable.h"
#include "shared.h"

#define HUGE_M 1e30f        /* no collision; also the inverse of what does not move */
#define STILL 1e-30f
#define TRACK 2u            /* of the random stream */
#define MEDIUM_SHIFT 21     /* of its draw */
#define MOST_BLOCKS (1u << MEDIUM_SHIFT)

typedef struct Span {
    float o[3], d[3], inv[3], near, far; /* the ray in medium space, and its part within the box, in metres */
    int inside;
} Span;

typedef struct Events {
    uint key[2], counter[3], draw, count;
    NphWords words;
} Events;

static Span clip(const Medium *m, const float p[3], const float d[3]) {
    Span span = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, 0.0f, HUGE_M, 1};
    for (int a = 0; a < 3; a++) {
        const float *row = m->from_local + 4 * a;
        span.o[a] = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
        span.d[a] = row[0] * d[0] + row[1] * d[1] + row[2] * d[2];
        int moves = nph_absf(span.d[a]) > STILL;
        span.inv[a] = moves ? 1.0f / span.d[a] : HUGE_M;
        float t0 = (m->lo[a] - span.o[a]) * span.inv[a], t1 = (m->hi[a] - span.o[a]) * span.inv[a];
        float first = moves ? (t0 < t1 ? t0 : t1) : 0.0f, last = moves ? (t0 < t1 ? t1 : t0) : HUGE_M;
        span.near = first > span.near ? first : span.near;
        span.far = last < span.far ? last : span.far;
        span.inside &= moves | ((span.o[a] >= m->lo[a]) & (span.o[a] < m->hi[a]));
    }
    span.inside &= span.near < span.far;
    return span;
}

static Events events_of(const Launch *launch, const Medium *m, int id) {
    uint x = launch->tile_x + (uint)(id >> 4 & 15), y = launch->tile_y + (uint)(id >> 8);
    Events events;
    events.key[0] = launch->seed;
    events.key[1] = TRACK << 24 | launch->frame;
    events.counter[0] = y * launch->width + x;
    events.counter[1] = launch->first_sample + (uint)(id & 15);
    events.counter[2] = launch->vertex;
    events.draw = (uint)m->number << MEDIUM_SHIFT;
    events.count = 0;
    return events;
}

/* The optical depth to the next tentative collision, and the number that decides it: two events to a block of words. */
static float next_event(Events *e, float *decision) {
    uint second = e->count & 1u;
    if (!second)
        e->words = nph_philox(e->key[0], e->key[1], e->counter[0], e->counter[1], e->counter[2], e->draw | (e->count >> 1 & (MOST_BLOCKS - 1u)));
    e->count++;
    *decision = nph_uniformf(second ? e->words.w3 : e->words.w1);
    return -nph_logf(1.0f - nph_uniformf(second ? e->words.w2 : e->words.w0));
}

static float within(float x, float lo, float hi) { return x < lo ? lo : x > hi ? hi : x; }
static float mix_of(float a, float b, float w) { return a + w * (b - a); }

/* Trilinear, or the nearest sample; u is within the lattice. */
static float density_at(const Medium *m, __global const float *density, const float u[3]) {
    int at[3], step = m->samples[0], layer = m->samples[0] * m->samples[1];
    float w[3];
    for (int a = 0; a < 3; a++) {
        at[a] = (int)(u[a] + (m->nearest ? 0.5f : 0.0f));
        w[a] = m->nearest ? 0.0f : u[a] - (float)at[a];
    }
    /* on the upper side a weight is 0 and the sample beyond is not asked for */
    int x = at[0] + 1 < m->samples[0], y = at[1] + 1 < m->samples[1] ? step : 0, z = at[2] + 1 < m->samples[2] ? layer : 0;
    __global const float *v = density + at[2] * layer + at[1] * step + at[0];
    float c00 = mix_of(v[0], v[x], w[0]), c10 = mix_of(v[y], v[y + x], w[0]);
    float c01 = mix_of(v[z], v[z + x], w[0]), c11 = mix_of(v[z + y], v[z + y + x], w[0]);
    return mix_of(mix_of(c00, c10, w[1]), mix_of(c01, c11, w[1]), w[2]);
}

/* Where a ray stands in the majorants' cells. */
typedef struct Walk {
    int cell[3];
    float t, depth, majorant, mean, expected; /* mean: of the cell's density over its majorant */
} Walk;

/* On to the next tentative collision; 0 where the medium ends before. An empty cell holds minus the number of cells that are
 * crossed at once. */
static int walk_on(const Medium *m, __global const float *bounds, const Span *s, float sigma, Walk *w) {
    for (;;) {
        float entry = bounds[(w->cell[2] * m->cells[1] + w->cell[1]) * m->cells[0] + w->cell[0]], exit = HUGE_M, t[3];
        int skip = entry < 0.0f ? (int)-entry : 1, by = 2, out = 0;
        for (int a = 0; a < 3; a++) {
            int plane = w->cell[a] + (s->inv[a] > 0.0f ? skip : 1 - skip);
            t[a] = (4.0f * (float)plane - s->o[a]) * s->inv[a];
        }
        exit = t[0] < t[1] ? t[0] : t[1];
        exit = t[2] < exit ? t[2] : exit;
        by = t[2] <= exit ? 2 : t[1] <= exit ? 1 : 0;
        int ends = exit >= s->far;
        exit = ends ? s->far : exit;
        exit = exit > w->t ? exit : w->t;
        w->majorant = entry < 0.0f ? 0.0f : entry;
        w->mean = (float)(int)(nph_bitsf(entry) & 15u) * 0.0625f + 0.03125f;
        float rate = w->majorant * sigma, through = rate * (exit - w->t);
        if (w->depth < through) {
            float along = w->t + w->depth / rate;
            w->t = along < exit ? along : exit;
            w->expected += w->mean * w->depth;
            return 1;
        }
        w->t = exit;
        w->depth -= through;
        w->expected += w->mean * through;
        for (int a = 0; a < 3; a++) {
            int forward = s->inv[a] > 0.0f, last = w->cell[a] + (forward ? skip - 1 : 1 - skip);
            int lo = forward ? w->cell[a] : last, hi = forward ? last : w->cell[a];
            float u = s->o[a] + exit * s->d[a];
            w->cell[a] = a == by ? last + (forward ? 1 : -1) : (int)within(u * 0.25f, (float)lo, (float)hi);
            out |= (w->cell[a] < 0) | (w->cell[a] >= m->cells[a]);
        }
        if (ends | out) return 0;
    }
}

#ifdef PLANT_DROPPED_FACTOR
#define COLLIDES(m) 1.0f
#define RATE(m) ((m)->is_grid ? (m)->sigma : 1.0f)
#else
#define COLLIDES(m) (m)->collide
#define RATE(m) (m)->sigma
#endif

/* Delta tracking, with the weight of its virtual collisions. */
static float fly_grid(const Medium *m, __global const float *density, __global const float *bounds, const Span *s, Events *e, float *survived,
                      float *expected) {
    Walk w = {{0, 0, 0}, s->near, 0.0f, 0.0f, 0.0f, 0.0f};
    float decision, k = COLLIDES(m);
    for (int a = 0; a < 3; a++) w.cell[a] = (int)within((s->o[a] + s->near * s->d[a]) * 0.25f, 0.0f, (float)(m->cells[a] - 1));
    w.depth = next_event(e, &decision);
    while (walk_on(m, bounds, s, RATE(m), &w)) {
        float u[3];
        for (int a = 0; a < 3; a++) {
            float first = 4.0f * (float)w.cell[a], last = first + 4.0f;
            u[a] = within(s->o[a] + w.t * s->d[a], first > m->lo[a] ? first : m->lo[a], last < m->hi[a] ? last : m->hi[a]);
        }
        float rho = density_at(m, density, u) / w.majorant;
        *expected = w.expected;
        if (decision < rho * k) return w.t;
        *survived *= 1.0f - (1.0f - k) * (rho - w.mean) / (1.0f - k * rho);
        if (e->count >= 2u * MOST_BLOCKS) return HUGE_M;
        w.depth = next_event(e, &decision);
    }
    *expected = w.expected;
    return HUGE_M;
}

static float fly_box(const Medium *m, const Span *s, Events *e, float *survived) {
    float decision, t = s->near + next_event(e, &decision) / (RATE(m) * COLLIDES(m));
    *survived = nph_expf(-(1.0f - COLLIDES(m)) * RATE(m) * ((t < s->far ? t : s->far) - s->near));
    return t < s->far ? t : HUGE_M;
}

/* A camera ray: `through` passes, and with the chance min(1, split part) the rest collides. */
static float fly_split(const Medium *m, const Span *s, Events *e, float *through, float *collides) {
    float decision, depth = s->inside ? RATE(m) * (s->far - s->near) : 0.0f, part = -nph_expm1f(-depth), chance = part * m->split;
    next_event(e, &decision);
    float t = s->near - nph_log1pf(-(nph_uniformf(e->words.w0) * part)) / RATE(m);
    *through = nph_expf(-depth);
    *collides = decision < chance ? (chance < 1.0f ? 1.0f / m->split : part) : 0.0f;
    return *collides > 0.0f ? (t < s->far ? t : s->far) : HUGE_M;
}

__kernel void track(const Launch launch, const Medium medium, __global const float *density, __global const float *bounds,
                    __global const int *id, __global const float *ray, __global float *weight, __global float *distance,
                    __global int *medium_of, __global float *flown, __global float *collided, __global int *queues, __global int *lengths) {
#ifdef PLANT_BLOCK_OFF_BY_ONE
    int i = (int)((get_group_id(0) + 1) * get_local_size(0) + get_local_id(0));
#else
    int i = (int)get_global_id(0);
#endif
    int count = launch.count;
    if (i >= count) return;
    float p[3], d[3], survived = 1.0f, expected = 0.0f, t = HUGE_M;
    for (int a = 0; a < 3; a++) {
        p[a] = ray[a * count + i];
        d[a] = ray[(3 + a) * count + i];
    }
    Span span = clip(&medium, p, d);
    Events events = events_of(&launch, &medium, id[i]);
    int splits = medium.split > 0.0f && launch.vertex == 0;
    if (splits) t = fly_split(&medium, &span, &events, &survived, &expected);
    else if (span.inside && medium.is_grid) t = fly_grid(&medium, density, bounds, &span, &events, &survived, &expected);
    else if (span.inside) t = fly_box(&medium, &span, &events, &survived);
    int hits = t < HUGE_M;
    if (splits) {
        collided[id[i]] = expected;
        weight[i] *= medium.collide;
    } else if (medium.weighed) weight[i] *= survived * nph_expf(-(1.0f - medium.collide) * expected);
#ifdef PLANT_HALF
    ushort bits;
    vstore_half(t, 0, (half *)&bits);
    distance[i] = vload_half(0, (half *)&bits);
#else
    distance[i] = t;
#endif
    medium_of[i] = hits ? medium.position : -1;
    flown[i] = survived;
    flown[count + i] = expected;
    /* as the atomics fall: whose place is whose does not matter */
    queues[(hits ? 0 : count) + atomic_inc(&lengths[hits ? 0 : 1])] = i;
}
