/* SPDX-License-Identifier: Apache-2.0
 *
 * See kernel_bvh.h. */
#include "kernel_bvh.h"

#include "core/philox.h"
#include "geometry/lambert_lookup.h"
#include "geometry/surface_lookup.h"

static RRay ray_of(const NphBvhRays *rays, int64_t i) {
    Real in[6];
    for (int k = 0; k < 6; k++) in[k] = ((const Real *)rays->ray[k])[i];
    return r_ray(in, in + 3);
}

void NPH_KERNEL(geometry_brute)(const NphBvh *bvh, const NphBvhRays *rays) {
    RBvh view = r_bvh(bvh);
    for (int64_t i = 0; i < rays->count; i++) {
        RRay ray = ray_of(rays, i);
        Real t_max = ((const Real *)rays->ray[6])[i];
        RHit best = {t_max, {R(0.0), R(0.0)}, -1, -1}, hit;
        for (int32_t s = 0; s < bvh->triangle_count; s++) {
            if (!r_triangle_hit(&ray, r_bvh_corner(&view, s, 0), r_bvh_corner(&view, s, 1), r_bvh_corner(&view, s, 2),
                                t_max, &hit))
                continue;
            hit.number = view.triangles[s].number;
            if (best.number < 0 || hit.t < best.t || (hit.t == best.t && hit.number < best.number)) best = hit;
        }
        rays->number[i] = best.number;
        rays->any[i] = best.number >= 0;
        if (best.number < 0) continue;
        ((Real *)rays->t)[i] = best.t;
        for (int k = 0; k < 2; k++) ((Real *)rays->weight[k])[i] = best.weight[k];
    }
}

/* Uniform over a triangle. */
static void random_weights(NphWords words, Real weight[2]) {
    Real root = r_sqrt(r_uniform(words.w0)), v = r_uniform(words.w1);
    weight[0] = root * (R(1.0) - v);
    weight[1] = root * v;
}

int64_t NPH_KERNEL(geometry_self_hits)(const NphBvh *bvh, uint32_t seed, int64_t count, double grazing, double share) {
    RBvh view = r_bvh(bvh);
    int64_t hits = 0;
    for (int64_t i = 0; i < count; i++) {
        NphWords a = nph_philox(seed, 1, (uint32_t)i, 0, 0, 0), b = nph_philox(seed, 2, (uint32_t)i, 0, 0, 0);
        RHit hit = {R(0.0), {R(0.0), R(0.0)}, 0, (int32_t)(a.w2 % (uint32_t)bvh->triangle_count)}, other;
        Real d[3], o[3], n[3], u = r_uniform(b.w0);
        random_weights(a, hit.weight);
        RSurfacePoint point = r_bvh_point(&view, &hit);
        point.clear *= (Real)share;
        for (int k = 0; k < 3; k++) n[k] = b.w2 & 1 ? point.n[k] : -point.n[k];
        if (grazing > 0.0) u = R(1.0) - (Real)(grazing * grazing) * u;
        r_lambert_sample(n, u < R(1.0) ? u : R(0.0), r_uniform(b.w1), d);
        r_leave(&point, d, o);
        RRay ray = r_ray(o, d);
        hits += r_triangle_hit(&ray, r_bvh_corner(&view, hit.slot, 0), r_bvh_corner(&view, hit.slot, 1),
                               r_bvh_corner(&view, hit.slot, 2), R(1e30), &other);
    }
    return hits;
}

int64_t NPH_KERNEL(geometry_escapes)(const NphBvh *bvh, const double start[3], uint32_t seed, int64_t paths,
                                     int64_t count) {
    RBvh view = r_bvh(bvh);
    int64_t escaped = 0;
    for (int64_t path = 0; path < paths; path++) {
        Real o[3], d[3], n[3] = {R(0.0), R(0.0), R(1.0)};
        for (int k = 0; k < 3; k++) o[k] = (Real)start[k];
        for (int64_t i = 0; i < count; i++) {
            NphWords words = nph_philox(seed, 3, (uint32_t)i, (uint32_t)path, 0, 0);
            RHit hit;
            r_lambert_sample(n, r_uniform(words.w0), r_uniform(words.w1), d);
            RRay ray = r_ray(o, d);
            if (!r_bvh_closest(&view, &ray, R(1e30), &hit)) {
                escaped++;
                break;
            }
            RSurfacePoint point = r_bvh_point(&view, &hit);
            Real side = r_dot(point.n, d) < R(0.0) ? R(1.0) : R(-1.0);
            for (int k = 0; k < 3; k++) n[k] = side * point.n[k];
            r_leave(&point, n, o);
        }
    }
    return escaped;
}

