/* SPDX-License-Identifier: Apache-2.0
 *
 * The solution of principal ordinates: memory, and the stages as blocks on the pool. Grids are independent of each other until they
 * are joined, so a block of a propagation that nobody looks into is one grid with all its iterations: its cells stay in the cache. */
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/pool.h"
#include "method/principal_ordinates/pop.h"

int64_t nph_pop_sky_texels(const NphScene *scene) {
    int64_t most = 65 * 33; /* of constant lights */
    for (int l = 0; l < scene->light_count; l++) {
        const NphLight *light = &scene->lights[l];
        if (light->kind != NPH_LIGHT_ENVIRONMENT) continue;
        int64_t texels = ((int64_t)light->map.width + 1) * ((int64_t)light->map.height + 1);
        most = texels > most ? texels : most;
    }
    return most;
}

uint64_t nph_pop_buffer_bytes(const NphPopChoice *choice, int precision, NphPopBuffer buffer) {
    uint64_t real = precision == 32 ? 4 : 8, film = (uint64_t)choice->transport.film_channels;
    int grids = nph_pop_grids(choice);
    switch (buffer) {
    case NPH_POP_B_MEDIUM: return real * (uint64_t)nph_pop_cells(choice->mips);
    case NPH_POP_B_IMPORTANCE: return real * NPH_POP_MAP_WIDTH * NPH_POP_MAP_HEIGHT;
    case NPH_POP_B_ORDINATE: return real * (uint64_t)grids * NPH_POP_ROW;
    case NPH_POP_B_RSM: return choice->vpls > 0 ? real * (uint64_t)nph_pop_lamps(choice) * (uint64_t)choice->rsm * (uint64_t)choice->rsm * NPH_POP_TEXEL : 0;
    case NPH_POP_B_DENSITY: return real * (uint64_t)nph_pop_first(choice, grids, 1);
    case NPH_POP_B_LIT: return choice->shadows > 0 ? real * (uint64_t)nph_pop_first(choice, grids, 1) : 0;
    case NPH_POP_B_LIGHT:
    case NPH_POP_B_COSINE:
    case NPH_POP_B_SEEN: return real * (uint64_t)nph_pop_first(choice, grids, choice->channels);
    case NPH_POP_B_POWER: return sizeof(double) * (uint64_t)grids * (uint64_t)choice->channels * NPH_POP_POWERS;
    case NPH_POP_B_RESIDUUM: return 2 * real * film * (uint64_t)nph_pop_cells(choice->joined);
    case NPH_POP_B_SPREAD: return 5 * real * film * (uint64_t)nph_pop_cells(choice->joined); /* and what cells keep */
    case NPH_POP_B_GATHERED: return choice->vpls > 0 ? real * film * (uint64_t)nph_pop_cells(choice->gathered) : 0;
    case NPH_POP_B_MERGED: return real * NPH_POP_CELL * (uint64_t)nph_pop_cells(choice->merged);
    case NPH_POP_B_FINE: return real * NPH_POP_CELL * (uint64_t)nph_pop_cells(choice->fine);
    default: return 0;
    }
}

static NphStatus allocate(NphPopSolver *s) {
    NphContext *context = s->job.context;
    NphPopArrays *a = &s->arrays;
    struct {
        NphPopBuffer buffer;
        int parts;
        const char *what;
        void **to;
    } const needed[] = {
        {NPH_POP_B_MEDIUM, 1, "downscaled medium", &a->medium},       {NPH_POP_B_IMPORTANCE, 1, "importance", &a->importance},
        {NPH_POP_B_ORDINATE, 1, "ordinates", &a->ordinate},           {NPH_POP_B_DENSITY, 1, "densities of grids", &a->density},
        {NPH_POP_B_RSM, 1, "reflective shadow maps", &a->rsm},        {NPH_POP_B_LIT, 1, "shadows of grids", &a->lit},
        {NPH_POP_B_LIGHT, 1, "light of grids", &a->light},            {NPH_POP_B_COSINE, 1, "mean cosines of grids", &a->cosine},
        {NPH_POP_B_SEEN, 1, "what grids show", &a->seen},             {NPH_POP_B_RESIDUUM, 2, "residuum", &a->residuum[0]},
        {NPH_POP_B_RESIDUUM, 2, "residuum", &a->residuum[1]},         {NPH_POP_B_SPREAD, 5, "spread residuum", &a->spread},
        {NPH_POP_B_GATHERED, 1, "what virtual points show", &a->gathered},
        {NPH_POP_B_MERGED, 1, "merged grid", &a->merged},             {NPH_POP_B_FINE, 1, "upsampled grid", &a->fine},
    };
    for (size_t i = 0; i < sizeof needed / sizeof *needed; i++) {
        uint64_t bytes = nph_pop_buffer_bytes(&s->choice, s->job.precision, needed[i].buffer) / (uint64_t)needed[i].parts;
        NPH_TRY(nph_alloc(context, bytes > 0 ? (size_t)bytes : 64, 1, needed[i].what, needed[i].to));
    }
    int64_t keep = 4 * s->choice.transport.film_channels * nph_pop_cells(s->choice.joined);
    NPH_TRY(nph_alloc(context, (size_t)keep, (size_t)s->job.precision / 8, "spread residuum", &a->keep));
    int64_t powers = (int64_t)nph_pop_grids(&s->choice) * s->choice.channels * NPH_POP_POWERS;
    NPH_TRY(NPH_NEW(context, powers > 0 ? powers : 1, "powers of grids", &a->power));
    NPH_TRY(NPH_NEW(context, nph_pop_sky_texels(s->job.scene), "sums of the sky", &s->texels));
    NPH_TRY(NPH_NEW(context, s->threads, "counts of stages", &s->stages));
    NPH_TRY(NPH_NEW(context, s->threads, "workers", &s->scratch));
    for (int w = 0; w < s->threads; w++) NPH_TRY(nph_alloc(context, s->kernels.scratch_bytes(&s->choice), 1, "cells of a grid", &s->scratch[w]));
    return NPH_OK;
}

