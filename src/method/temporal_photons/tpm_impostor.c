/* SPDX-License-Identifier: Apache-2.0
 *
 * Which frame's picture of the cloud a frame shows [Elek12 sec. 4.4]. The picture is marched anew when the cloud is seen under an angle
 * or from a distance that differs too much, when too many generations have been exchanged, or when the cloud is another one. Every
 * frame whose number is a multiple of the last criterion's starts anew, so that no frame depends on more than those before it
 * back to there; and so does a cloud that was not wholly in the picture and is now seen otherwise. */
#include "core/fmath.h"
#include "core/memory.h"
#include "core/message.h"
#include "field/sample.h"
#include "method/temporal_photons/tpm_impostor.h"

enum { PLACES = 24 }; /* at which densities are compared, along an axis */

static void centre_of(const NphMedium *medium, double centre[3]) {
    double lo[3], hi[3];
    nph_medium_bounds(medium, lo, hi);
    for (int a = 0; a < 3; a++) centre[a] = 0.5 * (lo[a] + hi[a]);
}

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Whether all corners of the medium's box lie in the picture. */
static int is_whole(const NphScene *scene, const NphMedium *medium) {
    const NphSensor *sensor = &scene->sensor;
    double lo[3], hi[3];
    nph_medium_bounds(medium, lo, hi);
    for (int k = 0; k < 8; k++) {
        double away[3];
        for (int a = 0; a < 3; a++) away[a] = (k >> a & 1 ? hi[a] : lo[a]) - sensor->position[a];
        double depth = dot(away, sensor->forward);
        if (!(depth > 0.0) || !(nph_abs(dot(away, sensor->right)) <= depth * sensor->half_size[0]) ||
            !(nph_abs(dot(away, sensor->up)) <= depth * sensor->half_size[1]))
            return 0;
    }
    return 1;
}

static int same_view(const NphSensor *a, const NphSensor *b) {
    return nph_tpm_same(a->position, b->position, 3) && nph_tpm_same(a->right, b->right, 3) && nph_tpm_same(a->up, b->up, 3) &&
           nph_tpm_same(a->forward, b->forward, 3) && nph_tpm_same(a->half_size, b->half_size, 2);
}

/* The mean difference of two densities, over the mean of the first; both at the same parts of their boxes. */
static NphStatus compare_densities(NphContext *context, const NphGrid *a, const NphGrid *b, double *difference) {
    enum { COUNT = PLACES * PLACES * PLACES };
    static const double per = 1.0 / PLACES;
    double *at = NULL, off = 0.0, sum = 0.0;
    NPH_TRY(NPH_NEW(context, 5 * COUNT, "densities of two frames", &at));
    NphStatus status = NPH_OK;
    for (int g = 0; g < 2 && status == NPH_OK; g++) {
        const NphGrid *grid = g ? b : a;
        for (int i = 0; i < COUNT; i++) {
            const int place[3] = {i % PLACES, i / PLACES % PLACES, i / (PLACES * PLACES)};
            for (int x = 0; x < 3; x++) at[x * COUNT + i] = grid->lo[x] + (grid->hi[x] - grid->lo[x]) * ((double)place[x] + 0.5) * per;
        }
        status = nph_grid_sample(context, grid, 64, COUNT, (const void *const[]){at, at + COUNT, at + 2 * COUNT}, at + (3 + g) * COUNT);
    }
    for (int i = 0; i < COUNT; i++) {
        sum += at[3 * COUNT + i];
        off += nph_abs(at[4 * COUNT + i] - at[3 * COUNT + i]);
    }
    *difference = off > 0.0 ? (sum > 0.0 ? off / sum : 1e30) : 0.0;
    nph_free(context, at);
    return status;
}

