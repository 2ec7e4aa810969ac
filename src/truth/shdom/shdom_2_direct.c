/* SPDX-License-Identifier: Apache-2.0
 *
 * shdom.direct: light of suns and points where it has not been scattered. Optical depths are exact (single_walk.h), scaled by delta-M.
 *   beam    at a point, what it scatters first: albedo chi_l w_l sum over lights of E e^-tau Y_lm along their rays, E = I / r^2 of points
 *   share   of a cell, by how much the mean of its corners is to be multiplied to be what the cell gets,
 *           mean of E e^-tau = sum over entering rays of E e^-tau_entry (1 - e^-s) dA / sum of s dA,   s: optical depth in the cell
 *           with four rays through each face that the light enters by: what a cell scatters is what the beam loses in it, however
 *           steep the shadows and however uneven the density
 *   sun     depth of density towards each sun at points; sun_mean: the same mean of e^-tau in cells. Sweeps follow suns by these.
 * Cells around a point light have their mean from rays that leave it in all directions. */
#include <assert.h>
#include <string.h>

#include "core/fmath.h"
#include "truth/shdom/shdom.h"

enum { NEAR = 2, FALL = 16, TURN = 32 }; /* cells around a point; its rays: polar angles, azimuths */
#define MOST_SHARE 1e6
#define PI 3.14159265358979323846
#define Y00 0.28209479177387814347 /* the harmonic of degree 0 */

static void to_local(const NphShdomGrid *grid, const double u[3], double p[3]) {
    for (int a = 0; a < 3; a++) {
        const double *row = grid->to_local + 4 * a;
        p[a] = row[0] * u[0] + row[1] * u[1] + row[2] * u[2] + row[3];
    }
}

/* Of point number `at` of rows, in the grid's space. */
static void place_of(const int32_t points[3], int64_t at, double u[3]) {
    int64_t row = at / points[0], plane = row / points[1];
    u[0] = (double)(at % points[0]);
    u[1] = (double)(row % points[1]);
    u[2] = (double)plane;
}

/* Just inside: a point in a side of the medium is lit as what lies behind that side is. */
static void inside(const NphShdomGrid *grid, double u[3]) {
    for (int a = 0; a < 3; a++)
        if (!grid->periodic[a]) u[a] = r_clamp(u[a], 1e-6, (double)grid->cells[a] - 1e-6);
}

static void turn_into(const NphShdomGrid *grid, const double d[3], double along[3]) {
    for (int a = 0; a < 3; a++) {
        const double *row = grid->from_local + 4 * a;
        along[a] = row[0] * d[0] + row[1] * d[1] + row[2] * d[2];
    }
}

/* The light of a beam at a place: unit vector towards the light, and its value there but for the medium, of a unit of it. */
typedef struct Beam {
    double to[3], value, distance;
} Beam;

static double edge_of(const NphShdomGrid *grid) { /* of a cell, the shortest, in metres */
    double least = 1e300;
    for (int a = 0; a < 3; a++) {
        double x = grid->to_local[a], y = grid->to_local[4 + a], z = grid->to_local[8 + a], edge = nph_sqrt(x * x + y * y + z * z);
        least = edge < least ? edge : least;
    }
    return least;
}

static Beam beam_at(const NphShdomGrid *grid, const RLight *light, const double p[3]) {
    Beam beam = {{light->direction[0], light->direction[1], light->direction[2]}, 1.0, R_HUGE};
    if (light->kind != NPH_LIGHT_POINT) return beam;
    double squared = 0.0, near = 0.25 * edge_of(grid);
    for (int a = 0; a < 3; a++) {
        beam.to[a] = light->position[a] - p[a];
        squared += beam.to[a] * beam.to[a];
    }
    beam.distance = nph_sqrt(squared);
    for (int a = 0; a < 3; a++) beam.to[a] = beam.distance > 0.0 ? beam.to[a] / beam.distance : 0.0;
    beam.value = 1.0 / (squared > near * near ? squared : near * near);
    return beam;
}

/* Of harmonics: points, and suns where cameras look for them in the grid. */
static int is_beam(const NphShdomChoice *choice, const RLight *light) {
    return light->kind == NPH_LIGHT_POINT || (light->kind == NPH_LIGHT_SUN && choice->looks);
}

