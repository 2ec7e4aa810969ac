/* SPDX-License-Identifier: Apache-2.0
 *
 * The sky along a line of sight by quadrature: several scale heights, and atmospheres around a sphere.
 *
 * The line is taken in pieces along which no constituent that still matters changes by more than a factor e^2 and the
 * optical depth by more than 1, each by Gauss and Legendre's rule of 8 points; a smooth integrand of that range is then known to
 * 1e-11. Heights above a sphere are counted without cancellation, as in air_table.c. */
#include <assert.h>

#include "core/fmath.h"
#include "optics/sky.h"

enum { POINTS = 8, MOST_PIECES = 4000 };

/* Gauss and Legendre's rule on [0, 1]. */
static const double PLACE[POINTS] = {0.019855071751231912, 0.10166676129318664, 0.23723379504183550, 0.40828267875217511,
                                     0.59171732124782489, 0.76276620495816450, 0.89833323870681336, 0.98014492824876809};
static const double WEIGHT[POINTS] = {0.050614268145188129, 0.11119051722668724, 0.15685332293894363, 0.18134189168918100,
                                      0.18134189168918100, 0.15685332293894363, 0.11119051722668724, 0.050614268145188129};

/* The same of 4 points, for a fifth of a piece. */
static const double NEAR_PLACE[4] = {0.069431844202973712, 0.33000947820757187, 0.66999052179242813, 0.93056815579702629};
static const double NEAR_WEIGHT[4] = {0.17392742256872693, 0.32607257743127307, 0.32607257743127307, 0.17392742256872693};

static const double NOTHING = 1e-17; /* a depth below which a constituent no longer matters */
static const double OPAQUE = 45.0;   /* e^-45 = 3e-20: behind it nothing is looked for */

double nph_sky_height(const NphSky *sky, const NphSkyLine *line, double distance_m) {
    if (!(sky->radius_m > 0.0)) return line->height_m + distance_m * line->direction[2];
    double radius = sky->radius_m + line->height_m, run = distance_m * (distance_m + 2.0 * radius * line->direction[2]);
    return line->height_m + run / (nph_sqrt(radius * radius + run) + radius);
}

/* Distance to the height `to_m`: of a line that leads up and begins below it, or down and begins above it and reaches it;
 * infinite where it does not. */
static double distance_to(const NphSky *sky, const NphSkyLine *line, double to_m) {
    double climb = to_m - line->height_m, rise = line->direction[2];
    if (!(sky->radius_m > 0.0)) return climb * rise > 0.0 ? climb / rise : climb == 0.0 && rise != 0.0 ? 0.0 : nph_infinity();
    double radius = sky->radius_m + line->height_m, straight = radius * rise, run = climb * (2.0 * sky->radius_m + line->height_m + to_m);
    double square = straight * straight + run;
    if (climb > 0.0) return rise >= 0.0 ? run / (straight + nph_sqrt(square)) : nph_sqrt(square) - straight;
    if (!(rise < 0.0) || !(square >= 0.0)) return nph_infinity();
    return run / (straight - nph_sqrt(square));
}

double nph_sky_end(const NphSky *sky, const NphSkyLine *line) {
    double ground = line->direction[2] < 0.0 ? distance_to(sky, line, 0.0) : nph_infinity();
    return line->distance_m < ground ? line->distance_m : ground;
}

static double density(const NphSky *sky, int i, double height_m) {
    const NphSkyConstituent *of = &sky->of[i];
    height_m = height_m > 0.0 ? height_m : 0.0;
    return of->scale_height_m > 0.0 ? nph_exp(-height_m / of->scale_height_m) : nph_air_density(&of->table->profile, height_m);
}

static double top_of(const NphSky *sky, int i) {
    const NphSkyConstituent *of = &sky->of[i];
    return sky->radius_m > 0.0 ? of->table->profile.levels[of->table->profile.count - 1].height_m : 45.0 * of->scale_height_m;
}

/* By which lengths are measured; of a profile the mean one. */
static double scale_of(const NphSky *sky, int i) {
    return sky->of[i].scale_height_m > 0.0 ? sky->of[i].scale_height_m : top_of(sky, i) / 15.0;
}

