/* SPDX-License-Identifier: Apache-2.0
 *
 * photonmap.march: from the camera through the media [Jensen98],
 *   L = sum over steps of T(t_k) S(t_k) / lambda(t_k) + T L_inf,    S = direct (shadow rays) + multiple (r_estimate)
 * Each medium m places points at the depths (u + i) step of its own majorant, M_m s_m, with u uniform: there are
 * lambda = sum M_m s_m / step of them per metre, so the sum has the mean of the integral of T S, and empty space costs
 * nothing. T is exact (photonmap_depth.h): the only bias is that of the estimate. In print T is the product of
 * e^(-sigma_t(x_k) dx_k), here with dx = 1 / lambda: `printed`. */
#include <stdarg.h>
#include <stdio.h>

#include "transport/camera_lookup.h"
#include "transport/vertex_lookup.h"
#include "truth/photonmap/photonmap_2_estimate.h"
#include "truth/photonmap/photonmap_depth.h"

void NPH_KERNEL(nph_photonmap_march)(const void *scene, const NphPhotonMap *map, const NphPhotonmapTile *tile,
                                     NphTally *tally);
void NPH_KERNEL(nph_photonmap_replay)(const void *scene, const NphPhotonMap *map, const int pixel[2], NphLineFn line,
                                      void *user, double fields[NPH_SAMPLE_FIELDS]);

/* The ray in one medium: its next point at `next`, where the majorant is `rate` per metre over the step. */
typedef struct Track {
    RSpan span;
    RWalk walk;
    Real next, rate;
    int ahead;
} Track;

typedef struct March {
    const RPhotonScene *scene;
    const NphPhotonMap *map;
    uint32_t pixel, points;
    RCameraRay ray;
    Real t, depth[3], grown; /* optical depth up to t; what roulette has multiplied */
    Real field[NPH_SAMPLE_FIELDS];
    Track tracks[NPH_MAX_MEDIA];
    Real density[NPH_MAX_MEDIA]; /* of the media at the point */
    NphTally *tally;
    NphLineFn line;
    void *user;
} March;

static void tell(const March *m, const char *format, ...) {
    if (!m->line) return;
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    m->line(m->user, text);
}

static RStream stream_of(const March *m, uint32_t stage, uint32_t draw) {
    RStream stream = r_photon_stream(m->scene, stage, m->pixel, m->map->sample, m->points);
    stream.draw = draw;
    return stream;
}

/* The next point of a medium, `depth` of its majorant further. */
static void advance(const RMedium *medium, Track *track, Real depth, Real step) {
    if (medium->shape != NPH_SHAPE_GRID) {
        track->next += depth / medium->sigma_max;
        track->ahead = track->next < track->span.far;
        track->rate = medium->sigma_max / step;
        return;
    }
    track->walk.depth = depth;
    track->ahead = r_walk_on(medium, &track->span, &track->walk);
    track->next = track->walk.t;
    track->rate = track->walk.majorant * medium->sigma_max / step;
}

static void enter(March *m) {
    const RScene *local = &m->scene->local;
    for (int i = 0; i < local->medium_count; i++) {
        const RMedium *medium = &local->media[i];
        Track *track = &m->tracks[i];
        track->span = r_clip(medium, m->ray.p, m->ray.d, R_HUGE);
        track->ahead = track->span.inside && medium->sigma_max > R(0.0);
        if (!track->ahead) continue;
        RStream stream = stream_of(m, NPH_RNG_MARCH_STEP, medium->number << NPH_DRAW_MEDIUM_SHIFT);
        Real first = r_uniform(r_words(&stream, 0).w0) * m->scene->step;
        track->next = track->span.near;
        if (medium->shape == NPH_SHAPE_GRID) track->walk = r_walk_enter(medium->majorant_n, &track->span, first);
        advance(medium, track, first, m->scene->step);
    }
}

/* The medium whose point is next, or -1. */
static int nearest_track(const March *m) {
    int nearest = -1;
    for (int i = 0; i < m->scene->local.medium_count; i++)
        if (m->tracks[i].ahead && (nearest < 0 || m->tracks[i].next < m->tracks[nearest].next)) nearest = i;
    return nearest;
}

static void move_to(March *m, Real t) {
    const RScene *local = &m->scene->local;
    for (int i = 0; i < local->medium_count && !m->scene->printed; i++) {
        Real depth = r_depth(&local->media[i], &m->tracks[i].span, m->t, t);
        for (int c = 0; c < 3; c++) m->depth[c] += local->media[i].sigma[c] * depth;
    }
    m->t = t;
}

