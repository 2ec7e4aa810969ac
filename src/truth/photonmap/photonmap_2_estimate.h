/* SPDX-License-Identifier: Apache-2.0
 *
 * The radiance estimate [Jensen98]. Per volume and time, collisions of photons of direction w' happen at the rate
 * sigma_t L(x, w'), and the part sigma_s L of them is scattered. A photon stores that scattered power, so the light that
 * is scattered at x into w needs no coefficient:
 *   sigma_s(x) int p(w' . w) L(x, w') dw'  =  d/dV sum p(w'_i . w) dPhi_i  ~  sum over the nearest of p dPhi / (4/3 pi r^3)
 *
 * Which are the nearest: with n photons within the largest radius R, r = R and all of them when n < k; else r is the
 * distance of the k-th, which only sets the volume: the k - 1 nearer ones are summed. Then the mean is exact where the
 * density of photons is uniform: with q = density times volume of R, n has Poisson's distribution, the volume of the k-th
 * the density v^(k-1) e^-v / (k-1)!, and
 *   sum_{n<k} n q^n e^-q / n! / q  +  int_0^q (k-1) v^(k-2) e^-v / (k-1)! dv  =  P(N <= k-2) + P(N >= k-1)  =  1.
 * In print the k-th is summed too, which is too bright by 1 / (k - 1) in the mean: `printed`.
 *
 * Photons tell of the radiance, power over s(x_i), s being the extinction at theirs, and the medium at x scatters s(x) of
 * it: each counts s(x) / s(x_i) of its power, at most 10. Else the light of a dense core is spread over the thin rim
 * before it, where little would have scattered it. With r the factor goes to 1; it is 1 throughout an even medium. In
 * print it is 1 everywhere: sigma is taken to be the same in the sphere.
 *
 * r is at least R / 10^6, for photons that stand at one place. */
#ifndef NPH_TRUTH_PHOTONMAP_ESTIMATE_H
#define NPH_TRUTH_PHOTONMAP_ESTIMATE_H

#include "transport/lights_lookup.h"
#include "truth/photonmap/photonmap_state.h"

/* Light scattered at a point towards the sensor, per metre [W/m3/sr]; of it, luminance times order of scattering. */
typedef struct RScattered {
    Real radiance[3], order;
    int found;
    Real radius;
} RScattered;

/* d: the ray's direction, away from the sensor; extinction: r_extinction_at of p. */
static inline RScattered r_estimate(const RPhotonScene *scene, const NphPhotonMap *map, const Real p[3],
                                    const Real d[3], Real extinction) {
    RKdFound found[NPH_PHOTONMAP_NEAREST_MAX];
    const RKdNode *nodes = map->tree.nodes;
    const RPhoton *photons = map->photons;
    Real within = scene->reach * scene->reach, least = within * R(1e-12);
    int count = r_kd_nearest(nodes, map->tree.count, p, within, scene->nearest, found),
        full = count > 0 && count == scene->nearest;
    Real squared = full ? r_max(found[0].squared, least) : within;
    RScattered out = {{R(0.0), R(0.0), R(0.0)}, R(0.0), count, r_sqrt(squared)};
    for (int i = full && !scene->printed; i < count; i++) {
        const RPhoton *photon = &photons[r_kd_number(&nodes[found[i].node])];
        Real back[3] = {-photon->d[0], -photon->d[1], -photon->d[2]}, light[3];
        Real density = r_phase_at(&scene->local.media[photon->medium].phase, r_angle_between(d, back));
        if (!scene->printed)
            density *= extinction < R(10.0) * photon->extinction ? extinction / photon->extinction : R(10.0);
        for (int c = 0; c < 3; c++) {
            light[c] = density * photon->power[c];
            out.radiance[c] += light[c];
        }
        out.order += (Real)photon->order * r_luminance(light);
    }
    Real scale = count > 0 ? R(0.23873241463784300) / (squared * out.radius) : R(0.0); /* 3 / 4 pi */
    for (int c = 0; c < 3; c++) out.radiance[c] *= scale;
    out.order *= scale;
    return out;
}

#endif
