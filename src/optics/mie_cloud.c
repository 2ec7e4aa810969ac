/* SPDX-License-Identifier: Apache-2.0
 *
 * Sums over sizes. The trapezoid rule over ln r converges faster than any power of its step once the step resolves what the
 * intensity does between neighbours, and a halved grid keeps the points that are there. A block is a few spheres at some of the
 * angles; its sums have places of their own and are folded in the order of the spheres, whoever computed them. */
#include "optics/mie_cloud.h"

#include <stddef.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"
#include "core/reduce.h"
#include "core/text.h"
#include "optics/mie_kernel.h"

enum { SPHERES_PER_BLOCK = 8, TILES_PER_BLOCK = 16, FEWEST_POINTS = 32 };
enum { EXTINCTION, SCATTERING, ABSORPTION, MOMENT, GEOMETRIC, AREA, VOLUME, FOURTH, NUMBER, SUMS };

static const double PI = 3.14159265358979323846, LEAST = 1e-7;

/* Spheres skip, skip + stride, ... of the grid, each at every wavelength. */
typedef struct Sum {
    const NphMieCloud *cloud;
    int64_t skip, stride, spheres;
    int64_t begin;         /* the first block that is run */
    int64_t tiles, groups; /* of angles: NPH_MIE_LANES to a tile, TILES_PER_BLOCK tiles to a group */
    double *distance;      /* padded to whole tiles; forward ones first */
    int64_t front_tiles;
    double *part;          /* [blocks of spheres][tiles * lanes] */
    double *sums;          /* [spheres][SUMS] */
    int64_t block_doubles, order_count;
    double *scratch;       /* per worker: terms, then NphMieOrder forward and backward */
    void (*kernel)(const NphMieTile *);
} Sum;

static double log_radius(const NphMieCloud *cloud, int64_t point) { return cloud->first + (double)point * cloud->step; }

static NphMieSphere sphere_at(const NphMieCloud *cloud, double radius_um, int wavelength) {
    const NphMieRequest *request = cloud->request;
    return (NphMieSphere){2.0 * PI * radius_um / request->wavelength_um[wavelength], request->index[wavelength][0],
                          request->index[wavelength][1]};
}

static double number_at(const NphMieCloud *cloud, double log_um) {
    if (cloud->request->sizes.kind == NPH_SIZES_SINGLE) return 1.0;
    double reference = nph_sizes_log_density(&cloud->request->sizes, nph_log(cloud->request->sizes.radius_um));
    return nph_exp(nph_sizes_log_density(&cloud->request->sizes, log_um) - reference);
}

/* For both kinds of tiles; mie.c tells why the backward ones are these. */
static void make_orders(const NphMieTerms *terms, int64_t padded, NphMieOrder *front, NphMieOrder *back) {
    for (int64_t i = 0; i < padded; i++) {
        double n = (double)(i + 1), c = i < terms->count ? (2.0 * n + 1.0) / (n * (n + 1.0)) : 0.0, s = i & 1 ? -c : c;
        int64_t at = i < terms->count ? i : 0;
        double plus_re = terms->a_re[at] + terms->b_re[at], plus_im = terms->a_im[at] + terms->b_im[at];
        double minus_re = terms->a_re[at] - terms->b_re[at], minus_im = terms->a_im[at] - terms->b_im[at];
        front[i] = (NphMieOrder){c * plus_re, c * plus_im, c * minus_re, c * minus_im, n, (n + 1.0) / n};
        back[i] = (NphMieOrder){s * minus_re, s * minus_im, s * plus_re, s * plus_im, n, (n + 1.0) / n};
    }
}

static void add_totals(const NphMieSphere *sphere, const NphMieTerms *terms, double weight, double radius_um, double *sums) {
    NphMie mie;
    nph_mie_efficiencies(sphere, terms, &mie);
    double area = weight * PI * radius_um * radius_um;
    sums[EXTINCTION] = area * mie.extinction;
    sums[SCATTERING] = area * mie.scattering;
    sums[ABSORPTION] = area * mie.absorption;
    sums[MOMENT] = area * mie.scattering * mie.asymmetry;
    sums[GEOMETRIC] = area;
    sums[AREA] = weight * radius_um * radius_um;
    sums[VOLUME] = sums[AREA] * radius_um;
    sums[FOURTH] = sums[VOLUME] * radius_um;
    sums[NUMBER] = weight;
}

