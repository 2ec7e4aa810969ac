/* SPDX-License-Identifier: Apache-2.0
 *
 * tpm.march [Elek12 sec. 4.4]. Along a ray in steps of the box's diagonal over a number, front to back:
 *   L += T (1 - e^(-s_t step)) S,  T *= e^(-s_t step),  until T is below the exit
 *   S = albedo (F_sun p_HG(theta | g g') + F_sky / 4 pi)
 * The cache tells the light that arrives, of mean cosine g' around the sun's direction; scattered once more it has g g' [Max04].
 * theta is the angle between the sun's direction of travel and the way to the sensor; the sky's fluence has its own lobe where
 * one is kept (else its g' is not used). In print a step is as long as any other and the density is fetched at its middle; so it
 * is here, the last step of a ray ends with the box.
 * How rays begin is in tpm_rays_lookup.h, the detail that noise adds in tpm_noise_lookup.h. */
#include <stdio.h>

#include "method/temporal_photons/tpm_noise_lookup.h"
#include "method/temporal_photons/tpm_rays_lookup.h"

void NPH_KERNEL(nph_tpm_march)(const void *memory, const void *fine, uint32_t sample, int first, int end, void *picture,
                               int64_t *steps);
void NPH_KERNEL(nph_tpm_replay)(const void *memory, const void *fine, uint32_t sample, const int pixel[2], NphLineFn line, void *user);

/* Rays on their way, and the step that each of them is at: all go on together, step by step, and where one is through the last one takes
 * its lane, and then another pixel's. Lanes without a ray take part in the arithmetic: they begin as zeros, and then have no end. */
typedef struct Lanes {
    Real o[3][LANES], d[3][LANES], near[LANES], far[LANES]; /* in the medium's space */
    Real jump[LANES];                                       /* steps per majorant cell along the fastest axis, a little less */
    Real start[LANES], cosine[NPH_TPM_KINDS][LANES];
    Real T[LANES], light[3][LANES], collided[LANES], distance[LANES], order[LANES];
    int32_t step[LANES], looks[LANES], through[LANES];
    Real t[LANES], length[LANES], density[LANES], depth[LANES], p[3][LANES];
    int32_t low[3][LANES], more[3][LANES];
    Real share[8][LANES];
    Real behind[3][LANES];
    Real *out[LANES];
} Lanes;

typedef struct Sight {
    const RTpmScene *scene;
    const Real *fine;
    int alive, sky_lobe;
    int64_t steps;
    NphLineFn line; /* NULL: nobody looks */
    void *user;
    Rays rays;
    Lanes lanes;
    int32_t at[LANES];                  /* where a lane's cell begins, in numbers */
    Real cells[LANES * NPH_TPM_FIELDS]; /* what J holds where the lanes are */
} Sight;

R_INLINE Real lobe(Real g, Real cosine) {
    RAngle angle = {cosine, R(1.0) - cosine, R(1.0) + cosine};
    return r_hg_value(g, R(1.0) - r_abs(g), angle);
}

static void tell_step(const Sight *s) {
    const Lanes *l = &s->lanes;
    char text[256];
    if (!(l->depth[0] > R(0.0))) return;
    snprintf(text, sizeof text, "  after %.9g m: density %.6g, sun %.6g (g %.4g), sky %.6g, transmittance %.6g", (double)l->t[0],
             (double)l->density[0], (double)s->cells[NPH_TPM_I_SUN], (double)s->cells[NPH_TPM_I_G], (double)s->cells[NPH_TPM_I_SKY],
             (double)l->T[0]);
    s->line(s->user, text);
}

/* What the loops over lanes need of the scene. */
typedef struct March {
    Real step, lo[3], hi[3], sigma;
    const float *majorant; /* of cells; one that is not empty where none are passed */
    int32_t majorants[3];
    Real majorants_per_unit;
} March;

/* Every ray on to where density may be: an empty majorant cell tells how many cells around it are empty too, and so how many steps are
 * nothing. A ray that is there stays. Returns how many are, and 65536 times those that are through. */
R_OUTLINE int32_t advance(Lanes *restrict l, const March *restrict from, const float *restrict majorant, int alive) {
    const March m = *from;
    int count = r_whole_vectors(alive);
    int32_t told = 0;
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
        int32_t empty = around > R(0.0) ? 1 : 0, looks = on & (empty ^ 1);
        int32_t more = (int32_t)r_min(r_max((around - R(1.0)) * l->jump[i], R(0.0)), R(1e6));
        l->t[i] = t;
        l->length[i] = end - begin;
        l->p[0][i] = x;
        l->p[1][i] = y;
        l->p[2][i] = z;
        l->looks[i] = looks;
        l->through[i] = on ^ 1;
        l->step[i] += (on & empty) * (1 + more);
        told += looks + ((on ^ 1) << 16);
    }
    return told;
}

