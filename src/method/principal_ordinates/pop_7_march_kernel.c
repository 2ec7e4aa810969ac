/* SPDX-License-Identifier: Apache-2.0
 *
 * pop.march [Elek14 sec. 4.4]. Along a ray in steps of the box's diagonal over a number, front to back, per channel:
 *   L += T a (1 - e^(-s_t step)) J,   T *= e^(-s_t step)
 * J is what was merged: the light scattered to the observer, over s_s. The density is that of a step's middle. What is behind joins: the sky,
 * or a surface. That reflects what the grids' lights bring it, behind media and surfaces: of suns, ordinates and points one a sample,
 * of virtual point lights another, drawn by what they would bring without those. */
#include <stdio.h>

#include "method/principal_ordinates/pop_surface.h"

void NPH_KERNEL(nph_pop_march)(const void *memory, const NphPopArrays *arrays, const int rect[4], int64_t chunk, void *samples, int64_t *steps);
void NPH_KERNEL(nph_pop_replay)(const void *memory, const NphPopArrays *arrays, const int pixel[2], uint32_t sample, NphLineFn line, void *user);

enum { LANES = 64 };

/* Rays on their way; lanes without one begin as zeros and take part in the arithmetic. */
typedef struct Lanes {
    Real o[3][LANES], d[3][LANES], near[LANES], far[LANES]; /* in the medium's space */
    Real T[3][LANES], light[3][LANES], collided[LANES], distance[LANES], start[LANES];
    Real p[3][LANES], t[LANES], length[LANES], density[LANES];
    int32_t step[LANES], looks[LANES], through[LANES], first[LANES], more[3][LANES];
    Real part[3][LANES], J[3][LANES];
    Real way[3][LANES], pdf[LANES];
    Real *out[LANES]; /* fields are Sight.between apart */
    RMet met[LANES];  /* where there are surfaces; surface -1: none */
    uint32_t pixel[LANES], sample[LANES];
} Lanes;

typedef struct March {
    Real step, lo[3], hi[3], sigma[3], albedo[3];
    const float *majorant;
    int32_t majorants[3];
    Real majorants_per_unit;
    RPopBox cells; /* those of J */
} March;

typedef struct Sight {
    const RPopScene *scene;
    const NphPopArrays *arrays;
    const Real *values; /* J */
    March march;
    int alive, between, surfaces, grey;
    int64_t steps;
    NphLineFn line;
    void *user;
    Lanes lanes;
} Sight;

/* Every ray to its next step, or to where density may be: an empty cell of the majorant tells how many around it are empty. */
R_OUTLINE void advance(Lanes *restrict l, const March *restrict from, const float *restrict majorant, int alive) {
    const March m = *from;
    int count = r_whole_vectors(alive);
    for (int i = 0; i < count; i++) { /* vec */
        Real begin = l->near[i] + (Real)l->step[i] * m.step, end = r_min(begin + m.step, l->far[i]), t = R(0.5) * (begin + end);
        int32_t on = begin < end ? 1 : 0;
        Real x = r_min(r_max(l->o[0][i] + t * l->d[0][i], m.lo[0]), m.hi[0]), y = r_min(r_max(l->o[1][i] + t * l->d[1][i], m.lo[1]), m.hi[1]);
        Real z = r_min(r_max(l->o[2][i] + t * l->d[2][i], m.lo[2]), m.hi[2]);
        int32_t c0 = (int32_t)(x * m.majorants_per_unit), c1 = (int32_t)(y * m.majorants_per_unit), c2 = (int32_t)(z * m.majorants_per_unit);
        c0 = c0 < m.majorants[0] ? c0 : m.majorants[0] - 1;
        c1 = c1 < m.majorants[1] ? c1 : m.majorants[1] - 1;
        c2 = c2 < m.majorants[2] ? c2 : m.majorants[2] - 1;
        Real around = (Real)-majorant[(c2 * m.majorants[1] + c1) * m.majorants[0] + c0];
        Real speed = r_max(r_abs(l->d[0][i]), r_max(r_abs(l->d[1][i]), r_abs(l->d[2][i])));
        Real free = R(4.0) * (around - R(1.0)) / r_max(speed * m.step, R(1e-12));
        int32_t empty = around > R(0.0) ? 1 : 0, more = (int32_t)r_min(r_max(free * R(0.9999), R(0.0)), R(1e6));
        l->t[i] = t;
        l->length[i] = end - begin;
        l->p[0][i] = x;
        l->p[1][i] = y;
        l->p[2][i] = z;
        l->looks[i] = on & (empty ^ 1);
        l->through[i] = on ^ 1;
        l->step[i] += on * (1 + empty * more);
    }
}

