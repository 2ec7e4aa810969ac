/* SPDX-License-Identifier: Apache-2.0
 *
 * The light tracer's kernels by precision. */
#include "truth/light/light_tracing.h"

#define BUILDS(type, name, arguments) type name##_f32_base arguments; type name##_f64_base arguments
BUILDS(size_t, nph_light_scene_bytes, (void));
BUILDS(void, nph_light_prepare, (const NphJob *, const NphLightChoice *, const NphEmissionSources *, void *));
BUILDS(void, nph_light_trace, (const void *, NphLightImage *));
BUILDS(void, nph_light_see, (const void *, const NphLightImage *, const int *, const int *, void *, NphTally *));

void nph_light_kernels(int precision, NphLightKernels *kernels) {
    int f32 = precision == 32;
    kernels->scene_bytes = f32 ? nph_light_scene_bytes_f32_base : nph_light_scene_bytes_f64_base;
    kernels->prepare = f32 ? nph_light_prepare_f32_base : nph_light_prepare_f64_base;
    kernels->trace = f32 ? nph_light_trace_f32_base : nph_light_trace_f64_base;
    kernels->see = f32 ? nph_light_see_f32_base : nph_light_see_f64_base;
}
