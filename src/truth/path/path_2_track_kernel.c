/* SPDX-License-Identifier: Apache-2.0
 *
 * path.track: one whole free flight of every path. Each medium proposes its first collision, none beyond the nearest
 * so far; the nearest is the path's [superposition of Poisson processes]. None beyond the nearest surface either: a path
 * whose media let it through is there. For chromatic media the flight is walked once
 * more up to where it ended (reweigh), to tell what the other channels would have made of it.
 * [paths.p, d, hero -> distance, medium, surface, paths.weight, share; queue, escaped] */
#include "truth/path/path_lanes.h"

void NPH_KERNEL(nph_path_track)(NphPathBatch *batch);
void NPH_KERNEL(nph_path_reweigh)(NphPathBatch *batch);

/* The nearest surface of every path limits its flight; `distance` is that limit. */
static void meet_surfaces(NphPathBatch *batch) {
    const RPaths *paths = &batch->paths[batch->now];
    for (int i = 0; i < batch->count; i++) {
        Real p[3] = {paths->p[0][i], paths->p[1][i], paths->p[2][i]};
        Real d[3] = {paths->d[0][i], paths->d[1][i], paths->d[2][i]};
        RMet met;
        batch->surface[i] = -1;
        batch->surface_t[i] = R(0.0);
        for (int a = 0; a < 3; a++) batch->surface_p[a][i] = batch->surface_n[a][i] = R(0.0);
        if (!r_closest_surface(batch->scene, p, d, R_HUGE, &met)) continue;
        batch->surface[i] = met.surface;
        batch->distance[i] = met.limit;
        batch->surface_t[i] = met.t;
        for (int a = 0; a < 3; a++) {
            batch->surface_p[a][i] = met.p[a];
            batch->surface_n[a][i] = met.n[a];
        }
    }
}

/* What the channels' factors do to throughput and shares: share_c f_c, normalised to mean 1. */
static void apply_factors(RPaths *paths, int i, const Real factor[3]) {
    if (NPH_BUG(14)) return;
    Real mean = R(0.0);
    for (int c = 0; c < 3; c++) mean += paths->share[c][i] * factor[c];
    mean *= R(1.0) / R(3.0);
    for (int c = 0; c < 3; c++) {
        paths->share[c][i] *= factor[c] / mean;
        paths->weight[c][i] *= factor[c] / mean;
    }
}

static void track_factors(NphPathBatch *batch, int i, const Real p[3], const Real d[3], const RStream *stream) {
    const RScene *scene = r_path_scene(batch, i);
    RPaths *paths = &batch->paths[batch->now];
    Real factor[3] = {R(1.0), R(1.0), R(1.0)};
    int hero = r_hero_channel(paths->hero[i]), hit = batch->medium[i];
    for (int m = 0; m < scene->medium_count; m++) {
        const RMedium *medium = &scene->media[m];
        if (medium->sigma[0] == medium->sigma[1] && medium->sigma[0] == medium->sigma[2]) continue;
        REvents events = r_events(stream, 0, medium->number);
        r_flight_factors(medium, p, d, batch->distance[i], hero, &events, factor);
    }
    if (hit >= 0) {
        const RMedium *medium = &scene->media[hit];
        for (int c = 0; c < 3; c++) factor[c] *= medium->sigma[c] / medium->sigma[hero];
    }
    apply_factors(paths, i, factor);
}

/* One medium for channels that are alike, path by path; paths.distance and medium are what the media before left. */
static void fly_one_by_one(NphPathBatch *batch, int m, const RStream *base) {
    const RScene *scene = batch->scene;
    const RPaths *paths = &batch->paths[batch->now];
    for (int i = 0; i < batch->count; i++) {
        Real p[3] = {paths->p[0][i], paths->p[1][i], paths->p[2][i]};
        Real d[3] = {paths->d[0][i], paths->d[1][i], paths->d[2][i]};
        RStream stream = *base;
        stream.pixel = r_pixel(batch, paths->id[i]);
        stream.sample = r_sample(batch, paths->id[i]);
        REvents events = r_events(&stream, 0, scene->media[m].number);
        Real t = r_free_flight(&scene->media[m], p, d, batch->distance[i], paths->hero[i], &events, &batch->tally);
        batch->medium[i] = t >= R(0.0) ? m : batch->medium[i];
        batch->distance[i] = t >= R(0.0) ? t : batch->distance[i];
        batch->survived[i] = events.survived;
        batch->expected[i] = events.expected;
    }
}

