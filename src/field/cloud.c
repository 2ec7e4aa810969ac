/* SPDX-License-Identifier: Apache-2.0
 *
 * From the water content and effective radius of a cloud model to extinction:
 *     sigma_t = 3 Q LWC / (4 rho_w r_e), Q = 2 (droplets much larger than the wavelength), rho_w = 1e6 g/m3
 * [Stephens78]. With r_e in micrometres: 1.5 LWC / r_e [1/m]. */
#include "field/cloud.h"

#include <math.h>

#include "core/message.h"

/* How far an altitude may be from its equidistant place, in units of the spacing: files round to whole metres (les_stcu
 * has 438, 463, 488, 512 m ...). Eight levels that grow by 1% each are off by 0.06 already. */
static const double level_tolerance = 0.05;

static NphStatus check_shapes(NphContext *context, const NphLes *les, const char *what) {
    const NphArray *lwc = &les->lwc_g_per_m3, *reff = &les->reff_um, *height = &les->height_m;
    int same = lwc->rank == 3 && reff->rank == 3 && height->rank == 1 && lwc->type == NPH_F32 &&
               reff->type == NPH_F32 && height->type == NPH_F64;
    for (int axis = 0; axis < 3; axis++) same &= lwc->shape[axis] == reff->shape[axis] && lwc->shape[axis] > 0;
    if (!same || height->shape[0] != lwc->shape[0])
        return nph_error(context, NPH_BAD_USAGE, "%s: water content, radius and altitudes differ in shape", what);
    for (int axis = 0; axis < 2; axis++)
        if (!(les->spacing_m[axis] > 0) || !isfinite(les->spacing_m[axis]))
            return nph_error(context, NPH_BAD_INPUT, "%s: the spacing along %c is %g m; it must be above 0", what,
                             "xy"[axis], les->spacing_m[axis]);
    return NPH_OK;
}

static NphStatus check_levels(NphContext *context, const NphArray *height_m, const char *what) {
    const double *z = height_m->data;
    int64_t n = height_m->shape[0];
    double spacing = n > 1 ? (z[n - 1] - z[0]) / (double)(n - 1) : 1;
    for (int64_t k = 0; k < n; k++)
        if (!isfinite(z[k]))
            return nph_error(context, NPH_BAD_INPUT, "%s: the altitude of level %lld is %g m", what, (long long)k,
                             z[k]);
    if (!(spacing > 0))
        return nph_error(context, NPH_BAD_INPUT, "%s: altitudes do not rise (%g m to %g m)", what, z[0], z[n - 1]);
    for (int64_t k = 0; k < n; k++) {
        double even = z[0] + (double)k * spacing;
        if (!(fabs(z[k] - even) <= level_tolerance * spacing))
            return nph_error(context, NPH_BAD_INPUT,
                             "%s: altitudes are not equidistant: level %lld is at %g m, %g m would be even", what,
                             (long long)k, z[k], even);
    }
    return NPH_OK;
}

static NphStatus convert(NphContext *context, const NphLes *les, const char *what, float *sigma_t) {
    const float *lwc = les->lwc_g_per_m3.data, *reff = les->reff_um.data;
    int64_t ny = les->lwc_g_per_m3.shape[1], nx = les->lwc_g_per_m3.shape[2];
    int64_t count = nph_array_count(&les->lwc_g_per_m3);
    for (int64_t i = 0; i < count; i++) {
        if (lwc[i] == 0) continue; /* whatever the radius: there is no droplet */
        double sigma = 1.5 * (double)lwc[i] / (double)reff[i];
        if (lwc[i] > 0 && reff[i] > 0 && isfinite(reff[i]) && sigma <= NPH_DENSITY_MAX) {
            sigma_t[i] = (float)sigma;
            continue;
        }
        return nph_error(context, NPH_BAD_INPUT,
                         "%s: point (%lld, %lld, %lld) has %g g/m3 of water and a radius of %g um; water is finite and "
                         "not negative, the radius above 0 where there is water",
                         what, (long long)(i % nx), (long long)(i / nx % ny), (long long)(i / (nx * ny)),
                         (double)lwc[i], (double)reff[i]);
    }
    return NPH_OK;
}

NphStatus nph_cloud_extinction(NphContext *context, const NphLes *les, const char *what, NphArray *sigma_t_per_m,
                               double box_lo_m[3], double box_hi_m[3]) {
    NPH_TRY(check_shapes(context, les, what));
    NPH_TRY(check_levels(context, &les->height_m, what));
    NphArray made = {0};
    const NphArray *lwc = &les->lwc_g_per_m3;
    NPH_TRY(nph_array_new(context, NPH_F32, 3, lwc->shape, what, &made));
    NphStatus status = convert(context, les, what, made.data);
    if (status != NPH_OK) {
        nph_array_free(context, &made);
        return status;
    }
    const double *height = les->height_m.data;
    for (int axis = 0; axis < 2; axis++) {
        box_lo_m[axis] = 0;
        box_hi_m[axis] = (double)(lwc->shape[2 - axis] - 1) * les->spacing_m[axis];
    }
    box_lo_m[2] = height[0];
    box_hi_m[2] = height[lwc->shape[0] - 1];
    *sigma_t_per_m = made;
    return NPH_OK;
}
