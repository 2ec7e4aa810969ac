/* SPDX-License-Identifier: Apache-2.0
 *
 * The making of a photon map: blocks of photons are counted, the counts are summed in order of blocks, and every block
 * stores from its own number on; then the tree. Which thread does a block is nowhere in the result. */
#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"
#include "truth/photonmap/photonmap.h"

int64_t nph_photonmap_blocks(int64_t photons) { return (photons + NPH_PHOTONMAP_BLOCK - 1) / NPH_PHOTONMAP_BLOCK; }

int64_t nph_photonmap_most(const NphPhotonmapChoice *choice) {
    return !choice->traced ? 0 : choice->emitted ? choice->emitted : choice->most;
}

int64_t nph_photonmap_pilot_photons(const NphPhotonmapChoice *choice) {
    if (!choice->traced || choice->emitted) return 0;
    return choice->most < NPH_PHOTONMAP_PILOT_PHOTONS ? choice->most : NPH_PHOTONMAP_PILOT_PHOTONS;
}

uint64_t nph_photonmap_map_bytes(int precision, const NphPhotonmapChoice *choice, uint64_t threads) {
    NphPhotonmapKernels kernels;
    nph_photonmap_kernels(NPH_ISA_BASE, precision, &kernels);
    uint64_t photon = kernels.photon_bytes() + 2 * nph_kd_node_bytes(precision);
    return (uint64_t)choice->room * photon +
           (2 * (uint64_t)nph_photonmap_blocks(nph_photonmap_most(choice)) + 1) * sizeof(int64_t) +
           threads * (sizeof(NphTally) + sizeof(NphStageCounts) + sizeof(double));
}

void nph_photonmap_maker_close(NphPhotonmapMaker *maker) {
    nph_free(maker->context, maker->counts);
    nph_free(maker->context, maker->first);
    nph_free(maker->context, maker->map.photons);
    nph_free(maker->context, maker->map.names);
    nph_free(maker->context, maker->map.tree.nodes);
    nph_free(maker->context, maker->map.tree.items);
    nph_free(maker->context, maker->tallies);
    nph_free(maker->context, maker->stages);
    nph_free(maker->context, maker->seconds);
}

static NphStatus allocate(NphPhotonmapMaker *maker, const NphJob *job, const NphPhotonmapChoice *choice) {
    NphContext *context = job->context;
    int threads = nph_context_threads(context);
    size_t room = (size_t)choice->room, node = nph_kd_node_bytes(job->precision);
    int64_t blocks = nph_photonmap_blocks(nph_photonmap_most(choice));
    NPH_TRY(NPH_NEW(context, blocks > 0 ? blocks : 1, "counts of photons", &maker->counts));
    NPH_TRY(NPH_NEW(context, blocks + 1, "numbers of photons", &maker->first));
    NPH_TRY(nph_alloc(context, room, maker->kernels.photon_bytes(), "photons", &maker->map.photons));
    NPH_TRY(nph_alloc(context, room, node, "photon tree", &maker->map.tree.nodes));
    NPH_TRY(nph_alloc(context, room, node, "photons to sort", &maker->map.tree.items));
    NPH_TRY(NPH_NEW(context, threads, "counts of events", &maker->tallies));
    NPH_TRY(NPH_NEW(context, threads, "counts of stages", &maker->stages));
    return NPH_NEW(context, threads, "seconds", &maker->seconds);
}

NphStatus nph_photonmap_maker_open(const NphJob *job, const NphPhotonmapChoice *choice, const void *scene,
                                   NphPhotonmapMaker *maker) {
    NphPhotonmapMaker made = {.context = job->context, .choice = choice, .scene = scene};
    nph_photonmap_kernels(nph_context_isa(job->context), job->precision, &made.kernels);
    made.map.room = choice->room;
    made.map.emitted = nph_photonmap_most(choice); /* until the pilot knows better */
    made.map.tree.precision = job->precision;
    NphStatus status = allocate(&made, job, choice);
    if (status != NPH_OK) {
        nph_photonmap_maker_close(&made);
        return status;
    }
    *maker = made;
    return NPH_OK;
}

static void range_of(const NphPhotonmapMaker *maker, int64_t block, int64_t range[2]) {
    range[0] = block * NPH_PHOTONMAP_BLOCK;
    range[1] = range[0] + NPH_PHOTONMAP_BLOCK;
    if (range[1] > maker->traced) range[1] = maker->traced;
}

static NphStatus count_block(void *data, int64_t block, int worker) {
    NphPhotonmapMaker *maker = data;
    int pilot = maker->map.sample == (uint32_t)NPH_PHOTONMAP_PILOT_SAMPLE;
    int64_t range[2];
    range_of(maker, block, range);
    NPH_LAUNCH(&maker->stages[worker], pilot ? NPH_PHOTONMAP_PILOT : NPH_PHOTONMAP_COUNT, range[1] - range[0],
               maker->counts[block] =
                   maker->kernels.count(maker->scene, maker->map.sample, range, &maker->tallies[worker]));
    return NPH_OK;
}

