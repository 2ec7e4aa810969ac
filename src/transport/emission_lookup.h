/* SPDX-License-Identifier: Apache-2.0
 *
 * What media add to a path by their own light, along one flight from 0 to where it ends, t: at a collision, at a surface,
 * or beyond all media. A flight is still under way at s with the probability T(s), so
 *     integral of T(s) j(s) ds  =  mean of  integral from 0 to t of j(s) ds,
 * whatever media and collisions are: also where the density is 0 or the albedo 1. The inner integral:
 *   box, layer   j times the length within; where its own medium is the only one, T too is known: j (1 - exp(-sigma L)) / sigma
 *   grid         a Poisson process of events along the flight, independent of its collisions, with the rate r(s) =
 *                rate * bound(s) of the cell: the mean of the sum of j / r over the events is the integral (Campbell's
 *                formula [Kingman93]). An event is worth at most 1 / rate.
 * Where extinction differs between channels the weights at s are those of a flight that has come so far: factors of
 * r_flight_factors up to s, normalised like those of the whole flight (one-sample balance heuristic); a box or layer is
 * then met at one uniform point of its length. */
#ifndef NPH_TRANSPORT_EMISSION_LOOKUP_H
#define NPH_TRANSPORT_EMISSION_LOOKUP_H

#include "transport/flight_lookup.h"

/* A flight and its weights where it began. `flown`: the stream of its own collisions, to walk it again. */
typedef struct RFlown {
    Real p[3], d[3], limit;
    Real weight[3], share[3];
    Real pdf;                  /* of the direction, where light samples of the vertex might have taken it; else negative */
    int hero;
    RStream flown;
} RFlown;

/* Weights at distance s: share_c f_c over the mean of the channels'. */
static inline void r_weights_at(const RScene *scene, const RFlown *flight, Real s, Real weight[3]) {
    Real factor[3] = {R(1.0), R(1.0), R(1.0)}, mean = R(0.0);
    for (int c = 0; c < 3; c++) weight[c] = flight->weight[c];
    if (!scene->chromatic) return;
    for (int m = 0; m < scene->medium_count; m++) {
        const RMedium *medium = &scene->media[m];
        if (medium->sigma[0] == medium->sigma[1] && medium->sigma[0] == medium->sigma[2]) continue;
        REvents events = r_events(&flight->flown, 0, medium->number);
        r_flight_factors(medium, flight->p, flight->d, s, flight->hero, &events, factor);
    }
    for (int c = 0; c < 3; c++) mean += flight->share[c] * factor[c];
    mean *= R(1.0) / R(3.0);
    for (int c = 0; c < 3; c++) weight[c] *= factor[c] / mean;
}

/* The length within, or the integral of its transmittance. */
static inline Real r_emission_length(Real sigma, Real length) {
    Real depth = sigma * length;
    return depth > R(1e-6) ? -r_expm1(-depth) / sigma : length;
}

static inline void r_emit_constant(const RScene *scene, const REmitter *emitter, const RFlown *flight,
                                   const RStream *stream, Real light[3]) {
    const RMedium *field = &emitter->field;
    REvents events = r_events(stream, 0, field->number);
    RImage image = r_first_image(field, flight->p, flight->d, emitter->alone ? R_HUGE : flight->limit);
    do {
        RSpan span = r_image_span(field, flight->p, flight->d, &image);
        Real weight[3] = {flight->weight[0], flight->weight[1], flight->weight[2]}, length = span.far - span.near;
        if (!span.inside) continue;
        if (scene->chromatic && !emitter->alone) {
            Real depth, place;
            r_next_event(&events, &depth, &place);
            r_weights_at(scene, flight, span.near + place * length, weight);
        }
        for (int c = 0; c < 3; c++) {
            Real worth = emitter->alone ? r_emission_length(field->sigma[c], length) : length;
            light[c] += weight[c] * emitter->value[c] * worth;
        }
    } while (r_next_image(field, flight->p, flight->d, &image));
}

