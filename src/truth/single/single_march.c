/* SPDX-License-Identifier: Apache-2.0
 *
 * The sample of one camera ray [Kajiya84, the low-albedo case]:
 *     L = e^-tau L_infinity  +  sum over lights of  integral rho s albedo p e^-tau T_light dt  value
 * and, where the ray ends on a surface, e^-tau albedo / pi sum over lights of cos T_light value. Beams of light come
 * from single_light.c. Blinn's mode [Blinn82]: suns alone, each from its centre; in a layer the integral in closed
 * form. */
#include <assert.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "transport/vertex_lookup.h"
#include "truth/single/single_quadrature.h"

/* One ray under way. */
typedef struct March {
    const NphSingleScene *scene;
    NphSingleScratch *scratch;
    NphSingleState *state;
    const RCameraRay *ray; /* of the state */
    const NphSingleAsk *ask;
    double *fields;        /* of the state */
    double weight;         /* of the ray: 1, pi for a flux sensor */
} March;

static March march_of(const NphSingleScene *scene, NphSingleScratch *scratch, NphSingleState *state, const NphSingleAsk *ask) {
    March m = {.scene = scene, .scratch = scratch, .state = state, .ray = &state->ray, .ask = ask, .fields = state->part,
               .weight = state->ray.weight};
    return m;
}

void nph_single_tell(const NphSingleAsk *ask, const char *format, ...) {
    if (!ask->line) return;
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    ask->line(ask->user, text);
}

size_t nph_single_scratch_bytes(int fields) {
    return sizeof(NphSingleScratch) + (size_t)fields * (NPH_SINGLE_PIECES + 1) * sizeof(NphPiece);
}

void nph_single_scratch_layout(void *memory, int fields, NphSingleScratch **scratch) {
    NphSingleScratch *made = memory;
    memset(made, 0, sizeof *made);
    NphPiece *pieces = (NphPiece *)(void *)((char *)memory + sizeof *made);
    for (int m = 0; m < fields; m++) made->profile.pieces[m] = pieces + (size_t)m * (NPH_SINGLE_PIECES + 1);
    *scratch = made;
}

const NphSingleTally *nph_single_tally(const NphSingleScratch *scratch) { return &scratch->tally; }

static void add(March *m, const double channels[3], int order) {
    double light[3] = {channels[0], channels[1], channels[2]};
    r_film_rgb(&m->scene->local, light);
    for (int c = 0; c < 3; c++) m->fields[NPH_SAMPLE_L0 + c] += light[c];
    m->fields[NPH_SAMPLE_ORDER] += (double)order * r_luminance(light);
}

/* Of each channel of the film when transport has one. */
static double channel(const March *m, const double value[3], int c) {
    return value[m->scene->local.channels > 1 ? c : 0];
}

/* A homogeneous layer lit by parallel light [Blinn82]: the optical depth towards the light changes in proportion to the
 * way along the ray, from a at `near` to b at `far`, so with x = s (far - near) + b - a
 *     s albedo p  integral e^(-s (t - near) - a - (b - a)(t - near) / (far - near)) dt
 *         = albedo p e^-a  s (far - near) (1 - e^-x) / x
 * which for rays through the whole layer is Blinn's mu0 / (mu0 + mu) (1 - e^(-tau (1/mu0 + 1/mu))), and where the light
 * comes from the other side mu0 / (mu0 - mu) (e^(-tau/mu0) - e^(-tau/mu)). */
static void scatter_layer(March *m, const NphBeam *beam, double result[3]) {
    const RScene *local = &m->scene->local;
    const RMedium *medium = &local->media[0];
    NphLine line;
    if (!nph_line_clip(medium, m->ray->p, m->ray->d, 0.0, R_HUGE, &line)) return;
    double near[3], far[3], length = line.far - line.near;
    NphWalked none = {0, 0};
    assert(local->channels <= 3);
    for (int a = 0; a < 3; a++) {
        near[a] = m->ray->p[a] + line.near * m->ray->d[a];
        far[a] = m->ray->p[a] + line.far * m->ray->d[a];
    }
    double before = nph_single_depth(medium, near, beam->d, R_HUGE, 1e300, &none);
    double behind = nph_single_depth(medium, far, beam->d, R_HUGE, 1e300, &none);
    for (int c = 0; c < local->channels; c++) {
        double along = medium->sigma[c] * length, x = along + medium->sigma[c] * (behind - before);
        double part = nph_abs(x) > 1e-8 ? -r_expm1(-x) / x : 1.0 - 0.5 * x;
        result[c] += medium->albedo[c] * beam->phase[0] * r_exp(-medium->sigma[c] * before) * along * part;
    }
}

