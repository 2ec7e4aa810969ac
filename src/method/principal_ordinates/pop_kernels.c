/* SPDX-License-Identifier: Apache-2.0
 *
 * The kernels of principal ordinates by precision and vector level. */
#include "core/cpu.h"
#include "method/principal_ordinates/pop.h"

#define BUILDS(type, name, arguments) type name##_f32_base arguments; type name##_f64_base arguments
BUILDS(size_t, nph_pop_scene_bytes, (void));
BUILDS(size_t, nph_pop_scratch_bytes, (const NphPopChoice *));
BUILDS(void, nph_pop_prepare, (const NphJob *, const NphPopChoice *, void *));
BUILDS(void, nph_pop_facts, (const void *, NphFactFn, void *));
BUILDS(int, nph_pop_iterations, (const void *, const void *));
NPH_STAGE_DECLARE(void, nph_pop_medium, (const void *, int, int, void *));
NPH_STAGE_DECLARE(void, nph_pop_ordinates, (const NphJob *, const void *, const void *, double *, void *));
NPH_STAGE_DECLARE(void, nph_pop_reflect, (const void *, const NphPopArrays *, int));
NPH_STAGE_DECLARE(void, nph_pop_vpls, (const NphJob *, const void *, const NphPopArrays *));
NPH_STAGE_DECLARE(void, nph_pop_shadow, (const void *, const NphPopArrays *, int));
NPH_KERNEL_DECLARE(void, nph_pop_importance, (const void *, const NphPopArrays *, void *));
NPH_KERNEL_DECLARE(void, nph_pop_grid, (const void *, const NphPopArrays *, int));
NPH_KERNEL_DECLARE(void, nph_pop_inject, (const void *, const NphPopArrays *, int, void *));
NPH_KERNEL_DECLARE(void, nph_pop_propagate, (const void *, const NphPopArrays *, int, const int *, void *));
NPH_KERNEL_DECLARE(double, nph_pop_leaves, (const void *, const NphPopArrays *, int, int, void *));
NPH_KERNEL_DECLARE(void, nph_pop_join, (const void *, const NphPopArrays *, int, int));
NPH_KERNEL_DECLARE(void, nph_pop_join_scale, (const void *, const NphPopArrays *));
NPH_KERNEL_DECLARE(void, nph_pop_keep, (const void *, const NphPopArrays *, int, int));
NPH_KERNEL_DECLARE(void, nph_pop_spread, (const void *, const NphPopArrays *, int, int, int));
NPH_KERNEL_DECLARE(double, nph_pop_left, (const void *, const NphPopArrays *, int));
NPH_KERNEL_DECLARE(void, nph_pop_gather, (const void *, const NphPopArrays *, int, int));
NPH_KERNEL_DECLARE(void, nph_pop_merge, (const void *, const NphPopArrays *, int, int));
NPH_KERNEL_DECLARE(void, nph_pop_upsample, (const void *, const NphPopArrays *, int, int));
NPH_KERNEL_DECLARE(void, nph_pop_march, (const void *, const NphPopArrays *, const int *, int64_t, void *, int64_t *));
NPH_KERNEL_DECLARE(void, nph_pop_replay, (const void *, const NphPopArrays *, const int *, uint32_t, NphLineFn, void *));

void nph_pop_kernels(int precision, NphIsa isa, NphPopKernels *kernels) {
    int f32 = precision == 32;
    kernels->scene_bytes = f32 ? nph_pop_scene_bytes_f32_base : nph_pop_scene_bytes_f64_base;
    kernels->scratch_bytes = f32 ? nph_pop_scratch_bytes_f32_base : nph_pop_scratch_bytes_f64_base;
    kernels->prepare = f32 ? nph_pop_prepare_f32_base : nph_pop_prepare_f64_base;
    kernels->facts = f32 ? nph_pop_facts_f32_base : nph_pop_facts_f64_base;
    kernels->iterations = f32 ? nph_pop_iterations_f32_base : nph_pop_iterations_f64_base;
    NPH_STAGE_PICK(kernels->medium, nph_pop_medium, isa, precision);
    NPH_STAGE_PICK(kernels->ordinates, nph_pop_ordinates, isa, precision);
    NPH_STAGE_PICK(kernels->reflect, nph_pop_reflect, isa, precision);
    NPH_STAGE_PICK(kernels->vpls, nph_pop_vpls, isa, precision);
    NPH_STAGE_PICK(kernels->shadow, nph_pop_shadow, isa, precision);
    NPH_KERNEL_PICK(kernels->importance, nph_pop_importance, isa, precision);
    NPH_KERNEL_PICK(kernels->grid, nph_pop_grid, isa, precision);
    NPH_KERNEL_PICK(kernels->inject, nph_pop_inject, isa, precision);
    NPH_KERNEL_PICK(kernels->propagate, nph_pop_propagate, isa, precision);
    NPH_KERNEL_PICK(kernels->leaves, nph_pop_leaves, isa, precision);
    NPH_KERNEL_PICK(kernels->join, nph_pop_join, isa, precision);
    NPH_KERNEL_PICK(kernels->join_scale, nph_pop_join_scale, isa, precision);
    NPH_KERNEL_PICK(kernels->keep, nph_pop_keep, isa, precision);
    NPH_KERNEL_PICK(kernels->spread, nph_pop_spread, isa, precision);
    NPH_KERNEL_PICK(kernels->left, nph_pop_left, isa, precision);
    NPH_KERNEL_PICK(kernels->gather, nph_pop_gather, isa, precision);
    NPH_KERNEL_PICK(kernels->merge, nph_pop_merge, isa, precision);
    NPH_KERNEL_PICK(kernels->upsample, nph_pop_upsample, isa, precision);
    NPH_KERNEL_PICK(kernels->march, nph_pop_march, isa, precision);
    NPH_KERNEL_PICK(kernels->replay, nph_pop_replay, isa, precision);
}
