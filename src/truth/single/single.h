/* SPDX-License-Identifier: Apache-2.0
 *
 * truth/single: light that has been scattered at most once, by quadrature instead of chance [Kajiya84]. Its stages:
 *   1 generate   camera rays, the same as those of path
 *   2 meet       the surfaces that they end at
 *   3 gather     light that sensors for flux and fluence get straight from the lights
 *   4 march      per ray: densities along it (single_profile.c), what media emit, and for every light the adaptive
 *                quadrature of what is scattered towards the sensor (single_quadrature.c)
 *   5 arrive     what surfaces reflect
 *   6 leave      lights at infinity behind everything
 *   7 fold       groups of wavelengths, which have stages 2 to 6 each
 *   8 accumulate into the film's tree
 * Everything is computed in double, whatever the precision of the run. It shares no estimator with path: optical depths
 * are exact (single_walk.h), nothing is tracked. What chance is left: where a ray meets its pixel, and one direction a
 * ray for each light that has a size. */
#ifndef NPH_TRUTH_SINGLE_SINGLE_H
#define NPH_TRUTH_SINGLE_SINGLE_H

#include "core/message.h"
#include "pipeline/method.h"
#include "transport/camera_lookup.h"
#include "transport/choice.h"
#include "transport/surfaces_lookup.h"
#include "truth/single/single_walk.h"
#ifdef NPH_KERNEL_SUFFIX
#include "truth/single/single_names.h"
#endif

extern const NphMethod nph_single;

enum { NPH_SINGLE_BATCH = NPH_TILE_PIXELS * NPH_CHUNK };

typedef enum NphSingleStage {
    NPH_SINGLE_GENERATE,
    NPH_SINGLE_MEET,
    NPH_SINGLE_GATHER,
    NPH_SINGLE_MARCH,
    NPH_SINGLE_ARRIVE,
    NPH_SINGLE_LEAVE,
    NPH_SINGLE_FOLD,
    NPH_SINGLE_ACCUMULATE,
    NPH_SINGLE_STAGES
} NphSingleStage;

typedef enum NphSingleBuffer {
    NPH_SINGLE_RAY,
    NPH_SINGLE_SURFACE,
    NPH_SINGLE_TOUCH,
    NPH_SINGLE_TRANSMITTANCE,
    NPH_SINGLE_SCATTERED,
    NPH_SINGLE_PART,
    NPH_SINGLE_SAMPLE,
    NPH_SINGLE_NODE,
    NPH_SINGLE_BUFFERS
} NphSingleBuffer;
typedef enum NphSingleArgument { NPH_SINGLE_TILE, NPH_SINGLE_CHUNK, NPH_SINGLE_GROUP, NPH_SINGLE_ARGUMENTS } NphSingleArgument;

enum { NPH_SINGLE_KNOB_TOLERANCE, NPH_SINGLE_KNOB_PANELS, NPH_SINGLE_KNOB_MODE, NPH_SINGLE_KNOBS };
enum { NPH_SINGLE_KAJIYA, NPH_SINGLE_BLINN }; /* single.mode */

/* The part of a ray that is looked at at once: so many pieces of a medium, so many panels of a quadrature. */
enum { NPH_SINGLE_PIECES = 1024, NPH_SINGLE_PANELS_MAX = 1024 };

/* Media, and what emits: up to three grids of a medium. */
enum { NPH_SINGLE_GLOWS = 3 * NPH_MAX_MEDIA, NPH_SINGLE_FIELDS = NPH_MAX_MEDIA + NPH_SINGLE_GLOWS };

/* Beyond this optical depth of the camera ray, in its thinnest channel, nothing is looked for: e^-128 = 2.6e-56. */
#define NPH_SINGLE_OPAQUE 128.0

/* What statistics show, and what must not pass silently. */
typedef struct NphSingleTally {
    NphWalked walked;
    int64_t points;      /* at which light was looked for: optical depths towards lights */
    int64_t integrals;   /* a ray and a light each */
    int64_t unconverged; /* integrals that ended above their tolerance */
    double worst;        /* largest estimate of such an error, relative to the integral */
} NphSingleTally;

/* What plan, run and replay agree on. */
typedef struct NphSingleChoice {
    NphTransportChoice transport;
    int scattered[NPH_MAX_LIGHTS]; /* lights whose light media scatter */
    int reflected[NPH_MAX_LIGHTS]; /* and surfaces reflect */
    int layer;                     /* the one medium, a layer, has Blinn's closed form */
} NphSingleChoice;
void nph_single_choose(const NphJob *job, NphSingleChoice *choice);