static void transmittance(const March *m, Real T[3]) {
    for (int c = 0; c < 3; c++) T[c] = m->grown * r_exp(-m->depth[c]);
}

/* Densities of all media at t, and points per metre there. */
static Real rate_at(March *m, int own, Real t) {
    const RScene *local = &m->scene->local;
    Real rate = m->tracks[own].rate;
    for (int i = 0; i < local->medium_count; i++) {
        const RMedium *medium = &local->media[i];
        const RSpan *span = &m->tracks[i].span;
        m->density[i] = R(0.0);
        if (!span->inside || (i != own && !(t >= span->near && t < span->far))) continue;
        m->density[i] = R(1.0);
        if (medium->shape != NPH_SHAPE_GRID) {
            rate += i == own ? R(0.0) : medium->sigma_max / m->scene->step;
            continue;
        }
        int32_t cell[3];
        for (int a = 0; a < 3; a++) cell[a] = r_cell_of(span->o[a] + t * span->d[a], medium->majorant_n[a]);
        if (i == own) {
            cell[0] = m->tracks[i].walk.c0;
            cell[1] = m->tracks[i].walk.c1;
            cell[2] = m->tracks[i].walk.c2;
        } else
            rate += r_max((Real)medium->majorant[r_walk_cell(medium->majorant_n, cell[0], cell[1], cell[2])], R(0.0)) *
                    medium->sigma_max / m->scene->step;
        m->density[i] = r_depth_density(medium, span, cell, t);
    }
    return rate;
}

/* What of a light from direction to, of radiance over density `value`, is scattered at p towards the sensor; only: one
 * medium, or -1. `phased`: the phase function is in value's density already. */
static void add_light(March *m, int number, const Real p[3], const RLightSample *light, int only, Real sum[3]) {
    const RScene *local = &m->scene->local;
    Real weight[3] = {R(0.0), R(0.0), R(0.0)}, T[3] = {R(1.0), R(1.0), R(1.0)};
    for (int i = 0; i < local->medium_count; i++) {
        const RMedium *medium = &local->media[i];
        if (only >= 0 && i != only) continue;
        Real phase = only >= 0 ? R(1.0) : r_phase_at(&medium->phase, r_angle_between(m->ray.d, light->d));
        for (int c = 0; c < 3; c++) weight[c] += m->density[i] * medium->sigma[c] * medium->albedo[c] * phase;
    }
    if (!(weight[0] * light->value[0] + weight[1] * light->value[1] + weight[2] * light->value[2] > R(0.0))) return;
    RStream stream = stream_of(m, NPH_RNG_MARCH_SHADOW, 0);
    for (int i = 0; i < local->medium_count && T[0] + T[1] + T[2] > R(0.0); i++) {
        uint32_t slot = local->media[i].number; /* of a constant light, also by medium: other random words */
        REvents events = r_events(&stream, number, slot);
        if (only >= 0) events.stream.vertex |= (uint32_t)(only + 1) << 24;
        r_transmittance(&local->media[i], p, light->d, light->distance, local, &events, T, m->tally);
        if (local->channels == 1) T[1] = T[2] = T[0];
    }
    for (int c = 0; c < 3; c++) sum[c] += weight[c] * T[c] * light->value[c];
}

/* One direction for each medium, drawn from its phase function. */
static void add_constant(March *m, int number, const Real p[3], Real sum[3]) {
    const RScene *local = &m->scene->local;
    const RLight *light = &local->lights[number];
    for (int i = 0; i < local->medium_count; i++) {
        const RMedium *medium = &local->media[i];
        if (!(m->density[i] > R(0.0))) continue;
        RStream stream = stream_of(m, NPH_RNG_MARCH_LIGHT,
                                   (uint32_t)number << NPH_DRAW_LIGHT_SHIFT | medium->number << NPH_DRAW_MEDIUM_SHIFT);
        RTurned turned = r_turn_plain(&medium->phase, m->ray.d, r_words(&stream, 0));
        RLightSample sample = {
            {turned.d[0], turned.d[1], turned.d[2]}, R_HUGE, {R(0.0), R(0.0), R(0.0)}, R(-1.0), R(0.0)};
        int seen = light->hemisphere == 0 || turned.d[2] * (Real)light->hemisphere > R(0.0);
        for (int c = 0; c < 3; c++) sample.value[c] = seen ? light->value[c] : R(0.0);
        add_light(m, number, p, &sample, i, sum);
    }
}