/* The optical depth of every step. */
R_OUTLINE void look_grid(Lanes *restrict l, const March *restrict m, const RGrid *restrict lattice, const int32_t *restrict brick_index,
                         const float *restrict values, int alive) {
    const Real sigma = m->sigma;
    RGrid grid = *lattice;
    grid.brick_index = brick_index;
    grid.values = values;
    int count = r_whole_vectors(alive);
    for (int i = 0; i < count; i++) { /* vec */
        Real density = r_grid_value(&grid, l->p[0][i], l->p[1][i], l->p[2][i]);
        l->density[i] = density;
        l->depth[i] = density * sigma * l->length[i] * (Real)l->looks[i];
    }
}

R_OUTLINE void look_box(Lanes *restrict l, const March *restrict m, int alive) {
    const Real sigma = m->sigma;
    int count = r_whole_vectors(alive);
    for (int i = 0; i < count; i++) { /* vec */
        l->density[i] = R(1.0);
        l->depth[i] = sigma * l->length[i] * (Real)l->looks[i];
    }
}

/* The eight cells around, and how much of each. */
R_OUTLINE void find_cells(Lanes *restrict l, const RTpmGrid *restrict grid, int alive) {
    const RTpmGrid g = *grid;
    int count = r_whole_vectors(alive);
    for (int i = 0; i < count; i++) { /* vec */
        RTpmAxis x = r_tpm_axis(l->p[0][i], g.lo[0], g.per_unit[0], g.n[0]), y = r_tpm_axis(l->p[1][i], g.lo[1], g.per_unit[1], g.n[1]);
        RTpmAxis z = r_tpm_axis(l->p[2][i], g.lo[2], g.per_unit[2], g.n[2]);
        l->low[0][i] = x.low;
        l->low[1][i] = y.low;
        l->low[2][i] = z.low;
        l->more[0][i] = x.more;
        l->more[1][i] = y.more;
        l->more[2][i] = z.more;
        Real s00 = (R(1.0) - x.part) * (R(1.0) - y.part), s10 = x.part * (R(1.0) - y.part), s01 = (R(1.0) - x.part) * y.part;
        Real s11 = x.part * y.part;
        l->share[0][i] = s00 * (R(1.0) - z.part);
        l->share[1][i] = s10 * (R(1.0) - z.part);
        l->share[2][i] = s01 * (R(1.0) - z.part);
        l->share[3][i] = s11 * (R(1.0) - z.part);
        l->share[4][i] = s00 * z.part;
        l->share[5][i] = s10 * z.part;
        l->share[6][i] = s01 * z.part;
        l->share[7][i] = s11 * z.part;
    }
}

enum { WIDE = 8 }; /* fields that are mixed at once: the first and, again, the last */

/* The mean of eight cells. */
R_INLINE void mix_cells(const Real *restrict fine, const int64_t at[8], const Real share[8], Real *restrict cell) {
    const Real *a = fine + at[0], *b = fine + at[1], *c = fine + at[2], *d = fine + at[3], *e = fine + at[4], *f = fine + at[5];
    const Real *g = fine + at[6], *h = fine + at[7];
    for (int v = 0; v < WIDE; v++) /* vec */
        cell[v] = share[0] * a[v] + share[1] * b[v] + share[2] * c[v] + share[3] * d[v] + share[4] * e[v] + share[5] * f[v] +
                  share[6] * g[v] + share[7] * h[v];
}

/* What J holds there: lane by lane, since a cell's fields lie together. */
R_OUTLINE void read_cells(const Lanes *restrict l, const int32_t n[3], const Real *restrict fine, int alive, Real *restrict cells) {
    enum { LAST = NPH_TPM_FIELDS - WIDE };
    const int64_t line = n[0], plane = line * n[1];
    for (int i = 0; i < alive; i++) {
        int64_t at[8];
        Real share[8], *cell = cells + i * NPH_TPM_FIELDS;
        if (!(l->depth[i] > R(0.0))) continue;
        int64_t right = l->more[0][i] * NPH_TPM_FIELDS, below = l->more[1][i] * line * NPH_TPM_FIELDS;
        int64_t behind = l->more[2][i] * plane * NPH_TPM_FIELDS;
        at[0] = ((int64_t)l->low[2][i] * plane + (int64_t)l->low[1][i] * line + (int64_t)l->low[0][i]) * NPH_TPM_FIELDS;
        at[1] = at[0] + right;
        at[2] = at[0] + below;
        at[3] = at[1] + below;
        for (int k = 0; k < 4; k++) at[4 + k] = at[k] + behind;
        for (int k = 0; k < 8; k++) share[k] = l->share[k][i];
        mix_cells(fine, at, share, cell);
        mix_cells(fine + LAST, at, share, cell + LAST);
    }
}

