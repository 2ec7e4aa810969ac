/* SPDX-License-Identifier: Apache-2.0
 *
 * The scene of temporal photons, and tpm.resolve: from sums in fixed point to fluence, mean cosine and penetration depth.
 *
 * A beam's tentative events stand at the rate s_T, so the sum of w / (s_T V) over those in a cell of volume V estimates the
 * fluence there: w is what is left of the beam, deposits are its flux in units of `unit`, and after the switch to isotropic
 * scattering they are s_T / s_T' times as large. With N photons in the buffer the fluence is
 *   sum unit / (N s_T V).
 * Photons of all generations carry as much, however many there are: N is then the number that would carry each generation's light. */
#include <string.h>

#include "method/temporal_photons/tpm_state.h"
#include "transport/facts_lookup.h"
#include "transport/prepare_lookup.h"

size_t NPH_KERNEL(nph_tpm_scene_bytes)(int noise);
void NPH_KERNEL(nph_tpm_prepare)(const NphJob *job, const NphTpmChoice *choice, void *memory);
void NPH_KERNEL(nph_tpm_adopt)(void *memory, const void *reference);
void NPH_KERNEL(nph_tpm_resolve)(const void *memory, const int64_t *sums, const double photons[NPH_TPM_KINDS], void *coarse);
void NPH_KERNEL(nph_tpm_facts)(const void *memory, const NphTpmChoice *choice, NphFactFn fact, void *user);

enum { FIELD = R_TPM_NOISE * R_TPM_NOISE * R_TPM_NOISE };

size_t NPH_KERNEL(nph_tpm_scene_bytes)(int noise) { return sizeof(RTpmScene) + (noise ? 3 * FIELD * sizeof(float) : 0); }

