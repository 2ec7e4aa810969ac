/* SPDX-License-Identifier: Apache-2.0
 *
 * shdom.march: what a camera ray sees, with the extinction that delta-M leaves, sigma' = (1 - albedo f) sigma:
 *   L = integral of sigma' e^-tau' S(x, w) dt  +  light scattered once  +  lights at infinity e^-tau'
 * S: the source function of light that was scattered before, looked up at three places of every cell of the grid that the ray crosses
 * and interpolated as a parabola, against the weight sigma' e^-tau' that is integrated through the density itself (single_profile.h).
 * Light of suns and points that is scattered once comes from single's quadrature with the whole phase function, albedo / (1 - albedo f)
 * and sigma' [Nakajima88 TMS]; or, `shdom.single` 0, from the grid. Discs of suns are seen through the true extinction, as the light
 * that delta-M adds to them is single scattering's. */
#include <assert.h>
#include <string.h>

#include "core/fmath.h"
#include "transport/vertex_lookup.h"
#include "truth/shdom/shdom_ray.h"

void nph_shdom_scale_scene(const NphShdomChoice *choice, NphSingleScene *scene) {
    RScene *local = &scene->local;
    for (int m = 0; m < local->medium_count; m++) {
        RMedium *medium = &local->media[m];
        medium->sigma_max = 0.0;
        for (int c = 0; c < 3; c++) {
            medium->sigma[c] *= choice->kept[c];
            medium->albedo[c] /= choice->kept[c];
            medium->sigma_max = medium->sigma[c] > medium->sigma_max ? medium->sigma[c] : medium->sigma_max;
        }
    }
}

/* One source of eight corners; [basis][rows of sums]. */
size_t nph_shdom_look_doubles(const NphShdomChoice *choice) {
    return NPH_SHDOM_TERMS_MAX + (size_t)choice->channels * (size_t)choice->angles.terms * (size_t)(1 + choice->looks);
}

void nph_shdom_ray_begin(const NphShdomCamera *camera, const NphShdomRoom *room, const double p[3], const double d[3], NphShdomRay *ray) {
    const NphShdomGrid *grid = &camera->choice->grid;
    memset(ray, 0, sizeof *ray);
    ray->camera = camera;
    ray->room = room;
    for (int a = 0; a < 3; a++) {
        const double *row = grid->from_local + 4 * a;
        ray->p[a] = p[a];
        ray->d[a] = d[a];
        ray->u[a] = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
        ray->w[a] = row[0] * d[0] + row[1] * d[1] + row[2] * d[2];
    }
    if (camera->field) nph_shdom_harmonics(camera->choice->angles.bands, (double[3]){-d[0], -d[1], -d[2]}, room->look);
}

/* Where the ray, at `middle`, is in a cell of the grid; places beyond an open side are in its last cell. */
static void cell_at(const NphShdomGrid *grid, const NphShdomRay *ray, double middle, double cell[3]) {
    for (int a = 0; a < 3; a++) {
        cell[a] = nph_floor(ray->u[a] + middle * ray->w[a]);
        if (!grid->periodic[a]) cell[a] = r_clamp(cell[a], 0.0, (double)(grid->cells[a] - 1));
    }
}

