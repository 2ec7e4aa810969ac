/* SPDX-License-Identifier: Apache-2.0
 *
 * truth/light: light tracing, path's adversary: photons go from the lights to the sensor. A film sample is one image,
 * made by N photons; its pixels share them.
 *   1 emit        photons of a block set out
 *   2 trace       they are followed to their end: flights, each with the vertex that it ends at
 *   3 connect     every vertex to the sensor, or crossings of it: splats
 *   4 splat       into the sample's image
 *   5 see         per pixel: what reaches the sensor without meeting anything (light tracing cannot connect a light at
 *                 infinity to a pinhole); joins it to the images
 *   6 accumulate  into the film's trees: of pixels, tiles and image
 * light_trace_kernel.c follows one photon from its light to its end in scalar code: the text to read first. */
#ifndef NPH_TRUTH_LIGHT_LIGHT_TRACING_H
#define NPH_TRUTH_LIGHT_LIGHT_TRACING_H

#include "transport/choice.h"
#include "transport/emission_source.h"

extern const NphMethod nph_light;

typedef enum NphLightStage { NPH_LIGHT_EMIT, NPH_LIGHT_TRACE, NPH_LIGHT_CONNECT, NPH_LIGHT_SPLAT, NPH_LIGHT_SEE,
                             NPH_LIGHT_ACCUMULATE, NPH_LIGHT_STAGES } NphLightStage;

/* Of photons that set out, of what waits, of flights, of splats, of images. */
typedef enum NphLightBuffer {
    NPH_LIGHT_RAY, NPH_LIGHT_POWER, NPH_LIGHT_UNIT, NPH_LIGHT_SOURCE, NPH_LIGHT_HERO,
    NPH_LIGHT_PLACE, NPH_LIGHT_WAITING, NPH_LIGHT_WAITING_AT,
    NPH_LIGHT_FLIGHT, NPH_LIGHT_FLIGHT_RAY, NPH_LIGHT_FLIGHT_WEIGHT, NPH_LIGHT_FLIGHT_SHARE, NPH_LIGHT_FLIGHT_HERO,
    NPH_LIGHT_FLIGHT_ORDER, NPH_LIGHT_FLIGHT_DISTANCE, NPH_LIGHT_FLIGHT_MEDIUM, NPH_LIGHT_FLIGHT_SURFACE,
    NPH_LIGHT_FLIGHT_TOUCH, NPH_LIGHT_FLIGHT_LEFT,
    NPH_LIGHT_SPLATS, NPH_LIGHT_SPLAT_AT, NPH_LIGHT_SPLAT_ADD, NPH_LIGHT_SPLAT_FROM, NPH_LIGHT_SPLAT_ORDER,
    NPH_LIGHT_IMAGE, NPH_LIGHT_TRACED, NPH_LIGHT_SAMPLE, NPH_LIGHT_NODE, NPH_LIGHT_BUFFERS
} NphLightBuffer;
typedef enum NphLightArgument { NPH_LIGHT_ARG_SAMPLE, NPH_LIGHT_ARG_BLOCK, NPH_LIGHT_ARG_TILE, NPH_LIGHT_ARGUMENTS } NphLightArgument;

/* Photons of a block; flights of one launch; vertices at which copies of a photon wait, and how many copies at most. */
enum { NPH_LIGHT_BLOCK = 1024, NPH_LIGHT_FLIGHTS = 1024, NPH_LIGHT_SPLITS = 256, NPH_LIGHT_COPIES = 16 };

enum { NPH_LIGHT_KNOB_PHOTONS, NPH_LIGHT_KNOB_ROULETTE, NPH_LIGHT_KNOB_CONNECT_ROULETTE, NPH_LIGHT_KNOB_COUNT,
       NPH_LIGHT_KNOB_SPLIT, NPH_LIGHT_KNOBS };

/* Where photons of lights at infinity start (light_1_emit_lookup.h); scene-local. */
typedef struct NphLightAim {
    int box;                  /* media or meshes that have ends */
    double lo[3], hi[3];      /* their box */
    int unbounded;            /* layers or planes */
    double level, slab[2];    /* the plane that photons are aimed at; z of all layers and planes */
    double centre[2][3];      /* foot of the sensor, of the box, on that plane; and how high above it */
    double target[4];         /* a sphere around the box and a flux sensor: what distant reflections should not miss; 0: none */
    int wrapped;              /* sides repeat, or nothing changes along x and y: every crossing stands for a lattice */
    double area;              /* then: of one cell of the lattice on a level, m2 */
    double steps[2][2];       /* x, y of the lattice's two steps: columns */
    double st_from_steps[2][2], steps_from_st[2][2]; /* the lattice on the sensor (s, t) */
} NphLightAim;

