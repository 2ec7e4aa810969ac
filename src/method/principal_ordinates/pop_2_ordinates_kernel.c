/* SPDX-License-Identifier: Apache-2.0
 *
 * pop.ordinates [Elek14 sec. 5.1, 5.2]. Every sun is one. The rest of the sky, maps and constant lights, is cut into as many regions of
 * equal weight as there are ordinates, by halving rectangles of texels across their longer side; weight is luminance times solid
 * angle, times importance where there is that map. A region's ordinate
 *   drawn     is one of its texels, drawn by weight: radiance of the texel times weight of the region over that of the texel per
 *             solid angle, so the sum over many draws is the sky's
 *   regions   is the mean direction of its light, and has all of it
 * A rectangle that cannot be halved is one ordinate, however many it was to become: the others stay dark.
 *
 * Prefiltering: the mean cosine of the light that an ordinate stands for. With w = N Omega / 4 pi
 *   cap       1 - Omega / 4 pi, to the power beta: exact for a cap and beta 1. In print (1 - w / N)^beta too, but w is the importance
 *             of the ordinate: read as its density over the largest of all
 *   exact     the mean over the region, by luminance
 *
 * Points stand in the scene: place and intensity. */
#include "method/principal_ordinates/pop_state.h"

void NPH_KERNEL(nph_pop_ordinates)(const NphJob *job, const void *memory, const void *importance, double *texels, void *ordinate);
int NPH_KERNEL(nph_pop_iterations)(const void *memory, const void *ordinate);

enum { CONSTANT_WIDTH = 64, CONSTANT_HEIGHT = 32 };

/* A light's texels, and their weights summed from the corner: sums[(row) * (width + 1) + column]. */
typedef struct Sky {
    const RPopScene *scene;
    const NphLight *light;
    const Real *importance; /* or NULL */
    double least;           /* importance of directions that have none */
    int width, height;
    double *sums;
    Real *rows;             /* of ordinates, from the next one on */
    double *density;        /* of them: importance, in print */
    int room;
    const NphJob *job;
    int first;              /* number of the next one */
} Sky;

static void texel_bounds(const Sky *sky, int row, double *above, double *below) {
    double unused;
    nph_sincos2pi(0.5 * (double)row / (double)sky->height, &unused, above);
    nph_sincos2pi(0.5 * (double)(row + 1) / (double)sky->height, &unused, below);
}

/* Solid angle, and the direction towards its middle. */
static double texel(const Sky *sky, int row, int column, double d[3]) {
    double above, below, middle, top, sine, cosine, turns = sky->light->kind == NPH_LIGHT_ENVIRONMENT ? sky->light->rotation_rad * 0.15915494309189535 : 0.0;
    texel_bounds(sky, row, &above, &below);
    nph_sincos2pi(0.5 * ((double)row + 0.5) / (double)sky->height, &middle, &top);
    nph_sincos2pi(0.5 - ((double)column + 0.5) / (double)sky->width + turns, &sine, &cosine);
    d[0] = middle * cosine;
    d[1] = middle * sine;
    d[2] = top;
    return 6.283185307179586 * (above - below) / (double)sky->width;
}

static void radiance_of(const Sky *sky, int row, int column, const double d[3], double out[3]) {
    const NphLight *light = sky->light;
    int seen = light->hemisphere == 0 || d[2] * (double)light->hemisphere > 0.0;
    for (int c = 0; c < 3; c++)
        out[c] = light->kind == NPH_LIGHT_ENVIRONMENT ? (double)light->map.radiance[3 * ((int64_t)row * light->map.width + column) + c]
                 : seen                               ? light->radiance[c]
                                                      : 0.0;
}

static double luminance_of(const double c[3]) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; }

