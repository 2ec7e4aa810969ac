/* SPDX-License-Identifier: Apache-2.0
 *
 * path.scatter: a collision takes its albedo, may end the path by roulette (below `roulette` it survives with
 * probability weight / (2 roulette), keeping the mean), and turns into a direction of the phase function. Survivors are
 * written one after the other into the other set of paths. At albedo 1 no weight falls and no path is ended: it leaves
 * through the surface, after sigma 4V/S collisions in the mean.
 * [paths, queue, distance, medium -> the other paths; samples at the first collision] */
#include "truth/path/path_walk.h"

void NPH_KERNEL(nph_path_scatter)(NphPathBatch *batch);

/* What the lane loops below hold in registers. */
typedef struct RScatter {
    RPhase phase;
    Real albedo, roulette;
    RTile tile;
} RScatter;

/* Grey transport in one medium: path queue[k] into place k of `to`, with weight 0 where it ends. */
R_INLINE void turn_lane(const RScatter *scatter, const Real *from, const int32_t *id, int i, Real distance, Real *to,
                             int k) {
    NphWords words = r_tile_words(&scatter->tile, id[i], 0);
    Real d[3] = {r_lane(from, R_OF_D, i), r_lane(from, R_OF_D + 1, i), r_lane(from, R_OF_D + 2, i)}, turned[3];
    Real weight = r_lane(from, R_OF_WEIGHT, i) * scatter->albedo;
    Real survival = weight < scatter->roulette ? weight / (R(2.0) * scatter->roulette) : R(1.0);
    Real lives = (Real)(r_uniform(words.w3) < survival);
    RAngle angle = r_phase_angle(&scatter->phase, r_uniform(words.w0), r_uniform(words.w2));
    r_turn_by(d, angle, r_uniform(words.w1), turned);
    to[R_OF_P * NPH_PATH_BATCH + k] = r_lane(from, R_OF_P, i) + distance * d[0];
    to[(R_OF_P + 1) * NPH_PATH_BATCH + k] = r_lane(from, R_OF_P + 1, i) + distance * d[1];
    to[(R_OF_P + 2) * NPH_PATH_BATCH + k] = r_lane(from, R_OF_P + 2, i) + distance * d[2];
    to[R_OF_D * NPH_PATH_BATCH + k] = turned[0];
    to[(R_OF_D + 1) * NPH_PATH_BATCH + k] = turned[1];
    to[(R_OF_D + 2) * NPH_PATH_BATCH + k] = turned[2];
    to[R_OF_WEIGHT * NPH_PATH_BATCH + k] = lives > R(0.0) ? weight / survival : R(0.0);
    to[R_OF_PDF * NPH_PATH_BATCH + k] = r_phase_at(&scatter->phase, angle);
}

/* A loop for each kind of phase function, so that none chooses by lane. */
#define TURN(name, phase_kind)                                                                                      \
    R_OUTLINE void name(const RScatter *restrict constant, const Real *restrict from, const int32_t *restrict id,   \
                        const int32_t *restrict queue, const Real *restrict distance, Real *restrict to) {          \
        RScatter scatter = *constant;                                                                               \
        scatter.phase.kind = (phase_kind);                                                                          \
        for (int k = 0; k < scatter.tile.count; k++) turn_lane(&scatter, from, id, queue[k], distance[queue[k]], to, k); \
    }
TURN(turn_isotropic, NPH_PHASE_ISOTROPIC)
TURN(turn_hg, NPH_PHASE_HG)
TURN(turn_two_lobe, NPH_PHASE_TWO_LOBE)
TURN(turn_rayleigh, NPH_PHASE_RAYLEIGH)

/* Moves the paths that live together, in their order. */
static int close_ranks(const NphPathBatch *batch, const RPaths *from, RPaths *to) {
    int count = 0;
    for (int k = 0; k < batch->queued; k++) {
        int i = batch->queue[k];
        if (!(to->weight[0][k] > R(0.0))) continue;
        for (int a = 0; a < 3 && count < k; a++) {
            to->p[a][count] = to->p[a][k];
            to->d[a][count] = to->d[a][k];
        }
        to->weight[0][count] = to->weight[0][k];
        to->share[0][count] = R(1.0);
        to->pdf[count] = to->pdf[k];
        to->id[count] = from->id[i];
        to->hero[count] = from->hero[i];
        count++;
    }
    return count;
}

