/* SPDX-License-Identifier: Apache-2.0
 *
 * The photon map's kernels by precision; of altered programs those that do arithmetic by level too. */
#include "core/cpu.h"
#include "truth/photonmap/photonmap.h"

#define BUILDS(type, name, arguments)                                                                                  \
    type name##_f32_base arguments;                                                                                    \
    type name##_f64_base arguments
BUILDS(size_t, nph_photonmap_scene_bytes, (void));
BUILDS(size_t, nph_photonmap_photon_bytes, (void));
BUILDS(void, nph_photonmap_prepare, (const NphJob *, const NphPhotonmapChoice *, void *));
NPH_STAGE_DECLARE(int64_t, nph_photonmap_count, (const void *, uint32_t, const int64_t *, NphTally *));
NPH_STAGE_DECLARE(void, nph_photonmap_store, (const void *, const NphPhotonMap *, const int64_t *, const int64_t *));
NPH_STAGE_DECLARE(int64_t, nph_photonmap_thin, (const void *, uint32_t, int64_t));
NPH_STAGE_DECLARE(void, nph_photonmap_march, (const void *, const NphPhotonMap *, const NphPhotonmapTile *, NphTally *));
BUILDS(void, nph_photonmap_replay, (const void *, const NphPhotonMap *, const int *, NphLineFn, void *, double *));
BUILDS(void, nph_photonmap_clear, (NphPhotonMap *));
BUILDS(void, nph_photonmap_show, (const NphPhotonMap *, int, void *));
BUILDS(void, nph_photonmap_take, (NphPhotonMap *, int, const void *));
BUILDS(void, nph_photonmap_facts, (const void *, int64_t, NphFactFn, void *));

void nph_photonmap_kernels(NphIsa isa, int precision, NphPhotonmapKernels *kernels) {
    int f32 = precision == 32;
    kernels->scene_bytes = f32 ? nph_photonmap_scene_bytes_f32_base : nph_photonmap_scene_bytes_f64_base;
    kernels->photon_bytes = f32 ? nph_photonmap_photon_bytes_f32_base : nph_photonmap_photon_bytes_f64_base;
    kernels->prepare = f32 ? nph_photonmap_prepare_f32_base : nph_photonmap_prepare_f64_base;
    NPH_STAGE_PICK(kernels->count, nph_photonmap_count, isa, precision);
    NPH_STAGE_PICK(kernels->store, nph_photonmap_store, isa, precision);
    NPH_STAGE_PICK(kernels->thin, nph_photonmap_thin, isa, precision);
    NPH_STAGE_PICK(kernels->march, nph_photonmap_march, isa, precision);
    kernels->replay = f32 ? nph_photonmap_replay_f32_base : nph_photonmap_replay_f64_base;
    kernels->clear = f32 ? nph_photonmap_clear_f32_base : nph_photonmap_clear_f64_base;
    kernels->show = f32 ? nph_photonmap_show_f32_base : nph_photonmap_show_f64_base;
    kernels->take = f32 ? nph_photonmap_take_f32_base : nph_photonmap_take_f64_base;
    kernels->facts = f32 ? nph_photonmap_facts_f32_base : nph_photonmap_facts_f64_base;
}
