/* SPDX-License-Identifier: Apache-2.0
 *
 * tpm.upsample: the coarse cache at the resolution of the density, which guides it [Elek12 sec. 4.3]. At p, over the cells q of a
 * neighbourhood, with d = |p - q|, r the distance from the neighbourhood's middle to its border, D the density over its maximum:
 *   fluence     sum I(q) w / sum w,  w = f_exp(d | tau, r) max(1 - |D(p) - D(q)|, 0)
 *   f_exp       tau e^(-tau d) / (1 - e^(-tau r)), less its value at r, over what keeps its integral from 0 to r at 1:
 *               (tau / (1 - e^(-tau r))) (e^(-tau d) - e^(-tau r)) / (1 - r tau e^(-tau r) / (1 - e^(-tau r))) -> 2 (r - d) / r^2
 *   tau         s_s (D(p) + D(q)) / 2; in print the difference
 *   cosine      sum I_g(q) e^(-(1-g) delta) w / sum w, delta the depth of p less that of q: after delta events in the mean the
 *               cosine falls by that (docs/errata.md); in print g^delta, which stands in the denominator too and cancels there
 * The exponentials of all cells are taken relative to the largest: however dense the medium, one of them is 1. Where nothing
 * weighs anything, I is interpolated. `gaussian` is the joint bilateral filter that the paper compares with [Kopf07]. */
#include "method/temporal_photons/tpm_state.h"

void NPH_KERNEL(nph_tpm_upsample)(const void *memory, const void *coarse, int64_t first, int64_t end, void *fine);

enum { NEAR = 5 * 5 * 5 };

typedef struct Around {
    const Real *cell[NEAR];
    Real distance[NEAR], unlike[NEAR], rate[NEAR], least;
    int count;
} Around;

static Real density_at(const RTpmScene *scene, const Real p[3]) {
    return r_tpm_density(&scene->medium, p[0], p[1], p[2]) / scene->density_max;
}

static void look_around(const RTpmScene *scene, const Real *coarse, const Real p[3], Around *out) {
    const RTpmGrid *grid = &scene->coarse;
    int32_t low[3], high[3], at[3];
    Real own = density_at(scene, p), sigma = scene->majorant * scene->medium.albedo[0];
    for (int a = 0; a < 3; a++) {
        int32_t middle = (int32_t)((p[a] - grid->lo[a]) * grid->per_unit[a]);
        middle = middle < grid->n[a] ? middle : grid->n[a] - 1;
        low[a] = middle > scene->reach ? middle - scene->reach : 0;
        high[a] = middle + scene->reach < grid->n[a] ? middle + scene->reach : grid->n[a] - 1;
    }
    out->count = 0;
    out->least = R_HUGE;
    for (at[2] = low[2]; at[2] <= high[2]; at[2]++)
        for (at[1] = low[1]; at[1] <= high[1]; at[1]++)
            for (at[0] = low[0]; at[0] <= high[0]; at[0]++) {
                Real q[3], squared = R(0.0);
                int k = out->count++;
                for (int a = 0; a < 3; a++) {
                    Real off = (p[a] - grid->lo[a]) * grid->per_unit[a] - ((Real)at[a] + R(0.5));
                    q[a] = grid->lo[a] + ((Real)at[a] + R(0.5)) / grid->per_unit[a];
                    squared += off * off * grid->edge[a] * grid->edge[a];
                }
                Real other = density_at(scene, q);
                out->cell[k] = coarse + r_tpm_cell(grid->n, at[0], at[1], at[2]) * NPH_TPM_FIELDS;
                out->distance[k] = r_sqrt(squared);
                out->unlike[k] = r_abs(own - other);
                out->rate[k] = R(0.5) * sigma * (scene->paper ? own - other : own + other);
                out->least = r_min(out->least, out->rate[k] * out->distance[k]);
            }
}

/* f_exp times e^least. x = tau r; below 1e-3 the series: 2 (r - d) / r^2 to a thousandth of a thousandth. */
static Real truncated(Real tau, Real d, Real r, Real least) {
    Real x = tau * r, left = r - d;
    if (!(left > R(0.0))) return R(0.0);
    if (r_abs(x) < R(1e-3)) return R(2.0) * left / (r * r) * r_exp(least);
    Real whole = -r_expm1(-x), tail = -r_expm1(-tau * left); /* 1 - e^(-tau r); 1 - e^(-tau (r - d)) */
    if (x < R(-60.0)) return R(0.0); /* of a difference, in print: all of it lies at r */
    return tau * r_exp(least - tau * d) * tail / (whole - x * r_exp(-x));
}