/* Around a sphere a point above the table sees what is below through where its line comes in. */
static double table_column(const NphSky *sky, int i, double height_m, double rise) {
    double top = top_of(sky, i);
    NphSkyLine line = {height_m, {0.0, 0.0, rise}, nph_infinity()};
    if (height_m <= top) return nph_air_table_column(sky->of[i].table, height_m > 0.0 ? height_m : 0.0, rise);
    double enters = rise < 0.0 ? distance_to(sky, &line, top) : nph_infinity();
    if (!(enters < nph_infinity())) return 0.0;
    return nph_air_table_column(sky->of[i].table, top, ((sky->radius_m + height_m) * rise + enters) / (sky->radius_m + top));
}

void nph_sky_columns_above(const NphSky *sky, double height_m, double sun_rise, double columns_m[NPH_SKY_MOST]) {
    for (int i = 0; i < NPH_SKY_MOST; i++) {
        columns_m[i] = 0.0;
        if (i < sky->count)
            columns_m[i] = sky->radius_m > 0.0 ? table_column(sky, i, height_m, sun_rise)
                                               : nph_air_column_above(sky->of[i].scale_height_m, height_m, sun_rise);
    }
}

/* ---- along the line ---- */

typedef struct Walk {
    const NphSky *sky;
    const NphSkyLine *line;
    double t, end;
    double columns[NPH_SKY_MOST]; /* from the eye to t */
} Walk;

/* z of the direction to the vertical at t. */
static double rise_at(const Walk *walk, double t, double height_m) {
    const NphSky *sky = walk->sky;
    if (!(sky->radius_m > 0.0)) return walk->line->direction[2];
    return ((sky->radius_m + walk->line->height_m) * walk->line->direction[2] + t) / (sky->radius_m + height_m);
}

/* points: 8 for a piece, 4 from one of its points to the next. */
static double columns_between(const Walk *walk, int i, double from, double to, int points) {
    const NphSky *sky = walk->sky;
    double sum = 0.0;
    if (!(sky->radius_m > 0.0))
        return nph_air_column_between(sky->of[i].scale_height_m, nph_sky_height(sky, walk->line, from),
                                      nph_sky_height(sky, walk->line, to), to - from);
    for (int k = 0; k < points; k++) {
        double place = points == POINTS ? PLACE[k] : NEAR_PLACE[k], weight = points == POINTS ? WEIGHT[k] : NEAR_WEIGHT[k];
        sum += weight * density(sky, i, nph_sky_height(sky, walk->line, from + (to - from) * place));
    }
    return sum * (to - from);
}

/* How far the height may change by two of a scale height; around a sphere t^2 / 2R is part of the change. */
static double reach(const Walk *walk, double change_m, double rise) {
    double most = nph_abs(rise) > 0.0 ? change_m / nph_abs(rise) : nph_infinity();
    double bend = walk->sky->radius_m > 0.0 ? nph_sqrt(2.0 * change_m * walk->sky->radius_m) : nph_infinity();
    return most < bend ? most : bend;
}

/* The next piece's length. 0: nothing more comes. */
static double step(const Walk *walk) {
    const NphSky *sky = walk->sky;
    double height = nph_sky_height(sky, walk->line, walk->t), rise = rise_at(walk, walk->t, height), length = walk->end - walk->t;
    double thickest = 0.0;
    int matters = 0;
    for (int i = 0; i < sky->count; i++) {
        double largest = 0.0, scale = scale_of(sky, i), low = height + (rise < 0.0 ? -2.0 * scale : 0.0);
        for (int c = 0; c < 3; c++) largest = sky->of[i].extinction_per_m[c] > largest ? sky->of[i].extinction_per_m[c] : largest;
        double rate = largest * density(sky, i, low);
        if (!(largest * scale * density(sky, i, height) > NOTHING) && !(rise < 0.0)) continue;
        if (!(largest > 0.0)) continue;
        matters = 1;
        double most = reach(walk, 2.0 * scale, rise);
        length = most < length ? most : length;
        thickest += rate;
    }
    if (!matters) return 0.0;
    return length * thickest > 1.0 ? 1.0 / thickest : length;
}

