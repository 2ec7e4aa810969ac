/* SPDX-License-Identifier: Apache-2.0
 *
 * truth/shdom: the spherical harmonics discrete ordinates method [Evans98], on a grid of points over one medium.
 *   1 properties  the mean density of every cell
 *   2 direct      light of suns and points, attenuated exactly to the points, as harmonics of what it scatters first; what every cell
 *                 gets of it in the mean; light at infinity by ordinate
 *   3 sweep       radiance of a group of ordinates, point by point along each: short characteristics [Kunasz88]
 *   4 moments     their harmonics
 *   5 first       what has been scattered at most once so far, and the source function that follows from it
 *   6 scatter     the source function that follows from the last one's radiance
 *   7 accelerate  the next source function from the last ones [Anderson65]; until it changes by less than the tolerance
 *   8 finish      the source function point by point, as cameras look it up
 *   9 generate    camera rays, those of path
 *  10 march       the source function along them through the density itself, and single scattering of suns and points by quadrature
 *  11 accumulate  into the film's tree
 * The phase function's peak is cut off and its light goes on (delta-M [Wiscombe77]); what is scattered once is corrected for it along
 * camera rays [Nakajima88]. Stages 1, 2 and 10 are computed in double, whatever the precision of the run; 3 to 8 in it. */
#ifndef NPH_TRUTH_SHDOM_SHDOM_H
#define NPH_TRUTH_SHDOM_SHDOM_H

#include "truth/shdom/shdom_angles.h"
#include "truth/shdom/shdom_kernels.h"
#include "truth/single/single.h"

extern const NphMethod nph_shdom;

enum { NPH_SHDOM_HISTORY_MAX = 32, NPH_SHDOM_GATHER_MAX = 64, NPH_SHDOM_POINTS_MAX = 1 << 27 };
enum { NPH_SHDOM_BATCH = NPH_TILE_PIXELS * NPH_CHUNK, NPH_SHDOM_RAY_ROWS = 12 };

typedef enum NphShdomStage {
    NPH_SHDOM_PROPERTIES,
    NPH_SHDOM_DIRECT,
    NPH_SHDOM_SWEEP,
    NPH_SHDOM_MOMENTS,
    NPH_SHDOM_FIRST,
    NPH_SHDOM_SCATTER,
    NPH_SHDOM_ACCELERATE,
    NPH_SHDOM_FINISH,
    NPH_SHDOM_GENERATE,
    NPH_SHDOM_MARCH,
    NPH_SHDOM_ACCUMULATE,
    NPH_SHDOM_STAGES
} NphShdomStage;

typedef enum NphShdomBuffer {
    NPH_SHDOM_B_DENSITY,
    NPH_SHDOM_B_BEAM,
    NPH_SHDOM_B_SHARE,
    NPH_SHDOM_B_SUN,
    NPH_SHDOM_B_SUN_MEAN,
    NPH_SHDOM_B_BORDER,
    NPH_SHDOM_B_SOURCE,
    NPH_SHDOM_B_RADIANCE,
    NPH_SHDOM_B_MEAN,
    NPH_SHDOM_B_MOMENTS,
    NPH_SHDOM_B_FIRST,
    NPH_SHDOM_B_SCATTERED,
    NPH_SHDOM_B_HISTORY,
    NPH_SHDOM_B_GRAM,
    NPH_SHDOM_B_RESIDUAL,
    NPH_SHDOM_B_FIELD,
    NPH_SHDOM_B_BUBBLE,
    NPH_SHDOM_B_RAY,
    NPH_SHDOM_B_SAMPLE,
    NPH_SHDOM_B_NODE,
    NPH_SHDOM_BUFFERS
} NphShdomBuffer;

enum {
    NPH_SHDOM_ARG_CHANNEL, NPH_SHDOM_ARG_ITERATION, NPH_SHDOM_ARG_GROUP, NPH_SHDOM_ARG_TILE, NPH_SHDOM_ARG_CHUNK,
    NPH_SHDOM_ARGUMENTS
};