void NPH_KERNEL(geometry_chords)(const NphBvh *bvh, const double *cdf, uint32_t seed, int64_t count, double out[3]) {
    RBvh view = r_bvh(bvh);
    out[0] = out[1] = out[2] = 0.0;
    for (int64_t i = 0; i < count; i++) {
        NphWords a = nph_philox(seed, 4, (uint32_t)i, 0, 0, 0), b = nph_philox(seed, 5, (uint32_t)i, 0, 0, 0);
        double pick = nph_uniform(a.w2);
        int32_t number = 0;
        Real d[3], o[3], n[3];
        while (cdf[number] <= pick) number++;
        RHit hit = {R(0.0), {R(0.0), R(0.0)}, number, 0};
        while (view.triangles[hit.slot].number != number) hit.slot++;
        random_weights(a, hit.weight);
        RSurfacePoint point = r_bvh_point(&view, &hit);
        for (int k = 0; k < 3; k++) n[k] = -point.n[k];
        r_lambert_sample(n, r_uniform(b.w0), r_uniform(b.w1), d);
        r_leave(&point, d, o);
        RRay ray = r_ray(o, d);
        if (!r_bvh_closest(&view, &ray, R(1e30), &hit)) continue;
        out[0] += 1.0;
        out[1] += (double)hit.t;
        out[2] += (double)hit.t * (double)hit.t;
    }
}

void NPH_KERNEL(geometry_lambert)(const double n_[3], uint32_t seed, int64_t count, double *direction,
                                  double *density) {
    Real n[3] = {(Real)n_[0], (Real)n_[1], (Real)n_[2]};
    for (int64_t i = 0; i < count; i++) {
        NphWords words = nph_philox(seed, 6, (uint32_t)i, 0, 0, 0);
        Real d[3];
        r_lambert_sample(n, r_uniform(words.w0), r_uniform(words.w1), d);
        for (int k = 0; k < 3; k++) direction[3 * i + k] = (double)d[k];
        density[i] = (double)r_lambert_density(r_dot(n, d));
    }
}

static RPlane plane_of(const double plane[6]) {
    const double origin[3] = {0, 0, 0};
    return r_plane_through(plane, plane + 3, origin);
}

double NPH_KERNEL(geometry_plane)(const double plane_[6], const double ray[6], double t_max) {
    RPlane plane = plane_of(plane_);
    Real in[6], t;
    for (int k = 0; k < 6; k++) in[k] = (Real)ray[k];
    return r_plane_hit(&plane, in, in + 3, (Real)t_max, &t) ? (double)t : -1.0;
}

int64_t NPH_KERNEL(geometry_plane_self_hits)(const double plane_[6], const double ray[6], uint32_t seed,
                                             int64_t count) {
    RPlane plane = plane_of(plane_);
    Real in[6], t;
    int64_t hits = 0;
    for (int k = 0; k < 6; k++) in[k] = (Real)ray[k];
    if (!r_plane_hit(&plane, in, in + 3, R(1e30), &t)) return -1;
    RSurfacePoint point = r_plane_point(&plane, in, in + 3, t);
    for (int64_t i = 0; i < count; i++) {
        NphWords words = nph_philox(seed, 7, (uint32_t)i, 0, 0, 0);
        Real d[3], o[3], n[3];
        for (int k = 0; k < 3; k++) n[k] = words.w2 & 1 ? point.n[k] : -point.n[k];
        r_lambert_sample(n, r_uniform(words.w0), r_uniform(words.w1), d);
        r_leave(&point, d, o);
        hits += r_plane_hit(&plane, o, d, R(1e30), &t);
    }
    return hits;
}

void NPH_KERNEL(geometry_point)(const NphBvh *bvh, int32_t slot, const double weight[2], double out[7]) {
    RBvh view = r_bvh(bvh);
    RHit hit = {R(0.0), {(Real)weight[0], (Real)weight[1]}, 0, slot};
    RSurfacePoint point = r_bvh_point(&view, &hit);
    for (int k = 0; k < 3; k++) {
        out[k] = (double)point.p[k];
        out[3 + k] = (double)point.n[k];
    }
    out[6] = (double)point.clear;
}
