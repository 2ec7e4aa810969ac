/* SPDX-License-Identifier: Apache-2.0
 *
 * Distributions of sizes (sizes.h), over u = ln r, where all of them times any power of r have one peak. */
#include "optics/sizes.h"

#include <stddef.h>

#include "core/fmath.h"

const char *nph_sizes_mistake(const NphSizes *sizes) {
    if (!(sizes->radius_um >= NPH_SIZES_LEAST_UM && sizes->radius_um <= NPH_SIZES_MOST_UM))
        return "the radius lies outside 1e-6 to 1e6 um";
    if (sizes->kind == NPH_SIZES_LOGNORMAL && !(sizes->spread > 1.0 && sizes->spread <= NPH_SIZES_MOST_LOGNORMAL))
        return "the spread of a lognormal distribution, its geometric standard deviation, lies above 1 and at most at 5";
    if (sizes->kind == NPH_SIZES_GAMMA && !(sizes->spread >= NPH_SIZES_LEAST_GAMMA && sizes->spread <= NPH_SIZES_MOST_GAMMA))
        return "the spread of a gamma distribution, its effective variance, is 1e-4 to 0.49";
    if (sizes->kind == NPH_SIZES_MODIFIED_GAMMA &&
        !(sizes->alpha > 0.0 && sizes->alpha <= 100.0 && sizes->gamma >= 0.1 && sizes->gamma <= 10.0))
        return "alpha of a modified gamma distribution lies above 0 and at most at 100, gamma at 0.1 to 10";
    return NULL;
}

/* Of a gamma distribution: r^alpha exp(-alpha / gamma (r / radius)^gamma) with its own names. */
static double log_power(double alpha, double rate, double gamma, double u) { return (alpha + 1.0) * u - rate * nph_exp(gamma * u); }

double nph_sizes_log_density(const NphSizes *sizes, double log_um) {
    double u = log_um - nph_log(sizes->radius_um);
    if (sizes->kind == NPH_SIZES_LOGNORMAL) {
        double width = nph_log(sizes->spread);
        return -0.5 * (u / width) * (u / width);
    }
    if (sizes->kind == NPH_SIZES_GAMMA) return log_power(1.0 / sizes->spread - 3.0, 1.0 / sizes->spread, 1.0, u);
    return log_power(sizes->alpha, sizes->alpha / sizes->gamma, sizes->gamma, u);
}

/* Where the density times r^power is largest. */
static double peak(const NphSizes *sizes, double power) {
    double at = nph_log(sizes->radius_um);
    if (sizes->kind == NPH_SIZES_LOGNORMAL) {
        double width = nph_log(sizes->spread);
        return at + power * width * width;
    }
    if (sizes->kind == NPH_SIZES_GAMMA) return at + nph_log(1.0 + (power - 2.0) * sizes->spread);
    return at + nph_log((sizes->alpha + 1.0 + power) / sizes->alpha) / sizes->gamma;
}

/* The bound on one side: bisection between the peak and where the density is surely small. */
static double bound(const NphSizes *sizes, double power, double side, double drop) {
    double top = peak(sizes, power), most = nph_sizes_log_density(sizes, top) + power * top, in = 0.0, out = 1e-3;
    while (most - nph_sizes_log_density(sizes, top + side * out) - power * (top + side * out) < drop) out *= 2.0;
    for (int step = 0; step < 60; step++) {
        double middle = 0.5 * (in + out), at = top + side * middle;
        *(most - nph_sizes_log_density(sizes, at) - power * at < drop ? &in : &out) = middle;
    }
    return top + side * out;
}

void nph_sizes_range(const NphSizes *sizes, double least, double range_um[2]) {
    range_um[0] = range_um[1] = sizes->radius_um;
    if (sizes->kind == NPH_SIZES_SINGLE) return;
    range_um[0] = nph_exp(bound(sizes, 2.0, -1.0, -nph_log(least)));
    range_um[1] = nph_exp(bound(sizes, 6.0, 1.0, -nph_log(least)));
}