/* Light l at a place of the grid: its beam, and the depth of density towards it [m], as far as anything passes. */
static Beam depth_to(const NphShdomSolver *solver, int l, const double u[3], int worker, double *depth) {
    const NphShdomChoice *choice = solver->choice;
    double p[3], moved[3] = {u[0], u[1], u[2]}, thin = 0.0;
    inside(&choice->grid, moved);
    to_local(&choice->grid, moved, p);
    Beam beam = beam_at(&choice->grid, &solver->scene->local.lights[l], p);
    for (int c = 0; c < choice->channels; c++) thin = c == 0 || choice->extinction[c] < thin ? choice->extinction[c] : thin;
    double enough = thin > 0.0 ? 800.0 / thin : 1e300;
    *depth = nph_single_depth(&solver->scene->local.media[0], p, beam.to, beam.distance, enough, &solver->walked[worker]);
    return beam;
}

/* Its light there, in all channels. */
static Beam arrives(const NphShdomSolver *solver, int l, const double u[3], int worker, double value[3]) {
    const NphShdomChoice *choice = solver->choice;
    double depth;
    assert(choice->channels <= 3);
    Beam beam = depth_to(solver, l, u, worker, &depth);
    for (int c = 0; c < choice->channels; c++)
        value[c] = solver->scene->beam[l][c] * beam.value * nph_exp(-choice->extinction[c] * depth);
    return beam;
}

/* One channel's coefficients of a beam, a block apart. */
static void add_beam(const NphShdomChoice *choice, int channel, double value, const double *y, double *row) {
    for (int l = 0; l * l < choice->angles.terms; l++)
        for (int t = l * l; t < (l + 1) * (l + 1); t++)
            row[t * NPH_SHDOM_BLOCK] += choice->albedo[channel] * choice->angles.kept[l] * value * y[t];
}

/* Depths towards each sun. */
static void sun_points(const NphShdomSolver *solver, const int64_t range[2], int worker) {
    const NphShdomChoice *choice = solver->choice;
    const NphShdomGrid *grid = &choice->grid;
    double *row = solver->rows[worker];
    size_t real = (size_t)solver->precision / 8;
    for (int n = 0; n < choice->sun_count; n++) {
        for (int64_t point = range[0]; point < range[1]; point++) {
            double u[3];
            place_of(grid->points, point, u);
            (void)depth_to(solver, choice->suns[n], u, worker, &row[point - range[0]]);
        }
        solver->kernels.store(row, range[1] - range[0], (char *)solver->sun + real * (size_t)(n * grid->point_count + range[0]));
    }
}

/* A block of points: what they scatter first. */
void nph_shdom_direct_points(NphShdomSolver *solver, int64_t block, int worker) {
    const NphShdomChoice *choice = solver->choice;
    const NphShdomGrid *grid = &choice->grid;
    const RScene *local = &solver->scene->local;
    int64_t first = block * NPH_SHDOM_BLOCK, end = first + NPH_SHDOM_BLOCK < grid->point_count ? first + NPH_SHDOM_BLOCK : grid->point_count;
    int terms = choice->angles.terms;
    double y[NPH_SHDOM_TERMS_MAX], *rows = solver->rows[worker];
    size_t real = (size_t)solver->precision / 8;
    memset(rows, 0, sizeof *rows * (size_t)choice->channels * (size_t)terms * NPH_SHDOM_BLOCK);
    for (int64_t point = first; point < end; point++) {
        double u[3];
        place_of(grid->points, point, u);
        for (int l = 0; l < local->light_count; l++) {
            double value[3];
            if (!is_beam(choice, &local->lights[l])) continue;
            Beam beam = arrives(solver, l, u, worker, value);
            double along[3] = {-beam.to[0], -beam.to[1], -beam.to[2]};
            nph_shdom_harmonics(choice->angles.bands, along, y);
            if (!(beam.distance > 0.0)) /* in the light itself it comes from everywhere */
                for (int t = 1; t < terms; t++) y[t] = 0.0;
            for (int c = 0; c < choice->channels; c++) add_beam(choice, c, value[c], y, rows + c * terms * NPH_SHDOM_BLOCK + point - first);
        }
    }
    for (int r = 0; r < choice->channels * terms; r++)
        solver->kernels.store(rows + (size_t)r * NPH_SHDOM_BLOCK, end - first,
                              (char *)solver->beam + real * (size_t)(r * grid->point_count + first));
    sun_points(solver, (int64_t[2]){first, end}, worker);
}

/* Mean of e^(-s x) over x in [0, 1]. */
static double mean_passing(double s) { return s < 1e-6 ? 1.0 - 0.5 * s : -nph_expm1(-s) / s; }