R_OUTLINE void look_grid(Lanes *restrict l, const RGrid *restrict lattice, const int32_t *restrict brick_index, const float *restrict values, int alive) {
    RGrid grid = *lattice;
    grid.brick_index = brick_index;
    grid.values = values;
    int count = r_whole_vectors(alive);
    for (int i = 0; i < count; i++) /* vec */
        l->density[i] = r_grid_value(&grid, l->p[0][i], l->p[1][i], l->p[2][i]) * (Real)l->looks[i];
}

R_OUTLINE void look_box(Lanes *restrict l, int alive) {
    int count = r_whole_vectors(alive);
    for (int i = 0; i < count; i++) l->density[i] = (Real)l->looks[i]; /* vec */
}

R_INLINE void along_axis(Lanes *l, const RPopBox *box, int a, int i, int32_t *low) {
    Real u = r_min(r_max((l->p[a][i] - box->lo[a]) * box->per[a] - R(0.5), R(0.0)), (Real)(box->n[a] - 1));
    *low = (int32_t)u;
    l->more[a][i] = *low + 1 < box->n[a] ? 1 : 0;
    l->part[a][i] = u - (Real)*low;
}

R_OUTLINE void find_cells(Lanes *restrict l, const RPopBox *restrict from, int alive) {
    const RPopBox box = *from;
    int count = r_whole_vectors(alive);
    for (int i = 0; i < count; i++) { /* vec */
        int32_t x, y, z;
        along_axis(l, &box, 0, i, &x);
        along_axis(l, &box, 1, i, &y);
        along_axis(l, &box, 2, i, &z);
        l->first[i] = (z * box.n[1] + y) * box.n[0] + x;
    }
}

/* A cell's numbers lie together: they are mixed lane by lane, four at once. */
R_INLINE void mix_cells(const Real *restrict a, const Real *restrict b, Real part, Real *restrict out) {
    for (int c = 0; c < NPH_POP_CELL; c++) out[c] = r_grid_mix(a[c], b[c], part);
}

static void read_cells(Sight *s) {
    const RPopBox *box = &s->march.cells;
    Lanes *l = &s->lanes;
    for (int i = 0; i < s->alive; i++) {
        Real sum[NPH_POP_CELL] = {R(0.0)}, row[4][NPH_POP_CELL], plane[2][NPH_POP_CELL];
        if (l->density[i] > R(0.0)) {
            const Real *a = s->values + (int64_t)l->first[i] * NPH_POP_CELL;
            int64_t right = l->more[0][i] * NPH_POP_CELL, below = (int64_t)l->more[1][i] * box->n[0] * NPH_POP_CELL;
            int64_t behind = (int64_t)l->more[2][i] * box->n[0] * box->n[1] * NPH_POP_CELL;
            Real u = l->part[0][i], v = l->part[1][i], w = l->part[2][i];
            for (int k = 0; k < 4; k++) {
                const Real *b = a + (k & 1 ? below : 0) + (k & 2 ? behind : 0);
                mix_cells(b, b + right, u, row[k]);
            }
            mix_cells(row[0], row[1], v, plane[0]);
            mix_cells(row[2], row[3], v, plane[1]);
            mix_cells(plane[0], plane[1], w, sum);
        }
        for (int c = 0; c < 3; c++) l->J[c][i] = sum[c];
    }
}