static int is_dark(const Walk *walk) {
    for (int c = 0; c < 3; c++) {
        double depth = 0.0;
        for (int i = 0; i < walk->sky->count; i++) depth += walk->sky->of[i].extinction_per_m[c] * walk->columns[i];
        if (!(depth > OPAQUE)) return 0;
    }
    return 1;
}

/* Down from far above the air: to where it begins. */
static Walk enter(const NphSky *sky, const NphSkyLine *line) {
    Walk walk = {sky, line, 0.0, nph_sky_end(sky, line), {0.0, 0.0}};
    double top = 0.0;
    for (int i = 0; i < sky->count; i++) top = top_of(sky, i) > top ? top_of(sky, i) : top;
    if (!(line->height_m > top)) return walk;
    walk.t = line->direction[2] < 0.0 ? distance_to(sky, line, top) : nph_infinity();
    return walk;
}

void nph_sky_columns(const NphSky *sky, const NphSkyLine *line, double columns_m[NPH_SKY_MOST]) {
    Walk walk = {sky, line, 0.0, nph_sky_end(sky, line), {0.0, 0.0}};
    int endless = !(walk.end < nph_infinity());
    if (!(sky->radius_m > 0.0)) {
        for (int i = 0; i < sky->count; i++)
            columns_m[i] = endless ? nph_air_column_above(sky->of[i].scale_height_m, line->height_m, line->direction[2])
                                   : columns_between(&walk, i, 0.0, walk.end, POINTS);
        return;
    }
    walk = enter(sky, line);
    for (int n = 0; walk.t < walk.end && n < MOST_PIECES; n++) {
        double length = step(&walk);
        if (!(length > 0.0)) break;
        for (int i = 0; i < sky->count; i++) walk.columns[i] += columns_between(&walk, i, walk.t, walk.t + length, POINTS);
        walk.t = length == walk.end - walk.t ? walk.end : walk.t + length;
    }
    for (int i = 0; i < sky->count; i++) columns_m[i] = walk.columns[i];
}

/* The integrand at t; columns: from the eye. */
static void add_point(const Walk *walk, double t, double weight, const double columns[NPH_SKY_MOST], double metres[NPH_SKY_MOST][3]) {
    const NphSky *sky = walk->sky;
    const double *d = walk->line->direction, *s = sky->sun;
    double height = nph_sky_height(sky, walk->line, t), sun_rise = s[2], above[NPH_SKY_MOST];
    if (sky->radius_m > 0.0)
        sun_rise = ((sky->radius_m + walk->line->height_m) * s[2] + t * (d[0] * s[0] + d[1] * s[1] + d[2] * s[2])) / (sky->radius_m + height);
    assert(sky->count <= NPH_SKY_MOST);
    nph_sky_columns_above(sky, height, sun_rise, above);
    if (!(above[0] < nph_infinity())) return;
    for (int c = 0; c < 3; c++) {
        double depth = 0.0;
        for (int i = 0; i < sky->count; i++) depth += sky->of[i].extinction_per_m[c] * (columns[i] + above[i]);
        double arrives = weight * nph_exp(-depth);
        for (int i = 0; i < sky->count; i++) metres[i][c] += arrives * density(sky, i, height);
    }
}

void nph_sky_integrate(const NphSky *sky, const NphSkyLine *line, double metres[NPH_SKY_MOST][3]) {
    Walk walk = enter(sky, line);
    for (int i = 0; i < NPH_SKY_MOST; i++)
        for (int c = 0; c < 3; c++) metres[i][c] = 0.0;
    for (int n = 0; walk.t < walk.end && !is_dark(&walk) && n < MOST_PIECES; n++) {
        double length = step(&walk), from = walk.t, columns[NPH_SKY_MOST] = {walk.columns[0], walk.columns[1]};
        if (!(length > 0.0)) break;
        for (int k = 0; k < POINTS; k++) {
            double t = walk.t + length * PLACE[k];
            for (int i = 0; i < sky->count; i++) columns[i] += columns_between(&walk, i, from, t, 4);
            add_point(&walk, t, length * WEIGHT[k], columns, metres);
            from = t;
        }
        for (int i = 0; i < sky->count; i++) walk.columns[i] = columns[i] + columns_between(&walk, i, from, walk.t + length, 4);
        walk.t = length == walk.end - walk.t ? walk.end : walk.t + length;
    }
}