/* Where ray i of twelve enters a cell, and how far it goes there; w: its way in the grid's space, of a metre. 0: through no such face. */
static int enters_at(const int64_t cell[3], const double w[3], int i, double u[3], double *length) {
    int a = i / 4, b = (a + 1) % 3, c = (a + 2) % 3;
    double off = 0.28867513459481288;
    if (!(nph_abs(w[a]) > 0.0)) return 0;
    u[a] = (double)cell[a] + (w[a] > 0.0 ? 0.0 : 1.0);
    u[b] = (double)cell[b] + 0.5 + (i & 1 ? off : -off);
    u[c] = (double)cell[c] + 0.5 + (i & 2 ? off : -off);
    *length = 1e300;
    for (int k = 0; k < 3; k++) {
        if (!(nph_abs(w[k]) > 0.0)) continue;
        double reach = ((double)cell[k] + (w[k] > 0.0 ? 1.0 : 0.0) - u[k]) / w[k];
        *length = reach < *length ? reach : *length;
    }
    return 1;
}

/* What a cell gets of light l in the mean over its matter, from where it enters. */
static void entering(const NphShdomSolver *solver, int l, const int64_t cell[3], int worker, double mean[3]) {
    const NphShdomChoice *choice = solver->choice;
    double middle[3], p[3], w[3], sum[3] = {0.0, 0.0, 0.0}, matter = 0.0;
    for (int a = 0; a < 3; a++) middle[a] = (double)cell[a] + 0.5;
    to_local(&choice->grid, middle, p);
    Beam beam = beam_at(&choice->grid, &solver->scene->local.lights[l], p);
    double along[3] = {-beam.to[0], -beam.to[1], -beam.to[2]};
    turn_into(&choice->grid, along, w);
    for (int i = 0; i < 12; i++) {
        double u[3], length, value[3];
        if (!enters_at(cell, w, i, u, &length)) continue;
        inside(&choice->grid, u);
        to_local(&choice->grid, u, p);
        double depth = nph_single_depth(&solver->scene->local.media[0], p, along, length, 1e300, &solver->walked[worker]);
        double weight = nph_abs(w[i / 4]) * depth;
        if (!(weight > 0.0)) continue;
        arrives(solver, l, u, worker, value);
        matter += weight;
        for (int k = 0; k < choice->channels; k++) sum[k] += weight * value[k] * mean_passing(choice->extinction[k] * depth);
    }
    for (int k = 0; k < choice->channels; k++) mean[k] = matter > 0.0 ? sum[k] / matter : 0.0;
}

/* Where the light of a point comes to within a cell near it: metres on a ray from it, from near to far; 0 when it does not. */
static int crosses(const int64_t cell[3], const double from[3], const double w[3], double *near, double *far) {
    *near = 0.0;
    *far = 1e300;
    for (int a = 0; a < 3; a++) {
        double lo = (double)cell[a] - from[a], hi = lo + 1.0;
        if (!(nph_abs(w[a]) > 1e-300)) {
            if (lo > 0.0 || hi < 0.0) return 0;
            continue;
        }
        double t0 = (w[a] > 0.0 ? lo : hi) / w[a], t1 = (w[a] > 0.0 ? hi : lo) / w[a];
        *near = t0 > *near ? t0 : *near;
        *far = t1 < *far ? t1 : *far;
    }
    return *near < *far;
}

/* Means of I e^-tau / r^2 over a cell near a point: sum over its rays of e^-tau_entry (1 - e^-s) / sigma dOmega / volume. */
static void around(const NphShdomSolver *solver, int l, const int64_t cell[3], double density, int worker, double mean[3]) {
    const NphShdomChoice *choice = solver->choice;
    const NphShdomGrid *grid = &choice->grid;
    const RLight *light = &solver->scene->local.lights[l];
    const double *m = grid->to_local;
    double from[3], point[FALL], weight[FALL], p[3];
    double volume = nph_abs(m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) + m[2] * (m[4] * m[9] - m[5] * m[8]));
    for (int a = 0; a < 3; a++) p[a] = light->position[a];
    turn_into(grid, p, from);
    for (int a = 0; a < 3; a++) from[a] += grid->from_local[4 * a + 3];
    nph_shdom_gauss(FALL, point, weight);
    assert(choice->channels <= 3);
    for (int c = 0; c < 3; c++) mean[c] = 0.0;
    for (int i = 0; i < FALL * TURN; i++) {
        double z = 2.0 * point[i / TURN] - 1.0, across = nph_sqrt(1.0 - z * z), sine, cosine, w[3], near, far;
        nph_sincos2pi((i % TURN + 0.5) / TURN, &sine, &cosine);
        double d[3] = {across * cosine, across * sine, z}, dOmega = weight[i / TURN] * 4.0 * PI / TURN;
        turn_into(grid, d, w);
        if (!crosses(cell, from, w, &near, &far)) continue;
        double depth = nph_single_depth(&solver->scene->local.media[0], p, d, near, 1e300, &solver->walked[worker]);
        for (int c = 0; c < choice->channels; c++)
            mean[c] += solver->scene->beam[l][c] * dOmega / volume * nph_exp(-choice->extinction[c] * depth) *
                       (far - near) * mean_passing(choice->extinction[c] * density * (far - near));
    }
}

