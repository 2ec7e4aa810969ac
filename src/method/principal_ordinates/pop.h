/* SPDX-License-Identifier: Apache-2.0
 *
 * method/principal_ordinates: principal-ordinates propagation [Elek14]. Light is cut into N directions, the ordinates, and points; each
 * has a grid of its own along which its light travels, and a cell of it knows one radiance and one mean cosine. Once for a picture:
 *    0 medium      the density at the resolution of the grids (mips)
 *    1 importance  from the camera through the medium to the directions of the sky
 *    2 ordinates   directions, irradiances, and mean cosines of what each stands for
 *    3 reflect     what their light meets first on surfaces: reflective shadow maps
 *    4 vpls        virtual point lights drawn from those
 *    5 grids       the density in every cell of every grid
 *    6 shadows     how much of every cell the unscattered light reaches
 *    7 inject      what first scatters in a cell; what the unscattered beam shows
 *    8 propagate   every cell to its six neighbours, M times
 *    9 join        what is left of all grids, isotropic by then, into one grid along the medium
 *   10 spread      the same there (the isotropic residuum)
 *   11 gather      what virtual point lights show the observer, into one grid along the medium
 *   12 merge       what all grids show, into one
 *   13 upsample    to the resolution of the density, which guides it
 * and for every tile and 16 samples:
 *   14 march       through density and what was merged, to surfaces
 *   15 accumulate  into the film's tree
 * The solution is the same for all samples: they differ in where in their pixel they look. */
#ifndef NPH_METHOD_POP_H
#define NPH_METHOD_POP_H

#include "transport/choice.h"

extern const NphMethod nph_principal_ordinates;
extern const NphStage nph_pop_stages[];
extern const NphBuffer nph_pop_buffers[];

enum { NPH_RNG_POP_ORDINATE = 56, NPH_RNG_POP_VPL = 57, NPH_RNG_POP_SURFACE = 58 };

typedef enum NphPopStage {
    NPH_POP_MEDIUM,
    NPH_POP_IMPORTANCE,
    NPH_POP_ORDINATES,
    NPH_POP_REFLECT,
    NPH_POP_VPLS,
    NPH_POP_GRIDS,
    NPH_POP_SHADOWS,
    NPH_POP_INJECT,
    NPH_POP_PROPAGATE,
    NPH_POP_JOIN,
    NPH_POP_SPREAD,
    NPH_POP_GATHER,
    NPH_POP_MERGE,
    NPH_POP_UPSAMPLE,
    NPH_POP_MARCH,
    NPH_POP_ACCUMULATE,
    NPH_POP_STAGES
} NphPopStage;

typedef enum NphPopBuffer {
    NPH_POP_B_MEDIUM,
    NPH_POP_B_IMPORTANCE,
    NPH_POP_B_ORDINATE,
    NPH_POP_B_RSM,
    NPH_POP_B_DENSITY,
    NPH_POP_B_LIT,
    NPH_POP_B_LIGHT,
    NPH_POP_B_COSINE,
    NPH_POP_B_SEEN,
    NPH_POP_B_POWER,
    NPH_POP_B_RESIDUUM,
    NPH_POP_B_SPREAD,
    NPH_POP_B_GATHERED,
    NPH_POP_B_MERGED,
    NPH_POP_B_FINE,
    NPH_POP_B_SAMPLE,
    NPH_POP_B_NODE,
    NPH_POP_BUFFERS
} NphPopBuffer;

enum { NPH_POP_ARG_ITERATION, NPH_POP_ARG_TILE, NPH_POP_ARG_CHUNK, NPH_POP_ARGUMENTS };

enum {
    NPH_POP_KNOB_VARIANT,
    NPH_POP_KNOB_ORDINATES,
    NPH_POP_KNOB_CELLS,
    NPH_POP_KNOB_ALONG,
    NPH_POP_KNOB_RADIAL,
    NPH_POP_KNOB_INNER,
    NPH_POP_KNOB_VPLS,
    NPH_POP_KNOB_VPL_CELLS,
    NPH_POP_KNOB_RSM,
    NPH_POP_KNOB_CLAMP,
    NPH_POP_KNOB_SHADOWS,
    NPH_POP_KNOB_ITERATIONS,
    NPH_POP_KNOB_EPSILON_A,
    NPH_POP_KNOB_EPSILON_L,
    NPH_POP_KNOB_PATHS,
    NPH_POP_KNOB_REGIONS,
    NPH_POP_KNOB_PREFILTER,
    NPH_POP_KNOB_BETA,
    NPH_POP_KNOB_IMPORTANCE,
    NPH_POP_KNOB_FRAMES,
    NPH_POP_KNOB_RESIDUUM,
    NPH_POP_KNOB_RESIDUUM_CELLS,
    NPH_POP_KNOB_RESIDUUM_ITERATIONS,
    NPH_POP_KNOB_MERGED,
    NPH_POP_KNOB_MIPS,
    NPH_POP_KNOB_UPSAMPLING,
    NPH_POP_KNOB_SPREAD_DENSITY,
    NPH_POP_KNOB_STEPS,
    NPH_POP_KNOB_EXIT,
    NPH_POP_KNOBS
};

