/* SPDX-License-Identifier: Apache-2.0
 *
 * Which build of the stages of single: there is one, but for altered programs. */
#include "core/cpu.h"
#include "truth/single/single.h"

#ifdef NPH_ALTERED_STAGES
NPH_STAGE_DECLARE(void, nph_single_launch, (NphSingleBatch *, NphSingleStage));

NphSingleLaunchFn nph_single_kernel(NphIsa isa) {
    NphSingleLaunchFn launch;
    NPH_STAGE_PICK(launch, nph_single_launch, isa, 64);
    return launch;
}
#else
NphSingleLaunchFn nph_single_kernel(NphIsa isa) {
    (void)isa;
    return nph_single_launch;
}
#endif