static int is_near(const NphShdomGrid *grid, const RLight *light, const int64_t cell[3]) {
    if (light->kind != NPH_LIGHT_POINT) return 0;
    int near = 1;
    for (int a = 0; a < 3; a++) {
        const double *row = grid->from_local + 4 * a;
        double u = row[0] * light->position[0] + row[1] * light->position[1] + row[2] * light->position[2] + row[3];
        near &= nph_abs(u - (double)cell[a] - 0.5) < (double)NEAR + 0.5;
    }
    return near;
}

/* Of the beams, from what their points scatter in degree 0. */
static void mean_of_corners(const NphShdomSolver *solver, const int64_t cell[3], double mean[3]) {
    const NphShdomChoice *choice = solver->choice;
    const NphShdomGrid *grid = &choice->grid;
    assert(choice->channels <= 3);
    for (int i = 0; i < 8; i++) {
        int64_t at[3];
        for (int a = 0; a < 3; a++) at[a] = (cell[a] + (i >> a & 1)) % grid->points[a];
        int64_t point = (at[2] * grid->points[1] + at[1]) * grid->points[0] + at[0];
        for (int c = 0; c < choice->channels; c++)
            mean[c] += 0.125 * solver->kernels.load(solver->beam, c * choice->angles.terms * grid->point_count + point);
    }
    for (int c = 0; c < choice->channels; c++) mean[c] = choice->albedo[c] > 0.0 ? mean[c] / (choice->albedo[c] * Y00) : 0.0;
}

/* Of all lights: what a cell gets, and what its corners have. */
static void share_of(const NphShdomSolver *solver, const int64_t cell[3], int worker, double share[3]) {
    const NphShdomChoice *choice = solver->choice;
    const NphShdomGrid *grid = &choice->grid;
    const RScene *local = &solver->scene->local;
    double gets[3] = {0.0, 0.0, 0.0}, corners[3] = {0.0, 0.0, 0.0};
    assert(choice->channels <= 3);
    int64_t number = (cell[2] * grid->cells[1] + cell[1]) * grid->cells[0] + cell[0];
    double density = solver->kernels.load(solver->density, number);
    for (int l = 0; l < local->light_count; l++) {
        double mean[3];
        if (!is_beam(choice, &local->lights[l])) continue;
        if (is_near(grid, &local->lights[l], cell)) around(solver, l, cell, density, worker, mean);
        else entering(solver, l, cell, worker, mean);
        for (int c = 0; c < choice->channels; c++) gets[c] += mean[c];
    }
    mean_of_corners(solver, cell, corners);
    for (int c = 0; c < choice->channels; c++) share[c] = corners[c] > 0.0 ? gets[c] / corners[c] : 0.0;
    for (int c = 0; c < choice->channels; c++) share[c] = share[c] < MOST_SHARE ? share[c] : MOST_SHARE;
}

/* Each sun's light in cells, in the mean, over what it is outside. */
static void sun_cells(const NphShdomSolver *solver, const int64_t range[2], int worker) {
    const NphShdomChoice *choice = solver->choice;
    const NphShdomGrid *grid = &choice->grid;
    double *rows = solver->rows[worker];
    size_t real = (size_t)solver->precision / 8;
    for (int n = 0; n < choice->sun_count; n++) {
        assert(choice->channels <= 3);
        for (int64_t cell = range[0]; cell < range[1]; cell++) {
            int64_t at[3] = {cell % grid->cells[0], cell / grid->cells[0] % grid->cells[1], cell / grid->cells[0] / grid->cells[1]};
            double mean[3];
            entering(solver, choice->suns[n], at, worker, mean);
            for (int c = 0; c < choice->channels; c++) {
                double whole = solver->scene->beam[choice->suns[n]][c];
                rows[c * NPH_SHDOM_BLOCK + cell - range[0]] = whole > 0.0 ? mean[c] / whole : 0.0;
            }
        }
        for (int c = 0; c < choice->channels; c++)
            solver->kernels.store(rows + c * NPH_SHDOM_BLOCK, range[1] - range[0],
                                  (char *)solver->sun_mean + real * (size_t)((n * choice->channels + c) * grid->cell_count + range[0]));
    }
}