typedef struct NphSingleScene {
    RScene local;
    NphSingleChoice choice;
    double tolerance;
    int panels, mode;
    int fields;                     /* media, and glows behind them */
    RMedium glow[NPH_SINGLE_GLOWS]; /* what emits: j_c = glow_value[c] times its density */
    double glow_value[NPH_SINGLE_GLOWS][3];
    double beam[NPH_MAX_LIGHTS][3]; /* of suns: irradiance [W/m2], also of those with a disc */
} NphSingleScene;

/* One worker's memory: what single_profile.h and single_quadrature.h lay into it. */
typedef struct NphSingleScratch NphSingleScratch;
size_t nph_single_scratch_bytes(int fields);
void nph_single_scratch_layout(void *memory, int fields, NphSingleScratch **scratch);
int nph_single_fields(const NphScene *scene); /* at most */

/* Who is asking: the random stream's pixel and sample, and where lines of a replay go (line NULL: nowhere). */
typedef struct NphSingleAsk {
    uint32_t pixel, sample;
    NphLineFn line;
    void *user;
} NphSingleAsk;
void nph_single_tell(const NphSingleAsk *ask, const char *format, ...) NPH_PRINTF(2, 3);

/* A ray under way, in one group of wavelengths. */
typedef struct NphSingleState {
    RCameraRay ray;
    RMet met;                            /* surface -1: none */
    double T[3];                         /* e^-tau up to there */
    double scattered[NPH_MAX_LIGHTS][3]; /* of part, by the lights: scattered once in media; channels of transport */
    double part[NPH_SAMPLE_FIELDS];
} NphSingleState;

/* single_march.c: the stages of one ray; and all of them: its sample. */
void nph_single_meet(const NphSingleScene *scene, NphSingleState *state);
void nph_single_gather(const NphSingleScene *scene, NphSingleScratch *scratch, NphSingleState *state, const NphSingleAsk *ask);
void nph_single_follow(const NphSingleScene *scene, NphSingleScratch *scratch, NphSingleState *state, const NphSingleAsk *ask);
void nph_single_arrive(const NphSingleScene *scene, NphSingleScratch *scratch, NphSingleState *state, const NphSingleAsk *ask);
void nph_single_leave(const NphSingleScene *scene, NphSingleScratch *scratch, NphSingleState *state, const NphSingleAsk *ask);
void nph_single_fold(const NphSingleScene *scene, int group, const NphSingleState *state, double fields[NPH_SAMPLE_FIELDS]);
void nph_single_march(const NphSingleScene *scenes, NphSingleScratch *scratch, const RCameraRay *ray,
                      const NphSingleAsk *ask, double fields[NPH_SAMPLE_FIELDS]);
const NphSingleTally *nph_single_tally(const NphSingleScratch *scratch);

/* single_stages.c: a batch of rays, one tile and one chunk, as the stages pass it on: [row][ray], a ray being pixel in its
 * tile * 16 + sample in its chunk. Rays that are not in the picture have no weight. */
typedef struct NphSingleBatch {
    const NphSingleScene *scenes; /* one a group */
    NphSingleScratch *scratch;
    int origin[2], inside[4];
    int64_t chunk;
    int group;
    double *rows, *samples;
    int32_t *surface;
} NphSingleBatch;
extern const NphBuffer nph_single_buffers[NPH_SINGLE_BUFFERS];
size_t nph_single_batch_doubles(const NphScene *scene);
RCameraRay nph_single_ray(const RScene *scene, int x, int y, uint32_t pixel, uint32_t sample);
void nph_single_launch(NphSingleBatch *batch, NphSingleStage stage);

/* nph_single_launch; in altered programs that of a level (src/altered/meson.build). */
typedef void (*NphSingleLaunchFn)(NphSingleBatch *batch, NphSingleStage stage);
NphSingleLaunchFn nph_single_kernel(NphIsa isa);
int nph_single_view(const NphSingleBatch *batch, int buffer, NphView *view); /* all but film.node */
/* NPH_BAD_INPUT where an input is one that no run could have. */
NphStatus nph_single_check(NphContext *context, const NphSingleBatch *batch, const NphStage *stage);

/* single_scene.c */
int nph_single_groups(const NphJob *job);
void nph_single_prepare(const NphJob *job, NphSingleScene *scenes); /* one a group of wavelengths; else one */
NphStatus nph_single_plan(const NphJob *job, NphPlan *plan);

#endif
