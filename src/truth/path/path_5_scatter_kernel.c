/* SPDX-License-Identifier: Apache-2.0
 *
 * path.scatter: a collision takes its albedo, may end the path by roulette (below `roulette` it survives with
 * probability weight / (2 roulette), keeping the mean), and turns into a direction of the phase function. Survivors are
 * written one after the other into the other set of paths. At albedo 1 no weight falls and no path is ended: it leaves
 * through the surface, after sigma 4V/S collisions in the mean. On surfaces directions have the density cos / pi.
 * [paths, queue, distance, medium, surface -> the other paths; samples at the first vertex] */
#include "transport/camera_lookup.h"
#include "truth/path/path_state.h"

void NPH_KERNEL(nph_path_scatter)(NphPathBatch *batch);

/* What the lane loops below hold in registers. */
typedef struct RScatter {
    RPhase phase;
    Real albedo, roulette, part, unit, sun[3];
    RTile tile;
} RScatter;

/* Grey transport in one medium: path queue[k] into place k of `to`, with weight 0 where it ends. */
R_INLINE void turn_lane(const RScatter *scatter, const Real *from, const int32_t *id, int i, Real distance, Real *to,
                        int k, int guided) {
    NphWords words = r_tile_words(&scatter->tile, id[i], 0);
    Real d[3] = {r_lane(from, R_OF_D, i), r_lane(from, R_OF_D + 1, i), r_lane(from, R_OF_D + 2, i)};
    Real part = r_part_of(scatter->part, r_lane(from, R_OF_WEIGHT, i), scatter->unit);
    RTurned turned = guided ? r_turn_guided(&scatter->phase, d, scatter->sun, part, words)
                            : r_turn_plain(&scatter->phase, d, words);
    Real weight = r_lane(from, R_OF_WEIGHT, i) * scatter->albedo * turned.weight;
    if (NPH_BUG(5)) weight *= scatter->albedo;
    Real survival = r_survival(scatter->roulette, weight, turned.peak);
    Real lives = (Real)(r_uniform(words.w3) < survival);
    to[R_OF_P * NPH_PATH_BATCH + k] = r_lane(from, R_OF_P, i) + distance * d[0];
    to[(R_OF_P + 1) * NPH_PATH_BATCH + k] = r_lane(from, R_OF_P + 1, i) + distance * d[1];
    to[(R_OF_P + 2) * NPH_PATH_BATCH + k] = r_lane(from, R_OF_P + 2, i) + distance * d[2];
    to[R_OF_D * NPH_PATH_BATCH + k] = turned.d[0];
    to[(R_OF_D + 1) * NPH_PATH_BATCH + k] = turned.d[1];
    to[(R_OF_D + 2) * NPH_PATH_BATCH + k] = turned.d[2];
    to[R_OF_WEIGHT * NPH_PATH_BATCH + k] = lives > R(0.0) ? weight / (NPH_BUG(16) ? R(1.0) : survival) : R(0.0);
    to[R_OF_PDF * NPH_PATH_BATCH + k] = turned.pdf;
}

/* A loop for each kind of phase function, so that none chooses by lane. */
#define TURN(name, phase_kind, guided)                                                                                      \
    R_OUTLINE void name(const RScatter *restrict constant, const Real *restrict from, const int32_t *restrict id,   \
                        const int32_t *restrict queue, const Real *restrict distance, Real *restrict to) {          \
        RScatter scatter = *constant;                                                                               \
        scatter.phase.kind = (phase_kind);                                                                          \
        int count = r_whole_vectors(scatter.tile.count);                                                            \
        for (int k = 0; k < count; k++) turn_lane(&scatter, from, id, queue[k], distance[queue[k]], to, k, guided); \
    }
TURN(turn_isotropic, NPH_PHASE_ISOTROPIC, 0) /* vec */
TURN(turn_hg, NPH_PHASE_HG, 0) /* vec */
TURN(turn_two_lobe, NPH_PHASE_TWO_LOBE, 0) /* vec */
TURN(turn_rayleigh, NPH_PHASE_RAYLEIGH, 0) /* vec */
TURN(turn_draine, NPH_PHASE_DRAINE, 0)
TURN(turn_tabulated, NPH_PHASE_TABULATED, 0)
TURN(guide_hg, NPH_PHASE_HG, 1) /* vec */
TURN(guide_two_lobe, NPH_PHASE_TWO_LOBE, 1) /* vec */
TURN(guide_draine, NPH_PHASE_DRAINE, 1)
TURN(guide_tabulated, NPH_PHASE_TABULATED, 1)

/* Where every path lives, as at albedo 1, they stand together already. */
static int keep_ranks(const NphPathBatch *batch, const RPaths *from, RPaths *to) {
    int dead = 0;
    for (int k = 0; k < batch->queued; k++) dead |= !(to->weight[0][k] > R(0.0));
    if (dead) return 0;
    for (int k = 0; k < batch->queued; k++) to->share[0][k] = R(1.0);
    for (int k = 0; k < batch->queued; k++) to->id[k] = from->id[batch->queue[k]];
    for (int k = 0; k < batch->queued; k++) to->hero[k] = from->hero[batch->queue[k]];
    return 1;
}

