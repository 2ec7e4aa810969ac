/* SPDX-License-Identifier: Apache-2.0
 *
 * method/temporal_photons: temporally coherent photon mapping [Elek12]. One sample of the film is one frame, from photons of
 * its own:
 *   0 clear      I of no generation
 *   1 trace      photons of one generation deposit their flux in a coarse grid; every block has its own in shared memory and
 *                adds it to the generation's partial cache H, in 64-bit fixed point
 *   2 update     I = I + H_new, one generation after another; sums of integers, so nothing drifts
 *   3 resolve    fluence, mean cosine and penetration depth of every cell, from the sums
 *   4 upsample   to the resolution of the density: J
 *   5 march      through density and J, at half resolution
 *   6 enlarge    to the pixels of the sensor; from an earlier frame's picture where that one still does (impostors)
 *   7 accumulate into the film's tree
 * Frame f is made of generations f - m + 1 ... f, each a function of its number and of the scene at that frame: any frame has the
 * same bytes alone and within a sequence, which keeps the partial caches and takes the oldest out of I again. */
#ifndef NPH_METHOD_TPM_H
#define NPH_METHOD_TPM_H

#include "transport/choice.h"

extern const NphMethod nph_temporal_photons;
extern const NphStage nph_tpm_stages[];
extern const NphBuffer nph_tpm_buffers[];

enum { NPH_RNG_TPM_EMIT = 48, NPH_RNG_TPM_FLY = 49, NPH_RNG_TPM_SCATTER = 50, NPH_RNG_TPM_NOISE = 51, NPH_RNG_TPM_PIXEL = 52,
       NPH_RNG_TPM_VARY = 53 };

/* Photons of a block, and what it keeps of a cell in shared memory: flux of three channels, flux times cosine, flux times
 * order; in print cosine and order unweighted, and their number. 48 KB hold 2400 cells of five 32-bit values (the sixth, which
 * the print needs too, does not fit); blocks of larger grids add to the partial cache deposit by deposit. */
enum { NPH_TPM_BLOCK = 256, NPH_TPM_VALUES = 6, NPH_TPM_SHARED_CELLS = 2400 };
enum { NPH_TPM_RED, NPH_TPM_COSINE = 3, NPH_TPM_ORDER = 4, NPH_TPM_COUNT = 5 };

/* Photons of the dominant sun, and of all other lights. */
enum { NPH_TPM_SUN, NPH_TPM_SKY, NPH_TPM_KINDS };

/* A cell of I, and of J: fluence of both kinds [W/m2], mean cosines against their directions, mean numbers of scatterings. */
enum {
    NPH_TPM_I_SUN,
    NPH_TPM_I_G = 3,
    NPH_TPM_I_SKY = 4,
    NPH_TPM_I_SKY_G = 7,
    NPH_TPM_I_DEPTH = 8,
    NPH_TPM_I_SKY_DEPTH = 9,
    NPH_TPM_FIELDS = 10
};

enum { NPH_TPM_CELLS_MAX = 1 << 24, NPH_TPM_GENERATIONS_MAX = 4096, NPH_TPM_ORDER_MAX = 1 << 20 };

typedef enum NphTpmStage {
    NPH_TPM_CLEAR,
    NPH_TPM_TRACE,
    NPH_TPM_UPDATE,
    NPH_TPM_RESOLVE,
    NPH_TPM_UPSAMPLE,
    NPH_TPM_MARCH,
    NPH_TPM_ENLARGE,
    NPH_TPM_ACCUMULATE,
    NPH_TPM_STAGES
} NphTpmStage;

typedef enum NphTpmBuffer {
    NPH_TPM_B_PARTIAL,
    NPH_TPM_B_OLD,
    NPH_TPM_B_SUM,
    NPH_TPM_B_COARSE,
    NPH_TPM_B_FINE,
    NPH_TPM_B_PICTURE,
    NPH_TPM_B_IMAGE,
    NPH_TPM_B_SAMPLE,
    NPH_TPM_B_NODE,
    NPH_TPM_BUFFERS
} NphTpmBuffer;