static void direct_light(March *m, const Real p[3], Real sum[3]) {
    const RScene *local = &m->scene->local;
    for (int l = 0; l < local->light_count && m->scene->direct; l++) {
        if (local->lights[l].kind == NPH_LIGHT_CONSTANT) {
            add_constant(m, l, p, sum);
            continue;
        }
        if (!local->lights[l].sampled) continue;
        RStream stream = stream_of(m, NPH_RNG_MARCH_LIGHT, (uint32_t)l << NPH_DRAW_LIGHT_SHIFT);
        RLightSample sample;
        r_sample_light(&local->lights[l], p, &stream, &sample);
        add_light(m, l, p, &sample, -1, sum);
    }
}

/* One point of the march, placed by medium `own`. */
static void look(March *m, int own, Real t) {
    const RScene *local = &m->scene->local;
    Real rate = rate_at(m, own, t), T[3], p[3], direct[3] = {R(0.0), R(0.0), R(0.0)}, light[2][3], collides = R(0.0),
         extinction = R(0.0);
    m->points++;
    transmittance(m, T);
    for (int a = 0; a < 3; a++) p[a] = m->ray.p[a] + t * m->ray.d[a];
    for (int i = 0; i < local->medium_count; i++) extinction += m->density[i] * local->media[i].sigma_max;
    direct_light(m, p, direct);
    RScattered multiple = r_estimate(m->scene, m->map, p, m->ray.d, extinction);
    Real shares[3] = {R(0.0), R(0.0), R(0.0)}, mean_T = (T[0] + T[1] + T[2]) * (R(1.0) / R(3.0));
    for (int i = 0; i < local->medium_count; i++)
        for (int c = 0; c < 3; c++) shares[c] += m->density[i] * local->media[i].sigma[c] / rate;
    for (int c = 0; c < 3; c++) {
        light[0][c] = m->ray.weight * T[c] * direct[c] / rate;
        light[1][c] = m->ray.weight * T[c] * multiple.radiance[c] / rate;
        m->field[NPH_SAMPLE_L0 + c] += light[0][c] + light[1][c];
        collides += T[c] * shares[c] * (R(1.0) / R(3.0));
        m->depth[c] += m->scene->printed ? shares[c] : R(0.0);
    }
    m->field[NPH_SAMPLE_ORDER] += r_luminance(light[0]) + m->ray.weight * mean_T * multiple.order / rate;
    m->field[NPH_SAMPLE_COLLIDED] += collides;
    m->field[NPH_SAMPLE_DISTANCE] += (m->ray.start + t) * collides;
    tell(m, "  point %u after %.9g m: transmittance %.6g, direct %.6g, multiple %.6g from %d photons within %.6g m",
         m->points, (double)t, (double)T[0], (double)direct[0], (double)multiple.radiance[0], multiple.found,
         (double)multiple.radius);
}

/* Once little is left to be seen, the march goes on with probability 1/4 and four times the weight. */
static int goes_on(March *m) {
    Real T[3];
    transmittance(m, T);
    if (!(r_max(T[0], r_max(T[1], T[2])) < m->scene->local.shadow_roulette)) return 1;
    RStream stream = stream_of(m, NPH_RNG_MARCH_STEP, 0);
    if (!(r_uniform(r_words(&stream, 0).w1) < R(0.25))) return 0;
    m->grown *= R(4.0);
    return 1;
}

/* Lights at infinity behind the media, and the layer of the transmittance. */
static void leave(March *m) {
    Real T[3], radiance[3] = {R(0.0), R(0.0), R(0.0)};
    move_to(m, R_HUGE);
    transmittance(m, T);
    r_lights_at_infinity(&m->scene->local, m->ray.d, m->ray.pdf, radiance);
    for (int c = 0; c < 3; c++) {
        m->field[NPH_SAMPLE_L0 + c] += m->ray.weight * T[c] * radiance[c];
        m->field[NPH_SAMPLE_T0 + c] = T[c];
    }
    tell(m, "  leaves: transmittance %.9g %.9g %.9g", (double)T[0], (double)T[1], (double)T[2]);
}

