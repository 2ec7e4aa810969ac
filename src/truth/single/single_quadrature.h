/* SPDX-License-Identifier: Apache-2.0
 *
 * What is scattered once, towards the sensor, along a stretch of a camera ray, of the light of one beam:
 *     integral of  sum over media of rho_m(t) s_m,c albedo_m,c p_m(t)  e^-tau_c(t)  T_c(t) V(t) [/ r(t)^2]  dt
 * per unit value of the light. rho, tau: density and optical depth along the ray (the profile); T, V: transmittance
 * and visibility from the point towards the light. The weight rho e^-tau [/ r^2] is integrated by Gauss points
 * inside every piece of the profile; what costs an optical depth each, T V p, is interpolated by polynomials on
 * panels that are halved until the estimate of the error is below the tolerance: a product rule. Panels end where
 * shadows of surfaces do. A point light's panels are equal in the angle at which it is seen, t = t_c + D tan v, in
 * which 1/r^2 dt = dv / D [Kulla12]. */
#ifndef NPH_TRUTH_SINGLE_QUADRATURE_H
#define NPH_TRUTH_SINGLE_QUADRATURE_H

#include "truth/single/single_profile.h"

/* Light as one sample of a ray meets it: from a direction at infinity, or from a point. */
typedef struct NphBeam {
    int light, point;
    double d[3];                 /* towards it, when it is at infinity */
    double position[3];          /* of a point */
    double value[3];             /* irradiance, radiance over density of the direction, intensity */
    double phase[NPH_MAX_MEDIA]; /* of a light at infinity: towards the sensor, in each medium */
} NphBeam;

enum { NPH_NODES = 5 };

/* A quarter of the panel lies between nodes. */
typedef struct NphPanel {
    double v0, v1;
    double T[NPH_NODES][3];
    int lit[NPH_NODES]; /* no surface on the way to the light */
    double value[3], error[3];
    double key; /* what halving it may gain */
} NphPanel;

struct NphSingleScratch {
    NphProfile profile;
    NphSingleTally tally;
    NphPanel panels[NPH_SINGLE_PANELS_MAX];
    int32_t heap[NPH_SINGLE_PANELS_MAX]; /* the panel with the largest key first */
};

/* single_light.c: the beam of light l for the media on a ray, or for a surface with this normal. */
void nph_single_beam(const NphSingleScene *scene, const RCameraRay *ray, const NphSingleAsk *ask, int l,
                     const double *normal, NphBeam *beam);

/* Adds the integral over the scratch's profile to result; error: what remains of it by estimate, added too. */
void nph_single_integrate(const NphSingleScene *scene, NphSingleScratch *scratch, const double p[3], const double d[3],
                          const NphBeam *beam, double result[3], double error[3]);

/* Transmittance of all media from x along d, up to limit. */
void nph_single_transmittance(const RScene *scene, const double x[3], const double d[3], double limit,
                              NphWalked *walked, double T[3]);

#endif