/* Weight over solid angle. */
static double weight_of(const Sky *sky, const double d[3], const double radiance[3]) {
    double factor = 1.0;
    if (sky->importance) {
        double polar = nph_acos(d[2] > 1.0 ? 1.0 : d[2] < -1.0 ? -1.0 : d[2]) * 0.31830988618379067;
        double u = 0.5 - nph_atan2(d[1], d[0]) * 0.15915494309189535;
        int row = (int)(polar * NPH_POP_MAP_HEIGHT), column = (int)((u - nph_floor(u)) * NPH_POP_MAP_WIDTH);
        row = row < NPH_POP_MAP_HEIGHT ? row : NPH_POP_MAP_HEIGHT - 1;
        column = column < NPH_POP_MAP_WIDTH ? column : NPH_POP_MAP_WIDTH - 1;
        factor = sky->least + (double)sky->importance[row * NPH_POP_MAP_WIDTH + column];
    }
    return factor * luminance_of(radiance);
}

static void sum_texels(Sky *sky) {
    int line = sky->width + 1;
    for (int column = 0; column <= sky->width; column++) sky->sums[column] = 0.0;
    for (int row = 0; row < sky->height; row++) {
        double sum = 0.0;
        sky->sums[(row + 1) * line] = 0.0;
        for (int column = 0; column < sky->width; column++) {
            double d[3], radiance[3], solid = texel(sky, row, column, d);
            radiance_of(sky, row, column, d, radiance);
            sum += solid * weight_of(sky, d, radiance);
            sky->sums[(row + 1) * line + column + 1] = sky->sums[row * line + column + 1] + sum;
        }
    }
}

/* A rectangle of texels: rows [0], [1], columns [2], [3]. */
static double weight_in(const Sky *sky, const int r[4]) {
    int line = sky->width + 1;
    double whole = sky->sums[r[1] * line + r[3]] - sky->sums[r[0] * line + r[3]], left = sky->sums[r[1] * line + r[2]] - sky->sums[r[0] * line + r[2]];
    return whole > left ? whole - left : 0.0;
}

/* What a region's light is in all. */
typedef struct Region {
    double light[3], solid, towards[3], weight;
} Region;

static void sum_region(const Sky *sky, const int r[4], Region *out) {
    *out = (Region){{0.0}, 0.0, {0.0}, 0.0};
    for (int row = r[0]; row < r[1]; row++)
        for (int column = r[2]; column < r[3]; column++) {
            double d[3], radiance[3], solid = texel(sky, row, column, d);
            radiance_of(sky, row, column, d, radiance);
            out->solid += solid;
            out->weight += solid * weight_of(sky, d, radiance);
            for (int c = 0; c < 3; c++) out->light[c] += solid * radiance[c];
            for (int a = 0; a < 3; a++) out->towards[a] += solid * luminance_of(radiance) * d[a];
        }
}

/* A texel of the region, drawn by weight; its direction and what its light stands for. */
static void draw(const Sky *sky, const int r[4], const Region *region, double u, double d[3], double light[3], double *density) {
    double sum = 0.0, least = u * region->weight;
    for (int row = r[0]; row < r[1]; row++)
        for (int column = r[2]; column < r[3]; column++) {
            double way[3], radiance[3], solid = texel(sky, row, column, way), weight;
            radiance_of(sky, row, column, way, radiance);
            weight = weight_of(sky, way, radiance);
            if (!(weight > 0.0)) continue;
            sum += solid * weight;
            for (int a = 0; a < 3; a++) d[a] = way[a];
            for (int c = 0; c < 3; c++) light[c] = radiance[c] * region->weight / weight;
            *density = weight;
            if (sum > least) return;
        }
}

static double exact_cosine(const Sky *sky, const int r[4], const double d[3]) {
    double sum = 0.0, weight = 0.0;
    for (int row = r[0]; row < r[1]; row++)
        for (int column = r[2]; column < r[3]; column++) {
            double way[3], radiance[3], solid = texel(sky, row, column, way);
            radiance_of(sky, row, column, way, radiance);
            sum += solid * luminance_of(radiance) * (way[0] * d[0] + way[1] * d[1] + way[2] * d[2]);
            weight += solid * luminance_of(radiance);
        }
    return weight > 0.0 ? sum / weight : 0.0;
}

