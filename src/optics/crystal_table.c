/* SPDX-License-Identifier: Apache-2.0
 *
 * From the rays of crystals to a table. Diffraction takes as much light again as falls on the crystal; of a direction it is that of a
 * disc with the crystal's projected area, Fraunhofer's with the obliquity (1 + cos)^2 / 4 [Bohren83 sec. 4.4.3]
 *   (1 + cos)^2 / 4  x^2 / (4 pi)  (2 J1(x sin) / (x sin))^2,
 * averaged over directions. What leaves straight on through parallel facets is a beam as wide as a facet and is diffracted alike. */
#include <stddef.h>

#include "core/fmath.h"
#include "core/memory.h"
#include "core/message.h"
#include "core/reduce.h"
#include "optics/crystal.h"

enum { NEAR_MOST = 512, POLAR = 16, AROUND = 6, DIRECTIONS = POLAR * AROUND };

static const double PI = 3.14159265358979323846;

/* J1(z) / z. Below 30 by the trapezoid rule over a period, exact to rounding [Abramowitz64 eq. 9.1.21], above by Hankel's expansion
 * [Abramowitz64 eq. 9.2.5]. */
static double bessel_over_z(double z) {
    enum { STEPS = 48 };
    if (z < 1e-4) return 0.5 - z * z / 16.0;
    if (z < 30.0) {
        NphSum sum = {0.0, 0.0};
        for (int i = 0; i < STEPS; i++) { /* (1 / pi) int_0^pi sin t sin(z sin t): even about pi / 2 */
            double sine, cosine;
            nph_sincos2pi(((double)i + 0.5) / (2.0 * STEPS), &sine, &cosine);
            nph_sum_add(&sum, sine * nph_sin(z * sine));
        }
        return nph_sum_value(sum) / STEPS / z;
    }
    double t = 1.0 / (64.0 * z * z), p = 1.0 + t * (7.5 - t * 590.625), q = (3.0 - t * 52.5) / (8.0 * z), phase = z - 0.75 * PI;
    return nph_sqrt(2.0 / (PI * z)) * (p * nph_cos(phase) - q * nph_sin(phase)) / z;
}

/* Projected areas of evenly spread directions: of a convex body the sum over facets of area times cosine. */
static void projected_areas(const NphCrystal *crystal, double area[DIRECTIONS]) {
    double cap = 1.5 * nph_sqrt(3.0) * crystal->edge_um * crystal->edge_um, side = crystal->edge_um * crystal->length_um;
    for (int i = 0; i < DIRECTIONS; i++) {
        int polar = i / AROUND, around = i % AROUND;
        double z = ((double)polar + 0.5) / POLAR, turn = ((double)around + 0.5) / (12.0 * AROUND), sides = 0.0;
        for (int k = -1; k <= 1; k++) {
            double sine, cosine;
            nph_sincos2pi(turn + (double)k / 6.0, &sine, &cosine);
            sides += nph_abs(cosine);
        }
        area[i] = cap * z + side * nph_sqrt(1.0 - z * z) * sides;
    }
}

/* [1/sr], weighted by the light that each direction takes away. */
static double diffraction(const double area[DIRECTIONS], double wavelength_um, double degrees) {
    double sine, cosine;
    NphSum value = {0.0, 0.0}, whole = {0.0, 0.0};
    nph_sincos2pi(degrees / 360.0, &sine, &cosine);
    if (degrees >= 90.0) return 0.0;
    for (int i = 0; i < DIRECTIONS; i++) {
        double x = 2.0 * PI / wavelength_um * nph_sqrt(area[i] / PI), lobe = 2.0 * bessel_over_z(x * sine);
        nph_sum_add(&value, area[i] * x * x * lobe * lobe);
        nph_sum_add(&whole, area[i]);
    }
    double oblique = 0.5 * (1.0 + cosine);
    return oblique * oblique * nph_sum_value(value) / nph_sum_value(whole) / (4.0 * PI);
}

static double bin_middle(int bin) { return ((double)bin + 0.5) * 180.0 / NPH_CRYSTAL_BINS; }

/* [1/sr] of what leaves within a bin. */
static double bin_density(const NphCrystalRays *rays, int bin) {
    double sine[2], cosine[2];
    for (int k = 0; k < 2; k++) nph_sincos2pi((double)(bin + k) / (2.0 * NPH_CRYSTAL_BINS), &sine[k], &cosine[k]);
    return rays->bin[bin] / (2.0 * PI * (cosine[0] - cosine[1]));
}

/* Between middles of bins linear, and before the first and after the last as there. */
static double leaving(const NphCrystalRays *rays, double degrees) {
    double at = degrees * NPH_CRYSTAL_BINS / 180.0 - 0.5, last = NPH_CRYSTAL_BINS - 1;
    at = at < 0.0 ? 0.0 : at > last ? last : at;
    int bin = at < last ? (int)at : NPH_CRYSTAL_BINS - 2;
    double low = bin_density(rays, bin), high = bin_density(rays, bin + 1);
    return low + (at - bin) * (high - low);
}