/* One exponential for three channels. */
R_OUTLINE void gather_grey(Lanes *restrict l, const March *restrict from, int alive) {
    const March m = *from;
    int count = r_whole_vectors(alive);
    for (int i = 0; i < count; i++) { /* vec */
        Real collides = R(0.0), part = -r_expm1(-m.sigma[0] * l->density[i] * l->length[i]);
        for (int c = 0; c < 3; c++) {
            Real T = l->T[c][i];
            l->light[c][i] += T * part * m.albedo[c] * l->J[c][i];
            collides += T * part * R(0.33333333333333333);
            l->T[c][i] = T * (R(1.0) - part);
        }
        l->collided[i] += collides;
        l->distance[i] += collides * (l->start[i] + l->t[i]);
    }
}

R_OUTLINE void gather(Lanes *restrict l, const March *restrict from, int alive) {
    const March m = *from;
    int count = r_whole_vectors(alive);
    for (int i = 0; i < count; i++) { /* vec */
        Real collides = R(0.0);
        for (int c = 0; c < 3; c++) {
            Real part = -r_expm1(-m.sigma[c] * l->density[i] * l->length[i]), T = l->T[c][i];
            l->light[c][i] += T * part * m.albedo[c] * l->J[c][i];
            collides += T * part * R(0.33333333333333333);
            l->T[c][i] = T * (R(1.0) - part);
        }
        l->collided[i] += collides;
        l->distance[i] += collides * (l->start[i] + l->t[i]);
    }
}

/* What the surface reflects that a ray ends at. */
static void meet_surface(Sight *s, int i, Real radiance[3]) {
    const RPopScene *scene = s->scene;
    const NphPopChoice *choice = &scene->choice;
    Lanes *l = &s->lanes;
    RStream stream = r_stream(&scene->local, NPH_RNG_POP_SURFACE, l->pixel[i], l->sample[i], 0);
    NphWords words = r_words(&stream, 0);
    Real T = R(0.0);
    r_pop_reflect(scene, s->arrays, &l->met[i], (int[]){0, nph_pop_lamps(choice)}, r_uniform(words.w0), radiance);
    r_pop_reflect(scene, s->arrays, &l->met[i], (int[]){nph_pop_lamps(choice), nph_pop_grids(choice)}, r_uniform(words.w1), radiance);
    for (int c = 0; c < 3; c++) T += l->T[c][i] * R(0.33333333333333333);
    l->collided[i] += T;
    l->distance[i] += T * (l->start[i] + l->met[i].t);
    if (s->line) {
        char text[256];
        snprintf(text, sizeof text, "  meets surface %d after %.9g m: reflects %.6g %.6g %.6g, transmittance %.6g", l->met[i].surface, (double)l->met[i].t,
                 (double)radiance[0], (double)radiance[1], (double)radiance[2], (double)l->T[0][i]);
        s->line(s->user, text);
    }
}

static void end_ray(Sight *s, int i) {
    Lanes *l = &s->lanes;
    const int plane = s->between, met = s->surfaces && l->met[i].surface >= 0;
    Real radiance[3] = {R(0.0), R(0.0), R(0.0)}, d[3] = {l->way[0][i], l->way[1][i], l->way[2][i]}, *out = l->out[i];
    if (met) meet_surface(s, i, radiance);
    else r_lights_at_infinity(&s->scene->local, d, l->pdf[i], radiance);
    for (int c = 0; c < 3; c++) {
        out[(NPH_SAMPLE_L0 + c) * plane] = l->light[c][i] + l->T[c][i] * radiance[c];
        out[(NPH_SAMPLE_T0 + c) * plane] = met ? R(0.0) : l->T[c][i];
    }
    out[NPH_SAMPLE_ORDER * plane] = R(0.0);
    out[NPH_SAMPLE_DISTANCE * plane] = l->distance[i];
    out[NPH_SAMPLE_COLLIDED * plane] = l->collided[i];
}

