/* SPDX-License-Identifier: Apache-2.0
 *
 * What the kernels see, in the number type of the build. Positions of photons and of the march are in the medium's space, in
 * which the box [lo, hi] is cut into the cells of I and of J. */
#ifndef NPH_METHOD_TPM_STATE_H
#define NPH_METHOD_TPM_STATE_H

#include "method/temporal_photons/tpm.h"
#include "transport/entry_lookup.h"

/* A grid of cells that fills the medium's box. */
typedef struct RTpmGrid {
    int32_t n[3];
    Real lo[3], per_unit[3]; /* cells per unit of the medium's space */
    Real edge[3];            /* m */
} RTpmGrid;

typedef struct RTpmScene {
    RScene local;
    RMedium medium;
    int traced, kinds, dominant, similarity, switch_order, shared, paper;
    double choose[NPH_MAX_LIGHTS + 1]; /* cumulated probability that a photon of the sky comes from a light */
    RDisc from[NPH_MAX_LIGHTS];
    double unit;             /* W: of flux */
    double scale;            /* units of fixed point per unit of flux */
    Real towards[NPH_TPM_KINDS][3]; /* the directions in which most of the flux travels, scene-local */
    Real density_max, majorant, inverse_majorant[2], gain[2], albedo[2][3], survival[2]; /* before and after the switch */
    Real threshold;
    int orders;              /* of scattering that are deposited: 0 all; 1, 2: that one, the march's being one of them; 3: later ones */
    RTpmGrid coarse, fine;
    double fluence_per_unit; /* of I: W/m2 per unit of flux of a cell's sum */
    int upsampling, reach;
    Real spread, spread_density;
    Real step, exit, noise;  /* m, 1, units of the medium's space */
    int octaves, half, small_origin[2], small[2];
    int impostor;            /* pictures show the cloud alone; what is behind it joins when they are enlarged */
    double centre[3];        /* of the medium's box, world */
    float field[];           /* vectors of noise: [z][y][x][3], where there is noise */
} RTpmScene;

enum { R_TPM_NOISE = 32 };

static inline int64_t r_tpm_cell(const int32_t n[3], int32_t x, int32_t y, int32_t z) {
    return ((int64_t)z * n[1] + y) * n[0] + x;
}

static inline Real r_tpm_density(const RMedium *medium, Real u, Real v, Real w) {
    return medium->shape == NPH_SHAPE_GRID ? r_grid_value(&medium->grid, u, v, w) : R(1.0);
}

/* Along one axis the two cells around a position, and how much of the upper: linear between their middles, constant beyond the outermost. */
typedef struct RTpmAxis {
    int32_t low, more; /* the lower cell; 1 where there is one above */
    Real part;
} RTpmAxis;

R_INLINE RTpmAxis r_tpm_axis(Real p, Real lo, Real per_unit, int32_t n) {
    RTpmAxis axis;
    Real u = r_min(r_max((p - lo) * per_unit - R(0.5), R(0.0)), (Real)(n - 1));
    axis.low = (int32_t)u;
    axis.more = axis.low + 1 < n ? 1 : 0;
    axis.part = u - (Real)axis.low;
    return axis;
}

/* The eight cells around a position, and how much of each. */
typedef struct RTpmEight {
    int64_t at[8];
    Real share[8];
} RTpmEight;

static inline void r_tpm_eight(const RTpmGrid *grid, const Real p[3], RTpmEight *out) {
    RTpmAxis axis[3];
    for (int a = 0; a < 3; a++) axis[a] = r_tpm_axis(p[a], grid->lo[a], grid->per_unit[a], grid->n[a]);
    for (int k = 0; k < 8; k++) {
        int up[3] = {k & 1, k >> 1 & 1, k >> 2};
        int32_t at[3];
        Real share[3];
        for (int a = 0; a < 3; a++) {
            at[a] = axis[a].low + (up[a] ? axis[a].more : 0);
            share[a] = up[a] ? axis[a].part : R(1.0) - axis[a].part;
        }
        out->at[k] = r_tpm_cell(grid->n, at[0], at[1], at[2]);
        out->share[k] = share[0] * share[1] * share[2];
    }
}

#endif
