/* SPDX-License-Identifier: Apache-2.0
 *
 * Rays in a hexagonal prism (crystal.h). The crystal stands along z and the light comes from a random direction, which is the same as
 * a random crystal. A ray splits at every facet: what leaves is counted, what stays inside goes on. The field is a complex vector
 * across the ray; at a facet it is taken apart along s = d x n and p = s x d [Bohren83 sec. 2.7]. */
#include "optics/crystal.h"

#include "core/fmath.h"
#include "core/memory.h"
#include "core/message.h"
#include "core/philox.h"
#include "core/pool.h"
#include "core/reduce.h"

enum { FACETS = 8, MOST_FACETS = 300, STAGE = 0x43525953 /* the second word of the key */ };
enum { STRAIGHT = NPH_CRYSTAL_BINS, ABSORBED, LOST, MOMENT, HITS, SLOTS };

static const double PI = 3.14159265358979323846, LEAST_POWER = 1e-7, STRAIGHT_LEAST = 1e-12;

typedef struct Facet {
    double normal[3], offset; /* outwards */
} Facet;

typedef struct Tracing {
    const NphCrystal *crystal;
    Facet facet[FACETS];
    double reach;       /* radius of the sphere around it */
    double per_um;      /* absorption along a path inside */
    double *slots;      /* [blocks][SLOTS] */
    int64_t begin;      /* the first block that is run */
} Tracing;