enum {
    NPH_SHDOM_KNOB_CELLS,
    NPH_SHDOM_KNOB_CELLS_X,
    NPH_SHDOM_KNOB_CELLS_Y,
    NPH_SHDOM_KNOB_CELLS_Z,
    NPH_SHDOM_KNOB_BANDS,
    NPH_SHDOM_KNOB_POLAR,
    NPH_SHDOM_KNOB_AZIMUTHS,
    NPH_SHDOM_KNOB_CUBIC,
    NPH_SHDOM_KNOB_THIN,
    NPH_SHDOM_KNOB_DELTA_M,
    NPH_SHDOM_KNOB_SINGLE,
    NPH_SHDOM_KNOB_PREFILTER,
    NPH_SHDOM_KNOB_WIDTH,
    NPH_SHDOM_KNOB_TOLERANCE,
    NPH_SHDOM_KNOB_ITERATIONS,
    NPH_SHDOM_KNOB_HISTORY,
    NPH_SHDOM_KNOB_QUADRATURE,
    NPH_SHDOM_KNOB_GATHER,
    NPH_SHDOM_KNOBS
};

/* What plan, run and replay agree on. */
typedef struct NphShdomChoice {
    NphTransportChoice transport;
    int medium;       /* the one there is, or -1 */
    int solved;       /* something is scattered, of some light */
    int channels;     /* that are solved for: 1 when media and lights are grey, else 3 */
    int looks;        /* cameras look up first scattering in the grid too (parts of field: 2, else 1) */
    double thin;      /* NphShdomSweep */
    int cubic;        /* radiance is interpolated by cubics */
    int sun_count, suns[NPH_MAX_LIGHTS]; /* lights that sweeps follow within cells; none where `looks` */
    int history;      /* sources that accelerate looks back on */
    NphShdomGrid grid;
    NphShdomAngles angles;
    double extinction[3], albedo[3]; /* scaled by delta-M: per unit of density [1/m]; 1 */
    double kept[3];                  /* 1 - albedo f: the scaled extinction over the true one */
} NphShdomChoice;
/* NPH_BAD_SCENE, NPH_BAD_USAGE when the method cannot do it. */
NphStatus nph_shdom_choose(const NphJob *job, NphShdomChoice *choice);
NphStatus nph_shdom_plan(const NphJob *job, NphPlan *plan);

/* Everything the solution needs, on the pool. */
typedef struct NphShdomSolver {
    NphContext *context;
    int precision;
    const NphShdomChoice *choice;
    const NphSingleScene *scene; /* with the true extinction */
    NphShdomKernels kernels;
    void *density, *beam, *share, *border, *ones, *sun, *sun_mean; /* ones: a share that changes nothing */
    void *source, *moments, *first, *scattered, *history, *radiance, *mean, *field, *bubble, *bubble_now, *nothing;
    double *gram, *partial, *factors, *residual;
    void **projected;            /* of workers */
    double **rows;               /* of workers: doubles on their way into these arrays */
    NphStageCounts *counts;      /* of workers */
    NphWalked *walked;           /* of workers */
    int64_t *unsettled;          /* of workers: sweeps */
    int channel, iteration, group;
    int iterations[3];           /* that channels took */
    double reached[3];           /* their last residuals */
} NphShdomSolver;
NphStatus nph_shdom_solver_open(const NphJob *job, const NphShdomChoice *choice, const NphSingleScene *scene, NphShdomSolver *solver);
void nph_shdom_solver_close(NphShdomSolver *solver);
uint64_t nph_shdom_solver_bytes(const NphJob *job, const NphShdomChoice *choice, int threads);
/* One stage, up to NPH_SHDOM_FINISH, of the solver's channel, iteration and group. */
NphStatus nph_shdom_step(NphShdomSolver *solver, NphShdomStage stage);
int nph_shdom_groups(const NphShdomChoice *choice);
int nph_shdom_group_size(const NphShdomChoice *choice, int group);
int64_t nph_shdom_blocks(int64_t items);
/* Numbers of a source function: coefficients by points, then the mean of degree 0 in every cell. */
int64_t nph_shdom_row(const NphShdomChoice *choice);