static int scatter_lanes(NphPathBatch *batch, uint32_t vertex) {
    const RScene *scene = batch->scene;
    const RPaths *from = &batch->paths[batch->now];
    RPaths *to = &batch->paths[1 - batch->now];
    const RMedium *medium = &scene->media[0];
    RStream stream = r_stream(scene, NPH_RNG_SCATTER, 0, 0, vertex);
    RScatter scatter = {medium->phase, medium->albedo[0], scene->roulette, r_tile(batch, &stream, batch->queued, 0)};
    void (*const turns[])(const RScatter *, const Real *, const int32_t *, const int32_t *, const Real *, Real *) = {
        [NPH_PHASE_ISOTROPIC] = turn_isotropic, [NPH_PHASE_HG] = turn_hg, [NPH_PHASE_TWO_LOBE] = turn_two_lobe,
        [NPH_PHASE_RAYLEIGH] = turn_rayleigh};
    turns[medium->phase.kind](&scatter, from->p[0], from->id, batch->queue, batch->distance, to->p[0]);
    return close_ranks(batch, from, to);
}

static int scatter_any(NphPathBatch *batch, uint32_t vertex) {
    const RScene *scene = batch->scene;
    const RPaths *from = &batch->paths[batch->now];
    RPaths *to = &batch->paths[1 - batch->now];
    int count = 0;
    for (int k = 0; k < batch->queued; k++) {
        int i = batch->queue[k];
        int32_t id = from->id[i];
        const RMedium *medium = &scene->media[batch->medium[i]];
        RStream stream = r_stream(scene, NPH_RNG_SCATTER, r_pixel(batch, id), r_sample(batch, id), vertex);
        NphWords words = r_words(&stream, 0);
        Real weight[3], largest = R(0.0);
        for (int c = 0; c < scene->channels; c++) {
            weight[c] = from->weight[c][i] * medium->albedo[c];
            largest = r_max(largest, weight[c]);
        }
        Real survival = largest < scene->roulette ? largest / (R(2.0) * scene->roulette) : R(1.0);
        if (!(r_uniform(words.w3) < survival)) continue;
        Real d[3] = {from->d[0][i], from->d[1][i], from->d[2][i]}, turned[3];
        RAngle angle = r_phase_angle(&medium->phase, r_uniform(words.w0), r_uniform(words.w2));
        r_turn_by(d, angle, r_uniform(words.w1), turned);
        for (int a = 0; a < 3; a++) {
            to->p[a][count] = from->p[a][i] + batch->distance[i] * d[a];
            to->d[a][count] = turned[a];
        }
        for (int c = 0; c < scene->channels; c++) {
            to->weight[c][count] = weight[c] / survival;
            to->share[c][count] = from->share[c][i];
        }
        to->pdf[count] = r_phase_at(&medium->phase, angle);
        to->id[count] = id;
        to->hero[count] = from->hero[i];
        count++;
    }
    return count;
}

void NPH_KERNEL(nph_path_scatter)(NphPathBatch *batch) {
    const RScene *scene = batch->scene;
    const RPaths *from = &batch->paths[batch->now];
    uint32_t vertex = batch->vertex + 1u;
    Real camera = scene->sensor.kind == NPH_SENSOR_FLUX ? R(3.14159265358979323846) : R(1.0);
    for (int k = 0; k < batch->queued && vertex == 1; k++) {
        int i = batch->queue[k];
        int32_t id = from->id[i];
        Real collided = R(1.0), travelled = batch->start[id] + batch->distance[i];
        if (scene->weighed) collided = from->weight[0][i] / camera / scene->media[0].collide;
        batch->samples[NPH_SAMPLE_DISTANCE * NPH_PATH_BATCH + id] = scene->weighed ? collided * travelled : travelled;
        batch->samples[NPH_SAMPLE_COLLIDED * NPH_PATH_BATCH + id] = collided;
    }
    int lanes = scene->channels == 1 && scene->medium_count == 1;
    int count = lanes ? scatter_lanes(batch, vertex) : scatter_any(batch, vertex);
    batch->now = 1 - batch->now;
    batch->count = count;
    batch->vertex = vertex;
}