/* Rays as they leave the camera. */
typedef struct Rays {
    Real o[3][LANES], d[3][LANES], from[3][LANES], way[3][LANES], near[LANES], far[LANES], start[LANES], pdf[LANES];
    RMet met[LANES]; /* where there are surfaces */
    int32_t x[LANES], y[LANES], inside[LANES], seen[LANES];
    uint32_t sample[LANES];
} Rays;

R_INLINE void put_ray(Rays *rays, int i, const RMedium *medium, int32_t used, const RCameraRay *ray) {
    RSpan span = r_clip(medium, ray->p, ray->d, R_HUGE);
    for (int a = 0; a < 3; a++) {
        rays->o[a][i] = span.o[a];
        rays->d[a][i] = span.d[a];
        rays->from[a][i] = ray->p[a];
        rays->way[a][i] = ray->d[a];
    }
    rays->near[i] = span.near;
    rays->far[i] = span.far;
    rays->start[i] = ray->start;
    rays->pdf[i] = ray->pdf;
    rays->inside[i] = span.inside & used;
    rays->seen[i] = ray->weight > R(0.0) ? 1 : 0;
}

/* Of cameras whose rays are straight: pinhole, parallel. */
R_OUTLINE void aim_plain(Rays *restrict rays, const RScene *restrict local, const RMedium *restrict medium, double perspective, int32_t used) {
    for (int i = 0; i < LANES; i++) { /* vec */
        RStream stream = r_stream(local, NPH_RNG_GENERATE, (uint32_t)rays->y[i] * (uint32_t)local->width + (uint32_t)rays->x[i], rays->sample[i], 0);
        RCameraRay ray = r_camera_plain(local, rays->x[i], rays->y[i], r_words(&stream, 0), perspective, 0);
        put_ray(rays, i, medium, used, &ray);
    }
}

/* Rays end at surfaces. */
static void meet(Rays *rays, const RPopScene *scene) {
    for (int i = 0; i < LANES; i++) {
        Real p[3] = {rays->from[0][i], rays->from[1][i], rays->from[2][i]}, d[3] = {rays->way[0][i], rays->way[1][i], rays->way[2][i]};
        rays->met[i].surface = -1;
        if (!rays->seen[i] || !r_closest_surface(&scene->local, p, d, R_HUGE, &rays->met[i])) continue;
        rays->far[i] = r_min(rays->far[i], rays->met[i].limit);
        if (!(rays->near[i] < rays->far[i])) rays->inside[i] = 0;
    }
}

/* Pixels and samples are set; lanes without any look through the first pixel. */
static void aim(Rays *rays, const RPopScene *scene) {
    const RScene *local = &scene->local;
    int32_t used = local->medium_count > 0;
    if (local->sensor.kind != NPH_SENSOR_FISHEYE) {
        aim_plain(rays, local, &scene->medium, local->sensor.kind == NPH_SENSOR_PERSPECTIVE ? 1.0 : 0.0, used);
        if (local->surfaces.count > 0) meet(rays, scene);
        return;
    }
    for (int i = 0; i < LANES; i++) {
        RStream stream = r_stream(local, NPH_RNG_GENERATE, (uint32_t)rays->y[i] * (uint32_t)local->width + (uint32_t)rays->x[i], rays->sample[i], 0);
        RCameraRay ray;
        r_camera_ray(local, rays->x[i], rays->y[i], &stream, &ray);
        put_ray(rays, i, &scene->medium, used, &ray);
    }
    if (local->surfaces.count > 0) meet(rays, scene);
}

