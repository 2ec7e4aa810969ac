/* SPDX-License-Identifier: Apache-2.0
 *
 * The kernels of temporal photons by precision and vector level. */
#include "core/cpu.h"
#include "method/temporal_photons/tpm.h"

#define BUILDS(type, name, arguments) type name##_f32_base arguments; type name##_f64_base arguments
BUILDS(size_t, nph_tpm_scene_bytes, (int));
BUILDS(void, nph_tpm_prepare, (const NphJob *, const NphTpmChoice *, void *));
NPH_STAGE_DECLARE(void, nph_tpm_resolve, (const void *, const int64_t *, const double *, void *));
BUILDS(void, nph_tpm_adopt, (void *, const void *));
BUILDS(void, nph_tpm_replay, (const void *, const void *, uint32_t, const int *, NphLineFn, void *));
BUILDS(void, nph_tpm_facts, (const void *, const NphTpmChoice *, NphFactFn, void *));
BUILDS(size_t, nph_tpm_trace_bytes, (int64_t, int));
NPH_KERNEL_DECLARE(void, nph_tpm_guide, (const void *, int, int, void *));
NPH_KERNEL_DECLARE(void, nph_tpm_guide_seen, (const void *, const void *, int, int, uint8_t *));
NPH_KERNEL_DECLARE(void, nph_tpm_upsample, (const void *, const void *, const uint8_t *, const void *, int64_t, int64_t, void *));
NPH_KERNEL_DECLARE(void, nph_tpm_march, (const void *, const void *, uint32_t, int, int, void *, int64_t *));
NPH_KERNEL_DECLARE(void, nph_tpm_enlarge, (const void *, const void *, const void *, const int *, int, int, void *));
NPH_KERNEL_DECLARE(void, nph_tpm_trace, (const void *, const NphTpmBlock *));

void nph_tpm_kernels(int precision, NphIsa isa, NphTpmKernels *kernels) {
    int f32 = precision == 32;
    kernels->scene_bytes = f32 ? nph_tpm_scene_bytes_f32_base : nph_tpm_scene_bytes_f64_base;
    kernels->prepare = f32 ? nph_tpm_prepare_f32_base : nph_tpm_prepare_f64_base;
    kernels->adopt = f32 ? nph_tpm_adopt_f32_base : nph_tpm_adopt_f64_base;
    NPH_STAGE_PICK(kernels->resolve, nph_tpm_resolve, isa, precision);
    kernels->replay = f32 ? nph_tpm_replay_f32_base : nph_tpm_replay_f64_base;
    kernels->facts = f32 ? nph_tpm_facts_f32_base : nph_tpm_facts_f64_base;
    kernels->trace_bytes = f32 ? nph_tpm_trace_bytes_f32_base : nph_tpm_trace_bytes_f64_base;
    NPH_KERNEL_PICK(kernels->guide, nph_tpm_guide, isa, precision);
    NPH_KERNEL_PICK(kernels->guide_seen, nph_tpm_guide_seen, isa, precision);
    NPH_KERNEL_PICK(kernels->upsample, nph_tpm_upsample, isa, precision);
    NPH_KERNEL_PICK(kernels->march, nph_tpm_march, isa, precision);
    NPH_KERNEL_PICK(kernels->enlarge, nph_tpm_enlarge, isa, precision);
    NPH_KERNEL_PICK(kernels->trace, nph_tpm_trace, isa, precision);
}
