/* SPDX-License-Identifier: Apache-2.0
 *
 * truth/light: light tracing, path's adversary: photons go from the lights to the sensor. A film sample is one image,
 * made by N photons; its pixels share them.
 *   1 trace       per sample: emit N photons, follow them; every vertex is connected to the sensor, or their crossings of
 *                 it are counted
 *   2 see         per pixel: what reaches the sensor without meeting anything (light tracing cannot connect a light at
 *                 infinity to a pinhole); joins it to the images
 *   3 accumulate  into the film's trees: of pixels, tiles and image
 * light_trace_kernel.c follows one photon from its light to its end in scalar code: the text to read first. */
#ifndef NPH_TRUTH_LIGHT_LIGHT_TRACING_H
#define NPH_TRUTH_LIGHT_LIGHT_TRACING_H

#include "transport/choice.h"
#include "transport/emission_source.h"

extern const NphMethod nph_light;

typedef enum NphLightStage { NPH_LIGHT_TRACE, NPH_LIGHT_SEE, NPH_LIGHT_ACCUMULATE, NPH_LIGHT_STAGES } NphLightStage;

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

/* Of a tile's sample buffer. */
size_t nph_light_sample_bytes(int precision);

/* One sample: an image of the crop, [film channel, then order][pixel]. */
typedef struct NphLightImage {
    double *planes;
    int crop[4];
    int64_t sample;
    NphTally tally;
    NphLineFn line; /* replay: tells what arrives in the crop, which is one pixel; else NULL */
    void *user;
} NphLightImage;

/* The kernels of one precision. Memory is the caller's, 64-byte aligned. */
typedef struct NphLightKernels {
    size_t (*scene_bytes)(void);
    void (*prepare)(const NphJob *job, const NphLightChoice *choice, const NphEmissionSources *sources, void *scene);
    /* Adds all photons of a sample to its image, which is 0. */
    void (*trace)(const void *scene, NphLightImage *image);
    /* The sample buffer of a film tile from the images of its chunk's samples and what the pixels see themselves. */
    void (*see)(const void *scene, const NphLightImage images[NPH_CHUNK], const int origin[2], const int inside[4],
                void *samples, NphTally *tally);
} NphLightKernels;
void nph_light_kernels(int precision, NphLightKernels *kernels);

#endif