enum { NPH_POP_CORRECTED, NPH_POP_PAPER };
enum { NPH_POP_PREFILTER_NONE, NPH_POP_PREFILTER_CAP, NPH_POP_PREFILTER_EXACT };

/* A row of pop.ordinate: of a direction the way its light goes, of a point its place (scene-local, m); irradiance [W/m2] or
 * intensity [W/sr]; the mean cosine of the unscattered light around that direction; solid angle that it stands for [sr]. Of virtual
 * point lights also the normal, along which the intensity is that, and the area [m2] that it stands for. */
enum { NPH_POP_WAY, NPH_POP_VALUE = 3, NPH_POP_COSINE = 6, NPH_POP_SOLID_ANGLE = 7, NPH_POP_NORMAL = 8, NPH_POP_AREA = 11, NPH_POP_ROW = 12 };

/* A texel of a reflective shadow map: where its light meets a surface (scene-local, m), the normal there, what is reflected [W], area [m2]. */
enum { NPH_POP_TEXEL_PLACE, NPH_POP_TEXEL_NORMAL = 3, NPH_POP_TEXEL_POWER = 6, NPH_POP_TEXEL_AREA = 9, NPH_POP_TEXEL = 10 };

/* Per grid and channel: what was injected, and what is still under way, over what enters the grid: sums over cells of light. */
enum { NPH_POP_INJECTED, NPH_POP_LEFT, NPH_POP_POWERS };

enum { NPH_POP_IMPORTANCE_CELLS = 16, NPH_POP_MAP_WIDTH = 32, NPH_POP_MAP_HEIGHT = 16 };
enum { NPH_POP_ITERATIONS_MAX = 10000, NPH_POP_ORDINATES_MAX = 4096, NPH_POP_VPLS_MAX = 4096 };
enum { NPH_POP_CELL = 4 }; /* numbers of a merged cell: three channels, and the density over the largest */

/* What plan, run and replay agree on. */
typedef struct NphPopChoice {
    NphTransportChoice transport;
    int medium;              /* the one that is lit and marched, or -1 */
    int lit;                 /* something shines and scatters */
    int channels;            /* of propagation: 1 where the medium is grey */
    int suns, sky, points, vpls; /* grids of suns, of the rest of the sky, of points, of virtual point lights */
    int rsm, shadows;        /* texels of a reflective shadow map along an edge; rays of a cell's shadows along one, 0: there are none */
    int importance;          /* the map is made */
    int residuum;
    int32_t flat[3], radial[3], vpl[3]; /* cells of a grid */
    int32_t joined[3], gathered[3], merged[3], fine[3], mips[3];
    int level;               /* of the density: voxels of 2^level */
    int iterations;          /* of the propagation; 0: the number is known once there are ordinates (Eq. 10) */
    double mean_density;
} NphPopChoice;

static inline int64_t nph_pop_cells(const int32_t n[3]) { return (int64_t)n[0] * n[1] * n[2]; }
/* Grids of light that has met no surface. */
static inline int nph_pop_lamps(const NphPopChoice *c) { return c->suns + c->sky + c->points; }
static inline int nph_pop_grids(const NphPopChoice *c) { return nph_pop_lamps(c) + c->vpls; }
static inline const int32_t *nph_pop_shape(const NphPopChoice *c, int grid) {
    return grid < c->suns + c->sky ? c->flat : grid < nph_pop_lamps(c) ? c->radial : c->vpl;
}
/* The first cell of a grid when each has `channels` of them. */
static inline int64_t nph_pop_first(const NphPopChoice *c, int grid, int channels) {
    int lamps = nph_pop_lamps(c), flat = c->suns + c->sky, lamp = grid < lamps ? grid : lamps, before = lamp < flat ? lamp : flat;
    return channels * (before * nph_pop_cells(c->flat) + (lamp - before) * nph_pop_cells(c->radial) + (grid - lamp) * nph_pop_cells(c->vpl));
}

NphStatus nph_pop_choose(const NphJob *job, NphPopChoice *choice);
NphStatus nph_pop_plan(const NphJob *job, NphPlan *plan);

/* Arrays that kernels work on, in the precision's numbers. */
typedef struct NphPopArrays {
    void *medium, *importance, *ordinate, *rsm, *density, *lit, *light, *cosine, *seen;
    double *power;   /* [grid][channel][NPH_POP_POWERS] */
    void *residuum[2]; /* what is under way, before and after an iteration: [channel][z][y][x] */
    void *spread;      /* the sum of what has arrived */
    void *keep;        /* what is left on half the way through a cell of theirs, [axis][channel][cell]; then the path of a visit over its edge */
    void *gathered;    /* [channel][z][y][x] */
    void *merged, *fine;
} NphPopArrays;