/* What one light sends to the sensor by one scattering in the stretch that the profile describes. */
static void scatter(March *m, int l) {
    const NphSingleTally *tally = &m->scratch->tally;
    int64_t points = tally->points, voxels = tally->walked.voxels;
    NphBeam beam;
    double result[3] = {0.0, 0.0, 0.0}, error[3] = {0.0, 0.0, 0.0}, light[3], any = 0.0;
    nph_single_beam(m->scene, m->ray, m->ask, l, NULL, &beam);
    for (int c = 0; c < 3; c++) any = beam.value[c] > any ? beam.value[c] : any;
    if (!(any > 0.0)) return;
    int closed = m->scene->choice.layer && m->scene->mode == NPH_SINGLE_BLINN;
    if (closed)
        scatter_layer(m, &beam, result);
    else
        nph_single_integrate(m->scene, m->scratch, m->ray->p, m->ray->d, &beam, result, error);
    for (int c = 0; c < 3; c++) light[c] = m->weight * channel(m, result, c) * beam.value[c];
    for (int c = 0; c < 3; c++) m->state->scattered[l][c] += light[c];
    add(m, light, 1);
    nph_single_tell(
        m->ask,
        "    light %d%s: %.9g per unit, error at most %.2g by estimate, %lld optical depths of %lld voxels; "
        "adds %.9g %.9g %.9g",
        l, closed ? " in closed form" : "", result[0], error[0], (long long)(tally->points - points),
        (long long)(tally->walked.voxels - voxels), light[0], light[1], light[2]);
}

/* One Gauss point: where the ray is scattered first, in the mean over channels, and what is emitted. */
static void meet_point(const March *m, const NphPlace *place, double t, double h, double *sum, double glow[3]) {
    const RScene *local = &m->scene->local;
    double density[NPH_SINGLE_FIELDS], tau[3];
    assert(m->scene->fields >= local->medium_count);
    nph_profile_at(&m->scratch->profile, place, t, density, tau);
    for (int c = 0; c < local->channels; c++) {
        double rate = 0.0, passes = h * r_exp(-tau[c]);
        for (int i = 0; i < local->medium_count; i++) rate += density[i] * local->media[i].sigma[c];
        *sum += (m->ray->start + t) * rate * passes;
        for (int f = local->medium_count; f < m->scene->fields; f++) {
            const double *value = m->scene->glow_value[f - local->medium_count];
            glow[c] += density[f] * value[c] * passes;
            for (int k = 1; k < 3 && local->channels == 1; k++) glow[k] += density[f] * value[k] * passes;
        }
    }
}

/* Adds integral t sigma e^-tau dt, 1 - e^-tau, and integral j e^-tau dt of a stretch. */
static void meet(March *m, const double before[3], const double behind[3]) {
    const NphProfile *profile = &m->scratch->profile;
    int channels = m->scene->local.channels;
    double sum = 0.0, collided = 0.0, glow[3] = {0.0, 0.0, 0.0}, t = profile->begin;
    NphPlace place;
    nph_profile_seek(profile, t, &place);
    while (t < profile->end) {
        double e = nph_profile_move(profile, &place, t, profile->end);
        if (!(e > t)) break;
        while (place.active && t < e) {
            double thin = nph_profile_thin(profile, &place, t, e);
            for (int g = 0; g < NPH_GAUSS; g++)
                meet_point(m, &place, t + (thin - t) * nph_gauss_point[g], (thin - t) * nph_gauss_weight[g], &sum,
                           glow);
            t = thin;
        }
        t = e;
    }
    for (int c = 0; c < channels; c++) collided += r_exp(-before[c]) - r_exp(-behind[c]);
    m->fields[NPH_SAMPLE_DISTANCE] += sum / (double)channels;
    m->fields[NPH_SAMPLE_COLLIDED] += collided / (double)channels;
    if (m->scene->fields == m->scene->local.medium_count) return;
    for (int c = 0; c < 3; c++) glow[c] *= m->weight;
    add(m, glow, 0);
    nph_single_tell(m->ask, "    emission adds %.9g %.9g %.9g", glow[0], glow[1], glow[2]);
}

static void depths(const March *m, double tau[3]) {
    const RScene *local = &m->scene->local;
    for (int c = 0; c < local->channels; c++) {
        tau[c] = 0.0;
        for (int i = 0; i < local->medium_count; i++) tau[c] += local->media[i].sigma[c] * m->scratch->profile.total[i];
    }
}