/* The source function at t, in a cell: of all channels. */
static void look_at(const NphShdomRay *ray, const double cell[3], double t, double source[3]) {
    const NphShdomChoice *choice = ray->camera->choice;
    const NphShdomGrid *grid = &choice->grid;
    NphShdomLook look = {.rows = choice->channels * (1 + choice->looks), .terms = choice->angles.terms, .basis = ray->room->look,
                         .room = ray->room->look + NPH_SHDOM_TERMS_MAX};
    int64_t low[3], high[3], in[3];
    double part[3], out[6];
    for (int a = 0; a < 3; a++) {
        double n = (double)grid->cells[a], wrapped = cell[a] - n * nph_floor(cell[a] / n);
        part[a] = r_clamp(ray->u[a] + t * ray->w[a] - cell[a], 0.0, 1.0);
        in[a] = low[a] = (int64_t)wrapped;
        high[a] = (low[a] + 1) % grid->points[a];
    }
    for (int i = 0; i < 8; i++) {
        int64_t x = i & 1 ? high[0] : low[0], y = i & 2 ? high[1] : low[1], z = i & 4 ? high[2] : low[2];
        look.points[i] = (z * grid->points[1] + y) * grid->points[0] + x;
        look.weights[i] = (i & 1 ? part[0] : 1.0 - part[0]) * (i & 2 ? part[1] : 1.0 - part[1]) * (i & 4 ? part[2] : 1.0 - part[2]);
    }
    ray->camera->kernels.look(&look, ray->camera->field, out);
    int64_t number = (in[2] * grid->cells[1] + in[1]) * grid->cells[0] + in[0];
    for (int c = 0; c < choice->channels; c++) {
        source[c] = out[c] + ray->camera->kernels.load(ray->camera->bubble, c * grid->cell_count + number);
        if (!choice->looks) continue;
        source[c] += out[choice->channels + c] * ray->camera->kernels.load(ray->camera->share, c * grid->cell_count + number);
    }
}

/* Where the ray meets the next plane of the grid behind t, at `limit` at most; open sides are none. */
static double cell_end(const NphShdomGrid *grid, const NphShdomRay *ray, double t, double limit) {
    double end = limit;
    for (int a = 0; a < 3; a++) {
        double at = ray->u[a] + t * ray->w[a], last = (double)grid->cells[a] - 1.0, plane;
        if (!(nph_abs(ray->w[a]) > 1e-300)) continue;
        if (ray->w[a] > 0.0) {
            plane = nph_floor(at + 1e-9) + 1.0;
            if (!grid->periodic[a] && plane < 1.0) plane = 1.0;
        } else {
            plane = -nph_floor(1e-9 - at) - 1.0;
            if (!grid->periodic[a] && plane > last) plane = last;
        }
        if (!grid->periodic[a] && (plane < 1.0 || plane > last)) continue;
        double reach = (plane - ray->u[a]) / ray->w[a];
        end = reach > t && reach < end ? reach : end;
    }
    return end;
}

/* Weights of the stretch within one cell: integrals of sigma' e^-tau' x^k, x from 0 to 1 along it; first collisions. */
typedef struct Weights {
    double of[3][3];
    int any;
} Weights;

static void add_point(NphShdomRay *ray, const NphPlace *place, double t, double h, double x, Weights *weights) {
    const NphSingleScene *scene = ray->camera->scene;
    const RScene *local = &scene->local;
    double density[NPH_SINGLE_FIELDS], tau[3];
    assert(local->medium_count <= NPH_SINGLE_FIELDS);
    nph_profile_at(&ray->room->scratch->profile, place, t, density, tau);
    for (int c = 0; c < local->channels; c++) {
        double rate = density[0] * local->media[0].sigma[c], passes = h * rate * r_exp(-tau[c]), kept = ray->camera->choice->kept[c];
        weights->of[c][0] += passes;
        weights->of[c][1] += passes * x;
        weights->of[c][2] += passes * x * x;
        ray->distance += (ray->start + t) * h * rate / kept * r_exp(-tau[c] / kept);
    }
    weights->any = 1;
}

static void weigh(NphShdomRay *ray, NphPlace *place, double from, double to, Weights *weights) {
    const NphProfile *profile = &ray->room->scratch->profile;
    double t = from, scale = 1.0 / (to - from);
    memset(weights, 0, sizeof *weights);
    while (t < to) {
        double e = nph_profile_move(profile, place, t, to);
        if (!(e > t)) return;
        while (place->active && t < e) {
            double thin = nph_profile_thin(profile, place, t, e);
            for (int g = 0; g < NPH_GAUSS; g++) {
                double at = t + (thin - t) * nph_gauss_point[g];
                add_point(ray, place, at, (thin - t) * nph_gauss_weight[g], (at - from) * scale, weights);
            }
            t = thin;
        }
        t = e;
    }
}

