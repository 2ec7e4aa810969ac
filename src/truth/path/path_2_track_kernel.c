/* SPDX-License-Identifier: Apache-2.0
 *
 * path.track: one whole free flight of every path. Each medium proposes its first collision, none beyond the nearest
 * so far; the nearest is the path's [superposition of Poisson processes]. For chromatic media the flight is walked once
 * more up to where it ended, to tell what the other channels would have made of it.
 * [paths.p, d, hero -> distance, medium, paths.weight, share; queue, escaped] */
#include "truth/path/path_walk.h"

void NPH_KERNEL(nph_path_track)(NphPathBatch *batch);

/* What the channels' factors do to throughput and shares: share_c f_c, normalised to mean 1. */
static void apply_factors(RPaths *paths, int i, const Real factor[3]) {
    Real mean = R(0.0);
    for (int c = 0; c < 3; c++) mean += paths->share[c][i] * factor[c];
    mean *= R(1.0) / R(3.0);
    for (int c = 0; c < 3; c++) {
        paths->share[c][i] *= factor[c] / mean;
        paths->weight[c][i] *= factor[c] / mean;
    }
}

static void track_factors(NphPathBatch *batch, int i, const Real p[3], const Real d[3], const RStream *stream) {
    const RScene *scene = batch->scene;
    RPaths *paths = &batch->paths[batch->now];
    Real factor[3] = {R(1.0), R(1.0), R(1.0)};
    int hero = paths->hero[i], hit = batch->medium[i];
    Real limit = hit >= 0 ? batch->distance[i] : R_HUGE;
    for (int m = 0; m < scene->medium_count; m++) {
        const RMedium *medium = &scene->media[m];
        if (medium->sigma[0] == medium->sigma[1] && medium->sigma[0] == medium->sigma[2]) continue;
        REvents events = r_events(stream, 0, medium->number);
        r_flight_factors(medium, p, d, limit, hero, &events, factor);
    }
    if (hit >= 0) {
        const RMedium *medium = &scene->media[hit];
        for (int c = 0; c < 3; c++) factor[c] *= medium->sigma[c] / medium->sigma[hero];
    }
    apply_factors(paths, i, factor);
}

void NPH_KERNEL(nph_path_track)(NphPathBatch *batch) {
    const RScene *scene = batch->scene;
    RPaths *paths = &batch->paths[batch->now];
    int queued = 0, left = 0;
    for (int i = 0; i < batch->count; i++) {
        Real p[3] = {paths->p[0][i], paths->p[1][i], paths->p[2][i]};
        Real d[3] = {paths->d[0][i], paths->d[1][i], paths->d[2][i]};
        RStream stream = r_stream(scene, NPH_RNG_TRACK, r_pixel(batch, paths->id[i]), r_sample(batch, paths->id[i]),
                                  batch->vertex);
        Real nearest = R_HUGE;
        int hit = -1;
        for (int m = 0; m < scene->medium_count; m++) {
            REvents events = r_events(&stream, 0, scene->media[m].number);
            Real t = r_free_flight(&scene->media[m], p, d, nearest, paths->hero[i], &events, &batch->tally);
            hit = t >= R(0.0) ? m : hit;
            nearest = t >= R(0.0) ? t : nearest;
        }
        batch->distance[i] = nearest;
        batch->medium[i] = hit;
        if (scene->channels > 1) track_factors(batch, i, p, d, &stream);
        batch->queue[queued] = i;
        batch->escaped[left] = i;
        queued += hit >= 0;
        left += hit < 0;
    }
    batch->queued = queued;
    batch->left = left;
    batch->tally.collisions += queued;
}
