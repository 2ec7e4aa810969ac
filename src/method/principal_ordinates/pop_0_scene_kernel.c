/* SPDX-License-Identifier: Apache-2.0
 *
 * The scene of principal ordinates, and pop.medium: the density at the resolution of the grids. A cell of level l is the mean of
 * 2^l samples along every axis; voxels of that size are at most as large as the grids' cells [Elek14 sec. 4.2]. */
#include <string.h>

#include "method/principal_ordinates/pop_kept.h"
#include "transport/facts_lookup.h"
#include "transport/prepare_lookup.h"

size_t NPH_KERNEL(nph_pop_scene_bytes)(void);
void NPH_KERNEL(nph_pop_prepare)(const NphJob *job, const NphPopChoice *choice, void *memory);
void NPH_KERNEL(nph_pop_medium)(const void *memory, int first, int end, void *medium);
void NPH_KERNEL(nph_pop_facts)(const void *memory, NphFactFn fact, void *user);

size_t NPH_KERNEL(nph_pop_scene_bytes)(void) { return sizeof(RPopScene); }

/* Where the medium's box lies. */
static void prepare_space(const NphMedium *medium, RPopScene *out) {
    const double *m = medium->world_from_medium;
    int grid = medium->shape == NPH_SHAPE_GRID;
    const double *lo = grid ? medium->grid.lo : medium->lo, *hi = grid ? medium->grid.hi : medium->hi;
    for (int k = 0; k < 8; k++) {
        double at[3];
        for (int a = 0; a < 3; a++) at[a] = k >> a & 1 ? hi[a] : lo[a];
        for (int a = 0; a < 3; a++)
            out->corner[k][a] = m[4 * a] * at[0] + m[4 * a + 1] * at[1] + m[4 * a + 2] * at[2] + m[4 * a + 3] - out->local.origin[a];
    }
    for (int a = 0; a < 3; a++) {
        double length = 0.0, middle = 0.0;
        for (int b = 0; b < 3; b++) length += m[4 * b + a] * m[4 * b + a];
        out->metres[a] = nph_sqrt(length);
        for (int b = 0; b < 3; b++) out->side[a][b] = m[4 * b + a] / out->metres[a];
        for (int k = 0; k < 8; k++) middle += 0.125 * out->corner[k][a];
        out->middle[a] = middle;
        double counted = grid ? 0.0 : 0.5 * lo[0] + 0.5 * hi[0]; /* boxes are counted from their middle */
        double shift[3] = {counted, grid ? 0.0 : 0.5 * lo[1] + 0.5 * hi[1], grid ? 0.0 : 0.5 * lo[2] + 0.5 * hi[2]};
        for (int b = 0; b < 3; b++) out->local_from[4 * a + b] = (Real)m[4 * a + b];
        out->local_from[4 * a + 3] = (Real)(m[4 * a] * shift[0] + m[4 * a + 1] * shift[1] + m[4 * a + 2] * shift[2] + m[4 * a + 3] - out->local.origin[a]);
    }
}

/* How far from the middle of the medium's box its corners lie, and those of what all meshes lie in. */
static void prepare_reach(RPopScene *out) {
    const NphBvhNode *meshes = out->local.surfaces.bvh.nodes;
    double radius = 0.0, around = 0.0;
    for (int k = 0; k < 8; k++) {
        double near = 0.0, far = 0.0;
        for (int a = 0; a < 3; a++) {
            double corner = out->corner[k][a] - out->middle[a];
            double bound = meshes ? (double)(k >> a & 1 ? meshes->hi[a] : meshes->lo[a]) - out->middle[a] : corner;
            near += corner * corner;
            far += bound * bound;
        }
        radius = near > radius ? near : radius;
        around = far > around ? far : around;
    }
    out->radius = nph_sqrt(radius);
    out->around = nph_sqrt(around > radius ? around : radius);
}

static void prepare_box(const RPopScene *scene, const int32_t n[3], RPopBox *out) {
    for (int a = 0; a < 3; a++) {
        double size = (double)scene->medium.hi[a] - (double)scene->medium.lo[a];
        out->n[a] = n[a];
        out->lo[a] = scene->medium.lo[a];
        out->edge[a] = (Real)(size / (double)n[a]);
        out->per[a] = (Real)((double)n[a] / size);
        out->metres[a] = (Real)(size * scene->metres[a] / (double)n[a]);
    }
}

static void prepare_knobs(const double *knobs, RPopScene *out) {
    double diagonal = 0.0;
    for (int a = 0; a < 3; a++) {
        double size = ((double)out->medium.hi[a] - (double)out->medium.lo[a]) * out->metres[a];
        diagonal += size * size;
    }
    out->upsampling = knobs[NPH_POP_KNOB_UPSAMPLING] > 0.5;
    out->regions = knobs[NPH_POP_KNOB_REGIONS] > 0.5;
    out->prefilter = (int)knobs[NPH_POP_KNOB_PREFILTER];
    out->beta = (Real)knobs[NPH_POP_KNOB_BETA];
    out->epsilon_a = (Real)knobs[NPH_POP_KNOB_EPSILON_A];
    out->epsilon_l = (Real)knobs[NPH_POP_KNOB_EPSILON_L];
    out->paths = !out->paper && knobs[NPH_POP_KNOB_PATHS] > 0.5;
    out->inner = (Real)knobs[NPH_POP_KNOB_INNER];
    out->clamp = (Real)knobs[NPH_POP_KNOB_CLAMP];
    out->exit = (Real)knobs[NPH_POP_KNOB_EXIT];
    out->step = (Real)(nph_sqrt(diagonal) / knobs[NPH_POP_KNOB_STEPS]);
    out->beam = (Real)(nph_sqrt(diagonal) / (3.4641016151377544 * knobs[NPH_POP_KNOB_CELLS]));
    out->narrow = (Real)(1.0 / knobs[NPH_POP_KNOB_SPREAD_DENSITY]);
}

