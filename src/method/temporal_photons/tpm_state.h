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

/* Eight cells around a position, and how much of each: linear between their middles, constant beyond the outermost. */
typedef struct RTpmEight {
    int64_t at[8];
    Real share[8];
} RTpmEight;

static inline void r_tpm_eight(const RTpmGrid *grid, const Real p[3], RTpmEight *out) {
    int32_t low[3], high[3];
    Real part[3];
    for (int a = 0; a < 3; a++) {
        Real u = (p[a] - grid->lo[a]) * grid->per_unit[a] - R(0.5), last = (Real)(grid->n[a] - 1);
        u = r_clamp(u, R(0.0), last);
        low[a] = (int32_t)u;
        high[a] = low[a] + 1 < grid->n[a] ? low[a] + 1 : low[a];
        part[a] = u - (Real)low[a];
    }
    for (int k = 0; k < 8; k++) {
        int x = k & 1, y = k >> 1 & 1, z = k >> 2;
        out->at[k] = r_tpm_cell(grid->n, x ? high[0] : low[0], y ? high[1] : low[1], z ? high[2] : low[2]);
        out->share[k] = (x ? part[0] : R(1.0) - part[0]) * (y ? part[1] : R(1.0) - part[1]) * (z ? part[2] : R(1.0) - part[2]);
    }
}

#endif