/* Light that the step sends to the sensor; nothing where there is no depth. Then the ray goes on, or has no way left. */
R_INLINE void gather(Lanes *restrict l, const RMedium *restrict medium, const Real *restrict cells, const int32_t *restrict at, Real exit, int alive, int sky_lobe) {
    const Real albedo[3] = {medium->albedo[0], medium->albedo[1], medium->albedo[2]};
    const Real g = medium->phase.kind == NPH_PHASE_HG ? medium->phase.g0 : R(0.0), even = lobe(R(0.0), R(0.0));
    int count = r_whole_vectors(alive);
    for (int i = 0; i < count; i++) { /* vec */
        Real part = -r_expm1(-l->depth[i]), T = l->T[i];
        Real sun = lobe(g * cells[at[i] + NPH_TPM_I_G], l->cosine[NPH_TPM_SUN][i]);
        Real sky = sky_lobe ? lobe(g * cells[at[i] + NPH_TPM_I_SKY_G], l->cosine[NPH_TPM_SKY][i]) : even;
        Real from_sun[3], from_sky[3], left = T * (R(1.0) - part);
        for (int c = 0; c < 3; c++) {
            Real share = T * part * albedo[c];
            from_sun[c] = share * sun * cells[at[i] + NPH_TPM_I_SUN + c];
            from_sky[c] = share * sky * cells[at[i] + NPH_TPM_I_SKY + c];
            l->light[c][i] += from_sun[c] + from_sky[c];
        }
        l->order[i] += (cells[at[i] + NPH_TPM_I_DEPTH] + R(1.0)) * r_luminance(from_sun) +
                       (cells[at[i] + NPH_TPM_I_SKY_DEPTH] + R(1.0)) * r_luminance(from_sky);
        l->collided[i] += T * part;
        l->distance[i] += T * part * (l->start[i] + l->t[i]);
        l->T[i] = left;
        l->step[i] += l->looks[i];
        l->far[i] = left < exit ? R(-1.0) : l->far[i];
    }
}

R_OUTLINE void gather_even(Lanes *restrict l, const RMedium *restrict medium, const Real *restrict cells, const int32_t *restrict at, Real exit, int alive) {
    gather(l, medium, cells, at, exit, alive, 0);
}

R_OUTLINE void gather_lobes(Lanes *restrict l, const RMedium *restrict medium, const Real *restrict cells, const int32_t *restrict at, Real exit, int alive) {
    gather(l, medium, cells, at, exit, alive, 1);
}

/* Of cameras whose rays are straight: pinhole, parallel. */
R_OUTLINE void aim_plain(Rays *restrict rays, const RScene *restrict local, const RMedium *restrict medium, const Row *restrict from, int count) {
    const Row row = *from;
    int whole = r_whole_vectors(count);
    for (int i = 0; i < whole; i++) { /* vec */
        int32_t x, y;
        pixel_of(&row, i, &x, &y);
        RStream stream = r_stream(local, NPH_RNG_GENERATE, (uint32_t)y * (uint32_t)row.width + (uint32_t)x, row.sample, 0);
        RCameraRay ray = r_camera_plain(local, x, y, r_words(&stream, 0), row.perspective, 0);
        put_ray(rays, i, &row, medium, &ray);
    }
}

static void aim(Rays *rays, const RTpmScene *scene, const Row *row, int count) {
    const RScene *local = &scene->local;
    if (local->sensor.kind != NPH_SENSOR_FISHEYE) {
        aim_plain(rays, local, &scene->medium, row, count);
        return;
    }
    for (int i = 0; i < count; i++) {
        int32_t x, y;
        RCameraRay ray;
        pixel_of(row, i, &x, &y);
        RStream stream = r_stream(local, NPH_RNG_GENERATE, (uint32_t)y * (uint32_t)row->width + (uint32_t)x, row->sample, 0);
        r_camera_ray(local, x, y, &stream, &ray);
        put_ray(rays, i, row, &scene->medium, &ray);
    }
}