void nph_shdom_direct_cells(NphShdomSolver *solver, int64_t block, int worker) {
    const NphShdomChoice *choice = solver->choice;
    const NphShdomGrid *grid = &choice->grid;
    int64_t first = block * NPH_SHDOM_BLOCK, end = first + NPH_SHDOM_BLOCK < grid->cell_count ? first + NPH_SHDOM_BLOCK : grid->cell_count;
    double *rows = solver->rows[worker];
    size_t real = (size_t)solver->precision / 8;
    for (int64_t cell = first; cell < end; cell++) {
        int64_t at[3] = {cell % grid->cells[0], cell / grid->cells[0] % grid->cells[1], cell / grid->cells[0] / grid->cells[1]};
        double share[3];
        share_of(solver, at, worker, share);
        for (int c = 0; c < choice->channels; c++) rows[c * NPH_SHDOM_BLOCK + cell - first] = share[c];
    }
    for (int c = 0; c < choice->channels; c++)
        solver->kernels.store(rows + c * NPH_SHDOM_BLOCK, end - first, (char *)solver->share + real * (size_t)(c * grid->cell_count + first));
    sun_cells(solver, (int64_t[2]){first, end}, worker);
}

/* The mean over each ordinate's part of the sphere: no power is lost, whatever the map. The ordinate's light travels away from it. */
static void add_map(const NphShdomAngles *angles, const REnvironment *map, int channels, double *border) {
    int ordinates = nph_shdom_ordinates(angles), parts = 1 + 512 / (map->width < map->height ? map->width : map->height);
    parts = parts < 32 ? parts : 32;
    for (int64_t i = 0; i < (int64_t)map->width * map->height; i++) {
        int row = (int)(i / map->width), column = (int)(i % map->width);
        double radiance[3], top = nph_cos(PI * row / map->height), low = nph_cos(PI * (row + 1) / map->height);
        r_environment_texel(map, row, column, radiance);
        if (!(radiance[0] + radiance[1] + radiance[2] > 0.0)) continue;
        for (int k = 0; k < parts * parts; k++) {
            int down = k / parts, right = k % parts;
            double z = top + (low - top) * (down + 0.5) / parts, across = nph_sqrt(1.0 - z * z), sine, cosine, unused[3];
            nph_sincos2pi(0.5 - (column + (right + 0.5) / parts) / map->width + map->turns, &sine, &cosine);
            double d[3] = {-across * cosine, -across * sine, -z}, dOmega = 2.0 * PI * (top - low) / map->width / (parts * parts);
            int ordinate = nph_shdom_ordinate_of(angles, d);
            double solid = nph_shdom_ordinate(angles, ordinate, unused);
            for (int c = 0; c < channels && c < 3; c++) border[c * ordinates + ordinate] += radiance[c] * dOmega / solid;
        }
    }
}

void nph_shdom_border(NphShdomSolver *solver, double *border) {
    const NphShdomAngles *angles = &solver->choice->angles;
    const RScene *local = &solver->scene->local;
    int ordinates = nph_shdom_ordinates(angles), channels = solver->choice->channels;
    memset(border, 0, sizeof *border * (size_t)(channels * ordinates));
    for (int l = 0; l < local->light_count; l++) {
        const RLight *light = &local->lights[l];
        if (light->kind == NPH_LIGHT_ENVIRONMENT) add_map(angles, &light->map, channels, border);
        for (int o = 0; o < ordinates && light->kind == NPH_LIGHT_CONSTANT; o++) {
            double d[3];
            nph_shdom_ordinate(angles, o, d);
            int seen = light->hemisphere == 0 || -d[2] * light->hemisphere > 0.0;
            for (int c = 0; c < channels; c++) border[c * ordinates + o] += seen ? light->value[c] : 0.0;
        }
    }
}