/* The largest relative change of what a medium is: extinction, albedo, mean cosine, edges, density. */
static NphStatus compare_media(NphContext *context, const NphMedium *a, const NphMedium *b, double *difference) {
    double most = 0.0, grids = 0.0;
    const double *from = a->world_from_medium, *to = b->world_from_medium;
    for (int c = 0; c < 3; c++) {
        double e = nph_abs(a->extinction_per_m[c] - b->extinction_per_m[c]), largest = 0.0, moved = 0.0;
        most = e > most * a->extinction_per_m[c] ? e / (a->extinction_per_m[c] > 0.0 ? a->extinction_per_m[c] : 1e-30) : most;
        double w = nph_abs(a->albedo[c] - b->albedo[c]);
        most = w > most ? w : most;
        for (int r = 0; r < 3; r++) { /* an edge of the box, turned or longer */
            largest += from[4 * r + c] * from[4 * r + c];
            moved += (from[4 * r + c] - to[4 * r + c]) * (from[4 * r + c] - to[4 * r + c]);
        }
        most = moved > most * most * largest ? nph_sqrt(moved / largest) : most;
    }
    double g = nph_abs(a->phase.g[0] - b->phase.g[0]);
    most = g > most ? g : most;
    if (a->shape != b->shape) most = 1e30;
    else if (a->shape == NPH_SHAPE_GRID) NPH_TRY(compare_densities(context, &a->grid, &b->grid, &grids));
    *difference = grids > most ? grids : most;
    return NPH_OK;
}

/* Whether the picture of `a` does no longer do for `b`. */
static NphStatus is_outdated(const NphJob *job, const NphScene *a, const NphScene *b, int medium, int *outdated) {
    const double *limits = job->knobs;
    const NphMedium *from = &a->media[medium], *to = &b->media[medium];
    double ways[2][3], lengths[2], changed;
    for (int s = 0; s < 2; s++) {
        const NphScene *scene = s ? b : a;
        centre_of(s ? to : from, ways[s]);
        for (int x = 0; x < 3; x++) ways[s][x] = scene->sensor.position[x] - ways[s][x];
        lengths[s] = nph_sqrt(dot(ways[s], ways[s]));
    }
    double cosine = dot(ways[0], ways[1]) / (lengths[0] * lengths[1]), limit, unused;
    nph_sincos2pi(limits[NPH_TPM_KNOB_ANGLE] / 360.0, &unused, &limit);
    *outdated = 1;
    if (a->medium_count != b->medium_count) return NPH_OK;
    NPH_TRY(compare_media(job->context, from, to, &changed));
    *outdated = !(cosine >= limit) || !(nph_abs(lengths[1] / lengths[0] - 1.0) <= limits[NPH_TPM_KNOB_DISTANCE]) ||
                changed > limits[NPH_TPM_KNOB_SHAPE] || (!same_view(&a->sensor, &b->sensor) && !is_whole(a, from));
    return NPH_OK;
}

int nph_tpm_impostor_life(const NphJob *job) {
    return 1 + (int)nph_floor(job->knobs[NPH_TPM_KNOB_LIGHT] * job->knobs[NPH_TPM_KNOB_GENERATIONS] * (1.0 + 1e-9));
}

NphStatus nph_tpm_impostor(const NphJob *job, int medium, int *age, NphScene **scene) {
    const NphScene *last = job->scene;
    int animated = nph_scene_is_animated(last), life = nph_tpm_impostor_life(job);
    uint32_t frame = animated ? last->frame : job->frame, first = frame - frame % (uint32_t)life, shown = first;
    *age = 0;
    *scene = NULL;
    if (job->knobs[NPH_TPM_KNOB_IMPOSTORS] < 0.5 || medium < 0) return NPH_OK;
    *age = (int)(frame - first);
    if (!animated || *age == 0) return NPH_OK;
    NphScene *picture = NULL, *next = NULL;
    NphStatus status = nph_scene_at_frame(job->context, last, first, &picture);
    for (uint32_t at = first + 1; at <= frame && status == NPH_OK; at++) {
        int outdated = 0;
        if (at < frame) status = nph_scene_at_frame(job->context, last, at, &next);
        if (status == NPH_OK) status = is_outdated(job, picture, at < frame ? next : last, medium, &outdated);
        if (status == NPH_OK && outdated) {
            nph_scene_free(job->context, picture);
            picture = next;
            next = NULL;
            shown = at;
        }
        nph_scene_free(job->context, next);
        next = NULL;
    }
    *age = (int)(frame - shown);
    if (status == NPH_OK && *age > 0) *scene = picture;
    else nph_scene_free(job->context, picture);
    return status;
}
