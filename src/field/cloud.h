/* SPDX-License-Identifier: Apache-2.0
 *
 * Cloud microphysics: extinction of water droplets in the geometric-optics limit Q = 2. */
#ifndef NPH_FIELD_CLOUD_H
#define NPH_FIELD_CLOUD_H

#include "field/grid.h"

/* sigma_t [1/m] = 3 Q LWC / (4 rho_w r_e) = 1.5 LWC [g/m3] / r_e [um] for Q = 2, rho_w = 1e6 g/m3; 0 where LWC is 0,
 * whatever r_e. LWC > 0 with r_e = 0 is refused, as are values that are negative or not finite. Makes an f32 array of
 * the same shape. When altitudes are not equidistant (to 5% of their spacing: files round them) they are refused too,
 * naming the level. box_lo/hi: outermost points; of a single level both are its altitude. Out-parameters are untouched
 * on error. */
NphStatus nph_cloud_extinction(NphContext *context, const NphLes *les, const char *what, NphArray *sigma_t_per_m,
                               double box_lo_m[3], double box_hi_m[3]);

#endif
