/* SPDX-License-Identifier: Apache-2.0
 *
 * tpm.march and tpm.enlarge [Elek12 sec. 4.4]. Along a ray in steps of the box's diagonal over a number, front to back:
 *   L += T (1 - e^(-s_t step)) S,  T *= e^(-s_t step),  until T is below the exit
 *   S = albedo (F_sun p_HG(theta | g g') + F_sky / 4 pi)
 * The cache tells the light that arrives, of mean cosine g' around the sun's direction; scattered once more it has g g' [Max04].
 * theta is the angle between the sun's direction of travel and the way to the sensor; the sky's fluence has its own lobe where
 * one is kept (else its g' is not used). In print a step is as long as any other and the density is fetched at its middle; so it
 * is here, the last step of a ray ends with the box.
 *
 * With impostors a picture holds the cloud alone, and may serve later frames: it then stands on a plane through the cloud's middle.
 *
 * Detail: up to three octaves of vector noise move the places at which density and cache are looked up. */
#include <stdio.h>

#include "method/temporal_photons/tpm_state.h"

void NPH_KERNEL(nph_tpm_march)(const void *memory, const void *fine, uint32_t sample, int first, int end, void *picture,
                               int64_t *steps);
void NPH_KERNEL(nph_tpm_replay)(const void *memory, const void *fine, uint32_t sample, const int pixel[2], NphLineFn line, void *user);
void NPH_KERNEL(nph_tpm_enlarge)(const void *memory, const void *view, const void *picture, const int crop[4], int first, int end, void *image);

typedef struct Sight {
    const RTpmScene *scene;
    const Real *fine;
    RCameraRay ray;
    Real cosine[NPH_TPM_KINDS];
    Real T, light[3], collided, distance, order;
    int64_t steps;
    NphLineFn line; /* NULL: nobody looks */
    void *user;
} Sight;

/* Periodic, linear between its points. */
static void add_noise(const RTpmScene *scene, Real size, Real amount, const Real p[3], Real out[3]) {
    int32_t low[3];
    Real part[3];
    for (int a = 0; a < 3; a++) {
        Real u = p[a] * size, whole = r_floor(u);
        part[a] = u - whole;
        low[a] = (int32_t)(whole - R(32.0) * r_floor(whole * R(0.03125)));
    }
    for (int k = 0; k < 8; k++) {
        Real share = amount;
        int32_t at[3];
        for (int a = 0; a < 3; a++) {
            int up = k >> a & 1;
            share *= up ? part[a] : R(1.0) - part[a];
            at[a] = (low[a] + up) & (R_TPM_NOISE - 1);
        }
        const float *vector = scene->field + 3 * ((at[2] * R_TPM_NOISE + at[1]) * R_TPM_NOISE + at[0]);
        for (int a = 0; a < 3; a++) out[a] += share * (Real)vector[a];
    }
}

/* The place that is looked up for p: p itself, or moved by noise and kept in the box. */
static void detail(const RTpmScene *scene, const Real p[3], Real out[3]) {
    Real moved[3] = {R(0.0), R(0.0), R(0.0)}, size = R(0.25), amount = scene->noise;
    for (int o = 0; o < scene->octaves && scene->noise > R(0.0); o++, size *= R(2.0), amount *= R(0.5))
        add_noise(scene, size, amount, p, moved);
    for (int a = 0; a < 3; a++) out[a] = r_clamp(p[a] + moved[a], scene->medium.lo[a], scene->medium.hi[a]);
}

static Real lobe(Real g, Real cosine) {
    RAngle angle = {cosine, R(1.0) - cosine, R(1.0) + cosine};
    return r_hg_value(g, R(1.0) - r_abs(g), angle);
}

static void tell_step(const Sight *s, const Real *cell, Real t, Real density) {
    char text[256];
    if (!s->line) return;
    snprintf(text, sizeof text, "  after %.9g m: density %.6g, sun %.6g (g %.4g), sky %.6g, transmittance %.6g", (double)t, (double)density,
             (double)cell[NPH_TPM_I_SUN], (double)cell[NPH_TPM_I_G], (double)cell[NPH_TPM_I_SKY], (double)s->T);
    s->line(s->user, text);
}

