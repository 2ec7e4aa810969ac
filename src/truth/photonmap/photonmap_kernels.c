/* SPDX-License-Identifier: Apache-2.0
 *
 * The photon map's kernels by precision. */
#include "truth/photonmap/photonmap.h"

#define BUILDS(type, name, arguments)                                                                                  \
    type name##_f32_base arguments;                                                                                    \
    type name##_f64_base arguments
BUILDS(size_t, nph_photonmap_scene_bytes, (void));
BUILDS(size_t, nph_photonmap_photon_bytes, (void));
BUILDS(void, nph_photonmap_prepare, (const NphJob *, const NphPhotonmapChoice *, void *));
BUILDS(int64_t, nph_photonmap_count, (const void *, uint32_t, const int64_t *, NphTally *));
BUILDS(void, nph_photonmap_store, (const void *, const NphPhotonMap *, const int64_t *, const int64_t *));
BUILDS(int64_t, nph_photonmap_thin, (const void *, uint32_t, int64_t));
BUILDS(void, nph_photonmap_march, (const void *, const NphPhotonMap *, const NphPhotonmapTile *, NphTally *));
BUILDS(void, nph_photonmap_replay, (const void *, const NphPhotonMap *, const int *, NphLineFn, void *, double *));
BUILDS(void, nph_photonmap_clear, (NphPhotonMap *));
BUILDS(void, nph_photonmap_show, (const NphPhotonMap *, int, void *));
BUILDS(void, nph_photonmap_take, (NphPhotonMap *, int, const void *));
BUILDS(void, nph_photonmap_facts, (const void *, int64_t, NphFactFn, void *));

void nph_photonmap_kernels(int precision, NphPhotonmapKernels *kernels) {
    int f32 = precision == 32;
    kernels->scene_bytes = f32 ? nph_photonmap_scene_bytes_f32_base : nph_photonmap_scene_bytes_f64_base;
    kernels->photon_bytes = f32 ? nph_photonmap_photon_bytes_f32_base : nph_photonmap_photon_bytes_f64_base;
    kernels->prepare = f32 ? nph_photonmap_prepare_f32_base : nph_photonmap_prepare_f64_base;
    kernels->count = f32 ? nph_photonmap_count_f32_base : nph_photonmap_count_f64_base;
    kernels->store = f32 ? nph_photonmap_store_f32_base : nph_photonmap_store_f64_base;
    kernels->thin = f32 ? nph_photonmap_thin_f32_base : nph_photonmap_thin_f64_base;
    kernels->march = f32 ? nph_photonmap_march_f32_base : nph_photonmap_march_f64_base;
    kernels->replay = f32 ? nph_photonmap_replay_f32_base : nph_photonmap_replay_f64_base;
    kernels->clear = f32 ? nph_photonmap_clear_f32_base : nph_photonmap_clear_f64_base;
    kernels->show = f32 ? nph_photonmap_show_f32_base : nph_photonmap_show_f64_base;
    kernels->take = f32 ? nph_photonmap_take_f32_base : nph_photonmap_take_f64_base;
    kernels->facts = f32 ? nph_photonmap_facts_f32_base : nph_photonmap_facts_f64_base;
}