/* Takes the next lane, where it meets the medium. */
static void begin_ray(Sight *s, const Rays *rays, int from, Real *out) {
    Lanes *l = &s->lanes;
    int i = s->alive;
    if (!rays->seen[from]) return; /* beyond the rim of a fisheye */
    l->out[i] = out;
    l->pdf[i] = rays->pdf[from];
    l->start[i] = rays->start[from];
    l->collided[i] = l->distance[i] = R(0.0);
    for (int c = 0; c < 3; c++) {
        l->light[c][i] = R(0.0);
        l->T[c][i] = R(1.0);
    }
    for (int a = 0; a < 3; a++) {
        l->way[a][i] = rays->way[a][from];
        l->o[a][i] = rays->o[a][from];
        l->d[a][i] = rays->d[a][from];
    }
    l->near[i] = rays->near[from];
    l->far[i] = rays->far[from];
    l->step[i] = 0;
    if (s->surfaces) {
        l->met[i] = rays->met[from];
        l->pixel[i] = (uint32_t)rays->y[from] * (uint32_t)s->scene->local.width + (uint32_t)rays->x[from];
        l->sample[i] = rays->sample[from];
    }
    if (rays->inside[from]) s->alive++;
    else end_ray(s, i);
}

static void move_ray(Sight *s, int to, int from) {
    Lanes *l = &s->lanes;
    for (int a = 0; a < 3; a++) {
        l->o[a][to] = l->o[a][from];
        l->d[a][to] = l->d[a][from];
        l->way[a][to] = l->way[a][from];
        l->light[a][to] = l->light[a][from];
        l->T[a][to] = l->T[a][from];
    }
    l->near[to] = l->near[from];
    l->far[to] = l->far[from];
    l->start[to] = l->start[from];
    l->collided[to] = l->collided[from];
    l->distance[to] = l->distance[from];
    l->step[to] = l->step[from];
    l->through[to] = l->through[from];
    l->pdf[to] = l->pdf[from];
    l->out[to] = l->out[from];
    if (s->surfaces) {
        l->met[to] = l->met[from];
        l->pixel[to] = l->pixel[from];
        l->sample[to] = l->sample[from];
    }
}

static void tell_step(const Sight *s) {
    const Lanes *l = &s->lanes;
    char text[256];
    if (!(l->density[0] > R(0.0))) return;
    snprintf(text, sizeof text, "  after %.9g m: density %.6g, seen %.6g %.6g %.6g, transmittance %.6g", (double)l->t[0], (double)l->density[0],
             (double)l->J[0][0], (double)l->J[1][0], (double)l->J[2][0], (double)l->T[0][0]);
    s->line(s->user, text);
}

static void step_rays(Sight *s) {
    const RMedium *medium = &s->scene->medium;
    Lanes *l = &s->lanes;
    advance(l, &s->march, s->march.majorant, s->alive);
    for (int i = 0; i < s->alive; i++) s->steps += l->looks[i];
    if (medium->shape == NPH_SHAPE_GRID) look_grid(l, &medium->grid, medium->grid.brick_index, medium->grid.values, s->alive);
    else look_box(l, s->alive);
    find_cells(l, &s->march.cells, s->alive);
    read_cells(s);
    (s->grey ? gather_grey : gather)(l, &s->march, s->alive);
    if (s->line) tell_step(s);
    for (int i = 0; i < s->alive;) {
        Real most = r_max(l->T[0][i], r_max(l->T[1][i], l->T[2][i]));
        if (!l->through[i] && !(most < s->scene->exit)) {
            i++;
            continue;
        }
        end_ray(s, i);
        move_ray(s, i, --s->alive);
    }
}

