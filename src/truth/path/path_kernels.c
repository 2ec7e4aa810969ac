/* SPDX-License-Identifier: Apache-2.0
 *
 * The path tracer's kernels by precision and vector level. */
#include "core/cpu.h"
#include "truth/path/path.h"

#define BUILDS(type, name, arguments) type name##_f32_base arguments; type name##_f64_base arguments
BUILDS(size_t, nph_path_scene_bytes, (int groups));
BUILDS(void, nph_path_prepare, (const NphJob *, const NphPathChoice *, void *));
BUILDS(size_t, nph_path_batch_bytes, (void));
BUILDS(void, nph_path_layout, (void *, const void *, NphPathBatch **));
BUILDS(void, nph_path_begin, (NphPathBatch *, const int *, const int *, int64_t));
BUILDS(int, nph_path_count, (const NphPathBatch *));
BUILDS(const void *, nph_path_samples, (const NphPathBatch *));
BUILDS(const NphTally *, nph_path_tally, (const NphPathBatch *));
BUILDS(void, nph_path_set_vertex, (NphPathBatch *, int64_t));
BUILDS(NphStatus, nph_path_extend, (NphPathBatch *, int, int64_t));
BUILDS(int, nph_path_view, (NphPathBatch *, int, NphView *));
BUILDS(void, nph_path_walk_bounds, (void *, int, int, const float *));
BUILDS(void, nph_path_facts, (const void *, int, NphFactFn, void *));
BUILDS(void, nph_path_replay, (const void *, const int *, int64_t, NphLineFn, void *, double *));
NPH_KERNEL_DECLARE(void, nph_path_generate, (NphPathBatch *));
NPH_KERNEL_DECLARE(void, nph_path_track, (NphPathBatch *));
NPH_KERNEL_DECLARE(void, nph_path_emission, (NphPathBatch *));
NPH_KERNEL_DECLARE(void, nph_path_near, (NphPathBatch *, int));
NPH_KERNEL_DECLARE(void, nph_path_around, (NphPathBatch *, int));
NPH_KERNEL_DECLARE(void, nph_path_reweigh, (NphPathBatch *));
NPH_KERNEL_DECLARE(void, nph_path_escape, (NphPathBatch *));
NPH_KERNEL_DECLARE(void, nph_path_fold, (NphPathBatch *));
NPH_KERNEL_DECLARE(void, nph_path_shadow, (NphPathBatch *, int, int));
NPH_KERNEL_DECLARE(void, nph_path_scatter, (NphPathBatch *));

void nph_path_kernels(NphIsa isa, int precision, NphPathKernels *kernels) {
    int f32 = precision == 32;
    kernels->scene_bytes = f32 ? nph_path_scene_bytes_f32_base : nph_path_scene_bytes_f64_base;
    kernels->prepare = f32 ? nph_path_prepare_f32_base : nph_path_prepare_f64_base;
    kernels->batch_bytes = f32 ? nph_path_batch_bytes_f32_base : nph_path_batch_bytes_f64_base;
    kernels->layout = f32 ? nph_path_layout_f32_base : nph_path_layout_f64_base;
    kernels->begin = f32 ? nph_path_begin_f32_base : nph_path_begin_f64_base;
    kernels->count = f32 ? nph_path_count_f32_base : nph_path_count_f64_base;
    kernels->samples = f32 ? nph_path_samples_f32_base : nph_path_samples_f64_base;
    kernels->tally = f32 ? nph_path_tally_f32_base : nph_path_tally_f64_base;
    kernels->set_vertex = f32 ? nph_path_set_vertex_f32_base : nph_path_set_vertex_f64_base;
    kernels->extend = f32 ? nph_path_extend_f32_base : nph_path_extend_f64_base;
    kernels->view = f32 ? nph_path_view_f32_base : nph_path_view_f64_base;
    kernels->walk_bounds = f32 ? nph_path_walk_bounds_f32_base : nph_path_walk_bounds_f64_base;
    kernels->facts = f32 ? nph_path_facts_f32_base : nph_path_facts_f64_base;
    kernels->replay = f32 ? nph_path_replay_f32_base : nph_path_replay_f64_base;
    NPH_KERNEL_PICK(kernels->generate, nph_path_generate, isa, precision);
    NPH_KERNEL_PICK(kernels->track, nph_path_track, isa, precision);
    NPH_KERNEL_PICK(kernels->emission, nph_path_emission, isa, precision);
    NPH_KERNEL_PICK(kernels->near_light, nph_path_near, isa, precision);
    NPH_KERNEL_PICK(kernels->around_light, nph_path_around, isa, precision);
    NPH_KERNEL_PICK(kernels->reweigh, nph_path_reweigh, isa, precision);
    NPH_KERNEL_PICK(kernels->escape, nph_path_escape, isa, precision);
    NPH_KERNEL_PICK(kernels->fold, nph_path_fold, isa, precision);
    NPH_KERNEL_PICK(kernels->shadow, nph_path_shadow, isa, precision);
    NPH_KERNEL_PICK(kernels->scatter, nph_path_scatter, isa, precision);
}
