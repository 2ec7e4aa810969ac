/* SPDX-License-Identifier: Apache-2.0
 *
 * The sky of a flat atmosphere in closed form, and what is put together of it.
 *
 * With C the column from the eye to the end of the line, X that from the eye to the sun, b the extinction and r, l the z
 * of the line and of the sun's direction, the column is the variable in which [Riley04 eq. 14] is one exponential:
 *     integral rho exp(-b (C(t) + X(h(t)))) dt = integral_0^C exp(-b (X + c (1 - r / l))) dc = e^(-b X) C (1 - e^-q) / q
 *     q = b C (1 - r / l),   b X - q = -(b C + b X(end)):  the depth by way of the far end
 * so that whichever of the two depths is smaller stands in the exponent and |q| in the fraction: nothing overflows, and
 * neither r = l nor r = 0 nor C = 0 is special. A level line without end has C infinite and 1 / (b (1 - r / l)). */
#include "optics/sky.h"

#include "core/fmath.h"

static const double PI = 3.14159265358979323846;

/* C (1 - e^-q) / q for q = C slope >= 0. */
static double saturated(double column, double slope) {
    double q = slope > 0.0 ? column * slope : 0.0;
    if (q > 1.0) return -nph_expm1(-q) / slope;
    return q > 0.0 ? column * (-nph_expm1(-q) / q) : column;
}

/* [m]: the integral above, for a line that does not pass the ground. */
static double flat_metres(double per_m, double scale_height_m, double height_m, double rise, double sun_rise, double distance_m) {
    double near = nph_air_column_above(scale_height_m, height_m, sun_rise), end = height_m + rise * distance_m, column, far;
    int endless = !(distance_m < nph_infinity());
    if (!(near < nph_infinity())) return 0.0;
    column = endless ? nph_air_column_above(scale_height_m, height_m, rise)
                     : nph_air_column_between(scale_height_m, height_m, end, distance_m);
    far = !endless ? nph_air_column_above(scale_height_m, end, sun_rise) : rise > 0.0 ? 0.0 : near;
    double slope = per_m * (1.0 - rise / sun_rise);
    double depth = slope >= 0.0 ? per_m * near : per_m * (column + far);
    return nph_exp(-depth) * saturated(column, nph_abs(slope));
}

double nph_sky_line(NphSkyVariant variant, double per_m, double scale_height_m, double height_m, double rise,
                    double sun_rise, double distance_m) {
    if (variant == NPH_SKY_CORRECTED)
        return per_m > 0.0 ? per_m * flat_metres(per_m, scale_height_m, height_m, rise, sun_rise, distance_m) : 0.0;
    double eye = scale_height_m * per_m * nph_exp(-height_m / scale_height_m), slope = 1.0 / sun_rise - 1.0 / rise;
    double end = nph_exp(-rise * distance_m / scale_height_m);
    return sun_rise / (rise - sun_rise) * (nph_exp(-eye * slope * end) - nph_exp(-eye * slope));
}

/* ---- any atmosphere ---- */

static double column_part(double per_m, double column_m) { return per_m > 0.0 ? per_m * column_m : 0.0; }

static void pass(const NphSky *sky, const double columns_m[NPH_SKY_MOST], double transmittance[3]) {
    for (int c = 0; c < 3; c++) {
        double depth = 0.0;
        for (int i = 0; i < sky->count; i++) depth += column_part(sky->of[i].extinction_per_m[c], columns_m[i]);
        transmittance[c] = nph_exp(-depth);
    }
}

void nph_sky_transmittance(const NphSky *sky, const NphSkyLine *line, double transmittance[3]) {
    double columns[NPH_SKY_MOST];
    int grounded = !(line->distance_m < nph_infinity()) && nph_sky_end(sky, line) < nph_infinity();
    nph_sky_columns(sky, line, columns);
    pass(sky, columns, transmittance);
    for (int c = 0; c < 3 && grounded; c++) transmittance[c] = 0.0;
}

void nph_sky_sunlight(const NphSky *sky, double height_m, double irradiance[3]) {
    double columns[NPH_SKY_MOST], through[3];
    nph_sky_columns_above(sky, height_m, sky->sun[2], columns);
    pass(sky, columns, through);
    for (int c = 0; c < 3; c++) irradiance[c] = columns[0] < nph_infinity() ? sky->irradiance[c] * through[c] : 0.0;
}

/* One exponential in all: flat, and every constituent has the same scale height. */
static int is_closed(const NphSky *sky) {
    return !(sky->radius_m > 0.0) && (sky->count == 1 || sky->of[0].scale_height_m == sky->of[1].scale_height_m);
}