/* What the grid sends along the part of the ray that the profile describes. */
static void add_grid(NphShdomRay *ray) {
    const NphShdomCamera *camera = ray->camera;
    const NphShdomGrid *grid = &camera->choice->grid;
    const NphProfile *profile = &ray->room->scratch->profile;
    const RScene *local = &camera->scene->local;
    double t = profile->begin, cell[3], source[3][3];
    NphPlace place;
    Weights w;
    nph_profile_seek(profile, t, &place);
    if (profile->count[0] == 0) return;
    t = profile->pieces[0][0].t0 > t ? profile->pieces[0][0].t0 : t;
    double last = profile->pieces[0][profile->count[0] - 1].t1 < profile->end ? profile->pieces[0][profile->count[0] - 1].t1 : profile->end;
    while (t < last) {
        double end = cell_end(grid, ray, t, last);
        if (!(end > t)) break;
        weigh(ray, &place, t, end, &w);
        if (w.any && camera->field) {
            cell_at(grid, ray, 0.5 * (t + end), cell);
            for (int k = 0; k < 3; k++) look_at(ray, cell, t + 0.5 * k * (end - t), source[k]);
            for (int c = 0; c < camera->choice->channels; c++) {
                const double *of = w.of[local->channels > 1 ? c : 0];
                double a = source[0][c], b = source[1][c], e = source[2][c];
                ray->grid[c] += of[0] * a + of[1] * (4.0 * b - 3.0 * a - e) + of[2] * (2.0 * a - 4.0 * b + 2.0 * e);
            }
        }
        t = end;
    }
}

/* Suns and points, scattered once in that part. phase: of the cut function, or NULL for the whole one. */
static void add_single(NphShdomRay *ray, const RCameraRay *camera_ray, const NphSingleAsk *ask, int cut) {
    const NphShdomCamera *camera = ray->camera;
    const RScene *local = &camera->scene->local;
    for (int l = 0; l < local->light_count; l++) {
        const RLight *light = &local->lights[l];
        NphBeam beam;
        RCameraRay turned = *camera_ray;
        double result[3] = {0.0, 0.0, 0.0}, error[3] = {0.0, 0.0, 0.0};
        if (!light->sampled || (light->kind != NPH_LIGHT_SUN && light->kind != NPH_LIGHT_POINT)) continue;
        memcpy(turned.d, ray->d, sizeof turned.d);
        nph_single_beam(camera->scene, &turned, ask, l, NULL, &beam);
        if (cut && !beam.point) {
            for (int a = 0; a < 3; a++) beam.d[a] = light->direction[a];
            for (int c = 0; c < 3; c++) beam.value[c] = camera->scene->beam[l][c];
            beam.phase[0] = nph_shdom_cut_phase(&camera->choice->angles, r_dot(ray->d, beam.d), 0) * (1.0 - camera->choice->angles.cut) *
                            0.079577471545947667884;
        }
        nph_single_integrate(camera->scene, ray->room->scratch, ray->p, ray->d, &beam, result, error);
        for (int c = 0; c < 3; c++) ray->once[c] += result[local->channels > 1 ? c : 0] * beam.value[c];
        nph_single_tell(ask, "    light %d, scattered once: %.9g per unit, error at most %.2g by estimate", l, result[0], error[0]);
    }
}

/* Stretch by stretch, to the end or to where nothing is seen; tau: of all. */
void nph_shdom_ray_follow(NphShdomRay *ray, const RCameraRay *camera_ray, const NphSingleAsk *ask, int cut) {
    const NphShdomCamera *camera = ray->camera;
    const RScene *local = &camera->scene->local;
    NphProfile *profile = &ray->room->scratch->profile;
    int single = !camera->choice->looks && camera->choice->transport.scatters;
    profile->end = profile->total[0] = 0.0;
    ray->start = camera_ray->start;
    do {
        nph_profile_build(profile, camera->scene, ray->p, ray->d, R_HUGE, &ray->room->scratch->tally.walked);
        if (local->medium_count == 0) break;
        add_grid(ray);
        if (single) add_single(ray, camera_ray, ask, cut);
        nph_single_tell(ask, "  %g m to %g m: optical depth %.9g at the end; from the grid so far %.9g, scattered once %.9g", profile->begin,
                        profile->end, local->media[0].sigma[0] * profile->total[0], ray->grid[0], ray->once[0]);
    } while (!profile->opaque && profile->end < R_HUGE);
    for (int c = 0; c < local->channels; c++) {
        double tau = local->medium_count > 0 ? local->media[0].sigma[c] * profile->total[0] : 0.0;
        ray->passes[c] = profile->opaque ? 0.0 : r_exp(-tau);
        ray->true_passes[c] = profile->opaque ? 0.0 : r_exp(-tau / camera->choice->kept[c]);
    }
}