/* The events in one span; depth: what is left to go to the next one. 1: out of random numbers. */
static inline int r_emit_span(const RScene *scene, const REmitter *emitter, const RFlown *flight, const RSpan *span,
                              REvents *events, Real *depth, Real light[3]) {
    const RMedium *field = &emitter->field;
    RWalk walk = r_walk_enter(field->majorant_n, span, *depth);
    while (r_walk_on(field, span, &walk)) {
        Real inverse = R(1.0) / (walk.majorant * field->sigma_max), value = R(0.0), weight[3], unused;
        Real u = r_within(span->o[0] + walk.t * span->d[0], walk.c0, field->lo[0], field->hi[0]);
        Real v = r_within(span->o[1] + walk.t * span->d[1], walk.c1, field->lo[1], field->hi[1]);
        Real w = r_within(span->o[2] + walk.t * span->d[2], walk.c2, field->lo[2], field->hi[2]);
        r_weights_at(scene, flight, walk.t, weight);
        for (int c = 0; c < 3; c++) {
            value = c == 0 || emitter->grids > 1 ? r_grid_value(&emitter->grid[c], u, v, w) : value;
            Real j = emitter->value[c] * value;
            events->violations += j > walk.majorant;
            light[c] += weight[c] * (j * inverse);
        }
        if (r_exhausted(events)) return 1;
        r_next_event(events, &walk.depth, &unused);
    }
    *depth = walk.depth;
    return 0;
}

static inline void r_emit_grid(const RScene *scene, const REmitter *emitter, const RFlown *flight, const RStream *stream,
                               NphTally *tally, Real light[3]) {
    const RMedium *field = &emitter->field;
    REvents events = r_events(stream, 0, field->number);
    RImage image = r_first_image(field, flight->p, flight->d, flight->limit);
    Real depth = R(0.0), unused;
    int over = 0;
    do {
        RSpan span = r_image_span(field, flight->p, flight->d, &image);
        if (!span.inside) continue;
        if (events.count == 0) r_next_event(&events, &depth, &unused);
        over = r_emit_span(scene, emitter, flight, &span, &events, &depth, light);
    } while (!over && r_next_image(field, flight->p, flight->d, &image));
    tally->tentative += events.count;
    tally->violations += events.violations;
    tally->exhausted += over | (image.left == 0);
}

/* What all emitters add to the path. */
static inline void r_emission(const RScene *scene, const RFlown *flight, const RStream *stream, NphTally *tally,
                              Real light[3]) {
    light[0] = light[1] = light[2] = R(0.0);
    for (int e = 0; e < scene->emitter_count; e++) {
        const REmitter *emitter = &scene->emitters[e];
        if (emitter->field.shape == NPH_SHAPE_GRID) r_emit_grid(scene, emitter, flight, stream, tally, light);
        else r_emit_constant(scene, emitter, flight, stream, light);
    }
}

/* j of all emitters at a point: for methods that march. */
static inline void r_emission_at(const RScene *scene, const Real p[3], Real j[3]) {
    Real wrapped[3] = {p[0], p[1], p[2]};
    j[0] = j[1] = j[2] = R(0.0);
    r_wrap_position(&scene->period, wrapped);
    for (int e = 0; e < scene->emitter_count; e++) {
        const REmitter *emitter = &scene->emitters[e];
        const RMedium *field = &emitter->field;
        Real u[3], value = R(1.0);
        int inside = 1;
        for (int a = 0; a < 3; a++) {
            const Real *row = field->from_local + 4 * a;
            u[a] = row[0] * wrapped[0] + row[1] * wrapped[1] + row[2] * wrapped[2] + row[3];
            inside &= (u[a] >= field->lo[a]) & (u[a] <= field->hi[a]);
        }
        for (int c = 0; c < 3 && inside; c++) {
            if (field->shape == NPH_SHAPE_GRID && (c == 0 || emitter->grids > 1))
                value = r_grid_value(&emitter->grid[c], u[0], u[1], u[2]);
            j[c] += emitter->value[c] * value;
        }
    }
}

#endif
