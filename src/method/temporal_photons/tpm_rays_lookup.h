/* SPDX-License-Identifier: Apache-2.0
 *
 * How rays of the march begin: pixels of a row of the small picture, and what the march wants to know of their rays [Elek12 sec. 4.4]. */
#ifndef NPH_METHOD_TPM_RAYS_LOOKUP_H
#define NPH_METHOD_TPM_RAYS_LOOKUP_H

#include "method/temporal_photons/tpm_state.h"

enum { LANES = 64 };

/* Rays of neighbouring pixels that begin next: in the medium's space, and what is behind the medium. */
typedef struct Rays {
    Real o[3][LANES], d[3][LANES], near[LANES], far[LANES], jump[LANES];
    Real start[LANES], cosine[NPH_TPM_KINDS][LANES], behind[3][LANES];
    Real way[3][LANES], pdf[LANES]; /* scene-local */
    int32_t inside[LANES], seen[LANES];
    int next, count;
} Rays;

/* What is the same for the rays of a row of pixels. */
typedef struct Row {
    int x, y, half, width, height, medium;
    uint32_t sample, seed;
    double perspective;
    Real step, towards[NPH_TPM_KINDS][3];
} Row;

/* The pixel of the sensor that a pixel of the small picture looks through; of two by two it is drawn with the sample's own words. */
R_INLINE void pixel_of(const Row *row, int i, int32_t *x, int32_t *y) {
    NphWords words = nph_philox(row->seed, (uint32_t)NPH_RNG_TPM_PIXEL << 24, (uint32_t)(row->x + i), (uint32_t)row->y, row->sample, 0);
    int32_t u = 2 * (row->x + i) + (int32_t)(words.w0 >> 31), v = 2 * row->y + (int32_t)(words.w1 >> 31);
    u = u < row->width ? u : row->width - 1;
    v = v < row->height ? v : row->height - 1;
    *x = row->half ? u : row->x + i;
    *y = row->half ? v : row->y;
}

R_INLINE void put_ray(Rays *restrict rays, int i, const Row *row, const RMedium *medium, const RCameraRay *ray) {
    RSpan span = r_clip(medium, ray->p, ray->d, R_HUGE);
    for (int a = 0; a < 3; a++) {
        rays->o[a][i] = span.o[a];
        rays->d[a][i] = span.d[a];
        rays->way[a][i] = ray->d[a];
    }
    for (int k = 0; k < NPH_TPM_KINDS; k++)
        rays->cosine[k][i] = -(ray->d[0] * row->towards[k][0] + ray->d[1] * row->towards[k][1] + ray->d[2] * row->towards[k][2]);
    Real speed = r_max(r_abs(span.d[0]), r_max(r_abs(span.d[1]), r_abs(span.d[2])));
    rays->jump[i] = R(3.9996) / r_max(speed * row->step, R(1e-12));
    rays->near[i] = span.near;
    rays->far[i] = span.far;
    rays->start[i] = ray->start;
    rays->pdf[i] = ray->pdf;
    rays->inside[i] = span.inside & row->medium;
    rays->seen[i] = ray->weight > R(0.0) ? 1 : 0;
}

/* The same from everywhere: then one look is enough. */
static inline int even_behind(const RScene *local) {
    int even = 1;
    for (int l = 0; l < local->light_count; l++) {
        const RLight *light = &local->lights[l];
        even &= !r_light_is_met(light) || (light->kind == NPH_LIGHT_CONSTANT && light->hemisphere == 0);
    }
    return even;
}

#endif