static Real weight_of(const RTpmScene *scene, const Around *around, int k, Real radius) {
    if (scene->upsampling == NPH_TPM_GAUSSIAN) {
        Real d = around->distance[k] / (scene->spread * radius), u = around->unlike[k] / scene->spread_density;
        return r_exp(R(-0.5) * (d * d + u * u));
    }
    return truncated(around->rate[k], around->distance[k], radius, around->least) * r_max(R(1.0) - around->unlike[k], R(0.0));
}

static Real fall_of(const RTpmScene *scene, Real delta) {
    if (scene->upsampling == NPH_TPM_GAUSSIAN) return R(1.0);
    int hg = scene->medium.phase.kind == NPH_PHASE_HG;
    Real g = hg ? r_abs(scene->medium.phase.g0) : R(0.0), rest = hg ? scene->medium.phase.rest0 : R(1.0);
    Real rate = scene->paper ? -r_log(r_max(g, R(1e-3))) : rest;
    return r_exp(-r_clamp(rate * delta, R(-40.0), R(40.0)));
}

static void interpolate(const RTpmScene *scene, const Real *coarse, const Real p[3], Real out[NPH_TPM_FIELDS]) {
    RTpmEight eight;
    r_tpm_eight(&scene->coarse, p, &eight);
    for (int v = 0; v < NPH_TPM_FIELDS; v++) {
        out[v] = R(0.0);
        for (int k = 0; k < 8; k++) out[v] += eight.share[k] * coarse[eight.at[k] * NPH_TPM_FIELDS + v];
    }
}

static void upsample_cell(const RTpmScene *scene, const Real *coarse, const Real p[3], Real *out) {
    Around around;
    Real plain[NPH_TPM_FIELDS], sum = R(0.0), cosine = R(0.0), bent = R(0.0), radius = R_HUGE;
    interpolate(scene, coarse, p, plain);
    for (int v = 0; v < NPH_TPM_FIELDS; v++) out[v] = plain[v];
    if (scene->upsampling == NPH_TPM_LINEAR) return;
    look_around(scene, coarse, p, &around);
    for (int a = 0; a < 3; a++) radius = r_min(radius, ((Real)scene->reach + R(0.5)) * scene->coarse.edge[a]);
    Real total[NPH_TPM_FIELDS] = {R(0.0)};
    for (int k = 0; k < around.count; k++) {
        const Real *cell = around.cell[k];
        Real weight = weight_of(scene, &around, k, radius), fall = fall_of(scene, plain[NPH_TPM_I_DEPTH] - cell[NPH_TPM_I_DEPTH]);
        sum += weight;
        bent += weight * fall;
        cosine += weight * fall * cell[NPH_TPM_I_G];
        for (int v = 0; v < NPH_TPM_FIELDS; v++) total[v] += weight * cell[v];
    }
    if (!(sum > R(0.0))) return;
    for (int v = 0; v < NPH_TPM_FIELDS; v++) out[v] = total[v] / sum;
    int divide = scene->paper || scene->upsampling == NPH_TPM_GAUSSIAN;
    out[NPH_TPM_I_G] = r_clamp(cosine / (divide ? bent : sum), R(-1.0), R(1.0));
}

void NPH_KERNEL(nph_tpm_upsample)(const void *memory, const void *coarse, int64_t first, int64_t end, void *fine) {
    const RTpmScene *scene = memory;
    const RTpmGrid *grid = &scene->fine;
    for (int64_t row = first; row < end; row++) {
        Real p[3] = {R(0.0), grid->lo[1] + ((Real)(row % grid->n[1]) + R(0.5)) / grid->per_unit[1],
                     grid->lo[2] + ((Real)(row / grid->n[1]) + R(0.5)) / grid->per_unit[2]};
        for (int32_t x = 0; x < grid->n[0]; x++) {
            p[0] = grid->lo[0] + ((Real)x + R(0.5)) / grid->per_unit[0];
            upsample_cell(scene, coarse, p, (Real *)fine + (row * grid->n[0] + x) * NPH_TPM_FIELDS);
        }
    }
}