double nph_shdom_ray_channel(const NphShdomRay *ray, const double value[3], int c) {
    return value[ray->camera->scene->local.channels > 1 ? c : 0];
}

void nph_shdom_ray_add(const NphShdomCamera *camera, const double light[3], int order, double fields[NPH_SAMPLE_FIELDS]) {
    (void)camera;
    for (int c = 0; c < 3; c++) fields[NPH_SAMPLE_L0 + c] += light[c];
    fields[NPH_SAMPLE_ORDER] += (double)order * r_luminance(light);
}

/* Grey grids are the same in all channels. */
void nph_shdom_ray_spread(const NphShdomRay *ray, double light[3]) {
    for (int c = 0; c < 3; c++) light[c] = ray->grid[ray->camera->choice->channels > 1 ? c : 0];
}

/* Constant lights and maps behind the cut extinction, discs of suns behind the true one. */
static void see_lights(const NphShdomRay *ray, double light[3]) {
    const RScene *local = &ray->camera->scene->local;
    for (int l = 0; l < local->light_count; l++) {
        const RLight *of = &local->lights[l];
        double value[3] = {0.0, 0.0, 0.0};
        int disc = of->kind == NPH_LIGHT_SUN && of->disc.width > 0.0 && r_disc_holds(&of->disc, ray->d);
        if (of->kind == NPH_LIGHT_ENVIRONMENT) (void)r_environment_lookup(&of->map, ray->d, value);
        int seen = of->kind == NPH_LIGHT_CONSTANT && (of->hemisphere == 0 || ray->d[2] * (double)of->hemisphere > 0.0);
        for (int c = 0; c < 3; c++) {
            if (seen || disc) value[c] = of->value[c];
            light[c] += value[c] * nph_shdom_ray_channel(ray, disc && !ray->camera->choice->looks ? ray->true_passes : ray->passes, c);
        }
    }
}

void nph_shdom_march(const NphShdomCamera *camera, const NphShdomRoom *room, const RCameraRay *camera_ray, const NphSingleAsk *ask,
                     double fields[NPH_SAMPLE_FIELDS]) {
    const RScene *local = &camera->scene->local;
    NphShdomRay ray;
    double light[3], sky[3] = {0.0, 0.0, 0.0}, collided = 0.0;
    for (int f = 0; f < NPH_SAMPLE_FIELDS; f++) fields[f] = 0.0;
    if (!(camera_ray->weight > 0.0)) return;
    nph_shdom_ray_begin(camera, room, camera_ray->p, camera_ray->d, &ray);
    nph_shdom_ray_follow(&ray, camera_ray, ask, 0);
    nph_shdom_ray_spread(&ray, light);
    nph_shdom_ray_add(camera, light, 2, fields);
    nph_shdom_ray_add(camera, ray.once, 1, fields);
    see_lights(&ray, sky);
    nph_shdom_ray_add(camera, sky, 0, fields);
    for (int c = 0; c < 3; c++) fields[NPH_SAMPLE_T0 + c] = nph_shdom_ray_channel(&ray, ray.true_passes, c);
    for (int c = 0; c < local->channels; c++) collided += (1.0 - ray.true_passes[c]) / (double)local->channels;
    fields[NPH_SAMPLE_COLLIDED] = collided;
    fields[NPH_SAMPLE_DISTANCE] = ray.distance / (double)local->channels;
    nph_single_tell(ask, "  leaves: transmittance %.9g; lights behind it add %.9g %.9g %.9g", ray.true_passes[0], sky[0], sky[1], sky[2]);
}