/* The light sample of a sensor that gathers, weighted against the rays that meet the light. */
static void sensor_light(March *m, int number) {
    const RScene *local = &m->scene->local;
    RStream stream = stream_of(m, NPH_RNG_MARCH_LIGHT, (uint32_t)number << NPH_DRAW_LIGHT_SHIFT);
    RLightSample sample;
    RVertex vertex;
    r_vertex_at_sensor(&local->sensor, m->ray.at, m->ray.d, &vertex);
    r_sample_light(&local->lights[number], m->ray.at, &stream, &sample);
    Real density = r_vertex_value(&vertex, sample.d), T[3] = {R(1.0), R(1.0), R(1.0)};
    Real weight = m->ray.weight * density * r_balance(sample.pdf, density);
    if (!(weight > R(0.0))) return;
    stream = stream_of(m, NPH_RNG_MARCH_SHADOW, 0);
    for (int i = 0; i < local->medium_count; i++) {
        REvents events = r_events(&stream, number, local->media[i].number);
        r_transmittance(&local->media[i], m->ray.at, sample.d, sample.distance, local, &events, T, m->tally);
        if (local->channels == 1) T[1] = T[2] = T[0];
    }
    for (int c = 0; c < 3; c++) m->field[NPH_SAMPLE_L0 + c] += weight * T[c] * sample.value[c];
}

static void march(March *m, int x, int y) {
    const RScene *local = &m->scene->local;
    RStream stream = stream_of(m, NPH_RNG_GENERATE, 0);
    r_camera_ray(local, x, y, &stream, &m->ray);
    m->grown = R(1.0);
    if (!(m->ray.weight > R(0.0))) return; /* beyond the rim of a fisheye */
    for (int l = 0; l < local->light_count && nph_sensor_gathers(local->sensor.kind); l++)
        if (local->lights[l].sampled) sensor_light(m, l);
    enter(m);
    for (int own = nearest_track(m); own >= 0; own = nearest_track(m)) {
        Track *track = &m->tracks[own];
        Real t = track->next;
        move_to(m, t);
        look(m, own, t);
        if (!goes_on(m)) return;
        advance(&local->media[own], track, m->scene->step, m->scene->step);
    }
    leave(m);
}

static March march_of(const void *scene, const NphPhotonMap *map, uint32_t pixel, NphTally *tally) {
    March m;
    m.scene = scene;
    m.map = map;
    m.pixel = pixel;
    m.points = 0;
    m.t = R(0.0);
    for (int c = 0; c < 3; c++) m.depth[c] = R(0.0);
    for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) m.field[f] = R(0.0);
    m.tally = tally;
    m.line = NULL;
    return m;
}

void NPH_KERNEL(nph_photonmap_march)(const void *scene, const NphPhotonMap *map, const NphPhotonmapTile *tile,
                                     NphTally *tally) {
    const RScene *local = &((const RPhotonScene *)scene)->local;
    const int *crop = tile->crop;
    int64_t width = crop[2] - crop[0], pixels = width * (crop[3] - crop[1]);
    Real *image = tile->image;
    for (int y = tile->inside[1]; y < tile->inside[3]; y++)
        for (int x = tile->inside[0]; x < tile->inside[2]; x++) {
            int64_t pixel = (y - crop[1]) * width + x - crop[0];
            March m = march_of(scene, map, (uint32_t)y * (uint32_t)local->width + (uint32_t)x, tally);
            march(&m, x, y);
            for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) image[f * pixels + pixel] = m.field[f];
        }
}

void NPH_KERNEL(nph_photonmap_replay)(const void *scene, const NphPhotonMap *map, const int pixel[2], NphLineFn line,
                                      void *user, double fields[NPH_SAMPLE_FIELDS]) {
    const RScene *local = &((const RPhotonScene *)scene)->local;
    NphTally tally = {0, 0, 0, 0};
    March m = march_of(scene, map, (uint32_t)pixel[1] * (uint32_t)local->width + (uint32_t)pixel[0], &tally);
    m.line = line;
    m.user = user;
    tell(&m, "photonmap: pixel %d,%d sample %u, seed %u, frame %u", pixel[0], pixel[1], map->sample, local->seed,
         local->frame);
    tell(&m, "  map: %lld photons emitted, %lld times scattered, %d stored", (long long)map->emitted,
         (long long)map->scattered, (int)map->tree.count);
    march(&m, pixel[0], pixel[1]);
    tell(&m, "result: %.9g %.9g %.9g of %u points", (double)m.field[0], (double)m.field[1], (double)m.field[2],
         m.points);
    for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) fields[f] = (double)m.field[f];
}