enum { NPH_TPM_ARG_SAMPLE, NPH_TPM_ARG_GENERATION, NPH_TPM_ARG_TILE, NPH_TPM_ARGUMENTS };

enum {
    NPH_TPM_KNOB_VARIANT,
    NPH_TPM_KNOB_PHOTONS,
    NPH_TPM_KNOB_GENERATIONS,
    NPH_TPM_KNOB_PRIMED,
    NPH_TPM_KNOB_REFERENCE,
    NPH_TPM_KNOB_VARY,
    NPH_TPM_KNOB_CELLS,
    NPH_TPM_KNOB_CELLS_X,
    NPH_TPM_KNOB_CELLS_Y,
    NPH_TPM_KNOB_CELLS_Z,
    NPH_TPM_KNOB_THRESHOLD,
    NPH_TPM_KNOB_SIMILARITY,
    NPH_TPM_KNOB_SKY_LOBE,
    NPH_TPM_KNOB_ORDERS,
    NPH_TPM_KNOB_UPSAMPLING,
    NPH_TPM_KNOB_NEIGHBOURHOOD,
    NPH_TPM_KNOB_SPREAD,
    NPH_TPM_KNOB_SPREAD_DENSITY,
    NPH_TPM_KNOB_STEPS,
    NPH_TPM_KNOB_EXIT,
    NPH_TPM_KNOB_NOISE,
    NPH_TPM_KNOB_OCTAVES,
    NPH_TPM_KNOB_HALF,
    NPH_TPM_KNOB_IMPOSTORS,
    NPH_TPM_KNOB_ANGLE,
    NPH_TPM_KNOB_DISTANCE,
    NPH_TPM_KNOB_LIGHT,
    NPH_TPM_KNOB_SHAPE,
    NPH_TPM_KNOBS
};

enum { NPH_TPM_CORRECTED, NPH_TPM_PAPER };
enum { NPH_TPM_LINEAR, NPH_TPM_GAUSSIAN, NPH_TPM_PHYSICAL }; /* upsampling */

/* What plan, run and replay agree on. */
typedef struct NphTpmChoice {
    NphTransportChoice transport;
    int traced;                    /* photons can add something */
    int medium;                    /* the one that is marched, or -1 */
    int dominant;                  /* light whose photons are the sun's, or -1 */
    int similarity;                /* photons may turn isotropic */
    int generations, first;        /* of a frame; the first that there is may be later than f - m + 1 */
    double power[NPH_TPM_KINDS];   /* of the lights of a kind, to weigh them */
    int64_t photons[NPH_TPM_KINDS]; /* of a generation of this scene, where nothing varies them */
    int animated;                  /* generations see scenes of their own */
    int32_t cells[3], fine[3];     /* of I and of J */
    int shared;                    /* blocks have a grid of their own */
    int scale;                     /* a unit of fixed point is 2^-scale of the unit of flux */
} NphTpmChoice;

/* For the job's frame; cells, fixed point and photons are those of the reference frame. reference: the choice of that one, or NULL
 * where nobody asks. */
NphStatus nph_tpm_choose(const NphJob *job, NphTpmChoice *choice, NphTpmChoice *reference);
/* For a scene of another frame. */
NphStatus nph_tpm_choose_like(const NphJob *job, const NphTpmChoice *reference, NphTpmChoice *choice);
/* The scene of the reference frame where it is not the job's own, else NULL; freed by the caller. */
NphStatus nph_tpm_reference(const NphJob *job, NphScene **scene);

/* The photons of one generation. All carry as much as those of the reference frame, n to a generation that shines as brightly: their
 * flux is multiplied by `relative`, and the generation counts as `share` of n. */
typedef struct NphTpmGeneration {
    int64_t photons[NPH_TPM_KINDS];
    double relative[NPH_TPM_KINDS], share[NPH_TPM_KINDS];
} NphTpmGeneration;
void nph_tpm_generation(const NphTpmChoice *reference, const NphTpmChoice *of, double vary, int64_t number, NphTpmGeneration *out);