NphStatus nph_pop_solver_open(const NphJob *job, NphPopSolver *solver) {
    NphPopSolver made;
    memset(&made, 0, sizeof made);
    made.job = *job;
    made.threads = nph_context_threads(job->context);
    made.iteration = -1;
    nph_pop_kernels(job->precision, nph_context_isa(job->context), &made.kernels);
    NPH_TRY(nph_pop_choose(job, &made.choice));
    NphStatus status = nph_alloc(job->context, made.kernels.scene_bytes(), 1, "scene for the kernels", &made.scene);
    if (status == NPH_OK) {
        made.kernels.prepare(job, &made.choice, made.scene);
        status = allocate(&made);
    }
    if (status != NPH_OK) {
        nph_pop_solver_close(&made);
        return status;
    }
    *solver = made;
    return NPH_OK;
}

void nph_pop_solver_close(NphPopSolver *s) {
    NphContext *context = s->job.context;
    NphPopArrays *a = &s->arrays;
    void *all[] = {a->gathered, a->rsm,    a->lit,        a->medium, a->importance, a->ordinate, a->density, a->light,  a->cosine, a->seen, a->power, a->residuum[0], a->residuum[1],
                   a->spread, a->keep,       a->merged,   a->fine,    s->texels, s->stages, s->scene};
    for (int w = 0; s->scratch && w < s->threads; w++) nph_free(context, s->scratch[w]);
    nph_free(context, s->scratch);
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) nph_free(context, all[i]);
}

/* Blocks: planes of a box, or grids. */
static NphStatus medium_plane(void *data, int64_t plane, int worker) {
    NphPopSolver *s = data;
    int64_t cells = (int64_t)s->choice.mips[0] * s->choice.mips[1];
    NPH_LAUNCH(&s->stages[worker], NPH_POP_MEDIUM, cells, s->kernels.medium(s->scene, (int)plane, (int)plane + 1, s->arrays.medium));
    return NPH_OK;
}

static NphStatus grid_block(void *data, int64_t grid, int worker) {
    NphPopSolver *s = data;
    NPH_LAUNCH(&s->stages[worker], NPH_POP_GRIDS, nph_pop_cells(nph_pop_shape(&s->choice, (int)grid)), s->kernels.grid(s->scene, &s->arrays, (int)grid));
    return NPH_OK;
}

static NphStatus reflect_block(void *data, int64_t lamp, int worker) {
    NphPopSolver *s = data;
    NPH_LAUNCH(&s->stages[worker], NPH_POP_REFLECT, (int64_t)s->choice.rsm * s->choice.rsm, s->kernels.reflect(s->scene, &s->arrays, (int)lamp));
    return NPH_OK;
}

static NphStatus shadow_block(void *data, int64_t grid, int worker) {
    NphPopSolver *s = data;
    NPH_LAUNCH(&s->stages[worker], NPH_POP_SHADOWS, nph_pop_cells(nph_pop_shape(&s->choice, (int)grid)), s->kernels.shadow(s->scene, &s->arrays, (int)grid));
    return NPH_OK;
}

static NphStatus inject_block(void *data, int64_t grid, int worker) {
    NphPopSolver *s = data;
    NPH_LAUNCH(&s->stages[worker], NPH_POP_INJECT, nph_pop_cells(nph_pop_shape(&s->choice, (int)grid)),
               s->kernels.inject(s->scene, &s->arrays, (int)grid, s->scratch[worker]));
    return NPH_OK;
}