static double length_of(const double v[3]) { return nph_sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

/* World metres per unit of the medium's space along its axes, and cubic metres per cubic unit. */
static void prepare_space(const NphMedium *medium, double metres[3], double *volume) {
    const double *m = medium->world_from_medium;
    double columns[3][3], cross[3];
    for (int a = 0; a < 3; a++) {
        for (int b = 0; b < 3; b++) columns[a][b] = m[4 * b + a];
        metres[a] = length_of(columns[a]);
    }
    nph_vector_cross(columns[0], columns[1], cross);
    *volume = nph_abs(cross[0] * columns[2][0] + cross[1] * columns[2][1] + cross[2] * columns[2][2]);
}

static void prepare_grid(const RMedium *medium, const int32_t n[3], const double metres[3], RTpmGrid *out) {
    for (int a = 0; a < 3; a++) {
        double size = (double)medium->hi[a] - (double)medium->lo[a];
        out->n[a] = n[a];
        out->lo[a] = medium->lo[a];
        out->per_unit[a] = (Real)((double)n[a] / size);
        out->edge[a] = (Real)(size * metres[a] / (double)n[a]);
    }
}

/* Light that comes from all sides alike has no direction: 0. */
static void add_sky_direction(const NphLight *light, double power, const double centre[3], double sum[3]) {
    double towards[3] = {0.0, 0.0, (double)light->hemisphere}, weight = 0.0;
    if (light->kind == NPH_LIGHT_ENVIRONMENT) {
        const NphEnvironment *map = &light->map;
        towards[2] = 0.0;
        for (int64_t i = 0; i < (int64_t)map->width * map->height; i++) {
            int64_t row = i / map->width;
            double polar = (double)row, turn = 0.5 - ((double)(i % map->width) + 0.5) / (double)map->width;
            double top, power_of_texel, middle, sine, cosine, unused, above, below, rotation = light->rotation_rad * 0.15915494309189535;
            nph_sincos2pi(0.5 * polar / (double)map->height, &unused, &above);
            nph_sincos2pi(0.5 * (polar + 1.0) / (double)map->height, &unused, &below);
            nph_sincos2pi(0.5 * (polar + 0.5) / (double)map->height, &middle, &top);
            nph_sincos2pi(turn + rotation, &sine, &cosine);
            power_of_texel = (above - below) * (0.2126 * (double)map->radiance[3 * i] + 0.7152 * (double)map->radiance[3 * i + 1] +
                                        0.0722 * (double)map->radiance[3 * i + 2]);
            towards[0] += power_of_texel * middle * cosine;
            towards[1] += power_of_texel * middle * sine;
            towards[2] += power_of_texel * top;
            weight += power_of_texel;
        }
        for (int a = 0; a < 3; a++) towards[a] /= weight > 0.0 ? weight : 1.0;
    } else if (light->kind == NPH_LIGHT_SUN) {
        for (int a = 0; a < 3; a++) towards[a] = light->direction[a];
    } else if (light->kind == NPH_LIGHT_POINT) {
        double away[3] = {light->position[0] - centre[0], light->position[1] - centre[1], light->position[2] - centre[2]};
        double length = length_of(away);
        for (int a = 0; a < 3; a++) towards[a] = length > 0.0 ? away[a] / length : 0.0;
    } else {
        towards[2] *= 0.5; /* mean cosine of a hemisphere */
    }
    for (int a = 0; a < 3; a++) sum[a] -= power * towards[a];
}

static void prepare_lights(const NphJob *job, const NphTpmChoice *choice, RTpmScene *out) {
    const NphScene *scene = job->scene;
    double power[NPH_MAX_LIGHTS], sum = 0.0, below = 0.0, most = 0.0, sky[3] = {0.0, 0.0, 0.0}, exponent = 0.0;
    for (int l = 0; l < scene->light_count; l++) {
        power[l] = r_entry_power(&out->local, &scene->lights[l], l, &out->from[l]);
        most = power[l] > most ? power[l] : most;
        if (l == choice->dominant) continue;
        sum += power[l];
        if (job->knobs[NPH_TPM_KNOB_SKY_LOBE] > 0.5) add_sky_direction(&scene->lights[l], power[l], out->local.origin, sky);
    }
    for (int l = 0; l < scene->light_count && sum > 0.0; l++) {
        below += l == choice->dominant ? 0.0 : power[l];
        out->choose[l + 1] = l + 1 == scene->light_count ? 1.0 : below / sum;
    }
    double length = length_of(sky);
    for (int a = 0; a < 3; a++) {
        out->towards[NPH_TPM_SKY][a] = length > 1e-9 * sum ? (Real)(sky[a] / length) : R(0.0);
    }
    if (most > 0.0) nph_mantissa(most, &exponent);
    out->unit = nph_power_of_2(exponent < -1000.0 ? -1000.0 : exponent);
}

/* The medium before and after the switch: extinction reduced to s_a + f s_s, with f = 1 - g, or its root in print. */
static void prepare_medium(const NphJob *job, const NphTpmChoice *choice, RTpmScene *out) {
    const NphMedium *from = &job->scene->media[choice->medium];
    double g = from->phase.kind == NPH_PHASE_HG ? from->phase.g[0] : 0.0, albedo = from->albedo[0];
    double factor = out->paper ? nph_sqrt(1.0 - g) : 1.0 - g, left = choice->similarity ? 1.0 - albedo * (1.0 - factor) : 1.0;
    out->medium = out->local.media[0];
    out->density_max = from->shape == NPH_SHAPE_GRID ? (Real)from->grid.max : R(1.0);
    out->majorant = out->medium.sigma_max * out->density_max;
    for (int k = 0; k < 2; k++) {
        double shrunk = k ? left : 1.0;
        out->gain[k] = (Real)(1.0 / shrunk);
        out->inverse_majorant[k] = (Real)(1.0 / (shrunk * (double)out->majorant));
        out->survival[k] = R(0.0);
        for (int c = 0; c < 3; c++) {
            out->albedo[k][c] = (Real)(k && choice->similarity ? from->albedo[c] * factor / left : from->albedo[c]);
            out->survival[k] = r_max(out->survival[k], out->albedo[k][c]);
        }
    }
    double order = 1.0, cosine = nph_abs(g), t = job->knobs[NPH_TPM_KNOB_SIMILARITY];
    if (choice->similarity && cosine > t) order = nph_log(t) / nph_log(cosine);
    out->switch_order = order < (double)NPH_TPM_ORDER_MAX ? (int)order + ((double)(int)order < order) : NPH_TPM_ORDER_MAX;
    out->similarity = choice->similarity;
}

static void prepare_march(const NphJob *job, const double metres[3], RTpmScene *out) {
    const double *knobs = job->knobs;
    double squared = 0.0;
    for (int a = 0; a < 3; a++) {
        double size = ((double)out->medium.hi[a] - (double)out->medium.lo[a]) * metres[a];
        squared += size * size;
    }
    out->step = (Real)(nph_sqrt(squared) / knobs[NPH_TPM_KNOB_STEPS]);
    out->exit = (Real)knobs[NPH_TPM_KNOB_EXIT];
    out->noise = (Real)knobs[NPH_TPM_KNOB_NOISE];
    out->octaves = (int)knobs[NPH_TPM_KNOB_OCTAVES];
    for (int i = 0; i < FIELD && out->noise > R(0.0); i++) {
        NphWords words = nph_philox(0, (uint32_t)NPH_RNG_TPM_NOISE << 24, (uint32_t)i, 0, 0, 0);
        out->field[3 * i] = 2.0f * nph_uniformf(words.w0) - 1.0f;
        out->field[3 * i + 1] = 2.0f * nph_uniformf(words.w1) - 1.0f;
        out->field[3 * i + 2] = 2.0f * nph_uniformf(words.w2) - 1.0f;
    }
}

void NPH_KERNEL(nph_tpm_prepare)(const NphJob *job, const NphTpmChoice *choice, void *memory) {
    RTpmScene *out = memory;
    double metres[3], volume, lo[3], hi[3];
    memset(out, 0, sizeof *out);
    r_prepare_scene(job->scene, &choice->transport, job->seed, job->frame, &out->local);
    out->traced = choice->traced;
    out->paper = job->knobs[NPH_TPM_KNOB_VARIANT] > 0.5;
    out->shared = choice->shared;
    out->half = job->knobs[NPH_TPM_KNOB_HALF] > 0.5;
    out->impostor = job->knobs[NPH_TPM_KNOB_IMPOSTORS] > 0.5;
    nph_tpm_small(job, out->small_origin, out->small);
    if (choice->medium < 0) return;
    nph_medium_bounds(&job->scene->media[choice->medium], lo, hi);
    for (int a = 0; a < 3; a++) out->centre[a] = 0.5 * (lo[a] + hi[a]);
    prepare_space(&job->scene->media[choice->medium], metres, &volume);
    prepare_medium(job, choice, out);
    prepare_grid(&out->medium, choice->cells, metres, &out->coarse);
    prepare_grid(&out->medium, choice->fine, metres, &out->fine);
    prepare_march(job, metres, out);
    out->upsampling = (int)job->knobs[NPH_TPM_KNOB_UPSAMPLING];
    out->reach = (int)job->knobs[NPH_TPM_KNOB_NEIGHBOURHOOD];
    out->spread = (Real)job->knobs[NPH_TPM_KNOB_SPREAD];
    out->spread_density = (Real)job->knobs[NPH_TPM_KNOB_SPREAD_DENSITY];
    for (int a = 0; a < 3 && choice->dominant >= 0; a++)
        out->towards[NPH_TPM_SUN][a] = (Real)-job->scene->lights[choice->dominant].direction[a];
    if (!choice->traced) return;
    prepare_lights(job, choice, out);
    out->dominant = choice->dominant;
    out->scale = nph_power_of_2((double)choice->scale);
    out->threshold = (Real)job->knobs[NPH_TPM_KNOB_THRESHOLD];
    out->orders = (int)job->knobs[NPH_TPM_KNOB_ORDERS];
    for (int a = 0; a < 3; a++)
        volume *= ((double)out->medium.hi[a] - (double)out->medium.lo[a]) / (double)choice->cells[a];
    out->fluence_per_unit = out->unit / out->scale / (double)out->majorant / volume;
}

/* Deposits are the fluence in units of unit / (s_T V) of the reference: where s_T V is another, they are multiplied by the ratio. */
void NPH_KERNEL(nph_tpm_adopt)(void *memory, const void *reference) {
    RTpmScene *scene = memory;
    const RTpmScene *from = reference;
    if (scene->traced && scene->fluence_per_unit > 0.0) {
        double ratio = scene->fluence_per_unit / scene->unit * (from->unit / from->fluence_per_unit);
        for (int k = 0; k < 2; k++) scene->gain[k] = (Real)((double)scene->gain[k] * ratio);
    }
    scene->unit = from->unit;
    scene->scale = from->scale;
    scene->fluence_per_unit = from->fluence_per_unit;
}

/* In print the sky's flux joins the sun's, and the mean cosine is divided by the number of the sun's photons. */
static void resolve_cell(const RTpmScene *scene, const int64_t *sum, int kind, double photons, Real *cell) {
    double per = photons > 0.0 ? scene->fluence_per_unit / photons : 0.0;
    double flux = 0.2126 * (double)sum[0] + 0.7152 * (double)sum[1] + 0.0722 * (double)sum[2];
    double weight = scene->paper ? (double)sum[NPH_TPM_COUNT] : flux;
    double cosine = weight > 0.0 ? (double)sum[NPH_TPM_COSINE] / weight : 0.0;
    int joined = kind == NPH_TPM_SKY && scene->paper;
    for (int c = 0; c < 3; c++) {
        Real fluence = (Real)((double)sum[c] * per);
        cell[NPH_TPM_I_SUN + c] += kind == NPH_TPM_SUN || joined ? fluence : R(0.0);
        cell[NPH_TPM_I_SKY + c] += kind == NPH_TPM_SKY && !joined ? fluence : R(0.0);
    }
    if (joined) return;
    cell[kind == NPH_TPM_SKY ? NPH_TPM_I_SKY_G : NPH_TPM_I_G] = (Real)(cosine > 1.0 ? 1.0 : cosine < -1.0 ? -1.0 : cosine);
    cell[kind == NPH_TPM_SKY ? NPH_TPM_I_SKY_DEPTH : NPH_TPM_I_DEPTH] = (Real)(weight > 0.0 ? (double)sum[NPH_TPM_ORDER] / weight : 0.0);
}

void NPH_KERNEL(nph_tpm_resolve)(const void *memory, const int64_t *sums, const double photons[NPH_TPM_KINDS], void *coarse) {
    const RTpmScene *scene = memory;
    int64_t cells = nph_tpm_cells(scene->coarse.n);
    for (int64_t i = 0; i < cells; i++) {
        Real *cell = (Real *)coarse + i * NPH_TPM_FIELDS;
        for (int v = 0; v < NPH_TPM_FIELDS; v++) cell[v] = R(0.0);
        for (int k = 0; k < NPH_TPM_KINDS; k++)
            resolve_cell(scene, sums + (k * cells + i) * NPH_TPM_VALUES, k, photons[k], cell);
    }
}

static void three(NphFactFn fact, void *user, const char *name, const int32_t n[3]) {
    fact(user, -1, name, 3, (double[]){(double)n[0], (double)n[1], (double)n[2]});
}

void NPH_KERNEL(nph_tpm_facts)(const void *memory, const NphTpmChoice *choice, NphFactFn fact, void *user) {
    const RTpmScene *scene = memory;
    const RScene *local = &scene->local;
    double small[4] = {(double)scene->small_origin[0], (double)scene->small_origin[1], (double)scene->small[0], (double)scene->small[1]};
    three(fact, user, "cells", choice->cells);
    three(fact, user, "fine", choice->fine);
    fact(user, -1, "photons_of_generation", 2, (double[]){(double)choice->photons[0], (double)choice->photons[1]});
    fact(user, -1, "generations", 1, (double[]){(double)choice->generations});
    fact(user, -1, "small", 4, small);
    r_fact(fact, user, "step", scene->step);
    if (choice->traced) {
        double cones[4 * NPH_MAX_LIGHTS], towards[3];
        for (int a = 0; a < 3; a++) towards[a] = (double)scene->towards[NPH_TPM_SUN][a];
        for (int l = 0; l < local->light_count; l++) {
            for (int a = 0; a < 3; a++) cones[4 * l + a] = (double)scene->from[l].axis[a];
            cones[4 * l + 3] = (double)scene->from[l].width;
        }
        fact(user, -1, "unit_W", 1, &scene->unit);
        fact(user, -1, "fixed_point_scale", 1, &scene->scale);
        fact(user, -1, "dominant", 1, (double[]){(double)scene->dominant});
        fact(user, -1, "towards", 3, towards);
        r_fact(fact, user, "majorant", scene->majorant);
        fact(user, -1, "switch_order", 1, (double[]){scene->similarity ? (double)scene->switch_order : -1.0});
        fact(user, -1, "gain", 2, (double[]){(double)scene->gain[0], (double)scene->gain[1]});
        fact(user, -1, "bounds_lo", 3, local->bounds_lo);
        fact(user, -1, "bounds_hi", 3, local->bounds_hi);
        fact(user, -1, "choose", local->light_count + 1, scene->choose);
        fact(user, -1, "cones", 4 * local->light_count, cones);
    }
    r_scene_facts(local, 1, fact, user);
}