static NphStatus sum_block(void *data, int64_t number, int worker) {
    Sum *sum = data;
    int64_t block = sum->begin + number;
    const NphMieCloud *cloud = sum->cloud;
    int wavelengths = cloud->request->wavelength_count;
    int64_t group = block % sum->groups, first = block / sum->groups * SPHERES_PER_BLOCK, end = first + SPHERES_PER_BLOCK;
    int64_t tile_end = (group + 1) * TILES_PER_BLOCK < sum->tiles ? (group + 1) * TILES_PER_BLOCK : sum->tiles;
    double *scratch = sum->scratch + worker * (sum->block_doubles + 2 * sum->order_count * (int64_t)(sizeof(NphMieOrder) / sizeof(double)));
    double *part = sum->part + block / sum->groups * sum->tiles * NPH_MIE_LANES;
    for (int64_t i = first; i < end && i < sum->spheres; i++) {
        double u = log_radius(cloud, sum->skip + i / wavelengths * sum->stride);
        double radius_um = cloud->request->sizes.kind == NPH_SIZES_SINGLE ? cloud->request->sizes.radius_um : nph_exp(u);
        double weight = number_at(cloud, u), wave = cloud->request->wavelength_um[i % wavelengths] / (2.0 * PI);
        NphMieSphere sphere = sphere_at(cloud, radius_um, (int)(i % wavelengths));
        NphMieTerms terms;
        nph_mie_terms(&sphere, scratch, &terms);
        int64_t padded = (terms.count + NPH_MIE_UNROLL - 1) / NPH_MIE_UNROLL * NPH_MIE_UNROLL;
        NphMieOrder *front = (NphMieOrder *)(void *)(scratch + sum->block_doubles), *back = front + sum->order_count;
        make_orders(&terms, padded, front, back);
        if (group == 0 && sum->sums) add_totals(&sphere, &terms, weight, radius_um, sum->sums + i * SUMS);
        for (int64_t t = group * TILES_PER_BLOCK; t < tile_end; t++) {
            NphMieTile tile = {t < sum->front_tiles ? front : back, (int)padded, weight * wave * wave,
                               sum->distance + t * NPH_MIE_LANES, part + t * NPH_MIE_LANES};
            sum->kernel(&tile);
        }
    }
    return NPH_OK;
}

/* All blocks, a sixteenth of them at a time: large spheres take minutes. */
static NphStatus sum_blocks(NphContext *context, Sum *sum, int64_t blocks) {
    int64_t slice = (blocks + 15) / 16;
    for (; sum->begin < blocks; sum->begin += slice) {
        nph_progress(context, "summing over sizes", (double)sum->begin, (double)blocks, -1.0);
        NPH_TRY(nph_pool_run(context, sum->begin + slice < blocks ? slice : blocks - sum->begin, sum_block, sum, NULL));
    }
    nph_progress(context, "summing over sizes", (double)blocks, (double)blocks, -1.0);
    return NPH_OK;
}

/* Distances of one pole, and the last one again up to a whole tile. */
static int64_t place_angles(const NphMieAngles *angles, int back, double *distance, int64_t at, int64_t *place) {
    int64_t begin = at;
    for (int64_t i = 0; i < angles->count; i++) {
        if ((angles->back[i] != 0) != back) continue;
        distance[at] = angles->distance[i];
        place[i] = at++;
    }
    while (at > begin && at % NPH_MIE_LANES != 0) {
        distance[at] = distance[at - 1];
        at++;
    }
    return at;
}

static void fold(const Sum *sum, int64_t blocks, const NphMieAngles *angles, const int64_t *place, double *value, double *totals) {
    int64_t width = sum->tiles * NPH_MIE_LANES;
    for (int64_t i = 0; i < angles->count; i++) value[i] = nph_tree_sum(sum->part + place[i], blocks, width);
    for (int k = 0; k < SUMS && totals; k++) totals[k] = nph_tree_sum(sum->sums + k, sum->spheres, SUMS);
}

static NphStatus allocate(NphContext *context, Sum *sum, int64_t blocks, const NphMieAngles *angles, int with_totals, int64_t **place) {
    int64_t most = angles->count + 2 * NPH_MIE_LANES, per_worker = sum->block_doubles + 2 * sum->order_count * (int64_t)(sizeof(NphMieOrder) / sizeof(double));
    NPH_TRY(NPH_NEW(context, most, "angles", &sum->distance));
    NPH_TRY(NPH_NEW(context, angles->count, "angles", place));
    sum->tiles = place_angles(angles, 0, sum->distance, 0, *place) / NPH_MIE_LANES;
    sum->front_tiles = sum->tiles;
    sum->tiles = place_angles(angles, 1, sum->distance, sum->tiles * NPH_MIE_LANES, *place) / NPH_MIE_LANES;
    sum->groups = (sum->tiles + TILES_PER_BLOCK - 1) / TILES_PER_BLOCK;
    NPH_TRY(NPH_NEW(context, blocks * sum->tiles * NPH_MIE_LANES, "intensities of spheres", &sum->part));
    if (with_totals) NPH_TRY(NPH_NEW(context, sum->spheres * SUMS, "efficiencies of spheres", &sum->sums));
    return NPH_NEW(context, per_worker * nph_context_threads(context), "orders of spheres", &sum->scratch);
}