/* Rays of up to LANES pixels from (x, y) of the small picture on. */
static void begin_rays(Sight *s, int x, int y, uint32_t sample, int count) {
    const RTpmScene *scene = s->scene;
    const RScene *local = &scene->local;
    Rays *rays = &s->rays;
    int even = even_behind(local);
    Real radiance[3];
    Row row = {.x = x, .y = y, .half = scene->half, .width = local->width, .height = local->height, .medium = local->medium_count > 0,
               .sample = sample, .seed = local->seed, .perspective = local->sensor.kind == NPH_SENSOR_PERSPECTIVE ? 1.0 : 0.0, .step = scene->step};
    for (int k = 0; k < NPH_TPM_KINDS; k++)
        for (int a = 0; a < 3; a++) row.towards[k][a] = scene->towards[k][a];
    aim(rays, scene, &row, count);
    for (int i = 0; i < count; i++) {
        Real d[3] = {rays->way[0][i], rays->way[1][i], rays->way[2][i]};
        if (i == 0 || !even)
            for (int c = 0; c < 3; c++) radiance[c] = R(0.0);
        if (!scene->impostor && (i == 0 || !even)) r_lights_at_infinity(local, d, rays->pdf[i], radiance);
        for (int c = 0; c < 3; c++) rays->behind[c][i] = radiance[c];
    }
    rays->next = 0;
    rays->count = count;
}

/* What is behind joins. */
static void end_ray(Lanes *l, int i) {
    Real *out = l->out[i];
    for (int c = 0; c < 3; c++) {
        out[NPH_SAMPLE_L0 + c] = l->light[c][i] + l->T[i] * l->behind[c][i];
        out[NPH_SAMPLE_T0 + c] = l->T[i];
    }
    out[NPH_SAMPLE_DISTANCE] = l->distance[i];
    out[NPH_SAMPLE_COLLIDED] = l->collided[i];
    out[NPH_SAMPLE_ORDER] = l->order[i];
}

/* A ray takes the lane after the last, unless it meets nothing and is over at once. */
static void take_ray(Sight *s, int k, Real *out) {
    const Rays *rays = &s->rays;
    Lanes *l = &s->lanes;
    int i = s->alive;
    if (!rays->inside[k] || !rays->seen[k]) {
        for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) out[f] = R(0.0);
        for (int c = 0; c < 3 && rays->seen[k]; c++) {
            out[NPH_SAMPLE_L0 + c] = rays->behind[c][k];
            out[NPH_SAMPLE_T0 + c] = R(1.0);
        }
        return;
    }
    s->alive++;
    l->out[i] = out;
    l->T[i] = R(1.0);
    l->collided[i] = l->distance[i] = l->order[i] = R(0.0);
    for (int a = 0; a < 3; a++) {
        l->o[a][i] = rays->o[a][k];
        l->d[a][i] = rays->d[a][k];
        l->light[a][i] = R(0.0);
        l->behind[a][i] = rays->behind[a][k];
    }
    for (int m = 0; m < NPH_TPM_KINDS; m++) l->cosine[m][i] = rays->cosine[m][k];
    l->near[i] = rays->near[k];
    l->far[i] = rays->far[k];
    l->jump[i] = rays->jump[k];
    l->start[i] = rays->start[k];
    l->step[i] = 0;
}

/* The last ray takes the lane of one that is through. */
static void move_ray(Lanes *l, int to, int from) {
    for (int a = 0; a < 3; a++) {
        l->o[a][to] = l->o[a][from];
        l->d[a][to] = l->d[a][from];
        l->p[a][to] = l->p[a][from];
        l->light[a][to] = l->light[a][from];
        l->behind[a][to] = l->behind[a][from];
    }
    for (int k = 0; k < NPH_TPM_KINDS; k++) l->cosine[k][to] = l->cosine[k][from];
    l->near[to] = l->near[from];
    l->far[to] = l->far[from];
    l->jump[to] = l->jump[from];
    l->start[to] = l->start[from];
    l->T[to] = l->T[from];
    l->collided[to] = l->collided[from];
    l->distance[to] = l->distance[from];
    l->order[to] = l->order[from];
    l->step[to] = l->step[from];
    l->t[to] = l->t[from];
    l->length[to] = l->length[from];
    l->looks[to] = l->looks[from];
    l->through[to] = l->through[from];
    l->out[to] = l->out[from];
    l->far[from] = R(-1.0);
    l->looks[from] = 0;
}

static void end_rays(Sight *s) {
    Lanes *l = &s->lanes;
    for (int i = 0; i < s->alive;) {
        if (!l->through[i]) {
            i++;
            continue;
        }
        end_ray(l, i);
        move_ray(l, i, --s->alive);
    }
}

/* Goes on until most rays are where density may be. */
static void find_steps(Sight *s, const March *march) {
    int looking = 0;
    for (int pass = 0; pass < 8 && s->alive > 0 && 8 * looking < 7 * s->alive; pass++) {
        int32_t told = advance(&s->lanes, march, march->majorant, s->alive);
        looking = told & 0xffff;
        if (told >> 16) end_rays(s);
    }
    s->steps += looking;
}

