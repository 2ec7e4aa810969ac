/* SPDX-License-Identifier: Apache-2.0
 *
 * What truth/shdom does for a scene: its grid, its directions, what delta-M makes of the medium; and what it refuses. */
#include <math.h>
#include <string.h>

#include "core/fmath.h"
#include "core/message.h"
#include "transport/prepare_lookup.h"
#include "truth/shdom/shdom.h"

/* A layer's cells are so wide that every ordinate crosses them from top to bottom, and there is one column of them. */
#define WIDE 1e6

static NphStatus refuse(const NphJob *job, NphShdomChoice *choice) {
    const NphScene *scene = job->scene;
    NphContext *context = job->context;
    NPH_TRY(nph_transport_refuse_air(context, scene, "shdom"));
    if (scene->surface_count > 0)
        return nph_error(context, NPH_BAD_SCENE, "shdom: surface %s: surfaces are not part of this method; path has them", scene->surfaces[0].name);
    for (int m = 0; m < scene->medium_count; m++) {
        const NphMedium *medium = &scene->media[m];
        if (!choice->transport.used[m]) continue;
        if (medium->emission.kind != NPH_EMISSION_NONE)
            return nph_error(context, NPH_BAD_SCENE, "shdom: medium %s emits light, which this method does not follow; path does", medium->name);
        if (choice->medium >= 0)
            return nph_error(context, NPH_BAD_SCENE, "shdom: medium %s: there is one medium in this method; path has more", medium->name);
        choice->medium = m;
    }
    return NPH_OK;
}

/* Lattice boxes of a medium's own space, or of scene-local space where sides repeat: lo and hi of each axis, and the way there. */
typedef struct Frame {
    double lo[3], hi[3], from_local[12], edge[3]; /* edge in metres */
    int periodic[3];
} Frame;

/* The grid lies in the medium's own space, whatever its place in the world; a density's in the box of what is not empty. */
static void own_frame(const NphMedium *medium, const double origin[3], Frame *frame) {
    RMedium placed = {.shape = medium->shape};
    const double *map = medium->world_from_medium;
    double lo[3], hi[3];
    memcpy(lo, medium->lo, sizeof lo);
    memcpy(hi, medium->hi, sizeof hi);
    if (medium->shape == NPH_SHAPE_GRID && medium->grid.sum > 0.0) r_occupied(&medium->grid, lo, hi);
    else if (medium->shape == NPH_SHAPE_GRID) {
        memcpy(lo, medium->grid.lo, sizeof lo);
        memcpy(hi, medium->grid.hi, sizeof hi);
    }
    r_prepare_place(map, lo, hi, origin, &placed);
    memcpy(frame->from_local, placed.from_local, sizeof frame->from_local);
    for (int a = 0; a < 3; a++) {
        frame->lo[a] = placed.lo[a];
        frame->hi[a] = placed.hi[a];
        frame->edge[a] = (hi[a] - lo[a]) * nph_sqrt(map[a] * map[a] + map[4 + a] * map[4 + a] + map[8 + a] * map[8 + a]);
    }
}

/* Scene-local axes: a period along those that repeat, else what bounds the medium. Of a layer all but z. */
static void upright_frame(const NphScene *scene, const NphMedium *medium, const double origin[3], Frame *frame) {
    double lo[3], hi[3];
    nph_medium_bounds(medium, lo, hi);
    nph_affine_identity(frame->from_local);
    for (int a = 0; a < 3; a++) {
        int layer = medium->shape == NPH_SHAPE_LAYER && a < 2, repeats = a < 2 && scene->period.on[a];
        double low = layer ? 0.0 : repeats ? scene->period.lo[a] : lo[a], high = layer ? 1.0 : repeats ? scene->period.hi[a] : hi[a];
        frame->lo[a] = layer ? 0.0 : low - origin[a];
        frame->hi[a] = layer ? 1.0 : high - origin[a];
        frame->edge[a] = high - low;
        frame->periodic[a] = layer || repeats;
    }
    if (medium->shape != NPH_SHAPE_LAYER) return;
    for (int a = 0; a < 2; a++) {
        frame->hi[a] = WIDE * frame->edge[2];
        frame->edge[a] = 0.0;
    }
}

