/* SPDX-License-Identifier: Apache-2.0
 *
 * Cloud microphysics: extinction of water droplets in the geometric-optics limit Q = 2. */
#ifndef NPH_FIELD_CLOUD_H
#define NPH_FIELD_CLOUD_H

#include "io/volume.h"

/* sigma_t [1/m] = 3 Q LWC / (4 rho_w r_e) = 1.5 LWC [g/m3] / r_e [um] for Q = 2, rho_w = 1e6 g/m3; 0 where LWC is 0 or
 * r_e is 0 with LWC 0; LWC > 0 with r_e = 0 is refused. Makes an f32 array of the same shape. When altitudes are not
 * equidistant they are refused too, naming the level. box_lo/hi: outermost points. */
NphStatus nph_cloud_extinction(NphContext *context, const NphLes *les, const char *what, NphArray *sigma_t_per_m,
                               double box_lo_m[3], double box_hi_m[3]);

#endif