/* Moves the paths that live together, in their order. */
static int close_ranks(const NphPathBatch *batch, const RPaths *from, RPaths *to) {
    int count = 0;
    if (keep_ranks(batch, from, to)) return batch->queued;
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

/* x and y of all paths back into the first period. */
static void wrap_lanes(const RPeriod *period, int count, Real *p) {
    for (int a = 0; a < 2 && period->on; a++) {
        Real lo = period->lo[a], size = period->size[a], inverse = period->inverse[a], *u = p + (R_OF_P + a) * NPH_PATH_BATCH;
        for (int k = 0; k < count; k++) u[k] = r_wrap(u[k], lo, size, inverse);
    }
}

static int scatter_lanes(NphPathBatch *batch, uint32_t vertex) {
    const RScene *scene = batch->scene;
    const RPaths *from = &batch->paths[batch->now];
    RPaths *to = &batch->paths[1 - batch->now];
    const RMedium *medium = &scene->media[0];
    RStream stream = r_stream(scene, NPH_RNG_SCATTER, 0, 0, vertex);
    int guided = scene->guide >= 0;
    const Real *sun = scene->lights[guided ? scene->guide : 0].direction;
    RScatter scatter = {medium->phase, medium->albedo[0], scene->roulette, scene->guide_part,
                        scene->weight_unit, {sun[0], sun[1], sun[2]},
                        r_tile(batch, &stream, batch->queued, 0)};
    void (*const turns[])(const RScatter *, const Real *, const int32_t *, const int32_t *, const Real *, Real *) = {
        [NPH_PHASE_ISOTROPIC] = turn_isotropic, [NPH_PHASE_HG] = guided ? guide_hg : turn_hg, [NPH_PHASE_TWO_LOBE] = guided ? guide_two_lobe : turn_two_lobe,
        [NPH_PHASE_RAYLEIGH] = turn_rayleigh, [NPH_PHASE_DRAINE] = guided ? guide_draine : turn_draine,
        [NPH_PHASE_TABULATED] = guided ? guide_tabulated : turn_tabulated};
    turns[medium->phase.kind](&scatter, from->p[0], from->id, batch->queue, batch->distance, to->p[0]);
    wrap_lanes(&scene->period, batch->queued, to->p[0]);
    return close_ranks(batch, from, to);
}

/* Vertex k of the queue, for k from first to end; survivors are written to `to` from place count on. */
static int scatter_any(NphPathBatch *batch, int first, int end, int count, uint32_t number) {
    const RScene *scene = batch->scene;
    const RPaths *from = &batch->paths[batch->now];
    RPaths *to = &batch->paths[1 - batch->now];
    for (int k = first; k < end; k++) {
        int i = batch->queue[k];
        int32_t id = from->id[i];
        RVertex vertex;
        r_path_vertex(batch, i, &vertex);
        RStream stream = r_stream(scene, NPH_RNG_SCATTER, r_pixel(batch, id), r_sample(batch, id), number);
        NphWords words = r_words(&stream, 0);
        Real weight[3], largest = R(0.0), before = R(0.0);
        for (int c = 0; c < scene->channels; c++) before = r_max(before, from->weight[c][i]);
        RTurned turned = r_vertex_turn(scene, &vertex, words, before);
        for (int c = 0; c < scene->channels; c++) {
            weight[c] = from->weight[c][i] * vertex.albedo[c] * turned.weight;
            if (NPH_BUG(5)) weight[c] *= vertex.albedo[c];
            largest = r_max(largest, weight[c]);
        }
        Real survival = r_survival(scene->roulette, largest, turned.peak);
        if (!(largest > R(0.0) && r_uniform(words.w3) < survival)) continue;
        r_wrap_position(&scene->period, vertex.p);
        for (int a = 0; a < 3; a++) {
            to->p[a][count] = vertex.p[a];
            to->d[a][count] = turned.d[a];
        }
        for (int c = 0; c < scene->channels; c++) {
            to->weight[c][count] = weight[c] / (NPH_BUG(16) ? R(1.0) : survival);
            to->share[c][count] = from->share[c][i];
        }
        to->pdf[count] = turned.pdf;
        to->id[count] = id;
        to->hero[count] = from->hero[i];
        count++;
    }
    return count;
}

/* What camera rays tell of their first vertex: how far it is, and, where flights are weighed, with which weight. */
static void note_first(NphPathBatch *batch) {
    const RScene *scene = batch->scene;
    const RPaths *from = &batch->paths[batch->now];
    Real camera = r_sensor_weight(scene);
    for (int k = 0; k < batch->queued + batch->touched; k++) {
        int i = batch->queue[k], in = batch->medium[i];
        int32_t id = from->id[i];
        Real weight = R(1.0), travelled = batch->start[id] + (in >= 0 ? batch->distance[i] : batch->surface_t[i]);
        if (scene->forced > R(0.0)) weight = batch->collides[id];
        else if (scene->weighed) weight = from->weight[0][i] / camera / (in >= 0 ? scene->media[0].collide : R(1.0));
        batch->samples[NPH_SAMPLE_DISTANCE * NPH_PATH_BATCH + id] = weight * travelled;
        batch->samples[NPH_SAMPLE_COLLIDED * NPH_PATH_BATCH + id] = weight;
    }
}

void NPH_KERNEL(nph_path_scatter)(NphPathBatch *batch) {
    const RScene *scene = batch->scene;
    uint32_t vertex = batch->vertex + 1u;
    int queued = batch->queued, lanes = scene->channels == 1 && scene->medium_count == 1;
    if (vertex == 1) note_first(batch);
    int count = lanes ? scatter_lanes(batch, vertex) : scatter_any(batch, 0, queued, 0, vertex);
    count = scatter_any(batch, queued, queued + batch->touched, count, vertex);
    batch->now = 1 - batch->now;
    batch->count = count;
    batch->vertex = vertex;
}