static void look(Sight *s, const Real p[3], Real t, Real length) {
    const RTpmScene *scene = s->scene;
    const RMedium *medium = &scene->medium;
    Real q[3];
    detail(scene, p, q);
    Real density = r_tpm_density(medium, q[0], q[1], q[2]), depth = density * medium->sigma_max * length;
    s->steps++;
    if (!(depth > R(0.0))) return;
    RTpmEight eight;
    Real cell[NPH_TPM_FIELDS] = {R(0.0)}, part = -r_expm1(-depth), g = medium->phase.kind == NPH_PHASE_HG ? medium->phase.g0 : R(0.0);
    r_tpm_eight(&scene->fine, q, &eight);
    for (int k = 0; k < 8; k++)
        for (int v = 0; v < NPH_TPM_FIELDS; v++) cell[v] += eight.share[k] * s->fine[eight.at[k] * NPH_TPM_FIELDS + v];
    Real sun = lobe(g * cell[NPH_TPM_I_G], s->cosine[NPH_TPM_SUN]), sky = lobe(g * cell[NPH_TPM_I_SKY_G], s->cosine[NPH_TPM_SKY]);
    Real from_sun[3], from_sky[3];
    for (int c = 0; c < 3; c++) {
        Real share = s->T * part * medium->albedo[c];
        from_sun[c] = share * sun * cell[NPH_TPM_I_SUN + c];
        from_sky[c] = share * sky * cell[NPH_TPM_I_SKY + c];
        s->light[c] += from_sun[c] + from_sky[c];
    }
    s->order += (cell[NPH_TPM_I_DEPTH] + R(1.0)) * r_luminance(from_sun) + (cell[NPH_TPM_I_SKY_DEPTH] + R(1.0)) * r_luminance(from_sky);
    s->collided += s->T * part;
    s->distance += s->T * part * (s->ray.start + t);
    s->T *= R(1.0) - part;
    tell_step(s, cell, t, density);
}

/* Steps that meet no density from here on: an empty majorant cell tells how many cells around it are empty too. */
static int64_t empty_steps(const RTpmScene *scene, const RSpan *span, const Real p[3]) {
    const RMedium *medium = &scene->medium;
    const int32_t *n = medium->majorant_n;
    int32_t c[3];
    if (medium->shape != NPH_SHAPE_GRID || scene->noise > R(0.0)) return 0;
    for (int a = 0; a < 3; a++) {
        int32_t cell = (int32_t)(p[a] * R(0.25)); /* NPH_MAJORANT_CELL */
        c[a] = cell < n[a] ? cell : n[a] - 1;
    }
    float around = -medium->majorant[r_tpm_cell(n, c[0], c[1], c[2])];
    if (!(around > 0.0f)) return 0;
    Real speed = r_max(r_abs(span->d[0]), r_max(r_abs(span->d[1]), r_abs(span->d[2])));
    Real steps = R(4.0) * (Real)(around - 1.0f) / r_max(speed * scene->step, R(1e-12));
    return 1 + (int64_t)r_min(steps * R(0.9999), R(1e6));
}

static void through(Sight *s) {
    const RTpmScene *scene = s->scene;
    RSpan span = r_clip(&scene->medium, s->ray.p, s->ray.d, R_HUGE);
    if (!span.inside) return;
    for (int64_t i = 0;;) {
        Real from = span.near + (Real)i * scene->step, to = r_min(from + scene->step, span.far), t = R(0.5) * (from + to), p[3];
        if (!(from < to)) return;
        for (int a = 0; a < 3; a++) p[a] = r_clamp(span.o[a] + t * span.d[a], scene->medium.lo[a], scene->medium.hi[a]);
        int64_t empty = empty_steps(scene, &span, p);
        i += empty > 1 ? empty : 1;
        if (empty > 0) continue;
        look(s, p, t, to - from);
        if (s->T < scene->exit) return;
    }
}

static void see(Sight *s, int x, int y, uint32_t sample, Real *out) {
    const RTpmScene *scene = s->scene;
    RStream stream = r_stream(&scene->local, NPH_RNG_GENERATE, (uint32_t)y * (uint32_t)scene->local.width + (uint32_t)x, sample, 0);
    Real radiance[3] = {R(0.0), R(0.0), R(0.0)};
    r_camera_ray(&scene->local, x, y, &stream, &s->ray);
    for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) out[f] = R(0.0);
    if (!(s->ray.weight > R(0.0))) return;
    s->T = R(1.0);
    s->collided = s->distance = s->order = R(0.0);
    for (int c = 0; c < 3; c++) s->light[c] = R(0.0);
    for (int k = 0; k < NPH_TPM_KINDS; k++) {
        const Real *towards = scene->towards[k];
        s->cosine[k] = -(s->ray.d[0] * towards[0] + s->ray.d[1] * towards[1] + s->ray.d[2] * towards[2]);
    }
    if (scene->local.medium_count > 0) through(s);
    if (!scene->impostor) r_lights_at_infinity(&scene->local, s->ray.d, s->ray.pdf, radiance);
    for (int c = 0; c < 3; c++) {
        out[NPH_SAMPLE_L0 + c] = s->light[c] + s->T * radiance[c];
        out[NPH_SAMPLE_T0 + c] = s->T;
    }
    out[NPH_SAMPLE_DISTANCE] = s->distance;
    out[NPH_SAMPLE_COLLIDED] = s->collided;
    out[NPH_SAMPLE_ORDER] = s->order;
}