/* The closed form for one path: t = near - ln(1 - u) / sigma. `survived` lies behind `distance`. */
R_INLINE void fly_lane(const RMedium *medium, const RTile *tile, const Real *ray, int32_t id, int i, Real *distance,
                       int32_t *medium_of, int weighed) {
    RSpan span = r_clip_ray(medium, ray, i, NPH_BUG(22) ? R_HUGE : distance[i]);
    NphWords words = r_tile_words(tile, id, 0);
    Real t = span.near + r_event_depth(words.w0) / (medium->sigma[0] * medium->collide);
    int hits = span.inside & (t < span.far);
    if (weighed) {
        Real survived = r_segment_weight(medium, (t < span.far ? t : span.far) - span.near);
        distance[NPH_PATH_BATCH + i] = span.inside ? survived : R(1.0);
    }
    distance[i] = hits ? t : distance[i];
    medium_of[i] = hits ? tile->medium : medium_of[i];
}

R_OUTLINE void fly_homogeneous(const RMedium *restrict medium, const Real *restrict ray, const int32_t *restrict id,
                               const RTile *restrict from, Real *restrict distance, int32_t *restrict medium_of) {
    const RTile tile = *from;
    int count = r_whole_vectors(tile.count);
    for (int i = 0; i < count; i++) fly_lane(medium, &tile, ray, id[i], i, distance, medium_of, 0); /* vec */
}

R_OUTLINE void fly_weighed(const RMedium *restrict medium, const Real *restrict ray, const int32_t *restrict id,
                           const RTile *restrict from, Real *restrict distance, int32_t *restrict medium_of) {
    const RTile tile = *from;
    int count = r_whole_vectors(tile.count);
    for (int i = 0; i < count; i++) fly_lane(medium, &tile, ray, id[i], i, distance, medium_of, 1); /* vec */
}

/* A flight that is split: survived and expected take what passes and what collides. */
R_INLINE void force_lane(const RMedium *medium, const RTile *tile, const Real *ray, int32_t id, int i, Real oftener,
                         Real *distance, int32_t *medium_of) {
    RSpan span = r_clip_ray(medium, ray, i, R_HUGE);
    RForced forced = r_forced_flight(medium, &span, oftener, r_tile_words(tile, id, 0));
    distance[NPH_PATH_BATCH + i] = forced.through;
    distance[2 * NPH_PATH_BATCH + i] = forced.collides;
    distance[i] = forced.collides > R(0.0) ? forced.t : distance[i];
    medium_of[i] = forced.collides > R(0.0) ? tile->medium : medium_of[i];
}

R_OUTLINE void force_flights(const RMedium *restrict medium, const Real *restrict ray, const int32_t *restrict id,
                             const RTile *restrict from, Real oftener, Real *restrict distance,
                             int32_t *restrict medium_of) {
    const RTile tile = *from;
    int count = r_whole_vectors(tile.count);
    for (int i = 0; i < count; i++) force_lane(medium, &tile, ray, id[i], i, oftener, distance, medium_of); /* vec */
}

/* Flights of camera rays that are split. */
static void track_forced(NphPathBatch *batch) {
    const RMedium *medium = &batch->scene->media[0];
    RPaths *paths = &batch->paths[batch->now];
    RStream stream = r_stream(batch->scene, NPH_RNG_TRACK, 0, 0, batch->vertex);
    stream.draw = medium->number << NPH_DRAW_MEDIUM_SHIFT;
    RTile tile = r_tile(batch, &stream, batch->count, 0);
    force_flights(medium, paths->p[0], paths->id, &tile, batch->scene->forced, batch->distance, batch->medium);
    batch->tally.tentative += batch->count;
    for (int i = 0; i < batch->count; i++) {
        batch->collides[paths->id[i]] = batch->expected[i];
        paths->weight[0][i] *= medium->collide;
    }
}

/* paths.weight takes the flights' weights (flight_lookup.h). */
R_OUTLINE void weigh(const RMedium *restrict medium, const Real *restrict survived, const Real *restrict expected,
                     Real *restrict weight, int alive) {
    int count = r_whole_vectors(alive);
    for (int i = 0; i < count; i++) weight[i] *= r_flight_weight(medium, survived[i], expected[i]); /* vec */
}