/* shdom_1_properties.c, shdom_2_direct.c: blocks of those stages. */
void nph_shdom_properties(NphShdomSolver *solver, int64_t block, int worker);
void nph_shdom_direct_points(NphShdomSolver *solver, int64_t block, int worker);
void nph_shdom_direct_cells(NphShdomSolver *solver, int64_t block, int worker);
void nph_shdom_border(NphShdomSolver *solver, double *border); /* [channel][ordinate] */

/* shdom_7_accelerate.c */
NphStatus nph_shdom_accelerate(NphShdomSolver *solver);

/* shdom_10_march.c: what cameras need; scenes: the media as delta-M leaves them. */
typedef struct NphShdomCamera {
    const NphShdomChoice *choice;
    const NphSingleScene *scene; /* scaled: extinction as solved; albedo times extinction is the true scattering */
    const void *field;           /* NULL: nothing was solved */
    const void *share, *bubble;
    NphShdomKernels kernels;
    int gather;                  /* polar angles of a sensor that gathers, per hemisphere */
    const double *gather_cosines, *gather_weights;
} NphShdomCamera;
void nph_shdom_scale_scene(const NphShdomChoice *choice, NphSingleScene *scene);
/* scratch of single (single.h); look: doubles of nph_shdom_look_doubles. */
typedef struct NphShdomRoom {
    NphSingleScratch *scratch;
    double *look;
} NphShdomRoom;
size_t nph_shdom_look_doubles(const NphShdomChoice *choice);
void nph_shdom_march(const NphShdomCamera *camera, const NphShdomRoom *room, const RCameraRay *ray, const NphSingleAsk *ask,
                     double fields[NPH_SAMPLE_FIELDS]);

/* shdom_11_gather.c: sensors for flux and fluence. */
void nph_shdom_march_gather(const NphShdomCamera *camera, const NphShdomRoom *room, const RCameraRay *ray, const NphSingleAsk *ask,
                            double fields[NPH_SAMPLE_FIELDS]);

/* shdom.c, shdom_alone.c: a run. */
typedef struct NphShdomWorker {
    double *rays, *samples; /* [12][ray], [field][ray] */
    void *memory, *film_scratch;
    NphShdomRoom room;
    int64_t chunk;
    int origin[2], inside[4];
} NphShdomWorker;

typedef struct NphShdomState {
    NphJob job;
    NphShdomChoice choice;
    NphSingleScene *scenes; /* true, scaled */
    NphShdomSolver solver;
    NphShdomCamera camera;
    double gather_rules[2 * NPH_SHDOM_GATHER_MAX];
    int threads, opened;
    NphShdomWorker *workers;
    NphFilm *film;
    int64_t begin, end, done, total, tiles_done;
    double started;
} NphShdomState;
extern const NphStage nph_shdom_stages[NPH_SHDOM_STAGES];
extern const NphBuffer nph_shdom_buffers[NPH_SHDOM_BUFFERS];
void nph_shdom_begin_batch(NphShdomState *state, NphShdomWorker *worker, int64_t tile, int64_t chunk);
NphStatus nph_shdom_launch(NphShdomState *state, int worker, const NphLaunch *launch);
/* A sample of the film from its camera ray, whatever the sensor. */
void nph_shdom_see(NphShdomState *state, int worker, const RCameraRay *ray, const NphSingleAsk *ask, double fields[NPH_SAMPLE_FIELDS]);
NphStatus nph_shdom_begin_launch(void *state, int worker, NphFilm *film, const NphLaunch *launch);
NphStatus nph_shdom_extend(void *state, int worker, int buffer, const int64_t *shape);
int nph_shdom_view(void *state, int worker, int buffer, NphView *view);
NphStatus nph_shdom_check(void *state, int worker, const NphLaunch *launch);
NphStatus nph_shdom_launch_alone(void *state, int worker, const NphLaunch *launch);

#endif