static NphStatus propagate_block(void *data, int64_t grid, int worker) {
    NphPopSolver *s = data;
    int range[3] = {s->iteration < 0 ? 0 : s->iteration, s->iteration < 0 ? s->iterations : s->iteration + 1, s->iterations};
    NPH_LAUNCH(&s->stages[worker], NPH_POP_PROPAGATE, nph_pop_cells(nph_pop_shape(&s->choice, (int)grid)) * (range[1] - range[0]),
               s->kernels.propagate(s->scene, &s->arrays, (int)grid, range, s->scratch[worker]));
    return NPH_OK;
}

static int64_t plane_of(const int32_t n[3]) { return (int64_t)n[0] * n[1]; }

static NphStatus join_plane(void *data, int64_t plane, int worker) {
    NphPopSolver *s = data;
    NPH_LAUNCH(&s->stages[worker], NPH_POP_JOIN, plane_of(s->choice.joined), s->kernels.join(s->scene, &s->arrays, (int)plane, (int)plane + 1));
    return NPH_OK;
}

static NphStatus keep_plane(void *data, int64_t plane, int worker) {
    NphPopSolver *s = data;
    NPH_LAUNCH(&s->stages[worker], NPH_POP_SPREAD, 0, s->kernels.keep(s->scene, &s->arrays, (int)plane, (int)plane + 1));
    return NPH_OK;
}

static NphStatus spread_plane(void *data, int64_t plane, int worker) {
    NphPopSolver *s = data;
    NPH_LAUNCH(&s->stages[worker], NPH_POP_SPREAD, plane_of(s->choice.joined), s->kernels.spread(s->scene, &s->arrays, s->from, (int)plane, (int)plane + 1));
    return NPH_OK;
}

static NphStatus gather_plane(void *data, int64_t plane, int worker) {
    NphPopSolver *s = data;
    NPH_LAUNCH(&s->stages[worker], NPH_POP_GATHER, plane_of(s->choice.gathered), s->kernels.gather(s->scene, &s->arrays, (int)plane, (int)plane + 1));
    return NPH_OK;
}

static NphStatus merge_plane(void *data, int64_t plane, int worker) {
    NphPopSolver *s = data;
    NPH_LAUNCH(&s->stages[worker], NPH_POP_MERGE, plane_of(s->choice.merged), s->kernels.merge(s->scene, &s->arrays, (int)plane, (int)plane + 1));
    return NPH_OK;
}

static NphStatus upsample_plane(void *data, int64_t plane, int worker) {
    NphPopSolver *s = data;
    NPH_LAUNCH(&s->stages[worker], NPH_POP_UPSAMPLE, plane_of(s->choice.fine), s->kernels.upsample(s->scene, &s->arrays, (int)plane, (int)plane + 1));
    return NPH_OK;
}

/* Two arrays take turns; the one that others see is the first. */
static NphStatus spread_once(NphPopSolver *s) {
    if (!s->kept) NPH_TRY(nph_pool_run(s->job.context, s->choice.joined[2], keep_plane, s, NULL));
    s->kept = 1;
    NPH_TRY(nph_pool_run(s->job.context, s->choice.joined[2], spread_plane, s, NULL));
    s->from = 1 - s->from;
    return NPH_OK;
}

static NphStatus join(NphPopSolver *s) {
    s->from = 0;
    s->kept = 1;
    NPH_TRY(nph_pool_run(s->job.context, s->choice.joined[2], keep_plane, s, NULL));
    NPH_TRY(nph_pool_run(s->job.context, s->choice.joined[2], join_plane, s, NULL));
    NPH_LAUNCH(&s->stages[0], NPH_POP_JOIN, 0, s->kernels.join_scale(s->scene, &s->arrays));
    return NPH_OK;
}

/* How many iterations there are is a function of the ordinates where no knob says it. */
static void count_iterations(NphPopSolver *s) {
    s->iterations = s->choice.iterations > 0 ? s->choice.iterations : s->kernels.iterations(s->scene, s->arrays.ordinate);
}

static void add_map(const NphPopSolver *from, int count, NphPopSolver *to) {
    for (int i = 0; i < NPH_POP_MAP_WIDTH * NPH_POP_MAP_HEIGHT; i++) {
        if (to->job.precision == 32) ((float *)to->arrays.importance)[i] += (((float *)from->arrays.importance)[i] - ((float *)to->arrays.importance)[i]) / (float)count;
        else ((double *)to->arrays.importance)[i] += (((double *)from->arrays.importance)[i] - ((double *)to->arrays.importance)[i]) / (double)count;
    }
}