/* A pixel of the small picture; of two by two the ray goes through one, drawn with the sample's own words. */
static void see_small(Sight *s, int x, int y, uint32_t sample, Real *out) {
    const RScene *local = &s->scene->local;
    if (s->scene->half) {
        NphWords words = nph_philox(local->seed, (uint32_t)NPH_RNG_TPM_PIXEL << 24, (uint32_t)x, (uint32_t)y, sample, 0);
        x = 2 * x + (int)(words.w0 >> 31);
        y = 2 * y + (int)(words.w1 >> 31);
        x = x < local->width ? x : local->width - 1;
        y = y < local->height ? y : local->height - 1;
    }
    see(s, x, y, sample, out);
}

void NPH_KERNEL(nph_tpm_march)(const void *memory, const void *fine, uint32_t sample, int first, int end, void *picture,
                               int64_t *steps) {
    const RTpmScene *scene = memory;
    Sight sight = {.scene = scene, .fine = fine};
    for (int row = first; row < end; row++)
        for (int column = 0; column < scene->small[0]; column++)
            see_small(&sight, scene->small_origin[0] + column, scene->small_origin[1] + row, sample,
                      (Real *)picture + ((int64_t)row * scene->small[0] + column) * NPH_SAMPLE_FIELDS);
    *steps = sight.steps;
}

void NPH_KERNEL(nph_tpm_replay)(const void *memory, const void *fine, uint32_t sample, const int pixel[2], NphLineFn line, void *user) {
    const RTpmScene *scene = memory;
    Sight sight = {.scene = scene, .fine = fine, .line = line, .user = user};
    Real out[NPH_SAMPLE_FIELDS];
    char text[256];
    see_small(&sight, scene->half ? pixel[0] / 2 : pixel[0], scene->half ? pixel[1] / 2 : pixel[1], sample, out);
    snprintf(text, sizeof text, "result: %.9g %.9g %.9g, transmittance %.9g, %lld steps", (double)out[0], (double)out[1], (double)out[2],
             (double)out[NPH_SAMPLE_T0], (long long)sight.steps);
    line(user, text);
}

/* Between four pixels of the small picture, which is constant beyond its outermost. */
static void blend(const RTpmScene *scene, const Real *picture, const Real at[2], Real out[NPH_SAMPLE_FIELDS]) {
    int32_t low[2], high[2];
    int64_t corner[4];
    Real share[2];
    for (int a = 0; a < 2; a++) {
        Real u = r_clamp(at[a] - (Real)scene->small_origin[a], R(0.0), (Real)(scene->small[a] - 1));
        low[a] = (int32_t)u;
        high[a] = low[a] + 1 < scene->small[a] ? low[a] + 1 : low[a];
        share[a] = u - (Real)low[a];
    }
    for (int k = 0; k < 4; k++)
        corner[k] = ((int64_t)(k >> 1 ? high[1] : low[1]) * scene->small[0] + (k & 1 ? high[0] : low[0])) * NPH_SAMPLE_FIELDS;
    for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) {
        const Real *from = picture + f;
        Real upper = from[corner[0]] + share[0] * (from[corner[1]] - from[corner[0]]);
        Real lower = from[corner[2]] + share[0] * (from[corner[3]] - from[corner[2]]);
        out[f] = upper + share[1] * (lower - upper);
    }
}

