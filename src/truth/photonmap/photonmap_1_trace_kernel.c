/* SPDX-License-Identifier: Apache-2.0
 *
 * photonmap.count and photonmap.trace: photons from a light through all media [Jensen98]. The nearest collision of the media is the
 * photon's, as in path; there its weight takes the albedo, what it scatters is stored (not the first time, where direct
 * light is found by shadow rays), and it lives on with the probability of its weight, which is then 1 again: a photon
 * that is scattered is as strong as one that is not, and absorption makes them fewer.
 *
 * Photons are traced twice with the same random words: to count what they scatter, M, and to store it. Where M exceeds
 * the room N, number j of them is kept when floor(((j + 1) N + o) / M) > floor((j N + o) / M), with o uniform in
 * 0 ... M - 1: exactly N of them, each with probability N / M, and each M / N as strong. */
#include "transport/prepare_lookup.h"
#include "truth/photonmap/photonmap_depth.h"
#include "truth/photonmap/photonmap_emit.h"

size_t NPH_KERNEL(nph_photonmap_scene_bytes)(void);
size_t NPH_KERNEL(nph_photonmap_photon_bytes)(void);
void NPH_KERNEL(nph_photonmap_prepare)(const NphJob *job, const NphPhotonmapChoice *choice, void *memory);
int64_t NPH_KERNEL(nph_photonmap_count)(const void *scene, uint32_t sample, const int64_t range[2], NphTally *tally);
void NPH_KERNEL(nph_photonmap_store)(const void *scene, const NphPhotonMap *map, const int64_t range[2],
                                     const int64_t numbers[2]);
int64_t NPH_KERNEL(nph_photonmap_thin)(const void *scene, uint32_t sample, int64_t scattered);

typedef struct Flying {
    const RPhotonScene *scene;
    uint32_t photon, sample, vertex;
    Real p[3], d[3], flux[3], weight[3], share[3];
    int hero;
    NphTally *tally;
    const NphPhotonMap *map; /* NULL: what would be stored is counted */
    int64_t number, end;     /* of what is scattered next; from here on nothing is stored */
} Flying;

size_t NPH_KERNEL(nph_photonmap_scene_bytes)(void) { return sizeof(RPhotonScene); }
size_t NPH_KERNEL(nph_photonmap_photon_bytes)(void) { return sizeof(RPhoton); }

void NPH_KERNEL(nph_photonmap_prepare)(const NphJob *job, const NphPhotonmapChoice *choice, void *memory) {
    RPhotonScene *out = memory;
    memset(out, 0, sizeof *out);
    r_prepare_scene(job->scene, &choice->transport, job->seed, job->frame, &out->local);
    double sum = 0.0, squared = 0.0, power[NPH_MAX_LIGHTS] = {0.0};
    for (int l = 0; l < out->local.light_count && choice->traced; l++)
        sum += power[l] = r_entry_power(&out->local, &job->scene->lights[l], l, &out->from[l]);
    double below = 0.0;
    for (int l = 0; l < out->local.light_count && sum > 0.0; l++) {
        below += power[l];
        out->choose[l + 1] = l + 1 == out->local.light_count ? 1.0 : below / sum;
    }
    for (int a = 0; a < 3 && choice->traced; a++) {
        double size = out->local.bounds_hi[a] - out->local.bounds_lo[a];
        squared += size * size;
    }
    out->nearest = (int)job->knobs[NPH_PHOTONMAP_KNOB_NEAREST];
    out->reach = (Real)(job->knobs[NPH_PHOTONMAP_KNOB_RADIUS] * nph_sqrt(squared));
    out->step = (Real)job->knobs[NPH_PHOTONMAP_KNOB_STEP];
    out->direct = job->knobs[NPH_PHOTONMAP_KNOB_DIRECT] > 0.5;
    out->printed = job->knobs[NPH_PHOTONMAP_KNOB_PRINTED] > 0.5;
    out->local.shadow_roulette = R(0.05);
}

static RStream stream_of(const Flying *f, uint32_t stage) {
    return r_photon_stream(f->scene, stage, f->photon, f->sample, f->vertex);
}

/* The nearest of the media's collisions; its medium's position in the list, or -1. */
static int fly(Flying *f, Real *distance) {
    const RScene *local = &f->scene->local;
    RStream stream = stream_of(f, NPH_RNG_PHOTON_TRACK);
    Real nearest = R_HUGE;
    int hit = -1;
    for (int m = 0; m < local->medium_count; m++) {
        REvents events = r_events(&stream, 0, local->media[m].number);
        Real t = r_free_flight(&local->media[m], f->p, f->d, nearest, f->hero, &events, f->tally);
        if (t < R(0.0)) continue;
        nearest = t;
        hit = m;
    }
    *distance = nearest;
    return hit;
}

/* One-sample balance heuristic over the channels [Wilkie14], as in path. */
static void reweigh(Flying *f, int hit, Real distance) {
    const RScene *local = &f->scene->local;
    RStream stream = stream_of(f, NPH_RNG_PHOTON_TRACK);
    Real factor[3] = {R(1.0), R(1.0), R(1.0)}, mean = R(0.0);
    for (int m = 0; m < local->medium_count; m++) {
        const RMedium *medium = &local->media[m];
        if (medium->sigma[0] == medium->sigma[1] && medium->sigma[0] == medium->sigma[2]) continue;
        REvents events = r_events(&stream, 0, medium->number);
        r_flight_factors(medium, f->p, f->d, distance, f->hero, &events, factor);
    }
    for (int c = 0; c < 3; c++) {
        factor[c] *= local->media[hit].sigma[c] / local->media[hit].sigma[f->hero];
        mean += f->share[c] * factor[c];
    }
    mean *= R(1.0) / R(3.0);
    for (int c = 0; c < 3; c++) {
        f->share[c] *= factor[c] / mean;
        f->weight[c] *= factor[c] / mean;
    }
}