/* The map of an earlier frame, from its own scene: any frame has the same bytes alone and in a sequence. */
static NphStatus add_frame(NphPopSolver *s, uint32_t frame, int count) {
    NphContext *context = s->job.context;
    NphScene *scene = NULL;
    NphPopSolver of;
    NphJob job = s->job;
    NPH_TRY(nph_scene_at_frame(context, s->job.scene, frame, &scene));
    job.scene = scene;
    job.frame = job.frame > 0 ? frame : 0;
    NphStatus status = nph_pop_solver_open(&job, &of);
    if (status == NPH_OK) {
        if (nph_pop_has(&of, NPH_POP_IMPORTANCE)) {
            status = nph_pool_run(context, of.choice.mips[2], medium_plane, &of, NULL);
            of.kernels.importance(of.scene, &of.arrays, of.scratch[0]);
            add_map(&of, count, s);
        }
        nph_pop_solver_close(&of);
    }
    nph_scene_free(context, scene);
    return status;
}

/* This frame's, and the mean with those before it. */
static NphStatus find_importance(NphPopSolver *s) {
    int most = nph_scene_is_animated(s->job.scene) ? (int)s->job.knobs[NPH_POP_KNOB_FRAMES] : 1;
    NPH_LAUNCH(&s->stages[0], NPH_POP_IMPORTANCE, NPH_POP_MAP_WIDTH * NPH_POP_MAP_HEIGHT, s->kernels.importance(s->scene, &s->arrays, s->scratch[0]));
    for (int k = 1; k < most && (uint32_t)k <= s->job.scene->frame; k++) NPH_TRY(add_frame(s, s->job.scene->frame - (uint32_t)k, k + 1));
    return NPH_OK;
}

NphStatus nph_pop_step(NphPopSolver *s, NphPopStage stage) {
    NphContext *context = s->job.context;
    NphStageCounts *counts = &s->stages[0];
    int grids = nph_pop_grids(&s->choice);
    switch (stage) {
    case NPH_POP_MEDIUM: return nph_pool_run(context, s->choice.mips[2], medium_plane, s, NULL);
    case NPH_POP_IMPORTANCE: return find_importance(s);
    case NPH_POP_ORDINATES:
        NPH_LAUNCH(counts, stage, grids, s->kernels.ordinates(&s->job, s->scene, s->arrays.importance, s->texels, s->arrays.ordinate));
        return NPH_OK;
    case NPH_POP_REFLECT: return nph_pool_run(context, nph_pop_lamps(&s->choice), reflect_block, s, NULL);
    case NPH_POP_VPLS: NPH_LAUNCH(counts, stage, s->choice.vpls, s->kernels.vpls(&s->job, s->scene, &s->arrays)); return NPH_OK;
    case NPH_POP_GRIDS: return nph_pool_run(context, grids, grid_block, s, NULL);
    case NPH_POP_SHADOWS: return nph_pool_run(context, grids, shadow_block, s, NULL);
    case NPH_POP_INJECT: return nph_pool_run(context, grids, inject_block, s, NULL);
    case NPH_POP_PROPAGATE:
        count_iterations(s);
        return nph_pool_run(context, grids, propagate_block, s, NULL);
    case NPH_POP_JOIN: return join(s);
    case NPH_POP_SPREAD: return spread_once(s);
    case NPH_POP_GATHER: return nph_pool_run(context, s->choice.gathered[2], gather_plane, s, NULL);
    case NPH_POP_MERGE: return nph_pool_run(context, s->choice.merged[2], merge_plane, s, NULL);
    case NPH_POP_UPSAMPLE: return nph_pool_run(context, s->choice.fine[2], upsample_plane, s, NULL);
    default: return NPH_OK;
    }
}

int nph_pop_has(const NphPopSolver *s, NphPopStage stage) {
    const NphPopChoice *choice = &s->choice;
    if (choice->medium < 0 || !choice->lit) return 0;
    if (stage == NPH_POP_IMPORTANCE) return choice->importance;
    if (stage == NPH_POP_REFLECT || stage == NPH_POP_VPLS || stage == NPH_POP_GATHER) return choice->vpls > 0;
    if (stage == NPH_POP_SHADOWS) return choice->shadows > 0;
    if (stage == NPH_POP_JOIN || stage == NPH_POP_SPREAD) return choice->residuum;
    if (stage == NPH_POP_UPSAMPLE) return nph_pop_cells(choice->fine) > 1;
    return 1;
}

int nph_pop_spreads(const NphPopSolver *s, double joined) {
    double least = s->job.knobs[NPH_POP_KNOB_EPSILON_L] * joined;
    return joined > 0.0 && s->kernels.left(s->scene, &s->arrays, s->from) > least;
}