static double product(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Through the middle of a pixel, of any length. */
static void pixel_way(const NphSensor *sensor, int x, int y, double d[3]) {
    double s = sensor->half_size[0] * (2.0 * ((double)x + 0.5) / (double)sensor->width - 1.0);
    double t = sensor->half_size[1] * (1.0 - 2.0 * ((double)y + 0.5) / (double)sensor->height);
    for (int a = 0; a < 3; a++) d[a] = sensor->forward[a] + s * sensor->right[a] + t * sensor->up[a];
}

/* Where the view's ray meets the impostor, in pixels of the picture's sensor: that is a plane through the middle of the cloud, across
 * the way on which it was seen. 0: nowhere. */
static int meet(const RTpmScene *scene, const RTpmScene *view, const double d[3], double at[2]) {
    const NphSensor *from = &scene->local.sensor, *to = &view->local.sensor;
    double normal[3], away[3], hit[3];
    for (int a = 0; a < 3; a++) {
        normal[a] = scene->centre[a] - from->position[a];
        away[a] = view->centre[a] - to->position[a];
    }
    double slope = product(d, normal), distance = product(away, normal) / slope;
    if (!(slope > 0.0) || !(distance > 0.0)) return 0;
    for (int a = 0; a < 3; a++) hit[a] = normal[a] + distance * d[a] - away[a]; /* from where the picture was taken */
    double depth = product(hit, from->forward);
    if (!(depth > 0.0)) return 0;
    at[0] = 0.5 * (1.0 + product(hit, from->right) / (depth * from->half_size[0])) * (double)from->width;
    at[1] = 0.5 * (1.0 - product(hit, from->up) / (depth * from->half_size[1])) * (double)from->height;
    return at[0] > -1.0 && at[1] > -1.0 && at[0] < (double)from->width + 1.0 && at[1] < (double)from->height + 1.0;
}

/* The same camera and cloud: the picture is where it was, to the bit. */
static int stands_still(const RTpmScene *scene, const RTpmScene *view) {
    const NphSensor *a = &scene->local.sensor, *b = &view->local.sensor;
    int same = 1;
    for (int x = 0; x < 3; x++)
        same &= !(a->position[x] < b->position[x] || a->position[x] > b->position[x] || a->right[x] < b->right[x] || a->right[x] > b->right[x] ||
                  a->up[x] < b->up[x] || a->up[x] > b->up[x] || a->forward[x] < b->forward[x] || a->forward[x] > b->forward[x] ||
                  scene->centre[x] < view->centre[x] || scene->centre[x] > view->centre[x]);
    for (int x = 0; x < 2; x++) same &= !(a->half_size[x] < b->half_size[x] || a->half_size[x] > b->half_size[x]);
    return same;
}

/* The cloud's picture, this frame's or an earlier one's, before what is behind it now. */
static void show_impostor(const RTpmScene *scene, const RTpmScene *view, int still, const Real *picture, int x, int y, Real out[NPH_SAMPLE_FIELDS]) {
    double way[3], place[2] = {(double)x + 0.5, (double)y + 0.5};
    Real radiance[3] = {R(0.0), R(0.0), R(0.0)}, d[3], at[2];
    pixel_way(&view->local.sensor, x, y, way);
    double inverse = 1.0 / nph_sqrt(product(way, way));
    for (int a = 0; a < 3; a++) d[a] = (Real)(way[a] * inverse);
    int seen = still || meet(scene, view, way, place);
    for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) out[f] = R(0.0);
    for (int c = 0; c < 3; c++) out[NPH_SAMPLE_T0 + c] = R(1.0);
    for (int a = 0; a < 2; a++) at[a] = (Real)((scene->half ? 0.5 * place[a] : place[a]) - 0.5);
    if (seen) blend(scene, picture, at, out);
    r_lights_at_infinity(&view->local, d, R(-1.0), radiance);
    for (int c = 0; c < 3; c++) out[NPH_SAMPLE_L0 + c] += out[NPH_SAMPLE_T0 + c] * radiance[c];
}

void NPH_KERNEL(nph_tpm_enlarge)(const void *memory, const void *seen, const void *picture, const int crop[4], int first, int end, void *image) {
    const RTpmScene *scene = memory, *view = seen;
    int64_t width = crop[2] - crop[0], pixels = width * (crop[3] - crop[1]);
    int still = scene == view || stands_still(scene, view);
    for (int row = first; row < end; row++)
        for (int column = 0; column < (int)width; column++) {
            int x = crop[0] + column, y = crop[1] + row;
            Real out[NPH_SAMPLE_FIELDS];
            Real at[2] = {scene->half ? R(0.5) * ((Real)x + R(0.5)) - R(0.5) : (Real)x, scene->half ? R(0.5) * ((Real)y + R(0.5)) - R(0.5) : (Real)y};
            if (scene->impostor) show_impostor(scene, view, still, picture, x, y, out);
            else blend(scene, picture, at, out);
            for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) ((Real *)image)[f * pixels + row * width + column] = out[f];
        }
}
