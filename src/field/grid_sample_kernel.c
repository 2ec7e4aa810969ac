/* SPDX-License-Identifier: Apache-2.0
 *
 * A loop over positions around the lookup; outside the box [lo, hi], and at NaN, the density is 0. */
#include "field/grid_sample_kernel.h"

void NPH_KERNEL(nph_grid_sample)(const GridSample *sample, const void *restrict u_in, const void *restrict v_in,
                                 const void *restrict w_in, void *restrict out_in) {
    const RGrid grid = sample->grid;
    const Real *us = u_in, *vs = v_in, *ws = w_in;
    Real *out = out_in;
    Real lo0 = (Real)sample->lo[0], lo1 = (Real)sample->lo[1], lo2 = (Real)sample->lo[2];
    Real hi0 = (Real)sample->hi[0], hi1 = (Real)sample->hi[1], hi2 = (Real)sample->hi[2];
    int64_t count = sample->count;
    for (int64_t i = 0; i < count; i++) { /* vec */
        Real u = r_max(r_min(us[i], hi0), lo0);
        Real v = r_max(r_min(vs[i], hi1), lo1);
        Real w = r_max(r_min(ws[i], hi2), lo2);
        Real inside = (Real)((u == us[i]) & (v == vs[i]) & (w == ws[i]));
        out[i] = inside * r_grid_value(&grid, u, v, w);
    }
}