static void put_ordinate(Sky *sky, const int r[4]) {
    const RPopScene *scene = sky->scene;
    Region region;
    double d[3] = {0.0, 0.0, 1.0}, light[3] = {0.0, 0.0, 0.0}, density = 0.0, length = 0.0, solid, cosine = 1.0;
    sum_region(sky, r, &region);
    if (sky->room == 0) return;
    if (!(region.weight > 0.0)) return;
    NphWords words = nph_philox(sky->job->seed, (uint32_t)NPH_RNG_POP_ORDINATE << 24 | (sky->job->frame & 0xffffffu), (uint32_t)sky->first, 0, 0, 0);
    draw(sky, r, &region, nph_uniform(words.w0), d, light, &density);
    solid = region.weight / density;
    for (int a = 0; a < 3; a++) length += region.towards[a] * region.towards[a];
    length = nph_sqrt(length);
    if (scene->regions && length > 1e-9 * luminance_of(region.light)) {
        for (int a = 0; a < 3; a++) d[a] = region.towards[a] / length;
        for (int c = 0; c < 3; c++) light[c] = region.light[c];
        solid = region.solid;
    }
    solid = solid < 12.566370614359172 ? solid : 12.566370614359172;
    if (scene->prefilter == NPH_POP_PREFILTER_CAP) cosine = 1.0 - solid * 0.079577471545947668;
    if (scene->prefilter == NPH_POP_PREFILTER_EXACT) cosine = exact_cosine(sky, r, d);
    for (int a = 0; a < 3; a++) {
        sky->rows[NPH_POP_WAY + a] = (Real)-d[a];
        sky->rows[NPH_POP_VALUE + a] = (Real)light[a];
    }
    if (scene->prefilter == NPH_POP_PREFILTER_CAP && scene->beta != R(1.0)) cosine = cosine > 0.0 ? nph_exp((double)scene->beta * nph_log(cosine)) : 0.0;
    sky->rows[NPH_POP_COSINE] = (Real)cosine;
    sky->rows[NPH_POP_SOLID_ANGLE] = (Real)solid;
    *sky->density++ = density;
    sky->rows += NPH_POP_ROW;
    sky->room--;
    sky->first++;
}

/* Halves the rectangle where its weight is, across its longer side. Depth: at most log2 of all texels, and of the ordinates. */
static void cut(Sky *sky, const int r[4], int ordinates) {
    int tall = r[1] - r[0], wide = r[3] - r[2], lower[4] = {r[0], r[1], r[2], r[3]}, upper[4] = {r[0], r[1], r[2], r[3]};
    double sine, unused, all = weight_in(sky, r);
    if (ordinates <= 1 || (tall == 1 && wide == 1)) {
        put_ordinate(sky, r);
        return;
    }
    nph_sincos2pi(0.25 * (double)(r[0] + r[1]) / (double)sky->height, &sine, &unused);
    int across = wide > 1 && (tall == 1 || 2.0 * (double)wide * sine / (double)sky->width >= (double)tall / (double)sky->height);
    int begin = across ? r[2] : r[0], end = across ? r[3] : r[1], low = begin + 1, high = end - 1;
    int half = ordinates / 2;
    double wanted = (double)half / (double)ordinates;
    while (low < high) { /* the last place before which there is not more than that */
        int middle = (low + high + 1) / 2;
        lower[across ? 3 : 1] = middle;
        if (weight_in(sky, lower) > wanted * all) high = middle - 1;
        else low = middle;
    }
    lower[across ? 3 : 1] = upper[across ? 2 : 0] = low;
    double part = all > 0.0 ? weight_in(sky, lower) / all : 0.5;
    int share = (int)((double)ordinates * part + 0.5);
    share = share < 1 ? 1 : share > ordinates - 1 ? ordinates - 1 : share;
    if (!(weight_in(sky, lower) > 0.0)) cut(sky, upper, ordinates);
    else if (!(weight_in(sky, upper) > 0.0)) cut(sky, lower, ordinates);
    else {
        cut(sky, lower, share);
        cut(sky, upper, ordinates - share);
    }
}