typedef struct Ray {
    double at[3], along[3];
    double re[3], im[3]; /* the field */
    uint32_t number[2], drawn;
    uint32_t seed;
} Ray;

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void cross(const double a[3], const double b[3], double out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static void scale_to_unit(double v[3]) {
    double scale = 1.0 / nph_sqrt(dot(v, v));
    for (int i = 0; i < 3; i++) v[i] *= scale;
}

static NphWords draw(Ray *ray) { return nph_philox(ray->seed, STAGE, ray->drawn++, 0, ray->number[0], ray->number[1]); }

/* Two unit vectors across d. */
static void frame(const double d[3], double a[3], double b[3]) {
    double axis[3] = {0.0, 0.0, 0.0};
    axis[nph_abs(d[0]) < 0.6 ? 0 : 1] = 1.0;
    cross(d, axis, a);
    scale_to_unit(a);
    cross(d, a, b);
}

static void place_facets(Tracing *work) {
    double inner = work->crystal->edge_um * nph_sqrt(0.75), half = 0.5 * work->crystal->length_um;
    for (int i = 0; i < 6; i++) {
        double *n = work->facet[i].normal;
        nph_sincos2pi((double)i / 6.0, &n[1], &n[0]);
        n[2] = 0.0;
        work->facet[i].offset = inner;
    }
    for (int i = 6; i < FACETS; i++) work->facet[i] = (Facet){{0.0, 0.0, i == 6 ? 1.0 : -1.0}, half};
    work->reach = nph_sqrt(work->crystal->edge_um * work->crystal->edge_um + half * half);
    work->per_um = 4.0 * PI * work->crystal->index[1] / work->crystal->wavelength_um;
}

/* From outside: the facet it enters through, or -1. */
static int enter(const Tracing *work, const Ray *ray, double *distance) {
    double in = -nph_infinity(), out = nph_infinity();
    int facet = -1;
    for (int i = 0; i < FACETS; i++) {
        double towards = dot(ray->along, work->facet[i].normal), away = work->facet[i].offset - dot(ray->at, work->facet[i].normal);
        if (towards == 0.0) {
            if (away < 0.0) return -1;
            continue;
        }
        double t = away / towards;
        if (towards > 0.0) out = t < out ? t : out;
        else if (t > in) {
            in = t;
            facet = i;
        }
    }
    *distance = in;
    return in < out ? facet : -1;
}

/* From inside: the facet ahead. */
static int leave(const Tracing *work, const Ray *ray, double *distance) {
    double nearest = nph_infinity();
    int facet = -1;
    for (int i = 0; i < FACETS; i++) {
        double towards = dot(ray->along, work->facet[i].normal);
        if (!(towards > 0.0)) continue;
        double t = (work->facet[i].offset - dot(ray->at, work->facet[i].normal)) / towards;
        if (t >= nearest) continue;
        nearest = t > 0.0 ? t : 0.0;
        facet = i;
    }
    *distance = nearest;
    return facet;
}

/* The facet's normal as this ray finds it, pointing to where the ray comes from; one that the ray cannot meet is drawn again. */
static void normal_met(const Tracing *work, Ray *ray, const double facet[3], int inside, double normal[3]) {
    double side = inside ? -1.0 : 1.0, straight[3], a[3], b[3];
    for (int i = 0; i < 3; i++) straight[i] = normal[i] = side * facet[i];
    if (!(work->crystal->tilt > 0.0)) return;
    frame(straight, a, b);
    for (int tries = 0; tries < 32; tries++) {
        NphWords w = draw(ray);
        double sine, cosine, across, along;
        nph_sincos2pi(0.25 * work->crystal->tilt * nph_uniform(w.w0), &sine, &cosine);
        nph_sincos2pi(nph_uniform(w.w1), &across, &along);
        for (int i = 0; i < 3; i++) normal[i] = cosine * straight[i] + sine * (along * a[i] + across * b[i]);
        if (dot(ray->along, normal) < -1e-6) return;
    }
    for (int i = 0; i < 3; i++) normal[i] = straight[i];
}

typedef struct Split {
    double reflected[3], refracted[3], s[3];
    double rs[2], rp[2]; /* complex amplitudes of reflection */
    int total;
} Split;

/* Fresnel's formulas from a medium to one of index m relative to it; the real part alone bends and reflects: k of ice is 1e-8. */
static void split_at(const double along[3], const double normal[3], double m, Split *split) {
    double cosine = -dot(along, normal), sine2 = (1.0 - cosine * cosine) / (m * m), root = nph_sqrt(nph_abs(1.0 - sine2));
    double unit[3];
    split->total = sine2 >= 1.0;
    cross(along, normal, split->s);
    double length = dot(split->s, split->s);
    if (length > 1e-24) scale_to_unit(split->s);
    else frame(along, split->s, unit);
    for (int i = 0; i < 3; i++) {
        split->reflected[i] = along[i] + 2.0 * cosine * normal[i];
        split->refracted[i] = along[i] / m + (cosine / m - root) * normal[i];
    }
    scale_to_unit(split->reflected);
    if (!split->total) {
        scale_to_unit(split->refracted);
        split->rs[0] = (cosine - m * root) / (cosine + m * root);
        split->rp[0] = (m * cosine - root) / (m * cosine + root);
        split->rs[1] = split->rp[1] = 0.0;
        return;
    }
    /* (a - i b) / (a + i b), of modulus 1: the refracted cosine is i root */
    double b = m * root, size = cosine * cosine + b * b, a = m * cosine, size_p = a * a + root * root;
    split->rs[0] = (cosine * cosine - b * b) / size;
    split->rs[1] = -2.0 * cosine * b / size;
    split->rp[0] = (a * a - root * root) / size_p;
    split->rp[1] = -2.0 * a * root / size_p;
}

/* The field, turned into the frame of a new direction with an amplitude for each part. */
static void turn_field(Ray *ray, const Split *split, const double along[3], const double as[2], const double ap[2]) {
    double p[3], to[3];
    cross(split->s, ray->along, p);
    cross(split->s, along, to);
    double s_re = dot(ray->re, split->s), s_im = dot(ray->im, split->s), p_re = dot(ray->re, p), p_im = dot(ray->im, p);
    for (int i = 0; i < 3; i++) {
        ray->re[i] = (as[0] * s_re - as[1] * s_im) * split->s[i] + (ap[0] * p_re - ap[1] * p_im) * to[i];
        ray->im[i] = (as[0] * s_im + as[1] * s_re) * split->s[i] + (ap[0] * p_im + ap[1] * p_re) * to[i];
    }
    for (int i = 0; i < 3; i++) ray->along[i] = along[i];
}

static double power_of(const Ray *ray) { return dot(ray->re, ray->re) + dot(ray->im, ray->im); }

/* What of the field is refracted: 1 - |r|^2 of each part. */
static double power_refracted(const Ray *ray, const Split *split) {
    double p[3];
    if (split->total) return 0.0;
    cross(split->s, ray->along, p);
    double s_re = dot(ray->re, split->s), s_im = dot(ray->im, split->s), p_re = dot(ray->re, p), p_im = dot(ray->im, p);
    return (1.0 - split->rs[0] * split->rs[0]) * (s_re * s_re + s_im * s_im) + (1.0 - split->rp[0] * split->rp[0]) * (p_re * p_re + p_im * p_im);
}

static void count(const double first[3], const double along[3], double power, double *slots) {
    double off[3], away, cosine = dot(first, along);
    for (int i = 0; i < 3; i++) off[i] = along[i] - first[i];
    away = dot(off, off);
    cosine = cosine < -1.0 ? -1.0 : cosine > 1.0 ? 1.0 : cosine;
    slots[MOMENT] += power * cosine;
    if (away < STRAIGHT_LEAST) {
        slots[STRAIGHT] += power;
        return;
    }
    int bin = (int)(nph_acos(cosine) * ((double)NPH_CRYSTAL_BINS / PI));
    slots[bin < NPH_CRYSTAL_BINS ? bin : NPH_CRYSTAL_BINS - 1] += power;
}

/* Where the crystal stands in the way: reflects outside and returns 1 with the ray inside. A rough facet may send either part to the
 * wrong side of the facet; then the straight normal is taken. */
static void split_facet(const Tracing *work, Ray *ray, const double facet[3], int inside, Split *split) {
    double normal[3], m = inside ? 1.0 / work->crystal->index[0] : work->crystal->index[0], out = inside ? -1.0 : 1.0;
    normal_met(work, ray, facet, inside, normal);
    split_at(ray->along, normal, m, split);
    int wrong = out * dot(split->reflected, facet) <= 0.0 || (!split->total && out * dot(split->refracted, facet) >= 0.0);
    if (!wrong) return;
    for (int i = 0; i < 3; i++) normal[i] = out * facet[i];
    split_at(ray->along, normal, m, split);
}

static void move(Ray *ray, double distance) {
    for (int i = 0; i < 3; i++) ray->at[i] += distance * ray->along[i];
}

static void trace_inside(const Tracing *work, Ray *ray, const double first[3], double *slots) {
    for (int met = 0; met < MOST_FACETS; met++) {
        double distance, power = power_of(ray);
        Split split;
        if (power < LEAST_POWER) break;
        int facet = leave(work, ray, &distance);
        if (facet < 0 || distance > 4.0 * work->reach) break;
        move(ray, distance);
        double kept = nph_exp(-work->per_um * distance), root = nph_sqrt(kept);
        slots[ABSORBED] += power * (1.0 - kept);
        for (int i = 0; i < 3; i++) {
            ray->re[i] *= root;
            ray->im[i] *= root;
        }
        split_facet(work, ray, work->facet[facet].normal, 1, &split);
        double leaves = power_refracted(ray, &split);
        if (leaves > 0.0) count(first, split.refracted, leaves, slots);
        turn_field(ray, &split, split.reflected, split.rs, split.rp);
    }
    slots[LOST] += power_of(ray);
}

/* A ray from a random direction, at a random place of the disc that covers the sphere around the crystal. */
static void begin(const Tracing *work, Ray *ray) {
    double a[3], b[3], sine, cosine;
    NphWords w = draw(ray), v = draw(ray);
    double z = 1.0 - 2.0 * nph_uniform(w.w0), across = nph_sqrt(1.0 - z * z), r = work->reach * nph_sqrt(nph_uniform(w.w2));
    nph_sincos2pi(nph_uniform(w.w1), &sine, &cosine);
    ray->along[0] = across * cosine;
    ray->along[1] = across * sine;
    ray->along[2] = z;
    frame(ray->along, a, b);
    nph_sincos2pi(nph_uniform(w.w3), &sine, &cosine);
    for (int i = 0; i < 3; i++) ray->at[i] = r * (cosine * a[i] + sine * b[i]) - 2.0 * work->reach * ray->along[i];
    nph_sincos2pi(nph_uniform(v.w0), &sine, &cosine);
    for (int i = 0; i < 3; i++) {
        ray->re[i] = cosine * a[i] + sine * b[i];
        ray->im[i] = 0.0;
    }
}

static void trace_ray(const Tracing *work, int64_t number, double *slots) {
    Ray ray = {.number = {(uint32_t)number, (uint32_t)((uint64_t)number >> 32)}, .seed = work->crystal->seed};
    double distance, first[3];
    Split split;
    begin(work, &ray);
    int facet = enter(work, &ray, &distance);
    if (facet < 0) return;
    slots[HITS] += 1.0;
    for (int i = 0; i < 3; i++) first[i] = ray.along[i];
    move(&ray, distance);
    split_facet(work, &ray, work->facet[facet].normal, 0, &split);
    double enters = power_refracted(&ray, &split);
    count(first, split.reflected, 1.0 - enters, slots);
    double as[2] = {nph_sqrt(1.0 - split.rs[0] * split.rs[0]), 0.0}, ap[2] = {nph_sqrt(1.0 - split.rp[0] * split.rp[0]), 0.0};
    turn_field(&ray, &split, split.refracted, as, ap);
    trace_inside(work, &ray, first, slots);
}

static NphStatus trace_block(void *data, int64_t number, int worker) {
    (void)worker;
    const Tracing *work = data;
    int64_t block = work->begin + number;
    for (int64_t i = 0; i < NPH_CRYSTAL_BLOCK; i++) trace_ray(work, block * NPH_CRYSTAL_BLOCK + i, work->slots + block * SLOTS);
    return NPH_OK;
}

static NphStatus trace_blocks(NphContext *context, Tracing *work, int64_t blocks) {
    int64_t slice = (blocks + 63) / 64;
    double start = nph_seconds();
    for (; work->begin < blocks; work->begin += slice) {
        double done = (double)work->begin, elapsed = nph_seconds() - start;
        nph_progress(context, "tracing rays in crystals", done, (double)blocks, done > 0.0 ? elapsed * ((double)blocks - done) / done : -1.0);
        NPH_TRY(nph_pool_run(context, work->begin + slice < blocks ? slice : blocks - work->begin, trace_block, work, NULL));
    }
    nph_progress(context, "tracing rays in crystals", (double)blocks, (double)blocks, 0.0);
    return NPH_OK;
}

/* Standard error of a ratio of two sums over blocks. */
static double ratio_error(const double *above, const double *below, int64_t blocks, double ratio) {
    NphSum square = {0.0, 0.0}, whole = {0.0, 0.0};
    for (int64_t i = 0; i < blocks; i++) {
        double rest = above[i * SLOTS] - ratio * below[i * SLOTS];
        nph_sum_add(&square, rest * rest);
        nph_sum_add(&whole, below[i * SLOTS]);
    }
    double n = (double)blocks;
    return blocks > 1 ? nph_sqrt(nph_sum_value(square) * n / (n - 1.0)) / nph_sum_value(whole) : nph_infinity();
}

static void gather(const Tracing *work, int64_t blocks, NphCrystalRays *rays) {
    double sum[SLOTS], disc = PI * work->reach * work->reach, part;
    for (int k = 0; k < SLOTS; k++) sum[k] = nph_tree_sum(work->slots + k, blocks, SLOTS);
    double hits = sum[HITS], left = hits - sum[ABSORBED] - sum[LOST];
    *rays = (NphCrystalRays){.rays = blocks * NPH_CRYSTAL_BLOCK, .hits = (int64_t)hits};
    for (int k = 0; k < NPH_CRYSTAL_BINS; k++) rays->bin[k] = sum[k] / hits;
    rays->straight = sum[STRAIGHT] / hits;
    rays->absorbed = sum[ABSORBED] / hits;
    rays->lost = sum[LOST] / hits;
    rays->mean_cosine = sum[MOMENT] / left;
    rays->mean_cosine_error = ratio_error(work->slots + MOMENT, work->slots + HITS, blocks, sum[MOMENT] / hits) * hits / left;
    part = hits / (double)rays->rays;
    rays->projected_um2 = disc * part;
    rays->projected_error_um2 = disc * nph_sqrt(part * (1.0 - part) / (double)rays->rays);
}

double nph_crystal_surface_um2(const NphCrystal *crystal) {
    double edge = crystal->edge_um;
    return 3.0 * nph_sqrt(3.0) * edge * edge + 6.0 * edge * crystal->length_um;
}

static const char *mistake_of(const NphCrystal *crystal) {
    double ratio = crystal->length_um / crystal->edge_um;
    if (!(crystal->edge_um > 0.0 && crystal->edge_um <= 1e6 && ratio >= 1e-3 && ratio <= 1e3)) return "its edge is above 0 and at most 1e6 um, its length 1e-3 to 1e3 times that";
    if (!(crystal->tilt >= 0.0 && crystal->tilt < 1.0)) return "its tilt is at least 0 and below 1";
    if (!(crystal->wavelength_um > 0.0)) return "the wavelength is above 0";
    if (!(crystal->index[0] > 1.0 && crystal->index[0] <= 4.0 && crystal->index[1] >= 0.0 && crystal->index[1] <= 0.1))
        return "geometric optics is for a refractive index above 1 and at most 4, with k of at most 0.1";
    if (crystal->rays < 1 || crystal->rays > NPH_CRYSTAL_MOST_RAYS) return "the number of rays is 1 to 2^36";
    return NULL;
}

NphStatus nph_crystal_trace(NphContext *context, const NphCrystal *crystal, const char *what, NphCrystalRays *rays) {
    const char *mistake = mistake_of(crystal);
    if (mistake) return nph_error(context, NPH_BAD_INPUT, "%s: %s", what, mistake);
    int64_t blocks = (crystal->rays + NPH_CRYSTAL_BLOCK - 1) / NPH_CRYSTAL_BLOCK;
    Tracing work = {.crystal = crystal};
    place_facets(&work);
    NPH_TRY(NPH_NEW(context, blocks * SLOTS, what, &work.slots));
    NphStatus status = trace_blocks(context, &work, blocks);
    if (status == NPH_OK) gather(&work, blocks, rays);
    nph_free(context, work.slots);
    return status;
}