/* Stretch by stretch to the end of the ray at `limit`, or to where it is opaque. */
static void follow(March *m, double limit) {
    const RScene *local = &m->scene->local;
    NphProfile *profile = &m->scratch->profile;
    double before[3] = {0.0, 0.0, 0.0}, tau[3] = {0.0, 0.0, 0.0};
    assert(local->channels <= 3 && local->medium_count <= m->scene->fields);
    profile->end = 0.0;
    for (int i = 0; i < m->scene->fields; i++) profile->total[i] = 0.0;
    do {
        memcpy(before, tau, sizeof before);
        nph_profile_build(profile, m->scene, m->ray->p, m->ray->d, limit, &m->scratch->tally.walked);
        depths(m, tau);
        meet(m, before, tau);
        nph_single_tell(m->ask, "  %g m to %g m: optical depth %.9g to %.9g", profile->begin, profile->end, before[0],
                        tau[0]);
        for (int l = 0; l < local->light_count; l++)
            if (m->scene->choice.scattered[l]) scatter(m, l);
        if (m->scene->choice.layer && m->scene->mode == NPH_SINGLE_BLINN) break;
    } while (!profile->opaque && profile->end < limit);
    for (int c = 0; c < local->channels; c++) m->state->T[c] = profile->opaque ? 0.0 : r_exp(-tau[c]);
}

/* What sensors for flux and fluence get straight from lights that have a direction of their own: E cos, E. */
static void light_sensor(March *m, int l) {
    const RScene *local = &m->scene->local;
    double cosine = 0.0, T[3], light[3];
    RStream stream = r_stream(local, NPH_RNG_LIGHT, m->ask->pixel, m->ask->sample, 0);
    RLightSample sample;
    stream.draw = (uint32_t)l << NPH_DRAW_LIGHT_SHIFT;
    r_sample_light(&local->lights[l], m->ray->at, &stream, &sample);
    int flux = local->sensor.kind == NPH_SENSOR_FLUX;
    for (int a = 0; a < 3; a++) cosine += local->sensor.forward[a] * sample.d[a];
    cosine = flux ? cosine : 1.0;
    if (!(cosine > 0.0) || r_blocked(local, m->ray->at, sample.d, sample.distance)) return;
    nph_single_transmittance(local, m->ray->at, sample.d, sample.distance, &m->scratch->tally.walked, T);
    double balance = sample.pdf > 0.0
                         ? r_balance(sample.pdf, cosine * (flux ? 0.31830988618379067154 : 0.079577471545947667884))
                         : 1.0;
    for (int c = 0; c < 3; c++) light[c] = cosine * balance * channel(m, T, c) * sample.value[c];
    add(m, light, 0);
    nph_single_tell(m->ask, "  light %d at the sensor: transmittance %.9g, weight %.6g; adds %.9g %.9g %.9g", l, T[0],
                    balance, light[0], light[1], light[2]);
}

/* Light of one lamp that a surface reflects to the sensor: e^-tau albedo cos / pi T V value. */
static void reflect(March *m, const RMet *met, int l) {
    const RScene *local = &m->scene->local;
    NphBeam beam;
    double to[3], distance = R_HUGE, fall = 1.0, T[3], arrives[3];
    nph_single_beam(m->scene, m->ray, m->ask, l, met->n, &beam);
    for (int a = 0; a < 3; a++) to[a] = beam.point ? beam.position[a] - met->p[a] : beam.d[a];
    if (beam.point) {
        distance = r_sqrt(r_dot(to, to));
        fall = 1.0 / (distance * distance);
        for (int a = 0; a < 3; a++) to[a] /= distance;
    }
    double density = r_lambert_density(r_dot(met->n, to));
    if (!(density > 0.0) || r_blocked(local, met->p, to, distance)) return;
    nph_single_transmittance(local, met->p, to, distance, &m->scratch->tally.walked, T);
    for (int c = 0; c < 3; c++)
        arrives[c] = m->weight * channel(m, m->state->T, c) * local->surfaces.albedo[met->surface][c] * density * fall *
                     channel(m, T, c) * beam.value[c];
    add(m, arrives, 1);
    nph_single_tell(m->ask, "    light %d: transmittance %.9g, cos %.9g; adds %.9g %.9g %.9g", l, T[0],
                    r_dot(met->n, to), arrives[0], arrives[1], arrives[2]);
}

