/* SPDX-License-Identifier: Apache-2.0
 *
 * The light tracer's kernels by precision; of altered programs those that do arithmetic by level too. */
#include "core/cpu.h"
#include "truth/light/light_tracing.h"

#define BUILDS(type, name, arguments) type name##_f32_base arguments; type name##_f64_base arguments
BUILDS(size_t, nph_light_scene_bytes, (void));
BUILDS(void, nph_light_prepare, (const NphJob *, const NphLightChoice *, const NphEmissionSources *, void *));
BUILDS(size_t, nph_light_batch_bytes, (void));
BUILDS(void, nph_light_layout, (void *, void *, const void *, NphLightBatch **));
BUILDS(void, nph_light_begin, (NphLightBatch *, int64_t, int64_t));
NPH_STAGE_DECLARE(void, nph_light_emit, (NphLightBatch *));
NPH_STAGE_DECLARE(void, nph_light_trace, (NphLightBatch *));
BUILDS(int, nph_light_unfinished, (const NphLightBatch *));
NPH_STAGE_DECLARE(void, nph_light_connect, (NphLightBatch *));
NPH_STAGE_DECLARE(void, nph_light_splat, (const NphLightBatch *, const NphLightImage *));
NPH_STAGE_DECLARE(void, nph_light_see, (const void *, const double *, const int *, const int *, int64_t, void *, NphTally *));
BUILDS(int64_t, nph_light_items, (const NphLightBatch *, NphLightStage));
BUILDS(size_t, nph_light_column_bytes, (void));
BUILDS(void, nph_light_start, (NphLightBatch *, NphLightPlacing));
BUILDS(void, nph_light_take, (NphLightBatch *, const char *));
BUILDS(NphStatus, nph_light_extend, (NphLightBatch *, int, int64_t));
BUILDS(int, nph_light_view, (NphLightBatch *, int, NphView *));
BUILDS(NphTally *, nph_light_tally, (NphLightBatch *));

#define TABLE(precision)                                                                                                   \
    {                                                                                                                      \
        nph_light_scene_bytes_##precision##_base, nph_light_prepare_##precision##_base,                                    \
        nph_light_batch_bytes_##precision##_base, nph_light_layout_##precision##_base, nph_light_begin_##precision##_base, \
        nph_light_emit_##precision##_base, nph_light_trace_##precision##_base, nph_light_unfinished_##precision##_base,    \
        nph_light_connect_##precision##_base, nph_light_splat_##precision##_base, nph_light_see_##precision##_base,        \
        nph_light_items_##precision##_base, nph_light_column_bytes_##precision##_base, nph_light_start_##precision##_base, \
        nph_light_take_##precision##_base, nph_light_extend_##precision##_base, nph_light_view_##precision##_base,         \
        nph_light_tally_##precision##_base                                                                                 \
    }

void nph_light_kernels(NphIsa isa, int precision, NphLightKernels *kernels) {
    static const NphLightKernels f32 = TABLE(f32), f64 = TABLE(f64);
    *kernels = precision == 32 ? f32 : f64;
    NPH_STAGE_PICK(kernels->emit, nph_light_emit, isa, precision);
    NPH_STAGE_PICK(kernels->trace, nph_light_trace, isa, precision);
    NPH_STAGE_PICK(kernels->connect, nph_light_connect, isa, precision);
    NPH_STAGE_PICK(kernels->splat, nph_light_splat, isa, precision);
    NPH_STAGE_PICK(kernels->see, nph_light_see, isa, precision);
}
