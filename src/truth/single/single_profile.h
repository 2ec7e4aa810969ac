/* SPDX-License-Identifier: Apache-2.0
 *
 * What a camera ray runs through: for every medium the pieces (voxels; a whole box or layer) in which its density is
 * one polynomial of third degree, so that density and optical depth at any point of the ray cost a few
 * multiplications. A stretch of the ray is described at once, up to NPH_SINGLE_PIECES of each medium. */
#ifndef NPH_TRUTH_SINGLE_PROFILE_H
#define NPH_TRUTH_SINGLE_PROFILE_H

#include "truth/single/single.h"
#include "truth/single/single_walk.h"

/* density = c0 + c1 x + c2 x^2 + c3 x^3 at x = (t - t0) / (t1 - t0), or c0 exp(-c1 x - c2 x^2) in air; depth: its integral from the
 * ray's start to t0. */
typedef struct NphPiece {
    double t0, t1, depth, c[4];
    int air;
} NphPiece;

/* Fields: the media of the scene, and behind them what emits, which has no extinction. */
typedef struct NphProfile {
    const NphSingleScene *scene;
    double begin, end; /* metres from the ray's start */
    int opaque;        /* nothing behind the end can be seen */
    int count[NPH_SINGLE_FIELDS];
    double total[NPH_SINGLE_FIELDS]; /* depth at the end */
    NphPiece *pieces[NPH_SINGLE_FIELDS];
} NphProfile;

/* The stretch of the ray p + t d that begins where the last one ended (a first one at 0, with total 0), and ends at
 * `limit` at the latest. */
void nph_profile_build(NphProfile *profile, const NphSingleScene *scene, const double p[3], const double d[3],
                       double limit, NphWalked *walked);

/* Between two ends of pieces: which one is under way in every medium. */
typedef struct NphPlace {
    int at[NPH_SINGLE_FIELDS];
    int active; /* media with a density there */
} NphPlace;

/* Moves the place to t and returns where the pieces that begin or go on there end, `limit` at most. Places move
 * forward. */
double nph_profile_move(const NphProfile *profile, NphPlace *place, double t, double limit);

/* The place for any t. */
void nph_profile_seek(const NphProfile *profile, double t, NphPlace *place);

/* Densities and optical depths (of each transport channel) at t, between the place's ends. */
void nph_profile_at(const NphProfile *profile, const NphPlace *place, double t, double density[NPH_SINGLE_FIELDS],
                    double tau[3]);

/* The depth of a medium behind which the optical depth of every channel is above tau; 1e300 where a channel passes. */
double nph_single_opaque(const RScene *scene, const RMedium *medium, double tau);

/* From t on, not beyond e, as far as five Gauss points are enough for exp(-tau): optical depth 1 in the thickest
 * channel. */
double nph_profile_thin(const NphProfile *profile, const NphPlace *place, double t, double e);

/* Gauss and Legendre's points and weights on [0, 1]: exact for polynomials up to the ninth degree [Golub69]. */
enum { NPH_GAUSS = 5 };
extern const double nph_gauss_point[NPH_GAUSS], nph_gauss_weight[NPH_GAUSS];

#endif
