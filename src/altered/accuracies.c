/* SPDX-License-Identifier: Apache-2.0
 *
 * What interfaces promise of their functions, entered by hand from the documents that each row names. Where one promises nothing, or
 * less than its machines keep, the promise counts. */
#include "altered/altered.h"

const NphAccuracy *nph_accuracy;
uint32_t nph_accuracy_salt;

static const NphAccuracy interfaces[] = {
    {.name = "opencl",
     .source = "OpenCL C specification, section Relative Error as ULPs, full profile (of SPIR-V: OpenCL SPIR-V Environment Specification, ULP "
               "Values for Math Instructions)",
     .doubles = 1, .exp = 3, .log = 3, .expm1 = 3, .log1p = 2, .sincos = 4, .cbrt = 2, .acos = 4, .atan2 = 6, .sqrt = 3},
    {.name = "cuda",
     .source = "CUDA C++ Programming Guide, appendix Mathematical Functions, section Standard Functions, of floats",
     .doubles = 0, .exp = 2, .log = 1, .expm1 = 1, .log1p = 1, .sincos = 2, .cbrt = 1, .acos = 3, .atan2 = 3, .sqrt = 0},
    {.name = "cuda_fast",
     .source = "CUDA C++ Programming Guide, appendix Mathematical Functions, section Intrinsic Functions, -use_fast_math; where it has "
               "none, Standard Functions",
     .doubles = 0, .exp = 2, .exp_by_size = 1.173, .log = 3, .log_absolute = 0x1.8157dap-22 /* 2^-21.41 */, .expm1 = 1, .log1p = 1,
     .sincos_absolute = 0x1.c0d278p-22 /* 2^-21.19, the cosine's */, .cbrt = 1, .acos = 3, .atan2 = 3, .sqrt = 3},
    {.name = "vulkan",
     .source = "Vulkan specification, appendix Vulkan Environment for SPIR-V, section Precision of Individual Operations, GLSL.std.450",
     .doubles = 0, .exp = 3, .exp_by_size = 2, .log = 3, .log_absolute = 0x1p-21, .sincos_absolute = 0x1p-11, .acos = 4096,
     .atan2 = 4096, .sqrt = 5 /* 1 / inversesqrt: 2, and a division's 2.5 */},
    {.name = "webgpu",
     .source = "W3C WGSL, section Floating Point Accuracy",
     .doubles = 0, .exp = 3, .exp_by_size = 2, .log = 3, .log_absolute = 0x1p-21, .sincos_absolute = 0x1p-11, .acos = 4096,
     .atan2 = 4096, .sqrt = 5 /* as of vulkan */},
};

int altered_interface_count(void) { return (int)(sizeof interfaces / sizeof *interfaces); }
const NphAccuracy *altered_interface(int index) { return &interfaces[index]; }