void nph_sky_sources(const NphSky *sky, const NphSkyLine *line, double source[NPH_SKY_MOST][3]) {
    double metres[NPH_SKY_MOST][3];
    if (is_closed(sky)) {
        double end = nph_sky_end(sky, line);
        for (int c = 0; c < 3; c++) {
            double per_m = 0.0;
            for (int i = 0; i < sky->count; i++) per_m += sky->of[i].extinction_per_m[c];
            for (int i = 0; i < sky->count; i++)
                metres[i][c] = per_m > 0.0 ? flat_metres(per_m, sky->of[0].scale_height_m, line->height_m, line->direction[2],
                                                         sky->sun[2], end) : 0.0;
        }
    } else {
        nph_sky_integrate(sky, line, metres);
    }
    for (int i = 0; i < sky->count; i++)
        for (int c = 0; c < 3; c++) source[i][c] = metres[i][c] * sky->of[i].extinction_per_m[c] * sky->of[i].albedo[c];
}

void nph_sky_combine(const NphSky *sky, const double direction[3], double source[NPH_SKY_MOST][3], double radiance[3]) {
    double cosine = direction[0] * sky->sun[0] + direction[1] * sky->sun[1] + direction[2] * sky->sun[2];
    cosine = cosine > 1.0 ? 1.0 : cosine < -1.0 ? -1.0 : cosine;
    for (int c = 0; c < 3; c++) radiance[c] = 0.0;
    for (int i = 0; i < sky->count; i++) {
        double phase = nph_phase_value(sky->of[i].phase, cosine);
        for (int c = 0; c < 3; c++) radiance[c] += sky->irradiance[c] * phase * source[i][c];
    }
}

void nph_sky_scattered(const NphSky *sky, const NphSkyLine *line, double radiance[3]) {
    double source[NPH_SKY_MOST][3];
    nph_sky_sources(sky, line, source);
    nph_sky_combine(sky, line->direction, source, radiance);
}

/* The line behind the split, as seen from there: around a sphere the vertical there is another, so direction and sun are
 * turned about the horizontal axis that takes the one vertical into the other. */
static void move_on(const NphSky *sky, const NphSkyLine *line, double distance_m, NphSky *moved_sky, NphSkyLine *moved) {
    *moved_sky = *sky;
    *moved = *line;
    moved->height_m = nph_sky_height(sky, line, distance_m);
    moved->distance_m = nph_infinity();
    if (!(sky->radius_m > 0.0)) return;
    double x = distance_m * line->direction[0], y = distance_m * line->direction[1];
    double across = nph_sqrt(x * x + y * y), radius = sky->radius_m + moved->height_m;
    double sine = across / radius, cosine = (sky->radius_m + line->height_m + distance_m * line->direction[2]) / radius;
    if (!(across > 0.0)) return;
    double ax = x / across, ay = y / across;
    double *turned[2] = {moved->direction, moved_sky->sun};
    for (int k = 0; k < 2; k++) {
        double *v = turned[k], along = ax * v[0] + ay * v[1], up = v[2];
        double change = along * (cosine - 1.0) - up * sine;
        v[0] += ax * change;
        v[1] += ay * change;
        v[2] = up * cosine + along * sine;
    }
}

void nph_sky_split(const NphSky *sky, const NphSkyLine *line, NphSkySplit *split) {
    NphSkyLine behind, endless = *line;
    NphSky there;
    endless.distance_m = nph_infinity();
    nph_sky_scattered(sky, line, split->front);
    nph_sky_transmittance(sky, line, split->through);
    for (int c = 0; c < 3; c++) split->behind[c] = 0.0;
    if (!(line->distance_m < nph_sky_end(sky, &endless))) return;
    move_on(sky, line, line->distance_m, &there, &behind);
    nph_sky_scattered(&there, &behind, split->behind);
}

void nph_sky_disc(const NphSky *sky, const NphSkyLine *line, double half_angle_rad, double radiance[3]) {
    double half = nph_sin(0.5 * half_angle_rad), sine = nph_sin(half_angle_rad), through[3], off = 0.0;
    for (int a = 0; a < 3; a++) off += (line->direction[a] - sky->sun[a]) * (line->direction[a] - sky->sun[a]);
    for (int c = 0; c < 3; c++) radiance[c] = 0.0;
    if (!(0.25 * off < half * half)) return; /* 1 - cos = |a - b|^2 / 2 */
    nph_sky_transmittance(sky, line, through);
    for (int c = 0; c < 3; c++) radiance[c] = sky->irradiance[c] * through[c] / (PI * sine * sine);
}