/* Angles: from 0 in steps that grow by a twentieth of the angle from a twentieth of the peak's width until bins are finer, and bins. */
static int near_angles(double x, double degrees[NEAR_MOST]) {
    double step = 0.05 / x * (180.0 / PI), at = 0.0, widest = 180.0 / NPH_CRYSTAL_BINS;
    int count = 0;
    for (; step < widest && at < bin_middle(0) + 40.0 * widest && count < NEAR_MOST; step *= 1.05) {
        degrees[count++] = at;
        at += step;
    }
    if (count == 0) degrees[count++] = 0.0;
    return count;
}

static NphStatus fill_rows(NphContext *context, const NphCrystal *crystal, const char *what, NphCrystalTable *table) {
    double near[NEAR_MOST], area[DIRECTIONS], x = 2.0 * PI / crystal->wavelength_um * nph_sqrt(nph_crystal_surface_um2(crystal) / (4.0 * PI));
    int few = near_angles(x, near), first = 0;
    while (bin_middle(first) <= near[few - 1]) first++;
    int count = few + NPH_CRYSTAL_BINS - first + 1;
    projected_areas(crystal, area);
    NPH_TRY(nph_array_new(context, NPH_F64, 2, (int64_t[]){count, 2}, what, &table->rows));
    double *rows = table->rows.data, bent = 1.0 + table->rays.straight;
    NphSum norm = {0.0, 0.0};
    for (int i = 0; i < count; i++) {
        rows[2 * i] = i < few ? near[i] : i < count - 1 ? bin_middle(first + i - few) : 180.0;
        rows[2 * i + 1] = diffraction(area, crystal->wavelength_um, rows[2 * i]);
        if (i == 0) continue;
        double sine, cosine, before;
        nph_sincos2pi(0.5 * (rows[2 * i] + rows[2 * i - 2]) / 360.0, &sine, &cosine);
        nph_sincos2pi(0.5 * (rows[2 * i] - rows[2 * i - 2]) / 360.0, &before, &cosine);
        nph_sum_add(&norm, 2.0 * PI * (rows[2 * i + 1] + rows[2 * i - 1]) * sine * before); /* cos a - cos b */
    }
    for (int i = 0; i < count; i++)
        rows[2 * i + 1] = bent / nph_sum_value(norm) * rows[2 * i + 1] + leaving(&table->rays, rows[2 * i]);
    return NPH_OK;
}

/* The diffracted peak's mean cosine is that of the table's; the rest is known from the rays. */
static void finish(const NphCrystal *crystal, NphCrystalTable *table) {
    const NphCrystalRays *rays = &table->rays;
    const double *rows = table->rows.data;
    NphSum whole = {0.0, 0.0}, moment = {0.0, 0.0};
    for (int64_t i = 0; i + 1 < table->rows.shape[0]; i++) {
        double sine, cosine, half, other;
        nph_sincos2pi(0.5 * (rows[2 * i] + rows[2 * i + 2]) / 360.0, &sine, &cosine);
        nph_sincos2pi(0.5 * (rows[2 * i + 2] - rows[2 * i]) / 360.0, &half, &other);
        double width = 2.0 * sine * half, middle = cosine * other, mean = 0.5 * (rows[2 * i + 1] + rows[2 * i + 3]);
        nph_sum_add(&whole, 2.0 * PI * width * mean);
        nph_sum_add(&moment, 2.0 * PI * width * (mean * middle + (rows[2 * i + 1] - rows[2 * i + 3]) * width / 12.0));
    }
    double left = 1.0 - rays->absorbed - rays->lost;
    table->asymmetry = nph_sum_value(moment) / nph_sum_value(whole);
    table->asymmetry_error = rays->mean_cosine_error * left / (1.0 + left);
    table->albedo = 1.0 - 0.5 * rays->absorbed;
    table->extinction_um2 = 0.5 * nph_crystal_surface_um2(crystal);
}

NphStatus nph_crystal_table(NphContext *context, const NphCrystal *crystal, const char *what, NphCrystalTable *table) {
    NphCrystalTable made = {.rows = {.rank = 0}};
    NPH_TRY(nph_crystal_trace(context, crystal, what, &made.rays));
    if (made.rays.hits == 0) return nph_error(context, NPH_BAD_INPUT, "%s: none of %lld rays met the crystal", what, (long long)made.rays.rays);
    NPH_TRY(fill_rows(context, crystal, what, &made));
    finish(crystal, &made);
    *table = made;
    return NPH_OK;
}

void nph_crystal_table_free(NphContext *context, NphCrystalTable *table) { nph_array_free(context, &table->rows); }