static Sky sky_of(const NphJob *job, const RPopScene *scene, const NphLight *light, const Real *importance, double *texels) {
    Sky sky = {.scene = scene, .light = light, .importance = importance, .width = CONSTANT_WIDTH, .height = CONSTANT_HEIGHT, .sums = texels, .job = job};
    double sum = 0.0;
    if (light->kind == NPH_LIGHT_ENVIRONMENT) {
        sky.width = light->map.width;
        sky.height = light->map.height;
    }
    for (int i = 0; importance && i < NPH_POP_MAP_WIDTH * NPH_POP_MAP_HEIGHT; i++) sum += (double)importance[i];
    sky.least = importance ? 0.01 * sum / (NPH_POP_MAP_WIDTH * NPH_POP_MAP_HEIGHT) + 1e-30 : 0.0;
    sum_texels(&sky);
    return sky;
}

static int is_sky(const NphLight *light) {
    double most = light->radiance[0] + light->radiance[1] + light->radiance[2];
    return light->kind == NPH_LIGHT_ENVIRONMENT ? light->map.total > 0.0 : light->kind == NPH_LIGHT_CONSTANT && most > 0.0;
}

static void put_sun(const RPopScene *scene, const NphLight *light, Real *row) {
    double sine = nph_sin(0.5 * light->half_angle_rad), width = 2.0 * sine * sine;
    for (int a = 0; a < 3; a++) {
        row[NPH_POP_WAY + a] = (Real)-light->direction[a];
        row[NPH_POP_VALUE + a] = (Real)light->irradiance[a];
    }
    row[NPH_POP_COSINE] = (Real)(scene->prefilter == NPH_POP_PREFILTER_NONE ? 1.0 : 1.0 - 0.5 * width);
    row[NPH_POP_SOLID_ANGLE] = (Real)(6.283185307179586 * width);
}

static void put_point(const RPopScene *scene, const NphLight *light, Real *row) {
    for (int a = 0; a < 3; a++) {
        row[NPH_POP_WAY + a] = (Real)(light->position[a] - scene->local.origin[a]);
        row[NPH_POP_VALUE + a] = (Real)light->intensity[a];
    }
    row[NPH_POP_COSINE] = R(1.0);
    row[NPH_POP_SOLID_ANGLE] = R(0.0);
}

/* In print: the density of an ordinate over the largest, in place of what it stands for. */
static void print_cosines(const RPopScene *scene, const double *density, Real *rows) {
    int count = scene->choice.sky;
    double most = 0.0;
    for (int i = 0; i < count; i++) most = density[i] > most ? density[i] : most;
    for (int i = 0; i < count && most > 0.0; i++) {
        double a = 1.0 - density[i] / most / (double)count;
        rows[i * NPH_POP_ROW + NPH_POP_COSINE] = (Real)(a > 0.0 ? nph_exp((double)scene->beta * nph_log(a)) : 0.0);
    }
}

static void put_sky(const NphJob *job, const RPopScene *scene, const Real *importance, double *texels, Real *rows) {
    const NphScene *from = job->scene;
    double weights[NPH_MAX_LIGHTS], density[NPH_POP_ORDINATES_MAX + NPH_MAX_LIGHTS] = {0.0}, all = 0.0;
    int lights = 0, left = scene->choice.sky, first = scene->choice.suns;
    double *at = density;
    for (int l = 0; l < from->light_count; l++) {
        weights[l] = 0.0;
        if (!is_sky(&from->lights[l])) continue;
        Sky sky = sky_of(job, scene, &from->lights[l], importance, texels);
        all += weights[l] = weight_in(&sky, (int[]){0, sky.height, 0, sky.width});
        lights++;
    }
    for (int l = 0; l < from->light_count; l++) {
        if (!is_sky(&from->lights[l])) continue;
        int ordinates = all > 0.0 ? (int)((double)scene->choice.sky * weights[l] / all + 0.5) : 1;
        lights--; /* at least one for each that follows */
        ordinates = ordinates < 1 ? 1 : ordinates > left - lights ? left - lights : ordinates;
        if (lights == 0) ordinates = left;
        left -= ordinates;
        Sky sky = sky_of(job, scene, &from->lights[l], importance, texels);
        sky.rows = rows;
        sky.density = at;
        sky.room = ordinates;
        sky.first = first;
        cut(&sky, (int[]){0, sky.height, 0, sky.width}, ordinates);
        rows += (int64_t)ordinates * NPH_POP_ROW;
        at += ordinates;
        first += ordinates;
    }
    if (scene->paper && scene->prefilter == NPH_POP_PREFILTER_CAP) print_cosines(scene, density, rows - (int64_t)scene->choice.sky * NPH_POP_ROW);
}