static void step_rays(Sight *s, const March *march) {
    const RTpmScene *scene = s->scene;
    const RMedium *medium = &scene->medium;
    Lanes *l = &s->lanes;
    find_steps(s, march);
    if (s->alive == 0) return;
    for (int i = 0; i < s->alive && scene->noise > R(0.0); i++) {
        Real p[3] = {l->p[0][i], l->p[1][i], l->p[2][i]}, q[3];
        detail(scene, p, q);
        for (int a = 0; a < 3; a++) l->p[a][i] = q[a];
    }
    if (medium->shape == NPH_SHAPE_GRID) look_grid(l, march, &medium->grid, medium->grid.brick_index, medium->grid.values, s->alive);
    else look_box(l, march, s->alive);
    find_cells(l, &scene->fine, s->alive);
    read_cells(l, scene->fine.n, s->fine, s->alive, s->cells);
    (s->sky_lobe ? gather_lobes : gather_even)(l, medium, s->cells, s->at, scene->exit, s->alive);
    if (s->line) tell_step(s);
}

static March march_of(const RTpmScene *scene) {
    static const float none = 0.0f;
    const RMedium *medium = &scene->medium;
    int skips = medium->shape == NPH_SHAPE_GRID && !(scene->noise > R(0.0));
    March march = {.step = scene->step, .sigma = medium->sigma_max, .majorant = skips ? medium->majorant : &none,
                   .majorants_per_unit = skips ? R(0.25) : R(0.0)}; /* 1 / NPH_MAJORANT_CELL */
    for (int a = 0; a < 3; a++) {
        march.lo[a] = medium->lo[a];
        march.hi[a] = medium->hi[a];
        march.majorants[a] = skips ? medium->majorant_n[a] : 1;
    }
    return march;
}

static int has_lobe(const RTpmScene *scene, int kind) {
    const Real *towards = scene->towards[kind];
    return towards[0] * towards[0] + towards[1] * towards[1] + towards[2] * towards[2] > R(0.0);
}

void NPH_KERNEL(nph_tpm_march)(const void *memory, const void *fine, uint32_t sample, int first, int end, void *picture,
                               int64_t *steps) {
    const RTpmScene *scene = memory;
    Sight sight = {.scene = scene, .fine = fine, .sky_lobe = has_lobe(scene, NPH_TPM_SKY)};
    const March march = march_of(scene);
    for (int i = 0; i < LANES; i++) sight.at[i] = i * NPH_TPM_FIELDS;
    Rays *rays = &sight.rays;
    Real *out = (Real *)picture + (int64_t)first * scene->small[0] * NPH_SAMPLE_FIELDS;
    for (int x = 0, y = first;;) {
        if (rays->next == rays->count && y < end) {
            int count = scene->small[0] - x < LANES ? scene->small[0] - x : LANES;
            begin_rays(&sight, scene->small_origin[0] + x, scene->small_origin[1] + y, sample, count);
            x = x + count < scene->small[0] ? x + count : 0;
            y += x == 0;
        }
        for (; rays->next < rays->count && sight.alive < LANES; out += NPH_SAMPLE_FIELDS) take_ray(&sight, rays->next++, out);
        if (rays->next == rays->count && y < end) continue;
        if (sight.alive == 0) break;
        step_rays(&sight, &march);
    }
    *steps = sight.steps;
}

void NPH_KERNEL(nph_tpm_replay)(const void *memory, const void *fine, uint32_t sample, const int pixel[2], NphLineFn line, void *user) {
    const RTpmScene *scene = memory;
    Sight sight = {.scene = scene, .fine = fine, .sky_lobe = has_lobe(scene, NPH_TPM_SKY), .line = line, .user = user};
    const March march = march_of(scene);
    for (int i = 0; i < LANES; i++) sight.at[i] = i * NPH_TPM_FIELDS;
    Real out[NPH_SAMPLE_FIELDS];
    char text[256];
    begin_rays(&sight, scene->half ? pixel[0] / 2 : pixel[0], scene->half ? pixel[1] / 2 : pixel[1], sample, 1);
    take_ray(&sight, 0, out);
    while (sight.alive > 0) step_rays(&sight, &march);
    snprintf(text, sizeof text, "result: %.9g %.9g %.9g, transmittance %.9g, %lld steps", (double)out[0], (double)out[1], (double)out[2],
             (double)out[NPH_SAMPLE_T0], (long long)sight.steps);
    line(user, text);
}
