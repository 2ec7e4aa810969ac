/* SPDX-License-Identifier: Apache-2.0
 *
 * What light tracing needs of a scene: where photons start, which light how often, what can be left out, and what it
 * cannot do. */
#include <math.h>
#include <string.h>

#include "core/message.h"
#include "pipeline/plan.h"
#include "truth/light/light_tracing.h"

enum { DECAY_MOMENTS = 400 };

static const double pi = 3.14159265358979323846;

static double luminance(const double c[3]) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; }

static void widen(double lo[3], double hi[3], const double at_lo[3], const double at_hi[3]) {
    for (int a = 0; a < 3; a++) {
        if (at_lo[a] < lo[a]) lo[a] = at_lo[a];
        if (at_hi[a] > hi[a]) hi[a] = at_hi[a];
    }
}

/* The box of everything that has ends, and the heights of everything that has none; world space. */
static void find_extents(const NphJob *job, const NphTransportChoice *choice, NphLightAim *aim) {
    const NphScene *scene = job->scene;
    double slab[2] = {HUGE_VAL, -HUGE_VAL};
    for (int a = 0; a < 3; a++) {
        aim->lo[a] = HUGE_VAL;
        aim->hi[a] = -HUGE_VAL;
    }
    for (int m = 0; m < scene->medium_count; m++) {
        double lo[3], hi[3];
        if (!choice->used[m]) continue;
        nph_medium_bounds(&scene->media[m], lo, hi);
        if (scene->media[m].shape == NPH_SHAPE_LAYER) {
            slab[0] = fmin(slab[0], lo[2]);
            slab[1] = fmax(slab[1], hi[2]);
            aim->unbounded = 1;
        } else {
            widen(aim->lo, aim->hi, lo, hi);
        }
    }
    for (int32_t v = 0; v < scene->bvh.vertex_count; v++) {
        double at[3];
        for (int a = 0; a < 3; a++) at[a] = scene->bvh.vertices[3 * v + a] + scene->bvh.origin[a];
        widen(aim->lo, aim->hi, at, at);
    }
    aim->box = aim->lo[0] <= aim->hi[0];
    for (int s = 0; s < scene->surface_count; s++) {
        if (!scene->surfaces[s].is_plane) continue;
        aim->unbounded = 1;
        slab[0] = fmin(slab[0], scene->surfaces[s].height_m);
        slab[1] = fmax(slab[1], scene->surfaces[s].height_m);
    }
    memcpy(aim->slab, slab, sizeof slab);
}

/* Planes get all their light by photons that hit them: those are aimed at the highest one; else at the layers' middle. */
static double level_of(const NphScene *scene, const NphLightAim *aim) {
    double level = -HUGE_VAL;
    for (int s = 0; s < scene->surface_count; s++)
        if (scene->surfaces[s].is_plane) level = fmax(level, scene->surfaces[s].height_m);
    return level > -HUGE_VAL ? level : 0.5 * aim->slab[0] + 0.5 * aim->slab[1];
}

static double half_diagonal(const NphLightAim *aim) {
    double sum = 0.0;
    for (int a = 0; a < 3 && aim->box; a++) sum += (aim->hi[a] - aim->lo[a]) * (aim->hi[a] - aim->lo[a]);
    return 0.5 * sqrt(sum);
}

static double half_diagonal_of(const double half[2]) { return sqrt(half[0] * half[0] + half[1] * half[1]); }

/* Feet on the level: of the sensor (of what an orthographic camera looks at), and of the box. */
static void place_feet(const NphScene *scene, NphLightAim *aim) {
    const NphSensor *sensor = &scene->sensor;
    double *foot = aim->centre[0], *other = aim->centre[1], drop = aim->level - sensor->position[2];
    int wide = sensor->kind != NPH_SENSOR_PERSPECTIVE && sensor->kind != NPH_SENSOR_FISHEYE;
    memcpy(foot, sensor->position, sizeof aim->centre[0]);
    if (wide && !nph_sensor_gathers(sensor->kind) && drop * sensor->seen[2] > 0.0)
        for (int a = 0; a < 2; a++) foot[a] += drop / sensor->seen[2] * sensor->seen[a];
    foot[2] = fabs(drop);
    if (wide) foot[2] = fmax(foot[2], half_diagonal_of(sensor->half_size));
    foot[2] = fmax(foot[2], 0.1 * (aim->slab[1] - aim->slab[0]));
    for (int a = 0; a < 2; a++) other[a] = 0.5 * aim->lo[a] + 0.5 * aim->hi[a];
    other[2] = fabs(aim->level - 0.5 * aim->lo[2] - 0.5 * aim->hi[2]) + half_diagonal(aim);
    if (!aim->box) memcpy(other, foot, sizeof aim->centre[1]);
    foot[2] = foot[2] > 0.0 ? foot[2] : other[2] > 0.0 ? other[2] : 1.0;
}