static void track_grey(NphPathBatch *batch) {
    const RScene *scene = batch->scene;
    RPaths *paths = &batch->paths[batch->now];
    RStream stream = r_stream(scene, NPH_RNG_TRACK, 0, 0, batch->vertex);
    for (int i = 0; i < batch->count && scene->weighed; i++) {
        batch->survived[i] = R(1.0);
        batch->expected[i] = R(0.0);
    }
    for (int m = 0; m < scene->medium_count; m++) {
        const RMedium *medium = &scene->media[m];
        stream.draw = medium->number << NPH_DRAW_MEDIUM_SHIFT;
        if (!(medium->sigma[0] > R(0.0))) continue;
        if (batch->count <= R_FEW || (medium->period.on && medium->shape != NPH_SHAPE_GRID)) {
            fly_one_by_one(batch, m, &stream);
        } else if (medium->shape != NPH_SHAPE_GRID) {
            RTile tile = r_tile(batch, &stream, batch->count, m);
            (scene->weighed ? fly_weighed : fly_homogeneous)(medium, paths->p[0], paths->id, &tile, batch->distance, batch->medium);
            batch->tally.tentative += batch->count;
        } else {
            RFlights *flights = batch->flights;
            flights->scene = scene;
            flights->medium = medium;
            flights->stream = stream;
            flights->batch = batch;
            flights->rays = (RRays){paths->p[0], batch->distance, batch->survived, batch->expected, paths->id, batch->count};
            r_flights_run(flights, &batch->tally, 0, batch->medium, m);
        }
        if (scene->weighed) weigh(medium, batch->survived, batch->expected, paths->weight[0], batch->count);
    }
}

static void track_wide(NphPathBatch *batch) {
    const RPaths *paths = &batch->paths[batch->now];
    for (int i = 0; i < batch->count; i++) {
        const RScene *scene = r_path_scene(batch, i);
        Real p[3] = {paths->p[0][i], paths->p[1][i], paths->p[2][i]};
        Real d[3] = {paths->d[0][i], paths->d[1][i], paths->d[2][i]};
        RStream stream = r_stream(scene, NPH_RNG_TRACK, r_pixel(batch, paths->id[i]), r_sample(batch, paths->id[i]),
                                  batch->vertex);
        Real nearest = batch->distance[i];
        int hit = -1;
        for (int m = 0; m < scene->medium_count; m++) {
            REvents events = r_events(&stream, 0, scene->media[m].number);
            Real t = r_free_flight(&scene->media[m], p, d, nearest, r_hero_channel(paths->hero[i]), &events, &batch->tally);
            hit = t >= R(0.0) ? m : hit;
            nearest = t >= R(0.0) ? t : nearest;
        }
        batch->distance[i] = nearest;
        batch->medium[i] = hit;
    }
}

void NPH_KERNEL(nph_path_reweigh)(NphPathBatch *batch) {
    const RPaths *paths = &batch->paths[batch->now];
    for (int i = 0; i < batch->count; i++) {
        Real p[3] = {paths->p[0][i], paths->p[1][i], paths->p[2][i]};
        Real d[3] = {paths->d[0][i], paths->d[1][i], paths->d[2][i]};
        RStream stream = r_stream(batch->scene, NPH_RNG_TRACK, r_pixel(batch, paths->id[i]),
                                  r_sample(batch, paths->id[i]), batch->vertex);
        track_factors(batch, i, p, d, &stream);
    }
}

/* Of those that do not collide the ones at surfaces join the queue. */
static void part_touched(NphPathBatch *batch) {
    int all = batch->left;
    batch->left = 0;
    for (int k = 0; k < all; k++) {
        int i = batch->escaped[k];
        if (batch->surface[i] >= 0) batch->queue[batch->queued + batch->touched++] = i;
        else batch->escaped[batch->left++] = i;
    }
}

void NPH_KERNEL(nph_path_track)(NphPathBatch *batch) {
    int queued = 0, left = 0;
    for (int i = 0; i < batch->count; i++) batch->distance[i] = R_HUGE;
    for (int i = 0; i < batch->count; i++) batch->medium[i] = -1;
    if (batch->scene->surfaces.count > 0) meet_surfaces(batch);
    if (batch->scene->channels > 1) track_wide(batch);
    else if (batch->scene->forced > R(0.0) && batch->vertex == 0) track_forced(batch);
    else track_grey(batch);
    for (int i = 0; i < batch->count; i++) {
        batch->queue[queued] = i;
        batch->escaped[left] = i;
        queued += batch->medium[i] >= 0;
        left += batch->medium[i] < 0;
    }
    batch->queued = queued;
    batch->touched = 0;
    batch->left = left;
    if (batch->scene->surfaces.count > 0) part_touched(batch);
    batch->tally.collisions += queued;
}
