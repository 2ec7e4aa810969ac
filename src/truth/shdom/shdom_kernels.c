/* SPDX-License-Identifier: Apache-2.0
 *
 * The kernels of truth/shdom by precision and vector level. */
#include "core/cpu.h"
#include "truth/shdom/shdom.h"

NPH_KERNEL_DECLARE(int64_t, nph_shdom_sweep, (const NphShdomSweep *));
NPH_KERNEL_DECLARE(void, nph_shdom_gather, (const NphShdomGather *));
NPH_KERNEL_DECLARE(void, nph_shdom_scatter, (double, const void *, const void *, const int64_t *, void *));
NPH_KERNEL_DECLARE(void, nph_shdom_difference, (const NphShdomMix *));
NPH_KERNEL_DECLARE(void, nph_shdom_combine, (const NphShdomMix *));
NPH_KERNEL_DECLARE(void, nph_shdom_store, (const double *, int64_t, void *));
NPH_KERNEL_DECLARE(double, nph_shdom_load, (const void *, int64_t));
NPH_KERNEL_DECLARE(void, nph_shdom_bubble, (const NphShdomGrid *, const void *, const void *, const int64_t *, void *));
NPH_KERNEL_DECLARE(void, nph_shdom_look, (const NphShdomLook *, const void *, double *));

void nph_shdom_kernels(NphIsa isa, int precision, NphShdomKernels *kernels) {
    NPH_KERNEL_PICK(kernels->sweep, nph_shdom_sweep, isa, precision);
    NPH_KERNEL_PICK(kernels->gather, nph_shdom_gather, isa, precision);
    NPH_KERNEL_PICK(kernels->scatter, nph_shdom_scatter, isa, precision);
    NPH_KERNEL_PICK(kernels->difference, nph_shdom_difference, isa, precision);
    NPH_KERNEL_PICK(kernels->combine, nph_shdom_combine, isa, precision);
    NPH_KERNEL_PICK(kernels->store, nph_shdom_store, isa, precision);
    NPH_KERNEL_PICK(kernels->load, nph_shdom_load, isa, precision);
    NPH_KERNEL_PICK(kernels->bubble, nph_shdom_bubble, isa, precision);
    NPH_KERNEL_PICK(kernels->look, nph_shdom_look, isa, precision);
}