void NPH_KERNEL(nph_pop_ordinates)(const NphJob *job, const void *memory, const void *importance, double *texels, void *ordinate) {
    const RPopScene *scene = memory;
    const NphPopChoice *choice = &scene->choice;
    const NphScene *from = job->scene;
    Real *rows = ordinate, *sun = rows, *point = rows + (int64_t)(choice->suns + choice->sky) * NPH_POP_ROW;
    for (int64_t i = 0; i < (int64_t)nph_pop_grids(choice) * NPH_POP_ROW; i++) rows[i] = R(0.0);
    for (int n = 0; n < nph_pop_grids(choice); n++) {
        rows[n * NPH_POP_ROW + NPH_POP_WAY + 2] = R(-1.0); /* dark ones: any direction */
        rows[n * NPH_POP_ROW + NPH_POP_COSINE] = R(1.0);
    }
    for (int l = 0; l < from->light_count; l++) {
        double sum = 0.0;
        const NphLight *light = &from->lights[l];
        for (int c = 0; c < 3; c++) sum += light->kind == NPH_LIGHT_SUN ? light->irradiance[c] : light->kind == NPH_LIGHT_POINT ? light->intensity[c] : 0.0;
        if (!(sum > 0.0)) continue;
        if (light->kind == NPH_LIGHT_SUN) {
            put_sun(scene, light, sun);
            sun += NPH_POP_ROW;
        } else {
            put_point(scene, light, point);
            point += NPH_POP_ROW;
        }
    }
    if (choice->sky > 0) put_sky(job, scene, choice->importance ? importance : NULL, texels, rows + (int64_t)choice->suns * NPH_POP_ROW);
}

/* The number after which the light's mean cosine has fallen to epsilon_a [Elek14 eq. 10]: ln(a / epsilon_a) / ((1 - g) s_s d), in print
 * with -ln g for 1 - g; at least the cells along a grid. s_s is the mean over the medium, d the mean edge of a cell. */
int NPH_KERNEL(nph_pop_iterations)(const void *memory, const void *ordinate) {
    const RPopScene *scene = memory;
    const NphPopChoice *choice = &scene->choice;
    const Real *rows = ordinate;
    double most = 0.0, edge = 0.0, scatters = 0.0;
    int directions = choice->suns + choice->sky, least = choice->flat[2];
    if (choice->points > 0 && (choice->radial[2] > least || directions == 0)) least = choice->radial[2];
    if (choice->vpls > 0 && choice->vpl[2] > least) least = choice->vpl[2];
    for (int n = 0; n < directions; n++) {
        RPopGrid grid = r_pop_grid(scene, rows + (int64_t)n * NPH_POP_ROW, n);
        double cosine = (double)rows[n * NPH_POP_ROW + NPH_POP_COSINE];
        most = cosine > most ? cosine : most;
        for (int a = 0; a < 3; a++) edge += (double)grid.edge[a] / (3.0 * directions);
    }
    for (int c = 0; c < 3; c++) scatters += (double)scene->sigma_s[c] * choice->mean_density / 3.0;
    double g = (double)scene->g, rate = scene->paper ? -nph_log(nph_abs(g) > 1e-30 ? nph_abs(g) : 1e-30) : 1.0 - g;
    double needed = directions > 0 && most > (double)scene->epsilon_a ? nph_log(most / (double)scene->epsilon_a) / (rate * scatters * edge) : 0.0;
    if (!(needed < NPH_POP_ITERATIONS_MAX)) needed = NPH_POP_ITERATIONS_MAX;
    return (int)needed + 1 > least ? (int)needed + 1 : least;
}
