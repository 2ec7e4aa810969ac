/* SPDX-License-Identifier: Apache-2.0
 *
 * Columns of a spherical atmosphere: by quadrature, and from a table of them.
 *
 * At distance s along a direction of sine m from the radius r the height rises by (s^2 + 2 r m s) / (r(s) + r),
 * r(s)^2 = r^2 + s^2 + 2 r m s, which does not cancel. A way that leads down passes its lowest point at the height t and is
 * level there:  column(h, -m) = 2 column(t, 0) - column(h, m).  So ways that lead up or are level are all there is to
 * integrate; the logarithm of their column is a smooth function, nearly linear in the height, and that is what the table holds. */
#include <string.h>

#include "core/fmath.h"
#include "core/memory.h"
#include "core/message.h"
#include "optics/air.h"

static const double TOP_SCALE_HEIGHTS = 15.0;

/* Gauss and Legendre's rule of 8 points on [0, 1]; the other half mirrors it. */
static const double PLACE[4] = {0.40828267875217511, 0.23723379504183550, 0.10166676129318664, 0.019855071751231912};
static const double WEIGHT[4] = {0.18134189168918100, 0.15685332293894363, 0.11119051722668724, 0.050614268145188129};

/* ---- profiles ---- */

static NphStatus new_profile(NphContext *context, int64_t count, double radius_m, NphAirProfile *profile) {
    NphAirProfile made = {radius_m, (int)count, NULL};
    NPH_TRY(NPH_NEW(context, count, "profile of the air", &made.levels));
    *profile = made;
    return NPH_OK;
}

NphStatus nph_air_profile_exponential(NphContext *context, double scale_height_m, double radius_m, NphAirProfile *profile) {
    NPH_TRY(new_profile(context, 2, radius_m, profile));
    profile->levels[0] = (NphAirLevel){0.0, 1.0};
    profile->levels[1] = (NphAirLevel){TOP_SCALE_HEIGHTS * scale_height_m, nph_exp(-TOP_SCALE_HEIGHTS)};
    return NPH_OK;
}

NphStatus nph_air_profile_from_rows(NphContext *context, const NphArray *rows, double radius_m, NphAirProfile *profile) {
    const double *row = rows->data;
    NPH_TRY(new_profile(context, rows->shape[0], radius_m, profile));
    for (int i = 0; i < profile->count; i++) profile->levels[i] = (NphAirLevel){row[2 * i], row[2 * i + 1] / row[1]};
    return NPH_OK;
}

void nph_air_profile_free(NphContext *context, NphAirProfile *profile) {
    nph_free(context, profile->levels);
    *profile = (NphAirProfile){0};
}

/* The interval a height lies in: that above level i; the last one goes on without end. */
static int interval_of(const NphAirProfile *profile, double height_m) {
    int low = 0, high = profile->count - 1;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (profile->levels[middle].height_m <= height_m) low = middle;
        else high = middle;
    }
    return low;
}

static double scale_height(const NphAirLevel *level) {
    return (level[1].height_m - level[0].height_m) / nph_log(level[0].density / level[1].density);
}

static double density_above(const NphAirLevel *level, double scale_height_m, double height_m) {
    return level->density * nph_exp((level->height_m - height_m) / scale_height_m);
}

double nph_air_density(const NphAirProfile *profile, double height_m) {
    const NphAirLevel *level = &profile->levels[interval_of(profile, height_m)];
    return density_above(level, scale_height(level), height_m);
}

/* ---- quadrature ---- */

/* A way that leads up or is level. */
typedef struct Way {
    double radius_m, height_m; /* where it begins: from the middle of the sphere, above ground */
    double sine;
} Way;

/* How far one has gone that far above its beginning. */
static double distance_at(const Way *way, double rise_m) {
    double run = rise_m * (2.0 * way->radius_m + rise_m), straight = way->radius_m * way->sine;
    double denominator = straight + nph_sqrt(straight * straight + run);
    return denominator > 0.0 ? run / denominator : 0.0;
}

static double height_at(const Way *way, double distance_m) {
    double run = distance_m * (distance_m + 2.0 * way->radius_m * way->sine);
    return way->height_m + run / (nph_sqrt(way->radius_m * way->radius_m + run) + way->radius_m);
}

/* The column between two distances, within one interval. */
static double piece(const Way *way, const NphAirLevel *level, double scale_height_m, double begin_m, double end_m) {
    double sum = 0.0, length = end_m - begin_m;
    for (int i = 0; i < 4; i++) {
        double low = height_at(way, begin_m + length * PLACE[i]), high = height_at(way, end_m - length * PLACE[i]);
        sum += WEIGHT[i] * (density_above(level, scale_height_m, low) + density_above(level, scale_height_m, high));
    }
    return sum * length;
}