/* What the plan decided, for plan, run and replay. */
typedef struct NphLightChoice {
    NphTransportChoice transport;
    NphLightAim aim;
    int64_t photons;                     /* a sample */
    double reach[NPH_MAX_LIGHTS + 2];    /* cumulative probability of the lights, then of the media's own light */
    double unit;                         /* power of a photon in the mean, roughly: what roulette measures weights by */
    int expected;                        /* crossings of a flux sensor are scored by their expected value */
    int split;                           /* towards a flux meter */
    double importance[NPH_MAX_MEDIA];    /* by media of the scene: log of the splitting per metre, layers only */
} NphLightChoice;

NphStatus nph_light_sources(const NphJob *job, NphEmissionSources *sources);
/* NPH_BAD_USAGE names what cannot be done. sources: where light of media begins. */
NphStatus nph_light_choose(const NphJob *job, const NphEmissionSources *sources, NphLightChoice *choice);
NphStatus nph_light_plan(const NphJob *job, NphPlan *plan);

/* Of a tile's sample buffer, and of what the images of a chunk hold there. */
size_t nph_light_sample_bytes(int precision);
size_t nph_light_traced_doubles(int film_channels);

/* One sample: an image of the crop, [film channel, then order][pixel]. */
typedef struct NphLightImage {
    double *planes;
    int crop[4];
    int64_t sample;
    NphLineFn line; /* replay: tells what arrives in the crop, which is one pixel; else NULL */
    void *user;
} NphLightImage;

typedef struct NphLightBatch NphLightBatch; /* light_state.h */

/* The kernels of one precision. Memory is the caller's, 64-byte aligned. */
/* Who has put values into columns: nobody; a stage's inputs, of which there are no others; a watcher of a run. */
typedef enum NphLightPlacing { NPH_LIGHT_NONE, NPH_LIGHT_ALONE, NPH_LIGHT_HELD } NphLightPlacing;

typedef struct NphLightKernels {
    size_t (*scene_bytes)(void);
    void (*prepare)(const NphJob *job, const NphLightChoice *choice, const NphEmissionSources *sources, void *scene);
    size_t (*batch_bytes)(void);
    void (*layout)(void *memory, void *columns, const void *scene, NphLightBatch **batch);
    void (*begin)(NphLightBatch *batch, int64_t sample, int64_t block);
    void (*emit)(NphLightBatch *batch);
    /* Follows as many photons as there is room for flights, until none is unfinished. */
    void (*trace)(NphLightBatch *batch);
    int (*unfinished)(const NphLightBatch *batch);
    void (*connect)(NphLightBatch *batch);
    void (*splat)(const NphLightBatch *batch, const NphLightImage *image);
    /* The sample buffer of a film tile, from what the images of its chunk's samples hold there, [film channel, then
     * order][pixel][sample], and what the pixels see themselves. */
    void (*see)(const void *scene, const double *traced, const int origin[2], const int inside[4], int64_t sample, void *samples,
                NphTally *tally);
    int64_t (*items)(const NphLightBatch *batch, NphLightStage stage);
    /* What follows needs columns of so many bytes; start: values are placed, and `take` makes them the batch's. */
    size_t (*column_bytes)(void);
    void (*start)(NphLightBatch *batch, NphLightPlacing placing);
    void (*take)(NphLightBatch *batch, const char *reads);
    NphStatus (*extend)(NphLightBatch *batch, int buffer, int64_t items);
    int (*view)(NphLightBatch *batch, int buffer, NphView *view);
    NphTally *(*tally)(NphLightBatch *batch);
} NphLightKernels;
void nph_light_kernels(NphIsa isa, int precision, NphLightKernels *kernels);

typedef struct NphLightWorker {
    NphLightBatch *batch;
    NphLightImage *image; /* that its photons go to */
    void *memory, *columns, *samples; /* columns: NULL where nobody looks */
    double *traced, *film_scratch;
    NphStageCounts counts;
} NphLightWorker;

/* light.c: a run. */
typedef struct NphLightState {
    NphJob job;
    NphLightChoice choice;
    NphEmissionSources sources;
    NphLightKernels kernels;
    void *scene;
    double *planes;
    size_t image_doubles;
    NphLightImage images[NPH_CHUNK];
    int threads;
    NphLightWorker *workers;
    /* of the pass under way */
    NphFilm *film;
    int64_t chunk, images_done, images_total, images_before;
    double started;
} NphLightState;
NphStatus nph_light_open_columns(NphLightState *state, int worker); /* for tap, and stages alone */
int64_t nph_light_blocks(const NphLightState *state);
void nph_light_launch(NphLightState *state, int worker, const NphLaunch *launch);

/* light_alone.c: NphMethod's calls of these names. */
extern const NphBuffer nph_light_buffers[NPH_LIGHT_BUFFERS];
NphStatus nph_light_begin_launch(void *state, int worker, NphFilm *film, const NphLaunch *launch);
NphStatus nph_light_extend(void *state, int worker, int buffer, const int64_t *shape);
int nph_light_view(void *state, int worker, int buffer, NphView *view);
void nph_light_hold(void *state, int worker);
NphStatus nph_light_check(void *state, int worker, const NphLaunch *launch);
NphStatus nph_light_launch_alone(void *state, int worker, const NphLaunch *launch);

#endif