static int has_points(const NphScene *scene) {
    for (int l = 0; l < scene->light_count; l++)
        if (scene->lights[l].kind == NPH_LIGHT_POINT) return 1;
    return 0;
}

/* The lattice of shifts (columns: along x and y, in steps) on the sensor; 0 when it does not map the sensor's plane onto
 * itself, or an orthographic camera stands within what repeats. */
static int place_lattice(const NphScene *scene, double steps[2][2], NphLightAim *aim) {
    const NphSensor *sensor = &scene->sensor;
    const double *n = sensor->forward, *h = sensor->half_size;
    double reach = h[0] * fabs(sensor->right[2]) + h[1] * fabs(sensor->up[2]), z = sensor->position[2];
    if (sensor->kind == NPH_SENSOR_PERSPECTIVE || sensor->kind == NPH_SENSOR_FISHEYE) return 0;
    if (sensor->kind == NPH_SENSOR_ORTHOGRAPHIC) {
        int above = z - reach >= aim->slab[1] && n[2] < -1e-6, below = z + reach <= aim->slab[0] && n[2] > 1e-6;
        if (!above && !below) return 0;
    } else if (fabs(n[2]) < 1.0 - 1e-12) {
        return 0;
    }
    for (int k = 0; k < 2; k++) {
        double step[3] = {steps[0][k], steps[1][k], 0.0};
        aim->st_from_steps[0][k] = (step[0] * sensor->right[0] + step[1] * sensor->right[1]) / h[0];
        aim->st_from_steps[1][k] = (step[0] * sensor->up[0] + step[1] * sensor->up[1]) / h[1];
    }
    double(*m)[2] = aim->st_from_steps, determinant = m[0][0] * m[1][1] - m[0][1] * m[1][0];
    aim->steps_from_st[0][0] = m[1][1] / determinant;
    aim->steps_from_st[0][1] = -m[0][1] / determinant;
    aim->steps_from_st[1][0] = -m[1][0] / determinant;
    aim->steps_from_st[1][1] = m[0][0] / determinant;
    memcpy(aim->steps, steps, sizeof aim->steps);
    aim->area = fabs(steps[0][0] * steps[1][1] - steps[0][1] * steps[1][0]);
    aim->wrapped = 1;
    return 1;
}

/* Nothing changes along x and y: the lattice is the sensor's own, so that every crossing counts once. The steps are the
 * sides of its rectangle, moved along the viewing direction to be level. */
static void wrap_invariant(const NphScene *scene, NphLightAim *aim) {
    const NphSensor *s = &scene->sensor;
    double steps[2][2];
    if (aim->box || !aim->unbounded || has_points(scene)) return;
    if (s->kind == NPH_SENSOR_PERSPECTIVE || s->kind == NPH_SENSOR_FISHEYE || fabs(s->forward[2]) < 1e-6) return;
    for (int a = 0; a < 2; a++) {
        steps[a][0] = 2.0 * s->half_size[0] * (s->right[a] - s->right[2] / s->forward[2] * s->forward[a]);
        steps[a][1] = 2.0 * s->half_size[1] * (s->up[a] - s->up[2] / s->forward[2] * s->forward[a]);
    }
    place_lattice(scene, steps, aim);
}

static NphStatus wrap_period(const NphJob *job, NphLightAim *aim) {
    const NphPeriod *period = &job->scene->period;
    double steps[2][2] = {{period->hi[0] - period->lo[0], 0.0}, {0.0, period->hi[1] - period->lo[1]}};
    if (!period->on[0] || !period->on[1])
        return nph_error(job->context, NPH_BAD_USAGE,
                         "light: sides repeat along one axis only; light tracing needs both x and y, or neither");
    if (aim->box) {
        aim->slab[0] = fmin(aim->slab[0], aim->lo[2]);
        aim->slab[1] = fmax(aim->slab[1], aim->hi[2]);
    }
    if (!place_lattice(job->scene, steps, aim))
        return nph_error(job->context, NPH_BAD_USAGE,
                         "light: sides repeat, so that every vertex is seen at infinitely many places: only level sensors of "
                         "flux, fluence and radiance, and orthographic cameras outside of all media, can be met");
    aim->box = 0;
    aim->unbounded = 1;
    return NPH_OK;
}