/* Pieces that rise by at most a scale height and end at levels, until one above the last level adds nothing. */
static double column_outwards(const NphAirProfile *profile, double height_m, double sine) {
    Way way = {profile->radius_m + height_m, height_m, sine};
    int last = profile->count - 2, k = interval_of(profile, height_m);
    double sum = 0.0, at = height_m, from = 0.0;
    for (;;) {
        const NphAirLevel *level = &profile->levels[k];
        double scale = scale_height(level), to = at + scale;
        int ends = k < last && to >= level[1].height_m;
        if (ends) to = level[1].height_m;
        double until = distance_at(&way, to - height_m), more = piece(&way, level, scale, from, until);
        sum += more;
        if (k == last && !(more > 1e-17 * sum)) return sum;
        at = to;
        from = until;
        k += ends;
    }
}

/* h - (r + h)(1 - cos): the height of the lowest point of a way that leads down. */
static double lowest_height(const NphAirProfile *profile, double height_m, double sine) {
    double cosine = nph_sqrt((1.0 - sine) * (1.0 + sine));
    return height_m - (profile->radius_m + height_m) * (sine * sine / (1.0 + cosine));
}

double nph_air_column_curved(const NphAirProfile *profile, double height_m, double sine) {
    if (sine >= 0.0) return column_outwards(profile, height_m, sine);
    double lowest = lowest_height(profile, height_m, sine);
    if (!(lowest >= 0.0)) return nph_infinity();
    return 2.0 * column_outwards(profile, lowest, 0.0) - column_outwards(profile, height_m, -sine);
}

/* ---- the table ---- */

NphStatus nph_air_table_build(NphContext *context, NphAirProfile *profile, NphAirTable *table) {
    NphAirTable made = {*profile, NULL};
    memset(profile, 0, sizeof *profile);
    NphStatus status = NPH_NEW(context, NPH_AIR_HEIGHTS * NPH_AIR_SINES, "table of the air", &made.log_column);
    if (status != NPH_OK) {
        nph_air_table_free(context, &made);
        return status;
    }
    double top = made.profile.levels[made.profile.count - 1].height_m;
    for (int h = 0; h < NPH_AIR_HEIGHTS; h++) {
        double height = top * h / (NPH_AIR_HEIGHTS - 1);
        for (int u = 0; u < NPH_AIR_SINES; u++) {
            double root = (double)u / (NPH_AIR_SINES - 1);
            made.log_column[h * NPH_AIR_SINES + u] = nph_log(column_outwards(&made.profile, height, root * root));
        }
    }
    *table = made;
    return NPH_OK;
}

void nph_air_table_free(NphContext *context, NphAirTable *table) {
    nph_air_profile_free(context, &table->profile);
    nph_free(context, table->log_column);
    table->log_column = NULL;
}

/* Lagrange's polynomial through the four nodes around a place: the first of them, and their weights. */
static int four_around(double place, int count, double weight[4]) {
    int first = (int)place - 1;
    first = first < 0 ? 0 : first > count - 4 ? count - 4 : first;
    double t = place - first;
    weight[0] = (t - 1.0) * (t - 2.0) * (t - 3.0) / -6.0;
    weight[1] = t * (t - 2.0) * (t - 3.0) / 2.0;
    weight[2] = t * (t - 1.0) * (t - 3.0) / -2.0;
    weight[3] = t * (t - 1.0) * (t - 2.0) / 6.0;
    return first;
}

static double looked_up(const NphAirTable *table, double height_m, double sine) {
    const NphAirProfile *profile = &table->profile;
    double top = profile->levels[profile->count - 1].height_m, along[4], across[4], sum = 0.0;
    int h = four_around(height_m / top * (NPH_AIR_HEIGHTS - 1), NPH_AIR_HEIGHTS, along);
    int u = four_around(nph_sqrt(sine) * (NPH_AIR_SINES - 1), NPH_AIR_SINES, across);
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) sum += along[i] * across[j] * table->log_column[(h + i) * NPH_AIR_SINES + u + j];
    return nph_exp(sum);
}

double nph_air_table_column(const NphAirTable *table, double height_m, double sine) {
    if (sine >= 0.0) return looked_up(table, height_m, sine);
    double lowest = lowest_height(&table->profile, height_m, sine);
    if (!(lowest >= 0.0)) return nph_infinity();
    return 2.0 * looked_up(table, lowest, 0.0) - looked_up(table, height_m, -sine);
}