NphStatus nph_tpm_plan(const NphJob *job, NphPlan *plan);
/* Some generation may have any. */
static inline int nph_tpm_has_photons(const NphTpmChoice *choice) { return choice->traced || choice->animated; }
/* Numbers that are the same, 0 and -0 too. */
static inline int nph_tpm_same(const double *a, const double *b, int count) {
    int same = 1;
    for (int i = 0; i < count; i++) same &= a[i] >= b[i] && a[i] <= b[i];
    return same;
}
static inline int64_t nph_tpm_cells(const int32_t n[3]) { return (int64_t)n[0] * n[1] * n[2]; }

/* The energy of photons in units of fixed point, each entry added up on its own. Of the walk: emitted = escaped + absorbed +
 * stopped (after NPH_TPM_ORDER_MAX scatterings). Of the beams, which are not the walk: begun = collided + past (out of the
 * box) + cut (at the threshold). */
typedef struct NphTpmLedger {
    int64_t emitted, escaped, absorbed, stopped;
    int64_t begun, collided, past, cut;
    int64_t photons, beams, deposits;
    int64_t overflow, nonfinite; /* values that 64 bits do not hold, or that are no numbers */
} NphTpmLedger;

/* One block of photons: number `block` of a kind in a generation. partial: the generation's cache of that kind,
 * [cell][NPH_TPM_VALUES], to which it adds; scratch: NphTpmKernels.trace_bytes. */
typedef struct NphTpmBlock {
    uint32_t sample, generation;
    int kind;
    int64_t first;
    int count;
    double relative; /* NphTpmGeneration */
    int64_t *partial;
    void *scratch;
    NphTpmLedger *ledger;
    NphTally *tally;
} NphTpmBlock;

/* The kernels of one precision. Memory is the caller's; grids are arrays of the precision's numbers. */
typedef struct NphTpmKernels {
    size_t (*scene_bytes)(int noise);
    size_t (*trace_bytes)(int64_t cells, int shared);
    void (*prepare)(const NphJob *job, const NphTpmChoice *choice, void *scene);
    /* A scene whose deposits and cells are in the units of another one's. */
    void (*adopt)(void *scene, const void *reference);
    void (*trace)(const void *scene, const NphTpmBlock *block);
    /* sums [kind][cell][NPH_TPM_VALUES] of photons[kind] photons, the sum of shares -> coarse [cell][NPH_TPM_FIELDS] */
    void (*resolve)(const void *scene, const int64_t *sums, const double photons[NPH_TPM_KINDS], void *coarse);
    /* What lies in the coarse cells [first, end) of J: fine [cell][NPH_TPM_FIELDS] */
    void (*upsample)(const void *scene, const void *guide, const uint8_t *seen, const void *coarse, int64_t first, int64_t end, void *fine);
    /* What upsampling is guided by, planes [first, end) of fine cells: the density over its maximum; then, from all of it, whether any is near. */
    void (*guide)(const void *scene, int first, int end, void *guide);
    void (*guide_seen)(const void *scene, const void *guide, int first, int end, uint8_t *seen);
    /* Rows [first, end) of the small picture [pixel][NPH_SAMPLE_FIELDS]; steps: how many there were. */
    void (*march)(const void *scene, const void *fine, uint32_t sample, int first, int end, void *picture, int64_t *steps);
    void (*replay)(const void *scene, const void *fine, uint32_t sample, const int pixel[2], NphLineFn line, void *user);
    /* Rows [first, end) of a crop's image [field][pixel]; view: the scene of the frame, which may show the picture of an earlier one's */
    void (*enlarge)(const void *scene, const void *view, const void *picture, const int crop[4], int first, int end, void *image);
    void (*facts)(const void *scene, const NphTpmChoice *choice, NphFactFn fact, void *user);
} NphTpmKernels;
void nph_tpm_kernels(int precision, NphIsa isa, NphTpmKernels *kernels);

/* What is marched for a crop: pixels [origin, origin + size) of the small picture, or of the sensor's. Pixels of the small picture
 * cover two by two of the whole image, whatever the crop, and a border of one more is there to interpolate. Impostors are whole. */
void nph_tpm_small(const NphJob *job, int origin[2], int size[2]);

#endif