/* The sphere around the box and a flux sensor's rectangle, where planes or layers have no end. */
static void place_target(const NphScene *scene, NphLightAim *aim) {
    const NphSensor *s = &scene->sensor;
    double lo[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, hi[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}, sum = 0.0;
    if (!aim->unbounded || aim->wrapped) return;
    if (aim->box) widen(lo, hi, aim->lo, aim->hi);
    for (int corner = 0; corner < 4 && s->kind == NPH_SENSOR_FLUX; corner++) {
        double at[3], x = corner & 1 ? s->half_size[0] : -s->half_size[0], y = corner & 2 ? s->half_size[1] : -s->half_size[1];
        for (int a = 0; a < 3; a++) at[a] = s->position[a] + x * s->right[a] + y * s->up[a];
        widen(lo, hi, at, at);
    }
    if (lo[0] > hi[0]) return;
    for (int a = 0; a < 3; a++) {
        aim->target[a] = 0.5 * lo[a] + 0.5 * hi[a];
        sum += 0.25 * (hi[a] - lo[a]) * (hi[a] - lo[a]);
    }
    aim->target[3] = sqrt(sum);
}

static void to_local(const NphScene *scene, NphLightAim *aim) {
    double origin[3];
    nph_scene_origin(scene, origin);
    for (int a = 0; a < 3; a++) {
        aim->lo[a] -= origin[a];
        aim->hi[a] -= origin[a];
        aim->target[a] -= origin[a];
        for (int k = 0; k < 2 && a < 2; k++) aim->centre[k][a] -= origin[a];
    }
    aim->level -= origin[2];
    for (int k = 0; k < 2; k++) aim->slab[k] -= origin[2];
}

static NphStatus place_aim(const NphJob *job, const NphTransportChoice *choice, NphLightAim *aim) {
    const NphScene *scene = job->scene;
    find_extents(job, choice, aim);
    if (scene->period.on[0] || scene->period.on[1]) NPH_TRY(wrap_period(job, aim));
    else wrap_invariant(scene, aim);
    if (aim->unbounded) {
        aim->level = level_of(scene, aim);
        place_feet(scene, aim);
    } else {
        aim->centre[0][2] = half_diagonal(aim);
    }
    place_target(scene, aim);
    to_local(scene, aim);
    return NPH_OK;
}

/* About the power that a light sends into the scene; only how often it is chosen depends on it. */
static double power_of(const NphLight *light, const NphLightAim *aim) {
    double side[3], surface = 0.0;
    for (int a = 0; a < 3; a++) side[a] = aim->box ? aim->hi[a] - aim->lo[a] : 0.0;
    for (int a = 0; a < 3; a++) surface += 2.0 * side[a] * side[(a + 1) % 3];
    if (aim->unbounded) surface += 2.0 * pi * aim->centre[0][2] * aim->centre[0][2];
    switch (light->kind) {
    case NPH_LIGHT_POINT: return 4.0 * pi * luminance(light->intensity);
    case NPH_LIGHT_SUN: return luminance(light->irradiance) * 0.25 * surface;
    case NPH_LIGHT_CONSTANT: return luminance(light->radiance) * pi * surface * (light->hemisphere ? 0.5 : 1.0);
    case NPH_LIGHT_ENVIRONMENT: break;
    }
    return light->map.total * 0.25 * surface;
}

static int is_met(const NphLight *light, const NphLightAim *aim) {
    return light->kind == NPH_LIGHT_POINT || aim->box || aim->unbounded;
}

/* Of the lights, then of the media's own light. Probabilities: nine tenths by power, one tenth alike, so that a wrong guess costs little. No light, no photons. */
static void choose_lights(const NphScene *scene, const NphEmissionSources *sources, NphLightChoice *choice) {
    int count = scene->light_count + 1;
    double power[NPH_MAX_LIGHTS + 1], sum = 0.0, lit = 0.0, at = 0.0;
    for (int l = 0; l < count; l++) {
        power[l] = 0.0;
        if (l == scene->light_count) power[l] = 4.0 * pi * sources->total;
        else if (is_met(&scene->lights[l], &choice->aim)) power[l] = power_of(&scene->lights[l], &choice->aim);
        sum += power[l];
        lit += power[l] > 0.0;
    }
    if (!(sum > 0.0)) {
        choice->photons = 0;
        return;
    }
    choice->unit = sum / (double)choice->photons;
    for (int l = 0; l < count; l++) {
        choice->reach[l] = at;
        if (power[l] > 0.0) at += 0.9 * power[l] / sum + 0.1 / lit;
    }
    choice->reach[count] = at;
    for (int l = count; l >= 0; l--) choice->reach[l] = choice->reach[l] == at ? 1.0 : choice->reach[l];
}

/* How fast light dies out deep in a medium of albedo w and Henyey-Greenstein's phase function: as exp(-k tau). With moments
 * f_l of the intensity, transport is k ((l + 1) f_{l+1} + l f_{l-1}) = (2 l + 1) (1 - w g^l) f_l, so 1 / k is the largest
 * eigenvalue of the symmetric tridiagonal matrix with (l + 1)^2 / ((2 l + 1) h_l (2 l + 3) h_{l+1}), h_l = 1 - w g^l, as
 * squares of its off-diagonal. It is above x where a pivot of the matrix minus x is positive (Sturm). k is at most 1, the
 * rate of light that never scatters. */
static double decay_of(double w, double g) {
    double slow = 0.0, fast = 1.0;
    for (int i = 0; i < 40; i++) {
        double k = 0.5 * (slow + fast), pivot = -1.0 / k, power = 1.0;
        int above = 0;
        for (int l = 0; l < DECAY_MOMENTS && !above; l++) {
            double next = power * g, h0 = 1.0 - w * power, h1 = 1.0 - w * next;
            double square = (double)(l + 1) * (double)(l + 1) / ((2.0 * l + 1.0) * h0 * (2.0 * l + 3.0) * h1);
            pivot = -1.0 / k - square / pivot;
            above = pivot > 0.0;
            power = next;
        }
        if (above) fast = k;
        else slow = k;
    }
    return fast;
}

/* Splitting: the rate of the channel that goes deepest, times the knob. */
static void choose_split(const NphJob *job, NphLightChoice *choice) {
    const NphScene *scene = job->scene;
    double knob = job->knobs[NPH_LIGHT_KNOB_SPLIT];
    int layers = 1;
    for (int m = 0; m < scene->medium_count; m++)
        layers &= !choice->transport.used[m] || scene->media[m].shape == NPH_SHAPE_LAYER;
    choice->split = knob > 0.0 && layers && scene->sensor.kind == NPH_SENSOR_FLUX && fabs(scene->sensor.forward[2]) > 0.999;
    for (int m = 0; m < scene->medium_count && choice->split; m++) {
        const NphMedium *medium = &scene->media[m];
        double rate = HUGE_VAL, g = nph_phase_mean_cosine(&medium->phase);
        for (int c = 0; c < 3; c++) {
            double w = medium->albedo[c], decay = w < 1.0 ? decay_of(w, g) : 0.0;
            rate = fmin(rate, decay * medium->extinction_per_m[c]);
        }
        choice->importance[m] = knob * rate;
    }
}

NphStatus nph_light_choose(const NphJob *job, const NphEmissionSources *sources, NphLightChoice *choice) {
    const NphSensor *sensor = &job->scene->sensor;
    double photons = job->knobs[NPH_LIGHT_KNOB_PHOTONS];
    NphLightChoice made;
    memset(&made, 0, sizeof made);
    nph_transport_choose(job->scene, job->plan_full, &made.transport);
    NPH_TRY(nph_transport_refuse_air(job->context, job->scene, "light"));
    NPH_TRY(place_aim(job, &made.transport, &made.aim));
    made.photons = photons > 0.0 ? (int64_t)photons : (int64_t)sensor->width * sensor->height;
    made.expected = !(job->knobs[NPH_LIGHT_KNOB_COUNT] > 0.0);
    if (made.photons > UINT32_MAX)
        return nph_error(job->context, NPH_BAD_USAGE, "light: %lld photons a sample; at most 4294967295: set light.photons",
                         (long long)made.photons);
    choose_lights(job->scene, sources, &made);
    choose_split(job, &made);
    *choice = made;
    return NPH_OK;
}

static NphStatus plan_choice(const NphJob *job, const NphLightChoice *choice, NphPlan *plan) {
    NphContext *context = job->context;
    const char *where = choice->aim.wrapped     ? "uniform over a period; every crossing stands for a lattice of them"
                        : choice->aim.unbounded ? "aimed at a level plane, around box and sensor"
                                                : "uniform over the box of media and meshes as the light sees it";
    NPH_TRY(nph_plan_add(context, plan, "stage", "light.trace", 0, "%lld photons a sample, %s", (long long)choice->photons,
                         where));
    if (job->scene->sensor.kind == NPH_SENSOR_FLUX)
        NPH_TRY(nph_plan_add(context, plan, "stage", "light.trace", 0, "crossings of the sensor: %s",
                             choice->expected ? "their expected value at every flight" : "counted"));
    if (job->knobs[NPH_LIGHT_KNOB_SPLIT] > 0.0 && !choice->split)
        NPH_TRY(nph_plan_add(context, plan, "warning", "light.split", 0,
                             "not used: it takes a level flux sensor and media that are layers"));
    return NPH_OK;
}

NphStatus nph_light_sources(const NphJob *job, NphEmissionSources *sources) {
    NphTransportChoice choice;
    nph_transport_choose(job->scene, job->plan_full, &choice);
    return nph_emission_sources(job->context, job->scene, &choice, sources);
}

NphStatus nph_light_plan(const NphJob *job, NphPlan *plan) {
    NphContext *context = job->context;
    const NphScene *scene = job->scene;
    NphLightChoice choice;
    NphLightKernels kernels;
    NphEmissionSources sources;
    NPH_TRY(nph_light_sources(job, &sources));
    NphStatus status = nph_light_choose(job, &sources, &choice);
    uint64_t cells = (uint64_t)sources.count * (sizeof *sources.cells + sizeof *sources.cdf);
    nph_emission_sources_free(context, &sources);
    NPH_TRY(status);
    nph_light_kernels(nph_context_isa(context), job->precision, &kernels);
    for (int s = 0; s < nph_light.stage_count; s++) {
        const NphStage *stage = &nph_light.stages[s];
        NPH_TRY(nph_plan_add(context, plan, "stage", stage->name, 0, "%s; blocks of %d", stage->source, stage->block[0]));
    }
    NPH_TRY(plan_choice(job, &choice, plan));
    NPH_TRY(nph_transport_plan(context, scene, &choice.transport, plan));
    const int *crop = job->crop;
    int channels = choice.transport.film_channels;
    uint64_t pixels = (uint64_t)(crop[2] - crop[0]) * (uint64_t)(crop[3] - crop[1]);
    uint64_t threads = (uint64_t)nph_context_threads(context), sample_buffer = nph_light_sample_bytes(job->precision);
    NPH_TRY(nph_plan_add(context, plan, "buffer", "light.scene", kernels.scene_bytes() + cells,
                         "what the kernels see, cells that emit"));
    NPH_TRY(nph_plan_add(context, plan, "buffer", "light.image", pixels * (uint64_t)(channels + 1) * 8 * NPH_CHUNK,
                         "%d images of the photons, one a sample", NPH_CHUNK));
    NPH_TRY(nph_plan_add(context, plan, "buffer", "light.flight", threads * kernels.batch_bytes(),
                         "%d photons, %d flights and splats, one batch a thread", NPH_LIGHT_BLOCK, NPH_LIGHT_FLIGHTS));
    uint64_t traced = nph_light_traced_doubles(channels) * sizeof(double);
    NPH_TRY(nph_plan_add(context, plan, "buffer", "light.sample", threads * (traced + sample_buffer + nph_film_scratch_bytes(channels)),
                         "a tile's part of the images, samples and film scratch, one a thread"));
    return nph_plan_add(context, plan, "buffer", "film.node",
                        nph_film_forecast_bytes(scene->sensor.width, scene->sensor.height, crop, channels,
                                                job->sample_begin, job->sample_end) +
                            nph_film_forecast_shared_bytes(scene->sensor.width, scene->sensor.height, crop, channels,
                                                           job->sample_begin, job->sample_end),
                        "moments of %d x %d pixels, of their tiles and the image", crop[2] - crop[0], crop[3] - crop[1]);
}