/* Sums, not yet times the step, over points skip, skip + stride, ... up to `points`; totals may be NULL. */
static NphStatus add_up(NphContext *context, const NphMieCloud *cloud, int64_t skip, int64_t stride, const NphMieAngles *angles,
                        double *value, double *totals) {
    Sum sum = {.cloud = cloud, .skip = skip, .stride = stride};
    NphMieSphere largest = {0.0, 0.0, 0.0};
    for (int w = 0; w < cloud->request->wavelength_count; w++) {
        double radius = cloud->request->sizes.kind == NPH_SIZES_SINGLE ? cloud->request->sizes.radius_um
                                                                       : nph_exp(log_radius(cloud, cloud->points - 1)) * (1.0 + 1e-12);
        NphMieSphere sphere = sphere_at(cloud, radius, w);
        int64_t doubles = nph_mie_doubles(&sphere);
        sum.block_doubles = doubles > sum.block_doubles ? doubles : sum.block_doubles;
        largest = sphere.x > largest.x ? sphere : largest;
    }
    sum.order_count = nph_mie_orders(largest.x) + NPH_MIE_UNROLL;
    sum.spheres = ((cloud->points - skip + stride - 1) / stride) * cloud->request->wavelength_count;
    int64_t blocks = (sum.spheres + SPHERES_PER_BLOCK - 1) / SPHERES_PER_BLOCK, *place = NULL;
    NPH_KERNEL_PICK(sum.kernel, nph_mie_tile, nph_context_isa(context), 64);
    NphStatus status = allocate(context, &sum, blocks, angles, totals != NULL, &place);
    if (status == NPH_OK) status = sum_blocks(context, &sum, blocks * sum.groups);
    if (status == NPH_OK) fold(&sum, blocks, angles, place, value, totals);
    nph_free(context, sum.scratch);
    nph_free(context, sum.sums);
    nph_free(context, sum.part);
    nph_free(context, place);
    nph_free(context, sum.distance);
    return status;
}

static void finish_totals(const double sums[SUMS], NphMieTotals *totals) {
    double number = sums[NUMBER], effective = sums[VOLUME] / sums[AREA];
    totals->extinction_um2 = sums[EXTINCTION] / number;
    totals->scattering_um2 = sums[SCATTERING] / number;
    totals->absorption_um2 = sums[ABSORPTION] / number;
    totals->geometric_um2 = sums[GEOMETRIC] / number;
    totals->asymmetry = sums[MOMENT] / sums[SCATTERING];
    totals->effective_radius_um = effective;
    totals->effective_variance = sums[FOURTH] / (sums[AREA] * effective * effective) - 1.0;
}

NphStatus nph_mie_check(NphContext *context, const NphMieRequest *request, const char *what, double *largest_x) {
    char low[NPH_DOUBLE_TEXT], high[NPH_DOUBLE_TEXT];
    const char *mistake = nph_sizes_mistake(&request->sizes);
    double range_um[2], found = 0.0;
    if (mistake) return nph_error(context, NPH_BAD_INPUT, "%s: %s", what, mistake);
    nph_sizes_range(&request->sizes, LEAST, range_um);
    for (int w = 0; w < request->wavelength_count; w++) {
        double n = request->index[w][0], k = request->index[w][1], wave = request->wavelength_um[w];
        double least = 2.0 * PI * range_um[0] / wave, most = 2.0 * PI * range_um[1] / wave, size = nph_sqrt(n * n + k * k);
        found = most > found ? most : found;
        if (!(n > 0.0 && k >= 0.0 && size <= 1e3))
            return nph_error(context, NPH_BAD_INPUT, "%s: the refractive index is %s + %s i; n is above 0, k at least 0, |n + i k| at most 1000",
                             what, nph_format_double(n, low), nph_format_double(k, high));
        if (!(least >= NPH_MIE_LEAST_X && most <= NPH_MIE_MOST_X && most * size <= NPH_MIE_MOST_MX))
            return nph_error(context, NPH_BAD_INPUT, "%s: size parameters 2 pi r / wavelength from %s to %s (sizes that scatter less than "
                             "1e-7 left out) do not lie within 1e-6 to 1e5, or times |n + i k| above 1e6", what,
                             nph_format_rounded(least, 3, low), nph_format_rounded(most, 3, high));
    }
    *largest_x = found;
    return NPH_OK;
}