static NphStatus count_all(NphPhotonmapMaker *maker, int64_t photons) {
    maker->traced = photons;
    maker->blocks = nph_photonmap_blocks(photons);
    return nph_pool_run(maker->context, maker->blocks, count_block, maker, NULL);
}

/* How many photons fill the map, from what the pilot's scatter in the mean: random words of their own, so the number
 * does not depend on what the map then holds, and no map is biased. */
static void fill(NphPhotonmapMaker *maker) {
    const NphPhotonmapChoice *choice = maker->choice;
    int64_t pilot = nph_photonmap_pilot_photons(choice), scattered = 0, wanted = choice->most;
    for (int64_t b = 0; b < maker->blocks; b++) scattered += maker->counts[b];
    double mean = (double)scattered / (double)pilot;
    double fills = mean > 0.0 ? (double)choice->room / mean : (double)choice->most;
    if (fills < (double)choice->most) wanted = (int64_t)fills + 1;
    maker->map.emitted = wanted;
}

/* first[b] is what blocks before b scatter; first[blocks] is all. */
static void scan(NphPhotonmapMaker *maker) {
    maker->first[0] = 0;
    for (int64_t b = 0; b < maker->blocks; b++) maker->first[b + 1] = maker->first[b] + maker->counts[b];
}

static NphStatus store_block(void *data, int64_t block, int worker) {
    NphPhotonmapMaker *maker = data;
    int64_t range[2];
    range_of(maker, block, range);
    if (maker->first[block] < maker->first[block + 1])
        NPH_LAUNCH(&maker->stages[worker], NPH_PHOTONMAP_TRACE, range[1] - range[0],
                   maker->kernels.store(maker->scene, &maker->map, range, &maker->first[block]));
    return NPH_OK;
}

/* Where somebody looks, what is numbered and not scattered (numbers may be theirs) leaves places empty. */
static NphStatus store_all(NphPhotonmapMaker *maker) {
    NphPhotonMap *map = &maker->map;
    maker->traced = map->emitted;
    map->scattered = maker->first[maker->blocks];
    int64_t stored = map->scattered < map->room ? map->scattered : map->room;
    map->thin = maker->kernels.thin(maker->scene, map->sample, map->scattered);
    map->power = stored > 0 ? (double)map->scattered / (double)stored / (double)map->emitted : 0.0;
    map->tree.count = (int32_t)stored;
    if (map->names) maker->kernels.clear(map);
    return nph_pool_run(maker->context, maker->blocks, store_block, maker, NULL);
}

static NphStatus build_tree(NphPhotonmapMaker *maker) {
    int threads = nph_context_threads(maker->context);
    NphStageCount *count = &maker->stages[0].stage[NPH_PHOTONMAP_TREE];
    for (int w = 0; w < threads; w++) maker->seconds[w] = 0.0;
    NPH_TRY(nph_kd_build(maker->context, &maker->map.tree, maker->seconds));
    for (int w = 0; w < threads; w++) maker->stages[w].stage[NPH_PHOTONMAP_TREE].seconds += maker->seconds[w];
    count->launches++;
    count->items += maker->map.tree.count;
    return NPH_OK;
}

NphStatus nph_photonmap_step(NphPhotonmapMaker *maker, NphPhotonmapStage stage) {
    NphStageCounts *counts = &maker->stages[0];
    switch (stage) {
    case NPH_PHOTONMAP_PILOT:
        maker->map.sample = (uint32_t)NPH_PHOTONMAP_PILOT_SAMPLE;
        return count_all(maker, nph_photonmap_pilot_photons(maker->choice));
    case NPH_PHOTONMAP_FILL: NPH_LAUNCH(counts, stage, 1, fill(maker)); return NPH_OK;
    case NPH_PHOTONMAP_COUNT: return count_all(maker, maker->map.emitted);
    case NPH_PHOTONMAP_SCAN: NPH_LAUNCH(counts, stage, maker->blocks, scan(maker)); return NPH_OK;
    case NPH_PHOTONMAP_TRACE: return store_all(maker);
    default: return build_tree(maker);
    }
}

NphStatus nph_photonmap_prepare_maps(NphPhotonmapMaker *maker) {
    if (nph_photonmap_pilot_photons(maker->choice) == 0) return NPH_OK;
    NPH_TRY(nph_photonmap_step(maker, NPH_PHOTONMAP_PILOT));
    return nph_photonmap_step(maker, NPH_PHOTONMAP_FILL);
}

NphStatus nph_photonmap_make(NphPhotonmapMaker *maker, uint32_t sample) {
    maker->map.sample = sample;
    for (int stage = NPH_PHOTONMAP_COUNT; stage <= NPH_PHOTONMAP_TREE; stage++)
        NPH_TRY(nph_photonmap_step(maker, (NphPhotonmapStage)stage));
    return NPH_OK;
}