static void arrive(March *m, const RMet *met) {
    const RScene *local = &m->scene->local;
    double T = 0.0;
    for (int c = 0; c < local->channels; c++) T += m->state->T[c] / (double)local->channels;
    m->fields[NPH_SAMPLE_COLLIDED] += T;
    m->fields[NPH_SAMPLE_DISTANCE] += T * (m->ray->start + met->t);
    nph_single_tell(m->ask, "  meets surface %d after %.9g m, transmittance %.9g", met->surface, met->t, m->state->T[0]);
    for (int l = 0; l < local->light_count; l++)
        if (m->scene->choice.reflected[l]) reflect(m, met, l);
}

static void leave(March *m) {
    const RScene *local = &m->scene->local;
    double sky[3] = {0.0, 0.0, 0.0}, light[3];
    r_lights_at_infinity(local, m->ray->d, m->ray->pdf, sky);
    for (int c = 0; c < 3; c++) {
        m->fields[NPH_SAMPLE_T0 + c] = channel(m, m->state->T, c);
        light[c] = m->weight * channel(m, m->state->T, c) * sky[c];
    }
    r_film_transmittance(local, m->fields + NPH_SAMPLE_T0);
    add(m, light, 0);
    nph_single_tell(m->ask, "  leaves: transmittance %.9g %.9g %.9g; adds %.9g %.9g %.9g", m->fields[NPH_SAMPLE_T0],
                    m->fields[NPH_SAMPLE_T1], m->fields[NPH_SAMPLE_T2], light[0], light[1], light[2]);
}

/* Where the ray ends; nothing has been added yet. */
void nph_single_meet(const NphSingleScene *scene, NphSingleState *state) {
    const RScene *local = &scene->local;
    RMet met = {.surface = -1};
    memset(state->part, 0, sizeof state->part);
    state->met = met;
    state->met.limit = R_HUGE;
    if (state->ray.weight > 0.0 && local->surfaces.count > 0 && r_closest_surface(local, state->ray.p, state->ray.d, R_HUGE, &met))
        state->met = met;
}

void nph_single_gather(const NphSingleScene *scene, NphSingleScratch *scratch, NphSingleState *state, const NphSingleAsk *ask) {
    March m = march_of(scene, scratch, state, ask);
    for (int l = 0; l < scene->local.light_count; l++)
        if (scene->local.lights[l].sampled && m.weight > 0.0) light_sensor(&m, l);
}

void nph_single_follow(const NphSingleScene *scene, NphSingleScratch *scratch, NphSingleState *state, const NphSingleAsk *ask) {
    March m = march_of(scene, scratch, state, ask);
    memset(state->scattered, 0, sizeof state->scattered);
    for (int c = 0; c < 3; c++) state->T[c] = 0.0;
    if (m.weight > 0.0) follow(&m, state->met.limit);
}

void nph_single_arrive(const NphSingleScene *scene, NphSingleScratch *scratch, NphSingleState *state, const NphSingleAsk *ask) {
    March m = march_of(scene, scratch, state, ask);
    if (m.weight > 0.0 && state->met.surface >= 0) arrive(&m, &state->met);
}

void nph_single_leave(const NphSingleScene *scene, NphSingleScratch *scratch, NphSingleState *state, const NphSingleAsk *ask) {
    March m = march_of(scene, scratch, state, ask);
    if (m.weight > 0.0 && state->met.surface < 0) leave(&m);
}

/* All groups of wavelengths on the same ray; each is worth the picture, so their mean is. */
void nph_single_fold(const NphSingleScene *scene, int group, const NphSingleState *state, double fields[NPH_SAMPLE_FIELDS]) {
    double groups = (double)scene->local.groups;
    for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) {
        double sum = group == 0 ? state->part[f] : fields[f] + state->part[f];
        fields[f] = group == scene->local.groups - 1 ? sum / groups : sum;
    }
}

void nph_single_march(const NphSingleScene *scenes, NphSingleScratch *scratch, const RCameraRay *ray,
                      const NphSingleAsk *ask, double fields[NPH_SAMPLE_FIELDS]) {
    NphSingleState state = {.ray = *ray};
    for (int g = 0; g < scenes->local.groups; g++) {
        const NphSingleScene *scene = &scenes[g];
        if (g > 0) nph_single_tell(ask, "  group %d of wavelengths", g);
        if (!(ray->weight > 0.0)) nph_single_tell(ask, "  outside of the fisheye's circle");
        nph_single_meet(scene, &state);
        if (nph_sensor_gathers(scene->local.sensor.kind)) nph_single_gather(scene, scratch, &state, ask);
        nph_single_follow(scene, scratch, &state, ask);
        nph_single_arrive(scene, scratch, &state, ask);
        nph_single_leave(scene, scratch, &state, ask);
        nph_single_fold(scene, g, &state, fields);
    }
}