/* The kernels of one precision. Memory is the caller's; `worker` is NphPopKernels.scratch_bytes. */
typedef struct NphPopKernels {
    size_t (*scene_bytes)(void);
    size_t (*scratch_bytes)(const NphPopChoice *choice);
    void (*prepare)(const NphJob *job, const NphPopChoice *choice, void *scene);
    void (*medium)(const void *scene, int first, int end, void *medium); /* planes */
    void (*importance)(const void *scene, const NphPopArrays *arrays, void *worker);
    void (*ordinates)(const NphJob *job, const void *scene, const void *importance, double *texels, void *ordinate);
    void (*reflect)(const void *scene, const NphPopArrays *arrays, int lamp);
    void (*vpls)(const NphJob *job, const void *scene, const NphPopArrays *arrays);
    void (*shadow)(const void *scene, const NphPopArrays *arrays, int grid);
    int (*iterations)(const void *scene, const void *ordinate); /* Eq. 10 */
    void (*grid)(const void *scene, const NphPopArrays *arrays, int grid);
    void (*inject)(const void *scene, const NphPopArrays *arrays, int grid, void *worker);
    /* iterations: first, end, and how many there are in all */
    void (*propagate)(const void *scene, const NphPopArrays *arrays, int grid, const int iterations[3], void *worker);
    double (*leaves)(const void *scene, const NphPopArrays *arrays, int grid, int channel, void *worker); /* through the border, next time */
    void (*join)(const void *scene, const NphPopArrays *arrays, int first, int end); /* planes of residuum[0] */
    void (*join_scale)(const void *scene, const NphPopArrays *arrays);
    void (*keep)(const void *scene, const NphPopArrays *arrays, int first, int end);
    void (*spread)(const void *scene, const NphPopArrays *arrays, int from, int first, int end); /* residuum[from] to the other */
    double (*left)(const void *scene, const NphPopArrays *arrays, int from); /* of what was joined */
    void (*gather)(const void *scene, const NphPopArrays *arrays, int first, int end); /* planes of gathered */
    void (*merge)(const void *scene, const NphPopArrays *arrays, int first, int end); /* planes of merged */
    void (*upsample)(const void *scene, const NphPopArrays *arrays, int first, int end); /* planes of fine */
    void (*march)(const void *scene, const NphPopArrays *arrays, const int rect[4], int64_t chunk, void *samples, int64_t *steps);
    void (*replay)(const void *scene, const NphPopArrays *arrays, const int pixel[2], uint32_t sample, NphLineFn line, void *user);
    void (*facts)(const void *scene, NphFactFn fact, void *user);
} NphPopKernels;
void nph_pop_kernels(int precision, NphIsa isa, NphPopKernels *kernels);

/* pop_solve.c: the solution, on the pool. */
typedef struct NphPopSolver {
    NphJob job;
    NphPopChoice choice;
    NphPopKernels kernels;
    void *scene;
    NphPopArrays arrays;
    double *texels;         /* of the sky: sums of what is looked for in it */
    void **scratch;         /* per worker */
    NphStageCounts *stages; /* per worker */
    int threads;
    int iteration;          /* of propagate: the one to do; -1: all that are left */
    int iterations;         /* how many there are */
    int from;               /* which of the two arrays holds the residuum */
    int kept;               /* arrays.keep is made */
} NphPopSolver;
NphStatus nph_pop_solver_open(const NphJob *job, NphPopSolver *solver);
void nph_pop_solver_close(NphPopSolver *solver);
/* Bytes of the arrays, by buffer. */
uint64_t nph_pop_buffer_bytes(const NphPopChoice *choice, int precision, NphPopBuffer buffer);
int64_t nph_pop_sky_texels(const NphScene *scene);
/* One launch of a stage up to NPH_POP_UPSAMPLE, and whether a picture has it. */
NphStatus nph_pop_step(NphPopSolver *solver, NphPopStage stage);
int nph_pop_has(const NphPopSolver *solver, NphPopStage stage);
/* Whether the residuum is still worth an iteration. joined: what was joined. */
int nph_pop_spreads(const NphPopSolver *solver, double joined);

/* pop.c: a run. */
typedef struct NphPopWorker {
    void *samples;
    double *film_scratch;
    int64_t steps;
} NphPopWorker;

typedef struct NphPopState {
    NphPopSolver solver;
    NphPopWorker *workers;
    NphFilm *film;
    int64_t begin, end, done, total, tiles_done;
    double started;
} NphPopState;
NphStatus nph_pop_launch(NphPopState *state, int worker, const NphLaunch *launch);

/* pop_alone.c: NphMethod's calls of these names. */
NphStatus nph_pop_begin_launch(void *state, int worker, NphFilm *film, const NphLaunch *launch);
NphStatus nph_pop_extend(void *state, int worker, int buffer, const int64_t *shape);
int nph_pop_view(void *state, int worker, int buffer, NphView *view);
NphStatus nph_pop_check(void *state, int worker, const NphLaunch *launch);

#endif