static NphStatus choose_grid(const NphJob *job, NphShdomChoice *choice) {
    const NphScene *scene = job->scene;
    const NphMedium *medium = &scene->media[choice->medium];
    NphShdomGrid *grid = &choice->grid;
    Frame frame = {.periodic = {0, 0, 0}};
    double origin[3], longest = 0.0, total = 1.0;
    nph_scene_origin(scene, origin);
    if (scene->period.on[0] || scene->period.on[1] || medium->shape == NPH_SHAPE_LAYER) upright_frame(scene, medium, origin, &frame);
    else own_frame(medium, origin, &frame);
    for (int a = 0; a < 3; a++) longest = frame.edge[a] > longest ? frame.edge[a] : longest;
    for (int a = 0; a < 3; a++) {
        double least = frame.periodic[a] ? 1.0 : 2.0, given = nph_floor(job->knobs[NPH_SHDOM_KNOB_CELLS_X + a]);
        double count = nph_floor(job->knobs[NPH_SHDOM_KNOB_CELLS] * frame.edge[a] / longest + 0.5);
        if (given > 0.0) count = given;
        if (medium->shape == NPH_SHAPE_LAYER && a < 2) count = 1.0;
        count = count > least ? count : least;
        grid->periodic[a] = frame.periodic[a];
        grid->cells[a] = (int32_t)count;
        grid->points[a] = grid->cells[a] + !grid->periodic[a];
        total *= (double)grid->points[a];
        double scale = count / (frame.hi[a] - frame.lo[a]);
        for (int b = 0; b < 4; b++) grid->from_local[4 * a + b] = scale * frame.from_local[4 * a + b];
        grid->from_local[4 * a + 3] -= scale * frame.lo[a];
    }
    if (total > (double)NPH_SHDOM_POINTS_MAX)
        return nph_error(job->context, NPH_BAD_USAGE, "shdom: %d x %d x %d cells; at most %d points", (int)grid->cells[0], (int)grid->cells[1],
                         (int)grid->cells[2], (int)NPH_SHDOM_POINTS_MAX);
    if (!nph_affine_invert(grid->from_local, grid->to_local))
        return nph_error(job->context, NPH_BAD_SCENE, "shdom: medium %s is flat: no grid fills it", medium->name);
    grid->point_count = (int64_t)grid->points[0] * grid->points[1] * grid->points[2];
    grid->cell_count = (int64_t)grid->cells[0] * grid->cells[1] * grid->cells[2];
    return NPH_OK;
}

static NphStatus choose_angles(const NphJob *job, NphShdomChoice *choice) {
    const NphMedium *medium = &job->scene->media[choice->medium];
    const double *knobs = job->knobs;
    NphShdomCut cut = {(int)knobs[NPH_SHDOM_KNOB_BANDS], (int)knobs[NPH_SHDOM_KNOB_POLAR], (int)knobs[NPH_SHDOM_KNOB_AZIMUTHS],
                       knobs[NPH_SHDOM_KNOB_DELTA_M] > 0.5, (int)knobs[NPH_SHDOM_KNOB_PREFILTER], knobs[NPH_SHDOM_KNOB_WIDTH]};
    if ((cut.polar & 1) || cut.polar > NPH_SHDOM_POLAR_MAX)
        return nph_error(job->context, NPH_BAD_USAGE, "shdom: %d polar angles; an even number, at most %d: as many upwards as downwards", cut.polar,
                         (int)NPH_SHDOM_POLAR_MAX);
    nph_shdom_angles(&medium->phase, &cut, &choice->angles);
    for (int c = 0; c < 3; c++) {
        double albedo = medium->albedo[c], f = choice->angles.cut;
        choice->kept[c] = 1.0 - albedo * f;
        choice->extinction[c] = medium->extinction_per_m[c] * choice->kept[c];
        choice->albedo[c] = (1.0 - f) * albedo / choice->kept[c];
    }
    return NPH_OK;
}

static int is_lit(const NphScene *scene) {
    int lit = 0;
    for (int l = 0; l < scene->light_count; l++) {
        const NphLight *light = &scene->lights[l];
        const double *value = light->kind == NPH_LIGHT_SUN ? light->irradiance : light->kind == NPH_LIGHT_POINT ? light->intensity : light->radiance;
        lit |= light->kind == NPH_LIGHT_ENVIRONMENT ? light->map.total > 0.0 : value[0] + value[1] + value[2] > 0.0;
    }
    return lit;
}

NphStatus nph_shdom_choose(const NphJob *job, NphShdomChoice *choice) {
    const NphScene *scene = job->scene;
    NphShdomChoice made = {.medium = -1};
    int points = 0;
    nph_transport_choose(scene, job->plan_full, &made.transport);
    NPH_TRY(refuse(job, &made));
    made.channels = made.transport.film_channels > 1 ? 3 : 1;
    made.thin = job->knobs[NPH_SHDOM_KNOB_THIN];
    made.cubic = job->knobs[NPH_SHDOM_KNOB_CUBIC] > 0.5;
    made.history = (int)job->knobs[NPH_SHDOM_KNOB_HISTORY];
    for (int c = 0; c < 3; c++) made.kept[c] = 1.0;
    for (int l = 0; l < scene->light_count; l++) points |= scene->lights[l].kind == NPH_LIGHT_POINT;
    if (made.medium >= 0) {
        NPH_TRY(choose_grid(job, &made));
        NPH_TRY(choose_angles(job, &made));
        made.solved = made.transport.scatters && (job->plan_full || is_lit(scene));
    }
    made.looks = job->knobs[NPH_SHDOM_KNOB_SINGLE] < 0.5 || (points && nph_sensor_gathers(scene->sensor.kind));
    for (int l = 0; l < scene->light_count && !made.looks; l++)
        if (scene->lights[l].kind == NPH_LIGHT_SUN) made.suns[made.sun_count++] = l;
    *choice = made;
    return NPH_OK;
}