void NPH_KERNEL(nph_pop_prepare)(const NphJob *job, const NphPopChoice *choice, void *memory) {
    RPopScene *out = memory;
    memset(out, 0, sizeof *out);
    r_prepare_scene(job->scene, &choice->transport, job->seed, job->frame, &out->local);
    out->choice = *choice;
    out->paper = job->knobs[NPH_POP_KNOB_VARIANT] > 0.5;
    if (choice->medium < 0) return;
    const NphMedium *from = &job->scene->media[choice->medium];
    prepare_space(from, out);
    prepare_reach(out);
    out->medium = out->local.media[0];
    out->density_max = from->shape == NPH_SHAPE_GRID ? (Real)from->grid.max : R(1.0);
    out->g = (Real)nph_phase_mean_cosine(&from->phase);
    for (int c = 0; c < 3; c++) {
        out->sigma_t[c] = (Real)from->extinction_per_m[c];
        out->sigma_s[c] = (Real)(from->extinction_per_m[c] * from->albedo[c]);
        out->sigma_a[c] = (Real)(from->extinction_per_m[c] * (1.0 - from->albedo[c]));
    }
    out->per_level = (Real)nph_power_of_2((double)-choice->level);
    out->level_shift = R(-0.5) * out->per_level - R(0.5); /* sample 1 is the first of cell 0 */
    prepare_box(out, choice->joined, &out->joined);
    prepare_box(out, choice->gathered, &out->gathered);
    prepare_box(out, choice->merged, &out->merged);
    prepare_box(out, choice->fine, &out->fine);
    prepare_knobs(job->knobs, out);
}

/* Planes [first, end). */
void NPH_KERNEL(nph_pop_medium)(const void *memory, int first, int end, void *medium) {
    const RPopScene *scene = memory;
    const RGrid *grid = &scene->medium.grid;
    const int32_t *n = scene->choice.mips;
    int32_t size = 1 << scene->choice.level;
    Real *out = (Real *)medium + (int64_t)first * n[1] * n[0];
    if (scene->medium.shape != NPH_SHAPE_GRID) {
        *out = R(1.0);
        return;
    }
    for (int32_t z = first; z < end; z++)
        for (int32_t y = 0; y < n[1]; y++)
            for (int32_t x = 0; x < n[0]; x++) {
                int32_t lo[3] = {1 + x * size, 1 + y * size, 1 + z * size}, hi[3];
                double sum = 0.0;
                for (int a = 0; a < 3; a++) hi[a] = lo[a] + size < grid->n[a] - 1 ? lo[a] + size : grid->n[a] - 1;
                for (int32_t k = lo[2]; k < hi[2]; k++)
                    for (int32_t j = lo[1]; j < hi[1]; j++)
                        for (int32_t i = lo[0]; i < hi[0]; i++) sum += (double)grid->values[r_grid_element(grid, i, j, k)];
                *out++ = (Real)(sum / ((double)size * (double)size * (double)size));
            }
}

static void three(NphFactFn fact, void *user, const char *name, const int32_t n[3]) {
    fact(user, -1, name, 3, (double[]){(double)n[0], (double)n[1], (double)n[2]});
}

void NPH_KERNEL(nph_pop_facts)(const void *memory, NphFactFn fact, void *user) {
    const RPopScene *scene = memory;
    const NphPopChoice *choice = &scene->choice;
    if (choice->medium >= 0) {
        three(fact, user, "flat_cells", choice->flat);
        three(fact, user, "radial_cells", choice->radial);
        three(fact, user, "vpl_cells", choice->vpl);
        three(fact, user, "medium_cells", choice->mips);
        three(fact, user, "joined_cells", choice->joined);
        three(fact, user, "gathered_cells", choice->gathered);
        three(fact, user, "merged_cells", choice->merged);
        three(fact, user, "fine_cells", choice->fine);
        fact(user, -1, "grids_of_suns_sky_points", 3, (double[]){(double)choice->suns, (double)choice->sky, (double)choice->points});
        fact(user, -1, "virtual_points", 1, (double[]){(double)choice->vpls});
        fact(user, -1, "propagated_channels", 1, (double[]){(double)choice->channels});
        fact(user, -1, "level", 1, (double[]){(double)choice->level});
        fact(user, -1, "corners", 24, &scene->corner[0][0]);
        r_fact(fact, user, "mean_cosine", scene->g);
        r_fact(fact, user, "step", scene->step);
        RPopObserver observer = r_pop_observer(&scene->local);
        fact(user, -1, "observer", 3, (double[]){(double)observer.at[0], (double)observer.at[1], (double)observer.at[2]});
        r_fact(fact, user, "observer_parallel", (Real)observer.parallel);
    }
    r_scene_facts(&scene->local, 1, fact, user);
}