/* What a halving changed: root mean square over angles, relative. */
static double change(const double *before, double before_scale, const double *after, double after_scale, int64_t count) {
    NphSum sum = {0.0, 0.0};
    for (int64_t i = 0; i < count; i++) {
        double relative = before[i] * before_scale / (after[i] * after_scale) - 1.0;
        nph_sum_add(&sum, relative * relative);
    }
    return nph_sqrt(nph_sum_value(sum) / (double)count);
}

/* Ten times what it changed of the extinction per particle and of 1 - g, relative: resonances narrower than the step add to both what
 * hardly shows at any one angle. */
static double change_of_totals(const double before[SUMS], const double after[SUMS]) {
    double extinction = before[EXTINCTION] / before[NUMBER] / (after[EXTINCTION] / after[NUMBER]) - 1.0;
    double rest = (1.0 - before[MOMENT] / before[SCATTERING]) / (1.0 - after[MOMENT] / after[SCATTERING]) - 1.0;
    return 10.0 * (nph_abs(extinction) > nph_abs(rest) ? nph_abs(extinction) : nph_abs(rest));
}

/* Halves until a halving changes less than the tolerance. values: room for three times the angles. */
static NphStatus halve(NphContext *context, NphMieCloud *cloud, const NphMieAngles *probe, const char *what, double *values, double sums[SUMS]) {
    double *before = values, *more = values + probe->count, *now = values + 2 * probe->count;
    NPH_TRY(add_up(context, cloud, 0, 1, probe, now, sums));
    while (cloud->request->sizes.kind != NPH_SIZES_SINGLE) {
        double added[SUMS], old[SUMS];
        cloud->step *= 0.5;
        cloud->points = 2 * cloud->points - 1;
        NPH_TRY(add_up(context, cloud, 1, 2, probe, more, added));
        for (int64_t i = 0; i < probe->count; i++) {
            before[i] = now[i];
            now[i] += more[i];
        }
        for (int k = 0; k < SUMS; k++) {
            old[k] = sums[k];
            sums[k] += added[k];
        }
        double angles = change(before, 1.0 / old[SCATTERING], now, 1.0 / sums[SCATTERING], probe->count), totals = change_of_totals(old, sums);
        cloud->size_error = angles > totals ? angles : totals;
        if (cloud->size_error <= cloud->request->tolerance) break;
        if (2 * cloud->points - 1 <= NPH_MIE_MOST_SIZES) continue;
        char error[NPH_DOUBLE_TEXT];
        nph_warn(context, "%s: the sum over %lld sizes still changes by %s, root mean square over angles", what, (long long)cloud->points,
                 nph_format_rounded(cloud->size_error, 2, error));
        break;
    }
    return NPH_OK;
}

NphStatus nph_mie_cloud(NphContext *context, const NphMieRequest *request, const NphMieAngles *probe, const char *what,
                        NphMieCloud *out, double *value) {
    NphMieCloud cloud = {.request = request, .points = 1};
    double range_um[2], sums[SUMS], *values = NULL;
    nph_sizes_range(&request->sizes, LEAST, range_um);
    cloud.first = nph_log(range_um[0]);
    if (request->sizes.kind != NPH_SIZES_SINGLE) {
        cloud.points = FEWEST_POINTS + 1;
        cloud.step = (nph_log(range_um[1]) - cloud.first) / FEWEST_POINTS;
    }
    NPH_TRY(NPH_NEW(context, 3 * probe->count, what, &values));
    NphStatus status = halve(context, &cloud, probe, what, values, sums);
    for (int64_t i = 0; i < probe->count && status == NPH_OK; i++) value[i] = values[2 * probe->count + i] / sums[SCATTERING];
    nph_free(context, values);
    NPH_TRY(status);
    finish_totals(sums, &cloud.totals);
    cloud.weight_sum = sums[SCATTERING];
    *out = cloud;
    return NPH_OK;
}

NphStatus nph_mie_cloud_values(NphContext *context, const NphMieCloud *cloud, const NphMieAngles *angles, double *value) {
    NPH_TRY(add_up(context, cloud, 0, 1, angles, value, NULL));
    for (int64_t i = 0; i < angles->count; i++) value[i] /= cloud->weight_sum;
    return NPH_OK;
}