static void put(const Flying *f, int64_t slot, int medium) {
    const NphPhotonMap *map = f->map;
    RPhoton *photon = (RPhoton *)map->photons + slot;
    RKdNode *item = (RKdNode *)map->tree.items + slot;
    for (int a = 0; a < 3; a++) {
        item->p[a] = f->p[a];
        photon->d[a] = f->d[a];
        photon->power[a] = (Real)((double)(f->flux[a] * f->weight[a]) * map->power);
    }
    item->tag = (uint32_t)slot << 2;
    photon->extinction = r_extinction_at(&f->scene->local, f->p);
    photon->medium = medium;
    photon->order = (int32_t)f->vertex;
    if (map->names) map->names[slot] = (int64_t)f->photon * NPH_PHOTONMAP_NAMES + (int64_t)f->vertex;
}

static void deposit(Flying *f, int medium) {
    if (f->vertex < (f->scene->direct ? 2u : 1u)) return;
    int64_t number = f->number++;
    if (!f->map || number >= f->end) return;
    uint64_t j = (uint64_t)number, room = (uint64_t)f->map->room, all = (uint64_t)f->map->scattered;
    if (all <= room) {
        put(f, number, medium);
        return;
    }
    uint64_t slot = (j * room + (uint64_t)f->map->thin) / all;
    if (((j + 1u) * room + (uint64_t)f->map->thin) / all > slot) put(f, (int64_t)slot, medium);
}

/* Albedo, what is stored, roulette, a new direction; 0 when the photon ends. */
static int scatter(Flying *f, int hit) {
    const RMedium *medium = &f->scene->local.media[hit];
    Real largest = R(0.0);
    for (int c = 0; c < 3; c++) {
        f->weight[c] *= medium->albedo[c];
        largest = c < f->scene->local.channels ? r_max(largest, f->weight[c]) : largest;
    }
    if (!(largest > R(0.0))) return 0;
    deposit(f, hit);
    RStream stream = stream_of(f, NPH_RNG_PHOTON_SCATTER);
    NphWords words = r_words(&stream, 0);
    Real survival = largest < R(1.0) ? largest : R(1.0);
    if (!(r_uniform(words.w3) < survival)) return 0;
    RTurned turned = r_turn_plain(&medium->phase, f->d, words);
    for (int c = 0; c < 3; c++) {
        f->weight[c] /= survival;
        f->d[c] = turned.d[c];
    }
    return 1;
}

static void follow(Flying *f) {
    RStream stream = stream_of(f, NPH_RNG_PHOTON_EMIT);
    REntry start = r_emit(f->scene, &stream);
    for (int a = 0; a < 3; a++) {
        f->p[a] = start.p[a];
        f->d[a] = start.d[a];
        f->flux[a] = start.flux[a];
        f->weight[a] = f->share[a] = R(1.0);
    }
    f->hero = start.hero;
    for (;;) {
        Real distance;
        int hit = fly(f, &distance);
        if (hit < 0) return;
        if (f->scene->local.channels > 1) reweigh(f, hit, distance);
        for (int a = 0; a < 3; a++) f->p[a] += distance * f->d[a];
        f->vertex++;
        f->tally->collisions++;
        if (!scatter(f, hit)) return;
    }
}

int64_t NPH_KERNEL(nph_photonmap_count)(const void *scene, uint32_t sample, const int64_t range[2], NphTally *tally) {
    int64_t count = 0;
    const RPhotonScene *lit = scene;
    if (!(lit->choose[lit->local.light_count] > 0.0)) return 0; /* no light sends anything */
    for (int64_t i = range[0]; i < range[1]; i++) {
        Flying f = {.scene = scene, .photon = (uint32_t)i, .sample = sample, .tally = tally, .number = count};
        follow(&f);
        count = f.number;
    }
    return count;
}

void NPH_KERNEL(nph_photonmap_store)(const void *scene, const NphPhotonMap *map, const int64_t range[2],
                                     const int64_t numbers[2]) {
    NphTally counted_before = {0, 0, 0, 0};
    int64_t number = numbers[0];
    for (int64_t i = range[0]; i < range[1]; i++) {
        Flying f = {.scene = scene,
                    .photon = (uint32_t)i,
                    .sample = map->sample,
                    .tally = &counted_before,
                    .map = map,
                    .number = number,
                    .end = numbers[1]};
        follow(&f);
        number = f.number;
    }
}

/* Two words make a number in [0, scattered). */
int64_t NPH_KERNEL(nph_photonmap_thin)(const void *scene, uint32_t sample, int64_t scattered) {
    RStream stream = r_photon_stream(scene, NPH_RNG_PHOTON_THIN, 0, sample, 0);
    NphWords words = r_words(&stream, 0);
    return (int64_t)(((uint64_t)words.w0 << 32 | words.w1) % (uint64_t)(scattered > 0 ? scattered : 1));
}