static void begin_sight(Sight *s, const RPopScene *scene, const NphPopArrays *arrays) {
    static const float none = 0.0f;
    const RMedium *medium = &scene->medium;
    int grid = medium->shape == NPH_SHAPE_GRID;
    s->scene = scene;
    s->arrays = arrays;
    s->surfaces = scene->local.surfaces.count > 0;
    s->grey = scene->sigma_t[0] == scene->sigma_t[1] && scene->sigma_t[0] == scene->sigma_t[2];
    s->values = scene->upsampling && grid ? arrays->fine : arrays->merged;
    s->march = (March){.step = scene->step, .majorant = grid ? medium->majorant : &none, .majorants_per_unit = grid ? R(0.25) : R(0.0),
                       .cells = scene->upsampling && grid ? scene->fine : scene->merged};
    for (int a = 0; a < 3; a++) {
        s->march.lo[a] = medium->lo[a];
        s->march.hi[a] = medium->hi[a];
        s->march.majorants[a] = grid ? medium->majorant_n[a] : 1;
        s->march.sigma[a] = scene->sigma_t[a];
        s->march.albedo[a] = scene->choice.lit && scene->sigma_t[a] > R(0.0) ? scene->sigma_s[a] / scene->sigma_t[a] : R(0.0);
    }
}

/* Pixels [x0, y0, x1, y1) of a tile; samples: those of the tile, [field][pixel][16]. */
void NPH_KERNEL(nph_pop_march)(const void *memory, const NphPopArrays *arrays, const int rect[4], int64_t chunk, void *samples, int64_t *steps) {
    const RPopScene *scene = memory;
    enum { PLANE = NPH_TILE_PIXELS * NPH_CHUNK };
    Sight sight = {.between = PLANE};
    int32_t width = rect[2] - rect[0], pixels = width * (rect[3] - rect[1]), next = 0, all = pixels * NPH_CHUNK;
    Rays rays = {.inside = {0}};
    begin_sight(&sight, scene, arrays);
    for (int i = 0; i < NPH_SAMPLE_FIELDS * PLANE; i++) ((Real *)samples)[i] = R(0.0);
    while (next < all || sight.alive > 0) {
        for (; next < all && sight.alive < LANES; next++) {
            int lane = next % LANES;
            for (int i = 0; i < LANES && lane == 0; i++) {
                int32_t ray = next + i < all ? next + i : 0, pixel = ray / NPH_CHUNK;
                rays.x[i] = rect[0] + pixel % width;
                rays.y[i] = rect[1] + pixel / width;
                rays.sample[i] = (uint32_t)(chunk * NPH_CHUNK) + (uint32_t)(ray % NPH_CHUNK);
            }
            if (lane == 0) aim(&rays, scene);
            int32_t place = (rays.y[lane] & (NPH_TILE - 1)) * NPH_TILE + (rays.x[lane] & (NPH_TILE - 1));
            begin_ray(&sight, &rays, lane, (Real *)samples + place * NPH_CHUNK + next % NPH_CHUNK);
        }
        if (sight.alive > 0) step_rays(&sight);
    }
    *steps = sight.steps;
}

void NPH_KERNEL(nph_pop_replay)(const void *memory, const NphPopArrays *arrays, const int pixel[2], uint32_t sample, NphLineFn line, void *user) {
    const RPopScene *scene = memory;
    Sight sight = {.between = 1, .line = line, .user = user};
    Real out[NPH_SAMPLE_FIELDS];
    Rays rays = {.inside = {0}};
    char text[256];
    begin_sight(&sight, scene, arrays);
    for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) out[f] = R(0.0);
    for (int i = 0; i < LANES; i++) {
        rays.x[i] = pixel[0];
        rays.y[i] = pixel[1];
        rays.sample[i] = sample;
    }
    aim(&rays, scene);
    begin_ray(&sight, &rays, 0, out);
    while (sight.alive > 0) step_rays(&sight);
    snprintf(text, sizeof text, "result: %.9g %.9g %.9g, transmittance %.9g, %lld steps", (double)out[0], (double)out[1], (double)out[2],
             (double)out[NPH_SAMPLE_T0], (long long)sight.steps);
    line(user, text);
}
