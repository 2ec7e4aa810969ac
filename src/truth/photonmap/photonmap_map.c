/* SPDX-License-Identifier: Apache-2.0
 *
 * The making of a photon map: blocks of photons are counted, the counts are summed in order of blocks, and every block
 * stores from its own number on; then the tree. Which thread does a block is nowhere in the result. */
#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"
#include "truth/photonmap/photonmap.h"

static int64_t blocks_of(int64_t photons) { return (photons + NPH_PHOTONMAP_BLOCK - 1) / NPH_PHOTONMAP_BLOCK; }

/* Photons of a map at most. */
static int64_t emitted_of(const NphPhotonmapChoice *choice) { return choice->emitted ? choice->emitted : choice->most; }

uint64_t nph_photonmap_map_bytes(int precision, const NphPhotonmapChoice *choice, uint64_t threads) {
    NphPhotonmapKernels kernels;
    nph_photonmap_kernels(precision, &kernels);
    uint64_t photon = kernels.photon_bytes() + 2 * nph_kd_node_bytes(precision);
    return (uint64_t)choice->room * photon + (uint64_t)(blocks_of(emitted_of(choice)) + 1) * sizeof(int64_t) +
           threads * (sizeof(NphTally) + sizeof(NphStageCounts) + sizeof(double));
}

void nph_photonmap_maker_close(NphPhotonmapMaker *maker) {
    nph_free(maker->context, maker->counts);
    nph_free(maker->context, maker->map.photons);
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
    NPH_TRY(NPH_NEW(context, blocks_of(emitted_of(choice)) + 1, "counts of photons", &maker->counts));
    NPH_TRY(nph_alloc(context, room, maker->kernels.photon_bytes(), "photons", &maker->map.photons));
    NPH_TRY(nph_alloc(context, room, node, "photon tree", &maker->map.tree.nodes));
    NPH_TRY(nph_alloc(context, room, node, "photons to sort", &maker->map.tree.items));
    NPH_TRY(NPH_NEW(context, threads, "counts of events", &maker->tallies));
    NPH_TRY(NPH_NEW(context, threads, "counts of stages", &maker->stages));
    return NPH_NEW(context, threads, "seconds", &maker->seconds);
}

static NphStatus count_block(void *data, int64_t block, int worker) {
    NphPhotonmapMaker *maker = data;
    int64_t range[2] = {block * NPH_PHOTONMAP_BLOCK, (block + 1) * NPH_PHOTONMAP_BLOCK};
    if (range[1] > maker->map.emitted) range[1] = maker->map.emitted;
    NPH_LAUNCH(&maker->stages[worker], NPH_PHOTONMAP_TRACE, range[1] - range[0],
               maker->counts[block + 1] =
                   maker->kernels.count(maker->scene, maker->map.sample, range, &maker->tallies[worker]));
    return NPH_OK;
}

static NphStatus store_block(void *data, int64_t block, int worker) {
    NphPhotonmapMaker *maker = data;
    int64_t range[2] = {block * NPH_PHOTONMAP_BLOCK, (block + 1) * NPH_PHOTONMAP_BLOCK};
    if (range[1] > maker->map.emitted) range[1] = maker->map.emitted;
    if (maker->counts[block] < maker->counts[block + 1])
        NPH_LAUNCH(&maker->stages[worker], NPH_PHOTONMAP_TRACE, range[1] - range[0],
                   maker->kernels.store(maker->scene, &maker->map, range, maker->counts[block]));
    return NPH_OK;
}

/* counts[b] becomes what blocks before b scatter; counts[blocks] is all. */
static NphStatus count_all(NphPhotonmapMaker *maker, uint32_t sample, int64_t emitted) {
    maker->map.sample = sample;
    maker->map.emitted = emitted;
    maker->blocks = blocks_of(emitted);
    NPH_TRY(nph_pool_run(maker->context, maker->blocks, count_block, maker, NULL));
    maker->counts[0] = 0;
    for (int64_t b = 0; b < maker->blocks; b++) maker->counts[b + 1] += maker->counts[b];
    return NPH_OK;
}

/* How many photons fill the map, from what the pilot's scatter in the mean: random words of their own, so the number
 * does not depend on what the map then holds, and no map is biased. */
static NphStatus run_pilot(NphPhotonmapMaker *maker, const NphPhotonmapChoice *choice) {
    int64_t pilot = choice->most < NPH_PHOTONMAP_PILOT ? choice->most : NPH_PHOTONMAP_PILOT, wanted = choice->most;
    NPH_TRY(count_all(maker, (uint32_t)NPH_PHOTONMAP_PILOT_SAMPLE, pilot));
    double mean = (double)maker->counts[maker->blocks] / (double)pilot;
    double fills = mean > 0.0 ? (double)choice->room / mean : (double)choice->most;
    if (fills < (double)choice->most) wanted = (int64_t)fills + 1;
    maker->map.emitted = wanted;
    return NPH_OK;
}

NphStatus nph_photonmap_maker_open(const NphJob *job, const NphPhotonmapChoice *choice, const void *scene,
                                   NphPhotonmapMaker *maker) {
    NphPhotonmapMaker made = {.context = job->context, .scene = scene};
    nph_photonmap_kernels(job->precision, &made.kernels);
    made.map.room = choice->room;
    made.map.tree.precision = job->precision;
    NphStatus status = allocate(&made, job, choice);
    if (status == NPH_OK && choice->traced && !choice->emitted) status = run_pilot(&made, choice);
    if (status != NPH_OK) {
        nph_photonmap_maker_close(&made);
        return status;
    }
    if (choice->emitted) made.map.emitted = choice->emitted;
    if (!choice->traced) made.map.emitted = 0;
    *maker = made;
    return NPH_OK;
}

NphStatus nph_photonmap_make(NphPhotonmapMaker *maker, uint32_t sample) {
    NphPhotonMap *map = &maker->map;
    NPH_TRY(count_all(maker, sample, map->emitted));
    map->scattered = maker->counts[maker->blocks];
    int64_t stored = map->scattered < map->room ? map->scattered : map->room;
    map->thin = maker->kernels.thin(maker->scene, sample, map->scattered);
    map->power = stored > 0 ? (double)map->scattered / (double)stored / (double)map->emitted : 0.0;
    map->tree.count = (int32_t)stored;
    NPH_TRY(nph_pool_run(maker->context, maker->blocks, store_block, maker, NULL));
    int threads = nph_context_threads(maker->context);
    for (int w = 0; w < threads; w++) maker->seconds[w] = 0.0;
    NPH_TRY(nph_kd_build(maker->context, &map->tree, maker->seconds));
    for (int w = 0; w < threads; w++) maker->stages[w].stage[NPH_PHOTONMAP_TREE].seconds += maker->seconds[w];
    maker->stages[0].stage[NPH_PHOTONMAP_TREE].launches++;
    maker->stages[0].stage[NPH_PHOTONMAP_TREE].items += stored;
    return NPH_OK;
}
